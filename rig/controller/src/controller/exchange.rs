//! Which task exchanges which inputs and outputs with the terminals.
//!
//! Each task exchanges the channels that its own programs use: inputs at the start of its cycle, outputs at the end
//! (controller:PRIO-04, controller:TASK-10). What no task uses is exchanged by the bus cycle task, depending on
//! "Always update variables" (controller:DEV-10, controller:DEV-12; docs/decisions/0011-exchange-of-inputs-and-outputs.md).

use super::Controller;
use crate::module::{ExchangeCycle, Sharing, Written};
use crate::probes::class;
use crate::{Effects, ModuleChannel, Terminal};
use profile::{IoChannel, ModuleState};
use signal::{Address, Cause, Time, Value};

impl Controller {
    /// What is at the terminal of an input from `now` on: a level, or a number in the unit of an analogue channel.
    /// Terminals that there are not are ignored.
    pub fn input(&mut self, now: Time, terminal: Terminal, value: Value) {
        self.modules.set_input(&mut self.io, now, terminal, value);
    }

    /// The state of the expansion module of this index of TM3_MODULE_R (io:DIAG-01).
    pub fn module_state(&self, index: usize) -> ModuleState {
        self.modules.bus.state(index)
    }

    /// The terminal at a place of %I or %Q: a bit of a digital channel, a word of an analogue one.
    pub fn terminal(&self, address: Address) -> Option<Terminal> {
        let modules = (0..).map_while(|module| Some((module, self.modules.get(&self.io, module)?)));
        let mut all =
            modules.flat_map(|(module, it)| it.channels().iter().map(move |channel| (module, channel)));
        let at = |channel: &ModuleChannel| channel.address == address;
        all.find(|(_, channel)| at(channel))
            .map(|(module, channel)| Terminal { module, channel: channel.channel })
    }

    /// What the terminal of an output shows.
    pub(super) fn read_terminal(&self, terminal: Terminal) -> Value {
        let module = self.modules.get(&self.io, terminal.module);
        match (module, terminal.channel) {
            (Some(module), IoChannel::Output(output)) => module.output(output),
            _ => Value::Unknown,
        }
    }

    /// Shares out the channels among the tasks of a new application.
    pub(super) fn share_channels(&mut self) {
        let Some(application) = self.application.as_deref() else { return };
        let places: Vec<_> = self.scheduler.places().collect();
        let sharing = |bus: Option<usize>| {
            let bus = places.iter().position(|place| Some(*place) == bus);
            Sharing::new(application, &places, bus, self.config.always_update)
        };
        let by_tasks = sharing(self.config.bus_cycle());
        for module in self.modules.exchanged(&mut self.io) {
            module.share(&by_tasks);
        }
        self.modules.bus.share(&sharing(self.config.io_bus_cycle()));
    }

    /// The electronics of inputs and outputs come up.
    pub(super) fn power_modules(&mut self, now: Time) {
        self.modules.each(&mut self.io, |module| module.power_on(now));
    }

    /// The electronics of inputs and outputs lose their supply.
    pub(super) fn cut_modules(&mut self, now: Time) {
        self.modules.each(&mut self.io, |module| module.power_off(now));
    }

    /// Outputs show hardware initialization values (controller:OUT-02).
    pub(super) fn initialize_outputs(&mut self, now: Time) {
        self.modules.each(&mut self.io, |module| module.initialize(now));
    }

    /// The inputs of the task of this rank, or without one all of them, with forcing -> %I.
    #[inline]
    pub(super) fn exchange_inputs(&mut self, rank: Option<usize>, at: Time, fx: &mut Effects) {
        let mast = rank.is_none_or(|rank| self.scheduler.is_mast(self.scheduler.place(rank)));
        let mut changed = false;
        for module in self.modules.exchanged(&mut self.io) {
            changed |= module.sample(at, ExchangeCycle { rank, mast }, &mut self.memory);
        }
        changed |= self.modules.bus.begin_cycle(at, rank, &mut self.memory);
        if self.modules.bus.take_changed() {
            self.observe(class::STATE | class::LED, at, Cause::Board, fx);
        }
        if changed {
            self.observe(class::MEMORY, at, Cause::Board, fx);
        }
        self.observe(class::INPUT, at, Cause::Controller, fx);
    }

    /// %Q of the outputs of the task of this rank, or without one of all of them, changed by the forcing that acts
    /// (controller:FRC-02, controller:FRC-05) -> drivers.
    #[inline]
    pub(super) fn exchange_outputs(&mut self, rank: Option<usize>, at: Time, fx: &mut Effects) {
        let mut written = Written::default();
        for module in self.modules.exchanged(&mut self.io) {
            let it = module.drive(at, ExchangeCycle { rank, mast: false }, &mut self.memory);
            written.image_changed |= it.image_changed;
            written.stages_changed |= it.stages_changed;
        }
        written.image_changed |= self.modules.bus.end_cycle(at, rank, &mut self.memory);
        self.observe_written(written, at, fx);
    }

    /// The changes of outputs that are due at `now` come out.
    pub(super) fn fire_outputs(&mut self, now: Time, fx: &mut Effects) {
        let any = self.modules.fire(&mut self.io, now, fx);
        if any {
            self.observe(class::TERMINAL, now, Cause::Unknown, fx);
        }
    }

    /// What cycles left for the beginning of this one (controller:PRIO-08).
    #[inline]
    pub(super) fn write_late(&mut self, place: usize, at: Time, fx: &mut Effects) {
        if self.io.has_late_write() && Some(place) == self.config.bus_cycle() {
            let stages_changed = self.io.write_late(at, &self.memory);
            self.observe_written(Written { image_changed: false, stages_changed }, at, fx);
        }
    }

    #[inline]
    fn observe_written(&mut self, written: Written, at: Time, fx: &mut Effects) {
        if written.image_changed {
            self.observe(class::MEMORY, at, Cause::Controller, fx);
        }
        if written.stages_changed {
            self.observe(class::STATE | class::TERMINAL, at, Cause::Controller, fx);
        }
    }

    /// Protection looks at the outputs as they are commanded.
    pub(super) fn protect(&mut self, now: Time, fx: &mut Effects) {
        self.io.protect(now, &self.memory);
        self.observe(class::STATE | class::TERMINAL, now, Cause::Controller, fx);
    }
}
