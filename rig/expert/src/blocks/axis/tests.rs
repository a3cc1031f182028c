//! Blocks as a program calls them: once a millisecond, by the names of their pins.

use super::super::BLOCKS;
use super::*;
use crate::axis::AxisState;
use crate::{
    AxisConfig, DriveInput, ExpertConfig, ExpertEffect, ExpertFunctions, ExpertOperation, FunctionConfig,
    FunctionKind, FunctionProbe, InputConditions,
};
use profile::ChannelSet;

/// A program with one axis, whose outputs are followed.
struct Program {
    expert: ExpertFunctions,
    now: i64,
    pulses: usize,
}

struct Values(Vec<i64>);

impl BlockPins for Values {
    fn get(&self, pin: usize) -> i64 {
        self.0.get(pin).copied().unwrap_or(0)
    }
    fn set(&mut self, pin: usize, value: i64) {
        self.0[pin] = value;
    }
}

/// An instance of a block.
struct Block {
    block: &'static BlockType,
    values: Values,
}

impl Block {
    /// An instance for the axis, with inputs.
    fn new(name: &str, pins: &[(&str, i64)]) -> Block {
        let block = BLOCKS.iter().copied().flatten().find(|block| block.name == name).unwrap();
        let mut it = Block { block, values: Values(vec![0; block.pins.len()]) };
        it.set("Axis", 1);
        for (pin, value) in pins {
            it.set(pin, *value);
        }
        it
    }

    fn place(&self, pin: &str) -> usize {
        self.block.pins.iter().position(|it| it.name == pin).unwrap_or_else(|| panic!("no pin {pin}"))
    }

    fn set(&mut self, pin: &str, value: i64) {
        let place = self.place(pin);
        assert_eq!(self.block.pins[place].kind, BlockPinKind::Input, "{pin}");
        self.values.set(place, value);
    }

    fn get(&self, pin: &str) -> i64 {
        let place = self.place(pin);
        assert_eq!(self.block.pins[place].kind, BlockPinKind::Output, "{pin}");
        self.values.get(place)
    }

    /// The outputs that are TRUE, and ErrorID where it is not 0.
    fn shows(&self) -> String {
        let mut shown: Vec<String> = Vec::new();
        for pin in self.block.pins.iter().filter(|pin| pin.kind == BlockPinKind::Output) {
            match (pin.ty, self.get(pin.name)) {
                (_, 0) => {}
                (ValueType::Bool, _) => shown.push(pin.name.into()),
                (_, value) => shown.push(format!("{}={value}", pin.name)),
            }
        }
        shown.join(" ")
    }
}

impl Program {
    /// An axis with power.
    fn new(config: AxisConfig) -> Program {
        let function = FunctionConfig { name: "PTO0".into(), kind: FunctionKind::Axis(config) };
        let config = ExpertConfig { functions: vec![function] };
        let inputs = [InputConditions::default(); 8];
        let mut program = Program { expert: ExpertFunctions::new(&config, &inputs), now: 0, pulses: 0 };
        program.expert.operate(Time::ZERO, ExpertOperation::Running);
        program.call(&mut Block::new("MC_Power_PTO", &[("Enable", 1)]));
        program
    }

    fn call(&mut self, block: &mut Block) -> String {
        let now = Time::from_nanos(self.now);
        (block.block.run)(&mut BlockCall { now, pins: &mut block.values, expert: &mut self.expert });
        self.follow();
        block.shows()
    }

    fn with(&mut self, name: &str, pins: &[(&str, i64)]) -> String {
        self.call(&mut Block::new(name, pins))
    }

    fn follow(&mut self) {
        let mut place = 0;
        while let Some((_, effect)) = self.expert.take(place) {
            self.pulses += usize::from(effect == ExpertEffect::Output { output: 0, on: true });
            place += 1;
        }
    }

