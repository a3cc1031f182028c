//! Calls: inputs in order, the body, the result, outputs in order.

use super::expr::{BOOL, has_effects};
use super::frame::in_next;
use super::place::{Aim, PlaceUse};
use super::{Dest, Emitter, Value, ops};
use crate::code::{AddressBase, Op, Operand};
use crate::findings::SourcePlace;
use crate::tree::{CallInput, CallOutput, Callee, Expr, Slot, Target, TreeCall, TreePlace, TreeRoot, Ty};
use crate::types::Elementary;

/// Where the instance of a call is.
#[derive(Clone, Copy, Debug)]
enum Instance {
    /// None, or one that needs no address: pins have places of their own.
    Fixed(Operand),
    /// The address is in a slot of the frame; the instance stands at this offset of its root.
    Address { slot: Operand, offset: u32 },
}

impl Instance {
    fn operand(self) -> Operand {
        match self {
            Instance::Fixed(at) => at,
            Instance::Address { slot, .. } => Operand::new(AddressBase::Indirect, slot.offset()),
        }
    }
}

impl Emitter<'_, '_, '_> {
    /// Runs a call. The result stands in the frame of the callee until the next call.
    pub(super) fn call(&mut self, call: &TreeCall, ty: Ty) -> Value {
        let (instance, cost) = self.instance(&call.callee);
        self.inputs(call, instance);
        match &call.callee {
            Callee::Native(native, _) => {
                let cost = cost.saturating_add(self.costs.block);
                self.push(Op::CallNative, (u32::from(*native), instance.operand().0, 0), cost, call.at);
            }
            callee => {
                self.call_unit(callee, instance.operand(), cost.saturating_add(self.costs.call), call.at)
            }
        }
        let mut result = match call.result {
            Some(offset) => Value { at: in_next(offset), ty, cost: 0, fixed: false },
            // Nothing asks for it.
            None => Value { at: in_next(0), ty, cost: 0, fixed: true },
        };
        if !call.outputs.is_empty() {
            if call.outputs.iter().any(|output| target_has_effects(&output.target)) && call.result.is_some() {
                result = self.stable(result, call.at);
            }
            self.outputs(&call.outputs, instance, call.at);
        }
        result
    }

    /// Finds the instance. Its address is computed once, before the inputs.
    fn instance(&mut self, callee: &Callee) -> (Instance, u32) {
        match callee {
            Callee::Unit(_) | Callee::Same(_) => (Instance::Fixed(Operand(0)), 0),
            Callee::Of(_, place) | Callee::Native(_, place) => {
                let (operand, cost) = self.place(place, PlaceUse::Load);
                match operand.base() {
                    AddressBase::Indirect => {
                        let slot = Operand::new(AddressBase::Frame, operand.offset());
                        (Instance::Address { slot, offset: place.offset }, cost)
                    }
                    _ => (Instance::Fixed(operand), cost),
                }
            }
            Callee::Virtual(_, address) => {
                // The frame is prepared for the class that is called: nobody may change the address in between.
                let to = Dest { at: self.temporary(Ty::Address), ty: Ty::Address, cost: 0 };
                self.store(address, to);
                (Instance::Fixed(to.at), 0)
            }
        }
    }

    /// Inputs that run code of others come first, with all before them: their calls use the frame after the running
    /// one, where the parameters of this call are then put together.
    fn inputs(&mut self, call: &TreeCall, instance: Instance) {
        let first =
            call.inputs.iter().rposition(|input| has_effects(&input.value)).map_or(0, |last| last + 1);
        let (early, late) = call.inputs.split_at(first);
        let mut kept: Vec<(Operand, Value, SourcePlace)> = Vec::new();
        for input in early {
            match &input.to {
                Slot::Frame(offset, ty) => {
                    let to = Dest { at: self.temporary(*ty), ty: *ty, cost: 0 };
                    self.store(&input.value, to);
                    let value = Value { at: to.at, ty: *ty, cost: 0, fixed: true };
                    kept.push((in_next(*offset), value, input.value.at));
                }
                Slot::Place(place) => self.set_pin(place, &input.value, instance),
            }
        }
        let address = instance.operand().0;
        match &call.callee {
            Callee::Unit(unit) | Callee::Of(unit, _) | Callee::Same(unit) => {
                // Without variables there is nothing to prepare.
                if self.tree.units.get(usize::from(*unit)).is_none_or(|unit| !unit.frame.is_empty()) {
                    self.push(Op::Frame, (u32::from(*unit), 0, 0), 0, call.at);
                }
            }
            Callee::Virtual(selector, _) => self.push(Op::FrameVirtual, (*selector, address, 0), 0, call.at),
            Callee::Native(..) => {}
        }
        for (at, value, place) in kept {
            self.transfer(Dest { at, ty: value.ty, cost: 0 }, value, 0, place);
        }
        for CallInput { to, value } in late {
            match to {
                Slot::Frame(offset, ty) => self.store(value, Dest { at: in_next(*offset), ty: *ty, cost: 0 }),
                Slot::Place(place) => self.set_pin(place, value, instance),
            }
        }
    }

    fn set_pin(&mut self, place: &TreePlace, value: &Expr, instance: Instance) {
        let mark = self.mark();
        let (at, cost) = self.pin(place, instance, PlaceUse::Store);
        let cost = cost.saturating_add(self.writing(place.ty, place.retained));
        self.written(place);
        self.store(value, Dest { at, ty: place.ty, cost });
        self.release(mark);
    }

    /// The operand of a pin: the address of the instance is not computed again.
    fn pin(&mut self, place: &TreePlace, instance: Instance, used: PlaceUse) -> (Operand, u32) {
        let dynamic = !place.indices.is_empty() || matches!(place.root, TreeRoot::Address(_));
        match instance {
            Instance::Address { slot, offset } if dynamic => {
                let of = Operand::new(AddressBase::Indirect, slot.offset());
                let after = place.offset.saturating_sub(offset);
                if after == 0 {
                    return (of, 0);
                }
                let pin = self.temporary(Ty::Address);
                self.address_at_offset(of, (after, used), pin, 0, place.at);
                (Operand::new(AddressBase::Indirect, pin.offset()), 0)
            }
            _ => self.place(place, used),
        }
    }

    fn call_unit(&mut self, callee: &Callee, instance: Operand, cost: u32, at: SourcePlace) {
        let (op, unit) = match callee {
            Callee::Unit(unit) => (Op::Call, *unit),
            Callee::Of(unit, _) => (Op::CallThis, *unit),
            Callee::Same(unit) => (Op::CallSame, *unit),
            Callee::Virtual(selector, _) => {
                let units = self.reached.get(selector).cloned().unwrap_or_default();
                self.unit.calls.extend(units);
                return self.push(Op::CallVirtual, (*selector, instance.0, 0), cost, at);
            }
            Callee::Native(..) => return,
        };
        self.unit.calls.push(unit);
        self.push(op, (u32::from(unit), instance.0, 0), cost, at);
    }

    fn outputs(&mut self, outputs: &[CallOutput], instance: Instance, at: SourcePlace) {
        let keep = outputs.iter().any(|output| target_has_effects(&output.target));
        let mut values: Vec<Option<Value>> = Vec::with_capacity(outputs.len());
        for output in outputs {
            let value = match &output.from {
                Slot::Frame(offset, ty) => {
                    let value =
                        Value { at: in_next(*offset), ty: *ty, cost: self.reading(*ty, false), fixed: false };
                    Some(if keep { self.stable(value, at) } else { value })
                }
                Slot::Place(_) => None,
            };
            values.push(value);
        }
        for (output, value) in outputs.iter().zip(values) {
            let mark = self.mark();
            let aim = self.aim(&output.target);
            let value = match (&output.from, value) {
                (Slot::Place(place), _) => {
                    let (at, cost) = self.pin(place, instance, PlaceUse::Load);
                    let cost = cost.saturating_add(self.reading(place.ty, place.retained));
                    Some(Value { at, ty: place.ty, cost, fixed: false })
                }
                (Slot::Frame(..), value) => value,
            };
            if let Some(value) = value {
                self.output(value, output.negated, aim, at);
            }
            self.release(mark);
        }
    }

    fn output(&mut self, value: Value, negated: bool, aim: Aim, at: SourcePlace) {
        if !negated {
            return self.hit(aim, value, at);
        }
        let to = self.temporary(BOOL);
        let cost = value.cost.saturating_add(self.costs.op(Elementary::Bool));
        self.operate(ops::not(Elementary::Bool), [to, value.at, Operand(0)], cost, at);
        self.hit(aim, Value { at: to, ty: BOOL, cost: 0, fixed: true }, at);
    }
}

fn target_has_effects(target: &Target) -> bool {
    let (Target::Place(place) | Target::Bit(place, _)) = target;
    place.indices.iter().any(|index| has_effects(&index.value))
        || matches!(&place.root, TreeRoot::Address(address) if has_effects(address))
}
