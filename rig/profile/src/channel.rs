//! The embedded channels: their addresses and what they do to a signal.

use crate::{ChannelSet, Family, Reference, RegularOutputs};
use signal::Span;

/// What an embedded input is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum InputKind {
    /// Usable by counters and events.
    Fast,
    /// Digital only.
    Regular,
}

/// One embedded input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EmbeddedInput {
    /// Its number: I0, I1...
    pub index: usize,
    /// Byte of its bit in `%IXbyte.bit` (io:ADR-01, io:ADR-02).
    pub byte: u32,
    /// Bit in that byte, 0...7.
    pub bit: u32,
    /// What it is.
    pub kind: InputKind,
    /// Its own delay in each direction, before any filter: 2 us fast, 50 us regular (io:STD-IN-02).
    pub delay: Span,
}

/// What an embedded output is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum OutputKind {
    /// Push-pull transistor of the pulse generators; high impedance where it is not driven (io:REF-06).
    Fast,
    /// Regular transistor.
    Transistor,
    /// Relay contact.
    Relay,
}

/// One embedded output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EmbeddedOutput {
    /// Its number: Q0, Q1...
    pub index: usize,
    /// Byte of its bit in `%QXbyte.bit` (io:ADR-01; the outputs take bytes 0 and 1 on every M241).
    pub byte: u32,
    /// Bit in that byte, 0...7.
    pub bit: u32,
    /// What it is.
    pub kind: OutputKind,
    /// From the write of a 1 to the edge at the terminal (io:STD-OUT-01).
    pub on_delay: Span,
    /// From the write of a 0 to the edge at the terminal (io:STD-OUT-01).
    pub off_delay: Span,
    /// Both delays are the most that an edge takes, as product data of transistors say it; that of relays is an assumption
    /// (io:STD-OUT-01).
    pub at_most: bool,
}

/// The embedded inputs in the order of their numbers: fast ones first (io:REF-07).
pub fn inputs(reference: &Reference) -> impl Iterator<Item = EmbeddedInput> + use<> {
    let fast = reference.fast_inputs;
    (0..reference.input_count()).map(move |index| {
        let (byte, bit) = place(index);
        let (kind, delay) = if index < fast {
            (InputKind::Fast, Span::from_micros(2))
        } else {
            (InputKind::Regular, Span::from_micros(50))
        };
        EmbeddedInput { index, byte, bit, kind, delay }
    })
}

/// The embedded outputs in the order of their numbers: fast ones first (io:REF-07).
pub fn outputs(reference: &Reference) -> impl Iterator<Item = EmbeddedOutput> + use<> {
    let (fast, relay) = (reference.fast_outputs, reference.outputs == RegularOutputs::Relay);
    (0..reference.output_count()).map(move |index| {
        let (byte, bit) = place(index);
        let (kind, on_delay, off_delay) = if index < fast {
            (OutputKind::Fast, Span::from_micros(2), Span::from_micros(2))
        } else if relay {
            (OutputKind::Relay, Span::from_millis(10), Span::from_millis(10))
        } else {
            (OutputKind::Transistor, Span::from_micros(34), Span::from_micros(250))
        };
        EmbeddedOutput { index, byte, bit, kind, on_delay, off_delay, at_most: kind != OutputKind::Relay }
    })
}

/// Byte and bit of `%IX` at which the outputs' short circuit is reported: the byte after the last input byte, so
/// %IX2.0 with 24 channels and %IX3.0 with 40 (io:ADR-01, io:ADR-02). None without embedded outputs.
pub fn short_circuit_status(reference: &Reference) -> Option<(u32, u32)> {
    (reference.family == Family::M241).then(|| (place(reference.input_count() - 1).0 + 1, 0))
}

/// Byte and bit of `%QX` that command the rearming of the outputs: %QX2.0 (io:ADR-01). None without embedded outputs.
pub fn rearming_command(reference: &Reference) -> Option<(u32, u32)> {
    (reference.family == Family::M241).then_some((2, 0))
}

