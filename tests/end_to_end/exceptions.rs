//! A controller that leaves RUNNING by an exception: the case fails, unless its plan speaks of the state.

use crate::project_folder::{CommandOutput, TestProject};

/// Divides by zero in its first cycle, before it drives anything.
const DIVIDES: &str = "\
PROGRAM MAIN
VAR
    a : INT;
    b : INT := 5;
    f AT %QX0.0 : BOOL;
    r AT %QX0.1 : BOOL;
END_VAR
b := b / a;
f := TRUE;
END_PROGRAM
";

/// What such a program does to a claim that something never happens.
const NEVER: &str = r#"{ never = { all = ["f", "r"], from = "start", until = "end" } }"#;

const DIVISION: &str = "the controller went into HALT by itself, 180 ns after the start: \
                        application error 0102 hex in MAST at divides.st:8";

fn plan(rest: &str, claims: &[&str]) -> String {
    let claims = claims.join(", ");
    format!("format = 1\ntitle = \"Never both\"\nends = \"start + 4 s\"\n{rest}\nexpect = [{claims}]\n")
}

fn division(claims: &[&str]) -> String {
    plan("program = \"divides.st\"\nsignals = { f = \"%QX0.0\", r = \"%QX0.1\" }\nsteps = []", claims)
}

fn project() -> TestProject {
    let bench = TestProject::new();
    bench.write("divides.st", DIVIDES);
    bench
}

/// The first line below the name of a case.
fn first_line(ran: &CommandOutput) -> &str {
    ran.out.lines().skip_while(|line| !line.starts_with(['✗', '!', '?'])).nth(1).unwrap_or_default()
}

/// Runs a plan, and judges its trace again: both come to the same, and name the same first.
fn run_and_judge(bench: &TestProject, name: &str, plan: &str, code: i32, why: &str) {
    let file = format!("{name}.toml");
    bench.write(&file, plan);
    let ran = bench.expect(code, &["test", &file, "--report", name]);
    let trace = format!("{name}/traces/{name}.trace");
    let judged = bench.expect(code, &["judge", &file, &trace]);
    for ran in [ran, judged] {
        let line = if why.is_empty() { String::new() } else { format!("  why  {why}") };
        assert_eq!(first_line(&ran), line, "{}", ran.out);
    }
}

#[test]
fn a_division_by_zero_fails_what_holds_for_a_controller_that_does_nothing() {
    let bench = project();
    run_and_judge(&bench, "alone", &division(&[NEVER]), 1, DIVISION);
    // Before the claims that the program broke for it.
    let rises = r#"{ rises = { signal = "f", from = "start", within = "100 ms" } }"#;
    run_and_judge(&bench, "both", &division(&[NEVER, rises]), 1, DIVISION);
    for folder in ["alone", "both"] {
        let junit = bench.read(&format!("{folder}/junit.xml"));
        assert!(junit.contains(&format!("<failure type=\"fail\" message=\"{DIVISION}\">")), "{junit}");
        let summary = bench.read(&format!("{folder}/summary.md"));
        let title = summary.split_once("`Never both`").unwrap().1;
        assert!(title.starts_with(&format!("\n\n`{DIVISION}`\n")), "{summary}");
        assert_eq!(summary.contains("did not rise"), folder == "both", "{summary}");
        // What a browser without scripts shows.
        let page = bench.read(&format!("{folder}/index.html"));
        let title = page.split_once("<p>Never both</p>").unwrap().1;
        assert!(title.starts_with(&format!("<p class=\"why\">{DIVISION}</p>")), "{folder}");
        let case = &bench.json(&format!("{folder}/record.json"))["cases"][0];
        assert_eq!((&case["reason"], &case["exception"]), (&DIVISION.into(), &DIVISION.into()));
    }
}

