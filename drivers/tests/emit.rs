//! What a board of generators makes of what a generator does, without a device: orders and their order, edges that are
//! reported a few at a time, calls that hang or fail, a device that goes and comes back.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use crate::generating::{Did, Script, board, file};
use scanrig_drivers::generator::GeneratorBoard;
use scanrig_drivers::{
    Board, BoardContext, BoardError, BoardEvent, BoardExt, ChannelId, Emission, LossReason, NotEmitted,
    Origin, build,
};
use signal::{Span, Time, Value, When};

const EIO: i32 = 5;
const ENODEV: i32 = 19;
/// Where nothing must be late or lost, however busy the machine is.
const SLOW: &str = "20 s";
const S: ChannelId = ChannelId(0);
const P0: ChannelId = ChannelId(1);
const P1: ChannelId = ChannelId(2);

struct Bench {
    board: GeneratorBoard,
    at: BoardContext,
    stream: Arc<Script>,
    chip: Arc<Script>,
    events: Vec<BoardEvent>,
}

impl Bench {
    fn started(unresponsive_after: &str, reconnect: bool) -> Bench {
        let (stream, chip) = (Arc::new(Script::default()), Arc::new(Script::default()));
        let (board, at) = board(&file(unresponsive_after, reconnect), [&stream, &chip]);
        let mut bench = Bench { board, at, stream, chip, events: Vec::new() };
        bench.start().unwrap();
        assert_eq!([S, P0].map(|channel| bench.board.device_kind(channel)), [Some("spi"), Some("pwm")]);
        bench
    }

    fn start(&mut self) -> Result<(), BoardError> {
        self.events.clear();
        self.at.time.restart();
        self.board.start(Time::ZERO)?;
        self.poll();
        let rest = BoardEvent::Changed {
            channel: S,
            at: When::exactly(Time::ZERO),
            value: Value::Bool(false),
            origin: Origin::Write,
        };
        assert_eq!(self.events, [rest], "the level at rest, of what is told of");
        self.events.clear();
        Ok(())
    }

    fn poll(&mut self) {
        self.board.poll(self.at.time.now(), &mut self.events).unwrap();
    }

    fn emit(&mut self, channel: ChannelId, emission: &Emission) -> Result<(), BoardError> {
        self.board.emit(self.at.time.now(), channel, emission)
    }