    fn wait(&mut self, ms: i64) {
        self.now += ms * 1_000_000;
        while self.expert.next() <= Time::from_nanos(self.now) {
            self.expert.fire(self.expert.next());
            self.follow();
        }
    }

    fn state(&self) -> i64 {
        self.expert.read(0, FunctionProbe::State).as_int().unwrap() as i64
    }

    fn position(&self) -> i64 {
        self.expert.read(0, FunctionProbe::Position).as_int().unwrap() as i64
    }
}

fn config() -> AxisConfig {
    let mut config = AxisConfig::new(0, 1);
    (config.start_velocity, config.stop_velocity, config.fast_stop) = (100, 100, 100);
    config
}

const MOVE: [(&str, i64); 4] =
    [("Execute", 1), ("Velocity", 1000), ("Acceleration", 10), ("Deceleration", 10)];

fn relative(distance: i64) -> Block {
    let mut block = Block::new("MC_MoveRelative_PTO", &MOVE);
    block.set("Distance", distance);
    block
}

fn velocity(hertz: i64) -> Block {
    let mut block = Block::new("MC_MoveVelocity_PTO", &MOVE);
    block.set("Velocity", hertz);
    block
}

// io:STD-PTO-04
#[test]
fn the_end_of_a_command_is_shown_until_execute_is_false() {
    let mut program = Program::new(config());
    let mut block = relative(20);
    assert_eq!(program.call(&mut block), "Busy Active");
    program.wait(1000);
    assert_eq!((program.call(&mut block).as_str(), program.pulses), ("Done", 20));
    program.wait(1);
    assert_eq!(program.call(&mut block), "Done");
    block.set("Execute", 0);
    assert_eq!(program.call(&mut block), "");
    // Again, and Execute goes before the end comes: it is shown by one call.
    block.set("Execute", 1);
    assert_eq!(program.call(&mut block), "Busy Active");
    block.set("Execute", 0);
    assert_eq!(program.call(&mut block), "Busy Active");
    program.wait(1000);
    assert_eq!((program.call(&mut block).as_str(), program.pulses), ("Done", 40));
    assert_eq!(program.call(&mut block), "");
}

// io:STD-PTO-04
#[test]
fn an_aborted_command_says_so_and_the_next_one_goes_on() {
    let mut program = Program::new(config());
    let mut first = relative(1000);
    program.call(&mut first);
    program.wait(100);
    let mut second = velocity(500);
    assert_eq!(program.call(&mut second), "Busy Active");
    assert_eq!(program.call(&mut first), "CommandAborted");
    program.wait(100);
    assert_eq!(program.call(&mut second), "InVelocity Busy Active");
    let mut third = relative(100);
    third.set("BufferMode", 1);
    // Buffered after a velocity that is reached: it begins at once.
    assert_eq!(program.call(&mut third), "Busy Active");
    assert_eq!(program.call(&mut second), "CommandAborted");
    program.wait(1000);
    assert_eq!(program.call(&mut third), "Done");
    assert_eq!(program.position(), program.pulses as i64);
}

// io:STD-PTO-05
#[test]
fn one_command_waits_and_a_second_one_is_refused() {
    let mut program = Program::new(config());
    program.call(&mut relative(100));
    let mut second = relative(50);
    second.set("BufferMode", 1);
    assert_eq!(program.call(&mut second), "Busy");
    let mut third = relative(50);
    third.set("BufferMode", 1);
    assert_eq!(program.call(&mut third), "Error ErrorID=2008");
    program.wait(2000);
    assert_eq!((program.call(&mut second).as_str(), program.pulses), ("Done", 150));
}

