//! The wrappers around a board.

use crate::common::*;
use proptest::prelude::*;
use scanrig_drivers::circuit::{BusSpecKind, CanRates};
use scanrig_drivers::real::{FaultRelays, OfflineBoard};
use scanrig_drivers::{
    Board, BoardError, BoardEvent, BoardExt, Bus, BusEvent, BusId, BusSpec, Buses, Channel, ChannelId,
    Descriptions, Disturbance, Emission, Faulty, Health, LineApi, OutputClaim, PulseOutputs, SimulatedBoard,
};
use signal::{CanFrame, SerialOutput, SerialSettings, Span, Time, Value};
use std::fs::File;

fn board() -> SimulatedBoard {
    let mut circuit = digital(1, 1);
    circuit.wires.push(wire(0, 1, 5));
    SimulatedBoard::new(&circuit, 0).unwrap()
}

/// Toggles Q0 every 100 ns and polls wherever the board says that something happens; calls that fail are made
/// again.
fn run(disturbance: Disturbance, seed: u64, toggles: i64) -> (Vec<BoardEvent>, Faulty<SimulatedBoard>, u64) {
    let mut board = Faulty::new(board(), disturbance, seed);
    board.start(at(0)).unwrap();
    let (mut events, mut refused) = (Vec::new(), 0);
    let mut poll = |board: &mut Faulty<SimulatedBoard>, until: i64, refused: &mut u64| {
        while let Some(next) = board.next_event().filter(|next| next.as_nanos() <= until) {
            let before = events.len();
            match board.poll(next, &mut events) {
                Ok(()) => {
                    assert!(events.len() > before || board.next_event() != Some(next), "a poll for nothing")
                }
                Err(error) => {
                    assert!(matches!(error, BoardError::Os { .. }));
                    *refused += 1;
                }
            }
        }
    };
    for n in 1..=toggles {
        let now = n * 100;
        poll(&mut board, now - 1, &mut refused);
        while board.write(at(now), &[(id(0), Value::Bool(n % 2 == 1))]).is_err() {
            refused += 1;
            if refused > 100_000 {
                break;
            }
            if disturbance.call_ppm == 0 {
                break;
            }
        }
    }
    poll(&mut board, i64::MAX / 4, &mut refused);
    (events, board, refused)
}

#[test]
fn without_disturbance_nothing_differs() {
    let (events, board, _) = run(Disturbance::default(), 1, 50);
    // Two first values, then each toggle on both lines.
    assert_eq!(events.len(), 2 + 50 + 50);
    assert!(board.health().is_sound());
}

#[test]
fn a_lost_device_comes_back_with_its_present_value() {
    let disturbance = Disturbance { lose_ppm: 100_000, lost_for: ns(250), ..Disturbance::default() };
    let (events, board, _) = run(disturbance, 3, 200);
    let lost = events.iter().filter(|event| matches!(event, BoardEvent::Lost { .. })).count();
    assert!(lost > 3);
    for (place, event) in events.iter().enumerate() {
        let BoardEvent::Returned { channel, at } = event else { continue };
        let next = events[place + 1..].iter().find(|event| event.channel() == *channel).unwrap();
        assert!(matches!(next, BoardEvent::Changed { at: when, .. } if when.latest == *at));
    }
    assert_eq!(board.health().lost, 0, "all are back");
}

#[test]
fn a_device_that_is_away_cannot_be_written() {
    let disturbance = Disturbance { lose_ppm: 1_000_000, lost_for: ns(1_000), ..Disturbance::default() };
    let mut board = Faulty::new(board(), disturbance, 0);
    board.start(at(0)).unwrap();
    poll(&mut board, 0);
    board.write(at(10), &[(id(0), ON)]).unwrap();
    poll(&mut board, 10);
    assert!(matches!(board.write(at(20), &[(id(0), OFF)]), Err(BoardError::Os { .. })));
    assert!(!board.health().is_sound());
    poll(&mut board, 2_000);
    board.write(at(2_000), &[(id(0), OFF)]).unwrap();
}

proptest! {
    /// The same seed gives the same trouble; every change is reported, or its loss is.
    #[test]
    fn trouble_follows_from_the_seed(seed in any::<u64>(), late in 0u32..500_000, drop in 0u32..500_000, call in 0u32..300_000) {
        let disturbance = Disturbance {
            late_ppm: late,
            late_by: Span::from_nanos(700),
            drop_ppm: drop,
            call_ppm: call,
            ..Disturbance::default()
        };
        let (events, board, refused) = run(disturbance, seed, 60);
        let (again, _, _) = run(disturbance, seed, 60);
        prop_assert_eq!(&events, &again);
        let mut changed = 0;
        let mut dropped = 0u64;
        for event in &events {
            match event {
                BoardEvent::Changed { .. } => changed += 1,
                BoardEvent::Dropped { count, .. } => dropped += u64::from(*count),
                other => prop_assert!(false, "{:?}", other),
            }
        }
        prop_assert_eq!(changed + dropped, 2 + 60 + 60);
        prop_assert_eq!(dropped, board.health().dropped);
        prop_assert_eq!(refused, board.health().failed_calls);
        prop_assert!(events.windows(2).all(|pair| pair[0].latest() <= pair[1].latest()), "oldest first");
        // The true instant of a late change lies within its interval, and a channel's changes keep their order.
        for n in 0..2 {
            let delay = if n == 1 { 5 } else { 0 };
            let mut before = -1;
            for event in events.iter().filter(|event| event.channel() == id(n)) {
                let BoardEvent::Changed { at, .. } = event else { continue };
                let true_at = at.earliest.as_nanos();
                prop_assert!(true_at == 0 || true_at % 100 == delay);
                prop_assert!(true_at > before);
                prop_assert!(at.latest - at.earliest <= Span::from_nanos(700));
                before = true_at;
            }
        }
    }
}

