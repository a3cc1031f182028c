//! What is configured: reference, tasks, filters, behaviour in stop and at power-on.

mod choice;
mod error;
mod events;
mod input;
mod relocation;
mod task;
mod warnings;

pub use choice::{AlwaysUpdate, BusCycle, HaltOutputs, OutputsInStop, Rearming, StartingMode, WatchdogBasis};
pub use error::ConfigError;
pub use input::{InputConfig, InputFault, RunStopFault};
pub use relocation::{RelocationConfig, RelocationPart};
pub use task::{TaskConfig, TaskKind, TaskWatchdog};
pub use warnings::Warning;

use expert::{ExpertConfig, ExpertError, InputConditions, ReservedChannels};
use profile::{
    ChannelSet, ConfiguredModule, MINIMUM_CYCLE, ModuleFamily, ModuleKind, ModuleType, PRIORITIES, Profile,
    Reference,
};
use signal::Span;

/// Whether there is a model of such a module. What a TM4 module carries has none: it is there, or not.
pub fn is_module_modelled(module: &ModuleType) -> bool {
    match module.kind {
        ModuleKind::Transmitter | ModuleKind::Receiver => true,
        ModuleKind::Digital | ModuleKind::Safety => module.is_on_bus(),
        // Load cells have their words, and no document has a mode of them: nobody can use such a channel.
        ModuleKind::Analogue => true,
        ModuleKind::Expert => module.digital_inputs.is_some(),
        ModuleKind::Communication => module.family == ModuleFamily::Tm4,
    }
}

/// The configuration of a controller. The place of a task in `tasks` is its number everywhere.
#[derive(Clone, Debug, PartialEq)]
pub struct Config {
    /// Which documented controller (controller:CONV-01).
    pub profile: Profile,
    /// Which reference of it.
    pub reference: &'static Reference,
    /// The tasks; one of them is MAST (controller:TASK-51).
    pub tasks: Vec<TaskConfig>,
    /// Parameters of each embedded input from I0; inputs beyond the list have a filter of 4 ms and nothing else.
    pub inputs: Vec<InputConfig>,
    /// The Run/Stop input: n for In (controller:RS-03).
    pub run_stop_input: Option<usize>,
    /// The embedded outputs whose default value is 1 (controller:OUT-01).
    pub output_defaults: ChannelSet,
    /// Behaviour for outputs in Stop (controller:DEV-10).
    pub outputs_in_stop: OutputsInStop,
    /// What outputs do in HALT.
    pub halt_outputs: HaltOutputs,
    /// Update IO while in stop (controller:STOP-04).
    pub update_io_in_stop: bool,
    /// The output that shows that the application is running: n for Qn (controller:RS-08).
    pub alarm_output: Option<usize>,
    /// How outputs that protection switched off come back.
    pub rearming: Rearming,
    /// Outputs are written where the next cycle of the bus cycle task reads its inputs (controller:PRIO-08).
    pub minimize_jitter: bool,
    /// The CANopen manager produces or consumes SYNC: CAN Sync can start a task (controller:TASK-42).
    pub can_sync: bool,
    /// Edges of outputs whose delays are documented as maxima say by how much they may have come earlier (io:STD-OUT-01).
    pub worst_case: bool,
    /// By so many seconds a week the clock is fast without a correction, or slow below 0 (controller:HW-10).
    pub clock_drift: i64,
    /// A programming tool is connected when the power comes on (controller:FRC-01).
    pub tool_connected: bool,
    /// Starting mode (controller:DEV-10).
    pub starting_mode: StartingMode,
    /// What the time of a task watchdog measures (controller:WD-10).
    pub watchdog_basis: WatchdogBasis,
    /// The relocation table (controller:REL-01).
    pub relocation: RelocationConfig,
    /// The bus cycle task (controller:PRIO-06, controller:DEV-10).
    pub bus_cycle_task: BusCycle,
    /// MAST exchanges with the modules on the expansion bus, whatever the bus cycle task (io:BUS-08).
    pub io_bus_mast: bool,
    /// Always update variables (controller:DEV-10, controller:DEV-12).
    pub always_update: AlwaysUpdate,
    /// Fast counters and pulse generators (io: section 6).
    pub expert: ExpertConfig,
    /// Expansion modules and cartridges, in the order of the device tree (io: sections 9 and 10).
    pub modules: Vec<ConfiguredModule<'static>>,
    /// What is fitted beside the controller, in the order of the bus; exactly `modules` if none.
    pub fitted: Option<Vec<&'static ModuleType>>,
    /// Inputs behind whose terminals hardware counts: fast counters take its counts in place of edges.
    pub counted: ChannelSet,
}

