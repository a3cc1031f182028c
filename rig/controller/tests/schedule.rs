//! Scheduling against a naive oracle that steps microsecond by microsecond, and independence of slices.

use crate::support::*;
use proptest::prelude::*;
use scanrig_controller::*;
use signal::{Level, Span, Time, Value};

/// A task of the oracle: priority is its place, costs in microseconds.
#[derive(Clone, Debug)]
struct Plan {
    interval: i64,
    ops: Vec<i64>,
}

/// Starts and ends of cycles within `until` microseconds, one processor, highest priority first, an operation under
/// way is finished, one release waits and others are lost (controller:TASK-03, controller:TASK-11).
fn oracle(plans: &[Plan], until: i64) -> (Vec<(usize, i64, &'static str)>, Vec<u64>) {
    struct At {
        op: usize,
        done: i64,
    }
    let (mut trail, mut lost) = (Vec::new(), vec![0; plans.len()]);
    let mut ready = vec![true; plans.len()];
    let mut active: Vec<Option<At>> = plans.iter().map(|_| None).collect();
    for now in 0..until {
        if now > 0 {
            for (task, plan) in plans.iter().enumerate() {
                if now % plan.interval == 0 {
                    lost[task] += u64::from(ready[task]);
                    ready[task] = true;
                }
            }
        }
        let busy = active.iter().position(|at| at.as_ref().is_some_and(|at| at.done > 0));
        let first = (0..plans.len()).find(|task| ready[*task] || active[*task].is_some());
        let Some(task) = busy.or(first) else { continue };
        if active[task].is_none() {
            ready[task] = false;
            active[task] = Some(At { op: 0, done: 0 });
            trail.push((task, now, "start"));
        }
        if let Some(at) = &mut active[task] {
            at.done += 1;
            if at.done == plans[task].ops[at.op] {
                (at.op, at.done) = (at.op + 1, 0);
            }
            if at.op == plans[task].ops.len() {
                active[task] = None;
                trail.push((task, now + 1, "end"));
            }
        }
    }
    (trail, lost)
}

fn plans() -> impl Strategy<Value = Vec<Plan>> {
    let plan = (5i64..200, proptest::collection::vec(1i64..20, 1..6))
        .prop_map(|(interval, ops)| Plan { interval, ops });
    proptest::collection::vec(plan, 1..=4)
}

/// The place of each task in the configuration is shuffled against its priority.
fn rig(plans: &[Plan], turn: usize) -> (Rig, Vec<usize>) {
    let mut order: Vec<usize> = (0..plans.len()).collect();
    order.rotate_left(turn % plans.len());
    let mut config = config();
    config.tasks = order
        .iter()
        .map(|rank| {
            // Background tasks only: full load is no system error then (controller:WD-02).
            let name = if *rank == 0 { "MAST".into() } else { format!("T{rank}") };
            task(&name, 25 + *rank as u8, us(plans[*rank].interval))
        })
        .collect();
    let ops = order.iter().map(|rank| plans[*rank].ops.iter().map(|cost| (cost * 1_000, Act::Nop)).collect());
    (Rig::running(config, Script::new(ops.collect())), order)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn equals_the_oracle(plans in plans(), turn in 0usize..4, slices in proptest::collection::vec(1i64..90_000, 0..8)) {
        let until = 3_000;
        let (mut rig, order) = rig(&plans, turn);
        rig.slices = slices;
        rig.to(run_at(us(until)));
        let seen: Vec<_> = rig.trail.lock().unwrap().iter().map(|(place, at, what)| {
            (order[*place], (*at - run_at(Span::ZERO)).as_nanos(), *what)
        }).collect();
        let (expected, lost) = oracle(&plans, until);
        let expected: Vec<_> = expected.into_iter().map(|(task, at, what)| (task, at * 1_000, what)).collect();
        prop_assert_eq!(seen, expected);
        for (place, rank) in order.iter().enumerate() {
            prop_assert_eq!(rig.plc.task_figures(place).unwrap().lost, lost[*rank]);
        }
    }

    /// Everything that happens is the same however time is sliced, and watching changes nothing but what it reports.
    #[test]
    fn slices_never_show(plans in plans(), slices in proptest::collection::vec(1i64..5_000, 1..8), edge in 0i64..2_000) {
        let run = |slices: Vec<i64>, watched: bool| {
            let mut config = config();
            config.inputs = vec![InputConfig::filtered(profile::InputFilter::None); 14];
            let tasks = plans.iter().enumerate();
            config.tasks = tasks
                .clone()
                .map(|(rank, plan)| {
                    let name = if rank == 0 { "MAST".into() } else { format!("T{rank}") };
                    let watchdog = Some(TaskWatchdog { time: us(400), sensitivity: 2 });
                    TaskConfig { watchdog, ..task(&name, 25 + rank as u8, us(plan.interval)) }
                })
                .collect();
            let mut script = Script::new(
                tasks
                    .map(|(rank, plan)| {
                        // The first task drives outputs, the others count in words and variables.
                        let acts = [
                            Act::Copy(at("%IX0.0"), at(["%QX0.4", "%MX4.0", "%MX6.0", "%MX8.0"][rank])),
                            Act::Add(rank, 1),
                            Act::Store(at(["%QX0.0", "%MX4.1", "%MX6.1", "%MX8.1"][rank]), plan.interval as u64 % 2),
                            Act::Move(rank, (rank + 1) % 4),
                            Act::Store(at(["%QX0.0", "%MX4.1", "%MX6.1", "%MX8.1"][rank]), 1),
                        ];
                        plan.ops.iter().zip(acts).map(|(cost, act)| (cost * 700, act)).chain([(0, Act::Add(4, 1))]).collect()
                    })
                    .collect(),
            );
            script.variables = vec![(0, Keep::Plain); 5];
            let mut rig = Rig::running(config, script);
            rig.slices = slices;
            if watched {
                for n in 0..5 {
                    rig.plc.watch(Probe::Variable(n));
                }
                rig.plc.watch(Probe::Address(signal::Address::bit(signal::Area::Input, 0)));
                rig.plc.watch(Probe::Address(at("%MW2")));
                rig.plc.watch(Probe::TaskFigure { task: 0, figure: TaskFigure::Last });
            }
            rig.to(run_at(us(edge)));
            rig.plc.input(rig.now, Terminal::input(0), Value::from(Level::High));
            rig.to(run_at(us(4_000)));
            let trail = rig.trail.lock().unwrap().clone();
            (rig.seen, trail)
        };
        let whole = run(vec![], true);
        prop_assert_eq!(&run(slices, true), &whole);
        let unwatched = run(vec![], false);
        let own: Vec<_> = whole.0.into_iter().filter(|effect| !matches!(effect, Effect::Changed { .. })).collect();
        prop_assert_eq!(unwatched.0, own);
        prop_assert_eq!(unwatched.1, whole.1);
    }
}

// controller:TASK-03: the operation under way is finished before a pre-emption.
#[test]
fn an_operation_is_never_cut() {
    let mut config = config();
    config.tasks.push(task("FAST", 0, ms(1)));
    let script = Script::new(vec![vec![(900_000, Act::Nop), (300_000, Act::Nop)], vec![(10_000, Act::Nop)]]);
    let mut rig = Rig::running(config, script);
    rig.after(ms(3));
    let trail = rig.trail.lock().unwrap().clone();
    let fast: Vec<_> =
        trail.iter().filter(|(task, _, what)| *task == 1 && *what == "start").map(|it| it.1).collect();
    // MAST: 10 us...910 us and 910 us...1210 us.
    assert_eq!(fast, [run_at(us(0)), run_at(us(1_210)), run_at(us(2_000))]);
}

// controller:TASK-10: an empty cycle takes the minimum, and an overload takes what it was given, pre-emptible anywhere.
#[test]
fn minimum_cycle_and_overload() {
    let mut config = config();
    config.tasks.push(task("FAST", 0, ms(1)));
    let mut rig = Rig::running(config, Script::new(vec![vec![], vec![(100_000, Act::Nop)]]));
    rig.to(run_at(ms(20)));
    rig.plc.overload(0, us(2_500), 1);
    let figures = rig.plc.task_figures(0).unwrap();
    assert_eq!((figures.cycles, figures.last, figures.elapsed), (1, us(1), us(1)));
    rig.to(run_at(ms(40)));
    let figures = rig.plc.task_figures(0).unwrap();
    // FAST takes 100 us at 20, 21 and 22 ms.
    assert_eq!((figures.cycles, figures.last, figures.elapsed), (2, us(2_500), us(2_700)));
    let trail = rig.trail.lock().unwrap().clone();
    let starts: Vec<_> = trail.iter().filter(|it| (it.0, it.2) == (0, "start")).map(|it| it.1).collect();
    assert_eq!(starts, [run_at(us(100)), run_at(us(20_100))]);
    rig.to(run_at(ms(60)));
    assert_eq!(rig.plc.task_figures(0).unwrap().last, us(1));
}

// controller:TASK-11: the cycle repeats at once, nothing is stretched.
#[test]
fn an_interval_too_short_repeats_at_once() {
    let mut config = config();
    config.tasks[0] = TaskConfig { priority: 30, ..task("MAST", 30, ms(10)) };
    let mut rig = Rig::running(config, Script::new(vec![vec![(25_000_000, Act::Nop)]]));
    rig.to(run_at(ms(101)));
    let starts: Vec<_> =
        rig.trail.lock().unwrap().iter().filter(|it| it.2 == "start").map(|it| it.1).collect();
    assert_eq!(starts, [0, 25, 50, 75, 100].map(|n| run_at(ms(n))));
    let figures = rig.plc.task_figures(0).unwrap();
    // Releases at 10...100 ms: those of 20, 40, 50?, ... found one waiting.
    assert_eq!((figures.overruns, figures.cycles), (4, 4));
    assert_eq!(figures.lost, 6);
}

#[test]
fn time_never_goes_backwards_for_an_idle_controller() {
    let mut rig = Rig::off(config(), Script::new(vec![vec![]]));
    assert_eq!(rig.plc.next_timer(), None);
    assert_eq!(rig.plc.run(Time::ZERO + ms(5), &mut rig.fx), Time::ZERO + ms(5));
}
