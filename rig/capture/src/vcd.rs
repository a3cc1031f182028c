//! Value change dumps.
//!
//! A change at a timestamp lies within the timescale before or after it; within the time between two samples where the file
//! (sigrok's comment) or the user says it. A dump of the rig itself says in comments what its trace knew: `reports::vcd` has
//! them one by one.

use crate::builder::{CaptureBuilder, FEWER, too_many_changes, too_many_channels};
use crate::time::{hertz, period as period_of, ticks};
use crate::{Capture, CaptureError, ChannelType, Knowledge};
use signal::{SignalRecording, Span, Time, Value, When};
use std::collections::BTreeMap;
use std::io::Read;
use vcd::{Command, IdCode, Parser, SimulationCommand, TimescaleUnit, VarType};

/// What a dump of the rig's own begins its version with.
const OWN: &str = "rig ";

/// What to do about a dump of the rig's own that does not say everything.
const AGAIN: &str = "name the trace beside it, or write it again: rig report RUN --out DIR --format vcd";

/// Reads a dump. Of one of the rig's own `period` is not asked: it says itself what is known.
///
/// # Errors
/// [`CaptureError`] with the line.
pub fn read(bytes: &[u8], period: Option<Span>) -> Result<Capture, CaptureError> {
    let mut reader = VcdReader {
        period,
        femtoseconds: 1_000_000,
        codes: BTreeMap::new(),
        builder: CaptureBuilder::default(),
        first: None,
        now: (Time::ZERO, Time::ZERO),
        ticks: 0,
        sampled: None,
        own: false,
        notes: Vec::new(),
        widest: BTreeMap::new(),
        beside: BTreeMap::new(),
        uncertainties: BTreeMap::new(),
        recordings: BTreeMap::new(),
        origin: Span::ZERO,
        complete: false,
        initial: false,
        defined: false,
    };
    // The last word ends with the file, too.
    let mut parser = Parser::new(bytes.chain(&b"\n"[..]));
    loop {
        match parser.next() {
            None => break,
            Some(Ok(command)) => {
                reader.take(command).map_err(|(what, fix)| CaptureError::line(parser.line(), what, fix))?
            }
            Some(Err(error)) => {
                let what = format!("no value change dump: {}", plain(&error));
                return Err(CaptureError::line(parser.line(), what, "write it again with the instrument"));
            }
        }
    }
    reader.finish()
}

/// The reason without the line, which the place says.
fn plain(error: &std::io::Error) -> String {
    match error.get_ref().and_then(|inner| inner.downcast_ref::<vcd::ParseError>()) {
        Some(parse) => parse.kind().to_string(),
        None => error.to_string(),
    }
}

struct VcdReader {
    period: Option<Span>,
    femtoseconds: u64,
    /// The channels of a code: one code may stand for several names.
    codes: BTreeMap<IdCode, Vec<u32>>,
    builder: CaptureBuilder,
    first: Option<Time>,
    /// The instant, as the nanoseconds at or before and at or after it.
    now: (Time, Time),
    ticks: u64,
    sampled: Option<Span>,
    own: bool,
    notes: Vec<(String, String)>,
    /// How wide the changes of a channel are at most, by name.
    widest: BTreeMap<String, i64>,
    /// The variables that have how well a channel's numbers are known, by name: the name of the channel.
    beside: BTreeMap<String, String>,
    /// The name of the channel by the code of such a variable, and what it has.
    uncertainties: BTreeMap<IdCode, (String, f64)>,
    /// How the trace recorded each signal, by the name of its variable.
    recordings: BTreeMap<String, SignalRecording>,
    /// The instant of the trace at which the dump has 0.
    origin: Span,
    /// Whether the comment that ends a dump of the rig's own has come.
    complete: bool,
    /// Whether what comes is what every variable is before the first change.
    initial: bool,
    defined: bool,
}

