//! The folder of a run's reports.

use crate::files::{write_whole, write_whole_unsynced};
use clap::ValueEnum;
use record::{CaseRecord, RunRecord};
use signal::Trace;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Longest name of a trace file without its ending; file systems take 255 bytes.
const LONGEST_NAME: usize = 180;

/// A report that is drawn from the record.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ReportFormat {
    /// `index.html`: the page for a person.
    Html,
    /// `junit.xml`: for a CI server.
    Junit,
    /// `ctrf.json`: the Common Test Report Format.
    Ctrf,
    /// `summary.md`: Markdown for a merge request.
    Md,
    /// `measurements.csv` and `claims.csv`: for a spreadsheet.
    Csv,
    /// `traces/*.vcd`: waves of the recorded traces.
    Vcd,
}

/// The folder.
#[derive(Debug)]
pub struct ReportFolder {
    folder: PathBuf,
    /// Names of trace files that are taken.
    names: BTreeSet<String>,
}

impl ReportFolder {
    /// Makes the folder with a place for traces.
    ///
    /// # Errors
    /// Why it cannot be made.
    pub fn new(folder: &Path) -> Result<ReportFolder, String> {
        let store = ReportFolder::without_traces(folder)?;
        store.traces()?;
        Ok(store)
    }

    /// Makes the folder.
    ///
    /// # Errors
    /// Why it cannot be made.
    pub fn without_traces(folder: &Path) -> Result<ReportFolder, String> {
        make(folder)?;
        Ok(ReportFolder { folder: folder.to_owned(), names: BTreeSet::new() })
    }

    /// Makes the place for traces.
    ///
    /// # Errors
    /// Why it cannot be made.
    pub fn traces(&self) -> Result<(), String> {
        make(&self.folder.join("traces"))
    }

    /// Keeps a trace, as the rig's own file and with `waves` as VCD; returns its path relative to the record.
    ///
    /// # Errors
    /// Which file cannot be written, and why.
    pub fn trace(&mut self, record: &CaseRecord, trace: &Trace, waves: bool) -> Result<String, String> {
        let path = self.trace_path(&record.name);
        self.write_unsynced(&path, &mut |out| {
            trace.save(out).map_err(|error| format!("{path} cannot be written: {error}"))
        })?;
        if waves {
            self.waves(&path, trace)?;
        }
        Ok(path)
    }

    /// Keeps a copy of a trace that another run left, and of the waves beside it; returns its path relative to the
    /// record.
    ///
    /// # Errors
    /// Which file cannot be read or written, and why.
    pub fn adopt(&mut self, record: &CaseRecord, from: &Path) -> Result<String, String> {
        let path = self.trace_path(&record.name);
        self.copy(from, &path)?;
        let waves = from.with_extension("vcd");
        if waves.is_file() {
            self.copy(&waves, &beside(&path, "vcd"))?;
        }
        self.adopt_frames(&path, from)?;
        Ok(path)
    }

    fn copy(&self, from: &Path, to: &str) -> Result<(), String> {
        let fail = |error: std::io::Error| format!("{} cannot be copied: {error}", from.display());
        let mut file = document::file::open(from)
            .map_err(|fault| format!("{} cannot be copied: {fault}", from.display()))?;
        self.write_unsynced(to, &mut |out| std::io::copy(&mut file, out).map(drop).map_err(fail))
    }

    /// Writes the waves of a trace beside it.
    ///
    /// # Errors
    /// Which file cannot be written, and why.
    pub fn waves(&self, path: &str, trace: &Trace) -> Result<(), String> {
        let waves = beside(path, "vcd");
        self.write_unsynced(&waves, &mut |out| {
            reports::vcd::write_trace(trace, env!("CARGO_PKG_VERSION"), out)
                .map_err(|error| format!("{waves} cannot be written: {error}"))
        })
    }

    /// Writes CAN frames beside the trace that they belong to.
    ///
    /// # Errors
    /// Which file cannot be written, and why.
    pub fn frames(&self, path: &str, frames: &str) -> Result<(), String> {
        let path = beside(path, "log");
        self.write_unsynced(&path, &mut |out| {
            out.write_all(frames.as_bytes()).map_err(|error| format!("{path} cannot be written: {error}"))
        })
    }

    /// Copies the CAN frames beside a trace of another run to those beside a trace of this one.
    ///
    /// # Errors
    /// Which file cannot be read or written, and why.
    pub fn adopt_frames(&self, path: &str, from: &Path) -> Result<(), String> {
        let frames = from.with_extension("log");
        if frames.is_file() { self.copy(&frames, &beside(path, "log")) } else { Ok(()) }
    }

    /// The path that the trace of a case gets, which no other case has.
    fn trace_path(&mut self, case: &str) -> String {
        let mut name = file_name(case);
        if !self.names.insert(name.clone()) {
            name = distinct(&name, case);
            self.names.insert(name.clone());
        }
        format!("traces/{name}.trace")
    }

