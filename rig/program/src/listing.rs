//! The code for reading: units, source lines, operations with their cost and the names of their operands.

use crate::code::{AddressBase, CodeStep, CodeUnit, LibraryArgument, LibraryCode, Op, Operand, TextAt};
use crate::program::Program;
use crate::shape::{MemoryLayout, ShapeId};
use crate::types::Elementary;
use crate::walk::indices;
use document::SourceFile;
use std::fmt::Write as _;

/// Types that stand inside each other, at most.
const DEPTH: u32 = 200;

/// The code of a unit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ListedUnit {
    /// As declared.
    pub name: String,
    /// Place of the source file.
    pub file: u16,
    /// Bytes of its frame.
    pub frame: u32,
    /// Lines that have operations, in the order of the code: a line may be there several times.
    pub lines: Vec<ListedLine>,
}

/// A source line with its operations.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ListedLine {
    /// From 1.
    pub line: u32,
    /// The text without the spaces around it.
    pub text: String,
    /// What it became.
    pub steps: Vec<ListedStep>,
}

/// An operation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ListedStep {
    /// Its place in the code.
    pub pc: u32,
    /// Name and operands, the destination first.
    pub text: String,
    /// Modelled time in nanoseconds.
    pub cost: u32,
}

impl Program {
    /// The code by units, with the lines of `sources`, those that it was compiled from.
    pub fn listing(&self, sources: &[SourceFile]) -> Vec<ListedUnit> {
        let mut order: Vec<&CodeUnit> = self.units.iter().collect();
        order.sort_by_key(|unit| unit.entry);
        let ends = order.iter().skip(1).map(|unit| unit.entry).chain([self.code.len() as u32]);
        let units = order.iter().zip(ends).map(|(unit, end)| {
            let source = sources.get(usize::from(unit.file)).map_or("", |source| source.text.as_str());
            let texts: Vec<&str> = source.lines().collect();
            let mut lines: Vec<ListedLine> = Vec::new();
            for pc in unit.entry..end {
                let Some(step) = self.code.get(pc as usize) else { break };
                let line = self.lines.get(pc as usize).copied().unwrap_or(0);
                let step = ListedStep { pc, text: self.step(step), cost: step.cost };
                match lines.last_mut() {
                    Some(last) if last.line == line => last.steps.push(step),
                    _ => {
                        let text = (line as usize).checked_sub(1).and_then(|line| texts.get(line));
                        let text = text.map_or(String::new(), |text| text.trim().to_owned());
                        lines.push(ListedLine { line, text, steps: vec![step] });
                    }
                }
            }
            ListedUnit { name: unit.name.clone(), file: unit.file, frame: unit.frame, lines }
        });
        units.collect()
    }

    /// Name and operands of an operation.
    fn step(&self, step: &CodeStep) -> String {
        let mut text = format!("{:?}", step.op);
        let unit = |place: u32| self.units.get(place as usize).map_or("?", |unit| unit.name.as_str());
        let width = step.op.width();
        let fields = [step.a, step.b, step.c];
        let mut operands: Vec<String> = Vec::new();
        for (field, is_place) in fields.into_iter().zip(step.op.places()) {
            if is_place {
                operands.push(self.operand(Operand(field), width));
            }
        }
        match step.op {
            Op::Call | Op::CallThis | Op::CallSame | Op::Frame => operands.insert(0, unit(step.a).to_owned()),
            Op::CallVirtual | Op::FrameVirtual => operands.insert(0, format!("method {}", step.a)),
            Op::CallNative => {
                let native = self.natives.get(step.a as usize).map_or("?", |native| native.name);
                operands.insert(0, native.to_owned());
            }
            Op::CallLibrary => operands = self.library_call(step.b),
            Op::MoveText | Op::CompareText => {
                if let Some(pair) = self.texts.get(step.c as usize) {
                    operands.extend([pair.to, pair.of].map(|at| self.text(&at)));
                }
            }
            Op::Convert => {
                let name =
                    |place: u32| Elementary::ALL.get((place & 0xFF) as usize).map_or("?", |ty| ty.name());
                operands.push(format!("{} to {}", name(step.c >> 8), name(step.c)));
            }
            Op::IsKind => operands.push(self.kinds.get(step.c as usize).cloned().unwrap_or_default()),
            Op::Copy => operands.push(format!("{} bytes", step.c)),
            Op::LoadBit | Op::StoreBit => operands.push(format!("bit {}", step.c)),
            op if op.indexes() => {
                if let Some(index) = self.indexes.get(step.c as usize) {
                    operands.push(format!(
                        "{}[{}..{}]",
                        self.operand(index.of, width),
                        index.low,
                        index.high
                    ));
                }
            }
            op if op == Op::Jump || op.branches() => operands.push(format!("to {}", step.a)),
            _ => {}
        }
        for (nth, operand) in operands.iter().enumerate() {
            // Writing to a string does not fail.
            let _ = write!(text, "{} {operand}", if nth > 0 { "," } else { "" });
        }
        text
    }

