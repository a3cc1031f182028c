//! Value change dumps (IEEE 1364-2001, 18.2) for waveform viewers and logic analyser tools.
//!
//! A change that is known to lie within an interval is written at its latest instant: from there on the
//! value is certain. Changes are put in order of that instant within a bounded buffer; one that comes later still is
//! written at the instant reached.
//!
//! Comments say what else the trace knew, so that the dump can be judged again (`capture::vcd` reads them):
//!
//! - `note KEY VALUE`: a note of the trace.
//! - `recorded SIGNAL HOW`: its [`SignalRecording`].
//! - `uncertainty VARIABLE SIGNAL`: a number that was measured has a variable beside it with how far the truth may lie from it.
//! - `origin N ns`: the instant of the trace that is 0 in the dump, if another.
//! - At the end `widest SIGNAL N ns`: how far before its instant in the dump a change may have happened at most, and
//!   `complete`, without which the dump was cut off.
//!
//! What the trace knows and a dump does not: the width of each single change, who made it, why a value is not known, and a
//! real number that is none (NaN), which is not known in the dump.

use signal::{
    ClockDomain, Event, SignalId, SignalInfo, SignalRecording, Time, Trace, TraceError, Value, ValueKind,
};
use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};
use std::io::{self, Write};
use thiserror::Error;
use vcd::{IdCode, SimulationCommand, TimescaleUnit, VarType, Writer};

/// How many changes wait to be put in order.
const REORDER: usize = 4_096;

/// Writes the signals and their changes, timescale 1 ns.
///
/// How the signals were recorded it does not say: such a dump is looked at, and not judged again.
///
/// Booleans are one bit with `z` and `x`, numbers and states vectors of 64 bits (two's complement), real
/// numbers `real`, marks 64-bit counters. The labels of states stand in a comment of the header. Events of
/// signals that `signals` does not hold are left out. `signals` in the order of their [`SignalId`]s.
///
/// # Errors
/// Those of `out`.
pub fn write<W: Write>(
    signals: &[SignalInfo],
    events: &[Event],
    rig_version: &str,
    out: W,
) -> io::Result<()> {
    let mut before = BeforeWriting::new(signals);
    events.iter().for_each(|event| before.see(event));
    let mut sink = VcdWriter::begin(signals, &before, rig_version, out, |_| Ok(()))?;
    for event in events {
        sink.push(event)?;
    }
    sink.finish()
}

