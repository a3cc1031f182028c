//! Which cases run, with which values, how often and in which order.

use crate::project_folder::{LAMP, TestProject};

/// Names of the cases that a command lists.
fn listed(bench: &TestProject, args: &[&str]) -> Vec<String> {
    let out = bench.expect(0, &[&["test", "--list"], args].concat()).out;
    out.lines().map(|line| line.split("  ").next().unwrap().to_owned()).collect()
}

/// Verdict words and names of the cases that a command ran, in the order in which it named them: up to the summary,
/// after which failures come again.
fn lines(out: &str) -> Vec<(String, String)> {
    out.lines()
        .take_while(|line| !line.starts_with("Summary"))
        .filter_map(|line| {
            let (word, rest) = line.split_once('[')?;
            let name = rest.split_once("] (")?.1.split_once(") ")?.1;
            ["PASS", "FAIL", "SKIP"].contains(&word.trim()).then(|| (word.trim().to_owned(), name.to_owned()))
        })
        .collect()
}

/// A folder with plans of several kinds.
fn folder() -> TestProject {
    let bench = TestProject::new();
    bench.write("plans/lamp.st", crate::project_folder::LAMP_ST);
    bench.write(
        "plans/a.toml",
        &LAMP
            .replace("\"500 ms .. 550 ms\"", "\"$limit\"")
            .replace("[\"controller:TASK-10\"]", "[\"io:EIO-15\"]"),
    );
    bench.write(
        "plans/a.toml",
        &(bench.read("plans/a.toml")
            + "[rows]\nwide = { limit = \"400 ms .. 600 ms\" }\nnarrow = { limit = \"500 ms .. 550 ms\" }\n"),
    );
    bench.write(
        "plans/deeper/b.toml",
        &LAMP.replace("lamp.st", "../lamp.st").replace("half a second", "500 ms"),
    );
    bench.write("plans/deeper/board.toml", "format = 1\n[board]\nkind = \"simulated\"\n");
    bench.write("plans/Cargo.toml", "[package]\nname = \"x\"\n");
    bench
}

#[test]
fn folders_are_searched_for_plans() {
    let bench = folder();
    assert_eq!(listed(&bench, &["plans"]), ["plans/a[wide]", "plans/a[narrow]", "plans/deeper/b"]);
    assert_eq!(listed(&bench, &["plans/deeper", "lamp.toml"]), ["plans/deeper/b", "lamp"]);
    assert_eq!(listed(&bench, &["."]), ["lamp", "plans/a[wide]", "plans/a[narrow]", "plans/deeper/b"]);
    // A plan that says too little is refused, not passed over.
    bench.write("plans/new.toml", "format = 1\ntitle = \"To be written\"\n");
    bench.refused(&["test", "plans"], &["plans/new.toml"]);
}

#[test]
fn only_selects_by_name_title_proof_and_profile() {
    let bench = folder();
    let only = |expression| listed(&bench, &["plans", "--only", expression]);
    assert_eq!(only("narrow"), ["plans/a[narrow]"]);
    assert_eq!(only("not narrow"), ["plans/a[wide]", "plans/deeper/b"]);
    assert_eq!(only("narrow or deeper"), ["plans/a[narrow]", "plans/deeper/b"]);
    assert_eq!(only("a and (wide or deeper)"), ["plans/a[wide]", "plans/deeper/b"]);
    assert_eq!(only("title:\"500 ms after\""), ["plans/deeper/b"]);
    assert_eq!(only("proves:controller:TASK-10"), ["plans/deeper/b"]);
    assert_eq!(only("proves:io:*"), ["plans/a[wide]", "plans/a[narrow]"]);
    assert_eq!(only("profile:m241-2019 deeper"), ["plans/deeper/b"]);
    let ran = bench.expect(0, &["test", "plans", "--only", "wide"]);
    assert_eq!(lines(&ran.out), [("PASS".into(), "plans/a[wide]".into())]);
}

