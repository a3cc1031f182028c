//! The real lines of a run, and the real controller on them.

use crate::codes;
use crate::suite::file_source::beside;
use crate::suite::{Job, LoadedPlan};
use document::Diagnostic;
use drivers::file::BoardFile;

/// The board with real lines that these jobs run on, if there is one.
///
/// # Errors
/// There are several: lines of one could be those of another.
pub fn real_board<'p>(plans: &'p [LoadedPlan], jobs: &[Job]) -> Result<Option<&'p BoardFile>, Diagnostic> {
    let mut found: Option<&BoardFile> = None;
    for job in jobs {
        let board = plans.get(job.plan).and_then(|loaded| loaded.real_board_of(job));
        match (found, board) {
            (Some(first), Some(board)) if first.name != board.name => {
                let message =
                    format!("one run cannot have the lines of `{}` and `{}`", first.name, board.name);
                let help = "run their plans one after the other, or on one board by `--board`";
                return Err(Diagnostic::error(codes::SEVERAL_REAL_BOARDS, message).help(help));
            }
            (None, Some(_)) => found = board,
            _ => {}
        }
    }
    Ok(found)
}

/// That the program in a real controller is taken to be that of the plans, where nothing loads it: a warning.
pub fn program_not_loaded(plans: &[LoadedPlan]) -> Option<Diagnostic> {
    let boards = plans.iter().flat_map(|plan| {
        let given = plan.board.iter().map(|(board, _)| board);
        given.chain(plan.boards.iter().map(|(_, board, _)| board))
    });
    let unloaded =
        |board: &&BoardFile| board.subject.external.as_ref().is_some_and(|own| own.load.is_empty());
    let board = boards.into_iter().find(unloaded)?;
    let message =
        format!("the controller of `{}` is taken to have the program and settings of the plan", board.name);
    let help = "see that it has, or name the command that loads it under `load`";
    Some(Diagnostic::warning(codes::PROGRAM_NOT_LOADED, message).at(&board.name, 0..0, "").help(help))
}

impl LoadedPlan {
    /// The board with real lines that a job runs on, if there is one.
    fn real_board_of(&self, job: &Job) -> Option<&BoardFile> {
        if let Some((board, _)) = &self.board {
            return Some(board).filter(|board| board.is_real());
        }
        // A case is made only where it can matter.
        if !self.boards.iter().any(|(_, board, _)| board.is_real()) {
            return None;
        }
        let path = beside(&self.plan.path, &self.plan.case(job.case)?.board?);
        let (_, board, _) = self.boards.iter().find(|(known, ..)| *known == path)?;
        Some(board).filter(|board| board.is_real())
    }
}
