//! The expansion bus of TM3 and TM2 modules (io: sections 10 to 12).
//!
//! The bus cycle task alone exchanges with the modules, all of them at one instant: their inputs as its cycle begins, their
//! outputs as it ends. Every task reads and writes a virtual image in between (io:BUS-09, controller:PRIO-06,
//! controller:PRIO-07). In STOPPED and HALT each update of inputs and outputs is such a cycle (controller:STOP-04).
//!
//! A module that fails two exchanges in a row is an error of the bus (io:ERR-03). Under active handling the bus then goes off
//! until something starts it again (io:ERR-06, io:ERR-07); under passive handling, which is that of 2014, the exchange with the
//! others goes on (io:ERR-09).

mod analogue;
mod digital;
mod exchange;
mod fitted;
mod force;
pub(crate) mod image;
mod internal_status;
mod safety;
mod start;

pub use force::ForcedPlaces;
pub use start::{BusStart, ConfiguredPosition, ExtraModules, PositionState, compare_modules};

use crate::analogue::AnalogueModule;
use crate::command::CommandError;
use crate::config::Config;
use crate::effect::Effects;
use crate::external::ModuleFault;
use crate::memory::Memory;
use crate::module::{IoModule, Sharing, fire};
use digital::DigitalModule;
use exchange::Exchange;
use fitted::FittedModules;
use image::{SharedBits, VirtualImage};
use profile::{
    ChannelStatus, ConfiguredModule, ExchangeCode, IoStatus, LOCAL_MODULES, ModuleAddresses, ModuleFamily,
    ModuleKind, ModuleState, ModuleType, NO_FIRMWARE_VERSION, Profile, Tm3BusState, module_indices,
};
use safety::SafetyModule;
use signal::{Address, Area, Cause, Image, Time, Value};

/// A module as the bus sees it.
pub(crate) trait BusModule: IoModule {
    /// Its inputs as they are at `now` -> the virtual image of %I.
    fn read(&mut self, now: Time, inputs: &mut Image);

    /// Its outputs in the virtual image of %Q -> their stages at `now`. The memory knows who wrote them last.
    fn write(&mut self, now: Time, outputs: &Image, memory: &Memory);

    /// Its outputs are switched to 0 at `now`, by the module itself.
    fn clear(&mut self, now: Time);

    /// Its own supply is there or off from `now` on. Nothing happens in a module without one.
    fn supply(&mut self, _now: Time, _on: bool) {}

    /// The status of a channel, inputs before outputs, as it is at `now` or was read last; none beyond its last channel and of a
    /// module without such a table (plcsystem:FUN-90, plcsystem:FUN-91).
    fn internal_status(&mut self, _now: Time, _channel: usize) -> Option<ChannelStatus> {
        None
    }

    /// What it has in %I beside its channels.
    fn status_bytes(&self) -> &[Address] {
        &[]
    }

    /// Such a module is at its terminals from now on, in place of the configured one or of another of the same internal ID code:
    /// it has delays, and may have other channels, of its own.
    fn fit(&mut self, _module: &ModuleType) {}
}

/// The model of a module that is configured so, with this number.
fn model(
    number: usize,
    configured: &ConfiguredModule<'_>,
    addresses: &ModuleAddresses,
    worst_case: bool,
) -> Box<dyn BusModule> {
    match configured.module.kind {
        ModuleKind::Analogue => Box::new(AnalogueModule::new(configured, addresses)),
        ModuleKind::Safety => Box::new(SafetyModule::new(configured.module, addresses)),
        _ => Box::new(DigitalModule::new(number, configured.module, addresses, worst_case)),
    }
}

