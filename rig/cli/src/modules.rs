//! `rig modules`: where the inputs and outputs of a plan's controller and modules are.

use crate::exit::ExitStatus;
use crate::output::{self, OutputFormat};
use crate::plan_files::load::{LoadRequest, load};
use clap::Args;
use document::Diagnostic;
use profile::{
    AnalogueInputSettings, AnalogueMode, ChannelAddresses, ConfiguredModule, CountRange, IoChannel,
    LOCAL_MODULES, ModuleAddresses, REMOTE_MODULES, Reference, TemperatureScope, module_indices,
    rearming_command, short_circuit_status,
};
use runtime::application::modules;
use runtime::suite::LoadedPlan;
use serde_json::{Value as Json, json};
use signal::{Address, Area};
use std::path::PathBuf;

/// `rig modules`.
#[derive(Debug, Args)]
pub struct ModulesArgs {
    /// Plans, or folders that are searched for plans.
    #[arg(value_name = "PLAN|DIR", required = true)]
    plans: Vec<PathBuf>,
    /// The board file to use in place of each plan's own.
    #[arg(long, value_name = "FILE")]
    board: Option<PathBuf>,
    /// Give a plan's parameter a value.
    #[arg(long = "param", value_name = "K=V")]
    params: Vec<String>,
    /// How to print.
    #[arg(long, value_enum, default_value_t)]
    format: OutputFormat,
}

/// Prints the table of each list of modules that the cases of the plans have.
pub fn run(args: &ModulesArgs) -> ExitStatus {
    let request =
        LoadRequest { plans: &args.plans, board: args.board.as_deref(), params: &args.params, seed: 1 };
    let mut sources = Vec::new();
    let loaded = match load(&request, &mut sources) {
        Ok(loaded) => loaded,
        Err(exit) => return exit,
    };
    let (mut tables, mut wrong): (Vec<ModuleTable>, Vec<Diagnostic>) = Default::default();
    for plan in &loaded {
        tables_of(plan, &mut tables, &mut wrong);
    }
    match args.format {
        OutputFormat::Table => tables.iter().for_each(|table| output::print(&table.text())),
        OutputFormat::Json => {
            let all: Vec<Json> = tables.iter().map(ModuleTable::json).collect();
            output::print(&format!("{}\n", serde_json::to_string_pretty(&all).unwrap_or_default()));
        }
    }
    output::new_findings(&wrong, &mut Vec::new(), &sources);
    if wrong.is_empty() { ExitStatus::Passed } else { ExitStatus::UserFiles }
}

/// Adds the tables of a plan, each once.
fn tables_of(plan: &LoadedPlan, tables: &mut Vec<ModuleTable>, wrong: &mut Vec<Diagnostic>) {
    let first = tables.len();
    for job in plan.jobs(0, 1, 1) {
        let Some(case) = plan.plan.case(job.case) else { continue };
        let files = match plan.files(&case, &job) {
            Ok(files) => files,
            Err(found) => {
                add_new(wrong, found);
                continue;
            }
        };
        // A real controller has modules of its own; a case of another profile never runs.
        if files.board.subject.is_external() || !files.profile.accepts(files.reference) {
            continue;
        }
        let settings = &case.settings.modules;
        match modules::configure(settings, files.profile, files.reference, &files.plan.name) {
            Ok(configured) => {
                let (rows, fitted) = (rows(files.reference, &configured), Fitted::of(&configured));
                let same = |table: &&mut ModuleTable| {
                    table.reference == files.reference.name && table.rows == rows && table.fitted == fitted
                };
                match tables[first..].iter_mut().find(same) {
                    Some(table) => table.cases.push(case.name.clone()),
                    None => tables.push(ModuleTable {
                        plan: plan.plan.path.clone(),
                        cases: vec![case.name.clone()],
                        reference: files.reference.name,
                        fitted,
                        rows,
                    }),
                }
            }
            // A plan may be about a list that is refused.
            Err(_) if case.refusal.is_some() => {}
            Err(found) => add_new(wrong, found),
        }
    }
}

fn add_new(known: &mut Vec<Diagnostic>, found: Vec<Diagnostic>) {
    for one in found {
        if !known.contains(&one) {
            known.push(one);
        }
    }
}

/// How many modules are on the bus, before and after the link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Fitted {
    local: usize,
    remote: usize,
}

