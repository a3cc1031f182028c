//! JUnit XML for CI: a suite for each folder of plans, a test case for each case.
//!
//! A failed case is `<failure type="fail">`, an inconclusive one `<failure type="inconclusive">` (it must
//! not be green), the rig's own trouble `<error>`, and what was not judged `<skipped>` with its reason.
//!
//! The file holds to the schemas of Jenkins, which know neither properties nor a file of a test case: those facts
//! stand in `system-out` as `[[PROPERTY|name=value]]`, beside the `[[ATTACHMENT|path]]` that GitLab and Jenkins link.

mod xml;

use crate::brief;
use crate::show::{self, ShownOutcome, clean};
use record::{CaseRecord, RunRecord, Verdict};
use std::collections::{BTreeMap, BTreeSet};
use xml::Xml;

/// The largest file in bytes: GitLab reads none above 30 MB.
pub const MAX_BYTES: usize = 30_000_000;

/// Longest `message` in bytes: readers show it as one line.
const LONGEST_MESSAGE: usize = 2_000;

/// Room that is kept for what is said at the end.
const TAIL: usize = 4_000;

/// How much is said of each case.
#[derive(Clone, Copy, Debug)]
struct DetailLevel {
    /// Longest message.
    message: usize,
    /// Longest text of a failure.
    text: usize,
    /// Longest name of a case or folder.
    name: usize,
    /// Whether cases that passed have a `system-out`, and those that did not.
    passed: bool,
    others: bool,
}

/// From everything to the least; the first that keeps the file small enough is taken.
const DETAILS: [DetailLevel; 3] = [
    DetailLevel { message: LONGEST_MESSAGE, text: 65_536, name: usize::MAX, passed: true, others: true },
    DetailLevel { message: 500, text: 2_000, name: usize::MAX, passed: false, others: true },
    DetailLevel { message: 150, text: 0, name: 150, passed: false, others: false },
];

/// The run as JUnit XML of at most [`MAX_BYTES`]. Times are host seconds; modelled times are properties.
///
/// `folder` is where the record stands, as the reader of the file names it: paths of traces begin with it.
/// `classname` and `name` together are unique, also in a record whose case names are not.
pub fn render(run: &RunRecord, folder: &str) -> String {
    render_within(run, folder, MAX_BYTES)
}

fn render_within(run: &RunRecord, folder: &str, most: usize) -> String {
    let whole = |detail: &DetailLevel| {
        let written = suites(run, folder, *detail, most);
        (written.left_out == 0).then(|| written.file())
    };
    let last = || suites(run, folder, DETAILS[DETAILS.len() - 1], most).file();
    DETAILS.iter().find_map(whole).unwrap_or_else(last)
}

/// Cases by what JUnit counts.
#[derive(Clone, Copy, Debug, Default)]
struct SuiteCounts {
    tests: usize,
    skipped: usize,
    failures: usize,
    errors: usize,
    host_ms: u64,
}

impl SuiteCounts {
    fn add(&mut self, case: &CaseRecord) {
        self.tests += 1;
        self.host_ms += case.host_ms;
        match ShownOutcome::of(case) {
            ShownOutcome::Judged(Verdict::Pass) => {}
            ShownOutcome::Judged(Verdict::Fail | Verdict::Inconclusive) => self.failures += 1,
            ShownOutcome::Judged(Verdict::Error) => self.errors += 1,
            ShownOutcome::Judged(Verdict::None) | ShownOutcome::Skipped | ShownOutcome::NotApplicable => {
                self.skipped += 1
            }
        }
    }

    fn and(self, other: SuiteCounts) -> SuiteCounts {
        SuiteCounts {
            tests: self.tests + other.tests,
            skipped: self.skipped + other.skipped,
            failures: self.failures + other.failures,
            errors: self.errors + other.errors,
            host_ms: self.host_ms + other.host_ms,
        }
    }
}

/// The suites of a file, without what stands around them.
struct Suites {
    body: Xml,
    counts: SuiteCounts,
    /// Cases for which there was no room.
    left_out: usize,
}

impl Suites {
    fn file(self) -> String {
        let SuiteCounts { tests, failures, errors, host_ms, .. } = self.counts;
        let mut file = Xml::default();
        file.open(
            0,
            "testsuites",
            &[
                ("name", "rig"),
                ("tests", &tests.to_string()),
                ("failures", &failures.to_string()),
                ("errors", &errors.to_string()),
                ("time", &seconds(host_ms)),
            ],
        );
        file.append(&self.body);
        file.close(0, "testsuites");
        file.file()
    }
}

