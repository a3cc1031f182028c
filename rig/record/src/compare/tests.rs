//! What is a change, and which changes are worse.

use super::*;
use crate::{ClaimRecord, GuardBand, InstrumentRecord, MeasurementRecord, Parameter, Provenance};

fn claim(name: &str, margin: f64, uncertainty: f64) -> ClaimRecord {
    ClaimRecord {
        name: name.into(),
        verdict: Verdict::Pass,
        margin: Some(Figure::new(margin, "ns")),
        uncertainty: Some(Figure::new(uncertainty, "ns")),
        ..ClaimRecord::default()
    }
}

fn case(name: &str, verdict: Verdict) -> CaseRecord {
    CaseRecord { name: name.into(), verdict, ..CaseRecord::default() }
}

fn run(cases: impl IntoIterator<Item = CaseRecord>) -> RunRecord {
    let mut run = RunRecord::new("0.1.0", Provenance { seed: 1, ..Provenance::default() });
    cases.into_iter().for_each(|case| run.push(case));
    run
}

fn compared(old: &RunRecord, new: &RunRecord) -> Comparison {
    compare(old, new, &Thresholds::default())
}

#[test]
fn a_run_is_the_same_as_itself() {
    let mut one = case("a", Verdict::Pass);
    one.claims = vec![claim("x", 5.0, 0.0), claim("x", 7.0, 0.0)];
    let run = run([one, CaseRecord::skipped("b", "")]);
    let found = compared(&run, &run);
    assert!(!found.worse && found.cases.is_empty() && found.claims.is_empty() && found.eroded.is_empty());
    assert_eq!(found.same, 2);
}

#[test]
fn every_change_of_a_verdict_is_better_or_worse() {
    use Verdict::*;
    // From best to worst; what was not judged is no evidence.
    let order: Vec<fn(&str) -> CaseRecord> = vec![
        |name| case(name, Pass),
        |name| CaseRecord::not_applicable(name, "no wire"),
        |name| case(name, Inconclusive),
        |name| case(name, Fail),
        |name| case(name, Error),
    ];
    for (was, old) in order.iter().enumerate() {
        for (is, new) in order.iter().enumerate() {
            let found = compared(&run([old("a")]), &run([new("a")]));
            assert_eq!(found.worse, is > was, "{found:?}");
            assert_eq!(found.cases.len(), usize::from(was != is));
        }
    }
}

#[test]
fn evidence_that_is_lost_is_worse() {
    let old = run([case("a", Verdict::Pass), case("b", Verdict::Pass), CaseRecord::skipped("c", "")]);
    let found = compared(&old, &run([case("a", Verdict::Pass), case("d", Verdict::Pass)]));
    let names: Vec<(&str, bool)> = found.cases.iter().map(|case| (case.name.as_str(), case.worse)).collect();
    assert_eq!(names, [("b", true), ("c", false), ("d", false)]);
    assert!(found.worse);
    let allowed = Thresholds { allow_missing: true, ..Thresholds::default() };
    assert!(!compare(&old, &run([case("a", Verdict::Pass)]), &allowed).worse);
    assert!(compared(&old, &run([old.cases.clone(), vec![case("d", Verdict::Fail)]].concat())).worse);
    // A claim that went away from a case that still passes.
    let mut with = case("a", Verdict::Pass);
    with.claims = vec![claim("x", 1.0, 0.0), claim("x", 2.0, 0.0)];
    let mut without = with.clone();
    without.claims.pop();
    let found = compared(&run([with.clone()]), &run([without.clone()]));
    assert!(found.worse && found.claims[0].missing && found.claims[0].name == "x");
    assert!(!compared(&run([without]), &run([with])).worse);
}

#[test]
fn a_margin_erodes_beyond_the_threshold_and_what_is_not_known() {
    let with = |margin: f64, uncertainty: f64, verdict: Verdict| {
        let mut one = case("a", verdict);
        one.claims = vec![ClaimRecord { verdict, ..claim("x", margin, uncertainty) }];
        run([one])
    };
    let pass = |margin, uncertainty| with(margin, uncertainty, Verdict::Pass);
    let eroded = |old: &RunRecord, new: &RunRecord| compared(old, new).eroded;
    assert!(eroded(&pass(100.0, 0.0), &pass(90.0, 0.0)).is_empty());
    let found = eroded(&pass(100.0, 0.0), &pass(89.0, 0.0));
    assert_eq!((found[0].lost_percent, &found[0].new), (11.0, &Figure::new(89.0, "ns")));
    assert!(eroded(&pass(89.0, 0.0), &pass(100.0, 0.0)).is_empty());
    // Between two placements of an event nothing is known.
    assert!(eroded(&pass(100.0, 0.0), &pass(80.0, 25.0)).is_empty());
    // A claim that fails now is a change of its verdict.
    let failed = compared(&pass(100.0, 0.0), &with(-5.0, 0.0, Verdict::Fail));
    assert!(failed.eroded.is_empty() && failed.worse);
}

