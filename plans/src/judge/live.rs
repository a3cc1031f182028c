//! Watching claims while the trace grows, only to notice early that one is lost.
//!
//! A claim is watched from the moment that the instants it depends on are known. What is noticed here never
//! becomes a verdict: the last reading decides.

use signal::{Event, SignalInfo};

use super::order::Orderer;
use crate::expect::Expectation;
use crate::lang::{Anchor, AnchorBase};
use crate::monitor::{CaseTimeline, EventOrder, Monitor, TimedValue, lag};

/// How far a claim is watched.
enum ClaimWatch {
    /// An instant is still to come.
    Waiting,
    /// Fed; `open` if the end of its window is still to come.
    Running { monitor: Box<dyn Monitor>, open: bool },
    /// Not watched any more.
    Over { lost: bool },
}

impl ClaimWatch {
    /// Whether the claim is lost when every event before `now` is known.
    fn lost(&mut self, now: i64) -> bool {
        match self {
            ClaimWatch::Waiting => false,
            ClaimWatch::Running { monitor, .. } => monitor.lost(now),
            ClaimWatch::Over { lost } => *lost,
        }
    }
}

/// A signal with the claims that look at it.
struct WatchedSignal {
    orderer: Orderer,
    followers: Vec<(usize, usize)>,
    last: Option<TimedValue>,
    order: EventOrder,
}

/// The claims under watch.
pub(crate) struct LiveReading {
    watches: Vec<ClaimWatch>,
    /// How late an event of a claim's signals can become known, nanoseconds.
    lags: Vec<i64>,
    /// From when on all instants that a claim depends on have come, the end of the case apart: one that does not come any more
    /// would leave the claim open.
    come: Vec<i64>,
    lines: Vec<WatchedSignal>,
    now: i64,
    /// The instant that the case has come to.
    reached: i64,
    /// Nobody asks: only the order of the events is looked at.
    idle: bool,
    /// The claims that were lost when that was first noticed.
    first_lost: Vec<usize>,
}

impl LiveReading {
    /// The claim at this place is not watched: it is decided after the case.
    pub(crate) fn pass_over(&mut self, at: usize) {
        self.watches[at] = ClaimWatch::Over { lost: false };
    }

    pub(crate) fn new(expectations: &[Expectation], signals: &[SignalInfo]) -> LiveReading {
        let line = |_: &SignalInfo| WatchedSignal {
            orderer: Orderer::new(false),
            followers: Vec::new(),
            last: None,
            order: EventOrder::default(),
        };
        let mut live = LiveReading {
            watches: Vec::new(),
            lags: Vec::new(),
            come: vec![i64::MAX; expectations.len()],
            lines: signals.iter().map(line).collect(),
            now: i64::MIN,
            reached: i64::MIN,
            idle: false,
            first_lost: Vec::new(),
        };
        for (at, expectation) in expectations.iter().enumerate() {
            let mut latest = 0;
            for (slot, name) in expectation.claim.signals().iter().enumerate() {
                if let Some(place) = signals.iter().position(|info| info.name == *name) {
                    live.lines[place].followers.push((at, slot));
                    latest = latest.max(lag(&signals[place]).as_nanos());
                }
            }
            live.lags.push(latest);
            // What looks back needs what was before; what looks at the end is decided there.
            let back = expectation.claim.anchors().iter().any(|anchor| anchor.offset.is_negative());
            live.watches.push(if back { ClaimWatch::Over { lost: false } } else { ClaimWatch::Waiting });
        }
        live
    }

    /// Claims are not watched any more.
    pub(crate) fn rest(&mut self) {
        self.idle = true;
        self.watches.clear();
    }

    /// The case has come to this instant.
    pub(crate) fn reach(&mut self, now: i64) {
        self.reached = self.reached.max(now);
    }

    #[inline]
    pub(crate) fn feed(&mut self, event: &Event, place: u64) {
        let newest = self.now;
        self.now = newest.max(event.at.earliest.as_nanos());
        self.reached = self.reached.max(self.now);
        let Some(line) = self.lines.get_mut(event.signal.0 as usize) else { return };
        line.order.see(event.at, newest);
        if line.followers.is_empty() {
            return;
        }
        let WatchedSignal { orderer, followers, last, .. } = line;
        if self.idle {
            orderer.push(event, place, |_| {});
            return;
        }
        let watches = &mut self.watches;
        orderer.push(event, place, |seen| {
            *last = Some(*seen);
            for (watch, slot) in followers.iter() {
                if let ClaimWatch::Running { monitor, .. } = &mut watches[*watch] {
                    monitor.feed(*slot, seen);
                }
            }
        });
    }