impl Config {
    /// The defaults of a profile: its default reference, MAST alone, filters of 4 ms, outputs to default in stop,
    /// inputs and outputs updated in stop, start as previous state (controller:DEV-10).
    pub fn new(profile: Profile) -> Config {
        Config {
            profile,
            reference: profile.default_reference(),
            tasks: vec![TaskConfig::mast()],
            inputs: Vec::new(),
            run_stop_input: None,
            output_defaults: ChannelSet::EMPTY,
            outputs_in_stop: OutputsInStop::default(),
            halt_outputs: HaltOutputs::default(),
            update_io_in_stop: true,
            alarm_output: None,
            rearming: Rearming::default(),
            minimize_jitter: false,
            can_sync: false,
            worst_case: false,
            clock_drift: 0,
            tool_connected: true,
            starting_mode: StartingMode::default(),
            watchdog_basis: WatchdogBasis::default(),
            relocation: RelocationConfig::default(),
            bus_cycle_task: BusCycle::default(),
            io_bus_mast: false,
            always_update: AlwaysUpdate::default_of(profile),
            expert: ExpertConfig::default(),
            modules: Vec::new(),
            fitted: None,
            counted: ChannelSet::EMPTY,
        }
    }

    /// Place of the bus cycle task (controller:PRIO-06): of cyclic tasks of one interval the first one.
    pub fn bus_cycle(&self) -> Option<usize> {
        match self.bus_cycle_task {
            BusCycle::Mast => self.task("MAST"),
            BusCycle::Task(place) => Some(place),
            BusCycle::Slowest => {
                let cyclic = self.tasks.iter().enumerate();
                let cyclic = cyclic.filter_map(|(place, task)| Some((task.interval()?, place)));
                let slowest = cyclic.max_by_key(|(interval, place)| (*interval, std::cmp::Reverse(*place)));
                slowest.map(|(_, place)| place).or_else(|| self.task("MAST"))
            }
        }
    }

    /// Place of the task that exchanges with the modules on the expansion bus (io:BUS-08).
    pub fn io_bus_cycle(&self) -> Option<usize> {
        if self.io_bus_mast { self.task("MAST") } else { self.bus_cycle() }
    }

    /// Place of the task with this name, in any case of letters.
    pub fn task(&self, name: &str) -> Option<usize> {
        self.tasks.iter().position(|task| task.name.eq_ignore_ascii_case(name))
    }

    /// The numbers of tasks against their limits (controller:TASK-01): by kind first, then in all.
    fn check_numbers(&self) -> Result<(), ConfigError> {
        let limits = self.profile.task_limits(self.reference);
        let count = |of: fn(&TaskKind) -> bool| self.tasks.iter().filter(|task| of(&task.kind)).count();
        let freewheeling = count(|kind| matches!(kind, TaskKind::Freewheeling));
        let cyclic = if freewheeling == 0 { limits.cyclic } else { limits.cyclic_beside_freewheeling };
        for (kind, found, most) in [
            ("cyclic", count(|kind| matches!(kind, TaskKind::Cyclic { .. })), cyclic),
            ("freewheeling", freewheeling, limits.freewheeling),
            ("event", count(|kind| matches!(kind, TaskKind::Event { .. })), limits.event),
            (
                "external event",
                count(|kind| matches!(kind, TaskKind::ExternalEvent { .. })),
                limits.external_event,
            ),
        ] {
            if found > most {
                return Err(ConfigError::TooManyOfKind { kind, found, most });
            }
        }
        let found = self.tasks.len();
        if found > limits.total {
            return Err(ConfigError::TooManyTasks { found, most: limits.total });
        }
        Ok(())
    }

