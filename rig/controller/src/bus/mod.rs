//! The expansion bus of TM3 and TM2 modules (io: sections 10 to 12).
//!
//! The bus cycle task alone exchanges with the modules, all of them at one instant: their inputs as its cycle begins, their
//! outputs as it ends. Every task reads and writes a virtual image in between (io:BUS-09, controller:PRIO-06,
//! controller:PRIO-07). In STOPPED and HALT each update of inputs and outputs is such a cycle (controller:STOP-04).

mod digital;
mod image;
mod start;

pub use start::{BusStart, ConfiguredPosition, ExtraModules, PositionState, compare_modules};

use crate::config::Config;
use crate::memory::Memory;
use crate::module::{IoModule, Sharing};
use digital::DigitalModule;
use image::{SharedBytes, VirtualImage};
use profile::{ModuleKind, ModuleType, module_indices};
use signal::{Image, Time};

/// A module as the bus sees it.
pub(crate) trait BusModule: IoModule {
    /// Its inputs as they are at `now` -> the virtual image of %I.
    fn read(&mut self, now: Time, inputs: &mut Image);

    /// Its outputs in the virtual image of %Q -> their stages at `now`. The memory knows who wrote them last.
    fn write(&mut self, now: Time, outputs: &Image, memory: &Memory);
}

/// Whether there is a model of such a module.
pub fn is_module_modelled(module: &ModuleType) -> bool {
    module.kind.is_link() || module.is_on_bus() && module.kind == ModuleKind::Digital
}

/// The bus with the configured modules.
#[derive(Debug)]
pub(crate) struct ExpansionBus {
    /// In the order of the configuration.
    modules: Vec<Box<dyn BusModule>>,
    image: VirtualImage,
    /// What each task exchanges with the virtual image, by rank.
    shared: Vec<SharedBytes>,
    /// The same of an update in STOPPED and HALT: everything.
    all: SharedBytes,
    /// Rank of the bus cycle task.
    bus_cycle: Option<usize>,
}

impl ExpansionBus {
    /// The bus of a configuration that was found right; `first` is the number of the first module on it.
    pub(crate) fn new(config: &Config, first: usize) -> ExpansionBus {
        let on_bus = module_indices(&config.modules);
        let places = config.reference.module_addresses(&config.modules).unwrap_or_default();
        let configured = config.modules.iter().zip(places).zip(on_bus).filter(|(_, index)| index.is_some());
        let modules: Vec<Box<dyn BusModule>> = configured
            .enumerate()
            .map(|(place, ((configured, addresses), _))| {
                let module =
                    DigitalModule::new(first + place, configured.module, &addresses, config.worst_case);
                Box::new(module) as Box<dyn BusModule>
            })
            .collect();
        let all = SharedBytes::of(modules.iter().flat_map(|module| module.channels()), |_| true);
        ExpansionBus {
            modules,
            image: VirtualImage::new(config.profile),
            shared: Vec::new(),
            all,
            bus_cycle: None,
        }
    }

    /// Its modules, in the order of the configuration.
    pub(crate) fn modules(&self) -> impl Iterator<Item = &dyn IoModule> {
        self.modules.iter().map(|module| &**module as &dyn IoModule)
    }

    /// The same, to be changed.
    pub(crate) fn modules_mut(&mut self) -> impl Iterator<Item = &mut dyn IoModule> {
        self.modules.iter_mut().map(|module| &mut **module as &mut dyn IoModule)
    }

    /// Learns which task of a new application uses which channels.
    pub(crate) fn share(&mut self, sharing: &Sharing<'_>) {
        let channels = || self.modules.iter().flat_map(|module| module.channels());
        let of = |rank| SharedBytes::of(channels(), |address| sharing.exchanges(rank, address));
        self.shared = (0..sharing.tasks()).map(of).collect();
        self.bus_cycle = sharing.bus_cycle();
    }

    /// There is no application any more: what is in the virtual image is of nobody.
    pub(crate) fn unload(&mut self) {
        self.image.clear();
    }

    /// Whether the cycle of this rank, or an update without one, exchanges with the modules.
    #[inline]
    fn is_bus_cycle(&self, rank: Option<usize>) -> bool {
        rank.is_none() || rank == self.bus_cycle
    }

    #[inline]
    fn shared(&self, rank: Option<usize>) -> &SharedBytes {
        rank.and_then(|rank| self.shared.get(rank)).unwrap_or(&self.all)
    }

    /// A cycle begins: the inputs of the modules -> virtual image, if it is the bus cycle; virtual image -> %I, as far as the task
    /// uses it. Whether %I changed.
    #[inline]
    pub(crate) fn begin_cycle(&mut self, now: Time, rank: Option<usize>, memory: &mut Memory) -> bool {
        if self.modules.is_empty() {
            return false;
        }
        if self.is_bus_cycle(rank) {
            for module in &mut self.modules {
                module.read(now, &mut self.image.inputs);
            }
        }
        self.image.to_inputs(self.shared(rank), memory)
    }

    /// A cycle ends: %Q -> virtual image, as far as the task writes it; virtual image -> outputs of the modules, if it is the bus
    /// cycle.
    #[inline]
    pub(crate) fn end_cycle(&mut self, now: Time, rank: Option<usize>, memory: &Memory) {
        if self.modules.is_empty() {
            return;
        }
        let shared = rank.and_then(|rank| self.shared.get(rank)).unwrap_or(&self.all);
        self.image.take_outputs(shared, memory);
        if self.is_bus_cycle(rank) {
            for module in &mut self.modules {
                module.write(now, &self.image.outputs, memory);
            }
        }
    }
}
