//! Cycles that take no time, and what whoever runs a PROGRAM connects: a plant of a board runs so.

use document::SourceFile;
use scanrig_program::{
    Costs, Elementary, Host, Machine, Options, Program, ProgramFaultKind, ProgramPin, StopReason, compile,
};
use signal::{Address, Span, Time, Value};
use std::sync::Arc;

struct NoMemory;

impl Host for NoMemory {
    fn load(&mut self, _: Address) -> u64 {
        0
    }

    fn store(&mut self, _: Address, _: u64, _: u16, _: u32) -> bool {
        false
    }
}

fn compiled(text: &str) -> Program {
    let options = Options { costs: Costs::COUNTED, ..Options::default() };
    compile(&[SourceFile::new("plant.st", text)], &options).unwrap_or_else(|found| panic!("{found:#?}"))
}

fn machine(text: &str) -> Machine {
    Machine::new(Arc::new(compiled(text)), &[vec![0]]).unwrap()
}

const MOST: Span = Span::from_micros(100);

#[test]
fn pins_are_those_of_programs() {
    let text = "FUNCTION_BLOCK FB VAR_INPUT no : INT; END_VAR END_FUNCTION_BLOCK
        TYPE Colour : (red, green); END_TYPE
        PROGRAM Mixer VAR_INPUT Fill : BOOL; flow : LREAL := 2.5; END_VAR
        VAR_INPUT CONSTANT size : INT := 3; END_VAR
        VAR own : INT; b : FB; END_VAR VAR_OUTPUT level : REAL; colour : Colour; END_VAR END_PROGRAM";
    let pin = |name: &str, is_input, ty| ProgramPin {
        name: name.to_owned(),
        path: format!("Mixer.{name}"),
        is_input,
        ty,
    };
    assert_eq!(
        compiled(text).pins(),
        [
            pin("Fill", true, Some(Elementary::Bool)),
            pin("flow", true, Some(Elementary::Lreal)),
            pin("level", false, Some(Elementary::Real)),
            pin("colour", false, None),
        ]
    );
}

// With a time that goes on by what operations cost, a timer after a long loop ends one cycle late when the loop is short.
#[test]
fn time_stands_still_in_a_cycle() {
    for block in ["d(IN := TRUE, PT := LTIME_TO_TIME(LTIME#10ms));", "d(TRUE, T#10ms);"] {
        let mut machine = machine(&format!(
            "PROGRAM MAIN VAR turns, n : INT; d : TON; seen : LTIME; END_VAR
             FOR n := 1 TO turns DO ; END_FOR {block} seen := LTIME(); END_PROGRAM"
        ));
        let find = |path: &str| machine.find(path).unwrap();
        let (turns, done, at) = (find("turns"), find("d.Q"), find("seen"));
        for ms in 0..12 {
            let now = Time::ZERO + Span::from_millis(ms);
            machine.write(turns, Value::Int(if ms == 0 { 1000 } else { 0 }));
            assert_eq!(machine.cycle(0, now, MOST, &mut NoMemory), StopReason::Done);
            assert_eq!(machine.read(done), Value::Bool(ms >= 10), "{ms} ms");
            assert_eq!(machine.read(at).as_int(), Some(i128::from(now.as_nanos())));
        }
    }
}

#[test]
fn a_cycle_without_end_is_abandoned() {
    let mut machine = machine(
        "PROGRAM MAIN VAR n : DINT; on : BOOL; END_VAR\nIF on THEN\nWHILE TRUE DO\nn := n + 1;\nEND_WHILE\nEND_IF\nEND_PROGRAM",
    );
    let (on, n) = (machine.find("on").unwrap(), machine.find("n").unwrap());
    machine.write(on, Value::Bool(true));
    assert!(matches!(machine.cycle(0, Time::ZERO, MOST, &mut NoMemory), StopReason::Budget { .. }));
    let (file, line) = machine.source_line(0).unwrap();
    assert!(file == 0 && (3..=5).contains(&line), "{line}");
    // 100 000 operations, a few of them in each turn.
    let turns = machine.read(n).as_int().unwrap();
    assert!((10_000..=100_000).contains(&turns), "{turns}");
    machine.write(on, Value::Bool(false));
    assert_eq!(machine.cycle(0, Time::ZERO, MOST, &mut NoMemory), StopReason::Done);
}

// Functions that call each other twice run for ever without any loop.
#[test]
fn calls_without_loops_are_bounded_too() {
    let mut text = String::from("FUNCTION F0 : INT F0 := 1; END_FUNCTION ");
    for n in 1..40 {
        text += &format!("FUNCTION F{n} : INT F{n} := F{0}(); F{n} := F{0}(); END_FUNCTION ", n - 1);
    }
    let mut machine = machine(&(text + "PROGRAM MAIN VAR n : INT; END_VAR n := F39(); END_PROGRAM"));
    assert!(matches!(machine.cycle(0, Time::ZERO, MOST, &mut NoMemory), StopReason::Budget { .. }));
}

#[test]
fn a_fault_names_its_line() {
    let mut machine = machine("PROGRAM MAIN VAR n, zero : INT; END_VAR\n\nn := 7 / zero;\nEND_PROGRAM");
    let StopReason::Fault(fault) = machine.cycle(0, Time::ZERO, MOST, &mut NoMemory) else { panic!() };
    assert_eq!((fault.kind, fault.file, fault.line), (ProgramFaultKind::DivisionByZero, 0, 3));
}

#[test]
fn what_asks_the_controller_is_known() {
    let asks = "PROGRAM MAIN VAR n : DINT; END_VAR\nn := 1;\nn := GetRtc();\nEND_PROGRAM";
    assert_eq!(compiled(asks).asks_controller(), Some((0, 3)));
    assert_eq!(
        compiled("PROGRAM MAIN VAR n : REAL; END_VAR n := SIN(n); END_PROGRAM").asks_controller(),
        None
    );
}
