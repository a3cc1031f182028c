//! Measurements over a window: frequency, duty, periods, widths of pulses, and what the values came to.

use record::MeasurementRecord;
use signal::SignalInfo;

use super::gauge::{LimitNumbers, failed, judge, nanos, open};
use super::{Statistic, WindowFigure};
use crate::monitor::cycles::Cycles;
use crate::monitor::edges::{CountedEdge, EdgeFinder};
use crate::monitor::extremes::Extremes;
use crate::monitor::jitter::Jitter;
use crate::monitor::levels::PulseFinder;
use crate::monitor::pulses::{FirstPulse, Pulse};
use crate::monitor::speed::SpeedFollower;
use crate::monitor::{Extent, Number, TimedValue, UncertainWindow, slack, widened};

/// What follows the signal.
#[derive(Debug)]
pub(super) enum WindowFollower {
    /// Whole cycles together.
    Cycles(Box<Cycles>),
    /// The first pulse.
    First(PulseFinder, FirstPulse),
    /// The pulses one by one.
    Pulses(PulseFinder, SpanStatistics),
    /// The distances of edges one by one.
    Edges { finder: EdgeFinder, before: Option<TimedValue>, many: SpanStatistics },
    /// The distances of edges from a grid.
    Jitter(Box<Jitter>),
    /// The values.
    Values(Box<Extremes>),
    /// The values at both ends.
    Speed(Box<SpeedFollower>),
}

/// What is measured over a window.
#[derive(Debug)]
pub(super) struct WindowMeasurement {
    window: UncertainWindow,
    figure: WindowFigure,
    follow: WindowFollower,
    /// The end of the case, at the earliest and at the latest: what lasts until then has no known width.
    end: (i64, i64),
    slack: f64,
}

/// The least, the greatest and the mean of many lengths of time, each known to within an interval.
#[derive(Debug, Default)]
pub(super) struct SpanStatistics {
    /// Of those that lie in the window in every placement: how many, and the sums of their least and greatest lengths.
    count: u64,
    sum: (i128, i128),
    least: Option<(i64, i64)>,
    most: Option<(i64, i64)>,
    /// Least and greatest length of those that may lie in it.
    possible: Option<(i64, i64)>,
    doubtful: bool,
}

impl SpanStatistics {
    fn see(&mut self, length: (i64, i64), certain: bool) {
        let pair = |old: Option<(i64, i64)>, pick: fn(i64, i64) -> i64| {
            Some(old.map_or(length, |old| (pick(old.0, length.0), pick(old.1, length.1))))
        };
        if certain {
            self.count += 1;
            self.sum = (self.sum.0 + i128::from(length.0), self.sum.1 + i128::from(length.1));
            self.least = pair(self.least, i64::min);
            self.most = pair(self.most, i64::max);
        } else {
            self.possible =
                Some(self.possible.map_or(length, |old| (old.0.min(length.0), old.1.max(length.1))));
        }
    }

    /// Least and greatest figure of all placements; `None` if there may be nothing in the window.
    fn finish(&self, take: Statistic) -> Option<Extent> {
        let (least, most) = (self.least?, self.most?);
        let (low, high) = match take {
            Statistic::Min => nanos(least),
            Statistic::Max => nanos(most),
            Statistic::Span => nanos((most.0.saturating_sub(least.1).max(0), most.1.saturating_sub(least.0))),
            _ => (Number::quotient(self.sum.0, self.count), Number::quotient(self.sum.1, self.count)),
        };
        let Some(possible) = self.possible else { return Some((low, high)) };
        let whole = most.1.max(possible.1).saturating_sub(least.0.min(possible.0));
        let possible = nanos(possible);
        Some(match take {
            Statistic::Min => (low.least(possible.0), high),
            Statistic::Max => (low, high.most(possible.1)),
            Statistic::Span => (low, high.most(nanos((whole, whole)).1)),
            _ => (low.least(possible.0), high.most(possible.1)),
        })
    }
}