/// A simulated board that has every capability: devices and noise behind its channels, one
/// behind its bus, outputs that emit, claims.
#[derive(Debug)]
struct Capable(SimulatedBoard);

impl Board for Capable {
    fn inner(&self) -> Option<&dyn Board> {
        Some(&self.0)
    }

    fn inner_mut(&mut self) -> Option<&mut dyn Board> {
        Some(&mut self.0)
    }

    fn channels(&self) -> &[Channel] {
        self.0.channels()
    }

    fn start(&mut self, now: Time) -> Result<(), BoardError> {
        self.0.start(now)
    }

    fn write(&mut self, now: Time, writes: &[(ChannelId, Value)]) -> Result<(), BoardError> {
        self.0.write(now, writes)
    }

    fn poll(&mut self, now: Time, out: &mut Vec<BoardEvent>) -> Result<(), BoardError> {
        self.0.poll(now, out)
    }

    fn next_event(&self) -> Option<Time> {
        self.0.next_event()
    }

    fn safe(&mut self, now: Time) -> Result<(), BoardError> {
        self.0.safe(now)
    }

    fn health(&self) -> Health {
        self.0.health()
    }

    fn buses(&self) -> Option<&dyn Buses> {
        Some(self)
    }

    fn buses_mut(&mut self) -> Option<&mut dyn Buses> {
        Some(self)
    }

    fn pulse_outputs(&mut self) -> Option<&mut dyn PulseOutputs> {
        Some(self)
    }

    fn output_claims(&self) -> Result<Vec<OutputClaim>, BoardError> {
        let claim = File::open("/dev/null").unwrap().into();
        Ok(vec![OutputClaim { device: "chip".into(), claim, api: LineApi::V2, mask: 1, safe: 0 }])
    }

    fn descriptions(&self) -> Option<&dyn Descriptions> {
        Some(self)
    }
}

impl Buses for Capable {
    fn bus_list(&self) -> &[Bus] {
        Buses::bus_list(&self.0)
    }

    fn bus_device(&self, _bus: BusId) -> Option<&str> {
        Some("can0")
    }

    fn send(&mut self, now: Time, bus: BusId, frame: &CanFrame) -> Result<(), BoardError> {
        Buses::send(&mut self.0, now, bus, frame)
    }

    fn send_serial(&mut self, now: Time, bus: BusId, output: &SerialOutput) -> Result<(), BoardError> {
        Buses::send_serial(&mut self.0, now, bus, output)
    }

    fn configure(
        &mut self,
        now: Time,
        bus: BusId,
        settings: &SerialSettings,
        message_gap: Span,
    ) -> Result<(), BoardError> {
        Buses::configure(&mut self.0, now, bus, settings, message_gap)
    }

    fn break_off(&mut self, now: Time, bus: BusId) -> Result<(), BoardError> {
        Buses::break_off(&mut self.0, now, bus)
    }

    fn poll_buses(&mut self, now: Time, out: &mut Vec<BusEvent>) -> Result<(), BoardError> {
        Buses::poll_buses(&mut self.0, now, out)
    }
}

impl PulseOutputs for Capable {
    fn emit(&mut self, _now: Time, _channel: ChannelId, _emission: &Emission) -> Result<(), BoardError> {
        Ok(())
    }
}

impl Descriptions for Capable {
    fn device(&self, _channel: ChannelId) -> Option<&str> {
        Some("chip")
    }

    fn device_kind(&self, _channel: ChannelId) -> Option<&'static str> {
        Some("gpio")
    }

    fn noise(&self, _channel: ChannelId) -> Option<f64> {
        Some(0.5)
    }
}

/// Every capability of the board within, through a wrapper that changes none of them.
fn hides_nothing(mut board: impl Board) {
    let channel = id(0);
    board.start(at(0)).unwrap();
    assert_eq!((board.device(channel), board.noise(channel)), (Some("chip"), Some(0.5)));
    assert_eq!(board.device_kind(channel), Some("gpio"));
    assert_eq!(board.output_claims().unwrap().len(), 1);
    let square = Emission::Square { period: ns(10), high: ns(5) };
    assert_eq!(board.emit(at(1), channel, &square), Ok(()));
    assert!(board.faults().is_some() && board.faults_mut().is_some());
    assert_eq!((board.bus_list().len(), board.bus_device(BusId(0))), (1, Some("can0")));
    assert!(board.buses_mut().is_some());
}

#[test]
fn a_wrapper_hides_no_capability_of_the_board_within() {
    let capable = || {
        let mut circuit = digital(1, 1);
        let kind = BusSpecKind::Can(CanRates { bitrate: 500_000, data_bitrate: None });
        circuit.buses.push(BusSpec { name: "can".into(), kind, joins: None });
        Capable(SimulatedBoard::new(&circuit, 0).unwrap())
    };
    hides_nothing(capable());
    hides_nothing(Faulty::new(capable(), Disturbance::default(), 0));
    hides_nothing(FaultRelays::new(capable(), &[], None));
    hides_nothing(Box::new(capable()) as Box<dyn Board>);
    hides_nothing(Faulty::new(FaultRelays::new(capable(), &[], None), Disturbance::default(), 0));
}

#[test]
fn what_a_board_lacks_is_refused() {
    let mut board = OfflineBoard::default();
    let square = Emission::Square { period: ns(10), high: ns(5) };
    assert!(matches!(board.emit(at(0), id(0), &square), Err(BoardError::NotEmitted(..))));
    assert_eq!((board.device(id(0)), board.fault_settled_at(id(0))), (None, None));
}
