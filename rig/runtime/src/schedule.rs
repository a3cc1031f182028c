//! The steps of a case on their way to their instants. Prepared before the start: nothing is allocated while the
//! case runs.

use controller::{Command, Disturbance, FileUser, Probe};
use drivers::{ChannelId, Fault};
use plans::lang::{Anchor, Base};
use plans::steps::{FileDeed, Train};
use signal::{Random, SignalId, Span, Time, Value};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

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
    /// Lets something go wrong around the subject, or mends it.
    Disturb(Disturbance),
    /// Keeps a task from the processor.
    Suspend {
        /// Place of the task.
        task: usize,
        /// For how long.
        lasts: Span,
    },
    /// Puts a fault on a line.
    Fault(Fault),
    /// Takes the faults off a line.
    Clear(ChannelId),
    /// Writes a variable, a place in memory or a register.
    Write(Probe, Value, Expected),
    /// Does something to a file.
    File(FileAct, Expected),
}

/// What is done to a file of the subject.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileAct {
    /// Its path.
    pub path: String,
    /// What is done.
    pub deed: FileDeed,
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

/// What an awaited step waits for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Awaited {
    /// The signal becomes this value.
    Becomes(Value),
    /// It becomes TRUE.
    Rises,
    /// It becomes FALSE.
    Falls,
    /// It changes.
    Changes,
    /// It moves from at or below to above this.
    Above(f64),
    /// It moves from at or above to below this.
    Below(f64),
}

impl Awaited {
    /// Whether a change of the signal is what is waited for.
    fn met(self, before: Option<Value>, value: Value) -> bool {
        let real = |value: Option<Value>| value.and_then(Value::as_real);
        match self {
            Awaited::Becomes(wanted) => value == wanted,
            Awaited::Rises => value.as_bool() == Some(true) && before.and_then(Value::as_bool) != Some(true),
            Awaited::Falls => {
                value.as_bool() == Some(false) && before.and_then(Value::as_bool) != Some(false)
            }
            Awaited::Changes => true,
            Awaited::Above(limit) => {
                real(Some(value)).is_some_and(|now| now > limit)
                    && real(before).is_none_or(|then| then <= limit)
            }
            Awaited::Below(limit) => {
                real(Some(value)).is_some_and(|now| now < limit)
                    && real(before).is_none_or(|then| then >= limit)
            }
        }
    }
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
        event: Awaited,
        /// Where waiting begins.
        from: Anchor,
        /// How long to wait for it.
        within: Span,
    },
}

/// A train of pulses under way.
#[derive(Clone, Debug)]
pub struct TrainWork {
    /// Where it is emitted.
    pub channel: ChannelId,
    /// The pulses.
    pub train: Train,
}

/// A step with everything resolved.
#[derive(Clone, Debug)]
pub struct Planned {
    /// Its id.
    pub id: String,
    /// The mark of its beginning.
    pub mark: SignalId,
    /// The mark of its end.
    pub done: SignalId,
    /// When it comes.
    pub timing: Timing,
    /// What it does, by the time since its beginning, in order.
    pub acts: Vec<(Span, Act)>,
    /// Its train, if any.
    pub train: Option<TrainWork>,
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
    /// An edge of its train: number of the pulse from 1, TRUE for the rising one.
    Edge(u32, bool),
    /// It is done.
    Done,
    /// What it waits for did not come.
    Missed,
}

/// What a step or the end of the case hangs on, with the step's place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Root {
    Start,
    Begin(usize),
    Done(usize),
    Pulse(usize, u32),
    /// Nothing that comes.
    Never,
}

impl Root {
    fn of(base: &Base, steps: &[Planned]) -> Root {
        let place = |id: &str| steps.iter().position(|step| step.id == id);
        let found = match base {
            Base::Start => Some(Root::Start),
            Base::End => None,
            Base::Step(id) => place(id).map(Root::Begin),
            Base::StepDone(id) => place(id).map(Root::Done),
            Base::Pulse { step, n } => {
                place(step).zip(u32::try_from(*n).ok()).map(|(place, n)| Root::Pulse(place, n))
            }
        };
        found.unwrap_or(Root::Never)
    }
}

/// The steps and what of them is due next.
#[derive(Debug)]
pub struct Schedule {
    steps: Vec<Planned>,
    /// What each step hangs on, and behind them the end of the case.
    roots: Vec<Root>,
    begun: Vec<Option<Time>>,
    armed: Vec<bool>,
    queue: BinaryHeap<Reverse<(Time, u64, usize, Due)>>,
    order: u64,
    ends: Anchor,
    end: Option<Time>,
    start: Option<Time>,
    seed: u64,
}

impl Schedule {
    /// A schedule that waits for its start. `ends` is the end of the case.
    pub fn new(steps: Vec<Planned>, ends: Anchor, seed: u64) -> Schedule {
        let count = steps.len();
        let anchors = steps.iter().map(|step| match &step.timing {
            Timing::At(anchor) | Timing::When { from: anchor, .. } => anchor,
        });
        let roots = anchors.chain([&ends]).map(|anchor| Root::of(&anchor.base, &steps)).collect();
        Schedule {
            steps,
            roots,
            begun: vec![None; count],
            armed: vec![false; count],
            // Of each step at most its beginning or miss, its acts, one edge and its end wait at once.
            queue: BinaryHeap::with_capacity(count * 8 + 8),
            order: 0,
            ends,
            end: None,
            start: None,
            seed,
        }
    }

    /// The steps.
    pub fn steps(&self) -> &[Planned] {
        &self.steps
    }