/// A configured module on the bus.
#[derive(Debug)]
struct Position {
    /// What is configured there.
    configured: ConfiguredPosition,
    /// The internal ID code that answered when the bus was started last.
    found: Option<u8>,
    /// The place of the fitted module that this position has: what the comparison gave it, else its own.
    place: usize,
    /// What is fitted there, as far as its channels follow it.
    fitted: &'static ModuleType,
    /// It has its supply.
    supplied: bool,
    module: Box<dyn BusModule>,
    exchange: Exchange,
    /// The bus cycle task exchanges all of its channels (io:BUS-11).
    always_update: bool,
}

impl Position {
    /// What the module has in the images.
    fn places(&self) -> impl Iterator<Item = Address> {
        let channels = self.module.channels().iter().map(|channel| channel.address);
        channels.chain(self.module.status_bytes().iter().copied())
    }

    /// Its outputs are 0 from `now` on. A module that is not there, or has no supply, drives nothing, and so not 0 V either.
    fn clear(&mut self, now: Time) {
        if self.supplied {
            self.module.clear(now);
        }
    }

    /// Its module has the channels of what is fitted, and the exchange reaches as far as the bus does.
    fn follow(&mut self, all: &FittedModules) {
        let fitted = all.module(self.place);
        if let Some(module) = fitted.filter(|module| !std::ptr::eq(*module, self.fitted)) {
            self.fitted = module;
            self.module.fit(module);
        }
        self.supplied = all.is_supplied(self.place);
        let is_configured = fitted.is_some_and(|module| module.id == Some(self.configured.id));
        let reached = is_configured && all.reached().any(|place| place == self.place);
        self.exchange.reach(reached, all.is_disturbed(self.place));
    }
}

/// The bus with the configured modules.
#[derive(Debug)]
pub(crate) struct ExpansionBus {
    /// In the order of the configuration.
    positions: Vec<Position>,
    fitted: FittedModules,
    /// The fitted cartridges are not those of the configuration, which keeps the bus off (io:CART-03).
    cartridges_differ: bool,
    /// Modules were left over when the bus was started last, or cartridges differed.
    extra: bool,
    image: VirtualImage,
    /// What each task exchanges with the virtual image, by rank.
    shared: Vec<SharedBits>,
    /// The same of an update in STOPPED and HALT: everything.
    all: SharedBits,
    /// The outputs on which forcing comes to act with the cycles of each task, by rank: those that it writes, or exchanges where
    /// none writes them (controller:FRC-05).
    forced_with: Vec<Vec<Address>>,
    forced: ForcedPlaces,
    /// Rank of the bus cycle task.
    bus_cycle: Option<usize>,
    /// The controller of 2014: errors are handled passively, whatever is commanded (plcsystem:TM3V-06).
    only_passive: bool,
    /// Errors switch the bus off (io:ERR-06).
    active: bool,
    /// Nothing is exchanged until the bus is started again.
    is_off: bool,
    /// What it found when it was started last.
    start_state: Tm3BusState,
    /// The state of a module changed since somebody asked.
    changed: bool,
    /// When something happens by itself, on the bus or in a module: kept, because the controller asks at each turn.
    due: Time,
}

