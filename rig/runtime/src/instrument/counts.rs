//! The fastest pulses of which a board counts every one: trains through its loop, faster and faster, until pulses are
//! missing or cannot be made any faster.

use super::{Instrument, LONGEST_WAIT, LoopFault, SETTLE};
use drivers::{BoardError, BoardEvent, BoardExt, ChannelId, Emission, LoopbackPair, LossReason, Origin};
use signal::{Span, Time, Value};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Pulses of one train.
const PULSES: u32 = 500;
/// The longest that a train lasts: slow ones have fewer pulses.
const LASTS: Span = Span::from_millis(500);
/// The slowest train, in Hz.
const SLOWEST: u64 = 50;
/// The fastest train, in Hz: nothing that interrupts count comes near it.
const FASTEST: u64 = 10_000_000;
/// From one frequency to the next, as a fraction.
const STEP: (u64, u64) = (5, 4);
/// A train that is slower than wanted by more than this part of it is one that cannot be made.
const SLOWER: u64 = 10;
/// How long nothing may come before no more edges are waited for.
const QUIET: Span = Span::from_millis(200);
/// Edges between two looks at the board while a train is made: its queues hold far more.
const LOOK: u32 = 128;

/// One train.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Train {
    /// How fast it was to be, in Hz.
    pub wanted_hz: u64,
    /// How fast it was.
    pub hz: u64,
    /// Edges of the output.
    pub made: u32,
    /// Edges of the input.
    pub seen: u32,
    /// Edges that the board says were lost.
    pub lost: u32,
}

impl Train {
    /// Whether every edge was seen.
    pub const fn is_counted(&self) -> bool {
        self.seen == self.made && self.lost == 0
    }

    /// Whether it was as fast as it was to be.
    pub const fn is_made(&self) -> bool {
        self.hz >= self.wanted_hz - self.wanted_hz / SLOWER
    }
}

/// What came of a measurement.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Every train, in order.
    pub trains: Vec<Train>,
    /// The fastest pulses of which all were counted each time, in Hz; 0 where some of the slowest were missing.
    pub counted_hz: u64,
    /// The fastest pulses that were made, in Hz.
    pub made_hz: u64,
    /// Faster ones were made, and some of them were missing.
    pub is_limit: bool,
}

/// Drives trains through a loop, `repeats` of each frequency, and counts what comes back. Leaves the board safe.
///
/// # Errors
/// Why nothing can be measured.
pub fn counts(
    mut on: Instrument<'_>,
    looped: LoopbackPair,
    repeats: u32,
    stop: &AtomicBool,
) -> Result<Counts, LoopFault> {
    on.start()?;
    let mut trains = Trains {
        on,
        looped,
        events: Vec::with_capacity(8_192),
        seen: 0,
        lost: 0,
        unmade: false,
        last: Time::ZERO,
    };
    trains.wait_until_quiet(SETTLE)?;
    let mut found = Counts::default();
    let mut wanted = SLOWEST;
    while wanted <= FASTEST {
        let (mut counted, mut slowest) = (true, u64::MAX);
        for _ in 0..repeats {
            if stop.load(Ordering::Relaxed) {
                return if found.trains.is_empty() { Err(LoopFault::Interrupted) } else { Ok(found) };
            }
            let Some(train) = trains.drive(wanted)? else { return Ok(found) };
            found.trains.push(train);
            counted &= train.is_counted();
            slowest = slowest.min(train.hz);
            found.made_hz = found.made_hz.max(train.hz.min(wanted));
        }
        let train = found.trains.last().copied().filter(|_| repeats > 0);
        if !counted {
            found.is_limit = true;
            return Ok(found);
        }
        found.counted_hz = found.counted_hz.max(slowest.min(wanted));
        // What cannot be made as fast as this cannot be made faster.
        if train.is_none_or(|train| !train.is_made()) {
            return Ok(found);
        }
        wanted = wanted * STEP.0 / STEP.1 + 1;
    }
    Ok(found)
}

/// A board whose loop carries trains.
struct Trains<'a> {
    on: Instrument<'a>,
    looped: LoopbackPair,
    events: Vec<BoardEvent>,
    seen: u32,
    lost: u32,
    /// Edges of the output were taken back before the device came to them.
    unmade: bool,
    /// When something of the loop came last.
    last: Time,
}

