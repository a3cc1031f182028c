//! `rig run`: the modelled controller kept running on a board.

use crate::exit::ExitStatus;
use crate::output;
use crate::plan_files::library::ShippedFiles;
use control_socket::{ControlArgs, HostPlans, serve};
use service_manager::ServiceNotifier;
mod control_socket;
mod service_manager;

use crate::bench_lock::BenchLockArgs;
use clap::Args;
use document::{Diagnostic, SourceFile};
use drivers::BoardFile;
use runtime::hardware::Hardware;
use runtime::live;
use runtime::soft_plc::{self, SoftPlcEvent, SoftPlcReport, SoftPlcSettings};
use runtime::suite::{self, Disk, FileSource};
use runtime::{CaseFiles, ClockKind, LoopCounter, RunOptions};
use serde_json::Value as Json;
use signal::{Span, Time};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver};
use std::sync::{Arc, Mutex};

/// Set by the signal handler: the controller stops with its outputs safe.
static INTERRUPT: AtomicBool = AtomicBool::new(false);

/// Counts the executor's turns: the service manager is notified as long as they go on.
static TURNS: LoopCounter = LoopCounter::new();

/// How long an interrupt takes at most to be seen where nothing happens.
const SLICE: Span = Span::from_millis(50);

/// The same where lines are modelled and no event ends a wait: the delay of a client's request.
const MODELLED: Span = Span::from_millis(10);

/// Lines that wait to be printed.
const WAITING: usize = 1_024;

/// What the case of a program without a plan is called.
const NAME: &str = "rig-run";

/// `rig run`.
#[derive(Debug, Args)]
pub struct RunArgs {
    /// The board file that the controller runs on.
    #[arg(long, value_name = "FILE")]
    board: PathBuf,
    /// Structured Text files of its application.
    #[arg(long, value_name = "FILE", num_args = 1.., required_unless_present = "case", conflicts_with = "case")]
    program: Vec<PathBuf>,
    /// The program and the settings of this case, of a plan on disk or of one that ships, by its name as `rig test
    /// --list` has it.
    #[arg(long, value_name = "PLAN[CASE]")]
    case: Option<String>,
    /// How long to run; until it is interrupted if left out.
    #[arg(long = "for", value_name = "TIME")]
    duration: Option<String>,
    /// Skip the time of the first boot.
    #[arg(long)]
    booted: bool,
    /// What it does while another run uses the lines.
    #[command(flatten)]
    wait: BenchLockArgs,
    /// The seed of all random choices.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// End when standard input does: with the program that holds its other end, however that ends.
    #[arg(long, hide = true)]
    until_input_ends: bool,
    /// How clients operate it.
    #[command(flatten)]
    control: ControlArgs,
}

/// Keeps a controller running.
pub fn run(args: &RunArgs) -> ExitStatus {
    if let Err(error) = output::never_wait() {
        output::error(&format!("the rig's threads cannot be started: {error}"));
        return ExitStatus::Error;
    }
    let mut sources = Vec::new();
    try_run(args, &mut sources).unwrap_or_else(|found| {
        output::findings(&found, &sources);
        ExitStatus::UserFiles
    })
}

