//! The embedded inputs of a case: what its settings say, what the controller's documents exclude, and how they are
//! named in a plan.

use crate::application::module_terminals::ModuleTerminals;
use crate::application::observable::Observable;
use crate::codes;
use controller::{Config, ConfigError, InputConfig, InputFault, InputProbe, Probe, RunStopFault};
use document::Diagnostic;
use plans::plan::PlanSettings;
use profile::InputFilter;
use signal::{Address, ValueKind};
use std::ops::Range;

/// Puts what a plan says of inputs into the configuration.
///
/// # Errors
/// A finding at the setting: an input that the reference does not have, parameters that exclude each other.
pub fn configure(config: &mut Config, settings: &PlanSettings, plan: &str) -> Result<(), Vec<Diagnostic>> {
    let count = config.reference.input_count();
    let everywhere = InputConfig::filtered(settings.filter.unwrap_or_default());
    config.inputs = vec![everywhere; count];
    let of_modules = ModuleTerminals::new(config.reference, &config.modules);
    let of_module = |address: Address| {
        let terminal = of_modules.at(address, 1).next()?;
        Some(format!("; {address} is {terminal} of {}, and no embedded input", terminal.reference()))
    };
    let missing = |address: Address, at: Range<usize>| {
        let message = format!("{} has no input {address}", config.reference.name);
        let help = match count {
            0 => String::from("it has no embedded inputs"),
            _ => format!("it has I0 to I{}", count - 1),
        } + &of_module(address).unwrap_or_default();
        vec![Diagnostic::error(codes::NO_TERMINAL, message).at(plan, at, "").help(help)]
    };
    let place = |address: Address| address.bit_offset() as usize;
    for (address, filter) in &settings.filters {
        let input = config.inputs.get_mut(place(*address)).ok_or_else(|| missing(*address, 0..0))?;
        input.filter = *filter;
    }
    for said in &settings.inputs {
        let stated = settings.filters.iter().any(|(address, _)| *address == said.address);
        let input = config.inputs.get_mut(place(said.address));
        let input = input.ok_or_else(|| missing(said.address, said.span.clone()))?;
        (input.latch, input.event) = (said.latch, said.event);
        input.bounce = said.bounce.unwrap_or_default();
        // io:EIO-03: a filter that is not stated for this very input is none beside Latch or Event.
        input.filter = match said.filter {
            Some(filter) => filter,
            None if input.is_expert() && !stated => InputFilter::None,
            None => input.filter,
        };
    }
    if let Some((address, at)) = &settings.run_stop_input {
        if count > 0 && place(*address) >= count {
            return Err(missing(*address, at.clone()));
        }
        config.run_stop_input = Some(place(*address));
    }
    config.check_inputs().map_err(|error| vec![refusal(&error, settings, plan)])
}

/// A refusal of the controller at the setting that it is about, with what fixes it.
fn refusal(error: &ConfigError, settings: &PlanSettings, plan: &str) -> Diagnostic {
    let (code, at, help) = match error {
        ConfigError::Input { input, fault } => {
            let said = settings.inputs.iter().find(|said| said.address.bit_offset() as usize == *input);
            let help = match fault {
                InputFault::FilterWithExpert => "leave the filter out, or set it to \"0 ms\"",
                InputFault::LatchWithEvent => "remove one of `latch` and `event`",
                InputFault::NotFast => "take one of I0 to I7, or remove `latch` and `event`",
                InputFault::BounceAlone => "remove `bounce`, or set `latch` or `event`",
            };
            (codes::INPUT_PARAMETERS_EXCLUSIVE, said.map(|said| said.span.clone()), help)
        }
        ConfigError::RunStopInput { fault, .. } => {
            let help = match fault {
                RunStopFault::NoneAtAll => "remove `run-stop-input`: its switch runs and stops it",
                RunStopFault::Beyond { .. } => "take one of those, or another profile",
                RunStopFault::Expert => "take another input, or remove its `latch` and `event`",
            };
            (codes::NO_RUN_STOP_INPUT, settings.run_stop_input.as_ref().map(|(_, at)| at.clone()), help)
        }
        _ => (codes::CONFIGURATION_REFUSED, None, ""),
    };
    Diagnostic::error(code, error.to_string()).at(plan, at.unwrap_or(0..0), "").help(help)
}

/// Whether only MAST reads the latched inputs (io:EIO-09). `readers` has the tasks with the places of their PROGRAMs.
///
/// # Errors
/// A finding at the setting of the first input that another task reads.
pub fn latched_for_mast<'a>(
    program: &program::Program,
    readers: impl Iterator<Item = (&'a str, &'a Vec<usize>)>,
    settings: &PlanSettings,
    plan: &str,
) -> Result<(), Vec<Diagnostic>> {
    for (task, programs) in readers.filter(|(task, _)| !task.eq_ignore_ascii_case("MAST")) {
        let read: Vec<Address> = programs.iter().flat_map(|place| program.inputs_of(*place)).collect();
        let mut latched = settings.inputs.iter().filter(|said| said.latch);
        if let Some(said) = latched.find(|said| read.iter().any(|read| read.overlaps(&said.address))) {
            let message = format!("the task {task} reads {}, which is latched", said.address);
            let found = Diagnostic::error(codes::LATCH_OUTSIDE_MAST, message).at(plan, said.span.clone(), "");
            return Err(vec![
                found.help("read it in MAST, which alone empties its latch, or remove `latch`"),
            ]);
        }
    }
    Ok(())
}

/// What `INPUT.I0.filtered` and the like mean on a controller with so many inputs.
pub fn observable(name: &str, inputs: usize) -> Option<Observable> {
    let mut parts = name.split('.');
    let (prefix, input, part) = (parts.next()?, parts.next()?, parts.next()?);
    if parts.next().is_some() || !prefix.eq_ignore_ascii_case("INPUT") {
        return None;
    }
    let number =
        input.strip_prefix(['I', 'i']).filter(|digits| digits.bytes().all(|c| c.is_ascii_digit()))?;
    let input = number.parse().ok().filter(|input| *input < inputs)?;
    let part = PARTS.iter().find(|(known, _)| known.eq_ignore_ascii_case(part))?.1;
    let kind = if part == InputProbe::Events { ValueKind::Int } else { ValueKind::Bool };
    Some(Observable { probe: Probe::Input { input, part }, kind })
}

/// What can be looked at of an input, by its name.
const PARTS: [(&str, InputProbe); 4] = [
    ("filtered", InputProbe::Filtered),
    ("latched", InputProbe::Latched),
    ("events", InputProbe::Events),
    ("overdriven", InputProbe::Overdriven),
];

/// The names of everything that can be looked at of so many inputs.
pub fn names(inputs: usize) -> impl Iterator<Item = String> {
    (0..inputs).flat_map(|input| PARTS.iter().map(move |(part, _)| format!("INPUT.I{input}.{part}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    // io: section 17.6
    #[test]
    fn every_name_means_something() {
        assert!(names(14).all(|name| observable(&name, 14).is_some()));
        for wrong in
            ["INPUT.I14.filtered", "INPUT.I+1.filtered", "INPUT.I1", "INPUT.I1.raw", "INPUT.I1.events.x"]
        {
            assert_eq!(observable(wrong, 14), None, "{wrong}");
        }
    }
}
