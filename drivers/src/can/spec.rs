//! What a board file says of CAN buses.

use std::ops::Range;

use signal::{CanFrame, Span};

use crate::{Bus, BusId, BusKind, TimestampSource};

/// The CAN buses of a board.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CanSpec {
    /// The buses, in the order of their numbers.
    pub buses: Vec<CanBusSpec>,
}

/// A CAN bus, and the interface by which the rig takes part in it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CanBusSpec {
    /// Its number.
    pub bus: BusId,
    /// Its name in the board file.
    pub name: String,
    /// Where the file names it, and where it names the interface.
    pub place: Range<usize>,
    /// See [`CanBusSpec::place`].
    pub interface_place: Range<usize>,
    /// The interface, as in `can0`.
    pub interface: String,
    /// In bit/s.
    pub bitrate: u32,
    /// Where in a bit it is looked at, in thousandths; `None`: anywhere.
    pub sample_point: Option<u32>,
    /// Bit rate of fast data; `None` on classic CAN.
    pub data_bitrate: Option<u32>,
    /// Where in a bit of fast data it is looked at, in thousandths; `None`: anywhere.
    pub data_sample_point: Option<u32>,
    /// The frames that the kernel hands over; all where there is none.
    pub accept: Vec<Filter>,
    /// How long after bus-off the controller starts again, by the kernel or else by the rig; `None`: it is not asked.
    pub restart: Option<Span>,
    /// The controller never drives the bus, not even to acknowledge.
    pub listen_only: bool,
    /// The rig sets the interface up, and back as it was.
    pub configure: bool,
}

/// Frames by their identifiers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Filter {
    /// The identifier.
    pub id: u32,
    /// The bits of it that count.
    pub mask: u32,
    /// It has 29 bits.
    pub extended: bool,
}

impl Filter {
    /// Reads `123` or `700/780`: an identifier in hexadecimal digits, and the bits of it that count. Three digits at
    /// most are an identifier of 11 bits, eight are one of 29 bits.
    pub fn parse(text: &str) -> Option<Filter> {
        let (id, mask) = text.split_once('/').map_or((text, None), |(id, mask)| (id, Some(mask)));
        let extended = match id.len() {
            1..=3 => false,
            8 => true,
            _ => return None,
        };
        let most = if extended { 0x1FFF_FFFF } else { 0x7FF };
        let number = |text: &str| {
            let digits = !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_hexdigit());
            u32::from_str_radix(text, 16).ok().filter(|number| digits && *number <= most)
        };
        let id = number(id)?;
        let mask = mask.map_or(Some(most), number)?;
        Some(Filter { id, mask, extended })
    }

    /// Whether it takes this frame.
    pub fn takes(&self, frame: &CanFrame) -> bool {
        frame.extended == self.extended && (frame.id ^ self.id) & self.mask == 0
    }
}

impl CanBusSpec {
    /// Whether a frame of this identifier reaches the rig, its own as well.
    pub fn takes(&self, frame: &CanFrame) -> bool {
        self.accept.is_empty() || self.accept.iter().any(|filter| filter.takes(frame))
    }

    /// The bus on paper.
    pub fn described(&self) -> Bus {
        Bus {
            name: self.name.clone(),
            kind: BusKind::Can { bitrate: self.bitrate, data_bitrate: self.data_bitrate },
            timestamp: TimestampSource::Kernel,
            resolution: Span::ZERO,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn filters_take_what_they_say() {
        let filter = Filter::parse("700/780").unwrap();
        assert!(filter.takes(&CanFrame::classic(0x77F, false, &[]).unwrap()));
        assert!(!filter.takes(&CanFrame::classic(0x780, false, &[]).unwrap()));
        assert!(!filter.takes(&CanFrame::classic(0x700, true, &[]).unwrap()));
        assert_eq!(Filter::parse("00000123"), Some(Filter { id: 0x123, mask: 0x1FFF_FFFF, extended: true }));
        for wrong in ["", "800", "1234", "12g", "123/", "123/800", "+12", "20000000", "123/1/1"] {
            assert_eq!(Filter::parse(wrong), None, "{wrong}");
        }
    }

    proptest! {
        #[test]
        fn any_text_is_read_or_refused(text in "\\PC{0,12}") {
            if let Some(filter) = Filter::parse(&text) {
                prop_assert!(filter.id <= 0x1FFF_FFFF && filter.mask <= 0x1FFF_FFFF);
            }
        }
    }
}
