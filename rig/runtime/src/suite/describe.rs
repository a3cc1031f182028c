//! What a record and a trace say of where they come from.

use crate::subject::{Subject, SubjectExt};
use crate::suite::board_instrument;
use crate::suite::case_files::CaseFiles;
use crate::wiring::Wiring;
use document::Joined;
use drivers::{BoardFile, Channel};
use plans::Case;
use plans::judge::{INSTANTS_COVERAGE_NOTE, counts_note, coverage_note};
use plans::plan::DelayModel;
use plans::steps::ProgramRef;
use plans::steps::{
    DisturbanceKind, FileOperation, LineFault, ModuleFaultKind, PlanCommand, Stimulus, StimulusShape,
};
use record::{CaseRecord, ClaimOrigin, Hashes, Parameter, StepRecord};
use sha2::{Digest, Sha256};
use signal::calendar::rfc3339;
use signal::{Coverage, Trace};

/// Bytes as hexadecimal digits.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// SHA-256 as hexadecimal digits.
pub fn sha256(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

/// The hash of a plan with all that it includes.
pub fn plan_hash(joined: &Joined) -> String {
    let mut text = joined.first().text.clone();
    for file in joined.others() {
        text.push('\0');
        text.push_str(&file.text);
    }
    sha256(text.as_bytes())
}

/// Notes of the trace of a capture: the hashes that [`hashes_again`] gives back.
const HASH_NOTES: [&str; 3] = ["board-sha256", "program-sha256", "capture-sha256"];

/// Writes into the trace of a capture what it was judged with beside the plan: the capture itself by its hash, board and program.
pub fn annotate_capture(trace: &mut Trace, files: &CaseFiles, capture: &str) {
    let Hashes { board, program, .. } = hashes(files);
    for (note, hash) in HASH_NOTES.into_iter().zip([board, program, capture.to_owned()]) {
        trace.set_note(note, hash);
    }
}

/// Hashes of what a trace is judged with: the plan, and what made the trace, as far as it says it. Otherwise the trace itself
/// stands for all that it was made from.
pub fn hashes_again(plan: &Joined, trace: &Trace) -> Hashes {
    let [board, program, capture] = HASH_NOTES.map(|note| trace.note(note).map(str::to_owned));
    Hashes {
        plan: plan_hash(plan),
        board: board.unwrap_or_default(),
        program: program.unwrap_or_default(),
        capture: capture.unwrap_or_else(|| hex(&trace.digest())),
    }
}

/// The hash of the board file with the programs of its plants.
pub(crate) fn board_hash(files: &CaseFiles) -> String {
    let mut text = files.board_text.clone();
    for program in &files.board.programs {
        text.push('\0');
        text.push_str(&program.text);
    }
    sha256(text.as_bytes())
}

/// Hashes of what a case is made of.
pub fn hashes(files: &CaseFiles) -> Hashes {
    let all = files.sources.iter().chain(files.others.iter().flat_map(|other| &other.sources));
    let sources: String = all.map(|source| format!("{}\0{}\0", source.name, source.text)).collect();
    Hashes {
        plan: plan_hash(&files.joined),
        board: if files.board_text.is_empty() { String::new() } else { board_hash(files) },
        program: if sources.is_empty() { String::new() } else { sha256(sources.as_bytes()) },
        capture: String::new(),
    }
}

/// What `$` names had which value.
pub fn parameters(case: &Case) -> Vec<Parameter> {
    let parameter = |(name, value): &(String, String)| Parameter { name: name.clone(), value: value.clone() };
    case.parameters.iter().map(parameter).collect()
}

/// The record of a case before it runs.
pub fn record_of(case: &Case, files: &CaseFiles) -> CaseRecord {
    CaseRecord {
        name: files.name.clone(),
        plan: files.plan.name.clone(),
        row: case.row.clone(),
        parameters: parameters(case),
        title: case.title.clone(),
        proves: case.proves.clone(),
        tags: case.tags.clone(),
        profile: files.profile.name().to_owned(),
        reference: files.reference.name.to_owned(),
        model: model(case, files),
        board: files.board.name.clone(),
        instrument: board_instrument::of(files),
        hashes: hashes(files),
        seed: files.seed,
        steps: case
            .steps
            .iter()
            .map(|step| StepRecord {
                id: step.id.clone(),
                at_ns: None,
                what: what(&step.stimulus),
                phase: step.part.word().to_owned(),
            })
            .collect(),
        ..CaseRecord::default()
    }
}

/// What the delays of the controller mean, where the rig plays it and an edge does not come when its delay is over.
fn model(case: &Case, files: &CaseFiles) -> String {
    match case.model {
        DelayModel::WorstCase if !files.board.subject.is_external() => case.model.name().to_owned(),
        DelayModel::Exact | DelayModel::WorstCase => String::new(),
    }
}

/// Writes into the trace up to which frequency its board reports every pulse, where the board says it.
pub fn promises(trace: &mut Trace, wiring: &Wiring, channels: &[Channel]) {
    for (channel, signals) in channels.iter().zip(&wiring.channels) {
        for signal in signals.iter().filter(|_| channel.is_digital()) {
            if let (Some(hz), Some(info)) = (channel.counts_hz, trace.signals().get(signal.0 as usize)) {
                trace.set_note(&counts_note(&info.name), hz.to_string());
            }
        }
    }
}

/// Writes into the trace what the values of real channels cover where that is no bound, and what all instants do: the clock of
/// the board has stamped them, and steps may wait for one of the values.
pub fn coverages(trace: &mut Trace, wiring: &Wiring, board: &BoardFile, case: &Case) {
    let stated = board.coverages();
    for (channel, words) in &stated {
        let signals = wiring.channels.get(usize::from(channel.0)).map_or(&[][..], Vec::as_slice);
        let names: Vec<String> = signals
            .iter()
            .filter_map(|signal| trace.signals().get(signal.0 as usize).map(|info| info.name.clone()))
            .collect();
        for name in names {
            trace.set_note(&coverage_note(&name), words.clone());
        }
    }
    let mut instants: Vec<String> = Vec::new();
    if board.clock.coverage != Coverage::Limits {
        instants.push(board.clock.coverage.to_string());
    }
    if case.scenario().steps.iter().any(|step| step.awaited.is_some()) {
        instants.extend(stated.into_iter().map(|(_, words)| words));
    }
    if !instants.is_empty() {
        trace.set_note(INSTANTS_COVERAGE_NOTE, instants.join(", "));
    }
}

/// Writes into the trace what judging it again needs, and whose names stand behind its numbers.
pub fn annotate(trace: &mut Trace, case: &Case, files: &CaseFiles, subject: &dyn Subject, clock: &str) {
    annotate_files(trace, case, files, clock);
    let model = model(case, files);
    if !model.is_empty() {
        trace.set_note("model", model);
    }
    board_instrument::annotate_clock(trace, files.board.clock.error);
    if let Some(board) = board_instrument::of(files) {
        board_instrument::annotate(trace, &board);
    }
    for (place, (task, ..)) in subject.figures().iter().enumerate() {
        trace.set_note(&format!("task:{place}"), task.clone());
    }
}

/// What of it follows from the files alone.
pub(crate) fn annotate_files(trace: &mut Trace, case: &Case, files: &CaseFiles, clock: &str) {
    trace.set_note("case", files.name.clone());
    trace.set_note("plan-case", case.name.clone());
    trace.set_note("plan", files.plan.name.clone());
    trace.set_note("plan-sha256", plan_hash(&files.joined));
    trace.set_note("profile", files.profile.name().to_owned());
    trace.set_note("reference", files.reference.name.to_owned());
    trace.set_note("seed", files.seed.to_string());
    trace.set_note("clock", clock.to_owned());
    for (name, value) in &case.parameters {
        trace.set_note(&format!("parameter:{name}"), value.clone());
    }
    for (name, value) in &files.given {
        trace.set_note(&format!("given:{name}"), value.clone());
    }
    // Whole, so that a trace can be judged again without the files.
    for (place, guards) in files.guards.iter().enumerate() {
        let kind = if guards.origin() == ClaimOrigin::Board { "board" } else { "suite" };
        let file = guards.file();
        trace.set_note(&format!("guards:{place:03}:{kind}:{}", file.name), file.text.clone());
    }
    let ports = crate::suite::ports::wired(&files.board, files.reference);
    for (place, port) in ports.iter().enumerate().filter(|(_, port)| port.bus.is_some()) {
        trace.set_note(&format!("port:{place}"), port.name.to_owned());
    }
    for (place, source) in files.sources.iter().enumerate() {
        trace.set_note(&format!("file:{place}"), source.name.clone());
    }
}

/// A program that a step names, in words.
fn program_name(program: &ProgramRef) -> String {
    match program {
        ProgramRef::Files(names) => names.join(", "),
        ProgramRef::Text { .. } | ProgramRef::None => String::from("the application"),
    }
}

/// What is wrong with an expansion module, after its name.
fn show_module_fault(fault: &ModuleFaultKind) -> String {
    match fault {
        ModuleFaultKind::Silent(None) => String::from("is silent"),
        ModuleFaultKind::Silent(Some(exchanges)) => format!("is silent for {exchanges} exchanges"),
        ModuleFaultKind::Pulled => String::from("is pulled"),
        ModuleFaultKind::Replaced(Some(module)) => format!("is replaced by {}", module.reference),
        ModuleFaultKind::Replaced(None) => String::from("is replaced"),
        ModuleFaultKind::Disturbs => String::from("disturbs those beside it"),
        ModuleFaultKind::Unsupplied => String::from("has no supply of its own"),
    }
}

/// A fault in words.
pub(crate) fn show_fault(kind: &LineFault) -> String {
    match kind {
        LineFault::Stuck(value) => format!("stuck at {}", plans::show_literal(value)),
        LineFault::Open => String::from("open"),
        LineFault::ShortToGround => String::from("short to ground"),
        LineFault::ShortToSupply => String::from("short to supply"),
        LineFault::Glitch { value, width } => format!("glitch to {} for {width}", plans::show_literal(value)),
        LineFault::Late(delay) => format!("{delay} late"),
        LineFault::Lost => String::from("lost"),
    }
}

/// A stimulus in words.
pub fn what(stimulus: &Stimulus) -> String {
    match stimulus {
        Stimulus::Set(list) => {
            let each: Vec<String> = list
                .iter()
                .map(|(signal, value)| format!("{signal} := {}", plans::show_literal(value)))
                .collect();
            each.join(", ")
        }
        Stimulus::Pulse { signal, value, width } => {
            format!("{signal} := {} for {width}", plans::show_literal(value))
        }
        Stimulus::Force { signal, value } => format!("force {signal} to {}", plans::show_literal(value)),
        Stimulus::Release { signal } => format!("release {signal}"),
        Stimulus::Write { of, value } => format!("write {of} := {}", plans::show_literal(value)),
        Stimulus::Command(command) => String::from(match command {
            PlanCommand::Run => "run",
            PlanCommand::Stop => "stop",
            PlanCommand::ResetWarm => "reset warm",
            PlanCommand::ResetCold => "reset cold",
            PlanCommand::Login => "connect the tool",
            PlanCommand::Logout => "disconnect the tool",
            PlanCommand::LogoutKeepForcing => "disconnect the tool and keep forcing",
            PlanCommand::IdentifyOn => "identify the controller",
            PlanCommand::IdentifyOff => "identify the controller no longer",
            PlanCommand::ResetOrigin => "reset origin",
            PlanCommand::Reboot => "reboot by script",
            PlanCommand::CreateBootApplication => "create the boot application",
            PlanCommand::DeleteApplication => "delete the application",
        }),
        Stimulus::Switch(run) => {
            format!("Run/Stop switch to {}", if *run { "Run" } else { "Stop" })
        }
        Stimulus::Download { program, boot } => {
            let name = program.as_ref().map_or_else(|| String::from("the application"), program_name);
            let boot = if *boot { "" } else { " and leave the boot application" };
            format!("download {name}{boot}")
        }
        Stimulus::OnlineChange(program) => format!("online change to {}", program_name(program)),
        Stimulus::Breakpoint { line, file: None } => format!("breakpoint in line {line}"),
        Stimulus::Breakpoint { line, file: Some(file) } => format!("breakpoint in line {line} of {file}"),
        Stimulus::SetClock { seconds } => {
            format!("set the clock to {}", rfc3339(u64::try_from(*seconds).unwrap_or_default()))
        }
        Stimulus::ClearBreakpoints => String::from("clear breakpoints"),
        Stimulus::Resume => String::from("go on from the breakpoint"),
        Stimulus::StepStatement => String::from("go on to the next statement"),
        Stimulus::MultipleDownload { program, start } => {
            let name = program.as_ref().map_or_else(|| String::from("the application"), program_name);
            let start = if *start { " and start" } else { "" };
            format!("multiple download of {name}{start}")
        }
        Stimulus::PlaceBootApplication(program) => {
            let name = program.as_ref().map_or_else(|| String::from("the application"), program_name);
            format!("place {name} as boot application")
        }
        Stimulus::ResetOriginDevice { user_management, plc_logic, certificates } => {
            let parts = [
                (*user_management, "user management"),
                (*plc_logic, "PLC logic"),
                (*certificates, "certificates"),
            ];
            let chosen: Vec<&str> = parts.iter().filter(|part| part.0).map(|part| part.1).collect();
            format!("reset origin device: {}", chosen.join(", "))
        }
        Stimulus::Firmware(true) => String::from("restore the firmware"),
        Stimulus::Firmware(false) => String::from("damage the firmware"),
        Stimulus::PowerCut(lasts) => format!("cut the supply for {lasts}"),
        Stimulus::Power(true) => String::from("supply on"),
        Stimulus::Power(false) => String::from("supply off"),
        Stimulus::Overload { task, cycle, times: 1 } => format!("the next cycle of {task} takes {cycle}"),
        Stimulus::Overload { task, cycle, times } => {
            format!("the next {times} cycles of {task} take {cycle} each")
        }
        Stimulus::Suspend { task, lasts } => format!("{task} does not get the processor for {lasts}"),
        Stimulus::SetPlant { plant, parameter, value, lasts } => {
            let lasts = lasts.map_or_else(String::new, |lasts| format!(" for {lasts}"));
            format!("{parameter} of {plant} to {value}{lasts}")
        }
        Stimulus::Fault { signal, kind, lasts } => {
            let kind = show_fault(kind);
            let lasts = lasts.map_or_else(String::new, |lasts| format!(" for {lasts}"));
            format!("fault on {signal}: {kind}{lasts}")
        }
        Stimulus::File { path, deed, .. } => match deed {
            FileOperation::Put(bytes) => format!("put {} bytes into {path}", bytes.len()),
            FileOperation::Fill(bytes) => format!("put {bytes} bytes into {path}"),
            FileOperation::Log(entry) => format!("log {} characters into {path}", entry.chars().count()),
            FileOperation::Remove => format!("remove {path}"),
        },
        Stimulus::Clear { signal } => format!("faults off {signal}"),
        Stimulus::Disturb { what, on, lasts } => {
            let what = match what {
                DisturbanceKind::ShortCircuit(output) => format!("short circuit at {output}"),
                DisturbanceKind::OverTemperature(output) => format!("over-temperature at {output}"),
                DisturbanceKind::NoIoSupply => String::from("no supply of inputs and outputs"),
                DisturbanceKind::External(bit) => format!("external error {bit}"),
                DisturbanceKind::Internal(kind) => format!("internal error: {}", kind.name()),
                DisturbanceKind::Module { index, fault } => {
                    format!("module {index} {}", show_module_fault(fault))
                }
                DisturbanceKind::NoBusSupply => String::from("no supply of the expansion bus"),
                DisturbanceKind::NoBusLink => String::from("link of transmitter and receiver cut"),
                DisturbanceKind::Battery(charge) => format!("battery of the clock at {charge} %"),
            };
            match (on, lasts) {
                (true, Some(lasts)) => format!("{what} for {lasts}"),
                (true, None) => what,
                (false, _) => format!("{what} ends"),
            }
        }
        Stimulus::Train(train) => format!("{} pulses on {}", train.count, train.signal),
        Stimulus::Wave(wave) => {
            let lasts = wave.lasts.map_or_else(String::new, |lasts| format!(" for {lasts}"));
            match &wave.shape {
                StimulusShape::Ramp { from: Some(from), to } => {
                    format!("{} from {from} to {to}{lasts}", wave.signal)
                }
                StimulusShape::Ramp { from: None, to } => format!("{} to {to}{lasts}", wave.signal),
                _ => format!("{} on {}{lasts}", wave.verb(), wave.signal),
            }
        }
        Stimulus::Sequence(sequence) => {
            let rows = sequence.table.times.len();
            let times =
                if sequence.times > 1 { format!(", {} times", sequence.times) } else { String::new() };
            format!("{rows} rows of {}{times}", sequence.table.path)
        }
        Stimulus::Encoder(encoder) => {
            let lines: Vec<&str> = encoder.lines().collect();
            format!("{} counts of an encoder on {}", encoder.counts(), lines.join(", "))
        }
        Stimulus::Run { group } => format!("run {group}"),
        Stimulus::Send(send) => {
            let what = match &send.name {
                Some(name) => format!("send {name} on {}", send.frame.bus),
                None => format!("send {} on {}", send.frame, send.frame.bus),
            };
            match send.count {
                1 => what,
                count => format!("{what}, {count} times every {}", send.period),
            }
        }
        Stimulus::Ask(question) => format!("ask: {}", question.text),
        Stimulus::Mark => String::from("nothing"),
    }
}
