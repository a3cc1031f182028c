//! `encoder`: the lines of an incremental encoder whose shaft turns by a profile.
//!
//! Every count is an edge of A or of B, four to a line of the disc. An edge comes when the shaft has turned by its
//! whole count, worked out in whole numbers, so that neither the number of counts nor an instant is ever rounded off.

use document::{Data, Fields, Findings, KeySpec, KeyType, Node};
use signal::{Quantity, Span, Unit};

use super::drive::above_zero;
use super::{MAX_PULSES, StepVerb, Stimulus};
use super::{StepNames, table_fields};
use crate::codes;
use crate::lang::millihertz;

/// Most motions of one step.
const MAX_MOTIONS: usize = 1_000;
/// Furthest from 0 that a position lies.
const FURTHEST: i64 = 1_000_000_000_000;
/// Longest acceleration.
const LONGEST_RAMP: Span = Span::from_secs(100);
/// Counts in a line of the disc.
const COUNTS_IN_LINE: u32 = 4;
/// Bits after the point of a nanosecond in which instants are worked out.
const FINE: u32 = 8;

const MOTION_KEYS: &[KeySpec] = &[
    KeySpec::optional(
        "by",
        KeyType::Integer(-(MAX_PULSES as i64), MAX_PULSES as i64),
        "Counts that it turns by; below 0 backwards.",
    ),
    KeySpec::optional("to", KeyType::Integer(-FURTHEST, FURTHEST), "Position that it turns to, in counts."),
    KeySpec::optional(
        "speed",
        KeyType::Text,
        "How fast: counts per time as in \"20 kHz\", or with `lines` turns as in \"1500 rpm\".",
    ),
    KeySpec::optional(
        "ramp",
        KeyType::Duration,
        "Time from standstill to the speed, and back at the end; none if left out.",
    ),
    KeySpec::optional("pause", KeyType::Duration, "How long it stands still, in place of a motion."),
];
const MOTION: KeyType = KeyType::Table(MOTION_KEYS);

const KEYS: &[KeySpec] = &[
    KeySpec::required("a", KeyType::SignalRef, "Line A; it leads B while the shaft turns forwards."),
    KeySpec::required("b", KeyType::SignalRef, "Line B."),
    KeySpec::optional("index", KeyType::SignalRef, "Line of the index, high for one count in every turn."),
    KeySpec::optional("lines", KeyType::Integer(1, 1_000_000), "Lines of the disc: periods of A in a turn."),
    KeySpec::optional(
        "from",
        KeyType::Integer(-FURTHEST, FURTHEST),
        "Position in which it begins, in counts; 0 if left out.",
    ),
    KeySpec::required("moves", KeyType::OneOrMore(&MOTION), "What the shaft does, one after another."),
];

pub(super) const ENCODER: StepVerb = StepVerb {
    name: "encoder",
    doc: "Emits what an incremental encoder emits as its shaft turns.",
    value: KeyType::Table(KEYS),
    needs: &["pulse"],
    read,
};

/// An encoder and what its shaft does.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Encoder {
    /// Line A.
    pub a: String,
    /// Line B.
    pub b: String,
    /// The index, with the counts of a turn.
    pub index: Option<(String, i64)>,
    /// Position in which it begins, in counts.
    pub from: i64,
    motions: Vec<ShaftMotion>,
    lasts: Span,
}

/// A motion of a shaft: evenly faster, at its speed, evenly slower.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShaftMotion {
    /// How long after the step it begins.
    begins: Span,
    /// Counts of the motions before it.
    before: u64,
    /// Position in which it begins.
    from: i64,
    /// Counts that it goes through, below 0 backwards, never 0.
    counts: i64,
    /// The speed is `counts_in / nanos` counts per nanosecond.
    counts_in: u64,
    nanos: u64,
    /// From standstill to the speed.
    ramp: Span,
}

