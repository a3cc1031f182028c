//! What a bench reports of a plan before anything moves, each with the plan that has nothing wrong beside it.

use crate::texts::Texts;
use document::Diagnostic;

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
    let files = [("plan.toml", plan.as_str()), ("a.st", PROGRAM), ("board.toml", BOARD)];
    let (Ok(found) | Err(found)) = Texts(&files).checked();
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

/// The findings of a plan with one step, whose modules are eight digital inputs, an analogue input and an analogue output.
fn of_step(step: &str) -> Vec<String> {
    let (Ok(found) | Err(found)) =
        with_modules(&format!("steps = [{{ id = \"one\", at = \"start + 101 ms\", {step} }}]"), "", PROGRAM);
    let shown = found.iter().filter(|one| one.is_error());
    shown.map(|one| format!("{} {}: {}", one.code, one.message, one.help)).collect()
}

/// What the check finds in a plan of a M241 with three modules.
fn with_modules(text: &str, binds: &str, program: &str) -> Result<Vec<Diagnostic>, Vec<Diagnostic>> {
    let plan = format!(
        "format = 1\ntitle = \"A plan\"\nprogram = \"a.st\"\nneeds = [\"memory-access\"]\n\
         signals = {{ word = {{ address = \"%QW2\" }}, byte = {{ address = \"%MB3\" }}, far = {{ address = \"%IB201\", record = true }}, bit = {{ image = \"%QX0.4\" }}{binds} }}\n\
         {text}\nexpect = [{{ state = {{ stays = \"RUNNING\" }} }}]\n\
         [settings]\nmodules = [\"TM3DI8\", {{ type = \"TM3AI4\", inputs = [\"0..10 V\"] }}, {{ type = \"TM3AQ2\", outputs = [\"0..10 V\"] }}]\n"
    );
    let text = program.replace("small : USINT;", "small : USINT; go : BOOL; r : REAL;");
    Texts(&[("plan.toml", &plan), ("a.st", &text)]).checked()
}

#[test]
fn a_program_at_a_place_where_nothing_is_gives_a_warning() {
    for (declared, body, message, help) in [
        ("level AT %IW2 : INT;", "", "", ""),
        (
            "level AT %IW3 : INT;",
            "",
            "%IW3 is M2.IW1, an input of TM3AI4 that is not used",
            "inputs = [\"0..10 V\", \"0..10 V\"]",
        ),
        (
            "level AT %IW40 : INT;",
            "",
            "no input of the controller is at %IW40",
            "%IW2..%IW5 and status %IB12..%IB15 of M2 (TM3AI4)",
        ),
        ("level AT %IW2 : INT; status AT %IB12 : BYTE;", "", "", ""),
        (
            "level AT %IW2 : INT; status AT %IB13 : BYTE;",
            "",
            "%IB13 is the status of M2.IW1, an input of TM3AI4 that is not used",
            "inputs = [\"0..10 V\", \"0..10 V\"]",
        ),
        (
            "status AT %IB18 : BYTE;",
            "",
            "no input of the controller is at %IB18",
            "%IX3.0..%IX3.7 of M1 (TM3DI8)",
        ),
        ("all AT %IB0 : ARRAY [0..99] OF BYTE;", "", "", ""),
        (
            "far AT %QW20 : ARRAY [0..3] OF INT;",
            "",
            "no output of the controller is at %QW20",
            "%QW2..%QW3 of M3 (TM3AQ2)",
        ),
        ("relay AT %QX8.0 : BOOL;", "", "no output of the controller is at %QX8.0", "%QX0.0..%QX1.1"),
        ("", "%QX1.1 := %IX1.5;", "", ""),
        ("", "%QX1.2 := TRUE;", "no output of the controller is at %QX1.2", "%QX2.0 of TM241CEC24T"),
        ("", "%QX2.0 := %IX2.0;", "", ""),
        ("m AT %MW40 : INT;", "", "", ""),
        // The plan looks at this place by its address.
        ("w AT %IW100 : INT;", "", "", ""),
    ] {
        let program =
            format!("PROGRAM MAIN\nVAR small : USINT; {declared} END_VAR\nsmall := 1; {body}\nEND_PROGRAM");
        let found = with_modules("", "", &program).unwrap();
        let fits = match (message, found.as_slice()) {
            ("", found) => found.is_empty(),
            (message, [one]) => {
                one.code == "R0265"
                    && one.message == message
                    && one.help.contains(help)
                    && one.labels[0].file == "a.st"
            }
            _ => false,
        };
        assert!(fits, "{declared} {body}: {found:#?}");
    }
}

