//! The controller's configuration from what a plan sets.

use crate::application::functions;
use crate::application::inputs;
use crate::application::module_terminals::ModuleTerminals;
use crate::application::modules;
use crate::codes;
use crate::suite::case_files::CaseFiles;
use controller::{
    AlwaysUpdate, Config, HaltOutputs, OutputsInStop, Rearming, RelocationConfig, StartingMode, State,
    WatchdogBasis,
};
use document::Diagnostic;
use plans::plan::{InitialState, PlanSettings};
use signal::Address;

/// The state in which a case begins.
pub const fn initial_state(initial: InitialState) -> State {
    match initial {
        InitialState::Running => State::Running,
        InitialState::Stopped => State::Stopped,
        InitialState::Empty => State::Empty,
        InitialState::Booting => State::Booting,
    }
}

/// The controller's configuration from the plan's settings, but for the tasks.
///
/// # Errors
/// A finding in the plan: an input or an output that the reference does not have, parameters that exclude each other.
pub fn configuration(settings: &PlanSettings, files: &CaseFiles) -> Result<Config, Vec<Diagnostic>> {
    let mut config = Config::new(files.profile);
    config.reference = files.reference;
    if let Some(mode) = settings.starting_mode {
        config.starting_mode = match mode {
            plans::plan::StartingMode::Previous => StartingMode::Previous,
            plans::plan::StartingMode::Stop => StartingMode::Stop,
            plans::plan::StartingMode::Run => StartingMode::Run,
        };
    }
    if let Some(outputs) = settings.outputs_in_stop {
        config.outputs_in_stop = match outputs {
            plans::plan::OutputsInStop::Keep => OutputsInStop::Keep,
            plans::plan::OutputsInStop::Default => OutputsInStop::Default,
        };
    }
    if let Some(basis) = settings.watchdog_basis {
        config.watchdog_basis = match basis {
            plans::plan::WatchdogBasis::Elapsed => WatchdogBasis::Elapsed,
            plans::plan::WatchdogBasis::Processor => WatchdogBasis::Processor,
        };
    }
    if let Some(update) = settings.always_update {
        config.always_update = match update {
            plans::plan::AlwaysUpdate::Disabled => AlwaysUpdate::Disabled,
            plans::plan::AlwaysUpdate::Enabled1 => AlwaysUpdate::Unused,
            plans::plan::AlwaysUpdate::Enabled2 => AlwaysUpdate::Always,
        };
    }
    config.update_io_in_stop = settings.update_io_in_stop.unwrap_or(config.update_io_in_stop);
    let [read, write] = settings.relocation.clone();
    config.relocation = RelocationConfig { read, write };
    if let Some(outputs) = settings.halt_outputs {
        config.halt_outputs = match outputs {
            plans::plan::HaltOutputs::Configured => HaltOutputs::Configured,
            plans::plan::HaltOutputs::Default => HaltOutputs::Default,
        };
    }
    if let Some(mode) = settings.rearming {
        config.rearming = match mode {
            plans::plan::Rearming::Automatic => Rearming::Automatic,
            plans::plan::Rearming::Manual => Rearming::Manual,
        };
    }
    config.minimize_jitter = settings.minimize_jitter.unwrap_or(config.minimize_jitter);
    config.can_sync = settings.can_sync.unwrap_or(config.can_sync);
    config.clock_drift = settings.clock_drift.unwrap_or(config.clock_drift);
    config.tool_connected = settings.login.unwrap_or(config.tool_connected);
    config.alarm_output = settings.alarm_output.map(|address| address.bit_offset() as usize);
    config.expert = functions::configure(settings, &files.plan.name)?;
    if !files.board.subject.is_external() {
        config.counted = functions::counted(&files.board, files.reference);
        functions::check_counted(&config.expert, config.counted, settings, &files.plan.name)?;
    }
    config.modules = modules::configure(&settings.modules, files.profile, files.reference, &files.plan.name)?;
    config.io_bus_mast = settings.io_bus_mast.unwrap_or(config.io_bus_mast);
    config.fitted = files.board.fitted.as_deref().map(modules::fitted);
    inputs::configure(&mut config, settings, &files.plan.name)?;
    for (address, on) in &settings.output_defaults {
        let output = address.bit_offset() as usize;
        if output >= files.reference.output_count() {
            return Err(vec![no_output(*address, &config, files)]);
        }
        if *on {
            config.output_defaults.insert(output);
        }
    }
    functions::check(&config, settings, &files.plan.name)?;
    Ok(config)
}

fn no_output(address: Address, config: &Config, files: &CaseFiles) -> Diagnostic {
    let reference = files.reference;
    let mut help = match reference.output_count().checked_sub(1) {
        None => String::from("it has no embedded outputs"),
        Some(last) => format!("it has Q0 to Q{last}"),
    };
    if let Some(terminal) = ModuleTerminals::new(reference, &config.modules).at(address, 1).next() {
        let of = terminal.reference();
        help +=
            &format!("; {address} is {terminal} of {of}, whose outputs have FALSE as their default value");
    }
    let found = Diagnostic::error(codes::NO_TERMINAL, format!("{} has no output {address}", reference.name));
    found.at(&files.plan.name, 0..0, "").help(help)
}
