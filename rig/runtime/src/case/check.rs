//! What a bench shows of a case before anything moves: values that its signals cannot have, signals that nothing can
//! move, needs that it does not meet.

use crate::application::taken_values::TakenValues;
use crate::case::needs::{Unmet, unmet};
use crate::codes;
use crate::generator::StimulusGenerator;
use crate::prepare::PreparedCase;
use crate::schedule::{Act, PlannedStep, Timing};
use crate::subject::Subject;
use crate::suite::case_files::CaseFiles;
use document::Diagnostic;
use drivers::{Board, BoardFile, ChannelId};
use plans::bench::{Doubt, SignalBounds, doubt};
use plans::expect::{ClaimDemand, Expectation};
use plans::lang::Literal;
use plans::plan::DelayModel;
use plans::signals::{FileFigure, RowFigure, SignalBinding, SignalSource, TaskFigure};
use plans::steps::Stimulus;
use plans::{Case, PlanStep};
use profile::Profile;
use signal::{SignalId, SignalInfo, Span, ValueKind};

/// What is looked at.
pub(crate) struct CaseOnBench<'a> {
    pub(crate) case: &'a Case,
    pub(crate) files: &'a CaseFiles,
    pub(crate) subject: &'a dyn Subject,
    pub(crate) board: &'a dyn Board,
    pub(crate) prepared: &'a PreparedCase,
}

/// Errors in the claims of a case, and what is worth knowing about them.
pub(crate) fn claims(looked: &CaseOnBench<'_>) -> Vec<Diagnostic> {
    let case = looked.case;
    let signals = looked.prepared.trace.signals();
    let bounds = |name: &str| looked.bounds(name);
    let moved = MovableChannels::new(looked.board, &looked.files.board, &looked.prepared.steps);
    let guards = case.invariants.iter().map(|guard| &guard.expectation);
    let mut found = Vec::new();
    for expectation in case.expectations.iter().chain(guards) {
        if let Some(one) = looked.compared_with_itself(expectation) {
            found.push(at(one, looked, expectation));
            continue;
        }
        let one = match doubt(&*expectation.claim, signals, &bounds) {
            Some(Doubt::Never(why)) => {
                let names = expectation.claim.signals();
                let is_word = |info: &SignalInfo| info.kind == ValueKind::Word && names.contains(&info.name);
                let help = match signals.iter().any(is_word) {
                    true => {
                        "claim a value that it can have; a place has no sign, nor has a variable at one: copy it into a variable without an address"
                    }
                    false => "claim a value that it can have",
                };
                Diagnostic::error(codes::CLAIM_WITHOUT_CHOICE, format!("the claim can never be met: {why}"))
                    .help(help)
            }
            Some(Doubt::Always(why)) => {
                let help = "narrow the limits, or remove the claim";
                Diagnostic::error(codes::CLAIM_WITHOUT_CHOICE, format!("the claim can never fail: {why}"))
                    .help(help)
            }
            Some(Doubt::Blind(why)) => {
                let help = "widen the limits, or record the signal more finely";
                Diagnostic::warning(codes::LIMIT_TOO_CLOSE, format!("the claim can never pass: {why}"))
                    .help(help)
            }
            None => match looked.unmoved(expectation, &moved) {
                Some(found) => found,
                None => continue,
            },
        };
        found.push(at(one, looked, expectation));
    }
    found.extend(case.steps.iter().filter_map(|step| looked.beyond_target(step)));
    found.extend(looked.faults_in_worst_case());
    for (step, planned) in case.steps.iter().zip(&looked.prepared.steps) {
        let Timing::When { signal, .. } = &planned.timing else { continue };
        if let Some(channel) = looked.channel_of(*signal).filter(|channel| moved.is_still(*channel)) {
            let name = &looked.board.channels()[usize::from(channel.0)].name;
            let message = format!("the step `{}` waits for `{name}`, which nothing moves", step.id);
            let found_one = Diagnostic::warning(codes::SIGNAL_NOT_MOVED, message).help(STILL);
            found.push(found_one.at(&looked.files.plan.name, step.span.clone(), ""));
        }
    }
    found
}

