//! Pulses that the board makes by itself: one call in place of one write for each edge, and edges as the board reports them.

use crate::texts::{Parted, Texts};
use drivers::{
    Board, BoardError, BoardEvent, Channel, ChannelId, Emission, Health, Origin, PulseCapability,
    PulseOutputs, TimestampSource,
};
use scanrig_runtime::executor::ExecutorReport;
use scanrig_runtime::executor::clock::Clock;
use scanrig_runtime::executor::rig_fault::RigFault;
use scanrig_runtime::subject::model::ModelledController;
use signal::{Span, Time, Value, When};
use std::sync::{Arc, Mutex};

const US: fn(i64) -> Span = Span::from_micros;
const MS: fn(i64) -> Span = Span::from_millis;

/// What the board was asked for, and when.
#[derive(Clone, Debug, PartialEq)]
enum Asked {
    Write(Value),
    Emit(Emission),
}

#[derive(Debug, Default)]
struct World {
    now: Time,
    asked: Vec<(Time, String, Asked)>,
}

type Shared = Arc<Mutex<World>>;

/// A clock whose waits for a bell end after a millisecond.
#[derive(Debug)]
struct Ticks(Shared);

impl Clock for Ticks {
    fn wait_until(&mut self, due: Time) -> Time {
        let mut world = self.0.lock().unwrap();
        world.now = world.now.max(due);
        world.now
    }

    fn wait(&mut self, due: Time) -> Time {
        let now = self.0.lock().unwrap().now;
        self.wait_until(due.min(now + MS(1)))
    }

    fn rung(&mut self) -> bool {
        true
    }

    fn now(&mut self) -> Time {
        self.0.lock().unwrap().now
    }

    fn is_exact(&self) -> bool {
        false
    }

    fn name(&self) -> &'static str {
        "ticks"
    }
}

/// How long after it is asked the board begins, and how exactly it knows that.
const BEGINS: Span = Span::from_micros(3_000);
const KNOWN: Span = Span::from_micros(50);

/// A board whose channel `stream` counts its pulses and reports them when they are over, and whose channel `fan` has waves
/// without end, and levels, and reports nothing.
#[derive(Debug)]
struct Emitting {
    world: Shared,
    channels: Vec<Channel>,
    /// Edges that it loses from the end of a stream.
    loses: usize,
    reported: Vec<BoardEvent>,
}

impl Emitting {
    fn like(board: &dyn Board, world: &Shared, loses: usize) -> Emitting {
        let emits = PulseCapability {
            shortest: US(1),
            longest: Span::from_secs(1),
            resolution: US(1),
            counted: Span::ZERO,
            endless: true,
        };
        let real = |channel: &Channel| {
            let mut channel = Channel { timestamp: TimestampSource::Kernel, ..channel.clone() };
            match channel.name.as_str() {
                "stream" => {
                    channel.emits = Some(PulseCapability { counted: MS(32), endless: false, ..emits });
                    channel.drives = false;
                }
                "fan" | "Q0" => {
                    channel.emits = Some(emits);
                    channel.senses = false;
                    channel.max_pulse_hz = 0;
                }
                "Q1" => channel.max_pulse_hz = 1_000,
                "Q2" => channel.max_pulse_hz = 0,
                _ => {}
            }
            channel
        };
        let channels = board.channels().iter().map(real).collect();
        Emitting { world: world.clone(), channels, loses, reported: Vec::new() }
    }

    fn note(&self, now: Time, channel: ChannelId, asked: Asked) {
        let name = self.channels[usize::from(channel.0)].name.clone();
        self.world.lock().unwrap().asked.push((now, name, asked));
    }
}

impl Board for Emitting {
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
        for (channel, value) in writes {
            self.note(now, *channel, Asked::Write(*value));
        }
        Ok(())
    }

    fn poll(&mut self, now: Time, out: &mut Vec<BoardEvent>) -> Result<(), BoardError> {
        if self.reported.last().is_some_and(|last| last.latest() <= now) {
            out.append(&mut self.reported);
        }
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

    fn pulse_outputs(&mut self) -> Option<&mut dyn PulseOutputs> {
        Some(self)
    }
}

impl PulseOutputs for Emitting {
    fn emit(&mut self, now: Time, channel: ChannelId, emission: &Emission) -> Result<(), BoardError> {
        self.note(now, channel, Asked::Emit(emission.clone()));
        let known = &self.channels[usize::from(channel.0)];
        let emits = known.emits.ok_or(BoardError::NotEmitted(channel, drivers::NotEmitted::Nothing))?;
        emits.check(emission).map_err(|why| BoardError::NotEmitted(channel, why))?;
        if let Emission::Pulses(edges) = emission {
            for (n, after) in edges.iter().enumerate().take(edges.len() - self.loses) {
                let at = now + BEGINS + *after;
                let at = When::within(at, at + KNOWN);
                let value = Value::Bool(n % 2 == 0);
                self.reported.push(BoardEvent::Changed { channel, at, value, origin: Origin::Write });
            }
        }
        Ok(())
    }
}

