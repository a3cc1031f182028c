//! What the phases of a scan take on a board: waking up, taking the inputs, the program, handing over the outputs.

use super::{Instrument, LoopFault};
use crate::instrument::standalone::StandaloneEnd;
use drivers::{BoardEvent, ChannelId, LossReason, Origin};
use host::Histogram;
use signal::{Span, Value};
use std::sync::atomic::{AtomicBool, Ordering};

/// What many scans took.
#[derive(Clone, Debug, Default)]
pub struct Phases {
    /// From the instant that a scan was due to its beginning.
    pub wake: Histogram,
    /// Taking what the board saw.
    pub inputs: Histogram,
    /// The program, on this machine.
    pub program: Histogram,
    /// Handing the outputs to the board.
    pub outputs: Histogram,
    /// All of it together, from the instant that the scan was due.
    pub whole: Histogram,
    /// The device's own calls that drove outputs, beside the scan.
    pub device: Histogram,
    /// Edges that never came about or were lost, for the device is slower than the scan.
    pub lost: u64,
    /// Scans that were left out, for the one before them ended later than they were due.
    pub missed: u64,
    /// Somebody ended it early.
    pub interrupted: bool,
}

/// Why scans could not be measured.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ScanFault {
    /// The board.
    Board(LoopFault),
    /// The program.
    Program(StandaloneEnd),
}

impl<E: Into<LoopFault>> From<E> for ScanFault {
    fn from(error: E) -> Self {
        ScanFault::Board(error.into())
    }
}

/// Scans `count` times, one every `interval`, as the executor does: waits, polls, runs `program`, writes. The outputs
/// in `driven` turn with every scan, no other one moves. Leaves the board safe.
///
/// # Errors
/// A board that loses devices; a program that fails.
pub fn phases(
    mut on: Instrument<'_>,
    [interval, count]: [i64; 2],
    driven: &[ChannelId],
    program: &mut dyn FnMut() -> Result<(), StandaloneEnd>,
    stop: &AtomicBool,
) -> Result<Phases, ScanFault> {
    on.start()?;
    let lives = on.lives;
    let mut found = Phases::default();
    let mut events: Vec<BoardEvent> = Vec::with_capacity(1024);
    let mut writes: Vec<(ChannelId, Value)> =
        driven.iter().map(|channel| (*channel, Value::Bool(false))).collect();
    let interval = Span::from_nanos(interval.max(1));
    let mut due = lives.time.now() + interval;
    let mut scans = 0;
    while scans < count {
        if stop.load(Ordering::Relaxed) {
            found.interrupted = true;
            break;
        }
        on.beat()?;
        // What the board has to report meanwhile belongs to this scan.
        while lives.time.now() < due {
            on.beat()?;
            on.wait(due);
        }
        let woke = lives.time.now();
        events.clear();
        on.board.poll(woke, &mut events)?;
        let polled = lives.time.now();
        for event in &events {
            match *event {
                BoardEvent::Changed { at, origin: Origin::Write, .. } if scans > 0 => {
                    found.device.note((at.latest - at.earliest).as_nanos());
                }
                BoardEvent::Dropped { count, .. } => found.lost += u64::from(count),
                BoardEvent::Lost { reason, .. } if reason != LossReason::Injected => {
                    return Err(LoopFault::Lost(reason).into());
                }
                _ => {}
            }
        }
        let ready = lives.time.now();
        program().map_err(ScanFault::Program)?;
        let ran = lives.time.now();
        let high = scans % 2 == 0;
        writes.iter_mut().for_each(|(_, value)| *value = Value::Bool(high));
        if !writes.is_empty() {
            on.board.write(ran, &writes)?;
        }
        let wrote = lives.time.now();
        found.wake.note((woke - due).as_nanos());
        found.inputs.note((polled - woke).as_nanos());
        found.program.note((ran - ready).as_nanos());
        found.outputs.note((wrote - ran).as_nanos());
        found.whole.note((wrote - due).as_nanos());
        scans += 1;
        due += interval;
        if wrote > due {
            let over = (wrote - due).as_nanos() / interval.as_nanos() + 1;
            found.missed += over.unsigned_abs();
            due += Span::from_nanos(over.saturating_mul(interval.as_nanos()));
        }
    }
    Ok(found)
}
