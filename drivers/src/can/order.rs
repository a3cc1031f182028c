//! What the kernel is asked and ordered about a CAN interface: messages of rtnetlink.

use super::link::{BitTiming, Link, Modes, kind};
use super::spec::CanBusSpec;
use super::wire;

/// Marks of a message: it is a request, and an answer is wanted in any case.
const REQUEST: u16 = 1;
const ANSWER: u16 = 4;
/// Words of `struct can_bittiming` after bit rate and sample point: the kernel works them out.
const WORKED_OUT: usize = 6;

/// How an interface is set up, as far as the rig does so.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Setup {
    /// Of arbitration; a sample point of 0 leaves it to the kernel. `None` on an interface without bits.
    pub bits: Option<BitTiming>,
    /// Of fast data; `None` on classic CAN.
    pub data_bits: Option<BitTiming>,
    /// The modes of [`Setup::MODES`] that are on.
    pub modes: Modes,
    /// How long after bus-off the kernel starts the controller again, in milliseconds; 0 for never.
    pub restart_ms: u32,
    /// The most bytes of a frame as the kernel passes them, on an interface without bits.
    pub mtu: Option<u32>,
}

impl Setup {
    /// The modes that are switched on or off.
    pub const MODES: u32 = Modes::FD | Modes::LISTEN_ONLY | Modes::LOOPBACK;

    /// As an interface is.
    pub fn of(link: &Link) -> Setup {
        let has_bits = !link.is_virtual();
        Setup {
            bits: link.bits.filter(|_| has_bits),
            data_bits: link.data_bits.filter(|_| has_bits && link.modes.has(Modes::FD)),
            modes: Modes(link.modes.0 & Setup::MODES),
            restart_ms: link.restart_ms,
            mtu: Some(link.mtu).filter(|_| !has_bits),
        }
    }

    /// As a bus wants its interface, which is like that now.
    pub fn wanted(spec: &CanBusSpec, link: &Link) -> Setup {
        let was = Setup::of(link);
        let fd = spec.data_bitrate.is_some();
        if link.is_virtual() {
            let mtu = if fd { wire::FD } else { wire::CLASSIC } as u32;
            return Setup { mtu: Some(mtu.max(link.mtu)), ..was };
        }
        let mut modes = if fd { Modes::FD } else { 0 };
        modes |= if spec.listen_only { Modes::LISTEN_ONLY } else { 0 };
        // A sample point that nobody asks for stays.
        let bits = |bitrate: u32, asked: Option<u32>, was: Option<BitTiming>| {
            let stays = was.filter(|was| was.bitrate == bitrate).map(|was| was.sample_point);
            BitTiming { bitrate, sample_point: asked.or(stays).unwrap_or(0) }
        };
        let restart = spec.restart.and_then(|restart| u32::try_from(restart.as_nanos() / 1_000_000).ok());
        Setup {
            bits: Some(bits(spec.bitrate, spec.sample_point, was.bits)),
            data_bits: spec.data_bitrate.map(|rate| bits(rate, spec.data_sample_point, was.data_bits)),
            modes: Modes(modes),
            restart_ms: restart.unwrap_or(was.restart_ms),
            mtu: None,
        }
    }
}

/// The question what the interface of this name is.
pub fn question(name: &str) -> Vec<u8> {
    let mut text = name.as_bytes().to_vec();
    text.push(0);
    message(kind::GET_LINK, REQUEST, 0, [0; 2], &[attribute(kind::NAME, &text)])
}

/// The order to change nothing about the interface of this number: the answer says whether the rig may.
pub fn nothing(index: u32) -> Vec<u8> {
    change(index, [0; 2], &[])
}

/// The order to go up or down.
pub fn up(index: u32, up: bool) -> Vec<u8> {
    change(index, [if up { kind::UP } else { 0 }, kind::UP], &[])
}

