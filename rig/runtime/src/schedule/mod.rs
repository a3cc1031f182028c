//! The steps of a case on their way to their instants. Prepared before the start: nothing is allocated while the
//! case runs.

pub mod case_ending;
mod never;
mod progress;

use crate::generator::{BoardOrder, StimulusGenerator};
use controller::{Command, Disturbance, FileUser, Probe};
use drivers::{ChannelId, Fault};
use plans::lang::{Anchor, AnchorBase};
use plans::plan::StepRepeat;
use plans::steps::{AwaitedChange, CasePart, FileOperation, Question};
use signal::{SignalId, Span, Time, Value};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};
use std::sync::Arc;

pub use progress::EndReason;
use progress::ScheduleProgress;

/// One thing that a step does, with every name resolved.
#[derive(Clone, Debug, PartialEq)]
pub enum Act {
    /// Drives a line.
    Drive(ChannelId, Value),
    /// Drives a line back to what it was before the step.
    Restore(ChannelId),
    /// Commands the subject; with whether the plan expects a refusal.
    Command(Command, Expected),
    /// Switches the subject's supply.
    Power(bool),
    /// Puts load on a task.
    Overload {
        /// Place of the task.
        task: usize,
        /// Time of execution of one cycle.
        cycle: Span,
        /// Number of cycles.
        times: u32,
    },
    /// Lets something go wrong around the subject, or clears it.
    Disturb(Disturbance),
    /// Keeps a task from the processor.
    Suspend {
        /// Place of the task.
        task: usize,
        /// For how long.
        lasts: Span,
    },
    /// Sets a parameter of a plant.
    SetPlant {
        /// Place of the plant.
        plant: usize,
        /// Place of its parameter.
        parameter: usize,
        /// What it is from then on.
        value: f64,
        /// Whether it goes back.
        for_a_time: bool,
    },
    /// Ends the time for which the step has set a parameter of a plant.
    RestorePlant {
        /// Place of the plant.
        plant: usize,
        /// Place of its parameter.
        parameter: usize,
        /// What it is in the board file.
        initial: f64,
    },
    /// Puts a fault on a line.
    Fault(Fault),
    /// Takes the faults off a line.
    Clear(ChannelId),
    /// Writes a variable, a place in memory or a register.
    Write(Probe, Value, Expected),
    /// Does something to a file.
    File(FileAction, Expected),
    /// Asks a person; the answer is recorded as this signal.
    Ask(Arc<Question>, SignalId),
}

/// What is done to a file of the subject.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileAction {
    /// Its path.
    pub path: String,
    /// What is done.
    pub deed: FileOperation,
    /// Who does it.
    pub user: FileUser,
}

/// Whether a command is to be obeyed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Expected {
    /// A refusal is trouble.
    #[default]
    Obeyed,
    /// Obedience is trouble.
    Refused,
}

/// When a step comes.
#[derive(Clone, Debug, PartialEq)]
pub enum Timing {
    /// At an instant.
    At(Anchor),
    /// When something happens.
    When {
        /// The signal.
        signal: SignalId,
        /// What it does.
        event: AwaitedChange,
        /// Where waiting begins.
        from: Anchor,
        /// How long to wait for it.
        within: Span,
    },
}

/// A step with everything resolved.
#[derive(Clone, Debug)]
pub struct PlannedStep {
    /// Its id.
    pub id: String,
    /// The mark of its beginning.
    pub mark: SignalId,
    /// The mark of its end.
    pub done: SignalId,
    /// The part of the case that it belongs to.
    pub phase: CasePart,
    /// When it comes.
    pub timing: Timing,
    /// How it comes more than once.
    pub repeat: Option<StepRepeat>,
    /// Place of the step that runs its group.
    pub parent: Option<usize>,
    /// What it does, by the time since its beginning, in order.
    pub acts: Vec<(Span, Act)>,
    /// What goes on from its beginning, if anything.
    pub generator: Option<StimulusGenerator>,
    /// How long after its beginning it is done.
    pub lasts: Span,
}

/// What is due.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Due {
    /// The step begins to wait.
    Arm,
    /// The step begins.
    Begin,
    /// One of its acts.
    Act(u32),
    /// The next act of its generator, of the time that it came with this ticket.
    Emit(u64),
    /// It is done.
    Done,
    /// What it waits for did not come.
    Missed,
    /// It comes no more.
    Stop,
    /// All of the setup is done. Of no step.
    Main,
}

