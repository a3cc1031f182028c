//! A cartridge of an M241: its channels are exchanged by each task, as the embedded ones are (io: section 9).

use crate::analogue::AnalogueModule;
use crate::bus::image::{SharedBits, VirtualImage};
use crate::memory::Memory;
use crate::module::{ExchangeCycle, IoModule, ModuleChannel, OutputChanges, Sharing, TaskModule, Written};
use profile::{ConfiguredModule, IoStatus, ModuleAddresses, Profile};
use signal::{Address, Time, Value};

/// The cartridge.
#[derive(Debug)]
pub(crate) struct Cartridge {
    module: AnalogueModule,
    /// It is in its slot: else its inputs are open, and nothing drives its outputs (io:CART-03).
    fitted: bool,
    /// What it last read and was last written.
    image: VirtualImage,
    /// What each task exchanges, by rank.
    shared: Vec<SharedBits>,
    /// The same of an update in STOPPED and HALT: everything.
    all: SharedBits,
}

impl Cartridge {
    /// The cartridge as it is configured, at these places of the images; `fitted` where it is in its slot.
    pub(crate) fn new(
        configured: &ConfiguredModule<'_>,
        addresses: &ModuleAddresses,
        profile: Profile,
        fitted: bool,
    ) -> Cartridge {
        let module = AnalogueModule::new(configured, addresses);
        let all = SharedBits::of(module.places(), |_| true);
        Cartridge { module, fitted, image: VirtualImage::new(profile), shared: Vec::new(), all }
    }

    fn shared(&self, cycle: ExchangeCycle) -> &SharedBits {
        cycle.rank.and_then(|rank| self.shared.get(rank)).unwrap_or(&self.all)
    }
}

impl IoModule for Cartridge {
    fn channels(&self) -> &[ModuleChannel] {
        self.module.channels()
    }

    fn power_on(&mut self, now: Time) {
        if self.fitted {
            self.module.power_on(now);
        }
    }

    fn power_off(&mut self, now: Time) {
        self.module.power_off(now);
    }

    fn set_input(&mut self, now: Time, input: usize, value: Value) {
        if self.fitted {
            self.module.set_input(now, input, value);
        }
    }

    fn initialize(&mut self, now: Time) {
        self.image.clear();
        self.module.initialize(now);
    }

    fn next(&self) -> Time {
        self.module.next()
    }

    fn fire(&mut self, now: Time, changes: &mut OutputChanges<'_>) {
        self.module.fire(now, changes);
    }

    fn output(&self, output: usize) -> Value {
        self.module.output(output)
    }
}

impl TaskModule for Cartridge {
    fn share(&mut self, sharing: &Sharing<'_>) {
        let of =
            |rank| SharedBits::of(self.module.places(), |address: Address| sharing.exchanges(rank, address));
        self.shared = (0..sharing.tasks()).map(of).collect();
    }

    fn sample(&mut self, now: Time, cycle: ExchangeCycle, memory: &mut Memory) -> bool {
        if self.fitted {
            self.module.read(now, &mut self.image.inputs);
        }
        self.image.to_inputs(self.shared(cycle), memory)
    }

    fn drive(&mut self, now: Time, cycle: ExchangeCycle, memory: &mut Memory) -> Written {
        let shared = cycle.rank.and_then(|rank| self.shared.get(rank)).unwrap_or(&self.all);
        self.image.take_outputs(shared, memory);
        if self.fitted {
            self.module.write(now, &self.image.outputs, memory);
        }
        Written::default()
    }

    fn status(&self) -> IoStatus {
        IoStatus::Ok
    }
}
