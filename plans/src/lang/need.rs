//! What a plan needs of its rig and subject: `task-load`, `pulse >= 200 kHz`, `timestamp <= 0.5 us`.

use std::fmt;

use document::suggest;
use signal::{Decimal, Quantity, Span, Unit};

/// A power that a rig and its subject can have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Capability {
    /// The word.
    pub word: &'static str,
    /// What it is bounded by, if anything.
    pub measure: CapabilityUnit,
    /// What it means, one sentence.
    pub doc: &'static str,
}

/// What a capability is bounded by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CapabilityUnit {
    /// It is there or not.
    None,
    /// A frequency.
    Frequency,
    /// A duration.
    Time,
}

const fn capability(word: &'static str, measure: CapabilityUnit, doc: &'static str) -> Capability {
    Capability { word, measure, doc }
}

/// Every power that a plan can need, in alphabetical order.
pub const CAPABILITIES: &[Capability] = &[
    capability("commands", CapabilityUnit::None, "Run, Stop and the resets can be commanded"),
    capability("download", CapabilityUnit::None, "an application can be downloaded"),
    capability("faults", CapabilityUnit::None, "faults can be put on lines"),
    capability(
        "files",
        CapabilityUnit::None,
        "files of the controller, its log among them, can be seen and changed",
    ),
    capability("firmware", CapabilityUnit::None, "the firmware can be damaged and restored"),
    capability("force", CapabilityUnit::None, "inputs and outputs can be forced"),
    capability("indicators", CapabilityUnit::None, "LEDs and the states of output stages can be read"),
    capability("memory-access", CapabilityUnit::None, "variables and memory can be read and written"),
    capability("operator", CapabilityUnit::None, "a person at a terminal can be asked"),
    capability("power", CapabilityUnit::None, "the supply can be switched"),
    capability("pulse", CapabilityUnit::Frequency, "trains of pulses up to a frequency can be emitted"),
    capability("registers", CapabilityUnit::None, "registers can be read and written as over the network"),
    capability("run-stop", CapabilityUnit::None, "the Run/Stop switch can be moved"),
    capability("system-variables", CapabilityUnit::None, "PLC_R and PLC_W can be read"),
    capability("task-load", CapabilityUnit::None, "the cycles of a task can be made longer"),
    capability("timestamp", CapabilityUnit::Time, "edges are stamped to within a duration"),
];

/// A power that a plan needs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Need {
    /// The word, one of [`CAPABILITIES`].
    pub word: &'static str,
    /// How much of it; `None`: any.
    pub bound: Option<NeedBound>,
}

/// How much of a power is needed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NeedBound {
    /// At least or at most.
    pub relation: BoundRelation,
    /// How much.
    pub amount: Amount,
}

/// The side of a bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BoundRelation {
    /// `>=`.
    AtLeast,
    /// `<=`.
    AtMost,
}

/// An exact amount.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Amount {
    /// A frequency in thousandths of a Hertz.
    Millihertz(u64),
    /// A duration.
    Time(Span),
}

/// Why a text is no need.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NeedFault {
    /// No rig can have it; the word that was probably meant.
    Unknown(Option<&'static str>),
    /// After the word stands neither `>=` nor `<=`.
    Relation,
    /// This power has no amount.
    NoAmount,
    /// The amount is not a frequency.
    Frequency,
    /// The amount is not a duration.
    Time,
}

impl fmt::Display for NeedFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NeedFault::Unknown(Some(meant)) => write!(f, "no rig can have this; did you mean `{meant}`?"),
            NeedFault::Unknown(None) => {
                let words: Vec<&str> = CAPABILITIES.iter().map(|one| one.word).collect();
                write!(f, "no rig can have this; there are {}", words.join(", "))
            }
            NeedFault::Relation => {
                f.write_str("expected `>=` or `<=` after the word, as in `pulse >= 200 kHz`")
            }
            NeedFault::NoAmount => f.write_str("this is there or not, without an amount"),
            NeedFault::Frequency => f.write_str("expected a frequency, as in `pulse >= 200 kHz`"),
            NeedFault::Time => f.write_str("expected a duration, as in `timestamp <= 0.5 us`"),
        }
    }
}