/// What a step or the end of the case depends on, with the step's place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum StepAnchor {
    Start,
    Main,
    Teardown,
    Begin(usize),
    /// The step comes this time, from 1.
    Time(usize, u64),
    Done(usize),
    Pulse(usize, u32),
    /// Nothing that comes.
    Never,
}

impl StepAnchor {
    fn of(base: &AnchorBase, steps: &BTreeMap<&str, usize>) -> StepAnchor {
        let place = |id: &str| steps.get(id).copied();
        let found = match base {
            AnchorBase::Start => Some(StepAnchor::Start),
            AnchorBase::Main => Some(StepAnchor::Main),
            AnchorBase::Teardown => Some(StepAnchor::Teardown),
            AnchorBase::End => None,
            AnchorBase::Occurrence { step, n } => place(step).map(|place| StepAnchor::Time(place, *n)),
            AnchorBase::Step(id) => place(id).map(StepAnchor::Begin),
            AnchorBase::StepDone(id) => place(id).map(StepAnchor::Done),
            AnchorBase::Pulse { step, n } => {
                place(step).zip(u32::try_from(*n).ok()).map(|(place, n)| StepAnchor::Pulse(place, n))
            }
        };
        found.unwrap_or(StepAnchor::Never)
    }
}

/// An edge that the rig is late with keeps this much of its distance from the one before it, as a fraction.
const KEPT: (i64, i64) = (3, 4);

/// How far the generator of a step has come.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct GeneratorProgress {
    /// Which time of the step this is.
    ticket: u64,
    /// The number of its next act, from 0.
    act: u64,
    /// Something else drives one of its lines: it does nothing more.
    stopped: bool,
    /// The end of its step is known, and waits.
    ends: bool,
}

/// The steps and what of them is due next.
#[derive(Debug)]
pub struct Schedule {
    steps: Vec<PlannedStep>,
    /// What each step depends on, and after them the end of the case.
    roots: Vec<StepAnchor>,
    /// When each began last.
    begun: Vec<Option<Time>>,
    armed: Vec<bool>,
    /// How each step's generator goes on.
    running: Vec<GeneratorProgress>,
    /// By channel: the step whose generator drives it.
    drivers: Vec<Option<usize>>,
    progress: ScheduleProgress,
    queue: BinaryHeap<Reverse<(Time, u64, usize, Due)>>,
    order: u64,
    ends: Anchor,
    end: Option<Time>,
    start: Option<Time>,
}

impl Schedule {
    /// A schedule that waits for its start. `ends` is the end of the case.
    pub fn new(steps: Vec<PlannedStep>, ends: Anchor) -> Schedule {
        let count = steps.len();
        let places: BTreeMap<&str, usize> =
            steps.iter().enumerate().map(|(place, step)| (step.id.as_str(), place)).collect();
        let anchors = steps.iter().map(|step| match &step.timing {
            Timing::At(anchor) | Timing::When { from: anchor, .. } => anchor,
        });
        let roots = anchors.chain([&ends]).map(|anchor| StepAnchor::of(&anchor.base, &places)).collect();
        let progress = ScheduleProgress::new(&steps, &places);
        let generators = steps.iter().filter_map(|step| step.generator.as_ref());
        let channels =
            generators.flat_map(StimulusGenerator::channels).map(|channel| usize::from(channel.0) + 1).max();
        Schedule {
            progress,
            steps,
            roots,
            begun: vec![None; count],
            armed: vec![false; count],
            running: vec![GeneratorProgress::default(); count],
            drivers: vec![None; channels.unwrap_or(0)],
            // Of each step at most its beginning or miss, its acts, one of its generator's and its end wait at once.
            queue: BinaryHeap::with_capacity(count * 8 + 8),
            order: 0,
            ends,
            end: None,
            start: None,
        }
    }

    /// The steps.
    pub fn steps(&self) -> &[PlannedStep] {
        &self.steps
    }

    /// When a step began, for the first time.
    pub fn begun(&self, step: usize) -> Option<Time> {
        self.progress.first[step]
    }

    /// The end of the case, once it is known. It does not end before its setup is done, unless that fails.
    pub fn end(&self) -> Option<Time> {
        let comes = self.progress.phase == CasePart::Main || self.progress.ended.is_some();
        self.end.filter(|_| comes)
    }

    /// When something is due.
    #[inline]
    pub fn next_due(&self) -> Option<Time> {
        self.queue.peek().map(|Reverse((at, ..))| *at)
    }

