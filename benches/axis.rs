//! A pulse train of ten million pulses at up to 100 kHz, edge by edge as the controller takes it: trapezoid and S-curve.
//!
//! `cargo bench -p scanrig-expert --bench axis`. The exit code is 1 where one of them takes a second or more, or has
//! another number of pulses.

use scanrig_expert::{
    AxisConfig, BLOCKS, BlockCall, BlockPins, BlockType, ExpertConfig, ExpertEffect, ExpertFunctions,
    ExpertOperation, FunctionConfig, FunctionKind,
};
use signal::Time;
use std::hint::black_box;
use std::process::ExitCode;
use std::time::Instant;

/// The pulses of each train.
const PULSES: i64 = 10_000_000;
/// How long one may take, in seconds.
const MOST: f64 = 1.0;
/// Trains of each kind, of which the fastest counts.
const RUNS: usize = 5;

/// An instance of a block.
struct Block {
    block: &'static BlockType,
    pins: Values,
}

struct Values(Vec<i64>);

impl BlockPins for Values {
    fn get(&self, pin: usize) -> i64 {
        self.0.get(pin).copied().unwrap_or(0)
    }
    fn set(&mut self, pin: usize, value: i64) {
        if let Some(place) = self.0.get_mut(pin) {
            *place = value;
        }
    }
}

impl Block {
    fn new(name: &str, pins: &[(&str, i64)]) -> Option<Block> {
        let block = BLOCKS.iter().copied().flatten().find(|block| block.name == name)?;
        let mut values = Values(vec![0; block.pins.len()]);
        for (name, value) in pins {
            values.set(block.pins.iter().position(|pin| pin.name == *name)?, *value);
        }
        Some(Block { block, pins: values })
    }

    fn call(&mut self, now: Time, expert: &mut ExpertFunctions) {
        (self.block.run)(&mut BlockCall { now, pins: &mut self.pins, expert });
    }
}

/// Seconds of processor time so far, so that other work on the machine does not count; of real time where the kernel does
/// not report.
fn seconds(begin: Instant) -> f64 {
    let told = std::fs::read_to_string("/proc/self/schedstat").ok();
    let nanos = told.and_then(|text| text.split_ascii_whitespace().next()?.parse::<f64>().ok());
    nanos.map_or_else(|| begin.elapsed().as_secs_f64(), |nanos| nanos / 1e9)
}

/// Seconds that a train takes, and its pulses.
fn train(jerk_ratio: i64) -> Option<(f64, i64)> {
    let axis = FunctionConfig { name: "PTO0".into(), kind: FunctionKind::Axis(AxisConfig::new(0, 1)) };
    let mut expert = ExpertFunctions::new(&ExpertConfig { functions: vec![axis] }, &[]);
    expert.operate(Time::ZERO, ExpertOperation::Running);
    Block::new("MC_Power_PTO", &[("Axis", 1), ("Enable", 1)])?.call(Time::ZERO, &mut expert);
    let pins = [
        ("Axis", 1),
        ("Execute", 1),
        ("Distance", PULSES),
        ("Velocity", 100_000),
        ("Acceleration", 10),
        ("Deceleration", 10),
        ("JerkRatio", jerk_ratio),
    ];
    let begin = Instant::now();
    let start = seconds(begin);
    Block::new("MC_MoveRelative_PTO", &pins)?.call(Time::ZERO, &mut expert);
    let (mut pulses, mut last) = (0, Time::ZERO);
    while expert.next() < Time::MAX {
        expert.fire(expert.next());
        let mut place = 0;
        while let Some((at, effect)) = expert.take(place) {
            pulses += i64::from(effect == ExpertEffect::Output { output: 0, on: true });
            last = at;
            place += 1;
        }
    }
    black_box(last);
    Some((seconds(begin) - start, pulses))
}

fn main() -> ExitCode {
    let mut missed = false;
    for (name, jerk_ratio) in [("trapezoid", 0), ("S-curve", 100)] {
        let runs: Option<Vec<(f64, i64)>> = (0..RUNS).map(|_| train(jerk_ratio)).collect();
        let Some(runs) = runs else {
            println!("{name:10} a block or one of its pins is not there");
            return ExitCode::FAILURE;
        };
        let fastest = runs.iter().map(|(seconds, _)| *seconds).fold(f64::INFINITY, f64::min);
        let exact = runs.iter().all(|(_, pulses)| *pulses == PULSES);
        missed |= fastest >= MOST || !exact;
        println!(
            "{name:10} {fastest:6.3} s, {:5.1} ns an edge{}",
            fastest * 1e9 / (2 * PULSES) as f64,
            if exact { "" } else { ", and the wrong number of pulses" }
        );
    }
    if missed { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}
