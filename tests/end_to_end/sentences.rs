//! Seven sentences that test engineers write, each a plan that ships with the rig: its program passes, and one with a
//! slip of the kind that the sentence is about is noticed by the claim that says so.

use record::Verdict;

use crate::plan_folder::PlanFolder;
use crate::project_folder::root;

/// A plan, a slip in its program, and the claim that it breaks.
struct SentenceCase {
    plan: &'static str,
    program: &'static str,
    /// What stands in the program, and what the slip makes of it.
    slip: (&'static str, &'static str),
    claim: &'static str,
}

/// Turns of a case that are enough to notice a slip; all of them run with the library.
const TURNS: u32 = 3;

const SENTENCES: &[SentenceCase] = &[
    SentenceCase {
        plan: "bus-lost.toml",
        program: "bus-lost.st",
        slip: ("PT := T#1s500ms", "PT := T#2s"),
        claim: "off within 2 s of losing the bus",
    },
    SentenceCase {
        plan: "bus-lost.toml",
        program: "bus-lost.st",
        slip: ("ELSIF pressed.Q AND alive THEN", "ELSIF alive THEN"),
        claim: "off for 10 s",
    },
    SentenceCase {
        plan: "retries.toml",
        program: "retries.st",
        slip: ("RETRIES : INT := 3;", "RETRIES : INT := 2;"),
        claim: "once and three retries",
    },
    SentenceCase {
        plan: "retries.toml",
        program: "retries.st",
        slip: ("PT := T#500ms", "PT := T#530ms"),
        claim: "500 ± 20 ms apart",
    },
    SentenceCase {
        plan: "retries.toml",
        program: "retries.st",
        slip: (
            "        busy := FALSE;\n        alarm := TRUE;",
            "        alarm := TRUE;\n        command(IN := TRUE);",
        ),
        claim: "and no further attempt",
    },
    SentenceCase {
        plan: "contactors.toml",
        program: "contactors.st",
        slip: ("fast := now = 2;", "fast := fast_button;"),
        claim: "no two contactors on together",
    },
    SentenceCase {
        plan: "counter.toml",
        program: "counter.st",
        slip: ("IF pulses AND NOT before THEN", "IF pulses THEN"),
        claim: "the counter equals the pulses sent",
    },
    SentenceCase {
        plan: "power-loss.toml",
        program: "power-loss.st",
        slip: ("1: flours[1 - in_use] := 600;", "1: flours[in_use] := 600;"),
        claim: "salt goes with the flour",
    },
    SentenceCase {
        plan: "power-loss.toml",
        program: "power-loss.st",
        slip: (
            "3: yeasts[1 - in_use] := 24; stage := 4;",
            "3: in_use := 1 - in_use; stage := 5;\n    5: yeasts[in_use] := 24; stage := 0;",
        ),
        claim: "yeast goes with the flour",
    },
    SentenceCase {
        plan: "settling.toml",
        program: "settling.st",
        slip: (
            "END_VAR\nmotor := go AND NOT fast_enough;",
            "late : TON;\nEND_VAR\nlate(IN := fast_enough, PT := T#120ms);\nmotor := go AND NOT late.Q;",
        ),
        claim: "settles in 3 s with under 5 % overshoot",
    },
    SentenceCase {
        plan: "watchdog.toml",
        program: "watchdog.toml",
        slip: ("watchdog = \"100 ms\"", "watchdog = \"106 ms\""),
        claim: "it trips between 95 and 105 ms",
    },
];

fn folder() -> std::path::PathBuf {
    root().join("plans/library/sentences")
}

#[test]
fn every_sentence_passes_and_its_slip_is_noticed() {
    for SentenceCase { plan, program, slip, claim } in SENTENCES {
        let (from, to) = *slip;
        let broken = PlanFolder { path: folder(), changed: Some((program, from, to)) }.run(plan, TURNS);
        let failed: Vec<&str> = broken
            .iter()
            .flat_map(|case| &case.claims)
            .filter(|judged| judged.verdict == Verdict::Fail)
            .map(|judged| judged.name.as_str())
            .collect();
        assert!(failed.contains(claim), "{plan} with `{to}`: `{claim}` is not among {failed:?}");
    }
    let plans: std::collections::BTreeSet<&str> = SENTENCES.iter().map(|sentence| sentence.plan).collect();
    for plan in &plans {
        for case in (PlanFolder { path: folder(), changed: None }).run(plan, TURNS) {
            assert_eq!(case.verdict, Verdict::Pass, "{}: {}", case.name, case.reason);
        }
    }
    let shipped = std::fs::read_dir(folder()).unwrap().map(|file| file.unwrap().file_name());
    let shipped = shipped.filter(|name| {
        let name = name.to_string_lossy();
        name.ends_with(".toml") && !name.ends_with("-board.toml")
    });
    assert_eq!(shipped.count(), plans.len(), "a sentence without a slip");
    assert_eq!(plans.len(), 7);
}
