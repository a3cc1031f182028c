//! The analogue channels of a module in `settings.modules` (io: 10.3; manufacturer's product help, TM3 analogue modules).

use document::{Fields, Findings, KeySpec, KeyType, Node, suggest};
use profile::{
    AnalogueChannels, AnalogueInputSettings, AnalogueMode, AnalogueOutputSettings, CountRange, ModuleType,
    TemperatureScope,
};
use signal::Span;

use crate::codes;

const WORD: KeyType = KeyType::Integer(i16::MIN as i64, i16::MAX as i64);

const INPUT_KEYS: &[KeySpec] = &[
    KeySpec::optional("mode", KeyType::Text, "Its mode, as in \"4..20 mA\"; \"not used\" if left out."),
    KeySpec::optional("min", WORD, "Its word at the low end of the mode; -32768 if left out."),
    KeySpec::optional("max", WORD, "Its word at the high end of the mode; 32767 if left out."),
    KeySpec::optional(
        "scope",
        KeyType::Choice(&["celsius", "fahrenheit"]),
        "In what a temperature is counted; celsius if left out.",
    ),
    KeySpec::optional("filter", KeyType::Duration, "The time constant of its filter; none if left out."),
];

const OUTPUT_KEYS: &[KeySpec] = &[
    KeySpec::optional("mode", KeyType::Text, "Its mode, as in \"0..10 V\"; \"not used\" if left out."),
    KeySpec::optional("min", WORD, "Its word at the low end of the mode; -32768 if left out."),
    KeySpec::optional("max", WORD, "Its word at the high end of the mode; 32767 if left out."),
    KeySpec::optional("fallback", WORD, "Its word as a default value; 0 or what is next to it if left out."),
];

/// A channel: its mode alone, or a table.
const INPUT_TYPE: KeyType = KeyType::Either(&[KeyType::Text, KeyType::Table(INPUT_KEYS)]);
const OUTPUT_TYPE: KeyType = KeyType::Either(&[KeyType::Text, KeyType::Table(OUTPUT_KEYS)]);

/// The mode of a channel that is not used.
const NOT_USED: &str = "not used";

/// The type of `inputs` of a module.
pub(super) const INPUTS_TYPE: KeyType = KeyType::List(&INPUT_TYPE);

/// The type of `outputs` of a module.
pub(super) const OUTPUTS_TYPE: KeyType = KeyType::List(&OUTPUT_TYPE);

/// Reads `sampling`, a choice of the module.
pub(super) fn sampling(fields: &Fields<'_>, module: &ModuleType, out: &mut Findings) -> Option<Span> {
    let (node, chosen) = (fields.get("sampling")?, fields.duration("sampling")?);
    let conversion = module.analogue_inputs.as_ref().and_then(|inputs| inputs.conversion.as_ref());
    let choices = conversion.map_or(&[][..], |conversion| &conversion.per_channel);
    match choices {
        [_, _, ..] if choices.contains(&chosen) => return Some(chosen),
        [_, _, ..] => {
            let choices: Vec<String> = choices.iter().map(Span::to_string).collect();
            let message = format!("{} has no sampling of {chosen} for each channel", module.reference);
            out.bad(codes::CHANNEL_PARAMETER, node, message, format!("write {}", choices.join(" or ")));
        }
        _ => {
            let message = format!("{} has no choice of `sampling`", module.reference);
            out.bad(codes::CHANNEL_KEY, node, message, "remove it");
        }
    }
    None
}

/// Reads `inputs` of a module.
pub(super) fn inputs(
    fields: &Fields<'_>,
    module: &'static ModuleType,
    out: &mut Findings,
) -> Vec<Option<AnalogueInputSettings<'static>>> {
    let list = channels(fields, "inputs", module, module.analogue_inputs.as_ref(), out);
    let Some((list, channels)) = list else { return Vec::new() };
    list.iter().map(|node| input(node, module, channels, out)).collect()
}

/// Reads `outputs` of a module.
pub(super) fn outputs(
    fields: &Fields<'_>,
    module: &'static ModuleType,
    out: &mut Findings,
) -> Vec<Option<AnalogueOutputSettings<'static>>> {
    let list = channels(fields, "outputs", module, module.analogue_outputs.as_ref(), out);
    let Some((list, channels)) = list else { return Vec::new() };
    list.iter().map(|node| output(node, module, channels, out)).collect()
}

/// The list under a key, as far as the module has channels for it.
fn channels<'a>(
    fields: &Fields<'a>,
    key: &str,
    module: &ModuleType,
    channels: Option<&'static AnalogueChannels>,
    out: &mut Findings,
) -> Option<(&'a [Node], &'static AnalogueChannels)> {
    let list = fields.each(key);
    let count = channels.map_or(0, |channels| channels.count as usize);
    if let Some(node) = list.get(count) {
        let message =
            format!("{} has {count} analogue {key}, {} are described", module.reference, list.len());
        let help = if count == 0 { "remove the list" } else { "remove the others" };
        out.bad(codes::TOO_MANY_CHANNELS, node, message, help);
    }
    Some((&list[..count.min(list.len())], channels?))
}

