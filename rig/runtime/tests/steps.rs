//! Steps come when they should, each once.

use crate::common::events;
use crate::texts::Texts;
use record::Verdict;
use scanrig_runtime::{ClockKind, RunOptions};
use signal::{Span, Time};
use std::sync::atomic::AtomicBool;

const PLAN: &str = r#"
format = 1
title = "Steps depend on pulses of a train"
program-text = "PROGRAM MAIN END_PROGRAM"
signals = { in = "%IX0.0" }
ends = "train.pulse[5] + 10 ms"
steps = [
  { id = "train", at = "start + 100 ms", train = { signal = "in", frequency = "1 kHz", count = 8 } },
  { id = "one", at = "train.pulse[3]", mark = {} },
  { id = "two", at = "train.pulse[3] + 0.5 ms", mark = {} },
  { id = "three", at = "train.pulse[3]", mark = {} },
  { id = "after", at = "two.done + 1 ms", mark = {} },
]
expect = [{ edges = { signal = "in", rising = 8 } }]
"#;

#[test]
fn several_steps_hang_on_one_pulse() {
    let interrupt = AtomicBool::new(false);
    let result = Texts(&[("plan.toml", PLAN)]).run(1, &RunOptions::new(ClockKind::Virtual, &interrupt));
    crate::texts::expect(&result, Verdict::Pass);
    let trace = result.trace.unwrap();
    let events = events(&trace);
    let of = |name: &str| -> Vec<Time> {
        let signal = trace.find(name).unwrap();
        events.iter().filter(|event| event.signal == signal).map(|event| event.at.earliest).collect()
    };
    // The first event of the line is its level before the train.
    let rises: Vec<Time> = of("in").into_iter().skip(1).step_by(2).collect();
    let half = Span::from_micros(500);
    assert_eq!((of("step:one"), of("step:three")), (vec![rises[2]], vec![rises[2]]));
    assert_eq!(of("step:two"), [rises[2] + half]);
    assert_eq!(of("step:after"), [rises[2] + half + Span::from_millis(1)]);
    assert_eq!(of("step:end"), [rises[4] + Span::from_millis(10)]);
}

/// The verdict of a plan whose steps wait for what does not come, how many milliseconds after its start it ended, and how many its
/// teardown took.
fn without(steps: &str) -> (Verdict, i64, i64) {
    let plan = format!(
        "format = 1\nprogram-text = \"PROGRAM MAIN END_PROGRAM\"\nsignals = {{ in = \"%IX0.0\", lamp = \"%QX0.4\" }}\n\
         expect = [{{ stays = {{ signal = \"lamp\", is = false }} }}]\n{steps}\n"
    );
    let interrupt = AtomicBool::new(false);
    let result = Texts(&[("plan.toml", &plan)]).run(1, &RunOptions::new(ClockKind::Virtual, &interrupt));
    let trace = result.trace.unwrap();
    let events = events(&trace);
    let first = |name: &str| {
        let signal = trace.find(name)?;
        events.iter().find(|event| event.signal == signal).map(|event| event.at.earliest)
    };
    let (start, end) = (first("step:start").unwrap(), first("step:end").unwrap());
    let closed = first("step:teardown.done").unwrap_or(end);
    let milliseconds = |span: Span| span.as_nanos() / 1_000_000;
    (result.record.verdict, milliseconds(end - start), milliseconds(closed - end))
}

/// What steps wait for does not come, the end of the case counts from it, and other steps come after its limit or have no
/// end themselves.
#[test]
fn a_case_ends_when_nothing_of_it_can_come_any_more() {
    let lit =
        r#"{ id = "lit", when = { signal = "lamp", edge = "rises", from = "start", within = "500 ms" } }"#;
    let ends = |others: &str| {
        let (verdict, length, _) = without(&format!("steps = [{others} {lit}]"));
        assert_eq!(verdict, Verdict::Fail, "{others}");
        length
    };
    assert_eq!(ends(""), 500);
    // A second after the last step, if that is later than the limit.
    assert_eq!(
        ends(r#"{ id = "press", at = "start + 100 ms", set = { signal = "in", value = true } },"#),
        1100
    );
    assert_eq!(
        ends(r#"{ id = "press", at = "start + 800 ms", pulse = { signal = "in", width = "1 s" } },"#),
        2800
    );
    // Its limit lies after all others though it came.
    let long = r#"{ id = "press", at = "start + 100 ms", set = { signal = "in", value = true } },
        { id = "pressed", when = { signal = "in", edge = "rises", from = "start", within = "20 s" } },"#;
    assert_eq!(ends(long), 1100);
    let wave = r#"{ id = "wave", at = "start + 100 ms", square = { signal = "in", frequency = "2 Hz" } },"#;
    assert_eq!(ends(wave), 1100);
    let again = r#"{ id = "again", at = "start + 100 ms", every = { period = "200 ms", until = "lit" }, mark = {} },
        { id = "after", at = "again.done + 1 s", mark = {} },"#;
    assert_eq!(ends(again), 500);
    let group = format!(
        "steps = [{{ id = \"call\", at = \"start\", run = {{ group = \"g\" }} }}, {{ id = \"after\", at = \"call.done\", mark = {{}} }}]\n\
         [group.g]\nsteps = [{}, {{ id = \"late\", at = \"begin + 3 s\", mark = {{}} }}]",
        lit.replace("start", "begin")
    );
    let (verdict, length, _) = without(&group);
    assert_eq!((verdict, length), (Verdict::Fail, 4000));
}

/// A wave without an end, and a step that comes again until something that does not come.
#[test]
fn a_teardown_ends_when_nothing_of_it_can_come_any_more() {
    let wave = r#"teardown = [{ id = "wave", at = "teardown", square = { signal = "in", frequency = "2 Hz" } },
        { id = "last", at = "teardown + 1 s", mark = {} }]"#;
    let (verdict, _, teardown) = without(wave);
    assert_eq!((verdict, teardown), (Verdict::Pass, 1000));
    let again = r#"teardown = [{ id = "again", at = "teardown + 100 ms", every = { period = "200 ms", until = "lit" }, mark = {} },
        { id = "lit", when = { signal = "lamp", edge = "rises", from = "teardown", within = "500 ms" } }]"#;
    let (verdict, _, teardown) = without(again);
    assert_eq!((verdict, teardown), (Verdict::Fail, 500));
}
