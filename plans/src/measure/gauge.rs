//! Taking a measurement.

use std::cmp::Ordering;

use record::{Figure, GuardBand, MeasurementRecord, Verdict};
use signal::{ClockError, Decimal, SignalInfo, Span, ValueKind};

use super::window::WindowMeasurement;
use super::{MeasuredQuantity, Measurement, MeasurementLimits, Statistic, WindowFigure};
use crate::expect::band::figure;
use crate::expect::position::PositionCounter;
use crate::expect::profile::ShapeMeasurement;
use crate::lang::Literal;
use crate::meaning::{ToleranceBand, number};
use crate::monitor::edges::{EdgeFinder, FirstEdge};
use crate::monitor::reading::ValueReader;
use crate::monitor::{
    CaseTimeline, ClockLimits, ClockedFigure, Extent, NotJudged, Number, NumberLimits, TimedValue,
    UncertainInstant, UnseenPulses, slack, true_figure, widened,
};

/// Limits as numbers, and as the record states them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct LimitNumbers {
    limits: NumberLimits,
    /// The value wanted and the tolerance, where the limits were given by them.
    around: Option<(Decimal, Decimal)>,
    /// What no figure of this kind is below or above: a limit there is none.
    natural: NumberLimits,
    /// How the uncertainty of a figure counts against them.
    guard: GuardBand,
    /// What the clock may be off that the figure depends on.
    clock: ClockError,
    /// How it does.
    clocked: ClockedFigure,
    /// Against a grid of true time: the time of which the figure is off by that part, nanoseconds.
    wanders_over: Option<i64>,
}

impl LimitNumbers {
    /// The limits of a value of this signal; of a time, [`time`].
    ///
    /// # Errors
    /// Why a limit means nothing, one sentence.
    pub(super) fn new(limits: &MeasurementLimits, info: &SignalInfo) -> Result<LimitNumbers, String> {
        let bind = |limit: &Option<Literal>| limit.as_ref().map(|one| number(one, info)).transpose();
        let mut numbers = LimitNumbers {
            limits: NumberLimits { min: bind(&limits.min)?, max: bind(&limits.max)? },
            ..LimitNumbers::default()
        };
        if let Some((nominal, tolerance)) = &limits.nominal {
            let around = ToleranceBand::new(nominal, tolerance, info)?;
            numbers.limits = NumberLimits { min: Some(around.min.into()), max: Some(around.max.into()) };
            numbers.around = around.max.minus(around.middle).map(|tolerance| (around.middle, tolerance));
        }
        match numbers.limits.are_reversed() {
            true => Err("the limits exclude every value".into()),
            false => Ok(numbers),
        }
    }

    /// The same with this guard band.
    fn guarded(self, guard: GuardBand) -> LimitNumbers {
        LimitNumbers { guard, ..self }
    }

    /// What of a figure is held against them: all of it, or without a guard band its middle, exactly. A figure without an
    /// end has none.
    fn judged(&self, (low, high): Extent) -> Extent {
        // What is known exactly is its own middle.
        if low.compare(high) == Some(Ordering::Equal) {
            return (low, high);
        }
        let middle = low.plus(high).times(Number::Real(0.5));
        match self.guard {
            GuardBand::None if middle.as_real().is_finite() => (middle, middle),
            _ => (low, high),
        }
    }

    /// The same of how far edges stand off a grid of true time.
    pub(super) fn of_true_grid(self, wanders_over: i64) -> LimitNumbers {
        LimitNumbers { wanders_over: Some(wanders_over), ..self }
    }

    /// A figure with what the clock may be off.
    fn by_clock(&self, (low, high): Extent) -> Extent {
        match self.wanders_over {
            None => true_figure(self.clock, (low, high), self.clocked),
            Some(_) if self.clock.is_none() => (low, high),
            Some(over) => {
                let off = Number::Int(i128::from(self.clock.of(Span::from_nanos(over)).as_nanos()));
                (low.minus(off).most(Number::ZERO), high.plus(off))
            }
        }
    }

    /// The same for a figure that is never outside of these.
    fn of_kind(self, natural: NumberLimits) -> LimitNumbers {
        LimitNumbers { natural, ..self }
    }
}

/// A time as if it were a signal.
pub(super) fn time() -> SignalInfo {
    let mut info = SignalInfo::exact("time", ValueKind::Int);
    info.unit = "ns".into();
    info
}

