//! Cases that are to be refused: they pass by what their check finds, and fail by everything else.

use crate::texts::Texts;
use record::Verdict;
use scanrig_runtime::case::jobs::JobResult;
use scanrig_runtime::{ClockKind, RunOptions};
use std::sync::atomic::AtomicBool;

fn verdict(signal: &str, refused: &str) -> (Verdict, String) {
    let plan = format!(
        "format = 1\nprogram-text = \"PROGRAM MAIN END_PROGRAM\"\nsignals = {{ word = \"{signal}\" }}\nrefused = {refused}\n"
    );
    let interrupt = AtomicBool::new(false);
    let options = RunOptions::new(ClockKind::Virtual, &interrupt);
    let JobResult::Case(result) = Texts(&[("plan.toml", &plan)]).done(1, &options) else {
        panic!("findings")
    };
    assert!(result.trace.is_none() && result.record.claims.len() == 1, "{:#?}", result.record);
    (result.record.verdict, result.record.reason)
}

#[test]
fn the_right_error_passes_and_nothing_else() {
    let right = "{ code = \"R0112\", says = \"%MW59999\", errors = 1 }";
    assert_eq!(verdict("%MW60000", right), (Verdict::Pass, String::new()));
    let fails = |signal, refused, words: &str| {
        let (verdict, reason) = verdict(signal, refused);
        assert!(verdict == Verdict::Fail && reason.contains(words), "{verdict:?}: {reason}");
    };
    fails("%MW59999", right, "nothing is refused");
    fails("%MW60000", "{ code = \"R0113\" }", "refused otherwise: R0112");
    fails("%MW60000", "{ code = \"R0112\", says = \"%MW1\" }", "no finding says `%MW1`");
    fails("%MW60000", "{ code = \"R0112\", errors = 2 }", "1 findings in place of 2");
}