impl ExpansionBus {
    /// The bus of a configuration that was found right; `first` is the number of the first module on it.
    pub(crate) fn new(config: &Config, first: usize) -> ExpansionBus {
        let indices = module_indices(&config.modules);
        let places = config.reference.module_addresses(&config.modules).unwrap_or_default();
        let configured = config.modules.iter().zip(places).zip(indices);
        let on_bus = configured.filter_map(|(one, index)| Some((one, index?))).enumerate();
        let mut positions: Vec<Position> = on_bus
            .map(|(place, ((configured, addresses), index))| Position {
                configured: ConfiguredPosition {
                    index,
                    id: configured.module.id.unwrap_or(0),
                    optional: configured.optional,
                },
                found: None,
                place,
                fitted: configured.module,
                supplied: true,
                module: model(first + place, configured, &addresses, config.worst_case),
                exchange: Exchange::new(configured.module.family == ModuleFamily::Tm3),
                always_update: configured.always_update,
            })
            .collect();
        let configured: Vec<ConfiguredPosition> = positions.iter().map(|it| it.configured).collect();
        let local = configured.iter().filter(|one| one.index < LOCAL_MODULES).count();
        let fitted: Vec<&ModuleType> = match &config.fitted {
            Some(fitted) => fitted.iter().copied().filter(|module| module.is_on_bus()).collect(),
            None => positions.iter().map(|it| it.fitted).collect(),
        };
        let fitted = FittedModules::new(&configured, local, &fitted);
        for position in &mut positions {
            position.follow(&fitted);
        }
        let all = SharedBits::of(positions.iter().flat_map(Position::places), |_| true);
        ExpansionBus {
            positions,
            fitted,
            cartridges_differ: config.differs_in(ModuleFamily::Tmc4),
            extra: false,
            image: VirtualImage::new(config.profile),
            shared: Vec::new(),
            forced_with: Vec::new(),
            forced: ForcedPlaces::default(),
            all,
            bus_cycle: None,
            only_passive: config.profile == Profile::M241_2014,
            active: config.profile != Profile::M241_2014,
            is_off: false,
            start_state: Tm3BusState::Ok,
            changed: false,
            due: Time::MAX,
        }
        .looking_ahead()
    }

    /// Its modules, in the order of the configuration.
    pub(crate) fn modules(&self) -> impl Iterator<Item = &dyn IoModule> {
        self.positions.iter().map(|it| &*it.module as &dyn IoModule)
    }

    /// Lets a change come to each module, in the order of the configuration.
    pub(crate) fn each_module(&mut self, mut change: impl FnMut(&mut dyn IoModule)) {
        self.positions.iter_mut().for_each(|it| change(&mut *it.module));
        self.look_ahead();
    }

    /// What is at the terminal of an input of the module at this place from `now` on.
    pub(crate) fn set_input(&mut self, place: usize, now: Time, input: usize, value: Value) {
        let Some(Position { module, .. }) = self.positions.get_mut(place) else { return };
        let before = module.next();
        module.set_input(now, input, value);
        if module.next() != before {
            self.look_ahead();
        }
    }

    fn looking_ahead(mut self) -> ExpansionBus {
        self.look_ahead();
        self
    }

    /// Finds out when something happens by itself. Whatever may have changed that calls it.
    fn look_ahead(&mut self) {
        self.due = self.earliest();
    }

    fn earliest(&self) -> Time {
        let each = |it: &Position| it.module.next().min(it.exchange.outputs_off());
        self.positions.iter().map(each).min().unwrap_or(Time::MAX)
    }

    /// Learns which task of a new application uses which channels.
    pub(crate) fn share(&mut self, sharing: &Sharing<'_>) {
        let places = || self.positions.iter().flat_map(Position::places);
        let always: Vec<Address> =
            self.positions.iter().filter(|it| it.always_update).flat_map(Position::places).collect();
        let exchanges = |rank, at: Address| {
            sharing.exchanges(rank, at) || Some(rank) == sharing.bus_cycle() && always.contains(&at)
        };
        let of = |rank| SharedBits::of(places(), |at| exchanges(rank, at));
        self.shared = (0..sharing.tasks()).map(of).collect();
        let forced_with = |rank| {
            let outputs = places().filter(|at| at.area() == Area::Output);
            let written = |at| (0..sharing.tasks()).any(|other| sharing.writes(other, at));
            let comes = |at: &Address| sharing.writes(rank, *at) || exchanges(rank, *at) && !written(*at);
            outputs.filter(comes).collect()
        };
        self.forced_with = (0..sharing.tasks()).map(forced_with).collect();
        self.bus_cycle = sharing.bus_cycle();
    }

