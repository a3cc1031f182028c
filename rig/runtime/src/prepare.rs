//! From the names of a plan to terminals, channels, probes and signals.

use crate::schedule::{Act, Awaited, Expected, Planned, Timing, TrainWork};
use crate::subject::{Observable, Subject};
use crate::wiring::Wiring;
use controller::{Channel as Terminal, Command, Figure, Probe, State};
use document::{Diagnostic, Findings};
use drivers::{Board, BoardFile, Channel, ChannelId, Fault, FaultKind, TimestampSource};
use plans::lang::Literal;
use plans::plan::{Await, Recording, SignalBinding, Source, TaskFigure};
use plans::steps::{FaultKind as PlannedFault, Stimulus};
use plans::{Case, Step, StepTime};
use profile::{Profile, Reference};
use signal::{
    Address, Area, ClockDomain, Kind, Level, Policy, Sampling, SignalId, SignalInfo, Span, Trace, TraceError,
    Value,
};

/// What the names of a case are looked up in.
pub struct Bench<'a> {
    /// The subject.
    pub subject: &'a mut dyn Subject,
    /// The board.
    pub board: &'a dyn Board,
    /// The board's file.
    pub file: &'a BoardFile,
    /// The subject's profile.
    pub profile: Profile,
    /// The subject's reference.
    pub reference: &'static Reference,
    /// The application that a download step transfers where it names none; empty where there is none.
    pub bundle: &'a [u8],
    /// Whether the clock is exact.
    pub exact: bool,
}

impl std::fmt::Debug for Bench<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Bench").field("file", &self.file.name).finish_non_exhaustive()
    }
}

/// What a name turned out to be.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Meaning {
    /// A channel, and the terminal where it was named by one: several inputs may share a channel.
    Channel(ChannelId, Option<Address>),
    Inside(Observable),
}

/// A case with every name resolved.
#[derive(Debug)]
pub struct Prepared {
    /// The trace with its signals defined.
    pub trace: Trace,
    /// Who is behind whom.
    pub wiring: Wiring,
    /// The steps.
    pub steps: Vec<Planned>,
    /// Observed probes with their signals, to be read once at the start.
    pub probes: Vec<(Probe, SignalId)>,
}

/// The labels of the signal `state`.
pub fn state_labels() -> Vec<(i64, String)> {
    State::ALL.iter().map(|state| (state.number(), state.name().to_owned())).collect()
}

/// Resolves the names of a case and defines its signals in `trace`.
///
/// # Errors
/// Findings with their places in the plan: names that mean nothing on this bench, values that do not fit.
pub fn prepare(
    case: &Case,
    plan: &document::SourceFile,
    mut trace: Trace,
    bench: &mut Bench<'_>,
) -> Result<Prepared, Vec<Diagnostic>> {
    let mut out = Findings::new(plan, plans::TOML);
    let mut wiring = Wiring::new(bench.reference.output_count(), bench.board.channels().len());
    for binding in &bench.file.bind {
        match Terminal::at(binding.address, bench.reference) {
            Some(Terminal::Input(input)) => wiring.inputs[usize::from(binding.channel.0)].push(input),
            Some(Terminal::Output(output)) => wiring.outputs[output] = Some(binding.channel),
            None => {}
        }
    }
    let mut state = SignalInfo::exact("state", Kind::State);
    state.labels = state_labels();
    wiring.state = define(&mut trace, state, &mut out);
    let mut names = Vec::new();
    let mut probes = Vec::new();
    for binding in &case.signals {
        let Some(meaning) = meaning(binding, bench, &mut out) else { continue };
        let info = match meaning {
            Meaning::Channel(channel, _) => {
                channel_info(&binding.name, &bench.board.channels()[usize::from(channel.0)])
            }
            Meaning::Inside(observable) => SignalInfo::exact(&binding.name, observable.kind),
        };
        let Some(policy) = policy(binding, &info, &mut out) else { continue };
        let info = clocked(SignalInfo { policy, ..info }, bench.exact);
        let Some(signal) = define(&mut trace, info, &mut out) else { continue };
        match meaning {
            Meaning::Channel(channel, _) => wiring.channels[usize::from(channel.0)].push(signal),
            Meaning::Inside(observable) => {
                let probe = bench.subject.watch(observable.probe);
                wiring.show_probe(probe, signal);
                probes.push((observable.probe, signal));
            }
        }
        names.push((binding.name.clone(), meaning, signal));
    }
    for (mark, place) in [("step:start", &mut wiring.start), ("step:end", &mut wiring.end)] {
        *place = define(&mut trace, SignalInfo::exact(mark, Kind::Mark), &mut out);
    }
    let mut steps = Vec::new();
    for step in &case.steps {
        let mark = define(&mut trace, SignalInfo::exact(format!("step:{}", step.id), Kind::Mark), &mut out);
        let done =
            define(&mut trace, SignalInfo::exact(format!("step:{}.done", step.id), Kind::Mark), &mut out);
        let (Some(mark), Some(done)) = (mark, done) else { continue };
        let names = Names { list: &names, state: wiring.state };
        let planned = plan_step(step, mark, done, &names, &trace, bench, &mut out);
        steps.extend(planned);
    }
    let found = out.into_vec();
    if found.iter().any(Diagnostic::is_error) {
        return Err(found);
    }
    Ok(Prepared { trace, wiring, steps, probes })
}

