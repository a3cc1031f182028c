//! What the kernel reports of a CAN interface: messages of rtnetlink (`linux/rtnetlink.h`, `linux/can/netlink.h`).

use kind::{
    CAN_BERR_COUNTER, CAN_BITTIMING, CAN_CTRLMODE, CAN_DATA_BITTIMING, CAN_RESTART_MS, CAN_STATE,
    DELETED_LINK, ERROR, INFO_DATA, INFO_KIND, LINK_INFO, MTU, NAME, NEW_LINK, RUNNING, UP,
};

use crate::BusState;

/// Length of the head of a message, and of what follows in a message about an interface.
const HEAD: usize = 16;
const ABOUT: usize = 16;
/// Flags of an attribute's kind that are no part of it.
const KIND_BITS: u16 = 0x3FFF;

/// Kinds of messages, of flags and of attributes.
pub(super) mod kind {
    pub const ERROR: u16 = 2;
    pub const NEW_LINK: u16 = 16;
    pub const DELETED_LINK: u16 = 17;
    pub const GET_LINK: u16 = 18;
    /// The interface is up; frames can pass.
    pub const UP: u32 = 0x1;
    pub const RUNNING: u32 = 0x40;
    /// Attributes of an interface, of its kind, of a CAN interface.
    pub const NAME: u16 = 3;
    pub const MTU: u16 = 4;
    pub const LINK_INFO: u16 = 18;
    pub const INFO_KIND: u16 = 1;
    pub const INFO_DATA: u16 = 2;
    pub const CAN_BITTIMING: u16 = 1;
    pub const CAN_STATE: u16 = 4;
    pub const CAN_CTRLMODE: u16 = 5;
    pub const CAN_RESTART_MS: u16 = 6;
    pub const CAN_RESTART: u16 = 7;
    pub const CAN_BERR_COUNTER: u16 = 8;
    pub const CAN_DATA_BITTIMING: u16 = 9;
}

/// A bit rate as an interface has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BitTiming {
    /// In bit/s.
    pub bitrate: u32,
    /// Where in the bit it is looked at, in thousandths.
    pub sample_point: u32,
}

/// How a controller is set up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Modes(pub u32);

impl Modes {
    /// It hears what it sends, and nothing goes out.
    pub const LOOPBACK: u32 = 0x1;
    /// It never drives the bus, not even to acknowledge.
    pub const LISTEN_ONLY: u32 = 0x2;
    /// It sends a frame once, whatever becomes of it.
    pub const ONE_SHOT: u32 = 0x8;
    /// It reports every error on the bus.
    pub const ERRORS: u32 = 0x10;
    /// CAN FD.
    pub const FD: u32 = 0x20;

    /// Whether it is set up like that.
    pub fn has(self, mode: u32) -> bool {
        self.0 & mode != 0
    }
}

/// An interface as the kernel reports it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Link {
    /// Its number.
    pub index: u32,
    /// Its name, as in `can0`.
    pub name: String,
    /// It is up.
    pub up: bool,
    /// The kernel lets frames pass: not so in bus-off, and for a moment after it.
    pub running: bool,
    /// The most bytes of a frame as the kernel passes them: 16 of classic CAN, 72 of CAN FD.
    pub mtu: u32,
    /// What kind of interface it is: `can`, `vcan`, `vxcan`; empty where the kernel does not say.
    pub kind: String,
    /// Of arbitration; `None` where the interface has no bits, or none were set.
    pub bits: Option<BitTiming>,
    /// Of fast data.
    pub data_bits: Option<BitTiming>,
    /// How it takes part in the bus.
    pub state: Option<BusState>,
    /// How it is set up.
    pub modes: Modes,
    /// How long after bus-off the kernel starts it again, in milliseconds; 0 for never.
    pub restart_ms: u32,
    /// Its counters of errors while sending and while receiving.
    pub errors: Option<(u16, u16)>,
}

impl Link {
    /// It has no bits: all in software.
    pub fn is_virtual(&self) -> bool {
        self.kind != "can"
    }
}

