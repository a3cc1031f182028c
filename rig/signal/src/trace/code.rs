//! The encoding of events: each relative to the event before it and to the last one of its signal.
//!
//! ```text
//! varint   signal << 6 | flags           flags: value tag (3 bits), MOVED, WIDE, CAUSE
//! varint   zigzag of the step in `earliest` since the previous event     if MOVED
//! varint   latest - earliest                                             if WIDE
//! value    Int, Word: zigzag varint of the step since the signal's last number; Real: 8 bytes;
//!          Measured: 8 bytes and 4 of its uncertainty
//! cause    tag, then the fields of its kind                              if CAUSE: not the signal's last one
//! ```
//!
//! Every event has exactly one encoding by [`CodecState::encode`], which is what the digest is taken of.

use crate::{Cause, Event, SignalGap, SignalId, Time, Value, When};

/// No event is longer: 6 + 10 + 10 + 12 + 10 bytes.
pub(super) const MAX_EVENT: usize = 48;

const FALSE: u64 = 0;
const TRUE: u64 = 1;
const HIGH_Z: u64 = 2;
const UNKNOWN: u64 = 3;
const INT: u64 = 4;
const WORD: u64 = 5;
const REAL: u64 = 6;
const MEASURED: u64 = 7;
const TAG: u64 = 7;
const MOVED: u64 = 1 << 3;
const WIDE: u64 = 1 << 4;
const CAUSE: u64 = 1 << 5;
const SIGNAL_SHIFT: u32 = 6;

/// What encoding and decoding need to know of the events before.
#[derive(Clone, Debug, Default)]
pub(super) struct CodecState {
    earliest: i64,
    last: Vec<Option<Event>>,
}

/// Why bytes are no event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CodeFault {
    /// They end before the event does.
    Short,
    /// No event is written like this.
    Bad,
}

impl CodecState {
    /// Makes room for one more signal, so that noting its events never allocates.
    pub(super) fn add_signal(&mut self) {
        self.last.push(None);
    }

    #[inline]
    pub(super) fn last(&self, signal: SignalId) -> Option<Event> {
        self.last.get(signal.0 as usize).copied().flatten()
    }

    /// Memory that the state takes.
    pub(super) fn bytes(&self) -> usize {
        self.last.capacity() * size_of::<Option<Event>>()
    }

    /// Takes the event into account. Its place in `last` must exist.
    #[inline]
    pub(super) fn note(&mut self, event: Event) {
        self.earliest = event.at.earliest.as_nanos();
        if let Some(place) = self.last.get_mut(event.signal.0 as usize) {
            *place = Some(event);
        }
    }

    /// Writes the event and returns its length. The state is as before.
    #[inline]
    pub(super) fn encode(&self, event: &Event, out: &mut [u8; MAX_EVENT]) -> usize {
        let last = self.last(event.signal);
        let earliest = event.at.earliest.as_nanos();
        let moved = earliest.wrapping_sub(self.earliest);
        let width = event.at.latest.as_nanos().wrapping_sub(earliest) as u64;
        let tag = match event.value {
            Value::Bool(false) => FALSE,
            Value::Bool(true) => TRUE,
            Value::HighZ => HIGH_Z,
            Value::Unknown => UNKNOWN,
            Value::Int(_) => INT,
            Value::Word(_) => WORD,
            Value::Real(_) => REAL,
            Value::Measured(..) => MEASURED,
        };
        let mut flags = tag;
        if moved != 0 {
            flags |= MOVED;
        }
        if width != 0 {
            flags |= WIDE;
        }
        if event.cause != last_cause(last) {
            flags |= CAUSE;
        }
        let mut writer = Writer { out, at: 0 };
        writer.varint(u64::from(event.signal.0) << SIGNAL_SHIFT | flags);
        if moved != 0 {
            writer.varint(zigzag(moved));
        }
        if width != 0 {
            writer.varint(width);
        }
        match event.value {
            Value::Int(n) => writer.varint(zigzag((n as u64).wrapping_sub(last_number(last)) as i64)),
            Value::Word(n) => writer.varint(zigzag(n.wrapping_sub(last_number(last)) as i64)),
            Value::Real(r) => r.to_bits().to_le_bytes().into_iter().for_each(|byte| writer.byte(byte)),
            Value::Measured(r, uncertainty) => {
                r.to_bits().to_le_bytes().into_iter().for_each(|byte| writer.byte(byte));
                uncertainty.to_bits().to_le_bytes().into_iter().for_each(|byte| writer.byte(byte));
            }
            Value::Bool(_) | Value::HighZ | Value::Unknown => {}
        }
        if flags & CAUSE != 0 {
            match event.cause {
                Cause::Unknown => writer.byte(0),
                Cause::Controller => writer.byte(1),
                Cause::Board => writer.byte(2),
                Cause::Step(step) => {
                    writer.byte(3);
                    writer.varint(u64::from(step));
                }
                Cause::Gap(gap) => {
                    writer.byte(5);
                    writer.byte(match gap {
                        SignalGap::OpenWire => 0,
                        SignalGap::Failed => 1,
                        SignalGap::Below => 2,
                        SignalGap::Above => 3,
                        SignalGap::Delay => 4,
                    });
                }
                Cause::Port(port) => {
                    writer.byte(6);
                    writer.byte(port);
                }
                Cause::Program { task, file, line } => {
                    writer.byte(4);
                    writer.byte(task);
                    writer.varint(u64::from(file));
                    writer.varint(u64::from(line));
                }
            }
        }
        writer.at
    }

