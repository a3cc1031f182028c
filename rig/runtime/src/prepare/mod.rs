//! From the names of a plan to terminals, channels, probes and signals.

mod alarms;
mod emission;
mod file_signals;
mod function_lines;
mod lines;
mod meaning;
mod plants;
mod signals;
mod steps;
mod waves;

use crate::frames::{self, FrameWatch};
use crate::schedule::{Act, PlannedStep};
use crate::subject::external::NOT_RUNNING;
use crate::subject::{Subject, SubjectExt};
use crate::suite::file_source::beside;
use crate::suite::ports;
use crate::wiring::Wiring;
use controller::{Probe, State};
use document::{Diagnostic, Findings};
use drivers::{Board, BoardFile};
use meaning::{NameMeaning, SignalMeanings, meaning};
use plans::Case;
use plans::signals::{SignalBinding, SignalSource};
use plans::steps::{CasePart, ProgramRef};
use plans::steps::{Question, Stimulus};
use profile::{ModuleType, Profile, Reference};
use signal::{SignalId, SignalInfo, Span, Trace, ValueKind};
use signals::{by_clock, channel_info, clocked, define, delayed, policy};
use std::sync::Arc;
use steps::plan_step;

pub use alarms::ArmedAlarm;
pub(crate) use lines::{NOT_PROMISED, fault_on};

/// What the names of a case are looked up in.
pub struct TestBench<'a> {
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
    /// The expansion modules that are configured, with their indices in TM3_MODULE_R.
    pub modules: &'a [(usize, &'static ModuleType)],
    /// Transmitter and receiver are configured.
    pub linked: bool,
    /// The application that a download step transfers where it names none; empty where there is none.
    pub bundle: &'a [u8],
    /// The programs that steps bring, as bundles.
    pub others: &'a [(ProgramRef, Vec<u8>)],
    /// The seed of what stimuli leave to chance.
    pub seed: u64,
    /// Whether the clock is exact.
    pub exact: bool,
}

impl std::fmt::Debug for TestBench<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("TestBench").field("file", &self.file.name).finish_non_exhaustive()
    }
}

/// A case with every name resolved.
#[derive(Debug)]
pub struct PreparedCase {
    /// The trace with its signals defined.
    pub trace: Trace,
    /// Who is behind whom.
    pub wiring: Wiring,
    /// The steps.
    pub steps: Vec<PlannedStep>,
    /// Observed probes with their signals, to be read once at the start.
    pub probes: Vec<(Probe, SignalId)>,
    /// The alarms.
    pub alarms: Vec<ArmedAlarm>,
    /// What is wrong with the plan and does not keep it from running.
    pub warnings: Vec<Diagnostic>,
}

/// The labels of the signal `state`.
pub fn state_labels() -> Vec<(i64, String)> {
    State::ALL.iter().map(|state| (state.number(), state.name().to_owned())).collect()
}

/// The signal `state` of the controller of a board file.
pub(crate) fn state_info(file: &BoardFile) -> SignalInfo {
    let mut labels = state_labels();
    if file.subject.is_external() {
        let (number, name) = NOT_RUNNING;
        labels.push((number, name.to_owned()));
    }
    SignalInfo { labels, ..SignalInfo::exact("state", ValueKind::State) }
}

/// The signal that shows what was answered.
fn answers(step: &str, question: &Question) -> SignalInfo {
    let labels = question.answers.iter().enumerate().map(|(place, answer)| (place as i64, answer.clone()));
    SignalInfo { labels: labels.collect(), ..SignalInfo::exact(format!("answer:{step}"), ValueKind::State) }
}

