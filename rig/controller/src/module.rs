//! What the controller asks of a module of inputs and outputs.
//!
//! A module knows neither tasks nor programs. It gets the images at the beginning and at the end of cycles, says when
//! something happens in it by itself, and reports what its outputs do. Nothing of it allocates between two calls of
//! [`TaskModule::share`].

use crate::application::Application;
use crate::config::AlwaysUpdate;
use crate::effect::{Effect, Effects};
use crate::memory::Memory;
use crate::terminal::Terminal;
use profile::{IoChannel, IoStatus};
use signal::{Address, Area, Cause, Span, Time, Value};
use std::fmt;

/// A channel of a module and its place in the images: a bit for a digital channel, a word for an analogue one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ModuleChannel {
    /// The channel.
    pub channel: IoChannel,
    /// Its place in %I or %Q.
    pub address: Address,
    /// What the place of an output takes where outputs are set to their default values (controller:STOP-03).
    pub default: u64,
}

impl ModuleChannel {
    /// A channel whose default value is 0.
    pub const fn new(channel: IoChannel, address: Address) -> ModuleChannel {
        ModuleChannel { channel, address, default: 0 }
    }
}

/// Which cycle exchanges the images.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ExchangeCycle {
    /// The rank of the task whose cycle it is; none for an update in STOPPED and HALT, which exchanges every channel.
    pub rank: Option<usize>,
    /// It is one of MAST, or an update without a task: latches are read (io:STD-IN-04).
    pub mast: bool,
}

/// What a write of outputs did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Written {
    /// Forcing changed %Q.
    pub image_changed: bool,
    /// Protection had a part in it: status and stages of outputs may be others.
    pub stages_changed: bool,
}

/// A module with terminals: embedded, cartridge or expansion.
pub trait IoModule: fmt::Debug + Send {
    /// Its channels.
    fn channels(&self) -> &[ModuleChannel];

    /// The electronics come up at `now`, with what is at the terminals.
    fn power_on(&mut self, now: Time);

    /// The electronics lose their supply at `now`: nothing happens by itself until they have it again. Outputs show their
    /// hardware initialization values by then.
    fn power_off(&mut self, now: Time);

    /// What is at the terminal of an input from `now` on: a level ([`Value::HighZ`] where nothing drives the line), or a
    /// number in the unit of the channel. Inputs that it does not have are ignored.
    fn set_input(&mut self, now: Time, input: usize, value: Value);

    /// Outputs show their hardware initialization values from `now` on (controller:OUT-02).
    fn initialize(&mut self, now: Time);

    /// When something happens here by itself; [`Time::MAX`] for never.
    fn next(&self) -> Time;

    /// The changes of outputs that are due at `now` come out.
    fn fire(&mut self, now: Time, changes: &mut OutputChanges<'_>);

    /// What the terminal of an output shows: a level, or a number in the unit of the channel; [`Value::HighZ`] where it
    /// drives nothing. Unknown for one that it does not have.
    fn output(&self, output: usize) -> Value;
}

/// A module that each task exchanges by itself, at the beginning and at the end of its cycles: the embedded inputs and
/// outputs, and cartridges (controller:PRIO-04).
pub trait TaskModule: IoModule {
    /// Learns which task of a new application exchanges which of its channels.
    fn share(&mut self, sharing: &Sharing<'_>);

    /// The inputs that this cycle exchanges -> %I, at its beginning; whether %I changed.
    fn sample(&mut self, now: Time, cycle: ExchangeCycle, memory: &mut Memory) -> bool;

    /// %Q -> the outputs that this cycle exchanges, at its end.
    fn drive(&mut self, now: Time, cycle: ExchangeCycle, memory: &mut Memory) -> Written;

    /// How it is.
    fn status(&self) -> IoStatus;
}

/// Where a module reports what its outputs do.
#[derive(Debug)]
pub struct OutputChanges<'a> {
    module: usize,
    fx: &'a mut Effects,
    /// Something was reported.
    any: bool,
}

impl OutputChanges<'_> {
    /// The terminal of an output shows another value from `at` on.
    pub fn push(&mut self, at: Time, output: usize, value: Value, cause: Cause) {
        let terminal = Terminal { module: self.module, channel: IoChannel::Output(output) };
        self.report(Effect::Terminal { at, terminal, value, cause, early: Span::ZERO });
    }

    /// What only the embedded outputs do.
    pub(crate) fn report(&mut self, effect: Effect) {
        self.any = true;
        self.fx.push(effect);
    }
}

/// Which task exchanges which places of the images (controller:PRIO-04, controller:DEV-10, controller:DEV-12).
pub struct Sharing<'a> {
    application: &'a dyn Application,
    /// Places of the tasks, by rank.
    places: &'a [usize],
    /// Rank of the bus cycle task, which exchanges what no task uses.
    bus_cycle: Option<usize>,
    always_update: AlwaysUpdate,
}

impl fmt::Debug for Sharing<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Sharing").field("places", &self.places).finish_non_exhaustive()
    }
}

impl<'a> Sharing<'a> {
    pub(crate) fn new(
        application: &'a dyn Application,
        places: &'a [usize],
        bus_cycle: Option<usize>,
        always_update: AlwaysUpdate,
    ) -> Sharing<'a> {
        Sharing { application, places, bus_cycle, always_update }
    }

    /// Rank of the bus cycle task.
    pub(crate) const fn bus_cycle(&self) -> Option<usize> {
        self.bus_cycle
    }

    /// Number of tasks: ranks are below it.
    pub fn tasks(&self) -> usize {
        self.places.len()
    }

    /// Whether the programs of a task read this place of %I, or write into the bytes of this place of %Q.
    fn uses(&self, rank: usize, at: Address) -> bool {
        let (first, bits) = (at.bit_offset(), at.bit_len());
        let mut bits = first..first + bits;
        match at.area() {
            Area::Input => bits.any(|bit| self.application.reads_input(self.places[rank], bit)),
            Area::Output => bits.any(|bit| self.application.writes_output(self.places[rank], bit / 8)),
            Area::Memory => false,
        }
    }

    /// Whether a task exchanges this place of %I or %Q.
    pub fn exchanges(&self, rank: usize, at: Address) -> bool {
        let as_bus_cycle = || match self.always_update {
            AlwaysUpdate::Disabled => false,
            AlwaysUpdate::Unused => !(0..self.tasks()).any(|other| self.uses(other, at)),
            AlwaysUpdate::Always => true,
        };
        self.uses(rank, at) || (Some(rank) == self.bus_cycle && as_bus_cycle())
    }

    /// Whether the programs of a task write this very place of %Q (controller:FRC-05); [`Sharing::exchanges`] goes by whole
    /// bytes.
    pub fn writes(&self, rank: usize, at: Address) -> bool {
        let first = at.bit_offset();
        let mut bits = first..first + at.bit_len();
        at.area() == Area::Output
            && bits.any(|bit| self.application.writes_output_bit(self.places[rank], bit))
    }
}

/// Has a module report the changes of its outputs that are due; whether there were any.
pub(crate) fn fire(module: usize, it: &mut dyn IoModule, now: Time, fx: &mut Effects) -> bool {
    let mut changes = OutputChanges { module, fx, any: false };
    it.fire(now, &mut changes);
    changes.any
}
