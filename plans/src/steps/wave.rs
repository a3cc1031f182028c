//! `ramp`, `sine`, `square`, `triangle` and `noise`: values that change over time by a rule.
//!
//! Square waves have their edges where they belong; the others change every `sample`. All that is written is kept
//! exactly: which value a channel gets at which instant is worked out where its unit is known.

use document::{Data, Fields, Findings, KeySpec, KeyType, Node};
use signal::{Decimal, Quantity, QuantityRange, Span, Unit};

use super::cycle::{ExactPeriod, FREQUENCY, PERIOD, millionths, part};
use super::drive::above_zero;
use super::{MAX_PULSES, StepVerb, Stimulus};
use super::{StepNames, table_fields};
use crate::codes;

/// Most values that a wave goes through, as far as its length is known before the case runs.
pub const MAX_SAMPLES: i64 = 10_000_000;
/// Fewest values of a period: with fewer it is another wave.
const LEAST_SAMPLES: u64 = 4;
/// How often a value changes where the plan does not say.
const SAMPLE_PERIOD: Span = Span::from_millis(1);

const SIGNAL: KeySpec =
    KeySpec::required("signal", KeyType::SignalRef, "The line or channel that is driven.");
const RANGE: KeySpec =
    KeySpec::required("range", KeyType::Range, "From the least to the greatest value, as in \"4 .. 20 mA\".");
const SAMPLE: KeySpec =
    KeySpec::optional("sample", KeyType::Duration, "Time from one value to the next; 1 ms if left out.");
const LASTS: KeySpec = KeySpec::optional(
    "duration",
    KeyType::Duration,
    "How long it lasts; until something else drives the line if left out.",
)
.was("lasts");
const COUNT: KeySpec = KeySpec::optional(
    "count",
    KeyType::Integer(1, MAX_PULSES as i64),
    "How many periods, in place of `duration`.",
);
const PHASE: KeySpec = KeySpec::optional(
    "phase",
    KeyType::Text,
    "Where in its period it begins, as in \"90 deg\" or \"25 %\"; at its beginning if left out.",
);

const RAMP_KEYS: &[KeySpec] = &[
    SIGNAL,
    KeySpec::optional("from", KeyType::Quantity, "Where it begins; where the line is if left out."),
    KeySpec::required("to", KeyType::Quantity, "Where it ends."),
    KeySpec::required("duration", KeyType::Duration, "How long it takes.").was("lasts"),
    SAMPLE,
];

const SINE_KEYS: &[KeySpec] = &[SIGNAL, RANGE, FREQUENCY, PERIOD, PHASE, LASTS, COUNT, SAMPLE];

const TRIANGLE_KEYS: &[KeySpec] = &[
    SIGNAL,
    RANGE,
    FREQUENCY,
    PERIOD,
    PHASE,
    LASTS,
    COUNT,
    SAMPLE,
    KeySpec::optional(
        "rise",
        KeyType::Text,
        "Part of the period in which it rises, from \"0 %\" to \"100 %\"; half if left out.",
    ),
];

const SQUARE_KEYS: &[KeySpec] = &[
    SIGNAL,
    KeySpec::optional(
        "range",
        KeyType::Range,
        "Its two values, as in \"0 .. 5 V\"; FALSE and TRUE if left out.",
    ),
    FREQUENCY,
    PERIOD,
    PHASE,
    LASTS,
    COUNT,
    KeySpec::optional(
        "duty",
        KeyType::Text,
        "Part of the period that is high, as in \"25 %\"; half if left out.",
    ),
];

const NOISE_KEYS: &[KeySpec] = &[
    SIGNAL,
    RANGE,
    KeySpec::optional(
        "deviation",
        KeyType::Quantity,
        "Standard deviation of a normal distribution around the middle of the range; uniform if left out.",
    ),
    LASTS,
    SAMPLE,
];

pub(super) const RAMP: StepVerb = StepVerb {
    name: "ramp",
    doc: "Drives a channel evenly from one value to another.",
    value: KeyType::Table(RAMP_KEYS),
    needs: &[],
    read: read_ramp,
};

pub(super) const SINE: StepVerb = StepVerb {
    name: "sine",
    doc: "Drives a channel with a sine wave.",
    value: KeyType::Table(SINE_KEYS),
    needs: &[],
    read: |node, scope, out| read_periodic(node, SINE_KEYS, "sine", scope, out),
};

