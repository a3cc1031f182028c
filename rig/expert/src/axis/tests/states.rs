//! States of an axis, limits, and what ends its motions.

use super::*;
use ::profile::ChannelSet;

fn usual() -> Ramps {
    ramps(10, 10, 0)
}

fn pulses(bench: &Bench) -> i64 {
    bench.decoded(PulseOutput::PulseDirection)
}

fn switch(input: u8) -> Option<DriveInput> {
    Some(DriveInput { input, inverted: false })
}

fn slow() -> AxisConfig {
    let mut config = AxisConfig::new(0, 1);
    (config.start_velocity, config.stop_velocity, config.fast_stop) = (100, 100, 100);
    config
}

// io:STD-PTO-03, io:STD-PTO-14
#[test]
fn nothing_moves_without_power_or_in_error() {
    let mut bench = Bench::new(&slow());
    bench.with(|axis, now, fx| axis.power(now, false, fx));
    assert_eq!(bench.try_order(MotionCommand::By(5), 100, usual()), Err(AxisFault::Disabled));
    bench.with(|axis, now, fx| axis.power(now, true, fx));
    assert_eq!(bench.axis.state(), AxisState::Standstill);
    bench.with(|axis, now, fx| axis.protect(now, ChannelSet::of(0), fx));
    assert_eq!(bench.axis.state(), AxisState::ErrorStop);
    assert_eq!(bench.try_order(MotionCommand::By(5), 100, usual()), Err(AxisFault::ErrorStopActive));
    assert_eq!(bench.axis.acknowledge(), Err(AxisFault::OutputProtection));
    bench.with(|axis, now, fx| axis.protect(now, ChannelSet::of(2), fx));
    assert_eq!(bench.axis.acknowledge(), Ok(true));
    assert_eq!(bench.axis.state(), AxisState::Standstill);
}

// io:STD-PTO-03: power off ends a move with an error, and the position is not known afterwards
#[test]
fn power_off_ends_pulses_at_once() {
    let mut bench = Bench::new(&slow());
    bench.axis.set_position(0).unwrap();
    let ticket = bench.order(MotionCommand::By(1000), 1000, usual());
    bench.until(150 * MS);
    let emitted = bench.axis.position();
    bench.with(|axis, now, fx| axis.power(now, false, fx));
    assert_eq!(bench.axis.next(), Time::MAX);
    assert_eq!(bench.axis.phase(ticket), CommandPhase::Failed(AxisFault::Disabled));
    assert_eq!((bench.axis.state(), bench.axis.homed()), (AxisState::Disabled, false));
    let (_, a, b) = *bench.waves().last().unwrap();
    assert!(emitted > 10 && !a && !b);
    assert_eq!((bench.axis.position(), pulses(&bench)), (emitted, emitted));
}

// io:STD-PTO-13
#[test]
fn a_stopped_application_leaves_an_axis_disabled() {
    let mut bench = Bench::new(&slow());
    let ticket = bench.order(MotionCommand::Velocity(Some(true)), 1000, usual());
    bench.until(155 * MS);
    let edges = bench.log.len();
    bench.with(|axis, now, fx| axis.operate(now, ExpertOperation::Stopped, fx));
    assert!(bench.log[edges..].iter().all(|(_, fx)| matches!(fx, ExpertEffect::Output { on: false, .. })));
    assert_eq!(bench.axis.phase(ticket), CommandPhase::Failed(AxisFault::ApplicationStopped));
    assert_eq!(bench.axis.state(), AxisState::Disabled);
    assert_eq!(bench.axis.position(), pulses(&bench));
    bench.with(|axis, now, fx| axis.operate(now, ExpertOperation::Running, fx));
    assert_eq!(bench.axis.state(), AxisState::Disabled);
}

