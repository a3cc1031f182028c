//! How the rig is at an instant, as the scan leaves it for whoever asks.

use controller::{FrontPanel, JITTER_BORDERS, JitterCounts, State, TaskFigures};
use drivers::{BusState, Health, LossReason};
use signal::{Span, Time};

/// A snapshot. All that is in it stays where it is when it is filled again.
#[derive(Debug)]
pub struct Snapshot {
    /// The instant.
    pub at: Time,
    /// The controller's state.
    pub state: State,
    /// What it shows; nothing of a real controller.
    pub front: Option<FrontPanel>,
    /// What its tasks did, in the order of the configuration.
    pub tasks: Vec<(TaskFigures, JitterCounts)>,
    /// The channels of the board.
    pub lines: Vec<LineCounts>,
    /// Its buses.
    pub buses: Vec<BusCounts>,
    /// What it says of itself.
    pub health: Health,
    /// How late the rig was at worst, and what it drives.
    pub late: Span,
    /// See `late`.
    pub late_outputs: Span,
    /// How its waits ended.
    pub wakes: JitterCounts,
    /// Waits that ended later than the rig may be.
    pub overruns: u64,
    /// Events that found no room.
    pub untold: u64,
}

/// A channel of the board.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LineCounts {
    /// Rising edges.
    pub rising: u64,
    /// Falling edges.
    pub falling: u64,
    /// Its device is lost, and why.
    pub lost: Option<LossReason>,
}

/// A bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BusCounts {
    /// How its controller takes part.
    pub state: BusState,
    /// Its device is lost, and why.
    pub lost: Option<LossReason>,
    /// Frames or bytes from others.
    pub received: u64,
    /// Those of the rig.
    pub sent: u64,
    /// Errors.
    pub errors: u64,
    /// Frames that were missed.
    pub dropped: u64,
}

impl Clone for Snapshot {
    fn clone(&self) -> Snapshot {
        let mut other = Snapshot::new(self.tasks.len(), self.lines.len(), self.buses.len());
        other.clone_from(self);
        other
    }

    /// Takes no memory where both are of one rig.
    fn clone_from(&mut self, from: &Snapshot) {
        let Snapshot { tasks, lines, buses, .. } = self;
        tasks.clone_from(&from.tasks);
        lines.clone_from(&from.lines);
        buses.clone_from(&from.buses);
        let kept = (std::mem::take(tasks), std::mem::take(lines), std::mem::take(buses));
        let (tasks, lines, buses) = kept;
        *self = Snapshot { tasks, lines, buses, ..*from };
    }
}

impl Snapshot {
    /// Of a rig that has not begun, with so many tasks, channels and buses.
    pub fn new(tasks: usize, channels: usize, buses: usize) -> Snapshot {
        let traffic = BusCounts {
            state: BusState::ErrorActive,
            lost: None,
            received: 0,
            sent: 0,
            errors: 0,
            dropped: 0,
        };
        Snapshot {
            at: Time::ZERO,
            state: State::Off,
            front: None,
            tasks: vec![(TaskFigures::default(), JitterCounts::default()); tasks],
            lines: vec![LineCounts::default(); channels],
            buses: vec![traffic; buses],
            health: Health::default(),
            late: Span::ZERO,
            late_outputs: Span::ZERO,
            wakes: JitterCounts::default(),
            overruns: 0,
            untold: 0,
        }
    }
}

/// Each border with its count, up to the last one that counted anything; what is beyond all borders stands at the end of
/// time.
pub fn counts(counts: &JitterCounts) -> Vec<(i64, u64)> {
    let after = counts.iter().rposition(|count| *count > 0).map_or(0, |last| last + 1);
    let borders = JITTER_BORDERS.iter().copied().chain([i64::MAX]);
    borders.zip(counts.iter().copied()).take(after).collect()
}
