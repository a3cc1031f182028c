//! Files of Structured Text as they are distributed: in several encodings, and wrapped into XML by some tools.

mod units;
mod xml;

use crate::codes::Code;
use document::{Diagnostic, SourceFile};

/// A source from the bytes of a file: UTF-8 or UTF-16 with its mark, anything else is ISO 8859-1. Units that stand in
/// XML are taken out of it; each of their lines keeps its number.
///
/// # Errors
/// A finding where the XML is broken or holds another language than Structured Text.
pub fn source(name: &str, bytes: &[u8]) -> Result<SourceFile, Diagnostic> {
    let text = decoded(bytes);
    let start = text.trim_start_matches(['\u{feff}', ' ', '\t', '\r', '\n']);
    if !start.starts_with('<') {
        return Ok(SourceFile::new(name, text));
    }
    match units::structured_text(&text) {
        Ok(taken) => Ok(SourceFile::new(name, taken)),
        Err(fault) => {
            let line = text.get(..fault.at).unwrap_or("").matches('\n').count() + 1;
            let code = if fault.language { Code::Unsupported } else { Code::Unexpected };
            let message = format!("{name}, line {line}: {}", fault.what);
            Err(Diagnostic::error(code.text(), message).help(fault.help))
        }
    }
}

/// Why there is no Structured Text in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct SourceFault {
    /// Bytes before it.
    at: usize,
    what: &'static str,
    help: &'static str,
    /// Another language.
    language: bool,
}

impl SourceFault {
    const fn new(at: usize, what: &'static str) -> SourceFault {
        SourceFault { at, what, help: "export it again, or give the text of the unit alone", language: false }
    }
}

/// The text of bytes in whatever encoding. Every byte sequence has one.
fn decoded(bytes: &[u8]) -> String {
    match bytes {
        [0xFF, 0xFE, rest @ ..] => utf16(rest, u16::from_le_bytes),
        [0xFE, 0xFF, rest @ ..] => utf16(rest, u16::from_be_bytes),
        _ => match std::str::from_utf8(bytes) {
            Ok(text) => text.to_owned(),
            // Each byte is the character of its number: a STRING keeps the bytes that the file has.
            Err(_) => bytes.iter().copied().map(char::from).collect(),
        },
    }
}

fn utf16(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> String {
    let units = bytes.chunks_exact(2).filter_map(|pair| pair.first_chunk().copied().map(unit));
    char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_encoding_is_read() {
        let plain = "VAR s : STRING := 'ö'; END_VAR";
        let utf16 = |mark: u16, swap: bool| {
            std::iter::once(mark)
                .chain(plain.encode_utf16())
                .flat_map(|unit| if swap { unit.to_be_bytes() } else { unit.to_le_bytes() })
                .collect::<Vec<u8>>()
        };
        let latin: Vec<u8> = plain.chars().map(|c| c as u8).collect();
        for bytes in [plain.as_bytes().to_vec(), latin, utf16(0xFEFF, false), utf16(0xFEFF, true)] {
            assert_eq!(source("a.st", &bytes).unwrap().text, plain);
        }
        assert_eq!(source("a.st", &[0xFF, 0xFE, 0x41]).unwrap().text, "");
        assert_eq!(source("a.st", &[0x80, 0x41]).unwrap().text, "\u{80}A");
    }

    #[test]
    fn what_is_no_text_is_refused() {
        let code = |text: &str| source("a.TcPOU", text.as_bytes()).unwrap_err().code;
        assert_eq!(code("<TcPlcObject><POU"), "S0102");
        assert_eq!(code("<a></b>"), "S0102");
        assert_eq!(code("<html><body/></html>"), "S0102");
        assert_eq!(code("<POU><Implementation><NWL/></Implementation></POU>"), "S0901");
    }
}
