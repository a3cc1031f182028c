//! The record survives JSON unchanged, and no text makes the reader panic.

use proptest::prelude::*;
use scanrig_record::*;
use signal::{SignalInfo, Time, Value, ValueKind, When};

fn sample() -> RunRecord {
    let provenance = Provenance { seed: u64::MAX, kernel: "6.12.0".into(), ..Provenance::default() };
    let mut run = RunRecord::new("0.1.0", provenance);
    let mut lane = Lane::of(&SignalInfo::exact("lamp", ValueKind::Bool));
    for (at, value) in
        [(0, Value::Unknown), (10, Value::Bool(true)), (20, Value::HighZ), (30, Value::Real(0.1))]
    {
        lane.push(When::within(Time::from_nanos(at), Time::from_nanos(at + 2)), value);
    }
    let mut case = CaseRecord { name: "watchdog/fallback[over]".into(), ..CaseRecord::default() };
    case.verdict = Verdict::Fail;
    case.profile = "m241-2019".into();
    case.lanes.push(lane);
    case.claims.push(ClaimRecord {
        name: "lamp falls".into(),
        margin: Some(Figure::new(-0.1, "ms")),
        uncertainty: Some(Figure::new(f64::INFINITY, "")),
        window: Some(Window { from_ns: [1, 2], until_ns: [i64::MIN, i64::MAX], ..Window::default() }),
        deciding_ns: Some([5, 5]),
        ..ClaimRecord::default()
    });
    case.measurements.push(MeasurementRecord {
        name: "latency".into(),
        value: Some([0.1, 1.0 / 3.0]),
        max: Some(f64::INFINITY),
        ..MeasurementRecord::default()
    });
    case.log_line(7, "booted \u{1b}[31m<b>");
    run.push(case);
    run.push(CaseRecord::not_applicable("watchdog/pulse", "no channel reaches 200 kHz"));
    run.push(CaseRecord::skipped("watchdog/late", "not selected"));
    run.coverage.push(FileCoverage {
        file: "lamp.st".into(),
        statements: 3,
        statements_run: 2,
        lines_missed: vec![[7, 9]],
        ..FileCoverage::default()
    });
    run
}

#[test]
fn a_record_reads_back_and_writes_the_same_bytes() {
    let run = sample();
    let text = run.to_json();
    let back = RunRecord::from_json(&text).unwrap();
    assert_eq!(back, run);
    assert_eq!(back.to_json(), text);
    assert_eq!(run.totals, Totals { failed: 1, not_applicable: 1, skipped: 1, ..Totals::default() });
    assert_eq!(run.verdict(), Verdict::Fail);
    assert_eq!(run.provenance.profiles, ["m241-2019"]);
}

#[test]
fn what_cannot_be_trusted_is_refused() {
    let text = sample().to_json();
    let code = |text: &str| RunRecord::from_json(text).unwrap_err().code();
    assert_eq!(code("{\n \"format\": 1,\n"), "R0402");
    assert_eq!(code("{\"format\": 2}"), "R0403");
    assert_eq!(code("{\"format\": 3}"), "R0404");
    assert_eq!(code("[]"), "R0403");
    assert_eq!(code(&text.replace("watchdog/late", "watchdog/pulse")), "R0406");
    // A failure edited away leaves totals that do not add up.
    assert_eq!(code(&text.replacen("\"verdict\":\"fail\"", "\"verdict\":\"pass\"", 1)), "R0407");
    let mut run = sample();
    run.cases[0].claims[0].deciding_ns = Some([6, 5]);
    assert_eq!(code(&run.to_json()), "R0408");
    let point = run.cases[0].lanes[0].points[0];
    run.cases[0].claims.clear();
    run.cases[0].lanes[0].points = vec![point; MAX_LANE_POINTS + 1];
    assert_eq!(code(&run.to_json()), "R0405");
    run.cases.clear();
    run.totals = Totals::default();
    run.coverage[0].lines_missed = vec![[9, 7]];
    assert_eq!(code(&run.to_json()), "R0409");
    run.coverage[0] = FileCoverage { statements_run: 1, ..FileCoverage::default() };
    assert_eq!(code(&run.to_json()), "R0409");
    run.coverage[0] =
        FileCoverage { statements: 2, statements_at: vec![(1, true)], ..FileCoverage::default() };
    assert_eq!(code(&run.to_json()), "R0409");
    run.coverage.clear();
    run.shard = Some([3, 2]);
    assert_eq!(code(&run.to_json()), "R0411");
}

