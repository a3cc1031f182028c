//! `settings`: the configuration of the controller.

use document::{Fields, Findings, KeySpec, KeyType, Node, Table};
use profile::{Filter, Reference};
use signal::{Address, Area, Size, Span};

use super::signals::address;
use crate::codes;

const FILTER_EACH: KeyType = KeyType::Duration;

const TASK_KEYS: &[KeySpec] = &[
    KeySpec::optional("interval", KeyType::Duration, "From one start to the next."),
    KeySpec::optional("priority", KeyType::Integer(0, 31), "0, the highest, to 31."),
    KeySpec::optional("watchdog", KeyType::Duration, "The time of the task's watchdog."),
    KeySpec::optional("sensitivity", KeyType::Integer(0, 65_535), "Exceptions in a row that are an error."),
    KeySpec::optional("enabled", KeyType::Bool, "Whether the task's watchdog watches."),
    KeySpec::optional("programs", KeyType::List(&KeyType::Text), "The programs that it runs, in order."),
];
const TASK_TYPE: KeyType = KeyType::Table(TASK_KEYS);

/// The keys of `settings`.
pub(super) const SETTINGS_KEYS: &[KeySpec] = &[
    KeySpec::optional(
        "initial",
        KeyType::Choice(&["running", "stopped", "empty", "booting"]),
        "The controller's state at `start`; running if left out.",
    ),
    KeySpec::optional("reference", KeyType::Text, "The controller's reference, as in TM241CEC24T."),
    KeySpec::optional(
        "starting-mode",
        KeyType::Choice(&["previous", "stop", "run"]),
        "What the controller does at power-on.",
    ),
    KeySpec::optional(
        "outputs-in-stop",
        KeyType::Choice(&["keep", "default"]),
        "What outputs do in STOPPED.",
    ),
    KeySpec::optional(
        "update-io-in-stop",
        KeyType::Bool,
        "Whether inputs and outputs are updated in STOPPED.",
    ),
    KeySpec::optional(
        "filter",
        KeyType::Either(&[KeyType::Duration, KeyType::Map(&FILTER_EACH)]),
        "The filter of all inputs, or of each by its address: 0, 1, 4 or 12 ms.",
    ),
    KeySpec::optional(
        "output-defaults",
        KeyType::Map(&KeyType::Bool),
        "Default values by the outputs' addresses.",
    ),
    KeySpec::optional("mast", TASK_TYPE, "The task MAST."),
    KeySpec::optional("tasks", KeyType::Map(&TASK_TYPE), "Further tasks by their names."),
];

/// The controller's state at `start`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Initial {
    /// RUNNING, the default.
    #[default]
    Running,
    /// STOPPED.
    Stopped,
    /// EMPTY: without an application.
    Empty,
    /// Whatever the power-on leads to; `start` is the power-on itself.
    Booting,
}

/// What outputs do in STOPPED.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutputsInStop {
    /// Keep their values.
    Keep,
    /// Take their default values.
    Default,
}

/// What the controller does at power-on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StartingMode {
    /// Start as previous state.
    Previous,
    /// Start in stop.
    Stop,
    /// Start in run.
    Run,
}

/// The configuration that a plan asks for. What it leaves out is as the controller's documents have it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Settings {
    /// The controller's state at `start`.
    pub initial: Initial,
    /// The controller's reference; `None`: the board's.
    pub reference: Option<&'static Reference>,
    /// What the controller does at power-on.
    pub starting_mode: Option<StartingMode>,
    /// What outputs do in STOPPED.
    pub outputs_in_stop: Option<OutputsInStop>,
    /// Whether inputs and outputs are updated in STOPPED.
    pub update_io_in_stop: Option<bool>,
    /// The filter of all inputs that `filters` does not name.
    pub filter: Option<Filter>,
    /// The filters of single inputs.
    pub filters: Vec<(Address, Filter)>,
    /// Default values of outputs.
    pub output_defaults: Vec<(Address, bool)>,
    /// What is said of tasks; MAST first where it is named. MAST exists in any case.
    pub tasks: Vec<TaskSettings>,
}

/// What a plan says of a task.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TaskSettings {
    /// Its name.
    pub name: String,
    /// From one start to the next, above 0.
    pub interval: Option<Span>,
    /// 0 (highest) ..= 31.
    pub priority: Option<u8>,
    /// The time of its watchdog, above 0.
    pub watchdog: Option<Span>,
    /// Exceptions in a row that are an error; 0 counts as 1.
    pub sensitivity: Option<u32>,
    /// Whether its watchdog watches.
    pub enabled: Option<bool>,
    /// The programs that it runs, in order; `None`: for MAST, those that no other task names.
    pub programs: Option<Vec<String>>,
}

