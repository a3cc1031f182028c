//! What a change of the phases counts (io:STD-HSC-09).

use super::config::Phases;

/// Counts by `before << 2 | after`, each with A in bit 0 and B in bit 1.
pub(super) type Table = [i8; 16];

/// Both phases changed at once, which no encoder does.
pub(super) const ILLEGAL: i8 = i8::MAX;

/// The counts of two phases.
pub(super) fn of_phases(phases: Phases) -> Table {
    let (sign, edges) = match phases {
        Phases::UpDown => return table(|change| i8::from(change.rises(A)) - i8::from(change.rises(B))),
        Phases::PulseDirection => return table(|change| signed(change.rises(A), !change.after(B))),
        Phases::X1 => (1, 1),
        Phases::X2 => (1, 2),
        Phases::X4 => (1, 4),
        Phases::ReverseX1 => (-1, 1),
        Phases::ReverseX2 => (-1, 2),
        Phases::ReverseX4 => (-1, 4),
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
pub(super) fn of_one() -> Table {
    table(|change| i8::from(change.rises(A)))
}

/// How far the value is off for a pulse of a phase that was not seen.
pub(super) const fn weight(phases: Phases) -> u64 {
    match phases {
        Phases::X2 | Phases::ReverseX2 | Phases::X4 | Phases::ReverseX4 => 2,
        _ => 1,
    }
}

/// How far the value may be off for edges that are known to be missing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Lost {
    /// Every second of them counts.
    Pulses,
    /// As that for A; without those of B, pulses since its last edge may have counted the wrong way.
    Direction,
    /// Each second one hides the next, and until that is seen the other phase's edges count the wrong way: by turns, so
    /// that the value is off by so many for two of them at the most.
    Cycles(u64),
}

impl Lost {
    pub const fn of(phases: Option<Phases>) -> Lost {
        match phases {
            None | Some(Phases::UpDown) => Lost::Pulses,
            Some(Phases::PulseDirection) => Lost::Direction,
            Some(Phases::X4 | Phases::ReverseX4) => Lost::Cycles(4),
            Some(_) => Lost::Cycles(2),
        }
    }

    /// Counts by which so many missing edges of A may put it off.
    pub fn of_a(self, edges: u32) -> u64 {
        let pairs = u64::from(edges.div_ceil(2));
        match self {
            Lost::Pulses | Lost::Direction => pairs,
            Lost::Cycles(counts) => pairs * counts,
        }
    }

    /// The same for B, with so many pulses of A since its last edge that was seen.
    pub fn of_b(self, edges: u32, pulses: u64) -> u64 {
        match self {
            Lost::Direction => pulses.saturating_mul(2),
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

fn table(count: impl Fn(Change) -> i8) -> Table {
    std::array::from_fn(|change| count(Change(change)))
}