impl Fitted {
    fn of(configured: &[ConfiguredModule<'_>]) -> Fitted {
        let indices: Vec<usize> = module_indices(configured).into_iter().flatten().collect();
        let local = indices.iter().filter(|index| **index < LOCAL_MODULES).count();
        Fitted { local, remote: indices.len() - local }
    }
}

/// A controller with its modules, and the cases that have it.
#[derive(Debug)]
struct ModuleTable {
    plan: String,
    cases: Vec<String>,
    reference: &'static str,
    fitted: Fitted,
    rows: Vec<ModuleRow>,
}

/// Channels that stand together, or one analogue channel.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct ModuleRow {
    /// `M1.IW0`, or the first and the last of several.
    terminal: String,
    /// The reference of the module; what it is for where it is the controller's own.
    module: String,
    /// The index of `TM3_MODULE_R`.
    index: Option<usize>,
    /// The address, or the first and the last.
    address: String,
    /// The status byte.
    status: String,
    /// The mode of an analogue channel.
    mode: String,
    /// What its channel of the board carries.
    unit: String,
    /// Its words at the ends of the mode, or what they count.
    words: String,
}

/// The heads of the columns.
const HEADS: [&str; 8] = ["terminal", "module", "index", "address", "status", "mode", "unit", "words"];

impl ModuleRow {
    fn cells(&self) -> [String; 8] {
        let index = self.index.map_or_else(String::new, |index| index.to_string());
        let ModuleRow { terminal, module, address, status, mode, unit, words, .. } = self.clone();
        [terminal, module, index, address, status, mode, unit, words]
    }
}

impl ModuleTable {
    /// As a person reads it.
    fn text(&self) -> String {
        let lines: Vec<[String; 8]> = self.rows.iter().map(ModuleRow::cells).collect();
        let widths: Vec<usize> = (0..HEADS.len())
            .map(|column| {
                let widest = lines.iter().map(|line| line[column].chars().count()).max().unwrap_or(0);
                if widest == 0 { 0 } else { widest.max(HEADS[column].len()) }
            })
            .collect();
        let heads = HEADS.map(String::from);
        let mut text = format!("{}\n\n", self.title());
        for line in std::iter::once(&heads).chain(&lines) {
            let shown = line.iter().zip(&widths).filter(|(_, width)| **width > 0);
            let cells: Vec<String> = shown.map(|(cell, width)| format!("{cell:width$}")).collect();
            text += cells.join("  ").trim_end();
            text += "\n";
        }
        text + "\n"
    }

    /// `valve.toml: TM241CEC24T, 2 of 7 local modules`, and of which cases.
    fn title(&self) -> String {
        let Fitted { local, remote } = self.fitted;
        let mut title =
            format!("{}: {}, {local} of {LOCAL_MODULES} local modules", self.plan, self.reference);
        if remote > 0 {
            title += &format!(", {remote} of {REMOTE_MODULES} remote ones");
        }
        match self.cases.as_slice() {
            [] => {}
            [case] => title += &format!(" ({case})"),
            [case, others @ ..] => title += &format!(" ({case} and {} more)", others.len()),
        }
        title
    }

    /// As a program reads it.
    fn json(&self) -> Json {
        let rows = self.rows.iter().map(|row| {
            let filled = HEADS.iter().zip(row.cells()).filter(|(_, cell)| !cell.is_empty());
            let mut object: serde_json::Map<String, Json> =
                filled.map(|(head, cell)| ((*head).to_owned(), Json::String(cell))).collect();
            if let Some(index) = row.index {
                object.insert("index".into(), json!(index));
            }
            Json::Object(object)
        });
        json!({
            "plan": self.plan,
            "cases": self.cases,
            "reference": self.reference,
            "local": self.fitted.local,
            "remote": self.fitted.remote,
            "terminals": rows.collect::<Vec<_>>(),
        })
    }
}

