//! What a board of GPIO lines makes of what a chip does, without a kernel: calls that hang or fail, edges that are lost
//! on their way, calls of the board that make no sense.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use crate::fake::Fake;
use host::HostInstant;
use scanrig_drivers::gpio::Edge;
use scanrig_drivers::{
    Board, BoardContext, BoardError, BoardEvent, BoardExt, ChannelId, GpioBoard, LossReason, Origin, build,
};
use signal::{Span, Time, Value};

/// When the chip of these tests is lost.
const SILENT: &str = "50 ms";
/// Where it must not be lost, however busy the machine is.
const PATIENT: &str = "20 s";

struct Bench {
    board: GpioBoard,
    at: BoardContext,
    chip: Arc<Fake>,
    events: Vec<BoardEvent>,
}

impl Bench {
    fn started() -> Bench {
        Bench::patient(SILENT)
    }

    fn patient(unresponsive_after: &str) -> Bench {
        let chip = Fake::new();
        let (board, at) = crate::fake::board(chip.clone(), unresponsive_after);
        let mut bench = Bench { board, at, chip, events: Vec::new() };
        bench.start();
        bench
    }

    fn start(&mut self) {
        self.at.time.restart();
        self.board.start(Time::ZERO).unwrap();
        self.poll();
        assert_eq!(self.events.len(), 2 * crate::fake::LINES, "the first level of every line");
        self.events.clear();
    }

    fn poll(&mut self) {
        self.board.poll(self.at.time.now(), &mut self.events).unwrap();
    }

    fn id(&self, name: &str) -> ChannelId {
        self.board.find(name).unwrap()
    }

