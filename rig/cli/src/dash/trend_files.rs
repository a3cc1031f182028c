//! Recordings of the dashboard's trend in files: dumps and tables, written as the rig writes its own and read as it
//! reads those of other instruments.

use capture::{Capture, CaptureFormat, ChannelType};
use control::{RequestFault, SignalKind, Value, WireValue};
use dash::frame_decoder::FrameDecoder;
use dash::recording::{RecordedChange, RecordedSignal, TrendFiles, TrendRecording};
use document::file::FileFault;
use serde_json::json;
use signal::{Cause, Event, SignalId, SignalInfo, Time, Trace, ValueKind, When};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

/// The ending of a path names no format that is written.
const NO_FORMAT: &str = "R0680";
/// A recording cannot be written.
const NOT_WRITTEN: &str = "R0681";
/// A recording cannot be read.
const NOT_READ: &str = "R0682";

/// The note of a dump that says what the signals were, where a dump itself cannot.
const NOTE: &str = "trend";

/// Recordings in the host's files.
#[derive(Debug)]
pub struct HostTrendFiles;

impl TrendFiles for HostTrendFiles {
    fn extensions(&self) -> &[&str] {
        &["vcd", "csv"]
    }

    fn save(&self, path: &str, recording: &TrendRecording) -> Result<(), RequestFault> {
        let ending = path.rsplit_once('.').map_or("", |(_, ending)| ending).to_ascii_lowercase();
        if !self.extensions().contains(&ending.as_str()) {
            return Err(fault(
                NO_FORMAT,
                format!("`{path}` ends as no format that is written"),
                "end the name with .vcd or .csv",
            ));
        }
        let failed = |error: &dyn std::fmt::Display| {
            fault(
                NOT_WRITTEN,
                format!("`{path}` cannot be written: {error}"),
                "name a new file, in a folder that you may write to",
            )
        };
        let file = File::create_new(path).map_err(|error| failed(&error))?;
        let mut out = BufWriter::new(file);
        match ending.as_str() {
            "vcd" => write_dump(recording, &mut out).map_err(|error| failed(&error)),
            _ => write_table(recording, &mut out).map_err(|error| failed(&error)),
        }
    }

    fn load(&self, path: &str) -> Result<TrendRecording, RequestFault> {
        let failed =
            |what: String, help: &str| fault(NOT_READ, format!("`{path}` cannot be read: {what}"), help);
        let other = "name a value change dump, a table with a column of instants, or a sigrok session";
        let bytes = document::file::read(Path::new(path), capture::MAX_FILE).map_err(|fault| {
            let help =
                if matches!(fault, FileFault::TooLarge { .. }) { "cut a part out of it" } else { other };
            failed(fault.to_string(), help)
        })?;
        let format = CaptureFormat::of(&bytes, path)
            .ok_or_else(|| failed("its format is not known".to_owned(), other))?;
        let capture =
            capture::read(format, &bytes, None).map_err(|error| failed(error.to_string(), error.fix))?;
        Ok(recording_of(capture))
    }

    fn decoder(&self, path: &str) -> Result<Box<dyn FrameDecoder>, RequestFault> {
        super::dbc_decoder::read(path)
    }
}

fn fault(code: &str, message: String, help: &str) -> RequestFault {
    RequestFault { code: code.to_owned(), message, help: help.to_owned() }
}

fn kind_of(kind: SignalKind) -> ValueKind {
    match kind {
        SignalKind::Bool => ValueKind::Bool,
        SignalKind::Int => ValueKind::Int,
        SignalKind::Word => ValueKind::Word,
        SignalKind::Real => ValueKind::Real,
        SignalKind::State => ValueKind::State,
    }
}