    /// Whether a controller of the profile accepts the configuration.
    ///
    /// # Errors
    /// The first [`ConfigError`].
    pub fn check(&self) -> Result<(), ConfigError> {
        if !self.profile.accepts(self.reference) {
            return Err(ConfigError::Reference);
        }
        let Some(mast) = self.task("MAST").and_then(|place| self.tasks.get(place)) else {
            return Err(ConfigError::NoMast);
        };
        if !mast.runs_by_itself() {
            return Err(ConfigError::MastKind);
        }
        self.check_numbers()?;
        for (place, task) in self.tasks.iter().enumerate() {
            if !PRIORITIES.contains(&task.priority) {
                return Err(ConfigError::Priority { task: place, priority: task.priority });
            }
            if let Some(interval) = task.interval().filter(|interval| *interval < MINIMUM_CYCLE) {
                return Err(ConfigError::Interval { task: place, interval });
            }
            if let TaskKind::ExternalEvent { source } = task.kind
                && !source.exists(self.profile, self.reference)
            {
                return Err(ConfigError::Event { task: place, event: source });
            }
            if let TaskKind::ExternalEvent { source } = task.kind
                && !self.raises(source)
            {
                return Err(ConfigError::NoEvent { task: place, event: source });
            }
            if task.watchdog.is_some_and(|watchdog| watchdog.time <= Span::ZERO) {
                return Err(ConfigError::WatchdogTime { task: place });
            }
            for (other, earlier) in self.tasks[..place].iter().enumerate() {
                if earlier.name.eq_ignore_ascii_case(&task.name) {
                    return Err(ConfigError::SameName { tasks: (other, place) });
                }
                if earlier.priority == task.priority && self.profile != Profile::M241_2014 {
                    return Err(ConfigError::SamePriority { tasks: (other, place), priority: task.priority });
                }
            }
        }
        for bus in [self.bus_cycle(), self.io_bus_cycle()] {
            if !bus.and_then(|place| self.tasks.get(place)).is_some_and(TaskConfig::runs_by_itself) {
                return Err(ConfigError::BusCycleTask);
            }
        }
        if !self.always_update.exists(self.profile) {
            return Err(ConfigError::AlwaysUpdate);
        }
        self.check_modules()?;
        self.check_inputs()?;
        if let Some(error) = self.check_expert().first() {
            return Err(ConfigError::Expert(*error));
        }
        let outputs = self.reference.output_count();
        if !(self.output_defaults - ChannelSet::first(outputs)).is_empty() {
            return Err(ConfigError::OutputDefaults { outputs });
        }
        if self.alarm_output.is_some_and(|output| output >= outputs) {
            return Err(ConfigError::AlarmOutput { outputs });
        }
        if outputs == 0 && (self.minimize_jitter || self.rearming == Rearming::Manual) {
            return Err(ConfigError::NoOutputs);
        }
        if self.can_sync && !self.reference.has_can() {
            return Err(ConfigError::NoCan);
        }
        Ok(())
    }