// io:STD-PTO-03
#[test]
fn stopping_lasts_until_it_is_released() {
    let mut bench = Bench::new(&slow());
    let moving = bench.order(MotionCommand::Velocity(Some(false)), 1000, usual());
    bench.until(500 * MS);
    assert_eq!(bench.axis.phase(moving), CommandPhase::InVelocity);
    let stop = bench.order(MotionCommand::Stop, 0, usual());
    assert_eq!(bench.axis.phase(moving), CommandPhase::Aborted);
    assert_eq!(bench.try_order(MotionCommand::By(5), 100, usual()), Err(AxisFault::StoppingActive));
    bench.settle();
    assert_eq!((bench.axis.phase(stop), bench.axis.state()), (CommandPhase::Done, AxisState::Stopping));
    bench.axis.release(stop);
    assert_eq!(bench.axis.state(), AxisState::Standstill);
    assert_eq!(bench.axis.position(), pulses(&bench));
}

// io:STD-PTO-10
#[test]
fn a_limit_stops_fast_and_lets_only_back() {
    let mut config = slow();
    config.limit_positive = switch(0);
    let mut bench = Bench::new(&config);
    let ticket = bench.order(MotionCommand::Velocity(Some(true)), 1000, usual());
    bench.until(500 * MS);
    bench.input(0, true);
    assert_eq!(bench.axis.phase(ticket), CommandPhase::Failed(AxisFault::LimitPositive));
    assert_eq!(bench.axis.acknowledge(), Ok(false), "it still moves");
    bench.settle();
    // 100 Hz a millisecond from 1000 Hz: 9 ms, and to the end of the last pulse.
    let last = bench.rises(0).last().copied().unwrap();
    assert!(last < 520 * MS, "{last}");
    assert_eq!(bench.axis.acknowledge(), Ok(true));
    assert_eq!(bench.try_order(MotionCommand::By(1), 100, usual()), Err(AxisFault::LimitPositive));
    bench.order(MotionCommand::By(-3), 100, usual());
    bench.settle();
    assert_eq!(bench.axis.position(), pulses(&bench));
    assert_eq!(bench.axis.state(), AxisState::Standstill);
}

// io:STD-PTO-10
#[test]
fn software_limits_hold_once_the_position_is_known() {
    let mut config = slow();
    config.software_limits = Some((-50, 50));
    let mut bench = Bench::new(&config);
    bench.order(MotionCommand::By(60), 1000, usual());
    bench.settle();
    assert_eq!(bench.axis.state(), AxisState::Standstill, "no limits yet");
    bench.axis.set_position(0).unwrap();
    bench.order(MotionCommand::To(50), 1000, usual());
    bench.settle();
    assert_eq!((bench.axis.state(), bench.axis.position()), (AxisState::Standstill, 50));
    assert_eq!(bench.try_order(MotionCommand::By(1), 100, usual()), Err(AxisFault::SoftwareLimitPositive));
    bench.order(MotionCommand::Velocity(Some(false)), 1000, usual());
    bench.settle();
    assert_eq!(bench.axis.fault(), Some(AxisFault::SoftwareLimitNegative));
    assert!((-60..=-50).contains(&bench.axis.position()), "{}", bench.axis.position());
}

// io:STD-PTO-10
#[test]
fn an_absolute_move_needs_a_known_position() {
    let mut bench = Bench::new(&slow());
    assert_eq!(bench.try_order(MotionCommand::To(5), 100, usual()), Err(AxisFault::NotHomed));
    bench.axis.set_position(3).unwrap();
    bench.order(MotionCommand::To(5), 100, usual());
    assert_eq!(bench.axis.set_position(9), Err(AxisFault::InvalidSetPosition));
    bench.settle();
    assert_eq!((bench.axis.position(), pulses(&bench)), (5, 2));
}

// io:STD-PTO-03
#[test]
fn a_drive_that_is_not_ready_is_an_error_of_the_axis() {
    let mut config = slow();
    (config.drive_ready, config.drive_enable) = (switch(3), Some(2));
    let mut bench = Bench::new(&config);
    bench.settle();
    assert_eq!((bench.axis.state(), bench.axis.powered()), (AxisState::Disabled, false));
    bench.input(3, true);
    assert_eq!((bench.axis.state(), bench.axis.powered()), (AxisState::Standstill, true));
    assert_eq!(bench.rises(2), [0]);
    bench.order(MotionCommand::By(500), 1000, usual());
    bench.after(150 * MS);
    bench.input(3, false);
    assert_eq!(bench.axis.fault(), Some(AxisFault::DriveNotReady));
    bench.settle();
    assert_eq!(bench.axis.acknowledge(), Err(AxisFault::DriveNotReady));
    bench.input(3, true);
    assert_eq!(bench.axis.acknowledge(), Ok(true));
}

