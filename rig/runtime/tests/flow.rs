//! How cases come through setup, steps and teardown: every row of the table in `docs/plans/steps.md`. Each verdict is the same
//! when the trace is judged again.

use crate::texts::Texts;
use plans::steps::Question;
use record::{CaseRecord, Verdict};
use scanrig_runtime::case::jobs::JobResult;
use scanrig_runtime::case::rejudge;
use scanrig_runtime::{AskError, CaseResult, ClockKind, Operator, RunOptions};
use signal::{LoadLimits, Trace};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

/// The valve opens with the button and closes with the stop button.
const VALVE: &str = "PROGRAM MAIN
VAR
    button AT %IX0.0 : BOOL;
    stop AT %IX0.1 : BOOL;
    valve AT %QX0.4 : BOOL;
END_VAR
IF stop THEN valve := FALSE; ELSIF button THEN valve := TRUE; END_IF;
END_PROGRAM
";

const HEAD: &str = "format = 1
program = \"valve.st\"
settings = { filter = \"0 ms\", mast = { interval = \"5 ms\" } }
signals = { button = \"%IX0.0\", stop = \"%IX0.1\", valve = \"%QX0.4\" }
";

/// Opens the valve in the steps and closes it in the teardown.
const USUAL: &str = "
steps = [{ id = \"open\", at = \"main + 100 ms\", pulse = { signal = \"button\", width = \"20 ms\" } }]
ends = \"main + 1 s\"
teardown = [
  { id = \"close\", at = \"teardown + 10 ms\", set = { signal = \"stop\", value = true } },
  { id = \"closed\", when = { signal = \"valve\", edge = \"falls\", within = \"100 ms\" } },
]
";

fn texts<'a>(files: &'a [(&'a str, &'a str)]) -> Texts<'a> {
    Texts(files)
}

fn run_with(rest: &str, board: &str, options: &RunOptions<'_>) -> Box<CaseResult> {
    let plan = format!("{HEAD}board = \"board.toml\"\n{rest}");
    let board = format!("format = 1\ntitle = \"A bench\"\n[board]\nkind = \"simulated\"\n{board}\n");
    let result = texts(&[("plan.toml", &plan), ("valve.st", VALVE), ("board.toml", &board)]).run(3, options);
    let mut bytes = Vec::new();
    let trace = result.trace.as_ref().unwrap();
    trace.save(&mut bytes).unwrap();
    let loaded = Trace::load(&mut bytes.as_slice(), LoadLimits::default()).unwrap();
    let again = rejudge::judge(&document::SourceFile::new("plan.toml", plan), &loaded).unwrap();
    assert_eq!(again.verdict, result.record.verdict, "{} {}", again.reason, result.record.reason);
    assert_eq!(again.claims, result.record.claims);
    assert_eq!((again.ended, again.duration_ns), (result.record.ended.clone(), result.record.duration_ns));
    result
}

fn run(rest: &str) -> Box<CaseResult> {
    let interrupt = AtomicBool::new(false);
    run_with(rest, "", &RunOptions::new(ClockKind::Virtual, &interrupt))
}

/// When a step came, milliseconds after the start; `None` if it did not.
fn came(record: &CaseRecord, id: &str) -> Option<i64> {
    let step = record.steps.iter().find(|step| step.id == id).unwrap();
    step.at_ns.map(|[at, _]| (at - record.start_ns) / 1_000_000)
}

fn claim<'r>(record: &'r CaseRecord, name: &str) -> (Verdict, &'r str) {
    let names: Vec<&str> = record.claims.iter().map(|claim| claim.name.as_str()).collect();
    let found = record.claims.iter().find(|claim| claim.name == name);
    let found = found.unwrap_or_else(|| panic!("no claim `{name}` among {names:?}"));
    (found.verdict, &found.reason)
}

#[test]
fn the_teardown_comes_behind_the_end_and_is_seen_by_whom_it_concerns() {
    let result = run(&format!(
        "{USUAL}expect = [
          {{ name = \"open\", stays = {{ signal = \"valve\", is = true, from = \"open + 20 ms\" }} }},
          {{ name = \"closed\", falls = {{ signal = \"valve\", from = \"teardown\", within = \"10 ms .. 16 ms\" }} }},
          {{ name = \"never\", falls = {{ signal = \"valve\", from = \"open\" }} }},
        ]"
    ));
    let record = &result.record;
    assert_eq!(claim(record, "open").0, Verdict::Pass);
    assert_eq!(claim(record, "closed").0, Verdict::Pass);
    assert_eq!(claim(record, "never").0, Verdict::Fail);
    assert_eq!((came(record, "open"), came(record, "close")), (Some(100), Some(1_010)));
    assert_eq!(record.end_ns - record.start_ns, 1_000_000_000);
    assert!(record.duration_ns > record.end_ns);
    let phases: Vec<&str> = record.steps.iter().map(|step| step.phase.as_str()).collect();
    assert_eq!(phases, ["main", "teardown", "teardown"]);
}

#[test]
fn without_its_setup_nothing_is_tried_and_the_teardown_comes() {
    let result = run(&format!(
        "setup = [
          {{ id = \"warm\", when = {{ signal = \"valve\", edge = \"rises\", within = \"300 ms\" }} }},
          {{ id = \"also\", at = \"start + 400 ms\", mark = {{}} }},
        ]{USUAL}expect = [
          {{ name = \"quiet\", stays = {{ signal = \"valve\", is = false }} }},
          {{ name = \"warms\", happens = {{ step = \"warm\", from = \"start\", within = \"1 s\" }} }},
          {{ name = \"closes\", rises = {{ signal = \"stop\", from = \"teardown\", within = \"10 ms\" }} }},
        ]
        measure = [{{ name = \"delay\", from = \"start\", to = {{ signal = \"valve\", edge = \"rises\" }}, max = \"1 s\" }}]"
    ));
    let record = &result.record;
    assert_eq!(record.verdict, Verdict::Fail);
    assert_eq!(record.ended, "step `warm` of the setup never came");
    assert_eq!((came(record, "also"), came(record, "open"), came(record, "close")), (None, None, Some(310)));
    let why = "the setup was never done: step `warm` of the setup never came";
    assert_eq!(claim(record, "quiet"), (Verdict::Inconclusive, why));
    assert_eq!(record.measurements[0].reason, why);
    assert_eq!(claim(record, "warms").0, Verdict::Fail);
    assert_eq!(claim(record, "closes").0, Verdict::Pass);
    // The valve was never open, so that it does not close either.
    assert_eq!(claim(record, "step closed comes within 100 ms of waiting").0, Verdict::Fail);
}

#[test]
fn steps_wait_for_the_setup_however_long_it_takes() {
    let result = run("setup = [
          { id = \"wait\", when = { signal = \"button\", edge = \"rises\", within = \"2 s\" } },
          { id = \"press\", at = \"start + 700 ms\", pulse = { signal = \"button\", width = \"100 ms\" } },
        ]
        steps = [
          { id = \"early\", at = \"start + 900 ms\", mark = {} },
          { id = \"held\", at = \"wait + 10 ms\", mark = {} },
          { id = \"then\", at = \"main + 50 ms\", mark = {} },
          { id = \"later\", when = { signal = \"button\", edge = \"falls\", from = \"start\", within = \"100 ms\" } },
        ]
        ends = \"start + 1 s\"
        expect = [{ rises = { signal = \"button\" } }]");
    let record = &result.record;
    let times: Vec<Option<i64>> = ["early", "held", "then", "later"].map(|id| came(record, id)).to_vec();
    // The pulse ends in the setup, and it is that which main waits for: its falling edge comes too early for `later`.
    assert_eq!(times, [Some(900), Some(800), Some(850), None]);
    assert_eq!(record.verdict, Verdict::Fail);
}

/// A step that waits in vain fails its case; the steps, and those of the teardown, go on without it and what depends on it.
#[test]
fn a_step_that_does_not_come_leaves_out_what_depends_on_it() {
    let waits = |id: &str| {
        format!(
            "{{ id = \"{id}\", when = {{ signal = \"valve\", edge = \"falls\", within = \"100 ms\" }} }}, {{ id = \"then\", at = \"{id} + 10 ms\", mark = {{}} }},"
        )
    };
    for in_teardown in [false, true] {
        let (steps, teardown) =
            if in_teardown { (String::new(), waits("gone")) } else { (waits("gone"), String::new()) };
        let result = run(&format!(
            "steps = [{steps} {{ id = \"other\", at = \"main + 300 ms\", mark = {{}} }}]
            ends = \"main + 1 s\"
            teardown = [{teardown} {{ id = \"last\", at = \"teardown + 300 ms\", mark = {{}} }}]
            expect = [{{ name = \"shut\", stays = {{ signal = \"valve\", is = false }} }}]"
        ));
        let record = &result.record;
        let times = ["gone", "then", "other", "last"].map(|id| came(record, id));
        assert_eq!(times, [None, None, Some(300), Some(1_300)], "in the teardown: {in_teardown}");
        assert_eq!(claim(record, "shut").0, Verdict::Pass);
        assert_eq!(claim(record, "step gone comes within 100 ms of waiting").0, Verdict::Fail);
        assert_eq!((record.verdict, record.ended.as_str()), (Verdict::Fail, ""));
    }
}

#[test]
fn trouble_in_the_setup_keeps_the_steps_from_coming() {
    let result = run(&format!(
        "setup = [
          {{ id = \"again\", at = \"start\", command = \"run\" }},
          {{ id = \"still\", at = \"start + 50 ms\", mark = {{}} }},
        ]{USUAL}expect = [{{ name = \"quiet\", stays = {{ signal = \"valve\", is = false }} }}]"
    ));
    let record = &result.record;
    assert_eq!(record.verdict, Verdict::Error);
    assert!(record.reason.contains("refused"), "{}", record.reason);
    assert_eq!(record.ended, "the rig had trouble in the setup");
    assert_eq!(
        (came(record, "still"), came(record, "open"), came(record, "close")),
        (Some(50), None, Some(60))
    );
    assert_eq!(claim(record, "quiet").0, Verdict::Inconclusive);
}

#[test]
fn a_lost_claim_and_an_interrupt_end_the_steps_and_not_the_teardown() {
    let lost =
        format!("{USUAL}expect = [{{ name = \"shut\", stays = {{ signal = \"valve\", is = false }} }}]");
    let interrupt = AtomicBool::new(false);
    let options = RunOptions { fail_fast: true, ..RunOptions::new(ClockKind::Virtual, &interrupt) };
    let record = &run_with(&lost, "", &options).record;
    assert_eq!((record.verdict, record.ended.as_str()), (Verdict::Fail, "a claim was lost"));
    let close = came(record, "close").unwrap();
    assert!((110..200).contains(&close), "{close}");
    interrupt.store(true, Ordering::Relaxed);
    let plan = format!("{HEAD}{lost}");
    let done = texts(&[("plan.toml", &plan), ("valve.st", VALVE)]).load(3);
    let (loaded, jobs) = done;
    let case = loaded.plan.case(0).unwrap();
    let files = loaded.files(&case, &jobs[0]).unwrap();
    let result = scanrig_runtime::run_case(&case, &files, &options).unwrap();
    assert_eq!(result.record.reason, "interrupted");
    // Before the start there is nothing to tear down.
    assert_eq!((came(&result.record, "open"), came(&result.record, "close")), (None, None));
}

/// Answers as it is asked, and interrupts the run with the last answer if that is asked.
#[derive(Debug)]
struct Reported<'a> {
    answers: Mutex<Vec<Result<usize, AskError>>>,
    asked: Mutex<Vec<String>>,
    interrupt: Option<&'a AtomicBool>,
}

impl Reported<'_> {
    fn new(answers: &[Result<usize, AskError>]) -> Reported<'static> {
        Reported { answers: Mutex::new(answers.to_vec()), asked: Mutex::default(), interrupt: None }
    }
}

impl Operator for Reported<'_> {
    fn ask(&self, step: &str, question: &Question, _: &AtomicBool) -> Result<usize, AskError> {
        let photo = question.photo.clone().unwrap_or_default();
        self.asked.lock().unwrap().push(format!("{step}: {} {photo}", question.text));
        if let Some(interrupt) = self.interrupt {
            interrupt.store(true, Ordering::Relaxed);
        }
        self.answers.lock().unwrap().remove(0)
    }
}

const ASKS: &str = "
steps = [
  { id = \"open\", at = \"start + 100 ms\", pulse = { signal = \"button\", width = \"20 ms\" } },
  { id = \"see\", at = \"open + 500 ms\", ask = { text = \"What colour?\", photo = \"door.png\", answers = [\"green\", \"red\", \"dark\"], pass = \"red\" } },
  { id = \"after\", at = \"see + 100 ms\", mark = {} },
]
expect = [{ rises = { signal = \"valve\", from = \"open\" } }]
teardown = [{ id = \"close\", at = \"teardown\", set = { signal = \"stop\", value = true } }]
";

fn asked(answer: Result<usize, AskError>) -> (JobResult, Vec<String>) {
    let interrupt = AtomicBool::new(false);
    let person = Reported::new(&[answer]);
    let options = RunOptions { operator: Some(&person), ..RunOptions::new(ClockKind::Virtual, &interrupt) };
    let plan = format!("{HEAD}{ASKS}");
    let done = texts(&[("plan.toml", &plan), ("valve.st", VALVE), ("door.png", "picture")]).done(3, &options);
    (done, person.asked.into_inner().unwrap())
}

#[test]
fn an_answer_is_a_claim_that_the_trace_repeats() {
    for (answer, verdict, reason) in [(1, Verdict::Pass, ""), (2, Verdict::Fail, "answered dark")] {
        let (done, questions) = asked(Ok(answer));
        let JobResult::Case(result) = done else { panic!("{done:?}") };
        assert_eq!(questions, ["see: What colour? door.png"]);
        assert_eq!(claim(&result.record, "What colour?"), (verdict, reason));
        assert_eq!(came(&result.record, "after"), Some(700));
        let plan = document::SourceFile::new("plan.toml", format!("{HEAD}{ASKS}"));
        let again = rejudge::judge(&plan, result.trace.as_ref().unwrap()).unwrap();
        assert_eq!(again.claims, result.record.claims);
    }
}

#[test]
fn without_an_answer_the_case_is_an_error_and_torn_down() {
    let (done, _) = asked(Err(AskError::Nobody));
    let JobResult::Case(result) = done else { panic!("{done:?}") };
    assert_eq!(result.record.verdict, Verdict::Error);
    assert!(result.record.reason.contains("step `see` asked and got no answer"), "{}", result.record.reason);
    assert_eq!(
        claim(&result.record, "What colour?"),
        (Verdict::Inconclusive, "`answer:see` was never observed")
    );
    assert_eq!(came(&result.record, "close"), Some(600));
}

#[test]
fn where_nobody_can_be_asked_nothing_moves() {
    let interrupt = AtomicBool::new(false);
    let options = RunOptions::new(ClockKind::Virtual, &interrupt);
    let plan = format!("{HEAD}{ASKS}");
    let files = [("plan.toml", plan.as_str()), ("valve.st", VALVE), ("door.png", "picture")];
    let JobResult::Findings(found) = texts(&files).done(3, &options) else { panic!() };
    assert_eq!((found[0].code, found[0].labels[0].file.as_str()), ("R0140", "plan.toml"));
    let mut sources = Vec::new();
    let found =
        scanrig_runtime::suite::load_plan(&texts(&files[..2]), "plan.toml", None, &[], 1, &mut sources);
    assert_eq!(found.err().unwrap()[0].code, "R0141");
}

#[test]
fn an_interrupt_leaves_the_teardown_to_come() {
    let interrupt = AtomicBool::new(false);
    let person = Reported { interrupt: Some(&interrupt), ..Reported::new(&[Ok(1)]) };
    let options = RunOptions { operator: Some(&person), ..RunOptions::new(ClockKind::Virtual, &interrupt) };
    let plan = format!("{HEAD}{ASKS}");
    let (loaded, jobs) = texts(&[("plan.toml", &plan), ("valve.st", VALVE), ("door.png", "picture")]).load(3);
    let case = loaded.plan.case(0).unwrap();
    let files = loaded.files(&case, &jobs[0]).unwrap();
    let result = scanrig_runtime::run_case(&case, &files, &options).unwrap();
    assert_eq!(result.record.reason, "interrupted");
    assert_eq!((came(&result.record, "after"), came(&result.record, "close")), (None, Some(600)));
}

#[test]
fn trouble_of_the_board_does_not_keep_the_teardown_from_coming() {
    let interrupt = AtomicBool::new(false);
    let options = RunOptions::new(ClockKind::Virtual, &interrupt);
    let plan = "
        steps = [{ id = \"tap\", at = \"start + 10 ms\", every = { period = \"10 ms\", times = 50 }, pulse = { signal = \"button\", width = \"5 ms\" } }]
        expect = [{ rises = { signal = \"button\" } }]
        teardown = [
          { id = \"off\", at = \"teardown + 10 ms\", every = { period = \"10 ms\", times = 50 }, pulse = { signal = \"stop\", width = \"5 ms\" } },
          { id = \"last\", at = \"off.done + 10 ms\", mark = {} },
        ]";
    let result = run_with(plan, "[faults]\nfailed-calls = { chance = 0.05 }", &options);
    let record = &result.record;
    assert_eq!(record.verdict, Verdict::Error);
    let (end, last) = ((record.end_ns - record.start_ns) / 1_000_000, came(record, "last").unwrap());
    assert!(end < 500, "{end}");
    assert_eq!(last - end, 515);
}

#[test]
fn times_that_touch_each_other_are_done_once() {
    let result = run("
        steps = [
          { id = \"twice\", at = \"start\", run = { group = \"waves\" } },
          { id = \"behind\", at = \"twice.done\", mark = {} },
        ]
        ends = \"start + 1 s\"
        expect = [{ name = \"whole\", edges = { signal = \"button\", rising = 30, falling = 30 } }]
        [group.waves]
        steps = [{ id = \"train\", at = \"begin\", every = { period = \"100 ms\", times = 3 }, train = { signal = \"button\", period = \"10 ms\", count = 10 } }]");
    assert_eq!(claim(&result.record, "whole"), (Verdict::Pass, ""));
    assert!((295..=300).contains(&came(&result.record, "behind").unwrap()));
}

/// The button is pressed shortly before the end, and a board that reports late knows of it only after the end.
#[test]
fn a_change_that_is_reported_after_the_end_leaves_open_whether_it_came_before() {
    let interrupt = AtomicBool::new(false);
    let options = RunOptions::new(ClockKind::Virtual, &interrupt);
    let plan = |ends: &str, teardown: &str| {
        format!(
            "title = \"Late\"\nsteps = [{{ id = \"open\", at = \"main + 100 ms\", set = {{ signal = \"button\", value = true }} }}]
            ends = \"main + {ends}\"\n{teardown}\nexpect = [
            {{ name = \"none\", edges = {{ signal = \"button\", rising = 0 }} }},
            {{ name = \"shut\", stays = {{ signal = \"button\", is = false }} }},
            {{ name = \"value\", value = {{ of = \"button\", is = false, when = \"end\" }} }},
            {{ name = \"before\", stays = {{ signal = \"button\", is = false, until = \"open\" }} }},
            ]\n"
        )
    };
    let teardown = "teardown = [{ id = \"rest\", at = \"teardown + 500 ms\", mark = {} }]";
    let board = "[faults]\nlate = { chance = 1, by = \"400 ms\" }";
    for teardown in ["", teardown] {
        let record = &run_with(&plan("130 ms", teardown), board, &options).record;
        for name in ["none", "shut", "value"] {
            assert_eq!(claim(record, name).0, Verdict::Inconclusive, "{name}: {}", claim(record, name).1);
        }
        assert_eq!(claim(record, "before").0, Verdict::Pass);
        // Once it is known that it came before the end, it did.
        let record = &run_with(&plan("2 s", teardown), board, &options).record;
        for name in ["none", "shut", "value"] {
            assert_eq!(claim(record, name).0, Verdict::Fail, "{name}");
        }
        // A board that reports at once leaves nothing open.
        let record = &run_with(&plan("130 ms", teardown), "", &options).record;
        for name in ["none", "shut", "value"] {
            assert_eq!(claim(record, name).0, Verdict::Fail, "{name}");
        }
    }
}

/// `within` includes its limit for a step that waits, as it does for a claim.
#[test]
fn what_comes_at_the_limit_of_a_wait_comes_in_time() {
    let interrupt = AtomicBool::new(false);
    let options = RunOptions::new(ClockKind::Virtual, &interrupt);
    for (within, came_in_time) in [("100 ms", true), ("99.999999 ms", false)] {
        let plan = format!(
            "title = \"At the limit\"\nsteps = [
            {{ id = \"open\", at = \"main + 100 ms\", set = {{ signal = \"button\", value = true }} }},
            {{ id = \"seen\", when = {{ signal = \"button\", edge = \"rises\", from = \"main\", within = \"{within}\" }} }},
            ]\nends = \"main + 1 s\"\n
            expect = [{{ name = \"claim\", rises = {{ signal = \"button\", from = \"main\", within = \"{within}\" }} }}]\n"
        );
        let record = &run_with(&plan, "", &options).record;
        assert_eq!(came(record, "seen").is_some(), came_in_time, "{within}");
        let expected = if came_in_time { Verdict::Pass } else { Verdict::Fail };
        assert_eq!(claim(record, "claim").0, expected, "{within}");
        assert_eq!(record.verdict, expected, "{within}: {}", record.reason);
    }
}

/// What is lost early is said in the words of the whole case; what was not finished is not judged.
#[test]
fn a_case_that_ends_at_a_lost_claim_has_the_verdict_of_the_whole_case() {
    let interrupt = AtomicBool::new(false);
    let whole = RunOptions::new(ClockKind::Virtual, &interrupt);
    let fast = RunOptions { fail_fast: true, ..RunOptions::new(ClockKind::Virtual, &interrupt) };
    let plan = format!(
        "{USUAL}expect = [
        {{ name = \"shut\", stays = {{ signal = \"valve\", is = false, from = \"open\", until = \"open + 50 ms\" }} }},
        {{ name = \"falls\", falls = {{ signal = \"button\", from = \"open\" }} }},
        {{ name = \"begun\", rises = {{ signal = \"button\", from = \"main\" }} }},
        {{ name = \"later\", edges = {{ signal = \"stop\", rising = 0, from = \"main + 500 ms\" }} }},
        ]
        measure = [{{ name = \"open\", value-of = \"valve\", take = \"mean\", from = \"main\", max = 1 }}]\n"
    );
    let all = &run_with(&plan, "", &whole).record;
    let early = &run_with(&plan, "", &fast).record;
    assert_eq!((all.verdict, early.verdict), (Verdict::Fail, Verdict::Fail));
    assert_eq!(early.ended, "a claim was lost");
    assert_eq!(claim(all, "shut"), claim(early, "shut"));
    assert_eq!(all.reason, early.reason);
    assert_eq!(claim(early, "begun").0, Verdict::Pass);
    let not_judged = (Verdict::Inconclusive, "not judged: the case was ended when another claim was lost");
    assert_eq!(claim(early, "later"), not_judged);
    assert_eq!((early.measurements[0].verdict, early.measurements[0].reason.as_str()), not_judged);
}