#[test]
fn values_move_when_they_cannot_be_one() {
    let with = |low: f64, high: f64| {
        let mut one = case("a", Verdict::Pass);
        let value = Some([low, high]);
        one.measurements =
            vec![MeasurementRecord { name: "m".into(), value, ..MeasurementRecord::default() }];
        run([one])
    };
    assert!(compared(&with(1.0, 2.0), &with(2.0, 3.0)).moved.is_empty());
    let found = compared(&with(1.0, 2.0), &with(2.5, 3.0));
    assert_eq!((found.moved[0].old, found.moved[0].new), ([1.0, 2.0], [2.5, 3.0]));
    assert!(!found.worse);
}

#[test]
fn a_pass_that_is_no_longer_proven_is_worse() {
    let with = |guard_band: GuardBand, by_middle: bool, margin: f64, verdict: Verdict| {
        let mut one = case("a", verdict);
        let margin = Some(Figure::new(margin, "ns"));
        let name = "m".into();
        let taken = MeasurementRecord {
            name,
            guard_band,
            by_middle,
            margin,
            verdict,
            ..MeasurementRecord::default()
        };
        one.measurements = vec![taken];
        run([one])
    };
    let pass = |guard_band, by_middle| with(guard_band, by_middle, 10.0, Verdict::Pass);
    let proven = pass(GuardBand::Uncertainty, false);
    let found = compared(&proven, &pass(GuardBand::None, true));
    assert!(found.worse && found.guards[0].worse, "{found:?}");
    assert_eq!((found.guards[0].old, found.guards[0].new), ("uncertainty", "none, by its middle"));
    // Its whole interval lies inside the limits: that is proven still.
    let found = compared(&proven, &pass(GuardBand::None, false));
    assert!(!found.worse && found.guards.len() == 1);
    // Whoever asked for no guard band accepted it before.
    let found = compared(&pass(GuardBand::None, false), &pass(GuardBand::None, true));
    assert!(!found.worse && found.guards.len() == 1);
    // The margin of a middle is another figure than that of the interval.
    let found =
        compared(&pass(GuardBand::None, false), &with(GuardBand::Uncertainty, false, 1.0, Verdict::Pass));
    assert!(!found.worse && found.eroded.is_empty());
    assert!(compared(&proven, &proven).guards.is_empty());
}

#[test]
fn what_the_runs_were_made_from_is_compared() {
    let mut old = run([case("a", Verdict::Pass)]);
    old.provenance.binary_sha256 = "b".repeat(64);
    old.cases[0].plan = "a.toml".into();
    old.cases[0].hashes.plan = "1".repeat(64);
    old.cases[0].trace_sha256 = "x".into();
    let mut new = old.clone();
    new.cases[0].trace_sha256 = "y".into();
    // The same files, seed and build, and another trace: the controller or the rig is not deterministic.
    assert_eq!(compared(&old, &new).traces, ["a"]);
    // Two captures that were judged, or one by two statements of its instrument: that is why.
    let mut capture = new.clone();
    capture.cases[0].hashes.capture = "c".repeat(64);
    let found = compared(&old, &capture);
    assert_eq!((found.traces.len(), found.files[0].what.as_str()), (0, "capture of a.toml"));
    // By one that is laid out otherwise.
    let mut laid = [old.clone(), new.clone()];
    laid.iter_mut().for_each(|run| run.cases[0].hashes.capture = "c".repeat(64));
    assert_eq!(compared(&laid[0], &laid[1]).traces, ["a"]);
    laid[1].provenance.arguments = vec!["--start".into(), "1 s".into()];
    assert!(compared(&laid[0], &laid[1]).traces.is_empty());
    let mut instrument = new.clone();
    instrument.cases[0].instrument =
        Some(InstrumentRecord { sha256: "1".repeat(64), ..InstrumentRecord::default() });
    let found = compared(&old, &instrument);
    assert_eq!((found.traces.len(), found.files[0].what.as_str()), (0, "instrument of a.toml"));
    let mut given = new.clone();
    given.cases[0].parameters = vec![Parameter { name: "delay".into(), value: "1 s".into() }];
    assert!(compared(&old, &given).traces.is_empty());
    new.cases[0].hashes.program = "2".repeat(64);
    new.provenance.seed = 2;
    let found = compared(&old, &new);
    assert!(found.traces.is_empty() && !found.worse);
    assert_eq!(found.files[0].what, "program of a.toml");
    assert_eq!(found.facts, [TextChange { what: "seed".into(), old: "1".into(), new: "2".into() }]);
}