/// An address that was right for another list of modules.
#[test]
fn a_program_at_a_place_of_another_channel_gives_a_warning() {
    for (declared, message, help) in [
        (
            "level AT %IW2 : INT; status AT %IB4 : BYTE;",
            "%IB4 is a part of M2.IW0, an analogue channel of TM3AI4",
            "its word is %IW2, its status %IB12",
        ),
        (
            "level AT %IW2 : INT; door AT %IX5.7 : BOOL;",
            "%IX5.7 is a part of M2.IW0, an analogue channel of TM3AI4",
            "its word is %IW2",
        ),
        (
            "status AT %IB12 : BYTE;",
            "%IB12 is the status of M2.IW0, whose value the program does not read",
            "the value of M2.IW0 is %IW2",
        ),
        // Several status bytes at once, and the status of an output, say nothing of a value.
        ("all AT %IW6 : WORD;", "", ""),
        ("level AT %IW2 : INT; bad AT %IX12.0 : BOOL;", "", ""),
        ("status AT %IB16 : BYTE;", "", ""),
    ] {
        let program =
            format!("PROGRAM MAIN\nVAR small : USINT; {declared} END_VAR\nsmall := 1;\nEND_PROGRAM");
        let found = with_modules("", "", &program).unwrap();
        let fits = match (message, found.as_slice()) {
            ("", found) => found.is_empty(),
            (message, [one]) => one.code == "R0266" && one.message == message && one.help.contains(help),
            _ => false,
        };
        assert!(fits, "{declared}: {found:#?}");
    }
}

/// The wrong number in the name of a terminal: what the board drives goes nowhere.
#[test]
fn a_board_that_drives_an_unused_terminal_gives_a_warning() {
    for (terminal, wanted) in
        [("M1.IW0", ""), ("M1.IW1", "R0267 the board drives `M1.IW1`, an input of TM3AI4 that is not used")]
    {
        let board = BOARD.replace(
            "level = {",
            &format!("\"{terminal}\" = {{ kind = \"analog\", unit = \"V\" }}\nlevel = {{"),
        ) + &format!(
            "[[plants]]\nkind = \"transmitter\"\nname = \"t\"\ninput = \"level\"\noutput = \"{terminal}\"\nrange = \"0 .. 6 bar\"\n\
                 signal = \"0 .. 10 V\"\nsample = \"10 ms\"\n"
        );
        let plan = "format = 1\ntitle = \"A plan\"\nprogram = \"a.st\"\nboard = \"board.toml\"\nexpect = [{ state = { stays = \"RUNNING\" } }]\n\
                    [settings]\nmodules = [{ type = \"TM3AI4\", inputs = [\"0..10 V\"] }]\n";
        let files = [("plan.toml", plan), ("a.st", PROGRAM), ("board.toml", board.as_str())];
        let found = Texts(&files).checked().unwrap();
        let shown: Vec<String> = found.iter().map(|one| format!("{} {}", one.code, one.message)).collect();
        assert_eq!(shown, if wanted.is_empty() { vec![] } else { vec![wanted] }, "{terminal}");
    }
}

#[test]
fn what_can_only_be_read_is_not_written() {
    for name in ["PLC_R.i_wStatus", "LED.RUN", "OUTPUT.Q0"] {
        let found = of_step(&format!("write = {{ of = \"{name}\", value = 1 }}"));
        assert!(found.len() == 1 && found[0].starts_with("R0106"), "{name}: {found:?}");
        // A plan may claim that the controller refuses it.
        let found = of_step(&format!("refused = true, write = {{ of = \"{name}\", value = 1 }}"));
        assert!(found.is_empty(), "{name}: {found:?}");
    }
}

#[test]
fn a_name_of_a_terminal_that_a_module_does_not_have_says_what_to_write() {
    for (bound, code, help) in [
        (
            "\"M2.IW1\"",
            "R0104",
            "write { type = \"TM3AI4\", inputs = [\"0..10 V\", \"0..10 V\"] } in `settings.modules`",
        ),
        (
            "{ channel = \"M2.IW1\" }",
            "R0103",
            "write { type = \"TM3AI4\", inputs = [\"0..10 V\", \"0..10 V\"] } in `settings.modules`",
        ),
        ("\"M3.QW1\"", "R0104", "outputs = [\"0..10 V\", \"0..10 V\"]"),
        ("\"M2.I0\"", "R0104", "TM3AI4 has the terminals M2.IW0 to M2.IW3"),
        ("{ channel = \"M4.I0\" }", "R0103", "their terminals begin with M1 to M3"),
        ("\"%QX9.0\"", "R0102", "its outputs are %QX0.0..%QX1.1"),
    ] {
        let (binds, never) = (format!(", x = {bound}"), "measure = [{ name = \"n\", value-of = \"x\" }]");
        let found = with_modules(never, &binds, PROGRAM).unwrap_err();
        assert!(found[0].code == code && found[0].help.contains(help), "{bound}: {found:#?}");
    }
}

