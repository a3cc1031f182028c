//! What the files of a case mean together: names and terminals, and what a plan needs of the rig.

use crate::texts::Texts;
use record::Verdict;
use scanrig_runtime::case::jobs::JobResult;
use scanrig_runtime::{ClockKind, RunOptions};
use signal::Span;
use std::sync::atomic::AtomicBool;

/// An output that toggles in every cycle, and an array.
const TOGGLE: &str = "PROGRAM MAIN
VAR
    lamp AT %QX0.4 : BOOL;
    a : ARRAY [1..3] OF INT;
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
    format!("format = 1\ntitle = \"RigFault\"\n[board]\nkind = \"simulated\"\n{rest}\n")
}

/// A line behind two inputs feeds both of them.
#[test]
fn one_channel_may_feed_two_inputs() {
    let plan = "format = 1\ntitle = \"One line, two inputs\"\nprogram = \"two.st\"\nboard = \"board.toml\"
        signals = { in = \"%IX0.3\", q0 = \"%QX0.4\", q1 = \"%QX0.5\" }
        steps = [
          { id = \"on\", at = \"start + 0.5 s\", set = { signal = \"in\", value = true } },
          { id = \"force\", at = \"start + 1 s\", force = { signal = \"second\", value = false } },
        ]
        ends = \"start + 1.5 s\"
        expect = [
          { rises = { signal = \"q0\", from = \"on\", within = \"60 ms\" } },
          { rises = { signal = \"q1\", from = \"on\", within = \"60 ms\" } },
          { value = { of = \"q0\", is = true, when = \"end\" } },
          { value = { of = \"q1\", is = false, when = \"end\" } },
        ]\n";
    // A signal is the terminal that it names, although both terminals have one line.
    let plan = plan.replace("in = \"%IX0.3\",", "in = \"%IX0.3\", second = \"%IX0.4\",");
    let program = "PROGRAM MAIN\nVAR\n a AT %IX0.3 : BOOL;\n b AT %IX0.4 : BOOL;\n p AT %QX0.4 : BOOL;\n q AT %QX0.5 : BOOL;\nEND_VAR\np := a;\nq := b;\nEND_PROGRAM\n";
    let board = board("[bind]\n\"%IX0.3\" = \"I3\"\n\"%IX0.4\" = \"I3\"");
    let interrupt = AtomicBool::new(false);
    let options = RunOptions::new(ClockKind::Virtual, &interrupt);
    let texts = [("plan.toml", plan.as_str()), ("two.st", program), ("board.toml", board.as_str())];
    crate::texts::expect(&Texts(&texts).run(1, &options), Verdict::Pass);
}

#[test]
fn findings_say_what_to_write_instead() {
    let interrupt = AtomicBool::new(false);
    let options = RunOptions::new(ClockKind::Virtual, &interrupt);
    let board = board("");
    let write = "steps = [{ id = \"w\", at = \"start\", write = { of = \"lamp\", value = true } }]";
    let image = "steps = [{ id = \"w\", at = \"start\", write = { of = \"%IX0.0\", value = true } }]";
    let array = "measure = []";
    for (rest, signal, code, help) in [
        (write, "", "R0106", "`force`"),
        (image, "", "R0106", "the process image is { image = "),
        (array, ", whole = \"MAIN.a\"", "R0104", "`MAIN.a[1]`"),
        (array, ", beyond = \"MAIN.a[9]\"", "R0104", "`MAIN.a[1]`"),
        (array, ", no = { address = \"%QX0.5\", deadband = 1 }", "R0115", "remove `deadband`"),
        (
            array,
            ", no = { task = \"MAST\", figure = \"cycles\", deadband = \"5 V\" }",
            "R0115",
            "without a unit",
        ),
    ] {
        let plan = plan(rest).replace("lamp = \"%QX0.4\" }", &format!("lamp = \"%QX0.4\"{signal} }}"));
        let texts = [("plan.toml", plan.as_str()), ("toggle.st", TOGGLE), ("board.toml", board.as_str())];
        let JobResult::Findings(found) = Texts(&texts).done(1, &options) else {
            panic!("{code}: nothing found")
        };
        let said = format!("{found:?}");
        assert!(said.contains(code) && said.contains(help), "{said}");
    }
}

/// A step 3 us before a cycle that comes up to 50 us late misses it: no fault of the controller.
#[test]
fn a_plan_that_needs_exact_instants_is_inconclusive_on_a_late_rig() {
    let plan = |needs: &str| {
        format!(
            "format = 1\ntitle = \"Just before a cycle\"\nprogram = \"follow.st\"\n{needs}\nsettings = {{ filter = \"0 ms\" }}
            signals = {{ in = \"%IX0.0\", out = \"%QX0.0\" }}
            steps = [{{ id = \"go\", at = \"start + 1 s - 3 us\", set = {{ signal = \"in\", value = true }} }}]
            expect = [{{ rises = {{ signal = \"out\", from = \"go\", within = \"0 s .. 10 us\" }} }}]"
        )
    };
    let program =
        "PROGRAM MAIN\nVAR\n i AT %IX0.0 : BOOL;\n q AT %QX0.0 : BOOL;\nEND_VAR\nq := i;\nEND_PROGRAM\n";
    let interrupt = AtomicBool::new(false);
    let exact = RunOptions::new(ClockKind::Virtual, &interrupt);
    let late = RunOptions::new(ClockKind::Late(Span::from_micros(50)), &interrupt);
    let run =
        |needs: &str, options| Texts(&[("plan.toml", &plan(needs)), ("follow.st", program)]).run(3, options);
    let needs = "needs = [\"timestamp <= 1 us\"]";
    crate::texts::expect(&run(needs, &exact), Verdict::Pass);
    crate::texts::expect(&run("", &late), Verdict::Inconclusive);
    let result = run(needs, &late);
    crate::texts::expect(&result, Verdict::Inconclusive);
    assert!(result.record.reason.contains("the plan needs edges to within 1 us"), "{}", result.record.reason);
}

/// The plan's reference goes before the board's: what the board binds has to be there.
#[test]
fn a_port_that_the_plans_reference_lacks_is_a_finding() {
    let interrupt = AtomicBool::new(false);
    let options = RunOptions::new(ClockKind::Virtual, &interrupt);
    let board = board("[buses]\ncan = { kind = \"can\" }\n[ports]\ncan_1 = \"can\"");
    let run = |rest: &str| {
        let plan = plan(rest);
        let texts = [("plan.toml", plan.as_str()), ("toggle.st", TOGGLE), ("board.toml", board.as_str())];
        Texts(&texts).done(1, &options)
    };
    assert!(!matches!(run("settings = { reference = \"TM241CEC24R\" }"), JobResult::Findings(_)));
    let JobResult::Findings(found) = run("settings = { reference = \"TM241CE24T\" }") else {
        panic!("it has no CAN port");
    };
    assert_eq!(
        (found[0].code, found[0].help.as_str()),
        ("R0271", "it has SL1, SL2, Ethernet_1, USB; or leave `reference` to the board")
    );
}
