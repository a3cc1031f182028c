//! What expert functions a controller can have, and how fast they are.

use crate::{ChannelSet, Profile, Reference, RegularOutputs};

/// Fast outputs of every M241: Q0...Q3 (io:REF-01, io:REF-07).
pub const FAST_OUTPUTS: usize = 4;

/// Fast inputs of every M241: I0...I7 (io:REF-01, io:REF-07).
pub const FAST_INPUTS: usize = 8;

/// Highest frequency of pulse width modulation on a fast output, in tenths of a hertz (io:STD-PWM-01).
pub const PWM_TENTHS: u32 = 200_000;

/// Highest frequency of a frequency generator on a fast output, in tenths of a hertz (io:STD-FG-01).
pub const GENERATOR_TENTHS: u32 = 1_000_000;

/// Highest frequency of a function on a regular transistor output, in tenths of a hertz (io:EXP-03).
pub const REGULAR_OUTPUT_TENTHS: u32 = 10_000;

/// Numbers and channels of expert functions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ExpertLimits {
    /// Main counters, meters, PTO, PWM and frequency generators together (io:EXP-08).
    pub shared: usize,
    /// PTO among them: 2 in 2014.
    pub axes: usize,
    /// Inputs of one main counter (io:EXP-01).
    pub main_inputs: usize,
    /// Capture inputs of one main counter (io:STD-ASG-01).
    pub captures: u8,
    /// The inputs that functions can use (io:STD-ASG-01). A counter needs one of its own, so there are no
    /// more counters and meters, nor HSC Simple beside others, than io: section 6.2 allows.
    pub inputs: ChannelSet,
    /// The outputs that can be reflex outputs (io:STD-ASG-01).
    pub reflexes: ChannelSet,
    /// The outputs that can make pulses (io:EXP-04, io:STD-ASG-01).
    pub pulses: ChannelSet,
}

impl Profile {
    /// What expert functions a reference can have; none without embedded channels (io:REF-08). The documents of 2014
    /// give no numbers of functions, so those of 2019 hold there too, as far as the fast channels go (io:EXP-02).
    pub fn expert_limits(self, reference: &Reference) -> ExpertLimits {
        let channels = if self == Profile::M241_2014 { (FAST_INPUTS, FAST_OUTPUTS) } else { (16, 8) };
        let first = |most: usize, there: usize| ChannelSet::first(most.min(there));
        let reflexes = first(channels.1, reference.output_count());
        let relay = reference.outputs == RegularOutputs::Relay;
        let embedded = reference.input_count() > 0;
        ExpertLimits {
            shared: if embedded { 4 } else { 0 },
            axes: match self {
                _ if !embedded => 0,
                Profile::M241_2014 => 2,
                Profile::M241_2019 | Profile::M251_2024 => 4,
            },
            main_inputs: if self == Profile::M241_2014 { 6 } else { 4 },
            captures: if self == Profile::M241_2014 { 2 } else { 1 },
            inputs: first(channels.0, reference.input_count()),
            reflexes,
            pulses: if relay { reflexes & ChannelSet::first(FAST_OUTPUTS) } else { reflexes },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limits(profile: Profile, reference: &str) -> ExpertLimits {
        profile.expert_limits(Reference::find(reference).unwrap())
    }

    // io:EXP-08, io:EXP-09, io:STD-ASG-01
    #[test]
    fn numbers_and_channels() {
        let small = limits(Profile::M241_2019, "TM241CEC24T");
        assert_eq!((small.shared, small.axes), (4, 4));
        let first = ChannelSet::first;
        assert_eq!((small.inputs, small.reflexes, small.pulses), (first(14), first(8), first(8)));
        let large = limits(Profile::M241_2019, "TM241CE40R");
        assert_eq!(large.inputs, first(16));
        assert_eq!((large.reflexes, large.pulses), (first(8), first(4)));
    }

    // io:EXP-01, io:EXP-02
    #[test]
    fn in_2014_only_fast_channels() {
        let old = limits(Profile::M241_2014, "TM241CEC24T");
        let first = ChannelSet::first;
        assert_eq!((old.inputs, old.reflexes, old.pulses), (first(8), first(4), first(4)));
        assert_eq!((old.axes, old.main_inputs), (2, 6));
    }

    // io:REF-08
    #[test]
    fn none_without_embedded_channels() {
        let none = limits(Profile::M251_2024, "TM251MESC");
        assert_eq!((none.shared, none.axes), (0, 0));
        assert_eq!((none.inputs, none.pulses), (ChannelSet::EMPTY, ChannelSet::EMPTY));
    }

    // io:REF-07
    #[test]
    fn fast_channels_are_those_of_the_table() {
        for reference in Profile::M241_2019.references() {
            assert_eq!((reference.fast_inputs, reference.fast_outputs), (FAST_INPUTS, FAST_OUTPUTS));
        }
    }
}
