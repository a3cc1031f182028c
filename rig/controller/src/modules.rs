//! The list of the controller's modules.

use crate::bus::ExpansionBus;
use crate::cartridge::Cartridge;
use crate::config::{Config, OutputsInStop};
use crate::effect::Effects;
use crate::memory::Memory;
use crate::module::{IoModule, ModuleChannel, TaskModule, fire};
use crate::state::State;
use crate::terminal::Terminal;
use profile::{IoChannel, IoStatus, ModuleFamily};
use signal::{Cause, Time, Value};

/// Which outputs of modules take their default values when initialization values are over (controller:OUT-05, controller:OUT-06).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum DefaultedOutputs {
    /// None.
    #[default]
    None,
    /// Those that nobody wrote, as the initial value of a variable does.
    Unwritten,
    /// Every one.
    All,
}

/// The modules after the embedded I/O: those that tasks exchange, then those on the bus in the order of the configuration.
#[derive(Debug)]
pub(crate) struct Modules {
    list: Vec<Box<dyn TaskModule>>,
    /// The expansion bus.
    pub(crate) bus: ExpansionBus,
    /// The TM4 modules that are fitted are not those that are configured. They are a chain of their own (io:BUS-04).
    tm4_differs: bool,
    /// That is an error, since there is an application.
    tm4_error: bool,
    /// At each update in STOPPED and HALT their outputs are set to their default values.
    at_defaults: bool,
    /// What becomes of them at the end of initialization values.
    defaulted: DefaultedOutputs,
}

impl Modules {
    /// The modules of a configuration that was found right: its cartridges, then those of the list.
    pub(crate) fn new(config: &Config, others: Vec<Box<dyn TaskModule>>) -> Modules {
        let places = config.reference.module_addresses(&config.modules).unwrap_or_default();
        let cartridges =
            config.modules.iter().zip(&places).filter(|(one, _)| one.module.family == ModuleFamily::Tmc4);
        let mut list: Vec<Box<dyn TaskModule>> = Vec::new();
        let mut fitted = config.fitted_in(ModuleFamily::Tmc4);
        for (configured, addresses) in cartridges {
            let is_fitted = config.fitted.is_none()
                || fitted.next().is_some_and(|module| module.reference == configured.module.reference);
            list.push(Box::new(Cartridge::new(configured, addresses, config.profile, is_fitted)));
        }
        list.extend(others);
        let bus = ExpansionBus::new(config, 1 + list.len());
        let tm4_differs = config.differs_in(ModuleFamily::Tm4);
        Modules {
            list,
            bus,
            tm4_differs,
            tm4_error: false,
            at_defaults: false,
            defaulted: DefaultedOutputs::None,
        }
    }

    /// The buses start with an application at `now`.
    pub(crate) fn start(&mut self, now: Time) {
        self.tm4_error = self.tm4_differs;
        self.bus.start(now);
    }

    /// There is no application any more.
    pub(crate) fn unload(&mut self) {
        self.tm4_error = false;
        self.bus.unload();
    }

    /// Whether the TM4 bus is in error.
    pub(crate) fn tm4_error(&self) -> bool {
        self.tm4_error
    }