fn suites(run: &RunRecord, folder: &str, detail: DetailLevel, most: usize) -> Suites {
    let room = most.saturating_sub(TAIL);
    let mut all = Suites { body: Xml::default(), counts: SuiteCounts::default(), left_out: 0 };
    let mut worst_left_out = Verdict::None;
    for (place, cases) in by_folder(run) {
        let place = brief::shorten(&clean(place), detail.name);
        let mut suite = Xml::default();
        let mut counts = SuiteCounts::default();
        let mut names = BTreeSet::new();
        for case in cases {
            let before = suite.len();
            let mut one = Xml::default();
            test_case(&mut one, case, &place, folder, detail, &mut names);
            if all.body.len() + before + one.len() > room {
                all.left_out += 1;
                worst_left_out = worst_left_out.and(case.verdict);
                continue;
            }
            suite.append(&one);
            counts.add(case);
        }
        if counts.tests > 0 {
            let name = if place.is_empty() { "plans" } else { &place };
            open_suite(&mut all.body, run, name, counts);
            all.body.append(&suite);
            all.body.close(1, "testsuite");
            all.counts = all.counts.and(counts);
        }
    }
    if all.left_out > 0 {
        let errors = usize::from(worst_left_out > Verdict::Pass);
        let counts = SuiteCounts { tests: 1, errors, skipped: 1 - errors, ..SuiteCounts::default() };
        let said = format!(
            "{} cases are left out of this file of at most {most} bytes; the worst verdict among them is {worst_left_out}",
            all.left_out
        );
        open_suite(&mut all.body, run, "rig", counts);
        all.body.open(2, "testcase", &[("name", "cases left out"), ("time", "0.000"), ("classname", "rig")]);
        match errors {
            0 => all.body.text(3, "skipped", &[], &said),
            _ => all.body.text(3, "error", &[("type", "left-out"), ("message", &said)], "See record.json."),
        }
        all.body.close(2, "testcase");
        all.body.close(1, "testsuite");
        all.counts = all.counts.and(counts);
    }
    all
}

fn by_folder(run: &RunRecord) -> BTreeMap<&str, Vec<&CaseRecord>> {
    let mut folders: BTreeMap<&str, Vec<&CaseRecord>> = BTreeMap::new();
    for case in &run.cases {
        folders.entry(case.folder()).or_default().push(case);
    }
    folders
}

/// Opens a suite, with the facts of the run: each may be read without the others.
fn open_suite(out: &mut Xml, run: &RunRecord, name: &str, counts: SuiteCounts) {
    let SuiteCounts { tests, skipped, failures, errors, host_ms } = counts;
    let (tests, skipped) = (tests.to_string(), skipped.to_string());
    let (failures, errors, time) = (failures.to_string(), errors.to_string(), seconds(host_ms));
    let mut attributes = vec![
        ("name", name),
        ("tests", &tests),
        ("skipped", &skipped),
        ("failures", &failures),
        ("errors", &errors),
        ("time", &time),
    ];
    if let Some(started) = &run.provenance.started {
        attributes.push(("timestamp", started));
    }
    out.open(1, "testsuite", &attributes);
    out.open(2, "properties", &[]);
    for (name, value) in facts_of(run) {
        out.empty(3, "property", &[("name", name), ("value", &clean(&value))]);
    }
    out.close(2, "properties");
}

fn facts_of(run: &RunRecord) -> Vec<(&'static str, String)> {
    let facts = &run.provenance;
    let mut all = vec![
        ("rig.version", run.rig_version.clone()),
        ("rig.sha256", facts.binary_sha256.clone()),
        ("rig.clock", facts.clock.word().to_owned()),
        ("rig.seed", facts.seed.to_string()),
        ("rig.profiles", facts.profiles.join(" ")),
        ("rig.guard", show::unguarded(run)),
        ("rig.shard", run.shard.map_or(String::new(), |[part, of]| format!("{part}/{of}"))),
        ("host.kernel", facts.kernel.clone()),
    ];
    all.retain(|(_, value)| !value.is_empty());
    all
}