#[test]
fn without_files_the_project_in_the_current_folder_runs_and_elsewhere_the_library() {
    let bench = TestProject::new();
    assert_eq!(listed(&bench, &[]), ["lamp"]);
    bench.write("site/suite.toml", "format = 1\ntitle = \"t\"\nsignals = { lamp = \"%QX0.4\", other = \"%QX0.5\" }\ninvariants = [{ name = \"n\", never = { all = [\"lamp\", \"other\"] } }]\n");
    bench.write("site/plans/a.toml", &LAMP.replace("lamp.st", "../../lamp.st"));
    bench.write("site/src/note.txt", "");
    bench.write("empty/note.txt", "");
    let within = |folder: &str, args: &[&str]| {
        let mut command = bench.command(args);
        command.current_dir(bench.path(folder));
        let done = command.output().unwrap();
        (
            done.status.code(),
            String::from_utf8(done.stdout).unwrap() + &String::from_utf8(done.stderr).unwrap(),
        )
    };
    assert_eq!(
        within("site", &["test", "--list"]).1.lines().next().unwrap().split("  ").next(),
        Some("plans/a")
    );
    assert_eq!(within("site/plans", &["test", "--list"]).1.split("  ").next(), Some("a"));
    // A folder of a project without plans is no reason to run others.
    let (code, said) = within("site/src", &["test", "--list"]);
    assert!(code == Some(2) && said.contains("R0230"), "{said}");
    assert_eq!(within("site", &["check"]), (Some(0), String::from("plans/a.toml: no errors\n")));
    let (code, said) = within("empty", &["check"]);
    assert!(code == Some(2) && said.contains("R0230") && said.contains("no project"), "{said}");
    assert!(within("empty", &["test", "--list"]).1.lines().count() > 100);
    let all = listed(&bench, &["--shipped"]);
    assert!(all.len() > 100 && all.iter().any(|name| name == "watchdog/fallback[over]"));
    let ran = bench.expect(0, &["test", "--shipped", "--only", "watchdog/fallback or bench"]);
    assert!(ran.out.contains("PASS") && ran.out.contains("bench/oven[broken]"), "{}", ran.out);
}

#[test]
fn parameters_belong_to_the_plans_that_have_them() {
    let bench = TestProject::new();
    let text = LAMP.replace("\"500 ms .. 550 ms\"", "\"$limit\"");
    bench.write("limit.toml", &format!("{text}[parameters]\nlimit = \"500 ms .. 550 ms\"\n"));
    bench.expect(0, &["test", "limit.toml", "lamp.toml"]);
    let ran = bench
        .expect(1, &["test", "limit.toml", "lamp.toml", "--param", "limit=1 ms .. 2 ms", "--report", "out"]);
    assert_eq!(lines(&ran.out), [("FAIL".into(), "limit".into()), ("PASS".into(), "lamp".into())]);
    // The record says with which values the case ran, and the judge takes them from the trace.
    let record = bench.json("out/record.json");
    assert_eq!(record["cases"][0]["parameters"][0]["value"], "1 ms .. 2 ms");
    let judged = bench.expect(1, &["judge", "limit.toml", "out/traces/limit.trace"]);
    assert!(judged.out.contains("rises 1 ms .. 2 ms"), "{}", judged.out);
}

#[test]
fn one_seed_gives_one_trace() {
    let bench = TestProject::new();
    // Edges become known late by chance: the trace depends on the seed.
    bench.write(
        "late.toml",
        "format = 1\n[board]\nkind = \"simulated\"\n[faults]\nlate = { chance = 1.0, by = \"1 ms\" }\n",
    );
    let hashes = |args: &[&str]| {
        bench.rig(&[&["test", "lamp.toml", "--board", "late.toml", "--report", "out"], args].concat());
        let cases = bench.json("out/record.json")["cases"].clone();
        let of = |case: &serde_json::Value| {
            (case["seed"].as_u64().unwrap(), case["trace_sha256"].as_str().unwrap().to_owned())
        };
        cases.as_array().unwrap().iter().map(of).collect::<Vec<_>>()
    };
    let one = hashes(&[]);
    assert_eq!(one, hashes(&["--seed", "1"]));
    let five = hashes(&["--seed", "5"]);
    assert_ne!(one[0].1, five[0].1);
    // Each turn has the next seed, so that a turn that fails can be run alone.
    let turns = hashes(&["--seed", "4", "--repeat", "3", "--jobs", "2"]);
    assert_eq!(turns.iter().map(|(seed, _)| *seed).collect::<Vec<_>>(), [4, 5, 6]);
    assert_eq!(turns[1].1, five[0].1);
}

#[test]
fn repeated_cases_are_numbered() {
    let bench = TestProject::new();
    let ran = bench.expect(0, &["test", "lamp.toml", "--repeat", "3", "--report", "out"]);
    let names: Vec<String> = lines(&ran.out).into_iter().map(|(_, name)| name).collect();
    assert_eq!(names, ["lamp", "lamp#2", "lamp#3"]);
    assert!(bench.list("out/traces").contains(&"lamp#2.trace".to_owned()));
    bench.expect(0, &["judge", "lamp.toml", "out/traces/lamp#2.trace"]);
}

