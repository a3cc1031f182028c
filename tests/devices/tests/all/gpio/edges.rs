//! Every edge that was made is seen or reported lost.

use std::fs::File;
use std::os::unix::fs::FileExt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use super::bench::{Bench, Seen};
use devices::{Lab, Line, MAIN};
use drivers::{BoardEvent, TimestampSource};
use host::{Processors, Realtime, ThreadRole};
use signal::Value;

/// Moves a line as fast as the lab lets it; leaves it low. How long it took.
fn toggle(line: Line, edges: u32) -> Duration {
    let pull = File::options().write(true).open(line.pull_file()).unwrap();
    let begin = Instant::now();
    for edge in 0..edges {
        pull.write_all_at(if edge % 2 == 0 { b"pull-up" } else { b"pull-down" }, 0).unwrap();
    }
    begin.elapsed()
}

/// The accounts are settled: every edge that was made is a change or a loss. What became one edge with another may be
/// reported of another line of the chip, so that all count together. When an interrupt meets the kernel's thread just as
/// that takes the stamp of the one before, the kernel counts it twice: of edges that come as fast as that, a few more
/// can be reported as lost than were.
fn settled(bench: &mut Bench, made: u32) -> Seen {
    let of_all = |bench: &Bench| bench.seen("a") + bench.seen("b");
    bench.until(&format!("{made} edges are accounted for"), |bench| {
        let seen = of_all(bench);
        seen.changes + seen.dropped >= u64::from(made)
    });
    // Gaps that are still open would be reported by then.
    let due = Instant::now() + Duration::from_millis(300);
    bench.until("all gaps are reported", |_| Instant::now() >= due);
    let seen = of_all(bench);
    let more = seen.changes + seen.dropped - u64::from(made);
    assert!(more <= u64::from(made / 4), "{made} edges: {seen:?}");
    seen
}

/// The changes of a channel alternate, and their stamps never go back.
fn in_order(bench: &Bench, name: &str) {
    let id = bench.channel(name);
    let mut last = None;
    for event in &bench.events {
        let BoardEvent::Changed { channel, at, value: Value::Bool(high), .. } = event else { continue };
        if *channel == id {
            if let Some((before, level)) = last {
                assert!(at.latest >= before && *high != level, "{name} at {}", at.latest);
            }
            last = Some((at.latest, *high));
        }
    }
}

const TWO: &str = "a = { kind = \"digital\", line = 0 }\nb = { kind = \"digital\", line = 1 }";

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_hundred_thousand_edges_are_seen_or_reported_lost() {
    let _lab = Lab::enter();
    let mut bench = Bench::of_main("v2", TWO);
    bench.start();
    let (edges, other) = (100_000, 2_000);
    let fast = thread::spawn(move || toggle(MAIN.line(0), edges));
    let slow = thread::spawn(move || {
        for edge in 0..other {
            MAIN.line(1).pull(edge % 2 == 0);
        }
    });
    slow.join().unwrap();
    let took = fast.join().unwrap();
    let all = settled(&mut bench, edges + other);
    in_order(&bench, "a");
    in_order(&bench, "b");
    println!("figure: {edges} edges in {took:?}, {other} beside them: {all:?}");
    assert_eq!(bench.board.health().dropped, all.dropped);
    assert!(all.changes > 0 && bench.board.health().is_sound() == (all.dropped == 0));
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn slow_edges_are_all_seen_through_both_interfaces() {
    let _lab = Lab::enter();
    for backend in super::bench::BOTH {
        let mut bench = Bench::of_main(backend, TWO);
        bench.start();
        let edges = 1_000;
        for edge in 0..edges {
            MAIN.line(0).pull(edge % 2 == 0);
            bench.until_level("a", edge % 2 == 0);
        }
        let (seen, first) = (bench.seen("a"), bench.events.iter().take(6).collect::<Vec<_>>());
        assert_eq!((seen.changes, seen.dropped), (edges, 0), "{backend}: {first:?}");
        in_order(&bench, "a");
        assert!(bench.board.health().is_sound());
        let channel = &bench.board.channels()[usize::from(bench.channel("a").0)];
        // What the kernel does not count may be lost without a sign: the board says that it is no better than a line
        // that is looked at now and then.
        let sampled = matches!(channel.timestamp, TimestampSource::Sampled { .. });
        assert_eq!(sampled, backend == "v1");
    }
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn what_the_kernels_buffer_loses_is_reported() {
    let _lab = Lab::enter();
    // The edge thread stays on a processor that somebody with a higher priority keeps busy.
    let realtime = Realtime { processors: Processors::new([1]), ..Realtime::with_priority(40) };
    let mut bench = Bench::open_with(&Bench::main("v2", TWO), realtime);
    bench.start();
    let stop = Arc::new(AtomicBool::new(false));
    let hog = {
        let stop = stop.clone();
        thread::spawn(move || {
            let realtime = Realtime { processors: Processors::new([1]), ..Realtime::with_priority(90) };
            realtime.enter(ThreadRole::Scan).unwrap();
            let due = Instant::now() + Duration::from_secs(20);
            while !stop.load(Ordering::Relaxed) && Instant::now() < due {}
        })
    };
    let edges = 4_000;
    toggle(MAIN.line(0), edges);
    stop.store(true, Ordering::Relaxed);
    hog.join().unwrap();
    let seen = settled(&mut bench, edges);
    println!("figure: of {edges} edges behind a busy processor {seen:?}");
    assert!(seen.dropped > 0, "the kernel keeps 1024 edges: {seen:?}");
    assert!(!bench.board.health().is_sound());
}
