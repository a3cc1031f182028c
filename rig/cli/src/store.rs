//! The folder of a run's reports.

use record::{CaseRecord, RunRecord};
use signal::Trace;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Longest name of a trace file without its ending; file systems take 255 bytes.
const LONGEST_NAME: usize = 180;

/// The folder.
#[derive(Debug)]
pub struct Store {
    folder: PathBuf,
    /// Names of trace files that are taken.
    names: BTreeSet<String>,
}

impl Store {
    /// Makes the folder.
    pub fn new(folder: &Path) -> Result<Store, String> {
        let traces = folder.join("traces");
        std::fs::create_dir_all(&traces)
            .map_err(|error| format!("{} cannot be made: {error}", traces.display()))?;
        Ok(Store { folder: folder.to_owned(), names: BTreeSet::new() })
    }

    /// Keeps a trace, as the rig's own file and as VCD; returns its path relative to the record.
    pub fn trace(&mut self, record: &CaseRecord, trace: &Trace) -> Result<String, String> {
        let mut name = file_name(&record.name);
        if !self.names.insert(name.clone()) {
            name = distinct(&name, &record.name);
            self.names.insert(name.clone());
        }
        let path = format!("traces/{name}.trace");
        let fail = |error: &dyn std::fmt::Display| format!("{path} cannot be written: {error}");
        self.write(&path, &mut |out| trace.save(out).map_err(|error| fail(&error)))?;
        let waves = format!("traces/{name}.vcd");
        self.write(&waves, &mut |out| {
            reports::vcd::write_trace(trace, env!("CARGO_PKG_VERSION"), out).map_err(|error| fail(&error))
        })?;
        Ok(path)
    }

    /// Writes record and reports; returns the path of the page.
    pub fn reports(&self, run: &RunRecord) -> Result<String, String> {
        let text = |path: &str, text: &str| {
            self.write(path, &mut |out| {
                out.write_all(text.as_bytes()).map_err(|error| format!("{path} cannot be written: {error}"))
            })
        };
        text("record.json", &run.to_json())?;
        text("junit.xml", &reports::junit::render(run))?;
        let page =
            reports::html::render(run).map_err(|error| format!("the page cannot be drawn: {error}"))?;
        text("index.html", &page)?;
        Ok(self.folder.join("index.html").display().to_string())
    }

    /// Writes a file whole or not at all: a report half written is never found.
    fn write(
        &self,
        path: &str,
        fill: &mut dyn FnMut(&mut dyn std::io::Write) -> Result<(), String>,
    ) -> Result<(), String> {
        let path = self.folder.join(path);
        let fail = |error: std::io::Error| format!("{} cannot be written: {error}", path.display());
        let mut file = atomic_write_file::AtomicWriteFile::open(&path).map_err(fail)?;
        {
            let mut buffered = std::io::BufWriter::new(&mut file);
            fill(&mut buffered)?;
            std::io::Write::flush(&mut buffered).map_err(fail)?;
        }
        file.commit().map_err(fail)
    }
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
    let hash = runtime::describe::sha256(case.as_bytes());
    format!("{}-{}", &name[start..], &hash[..16])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_case_has_a_file_of_its_own() {
        let folder = tempfile::tempdir().unwrap();
        let mut store = Store::new(folder.path()).unwrap();
        let long = format!("{}[row]", "long/".repeat(100));
        let names = ["a/b", "a_b", "a b", "../a/b", "x[cut=0.37 ms]#2", long.as_str(), "/"];
        let mut paths = BTreeSet::new();
        for name in names {
            let record = CaseRecord { name: name.to_owned(), ..CaseRecord::default() };
            let path = store.trace(&record, &Trace::new()).unwrap();
            assert!(folder.path().join(&path).is_file());
            assert!(!path.contains("/.") && path.len() < 250, "{path}");
            paths.insert(path);
        }
        assert_eq!(paths.len(), names.len());
        assert!(paths.contains("traces/a_b.trace") && paths.contains("traces/x[cut=0.37_ms]#2.trace"));
    }
}
