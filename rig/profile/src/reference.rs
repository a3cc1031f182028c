//! The references: which controller has which channels and ports.

use crate::port::{self, Port, PortKind};

/// A controller family.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Family {
    /// With embedded inputs and outputs.
    M241,
    /// Without embedded inputs and outputs.
    M251,
}

/// What the regular outputs of a reference are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RegularOutputs {
    /// No embedded outputs.
    None,
    /// Relay contacts, 2 A.
    Relay,
    /// Transistors that switch to the supply.
    Source,
    /// Transistors that switch to 0 V.
    Sink,
}

/// One reference and what it carries (controller:HW-02, controller:HW-04, io:REF-01).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reference {
    /// The commercial reference, as in `TM241CEC24T`.
    pub name: &'static str,
    /// Its family.
    pub family: Family,
    /// Number of fast inputs; they come first (io:REF-07).
    pub fast_inputs: usize,
    /// Number of regular inputs.
    pub regular_inputs: usize,
    /// Number of fast outputs; they come first (io:REF-07).
    pub fast_outputs: usize,
    /// Number of regular outputs.
    pub regular_outputs: usize,
    /// What the regular outputs are. The fast ones are transistors on every M241: sink where the regular outputs
    /// are sink, else source (io:REF-05).
    pub outputs: RegularOutputs,
    /// Its ports: serial lines, CAN, Ethernet networks, the programming port. A port's number is its place.
    pub ports: &'static [Port],
}

impl Reference {
    /// The reference of this name, in any case.
    pub fn find(name: &str) -> Option<&'static Reference> {
        REFERENCES.iter().find(|reference| reference.name.eq_ignore_ascii_case(name))
    }

    /// Number of embedded inputs.
    pub const fn input_count(&self) -> usize {
        self.fast_inputs + self.regular_inputs
    }

    /// Number of embedded outputs.
    pub const fn output_count(&self) -> usize {
        self.fast_outputs + self.regular_outputs
    }

    /// The number of the port of this name, in any case.
    pub fn find_port(&self, name: &str) -> Option<usize> {
        self.ports.iter().position(|port| port.is_named(name))
    }

    /// Number of Ethernet networks.
    pub fn ethernet_count(&self) -> usize {
        self.ports.iter().filter(|port| port.kind == PortKind::Ethernet).count()
    }

    /// Whether it has a port for CANopen (serial-can:SER-03).
    pub fn has_can(&self) -> bool {
        self.ports.iter().any(|port| port.kind == PortKind::Can)
    }
}

/// An M241: 24 or 40 embedded channels.
const fn m241(
    name: &'static str,
    channels: usize,
    outputs: RegularOutputs,
    ports: &'static [Port],
) -> Reference {
    let large = channels == 40;
    Reference {
        name,
        family: Family::M241,
        fast_inputs: 8,
        regular_inputs: if large { 16 } else { 6 },
        fast_outputs: 4,
        regular_outputs: if large { 12 } else { 6 },
        outputs,
        ports,
    }
}

/// An M251: no embedded channels.
const fn m251(name: &'static str, ports: &'static [Port]) -> Reference {
    Reference {
        name,
        family: Family::M251,
        fast_inputs: 0,
        regular_inputs: 0,
        fast_outputs: 0,
        regular_outputs: 0,
        outputs: RegularOutputs::None,
        ports,
    }
}

/// Every reference (io: section 1, controller:HW-02, controller:HW-04). There is no TM241CEC40.
pub const REFERENCES: &[Reference] = &[
    m241("TM241C24R", 24, RegularOutputs::Relay, port::M241_C),
    m241("TM241CE24R", 24, RegularOutputs::Relay, port::M241_CE),
    m241("TM241CEC24R", 24, RegularOutputs::Relay, port::M241_CEC),
    m241("TM241C24T", 24, RegularOutputs::Source, port::M241_C),
    m241("TM241CE24T", 24, RegularOutputs::Source, port::M241_CE),
    m241("TM241CEC24T", 24, RegularOutputs::Source, port::M241_CEC),
    m241("TM241C24U", 24, RegularOutputs::Sink, port::M241_C),
    m241("TM241CE24U", 24, RegularOutputs::Sink, port::M241_CE),
    m241("TM241CEC24U", 24, RegularOutputs::Sink, port::M241_CEC),
    m241("TM241C40R", 40, RegularOutputs::Relay, port::M241_C),
    m241("TM241CE40R", 40, RegularOutputs::Relay, port::M241_CE),
    m241("TM241C40T", 40, RegularOutputs::Source, port::M241_C),
    m241("TM241CE40T", 40, RegularOutputs::Source, port::M241_CE),
    m241("TM241C40U", 40, RegularOutputs::Sink, port::M241_C),
    m241("TM241CE40U", 40, RegularOutputs::Sink, port::M241_CE),
    m251("TM251MESC", port::M251_MESC),
    m251("TM251MESE", port::M251_MESE),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_found_in_any_case() {
        for (place, reference) in REFERENCES.iter().enumerate() {
            assert_eq!(Reference::find(&reference.name.to_lowercase()), Some(reference));
            assert!(REFERENCES[..place].iter().all(|other| other.name != reference.name));
        }
        assert_eq!(Reference::find("TM241CEC40T"), None);
    }

    // io:REF-01, controller:HW-02
    #[test]
    fn names_say_what_the_tables_say() {
        for reference in REFERENCES.iter().filter(|reference| reference.family == Family::M241) {
            let counts = (reference.input_count(), reference.output_count());
            assert_eq!(
                counts,
                if reference.name.contains("40") { (24, 16) } else { (14, 10) },
                "{}",
                reference.name
            );
            let outputs = match reference.name.chars().last() {
                Some('R') => RegularOutputs::Relay,
                Some('T') => RegularOutputs::Source,
                _ => RegularOutputs::Sink,
            };
            assert_eq!(reference.outputs, outputs, "{}", reference.name);
        }
    }
}