/// What takes the measurement.
#[derive(Debug)]
enum GaugeState {
    Between { from: UncertainInstant, to: UncertainInstant, length: (i64, i64) },
    Edge { from: UncertainInstant, finder: EdgeFinder, first: FirstEdge, past: &'static str },
    Value { point: UncertainInstant, info: SignalInfo, reader: ValueReader },
    Over(Box<WindowMeasurement>),
    Position(Box<PositionCounter>),
    Profile(Box<ShapeMeasurement>),
}

/// Follows the signal of one measurement.
#[derive(Debug)]
pub struct Gauge {
    /// Without a guard band and by a clock that may be off: the same by the clock as it is, the reading.
    reading: Option<Box<Gauge>>,
    record: MeasurementRecord,
    bounds: LimitNumbers,
    reach: UnseenReach,
    taking: GaugeState,
}

/// Why a figure that reaches over a limit has no verdict.
const LIMIT_WITHIN: &str = "a limit lies within the uncertainty";

/// Where pulses that nobody saw can take a figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum UnseenReach {
    /// Anywhere.
    Anywhere,
    /// Up: a greatest value.
    Up,
    /// Down: a least value, or the time to a first edge.
    Down,
}

impl UnseenReach {
    fn of(quantity: &MeasuredQuantity) -> UnseenReach {
        match quantity {
            MeasuredQuantity::ToEdge { .. } => UnseenReach::Down,
            MeasuredQuantity::Over { figure: WindowFigure::Value(take), .. } => match take {
                Statistic::Min => UnseenReach::Down,
                Statistic::Max | Statistic::Span => UnseenReach::Up,
                Statistic::First | Statistic::Mean | Statistic::Rms => UnseenReach::Anywhere,
            },
            _ => UnseenReach::Anywhere,
        }
    }

    /// The figure with all that they could make of it.
    fn widened(self, (low, high): Extent) -> Extent {
        let (least, most) = (Number::Real(f64::NEG_INFINITY), Number::Real(f64::INFINITY));
        match self {
            UnseenReach::Anywhere => (least, most),
            UnseenReach::Up => (low, most),
            UnseenReach::Down => (least, high),
        }
    }
}

impl Gauge {
    pub(super) fn new(measurement: &Measurement, scene: &CaseTimeline<'_>) -> Result<Gauge, NotJudged> {
        let reading = match measurement.guard {
            GuardBand::None if !scene.clock.error.is_none() => {
                let clock = ClockLimits::default();
                Some(Box::new(Gauge::new(measurement, &CaseTimeline { clock, ..*scene })?))
            }
            _ => None,
        };
        let mut info = time();
        let taking = match &measurement.quantity {
            MeasuredQuantity::Between { from, to } => {
                let length = scene.time_between(from, to)?;
                GaugeState::Between { from: scene.point(from)?, to: scene.point(to)?, length }
            }
            MeasuredQuantity::ToEdge { from, signal, edge } => {
                let from = scene.point(from)?;
                let finder = EdgeFinder::new(edge.clone(), slack(scene.signal(signal)?));
                GaugeState::Edge {
                    from,
                    finder,
                    first: FirstEdge::new(from, 0, i64::MAX).until(scene.end()),
                    past: edge.past(),
                }
            }
            MeasuredQuantity::Value { signal, when } => {
                let (found, point) = (scene.signal(signal)?, scene.point(when)?);
                info = found.clone();
                GaugeState::Value { point, info: found.clone(), reader: ValueReader::new(point) }
            }
            MeasuredQuantity::Over { signal, from, until, figure } => {
                let found = scene.signal(signal)?;
                info = figure.info(found).map_err(NotJudged::NoMeaning)?;
                let window = scene.window(from, until)?;
                let end = (scene.earliest_end(), scene.end());
                let length = scene.time_between(from, until)?;
                GaugeState::Over(Box::new(WindowMeasurement::new(window, *figure, found, end, length)))
            }
            MeasuredQuantity::Position { train, from, until } => {
                info = figure("position", "");
                GaugeState::Position(Box::new(PositionCounter::new(train, scene, from, until)?))
            }
            MeasuredQuantity::Profile { shaped, from, until } => {
                info = figure("frequency", "Hz");
                GaugeState::Profile(Box::new(shaped.follow(scene, from, until)?))
            }
        };
        let bounds = LimitNumbers::new(&measurement.limits, &info).map_err(NotJudged::NoMeaning)?;
        let bounds = bounds.of_kind(measurement.quantity.natural()).guarded(match reading {
            Some(_) => GuardBand::Uncertainty,
            None => measurement.guard,
        });
        let bounds = match measurement.quantity.by_clock() {
            Some(clocked) => LimitNumbers { clock: scene.clock.error, clocked, ..bounds },
            None => bounds,
        };
        let record = MeasurementRecord {
            name: measurement.name.clone(),
            unit: info.unit,
            min: bounds.limits.min.map(Number::as_real),
            max: bounds.limits.max.map(Number::as_real),
            nominal: bounds.around.map(|(nominal, _)| nominal.as_f64()),
            tolerance: bounds.around.map(|(_, tolerance)| tolerance.as_f64()),
            guard_band: measurement.guard,
            signal: measurement.signals().into_iter().next(),
            what: measurement.quantity.to_string(),
            line: measurement.line(),
            ..MeasurementRecord::default()
        };
        Ok(Gauge { reading, record, bounds, reach: UnseenReach::of(&measurement.quantity), taking })
    }