impl Need {
    /// Reads `word`, `word >= amount` or `word <= amount`.
    ///
    /// # Errors
    /// [`NeedFault`] with the byte at which the fault begins.
    pub fn parse(text: &str) -> Result<Need, (usize, NeedFault)> {
        let start = text.len() - text.trim_start().len();
        let end = text[start..]
            .find(|c: char| c.is_whitespace() || matches!(c, '<' | '>' | '='))
            .map_or(text.len(), |end| start + end);
        let word = &text[start..end];
        let Some(capability) = CAPABILITIES.iter().find(|one| one.word == word) else {
            let meant = suggest(word, CAPABILITIES.iter().map(|one| one.word));
            return Err((start, NeedFault::Unknown(meant)));
        };
        let rest = text[end..].trim_start();
        if rest.is_empty() {
            return Ok(Need { word: capability.word, bound: None });
        }
        let at = text.len() - rest.len();
        let (relation, amount) = match (rest.strip_prefix(">="), rest.strip_prefix("<=")) {
            (Some(amount), _) => (BoundRelation::AtLeast, amount),
            (_, Some(amount)) => (BoundRelation::AtMost, amount),
            _ => return Err((at, NeedFault::Relation)),
        };
        let amount_at = text.len() - amount.trim_start().len();
        let amount = match capability.measure {
            CapabilityUnit::None => return Err((at, NeedFault::NoAmount)),
            CapabilityUnit::Frequency => {
                Amount::Millihertz(millihertz(amount).ok_or((amount_at, NeedFault::Frequency))?)
            }
            CapabilityUnit::Time => match Span::parse(amount) {
                Ok(span) if !span.is_negative() => Amount::Time(span),
                _ => return Err((amount_at, NeedFault::Time)),
            },
        };
        Ok(Need { word: capability.word, bound: Some(NeedBound { relation, amount }) })
    }
}

/// A frequency in thousandths of a Hertz; `None` if the text is none, or finer.
pub(crate) fn millihertz(text: &str) -> Option<u64> {
    let number = Quantity::parse(text).ok()?.in_unit(&Unit::new("mHz"))?;
    u64::try_from(number.as_whole()?).ok().filter(|frequency| *frequency > 0)
}

impl fmt::Display for Need {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.word)?;
        let Some(bound) = self.bound else { return Ok(()) };
        f.write_str(if bound.relation == BoundRelation::AtLeast { " >= " } else { " <= " })?;
        match bound.amount {
            Amount::Millihertz(frequency) => {
                let (power, unit) = match frequency {
                    1_000_000_000.. => (-9, "MHz"),
                    1_000_000.. => (-6, "kHz"),
                    _ => (-3, "Hz"),
                };
                write!(f, "{} {unit}", Decimal::new(i128::from(frequency), power))
            }
            Amount::Time(span) => span.fmt(f),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn needs_read() {
        assert_eq!(Need::parse("task-load"), Ok(Need { word: "task-load", bound: None }));
        let pulse = Need::parse("pulse >= 200 kHz").unwrap();
        let amount = Amount::Millihertz(200_000_000);
        assert_eq!(pulse.bound, Some(NeedBound { relation: BoundRelation::AtLeast, amount }));
        assert_eq!(pulse.to_string(), "pulse >= 200 kHz");
        assert_eq!(Need::parse("timestamp<=0.5 us").unwrap().to_string(), "timestamp <= 500 ns");
    }

    #[test]
    fn faults_name_their_place() {
        assert_eq!(Need::parse("taskload"), Err((0, NeedFault::Unknown(Some("task-load")))));
        assert_eq!(Need::parse("pulse > 1 Hz"), Err((6, NeedFault::Relation)));
        assert_eq!(Need::parse("pulse >= 1 V"), Err((9, NeedFault::Frequency)));
        assert_eq!(Need::parse("force >= 1 s"), Err((6, NeedFault::NoAmount)));
        assert_eq!(Need::parse("timestamp <= 1"), Err((13, NeedFault::Time)));
    }

    proptest! {
        #[test]
        fn no_text_panics(text in "\\PC*", near in "(pulse|timestamp|>=|<=| |[0-9.]{1,20}|Hz|us){0,6}") {
            let _ = (Need::parse(&text), Need::parse(&near));
        }
    }
}