impl WindowMeasurement {
    /// `end` is the end of the case at the earliest and at the latest, `length` the least and greatest true time that the
    /// window lasts.
    pub(super) fn new(
        window: UncertainWindow,
        figure: WindowFigure,
        info: &SignalInfo,
        end: (i64, i64),
        length: (i64, i64),
    ) -> WindowMeasurement {
        let slack = slack(info);
        let follow = match figure {
            WindowFigure::Frequency | WindowFigure::Duty | WindowFigure::Period(Statistic::Mean) => {
                WindowFollower::Cycles(Box::new(Cycles::new(window, false, slack)))
            }
            WindowFigure::Period(_) => {
                let finder = EdgeFinder::new(CountedEdge::Rises, slack);
                WindowFollower::Edges { finder, before: None, many: SpanStatistics::default() }
            }
            WindowFigure::Width { high, take: Statistic::First } => {
                WindowFollower::First(PulseFinder::new(high, slack), FirstPulse::new(window, (0, i64::MAX)))
            }
            WindowFigure::Width { high, .. } => {
                WindowFollower::Pulses(PulseFinder::new(high, slack), SpanStatistics::default())
            }
            WindowFigure::Jitter(asked) => {
                WindowFollower::Jitter(Box::new(Jitter::new(asked, CountedEdge::Rises, window, slack)))
            }
            WindowFigure::Value(Statistic::Min | Statistic::Max | Statistic::Span) => {
                WindowFollower::Values(Box::new(Extremes::new(window)))
            }
            WindowFigure::Value(take) => {
                let squares = take == Statistic::Rms;
                WindowFollower::Values(Box::new(Extremes::new(window).with_mean(squares)))
            }
            WindowFigure::Speed => WindowFollower::Speed(Box::new(SpeedFollower::new(window, length))),
        };
        WindowMeasurement { window, figure, follow, end, slack }
    }

    #[inline]
    pub(super) fn feed(&mut self, seen: &TimedValue) {
        let (window, end) = (&self.window, self.end);
        match &mut self.follow {
            WindowFollower::Cycles(cycles) => cycles.see(seen),
            WindowFollower::First(levels, first) => {
                if let Some(pulse) = levels.see(seen) {
                    first.see(&pulse);
                }
            }
            WindowFollower::Pulses(levels, many) => {
                if let Some(pulse) = levels.see(seen) {
                    one_of_many(many, &pulse, window, end);
                }
            }
            WindowFollower::Edges { finder, before, many } => match finder.see(seen) {
                Some(found) if found.certain => {
                    if let Some(before) = before.replace(*seen)
                        && window.can_hold(&before)
                        && window.can_hold(seen)
                    {
                        let length =
                            (seen.a.saturating_sub(before.b).max(0), seen.b.saturating_sub(before.a));
                        many.see(length, window.must_hold(&before) && window.must_hold(seen));
                    }
                }
                Some(found) => {
                    *before = None;
                    many.doubtful |= window.can_hold(&found.seen);
                }
                None => {}
            },
            WindowFollower::Jitter(jitter) => jitter.see(seen),
            WindowFollower::Values(extremes) => extremes.see(seen),
            WindowFollower::Speed(speed) => speed.see(seen),
        }
    }