/// Why a trace was not written as VCD.
#[derive(Debug, Error)]
pub enum VcdError {
    /// The trace could not be read.
    #[error("the trace cannot be read: {0}")]
    Trace(#[source] TraceError),
    /// The output could not be written.
    #[error("the dump cannot be written: {0}")]
    Output(#[source] io::Error),
}

/// Writes a whole trace with its notes, so that it can be judged again; see [`write()`].
///
/// # Errors
/// [`VcdError`]: reading the trace or writing the dump failed.
pub fn write_trace<W: Write>(trace: &Trace, rig_version: &str, out: W) -> Result<(), VcdError> {
    write_all(trace, true, rig_version, out)
}

/// The same without how the signals were recorded, of a trace that does not know it: it is looked at, and not judged again.
///
/// # Errors
/// As [`write_trace`].
pub fn write_waves<W: Write>(trace: &Trace, rig_version: &str, out: W) -> Result<(), VcdError> {
    write_all(trace, false, rig_version, out)
}

fn write_all<W: Write>(
    trace: &Trace,
    says_recording: bool,
    rig_version: &str,
    out: W,
) -> Result<(), VcdError> {
    let notes = |writer: &mut Writer<W>| -> io::Result<()> {
        for (key, value) in trace.notes() {
            writer.comment(&format!("note {} {}", escaped(key).replace(' ', "\\s"), escaped(value)))?;
        }
        Ok(())
    };
    let mut before = BeforeWriting { says_recording, ..BeforeWriting::new(trace.signals()) };
    for event in trace.events() {
        before.see(&event.map_err(VcdError::Trace)?);
    }
    let mut sink =
        VcdWriter::begin(trace.signals(), &before, rig_version, out, notes).map_err(VcdError::Output)?;
    for event in trace.events() {
        sink.push(&event.map_err(VcdError::Trace)?).map_err(VcdError::Output)?;
    }
    sink.finish().map_err(VcdError::Output)
}

/// What the header says of the events, found before they are written.
struct BeforeWriting {
    /// The instant, in nanoseconds, that is 0 in the dump, which has none before that: 0, or the earliest of the trace.
    origin: i64,
    /// Of each signal whether a number of it was measured.
    measured: Vec<bool>,
    /// Whether it says how each signal was recorded.
    says_recording: bool,
}

impl BeforeWriting {
    fn new(signals: &[SignalInfo]) -> BeforeWriting {
        BeforeWriting { origin: 0, measured: vec![false; signals.len()], says_recording: false }
    }

    fn see(&mut self, event: &Event) {
        let Some(measured) = self.measured.get_mut(event.signal.0 as usize) else { return };
        *measured |= event.value.uncertainty() > 0.0;
        self.origin = self.origin.min(event.at.earliest.as_nanos());
    }
}

/// A dump that is being written, for events that come one by one or may fail to be read.
struct VcdWriter<'a, W: Write> {
    writer: Writer<W>,
    signals: &'a [SignalInfo],
    codes: Vec<IdCode>,
    names: Vec<String>,
    /// Of signals that are measured: the variable of their uncertainty, and what it has.
    uncertainties: Vec<Option<(IdCode, f64)>>,
    /// How far before its instant in the dump a change of each signal may have happened at most.
    widest: Vec<u64>,
    /// The instant, in nanoseconds, that is 0 in the dump.
    origin: i64,
    /// Waiting changes: instant, then order of arrival.
    waiting: BinaryHeap<Reverse<(u64, u64, PendingChange)>>,
    arrived: u64,
    now: u64,
}

/// A change in the heap, with the earliest instant at which it may have happened; ordered only so that the heap's key is complete.
#[derive(Clone, Copy, Debug)]
struct PendingChange(SignalId, Value, u64);

impl PartialEq for PendingChange {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}
impl Eq for PendingChange {}
impl PartialOrd for PendingChange {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for PendingChange {
    fn cmp(&self, _: &Self) -> std::cmp::Ordering {
        std::cmp::Ordering::Equal
    }
}

impl<'a, W: Write> VcdWriter<'a, W> {
    /// Writes the header; every signal is unknown until its first event. `notes` writes the notes of the trace, which stand in
    /// the header: sigrok reads nothing after a comment among the values.
    fn begin(
        signals: &'a [SignalInfo],
        before: &BeforeWriting,
        rig_version: &str,
        out: W,
        notes: impl FnOnce(&mut Writer<W>) -> io::Result<()>,
    ) -> io::Result<Self> {
        let mut writer = Writer::new(out);
        writer.version(&word(&format!("rig {rig_version}")).replace('_', " "))?;
        for info in signals.iter().filter(|info| !info.labels.is_empty()) {
            let labels: Vec<String> =
                info.labels.iter().map(|(n, label)| format!("{n}={}", word(label))).collect();
            writer.comment(&format!("{}: {}", word(&info.name), labels.join(" ")))?;
        }
        notes(&mut writer)?;
        let names = names(signals);
        for (info, name) in signals.iter().zip(&names).filter(|_| before.says_recording) {
            writer.comment(&format!("recorded {name} {}", SignalRecording::of(info)))?;
        }
        if before.origin != 0 {
            writer.comment(&format!("origin {} ns", before.origin))?;
        }
        let beside: Vec<Option<String>> = (signals.iter().zip(&names).zip(&before.measured))
            .map(|((info, name), measured)| beside(info, *measured, name, &names))
            .collect();
        for (name, beside) in names.iter().zip(&beside) {
            if let Some(beside) = beside {
                writer.comment(&format!("uncertainty {beside} {name}"))?;
            }
        }
        writer.timescale(1, TimescaleUnit::NS)?;
        writer.add_module("rig")?;
        let mut codes = Vec::with_capacity(signals.len());
        for (info, name) in signals.iter().zip(&names) {
            codes.push(match info.kind {
                ValueKind::Bool => writer.add_wire(1, name)?,
                ValueKind::Real => writer.add_var(VarType::Real, 64, name, None)?,
                ValueKind::Int | ValueKind::Word | ValueKind::State | ValueKind::Mark => {
                    writer.add_wire(64, name)?
                }
            });
        }
        let mut uncertainties = Vec::with_capacity(signals.len());
        for name in &beside {
            uncertainties.push(match name {
                Some(name) => Some((writer.add_var(VarType::Real, 64, name, None)?, 0.0)),
                None => None,
            });
        }
        writer.upscope()?;
        writer.enddefinitions()?;
        writer.timestamp(0)?;
        writer.begin(SimulationCommand::Dumpvars)?;
        for (info, code) in signals.iter().zip(&codes) {
            match info.kind {
                ValueKind::Bool => writer.change_scalar(*code, vcd::Value::X)?,
                ValueKind::Real => {}
                ValueKind::Int | ValueKind::Word | ValueKind::State | ValueKind::Mark => {
                    unknown_vector(&mut writer, *code)?
                }
            }
        }
        writer.end()?;
        let widest = vec![0; signals.len()];
        Ok(VcdWriter {
            writer,
            signals,
            codes,
            names,
            uncertainties,
            widest,
            origin: before.origin,
            waiting: BinaryHeap::new(),
            arrived: 0,
            now: 0,
        })
    }