/// Which changes of a bound signal the trace keeps.
fn policy(binding: &SignalBinding, info: &SignalInfo, out: &mut Findings) -> Option<Policy> {
    let band = match &binding.recording {
        Recording::Changes => return Some(Policy::Changes),
        Recording::AtMostEvery(span) => return Some(Policy::AtMostEvery(*span)),
        Recording::Deadband(band) => band,
    };
    let (message, help) = match (info.kind, plans::value_of(band, info).ok().and_then(Value::as_real)) {
        (Kind::Int | Kind::Word | Kind::Real, Some(band)) if band > 0.0 && band.is_finite() => {
            return Some(Policy::Deadband(band));
        }
        (Kind::Int | Kind::Word | Kind::Real, _) => {
            let unit = if info.unit.is_empty() {
                String::from("without a unit")
            } else {
                format!("in {}", info.unit)
            };
            let band = plans::show_literal(band);
            (format!("the deadband {band} does not fit `{}`", info.name), format!("write a number {unit}"))
        }
        _ => (format!("`{}` is no number and has no deadband", info.name), String::from("remove `deadband`")),
    };
    out.error("R0115", binding.span.clone(), message, help);
    None
}

fn define(trace: &mut Trace, info: SignalInfo, out: &mut Findings) -> Option<SignalId> {
    let name = info.name.clone();
    match trace.define(info) {
        Ok(signal) => Some(signal),
        Err(TraceError::DuplicateName(_)) => {
            out.error("R0101", 0..0, format!("the trace has two signals `{name}`"), "rename one of them");
            None
        }
        Err(error) => {
            out.error("R0101", 0..0, format!("the signal `{name}` cannot be recorded: {error}"), "");
            None
        }
    }
}

fn clocked(mut info: SignalInfo, exact: bool) -> SignalInfo {
    info.clock = if exact { ClockDomain::Virtual } else { ClockDomain::Monotonic };
    info
}

fn channel_info(name: &str, channel: &Channel) -> SignalInfo {
    let kind = if channel.is_digital() { Kind::Bool } else { Kind::Real };
    let sampling = match channel.timestamp {
        TimestampSource::Sampled { period } => Sampling::Sampled { period },
        _ => Sampling::Edges { resolution: channel.resolution },
    };
    SignalInfo {
        unit: channel.unit().to_owned(),
        sampling,
        shortest_pulse: channel.shortest_pulse,
        ..SignalInfo::exact(name, kind)
    }
}

