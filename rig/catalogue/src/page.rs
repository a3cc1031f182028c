//! The pages of modules.

use document::{Codes, Diagnostic, Fields, Findings, KeySpec, KeyType, Node, SourceFile, Table, toml};
use profile::{
    AnalogueChannels, Conversion, DigitalInputs, DigitalOutputKind, DigitalOutputs, ModuleFamily, ModuleKind,
    ModuleType, Profile, SafetyFunction,
};
use signal::{Quantity, Span};

use crate::modes::Modes;
use crate::source::{self, SOURCE};

/// The pages that are built in, with their names.
const PAGES: &[(&str, &str)] = &[
    ("tm3-digital.toml", include_str!("../modules/tm3-digital.toml")),
    ("tm3-analogue.toml", include_str!("../modules/tm3-analogue.toml")),
    ("tm3-expert.toml", include_str!("../modules/tm3-expert.toml")),
    ("tm3-safety.toml", include_str!("../modules/tm3-safety.toml")),
    ("tm2-digital.toml", include_str!("../modules/tm2-digital.toml")),
    ("tm2-analogue.toml", include_str!("../modules/tm2-analogue.toml")),
    ("tm4.toml", include_str!("../modules/tm4.toml")),
    ("tmc4.toml", include_str!("../modules/tmc4.toml")),
];

/// The page of the modes of analogue channels.
const MODES: (&str, &str) = ("modes.toml", include_str!("../modules/modes.toml"));

/// What is wrong with the pages reaches whoever changes one, by a test, and never a user.
const CODES: Codes = Codes {
    syntax: "syntax",
    newer_toml: "syntax",
    too_large: "too large",
    unknown_key: "unknown key",
    missing_key: "missing key",
    wrong_type: "wrong type",
    unreadable: "unreadable",
};

const FAMILY: KeyType = KeyType::Choice(&["TM2", "TM3", "TM4", "TMC4"]);
const KIND: KeyType =
    KeyType::Choice(&["digital", "analogue", "expert", "safety", "communication", "transmitter", "receiver"]);
const PROFILES: KeyType = KeyType::OneOrMore(&KeyType::Choice(&["m241-2014", "m241-2019", "m251-2024"]));
const CHANNELS: KeyType = KeyType::Integer(1, 64);
const FIRMWARE: KeyType = KeyType::Integer(0, 0xFFFE);

/// The keys of a page: what holds of all its modules, and these.
const PAGE_KEYS: &[KeySpec] = &[
    KeySpec::required("family", FAMILY, "The family of its modules."),
    KeySpec::required("kind", KIND, "What its modules are for."),
    KeySpec::required("profiles", PROFILES, "The profiles that know its modules."),
    KeySpec::optional("terminals", KeyType::Text, "How wires are connected."),
    KeySpec::optional("firmware", FIRMWARE, "The version of the modules' firmware."),
    KeySpec::optional("note", KeyType::Text, "What else is to be known."),
    KeySpec::optional("source", SOURCE, "Where figures are from that no document has."),
    KeySpec::required("modules", KeyType::Map(&KeyType::Table(MODULE_KEYS)), "The modules by reference."),
];

/// The keys of a module.
const MODULE_KEYS: &[KeySpec] = &[
    KeySpec::optional("kind", KIND, "What it is for, where that is not what the page says."),
    KeySpec::optional("id", KeyType::Integer(0, 255), "The internal ID code."),
    KeySpec::optional("spring", KeyType::Bool, "Whether there is one more, with G, with spring terminals."),
    KeySpec::optional("terminals", KeyType::Text, "How wires are connected."),
    KeySpec::optional("digital-inputs", KeyType::Table(INPUT_KEYS), "Digital inputs."),
    KeySpec::optional("digital-outputs", KeyType::Table(OUTPUT_KEYS), "Digital outputs."),
    KeySpec::optional("analogue-inputs", KeyType::Table(ANALOGUE_KEYS), "Analogue inputs."),
    KeySpec::optional("analogue-outputs", KeyType::Table(ANALOGUE_KEYS), "Analogue outputs."),
    KeySpec::optional("safety", KeyType::Table(SAFETY_KEYS), "The function of a safety module."),
    KeySpec::optional("firmware", FIRMWARE, "The version of its firmware."),
    KeySpec::optional("note", KeyType::Text, "What else is to be known."),
    KeySpec::optional("source", SOURCE, "Where figures are from that no document has."),
];

