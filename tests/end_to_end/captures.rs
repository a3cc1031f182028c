//! `rig judge` on what other instruments recorded: dumps, tables, sigrok sessions.

use crate::project_folder::{LAMP, TestProject, root};

/// The lamp's plan for instruments that sample: pulses that they can miss are declared not to matter.
fn bench() -> TestProject {
    let bench = TestProject::new();
    let mut plan = LAMP.to_owned();
    for claim in ["within = \"500 ms .. 550 ms\"", "until = \"press + 500 ms\""] {
        assert!(plan.contains(claim), "{claim}");
        plan = plan.replace(claim, &format!("{claim}, pulses-longer-than = \"20 ms\""));
    }
    bench.write("lamp.toml", &plan);
    for file in ["lamp.sr", "sigrok.vcd", "scope.csv", "edges.csv"] {
        std::fs::copy(root().join("rig/capture/tests/files").join(file), bench.path(file)).unwrap();
    }
    bench
}

const LINES: [&str; 4] = ["--map", "0=button", "--map", "1=lamp"];

fn judge<'a>(file: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    ["judge", "lamp.toml", file].into_iter().chain(more.iter().copied()).collect()
}

fn mapped<'a>(file: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    judge(file, &LINES).into_iter().chain(more.iter().copied()).collect()
}

#[test]
fn sessions_and_dumps_of_sigrok_are_judged_alike() {
    let bench = bench();
    for instants in [["--start", "1.5 s"], ["--at", "press=button rises"], ["--at", "press = 2.5 s"]] {
        let outs: Vec<String> = ["lamp.sr", "sigrok.vcd"]
            .into_iter()
            .map(|file| bench.expect(0, &mapped(file, &instants)).out)
            .collect();
        // The same trace, down to its hash.
        assert_eq!(outs[0], outs[1]);
        assert!(outs[0].contains("PASS"), "{}", outs[0]);
    }
}

/// Between two rows the limit of a wait may come before another step.
#[test]
fn a_wait_that_ends_before_another_step_ends() {
    let bench = bench();
    let wait = "steps = [\n  { id = \"early\", when = { signal = \"button\", edge = \"rises\", within = \"5 ms\" } },\n  { id = \"mark\", at = \"start + 20 ms\", mark = {} },\n";
    bench.write("lamp.toml", &LAMP.replace("steps = [\n", wait));
    let ran = bench.expect(1, &judge("edges.csv", &["--at", "press=1 s", "--period", "1 us"]));
    assert!(ran.out.contains("early"), "{}", ran.out);
}

#[test]
fn a_table_of_volts_has_thresholds() {
    let bench = bench();
    let map = [
        "--map",
        "Taster=button@12",
        "--map",
        "Lampe=lamp@12",
        "--start",
        "0 s",
        "--at",
        "press=button rises",
    ];
    bench.expect(0, &judge("scope.csv", &map));
    bench.refused(&judge("scope.csv", &["--map", "Lampe=lamp", "--start", "0 s"]), &["R0174", "lamp@2.5"]);
    // A level that the voltage never reaches.
    let ran = bench.expect(1, &judge("scope.csv", &["--map", "Lampe=lamp@30", "--start", "0 s"]));
    assert!(ran.out.contains("did not rise"), "{}", ran.out);
}

#[test]
fn what_lies_between_two_rows_is_not_known() {
    let bench = bench();
    let start = ["--at", "press=1 s"];
    let ran = bench.expect(3, &judge("edges.csv", &start));
    assert!(ran.out.contains("uncertainty"), "{}", ran.out);
    // These rows are edges: the user knows it.
    let known = ["--at", "press=1 s", "--period", "1 us"];
    // What the last one began may be over at once: nothing is known after it.
    bench.expect(3, &judge("edges.csv", &known));
    bench.write("edges.csv", &format!("{}\n2.0,1,1\n", bench.read("edges.csv").trim_end()));
    bench.expect(0, &judge("edges.csv", &known));
}