const STILL: &str = "drive it in a step, or let a wire or plant of the board reach it";

/// What the bench lacks for the case to get a verdict at all.
pub(crate) fn needs(looked: &CaseOnBench<'_>) -> Option<Diagnostic> {
    let (Unmet::Power(reason) | Unmet::Instrument(reason)) =
        unmet(looked.case, looked.subject, looked.board, Span::ZERO)?;
    Some(no_verdict(looked.files, &reason))
}

/// What the bench lacks, in words.
pub(crate) fn no_verdict(files: &CaseFiles, reason: &str) -> Diagnostic {
    let message = format!("the case gets no verdict here: {reason}");
    let found = Diagnostic::warning(codes::NEED_NOT_MET, message).at(&files.plan.name, 0..0, "");
    found.help("ask for less in `needs`, slow the train down, or name another board")
}

/// A case that runs nowhere: it holds for another profile than that of its board, or its reference is of another one.
pub(crate) fn profile(case: &Case, files: &CaseFiles) -> Option<Diagnostic> {
    // A board that was given for this run says nothing of the others.
    let is_own = files.own_board || case.board.is_none() && files.board_text.is_empty();
    if !is_own {
        return None;
    }
    let (message, help) = if case.profiles.is_empty() || case.profiles.contains(&files.profile) {
        of_another_profile(case, files)?
    } else {
        let only: Vec<&str> = case.profiles.iter().map(|profile| profile.name()).collect();
        let (only, name) = (only.join(", "), files.profile.name());
        let message =
            format!("no case of the plan ever runs: it holds for {only}, and its board is of {name}");
        (message, format!("add \"{name}\" to `profiles`, or name another board"))
    };
    Some(Diagnostic::warning(codes::PLAN_NEVER_RUNS, message).at(&files.plan.name, 0..0, "").help(help))
}

/// That a case with this reference runs on none of its profiles, and what helps.
fn of_another_profile(case: &Case, files: &CaseFiles) -> Option<(String, String)> {
    let (reference, name) = (files.reference, files.profile.name());
    if case.board.is_none() && case.profiles.iter().any(|profile| profile.accepts(reference)) {
        return None;
    }
    let fitting: Vec<&str> =
        Profile::ALL.iter().filter(|one| one.accepts(reference)).map(|one| one.name()).collect();
    let fitting = fitting.join(" or ");
    let own: Vec<&str> = files.profile.references().map(|one| one.name).collect();
    let (whose, or) = match &case.board {
        Some(_) => ("its board", format!("name a board of {fitting}")),
        None => ("the plan", format!("let `profiles` name {fitting}")),
    };
    let message = format!(
        "the case never runs: its reference {} is of {fitting}, and {whose} of {name}",
        reference.name
    );
    Some((message, format!("write a `reference` of {name}: {}; or {or}", own.join(", "))))
}

/// Adds where a claim stands.
fn at(found: Diagnostic, looked: &CaseOnBench<'_>, expectation: &Expectation) -> Diagnostic {
    match &expectation.place {
        Some(place) if !place.file.is_empty() => found.at(&*place.file, place.span.clone(), ""),
        _ => found.at(&looked.files.plan.name, 0..0, ""),
    }
}