    /// Takes what is due up to `now`, oldest first.
    #[inline]
    pub fn take(&mut self, now: Time) -> Option<(Time, usize, Due)> {
        loop {
            let Reverse((at, _, step, due)) = *self.queue.peek()?;
            if at > now {
                return None;
            }
            self.queue.pop();
            // The limit of a wait belongs to it: what comes at that very instant came in time.
            if due == Due::Missed && self.acts_by(at) {
                self.put(at, step, due);
                continue;
            }
            if !self.is_held(step, due) {
                return Some((at, step, due));
            }
        }
    }

    /// Whether a step does something by this instant that may still bring what another one waits for.
    fn acts_by(&self, limit: Time) -> bool {
        self.queue.iter().any(|Reverse((at, _, _, due))| *at <= limit && *due != Due::Missed)
    }

    /// The wait of a step is not over yet: more may come at this instant.
    pub fn wait_on(&mut self, at: Time, step: usize) {
        self.put(at, step, Due::Missed);
    }

    fn put(&mut self, at: Time, step: usize, due: Due) {
        self.order += 1;
        self.queue.push(Reverse((at, self.order, step, due)));
    }

    /// The case starts.
    pub fn start(&mut self, at: Time) {
        self.start = Some(at);
        self.begin_first_phase();
        self.anchor_reached(StepAnchor::Start, at);
    }

    /// An instant that steps or the end depend on came.
    fn anchor_reached(&mut self, root: StepAnchor, now: Time) {
        for place in 0..self.roots.len() {
            if self.roots[place] == root {
                self.queue_anchored(place, now, now);
            }
        }
        self.stops(root, now);
    }

    /// What the step at `place`, or the end after the last one, depends on comes at `base_at`.
    fn queue_anchored(&mut self, place: usize, base_at: Time, now: Time) {
        let (anchor, due) = match self.steps.get(place).map(|step| &step.timing) {
            Some(Timing::At(anchor)) => (anchor, Some(Due::Begin)),
            Some(Timing::When { from, .. }) => (from, Some(Due::Arm)),
            None => (&self.ends, None),
        };
        let at = base_at.saturating_add(anchor.offset).max(now);
        match due {
            None => self.end = Some(at),
            Some(due) if self.begun[place].is_none() && self.may_come(place) => self.put(at, place, due),
            Some(_) => {}
        }
    }

    /// The step waits from now on.
    pub fn arm(&mut self, step: usize, now: Time) {
        if let Timing::When { within, .. } = self.steps[step].timing {
            self.armed[step] = true;
            self.put(now.saturating_add(within), step, Due::Missed);
        }
    }

    /// The step has waited long enough. FALSE where it has come already.
    pub fn miss(&mut self, step: usize, now: Time) -> bool {
        let missed = std::mem::take(&mut self.armed[step]) && !self.has_come(step, now);
        if missed {
            self.never_comes(step);
        }
        missed
    }

    /// Whether a step waits for changes of this signal: asked for every recorded event.
    pub fn awaits(&self, signal: SignalId) -> bool {
        self.steps.iter().zip(&self.armed).any(|(step, armed)| {
            *armed && matches!(step.timing, Timing::When { signal: awaited, .. } if awaited == signal)
        })
    }

    /// Whether this step waits, and has not come yet.
    pub fn is_waiting(&self, step: usize) -> bool {
        self.armed[step] && self.progress.first[step].is_none()
    }

    /// Whether it waits for changes of this signal.
    pub fn is_awaiting(&self, step: usize, signal: SignalId) -> bool {
        self.is_waiting(step)
            && matches!(self.steps[step].timing, Timing::When { signal: awaited, .. } if awaited == signal)
    }

    /// A recorded change: steps that waited for it begin now.
    pub fn changed(&mut self, signal: SignalId, before: Option<Value>, value: Value, now: Time) {
        for step in 0..self.steps.len() {
            let Timing::When { signal: awaited, event, .. } = &self.steps[step].timing else { continue };
            let (awaited, event) = (*awaited, *event);
            if self.armed[step] && awaited == signal && event.met(before, value) && self.reacts(step) {
                self.put(now, step, Due::Begin);
            }
        }
    }