#[test]
fn behind_the_end_of_a_capture_nothing_is_known() {
    let bench = bench();
    // The lamp would have to light after the capture ends.
    let short = bench.read("scope.csv").lines().take(250).collect::<Vec<_>>().join("\n");
    bench.write("short.csv", &short);
    let volts = [
        "--map",
        "Taster=button@12",
        "--map",
        "Lampe=lamp@12",
        "--start",
        "0 s",
        "--at",
        "press=button rises",
    ];
    let ran = bench.expect(3, &judge("short.csv", &volts));
    assert!(ran.out.contains("not known at a time when it may rise"), "{}", ran.out);
    // What broke before its end stays broken.
    bench.write_lamp("lamp.toml", "500 ms .. 550 ms", "490 ms .. 510 ms");
    let ran = bench.expect(1, &mapped("lamp.sr", &["--at", "press=button rises"]));
    assert!(ran.out.contains("too late"), "{}", ran.out);
}

#[test]
fn a_signal_without_a_channel_is_inconclusive_and_said() {
    let bench = bench();
    let ran = bench.expect(3, &judge("lamp.sr", &["--start", "1.5 s", "--map", "0=button"]));
    assert!(
        ran.err.contains("no channel for lamp") && ran.out.contains("never observed"),
        "{}{}",
        ran.err,
        ran.out
    );
    assert!(!ran.out.contains("-9223372036"), "{}", ran.out);
}

#[test]
fn a_step_that_waits_comes_when_the_capture_has_it() {
    let bench = bench();
    let plan = bench.read("lamp.toml").replace(
        "{ id = \"press\", at = \"start + 1 s\", set = { signal = \"button\", value = true } }",
        "{ id = \"press\", when = { signal = \"button\", becomes = true, within = \"2 s\" } }",
    );
    let shut = |line: &&str| line.contains("stays = { signal = \"lamp\"");
    let plan: Vec<&str> = plan.lines().filter(|line| !shut(line)).collect();
    bench.write("lamp.toml", &plan.join("\n"));
    bench.expect(0, &mapped("lamp.sr", &["--start", "1.5 s"]));
    // It waits until 2.1 s only.
    let ran = bench.expect(1, &mapped("lamp.sr", &["--start", "0.1 s"]));
    assert!(ran.out.contains("press"), "{}", ran.out);
    // What the button was before the capture began nobody knows: it may have been pressed then.
    let ran = bench.expect(3, &mapped("lamp.sr", &["--start", "-0.1 s"]));
    assert!(ran.out.contains("whether step press came in time is not known"), "{}", ran.out);
}

/// A plan without a program, for captures of two lines.
fn two_lines(steps: &str, claims: &str) -> TestProject {
    let bench = TestProject::new();
    let plan = format!(
        "format = 1\nprogram-text = \"PROGRAM MAIN END_PROGRAM\"\nsignals = {{ a = \"%IX0.0\", b = \"%IX0.1\" }}\n\
         ends = \"start + 40 ms\"\nsteps = [{steps}]\nexpect = [{claims}]\n"
    );
    bench.write("two.toml", &plan);
    bench
}

#[test]
fn what_a_line_is_at_the_first_instant_is_no_edge_of_a_case_that_starts_there() {
    let claims = "{ changes = { signal = \"b\", within = \"6 ms .. 8 ms\", pulses-longer-than = \"2 us\" } }, \
        { edges = { signal = \"a\", rising = 0, falling = 1, pulses-longer-than = \"2 us\" } }, \
        { value = { of = \"a\", is = true, when = \"start\" } }, { rises = { signal = \"b\", from = \"w\", within = \"2 ms\" } }";
    let bench =
        two_lines("{ id = \"w\", when = { signal = \"a\", edge = \"falls\", within = \"9 ms\" } }", claims);
    let stamps = "$timescale 1 us $end\n$var wire 1 ! a $end\n$var wire 1 % b $end\n$enddefinitions $end\n\
        #0\n1!\n0%\n#6000\n0!\n#7000\n1%\n#50000\n1!\n";
    bench.write("two.vcd", stamps);
    bench.expect(0, &["judge", "two.toml", "two.vcd", "--start", "0 ms"]);
    bench.write("two.csv", "time [ms],a,b\n0,1,0\n6,0,0\n7,0,1\n50,1,1\n");
    bench.expect(0, &["judge", "two.toml", "two.csv", "--start", "0 ms", "--period", "1 us"]);
}

