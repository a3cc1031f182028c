//! Function blocks that are not written in Structured Text: a table of typed pins with a Rust body each.

mod bistables;
mod clock;
mod counters;
mod timers;

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

/// One pin: a value in the memory of an instance.
#[derive(Clone, Copy, Debug)]
pub struct Pin {
    /// Name in capitals.
    pub name: &'static str,
    /// Who may set it.
    pub kind: PinKind,
    /// Type. Hidden pins may hold any 64 bits whatever their type; LINT says so best.
    pub ty: Elementary,
}

/// What a block does at a call.
#[derive(Clone, Copy, Debug)]
pub enum BlockBody {
    /// This, with nothing but its pins. It must not allocate, and finish in bounded time.
    Own(fn(&mut Pins<'_>)),
    /// Whoever runs the program does it, and knows the block by this number: [`crate::Host::block`].
    Host(u16),
}

/// A function block that is not written in Structured Text. All bytes of an instance are 0 at the start.
#[derive(Clone, Copy, Debug)]
pub struct Native {
    /// Name of the type in capitals.
    pub name: &'static str,
    /// Pins in the order of positional parameters.
    pub pins: &'static [Pin],
    /// One call.
    pub body: BlockBody,
}

/// Alignment and granularity of instances, in bytes.
const ALIGNMENT: usize = 8;

impl Native {
    /// Where the pins lie in an instance, in bytes from its start, and the size of an instance: each pin at a multiple
    /// of its size, the instance a multiple of 8 bytes.
    pub(crate) fn layout(&self) -> (Vec<u16>, u32) {
        let offsets: Vec<u16> = (0..self.pins.len()).map(|pin| offset(self.pins, pin)).collect();
        let ends = offsets.iter().zip(self.pins).map(|(offset, pin)| usize::from(*offset) + pin.ty.bytes());
        (offsets.clone(), ends.max().unwrap_or(0).next_multiple_of(ALIGNMENT) as u32)
    }

    /// The place of the pin that a program may call by this name, in capitals.
    ///
    /// The controllers' tool and the standard name some pins of the same blocks differently (RESET and R); both are
    /// taken.
    pub(crate) fn pin(&self, key: &str) -> Option<usize> {
        const OTHER_NAMES: [(&str, &str); 9] = [
            ("R", "RESET"),
            ("RESET", "R"),
            ("LD", "LOAD"),
            ("LOAD", "LD"),
            ("S", "SET"),
            ("S1", "SET1"),
            ("R1", "RESET1"),
            ("EN", "IN"),
            ("IN", "EN"),
        ];
        let named = |name| self.pins.iter().position(|pin| pin.kind != PinKind::Hidden && pin.name == name);
        named(key).or_else(|| {
            OTHER_NAMES.iter().filter(|(other, _)| *other == key).find_map(|(_, name)| named(name))
        })
    }
}

/// Where a pin lies in an instance, in bytes.
const fn offset(pins: &[Pin], pin: usize) -> u16 {
    let (mut nth, mut end) = (0, 0usize);
    loop {
        let bytes = pins[nth].ty.bytes();
        let offset = end.next_multiple_of(bytes);
        if nth == pin {
            // A table of pins is written by hand: it has no 8,000 of them.
            return offset as u16;
        }
        (nth, end) = (nth + 1, offset + bytes);
    }
}

/// A block whose body is made for its pins: where they lie and of what type they are is known when it is compiled.
macro_rules! native {
    ($name:expr, $pins:expr, $run:ident) => {
        Native {
            name: $name,
            pins: $pins,
            body: {
                const PINS: &[Pin] = $pins;
                const OFFSETS: [u16; PINS.len()] = {
                    let mut offsets = [0; PINS.len()];
                    let mut pin = 0;
                    while pin < PINS.len() {
                        offsets[pin] = crate::native::offset(PINS, pin);
                        pin += 1;
                    }
                    offsets
                };
                crate::native::BlockBody::Own(|pins| pins.of(PINS, &OFFSETS, $run))
            },
        }
    };
}
use native;

/// The standard blocks of IEC 61131-3 (controller:LIB-01, library Standard): timers, counters, edges, bistables and the
/// real-time clock.
pub const STANDARD: &[Native] = &{
    const TABLES: [&[Native]; 4] = [timers::BLOCKS, counters::BLOCKS, bistables::BLOCKS, clock::BLOCKS];
    const COUNT: usize = TABLES[0].len() + TABLES[1].len() + TABLES[2].len() + TABLES[3].len();
    let mut all = [TABLES[0][0]; COUNT];
    let (mut table, mut place, mut next) = (0, 0, 0);
    while next < COUNT {
        if place == TABLES[table].len() {
            (table, place) = (table + 1, 0);
        } else {
            all[next] = TABLES[table][place];
            (place, next) = (place + 1, next + 1);
        }
    }
    all
};

/// The pins of one instance during a call.
#[derive(Debug)]
pub struct Pins<'a> {
    bytes: &'a mut [u8],
    pins: &'static [Pin],
    offsets: &'a [u16],
    flags: &'a [u8],
    now: Time,
    /// Flags of the bytes that changed.
    pub(crate) changed: u8,
}

impl<'a> Pins<'a> {
    /// The pins of the instance in `bytes`, laid out as [`Native::layout`] says. `flags` are those of the bytes from
    /// the first on; bytes beyond them have none.
    pub(crate) fn new(
        bytes: &'a mut [u8],
        pins: &'static [Pin],
        offsets: &'a [u16],
        flags: &'a [u8],
        now: Time,
    ) -> Self {
        Pins { bytes, pins, offsets, flags, now, changed: 0 }
    }

