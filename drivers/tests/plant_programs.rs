//! Plants that run a program: when they run it, what it sees and what comes of its end. The program is played here; that of
//! Structured Text is looked at in `rig/runtime/tests/plant_programs.rs`.

use std::sync::Arc;

use crate::common::*;
use document::SourceFile;
use scanrig_drivers::circuit::{
    ParameterKind, PlantMachine, PlantProgram, PlantProgramError, PlantPrograms, PlantVariable,
    PlantVariableKind,
};
use scanrig_drivers::{
    Board, BoardError, BoardExt, BoardFile, Fault, FaultKind, Subject, Terminals, UnknownSubject, build,
    read_with_programs,
};
use signal::{Address, Time, Value};

const MS: i64 = 1_000_000;

/// Plays `played.st`: each cycle counts, adds `flow` times `gain` to `level`, copies `fill` to `full`, and fails in the cycle
/// that `mode` names. No other file is a program.
#[derive(Debug)]
pub struct PlayedPrograms;

#[derive(Debug)]
struct Played;

#[derive(Clone, Debug, Default)]
struct PlayedMachine {
    values: [f64; 7],
}

const FILL: usize = 0;
const FLOW: usize = 1;
const GAIN: usize = 2;
const FAILS: usize = 3;
const LEVEL: usize = 4;
const FULL: usize = 5;

const NUMBER: PlantVariableKind = PlantVariableKind::Number { least: -1e3, most: 1e3 };

const VARIABLES: [(&str, bool, PlantVariableKind); 7] = [
    ("fill", true, PlantVariableKind::Level),
    ("flow", true, NUMBER),
    ("Gain", true, NUMBER),
    ("fails", true, NUMBER),
    ("level", false, NUMBER),
    ("full", false, PlantVariableKind::Level),
    ("colour", false, PlantVariableKind::Other),
];

fn variables() -> &'static [PlantVariable] {
    static LIST: std::sync::OnceLock<Vec<PlantVariable>> = std::sync::OnceLock::new();
    LIST.get_or_init(|| {
        let of = |(name, is_input, kind): &(&str, bool, PlantVariableKind)| PlantVariable {
            name: String::from(*name),
            is_input: *is_input,
            kind: *kind,
            initial: if *name == "Gain" { 1.0 } else { 0.0 },
        };
        VARIABLES.iter().map(of).collect()
    })
}

impl PlantPrograms for PlayedPrograms {
    fn load(&self, files: &[&str]) -> Result<Arc<dyn PlantProgram>, PlantProgramError> {
        match files {
            ["played.st"] => Ok(Arc::new(Played)),
            _ => Err(PlantProgramError::Unsuited("there is no PROGRAM".into(), "name another file".into())),
        }
    }
}

impl PlantProgram for Played {
    fn variables(&self) -> &[PlantVariable] {
        variables()
    }

    fn machine(&self) -> Box<dyn PlantMachine> {
        let mut machine = PlayedMachine::default();
        machine.reset();
        Box::new(machine)
    }
}

impl PlantMachine for PlayedMachine {
    fn reset(&mut self) {
        self.values = [0.0; 7];
        self.values[GAIN] = 1.0;
    }

    fn set(&mut self, variable: usize, value: f64) {
        self.values[variable] = value;
    }

    fn get(&self, variable: usize) -> f64 {
        self.values[variable]
    }

    fn cycle(&mut self, now: Time) -> Result<(), String> {
        if self.values[FAILS] * 1e6 == now.as_nanos() as f64 {
            return Err(String::from("played.st:3: division by zero"));
        }
        self.values[LEVEL] += self.values[FLOW] * self.values[GAIN];
        self.values[FULL] = self.values[FILL];
        Ok(())
    }
}

fn terminals(_: &Subject) -> Result<Terminals, UnknownSubject> {
    let addresses =
        |area: &str| (0..8).map(|bit| Address::parse(&format!("%{area}X0.{bit}")).unwrap()).collect();
    Ok(Terminals { inputs: addresses("I"), outputs: addresses("Q"), ports: Vec::new(), modules: Vec::new() })
}

