//! What a board of counters makes of what a counter does, without a device: how far it has counted and when, calls that
//! hang or fail, a device that goes and comes back.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use crate::scripted_counter::{Script, board, file};
use scanrig_drivers::counter::CounterBoard;
use scanrig_drivers::{
    Board, BoardContext, BoardError, BoardEvent, ChannelId, ChannelKind, LossReason, TimestampSource,
};
use signal::{Span, Time, Value, When};

const EIO: i32 = 5;
const ENODEV: i32 = 19;
/// Where nothing must be late or lost, however busy the machine is.
const SLOW: &str = "20 s";

struct Bench {
    board: CounterBoard,
    at: BoardContext,
    script: Arc<Script>,
    events: Vec<BoardEvent>,
}

impl Bench {
    fn started(unresponsive_after: &str, reconnect: bool) -> Bench {
        let script = Arc::new(Script::default());
        script.value.store(4_000_000_000, Ordering::Release);
        let (board, at) = board(&file(unresponsive_after, "200 us", reconnect), &script);
        let mut bench = Bench { board, at, script, events: Vec::new() };
        bench.start().unwrap();
        bench
    }

    fn start(&mut self) -> Result<(), BoardError> {
        self.at.time.restart();
        self.events.clear();
        self.board.start(Time::ZERO)?;
        self.poll();
        let at = When::exactly(Time::ZERO);
        assert_eq!(self.changes().first(), Some(&(at, Value::Int(0))));
        Ok(())
    }

    fn poll(&mut self) {
        self.board.poll(self.at.time.now(), &mut self.events).unwrap();
    }

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

    fn moves(&self, by: i64) {
        let value = self.script.value.load(Ordering::Acquire) as i64 + by;
        self.script.value.store(value.rem_euclid(1 << 32) as u64, Ordering::Release);
    }

    fn counts(&mut self, total: i64) {
        self.until("a count", |bench| bench.changes().last().map(|last| last.1) == Some(Value::Int(total)));
    }

    fn changes(&self) -> Vec<(When, Value)> {
        let of = |event: &BoardEvent| match *event {
            BoardEvent::Changed { at, value, .. } => Some((at, value)),
            _ => None,
        };
        self.events.iter().filter_map(of).collect()
    }

    fn fate(&self) -> Option<Option<LossReason>> {
        self.events.iter().rev().find_map(|event| match *event {
            BoardEvent::Lost { reason, .. } => Some(Some(reason)),
            BoardEvent::Returned { .. } => Some(None),
            _ => None,
        })
    }
}

#[test]
fn a_channel_tells_how_far_it_has_counted_over_every_wrap() {
    let mut bench = Bench::started(SLOW, false);
    let channel = bench.board.channels()[0].clone();
    assert_eq!((channel.kind, channel.drives, channel.senses), (ChannelKind::Count, false, true));
    assert_eq!(channel.timestamp, TimestampSource::Sampled { period: Span::from_micros(200) });
    assert!(channel.shortest_pulse > Span::from_secs(20));
    let mut total = 0;
    for by in [300_000_000, 7, -300_000_100, 2_000_000_000, 2_000_000_000] {
        bench.moves(by);
        total += by;
        bench.counts(total);
    }
    let changes = bench.changes();
    assert_eq!(changes.len(), 6, "each movement is told once: {changes:?}");
    assert!(changes.iter().all(|(at, _)| at.earliest <= at.latest));
    assert!(changes.is_sorted_by_key(|(at, _)| at.latest));
    assert!(bench.board.health().is_sound());
    let refused = bench.board.write(bench.at.time.now(), &[(ChannelId(0), Value::Int(1))]);
    assert_eq!(refused, Err(BoardError::NotDriven(ChannelId(0))));
    bench.start().unwrap();
    bench.moves(-1);
    bench.counts(-1);
}

#[test]
fn a_call_that_hangs_is_told_and_survived() {
    let mut bench = Bench::started("100 ms", false);
    bench.script.shut(true);
    bench.until("the loss", |bench| bench.fate() == Some(Some(LossReason::Unresponsive)));
    bench.moves(9);
    bench.script.shut(false);
    bench.until("the return", |bench| bench.fate() == Some(None));
    bench.counts(9);
    assert_eq!(bench.board.health().lost, 0);
}

#[test]
fn a_device_that_was_gone_goes_on_from_what_was_told() {
    let mut bench = Bench::started("50 ms", true);
    bench.moves(20);
    bench.counts(20);
    bench.script.error.store(ENODEV, Ordering::Release);
    bench.until("the loss", |bench| bench.fate() == Some(Some(LossReason::Gone)));
    assert_eq!((bench.board.health().lost, bench.board.health().failed_calls), (1, 1));
    bench.moves(500);
    bench.script.error.store(0, Ordering::Release);
    bench.script.there.store(true, Ordering::Release);
    bench.until("the return", |bench| bench.fate() == Some(None));
    bench.moves(1);
    bench.until("a count", |bench| {
        let last = bench.changes().last().map(|last| last.1);
        // It may have been opened before or after this last step.
        [Value::Int(20), Value::Int(21)].map(Some).contains(&last)
    });
}

#[test]
fn calls_that_go_on_to_fail_are_a_loss() {
    let mut bench = Bench::started("50 ms", false);
    bench.script.error.store(EIO, Ordering::Release);
    bench.until("the loss", |bench| bench.fate() == Some(Some(LossReason::Gone)));
    assert!(bench.board.health().failed_calls > 1);
    bench.board.safe(bench.at.time.now()).unwrap();
    let error = bench.board.start(Time::ZERO).unwrap_err();
    assert!(matches!(error, BoardError::Lost { reason: LossReason::Gone, .. }), "{error:?}");
}

#[test]
fn a_full_queue_of_events_is_told_as_lost() {
    let mut bench = Bench::started(SLOW, false);
    bench.script.full.store(true, Ordering::Release);
    bench.until("the loss", |bench| bench.board.health().dropped == 1);
}