    /// Reads the event at the start of `bytes`, takes it into account and returns it with its length.
    pub(super) fn decode(&mut self, bytes: &[u8], signals: usize) -> Result<(Event, usize), CodeFault> {
        let mut reader = CodeReader::new(bytes);
        let head = reader.varint()?;
        let signal = SignalId(u32::try_from(head >> SIGNAL_SHIFT).map_err(|_| CodeFault::Bad)?);
        let place = signal.0 as usize;
        if place >= signals {
            return Err(CodeFault::Bad);
        }
        if place >= self.last.len() {
            // Signals may be defined while the trace is read.
            self.last.resize(signals, None);
        }
        let last = self.last[place];
        let moved = if head & MOVED != 0 { unzigzag(reader.varint()?) } else { 0 };
        let earliest = self.earliest.wrapping_add(moved);
        let width = if head & WIDE != 0 { reader.varint()? } else { 0 };
        let latest = earliest.wrapping_add(width as i64);
        if latest < earliest || (latest.wrapping_sub(earliest) as u64) != width {
            return Err(CodeFault::Bad);
        }
        let value = match head & TAG {
            FALSE => Value::Bool(false),
            TRUE => Value::Bool(true),
            HIGH_Z => Value::HighZ,
            UNKNOWN => Value::Unknown,
            INT => Value::Int(last_number(last).wrapping_add(unzigzag(reader.varint()?) as u64) as i64),
            WORD => Value::Word(last_number(last).wrapping_add(unzigzag(reader.varint()?) as u64)),
            REAL => Value::Real(f64::from_bits(reader.u64()?)),
            _ => {
                let (value, uncertainty) = (f64::from_bits(reader.u64()?), reader.f32()?);
                if !(uncertainty > 0.0 && uncertainty.is_finite()) {
                    return Err(CodeFault::Bad);
                }
                Value::Measured(value, uncertainty)
            }
        };
        let cause = if head & CAUSE == 0 {
            last_cause(last)
        } else {
            match reader.byte()? {
                0 => Cause::Unknown,
                1 => Cause::Controller,
                2 => Cause::Board,
                3 => Cause::Step(u16::try_from(reader.varint()?).map_err(|_| CodeFault::Bad)?),
                4 => Cause::Program {
                    task: reader.byte()?,
                    file: u16::try_from(reader.varint()?).map_err(|_| CodeFault::Bad)?,
                    line: u32::try_from(reader.varint()?).map_err(|_| CodeFault::Bad)?,
                },
                5 => Cause::Gap(*SignalGap::ALL.get(usize::from(reader.byte()?)).ok_or(CodeFault::Bad)?),
                6 => Cause::Port(reader.byte()?),
                _ => return Err(CodeFault::Bad),
            }
        };
        let at = When { earliest: Time::from_nanos(earliest), latest: Time::from_nanos(latest) };
        let event = Event { signal, at, value, cause };
        self.note(event);
        Ok((event, reader.at))
    }

    /// Writes the state itself, from which decoding can start in the middle of a trace.
    pub(super) fn save(&self, out: &mut Vec<u8>) {
        out.extend_from_slice(&self.earliest.to_le_bytes());
        let known = self.last.iter().flatten();
        put_varint(out, known.clone().count() as u64);
        let mut fresh = CodecState { earliest: 0, last: Vec::new() };
        let mut buffer = [0; MAX_EVENT];
        for event in known {
            // Each signal comes once, so that only `earliest` of the fresh state matters.
            let length = fresh.encode(event, &mut buffer);
            out.extend_from_slice(&buffer[..length]);
            fresh.earliest = event.at.earliest.as_nanos();
        }
    }

