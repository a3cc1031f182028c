//! The embedded inputs and outputs with what stands around them: filters, latches, expert functions, forcing, protection,
//! the alarm output.

mod embedded;
mod forced;
mod functions;
pub(crate) mod input;
pub(crate) mod output;
mod protection;

pub use forced::ForcedChannels;
pub(crate) use input::InputEvent;

use crate::config::{Config, OutputsInStop};
use crate::effect::Effects;
use crate::memory::Memory;
use crate::module::ModuleChannel;
use crate::probe::{InputProbe, OutputState};
use crate::state::State;
use expert::{ExpertEffect, ExpertFunctions, ExpertOperation, FunctionProbe};
use functions::{Functions, operation_in};
use input::Inputs;
use output::{OutputStage, Outputs};
use profile::{ChannelSet, Profile};
use protection::Protection;
use signal::{Address, Area, Cause, Span, Time, Value};

/// The embedded inputs and outputs.
#[derive(Clone, Debug)]
pub(crate) struct EmbeddedIo {
    channels: Vec<ModuleChannel>,
    inputs: Inputs,
    outputs: Outputs,
    functions: Functions,
    protection: Protection,
    forced_inputs: ForcedChannels,
    forced_outputs: ForcedChannels,
    /// What acts on the outputs: the forced values that their tasks have come to (controller:FRC-05).
    acting: ForcedChannels,
    /// What each task exchanges, by rank.
    tasks: Vec<TaskChannels>,
    /// To be driven where the bus cycle task reads its inputs next (controller:PRIO-08).
    late_write: Option<OutputWrite>,
    /// Outputs show their initialization values up to then, and these take their default values then.
    initialization: Option<(Time, ChannelSet)>,
    /// The outputs that are set to 1 at each update in STOPPED and HALT, and the others to 0; none to keep what is in %Q.
    /// Unlike those of other modules they can be initial values of the program (controller:OUT-05).
    stop_image: Option<ChannelSet>,
    /// The outputs whose default value is 1, as [`ModuleChannel::default`] says.
    defaults: ChannelSet,
    alarm_output: Option<usize>,
    /// The alarm output shows faults of the outputs, too (io:OUT-03).
    alarm_shows_faults: bool,
    /// The bit of %I that reports faults of the outputs, where there are outputs.
    status: Option<Address>,
    /// The bit of %Q that rearms the outputs, where there are outputs.
    rearming: Option<Address>,
    /// Outputs are written where the bus cycle task reads its inputs next.
    writes_late: bool,
    /// The controller is RUNNING.
    running: bool,
    /// It has its supply.
    powered: bool,
}

/// The channels that a task exchanges.
#[derive(Clone, Copy, Debug, Default)]
struct TaskChannels {
    /// The inputs that it reads.
    inputs: ChannelSet,
    /// It reads whether the outputs have a fault.
    status: bool,
    /// The outputs that it writes, by whole bytes.
    outputs: ChannelSet,
    /// It writes the rearming command.
    rearming: bool,
    /// The outputs that forcing comes to with it (controller:FRC-05).
    forced_with: ChannelSet,
}

impl TaskChannels {
    /// What is exchanged without a task.
    const ALL: TaskChannels = TaskChannels {
        inputs: ChannelSet::ALL,
        status: true,
        outputs: ChannelSet::ALL,
        rearming: true,
        forced_with: ChannelSet::ALL,
    };
}

/// What of %Q goes to the drivers.
#[derive(Clone, Copy, Debug, Default)]
struct OutputWrite {
    /// The outputs that are at 1.
    on: ChannelSet,
    /// The outputs that are written.
    which: ChannelSet,
    /// The rearming command, where it is written.
    rearming: Option<bool>,
}

/// Something that an expert function did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FunctionEffect {
    /// An output was commanded.
    Driven,
    /// Something else, which is the controller's.
    Raised(ExpertEffect),
}

