//! From the steps of a plan to what is done on a bench.

use super::TestBench;
use super::lines::{driven, fault_kind, forced_place, line, of_controller, value_for};
use super::meaning::{NameMeaning, SignalMeanings, known_tasks, no_terminal, suggestion};
use super::plants::plant_parameter;
use super::waves::generator;
use crate::application::catalogue::Catalogue;
use crate::application::taken_values::TakenValues;
use crate::codes;
use crate::schedule::{Act, Expected, FileAction, PlannedStep, Timing};
use crate::subject::SubjectExt;
use controller::{
    Command, DeviceReset, Disturbance, FAULT_BITS, FileUser, InternalError, ModuleFault, Probe,
};
use document::Findings;
use drivers::{BoardExt, Fault};
use plans::lang::Literal;
use plans::steps::{AwaitedChange, ProgramRef, StepCondition, Stimulus};
use plans::{PlanStep, StepTime};
use profile::IoChannel;
use signal::{Address, SignalId, SignalInfo, Span, Trace, Value, ValueKind};

pub(super) fn plan_step(
    step: &PlanStep,
    mark: SignalId,
    done: SignalId,
    names: &SignalMeanings<'_>,
    trace: &Trace,
    bench: &mut TestBench<'_>,
    out: &mut Findings,
) -> Option<PlannedStep> {
    let timing = match &step.when {
        StepTime::At(anchor) => Timing::At(anchor.clone()),
        StepTime::When { signal, awaits, from, within, .. } => {
            let signal = names.signal(signal)?;
            let info = &trace.signals()[signal.0 as usize];
            let event = awaited(awaits, info, step, out)?;
            Timing::When { signal, event, from: from.clone(), within: *within }
        }
    };
    let mut generates = None;
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
        Stimulus::Train(_)
        | Stimulus::Wave(_)
        | Stimulus::Encoder(_)
        | Stimulus::Sequence(_)
        | Stimulus::Send(_) => {
            generates = Some(generator(step, names, bench, out)?);
            Vec::new()
        }
        Stimulus::Force { signal, value } => {
            let address = forced_place(signal, names, bench, step, out)?;
            let Some(forced) = forced_value(address, value) else {
                let message = format!("`{signal}` cannot be forced to {}", plans::show_literal(value));
                let help = format!("it takes {}", TakenValues::of_place(address));
                out.error(codes::VALUE_MISFIT, step.span.clone(), message, help);
                return None;
            };
            vec![(Span::ZERO, Act::Command(Command::Force { address, value: forced }, expected(step)))]
        }
        Stimulus::Release { signal } => {
            let address = forced_place(signal, names, bench, step, out)?;
            vec![(Span::ZERO, Act::Command(Command::Unforce(address), expected(step)))]
        }
        Stimulus::Write { of, value } => {
            let observable = match names.meaning(of)? {
                NameMeaning::Inside(observable) => observable,
                NameMeaning::OfBus => {
                    let help = "a value in a frame is put on its bus with `send`";
                    out.error(codes::NOT_WRITABLE, step.span.clone(), format!("`{of}` is no variable"), help);
                    return None;
                }
                NameMeaning::Channel(channel, _) => {
                    let message = format!("`{of}` is no variable and no place in memory");
                    let help = match of_controller(channel, bench) {
                        true => "an output of the controller is driven from outside with `force`",
                        false => "a line is driven with `set`",
                    };
                    let help = match of.starts_with('%') {
                        true => format!(
                            "in a plan `{of}` is the terminal: {help}; the bit of the process image is {{ image = \"{of}\" }}, \
                             bound under `signals`"
                        ),
                        false => String::from(help),
                    };
                    out.error(codes::NOT_WRITABLE, step.span.clone(), message, help);
                    return None;
                }
            };
            if !step.refused && !is_written(observable.probe) {
                let message = format!("`{of}` can only be read");
                let help = "write a variable of the program, a place such as %MW0, or one of PLC_W";
                out.error(codes::NOT_WRITABLE, step.span.clone(), message, help);
                return None;
            }
            let written = match value {
                Literal::Value(value) => Some(*value),
                // Whether the variable is a time is known where its type is: `beyond_target` of the check.
                _ => value.value().filter(|_| {
                    matches!(observable.probe, Probe::Variable(_))
                        && value.quantity().is_some_and(|quantity| quantity.is_time())
                }),
            };
            let Some(value) = written else {
                let plain = value.quantity().is_some_and(|quantity| quantity.unit.is_none());
                let is_place = matches!(observable.probe, Probe::Address(_));
                let help = match plain {
                    true => "a number that is written has at most 64 bits",
                    false if is_place => {
                        "write TRUE, FALSE or a number without a unit: a place, and a variable at one, has bits alone"
                    }
                    false => {
                        "write TRUE, FALSE or a number without a unit; a variable of type TIME takes a duration, as in \"500 ms\""
                    }
                };
                let message = match plain {
                    true => format!("{value} does not fit into `{of}`"),
                    false => format!("`{of}` takes a plain number"),
                };
                out.error(codes::VALUE_MISFIT, step.span.clone(), message, help);
                return None;
            };
            if matches!(value, Value::Real(_)) && observable.kind != ValueKind::Real {
                let help = "only a REAL or LREAL has a value with a part after the point";
                out.error(
                    codes::VALUE_MISFIT,
                    step.span.clone(),
                    format!("`{of}` takes a whole number"),
                    help,
                );
                return None;
            }
            vec![(Span::ZERO, Act::Write(observable.probe, value, expected(step)))]
        }
        Stimulus::Command(command) => {
            let command = match command {
                plans::steps::PlanCommand::Run => Command::Run,
                plans::steps::PlanCommand::Stop => Command::Stop,
                plans::steps::PlanCommand::ResetWarm => Command::ResetWarm,
                plans::steps::PlanCommand::ResetCold => Command::ResetCold,
                plans::steps::PlanCommand::Login => Command::LogIn,
                plans::steps::PlanCommand::Logout => Command::LogOut { keep_forcing: false },
                plans::steps::PlanCommand::LogoutKeepForcing => Command::LogOut { keep_forcing: true },
                plans::steps::PlanCommand::IdentifyOn => Command::Identify(true),
                plans::steps::PlanCommand::IdentifyOff => Command::Identify(false),
                plans::steps::PlanCommand::ResetOrigin => Command::ResetOrigin,
                plans::steps::PlanCommand::Reboot => Command::Reboot,
                plans::steps::PlanCommand::CreateBootApplication => Command::CreateBootApplication,
                plans::steps::PlanCommand::DeleteApplication => Command::DeleteApplication,
            };
            vec![(Span::ZERO, Act::Command(command, expected(step)))]
        }
        Stimulus::Switch(run) => vec![(Span::ZERO, Act::Command(Command::Switch(*run), Expected::Obeyed))],
        Stimulus::Download { program, boot } => {
            let bundle = bundle(program.as_ref(), step, bench, out)?;
            let command = if *boot { Command::Download(bundle) } else { Command::DownloadToMemory(bundle) };
            vec![(Span::ZERO, Act::Command(command, expected(step)))]
        }
        Stimulus::OnlineChange(program) => {
            let bundle = bundle(Some(program), step, bench, out)?;
            vec![(Span::ZERO, Act::Command(Command::OnlineChange(bundle), expected(step)))]
        }
        Stimulus::Breakpoint { line, file } => {
            let file = source_file(file.as_deref(), step, bench, out)?;
            let command = Command::Breakpoint { file, line: *line };
            vec![(Span::ZERO, Act::Command(command, expected(step)))]
        }
        Stimulus::SetClock { seconds } => {
            vec![(Span::ZERO, Act::Command(Command::SetClock { seconds: *seconds }, expected(step)))]
        }
        Stimulus::ClearBreakpoints => {
            vec![(Span::ZERO, Act::Command(Command::ClearBreakpoints, expected(step)))]
        }
        Stimulus::Resume => vec![(Span::ZERO, Act::Command(Command::Resume, expected(step)))],
        Stimulus::StepStatement => vec![(Span::ZERO, Act::Command(Command::StepStatement, expected(step)))],
        Stimulus::MultipleDownload { program, start } => {
            let bundle = bundle(program.as_ref(), step, bench, out)?;
            let command = Command::MultipleDownload { bundle, start: *start };
            vec![(Span::ZERO, Act::Command(command, expected(step)))]
        }
        Stimulus::PlaceBootApplication(program) => {
            let bundle = bundle(program.as_ref(), step, bench, out)?;
            vec![(Span::ZERO, Act::Command(Command::PlaceBootApplication(bundle), expected(step)))]
        }
        Stimulus::ResetOriginDevice { user_management, plc_logic, certificates } => {
            let reset = DeviceReset {
                user_management: *user_management,
                plc_logic: *plc_logic,
                certificates: *certificates,
            };
            vec![(Span::ZERO, Act::Command(Command::ResetOriginDevice(reset), expected(step)))]
        }
        Stimulus::Firmware(valid) => {
            vec![(Span::ZERO, Act::Command(Command::Firmware { valid: *valid }, expected(step)))]
        }
        Stimulus::PowerCut(lasts) => vec![(Span::ZERO, Act::Power(false)), (*lasts, Act::Power(true))],
        Stimulus::Power(on) => vec![(Span::ZERO, Act::Power(*on))],
        Stimulus::Overload { task, cycle, times } => {
            let Some(task) = bench.subject.task(task) else {
                let help = known_tasks(task, bench);
                out.error(codes::NO_TASK, step.span.clone(), format!("there is no task `{task}`"), help);
                return None;
            };
            vec![(Span::ZERO, Act::Overload { task, cycle: *cycle, times: *times })]
        }
        Stimulus::Suspend { task, lasts } => {
            let Some(task) = bench.subject.task(task) else {
                let help = known_tasks(task, bench);
                out.error(codes::NO_TASK, step.span.clone(), format!("there is no task `{task}`"), help);
                return None;
            };
            vec![(Span::ZERO, Act::Suspend { task, lasts: *lasts })]
        }
        Stimulus::SetPlant { plant, parameter, value, lasts } => {
            let (plant, place, set) = plant_parameter(plant, parameter, value, bench, step, out)?;
            let initial = bench.file.circuit.plants[plant].parameters()[place].initial;
            let act = Act::SetPlant { plant, parameter: place, value: set, for_a_time: lasts.is_some() };
            let back = lasts.map(|lasts| (lasts, Act::RestorePlant { plant, parameter: place, initial }));
            std::iter::once((Span::ZERO, act)).chain(back).collect()
        }
        Stimulus::Fault { signal, kind, lasts } => {
            let channel = line(signal, names, step, out)?;
            let kind = fault_kind(kind, channel, bench, step, out)?;
            vec![(Span::ZERO, Act::Fault(Fault { channel, kind, lasts: *lasts }))]
        }
        Stimulus::File { path, deed, by_application } => {
            let user = if *by_application { FileUser::Application } else { FileUser::Service };
            let act = FileAction { path: path.clone(), deed: deed.clone(), user };
            vec![(Span::ZERO, Act::File(act, expected(step)))]
        }
        Stimulus::Disturb { what, on, lasts } => {
            let begin = disturbance(*what, *on, bench, step, out)?;
            let end = lasts.and_then(|lasts| Some((lasts, disturbance(*what, !on, bench, step, out)?)));
            let acts = std::iter::once((Span::ZERO, begin)).chain(end);
            acts.map(|(after, what)| (after, Act::Disturb(what))).collect()
        }
        Stimulus::Clear { signal } => vec![(Span::ZERO, Act::Clear(line(signal, names, step, out)?))],
        // What a question does is added where its answer is recorded.
        Stimulus::Mark | Stimulus::Run { .. } | Stimulus::Ask(_) => Vec::new(),
    };
    // A relay takes its time to put a fault on a wire.
    let relay = acts.iter().find_map(|(_, act)| match act {
        Act::Fault(fault) => Some(fault.channel),
        Act::Clear(channel) => Some(*channel),
        _ => None,
    });
    let settle = relay.map_or(Span::ZERO, |channel| bench.board.fault_switching_time(channel));
    let lasts = step.stimulus.duration() + settle;
    let (id, phase, repeat, parent) = (step.id.clone(), step.part, step.repeat.clone(), step.parent);
    Some(PlannedStep { id, mark, done, phase, timing, repeat, parent, acts, generator: generates, lasts })
}