fn test_case(
    out: &mut Xml,
    case: &CaseRecord,
    place: &str,
    folder: &str,
    detail: DetailLevel,
    names: &mut BTreeSet<String>,
) {
    let own = case.name[case.folder().len()..].trim_start_matches('/');
    let own = brief::shorten(&clean(if own.is_empty() { "(unnamed)" } else { own }), detail.name);
    let mut name = own.clone();
    let mut copy = 2;
    while !names.insert(name.clone()) {
        name = format!("{own} #{copy}");
        copy += 1;
    }
    let class = if place.is_empty() { "plans".to_owned() } else { place.replace('/', ".") };
    let time = seconds(case.host_ms);
    let attributes = [("name", name.as_str()), ("classname", &class), ("time", &time)];
    let passed = ShownOutcome::of(case) == ShownOutcome::Judged(Verdict::Pass);
    let wanted = if passed { detail.passed } else { detail.others };
    let said = if wanted { system_out(case, folder, passed) } else { String::new() };
    if passed && said.is_empty() {
        return out.empty(2, "testcase", &attributes);
    }
    out.open(2, "testcase", &attributes);
    status(out, case, detail);
    if !said.is_empty() {
        out.text(3, "system-out", &[], &said);
    }
    out.close(2, "testcase");
}

fn status(out: &mut Xml, case: &CaseRecord, detail: DetailLevel) {
    let element = match ShownOutcome::of(case) {
        ShownOutcome::Judged(Verdict::Pass) => return,
        ShownOutcome::Judged(Verdict::Fail | Verdict::Inconclusive) => "failure",
        ShownOutcome::Judged(Verdict::Error) => "error",
        outcome @ (ShownOutcome::Judged(Verdict::None)
        | ShownOutcome::Skipped
        | ShownOutcome::NotApplicable) => {
            let word = match outcome {
                ShownOutcome::NotApplicable => "not applicable",
                ShownOutcome::Skipped => "skipped",
                ShownOutcome::Judged(_) => "nothing was judged",
            };
            let reason = brief::cut(&clean(show::reason(case)), detail.message);
            let said = if reason.is_empty() { word.to_owned() } else { format!("{word}: {reason}") };
            return out.text(3, "skipped", &[], &said);
        }
    };
    let message = brief::cut(&brief::message(case), detail.message);
    let attributes = [("type", case.verdict.word()), ("message", &message)];
    // The details hold the whole story: expected, observed, margin, nearest miss, last writer, plan line.
    let details = match detail.text {
        0 => String::new(),
        most => brief::cut(&crate::text::details(case, crate::text::Style::default()), most),
    };
    out.text(3, element, &attributes, &details);
}

/// Properties, measurements, and where a case did not pass its waves, a line each.
fn system_out(case: &CaseRecord, folder: &str, passed: bool) -> String {
    let mut out = String::new();
    let mut line = |text: &str| {
        out.push_str(&clean(text));
        out.push('\n');
    };
    for requirement in &case.proves {
        line(&format!("[[PROPERTY|requirement={requirement}]]"));
    }
    if case.is_judged() {
        for (name, value) in [
            ("plan", case.plan.clone()),
            ("modelled", show::span(case.duration_ns)),
            ("seed", case.seed.to_string()),
            ("profile", case.profile.clone()),
            ("model", case.model.clone()),
            ("trace.sha256", case.trace_sha256.clone()),
        ] {
            if !value.is_empty() {
                line(&format!("[[PROPERTY|{name}={value}]]"));
            }
        }
    }
    for m in &case.measurements {
        let limits = Some(show::limits(m)).filter(|limits| !limits.is_empty());
        let limits = limits.map(|limits| format!("limits {limits}"));
        let coverage = Some(&m.coverage).filter(|words| !words.is_empty() && m.value.is_some());
        let by_middle = Some(show::by_middle(m).to_owned()).filter(|reason| !reason.is_empty());
        let coverage = coverage.map(|words| format!("coverage {words}"));
        let facts: Vec<String> = limits.into_iter().chain(coverage).chain(by_middle).collect();
        let facts = if facts.is_empty() { String::new() } else { format!(" ({})", facts.join("; ")) };
        line(&plain(&format!("{} {} = {}{facts}", m.verdict, m.name, show::value(m))));
    }
    if let Some(instrument) = &case.instrument {
        line(&plain(&format!("instrument {} {}", instrument.file, instrument.title)));
        for (of, stated) in show::instrument(instrument) {
            line(&plain(&format!("  {of}: {stated}")));
        }
    }
    for file in [brief::waves(case), brief::frames(case)].into_iter().flatten().filter(|_| !passed) {
        let file = if folder.is_empty() { file } else { format!("{}/{file}", folder.trim_end_matches('/')) };
        line(&format!("[[ATTACHMENT|{file}]]"));
    }
    out
}

/// Words of a user's file, which shall not be taken for an attachment or a property.
fn plain(text: &str) -> String {
    text.replace("[[", "[ [")
}

fn seconds(ms: u64) -> String {
    format!("{}.{:03}", ms / 1000, ms % 1000)
}

#[cfg(test)]
mod tests;
