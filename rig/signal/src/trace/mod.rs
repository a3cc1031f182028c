//! The trace: every change of every signal, in the order in which the changes became known.
//!
//! It is the only ground for a verdict, so it can be read while it grows, it has a digest that two equal
//! runs share, and a file that repeats it exactly. Events are kept encoded, about six bytes for a change
//! of a Boolean, in segments of which all but the newest can be moved out of memory.

mod code;
mod error;
mod file;
mod info;
mod policy;
mod read;
mod segment;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::fmt;

use sha2::{Digest, Sha256};

use crate::{Cause, Event, Policy, SignalId, SignalInfo, Time, Value, ValueKind, When};
use code::{CodecState, MAX_EVENT};
use policy::HeldChange;
use segment::Segments;

pub use error::{TraceError, TraceTransfer};
pub use file::LoadLimits;
pub use read::{Cursor, Events, EventsBetween};
pub use segment::Spill;

/// The most signals that a trace defines.
pub const MAX_SIGNALS: usize = 65_536;

/// Length of a segment where nothing asks for a shorter one.
const SEGMENT_BYTES: usize = 64 * 1024;

/// The one record of what happened: defined signals, their events, and notes about where it comes from.
pub struct Trace {
    signals: Vec<SignalInfo>,
    names: BTreeMap<String, SignalId>,
    notes: BTreeMap<String, String>,
    /// Memory taken by `signals`, `names` and `notes`, roughly.
    described_bytes: usize,
    state: CodecState,
    waiting: HeldChange,
    segments: Segments,
    events: u64,
    /// Of the stream of all closed segments.
    hasher: Sha256,
    /// Why no more events are taken.
    broken: Option<TraceError>,
}

impl Default for Trace {
    fn default() -> Self {
        Trace::new()
    }
}

impl fmt::Debug for Trace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Trace")
            .field("signals", &self.signals.len())
            .field("events", &self.events)
            .field("segments", &self.segments.count())
            .field("broken", &self.broken)
            .finish_non_exhaustive()
    }
}

impl Trace {
    /// A trace held in memory, whatever its length: for short cases.
    pub fn new() -> Trace {
        Trace::segmented(SEGMENT_BYTES, usize::MAX, None)
    }

    /// A trace whose segments move to `store`, an empty file, while they take more than `bound_bytes` of memory.
    ///
    /// The segment that grows stays in memory, half a kilobyte at least, so the least useful bound is some tens of
    /// kilobytes: segments are a quarter of it and at most 64 KiB long, and what is remembered of each stored one takes
    /// about a hundred bytes.
    pub fn with_spill(bound_bytes: usize, store: Box<dyn Spill>) -> Trace {
        Trace::segmented((bound_bytes / 4).clamp(512, SEGMENT_BYTES), bound_bytes, Some(store))
    }

    fn segmented(segment_bytes: usize, bound: usize, store: Option<Box<dyn Spill>>) -> Trace {
        Trace {
            signals: Vec::new(),
            names: BTreeMap::new(),
            notes: BTreeMap::new(),
            described_bytes: 0,
            state: CodecState::default(),
            waiting: HeldChange::new(),
            segments: Segments::new(segment_bytes, bound, store),
            events: 0,
            hasher: Sha256::new(),
            broken: None,
        }
    }

    /// Defines the next signal; also while events are recorded.
    ///
    /// # Errors
    /// [`TraceError::DuplicateName`], [`TraceError::TooManySignals`].
    pub fn define(&mut self, info: SignalInfo) -> Result<SignalId, TraceError> {
        if let Some(other) = self.names.get(&info.name) {
            return Err(TraceError::DuplicateName(*other));
        }
        if self.signals.len() >= MAX_SIGNALS {
            return Err(TraceError::TooManySignals);
        }
        let id = SignalId(self.signals.len() as u32);
        self.described_bytes += info::info_bytes(&info);
        if matches!(info.policy, Policy::AtMostEvery(_)) {
            self.waiting.add_signal();
        }
        self.names.insert(info.name.clone(), id);
        self.signals.push(info);
        self.state.add_signal();
        Ok(id)
    }

    /// All signals; a signal's [`SignalId`] is its place.
    pub fn signals(&self) -> &[SignalInfo] {
        &self.signals
    }

    /// The signal of this name.
    pub fn find(&self, name: &str) -> Option<SignalId> {
        self.names.get(name).copied()
    }

    /// Sets a note about the trace, such as the plan's path or `task:0`'s name. Notes are not part of the digest.
    pub fn set_note(&mut self, key: &str, value: String) {
        self.described_bytes += value.len();
        match self.notes.get_mut(key) {
            Some(place) => {
                self.described_bytes -= place.len();
                *place = value;
            }
            None => {
                self.described_bytes += note_bytes(key);
                self.notes.insert(key.to_string(), value);
            }
        }
    }

    /// The note of this key.
    pub fn note(&self, key: &str) -> Option<&str> {
        self.notes.get(key).map(String::as_str)
    }

    /// All notes, sorted by key.
    pub fn notes(&self) -> impl Iterator<Item = (&str, &str)> {
        self.notes.iter().map(|(key, value)| (key.as_str(), value.as_str()))
    }

