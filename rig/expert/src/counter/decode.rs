//! What a change of the phases counts (io:STD-HSC-09).

use super::config::PhaseMode;

/// Counts by `before << 2 | after`, each with A in bit 0 and B in bit 1.
pub(super) type DecodeTable = [i8; 16];

/// Both phases changed at once, which no encoder does.
pub(super) const ILLEGAL: i8 = i8::MAX;

/// The counts of two phases.
pub(super) fn of_phases(phases: PhaseMode) -> DecodeTable {
    let (sign, edges) = match phases {
        PhaseMode::UpDown => return table(|change| i8::from(change.rises(A)) - i8::from(change.rises(B))),
        PhaseMode::PulseDirection => return table(|change| signed(change.rises(A), !change.after(B))),
        PhaseMode::X1 => (1, 1),
        PhaseMode::X2 => (1, 2),
        PhaseMode::X4 => (1, 4),
        PhaseMode::ReverseX1 => (-1, 1),
        PhaseMode::ReverseX2 => (-1, 2),
        PhaseMode::ReverseX4 => (-1, 4),
    };
    table(|change| {
        let (a, b) = (change.turns(A), change.turns(B));
        if a && b {
            return ILLEGAL;
        }
        // Forwards A comes before B: it turns away from B's level, and B turns to A's. A cycle of one count has it at
        // the edge of A while B is 0, in either direction, so that an edge that goes to and fro counts nothing.
        let counted = match edges {
            1 => a && !change.after(B),
            2 => a,
            _ => a || b,
        };
        let forwards = (change.after(A) != change.after(B)) == a;
        sign * signed(counted, forwards)
    })
}

/// The counts of one phase: its rising edges.
pub(super) fn of_one() -> DecodeTable {
    table(|change| i8::from(change.rises(A)))
}

/// How far the value is off for a pulse of a phase that was not seen.
pub(super) const fn weight(phases: PhaseMode) -> u64 {
    match phases {
        PhaseMode::X2 | PhaseMode::ReverseX2 | PhaseMode::X4 | PhaseMode::ReverseX4 => 2,
        _ => 1,
    }
}

/// How far the value may be off for edges that are known to be missing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MissedEdgeError {
    /// Every second of them counts.
    Pulses,
    /// As that for A; without those of B, pulses since its last edge may have counted the wrong way.
    Direction,
    /// Each second one hides the next, and until that is seen the other phase's edges count the wrong way: by turns, so
    /// that the value is off by so many for two of them at the most.
    Cycles(u64),
}

impl MissedEdgeError {
    pub const fn of(phases: Option<PhaseMode>) -> MissedEdgeError {
        match phases {
            None | Some(PhaseMode::UpDown) => MissedEdgeError::Pulses,
            Some(PhaseMode::PulseDirection) => MissedEdgeError::Direction,
            Some(PhaseMode::X4 | PhaseMode::ReverseX4) => MissedEdgeError::Cycles(4),
            Some(_) => MissedEdgeError::Cycles(2),
        }
    }

    /// Counts by which so many missing edges of A may put it off.
    pub fn of_a(self, edges: u32) -> u64 {
        let pairs = u64::from(edges.div_ceil(2));
        match self {
            MissedEdgeError::Pulses | MissedEdgeError::Direction => pairs,
            MissedEdgeError::Cycles(counts) => pairs * counts,
        }
    }

    /// The same for B, with so many pulses of A since its last edge that was seen.
    pub fn of_b(self, edges: u32, pulses: u64) -> u64 {
        match self {
            MissedEdgeError::Direction => pulses.saturating_mul(2),
            other => other.of_a(edges),
        }
    }
}

/// A change of the phases.
struct Change(usize);

const A: usize = 0;
const B: usize = 1;

impl Change {
    const fn after(&self, phase: usize) -> bool {
        self.0 >> phase & 1 == 1
    }

    const fn turns(&self, phase: usize) -> bool {
        (self.0 >> 2 ^ self.0) >> phase & 1 == 1
    }

    const fn rises(&self, phase: usize) -> bool {
        self.turns(phase) && self.after(phase)
    }
}

const fn signed(counts: bool, up: bool) -> i8 {
    match (counts, up) {
        (false, _) => 0,
        (true, true) => 1,
        (true, false) => -1,
    }
}

fn table(count: impl Fn(Change) -> i8) -> DecodeTable {
    std::array::from_fn(|change| count(Change(change)))
}