    /// Takes one event, in the order of the trace.
    ///
    /// # Errors
    /// Those of the output.
    pub fn push(&mut self, event: &Event) -> io::Result<()> {
        let since_origin = |at: Time| u64::try_from(i128::from(at.as_nanos()) - i128::from(self.origin));
        let [earliest, latest] = [event.at.earliest, event.at.latest].map(|at| since_origin(at).unwrap_or(0));
        let change = PendingChange(event.signal, event.value, earliest);
        self.waiting.push(Reverse((latest, self.arrived, change)));
        self.arrived += 1;
        if self.waiting.len() > REORDER { self.write_next() } else { Ok(()) }
    }

    /// Writes what is waiting, how well the changes are known where that is not exactly, and flushes.
    ///
    /// # Errors
    /// Those of the output.
    pub fn finish(mut self) -> io::Result<()> {
        while !self.waiting.is_empty() {
            self.write_next()?;
        }
        for (name, width) in self.names.iter().zip(&self.widest).filter(|(_, width)| **width > 0) {
            self.writer.comment(&format!("widest {name} {width} ns"))?;
        }
        self.writer.comment("complete")?;
        self.writer.flush()
    }

    fn write_next(&mut self) -> io::Result<()> {
        let Some(Reverse((at, _, PendingChange(id, value, earliest)))) = self.waiting.pop() else {
            return Ok(());
        };
        let place = id.0 as usize;
        let (Some(info), Some(&code)) = (self.signals.get(place), self.codes.get(place)) else {
            return Ok(());
        };
        let at = at.max(self.now);
        if self.now != at {
            self.writer.timestamp(at)?;
            self.now = at;
        }
        // By where the change stands, which is later than its latest instant where it came too late to be put in order.
        self.widest[place] = self.widest[place].max(at - earliest);
        match info.kind {
            ValueKind::Bool => self.writer.change_scalar(code, scalar(value)),
            ValueKind::Real => {
                // First how well it is known: a reader has both when the number changes.
                if let Some(Some((code, last))) = self.uncertainties.get_mut(place)
                    && value.uncertainty() != *last
                {
                    *last = value.uncertainty();
                    self.writer.change_real(*code, *last)?;
                }
                self.writer.change_real(code, value.as_real().unwrap_or(f64::NAN))
            }
            ValueKind::Int | ValueKind::Word | ValueKind::State | ValueKind::Mark => match value.as_int() {
                // The low 64 bits: an Int as two's complement, a Word as it is.
                Some(n) => write_vector(self.writer.writer(), n, code),
                None => unknown_vector(&mut self.writer, code),
            },
        }
    }
}

/// A change of a vector of 64 bits. The library formats bit by bit, which is a third of the time of a report of waves.
fn write_vector(out: &mut impl Write, value: i128, code: IdCode) -> io::Result<()> {
    let mut bits = [b'b'; 65];
    for (place, bit) in bits[1..].iter_mut().rev().enumerate() {
        *bit = b'0' + u8::from(value >> place & 1 == 1);
    }
    out.write_all(&bits)?;
    writeln!(out, " {code}")
}

/// A text as a comment can hold it, which ends at `$end` and loses blanks at its ends: `\n`, `\r`, `\t`, `\d` for a dollar, `\s` for
/// a blank at either end, `\\`.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for (at, c) in text.char_indices() {
        match c {
            ' ' if at == 0 || at + 1 == text.len() => out.push_str("\\s"),
            '\n' => out.push_str("\\n"),
            '\r' => out.push_str("\\r"),
            '\t' => out.push_str("\\t"),
            '$' => out.push_str("\\d"),
            '\\' => out.push_str("\\\\"),
            c => out.push(c),
        }
    }
    out
}

