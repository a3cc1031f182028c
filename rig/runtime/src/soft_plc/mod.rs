//! The model kept running on a board: a controller that the rig plays, for a machine or for another rig.
//!
//! It has the lines of a controller beside its terminals: a supply, a Run/Stop switch, and a line that is 1 in RUNNING.

mod subject;

use crate::case::configure::initial_state;
use crate::case::spill;
use crate::case::test_setup::{TestSetup, set_up};
use crate::case::{RunOptions, clock};
use crate::codes;
use crate::executor::recorder::Recorder;
use crate::executor::rig_fault::RigFault;
use crate::executor::{Executor, ExecutorLimits, ExecutorReport, Parts};
use crate::hardware::Hardware;
use crate::prepare::PreparedCase;
use crate::scan_port;
use crate::schedule::Schedule;
use crate::subject::SubjectExt;
use crate::suite::case_files::CaseFiles;
use crate::wiring::WiredInput;
use controller::{State, TaskFigures, Terminal};
use document::Diagnostic;
use drivers::{BoardFile, RealtimeSettings};
use plans::Case;
use plans::judge::CaseJudge;
use plans::lang::{Anchor, AnchorBase};
use signal::{Span, Time, Trace};
use std::sync::mpsc::SyncSender;
use subject::{SoftPlc, SoftPlcTerminals};

/// Longer than any rig is kept running: 100 years.
const AGES: Span = Span::from_secs(100 * 365 * 86_400);

/// How long a controller is kept running, and from where.
#[derive(Clone, Copy, Debug, Default)]
pub struct SoftPlcSettings {
    /// How long; until it is interrupted if nothing is said.
    pub duration: Option<Span>,
    /// Its first boot takes no time.
    pub booted: bool,
}

/// What a controller that runs reports to whoever watches it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SoftPlcEvent {
    /// The outputs are claimed, and the controller waits for its supply or boots.
    Ready,
    /// It has another state.
    State(Time, State),
    /// A line of its log.
    Log(Time, String),
}

/// How a controller that was kept running did.
#[derive(Debug)]
pub struct SoftPlcReport {
    /// What the executor says.
    pub report: ExecutorReport,
    /// How late the rig was at worst.
    pub late: Span,
    /// What its tasks did: name, interval, figures.
    pub tasks: Vec<(String, Span, TaskFigures)>,
    /// The fault of the rig, in words.
    pub fault: Option<String>,
}

/// Keeps the controller of a case running, with the case's program and settings and nothing else of it, until it is
/// interrupted or its time is over. What it has to report goes to `events`, which never keeps it waiting: what finds no room is
/// left out. Clients are served by the port of the options, if there is one.
///
/// # Errors
/// Findings in the user's files.
pub fn run(
    case: &Case,
    files: &CaseFiles,
    options: &RunOptions<'_>,
    settings: SoftPlcSettings,
    events: SyncSender<SoftPlcEvent>,
) -> Result<SoftPlcReport, Vec<Diagnostic>> {
    let case = bare(case, settings.duration);
    let mut stage = set_up(&case, files, None)?;
    let hardware = options.hardware.filter(|hardware| hardware.name() == files.board.name);
    if let Some(hardware) = hardware {
        stage.board = Box::new(hardware.lease());
    }
    let mut clock = clock(options.clock, files.seed, hardware);
    let trace = Trace::with_spill(options.trace_memory, spill::temporary());
    let PreparedCase { trace, mut wiring, .. } = stage.prepare(&case, files, trace, clock.is_exact())?;
    let TestSetup { subject, mut board, .. } = stage;
    let lines = files.board.lines;
    let places =
        SoftPlcTerminals { inputs: files.reference.input_count(), outputs: files.reference.output_count() };
    for (channel, input) in [(lines.power, places.power()), (lines.run_stop, places.run_stop())] {
        if let Some(channel) = channel {
            wiring.bind_input(
                channel,
                WiredInput { terminal: Terminal::input(input), analog: false, sensor: None },
            );
        }
    }
    if let Some(alarm) = lines.alarm {
        wiring.bind_output(Terminal::output(places.alarm()), alarm);
    }
    // Nothing is recorded: what is kept running for months takes no more memory than in its first minute.
    wiring.state = None;
    let mut subject = SoftPlc::new(subject, lines, places, initial_state(case.settings.initial), events);
    subject.quick = settings.booted;
    let judge = CaseJudge::new(case.scenario(), trace.signals())?;
    let mut recorder = Recorder::new(trace, judge);
    let mut schedule = Schedule::new(Vec::new(), case.ends.clone());
    let limits = ExecutorLimits {
        initial: State::Off,
        // Nobody judges it: how late it was is reported at the end.
        late: Span::MAX,
        slice: options.slice,
        horizon: hardware.map_or_else(RealtimeSettings::default, |hardware| *hardware.settings()).horizon,
        fail_fast: false,
        on_loss: files.board.on_loss,
        reconnect: files.board.reconnects(),
        timeout: case.timeout,
        teardown: case.teardown,
    };
    let parts = Parts {
        clock: &mut *clock,
        subject: &mut subject,
        board: &mut *board,
        recorder: &mut recorder,
        schedule: &mut schedule,
        wiring: &mut wiring,
        alarms: &mut Vec::new(),
        interrupt: options.interrupt,
        operator: None,
        heartbeat: hardware.and_then(Hardware::heartbeat),
        loop_counter: options.loop_counter,
    };
    let mut port = options.live.map(scan_port::lock);
    let executor = Executor::new(parts, limits).serving(port.as_deref_mut(), scan_port::ExecutorRole::Rig);
    let entered = hardware.map(Hardware::enter);
    let report = executor.run();
    drop(entered);
    drop(port);
    let fault = report.fault.as_ref().filter(|fault| **fault != RigFault::Interrupted);
    let fault = fault.map(|fault| fault.show(board.channels()).to_string());
    Ok(SoftPlcReport { late: recorder.late(), tasks: subject.figures(), fault, report })
}

/// A controller that is a real one is not kept running by the rig.
pub fn real_controller(board: &BoardFile) -> Diagnostic {
    let message = format!("the subject of `{}` is a real controller, which runs by itself", board.name);
    let help = "run plans on it with `rig test`, or name a board with kind = \"model\"";
    Diagnostic::error(codes::REAL_CONTROLLER, message).at(&board.name, 0..0, "").help(help)
}

/// A case without all that is done and claimed in it.
fn bare(case: &Case, lasts: Option<Span>) -> Case {
    let mut case = case.clone();
    case.signals.clear();
    case.unspoken.clear();
    case.steps.clear();
    case.expectations.clear();
    case.measurements.clear();
    case.invariants.clear();
    case.alarms.clear();
    case.ends = Anchor { base: AnchorBase::Start, offset: lasts.unwrap_or(AGES) };
    case.timeout = Span::MAX;
    case
}
