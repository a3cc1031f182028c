//! The names of a case, looked up on its bench without running it.

use crate::case::applicability;
use crate::case::check;
use crate::case::needs::{Unmet, unmet};
use crate::case::test_setup::{TestSetup, set_up};
use crate::prepare::PreparedCase;
use crate::suite::case_files::CaseFiles;
use document::Diagnostic;
use plans::Case;
use plans::judge::CaseJudge;
use signal::{Span, Trace};
use std::borrow::Cow;

/// Builds subject and board of a case and looks up its names: signals and steps as a run would have them.
pub(crate) fn lay_out(case: &Case, files: &CaseFiles) -> Result<PreparedCase, Vec<Diagnostic>> {
    let case = &*files.guarded(case)?;
    set_up(case, files, None)?.prepare(case, files, Trace::new(), true)
}

/// Builds subject and board of a case and looks up its names. Hands back what its programs and its bench warn of.
pub(crate) fn look_up(case: &Case, files: &CaseFiles) -> Result<Vec<Diagnostic>, Vec<Diagnostic>> {
    let case = files.guarded(case)?;
    let mut stage = set_up(&case, files, None)?;
    let mut warnings = std::mem::take(&mut stage.program_warnings);
    warnings.extend(look_up_on(stage, case, files)?);
    Ok(warnings)
}

/// The same on a bench that is set up.
fn look_up_on(
    mut stage: TestSetup,
    mut case: Cow<'_, Case>,
    files: &CaseFiles,
) -> Result<Vec<Diagnostic>, Vec<Diagnostic>> {
    let missing = applicability::missing_of_own_board(&case, files, &*stage.board);
    if !missing.is_empty() {
        return Err(missing);
    }
    if let Some(reason) = applicability::not_applicable_reason(&case, files, &*stage.board) {
        return Ok(vec![check::no_verdict(files, &reason)]);
    }
    if files.board.subject.is_external() {
        if let Some(Unmet::Power(reason)) = unmet(&case, &*stage.subject, &*stage.board, Span::ZERO) {
            return Ok(vec![check::no_verdict(files, &reason)]);
        }
        applicability::remove_unreachable_signals(case.to_mut(), files, &*stage.board);
    }
    let case = &*case;
    let prepared = stage.prepare(case, files, Trace::new(), true)?;
    CaseJudge::new(case.scenario(), prepared.trace.signals())?;
    let looked = stage.on_bench(case, files, &prepared);
    let found = check::claims(&looked);
    if found.iter().any(Diagnostic::is_error) {
        return Err(found);
    }
    let needs = check::needs(&looked);
    let mut warnings = stage.warnings;
    warnings.extend(prepared.warnings);
    warnings.extend(found);
    warnings.extend(needs);
    Ok(warnings)
}