const BOARD: &str = "\
format = 1
[board]
kind = \"simulated\"
[channels]
stream = { kind = \"digital\" }
fan = { kind = \"digital\" }
other = { kind = \"digital\" }
fed = { kind = \"digital\" }
[bind]
\"%IX0.3\" = \"stream\"
";

/// The same, and the stream is no input of the model.
fn free() -> String {
    BOARD.split("[bind]").next().unwrap().to_owned()
}

fn plan(steps: &str, rest: &str) -> String {
    format!(
        "format = 1
title = \"t\"
program-text = \"PROGRAM MAIN END_PROGRAM\"
board = \"board.toml\"
signals = {{ stream = \"stream\", fan = \"fan\", other = \"other\" }}
steps = [{steps}]
expect = [{{ state = {{ stays = \"RUNNING\", from = \"start\", until = \"end\" }} }}]
{rest}
"
    )
}

/// The parts of a case on such a board, or the codes of what does not fit it.
fn parts(
    board: &str,
    plan: &str,
    loses: usize,
) -> Result<(Shared, ModelledController, Parted), Vec<&'static str>> {
    let world = Shared::default();
    let table = "time [ms],stream\n0,0\n1,1\n3,0\n4,0\n";
    let files = [("plan.toml", plan), ("board.toml", board), ("table.csv", table)];
    let emitting = |board: Box<dyn Board>| Box::new(Emitting::like(&*board, &world, loses)) as Box<dyn Board>;
    match Texts(&files).parts_on(1, |_| {}, emitting) {
        Ok((model, parts)) => Ok((world, model, parts)),
        Err(found) => Err(found.iter().map(|found| found.code).collect()),
    }
}

struct Case {
    ran: ExecutorReport,
    start: Time,
    parts: Parted,
    asked: Vec<(Time, String, Asked)>,
}

fn run(steps: &str, rest: &str, loses: usize) -> Case {
    let (world, mut model, mut parts) = parts(&free(), &plan(steps, rest), loses).unwrap();
    let ran = parts.run(&mut Ticks(world.clone()), &mut model);
    let start = ran.start.unwrap();
    let mut world = world.lock().unwrap();
    let asked = world.asked.drain(..).filter(|(at, name, _)| *at >= start && !name.starts_with('Q'));
    Case { ran, start, parts, asked: asked.collect() }
}

impl Case {
    fn events(&self, name: &str) -> Vec<When> {
        let trace = self.parts.recorder.trace();
        let signal = trace.find(name).unwrap();
        let events = trace.events().map(Result::unwrap);
        events.filter(|event| event.signal == signal).map(|event| event.at).collect()
    }
}

const TRAIN: &str = "{ id = \"pulses\", at = \"start + 5 ms\", train = { signal = \"stream\", frequency = \"1 kHz\", count = 3 } },";

/// Three pulses that a board which begins at once has made 7.5 ms after the start.
#[test]
fn a_train_is_one_call_and_its_end_is_its_last_edge() {
    let late = "{ id = \"late\", when = { signal = \"stream\", edge = \"rises\", within = \"9 ms\" }, \
                set = { signal = \"other\", value = true } }";
    let case = run(&format!("{TRAIN}{late}"), "ends = \"pulses.done\"", 0);
    assert_eq!(case.ran.fault, None);
    let at = case.start + MS(5);
    let edges = [0, 500, 1_000, 1_500, 2_000, 2_500].map(US);
    let emitted = Asked::Emit(Emission::Pulses(Arc::from(edges)));
    // The end waits for the pulses; a step that waits for them comes too late.
    assert_eq!(case.asked, [(at, "stream".to_owned(), emitted)]);
    let seen = case.events("stream");
    assert_eq!(seen.len(), 6);
    assert_eq!(case.events("step:pulses.done"), [seen[5]]);
    let last = at + BEGINS + US(2_500) + KNOWN;
    assert_eq!(seen[5].latest, last);
    assert!(case.ran.end >= last && case.ran.end <= last + MS(2), "{}", case.ran.end);
}

#[test]
fn edges_that_the_board_does_not_report_in_time_are_the_rigs_trouble() {
    let case = run(TRAIN, "ends = \"pulses.done\"", 1);
    assert!(matches!(case.ran.fault, Some(RigFault::Late { .. })), "{:?}", case.ran.fault);
    // All that was reported, and no more: who drives the line meanwhile waits for nothing.
    assert_eq!(case.events("stream").len(), 5);
}

#[test]
fn a_wave_without_end_ends_with_its_step_with_the_case_and_with_what_drives_its_line() {
    let square = Emission::Square { period: MS(1), high: US(250) };
    let square = ("fan", Asked::Emit(square));
    let level = |on| ("fan", Asked::Write(Value::Bool(on)));
    let step = |rest: &str| {
        format!(
            "{{ id = \"wave\", at = \"start + 2 ms\", square = {{ signal = \"fan\", frequency = \"1 kHz\", \
             duty = \"25 %\"{rest} }} }},"
        )
    };
    let stops = "{ id = \"stop\", at = \"start + 4 ms\", set = { signal = \"fan\", value = true } }";
    for (steps, ends, expected) in [
        // Its step ends it within the high part of a period, and without: the level stays as it is there.
        (step(", duration = \"3200 us\""), "wave.done", vec![square.clone(), level(true)]),
        (step(", duration = \"3500 us\""), "wave.done", vec![square.clone(), level(false)]),
        (step(""), "start + 5 ms", vec![square.clone(), level(false)]),
        // Who drives last drives alone: nothing of the wave comes after it.
        (step(", duration = \"3200 us\"") + stops, "start + 9 ms", vec![square.clone(), level(true)]),
        (step("") + stops, "start + 9 ms", vec![square, level(true)]),
    ] {
        let case = run(&steps, &format!("ends = \"{ends}\""), 0);
        assert_eq!(case.ran.fault, None);
        let asked: Vec<_> = case.asked.iter().map(|(_, name, asked)| (&**name, asked.clone())).collect();
        assert_eq!(asked, expected, "{steps}");
    }
}

#[test]
fn a_table_of_one_line_is_emitted_whole() {
    let step = "{ id = \"rows\", at = \"start + 1 ms\", sequence = { file = \"table.csv\" } }";
    let case = run(step, "ends = \"rows.done\"", 0);
    assert_eq!(case.ran.fault, None);
    let emitted = Asked::Emit(Emission::Pulses(Arc::from([MS(1), MS(3)])));
    assert_eq!(case.asked, [(case.start + MS(1), "stream".to_owned(), emitted)]);
}

#[test]
fn what_a_channel_cannot_emit_is_refused_before_anything_moves() {
    let train =
        |rest: &str| format!("{{ id = \"x\", at = \"start\", train = {{ signal = \"stream\", {rest} }} }}");
    let square = |rest: &str| format!("{{ id = \"x\", at = \"start\", square = {{ signal = {rest} }} }}");
    for (step, code) in [
        (train("frequency = \"500 kHz\", count = 5"), None),
        (train("frequency = \"600 kHz\", count = 5"), Some("R0305")),
        (train("frequency = \"1 kHz\", count = 100"), Some("R0305")),
        (square("\"stream\", frequency = \"1 kHz\", count = 5"), None),
        (square("\"stream\", frequency = \"1 kHz\", duration = \"4 ms\""), None),
        (square("\"stream\", frequency = \"1 kHz\", duration = \"4200 us\""), Some("R0305")),
        (square("\"stream\", frequency = \"1 kHz\""), Some("R0305")),
        (square("\"fan\", frequency = \"1 kHz\", count = 5"), Some("R0305")),
        (square("\"fan\", frequency = \"1 kHz\", phase = \"90 deg\""), Some("R0305")),
        (square("\"fan\", period = \"2 s\""), Some("R0305")),
        (
            "{ id = \"x\", at = \"start\", encoder = { a = \"stream\", b = \"other\", moves = { by = 8, speed = \"1 kHz\" } } }"
                .to_owned(),
            Some("R0306"),
        ),
        ("{ id = \"x\", at = \"start\", set = { signal = \"stream\", value = true } }".to_owned(), Some("R0110")),
    ] {
        let found = parts(&free(), &plan(&step, "ends = \"start + 1 s\""), 0);
        assert_eq!(found.map(|_| ()).err(), code.map(|code| vec![code]), "{step}");
    }
    // What the model would see of pulses that are reported when they are over.
    let bound = plan(&train("frequency = \"1 kHz\", count = 5"), "ends = \"start + 1 s\"");
    assert_eq!(parts(BOARD, &bound, 0).err(), Some(vec!["R0307"]));
}

/// A controller whose PWM0 is on Q0.
fn with_pwm(program: &str, function: &str, rest: &str) -> String {
    format!(
        "format = 1
title = \"t\"
program-text = \"\"\"
PROGRAM MAIN
VAR wave : PWM_M241; on : BOOL := TRUE; f : UDINT := 10_000; s : BOOL; END_VAR
wave(PWM_REF_IN := PWM0, Enable := on, Frequency := f, Duty := 25, Sync := s);
END_PROGRAM
\"\"\"
board = \"board.toml\"
signals = {{ on = \"MAIN.on\", f = \"MAIN.f\", s = \"MAIN.s\", pulses = \"PWM0.pulses\", ready = \"MAIN.wave.InFrequency\" }}
settings = {{ expert = {{ PWM0 = {{ {function} }} }} }}
steps = [{program}]
expect = [{{ state = {{ stays = \"RUNNING\", from = \"start\", until = \"f\" }} }}]
{rest}
"
    )
}

/// What the model asked of the channel of Q0 after the start.
fn of_model(steps: &str) -> (ExecutorReport, Vec<(Time, Asked)>) {
    let plan = with_pwm(steps, "kind = \"pwm\", a = \"%QX0.0\"", "ends = \"start + 1 s\"");
    let (world, mut model, mut parts) = parts(&free(), &plan, 0).unwrap();
    let ran = parts.run(&mut Ticks(world.clone()), &mut model);
    let start = ran.start.unwrap();
    let mut world = world.lock().unwrap();
    let asked = world.asked.drain(..).filter(|(at, name, _)| *at >= start && name == "Q0");
    (ran, asked.map(|(at, _, asked)| (at, asked)).collect())
}

const CHANGE: &str = "{ id = \"f\", at = \"start + 300 ms\", write = { of = \"f\", value = 20_000 } },";

#[test]
fn the_models_pwm_is_made_by_the_board_and_reported_at_start_and_change_only() {
    let stop = "{ id = \"stop\", at = \"start + 600 ms\", command = \"stop\" }";
    let (ran, asked) = of_model(&format!("{CHANGE}{stop}"));
    assert_eq!(ran.fault, None);
    let what: Vec<_> = asked.iter().map(|(_, asked)| asked.clone()).collect();
    let square = |period| Asked::Emit(Emission::Square { period: US(period), high: US(period / 4) });
    let low = Asked::Write(Value::Bool(false));
    // The controller's output is at 0 until the program runs; outside RUNNING functions cease.
    let expected = [square(1_000), square(500), low];
    assert!(what.ends_with(&expected), "{what:?}");
    let start = ran.start.unwrap();
    let [first, change, stop] = [3, 2, 1].map(|n| asked[asked.len() - n].0);
    assert!(first <= start + MS(25), "{first}");
    assert!(change >= start + MS(300) && change <= start + MS(330), "{change}");
    assert!(stop >= start + MS(600) && stop <= start + MS(610), "{stop}");
}

#[test]
fn a_period_that_begins_anew_behind_a_device_is_the_rigs_trouble() {
    let sync = "{ id = \"sync\", at = \"start + 500 ms\", write = { of = \"s\", value = true } },";
    let (ran, _) = of_model(&format!("{CHANGE}{sync}"));
    assert!(matches!(ran.fault, Some(RigFault::PeriodNotRestarted { .. })), "{:?}", ran.fault);
}

// The board's longest period is 1 s.
#[test]
fn a_shape_that_the_device_does_not_have_ends_the_case() {
    let step = "{ id = \"f\", at = \"start + 300 ms\", write = { of = \"f\", value = 7 } },";
    let (ran, _) = of_model(step);
    assert!(matches!(ran.fault, Some(RigFault::Board { error: BoardError::NotEmitted(..), .. })), "{ran:?}");
}

#[test]
fn functions_that_a_line_cannot_do_are_refused_and_those_that_it_does_not_promise_are_reported() {
    let pto = |rest: &str| format!("kind = \"pto\", output = \"pulse\", {rest}");
    for (function, expected) in [
        ("kind = \"pwm\", a = \"%QX0.0\"".to_owned(), Ok(vec![])),
        ("kind = \"pwm\", a = \"%QX0.0\", sync = \"%IX0.0\"".to_owned(), Err(vec!["R0310"])),
        ("kind = \"pwm\", a = \"%QX0.1\", sync = \"%IX0.0\"".to_owned(), Ok(vec![])),
        ("kind = \"pwm\", a = \"%QX0.2\"".to_owned(), Ok(vec!["R0309"])),
        (pto("a = \"%QX0.0\""), Err(vec!["R0308"])),
        (pto("a = \"%QX0.1\", max-velocity = 1_000, start-velocity = 10"), Ok(vec![])),
        (pto("a = \"%QX0.1\", max-velocity = 1_001, start-velocity = 10"), Ok(vec!["R0309"])),
        (pto("a = \"%QX0.2\", max-velocity = 10, start-velocity = 10"), Ok(vec!["R0309"])),
    ] {
        let plan = with_pwm(CHANGE, &function, "ends = \"start + 1 s\"");
        let found = parts(&free(), &plan, 0);
        let warned = found.map(|(_, _, parts)| parts.warnings.iter().map(|found| found.code).collect());
        assert_eq!(warned, expected, "{function}");
    }
}
