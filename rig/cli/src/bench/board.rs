//! A board file for a measurement.

use super::INTERRUPT;
use crate::bench_lock::BenchLockArgs;
use crate::exit::ExitStatus;
use crate::output;
use document::{Diagnostic, SourceFile};
use drivers::BoardFile;
use host::Refused;
use runtime::Hardware;
use runtime::suite::{self, Disk};
use std::path::Path;

/// Reads a board file and opens its real lines, as a run does.
///
/// # Errors
/// The exit of the command, when the reason was shown.
pub fn open(path: &Path, wait: &BenchLockArgs) -> Result<(BoardFile, Hardware), ExitStatus> {
    let mut sources: Vec<SourceFile> = Vec::new();
    let shown = |found: &[Diagnostic], sources: &[SourceFile]| {
        output::findings(found, sources);
        ExitStatus::UserFiles
    };
    let (file, _) = suite::load_board(&Disk, &path.to_string_lossy(), &mut sources)
        .map_err(|found| shown(&found, &sources))?;
    let lock = wait.take(&file, &INTERRUPT)?;
    let hardware = Hardware::open(&file).map_err(|found| shown(&found, &sources))?;
    let Some(hardware) = hardware.map(|hardware| hardware.with_lock(lock)) else {
        let message = format!("`{}` has no real lines: there is nothing to measure", path.display());
        let found = Diagnostic::error("R0253", message).help("name the file of a board of `kind = \"real\"`");
        return Err(shown(&[found], &[]));
    };
    // That earlier figures are no good any more is no news to whoever measures new ones.
    let old = &hardware.standing().warnings;
    let warnings = hardware.warnings();
    let warnings: Vec<Diagnostic> = warnings.into_iter().filter(|found| !old.contains(found)).collect();
    output::findings(&warnings, &sources);
    Ok((file, hardware))
}

/// How it is measured, for the figures that are kept.
pub fn settings(hardware: &Hardware) -> Vec<(String, String)> {
    let old = &hardware.standing().facts;
    hardware.facts().into_iter().filter(|fact| !old.contains(fact)).collect()
}

/// Says what the kernel refused.
pub fn note(refused: &Refused) {
    output::note(&format!("{refused}; `rig doctor` has the line to type"));
}
