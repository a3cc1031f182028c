//! The files that a case is made of.

use document::{Diagnostic, Joined, SourceFile};
use drivers::BoardFile;
use plans::Case;
use plans::plan::GlobalChecks;
use plans::steps::ProgramRef;
use profile::{Profile, Reference};
use std::borrow::Cow;
use std::sync::Arc;

/// A case with the files that it is made of.
#[derive(Clone, Debug)]
pub struct CaseFiles {
    /// Name of the case in the run.
    pub name: String,
    /// What the command line gives for the plan's parameters.
    pub given: Vec<(String, String)>,
    /// The plan.
    pub plan: SourceFile,
    /// The plan and what it includes: the places of the case count through all of them.
    pub joined: Joined,
    /// The sources of the program.
    pub sources: Vec<SourceFile>,
    /// The programs that steps bring to the controller, each once.
    pub others: Vec<OtherProgram>,
    /// The board.
    pub board: BoardFile,
    /// Text of the board file, empty for the default board.
    pub board_text: String,
    /// Whether the board is the one that the plan names: what it lacks is a fault of the plan then, and not of the bench.
    pub own_board: bool,
    /// What suites and the board claim of every case.
    pub guards: Vec<Arc<GlobalChecks>>,
    /// The controller.
    pub profile: Profile,
    /// Its reference.
    pub reference: &'static Reference,
    /// The seed of everything that is left to chance.
    pub seed: u64,
}

impl CaseFiles {
    /// The case with what suites and the board claim of it.
    ///
    /// # Errors
    /// Two alarms of one name.
    pub fn guarded<'c>(&self, case: &'c Case) -> Result<Cow<'c, Case>, Vec<Diagnostic>> {
        let mut case = Cow::Borrowed(case);
        for guards in &self.guards {
            guards.attach(case.to_mut())?;
        }
        Ok(case)
    }
}

/// A program that a step brings to the controller.
#[derive(Clone, Debug)]
pub struct OtherProgram {
    /// As the step names it.
    pub program: ProgramRef,
    /// Its sources.
    pub sources: Vec<SourceFile>,
}
