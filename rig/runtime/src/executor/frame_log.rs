//! The CAN frames of a case, as `candump -L` writes them: what other tools replay and look at.

use drivers::{Bus, BusId, BusKind};
use signal::{CanFrame, Time};
use std::fmt::Write;

/// The most frames that are kept: a busy bus of 500 kbit/s for about 16 s.
const MOST: usize = 65_536;

/// A frame that was on a bus.
#[derive(Clone, Copy, Debug)]
struct Heard {
    at: Time,
    bus: BusId,
    frame: CanFrame,
}

/// The first frames of a case. It has its memory from the start.
#[derive(Debug, Default)]
pub struct FrameLog {
    heard: Vec<Heard>,
    more: u64,
}

impl FrameLog {
    /// For these buses; without a CAN bus among them it takes no memory.
    pub fn of(buses: &[Bus]) -> FrameLog {
        let has_can = buses.iter().any(|bus| matches!(bus.kind, BusKind::Can { .. }));
        FrameLog { heard: Vec::with_capacity(if has_can { MOST } else { 0 }), more: 0 }
    }

    /// Keeps a frame that was on the bus by this instant, if there is room.
    pub fn hear(&mut self, at: Time, bus: BusId, frame: &CanFrame) {
        if self.heard.len() < self.heard.capacity().min(MOST) {
            self.heard.push(Heard { at, bus, frame: *frame });
        } else {
            self.more += 1;
        }
    }

    /// Frames that are kept, and those that found no room.
    pub fn counts(&self) -> (u64, u64) {
        (self.heard.len() as u64, self.more)
    }

    /// A line for each frame, seconds of the trace before it; buses by their names.
    pub fn text(&self, buses: &[Bus]) -> String {
        let mut text = String::new();
        for Heard { at, bus, frame } in &self.heard {
            let micros = at.as_nanos() / 1_000;
            let name = buses.get(usize::from(bus.0)).map_or("", |bus| bus.name.as_str());
            let digits = if frame.extended { 8 } else { 3 };
            // Writing into a text cannot fail.
            let _ = write!(
                text,
                "({:010}.{:06}) {name} {:0digits$X}",
                micros / 1_000_000,
                micros % 1_000_000,
                frame.id
            );
            text += if frame.fd { "##" } else { "#" };
            if frame.fd {
                let _ = write!(text, "{:X}", u8::from(frame.brs) | u8::from(frame.esi) << 1);
            }
            match frame.remote {
                true => {
                    let _ = write!(text, "R{}", frame.len);
                }
                false => frame.data().iter().for_each(|byte| {
                    let _ = write!(text, "{byte:02X}");
                }),
            }
            text.push('\n');
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use drivers::TimestampSource;
    use signal::Span;

    fn buses() -> Vec<Bus> {
        let bus = |name: &str| Bus {
            name: name.into(),
            kind: BusKind::Can { bitrate: 500_000, data_bitrate: None },
            timestamp: TimestampSource::Virtual,
            resolution: Span::ZERO,
        };
        vec![bus("machine"), bus("drive")]
    }

    #[test]
    fn lines_are_those_of_candump() {
        let buses = buses();
        let mut log = FrameLog::of(&buses);
        let at = |nanos: i64| Time::ZERO + Span::from_nanos(nanos);
        let classic = CanFrame::classic(0x44, false, &[0x2A, 0x36]).unwrap();
        log.hear(at(1_249_713_999), BusId(0), &classic);
        log.hear(at(2_000_000_000), BusId(1), &CanFrame { id: 0x123, extended: true, ..classic });
        log.hear(at(2_000_000_000), BusId(1), &CanFrame { remote: true, len: 8, data: [0; 64], ..classic });
        log.hear(at(12_000_000_000), BusId(0), &CanFrame { fd: true, brs: true, esi: true, ..classic });
        assert_eq!(
            log.text(&buses),
            "(0000000001.249713) machine 044#2A36\n(0000000002.000000) drive 00000123#2A36\n\
             (0000000002.000000) drive 044#R8\n(0000000012.000000) machine 044##32A36\n"
        );
    }

    #[test]
    fn what_finds_no_room_is_counted_and_a_board_without_can_takes_none() {
        let mut log = FrameLog::of(&buses());
        let frame = CanFrame::classic(1, false, &[]).unwrap();
        for _ in 0..MOST + 3 {
            log.hear(Time::ZERO, BusId(0), &frame);
        }
        assert_eq!(log.counts(), (MOST as u64, 3));
        assert_eq!(FrameLog::of(&[]).heard.capacity(), 0);
    }
}