/// What the first version of this crate wrote of [`sample`] but for its shape of JSON: every field, points of three.
#[test]
fn a_record_of_format_1_reads_as_it_did() {
    let text = r#"{ "format": 1, "rig_version": "0.1.0", "provenance": {
        "binary_sha256": "", "kernel": "6.12.0", "host_cpu": null, "profiles": ["m241-2019"], "seed": 7,
        "clock": "virtual", "arguments": [], "started": null },
      "totals": { "passed": 0, "none": 1, "inconclusive": 0, "failed": 0, "errors": 0, "not_applicable": 0,
        "skipped": 0 },
      "cases": [ { "name": "a", "plan": "", "row": null, "parameters": [], "title": "", "status": { "is": "judged" },
        "verdict": "none", "reason": "", "proves": [], "profile": "m241-2019", "reference": "",
        "hashes": { "plan": "", "board": "", "program": "" }, "seed": 0, "start_ns": 0, "end_ns": 0,
        "duration_ns": 0, "host_ms": 0, "trace_sha256": "", "trace_file": null, "claims": [], "measurements": [],
        "steps": [], "timing": { "late_max_ns": 0, "overruns": 0, "dropped": 0, "horizon_ns": 0 }, "tasks": [],
        "log": [], "log_dropped": 0, "lanes": [ { "signal": "lamp", "kind": "digital", "unit": "", "labels": [],
          "points": [[0, 0, "x"], [10, 12, 1]], "truncated": false, "until_ns": null } ] } ] }"#;
    let run = RunRecord::from_json(text).unwrap();
    let point = |at, value| LanePoint { at, value };
    let points = [point([0, 0], LaneValue::Unknown), point([10, 12], LaneValue::Number(1.0))];
    assert_eq!(run.cases[0].lanes[0].points, points);
    let compact = run.to_json();
    assert!(compact.contains(r#""points":[[0,"x"],[10,12,1]]"#), "{compact}");
    assert_eq!(RunRecord::from_json(&compact).unwrap(), run);
}

#[test]
fn every_case_has_a_line() {
    let text = sample().to_json();
    let lines: Vec<&str> = text.lines().filter(|line| line.starts_with("{\"name\":")).collect();
    assert_eq!(lines.len(), 3, "{text}");
}

#[test]
fn a_record_without_coverage_does_not_speak_of_it() {
    let text = RunRecord { coverage: Vec::new(), ..sample() }.to_json();
    assert!(!text.contains("coverage"));
    assert!(RunRecord::from_json(&text).unwrap().coverage.is_empty());
}

#[test]
fn an_unknown_number_is_never_written_as_a_number() {
    let mut lane = Lane::of(&SignalInfo::exact("level", ValueKind::Real));
    lane.push(When::exactly(Time::ZERO), Value::Real(f64::NAN));
    assert_eq!(lane.points[0].value, LaneValue::Unknown);
}

#[test]
fn folders_group_by_plan_and_not_by_row() {
    let folder = |name: &str| CaseRecord { name: name.into(), ..CaseRecord::default() }.folder().to_owned();
    assert_eq!(folder("watchdog/fallback[over]"), "watchdog");
    assert_eq!(folder("a/b/c[x/y]"), "a/b");
    assert_eq!(folder("alone"), "");
    assert_eq!(folder("[/]"), "");
}

#[test]
fn the_log_is_bounded() {
    let mut case = CaseRecord::default();
    for at in 0..MAX_LOG_LINES as i64 + 3 {
        case.log_line(at, "x");
    }
    assert_eq!((case.log.len(), case.log_dropped), (MAX_LOG_LINES, 3));
}

proptest! {
    #[test]
    fn no_mutation_panics(at in any::<prop::sample::Index>(), with in "\\PC{0,3}", cut in 0usize..4) {
        let text = sample().to_json();
        let chars: Vec<char> = text.chars().collect();
        let at = at.index(chars.len());
        let end = (at + cut).min(chars.len());
        let mutated: String = chars[..at].iter().copied().chain(with.chars()).chain(chars[end..].iter().copied()).collect();
        let _ = RunRecord::from_json(&mutated);
    }

    #[test]
    fn numbers_survive_to_the_last_bit(low in any::<f64>(), high in any::<f64>()) {
        let mut run = sample();
        run.cases[0].measurements[0].value = Some([low, high]);
        let back = RunRecord::from_json(&run.to_json()).unwrap();
        let [l, h] = back.cases[0].measurements[0].value.unwrap();
        let same = |a: f64, b: f64| a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan());
        prop_assert!(same(l, low) && same(h, high));
    }
}

#[test]
fn what_an_instrument_states_and_a_value_covers_reads_back() {
    let mut run = sample();
    run.cases[0].measurements[0].coverage = "95 %".into();
    let statement =
        InstrumentStatement { of: "timebase".into(), key: "error".into(), value: "25 ppm".into() };
    run.cases[0].instrument = Some(InstrumentRecord {
        file: "scope.toml".into(),
        title: String::new(),
        sha256: "ab".repeat(32),
        statements: vec![statement],
    });
    let text = run.to_json();
    assert!(text.contains(r#""statements":[{"of":"timebase","key":"error","value":"25 ppm"}]"#), "{text}");
    assert_eq!(RunRecord::from_json(&text).unwrap(), run);
    // A record of a rig that did not say what an interval covers.
    assert_eq!(RunRecord::from_json(&sample().to_json()).unwrap().cases[0].measurements[0].coverage, "");
}
