//! The rig as an instrument, on a loop whose every trouble is made on purpose.

use drivers::{
    Board, BoardContext, BoardError, BoardEvent, Channel, ChannelId, ChannelKind, FaultSet, Health,
    LoopbackPair, LossReason, Origin, TimestampSource,
};
use guard::GuardError;
use host::Realtime;
use scanrig_runtime::executor::heartbeat::Heartbeat;
use scanrig_runtime::instrument::{EDGES, Instrument, LoopFault, loopback, names, phases, square};
use signal::{Span, Time, Value, When};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// What the loop does wrong, from an edge on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Trouble {
    None,
    Inverts,
    Cut,
    Twice,
    Lost,
    Gone,
    Early,
}

/// An output that comes back at an input after some time of the host's clock.
#[derive(Debug)]
struct Echo {
    channels: Vec<Channel>,
    delay: Span,
    trouble: Trouble,
    from: u64,
    edges: u64,
    level: bool,
    coming: Vec<BoardEvent>,
    safe: bool,
}

const OUT: ChannelId = ChannelId(0);
const IN: ChannelId = ChannelId(1);
const LOOP: LoopbackPair = LoopbackPair { out: OUT, input: IN };

fn channel(name: &str) -> Channel {
    Channel {
        name: name.to_owned(),
        kind: ChannelKind::Digital,
        drives: true,
        senses: true,
        timestamp: TimestampSource::Kernel,
        resolution: Span::ZERO,
        shortest_pulse: Span::ZERO,
        deadband: 0.0,
        max_pulse_hz: 0,
        emits: None,
        counts_hz: None,
        faults: FaultSet::NONE,
        safe: Value::Bool(false),
    }
}

fn echo(trouble: Trouble, from: u64) -> Echo {
    Echo {
        channels: vec![channel("Q0"), channel("I0")],
        delay: Span::from_micros(200),
        trouble,
        from,
        edges: 0,
        level: false,
        coming: Vec::new(),
        safe: false,
    }
}

impl Board for Echo {
    fn inner(&self) -> Option<&dyn Board> {
        None
    }

    fn inner_mut(&mut self) -> Option<&mut dyn Board> {
        None
    }

    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn start(&mut self, _: Time) -> Result<(), BoardError> {
        (self.safe, self.level) = (false, false);
        Ok(())
    }

    fn write(&mut self, now: Time, writes: &[(ChannelId, Value)]) -> Result<(), BoardError> {
        for (channel, value) in writes {
            let Value::Bool(high) = *value else { return Err(BoardError::BadValue(*channel)) };
            if high == self.level || *channel != OUT {
                continue;
            }
            (self.level, self.edges) = (high, self.edges + 1);
            let call = When::within(now, now + Span::from_micros(10));
            self.coming.push(BoardEvent::Changed {
                channel: OUT,
                at: call,
                value: *value,
                origin: Origin::Write,
            });
            let trouble = if self.edges >= self.from { self.trouble } else { Trouble::None };
            let at = now + if trouble == Trouble::Early { Span::from_millis(-3) } else { self.delay };
            let changed = |high, at| BoardEvent::Changed {
                channel: IN,
                at: When::exactly(at),
                value: Value::Bool(high),
                origin: Origin::Outside,
            };
            match trouble {
                Trouble::None | Trouble::Early => self.coming.push(changed(high, at)),
                Trouble::Inverts => self.coming.push(changed(!high, at)),
                Trouble::Cut => {}
                Trouble::Twice => {
                    self.coming.extend([changed(high, at), changed(!high, at + Span::from_millis(1))]);
                }
                Trouble::Lost => self.coming.push(BoardEvent::Dropped { channel: IN, at, count: 2 }),
                Trouble::Gone => {
                    let reason = LossReason::Gone;
                    self.coming.push(BoardEvent::Lost { channel: IN, at, reason });
                }
            }
        }
        Ok(())
    }

    fn poll(&mut self, now: Time, out: &mut Vec<BoardEvent>) -> Result<(), BoardError> {
        let (due, coming) = self.coming.drain(..).partition(|event| event.latest() <= now);
        self.coming = coming;
        out.extend::<Vec<_>>(due);
        Ok(())
    }

    fn next_event(&self) -> Option<Time> {
        self.coming.iter().map(BoardEvent::latest).min()
    }

    fn safe(&mut self, _: Time) -> Result<(), BoardError> {
        (self.safe, self.level) = (true, false);
        Ok(())
    }

    fn health(&self) -> Health {
        Health::default()
    }
}

fn lives() -> BoardContext {
    BoardContext::new(Realtime::default())
}

fn on<'a>(board: &'a mut Echo, lives: &'a BoardContext) -> Instrument<'a> {
    Instrument { board, lives, heartbeat: None }
}

static GO_ON: AtomicBool = AtomicBool::new(false);

#[test]
fn a_wave_that_comes_back_edge_by_edge_is_an_instrument() {
    for trouble in [Trouble::None, Trouble::Inverts] {
        let mut board = echo(trouble, 0);
        let found = square(on(&mut board, &lives()), LOOP, &GO_ON).unwrap();
        assert_eq!((found.edges, board.edges), (EDGES, EDGES), "{trouble:?}");
        // The delay is exact; when it was seen depends on the host.
        assert_eq!(found.stamped_within, Span::from_micros(200));
        assert!(!found.seen_within.is_negative() && board.safe);
    }
}

