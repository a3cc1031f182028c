//! `rig test`.

use crate::args::{ClockChoice, TestArgs};
use crate::exit::Exit;
use crate::find::find;
use crate::library::{self, Embedded};
use crate::parameters::Parameters;
use crate::select::{Facts, Selection};
use crate::store::Store;
use crate::{output, provenance};
use document::SourceFile;
use drivers::file::BoardFile;
use record::{CaseRecord, RunRecord, Verdict};
use reports::text::{self, Style, case_line, details, summary};
use runtime::coverage::Total;
use runtime::suite::{self, Disk, Done, Files, Job, LoadedPlan};
use runtime::{ClockKind, RunOptions};
use signal::Span;
use std::sync::atomic::{AtomicBool, Ordering};

/// Set by the signal handler: the running cases end with their outputs safe.
static INTERRUPT: AtomicBool = AtomicBool::new(false);

/// Cases that a selection is made from.
const MOST_CASES: u64 = 10 * record::MAX_CASES as u64;

/// How long a run on the host's clock takes at most to see an interrupt.
const REAL_SLICE: Span = Span::from_millis(50);

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
        list(&jobs);
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
    let mut parameters = Parameters::read(&args.params)?;
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
        // What cannot be read is reported by the loading.
        let own = parameters.of_plan(&files.read(path).unwrap_or_default());
        match suite::load_plan(files, path, board.as_ref(), &own, args.seed, sources) {
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
    if wrong {
        return Err(Exit::UserFiles);
    }
    parameters.finish()?;
    Ok(loaded)
}

fn select(args: &TestArgs, loaded: &[LoadedPlan]) -> Result<Vec<Job>, Exit> {
    let selection = match &args.only {
        None => Selection::All,
        Some(expression) => Selection::parse(expression).map_err(|error| {
            output::complain(&format!("--only {expression}: {error}"));
            Exit::UserFiles
        })?,
    };
    // Those that are looked through, and those that run: each within what the memory and a record hold.
    let all: u64 = loaded.iter().map(|plan| plan.plan.len()).sum();
    if all.saturating_mul(u64::from(args.repeat.get())) > MOST_CASES {
        return Err(too_many());
    }
    let mut jobs = Vec::new();
    for (place, plan) in loaded.iter().enumerate() {
        jobs.extend(plan.jobs(place, args.seed, args.repeat.get()).into_iter().filter(|job| {
            let profile = job.profile.name();
            selection.matches(&Facts { name: &job.name, title: &job.title, proves: &job.proves, profile })
        }));
    }
    if jobs.is_empty() {
        output::complain("no case is selected");
        return Err(Exit::UserFiles);
    }
    if jobs.len() > record::MAX_CASES {
        return Err(too_many());
    }
    let mut names: Vec<&str> = jobs.iter().map(|job| job.name.as_str()).collect();
    names.sort_unstable();
    if let Some(twice) = names.windows(2).find(|pair| pair[0] == pair[1]) {
        output::complain(&format!("two cases have the name {}: a plan is given twice", twice[0]));
        return Err(Exit::UserFiles);
    }
    Ok(jobs)
}

fn too_many() -> Exit {
    output::complain(&format!(
        "more than {} cases: select fewer, or repeat them less often",
        record::MAX_CASES
    ));
    Exit::UserFiles
}

fn list(jobs: &[Job]) {
    for job in jobs {
        output::print(&format!("{}  {}\n", job.name, job.title));
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
    let mut options = RunOptions {
        fail_fast: args.fail_fast,
        coverage: args.coverage,
        ..RunOptions::new(kind, &INTERRUPT)
    };
    let mut coverage = Total::default();
    if args.clock == ClockChoice::Real {
        // Nothing may happen for minutes; an interrupt is not to wait for it.
        options.slice = REAL_SLICE;
    }
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
    suite::run(loaded, jobs, at_once.min(jobs.len()), args.fail_fast, &options, &mut |place, done| {
        let (record, trace) = match done {
            Done::Case(result) => {
                coverage.add(result.coverage);
                (result.record, result.trace)
            }
            Done::Skipped(record) => (*record, None),
            Done::Findings(found) => {
                output::findings(&found, sources);
                wrong_files = true;
                let mut record = CaseRecord { name: jobs[place].name.clone(), ..CaseRecord::default() };
                record.plan.clone_from(&loaded[jobs[place].plan].plan.path);
                record.title.clone_from(&jobs[place].title);
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
    run.coverage = coverage.record();
    if !run.coverage.is_empty() {
        output::print(&format!("\n{}\n", text::coverage(&run.coverage)));
    }
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