// io:STD-PTO-03: only the block that asks gets the error
#[test]
fn what_cannot_be_leaves_the_axis_as_it_was() {
    let mut program = Program::new(config());
    let mut running = velocity(1000);
    program.call(&mut running);
    program.wait(500);
    for (name, pins, error) in [
        ("MC_MoveAbsolute_PTO", &MOVE[..], 2007),
        ("MC_MoveRelative_PTO", &[("Execute", 1), ("Velocity", 100_001)], 3000),
        ("MC_MoveRelative_PTO", &[("Execute", 1), ("Velocity", 0)], 3000),
        ("MC_MoveVelocity_PTO", &[("Execute", 1), ("Velocity", 100)], 3001),
        ("MC_MoveVelocity_PTO", &[("Execute", 1), ("Velocity", 100), ("Acceleration", 1)], 3002),
        // A ramp to 100 kHz of 100 s.
        ("MC_MoveVelocity_PTO", &[("Execute", 1), ("Velocity", 100_000), ("Acceleration", 1)], 3001),
        ("MC_MoveVelocity_PTO", &[MOVE[0], MOVE[1], MOVE[2], MOVE[3], ("JerkRatio", 101)], 3003),
        ("MC_MoveVelocity_PTO", &[MOVE[0], MOVE[1], MOVE[2], MOVE[3], ("Direction", 2)], 3004),
        ("MC_MoveVelocity_PTO", &[MOVE[0], MOVE[1], MOVE[2], MOVE[3], ("BufferMode", 6)], 3005),
        ("MC_MoveVelocity_PTO", &[MOVE[0], MOVE[1], MOVE[2], MOVE[3], ("BufferMode", 10)], 2005),
        ("MC_Home_PTO", &[("Execute", 1), ("Mode", 2)], 3006),
        ("MC_Home_PTO", &[("Execute", 1)], 2002),
        ("MC_SetPosition_PTO", &[("Execute", 1)], 2003),
        ("MC_TouchProbe_PTO", &[("Execute", 1)], 2005),
        ("MC_AbortTrigger_PTO", &[("Execute", 1)], 2005),
        ("MC_ReadParameter_PTO", &[("Enable", 1), ("ParameterNumber", 6)], 3007),
        ("MC_WriteParameter_PTO", &[("Execute", 1), ("ParameterNumber", 1)], 3008),
        ("MC_WriteParameter_PTO", &[("Execute", 1), ("ParameterNumber", 9), ("Value", 0)], 3009),
        ("MC_Halt_PTO", &[("Execute", 1)], 3002),
    ] {
        let shown = program.with(name, pins);
        assert!(shown.ends_with(&format!("Error ErrorID={error}")), "{name} {pins:?}: {shown}");
    }
    program.wait(100);
    assert_eq!(program.call(&mut running), "InVelocity Busy Active");
    assert_eq!(program.state(), AxisState::ContinuousMotion as i64);
}

// io:EXP-06
#[test]
fn every_block_reports_an_unknown_axis_and_does_nothing() {
    let mut program = Program::new(config());
    for block in BLOCKS.iter().copied().flatten().filter(|block| block.name.ends_with("_PTO")) {
        for reference in [0, 2, 65_535] {
            let mut block = Block::new(block.name, &[("Axis", reference)]);
            let start = if block.block.pins[1].name == "Execute" { "Execute" } else { "Enable" };
            block.set(start, 1);
            assert_eq!(program.call(&mut block), "Error ErrorID=1", "{}", block.block.name);
        }
    }
    assert_eq!(program.state(), AxisState::Standstill as i64);
    assert_eq!(BLOCKS.iter().copied().flatten().filter(|block| block.name.ends_with("_PTO")).count(), 18);
}

// io:EXP-06
#[test]
fn an_error_waits_for_its_axis_to_be_known_again() {
    let mut program = Program::new(config());
    let mut home = Block::new("MC_Home_PTO", &[("Execute", 1), ("Mode", 77)]);
    let refused = program.call(&mut home);
    assert!(refused.starts_with("Error ErrorID=3"), "{refused}");
    home.set("Axis", 0);
    assert_eq!(program.call(&mut home), "Error ErrorID=1");
    home.set("Axis", 1);
    assert_eq!(program.call(&mut home), refused);
    home.set("Execute", 0);
    assert_eq!(program.call(&mut home), "");
}

