//! Commands at any time: no pulse is lost, doubled or too short, and positions are what they should be.

use super::*;
use signal::Random;

fn between(random: &mut Random, low: i64, high: i64) -> i64 {
    low + random.below((high - low + 1) as u64) as i64
}

/// Numbers of every magnitude up to one.
fn magnitude(random: &mut Random, most: i64) -> i64 {
    let bits = between(random, 1, 63 - i64::from(most.leading_zeros()));
    between(random, 1, 1 << bits).min(most)
}

fn axis(random: &mut Random) -> AxisConfig {
    let mut config = AxisConfig::new(0, 1);
    config.output = match random.below(3) {
        0 => PulseOutput::PulseDirection,
        1 => PulseOutput::ClockwiseCounterclockwise,
        _ => PulseOutput::Quadrature,
    };
    if random.chance(700_000) {
        config.start_velocity = magnitude(random, 20_000) as u32;
    }
    if random.chance(700_000) {
        config.stop_velocity = magnitude(random, 20_000) as u32;
    }
    config
}

fn some_ramps(random: &mut Random) -> Ramps {
    let ratio = if random.chance(500_000) { 0 } else { between(random, 1, 100) as u8 };
    ramps(between(random, 2, 1000) as u32, between(random, 2, 1000) as u32, ratio)
}

fn sequence(seed: u64) {
    let mut random = Random::new(seed);
    let config = axis(&mut random);
    let mut bench = Bench::new(&config);
    bench.axis.set_position(0).unwrap();
    let mut fastest = 1;
    let mut given = Vec::new();
    for _ in 0..between(&mut random, 2, 8) {
        let hertz = magnitude(&mut random, 60_000);
        let order = match random.below(8) {
            0 | 1 => MotionCommand::To(between(&mut random, -300, 300)),
            2 | 3 => MotionCommand::By(between(&mut random, -200, 200)),
            4 | 5 => MotionCommand::Velocity(Some(random.chance(500_000))),
            6 => MotionCommand::Halt,
            _ => MotionCommand::Stop,
        };
        let mode = match random.below(4) {
            0 if order != MotionCommand::Stop => BufferMode::of(between(&mut random, 1, 5)).unwrap(),
            _ => BufferMode::Aborting,
        };
        let command = AxisCommand {
            order,
            velocity: hertz * HERTZ,
            ramps: some_ramps(&mut random),
            mode,
            delay: Span::ZERO,
        };
        match bench.give(command) {
            Ok(ticket) => given.push(ticket),
            Err(fault) => assert!(
                matches!(fault, AxisFault::StoppingActive | AxisFault::QueueFull),
                "{fault:?} in sequence {seed}"
            ),
        }
        fastest = fastest.max(hertz);
        if let (MotionCommand::Stop, Some(ticket)) = (order, given.last()) {
            bench.axis.release(*ticket);
        }
        // Some wait for a time within the first pulses, some for a few pulses, some for rest.
        match random.below(4) {
            0 => {}
            1 => bench.after(magnitude(&mut random, 1_000_000_000 / hertz)),
            2 => bench.events(random.below(400)),
            _ => bench.events(2000),
        }
    }
    let halt = bench.try_order(MotionCommand::Halt, 0, some_ramps(&mut random));
    if halt.is_err() {
        assert_eq!(bench.axis.state(), AxisState::Stopping);
    }
    bench.settle();
    assert_eq!(bench.axis.state(), AxisState::Standstill, "sequence {seed}");
    assert_eq!(bench.decoded(config.output), bench.axis.position(), "sequence {seed}");
    for ticket in given {
        let phase = bench.axis.phase(ticket);
        assert!(matches!(phase, CommandPhase::Done | CommandPhase::Aborted), "{phase:?} in sequence {seed}");
    }
    // An absolute move from wherever it is now ends where it should.
    let target = between(&mut random, -300, 300);
    let last = bench.order(MotionCommand::To(target), fastest, some_ramps(&mut random));
    bench.settle();
    assert_eq!(bench.axis.phase(last), CommandPhase::Done);
    assert_eq!((bench.axis.position(), bench.decoded(config.output)), (target, target), "sequence {seed}");
    assert_spacing(&bench, &config, fastest.max(20_000), seed);
}

/// No pulse is shorter than half the period of the highest velocity, none comes sooner than a period after the one
/// before, and none too soon after a change of direction.
fn assert_spacing(bench: &Bench, config: &AxisConfig, fastest: i64, seed: u64) {
    let period = S / fastest - 3;
    if config.output == PulseOutput::PulseDirection {
        let (mut a, mut b) = (false, false);
        let (mut rise, mut turn) = (i64::MIN / 2, i64::MIN / 2);
        for (at, next_a, next_b) in bench.waves() {
            if next_b != b {
                assert!(!a && !next_a, "a turn within a pulse at {at} in sequence {seed}");
                turn = at;
            } else if next_a && !a {
                assert!(at - rise >= period, "{} after {rise} in sequence {seed}", at - rise);
                assert!(at - turn >= 20_000, "{} after a turn in sequence {seed}", at - turn);
                rise = at;
            } else if a && !next_a {
                assert!(at - rise >= period / 2, "{} long at {rise} in sequence {seed}", at - rise);
            }
            (a, b) = (next_a, next_b);
        }
    }
    for output in [0, 1] {
        if config.output != PulseOutput::PulseDirection {
            for pair in bench.rises(output).windows(2) {
                // A direction that changes within the quadrature brings two edges of one line together.
                let least = if config.output == PulseOutput::Quadrature { period / 4 } else { period };
                assert!(pair[1] - pair[0] >= least, "{} in sequence {seed}", pair[1] - pair[0]);
            }
        }
    }
}

// io:STD-PTO-05, io:STD-PTO-06
#[test]
fn ten_thousand_sequences_lose_and_double_no_pulse() {
    for seed in 0..10_000 {
        sequence(seed);
    }
}
