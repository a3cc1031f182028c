//! The judge of one case.

use std::fmt;

use document::Diagnostic;
use record::{ClaimRecord, Verdict};
use signal::{Cause, Event, SignalInfo, Span, When};

use super::anchors::Anchors;
use super::live::Live;
use super::order::Orderer;
use super::{Finding, Monitor, NotJudged, Outcome, Scene, Wiring};
use crate::expect::{Expectation, Place, happens};
use crate::lang::Anchor;
use crate::measure::{Gauge, Measurement};

/// A step of the case, as far as the judge needs it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct StepFacts {
    /// Its id.
    pub id: String,
    /// It waits for an event (`when`), so that not coming is a failure. With the longest wait.
    pub awaited: Option<Span>,
    /// The signal that its train of pulses is emitted on.
    pub train: Option<String>,
    /// Line of the plan, from 1.
    pub line: u32,
}

/// What is to be judged of a case.
#[derive(Clone, Debug, Default)]
pub struct Scenario {
    /// The expectations, in the plan's order.
    pub expectations: Vec<Expectation>,
    /// The measurements, in the plan's order.
    pub measurements: Vec<Measurement>,
    /// The steps, in the plan's order: the place is that of [`Cause::Step`].
    pub steps: Vec<StepFacts>,
}

impl Scenario {
    /// All instants that claims and measurements hang on.
    fn anchors(&self) -> impl Iterator<Item = &Anchor> {
        let claims = self.expectations.iter().flat_map(|each| each.claim.anchors());
        claims.chain(self.measurements.iter().flat_map(Measurement::anchors))
    }

    /// Every signal that claims and measurements look at, in order of first use.
    pub fn signals(&self) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        let claims = self.expectations.iter().flat_map(|each| each.claim.signals());
        let measured = self.measurements.iter().flat_map(Measurement::signals);
        for name in claims.chain(measured) {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        names
    }

    fn train(&self, id: &str) -> Option<String> {
        self.steps.iter().find(|step| step.id == id)?.train.clone()
    }
}

/// Why the trace could not be read to its end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JudgeError {
    /// What the trace reported.
    pub fault: String,
}

impl fmt::Display for JudgeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the trace cannot be read: {}", self.fault)
    }
}

impl std::error::Error for JudgeError {}

/// The judge of one case: fed with the trace as it grows, then asked for the verdicts.
pub struct Judge {
    scenario: Scenario,
    signals: Vec<SignalInfo>,
    anchors: Anchors,
    live: Live,
    fed: u64,
}

impl fmt::Debug for Judge {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Judge")
            .field("scenario", &self.scenario)
            .field("fed", &self.fed)
            .finish_non_exhaustive()
    }
}

impl Judge {
    /// A judge for a case whose trace has these signals, in the order of their places.
    ///
    /// # Errors
    /// Findings about claims that these signals cannot answer: a name that the trace does not have, a label
    /// that a state does not have, a unit of another dimension.
    pub fn new(mut scenario: Scenario, signals: &[SignalInfo]) -> Result<Judge, Vec<Diagnostic>> {
        for step in scenario.steps.iter().filter(|step| step.awaited.is_some()) {
            scenario.expectations.push(happens::implied(step));
        }
        let mut found = Vec::new();
        let wiring = Wiring { signals };
        for expectation in &scenario.expectations {
            let known = found.len();
            expectation.claim.check(&wiring, &mut found);
            locate(&mut found[known..], expectation.place.as_ref());
        }
        for measurement in &scenario.measurements {
            let known = found.len();
            measurement.check(&wiring, &mut found);
            locate(&mut found[known..], measurement.place.as_ref());
        }
        if found.iter().any(Diagnostic::is_error) {
            return Err(found);
        }
        let anchors = Anchors::new(scenario.anchors(), |id| scenario.train(id), signals);
        let live = Live::new(&scenario.expectations, signals);
        Ok(Judge { scenario, signals: signals.to_vec(), anchors, live, fed: 0 })
    }

    /// The same judge for a case that nobody wants to end early: it does not watch the claims while the trace grows,
    /// and [`Judge::failed_early`] says no. The verdicts are the same at half the work.
    #[must_use]
    pub fn unhurried(mut self) -> Judge {
        self.live.rest();
        self
    }

    /// The next event of the trace, in its order.
    #[inline]
    pub fn feed(&mut self, event: &Event) {
        self.live.feed(event, self.fed);
        let news = self.anchors.feed(event, self.fed);
        self.fed += 1;
        if news {
            let now = event.at.earliest.as_nanos();
            let (signals, anchors) = (&self.signals, &self.anchors);
            let scene = Scene { signals, anchors, disordered: &[], open_from: Some(now) };
            self.live.news(&self.scenario.expectations, &scene, now);
        }
    }

