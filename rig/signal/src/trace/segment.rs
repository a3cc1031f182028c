//! The stream of encoded events, cut into segments that are held in memory or moved to a store.
//!
//! A segment's bytes are the state from which decoding can start there, then a piece of the stream. The
//! stream itself runs on across segments, so that where it is cut shows in nothing that is read from it.

use std::io::{self, Read, Seek, SeekFrom, Write};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::code::{CodecState, MAX_EVENT};
use super::error::{TraceError, TraceTransfer};
use crate::{Time, When};

/// A place for the segments that memory has no room for: an empty file, opened for reading and writing.
pub trait Spill: Read + Write + Seek + Send {}

impl<T: Read + Write + Seek + Send> Spill for T {}

/// The times that a segment covers.
#[derive(Clone, Copy, Debug)]
pub(super) struct SegmentTimes {
    pub(super) first_earliest: Time,
    pub(super) first_latest: Time,
    pub(super) last_latest: Time,
}

impl SegmentTimes {
    const NONE: SegmentTimes =
        SegmentTimes { first_earliest: Time::MAX, first_latest: Time::MAX, last_latest: Time::MIN };

    #[inline]
    fn cover(&mut self, at: When) {
        self.first_earliest = self.first_earliest.min(at.earliest);
        self.first_latest = self.first_latest.min(at.latest);
        self.last_latest = self.last_latest.max(at.latest);
    }
}

/// The segment that grows.
pub(super) struct OpenSegment {
    bytes: Vec<u8>,
    /// Where the piece of the stream begins: after the state.
    stream_at: usize,
    /// The segment is full when it is this long.
    full_at: usize,
    times: SegmentTimes,
}

/// A full segment.
struct Segment {
    place: SegmentPlace,
    stream_at: usize,
    times: SegmentTimes,
}

enum SegmentPlace {
    Memory(Vec<u8>),
    Store { offset: u64, length: usize, crc: u32 },
}

/// A segment's state and its piece of the stream.
type SegmentParts<'a> = (&'a [u8], &'a [u8]);

/// Where a reader keeps a segment that it fetched from the store.
#[derive(Clone, Debug, Default)]
pub(super) struct Fetched {
    segment: Option<usize>,
    bytes: Vec<u8>,
}

/// All segments.
pub(super) struct Segments {
    full: Vec<Segment>,
    open: OpenSegment,
    segment_bytes: usize,
    bound: usize,
    store: Option<Mutex<Box<dyn Spill>>>,
    /// The first segment that is still in memory: they leave in order.
    first_held: usize,
    held_bytes: usize,
    stored_bytes: u64,
    spare: Vec<u8>,
}

impl Segments {
    pub(super) fn new(segment_bytes: usize, bound: usize, store: Option<Box<dyn Spill>>) -> Self {
        let open = OpenSegment::new(Vec::new(), &CodecState::default(), segment_bytes);
        Segments {
            full: Vec::new(),
            open,
            segment_bytes,
            bound,
            store: store.map(Mutex::new),
            first_held: 0,
            held_bytes: 0,
            stored_bytes: 0,
            spare: Vec::new(),
        }
    }

    /// Number of segments, the growing one included.
    pub(super) fn count(&self) -> usize {
        self.full.len() + 1
    }

    /// Appends one encoded event of this length. Whether the segment is full now: [`Segments::close`] is due.
    #[inline]
    pub(super) fn append(&mut self, encoded: &[u8; MAX_EVENT], length: usize, at: When) -> bool {
        // A copy of a fixed length is a few moves, one of a few bytes a call; there is room for it in every segment.
        let end = self.open.bytes.len() + length;
        self.open.bytes.extend_from_slice(encoded);
        self.open.bytes.truncate(end);
        self.open.times.cover(at);
        self.open.bytes.len() >= self.open.full_at
    }

    /// The piece of the stream that has not been closed yet.
    pub(super) fn open_stream(&self) -> &[u8] {
        &self.open.bytes[self.open.stream_at..]
    }

    /// Closes the growing segment and begins the next one at `state`; moves segments to the store while memory
    /// holds more than the bound.
    pub(super) fn close(&mut self, state: &CodecState) -> Result<(), TraceError> {
        let next = OpenSegment::new(std::mem::take(&mut self.spare), state, self.segment_bytes);
        let done = std::mem::replace(&mut self.open, next);
        self.held_bytes += done.bytes.capacity();
        self.full.push(Segment {
            place: SegmentPlace::Memory(done.bytes),
            stream_at: done.stream_at,
            times: done.times,
        });
        while self.store.is_some() && self.held_bytes + self.open.bytes.capacity() > self.bound {
            if !self.spill_one()? {
                break;
            }
        }
        Ok(())
    }

