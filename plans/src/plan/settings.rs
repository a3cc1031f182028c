//! `settings`: the configuration of the controller.

use std::ops::Range;

use document::{Fields, Findings, KeySpec, KeyType, Node, Table};
use profile::{InputFilter, Reference};
use signal::{Address, Area, Span};

use super::functions::{self, FunctionSettings};
use super::inputs::{self, InputSettings};
use super::modules::{self, ModuleSettings};
use crate::codes;
use crate::lang::terminal;

const TASK_KEYS: &[KeySpec] = &[
    KeySpec::optional(
        "type",
        KeyType::Choice(&["cyclic", "freewheeling", "event", "external-event"]),
        "What starts its cycles; what the other keys say if left out, else cyclic.",
    ),
    KeySpec::optional("trigger", KeyType::Text, "The Boolean variable that starts an event task."),
    KeySpec::optional("event", KeyType::Text, "What starts an external event task: an input, or a name."),
    KeySpec::optional("interval", KeyType::Duration, "From one start to the next."),
    KeySpec::optional("priority", KeyType::Integer(0, 31), "0, the highest, to 31."),
    KeySpec::optional("watchdog", KeyType::Duration, "The time of the task's watchdog."),
    KeySpec::optional("sensitivity", KeyType::Integer(0, 65_535), "Exceptions in a row that are an error."),
    KeySpec::optional("enabled", KeyType::Bool, "Whether the task's watchdog watches."),
    KeySpec::optional("programs", KeyType::List(&KeyType::Text), "The programs that it runs, in order."),
];
const RELOCATION_KEYS: &[KeySpec] = &[
    KeySpec::optional("read", KeyType::List(&KeyType::Text), "What stands from %MW60200 on, in order."),
    KeySpec::optional("write", KeyType::List(&KeyType::Text), "What stands from %MW62200 on, in order."),
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
        "firmware",
        KeyType::Choice(&["valid", "invalid"]),
        "The controller's firmware; valid if left out.",
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
        inputs::FILTER_TYPE,
        "The filter of all inputs, or of each by its address: 0, 1, 4 or 12 ms.",
    ),
    KeySpec::optional("inputs", inputs::INPUTS_TYPE, "Parameters of single inputs by their addresses."),
    KeySpec::optional("run-stop-input", KeyType::Text, "The input that runs and stops the controller."),
    KeySpec::optional(
        "switch",
        KeyType::Choice(&["run", "stop"]),
        "Where the Run/Stop switch stands at power-on.",
    ),
    KeySpec::optional(
        "output-defaults",
        KeyType::Map(&KeyType::Bool),
        "Default values by the outputs' addresses.",
    ),
    KeySpec::optional(
        "halt-outputs",
        KeyType::Choice(&["configured", "default"]),
        "What outputs do in HALT: the same as in STOPPED, or always their defaults.",
    ),
    KeySpec::optional(
        "alarm-output",
        KeyType::Text,
        "The output that shows that the application is running.",
    ),
    KeySpec::optional(
        "rearming",
        KeyType::Choice(&["automatic", "manual"]),
        "How outputs come back after a fault: by themselves, or on the rearming command.",
    ),
    KeySpec::optional(
        "minimize-jitter",
        KeyType::Bool,
        "Whether outputs are written where the next bus cycle reads its inputs.",
    ),
    KeySpec::optional(
        "can-sync",
        KeyType::Bool,
        "Whether the CANopen manager produces or consumes SYNC; FALSE if left out.",
    ),
    KeySpec::optional(
        "clock-drift",
        KeyType::Integer(-13, 13),
        "By how many seconds a week the real-time clock is fast, or slow below 0; 0 if left out.",
    ),
    KeySpec::optional("login", KeyType::Bool, "Whether a programming tool is connected; TRUE if left out."),
    KeySpec::optional(
        "watchdog-basis",
        KeyType::Choice(&["elapsed", "processor"]),
        "What the time of a task's watchdog measures: elapsed time if left out.",
    ),
    KeySpec::optional(
        "bus-cycle-task",
        KeyType::Text,
        "The task that exchanges what no task uses; MAST if left out, `<unspecified>` for the slowest.",
    ),
    KeySpec::optional(
        "io-bus-task",
        KeyType::Choice(&["parent", "mast"]),
        "The task that exchanges with expansion modules: the bus cycle task if left out, or MAST.",
    ),
    KeySpec::optional(
        "always-update",
        KeyType::Choice(&["disabled", "enabled-1", "enabled-2"]),
        "Always update variables: what the bus cycle task exchanges.",
    ),
    KeySpec::optional("mast", TASK_TYPE, "The task MAST."),
    KeySpec::optional("relocation", KeyType::Table(RELOCATION_KEYS), "The relocation table."),
    KeySpec::optional(
        "expert",
        functions::EXPERT_TYPE,
        "Fast counters and pulse generators by their names, in order.",
    ),
    KeySpec::optional("modules", modules::MODULES_TYPE, "Expansion modules, from the controller on."),
    KeySpec::optional("tasks", KeyType::Map(&TASK_TYPE), "Further tasks by their names."),
];