/// The names that a dump has for these signals, in their order: each is unique.
pub fn names(signals: &[SignalInfo]) -> Vec<String> {
    let mut taken = BTreeSet::new();
    let unique = |info: &SignalInfo| {
        let stem = word(&info.name);
        let mut name = stem.clone();
        let mut copy = 2;
        while !taken.insert(name.clone()) {
            name = format!("{stem}_{copy}");
            copy += 1;
        }
        name
    };
    signals.iter().map(unique).collect()
}

/// The name of the variable beside a signal with how well its numbers are known; `None` for one that is not measured.
fn beside(info: &SignalInfo, measured: bool, name: &str, names: &[String]) -> Option<String> {
    let has_variable = info.kind == ValueKind::Real && (measured || info.clock != ClockDomain::Virtual);
    has_variable.then(|| {
        let mut beside = format!("{name}_uncertainty");
        while names.contains(&beside) {
            beside.push('_');
        }
        beside
    })
}

fn scalar(value: Value) -> vcd::Value {
    match value {
        Value::HighZ => vcd::Value::Z,
        Value::Unknown => vcd::Value::X,
        other => match other.as_bool() {
            Some(true) => vcd::Value::V1,
            Some(false) => vcd::Value::V0,
            None => vcd::Value::X,
        },
    }
}

/// All bits unknown: one `x` stands for the whole vector.
fn unknown_vector<W: Write>(writer: &mut Writer<W>, code: IdCode) -> io::Result<()> {
    writer.change_vector(code, [vcd::Value::X])
}

