//! Plans in the place of the controller that is kept running.

use super::{Bench, PATIENCE, with_rig};
use control::PlanEvent;
use services::control::{Answer, Rig, RigEvent, RigOrder, Ticket};
use signal::{Span, Value};
use std::time::Instant;

fn over(bench: &mut Bench<'_>) -> String {
    bench.until("the end of the plan", |reported| match reported {
        RigEvent::Plan(PlanEvent::Over { verdict, .. }) => Some(verdict.clone()),
        _ => None,
    })
}

#[test]
fn a_plan_is_reported_as_it_goes_and_the_controller_begins_anew() {
    with_rig(true, |bench| {
        bench.advance(Span::from_secs(1));
        let (count, signal) = (bench.watch("MAIN.count"), bench.watch("signal"));
        bench.force("Q1", true).unwrap();
        let listed = |names: &[&str]| Ok(Answer::Plans(names.iter().map(|name| (*name).into()).collect()));
        assert_eq!(bench.order(RigOrder::Plans(None)), listed(&["press", "long", "none"]));
        // One that cannot be read hides no other.
        assert_eq!(bench.order(RigOrder::Plans(Some(".".into()))), listed(&["press", "long"]));
        assert_eq!(bench.order(RigOrder::Plan("press".into())), Ok(Answer::Done));
        assert_eq!(over(bench), "pass");
        let reported: Vec<PlanEvent> = bench
            .reported
            .iter()
            .filter_map(|reported| match reported {
                RigEvent::Plan(event) => Some(event.clone()),
                _ => None,
            })
            .collect();
        let [PlanEvent::Case { name, place, steps, claims }, begun, done, verdict, _] = &reported[..] else {
            panic!("{reported:#?}");
        };
        assert_eq!((name.as_str(), *place), ("press", (1, 1)));
        assert_eq!((steps[0].0.as_str(), claims.len()), ("press", 2));
        for (event, is_done) in [(begun, false), (done, true)] {
            let PlanEvent::Step { step, at, done } = event else { panic!("{event:?}") };
            assert_eq!((*step, *at, *done), (0, 100_000_000, is_done));
        }
        let PlanEvent::Verdict { verdict, measured, .. } = verdict else { panic!("{verdict:?}") };
        assert_eq!((verdict.as_str(), measured[0].high), ("pass", Some(100_000_000.0)));
        // What lines did in the case was reported; the variable of the rig's own program was not there.
        assert!(bench.changes(signal).iter().any(|(_, value)| *value == Value::Bool(true)));
        bench.advance(Span::from_millis(100));
        let status = bench.rig.status();
        assert!(status.forced.is_empty() && status.plan.is_none(), "{status:?}");
        assert_eq!(status.state, "RUNNING");
        // It counts from the beginning, and time went on.
        assert_eq!(bench.read("MAIN.count"), Value::Int(5));
        let changes = bench.changes(count);
        assert!(
            changes.iter().any(|(at, value)| *at > 1_300_000_000 && *value == Value::Int(3)),
            "{changes:?}"
        );
        assert!(changes.windows(2).all(|pair| pair[0].0 <= pair[1].0), "{changes:?}");
    });
}

#[test]
fn a_plan_that_runs_has_the_board_and_can_be_ended() {
    with_rig(false, |bench| {
        assert_eq!(bench.order(RigOrder::Abort).unwrap_err().code, "R0612");
        assert_eq!(bench.order(RigOrder::Plan("long".into())), Ok(Answer::Done));
        bench.status("the case", |status| status.plan.as_ref().is_some_and(|plan| plan.case == "long"));
        bench.status("the case runs", |status| status.state == "RUNNING");
        assert_eq!(bench.force("Q0", true).unwrap_err().code, "R0611");
        assert_eq!(bench.order(RigOrder::Plan("press".into())).unwrap_err().code, "R0611");
        assert_eq!(bench.read("%QX0.0"), Value::Bool(false));
        assert_eq!(bench.order(RigOrder::Abort), Ok(Answer::Done));
        assert_eq!(over(bench), "error");
        bench.status("the controller", |status| status.plan.is_none() && status.tasks[0].cycles > 2);
        bench.force("Q0", true).unwrap();
    });
}

#[test]
fn what_is_no_plan_is_refused_and_the_controller_goes_on() {
    with_rig(true, |bench| {
        bench.advance(Span::from_secs(1));
        let fault = bench.order(RigOrder::Plan("none".into())).unwrap_err();
        assert!(fault.code == "R0610" && fault.message.contains("R0201"), "{fault:?}");
        let fault = bench.order(RigOrder::Plan("press[fast]".into())).unwrap_err();
        assert_eq!((fault.code.as_str(), fault.help.as_str()), ("R0610", "`rig ctl plans` lists the cases"));
        assert_eq!(bench.read("MAIN.count"), Value::Int(50));
    });
}

#[test]
fn a_disk_that_does_not_answer_delays_those_who_ask_for_it_and_nobody_else() {
    with_rig(true, |bench| {
        bench.advance(Span::from_secs(1));
        let hangs = || RigOrder::Plans(Some("hangs".into()));
        for ticket in 1_000..1_004 {
            assert_eq!(bench.rig.order(Ticket(ticket), hangs()), Ok(()));
        }
        assert_eq!(bench.rig.order(Ticket(1_004), hangs()).unwrap_err().code, "R0613");
        assert_eq!(bench.read("MAIN.count"), Value::Int(50));
        let mut given_up = |ticket| {
            bench.until("the end of the wait", |reported| match reported {
                RigEvent::Answer(Ticket(of), Err(fault)) if *of == ticket => Some(fault.code.clone()),
                _ => None,
            })
        };
        for ticket in 1_000..1_004 {
            assert_eq!(given_up(ticket), "R0613");
        }
        // The readers learned that nobody waits, and ended.
        let began = Instant::now();
        while bench.order(RigOrder::Plans(None)).is_err() {
            assert!(began.elapsed() < PATIENCE, "the readers do not end");
        }
    });
}
