//! Which bus of the board each port of the subject is on.

use crate::codes;
use crate::suite::case_files::CaseFiles;
use crate::wiring::WiredPort;
use document::{Diagnostic, suggest};
use drivers::BoardFile;
use profile::Reference;

/// The ports of a reference with the buses behind them, by the port's number; what it lacks is left out.
pub(crate) fn wired(file: &BoardFile, reference: &Reference) -> Vec<WiredPort> {
    let mut ports: Vec<_> =
        reference.ports.iter().map(|port| WiredPort { name: port.name, bus: None }).collect();
    for binding in &file.ports {
        if let Some(port) = reference.find_port(&binding.port) {
            ports[port].bus = Some(binding.bus);
        }
    }
    ports
}

/// Ports that the board file binds and the controller of a case lacks: the plan's reference goes before the board's.
///
/// # Errors
/// A finding for each of them.
pub(crate) fn check(files: &CaseFiles) -> Result<(), Vec<Diagnostic>> {
    let reference = files.reference;
    let names = || reference.ports.iter().map(|port| port.name);
    let lacking = files.board.ports.iter().filter(|binding| reference.find_port(&binding.port).is_none());
    let found: Vec<Diagnostic> = lacking
        .map(|binding| {
            let message = format!("{} has no port {}, which the board binds", reference.name, binding.port);
            let help = match suggest(&binding.port, names()) {
                Some(meant) => format!("bind {meant}, or leave `reference` to the board"),
                None => {
                    let known: Vec<&str> = names().collect();
                    format!("it has {}; or leave `reference` to the board", known.join(", "))
                }
            };
            let missing = Diagnostic::error(codes::PORT_MISSING, message);
            missing.at(&files.board.name, binding.place.clone(), "").help(help)
        })
        .collect();
    if found.is_empty() { Ok(()) } else { Err(found) }
}