fn give(bench: &mut Bench, order: MotionCommand, hertz: i64, mode: BufferMode) -> Result<u32, AxisFault> {
    let delay = Span::from_millis(50);
    bench.give(AxisCommand { order, velocity: hertz * HERTZ, ramps: usual(), mode, delay })
}

// io:STD-PTO-05
#[test]
fn commands_follow_each_other() {
    let mut bench = Bench::new(&slow());
    let first = give(&mut bench, MotionCommand::By(200), 1000, BufferMode::Buffered).unwrap();
    let second = give(&mut bench, MotionCommand::By(100), 1000, BufferMode::BufferedDelay).unwrap();
    assert_eq!(give(&mut bench, MotionCommand::By(1), 1000, BufferMode::Buffered), Err(AxisFault::QueueFull));
    assert_eq!(
        (bench.axis.phase(first), bench.axis.phase(second)),
        (CommandPhase::Active, CommandPhase::Waiting)
    );
    bench.settle();
    let rises = bench.rises(0);
    assert_eq!(rises.len(), 300);
    // The last pulse of the first ends a period of 100 Hz after its beginning, the next comes 50 ms later.
    let gap = rises[200] - rises[199];
    assert!((55 * MS..61 * MS).contains(&gap), "{gap}");
    assert_eq!((bench.axis.phase(first), bench.axis.phase(second)), (CommandPhase::Done, CommandPhase::Done));
}

// io:STD-PTO-05: the velocity at the end of the first move, from the periods around it
#[test]
fn blended_moves_do_not_stop() {
    for (mode, hertz) in [
        (BufferMode::BlendingLow, 500),
        (BufferMode::BlendingPrevious, 1000),
        (BufferMode::BlendingNext, 500),
        (BufferMode::BlendingHigh, 1000),
        // The last pulse on the way down to 100 Hz.
        (BufferMode::Buffered, 136),
    ] {
        let mut bench = Bench::new(&slow());
        bench.order(MotionCommand::By(400), 1000, usual());
        bench.until(200 * MS);
        give(&mut bench, MotionCommand::By(400), 500, mode).unwrap();
        bench.settle();
        let rises = bench.rises(0);
        assert_eq!(rises.len(), 800);
        let period = rises[400] - rises[399];
        let expected = S / hertz;
        assert!((period - expected).abs() <= expected / 7, "{mode:?}: {period}");
    }
}

// io:STD-PTO-08
#[test]
fn velocity_zero_holds_without_pulses() {
    let mut bench = Bench::new(&slow());
    bench.order(MotionCommand::Velocity(Some(true)), 1000, usual());
    bench.until(300 * MS);
    let zero = bench.order(MotionCommand::Velocity(Some(true)), 0, usual());
    bench.settle();
    assert_eq!(bench.axis.phase(zero), CommandPhase::InVelocity);
    assert_eq!((bench.axis.state(), bench.axis.velocity(bench.time())), (AxisState::ContinuousMotion, 0));
    // The other way.
    bench.order(MotionCommand::Velocity(Some(false)), 1000, usual());
    bench.after(300 * MS);
    assert_eq!(bench.axis.velocity(bench.time()), -1000);
    assert_eq!(bench.axis.position(), pulses(&bench));
}

// io:STD-PTO-02: the pulses into the play come before those that count
#[test]
fn play_is_taken_up_at_each_turn() {
    let mut config = slow();
    (config.output, config.backlash) = (PulseOutput::Quadrature, 7);
    let mut bench = Bench::new(&config);
    let mut emitted = 0;
    for (distance, extra) in [(20, 0), (20, 0), (-30, 7), (10, 7), (-1, 7)] {
        bench.order(MotionCommand::By(distance), 1000, usual());
        bench.settle();
        emitted += distance + extra * distance.signum();
        assert_eq!(bench.decoded(PulseOutput::Quadrature), emitted);
    }
    assert_eq!(bench.axis.position(), 19);
}

