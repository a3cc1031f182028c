//! Which task exchanges which embedded inputs and outputs with the terminals.
//!
//! Each task exchanges the channels that its own programs use: inputs at the start of its cycle, outputs at the end
//! (controller:PRIO-04, controller:TASK-10). What no task uses is exchanged by the bus cycle task, depending on
//! "Always update variables" (controller:DEV-10, controller:DEV-12; docs/decisions/0011-exchange-of-inputs-and-outputs.md).

use super::Controller;
use crate::io::{TaskChannels, Written};
use crate::probes::class;
use crate::{AlwaysUpdate, Application, Effects};
use signal::{Cause, Time};

impl Controller {
    /// Shares out the channels among the tasks of a new application.
    pub(super) fn share_channels(&mut self) {
        let Some(application) = self.application.as_deref() else { return };
        let mut tasks: Vec<_> = self
            .scheduler
            .places()
            .map(|place| TaskChannels {
                inputs: inputs_of(application, place),
                outputs: outputs_of(application, place),
                forced_with: application.written_outputs(place),
            })
            .collect();
        let used = tasks.iter().fold(TaskChannels::default(), |used, task| TaskChannels {
            inputs: used.inputs | task.inputs,
            outputs: used.outputs | task.outputs,
            forced_with: used.forced_with | task.forced_with,
        });
        let (inputs, outputs) = match self.config.always_update {
            AlwaysUpdate::Disabled => (0, 0),
            AlwaysUpdate::Unused => (!used.inputs, !used.outputs),
            AlwaysUpdate::Always => (!0, !0),
        };
        let bus = self.config.bus_cycle();
        if let Some(rank) = self.scheduler.places().position(|place| Some(place) == bus) {
            tasks[rank].inputs |= inputs;
            tasks[rank].outputs |= outputs;
        }
        // Forcing comes to an output with the task that writes it, else with that which exchanges it.
        for task in &mut tasks {
            task.forced_with |= task.outputs & !used.forced_with;
        }
        self.io.share(tasks.into_iter());
    }

    /// The inputs of the task of this rank, or without one all of them, with forcing -> %I.
    #[inline]
    pub(super) fn exchange_inputs(&mut self, rank: Option<usize>, at: Time, fx: &mut Effects) {
        let mast = rank.is_none_or(|rank| self.scheduler.is_mast(self.scheduler.place(rank)));
        if self.io.sample(at, rank, mast, &mut self.memory) {
            self.observe(class::MEMORY, at, Cause::Board, fx);
        }
        self.observe(class::INPUT, at, Cause::Controller, fx);
    }

    /// %Q of the outputs of a task, changed by forcing -> drivers: at once, or where the bus cycle task reads its inputs
    /// next (controller:PRIO-08).
    #[inline]
    pub(super) fn exchange_outputs(&mut self, rank: usize, at: Time, fx: &mut Effects) {
        let written = self.io.end_cycle(at, rank, self.config.minimize_jitter, &mut self.memory);
        self.observe_written(written, at, fx);
    }

    /// What cycles left for the beginning of this one (controller:PRIO-08).
    #[inline]
    pub(super) fn write_late(&mut self, place: usize, at: Time, fx: &mut Effects) {
        if self.io.has_late_write() && Some(place) == self.config.bus_cycle() {
            let stages_changed = self.io.write_late(at, &self.memory);
            self.observe_written(Written { image_changed: false, stages_changed }, at, fx);
        }
    }

    /// %Q, changed by the forcing that acts (controller:FRC-02, controller:FRC-05), -> drivers of every output.
    pub(super) fn write_outputs(&mut self, at: Time, fx: &mut Effects) {
        let written = self.io.write_all(at, &mut self.memory);
        self.observe_written(written, at, fx);
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