    /// The next event of the signal at this place among the measurement's.
    #[inline]
    pub fn feed(&mut self, slot: usize, seen: &TimedValue) {
        if let Some(reading) = &mut self.reading {
            reading.feed(slot, seen);
        }
        match &mut self.taking {
            GaugeState::Between { .. } => {}
            GaugeState::Edge { finder, first, .. } => {
                if let Some(found) = finder.see(seen) {
                    first.see(&found);
                }
            }
            GaugeState::Value { reader, .. } => reader.see(seen),
            GaugeState::Over(over) => over.feed(seen),
            GaugeState::Position(counting) => counting.see(slot, seen),
            GaugeState::Profile(following) => following.see(slot, seen),
        }
    }

    /// The record when nothing comes any more. `doubt` is what pulses that nobody saw could do, and why.
    pub(crate) fn finish(mut self, doubt: Option<(UnseenPulses, String)>) -> MeasurementRecord {
        let (bounds, reach, reading) = (self.bounds, self.reach, self.reading.take());
        let reading = reading.map(|reading| reading.finish(doubt.clone()));
        let record = self.of_what_was_seen();
        let record = match doubt {
            Some((unseen, why)) => with_unseen(record, &bounds, reach, unseen, why),
            None => record,
        };
        match reading {
            Some(reading) if record.reason == LIMIT_WITHIN => by_reading(record, reading),
            _ => record,
        }
    }

    fn of_what_was_seen(self) -> MeasurementRecord {
        let Gauge { mut record, bounds, taking, .. } = self;
        let interval = |point: &UncertainInstant| Some([point.a, point.b]);
        match taking {
            GaugeState::Between { from, to, length } => {
                record.from_ns = interval(&from);
                record.to_ns = interval(&to);
                judge(record, &bounds, nanos(length))
            }
            GaugeState::Edge { from, finder, mut first, past } => {
                if let Some(rest) = finder.rest() {
                    first.see(&rest);
                }
                let delay = first.finish();
                record.from_ns = interval(&from);
                record.to_ns = delay.deciding.map(|found| [found.seen.a, found.seen.b]);
                let Some((low, high)) = delay.delay else {
                    record.to_ns = None;
                    if delay.doubtful {
                        return open(record, "the value is not known when it may have ended");
                    }
                    return failed(record, &format!("it did not happen, nothing {past}"));
                };
                let record = judge(record, &bounds, nanos((low, high)));
                if delay.doubtful || delay.can_be_missing {
                    return open(record, "the value is not known at a time when it may have ended earlier");
                }
                record
            }
            GaugeState::Value { point, info, reader } => {
                record.from_ns = interval(&point);
                let candidates = reader.finish();
                let slack = slack(&info);
                let mut extent = None;
                for candidate in &candidates {
                    let value = candidate.seen.value;
                    match Number::of(value).filter(|number| !number.as_real().is_nan()) {
                        Some(number) => {
                            let off = Number::Real(slack + value.uncertainty());
                            extent = Some(widened(extent, (number.minus(off), number.plus(off))));
                        }
                        None => {
                            record.verdict = Verdict::Inconclusive;
                            record.reason = format!("the value is {}", info.show(value));
                            return record;
                        }
                    }
                }
                let Some(extent) = extent else { return open(record, "the value is not known") };
                // A value that changes about the instant is one or the other, and none between them.
                let values: Vec<_> = candidates.iter().map(|candidate| candidate.seen.value).collect();
                let is_one = values.windows(2).all(|pair| pair[0] == pair[1]);
                let bounds = if is_one { bounds } else { bounds.guarded(GuardBand::Uncertainty) };
                judge(record, &bounds, extent)
            }
            GaugeState::Over(over) => over.finish(record, &bounds),
            GaugeState::Position(counting) => {
                let (sum, window) = counting.finish();
                record.from_ns = interval(&window.from);
                record.to_ns = interval(&window.until);
                let record = judge(record, &bounds, sum.figure());
                seen_whole(record, sum.doubtful)
            }
            GaugeState::Profile(following) => {
                let (found, window) = following.finish();
                record.from_ns = interval(&window.from);
                record.to_ns = interval(&window.until);
                if found.counts.1 == 0 && !found.doubtful {
                    return failed(record, "nothing counted in the window");
                }
                let record =
                    judge(record, &bounds, (Number::Real(found.needed.0), Number::Real(found.needed.1)));
                match found.counts.0 {
                    0 if !found.doubtful && record.verdict != Verdict::Fail => {
                        open(record, "it is open whether anything counted in the window")
                    }
                    _ => seen_whole(record, found.doubtful),
                }
            }
        }
    }
}