    fn write(&mut self, writes: &[(ChannelId, Value)]) -> Result<(), BoardError> {
        self.board.write(self.at.time.now(), writes)
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

    fn fate(&self, of: ChannelId) -> Vec<Option<LossReason>> {
        let of = |event: &BoardEvent| match *event {
            BoardEvent::Lost { channel, reason, .. } if channel == of => Some(Some(reason)),
            BoardEvent::Returned { channel, .. } if channel == of => Some(None),
            _ => None,
        };
        self.events.iter().filter_map(of).collect()
    }

    fn edges(&self) -> Vec<(When, bool)> {
        let of = |event: &BoardEvent| match *event {
            BoardEvent::Changed { channel: S, at, value: Value::Bool(high), origin: Origin::Write } => {
                Some((at, high))
            }
            _ => None,
        };
        self.events.iter().filter_map(of).collect()
    }
}

fn square(period: i64, high: i64) -> Emission {
    Emission::Square { period: Span::from_nanos(period), high: Span::from_nanos(high) }
}

/// So many pulses of 2 us every 5 us.
fn pulses(count: i64) -> Emission {
    Emission::Pulses((0..count).flat_map(|pulse| [pulse * 5, pulse * 5 + 2].map(Span::from_micros)).collect())
}

#[test]
fn what_can_be_had_of_which_channel_is_known_on_paper_and_kept() {
    let mut bench = Bench::started(SLOW, false);
    let paper = build(&file(SLOW, false), 1).unwrap();
    assert_eq!(paper.channels(), bench.board.channels(), "a plan is checked alike on any machine");
    let emits = |channel: ChannelId| paper.channels()[usize::from(channel.0)].emits.unwrap();
    // 4096 bytes, of which one goes in front and the last bit is at rest.
    assert_eq!(emits(S).counted, Span::from_micros(4_095 * 8 - 1));
    let not = |channel, why| Err(BoardError::NotEmitted(channel, why));
    assert_eq!(bench.emit(S, &square(10_000, 5_000)), not(S, NotEmitted::Endless));
    assert_eq!(bench.emit(P0, &pulses(1)), not(P0, NotEmitted::Counted));
    assert_eq!(bench.emit(S, &pulses(6_553)), not(S, NotEmitted::Lasting(emits(S).counted)));
    assert_eq!(bench.emit(P0, &square(3_000_000_000, 1)), not(P0, NotEmitted::Long(emits(P0).longest)));
    assert_eq!(bench.emit(ChannelId(9), &pulses(1)), Err(BoardError::NoChannel(ChannelId(9))));
    // One that is refused keeps the others from being written.
    let both = [(P0, Value::Bool(true)), (S, Value::Bool(true))];
    assert_eq!(bench.write(&both), Err(BoardError::BadValue(S)));
    assert_eq!(bench.write(&[(P0, Value::Int(1))]), Err(BoardError::BadValue(P0)));
    assert_eq!(bench.chip.did(), [Did::Rest]);
    assert_eq!(bench.stream.did(), [Did::Rest]);
}

#[test]
fn a_channel_is_written_only_where_that_changes_something() {
    let mut bench = Bench::started(SLOW, false);
    let [low, high] = [Value::Bool(false), Value::Bool(true)];
    bench.write(&[(P0, low), (P1, high), (S, low)]).unwrap();
    bench.write(&[(P0, high), (P1, Value::HighZ)]).unwrap();
    bench.write(&[(P0, high), (P1, low)]).unwrap();
    bench.emit(P0, &square(1_000, 400)).unwrap();
    bench.emit(P0, &square(1_000, 500)).unwrap();
    bench.write(&[(P0, high), (P1, Value::HighZ)]).unwrap();
    let wanted = [
        Did::Rest,
        Did::Level(0, true),
        Did::Level(1, false),
        Did::Square(0, 1_000, 400),
        Did::Square(0, 1_000, 500),
        Did::Level(0, true),
        Did::Level(1, true),
    ];
    bench.until("all that changed", |bench| bench.chip.did().len() == wanted.len());
    assert_eq!(bench.chip.did(), wanted);
    let now = bench.at.time.now();
    bench.board.safe(now).unwrap();
    assert_eq!(bench.chip.did().last(), Some(&Did::Rest), "it was waited for");
    assert_eq!(bench.emit(P0, &square(1_000, 400)), Err(BoardError::Latched));
    assert_eq!(bench.write(&[(P0, high)]), Err(BoardError::Latched));
    bench.start().unwrap();
    bench.write(&[(P0, low)]).unwrap();
    bench.until("a look", |_| true);
    assert_eq!(bench.chip.did().len(), wanted.len() + 2, "it rests, and knows it");
}

#[test]
fn edges_are_reported_in_order_some_at_a_time_within_what_the_call_allows() {
    let mut bench = Bench::started(SLOW, false);
    let before = bench.at.time.now();
    bench.emit(S, &pulses(1_000)).unwrap();
    bench.emit(S, &pulses(3)).unwrap();
    bench.emit(S, &pulses(1)).unwrap();
    // The third call begins when both before are reported. Nobody polls meanwhile, however long that takes.
    let due = Instant::now() + Duration::from_secs(20);
    while bench.stream.did().len() < 4 {
        assert!(Instant::now() < due, "never sent: {:?}", bench.stream.did());
        std::thread::sleep(Duration::from_millis(1));
    }
    let mut polls = 0;
    while bench.edges().len() < 2_006 {
        let reported = bench.edges().len();
        bench.poll();
        let more = bench.edges().len() - reported;
        assert!((1..=256).contains(&more), "{more} edges: a poll takes no longer than 256");
        if bench.edges().len() < 2_006 {
            assert!(
                bench.board.next_event().is_some_and(|at| at <= bench.at.time.now()),
                "it is not forgotten"
            );
        }
        polls += 1;
    }
    assert_eq!(polls, 8);
    let edges = bench.edges();
    assert!(edges.iter().enumerate().all(|(place, (_, high))| *high == (place % 2 == 0)));
    assert!(edges.is_sorted_by_key(|(at, _)| at.earliest));
    let (first, last) = (edges[0].0, edges[1_999].0);
    assert!(first.earliest >= before + Span::from_micros(8), "a byte goes in front: {first:?}");
    assert_eq!(last.earliest - first.earliest, Span::from_micros(999 * 5 + 2));
    assert!(bench.board.health().is_sound());
}

#[test]
fn a_write_drops_pulses_that_did_not_begin_and_tells_which() {
    let mut bench = Bench::started(SLOW, false);
    bench.stream.shut(true);
    bench.emit(S, &pulses(2)).unwrap();
    bench.until("the call", |bench| bench.stream.waiting.load(Ordering::Acquire));
    bench.emit(S, &pulses(5)).unwrap();
    bench.write(&[(S, Value::Bool(false))]).unwrap();
    bench.emit(S, &pulses(3)).unwrap();
    bench.stream.shut(false);
    bench.until("what did go out", |bench| bench.edges().len() == 10);
    assert_eq!(bench.stream.did(), [Did::Rest, Did::Pulses(4, 7_000), Did::Pulses(6, 12_000)]);
    assert_eq!(bench.board.health().dropped, 10);
    let dropped = bench.events.iter().find(|event| matches!(event, BoardEvent::Dropped { .. }));
    assert!(matches!(dropped, Some(BoardEvent::Dropped { channel: S, count: 10, .. })), "{dropped:?}");
}

#[test]
fn a_call_that_hangs_holds_up_no_other_device_and_a_start_drops_what_waited() {
    let mut bench = Bench::started("150 ms", false);
    bench.stream.shut(true);
    bench.emit(S, &pulses(1)).unwrap();
    bench.emit(S, &pulses(2)).unwrap();
    bench.until("the silence", |bench| bench.fate(S) == [Some(LossReason::Unresponsive)]);
    bench.emit(P0, &square(1_000, 400)).unwrap();
    bench.until("the wave", |bench| bench.chip.did().len() == 2);
    let now = bench.at.time.now();
    assert!(bench.board.safe(now).is_err(), "a line that hangs is not known to be safe");
    assert_eq!(bench.chip.did().last(), Some(&Did::Rest));
    bench.at.time.restart();
    let refused = bench.board.start(Time::ZERO);
    assert!(
        matches!(refused, Err(BoardError::Lost { channel: S, reason: LossReason::Unresponsive, .. })),
        "{refused:?}"
    );
    bench.stream.shut(false);
    bench.start().unwrap();
    assert_eq!(bench.stream.did().iter().filter(|did| matches!(did, Did::Pulses(..))).count(), 1);
    bench.emit(S, &pulses(3)).unwrap();
    bench.until("the edges of the new run", |bench| bench.edges().len() == 6);
}

#[test]
fn a_safe_state_waits_no_longer_for_pulses_under_way_than_a_device_may_be_silent_and_a_start_does() {
    let mut bench = Bench::started("100 ms", false);
    bench.stream.says.store(30_000_000_000, Ordering::Release);
    bench.stream.shut(true);
    bench.emit(S, &pulses(2)).unwrap();
    bench.emit(S, &pulses(3)).unwrap();
    bench.until("the call", |bench| bench.stream.waiting.load(Ordering::Acquire));
    let began = Instant::now();
    bench.board.safe(bench.at.time.now()).unwrap();
    assert!(began.elapsed() < Duration::from_secs(15), "they end at rest by themselves");
    bench.poll();
    assert_eq!(bench.fate(S), [], "they last, and nothing hangs");
    let script = bench.stream.clone();
    let ends = std::thread::spawn(move || {
        std::thread::sleep(Duration::from_millis(2_500));
        script.shut(false);
    });
    bench.start().unwrap();
    ends.join().unwrap();
    assert_eq!(bench.stream.did()[1..], [Did::Pulses(4, 7_000), Did::Rest], "what waited is forgotten");
}

#[test]
fn a_device_that_is_gone_comes_back_at_rest_and_goes_on_with_what_it_was_asked_last() {
    let mut bench = Bench::started("150 ms", true);
    bench.emit(P0, &square(1_000, 400)).unwrap();
    bench.write(&[(P1, Value::Bool(false))]).unwrap();
    bench.until("both", |bench| bench.chip.did().len() == 3);
    bench.chip.error.store(ENODEV, Ordering::Release);
    bench.until("the loss", |bench| bench.fate(P0) == [Some(LossReason::Gone)]);
    assert_eq!((bench.fate(P1).len(), bench.board.health().lost), (1, 2), "all its outputs");
    bench.emit(P0, &square(1_000, 600)).unwrap();
    bench.chip.error.store(0, Ordering::Release);
    bench.chip.there.store(true, Ordering::Release);
    bench.until("the return", |bench| bench.fate(P1).last() == Some(&None));
    bench.until("what it was asked last", |bench| bench.chip.did().len() == 5);
    assert_eq!(bench.chip.did()[3..], [Did::Square(0, 1_000, 600), Did::Level(1, false)]);
    assert_eq!(bench.board.health().lost, 0);
}

#[test]
fn calls_that_fail_are_counted_and_calls_that_go_on_to_fail_are_a_loss() {
    let mut bench = Bench::started("150 ms", false);
    bench.stream.error.store(EIO, Ordering::Release);
    bench.emit(S, &pulses(2)).unwrap();
    bench.until("the failure", |bench| {
        bench.board.health().failed_calls > 0 && bench.board.health().dropped == 4
    });
    bench.until("the loss", |bench| bench.fate(S) == [Some(LossReason::Gone)]);
    assert_eq!(bench.fate(P0), []);
    bench.at.time.restart();
    let refused = bench.board.start(Time::ZERO);
    assert!(matches!(refused, Err(BoardError::Lost { reason: LossReason::Gone, .. })), "{refused:?}");
}
