//! Texts as values: what can be read is taken, from the left as far as it goes.

use super::real_cell;
use crate::library::Text;
use crate::library::calendar::{DAY, days_of};
use crate::types::Elementary::{self, *};

/// Reads a value; 0 where nothing can be read. Spaces in front are skipped, prefixes such as `T#` may be missing, and
/// what follows the value is not looked at:
/// - BOOL: TRUE for `TRUE`, in any case, and for numbers that are not 0;
/// - whole numbers: sign, digits, `_` between them, and 2#, 8# and 16#; the high bits are cut off;
/// - REAL and LREAL: as in -1.5E3, and `#NaN`, `#Inf`; the nearest number; not more than 1000 digits are read;
/// - times: parts such as 1d2h3m4s5ms6us7ns, each with decimals; a number without a unit counts the unit of the type;
/// - dates: 2020-01-31, times of day: 12:34 and 12:34:56.789, both: 2020-01-31-12:34:56, with `-`, a space, `_` or `T`
///   between; 0 for a date that there is not;
/// - a character: the first one.
pub(crate) fn from_text(text: Text<'_>, to: Elementary) -> i64 {
    let mut reader = LiteralReader { text, at: 0 };
    match to {
        // Even a space is a character.
        Char | Wchar => {
            let first = text.units().next().unwrap_or(0);
            return if to == Char && first > 0xFF { i64::from(b'?') } else { i64::from(first) };
        }
        _ => reader.skip_spaces(),
    }
    let nanos = match to {
        Bool => return i64::from(reader.word("TRUE") || reader.integer() != 0),
        Real | Lreal => return reader.real(to),
        Time => reader.duration(1_000_000),
        Ltime => reader.duration(1),
        Date | Ldate => reader.date(),
        Tod | Ltod => reader.clock(),
        Dt | Ldt => reader.date_and_clock(),
        _ => return to.wrap(reader.integer()),
    };
    let count = nanos.unwrap_or(0) / u128::from(to.nanos().unwrap_or(1));
    to.wrap(count as i64)
}

/// A place in a text.
#[derive(Clone, Copy)]
struct LiteralReader<'a> {
    text: Text<'a>,
    at: usize,
}

