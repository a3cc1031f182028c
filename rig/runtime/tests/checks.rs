//! What a bench reports of a plan before anything moves, each with the plan that has nothing wrong beside it.

use crate::texts::Texts;
use scanrig_runtime::case::check_case;

const PROGRAM: &str = "PROGRAM MAIN
VAR
    lamp AT %QX0.4 : BOOL;
    button AT %IX0.0 : BOOL;
    small : USINT;
    minus : INT;
    back : TIME;
END_VAR
lamp := button;
small := small + 1;
minus := -5;
END_PROGRAM";

const BOARD: &str = "format = 1
title = \"A bench\"
[board]
kind = \"simulated\"
[channels]
level = { kind = \"analog\", unit = \"bar\" }
free = { kind = \"analog\", unit = \"bar\" }
hidden = { kind = \"digital\", senses = false }
[[wires]]
from = \"Q4\"
to = \"I1\"
delay = \"3 ms\"
[[plants]]
kind = \"lag\"
name = \"tank\"
input = \"Q4\"
output = \"level\"
low = 0
high = 6
tau = \"1 s\"
sample = \"10 ms\"
switches = [{ channel = \"I5\", on-above = 4, off-below = 3 }]
";

/// The codes of what the check finds in a plan with this, each with what stands at its place.
fn found(text: &str) -> Vec<String> {
    let plan =
        format!("format = 1\ntitle = \"A plan\"\nprogram = \"a.st\"\nboard = \"board.toml\"\n{text}\n");
    let (loaded, jobs) = Texts(&[("plan.toml", &plan), ("a.st", PROGRAM), ("board.toml", BOARD)]).load(1);
    let case = loaded.plan.case(0).unwrap();
    let files = loaded.files(&case, &jobs[0]).unwrap();
    let (Ok(found) | Err(found)) = check_case(&case, &files);
    found.iter().map(|one| format!("{} {}", one.code, one.message)).collect()
}

/// What the check finds of one claim, with `press` as a step that drives `%IX0.0`.
fn of_claim(claim: &str) -> Vec<String> {
    let step =
        "steps = [{ id = \"press\", at = \"start + 1 s\", set = { signal = \"%IX0.0\", value = true } }]";
    let binds = "fine = { path = \"level\", record = true }, coarse = { path = \"level\", deadband = 1 }, word = { address = \"%MW100\", deadband = 10 }";
    found(&format!(
        "needs = [\"memory-access\"]\nsignals = {{ {binds}, halts = {{ log = \"HALT\" }} }}\n{step}\nexpect = [{claim}]"
    ))
}

#[test]
fn values_that_a_step_cannot_write_are_errors() {
    for (of, value, code) in [
        ("small", "255", ""),
        ("small", "256", "R0107"),
        ("small", "-1", "R0107"),
        ("minus", "-32768", ""),
        ("minus", "32768", "R0107"),
        ("MAIN.minus", "-32769", "R0107"),
    ] {
        let text = format!(
            "needs = [\"memory-access\"]\nsteps = [{{ id = \"put\", at = \"start + 1 s\", write = {{ of = \"{of}\", value = {value} }} }}]\n\
             expect = [{{ value = {{ of = \"small\", is = 5 }} }}]"
        );
        let found = found(&text);
        assert_eq!(found.first().map_or("", |one| &one[..5]), code, "{of} {value}: {found:?}");
    }
}

#[test]
fn values_that_a_signal_cannot_have_are_errors() {
    for (claim, code) in [
        ("{ value = { of = \"small\", is = 256 } }", "R0145"),
        ("{ value = { of = \"small\", is = 255 } }", ""),
        ("{ value = { of = \"minus\", min = -32769, max = 40000 } }", "R0145"),
        ("{ value = { of = \"minus\", min = -32768, max = 40000 } }", "R0145"),
        ("{ value = { of = \"minus\", min = -32767, max = 40000 } }", ""),
        ("{ stays = { signal = \"%MW3\", min = 0 } }", "R0145"),
        ("{ stays = { signal = \"%MW3\", min = 0, max = 65534 } }", ""),
        ("{ never = { signal = \"%MB3\", min = 300 } }", "R0145"),
        ("{ stays = { signal = \"halts\", min = 0 } }", "R0145"),
        ("{ stays = { signal = \"halts\", is = 0 } }", ""),
        ("{ becomes = { signal = \"lamp\", is = 2 } }", "R0145"),
        ("{ never = { signal = \"lamp\", is = 2 } }", "R0145"),
        // A line can be driven by nobody, so it need not be TRUE or FALSE; a variable is nothing else.
        ("{ stays = { signal = \"%QX0.4\", one-of = [true, false] } }", ""),
        ("{ stays = { signal = \"%MX3.0\", one-of = [true, false] } }", "R0145"),
        ("{ becomes = { signal = \"%MX3.0\", one-of = [true, false] } }", "R0145"),
        ("{ value = { of = \"PLC_R.i_wStatus\", is = 70000 } }", "R0145"),
        // What a TIME holds is reported in nanoseconds.
        ("{ value = { of = \"back\", max = \"1 d\" } }", ""),
    ] {
        let codes = of_claim(claim);
        let wanted: Vec<&str> = if code.is_empty() { Vec::new() } else { vec![code] };
        let seen: Vec<&str> = codes.iter().map(|one| &one[..5]).collect();
        assert_eq!(seen, wanted, "{claim}: {codes:?}");
    }
    let why = of_claim("{ value = { of = \"small\", is = 256 } }");
    assert_eq!(why, ["R0145 the claim can never be met: `small` is 0 .. 255 and never 256"]);
}

#[test]
fn one_thing_under_two_names_is_not_compared_with_itself() {
    let with = |claim: &str| {
        let binds = "a = \"%QX0.4\", b = \"Q4\", c = \"%IX0.0\", n = \"small\", m = \"MAIN.small\", fine = \"small\", coarse = { path = \"small\", deadband = 5 }";
        let plan = format!(
            "signals = {{ {binds} }}\nsteps = [{{ id = \"press\", at = \"start + 1 s\", set = {{ signal = \"c\", value = true }} }}]\nexpect = [{claim}]"
        );
        found(&plan).iter().filter(|one| one.starts_with("R0145")).cloned().collect::<Vec<String>>()
    };
    for claim in [
        "{ follows = { signal = \"a\", leader = \"b\" } }",
        "{ equal = { left = \"a\", right = \"b\" } }",
        "{ equal = { left = \"n\", right = \"m\" } }",
        "{ phase = { of = \"a\", reference = \"b\", is = \"0 deg .. 1 deg\" } }",
        "{ position = { signal = \"a\", quadrature = \"b\", is = 1 } }",
    ] {
        assert_eq!(with(claim).len(), 1, "{claim}: {:?}", found(claim));
    }
    for claim in [
        "{ follows = { signal = \"a\", leader = \"c\" } }",
        "{ equal = { left = \"n @ press\", right = \"m\" } }",
        // What is recorded coarsely may differ from what is recorded finely.
        "{ follows = { signal = \"fine\", leader = \"coarse\", tolerance = 9 } }",
    ] {
        assert!(with(claim).is_empty(), "{claim}: {:?}", with(claim));
    }
    assert_eq!(
        with("{ follows = { signal = \"a\", leader = \"b\" } }"),
        ["R0145 `a` and `b` are one signal under two names: the claim compares it with itself"]
    );
}

#[test]
fn a_run_is_refused_as_well() {
    let plan = "format = 1\ntitle = \"A plan\"\nprogram = \"a.st\"\nneeds = [\"memory-access\"]\nexpect = [{ value = { of = \"small\", is = 256 } }]\n";
    let interrupt = std::sync::atomic::AtomicBool::new(false);
    let options = scanrig_runtime::RunOptions::new(scanrig_runtime::ClockKind::Virtual, &interrupt);
    match Texts(&[("plan.toml", plan), ("a.st", PROGRAM)]).done(1, &options) {
        scanrig_runtime::case::jobs::JobResult::Findings(found) => assert_eq!(found[0].code, "R0145"),
        other => panic!("{other:#?}"),
    }
}

#[test]
fn a_line_that_nothing_moves_is_reported() {
    for (claim, code) in [
        ("{ rises = { signal = \"%IX0.0\", from = \"press\" } }", ""),
        ("{ rises = { signal = \"%IX0.2\", from = \"press\" } }", "R0146"),
        ("{ falls = { signal = \"%IX0.1\", from = \"press\" } }", ""),
        ("{ changes = { signal = \"%IX0.5\", from = \"press\" } }", ""),
        ("{ edges = { signal = \"%IX0.3\", rising = \"1 ..\" } }", "R0146"),
        ("{ edges = { signal = \"%IX0.3\", rising = 0 } }", ""),
        ("{ becomes = { signal = \"free\", min = 3 } }", "R0146"),
        ("{ becomes = { signal = \"fine\", min = 3 } }", ""),
        ("{ order = { edges = [\"%IX0.0 rises\", \"%IX0.2 rises\"] } }", "R0146"),
        ("{ never = { signal = \"hidden\" } }", "R0146"),
    ] {
        let codes: Vec<String> = of_claim(claim).iter().map(|one| one[..5].to_owned()).collect();
        let wanted: Vec<&str> = if code.is_empty() { Vec::new() } else { vec![code] };
        assert_eq!(codes, wanted, "{claim}");
    }
    let waits = "steps = [{ id = \"lit\", when = { signal = \"%IX0.2\", edge = \"rises\", within = \"1 s\" } }]\nexpect = [{ state = { stays = \"RUNNING\" } }]";
    assert_eq!(found(waits), ["R0146 the step `lit` waits for `I2`, which nothing moves"]);
    let fault = "steps = [{ id = \"stuck\", at = \"start + 1 s\", fault = { signal = \"%IX0.2\", kind = \"stuck\", value = true } }]\nexpect = [{ rises = { signal = \"%IX0.2\" } }]";
    assert!(found(fault).is_empty());
}

#[test]
fn limits_that_the_instrument_cannot_report_are_reported() {
    for (claim, code) in [
        ("{ value = { of = \"coarse\", near = 3, tolerance = 0.5 } }", "R0148"),
        ("{ value = { of = \"coarse\", near = 3, tolerance = 1 } }", ""),
        ("{ value = { of = \"coarse\", is = 3 } }", "R0148"),
        ("{ stays = { signal = \"coarse\", max = 6 } }", ""),
        ("{ never = { signal = \"coarse\", is = 3 } }", ""),
        ("{ rises = { signal = \"coarse\" } }", "R0148"),
        ("{ value = { of = \"word\", near = 50, tolerance = 5 } }", "R0148"),
        ("{ becomes = { signal = \"coarse\", min = 3 } }", ""),
    ] {
        let codes: Vec<String> = of_claim(claim).iter().map(|one| one[..5].to_owned()).collect();
        let wanted: Vec<&str> = if code.is_empty() { Vec::new() } else { vec![code] };
        assert_eq!(codes, wanted, "{claim}");
    }
}

#[test]
fn a_need_that_no_board_meets_is_reported() {
    let plan = |need: &str| {
        found(&format!("needs = [\"{need}\"]\nexpect = [{{ state = {{ stays = \"RUNNING\" }} }}]"))
    };
    assert!(plan("pulse >= 500 MHz").is_empty());
    assert_eq!(
        plan("pulse >= 2 GHz"),
        [
            "R0147 the case gets no verdict here: the board emits pulses up to 500000000 Hz, the plan needs more"
        ]
    );
}

#[test]
fn a_plan_that_runs_nowhere_is_reported() {
    let plan = "profiles = [\"m251-2024\"]\nexpect = [{ state = { stays = \"RUNNING\" } }]";
    let found = found(plan);
    assert_eq!(
        found,
        ["R0149 no case of the plan ever runs: it holds for m251-2024, and its board is of m241-2019"]
    );
}

#[test]
fn a_reference_of_another_profile_is_reported() {
    let plan = |reference: &str| {
        let setting = format!("settings = {{ reference = \"{reference}\" }}");
        found(&format!("{setting}\nexpect = [{{ state = {{ stays = \"RUNNING\" }} }}]"))
    };
    assert!(plan("TM241C40R").is_empty());
    assert_eq!(
        plan("TM251MESE"),
        ["R0149 the case never runs: its reference TM251MESE is of m251-2024, and its board of m241-2019"]
    );
}
