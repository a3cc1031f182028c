//! Traces that a record names: found, checked, drawn as waves.

use crate::output;
use crate::saved_runs::SavedRun;
use crate::saved_runs::report_folder::ReportFolder;
use document::Diagnostic;
use record::CaseRecord;
use signal::{LoadLimits, Trace};
use std::io::BufReader;
use std::path::{Component, Path, PathBuf};

/// The most cases that are named in a finding about their traces.
const NAMED: usize = 5;

/// Draws the waves of all traces of a run; into another folder than its own the traces are copied, too. Without
/// `asked` a trace that is not there is only noted: whoever keeps the record alone wants the other reports.
///
/// # Errors
/// Traces that are not there or not those that the record names; a folder that cannot be written.
pub(super) fn draw(
    run: &mut SavedRun,
    store: &mut ReportFolder,
    own: bool,
    asked: bool,
) -> Result<(), Vec<Diagnostic>> {
    let mut lost = Vec::new();
    if run.record.cases.iter().any(|case| case.trace_file.is_some()) {
        store.traces().map_err(super::unwritten)?;
    }
    for case in &mut run.record.cases {
        let Some(file) = case.trace_file.clone() else { continue };
        let trace = match load(&run.folder, case) {
            Ok(trace) => trace,
            Err(why) => {
                lost.push(format!("{}: {why}", case.name));
                continue;
            }
        };
        if own {
            store.waves(&file, &trace).map_err(super::unwritten)?;
        } else {
            let from = path(&run.folder, case).map_err(super::unwritten)?;
            let path = store.trace(case, &trace, true).map_err(super::unwritten)?;
            store.adopt_frames(&path, &from).map_err(super::unwritten)?;
            case.trace_file = Some(path);
        }
    }
    match finding(&lost) {
        Some(found) if asked => Err(vec![found]),
        Some(found) => {
            output::note(&format!("{}; no waves are drawn of them", found.message));
            Ok(())
        }
        None => Ok(()),
    }
}

/// What is to be said of traces that are lost.
pub(super) fn finding(lost: &[String]) -> Option<Diagnostic> {
    if lost.is_empty() {
        return None;
    }
    let named = lost[..lost.len().min(NAMED)].join("; ");
    let more = if lost.len() > NAMED { "; and others" } else { "" };
    let message = format!("{} of the traces cannot be taken: {named}{more}", lost.len());
    Some(Diagnostic::error("R0166", message).help("keep the folder `traces` beside `record.json`"))
}

/// The trace of a case, as the record names it.
///
/// # Errors
/// Why it is not that trace.
fn load(folder: &Path, case: &CaseRecord) -> Result<Trace, String> {
    let path = path(folder, case)?;
    let mut file =
        BufReader::new(document::file::open(&path).map_err(|fault| format!("{}: {fault}", path.display()))?);
    let trace = Trace::load(&mut file, LoadLimits::default())
        .map_err(|error| format!("{} is not a complete trace: {error}", path.display()))?;
    if runtime::suite::describe::hex(&trace.digest()) != case.trace_sha256 {
        return Err(format!("{} is another trace than the record names", path.display()));
    }
    Ok(trace)
}

/// Where the trace of a case is: in the run's folder and nowhere else, whatever the record says.
///
/// # Errors
/// The path of the record leads elsewhere.
pub(super) fn path(folder: &Path, case: &CaseRecord) -> Result<PathBuf, String> {
    let named = Path::new(case.trace_file.as_deref().unwrap_or_default());
    if named.components().all(|part| matches!(part, Component::Normal(_)))
        && named.extension().is_some_and(|e| e == "trace")
    {
        Ok(folder.join(named))
    } else {
        Err(format!("`{}` is not a path within the run's folder", named.display()))
    }
}