/// What a bound name is on this bench.
fn meaning(binding: &SignalBinding, bench: &Bench<'_>, out: &mut Findings) -> Option<Meaning> {
    let at = binding.span.clone();
    let inside = |name: &str| bench.subject.observable(name).map(Meaning::Inside);
    let found = match &binding.source {
        Source::Line(address) => {
            let channel = bench.file.channel_of(*address);
            channel.map(|channel| Meaning::Channel(channel, Some(*address))).or_else(|| {
                // A terminal that the reference does not have is no line; nor is one that the board leaves open.
                let help = match Terminal::at(*address, bench.reference) {
                    None => format!("{} has no such terminal", bench.reference.name),
                    Some(_) => format!("bind it to a channel in {}", bench.file.name),
                };
                out.error("R0102", at.clone(), format!("no line is at {address}"), help);
                None
            })?
        }
        Source::Memory(address) | Source::Image(address) => {
            let limits = bench.profile.address_limits();
            if let Err(error) = address.check(&limits) {
                out.error("R0112", at, error.to_string(), "");
                return None;
            }
            inside(&address.to_string())?
        }
        Source::Channel(name) => match bench.board.find(name) {
            Some(channel) => Meaning::Channel(channel, None),
            None => {
                let channels = bench.board.channels().iter().map(|channel| channel.name.as_str());
                let help = suggestion(name, channels);
                out.error("R0103", at, format!("the board has no channel `{name}`"), help);
                return None;
            }
        },
        Source::Path(path) => {
            let channel = || bench.board.find(path).map(|channel| Meaning::Channel(channel, None));
            let Some(found) = inside(path).or_else(channel) else {
                if let Some((message, help)) = element(path, bench) {
                    out.error("R0104", at, message, help);
                    return None;
                }
                let mut known = bench.subject.names();
                known.extend(bench.board.channels().iter().map(|channel| channel.name.clone()));
                let help = suggestion(path, known.iter().map(String::as_str));
                let message =
                    format!("`{path}` is no variable, no system variable and no channel of the board");
                out.error("R0104", at, message, help);
                return None;
            };
            found
        }
        Source::Task { task, figure } => {
            let Some(place) = bench.subject.task(task) else {
                out.error("R0105", at, format!("there is no task `{task}`"), known_tasks(task, bench));
                return None;
            };
            let probe = Probe::TaskFigure { task: place, figure: figure_of(*figure) };
            Meaning::Inside(Observable { probe, kind: Kind::Int })
        }
    };
    Some(found)
}

/// What is wrong with a name that means an array, or a place outside one: its finding and what mends it.
fn element(path: &str, bench: &Bench<'_>) -> Option<(String, String)> {
    let array = path.split('[').next().unwrap_or(path);
    let mut elements = (0..=1).rev().map(|place| format!("{array}[{place}]"));
    let example = elements.find(|element| bench.subject.observable(element).is_some())?;
    let message = if array == path {
        format!("`{path}` is an array, and a signal is one value")
    } else {
        format!("`{path}` is no element of the array `{array}`")
    };
    Some((message, format!("name one element, as in `{example}`")))
}

fn suggestion<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> String {
    document::suggest(name, known).map_or_else(String::new, |meant| format!("did you mean `{meant}`?"))
}

/// What mends the name of a task that there is none of.
fn known_tasks(task: &str, bench: &Bench<'_>) -> String {
    let known: Vec<&str> = (0..).map_while(|place| bench.subject.task_name(place)).collect();
    match document::suggest(task, known.iter().copied()) {
        Some(meant) => format!("did you mean `{meant}`?"),
        None => {
            format!("there are {}: tasks stand in the plan's settings or in the program", known.join(", "))
        }
    }
}

const fn figure_of(figure: TaskFigure) -> Figure {
    match figure {
        TaskFigure::Cycles => Figure::Cycles,
        TaskFigure::LastCycle => Figure::Last,
        TaskFigure::MinCycle => Figure::Min,
        TaskFigure::MaxCycle => Figure::Max,
        TaskFigure::Elapsed => Figure::Elapsed,
        TaskFigure::Overruns => Figure::Overruns,
        TaskFigure::Lost => Figure::Lost,
        TaskFigure::Exceptions => Figure::Exceptions,
    }
}

