//! Channels that a board drives at terminals of modules which a plan does not use.

use crate::application::module_terminals::{ModuleTerminals, TerminalOfModule};
use crate::codes;
use controller::Config;
use document::Diagnostic;
use drivers::{BoardFile, ChannelId};

/// A plant or a wire that drives the channel of an analogue input without a `mode`: most often a terminal is meant that has one, and
/// nothing drives that.
pub(crate) fn warnings(board: &BoardFile, config: &Config, plan: &str) -> Vec<Diagnostic> {
    let terminals = ModuleTerminals::new(config.reference, &config.modules);
    let unused = |terminal: &TerminalOfModule<'_>| {
        let is_open = terminal.is_word() && terminal.is_input() && !terminal.is_used();
        is_open && board.find(&terminal.to_string()).is_some_and(|channel| is_driven(board, channel))
    };
    let warned = |terminal: TerminalOfModule<'_>| {
        let message =
            format!("the board drives `{terminal}`, an input of {} that is not used", terminal.reference());
        Diagnostic::warning(codes::UNUSED_TERMINAL, message).at(plan, 0..0, "").help(terminal.how_to_use())
    };
    terminals.all().map(|(terminal, _)| terminal).filter(unused).map(warned).collect()
}

fn is_driven(board: &BoardFile, channel: ChannelId) -> bool {
    let mut outputs = board.circuit.plants.iter().flat_map(|plant| plant.outputs());
    board.circuit.wires.iter().any(|wire| wire.to == channel) || outputs.any(|port| port.channel == channel)
}
