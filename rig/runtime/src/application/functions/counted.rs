//! Inputs at which hardware counts: fast counters take its counts in place of edges.

use super::configure::key_of;
use crate::codes;
use document::Diagnostic;
use drivers::{BoardFile, ChannelKind};
use expert::{ChannelRole, CounterMode, CounterRole, ExpertConfig, FunctionKind};
use plans::plan::PlanSettings;
use profile::{ChannelSet, IoChannel, Reference};
use signal::Area;

/// The inputs of the model behind whose terminals hardware counts.
pub fn counted(board: &BoardFile, reference: &Reference) -> ChannelSet {
    let counts = |channel: drivers::ChannelId| {
        let channel = board.circuit.channels.get(usize::from(channel.0));
        channel.is_some_and(|channel| channel.kind == ChannelKind::Count)
    };
    let inputs = board.bind.iter().filter(|binding| binding.address.area() == Area::Input);
    let counted = inputs.filter(|binding| counts(binding.channel));
    let numbers = counted.filter_map(|binding| match IoChannel::at(binding.address, reference)? {
        IoChannel::Input(input) => Some(input),
        IoChannel::Output(_) => None,
    });
    numbers.collect()
}

/// What functions cannot do with counts.
///
/// # Errors
/// The findings, each at the key that names such an input.
pub fn check(
    config: &ExpertConfig,
    counted: ChannelSet,
    settings: &PlanSettings,
    plan: &str,
) -> Result<(), Vec<Diagnostic>> {
    let mut found = Vec::new();
    for (function, said) in config.functions.iter().zip(&settings.expert) {
        for (role, channel) in function.kind.channels() {
            let IoChannel::Input(input) = channel else { continue };
            if !counted.contains(input) {
                continue;
            }
            let (code, message, help) = match (&function.kind, role) {
                (FunctionKind::Counter(counter), ChannelRole::Counter(CounterRole::A)) => {
                    match counter.mode {
                        CounterMode::OneShot { .. }
                        | CounterMode::ModuloLoop { .. }
                        | CounterMode::FreeLarge { .. } => continue,
                        CounterMode::EventCounting { .. }
                        | CounterMode::Frequency { .. }
                        | CounterMode::Period { .. } => (
                            codes::FUNCTION_WITHOUT_COUNTS,
                            format!(
                                "`{}` measures when its pulses come, and I{input} shows how many came",
                                said.name
                            ),
                            "bind the input to a line whose edges the board reports, or measure the speed of the count in the plan",
                        ),
                    }
                }
                _ => (
                    codes::INPUT_WITHOUT_LEVEL,
                    format!("`{}` needs the level of I{input}, behind which the board counts", said.name),
                    "take an input that is bound to a line: a count has no level",
                ),
            };
            let place = said.place(key_of(role));
            found.push(Diagnostic::error(code, message).at(plan, place, "").help(help));
        }
    }
    if found.is_empty() { Ok(()) } else { Err(found) }
}
