//! The executor on real lines, with time and edges out of a script: what it waits for, when inputs count, when outputs
//! leave, and what lateness does to all this.

use crate::scripted::{ScriptBoard, ScriptClock, Shared};
use crate::texts::{Parted, Texts};
use controller::{Config, InputConfig};
use drivers::{BoardExt, ChannelId};
use profile::InputFilter;
use scanrig_runtime::executor::ExecutorReport;
use scanrig_runtime::executor::rig_fault::RigFault;
use signal::{Span, Time, Value};

/// The bench has a controller of the usual configuration, but inputs without a filter: a cycle each 20 ms.
const CYCLE: i64 = 20;

/// Counts the cycles in which it sees I0 high, and shows on Q4 whether it does.
const PROGRAM: &str = "PROGRAM MAIN
VAR
    seen AT %IX0.0 : BOOL;
    shown AT %QX0.4 : BOOL;
    n : DINT;
END_VAR
shown := seen;
IF seen THEN n := n + 1; END_IF;
END_PROGRAM
";

fn plan(rest: &str) -> String {
    format!(
        "format = 1
title = \"A lamp that follows a switch\"
program = \"follow.st\"
signals = {{ shown = \"%QX0.4\", n = \"MAIN.n\" }}
expect = [{{ state = {{ stays = \"RUNNING\", from = \"start\", until = \"end\" }} }}]
{rest}
"
    )
}

/// A case with its world.
struct Bench {
    world: Shared,
    model: scanrig_runtime::subject::model::ModelledController,
    parts: Parted,
}

impl Bench {
    fn new(rest: &str) -> Bench {
        Bench::of(PROGRAM, &plan(rest))
    }

    fn of(program: &str, plan: &str) -> Bench {
        let files = [("plan.toml", plan), ("follow.st", program)];
        let plain = |config: &mut Config| config.inputs = vec![InputConfig::filtered(InputFilter::None)];
        let (model, mut parts) = Texts(&files).parts_with(1, plain);
        let world = Shared::default();
        parts.board = Box::new(ScriptBoard::like(&*parts.board, &world));
        Bench { world, model, parts }
    }

    fn channel(&self, name: &str) -> ChannelId {
        self.parts.board.find(name).unwrap()
    }

    fn edge(&self, at: Time, high: bool) {
        self.world.lock().unwrap().edges.push_back((at, self.channel("I0"), high));
    }

    fn late(&self, at: Time, late: Span) {
        self.world.lock().unwrap().late.push_back((at, late));
    }

    fn run(&mut self) -> ExecutorReport {
        self.parts.run(&mut ScriptClock(self.world.clone()), &mut self.model)
    }

    /// When the lamp's channel was written to what.
    fn lamp(&self) -> Vec<(Time, Value)> {
        let lamp = self.channel("Q4");
        let world = self.world.lock().unwrap();
        let writes = world.writes.iter().filter(|write| write.1 == lamp);
        writes.map(|(at, _, value)| (*at, *value)).collect()
    }
}

/// Where the boot ends and the cycles begin, on this bench.
fn started() -> Time {
    let ran = Bench::new("ends = \"start + 1 ms\"").run();
    assert_eq!(ran.fault, None);
    ran.start.unwrap()
}

fn ms(n: i64) -> Span {
    Span::from_millis(n)
}

/// The start of a cycle that is well after the beginning.
fn cycle(start: Time) -> Time {
    // Found out from the bench: an output that changes does so a few us after its cycle's start.
    let mut bench = Bench::new("ends = \"start + 200 ms\"");
    bench.edge(start + ms(101), true);
    assert_eq!(bench.run().fault, None);
    let lamp = bench.lamp();
    let changed = lamp.iter().find(|(_, value)| *value == Value::Bool(true)).unwrap().0;
    let waits = &bench.world.lock().unwrap().waits;
    let releases = waits.iter().map(|wait| wait.0).filter(|due| due.as_nanos() % 1_000_000 == 0);
    releases.filter(|due| *due < changed).max().unwrap()
}

#[test]
fn an_edge_counts_for_the_next_cycle_and_not_for_one_that_was_due_before_it() {
    let start = started();
    let at = cycle(start);
    // 5 ms before a cycle, and 5 ms after its start while the rig is 15 ms late for it.
    for (edge, late, cycles_later) in [(at - ms(5), Span::ZERO, 0), (at + ms(5), ms(15), 1)] {
        let mut bench = Bench::new("ends = \"start + 200 ms\"");
        bench.edge(edge, true);
        bench.late(at, late);
        let ran = bench.run();
        assert_eq!(ran.fault, None);
        let lit = bench.lamp().into_iter().find(|(_, value)| *value == Value::Bool(true)).unwrap().0;
        let expected = at + ms(CYCLE * cycles_later);
        assert!(lit >= expected && lit < expected + ms(1), "lit at {lit}, the cycle is at {expected}");
    }
}

#[test]
fn a_pulse_between_two_scans_is_seen_by_neither_however_late_the_rig_is() {
    let start = started();
    let at = cycle(start);
    let mut bench = Bench::new("ends = \"start + 200 ms\"");
    bench.edge(at + ms(5), true);
    bench.edge(at + ms(8), false);
    bench.late(at, ms(15));
    assert_eq!(bench.run().fault, None);
    let lit = bench.lamp().into_iter().find(|(_, value)| *value == Value::Bool(true));
    assert_eq!(lit, None);
}

#[test]
fn a_pulse_is_counted_whose_edges_the_rig_sees_at_once() {
    let program = "PROGRAM MAIN
VAR
    simple : HSCSimple_M241;
END_VAR
simple(Enable := TRUE, HSC_REF_IN := HSC0);
END_PROGRAM
";
    let plan = "format = 1
title = \"A late rig counts\"
program = \"follow.st\"
settings = { filter = \"0 ms\", expert = { HSC0 = { kind = \"simple\", a = \"%IX0.0\", mode = \"modulo-loop\", modulo = 30000 } } }
signals = { n = \"HSC0.value\" }
ends = \"start + 200 ms\"
expect = [{ value = { of = \"n\", is = 3 } }]
";
    let start = started();
    // The rig wakes up for the first edge 10 ms late: it sees the first pulse as a whole, and the second one begin; and for the last
    // pulse 15 ms late, when a cycle was due that came after it.
    for (first, late) in [(101, 10), (113, 15)] {
        let mut bench = Bench::of(program, plan);
        for (n, at) in [101, 104, 107, 112, 113, 115].into_iter().enumerate() {
            bench.edge(start + ms(at), n % 2 == 0);
        }
        bench.late(start + ms(first), ms(late));
        assert_eq!(bench.run().fault, None);
        let trace = bench.parts.recorder.trace();
        let counted = trace.last(trace.find("n").unwrap()).unwrap().value;
        assert_eq!(counted, Value::Int(3), "{first} ms, {late} ms late");
    }
}

#[test]
fn a_step_that_waits_for_an_edge_begins_no_earlier_than_the_edge() {
    let start = started();
    // Seen 10 ms late, long after the last cycle.
    let mut bench = Bench::new(
        "ends = \"seen + 50 ms\"
steps = [{ id = \"seen\", when = { signal = \"%IX0.0\", edge = \"rises\", within = \"1 s\" } }]",
    );
    bench.edge(start + ms(115), true);
    bench.edge(start + ms(117), false);
    bench.late(start + ms(115), ms(10));
    let ran = bench.run();
    assert_eq!(ran.fault, None);
    let seen = ran.end - ms(50);
    assert!(seen >= start + ms(115) && seen <= start + ms(125), "{}", seen - start);
}

#[test]
fn nothing_ticks_while_nothing_is_to_be_done() {
    let mut bench = Bench::new("ends = \"start + 2 s\"");
    assert_eq!(bench.run().fault, None);
    let start = started();
    let world = bench.world.lock().unwrap();
    let waits = world.waits.iter().filter(|wait| wait.0 > start + ms(500) && wait.0 <= start + ms(1_500));
    let waits = waits.count();
    // 50 cycles: the release, the end of the cycle, what the controller does besides.
    assert!((50..=200).contains(&waits), "{waits} waits in 50 cycles");
}

#[test]
fn lateness_does_not_add_up() {
    let start = started();
    let at = cycle(start);
    let mut bench = Bench::new("ends = \"start + 1 s\"");
    for n in 0..20 {
        bench.late(at + ms(CYCLE * n), ms(n % 9));
    }
    // Seen by the cycle 400 ms later.
    bench.edge(at + ms(395), true);
    let ran = bench.run();
    assert_eq!(ran.fault, None);
    let lit = bench.lamp().into_iter().find(|(_, value)| *value == Value::Bool(true)).unwrap().0;
    assert!(lit >= at + ms(400) && lit < at + ms(401), "{lit}");
    let wakes = ran.wakes.unwrap();
    assert!(wakes.late >= 17 && wakes.max_ns == 8_000_000, "{wakes:?}");
    assert!(
        wakes.latest.iter().any(|wake| wake.at_ns == (at + ms(160)).as_nanos() && wake.late_ns == 8_000_000)
    );
}

#[test]
fn what_leaves_late_may_have_been_meant_earlier() {
    let start = started();
    let at = cycle(start);
    let mut bench = Bench::new("ends = \"start + 200 ms\"");
    bench.edge(at - ms(5), true);
    bench.late(at, ms(7));
    assert_eq!(bench.run().fault, None);
    let trace = bench.parts.recorder.trace();
    let shown = trace.find("shown").unwrap();
    let lit = trace.last(shown).unwrap();
    assert_eq!(lit.value, Value::Bool(true));
    // Written 7 ms late; the controller would have done so at its instant.
    assert!(lit.at.latest >= at + ms(7) && lit.at.earliest <= at + ms(1), "{:?}", lit.at);
    assert!(lit.at.earliest >= at - ms(1), "{:?}", lit.at);
}

#[test]
fn an_application_that_computes_stays_near_the_clock() {
    let rest = "ends = \"start + 300 ms\"
steps = [{ id = \"long\", at = \"start + 100 ms\", overload = { task = \"MAST\", cycle = \"8 ms\", times = 3 } }]";
    let start = started();
    let mut bench = Bench::new(rest);
    assert_eq!(bench.run().fault, None);
    // It waits at least once in each horizon of 100 us while a cycle of 8 ms computes, and not as often when none does.
    let world = bench.world.lock().unwrap();
    let due: Vec<Time> = world.waits.iter().map(|wait| wait.0).collect();
    let within = |from: Span, to: Span| {
        let all = due.windows(2).filter(move |pair| pair[0] >= start + from && pair[1] < start + to);
        all.map(|pair| pair[1] - pair[0]).filter(|gap| *gap <= Span::from_micros(100)).count()
    };
    assert!(within(ms(100), ms(180)) >= 3 * 75, "{}", within(ms(100), ms(180)));
    assert!(within(ms(200), ms(250)) < 40, "{}", within(ms(200), ms(250)));
}

/// A train of 10 ms on a line of the bench, while one wait ends so late.
fn train(late: Span) -> (ExecutorReport, Vec<(Time, Value)>, Time) {
    train_to("pulses.done + 50 ms", 20, late)
}

/// The same with another end of the case, and a wait that ends so late at so many milliseconds.
fn train_to(ends: &str, at: i64, late: Span) -> (ExecutorReport, Vec<(Time, Value)>, Time) {
    let rest = format!("ends = \"{ends}\"
steps = [{{ id = \"pulses\", at = \"start + 100 ms\", train = {{ signal = \"%IX0.1\", frequency = \"100 Hz\", count = 10 }} }}]");
    let rest = rest.as_str();
    let mut bench = Bench::new(rest);
    let begins = started() + ms(100);
    bench.late(begins + ms(at), late);
    let ran = bench.run();
    let line = bench.channel("I1");
    let world = bench.world.lock().unwrap();
    let writes = world.writes.iter().filter(|write| write.1 == line);
    (ran, writes.map(|(at, _, value)| (*at, *value)).collect(), begins)
}

#[test]
fn a_late_train_has_all_its_edges_none_of_them_close_together_and_catches_up() {
    let (ran, edges, begins) = train(ms(14));
    assert_eq!(ran.fault, None);
    let levels: Vec<Value> = edges.iter().map(|(_, value)| *value).collect();
    let planned: Vec<Value> = (0..20).map(|n| Value::Bool(n % 2 == 0)).collect();
    assert_eq!(levels, planned);
    // 5 ms apart as planned, and three quarters of that while it catches up.
    for pair in edges.windows(2) {
        assert!(pair[1].0 - pair[0].0 >= Span::from_micros(3_750), "{pair:?}");
    }
    assert_eq!(edges[4].0, begins + ms(34));
    assert_eq!(edges[5].0, begins + ms(34) + Span::from_micros(3_750));
    assert_eq!(edges[19].0, begins + ms(95));
}

#[test]
fn a_train_that_is_later_than_the_rig_may_be_is_trouble_of_the_rig() {
    // Each wait is in time for what is planned by then, but the train has fallen behind.
    let rest = "ends = \"pulses.done + 50 ms\"
steps = [{ id = \"pulses\", at = \"start + 100 ms\", train = { signal = \"%IX0.1\", frequency = \"100 Hz\", count = 8 } }]";
    let mut bench = Bench::new(rest);
    let begins = started() + ms(100);
    for n in 0..8 {
        bench.late(begins + ms(5 * n), ms(15));
    }
    let ran = bench.run();
    assert!(matches!(ran.fault, Some(RigFault::Late { .. })), "{:?}", ran.fault);
}

#[test]
fn a_case_does_not_end_before_what_its_train_owes() {
    // 10 ms late just before the end, which is that of the train.
    for (ends, edges) in [("pulses.done", 20), ("pulses + 70.1 ms", 15)] {
        let (ran, written, _) = train_to(ends, 65, ms(10));
        assert_eq!(ran.fault, None);
        assert_eq!(written.len(), edges, "{ends}");
    }
}
