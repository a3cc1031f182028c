//! Events of the hardware that start tasks.

use profile::{Family, Profile, Reference};
use signal::{Address, Area, Size};
use std::fmt;

/// What starts an external event task (controller:TASK-41, io:EVT-02).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ExternalEventSource {
    /// An edge at In.
    Input(usize),
    /// A threshold of a fast counter.
    Threshold {
        /// The counter.
        counter: u8,
        /// The threshold.
        threshold: u8,
    },
    /// The stop of a fast counter.
    CounterStop(u8),
    /// SYNC of the CANopen manager.
    CanSync,
}

impl ExternalEventSource {
    /// The event of this name: the address of an input, or the name of the profile's documents (io:EVT-04), such as
    /// `HSC0_STOP` (`BLOCK0_HSCSTOP` in 2014), `HSC0_TH1` (`BLOCK0_TH1`), `CAN_1_SYNC`, in any case of letters.
    pub fn find(name: &str, profile: Profile) -> Option<ExternalEventSource> {
        if let Ok(at) = Address::parse(name) {
            let input = at.area() == Area::Input && at.size() == Size::Bit;
            return usize::try_from(at.bit_offset()).ok().filter(|_| input).map(ExternalEventSource::Input);
        }
        let name = name.to_ascii_uppercase();
        if name == "CAN_1_SYNC" {
            return Some(ExternalEventSource::CanSync);
        }
        let (block, stop) = match profile {
            Profile::M241_2014 => ("BLOCK", "HSCSTOP"),
            Profile::M241_2019 | Profile::M251_2024 => ("HSC", "STOP"),
        };
        let (counter, event) = name.strip_prefix(block)?.split_once('_')?;
        let digit = |text: &str| text.parse().ok().filter(|_| text.len() == 1);
        let counter = digit(counter)?;
        if event == stop {
            return Some(ExternalEventSource::CounterStop(counter));
        }
        Some(ExternalEventSource::Threshold { counter, threshold: digit(event.strip_prefix("TH")?)? })
    }

    /// Whether this controller has the event: an M241 those of the inputs I0...I7, in 2014 of I8...I11 too, and those
    /// of its counters; a controller with a CAN port SYNC (controller:TASK-41, controller:TASK-45, io:EVT-03). Whether
    /// anything is configured to raise it is another question, see [`crate::ConfigError::NoEvent`].
    pub fn exists(self, profile: Profile, reference: &Reference) -> bool {
        let inputs = if profile == Profile::M241_2014 { 12 } else { 8 };
        match self {
            ExternalEventSource::Input(input) => {
                reference.family == Family::M241 && input < inputs && input < reference.input_count()
            }
            ExternalEventSource::Threshold { .. } | ExternalEventSource::CounterStop(_) => {
                reference.family == Family::M241
            }
            ExternalEventSource::CanSync => reference.has_can(),
        }
    }
}

impl fmt::Display for ExternalEventSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ExternalEventSource::Input(input) => write!(f, "%IX{}.{}", input / 8, input % 8),
            ExternalEventSource::Threshold { counter, threshold } => write!(f, "HSC{counter}_TH{threshold}"),
            ExternalEventSource::CounterStop(counter) => write!(f, "HSC{counter}_STOP"),
            ExternalEventSource::CanSync => f.write_str("CAN_1_SYNC"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // controller:TASK-41, io:EVT-02, io:EVT-03, io:EVT-04
    #[test]
    fn events_of_each_profile() {
        let (old, new, m251) = (Profile::M241_2014, Profile::M241_2019, Profile::M251_2024);
        let exists = |name: &str, profile: Profile| {
            ExternalEventSource::find(name, profile)
                .is_some_and(|source| source.exists(profile, profile.default_reference()))
        };
        for (name, expected) in [
            ("%IX0.0", [true, true, false]),
            ("%IX0.7", [true, true, false]),
            ("%IX1.0", [true, false, false]),
            ("%IX1.3", [true, false, false]),
            ("%IX1.4", [false; 3]),
            ("%QX0.0", [false; 3]),
            ("%IB0", [false; 3]),
            ("BLOCK0_HSCSTOP", [true, false, false]),
            ("block1_th0", [true, false, false]),
            ("HSC0_STOP", [false, true, false]),
            ("HSC7_TH1", [false, true, false]),
            ("HSC_STOP", [false; 3]),
            ("HSC10_STOP", [false; 3]),
            ("CAN_1_SYNC", [true; 3]),
            ("CAN_2_SYNC", [false; 3]),
        ] {
            assert_eq!([old, new, m251].map(|profile| exists(name, profile)), expected, "{name}");
        }
        let mese = Reference::find("TM251MESE").unwrap();
        assert!(!ExternalEventSource::CanSync.exists(m251, mese));
    }
}