/// What a message says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum News {
    /// An interface is like that now.
    Is(Link),
    /// An interface is gone.
    Gone(Link),
    /// The kernel refuses what it was asked, with this error number; 0: what it was asked is done.
    Refused(i32),
}

/// Reads the messages of a datagram. What is cut off, or is none of ours, is left out.
pub fn read(datagram: &[u8]) -> Vec<News> {
    let (mut news, mut rest) = (Vec::new(), datagram);
    while let (Some(len), Some(kind)) = (u32_at(rest, 0), u16_at(rest, 4)) {
        let len = len as usize;
        let Some(message) = rest.get(HEAD..len) else { break };
        match kind {
            ERROR => {
                news.extend(u32_at(message, 0).map(|code| News::Refused(code.cast_signed().wrapping_neg())))
            }
            NEW_LINK => news.extend(link(message).map(News::Is)),
            DELETED_LINK => news.extend(link(message).map(News::Gone)),
            _ => {}
        }
        rest = rest.get(len.next_multiple_of(4)..).unwrap_or_default();
    }
    news
}

fn link(message: &[u8]) -> Option<Link> {
    let flags = u32_at(message, 8)?;
    let mut link = Link {
        index: u32_at(message, 4)?,
        name: String::new(),
        up: flags & UP != 0,
        running: flags & RUNNING != 0,
        mtu: 0,
        kind: String::new(),
        bits: None,
        data_bits: None,
        state: None,
        modes: Modes::default(),
        restart_ms: 0,
        errors: None,
    };
    for (kind, value) in attributes(message.get(ABOUT..)?) {
        match kind {
            NAME => link.name = text(value),
            MTU => link.mtu = u32_at(value, 0).unwrap_or_default(),
            LINK_INFO => {
                for (kind, value) in attributes(value) {
                    match kind {
                        INFO_KIND => link.kind = text(value),
                        INFO_DATA => can(value, &mut link),
                        _ => {}
                    }
                }
            }
            _ => {}
        }
    }
    (!link.name.is_empty()).then_some(link)
}

/// Attributes of a CAN interface.
fn can(value: &[u8], link: &mut Link) {
    let timing = |value| {
        let (bitrate, sample_point) = (u32_at(value, 0)?, u32_at(value, 4)?);
        (bitrate > 0).then_some(BitTiming { bitrate, sample_point })
    };
    for (kind, value) in attributes(value) {
        match kind {
            CAN_BITTIMING => link.bits = timing(value),
            CAN_DATA_BITTIMING => link.data_bits = timing(value),
            CAN_STATE => link.state = u32_at(value, 0).and_then(state),
            // A mask, then the flags.
            CAN_CTRLMODE => link.modes = Modes(u32_at(value, 4).unwrap_or_default()),
            CAN_RESTART_MS => link.restart_ms = u32_at(value, 0).unwrap_or_default(),
            CAN_BERR_COUNTER => link.errors = u16_at(value, 0).zip(u16_at(value, 2)),
            _ => {}
        }
    }
}

fn state(number: u32) -> Option<BusState> {
    Some(match number {
        0 => BusState::ErrorActive,
        1 => BusState::ErrorWarning,
        2 => BusState::ErrorPassive,
        3 => BusState::BusOff,
        4 | 5 => BusState::Stopped,
        _ => return None,
    })
}

/// Kind and value of each attribute, up to the first that is cut off.
fn attributes(bytes: &[u8]) -> impl Iterator<Item = (u16, &[u8])> {
    let mut rest = bytes;
    std::iter::from_fn(move || {
        let (len, kind) = (usize::from(u16_at(rest, 0)?), u16_at(rest, 2)?);
        let value = rest.get(4..len)?;
        rest = rest.get(len.next_multiple_of(4)..).unwrap_or_default();
        Some((kind & KIND_BITS, value))
    })
}

fn text(value: &[u8]) -> String {
    let end = value.iter().position(|byte| *byte == 0).unwrap_or(value.len());
    String::from_utf8_lossy(&value[..end]).into_owned()
}

fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    bytes.get(at..at + 2)?.first_chunk().copied().map(u16::from_ne_bytes)
}

fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    bytes.get(at..at + 4)?.first_chunk().copied().map(u32::from_ne_bytes)
}

#[cfg(test)]
mod tests {
    use super::super::order::{attribute, bytes};
    use super::*;
    use proptest::prelude::*;

    fn message(kind: u16, attributes: &[Vec<u8>]) -> Vec<u8> {
        let mut bytes = bytes(&[0, 0, 0, 0, 0, 7, UP | RUNNING, 0]);
        bytes.extend(attributes.concat());
        let len = bytes.len() as u32;
        bytes[..4].copy_from_slice(&len.to_ne_bytes());
        bytes[4..6].copy_from_slice(&kind.to_ne_bytes());
        bytes
    }

    fn refusal(code: i32) -> Vec<u8> {
        let mut refused = bytes(&[20, 0, 0, 0, code.cast_unsigned()]);
        refused[4..6].copy_from_slice(&ERROR.to_ne_bytes());
        refused
    }

    fn of_can() -> Vec<u8> {
        let data = [
            attribute(CAN_BITTIMING, &bytes(&[500_000, 875, 0, 0, 0, 0, 0, 0])),
            attribute(CAN_STATE, &bytes(&[2])),
            attribute(CAN_CTRLMODE, &bytes(&[0xFF, Modes::FD | Modes::LISTEN_ONLY])),
            attribute(CAN_RESTART_MS, &bytes(&[100])),
            attribute(CAN_BERR_COUNTER, &[128, 0, 3, 0]),
        ];
        let info = [attribute(INFO_KIND, b"can\0"), attribute(INFO_DATA | 0x8000, &data.concat())];
        message(
            NEW_LINK,
            &[
                attribute(NAME, b"can0\0"),
                attribute(MTU, &bytes(&[72])),
                attribute(LINK_INFO, &info.concat()),
            ],
        )
    }

    #[test]
    fn an_interface_is_read_with_its_settings() {
        let [News::Is(link)] = &read(&of_can())[..] else { panic!() };
        assert_eq!((link.index, link.name.as_str(), link.kind.as_str(), link.mtu), (7, "can0", "can", 72));
        assert_eq!(link.bits, Some(BitTiming { bitrate: 500_000, sample_point: 875 }));
        assert_eq!((link.data_bits, link.restart_ms), (None, 100));
        assert_eq!((link.state, link.errors), (Some(BusState::ErrorPassive), Some((128, 3))));
        assert!(link.up && link.running && link.modes.has(Modes::FD) && !link.modes.has(Modes::ONE_SHOT));
    }

    #[test]
    fn a_refusal_may_have_any_number() {
        for (code, number) in [(0, 0), (-19, 19), (i32::MAX, -i32::MAX), (i32::MIN, i32::MIN)] {
            assert_eq!(read(&refusal(code)), [News::Refused(number)], "{code}");
        }
    }

    #[test]
    fn several_messages_of_a_datagram_are_read_and_a_refusal_is_one() {
        let gone = message(DELETED_LINK, &[attribute(NAME, b"can0\0")]);
        let all = read(&[gone, refusal(-19)].concat());
        assert!(matches!(&all[..], [News::Gone(link), News::Refused(19)] if link.name == "can0"), "{all:?}");
    }

    proptest! {
        #[test]
        fn any_bytes_are_read(bytes in proptest::collection::vec(any::<u8>(), 0..256)) {
            prop_assert!(read(&bytes).len() <= bytes.len() / HEAD + 1);
        }

        #[test]
        fn a_message_with_a_few_other_bytes_is_read(
            at in proptest::collection::vec((0usize..200, any::<u8>()), 1..6),
            cut in 0usize..200,
        ) {
            let mut bytes = of_can();
            for (place, byte) in at {
                let place = place % bytes.len();
                bytes[place] = byte;
            }
            bytes.truncate(cut);
            let _ = read(&bytes);
        }
    }
}