/// The names of a case with what they mean.
struct Names<'a> {
    list: &'a [(String, Meaning, SignalId)],
    state: Option<SignalId>,
}

impl Names<'_> {
    fn signal(&self, name: &str) -> Option<SignalId> {
        if name == "state" {
            return self.state;
        }
        self.list.iter().find(|(known, ..)| known == name).map(|(.., signal)| *signal)
    }

    fn meaning(&self, name: &str) -> Option<Meaning> {
        self.list.iter().find(|(known, ..)| known == name).map(|(_, meaning, _)| *meaning)
    }
}

fn plan_step(
    step: &Step,
    mark: SignalId,
    done: SignalId,
    names: &Names<'_>,
    trace: &Trace,
    bench: &mut Bench<'_>,
    out: &mut Findings,
) -> Option<Planned> {
    let timing = match &step.when {
        StepTime::At(anchor) => Timing::At(anchor.clone()),
        StepTime::When { signal, awaits, from, within } => {
            let signal = names.signal(signal)?;
            let info = &trace.signals()[signal.0 as usize];
            let event = awaited(awaits, info, step, out)?;
            Timing::When { signal, event, from: from.clone(), within: *within }
        }
    };
    let mut train = None;
    let acts = match &step.stimulus {
        Stimulus::Set(list) => {
            let acts: Option<Vec<_>> = list
                .iter()
                .map(|(name, value)| {
                    let channel = driven(name, names, bench, step, out)?;
                    Some((Span::ZERO, Act::Drive(channel, value_for(value, channel, bench, step, out)?)))
                })
                .collect();
            acts?
        }
        Stimulus::Pulse { signal, value, width } => {
            let channel = driven(signal, names, bench, step, out)?;
            let value = value_for(value, channel, bench, step, out)?;
            vec![(Span::ZERO, Act::Drive(channel, value)), (*width, Act::Restore(channel))]
        }
        Stimulus::Train(planned) => {
            let channel = driven(&planned.signal, names, bench, step, out)?;
            train = Some(TrainWork { channel, train: planned.clone() });
            Vec::new()
        }
        Stimulus::Force { signal, value } => {
            let channel = terminal(signal, names, bench, step, out)?;
            let Some(on) = boolean(value) else {
                out.error("R0107", step.span.clone(), "a terminal is forced to TRUE or FALSE", "");
                return None;
            };
            vec![(Span::ZERO, Act::Command(Command::Force { channel, on }, Expected::Obeyed))]
        }
        Stimulus::Release { signal } => {
            let channel = terminal(signal, names, bench, step, out)?;
            vec![(Span::ZERO, Act::Command(Command::Unforce(channel), Expected::Obeyed))]
        }
        Stimulus::Write { of, value } => {
            let observable = match names.meaning(of)? {
                Meaning::Inside(observable) => observable,
                Meaning::Channel(channel, _) => {
                    let message = format!("`{of}` is no variable and no place in memory");
                    let help = match of_controller(channel, bench) {
                        true => "an output of the controller is driven from outside with `force`",
                        false => "a line is driven with `set`",
                    };
                    out.error("R0106", step.span.clone(), message, help);
                    return None;
                }
            };
            let Literal::Value(value) = value else {
                out.error("R0107", step.span.clone(), format!("`{of}` takes a plain number"), "");
                return None;
            };
            if matches!(value, Value::Real(_)) && observable.kind != Kind::Real {
                let help = "only a REAL or LREAL has a value with a part behind the point";
                out.error("R0107", step.span.clone(), format!("`{of}` takes a whole number"), help);
                return None;
            }
            vec![(Span::ZERO, Act::Write(observable.probe, *value))]
        }
        Stimulus::Command(command) => {
            let command = match command {
                plans::steps::Command::Run => Command::Run,
                plans::steps::Command::Stop => Command::Stop,
                plans::steps::Command::ResetWarm => Command::ResetWarm,
                plans::steps::Command::ResetCold => Command::ResetCold,
            };
            vec![(Span::ZERO, Act::Command(command, expected(step)))]
        }
        Stimulus::Download(None) if bench.bundle.is_empty() => {
            let help = "give the plan a `program`: it is what a download transfers";
            out.error("R0108", step.span.clone(), "there is no application to download", help);
            return None;
        }
        Stimulus::Download(None) => {
            vec![(Span::ZERO, Act::Command(Command::Download(bench.bundle.to_vec()), expected(step)))]
        }
        Stimulus::Download(Some(_)) => {
            let help = "leave `program` out: the case's own application is downloaded again";
            out.error("R0108", step.span.clone(), "another application cannot be downloaded yet", help);
            return None;
        }
        Stimulus::PowerCut(lasts) => vec![(Span::ZERO, Act::Power(false)), (*lasts, Act::Power(true))],
        Stimulus::Power(on) => vec![(Span::ZERO, Act::Power(*on))],
        Stimulus::Overload { task, cycle, times } => {
            let Some(task) = bench.subject.task(task) else {
                let help = known_tasks(task, bench);
                out.error("R0105", step.span.clone(), format!("there is no task `{task}`"), help);
                return None;
            };
            vec![(Span::ZERO, Act::Overload { task, cycle: *cycle, times: *times })]
        }
        Stimulus::Fault { signal, kind, lasts } => {
            let channel = line(signal, names, step, out)?;
            let kind = fault_kind(kind, channel, bench, step, out)?;
            vec![(Span::ZERO, Act::Fault(Fault { channel, kind, lasts: *lasts }))]
        }
        Stimulus::Clear { signal } => vec![(Span::ZERO, Act::Clear(line(signal, names, step, out)?))],
        Stimulus::Mark => Vec::new(),
    };
    let lasts = step.stimulus.duration();
    Some(Planned { id: step.id.clone(), mark, done, timing, acts, train, lasts })
}

