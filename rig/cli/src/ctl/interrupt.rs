//! Interrupts of commands that have something to undo. Others end by the signal itself.

use super::CtlError;
use crate::exit::ExitStatus;
use crate::output;
use std::sync::atomic::{AtomicBool, Ordering};

/// Set by the first interrupt.
static INTERRUPT: AtomicBool = AtomicBool::new(false);

/// The first interrupt is seen from now on by what comes back; a second one ends the command at once, whatever it waits for.
///
/// # Errors
/// They cannot be caught.
pub fn catch() -> Result<impl Fn() -> bool, CtlError> {
    let interrupted = || {
        if INTERRUPT.swap(true, Ordering::Relaxed) {
            std::process::exit(ExitStatus::Interrupted.code().into());
        }
    };
    if let Err(error) = ctrlc::set_handler(interrupted) {
        output::error(&format!("interrupts cannot be caught: {error}"));
        return Err(CtlError::Exit(ExitStatus::Error));
    }
    Ok(|| INTERRUPT.load(Ordering::Relaxed))
}
