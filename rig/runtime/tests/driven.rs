//! Lines that a device drives a while after the command: the mark of a step ends when its lines were seen driven.

use crate::texts::{Parted, Texts};
use document::SourceFile;
use drivers::{Board, BoardError, BoardEvent, Channel, ChannelId, Health, Origin, TimestampSource};
use scanrig_runtime::executor::ExecutorReport;
use scanrig_runtime::executor::clock::Clock;
use scanrig_runtime::executor::rig_fault::RigFault;
use scanrig_runtime::subject::external::ExternalController;
use scanrig_runtime::subject::hook::Hook;
use scanrig_runtime::suite;
use signal::{Span, Time, Value, When};

const MILLISECOND: Span = Span::from_millis(1);

/// A clock whose waits for a bell end after a millisecond.
#[derive(Debug, Default)]
struct Ticks(Time);

impl Clock for Ticks {
    fn wait_until(&mut self, due: Time) -> Time {
        self.0 = self.0.max(due);
        self.0
    }

    fn wait(&mut self, due: Time) -> Time {
        self.0 = self.0.max(due.min(self.0 + MILLISECOND));
        self.0
    }

    fn rung(&mut self) -> bool {
        true
    }

    fn now(&mut self) -> Time {
        self.0
    }

    fn is_exact(&self) -> bool {
        false
    }

    fn name(&self) -> &'static str {
        "ticks"
    }
}

/// A board that drives its lines so long after the command.
#[derive(Debug)]
struct Slow {
    channels: Vec<Channel>,
    by: Span,
    reported: Vec<(Time, ChannelId, Value)>,
}

impl Board for Slow {
    fn inner(&self) -> Option<&dyn Board> {
        None
    }

    fn inner_mut(&mut self) -> Option<&mut dyn Board> {
        None
    }

    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn start(&mut self, _now: Time) -> Result<(), BoardError> {
        Ok(())
    }

    fn write(&mut self, now: Time, writes: &[(ChannelId, Value)]) -> Result<(), BoardError> {
        self.reported.extend(writes.iter().map(|(channel, value)| (now + self.by, *channel, *value)));
        Ok(())
    }

    fn poll(&mut self, now: Time, out: &mut Vec<BoardEvent>) -> Result<(), BoardError> {
        self.reported.retain(|(at, channel, value)| {
            let driven = *at <= now;
            if driven {
                let (channel, value, at) = (*channel, *value, When::exactly(*at));
                out.push(BoardEvent::Changed { channel, at, value, origin: Origin::Write });
            }
            !driven
        });
        Ok(())
    }

    fn next_event(&self) -> Option<Time> {
        None
    }

    fn safe(&mut self, _now: Time) -> Result<(), BoardError> {
        Ok(())
    }

    fn health(&self) -> Health {
        Health::default()
    }
}

const BOARD: &str = "\
format = 1
[board]
kind = \"simulated\"
[subject]
kind = \"external\"
boot = \"100 ms\"
";

const PLAN: &str = "\
format = 1
title = \"t\"
program-text = \"PROGRAM MAIN END_PROGRAM\"
board = \"board.toml\"
signals = { button = \"%IX0.0\", lamp = \"%QX0.4\" }
steps = [{ id = \"press\", at = \"start + 50 ms\", set = { signal = \"button\", value = true } }]
ends = \"press + 100 ms\"
expect = [{ stays = { signal = \"lamp\", is = false } }]
";

/// A case on a board that is so slow.
fn run(by: Span) -> (ExecutorReport, Parted) {
    run_plan(PLAN, by)
}

fn run_plan(plan: &str, by: Span) -> (ExecutorReport, Parted) {
    let (_, mut parts) = Texts(&[("plan.toml", plan), ("board.toml", BOARD)]).parts(1);
    let real = |channel: &Channel| Channel { timestamp: TimestampSource::Kernel, ..channel.clone() };
    let channels = parts.board.channels().iter().map(real).collect();
    parts.board = Box::new(Slow { channels, by, reported: Vec::new() });
    let file = drivers::read(&SourceFile::new("board.toml", BOARD), &suite::terminals).unwrap();
    let settings = file.subject.external.clone().unwrap();
    let running = controller::State::Running;
    let mut subject = ExternalController::new(&file, settings, &*parts.board, running, true, Hook::default());
    let ran = parts.run(&mut Ticks::default(), &mut subject);
    (ran, parts)
}

fn event(parts: &Parted, name: &str, value: Value) -> When {
    let trace = parts.recorder.trace();
    let signal = trace.find(name).unwrap();
    let mut events = trace.events().map(Result::unwrap);
    events.find(|event| event.signal == signal && event.value == value).unwrap().at
}

#[test]
fn the_mark_of_a_step_ends_when_its_lines_were_driven() {
    let (ran, parts) = run(Span::from_millis(7));
    assert_eq!(ran.fault, None);
    let (mark, line) =
        (event(&parts, "step:press", Value::Int(1)), event(&parts, "button", Value::Bool(true)));
    let start = ran.start.unwrap();
    assert_eq!(mark.earliest, start + Span::from_millis(50));
    assert!(mark.latest >= line.latest && mark.latest <= line.latest + MILLISECOND, "{mark:?} {line:?}");
}

#[test]
fn a_line_that_is_driven_too_late_is_the_rigs_trouble() {
    let (ran, _) = run(Span::from_millis(40));
    assert!(matches!(ran.fault, Some(RigFault::Late { .. })), "{:?}", ran.fault);
}

/// What counts the pulses of a train up to its end counts all of them.
#[test]
fn a_train_is_done_when_its_last_edge_was_driven() {
    let plan = PLAN
        .replace(
            "set = { signal = \"button\", value = true }",
            "train = { signal = \"button\", frequency = \"100 Hz\", count = 3 }",
        )
        .replace("press + 100 ms", "press.done + 50 ms");
    let (ran, parts) = run_plan(&plan, Span::from_millis(7));
    assert_eq!(ran.fault, None);
    let trace = parts.recorder.trace();
    let button = trace.find("button").unwrap();
    let edges: Vec<When> = trace
        .events()
        .map(Result::unwrap)
        .filter(|event| event.signal == button)
        .map(|event| event.at)
        .collect();
    let done = event(&parts, "step:press.done", Value::Int(1));
    // The level before the train is no edge.
    let last = edges.last().unwrap();
    assert_eq!(edges.len(), 6, "{edges:?}");
    assert!(done.earliest >= last.latest, "{done:?} {last:?}");
    assert!(done.latest <= last.latest + MILLISECOND + MILLISECOND, "{done:?} {last:?}");
}

/// A device that does not come to the end of a train in time is too late for it.
#[test]
fn the_last_edge_of_a_train_is_not_waited_for_without_end() {
    let plan = PLAN
        .replace(
            "set = { signal = \"button\", value = true }",
            "train = { signal = \"button\", frequency = \"20 Hz\", count = 3 }",
        )
        .replace("press + 100 ms", "press.done + 50 ms");
    let (ran, _) = run_plan(&plan, Span::from_millis(30));
    assert!(matches!(ran.fault, Some(RigFault::Late { .. })), "{:?}", ran.fault);
}
