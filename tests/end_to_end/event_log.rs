//! `RUST_LOG`: what is logged goes to standard error, beside what a command prints.

use crate::project_folder::{CommandOutput, TestProject, run};

fn logged(filter: &str) -> CommandOutput {
    let bench = TestProject::new();
    bench.write_lamp("slow.toml", "500 ms .. 550 ms", "490 ms .. 510 ms");
    let mut command = bench.command(&["test", "slow.toml"]);
    command.env("RUST_LOG", filter);
    let ran = run(command);
    assert_eq!(ran.code, Some(1), "{}", ran.err);
    ran
}

#[test]
fn what_is_asked_for_is_logged_and_nothing_else() {
    let debug = logged("debug");
    for words in ["a file is read", "slow.toml", "a case begins", "a case is over", "verdict=fail"] {
        assert!(debug.err.contains(words), "`{words}` is missing in\n{}", debug.err);
    }
    assert!(!debug.out.contains("DEBUG"), "{}", debug.out);
    for filter in ["", "info", "scanrig_drivers=debug"] {
        let quiet = logged(filter);
        assert!(!quiet.err.contains("a case"), "{filter}: {}", quiet.err);
    }
}

#[test]
fn a_filter_that_is_none_is_a_warning_and_the_command_goes_on() {
    let err = logged("debgu").err;
    assert!(err.contains("warning[R0226]") && err.contains("`debgu`"), "{err}");
}
