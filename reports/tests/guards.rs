//! A pass without a guard band is nowhere shown as a proven one.

use record::{CaseRecord, CaseStatus, GuardBand, MeasurementRecord, RunRecord, Verdict};
use scanrig_reports::{csv, ctrf, junit, markdown, text};

/// What the judge says of such a verdict.
const BY_MIDDLE: &str = "accepted by its middle: a limit lies within the uncertainty";

fn run(guard_band: GuardBand) -> RunRecord {
    let measured = MeasurementRecord {
        name: "latency".into(),
        value: Some([4_000.0, 8_000.0]),
        unit: "ns".into(),
        min: Some(0.0),
        max: Some(7_000.0),
        guard_band,
        by_middle: guard_band == GuardBand::None,
        reason: match guard_band {
            GuardBand::None => BY_MIDDLE.into(),
            GuardBand::Uncertainty => String::new(),
        },
        verdict: Verdict::Pass,
        margin: Some(record::Figure::new(1_000.0, "ns")),
        ..MeasurementRecord::default()
    };
    let case = CaseRecord {
        name: "fast".into(),
        status: CaseStatus::Judged,
        verdict: Verdict::Pass,
        measurements: vec![measured],
        ..CaseRecord::default()
    };
    RunRecord { cases: vec![case], ..RunRecord::default() }
}

#[test]
fn every_report_says_that_a_limit_has_no_guard_band() {
    let style = text::Style::default();
    let forms = |run: &RunRecord| {
        [
            text::numbered_line(&run.cases[0], 1, 1, style),
            text::summary(run, style),
            junit::render(run, "out"),
            markdown::render(run),
            ctrf::render(run),
            csv::measurements(run),
        ]
    };
    let (unguarded, guarded) = (forms(&run(GuardBand::None)), forms(&run(GuardBand::Uncertainty)));
    for (form, word) in unguarded.iter().zip([
        "fast (guard none, by its middle)",
        "1 case measured without a guard band, 1 of them decided by a middle",
        "(limits 0 s .. 7 us, guard none; accepted by its middle: ",
        "4 us .. 8 us, guard none",
        "\"guard\":\"none\"",
        ",none,",
    ]) {
        assert!(form.replace("\": \"", "\":\"").contains(word), "{word} in {form}");
    }
    for form in guarded {
        assert!(!form.contains("guard none") && !form.contains("guard band"), "{form}");
    }
}

#[test]
fn every_report_says_that_a_middle_alone_decided() {
    let run = run(GuardBand::None);
    let forms =
        [junit::render(&run, "out"), markdown::render(&run), ctrf::render(&run), csv::measurements(&run)];
    for form in &forms {
        assert!(form.contains(BY_MIDDLE), "{form}");
    }
    for form in &forms[..3] {
        assert!(
            form.contains("1 case measured without a guard band, 1 of them decided by a middle"),
            "{form}"
        );
    }
    // Where it failed, too.
    let mut failed = run;
    let case = &mut failed.cases[0];
    case.verdict = Verdict::Fail;
    case.measurements[0].verdict = Verdict::Fail;
    case.measurements[0].reason = "too large by its middle".into();
    for form in [junit::render(&failed, "out"), markdown::render(&failed), ctrf::render(&failed)] {
        assert!(form.contains("too large by its middle"), "{form}");
    }
    assert!(!markdown::render(&failed).contains("Accepted and not proven"));
}
