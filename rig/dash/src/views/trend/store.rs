//! What was seen of the signals of a trend, as far back as there is room.

use crate::recording::{RecordedChange, RecordedSignal, TrendRecording};
use control::{Value, WireValue};
use std::collections::VecDeque;

/// The most signals of a trend.
pub const MAX_LINES: usize = 32;

/// The most changes of each that are kept.
pub const CHANGES: usize = 32_768;

/// A change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrendPoint {
    /// The earliest instant, nanoseconds since the rig began.
    pub earliest: i64,
    /// The latest instant: it is drawn and measured there.
    pub at: i64,
    /// The value from then on.
    pub value: Value,
}

/// A signal with its changes.
#[derive(Clone, Debug)]
pub struct TrendLine {
    /// What it is.
    pub track: RecordedSignal,
    /// Its numbers from the bottom to the top of its lane; what was seen decides where the user did not.
    pub scale: Option<(f64, f64)>,
    points: VecDeque<TrendPoint>,
    /// From here on changes were not taken, because what is looked at needs the room.
    refused: Option<i64>,
}

impl TrendLine {
    /// A signal of which nothing was seen yet.
    pub fn new(track: RecordedSignal) -> TrendLine {
        TrendLine { track, scale: None, points: VecDeque::new(), refused: None }
    }

    /// Takes a change. Where there is no room, the oldest makes some, if it lies before `keep`.
    fn push(&mut self, point: TrendPoint, keep: Option<i64>) {
        while self.points.len() >= CHANGES {
            // The second one says what was seen until it, so that is what the first one's room costs.
            let needed = keep.is_some_and(|keep| self.points.get(1).is_none_or(|second| second.at > keep));
            if needed {
                self.refused = self.refused.or(Some(point.at));
                return;
            }
            self.points.pop_front();
        }
        if let Some(since) = self.refused.take() {
            // Room for two: one point more than there may be, until the next one comes.
            self.points.push_back(TrendPoint { earliest: since, at: since, value: Value::Unknown });
        }
        if self.points.back().is_none_or(|last| last.value != point.value) {
            self.points.push_back(point);
        }
    }

    /// The changes after an instant, up to another and with it.
    pub fn between(&self, from: i64, to: i64) -> impl Iterator<Item = &TrendPoint> {
        let first = self.points.partition_point(|point| point.at <= from);
        self.points.range(first..).take_while(move |point| point.at <= to)
    }

    /// The value at an instant.
    pub fn at(&self, at: i64) -> Value {
        let after = self.points.partition_point(|point| point.at <= at);
        after.checked_sub(1).and_then(|place| self.points.get(place)).map_or(Value::Unknown, |p| p.value)
    }

    /// The last value that was seen.
    pub fn last(&self) -> Value {
        self.points.back().map_or(Value::Unknown, |point| point.value)
    }

    /// The next change after an instant, or the last one before it.
    pub fn next(&self, at: i64, forward: bool) -> Option<TrendPoint> {
        if forward {
            self.points.get(self.points.partition_point(|point| point.at <= at)).copied()
        } else {
            let after = self.points.partition_point(|point| point.at < at);
            after.checked_sub(1).and_then(|place| self.points.get(place)).copied()
        }
    }
}

/// The signals.
#[derive(Clone, Debug, Default)]
pub struct TrendStore {
    /// In the order in which they are drawn.
    pub lines: Vec<TrendLine>,
    /// The last instant of which anything is known.
    pub now: i64,
}

impl TrendStore {
    /// Takes a change of a signal; `keep` is the first instant that is looked at. An instant before the last one is of
    /// another run of the rig: what was seen of the old one is forgotten.
    pub fn push(&mut self, name: &str, point: TrendPoint, keep: Option<i64>) {
        let Some(place) = self.lines.iter().position(|line| line.track.name == name) else { return };
        if self.lines[place].points.back().is_some_and(|last| point.at < last.at) {
            self.forget();
        }
        self.now = self.now.max(point.at);
        self.lines[place].push(point, keep);
    }

    /// Time passed.
    pub fn until(&mut self, now: i64) {
        // Changes run ahead of the status, a little.
        if now.saturating_add(AHEAD) < self.now {
            self.forget();
        }
        self.now = self.now.max(now);
    }

    /// No changes were sent since the last instant.
    pub fn gap(&mut self) {
        let now = self.now;
        for line in &mut self.lines {
            if line.last() != Value::Unknown {
                line.push(TrendPoint { earliest: now, at: now, value: Value::Unknown }, None);
            }
        }
    }

    fn forget(&mut self) {
        self.now = 0;
        for line in &mut self.lines {
            line.points.clear();
            line.refused = None;
        }
    }

    /// The first instant that anything is known of.
    pub fn begin(&self) -> i64 {
        self.lines
            .iter()
            .filter_map(|line| line.points.front())
            .map(|point| point.at)
            .min()
            .unwrap_or(self.now)
    }

