//! An analogue output: from its word of %Q to the terminal. That it takes no time is a rig definition: no document has a figure.

use super::scale::OutputScale;
use profile::ChannelStatus;
use signal::{Cause, Time, Value};

/// An output in use.
#[derive(Clone, Debug)]
pub(super) struct AnalogueOutput {
    scale: OutputScale,
    /// The word that the terminal shows; none where it shows something else.
    word: Option<i16>,
    value: Value,
    /// A change that was not reported yet: what it was before, since when, and who made it.
    change: Option<(Value, Time, Cause)>,
    /// The module has its own supply.
    is_supplied: bool,
    /// The status that was read last.
    status: ChannelStatus,
}

impl AnalogueOutput {
    /// The output, which drives nothing.
    pub(super) fn new(scale: OutputScale) -> AnalogueOutput {
        let (is_supplied, status) = (true, ChannelStatus::Normal);
        AnalogueOutput { scale, word: None, value: Value::HighZ, change: None, is_supplied, status }
    }

    /// The word is written at `now`, by whoever that is.
    #[inline]
    pub(super) fn write(&mut self, now: Time, word: i16, cause: impl FnOnce() -> Cause) {
        if self.word != Some(word) && self.is_supplied {
            self.show(now, Value::Real(self.scale.value(word)), cause());
            self.word = Some(word);
        }
    }

    /// Nothing is driven from `now` on (controller:OUT-02).
    pub(super) fn initialize(&mut self, now: Time) {
        self.show(now, Value::HighZ, Cause::Controller);
    }

    /// No voltage and no current from `now` on.
    pub(super) fn clear(&mut self, now: Time) {
        if self.is_supplied {
            self.show(now, Value::Real(0.0), Cause::Controller);
        }
    }

    /// The supply of the module is there or off from `now` on: without it nothing is driven, whatever is written.
    pub(super) fn supply(&mut self, now: Time, on: bool) {
        self.is_supplied = on;
        if !on {
            self.initialize(now);
        }
    }

    /// Reads its status.
    #[inline]
    pub(super) fn read_status(&mut self) -> ChannelStatus {
        self.status = if self.is_supplied { ChannelStatus::Normal } else { ChannelStatus::Supply };
        self.status
    }

    /// The status that was read last.
    pub(super) fn last_status(&self) -> ChannelStatus {
        self.status
    }

    fn show(&mut self, now: Time, value: Value, cause: Cause) {
        self.word = None;
        let before = std::mem::replace(&mut self.value, value);
        if before != value {
            let first = self.change.map_or(before, |(first, ..)| first);
            self.change = Some((first, now, cause));
        }
    }

    /// When its last change comes out; [`Time::MAX`] for none.
    pub(super) fn due(&self) -> Time {
        self.change.map_or(Time::MAX, |(_, at, _)| at)
    }

    /// Takes its change that is due at `now`: the value, since when, and who made it.
    pub(super) fn take_change(&mut self, now: Time) -> Option<(Value, Time, Cause)> {
        let (before, at, cause) = self.change.filter(|(_, at, _)| *at <= now)?;
        self.change = None;
        (before != self.value).then_some((self.value, at, cause))
    }

    /// What the terminal shows.
    pub(super) fn value(&self) -> Value {
        self.value
    }
}