    /// Runs a block on the same instance, with its pins as they were when it was compiled.
    #[inline(always)]
    fn of(&mut self, pins: &'static [Pin], offsets: &'static [u16], run: impl FnOnce(&mut Pins<'_>)) {
        let Pins { bytes, flags, now, .. } = self;
        let mut known = Pins { bytes, pins, offsets, flags, now: *now, changed: 0 };
        run(&mut known);
        self.changed |= known.changed;
    }

    /// Modelled time at which the call takes effect.
    #[inline(always)]
    pub fn now(&self) -> Time {
        self.now
    }

    /// The type of a pin; LINT where there is no such pin.
    #[inline(always)]
    pub fn ty(&self, pin: usize) -> Elementary {
        self.pins.get(pin).map_or(Elementary::Lint, |pin| pin.ty)
    }

    /// The cell of a pin; 0 where there is no such pin.
    #[inline(always)]
    pub fn get(&self, pin: usize) -> i64 {
        self.read(pin).unwrap_or(0)
    }

    /// Whether a pin is not 0.
    #[inline(always)]
    pub fn on(&self, pin: usize) -> bool {
        self.get(pin) != 0
    }

    /// Sets the cell of a pin; its high bits are cut off to the type of the pin.
    #[inline(always)]
    pub fn set(&mut self, pin: usize, value: i64) {
        let ty = self.ty(pin);
        let value = ty.wrap(value);
        if self.read(pin).is_none_or(|old| old == value) {
            return;
        }
        let start = self.offsets.get(pin).map_or(0, |offset| usize::from(*offset));
        let end = start + ty.bytes();
        if let Some(stored) = self.bytes.get_mut(start..end) {
            for (byte, new) in stored.iter_mut().zip(value.to_le_bytes()) {
                *byte = new;
            }
        }
        for flags in self.flags.iter().take(end).skip(start) {
            self.changed |= flags;
        }
    }

    #[inline(always)]
    fn read(&self, pin: usize) -> Option<i64> {
        let ty = self.pins.get(pin)?.ty;
        let bytes = self.bytes.get(usize::from(*self.offsets.get(pin)?)..)?;
        let raw = match ty.bytes() {
            1 => i64::from(*bytes.first()?),
            2 => i64::from(u16::from_le_bytes(*bytes.first_chunk()?)),
            4 => i64::from(u32::from_le_bytes(*bytes.first_chunk()?)),
            _ => i64::from_le_bytes(*bytes.first_chunk()?),
        };
        Some(ty.wrap(raw))
    }
}

const fn input(name: &'static str, ty: Elementary) -> Pin {
    Pin { name, kind: PinKind::Input, ty }
}

const fn output(name: &'static str, ty: Elementary) -> Pin {
    Pin { name, kind: PinKind::Output, ty }
}

const fn hidden(name: &'static str) -> Pin {
    Pin { name, kind: PinKind::Hidden, ty: Elementary::Lint }
}

/// Whether the input pin rose since the last call, remembered in the pin `last`.
#[inline(always)]
fn rose(pins: &mut Pins<'_>, input: usize, last: usize) -> bool {
    let rose = pins.on(input) && !pins.on(last);
    pins.set(last, i64::from(pins.on(input)));
    rose
}

#[cfg(test)]
mod tests;
