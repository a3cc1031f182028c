//! The ports of the subject: which bus of the board each is on.

use crate::case_files::CaseFiles;
use crate::codes;
use document::{Diagnostic, suggest};
use drivers::BusId;

/// The bus behind each port of a case's controller, by the port's number.
///
/// # Errors
/// A port that the board file binds and this controller lacks: the plan's reference goes before the board's.
pub(crate) fn bound_buses(files: &CaseFiles) -> Result<Vec<Option<BusId>>, Vec<Diagnostic>> {
    let reference = files.reference;
    let mut buses = vec![None; reference.ports.len()];
    let mut found = Vec::new();
    for binding in &files.board.ports {
        match reference.find_port(&binding.port) {
            Some(port) => buses[port] = Some(binding.bus),
            None => {
                let message =
                    format!("{} has no port {}, which the board binds", reference.name, binding.port);
                let names = || reference.ports.iter().map(|port| port.name);
                let known: Vec<&str> = names().collect();
                let help = match suggest(&binding.port, names()) {
                    Some(meant) => format!("bind {meant}, or leave `reference` to the board"),
                    None => format!("it has {}; or leave `reference` to the board", known.join(", ")),
                };
                let board = &files.board.name;
                let missing =
                    Diagnostic::error(codes::PORT_MISSING, message).at(board, binding.place.clone(), "");
                found.push(missing.help(help));
            }
        }
    }
    if found.is_empty() { Ok(buses) } else { Err(found) }
}
