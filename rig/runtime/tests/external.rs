//! A controller that is not the rig's own: here it is made of wires, which follow its supply and its inputs.

use crate::texts::{Texts, expect};
use record::{CaseStatus, Verdict};
use scanrig_runtime::case::jobs::JobResult;
use scanrig_runtime::{CaseResult, ClockKind, RunOptions};
use signal::{Event, Time};
use std::sync::atomic::AtomicBool;

/// Its program lets the lamp at Q4 follow the button at I0 within 20 ms. It takes 1.5 s from its supply to RUNNING.
const COPPER: &str = "\
format = 1
[board]
kind = \"simulated\"
[channels]
supply = { kind = \"digital\", safe = false }
switch = { kind = \"digital\" }
running = { kind = \"digital\" }
[[wires]]
from = \"supply\"
to = \"running\"
delay = \"1500 ms\"
[[wires]]
from = \"I0\"
to = \"Q4\"
delay = \"20 ms\"
[[wires]]
from = \"switch\"
to = \"Q5\"
";

const LINES: &str = "power = \"supply\"\nalarm = \"running\"\nrun-stop = \"switch\"\noff = \"2 s\"\n";

fn board(subject: &str) -> String {
    format!("{COPPER}[subject]\nkind = \"external\"\n{subject}")
}

fn plan(rest: &str) -> String {
    format!(
        "format = 1\ntitle = \"t\"\nprogram-text = \"PROGRAM MAIN lamp := button; END_PROGRAM\"\n\
         board = \"board.toml\"\nsignals = {{ button = \"%IX0.0\", lamp = \"%QX0.4\", free = \"%QX0.5\" }}\n{rest}"
    )
}

fn run_on(clock: ClockKind, subject: &str, rest: &str) -> Box<CaseResult> {
    let (plan, board) = (plan(rest), board(subject));
    let interrupt = AtomicBool::new(false);
    let options = RunOptions::new(clock, &interrupt);
    Texts(&[("plan.toml", plan.as_str()), ("board.toml", board.as_str())]).run(1, &options)
}

fn run(subject: &str, rest: &str) -> Box<CaseResult> {
    run_on(ClockKind::Virtual, subject, rest)
}

/// Every event of a signal.
fn events(result: &CaseResult, name: &str) -> Vec<Event> {
    let trace = result.trace.as_ref().unwrap();
    let signal = trace.find(name).unwrap();
    trace.events().map(Result::unwrap).filter(|event| event.signal == signal).collect()
}

const PRESS: &str = "\
steps = [{ id = \"press\", at = \"start + 1 s\", set = { signal = \"button\", value = true } }]
expect = [
  { rises = { signal = \"lamp\", from = \"press\", within = \"10 ms .. 30 ms\" } },
  { state = { stays = \"RUNNING\" } },
]";

#[test]
fn its_supply_is_switched_its_alarm_reports_and_its_lines_are_seen() {
    let result = run(LINES, PRESS);
    expect(&result, Verdict::Pass);
    // 2 s without supply, 1.5 s until it runs.
    assert_eq!(result.record.start_ns, 3_500_000_000);
    // After the case everything is safe, its supply too.
    let begun = result.record.steps[0].at_ns.unwrap();
    assert_eq!(begun, [4_500_000_000; 2]);
}

#[test]
fn its_jitter_widens_what_is_seen_of_it_and_nothing_else() {
    let result = run(&format!("{LINES}jitter = \"5 ms\"\n"), PRESS);
    expect(&result, Verdict::Pass);
    let wide = |name| {
        let last = *events(&result, name).last().unwrap();
        (last.at.latest - last.at.earliest).as_nanos()
    };
    assert_eq!((wide("lamp"), wide("button")), (5_000_000, 0));
    // The lamp came after 20 ms; 16 ms is within its jitter, and 14 ms is not.
    for (within, verdict) in [("16 ms", Verdict::Inconclusive), ("14 ms", Verdict::Fail)] {
        let rest = PRESS.replace("10 ms .. 30 ms", within);
        expect(&run(&format!("{LINES}jitter = \"5 ms\"\n"), &rest), verdict);
    }
}

#[test]
fn the_start_is_as_uncertain_as_what_shows_it() {
    let start = |subject: &str| {
        let result = run(subject, "expect = [{ stays = { signal = \"lamp\", is = false } }]");
        events(&result, "step:start")[0].at
    };
    let shown = start(&format!("{LINES}jitter = \"5 ms\"\n"));
    assert_eq!((shown.latest - shown.earliest).as_nanos(), 5_000_000);
    // Without an alarm line it is somewhere between the supply and the longest boot.
    let blind = start("power = \"supply\"\noff = \"2 s\"\nboot = \"4 s\"\n");
    let second = |n: i64| Time::from_nanos(n * 1_000_000_000);
    assert_eq!((blind.earliest, blind.latest), (second(2), second(6)));
}

#[test]
fn power_cuts_and_the_switch_reach_its_lines() {
    let rest = "\
steps = [
  { id = \"stop\", at = \"start + 1 s\", switch = \"stop\" },
  { id = \"cut\", at = \"start + 2 s\", power-cut = { duration = \"3 s\" } },
]
ends = \"cut.done + 3 s\"
expect = [
  { falls = { signal = \"free\", from = \"stop\", within = \"0 ms\" } },
  { state = { becomes = \"OFF\", from = \"cut\", within = \"1.5 s\" } },
  { state = { becomes = \"RUNNING\", from = \"cut.done\", within = \"1.5 s\" } },
]";
    expect(&run(LINES, rest), Verdict::Pass);
}

fn reason(subject: &str, rest: &str) -> String {
    match run(subject, rest).record.status.clone() {
        CaseStatus::NotApplicable { reason } => reason,
        other => panic!("{other:?}"),
    }
}

#[test]
fn what_it_lacks_is_not_applicable_with_the_reason() {
    let claim = "expect = [{ stays = { signal = \"lamp\", is = false } }]";
    let step = |step: &str| format!("steps = [{{ id = \"x\", at = \"start + 1 s\", {step} }}]\n{claim}");
    for (rest, words) in [
        (step("command = \"stop\""), "`commands`"),
        (step("overload = { task = \"MAST\", cycle = \"1 ms\" }"), "`task-load`"),
        (step("write = { of = \"%MW1\", value = 1 }"), "`memory-access`"),
        ("expect = [{ value = { of = \"MAIN.n\", is = 1 } }]".into(), "`MAIN.n` cannot be seen from outside"),
        ("expect = [{ state = { becomes = \"HALT\" } }]".into(), "does not tell the other states apart"),
        (format!("settings = {{ initial = \"stopped\" }}\n{claim}"), "nothing stops a real controller"),
        (format!("settings = {{ initial = \"booting\", firmware = \"invalid\" }}\n{claim}"), "its firmware"),
    ] {
        let reason = reason(LINES, &rest);
        assert!(reason.contains(words), "{rest}\n{reason}");
    }
    let bare = "alarm = \"running\"\n";
    let reasons = [
        (reason(bare, &step("power-cut = { duration = \"1 s\" }")), "`power`"),
        (reason(bare, &step("switch = \"stop\"")), "`run-stop`"),
        (reason("", "expect = [{ state = { stays = \"RUNNING\" } }]"), "no `alarm` line"),
    ];
    for (reason, words) in reasons {
        assert!(reason.contains(words), "{reason}");
    }
}

#[test]
fn a_controller_that_does_not_come_is_trouble_of_the_rig() {
    // Nothing drives the alarm line.
    let subject = "power = \"supply\"\nalarm = \"Q7\"\nboot = \"5 s\"\n";
    let result = run(subject, PRESS);
    expect(&result, Verdict::Error);
    assert!(result.record.reason.contains("it stayed BOOTING"), "{}", result.record.reason);
}

#[test]
fn commands_bring_the_program_and_take_it_away() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("log");
    let command = |words: &str| format!("[\"sh\", \"-c\", \"{words} >> {}\"]", log.display());
    let load = command("echo $RIG_CASE $RIG_PROFILE $(cat $RIG_PROGRAM) $RIG_SETTINGS");
    let unload = command("echo gone");
    let subject = format!("{LINES}load = {load}\nunload = {unload}\n");
    let rest = format!(
        "settings = {{ filter = \"1 ms\", expert = {{ PWM0 = {{ kind = \"pwm\", a = \"%QX0.1\" }} }} }}\n{PRESS}"
    );
    expect(&run(&subject, &rest), Verdict::Pass);
    let text = std::fs::read_to_string(&log).unwrap();
    let expected = "plan m241-2019 PROGRAM MAIN lamp := button; END_PROGRAM initial = \"running\" filter = \"1 ms\" expert.\"PWM0\".kind = \"pwm\" expert.\"PWM0\".a = \"%QX0.1\"\n";
    assert_eq!(text, format!("{expected}gone\n"));
    // With a program to load a case may begin in a state that only that brings about.
    let stopped = format!("{subject}boot = \"3 s\"\n");
    let rest =
        "settings = { initial = \"stopped\" }\nexpect = [{ stays = { signal = \"free\", is = true } }]";
    expect(&run(&stopped, rest), Verdict::Pass);
}

#[test]
fn a_command_that_fails_is_trouble_with_its_words() {
    let fails = "load = [\"sh\", \"-c\", \"echo no such controller >&2; exit 7\"]\n";
    let result = run(&format!("{LINES}{fails}"), PRESS);
    expect(&result, Verdict::Error);
    let words = "the command `sh` of `load` ended with exit code 7: no such controller";
    assert_eq!(result.record.reason, words);
    let slow = "unload = [\"sleep\", \"1000\"]\nload-within = \"50 ms\"\n";
    let result = run(&format!("{LINES}{slow}"), PRESS);
    expect(&result, Verdict::Error);
    assert!(result.record.reason.contains("had not ended after 50 ms"), "{}", result.record.reason);
}

#[test]
fn lateness_of_the_rig_widens_and_contradicts_nothing() {
    let late = signal::Span::from_micros(50);
    for seed in [3, 4] {
        let (plan, board) = (plan(PRESS), board(LINES));
        let interrupt = AtomicBool::new(false);
        let options = RunOptions::new(ClockKind::Late(late), &interrupt);
        let texts = [("plan.toml", plan.as_str()), ("board.toml", board.as_str())];
        expect(&Texts(&texts).run(seed, &options), Verdict::Pass);
    }
}

#[test]
fn a_controller_that_stops_running_breaks_what_is_claimed_of_its_state() {
    let rest = "\
steps = [{ id = \"cut\", at = \"start + 1 s\", power = \"off\" }]
ends = \"cut + 3 s\"
expect = [{ state = { stays = \"RUNNING\" } }]";
    expect(&run(LINES, rest), Verdict::Fail);
}

#[test]
fn that_it_never_runs_is_all_that_can_be_claimed_of_its_stop() {
    let claimed = |from: &str| {
        let claim = format!("{{ never = {{ signal = \"state\", is = \"RUNNING\", from = \"{from}\" }} }}");
        let step = "{ id = \"cut\", at = \"start + 1 s\", power = \"off\" }";
        run(LINES, &format!("steps = [{step}]\nends = \"cut + 3 s\"\nexpect = [{claim}]"))
    };
    expect(&claimed("cut + 2 s"), Verdict::Pass);
    expect(&claimed("start"), Verdict::Fail);
}

#[test]
fn a_case_that_begins_with_its_boot_switches_its_supply_whatever_the_board_says() {
    let rest = "\
settings = { initial = \"booting\" }
ends = \"start + 3 s\"
expect = [{ state = { becomes = \"RUNNING\", from = \"start\", within = \"1.4 s .. 1.6 s\" } }]";
    let subject = format!("{LINES}cycle = false\nload = [\"true\"]\n");
    expect(&run(&subject, rest), Verdict::Pass);
}

#[test]
fn what_a_check_refuses_is_not_asked_of_it() {
    let (plan, board) = (plan("refused = { code = \"R0113\" }"), board(LINES));
    let interrupt = AtomicBool::new(false);
    let options = RunOptions::new(ClockKind::Virtual, &interrupt);
    let texts = [("plan.toml", plan.as_str()), ("board.toml", board.as_str())];
    match Texts(&texts).done(1, &options) {
        JobResult::Case(result) => {
            assert!(matches!(result.record.status, CaseStatus::NotApplicable { .. }), "{result:#?}");
        }
        other => panic!("{other:#?}"),
    }
}

/// A plant is the bench's, whatever controller is at it.
#[test]
fn a_plant_at_a_real_controller_is_set_as_any_other() {
    let oven = "[channels.warmth]
kind = \"analog\"
unit = \"degC\"
[[plants]]
kind = \"lag\"
name = \"oven\"
input = \"Q4\"
output = \"warmth\"
low = 20
high = 100
tau = \"1 ms\"
sample = \"1 ms\"
";
    let rest = "steps = [
  { id = \"heat\", at = \"start + 1 s\", set = { signal = \"button\", value = true } },
  { id = \"weak\", at = \"heat + 1 s\", set-plant = { plant = \"oven\", parameter = \"high\", value = \"60 degC\", duration = \"1 s\" } },
]
ends = \"weak.done + 1 s\"
expect = [
  { stays = { signal = \"warmth\", is = \"100 degC\", from = \"heat + 100 ms\", until = \"weak\" } },
  { stays = { signal = \"warmth\", is = \"60 degC\", from = \"weak + 100 ms\", until = \"weak.done\" } },
  { stays = { signal = \"warmth\", is = \"100 degC\", from = \"weak.done + 100 ms\" } },
]
";
    expect(&run(&format!("{LINES}{oven}"), rest), Verdict::Pass);
}