/// Resolves the names of a case and defines its signals in `trace`.
///
/// # Errors
/// Findings with their places in the plan: names that mean nothing on this bench, values that do not fit.
pub fn prepare(
    case: &Case,
    plan: &document::SourceFile,
    mut trace: Trace,
    bench: &mut TestBench<'_>,
) -> Result<PreparedCase, Vec<Diagnostic>> {
    let mut out = Findings::new(plan, plans::TOML);
    let mut wiring = Wiring::of(bench.file, &*bench.subject, bench.board.channels().len());
    if !bench.file.subject.is_external() {
        wiring.ports = ports::wired(bench.file, bench.reference);
    }
    wiring.state = define(&mut trace, state_info(bench.file), &mut out);
    if let (Some(probe), Some(state)) = (bench.subject.state_probe(), wiring.state) {
        wiring.show_probe(probe, state);
    }
    let mut signals = Signals::default();
    let mut foreign = Vec::new();
    for binding in &case.signals {
        // What is wrong with a name is shown in the file that gives it.
        let Some(file) = &binding.file else {
            signals.add(binding, case, &mut trace, &mut wiring, bench, &mut out);
            continue;
        };
        let mut own = Findings::new(&document::SourceFile::new(&**file, ""), plans::TOML);
        signals.add(binding, case, &mut trace, &mut wiring, bench, &mut own);
        foreign.extend(own.into_vec());
    }
    let Signals { names, probes } = signals;
    for (mark, place) in [("step:start", &mut wiring.start), ("step:end", &mut wiring.end)] {
        *place = define(&mut trace, SignalInfo::exact(mark, ValueKind::Mark), &mut out);
    }
    for (phase, mark, place) in [
        (CasePart::Setup, "step:main", &mut wiring.main),
        (CasePart::Teardown, "step:teardown", &mut wiring.teardown),
        (CasePart::Teardown, "step:teardown.done", &mut wiring.closed),
    ] {
        if case.steps.iter().any(|step| step.part == phase) {
            *place = define(&mut trace, SignalInfo::exact(mark, ValueKind::Mark), &mut out);
        }
    }
    let mut steps = Vec::new();
    for step in &case.steps {
        let mark =
            define(&mut trace, SignalInfo::exact(format!("step:{}", step.id), ValueKind::Mark), &mut out);
        let done = define(
            &mut trace,
            SignalInfo::exact(format!("step:{}.done", step.id), ValueKind::Mark),
            &mut out,
        );
        let (Some(mark), Some(done)) = (mark, done) else { continue };
        let answer = match &step.stimulus {
            Stimulus::Ask(question) => define(&mut trace, answers(&step.id, question), &mut out),
            _ => None,
        };
        let names = SignalMeanings { list: &names, state: wiring.state };
        let planned = plan_step(step, mark, done, &names, &trace, bench, &mut out);
        steps.extend(planned.map(|mut planned| {
            if let (Stimulus::Ask(question), Some(signal)) = (&step.stimulus, answer) {
                let photo = question.photo.as_deref().map(|photo| beside(&plan.name, photo));
                let question = Question { photo, ..question.clone() };
                planned.acts.push((Span::ZERO, Act::Ask(Arc::new(question), signal)));
            }
            planned
        }));
    }
    let mut found = out.into_vec();
    found.extend(foreign);
    found.extend(function_lines::on_lines(&case.settings, &plan.name, bench));
    let names = SignalMeanings { list: &names, state: wiring.state };
    let alarms = alarms::alarms(case, &names, &mut trace, &mut found);
    if found.iter().any(Diagnostic::is_error) {
        return Err(found);
    }
    Ok(PreparedCase { trace, wiring, steps, probes, alarms, warnings: found })
}

/// The signals of a case as they are defined.
#[derive(Default)]
struct Signals {
    names: Vec<(String, NameMeaning, SignalId)>,
    probes: Vec<(Probe, SignalId)>,
}

impl Signals {
    /// Defines the signal of a bound name. Reports a name that means nothing on this bench.
    fn add(
        &mut self,
        binding: &SignalBinding,
        case: &Case,
        trace: &mut Trace,
        wiring: &mut Wiring,
        bench: &mut TestBench<'_>,
        out: &mut Findings,
    ) {
        if self.of_bus(binding, trace, wiring, bench, out) {
            return;
        }
        let found = file_signals::observable(binding, case, bench, out);
        let found = found.map(|found| found.map(NameMeaning::Inside));
        let Some(meaning) = found.unwrap_or_else(|| meaning(binding, bench, out)) else { return };
        let mut own = 0.0;
        let info = match meaning {
            NameMeaning::Channel(channel, _) => {
                let (earliest, latest) = wiring.delay_of(channel);
                let channel = &bench.board.channels()[usize::from(channel.0)];
                own = channel.deadband;
                let info = delayed(channel_info(&binding.name, channel), latest - earliest);
                by_clock(info, bench.file.clock.error)
            }
            NameMeaning::OfBus => return,
            NameMeaning::Inside(observable) => SignalInfo {
                labels: observable.labels(),
                ..SignalInfo::exact(&binding.name, observable.kind)
            },
        };
        let Some(policy) = policy(binding, &info, own, out) else { return };
        let info = clocked(SignalInfo { policy, ..info }, bench.exact);
        let Some(signal) = define(trace, info, out) else { return };
        match meaning {
            NameMeaning::Channel(channel, _) => wiring.channels[usize::from(channel.0)].push(signal),
            NameMeaning::OfBus => {}
            NameMeaning::Inside(observable) => {
                let probe = bench.subject.watch(observable.probe);
                wiring.show_probe(probe, signal);
                self.probes.push((observable.probe, signal));
            }
        }
        self.names.push((binding.name.clone(), meaning, signal));
    }

    /// Defines the signal of a name that stands for frames, or for a value in them; FALSE for other names. One of a bus
    /// that the board lacks has no signal: a case that speaks of it does not come here.
    fn of_bus(
        &mut self,
        binding: &SignalBinding,
        trace: &mut Trace,
        wiring: &mut Wiring,
        bench: &TestBench<'_>,
        out: &mut Findings,
    ) -> bool {
        let pattern = match &binding.source {
            SignalSource::Frames(pattern) => &**pattern,
            SignalSource::FrameSignal(source) => &source.pattern,
            _ => return false,
        };
        let Some((bus, known)) = frames::find(bench.board, &pattern.bus) else { return true };
        let info = match &binding.source {
            SignalSource::FrameSignal(source) => frames::value_info(&binding.name, source, known),
            _ => frames::count_info(&binding.name, known),
        };
        let Some(policy) = policy(binding, &info, 0.0, out) else { return true };
        let info = clocked(SignalInfo { policy, ..info }, bench.exact);
        let Some(signal) = define(trace, info, out) else { return true };
        wiring.follow(
            bus,
            match &binding.source {
                SignalSource::FrameSignal(source) => FrameWatch::reading(signal, source),
                _ => FrameWatch::counting(signal, Arc::new(pattern.clone())),
            },
        );
        self.names.push((binding.name.clone(), NameMeaning::OfBus, signal));
        true
    }
}
