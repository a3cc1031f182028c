//! Questions to a person: asked at a terminal, refused without one, judged again without asking.

use crate::project_folder::TestProject;
use crate::terminal::{talk, terminal};

/// The lamp, and somebody who says which colour it has.
fn asking() -> TestProject {
    let bench = TestProject::new();
    bench.write("door.png", "a picture");
    let part = "value = true } },\n";
    let ask = "ask = { text = \"Which colour?\", photo = \"door.png\", answers = [\"green\", \"red\"] }";
    let step = format!("{part}  {{ id = \"look\", at = \"press + 1 s\", {ask} }},\n");
    bench.write_lamp("ask.toml", part, &step);
    bench
}

#[test]
fn the_answer_of_a_person_decides() {
    let bench = asking();
    for (typed, code) in [(&["what", "green"][..], 0), (&["2"], 1)] {
        let (ended, screen) = talk(terminal(&bench, &["test", "ask.toml", "--report", "out"]), typed);
        assert_eq!(ended, Some(code), "{screen}");
        assert!(screen.contains("look: Which colour?") && screen.contains("door.png"), "{screen}");
        // The trace has the answer.
        let again = bench.expect(code, &["judge", "ask.toml", "out/traces/ask.trace"]);
        assert_eq!(again.out.contains("red"), code == 1, "{}", again.out);
    }
}

#[test]
fn nobody_is_asked_in_a_pipe_or_in_ci() {
    let bench = asking();
    bench.refused(&["test", "ask.toml"], &["R0140", "ask.toml"]);
    let mut ci = terminal(&bench, &["test", "ask.toml"]);
    ci.env("CI", "true");
    let (ended, screen) = talk(ci, &["green"]);
    assert!(ended == Some(2) && screen.contains("R0140") && !screen.contains("look: Which"), "{screen}");
}
