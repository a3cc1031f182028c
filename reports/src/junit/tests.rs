//! What happens to a file that grows too large. The forms are goldens in `tests/golden.rs`.

use super::*;
use record::Provenance;

fn run(cases: usize, verdict: Verdict) -> RunRecord {
    let mut run = RunRecord::new("0.1.0", Provenance::default());
    for number in 0..cases {
        run.push(CaseRecord {
            name: format!("folder/plan[{}{number:04}]", "a long row ".repeat(30)),
            verdict,
            reason: "because ".repeat(100),
            ..CaseRecord::default()
        });
    }
    run
}

fn count(text: &str, part: &str) -> usize {
    text.matches(part).count()
}

#[test]
fn details_go_before_cases_do() {
    let run = run(100, Verdict::Fail);
    let full = render(&run, "");
    let (some, few) = (full.len() * 3 / 4, full.len() / 4);
    for most in [full.len() + TAIL, some, few] {
        let text = render_within(&run, "", most);
        assert!(text.len() <= most, "{} of {most}", text.len());
        assert_eq!(count(&text, "<testcase "), 100);
        assert_eq!(count(&text, "<failure "), 100);
        assert!(text.contains("tests=\"100\" failures=\"100\""), "{}", &text[..200]);
    }
    assert!(render_within(&run, "", some).contains("bytes more: see record.json]"));
    // Names without their middle are as different as before.
    let short = render_within(&run, "", few);
    let names: BTreeSet<&str> =
        short.split("<testcase name=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
    assert_eq!(names.len(), 100);
    assert!(names.iter().all(|name| name.len() < 200));
}

#[test]
fn cases_without_room_are_said_and_not_green() {
    for (verdict, element) in [(Verdict::Fail, "<error type=\"left-out\""), (Verdict::Pass, "<skipped>")] {
        let run = run(100, verdict);
        let text = render_within(&run, "", 12_000);
        assert!(text.len() <= 12_000);
        let written = count(&text, "<testcase ");
        assert!((2..100).contains(&written), "{written}");
        assert!(text.contains(element), "{text}");
        assert!(text.contains(&format!("{} cases are left out", 101 - written)), "{text}");
    }
}
