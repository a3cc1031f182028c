//! The embedded inputs and outputs with what stands around them: filters, latches, expert functions, forcing, protection,
//! the alarm output.

mod embedded;
mod forced;
mod functions;
mod input;
mod output;
mod protection;

pub(crate) use input::InputEvent;

use crate::config::{Config, OutputsInStop};
use crate::memory::Memory;
use crate::module::{ModuleChannel, Written};
use crate::probe::{InputProbe, OutputState};
use crate::state::State;
use expert::{Effect, ExpertFunctions, FunctionProbe, Operation};
use forced::Forced;
use functions::{Functions, operation_in};
use input::Inputs;
use output::Outputs;
use profile::Profile;
use protection::Protection;
use signal::{Cause, Span, Time, Value};

/// The embedded inputs and outputs. In the masks bit n stands for In or Qn, of which there are at most 24.
#[derive(Clone, Debug)]
pub(crate) struct EmbeddedIo {
    channels: Vec<ModuleChannel>,
    inputs: Inputs,
    outputs: Outputs,
    functions: Functions,
    protection: Protection,
    forced_inputs: Forced,
    forced_outputs: Forced,
    /// What acts on the outputs: the forced values that their tasks have come to (controller:FRC-05).
    acting: Forced,
    /// What each task exchanges, by rank.
    tasks: Vec<TaskChannels>,
    /// What was written to the outputs, and to which, to be driven where the bus cycle task reads its inputs next
    /// (controller:PRIO-08).
    late_write: Option<(u32, u32)>,
    /// Outputs show their initialization values up to then, and these take their default values then.
    initialization: Option<(Time, u32)>,
    /// What the outputs are set to at each update in STOPPED and HALT; none to keep what is in %Q.
    stop_image: Option<u32>,
    defaults: u32,
    alarm_output: Option<usize>,
    /// The alarm output shows faults of the outputs, too (io:OUT-03).
    alarm_shows_faults: bool,
    /// The bit of %I that reports faults of the outputs; 0 without outputs.
    status_bit: u32,
    /// The bit of %Q that rearms the outputs; 0 without outputs.
    rearming_bit: u32,
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
    inputs: u32,
    /// The outputs that it writes, by whole bytes.
    outputs: u32,
    /// The outputs that forcing comes to with it (controller:FRC-05).
    forced_with: u32,
}

/// Something that an expert function did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FunctionEffect {
    /// An output was commanded.
    Driven,
    /// Something else, which is the controller's.
    Raised(Effect),
}

/// A bit by its byte and its place in it, among the first 32 of an image.
const fn low_bit((byte, bit): (u32, u32)) -> u32 {
    1 << (8 * byte + bit)
}

