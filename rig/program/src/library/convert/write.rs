//! Values as texts, in the forms of the language's literals.

use super::real;
use crate::library::TextOut;
use crate::library::calendar::{DAY, date_of};
use crate::types::Elementary::{self, *};
use std::fmt::{Debug, Result, UpperExp, Write};

/// Writes a value:
/// - BOOL as TRUE or FALSE, whole numbers and bit strings in decimal;
/// - REAL and LREAL with the fewest digits that read back as the same number, at least one of them after the point;
///   below 1E-4, and from 1E8 (REAL) or 1E15 (LREAL) on, as in 1.5E20 and 1E-7; `#NaN`, `#Inf`, `-#Inf`;
/// - TIME and LTIME as T#1d2h3m4s5ms and LTIME#..us..ns without the parts that are 0, T#0ms and LTIME#0ns;
/// - dates as D#2020-01-31, TOD#12:34:56.789, DT#2020-01-31-12:34:56 and LD#, LTOD#, LDT#, a fraction of a second
///   only where it is not 0, with all 3 or 9 digits;
/// - a character as itself, the character 0 as an empty text.
pub(crate) fn to_text(from: Elementary, cell: i64, out: &mut TextOut<'_>) {
    out.clear();
    // Writing into a text never fails: what does not fit is cut off.
    let _ = write(from, from.wrap(cell), out);
}

fn write(from: Elementary, cell: i64, out: &mut TextOut<'_>) -> Result {
    let count = cell as u64;
    match from {
        Bool => out.write_str(if cell != 0 { "TRUE" } else { "FALSE" }),
        Real => write_real(f32::from_bits(cell as u32), real(from, cell), (1e-4_f32.into(), 1e8), out),
        Lreal => write_real(f64::from_bits(count), f64::from_bits(count), (1e-4, 1e15), out),
        Char | Wchar => {
            out.extend((cell != 0).then_some(cell as u16));
            Ok(())
        }
        Time => write_duration("T#", count * 1_000_000, "0ms", out),
        Ltime => write_duration("LTIME#", count, "0ns", out),
        Date => write_date("D#", count * 1_000_000_000, out),
        Ldate => write_date("LD#", count, out),
        Tod => write_clock("TOD#", count * 1_000_000, 3, out),
        Ltod => write_clock("LTOD#", count, 9, out),
        Dt => {
            write_date("DT#", count * 1_000_000_000, out)?;
            write_clock("-", count * 1_000_000_000 % DAY, 9, out)
        }
        Ldt => {
            write_date("LDT#", count, out)?;
            write_clock("-", count % DAY, 9, out)
        }
        Ulint | Lword => write!(out, "{count}"),
        Sint | Usint | Int | Uint | Dint | Udint | Lint | Byte | Word | Dword => write!(out, "{cell}"),
    }
}

/// `number` with its own shortest digits; `size` is the same number for the comparisons. Without an exponent from the
/// first limit on and below the second.
fn write_real(number: impl Debug + UpperExp, size: f64, limits: (f64, f64), out: &mut TextOut<'_>) -> Result {
    let plain = size == 0.0 || (size.abs() >= limits.0 && size.abs() < limits.1);
    if size.is_nan() {
        out.write_str("#NaN")
    } else if size.is_infinite() {
        out.write_str(if size < 0.0 { "-#Inf" } else { "#Inf" })
    } else if plain {
        write!(out, "{number:?}")
    } else {
        write!(out, "{number:E}")
    }
}

fn write_duration(prefix: &str, mut nanos: u64, zero: &str, out: &mut TextOut<'_>) -> Result {
    const PARTS: [(u64, &str); 7] = [
        (DAY, "d"),
        (3_600_000_000_000, "h"),
        (60_000_000_000, "m"),
        (1_000_000_000, "s"),
        (1_000_000, "ms"),
        (1_000, "us"),
        (1, "ns"),
    ];
    out.write_str(prefix)?;
    if nanos == 0 {
        return out.write_str(zero);
    }
    for (size, name) in PARTS {
        if nanos >= size {
            write!(out, "{}{name}", nanos / size)?;
            nanos %= size;
        }
    }
    Ok(())
}

fn write_date(prefix: &str, nanos: u64, out: &mut TextOut<'_>) -> Result {
    let (year, month, day) = date_of(nanos / DAY);
    write!(out, "{prefix}{year:04}-{month:02}-{day:02}")
}

/// The fraction has `digits` digits: 3 or 9.
fn write_clock(prefix: &str, nanos: u64, digits: usize, out: &mut TextOut<'_>) -> Result {
    let seconds = nanos / 1_000_000_000;
    let (hours, minutes) = (seconds / 3600, seconds / 60 % 60);
    write!(out, "{prefix}{hours:02}:{minutes:02}:{:02}", seconds % 60)?;
    let fraction = nanos % 1_000_000_000;
    match (fraction, digits) {
        (0, _) => Ok(()),
        (_, 3) => write!(out, ".{:03}", fraction / 1_000_000),
        _ => write!(out, ".{fraction:09}"),
    }
}