#[test]
fn every_trouble_of_a_loop_is_named_and_leaves_the_board_safe() {
    for (trouble, expected, words) in [
        (Trouble::Cut, LoopFault::Silent { edge: 7, high: true }, "`I0` did not follow edge 7 of `Q0`, to 1"),
        (Trouble::Inverts, LoopFault::Stray { edge: 7 }, "though nobody drove it"),
        (Trouble::Lost, LoopFault::Dropped(2), "2 edges of `I0` were lost"),
        (Trouble::Gone, LoopFault::Lost(LossReason::Gone), "the device is gone"),
        (
            Trouble::Early,
            LoopFault::Early { edge: 7, by: Span::from_millis(3) },
            "3 ms before `Q0` was driven",
        ),
    ] {
        let mut board = echo(trouble, 7);
        let found = square(on(&mut board, &lives()), LOOP, &GO_ON).unwrap_err();
        assert_eq!(found, expected, "{trouble:?}");
        assert!(found.words(&names(&board, LOOP)).contains(words), "{}", found.words(&names(&board, LOOP)));
        assert!(board.safe && !found.fix().is_empty(), "{trouble:?}");
    }
}

#[test]
fn an_input_that_changes_once_more_is_a_stray_edge() {
    let mut board = echo(Trouble::Twice, 7);
    let found = square(on(&mut board, &lives()), LOOP, &GO_ON).unwrap_err();
    // A host that was late drives its next edges before it sees the one that nobody drove.
    let LoopFault::Stray { edge } = found else { panic!("{found:?}") };
    assert!(edge >= 7 && board.safe && !found.fix().is_empty(), "{found:?}");
    let words = format!("`I0` changed after edge {edge} of `Q0`");
    assert!(found.words(&names(&board, LOOP)).contains(&words), "{}", found.words(&names(&board, LOOP)));
}

#[test]
fn a_loop_that_drives_itself_needs_no_stamp() {
    let mut board = echo(Trouble::Inverts, 0);
    let found = loopback(on(&mut board, &lives()), LOOP, 100, &GO_ON).unwrap();
    assert_eq!((found.turns, found.call_to_stamp.count(), found.asked_to_call.count()), (100, 100, 100));
    assert_eq!((found.call_to_stamp.min(), found.call_to_stamp.max()), (200_000, 200_000));
    // A turn is at least what the wire takes, and the parts together are no more than the whole.
    let turn = found.turn().unwrap();
    assert!(turn >= Span::from_micros(200), "{turn}");
    let parts = found.call_to_stamp.mean() + found.stamp_to_seen.mean();
    assert!(parts <= turn.as_nanos() as u64, "{parts} ns of {turn}");
    assert!(board.safe);
}

#[test]
fn a_loop_that_somebody_ends_keeps_what_it_has() {
    let found =
        loopback(on(&mut echo(Trouble::None, 0), &lives()), LOOP, 100, &AtomicBool::new(true)).unwrap();
    assert!(found.interrupted && found.turns == 0 && found.turn().is_none());
}

#[test]
fn scans_have_phases_and_drive_what_they_may() {
    let mut board = echo(Trouble::None, 0);
    let mut ran = 0;
    let mut program = || {
        ran += 1;
        Ok(())
    };
    let timing = [500_000, 40];
    let found = phases(on(&mut board, &lives()), timing, &[OUT], &mut program, &GO_ON).unwrap();
    assert_eq!((ran, board.edges, found.wake.count(), found.outputs.count()), (40, 40, 40, 40));
    assert!(found.whole.max() >= found.program.max() && found.device.count() > 0 && board.safe);
    // Nothing moves that was not named.
    let mut board = echo(Trouble::None, 0);
    phases(on(&mut board, &lives()), timing, &[], &mut || Ok(()), &GO_ON).unwrap();
    assert_eq!(board.edges, 0);
}

/// A heartbeat that counts, and stops beating after so many.
#[derive(Debug, Default)]
struct Pulse {
    begun: AtomicU64,
    beats: AtomicU64,
    most: u64,
    ended: AtomicU64,
}

impl Heartbeat for Pulse {
    fn begin(&self) -> Result<(), GuardError> {
        self.begun.fetch_add(1, Ordering::Relaxed);
        Ok(())
    }

    fn beat(&self) -> Result<(), GuardError> {
        let beats = self.beats.fetch_add(1, Ordering::Relaxed) + 1;
        if beats > self.most { Err(GuardError::Gone) } else { Ok(()) }
    }

    fn every(&self) -> Span {
        Span::from_millis(2)
    }

    fn end(&self) -> Result<(), GuardError> {
        self.ended.fetch_add(1, Ordering::Relaxed);
        Ok(())
    }
}

fn watched<'a>(board: &'a mut Echo, lives: &'a BoardContext, pulse: &'a Pulse) -> Instrument<'a> {
    Instrument { board, lives, heartbeat: Some(pulse) }
}

#[test]
fn somebody_watches_every_measurement_from_its_start_to_its_end() {
    let count = |of: &AtomicU64| of.load(Ordering::Relaxed);
    let pulse = Pulse { most: u64::MAX, ..Pulse::default() };
    let (mut board, lives) = (echo(Trouble::None, 0), lives());
    square(watched(&mut board, &lives, &pulse), LOOP, &GO_ON).unwrap();
    loopback(watched(&mut board, &lives, &pulse), LOOP, 5, &GO_ON).unwrap();
    let timing = [20_000_000, 3];
    phases(watched(&mut board, &lives, &pulse), timing, &[], &mut || Ok(()), &GO_ON).unwrap();
    assert_eq!((count(&pulse.begun), count(&pulse.ended)), (3, 3));
    // Three scans of 20 ms alone are thirty times as long as it may be silent.
    assert!(count(&pulse.beats) > 30, "{pulse:?}");
    // Nothing goes on when nobody watches.
    let pulse = Pulse { most: 20, ..Pulse::default() };
    let fault = square(watched(&mut board, &lives, &pulse), LOOP, &GO_ON).unwrap_err();
    assert!(matches!(fault, LoopFault::Unguarded(_)) && board.safe, "{fault:?}");
}