/// The order to be set up like this; the interface has to be down.
pub fn set(index: u32, setup: &Setup) -> Vec<u8> {
    if let Some(mtu) = setup.mtu {
        return change(index, [0; 2], &[attribute(kind::MTU, &mtu.to_ne_bytes())]);
    }
    let mut about = Vec::new();
    let timing = |bits: BitTiming| {
        let mut words = vec![bits.bitrate, bits.sample_point];
        words.resize(words.len() + WORKED_OUT, 0);
        bytes(&words)
    };
    about.extend(setup.bits.map(|bits| attribute(kind::CAN_BITTIMING, &timing(bits))));
    about.extend(setup.data_bits.map(|bits| attribute(kind::CAN_DATA_BITTIMING, &timing(bits))));
    about.push(attribute(kind::CAN_CTRLMODE, &bytes(&[Setup::MODES, setup.modes.0])));
    about.push(attribute(kind::CAN_RESTART_MS, &setup.restart_ms.to_ne_bytes()));
    change(index, [0; 2], &[of_can(&about)])
}

/// The order to start a controller again that is off the bus.
pub fn restart(index: u32) -> Vec<u8> {
    change(index, [0; 2], &[of_can(&[attribute(kind::CAN_RESTART, &1u32.to_ne_bytes())])])
}

/// What is special of CAN interfaces.
fn of_can(about: &[Vec<u8>]) -> Vec<u8> {
    let info = [attribute(kind::INFO_KIND, b"can\0"), attribute(kind::INFO_DATA, &about.concat())];
    attribute(kind::LINK_INFO, &info.concat())
}

/// An order about the interface of this number: its flags and those that are meant, and attributes.
fn change(index: u32, flags: [u32; 2], attributes: &[Vec<u8>]) -> Vec<u8> {
    message(kind::NEW_LINK, REQUEST | ANSWER, index, flags, attributes)
}

fn message(kind: u16, marks: u16, index: u32, flags: [u32; 2], attributes: &[Vec<u8>]) -> Vec<u8> {
    let attributes = attributes.concat();
    let head = bytes(&[0, 0, 0, 0, 0, index, flags[0], flags[1]]);
    let mut message = [head, attributes].concat();
    let len = message.len() as u32;
    message[..4].copy_from_slice(&len.to_ne_bytes());
    message[4..6].copy_from_slice(&kind.to_ne_bytes());
    message[6..8].copy_from_slice(&marks.to_ne_bytes());
    message
}

/// An attribute, filled up to whole words.
pub(super) fn attribute(kind: u16, value: &[u8]) -> Vec<u8> {
    let mut bytes = ((value.len() + 4) as u16).to_ne_bytes().to_vec();
    bytes.extend(kind.to_ne_bytes());
    bytes.extend(value);
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    bytes
}

pub(super) fn bytes(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_ne_bytes()).collect()
}

#[cfg(test)]
mod tests {
    use super::super::link::{News, read};
    use super::*;

    /// What the kernel would report of an interface that became as it was set up.
    fn read_back(mut order: Vec<u8>) -> Link {
        // The kernel names the interface; it does so after what was set up.
        order.extend(attribute(kind::NAME, b"can0\0"));
        let len = order.len() as u32;
        order[..4].copy_from_slice(&len.to_ne_bytes());
        match read(&order).pop() {
            Some(News::Is(link)) => link,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_setup_is_told_as_the_kernel_tells_of_it() {
        let setup = Setup {
            bits: Some(BitTiming { bitrate: 500_000, sample_point: 875 }),
            data_bits: Some(BitTiming { bitrate: 2_000_000, sample_point: 750 }),
            modes: Modes(Modes::FD | Modes::LISTEN_ONLY),
            restart_ms: 100,
            mtu: None,
        };
        let link = read_back(set(7, &setup));
        assert_eq!((link.index, link.kind.as_str(), Setup::of(&link)), (7, "can", setup));
        let wide = Setup { bits: None, data_bits: None, modes: Modes(0), restart_ms: 0, mtu: Some(72) };
        assert_eq!(read_back(set(7, &wide)).mtu, 72);
        assert!(read_back(up(7, true)).up && !read_back(up(7, false)).up && !read_back(nothing(7)).up);
    }

    #[test]
    fn every_order_is_a_whole_message_that_asks_for_an_answer() {
        for order in [nothing(3), up(3, true), restart(3)] {
            assert_eq!(order[..4], (order.len() as u32).to_ne_bytes());
            assert_eq!(order[4..8], [16, 0, 5, 0], "{order:?}");
        }
        let question = question("can0");
        assert_eq!(question[..8], [44, 0, 0, 0, 18, 0, 1, 0], "{question:?}");
    }
}