    /// The bus starts with an application: after a boot, a download or a reset (io:OPT-02, io:ERR-07). It stays off where a
    /// mandatory module does not answer, another one than the configured one does, modules are left over, it has no supply, or
    /// cartridges differ: from that it starts only with what is configured (io:CART-03).
    pub(crate) fn start(&mut self, now: Time) {
        let configured: Vec<ConfiguredPosition> =
            self.positions.iter().map(|position| position.configured).collect();
        let reached: Vec<usize> = self.fitted.reached().collect();
        let answers = |place: &usize| {
            let silent = self.positions.get(*place).is_some_and(|it| it.exchange.is_silent());
            if silent { None } else { self.fitted.module(*place)?.id }
        };
        let ids: Vec<Option<u8>> = reached.iter().map(answers).collect();
        let start = compare_modules(&configured, &ids, ExtraModules::default());
        for (own, position) in self.positions.iter_mut().enumerate() {
            let Some(found) = start.modules.get(position.configured.index) else { continue };
            position.found = found.fitted;
            position.place = found.place.and_then(|place| reached.get(place).copied()).unwrap_or(own);
            position.exchange.start(now, found.state);
            // What a silent module kept ends here (io:ERR-11).
            if found.state == ModuleState::BusError {
                position.clear(now);
            }
        }
        let differs = self.cartridges_differ;
        self.start_state = match self.fitted.has_supply() {
            false => Tm3BusState::PowerSupplyError,
            true if differs => Tm3BusState::ConfigurationError,
            true => start.state,
        };
        (self.extra, self.changed) = (start.extra > 0 || differs, true);
        self.follow(now);
        self.is_off = false;
        if (self.active || differs) && self.start_state != Tm3BusState::Ok {
            self.switch_off(now);
        }
        self.look_ahead();
    }

    /// Something is wrong with the module of this index of TM3_MODULE_R from `now` on, or is over.
    pub(crate) fn fault(&mut self, now: Time, index: usize, fault: ModuleFault) {
        let Some(place) = self.positions.iter().position(|it| it.configured.index == index) else { return };
        match fault {
            ModuleFault::Silent(exchanges) => self.positions[place].exchange.silence(exchanges),
            ModuleFault::Pulled(pulled) => self.fitted.pull(place, pulled),
            ModuleFault::Replaced(module) => self.fitted.replace(place, module),
            ModuleFault::Unsupplied(off) => self.positions[place].module.supply(now, !off),
            ModuleFault::Disturbs(disturbs) => {
                self.positions[place].exchange.silence(if disturbs { None } else { Some(0) });
                self.fitted.disturb(place, disturbs);
            }
        }
        self.follow(now);
    }

    /// The bus has its supply from `now` on, or not (io:HW-04). Under active handling it starts by what starts it after an error
    /// (io:ERR-07), else as its supply is there.
    pub(crate) fn supply(&mut self, now: Time, on: bool) {
        self.fitted.supply(on);
        self.changed = true;
        self.follow(now);
        if on && !self.active && self.start_state == Tm3BusState::PowerSupplyError {
            self.start(now);
        }
    }

    /// Transmitter and receiver are joined from `now` on, or not.
    pub(crate) fn link(&mut self, now: Time, whole: bool) {
        self.fitted.link(whole);
        self.follow(now);
    }

    /// What is fitted, reached or supplied changed: the modules follow. One that loses its supply has its hardware initialization
    /// values, and begins from them as it has it again.
    fn follow(&mut self, now: Time) {
        for position in &mut self.positions {
            let (before, was_supplied) = (position.fitted, position.supplied);
            position.follow(&self.fitted);
            let is_another = !std::ptr::eq(position.fitted, before);
            if was_supplied && (is_another || !position.supplied) {
                position.module.initialize(now);
            }
            if position.supplied && (is_another || !was_supplied) {
                position.module.power_on(now);
            }
        }
        self.look_ahead();
    }

    /// How errors are handled from now on. A bus that is off stays so.
    pub(crate) fn set_passive(&mut self, passive: bool) {
        self.active = !(passive || self.only_passive);
    }

