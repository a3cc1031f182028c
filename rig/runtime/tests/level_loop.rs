//! A level loop: a PI controller in Structured Text against a tank of the board, compared with an integration of its own in
//! steps of a microsecond.
//!
//! The integration knows nothing of courses, closed forms or events. It takes over what a loop on the bench has by its documents:
//!
//! - **Samples.** The transmitter shows its current every 7 ms, counted from power-on, which is `sample` of its plant. A cycle of
//!   MAST reads what was shown last, so up to 7 ms old. Both at one instant: the board changes before the controller reads.
//! - **Reading.** The bus cycle reads its inputs as MAST begins a cycle, every 20 ms from `start`, which is 1.5 s after power-on
//!   (decision 81). TM3AI4 has no conversion time in the catalogue: it converts as it is read.
//! - **Rounding.** 12 bit are 4095 steps from 4 to 20 mA; a current is rounded to a step and the step to a word, halves away from
//!   zero (decision 82). The output is rounded the same way back.
//! - **Writing.** The word goes out as the cycle ends: after the processor time of the program, [`CYCLE_TIME`]. TM3AQ2 has no
//!   delay in the catalogue.
//! - **Travel.** The positioner passes a current on at once; the valve moves evenly, from end to end in its `travel`.
//! - **Inflow.** A tank whose outflow goes with its level takes the samples of the valve's opening, one every millisecond; any
//!   other one takes the opening as it is (decision 84).

use scanrig_runtime::{ClockKind, RunOptions};
use signal::{Time, Value};
use std::sync::atomic::AtomicBool;

use crate::texts::Texts;

const PROGRAM: &str = "PROGRAM MAIN
VAR
    run AT %IX0.0 : BOOL;
    level AT %IW2 : INT;
    valve AT %QW2 : INT;
    error, share, integral, opening : REAL;
END_VAR
IF run THEN
    error := 1000.0 - INT_TO_REAL(level);
    share := 0.4 * error;
    IF NOT (opening >= 100.0 AND error > 0.0) AND NOT (opening <= 0.0 AND error < 0.0) THEN
        integral := integral + share * 0.02 / 4.0;
    END_IF
    opening := LIMIT(0.0, share + integral, 100.0);
END_IF
valve := REAL_TO_INT(10.0 * opening);
END_PROGRAM
";

const PLAN: &str = r#"format = 1
title = "A level loop"
program = "level.st"
board = "board.toml"
ends = "start + 45 s"
signals = { run = "%IX0.0", level = { channel = "level", record = true }, valve = { channel = "M2.QW0", record = true } }
steps = [{ id = "run", at = "start + 1013 ms", set = { signal = "run", value = true } }]
expect = [{ state = { stays = "RUNNING" } }]
[settings]
filter = "0 ms"
mast = { interval = "20 ms" }
[[settings.modules]]
type = "TM3AI4"
inputs = [{ mode = "4..20 mA", min = 0, max = 2000 }]
[[settings.modules]]
type = "TM3AQ2"
outputs = [{ mode = "4..20 mA", min = 0, max = 1000 }]
"#;

const BOARD: &str = r#"format = 1
[board]
kind = "simulated"
[channels]
"M1.IW0" = { kind = "analog", unit = "mA" }
"M2.QW0" = { kind = "analog", unit = "mA" }
demand = { kind = "analog", unit = "%" }
opening = { kind = "analog", unit = "%" }
level = { kind = "analog", unit = "m" }
[[plants]]
kind = "transmitter"
name = "positioner"
input = "M2.QW0"
output = "demand"
range = "4 .. 20 mA"
signal = "0 .. 100 %"
sample = "1 ms"
[[plants]]
kind = "valve"
name = "valve"
input = "demand"
travel = "500 ms"
output = "opening"
sample = "1 ms"
[[plants]]
kind = "tank"
name = "tank"
area = "0.01 m2"
height = "2 m"
inflows = [{ channel = "opening", flow = "60 l/min" }]
outflows = [{ flow = "15 l/min"OUTFLOW }]
output = "level"
sample = "5 ms"
[[plants]]
kind = "transmitter"
name = "transmitter"
input = "level"
output = "M1.IW0"
range = "0 .. 2 m"
signal = "4 .. 20 mA"
limits = "3.8 .. 20.5 mA"
sample = "7 ms"
"#;

/// Microseconds: from power-on to `start`, from one cycle to the next, between samples of the transmitter, to the step `run`.
const START: i64 = 1_500_000;
const CYCLE: i64 = 20_000;
const SAMPLE: i64 = 7_000;
const RUN: i64 = START + 1_013_000;
const END: i64 = START + 45_000_000;
/// Between two levels that the tank shows, in microseconds.
const SHOWN: i64 = 5_000;
/// From the beginning of a cycle to its end, in microseconds: the program's operations take a few of them.
const CYCLE_TIME: i64 = 5;

/// What both come to: settling within 20 mm of 1 m, the highest level, and the level at instants.
#[derive(Debug, Default)]
struct Response {
    /// Seconds since `run`.
    settled: f64,
    /// Metres.
    highest: f64,
    /// Microseconds since power-on, metres.
    levels: Vec<(i64, f64)>,
}

impl Response {
    fn take(&mut self, at: i64, level: f64) {
        if (level - 1.0).abs() > 0.02 {
            self.settled = (at - RUN) as f64 * 1e-6;
        }
        self.highest = self.highest.max(level);
    }