const INPUT_KEYS: &[KeySpec] = &[
    KeySpec::required("count", CHANNELS, "How many."),
    KeySpec::optional("rating", KeyType::Text, "Voltage and current."),
    KeySpec::optional("on-delay", KeyType::Duration, "From the edge at the terminal to a 1."),
    KeySpec::optional("off-delay", KeyType::Duration, "From the edge at the terminal to a 0."),
];

const OUTPUT_KEYS: &[KeySpec] = &[
    KeySpec::required("count", CHANNELS, "How many."),
    KeySpec::optional("kind", KeyType::Choice(&["relay", "source", "sink"]), "What they are."),
    KeySpec::optional("rating", KeyType::Text, "Voltage."),
    KeySpec::optional("output-current", KeyType::Quantity, "Most current of one output."),
    KeySpec::optional("common-current", KeyType::Quantity, "Most current of a common line."),
    KeySpec::optional("on-delay", KeyType::Duration, "From a 1 to the edge at the terminal, at most."),
    KeySpec::optional("off-delay", KeyType::Duration, "From a 0 to the edge at the terminal, at most."),
];

const ANALOGUE_KEYS: &[KeySpec] = &[
    KeySpec::required("count", CHANNELS, "How many."),
    KeySpec::optional("bits", KeyType::Integer(1, 16), "Resolution in bits."),
    KeySpec::optional("modes", KeyType::OneOrMore(&KeyType::Text), "Modes, or groups of modes, by name."),
    KeySpec::optional("conversion", KeyType::Table(CONVERSION_KEYS), "Conversion of voltages and currents."),
    KeySpec::optional(
        "temperature-conversion",
        KeyType::Table(CONVERSION_KEYS),
        "Conversion of temperatures.",
    ),
];

const CONVERSION_KEYS: &[KeySpec] = &[
    KeySpec::optional("fixed", KeyType::Duration, "The part that is always the same."),
    KeySpec::required(
        "per-channel",
        KeyType::OneOrMore(&KeyType::Duration),
        "The part for each channel in use, the default first.",
    ),
];

const SAFETY_KEYS: &[KeySpec] = &[
    KeySpec::required("functions", KeyType::Integer(1, 8), "How many functions it has."),
    KeySpec::required("category", KeyType::Integer(1, 4), "The category that it reaches at most."),
    KeySpec::required("inputs", KeyType::OneOrMore(&KeyType::Integer(1, 8)), "The numbers of safety inputs."),
    KeySpec::optional("non-monitored-start", KeyType::Bool, "Whether its start is not monitored."),
];

/// What is wrong with the pages, with the texts in which it stands.
pub type PageFindings = Vec<(SourceFile, Diagnostic)>;

/// Reads the pages that are built in: the modules, and what is wrong. A table that is wrong gives no module.
pub fn read_pages() -> (Vec<ModuleType>, PageFindings) {
    read(MODES, PAGES)
}

/// Reads pages by name and text, that of the modes first.
fn read(modes_page: (&str, &str), pages: &[(&str, &str)]) -> (Vec<ModuleType>, PageFindings) {
    let mut findings = Vec::new();
    let mut each = |(name, text): (&str, &str), read: &mut dyn FnMut(&Table, &mut Findings)| {
        let file = SourceFile::new(name, text);
        let found = match toml::parse(&file, CODES) {
            Ok(page) => {
                let mut out = Findings::new(&file, CODES);
                read(&page, &mut out);
                out.into_vec()
            }
            Err(found) => found,
        };
        findings.extend(found.into_iter().map(|found| (file.clone(), found)));
    };
    let mut modes = None;
    each(modes_page, &mut |page, out| modes = Some(Modes::read(page, out)));
    let mut modules: Vec<ModuleType> = Vec::new();
    if let Some(modes) = &modes {
        for page in pages {
            each(*page, &mut |table, out| read_page(table, modes, &mut modules, out));
        }
    }
    (modules, findings)
}

