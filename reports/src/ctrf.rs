//! The run in the Common Test Report Format (<https://ctrf.io>), version 0.0 of its schema.
//!
//! A case is a test, its claims and measurements are the steps. Inconclusive cases and the rig's own trouble are
//! `failed`, with the verdict as `rawStatus`; what does not apply or was left out is `skipped`, and a case in which
//! nothing was judged `other`.

use crate::brief::{self, DecidingResult};
use crate::show::{self, ShownOutcome, clean};
use record::{CaseRecord, ClaimRecord, Figure, MeasurementRecord, RunClock, RunRecord, Verdict};
use serde_json::{Map, Value, json};
use signal::calendar::seconds_of;

/// Version of the format.
const SPEC: &str = "0.0.0";

/// Longest message and longest trace of a test, bytes.
const LONGEST_MESSAGE: usize = 2_000;
const LONGEST_TRACE: usize = 65_536;

/// The run as CTRF JSON with a final line end.
pub fn render(run: &RunRecord) -> String {
    let facts = &run.provenance;
    let counts = |status: &str| run.cases.iter().filter(|case| status_of(case) == status).count();
    let start = facts.started.as_deref().and_then(seconds_of).map_or(0, |seconds| seconds * 1_000);
    let host_ms = if run.host_ms > 0 { run.host_ms } else { run.cases.iter().map(|c| c.host_ms).sum() };
    let host_ms = i64::try_from(host_ms).unwrap_or(i64::MAX);
    let mut suites: Vec<&str> = run.cases.iter().map(CaseRecord::folder).collect();
    suites.sort_unstable();
    suites.dedup();
    let mut environment = object([
        ("osPlatform", text("linux")),
        ("osRelease", text(&facts.kernel)),
        (
            "testEnvironment",
            text(match facts.clock {
                RunClock::Virtual => "virtual time",
                RunClock::Real => "real time",
            }),
        ),
        ("shardId", text(&run.shard.map_or(String::new(), |[part, of]| format!("{part}/{of}")))),
    ]);
    environment.insert(
        "extra".into(),
        Value::Object(object([
            ("seed", json!(facts.seed)),
            ("guard", text(&show::unguarded(run))),
            ("processor", text(facts.host_cpu.as_deref().unwrap_or_default())),
            ("binarySha256", text(&facts.binary_sha256)),
            ("selectionSha256", text(&run.selection_sha256)),
            ("profiles", json!(facts.profiles)),
            ("arguments", json!(facts.arguments)),
            (
                "host",
                facts
                    .environment
                    .iter()
                    .map(|(name, value)| (clean(name).into_owned(), text(value)))
                    .collect(),
            ),
        ])),
    );
    let mut report = object([
        ("reportFormat", text("CTRF")),
        ("specVersion", text(SPEC)),
        ("timestamp", text(facts.started.as_deref().unwrap_or_default())),
        ("generatedBy", text(&format!("rig {}", run.rig_version))),
    ]);
    report.insert(
        "results".into(),
        json!({
            "tool": object([("name", text("rig")), ("version", text(&run.rig_version))]),
            "summary": {
                "tests": run.cases.len(),
                "passed": counts("passed"),
                "failed": counts("failed"),
                "skipped": counts("skipped"),
                "pending": 0,
                "other": counts("other"),
                "suites": suites.len(),
                "start": start,
                "stop": start.saturating_add(host_ms),
                "duration": host_ms,
            },
            "tests": run.cases.iter().map(test).collect::<Vec<Value>>(),
            "environment": environment,
        }),
    );
    format!("{}\n", Value::Object(report))
}

/// A text, or nothing where it is empty.
fn text(text: &str) -> Value {
    if text.is_empty() { Value::Null } else { Value::String(clean(text).into_owned()) }
}

/// An object without what is nothing or empty.
fn object<const N: usize>(entries: [(&str, Value); N]) -> Map<String, Value> {
    let says = |value: &Value| match value {
        Value::Null => false,
        Value::Array(list) => !list.is_empty(),
        Value::Object(map) => !map.is_empty(),
        _ => true,
    };
    let kept = entries.into_iter().filter(|(_, value)| says(value));
    kept.map(|(name, value)| (name.to_owned(), value)).collect()
}

fn status_of(case: &CaseRecord) -> &'static str {
    match ShownOutcome::of(case) {
        ShownOutcome::Judged(verdict) => status_word(verdict),
        ShownOutcome::Skipped | ShownOutcome::NotApplicable => "skipped",
    }
}

const fn status_word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Pass => "passed",
        Verdict::Fail | Verdict::Inconclusive | Verdict::Error => "failed",
        Verdict::None => "other",
    }
}