    /// What was seen between two instants, for a file.
    pub fn recording(&self, from: i64, to: i64) -> TrendRecording {
        let mut samples = Vec::new();
        for (track, line) in self.lines.iter().enumerate() {
            let before = line.at(from);
            if before != Value::Unknown {
                samples.push(RecordedChange { track, when: (from, from), value: WireValue(before) });
            }
            samples.extend(line.between(from, to).map(|point| RecordedChange {
                track,
                when: (point.earliest.max(from), point.at),
                value: WireValue(point.value),
            }));
        }
        // Stable, so that changes at one instant keep the order of the lines.
        samples.sort_by_key(|sample| sample.when.1);
        let tracks = self.lines.iter().map(|line| line.track.clone()).collect();
        TrendRecording { tracks, samples, span: (from, to) }
    }

    /// What a file holds. Signals and changes that there is no room for are left out; how many.
    pub fn of(recording: TrendRecording) -> (TrendStore, usize) {
        let lines = recording.tracks.into_iter().take(MAX_LINES).map(TrendLine::new).collect();
        let mut store = TrendStore { lines, now: recording.span.1 };
        let mut left = 0;
        for sample in recording.samples {
            let point = TrendPoint { earliest: sample.when.0, at: sample.when.1, value: sample.value.0 };
            match store.lines.get_mut(sample.track) {
                Some(line) if line.points.len() < CHANGES => line.push(point, None),
                _ => left += 1,
            }
        }
        (store, left)
    }
}

/// How far changes can run ahead of the status, nanoseconds.
const AHEAD: i64 = 2_000_000_000;

#[cfg(test)]
mod tests {
    use super::*;
    use control::SignalKind;

    fn store(names: &[&str]) -> TrendStore {
        let track = |name: &&str| RecordedSignal {
            name: (*name).to_owned(),
            unit: String::new(),
            kind: SignalKind::Int,
            labels: Vec::new(),
        };
        TrendStore { lines: names.iter().map(track).map(TrendLine::new).collect(), now: 0 }
    }

    fn point(at: i64, value: i64) -> TrendPoint {
        TrendPoint { earliest: at - 1, at, value: Value::Int(value) }
    }

    #[test]
    fn the_oldest_goes_unless_it_is_looked_at() {
        let mut store = store(&["a"]);
        for n in 0..CHANGES as i64 + 5 {
            store.push("a", point(n, n), None);
        }
        assert_eq!(store.lines[0].points.len(), CHANGES);
        assert_eq!(store.begin(), 5);
        let last = CHANGES as i64 + 4;
        for n in 1..=3 {
            store.push("a", point(last + n, last + n), Some(5));
        }
        assert_eq!((store.begin(), store.lines[0].last()), (5, Value::Int(last)));
        // What was not taken is not known.
        store.push("a", point(last + 9, -1), None);
        assert_eq!(store.lines[0].at(last + 1), Value::Unknown);
        assert_eq!(store.lines[0].at(last + 9), Value::Int(-1));
        for n in 10..40 {
            store.push("a", point(last + n, n), None);
        }
        assert!(store.lines[0].points.len() <= CHANGES + 1);
    }

    #[test]
    fn an_instant_that_goes_back_is_another_run() {
        let mut store = store(&["a", "b"]);
        store.push("a", point(50, 1), None);
        store.push("b", point(60, 1), None);
        store.push("a", point(10, 2), None);
        assert_eq!((store.now, store.begin()), (10, 10));
        assert_eq!(store.lines[1].last(), Value::Unknown);
        store.until(3_000_000_000);
        store.until(2_900_000_000);
        assert_eq!(store.now, 3_000_000_000);
        store.until(1);
        assert_eq!((store.now, store.lines[0].last()), (1, Value::Unknown));
    }

    #[test]
    fn values_and_changes_are_found() {
        let mut store = store(&["a"]);
        for at in [10, 20, 30] {
            store.push("a", point(at, at), None);
        }
        let line = &store.lines[0];
        assert_eq!((line.at(9), line.at(10), line.at(29)), (Value::Unknown, Value::Int(10), Value::Int(20)));
        assert_eq!(line.between(10, 30).count(), 2);
        assert_eq!(line.next(10, true).map(|point| point.at), Some(20));
        assert_eq!(line.next(10, false), None);
        assert_eq!(line.next(99, false).map(|point| point.at), Some(30));
    }

    #[test]
    fn a_recording_begins_with_what_was_before_it() {
        let mut store = store(&["a", "b"]);
        store.push("a", point(10, 1), None);
        store.push("b", point(15, 2), None);
        store.push("a", point(20, 3), None);
        let recording = store.recording(12, 20);
        let seen: Vec<(usize, (i64, i64))> = recording.samples.iter().map(|s| (s.track, s.when)).collect();
        assert_eq!(seen, [(0, (12, 12)), (1, (14, 15)), (0, (19, 20))]);
        let (read, left) = TrendStore::of(recording);
        assert_eq!((read.now, left, read.lines[0].at(13)), (20, 0, Value::Int(1)));
    }
}
