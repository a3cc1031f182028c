//! The embedded inputs and outputs as module 0.

use super::{EmbeddedIo, OutputWrite, TaskChannels};
use crate::config::Config;
use crate::memory::Memory;
use crate::module::{ExchangeCycle, IoModule, ModuleChannel, OutputChanges, Sharing, TaskModule, Written};
use profile::{ChannelSet, IoChannel, IoStatus};
use signal::{Address, Area, Level, Time, Value};

/// The embedded channels of a configuration with their places in the images (io:ADR-01, io:ADR-02).
pub(super) fn channels(config: &Config) -> Vec<ModuleChannel> {
    let inputs = profile::inputs(config.reference).map(|input| {
        let address = Address::bit(Area::Input, input.byte * 8 + input.bit);
        ModuleChannel::new(IoChannel::Input(input.index), address)
    });
    let outputs = profile::outputs(config.reference).map(|output| {
        let address = Address::bit(Area::Output, output.byte * 8 + output.bit);
        let default = config.output_defaults.contains(output.index).into();
        ModuleChannel { default, ..ModuleChannel::new(IoChannel::Output(output.index), address) }
    });
    inputs.chain(outputs).collect()
}

/// The outputs whose default value is 1.
pub(super) fn default_outputs(channels: &[ModuleChannel]) -> ChannelSet {
    let on = channels.iter().filter(|known| known.default != 0);
    on.filter_map(|known| match known.channel {
        IoChannel::Output(output) => Some(output),
        IoChannel::Input(_) => None,
    })
    .collect()
}

impl IoModule for EmbeddedIo {
    fn channels(&self) -> &[ModuleChannel] {
        &self.channels
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
}

impl TaskModule for EmbeddedIo {
    fn share(&mut self, sharing: &Sharing<'_>) {
        for (rank, own) in self.tasks.iter_mut().enumerate().take(sharing.tasks()) {
            let exchanges = |at: Option<Address>| at.is_some_and(|at| sharing.exchanges(rank, at));
            let status = exchanges(self.status);
            let rearming = exchanges(self.rearming);
            *own = TaskChannels { status, rearming, ..TaskChannels::default() };
            for ModuleChannel { channel, address, .. } in &self.channels {
                let exchanged = sharing.exchanges(rank, *address);
                match *channel {
                    IoChannel::Input(input) => own.inputs.set(input, exchanged),
                    IoChannel::Output(output) => {
                        own.outputs.set(output, exchanged);
                        // Forcing comes to an output with the task that writes it, else with that which exchanges it.
                        let written = (0..sharing.tasks()).any(|other| sharing.writes(other, *address));
                        let own_write = sharing.writes(rank, *address);
                        own.forced_with.set(output, own_write || exchanged && !written);
                    }
                }
            }
        }
    }

    #[inline]
    fn sample(&mut self, now: Time, cycle: ExchangeCycle, memory: &mut Memory) -> bool {
        let task = self.exchanged(cycle.rank);
        let (on, readable) = self.inputs.read(now, cycle.mast);
        let changed = memory.set_inputs(self.forced_inputs.apply(on), readable & task.inputs);
        let status = self.status.filter(|_| task.status);
        status.is_some_and(|at| memory.set_input(at, self.protection.reported().into())) || changed
    }

    /// At once, or where the bus cycle task reads its inputs next (controller:PRIO-08).
    #[inline]
    fn drive(&mut self, now: Time, cycle: ExchangeCycle, memory: &mut Memory) -> Written {
        if cycle.rank.is_some() {
            self.act_forcing(cycle.rank);
        }
        let task = self.exchanged(cycle.rank);
        let image_changed = self.force_image(task.outputs, memory);
        let write = self.image(task, memory);
        if cycle.rank.is_none() || !self.writes_late {
            self.late_write = None;
            let stages_changed = self.drive(now, write, memory);
            return Written { image_changed, stages_changed };
        }
        let waiting = self.late_write.unwrap_or_default();
        self.late_write = Some(OutputWrite {
            on: waiting.on.updated(write.which, write.on),
            which: waiting.which | write.which,
            rearming: write.rearming.or(waiting.rearming),
        });
        Written { image_changed, stages_changed: false }
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
