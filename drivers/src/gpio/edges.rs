//! The thread that takes the edges of a chip from the kernel.

use std::os::fd::OwnedFd;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use host::{Bell, HostInstant, Realtime, ThreadRole};
use rtrb::{Consumer, Producer};
use rustix::event::{PollFd, PollFlags, poll};
use rustix::io::Errno;
use signal::Span;

use super::chip::{SharedChip, sources, timespec};
use super::port::{Edge, GpioPort};
use super::track::{Lost, Tracker};

/// Notes of edges on their way to the board.
const EDGES: usize = 8_192;
/// Edges that are read at once.
const BATCH: usize = 64;
/// How long a number may be missing: the kernel reports edges of different lines a little out of order.
const PATIENCE: Span = Span::from_millis(100);

/// An edge, or the loss of some, on its way to the board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Note {
    pub(super) stamp: HostInstant,
    /// Edges of the line that were lost before it.
    pub(super) lost: u32,
    pub(super) input: u8,
    /// The level after the edge; `None` for a loss alone.
    pub(super) high: Option<bool>,
}

/// The edge thread's side of a chip.
#[derive(Debug)]
pub(super) struct Edges {
    port: Arc<dyn GpioPort>,
    shared: Arc<SharedChip>,
    notes: Producer<Note>,
    bell: Arc<Bell>,
    tracker: Tracker,
    /// The level after the last edge of each input.
    seen: u64,
    end: Arc<OwnedFd>,
    batch: Vec<Edge>,
}

impl Edges {
    /// The thread.
    pub(super) fn run(mut self, realtime: Realtime) {
        let _ = realtime.enter(ThreadRole::Edges);
        let port = self.port.clone();
        let end = self.end.clone();
        let mut waits: Vec<PollFd<'_>> =
            sources(&*port).map(|source| PollFd::from_borrowed_fd(source, PollFlags::IN)).collect();
        let sources = waits.len();
        waits.push(PollFd::new(&*end, PollFlags::IN));
        loop {
            let timeout = self.tracker.due().map(|due| timespec(due.remaining()));
            match poll(&mut waits, timeout.as_ref()) {
                Ok(_) | Err(Errno::INTR) => {}
                Err(error) => return self.give_up(&error.into()),
            }
            if self.shared.stopped() {
                return;
            }
            let mut reported = false;
            self.shared.reading.store(true, Ordering::Release);
            for (source, wait) in waits[..sources].iter_mut().enumerate() {
                let ready = wait.revents();
                wait.clear_revents();
                if ready.is_empty() {
                    continue;
                }
                self.batch.clear();
                match port.edges(source, &mut self.batch) {
                    Ok(()) => {}
                    Err(error) if error.kind() == std::io::ErrorKind::Interrupted => continue,
                    Err(error) => return self.give_up(&error),
                }
                let batch = std::mem::take(&mut self.batch);
                reported |= self.note(&batch);
                self.batch = batch;
            }
            self.shared.reading.store(false, Ordering::Release);
            reported |= self.settle();
            if reported {
                self.bell.ring();
            }
        }
    }

    /// Hands on edges that somebody else read.
    pub(super) fn take(&mut self, edges: &[Edge]) {
        if self.note(edges) {
            self.bell.ring();
        }
    }

    /// Hands on what was read.
    fn note(&mut self, edges: &[Edge]) -> bool {
        let mut touched = 0;
        for edge in edges {
            let (notes, shared) = (&mut self.notes, &*self.shared);
            let bit = 1u64 << (edge.input % 64);
            touched |= bit;
            self.seen = if edge.high { self.seen | bit } else { self.seen & !bit };
            let lost = self
                .tracker
                .see(edge, HostInstant::now, |gap| give(notes, shared, given_up(gap, HostInstant::now())));
            let note = Note { stamp: edge.stamp, lost, input: edge.input, high: Some(edge.high) };
            give(&mut self.notes, &self.shared, note);
        }
        // Levels first: who finds a line touched finds its level.
        self.shared.seen.store(self.seen, Ordering::Release);
        self.shared.touched.fetch_or(touched, Ordering::AcqRel);
        self.publish_open();
        !edges.is_empty()
    }

    /// Reports how many numbers are still to come; whoever waits for the last of them hears of it.
    fn publish_open(&self) {
        let open = self.tracker.open();
        // Nobody else writes it.
        let before = self.shared.open.load(Ordering::Relaxed);
        if open != before {
            self.shared.open.store(open, Ordering::Release);
            if open == 0 {
                self.shared.answer.ring();
            }
        }
    }

    /// Hands on what will not come any more.
    fn settle(&mut self) -> bool {
        let mut reported = false;
        while let Some(gap) = self.tracker.settle(HostInstant::now()) {
            give(&mut self.notes, &self.shared, given_up(gap, HostInstant::now()));
            reported = true;
        }
        self.publish_open();
        reported
    }

    /// The chip is gone, or its edges cannot be had.
    fn give_up(self, error: &std::io::Error) {
        tracing::debug!(%error, "edges of the device cannot be had");
        self.shared.failed.fetch_add(1, Ordering::Relaxed);
        self.shared.ends(error.raw_os_error().unwrap_or(Errno::NODEV.raw_os_error()));
        self.bell.ring();
        self.shared.answer.ring();
    }
}

fn given_up(gap: Lost, now: HostInstant) -> Note {
    Note { stamp: now, lost: gap.count, input: gap.line, high: None }
}

/// Hands on a note; one that finds no room is counted.
fn give(notes: &mut Producer<Note>, shared: &SharedChip, note: Note) {
    if notes.push(note).is_err() {
        let count = note.lost.saturating_add(u32::from(note.high.is_some()));
        shared.edge_overflows[usize::from(note.input) % 64].fetch_add(count, Ordering::Relaxed);
        shared.overflowed.store(true, Ordering::Release);
    }
}

/// The edge thread's side of a chip, and the board's end of its queue. `end` is readable when the thread is to stop.
pub(super) fn edges(
    port: Arc<dyn GpioPort>,
    shared: Arc<SharedChip>,
    bell: Arc<Bell>,
    end: Arc<OwnedFd>,
) -> (Edges, Consumer<Note>) {
    let (notes, noted) = rtrb::RingBuffer::new(EDGES);
    let batch = Vec::with_capacity(BATCH);
    (Edges { port, shared, notes, bell, tracker: Tracker::new(PATIENCE), seen: 0, end, batch }, noted)
}
