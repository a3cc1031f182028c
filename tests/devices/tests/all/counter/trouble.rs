//! Counters that hang, go away and come back, or report more than anybody takes.

use super::bench::{Bench, PATIENT, file};
use drivers::{BoardError, LossReason};
use signal::Time;
use std::time::Duration;

/// Long enough that an emulated machine is not taken for a device that hangs, short enough for a test.
const SOON: &str = "unresponsive-after = \"400 ms\"";

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_reading_that_hangs_is_reported_and_nothing_is_miscounted() {
    let mut bench = Bench::started(&file("unresponsive-after = \"300 ms\"", "period = \"5 ms\""));
    let wheel = bench.counter.count(0);
    wheel.stall(Duration::from_millis(1_500), 1);
    bench.until("the loss", |bench| bench.fate().contains(&Some(LossReason::Unresponsive)));
    assert_eq!(wheel.inside(), 1, "the call hangs");
    wheel.steps(250);
    bench.until("the return", |bench| bench.fate().last() == Some(&None));
    bench.counts(250);
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_counter_that_goes_away_is_taken_back_and_counts_on() {
    let mut bench = Bench::started(&file(&format!("reconnect = true\n{SOON}"), "period = \"5 ms\""));
    let wheel = bench.counter.count(0);
    wheel.steps(100);
    bench.counts(100);
    bench.counter.unbind();
    bench.until("the loss", |bench| bench.fate().last() == Some(&Some(LossReason::Gone)));
    assert_eq!(bench.board.health().lost, 1);
    bench.counter.bind();
    bench.until("the return", |bench| bench.fate().last() == Some(&None));
    assert_eq!(bench.last(), Some(100), "what was counted meanwhile nobody knows");
    wheel.steps(11);
    bench.counts(111);
    bench.start();
    assert_eq!(bench.board.health().lost, 0);
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_counter_that_goes_away_stays_lost_where_nobody_wants_it_back() {
    let mut bench = Bench::started(&file(SOON, "period = \"5 ms\""));
    bench.counter.unbind();
    bench.until("the loss", |bench| bench.fate().last() == Some(&Some(LossReason::Gone)));
    bench.counter.bind();
    bench.board.safe(bench.at.time.now()).unwrap();
    let error = bench.board.start(Time::ZERO).unwrap_err();
    assert!(matches!(error, BoardError::Lost { reason: LossReason::Gone, .. }), "{error:?}");
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn events_that_find_the_kernels_queue_full_are_reported_as_lost() {
    let of = "period = \"5 ms\", events = [\"change-of-state\"], buffer = 64";
    let mut bench = Bench::started(&file(PATIENT, of));
    // All at once: nobody can take them in time.
    bench.counter.count(0).steps(10_000);
    bench.until("the loss", |bench| bench.dropped() > 0);
    // Readings report what events did not.
    bench.counts(10_000);
    assert!(!bench.board.health().is_sound());
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_count_faster_than_promised_is_reported_as_a_loss() {
    let mut bench =
        Bench::started(&file(PATIENT, "period = \"5 ms\", counts-up-to = \"20 kHz\", ceiling = 9999999"));
    bench.counter.count(0).steps_at(300, 300);
    bench.counts(300);
    assert_eq!(bench.dropped(), 0, "{:?}", bench.events);
    bench.counter.count(0).steps(1_000_000);
    bench.counts(1_000_300);
    assert!(bench.dropped() >= 1, "{:?}", bench.changes().len());
}
