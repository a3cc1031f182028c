//! The units that quantities are written in: one table.

use std::fmt;

/// A unit in its one spelling: `µV` and `uV`, `°C` and `degC`, `kΩ` and `kOhm` are one.
///
/// Any word is a unit. One that the table does not know, such as `l/min`, compares with itself alone.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Unit(String);

/// What a unit of the table is in its base unit: `factor` times ten to the power of `power`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Scale {
    pub(super) base: &'static str,
    pub(super) factor: u32,
    pub(super) power: i32,
}

/// Most characters of a unit in its one spelling.
const MAX_LENGTH: usize = 16;

/// The base unit of time.
pub(super) const SECOND: &str = "s";
/// The base unit of parts.
pub(super) const PERCENT: &str = "%";

/// Base units, and the units that are a power of ten of them.
const UNITS: &[(&str, &[(&str, i32)])] = &[
    (SECOND, &[("ns", -9), ("us", -6), ("ms", -3), ("s", 0)]),
    ("Hz", &[("uHz", -6), ("mHz", -3), ("Hz", 0), ("kHz", 3), ("MHz", 6), ("GHz", 9)]),
    ("V", &[("nV", -9), ("uV", -6), ("mV", -3), ("V", 0), ("kV", 3), ("MV", 6)]),
    ("A", &[("nA", -9), ("uA", -6), ("mA", -3), ("A", 0), ("kA", 3)]),
    ("Ohm", &[("uOhm", -6), ("mOhm", -3), ("Ohm", 0), ("kOhm", 3), ("MOhm", 6), ("GOhm", 9)]),
    ("W", &[("nW", -9), ("uW", -6), ("mW", -3), ("W", 0), ("kW", 3), ("MW", 6), ("GW", 9)]),
    ("Pa", &[("mPa", -3), ("Pa", 0), ("hPa", 2), ("kPa", 3), ("MPa", 6), ("mbar", 2), ("bar", 5)]),
    ("m", &[("nm", -9), ("um", -6), ("mm", -3), ("cm", -2), ("m", 0), ("km", 3)]),
    ("g", &[("ug", -6), ("mg", -3), ("g", 0), ("kg", 3)]),
    ("N", &[("mN", -3), ("N", 0), ("kN", 3), ("MN", 6)]),
    (PERCENT, &[("ppm", -4), ("%", 0)]),
];

/// The units of time that are no power of ten of a second.
const LONG_TIMES: &[(&str, u32)] = &[("min", 60), ("h", 3_600), ("d", 86_400)];

impl Unit {
    /// The unit of a plain number.
    pub const NONE: Unit = Unit(String::new());

    /// The unit that a word names. The empty word is [`Unit::NONE`].
    pub fn new(word: &str) -> Unit {
        let mut symbol = String::with_capacity(word.len());
        for char in word.trim().chars() {
            match char {
                'µ' | 'μ' => symbol.push('u'),
                '°' => symbol.push_str("deg"),
                'Ω' | '\u{2126}' => symbol.push_str("Ohm"),
                '²' => symbol.push('2'),
                '³' => symbol.push('3'),
                other => symbol.push(other),
            }
        }
        Unit(symbol)
    }

    /// Whether it is that of plain numbers.
    pub fn is_none(&self) -> bool {
        self.0.is_empty()
    }

    /// Its row of the table.
    pub(super) fn scale(&self) -> Option<Scale> {
        let long = LONG_TIMES.iter().find(|(symbol, _)| *symbol == self.0);
        if let Some((_, factor)) = long {
            return Some(Scale { base: SECOND, factor: *factor, power: 0 });
        }
        UNITS.iter().find_map(|(base, units)| {
            let (_, power) = units.iter().find(|(symbol, _)| *symbol == self.0)?;
            Some(Scale { base, factor: 1, power: *power })
        })
    }

    /// Whether it is a unit of this base unit.
    pub(super) fn is_of(&self, base: &str) -> bool {
        self.scale().is_some_and(|scale| scale.base == base)
    }
}

/// Length of the unit at the beginning of the text, 0 if there is none: letters, `%`, `°`, `/`, `·`, `^`, and
/// digits from the second character on, at most 16 in the one spelling, so that what is shown reads back.
pub(super) fn unit_length(text: &str) -> usize {
    let part =
        |(at, c): &(usize, char)| c.is_alphabetic() || "%°/·^".contains(*c) || (*at > 0 && c.is_numeric());
    let word = text.char_indices().take_while(part);
    let (mut length, mut count) = (0, 0);
    for (at, char) in word {
        length = at + char.len_utf8();
        count += match char {
            '°' | 'Ω' | '\u{2126}' => 3,
            _ => 1,
        };
    }
    if count > MAX_LENGTH { 0 } else { length }
}

impl fmt::Display for Unit {
    /// The one spelling; empty for plain numbers.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // The powers against the meaning of the prefixes, which the table does not use.
    #[test]
    fn powers_are_those_of_the_prefixes() {
        let prefixes =
            [("n", -9), ("u", -6), ("m", -3), ("c", -2), ("", 0), ("h", 2), ("k", 3), ("M", 6), ("G", 9)];
        let mut seen: Vec<&str> = LONG_TIMES.iter().map(|(symbol, _)| *symbol).collect();
        for (base, units) in UNITS {
            for (symbol, power) in *units {
                assert!(!seen.contains(symbol), "{symbol} stands twice");
                assert_eq!(Unit::new(symbol).to_string(), *symbol);
                seen.push(symbol);
                let of = |base: &str| symbol.strip_suffix(base).map(str::to_owned);
                let (prefix, more) = match of("bar") {
                    Some(prefix) => (prefix, 5),
                    None if *symbol == "ppm" => (String::new(), -4),
                    None => (of(base).unwrap(), 0),
                };
                let known = prefixes.iter().find(|(name, _)| *name == prefix);
                assert_eq!(known.map(|(_, power)| power + more), Some(*power), "{symbol}");
            }
        }
    }

    #[test]
    fn spellings_are_one() {
        for (word, symbol) in
            [("µs", "us"), ("μs", "us"), ("°C", "degC"), ("kΩ", "kOhm"), ("k\u{2126}", "kOhm"), (" V ", "V")]
        {
            assert_eq!(Unit::new(word).to_string(), symbol);
        }
        assert_eq!(Unit::new("l/min").scale(), None);
        assert_eq!(unit_length("m3/h und"), 4);
        assert_eq!(unit_length("3m"), 0);
        assert_eq!(unit_length("°C"), 3);
        assert_eq!((unit_length(&"°".repeat(5)), unit_length(&"°".repeat(6))), (10, 0));
        assert_eq!(unit_length("Volts_and_more"), 5);
        assert_eq!(unit_length("abcdefghijklmnopq"), 0);
    }
}