#[test]
fn a_step_that_may_have_come_in_time_or_not_is_open_with_all_that_comes_after_it() {
    let steps = "{ id = \"w\", when = { signal = \"a\", edge = \"rises\", from = \"start\", within = \"LIMIT\" } }, \
        { id = \"then\", when = { signal = \"b\", edge = \"rises\", from = \"w\", within = \"20 ms\" } }, \
        { id = \"apart\", when = { signal = \"b\", edge = \"rises\", from = \"start\", within = \"20 ms\" } }";
    for (limit, start, code, words) in [
        // The line rises between 8 ms and 10 ms.
        ("7 ms", "0 ms", 1, "step w never came"),
        ("8 ms", "0 ms", 3, "whether step w came in time is not known"),
        ("9 ms", "0 ms", 3, "whether step w came in time is not known"),
        ("10 ms", "0 ms", 0, ""),
        // It may have risen before the wait began.
        ("10 ms", "9 ms", 3, "whether step w came in time is not known"),
        ("10 ms", "8 ms", 0, ""),
    ] {
        let claim = "{ value = { of = \"b\", is = false, when = \"start\" } }";
        let bench = two_lines(&steps.replace("LIMIT", limit), claim);
        bench.write(
            "two.csv",
            "time [ms],a,b\n0,0,0\n2,0,0\n4,0,0\n6,0,0\n8,0,0\n10,1,0\n12,1,0\n14,1,1\n60,1,1\n",
        );
        let ran = bench.expect(code, &["judge", "two.toml", "two.csv", "--start", start, "--period", "2 ms"]);
        assert!(ran.out.contains(words), "{limit} {start}: {}", ran.out);
        assert!(code != 3 || ran.out.contains("step then") && !ran.out.contains("step apart"), "{}", ran.out);
        assert!(code != 1 || ran.out.contains("step then never came"), "{}", ran.out);
    }
}

#[test]
fn what_counts_from_a_step_moves_with_it_where_it_is_laid_elsewhere() {
    let steps = "{ id = \"press\", at = \"start + 1 ms\", set = { signal = \"a\", value = true } }, \
        { id = \"after\", at = \"press + 2 ms\", mark = {} }, { id = \"last\", at = \"after + 1 ms\", mark = {} }, \
        { id = \"wait\", when = { signal = \"b\", edge = \"falls\", from = \"after + 1 ms\", within = \"10 ms\" } }, \
        { id = \"group\", at = \"press + 1 ms\", run = { group = \"more\" } }";
    let claims = "{ value = { of = \"b\", is = true, when = \"after\" } }, { value = { of = \"b\", is = true, when = \"last\" } }, \
        { value = { of = \"b\", is = false, when = \"press\" } }, { value = { of = \"b\", is = true, when = \"group.in\" } }";
    let bench = two_lines(steps, claims);
    let plan = bench.read("two.toml").replace("ends = \"start + 40 ms\"", "ends = \"press + 20 ms\"");
    bench.write(
        "two.toml",
        &format!("{plan}[group.more]\nsteps = [{{ id = \"in\", at = \"begin + 1 ms\", mark = {{}} }}]\n"),
    );
    // The button is pressed 10 ms after the start, and not 1 ms as in the plan; the other line is TRUE from 11 to 20 ms.
    bench.write(
        "two.vcd",
        "$timescale 1 us $end\n$var wire 1 ! a $end\n$var wire 1 % b $end\n$enddefinitions $end\n\
         #0\n0!\n0%\n#10000\n1!\n#11000\n1%\n#20000\n0%\n#31000\n0!\n",
    );
    bench.expect(0, &["judge", "two.toml", "two.vcd", "--start", "0 ms", "--at", "press=a rises"]);
}

