//! Chips that went away and are there again: a thread of its own looks for them, claims their lines as before, has them
//! guarded, and hands them to the board.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;

use host::{Bell, HostInstant};
use rtrb::{Consumer, Producer, RingBuffer};
use signal::Span;

use super::chip::SharedChip;
use super::find::find_again;
use super::make::{Chip, Maker};
use crate::run_state::START;

/// How often a chip that is gone is looked for.
const EVERY: Span = Span::from_millis(100);

/// Chips on their way, for each chip of the board: it may go away again before the board has taken it.
const ON_THEIR_WAY: usize = 4;

/// A chip that is back, and its place among those of the board.
#[derive(Debug)]
pub(super) struct Reconnected {
    pub(super) at: usize,
    pub(super) chip: Chip,
}

/// The board's side.
#[derive(Debug)]
pub(super) struct Reconnector {
    shared: Arc<Signs>,
    pub(super) back: Consumer<Reconnected>,
    /// Chips that are done with: letting go of one may wait for its threads.
    pub(super) old: Producer<Chip>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Debug, Default)]
struct Signs {
    stop: AtomicBool,
    /// Wakes the thread.
    look: Bell,
    /// Wakes whoever waits for a chip.
    found: Bell,
}

/// The thread's side.
struct Search {
    maker: Maker,
    signs: Arc<Signs>,
    /// The chips as the board has them, or will when it has taken what is on its way.
    chips: Vec<Known>,
    back: Producer<Reconnected>,
    old: Consumer<Chip>,
}

struct Known {
    spec: usize,
    device: String,
    shared: Arc<SharedChip>,
    /// It was logged that it is looked for.
    is_looked_for: bool,
}

impl Known {
    fn of(chip: &Chip) -> Known {
        Known {
            spec: chip.spec,
            device: chip.device.clone(),
            shared: chip.lines.shared.clone(),
            is_looked_for: false,
        }
    }
}

impl Reconnector {
    /// Looks after these chips.
    pub(super) fn start(maker: Maker, chips: &[Chip]) -> std::io::Result<Reconnector> {
        let signs = Arc::new(Signs::default());
        let (give, back) = RingBuffer::new(chips.len() * ON_THEIR_WAY);
        let (old, done) = RingBuffer::new(chips.len() * (ON_THEIR_WAY + 1));
        let chips = chips.iter().map(Known::of).collect();
        let search = Search { maker, signs: signs.clone(), chips, back: give, old: done };
        let thread = std::thread::Builder::new().name(String::from("reconnect")).spawn(|| search.run())?;
        Ok(Reconnector { shared: signs, back, old, thread: Some(thread) })
    }

    /// Waits until a chip is on its way, at most until this stamp.
    pub(super) fn wait(&self, due: HostInstant) {
        self.shared.look.ring();
        if self.back.is_empty() {
            self.shared.found.wait_until(due);
        }
    }
}

impl Drop for Reconnector {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::Release);
        self.shared.look.ring();
        // One that hangs in a call on a device is left to it.
        let done = |thread: &JoinHandle<()>| thread.is_finished();
        let due = HostInstant::now() + EVERY;
        while self.thread.as_ref().is_some_and(|thread| !done(thread)) && HostInstant::now() < due {
            self.shared.found.wait_until(due);
        }
        if let Some(thread) = self.thread.take().filter(done) {
            let _ = thread.join();
        }
    }
}

impl Search {
    fn run(mut self) {
        while !self.signs.stop.load(Ordering::Acquire) {
            while self.old.pop().is_ok() {}
            for at in 0..self.chips.len() {
                let gone = self.chips[at].shared.is_gone();
                if gone && !std::mem::replace(&mut self.chips[at].is_looked_for, true) {
                    tracing::debug!(device = self.chips[at].device, "the device is looked for");
                }
                if gone
                    && !self.back.is_full()
                    && let Some(chip) = self.reconnect(at)
                {
                    tracing::info!(device = chip.device, "the device is there again");
                    self.chips[at] = Known::of(&chip);
                    // There is room.
                    let _ = self.back.push(Reconnected { at, chip });
                    self.signs.found.ring();
                    self.maker.context.bell.ring();
                }
            }
            self.signs.look.wait_until(HostInstant::now() + EVERY);
        }
        self.signs.found.ring();
    }

    /// The chip again, its outputs safe and guarded, its inputs read. `None` while it cannot be had.
    fn reconnect(&mut self, at: usize) -> Option<Chip> {
        let known = &self.chips[at];
        let found = find_again(&self.maker.file, &self.maker.spec, known.spec)?;
        let mut chip = self.maker.claim(found).ok()?;
        let start = chip.lines.ask_start();
        let due = HostInstant::now() + START;
        if !chip.lines.await_start(start, due) {
            return None;
        }
        // A board without a guard has nobody to ask.
        if let Some(output_guard) = &self.maker.context.output_guard {
            let held = chip.port.output_claims(&chip.device).ok()?;
            output_guard.upgrade()?.replace(&known.device, held).ok()?;
        }
        Some(chip)
    }
}