type Wrong = (String, &'static str);

impl VcdReader {
    fn take(&mut self, command: Command) -> Result<(), Wrong> {
        match command {
            Command::Comment(text) => self.comment(&text)?,
            Command::Version(text) => self.own = text.starts_with(OWN),
            Command::Timescale(number, unit) => {
                let wrong = || (String::from("a timescale of 0"), "write 1, 10 or 100 and a unit");
                self.femtoseconds = u64::from(number).checked_mul(femtoseconds(unit)).ok_or_else(wrong)?;
                if self.femtoseconds == 0 {
                    return Err(wrong());
                }
            }
            Command::VarDef(kind, width, code, name, index) => {
                let name = index.map_or_else(|| name.clone(), |index| format!("{name}{index}"));
                if let Some(of) = self.beside.get(&name).filter(|_| self.own) {
                    self.uncertainties.insert(code, (of.clone(), 0.0));
                    return Ok(());
                }
                let shape = match (kind, width) {
                    (VarType::Real, _) => ChannelType::Real,
                    (_, 1) => ChannelType::Bit,
                    _ => ChannelType::Whole,
                };
                // A variable that is declared again, in another scope, is the same channel.
                let declared = self.codes.get(&code).map_or(&[][..], Vec::as_slice);
                if declared.iter().any(|known| self.builder.channels[*known as usize].name == name) {
                    return Ok(());
                }
                let channel = self.builder.channel(&name, "", shape);
                let channel = channel.ok_or_else(|| (too_many_channels(), "dump fewer"))?;
                if self.own {
                    self.builder.channels[channel as usize].recording = self.recordings.get(&name).copied();
                }
                self.codes.entry(code).or_default().push(channel);
            }
            Command::Enddefinitions => self.defined = true,
            Command::Timestamp(at) => {
                if at < self.ticks {
                    return Err((
                        format!("time runs backwards to #{at}"),
                        "put the changes in order of time",
                    ));
                }
                self.ticks = at;
                let wrong = || (format!("#{at} is beyond 292 years"), "check the timescale");
                let (below, above) = ticks(at, self.femtoseconds).ok_or_else(wrong)?;
                self.now = (below.saturating_add(self.origin), above.saturating_add(self.origin));
                self.first.get_or_insert(self.now.0);
            }
            Command::Begin(SimulationCommand::Dumpvars) => self.initial = true,
            Command::End(SimulationCommand::Dumpvars) => self.initial = false,
            Command::ChangeScalar(code, value) => self.change(code, scalar(value))?,
            Command::ChangeVector(code, bits) => self.change(code, vector(&bits)?)?,
            Command::ChangeReal(code, real) => {
                if let Some((_, known)) = self.uncertainties.get_mut(&code) {
                    *known = real;
                    return Ok(());
                }
                let value = match real {
                    real if real.is_finite() => self.measured(code, real),
                    // A program can compute it.
                    real if self.own && real.is_infinite() => Value::Real(real),
                    _ => Value::Unknown,
                };
                self.change(code, value)?;
            }
            // Texts have no meaning for a plan; scopes and dates need none.
            _ => {}
        }
        Ok(())
    }

    /// A number with how well it is known, where a variable beside it says that.
    fn measured(&self, code: IdCode, real: f64) -> Value {
        let channels = self.codes.get(&code).map_or(&[][..], Vec::as_slice);
        let names = channels.iter().filter_map(|channel| self.builder.channels.get(*channel as usize));
        let known = names
            .filter_map(|channel| self.uncertainties.values().find(|(of, _)| *of == channel.name))
            .map(|(_, known)| *known);
        match known.reduce(f64::max) {
            None => Value::Real(real),
            Some(known) if known >= 0.0 && known.is_finite() => match Value::measured(real, known) {
                // More than can be kept: the truth may be anything.
                Value::Real(_) if known > 0.0 => Value::Unknown,
                value => value,
            },
            Some(_) => Value::Unknown,
        }
    }

    fn comment(&mut self, text: &str) -> Result<(), Wrong> {
        if let Some(rest) = text.strip_prefix("Acquisition with ") {
            self.sampled = rest.rsplit_once(" at ").and_then(|(_, rate)| hertz(rate)).map(period_of);
        }
        let mut words = text.splitn(3, ' ');
        match (words.next(), words.next(), words.next()) {
            (Some("note"), Some(key), value) => {
                self.notes.push((unescaped(key), unescaped(value.unwrap_or_default())));
            }
            (Some("recorded"), Some(name), how) if self.own && !self.defined => {
                let how = how.and_then(SignalRecording::parse);
                let how = how.ok_or_else(|| (format!("no words on how `{name}` was recorded"), AGAIN))?;
                self.recordings.insert(name.to_owned(), how);
            }
            (Some("origin"), Some(nanos), Some("ns")) if self.own && !self.defined => {
                let nanos = nanos.parse().map_err(|_| (format!("`{nanos}` is no origin"), AGAIN))?;
                self.origin = Span::from_nanos(nanos);
            }
            (Some("complete"), None, None) => self.complete = true,
            (Some("uncertainty"), Some(beside), Some(name)) if !self.defined => {
                self.beside.insert(beside.to_owned(), name.to_owned());
            }
            (Some("widest"), Some(name), Some(width)) => {
                let width = width.strip_suffix(" ns").and_then(|width| width.parse().ok());
                // A width that cannot be read is as wide as can be, lest a claim passes by it.
                self.widest.insert(name.to_owned(), width.filter(|ns| *ns >= 0).unwrap_or(i64::MAX));
            }
            _ => {}
        }
        Ok(())
    }

    fn change(&mut self, code: IdCode, value: Value) -> Result<(), Wrong> {
        let channels = self.codes.get(&code).cloned();
        let channels = channels.ok_or_else(|| {
            (format!("`{code}` is declared nowhere"), "declare it with $var before $enddefinitions")
        })?;
        // A dump of the rig's own is unknown everywhere until its trace says something, that it is not known among it.
        if self.own && self.initial {
            return Ok(());
        }
        for channel in channels {
            // The width of what came before is known only at the end; see `finish`.
            let at = When::within(self.now.0, self.now.1);
            let room = match self.own {
                true => self.builder.change_or_unknown(channel, at, value),
                false => self.builder.change(channel, at, value),
            };
            if !room {
                return Err((too_many_changes(), FEWER));
            }
        }
        Ok(())
    }

    fn finish(self) -> Result<Capture, CaptureError> {
        if !self.defined {
            let fix = "a value change dump has declarations and `$enddefinitions $end`";
            return Err(CaptureError::whole("no value change dump: its header does not end", fix));
        }
        if !self.recordings.is_empty() && !self.complete {
            return Err(CaptureError::whole(
                "the dump is cut off: the comment that ends it is not there",
                AGAIN,
            ));
        }
        let unit = Span::from_nanos(i64::try_from(self.femtoseconds.div_ceil(1_000_000)).unwrap_or(i64::MAX));
        let knowledge = match self.period.or(self.sampled) {
            _ if self.own => Knowledge::Own,
            Some(period) => Knowledge::Sampled(period),
            None => Knowledge::Edges(unit),
        };
        let CaptureBuilder { channels, mut changes, .. } = self.builder;
        let first = self.first.unwrap_or_default();
        let widths: Vec<i64> = channels
            .iter()
            .map(|channel| match knowledge {
                Knowledge::Own => self.widest.get(&channel.name).copied().unwrap_or(0),
                Knowledge::Edges(width) | Knowledge::Sampled(width) => width.as_nanos(),
            })
            .collect();
        for change in &mut changes {
            // At the first instant nothing is known of what was before.
            if change.at.latest > first {
                // One tool rounds an instant to its timestamp, another cuts off what is less.
                if let Knowledge::Edges(width) = knowledge {
                    change.at.latest = change.at.latest.saturating_add(width);
                }
                let earliest = change.at.earliest.as_nanos().saturating_sub(widths[change.channel as usize]);
                change.at.earliest = Time::from_nanos(earliest.max(first.as_nanos()));
            }
        }
        Ok(Capture {
            channels,
            changes,
            knowledge,
            span: [first, self.now.1],
            end: When::exactly(self.now.1),
            notes: self.notes,
        })
    }
}

/// A text of a comment as it was before the rig wrote it.
fn unescaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text.chars();
    while let Some(c) = rest.next() {
        match c {
            '\\' => match rest.next() {
                Some('n') => out.push('\n'),
                Some('r') => out.push('\r'),
                Some('t') => out.push('\t'),
                Some('d') => out.push('$'),
                Some('s') => out.push(' '),
                Some(c) => out.push(c),
                None => {}
            },
            c => out.push(c),
        }
    }
    out
}