impl ShaftMotion {
    /// From the beginning of the motion to its count `n` from 1, in parts of a nanosecond; `None` beyond what can be
    /// worked out.
    fn fine(&self, n: u64) -> Option<u128> {
        let (speed, nanos) = (u128::from(self.counts_in), u128::from(self.nanos));
        let (n, all) = (u128::from(n), u128::from(self.counts.unsigned_abs()));
        let ramp = u128::try_from(self.ramp.as_nanos()).ok()?;
        let evenly = |counts: u128| Some(counts.checked_mul(nanos)?.checked_mul(1 << FINE)? / speed);
        // Twice the distance of the acceleration, s = a t^2 / 2, gives back its time.
        let from_rest = |twice: u128| -> Option<u128> {
            let square = twice.checked_mul(nanos)?.checked_mul(ramp)?.checked_mul(1 << (2 * FINE))?;
            Some((square / speed).isqrt())
        };
        let to_speed = speed.checked_mul(ramp)?;
        if all.checked_mul(nanos)? >= to_speed {
            let total = evenly(all)? + (ramp << FINE);
            return match (2 * n * nanos <= to_speed, 2 * (all - n) * nanos <= to_speed) {
                (true, _) => from_rest(2 * n),
                (_, true) => Some(total - from_rest(2 * (all - n))?),
                _ => Some(evenly(n)? + (ramp << FINE) / 2),
            };
        }
        // Too short a way for the speed: it brakes from the middle on.
        let total = from_rest(4 * all)?;
        if 2 * n <= all { from_rest(2 * n) } else { Some(total - from_rest(2 * (all - n))?) }
    }

    /// From the beginning of the motion to its count `n` from 1, to the nanosecond.
    fn after(&self, n: u64) -> Option<Span> {
        let nanos = (self.fine(n)? + (1 << (FINE - 1))) >> FINE;
        Some(Span::from_nanos(i64::try_from(nanos).ok()?))
    }
}

impl Encoder {
    /// Counts of all motions: that many edges A and B have together.
    pub fn counts(&self) -> u64 {
        self.motions.last().map_or(0, |motion| motion.before + motion.counts.unsigned_abs())
    }

    /// From the step to its end.
    pub fn length(&self) -> Span {
        self.lasts
    }

    /// When count `n` from 1 comes after the step, and the position that it brings; `None` after the last.
    pub fn count(&self, n: u64) -> Option<(Span, i64)> {
        let place = self.motions.partition_point(|motion| motion.before < n).checked_sub(1)?;
        let motion = &self.motions[place];
        let own = n - motion.before;
        let moved = i64::try_from(own).ok().filter(|own| *own <= motion.counts.abs())?;
        let after = motion.begins.as_nanos().saturating_add(motion.after(own)?.as_nanos());
        Some((Span::from_nanos(after), motion.from + moved * motion.counts.signum()))
    }

    /// A, B and the index at a position.
    pub fn levels(&self, position: i64) -> (bool, bool, bool) {
        let quarter = position.rem_euclid(i64::from(COUNTS_IN_LINE));
        let index = self.index.as_ref().is_some_and(|(_, turn)| position.rem_euclid(*turn) == 0);
        (matches!(quarter, 1 | 2), matches!(quarter, 2 | 3), index)
    }

    /// Its lines.
    pub fn lines(&self) -> impl Iterator<Item = &str> {
        [&self.a, &self.b].into_iter().chain(self.index.as_ref().map(|(line, _)| line)).map(String::as_str)
    }

    /// How long so many counts last at the highest speed, rounded down.
    pub fn lasts_at_most_speed(&self, counts: u64) -> Span {
        let lasts = |motion: &ShaftMotion| {
            let nanos = u128::from(counts) * u128::from(motion.nanos) / u128::from(motion.counts_in);
            Span::from_nanos(i64::try_from(nanos).unwrap_or(i64::MAX))
        };
        self.motions.iter().map(lasts).min().unwrap_or(Span::MAX)
    }

    /// Periods of A per time at the highest speed, in thousandths of a Hertz, rounded up.
    pub fn millihertz(&self) -> u64 {
        let rate = |motion: &ShaftMotion| {
            let counts = u128::from(motion.counts_in) * 1_000_000_000_000;
            let rate = counts.div_ceil(u128::from(motion.nanos) * u128::from(COUNTS_IN_LINE));
            u64::try_from(rate).unwrap_or(u64::MAX)
        };
        self.motions.iter().map(rate).max().unwrap_or(0)
    }
}