const fn expected(step: &Step) -> Expected {
    if step.refused { Expected::Refused } else { Expected::Obeyed }
}

fn awaited(awaits: &Await, info: &SignalInfo, step: &Step, out: &mut Findings) -> Option<Awaited> {
    let mut value = |literal: &Literal| {
        let value = plans::value_of(literal, info).ok();
        if value.is_none() {
            let message = format!("`{}` cannot have this value", info.name);
            let labels: Vec<&str> = info.labels.iter().map(|(_, label)| label.as_str()).collect();
            let help =
                if labels.is_empty() { String::new() } else { format!("it can be {}", labels.join(", ")) };
            out.error("R0107", step.span.clone(), message, help);
        }
        value
    };
    Some(match awaits {
        Await::Becomes(literal) => Awaited::Becomes(value(literal)?),
        Await::Rises => Awaited::Rises,
        Await::Falls => Awaited::Falls,
        Await::Changes => Awaited::Changes,
        Await::Above(literal) => Awaited::Above(value(literal)?.as_real()?),
        Await::Below(literal) => Awaited::Below(value(literal)?.as_real()?),
    })
}

/// The channel of a line.
fn line(name: &str, names: &Names<'_>, step: &Step, out: &mut Findings) -> Option<ChannelId> {
    if let Some(Meaning::Channel(channel, _)) = names.meaning(name) {
        return Some(channel);
    }
    // A name that means nothing at all was reported where it is bound.
    if names.meaning(name).is_some() {
        let help = "bind it to a terminal such as \"%IX0.0\", or to a channel of the board";
        out.error("R0109", step.span.clone(), format!("`{name}` is no line"), help);
    }
    None
}

/// Whether an output terminal is behind the channel.
fn of_controller(channel: ChannelId, bench: &Bench<'_>) -> bool {
    bench.file.bind.iter().any(|binding| binding.channel == channel && binding.address.area() == Area::Output)
}