impl CaseOnBench<'_> {
    fn binding(&self, name: &str) -> Option<&SignalBinding> {
        self.case.signals.iter().find(|binding| binding.name == name)
    }

    /// The values that a signal can have, where that is known.
    fn bounds(&self, name: &str) -> Option<SignalBounds> {
        Some(match &self.binding(name)?.source {
            SignalSource::Line(_) | SignalSource::Channel(_) => {
                let channel = self.channel(name)?;
                self.board.channels()[usize::from(channel.0)].is_digital().then_some(SignalBounds::LINE)?
            }
            SignalSource::Image(address) | SignalSource::Memory(address) => {
                SignalBounds::bits(address.size().bits())
            }
            // A name inside the subject goes before a channel of the same name, as where it is looked up.
            SignalSource::Path(path) => match self.subject.catalogue().and_then(|names| names.bounds(path)) {
                Some((least, most)) => SignalBounds::new(least, most),
                None if self
                    .channel(name)
                    .is_some_and(|channel| self.board.channels()[usize::from(channel.0)].is_digital()) =>
                {
                    SignalBounds::LINE
                }
                None => return None,
            },
            SignalSource::Task { figure: TaskFigure::Load, .. } | SignalSource::FrameSignal(_) => {
                return None;
            }
            SignalSource::Task { .. } | SignalSource::Log(_) | SignalSource::Frames(_) => SignalBounds::COUNT,
            SignalSource::File { asks: FileFigure::Exists | FileFigure::Holds(_), .. } => SignalBounds::BIT,
            SignalSource::File { .. } => SignalBounds::COUNT,
            SignalSource::Register { exception: false, .. } => SignalBounds::bits(16),
            SignalSource::Register { exception: true, .. } => SignalBounds::bits(8),
            SignalSource::Relocation { figure: RowFigure::Valid, .. } => SignalBounds::BIT,
            SignalSource::Relocation { .. } => SignalBounds::new(-1, 65_535),
        })
    }

    /// A step that writes a value which its variable or place does not take: it would be cut without a word
    /// (controller:DT-01).
    fn beyond_target(&self, step: &PlanStep) -> Option<Diagnostic> {
        let Stimulus::Write { of, value: literal } = &step.stimulus else { return None };
        let value = literal.value()?;
        let taken = match &self.binding(of)?.source {
            SignalSource::Path(path) => self.subject.catalogue()?.taken(path)?,
            SignalSource::Image(address) | SignalSource::Memory(address) => TakenValues::of_place(*address),
            SignalSource::Register { exception: false, .. } => TakenValues::WORD,
            _ => return None,
        };
        // A duration is the nanoseconds that a time holds, and no number.
        let is_kind = matches!(literal, Literal::Value(_)) || matches!(taken, TakenValues::Nanoseconds(..));
        if is_kind && taken.takes(value) {
            return None;
        }
        let message = format!("`{of}` cannot have the value that the step `{}` writes", step.id);
        let found = Diagnostic::error(codes::VALUE_MISFIT, message).help(format!("it takes {taken}"));
        Some(found.at(&self.files.plan.name, step.span.clone(), ""))
    }

    /// Faults on lines of outputs whose edges are intervals: what such a line shows is not followed.
    fn faults_in_worst_case(&self) -> impl Iterator<Item = Diagnostic> {
        let is_worst = self.case.model == DelayModel::WorstCase && !self.files.board.subject.is_external();
        let steps = self.case.steps.iter().zip(&self.prepared.steps).filter(move |_| is_worst);
        steps.filter_map(|(step, planned)| {
            let wiring = &self.prepared.wiring;
            let on_output = |act: &Act| match act {
                Act::Fault(fault) => wiring.outputs().any(|(_, channel)| channel == fault.channel),
                _ => false,
            };
            planned.acts.iter().find(|(_, act)| on_output(act))?;
            let message =
                format!("the step `{}` puts a fault on an output in the worst case of the model", step.id);
            let found = Diagnostic::error(codes::FAULT_IN_WORST_CASE, message);
            let found = found.help("put it on the line of an input, or remove `model = \"worst case\"`");
            Some(found.at(&self.files.plan.name, step.span.clone(), ""))
        })
    }

    /// The channel that a signal shows.
    fn channel(&self, name: &str) -> Option<ChannelId> {
        let signal = self.prepared.trace.find(name)?;
        self.channel_of(signal)
    }

    fn channel_of(&self, signal: SignalId) -> Option<ChannelId> {
        let channels = &self.prepared.wiring.channels;
        let place = channels.iter().position(|signals| signals.contains(&signal))?;
        u16::try_from(place).ok().map(ChannelId)
    }

    /// A claim that holds two signals against each other which are two names of one thing.
    fn compared_with_itself(&self, expectation: &Expectation) -> Option<Diagnostic> {
        let demands = expectation.claim.demands();
        let (one, other) = demands.iter().find_map(|demand| match demand {
            ClaimDemand::Differ(one, other) if self.is_same(one, other) => Some((one, other)),
            _ => None,
        })?;
        let message = format!(
            "`{one}` and `{other}` are one signal under two names: the claim compares it with itself"
        );
        Some(Diagnostic::error(codes::CLAIM_WITHOUT_CHOICE, message).help("name two signals that can differ"))
    }

    /// Whether two names stand for one thing, a line, a variable, a place of memory, of which the same is recorded.
    fn is_same(&self, one: &str, other: &str) -> bool {
        let trace = &self.prepared.trace;
        let policy = |name| trace.find(name).map(|signal| trace.signals()[signal.0 as usize].policy);
        if policy(one) != policy(other) {
            return false;
        }
        let source = |name| self.binding(name).map(|binding| &binding.source);
        if source(one).is_some_and(|source_of_one| Some(source_of_one) == source(other)) {
            return true;
        }
        let (Some(one), Some(other)) = (trace.find(one), trace.find(other)) else {
            return false;
        };
        let wiring = &self.prepared.wiring;
        let mut shown = wiring.channels.iter().chain(&wiring.probes);
        shown.any(|signals| signals.contains(&one) && signals.contains(&other))
    }

    /// A claim that needs a change of a line that nothing moves, or a look at one that the rig cannot see.
    fn unmoved(&self, expectation: &Expectation, moved: &MovableChannels) -> Option<Diagnostic> {
        for name in expectation.claim.signals() {
            let Some(channel) = self.channel(&name) else { continue };
            if !self.board.channels()[usize::from(channel.0)].senses {
                let message = format!("the rig cannot see `{name}`: its channel has `senses = false`");
                return Some(
                    Diagnostic::warning(codes::SIGNAL_NOT_MOVED, message).help("look at another signal"),
                );
            }
        }
        let still = expectation.claim.demands().into_iter().find_map(|demand| match demand {
            ClaimDemand::Change(signal) => {
                let channel = self.channel(signal)?;
                moved.is_still(channel).then(|| signal.to_owned())
            }
            _ => None,
        })?;
        let message = format!("the claim can never be met: nothing moves `{still}`");
        Some(Diagnostic::warning(codes::SIGNAL_NOT_MOVED, message).help(STILL))
    }
}