#[test]
fn a_plan_that_claims_halt_passes() {
    let bench = project();
    for (name, claim) in [
        ("enters", r#"{ state = { becomes = "HALT", from = "start", within = "1 ms" } }"#),
        ("is", r#"{ state = { is = "HALT", when = "end" } }"#),
        ("runs-not", r#"{ never = { signal = "state", is = "RUNNING", from = "start + 1 ms" } }"#),
    ] {
        run_and_judge(&bench, name, &division(&[NEVER, claim]), 0, "");
        assert!(bench.json(&format!("{name}/record.json"))["cases"][0].get("exception").is_none());
    }
    let waits = division(&[NEVER]).replace(
        "steps = []",
        r#"steps = [{ id = "halt", when = { signal = "state", becomes = "HALT", within = "1 s" } }]"#,
    );
    run_and_judge(&bench, "waits", &waits, 0, "");
    // That it runs, or is not in HALT, is no claim of HALT.
    for (name, claim) in [
        ("stopped", r#"{ never = { signal = "state", is = "STOPPED" } }"#),
        ("halts-not", r#"{ never = { signal = "state", is = "HALT" } }"#),
    ] {
        run_and_judge(&bench, name, &division(&[NEVER, claim]), 1, DIVISION);
    }
}

/// A claim of the state that says nothing of an exception.
const RUNS: &str = r#"{ state = { stays = "RUNNING", from = "start", until = "long" } }"#;

/// A watchdog trips in a cycle that is too long, or the system's does where the task has none.
fn overlong(watched: bool, cycle: &str, claims: &[&str]) -> String {
    let rest = format!(
        "program = \"lamp.st\"\nsettings = {{ mast = {{ enabled = {watched} }} }}\nsteps = [\
         {{ id = \"long\", at = \"start + 1.005 s\", overload = {{ task = \"MAST\", cycle = \"{cycle}\" }} }}]"
    );
    plan(&rest, claims)
}

#[test]
fn a_watchdog_that_trips_fails_the_case() {
    let bench = project();
    let why = "the controller went into HALT by itself, 1.12 s after the start: the task watchdog of MAST stopped the application";
    run_and_judge(&bench, "trips", &overlong(true, "150 ms", &[RUNS]), 1, why);
    let halt = r#"{ state = { becomes = "HALT", from = "long", within = "115 ms .. 115 ms" } }"#;
    run_and_judge(&bench, "claimed", &overlong(true, "150 ms", &[halt]), 0, "");
    run_and_judge(&bench, "shorter", &overlong(true, "90 ms", &[RUNS]), 0, "");
}

#[test]
fn a_system_error_is_no_halt() {
    let bench = project();
    let why = "the controller went into EMPTY by itself, 2.02 s after the start: \
               system watchdog: the tasks of priority 0 to 24 took the whole processor";
    // A claim of HALT that holds in no run of it: the exception is still what is said first.
    let halt = r#"{ state = { is = "HALT", when = "end" } }"#;
    run_and_judge(&bench, "halt", &overlong(false, "1.2 s", &[halt]), 1, why);
    let empty = r#"{ state = { is = "EMPTY", when = "end" } }"#;
    run_and_judge(&bench, "empty", &overlong(false, "1.2 s", &[empty]), 0, "");
}

/// A step that is the error asks for the stop as a command does; an error of the program beside it is still an exception.
#[test]
fn an_internal_error_is_asked_for() {
    let bench = project();
    for kind in ["firmware", "hardware-watchdog", "firmware-exception"] {
        let step =
            format!("steps = [{{ id = \"wrong\", at = \"start + 1 s\", internal-error = \"{kind}\" }}]");
        let rest = format!("program = \"lamp.st\"\nsignals = {{ f = \"%QX0.0\", r = \"%QX0.1\" }}\n{step}");
        run_and_judge(&bench, kind, &plan(&rest, &[NEVER]), 0, "");
        run_and_judge(
            &bench,
            &format!("{kind}-and"),
            &division(&[NEVER]).replace("steps = []", &step),
            1,
            DIVISION,
        );
    }
}
