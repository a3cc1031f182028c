//! The judge of one case.

use std::fmt;

use document::Diagnostic;
use record::{ClaimOrigin, Verdict, Window};
use signal::{ClockError, Event, SignalInfo, Span, TraceError, ValueKind, When};

use super::claim_record::{claim_record, writer};
use super::coverage::coverage;
use super::early_end::EarlyEnd;
use super::live::LiveReading;
use super::order::Orderer;
use super::pulse_limits::PulseLimits;
use super::short_pulses::ShortPulses;
use super::unknown::{UnknownTimes, add_why};
use super::waits::ClockedWaits;
use super::{JudgedCase, answer};
use crate::expect::{Expectation, FilePlace, GlobalCheck, TraceClaim, happens};
use crate::lang::{Anchor, AnchorBase};
use crate::measure::{Gauge, Measurement};
use crate::monitor::edges::LAST;
use crate::monitor::{
    Anchors, BothEnds, CaseTimeline, ClockLimits, LimitEnd, Monitor, NotJudged, PulseRule, TimedValue,
    TraceSignals,
};
use crate::steps::{CasePart, Question, StepWait};

/// A step of the case, as far as the judge needs it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StepFacts {
    /// Its id.
    pub id: String,
    /// It waits for an event (`when`), so that not coming is a failure.
    pub awaited: Option<StepWait>,
    /// Place of the step that its time counts from.
    pub counts_from: Option<usize>,
    /// The signal that its train of pulses is emitted on.
    pub train: Option<String>,
    /// The part of the case that it belongs to.
    pub part: CasePart,
    /// What a person is asked: the answer has to be that which passes.
    pub asks: Option<Question>,
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
    /// The steps, in the plan's order: the place is that of [`signal::Cause::Step`].
    pub steps: Vec<StepFacts>,
    /// Invariants and alarms, which are judged after the expectations.
    pub global_checks: Vec<GlobalCheck>,
}

impl Scenario {
    /// All instants that claims, measurements and waits depend on.
    fn anchors(&self) -> impl Iterator<Item = &Anchor> {
        let claims = self.expectations.iter().flat_map(|each| each.claim.anchors());
        let waits = self.steps.iter().filter_map(|step| Some(&step.awaited.as_ref()?.from));
        claims.chain(self.measurements.iter().flat_map(Measurement::anchors)).chain(waits)
    }

    /// Every signal that claims and measurements look at, in order of first use.
    pub fn signals(&self) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        let claims = self.expectations.iter().flat_map(|each| each.claim.signals());
        let measured = self.measurements.iter().flat_map(Measurement::signals);
        let global_checks = self.global_checks.iter().flat_map(|guard| guard.expectation.claim.signals());
        for name in claims.chain(measured).chain(global_checks) {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        names
    }

    /// The part of the case that a claim looks at, by the instants that it depends on and the signals that it looks at:
    /// what names the teardown sees it to its end, and what is of a step of the setup alone does not need the rest.
    fn part(&self, anchors: &[&Anchor], signals: &[String]) -> CasePart {
        let part = |id: &str| self.steps.iter().find(|step| step.id == id).map(|step| step.part);
        let own = |signal: &String| {
            signal.strip_prefix("step:").or_else(|| signal.strip_prefix("answer:")).and_then(part)
        };
        let named = anchors.iter().any(|anchor| {
            anchor.base == AnchorBase::Teardown
                || anchor.base.step().and_then(part) == Some(CasePart::Teardown)
        });
        match signals.iter().filter_map(own).max() {
            _ if named => CasePart::Teardown,
            Some(part) => part,
            None => CasePart::Main,
        }
    }

    fn part_of_claim(&self, expectation: &Expectation) -> CasePart {
        self.part(&expectation.claim.anchors(), &expectation.claim.signals())
    }

    fn train(&self, id: &str) -> Option<String> {
        self.steps.iter().find(|step| step.id == id)?.train.clone()
    }
}

/// Why a trace could not be judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum JudgeError {
    /// It could not be read to its end.
    #[error("the trace cannot be read: {0}")]
    Unreadable(#[from] TraceError),
    /// It lacks a signal that the claims look at.
    #[error("the trace cannot be read: it lacks a signal of the plan")]
    MissingSignal,
}

/// The judge of one case: fed with the trace as it grows, then asked for the verdicts.
pub struct CaseJudge {
    scenario: Scenario,
    signals: Vec<SignalInfo>,
    anchors: Anchors,
    live: LiveReading,
    fed: u64,
    /// While the trace grows a claim is lost where it fails at the loosest end of its limits.
    clock: ClockLimits,
}

