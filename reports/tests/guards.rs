//! A pass without a guard band is nowhere shown as a proven one.

use record::{CaseRecord, CaseStatus, GuardBand, MeasurementRecord, RunRecord, Verdict};
use scanrig_reports::{csv, ctrf, junit, markdown, text};

fn run(guard_band: GuardBand) -> RunRecord {
    let measured = MeasurementRecord {
        name: "latency".into(),
        value: Some([4_000.0, 8_000.0]),
        unit: "ns".into(),
        min: Some(0.0),
        max: Some(7_000.0),
        guard_band,
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
        "fast (guard none)",
        "1 case measured without a guard band",
        "(limits 0 s .. 7 us, guard none)",
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
