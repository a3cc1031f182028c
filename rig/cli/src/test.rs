//! `rig test`.

use crate::args::{ClockChoice, TestArgs};
use crate::exit::Exit;
use crate::library::{self, Embedded};
use crate::select::{Facts, Selection};
use crate::{output, provenance};
use document::SourceFile;
use drivers::file::BoardFile;
use record::{CaseRecord, RunRecord, Verdict};
use reports::text::{Style, case_line, details, summary};
use runtime::suite::{self, Disk, Done, Files, Job, LoadedPlan};
use runtime::{ClockKind, RunOptions};
use signal::Trace;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

/// Set by the signal handler: the running cases end with their outputs safe.
static INTERRUPT: AtomicBool = AtomicBool::new(false);

/// Runs plans.
pub fn run(args: &TestArgs) -> Exit {
    let mut sources = Vec::new();
    let loaded = match load(args, &mut sources) {
        Ok(loaded) => loaded,
        Err(exit) => return exit,
    };
    let jobs = match select(args, &loaded) {
        Ok(jobs) => jobs,
        Err(exit) => return exit,
    };
    if args.list {
        list(&loaded, &jobs);
        return Exit::Passed;
    }
    if let Err(error) = ctrlc::set_handler(|| INTERRUPT.store(true, Ordering::Relaxed)) {
        output::complain(&format!("interrupts cannot be caught: {error}"));
        return Exit::Error;
    }
    execute(args, &loaded, &jobs, &sources)
}

/// Plans with everything that they name.
fn load(args: &TestArgs, sources: &mut Vec<SourceFile>) -> Result<Vec<LoadedPlan>, Exit> {
    let parameters = parameters(&args.params)?;
    let board: Option<(BoardFile, String)> = match &args.board {
        None => None,
        Some(path) => match suite::load_board(&Disk, &path.to_string_lossy(), sources) {
            Ok(board) => Some(board),
            Err(found) => {
                output::findings(&found, sources);
                return Err(Exit::UserFiles);
            }
        },
    };
    let shipped = args.plans.is_empty();
    let files: &dyn Files = if shipped { &Embedded } else { &Disk };
    let paths = if shipped { library::plans() } else { find(&args.plans)? };
    let mut loaded = Vec::new();
    let mut wrong = false;
    for path in &paths {
        // A parameter may belong to one plan of several: only those that no plan has are an error.
        match suite::load_plan(files, path, board.as_ref(), &parameters, args.seed, sources) {
            Ok(plan) => {
                output::findings(&plan.plan.warnings, sources);
                loaded.push(plan);
            }
            Err(found) => {
                output::findings(&found, sources);
                wrong = true;
            }
        }
    }
    if wrong { Err(Exit::UserFiles) } else { Ok(loaded) }
}

/// `K=V` of the command line.
pub fn parameters(given: &[String]) -> Result<Vec<(String, String)>, Exit> {
    let split = |text: &String| text.split_once('=').map(|(name, value)| (name.to_owned(), value.to_owned()));
    given
        .iter()
        .map(|text| {
            split(text).ok_or_else(|| {
                output::complain(&format!("--param {text}: write it as NAME=VALUE"));
                Exit::UserFiles
            })
        })
        .collect()
}

/// Plan files of paths: files as given, folders searched in the order of names.
pub fn find(paths: &[PathBuf]) -> Result<Vec<String>, Exit> {
    let mut found = Vec::new();
    for path in paths {
        if path.is_dir() {
            let before = found.len();
            search(path, 0, &mut found);
            if found.len() == before {
                output::complain(&format!("{} holds no plan", path.display()));
                return Err(Exit::UserFiles);
            }
        } else {
            found.push(path.to_string_lossy().into_owned());
        }
    }
    Ok(found)
}

fn search(folder: &Path, depth: usize, found: &mut Vec<String>) {
    // Deeper than any project; ends circles of links.
    if depth > 32 {
        return;
    }
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            search(&path, depth + 1, found);
        } else if std::fs::read_to_string(&path).is_ok_and(|text| is_plan_of_folder(&path, &text)) {
            found.push(path.to_string_lossy().into_owned());
        }
    }
}

/// In a folder of a user's project other TOML files stand about: a plan says its format.
fn is_plan_of_folder(path: &Path, text: &str) -> bool {
    library::is_plan(path, text)
        && text.lines().any(|line| line.trim_start().starts_with("format") && line.contains('='))
}

fn select(args: &TestArgs, loaded: &[LoadedPlan]) -> Result<Vec<Job>, Exit> {
    let selection = match &args.only {
        None => Selection::All,
        Some(expression) => Selection::parse(expression).map_err(|error| {
            output::complain(&format!("--only {expression}: {error}"));
            Exit::UserFiles
        })?,
    };
    let mut jobs = Vec::new();
    for (place, plan) in loaded.iter().enumerate() {
        jobs.extend(plan.jobs(place, args.seed, args.repeat.get()).into_iter().filter(|job| {
            let plan = &plan.plan;
            let profile = job.profile.name();
            selection.matches(&Facts { name: &job.name, title: &plan.title, proves: &plan.proves, profile })
        }));
    }
    if jobs.is_empty() {
        output::complain("no case is selected");
        return Err(Exit::UserFiles);
    }
    let mut names: Vec<&str> = jobs.iter().map(|job| job.name.as_str()).collect();
    names.sort_unstable();
    if let Some(twice) = names.windows(2).find(|pair| pair[0] == pair[1]) {
        output::complain(&format!("two cases have the name {}: a plan is given twice", twice[0]));
        return Err(Exit::UserFiles);
    }
    Ok(jobs)
}

