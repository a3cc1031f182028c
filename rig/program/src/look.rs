//! Showing variables: values with the names and forms that they have in the language.

use crate::host::Host;
use crate::library::{TextOut, to_text};
use crate::machine::Machine;
use crate::program::Storage;
use crate::shape::{MemoryLayout, ShapeId, count};
use crate::types::Elementary;
use crate::walk::{Spot, indices};
use signal::Value;
use std::fmt;

/// Elements of one array, and variables in all, that are shown.
const ELEMENTS: u32 = 256;
const ALL: usize = 10_000;
/// Types that stand inside each other, at most.
const DEPTH: u32 = 200;

/// A variable as it is shown.
#[derive(Clone, Debug, PartialEq)]
pub enum ShownVariable {
    /// One value: as plans know it, and its type.
    Value(Value, Elementary),
    /// A value of an enumeration: its name, where it has one, and its number.
    Named(Option<String>, Value),
    /// A text; what is no character is shown as U+FFFD.
    Text(String),
    /// An address: a pointer, a reference, an interface; 0 leads nowhere.
    Address(u32),
    /// Elements in order, each with its indices as in `[1,2]`, and how many are left out.
    Array(Vec<(String, ShownVariable)>, usize),
    /// Members in order by their names.
    Members(Vec<(String, ShownVariable)>),
}

impl Machine {
    /// The variable at a path, whatever its type. The host has the located ones.
    pub fn show(&self, path: &str, host: &mut dyn Host) -> Option<ShownVariable> {
        let spot = Spot::find(self.program(), path)?;
        Viewer { machine: self, host, left: ALL }.view(spot.shape, spot.address, spot.bit, 0)
    }
}

struct Viewer<'a> {
    machine: &'a Machine,
    host: &'a mut dyn Host,
    left: usize,
}

impl Viewer<'_> {
    fn view(&mut self, id: ShapeId, address: u32, bit: u8, depth: u32) -> Option<ShownVariable> {
        let program = self.machine.program();
        self.left = self.left.saturating_sub(1);
        if depth > DEPTH {
            return None;
        }
        Some(match program.shape(id)? {
            MemoryLayout::Elementary(ty) | MemoryLayout::Subrange { base: ty, .. } => {
                ShownVariable::Value(ty.value(self.cell(address, bit, *ty)?), *ty)
            }
            MemoryLayout::Enumeration { base, values, .. } => {
                let cell = self.cell(address, bit, *base)?;
                let name = values.iter().find(|(_, value)| *value == cell);
                ShownVariable::Named(name.map(|(name, _)| name.clone()), base.value(cell))
            }
            MemoryLayout::Text { wide, length } => ShownVariable::Text(self.text(address, *wide, *length)?),
            MemoryLayout::Address => ShownVariable::Address(self.cell(address, 0, Elementary::Dword)? as u32),
            MemoryLayout::Array { dimensions, of, stride } => {
                let mut elements = Vec::new();
                let all = count(dimensions);
                for nth in 0..all.min(ELEMENTS) {
                    if self.left == 0 {
                        break;
                    }
                    let at = address.checked_add(nth.checked_mul(*stride)?)?;
                    elements.push((indices(dimensions, nth), self.view(*of, at, 0, depth + 1)?));
                }
                let more = all as usize - elements.len();
                ShownVariable::Array(elements, more)
            }
            MemoryLayout::Members { members, .. } => {
                let mut list = Vec::new();
                for member in members {
                    if self.left == 0 {
                        break;
                    }
                    let at = address.checked_add(member.offset)?;
                    list.push((member.name.clone(), self.view(member.shape, at, 0, depth + 1)?));
                }
                ShownVariable::Members(list)
            }
        })
    }

    fn cell(&mut self, address: u32, bit: u8, ty: Elementary) -> Option<i64> {
        let program = self.machine.program();
        let spot = Spot { path: String::new(), address, bit, shape: ShapeId(0), file: 0 };
        match spot.storage(ty)? {
            Storage::Located(at) => {
                at.check(&program.limits).ok()?;
                Some(ty.wrap(self.host.load(at) as i64))
            }
            Storage::Cell(_) => {
                let stored = self.machine.memory().get(address as usize..)?.get(..ty.bytes())?;
                Some(ty.wrap(stored.iter().rev().fold(0, |n, byte| n << 8 | i64::from(*byte))))
            }
        }
    }

    fn text(&mut self, address: u32, wide: bool, length: u32) -> Option<String> {
        let ty = if wide { Elementary::Wchar } else { Elementary::Char };
        let mut units = Vec::new();
        for nth in 0..length {
            match self.cell(address.checked_add(nth * ty.bytes() as u32)?, 0, ty)? {
                0 => break,
                unit => units.push(unit as u16),
            }
        }
        // A STRING holds characters of Latin-1, which are the first of Unicode.
        Some(String::from_utf16_lossy(&units))
    }
}

/// A value in the form that the language gives it.
fn plain(value: Value, ty: Elementary) -> String {
    let mut bytes = [0; 256];
    let mut out = TextOut { wide: false, bytes: &mut bytes, length: 0 };
    let Some(cell) = ty.cell(value) else { return String::from("?") };
    to_text(ty, cell, &mut out);
    let length = out.length;
    let text = bytes.get(..length).unwrap_or_default();
    text.iter().map(|byte| char::from(*byte)).collect()
}

impl fmt::Display for ShownVariable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ShownVariable::Value(value, ty) if ty.is_char() => {
                let unit = value.as_int().and_then(|unit| char::from_u32(u32::try_from(unit).ok()?));
                write!(f, "'{}'", unit.unwrap_or(char::REPLACEMENT_CHARACTER))
            }
            // Bit strings as traces write them.
            ShownVariable::Value(value @ Value::Word(_), ty) if ty.is_bit_string() => write!(f, "{value}"),
            ShownVariable::Value(value, ty) => f.write_str(&plain(*value, *ty)),
            ShownVariable::Named(Some(name), _) => f.write_str(name),
            ShownVariable::Named(None, value) => write!(f, "{}", value.as_int().unwrap_or(0)),
            ShownVariable::Text(text) => {
                f.write_str("'")?;
                for c in text.chars() {
                    match c {
                        '$' | '\'' => write!(f, "${c}")?,
                        '\n' => f.write_str("$N")?,
                        '\r' => f.write_str("$R")?,
                        '\t' => f.write_str("$T")?,
                        c if u32::from(c) < 32 => write!(f, "${:02X}", u32::from(c))?,
                        c => write!(f, "{c}")?,
                    }
                }
                f.write_str("'")
            }
            ShownVariable::Address(0) => f.write_str("NULL"),
            ShownVariable::Address(at) => write!(f, "16#{at:08X}"),
            ShownVariable::Array(elements, more) => {
                f.write_str("[")?;
                for (nth, (_, element)) in elements.iter().enumerate() {
                    let comma = if nth > 0 { ", " } else { "" };
                    write!(f, "{comma}{element}")?;
                }
                if *more > 0 {
                    write!(f, ", and {more} more")?;
                }
                f.write_str("]")
            }
            ShownVariable::Members(members) => {
                f.write_str("(")?;
                for (nth, (name, member)) in members.iter().enumerate() {
                    let comma = if nth > 0 { ", " } else { "" };
                    write!(f, "{comma}{name} := {member}")?;
                }
                f.write_str(")")
            }
        }
    }
}
