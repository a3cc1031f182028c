//! Clients cost the scan no memory, and whoever does not listen costs it no time.

use super::{BOARD, PLAN, PROGRAM};
use crate::allocation::Noting;
use crate::texts::Texts;
use scanrig_runtime::live::{self, LiveRig};
use scanrig_runtime::scan_port::ScanPort;
use services::control::{Rig, RigOrder, Ticket};
use signal::{Time, Value};
use std::sync::atomic::{AtomicBool, Ordering};

/// The same program for a quarter of an hour.
fn plan() -> String {
    PLAN.replace("expect", "ends = \"start + 900 s\"\nexpect")
}

static NEVER: AtomicBool = AtomicBool::new(false);

fn rig(texts: &Texts<'_>) -> (LiveRig, ScanPort) {
    let (loaded, jobs) = texts.load(1);
    let case = loaded.plan.case(jobs[0].case).unwrap();
    let files = loaded.files(&case, &jobs[0]).unwrap();
    let (rig, port, _) = live::open(&case, &files, None, false, "0", None, &NEVER).unwrap();
    (rig, port)
}

/// Allocations of the scan from 30 s to 800 s of its time, with the client that `act` is.
fn allocations(act: impl FnOnce(LiveRig, &AtomicBool) -> LiveRig + Send) -> (u64, LiveRig) {
    let plan = plan();
    let texts = Texts(&[("plan.toml", &plan), ("lamp.st", PROGRAM), ("board.toml", BOARD)]);
    let (rig, mut port) = rig(&texts);
    let (mut model, mut parts) = texts.parts(1);
    let second = |n: i64| Time::from_nanos(n * 1_000_000_000);
    let mut clock =
        Noting { now: Time::ZERO, at: [second(10), second(30), second(800)], allocations: [None; 3] };
    let over = AtomicBool::new(false);
    let rig = std::thread::scope(|scope| {
        let client = scope.spawn(|| act(rig, &over));
        let ran = parts.serve(&mut clock, &mut model, Some(&mut port));
        over.store(true, Ordering::Relaxed);
        assert_eq!(ran.fault, None);
        client.join().unwrap()
    });
    let [_, Some(from), Some(to)] = clock.allocations else { panic!("{:?}", clock.allocations) };
    (to - from, rig)
}

#[test]
fn a_client_that_does_everything_costs_no_memory() {
    let (taken, _) = allocations(|mut rig, over| {
        let names =
            ["MAIN.count", "MAIN.flash", "MAIN.tick.ET", "beacon", "signal", "state", "%MW7", "LED.RUN.lit"];
        let signals = names.map(|name| rig.find(name).unwrap().number);
        let (output, count) = (rig.find("Q0").unwrap().number, signals[0]);
        let (mut ticket, mut heard) = (0, 0);
        while !over.load(Ordering::Relaxed) {
            signals.iter().for_each(|signal| rig.watch(*signal).unwrap());
            for order in [
                RigOrder::Force(output, Value::Bool(ticket % 2 == 0)),
                RigOrder::Write(count, Value::Int(ticket as i64 % 100)),
                RigOrder::Read(count),
                RigOrder::ReleaseAll,
            ] {
                ticket += 1;
                rig.order(Ticket(ticket), order).unwrap();
            }
            let asked = heard + 4;
            while heard < asked && !over.load(Ordering::Relaxed) {
                rig.poll(&mut |reported| {
                    heard += u64::from(matches!(reported, services::control::RigEvent::Answer(..)))
                });
            }
            signals.iter().for_each(|signal| rig.unwatch(*signal));
        }
        assert!(heard > 40, "only {heard} answers");
        rig
    });
    // A segment of the trace, which this case keeps, may be begun.
    assert!(taken <= 4, "{taken} allocations");
}

#[test]
fn one_that_never_listens_is_not_waited_for() {
    let (taken, mut rig) = allocations(|mut rig, over| {
        let signal = rig.find("MAIN.count").unwrap().number;
        rig.watch(signal).unwrap();
        rig.order(Ticket(1), RigOrder::Read(signal)).unwrap();
        while !over.load(Ordering::Relaxed) {
            std::thread::yield_now();
        }
        rig
    });
    assert!(taken <= 4, "{taken} allocations");
    // 45 000 cycles changed it; the queue holds less.
    let mut reported = 0;
    rig.poll(&mut |_| reported += 1);
    assert!((10_000..20_000).contains(&reported), "{reported}");
}
