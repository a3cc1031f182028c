//! How many edges a second the fast counters take: one after the other and in batches, behind delay and anti-bounce
//! filter, with four thresholds and two reflex outputs; and from the records of the kernel's GPIO lines.
//!
//!     cargo bench -p scanrig-expert --bench counter
//!
//! The exit code is 1 where a rate is below its floor.

use scanrig_expert::{
    BLOCKS, BlockCall, BlockPins, BlockType, CounterConfig, CounterKind, CounterMode, ExpertConfig,
    ExpertFunctions, ExpertOperation, FunctionConfig, FunctionKind, FunctionProbe, InputConditions,
    InputEdge, LimitsMode, LineEvents, PhaseMode, RECORD, Reflex, Threshold, ThresholdEvent,
};
use signal::{Span, Time, Value};
use std::io::{Read, Write};
use std::process::ExitCode;
use std::time::Instant;

/// Edges of a round.
const EDGES: usize = 2_000_000;
const ROUNDS: usize = 25;

/// Edges a second that the counters have to take, and those that come as records.
const FLOOR: f64 = 20e6;
const RECORD_FLOOR: f64 = 2e6;

/// The pins of one block.
struct Instance(&'static BlockType, Vec<i64>);

impl BlockPins for Instance {
    fn get(&self, pin: usize) -> i64 {
        self.1[pin]
    }

    fn set(&mut self, pin: usize, value: i64) {
        self.1[pin] = value;
    }
}

impl Instance {
    fn call(&mut self, expert: &mut ExpertFunctions, on: &[&str]) {
        for (place, pin) in self.0.pins.iter().enumerate() {
            if place == 0 || on.contains(&pin.name) {
                self.1[place] = 1;
            }
        }
        (self.0.run)(&mut BlockCall { now: Time::ZERO, pins: self, expert });
    }
}

/// A counter that counts, compares and drives two outputs.
fn counter(kind: CounterKind, mode: CounterMode) -> ExpertFunctions {
    let mut config = CounterConfig::new(kind, 0, mode);
    config.thresholds =
        [100, 300, 500, 700].map(|value| Threshold { value, event: ThresholdEvent::Both }).to_vec();
    config.reflex = [Reflex { output: Some(0), zones: 0b01010 }, Reflex { output: Some(1), zones: 0b10100 }];
    let conditions = InputConditions { delay: Span::from_micros(2), bounce: Span::from_micros(2) };
    let functions = vec![FunctionConfig { name: "HSC0".into(), kind: FunctionKind::Counter(config) }];
    let mut expert = ExpertFunctions::new(&ExpertConfig { functions }, &[conditions; 16]);
    expert.operate(Time::ZERO, ExpertOperation::Running);
    let block = BLOCKS.iter().copied().flatten().find(|block| block.name == "HSCMain_M241");
    let block = block.expect("a block of the table");
    let mut instance = Instance(block, vec![0; block.pins.len()]);
    let on = ["F_Enable", "F_Preset", "EN_Compare", "EN_Out0", "EN_Out1"];
    instance.call(&mut expert, &on);
    expert
}

/// A train on the first input, or an encoder on the first two.
fn edges(encoder: bool) -> Vec<InputEdge> {
    (0..EDGES)
        .map(|n| {
            let at = Time::from_nanos(10_000 + n as i64 * 5_000);
            match encoder {
                true => InputEdge { at, input: (n % 2) as u8, high: n / 2 % 2 == 0 },
                false => InputEdge { at, input: 0, high: n % 2 == 0 },
            }
        })
        .collect()
}

/// Takes the effects, and says how many there were.
fn take(expert: &mut ExpertFunctions) -> usize {
    let mut count = 0;
    while expert.take(count).is_some() {
        count += 1;
    }
    count
}

/// The rate of the best round; `run` takes all edges and says how many effects they had.
fn measure(name: &str, floor: f64, mut run: impl FnMut() -> (ExpertFunctions, usize)) -> bool {
    let mut best = f64::INFINITY;
    let mut shown = (Value::Unknown, 0);
    for _ in 0..ROUNDS {
        let began = Instant::now();
        let (expert, effects) = run();
        best = best.min(began.elapsed().as_secs_f64());
        shown = (expert.read(0, FunctionProbe::Value), effects);
    }
    let rate = EDGES as f64 / best;
    println!("{name:<44} {:>6.1} million edges/s   value {}, {} effects", rate / 1e6, shown.0, shown.1);
    rate >= floor
}

fn one_by_one(mut expert: ExpertFunctions, edges: &[InputEdge]) -> (ExpertFunctions, usize) {
    let mut effects = 0;
    for edge in edges {
        expert.edge(edge.at, usize::from(edge.input), edge.high);
        if !expert.effects().as_slice().is_empty() {
            effects += take(&mut expert);
        }
    }
    (expert, effects)
}

fn in_batches(mut expert: ExpertFunctions, mut edges: &[InputEdge]) -> (ExpertFunctions, usize) {
    let mut effects = 0;
    while !edges.is_empty() {
        edges = &edges[expert.edges(edges)..];
        effects += take(&mut expert);
    }
    (expert, effects)
}

fn records(edges: &[InputEdge]) -> Vec<u8> {
    let mut numbers = [0_u32; 2];
    let mut bytes = Vec::with_capacity(edges.len() * RECORD);
    for (place, edge) in edges.iter().enumerate() {
        let number = &mut numbers[usize::from(edge.input)];
        *number += 1;
        bytes.extend(edge.at.as_nanos().to_ne_bytes());
        for word in [if edge.high { 1 } else { 2 }, u32::from(edge.input) + 4, place as u32 + 1, *number] {
            bytes.extend(word.to_ne_bytes());
        }
        bytes.extend([0; RECORD - 24]);
    }
    bytes
}

/// Through a descriptor, as from the kernel, 64 records with each read.
fn from_records(mut expert: ExpertFunctions, bytes: &[u8]) -> (ExpertFunctions, usize) {
    let (mut reader, mut writer) = std::io::pipe().expect("a pipe");
    std::thread::scope(|scope| {
        scope.spawn(move || writer.write_all(bytes));
        let mut lines = LineEvents::new(&[(4, 0), (5, 1)], 0);
        let mut buffer = [0; 64 * RECORD];
        let (mut filled, mut effects) = (0, 0);
        while let Ok(count @ 1..) = reader.read(&mut buffer[filled..]) {
            filled += count;
            let mut done = 0;
            while filled - done >= RECORD {
                done += lines.read(&buffer[done..filled], &mut expert);
                effects += take(&mut expert);
            }
            buffer.copy_within(done..filled, 0);
            filled -= done;
        }
        assert_eq!((lines.lost(), lines.malformed()), (0, 0));
        (expert, effects)
    })
}

fn main() -> ExitCode {
    let (train, encoder) = (edges(false), edges(true));
    let modulo = CounterMode::ModuloLoop { modulo: 1000 };
    let free = CounterMode::FreeLarge { preset: 0, limits: LimitsMode::Rollover };
    let single = || counter(CounterKind::Single, modulo);
    let x4 = || counter(CounterKind::Dual { b: 1, phases: PhaseMode::X4 }, modulo);
    let up = || counter(CounterKind::Dual { b: 1, phases: PhaseMode::UpDown }, free);
    let bytes = records(&encoder);
    let held = [
        measure("one phase, modulo-loop", FLOOR, || one_by_one(single(), &train)),
        measure("one phase, modulo-loop, in batches", FLOOR, || in_batches(single(), &train)),
        measure("quadrature X4, modulo-loop", FLOOR, || one_by_one(x4(), &encoder)),
        measure("quadrature X4, modulo-loop, in batches", FLOOR, || in_batches(x4(), &encoder)),
        measure("up and down, free-large", FLOOR, || one_by_one(up(), &train)),
        measure("quadrature X4, from records of lines", RECORD_FLOOR, || from_records(x4(), &bytes)),
    ];
    if held.iter().all(|held| *held) { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
