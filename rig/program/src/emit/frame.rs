//! The frame of a unit while it is being made: temporaries, labels, and what is only known at its end.

use super::{Dest, Emitter, Value, ops};
use crate::code::{AddressBase, CodeStep, LibraryArgument, Op, Operand};
use crate::findings::SourcePlace;
use crate::tree::{Ty, UnitTree};

/// Offsets of the running frame from here on are meant in the next one, which begins where the running one ends.
const NEXT: u32 = 1 << 28;

/// A place in the code that may not be known yet.
#[derive(Clone, Copy, Debug)]
pub(super) struct CodeLabel(usize);

/// Where EXIT and CONTINUE go.
#[derive(Clone, Copy, Debug)]
pub(super) struct Loop {
    pub exit: CodeLabel,
    pub next: CodeLabel,
}

/// What is known of the unit that is being made.
#[derive(Debug, Default)]
pub(super) struct RunningLoop {
    /// Bytes of the frame in use, and at most.
    top: u32,
    pub most: u32,
    labels: Vec<u32>,
    /// Operations whose `a` is a label.
    jumps: Vec<usize>,
    pub loops: Vec<Loop>,
    pub calls: Vec<u16>,
    pub writes: Vec<(u32, u32)>,
    pub reads: Vec<(u32, u32)>,
    /// Expressions inside each other.
    pub depth: u32,
    /// That they are too many was reported.
    pub deep: bool,
}

impl RunningLoop {
    pub fn new(unit: &UnitTree) -> Self {
        let bytes = u32::try_from(unit.frame.len()).unwrap_or(NEXT).min(NEXT).next_multiple_of(8);
        RunningLoop { top: bytes, most: bytes, ..RunningLoop::default() }
    }
}

/// A place in the frame that a call prepares.
pub(super) fn in_next(offset: u32) -> Operand {
    Operand::new(AddressBase::Frame, NEXT.saturating_add(offset))
}

impl Emitter<'_, '_, '_> {
    /// A place for a value until what is used now is released.
    pub(super) fn temporary(&mut self, ty: Ty) -> Operand {
        let place = self.unit.top;
        // Beyond the limit the unit is refused at its end.
        self.unit.top = place.saturating_add(ty.bytes().clamp(1, NEXT).next_multiple_of(8)).min(NEXT);
        self.unit.most = self.unit.most.max(self.unit.top);
        Operand::new(AddressBase::Frame, place)
    }

    pub(super) fn mark(&self) -> u32 {
        self.unit.top
    }

    /// Temporaries since the mark are used no more.
    pub(super) fn release(&mut self, mark: u32) {
        self.unit.top = mark;
    }

    /// The value so that nothing changes it any more.
    pub(super) fn stable(&mut self, value: Value, at: SourcePlace) -> Value {
        if value.fixed {
            return value;
        }
        let to = Dest { at: self.temporary(value.ty), ty: value.ty, cost: 0 };
        self.transfer(to, value, 0, at);
        Value { at: to.at, cost: 0, fixed: true, ..value }
    }

    /// Copies a value; both are of one type, texts of one width.
    pub(super) fn transfer(&mut self, to: Dest, value: Value, cost: u32, at: SourcePlace) {
        let cost = cost.saturating_add(value.cost).saturating_add(to.cost);
        match to.ty {
            Ty::Scalar(_) | Ty::Promoted(_) | Ty::Address => {
                let op = ops::mov(ops::scalar(to.ty));
                self.operate(op, [to.at, value.at, Operand(0)], cost, at);
            }
            Ty::Text { .. } => self.move_text(to, value, cost, at),
            Ty::Block { bytes } => self.push(Op::Copy, (to.at.0, value.at.0, bytes), cost, at),
        }
    }

    pub(super) fn label(&mut self) -> CodeLabel {
        self.unit.labels.push(u32::MAX);
        CodeLabel(self.unit.labels.len() - 1)
    }

    /// The label is the next operation.
    pub(super) fn bind(&mut self, label: CodeLabel) {
        let here = self.code.len() as u32;
        if let Some(place) = self.unit.labels.get_mut(label.0) {
            *place = here;
        }
    }

    /// An operation that may go on at a label.
    pub(super) fn jump(&mut self, op: Op, to: CodeLabel, [b, c]: [Operand; 2], cost: u32, at: SourcePlace) {
        self.unit.jumps.push(self.code.len());
        self.push(op, (to.0 as u32, b.0, c.0), cost, at);
    }

    /// Puts in what was not known: labels, and the end of the frame, which is the start of the next one.
    pub(super) fn resolve(&mut self, entry: usize, tables: (usize, usize, usize), frame: u32) {
        for jump in &self.unit.jumps {
            if let Some(step) = self.code.get_mut(*jump) {
                step.a = self.unit.labels.get(step.a as usize).copied().unwrap_or(step.a);
            }
        }
        for place in 0..self.unit.jumps.len() {
            let jump = self.unit.jumps.get(place).copied().unwrap_or(usize::MAX);
            let Some(to) = self.code.get(jump).map(|step| self.threaded(step.a)) else { continue };
            if let Some(step) = self.code.get_mut(jump) {
                step.a = to;
            }
        }
        // No field but a place is as large as one in a frame.
        for step in self.code.iter_mut().skip(entry) {
            for field in [&mut step.a, &mut step.b, &mut step.c] {
                *field = placed_in_frame(Operand(*field), frame).0;
            }
        }
        for index in self.indexes.iter_mut().skip(tables.0) {
            index.of = placed_in_frame(index.of, frame);
        }
        for pair in self.texts.iter_mut().skip(tables.1) {
            pair.to.at = placed_in_frame(pair.to.at, frame);
            pair.of.at = placed_in_frame(pair.of.at, frame);
        }
        for call in self.library.iter_mut().skip(tables.2) {
            for argument in call.arguments.iter_mut().chain([&mut call.result]) {
                match argument {
                    LibraryArgument::Cell(at, _) => *at = placed_in_frame(*at, frame),
                    LibraryArgument::Text(text) => text.at = placed_in_frame(text.at, frame),
                }
            }
        }
    }
}

impl Emitter<'_, '_, '_> {
    /// Where a jump to this operation ends up: jumps that cost nothing are left out, unless a statement begins there,
    /// which must be seen.
    fn threaded(&self, to: u32) -> u32 {
        let mut to = to;
        for _ in 0..8 {
            match self.code.get(to as usize) {
                Some(CodeStep { op: Op::Jump, a, cost: 0, .. })
                    if self.statements.binary_search_by_key(&to, |statement| statement.pc).is_err() =>
                {
                    to = *a;
                }
                _ => break,
            }
        }
        to
    }
}

/// A place of the next frame, counted from the running one.
fn placed_in_frame(at: Operand, frame: u32) -> Operand {
    match at.base() {
        AddressBase::Frame | AddressBase::Indirect if at.offset() >= NEXT => {
            Operand::new(at.base(), at.offset() - NEXT + frame)
        }
        _ => at,
    }
}
