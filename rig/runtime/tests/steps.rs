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