impl fmt::Debug for CaseJudge {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Judge")
            .field("scenario", &self.scenario)
            .field("fed", &self.fed)
            .finish_non_exhaustive()
    }
}

impl CaseJudge {
    /// A judge for a case whose trace has these signals, in the order of their places.
    ///
    /// # Errors
    /// Findings about claims that these signals cannot answer: a name that the trace does not have, a label
    /// that a state does not have, a unit of another dimension.
    pub fn new(mut scenario: Scenario, signals: &[SignalInfo]) -> Result<CaseJudge, Vec<Diagnostic>> {
        for step in &scenario.steps {
            if let Some(wait) = &step.awaited {
                scenario.expectations.push(happens::implied(&step.id, wait.within, step.line));
            }
            if let Some(question) = &step.asks {
                scenario.expectations.push(answer::implied(step, question));
            }
        }
        scenario.expectations.extend(scenario.global_checks.iter().map(|guard| guard.expectation.clone()));
        let mut found = Vec::new();
        let wiring = TraceSignals { signals };
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
        let mut live = LiveReading::new(&scenario.expectations, signals);
        for (at, expectation) in scenario.expectations.iter().enumerate() {
            let held_back = signals_of(expectation, signals).any(|info| {
                let rule = expectation.claim.pulses(info);
                rule.filter(info, 0, ClockError::NONE).is_some() || rule.can_rescue(info)
            });
            if held_back || scenario.part_of_claim(expectation) == CasePart::Teardown {
                live.pass_over(at);
            }
        }
        let clock = ClockLimits::default();
        Ok(CaseJudge { scenario, signals: signals.to_vec(), anchors, live, fed: 0, clock })
    }

    /// The same judge for a trace that was stamped by a clock which may be off.
    #[must_use]
    pub fn by_clock(mut self, error: ClockError) -> CaseJudge {
        self.clock.error = error;
        self
    }

    /// The same judge for a case that nobody wants to end early: it does not watch the claims while the trace grows,
    /// and [`CaseJudge::failed_early`] says no. The verdicts are the same at half the work.
    #[must_use]
    pub fn without_early_end(mut self) -> CaseJudge {
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
            let (signals, anchors, clock) = (&self.signals, &self.anchors, self.clock);
            let scene = CaseTimeline {
                signals,
                anchors,
                order: &[],
                open_from: Some(now),
                closing: false,
                held: 0,
                clock,
            };
            self.live.news(&self.scenario.expectations, &scene, now);
        }
    }

    /// The case has come to this instant, whether anything happened then or not.
    pub fn reach(&mut self, now: signal::Time) {
        self.live.reach(now.as_nanos());
    }

    /// Whether some claim is lost whatever comes. Cheap enough to ask after every step and every change.
    pub fn failed_early(&mut self) -> bool {
        self.live.lost()
    }

    /// The words of the note [`super::LOST_NOTE`] of a case that was ended because [`CaseJudge::failed_early`] said so.
    pub fn lost_words(&self) -> String {
        EarlyEnd::words(self.live.first_lost())
    }

    /// Which claims are lost whatever comes, in the order of the expectations.
    pub(super) fn lost(&mut self) -> Vec<bool> {
        self.live.lost_each()
    }

    /// The verdicts at the end of a case. `end` is the end of the case where the trace has no mark of it.
    ///
    /// # Errors
    /// [`JudgeError`] if the trace cannot be read.
    pub fn finish(self, end: When, trace: &signal::Trace) -> Result<JudgedCase, JudgeError> {
        let events = trace.events().map(|event| event.map_err(JudgeError::from));
        self.finish_over(end, events, &|key| trace.note(key).map(str::to_owned))
    }

    /// Judges a recorded trace.
    ///
    /// # Errors
    /// [`JudgeError`] if the trace cannot be read.
    pub fn replay(mut self, end: When, trace: &signal::Trace) -> Result<JudgedCase, JudgeError> {
        self.live.rest();
        for event in trace.events() {
            self.feed(&event?);
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
    ) -> Result<JudgedCase, E> {
        self.anchors.end(end, self.fed);
        let order = self.live.order();
        let (signals, anchors, clock) = (&self.signals, &self.anchors, self.clock);
        let scene =
            CaseTimeline { signals, anchors, order: &order, open_from: None, closing: false, held: 0, clock };
        let why = note("ended").unwrap_or_default();
        let early = EarlyEnd::of(note);
        let mut stage = FinalReading::new(&self.scenario, &scene, &why);
        stage.counting = PulseLimits::new(&self.signals, note);
        stage.waits = ClockedWaits::new(&self.scenario.steps, &scene);
        let last = scene.end().max(CaseTimeline { closing: true, ..scene }.end());
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
        Ok(stage.finish(&self.scenario, &scene, &early, note))
    }
}

