//! Interrupts of commands that have something to undo. Others end by the signal itself.

use super::CtlError;
use crate::exit::ExitStatus;
use crate::output;
use std::sync::atomic::{AtomicBool, Ordering};

/// Set by the first interrupt.
static INTERRUPT: AtomicBool = AtomicBool::new(false);

/// Interrupts are seen from now on by what comes back.
///
/// # Errors
/// They cannot be caught.
pub fn catch() -> Result<impl Fn() -> bool, CtlError> {
    if let Err(error) = ctrlc::set_handler(|| INTERRUPT.store(true, Ordering::Relaxed)) {
        output::error(&format!("interrupts cannot be caught: {error}"));
        return Err(CtlError::Exit(ExitStatus::Error));
    }
    Ok(|| INTERRUPT.load(Ordering::Relaxed))
}