/// The groups of outputs that are protected together: the fast outputs; Q4...Q7; Q8 to the last (io:OUT-09,
/// rig definition: no document says which outputs share a group). Relays have no such protection: their groups are
/// empty.
pub fn protection_groups(reference: &Reference) -> [ChannelSet; 3] {
    let mut groups = [ChannelSet::EMPTY; 3];
    for output in outputs(reference) {
        let group = match (output.kind, output.index) {
            (OutputKind::Fast, _) => 0,
            (OutputKind::Transistor, 0..=7) => 1,
            (OutputKind::Transistor, _) => 2,
            (OutputKind::Relay, _) => continue,
        };
        groups[group].insert(output.index);
    }
    groups
}

const fn place(index: usize) -> (u32, u32) {
    (index as u32 / 8, index as u32 % 8)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{IMAGE_BITS, REFERENCES};

    // io:ADR-01, io:ADR-02: every bit has one owner, inside the image.
    #[test]
    fn no_address_is_used_twice() {
        for reference in REFERENCES {
            let mut read: Vec<_> = inputs(reference).map(|input| (input.byte, input.bit)).collect();
            read.extend(short_circuit_status(reference));
            let mut written: Vec<_> = outputs(reference).map(|output| (output.byte, output.bit)).collect();
            written.extend(rearming_command(reference));
            for mut bits in [read, written] {
                let count = bits.len();
                bits.sort_unstable();
                bits.dedup();
                assert_eq!(bits.len(), count, "{}", reference.name);
                assert!(bits.iter().all(|&(byte, bit)| bit < 8 && byte * 8 + bit < IMAGE_BITS));
            }
        }
    }

    #[test]
    fn documented_addresses() {
        let small = Reference::find("TM241CEC24T").unwrap();
        let large = Reference::find("TM241CE40R").unwrap();
        let at = |reference, index: usize| inputs(reference).nth(index).map(|input| (input.byte, input.bit));
        assert_eq!(at(small, 8), Some((1, 0)));
        assert_eq!(at(small, 13), Some((1, 5)));
        assert_eq!(at(small, 14), None);
        assert_eq!(at(large, 19), Some((2, 3)));
        assert_eq!(outputs(small).nth(9).map(|output| (output.byte, output.bit)), Some((1, 1)));
        assert_eq!(short_circuit_status(small), Some((2, 0)));
        assert_eq!(short_circuit_status(large), Some((3, 0)));
    }

    // io:OUT-09
    #[test]
    fn groups_of_protection() {
        let groups = |name| {
            protection_groups(Reference::find(name).unwrap()).map(|group| group.iter().collect::<Vec<_>>())
        };
        assert_eq!(groups("TM241CEC24T"), [vec![0, 1, 2, 3], vec![4, 5, 6, 7], vec![8, 9]]);
        assert_eq!(groups("TM241CE40U"), [(0..4).collect(), (4..8).collect(), (8..16).collect::<Vec<_>>()]);
        assert_eq!(groups("TM241CE40R"), [vec![0, 1, 2, 3], vec![], vec![]]);
        assert_eq!(groups("TM251MESC"), [vec![], vec![], vec![]]);
    }

    // io:REF-05, io:STD-OUT-01, io:STD-IN-02
    #[test]
    fn kinds_and_delays() {
        let relay = Reference::find("TM241C24R").unwrap();
        assert_eq!(outputs(relay).filter(|output| output.kind == OutputKind::Fast).count(), 4);
        let last = outputs(relay).last().unwrap();
        assert_eq!((last.kind, last.on_delay), (OutputKind::Relay, Span::from_millis(10)));
        assert!(!last.at_most && outputs(relay).next().is_some_and(|fast| fast.at_most));
        let transistor = outputs(Reference::find("TM241C24U").unwrap()).nth(4).unwrap();
        assert_eq!(
            (transistor.on_delay, transistor.off_delay),
            (Span::from_micros(34), Span::from_micros(250))
        );
        let kinds: Vec<_> = inputs(relay).map(|input| input.kind).collect();
        assert_eq!(kinds[7..9], [InputKind::Fast, InputKind::Regular]);
    }
}
