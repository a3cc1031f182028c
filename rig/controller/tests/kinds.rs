//! Tasks of every kind against a naive oracle that steps microsecond by microsecond: cyclic and freewheeling tasks,
//! tasks that variables and events start, and tasks of one priority that take turns.

use crate::support::*;
use proptest::prelude::*;
use scanrig_controller::*;
use signal::{Span, Time};

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Cyclic(i64),
    Freewheeling,
    Event,
    External,
}

/// A task: costs in microseconds, multiples of 7 so that pauses are whole ones, and what each operation stores into
/// which trigger.
#[derive(Clone, Debug)]
struct Plan {
    kind: Kind,
    priority: u8,
    ops: Vec<(i64, usize, bool)>,
}

/// What happened to which task, by its rank, and when in microseconds.
type Seen = (usize, i64, &'static str);

/// The scheduler of a controller of 2014, a microsecond at a time.
struct Oracle<'a> {
    plans: &'a [Plan],
    trail: Vec<Seen>,
    lost: Vec<u64>,
    ready: Vec<bool>,
    /// Operation under way and how much of it is done.
    active: Vec<Option<(usize, i64)>>,
    started: Vec<i64>,
    release: Vec<i64>,
    arrivals: Vec<(i64, usize)>,
    level: Vec<bool>,
    was: Vec<bool>,
    /// Per priority: whose turn and what is left of it.
    turns: Vec<(usize, i64)>,
    events: Vec<i64>,
    halted: bool,
}

const NEVER: i64 = i64::MAX;

