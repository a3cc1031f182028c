//! Tasks of one priority take the processor in turn (controller:PRIO-02, M241 of 2014).

use super::Scheduler;
use super::task::Task;
use profile::TIME_SLICE;
use signal::{Span, Time};

/// Whose turn it is among the tasks of one priority, kept with the first of them.
#[derive(Clone, Copy, Debug)]
pub(super) struct TimeSlice {
    rank: usize,
    /// Processor time that is left of its slice.
    left: Span,
}

impl TimeSlice {
    /// Nobody's: the first one begins.
    pub(super) const NONE: TimeSlice = TimeSlice { rank: usize::MAX, left: Span::ZERO };
}

/// Tells each task which ranks share its priority.
pub(super) fn find_peers(tasks: &mut [Task]) {
    for rank in 0..tasks.len() {
        let priority = tasks[rank].priority;
        let peers = tasks.iter().enumerate().filter(|(_, task)| task.priority == priority);
        tasks[rank].peers = peers.fold(0, |mask, (peer, _)| mask | 1 << peer);
    }
}

impl Scheduler {
    /// The rank that gets the processor of those that want it: the highest priority, and within it the one whose turn
    /// it is. A turn ends with its slice and with the end of the task's cycle.
    #[inline]
    pub(super) fn chosen(&self, runnable: u32) -> usize {
        let top = runnable.trailing_zeros() as usize;
        let peers = self.tasks[top].peers & runnable;
        if peers & peers.wrapping_sub(1) == 0 {
            return top;
        }
        let turn = self.tasks[self.first_peer(top)].turn;
        let after = u32::try_from(turn.rank).map_or(0, |rank| peers & (!1u64 << rank) as u32);
        match turn.rank {
            rank if turn.left > Span::ZERO && rank < 32 && peers >> rank & 1 == 1 => rank,
            _ if after != 0 => after.trailing_zeros() as usize,
            _ => top,
        }
    }

    fn first_peer(&self, rank: usize) -> usize {
        self.tasks[rank].peers.trailing_zeros() as usize
    }

    /// The chosen task gets the processor up to `cap`, or to the end of its slice and of the operation under way.
    #[inline]
    pub(super) fn start_time_slice(&mut self, rank: usize, cap: Time) -> Time {
        if self.tasks[rank].peers.count_ones() == 1 {
            return cap;
        }
        let (first, at) = (self.first_peer(rank), self.at);
        let turn = &mut self.tasks[first].turn;
        if turn.rank != rank || turn.left == Span::ZERO {
            *turn = TimeSlice { rank, left: TIME_SLICE };
        }
        let end = at.saturating_add(turn.left);
        cap.min(self.in_flight.map_or(end, |until| until.max(end)))
    }

    /// The task's cycle is over, and with it its turn.
    pub(super) fn end_time_slice(&mut self, rank: usize) {
        self.use_time_slice(rank, TIME_SLICE);
    }

    /// Processor time passes for a task.
    #[inline]
    pub(super) fn use_time_slice(&mut self, rank: usize, used: Span) {
        let first = self.first_peer(rank);
        let turn = &mut self.tasks[first].turn;
        if turn.rank == rank {
            turn.left = (turn.left - used).max(Span::ZERO);
        }
    }
}
