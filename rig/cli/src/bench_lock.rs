//! A bench that another run may be using.

use crate::exit::ExitStatus;
use crate::output;
use clap::Args;
use document::Diagnostic;
use drivers::BoardFile;
use runtime::BenchLock;
use runtime::hardware::bench_lock;
use signal::Span;
use std::sync::atomic::{AtomicBool, Ordering};

/// What the command line says of it.
#[derive(Clone, Debug, Args)]
pub struct BenchLockArgs {
    /// Wait at most this long for a bench that another run uses.
    #[arg(long, value_name = "TIME", value_parser = crate::duration::above_zero)]
    wait: Option<Span>,
}

impl BenchLockArgs {
    /// Takes the lines of a board for this command, until what comes back is dropped.
    ///
    /// # Errors
    /// How the command ends where it cannot have them; why is printed.
    pub fn take(&self, board: &BoardFile, interrupt: &AtomicBool) -> Result<Option<BenchLock>, ExitStatus> {
        let taken = bench_lock::take(board, self.wait, interrupt, &output::note);
        if let Ok(Some(lock)) = &taken {
            output::findings(&lock.warning().cloned().into_iter().collect::<Vec<_>>(), &[]);
        }
        taken.or_else(|found: Diagnostic| {
            let refused = found.is_error();
            if refused && interrupt.load(Ordering::Relaxed) {
                return Err(ExitStatus::Interrupted);
            }
            output::findings(&[found], &[]);
            if refused { Err(ExitStatus::UserFiles) } else { Ok(None) }
        })
    }
}
