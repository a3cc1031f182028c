//! The person at the machine, as a case meets them.

use plans::steps::Question;
use std::fmt;
use std::sync::atomic::AtomicBool;

/// Somebody who can be asked while a case runs. Cases that run at once may ask at once.
pub trait Operator: fmt::Debug + Sync {
    /// Asks the question of a step and waits for the place of an answer in [`Question::answers`]. `interrupt` becomes
    /// TRUE when the user wants the run to end: then waiting ends, too.
    ///
    /// # Errors
    /// Why there is no answer.
    fn ask(&self, step: &str, question: &Question, interrupt: &AtomicBool) -> Result<usize, AskError>;
}

/// Why a question has no answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AskError {
    /// Nobody is there, or nobody any more.
    Nobody,
    /// The user wants the run to end.
    Interrupted,
}

impl fmt::Display for AskError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            AskError::Nobody => "nobody is there to answer",
            AskError::Interrupted => "interrupted",
        })
    }
}

impl std::error::Error for AskError {}
