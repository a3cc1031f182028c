//! What a scan of a GPIO board takes of its own: 16 outputs that all change, 16 inputs that all had an edge, with the
//! kernel's calls left out.
//!
//!     cargo bench -p scanrig-drivers --bench gpio
//!
//! One thread does all: what wakes one thread from the other is a call of the kernel, too, and reported by itself.

#[path = "../drivers/tests/fake/mod.rs"]
mod fake;

use std::io;
use std::os::fd::BorrowedFd;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use fake::LINES;
use host::HostInstant;
use rustix::time::{ClockId, clock_gettime};
use scanrig_drivers::gpio::{Backend, Edge, GpioPort, LineLevels, Served};
use scanrig_drivers::{Board, BoardContext, BoardEvent, BoardExt, ChannelId, GpioBoard, OutputClaim};
use signal::{Span, Time, Value};

const SCANS: u32 = 200_000;
const ROUNDS: usize = 15;

/// A chip whose calls take no time.
#[derive(Debug, Default)]
struct Stub {
    bits: AtomicU64,
}

impl GpioPort for Stub {
    fn backend(&self) -> Backend {
        Backend::V2
    }

    fn set(&self, bits: u64) -> io::Result<()> {
        self.bits.store(bits, Ordering::Relaxed);
        Ok(())
    }

    fn get(&self) -> io::Result<LineLevels> {
        Ok(LineLevels { bits: self.bits.load(Ordering::Relaxed), known: (1 << LINES) - 1 })
    }

    fn survey(&self) -> io::Result<LineLevels> {
        self.get()
    }

    fn source(&self, _number: usize) -> Option<BorrowedFd<'_>> {
        None
    }

    fn edges(&self, _source: usize, _out: &mut Vec<Edge>) -> io::Result<()> {
        Ok(())
    }

    fn output_claims(&self, _device: &str) -> io::Result<Vec<OutputClaim>> {
        Ok(Vec::new())
    }
}

/// What moves in each scan; the number is how many lines do, in sixteens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Moving {
    Nothing,
    Outputs,
    All,
}

/// The bench: a board, and who serves its chip.
struct Bench {
    board: GpioBoard,
    served: Served,
    at: BoardContext,
    /// Edges that every input has had.
    edges: u32,
}

impl Bench {
    fn new() -> Bench {
        let (file, found, at) = fake::parts("20 s");
        let (mut board, mut served) = GpioBoard::served(
            &file.channel_table(),
            fake::spec(&file),
            fake::limits(&file),
            &at,
            found,
            Arc::new(Stub::default()),
        )
        .expect("a board");
        let started = AtomicBool::new(false);
        // A start waits for the device.
        std::thread::scope(|scope| {
            scope.spawn(|| {
                while !started.load(Ordering::Acquire) {
                    served.turn();
                }
            });
            board.start(Time::ZERO).expect("a start");
            started.store(true, Ordering::Release);
        });
        Bench { board, served, at, edges: 0 }
    }

    /// Time of one scan in nanoseconds.
    fn round(&mut self, moving: Moving) -> f64 {
        let out = |line| self.board.find(&format!("o{line}")).expect("an output");
        let mut writes: Vec<(ChannelId, Value)> =
            (0..LINES).map(|line| (out(line), Value::Bool(false))).collect();
        let mut edges = [Edge { input: 0, high: false, stamp: HostInstant::BOOT, numbers: None }; LINES];
        let mut events: Vec<BoardEvent> = Vec::with_capacity(4 * LINES);
        let mut told = 0;
        // Times that lie ahead: asking for them is the executor's business.
        let now = self.at.time.now() + Span::from_secs(3_600);
        let stamp = self.at.time.stamp(now);
        let begin = spent();
        for scan in 0..SCANS {
            let high = moving != Moving::Nothing && scan % 2 == 0;
            for (_, value) in &mut writes {
                *value = Value::Bool(high);
            }
            self.board.write(now, &writes).expect("a write");
            self.served.turn();
            if moving == Moving::All {
                for (line, edge) in (0..).zip(&mut edges) {
                    let numbers = Some((self.edges * LINES as u32 + u32::from(line) + 1, self.edges + 1));
                    *edge = Edge { input: line, high, stamp, numbers };
                }
                self.edges += 1;
                self.served.take(&edges);
            }
            events.clear();
            self.board.poll(now, &mut events).expect("a poll");
            told += events.len();
        }
        let took = spent() - begin;
        assert!(self.board.health().is_sound(), "{:?}", self.board.health());
        assert!(told >= moving as usize * LINES * SCANS as usize, "{told} events");
        took / f64::from(SCANS)
    }
}

/// What this thread has spent, in nanoseconds: others that want the processor do not count.
fn spent() -> f64 {
    let spent = clock_gettime(ClockId::ThreadCPUTime);
    spent.tv_sec as f64 * 1e9 + spent.tv_nsec as f64
}

/// What one ring of a bell adds when somebody may be waiting: a call of the kernel, in nanoseconds.
fn ring() -> f64 {
    let bell = host::Bell::new();
    let begin = spent();
    for _ in 0..SCANS {
        bell.ring();
        bell.wait_until(HostInstant::BOOT);
    }
    (spent() - begin) / f64::from(SCANS)
}

/// What asking for the time takes, in nanoseconds: a scan in which outputs change asks twice.
fn clock() -> f64 {
    let begin = spent();
    for _ in 0..SCANS {
        std::hint::black_box(HostInstant::now());
    }
    (spent() - begin) / f64::from(SCANS)
}

fn main() {
    let mut bench = Bench::new();
    for moving in [Moving::Nothing, Moving::Outputs, Moving::All] {
        // The first round warms up.
        bench.round(moving);
        let mut rounds: Vec<f64> = (0..ROUNDS).map(|_| bench.round(moving)).collect();
        rounds.sort_by(f64::total_cmp);
        println!(
            "scan of {LINES} outputs and {LINES} inputs, {}: {:.0} ns (best {:.0}, worst {:.0} of {ROUNDS} rounds of {SCANS})",
            match moving {
                Moving::Nothing => "none of which changes",
                Moving::Outputs => "outputs change, inputs are read",
                Moving::All => "outputs change, inputs have an edge each",
            },
            rounds[ROUNDS / 2],
            rounds[0],
            rounds[ROUNDS - 1],
        );
    }
    println!(
        "of that each look at the clock {:.0} ns; beside it each ring that wakes a thread {:.0} ns",
        clock(),
        ring()
    );
}
