//! What a plan asks for that no line of the board reaches: such a case does not apply.

use crate::codes;
use crate::frames;
use crate::prepare::{fault_on, state_info};
use crate::subject::external::NOT_RUNNING;
use crate::suite::case_files::CaseFiles;
use crate::suite::describe::show_fault;
use controller::State;
use document::Diagnostic;
use drivers::{Board, BoardExt, FaultKind};
use plans::bench::is_same_for;
use plans::plan::InitialState;
use plans::signals::{SignalBinding, SignalSource};
use plans::steps::StepCondition;
use plans::steps::Stimulus;
use plans::{Case, PlanStep, StepTime, value_of};
use profile::IoChannel;
use signal::{SignalInfo, Value};
use std::ops::Range;

/// Errors in what a case says of the board that its own plan names: buses, and channels of a real controller, that this
/// board does not have. On a board that is given in its place such a case does not apply.
pub fn missing_of_own_board(case: &Case, files: &CaseFiles, board: &dyn Board) -> Vec<Diagnostic> {
    let mut found: Vec<Diagnostic> = Vec::new();
    if !files.own_board {
        return found;
    }
    let mut bus = |name: &str, at: &Range<usize>| {
        if let Some(reason) = frames::lacks(board, name)
            && found.iter().all(|known| known.message != reason)
        {
            let help = frames::known(board, name);
            found.push(
                Diagnostic::error(codes::NO_BUS, reason).at(&files.plan.name, at.clone(), "").help(help),
            );
        }
    };
    for binding in &case.signals {
        match &binding.source {
            SignalSource::Frames(pattern) => bus(&pattern.bus, &binding.span),
            SignalSource::FrameSignal(source) => bus(&source.pattern.bus, &binding.span),
            _ => {}
        }
    }
    for step in &case.steps {
        if let Stimulus::Send(send) = &step.stimulus {
            bus(&send.frame.bus, &step.span);
        }
    }
    for binding in case.signals.iter().filter(|_| files.board.subject.is_external()) {
        if let SignalSource::Channel(name) = &binding.source
            && board.find(name).is_none()
        {
            let names = board.channels().iter().map(|channel| channel.name.as_str());
            let help = document::suggest(name, names)
                .map_or_else(String::new, |meant| format!("did you mean `{meant}`?"));
            let message = format!("the board has no channel `{name}`");
            let one = Diagnostic::error(codes::NO_CHANNEL, message);
            found.push(one.at(&files.plan.name, binding.span.clone(), "").help(help));
        }
    }
    found
}

/// What a plan names of its own board and a board that is given in its place does not have: a channel or a plant.
fn missing_of_given_board(case: &Case, files: &CaseFiles, board: &dyn Board) -> Option<String> {
    if files.own_board || case.board.is_none() {
        return None;
    }
    let channel = case.signals.iter().find_map(|binding| match &binding.source {
        SignalSource::Channel(name) if board.find(name).is_none() => Some(format!("channel `{name}`")),
        _ => None,
    });
    let plants = &files.board.circuit.plants;
    let plant = || {
        case.steps.iter().find_map(|step| match &step.stimulus {
            Stimulus::SetPlant { plant, .. } if plants.iter().all(|known| known.name() != plant) => {
                Some(format!("plant `{plant}`"))
            }
            _ => None,
        })
    };
    channel.or_else(plant).map(|what| format!("the board has no {what}"))
}

/// Why a case does not apply to this controller on this board, if it does not.
pub fn not_applicable_reason(case: &Case, files: &CaseFiles, board: &dyn Board) -> Option<String> {
    if let Some(reason) = missing_of_given_board(case, files, board) {
        return Some(reason);
    }
    if let Some(reason) = case
        .signals
        .iter()
        .filter(|binding| !case.unspoken.contains(&binding.name))
        .find_map(|binding| unreachable_reason(binding, files, board))
    {
        return Some(reason);
    }
    let sends = case.steps.iter().find_map(|step| match &step.stimulus {
        Stimulus::Send(send) => frames::lacks(board, &send.frame.bus),
        _ => None,
    });
    if sends.is_some() {
        return sends;
    }
    if let Some(reason) = case.steps.iter().find_map(|step| missing_fault_reason(case, step, files, board)) {
        return Some(reason);
    }
    let external = files.board.subject.external.as_ref()?;
    if case.refusal.is_some() {
        return Some(String::from("what its check finds concerns the rig's own model"));
    }
    let settings = &case.settings;
    let lines = files.board.lines;
    if settings.firmware_invalid {
        return Some(String::from("a real controller has its firmware"));
    }
    if settings.switch_at_run == Some(false) && lines.run_stop.is_none() {
        return Some(String::from("the board names no `run-stop` line of the controller"));
    }
    match settings.initial {
        InitialState::Running => {}
        InitialState::Booting if lines.power.is_some() => {}
        InitialState::Booting => {
            return Some(String::from("the board names no `power` line of the controller"));
        }
        InitialState::Stopped | InitialState::Empty if !external.load.is_empty() => {}
        InitialState::Stopped => {
            return Some(String::from("nothing stops a real controller before the case"));
        }
        InitialState::Empty => {
            return Some(String::from("nothing empties a real controller before the case"));
        }
    }
    let state = state_info(&files.board);
    match (lines.alarm, needed(case, &state)) {
        (None, Some(_)) => {
            Some(String::from("the board names no `alarm` line that shows the controller's state"))
        }
        (Some(_), Some(StateNeed::Apart)) => Some(String::from(
            "an alarm line shows RUNNING and OFF, and does not tell the other states apart",
        )),
        (_, None) | (Some(_), Some(StateNeed::Running)) => None,
    }
}