    /// When a step began.
    pub fn begun(&self, step: usize) -> Option<Time> {
        self.begun[step]
    }

    /// The end of the case, once it is known.
    pub fn end(&self) -> Option<Time> {
        self.end
    }

    /// When something is due.
    #[inline]
    pub fn next_due(&self) -> Option<Time> {
        self.queue.peek().map(|Reverse((at, ..))| *at)
    }

    /// Takes what is due up to `now`, oldest first.
    #[inline]
    pub fn take(&mut self, now: Time) -> Option<(Time, usize, Due)> {
        let Reverse((at, _, step, due)) = *self.queue.peek()?;
        if at > now {
            return None;
        }
        self.queue.pop();
        Some((at, step, due))
    }

    fn put(&mut self, at: Time, step: usize, due: Due) {
        self.order += 1;
        self.queue.push(Reverse((at, self.order, step, due)));
    }

    /// The case starts.
    pub fn start(&mut self, at: Time) {
        self.start = Some(at);
        self.came(Root::Start, at);
    }

    /// An instant that steps or the end hang on came.
    fn came(&mut self, root: Root, now: Time) {
        for place in 0..self.roots.len() {
            if self.roots[place] == root {
                self.hang(place, now, now);
            }
        }
    }

    /// What the step at `place`, or the end behind the last one, hangs on comes at `base_at`.
    fn hang(&mut self, place: usize, base_at: Time, now: Time) {
        let (anchor, due) = match self.steps.get(place).map(|step| &step.timing) {
            Some(Timing::At(anchor)) => (anchor, Some(Due::Begin)),
            Some(Timing::When { from, .. }) => (from, Some(Due::Arm)),
            None => (&self.ends, None),
        };
        let at = base_at.saturating_add(anchor.offset).max(now);
        match due {
            None => self.end = Some(at),
            Some(due) if self.begun[place].is_none() => self.put(at, place, due),
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
    pub fn miss(&mut self, step: usize) -> bool {
        std::mem::take(&mut self.armed[step])
    }

    /// Whether nothing is left that could come, the end of the case included.
    pub fn is_exhausted(&self) -> bool {
        self.queue.is_empty() && self.end.is_none() && !self.armed.contains(&true)
    }

    /// Whether a step waits for changes of this signal: asked for every recorded event.
    pub fn awaits(&self, signal: SignalId) -> bool {
        self.steps.iter().zip(&self.armed).any(|(step, armed)| {
            *armed && matches!(step.timing, Timing::When { signal: awaited, .. } if awaited == signal)
        })
    }

    /// A recorded change: steps that waited for it begin now.
    pub fn changed(&mut self, signal: SignalId, before: Option<Value>, value: Value, now: Time) {
        for step in 0..self.steps.len() {
            let Timing::When { signal: awaited, event, .. } = &self.steps[step].timing else { continue };
            let (awaited, event) = (*awaited, *event);
            if self.armed[step] && awaited == signal && event.met(before, value) {
                self.armed[step] = false;
                self.put(now, step, Due::Begin);
            }
        }
    }

    /// A step begins: what it does is queued, what hangs on it learns its instant.
    pub fn begin(&mut self, step: usize, now: Time) {
        self.begun[step] = Some(now);
        self.armed[step] = false;
        for act in 0..self.steps[step].acts.len() {
            let after = self.steps[step].acts[act].0;
            self.put(now.saturating_add(after), step, Due::Act(act as u32));
        }
        if self.steps[step].train.is_some() {
            self.edge(step, 1, true);
        }
        let lasts = self.steps[step].lasts;
        self.put(now.saturating_add(lasts), step, Due::Done);
        for place in 0..self.roots.len() {
            if let Root::Pulse(train, n) = self.roots[place]
                && train == step
                && let Some(rises) = self.rises(step, n)
            {
                self.hang(place, rises, now);
            }
        }
        self.came(Root::Begin(step), now);
    }

    /// A step is done.
    pub fn finish(&mut self, step: usize, now: Time) {
        self.came(Root::Done(step), now);
    }

    /// When pulse `n` of a train rises, jitter included.
    fn rises(&self, step: usize, n: u32) -> Option<Time> {
        Some(self.begun[step]? + self.edge_after(step, n, true)?)
    }

    fn edge_after(&self, step: usize, n: u32, rising: bool) -> Option<Span> {
        let train = &self.steps[step].train.as_ref()?.train;
        let nominal = if rising { train.rises(n) } else { train.falls(n) };
        if train.jitter == Span::ZERO {
            return Some(nominal);
        }
        // The jitter of an edge depends on its number alone, so that an edge can be asked for ahead of its turn.
        let mut random =
            Random::new(self.seed ^ (u64::from(n) << 1 | u64::from(rising)).wrapping_mul(0x9e37_79b9));
        let width = train.jitter.as_nanos() as u64 * 2 + 1;
        let moved = Span::from_nanos(random.below(width) as i64) - train.jitter;
        Some((nominal + moved).max(Span::ZERO))
    }

    /// Queues an edge of a train.
    fn edge(&mut self, step: usize, n: u32, rising: bool) {
        let (Some(begun), Some(after)) = (self.begun[step], self.edge_after(step, n, rising)) else { return };
        self.put(begun.saturating_add(after), step, Due::Edge(n, rising));
    }

    /// An edge was emitted: queues the next one.
    pub fn emitted(&mut self, step: usize, n: u32, rising: bool) {
        let count = self.steps[step].train.as_ref().map_or(0, |work| work.train.count);
        if rising {
            self.edge(step, n, false);
        } else if n < count {
            self.edge(step, n + 1, true);
        }
    }
}
