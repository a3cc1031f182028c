//! Which task exchanges which embedded inputs and outputs with the terminals.
//!
//! Each task exchanges the channels that its own programs use: inputs at the start of its cycle, outputs at the end
//! (controller:PRIO-04, controller:TASK-10). What no task uses is exchanged by the bus cycle task, depending on
//! "Always update variables" (controller:DEV-10, controller:DEV-12; docs/decisions/0011-exchange-of-inputs-and-outputs.md).

use crate::forcing::Forced;
use crate::watch::class;
use crate::{AlwaysUpdate, Application, Controller, Effects};
use signal::{Cause, Time};

impl Controller {
    /// Shares out the channels among the tasks of a new application.
    pub(crate) fn share_channels(&mut self) {
        let Some(application) = self.application.as_deref() else { return };
        let (mut used_inputs, mut used_outputs) = (0, 0);
        for task in &mut self.tasks {
            task.inputs = inputs_of(application, task.place);
            task.outputs = outputs_of(application, task.place);
            used_inputs |= task.inputs;
            used_outputs |= task.outputs;
        }
        let (inputs, outputs) = match self.config.always_update {
            AlwaysUpdate::Disabled => (0, 0),
            AlwaysUpdate::Unused => (!used_inputs, !used_outputs),
            AlwaysUpdate::Always => (!0, !0),
        };
        let bus = self.config.bus_cycle();
        if let Some(task) = self.tasks.iter_mut().find(|task| Some(task.place) == bus) {
            task.inputs |= inputs;
            task.outputs |= outputs;
        }
    }

    /// The inputs of a task, with forcing -> %I.
    #[inline]
    pub(crate) fn exchange_inputs(&mut self, rank: usize, at: Time, fx: &mut Effects) {
        let task = &self.tasks[rank];
        self.read_inputs_of(task.inputs, task.place == self.mast, at, fx);
    }

    /// %Q of the outputs of a task, changed by forcing -> drivers: at once, or where the bus cycle task reads its inputs
    /// next (controller:PRIO-08).
    #[inline]
    pub(crate) fn exchange_outputs(&mut self, rank: usize, at: Time, fx: &mut Effects) {
        self.act_forcing(Some(rank));
        let which = self.tasks[rank].outputs;
        if self.config.minimize_jitter {
            self.force_outputs(which, at, fx);
            let (bits, waiting) = self.power.late_write.unwrap_or_default();
            let image = self.memory.output_bits();
            self.power.late_write = Some((bits & !which | image & which, waiting | which));
        } else {
            self.write_outputs_of(which, at, fx);
        }
    }

    /// What cycles left for the beginning of this one (controller:PRIO-08).
    #[inline]
    pub(crate) fn write_late(&mut self, rank: usize, at: Time, fx: &mut Effects) {
        if self.power.late_write.is_some()
            && Some(self.tasks[rank].place) == self.config.bus_cycle()
            && let Some((bits, which)) = self.power.late_write.take()
        {
            self.drive(at, bits, which, fx);
        }
    }

    /// Physical inputs -> %I, with forcing, for MAST with what the latches hold; and the status of the outputs'
    /// protection (io:ADR-01).
    #[inline]
    pub(crate) fn read_inputs_of(&mut self, which: u32, mast: bool, at: Time, fx: &mut Effects) {
        let (levels, mask) = self.inputs.read(at, mast);
        let bits = self.forced_inputs.apply(levels);
        let status = self.status_bit;
        let bits = if self.protection.reported() { bits | status } else { bits & !status };
        if self.memory.set_input_bits(bits, (mask | status) & which) {
            self.observe(class::MEMORY, at, Cause::Board, fx);
        }
        self.observe(class::INPUT, at, Cause::Controller, fx);
    }

    /// %Q, changed by the forcing that acts (controller:FRC-02, controller:FRC-05), -> drivers.
    #[inline]
    pub(crate) fn write_outputs_of(&mut self, which: u32, at: Time, fx: &mut Effects) {
        self.force_outputs(which, at, fx);
        self.power.late_write = None;
        self.drive(at, self.memory.output_bits(), which, fx);
    }

    #[inline]
    fn force_outputs(&mut self, which: u32, at: Time, fx: &mut Effects) {
        let Forced { mask, bits } = self.acting_outputs();
        if mask & which != 0 && self.memory.set_output_bits(bits, mask & which, Cause::Controller) {
            self.observe(class::MEMORY, at, Cause::Controller, fx);
        }
    }
}

/// The embedded inputs that a task's programs read, bit n for In.
fn inputs_of(application: &dyn Application, task: usize) -> u32 {
    (0..32).filter(|bit| application.reads_input(task, *bit)).fold(0, |mask, bit| mask | 1 << bit)
}

/// The outputs whose bytes a task's programs write, bit n for Qn.
fn outputs_of(application: &dyn Application, task: usize) -> u32 {
    (0..4)
        .filter(|byte| application.writes_output(task, *byte))
        .fold(0, |mask, byte| mask | 0xFF << (8 * byte))
}