fn read(node: &Node, scope: &dyn StepNames, out: &mut Findings) -> Option<Stimulus> {
    let fields = table_fields(node, KEYS)?;
    let lines = fields.integer("lines");
    let a = scope.whole_signal(fields.get("a")?, out);
    let b = scope.whole_signal(fields.get("b")?, out);
    let index = match (fields.get("index"), lines) {
        (None, _) => None,
        (Some(place), Some(lines)) => {
            Some((scope.whole_signal(place, out)?, lines * i64::from(COUNTS_IN_LINE)))
        }
        (Some(place), None) => {
            let message = "where the index lies is not known";
            out.bad(codes::ENCODER, place, message, "add the `lines` of the disc, as in lines = 1024");
            return None;
        }
    };
    let from = fields.integer("from").unwrap_or(0);
    let mut encoder = Encoder { a: a?, b: b?, index, from, motions: Vec::new(), lasts: Span::ZERO };
    let lists: Vec<&str> = encoder.lines().collect();
    if (1..lists.len()).any(|at| lists[..at].contains(&lists[at])) {
        let message = "two lines of the encoder are one signal";
        out.bad(codes::ENCODER, node, message, "give `a`, `b` and `index` a line each");
        return None;
    }
    let value = fields.get("moves")?;
    let moves = match &value.data {
        Data::Array(list) => list.as_slice(),
        _ => std::slice::from_ref(value),
    };
    if moves.len() > MAX_MOTIONS {
        let message = format!("the encoder has {} motions; {MAX_MOTIONS} are the most", moves.len());
        out.bad(codes::ENCODER, value, message, "let several steps follow each other");
        return None;
    }
    let mut position = from;
    for one in moves {
        position = add(&mut encoder, position, lines, one, scope, out)?;
    }
    Some(Stimulus::Encoder(encoder))
}

/// Adds a motion or pause, and gives the position after it.
fn add(
    encoder: &mut Encoder,
    position: i64,
    lines: Option<i64>,
    node: &Node,
    _: &dyn StepNames,
    out: &mut Findings,
) -> Option<i64> {
    let fields = table_fields(node, MOTION_KEYS)?;
    let given: Vec<&str> = ["by", "to", "pause"].into_iter().filter(|key| fields.has(key)).collect();
    let [key] = given.as_slice() else {
        let message = "a motion has none of, or several of, `by`, `to` and `pause`";
        out.bad(codes::ENCODER, node, message, "as in { by = 4000, speed = \"20 kHz\" }");
        return None;
    };
    if *key == "pause" {
        let lasts = above_zero(&fields, "pause", out)?;
        if let Some(entry) = ["speed", "ramp"].into_iter().find_map(|key| fields.entry(key)) {
            let message = format!("a pause has no `{}`", entry.key);
            out.error(codes::ENCODER, entry.key_span.clone(), message, "remove it");
            return None;
        }
        encoder.lasts = Span::from_nanos(encoder.lasts.as_nanos().saturating_add(lasts.as_nanos()));
        return Some(position);
    }
    let target = fields.integer(key)?;
    let counts = if *key == "by" { target } else { target - position };
    if counts == 0 {
        let message = format!("the encoder stands at {position} already");
        out.bad(codes::ENCODER, fields.get(key)?, message, "remove the motion, or let it `pause`");
        return None;
    }
    let before = encoder.counts();
    if before + counts.unsigned_abs() > u64::from(MAX_PULSES) {
        let message = format!("the encoder has more than {MAX_PULSES} counts");
        out.bad(codes::ENCODER, fields.get(key)?, message, "let several steps follow each other");
        return None;
    }
    let (counts_in, nanos) = speed(&fields, node, lines, out)?;
    let ramp = fields.duration("ramp").unwrap_or(Span::ZERO);
    let motion =
        ShaftMotion { begins: encoder.lasts, before, from: position, counts, counts_in, nanos, ramp };
    let end = motion.after(counts.unsigned_abs()).filter(|_| ramp <= LONGEST_RAMP);
    let Some(end) = end else {
        let place = fields.get("ramp").unwrap_or(node);
        let message = "the motion takes too long to be worked out";
        out.bad(codes::ENCODER, place, message, format!("a ramp of at most {LONGEST_RAMP}, or fewer counts"));
        return None;
    };
    encoder.lasts = Span::from_nanos(encoder.lasts.as_nanos().saturating_add(end.as_nanos()));
    encoder.motions.push(motion);
    Some(position + counts)
}