    /// Each module that tasks exchange, first the embedded I/O.
    #[inline]
    pub(crate) fn exchanged<'a>(
        &'a mut self,
        embedded: &'a mut dyn TaskModule,
    ) -> impl Iterator<Item = &'a mut dyn TaskModule> {
        std::iter::once(embedded)
            .chain(self.list.iter_mut().map(|module| &mut **module as &mut dyn TaskModule))
    }

    /// Lets a change come to each module, first to the embedded I/O.
    #[inline]
    pub(crate) fn each(&mut self, embedded: &mut dyn TaskModule, mut change: impl FnMut(&mut dyn IoModule)) {
        change(embedded);
        self.list.iter_mut().for_each(|module| change(&mut **module));
        self.bus.each_module(change);
    }

    /// What is at the terminal of an input of a module from `now` on; 0 is the embedded I/O.
    #[inline]
    pub(crate) fn set_input(
        &mut self,
        embedded: &mut dyn IoModule,
        now: Time,
        terminal: Terminal,
        value: Value,
    ) {
        let IoChannel::Input(input) = terminal.channel else { return };
        let Some(place) = terminal.module.checked_sub(1) else {
            return embedded.set_input(now, input, value);
        };
        match self.list.get_mut(place) {
            Some(module) => module.set_input(now, input, value),
            None => self.bus.set_input(place - self.list.len(), now, input, value),
        }
    }

    /// The changes of outputs that are due at `now` come out; whether there were any.
    pub(crate) fn fire(&mut self, embedded: &mut dyn IoModule, now: Time, fx: &mut Effects) -> bool {
        let mut any = fire(0, embedded, now, fx);
        for (place, module) in self.list.iter_mut().enumerate() {
            any |= fire(1 + place, &mut **module, now, fx);
        }
        any | self.bus.fire(now, 1 + self.list.len(), fx)
    }

    /// Each module after the embedded I/O.
    fn others(&self) -> impl Iterator<Item = &dyn IoModule> {
        self.list.iter().map(|module| &**module as &dyn IoModule).chain(self.bus.modules())
    }

    /// The module of a number; 0 is the embedded I/O.
    pub(crate) fn get<'a>(&'a self, embedded: &'a dyn IoModule, module: usize) -> Option<&'a dyn IoModule> {
        match module.checked_sub(1) {
            None => Some(embedded),
            Some(place) => self.others().nth(place),
        }
    }

    /// What their outputs are set to from now on at updates in STOPPED and HALT: default values, or what is in %Q.
    pub(crate) fn fall_back(&mut self, outputs: OutputsInStop) {
        self.at_defaults = outputs == OutputsInStop::Default;
    }

    /// %Q of their outputs is no longer set to anything: there is another application, or none.
    pub(crate) fn forget_fallback(&mut self) {
        (self.at_defaults, self.defaulted) = (false, DefaultedOutputs::None);
    }

    /// Initialization values show from now on, whatever an earlier stop said; these outputs take their default values after them.
    pub(crate) fn begin_initialization(&mut self, defaulted: DefaultedOutputs) {
        (self.at_defaults, self.defaulted) = (false, defaulted);
    }

    /// Initialization values are over; whether %Q changed. A place that has its default value already is written by nobody.
    pub(crate) fn end_initialization(&mut self, memory: &mut Memory) -> bool {
        let defaulted = std::mem::take(&mut self.defaulted);
        self.set_defaults(memory, |channel, memory| {
            let is_meant = match defaulted {
                DefaultedOutputs::None => false,
                DefaultedOutputs::Unwritten => {
                    memory.writer(channel.address.bit_offset() as usize) == Cause::Unknown
                }
                DefaultedOutputs::All => true,
            };
            is_meant && memory.load(channel.address) != channel.default
        })
    }

    /// Sets %Q of their outputs to what [`Modules::fall_back`] said; whether it changed.
    pub(crate) fn set_stop_image(&self, memory: &mut Memory) -> bool {
        self.at_defaults && self.set_defaults(memory, |_, _| true)
    }

    /// Sets %Q of the outputs that are meant to their default values; whether it changed.
    fn set_defaults(&self, memory: &mut Memory, is_meant: impl Fn(&ModuleChannel, &Memory) -> bool) -> bool {
        let mut changed = false;
        for channel in self.others().flat_map(|module| module.channels()) {
            if matches!(channel.channel, IoChannel::Output(_)) && is_meant(channel, memory) {
                changed |= memory.load(channel.address) != channel.default;
                memory.set_cause(Cause::Controller);
                memory.store(channel.address, channel.default);
            }
        }
        changed
    }

    /// When something happens in one of them by itself.
    #[inline]
    pub(crate) fn next(&self) -> Time {
        self.list.iter().map(|module| module.next()).min().unwrap_or(Time::MAX).min(self.bus.next())
    }

    /// The status of the first of them that is not as it should be (controller:SYS-06). None is configured without an
    /// application.
    pub(crate) fn status(&self, state: State) -> IoStatus {
        if state == State::Empty && !self.list.is_empty() {
            return IoStatus::NotInitialised;
        }
        let bus = self.bus.status();
        if bus != IoStatus::Ok {
            return bus;
        }
        let wrong = self.list.iter().map(|module| module.status()).find(|status| *status != IoStatus::Ok);
        wrong.unwrap_or(IoStatus::Ok)
    }
}