fn list(loaded: &[LoadedPlan], jobs: &[Job]) {
    for job in jobs {
        output::print(&format!("{}  {}\n", job.name, loaded[job.plan].plan.title));
    }
}

fn execute(args: &TestArgs, loaded: &[LoadedPlan], jobs: &[Job], sources: &[SourceFile]) -> Exit {
    let (kind, clock) = match args.clock {
        ClockChoice::Virtual => (ClockKind::Virtual, record::Clock::Virtual),
        ClockChoice::Real => (ClockKind::Real, record::Clock::Real),
    };
    let mut run = RunRecord::new(env!("CARGO_PKG_VERSION"), provenance::now(args.seed, clock));
    let mut store = match args.report.as_deref().map(Store::new).transpose() {
        Ok(store) => store,
        Err(error) => {
            output::complain(&error);
            return Exit::UserFiles;
        }
    };
    let options = RunOptions { fail_fast: args.fail_fast, ..RunOptions::new(kind, &INTERRUPT) };
    // On the host's clock cases would make each other late.
    let at_once = match args.clock {
        ClockChoice::Real => 1,
        ClockChoice::Virtual => {
            args.jobs.map_or_else(|| std::thread::available_parallelism().map_or(1, usize::from), usize::from)
        }
    };
    let style = Style { color: output::color_out(), quiet: false };
    let mut wrong_files = false;
    let mut trouble = None;
    suite::run(loaded, jobs, at_once, args.fail_fast, &options, &mut |place, done| {
        let (record, trace) = match done {
            Done::Case(result) => (result.record, result.trace),
            Done::Skipped(record) => (*record, None),
            Done::Findings(found) => {
                output::findings(&found, sources);
                wrong_files = true;
                let mut record = CaseRecord { name: jobs[place].name.clone(), ..CaseRecord::default() };
                record.plan.clone_from(&loaded[jobs[place].plan].plan.path);
                record.title.clone_from(&loaded[jobs[place].plan].plan.title);
                record.verdict = Verdict::Error;
                record.reason = found.first().map_or_else(String::new, |first| first.message.clone());
                (record, None)
            }
        };
        run.push(record);
        if let Some(record) = run.cases.last_mut() {
            if let (Some(store), Some(trace)) = (&mut store, &trace) {
                match store.trace(record, trace) {
                    Ok(path) => record.trace_file = Some(path),
                    Err(error) => trouble = Some(error),
                }
            }
            output::print(&format!("{}\n", case_line(record, style).trim_end()));
            let more = details(record, style);
            if record.verdict > Verdict::Pass && !more.is_empty() {
                output::print(&format!("{}\n", more.trim_end()));
            }
        }
    });
    output::print(&format!("{}\n", summary(&run, style).trim_end()));
    if let Some(store) = &store {
        match store.reports(&run) {
            Ok(page) => output::print(&format!("Report: {page}\n")),
            Err(error) => trouble = Some(error),
        }
    }
    if let Some(error) = trouble {
        output::complain(&error);
        return Exit::Error;
    }
    if INTERRUPT.load(Ordering::Relaxed) {
        return Exit::Interrupted;
    }
    if wrong_files { Exit::UserFiles } else { Exit::of(run.verdict()) }
}

/// The folder of a run's reports.
struct Store {
    folder: PathBuf,
}

impl Store {
    fn new(folder: &Path) -> Result<Store, String> {
        let traces = folder.join("traces");
        std::fs::create_dir_all(&traces).map_err(|error| format!("{} cannot be made: {error}", traces.display()))?;
        Ok(Store { folder: folder.to_owned() })
    }

    /// Keeps a trace, as the rig's own file and as VCD; returns its path relative to the record.
    fn trace(&mut self, record: &CaseRecord, trace: &Trace) -> Result<String, String> {
        let name: String = record
            .name
            .chars()
            .map(|c| if c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.' | '[' | ']' | '=' | '@') { c } else { '_' })
            .collect();
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
    fn reports(&self, run: &RunRecord) -> Result<String, String> {
        let text = |path: &str, text: &str| {
            self.write(path, &mut |out| {
                out.write_all(text.as_bytes()).map_err(|error| format!("{path} cannot be written: {error}"))
            })
        };
        text("record.json", &run.to_json())?;
        text("junit.xml", &reports::junit::render(run))?;
        let page = reports::html::render(run).map_err(|error| format!("the page cannot be drawn: {error}"))?;
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