impl EmbeddedIo {
    /// Those of a configuration that was checked, without power.
    pub(crate) fn new(config: &Config) -> EmbeddedIo {
        let bit = |area| move |(byte, bit): (u32, u32)| Address::bit(area, 8 * byte + bit);
        let channels = embedded::channels(config);
        EmbeddedIo {
            defaults: embedded::default_outputs(&channels),
            channels,
            inputs: Inputs::new(config),
            outputs: Outputs::new(
                0,
                0,
                profile::outputs(config.reference).map(OutputStage::from),
                config.worst_case,
            ),
            functions: Functions::new(config),
            protection: Protection::new(config.reference, config.rearming),
            forced_inputs: ForcedChannels::default(),
            forced_outputs: ForcedChannels::default(),
            acting: ForcedChannels::default(),
            tasks: vec![TaskChannels::default(); config.tasks.len()],
            late_write: None,
            initialization: None,
            stop_image: None,
            alarm_output: config.alarm_output,
            alarm_shows_faults: config.profile != Profile::M241_2014,
            status: profile::short_circuit_status(config.reference).map(bit(Area::Input)),
            rearming: profile::rearming_command(config.reference).map(bit(Area::Output)),
            writes_late: config.minimize_jitter,
            running: false,
            powered: false,
        }
    }

    /// The controller is in this state from `now` on.
    pub(crate) fn enter(&mut self, now: Time, state: State) {
        (self.running, self.powered) = (state == State::Running, state != State::Off);
        self.inputs.operate(now, matches!(state, State::Running | State::Breakpoint));
    }
}

/// Inputs.
impl EmbeddedIo {
    /// Lets the inputs act that turn at `now`; whether any is due.
    pub(crate) fn fire_inputs(&mut self, now: Time) -> bool {
        let due = self.inputs.next() <= now;
        if due {
            self.inputs.fire(now);
        }
        due
    }

    /// What happened at an input, in the order in which it did; `place` counts from 0.
    pub(crate) fn take_input_event(&mut self, place: usize) -> Option<InputEvent> {
        self.inputs.take(place)
    }

    /// The level of the Run/Stop input at `now`, where one is configured.
    pub(crate) fn run_stop(&mut self, now: Time) -> Option<bool> {
        self.inputs.run_stop(now)
    }

    /// Observes an input from now on.
    pub(crate) fn watch_input(&mut self, input: usize) {
        self.inputs.watch(input);
    }

    /// What an observer sees of an input.
    pub(crate) fn read_input(&self, input: usize, probe: InputProbe) -> Value {
        self.inputs.show(input, probe)
    }
}

/// Outputs.
impl EmbeddedIo {
    /// Every output.
    pub(crate) fn all_outputs(&self) -> ChannelSet {
        self.outputs.all()
    }

    /// What the stage of an output does.
    pub(crate) fn output_state(&self, output: usize) -> Option<OutputState> {
        let level = self.outputs.level(output)?;
        let protected = self.protection.off().contains(output);
        Some(if protected { OutputState::Protected } else { OutputState::from(level) })
    }

    /// What cycles left for the beginning of one of the bus cycle task (controller:PRIO-08); whether stages changed.
    #[inline]
    pub(crate) fn write_late(&mut self, now: Time, memory: &Memory) -> bool {
        self.late_write.take().is_some_and(|write| self.drive(now, write, memory))
    }

    /// Whether cycles left something for the beginning of one of the bus cycle task.
    #[inline]
    pub(crate) const fn has_late_write(&self) -> bool {
        self.late_write.is_some()
    }

    /// What a task exchanges, by its rank; without one everything.
    #[inline]
    fn exchanged(&self, rank: Option<usize>) -> TaskChannels {
        rank.map_or(TaskChannels::ALL, |rank| self.tasks[rank])
    }

    /// What a task writes, as it is in %Q.
    #[inline]
    fn image(&self, task: TaskChannels, memory: &Memory) -> OutputWrite {
        let rearming = self.rearming.filter(|_| task.rearming).map(|at| memory.load(at) != 0);
        OutputWrite { on: memory.outputs(), which: task.outputs, rearming }
    }

