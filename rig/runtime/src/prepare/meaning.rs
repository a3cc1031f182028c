//! What a bound name is on a bench.

use super::TestBench;
use crate::application::catalogue::Catalogue;
use crate::application::image_places::known_places;
use crate::application::observable::Observable;
use crate::codes;
use crate::subject::SubjectExt;
use controller::Probe;
use document::Findings;
use drivers::{BoardExt, ChannelId};
use plans::signals::{SignalBinding, SignalSource, TaskFigure};
use profile::IoChannel;
use signal::{Address, SignalId, ValueKind};

/// What a name turned out to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum NameMeaning {
    /// A channel, and the terminal where it was named by one: several inputs may share a channel.
    Channel(ChannelId, Option<Address>),
    Inside(Observable),
    /// Frames of a bus, or a value in them.
    OfBus,
}

/// What a bound name is on this bench.
pub(super) fn meaning(
    binding: &SignalBinding,
    bench: &TestBench<'_>,
    out: &mut Findings,
) -> Option<NameMeaning> {
    let at = binding.span.clone();
    let inside = |name: &str| bench.subject.observable(name).map(NameMeaning::Inside);
    let found = match &binding.source {
        SignalSource::Line(address) => {
            let channel = bench.file.channel_of(*address);
            channel.map(|channel| NameMeaning::Channel(channel, Some(*address))).or_else(|| {
                // A terminal that the reference does not have is no line; nor is one that the board leaves open.
                let known = IoChannel::at(*address, bench.reference).is_some()
                    || bench.subject.terminal(*address).is_some();
                let help = match known {
                    false => no_terminal(*address, bench),
                    true => format!("bind it to a channel in {}", bench.file.name),
                };
                out.error(codes::NO_TERMINAL, at.clone(), format!("no line is at {address}"), help);
                None
            })?
        }
        SignalSource::Memory(address) | SignalSource::Image(address) => {
            let limits = bench.profile.address_limits();
            if let Err(error) = address.check(&limits) {
                out.error(
                    codes::ADDRESS_OUT_OF_RANGE,
                    at,
                    error.to_string(),
                    "write an address below the end of its area",
                );
                return None;
            }
            inside(&address.to_string())?
        }
        SignalSource::Channel(name) => match bench.board.find(name) {
            Some(channel) => NameMeaning::Channel(channel, None),
            None => {
                let channels = bench.board.channels().iter().map(|channel| channel.name.as_str());
                let help = of_module(name, bench)
                    .or_else(|| {
                        document::suggest(name, channels).map(|meant| format!("did you mean `{meant}`?"))
                    })
                    .unwrap_or_else(|| String::from("describe it under `channels` of the board file"));
                out.error(codes::NO_CHANNEL, at, format!("the board has no channel `{name}`"), help);
                return None;
            }
        },
        SignalSource::Path(path) => {
            let channel = || bench.board.find(path).map(|channel| NameMeaning::Channel(channel, None));
            let Some(found) = inside(path).or_else(channel) else {
                if let Some((message, help)) = element(path, bench) {
                    out.error(codes::UNKNOWN_NAME, at, message, help);
                    return None;
                }
                let mut known = bench.subject.catalogue().map_or_else(Vec::new, Catalogue::names);
                known.extend(bench.board.channels().iter().map(|channel| channel.name.clone()));
                let known = known.iter().map(String::as_str);
                let help = of_module(path, bench)
                    .or_else(|| {
                        document::suggest(path, known).map(|meant| format!("did you mean `{meant}`?"))
                    })
                    .unwrap_or_else(|| String::from(NAMES));
                let message =
                    format!("`{path}` is no variable, no system variable and no channel of the board");
                out.error(codes::UNKNOWN_NAME, at, message, help);
                return None;
            };
            found
        }
        SignalSource::Task { task, figure } => {
            let Some(place) = bench.subject.task(task) else {
                out.error(codes::NO_TASK, at, format!("there is no task `{task}`"), known_tasks(task, bench));
                return None;
            };
            let probe = Probe::TaskFigure { task: place, figure: figure_of(*figure) };
            let kind = if *figure == TaskFigure::Load { ValueKind::Real } else { ValueKind::Int };
            NameMeaning::Inside(Observable { probe, kind })
        }
        // These were looked at before.
        SignalSource::Log(_)
        | SignalSource::File { .. }
        | SignalSource::Register { .. }
        | SignalSource::Relocation { .. }
        | SignalSource::Frames(_)
        | SignalSource::FrameSignal(_) => {
            return None;
        }
    };
    Some(found)
}