/// The place of a source in its application: as a step names it, relative to the plan; the first one where it names
/// none.
fn source_file(
    name: Option<&str>,
    step: &PlanStep,
    bench: &TestBench<'_>,
    out: &mut Findings,
) -> Option<u16> {
    let Some(name) = name else { return Some(0) };
    let files = || bench.subject.catalogue().into_iter().flat_map(Catalogue::source_files);
    let found = files().find(|(_, known)| *known == name || known.ends_with(&format!("/{name}")));
    if found.is_none() {
        let help = suggestion(name, files().map(|(_, known)| known));
        out.error(
            codes::NO_SOURCE,
            step.span.clone(),
            format!("no program of the plan has the source `{name}`"),
            help,
        );
    }
    found.map(|(place, _)| place)
}

/// What goes wrong, with its output found on the bench.
fn disturbance(
    what: plans::steps::DisturbanceKind,
    on: bool,
    bench: &TestBench<'_>,
    step: &PlanStep,
    out: &mut Findings,
) -> Option<Disturbance> {
    use plans::steps::{DisturbanceKind, InternalErrorKind, ModuleFaultKind};
    let mut output = |address: Address| match IoChannel::at(address, bench.reference) {
        Some(IoChannel::Output(output)) => Some(output),
        _ => {
            let (code, message, help) = match of_module(address, bench) {
                Some((message, help)) => (codes::FAULT_NOT_AVAILABLE, message, help),
                None => {
                    (codes::NO_TERMINAL, format!("no output is at {address}"), no_terminal(address, bench))
                }
            };
            out.error(code, step.span.clone(), message, help);
            None
        }
    };
    Some(match what {
        DisturbanceKind::ShortCircuit(address) => Disturbance::ShortCircuit { output: output(address)?, on },
        DisturbanceKind::OverTemperature(address) => {
            Disturbance::OverTemperature { output: output(address)?, on }
        }
        DisturbanceKind::NoIoSupply => Disturbance::IoSupply(!on),
        DisturbanceKind::External(bit) if FAULT_BITS.contains(&bit) => Disturbance::ExternalError { bit, on },
        DisturbanceKind::Internal(kind) => Disturbance::InternalError(match kind {
            InternalErrorKind::HardwareWatchdog => InternalError::HardwareWatchdog,
            InternalErrorKind::Firmware => InternalError::Firmware,
            InternalErrorKind::FirmwareException => InternalError::FirmwareException,
        }),
        DisturbanceKind::Module { index, fault } => {
            let index = usize::from(index);
            let Some((_, module)) = bench.modules.iter().find(|(known, _)| *known == index) else {
                let known: Vec<String> = bench.modules.iter().map(|(index, _)| index.to_string()).collect();
                let help = match known.is_empty() {
                    true => String::from("configure modules in `settings`"),
                    false => format!("those with a module are {}", known.join(", ")),
                };
                let message = format!("no module is configured at index {index}");
                out.error(codes::NO_MODULE, step.span.clone(), message, help);
                return None;
            };
            if fault == ModuleFaultKind::Unsupplied && !module.has_own_supply() {
                let message = format!("{} has no supply of its own", module.reference);
                let help = "modules with analogue channels or transistor outputs have one; `supply-bus` is the supply of the bus";
                out.error(codes::FAULT_NOT_AVAILABLE, step.span.clone(), message, help);
                return None;
            }
            let fault = match fault {
                ModuleFaultKind::Silent(exchanges) => {
                    ModuleFault::Silent(if on { exchanges } else { Some(0) })
                }
                ModuleFaultKind::Pulled => ModuleFault::Pulled(on),
                ModuleFaultKind::Replaced(module) => ModuleFault::Replaced(module.filter(|_| on)),
                ModuleFaultKind::Disturbs => ModuleFault::Disturbs(on),
                ModuleFaultKind::Unsupplied => ModuleFault::Unsupplied(on),
            };
            Disturbance::Module { index, fault }
        }
        DisturbanceKind::Battery(charge) => Disturbance::Battery { charge },
        DisturbanceKind::NoBusSupply => Disturbance::BusSupply(!on),
        DisturbanceKind::NoBusLink if on && !bench.linked => {
            let help = "write TM3XTRA1 and TM3XREC1 into `settings.modules`";
            out.error(
                codes::NO_MODULE,
                step.span.clone(),
                "no transmitter and receiver are configured",
                help,
            );
            return None;
        }
        DisturbanceKind::NoBusLink => Disturbance::BusLink(!on),
        DisturbanceKind::External(bit) => {
            let bits: Vec<String> = FAULT_BITS.iter().map(u8::to_string).collect();
            let help = format!("the others are {}", bits.join(", "));
            out.error(codes::VALUE_MISFIT, step.span.clone(), format!("bit {bit} is reserved"), help);
            return None;
        }
    })
}

