//! Homing and the probe, with switches on a machine that follows the pulses.

use super::*;
use std::ops::Range;

/// A machine: switches at positions, which the outputs move.
struct Machine {
    bench: Bench,
    /// Where the machine stands when the axis begins.
    start: i64,
    reference: Range<i64>,
    index: [i64; 4],
    limits: (i64, i64),
}

const REFERENCE: u8 = 0;
const INDEX: u8 = 1;
const POSITIVE: u8 = 2;
const NEGATIVE: u8 = 3;

impl Machine {
    fn new(start: i64, reference: Range<i64>) -> Machine {
        let on = |input| Some(DriveInput { input, inverted: false });
        let mut config = AxisConfig::new(0, 1);
        (config.start_velocity, config.stop_velocity, config.fast_stop) = (100, 100, 100);
        (config.reference, config.index) = (on(REFERENCE), on(INDEX));
        (config.limit_positive, config.limit_negative) = (on(POSITIVE), on(NEGATIVE));
        let index = [330, 480, 530, 680];
        let bench = Bench::new(&config);
        let mut machine = Machine { bench, start, reference, index, limits: (0, 1000) };
        machine.switch();
        machine
    }

    fn place(&self) -> i64 {
        self.start + self.bench.decoded(PulseOutput::PulseDirection)
    }

    fn switch(&mut self) {
        let place = self.place();
        self.bench.input(REFERENCE, self.reference.contains(&place));
        self.bench.input(INDEX, self.index.contains(&place));
        self.bench.input(POSITIVE, place >= self.limits.1);
        self.bench.input(NEGATIVE, place <= self.limits.0);
    }

    /// Homes towards larger positions; what became of it, and where the machine is then.
    fn home(&mut self, mode: Homing, offset: i64) -> (CommandPhase, i64) {
        let (fast, slow) = (1000 * HERTZ, 200 * HERTZ);
        let method = HomingMethod { mode, forward: true, position: 7000, fast, slow, offset };
        let ticket = self.bench.order(MotionCommand::Home(method), 1000, ramps(10, 10, 0));
        while self.bench.axis.next() < Time::MAX {
            self.bench.until(self.bench.axis.next().as_nanos());
            self.switch();
        }
        (self.bench.axis.phase(ticket), self.place())
    }
}

#[track_caller]
fn homes(mode: Homing, start: i64, reference: Range<i64>, place: i64) {
    for offset in [0, 40, -25] {
        let mut machine = Machine::new(start, reference.clone());
        assert_eq!(machine.home(mode, offset), (CommandPhase::Done, place + offset), "offset {offset}");
        let axis = &machine.bench.axis;
        assert_eq!((axis.position(), axis.homed(), axis.state()), (7000, true, AxisState::Standstill));
    }
}

// io:STD-PTO-09: a place is where the pulse that makes the switch change begins
#[test]
fn homing_finds_its_place() {
    // Long switch: left backwards, so that the first place beside it counts.
    homes(Homing::LongReference, 100, 500..2000, 499);
    homes(Homing::LongReference, 700, 500..2000, 499);
    homes(Homing::LongReferenceAndIndex, 100, 500..2000, 480);
    // Short switch, found in the direction, from itself, and behind the limit.
    homes(Homing::ShortReferenceReversal, 100, 500..540, 499);
    homes(Homing::ShortReferenceReversal, 520, 500..540, 499);
    homes(Homing::ShortReferenceReversal, 800, 500..540, 499);
    homes(Homing::ShortReferenceNoReversal, 100, 500..540, 540);
    homes(Homing::ShortReferenceAndIndexOutside, 100, 500..540, 480);
    homes(Homing::ShortReferenceAndIndexOutside, 800, 500..540, 480);
    homes(Homing::ShortReferenceAndIndexInside, 100, 500..540, 530);
    homes(Homing::ShortReferenceAndIndexInside, 800, 500..540, 530);
}