fn read_page(page: &Table, modes: &Modes, modules: &mut Vec<ModuleType>, out: &mut Findings) {
    let fields = Fields::check(page, 0..0, "page", PAGE_KEYS, out);
    let family = word(fields.text("family"), &ModuleFamily::ALL, ModuleFamily::name);
    let kind = word(fields.text("kind"), &ModuleKind::ALL, ModuleKind::name);
    let (Some(family), Some(kind), Some(tables)) = (family, kind, fields.get("modules")) else { return };
    for entry in tables.as_table().map_or(&[][..], |table| &table.entries) {
        let Some(table) = entry.node.as_table() else { continue };
        if !entry.key.starts_with(family.name()) || modules.iter().any(|other| other.reference == entry.key) {
            let message = format!("`{}` is there twice, or is no reference of {}", entry.key, family.name());
            out.error(out.codes().unreadable, entry.key_span.clone(), message, "give it its own reference");
            continue;
        }
        let of = Fields::checked(table, MODULE_KEYS);
        let module = read_module(&entry.key, family, kind, &fields, &of, modes, out);
        let spring = of.boolean("spring").unwrap_or(false).then(|| with_spring_terminals(&module));
        modules.push(module);
        modules.extend(spring);
    }
}

/// The module of the table `of` on a page of `fields`.
fn read_module(
    reference: &str,
    family: ModuleFamily,
    kind: ModuleKind,
    fields: &Fields<'_>,
    of: &Fields<'_>,
    modes: &Modes,
    out: &mut Findings,
) -> ModuleType {
    let kind = word(of.text("kind"), &ModuleKind::ALL, ModuleKind::name).unwrap_or(kind);
    // What a module says itself stands before what its page says.
    let own = |name: &str| of.get(name).or_else(|| fields.get(name));
    let text = |name: &str| own(name).and_then(Node::as_text).map(String::from);
    let mut sources = source::read(of.get("source"), of.table(), false, out);
    // Figures that the page gives have the page's sources, too.
    let mut figures = of.table().clone();
    figures.entries.extend(fields.table().entries.iter().filter(|one| !of.has(&one.key)).cloned());
    for one in source::read(fields.get("source"), &figures, true, out) {
        if sources.iter().all(|own| own.figure != one.figure) {
            sources.push(one);
        }
    }
    ModuleType {
        id: of.integer("id").and_then(|id| u8::try_from(id).ok()),
        profiles: profiles(fields),
        terminals: text("terminals"),
        digital_inputs: of.inner("digital-inputs").map(|of| digital_inputs(&of)),
        digital_outputs: of.inner("digital-outputs").map(|of| digital_outputs(&of, out)),
        analogue_inputs: of.inner("analogue-inputs").map(|of| analogue(&of, family, modes, out)),
        analogue_outputs: of.inner("analogue-outputs").map(|of| analogue(&of, family, modes, out)),
        safety: of.inner("safety").map(|of| safety(&of)),
        firmware: of
            .integer("firmware")
            .or_else(|| fields.integer("firmware"))
            .and_then(|one| u16::try_from(one).ok()),
        note: text("note"),
        sources,
        ..ModuleType::new(reference, family, kind)
    }
}

/// The same module with spring terminals: its reference ends with G.
fn with_spring_terminals(module: &ModuleType) -> ModuleType {
    ModuleType {
        reference: format!("{}G", module.reference),
        terminals: module.terminals.as_ref().map(|terminals| terminals.replace("screw", "spring")),
        ..module.clone()
    }
}

fn profiles(fields: &Fields<'_>) -> Vec<Profile> {
    let names = fields.each("profiles").iter().filter_map(Node::as_text);
    names.filter_map(|name| name.parse().ok()).collect()
}

fn digital_inputs(of: &Fields<'_>) -> DigitalInputs {
    DigitalInputs {
        count: small(of, "count"),
        rating: of.text("rating").map(String::from),
        on_delay: of.duration("on-delay"),
        off_delay: of.duration("off-delay"),
    }
}

fn digital_outputs(of: &Fields<'_>, out: &mut Findings) -> DigitalOutputs {
    DigitalOutputs {
        count: small(of, "count"),
        kind: word(of.text("kind"), &DigitalOutputKind::ALL, DigitalOutputKind::name),
        rating: of.text("rating").map(String::from),
        output_current: current(of, "output-current", out),
        common_current: current(of, "common-current", out),
        on_delay: of.duration("on-delay"),
        off_delay: of.duration("off-delay"),
    }
}

