//! `clock-error` of a board file: of every time between two instants that its clock stamped a part may be wrong, the same for all.

use crate::common::events;
use crate::texts::Texts;
use record::{CaseRecord, Verdict};
use scanrig_runtime::case::rejudge;
use scanrig_runtime::{CaseResult, ClockKind, RunOptions};
use signal::{LoadLimits, Trace};
use std::sync::atomic::AtomicBool;

const PROGRAM: &str =
    "PROGRAM MAIN VAR button AT %IX0.0 : BOOL; lamp AT %QX0.4 : BOOL; END_VAR lamp := button; END_PROGRAM";

const HEAD: &str = "format = 1
program = \"p.st\"
board = \"board.toml\"
signals = { button = \"%IX0.0\", lamp = \"%QX0.4\" }
";

fn run(clock: &str, plan: &str) -> Box<CaseResult> {
    let plan = format!("{HEAD}{plan}");
    let board = format!("format = 1\ntitle = \"A bench\"\n[board]\nkind = \"simulated\"\n{clock}\n");
    let interrupt = AtomicBool::new(false);
    let options = RunOptions { fail_fast: true, ..RunOptions::new(ClockKind::Virtual, &interrupt) };
    let texts = [("plan.toml", &*plan), ("p.st", PROGRAM), ("board.toml", &*board)];
    let result = Texts(&texts).run(1, &options);
    let mut bytes = Vec::new();
    result.trace.as_ref().unwrap().save(&mut bytes).unwrap();
    let loaded = Trace::load(&mut bytes.as_slice(), LoadLimits::default()).unwrap();
    let again = rejudge::judge(&document::SourceFile::new("plan.toml", plan), &loaded).unwrap();
    let record = &result.record;
    assert_eq!((&again.claims, &again.measurements), (&record.claims, &record.measurements));
    assert_eq!(again.instrument, record.instrument);
    result
}

/// The lamp follows the button, which is pressed 10 s after the start, within a cycle.
fn pressed(claims: &str) -> String {
    format!(
        "steps = [{{ id = \"press\", at = \"start + 10 s\", set = {{ signal = \"button\", value = true }} }}]
ends = \"start + 12 s\"
{claims}
"
    )
}

fn verdicts(record: &CaseRecord) -> Vec<Verdict> {
    record.claims.iter().map(|claim| claim.verdict).collect()
}

#[test]
fn a_measured_time_is_known_to_within_the_error_of_the_clock() {
    let plan = pressed(
        "measure = [{ name = \"lit\", from = \"start\", to = { signal = \"lamp\", edge = \"rises\" }, max = \"10.1 s\" }]",
    );
    let taken = |clock: &str| run(clock, &plan).record.measurements[0].clone();
    let exact = taken("").value.unwrap();
    assert!(exact[1] - exact[0] < 1.0, "{exact:?}");
    let known = taken("clock-error = \"100 ppm\"");
    // A clock that is fast by e shows 1 + e of each true second.
    let wanted = [exact[0] / (1.0 + 1e-4), exact[0] / (1.0 - 1e-4)];
    let [low, high] = known.value.unwrap();
    assert!((low - wanted[0]).abs() <= 1.0 && (high - wanted[1]).abs() <= 1.0, "{low} {high} {wanted:?}");
    assert_eq!((known.verdict, known.coverage.as_str()), (Verdict::Pass, "limits"));
    // 2 % of 10 s is more than is left to the limit.
    let known = taken("clock-error = \"2 %\"\nclock-coverage = \"95 %\"");
    assert_eq!((known.verdict, known.coverage.as_str()), (Verdict::Inconclusive, "95 %"));
}

#[test]
fn a_limit_that_the_clock_cannot_prove_is_open() {
    let plan = pressed(
        "expect = [
  { rises = { signal = \"lamp\", from = \"start\", within = \"10.015 s .. 10.5 s\" } },
  { rises = { signal = \"lamp\", from = \"start\", within = \"9.9 s .. 10.5 s\" } },
  { rises = { signal = \"lamp\", from = \"start\", within = \"1 s .. 9.9 s\" } },
]",
    );
    let (pass, fail, open) = (Verdict::Pass, Verdict::Fail, Verdict::Inconclusive);
    assert_eq!(verdicts(&run("", &plan.replace("1 s .. 9.9 s", "1 s .. 20 s")).record), [pass; 3]);
    // With --fail-fast the case ends when the third claim is lost, and not before.
    let found = run("clock-error = \"1000 ppm\"", &plan.replace("1 s .. 9.9 s", "1 s .. 20 s")).record;
    assert_eq!(verdicts(&found), [open, pass, pass], "{:#?}", found.claims);
    assert_eq!(verdicts(&run("clock-error = \"1000 ppm\"", &plan).record)[2], fail);
}

#[test]
fn what_has_no_limit_of_time_is_the_same_by_every_clock() {
    let plan = "steps = [{ id = \"press\", at = \"start + 1 s\", set = { signal = \"button\", value = true } }]
ends = \"start + 12 s\"
expect = [
  { stays = { signal = \"button\", is = true, from = \"press\", until = \"end\" } },
  { edges = { signal = \"lamp\", rising = 1, from = \"press\", until = \"end\" } },
  { order = { edges = [\"button rises\", \"lamp rises\"] } },
  { never = { signal = \"lamp\", is = true, from = \"start\", until = \"press\" } },
]
measure = [{ name = \"on\", value-of = \"lamp\", take = \"mean\", from = \"press + 100 ms\", until = \"end\", min = 1 }]
teardown = [{ id = \"release\", at = \"teardown\", set = { signal = \"button\", value = false } }]
";
    let (exact, off) = (run("", plan), run("clock-error = \"1 %\"", plan));
    assert_eq!(verdicts(&off.record), [Verdict::Pass; 4], "{:#?}", off.record.claims);
    assert_eq!(exact.record.claims, off.record.claims);
    assert_eq!(off.record.measurements[0].value, Some([1.0, 1.0]));
    // The trace has what the clock showed.
    assert_eq!(events(exact.trace.as_ref().unwrap()), events(off.trace.as_ref().unwrap()));
}

#[test]
fn short_times_are_known_as_well_late_in_a_case() {
    let plan = "steps = [
  { id = \"on\", at = \"start + 1000 s\", set = { signal = \"button\", value = true } },
  { id = \"off\", at = \"on + 100 ms\", set = { signal = \"button\", value = false } },
]
ends = \"off + 1 s\"
expect = [
  { rises = { signal = \"button\", from = \"on\", within = \"1 us\" } },
  { falls = { signal = \"button\", from = \"on\", within = \"99.99 ms .. 100.01 ms\" } },
  { falls = { signal = \"button\", from = \"on\", within = \"99.998 ms .. 100.002 ms\" } },
  { pulse = { signal = \"button\", width = \"99.99 ms .. 100.01 ms\" } },
  { pulse = { signal = \"button\", width = \"99.998 ms .. 100.002 ms\" } },
  { never = { signal = \"button\", from = \"on + 100.01 ms\", until = \"end\" } },
  { never = { signal = \"button\", from = \"on + 100.004 ms\", until = \"end\" } },
  { never = { signal = \"button\", from = \"on\", until = \"end\", pulses-longer-than = \"100.01 ms\" } },
  { never = { signal = \"button\", from = \"on\", until = \"end\", pulses-longer-than = \"100.004 ms\" } },
  { never = { signal = \"button\", from = \"on\", until = \"end\", pulses-longer-than = \"99 ms\" } },
]
";
    // 50 ppm of 100 ms are 5 us, of 1000 s 50 ms.
    let found = run("clock-error = \"50 ppm\"", plan).record;
    let (pass, fail, open) = (Verdict::Pass, Verdict::Fail, Verdict::Inconclusive);
    assert_eq!(
        verdicts(&found),
        [pass, pass, open, pass, open, pass, open, pass, open, fail],
        "{:#?}",
        found.claims
    );
}

#[test]
fn a_frequency_is_known_to_within_the_error_of_the_clock() {
    let plan = "steps = [{ id = \"wave\", at = \"start + 1 s\", square = { signal = \"button\", period = \"100 ms\", duration = \"20 s\" } }]
ends = \"start + 22 s\"
expect = [
  { frequency = { signal = \"button\", is = \"9.99 .. 10.01 Hz\", from = \"wave\", until = \"wave.done\" } },
  { frequency = { signal = \"button\", is = \"9.9999 .. 10.0001 Hz\", from = \"wave\", until = \"wave.done\" } },
  { period = { signal = \"button\", is = \"99.98 ms .. 100.02 ms\", from = \"wave\", until = \"wave.done\" } },
  { duty = { signal = \"button\", is = \"49.9999 .. 50.0001 %\", from = \"wave\", until = \"wave.done\" } },
]
measure = [{ name = \"f\", frequency-of = \"button\", from = \"wave\", until = \"wave.done\", min = \"9.9 Hz\" }]
";
    let found = run("clock-error = \"50 ppm\"", plan).record;
    let (pass, open) = (Verdict::Pass, Verdict::Inconclusive);
    assert_eq!(verdicts(&found), [pass, open, pass, pass], "{:#?}", found.claims);
    let [low, high] = found.measurements[0].value.unwrap();
    assert!((9.9994..=9.9995001).contains(&low) && (10.0005..10.0006).contains(&high), "{low} {high}");
}

#[test]
fn a_record_says_what_the_board_states_of_its_clock() {
    let plan = pressed("expect = [{ rises = { signal = \"lamp\" } }]");
    let record = run("clock-error = \"25 ppm\"\nclock-coverage = \"k = 2\"", &plan).record;
    let board = record.instrument.unwrap();
    let stated: Vec<String> =
        board.statements.iter().map(|one| format!("{} {} = {}", one.of, one.key, one.value)).collect();
    assert_eq!((board.file.as_str(), board.title.as_str()), ("board.toml", "A bench"));
    assert_eq!(stated, ["board clock-error = 25 ppm", "board clock-coverage = k = 2"]);
    assert_eq!(board.sha256, record.hashes.board);
    assert_eq!(run("", &plan).record.instrument, None);
}

#[test]
fn a_shape_is_not_held_against_a_clock_that_may_be_off() {
    let plan = pressed(
        "expect = [{ profile = { signal = \"lamp\", points = [{ at = \"0 ms\", frequency = \"1 Hz\" }], tolerance = \"50 %\" } }]",
    );
    assert_eq!(verdicts(&run("", &plan).record), [Verdict::Fail]);
    let found = run("clock-error = \"1 ppm\"", &plan).record;
    assert_eq!(verdicts(&found), [Verdict::Inconclusive]);
    assert!(found.claims[0].reason.contains("clock-error"), "{}", found.claims[0].reason);
}
