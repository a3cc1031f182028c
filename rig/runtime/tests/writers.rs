//! Who made a change: what a failed claim names as the last writer.

use crate::texts::Texts;
use scanrig_runtime::{CaseResult, ClockKind, RunOptions};
use signal::Cause;
use std::sync::atomic::AtomicBool;

fn run(plan: &str, program: &str) -> Box<CaseResult> {
    let interrupt = AtomicBool::new(false);
    let options = RunOptions::new(ClockKind::Virtual, &interrupt);
    Texts(&[("plan.toml", plan), ("two.st", program)]).run(1, &options)
}

/// Task and line of each change of a signal by a program.
fn writers(result: &CaseResult, signal: &str) -> Vec<(u8, u32)> {
    let trace = result.trace.as_ref().unwrap();
    let signal = trace.find(signal).unwrap();
    let changes = crate::common::events(trace).into_iter().filter(|event| event.signal == signal);
    let by_program = changes.filter_map(|event| match event.cause {
        Cause::Program { task, line, .. } => Some((task, line)),
        _ => None,
    });
    by_program.collect()
}

/// A variable is no output: the line that changes it is known all the same, also after another task stored an output.
#[test]
fn a_variable_names_the_task_and_the_line_that_changed_it() {
    let program = "PROGRAM MAIN
VAR
    n : UINT;
    half : BOOL;
END_VAR
n := n + 1;
half := n >= 3;
END_PROGRAM
PROGRAM OTHER
VAR
    lamp AT %QX0.0 : BOOL;
END_VAR
lamp := NOT lamp;
END_PROGRAM
";
    let plan = "format = 1
title = \"Two tasks\"
program = \"two.st\"
settings = { mast = { interval = \"20 ms\" }, tasks = { FAST = { interval = \"5 ms\", priority = 3, programs = [\"OTHER\"] } } }
signals = { half = \"MAIN.half\", n = \"MAIN.n\" }
ends = \"start + 90 ms\"
expect = [{ value = { of = \"half\", is = true } }]
";
    let result = run(plan, program);
    assert_eq!(writers(&result, "half"), [(0, 7)]);
    assert_eq!(writers(&result, "n"), [(0, 6); 5]);
}

/// `programs = []` is a task that runs nothing, and not one that runs what is left, as MAST does.
#[test]
fn a_task_with_an_empty_list_runs_no_program() {
    let program = "PROGRAM MAIN
VAR n : UINT; END_VAR
n := n + 1;
END_PROGRAM
";
    let plan = "format = 1
title = \"A task without programs\"
program = \"two.st\"
settings = { mast = { interval = \"20 ms\" }, tasks = { IDLE = { interval = \"5 ms\", priority = 3, programs = [] } } }
signals = { n = \"MAIN.n\" }
ends = \"start + 90 ms\"
expect = [{ value = { of = \"n\", is = 5 } }]
";
    let result = run(plan, program);
    assert_eq!(result.record.verdict, record::Verdict::Pass, "{}", result.record.reason);
}