fn try_run(args: &RunArgs, sources: &mut Vec<SourceFile>) -> Result<ExitStatus, Vec<Diagnostic>> {
    let lasts = args.duration.as_deref().map(duration).transpose().map_err(|found| vec![found])?;
    let stepped = args.control.is_stepped().map_err(|found| vec![found])?;
    let board = suite::load_board(&Disk, &args.board.to_string_lossy(), sources)?;
    output::findings(&board.0.warnings, sources);
    if board.0.subject.is_external() {
        return Err(vec![soft_plc::real_controller(&board.0)]);
    }
    let (case, files) = case(args, &board, sources)?;
    let notifier = ServiceNotifier::start(&TURNS).map_err(|found| vec![found])?;
    let handle = notifier.handle();
    let interrupted = move || {
        INTERRUPT.store(true, Ordering::Relaxed);
        if let Some(handle) = &handle {
            handle.stopping();
        }
    };
    if let Err(error) = ctrlc::set_handler(interrupted.clone()) {
        output::error(&format!("interrupts cannot be caught: {error}"));
        return Ok(ExitStatus::Error);
    }
    if args.until_input_ends {
        // Not joined: the input may have no end before the rig.
        std::thread::spawn(move || {
            // One that cannot be read has ended.
            let _ = std::io::copy(&mut std::io::stdin(), &mut std::io::sink());
            interrupted();
        });
    }
    let lock = match args.wait.take(&board.0, &INTERRUPT) {
        Ok(lock) => lock,
        Err(exit) => return Ok(exit),
    };
    let hardware = Hardware::open(&board.0)?.map(|hardware| hardware.with_lock(lock));
    output::findings(&hardware.as_ref().map(Hardware::warnings).unwrap_or_default(), sources);
    let plans = live::PlanBench { source: Arc::new(HostPlans), board: board.clone(), seed: args.seed };
    let (rig, port, slot) = live::open(
        &case,
        &files,
        hardware.as_ref(),
        stepped,
        env!("CARGO_PKG_VERSION"),
        Some(plans),
        &INTERRUPT,
    )?;
    let serving = serve(&args.control, &board.0, rig).map_err(|found| vec![found])?;
    let port = Mutex::new(port);
    let options = RunOptions {
        slice: if hardware.is_some() { SLICE } else { MODELLED },
        hardware: hardware.as_ref(),
        loop_counter: Some(&TURNS),
        live: serving.is_some().then_some(&port),
        ..RunOptions::new(if stepped { ClockKind::Virtual } else { ClockKind::Real }, &INTERRUPT)
    };
    let settings = SoftPlcSettings { duration: lasts, booted: args.booted };
    let (sender, events) = mpsc::sync_channel(WAITING);
    let played = std::thread::scope(|scope| {
        let controller = scope.spawn(|| {
            let sender = sender;
            live::run_with_plans(&case, &files, &options, settings, &slot, &sender)
        });
        show(&events, &notifier);
        controller.join()
    });
    if let Some(serving) = serving {
        serving.end("the rig ends");
    }
    match played {
        Ok(played) => Ok(end(&played?, hardware.is_some(), &notifier)),
        Err(_) => {
            // The panic has printed its words.
            Ok(ExitStatus::Error)
        }
    }
}

fn duration(text: &str) -> Result<Span, Diagnostic> {
    match Span::parse(text) {
        Ok(span) if span > Span::ZERO => Ok(span),
        _ => {
            let found = Diagnostic::error("R0222", format!("`--for {text}` is not a duration above 0"));
            Err(found.help("write one such as \"--for 10s\" or \"--for '1 h 30 min'\""))
        }
    }
}

/// A plan that names a program and nothing else.
struct ProgramOnlyPlan(String);

impl FileSource for ProgramOnlyPlan {
    fn read(&self, path: &str) -> Result<String, String> {
        if path == format!("{NAME}.toml") { Ok(self.0.clone()) } else { Disk.read(path) }
    }

    fn bytes(&self, path: &str) -> Result<Vec<u8>, String> {
        if path == format!("{NAME}.toml") { Ok(self.0.clone().into_bytes()) } else { Disk.bytes(path) }
    }
}