impl LiteralReader<'_> {
    /// The next unit; 0 at the end and for what is not ASCII, neither of which any value goes on with.
    fn peek(&self) -> u8 {
        u8::try_from(self.text.unit(self.at)).unwrap_or(0)
    }

    fn eat(&mut self, byte: u8) -> bool {
        let found = byte != 0 && self.peek().eq_ignore_ascii_case(&byte);
        self.at += usize::from(found);
        found
    }

    fn skip_spaces(&mut self) {
        while matches!(self.peek(), b' ' | b'\t' | b'\r' | b'\n') {
            self.at += 1;
        }
    }

    /// Takes a word, in any case.
    fn word(&mut self, word: &str) -> bool {
        let start = self.at;
        let found = word.bytes().all(|byte| self.eat(byte));
        if !found {
            self.at = start;
        }
        found
    }

    /// Takes a prefix such as `T#`.
    fn skip_prefix(&mut self) {
        let start = self.at;
        while self.peek().is_ascii_alphabetic() || self.peek() == b'_' {
            self.at += 1;
        }
        if self.at == start || !self.eat(b'#') {
            self.at = start;
        }
    }

    /// The next digit, past one `_`.
    fn digit(&mut self, base: u32) -> Option<u32> {
        let mut ahead = *self;
        ahead.eat(b'_');
        let digit = char::from(ahead.peek()).to_digit(base)?;
        ahead.at += 1;
        *self = ahead;
        Some(digit)
    }

    /// Digits as a number of 64 bits, whose high bits are cut off. `None` where there is no digit.
    fn digits(&mut self, base: u32) -> Option<u64> {
        if self.peek() == b'_' {
            return None;
        }
        let mut number = u64::from(self.digit(base)?);
        while let Some(digit) = self.digit(base) {
            number = number.wrapping_mul(u64::from(base)).wrapping_add(u64::from(digit));
        }
        Some(number)
    }

    fn sign(&mut self) -> bool {
        let negative = self.eat(b'-');
        if !negative {
            self.eat(b'+');
        }
        negative
    }

    fn integer(&mut self) -> i64 {
        let negative = self.sign();
        let mut number = self.digits(10).unwrap_or(0);
        if matches!(number, 2 | 8 | 16) && self.eat(b'#') {
            number = self.digits(number as u32).unwrap_or(0);
        }
        if negative { (number as i64).wrapping_neg() } else { number as i64 }
    }

    fn real(&mut self, to: Elementary) -> i64 {
        let negative = self.sign();
        if self.eat(b'#') {
            let special = match (self.word("NAN"), self.word("INF")) {
                (true, _) => f64::NAN,
                (_, true) => f64::INFINITY,
                _ => 0.0,
            };
            return real_cell(to, if negative { -special } else { special });
        }
        let mut spelling = Spelling { bytes: [0; 1024], length: 0 };
        if negative {
            spelling.push(b'-');
        }
        while let Some(digit) = self.digit(10) {
            spelling.push_digit(digit);
        }
        if self.peek() == b'.' {
            self.at += 1;
            spelling.push(b'.');
            while let Some(digit) = self.digit(10) {
                spelling.push_digit(digit);
            }
        }
        if self.eat(b'E') {
            let negative = self.sign();
            if let Some(exponent) = self.digits(10) {
                spelling.push_exponent(negative, exponent);
            }
        }
        // Each type from the digits: by way of LREAL a REAL would be rounded twice.
        if to == Real {
            real_cell(to, spelling.text().parse::<f32>().map_or(0.0, f64::from))
        } else {
            real_cell(to, spelling.text().parse::<f64>().unwrap_or(0.0))
        }
    }

    /// Nanoseconds of a fraction of `unit`, after its point.
    fn fraction(&mut self, unit: u64) -> u128 {
        let (mut number, mut scale) = (0u128, 1u128);
        while let Some(digit) = self.digit(10) {
            // Digits after the 18th are below a nanosecond of any unit.
            if scale < 1_000_000_000_000_000_000 {
                number = number * 10 + u128::from(digit);
                scale *= 10;
            }
        }
        number * u128::from(unit) / scale
    }

    fn duration(&mut self, base: u64) -> Option<u128> {
        self.skip_prefix();
        let mut total: Option<u128> = None;
        while let Some(number) = self.digits(10) {
            let fraction = if self.eat(b'.') { Some(*self) } else { None };
            while fraction.is_some() && self.digit(10).is_some() {}
            let unit = match self.unit() {
                Some(unit) => unit,
                None if total.is_none() => base,
                None => break,
            };
            let part = u128::from(number) * u128::from(unit) + fraction.map_or(0, |mut at| at.fraction(unit));
            total = Some(total.unwrap_or(0).wrapping_add(part));
            self.eat(b'_');
        }
        total
    }

    /// Nanoseconds of a unit of time.
    fn unit(&mut self) -> Option<u64> {
        // Longer words first.
        const UNITS: [(&str, u64); 7] = [
            ("ms", 1_000_000),
            ("us", 1_000),
            ("ns", 1),
            ("d", DAY),
            ("h", 3_600_000_000_000),
            ("m", 60_000_000_000),
            ("s", 1_000_000_000),
        ];
        UNITS.iter().find(|(word, _)| self.word(word)).map(|(_, nanos)| *nanos)
    }

    /// A number of a date or of a time of day.
    fn part(&mut self) -> Option<i64> {
        i64::try_from(self.digits(10)?).ok()
    }

    fn date(&mut self) -> Option<u128> {
        self.skip_prefix();
        let year = self.part()?;
        let month = self.eat(b'-').then(|| self.part())??;
        let day = self.eat(b'-').then(|| self.part())??;
        let days = u64::try_from(days_of(year, month, day)?).ok()?;
        Some(u128::from(days) * u128::from(DAY))
    }

    fn clock(&mut self) -> Option<u128> {
        self.skip_prefix();
        let hours = self.part().filter(|hours| *hours <= 0xFFFF_FFFF)?;
        let minutes = self.eat(b':').then(|| self.part())?.filter(|minutes| *minutes < 60)?;
        let mut nanos = 0;
        let mut seconds = 0;
        if self.eat(b':') {
            seconds = self.part().filter(|seconds| *seconds < 60)?;
            if self.eat(b'.') {
                nanos = self.fraction(1_000_000_000);
            }
        }
        let seconds = u128::try_from((hours * 60 + minutes) * 60 + seconds).ok()?;
        Some(seconds * 1_000_000_000 + nanos)
    }

    fn date_and_clock(&mut self) -> Option<u128> {
        let date = self.date()?;
        let more = [b'-', b' ', b'_', b'T'].into_iter().any(|byte| self.eat(byte));
        if more { Some(date + self.clock()?) } else { Some(date) }
    }
}

/// A number as Rust spells it.
struct Spelling {
    bytes: [u8; 1024],
    length: usize,
}

impl Spelling {
    /// Digits for which there is no room are left out; the rest of the buffer is for the exponent.
    fn push(&mut self, byte: u8) {
        if self.length < 1000 {
            self.put(byte);
        }
    }

    fn push_digit(&mut self, digit: u32) {
        self.push(b'0' + digit as u8);
    }

    fn push_exponent(&mut self, negative: bool, exponent: u64) {
        self.put(b'e');
        if negative {
            self.put(b'-');
        }
        // Far beyond any number of LREAL.
        let exponent = exponent.min(99_999);
        for place in [10_000, 1_000, 100, 10, 1] {
            self.put(b'0' + (exponent / place % 10) as u8);
        }
    }

    fn put(&mut self, byte: u8) {
        if let Some(place) = self.bytes.get_mut(self.length) {
            *place = byte;
            self.length += 1;
        }
    }

    fn text(&self) -> &str {
        self.bytes.get(..self.length).and_then(|bytes| std::str::from_utf8(bytes).ok()).unwrap_or("")
    }
}
