//! A controller's memory and clock for the tests.

pub mod oracle;

use document::SourceFile;
use scanrig_program::{Host, Machine, MachineSlice, Options, Program, StopReason, compile};
use signal::{Address, Area, Image, Span, Time, Value};
use std::sync::Arc;

/// Images, and what was written with its line.
pub struct Memory {
    pub inputs: Image,
    pub outputs: Image,
    pub words: Image,
    pub lines: Vec<u32>,
    pub watched: Option<Address>,
}

impl Default for Memory {
    fn default() -> Self {
        let image = || Image::new(960_000);
        Memory { inputs: image(), outputs: image(), words: image(), lines: Vec::new(), watched: None }
    }
}

impl Memory {
    pub fn image(&mut self, area: Area) -> &mut Image {
        match area {
            Area::Input => &mut self.inputs,
            Area::Output => &mut self.outputs,
            Area::Memory => &mut self.words,
        }
    }

    pub fn get(&mut self, address: &str) -> u64 {
        let address = Address::parse(address).unwrap();
        self.image(address.area()).get(address)
    }

    pub fn set(&mut self, address: &str, value: u64) {
        let address = Address::parse(address).unwrap();
        self.image(address.area()).set(address, value);
    }
}

impl Host for Memory {
    fn load(&mut self, at: Address) -> u64 {
        self.image(at.area()).get(at)
    }

    fn store(&mut self, at: Address, value: u64, _file: u16, line: u32) -> bool {
        self.lines.push(line);
        let changed = self.image(at.area()).set(at, value);
        changed && self.watched.is_some_and(|watched| watched.overlaps(&at))
    }
}

pub fn sources(text: &str) -> Vec<SourceFile> {
    vec![SourceFile { name: "test.st".into(), text: text.into() }]
}

pub fn build(text: &str) -> Program {
    match compile(&sources(text), &Options::default()) {
        Ok(program) => program,
        Err(findings) => panic!("{text}\n{findings:#?}"),
    }
}

/// Codes of the errors of a program, in order.
pub fn codes(text: &str) -> Vec<&'static str> {
    match compile(&sources(text), &Options::default()) {
        Ok(_) => Vec::new(),
        Err(findings) => findings
            .iter()
            .filter(|finding| finding.severity == document::Severity::Error)
            .map(|finding| finding.code)
            .collect(),
    }
}

/// A machine with one task that runs every program, and its memory.
pub struct Rig {
    pub machine: Machine,
    pub memory: Memory,
    pub now: Time,
}

impl Rig {
    pub fn new(text: &str) -> Self {
        let program = Arc::new(build(text));
        let all = (0..program.programs().len()).collect();
        let machine = Machine::new(program, &[all]).unwrap();
        Rig { machine, memory: Memory::default(), now: Time::ZERO }
    }

    /// One whole cycle at the present time; the time it took. Time itself does not move.
    pub fn cycle(&mut self) -> Span {
        let slice = self.run();
        assert_eq!(slice.stop, StopReason::Done);
        slice.used
    }

    pub fn run(&mut self) -> MachineSlice {
        self.machine.begin(0);
        self.machine.resume(0, self.now, Span::from_secs(1), &mut self.memory)
    }

    pub fn read(&self, path: &str) -> Value {
        let variable = self.machine.find(path).unwrap_or_else(|| panic!("no {path}"));
        self.machine.read(variable)
    }

    pub fn int(&self, path: &str) -> i128 {
        self.read(path).as_int().unwrap()
    }

    pub fn on(&self, path: &str) -> bool {
        self.read(path) == Value::Bool(true)
    }

    pub fn write(&mut self, path: &str, value: Value) {
        let variable = self.machine.find(path).unwrap_or_else(|| panic!("no {path}"));
        assert!(self.machine.write(variable, value));
    }
}

/// Runs one cycle of a program with these declarations and statements.
pub fn once(declarations: &str, statements: &str) -> Rig {
    let mut rig = Rig::new(&format!("PROGRAM MAIN\n{declarations}\n{statements}\nEND_PROGRAM\n"));
    rig.cycle();
    rig
}
