//! How long it takes from an output to an input: by stamps, and by counting the turns of a loop that drives itself.

use super::{Driven, Instrument, LoopFault};
use drivers::LoopbackPair;
use host::Histogram;
use signal::Span;
use std::sync::atomic::{AtomicBool, Ordering};

/// What many edges that went around the loop took.
#[derive(Clone, Debug)]
pub struct Loopback {
    /// From the rig's wish to the beginning of the device's call; empty where the board does not report the call.
    pub asked_to_call: Histogram,
    /// From the beginning of the call, or of the wish, to the stamp of the input's edge.
    pub call_to_stamp: Histogram,
    /// From the stamp until the rig knew of it.
    pub stamp_to_seen: Histogram,
    /// Edges of the loop that drove itself.
    pub turns: u64,
    /// How long they took together.
    pub lasted: Span,
    /// Somebody ended it early.
    pub interrupted: bool,
}

impl Loopback {
    /// How long an edge took around the loop by counting alone: 1/(2f) of the wave that the loop drives itself. No
    /// stamp goes into it, and of the clock the length of the whole only.
    pub fn turn(&self) -> Option<Span> {
        let turns = i64::try_from(self.turns).ok()?;
        self.lasted.as_nanos().checked_div(turns).map(Span::from_nanos)
    }
}

/// Lets the loop drive itself: the output turns as soon as the input has followed, `count` times. Leaves the board
/// safe.
///
/// # Errors
/// Why it is no loop.
pub fn loopback(
    on: Instrument<'_>,
    looped: LoopbackPair,
    count: u64,
    stop: &AtomicBool,
) -> Result<Loopback, LoopFault> {
    let mut found = Loopback {
        asked_to_call: Histogram::new(),
        call_to_stamp: Histogram::new(),
        stamp_to_seen: Histogram::new(),
        turns: 0,
        lasted: Span::ZERO,
        interrupted: false,
    };
    let mut driven = Driven::start(on, looped)?;
    // The first edge finds out whether the wire inverts.
    driven.edge()?;
    let began = driven.now();
    while found.turns < count {
        if stop.load(Ordering::Relaxed) {
            found.interrupted = true;
            break;
        }
        let round = driven.edge()?;
        found.turns += 1;
        let from = match round.call {
            Some(call) => {
                found.asked_to_call.note((call.earliest - round.asked).as_nanos());
                call.earliest
            }
            None => round.asked,
        };
        found.call_to_stamp.note((round.stamped - from).as_nanos());
        found.stamp_to_seen.note((round.seen - round.stamped).as_nanos());
    }
    found.lasted = driven.now() - began;
    Ok(found)
}
