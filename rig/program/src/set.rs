//! Setting variables from text, in the forms that the language gives values.

use crate::host::Host;
use crate::library::days_of;
use crate::machine::Machine;
use crate::program::Storage;
use crate::shape::MemoryLayout;
use crate::types::Elementary::{self, *};
use crate::walk::Spot;
use std::fmt;

/// Why a variable cannot be set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SetError {
    /// There is no variable with this path.
    NoSuchVariable,
    /// It has no value of its own: a structure, an array, a block, an address; or it is an input's place that does
    /// not exist.
    NotSettable,
    /// The text is no value of its type, which is written as in this example.
    Form(&'static str),
    /// The value is outside the limits of the type or subrange.
    Range {
        /// Least value.
        low: i128,
        /// Greatest value.
        high: i128,
    },
    /// The type, REAL or LREAL, holds 0 and numbers of normal magnitude only (controller:DT-01).
    Magnitude(Elementary),
    /// The enumeration has no such name.
    NoSuchName,
    /// The text has more characters than this.
    TooLong(u32),
    /// A STRING cannot hold a character of the text.
    Character,
}

impl fmt::Display for SetError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SetError::NoSuchVariable => f.write_str("there is no such variable"),
            SetError::NotSettable => {
                f.write_str("only single values can be set: name a member or an element")
            }
            SetError::Form(example) => write!(f, "the value is written as in {example}"),
            SetError::Range { low, high } => write!(f, "the value must be from {low} to {high}"),
            SetError::Magnitude(ty) => {
                let (least, most) = ty.magnitudes();
                write!(f, "{} takes 0 and magnitudes from {least} to {most}", ty.name())
            }
            SetError::NoSuchName => f.write_str("the enumeration has no such name"),
            SetError::TooLong(most) => write!(f, "the text may have {most} characters"),
            SetError::Character => f.write_str("a STRING holds characters up to U+00FF"),
        }
    }
}

impl std::error::Error for SetError {}

impl Machine {
    /// Sets the variable at a path to what `text` says: `12`, `16#FF`, `-1.5`, `TRUE`, `T#1h5m`, `D#2024-02-29`,
    /// `'text'` (the quotes may be left out), a name of an enumeration. The host has the located ones.
    ///
    /// # Errors
    /// [`SetError`], and nothing has changed.
    pub fn set(&mut self, path: &str, text: &str, host: &mut dyn Host) -> Result<(), SetError> {
        let program = std::sync::Arc::clone(self.program());
        let spot = Spot::find(&program, path).ok_or(SetError::NoSuchVariable)?;
        let shape = program.shape(spot.shape).ok_or(SetError::NoSuchVariable)?;
        let text = text.trim();
        if let MemoryLayout::Text { wide, length } = shape {
            let bytes = characters(text, *wide, *length)?;
            let unit = if *wide { Wchar } else { Char };
            return bytes.chunks(unit.bytes()).zip(0..).try_for_each(|(bytes, nth)| {
                let at = Spot { address: spot.address + nth * unit.bytes() as u32, ..spot.clone() };
                self.place(&at, unit, bytes, host)
            });
        }
        let ty = shape.elementary().ok_or(SetError::NotSettable)?;
        let cell = match shape {
            MemoryLayout::Enumeration { base, values, .. } => named(text, *base, values)?,
            MemoryLayout::Subrange { base, low, high } => {
                let cell = scalar(text, *base)?;
                if cell < *low || cell > *high {
                    return Err(SetError::Range { low: i128::from(*low), high: i128::from(*high) });
                }
                cell
            }
            _ => scalar(text, ty)?,
        };
        self.place(&spot, ty, cell.to_le_bytes().get(..ty.bytes()).unwrap_or_default(), host)
    }

    /// Stores a value where it belongs.
    fn place(
        &mut self,
        at: &Spot,
        ty: Elementary,
        bytes: &[u8],
        host: &mut dyn Host,
    ) -> Result<(), SetError> {
        match at.storage(ty).ok_or(SetError::NotSettable)? {
            Storage::Cell(variable) => {
                self.set_variable(variable.address(), bytes).then_some(()).ok_or(SetError::NotSettable)
            }
            Storage::Located(address) => {
                address.check(&self.program().limits).map_err(|_| SetError::NotSettable)?;
                host.store(address, bytes.iter().rev().fold(0, |n, byte| n << 8 | u64::from(*byte)), 0, 0);
                Ok(())
            }
        }
    }
}

/// The cell of a name of an enumeration, or of a number that it has.
fn named(text: &str, base: Elementary, values: &[(String, i64)]) -> Result<i64, SetError> {
    let name = text.rsplit(['#', '.']).next().unwrap_or(text);
    if let Some((_, value)) = values.iter().find(|(known, _)| known.eq_ignore_ascii_case(name)) {
        return Ok(*value);
    }
    let number = scalar(text, base).map_err(|_| SetError::NoSuchName)?;
    values.iter().any(|(_, value)| *value == number).then_some(number).ok_or(SetError::NoSuchName)
}