    /// Moves the oldest segment in memory to the store; false if there is none.
    fn spill_one(&mut self) -> Result<bool, TraceError> {
        let (Some(segment), Some(store)) = (self.full.get_mut(self.first_held), &self.store) else {
            return Ok(false);
        };
        let SegmentPlace::Memory(bytes) = &mut segment.place else { return Ok(false) };
        let mut store = lock(store);
        store
            .seek(SeekFrom::Start(self.stored_bytes))
            .and_then(|_| store.write_all(bytes))
            .map_err(|error| TraceError::Io { transfer: TraceTransfer::Spill, kind: error.kind() })?;
        let crc = crc32fast::hash(bytes);
        let length = bytes.len();
        self.held_bytes -= bytes.capacity();
        self.spare = std::mem::take(bytes);
        segment.place = SegmentPlace::Store { offset: self.stored_bytes, length, crc };
        self.stored_bytes += length as u64;
        self.first_held += 1;
        Ok(true)
    }

    /// The times that a segment covers.
    pub(super) fn times(&self, segment: usize) -> Option<SegmentTimes> {
        if segment == self.full.len() {
            Some(self.open.times)
        } else {
            self.full.get(segment).map(|s| s.times)
        }
    }

    /// A segment's state and its piece of the stream; `None` after the last one.
    pub(super) fn get<'a>(
        &'a self,
        segment: usize,
        fetched: &'a mut Fetched,
    ) -> Result<Option<SegmentParts<'a>>, TraceError> {
        if segment == self.full.len() {
            return Ok(Some(self.open.bytes.split_at(self.open.stream_at)));
        }
        let Some(full) = self.full.get(segment) else { return Ok(None) };
        let bytes = match &full.place {
            SegmentPlace::Memory(bytes) => bytes,
            SegmentPlace::Store { offset, length, crc } => {
                if fetched.segment != Some(segment) {
                    fetched.segment = None;
                    self.fetch(*offset, *length, &mut fetched.bytes).map_err(|error| TraceError::Io {
                        transfer: TraceTransfer::Recall,
                        kind: error.kind(),
                    })?;
                    if crc32fast::hash(&fetched.bytes) != *crc {
                        return Err(TraceError::SpillDamaged { segment });
                    }
                    fetched.segment = Some(segment);
                }
                &fetched.bytes
            }
        };
        if bytes.len() < full.stream_at {
            // A cursor of another trace brought its own bytes.
            return Err(TraceError::ForeignCursor);
        }
        Ok(Some(bytes.split_at(full.stream_at)))
    }

    fn fetch(&self, offset: u64, length: usize, into: &mut Vec<u8>) -> io::Result<()> {
        let Some(store) = &self.store else { return Err(io::ErrorKind::NotFound.into()) };
        into.resize(length, 0);
        let mut store = lock(store);
        store.seek(SeekFrom::Start(offset))?;
        store.read_exact(into)
    }

    /// Memory taken by segments and by what is known of those in the store.
    pub(super) fn bytes_in_memory(&self) -> usize {
        self.held_bytes
            + self.open.bytes.capacity()
            + self.spare.capacity()
            + self.full.capacity() * size_of::<Segment>()
    }
}

/// A panic elsewhere while the store was locked leaves at worst a wrong position, and every use seeks first.
fn lock<'a>(store: &'a Mutex<Box<dyn Spill>>) -> MutexGuard<'a, Box<dyn Spill>> {
    store.lock().unwrap_or_else(PoisonError::into_inner)
}

impl OpenSegment {
    fn new(mut bytes: Vec<u8>, state: &CodecState, segment_bytes: usize) -> Self {
        bytes.clear();
        state.save(&mut bytes);
        let stream_at = bytes.len();
        // With thousands of signals the state is long: let it be a small part of the segment all the same.
        let full_at = stream_at + segment_bytes.max(4 * stream_at);
        bytes.reserve_exact(full_at + MAX_EVENT - stream_at);
        OpenSegment { bytes, stream_at, full_at, times: SegmentTimes::NONE }
    }
}