// io:STD-PTO-09: a switch that is shorter than the way to slow down
#[test]
fn an_overrun_switch_is_found_again() {
    homes(Homing::ShortReferenceReversal, 100, 500..505, 499);
}

// io:STD-PTO-09
#[test]
fn limits_end_a_search_that_does_not_turn_round() {
    let mut machine = Machine::new(800, 500..540);
    let (phase, _) = machine.home(Homing::ShortReferenceNoReversal, 0);
    assert_eq!(phase, CommandPhase::Failed(AxisFault::LimitPositive));
    assert_eq!(machine.bench.axis.state(), AxisState::ErrorStop);
    // No switch at all: the second limit ends the search.
    let mut machine = Machine::new(800, 5000..5001);
    let (phase, _) = machine.home(Homing::ShortReferenceReversal, 0);
    assert_eq!(phase, CommandPhase::Failed(AxisFault::LimitNegative));
    assert!(!machine.bench.axis.homed());
}

// io:STD-PTO-09
#[test]
fn a_position_can_be_set_where_the_axis_stands() {
    let mut machine = Machine::new(100, 500..540);
    assert_eq!(machine.home(Homing::PositionSetting, 0), (CommandPhase::Done, 100));
    assert_eq!((machine.bench.axis.position(), machine.bench.axis.homed()), (7000, true));
}

fn probed() -> Bench {
    let mut config = AxisConfig::new(0, 1);
    (config.start_velocity, config.stop_velocity) = (100, 100);
    config.probe = Some(DriveInput { input: 5, inverted: true });
    let mut bench = Bench::new(&config);
    bench.input(5, true);
    bench
}

// io:STD-PTO-11
#[test]
fn the_probe_captures_within_its_window() {
    let mut bench = probed();
    bench.order(MotionCommand::Velocity(Some(true)), 100, ramps(10, 10, 0));
    let ticket = bench.axis.touch(CaptureTrigger { rising: true, window: Some((10, 20)) }).unwrap();
    for (at, position) in [(45, None), (155, Some(15)), (165, Some(15))] {
        bench.until(at * MS);
        bench.input(5, false);
        bench.input(5, true);
        let (phase, recorded) = bench.axis.touched(ticket);
        assert_eq!((phase == CommandPhase::Done).then_some(recorded), position, "at {at} ms");
    }
    // The other edge, aborted.
    let ticket = bench.axis.touch(CaptureTrigger { rising: false, window: None }).unwrap();
    bench.input(5, false);
    assert_eq!(bench.axis.touched(ticket).0, CommandPhase::Active);
    bench.axis.abort_trigger().unwrap();
    bench.input(5, true);
    assert_eq!(bench.axis.touched(ticket).0, CommandPhase::Aborted);
    let empty = CaptureTrigger { rising: true, window: Some((2, 1)) };
    assert_eq!(bench.axis.touch(empty), Err(AxisFault::InvalidProbe));
}

// io:STD-PTO-11
#[test]
fn a_move_waits_for_the_probe() {
    let mut bench = probed();
    let first = bench.order(MotionCommand::Velocity(Some(true)), 100, ramps(10, 10, 0));
    let command = AxisCommand {
        order: MotionCommand::By(50),
        velocity: 100 * HERTZ,
        ramps: ramps(10, 10, 0),
        mode: BufferMode::Trigger,
        delay: Span::ZERO,
    };
    let ticket = bench.give(command).unwrap();
    bench.until(455 * MS);
    let position = bench.axis.position();
    assert_eq!(bench.axis.phase(ticket), CommandPhase::Waiting);
    bench.input(5, false);
    assert_eq!(
        (bench.axis.phase(first), bench.axis.phase(ticket)),
        (CommandPhase::Aborted, CommandPhase::Active)
    );
    bench.settle();
    assert_eq!((bench.axis.phase(ticket), bench.axis.position()), (CommandPhase::Done, position + 50));
}
