//! Function blocks that are not written in Structured Text: a table of typed pins with a Rust body each.

mod standard;

pub use standard::STANDARD;

use crate::types::Elementary;
use signal::Time;

/// Who may set a pin of a native block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PinKind {
    /// Set by the caller.
    Input,
    /// Read by the caller.
    Output,
    /// The block's own memory, not visible to the program.
    Hidden,
}

/// One pin: a cell of an instance.
#[derive(Clone, Copy, Debug)]
pub struct Pin {
    /// Name in capitals.
    pub name: &'static str,
    /// Who may set it.
    pub kind: PinKind,
    /// Type. Hidden pins may hold any 64 bits whatever their type; LINT says so best.
    pub ty: Elementary,
}

/// A function block with a Rust body. An instance is one cell for each pin, 0 at the start.
#[derive(Debug)]
pub struct Native {
    /// Name of the type in capitals.
    pub name: &'static str,
    /// Pins in the order of positional parameters.
    pub pins: &'static [Pin],
    /// One call. It must not allocate, and finish in bounded time.
    pub run: fn(&mut Pins<'_>),
}

/// The pins of one instance during a call.
#[derive(Debug)]
pub struct Pins<'a> {
    pub(crate) cells: &'a mut [i64],
    pub(crate) flags: &'a [u8],
    pub(crate) now: Time,
    /// Flags of the cells that changed.
    pub(crate) changed: u8,
}

impl Pins<'_> {
    /// Modelled time at which the call takes effect.
    pub fn now(&self) -> Time {
        self.now
    }

    /// The cell of a pin; 0 where there is no such pin.
    #[inline]
    pub fn get(&self, pin: usize) -> i64 {
        self.cells.get(pin).copied().unwrap_or(0)
    }

    /// Whether a pin is not 0.
    #[inline]
    pub fn on(&self, pin: usize) -> bool {
        self.get(pin) != 0
    }

    /// Sets the cell of a pin, which the caller has brought into the range of its type.
    #[inline]
    pub fn set(&mut self, pin: usize, value: i64) {
        if let (Some(cell), Some(flags)) = (self.cells.get_mut(pin), self.flags.get(pin))
            && *cell != value
        {
            *cell = value;
            self.changed |= flags;
        }
    }
}
