//! What a claim starts from: the signals and the instants of one case.

use std::fmt;

use signal::{Sampling, SignalInfo, Span, When};

use super::anchors::Anchors;
use super::instants::UNLINKED;
use super::{ClockLimits, UncertainInstant, UncertainWindow};
use crate::lang::{Anchor, AnchorBase};

/// The signals of a trace.
#[derive(Clone, Copy, Debug)]
pub struct TraceSignals<'a> {
    /// All of them, by their places in the trace.
    pub signals: &'a [SignalInfo],
}

impl<'a> TraceSignals<'a> {
    /// The signal of this name.
    pub fn find(&self, name: &str) -> Option<&'a SignalInfo> {
        self.signals.iter().find(|info| info.name == name)
    }
}

/// Why a claim was not judged. The verdict is then inconclusive: no evidence is no pass, and no failure.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NotJudged {
    /// The instant that it depends on never came.
    NeverCame(String),
    /// The instant that it depends on lies after the end of the case, of which nothing is known.
    AfterEnd(String),
    /// The case never came to its steps proper.
    NoMain(String),
    /// Its window ends before it begins, or has no length.
    EmptyWindow(String),
    /// The trace has no signal of this name.
    NoSignal(String),
    /// A value of the claim means nothing for its signal.
    NoMeaning(String),
}

impl fmt::Display for NotJudged {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NotJudged::NeverCame(anchor) => write!(f, "`{anchor}` never came"),
            NotJudged::AfterEnd(anchor) => write!(f, "`{anchor}` is after the end of the case"),
            NotJudged::NoMain(why) if why.is_empty() => f.write_str("the setup was never done"),
            NotJudged::NoMain(why) => write!(f, "the setup was never done: {why}"),
            NotJudged::EmptyWindow(window) => write!(f, "the window from {window} is empty"),
            NotJudged::NoSignal(name) => write!(f, "the trace has no signal `{name}`"),
            NotJudged::NoMeaning(why) => f.write_str(why),
        }
    }
}

/// How the events of one signal lie in the trace of the case: what a first reading of all of it found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct EventOrder {
    /// An interval ended before its predecessor's.
    pub(crate) disordered: bool,
    /// How far an event began before the beginning of one that stands before it in the trace, at most, nanoseconds.
    pub(crate) lag: i64,
    /// The widest interval, nanoseconds.
    pub(crate) widest: i64,
}

impl EventOrder {
    /// The next event of the signal, when the newest of the trace before it began at `newest`.
    #[inline]
    pub(crate) fn see(&mut self, at: When, newest: i64) {
        let [earliest, latest] = [at.earliest.as_nanos(), at.latest.as_nanos()];
        self.lag = self.lag.max(newest.saturating_sub(earliest));
        self.widest = self.widest.max(latest.saturating_sub(earliest));
    }
}

/// The signals and instants of one case.
#[derive(Clone, Copy, Debug)]
pub struct CaseTimeline<'a> {
    pub(crate) signals: &'a [SignalInfo],
    pub(crate) anchors: &'a Anchors,
    /// How the events of every signal lie in the trace; empty where that is not known yet.
    pub(crate) order: &'a [EventOrder],
    /// While the trace grows: an end that is not known yet lies at this instant or later.
    pub(crate) open_from: Option<i64>,
    /// `end` is the end of the teardown: for what looks at the teardown.
    pub(crate) closing: bool,
    /// How long a change is held back until it is known whether it is one, nanoseconds.
    pub(crate) held: i64,
    /// What the clock that stamped the trace may be off, and how limits are taken by it.
    pub(crate) clock: ClockLimits,
}

impl<'a> CaseTimeline<'a> {
    /// An instant.
    ///
    /// # Errors
    /// [`NotJudged::NeverCame`], [`NotJudged::AfterEnd`].
    pub fn point(&self, anchor: &Anchor) -> Result<UncertainInstant, NotJudged> {
        let point = self.resolve(anchor).ok_or_else(|| NotJudged::NeverCame(anchor.to_string()))?;
        match point.a > self.seen_until() {
            true => Err(NotJudged::AfterEnd(anchor.to_string())),
            false => Ok(point),
        }
    }

    /// Up to when anything was seen: the end of the case, or of its teardown, where that came.
    fn seen_until(&self) -> i64 {
        if self.closing && self.anchors.closed(Span::ZERO).is_none() { i64::MAX } else { self.end() }
    }

    fn resolve(&self, anchor: &Anchor) -> Option<UncertainInstant> {
        self.stamped(anchor).map(|point| point.by_clock(self.clock.error))
    }