#[test]
fn a_change_that_may_have_come_before_the_end_of_the_case_leaves_open_whether_it_did() {
    let step =
        "{ id = \"w\", when = { signal = \"b\", edge = \"rises\", from = \"start\", within = \"60 ms\" } }";
    let value = "{ value = { of = \"a\", is = true, when = \"start\" } }";
    let claim = "{ edges = { signal = \"b\", rising = 0, pulses-longer-than = \"4 ms\" } }";
    // The line rises between the two rows, and the case ends 40 ms after its start.
    for (rows, edges, comes) in [([26, 30], 1, 0), ([38, 42], 3, 3), ([40, 44], 0, 1), ([42, 46], 0, 1)] {
        let table =
            format!("time [ms],a,b\n0,1,0\n4,1,0\n{},1,0\n{},1,1\n60,1,1\n90,1,1\n", rows[0], rows[1]);
        let args = ["judge", "two.toml", "two.csv", "--start", "0 ms", "--period", "4 ms"];
        for (steps, claims, code) in [("", claim, edges), (step, value, comes)] {
            let bench = two_lines(steps, claims);
            bench.write("two.csv", &table);
            let ran = bench.rig(&args);
            assert_eq!(ran.code, Some(code), "{steps}{claims}: {rows:?} {}{}", ran.out, ran.err);
        }
    }
}

#[test]
fn what_is_said_wrongly_is_refused_with_a_code() {
    let bench = bench();
    for (more, words) in [
        (&["--map", "1=lapm"][..], &["R0172", "there is `lamp`"][..]),
        (&["--map", "7=lamp"], &["R0171", "there is `0`"]),
        (&["--map", "lamp"], &["R0178", "CHANNEL=SIGNAL"]),
        (&["--map", "1=lamp@high"], &["R0178", "not a number"]),
        (&["--map", "1=lamp", "--map", "0=lamp"], &["R0178", "twice"]),
        (&["--start", "soon"], &["R0177", "soon"]),
        (&["--start", "button climbs"], &["R0177"]),
        (&["--start", "2 rises 0"], &["R0177"]),
        (&["--start", "2 rises"], &["R0171"]),
        (&["--start", "0 rises 2"], &["R0173", "never comes", "`0` is FALSE at first, rises once and falls"]),
        (&["--start", "1 h"], &["R0173", "0.000000000 s to 3.600000000 s"]),
        (&["--at", "pres=1 s"], &["R0178", "no step `pres`"]),
        (&["--at", "press"], &["R0178"]),
        (&["--start", "0 s", "--period", "0 s"], &["R0177"]),
        (&["--case", "other"], &["R0175", "no case `other`"]),
        (&[], &["R0176", "--start"]),
    ] {
        bench.refused(&judge("lamp.sr", more), words);
    }
    bench.write("broken.csv", "time,lamp\n0,1\n");
    bench.refused(&judge("broken.csv", &[]), &["R0170", "broken.csv: line 1", "time [s]"]);
    bench.write("rows.toml", &LAMP.replace("500 ms .. 550 ms", "$w").replace("]\n\"#", "]\n"));
    bench.write(
        "rows.toml",
        &format!(
            "{}[rows]\na = {{ w = \"1 ms .. 2 ms\" }}\nb = {{ w = \"500 ms .. 550 ms\" }}\n",
            bench.read("rows.toml")
        ),
    );
    bench.refused(&["judge", "rows.toml", "lamp.sr", "--start", "0 s"], &["R0175", "2 cases", "--case"]);
    let of_row = [
        "judge",
        "rows.toml",
        "lamp.sr",
        "--case",
        "a",
        "--map",
        "1=lamp",
        "--map",
        "0=button",
        "--at",
        "press=button rises",
    ];
    assert!(bench.expect(1, &of_row).out.contains("rows[a]"));
}

