//! The embedded inputs and outputs as module 0.

use super::{EmbeddedIo, TaskChannels};
use crate::memory::Memory;
use crate::module::{Cycle, IoModule, ModuleChannel, OutputChanges, Sharing, Written};
use crate::terminal::Channel;
use profile::{IoStatus, Reference};
use signal::{Address, Area, Level, Time, Value};

/// The embedded channels of a reference with their places in the images (io:ADR-01, io:ADR-02).
pub(super) fn channels(reference: &Reference) -> Vec<ModuleChannel> {
    let inputs = profile::inputs(reference).map(|input| {
        let address = Address::bit(Area::Input, input.byte * 8 + input.bit);
        ModuleChannel::new(Channel::Input(input.index), address)
    });
    let outputs = profile::outputs(reference).map(|output| {
        let address = Address::bit(Area::Output, output.byte * 8 + output.bit);
        ModuleChannel::new(Channel::Output(output.index), address)
    });
    inputs.chain(outputs).collect()
}

impl IoModule for EmbeddedIo {
    fn channels(&self) -> &[ModuleChannel] {
        &self.channels
    }

    fn share(&mut self, sharing: &Sharing<'_>) {
        // Their bits, and those of status and rearming command, are among the first 32 of the images.
        let mask = |rank: usize, area: Area| {
            let exchanged = (0..32).filter(|bit| sharing.exchanges(rank, Address::bit(area, *bit)));
            exchanged.fold(0, |mask, bit| mask | 1 << bit)
        };
        let written = (0..sharing.tasks()).fold(0, |mask, rank| mask | sharing.written_outputs(rank));
        for (rank, own) in self.tasks.iter_mut().enumerate().take(sharing.tasks()) {
            let (inputs, outputs) = (mask(rank, Area::Input), mask(rank, Area::Output));
            // Forcing comes to an output with the task that writes it, else with that which exchanges it.
            let forced_with = sharing.written_outputs(rank) | outputs & !written;
            *own = TaskChannels { inputs, outputs, forced_with };
        }
    }

    fn power_on(&mut self, now: Time) {
        self.inputs.power_on(now);
        let inputs = &self.inputs;
        self.functions.power_on(now, self.channels.len(), |input| inputs.terminal(input));
    }

    // The state OFF, which comes with it, says all of it.
    fn power_off(&mut self, _now: Time) {}

    fn set_input(&mut self, now: Time, input: usize, value: Value) {
        // A terminal that nothing drives is at 0.
        let high = value.as_bool().unwrap_or(false);
        self.inputs.set(now, input, Level::from_bool(high));
        if self.powered {
            self.functions.edge(now, input, high);
        }
    }

    #[inline]
    fn sample(&mut self, now: Time, cycle: Cycle, memory: &mut Memory) -> bool {
        let which = cycle.rank.map_or(!0, |rank| self.tasks[rank].inputs);
        let (levels, mask) = self.inputs.read(now, cycle.mast);
        let bits = self.forced_inputs.apply(levels);
        let status = self.status_bit;
        let bits = if self.protection.reported() { bits | status } else { bits & !status };
        memory.set_input_bits(bits, (mask | status) & which)
    }

    /// At once, or where the bus cycle task reads its inputs next (controller:PRIO-08).
    #[inline]
    fn drive(&mut self, now: Time, cycle: Cycle, memory: &mut Memory) -> Written {
        let Some(rank) = cycle.rank else { return self.write(now, !0, memory) };
        self.act_forcing(Some(rank));
        let which = self.tasks[rank].outputs;
        if !self.writes_late {
            return self.write(now, which, memory);
        }
        let image_changed = self.force_image(which, memory);
        let (bits, waiting) = self.late_write.unwrap_or_default();
        let image = memory.output_bits();
        self.late_write = Some((bits & !which | image & which, waiting | which));
        Written { image_changed, stages_changed: false }
    }

    fn initialize(&mut self, now: Time) {
        self.protection.reset();
        self.outputs.initialize(now);
    }

    fn next(&self) -> Time {
        let next = self.outputs.next().min(self.inputs.next()).min(self.functions.next());
        next.min(self.protection.next()).min(self.initialization.map_or(Time::MAX, |(end, _)| end))
    }

    fn fire(&mut self, now: Time, changes: &mut OutputChanges<'_>) {
        self.outputs.fire(now, |effect| changes.report(effect));
    }

    fn output(&self, output: usize) -> Value {
        self.outputs.level(output).map_or(Value::Unknown, Value::from)
    }

    fn status(&self) -> IoStatus {
        if !self.protection.supplied() {
            IoStatus::PowerSupply
        } else if self.protection.reported() {
            IoStatus::ShortCircuit
        } else {
            IoStatus::Ok
        }
    }
}
