//! What a command that loads a real controller is given of the case: in its environment, and in files beside it.

use crate::subject::hook::Hook;
use crate::suite::case_files::CaseFiles;
use plans::Case;
use plans::plan::{HaltOutputs, InitialState, OutputsInStop, Rearming, StartingMode};
use signal::Span;
use std::io;
use std::path::Path;

/// Writes the case's program into a folder of its own and names it, with the case, in the environment of the commands.
///
/// # Errors
/// What cannot be written.
pub fn export_case(case: &Case, files: &CaseFiles) -> io::Result<Hook> {
    let folder = tempfile::Builder::new().prefix("rig-case-").tempdir()?;
    let mut program = Vec::new();
    for (place, source) in files.sources.iter().enumerate() {
        let name = Path::new(&source.name)
            .file_stem()
            .map_or_else(String::new, |stem| stem.to_string_lossy().into());
        let path = folder.path().join(format!("{place:02}-{name}.st"));
        // Blank lines stand for what is around a program inside a plan.
        std::fs::write(&path, source.text.trim_start_matches('\n'))?;
        program.push(path.to_string_lossy().into_owned());
    }
    let environment = [
        ("RIG_CASE", case.name.clone()),
        ("RIG_PLAN", files.plan.name.clone()),
        ("RIG_PROFILE", files.profile.name().to_owned()),
        ("RIG_REFERENCE", files.reference.name.to_owned()),
        ("RIG_SEED", files.seed.to_string()),
        ("RIG_FOLDER", folder.path().to_string_lossy().into_owned()),
        ("RIG_PROGRAM", program.join("\n")),
        ("RIG_SETTINGS", settings(case)),
    ];
    let environment = environment.map(|(name, value)| (name.to_owned(), value));
    Ok(Hook::new(environment.into(), Some(folder)))
}

/// The settings of the case, a line for each that the plan gives, as a plan would have them.
fn settings(case: &Case) -> String {
    let given = &case.settings;
    let mut lines = Vec::new();
    let mut line = |key: &str, value: Option<String>| {
        if let Some(value) = value {
            lines.push(format!("{key} = {value}"));
        }
    };
    let word = |word: &str| Some(format!("\"{word}\""));
    line(
        "initial",
        word(match given.initial {
            InitialState::Running => "running",
            InitialState::Stopped => "stopped",
            InitialState::Empty => "empty",
            InitialState::Booting => "booting",
        }),
    );
    line(
        "starting-mode",
        given.starting_mode.and_then(|mode| {
            word(match mode {
                StartingMode::Previous => "previous",
                StartingMode::Stop => "stop",
                StartingMode::Run => "run",
            })
        }),
    );
    line(
        "outputs-in-stop",
        given.outputs_in_stop.and_then(|mode| {
            word(match mode {
                OutputsInStop::Keep => "keep",
                OutputsInStop::Default => "default",
            })
        }),
    );
    line(
        "halt-outputs",
        given.halt_outputs.and_then(|mode| {
            word(match mode {
                HaltOutputs::Configured => "configured",
                HaltOutputs::Default => "default",
            })
        }),
    );
    line(
        "rearming",
        given.rearming.and_then(|mode| {
            word(match mode {
                Rearming::Automatic => "automatic",
                Rearming::Manual => "manual",
            })
        }),
    );
    line("update-io-in-stop", given.update_io_in_stop.map(|on| on.to_string()));
    line("minimize-jitter", given.minimize_jitter.map(|on| on.to_string()));
    line("can-sync", given.can_sync.map(|on| on.to_string()));
    line("filter", given.filter.map(|filter| format!("\"{}\"", filter.span())));
    line("run-stop-input", given.run_stop_input.as_ref().map(|(address, _)| format!("\"{address}\"")));
    line("alarm-output", given.alarm_output.map(|address| format!("\"{address}\"")));
    for (address, filter) in &given.filters {
        line(&format!("filter.\"{address}\""), Some(format!("\"{}\"", filter.span())));
    }
    for (address, on) in &given.output_defaults {
        line(&format!("output-defaults.\"{address}\""), Some(on.to_string()));
    }
    for input in &given.inputs {
        let key = format!("inputs.\"{}\"", input.address);
        line(&format!("{key}.latch"), input.latch.then(|| String::from("true")));
    }
    for function in &given.expert {
        for (key, value) in function.written() {
            line(&format!("expert.{:?}.{key}", function.name), Some(value));
        }
    }
    for task in &given.tasks {
        let span = |span: Option<Span>| span.map(|span| format!("\"{span}\""));
        let key = if task.name == "MAST" { String::from("mast") } else { format!("tasks.\"{}\"", task.name) };
        line(&format!("{key}.interval"), span(task.interval));
        line(&format!("{key}.watchdog"), span(task.watchdog));
        line(&format!("{key}.priority"), task.priority.map(|priority| priority.to_string()));
        line(&format!("{key}.sensitivity"), task.sensitivity.map(|times| times.to_string()));
        line(&format!("{key}.enabled"), task.enabled.map(|on| on.to_string()));
        let programs = task.programs.as_ref().map(|programs| format!("{programs:?}"));
        line(&format!("{key}.programs"), programs);
    }
    lines.push(String::new());
    lines.join("\n")
}
