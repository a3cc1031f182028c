//! Pulse trains with a position: how the keys of a plan say which lines carry it.

use document::{Diagnostic, Fields, KeySpec, KeyType};
use signal::{Sampling, SignalInfo, Span, ValueKind};

use super::common::{LONGER, signal};
use super::{ClaimDemand, ReadContext};
use crate::codes;
use crate::monitor::track::{PositionTrack, PulseEncoding};
use crate::monitor::{CaseTimeline, NotJudged, PulseRule, TraceSignals, slack};

/// The pulses.
pub(crate) const PULSES: KeySpec = KeySpec::required(
    "signal",
    KeyType::SignalRef,
    "The line of the pulses: their rising edges count; or a number that counts itself",
);
/// The line of direction.
pub(crate) const DIRECTION: KeySpec = KeySpec::optional(
    "direction",
    KeyType::SignalRef,
    "The line of direction: TRUE while pulses count up, FALSE while they count down",
);
/// Its sense.
pub(crate) const INVERTED: KeySpec = KeySpec::optional(
    "inverted",
    KeyType::Bool,
    "`true`: pulses count up while the line of direction is FALSE",
);
/// The other line of pulses.
pub(crate) const BACKWARDS: KeySpec = KeySpec::optional(
    "down",
    KeyType::SignalRef,
    "The line of the pulses that count down, beside those of `signal` that count up",
)
.was("backwards");
/// Phase B.
pub(crate) const QUADRATURE: KeySpec = KeySpec::optional(
    "quadrature",
    KeyType::SignalRef,
    "Phase B of a quadrature whose phase A is `signal`: every edge of both counts, four to a period",
);

/// The lines of a pulse train.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TrainLines {
    /// The pulses, phase A, or the number.
    pub(crate) signal: String,
    /// The line that gives or shares the direction, and how.
    pub(crate) second: Option<(PulseEncoding, String)>,
    /// `pulses-longer-than`.
    longer_than: Option<Span>,
}

impl TrainLines {
    /// Reads the keys above and `pulses-longer-than`.
    pub(crate) fn read(fields: &Fields<'_>, cx: &mut ReadContext<'_>) -> Option<TrainLines> {
        let first = signal(fields, "signal", cx);
        let given: Vec<&str> =
            ["direction", "down", "quadrature"].into_iter().filter(|key| fields.has(key)).collect();
        let inverted = fields.boolean("inverted").unwrap_or(false);
        if let Some(entry) = fields.entry("inverted").filter(|_| given != ["direction"]) {
            let message = "`inverted` goes with a line of `direction`";
            cx.out.error(codes::TRAIN, entry.key_span.clone(), message, "remove it, or name the line");
            return None;
        }
        let second = match given.as_slice() {
            [] => None,
            [key] => {
                let carried = match *key {
                    "direction" => PulseEncoding::Direction { inverted },
                    "down" => PulseEncoding::Backwards,
                    _ => PulseEncoding::Quadrature,
                };
                Some((carried, signal(fields, key, cx)?))
            }
            [_, key, ..] => {
                let place = fields.entry(key)?.key_span.clone();
                let message = "a direction is given in two ways";
                let help = "give one of `direction`, `down` and `quadrature`";
                cx.out.error(codes::TRAIN, place, message, help);
                return None;
            }
        };
        let first = first?;
        if let Some((_, other)) = second.as_ref().filter(|(_, other)| *other == first) {
            let place = fields.get(given.first()?)?;
            let message = format!("`{other}` is the line of the pulses, too");
            cx.out.bad(codes::TRAIN, place, message, "name another signal");
            return None;
        }
        Some(TrainLines { signal: first, second, longer_than: fields.duration(LONGER.name) })
    }

    /// Its signals, in the order of the slots of its track.
    pub(crate) fn signals(&self) -> Vec<String> {
        std::iter::once(&self.signal).chain(self.second.as_ref().map(|(_, other)| other)).cloned().collect()
    }

    /// What its lines demand of each other: one line has no direction.
    pub(crate) fn demands(&self) -> Vec<ClaimDemand<'_>> {
        let second = self.second.iter();
        second.map(|(_, other)| ClaimDemand::Differ(&self.signal, other)).collect()
    }

    /// Whether a position can shrink.
    pub(crate) fn is_signed(&self, info: &SignalInfo) -> bool {
        self.second.is_some() || is_number(info)
    }

    /// Finds what cannot be followed.
    pub(crate) fn check(&self, wiring: &TraceSignals<'_>, out: &mut Vec<Diagnostic>) {
        for (at, name) in self.signals().iter().enumerate() {
            let Some(info) = super::known(name, wiring, out) else { continue };
            let right = match info.kind {
                ValueKind::Bool => true,
                ValueKind::Int => at == 0 && self.second.is_none(),
                _ => false,
            };
            if !right {
                let why = match at == 0 && self.second.is_none() {
                    true => format!("`{name}` is neither a line nor a whole number, so it does not count"),
                    false => format!("`{name}` is no line, so it has no pulses and no direction"),
                };
                super::meant(
                    Err(why),
                    "name a line such as \"%QX0.0\", or a whole number that counts its pulses",
                    out,
                );
            }
        }
    }

    /// How it looks at the pulses of one of its signals. A number that was read counted what came in between.
    pub(crate) fn pulses(&self, info: &SignalInfo) -> PulseRule {
        if is_number(info) { PulseRule::SEEN } else { PulseRule::decides(self.longer_than) }
    }

    /// What follows it.
    pub(crate) fn track(&self, scene: &CaseTimeline<'_>) -> Result<PositionTrack, NotJudged> {
        let line = |name: &String| Ok((slack(scene.signal(name)?), scene.lag(name)));
        let first = line(&self.signal)?;
        let info = scene.signal(&self.signal)?;
        let Some((carried, other)) = &self.second else {
            let carried = match (is_number(info), self.is_coarse(info)) {
                (true, true) => PulseEncoding::Read,
                (true, false) => PulseEncoding::Number,
                (false, _) => PulseEncoding::Pulses,
            };
            return Ok(PositionTrack::new(carried, first, None));
        };
        Ok(PositionTrack::new(*carried, first, Some(line(other)?)))
    }

    /// Whether it is a number that is read from time to time.
    pub(crate) fn is_coarse(&self, info: &SignalInfo) -> bool {
        is_number(info) && matches!(info.sampling, Sampling::Sampled { .. })
    }

    /// What carries it: `` `A` and `B` ``.
    pub(crate) fn words(&self) -> String {
        match &self.second {
            None => format!("`{}`", self.signal),
            Some((_, other)) => format!("`{}` and `{other}`", self.signal),
        }
    }
}

fn is_number(info: &SignalInfo) -> bool {
    info.kind != ValueKind::Bool
}
