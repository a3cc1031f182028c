//! Reading a trace: from the beginning, from where a cursor stands, or a window of time.

use super::Trace;
use super::code::CodecState;
use super::error::TraceError;
use super::segment::Fetched;
use crate::{Event, SignalId, Time};

/// A place in one trace, between two events: where reading goes on while the trace grows.
#[derive(Clone, Debug, Default)]
pub struct Cursor {
    segment: usize,
    offset: usize,
    state: CodecState,
    fetched: Fetched,
}

impl Cursor {
    /// Before the first event.
    pub fn new() -> Self {
        Cursor::default()
    }

    /// At the beginning of a segment.
    fn at_segment(trace: &Trace, segment: usize) -> Result<Cursor, TraceError> {
        let mut cursor = Cursor { segment, ..Cursor::default() };
        if let Some((state, _)) = trace.segments.get(segment, &mut cursor.fetched)? {
            cursor.state = CodecState::restore(state, trace.signals.len()).map_err(|_| damaged(segment))?;
        }
        Ok(cursor)
    }

    /// The next event of the segment in which the cursor stands; none at its end.
    #[inline]
    fn inside(&mut self, trace: &Trace) -> Result<Option<Event>, TraceError> {
        let Cursor { segment, offset, state, fetched } = self;
        let (_, stream) = trace.segments.get(*segment, fetched)?.ok_or(TraceError::ForeignCursor)?;
        match stream.get(*offset..) {
            None => Err(TraceError::ForeignCursor),
            Some([]) => Ok(None),
            Some(bytes) => {
                let decoded = state.decode(bytes, trace.signals.len());
                let (event, length) = decoded.map_err(|_| damaged(*segment))?;
                *offset += length;
                Ok(Some(event))
            }
        }
    }

    fn next(&mut self, trace: &Trace) -> Option<Result<Event, TraceError>> {
        loop {
            match self.inside(trace).transpose() {
                None if self.segment + 1 < trace.segments.count() => {
                    self.segment += 1;
                    self.offset = 0;
                }
                next => return next,
            }
        }
    }

    /// Folds every event from here, each segment looked up once: much faster than one call after the other.
    fn fold<B>(
        &mut self,
        trace: &Trace,
        mut so_far: B,
        mut fold: impl FnMut(B, Result<Event, TraceError>) -> B,
    ) -> B {
        let (signals, last) = (trace.signals.len(), trace.segments.count() - 1);
        loop {
            let Cursor { segment, offset, state, fetched } = self;
            let stream = match trace.segments.get(*segment, fetched) {
                Ok(parts) => {
                    parts.and_then(|(_, stream)| stream.get(*offset..)).ok_or(TraceError::ForeignCursor)
                }
                Err(error) => Err(error),
            };
            let mut bytes = match stream {
                Ok(bytes) => bytes,
                Err(error) => return fold(so_far, Err(error)),
            };
            while !bytes.is_empty() {
                let Ok((event, length)) = state.decode(bytes, signals) else {
                    return fold(so_far, Err(damaged(*segment)));
                };
                *offset += length;
                bytes = &bytes[length..];
                so_far = fold(so_far, Ok(event));
            }
            if *segment >= last {
                return so_far;
            }
            *segment += 1;
            *offset = 0;
        }
    }
}

fn damaged(segment: usize) -> TraceError {
    TraceError::SpillDamaged { segment }
}

/// The events of a trace in the order in which they became known. Ends after the first error.
#[derive(Debug)]
pub struct Events<'a> {
    trace: &'a Trace,
    cursor: HeldSegment<'a>,
    failed: bool,
}

#[derive(Debug)]
enum HeldSegment<'a> {
    Own(Box<Cursor>),
    Lent(&'a mut Cursor),
}

impl HeldSegment<'_> {
    fn get(&mut self) -> &mut Cursor {
        match self {
            HeldSegment::Own(cursor) => cursor,
            HeldSegment::Lent(cursor) => cursor,
        }
    }
}

impl<'a> Events<'a> {
    pub(super) fn all(trace: &'a Trace) -> Self {
        Events { trace, cursor: HeldSegment::Own(Box::default()), failed: false }
    }

    pub(super) fn since(trace: &'a Trace, cursor: &'a mut Cursor) -> Self {
        Events { trace, cursor: HeldSegment::Lent(cursor), failed: false }
    }
}

impl Iterator for Events<'_> {
    type Item = Result<Event, TraceError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.failed {
            return None;
        }
        let next = self.cursor.get().next(self.trace);
        self.failed = matches!(next, Some(Err(_)));
        next
    }

    fn fold<B, F: FnMut(B, Self::Item) -> B>(mut self, init: B, fold: F) -> B {
        if self.failed { init } else { self.cursor.get().fold(self.trace, init, fold) }
    }
}