fn scalar(value: vcd::Value) -> Value {
    match value {
        vcd::Value::V0 => Value::Bool(false),
        vcd::Value::V1 => Value::Bool(true),
        vcd::Value::Z => Value::HighZ,
        vcd::Value::X => Value::Unknown,
    }
}

/// A vector as a number of at most 64 bits; one that is not known in every bit is not known.
fn vector(bits: &vcd::Vector) -> Result<Value, Wrong> {
    let mut number = 0u64;
    let mut high = bits.iter();
    if bits.len() > 64 {
        // What is beyond 64 bits may only be 0.
        let beyond = bits.len() - 64;
        if high.by_ref().take(beyond).any(|bit| bit == vcd::Value::V1) {
            let what = format!("a value of {} bits", bits.len());
            return Err((what, "numbers have at most 64 bits: dump the parts that matter"));
        }
    }
    for bit in high {
        match bit {
            vcd::Value::V0 => number <<= 1,
            vcd::Value::V1 => number = number << 1 | 1,
            vcd::Value::X | vcd::Value::Z => return Ok(Value::Unknown),
        }
    }
    Ok(Value::Word(number))
}

const fn femtoseconds(unit: TimescaleUnit) -> u64 {
    match unit {
        TimescaleUnit::FS => 1,
        TimescaleUnit::PS => 1_000,
        TimescaleUnit::NS => 1_000_000,
        TimescaleUnit::US => 1_000_000_000,
        TimescaleUnit::MS => 1_000_000_000_000,
        TimescaleUnit::S => 1_000_000_000_000_000,
    }
}