    #[inline]
    fn force_image(&mut self, which: ChannelSet, memory: &mut Memory) -> bool {
        let which = self.acting.channels() & which;
        !which.is_empty() && memory.set_outputs(self.acting.on(), which, Cause::Controller)
    }

    /// Commands the drivers at `now`, and rearming. Whether protection had a part in it.
    #[inline]
    fn drive(&mut self, now: Time, write: OutputWrite, memory: &Memory) -> bool {
        let which = write.which - self.functions.outputs();
        let on = self.with_alarm(write.on);
        let all = self.outputs.commanded().updated(which, on);
        let quiet = self.protection.is_quiet();
        match write.rearming {
            Some(command) => self.protection.update(now, all, command),
            None => self.protection.update_without_write(now, all),
        }
        if quiet && self.protection.is_quiet() {
            self.outputs.drive(now, on, which, memory);
            return false;
        }
        // A stage that protection switches off with this write must not come on with it.
        self.cut_outputs(now);
        self.outputs.drive(now, self.with_alarm(write.on), which, memory);
        self.drive_alarm(now, memory);
        true
    }

    /// Nothing waits for the end of initialization values.
    pub(crate) fn abandon_initialization(&mut self) {
        self.initialization = None;
    }

    /// Initialization values show until then; `defaults` take their default values after them.
    pub(crate) fn begin_initialization(&mut self, until: Time, defaults: ChannelSet) {
        self.initialization = Some((until, defaults));
    }

    /// Whether initialization values show.
    pub(crate) const fn is_initializing(&self) -> bool {
        self.initialization.is_some()
    }

    /// Whether initialization values are over by `now`.
    pub(crate) fn ends_initialization(&self, now: Time) -> bool {
        self.initialization.is_some_and(|(end, _)| end <= now)
    }

    /// Initialization values are over, if there are any: outputs without a value of their own take their defaults.
    /// Whether %Q changed; none where there was nothing to end.
    pub(crate) fn end_initialization(&mut self, outputs: OutputsInStop, memory: &mut Memory) -> Option<bool> {
        let (_, defaults) = self.initialization.take()?;
        let changed = memory.set_outputs(self.defaults, defaults, Cause::Controller);
        self.stop_image = match outputs {
            OutputsInStop::Keep => None,
            OutputsInStop::Default => Some(memory.outputs()),
        };
        Some(changed)
    }

    /// RUNNING is left: what outputs are set to from now on (controller:STOP-03).
    pub(crate) fn fall_back(&mut self, outputs: OutputsInStop) {
        self.functions.prepare_rest(outputs, self.defaults);
        self.stop_image = match outputs {
            OutputsInStop::Keep => None,
            OutputsInStop::Default => Some(self.defaults),
        };
    }

    /// Sets %Q to what outputs are set to in STOPPED and HALT; whether it changed.
    pub(crate) fn set_stop_image(&mut self, memory: &mut Memory) -> bool {
        let all = self.outputs.all();
        self.stop_image.is_some_and(|on| memory.set_outputs(on, all, Cause::Controller))
    }
}

/// Protection, supply and alarm.
impl EmbeddedIo {
    /// A short circuit at an output begins or is over.
    pub(crate) fn short_circuit(&mut self, output: usize, on: bool) {
        self.protection.short_circuit(output, on);
    }

    /// An output gets too hot, or no longer is.
    pub(crate) fn over_temperature(&mut self, output: usize, on: bool) {
        self.protection.over_temperature(output, on);
    }

    /// The supply of inputs and outputs comes or goes.
    pub(crate) fn supply(&mut self, on: bool) {
        self.protection.supply(on);
    }

    /// Whether the supply of inputs and outputs is there.
    pub(crate) fn is_supplied(&self) -> bool {
        self.protection.supplied()
    }

    /// Whether a fault of the outputs is reported.
    pub(crate) fn has_fault(&self) -> bool {
        self.protection.reported()
    }

    /// Whether nothing is wrong with the outputs and nothing was.
    pub(crate) fn is_quiet(&self) -> bool {
        self.protection.is_quiet()
    }

    /// Whether protection has something to do by `now`.
    pub(crate) fn is_protection_due(&self, now: Time) -> bool {
        self.protection.next() <= now
    }