    /// Reads what [`CodecState::save`] wrote.
    pub(super) fn restore(bytes: &[u8], signals: usize) -> Result<CodecState, CodeFault> {
        let mut reader = CodeReader::new(bytes);
        let earliest = reader.u64()? as i64;
        let known = reader.varint()?;
        let mut state = CodecState { earliest: 0, last: vec![None; signals] };
        let mut at = reader.at;
        for _ in 0..known {
            at += state.decode(&bytes[at..], signals)?.1;
        }
        state.earliest = earliest;
        Ok(state)
    }
}

#[inline]
fn last_cause(last: Option<Event>) -> Cause {
    last.map_or(Cause::Unknown, |event| event.cause)
}

#[inline]
fn last_number(last: Option<Event>) -> u64 {
    match last {
        Some(Event { value: Value::Int(n), .. }) => n as u64,
        Some(Event { value: Value::Word(n), .. }) => n,
        _ => 0,
    }
}

const fn zigzag(n: i64) -> u64 {
    ((n << 1) ^ (n >> 63)) as u64
}

const fn unzigzag(n: u64) -> i64 {
    (n >> 1) as i64 ^ -((n & 1) as i64)
}

/// Writes into a buffer that is long enough for every event.
struct Writer<'a> {
    out: &'a mut [u8; MAX_EVENT],
    at: usize,
}

impl Writer<'_> {
    #[inline]
    fn byte(&mut self, byte: u8) {
        self.out[self.at] = byte;
        self.at += 1;
    }

    #[inline]
    fn varint(&mut self, mut n: u64) {
        while n >= 0x80 {
            self.byte(n as u8 | 0x80);
            n >>= 7;
        }
        self.byte(n as u8);
    }
}

/// Appends a varint.
pub(super) fn put_varint(out: &mut Vec<u8>, mut n: u64) {
    while n >= 0x80 {
        out.push(n as u8 | 0x80);
        n >>= 7;
    }
    out.push(n as u8);
}

/// Appends a text with its length.
pub(super) fn put_text(out: &mut Vec<u8>, text: &str) {
    put_varint(out, text.len() as u64);
    out.extend_from_slice(text.as_bytes());
}

/// Reads numbers and texts from bytes of any origin.
pub(super) struct CodeReader<'a> {
    bytes: &'a [u8],
    pub(super) at: usize,
}

impl<'a> CodeReader<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        CodeReader { bytes, at: 0 }
    }

    #[inline]
    pub(super) fn byte(&mut self) -> Result<u8, CodeFault> {
        let byte = *self.bytes.get(self.at).ok_or(CodeFault::Short)?;
        self.at += 1;
        Ok(byte)
    }

    #[inline]
    pub(super) fn varint(&mut self) -> Result<u64, CodeFault> {
        let first = self.byte()?;
        if first < 0x80 { Ok(u64::from(first)) } else { self.varint_from(u64::from(first & 0x7f)) }
    }

    fn varint_from(&mut self, mut n: u64) -> Result<u64, CodeFault> {
        let mut shift = 7;
        loop {
            let byte = self.byte()?;
            let bits = u64::from(byte & 0x7f);
            if shift == 63 && bits > 1 {
                return Err(CodeFault::Bad);
            }
            n |= bits << shift;
            if byte < 0x80 {
                return Ok(n);
            }
            shift += 7;
            if shift > 63 {
                return Err(CodeFault::Bad);
            }
        }
    }

    pub(super) fn take(&mut self, length: usize) -> Result<&'a [u8], CodeFault> {
        let end = self.at.checked_add(length).ok_or(CodeFault::Short)?;
        let taken = self.bytes.get(self.at..end).ok_or(CodeFault::Short)?;
        self.at = end;
        Ok(taken)
    }

    pub(super) fn u64(&mut self) -> Result<u64, CodeFault> {
        let mut bytes = [0; 8];
        bytes.copy_from_slice(self.take(8)?);
        Ok(u64::from_le_bytes(bytes))
    }

    fn f32(&mut self) -> Result<f32, CodeFault> {
        let mut bytes = [0; 4];
        bytes.copy_from_slice(self.take(4)?);
        Ok(f32::from_le_bytes(bytes))
    }

    pub(super) fn text(&mut self) -> Result<&'a str, CodeFault> {
        let length = usize::try_from(self.varint()?).map_err(|_| CodeFault::Short)?;
        std::str::from_utf8(self.take(length)?).map_err(|_| CodeFault::Bad)
    }

    pub(super) fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at.min(self.bytes.len())..]
    }
}