    /// Starts the bus again under active handling with a module in error; else nothing happens (io:ERR-16, io:ERR-17).
    pub(crate) fn restart(&mut self, now: Time) {
        if self.active && self.is_in_error() {
            self.start(now);
        }
    }

    /// There is no application any more: what is in the virtual image is of nobody.
    pub(crate) fn unload(&mut self) {
        self.image.clear();
        (self.is_off, self.start_state, self.extra) = (false, Tm3BusState::Ok, false);
        for position in &mut self.positions {
            position.found = None;
            position.exchange.stop();
        }
        self.look_ahead();
    }

    /// The state of the module of this index of TM3_MODULE_R (io:DIAG-01).
    pub(crate) fn state(&self, index: usize) -> ModuleState {
        let found = self.positions.iter().find(|position| position.configured.index == index);
        found.map_or(ModuleState::Empty, |position| position.exchange.state())
    }

    /// The internal ID code of the module of this index; 0 where none was found (io:DIAG-01).
    pub(crate) fn id(&self, index: usize) -> u8 {
        let found = self.positions.iter().find(|position| position.configured.index == index);
        found.and_then(|position| position.found).unwrap_or(0)
    }

    fn at(&self, index: i64) -> Option<&Position> {
        let index = usize::try_from(index).ok()?;
        self.positions.iter().find(|position| position.configured.index == index)
    }

    /// The code of the last exchange with the module of this index (io:DIAG-04).
    pub(crate) fn exchange_code(&self, index: i64) -> ExchangeCode {
        self.at(index).map_or(ExchangeCode::Parameter, |position| position.exchange.code())
    }

    /// The version of the firmware of the module of this index (io:DIAG-05), which only a module in order gives.
    pub(crate) fn firmware(&self, index: i64) -> u16 {
        let in_order = self.at(index).filter(|it| it.exchange.state() == ModuleState::Ok);
        in_order.and_then(|it| it.fitted.firmware).unwrap_or(NO_FIRMWARE_VERSION)
    }

    /// What the bus found when it was started last, or that it has no supply (io:DIAG-03).
    pub(crate) fn start_state(&self) -> Tm3BusState {
        if self.fitted.has_supply() { self.start_state } else { Tm3BusState::PowerSupplyError }
    }

    /// Whether the state of a module changed since this was asked last.
    pub(crate) fn take_changed(&mut self) -> bool {
        std::mem::take(&mut self.changed)
    }

    /// Whether a module is in error (io:ERR-02).
    pub(crate) fn is_in_error(&self) -> bool {
        self.has(ModuleState::BusError)
    }

    fn has(&self, state: ModuleState) -> bool {
        self.positions.iter().any(|position| position.exchange.state() == state)
    }

    /// What is wrong with it: an error of the bus goes before modules that are not those of the configuration (controller:ERR-01).
    pub(crate) fn status(&self) -> IoStatus {
        if self.is_in_error() {
            IoStatus::BusError
        } else if self.extra || self.has(ModuleState::ConfigurationError) {
            IoStatus::ConfigurationFault
        } else {
            IoStatus::Ok
        }
    }

    /// Whether the cycle of this rank, or an update without one, exchanges with the modules.
    #[inline]
    fn is_bus_cycle(&self, rank: Option<usize>) -> bool {
        rank.is_none() || rank == self.bus_cycle
    }

    /// A cycle begins: the inputs of the modules -> virtual image, if it is the bus cycle; virtual image -> %I, as far as the task
    /// uses it. Whether %I changed.
    #[inline]
    pub(crate) fn begin_cycle(&mut self, now: Time, rank: Option<usize>, memory: &mut Memory) -> bool {
        if self.positions.is_empty() {
            return false;
        }
        if self.is_bus_cycle(rank) && !self.is_off {
            for Position { module, exchange, .. } in &mut self.positions {
                let before = exchange.state();
                if exchange.succeeds(now) {
                    module.read(now, &mut self.image.inputs);
                }
                self.changed |= exchange.state() != before;
            }
            if self.active && self.is_in_error() {
                self.switch_off(now);
            }
            self.look_ahead();
        }
        let shared = rank.and_then(|rank| self.shared.get(rank)).unwrap_or(&self.all);
        let shared = if self.is_off { &self.all } else { shared };
        let changed = self.image.to_inputs(shared, memory);
        if self.forced.is_empty() {
            return changed;
        }
        let here = self.forced.inputs().filter(|(address, _)| shared.has(*address));
        here.fold(changed, |any, (address, value)| any | memory.store(address, value))
    }

