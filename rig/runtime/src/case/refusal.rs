//! Cases that are to be refused or warned of when they are checked, and never run.

use crate::case::look_up::look_up;
use crate::codes;
use crate::suite::case_files::CaseFiles;
use document::Diagnostic;
use plans::Case;
use plans::plan::ExpectedRefusal;
use record::{CaseRecord, ClaimRecord, Verdict};

/// What the check of the case finds: errors, or else what is worth knowing of its tasks and of its program.
fn found(case: &Case, files: &CaseFiles) -> Vec<Diagnostic> {
    look_up(case, files).unwrap_or_else(|errors| errors)
}

/// What the check of the case finds, held against what it must find: what was observed, or what is wrong.
fn judge(
    case: &Case,
    files: &CaseFiles,
    refusal: &ExpectedRefusal,
) -> (Result<String, String>, Vec<Diagnostic>) {
    let found = if refusal.found.is_empty() { found(case, files) } else { refusal.found.clone() };
    (refusal.judge(&found), found)
}

/// The findings of a case that is to be refused: none if it is refused as it must be.
///
/// # Errors
/// What was found instead.
pub(crate) fn check(
    case: &Case,
    files: &CaseFiles,
    refusal: &ExpectedRefusal,
) -> Result<(), Vec<Diagnostic>> {
    let (judged, mut found) = judge(case, files, refusal);
    match judged {
        Ok(_) => Ok(()),
        Err(why) => {
            let expected = refusal.expected();
            let one = Diagnostic::error(codes::NOT_REFUSED_AS_PLANNED, why).at(
                &files.plan.name,
                refusal.span.clone(),
                expected,
            );
            found.insert(0, one);
            Err(found)
        }
    }
}

/// Judges a case by what its check finds.
pub(crate) fn run(case: &Case, files: &CaseFiles, refusal: &ExpectedRefusal, record: &mut CaseRecord) {
    let verb = if refusal.warning { "warned" } else { "refused" };
    let mut claim = ClaimRecord {
        name: verb.to_owned(),
        verb: verb.to_owned(),
        expected: refusal.expected(),
        line: refusal.line,
        ..ClaimRecord::default()
    };
    match judge(case, files, refusal).0 {
        Ok(observed) => {
            claim.verdict = Verdict::Pass;
            claim.observed = observed;
        }
        Err(why) => {
            claim.verdict = Verdict::Fail;
            claim.reason.clone_from(&why);
            claim.observed.clone_from(&why);
            record.reason = why;
        }
    }
    record.verdict = claim.verdict;
    record.claims.push(claim);
}
