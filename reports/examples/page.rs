//! Writes the example run, to be looked at: `cargo run -p scanrig-reports --example page > page.html`.
//!
//! The first argument chooses the form: `html` (also without one), `hostile`, `extreme`, `repeated`, `text`, `junit`,
//! `ctrf`, `markdown`, `measurements`, `claims`, `json`, `vcd`; any other is the path of a `record.json` to draw.

#[path = "../tests/fixture/mod.rs"]
mod fixture;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let form = std::env::args().nth(1).unwrap_or_default();
    let run = fixture::example();
    let text = match form.as_str() {
        "junit" => scanrig_reports::junit::render(&run, "out"),
        "ctrf" => scanrig_reports::ctrf::render(&run),
        "markdown" => scanrig_reports::markdown::render(&run),
        "measurements" => scanrig_reports::csv::measurements(&run),
        "claims" => scanrig_reports::csv::claims(&run),
        "text" => scanrig_reports::text::render(&run, scanrig_reports::text::Style::default()),
        "vcd" => dump(&run),
        "json" => run.to_json(),
        "hostile" => scanrig_reports::html::render(&fixture::hostile())?,
        "extreme" => scanrig_reports::html::render(&fixture::extreme::extreme())?,
        "repeated" => scanrig_reports::html::render(&fixture::repeated())?,
        "" | "html" => scanrig_reports::html::render(&fixture::drawn())?,
        path => {
            let record = record::RunRecord::from_json(&std::fs::read_to_string(path)?)?;
            scanrig_reports::html::render(&record)?
        }
    };
    print!("{text}");
    Ok(())
}

/// The lanes of a case with every kind of signal as a trace, as VCD.
fn dump(run: &record::RunRecord) -> String {
    use signal::{Cause, Event, SignalId, SignalInfo, Time, Value, ValueKind, When};
    let lanes = run.cases.get(3).map_or(&[][..], |case| &case.lanes);
    let kind = |lane: &record::Lane| match lane.kind {
        record::LaneKind::Digital => ValueKind::Bool,
        record::LaneKind::Analog => ValueKind::Real,
        record::LaneKind::State => ValueKind::State,
    };
    let info = |lane: &record::Lane| SignalInfo {
        labels: lane.labels.clone(),
        ..SignalInfo::exact(lane.signal.as_str(), kind(lane))
    };
    let signals: Vec<SignalInfo> = lanes.iter().map(info).collect();
    let mut events = Vec::new();
    for (place, lane) in lanes.iter().enumerate() {
        for point in &lane.points {
            let value = match point.value {
                record::LaneValue::HighZ => Value::HighZ,
                record::LaneValue::Unknown => Value::Unknown,
                record::LaneValue::Number(n) if lane.kind == record::LaneKind::Analog => Value::Real(n),
                record::LaneValue::Number(n) => Value::Int(n as i64),
                record::LaneValue::Large(n) => Value::Int(n as i64),
            };
            let at = When::within(Time::from_nanos(point.at[0]), Time::from_nanos(point.at[1]));
            events.push(Event { signal: SignalId(place as u32), at, value, cause: Cause::Unknown });
        }
    }
    events.sort_by_key(|event| event.at.latest);
    let mut out = Vec::new();
    // Writing to memory does not fail.
    let _ = scanrig_reports::vcd::write(&signals, &events, &run.rig_version, &mut out);
    String::from_utf8(out).unwrap_or_default()
}