    fn level(&self, at: i64) -> f64 {
        self.levels.iter().take_while(|(shown, _)| *shown <= at).last().unwrap().1
    }
}

/// Rounds a quotient of whole numbers to the nearest, halves away from zero; both are above 0 here.
fn rounded(over: i64, under: i64) -> i64 {
    (2 * over + under) / (2 * under)
}

/// The word of a current in milliamperes: a step of 4095, then 2000 words.
fn word_of(milliamperes: f64) -> i64 {
    let parts = (milliamperes * 1e9).round() as i64;
    let step = rounded((parts - 4_000_000_000).max(0) * 4095, 16_000_000_000);
    rounded(step * 2000, 4095)
}

/// The part of its way that the positioner sends the valve to, of a word from 0 to 1000.
fn demand_of(word: i64) -> f64 {
    let step = rounded(word * 4095, 1000);
    rounded(step * 16_000_000_000, 4095) as f64 / 16e9
}

/// The loop in steps of a microsecond; `by_weight` has the outflow go with the root of the level.
fn integrated(by_weight: bool) -> Response {
    let mut response = Response::default();
    let (mut level, mut valve, mut demand) = (0.0_f64, 0.0_f64, 0.0_f64);
    let (mut shown_current, mut shown_valve) = (4.0_f64, 0.0_f64);
    let (mut integral, mut opening) = (0.0_f32, 0.0_f32);
    let mut written = (i64::MAX, 0.0_f64);
    for at in 0..=END {
        if at % SAMPLE == 0 {
            shown_current = (4.0 + 8.0 * level).clamp(3.8, 20.5);
        }
        if at % 1_000 == 0 {
            shown_valve = valve;
        }
        if at >= RUN {
            response.take(at, level);
            if at % SHOWN == 0 {
                response.levels.push((at, level));
            }
        }
        if at == written.0 {
            demand = written.1;
        }
        if at >= RUN && (at - START) % CYCLE == 0 {
            let error = 1000.0_f32 - word_of(shown_current) as f32;
            let share = 0.4_f32 * error;
            if !(opening >= 100.0 && error > 0.0 || opening <= 0.0 && error < 0.0) {
                integral += share * 0.02_f32 / 4.0_f32;
            }
            opening = (share + integral).clamp(0.0, 100.0);
            written = (at + CYCLE_TIME, demand_of((10.0 * opening).round_ties_even() as i64));
        }
        // A microsecond: the valve goes 1/500000 of its way, 1 l/s into 0.01 m2 are 0.1 m/s.
        let before = valve;
        valve += (demand - valve).clamp(-2e-6, 2e-6);
        let inflow = if by_weight { shown_valve } else { (before + valve) / 2.0 };
        let outflow = if by_weight { 0.25 * level.sqrt() } else { 0.25 };
        level = (level + 1e-7 * (inflow - outflow)).clamp(0.0, 2.0);
    }
    response
}

/// The same loop run by the executor.
fn run(by_weight: bool) -> Response {
    let outflow = if by_weight { ", at-level = \"1 m\"" } else { "" };
    let board = BOARD.replace("OUTFLOW", outflow);
    let texts = [("plan.toml", PLAN), ("level.st", PROGRAM), ("board.toml", board.as_str())];
    let interrupt = AtomicBool::new(false);
    let result = *Texts(&texts).run(1, &RunOptions::new(ClockKind::Virtual, &interrupt));
    let Some(trace) = result.trace else { panic!("{:#?}", result.record) };
    let (level, valve) = (trace.find("level").unwrap(), trace.find("valve").unwrap());
    let mut response = Response::default();
    let micros = |at: Time| at.as_nanos() / 1_000;
    for event in trace.events().map(Result::unwrap).filter(|event| micros(event.at.latest) <= END) {
        let at = micros(event.at.latest);
        if let (true, Value::Real(value)) = (event.signal == level, event.value) {
            if at >= RUN {
                response.take(at, value);
            }
            response.levels.push((at, value));
        }
        if event.signal == valve && at > RUN {
            // The word goes out as the cycle ends, which takes what the integration says.
            let after = event.at.latest.as_nanos() - START * 1_000;
            let late = after % (CYCLE * 1_000) - CYCLE_TIME * 1_000;
            assert!(late.abs() < 5_000, "{late} ns from {CYCLE_TIME} us after the cycle began");
        }
    }
    response
}

fn near(found: f64, expected: f64, tolerance: f64, what: &str) {
    let off = (found / expected - 1.0).abs();
    assert!(off < tolerance, "{what}: {found} by the rig, {expected} by the integration, {off:e} apart");
}

fn compare(by_weight: bool) {
    let (rig, own) = (run(by_weight), integrated(by_weight));
    // The rig's level is seen every 5 ms.
    near(rig.settled, own.settled, 1e-3, "settling time in s");
    near(rig.highest - 1.0, own.highest - 1.0, 1e-4, "overshoot in m");
    for tenth in 1..=10 {
        let at = RUN + tenth * 3_000_000 - 3_000;
        near(rig.level(at), own.level(at), 1e-5, &format!("level in m after {} s", tenth * 3));
    }
}

/// The outflow stays the same: the tank follows the valve between its samples, too.
#[test]
fn settling_and_overshoot_are_those_of_an_integration() {
    compare(false);
}

/// The outflow goes with the root of the level: the tank takes the samples of the valve.
#[test]
fn settling_and_overshoot_of_a_tank_that_empties_by_its_own_weight() {
    compare(true);
}