/// What is wrong with a short circuit or heat at an output of a module, and what to write in its place.
fn of_module(address: Address, bench: &TestBench<'_>) -> Option<(String, String)> {
    let catalogue = bench.subject.catalogue()?;
    let terminal = catalogue.module_terminals().at(address, address.bit_len()).next()?;
    let message = format!(
        "{address} is {terminal} of {}, and only embedded outputs have a model of short circuits and heat",
        terminal.reference()
    );
    let help = format!(
        "put a fault on its line, as in fault = {{ signal = \"{terminal}\", kind = \"short-to-ground\" }}"
    );
    Some((message, help))
}

/// The bundle of the program that a step brings: of the case's own one where it names none.
fn bundle(
    program: Option<&ProgramRef>,
    step: &PlanStep,
    bench: &TestBench<'_>,
    out: &mut Findings,
) -> Option<Vec<u8>> {
    let bundle = match program {
        None => Some(bench.bundle).filter(|bundle| !bundle.is_empty()),
        Some(program) => {
            bench.others.iter().find(|(known, _)| known == program).map(|(_, bundle)| bundle.as_slice())
        }
    };
    if bundle.is_none() {
        let help = "give the plan a `program`, or the step: it is what is transferred";
        out.error(codes::NOT_DOWNLOADABLE, step.span.clone(), "there is no application to transfer", help);
    }
    bundle.map(<[u8]>::to_vec)
}