    /// Records an event and returns it as the trace has it; `None` if it is none: the signal has this value already
    /// (a [`ValueKind::Mark`] excepted, and a value that is now unknown for another reason), or its [`Policy`] drops it. A signal's first value is always kept.
    ///
    /// # Errors
    /// [`TraceError::UnknownSignal`]; [`TraceError::Io`] if a full segment cannot be stored, and from then on
    /// for every event: a trace with a hole is none.
    pub fn push(&mut self, event: Event) -> Result<Option<Event>, TraceError> {
        let Some(info) = self.signals.get(event.signal.0 as usize) else {
            return Err(TraceError::UnknownSignal(event.signal));
        };
        if let Some(error) = self.broken {
            return Err(error);
        }
        let last = self.state.last(event.signal);
        let admitted = match (info.kind, info.policy) {
            (ValueKind::Mark, _) => return self.append(event).map(Some),
            (_, Policy::AtMostEvery(span)) => self.waiting.admit(info, span, last, event),
            (_, policy) => last.is_none_or(|last| policy::keeps(policy, last, &event)).then_some(event),
        };
        match admitted {
            Some(event) if last.is_none_or(|last| is_news(&last, &event)) => self.append(event).map(Some),
            _ => Ok(None),
        }
    }

    /// Records an event that another trace has kept, as it has it: the signal's [`Policy`] is not asked once more.
    ///
    /// # Errors
    /// As [`Trace::push`].
    pub fn push_kept(&mut self, event: Event) -> Result<Option<Event>, TraceError> {
        let Some(info) = self.signals.get(event.signal.0 as usize) else {
            return Err(TraceError::UnknownSignal(event.signal));
        };
        if let Some(error) = self.broken {
            return Err(error);
        }
        match self.state.last(event.signal) {
            Some(last) if info.kind != ValueKind::Mark && !is_news(&last, &event) => Ok(None),
            _ => self.append(event).map(Some),
        }
    }

    /// Records a value that [`Policy::AtMostEvery`] kept waiting until before `now`, and returns it; `None` if there
    /// is none left. Due before an event at `now` is pushed: until then the trace says that the value is not known.
    ///
    /// # Errors
    /// As [`Trace::push`].
    #[inline]
    pub fn settle(&mut self, now: Time) -> Result<Option<Event>, TraceError> {
        while let Some(event) = self.waiting.take(now) {
            if let Some(error) = self.broken {
                return Err(error);
            }
            if self.state.last(event.signal).is_none_or(|last| last.value != event.value) {
                return self.append(event).map(Some);
            }
        }
        Ok(None)
    }

    fn append(&mut self, event: Event) -> Result<Event, TraceError> {
        let event = Event { at: When::within(event.at.earliest, event.at.latest), ..event };
        let mut buffer = [0; MAX_EVENT];
        let length = self.state.encode(&event, &mut buffer);
        self.state.note(event);
        self.events += 1;
        if self.segments.append(&buffer, length, event.at) {
            self.hasher.update(self.segments.open_stream());
            if let Err(error) = self.segments.close(&self.state) {
                self.broken = Some(error);
                return Err(error);
            }
        }
        Ok(event)
    }

    /// The last recorded event of a signal.
    pub fn last(&self, id: SignalId) -> Option<Event> {
        self.state.last(id)
    }

    /// Number of recorded events.
    pub fn len(&self) -> u64 {
        self.events
    }

    /// Whether no event has been recorded.
    pub fn is_empty(&self) -> bool {
        self.events == 0
    }

    /// Memory that the trace takes, in bytes: events, definitions and notes.
    pub fn bytes_in_memory(&self) -> usize {
        self.segments.bytes_in_memory() + self.state.bytes() + self.waiting.bytes() + self.described_bytes
    }

    /// SHA-256 over the definitions and all events, the same for equal traces however they are held in memory.
    pub fn digest(&self) -> [u8; 32] {
        let mut stream = self.hasher.clone();
        stream.update(self.segments.open_stream());
        let mut all = Sha256::new();
        let mut definition = Vec::new();
        for info in &self.signals {
            definition.clear();
            info::put_info(&mut definition, info);
            all.update((definition.len() as u64).to_le_bytes());
            all.update(&definition);
        }
        // A definition is never this long, so that the definitions end unmistakably.
        all.update(u64::MAX.to_le_bytes());
        all.update(self.events.to_le_bytes());
        all.update(stream.finalize());
        all.finalize().into()
    }

    /// All events from the beginning, in the order in which they became known.
    pub fn events(&self) -> Events<'_> {
        Events::all(self)
    }

    /// The events after the cursor, which moves along: for reading a trace while it grows.
    pub fn since<'a>(&'a self, cursor: &'a mut Cursor) -> Events<'a> {
        Events::since(self, cursor)
    }

    /// The events whose interval touches `[from, to]`, and the values of all signals before.
    ///
    /// # Errors
    /// [`TraceError::Io`] or [`TraceError::SpillDamaged`] if a stored segment cannot be read.
    pub fn between(&self, from: Time, to: Time) -> Result<EventsBetween<'_>, TraceError> {
        EventsBetween::new(self, from, to)
    }
}

/// Whether an event says what the last one of its signal did not: another value, or another reason why there is none.
#[inline]
fn is_news(last: &Event, event: &Event) -> bool {
    let another = |event: &Event| matches!(event.cause, Cause::Gap(_)) && last.cause != event.cause;
    last.value != event.value || matches!(event.value, Value::Unknown) && another(event)
}

/// Memory taken by a note of this key, its value excepted.
fn note_bytes(key: &str) -> usize {
    key.len() + 2 * size_of::<String>() + 32
}
