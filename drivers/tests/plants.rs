//! The lag in closed form against an integration in small steps, and its switches.

use crate::common::*;
use proptest::prelude::*;
use scanrig_drivers::circuit::{ChannelSpec, Circuit, CircuitFault, Pull};
use scanrig_drivers::plant::{LagSpec, LagTarget, SwitchSpec};
use scanrig_drivers::{Board, SimulatedBoard};
use signal::{Span, Value};
use std::sync::Arc;

const MS: i64 = 1_000_000;

/// Q0 heats `temp` (channel 1) from 20 to 100 with 2 s; I0 (channel 2) is on above 60, off below 55.
fn oven() -> Circuit {
    oven_with(|_| {})
}

/// The oven with its lag changed.
fn oven_with(change: impl FnOnce(&mut LagSpec)) -> Circuit {
    let mut circuit = Circuit::default();
    circuit.channels.push(ChannelSpec::digital("Q0", Pull::None));
    circuit.channels.push(ChannelSpec::analog("temp", "degC"));
    circuit.channels.push(ChannelSpec::digital("I0", Pull::Down));
    let mut lag = LagSpec {
        name: "oven".into(),
        input: id(0),
        output: id(1),
        unit: "degC".into(),
        target: LagTarget::Levels { low: 20.0, high: 100.0 },
        initial: 20.0,
        tau: Span::from_secs(2),
        sample: Span::from_millis(10),
        switches: vec![SwitchSpec { channel: id(2), on_above: 60.0, off_below: 55.0 }],
    };
    change(&mut lag);
    circuit.plants.push(Arc::new(lag));
    circuit
}

#[test]
fn the_thermostat_switches_at_the_computed_nanosecond() {
    let mut board = started(&oven(), 0);
    assert_eq!(board.next_event(), None, "at rest nothing is sampled");
    board.write(at(5 * MS), &[(id(0), ON)]).unwrap();
    let events = poll(&mut board, 3_000 * MS);
    // 60 = 100 - 80 exp(-t / 2 s) at t = 2 s ln 2 = 1.386294361119890... s, rounded up.
    assert_eq!(changes(&events, 2), [(5 * MS + 1_386_294_362, ON)]);
    board.write(at(3_000 * MS), &[(id(0), OFF)]).unwrap();
    let y0 = 100.0 - 80.0 * f64::exp(-2.995 / 2.0);
    let down = (2e9 * f64::ln((y0 - 20.0) / 35.0)).ceil() as i64;
    let events = poll(&mut board, 9_000 * MS);
    let off = changes(&events, 2);
    assert_eq!(off.len(), 1);
    assert!((off[0].0 - 3_000 * MS - down).abs() <= 1, "{off:?} {down}");
    assert_eq!(off[0].1, OFF);
}

#[test]
fn samples_lie_on_their_grid_and_end_when_the_value_is_there() {
    let mut board = started(&oven(), 0);
    board.write(at(3 * MS), &[(id(0), ON)]).unwrap();
    let events = poll(&mut board, 200_000 * MS);
    let samples = changes(&events, 1);
    assert_eq!(samples[0].0, 10 * MS);
    assert!(samples.iter().all(|(time, _)| time % (10 * MS) == 0));
    assert_eq!(samples.last().unwrap().1, Value::Real(100.0));
    assert_eq!(board.next_event(), None);
}

#[test]
fn a_write_overrides_the_plant_until_it_is_let_go() {
    let mut board = started(&oven(), 0);
    board.write(at(MS), &[(id(1), Value::Real(500.0))]).unwrap();
    assert_eq!(board.value(id(1)), Some(Value::Real(500.0)));
    board.write(at(2 * MS), &[(id(1), Value::HighZ)]).unwrap();
    assert_eq!(board.value(id(1)), Some(Value::Real(20.0)));
}

#[test]
fn a_start_beyond_a_threshold_is_on_from_the_start() {
    let circuit = oven_with(|lag| lag.initial = 80.0);
    let mut board = SimulatedBoard::new(&circuit, 0).unwrap();
    board.start(at(0)).unwrap();
    let events = poll(&mut board, 10_000 * MS);
    let edges = changes(&events, 2);
    assert_eq!(edges[0], (0, ON));
    // It cools from 80 to 20 by itself: 55 = 20 + 60 exp(-t / 2 s).
    assert_eq!(edges[1], ((2e9 * f64::ln(60.0 / 35.0)).ceil() as i64, OFF));
    assert_eq!(edges.len(), 2);
}