    /// An instant as the clock has it.
    fn stamped(&self, anchor: &Anchor) -> Option<UncertainInstant> {
        let closed = if self.closing && anchor.base == AnchorBase::End {
            self.anchors.closed(anchor.offset)
        } else {
            None
        };
        closed.or_else(|| self.anchors.resolve(anchor))
    }

    /// The true time from one instant to another, at least and at most, nanoseconds. Only of what lies between the events that
    /// they count from a part is wrong: the distances from these are true time.
    ///
    /// # Errors
    /// [`NotJudged::NeverCame`].
    pub(crate) fn time_between(&self, from: &Anchor, until: &Anchor) -> Result<(i64, i64), NotJudged> {
        let stamped = |anchor| self.stamped(anchor).ok_or_else(|| NotJudged::NeverCame(anchor.to_string()));
        let (from, until) = (stamped(from)?, stamped(until)?);
        if let Some(length) = from.link(&until) {
            return Ok((length, length));
        }
        let offsets = until.offset.saturating_sub(from.offset);
        let base = |at: i64, point: &UncertainInstant| at.saturating_sub(point.offset);
        let least = base(until.a, &until).saturating_sub(base(from.b, &from));
        let most = base(until.b, &until).saturating_sub(base(from.a, &from));
        let (least, most) = self.clock.error.true_times((least, most));
        Ok((least.saturating_add(offsets), most.saturating_add(offsets)))
    }

    /// Place in the trace after which nothing counts.
    pub(crate) fn last_place(&self) -> u64 {
        if self.closing { u64::MAX } else { self.anchors.end_place() }
    }

    /// A window.
    ///
    /// # Errors
    /// [`NotJudged`] if an end never came or the window is empty in every placement.
    pub fn window(&self, from: &Anchor, until: &Anchor) -> Result<UncertainWindow, NotJudged> {
        let start = self.point(from)?;
        let end = match (self.point(until), self.open_from) {
            (Err(_), Some(now)) => {
                UncertainInstant { a: now, b: i64::MAX, place: u64::MAX, base: UNLINKED, offset: 0 }
            }
            (end, _) => end?,
        };
        UncertainWindow::new(start, end)
            .ok_or_else(|| NotJudged::EmptyWindow(format!("{from} until {until}")))
    }

    /// The end of the case; later than all time while it is not known.
    pub fn end(&self) -> i64 {
        self.resolve(&Anchor::END).map_or(i64::MAX, |end| end.b)
    }

    /// The end of the case, at the earliest.
    pub(crate) fn earliest_end(&self) -> i64 {
        self.resolve(&Anchor::END).map_or(i64::MAX, |end| end.a)
    }

    /// From when to when nothing is known any more of the signals of what depends on these instants, nanoseconds: the end of the
    /// case, where an instant may lie after it by the error of the clock, or by how late a rig marked what it counts from.
    pub(crate) fn known_until(&self, anchors: &[&Anchor]) -> Option<(i64, i64)> {
        let end = (self.earliest_end(), self.end());
        let after = |anchor: &&Anchor| self.resolve(anchor).is_some_and(|point| point.b > end.1);
        anchors.iter().any(after).then_some(end)
    }

    /// Whether a window that ends at this instant has an end that is still to come.
    pub fn is_open(&self, until: &Anchor) -> bool {
        self.open_from.is_some() && self.point(until).is_err()
    }

    /// How far before the newest event of the trace one of this signal that comes after it can begin, nanoseconds.
    ///
    /// The trace itself says so once it was read: a board may report later than its channels promise, and a rig that
    /// wakes late widens what it saw.
    pub fn lag(&self, name: &str) -> i64 {
        let Some(at) = self.signals.iter().position(|info| info.name == name) else { return i64::MAX };
        let order = match self.order.get(at) {
            Some(order) if order.disordered => return i64::MAX,
            Some(order) => *order,
            None => {
                let lag = lag(&self.signals[at]).as_nanos();
                EventOrder { lag, widest: lag, ..EventOrder::default() }
            }
        };
        match self.held {
            0 => order.lag,
            // A change is held back until it is as old, and may have begun as much earlier where nothing was known before.
            held => order.lag.saturating_add(order.widest).saturating_add(held.saturating_mul(2)),
        }
    }

    /// A signal.
    ///
    /// # Errors
    /// [`NotJudged::NoSignal`].
    pub fn signal(&self, name: &str) -> Result<&'a SignalInfo, NotJudged> {
        TraceSignals { signals: self.signals }.find(name).ok_or_else(|| NotJudged::NoSignal(name.to_owned()))
    }
}

/// How late an event of the signal can become known: the latest stamp that is still to come.
pub(crate) fn lag(info: &SignalInfo) -> Span {
    match info.sampling {
        Sampling::Edges { resolution } => resolution,
        Sampling::Sampled { period } => period,
    }
}
