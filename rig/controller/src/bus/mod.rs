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
pub(crate) mod image;
mod internal_status;
mod start;

pub use start::{BusStart, ConfiguredPosition, ExtraModules, PositionState, compare_modules};

use crate::analogue::AnalogueModule;
use crate::config::Config;
use crate::memory::Memory;
use crate::module::{IoModule, Sharing};
use digital::DigitalModule;
use exchange::Exchange;
use image::{SharedBytes, VirtualImage};
use profile::{
    ChannelStatus, ConfiguredModule, ModuleAddresses, ModuleFamily, ModuleKind, ModuleState, Profile,
    Tm3BusState, module_indices,
};
use signal::{Address, Image, Time};

/// A module as the bus sees it.
pub(crate) trait BusModule: IoModule {
    /// Its inputs as they are at `now` -> the virtual image of %I.
    fn read(&mut self, now: Time, inputs: &mut Image);

    /// Its outputs in the virtual image of %Q -> their stages at `now`. The memory knows who wrote them last.
    fn write(&mut self, now: Time, outputs: &Image, memory: &Memory);

    /// Its outputs are switched to 0 at `now`, by the module itself.
    fn clear(&mut self, now: Time);

    /// The status of a channel, inputs before outputs, as it is at `now` or was read last; none beyond its last channel and of a
    /// module without such a table (plcsystem:FUN-90, plcsystem:FUN-91).
    fn internal_status(&mut self, _now: Time, _channel: usize) -> Option<ChannelStatus> {
        None
    }

    /// What it has in %I beside its channels.
    fn status_bytes(&self) -> &[Address] {
        &[]
    }
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
    module: Box<dyn BusModule>,
    exchange: Exchange,
}

impl Position {
    /// What the module has in the images.
    fn places(&self) -> impl Iterator<Item = Address> {
        let channels = self.module.channels().iter().map(|channel| channel.address);
        channels.chain(self.module.status_bytes().iter().copied())
    }
}

/// The bus with the configured modules.
#[derive(Debug)]
pub(crate) struct ExpansionBus {
    /// In the order of the configuration.
    positions: Vec<Position>,
    image: VirtualImage,
    /// What each task exchanges with the virtual image, by rank.
    shared: Vec<SharedBytes>,
    /// The same of an update in STOPPED and HALT: everything.
    all: SharedBytes,
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
}

impl ExpansionBus {
    /// The bus of a configuration that was found right; `first` is the number of the first module on it.
    pub(crate) fn new(config: &Config, first: usize) -> ExpansionBus {
        let indices = module_indices(&config.modules);
        let places = config.reference.module_addresses(&config.modules).unwrap_or_default();
        let configured = config.modules.iter().zip(places).zip(indices);
        let on_bus = configured.filter_map(|(one, index)| Some((one, index?))).enumerate();
        let positions: Vec<Position> = on_bus
            .map(|(place, ((configured, addresses), index))| Position {
                configured: ConfiguredPosition {
                    index,
                    id: configured.module.id.unwrap_or(0),
                    optional: configured.optional,
                },
                found: None,
                module: model(first + place, configured, &addresses, config.worst_case),
                exchange: Exchange::new(configured.module.family == ModuleFamily::Tm3),
            })
            .collect();
        let all = SharedBytes::of(positions.iter().flat_map(Position::places), |_| true);
        ExpansionBus {
            positions,
            image: VirtualImage::new(config.profile),
            shared: Vec::new(),
            all,
            bus_cycle: None,
            only_passive: config.profile == Profile::M241_2014,
            active: config.profile != Profile::M241_2014,
            is_off: false,
            start_state: Tm3BusState::Ok,
            changed: false,
        }
    }

    /// Its modules, in the order of the configuration.
    pub(crate) fn modules(&self) -> impl Iterator<Item = &dyn IoModule> {
        self.positions.iter().map(|it| &*it.module as &dyn IoModule)
    }

