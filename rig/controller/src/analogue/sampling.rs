//! When the inputs of a module are converted.
//!
//! A module converts its inputs in use one after the other, again and again (manufacturer's data sheets: a time that is always
//! the same and a time for each channel). That the first round begins with the supply is a rig definition.

use profile::{AnalogueChannels, AnalogueMode, ConfiguredModule, Conversion};
use signal::{Span, Time};

/// The instants at which an input is converted, from power-on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Sampling {
    /// The first one.
    first: Span,
    /// From one to the next, above 0.
    period: Span,
}

impl Sampling {
    /// The last one up to `now`, with power since `powered`; none before the first.
    pub(super) fn last(self, powered: Time, now: Time) -> Option<Time> {
        let first = powered.saturating_add(self.first);
        let since = now.as_nanos().saturating_sub(first.as_nanos());
        let period = self.period.as_nanos();
        (since >= 0).then(|| first.saturating_add(Span::from_nanos(since / period * period)))
    }

    /// The first one after an instant.
    pub(super) fn after(self, powered: Time, at: Time) -> Time {
        let first = powered.saturating_add(self.first);
        self.last(powered, at).map_or(first, |last| last.saturating_add(self.period))
    }

    /// Those of each input of a module; none for one that is not used, and for one that is converted whenever it is read,
    /// because no document has a time.
    pub(super) fn of(
        channels: &AnalogueChannels,
        configured: &ConfiguredModule<'_>,
    ) -> Vec<Option<Sampling>> {
        let inputs = (0..channels.count as usize).map(|input| configured.input(input));
        let conversions: Vec<Option<&Conversion>> =
            inputs.map(|input| input.and_then(|input| conversion(channels, input.mode))).collect();
        let own = |conversion: &Conversion| {
            let chosen = configured.sampling.filter(|chosen| conversion.per_channel.contains(chosen));
            chosen.or_else(|| conversion.per_channel.first().copied()).unwrap_or(Span::ZERO)
        };
        let fixed = conversions.iter().flatten().map(|one| one.fixed).max().unwrap_or(Span::ZERO);
        let round = fixed + conversions.iter().flatten().fold(Span::ZERO, |sum, one| sum + own(one));
        let mut first = fixed;
        let instants = |one: &Option<&Conversion>| {
            first = first + own((*one)?);
            (round > Span::ZERO).then_some(Sampling { first, period: round })
        };
        conversions.iter().map(instants).collect()
    }
}

/// The conversion of a mode.
fn conversion<'a>(channels: &'a AnalogueChannels, mode: &AnalogueMode) -> Option<&'a Conversion> {
    let of_sensors = channels.temperature_conversion.as_ref().filter(|_| mode.is_sensor());
    of_sensors.or(channels.conversion.as_ref())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_instant_is_the_last_of_its_grid() {
        let sampling = Sampling { first: Span::from_millis(3), period: Span::from_millis(10) };
        let last = |at| sampling.last(Time::from_nanos(500), Time::from_nanos(at));
        assert_eq!(last(3_000_499), None);
        assert_eq!(last(3_000_500), Some(Time::from_nanos(3_000_500)));
        assert_eq!(last(13_000_499), Some(Time::from_nanos(3_000_500)));
        assert_eq!(last(23_000_500), Some(Time::from_nanos(23_000_500)));
        let after = |at| sampling.after(Time::from_nanos(500), Time::from_nanos(at)).as_nanos();
        assert_eq!(
            [0, 3_000_499, 3_000_500, 23_000_499].map(after),
            [3_000_500, 3_000_500, 13_000_500, 23_000_500]
        );
    }
}