    pub(super) fn finish(self, mut record: MeasurementRecord, bounds: &LimitNumbers) -> MeasurementRecord {
        let WindowMeasurement { window, figure, follow, end: (end, _), slack } = self;
        record.from_ns = Some([window.from.a, window.from.b]);
        record.to_ns = Some([window.until.a, window.until.b]);
        const NOT_KNOWN: &str = "the signal is not known for a part of the window";
        match follow {
            WindowFollower::Cycles(cycles) => {
                let found = cycles.finish();
                let figures = found.stretches.iter().map(|stretch| match figure {
                    WindowFigure::Frequency => stretch.rate(),
                    WindowFigure::Duty => stretch.duty(),
                    _ => stretch.period(),
                });
                let Some(extent) = figures.reduce(|a, b| widened(Some(a), b)) else {
                    return missing(record, found.doubtful, "fewer than two edges lie in the window");
                };
                let record = judge(record, bounds, extent);
                match (found.doubtful, found.can_be_missing) {
                    (true, _) => open(record, NOT_KNOWN),
                    (_, true) => open(record, "it is open whether two edges lie in the window"),
                    _ => record,
                }
            }
            WindowFollower::First(mut levels, mut first) => {
                if let Some(pulse) = levels.rest(end) {
                    first.see(&pulse);
                }
                let spread = first.finish();
                let Some((low, high)) = spread.extent else {
                    return missing(record, spread.doubtful, "no pulse began in the window");
                };
                if high >= i64::MAX.saturating_sub(end.max(0)) {
                    record.value = Some([low as f64, f64::INFINITY]);
                    return open(record, "the case ended within the pulse");
                }
                let record = judge(record, bounds, nanos((low, high)));
                match (spread.doubtful, spread.can_be_missing) {
                    (true, _) => open(record, NOT_KNOWN),
                    (_, true) => open(record, "it is open whether the pulse began in the window"),
                    _ => record,
                }
            }
            WindowFollower::Pulses(mut levels, mut many) => {
                if let Some(pulse) = levels.rest(end) {
                    // What still lasts has no width: it does not count, unless it may be over.
                    many.doubtful |= !pulse.certain && window.can_hold(&pulse.start);
                }
                many_judged(record, bounds, &many, figure, "no whole pulse began in the window")
            }
            WindowFollower::Edges { finder, mut many, .. } => {
                many.doubtful |= finder.rest().is_some_and(|rest| window.can_hold(&rest.seen));
                many_judged(record, bounds, &many, figure, "fewer than two edges lie in the window")
            }
            WindowFollower::Jitter(jitter) => {
                let found = jitter.finish();
                let Some(extent) = found.extent else {
                    return missing(record, found.doubtful, "fewer than three edges lie in the window");
                };
                let bounds = match figure {
                    WindowFigure::Jitter(asked) if asked.grid.is_some() => {
                        bounds.of_true_grid(found.wanders_over)
                    }
                    _ => *bounds,
                };
                let record = judge(record, &bounds, extent);
                match (found.doubtful, found.can_be_missing) {
                    (true, _) => open(record, NOT_KNOWN),
                    (_, true) => open(record, "it is open whether three edges lie in the window"),
                    _ => record,
                }
            }
            WindowFollower::Speed(speed) => match speed.finish(slack) {
                Some(found) => judge(record, bounds, found.speed),
                None => open(record, "the signal is not known at both ends of the window"),
            },
            WindowFollower::Values(extremes) => {
                let Some(found) = extremes.finish() else {
                    return open(record, NOT_KNOWN);
                };
                let WindowFigure::Value(take) = figure else { return record };
                let (low, high) = match take {
                    Statistic::Min => found.least,
                    Statistic::Max => found.most,
                    Statistic::Span => (
                        found.most.0.minus(found.least.1).most(Number::ZERO),
                        found.most.1.minus(found.least.0),
                    ),
                    Statistic::First | Statistic::Mean | Statistic::Rms => found.mean.unwrap_or(found.most),
                };
                let slack = Number::Real(if take == Statistic::Span { 2.0 * slack } else { slack });
                let record = judge(record, bounds, (low.minus(slack), high.plus(slack)));
                if found.unknown { open(record, NOT_KNOWN) } else { record }
            }
        }
    }
}

/// One of several pulses. It counts if it is over by the end of the case: one that may end after it may not count.
fn one_of_many(many: &mut SpanStatistics, pulse: &Pulse, window: &UncertainWindow, end: (i64, i64)) {
    if !window.can_hold(&pulse.start) || pulse.end.0 > end.1 {
        return;
    }
    if !pulse.certain {
        many.doubtful = true;
        return;
    }
    let (start, over) = (&pulse.start, pulse.end);
    let certain = window.must_hold(start) && over.1 <= end.0;
    // Where it counts it is over by the end.
    let latest = over.1.min(end.1);
    many.see((over.0.saturating_sub(start.b).max(0), latest.saturating_sub(start.a)), certain);
}

fn many_judged(
    record: MeasurementRecord,
    bounds: &LimitNumbers,
    many: &SpanStatistics,
    figure: WindowFigure,
    none: &str,
) -> MeasurementRecord {
    let take = match figure {
        WindowFigure::Period(take) | WindowFigure::Width { take, .. } | WindowFigure::Value(take) => take,
        WindowFigure::Frequency | WindowFigure::Duty | WindowFigure::Speed | WindowFigure::Jitter(_) => {
            Statistic::Mean
        }
    };
    let Some(extent) = many.finish(take) else {
        return missing(record, many.doubtful || many.possible.is_some(), none);
    };
    let record = judge(record, bounds, extent);
    if many.doubtful { open(record, "the signal is not known for a part of the window") } else { record }
}

/// A measurement of which there was nothing to take.
fn missing(record: MeasurementRecord, doubtful: bool, why: &str) -> MeasurementRecord {
    if doubtful {
        open(record, "the signal is not known for a part of the window")
    } else {
        failed(record, why)
    }
}
