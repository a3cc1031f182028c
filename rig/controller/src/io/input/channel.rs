//! One input as a closed form: own delay, then integrating or anti-bounce filter.

use crate::config::InputConfig;
use signal::{Span, Time};

/// The channel model of one input.
///
/// The own delay is inertial: a level counts once it has lasted that long. Nothing is ticked: a channel is brought to
/// an instant when somebody looks at it, and says when it would turn by itself.
#[derive(Clone, Debug)]
pub(crate) struct InputChannel {
    delay: Span,
    stage: FilterStage,
    /// Level at the terminal.
    terminal: bool,
    /// Level behind the own delay.
    inside: bool,
    /// When `inside` takes the terminal's level, where they differ.
    follows: Time,
    /// The filter's state is that of this instant.
    at: Time,
    /// Level behind the filter at `at`.
    out: bool,
}

/// What stands behind the own delay.
#[derive(Clone, Copy, Debug)]
enum FilterStage {
    /// The accumulator of io:STD-IN-01: rises and falls by a nanosecond each nanosecond between 0 and `full`.
    Integrator { full: i64, sum: i64 },
    /// The anti-bounce filter of io:STD-IN-03: a level is accepted once it is stable for `bounce`. `since` is when the
    /// level behind the own delay changed last.
    AntiBounce { bounce: Span, since: Time },
}

impl InputChannel {
    /// A channel at rest at 0; `expert` where an expert function looks at the input (io:EIO-12).
    pub(crate) fn new(delay: Span, config: &InputConfig, expert: bool) -> InputChannel {
        let stage = if expert || config.is_expert() {
            FilterStage::AntiBounce { bounce: config.bounce.span(), since: Time::MIN }
        } else {
            FilterStage::Integrator { full: config.filter.span().as_nanos(), sum: 0 }
        };
        InputChannel {
            delay,
            stage,
            terminal: false,
            inside: false,
            follows: Time::MAX,
            at: Time::MIN,
            out: false,
        }
    }

    /// A channel at rest at 0 that has no filter.
    pub(crate) fn unfiltered(delay: Span) -> InputChannel {
        InputChannel {
            delay,
            stage: FilterStage::Integrator { full: 0, sum: 0 },
            terminal: false,
            inside: false,
            follows: Time::MAX,
            at: Time::MIN,
            out: false,
        }
    }

    /// The electronics come up at `now`: everything behind the terminal starts from 0. Returns the terminal's level.
    pub(crate) fn power_on(&mut self, now: Time) -> bool {
        (self.inside, self.out, self.at) = (false, false, now);
        match &mut self.stage {
            FilterStage::Integrator { sum, .. } => *sum = 0,
            FilterStage::AntiBounce { since, .. } => *since = now,
        }
        self.follows = now.saturating_add(self.delay);
        self.terminal
    }

    /// The terminal has this level from `now` on, to which the channel was brought. Returns whether that is a change.
    pub(crate) fn set(&mut self, now: Time, high: bool) -> bool {
        let changed = self.terminal != high;
        if changed {
            self.terminal = high;
            self.follows = now.saturating_add(self.delay);
        }
        changed
    }

    /// Levels take so long from now on, those under way as long as before.
    pub(crate) const fn set_delay(&mut self, delay: Span) {
        self.delay = delay;
    }

    /// Level at the terminal.
    pub(crate) const fn terminal(&self) -> bool {
        self.terminal
    }

    /// Level behind the filter.
    pub(crate) const fn out(&self) -> bool {
        self.out
    }

    /// Brings the channel to `now`; `edge` is called when the level behind the filter turned, and to what.
    pub(crate) fn advance(&mut self, now: Time, mut edge: impl FnMut(Time, bool)) {
        if self.inside != self.terminal && self.follows <= now {
            self.pass(self.follows, &mut edge);
            self.inside = self.terminal;
            if let FilterStage::AntiBounce { since, .. } = &mut self.stage {
                *since = self.follows;
            }
        }
        self.pass(now, &mut edge);
    }

    /// Time passes to `to` while the level behind the own delay stays.
    fn pass(&mut self, to: Time, edge: &mut impl FnMut(Time, bool)) {
        let turns = self.turns();
        if turns <= to {
            self.out = self.inside;
            edge(turns, self.out);
        }
        if let FilterStage::Integrator { full, sum } = &mut self.stage {
            let passed = to.as_nanos().saturating_sub(self.at.as_nanos()).max(0);
            *sum = if self.inside { sum.saturating_add(passed).min(*full) } else { (*sum - passed).max(0) };
        }
        self.at = self.at.max(to);
    }

    /// When the level behind the filter turns if the one behind the own delay stays.
    fn turns(&self) -> Time {
        if self.out == self.inside {
            return Time::MAX;
        }
        match self.stage {
            FilterStage::Integrator { full, sum } => {
                let left = if self.inside { full - sum } else { sum };
                self.at.saturating_add(Span::from_nanos(left))
            }
            FilterStage::AntiBounce { bounce, since } => since.saturating_add(bounce),
        }
    }

    /// When it has to be looked at next, so that no turn is seen late.
    pub(crate) fn next(&self) -> Time {
        let follows = if self.inside == self.terminal { Time::MAX } else { self.follows };
        self.turns().min(follows)
    }

    /// Whether anything in it can change without a change at the terminal.
    pub(crate) fn moves(&self) -> bool {
        let rest = match self.stage {
            FilterStage::Integrator { full, sum } => sum == if self.inside { full } else { 0 },
            FilterStage::AntiBounce { .. } => true,
        };
        self.inside != self.terminal || self.out != self.inside || !rest
    }
}