impl<'a> Oracle<'a> {
    fn new(plans: &'a [Plan]) -> Oracle<'a> {
        let n = plans.len();
        let by_itself = |plan: &Plan| matches!(plan.kind, Kind::Cyclic(_) | Kind::Freewheeling);
        Oracle {
            plans,
            trail: Vec::new(),
            lost: vec![0; n],
            ready: plans.iter().map(by_itself).collect(),
            active: vec![None; n],
            started: vec![0; n],
            release: plans
                .iter()
                .map(|plan| if let Kind::Cyclic(every) = plan.kind { every } else { NEVER })
                .collect(),
            arrivals: Vec::new(),
            level: vec![false; n],
            was: vec![false; n],
            turns: vec![(usize::MAX, 0); 32],
            events: Vec::new(),
            halted: false,
        }
    }

    fn make_ready(&mut self, task: usize) {
        self.lost[task] += u64::from(self.ready[task]);
        self.ready[task] = true;
    }

    fn look(&mut self, now: i64) {
        for task in 0..self.plans.len() {
            if self.plans[task].kind != Kind::Event || self.halted {
                continue;
            }
            let rose = self.level[task] && !self.was[task];
            self.was[task] = self.level[task];
            if rose {
                self.make_ready(task);
                self.events.push(now);
                // The sixth within a millisecond (controller:TASK-31).
                self.halted = self.events.iter().filter(|at| **at > now - 1_000).count() > 5;
            }
        }
    }

    fn timers(&mut self, now: i64, external: &[i64]) {
        for task in 0..self.plans.len() {
            if self.plans[task].kind == Kind::External && external.contains(&now) {
                self.arrivals.push((now + 180, task));
            }
        }
        for task in 0..self.plans.len() {
            if self.release[task] == now {
                self.release[task] = match self.plans[task].kind {
                    Kind::Cyclic(every) => now + every,
                    _ => NEVER,
                };
                self.make_ready(task);
            }
        }
        for (at, task) in self.arrivals.clone() {
            if at == now {
                self.make_ready(task);
            }
        }
        if now > 0 && now % 1_000 == 0 {
            self.look(now);
        }
    }

    /// Who gets the next microsecond.
    fn choose(&mut self) -> Option<usize> {
        let busy = self.active.iter().position(|at| at.is_some_and(|(_, done)| done > 0));
        if busy.is_some() {
            return busy;
        }
        let wants: Vec<usize> =
            (0..self.plans.len()).filter(|task| self.ready[*task] || self.active[*task].is_some()).collect();
        let priority = self.plans[*wants.first()?].priority;
        let wants: Vec<usize> =
            wants.into_iter().filter(|task| self.plans[*task].priority == priority).collect();
        let turn = &mut self.turns[usize::from(priority)];
        if turn.1 == 0 || !wants.contains(&turn.0) {
            let next = wants.iter().find(|task| turn.0 != usize::MAX && **task > turn.0);
            *turn = (*next.unwrap_or(&wants[0]), 2_000);
        }
        Some(turn.0)
    }

    fn step(&mut self, now: i64) {
        let Some(task) = self.choose() else { return };
        if self.active[task].is_none() {
            self.ready[task] = false;
            self.active[task] = Some((0, 0));
            self.started[task] = now;
            self.trail.push((task, now, "start"));
        }
        let turn = &mut self.turns[usize::from(self.plans[task].priority)];
        turn.1 = (turn.1 - 1).max(0);
        let Some((op, done)) = self.active[task] else { return };
        let (cost, trigger, value) = self.plans[task].ops[op];
        self.active[task] = Some((op, done + 1));
        if done + 1 < cost {
            return;
        }
        self.level[trigger % self.plans.len()] = value;
        self.active[task] = Some((op + 1, 0));
        if op + 1 == self.plans[task].ops.len() {
            self.active[task] = None;
            self.trail.push((task, now + 1, "end"));
            turn.1 = 0;
            if self.plans[task].kind == Kind::Freewheeling {
                self.release[task] = now + 1 + (now + 1 - self.started[task]) * 3 / 7;
            }
            self.look(now + 1);
        }
    }

    fn run(&mut self, until: i64, external: &[i64]) {
        for now in 0..until {
            if !self.halted {
                self.timers(now, external);
            }
            if !self.halted {
                self.step(now);
            }
        }
    }
}

/// The task's kind as a number, its interval, its priority and its operations.
type Drawn = (u8, i64, u8, Vec<(i64, usize, bool)>);

fn drawn() -> impl Strategy<Value = Vec<Drawn>> {
    let op =
        (1i64..60, 0usize..4, any::<bool>()).prop_map(|(cost, trigger, value)| (cost * 7, trigger, value));
    let task = (0u8..6, 200i64..3_000, 25u8..28, proptest::collection::vec(op, 1..7));
    proptest::collection::vec(task, 1..=4)
}

/// MAST first; at most one freewheeling task; in the order of their ranks.
fn plans(drawn: Vec<Drawn>) -> (Vec<Plan>, usize) {
    let mut freewheeling = false;
    let plans = drawn.into_iter().enumerate().map(|(place, (kind, interval, priority, ops))| {
        let kind = match kind {
            1 | 2 if !freewheeling => Kind::Freewheeling,
            3 | 4 if place > 0 => Kind::Event,
            5 if place > 0 => Kind::External,
            _ => Kind::Cyclic(interval),
        };
        freewheeling |= kind == Kind::Freewheeling;
        (place, Plan { kind, priority, ops })
    });
    let mut plans: Vec<_> = plans.collect();
    plans.sort_by_key(|(_, plan)| plan.priority);
    let mast = plans.iter().position(|(place, _)| *place == 0).unwrap();
    (plans.into_iter().map(|(_, plan)| plan).collect(), mast)
}

/// The controller with tasks in the order of their ranks.
fn rig(plans: &[Plan], mast: usize) -> Rig {
    let mut config = config();
    config.profile = profile::Profile::M241_2014;
    let bit = |rank: usize| format!("%MX{}.0", 2_000 + rank);
    config.tasks = plans
        .iter()
        .enumerate()
        .map(|(rank, plan)| TaskConfig {
            name: if rank == mast { "MAST".into() } else { format!("T{rank}") },
            priority: plan.priority,
            watchdog: None,
            kind: match plan.kind {
                Kind::Cyclic(every) => TaskKind::Cyclic { interval: us(every) },
                Kind::Freewheeling => TaskKind::Freewheeling,
                Kind::Event => TaskKind::Event { trigger: bit(rank) },
                Kind::External => TaskKind::ExternalEvent { source: ExternalEventSource::CounterStop(0) },
            },
        })
        .collect();
    let ops = plans.iter().map(|plan| {
        let op = |(cost, trigger, value): &(i64, usize, bool)| {
            (cost * 1_000, Act::Store(at(&bit(trigger % plans.len())), u64::from(*value)))
        };
        plan.ops.iter().map(op).collect()
    });
    Rig::running(config, Script::new(ops.collect()))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn equals_the_oracle(
        drawn in drawn(),
        mut external in proptest::collection::vec(1i64..11_000, 0..12),
        slices in proptest::collection::vec(1i64..900_000, 0..6),
    ) {
        let until = 12_000;
        let (plans, mast) = plans(drawn);
        external.sort_unstable();
        external.dedup();
        let mut oracle = Oracle::new(&plans);
        oracle.run(until, &external);
        let mut rig = rig(&plans, mast);
        rig.slices = slices;
        for event in &external {
            rig.to(run_at(us(*event)));
            rig.plc.external_event(ExternalEventSource::CounterStop(0), rig.now, &mut rig.fx);
        }
        rig.to(run_at(us(until)));
        let since = |time: Time| (time - run_at(Span::ZERO)).as_nanos();
        let seen: Vec<_> =
            rig.trail.lock().unwrap().iter().map(|(task, time, what)| (*task, since(*time), *what)).collect();
        let expected: Vec<_> =
            oracle.trail.iter().map(|(task, time, what)| (*task, time * 1_000, *what)).collect();
        prop_assert_eq!(seen, expected);
        prop_assert_eq!(rig.plc.state() == State::Halt, oracle.halted);
        for (place, lost) in oracle.lost.iter().enumerate() {
            prop_assert_eq!(rig.plc.task_figures(place).unwrap().lost, *lost, "lost of {}", place);
        }
    }
}
