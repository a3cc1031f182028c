//! The ports of the references: connectors for serial lines, CAN, Ethernet and the programming tool.

use std::fmt;

/// What a serial port can be on the wire; the application chooses where there are two (serial-can:SER-12).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SerialMedia {
    /// RS-232 or RS-485.
    Both,
    /// RS-485 alone.
    Rs485,
}

/// What a port is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PortKind {
    /// A serial line.
    Serial(SerialMedia),
    /// A CAN bus: CANopen or J1939.
    Can,
    /// An Ethernet network.
    Ethernet,
    /// The programming tool.
    Usb,
}

impl fmt::Display for PortKind {
    /// As in `SL2 is a serial line (RS-485)`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            PortKind::Serial(SerialMedia::Both) => "a serial line (RS-232 or RS-485)",
            PortKind::Serial(SerialMedia::Rs485) => "a serial line (RS-485)",
            PortKind::Can => "a CAN bus",
            PortKind::Ethernet => "an Ethernet network",
            PortKind::Usb => "the USB programming port",
        })
    }
}

/// A port of a reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Port {
    /// Its name in files and messages: the documents' short name where they have one.
    pub name: &'static str,
    /// Its node in the device tree (controller:HW-05), another name for it.
    pub node: &'static str,
    /// What it is for.
    pub kind: PortKind,
    /// The connector, where the documents say.
    pub connector: Option<&'static str>,
}

impl Port {
    /// Whether this is a name of the port, in any case of letters.
    pub fn is_named(&self, name: &str) -> bool {
        self.name.eq_ignore_ascii_case(name) || self.node.eq_ignore_ascii_case(name)
    }
}

const fn serial(
    name: &'static str,
    node: &'static str,
    media: SerialMedia,
    connector: Option<&'static str>,
) -> Port {
    Port { name, node, kind: PortKind::Serial(media), connector }
}

const fn port(name: &'static str, kind: PortKind, connector: Option<&'static str>) -> Port {
    Port { name, node: name, kind, connector }
}

/// serial-can:SER-01; the connectors stand in a guide that is not at hand.
const M241_SL1: Port = serial("SL1", "Serial_Line_1", SerialMedia::Both, None);
const M241_SL2: Port = serial("SL2", "Serial_Line_2", SerialMedia::Rs485, None);
/// serial-can:SER-03
const M241_CAN: Port = port("CAN_1", PortKind::Can, None);
/// ethernet:NET-02
const ETHERNET_1: Port = port("Ethernet_1", PortKind::Ethernet, Some("RJ45"));
const ETHERNET_2: Port = port("Ethernet_2", PortKind::Ethernet, Some("RJ45"));
/// controller:HW-02
const M241_USB: Port = port("USB", PortKind::Usb, None);
/// serial-can:SER-02, serial-can:WIR-01
const M251_SL1: Port = serial("SL1", "Serial_Line_1", SerialMedia::Both, Some("RJ45"));
/// serial-can:SER-03, serial-can: section 10.5
const M251_CAN: Port = port("CAN_1", PortKind::Can, Some("sub-D9 male"));
/// controller:HW-04
const M251_USB: Port = port("USB", PortKind::Usb, Some("USB mini-B"));

/// The ports of an M241 without Ethernet (controller:HW-02).
pub(crate) const M241_C: &[Port] = &[M241_SL1, M241_SL2, M241_USB];
/// With Ethernet.
pub(crate) const M241_CE: &[Port] = &[M241_SL1, M241_SL2, ETHERNET_1, M241_USB];
/// With Ethernet and CAN.
pub(crate) const M241_CEC: &[Port] = &[M241_SL1, M241_SL2, M241_CAN, ETHERNET_1, M241_USB];
/// controller:HW-04
pub(crate) const M251_MESC: &[Port] = &[M251_SL1, M251_CAN, ETHERNET_1, M251_USB];
/// controller:HW-04
pub(crate) const M251_MESE: &[Port] = &[M251_SL1, ETHERNET_1, ETHERNET_2, M251_USB];

#[cfg(test)]
mod tests {
    use crate::{Port, PortKind, REFERENCES, Reference};

    fn names(reference: &str) -> Vec<&'static str> {
        Reference::find(reference).unwrap().ports.iter().map(|port| port.name).collect()
    }

    // controller:HW-02, controller:HW-04, serial-can:SER-01, serial-can:SER-02, serial-can:SER-03, ethernet:NET-02
    #[test]
    fn references_have_the_ports_of_the_tables() {
        assert_eq!(names("TM241C24R"), ["SL1", "SL2", "USB"]);
        assert_eq!(names("TM241CE40T"), ["SL1", "SL2", "Ethernet_1", "USB"]);
        assert_eq!(names("TM241CEC24T"), ["SL1", "SL2", "CAN_1", "Ethernet_1", "USB"]);
        assert_eq!(names("TM251MESC"), ["SL1", "CAN_1", "Ethernet_1", "USB"]);
        assert_eq!(names("TM251MESE"), ["SL1", "Ethernet_1", "Ethernet_2", "USB"]);
        for reference in REFERENCES {
            let has = |kind| reference.ports.iter().any(|port| port.kind == kind);
            let (can, ethernet) = (reference.name.contains("CEC"), reference.name.contains("CE"));
            let m251 = reference.name.starts_with("TM251");
            assert_eq!(has(PortKind::Can), can || reference.name.ends_with("SC"), "{}", reference.name);
            assert_eq!(has(PortKind::Ethernet), ethernet || m251, "{}", reference.name);
        }
    }

    #[test]
    fn a_port_is_found_by_both_of_its_names_and_no_two_share_one() {
        let reference = Reference::find("TM241CEC24T").unwrap();
        assert_eq!(reference.find_port("sl2"), reference.find_port("Serial_Line_2"));
        assert_eq!(reference.find_port("can_1"), Some(2));
        assert_eq!(reference.find_port("SL3"), None);
        for reference in REFERENCES {
            let count = |name| reference.ports.iter().filter(|port: &&Port| port.is_named(name)).count();
            assert!(reference.ports.iter().all(|port| count(port.name) == 1 && count(port.node) == 1));
        }
    }
}