/// Which channels of a board something can move.
struct MovableChannels {
    channels: Vec<bool>,
}

impl MovableChannels {
    fn new(board: &dyn Board, file: &BoardFile, steps: &[PlannedStep]) -> MovableChannels {
        // What is outside of the rig may move any real line.
        let mut moved = MovableChannels { channels: vec![file.is_real(); board.channels().len()] };
        // What an output is bound to the controller drives.
        for binding in file.bind.iter().filter(|binding| binding.address.area() == signal::Area::Output) {
            moved.mark(binding.channel);
        }
        file.circuit.wires.iter().for_each(|wire| moved.mark(wire.to));
        let driven = file.circuit.plants.iter().flat_map(|plant| plant.outputs());
        driven.for_each(|port| moved.mark(port.channel));
        for step in steps {
            for (_, act) in &step.acts {
                match act {
                    Act::Drive(channel, _) | Act::Restore(channel) | Act::Clear(channel) => {
                        moved.mark(*channel)
                    }
                    Act::Fault(fault) => moved.mark(fault.channel),
                    _ => {}
                }
            }
            step.generator
                .iter()
                .flat_map(StimulusGenerator::channels)
                .for_each(|channel| moved.mark(channel));
        }
        moved
    }

    fn mark(&mut self, channel: ChannelId) {
        if let Some(moved) = self.channels.get_mut(usize::from(channel.0)) {
            *moved = true;
        }
    }

    fn is_still(&self, channel: ChannelId) -> bool {
        self.channels.get(usize::from(channel.0)) == Some(&false)
    }
}
