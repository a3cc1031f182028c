//! The executor on real lines: scans that start on time whatever devices do, and go on without end in the memory that
//! they began with.

// A counting allocator cannot be written without: it hands on every call to the system's unchanged.
#![allow(unsafe_code)]

#[path = "executor/bench.rs"]
mod bench;
#[path = "executor/counting.rs"]
mod counting;
#[path = "../../../rig/runtime/tests/common/texts.rs"]
mod texts;

use std::sync::atomic::Ordering;
use std::time::Duration;

use bench::{Bench, Start};
use counting::{LOOKING, look};
use devices::{Call, Lab, MAIN, PATIENCE, wait_for};
use signal::Span;

const HANG: Duration = Duration::from_secs(1);

/// How late this share of some scans started at most.
fn share(starts: &[Start], percent: usize) -> Span {
    let mut late: Vec<Span> = starts.iter().map(|start| start.late).collect();
    late.sort_unstable();
    late[(late.len() - 1) * percent / 100]
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn scans_start_as_punctually_while_a_device_call_hangs() {
    let lab = Lab::enter();
    // A scan each 10 ms, whose output turns in each.
    let bench = Bench::new(Span::from_millis(10), 1, Span::from_secs(12));
    let progress = bench.progress.clone();
    let hang = || {
        let now = || progress.load(Ordering::Relaxed);
        let mut hung = Vec::new();
        wait_for("the scans", PATIENCE, || now() > 3_000_000_000);
        for turn in 1..=3i64 {
            lab.stall(MAIN, Call::Set, HANG, 1);
            wait_for("a call that hangs", PATIENCE, || lab.inside(MAIN, Call::Set) == 1);
            let from = now();
            wait_for("its end", PATIENCE, || lab.inside(MAIN, Call::Set) == 0);
            hung.push((from, now()));
            wait_for("more scans", PATIENCE, || now() > 3_000_000_000 + turn * 2_500_000_000);
        }
        hung
    };
    let (outcome, hung) = std::thread::scope(|scope| {
        let hanging = scope.spawn(hang);
        (bench.run(), hanging.join().unwrap())
    });
    let (mut during, mut other) = (Vec::new(), Vec::new());
    for start in outcome.starts.iter().filter(|start| start.due.as_nanos() > 2_000_000_000) {
        let at = start.due.as_nanos();
        let in_it = hung.iter().any(|(from, to)| (*from..*to).contains(&at));
        if in_it { &mut during } else { &mut other }.push(*start);
    }
    let worst = during.iter().map(|start| start.late).max().unwrap();
    println!(
        "\nfigure: {} scans started while a call hung, {} late in the median, {} for 90 %, {worst} at worst; \
         {} at other times: {} and {}",
        during.len(),
        share(&during, 50),
        share(&during, 90),
        other.len(),
        share(&other, 50),
        share(&other, 90),
    );
    // 3 s, less what it takes the test to see them.
    assert!(during.len() > 150, "{} scans", during.len());
    // Scans that had waited for the device would have been half a second later in the median, and nine tenths of one
    // for 90 %. How late they are without is the machine's affair.
    assert!(share(&during, 50) < share(&other, 50) * 2 + Span::from_millis(50));
    assert!(share(&during, 90) < share(&other, 90) * 2 + Span::from_millis(100));
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_hundred_thousand_scans_allocate_nothing_and_lose_no_edge_in_silence() {
    let lab = Lab::enter();
    lab.wire(MAIN.line(8), MAIN.line(0));
    // A scan each 400 us; the output turns in each 50th.
    let bench = Bench::new(Span::from_micros(400), 50, Span::from_secs(41));
    let (progress, counts) = (bench.progress.clone(), bench.counts.clone());
    let looking = || {
        let reached = |second: i64| progress.load(Ordering::Relaxed) > second * 1_000_000_000;
        let patience = Duration::from_secs(150);
        [6, 41].map(|second| {
            wait_for("more scans", patience, || reached(second));
            look()
        })
    };
    let (outcome, [first, last]) = std::thread::scope(|scope| {
        let looking = scope.spawn(looking);
        (bench.run(), looking.join().unwrap())
    });
    let (made, told) = counts.output();
    let (seen, lost) = counts.input();
    println!(
        "\nfigure: {} scans; {} asked for, {made} made, {told} taken back, {seen} seen, {lost} reported lost; \
         {} kB resident, {} kB locked",
        outcome.scans, outcome.asked, last.resident, last.locked
    );
    assert!(outcome.scans >= 100_000, "{} scans", outcome.scans);
    assert!(last.allocations - first.allocations <= LOOKING, "{first:?} {last:?}");
    assert!(last.resident <= first.resident + 256, "{first:?} {last:?}");
    assert!(last.locked <= first.locked + 256, "{first:?} {last:?}");
    // Back to its safe level at the end, where it was at the start.
    let driven_back = made % 2;
    assert_eq!(driven_back, 0, "{made} edges made");
    assert!(made > 1_000, "{made} edges made");
    // Seen or reported lost. A machine that stands still has edges told twice now and then, late ones behind their loss.
    assert!((made..=made + made / 10).contains(&(seen + lost)), "{made} made, {seen} seen, {lost} lost");
    // What a late rig asked for and took back before the device came to it is reported, too; at least some of it.
    assert!(made == outcome.asked || made + told <= outcome.asked && told > 0, "{} asked for", outcome.asked);
}
