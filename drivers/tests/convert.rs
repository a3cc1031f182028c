//! What a board of converters makes of what a converter does, without a device: quantities and when they came, calls
//! that hang or fail, a device that goes and comes back.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use crate::scripted::{INPUTS, Script};
use scanrig_drivers::adc::{AdcBoard, InRange};
use scanrig_drivers::{
    Board, BoardContext, BoardError, BoardEvent, ChannelId, LossReason, TimestampSource, build,
};
use signal::calendar::Date;
use signal::{Span, Time, Value, When};

const EIO: i32 = 5;
const ENODEV: i32 = 19;
/// Where nothing must be late or lost, however busy the machine is.
const SLOW: &str = "20 s";

struct Bench {
    board: AdcBoard,
    at: BoardContext,
    script: Arc<Script>,
    events: Vec<BoardEvent>,
}

impl Bench {
    fn new(unresponsive_after: &str, period: &str, reconnect: bool, more: &str) -> Bench {
        let script = Arc::new(Script::default());
        let (board, at) = crate::scripted::board(
            &crate::scripted::file(unresponsive_after, period, reconnect, more),
            &script,
        );
        Bench { board, at, script, events: Vec::new() }
    }

    fn started(unresponsive_after: &str, period: &str, reconnect: bool, more: &str) -> Bench {
        let mut bench = Bench::new(unresponsive_after, period, reconnect, more);
        bench.start().unwrap();
        bench
    }

    fn start(&mut self) -> Result<(), BoardError> {
        self.at.time.restart();
        self.board.start(Time::ZERO)?;
        self.poll();
        // A busy machine misses readings from the start on, which is reported.
        self.events.retain(|event| !matches!(event, BoardEvent::Dropped { .. }));
        assert_eq!(self.events.len(), INPUTS, "the first value of every channel: {:?}", self.events);
        assert!(self.events.iter().all(|event| event.latest() == Time::ZERO), "{:?}", self.events);
        Ok(())
    }

    fn poll(&mut self) {
        self.board.poll(self.at.time.now(), &mut self.events).unwrap();
    }

    /// Polls until this is so.
    fn until(&mut self, what: &str, holds: impl Fn(&Bench) -> bool) {
        let due = Instant::now() + Duration::from_secs(20);
        self.poll();
        while !holds(self) {
            assert!(Instant::now() < due, "never: {what}; {:?} {:?}", self.board.health(), self.events);
            let next = self.at.time.now() + Span::from_millis(5);
            let next = self.board.next_event().map_or(next, |at| at.min(next));
            self.at.bell.wait_until(self.at.time.stamp(next));
            self.poll();
        }
    }

    fn changes(&self, channel: u16) -> Vec<(When, Value)> {
        let of = |event: &BoardEvent| match *event {
            BoardEvent::Changed { channel: other, at, value, .. } if other == ChannelId(channel) => {
                Some((at, value))
            }
            _ => None,
        };
        self.events.iter().filter_map(of).collect()
    }

    fn last(&self, channel: u16) -> Option<Value> {
        self.changes(channel).last().map(|(_, value)| *value)
    }

    /// Losses and returns of a channel, in order.
    fn fate(&self, channel: u16) -> Vec<Option<LossReason>> {
        let of = |event: &BoardEvent| match *event {
            BoardEvent::Lost { channel: other, reason, .. } if other == ChannelId(channel) => {
                Some(Some(reason))
            }
            BoardEvent::Returned { channel: other, .. } if other == ChannelId(channel) => Some(None),
            _ => None,
        };
        self.events.iter().filter_map(of).collect()
    }
}

#[test]
fn a_change_lies_between_the_sample_before_and_the_one_that_shows_it() {
    let mut bench = Bench::started("10 s", "1 ms", false, "");
    assert_eq!(bench.last(2), Some(Value::Real(0.0)));
    let before = bench.at.time.now();
    bench.script.show(2, 3.25);
    let after = bench.at.time.now();
    bench.until("a change", |bench| bench.last(2) == Some(Value::Real(3.25)));
    let (at, _) = bench.changes(2)[1];
    assert!(at.earliest <= after && before <= at.latest, "{before} {after} {at:?}");
    assert_eq!(
        (bench.changes(0).len(), bench.changes(2).len()),
        (1, 2),
        "what does not change is reported once"
    );
}

#[test]
fn a_channel_says_how_well_it_sees() {
    let bench = Bench::new("10 s", "5 ms", false, "");
    let channel = &bench.board.channels()[1];
    let apart = Span::from_millis(10);
    assert_eq!(channel.timestamp, TimestampSource::Sampled { period: apart });
    assert_eq!((channel.shortest_pulse, channel.drives, channel.senses), (apart, false, true));
    // On paper it is the same.
    let file = crate::scripted::file("10 s", "5 ms", false, "");
    assert_eq!(build(&file, 0).unwrap().channels(), bench.board.channels());
}

