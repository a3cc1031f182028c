//! What is counted: fast, both ways, over the ceiling, by GPIO lines.

use super::bench::{Bench, PATIENT, file};
use devices::{Counter, Lab, MAIN};
use drivers::TimestampSource;
use signal::{Span, Value};
use std::time::Instant;

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn two_hundred_thousand_and_a_million_a_second_are_counted_exactly() {
    let mut bench = Bench::started(&file(PATIENT, "period = \"5 ms\""));
    let wheel = bench.counter.count(0);
    let mut total = 0;
    for (steps, rate) in [(100_000, 200_000), (-30_000, 200_000), (300_000, 1_000_000)] {
        let began = Instant::now();
        wheel.steps_at(steps, rate);
        total += steps;
        bench.counts(total);
        println!("figure: {steps} steps at {rate}/s counted in {:?}", began.elapsed());
    }
    assert_eq!((bench.dropped(), bench.board.health().is_sound()), (0, true), "{:?}", bench.events);
    let changes = bench.changes();
    assert!(changes.len() > 10, "seen on its way: {}", changes.len());
    for pair in changes.windows(2) {
        assert!(pair[0].0.earliest <= pair[1].0.earliest && pair[1].0.earliest <= pair[1].0.latest);
    }
    let channel = &bench.board.channels()[0];
    assert_eq!(channel.timestamp, TimestampSource::Sampled { period: Span::from_millis(5) });
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn each_run_begins_at_0_wherever_the_device_stands() {
    let mut bench = Bench::started(&file(PATIENT, "period = \"2 ms\", function = \"quadrature-x4\""));
    let wheel = bench.counter.count(0);
    wheel.steps(-5);
    bench.counts(-5);
    wheel.steps(17);
    bench.counts(12);
    bench.start();
    assert_eq!(bench.last(), Some(0));
    wheel.steps(-12);
    bench.counts(-12);
    assert_eq!(wheel.says("count"), "0");
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_small_ceiling_is_followed_both_ways_by_readings_and_by_events() {
    // By readings alone: half the range takes a second.
    let slow = "period = \"5 ms\", ceiling = 9999, counts-up-to = \"5 kHz\"";
    let mut bench = Bench::started(&file(PATIENT, slow));
    let wheel = bench.counter.count(0);
    wheel.set("count", "9990");
    bench.start();
    wheel.steps_at(40, 200);
    bench.counts(40);
    wheel.steps_at(-60, 200);
    bench.counts(-20);
    assert_eq!(bench.dropped(), 0, "{:?}", bench.changes());
    let Bench { board, counter, lab, .. } = bench;
    drop(board);
    // By events: many turns between two readings.
    let fast = "period = \"20 ms\", ceiling = 999, events = [\"overflow\", \"underflow\"]";
    let mut bench = Bench::on(&file(PATIENT, fast), counter, lab);
    wheel.steps_at(100_000, 200_000);
    bench.counts(100_000);
    wheel.steps_at(-250_500, 200_000);
    bench.counts(-150_500);
    assert_eq!(bench.dropped(), 0, "{:?}", bench.events);
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn every_count_has_the_kernels_stamp_where_it_is_asked_for() {
    let of = "period = \"20 ms\", function = \"increase\", edge = \"rising\", events = [\"change-of-state\"]";
    let mut bench = Bench::started(&file(PATIENT, of));
    assert_eq!(bench.board.channels()[0].timestamp, TimestampSource::Kernel);
    bench.counter.count(0).steps_at(50, 200);
    bench.counts(50);
    let changes = bench.changes();
    let counts: Vec<Value> = changes.iter().map(|(_, value)| *value).collect();
    assert_eq!(counts, (0..=50).map(Value::Int).collect::<Vec<_>>());
    // Of a reading between a count and its event the instant is less certain; of most there is none.
    let exact = changes.iter().filter(|(at, _)| at.earliest == at.latest).count();
    assert!(exact > 40, "{exact} of 50: {changes:?}");
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn lines_of_a_chip_turn_the_wheel() {
    let lab = Lab::enter();
    let counter = Counter::enter();
    counter.count(0).lines(MAIN, &[8, 9]);
    let of = "period = \"2 ms\", function = \"quadrature-x4\"";
    let mut bench = Bench::on(&file(PATIENT, of), counter, lab);
    let turn = |order: [(u32, bool); 4]| order.iter().for_each(|(line, level)| MAIN.line(*line).pull(*level));
    let forward = [(8, true), (9, true), (8, false), (9, false)];
    let back = [(9, true), (8, true), (9, false), (8, false)];
    (0..25).for_each(|_| turn(forward));
    bench.counts(100);
    (0..40).for_each(|_| turn(back));
    bench.counts(-60);
    assert_eq!(bench.dropped(), 0, "{:?}", bench.events);
}
