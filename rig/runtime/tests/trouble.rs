//! Faults of the rig: the verdict is `error` with the reason, and nothing stays driven, whatever ended the case.

use crate::texts::Texts;
use controller::{Command, CommandError, Effects, State, Terminal};
use record::Verdict;
use scanrig_runtime::executor::clock::VirtualClock;
use scanrig_runtime::subject::Subject;
use scanrig_runtime::subject::capability::Capability;
use scanrig_runtime::subject::model::ModelledController;
use scanrig_runtime::{CaseResult, ClockKind, RunOptions};
use signal::{Address, Span, Time, Value, When};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::AtomicBool;

/// An output that toggles in every cycle.
const TOGGLE: &str = "PROGRAM MAIN
VAR
    lamp AT %QX0.4 : BOOL;
END_VAR
lamp := NOT lamp;
END_PROGRAM
";

fn plan(rest: &str) -> String {
    format!(
        "format = 1\ntitle = \"A lamp that flashes\"\nprogram = \"toggle.st\"\nboard = \"board.toml\"
        signals = {{ lamp = \"%QX0.4\" }}\nends = \"start + 1 s\"\n{rest}\n[[expect]]\nrises = {{ signal = \"lamp\" }}\n"
    )
}

fn board(rest: &str) -> String {
    format!("format = 1\ntitle = \"Trouble\"\n[board]\nkind = \"simulated\"\n{rest}\n")
}

fn run(plan: &str, board: &str) -> Box<CaseResult> {
    let interrupt = AtomicBool::new(false);
    let options = RunOptions::new(ClockKind::Virtual, &interrupt);
    Texts(&[("plan.toml", plan), ("toggle.st", TOGGLE), ("board.toml", board)]).run(5, &options)
}

fn faults(text: &str) -> String {
    board(&format!("[faults]\n{text}"))
}

#[test]
fn trouble_of_the_board_is_an_error_with_its_reason_and_leaves_everything_safe() {
    for (text, reason) in [
        ("dropped = { chance = 0.2 }", "events of channel Q"),
        ("lost = { chance = 0.2, duration = \"30 ms\" }", "channel Q"),
        ("failed-calls = { chance = 0.05 }", "failed with error number 5"),
    ] {
        let board = faults(text);
        let result = run(&plan(""), &board);
        crate::texts::expect(&result, Verdict::Error);
        assert!(result.record.reason.contains(reason), "{text}: {}", result.record.reason);
        let plan = plan("");
        let texts = [("plan.toml", plan.as_str()), ("toggle.st", TOGGLE), ("board.toml", board.as_str())];
        let (mut model, mut parts) = Texts(&texts).parts(5);
        let ran = parts.run(&mut VirtualClock::default(), &mut model);
        assert!(ran.fault.is_some(), "{text}");
        assert!(parts.board.health().latched_safe, "{text}");
    }
}

/// The board file says whether a lost device ends its case; the case is an error either way.
#[test]
fn a_lost_device_ends_its_case_through_the_teardown_where_the_board_file_says_so() {
    let teardown = "teardown = [{ id = \"rest\", at = \"teardown + 5 ms\", mark = {} }]";
    let lost = "[faults]\nlost = { chance = 0.2, duration = \"30 ms\" }";
    let run = |key: &str| run(&plan(teardown), &board(&format!("{key}{lost}")));
    for (key, early) in [("", false), ("on-loss = \"go-on\"\n", false), ("on-loss = \"end\"\n", true)] {
        let result = run(key);
        crate::texts::expect(&result, Verdict::Error);
        let record = &result.record;
        assert!(record.reason.contains("was lost at"), "{key}: {}", record.reason);
        assert_eq!(record.ended == "a device was lost", early, "{key}: {}", record.ended);
        // The teardown comes in any case.
        let rest = record.steps.iter().find(|step| step.id == "rest").and_then(|step| step.at_ns);
        assert_eq!(rest.map(|at| at[0]), Some(record.end_ns + 5_000_000), "{key}");
    }
}

/// Where lost claims end their case, a lost device still does so by itself, and the teardown comes.
#[test]
fn a_lost_device_is_why_its_case_ended_also_where_the_first_lost_claim_ends_it() {
    let interrupt = AtomicBool::new(false);
    let options = RunOptions { fail_fast: true, ..RunOptions::new(ClockKind::Virtual, &interrupt) };
    let board = board("on-loss = \"end\"\n[faults]\nlost = { chance = 0.2, duration = \"30 ms\" }");
    // What is unknown from the loss on makes the claim inconclusive, and does not end the case before the loss does.
    let plan = plan(
        "teardown = [{ id = \"rest\", at = \"teardown + 5 ms\", mark = {} }]\n\
         [[expect]]\nvalue = { of = \"lamp\", is = true, when = \"start + 999 ms\" }",
    );
    let texts = [("plan.toml", plan.as_str()), ("toggle.st", TOGGLE), ("board.toml", board.as_str())];
    let result = Texts(&texts).run(5, &options);
    crate::texts::expect(&result, Verdict::Error);
    let record = &result.record;
    assert_eq!(record.ended, "a device was lost");
    assert!(record.reason.contains("was lost at"), "{}", record.reason);
    let rest = record.steps.iter().find(|step| step.id == "rest").and_then(|step| step.at_ns);
    assert_eq!(rest.map(|at| at[0]), Some(record.end_ns + 5_000_000));
}

/// Late knowledge is no error: claims get an uncertainty.
#[test]
fn changes_that_become_known_late_are_uncertain_and_no_error() {
    let result = run(&plan(""), &faults("late = { chance = 0.5, by = \"2 ms\" }"));
    crate::texts::expect(&result, Verdict::Pass);
    let trace = result.trace.unwrap();
    let widest = trace.events().map(|event| event.unwrap().at).map(|at| at.latest - at.earliest).max();
    assert!(widest.is_some_and(|widest| widest > Span::ZERO && widest <= Span::from_millis(2)), "{widest:?}");
}

/// What the plan asks for is no trouble of the rig.
#[test]
fn a_loss_that_a_step_asks_for_is_no_error() {
    let lost =
        "steps = [{ id = \"gone\", at = \"start + 0.5 s\", fault = { signal = \"lamp\", kind = \"lost\" } }]";
    let result = run(&plan(lost), &board(""));
    crate::texts::expect(&result, Verdict::Pass);
    let trace = result.trace.unwrap();
    let lamp = trace.find("lamp").unwrap();
    assert_eq!(trace.last(lamp).map(|event| event.value), Some(Value::Unknown));
}

#[test]
fn an_error_of_the_board_names_the_channel() {
    let faults: String = (0..9)
        .map(|n| format!("{{ id = \"f{n}\", at = \"start + {n} ms\", fault = {{ signal = \"lamp\", kind = \"open\" }} }},"))
        .collect();
    let result = run(&plan(&format!("steps = [{faults}]")), &board(""));
    crate::texts::expect(&result, Verdict::Error);
    assert!(result.record.reason.contains("Q4 has 8 faults already"), "{}", result.record.reason);
}

/// A model whose driver has a bug: it panics after some calls.
struct Panics {
    model: ModelledController,
    calls: u32,
}

impl Subject for Panics {
    fn inner(&self) -> Option<&dyn Subject> {
        Some(&self.model)
    }

    fn inner_mut(&mut self) -> Option<&mut dyn Subject> {
        Some(&mut self.model)
    }

    fn capabilities(&self) -> &'static [Capability] {
        self.model.capabilities()
    }

    fn is_model(&self) -> bool {
        self.model.is_model()
    }

    fn state(&self) -> State {
        self.model.state()
    }

    fn power(&mut self, now: Time, on: bool, effects: &mut Effects) {
        self.model.power(now, on, effects);
    }

    fn run(&mut self, limit: Time, effects: &mut Effects) -> Time {
        self.calls -= 1;
        assert!(self.calls > 0, "out of calls");
        self.model.run(limit, effects)
    }

    fn is_computing(&self) -> bool {
        self.model.is_computing()
    }

    fn next_timer(&self) -> Option<Time> {
        self.model.next_timer()
    }

    fn fire(&mut self, now: Time, effects: &mut Effects) {
        self.model.fire(now, effects);
    }

    fn terminal(&self, address: Address) -> Option<Terminal> {
        self.model.terminal(address)
    }

    fn set_input(&mut self, now: Time, at: When, terminal: Terminal, value: Value, effects: &mut Effects) {
        self.model.set_input(now, at, terminal, value, effects);
    }

    fn output(&self, terminal: Terminal) -> Value {
        self.model.output(terminal)
    }

    fn command(&mut self, now: Time, command: &Command, effects: &mut Effects) -> Result<(), CommandError> {
        self.model.command(now, command, effects)
    }

    fn notice(&mut self, at: Time, text: &str) {
        self.model.notice(at, text);
    }
}

#[test]
fn a_subject_around_another_hides_nothing_of_it() {
    let (plan, board) = (plan(""), board(""));
    let texts = [("plan.toml", plan.as_str()), ("toggle.st", TOGGLE), ("board.toml", board.as_str())];
    let (model, _) = Texts(&texts).parts(5);
    let mut subject = Panics { model, calls: 1 };
    assert!(subject.catalogue().is_some_and(|names| names.task_name(0).is_some()));
    assert!(subject.observation().is_some() && subject.observation_mut().is_some());
    assert!(subject.files().is_some());
    assert!(subject.disturbances().is_some());
    assert!(subject.expert_functions().is_some());
    assert!(subject.startup().is_none(), "a model has nothing of it");
}

#[test]
fn a_panic_inside_the_run_drives_the_board_safe() {
    let (plan, board) = (plan(""), board(""));
    let texts = [("plan.toml", plan.as_str()), ("toggle.st", TOGGLE), ("board.toml", board.as_str())];
    for calls in [1, 2, 50, 151] {
        let (model, mut parts) = Texts(&texts).parts(5);
        let mut subject = Panics { model, calls };
        let outcome =
            catch_unwind(AssertUnwindSafe(|| parts.run(&mut VirtualClock::default(), &mut subject)));
        assert!(outcome.is_err(), "{calls} calls");
        assert!(parts.board.health().latched_safe, "{calls} calls");
    }
}