impl Trains<'_> {
    fn now(&self) -> Time {
        self.on.lives.time.now()
    }

    /// Takes what the board has to report.
    fn poll(&mut self) -> Result<(), LoopFault> {
        self.on.beat()?;
        self.events.clear();
        let now = self.now();
        self.on.board.poll(now, &mut self.events)?;
        let one = self.looped.out == self.looped.input;
        for event in &self.events {
            match *event {
                BoardEvent::Changed { channel, origin, .. } => {
                    let out = channel == self.looped.out && (one || origin == Origin::Write);
                    let input = channel == self.looped.input;
                    self.seen += u32::from(input);
                    if out || input {
                        self.last = now;
                    }
                }
                // It was never on the wire.
                BoardEvent::Dropped { channel, .. } if channel == self.looped.out && !one => {
                    self.unmade = true;
                }
                BoardEvent::Dropped { count, channel, .. } => {
                    self.lost = self.lost.saturating_add(count);
                    if channel == self.looped.input {
                        self.last = now;
                    }
                }
                BoardEvent::Lost { reason, .. } if reason != LossReason::Injected => {
                    return Err(LoopFault::Lost(reason));
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Waits until nothing has come for so long.
    fn wait_until_quiet(&mut self, quiet: Span) -> Result<(), LoopFault> {
        self.last = self.now();
        loop {
            self.poll()?;
            let due = self.last + quiet;
            if self.now() >= due {
                (self.seen, self.lost, self.unmade) = (0, 0, false);
                return Ok(());
            }
            self.on.wait(due);
        }
    }

    /// One train, and what came of it; `None` where the output cannot make it.
    fn drive(&mut self, hz: u64) -> Result<Option<Train>, LoopFault> {
        let half = i64::try_from(500_000_000 / hz.max(1)).unwrap_or(i64::MAX).max(1);
        let fit = u32::try_from(LASTS.as_nanos() / (2 * half)).unwrap_or(u32::MAX).max(2);
        let edges = 2 * PULSES.min(fit);
        let began = self.now();
        let emits = self.on.board.channels().get(usize::from(self.looped.out.0)).and_then(|out| out.emits);
        let mut ended = began;
        let own = match emits {
            Some(emits) => {
                let pulses: Arc<[Span]> =
                    (0..i64::from(edges)).map(|edge| Span::from_nanos(edge * half)).collect();
                let emission = Emission::Pulses(pulses);
                if emits.check(&emission).is_err() {
                    return Ok(None);
                }
                self.on.board.emit(began, self.looped.out, &emission)?;
                // It is as fast as its clock.
                ended = began + Span::from_nanos(half * i64::from(edges));
                true
            }
            None => {
                for edge in 0..edges {
                    self.wait_for(began + Span::from_nanos(half * i64::from(edge)), edge % LOOK == 0)?;
                    ended = self.now();
                    let level = Value::Bool(edge % 2 == 0);
                    self.on.board.write(ended, &[(self.looped.out, level)])?;
                }
                false
            }
        };
        let (first, last) = self.count_until_quiet(ended)?;
        // Made when the device had driven it, where that is reported, else when it was asked for.
        let lasted =
            if own { ended - began } else { (last.max(ended) - first.min(began)).max(ended - began) };
        let periods = u128::from(edges - 1);
        let nanos = u128::try_from(lasted.as_nanos()).unwrap_or(0).max(1);
        let reached = u64::try_from(periods * 500_000_000 / nanos).unwrap_or(u64::MAX);
        let (seen, lost, unmade) = (self.seen, self.lost, self.unmade);
        self.wait_until_quiet(Span::ZERO)?;
        if unmade {
            return Ok(None);
        }
        Ok(Some(Train { wanted_hz: hz, hz: if own { hz } else { reached.min(hz) }, made: edges, seen, lost }))
    }

    /// Takes edges until none came for a while: the first and the last call that drove the output.
    fn count_until_quiet(&mut self, ended: Time) -> Result<(Time, Time), LoopFault> {
        let (mut first, mut last) = (Time::MAX, Time::ZERO);
        self.last = ended.max(self.now());
        loop {
            self.poll()?;
            let calls = self.events.iter().filter_map(|event| match *event {
                BoardEvent::Changed { channel, at, origin: Origin::Write, .. }
                    if channel == self.looped.out =>
                {
                    Some(at)
                }
                _ => None,
            });
            for at in calls {
                (first, last) = (first.min(at.earliest), last.max(at.latest));
            }
            let due = self.last + QUIET;
            if self.now() >= due {
                return Ok((first, last));
            }
            self.on.wait(due);
        }
    }

    /// Lets time pass up to an instant, looking at the board where there is time, or where it has to be looked at.
    fn wait_for(&mut self, until: Time, look: bool) -> Result<(), LoopFault> {
        if look {
            self.poll()?;
        }
        while self.now() < until {
            self.on.lives.bell.wait_until(self.on.lives.time.stamp(until.min(self.now() + LONGEST_WAIT)));
            if self.now() < until {
                self.poll()?;
            }
        }
        Ok(())
    }
}

/// Whether a loop can be measured like this.
///
/// # Errors
/// What its channels lack.
pub fn is_countable(board: &dyn drivers::Board, looped: LoopbackPair) -> Result<(), BoardError> {
    let known = |channel: ChannelId| {
        board.channels().get(usize::from(channel.0)).ok_or(BoardError::NoChannel(channel))
    };
    let (out, input) = (known(looped.out)?, known(looped.input)?);
    if !out.drives && out.emits.is_none_or(|emits| emits.counted == Span::ZERO) {
        return Err(BoardError::NotDriven(looped.out));
    }
    if !input.is_digital() || !input.senses {
        return Err(BoardError::BadValue(looped.input));
    }
    Ok(())
}