/// The events that can have happened within a window of time, in the order in which they became known.
///
/// Segments that lie outside the window are not read. Ends after the first error.
#[derive(Debug)]
pub struct EventsBetween<'a> {
    trace: &'a Trace,
    from: Time,
    to: Time,
    before: Vec<Option<Event>>,
    cursor: Cursor,
    /// The first segment that has not been entered.
    next_segment: usize,
    /// Signals that nobody asks for any more.
    forgotten: Vec<bool>,
    failed: bool,
}

impl<'a> EventsBetween<'a> {
    pub(super) fn new(trace: &'a Trace, from: Time, to: Time) -> Result<Self, TraceError> {
        let count = trace.segments.count();
        let reaches = |segment: &usize| trace.segments.times(*segment).is_some_and(|t| t.last_latest >= from);
        let first = (0..count).find(reaches).unwrap_or(count - 1);
        let cursor = Cursor::at_segment(trace, first)?;
        let mut before: Vec<Option<Event>> = Vec::new();
        before.resize(trace.signals.len(), None);
        for (id, place) in before.iter_mut().enumerate() {
            *place = cursor.state.last(SignalId(id as u32));
        }
        // An event can become known after a later one: look for stragglers from before the window.
        for segment in first..count {
            if trace.segments.times(segment).is_none_or(|t| t.first_latest >= from) {
                continue;
            }
            let mut cursor = Cursor::at_segment(trace, segment)?;
            while cursor.segment == segment {
                let event = match cursor.next(trace) {
                    // The step into the next segment has been made: its event is not this loop's.
                    Some(Ok(_)) if cursor.segment != segment => break,
                    Some(event) => event?,
                    None => break,
                };
                if event.at.latest < from {
                    before[event.signal.0 as usize] = Some(event);
                }
            }
        }
        let forgotten = vec![false; trace.signals.len()];
        Ok(EventsBetween {
            trace,
            from,
            to,
            before,
            cursor,
            next_segment: first + 1,
            forgotten,
            failed: false,
        })
    }

    /// Events of this signal need not come any more: segments in which nothing else happens are not read.
    pub fn forget(&mut self, signal: SignalId) {
        if let Some(forgotten) = self.forgotten.get_mut(signal.0 as usize) {
            *forgotten = true;
        }
    }

    /// Whether only forgotten signals have events in a segment.
    fn is_idle(&self, segment: usize) -> Result<bool, TraceError> {
        if segment + 1 >= self.trace.segments.count() || !self.forgotten.contains(&true) {
            return Ok(false);
        }
        let begins = Cursor::at_segment(self.trace, segment)?.state;
        let ends = Cursor::at_segment(self.trace, segment + 1)?.state;
        // A last event that is the same and older than all of the segment is none of the segment's.
        let first = self.trace.segments.times(segment).map_or(Time::MIN, |times| times.first_earliest);
        let same = |id: u32| {
            let last = begins.last(SignalId(id));
            last == ends.last(SignalId(id)) && last.is_none_or(|event| event.at.latest < first)
        };
        Ok((0u32..).zip(&self.forgotten).all(|(id, forgotten)| *forgotten || same(id)))
    }

    /// The last event of a signal that lies wholly before the window: its value when the window begins, unless
    /// an event whose interval reaches into the window changed it.
    pub fn before(&self, signal: SignalId) -> Option<Event> {
        self.before.get(signal.0 as usize).copied().flatten()
    }

    fn step(&mut self) -> Option<Result<Event, TraceError>> {
        loop {
            match self.cursor.inside(self.trace) {
                Ok(Some(event)) if event.at.latest >= self.from && event.at.earliest <= self.to => {
                    return Some(Ok(event));
                }
                Ok(Some(_)) => continue,
                Ok(None) => {}
                Err(error) => return Some(Err(error)),
            }
            let inside = |segment: &usize| {
                let times = self.trace.segments.times(*segment);
                times.is_some_and(|t| t.last_latest >= self.from && t.first_earliest <= self.to)
            };
            let segment = (self.next_segment..self.trace.segments.count()).find(inside)?;
            self.next_segment = segment + 1;
            match self.is_idle(segment) {
                Ok(false) => {}
                // The cursor stays after: it is set again at the next segment that is read.
                Ok(true) => continue,
                Err(error) => return Some(Err(error)),
            }
            if segment == self.cursor.segment + 1 {
                self.cursor.segment = segment;
                self.cursor.offset = 0;
            } else {
                self.cursor = match Cursor::at_segment(self.trace, segment) {
                    Ok(cursor) => cursor,
                    Err(error) => return Some(Err(error)),
                };
            }
        }
    }
}

impl Iterator for EventsBetween<'_> {
    type Item = Result<Event, TraceError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.failed {
            return None;
        }
        let next = self.step();
        self.failed = matches!(next, Some(Err(_)));
        next
    }
}