    fn write(&mut self, name: &str, high: bool) {
        let id = self.id(name);
        self.board.write(self.at.time.now(), &[(id, Value::Bool(high))]).unwrap();
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

    /// Changes and losses of a channel.
    fn count(&self, name: &str) -> (u32, u32) {
        let id = self.id(name);
        let mut counts = (0, 0);
        for event in self.events.iter().filter(|event| event.channel() == id) {
            match event {
                BoardEvent::Changed { .. } => counts.0 += 1,
                BoardEvent::Dropped { count, .. } => counts.1 += count,
                _ => {}
            }
        }
        counts
    }
}

#[test]
fn what_is_written_is_driven_in_one_call_and_told_with_the_time_that_it_took() {
    let mut bench = Bench::patient(PATIENT);
    let ids = ["o0", "o3", "o15"].map(|name| bench.id(name));
    let sets = bench.chip.sets.load(Ordering::Acquire);
    let writes: Vec<_> = ids.iter().map(|id| (*id, Value::Bool(true))).collect();
    let asked = bench.at.time.now();
    bench.board.write(asked, &writes).unwrap();
    bench.until("all is told", |bench| bench.events.len() == 3);
    assert_eq!(bench.chip.outputs.load(Ordering::Acquire), 1 << 15 | 1 << 3 | 1);
    assert_eq!(bench.chip.sets.load(Ordering::Acquire), sets + 1);
    for (event, id) in bench.events.iter().zip(ids) {
        let BoardEvent::Changed { channel, at, value, origin } = *event else { panic!("{event:?}") };
        assert_eq!((channel, value, origin), (id, Value::Bool(true), Origin::Write));
        assert!(asked <= at.earliest && at.earliest <= at.latest && at.latest <= bench.at.time.now());
    }
    // The same again is no call, and letting go of an output that drives both levels is 0.
    bench.board.write(bench.at.time.now(), &writes).unwrap();
    bench.board.write(bench.at.time.now(), &[(ids[0], Value::HighZ)]).unwrap();
    bench.until("it is let go", |bench| bench.events.len() == 4);
    assert_eq!(bench.chip.sets.load(Ordering::Acquire), sets + 2);
    assert!(bench.board.health().is_sound());
}

#[test]
fn a_write_that_makes_no_sense_moves_nothing() {
    let chip = Fake::new();
    let (mut board, _at) = crate::fake::board(chip.clone(), SILENT);
    let (out, input) = (board.find("o0").unwrap(), board.find("i0").unwrap());
    let now = Time::ZERO;
    assert_eq!(board.write(now, &[(out, Value::Bool(true))]), Err(BoardError::NotStarted));
    assert_eq!(board.poll(now, &mut Vec::new()), Err(BoardError::NotStarted));
    assert_eq!(board.next_event(), None);
    board.start(now).unwrap();
    let sets = chip.sets.load(Ordering::Acquire);
    let high = (out, Value::Bool(true));
    for (wrong, error) in [
        ((ChannelId(99), Value::Bool(true)), BoardError::NoChannel(ChannelId(99))),
        ((input, Value::Bool(true)), BoardError::NotDriven(input)),
        ((out, Value::Real(1.0)), BoardError::BadValue(out)),
    ] {
        assert_eq!(board.write(now, &[high, wrong]), Err(error));
    }
    board.write(Time::from_nanos(5), &[]).unwrap();
    let last = Time::from_nanos(5);
    assert_eq!(board.write(now, &[high]), Err(BoardError::Backwards { now, last }));
    board.safe(last).unwrap();
    assert_eq!(board.write(last, &[high]), Err(BoardError::Latched));
    assert_eq!((chip.sets.load(Ordering::Acquire), chip.outputs.load(Ordering::Acquire)), (sets, 0));
    let health = board.health();
    assert!(health.latched_safe && health.is_sound());
}

#[test]
fn what_finds_no_room_on_its_way_is_told_as_lost() {
    let mut bench = Bench::patient(PATIENT);
    let made = 20_000;
    for edge in 0..made {
        bench.chip.edge(edge % 2 == 0, HostInstant::now());
    }
    // Nobody looks before all of them were on their way.
    while !bench.chip.is_drained() {
        std::thread::yield_now();
    }
    bench.until("all edges are accounted for", |bench| {
        let (seen, lost) = bench.count("i0");
        assert!(seen + lost <= made);
        seen + lost == made
    });
    let (seen, lost) = bench.count("i0");
    assert!(seen >= 8_000 && lost >= 10_000, "{seen} {lost}");
    assert_eq!(bench.board.health().dropped, u64::from(lost));
}

#[test]
fn edges_that_the_numbers_miss_are_told_as_lost() {
    let mut bench = Bench::patient(PATIENT);
    let now = HostInstant::now();
    for (high, numbers) in [(true, (1, 1)), (false, (4, 2)), (true, (5, 6))] {
        bench.chip.tell(Edge { input: 0, high, stamp: now, numbers: Some(numbers) });
    }
    bench.chip.level(true);
    // Three numbers of the line in between are lost for certain, one of which was among the two that the claim missed.
    bench.until("all is told", |bench| bench.count("i0").1 >= 3);
    assert_eq!(bench.count("i0"), (3, 3));
}

#[test]
fn an_edge_to_the_level_that_a_line_has_is_a_lost_one() {
    let mut bench = Bench::patient(PATIENT);
    for high in [true, true, false] {
        bench.chip.edge(high, HostInstant::now());
    }
    bench.until("all is told", |bench| bench.count("i0") == (2, 1));
    assert!(!bench.board.health().is_sound());
}

#[test]
fn a_level_that_no_edge_told_of_is_found_by_reading() {
    let mut bench = Bench::started();
    bench.chip.edge(true, HostInstant::now());
    bench.until("the edge is told", |bench| bench.count("i0") == (1, 0));
    bench.chip.level(false);
    bench.until("the level is told", |bench| bench.count("i0") == (2, 1));
    let Some(BoardEvent::Changed { at, value, .. }) = bench.events.last() else {
        panic!("{:?}", bench.events)
    };
    assert_eq!(*value, Value::Bool(false));
    assert!(at.latest - at.earliest >= Span::from_millis(50), "{at:?}");
    // The edge comes after all.
    bench.chip.edge(false, bench.at.time.stamp(at.earliest));
    bench.chip.edge(true, HostInstant::now());
    bench.until("the next edge is told", |bench| bench.count("i0").0 == 3);
    assert_eq!(bench.count("i0"), (3, 1));
}

#[test]
fn what_lies_ahead_of_a_poll_waits_for_the_next() {
    let mut bench = Bench::patient(PATIENT);
    let ahead = bench.at.time.now() + Span::from_millis(400);
    bench.chip.edge(true, bench.at.time.stamp(ahead));
    bench.until("it is known", |bench| bench.board.next_event() == Some(ahead));
    assert_eq!(bench.events, []);
    bench.until("it is told", |bench| bench.count("i0") == (1, 0));
    assert!(bench.at.time.now() >= ahead);
}

#[test]
fn a_device_that_hangs_is_lost_and_made_safe_when_it_comes_back() {
    let mut bench = Bench::started();
    bench.chip.shut(true);
    bench.write("o0", true);
    assert!(bench.board.next_event().is_some_and(|at| at <= bench.at.time.now() + Span::from_millis(51)));
    bench.until("every channel is lost", |bench| bench.board.health().lost == 32);
    let lost =
        |event: &&BoardEvent| matches!(event, BoardEvent::Lost { reason: LossReason::Unresponsive, .. });
    assert_eq!(bench.events.iter().filter(lost).count(), 32);
    // Far more than there is room for.
    for turn in 0..3_000 {
        bench.write("o1", turn % 2 == 0);
    }
    let begin = Instant::now();
    let safe = bench.board.safe(bench.at.time.now());
    assert!(matches!(safe, Err(BoardError::Os { .. })), "{safe:?}");
    assert!(begin.elapsed() < Duration::from_secs(10));
    bench.chip.shut(false);
    bench.until("it answers", |bench| bench.board.health().lost == 0);
    bench.until("it is safe", |bench| bench.chip.outputs.load(Ordering::Acquire) == 0);
    let back = |event: &&BoardEvent| matches!(event, BoardEvent::Returned { .. });
    assert_eq!(bench.events.iter().filter(back).count(), 32);
    bench.events.clear();
    bench.start();
    assert!(bench.board.health().is_sound());
}

#[test]
fn the_newest_image_is_driven_and_what_it_swallows_is_told() {
    let mut bench = Bench::patient(PATIENT);
    bench.chip.shut(true);
    bench.write("o0", true);
    let due = Instant::now() + Duration::from_secs(20);
    while !bench.chip.waiting.load(Ordering::Acquire) {
        assert!(Instant::now() < due, "the device is never asked");
        std::thread::yield_now();
    }
    // More than there is room for: the last one counts.
    for turn in 0..3_000 {
        bench.write("o1", turn % 2 == 0);
    }
    bench.write("o2", true);
    bench.chip.shut(false);
    bench.until("the newest image is driven", |bench| bench.chip.outputs.load(Ordering::Acquire) == 0b101);
    bench.until("the rest is told", |bench| bench.count("o1").1 > 0);
    bench.until("it is told", |bench| bench.count("o2").0 == 1);
    assert_eq!(bench.count("o1").0, 0);
}

/// Pulses that the chip was too late for are driven all the same: each edge in its turn, far enough from the one before.
#[test]
fn pulses_that_are_late_are_driven_one_after_another() {
    let mut bench = Bench::patient(PATIENT);
    bench.chip.shut(true);
    bench.write("o0", true);
    let due = Instant::now() + Duration::from_secs(20);
    while !bench.chip.waiting.load(Ordering::Acquire) {
        assert!(Instant::now() < due, "the device is never asked");
        std::thread::yield_now();
    }
    // An encoder that turns by 40 counts, while another output goes to and fro.
    let mut asked = Vec::new();
    for count in 0..40 {
        let (name, high) = (["o12", "o13"][count % 2], count % 4 < 2);
        bench.write(name, high);
        asked.push((bench.id(name), Value::Bool(high)));
    }
    bench.chip.shut(false);
    let pulsed = ["o12", "o13"].map(|name| bench.id(name));
    let of_them = |bench: &Bench| -> Vec<(ChannelId, Value, Time, Time)> {
        let edge = |event: &BoardEvent| match *event {
            BoardEvent::Changed { channel, at, value, .. } if pulsed.contains(&channel) => {
                Some((channel, value, at.earliest, at.latest))
            }
            _ => None,
        };
        bench.events.iter().filter_map(edge).collect()
    };
    bench.until("all edges are told", |bench| of_them(bench).len() >= 40);
    let edges = of_them(&bench);
    assert_eq!(edges.iter().map(|edge| (edge.0, edge.1)).collect::<Vec<_>>(), asked);
    for pair in edges.windows(2) {
        assert!(pair[0].3 <= pair[1].2, "two edges in one call: {pair:?}");
    }
    for line in pulsed {
        let own: Vec<_> = edges.iter().filter(|edge| edge.0 == line).collect();
        for pair in own.windows(2) {
            assert!(pair[1].2 - pair[0].3 >= Span::from_micros(250), "a runt: {pair:?}");
        }
    }
    assert!(bench.board.health().is_sound());
    // What stands in the way of the others is reported as ever.
    assert_eq!(bench.count("o0"), (1, 0));
}

/// More pulses than can wait: those that are lost are reported.
#[test]
fn pulses_without_room_are_told_as_lost() {
    let mut bench = Bench::patient(PATIENT);
    bench.chip.shut(true);
    for turn in 0..3_000 {
        bench.write("o12", turn % 2 == 0);
    }
    bench.chip.shut(false);
    bench.until("some are told as lost", |bench| bench.count("o12").1 > 0);
    assert!(!bench.board.health().is_sound());
}

#[test]
fn a_device_that_finds_nothing_left_to_do_is_not_silent() {
    let mut bench = Bench::patient("2 s");
    for _ in 0..100 {
        // As a rule both are there before the device looks, and cancel.
        bench.write("o0", true);
        bench.write("o0", false);
    }
    let due = Instant::now() + Duration::from_millis(2_200);
    bench.until("the chip would be lost by now", |_| Instant::now() > due);
    assert_eq!(bench.board.health().lost, 0);
    assert!(!bench.events.iter().any(|event| matches!(event, BoardEvent::Lost { .. })));
    // What cancelled is reported.
    let (seen, lost) = bench.count("o0");
    assert!(lost > 0 && seen % 2 == 0, "{seen} {lost}");
}

#[test]
fn a_chip_that_is_gone_or_answers_with_an_error_is_no_ground_for_a_verdict() {
    let mut bench = Bench::started();
    bench.chip.error.store(5, Ordering::Release);
    bench.write("o0", true);
    bench.until("the failed call is counted", |bench| bench.board.health().failed_calls > 0);
    bench.chip.error.store(0, Ordering::Release);
    bench.until("it is tried again", |bench| bench.chip.outputs.load(Ordering::Acquire) == 1);
    bench.chip.error.store(19, Ordering::Release);
    bench.write("o0", false);
    bench.until("it is gone", |bench| bench.board.health().lost == 32);
    let gone = |event: &&BoardEvent| matches!(event, BoardEvent::Lost { reason: LossReason::Gone, .. });
    assert_eq!(bench.events.iter().filter(gone).count(), 32);
    let safe = bench.board.safe(bench.at.time.now());
    assert!(matches!(safe, Err(BoardError::Os { code: 19, .. })), "{safe:?}");
    // Nothing says that it is to be taken back.
    let started = bench.board.start(bench.at.time.now());
    assert!(
        matches!(started, Err(BoardError::Lost { reason: LossReason::Gone, since, .. }) if since > Span::ZERO),
        "{started:?}"
    );
}

#[test]
fn a_board_on_paper_has_the_channels_and_never_starts() {
    let file = crate::fake::file(SILENT);
    let mut paper = build(&file, 1).unwrap();
    let (board, _at) = crate::fake::board(Fake::new(), SILENT);
    assert_eq!(paper.channels(), board.channels());
    assert_eq!(paper.start(Time::ZERO), Err(BoardError::NotStarted));
    assert!(paper.output_claims().unwrap().is_empty());
}