/// The case whose program and settings the controller gets.
fn case(
    args: &RunArgs,
    board: &(BoardFile, String),
    sources: &mut Vec<SourceFile>,
) -> Result<(plans::Case, CaseFiles), Vec<Diagnostic>> {
    let program_only;
    let (files, name): (&dyn FileSource, &str) = match &args.case {
        Some(name) if Disk.has(&path(name)) => (&Disk, name),
        Some(name) => (&ShippedFiles, name),
        None => {
            // The plan is none of the user's: a file that is missing is an argument here.
            for path in &args.program {
                suite::load_program(&Disk, &path.to_string_lossy()).map_err(|found| vec![found])?;
            }
            // A text of JSON is one of TOML.
            let names = args.program.iter().map(|path| Json::from(path.to_string_lossy()).to_string());
            let names: Vec<String> = names.collect();
            // A plan claims something; nobody judges it here.
            let claim = "expect = [{ state = { stays = \"RUNNING\" } }]";
            program_only = ProgramOnlyPlan(format!(
                "format = 1\ntitle = \"{NAME}\"\nprogram = [{}]\n{claim}\n",
                names.join(", ")
            ));
            (&program_only, NAME)
        }
    };
    let loaded = suite::load_plan(files, &path(name), Some(board), &[], args.seed, sources)?;
    let job = loaded.jobs(0, args.seed, 1).into_iter().find(|job| job.name == name);
    let found = job.map(|job| (loaded.plan.case_with(job.case, job.seed), job));
    let Some((case, job)) = found else {
        let names = loaded.jobs(0, args.seed, 1).into_iter().map(|job| job.name).collect::<Vec<_>>();
        let help = match document::suggest(name, names.iter().map(String::as_str)) {
            Some(meant) => format!("did you mean `{meant}`?"),
            None => format!("its cases are {}", names.iter().take(8).cloned().collect::<Vec<_>>().join(", ")),
        };
        let message = format!("the plan {} has no case `{name}`", path(name));
        return Err(vec![Diagnostic::error("R0223", message).help(help)]);
    };
    let case = case?;
    let files = loaded.files(&case, &job)?;
    Ok((case, files))
}

/// The path of the plan of a case.
fn path(case: &str) -> String {
    let plan = case.split('[').next().unwrap_or(case);
    format!("{}.toml", plan.strip_suffix(".toml").unwrap_or(plan))
}

/// An instant in seconds since the beginning.
fn seconds(at: Time) -> f64 {
    (at - Time::ZERO).as_nanos() as f64 / 1e9
}

/// Prints what the controller reports until it ends.
fn show(events: &Receiver<SoftPlcEvent>, notifier: &ServiceNotifier) {
    let line = |at: Time, text: &str| output::print(&format!("{:>12.3} s  {text}\n", seconds(at)));
    for event in events {
        match event {
            SoftPlcEvent::Ready => {
                line(Time::ZERO, "ready");
                notifier.ready();
            }
            SoftPlcEvent::State(at, state) => {
                line(at, state.name());
                notifier.status(state.name());
            }
            SoftPlcEvent::Log(at, text) => line(at, &format!("  {text}")),
        }
    }
}

/// Prints the summary, and returns how the command ends: an interrupt is how a controller that is kept running stops. How late
/// outputs were is known of `real` lines alone, which report when they changed.
fn end(played: &SoftPlcReport, real: bool, notifier: &ServiceNotifier) -> ExitStatus {
    let lasted = seconds(played.report.closed);
    let milliseconds = |span: Span| span.as_nanos() as f64 / 1e6;
    let late = milliseconds(played.late);
    let outputs = match real {
        true => format!(", outputs by {:.3} ms", milliseconds(played.report.late_outputs)),
        false => String::new(),
    };
    output::info(&format!(
        "stopped after {lasted:.3} s, outputs safe; late by {late:.3} ms at worst{outputs}"
    ));
    if let Some(wakes) = &played.report.wakes {
        let (half, most) = (wakes.p50_ns as f64 / 1e3, wakes.p99_ns as f64 / 1e3);
        output::info(&format!(
            "woken up {} times: half within {half:.1} us, 99 of 100 within {most:.1} us",
            wakes.count
        ));
    }
    for (name, _, figures) in &played.tasks {
        output::info(&format!("{name}: {} cycles, the longest {}", figures.cycles, figures.max));
    }
    match &played.fault {
        Some(fault) => {
            let help = "`rig board check` says whether the devices of the board can be had, `dmesg` what became of one";
            output::findings(&[Diagnostic::error("R0342", fault.as_str()).help(help)], &[]);
            notifier.status(fault);
            ExitStatus::Error
        }
        None => ExitStatus::Passed,
    }
}