/// What is wrong with a name that means an array, or a place outside one: its finding and what fixes it.
fn element(path: &str, bench: &TestBench<'_>) -> Option<(String, String)> {
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

/// What a name can be.
const NAMES: &str =
    "name a variable as in MAIN.n, a system variable as in PLC_R.i_wStatus, or a channel of the board";

/// What helps where the controller has no terminal at an address.
pub(super) fn no_terminal(address: Address, bench: &TestBench<'_>) -> String {
    let known = bench.subject.catalogue().map(|catalogue| {
        let terminals = catalogue.module_terminals();
        format!(": {}", known_places(address.area(), bench.reference, &terminals))
    });
    format!("{} has no such terminal{}", bench.reference.name, known.unwrap_or_default())
}

/// What helps where a name has the form of a terminal of a module and is none.
fn of_module(name: &str, bench: &TestBench<'_>) -> Option<String> {
    bench.subject.catalogue()?.module_terminals().help(name)
}

pub(super) fn suggestion<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> String {
    document::suggest(name, known).map_or_else(String::new, |meant| format!("did you mean `{meant}`?"))
}

/// The fix for the name of a task that there is none of.
pub(super) fn known_tasks(task: &str, bench: &TestBench<'_>) -> String {
    let tasks = bench.subject.catalogue().map_or(&[][..], Catalogue::tasks);
    let known: Vec<&str> = tasks.iter().map(|task| task.name.as_str()).collect();
    match document::suggest(task, known.iter().copied()) {
        Some(meant) => format!("did you mean `{meant}`?"),
        None => {
            format!("there are {}: tasks stand in the plan's settings or in the program", known.join(", "))
        }
    }
}

const fn figure_of(figure: TaskFigure) -> controller::TaskFigure {
    use controller::TaskFigure as Figure;
    match figure {
        TaskFigure::Cycles => Figure::Cycles,
        TaskFigure::LastCycle => Figure::Last,
        TaskFigure::MinCycle => Figure::Min,
        TaskFigure::MaxCycle => Figure::Max,
        TaskFigure::Elapsed => Figure::Elapsed,
        TaskFigure::Overruns => Figure::Overruns,
        TaskFigure::Lost => Figure::Lost,
        TaskFigure::Exceptions => Figure::Exceptions,
        TaskFigure::MeanCycle => Figure::Mean,
        TaskFigure::Jitter => Figure::Jitter,
        TaskFigure::MinJitter => Figure::MinJitter,
        TaskFigure::MaxJitter => Figure::MaxJitter,
        TaskFigure::Load => Figure::Load,
    }
}

/// The names of a case with what they mean.
pub(super) struct SignalMeanings<'a> {
    pub(super) list: &'a [(String, NameMeaning, SignalId)],
    pub(super) state: Option<SignalId>,
}

impl SignalMeanings<'_> {
    pub(super) fn signal(&self, name: &str) -> Option<SignalId> {
        if name == "state" {
            return self.state;
        }
        self.list.iter().find(|(known, ..)| known == name).map(|(.., signal)| *signal)
    }

    pub(super) fn meaning(&self, name: &str) -> Option<NameMeaning> {
        self.list.iter().find(|(known, ..)| known == name).map(|(_, meaning, _)| *meaning)
    }
}