    /// A step begins: what it does is queued, what depends on it learns its instant. `driven` is what each channel is
    /// driven to.
    pub fn begin(&mut self, step: usize, now: Time, driven: &[Value]) {
        self.begun[step] = Some(now);
        let n = self.count(step, now);
        for act in 0..self.steps[step].acts.len() {
            let after = self.steps[step].acts[act].0;
            self.put(now.saturating_add(after), step, Due::Act(act as u32));
        }
        if let Some(mut generator) = self.steps[step].generator.take() {
            generator.begin(driven);
            for channel in generator.channels() {
                self.take_over(channel, Some(step));
            }
            self.steps[step].generator = Some(generator);
        }
        let ticket = self.running[step].ticket + 1;
        self.running[step] = GeneratorProgress { ticket, ..GeneratorProgress::default() };
        if !self.runs(step) {
            self.emit(step, None);
        }
        self.again(step, n, now);
        for place in 0..self.roots.len() {
            if let StepAnchor::Pulse(train, n) = self.roots[place]
                && train == step
                && let Some(rises) = self.rises(step, n)
            {
                self.queue_anchored(place, rises, now);
            }
        }
        if n == 1 {
            self.anchor_reached(StepAnchor::Begin(step), now);
        }
        self.anchor_reached(StepAnchor::Time(step, n), now);
    }

    /// A step is done, with every time that it comes.
    pub fn finish(&mut self, step: usize, now: Time) {
        self.progress.last_done = Some(now);
        self.anchor_reached(StepAnchor::Done(step), now);
        self.close(step, now);
    }

    /// When pulse `n` of a train rises, jitter included.
    fn rises(&self, step: usize, n: u32) -> Option<Time> {
        let rises = self.steps[step].generator.as_ref()?.rises(n)?;
        Some(self.begun[step]?.saturating_add(rises))
    }

    /// When the next act of a step's generator is to come, however late the rig is.
    pub fn planned(&self, step: usize) -> Option<Time> {
        let after = self.steps[step].generator.as_ref()?.after(self.running[step].act)?;
        Some(self.begun[step]?.saturating_add(after))
    }

    /// Whether edges that were to come by this instant are still to come.
    pub fn is_behind(&self, end: Time) -> bool {
        let late = |step: &usize| {
            let edges = self.steps[*step].generator.as_ref().is_some_and(StimulusGenerator::is_of_edges);
            edges && !self.running[*step].stopped && self.planned(*step).is_some_and(|at| at <= end)
        };
        (0..self.steps.len()).any(|step| late(&step))
    }

    /// Queues the next act of a generator. After the last one that comes within the step's time the step is done. Where
    /// the act before came at `reached`, edges of pulses keep apart from it.
    fn emit(&mut self, step: usize, reached: Option<Time>) {
        let Some(begun) = self.begun[step] else { return };
        let GeneratorProgress { ticket, act, .. } = self.running[step];
        let after = self.steps[step].generator.as_ref().and_then(|generator| generator.after(act));
        if after.is_none_or(|after| after > self.steps[step].lasts) {
            self.done_later(step, begun);
        }
        if let Some(after) = after {
            let apart = reached.and_then(|reached| {
                let generator =
                    self.steps[step].generator.as_ref().filter(|generator| generator.is_of_edges())?;
                let distance = after - generator.after(act.checked_sub(1)?)?;
                Some(reached.saturating_add(Span::from_nanos(distance.as_nanos() / KEPT.1 * KEPT.0)))
            });
            let at = begun.saturating_add(after);
            self.put(apart.map_or(at, |apart| apart.max(at)), step, Due::Emit(ticket));
        }
    }

    /// Queues the end of a step, once.
    fn done_later(&mut self, step: usize, begun: Time) {
        if !std::mem::replace(&mut self.running[step].ends, true) {
            self.put(begun.saturating_add(self.steps[step].lasts), step, Due::Done);
        }
    }

    /// What the next act of a step's generator writes is appended to `out`, what else it asks of the board is handed back,
    /// and the one after it queued. Nothing where the generator was stopped, or has begun again since the act was queued.
    /// On real lines the act comes at `reached`: what a late rig catches up with keeps three quarters of its distance.
    pub fn emitted(
        &mut self,
        step: usize,
        ticket: u64,
        reached: Option<Time>,
        out: &mut Vec<(ChannelId, Value)>,
    ) -> Option<BoardOrder> {
        let running = &mut self.running[step];
        if running.stopped || running.ticket != ticket {
            return None;
        }
        let act = running.act;
        running.act += 1;
        let generator = self.steps[step].generator.as_ref();
        let order = generator.and_then(|generator| {
            generator.writes(act, out);
            generator.order(act)
        });
        self.emit(step, reached);
        order
    }

    /// A step drives a channel, with its generator or without one: what drove it before goes no further.
    pub fn take_over(&mut self, channel: ChannelId, by: Option<usize>) {
        let Some(driver) = self.drivers.get_mut(usize::from(channel.0)) else { return };
        if let Some(before) = std::mem::replace(driver, by)
            && by != Some(before)
        {
            self.running[before].stopped = true;
            if let Some(begun) = self.begun[before] {
                self.done_later(before, begun);
            }
        }
    }
}