    /// Every protected output is driven again.
    pub(crate) fn reset_protection(&mut self) {
        self.protection.reset();
    }

    /// Protection looks at the outputs as they are commanded. Under hardware initialization values nothing is driven.
    pub(crate) fn protect(&mut self, now: Time, memory: &Memory) {
        if !self.outputs.initialized() {
            self.protection.update_without_write(now, self.outputs.commanded());
        }
        self.cut_outputs(now);
        self.drive_alarm(now, memory);
    }

    /// Stages that protection switches off, or that have no supply.
    fn cut_outputs(&mut self, now: Time) {
        let off = self.protection.off();
        let unsupplied = if self.protection.supplied() { ChannelSet::EMPTY } else { self.outputs.all() };
        self.outputs.cut(now, off | unsupplied);
        self.functions.protect(now, off);
    }

    /// What the alarm output shows (controller:RS-08, io:OUT-03).
    fn alarm(&self) -> bool {
        self.running && !(self.alarm_shows_faults && self.protection.reported())
    }

    /// The alarm output is no longer the program's; only forcing goes before it (controller:FRC-02).
    #[inline]
    fn with_alarm(&self, mut on: ChannelSet) -> ChannelSet {
        if let Some(output) = self.alarm_output
            && !self.acting.channels().contains(output)
        {
            on.set(output, self.alarm());
        }
        on
    }

    /// The alarm output follows the state at once, also where no outputs are updated (controller:STOP-02).
    pub(crate) fn drive_alarm(&mut self, now: Time, memory: &Memory) {
        if let Some(output) = self.alarm_output.filter(|_| !self.outputs.initialized()) {
            let on = self.with_alarm(self.outputs.commanded());
            self.outputs.drive(now, on, ChannelSet::of(output), memory);
        }
    }
}

/// Expert functions.
impl EmbeddedIo {
    /// The functions as blocks reach them.
    #[inline]
    pub(crate) fn expert_mut(&mut self) -> &mut ExpertFunctions {
        self.functions.expert_mut()
    }

    /// When a function does something by itself.
    #[inline]
    pub(crate) fn functions_due(&self) -> Time {
        self.functions.next()
    }

    /// Hardware makes the square waves of these outputs.
    pub(crate) fn offload_pulses(&mut self, outputs: ChannelSet) {
        self.functions.offload_pulses(outputs);
    }

    /// So many edges at terminal I`input` are known to be missing before `now`.
    pub(crate) fn report_missed_edges(&mut self, now: Time, input: usize, edges: u32) {
        self.functions.report_missed_edges(now, input, edges);
    }

    /// Hardware at terminal I`input` counted so many steps more by `now`.
    pub(crate) fn count(&mut self, now: Time, input: usize, steps: i64) {
        self.functions.count(now, input, steps);
    }

    /// What a function shows.
    pub(crate) fn read_function(&self, function: usize, probe: FunctionProbe) -> Value {
        self.functions.read(function, probe)
    }

    /// What functions show is observed from now on.
    pub(crate) fn observe_functions(&mut self) {
        self.functions.observe();
    }

    /// Lets the functions do what is due at `now`; whether anything was.
    #[inline]
    pub(crate) fn fire_functions(&mut self, now: Time) -> bool {
        self.functions.fire(now)
    }

    /// The next thing that a function did. Commands of outputs have taken effect then.
    pub(crate) fn take_function_effect(&mut self) -> Option<(Time, FunctionEffect)> {
        let (at, effect) = self.functions.take()?;
        let running = self.functions.operation == ExpertOperation::Running;
        match effect {
            ExpertEffect::Output { output, on } if running => self.command_pulse(at, output, on),
            ExpertEffect::Wave { output, period, high } if running => {
                self.command_wave(at, output, period, high)
            }
            effect => return Some((at, FunctionEffect::Raised(effect))),
        }
        Some((at, FunctionEffect::Driven))
    }

    fn command_pulse(&mut self, at: Time, output: u8, on: bool) {
        let output = ChannelSet::of(output.into());
        self.outputs.command(at, if on { output } else { ChannelSet::EMPTY }, output);
    }