fn write_dump(recording: &TrendRecording, out: &mut impl Write) -> Result<(), Box<dyn std::error::Error>> {
    let mut trace = Trace::new();
    for track in &recording.tracks {
        let mut info = SignalInfo::exact(&track.name, kind_of(track.kind));
        info.unit.clone_from(&track.unit);
        info.labels.clone_from(&track.labels);
        trace.define(info)?;
    }
    // The names that the dump has for them.
    let names = reports::vcd::names(trace.signals());
    let tracks: Vec<_> = recording
        .tracks
        .iter()
        .zip(&names)
        .map(|(track, name)| {
            json!({
                "name": track.name, "as": name, "unit": track.unit, "kind": track.kind, "labels": track.labels,
            })
        })
        .collect();
    trace.set_note(NOTE, json!({ "span": recording.span, "signals": tracks }).to_string());
    for sample in &recording.samples {
        let (earliest, latest) = sample.when;
        trace.push(Event {
            signal: SignalId(sample.track as u32),
            at: When::within(Time::from_nanos(earliest), Time::from_nanos(latest)),
            value: sample.value.0,
            cause: Cause::Unknown,
        })?;
    }
    // How the signals were recorded a client does not know.
    reports::vcd::write_waves(&trace, env!("CARGO_PKG_VERSION"), &mut *out)?;
    out.flush()?;
    Ok(())
}

/// A row for each instant, with what changed then.
fn write_table(recording: &TrendRecording, out: &mut impl Write) -> std::io::Result<()> {
    write!(out, "time [ns]")?;
    for track in &recording.tracks {
        // A comma or a quote would begin another column; brackets hold units.
        let name: String =
            track.name.chars().map(|c| if ",;\t\"[]\n\r".contains(c) { '_' } else { c }).collect();
        write!(out, ",{name}")?;
        if !track.unit.is_empty() {
            write!(out, " [{}]", track.unit)?;
        }
    }
    writeln!(out)?;
    for row in recording.samples.chunk_by(|a, b| a.when.1 == b.when.1) {
        let mut cells = vec![String::new(); recording.tracks.len()];
        for sample in row {
            if let Some(cell) = cells.get_mut(sample.track) {
                *cell = cell_of(sample.value);
            }
        }
        writeln!(out, "{},{}", row[0].when.1, cells.join(","))?;
    }
    out.flush()
}

fn cell_of(value: WireValue) -> String {
    match value.0 {
        Value::Bool(on) => u8::from(on).to_string(),
        Value::Int(number) => number.to_string(),
        Value::Word(number) => number.to_string(),
        // With a point even where it is whole, so that it stays a real number.
        Value::Real(number) | Value::Measured(number, _) if number.fract() == 0.0 => format!("{number:.1}"),
        Value::Real(number) | Value::Measured(number, _) => number.to_string(),
        Value::HighZ => "z".to_owned(),
        Value::Unknown => "x".to_owned(),
    }
}

