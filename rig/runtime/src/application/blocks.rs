//! The function blocks of the expert functions: `program` calls them, `expert` has their bodies, and neither knows the
//! other (io:EXP-06).

use document::SourceFile;
use expert::{BLOCKS, BlockCall, BlockType, ExpertFunctions, ValueType};
use program::{BlockBody, Elementary, Native, Pin, PinKind, Pins, STANDARD};
use std::fmt::Write;
use std::sync::LazyLock;

/// Name of the source that declares the functions of a configuration.
const NAME: &str = "Expert functions";

/// The type by which programs refer to a function (io:EXP-16).
const REFERENCE: &str = "EXPERT_REF";

/// The standard blocks, and after them those of the expert functions.
static ALL: LazyLock<Vec<Native>> = LazyLock::new(|| {
    let blocks = BLOCKS.iter().copied().flatten();
    let own = (0..).zip(blocks).map(|(place, block)| native(place, block));
    STANDARD.iter().copied().chain(own).collect()
});

/// A block as programs know it. Tables that live as long as the process are made of constants once.
fn native(place: u16, block: &BlockType) -> Native {
    let pins: Vec<Pin> = block
        .pins
        .iter()
        .map(|pin| Pin {
            name: pin.name.to_ascii_uppercase().leak(),
            kind: match pin.kind {
                expert::BlockPinKind::Input => PinKind::Input,
                expert::BlockPinKind::Output => PinKind::Output,
                expert::BlockPinKind::Hidden => PinKind::Hidden,
            },
            ty: match pin.ty {
                ValueType::Bool => Elementary::Bool,
                ValueType::Reference | ValueType::Word => Elementary::Word,
                ValueType::Int => Elementary::Int,
                ValueType::Dint => Elementary::Dint,
                ValueType::Udint => Elementary::Udint,
                ValueType::Lint => Elementary::Lint,
            },
        })
        .collect();
    Native { name: block.name.to_ascii_uppercase().leak(), pins: pins.leak(), body: BlockBody::Host(place) }
}

/// The blocks for these sources: the standard ones, and those of the expert functions where one of them is named, so
/// that nothing else changes for a program without them.
pub fn blocks(sources: &[SourceFile]) -> &'static [Native] {
    let known =
        |word: &str| BLOCKS.iter().copied().flatten().any(|block| block.name.eq_ignore_ascii_case(word));
    let words = |text: &str| text.split(|c: char| !c.is_ascii_alphanumeric() && c != '_').any(known);
    if sources.iter().any(|source| words(&source.text)) { &ALL } else { STANDARD }
}

/// The source that declares these names of functions, in their order, by which programs refer to them; none without
/// functions.
pub fn declarations<'a>(names: impl Iterator<Item = &'a str>) -> Option<SourceFile> {
    let mut text = String::new();
    for (number, name) in (1..).zip(names).filter(|(_, name)| is_name(name)) {
        // Writing to a text does not fail.
        let _: Result<(), _> = write!(text, "{name} : {REFERENCE} := {number}; ");
    }
    if text.is_empty() {
        return None;
    }
    let text = format!("TYPE {REFERENCE} : WORD; END_TYPE VAR_GLOBAL CONSTANT {text}END_VAR");
    Some(SourceFile::new(NAME, text))
}

/// The names that functions have where nobody gives them others (io:EXP-07).
const GENERATED: [&str; 4] = ["HSC", "PTO", "PWM", "FG"];

/// The source that declares the generated names which sources mention, for programs that are looked at without a plan.
pub fn generated(sources: &[SourceFile]) -> Option<SourceFile> {
    let declared = |name: &str| sources.iter().any(|source| program::declares(&source.text, name));
    if blocks(sources).len() == STANDARD.len() || declared(REFERENCE) {
        return None;
    }
    let names = GENERATED.iter().flat_map(|kind| (0..16).map(move |number| format!("{kind}{number}")));
    let mentioned = |name: &String| sources.iter().any(|source| program::mentions(&source.text, name));
    let names: Vec<String> = names.filter(|name| mentioned(name) && !declared(name)).collect();
    // The type alone may be named, too.
    let none = names.is_empty().then_some("HSC0");
    declarations(names.iter().map(String::as_str).chain(none))
}

/// Whether a program can write it as a name; what it cannot is refused with the configuration (io:EXP-06).
fn is_name(text: &str) -> bool {
    text.bytes().all(|c| c.is_ascii_alphanumeric() || c == b'_')
        && !text.starts_with(|c: char| c.is_ascii_digit())
}

/// The pins of a call, as the bodies see them.
struct CallPins<'a, 'b>(&'a mut Pins<'b>);

impl expert::BlockPins for CallPins<'_, '_> {
    fn get(&self, pin: usize) -> i64 {
        self.0.get(pin)
    }

    fn set(&mut self, pin: usize, value: i64) {
        self.0.set(pin, value);
    }
}

/// A call of the block with this number. Whether something is due sooner than before, or somebody looks at the functions.
pub fn call(block: u16, pins: &mut Pins<'_>, expert: &mut ExpertFunctions) -> bool {
    let Some(block) = BLOCKS.iter().copied().flatten().nth(block.into()) else { return false };
    let before = expert.next();
    let now = pins.now();
    (block.run)(&mut BlockCall { now, pins: &mut CallPins(pins), expert });
    expert.is_observed() || expert.next() < before
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::application::compile;
    use profile::Profile;

    fn sources(text: &str) -> Vec<SourceFile> {
        let own = SourceFile::new("a.st", format!("PROGRAM MAIN {text} END_PROGRAM"));
        std::iter::once(own).chain(declarations(["FG0"].into_iter())).collect()
    }

    fn codes(text: &str) -> Vec<&'static str> {
        let found = compile(&sources(text), Profile::default()).err().unwrap_or_default();
        found.iter().map(|found| found.code).collect()
    }

    // io:EXP-06, io:EXP-16
    #[test]
    fn programs_call_blocks_with_the_names_of_functions() {
        let call = |of: &str| format!("VAR g : FrequencyGenerator_M241; r : EXPERT_REF; END_VAR g({of});");
        assert_eq!(codes(&call("FREQGEN_REF_IN := FG0, Enable := TRUE, Frequency := 10000")), [""; 0]);
        assert_eq!(codes(&call("FREQGEN_REF_IN := r")), [""; 0]);
        assert_eq!(codes(&call("fg0, TRUE")), [""; 0]);
        assert_eq!(codes(&call("FREQGEN_REF_IN := FG1")), ["S0301"]);
    }

    #[test]
    fn a_program_without_them_has_the_standard_blocks() {
        let plain = [SourceFile::new("a.st", "PROGRAM MAIN VAR t : TON; END_VAR t(); END_PROGRAM")];
        assert_eq!(blocks(&plain).len(), STANDARD.len());
        assert_eq!(blocks(&sources("VAR p : pwm_m241; END_VAR p();")).len(), ALL.len());
    }

    /// Every table of pins is one that programs can have.
    #[test]
    fn every_block_can_be_called() {
        for block in BLOCKS.iter().copied().flatten() {
            assert_eq!(codes(&format!("VAR b : {}; END_VAR b();", block.name)), [""; 0], "{}", block.name);
        }
    }
}