fn input(
    node: &Node,
    module: &ModuleType,
    channels: &'static AnalogueChannels,
    out: &mut Findings,
) -> Option<AnalogueInputSettings<'static>> {
    let Some(table) = node.as_table() else {
        return named(node, module, channels, out).map(AnalogueInputSettings::new);
    };
    let fields = Fields::checked(table, INPUT_KEYS);
    let mode = mode(&fields, module, channels, out)?;
    let fixed = mode.step.is_some() || mode.low.is_none();
    let is_temperature = mode.unit == signal::Unit::new("degC");
    for (key, applies) in [("min", !fixed), ("max", !fixed), ("scope", is_temperature)] {
        if let Some(entry) = fields.entry(key).filter(|_| !applies) {
            let message = format!("an input of mode `{}` has no `{key}`", mode.name);
            let help = if fixed { "remove it: what it counts is fixed" } else { "remove it" };
            out.error(codes::CHANNEL_KEY, entry.key_span.clone(), message, help);
        }
    }
    let filter = fields.duration("filter").unwrap_or_default();
    let step = AnalogueInputSettings::FILTER_STEP;
    if filter > AnalogueInputSettings::LONGEST_FILTER || filter.as_nanos() % step.as_nanos() != 0 {
        let message = format!("a filter of {filter}");
        let help = format!("write a multiple of {step} up to {}", AnalogueInputSettings::LONGEST_FILTER);
        out.bad(codes::CHANNEL_PARAMETER, fields.get("filter")?, message, help);
    }
    let scope = match fields.text("scope") {
        Some("fahrenheit") => TemperatureScope::Fahrenheit,
        _ => TemperatureScope::Celsius,
    };
    let counts = counts(&fields, out)?;
    Some(AnalogueInputSettings { mode, counts, scope, filter })
}

fn output(
    node: &Node,
    module: &ModuleType,
    channels: &'static AnalogueChannels,
    out: &mut Findings,
) -> Option<AnalogueOutputSettings<'static>> {
    let Some(table) = node.as_table() else {
        let mode = named(node, module, channels, out)?;
        return Some(AnalogueOutputSettings::new(mode, CountRange::FULL));
    };
    let fields = Fields::checked(table, OUTPUT_KEYS);
    let mode = mode(&fields, module, channels, out)?;
    let counts = counts(&fields, out)?;
    let settings = AnalogueOutputSettings::new(mode, counts);
    let Some(fallback) = word(&fields, "fallback") else { return Some(settings) };
    if !counts.contains(fallback) {
        let message = format!("a fallback value of {fallback}");
        let help = format!("write a word from {} to {}", counts.minimum(), counts.maximum());
        out.bad(codes::CHANNEL_PARAMETER, fields.get("fallback")?, message, help);
    }
    Some(AnalogueOutputSettings { fallback, ..settings })
}

/// The mode of a channel; none of one that is not used, which has no other key either.
fn mode(
    fields: &Fields<'_>,
    module: &ModuleType,
    channels: &'static AnalogueChannels,
    out: &mut Findings,
) -> Option<&'static AnalogueMode> {
    let used = fields.get("mode").filter(|node| node.as_text().map(str::trim) != Some(NOT_USED));
    if used.is_none()
        && let Some(entry) = fields.table().entries.iter().find(|entry| entry.key != "mode")
    {
        let message = format!("a channel without a mode is not used, and has no `{}`", entry.key);
        out.error(codes::CHANNEL_KEY, entry.key_span.clone(), message, "give the channel a `mode`");
    }
    named(used?, module, channels, out)
}

/// The mode that a text names; none of one that is not used.
fn named(
    node: &Node,
    module: &ModuleType,
    channels: &'static AnalogueChannels,
    out: &mut Findings,
) -> Option<&'static AnalogueMode> {
    let name = node.as_text()?.trim();
    if name == NOT_USED {
        return None;
    }
    let found = channels.mode(name);
    if found.is_none() {
        let known = channels.modes.iter().map(|mode| mode.name.as_str());
        let help = match suggest(name, known.clone()) {
            Some(near) => format!("did you mean \"{near}\"?"),
            None if channels.modes.is_empty() => {
                String::from("no document has its modes: write \"not used\", or leave the channel out")
            }
            None => format!("its modes are {}", known.collect::<Vec<_>>().join(", ")),
        };
        let message = format!("a channel of {} has no mode `{name}`", module.reference);
        out.bad(codes::CHANNEL_MODE, node, message, help);
    }
    found
}

/// The words at the ends of the mode.
fn counts(fields: &Fields<'_>, out: &mut Findings) -> Option<CountRange> {
    let minimum = word(fields, "min").unwrap_or(CountRange::FULL.minimum());
    let maximum = word(fields, "max").unwrap_or(CountRange::FULL.maximum());
    let counts = CountRange::new(minimum, maximum);
    if counts.is_none() {
        let node = fields.get("max").or_else(|| fields.get("min"))?;
        let message = format!("`min` is {minimum}, and `max` {maximum}");
        out.bad(codes::CHANNEL_PARAMETER, node, message, "write a `min` below `max`");
    }
    counts
}

fn word(fields: &Fields<'_>, key: &str) -> Option<i16> {
    fields.integer(key).and_then(|word| i16::try_from(word).ok())
}