pub(super) const TRIANGLE: StepVerb = StepVerb {
    name: "triangle",
    doc: "Drives a channel with a triangle or a sawtooth.",
    value: KeyType::Table(TRIANGLE_KEYS),
    needs: &[],
    read: |node, scope, out| read_periodic(node, TRIANGLE_KEYS, "triangle", scope, out),
};

pub(super) const SQUARE: StepVerb = StepVerb {
    name: "square",
    doc: "Drives a line or channel with a square wave.",
    value: KeyType::Table(SQUARE_KEYS),
    needs: &[],
    read: |node, scope, out| read_periodic(node, SQUARE_KEYS, "square", scope, out),
};

pub(super) const NOISE: StepVerb = StepVerb {
    name: "noise",
    doc: "Drives a channel with values out of the seed.",
    value: KeyType::Table(NOISE_KEYS),
    needs: &[],
    read: read_noise,
};

/// Values of a line over time, by a rule.
#[derive(Clone, Debug, PartialEq)]
pub struct WaveStimulus {
    /// The line or channel.
    pub signal: String,
    /// The rule.
    pub shape: StimulusShape,
    /// How long it lasts, above 0; `None`: until something else drives the line, or the end.
    pub lasts: Option<Span>,
    /// From one value to the next, above 0. A square wave has its edges instead.
    pub sample: Span,
}

/// The rule by which a value changes.
#[derive(Clone, Debug, PartialEq)]
pub enum StimulusShape {
    /// Evenly from one value to another.
    Ramp {
        /// Where it begins; `None`: where the line is.
        from: Option<Quantity>,
        /// Where it ends.
        to: Quantity,
    },
    /// A sine: from the middle of its range upwards.
    Sine(PeriodicWave),
    /// A triangle: from the least value upwards.
    Triangle {
        /// What it has of every period.
        periodic: PeriodicWave,
        /// Millionths of the period in which it rises, 0 ..= 1 000 000.
        rise: u32,
    },
    /// A square wave: high, then low.
    Square {
        /// What it has of every period.
        periodic: PeriodicWave,
        /// Millionths of the period that are high, above 0 and below 1 000 000.
        duty: u32,
    },
    /// A new value out of the seed at every sample.
    Noise {
        /// From the least to the greatest value; both ends are there.
        range: QuantityRange,
        /// Standard deviation around the middle, above 0; `None`: every value of the range is as likely.
        deviation: Option<Quantity>,
    },
}

/// What repeats.
#[derive(Clone, Debug, PartialEq)]
pub struct PeriodicWave {
    /// From the least to the greatest value, both ends there; `None`: FALSE and TRUE.
    pub range: Option<QuantityRange>,
    /// The period.
    pub cycle: ExactPeriod,
    /// Where in its period it begins, in parts of [`PeriodicWave::WHOLE`].
    pub phase: u32,
    /// How many whole periods it lasts, where the plan says that.
    pub count: Option<u32>,
}

impl PeriodicWave {
    /// A period in the parts that a phase is given in: both a millionth of it and a millionth of a degree are whole.
    pub const WHOLE: u32 = 360_000_000;
}

impl WaveStimulus {
    /// Edges that a line must be able to follow, in thousandths of a Hertz, where it is a line.
    pub fn millihertz(&self) -> Option<u64> {
        match &self.shape {
            StimulusShape::Square { periodic: PeriodicWave { range: None, cycle, .. }, .. } => {
                Some(cycle.millihertz())
            }
            _ => None,
        }
    }

    /// The shortest time that a square wave keeps a level; 0 of any other wave.
    pub fn shortest(&self) -> Span {
        match &self.shape {
            StimulusShape::Square { periodic, duty } => {
                let high = periodic.cycle.after(u128::from(*duty), 1_000_000);
                high.min(periodic.cycle.after(1, 1) - high)
            }
            _ => Span::ZERO,
        }
    }

    /// How many values it goes through in so long a time, in nanoseconds.
    pub fn values_in(&self, nanos: i128) -> i128 {
        let apart = match &self.shape {
            // Of a square wave the two edges of a period count.
            StimulusShape::Square { periodic, .. } => periodic.cycle.after(1, 2),
            _ => self.sample,
        };
        nanos.max(0) / i128::from(apart.as_nanos().max(1))
    }

    /// The verb that it is written with.
    pub fn verb(&self) -> &'static str {
        match self.shape {
            StimulusShape::Ramp { .. } => "ramp",
            StimulusShape::Sine(_) => "sine",
            StimulusShape::Triangle { .. } => "triangle",
            StimulusShape::Square { .. } => "square",
            StimulusShape::Noise { .. } => "noise",
        }
    }
}

