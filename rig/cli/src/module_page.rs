//! What the catalogue says of a module, as a person reads it.

use crate::paragraph::{WIDTH, wrap};
use catalogue::channels;
use profile::{
    AnalogueChannels, AnalogueMode, ChannelAddresses, ConfiguredModule, Conversion, FigureSource,
    ModuleAddresses, ModuleKind, ModuleType, Reference,
};
use signal::{Decimal, Span};
use std::fmt::Write;

/// Where the values of a page begin.
const LABEL: usize = 22;

/// The controllers whose addresses a page shows, with what they stand for.
const CONTROLLERS: &[(&str, &str)] = &[
    ("TM251MESC", "an M251"),
    ("TM241CEC24T", "an M241 of 24 channels"),
    ("TM241C40T", "an M241 of 40 channels"),
];

/// Every module in a line: its reference and its channels, or what it is for.
pub fn list() -> String {
    let line = |module: &ModuleType| format!("{:12}{}\n", module.reference, title(module));
    catalogue::modules().iter().map(line).collect()
}

/// The page of a module.
pub fn show(module: &ModuleType) -> String {
    let mut page = Page(format!("{}: {}\n\n", module.reference, title(module)));
    if let Some(id) = module.id {
        let others: Vec<_> = catalogue::with_the_same_id(module).map(|one| one.reference.as_str()).collect();
        let shared =
            if others.is_empty() { String::new() } else { format!(", shared with {}", others.join(", ")) };
        page.row("Internal ID code", &format!("{id}{shared}"));
    }
    page.row("Profiles", &module.profiles.iter().map(|one| one.name()).collect::<Vec<_>>().join(", "));
    page.maybe("Terminals", module.terminals.as_deref());
    page.digital(module);
    page.analogue("Analogue inputs", module.analogue_inputs.as_ref());
    page.analogue("Analogue outputs", module.analogue_outputs.as_ref());
    if let Some(safety) = &module.safety {
        let inputs: Vec<String> = safety.inputs.iter().map(u8::to_string).collect();
        let start = if safety.non_monitored_start { ", start not monitored" } else { "" };
        page.row(
            "Safety function",
            &format!(
                "{}, up to category {}, {} safety inputs{start}",
                safety.functions,
                safety.category,
                inputs.join(" or ")
            ),
        );
    }
    page.maybe("Firmware", module.firmware.map(|version| version.to_string()).as_deref());
    page.maybe("Note", module.note.as_deref());
    page.addresses(module);
    page.modes(module);
    page.sources(module);
    if module.kind == ModuleKind::Safety {
        page.0 += "\n";
        page.0 += &wrap("What the rig models of it is its documented function: the rig is no safety device.");
    }
    page.0
}

/// Family, kind and channels.
fn title(module: &ModuleType) -> String {
    let (family, kind) = (module.family.name(), module.kind.name());
    match channels(module) {
        none if none.is_empty() => format!("{family} {kind}"),
        channels => format!("{family} {kind}, {channels}"),
    }
}

/// The text of a page so far.
struct Page(String);

impl Page {
    /// A label and its value, in as many lines as it takes.
    fn row(&mut self, label: &str, value: &str) {
        let mut label = label;
        let mut line = String::new();
        for word in value.split_whitespace() {
            if !line.is_empty() && LABEL + line.chars().count() + 1 + word.chars().count() > WIDTH {
                let _ = writeln!(self.0, "{label:LABEL$}{line}");
                (label, line) = ("", String::new());
            }
            line += if line.is_empty() { "" } else { " " };
            line += word;
        }
        let _ = writeln!(self.0, "{label:LABEL$}{line}");
    }

    fn maybe(&mut self, label: &str, value: Option<&str>) {
        if let Some(value) = value {
            self.row(label, value);
        }
    }

    fn digital(&mut self, module: &ModuleType) {
        if let Some(inputs) = &module.digital_inputs {
            let parts = [Some(inputs.count.to_string()), inputs.rating.clone()];
            self.row(
                "Digital inputs",
                &joined(parts.into_iter().chain(delays(inputs.on_delay, inputs.off_delay))),
            );
        }
        if let Some(outputs) = &module.digital_outputs {
            let parts = [
                Some(outputs.kind.map_or_else(
                    || outputs.count.to_string(),
                    |kind| format!("{} {}", outputs.count, kind.name()),
                )),
                outputs.rating.clone(),
                outputs
                    .output_current
                    .as_ref()
                    .map(|most| format!("{} {} an output", most.number, most.unit)),
                outputs
                    .common_current
                    .as_ref()
                    .map(|most| format!("{} {} a common line", most.number, most.unit)),
            ];
            self.row(
                "Digital outputs",
                &joined(parts.into_iter().chain(delays(outputs.on_delay, outputs.off_delay))),
            );
        }
    }

    fn analogue(&mut self, label: &str, channels: Option<&AnalogueChannels>) {
        let Some(channels) = channels else { return };
        let parts = [Some(channels.count.to_string()), channels.bits.map(|bits| format!("{bits} bit"))];
        self.row(label, &joined(parts));
        self.maybe("  conversion", channels.conversion.as_ref().map(conversion).as_deref());
        self.maybe("  of temperatures", channels.temperature_conversion.as_ref().map(conversion).as_deref());
        let modes: Vec<_> = channels.modes.iter().map(|mode| mode.name.as_str()).collect();
        if !modes.is_empty() {
            self.row("  modes", &modes.join(", "));
        }
    }