#[test]
fn dumps_of_the_rig_give_the_verdicts_of_the_run() {
    let bench = TestProject::new();
    bench.write_lamp("slow.toml", "500 ms .. 550 ms", "490 ms .. 510 ms");
    for (name, fault) in
        [("drop", "dropped = { chance = 1.0 }"), ("late", "late = { chance = 1.0, by = \"40 ms\" }")]
    {
        bench.write(
            &format!("{name}.toml"),
            &format!("format = 1\n[board]\nkind = \"simulated\"\n[faults]\n{fault}\n"),
        );
        bench.write_lamp(
            &format!("of-{name}.toml"),
            "program =",
            &format!("board = \"{name}.toml\"\nprogram ="),
        );
    }
    bench.write(
        "rows.toml",
        &format!(
            "{}[rows]\nwide = {{ limit = \"400 ms .. 600 ms\" }}\nearly = {{ limit = \"1 ms .. 2 ms\" }}\n",
            LAMP.replace("\"500 ms .. 550 ms\"", "\"$limit\"")
        ),
    );
    let plans = ["lamp.toml", "slow.toml", "of-drop.toml", "of-late.toml", "rows.toml"];
    let args: Vec<&str> = ["test"].into_iter().chain(plans).chain(["--report", "out"]).collect();
    bench.expect(4, &args);
    let record = bench.json("out/record.json");
    for case in record["cases"].as_array().unwrap() {
        let dump = format!("out/{}", case["trace_file"].as_str().unwrap().replace(".trace", ".vcd"));
        let judged = bench.rig(&["judge", case["plan"].as_str().unwrap(), &dump]);
        let code = match case["verdict"].as_str().unwrap() {
            "pass" => 0,
            "fail" => 1,
            "inconclusive" => 3,
            _ => 4,
        };
        assert_eq!(judged.code, Some(code), "{dump}\n{}{}", judged.out, judged.err);
        assert!(
            judged.out.lines().next().unwrap().ends_with(case["name"].as_str().unwrap()),
            "{}",
            judged.out
        );
    }
}

#[test]
fn a_trace_of_the_rig_says_everything_itself() {
    let bench = TestProject::new();
    bench.expect(0, &["test", "lamp.toml", "--report", "out"]);
    bench.refused(&["judge", "lamp.toml", "out/traces/lamp.trace", "--start", "0 s"], &["rig's own"]);
    // As do its dumps; one that does not is none to be judged.
    let dump = bench.read("out/traces/lamp.vcd");
    bench.refused(&["judge", "lamp.toml", "out/traces/lamp.vcd", "--period", "1 us"], &["R0213", "--period"]);
    bench.write("older.vcd", &dump.replace("    recorded ", "    was "));
    bench.refused(&["judge", "lamp.toml", "older.vcd"], &["R0170", "does not say how"]);
    bench.write("cut.vcd", &dump[..dump.rfind("$comment").unwrap()]);
    bench.refused(&["judge", "lamp.toml", "cut.vcd"], &["R0170", "cut off"]);
    // A dump's instants can be given again: then the press is half a second later than it was.
    let moved = ["judge", "lamp.toml", "out/traces/lamp.vcd", "--start", "2 s"];
    assert!(bench.expect(1, &moved).out.contains("too early"));
}

#[test]
fn a_step_needs_no_channel_of_its_own() {
    let bench = bench();
    let waits = "signals = { button = \"%IX0.0\", lamp = \"%QX0.4\" }\nsteps = [\n\
                 { id = \"press\", at = \"start + 1 s\", set = { signal = \"button\", value = true } },\n\
                 { id = \"lit\", when = { signal = \"lamp\", edge = \"rises\", from = \"press\", within = \"1 s\" } },\n]\n\
                 expect = [{ happens = { step = \"lit\" } }]\n";
    bench.write(
        "waits.toml",
        &format!("format = 1\ntitle = \"Waits\"\nprogram = \"lamp.st\"\nends = \"start + 3 s\"\n{waits}"),
    );
    bench.write("rows.csv", "time [s],button,lamp\n0,0,0\n1,1,0\n1.52,1,1\n3,1,1\n");
    let args = ["judge", "waits.toml", "rows.csv", "--start", "0 s"];
    let ran = bench.expect(0, &args);
    assert_eq!(ran.err, "");
    // What it waits for is another matter.
    bench.write("rows.csv", "time [s],button\n0,0\n1,1\n3,1\n");
    let ran = bench.expect(3, &args);
    assert!(!ran.err.contains("step:"), "{}", ran.err);
}