fn file(keys: &str) -> BoardFile {
    let text = format!(
        "format = 1\n[channels]\nflow = {{ kind = \"analog\" }}\nlevel = {{ kind = \"analog\" }}\n
         [[plants]]\nkind = \"program\"\nname = \"played\"\nprogram = \"played.st\"\n{keys}\n"
    );
    read_with_programs(&SourceFile::new("b.toml", text), &terminals, &PlayedPrograms)
        .unwrap_or_else(|found| panic!("{found:#?}"))
}

fn started(file: &BoardFile) -> Box<dyn Board> {
    let mut board = build(file, 1).unwrap();
    board.start(at(0)).unwrap();
    poll(&mut *board, 0);
    board
}

const LEVEL_OF_FLOW: &str = "period = \"10 ms\"\ninputs = { flow = \"flow\", FILL = \"Q0\" }
    outputs = { level = \"level\", full = \"I0\" }";

#[test]
fn it_runs_at_each_multiple_of_its_period_and_sees_what_stood_until_then() {
    let file = file(LEVEL_OF_FLOW);
    let (flow, level) = (file.find("flow").unwrap(), file.find("level").unwrap());
    // One call for all, or one for each half of a millisecond: the same.
    for polled in [false, true] {
        let mut board = started(&file);
        let mut seen = Vec::new();
        let mut last = 0;
        for (instant, flow_of) in [(0, 2.0), (10 * MS, 3.0), (25 * MS, 5.0)] {
            for half in (last * 2 / MS..=instant * 2 / MS).filter(|_| polled) {
                seen.extend(changes(&poll(&mut *board, half * MS / 2), level.0));
            }
            // What is written at the very instant of a cycle counts for the next one, whether that instant was polled for or not.
            board.write(at(instant), &[(flow, Value::Real(flow_of))]).unwrap();
            last = instant;
        }
        seen.extend(changes(&poll(&mut *board, 40 * MS), level.0));
        assert_eq!(seen, series(&[(10, 2.0), (20, 5.0), (30, 10.0), (40, 15.0)]), "{polled}");
    }
}

/// Milliseconds and numbers as changes.
fn series(list: &[(i64, f64)]) -> Vec<(i64, Value)> {
    list.iter().map(|(ms, number)| (ms * MS, Value::Real(*number))).collect()
}

#[test]
fn levels_go_through_at_the_next_cycle() {
    let file = file(LEVEL_OF_FLOW);
    let (fill, full) = (file.find("Q0").unwrap(), file.find("I0").unwrap());
    let mut board = started(&file);
    board.write(at(3 * MS), &[(fill, ON)]).unwrap();
    board.write(at(24 * MS), &[(fill, Value::HighZ)]).unwrap();
    assert_eq!(changes(&poll(&mut *board, 100 * MS), full.0), [(10 * MS, ON), (30 * MS, OFF)]);
}

#[test]
fn two_of_them_see_what_the_other_was_before_the_instant() {
    // Each counts what the other shows: whoever stands first in the file.
    let plant = |name: &str, input: &str, output: &str| {
        format!(
            "[[plants]]\nkind = \"program\"\nname = \"{name}\"\nprogram = \"played.st\"\nperiod = \"1 ms\"
             inputs = {{ flow = \"{input}\" }}\noutputs = {{ level = \"{output}\" }}\n"
        )
    };
    let (one, other) = (plant("one", "a", "b"), plant("other", "b", "a"));
    for plants in [format!("{one}{other}"), format!("{other}{one}")] {
        let channels = "a = { kind = \"analog\" }\nb = { kind = \"analog\" }";
        let text = format!("format = 1\n[channels]\n{channels}\n{plants}");
        let file = read_with_programs(&SourceFile::new("b.toml", text), &terminals, &PlayedPrograms).unwrap();
        let mut board = build(&file, 1).unwrap();
        board.start(at(0)).unwrap();
        let (a, b) = (file.find("a").unwrap(), file.find("b").unwrap());
        // A fault stands in for what begins the series: `a` is 1 for the first cycle alone.
        let stuck =
            Fault { channel: a, kind: FaultKind::StuckAt(Value::Real(1.0)), lasts: Some(ns(3 * MS / 2)) };
        board.inject(at(0), stuck).unwrap();
        let events = poll(&mut *board, 4 * MS);
        assert_eq!(
            changes(&events, b.0).into_iter().filter(|(at, _)| *at > 0).collect::<Vec<_>>(),
            [(MS, Value::Real(1.0)), (3 * MS, Value::Real(2.0)), (4 * MS, Value::Real(4.0))]
        );
    }
}

#[test]
fn parameters_have_the_file_s_values_and_can_be_set() {
    let file = file(&format!("{LEVEL_OF_FLOW}\nparameters = {{ gain = 2.5 }}"));
    let plant = &file.circuit.plants[0];
    let parameters = plant.parameters();
    let known: Vec<(&str, f64)> = parameters.iter().map(|one| (one.name.as_str(), one.initial)).collect();
    assert_eq!(known, [("Gain", 2.5), ("fails", 0.0)]);
    assert!(parameters.iter().all(|one| matches!(one.takes, ParameterKind::Measure { .. })));
    let mut board = started(&file);
    let (flow, level) = (file.find("flow").unwrap(), file.find("level").unwrap());
    board.write(at(0), &[(flow, Value::Real(2.0))]).unwrap();
    // As of what comes at the instant of a cycle, the next one sees it first.
    board.set_parameter(at(20 * MS), 0, 0, 10.0).unwrap();
    let seen = changes(&poll(&mut *board, 30 * MS), level.0);
    assert_eq!(seen, series(&[(10, 5.0), (20, 10.0), (30, 30.0)]));
    // A start has the file's value again.
    board.start(at(100 * MS)).unwrap();
    poll(&mut *board, 100 * MS);
    board.write(at(100 * MS), &[(flow, Value::Real(2.0))]).unwrap();
    assert_eq!(changes(&poll(&mut *board, 110 * MS), level.0), [(110 * MS, Value::Real(5.0))]);
}

#[test]
fn a_program_that_fails_is_reported_once_and_its_outputs_stay() {
    let file = file(&format!("{LEVEL_OF_FLOW}\nparameters = {{ fails = 30 }}"));
    let (flow, level) = (file.find("flow").unwrap(), file.find("level").unwrap());
    let mut board = started(&file);
    board.write(at(0), &[(flow, Value::Real(2.0))]).unwrap();
    let mut events = Vec::new();
    assert_eq!(board.poll(at(100 * MS), &mut events), Err(BoardError::PlantFailed(at(30 * MS))));
    let fault = board.plant_fault().unwrap();
    assert_eq!(
        (fault.plant.as_str(), fault.at, fault.why.as_str()),
        ("played", at(30 * MS), "played.st:3: division by zero")
    );
    assert_eq!(board.poll(at(100 * MS), &mut events), Ok(()));
    assert_eq!(changes(&events, level.0).last(), Some(&(20 * MS, Value::Real(4.0))));
    assert_eq!(board.next_event(), None);
    board.safe(at(100 * MS)).unwrap();
    board.start(at(0)).unwrap();
    assert!(board.plant_fault().is_none());
}

#[test]
fn it_sees_how_a_line_goes_on_and_not_its_samples() {
    // A tank of 6 l/min into 0.1 m2 rises by 1 mm in a second, and shows that every 100 s.
    let text =
        "format = 1\n[channels]\nheight = { kind = \"analog\", unit = \"m\" }\nlevel = { kind = \"analog\" }
        [[plants]]\nkind = \"program\"\nname = \"played\"\nprogram = \"played.st\"\nperiod = \"1 s\"
        inputs = { flow = \"height\" }\noutputs = { level = \"level\" }
        [[plants]]\nkind = \"tank\"\nname = \"tank\"\narea = \"0.1 m2\"\nheight = \"1 m\"
        inflows = [{ flow = \"6 l/min\" }]\noutput = \"height\"\nsample = \"100 s\"\n";
    let file = read_with_programs(&SourceFile::new("b.toml", text), &terminals, &PlayedPrograms)
        .unwrap_or_else(|found| panic!("{found:#?}"));
    let mut board = started(&file);
    let seen = changes(&poll(&mut *board, 3_000 * MS), file.find("level").unwrap().0);
    let sums = [0.001, 0.003, 0.006];
    assert_eq!(seen.len(), 3, "{seen:?}");
    for ((at, value), (second, sum)) in seen.iter().zip((1..).zip(sums)) {
        assert!(*at == second * 1_000 * MS && (value.as_real().unwrap() - sum).abs() < 1e-12, "{seen:?}");
    }
}
