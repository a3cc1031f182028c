//! `input-delay` and `output-delay` of a board file: a change happened at the terminal earlier than its line showed it, or later
//! than its line was driven.

use crate::common::events;
use crate::texts::Texts;
use drivers::BoardExt;
use drivers::file::ChannelDelay;
use scanrig_runtime::executor::clock::VirtualClock;
use signal::{Event, Span};

const BOARD: &str = "format = 1
[board]
kind = \"simulated\"
[[wires]]
from = \"%QX0.4\"
to = \"I3\"
";
const PROGRAM: &str =
    "PROGRAM MAIN VAR on AT %IX0.0 : BOOL; lamp AT %QX0.4 : BOOL; END_VAR lamp := on; END_PROGRAM";
const PLAN: &str = "format = 1
program = \"p.st\"
board = \"board.toml\"
signals = { on = \"%IX0.0\", lamp = \"%QX0.4\", back = \"%IX0.3\" }
steps = [{ id = \"press\", at = \"start + 10 ms\", set = { signal = \"on\", value = true } }]
ends = \"start + 200 ms\"
expect = [{ rises = { signal = \"lamp\" } }]
";

fn seen(delays: &[(&str, (i64, i64), i64)]) -> Vec<(String, Event)> {
    let texts = Texts(&[("plan.toml", PLAN), ("p.st", PROGRAM), ("board.toml", BOARD)]);
    let (mut model, mut parted) = texts.parts(1);
    let us = Span::from_micros;
    let list: Vec<ChannelDelay> = delays
        .iter()
        .map(|(name, (least, most), after)| ChannelDelay {
            channel: parted.board.find(name).unwrap(),
            before: (us(*least), us(*most)),
            after: us(*after),
        })
        .collect();
    parted.wiring.delay(&list);
    let report = parted.run(&mut VirtualClock::default(), &mut model);
    assert_eq!(report.fault, None);
    let trace = parted.recorder.trace();
    let name = |event: &Event| trace.signals()[event.signal.0 as usize].name.clone();
    events(trace).into_iter().map(|event| (name(&event), event)).collect()
}

#[test]
fn a_delay_moves_and_widens_the_instants_of_its_channel_alone() {
    let (exact, delayed) = (seen(&[]), seen(&[("I3", (2, 18), 0), ("Q4", (0, 0), 25)]));
    assert_eq!(exact.len(), delayed.len());
    let mut moved = 0;
    for ((name, before), (_, after)) in exact.iter().zip(&delayed) {
        let (earliest, latest) = (after.at.earliest - before.at.earliest, after.at.latest - before.at.latest);
        let us = |nanos: Span| nanos.as_nanos() / 1_000;
        let expected = match name.as_str() {
            "back" => (-18, -2),
            "lamp" => (0, 25),
            _ => (0, 0),
        };
        assert_eq!((us(earliest), us(latest)), expected, "{name} {before:?} {after:?}");
        assert_eq!((before.signal, before.value, before.cause), (after.signal, after.value, after.cause));
        moved += usize::from(expected != (0, 0));
    }
    // What both lines are at first, and the edges.
    assert_eq!(moved, 5);
}