// io:STD-PTO-02: an interrupted way through the play is gone back
#[test]
fn play_that_is_half_taken_up_is_given_back() {
    let mut config = slow();
    (config.output, config.backlash) = (PulseOutput::Quadrature, 30);
    let mut bench = Bench::new(&config);
    bench.order(MotionCommand::By(20), 100, usual());
    bench.settle();
    bench.order(MotionCommand::By(-20), 100, usual());
    bench.after(110 * MS);
    bench.order(MotionCommand::Halt, 0, usual());
    bench.settle();
    assert_eq!(bench.axis.position(), 20, "within the play");
    bench.order(MotionCommand::By(5), 100, usual());
    bench.settle();
    assert_eq!((bench.axis.position(), bench.decoded(PulseOutput::Quadrature)), (25, 25));
}

// io:STD-PTO-05: where the first move is nearly over, the next one takes over as fast as it still is
#[test]
fn a_blend_that_comes_late_overruns_nothing() {
    let mut bench = Bench::new(&slow());
    bench.order(MotionCommand::By(400), 1000, usual());
    while bench.axis.position() < 398 {
        bench.events(1);
    }
    give(&mut bench, MotionCommand::By(10), 5, BufferMode::BlendingNext).unwrap();
    bench.settle();
    assert_eq!((bench.axis.position(), bench.rises(0).len()), (410, 410));
}

// io:STD-PTO-01: an output of pulses alone has no way back
#[test]
fn pulses_alone_never_go_back() {
    let mut config = slow();
    (config.output, config.b) = (PulseOutput::Pulse, None);
    let mut bench = Bench::new(&config);
    assert_eq!(bench.try_order(MotionCommand::By(-1), 100, usual()), Err(AxisFault::InvalidDirection));
    bench.order(MotionCommand::Velocity(Some(true)), 1000, usual());
    bench.after(300 * MS);
    let ticket = bench.order(MotionCommand::By(1), 1000, usual());
    bench.settle();
    assert_eq!(bench.axis.phase(ticket), CommandPhase::Failed(AxisFault::InvalidDirection));
    assert_eq!(bench.axis.position(), bench.rises(0).len() as i64);
}

// The velocity that plans observe, between pulses too.
#[test]
fn the_velocity_is_observed_from_the_last_change_on() {
    let mut bench = Bench::new(&slow());
    bench.order(MotionCommand::Velocity(Some(false)), 100, usual());
    bench.after(95 * MS);
    bench.order(MotionCommand::Velocity(Some(false)), 50, usual());
    assert_eq!(bench.axis.read(FunctionProbe::Velocity).and_then(Value::as_int), Some(-100));
    bench.after(100 * MS);
    assert_eq!(bench.axis.read(FunctionProbe::Velocity).and_then(Value::as_int), Some(-50));
    bench.order(MotionCommand::Halt, 0, usual());
    bench.settle();
    assert_eq!(bench.axis.read(FunctionProbe::Velocity).and_then(Value::as_int), Some(0));
}

// io:STD-PTO-14
#[test]
fn power_on_protected_outputs_is_an_error() {
    let mut bench = Bench::new(&slow());
    bench.with(|axis, now, fx| axis.power(now, false, fx));
    bench.with(|axis, now, fx| axis.protect(now, ChannelSet::of(1), fx));
    assert_eq!(bench.axis.state(), AxisState::Disabled);
    bench.with(|axis, now, fx| axis.power(now, true, fx));
    assert_eq!(bench.axis.fault(), Some(AxisFault::OutputProtection));
    // Without power a reset leads to Disabled, where no position is known.
    bench.with(|axis, now, fx| axis.power(now, false, fx));
    bench.with(|axis, now, fx| axis.protect(now, ChannelSet::EMPTY, fx));
    assert_eq!(bench.axis.acknowledge(), Ok(true));
    assert_eq!((bench.axis.state(), bench.axis.homed()), (AxisState::Disabled, false));
}