/// Where in the scan the press comes is left to chance: of six turns one is later than the claim allows.
#[test]
fn one_turn_that_fails_is_a_failure() {
    let bench = TestProject::new();
    bench.write_lamp(
        "lamp.toml",
        "at = \"start + 1 s\",",
        "at = \"start + 1 s\", phase = { over = \"20 ms\" },",
    );
    bench.write("lamp.toml", &bench.read("lamp.toml").replace("500 ms .. 550 ms", "500 ms .. 520 ms"));
    let turns = |count| ["test", "lamp.toml", "--seed", "2", "--repeat", count];
    let ran = bench.expect(0, &turns("5"));
    assert!(ran.out.contains("\n  lamp  5 of 5 passed\n"), "{}", ran.out);
    let ran = bench.expect(1, &turns("6"));
    for words in [
        "\n  lamp  5 of 6 passed\n",
        "margin of `lamp` rises 500 ms .. 520 ms after press:  -335.981 us .. 8.36165 ms, mean ",
        ", spread ",
        ", drift ",
        "Summary: 5 passed, 1 failed",
    ] {
        assert!(ran.out.contains(words), "`{words}` is missing in\n{}", ran.out);
    }
}

#[test]
fn more_cases_than_a_record_holds_are_refused() {
    let bench = TestProject::new();
    bench.refused(&["test", "lamp.toml", "--repeat", "4294967295"], &["more than 100000 cases"]);
    bench.refused(&["test", "lamp.toml", "--repeat", "100001", "--list"], &["more than 100000 cases"]);
    assert_eq!(listed(&bench, &["lamp.toml", "--repeat", "1000"]).len(), 1_000);
}

#[test]
fn fail_fast_starts_no_further_case() {
    let bench = TestProject::new();
    bench.write_lamp("a-slow.toml", "500 ms .. 550 ms", "490 ms .. 510 ms");
    let args = ["test", "a-slow.toml", "lamp.toml", "--jobs", "1"];
    let all = bench.expect(1, &args);
    assert_eq!(lines(&all.out), [("FAIL".into(), "a-slow".into()), ("PASS".into(), "lamp".into())]);
    let ran = bench.expect(1, &[&args[..], &["--fail-fast", "--report", "out"]].concat());
    let words: Vec<String> = lines(&ran.out).into_iter().map(|(word, _)| word).collect();
    assert_eq!(words, ["FAIL", "SKIP"]);
    // The case itself ends when its claim is lost: 510 ms after the step, not at the plan's end.
    let cases = bench.json("out/record.json")["cases"].clone();
    assert!(cases[0]["duration_ns"].as_i64().unwrap() < 3_200_000_000, "{}", cases[0]["duration_ns"]);
    assert_eq!(bench.json("out/record.json")["totals"]["skipped"], 1);
}

#[test]
fn jobs_change_nothing_but_the_time() {
    let bench = folder();
    let run = |jobs: &str| {
        let out = bench.expect(0, &["test", "plans", "lamp.toml", "--jobs", jobs, "--report", "out"]).out;
        let hashes: Vec<String> = bench.json("out/record.json")["cases"]
            .as_array()
            .unwrap()
            .iter()
            .map(|case| case["trace_sha256"].to_string())
            .collect();
        (out, hashes)
    };
    let one = run("1");
    assert_eq!(one, run("2"));
    assert_eq!(one, run("18446744073709551615"));
}

/// What the plan names of its own board, and a board that is given in its place does not have.
#[test]
fn a_case_does_not_apply_on_another_board_without_its_channel_or_plant() {
    let bench = TestProject::new();
    let own = "format = 1\n[board]\nkind = \"simulated\"\n[channels]\nlevel = { kind = \"analog\", unit = \"m\" }\n\
        [[plants]]\nkind = \"tank\"\nname = \"tank\"\narea = \"1 m2\"\nheight = \"2 m\"\noutput = \"level\"\nsample = \"100 ms\"\n";
    bench.write("own.toml", own);
    bench.write("other.toml", "format = 1\n[board]\nkind = \"simulated\"\n");
    let plan = |what: &str| {
        format!(
            "format = 1\ntitle = \"A plan\"\nboard = \"own.toml\"\nprogram = \"lamp.st\"\n{what}\nexpect = [{{ state = {{ stays = \"RUNNING\" }} }}]\n"
        )
    };
    for (what, lacks) in [
        ("signals = { level = { channel = \"level\", record = true } }", "the board has no channel `level`"),
        (
            "steps = [{ id = \"fill\", at = \"start + 1 s\", set-plant = { plant = \"tank\", parameter = \"leak\", value = \"1 l/min\" } }]",
            "the board has no plant `tank`",
        ),
    ] {
        bench.write("lamp.toml", &plan(what));
        assert_eq!(bench.rig(&["test", "lamp.toml"]).code, Some(0), "{what}");
        let ran = bench.rig(&["test", "lamp.toml", "--board", "other.toml"]);
        assert!(
            ran.out.contains(lacks) && ran.out.contains("1 not applicable"),
            "{what}: {}{}",
            ran.out,
            ran.err
        );
    }
}