// io:STD-PTO-03
#[test]
fn a_stop_holds_the_axis_until_execute_is_false() {
    let mut program = Program::new(config());
    program.call(&mut velocity(1000));
    program.wait(500);
    let mut stop = Block::new("MC_Stop_PTO", &[("Execute", 1), ("Deceleration", 10)]);
    assert_eq!(program.call(&mut stop), "Busy Active");
    program.wait(500);
    assert_eq!(program.call(&mut stop), "Done");
    assert_eq!(program.state(), AxisState::Stopping as i64);
    assert_eq!(program.call(&mut relative(1)), "Error ErrorID=2001");
    stop.set("Execute", 0);
    program.call(&mut stop);
    assert_eq!(program.state(), AxisState::Standstill as i64);
    // Execute is FALSE before the axis is at rest.
    program.call(&mut velocity(1000));
    program.wait(500);
    stop.set("Execute", 1);
    program.call(&mut stop);
    stop.set("Execute", 0);
    assert_eq!(program.call(&mut stop), "Busy Active");
    program.wait(500);
    assert_eq!(program.state(), AxisState::Standstill as i64);
    assert_eq!(program.call(&mut stop), "Done");
    assert_eq!(program.call(&mut stop), "");
}

// io:STD-PTO-04
#[test]
fn readers_tell_what_the_axis_does() {
    let mut program = Program::new(config());
    let status = [("Enable", 1)];
    assert_eq!(program.with("MC_ReadStatus_PTO", &status), "Valid Busy Standstill");
    program.with("MC_SetPosition_PTO", &[("Execute", 1), ("Position", 40)]);
    program.with("MC_SetPosition_PTO", &[("Execute", 1), ("Position", 2), ("Relative", 1)]);
    assert_eq!(program.with("MC_ReadActualPosition_PTO", &status), "Valid Busy Position=42");
    program.call(&mut velocity(-1000));
    program.wait(50);
    let shown = program.with("MC_ReadMotionState_PTO", &status);
    assert_eq!(shown, "Valid Busy Accelerating DirectionNegative");
    program.wait(200);
    assert_eq!(program.with("MC_ReadStatus_PTO", &status), "Valid Busy ContinuousMotion IsHomed");
    assert_eq!(program.with("MC_ReadActualVelocity_PTO", &status), "Valid Busy Velocity=-1000");
    let shown = program.with("MC_ReadMotionState_PTO", &status);
    assert_eq!(shown, "Valid Busy ConstantVelocity DirectionNegative");
    assert_eq!(program.with("MC_ReadActualVelocity_PTO", &[]), "");
    program.expert.protect(Time::from_nanos(program.now), ChannelSet::of(0));
    assert_eq!(program.with("MC_ReadAxisError_PTO", &status), "Valid Busy AxisErrorID=1007");
    assert_eq!(program.with("MC_ReadStatus_PTO", &status), "Valid Busy ErrorStop IsHomed");
    assert_eq!(program.with("MC_Reset_PTO", &[("Execute", 1)]), "Error ErrorID=1007");
    program.expert.protect(Time::from_nanos(program.now), ChannelSet::EMPTY);
    assert_eq!(program.with("MC_Reset_PTO", &[("Execute", 1)]), "Done");
}

// io:STD-PTO-02
#[test]
fn parameters_hold_for_the_next_commands() {
    let mut program = Program::new(config());
    for (number, value) in [(9, 500), (2, 30), (4, 1), (1000, 50), (1002, 77), (13, 20)] {
        let pins = [("Execute", 1), ("ParameterNumber", number), ("Value", value)];
        assert_eq!(program.with("MC_WriteParameter_PTO", &pins), "Done");
        let shown = program.with("MC_ReadParameter_PTO", &[("Enable", 1), ("ParameterNumber", number)]);
        assert_eq!(shown, format!("Valid Busy Value={value}"));
    }
    assert_eq!(program.call(&mut velocity(501)), "Error ErrorID=3000");
    program.with("MC_SetPosition_PTO", &[("Execute", 1)]);
    let mut block = velocity(500);
    program.call(&mut block);
    program.wait(1000);
    assert_eq!(program.call(&mut block), "Error ErrorID=1004");
    assert!((30..36).contains(&program.position()), "{}", program.position());
}

