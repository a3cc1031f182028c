//! Expert functions on the lines of a board: who makes their pulses, and how fast.

use super::TestBench;
use crate::application::functions::configure;
use crate::codes;
use document::Diagnostic;
use drivers::{Channel, TimestampSource};
use expert::{AxisConfig, FunctionKind, WaveConfig};
use plans::plan::{FunctionSettings, PlanSettings};
use profile::IoChannel;

/// What the lines behind the outputs of the functions cannot do, and what they do not promise.
pub(super) fn on_lines(settings: &PlanSettings, plan: &str, bench: &TestBench<'_>) -> Vec<Diagnostic> {
    if bench.file.subject.is_external() {
        return Vec::new();
    }
    // What is wrong with the functions themselves was reported with the controller.
    let Ok(config) = configure(settings, plan) else { return Vec::new() };
    let mut found = Vec::new();
    for (function, said) in config.functions.iter().zip(&settings.expert) {
        match &function.kind {
            FunctionKind::Pwm(wave) | FunctionKind::Generator(wave) => {
                found.extend(wave_on_line(wave, said, plan, bench));
            }
            FunctionKind::Axis(axis) => found.extend(axis_on_lines(axis, said, plan, bench)),
            FunctionKind::Counter(_) => {}
        }
    }
    found
}

fn wave_on_line(
    wave: &WaveConfig,
    said: &FunctionSettings,
    plan: &str,
    bench: &TestBench<'_>,
) -> Option<Diagnostic> {
    let channel = behind(wave.output, bench)?;
    match channel.emits {
        Some(emits) if !emits.endless => Some(not_made(said, "a", channel, plan)),
        Some(_) if wave.sync.is_some() => {
            let message =
                format!("`{}`: the device behind `{}` cannot restart its period", said.name, channel.name);
            let found =
                Diagnostic::error(codes::PERIOD_NOT_RESTARTED, message).at(plan, said.place("sync"), "");
            Some(found.help("leave out `sync`, or bind the output to a line that the rig drives"))
        }
        Some(_) => None,
        None => unpromised(said, "a", channel, 0, plan),
    }
}

fn axis_on_lines(
    axis: &AxisConfig,
    said: &FunctionSettings,
    plan: &str,
    bench: &TestBench<'_>,
) -> Option<Diagnostic> {
    [("a", Some(axis.a)), ("b", axis.b)].into_iter().find_map(|(key, output)| {
        let channel = behind(output?, bench)?;
        match channel.emits {
            Some(_) if channel.max_pulse_hz == 0 => Some(not_made(said, key, channel, plan)),
            _ => unpromised(said, key, channel, u64::from(axis.max_velocity), plan),
        }
    })
}

/// The channel behind an output.
fn behind<'b>(output: u8, bench: &'b TestBench<'_>) -> Option<&'b Channel> {
    let of = |binding: &&drivers::Binding| {
        let embedded = IoChannel::at(binding.address, bench.reference);
        embedded == Some(IoChannel::Output(output.into()))
    };
    let binding = bench.file.bind.iter().find(of)?;
    bench.board.channels().get(usize::from(binding.channel.0))
}

/// Pulses of which the device behind the line cannot make the number that the function wants.
fn not_made(said: &FunctionSettings, key: &str, channel: &Channel, plan: &str) -> Diagnostic {
    let name = &channel.name;
    let message = format!("`{}`: the device behind `{name}` cannot make these pulses", said.name);
    let found = Diagnostic::error(codes::FUNCTION_PULSES_NOT_MADE, message).at(plan, said.place(key), "");
    found.help("bind the output to a line that the rig drives: each pulse of this function is its own")
}

/// Pulses faster than the board promises: those of a function whose frequency the program says may be any.
fn unpromised(
    said: &FunctionSettings,
    key: &str,
    channel: &Channel,
    fastest: u64,
    plan: &str,
) -> Option<Diagnostic> {
    let promised = channel.max_pulse_hz;
    if channel.timestamp == TimestampSource::Virtual || promised > 0 && fastest <= promised {
        return None;
    }
    let (function, name) = (&said.name, &channel.name);
    let message = match promised {
        0 => format!("`{function}`: the board promises no pulses on `{name}`"),
        _ => format!(
            "`{function}`: the board promises pulses up to {promised} Hz on `{name}`, not {fastest} Hz"
        ),
    };
    let found = Diagnostic::warning(codes::FUNCTION_FASTER_THAN_LINE, message).at(plan, said.place(key), "");
    Some(found.help(
        "a pulse that the rig comes too late for is an error of the case: lower the highest velocity, bind the output to \
         a generator, or say with `pulses-up-to` what the line was measured to follow",
    ))
}