fn analogue(of: &Fields<'_>, family: ModuleFamily, modes: &Modes, out: &mut Findings) -> AnalogueChannels {
    let conversion = |name: &str| of.inner(name).map(|of| conversion(&of));
    AnalogueChannels {
        count: small(of, "count"),
        bits: of.integer("bits").and_then(|bits| u8::try_from(bits).ok()),
        modes: modes.named(family, of.each("modes"), out),
        conversion: conversion("conversion"),
        temperature_conversion: conversion("temperature-conversion"),
    }
}

fn conversion(of: &Fields<'_>) -> Conversion {
    let spans = of.each("per-channel").iter().filter_map(|one| Span::parse(one.as_text()?).ok());
    Conversion { fixed: of.duration("fixed").unwrap_or(Span::ZERO), per_channel: spans.collect() }
}

fn safety(of: &Fields<'_>) -> SafetyFunction {
    let byte = |node: &Node| match node.data {
        document::Data::Integer(number) => u8::try_from(number).ok(),
        _ => None,
    };
    SafetyFunction {
        functions: of.get("functions").and_then(byte).unwrap_or_default(),
        category: of.get("category").and_then(byte).unwrap_or_default(),
        inputs: of.each("inputs").iter().filter_map(byte).collect(),
        non_monitored_start: of.boolean("non-monitored-start").unwrap_or(false),
    }
}

/// The value that a word names.
fn word<T: Copy>(text: Option<&str>, all: &[T], name: impl Fn(T) -> &'static str) -> Option<T> {
    all.iter().copied().find(|one| Some(name(*one)) == text)
}

/// A whole number of at least 0.
fn small(of: &Fields<'_>, name: &str) -> u32 {
    of.integer(name).and_then(|number| u32::try_from(number).ok()).unwrap_or_default()
}

/// A current, in A or a part of it.
fn current(of: &Fields<'_>, name: &str, out: &mut Findings) -> Option<Quantity> {
    let node = of.get(name)?;
    let quantity = node.as_text().and_then(|text| Quantity::parse(text).ok());
    let ampere = signal::Unit::new("A");
    let quantity = quantity.filter(|quantity| quantity.in_unit(&ampere).is_some());
    if quantity.is_none() {
        out.bad(out.codes().unreadable, node, format!("`{name}` is no current"), "write it as in \"0.5 A\"");
    }
    quantity
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "family = \"TM3\"\nkind = \"analogue\"\nprofiles = [\"m241-2019\"]\n";

    /// How many modules a page gives, and what is said of it.
    fn found(mode: &str, module: &str) -> (usize, Vec<String>) {
        let modes = format!("[TM3.\"0..10 V\"]\nunit = \"V\"\n{mode}");
        let page = format!("{HEAD}[modules.TM3AI4]\n{module}");
        let (modules, findings) = read(("modes.toml", &modes), &[("page.toml", &page)]);
        (
            modules.len(),
            findings.into_iter().map(|(file, found)| format!("{}: {}", file.name, found.message)).collect(),
        )
    }

    // A page that is wrong is no module with less in it: it is reported.
    #[test]
    fn what_is_wrong_with_a_page_is_found() {
        assert_eq!(found("low = 0", "id = 193\nspring = true"), (2, vec![]));
        for (mode, module, message) in [
            ("lowest = 0", "", "modes.toml: `lowest` is not a key of the table `0..10 V`"),
            ("source = { low = \"x\" }", "", "modes.toml: there is no figure `low`"),
            ("", "id = 256", "page.toml: `id` is 256; expected an integer from 0 to 255"),
            ("", "source = { firmware = \"x\" }", "page.toml: there is no figure `firmware`"),
            (
                "",
                "digital-inputs = { count = 8 }\nsource = { digital-inputs.on-delay = \"x\" }",
                "page.toml: there is no figure `digital-inputs.on-delay`",
            ),
            (
                "",
                "analogue-inputs = { count = 4, modes = [\"0..1 V\"] }",
                "page.toml: `0..1 V` is no mode of TM3",
            ),
            (
                "",
                "digital-outputs = { count = 8, output-current = \"2 V\" }",
                "page.toml: `output-current` is no current",
            ),
            ("", "[modules.TM2X]", "page.toml: `TM2X` is there twice, or is no reference of TM3"),
        ] {
            assert_eq!(found(mode, module).1, [message], "{mode} {module}");
        }
    }

    #[test]
    fn a_page_that_is_no_toml_gives_nothing() {
        let (modules, findings) = read(("modes.toml", ""), &[("page.toml", "family =")]);
        assert!(modules.is_empty() && !findings.is_empty());
    }
}