// io:STD-PTO-11
#[test]
fn a_probe_records_where_its_edge_comes() {
    let mut with = config();
    with.probe = Some(DriveInput { input: 3, inverted: false });
    let mut program = Program::new(with);
    program.call(&mut velocity(100));
    let mut probe = Block::new("MC_TouchProbe_PTO", &[("Execute", 1)]);
    assert_eq!(program.call(&mut probe), "Busy Active");
    program.wait(95);
    program.expert.edge(Time::from_nanos(program.now), 3, true);
    program.wait(50);
    assert_eq!(program.call(&mut probe), "RecordedPosition=9 Done");
    let mut next = Block::new("MC_TouchProbe_PTO", &[("Execute", 1)]);
    program.call(&mut next);
    assert_eq!(program.with("MC_AbortTrigger_PTO", &[("Execute", 1)]), "Done");
    assert_eq!(program.call(&mut next), "CommandAborted");
    assert_eq!(program.call(&mut probe), "RecordedPosition=9 Done");
}

// io:STD-PTO-09
#[test]
fn homing_by_a_block() {
    let mut with = config();
    with.reference = Some(DriveInput { input: 3, inverted: false });
    let mut program = Program::new(with);
    let pins = [
        ("Execute", 1),
        ("Mode", 21),
        ("Position", 500),
        ("HighVelocity", 1000),
        ("LowVelocity", 100),
        ("Acceleration", 10),
        ("Deceleration", 10),
        ("Offset", 25),
    ];
    let mut home = Block::new("MC_Home_PTO", &pins);
    assert_eq!(program.call(&mut home), "Busy Active");
    for high in [true, false] {
        program.wait(500);
        program.expert.edge(Time::from_nanos(program.now), 3, high);
    }
    assert_eq!(program.state(), AxisState::Homing as i64);
    program.wait(1000);
    assert_eq!(program.call(&mut home), "Done");
    assert_eq!(program.position(), 500);
    // Absolute moves are possible now.
    let mut block = Block::new("MC_MoveAbsolute_PTO", &MOVE);
    block.set("Position", 480);
    program.call(&mut block);
    program.wait(1000);
    assert_eq!((program.call(&mut block).as_str(), program.position()), ("Done", 480));
}

// io:STD-PTO-04: a command that the axis had to end
#[test]
fn an_error_of_the_axis_is_shown_by_the_command_that_ran() {
    let mut program = Program::new(config());
    let mut block = relative(1000);
    program.call(&mut block);
    program.wait(100);
    let pulses = program.pulses;
    program.expert.operate(Time::from_nanos(program.now), ExpertOperation::Stopped);
    program.wait(100);
    program.expert.operate(Time::from_nanos(program.now), ExpertOperation::Running);
    assert_eq!(program.call(&mut block), "Error ErrorID=1006");
    assert_eq!((program.pulses, program.position()), (pulses, pulses as i64));
    assert_eq!(program.call(&mut relative(5)), "Error ErrorID=1001");
}

// The delay of a buffered command, in milliseconds.
#[test]
fn a_delay_is_in_milliseconds() {
    let mut program = Program::new(config());
    let mut block = relative(1);
    block.set("BufferMode", 11);
    block.set("Delay", 30);
    assert_eq!(program.call(&mut block), "Busy");
    program.wait(29);
    assert_eq!(program.pulses, 0);
    // B first, one period of 100 Hz before the pulse.
    program.wait(12);
    assert_eq!(program.pulses, 1);
}