fn recording_of(capture: Capture) -> TrendRecording {
    let note = capture.notes.iter().find(|(key, _)| key == NOTE);
    let note: Option<serde_json::Value> = note.and_then(|(_, text)| serde_json::from_str(text).ok());
    let own = |name: &str| {
        let signals = note.as_ref()?.get("signals")?.as_array()?;
        let signal = signals.iter().find(|signal| signal.get("as").is_some_and(|other| other == name))?;
        Some(RecordedSignal {
            name: signal.get("name")?.as_str()?.to_owned(),
            unit: signal.get("unit")?.as_str()?.to_owned(),
            kind: serde_json::from_value(signal.get("kind")?.clone()).ok()?,
            labels: serde_json::from_value(signal.get("labels")?.clone()).ok()?,
        })
    };
    let tracks: Vec<RecordedSignal> = capture
        .channels
        .iter()
        .map(|channel| {
            own(&channel.name).unwrap_or_else(|| RecordedSignal {
                name: channel.name.clone(),
                unit: channel.unit.clone(),
                kind: match channel.shape {
                    ChannelType::Bit => SignalKind::Bool,
                    ChannelType::Whole => SignalKind::Int,
                    ChannelType::Real => SignalKind::Real,
                },
                labels: Vec::new(),
            })
        })
        .collect();
    let samples = capture.changes.iter().map(|change| {
        let track = change.channel as usize;
        let signed =
            matches!(tracks.get(track).map(|track| track.kind), Some(SignalKind::Int | SignalKind::State));
        let value = match change.value {
            // A dump has the bits of a signed number.
            Value::Word(bits) if signed => Value::Int(bits.cast_signed()),
            other => other,
        };
        let when = (change.at.earliest.as_nanos(), change.at.latest.as_nanos());
        RecordedChange { track, when, value: WireValue(value) }
    });
    let samples = samples.collect();
    let read = capture.span.map(Time::as_nanos);
    let span = note.as_ref().and_then(|note| serde_json::from_value(note.get("span")?.clone()).ok());
    TrendRecording { tracks, samples, span: span.unwrap_or((read[0], read[1])) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recording() -> TrendRecording {
        let track = |name: &str, unit: &str, kind| RecordedSignal {
            name: name.to_owned(),
            unit: unit.to_owned(),
            kind,
            labels: Vec::new(),
        };
        let mut state = track("state of it", "", SignalKind::State);
        state.labels = vec![(-1, "LOST $end".to_owned()), (2, "FULL".to_owned())];
        let sample = |track, when, value| RecordedChange { track, when, value: WireValue(value) };
        TrendRecording {
            tracks: vec![
                track("%QX0.4", "", SignalKind::Bool),
                track("level, left", "mm", SignalKind::Real),
                track("HSC0.Count", "", SignalKind::Int),
                state,
                track("mask", "", SignalKind::Word),
            ],
            samples: vec![
                sample(0, (1_000, 1_000), Value::Bool(true)),
                sample(1, (1_000, 1_000), Value::Real(2.0)),
                sample(2, (1_500, 1_500), Value::Int(-7)),
                sample(3, (1_500, 1_500), Value::Int(-1)),
                sample(4, (1_600, 1_600), Value::Word(u64::MAX)),
                sample(1, (1_990, 2_000), Value::Real(-0.125)),
                sample(0, (2_500, 2_500), Value::HighZ),
            ],
            span: (1_000, 3_000),
        }
    }

    /// What is shown at an instant.
    fn at(recording: &TrendRecording, track: usize, at: i64) -> Value {
        let seen = recording.samples.iter().rev().find(|sample| sample.track == track && sample.when.1 <= at);
        seen.map_or(Value::Unknown, |sample| sample.value.0)
    }

    #[test]
    fn a_dump_reads_back_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trend.vcd").display().to_string();
        let before = recording();
        HostTrendFiles.save(&path, &before).unwrap();
        let after = HostTrendFiles.load(&path).unwrap();
        assert_eq!((&after.tracks, after.span), (&before.tracks, before.span));
        for track in 0..before.tracks.len() {
            for instant in [999, 1_000, 1_600, 1_999, 2_000, 2_499, 2_500] {
                let (seen, wanted) = (at(&after, track, instant), at(&before, track, instant));
                assert_eq!(seen, wanted, "{} at {instant}", before.tracks[track].name);
            }
        }
        // How well an instant is known stays, too, as far as a dump says it.
        let wide = after.samples.iter().find(|sample| sample.value.0 == Value::Real(-0.125)).unwrap();
        assert_eq!(wide.when, (1_990, 2_000));
    }

    #[test]
    fn a_table_reads_back_with_its_values() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trend.csv").display().to_string();
        HostTrendFiles.save(&path, &recording()).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(
            text.starts_with(
                "time [ns],%QX0.4,level_ left [mm],HSC0.Count,state of it,mask\n1000,1,2.0,,,\n"
            ),
            "{text}"
        );
        let after = HostTrendFiles.load(&path).unwrap();
        assert_eq!((after.tracks[1].name.as_str(), after.tracks[1].unit.as_str()), ("level_ left", "mm"));
        assert_eq!(at(&after, 1, 2_000), Value::Real(-0.125));
        assert_eq!(at(&after, 2, 2_000), Value::Int(-7));
        assert_eq!(at(&after, 0, 2_500), Value::HighZ);
    }

    #[test]
    fn what_cannot_be_written_or_read_says_why() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name).display().to_string();
        let code = |result: Result<(), RequestFault>| result.unwrap_err().code;
        assert_eq!(code(HostTrendFiles.save(&path("trend.png"), &recording())), "R0680");
        assert_eq!(code(HostTrendFiles.save(&path("trend"), &recording())), "R0680");
        HostTrendFiles.save(&path("trend.csv"), &recording()).unwrap();
        assert_eq!(code(HostTrendFiles.save(&path("trend.csv"), &recording())), "R0681");
        for (name, content) in
            [("none.vcd", None), ("text.txt", Some("hello")), ("cut.vcd", Some("$var $end"))]
        {
            if let Some(content) = content {
                std::fs::write(path(name), content).unwrap();
            }
            assert_eq!(code(HostTrendFiles.load(&path(name)).map(drop)), "R0682", "{name}");
        }
    }
}