/// What a controller has in its images, the embedded channels first.
fn rows(reference: &Reference, configured: &[ConfiguredModule<'static>]) -> Vec<ModuleRow> {
    let mut rows = embedded(reference);
    let places = reference.module_addresses(configured).unwrap_or_default();
    for ((number, module), (places, index)) in
        (1..).zip(configured).zip(places.iter().zip(module_indices(configured)))
    {
        rows.extend(of_module(number, module, places, index));
    }
    rows
}

fn embedded(reference: &Reference) -> Vec<ModuleRow> {
    let group = |area, count: usize, channel: fn(usize) -> IoChannel| {
        let last = count.checked_sub(1)?;
        let place = |channel: usize| Address::bit(area, channel as u32);
        Some(ModuleRow {
            terminal: format!("{} to {}", channel(0), channel(last)),
            module: "embedded".into(),
            address: format!("{}..{}", place(0), place(last)),
            ..ModuleRow::default()
        })
    };
    let special = |place: Option<(u32, u32)>, area, what: &str| {
        let (byte, bit) = place?;
        let address = Address::bit(area, byte * 8 + bit).to_string();
        Some(ModuleRow { terminal: what.into(), module: "embedded".into(), address, ..ModuleRow::default() })
    };
    [
        group(Area::Input, reference.input_count(), IoChannel::Input),
        special(short_circuit_status(reference), Area::Input, "status of outputs"),
        group(Area::Output, reference.output_count(), IoChannel::Output),
        special(rearming_command(reference), Area::Output, "rearming"),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn of_module(
    number: usize,
    configured: &ConfiguredModule<'_>,
    places: &ModuleAddresses,
    index: Option<usize>,
) -> Vec<ModuleRow> {
    let module = configured.module;
    let row = || ModuleRow { module: module.reference.clone(), index, ..ModuleRow::default() };
    let digital = |letter: &str, channels: Option<ChannelAddresses>| {
        let channels = channels?;
        let last = channels.count().checked_sub(1)?;
        let terminal = match last {
            0 => format!("M{number}.{letter}0"),
            last => format!("M{number}.{letter}0 to M{number}.{letter}{last}"),
        };
        Some(ModuleRow { terminal, address: channels.to_string(), ..row() })
    };
    let status = |channel: u32| {
        let byte = places.status.and_then(|status| status.get(channel));
        byte.map_or_else(String::new, |byte| byte.to_string())
    };
    let word = |channels: Option<ChannelAddresses>, channel: u32| {
        channels.and_then(|channels| channels.get(channel)).map_or_else(String::new, |at| at.to_string())
    };
    let mut rows: Vec<ModuleRow> = digital("I", places.digital_inputs).into_iter().collect();
    rows.extend(digital("Q", places.digital_outputs));
    for input in 0..module.analogue_input_count() {
        let used = configured.input(input as usize).map(|it| (it.mode, input_words(it)));
        let (terminal, address) = (format!("M{number}.IW{input}"), word(places.analogue_inputs, input));
        rows.push(analogue(ModuleRow { terminal, address, status: status(input), ..row() }, used));
    }
    for output in 0..module.analogue_output_count() {
        let used = configured.output(output as usize).map(|it| (it.mode, ends(it.counts)));
        let (terminal, address) = (format!("M{number}.QW{output}"), word(places.analogue_outputs, output));
        let status = status(module.analogue_input_count() + output);
        rows.push(analogue(ModuleRow { terminal, address, status, ..row() }, used));
    }
    if rows.is_empty() {
        rows.push(ModuleRow { terminal: format!("M{number}"), ..row() });
    }
    rows
}

/// The row of an analogue channel with its mode and words; none where it is not used.
fn analogue(row: ModuleRow, used: Option<(&AnalogueMode, String)>) -> ModuleRow {
    match used {
        None => ModuleRow { mode: "not used".into(), ..row },
        Some((mode, words)) => {
            ModuleRow { mode: mode.name.clone(), unit: mode.unit.to_string(), words, ..row }
        }
    }
}

/// What the words of an input are.
fn input_words(input: &AnalogueInputSettings<'_>) -> String {
    let mode = input.mode;
    if mode.step.is_none() && mode.low.is_some() {
        return ends(input.counts);
    }
    let step = mode.step.map_or_else(|| String::from("0.1"), |step| step.to_string());
    match input.scope {
        TemperatureScope::Fahrenheit => String::from("steps of 0.1 degF"),
        TemperatureScope::Celsius => format!("steps of {step} {}", mode.unit),
    }
}

fn ends(counts: CountRange) -> String {
    format!("{} to {}", counts.minimum(), counts.maximum())
}