/// The signals of a claim that the trace has.
fn signals_of<'a>(
    expectation: &Expectation,
    signals: &'a [SignalInfo],
) -> impl Iterator<Item = &'a SignalInfo> {
    let names = expectation.claim.signals();
    signals.iter().filter(move |info| names.contains(&info.name))
}

/// Says of findings where the claim stands.
fn locate(found: &mut [Diagnostic], place: Option<&FilePlace>) {
    let Some(place) = place.filter(|place| !place.file.is_empty()) else { return };
    for each in found.iter_mut().filter(|each| each.labels.is_empty()) {
        *each = each.clone().at(&*place.file, place.span.clone(), "");
    }
}

/// What follows the signals in the last reading.
enum RunningMonitor {
    Claim(Result<Box<dyn Monitor>, NotJudged>),
    Gauge(Box<Result<Gauge, NotJudged>>),
}

/// A signal with those who follow it.
struct FollowedSignal {
    orderer: Orderer,
    /// The followers.
    followers: Vec<Follower>,
    observed: bool,
    /// When it was not known, and why.
    unknown: UnknownTimes,
}

/// Who follows a signal.
#[derive(Clone, Copy)]
struct Follower {
    /// Its place.
    at: usize,
    /// The slot under which it knows the signal.
    slot: usize,
    /// Where it stops looking: the instant, and the place in the trace.
    last: (i64, u64),
    /// The end of the case at the earliest: what lasts until then lasts so long for certain.
    end: i64,
    /// What takes the short pulses out of the signal before, by its place.
    filter: Option<usize>,
    /// From when to when the signal is not known any more, where it looks at what may lie after the end.
    known_until: Option<(i64, i64)>,
}

impl Follower {
    #[inline]
    fn feed(self, running: &mut [RunningMonitor], short: &mut ShortPulses<Follower>, seen: &TimedValue) {
        // What was recorded after the end may have come before it, as far as its interval reaches.
        if seen.a > self.last.0 || seen.place > self.last.1 && seen.a == self.last.0 {
            return;
        }
        match self.filter {
            Some(filter) => short.see(filter, seen, |follower, seen| follower.hand_on(running, seen)),
            None => self.hand_on(running, seen),
        }
    }

    /// Nothing comes any more: what may lie after the end of the case nobody saw.
    fn end(self, running: &mut [RunningMonitor]) {
        if let Some(end) = self.known_until {
            self.lose(running, end);
        }
    }

    /// From then on nothing is known of the signal.
    fn lose(self, running: &mut [RunningMonitor], (a, b): (i64, i64)) {
        self.hand_on(running, &TimedValue { a, b, place: LAST, since: LAST, ..TimedValue::NOTHING });
    }

    #[inline]
    fn hand_on(self, running: &mut [RunningMonitor], seen: &TimedValue) {
        running[self.at].feed(self.slot, seen);
    }
}

/// The monitor of a claim; where the clock may be off, at both ends of its limits.
fn at_both_ends(claim: &dyn TraceClaim, scene: &CaseTimeline<'_>) -> Result<Box<dyn Monitor>, NotJudged> {
    let loosest = claim.start(scene)?;
    if scene.clock.error.is_none() {
        return Ok(loosest);
    }
    let clock = ClockLimits { end: LimitEnd::Strictest, ..scene.clock };
    let strictest = claim.start(&CaseTimeline { clock, ..*scene })?;
    Ok(Box::new(BothEnds { loosest, strictest }))
}

/// The last reading.
struct FinalReading {
    running: Vec<RunningMonitor>,
    lines: Vec<FollowedSignal>,
    short: ShortPulses<Follower>,
    counting: PulseLimits,
    waits: ClockedWaits,
}

