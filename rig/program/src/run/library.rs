//! Calls of the library and of native blocks.

use super::text::TextSpan;
use super::world::{By, ProgramMemory, Stored};
use crate::code::{LibraryArgument, LibraryCall, LibraryCode, Operand, TextAt};
use crate::host::ProgramFaultKind;
use crate::library::{Body, Service, Text, TextCall, TextOut, from_text, to_text};
use crate::native::{BlockBody, Native, Pins};
use crate::state::{PinOffsets, READ_ONLY, Scratch, WATCHED};
use crate::types::Elementary;
use signal::Time;

/// What a call of the library came to.
pub(super) enum CallResult {
    /// The result is stored.
    Done(Stored),
    /// The caller of the machine has to answer.
    Asks(Service, i64),
}

/// Text arguments that a call can have.
const TEXTS: usize = 32;

/// The cell in stored bytes.
#[inline]
fn cell(ty: Elementary, raw: u64) -> i64 {
    ty.wrap(raw as i64)
}

impl ProgramMemory<'_> {
    /// A scalar as its cell.
    pub fn cell(&mut self, memory: &[u8], at: u32, ty: Elementary) -> Option<i64> {
        self.load(memory, at, ty.bytes() as u32).map(|raw| cell(ty, raw))
    }

    /// Runs a function of the library. `place` resolves operands.
    #[inline(never)]
    pub fn call_library(
        &mut self,
        memory: &mut [u8],
        scratch: &mut Scratch,
        call: &LibraryCall,
        place: impl Fn(&[u8], Operand) -> Option<u32>,
        now: Time,
        by: By,
    ) -> Result<CallResult, ProgramFaultKind> {
        let Scratch { bytes, cells } = scratch;
        let place = |memory: &[u8], operand| place(memory, operand).ok_or(ProgramFaultKind::BadReference);
        let (out, mut rest) = match &call.result {
            LibraryArgument::Text(text) => {
                bytes.split_at_mut_checked(text.bytes as usize).ok_or(ProgramFaultKind::Internal)?
            }
            LibraryArgument::Cell(..) => (&mut [][..], bytes.as_mut_slice()),
        };
        let mut texts = [Text { wide: false, bytes: &[] }; TEXTS];
        let (mut text_count, mut cell_count) = (0, 0);
        for argument in &call.arguments {
            match argument {
                LibraryArgument::Cell(operand, ty) => {
                    let at = place(memory, *operand)?;
                    let value = self.cell(memory, at, *ty).ok_or(ProgramFaultKind::BadReference)?;
                    *cells.get_mut(cell_count).ok_or(ProgramFaultKind::Internal)? = value;
                    cell_count += 1;
                }
                LibraryArgument::Text(text) => {
                    let at = place(memory, text.at)?;
                    let entry = texts.get_mut(text_count).ok_or(ProgramFaultKind::Internal)?;
                    *entry = self.text(memory, &mut rest, at, text)?;
                    text_count += 1;
                }
            }
        }
        let texts = texts.get(..text_count).unwrap_or_default();
        let cells = cells.get(..cell_count).unwrap_or_default();
        let first = cells.first().copied().unwrap_or(0);
        let wide = matches!(&call.result, LibraryArgument::Text(text) if text.wide);
        let mut of = TextCall { texts, cells, out: TextOut { wide, bytes: out, length: 0 }, result: 0 };
        match call.code {
            LibraryCode::Function(function) => match function.body {
                Body::Scalar(run) => of.result = run(call.generic, cells),
                Body::Quotient(run) => {
                    let zero = if call.generic.is_real() {
                        ProgramFaultKind::RealDivisionByZero
                    } else {
                        ProgramFaultKind::DivisionByZero
                    };
                    of.result = run(call.generic, cells).ok_or(zero)?;
                }
                Body::Text(run) => run(&mut of),
                Body::Clock(run) => of.result = run(now),
                Body::Service(service) => return Ok(CallResult::Asks(service, first)),
            },
            LibraryCode::ToText(ty) => to_text(ty, first, &mut of.out),
            LibraryCode::FromText(ty) => {
                of.result = texts.first().map_or(0, |text| from_text(*text, ty));
            }
        }
        let (result, length) = (of.result, of.out.length);
        let target =
            |memory: &[u8], operand| place(memory, operand).map_err(|_| ProgramFaultKind::ReservedWrite);
        match &call.result {
            LibraryArgument::Cell(operand, ty) => {
                let at = target(memory, *operand)?;
                Ok(CallResult::Done(self.store(memory, at, ty.bytes() as u32, result as u64, by)))
            }
            LibraryArgument::Text(text) => {
                let at = TextSpan::new(target(memory, text.at)?, text);
                let length = length.saturating_mul(at.unit() as usize).min(text.bytes as usize);
                let units = bytes.get(..length).unwrap_or_default();
                Ok(CallResult::Done(self.store_text(memory, at, units, by)))
            }
        }
    }

    /// The storage of a text argument: as it lies in memory, or copied from the host's areas.
    fn text<'m>(
        &mut self,
        memory: &'m [u8],
        room: &mut &'m mut [u8],
        at: u32,
        text: &TextAt,
    ) -> Result<Text<'m>, ProgramFaultKind> {
        let length = text.bytes as usize;
        let own = memory.get(at as usize..).and_then(|rest| rest.get(..length));
        let bytes = match own {
            Some(bytes) => bytes,
            None => {
                let all = std::mem::take(room);
                let (copy, rest) = all.split_at_mut_checked(length).ok_or(ProgramFaultKind::Internal)?;
                *room = rest;
                self.read(memory, at, copy).ok_or(ProgramFaultKind::BadReference)?;
                copy
            }
        };
        Ok(Text { wide: text.wide, bytes })
    }

    /// Runs a native block on the instance at `at`.
    #[inline(never)]
    pub fn call_native(
        &mut self,
        memory: &mut [u8],
        native: &Native,
        pins: &PinOffsets,
        at: u32,
        now: Time,
    ) -> Stored {
        let range = at as usize..at as usize + pins.bytes as usize;
        let (Some(bytes), Some(flags)) = (memory.get_mut(range.clone()), self.flags.get(range)) else {
            return Stored::Bad;
        };
        if flags.iter().any(|flag| flag & READ_ONLY != 0) {
            return Stored::Bad;
        }
        let mut pins = Pins::new(bytes, native.pins, &pins.offsets, flags, now);
        let touched = match native.body {
            BlockBody::Own(run) => {
                run(&mut pins);
                false
            }
            BlockBody::Host(block) => self.host.block(block, &mut pins),
        };
        let changed = pins.changed;
        self.changed |= changed;
        if touched || changed & WATCHED != 0 { Stored::Touched } else { Stored::Fine }
    }
}