    /// Whether some claim is lost whatever comes. Cheap enough to ask after every step and every change.
    pub fn failed_early(&mut self) -> bool {
        self.live.lost()
    }

    /// The verdicts at the end of a case. `end` is the end of the case where the trace has no mark of it.
    ///
    /// # Errors
    /// [`JudgeError`] if the trace cannot be read.
    pub fn finish(self, end: When, trace: &signal::Trace) -> Result<Outcome, JudgeError> {
        let events =
            trace.events().map(|event| event.map_err(|error| JudgeError { fault: error.to_string() }));
        self.finish_over(end, events, &|key| trace.note(key).map(str::to_owned))
    }

    /// Judges a recorded trace.
    ///
    /// # Errors
    /// [`JudgeError`] if the trace cannot be read.
    pub fn replay(mut self, end: When, trace: &signal::Trace) -> Result<Outcome, JudgeError> {
        self.live.rest();
        for event in trace.events() {
            self.feed(&event.map_err(|error| JudgeError { fault: error.to_string() })?);
        }
        self.finish(end, trace)
    }

    /// The verdicts over the events of a whole trace, which were all fed before. `note` gives the trace's
    /// notes: `task:0`, `file:0` name the writers.
    ///
    /// # Errors
    /// What `events` gives.
    pub fn finish_over<E>(
        mut self,
        end: When,
        events: impl Iterator<Item = Result<Event, E>>,
        note: &dyn Fn(&str) -> Option<String>,
    ) -> Result<Outcome, E> {
        self.anchors.end(end, self.fed);
        let disordered = self.live.disordered();
        let (signals, anchors) = (&self.signals, &self.anchors);
        let scene = Scene { signals, anchors, disordered: &disordered, open_from: None };
        let mut stage = Stage::new(&self.scenario, &scene);
        let last = scene.end();
        let mut place = 0;
        let mut fault = None;
        // Not a `for`: reading a whole trace is faster from the inside.
        events.for_each(|event| match event {
            Ok(event) => {
                if event.at.earliest.as_nanos() <= last {
                    stage.feed(&event, place);
                }
                place += 1;
            }
            Err(error) => {
                fault.get_or_insert(error);
            }
        });
        if let Some(fault) = fault {
            return Err(fault);
        }
        Ok(stage.finish(&self.scenario, &self.signals, note))
    }
}

/// Says of findings where the claim stands.
fn locate(found: &mut [Diagnostic], place: Option<&Place>) {
    let Some(place) = place.filter(|place| !place.file.is_empty()) else { return };
    for each in found.iter_mut().filter(|each| each.labels.is_empty()) {
        *each = each.clone().at(&*place.file, place.span.clone(), "");
    }
}

/// What follows the signals in the last reading.
enum Running {
    Claim(Result<Box<dyn Monitor>, NotJudged>),
    Gauge(Box<Result<Gauge, NotJudged>>),
}

/// A signal with those who follow it.
struct Line {
    orderer: Orderer,
    /// Place of the follower, and the slot under which it knows the signal.
    followers: Vec<(usize, usize)>,
    observed: bool,
}

/// The last reading.
struct Stage {
    running: Vec<Running>,
    lines: Vec<Line>,
}

impl Stage {
    fn new(scenario: &Scenario, scene: &Scene<'_>) -> Stage {
        let mut stage = Stage { running: Vec::new(), lines: Vec::new() };
        for at in 0..scene.signals.len() {
            let hold = scene.disordered.get(at).copied().unwrap_or(false);
            stage.lines.push(Line { orderer: Orderer::new(hold), followers: Vec::new(), observed: false });
        }
        for expectation in &scenario.expectations {
            stage.follow(&expectation.claim.signals(), scene);
            stage.running.push(Running::Claim(expectation.claim.start(scene)));
        }
        for measurement in &scenario.measurements {
            stage.follow(&measurement.signals(), scene);
            stage.running.push(Running::Gauge(Box::new(measurement.start(scene))));
        }
        stage
    }

    fn follow(&mut self, names: &[String], scene: &Scene<'_>) {
        let follower = self.running.len();
        for (slot, name) in names.iter().enumerate() {
            if let Some(at) = scene.signals.iter().position(|info| info.name == *name) {
                self.lines[at].followers.push((follower, slot));
            }
        }
    }

    #[inline]
    fn feed(&mut self, event: &Event, place: u64) {
        let Some(line) = self.lines.get_mut(event.signal.0 as usize) else { return };
        if line.followers.is_empty() {
            return;
        }
        line.observed = true;
        let (followers, running) = (&line.followers, &mut self.running);
        line.orderer.push(event, place, |seen| {
            for (follower, slot) in followers {
                running[*follower].feed(*slot, seen);
            }
        });
    }

