//! Programs made by hand, and a host, for the tests of the machine.

mod images;
mod kept;
mod looks;
mod operators;
mod random;
mod slices;

use crate::assemble::finish;
use crate::code::{AddressBase, CodeStep, CodeUnit, Op, Operand, Statement, map};
use crate::host::{Host, MachineSlice, StopReason};
use crate::machine::Machine;
use crate::program::{Program, Retained, Retention};
use crate::shape::{MemoryLayout, Root, ShapeId};
use crate::types::Elementary;
use signal::{Address, AddressLimits, Area, Image, Span, Time};
use std::sync::Arc;

pub fn at(offset: u32) -> u32 {
    Operand::new(AddressBase::Absolute, offset).0
}

pub fn this(offset: u32) -> u32 {
    Operand::new(AddressBase::This, offset).0
}

pub fn frame(offset: u32) -> u32 {
    Operand::new(AddressBase::Frame, offset).0
}

pub fn via(offset: u32) -> u32 {
    Operand::new(AddressBase::Indirect, offset).0
}

/// A program under construction: constants, variables, units in the order of their code.
pub struct Builder {
    pub program: Program,
}

pub const LIMITS: AddressLimits = AddressLimits { input_bits: 64, output_bits: 128, memory_words: 100 };

impl Default for Builder {
    fn default() -> Self {
        let program = Program {
            code: Vec::new(),
            lines: Vec::new(),
            indexes: Vec::new(),
            texts: Vec::new(),
            library: Vec::new(),
            units: Vec::new(),
            natives: Vec::new(),
            classes: Vec::new(),
            kinds: Vec::new(),
            statements: Vec::new(),
            located: Vec::new(),
            programs: Vec::new(),
            program_names: Vec::new(),
            image: vec![0; map::FIRST as usize],
            variables_from: map::FIRST,
            variables_to: map::FIRST,
            limits: LIMITS,
            retained: Vec::new(),
            roots: Vec::new(),
            shapes: Vec::new(),
            tasks: Vec::new(),
            pins: Vec::new(),
            images: Vec::new(),
            lreal: None,
            variables: Vec::new(),
            index: Default::default(),
            files: vec!["test.st".into()],
            digest: [0; 32],
            layout: [0; 8],
            kept: Vec::new(),
            declarations: [0; 8],
            warnings: Vec::new(),
        };
        Builder { program }
    }
}

impl Builder {
    /// Bytes in the image, aligned to 8: their address. Constants come before the first variable.
    fn bytes(&mut self, bytes: &[u8]) -> u32 {
        let image = &mut self.program.image;
        let at = image.len().next_multiple_of(8);
        image.resize(at, 0);
        image.extend(bytes);
        let end = image.len().next_multiple_of(8);
        image.resize(end, 0);
        at as u32
    }

    pub fn constant(&mut self, bytes: &[u8]) -> u32 {
        assert_eq!(self.program.variables_from, self.program.variables_to, "constants come first");
        let at = self.bytes(bytes);
        self.program.variables_from = self.program.image.len() as u32;
        self.program.variables_to = self.program.variables_from;
        at
    }

    /// A constant after the variables, of which there are no more then.
    pub fn constant_behind(&mut self, bytes: &[u8]) -> u32 {
        self.bytes(bytes)
    }

    pub fn variable(&mut self, bytes: &[u8]) -> u32 {
        let at = self.bytes(bytes);
        self.program.variables_to = self.program.image.len() as u32;
        at
    }

    pub fn shape(&mut self, shape: MemoryLayout) -> ShapeId {
        self.program.shapes.push(shape);
        ShapeId(self.program.shapes.len() as u32 - 1)
    }

    pub fn root(&mut self, path: &str, shape: MemoryLayout, address: u32) {
        let shape = self.shape(shape);
        self.program.roots.push(Root { path: path.into(), shape, address, bit: 0, file: 0 });
    }

    /// A global variable with a name.
    pub fn global(&mut self, name: &str, ty: Elementary, value: i64) -> u32 {
        let address = self.variable(&value.to_le_bytes()[..ty.bytes()]);
        self.root(name, MemoryLayout::Elementary(ty), address);
        address
    }

    pub fn retain(&mut self, address: u32, bytes: u32, retention: Retention) {
        self.program.retained.push(Retained { address, bytes, retention });
    }

    /// Starts a unit.
    pub fn unit(&mut self, frame: u32, template: &[u8], calls: &[u16]) -> u16 {
        let program = &mut self.program;
        program.units.push(CodeUnit {
            name: format!("U{}", program.units.len()),
            file: 0,
            entry: program.code.len() as u32,
            frame,
            template: template.into(),
            calls: calls.into(),
            writes: Vec::new(),
            reads: Vec::new(),
        });
        program.units.len() as u16 - 1
    }

    pub fn program(&mut self, name: &str, calls: &[u16]) -> u16 {
        let unit = self.unit(64, &[], calls);
        self.program.programs.push(unit);
        self.program.program_names.push(name.into());
        unit
    }

    pub fn pc(&self) -> u32 {
        self.program.code.len() as u32
    }

    /// An operation that costs 10 ns; each is a line.
    pub fn op(&mut self, op: Op, a: u32, b: u32, c: u32) -> u32 {
        let pc = self.pc();
        self.program.code.push(CodeStep { op, a, b, c, cost: 10 });
        self.program.lines.push(pc + 1);
        pc
    }

    /// An operation at which a statement begins.
    pub fn statement(&mut self, op: Op, a: u32, b: u32, c: u32) -> u32 {
        let pc = self.op(op, a, b, c);
        self.program.statements.push(Statement { pc, file: 0, line: pc + 1 });
        pc
    }

    pub fn finish(self) -> Arc<Program> {
        Arc::new(finish(self.program))
    }

    /// A machine with one task that runs all programs.
    pub fn machine(self) -> Machine {
        let program = self.finish();
        let all = (0..program.programs.len()).collect();
        Machine::new(program, &[all]).unwrap()
    }
}

/// The host's memory, and what was stored.
pub struct Board {
    pub images: [Image; 3],
    pub stores: Vec<(Address, u64, u32)>,
    pub watched: Option<Address>,
}

impl Default for Board {
    fn default() -> Self {
        Board { images: [0; 3].map(|_| Image::new(2048)), stores: Vec::new(), watched: None }
    }
}

impl Board {
    fn image(&mut self, area: Area) -> &mut Image {
        match area {
            Area::Input => &mut self.images[0],
            Area::Output => &mut self.images[1],
            Area::Memory => &mut self.images[2],
        }
    }

    pub fn get(&mut self, text: &str) -> u64 {
        let address = Address::parse(text).unwrap();
        self.image(address.area()).get(address)
    }

    pub fn set(&mut self, text: &str, value: u64) {
        let address = Address::parse(text).unwrap();
        self.image(address.area()).set(address, value);
    }
}

impl Host for Board {
    fn load(&mut self, at: Address) -> u64 {
        self.image(at.area()).get(at)
    }

    fn store(&mut self, at: Address, value: u64, _: u16, line: u32) -> bool {
        self.stores.push((at, value, line));
        let changed = self.image(at.area()).set(at, value);
        changed && self.watched.is_some_and(|watched| watched.overlaps(&at))
    }
}

/// One cycle in one slice.
pub fn cycle(machine: &mut Machine, board: &mut Board) -> MachineSlice {
    machine.begin(0);
    machine.resume(0, Time::ZERO, Span::from_secs(1), board)
}

pub fn done(machine: &mut Machine) {
    assert_eq!(cycle(machine, &mut Board::default()).stop, StopReason::Done);
}
