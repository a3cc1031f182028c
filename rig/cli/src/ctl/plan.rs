//! `rig ctl plans` and `rig ctl plan`: cases on the board of a rig that runs.

use super::show::{print_text, seconds};
use super::{CtlError, commands, interrupt};
use crate::exit::ExitStatus;
use crate::output;
use crate::run_exit;
use clap::Args;
use control::{
    ClientError, ControlClient, Done, Measured, PlanEvent, Plans, RequestOperation, Subscribed,
    SubscriptionEvent, Topic,
};
use record::Verdict;
use serde_json::json;
use signal::Span;
use std::time::{Duration, Instant};

/// How long the controller may take to stop, and the plan to be read.
const PATIENCE: Duration = Duration::from_secs(120);

/// How long an interrupt may go unseen.
const LOOK_UP: Duration = Duration::from_millis(100);

/// `rig ctl plans`.
#[derive(Debug, Args)]
pub struct PlansArgs {
    /// A plan or a folder with plans as the rig sees it [default: the plans that ship with it].
    #[arg(value_name = "PLAN|DIR")]
    path: Option<String>,
}

/// Lists cases.
pub fn list(client: &mut ControlClient, args: &PlansArgs) -> Result<ExitStatus, CtlError> {
    let known: Plans = client.ask_within(RequestOperation::Plans { path: args.path.clone() }, PATIENCE)?;
    known.plans.iter().for_each(|name| output::print(&format!("{name}\n")));
    Ok(if known.plans.is_empty() { ExitStatus::UserFiles } else { ExitStatus::Passed })
}

/// `rig ctl plan`.
#[derive(Debug, Args)]
pub struct PlanArgs {
    /// The case, or the plan with all its cases, as `rig ctl plans` names it.
    name: String,
    /// Print JSON for a program: the events of the plan, an object a line.
    #[arg(long)]
    json: bool,
    /// Do not ask for confirmation on a terminal.
    #[arg(long, short)]
    yes: bool,
}

/// Runs a plan and prints its progress; an interrupt ends it.
pub fn run(client: &mut ControlClient, args: &PlanArgs) -> Result<ExitStatus, CtlError> {
    commands::confirm(client, args.yes, &format!("run {}", args.name))?;
    let interrupted = interrupt::catch()?;
    client.ask::<Subscribed>(RequestOperation::Subscribe { topic: Topic::Plan })?;
    client.ask_within::<Done>(RequestOperation::Plan { name: args.name.clone() }, PATIENCE)?;
    // When the end of a plan that was aborted is overdue.
    let mut due: Option<Instant> = None;
    let mut text_of_plan = RunningPlanText::default();
    let (mut cases, mut judged) = (0, false);
    loop {
        if interrupted() && due.is_none() {
            due = Some(Instant::now() + PATIENCE);
            output::note("interrupted: the plan ends, outputs become safe");
            client.ask_within::<Done>(RequestOperation::Abort, PATIENCE)?;
        }
        if due.is_some_and(|due| Instant::now() >= due) {
            return Err(ClientError::Silent(client.socket().to_owned(), PATIENCE).into());
        }
        match client.next(LOOK_UP)? {
            Some(SubscriptionEvent::Plan { event, .. }) => {
                print_text(&if args.json {
                    format!("{}\n", json!(event))
                } else {
                    text_of_plan.shown(&event)
                });
                match event {
                    PlanEvent::Verdict { verdict, .. } => {
                        cases += 1;
                        judged |= verdict_of(&verdict).is_some();
                    }
                    PlanEvent::Over { .. } if due.is_some() => return Ok(ExitStatus::Interrupted),
                    PlanEvent::Over { .. } if !judged && cases > 0 => {
                        return Ok(run_exit::none_judged(cases, run_exit::REASONS_ARE_PRINTED));
                    }
                    PlanEvent::Over { verdict, .. } => return Ok(exit_of(&verdict)),
                    _ => {}
                }
            }
            Some(SubscriptionEvent::Missed { lines, .. }) => {
                output::note(&format!("{lines} lines were left out"))
            }
            _ => {}
        }
    }
}

/// The exit of a verdict, as `rig test` has it; a word that is not known is no pass.
fn exit_of(verdict: &str) -> ExitStatus {
    verdict_of(verdict).map_or(ExitStatus::Error, ExitStatus::of)
}

/// The verdict of a word; a case that does not apply, or was skipped, has none.
fn verdict_of(word: &str) -> Option<Verdict> {
    let all = [Verdict::None, Verdict::Pass, Verdict::Inconclusive, Verdict::Fail, Verdict::Error];
    all.into_iter().find(|known| known.word() == word)
}

/// What is known of the case that runs.
#[derive(Debug, Default)]
struct RunningPlanText {
    steps: Vec<(String, String)>,
}

