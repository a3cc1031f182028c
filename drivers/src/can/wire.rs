//! CAN frames as the kernel passes them (`struct can_frame` and `struct canfd_frame` of `linux/can.h`).

use signal::{CanFrame, MAX_CAN_DATA};

/// Length of a classic frame, and of one of CAN FD.
pub const CLASSIC: usize = 16;
/// See [`CLASSIC`].
pub const FD: usize = 72;

const EXTENDED: u32 = 0x8000_0000;
const REMOTE: u32 = 0x4000_0000;
const ERROR: u32 = 0x2000_0000;
const BITS_29: u32 = 0x1FFF_FFFF;
const BITS_11: u32 = 0x7FF;
/// Flags of a CAN FD frame: fast data, error-passive sender, CAN FD at all.
const BRS: u8 = 1;
const ESI: u8 = 2;
const FDF: u8 = 4;

/// The lengths that a CAN FD frame can have.
const FD_LENGTHS: [u8; 16] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64];

/// What a socket reported.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Datagram {
    /// A frame of the bus.
    Frame(CanFrame),
    /// A report of the controller: its classes, and its details.
    Report(u32, [u8; 8]),
}

/// Reads what a socket reported. `None` where it is nothing that the kernel would write.
pub fn decode(bytes: &[u8]) -> Option<Datagram> {
    let fd = match bytes.len() {
        CLASSIC => false,
        FD => true,
        _ => return None,
    };
    let word = u32::from_ne_bytes(bytes.first_chunk().copied()?);
    let (len, flags) = (bytes[4], bytes[5]);
    if word & ERROR != 0 && !fd {
        return Some(Datagram::Report(word & BITS_29, bytes[8..].first_chunk().copied()?));
    }
    let extended = word & EXTENDED != 0;
    let remote = word & REMOTE != 0;
    let fits = if fd { usize::from(len) <= MAX_CAN_DATA && !remote } else { len <= 8 };
    if !fits || word & ERROR != 0 {
        return None;
    }
    let mut data = [0; MAX_CAN_DATA];
    if !remote {
        data[..usize::from(len)].copy_from_slice(&bytes[8..8 + usize::from(len)]);
    }
    Some(Datagram::Frame(CanFrame {
        id: word & if extended { BITS_29 } else { BITS_11 },
        extended,
        remote,
        fd,
        brs: fd && flags & BRS != 0,
        esi: fd && flags & ESI != 0,
        len,
        data,
    }))
}

/// A frame as the kernel takes it, and its length. `None` where no frame can be like that.
pub fn encode(frame: &CanFrame) -> Option<([u8; FD], usize)> {
    let most = if frame.extended { BITS_29 } else { BITS_11 };
    let fits = match frame.fd {
        true => !frame.remote && FD_LENGTHS.contains(&frame.len),
        false => frame.len <= 8 && !frame.brs && !frame.esi,
    };
    if frame.id > most || !fits {
        return None;
    }
    let mut word = frame.id;
    word |= if frame.extended { EXTENDED } else { 0 };
    word |= if frame.remote { REMOTE } else { 0 };
    let mut bytes = [0; FD];
    bytes[..4].copy_from_slice(&word.to_ne_bytes());
    bytes[4] = frame.len;
    if frame.fd {
        bytes[5] = FDF | if frame.brs { BRS } else { 0 } | if frame.esi { ESI } else { 0 };
    }
    let data = frame.data();
    bytes[8..8 + data.len()].copy_from_slice(data);
    Some((bytes, if frame.fd { FD } else { CLASSIC }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_classic_frame_is_laid_out_as_the_kernel_has_it() {
        let frame = CanFrame::classic(0x1ABC_DEF0, true, &[1, 2, 3]).unwrap();
        let (bytes, len) = encode(&frame).unwrap();
        assert_eq!(len, 16);
        assert_eq!(bytes[..4], 0x9ABC_DEF0u32.to_ne_bytes());
        assert_eq!(bytes[4..16], [3, 0, 0, 0, 1, 2, 3, 0, 0, 0, 0, 0]);
    }

    #[test]
    fn frames_that_cannot_be_are_not_made() {
        let sound = CanFrame::classic(0x7FF, false, &[0; 8]).unwrap();
        assert!(encode(&sound).is_some());
        for wrong in [
            CanFrame { id: 0x800, ..sound },
            CanFrame { len: 9, ..sound },
            CanFrame { brs: true, ..sound },
            CanFrame { fd: true, len: 9, ..sound },
            CanFrame { fd: true, remote: true, ..sound },
        ] {
            assert_eq!(encode(&wrong), None, "{wrong:?}");
        }
        assert!(encode(&CanFrame { fd: true, len: 64, ..sound }).is_some());
    }

    proptest! {
        #[test]
        fn any_bytes_are_read_or_refused_and_what_was_read_can_be_sent_again(
            bytes in proptest::collection::vec(any::<u8>(), 0..80),
            whole in proptest::sample::select(vec![CLASSIC, FD, 0]),
        ) {
            let mut bytes = bytes;
            if whole > 0 {
                bytes.resize(whole, 0);
            }
            if let Some(Datagram::Frame(frame)) = decode(&bytes)
                && let Some((again, len)) = encode(&frame)
            {
                prop_assert_eq!(decode(&again[..len]), Some(Datagram::Frame(frame)));
            }
        }
    }
}