/// Reads settings that were held against their keys.
pub(super) fn read(fields: &Fields<'_>, out: &mut Findings) -> Settings {
    let mut settings = Settings {
        initial: match fields.text("initial") {
            Some("stopped") => Initial::Stopped,
            Some("empty") => Initial::Empty,
            Some("booting") => Initial::Booting,
            _ => Initial::Running,
        },
        starting_mode: fields.text("starting-mode").map(|mode| match mode {
            "previous" => StartingMode::Previous,
            "stop" => StartingMode::Stop,
            _ => StartingMode::Run,
        }),
        outputs_in_stop: fields.text("outputs-in-stop").map(|behaviour| match behaviour {
            "keep" => OutputsInStop::Keep,
            _ => OutputsInStop::Default,
        }),
        update_io_in_stop: fields.boolean("update-io-in-stop"),
        ..Settings::default()
    };
    if let Some(node) = fields.get("reference") {
        settings.reference = node.as_text().and_then(Reference::find);
        if settings.reference.is_none() {
            let message = format!("there is no reference `{}`", node.as_text().unwrap_or_default());
            out.bad(codes::PROFILE, node, message, "as in TM241CEC24T or TM251MESC");
        }
    }
    filters(fields, &mut settings, out);
    defaults(fields, &mut settings, out);
    if let Some(mast) = fields.get("mast").and_then(Node::as_table) {
        settings.tasks.push(task("MAST", mast, out));
    }
    if let Some(tasks) = fields.get("tasks").and_then(Node::as_table) {
        // The largest controller has far fewer; see the profile's limits, which the controller itself checks.
        if let Some(entry) = tasks.entries.get(64) {
            out.error(
                codes::SETTING,
                entry.key_span.clone(),
                "more than 64 tasks",
                "no controller has so many",
            );
        }
        for entry in tasks.entries.iter().take(64) {
            if settings.tasks.iter().any(|known| known.name.eq_ignore_ascii_case(&entry.key)) {
                let message = format!("the task `{}` is given twice", entry.key);
                out.error(
                    codes::NAME_TWICE,
                    entry.key_span.clone(),
                    message,
                    "names differ not only in capitals",
                );
                continue;
            }
            if let Some(table) = entry.node.as_table() {
                settings.tasks.push(task(&entry.key, table, out));
            }
        }
    }
    settings
}

fn filters(fields: &Fields<'_>, settings: &mut Settings, out: &mut Findings) {
    let Some(node) = fields.get("filter") else { return };
    let Some(table) = node.as_table() else {
        settings.filter = filter(node, out);
        return;
    };
    for entry in &table.entries {
        let filter = filter(&entry.node, out);
        let address = terminal(entry, Area::Input, out);
        if let (Some(address), Some(filter)) = (address, filter) {
            settings.filters.push((address, filter));
        }
    }
}

fn filter(node: &Node, out: &mut Findings) -> Option<Filter> {
    let span = Span::parse(node.as_text()?).ok()?;
    let filter = Filter::from_span(span);
    if filter.is_none() {
        let help = "a filter has 0 ms, 1 ms, 4 ms or 12 ms (io:STD-IN-01)";
        out.bad(codes::SETTING, node, format!("no input has a filter of {span}"), help);
    }
    filter
}

fn defaults(fields: &Fields<'_>, settings: &mut Settings, out: &mut Findings) {
    let Some(table) = fields.get("output-defaults").and_then(Node::as_table) else { return };
    for entry in &table.entries {
        let document::Data::Bool(on) = entry.node.data else { continue };
        if let Some(address) = terminal(entry, Area::Output, out) {
            settings.output_defaults.push((address, on));
        }
    }
}

/// The key as the address of an input or output.
fn terminal(entry: &document::Entry, area: Area, out: &mut Findings) -> Option<Address> {
    let key = Node::new(entry.key_span.clone(), document::Data::Text(entry.key.clone()));
    let address = address(&key, &entry.key, out)?;
    if address.area() != area || address.size() != Size::Bit {
        let example =
            if area == Area::Input { "an input such as \"%IX0.0\"" } else { "an output such as \"%QX0.4\"" };
        out.bad(codes::ADDRESS, &key, format!("`{}` is not {example}", entry.key), "");
        return None;
    }
    Some(address)
}

fn task(name: &str, table: &Table, out: &mut Findings) -> TaskSettings {
    let fields = Fields::checked(table, TASK_KEYS);
    for key in ["interval", "watchdog"] {
        if let (Some(Span::ZERO), Some(node)) = (fields.duration(key), fields.get(key)) {
            let help = if key == "watchdog" { "write `enabled = false` to switch it off" } else { "" };
            out.bad(codes::SETTING, node, format!("`{key}` is 0"), help);
        }
    }
    let narrow = |key: &str| fields.integer(key).and_then(|number| u32::try_from(number).ok());
    TaskSettings {
        name: name.to_owned(),
        interval: fields.duration("interval"),
        priority: narrow("priority").and_then(|priority| u8::try_from(priority).ok()),
        watchdog: fields.duration("watchdog"),
        sensitivity: narrow("sensitivity"),
        enabled: fields.boolean("enabled"),
        programs: fields
            .get("programs")
            .and_then(Node::as_array)
            .map(|list| list.iter().filter_map(Node::as_text).map(str::to_owned).collect()),
    }
}