    /// The same, to be changed.
    pub(crate) fn modules_mut(&mut self) -> impl Iterator<Item = &mut dyn IoModule> {
        self.positions.iter_mut().map(|it| &mut *it.module as &mut dyn IoModule)
    }

    /// Learns which task of a new application uses which channels.
    pub(crate) fn share(&mut self, sharing: &Sharing<'_>) {
        let places = || self.positions.iter().flat_map(Position::places);
        let of = |rank| SharedBytes::of(places(), |address| sharing.exchanges(rank, address));
        self.shared = (0..sharing.tasks()).map(of).collect();
        self.bus_cycle = sharing.bus_cycle();
    }

    /// The bus starts with an application: after a boot, a download or a reset (io:OPT-02, io:ERR-07). A mandatory module that does
    /// not answer keeps it off.
    pub(crate) fn start(&mut self, now: Time) {
        let configured: Vec<ConfiguredPosition> =
            self.positions.iter().map(|position| position.configured).collect();
        let answers = |it: &Position| it.exchange.answers().then_some(it.configured.id);
        let fitted: Vec<Option<u8>> = self.positions.iter().map(answers).collect();
        let start = compare_modules(&configured, &fitted, ExtraModules::default());
        for position in &mut self.positions {
            let Some(found) = start.modules.get(position.configured.index) else { continue };
            position.found = found.fitted;
            position.exchange.start(now, found.state);
        }
        self.is_off = self.active && !start.starts();
        (self.start_state, self.changed) = (start.state, true);
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
        (self.is_off, self.start_state) = (false, Tm3BusState::Ok);
        for position in &mut self.positions {
            position.found = None;
            position.exchange.stop();
        }
    }

    /// The module of this index of TM3_MODULE_R is silent from now on, for so many exchanges or until another number is given; with
    /// 0 it answers again. Whether there is one.
    pub(crate) fn silence(&mut self, index: usize, exchanges: Option<u32>) -> bool {
        let found = self.positions.iter_mut().find(|position| position.configured.index == index);
        found.map(|position| position.exchange.silence(exchanges)).is_some()
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

    /// What the bus found when it was started last (io:DIAG-03).
    pub(crate) fn start_state(&self) -> Tm3BusState {
        self.start_state
    }

    /// Whether the state of a module changed since this was asked last.
    pub(crate) fn take_changed(&mut self) -> bool {
        std::mem::take(&mut self.changed)
    }

    /// Whether a module is in error (io:ERR-02).
    pub(crate) fn is_in_error(&self) -> bool {
        self.positions.iter().any(|position| position.exchange.state() == ModuleState::BusError)
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
        }
        let shared = rank.and_then(|rank| self.shared.get(rank)).unwrap_or(&self.all);
        self.image.to_inputs(if self.is_off { &self.all } else { shared }, memory)
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
        self.image.take_outputs(shared, memory);
        if self.is_bus_cycle(rank) {
            for Position { module, exchange, .. } in &mut self.positions {
                if exchange.is_written() {
                    module.write(now, &self.image.outputs, memory);
                }
            }
        }
        false
    }

    /// All outputs and both images are 0 until the bus is started again (io:ERR-06).
    fn switch_off(&mut self, now: Time) {
        self.is_off = true;
        self.image.clear();
        for position in &mut self.positions {
            position.module.clear(now);
        }
    }

    /// When the outputs of a silent module switch themselves off; [`Time::MAX`] for never.
    pub(crate) fn next(&self) -> Time {
        self.positions.iter().map(|position| position.exchange.outputs_off()).min().unwrap_or(Time::MAX)
    }

    /// What is due at `now` happens.
    pub(crate) fn fire(&mut self, now: Time) {
        for Position { module, exchange, .. } in &mut self.positions {
            if exchange.outputs_off() <= now {
                exchange.switched_off();
                module.clear(now);
            }
        }
    }
}