    fn library_call(&self, place: u32) -> Vec<String> {
        let Some(call) = self.library.get(place as usize) else { return Vec::new() };
        let argument = |argument: &LibraryArgument| match argument {
            LibraryArgument::Cell(at, ty) => self.operand(*at, ty.bytes() as u32),
            LibraryArgument::Text(text) => self.text(text),
        };
        let name = match call.code {
            LibraryCode::Function(function) => function.name.to_owned(),
            LibraryCode::ToText(ty) => format!("{}_TO_STRING", ty.name()),
            LibraryCode::FromText(ty) => format!("STRING_TO_{}", ty.name()),
        };
        [name, argument(&call.result)].into_iter().chain(call.arguments.iter().map(argument)).collect()
    }

    /// A text: a constant in quotes, or its place.
    fn text(&self, text: &TextAt) -> String {
        let at = text.at.offset();
        if text.at.base() == AddressBase::Absolute && self.is_constant(at) && !text.wide {
            let bytes = self.image.get(at as usize..).unwrap_or_default();
            let shown = bytes.iter().take(text.bytes as usize).take_while(|byte| **byte != 0);
            return format!("'{}'", shown.map(|byte| char::from(*byte)).collect::<String>());
        }
        self.operand(text.at, text.bytes)
    }

    fn is_constant(&self, at: u32) -> bool {
        (at as usize) < self.image.len() && !(self.variables_from..self.variables_to).contains(&at)
    }

    /// An operand: a variable's path, a constant's value, or the base with the offset.
    fn operand(&self, operand: Operand, width: u32) -> String {
        let offset = operand.offset();
        match operand.base() {
            AddressBase::Frame => format!("@{offset}"),
            AddressBase::Indirect => format!("^@{offset}"),
            AddressBase::This => format!("THIS@{offset}"),
            AddressBase::Absolute if self.is_constant(offset) => {
                let bytes = self.image.get(offset as usize..).unwrap_or_default();
                let number =
                    bytes.iter().take(width as usize).rev().fold(0, |n: u64, byte| n << 8 | u64::from(*byte));
                format!("#{number}")
            }
            AddressBase::Absolute => self.name(offset).unwrap_or_else(|| format!("{offset:#x}")),
        }
    }

    /// The path of the variable at an address.
    fn name(&self, address: u32) -> Option<String> {
        let holds = |first: u32, shape: ShapeId| {
            let bytes = self.shape(shape).map_or(0, MemoryLayout::bytes);
            address >= first && address - first < bytes
        };
        let root = self.roots.iter().find(|root| holds(root.address, root.shape))?;
        let (mut path, mut at, mut shape) = (root.path.clone(), root.address, root.shape);
        for _ in 0..DEPTH {
            match self.shape(shape)? {
                MemoryLayout::Members { members, .. } => {
                    let inside = members.iter().find(|member| holds(at + member.offset, member.shape));
                    let Some(member) = inside else { break };
                    path = format!("{path}.{}", member.name);
                    (at, shape) = (at + member.offset, member.shape);
                }
                MemoryLayout::Array { dimensions, of, stride } if *stride > 0 && address > at => {
                    let nth = (address - at) / stride;
                    path.push_str(&indices(dimensions, nth));
                    (at, shape) = (at + nth * stride, *of);
                }
                _ => break,
            }
        }
        if address > at {
            let _ = write!(path, "+{}", address - at);
        }
        Some(path)
    }
}

impl Op {
    /// Bytes of the operands, as its name says: 8 where it says nothing.
    fn width(self) -> u32 {
        let name = format!("{self:?}");
        let digits: String =
            name.chars().skip_while(|c| !c.is_ascii_digit()).take_while(char::is_ascii_digit).collect();
        match digits.as_str() {
            "8" => 1,
            "16" => 2,
            "32" => 4,
            _ => 8,
        }
    }
}