fn test(case: &CaseRecord) -> Value {
    let attention = ShownOutcome::of(case) != ShownOutcome::Judged(Verdict::Pass);
    let details = || {
        let text = crate::text::details(case, crate::text::Style::default());
        Value::String(brief::cut(&text, LONGEST_TRACE))
    };
    let failed = status_of(case) == "failed";
    let line = DecidingResult::of(case).line();
    let name = if case.name.is_empty() { "(unnamed)" } else { &case.name };
    let suite = clean(case.folder()).split('/').filter(|part| !part.is_empty()).map(text).collect();
    let parameters: Map<String, Value> = case
        .parameters
        .iter()
        .map(|parameter| (clean(&parameter.name).into_owned(), json!(clean(&parameter.value))))
        .collect();
    let attachment = |path: &str, name: &str, kind: &str| json!({ "name": name, "contentType": kind, "path": clean(path) });
    let mut attachments = Vec::new();
    if let Some(trace) = &case.trace_file {
        attachments.push(attachment(trace, "trace", "application/octet-stream"));
        attachments.extend(brief::waves(case).map(|waves| attachment(&waves, "waves", "text/x-vcd")));
        attachments.extend(brief::frames(case).map(|frames| attachment(&frames, "CAN frames", "text/plain")));
    }
    let steps = case.claims.iter().map(claim).chain(case.measurements.iter().map(measurement));
    let labels = object([
        ("requirement", case.proves.iter().map(|id| text(id)).filter(|id| !id.is_null()).collect()),
        ("profile", text(&case.profile)),
        ("reference", text(&case.reference)),
    ]);
    let extra = object([
        ("title", text(&case.title)),
        ("modelledNs", json!(case.duration_ns)),
        ("seed", json!(case.seed)),
        ("model", text(&case.model)),
        ("traceSha256", text(&case.trace_sha256)),
    ]);
    Value::Object(object([
        ("name", text(name)),
        ("status", text(status_of(case))),
        ("rawStatus", text(ShownOutcome::of(case).word())),
        ("duration", json!(case.host_ms)),
        ("suite", suite),
        (
            "message",
            if attention { text(&brief::cut(&brief::message(case), LONGEST_MESSAGE)) } else { Value::Null },
        ),
        ("trace", if failed { details() } else { Value::Null }),
        ("line", if failed && line > 0 { json!(line) } else { Value::Null }),
        ("filePath", text(&case.plan)),
        ("labels", Value::Object(labels)),
        ("parameters", Value::Object(parameters)),
        ("steps", steps.collect()),
        ("attachments", Value::Array(attachments)),
        ("extra", Value::Object(extra)),
    ]))
}

fn claim(claim: &ClaimRecord) -> Value {
    let wanted = claim.verdict != Verdict::Pass;
    let extra = object([
        ("verb", text(&claim.verb)),
        ("margin", figure(claim.margin.as_ref())),
        ("uncertainty", figure(claim.uncertainty.as_ref())),
        (
            "expected",
            if wanted && claim.expected != claim.name { text(&claim.expected) } else { Value::Null },
        ),
        ("observed", if wanted { text(&claim.observed) } else { Value::Null }),
        ("reason", text(&claim.reason)),
        ("nearestMiss", text(claim.nearest_miss.as_deref().unwrap_or_default())),
    ]);
    step(&claim.name, claim.verdict, extra)
}

fn measurement(m: &MeasurementRecord) -> Value {
    let (min, max) = show::bounds(m);
    let extra = object([
        ("low", number(m.value.map(|[low, _]| low))),
        ("high", number(m.value.map(|[_, high]| high))),
        ("unit", text(&m.unit)),
        ("coverage", text(&m.coverage)),
        ("min", number(min)),
        ("max", number(max)),
        ("guard", text(if m.guard_band.is_uncertainty() { "" } else { "none" })),
        ("margin", figure(m.margin.as_ref())),
        ("reason", text(&m.reason)),
    ]);
    step(&m.name, m.verdict, extra)
}

fn step(name: &str, verdict: Verdict, extra: Map<String, Value>) -> Value {
    let name = if name.is_empty() { "(unnamed)" } else { name };
    Value::Object(object([
        ("name", text(name)),
        ("status", text(status_word(verdict))),
        ("extra", Value::Object(extra)),
    ]))
}

fn figure(figure: Option<&Figure>) -> Value {
    figure.map_or(Value::Null, |figure| {
        Value::Object(object([("value", number(Some(figure.value))), ("unit", text(&figure.unit))]))
    })
}

/// A number as JSON has it: one that is not finite is a word.
fn number(number: Option<f64>) -> Value {
    match number {
        None => Value::Null,
        Some(number) if number.is_finite() => json!(number),
        Some(number) => Value::String(number.to_string()),
    }
}