/// The speed of a motion as counts in nanoseconds.
fn speed(fields: &Fields<'_>, node: &Node, lines: Option<i64>, out: &mut Findings) -> Option<(u64, u64)> {
    let Some(place) = fields.get("speed") else {
        if !fields.has("speed") {
            out.bad(codes::ENCODER, node, "the motion has no `speed`", "as in speed = \"20 kHz\"");
        }
        return None;
    };
    let text = place.as_text()?;
    let turns = || -> Option<u128> {
        let turns = Quantity::parse(text).ok()?.in_unit(&Unit::new("rpm"))?;
        u128::try_from(turns.shifted(3).as_whole()?).ok().filter(|turns| *turns > 0)
    };
    let fraction = match (millihertz(text), turns(), lines) {
        (Some(rate), ..) => Some((u128::from(rate), 1_000_000_000_000)),
        (None, Some(turns), Some(lines)) => {
            let counts = u128::from(lines.unsigned_abs()) * u128::from(COUNTS_IN_LINE);
            Some((turns.saturating_mul(counts), 60_000_000_000_000))
        }
        (None, Some(_), None) => {
            let message = "what a turn is in counts is not known";
            out.bad(codes::ENCODER, place, message, "add the `lines` of the disc, as in lines = 1024");
            return None;
        }
        (None, None, _) => None,
    };
    // Counts closer than 2 ns could fall on one instant.
    let right = fraction.filter(|(counts, nanos)| counts * 2 <= *nanos).and_then(|(counts, nanos)| {
        let divisor = common_divisor(counts, nanos);
        Some((u64::try_from(counts / divisor).ok()?, u64::try_from(nanos / divisor).ok()?))
    });
    if right.is_none() {
        let message = "`speed` is no speed of an encoder";
        let help = "counts per time up to 500 MHz, as in \"20 kHz\", or turns, as in \"1500 rpm\"";
        out.bad(codes::ENCODER, place, message, help);
    }
    right
}

const fn common_divisor(mut a: u128, mut b: u128) -> u128 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motion(counts: i64, counts_in: u64, nanos: u64, ramp: Span) -> ShaftMotion {
        ShaftMotion { begins: Span::ZERO, before: 0, from: 0, counts, counts_in, nanos, ramp }
    }

    fn instants(motion: &ShaftMotion) -> Vec<i64> {
        (1..=motion.counts.unsigned_abs()).map(|n| motion.after(n).unwrap().as_nanos()).collect()
    }

    // 3 counts in 10 ns: 3.33, 6.67 and 10 ns, and no drift over a million of them.
    #[test]
    fn an_even_motion_does_not_drift() {
        let even = motion(3, 3, 10, Span::ZERO);
        assert_eq!(instants(&even), [3, 7, 10]);
        let long = motion(3_000_000, 3, 10, Span::ZERO);
        assert_eq!(long.after(3_000_000), Some(Span::from_millis(10)));
    }

    // 1 count per us, reached in 8 us: s = a t^2 / 2 with a = 1/8 us^-2, so that count k comes at sqrt(16 k) us.
    #[test]
    fn acceleration_follows_the_square_root() {
        let full = motion(20, 1, 1_000, Span::from_micros(8));
        assert_eq!(full.after(1), Some(Span::from_micros(4)));
        assert_eq!(full.after(4), Some(Span::from_micros(8)));
        // At its speed from there on, and braking over the last 4 counts: 8 us + 12 us + 8 us.
        assert_eq!(full.after(10), Some(Span::from_micros(14)));
        assert_eq!(full.after(16), Some(Span::from_micros(20)));
        assert_eq!(full.after(19), Some(Span::from_micros(24)));
        assert_eq!(full.after(20), Some(Span::from_micros(28)));
    }

    // 2 counts do not reach the speed: 1 count of acceleration and 1 of braking, 4 us each.
    #[test]
    fn a_short_way_is_braked_from_its_middle() {
        let short = motion(-2, 1, 1_000, Span::from_micros(8));
        assert_eq!(instants(&short), [4_000, 8_000]);
    }

    #[test]
    fn instants_only_grow() {
        for ramp in [0, 1, 7, 100, 12_345] {
            for counts in [1, 2, 3, 50, 777] {
                let instants = instants(&motion(counts, 10, 33, Span::from_nanos(ramp)));
                assert!(instants.windows(2).all(|pair| pair[0] < pair[1]), "{ramp} {counts}: {instants:?}");
            }
        }
    }

    #[test]
    fn the_code_of_gray_has_one_edge_in_a_count() {
        let encoder = Encoder {
            a: "a".into(),
            b: "b".into(),
            index: Some(("z".into(), 8)),
            from: 0,
            motions: Vec::new(),
            lasts: Span::ZERO,
        };
        for position in -20..20 {
            let ((a, b, _), (next_a, next_b, _)) = (encoder.levels(position), encoder.levels(position + 1));
            assert_eq!(u8::from(a != next_a) + u8::from(b != next_b), 1, "{position}");
        }
        // A rises first on the way forwards; the index is high at 0, 8, 16.
        assert_eq!(encoder.levels(1), (true, false, false));
        assert_eq!((-16..=16).filter(|position| encoder.levels(*position).2).count(), 5);
    }
}