    /// Whether the modules can be configured so (io: sections 9, 10 and 12).
    /// The fitted modules of a family, in their order; none where those are fitted that are configured.
    pub(crate) fn fitted_in(&self, family: ModuleFamily) -> impl Iterator<Item = &'static ModuleType> {
        self.fitted.iter().flatten().copied().filter(move |module| module.family == family)
    }

    /// Whether the fitted modules of a family are not those of the configuration, by their references.
    pub(crate) fn differs_in(&self, family: ModuleFamily) -> bool {
        let configured = self.modules.iter().filter(|one| one.module.family == family);
        let references = configured.map(|one| one.module.reference.as_str());
        self.fitted.is_some()
            && !references.eq(self.fitted_in(family).map(|module| module.reference.as_str()))
    }

    fn check_modules(&self) -> Result<(), ConfigError> {
        profile::check_modules(self.profile, self.reference, &self.modules).map_err(ConfigError::Module)?;
        if let Some(place) = self.modules.iter().position(|one| !is_module_modelled(one.module)) {
            return Err(ConfigError::NoModuleModel { place });
        }
        self.reference.module_addresses(&self.modules).map(drop).map_err(ConfigError::ImageFull)
    }

    /// Everything for which the profile does not accept the expert functions.
    pub fn check_expert(&self) -> Vec<ExpertError> {
        let advanced = self.inputs.iter().enumerate().filter(|(_, input)| input.is_expert());
        let taken = ReservedChannels {
            advanced: advanced.map(|(input, _)| input).collect(),
            run_stop: self.run_stop_input,
            alarm: self.alarm_output,
        };
        self.expert.check(self.profile, self.reference, &taken)
    }

    /// The way from each input to the expert functions, from I0 on.
    pub fn input_conditions(&self) -> Vec<InputConditions> {
        let bounce = |input: usize| self.inputs.get(input).map(|own| own.bounce).unwrap_or_default();
        profile::inputs(self.reference)
            .map(|input| InputConditions { delay: input.delay, bounce: bounce(input.index).span() })
            .collect()
    }

    /// Whether the inputs can have their parameters (io: section 3).
    ///
    /// # Errors
    /// The first [`ConfigError`].
    pub fn check_inputs(&self) -> Result<(), ConfigError> {
        let inputs = self.reference.input_count();
        if self.inputs.len() > inputs {
            return Err(ConfigError::Inputs { found: self.inputs.len(), inputs });
        }
        let used = self.expert.inputs();
        for (input, config) in self.inputs.iter().enumerate() {
            let checked = config.check(input, used.contains(input), self.reference);
            checked.map_err(|fault| ConfigError::Input { input, fault })?;
        }
        if let Some(input) = self.run_stop_input {
            let config = self.inputs.get(input);
            let checked = RunStopFault::check(input, config, self.profile, self.reference);
            checked.map_err(|fault| ConfigError::RunStopInput { input, fault })?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::event_source::ExternalEventSource;

    fn with(change: impl FnOnce(&mut Config)) -> Result<(), ConfigError> {
        let mut config = Config::new(Profile::default());
        change(&mut config);
        config.check()
    }

    fn cyclic(name: &str, priority: u8) -> TaskConfig {
        TaskConfig { name: name.into(), priority, ..TaskConfig::mast() }
    }

    #[test]
    fn defaults_are_accepted() {
        assert!(Profile::ALL.iter().all(|profile| Config::new(*profile).check().is_ok()));
    }

    // controller:TASK-01, controller:TASK-51, controller:PRIO-01, controller:PRIO-02
    #[test]
    fn each_limit_is_refused() {
        assert_eq!(with(|c| c.tasks[0].name = "FAST".into()), Err(ConfigError::NoMast));
        assert_eq!(with(|c| c.tasks[0].name = "mast".into()), Ok(()));
        let many = |c: &mut Config| c.tasks.extend((0..5).map(|n| cyclic(&format!("T{n}"), n)));
        assert_eq!(with(many), Err(ConfigError::TooManyOfKind { kind: "cyclic", found: 6, most: 5 }));
        let old = |c: &mut Config| {
            c.profile = Profile::M241_2014;
            c.tasks.extend((0..4).map(|n| cyclic(&format!("T{n}"), n)));
        };
        assert_eq!(with(old), Err(ConfigError::TooManyOfKind { kind: "cyclic", found: 5, most: 4 }));
        let same = ConfigError::SamePriority { tasks: (0, 1), priority: 15 };
        assert_eq!(with(|c| c.tasks.push(cyclic("B", 15))), Err(same));
        assert_eq!(with(|c| c.tasks.push(cyclic("Mast", 1))), Err(ConfigError::SameName { tasks: (0, 1) }));
        assert_eq!(with(|c| c.tasks[0].priority = 32), Err(ConfigError::Priority { task: 0, priority: 32 }));
        let short = Span::from_nanos(999);
        assert_eq!(
            with(|c| c.tasks[0].kind = TaskKind::Cyclic { interval: short }),
            Err(ConfigError::Interval { task: 0, interval: short })
        );
        assert_eq!(with(|c| c.profile = Profile::M251_2024), Err(ConfigError::Reference));
        assert_eq!(with(|c| c.output_defaults.insert(10)), Err(ConfigError::OutputDefaults { outputs: 10 }));
        assert_eq!(
            with(|c| c.inputs = vec![InputConfig::default(); 15]),
            Err(ConfigError::Inputs { found: 15, inputs: 14 })
        );
    }

    // controller:TASK-42
    #[test]
    fn can_sync_starts_a_task_where_the_manager_has_it() {
        let sync = |can_sync| {
            with(|c| {
                let kind = TaskKind::ExternalEvent { source: ExternalEventSource::CanSync };
                c.tasks.push(TaskConfig { kind, ..cyclic("SYNC", 1) });
                c.can_sync = can_sync;
            })
        };
        assert_eq!(sync(true), Ok(()));
        assert_eq!(sync(false), Err(ConfigError::NoEvent { task: 1, event: ExternalEventSource::CanSync }));
        let mese = |c: &mut Config| {
            *c = Config::new(Profile::M251_2024);
            (c.reference, c.can_sync) = (Reference::find("TM251MESE").unwrap(), true);
        };
        assert_eq!(with(mese), Err(ConfigError::NoCan));
    }

    // controller:RS-03, controller:RS-05
    #[test]
    fn inputs_that_cannot_run_and_stop_are_refused() {
        let refused = |input, fault| Err(ConfigError::RunStopInput { input, fault });
        assert_eq!(with(|c| c.run_stop_input = Some(13)), Ok(()));
        assert_eq!(with(|c| c.run_stop_input = Some(14)), refused(14, RunStopFault::Beyond { most: 14 }));
        let old = |c: &mut Config| (c.profile, c.run_stop_input) = (Profile::M241_2014, Some(8));
        assert_eq!(with(old), refused(8, RunStopFault::Beyond { most: 8 }));
        let m251 = |c: &mut Config| {
            *c = Config::new(Profile::M251_2024);
            c.run_stop_input = Some(0);
        };
        assert_eq!(with(m251), refused(0, RunStopFault::NoneAtAll));
        let latch = |c: &mut Config| {
            let latch = InputConfig { latch: true, ..InputConfig::filtered(profile::InputFilter::None) };
            (c.inputs, c.run_stop_input) = (vec![latch], Some(0));
        };
        assert_eq!(with(latch), refused(0, RunStopFault::Expert));
    }
}
