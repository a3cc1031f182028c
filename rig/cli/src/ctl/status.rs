//! `rig ctl state`, `status` and `describe`.

use super::CtlError;
use super::show::{self, columns, percent, seconds, span};
use crate::exit::ExitStatus;
use crate::output;
use clap::Args;
use control::{
    ControlClient, Description, LedStatus, RequestOperation, Status, SubjectKind, TaskInfo, TaskStatus,
    TimeSource,
};

/// `rig ctl status` and `rig ctl describe`.
#[derive(Debug, Args)]
pub struct StatusArgs {
    /// Print JSON for a program, as the rig sends it.
    #[arg(long)]
    json: bool,
}

/// Prints the state.
pub fn state(client: &mut ControlClient) -> Result<ExitStatus, CtlError> {
    let status: Status = client.ask(RequestOperation::Status)?;
    output::print(&format!("{}\n", status.state));
    Ok(ExitStatus::Passed)
}

/// Prints how the rig is.
pub fn status(client: &mut ControlClient, args: &StatusArgs) -> Result<ExitStatus, CtlError> {
    if args.json {
        show::json(&client.ask(RequestOperation::Status)?);
        return Ok(ExitStatus::Passed);
    }
    let described: Description = client.ask(RequestOperation::Describe)?;
    let status: Status = client.ask(RequestOperation::Status)?;
    output::print(&columns(&facts(&described, &status)));
    if !described.modules.is_empty() {
        output::print(&format!("\n{}", columns(&modules(&described, &status))));
    }
    if !described.tasks.is_empty() {
        output::print(&format!("\n{}", columns(&tasks(&described.tasks, &status.tasks))));
    }
    Ok(ExitStatus::Passed)
}

/// Facts, a row each.
fn facts(described: &Description, status: &Status) -> Vec<Vec<String>> {
    let mut rows = Vec::new();
    let mut row = |name: &str, text: String| rows.push(vec![name.to_owned(), text]);
    for trouble in &status.troubles {
        row("!!", format!("{}: {}", trouble.kind, trouble.text));
    }
    let switch = if status.switch { "Run" } else { "Stop" };
    let power = if status.power { "" } else { ", no supply" };
    row("state", format!("{}, switch at {switch}{power}", status.state));
    row("rig", format!("{} on {}, {}", described.reference, described.board, clock(described.clock)));
    row("time", seconds(status.at));
    row("indicators", status.leds.iter().map(led).collect::<Vec<_>>().join(", "));
    row("load", format!("{} of at most {}", percent(status.load), percent(described.load_limit)));
    for forced in &status.forced {
        let by = forced.by.as_ref().map(|by| format!(" by {by}")).unwrap_or_default();
        row("forced", format!("{} = {}{by}", forced.address, forced.value.0));
    }
    if let Some(locked) = &status.locked {
        let note = if locked.note.is_empty() { String::new() } else { format!(": {}", locked.note) };
        row("locked", format!("by {}{note}", locked.by));
    }
    if let Some(plan) = &status.plan {
        row("plan", format!("{}, case {} of {}: {}", plan.name, plan.place.0, plan.place.1, plan.case));
    }
    for (device, known) in status.devices.iter().zip(&described.devices).filter(|(device, _)| !device.sound) {
        row("lost", format!("{}: {}", known.name, device.why));
    }
    for (bus, known) in status.buses.iter().zip(&described.buses) {
        let (got, sent) = (bus.received, bus.sent);
        let bad = if bus.errors + bus.dropped == 0 {
            String::new()
        } else {
            format!(", {} errors, {} missed", bus.errors, bus.dropped)
        };
        row("bus", format!("{}: {}, {got} received, {sent} sent{bad}", known.name, bus.state));
    }
    if described.clock == TimeSource::Real {
        // Modelled lines do not say when they changed.
        let outputs = match status.rig.late_outputs {
            0 => String::new(),
            late => format!(", outputs {}", span(late)),
        };
        row("late", format!("{} at worst{outputs}", span(status.rig.late_max)));
    }
    row("clients", status.clients.to_string());
    rows
}

fn led(led: &LedStatus) -> String {
    format!("{} {}", led.name, led.pattern)
}

const fn clock(clock: TimeSource) -> &'static str {
    match clock {
        TimeSource::Real => "on the host's clock",
        TimeSource::Stepped => "stepped by its clients",
    }
}

/// The expansion modules, a row each.
fn modules(described: &Description, status: &Status) -> Vec<Vec<String>> {
    let mut rows = vec![["module", "index", "state"].map(str::to_owned).to_vec()];
    for (module, state) in described.modules.iter().zip(&status.modules) {
        let optional = if module.optional { ", optional" } else { "" };
        rows.push(vec![format!("{}{optional}", module.reference), module.index.to_string(), state.clone()]);
    }
    rows
}

/// Figures of the tasks, a row each.
fn tasks(known: &[TaskInfo], now: &[TaskStatus]) -> Vec<Vec<String>> {
    let head = ["task", "cycles", "last", "least", "mean", "most", "jitter", "load", "overruns", "lost"];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    for (task, now) in known.iter().zip(now) {
        rows.push(vec![
            task.name.clone(),
            now.cycles.to_string(),
            span(now.last),
            span(now.min),
            span(now.mean),
            span(now.max),
            format!("{} .. {}", span(now.jitter_min), span(now.jitter_max)),
            percent(now.load),
            now.overruns.to_string(),
            now.lost.to_string(),
        ]);
    }
    rows
}

/// Prints what the rig is.
pub fn describe(client: &mut ControlClient, args: &StatusArgs) -> Result<ExitStatus, CtlError> {
    if args.json {
        show::json(&client.ask(RequestOperation::Describe)?);
        return Ok(ExitStatus::Passed);
    }
    let socket = client.socket().display().to_string();
    let version = client.greeting().version.clone();
    let it: Description = client.ask(RequestOperation::Describe)?;
    let mut rows = Vec::new();
    let mut row = |name: &str, text: String| rows.push(vec![name.to_owned(), text]);
    row("rig", format!("{version} at {socket}"));
    row("board", it.board.clone());
    let real = if it.subject == SubjectKind::External { ", a real one on the wires" } else { "" };
    row("controller", format!("{}, profile {}{real}", it.reference, it.profile));
    row("clock", clock(it.clock).to_owned());
    row("program", it.program.join(", "));
    row("on-disconnect", it.on_disconnect.clone());
    for task in &it.tasks {
        let every = if task.interval > 0 { format!(" every {}", span(task.interval)) } else { String::new() };
        let watchdog = task.watchdog.map(|time| format!(", watchdog {}", span(time))).unwrap_or_default();
        let runs = task.programs.join(", ");
        row(
            "task",
            format!("{}: {}{every}, priority {}{watchdog}: {runs}", task.name, task.kind, task.priority),
        );
    }
    for function in &it.functions {
        row(
            "function",
            format!("{}: {}, at {}", function.name, function.kind, function.terminals.join(", ")),
        );
    }
    for bus in &it.buses {
        let port = if bus.port.is_empty() { String::new() } else { format!(", at port {}", bus.port) };
        row("bus", format!("{}: {}, {}{port}", bus.name, bus.kind, bus.settings));
    }
    for device in &it.devices {
        let path = if device.path.is_empty() { String::new() } else { format!(" at {}", device.path) };
        row("device", format!("{}: {}{path}", device.name, device.kind));
    }
    row("points", format!("{}, and {} signals: `rig ctl list` has them", it.points.len(), it.signals.len()));
    output::print(&columns(&rows));
    Ok(ExitStatus::Passed)
}