/// The controller's state at `start`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum InitialState {
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

/// What outputs do in HALT.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HaltOutputs {
    /// The same as in STOPPED.
    Configured,
    /// Always their default values.
    Default,
}

/// How outputs come back after a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rearming {
    /// By themselves.
    Automatic,
    /// On the rearming command.
    Manual,
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

/// What starts the cycles of a task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TaskType {
    /// An interval.
    Cyclic,
    /// The end of the pause after the cycle before.
    Freewheeling,
    /// A Boolean variable.
    Event,
    /// An event of the hardware.
    ExternalEvent,
}

/// What the time of a task's watchdog measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WatchdogBasis {
    /// From the start of a cycle to its end.
    Elapsed,
    /// The processor time of the task alone.
    Processor,
}

/// What the bus cycle task exchanges besides what its own programs use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AlwaysUpdate {
    /// Nothing.
    Disabled,
    /// What no task uses.
    Enabled1,
    /// Everything.
    Enabled2,
}

/// The configuration that a plan asks for. What it leaves out is as the controller's documents have it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlanSettings {
    /// The controller's state at `start`.
    pub initial: InitialState,
    /// The controller's reference; `None`: the board's.
    pub reference: Option<&'static Reference>,
    /// What the controller does at power-on.
    pub starting_mode: Option<StartingMode>,
    /// The firmware is damaged from the start.
    pub firmware_invalid: bool,
    /// What outputs do in STOPPED.
    pub outputs_in_stop: Option<OutputsInStop>,
    /// Whether inputs and outputs are updated in STOPPED.
    pub update_io_in_stop: Option<bool>,
    /// The filter of all inputs that `filters` does not name.
    pub filter: Option<InputFilter>,
    /// The filters of single inputs.
    pub filters: Vec<(Address, InputFilter)>,
    /// What is said of single inputs.
    pub inputs: Vec<InputSettings>,
    /// The Run/Stop input, with its bytes of the plan.
    pub run_stop_input: Option<(Address, Range<usize>)>,
    /// Whether the Run/Stop switch stands at Run at power-on.
    pub switch_at_run: Option<bool>,
    /// Default values of outputs.
    pub output_defaults: Vec<(Address, bool)>,
    /// What outputs do in HALT.
    pub halt_outputs: Option<HaltOutputs>,
    /// The output that shows that the application is running.
    pub alarm_output: Option<Address>,
    /// How outputs come back after a fault.
    pub rearming: Option<Rearming>,
    /// Whether outputs are written where the next bus cycle reads its inputs.
    pub minimize_jitter: Option<bool>,
    /// Whether the CANopen manager produces or consumes SYNC.
    pub can_sync: Option<bool>,
    /// By so many seconds a week the real-time clock is fast (controller:HW-10: less than 60 s in 30 days).
    pub clock_drift: Option<i64>,
    /// Whether a programming tool is connected.
    pub login: Option<bool>,
    /// What the time of a task's watchdog measures.
    pub watchdog_basis: Option<WatchdogBasis>,
    /// The bus cycle task: the name of a task, or `<unspecified>`.
    pub bus_cycle_task: Option<String>,
    /// MAST exchanges with expansion modules, whatever the bus cycle task.
    pub io_bus_mast: Option<bool>,
    /// What the bus cycle task exchanges.
    pub always_update: Option<AlwaysUpdate>,
    /// What is said of tasks; MAST first where it is named. MAST exists in any case.
    pub tasks: Vec<TaskSettings>,
    /// The read part and the write part of the relocation table: names or full paths.
    pub relocation: [Vec<String>; 2],
    /// Fast counters and pulse generators.
    pub expert: Vec<FunctionSettings>,
    /// Expansion modules, in the order of the device tree.
    pub modules: Vec<ModuleSettings>,
}

/// What a plan says of a task.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TaskSettings {
    /// Its name.
    pub name: String,
    /// What starts its cycles, as written or as its other keys say.
    pub kind: Option<TaskType>,
    /// The variable that starts an event task.
    pub trigger: Option<String>,
    /// What starts an external event task.
    pub event: Option<String>,
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
    /// The programs that it runs, in order; `None`: those that no other task names.
    pub programs: Option<Vec<String>>,
}