    /// Where the module is if it is the only one.
    fn addresses(&mut self, module: &ModuleType) {
        if module.input_bytes() + module.output_bytes() == 0 {
            return;
        }
        self.0 += "\nAlone, with status bytes, it is at\n\n";
        for (controller, name) in CONTROLLERS {
            let Some(reference) = Reference::find(controller) else { continue };
            let known = module.profiles.iter().any(|profile| profile.accepts(reference));
            let found = reference.module_addresses(&[ConfiguredModule::new(module)]).ok().filter(|_| known);
            if let Some(addresses) = found.and_then(|found| found.into_iter().next()) {
                let _ = writeln!(self.0, "    {:26}{}", format!("on {name}"), places(&addresses));
            }
        }
    }

    /// The ends and limits of each mode.
    fn modes(&mut self, module: &ModuleType) {
        let modes: Vec<_> = every_mode(module).into_iter().filter(|mode| mode.low.is_some()).collect();
        if modes.is_empty() {
            return;
        }
        let _ = writeln!(
            self.0,
            "\n    {:24}{:>8}{:>8}{:>14}{:>12}",
            "mode", "from", "to", "under range", "over range"
        );
        for mode in modes {
            let figure =
                |number: Option<Decimal>| number.map_or_else(String::new, |number| number.to_string());
            let (low, high) = (figure(mode.low), figure(mode.high));
            let (under, over) = (figure(mode.under_range), figure(mode.over_range));
            let line = format!("    {:24}{low:>8}{high:>8}{under:>14}{over:>12}  {}", mode.name, mode.unit);
            let _ = writeln!(self.0, "{}", line.trim_end());
        }
    }

    /// The figures that no document of the controllers has, by source.
    fn sources(&mut self, module: &ModuleType) {
        let mut sources = Vec::new();
        add_figures(&mut sources, &module.sources, None);
        for mode in every_mode(module) {
            add_figures(&mut sources, &mode.sources, Some(&mode.name));
        }
        if sources.is_empty() {
            return;
        }
        self.0 += "\nNot in the documents of the controllers:\n";
        for source in &sources {
            let figures: Vec<String> = source.figures.iter().map(Figures::words).collect();
            self.0 += "\n";
            self.0 += &wrap(&format!("{}: {}", source.name, figures.join("; ")));
        }
    }
}

/// Figures of a module, or of some of its modes.
struct Figures<'a> {
    names: Vec<&'a str>,
    modes: Vec<&'a str>,
}

impl Figures<'_> {
    /// `low, high of PT100, PT1000`.
    fn words(&self) -> String {
        let figures = self.names.join(", ").replace(EVERYTHING, "everything");
        match self.modes.is_empty() {
            true => figures,
            false => format!("{figures} of {}", self.modes.join(", ")),
        }
    }
}

/// How a page names all figures of a module or mode.
const EVERYTHING: &str = "all";

/// A source with the figures that are from it.
struct FiguresFrom<'a> {
    name: &'a str,
    figures: Vec<Figures<'a>>,
}

/// Adds the figures of a module, or of one of its modes; modes with the same figures from one source stand together.
fn add_figures<'a>(sources: &mut Vec<FiguresFrom<'a>>, figures: &'a [FigureSource], mode: Option<&'a str>) {
    let mut own: Vec<(&str, Vec<&str>)> = Vec::new();
    for one in figures {
        match own.iter_mut().find(|(source, _)| *source == one.source) {
            Some((_, names)) => names.push(&one.figure),
            None => own.push((&one.source, vec![&one.figure])),
        }
    }
    for (name, names) in own {
        let known = match sources.iter_mut().position(|one| one.name == name) {
            Some(place) => &mut sources[place].figures,
            None => {
                sources.push(FiguresFrom { name, figures: Vec::new() });
                let Some(last) = sources.last_mut() else { continue };
                &mut last.figures
            }
        };
        // Of a module of which nothing is in the documents its modes need not be named.
        if known.iter().any(|one| one.modes.is_empty() && one.names == [EVERYTHING]) {
            continue;
        }
        match known.iter_mut().find(|one| one.names == names && one.modes.is_empty() == mode.is_none()) {
            Some(same) => same.modes.extend(mode),
            None => known.push(Figures { names, modes: mode.into_iter().collect() }),
        }
    }
}

/// The modes of inputs and outputs, each once.
fn every_mode(module: &ModuleType) -> Vec<&AnalogueMode> {
    let channels = [&module.analogue_inputs, &module.analogue_outputs].into_iter().flatten();
    let mut modes: Vec<&AnalogueMode> = Vec::new();
    for mode in channels.flat_map(|channels| &channels.modes) {
        if !modes.contains(&mode) {
            modes.push(mode);
        }
    }
    modes
}

/// The parts that are there, with commas.
fn joined(parts: impl IntoIterator<Item = Option<String>>) -> String {
    parts.into_iter().flatten().collect::<Vec<_>>().join(", ")
}

/// The delays of a digital channel.
fn delays(on: Option<Span>, off: Option<Span>) -> [Option<String>; 2] {
    [on.map(|delay| format!("on after {delay}")), off.map(|delay| format!("off after {delay}"))]
}

/// How long a conversion takes: `1 ms and 1 ms a channel`.
fn conversion(conversion: &Conversion) -> String {
    let fixed = (conversion.fixed != Span::ZERO).then(|| format!("{} and ", conversion.fixed));
    let per_channel: Vec<String> = conversion.per_channel.iter().map(Span::to_string).collect();
    format!("{}{} a channel", fixed.unwrap_or_default(), per_channel.join(" or "))
}

/// The addresses of a module in a line.
fn places(addresses: &ModuleAddresses) -> String {
    let shown = |channels: Option<ChannelAddresses>| channels.map(|channels| channels.to_string());
    joined([
        shown(addresses.digital_inputs),
        shown(addresses.analogue_inputs),
        shown(addresses.status).map(|status| format!("status {status}")),
        shown(addresses.digital_outputs),
        shown(addresses.analogue_outputs),
    ])
}