    /// A cycle ends: %Q -> virtual image, as far as the task writes it; virtual image -> outputs of the modules, if it is the bus
    /// cycle. Whether %Q changed: while the bus is off, that of all modules is 0 (io:ERR-06).
    #[inline]
    pub(crate) fn end_cycle(&mut self, now: Time, rank: Option<usize>, memory: &mut Memory) -> bool {
        if self.positions.is_empty() {
            return false;
        }
        if self.is_off {
            return self.all.clear_outputs(memory);
        }
        let shared = rank.and_then(|rank| self.shared.get(rank)).unwrap_or(&self.all);
        let changed = !self.forced.is_empty() && {
            let comes =
                |at| rank.and_then(|rank| self.forced_with.get(rank)).is_none_or(|all| all.contains(&at));
            memory.set_cause(Cause::Controller);
            let here = self.forced.outputs(comes).filter(|(address, _)| shared.has(*address));
            here.fold(false, |any, (address, value)| any | memory.store(address, value))
        };
        self.image.take_outputs(shared, memory);
        if self.is_bus_cycle(rank) {
            for Position { module, exchange, .. } in &mut self.positions {
                if exchange.is_written() {
                    module.write(now, &self.image.outputs, memory);
                }
            }
            self.look_ahead();
        }
        changed
    }

    /// Forces the channel at this place, or ends that.
    ///
    /// # Errors
    /// No module has a channel there, or there is no room for another place.
    pub(crate) fn force(&mut self, address: Address, value: Option<u64>) -> Result<(), CommandError> {
        let channels = self.positions.iter().flat_map(|it| it.module.channels());
        if !channels.into_iter().any(|channel| channel.address == address) {
            return Err(CommandError::NoChannel(address));
        }
        match value {
            Some(value) if !self.forced.force(address, value) => return Err(CommandError::TooManyForced),
            Some(_) => {}
            None => self.forced.release(address),
        }
        Ok(())
    }

    /// What is forced.
    pub(crate) fn forced(&self) -> ForcedPlaces {
        self.forced
    }

    /// These places are forced from now on, and act later.
    pub(crate) fn restore_forced(&mut self, forced: ForcedPlaces) {
        self.forced = forced.waiting();
    }

    /// All outputs and both images are 0 until the bus is started again (io:ERR-06).
    fn switch_off(&mut self, now: Time) {
        self.is_off = true;
        self.image.clear();
        for position in &mut self.positions {
            position.clear(now);
        }
    }

    /// When something happens by itself: an edge of an output comes out, or the outputs of a silent module switch themselves off;
    /// [`Time::MAX`] for never.
    #[inline]
    pub(crate) fn next(&self) -> Time {
        debug_assert_eq!(self.due, self.earliest(), "somebody did not look ahead");
        self.due
    }

    /// What is due at `now` happens; `first` is the number of the first module. Whether an output changed.
    pub(crate) fn fire(&mut self, now: Time, first: usize, fx: &mut Effects) -> bool {
        if self.next() > now {
            return false;
        }
        let mut any = false;
        for (place, position) in self.positions.iter_mut().enumerate() {
            if position.exchange.outputs_off() <= now {
                position.exchange.switched_off();
                position.clear(now);
            }
            any |= fire(first + place, &mut *position.module, now, fx);
        }
        self.look_ahead();
        any
    }
}