#[test]
fn an_analog_input_sets_the_target() {
    let mut circuit = oven_with(|lag| {
        lag.target = LagTarget::Linear { offset: 10.0, gain: 3.0 };
        lag.initial = 10.0;
    });
    circuit.channels[0] = ChannelSpec::analog("set", "V");
    let mut board = started(&circuit, 0);
    board.write(at(0), &[(id(0), Value::Real(2.0))]).unwrap();
    poll(&mut board, 200_000 * MS);
    assert_eq!(board.value(id(1)), Some(Value::Real(16.0)));
}

#[test]
fn bad_plants_are_refused() {
    let fault = |change: fn(&mut LagSpec)| oven_with(change).check().first().map(|error| error.fault);
    assert_eq!(fault(|_| {}), None);
    assert_eq!(fault(|lag| lag.tau = Span::ZERO), Some(CircuitFault::BadTime));
    assert_eq!(fault(|lag| lag.initial = f64::NAN), Some(CircuitFault::NotFinite));
    assert_eq!(fault(|lag| lag.output = id(2)), Some(CircuitFault::NotAnalog(id(2))));
    assert_eq!(fault(|lag| lag.input = id(1)), Some(CircuitFault::NotDigital(id(1))));
    assert_eq!(fault(|lag| lag.switches[0].on_above = 55.0), Some(CircuitFault::NoHysteresis));
    assert_eq!(fault(|lag| lag.switches[0].channel = id(1)), Some(CircuitFault::NotDigital(id(1))));
    let mut twice = oven();
    twice.plants.push(twice.plants[0].clone());
    assert_eq!(twice.check().first().map(|error| error.fault), Some(CircuitFault::TwoSources(id(1))));
}

proptest! {
    /// Against Euler's method in steps of 20 us: the closed form is that of the differential equation, whatever
    /// the input does.
    #[test]
    fn the_closed_form_solves_the_equation(
        gaps in proptest::collection::vec(1i64..300, 1..12),
        tau in 20i64..400,
    ) {
        let circuit = oven_with(|lag| {
            lag.tau = Span::from_millis(tau);
            lag.sample = Span::from_millis(1);
        });
        let mut board = started(&circuit, 0);
        let (mut events, mut now, mut level) = (Vec::new(), 0, false);
        let mut inputs = Vec::new();
        for gap in gaps {
            now += gap * MS;
            level = !level;
            inputs.push((now, level));
            board.write(at(now), &[(id(0), Value::Bool(level))]).unwrap();
        }
        let end = now + 300 * MS;
        events.extend(poll(&mut board, end));
        let samples = changes(&events, 1);
        let (mut y, mut target, mut next) = (20.0f64, 20.0, inputs.iter().peekable());
        let (mut sample, mut on, mut crossings) = (samples.iter().peekable(), false, Vec::new());
        let step = 20_000;
        for instant in (0..end).step_by(step) {
            while let Some((_, level)) = next.next_if(|(time, _)| *time <= instant) {
                target = if *level { 100.0 } else { 20.0 };
            }
            while let Some((_, value)) = sample.next_if(|(time, _)| *time <= instant) {
                let value = value.as_real().unwrap();
                prop_assert!((value - y).abs() < 0.2, "at {instant}: {value} {y}");
            }
            y += (target - y) * step as f64 / (tau as f64 * MS as f64);
            if (!on && y >= 60.0) || (on && y <= 55.0) {
                on = !on;
                crossings.push((instant, on));
            }
        }
        let switched = changes(&events, 2);
        // A peak that only just meets a threshold may be missed by the coarse steps: compare where both agree.
        if switched.len() == crossings.len() {
            for ((time, value), (about, on)) in switched.iter().zip(&crossings) {
                prop_assert_eq!(*value, Value::Bool(*on));
                prop_assert!((time - about).abs() < 3 * MS, "{time} {about}");
            }
        } else {
            prop_assert!(switched.len().abs_diff(crossings.len()) <= 2);
        }
        prop_assert!(switched.windows(2).all(|pair| pair[0].1 != pair[1].1));
    }

    /// The trace does not depend on how the time is cut.
    #[test]
    fn plants_do_not_depend_on_polls(cuts in proptest::collection::vec(1i64..50_000_000, 0..40)) {
        let run = |cuts: &[i64]| {
            let mut board = started(&oven(), 0);
            board.write(at(MS), &[(id(0), ON)]).unwrap();
            let (mut events, mut now) = (Vec::new(), MS);
            for cut in cuts {
                now += cut;
                events.extend(poll(&mut board, now));
            }
            events.extend(poll(&mut board, 5_000 * MS));
            events
        };
        prop_assert_eq!(run(&[]), run(&cuts));
    }
}