/// A finding says what to write, also where no name is near.
#[test]
fn a_finding_of_a_name_or_a_fault_has_a_help() {
    for (bound, help) in [
        ("\"Xyzzy.quux\"", "name a variable as in MAIN.n"),
        ("{ channel = \"Xyzzy.quux\" }", "describe it under `channels` of the board file"),
    ] {
        let never = "measure = [{ name = \"n\", value-of = \"x\" }]";
        let found = with_modules(never, &format!(", x = {bound}"), PROGRAM).unwrap_err();
        assert!(found[0].help.contains(help), "{bound}: {found:#?}");
    }
    let found = of_step("fault = { signal = \"M2.IW0\", kind = \"short-to-supply\" }");
    assert!(
        found[0].starts_with("R0111") && found[0].contains("it can have stuck, open, short-to-ground"),
        "{found:?}"
    );
}

/// Faults of outputs are those of the embedded ones: an output of a module is pointed to its line.
#[test]
fn a_short_circuit_of_an_output_of_a_module_names_the_fault_of_its_line() {
    for verb in ["short-circuit", "over-temperature"] {
        let found = of_step(&format!("{verb} = {{ output = \"%QX4.0\" }}"));
        assert!(found[0].starts_with("R0111") && found[0].contains("signal = \"M3.QW0\""), "{found:?}");
        let found = of_step(&format!("{verb} = {{ output = \"%QX9.0\" }}"));
        assert!(found[0].starts_with("R0102") && found[0].contains("its outputs are"), "{found:?}");
    }
}

/// Relays and digital inputs work from the bus.
#[test]
fn a_module_without_a_supply_of_its_own_cannot_be_without_it() {
    let of = |index: u8| of_step(&format!("module-fault = {{ index = {index}, kind = \"unsupplied\" }}"));
    let found = of(0);
    assert!(
        found[0].starts_with("R0111") && found[0].contains("TM3DI8 has no supply of its own"),
        "{found:?}"
    );
    assert_eq!([of(1), of(2)], [[""; 0]; 2]);
}

#[test]
fn values_that_a_place_a_terminal_or_a_line_does_not_take_are_errors() {
    let (level, word) = ("it takes TRUE or FALSE", "it takes a whole number from -32768 to 65535");
    let write = |of: &str, value: &str| format!("write = {{ of = \"{of}\", value = {value} }}");
    let of =
        |verb: &str, name: &str, value: &str| format!("{verb} = {{ signal = \"{name}\", value = {value} }}");
    for (step, help) in [
        (write("word", "65535"), ""),
        (write("word", "-32768"), ""),
        (write("word", "65536"), word),
        (write("word", "-32769"), word),
        (write("word", "true"), word),
        (write("%QW2", "70000"), word),
        (write("byte", "256"), "it takes a whole number from -128 to 255"),
        (write("bit", "1"), ""),
        (write("bit", "2"), level),
        (write("%MX4.0", "2"), level),
        (write("MAIN.go", "true"), ""),
        (write("MAIN.go", "2"), level),
        (write("MAIN.r", "true"), "it takes 0 and magnitudes"),
        (write("MAIN.back", "-1"), "it takes a time from 0 s to"),
        (write("MAIN.back", "\"T#500ms\""), ""),
        (write("MAIN.back", "\"500 ms\""), ""),
        (write("MAIN.back", "500_000_000"), ""),
        // A TIME counts milliseconds: half of one would be cut.
        (write("MAIN.back", "\"1.5 ms\""), "in whole 1 ms"),
        (write("MAIN.back", "1_500_000"), "in whole 1 ms"),
        (write("MAIN.back", "\"2 V\""), "a variable of type TIME takes a duration"),
        (write("MAIN.r", "\"500 ms\""), "it takes 0 and magnitudes"),
        (write("word", "\"500 ms\""), "write TRUE, FALSE or a number without a unit"),
        (write("PLC_W.q_wPLCControl", "65536"), "it takes a whole number from 0 to 65535"),
        (write("word", "\"2 V\""), "write TRUE, FALSE or a number without a unit"),
        (of("force", "%IX0.0", "1"), ""),
        (of("force", "%IX0.0", "2"), level),
        (of("force", "M1.I0", "2"), level),
        (of("force", "M1.I0", "true"), ""),
        (of("force", "M2.IW0", "65535"), ""),
        (of("force", "M2.IW0", "true"), word),
        (of("force", "M2.IW0", "65536"), word),
        (of("force", "M3.QW0", "-32769"), word),
        (of("set", "%IX0.0", "1"), ""),
        (of("set", "%IX0.0", "2"), level),
        (of("set", "M2.IW0", "5"), ""),
        (of("set", "M2.IW0", "true"), "it takes a number in V, as in \"1.5 V\""),
        (
            "train = { signal = \"M2.IW0\", frequency = \"10 Hz\", count = 5 }".into(),
            "write `square` with a `range`",
        ),
        ("fault = { signal = \"M2.IW0\", kind = \"stuck\", value = true }".into(), "it takes a number in V"),
    ] {
        let found = of_step(&step);
        let fits = match (help, found.as_slice()) {
            ("", []) => true,
            (help, [one]) => !help.is_empty() && one.starts_with("R0107") && one.contains(help),
            _ => false,
        };
        assert!(fits, "{step}: {found:?}");
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
