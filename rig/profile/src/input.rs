//! What can be configured of the embedded inputs, and how that differs between the profiles.

use crate::{Profile, Reference};

/// Edges of an input that raise its event (io: section 3, parameter Event).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum EventEdges {
    /// From 0 to 1.
    Rising,
    /// From 1 to 0.
    Falling,
    /// Every edge.
    Both,
}

impl EventEdges {
    /// Whether the event comes with the edge to this level.
    pub const fn includes(self, high: bool) -> bool {
        match self {
            EventEdges::Rising => high,
            EventEdges::Falling => !high,
            EventEdges::Both => true,
        }
    }
}

/// The level of an input by the voltage at its terminal (io:STD-IN-02): 1 from 15 V up, 0 up to 5 V. None between
/// them, where an input keeps the level that it had.
pub fn input_level(volts: f64) -> Option<bool> {
    if volts >= 15.0 {
        Some(true)
    } else if volts <= 5.0 {
        Some(false)
    } else {
        None
    }
}

impl Profile {
    /// How many inputs, from I0, can be the Run/Stop input: I0...I7 in 2014, every input in 2019, none of an M251
    /// (controller:RS-03).
    pub const fn run_stop_inputs(self, reference: &Reference) -> usize {
        match self {
            Profile::M241_2014 => reference.fast_inputs,
            Profile::M241_2019 => reference.input_count(),
            Profile::M251_2024 => 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_profiles_allow() {
        // controller:RS-03
        let run_stop = |profile: Profile, name: &str| profile.run_stop_inputs(Reference::find(name).unwrap());
        assert_eq!(run_stop(Profile::M241_2014, "TM241CE40T"), 8);
        assert_eq!(run_stop(Profile::M241_2019, "TM241CEC24T"), 14);
        assert_eq!(run_stop(Profile::M241_2019, "TM241CE40T"), 24);
        assert_eq!(run_stop(Profile::M251_2024, "TM251MESC"), 0);
    }

    // io:STD-IN-02
    #[test]
    fn levels_of_a_voltage() {
        let levels = [24.0, 15.0, 14.99, 5.01, 5.0, 0.0].map(input_level);
        assert_eq!(levels, [Some(true), Some(true), None, None, Some(false), Some(false)]);
    }
}