fn read_ramp(node: &Node, scope: &dyn StepNames, out: &mut Findings) -> Option<Stimulus> {
    let fields = table_fields(node, RAMP_KEYS)?;
    let signal = scope.signal(fields.get("signal")?, out);
    let from = quantity(&fields, "from");
    let to = quantity(&fields, "to")?;
    let lasts = above_zero(&fields, "duration", out)?;
    if let Some(from) = &from
        && !from.unit.is_none()
        && !to.unit.is_none()
        && from.in_unit(&to.unit).or_else(|| to.in_unit(&from.unit)).is_none()
    {
        let message = format!("a ramp cannot go from {from} to {to}");
        out.bad(codes::UNIT, fields.get("from")?, message, "give both ends in units of one kind");
        return None;
    }
    let sample = sample(&fields, Some(lasts), None, out)?;
    Some(Stimulus::Wave(WaveStimulus {
        signal: signal?,
        shape: StimulusShape::Ramp { from, to },
        lasts: Some(lasts),
        sample,
    }))
}

fn read_noise(node: &Node, scope: &dyn StepNames, out: &mut Findings) -> Option<Stimulus> {
    let fields = table_fields(node, NOISE_KEYS)?;
    let signal = scope.signal(fields.get("signal")?, out);
    let range = range(&fields, out)?;
    let deviation = quantity(&fields, "deviation");
    if let Some(deviation) = &deviation
        && !fits(deviation, &range)
    {
        let message = format!("{deviation} cannot be the standard deviation of values in this range");
        let help = "a quantity above 0 and at most as wide as the range, as in deviation = \"0.1 V\"";
        out.bad(codes::WAVE, fields.get("deviation")?, message, help);
        return None;
    }
    let lasts = if fields.has("duration") { Some(above_zero(&fields, "duration", out)?) } else { None };
    let sample = sample(&fields, lasts, None, out)?;
    Some(Stimulus::Wave(WaveStimulus {
        signal: signal?,
        shape: StimulusShape::Noise { range, deviation },
        lasts,
        sample,
    }))
}

fn read_periodic(
    node: &Node,
    keys: &'static [KeySpec],
    verb: &str,
    scope: &dyn StepNames,
    out: &mut Findings,
) -> Option<Stimulus> {
    let fields = table_fields(node, keys)?;
    // Every edge of a square wave counts, as every pulse of a train does.
    let signal = match verb {
        "square" => scope.whole_signal(fields.get("signal")?, out),
        _ => scope.signal(fields.get("signal")?, out),
    };
    let range = if fields.has("range") { Some(range(&fields, out)?) } else { None };
    let cycle = ExactPeriod::read(&fields, node, &format!("{verb} wave"), out)?;
    let phase = phase(&fields, out)?;
    if let (true, Some(place)) = (fields.has("duration"), fields.get("count")) {
        let message = "the wave has both `duration` and `count`";
        out.bad(codes::WAVE, place, message, "leave one of them");
        return None;
    }
    let count = fields.integer("count").and_then(|count| u32::try_from(count).ok());
    let lasts = match count {
        Some(count) => Some(cycle.after(u128::from(count), 1)),
        None if fields.has("duration") => Some(above_zero(&fields, "duration", out)?),
        None => None,
    };
    if lasts == Some(Span::MAX) {
        out.bad(codes::WAVE, node, "the wave lasts longer than 292 years", "lower its `count`");
        return None;
    }
    let periodic = PeriodicWave { range, cycle, phase, count };
    let (shape, sample) = match verb {
        "square" => {
            let duty = part(&fields, "duty", out)?;
            let high = cycle.after(u128::from(duty), 1_000_000);
            if high.min(cycle.after(1, 1) - high) <= Span::ZERO {
                let message = "a pulse of the wave, or the pause after it, is shorter than 1 ns";
                out.bad(codes::WAVE, node, message, "lower the frequency, or take a duty nearer to 50 %");
                return None;
            }
            (StimulusShape::Square { periodic, duty }, cycle.after(1, 1))
        }
        "triangle" => {
            let sample = sample(&fields, lasts, Some(cycle), out)?;
            (StimulusShape::Triangle { periodic, rise: rise(&fields, out)? }, sample)
        }
        _ => (StimulusShape::Sine(periodic), sample(&fields, lasts, Some(cycle), out)?),
    };
    Some(Stimulus::Wave(WaveStimulus { signal: signal?, shape, lasts, sample }))
}

