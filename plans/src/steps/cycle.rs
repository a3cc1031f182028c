//! The period of what repeats: exact whatever the frequency, over any number of periods.

use document::{Fields, Findings, KeySpec, KeyType, Node};
use signal::{Quantity, Span, Unit};

use super::drive::above_zero;
use crate::codes;
use crate::lang::millihertz;

/// One second in nanoseconds for a frequency in thousandths of a Hertz.
const NANOS_MILLIHERTZ: u64 = 1_000_000_000_000;

/// How often something repeats, as a frequency.
pub(super) const FREQUENCY: KeySpec =
    KeySpec::optional("frequency", KeyType::Text, "Periods per time, as in \"200 kHz\".");
/// How often something repeats, as a time.
pub(super) const PERIOD: KeySpec =
    KeySpec::optional("period", KeyType::Duration, "Time from one period to the next.");

/// The period of what repeats: `numerator / denominator` nanoseconds, so that every frequency is exact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ExactPeriod {
    numerator: u64,
    denominator: u64,
}

impl ExactPeriod {
    /// So many thousandths of a Hertz, above 0.
    pub const fn of_millihertz(frequency: u64) -> ExactPeriod {
        ExactPeriod { numerator: NANOS_MILLIHERTZ, denominator: frequency }
    }

    /// Reads `frequency` or `period`; `what` is the verb in words.
    pub(super) fn read(
        fields: &Fields<'_>,
        node: &Node,
        what: &str,
        out: &mut Findings,
    ) -> Option<ExactPeriod> {
        match (fields.has("frequency"), fields.has("period")) {
            (true, false) => {
                let text = fields.get("frequency")?;
                let Some(frequency) = millihertz(text.as_text()?) else {
                    let message = "`frequency` does not read as a frequency above 0";
                    out.bad(codes::UNIT, text, message, "write it in Hz, kHz or MHz, as in \"200 kHz\"");
                    return None;
                };
                Some(ExactPeriod::of_millihertz(frequency))
            }
            (false, true) => {
                let nanos = u64::try_from(above_zero(fields, "period", out)?.as_nanos()).ok()?;
                Some(ExactPeriod { numerator: nanos, denominator: 1 })
            }
            _ => {
                let message = format!("a {what} has either a `frequency` or a `period`");
                out.bad(codes::STIMULUS, node, message, "as in frequency = \"200 kHz\"");
                None
            }
        }
    }

    /// The time of `parts` of `whole` periods, rounded to the nanosecond; the longest there is where it is longer.
    pub fn after(self, parts: u128, whole: u128) -> Span {
        let divisor = u128::from(self.denominator) * whole;
        let nanos =
            parts.checked_mul(u128::from(self.numerator)).map(|nanos| (nanos + divisor / 2) / divisor);
        Span::from_nanos(nanos.and_then(|nanos| i64::try_from(nanos).ok()).unwrap_or(i64::MAX))
    }

    /// Which part of its period, `0 <= p / q < 1`, something has come to after this time, which is not below 0.
    pub fn position(self, after: Span) -> (u128, u128) {
        let whole = u128::from(self.numerator);
        let nanos = u128::try_from(after.as_nanos()).unwrap_or(0);
        (nanos * u128::from(self.denominator) % whole, whole)
    }

    /// Periods per time in thousandths of a Hertz, rounded up: what the rig must be able to emit.
    pub fn millihertz(self) -> u64 {
        let exact = u128::from(NANOS_MILLIHERTZ) * u128::from(self.denominator);
        u64::try_from(exact.div_ceil(u128::from(self.numerator))).unwrap_or(u64::MAX)
    }
}

/// The part of a period that a key says, in millionths, above 0 and below all of it; half if it is left out.
pub(super) fn part(fields: &Fields<'_>, key: &str, out: &mut Findings) -> Option<u32> {
    let Some(node) = fields.get(key) else { return (!fields.has(key)).then_some(500_000) };
    let read = millionths(node).filter(|part| (1..1_000_000).contains(part));
    if read.is_none() {
        let message = format!("`{key}` is not a part of the period");
        out.bad(codes::UNIT, node, message, "write per cent above 0 and below 100, as in \"25 %\"");
    }
    read
}

/// A part of a whole as it is written, in millionths.
pub(super) fn millionths(node: &Node) -> Option<u32> {
    let part = Quantity::parse(node.as_text()?).ok()?.in_unit(&Unit::new("ppm"))?;
    u32::try_from(part.as_whole()?).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_position_is_exact_over_a_year() {
        // 3 Hz has a period of no whole number of nanoseconds.
        let cycle = ExactPeriod::of_millihertz(3_000);
        let year = Span::from_secs(366 * 86_400);
        assert_eq!(cycle.position(year).0, 0);
        let (part, whole) = cycle.position(year + Span::from_millis(250));
        assert_eq!(part * 4, whole * 3);
        assert_eq!(cycle.after(3, 1), Span::from_secs(1));
        assert_eq!(cycle.after(1, 3), Span::from_nanos(111_111_111));
        assert_eq!(cycle.after(u128::MAX, 1), Span::MAX);
    }
}
