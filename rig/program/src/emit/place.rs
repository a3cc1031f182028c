//! Places: from roots, offsets and indices to operands.

use super::{Dest, Emitter, Value, ops};
use crate::code::{AddressBase, IndexOf, Op, Operand, map};
use crate::findings::SourcePlace;
use crate::tree::{Expr, ExprKind, Index, Target, TreePlace, TreeRoot, Ty};
use crate::types::Elementary;

/// What is assigned to, when its address is known.
#[derive(Clone, Copy, Debug)]
pub(super) enum Aim {
    Place(Dest),
    Bit { at: Operand, bit: u32, cost: u32 },
}

/// What a place is looked up for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PlaceUse {
    /// To be read, called, or passed on by its address.
    Load,
    /// To be written.
    Store,
}

/// The operand of a place that needs no address.
fn direct(root: &TreeRoot, offset: u32) -> Option<Operand> {
    let base = match root {
        TreeRoot::Absolute => AddressBase::Absolute,
        TreeRoot::This => AddressBase::This,
        TreeRoot::Frame => AddressBase::Frame,
        TreeRoot::Address(_) => return None,
    };
    Some(Operand::new(base, offset))
}

impl Emitter<'_, '_, '_> {
    /// The operand of a place, and what finding it costs besides what was charged.
    pub(super) fn place(&mut self, place: &TreePlace, used: PlaceUse) -> (Operand, u32) {
        let mut own = None;
        let (of, offset, mut cost) = match &place.root {
            TreeRoot::Address(address) => match self.known_address(address, place.offset) {
                Some(of) => (of, 0, 0),
                None => {
                    let (slot, cost) = self.address_slot(address, &mut own);
                    (Operand::new(AddressBase::Indirect, slot.offset()), place.offset, cost)
                }
            },
            root => (direct(root, place.offset).unwrap_or_default(), 0, 0),
        };
        if offset == 0 && place.indices.is_empty() {
            return (of, cost);
        }
        let slot = own.unwrap_or_else(|| self.temporary(Ty::Address));
        let mut of = of;
        if offset > 0 {
            // The operation for indices finds an address that is none before the offset hides it.
            self.address_at_offset(of, (offset, used), slot, std::mem::take(&mut cost), place.at);
            of = Operand::new(AddressBase::Indirect, slot.offset());
        }
        for index in &place.indices {
            self.index(index, (of, used), slot, std::mem::take(&mut cost));
            of = Operand::new(AddressBase::Indirect, slot.offset());
        }
        (of, cost)
    }

    /// Puts the address of what stands `offset` bytes after a place into a slot of the frame.
    pub(super) fn address_at_offset(
        &mut self,
        of: Operand,
        (offset, used): (u32, PlaceUse),
        slot: Operand,
        cost: u32,
        at: SourcePlace,
    ) {
        let zero = self.constant(0, Ty::Scalar(Elementary::Usint));
        let entry = self.indexes.len() as u32;
        let stored = used == PlaceUse::Store;
        self.indexes.push(IndexOf { of, low: -i64::from(offset), high: 0, stride: 1, stored });
        self.push(Op::IndexU8, (slot.0, zero.at.0, entry), cost, at);
    }

    fn index(&mut self, index: &Index, (of, used): (Operand, PlaceUse), slot: Operand, cost: u32) {
        let mark = self.mark();
        let value = self.value(&index.value);
        let entry = self.indexes.len() as u32;
        let Index { low, high, stride, .. } = *index;
        self.indexes.push(IndexOf { of, low, high, stride, stored: used == PlaceUse::Store });
        let cost = cost.saturating_add(value.cost).saturating_add(self.costs.index);
        let op = ops::index(ops::scalar(value.ty));
        self.push(op, (slot.0, value.at.0, entry), cost, index.value.at);
        self.release(mark);
    }

    /// What stands after the address of a place that is known: a value that was put into a variable to have one.
    fn known_address(&mut self, address: &Expr, offset: u32) -> Option<Operand> {
        let (statements, inner) = match &address.kind {
            ExprKind::Sequence(statements, inner) => (statements.as_slice(), inner.as_ref()),
            _ => (&[][..], address),
        };
        let ExprKind::AddressOf(place) = &inner.kind else { return None };
        let of =
            direct(&place.root, place.offset.saturating_add(offset)).filter(|_| place.indices.is_empty())?;
        self.written(place);
        self.read(place);
        self.run(statements);
        Some(of)
    }

    /// The slot of the frame that holds an address, and what reading it costs. A variable of the frame serves as it
    /// stands: what a call gets by reference. Otherwise `own` becomes the slot, which may be used again.
    fn address_slot(&mut self, address: &Expr, own: &mut Option<Operand>) -> (Operand, u32) {
        if let ExprKind::Load(place) = &address.kind
            && let (TreeRoot::Frame, []) = (&place.root, place.indices.as_slice())
        {
            let cost = self.reading(Ty::Address, place.retained);
            return (Operand::new(AddressBase::Frame, place.offset), cost);
        }
        let slot = self.temporary(Ty::Address);
        self.store(address, Dest { at: slot, ty: Ty::Address, cost: 0 });
        *own = Some(slot);
        (slot, 0)
    }

    /// What reading a variable costs. That of texts and blocks is in what is done with them.
    pub(super) fn reading(&self, ty: Ty, retained: bool) -> u32 {
        let kept = if retained { self.costs.retained } else { 0 };
        kept.saturating_add(match ty {
            Ty::Scalar(_) | Ty::Promoted(_) | Ty::Address => self.costs.load(ops::priced(ty)),
            Ty::Text { .. } | Ty::Block { .. } => 0,
        })
    }

    /// What writing a variable costs.
    pub(super) fn writing(&self, ty: Ty, retained: bool) -> u32 {
        let kept = if retained { self.costs.retained } else { 0 };
        kept.saturating_add(match ty {
            Ty::Scalar(_) | Ty::Promoted(_) | Ty::Address => self.costs.store(ops::priced(ty)),
            Ty::Text { .. } | Ty::Block { .. } => 0,
        })
    }

    /// What copying a variable costs besides.
    pub(super) fn copying(&self, ty: Ty) -> u32 {
        match ty {
            Ty::Scalar(_) | Ty::Promoted(_) | Ty::Address => 0,
            Ty::Text { .. } => self.costs.text,
            Ty::Block { bytes } => self.costs.copy.saturating_mul(bytes.div_ceil(8)),
        }
    }

    /// The variable as a value.
    pub(super) fn load(&mut self, place: &TreePlace) -> Value {
        self.read(place);
        let (at, cost) = self.place(place, PlaceUse::Load);
        let cost = cost.saturating_add(self.reading(place.ty, place.retained));
        Value { at, ty: place.ty, cost, fixed: false }
    }

    /// The variable as a destination.
    pub(super) fn destination(&mut self, place: &TreePlace) -> Dest {
        let (at, cost) = self.place(place, PlaceUse::Store);
        self.written(place);
        Dest { at, ty: place.ty, cost: cost.saturating_add(self.writing(place.ty, place.retained)) }
    }

    /// Keeps account of what is written of the outputs.
    pub(super) fn written(&mut self, place: &TreePlace) {
        let writes = bits_in(place, 0, whole(place), map::OUTPUTS..map::MEMORY);
        self.unit.writes.extend(writes);
    }

    fn written_bit(&mut self, place: &TreePlace, bit: u32) {
        self.unit.writes.extend(bits_in(place, bit, 1, map::OUTPUTS..map::MEMORY));
    }

    /// Keeps account of what is read of the inputs.
    pub(super) fn read(&mut self, place: &TreePlace) {
        self.unit.reads.extend(bits_in(place, 0, whole(place), map::INPUTS..map::OUTPUTS));
    }

    /// The same for one bit, or for all that indices may mean.
    pub(super) fn read_bit(&mut self, place: &TreePlace, bit: u32) {
        if place.indices.is_empty() {
            self.unit.reads.extend(bits_in(place, bit, 1, map::INPUTS..map::OUTPUTS));
        } else {
            self.read(place);
        }
    }

    /// Finds out where a target is. Its indices are computed before the value.
    pub(super) fn aim(&mut self, target: &Target) -> Aim {
        match target {
            Target::Place(place) => Aim::Place(self.destination(place)),
            Target::Bit(place, bit) => {
                let (at, cost) = self.place(place, PlaceUse::Store);
                let bits = if place.indices.is_empty() { 1 } else { 0 };
                if bits == 1 {
                    self.written_bit(place, *bit);
                } else {
                    self.written(place);
                }
                let bool = self.writing(Ty::Scalar(Elementary::Bool), place.retained);
                Aim::Bit { at, bit: *bit, cost: cost.saturating_add(bool) }
            }
        }
    }

    /// Assigns an expression.
    pub(super) fn assign(&mut self, aim: Aim, expr: &Expr, at: SourcePlace) {
        match aim {
            Aim::Place(to) => self.store(expr, to),
            Aim::Bit { .. } => {
                let value = self.value(expr);
                self.hit(aim, value, at);
            }
        }
    }

    /// Assigns a value, converting it at no cost.
    pub(super) fn hit(&mut self, aim: Aim, value: Value, at: SourcePlace) {
        match aim {
            Aim::Place(to) => {
                let cost = self.copying(to.ty);
                self.convert(value, to, cost, at);
            }
            Aim::Bit { at: to, bit, cost } => {
                self.push(Op::StoreBit, (to.0, value.at.0, bit), cost.saturating_add(value.cost), at);
            }
        }
    }

    /// The address of a place, where it is known or stands somewhere.
    pub(super) fn address_in_place(&mut self, place: &TreePlace) -> Option<Value> {
        if place.indices.is_empty() && matches!(place.root, TreeRoot::This | TreeRoot::Frame) {
            return None;
        }
        self.written(place);
        let ty = Ty::Address;
        let (at, cost) = self.place(place, PlaceUse::Load);
        Some(match at.base() {
            AddressBase::Absolute => self.constant(i64::from(at.offset()), ty),
            AddressBase::Indirect => {
                Value { at: Operand::new(AddressBase::Frame, at.offset()), ty, cost, fixed: false }
            }
            AddressBase::This | AddressBase::Frame => {
                let to = self.temporary(ty);
                self.operate(Op::Address, [to, at, Operand(0)], cost, place.at);
                Value { at: to, ty, cost: 0, fixed: true }
            }
        })
    }
}

/// Bits of a place, with all that its indices may mean.
fn whole(place: &TreePlace) -> u64 {
    let spans = place.indices.iter().map(|index| {
        let count = u64::try_from(index.high.saturating_sub(index.low)).unwrap_or(0);
        count.saturating_mul(u64::from(index.stride))
    });
    spans.fold(u64::from(place.ty.bytes()), u64::saturating_add).saturating_mul(8)
}

/// Bits of a place within one of the images, as first and number.
fn bits_in(place: &TreePlace, bit: u32, bits: u64, image: std::ops::Range<u32>) -> Option<(u32, u32)> {
    if !matches!(place.root, TreeRoot::Absolute) || !image.contains(&place.offset) {
        return None;
    }
    let first = u32::try_from(u64::from(place.offset - image.start) * 8 + u64::from(bit)).ok()?;
    Some((first, u32::try_from(bits).unwrap_or(u32::MAX).min(u32::MAX - first)))
}