impl FinalReading {
    fn new(scenario: &Scenario, scene: &CaseTimeline<'_>, why: &str) -> FinalReading {
        let mut stage = FinalReading {
            running: Vec::new(),
            lines: Vec::new(),
            short: ShortPulses::new(),
            counting: PulseLimits::default(),
            waits: ClockedWaits::default(),
        };
        for at in 0..scene.signals.len() {
            let hold = scene.order.get(at).is_some_and(|order| order.disordered);
            stage.lines.push(FollowedSignal {
                orderer: Orderer::new(hold),
                followers: Vec::new(),
                observed: false,
                unknown: UnknownTimes::default(),
            });
        }
        let setup = scenario.steps.iter().any(|step| step.part == CasePart::Setup);
        let begun =
            !setup || scene.anchors.resolve(&Anchor { base: AnchorBase::Main, offset: Span::ZERO }).is_some();
        // What holds in every case holds in its setup, too.
        let own = scenario.expectations.len() - scenario.global_checks.len();
        let part = |of: CasePart, standing: bool| {
            let missing = of == CasePart::Main && !begun && !standing;
            let whole = CaseTimeline { closing: of == CasePart::Teardown, ..*scene };
            if missing { Err(NotJudged::NoMain(why.to_owned())) } else { Ok(whole) }
        };
        for (at, expectation) in scenario.expectations.iter().enumerate() {
            let scene_of = part(scenario.part_of_claim(expectation), at >= own);
            let held = stage.follow(
                &expectation.claim.signals(),
                &expectation.claim.anchors(),
                |info| expectation.claim.pulses(info),
                scene_of.as_ref().unwrap_or(scene),
            );
            let monitor =
                scene_of.and_then(|scene| at_both_ends(&*expectation.claim, &CaseTimeline { held, ..scene }));
            stage.running.push(RunningMonitor::Claim(monitor));
        }
        for measurement in &scenario.measurements {
            let scene_of = part(scenario.part(&measurement.anchors(), &measurement.signals()), false);
            let held = stage.follow(
                &measurement.signals(),
                &measurement.anchors(),
                |info| measurement.pulses(info),
                scene_of.as_ref().unwrap_or(scene),
            );
            let gauge = scene_of.and_then(|scene| measurement.start(&CaseTimeline { held, ..scene }));
            stage.running.push(RunningMonitor::Gauge(Box::new(gauge)));
        }
        stage
    }

    /// Whoever runs next follows these signals and depends on these instants. How long their changes are held back at most, nanoseconds.
    fn follow(
        &mut self,
        names: &[String],
        anchors: &[&Anchor],
        rule: impl Fn(&SignalInfo) -> PulseRule,
        scene: &CaseTimeline<'_>,
    ) -> i64 {
        let (at, last) = (self.running.len(), (scene.end(), scene.last_place()));
        let (mut held, known_until) = (0, scene.known_until(anchors));
        for (slot, name) in names.iter().enumerate() {
            let Some(line) = scene.signals.iter().position(|info| info.name == *name) else { continue };
            // No step comes after the end.
            let known_until = known_until.filter(|_| scene.signals[line].kind != ValueKind::Mark);
            let mut follower =
                Follower { at, slot, last, end: scene.earliest_end(), filter: None, known_until };
            if let Some(filter) =
                rule(&scene.signals[line]).filter(&scene.signals[line], scene.lag(name), scene.clock.error)
            {
                held = held.max(filter.holds_for());
                follower.filter = Some(self.short.add(filter, follower));
            }
            self.lines[line].followers.push(follower);
        }
        held
    }

    #[inline]
    fn feed(&mut self, event: &Event, place: u64) {
        let running = &mut self.running;
        self.short.settle(event.at.earliest.as_nanos(), |follower, seen| follower.hand_on(running, seen));
        self.waits.see(event, place);
        let Some(line) = self.lines.get_mut(event.signal.0 as usize) else { return };
        if line.followers.is_empty() {
            return;
        }
        line.observed = true;
        line.unknown.see(event);
        self.counting.see(event);
        let (followers, running, short) = (&line.followers, &mut self.running, &mut self.short);
        line.orderer.push(event, place, |seen| {
            followers.iter().for_each(|follower| follower.feed(running, short, seen));
        });
    }