#[test]
fn only_what_moves_beyond_the_deadband_is_told() {
    let mut bench = Bench::started("10 s", "1 ms", false, ", deadband = 0.5");
    assert_eq!(bench.board.channels()[1].deadband, 0.5, "judges have to know");
    for value in [0.5, 0.4, 0.6] {
        bench.script.show(1, value);
        let reads = bench.script.reads.load(Ordering::Acquire);
        bench.until("two more readings", |bench| bench.script.reads.load(Ordering::Acquire) >= reads + 2);
    }
    bench.until("the change", |bench| bench.last(1) == Some(Value::Real(0.6)));
    assert_eq!(bench.changes(1).len(), 2, "{:?}", bench.events);
}

#[test]
fn what_is_beyond_its_range_or_behind_an_open_wire_is_not_known() {
    let mut bench = Bench::started(
        "10 s",
        "1 ms",
        false,
        ", scale = { shunt = 250, from = [\"4 mA\", \"20 mA\"], to = [0, 16] }, open-below = \"3.6 mA\", short-above = \"21 mA\"",
    );
    // Nothing flows yet.
    assert_eq!(bench.last(1), Some(Value::Unknown));
    for (volts, shown) in
        [(1.0, Value::Real(0.0)), (0.8, Value::Unknown), (5.0, Value::Real(16.0)), (5.3, Value::Unknown)]
    {
        bench.script.show(1, volts);
        bench.until("the value", |bench| bench.last(1) == Some(shown));
    }
    bench.script.clip(0, InRange::Above);
    bench.until("the end of the range", |bench| bench.last(0) == Some(Value::Unknown));
    bench.script.show(0, 1.5);
    bench.until("the value again", |bench| bench.last(0) == Some(Value::Real(1.5)));
}

#[test]
fn a_call_that_hangs_is_a_device_that_is_silent_until_it_answers() {
    let mut bench = Bench::started("50 ms", "1 ms", false, "");
    bench.script.show(3, 2.0);
    bench.script.shut(true);
    bench.until("a call that hangs", |bench| bench.script.waiting.load(Ordering::Acquire));
    bench.until("the loss", |bench| (0..4).all(|of| bench.fate(of) == [Some(LossReason::Unresponsive)]));
    assert_eq!(bench.board.health().lost, INPUTS as u32);
    bench.script.shut(false);
    bench.until("the return", |bench| {
        (0..4).all(|of| bench.fate(of) == [Some(LossReason::Unresponsive), None])
    });
    assert_eq!(bench.last(3), Some(Value::Real(2.0)));
    assert_eq!(
        (bench.board.health().lost, bench.board.health().is_sound()),
        (0, false),
        "it was away too long"
    );
}

#[test]
fn one_call_that_fails_is_counted_and_calls_that_go_on_to_fail_are_a_loss() {
    let mut bench = Bench::started(SLOW, "1 ms", false, "");
    bench.script.error.store(EIO, Ordering::Release);
    bench.until("failed calls", |bench| bench.board.health().failed_calls > 0);
    bench.script.error.store(0, Ordering::Release);
    bench.script.show(0, 1.0);
    bench.until("a value", |bench| bench.last(0) == Some(Value::Real(1.0)));
    assert_eq!(bench.fate(0), []);
    let mut bench = Bench::started("30 ms", "1 ms", false, "");
    bench.script.error.store(EIO, Ordering::Release);
    bench.until("the loss", |bench| (0..4).all(|of| bench.fate(of).contains(&Some(LossReason::Gone))));
}

#[test]
fn a_device_that_is_gone_is_taken_back_where_the_file_says_so() {
    let mut bench = Bench::started("20 ms", "1 ms", true, "");
    bench.script.error.store(ENODEV, Ordering::Release);
    bench.until("the loss", |bench| (0..4).all(|of| bench.fate(of).last() == Some(&Some(LossReason::Gone))));
    bench.script.show(0, 4.5);
    bench.script.error.store(0, Ordering::Release);
    bench.script.there.store(true, Ordering::Release);
    bench.until("the return", |bench| (0..4).all(|of| bench.fate(of).last() == Some(&None)));
    bench.until("its values", |bench| bench.last(0) == Some(Value::Real(4.5)));
    let returned =
        bench.events.iter().rposition(|event| matches!(event, BoardEvent::Returned { .. })).unwrap();
    for channel in 0..4 {
        let told = |event: &BoardEvent| {
            matches!(event, BoardEvent::Changed { .. }) && event.channel() == ChannelId(channel)
        };
        bench.until("every value", |bench| bench.events.iter().skip(returned).any(told));
    }
}