/// The cell of a value of an elementary type.
fn scalar(text: &str, ty: Elementary) -> Result<i64, SetError> {
    let key = text.to_ascii_uppercase();
    let (prefix, body) = key.split_once('#').map_or(("", key.as_str()), |(prefix, body)| (prefix, body));
    // What stands before # may be the type; else it is the base of a number.
    let body = if names(ty).contains(&prefix) { body } else { key.as_str() };
    match ty {
        Bool => match body {
            "TRUE" | "1" => Ok(1),
            "FALSE" | "0" => Ok(0),
            _ => Err(SetError::Form("TRUE")),
        },
        Real | Lreal => real(body, ty),
        Char | Wchar => {
            let bytes = characters(text, ty == Wchar, 1)?;
            Ok(bytes.iter().take(ty.bytes()).rev().fold(0, |n, byte| n << 8 | i64::from(*byte)))
        }
        Time | Ltime => ranged(duration(body).ok_or(SetError::Form("T#1m30s"))?, ty),
        Date | Ldate => ranged(date(body).ok_or(SetError::Form("D#2024-02-29"))?, ty),
        Tod | Ltod => ranged(clock(body).ok_or(SetError::Form("TOD#12:30:00"))?, ty),
        Dt | Ldt => {
            let form = SetError::Form("DT#2024-02-29-12:30:00");
            let (day, time) = body.rsplit_once('-').ok_or(form)?;
            ranged(date(day).zip(clock(time)).map(|(day, time)| day + time).ok_or(form)?, ty)
        }
        _ => whole(body, ty),
    }
}

/// What may stand before # for a type.
fn names(ty: Elementary) -> &'static [&'static str] {
    match ty {
        Time => &["T", "TIME"],
        Ltime => &["LT", "LTIME"],
        Date => &["D", "DATE"],
        Ldate => &["LD", "LDATE"],
        Tod => &["TOD", "TIME_OF_DAY"],
        Ltod => &["LTOD", "LTIME_OF_DAY"],
        Dt => &["DT", "DATE_AND_TIME"],
        Ldt => &["LDT", "LDATE_AND_TIME"],
        Bool => &["BOOL"],
        Sint => &["SINT"],
        Usint => &["USINT"],
        Int => &["INT"],
        Uint => &["UINT"],
        Dint => &["DINT"],
        Udint => &["UDINT"],
        Lint => &["LINT"],
        Ulint => &["ULINT"],
        Byte => &["BYTE"],
        Word => &["WORD"],
        Dword => &["DWORD"],
        Lword => &["LWORD"],
        Real => &["REAL"],
        Lreal => &["LREAL"],
        Char | Wchar => &[],
    }
}

/// Digits with underscores between them.
fn digits(text: &str, base: u32) -> Option<i128> {
    let plain: String = text.chars().filter(|c| *c != '_').collect();
    let all = plain.chars().all(|c| c.is_digit(base));
    (all && !text.starts_with('_')).then(|| i128::from_str_radix(&plain, base).ok()).flatten()
}

fn whole(body: &str, ty: Elementary) -> Result<i64, SetError> {
    let (negative, rest) = body.strip_prefix('-').map_or((false, body), |rest| (true, rest));
    let rest = if negative { rest } else { rest.strip_prefix('+').unwrap_or(rest) };
    let number = match rest.split_once('#') {
        Some(("2", rest)) => digits(rest, 2),
        Some(("8", rest)) => digits(rest, 8),
        Some(("16", rest)) => digits(rest, 16),
        Some(_) => None,
        None => digits(rest, 10),
    };
    let number = number.ok_or(SetError::Form(if ty.is_bit_string() { "16#FF" } else { "12" }))?;
    let number = if negative { -number } else { number };
    let (low, high) = ty.range();
    if number < low || number > high {
        return Err(SetError::Range { low, high });
    }
    Ok(ty.wrap(number as i64))
}

fn real(body: &str, ty: Elementary) -> Result<i64, SetError> {
    let form = SetError::Form("1.5");
    let plain: String = body.chars().filter(|c| *c != '_').collect();
    if !plain.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c)) {
        return Err(form);
    }
    let (Ok(double), Ok(single)) = (plain.parse::<f64>(), plain.parse::<f32>()) else { return Err(form) };
    let (normal, cell) = match ty {
        Real => (single.is_normal(), i64::from(single.to_bits())),
        _ => (double.is_normal(), double.to_bits() as i64),
    };
    if normal || double == 0.0 { Ok(cell) } else { Err(SetError::Magnitude(ty)) }
}