/// A number or quantity that was held against its type.
fn quantity(fields: &Fields<'_>, key: &str) -> Option<Quantity> {
    let node = fields.get(key)?;
    match &node.data {
        Data::Integer(number) => {
            Some(Quantity { number: Decimal::from(i128::from(*number)), unit: Unit::NONE })
        }
        Data::Float(text) => Quantity::parse(text).ok(),
        _ => Quantity::parse(node.as_text()?).ok(),
    }
}

/// The two ends of `range`.
fn range(fields: &Fields<'_>, out: &mut Findings) -> Option<QuantityRange> {
    let node = fields.get("range")?;
    let range = node.as_text().and_then(|text| QuantityRange::parse(text).ok());
    let whole = range.filter(|range| ends(range).is_some_and(|(min, max, _)| min < max));
    if whole.is_none() {
        let message = "`range` has no two ends that differ";
        out.bad(codes::WAVE, node, message, "write the least and the greatest value, as in \"4 .. 20 mA\"");
    }
    whole
}

/// The two ends of a range as numbers of one unit.
fn ends(range: &QuantityRange) -> Option<(Decimal, Decimal, &Unit)> {
    let (min, max) = (range.min.as_ref()?, range.max.as_ref()?);
    match max.in_unit(&min.unit) {
        Some(most) => Some((min.number, most, &min.unit)),
        None => Some((min.in_unit(&max.unit)?, max.number, &max.unit)),
    }
}

/// Whether this can be the standard deviation of values in a range.
fn fits(deviation: &Quantity, range: &QuantityRange) -> bool {
    let fits = |(min, max, unit): (Decimal, Decimal, &Unit)| {
        let (deviation, width) = (deviation.in_unit(unit)?, max.minus(min)?);
        Some(deviation > Decimal::ZERO && deviation <= width)
    };
    ends(range).and_then(fits).unwrap_or(false)
}

/// The time from one value to the next, held against the length of the wave and of its period.
fn sample(
    fields: &Fields<'_>,
    lasts: Option<Span>,
    cycle: Option<ExactPeriod>,
    out: &mut Findings,
) -> Option<Span> {
    let sample = if fields.has("sample") { above_zero(fields, "sample", out)? } else { SAMPLE_PERIOD };
    let place = fields.get("sample").or_else(|| fields.get("frequency")).or_else(|| fields.get("period"));
    let place = place.or_else(|| fields.get("duration")).or_else(|| fields.get("signal"))?;
    let period = cycle.map(|cycle| cycle.after(1, 1));
    if let Some(period) = period
        && u64::try_from(period.as_nanos() / sample.as_nanos()).unwrap_or(0) < LEAST_SAMPLES
    {
        let message = format!("a value every {sample} is too seldom for a period of {period}");
        let help = format!("{LEAST_SAMPLES} values in a period are the fewest: shorten `sample`");
        out.bad(codes::SAMPLES, place, message, help);
        return None;
    }
    if let Some(lasts) = lasts
        && lasts.as_nanos() / sample.as_nanos() > MAX_SAMPLES
    {
        let message = format!("a value every {sample} for {lasts} are too many");
        let help = format!("{MAX_SAMPLES} values are the most: lengthen `sample`");
        out.bad(codes::SAMPLES, place, message, help);
        return None;
    }
    Some(sample)
}

/// Where in its period a wave begins.
fn phase(fields: &Fields<'_>, out: &mut Findings) -> Option<u32> {
    let Some(node) = fields.get("phase") else { return (!fields.has("phase")).then_some(0) };
    let degrees = || -> Option<u32> {
        let degrees = Quantity::parse(node.as_text()?).ok()?.in_unit(&Unit::new("deg"))?;
        u32::try_from(degrees.shifted(6).as_whole()?).ok()
    };
    let read = millionths(node).and_then(|part| part.checked_mul(360)).or_else(degrees);
    let read = read.filter(|phase| *phase < PeriodicWave::WHOLE);
    if read.is_none() {
        let message = "`phase` is not a place in the period";
        let help = "write degrees below 360 or per cent below 100, as in \"90 deg\" or \"25 %\"";
        out.bad(codes::UNIT, node, message, help);
    }
    read
}

/// The part of the period in which a triangle rises.
fn rise(fields: &Fields<'_>, out: &mut Findings) -> Option<u32> {
    let Some(node) = fields.get("rise") else { return (!fields.has("rise")).then_some(500_000) };
    let read = millionths(node).filter(|rise| *rise <= 1_000_000);
    if read.is_none() {
        let help =
            "write per cent from 0 to 100: \"100 %\" makes a sawtooth that rises, \"0 %\" one that falls";
        out.bad(codes::UNIT, node, "`rise` is not a part of the period", help);
    }
    read
}