/// The channel of a line that the plan may drive: not one that the model drives.
fn driven(
    name: &str,
    names: &Names<'_>,
    bench: &Bench<'_>,
    step: &Step,
    out: &mut Findings,
) -> Option<ChannelId> {
    let channel = line(name, names, step, out)?;
    if of_controller(channel, bench) {
        let help = "an output is the controller's own: force it, or put a fault on it";
        out.error("R0110", step.span.clone(), format!("`{name}` is driven by the controller"), help);
        return None;
    }
    if !bench.board.channels()[usize::from(channel.0)].drives {
        out.error("R0110", step.span.clone(), format!("the board cannot drive `{name}`"), "");
        return None;
    }
    Some(channel)
}

/// The terminal behind a signal, for forcing.
fn terminal(
    name: &str,
    names: &Names<'_>,
    bench: &Bench<'_>,
    step: &Step,
    out: &mut Findings,
) -> Option<Terminal> {
    let address = match names.meaning(name)? {
        Meaning::Channel(_, Some(address)) => Some(address),
        Meaning::Channel(channel, None) => {
            bench.file.bind.iter().find(|binding| binding.channel == channel).map(|binding| binding.address)
        }
        Meaning::Inside(Observable { probe: Probe::Address(address), .. }) => Some(address),
        Meaning::Inside(_) => None,
    };
    let terminal = address.and_then(|address| Terminal::at(address, bench.reference));
    if terminal.is_none() {
        let help = "only inputs and outputs of the controller are forced; a variable is written with `write`";
        out.error("R0109", step.span.clone(), format!("`{name}` is no input or output"), help);
    }
    terminal
}

fn boolean(literal: &Literal) -> Option<bool> {
    match literal {
        Literal::Value(value) => value.as_bool(),
        _ => None,
    }
}

/// A written value as the channel takes it.
fn value_for(
    literal: &Literal,
    channel: ChannelId,
    bench: &Bench<'_>,
    step: &Step,
    out: &mut Findings,
) -> Option<Value> {
    let channel = &bench.board.channels()[usize::from(channel.0)];
    let info = channel_info(&channel.name, channel);
    let value = match (plans::value_of(literal, &info).ok(), channel.is_digital()) {
        (Some(Value::HighZ), _) => Some(Value::HighZ),
        (Some(value), true) => match value.as_int() {
            Some(0) => Some(Value::from(Level::Low)),
            Some(1) => Some(Value::from(Level::High)),
            _ => None,
        },
        (Some(value), false) => value.as_real().map(Value::Real),
        (None, _) => None,
    };
    if value.is_none() {
        let help = if channel.is_digital() {
            String::from("a level is TRUE or FALSE")
        } else {
            format!(
                "a number, or a quantity in {}",
                if channel.unit().is_empty() { "no unit" } else { channel.unit() }
            )
        };
        out.error("R0107", step.span.clone(), format!("the value does not fit `{}`", channel.name), help);
    }
    value
}

fn fault_kind(
    kind: &PlannedFault,
    channel: ChannelId,
    bench: &Bench<'_>,
    step: &Step,
    out: &mut Findings,
) -> Option<FaultKind> {
    let kind = match kind {
        PlannedFault::Stuck(value) => FaultKind::StuckAt(value_for(value, channel, bench, step, out)?),
        PlannedFault::Open => FaultKind::Open,
        PlannedFault::ShortToGround => FaultKind::ShortToGround,
        PlannedFault::ShortToSupply => FaultKind::ShortToSupply,
        PlannedFault::Glitch { value, width } => {
            FaultKind::Glitch { value: value_for(value, channel, bench, step, out)?, width: *width }
        }
        PlannedFault::Late(delay) => FaultKind::Late(*delay),
        PlannedFault::Lost => FaultKind::Lost,
    };
    let channel = &bench.board.channels()[usize::from(channel.0)];
    if !channel.faults.contains(kind) {
        out.error(
            "R0111",
            step.span.clone(),
            format!("the board cannot put this fault on `{}`", channel.name),
            "",
        );
        return None;
    }
    Some(kind)
}