#[test]
fn a_device_that_is_gone_stays_lost_where_the_file_does_not_say_so() {
    let mut bench = Bench::started("20 ms", "1 ms", false, "");
    bench.script.there.store(true, Ordering::Release);
    bench.script.error.store(ENODEV, Ordering::Release);
    bench.until("the loss", |bench| bench.fate(0).last() == Some(&Some(LossReason::Gone)));
    bench.script.error.store(0, Ordering::Release);
    bench.board.safe(bench.at.time.now()).unwrap();
    assert!(matches!(bench.start(), Err(BoardError::Lost { reason: LossReason::Gone, .. })));
}

#[test]
fn a_run_begins_with_what_is_there_and_forgets_the_trouble_before() {
    let mut bench = Bench::started("50 ms", "1 ms", false, "");
    bench.script.error.store(EIO, Ordering::Release);
    bench.until("failed calls", |bench| bench.board.health().failed_calls > 0);
    bench.board.safe(bench.at.time.now()).unwrap();
    bench.script.error.store(0, Ordering::Release);
    bench.script.show(1, 7.0);
    bench.events.clear();
    bench.start().unwrap();
    assert_eq!(bench.last(1), Some(Value::Real(7.0)));
    assert!(bench.board.health().is_sound(), "{:?}", bench.board.health());
    assert!(!bench.board.health().latched_safe);
}

#[test]
fn readings_that_come_too_late_are_told_as_lost() {
    let mut bench = Bench::started(SLOW, "5 ms", false, "");
    bench.script.shut(true);
    bench.until("a call that hangs", |bench| bench.script.waiting.load(Ordering::Acquire));
    let asleep = bench.at.time.now();
    while bench.at.time.now() - asleep < Span::from_millis(50) {
        bench.at.bell.wait_until(bench.at.time.stamp(asleep + Span::from_millis(50)));
    }
    bench.script.shut(false);
    let dropped = |bench: &Bench, of| {
        let count = |event: &BoardEvent| match event {
            BoardEvent::Dropped { channel, count, .. } if *channel == ChannelId(of) => *count,
            _ => 0,
        };
        bench.events.iter().map(count).sum::<u32>()
    };
    bench.until("the loss", |bench| (0..4).all(|of| dropped(bench, of) >= 4));
    assert_eq!(bench.fate(0), [], "it is slow, but there");
}

#[test]
fn a_board_of_converters_drives_nothing() {
    let mut bench = Bench::new("10 s", "1 ms", false, "");
    assert_eq!(bench.board.write(Time::ZERO, &[]), Err(BoardError::NotStarted));
    assert_eq!(bench.board.next_event(), None);
    bench.start().unwrap();
    let now = bench.at.time.now();
    let write = |board: &mut AdcBoard, channel| board.write(now, &[(ChannelId(channel), Value::Real(1.0))]);
    assert_eq!(write(&mut bench.board, 0), Err(BoardError::NotDriven(ChannelId(0))));
    assert_eq!(write(&mut bench.board, 99), Err(BoardError::NoChannel(ChannelId(99))));
    bench.board.safe(now).unwrap();
    assert!(bench.board.health().latched_safe);
}

#[test]
fn a_calibration_stands_in_the_record_and_is_warned_of_behind_its_last_day() {
    let more = ", calibration = { points = [[0, 0.1], [5, 5.1]], date = \"2026-01-31\", expires = \"2027-01-31\", \
                by = \"the laboratory\", certificate = \"K 77\" }";
    let file = crate::scripted::file("1 s", "1 ms", false, more);
    let on = |day: &str| file.calibrated(Date::parse(day).unwrap());
    let [sound] = &on("2027-01-31")[..] else { panic!() };
    let words = "calibrated 2026-01-31 by the laboratory, certificate K 77, until 2027-01-31";
    assert_eq!((sound.channel.as_str(), sound.words.as_str(), &sound.expired), ("a1", words, &None));
    let [expired] = &on("2027-02-01")[..] else { panic!() };
    assert_eq!(expired.words, format!("{words}: expired"));
    assert_eq!(expired.expired.as_ref().unwrap().code, "B0125");
    let script = Arc::new(Script::default());
    script.show(1, 2.0);
    let (board, at) = crate::scripted::board(&file, &script);
    let mut bench = Bench { board, at, script, events: Vec::new() };
    bench.start().unwrap();
    assert!(matches!(bench.last(1), Some(Value::Real(volts)) if (volts - 2.1).abs() < 1e-12));
}