/// Least and greatest time as a figure.
pub(super) fn nanos((low, high): (i64, i64)) -> Extent {
    (Number::Int(i128::from(low)), Number::Int(i128::from(high)))
}

/// The verdict on a figure of this extent.
pub(super) fn judge(
    mut record: MeasurementRecord,
    bounds: &LimitNumbers,
    extent: Extent,
) -> MeasurementRecord {
    let extent = bounds.by_clock(extent);
    record.value = Some([extent.0.reals().0, extent.1.reals().1]);
    let limits = bounds.limits;
    if !limits.any() {
        return record;
    }
    let judged = bounds.judged(extent);
    let margin = limits.passable(bounds.natural).margin(judged);
    record.margin = margin.map(|margin| Figure::new(margin, record.unit.clone()));
    (record.verdict, record.reason) = match limits.hold(judged) {
        (true, false) => (Verdict::Pass, String::new()),
        (false, _) => {
            let over = limits.max.is_some_and(|max| judged.0.is_above(max));
            (Verdict::Fail, String::from(if over { "too large" } else { "too small" }))
        }
        (true, true) => (Verdict::Inconclusive, String::from(LIMIT_WITHIN)),
    };
    if limits.hold(extent) == (true, true) && record.verdict != Verdict::Inconclusive {
        record.by_middle = true;
        record.reason = by_middle(&record);
    }
    record
}

/// Why a verdict is that of the middle alone.
fn by_middle(record: &MeasurementRecord) -> String {
    let sense = if record.verdict == Verdict::Pass { "accepted" } else { record.reason.as_str() };
    format!("{sense} by its middle: {LIMIT_WITHIN} and `guard` is \"none\"")
}

/// The verdict of the reading, where only what the clock may be off leaves it open.
fn by_reading(record: MeasurementRecord, reading: MeasurementRecord) -> MeasurementRecord {
    if !matches!(reading.verdict, Verdict::Pass | Verdict::Fail) {
        return record;
    }
    let reason = if reading.by_middle { reading.reason } else { by_middle(&reading) };
    MeasurementRecord { verdict: reading.verdict, margin: reading.margin, by_middle: true, reason, ..record }
}

/// The same, open where something may have gone unseen.
fn seen_whole(record: MeasurementRecord, doubtful: bool) -> MeasurementRecord {
    if doubtful { open(record, "a signal is not known for a part of the window") } else { record }
}

/// The same, open as far as pulses that nobody saw leave it so. A figure without limits is what was seen, and says so.
fn with_unseen(
    mut record: MeasurementRecord,
    bounds: &LimitNumbers,
    reach: UnseenReach,
    unseen: UnseenPulses,
    why: String,
) -> MeasurementRecord {
    let (can_hold, can_break) = match record.value {
        Some(value) => {
            let [low, high] = value.map(Number::Real);
            bounds.limits.hold(reach.widened(bounds.judged((low, high))))
        }
        // Nothing was seen that could be measured.
        None => (true, false),
    };
    match record.verdict {
        Verdict::None => record.reason = why,
        Verdict::Pass if can_break => return open(record, &why),
        Verdict::Fail if can_hold && unseen == UnseenPulses::Decide => return open(record, &why),
        _ => {}
    }
    record
}

/// The same, open where it was a pass or had no verdict.
pub(super) fn open(mut record: MeasurementRecord, why: &str) -> MeasurementRecord {
    record.verdict = Verdict::Inconclusive;
    record.by_middle = false;
    record.reason = why.to_owned();
    record
}

/// A measurement that could not be taken because what it measures did not come.
pub(super) fn failed(mut record: MeasurementRecord, why: &str) -> MeasurementRecord {
    record.verdict = Verdict::Fail;
    record.reason = why.to_owned();
    record
}