/// Reads settings that were held against their keys.
pub(super) fn read(fields: &Fields<'_>, out: &mut Findings) -> PlanSettings {
    let mut settings = PlanSettings {
        firmware_invalid: fields.text("firmware") == Some("invalid"),
        initial: match fields.text("initial") {
            Some("stopped") => InitialState::Stopped,
            Some("empty") => InitialState::Empty,
            Some("booting") => InitialState::Booting,
            _ => InitialState::Running,
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
        halt_outputs: fields.text("halt-outputs").map(|behaviour| match behaviour {
            "configured" => HaltOutputs::Configured,
            _ => HaltOutputs::Default,
        }),
        alarm_output: fields
            .get("alarm-output")
            .and_then(|node| terminal(node, node.as_text()?, Area::Output, out)),
        rearming: fields.text("rearming").map(|mode| match mode {
            "automatic" => Rearming::Automatic,
            _ => Rearming::Manual,
        }),
        minimize_jitter: fields.boolean("minimize-jitter"),
        can_sync: fields.boolean("can-sync"),
        clock_drift: fields.integer("clock-drift"),
        login: fields.boolean("login"),
        watchdog_basis: fields.text("watchdog-basis").map(|basis| match basis {
            "processor" => WatchdogBasis::Processor,
            _ => WatchdogBasis::Elapsed,
        }),
        bus_cycle_task: fields.text("bus-cycle-task").map(str::to_owned),
        io_bus_mast: fields.text("io-bus-task").map(|task| task == "mast"),
        always_update: fields.text("always-update").map(|update| match update {
            "enabled-1" => AlwaysUpdate::Enabled1,
            "enabled-2" => AlwaysUpdate::Enabled2,
            _ => AlwaysUpdate::Disabled,
        }),
        ..PlanSettings::default()
    };
    if let Some(node) = fields.get("reference") {
        settings.reference = node.as_text().and_then(Reference::find);
        if settings.reference.is_none() {
            let message = format!("there is no reference `{}`", node.as_text().unwrap_or_default());
            out.bad(codes::PROFILE, node, message, "as in TM241CEC24T or TM251MESC");
        }
    }
    relocation(fields, &mut settings, out);
    settings.expert = functions::read(fields, out);
    settings.modules = modules::read(fields, out);
    inputs::read(fields, &mut settings, out);
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

/// The rows of the relocation table; a row without a variable is left out (controller:REL-06).
fn relocation(fields: &Fields<'_>, settings: &mut PlanSettings, out: &mut Findings) {
    // More than its registers can never fit.
    const MOST: usize = 2_000;
    let Some(table) = fields.get("relocation").and_then(Node::as_table) else { return };
    let table = Fields::checked(table, RELOCATION_KEYS);
    for (part, rows) in ["read", "write"].into_iter().zip(&mut settings.relocation) {
        let list = table.each(part);
        if let Some(node) = list.get(MOST) {
            let message = format!("more than {MOST} rows");
            out.bad(codes::SETTING, node, message, "each part has 1800 words");
        }
        let names = list.iter().take(MOST).filter_map(Node::as_text).map(str::trim);
        *rows = names.filter(|name| !name.is_empty()).map(str::to_owned).collect();
    }
}

fn defaults(fields: &Fields<'_>, settings: &mut PlanSettings, out: &mut Findings) {
    let Some(table) = fields.get("output-defaults").and_then(Node::as_table) else { return };
    for entry in &table.entries {
        let document::Data::Bool(on) = entry.node.data else { continue };
        if let Some(address) = inputs::key(entry, Area::Output, out) {
            settings.output_defaults.push((address, on));
        }
    }
}

fn task(name: &str, table: &Table, out: &mut Findings) -> TaskSettings {
    let fields = Fields::checked(table, TASK_KEYS);
    for key in ["interval", "watchdog"] {
        if let (Some(Span::ZERO), Some(node)) = (fields.duration(key), fields.get(key)) {
            let help = if key == "watchdog" {
                "write `enabled = false` to switch it off"
            } else {
                "write it as in interval = \"10 ms\""
            };
            out.bad(codes::SETTING, node, format!("`{key}` is 0"), help);
        }
    }
    let kind = match fields.text("type") {
        Some("freewheeling") => Some(TaskType::Freewheeling),
        Some("event") => Some(TaskType::Event),
        Some("external-event") => Some(TaskType::ExternalEvent),
        Some(_) => Some(TaskType::Cyclic),
        None if fields.get("trigger").is_some() => Some(TaskType::Event),
        None if fields.get("event").is_some() => Some(TaskType::ExternalEvent),
        None if fields.get("interval").is_some() => Some(TaskType::Cyclic),
        None => None,
    };
    for (key, of) in
        [("interval", TaskType::Cyclic), ("trigger", TaskType::Event), ("event", TaskType::ExternalEvent)]
    {
        if let Some(node) = fields.get(key).filter(|_| kind != Some(of)) {
            let help = "a cyclic task has an `interval`, an event task a `trigger`, an external event task an `event`";
            out.bad(codes::SETTING, node, format!("`{key}` is for a task of another type"), help);
        }
    }
    let narrow = |key: &str| fields.integer(key).and_then(|number| u32::try_from(number).ok());
    TaskSettings {
        name: name.to_owned(),
        kind,
        trigger: fields.text("trigger").map(str::to_owned),
        event: fields.text("event").map(str::to_owned),
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