    fn finish(
        mut self,
        scenario: &Scenario,
        signals: &[SignalInfo],
        note: &dyn Fn(&str) -> Option<String>,
    ) -> Outcome {
        for line in &mut self.lines {
            let (followers, running) = (&line.followers, &mut self.running);
            line.orderer.drain(|seen| {
                for (follower, slot) in followers {
                    running[*follower].feed(*slot, seen);
                }
            });
        }
        let unobserved = |names: &[String]| {
            let silent = |name: &&String| {
                signals.iter().position(|info| info.name == **name).is_none_or(|at| !self.lines[at].observed)
            };
            names.iter().find(silent).map(|name| format!("`{name}` was never observed"))
        };
        let writer = |cause| writer(cause, &scenario.steps, note);
        let (mut claims, mut measurements) = (Vec::new(), Vec::new());
        let mut running = self.running.into_iter();
        for (expectation, running) in scenario.expectations.iter().zip(running.by_ref()) {
            let Running::Claim(judged) = running else { continue };
            let finding = judged.map(Monitor::finish);
            let silent = unobserved(&expectation.claim.signals());
            claims.push(claim_record(expectation, finding, silent, &writer));
        }
        for (measurement, running) in scenario.measurements.iter().zip(running) {
            let Running::Gauge(taken) = running else { continue };
            let mut taken = match *taken {
                Ok(gauge) => gauge.finish(),
                Err(why) => measurement.untaken(&why.to_string()),
            };
            if let (Verdict::Inconclusive, Some(silent)) = (taken.verdict, unobserved(&measurement.signals()))
            {
                taken.reason = silent;
            }
            measurements.push(taken);
        }
        Outcome::of(claims, measurements)
    }
}

impl Running {
    #[inline]
    fn feed(&mut self, slot: usize, seen: &super::Seen) {
        match self {
            Running::Claim(Ok(monitor)) => monitor.feed(slot, seen),
            Running::Claim(Err(_)) => {}
            Running::Gauge(gauge) => {
                if let Ok(gauge) = gauge.as_mut() {
                    gauge.feed(seen);
                }
            }
        }
    }
}

fn claim_record(
    expectation: &Expectation,
    finding: Result<Finding, NotJudged>,
    silent: Option<String>,
    writer: &dyn Fn(Cause) -> String,
) -> ClaimRecord {
    let claim = &expectation.claim;
    let expected = claim.expected();
    let name = if expectation.name.is_empty() { expected.clone() } else { expectation.name.clone() };
    let mut record = ClaimRecord {
        name,
        verb: expectation.verb.to_owned(),
        expected,
        line: expectation.place.as_ref().map_or(0, |place| place.line),
        ..ClaimRecord::default()
    };
    let finding = match finding {
        Ok(finding) => finding,
        Err(why) => {
            record.verdict = Verdict::Inconclusive;
            record.reason = why.to_string();
            record.observed = String::from("not judged");
            return record;
        }
    };
    record.verdict = finding.verdict();
    record.reason = match (record.verdict, silent) {
        (Verdict::Pass, _) => String::new(),
        (Verdict::Inconclusive, Some(silent)) => silent,
        _ => finding.reason,
    };
    record.observed = finding.observed;
    record.margin = finding.margin;
    record.uncertainty = finding.uncertainty;
    record.window = finding.window;
    record.deciding_ns = finding.deciding.map(|at| [at.earliest.as_nanos(), at.latest.as_nanos()]);
    record.signal = claim.signals().into_iter().nth(finding.slot);
    record.last_writer = finding.cause.map(writer).filter(|writer| !writer.is_empty());
    let nearest = finding.nearest_miss.filter(|_| record.verdict != Verdict::Pass);
    record.nearest_miss = nearest.map(|(what, cause)| match cause.map(writer) {
        Some(writer) if !writer.is_empty() => format!("{what}, written by {writer}"),
        _ => what,
    });
    record
}

/// Who made a change, in the user's names; empty for nobody known.
fn writer(cause: Cause, steps: &[StepFacts], note: &dyn Fn(&str) -> Option<String>) -> String {
    match cause {
        Cause::Unknown => String::new(),
        Cause::Controller => String::from("the controller"),
        Cause::Board => String::from("the board"),
        Cause::Step(at) => match steps.get(usize::from(at)) {
            Some(step) => format!("step {}", step.id),
            None => format!("step {}", u32::from(at) + 1),
        },
        Cause::Program { task, file, line } => {
            let task = note(&format!("task:{task}")).unwrap_or_else(|| format!("task {task}"));
            match note(&format!("file:{file}")) {
                Some(file) => format!("{task} {file}:{line}"),
                None => format!("{task} line {line}"),
            }
        }
    }
}