/// Leaves out the signals that the plan does not speak of and that nothing reaches: they would only be recorded.
pub fn remove_unreachable_signals(case: &mut Case, files: &CaseFiles, board: &dyn Board) {
    let unspoken = std::mem::take(&mut case.unspoken);
    case.signals
        .retain(|one| !unspoken.contains(&one.name) || unreachable_reason(one, files, board).is_none());
    case.unspoken = unspoken;
}

/// Why a name is nothing that the rig can see, if that is so.
fn unreachable_reason(binding: &SignalBinding, files: &CaseFiles, board: &dyn Board) -> Option<String> {
    let external = files.board.subject.is_external();
    let has = |channel: &str| board.find(channel).is_some();
    match &binding.source {
        SignalSource::Line(address) if IoChannel::at(*address, files.reference).is_some() => {
            let bound = files.board.channel_of(*address).is_some();
            (!bound).then(|| format!("the board binds no channel to {address}"))
        }
        SignalSource::Line(_) => None,
        SignalSource::Frames(pattern) => frames::lacks(board, &pattern.bus),
        SignalSource::FrameSignal(source) => frames::lacks(board, &source.pattern.bus),
        SignalSource::Channel(name) if external && !has(name) => {
            Some(format!("the board has no channel `{name}`"))
        }
        SignalSource::Path(name) if external && !has(name) => {
            Some(format!("`{name}` cannot be seen from outside the controller"))
        }
        SignalSource::Channel(_) | SignalSource::Path(_) => None,
        // The others need powers of their own; where they are memory the plan may have said so in another way.
        SignalSource::Memory(_) | SignalSource::Image(_) if external => {
            Some(format!("`{}` cannot be seen from outside the controller", binding.name))
        }
        _ => None,
    }
}

/// Why the relays of a board of real lines cannot put a step's fault on its line, if that is so.
fn missing_fault_reason(
    case: &Case,
    step: &PlanStep,
    files: &CaseFiles,
    board: &dyn Board,
) -> Option<String> {
    let Stimulus::Fault { signal, kind, lasts } = &step.stimulus else { return None };
    let source = &case.signals.iter().find(|binding| binding.name == *signal)?.source;
    let id = match source {
        SignalSource::Line(address) => files.board.channel_of(*address)?,
        SignalSource::Channel(name) | SignalSource::Path(name) => board.find(name)?,
        _ => return None,
    };
    let channel = board.channels().get(usize::from(id.0)).filter(|_| files.board.is_real())?;
    // A value that does not fit is the plan's own trouble.
    let fault = fault_on(kind, channel)?;
    let (name, settle) = (&channel.name, board.fault_switching_time(id));
    if !channel.faults.contains(fault) {
        let what = show_fault(kind);
        return Some(format!("the board has no relay that brings the fault \"{what}\" about on `{name}`"));
    }
    let width = match fault {
        FaultKind::Glitch { width, .. } => Some(lasts.map_or(width, |lasts| lasts.min(width))),
        _ => *lasts,
    };
    width.filter(|width| *width < settle + settle).map(|width| {
        format!("the relays of `{name}` settle within {settle}: they cannot make a fault of {width}")
    })
}

/// What a case has to see of the controller's state.
enum StateNeed {
    /// Whether it runs.
    Running,
    /// Which of the states it has in which it does not run.
    Apart,
}

/// What the claims and steps of a case have to see of the controller's state, if anything.
fn needed(case: &Case, state: &SignalInfo) -> Option<StateNeed> {
    let numbers = State::ALL.iter().filter(|state| !matches!(state, State::Running | State::Off));
    let mut values: Vec<Value> = numbers.map(|state| Value::Int(state.number())).collect();
    values.push(Value::Int(NOT_RUNNING.0));
    let mut seen = false;
    let claims = case.expectations.iter().chain(case.invariants.iter().map(|guard| &guard.expectation));
    for expectation in claims {
        seen |= expectation.claim.signals().contains(&state.name);
        if !is_same_for(&*expectation.claim, state, &values) {
            return Some(StateNeed::Apart);
        }
    }
    for step in &case.steps {
        let StepTime::When { signal, awaits, .. } = &step.when else { continue };
        if *signal != state.name {
            continue;
        }
        seen = true;
        match awaits {
            StepCondition::Becomes(literal)
                if value_of(literal, state).is_ok_and(|one| !values.contains(&one)) => {}
            _ => return Some(StateNeed::Apart),
        }
    }
    seen.then_some(StateNeed::Running)
}
