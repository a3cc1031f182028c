//! A known square wave: before a run on real lines judges anything, the rig looks at what it makes itself.

use super::{Driven, Instrument, LoopFault};
use drivers::LoopbackPair;
use signal::Span;
use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};

/// Edges of the wave.
pub const EDGES: u64 = 40;

/// From one rise to the next.
pub const PERIOD: Span = Span::from_millis(10);

/// What came of a wave whose every edge was seen, once and in time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Square {
    /// Edges made and seen.
    pub edges: u64,
    /// The longest from the call that drove the output to the stamp of the input.
    pub stamped_within: Span,
    /// The longest from the stamp until the rig knew of it.
    pub seen_within: Span,
}

impl fmt::Display for Square {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Square { edges, stamped_within, seen_within } = self;
        write!(
            f,
            "{edges} edges came back, stamped within {stamped_within} and seen within {seen_within} more"
        )
    }
}

/// Drives a square wave of [`EDGES`] edges and compares what comes back with what was driven. Leaves the board safe.
///
/// # Errors
/// Why the board is no instrument.
pub fn square(on: Instrument<'_>, looped: LoopbackPair, stop: &AtomicBool) -> Result<Square, LoopFault> {
    let mut driven = Driven::start(on, looped)?;
    let mut found = Square { edges: 0, stamped_within: Span::ZERO, seen_within: Span::ZERO };
    let half = Span::from_nanos(PERIOD.as_nanos() / 2);
    let mut due = driven.now() + half;
    while found.edges < EDGES {
        if stop.load(Ordering::Relaxed) {
            return Err(LoopFault::Interrupted);
        }
        driven.quiet(due)?;
        let round = driven.edge()?;
        found.edges += 1;
        let began = round.call.map_or(round.asked, |call| call.earliest);
        found.stamped_within = found.stamped_within.max(round.stamped - began);
        found.seen_within = found.seen_within.max(round.seen - round.stamped);
        due += half;
    }
    // An edge that comes twice comes late.
    driven.quiet(due)?;
    Ok(found)
}