    /// An instant became known at `now`.
    pub(crate) fn news(&mut self, expectations: &[Expectation], scene: &CaseTimeline<'_>, now: i64) {
        if self.idle {
            return;
        }
        for (at, expectation) in expectations.iter().enumerate() {
            let claim = &expectation.claim;
            if self.come[at] == i64::MAX {
                self.come[at] = all_come(&claim.anchors(), scene);
            }
            let open = || claim.anchors().iter().any(|anchor| scene.point(anchor).is_err());
            match &mut self.watches[at] {
                ClaimWatch::Over { .. } => {}
                ClaimWatch::Running { monitor, open: was_open } => {
                    if *was_open && !open() {
                        // The window ends here or a known time after: an open end would stretch too far.
                        let lost = monitor.lost(now.saturating_sub(self.lags[at]));
                        self.watches[at] = ClaimWatch::Over { lost };
                    }
                }
                ClaimWatch::Waiting => self.begin(at, expectation, scene, now, open()),
            }
        }
    }

    fn begin(
        &mut self,
        at: usize,
        expectation: &Expectation,
        scene: &CaseTimeline<'_>,
        now: i64,
        open: bool,
    ) {
        let claim = &expectation.claim;
        if claim.anchors().contains(&&Anchor::END) && scene.point(&Anchor::END).is_ok() {
            self.watches[at] = ClaimWatch::Over { lost: false };
            return;
        }
        let Ok(mut monitor) = claim.start(scene) else { return };
        for line in &self.lines {
            for (_, slot) in line.followers.iter().filter(|(watch, _)| *watch == at) {
                match line.last {
                    // Events that may lie after the instant would have to be fed, and only the last is kept.
                    Some(last) if last.b > now => {
                        self.watches[at] = ClaimWatch::Over { lost: false };
                        return;
                    }
                    Some(last) => monitor.feed(*slot, &last),
                    None => {}
                }
            }
        }
        self.watches[at] = ClaimWatch::Running { monitor, open };
    }

    /// How the events of every signal lay in the trace. Whether intervals ran backwards is known only of those that claims
    /// look at.
    pub(crate) fn order(&self) -> Vec<EventOrder> {
        let order =
            |line: &WatchedSignal| EventOrder { disordered: line.orderer.is_disordered(), ..line.order };
        self.lines.iter().map(order).collect()
    }

    /// Whether a claim is lost.
    pub(crate) fn lost(&mut self) -> bool {
        let (now, reached, times) = (self.now, self.reached, self.come.iter().zip(&self.lags));
        let mut watches = self.watches.iter_mut().zip(times);
        if !watches.any(|(watch, (come, lag))| *come <= reached && watch.lost(now.saturating_sub(*lag))) {
            return false;
        }
        if self.first_lost.is_empty() {
            let lost = self.lost_each().into_iter().enumerate();
            self.first_lost = lost.filter_map(|(at, lost)| lost.then_some(at)).collect();
        }
        true
    }

    /// The places of the claims that were lost when that was first noticed.
    pub(crate) fn first_lost(&self) -> &[usize] {
        &self.first_lost
    }

    /// Which claims are lost.
    pub(crate) fn lost_each(&mut self) -> Vec<bool> {
        let (now, reached, times) = (self.now, self.reached, self.come.iter().zip(&self.lags));
        let watches = self.watches.iter_mut().zip(times);
        watches.map(|(watch, (come, lag))| *come <= reached && watch.lost(now.saturating_sub(*lag))).collect()
    }
}

/// From when on all of these instants have come, the end of the case apart; `i64::MAX` while one is still to come.
fn all_come(anchors: &[&Anchor], scene: &CaseTimeline<'_>) -> i64 {
    let own = anchors.iter().filter(|anchor| anchor.base != AnchorBase::End);
    own.map(|anchor| scene.point(anchor).map_or(i64::MAX, |point| point.a)).max().unwrap_or(i64::MIN)
}