    fn finish(
        mut self,
        scenario: &Scenario,
        scene: &CaseTimeline<'_>,
        early: &EarlyEnd,
        note: &dyn Fn(&str) -> Option<String>,
    ) -> JudgedCase {
        let signals = scene.signals;
        for line in &mut self.lines {
            let (followers, running, short) = (&line.followers, &mut self.running, &mut self.short);
            line.orderer.drain(|seen| {
                followers.iter().for_each(|follower| follower.feed(running, short, seen));
            });
        }
        let running = &mut self.running;
        self.short.finish(|follower| follower.end, |follower, seen| follower.hand_on(running, seen));
        self.lines.iter().flat_map(|line| &line.followers).for_each(|follower| follower.end(running));
        let end = (scene.earliest_end(), scene.end());
        for mark in self.waits.open(scenario, scene) {
            self.lines[mark].followers.iter().for_each(|follower| follower.lose(running, end));
        }
        let unobserved = |names: &[String]| {
            let silent = |name: &&String| {
                signals.iter().position(|info| info.name == **name).is_none_or(|at| !self.lines[at].observed)
            };
            names.iter().find(silent).map(|name| format!("`{name}` was never observed"))
        };
        let why = |names: &[String], window: Option<&Window>, reason: &mut String| {
            let known = names.iter().filter_map(|name| signals.iter().position(|info| info.name == *name));
            let lines = known.map(|at| (signals[at].name.as_str(), &self.lines[at].unknown));
            add_why(lines, window, reason);
        };
        let writer = |cause| writer(cause, &scenario.steps, note);
        let (mut claims, mut measurements) = (Vec::new(), Vec::new());
        let mut running = self.running.into_iter();
        let counting = self.counting;
        // The global_checks stand after the case's own claims.
        let own = scenario.expectations.len() - scenario.global_checks.len();
        for ((place, expectation), running) in scenario.expectations.iter().enumerate().zip(running.by_ref())
        {
            let RunningMonitor::Claim(judged) = running else { continue };
            let doubts = signals_of(expectation, signals)
                .filter_map(|info| expectation.claim.pulses(info).doubt(info));
            let doubt = doubts.max_by_key(|(unseen, _)| *unseen);
            let finding = judged.map(|monitor| match doubt {
                Some((unseen, why)) => monitor.finish().with_unseen(unseen, why),
                None => monitor.finish(),
            });
            let silent = unobserved(&expectation.claim.signals());
            let record = claim_record(expectation, finding, silent, &writer);
            let mut record = early.claim(place, &*expectation.claim, scene, record);
            if record.verdict == Verdict::Inconclusive {
                why(&expectation.claim.signals(), record.window.as_ref(), &mut record.reason);
            }
            if record.verdict != Verdict::Error
                && let Some(wanted) = expectation.claim.counts()
                && let names = expectation.claim.signals()
                && let Some(why) = counting.doubt(signals, &names, record.window.as_ref(), wanted)
            {
                (record.verdict, record.reason) = (Verdict::Inconclusive, why);
            }
            if let Some(guard) = place.checked_sub(own).and_then(|place| scenario.global_checks.get(place)) {
                record.guard = true;
                record.origin = guard.origin;
                let file = expectation.place.as_ref().map(|place| place.file.to_string());
                record.place_file = file.filter(|_| guard.origin != ClaimOrigin::Plan);
            }
            claims.push(record);
        }
        for (measurement, running) in scenario.measurements.iter().zip(running) {
            let RunningMonitor::Gauge(taken) = running else { continue };
            let mut taken = match *taken {
                Ok(gauge) => gauge.finish(measurement.doubt(signals)),
                Err(why) => measurement.untaken(&why.to_string()),
            };
            if let (Verdict::Inconclusive, Some(silent)) = (taken.verdict, unobserved(&measurement.signals()))
            {
                taken.reason = silent;
            }
            if let (Verdict::Inconclusive, Some(from_ns)) = (taken.verdict, taken.from_ns) {
                let window =
                    Window { from_ns, until_ns: taken.to_ns.unwrap_or(from_ns), ..Window::default() };
                why(&measurement.signals(), Some(&window), &mut taken.reason);
            }
            if let Some(wanted) = measurement.counts() {
                let window = taken.from_ns.map(|from_ns| Window {
                    from_ns,
                    until_ns: taken.to_ns.unwrap_or(from_ns),
                    ..Window::default()
                });
                let doubt = counting.doubt(signals, &measurement.signals(), window.as_ref(), wanted);
                if let Some(why) = doubt {
                    (taken.verdict, taken.reason) = (Verdict::Inconclusive, why);
                }
            }
            let mut taken = early.measurement(&measurement.anchors(), scene, taken);
            if taken.value.is_some() {
                taken.coverage = coverage(&measurement.signals(), note);
            }
            measurements.push(taken);
        }
        JudgedCase::of(claims, measurements)
    }
}

impl RunningMonitor {
    #[inline]
    fn feed(&mut self, slot: usize, seen: &TimedValue) {
        match self {
            RunningMonitor::Claim(Ok(monitor)) => monitor.feed(slot, seen),
            RunningMonitor::Claim(Err(_)) => {}
            RunningMonitor::Gauge(gauge) => {
                if let Ok(gauge) = gauge.as_mut() {
                    gauge.feed(slot, seen);
                }
            }
        }
    }
}
