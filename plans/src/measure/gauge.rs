//! Taking a measurement.

use std::cmp::Ordering;

use record::{Figure, GuardBand, MeasurementRecord, Verdict};
use signal::{Decimal, SignalInfo, ValueKind};

use super::window::WindowMeasurement;
use super::{MeasuredQuantity, Measurement, MeasurementLimits, Statistic, WindowFigure};
use crate::expect::band::figure;
use crate::expect::position::PositionCounter;
use crate::expect::profile::ShapeMeasurement;
use crate::lang::Literal;
use crate::meaning::{ToleranceBand, number};
use crate::monitor::edges::{EdgeFinder, FirstEdge};
use crate::monitor::reading::ValueReader;
use crate::monitor::{CaseTimeline, NotJudged, Number, TimedValue, UncertainInstant, UnseenPulses, slack};

/// Limits as numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct LimitNumbers {
    min: Option<f64>,
    max: Option<f64>,
    nominal: Option<f64>,
    tolerance: Option<f64>,
    /// A limit is a whole number that no float is.
    rounded: bool,
    /// How the uncertainty of a figure counts against them.
    guard: GuardBand,
}

/// One end of what is held against limits.
#[derive(Clone, Copy, Debug)]
enum JudgedEnd {
    /// A number.
    At(f64),
    /// The middle of a figure: the sum of its ends, exactly, and half of that as the nearest float.
    Middle(Option<Decimal>, f64),
}

impl JudgedEnd {
    /// The middle of a figure; none of one without an end. Floats are met as the decimal numbers that they were written as:
    /// the middle of 0.45 and 0.55 is 0.5.
    fn middle(low: f64, high: f64) -> Option<JudgedEnd> {
        let middle = low / 2.0 + high / 2.0;
        let sum = || Decimal::from_f64(low)?.plus(Decimal::from_f64(high)?);
        middle.is_finite().then(|| JudgedEnd::Middle(sum(), middle))
    }

    fn compare(self, limit: f64) -> Option<Ordering> {
        let near = match self {
            JudgedEnd::At(number) => return number.partial_cmp(&limit),
            JudgedEnd::Middle(sum, near) => {
                let twice = Decimal::from_f64(limit).and_then(|limit| limit.plus(limit));
                if let (Some(sum), Some(twice)) = (sum, twice) {
                    return Some(sum.cmp(&twice));
                }
                near
            }
        };
        near.partial_cmp(&limit)
    }

    fn is_at_most(self, limit: f64) -> bool {
        self.compare(limit).is_some_and(Ordering::is_le)
    }

    fn is_at_least(self, limit: f64) -> bool {
        self.compare(limit).is_some_and(Ordering::is_ge)
    }
}

impl LimitNumbers {
    /// The limits of a value of this signal; of a time, [`time`].
    ///
    /// # Errors
    /// Why a limit means nothing, one sentence.
    pub(super) fn new(limits: &MeasurementLimits, info: &SignalInfo) -> Result<LimitNumbers, String> {
        let bind = |limit: &Option<Literal>| limit.as_ref().map(|one| number(one, info)).transpose();
        let (min, max) = (bind(&limits.min)?, bind(&limits.max)?);
        let rounded = |limit: Option<Number>| limit.is_some_and(|limit| limit.reals().0 < limit.reals().1);
        let mut bounds = LimitNumbers {
            min: min.map(Number::as_real),
            max: max.map(Number::as_real),
            rounded: rounded(min) || rounded(max),
            ..LimitNumbers::default()
        };
        if let Some((nominal, tolerance)) = &limits.nominal {
            let around = ToleranceBand::new(nominal, tolerance, info)?;
            bounds.nominal = Some(around.middle.as_f64());
            bounds.tolerance = around.max.minus(around.middle).map(Decimal::as_f64);
            bounds.min = Some(around.min.as_f64());
            bounds.max = Some(around.max.as_f64());
        }
        match (bounds.min, bounds.max) {
            (Some(min), Some(max)) if min > max => Err("the limits exclude every value".into()),
            _ => Ok(bounds),
        }
    }

    /// The same with this guard band.
    pub(super) fn guarded(self, guard: GuardBand) -> LimitNumbers {
        LimitNumbers { guard, ..self }
    }