    /// Writes the record.
    ///
    /// # Errors
    /// Why it cannot be written.
    pub fn record(&self, run: &RunRecord) -> Result<(), String> {
        self.text("record.json", &run.to_json())
    }

    /// Draws reports of these forms; waves are [`ReportFolder::waves`]. The page, which takes as long as all others
    /// together, is drawn beside them.
    ///
    /// # Errors
    /// Which file cannot be written, and why.
    pub fn reports(&self, run: &RunRecord, forms: &[ReportFormat]) -> Result<(), String> {
        let (page, others): (Vec<_>, Vec<_>) =
            forms.iter().copied().partition(|form| *form == ReportFormat::Html);
        std::thread::scope(|scope| {
            let page = scope.spawn(|| self.each(run, &page));
            let others = self.each(run, &others);
            page.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)).and(others)
        })
    }

    fn each(&self, run: &RunRecord, forms: &[ReportFormat]) -> Result<(), String> {
        for form in forms {
            match form {
                ReportFormat::Html => {
                    let page = reports::html::render(run)
                        .map_err(|error| format!("the page cannot be drawn: {error}"))?;
                    self.text("index.html", &page)?;
                }
                ReportFormat::Junit => {
                    self.text("junit.xml", &reports::junit::render(run, &self.folder.to_string_lossy()))?;
                }
                ReportFormat::Ctrf => self.text("ctrf.json", &reports::ctrf::render(run))?,
                ReportFormat::Md => self.text("summary.md", &reports::markdown::render(run))?,
                ReportFormat::Csv => {
                    self.text("measurements.csv", &reports::csv::measurements(run))?;
                    self.text("claims.csv", &reports::csv::claims(run))?;
                }
                ReportFormat::Vcd => {}
            }
        }
        Ok(())
    }

    /// A file of the folder, as the user names it.
    pub fn path(&self, name: &str) -> String {
        self.folder.join(name).display().to_string()
    }

    fn text(&self, path: &str, text: &str) -> Result<(), String> {
        self.write(path, &mut |out| {
            out.write_all(text.as_bytes()).map_err(|error| format!("{path} cannot be written: {error}"))
        })
    }

    fn write(
        &self,
        path: &str,
        fill: &mut dyn FnMut(&mut dyn std::io::Write) -> Result<(), String>,
    ) -> Result<(), String> {
        write_whole(&self.folder.join(path), fill)
    }

    fn write_unsynced(
        &self,
        path: &str,
        fill: &mut dyn FnMut(&mut dyn std::io::Write) -> Result<(), String>,
    ) -> Result<(), String> {
        write_whole_unsynced(&self.folder.join(path), fill)
    }
}

/// A file of this ending beside a trace.
fn beside(path: &str, ending: &str) -> String {
    format!("{}.{ending}", path.strip_suffix(".trace").unwrap_or(path))
}

fn make(folder: &Path) -> Result<(), String> {
    std::fs::create_dir_all(folder).map_err(|error| format!("{} cannot be made: {error}", folder.display()))
}

/// A case's name as the name of a file.
fn file_name(case: &str) -> String {
    let plain = |c: char| {
        let keeps = c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.' | '[' | ']' | '=' | '@' | '#');
        if keeps { c } else { '_' }
    };
    // A leading point or underscore is what is left of an absolute path or of `../`.
    let name: String = case.trim_start_matches(['/', '.']).chars().map(plain).collect();
    if name.len() > LONGEST_NAME || name.is_empty() { distinct(&name, case) } else { name }
}

/// A name that no other case has: other characters of the cases' names may have become the same.
fn distinct(name: &str, case: &str) -> String {
    // What tells long names apart is at their end: the row, the point of the sweep.
    let start = name.len().saturating_sub(LONGEST_NAME - 20);
    let hash = runtime::suite::describe::sha256(case.as_bytes());
    format!("{}-{}", &name[start..], &hash[..16])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_case_has_a_file_of_its_own() {
        let folder = tempfile::tempdir().unwrap();
        let mut store = ReportFolder::new(folder.path()).unwrap();
        let long = format!("{}[row]", "long/".repeat(100));
        let names = ["a/b", "a_b", "a b", "../a/b", "x[cut=0.37 ms]#2", long.as_str(), "/"];
        let mut paths = BTreeSet::new();
        for name in names {
            let record = CaseRecord { name: name.to_owned(), ..CaseRecord::default() };
            let path = store.trace(&record, &Trace::new(), true).unwrap();
            assert!(folder.path().join(&path).is_file());
            assert!(!path.contains("/.") && path.len() < 250, "{path}");
            paths.insert(path);
        }
        assert_eq!(paths.len(), names.len());
        assert!(paths.contains("traces/a_b.trace") && paths.contains("traces/x[cut=0.37_ms]#2.trace"));
    }
}