impl RunningPlanText {
    /// An event, for a person.
    fn shown(&mut self, event: &PlanEvent) -> String {
        match event {
            PlanEvent::Case { name, place, steps, .. } => {
                self.steps.clone_from(steps);
                format!("{name} ({} of {})\n", place.0, place.1)
            }
            // What a step comes to is seen when it is done.
            PlanEvent::Step { done: false, .. } => String::new(),
            PlanEvent::Step { step, at, done: true } => {
                let known = self.steps.get(*step as usize);
                let (name, what) = known.map_or(("", ""), |(name, what)| (name.as_str(), what.as_str()));
                let line = format!("{:>16}  {name}  {what}", seconds(*at));
                format!("{}\n", line.trim_end())
            }
            PlanEvent::Verdict { name, verdict, reason, claims, measured } => {
                let mut text = String::new();
                for (claim, verdict, reason) in
                    claims.iter().filter(|(_, verdict, _)| verdict != Verdict::Pass.word())
                {
                    text.push_str(&format!("  {verdict}: {claim}: {reason}\n"));
                }
                for one in measured {
                    text.push_str(&format!("  {}: {}: {}\n", one.verdict, one.name, figure(one)));
                }
                let reason = if reason.is_empty() { String::new() } else { format!(": {reason}") };
                text.push_str(&format!("{verdict}: {name}{reason}\n"));
                text
            }
            PlanEvent::Over { verdict, report } => {
                let report = report.as_ref().map(|path| format!(", report in {path}")).unwrap_or_default();
                format!("all: {verdict}{report}\n")
            }
        }
    }
}

/// A measurement and its limits.
fn figure(one: &Measured) -> String {
    // Durations are nanoseconds on the wire, and shown in the unit that fits.
    let (unit, number): (&str, fn(f64) -> String) = match one.unit.as_str() {
        "ns" => ("", |nanos| Span::from_nanos(nanos.round() as i64).to_string()),
        unit => (unit, |number| number.to_string()),
    };
    let value = match one.value {
        None => "not measured".to_owned(),
        Some((low, high)) if low.to_bits() == high.to_bits() => format!("{} {unit}", number(low)),
        Some((low, high)) => format!("{} .. {} {unit}", number(low), number(high)),
    };
    let limit = |limit: f64| format!("{} {unit}", number(limit)).trim_end().to_owned();
    let value = value.trim_end();
    match (one.low, one.high) {
        (None, None) => value.to_owned(),
        (Some(low), None) => format!("{value}, at least {}", limit(low)),
        (None, Some(high)) => format!("{value}, at most {}", limit(high)),
        (Some(low), Some(high)) => format!("{value} in {} .. {}", number(low), limit(high)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_verdict_has_the_exit_of_a_test() {
        let exits = ["pass", "fail", "inconclusive", "error", "none", "a younger word"].map(exit_of);
        assert_eq!(
            exits,
            [
                ExitStatus::Passed,
                ExitStatus::Failed,
                ExitStatus::Inconclusive,
                ExitStatus::Error,
                ExitStatus::Passed,
                ExitStatus::Error
            ]
        );
    }

    #[test]
    fn the_course_of_a_case_is_told() {
        let mut text_of_plan = RunningPlanText::default();
        let case = PlanEvent::Case {
            name: "lamp".to_owned(),
            place: (1, 2),
            steps: vec![("press".to_owned(), "set I0 to TRUE".to_owned())],
            claims: Vec::new(),
        };
        assert_eq!(text_of_plan.shown(&case), "lamp (1 of 2)\n");
        let step = |step, done| PlanEvent::Step { step, at: 2_000_000, done };
        assert_eq!(text_of_plan.shown(&step(0, false)), "");
        assert_eq!(text_of_plan.shown(&step(0, true)), "      0.002000 s  press  set I0 to TRUE\n");
        assert_eq!(text_of_plan.shown(&step(9, true)), "      0.002000 s\n");
        let measured = Measured {
            name: "delay".to_owned(),
            value: Some((9.5, 10.5)),
            low: None,
            high: Some(10.0),
            unit: "ms".to_owned(),
            verdict: "inconclusive".to_owned(),
        };
        let verdict = PlanEvent::Verdict {
            name: "lamp".to_owned(),
            verdict: "fail".to_owned(),
            reason: "it stayed dark".to_owned(),
            claims: vec![
                ("a".to_owned(), "pass".to_owned(), String::new()),
                ("b".to_owned(), "fail".to_owned(), "dark".to_owned()),
            ],
            measured: vec![measured],
        };
        assert_eq!(
            text_of_plan.shown(&verdict),
            "  fail: b: dark\n  inconclusive: delay: 9.5 .. 10.5 ms, at most 10 ms\nfail: lamp: it stayed dark\n"
        );
    }

    #[test]
    fn a_measurement_has_the_limits_that_it_has() {
        let shown = |low, high| {
            figure(&Measured {
                name: "delay".to_owned(),
                value: Some((102_663_219.0, 102_663_219.0)),
                low,
                high,
                unit: "ns".to_owned(),
                verdict: "none".to_owned(),
            })
        };
        assert_eq!(shown(None, None), "102.663219 ms");
        assert_eq!(shown(Some(1e6), None), "102.663219 ms, at least 1 ms");
        assert_eq!(shown(None, Some(2e8)), "102.663219 ms, at most 200 ms");
        assert_eq!(shown(Some(1e6), Some(2e8)), "102.663219 ms in 1 ms .. 200 ms");
    }
}