    pub(super) fn any(&self) -> bool {
        self.min.is_some() || self.max.is_some()
    }

    /// What of a figure is held against them: both ends, or without a guard band its middle.
    fn judged(&self, low: f64, high: f64) -> [JudgedEnd; 2] {
        let middle = match self.guard {
            GuardBand::Uncertainty => None,
            GuardBand::None => JudgedEnd::middle(low, high),
        };
        middle.map_or([JudgedEnd::At(low), JudgedEnd::At(high)], |middle| [middle; 2])
    }

    /// Whether a value between the ends can be inside the limits, and whether it can be outside.
    fn hold(&self, [low, high]: [JudgedEnd; 2]) -> (bool, bool) {
        let min = self.min.unwrap_or(f64::NEG_INFINITY);
        let max = self.max.unwrap_or(f64::INFINITY);
        let around = |limit: f64| match self.rounded {
            true => (limit.next_down(), limit.next_up()),
            false => (limit, limit),
        };
        let (min, max) = (around(min), around(max));
        let inside = low.is_at_least(min.1) && high.is_at_most(max.0);
        (low.is_at_most(max.1) && high.is_at_least(min.0), !inside)
    }

    fn margin(&self, low: f64, high: f64) -> Option<f64> {
        let middle = low + (high - low) / 2.0;
        let (low, high) = match self.guard {
            GuardBand::None if middle.is_finite() => (middle, middle),
            _ => (low, high),
        };
        let below = self.max.map(|max| max - high);
        let above = self.min.map(|min| low - min);
        match (below, above) {
            (Some(below), Some(above)) => Some(below.min(above)),
            (one, other) => one.or(other),
        }
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
    Between(UncertainInstant, UncertainInstant),
    Edge { from: UncertainInstant, finder: EdgeFinder, first: FirstEdge, past: &'static str },
    Value { point: UncertainInstant, info: SignalInfo, reader: ValueReader },
    Over(Box<WindowMeasurement>),
    Position(Box<PositionCounter>),
    Profile(Box<ShapeMeasurement>),
}

/// Follows the signal of one measurement.
#[derive(Debug)]
pub struct Gauge {
    record: MeasurementRecord,
    bounds: LimitNumbers,
    reach: UnseenReach,
    taking: GaugeState,
}

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

    fn widened(self, [low, high]: [JudgedEnd; 2]) -> [JudgedEnd; 2] {
        let (least, most) = (JudgedEnd::At(f64::NEG_INFINITY), JudgedEnd::At(f64::INFINITY));
        match self {
            UnseenReach::Anywhere => [least, most],
            UnseenReach::Up => [low, most],
            UnseenReach::Down => [least, high],
        }
    }
}

impl Gauge {
    pub(super) fn new(measurement: &Measurement, scene: &CaseTimeline<'_>) -> Result<Gauge, NotJudged> {
        let mut info = time();
        let taking = match &measurement.quantity {
            MeasuredQuantity::Between { from, to } => {
                GaugeState::Between(scene.point(from)?, scene.point(to)?)
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
                GaugeState::Over(Box::new(WindowMeasurement::new(
                    window,
                    *figure,
                    found,
                    (scene.earliest_end(), scene.end()),
                )))
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
        let bounds = bounds.guarded(measurement.guard);
        let record = MeasurementRecord {
            name: measurement.name.clone(),
            unit: info.unit,
            min: bounds.min,
            max: bounds.max,
            nominal: bounds.nominal,
            tolerance: bounds.tolerance,
            guard_band: measurement.guard,
            signal: measurement.signals().into_iter().next(),
            what: measurement.quantity.to_string(),
            line: measurement.line(),
            ..MeasurementRecord::default()
        };
        Ok(Gauge { record, bounds, reach: UnseenReach::of(&measurement.quantity), taking })
    }

    /// The next event of the signal at this place among the measurement's.
    #[inline]
    pub fn feed(&mut self, slot: usize, seen: &TimedValue) {
        match &mut self.taking {
            GaugeState::Between(..) => {}
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
    pub(crate) fn finish(self, doubt: Option<(UnseenPulses, String)>) -> MeasurementRecord {
        let (bounds, reach) = (self.bounds, self.reach);
        let record = self.of_what_was_seen();
        match doubt {
            Some((unseen, why)) => with_unseen(record, &bounds, reach, unseen, why),
            None => record,
        }
    }

    fn of_what_was_seen(self) -> MeasurementRecord {
        let Gauge { mut record, bounds, taking, .. } = self;
        let interval = |point: &UncertainInstant| Some([point.a, point.b]);
        match taking {
            GaugeState::Between(from, to) => {
                record.from_ns = interval(&from);
                record.to_ns = interval(&to);
                let extent = match from.link(&to) {
                    Some(length) => (length, length),
                    None => (to.a.saturating_sub(from.b), to.b.saturating_sub(from.a)),
                };
                judge(record, &bounds, extent.0 as f64, extent.1 as f64)
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
                let record = judge(record, &bounds, low as f64, high as f64);
                if delay.doubtful || delay.can_be_missing {
                    return open(record, "the value is not known at a time when it may have ended earlier");
                }
                record
            }
            GaugeState::Value { point, info, reader } => {
                record.from_ns = interval(&point);
                let candidates = reader.finish();
                let slack = slack(&info);
                let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
                for candidate in &candidates {
                    let reals = Number::of(candidate.seen.value).map(Number::reals);
                    match reals.filter(|(low, _)| !low.is_nan()) {
                        Some((least, most)) => {
                            let slack = slack + candidate.seen.value.uncertainty();
                            (low, high) = (low.min(least - slack), high.max(most + slack));
                        }
                        None => {
                            record.verdict = Verdict::Inconclusive;
                            let shown = info.show(candidate.seen.value);
                            record.reason = format!("the value is {shown}");
                            return record;
                        }
                    }
                }
                judge(record, &bounds, low, high)
            }
            GaugeState::Over(over) => over.finish(record, &bounds),
            GaugeState::Position(counting) => {
                let (sum, window) = counting.finish();
                record.from_ns = interval(&window.from);
                record.to_ns = interval(&window.until);
                let record = judge(record, &bounds, sum.extent.0 as f64, sum.extent.1 as f64);
                seen_whole(record, sum.doubtful)
            }
            GaugeState::Profile(following) => {
                let (found, window) = following.finish();
                record.from_ns = interval(&window.from);
                record.to_ns = interval(&window.until);
                if found.counts.1 == 0 && !found.doubtful {
                    return failed(record, "nothing counted in the window");
                }
                let record = judge(record, &bounds, found.needed.0, found.needed.1);
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

/// The verdict on a value that lies in an interval.
pub(super) fn judge(
    mut record: MeasurementRecord,
    bounds: &LimitNumbers,
    low: f64,
    high: f64,
) -> MeasurementRecord {
    record.value = Some([low, high]);
    if !bounds.any() {
        return record;
    }
    record.margin = bounds.margin(low, high).map(|margin| Figure::new(margin, record.unit.clone()));
    let judged = bounds.judged(low, high);
    (record.verdict, record.reason) = match bounds.hold(judged) {
        (true, false) => (Verdict::Pass, String::new()),
        (false, _) => {
            let over = bounds.max.is_some_and(|max| !judged[0].is_at_most(max));
            (Verdict::Fail, String::from(if over { "too large" } else { "too small" }))
        }
        (true, true) => (Verdict::Inconclusive, String::from("a limit lies within the uncertainty")),
    };
    let proven = bounds.guarded(GuardBand::Uncertainty).hold([low, high].map(JudgedEnd::At));
    if proven == (true, true) && record.verdict != Verdict::Inconclusive {
        let sense = if record.verdict == Verdict::Pass { "accepted" } else { record.reason.as_str() };
        record.reason =
            format!("{sense} by its middle: a limit lies within the uncertainty and `guard` is \"none\"");
    }
    record
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
        Some([low, high]) => bounds.hold(reach.widened(bounds.judged(low, high))),
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
    record.reason = why.to_owned();
    record
}

/// A measurement that could not be taken because what it measures did not come.
pub(super) fn failed(mut record: MeasurementRecord, why: &str) -> MeasurementRecord {
    record.verdict = Verdict::Fail;
    record.reason = why.to_owned();
    record
}
