//! Pulses that nobody saw: what a channel that is only sampled can miss, and what that does to a verdict.
//!
//! One rule for every claim and every measurement (`docs/decisions/0061-pulses-that-nobody-saw.md`): each says by a
//! [`PulseRule`] what one more pulse could do to its answer, and the judge does the rest. Neither a monitor nor a gauge knows
//! of sampling.

use record::Verdict;
use signal::{ClockError, Policy, Sampling, SignalInfo, Span, ValueKind};

use super::pulse_filter::{PulseFilter, PulseLevel};
use super::{Finding, ValueTest, slack};

/// What pulses that nobody saw could do to the answer that is given by what was seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum UnseenPulses {
    /// Nothing: it asks what the channel read at an instant, or for something that was seen to come.
    Nothing,
    /// They could break what held. What was seen to be wrong stays wrong.
    Break,
    /// They could make any answer, unless the finding is [`Finding::beyond_help`].
    Decide,
}

/// How a claim or a measurement looks at the pulses of a signal.
#[derive(Clone, Debug, PartialEq)]
pub struct PulseRule {
    /// What those that nobody saw could do.
    pub unseen: UnseenPulses,
    /// `pulses-longer-than`: those of at most this width do not count.
    pub longer_than: Option<Span>,
    /// The key of a plan that says so.
    pub key: &'static str,
    /// Its monitor leaves the short ones out by itself, because what counts is for how long a condition lasts.
    pub weighs: bool,
    /// What has to hold for a value to be at the level of a pulse; of a line, that it is TRUE, if left out.
    pub level: Option<ValueTest>,
}

impl PulseRule {
    /// Unseen pulses do not matter.
    pub const SEEN: PulseRule = PulseRule {
        unseen: UnseenPulses::Nothing,
        longer_than: None,
        key: "pulses-longer-than",
        weighs: false,
        level: None,
    };

    /// Unseen pulses could break it.
    pub fn breaks(longer_than: Option<Span>) -> PulseRule {
        PulseRule { unseen: UnseenPulses::Break, longer_than, ..PulseRule::SEEN }
    }

    /// Unseen pulses could make any answer.
    pub fn decides(longer_than: Option<Span>) -> PulseRule {
        PulseRule { unseen: UnseenPulses::Decide, longer_than, ..PulseRule::SEEN }
    }

    /// Its monitor holds the width of what breaks its condition against `longer_than`, which this key says.
    #[must_use]
    pub fn weighed(self, key: &'static str) -> PulseRule {
        PulseRule { key, weighs: true, ..self }
    }

    /// The same for pulses of a level that a condition describes.
    #[must_use]
    pub fn of_level(self, level: Option<ValueTest>) -> PulseRule {
        PulseRule { level, ..self }
    }

    /// What takes short pulses out of a signal before its monitor sees them. A value of a number is no pulse by itself: of one that
    /// is recorded at most every so often it only bridges the times for which that leaves it unknown. `lag` is that of
    /// [`super::CaseTimeline::lag`], `clock` what the clock may be off.
    pub(crate) fn filter(&self, info: &SignalInfo, lag: i64, clock: ClockError) -> Option<PulseFilter> {
        let longest = self.longer_than.filter(|span| !self.weighs && *span > Span::ZERO)?;
        let promised = matches!(info.policy, Policy::AtMostEvery(every) if every <= longest);
        let level = match &self.level {
            Some(test) => PulseLevel::Test(test.clone(), slack(info)),
            None if info.kind == ValueKind::Bool => PulseLevel::Line,
            None if promised => PulseLevel::EveryValue,
            None => return None,
        };
        let off = clock.of_true(longest);
        let limits = ((longest - off).as_nanos(), (longest + off).as_nanos());
        let filter = PulseFilter::new(level, limits, lag);
        Some(if promised { filter.bridging() } else { filter })
    }

    /// Whether what was seen to be wrong could be right, because pulses of this signal can go unseen.
    pub(crate) fn can_rescue(&self, info: &SignalInfo) -> bool {
        self.unseen == UnseenPulses::Decide && blind(info, self.longer_than).is_some()
    }

    /// What unseen pulses of this signal could do, and why, if anything.
    pub(crate) fn doubt(&self, info: &SignalInfo) -> Option<(UnseenPulses, String)> {
        let missed = blind(info, self.longer_than).filter(|_| self.unseen != UnseenPulses::Nothing)?;
        let why = format!(
            "`{}` is only sampled: pulses up to {missed} can go unseen; state `{}`",
            info.name, self.key
        );
        Some((self.unseen, why))
    }
}

/// The width of pulses that a channel can miss without a sign, if those of such a width count: `longer_than` is what the
/// plan says of the pulses that matter.
///
/// Only sampled channels count: one that stamps edges reports what it lost, and a run that lost events is no
/// pass. What a recording policy leaves out is in the trace as a value that is not known.
fn blind(info: &SignalInfo, longer_than: Option<Span>) -> Option<Span> {
    let Sampling::Sampled { period } = info.sampling else { return None };
    let missed = info.shortest_pulse.max(period);
    // Pulses of exactly the shortest certain width are seen.
    longer_than.is_none_or(|stated| stated < missed).then_some(missed)
}

impl Finding {
    /// The same, open as far as pulses that nobody saw leave it so.
    #[must_use]
    pub(crate) fn with_unseen(mut self, unseen: UnseenPulses, why: String) -> Finding {
        let verdict = self.verdict();
        let opens = match (unseen, verdict) {
            (UnseenPulses::Nothing, _) | (_, Verdict::Inconclusive) => false,
            (_, Verdict::Pass) => true,
            (UnseenPulses::Break, _) => false,
            (UnseenPulses::Decide, _) => !self.beyond_help,
        };
        if opens {
            (self.can_hold, self.can_break, self.reason) = (true, true, why);
        }
        self
    }
}