/// Nanoseconds as a cell of a type of times or dates: what its unit does not hold is cut off.
fn ranged(nanos: i128, ty: Elementary) -> Result<i64, SetError> {
    let unit = match ty {
        Time | Tod => 1_000_000,
        Date | Dt => 1_000_000_000,
        _ => 1,
    };
    let (low, high) = ty.range();
    let number = nanos.div_euclid(unit);
    if number < low || number > high {
        return Err(SetError::Range { low, high });
    }
    Ok(ty.wrap(number as i64))
}

/// A number with decimals in units of `unit` nanoseconds, whole nanoseconds.
fn decimal(text: &str, unit: i128) -> Option<i128> {
    let (whole, part) = text.split_once('.').unwrap_or((text, ""));
    let mut nanos = digits(whole, 10).filter(|_| !whole.is_empty())?.checked_mul(unit)?;
    let mut scale = unit;
    for digit in part.chars().filter(|c| *c != '_') {
        scale /= 10;
        nanos = nanos.checked_add(i128::from(digit.to_digit(10)?).checked_mul(scale)?)?;
    }
    Some(nanos)
}

/// `1D2H3M4S5MS6US7NS`, any of them.
fn duration(body: &str) -> Option<i128> {
    const UNITS: [(&str, i128); 7] = [
        ("MS", 1_000_000),
        ("US", 1_000),
        ("NS", 1),
        ("D", 86_400_000_000_000),
        ("H", 3_600_000_000_000),
        ("M", 60_000_000_000),
        ("S", 1_000_000_000),
    ];
    let (mut rest, mut nanos) = (body, 0i128);
    while !rest.is_empty() {
        let end = rest.find(|c: char| c.is_ascii_alphabetic())?;
        let (number, after) = rest.split_at(end);
        let (name, unit) = UNITS.iter().find(|(name, _)| after.starts_with(name))?;
        nanos = nanos.checked_add(decimal(number, *unit)?)?;
        rest = after.strip_prefix(name)?.trim_start_matches('_');
    }
    (!body.is_empty()).then_some(nanos)
}

/// Nanoseconds from 1970-01-01 to `year-month-day`.
fn date(body: &str) -> Option<i128> {
    let mut parts = body.split('-').map(|part| digits(part, 10).and_then(|n| i64::try_from(n).ok()));
    let (year, month, day) = (parts.next()??, parts.next()??, parts.next()??);
    let days = days_of(year, month, day).filter(|_| parts.next().is_none())?;
    Some(i128::from(days) * 86_400_000_000_000)
}

/// Nanoseconds since midnight of `hour:minute:second`, whose seconds may have decimals.
fn clock(body: &str) -> Option<i128> {
    let mut parts = body.split(':');
    let (hour, minute) = (digits(parts.next()?, 10)?, digits(parts.next()?, 10)?);
    let second = decimal(parts.next().unwrap_or("0"), 1_000_000_000)?;
    let fits = hour < 24 && minute < 60 && second < 60_000_000_000 && parts.next().is_none();
    fits.then_some((hour * 60 + minute) * 60_000_000_000 + second)
}

/// The stored form of a text with its closing 0; quotes and $ as in the language.
fn characters(text: &str, wide: bool, most: u32) -> Result<Vec<u8>, SetError> {
    let quote = if wide { '"' } else { '\'' };
    let quoted = text.strip_prefix(quote).and_then(|text| text.strip_suffix(quote));
    let plain = match quoted {
        Some(text) => unescaped(text, wide)?,
        None => text.to_owned(),
    };
    let mut bytes = Vec::new();
    for unit in plain.encode_utf16() {
        if wide {
            bytes.extend(unit.to_le_bytes());
        } else {
            bytes.push(u8::try_from(unit).map_err(|_| SetError::Character)?);
        }
    }
    let unit = 1 + usize::from(wide);
    if bytes.len() / unit > most as usize {
        return Err(SetError::TooLong(most));
    }
    bytes.extend(std::iter::repeat_n(0, unit));
    Ok(bytes)
}

/// `$N` and the like replaced.
fn unescaped(text: &str, wide: bool) -> Result<String, SetError> {
    let form = SetError::Form("'one$Ntwo'");
    let (mut plain, mut rest) = (String::new(), text.chars());
    while let Some(c) = rest.next() {
        if c != '$' {
            plain.push(c);
            continue;
        }
        let kind = rest.next().ok_or(form)?;
        plain.push(match kind.to_ascii_uppercase() {
            'N' | 'L' => '\n',
            'P' => '\x0C',
            'R' => '\r',
            'T' => '\t',
            '$' | '\'' | '"' => kind,
            _ => {
                let mut code = String::from(kind);
                code.extend(rest.by_ref().take(if wide { 3 } else { 1 }));
                let number = u32::from_str_radix(&code, 16).map_err(|_| form)?;
                char::from_u32(number).ok_or(form)?
            }
        });
    }
    Ok(plain)
}
