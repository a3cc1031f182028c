//! JUnit XML for CI: a suite for each folder of plans, a test case for each case.
//!
//! A failed case is `<failure type="fail">`, an inconclusive one `<failure type="inconclusive">` (it must
//! not be green), the rig's own trouble `<error>`, and what was not judged `<skipped>` with its reason.

use crate::show::{self, Outcome, clean};
use quick_junit::{NonSuccessKind, Property, Report, TestCase, TestCaseStatus, TestSuite};
use record::{CaseRecord, RunRecord, Verdict};
use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

/// The run as JUnit XML. Times are host seconds; modelled times are properties.
///
/// `classname` and `name` together are unique, also in a record whose case names are not.
pub fn render(run: &RunRecord) -> String {
    let mut report = Report::new("rig");
    report.timestamp = run.provenance.started.as_deref().and_then(|started| started.parse().ok());
    let mut total = Duration::ZERO;
    for (folder, cases) in by_folder(run) {
        let mut suite = TestSuite::new(if folder.is_empty() { "plans" } else { folder });
        let mut time = Duration::ZERO;
        let mut names = BTreeSet::new();
        for case in cases {
            time += Duration::from_millis(case.host_ms);
            suite.add_test_case(test_case(case, folder, &mut names));
        }
        suite.set_time(time);
        for (name, value) in facts_of(run) {
            suite.add_property(Property::new(name, value));
        }
        total += time;
        report.add_test_suite(suite);
    }
    report.set_time(total);
    // XmlString has removed what XML cannot hold, and writing to memory does not fail.
    report.to_string().unwrap_or_default()
}

fn by_folder(run: &RunRecord) -> BTreeMap<&str, Vec<&CaseRecord>> {
    let mut folders: BTreeMap<&str, Vec<&CaseRecord>> = BTreeMap::new();
    for case in &run.cases {
        folders.entry(case.folder()).or_default().push(case);
    }
    folders
}

fn facts_of(run: &RunRecord) -> Vec<(&'static str, String)> {
    let facts = &run.provenance;
    let mut all = vec![
        ("rig.version", run.rig_version.clone()),
        ("rig.sha256", facts.binary_sha256.clone()),
        ("rig.clock", facts.clock.word().to_owned()),
        ("rig.seed", facts.seed.to_string()),
        ("rig.profiles", facts.profiles.join(" ")),
        ("host.kernel", facts.kernel.clone()),
    ];
    all.retain(|(_, value)| !value.is_empty());
    all
}

fn test_case(case: &CaseRecord, folder: &str, names: &mut BTreeSet<String>) -> TestCase {
    let own = case.name[folder.len()..].trim_start_matches('/');
    let own = clean(if own.is_empty() { "(unnamed)" } else { own }).into_owned();
    let mut name = own.clone();
    let mut copy = 2;
    while !names.insert(name.clone()) {
        name = format!("{own} #{copy}");
        copy += 1;
    }
    let mut test = TestCase::new(name, status(case));
    test.set_classname(if folder.is_empty() { "plans".to_owned() } else { clean(folder).replace('/', ".") });
    test.set_time(Duration::from_millis(case.host_ms));
    test.set_assertions(case.claims.len() + case.measurements.len());
    if !case.plan.is_empty() {
        test.extra.insert("file".into(), clean(&case.plan).as_ref().into());
    }
    for requirement in &case.proves {
        test.add_property(Property::new("requirement", clean(requirement).as_ref()));
    }
    for (name, value) in [
        ("modelled", show::span(case.duration_ns)),
        ("seed", case.seed.to_string()),
        ("profile", case.profile.clone()),
        ("trace.sha256", case.trace_sha256.clone()),
    ] {
        if case.is_judged() && !value.is_empty() {
            test.add_property(Property::new(name, clean(&value).as_ref()));
        }
    }
    if !case.measurements.is_empty() {
        test.set_system_out(measurements(case));
    }
    test
}

fn status(case: &CaseRecord) -> TestCaseStatus {
    let kind = match Outcome::of(case) {
        Outcome::Judged(Verdict::Pass) => return TestCaseStatus::success(),
        Outcome::Judged(Verdict::Fail | Verdict::Inconclusive) => NonSuccessKind::Failure,
        Outcome::Judged(Verdict::Error) => NonSuccessKind::Error,
        outcome @ (Outcome::Judged(Verdict::None) | Outcome::Skipped | Outcome::NotApplicable) => {
            let mut status = TestCaseStatus::skipped();
            let word = match outcome {
                Outcome::NotApplicable => "not applicable",
                Outcome::Skipped => "skipped",
                Outcome::Judged(_) => "nothing was judged",
            };
            let reason = clean(show::reason(case));
            status.set_message(if reason.is_empty() { word.to_owned() } else { format!("{word}: {reason}") });
            return status;
        }
    };
    let mut status = TestCaseStatus::non_success(kind);
    status.set_type(case.verdict.word());
    status.set_message(message(case));
    // The details hold the whole story: expected, observed, margin, nearest miss, last writer, plan line.
    status.set_description(crate::text::details(case, crate::text::Style::default()));
    status
}

/// One line for lists of failures: the worst claim or measurement, or the case's own reason.
fn message(case: &CaseRecord) -> String {
    let claim = case.claims.iter().find(|c| c.verdict == case.verdict);
    let measurement = case.measurements.iter().find(|m| m.verdict == case.verdict);
    let mut text = match (claim, measurement) {
        (Some(claim), _) => {
            let mut text =
                format!("{}: expected {}, observed {}", claim.name, claim.expected, claim.observed);
            if let Some(margin) = &claim.margin {
                text.push_str(&format!(", margin {margin}"));
            }
            if let Some(miss) = &claim.nearest_miss {
                text.push_str(&format!(", nearest miss: {miss}"));
            }
            text
        }
        (None, Some(m)) => format!("{}: limits {}, measured {}", m.name, show::limits(m), show::value(m)),
        (None, None) => case.reason.clone(),
    };
    if text.is_empty() {
        text = case.verdict.word().to_owned();
    }
    clean(&text).into_owned()
}

fn measurements(case: &CaseRecord) -> String {
    let mut out = String::new();
    for m in &case.measurements {
        let limits = show::limits(m);
        let limits = if limits.is_empty() { String::new() } else { format!(" (limits {limits})") };
        out.push_str(&clean(&format!("{} {} = {}{limits}", m.verdict, m.name, show::value(m))));
        out.push('\n');
    }
    out
}