impl EmbeddedIo {
    /// Those of a configuration that was checked, without power.
    pub(crate) fn new(config: &Config) -> EmbeddedIo {
        EmbeddedIo {
            channels: embedded::channels(config.reference),
            inputs: Inputs::new(config),
            outputs: Outputs::new(profile::outputs(config.reference)),
            functions: Functions::new(config),
            protection: Protection::new(config.reference, config.rearming),
            forced_inputs: Forced::default(),
            forced_outputs: Forced::default(),
            acting: Forced::default(),
            tasks: vec![TaskChannels::default(); config.tasks.len()],
            late_write: None,
            initialization: None,
            stop_image: None,
            defaults: config.output_defaults,
            alarm_output: config.alarm_output,
            alarm_shows_faults: config.profile != Profile::M241_2014,
            status_bit: profile::short_circuit_status(config.reference).map_or(0, low_bit),
            rearming_bit: profile::rearming_command(config.reference).map_or(0, low_bit),
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
    /// A 1 for every output.
    pub(crate) fn output_mask(&self) -> u32 {
        self.outputs.mask()
    }

    /// What the stage of an output does.
    pub(crate) fn output_state(&self, output: usize) -> Option<OutputState> {
        let level = self.outputs.level(output)?;
        let protected = self.protection.off() >> output & 1 == 1;
        Some(if protected { OutputState::Protected } else { OutputState::from(level) })
    }

    /// What cycles left for the beginning of one of the bus cycle task (controller:PRIO-08); whether stages changed.
    #[inline]
    pub(crate) fn write_late(&mut self, now: Time, memory: &Memory) -> bool {
        self.late_write.take().is_some_and(|(bits, which)| self.drive(now, bits, which, memory))
    }

    /// Whether cycles left something for the beginning of one of the bus cycle task.
    #[inline]
    pub(crate) const fn has_late_write(&self) -> bool {
        self.late_write.is_some()
    }

    /// %Q, changed by the forcing that acts (controller:FRC-02, controller:FRC-05), -> drivers.
    #[inline]
    fn write(&mut self, now: Time, which: u32, memory: &mut Memory) -> Written {
        let image_changed = self.force_image(which, memory);
        self.late_write = None;
        let stages_changed = self.drive(now, memory.output_bits(), which, memory);
        Written { image_changed, stages_changed }
    }

    #[inline]
    fn force_image(&mut self, which: u32, memory: &mut Memory) -> bool {
        let Forced { mask, bits } = self.acting;
        mask & which != 0 && memory.set_output_bits(bits, mask & which, Cause::Controller)
    }

    /// Commands the drivers of `which` outputs at `now`, and the rearming command among the bits after them. Whether
    /// protection had a part in it.
    #[inline]
    fn drive(&mut self, now: Time, image: u32, which: u32, memory: &Memory) -> bool {
        let which = which & !self.functions.outputs();
        let bits = self.with_alarm(image);
        let all = self.outputs.commanded() & !which | bits & which;
        let quiet = self.protection.is_quiet();
        if which & self.rearming_bit == 0 {
            self.protection.update_without_write(now, all);
        } else {
            self.protection.update(now, all, image & self.rearming_bit != 0);
        }
        if quiet && self.protection.is_quiet() {
            self.outputs.drive(now, bits, which, memory);
            return false;
        }
        // A stage that protection switches off with this write must not come on with it.
        self.cut_outputs(now);
        self.outputs.drive(now, self.with_alarm(image), which, memory);
        self.drive_alarm(now, memory);
        true
    }

    /// Nothing waits for the end of initialization values.
    pub(crate) fn abandon_initialization(&mut self) {
        self.initialization = None;
    }

    /// Initialization values show until then; `defaults` take their default values behind them.
    pub(crate) fn begin_initialization(&mut self, until: Time, defaults: u32) {
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
        let changed = memory.set_output_bits(self.defaults, defaults, Cause::Controller);
        self.stop_image = match outputs {
            OutputsInStop::Keep => None,
            OutputsInStop::Default => Some(memory.output_bits() & self.outputs.mask()),
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
        let mask = self.outputs.mask();
        self.stop_image.is_some_and(|bits| memory.set_output_bits(bits, mask, Cause::Controller))
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
        let unsupplied = if self.protection.supplied() { 0 } else { self.outputs.mask() };
        self.outputs.cut(now, off | unsupplied);
        self.functions.protect(now, off);
    }

    /// What the alarm output shows (controller:RS-08, io:OUT-03).
    fn alarm(&self) -> bool {
        self.running && !(self.alarm_shows_faults && self.protection.reported())
    }

    /// The alarm output is no longer the program's; only forcing goes before it (controller:FRC-02).
    #[inline]
    fn with_alarm(&self, bits: u32) -> u32 {
        match self.alarm_output {
            Some(output) if self.acting.mask >> output & 1 == 0 => {
                bits & !(1 << output) | u32::from(self.alarm()) << output
            }
            _ => bits,
        }
    }

    /// The alarm output follows the state at once, also where no outputs are updated (controller:STOP-02).
    pub(crate) fn drive_alarm(&mut self, now: Time, memory: &Memory) {
        if let Some(output) = self.alarm_output.filter(|_| !self.outputs.initialized()) {
            let bits = self.with_alarm(self.outputs.commanded());
            self.outputs.drive(now, bits, 1 << output, memory);
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
    pub(crate) fn offload_pulses(&mut self, outputs: u32) {
        self.functions.offload_pulses(outputs);
    }

    /// So many edges at terminal I`input` are known to be missing before `now`.
    pub(crate) fn report_missed_edges(&mut self, now: Time, input: usize, edges: u32) {
        self.functions.report_missed_edges(now, input, edges);
    }

    /// Hardware after terminal I`input` counted so many steps more by `now`.
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
        let running = self.functions.operation == Operation::Running;
        match effect {
            Effect::Output { output, on } if running => self.command_pulse(at, output, on),
            Effect::Wave { output, period, high } if running => self.command_wave(at, output, period, high),
            effect => return Some((at, FunctionEffect::Raised(effect))),
        }
        Some((at, FunctionEffect::Driven))
    }

    fn command_pulse(&mut self, at: Time, output: u8, on: bool) {
        let bit = 1 << output;
        self.outputs.command(at, if on { bit } else { 0 }, bit);
    }

    fn command_wave(&mut self, at: Time, output: u8, period: Span, high: Span) {
        self.outputs.pulse(at, output, period, high);
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
            Operation::Running => self.outputs.command(now, 0, which),
            Operation::Stopped => self.outputs.command(now, self.functions.rest, which),
            Operation::Off => {}
        }
    }

    /// Outputs of functions rest at their default values from `now` on, but for those of pulse trains (io:OUT-24,
    /// io:OUT-25, io:PLS-04).
    pub(crate) fn rest_at_defaults(&mut self, now: Time) {
        self.functions.prepare_rest(OutputsInStop::Default, self.defaults);
        self.outputs.command(now, self.functions.rest, self.functions.outputs());
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
        if self.forced_outputs.mask | self.acting.mask != 0 {
            let which = rank.map_or(u32::MAX, |rank| self.tasks[rank].forced_with);
            self.acting.take(self.forced_outputs, which);
        }
    }

    /// Ends all forcing.
    pub(crate) fn clear_forcing(&mut self) {
        (self.forced_inputs, self.forced_outputs, self.acting) =
            (Forced::default(), Forced::default(), Forced::default());
    }

    /// Whether anything is forced.
    pub(crate) const fn has_forced(&self) -> bool {
        self.forced_inputs.mask | self.forced_outputs.mask != 0
    }

    /// Which inputs and which outputs are forced, each with their values.
    pub(crate) const fn forced(&self) -> [(u32, u32); 2] {
        let Forced { mask, bits } = self.forced_inputs;
        [(mask, bits), (self.forced_outputs.mask, self.forced_outputs.bits)]
    }

    /// What [`EmbeddedIo::forced`] said is forced again, and acts later.
    pub(crate) fn restore_forced(&mut self, [inputs, outputs]: [(u32, u32); 2]) {
        self.forced_inputs = Forced { mask: inputs.0, bits: inputs.1 };
        self.forced_outputs = Forced { mask: outputs.0, bits: outputs.1 };
    }
}