/// Whether a tool can write what a probe looks at, in some state of the controller. A register has its own answer for each write.
fn is_written(probe: Probe) -> bool {
    match probe {
        Probe::Address(_) | Probe::Variable(_) | Probe::Register(_) => true,
        Probe::System(variable) => variable.is_writable(),
        _ => false,
    }
}

const fn expected(step: &PlanStep) -> Expected {
    if step.refused { Expected::Refused } else { Expected::Obeyed }
}

fn awaited(
    awaits: &StepCondition,
    info: &SignalInfo,
    step: &PlanStep,
    out: &mut Findings,
) -> Option<AwaitedChange> {
    let change = awaits.bind(info);
    if change.is_none() {
        let message = format!("`{}` cannot have this value", info.name);
        let labels: Vec<&str> = info.labels.iter().map(|(_, label)| label.as_str()).collect();
        let help = if labels.is_empty() { String::new() } else { format!("it can be {}", labels.join(", ")) };
        out.error(codes::VALUE_MISFIT, step.span.clone(), message, help);
    }
    change
}

/// What a place of %I or %Q is forced to, as it lies there; `None` for what it does not take.
fn forced_value(address: Address, literal: &Literal) -> Option<u64> {
    let Literal::Value(value) = literal else { return None };
    TakenValues::of_place(address).forced(*value)
}