    fn command_wave(&mut self, at: Time, output: u8, period: Span, high: Span) {
        self.outputs.pulse(at, output.into(), period, high);
    }

    /// Reports at `now` what faster stages may have shown of the edges to come.
    pub(crate) fn report_unsettled(&mut self, now: Time, fx: &mut Effects) {
        self.outputs.report_unsettled(now, |effect| fx.push(effect));
    }

    /// Whether the functions do something else in this state than what they do now.
    pub(crate) fn changes_operation(&self, state: State) -> bool {
        self.functions.operation != operation_in(state)
    }

    /// The functions do what the state lets them, and the outputs of those that rest go to rest.
    pub(crate) fn operate_functions(&mut self, now: Time, state: State) {
        let operation = operation_in(state);
        self.functions.operate(now, operation);
        let which = self.functions.outputs();
        match operation {
            ExpertOperation::Running => self.outputs.command(now, ChannelSet::EMPTY, which),
            ExpertOperation::Stopped => self.outputs.command(now, self.functions.rest, which),
            ExpertOperation::Off => {}
        }
    }

    /// Outputs of functions rest at their default values from `now` on, but for those of pulse trains (io:OUT-24,
    /// io:OUT-25, io:PLS-04).
    pub(crate) fn rest_at_defaults(&mut self, now: Time) {
        self.functions.prepare_rest(OutputsInStop::Default, self.defaults);
        self.outputs.command(now, self.functions.rest, self.functions.outputs());
    }

    /// Outputs of functions rest at their initialization values from `now` on: at 0, for no variable of the program
    /// reaches them (io:OUT-18).
    pub(crate) fn rest_at_initial_values(&mut self, now: Time) {
        self.functions.rest = ChannelSet::EMPTY;
        self.outputs.command(now, ChannelSet::EMPTY, self.functions.outputs());
    }

    /// A cold reset or a download (io:STD-HSC-15).
    pub(crate) fn reset_functions(&mut self, now: Time) {
        self.functions.reset(now);
    }

    /// The application is gone.
    pub(crate) fn unload_functions(&mut self, now: Time) {
        self.functions.unload(now);
    }
}

/// Forcing.
impl EmbeddedIo {
    /// Forces an input, or ends that.
    pub(crate) fn force_input(&mut self, input: usize, on: Option<bool>) {
        self.forced_inputs.set(input, on);
    }

    /// Forces an output, or ends that.
    pub(crate) fn force_output(&mut self, output: usize, on: Option<bool>) {
        self.forced_outputs.set(output, on);
        if on.is_none() {
            self.acting.set(output, None);
        }
    }

    /// Whether an expert function drives an output.
    pub(crate) fn drives(&self, output: usize) -> bool {
        self.functions.drives(output)
    }

    /// Forcing comes to act on the outputs of a task that has executed, or without one on all of them.
    #[inline]
    pub(crate) fn act_forcing(&mut self, rank: Option<usize>) {
        if !(self.forced_outputs.is_empty() && self.acting.is_empty()) {
            self.acting.take(self.forced_outputs, self.exchanged(rank).forced_with);
        }
    }

    /// Ends all forcing.
    pub(crate) fn clear_forcing(&mut self) {
        self.restore_forced([ForcedChannels::default(); 2]);
        self.acting = ForcedChannels::default();
    }

    /// Whether anything is forced.
    pub(crate) const fn has_forced(&self) -> bool {
        !(self.forced_inputs.is_empty() && self.forced_outputs.is_empty())
    }

    /// Which inputs and which outputs are forced.
    pub(crate) const fn forced(&self) -> [ForcedChannels; 2] {
        [self.forced_inputs, self.forced_outputs]
    }

    /// What [`EmbeddedIo::forced`] said is forced again, and acts later.
    pub(crate) fn restore_forced(&mut self, [inputs, outputs]: [ForcedChannels; 2]) {
        (self.forced_inputs, self.forced_outputs) = (inputs, outputs);
    }
}
