//! The names of the conversions.

use super::functions;
use crate::library::Function;
use crate::types::Elementary::{self, *};

/// What stands on one side of a conversion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ConversionSide {
    Scalar(Elementary),
    String,
    Wstring,
}

/// How a conversion goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum How {
    /// As [`super::convert`], or with a text on a side.
    Plain,
    /// From REAL or LREAL to a whole number, towards 0.
    Truncate,
    /// From a bit string of decimal digits to a whole number.
    FromBcd,
    /// From a whole number to a bit string of decimal digits.
    ToBcd,
}

/// What the name of a conversion says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Conversion {
    /// `None` for the type of the argument, as in TO_INT.
    pub from: Option<ConversionSide>,
    pub to: ConversionSide,
    pub how: How,
}

impl Conversion {
    /// The function that does what is not plain; its one argument is of the type `from`.
    pub(crate) fn function(self) -> Option<&'static Function> {
        let ConversionSide::Scalar(to) = self.to else { return None };
        let prefix = match self.how {
            How::Plain => return None,
            How::Truncate => "TRUNC_",
            How::FromBcd => "BCD_TO_",
            How::ToBcd => "TO_BCD_",
        };
        functions::FUNCTIONS.iter().find(|function| function.name.strip_prefix(prefix) == Some(to.name()))
    }
}

/// The conversion with this name, in capitals: `A_TO_B`, `TO_B`, `ANY_TO_B`; `A_TRUNC_B`, `TRUNC_B` and TRUNC, which
/// gives DINT; `A_BCD_TO_B`, `BCD_TO_B`, `A_TO_BCD_B`, `TO_BCD_B` and `A_TO_BCD`.
pub(crate) fn parse_conversion(key: &str) -> Option<Conversion> {
    if key == "TRUNC" {
        return Some(Conversion { from: None, to: ConversionSide::Scalar(Dint), how: How::Truncate });
    }
    if let Some((from, to)) = split(key, "TRUNC_") {
        let (from, to) = (optional(from)?, side(to)?);
        return (whole(to) && from.is_none_or(real)).then_some(Conversion { from, to, how: How::Truncate });
    }
    let (from, to) = split(key, "TO_")?;
    let digits =
        if from == "BCD" { Some("") } else { from.strip_suffix("_BCD").filter(|from| !from.is_empty()) };
    if let Some(from) = digits {
        let (from, to) = (optional(from)?, side(to)?);
        return (whole(to) && from.is_none_or(bits)).then_some(Conversion { from, to, how: How::FromBcd });
    }
    if to == "BCD" {
        let from = side(from)?;
        let to = ConversionSide::Scalar(digits_of(from)?);
        return Some(Conversion { from: Some(from), to, how: How::ToBcd });
    }
    if let Some(to) = to.strip_prefix("BCD_") {
        let (from, to) = (optional(from)?, side(to)?);
        return (bits(to) && from.is_none_or(whole)).then_some(Conversion { from, to, how: How::ToBcd });
    }
    let from = if matches!(from, "ANY" | "ANY_NUM") { None } else { optional(from)? };
    Some(Conversion { from, to: side(to)?, how: How::Plain })
}

/// What stands before and after the word, which begins the name or follows a `_`.
fn split<'a>(key: &'a str, word: &str) -> Option<(&'a str, &'a str)> {
    if let Some(to) = key.strip_prefix(word) {
        return Some(("", to));
    }
    key.match_indices(word).find_map(|(place, _)| {
        let from = key.get(..place)?.strip_suffix('_')?;
        (!from.is_empty()).then_some((from, key.get(place..)?.strip_prefix(word)?))
    })
}

fn side(key: &str) -> Option<ConversionSide> {
    match key {
        "STRING" => Some(ConversionSide::String),
        "WSTRING" => Some(ConversionSide::Wstring),
        _ => Elementary::named(key).map(ConversionSide::Scalar),
    }
}

/// A type that may be missing; `None` where it is no type.
fn optional(key: &str) -> Option<Option<ConversionSide>> {
    if key.is_empty() { Some(None) } else { side(key).map(Some) }
}

fn real(side: ConversionSide) -> bool {
    matches!(side, ConversionSide::Scalar(ty) if ty.is_real())
}

fn whole(side: ConversionSide) -> bool {
    matches!(side, ConversionSide::Scalar(ty) if ty.is_integer())
}

fn bits(side: ConversionSide) -> bool {
    matches!(side, ConversionSide::Scalar(ty) if ty.is_bit_string())
}

/// What `A_TO_BCD` gives: the bit string as wide as A, but a BYTE for INT, as the controllers' Util library has it.
fn digits_of(from: ConversionSide) -> Option<Elementary> {
    match from {
        ConversionSide::Scalar(Sint | Usint | Byte | Int) => Some(Byte),
        ConversionSide::Scalar(Uint | Word) => Some(Word),
        ConversionSide::Scalar(Dint | Udint | Dword) => Some(Dword),
        ConversionSide::Scalar(Lint | Ulint | Lword) => Some(Lword),
        _ => None,
    }
}