/// A name as VCD can hold it: printable ASCII without blanks, `$` (a keyword's first letter) or `[` (a bit
/// select).
fn word(name: &str) -> String {
    let safe = |c: char| if c.is_ascii_graphic() && !matches!(c, '$' | '[' | ']') { c } else { '_' };
    let text: String = name.chars().map(safe).collect();
    if text.is_empty() { "_".to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;
    use signal::{Cause, When};

    fn event(signal: u32, earliest: i64, latest: i64, value: Value) -> Event {
        let at = When::within(Time::from_nanos(earliest), Time::from_nanos(latest));
        Event { signal: SignalId(signal), at, value, cause: Cause::Unknown }
    }

    /// What the reader of the same library sees: (time, reference, value in text).
    fn read(text: &[u8]) -> Vec<(u64, String, String)> {
        let mut parser = vcd::Parser::new(text);
        let header = parser.parse_header().unwrap();
        assert_eq!(header.timescale, Some((1, TimescaleUnit::NS)));
        let scope = header.find_scope(&["rig"]).unwrap();
        let name = |id: IdCode| {
            scope.items.iter().find_map(|item| match item {
                vcd::ScopeItem::Var(var) if var.code == id => Some(var.reference.clone()),
                _ => None,
            })
        };
        let (mut now, mut seen) = (0, Vec::new());
        for command in parser {
            let (id, value) = match command.unwrap() {
                vcd::Command::Timestamp(t) => {
                    assert!(t >= now);
                    now = t;
                    continue;
                }
                vcd::Command::ChangeScalar(id, v) => (id, v.to_string()),
                vcd::Command::ChangeVector(id, v) => (id, v.to_string()),
                vcd::Command::ChangeReal(id, v) => (id, v.to_string()),
                _ => continue,
            };
            seen.push((now, name(id).unwrap(), value));
        }
        seen
    }

    #[test]
    fn every_kind_reads_back() {
        let mut state = SignalInfo::exact("state", ValueKind::State);
        state.labels = vec![(2, "RUNNING $end".into())];
        let signals = [
            SignalInfo::exact("HSC0.out0", ValueKind::Bool),
            state,
            SignalInfo::exact("level $end", ValueKind::Real),
            SignalInfo::exact("level__end", ValueKind::Int),
        ];
        let events = [
            event(0, 5, 5, Value::Bool(true)),
            event(1, 7, 7, Value::Int(2)),
            event(2, 7, 7, Value::Real(21.5)),
            event(3, 8, 8, Value::Int(-1)),
            event(0, 9, 9, Value::HighZ),
            event(0, 10, 10, Value::Unknown),
            event(9, 10, 10, Value::Bool(true)),
        ];
        let mut out = Vec::new();
        write(&signals, &events, "0.1.0", &mut out).unwrap();
        let seen = read(&out);
        let after: Vec<_> =
            seen.iter().filter(|(at, ..)| *at > 0).map(|(at, n, v)| (*at, n.as_str(), v.as_str())).collect();
        let (two, minus) = (format!("{:064b}", 2), "1".repeat(64));
        assert_eq!(
            after,
            [
                (5, "HSC0.out0", "1"),
                (7, "state", two.as_str()),
                (7, "level__end", "21.5"),
                (8, "level__end_2", minus.as_str()),
                (9, "HSC0.out0", "z"),
                (10, "HSC0.out0", "x"),
            ]
        );
    }

    #[test]
    fn a_trace_and_its_events_write_the_same_dump() {
        let mut trace = Trace::new();
        let id = trace.define(SignalInfo::exact("lamp", ValueKind::Bool)).unwrap();
        let events = [event(id.0, 5, 5, Value::Bool(true)), event(id.0, 9, 12, Value::Bool(false))];
        for event in events {
            trace.push(event).unwrap();
        }
        let (mut whole, mut parts) = (Vec::new(), Vec::new());
        write_waves(&trace, "0.1.0", &mut whole).unwrap();
        write(trace.signals(), &events, "0.1.0", &mut parts).unwrap();
        assert_eq!(whole, parts);
        assert_eq!(read(&whole).last().map(|(at, _, v)| (*at, v.as_str())), Some((12, "0")));
    }

    #[test]
    fn a_number_that_was_measured_has_its_uncertainty_beside_it() {
        let clock = ClockDomain::Monotonic;
        let signals = [
            SignalInfo { clock, ..SignalInfo::exact("u", ValueKind::Real) },
            SignalInfo { clock, ..SignalInfo::exact("u_uncertainty", ValueKind::Real) },
            SignalInfo::exact("modelled", ValueKind::Real),
        ];
        let events = [
            event(0, 1, 1, Value::measured(3.0, 0.5)),
            event(0, 2, 2, Value::measured(4.0, 0.5)),
            event(0, 3, 3, Value::Unknown),
            event(2, 4, 4, Value::Real(7.0)),
        ];
        let mut out = Vec::new();
        write(&signals, &events, "0.1.0", &mut out).unwrap();
        let text = String::from_utf8_lossy(&out).into_owned();
        assert!(text.contains("uncertainty u_uncertainty_ u\n"), "{text}");
        assert!(!text.contains("modelled_uncertainty"), "{text}");
        let seen: Vec<_> = read(&out).into_iter().map(|(at, n, v)| format!("{at} {n} {v}")).collect();
        assert_eq!(
            seen,
            ["1 u_uncertainty_ 0.5", "1 u 3", "2 u 4", "3 u_uncertainty_ 0", "3 u NaN", "4 modelled 7"]
        );
    }

    #[test]
    fn time_never_runs_backwards() {
        let signals = [SignalInfo::exact("a", ValueKind::Bool), SignalInfo::exact("b", ValueKind::Bool)];
        let events = [
            event(0, -50, -40, Value::Bool(true)),
            event(0, 100, 200, Value::Bool(false)),
            event(1, 120, 120, Value::Bool(true)),
        ];
        let mut out = Vec::new();
        write(&signals, &events, "", &mut out).unwrap();
        let seen: Vec<_> = read(&out).into_iter().skip(2).map(|(at, n, v)| (at, n + &v)).collect();
        // 0 is 50 ns before that of the trace.
        assert_eq!(seen, [(10, "a1".into()), (170, "b1".into()), (250, "a0".into())]);
        assert!(String::from_utf8_lossy(&out).contains("origin -50 ns\n"));
    }
}
