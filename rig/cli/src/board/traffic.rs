//! What passes on the buses of a board, shown and counted.

use super::activity::loss;
use drivers::{Bus, BusError, BusEvent, BusKind, BusState, LossReason};

/// What happened on a bus since it was looked at first.
#[derive(Clone, Debug, Default)]
pub struct Traffic {
    frames: u64,
    errors: u64,
    missed: u64,
    state: Option<BusState>,
    lost: Option<LossReason>,
}

impl Traffic {
    /// Takes an event of the bus: what is shown of it.
    pub fn take(&mut self, event: &BusEvent) -> String {
        match *event {
            BusEvent::CanFrame { frame, .. } => {
                self.frames += 1;
                format!("{frame:?}")
            }
            BusEvent::SerialMessage { message, .. } => {
                self.frames += 1;
                self.errors += u64::from(message.errors.any());
                format!("{message:?}")
            }
            BusEvent::State { state, .. } => {
                self.state = Some(state);
                words(state).to_owned()
            }
            BusEvent::Error { error, .. } => {
                self.errors += 1;
                wrong(error)
            }
            BusEvent::Dropped { count, .. } => {
                self.missed = self.missed.saturating_add(u64::from(count));
                format!("{count} missed")
            }
            BusEvent::Lost { reason, .. } => {
                self.lost = Some(reason);
                loss(reason).to_owned()
            }
            BusEvent::Returned { .. } => {
                self.lost = None;
                "back".to_owned()
            }
        }
    }

    /// How the bus fares, in words.
    fn fares(&self, bus: &Bus) -> String {
        let missed = if self.missed > 0 { format!(", {} missed", self.missed) } else { String::new() };
        match (self.lost, bus.kind) {
            (Some(reason), _) => format!("{}{missed}", loss(reason)),
            (None, BusKind::Serial { settings }) => format!("held at {settings}{missed}"),
            (None, BusKind::Can { .. }) => {
                format!("{}{missed}", self.state.map_or("no trouble", words))
            }
        }
    }
}

/// A row of a bus; the first column is so wide.
pub fn row(bus: &Bus, traffic: &Traffic, wide: usize) -> String {
    let counts = match bus.kind {
        BusKind::Can { .. } => format!("{:>6} frames {:>6} errors", traffic.frames, traffic.errors),
        BusKind::Serial { .. } => format!("{:>4} messages {:>6} errors", traffic.frames, traffic.errors),
    };
    format!("{:<wide$}  {counts}  {}", bus.name, traffic.fares(bus))
}

fn words(state: BusState) -> &'static str {
    match state {
        BusState::ErrorActive => "error-active",
        BusState::ErrorWarning => "error warning",
        BusState::ErrorPassive => "error-passive",
        BusState::BusOff => "bus-off",
        BusState::Stopped => "stopped",
    }
}

fn wrong(error: BusError) -> String {
    match error {
        BusError::NoAck => "nobody acknowledges".to_owned(),
        BusError::LostArbitration(Some(bit)) => format!("arbitration lost at bit {bit}"),
        BusError::LostArbitration(None) => "arbitration lost".to_owned(),
        BusError::Protocol => "bit, stuff, form or CRC error".to_owned(),
        BusError::ReceiveOverflow => "the controller lost frames that came".to_owned(),
        BusError::SendOverflow => "the controller lost frames that were to go".to_owned(),
        BusError::SendTimeout => "a frame was not sent in time".to_owned(),
        BusError::Transceiver => "the transceiver reports a fault".to_owned(),
        BusError::Other => "the controller reports an error".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use drivers::{BusId, TimestampSource};
    use signal::{CanFrame, Span, Time, When};

    #[test]
    fn frames_errors_and_states_are_counted_and_told() {
        let (bus, at) = (BusId(0), Time::ZERO);
        let mut traffic = Traffic::default();
        let frame = CanFrame::classic(0x701, false, &[5]).unwrap();
        let reported = [
            BusEvent::CanFrame { bus, at: When::exactly(at), frame, own: false },
            BusEvent::Error { bus, at, error: BusError::NoAck },
            BusEvent::State { bus, at, state: BusState::ErrorPassive },
            BusEvent::Dropped { bus, at, count: 3 },
        ]
        .map(|event| traffic.take(&event));
        assert_eq!(reported, ["701#05", "nobody acknowledges", "error-passive", "3 missed"]);
        let of = Bus {
            name: "machine".into(),
            kind: BusKind::Can { bitrate: 500_000, data_bitrate: None },
            timestamp: TimestampSource::Kernel,
            resolution: Span::ZERO,
        };
        assert_eq!(row(&of, &traffic, 9), "machine         1 frames      1 errors  error-passive, 3 missed");
        traffic.take(&BusEvent::Lost { bus, at, reason: LossReason::Gone });
        assert!(row(&of, &traffic, 9).ends_with("gone, 3 missed"));
    }
}
