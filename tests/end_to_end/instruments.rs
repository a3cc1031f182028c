//! `rig judge --instrument`: what the instrument of a capture may be off, in the verdict, the record and the reports.

use crate::project_folder::{LAMP, TestProject, root};

/// The lamp by an oscilloscope: volts, sampled every 10 ms.
fn bench() -> TestProject {
    let bench = TestProject::new();
    let mut plan = LAMP.to_owned();
    for claim in ["within = \"500 ms .. 550 ms\"", "until = \"press + 500 ms\""] {
        plan = plan.replace(claim, &format!("{claim}, pulses-longer-than = \"20 ms\""));
    }
    let measure = "measure = [{ name = \"delay\", from = \"press\", to = { signal = \"lamp\", edge = \"rises\" }, \
                   min = \"500 ms\", max = \"550 ms\", pulses-longer-than = \"20 ms\" }]\n";
    bench.write("lamp.toml", &format!("{plan}{measure}"));
    let file = root().join("rig/capture/tests/files/scope.csv");
    std::fs::copy(file, bench.path("scope.csv")).unwrap();
    bench
}

/// The lamp's channels, and these figures of the clock and of the lamp's.
fn scope(clock: &str, lamp: &str) -> String {
    format!(
        "format = 1\ntitle = \"Scope 4\"\n[timebase]\n{clock}\n[channels.Taster]\nunit = \"V\"\nthreshold = \"12 V\"\n\
         [channels.Lampe]\nunit = \"V\"\nthreshold = \"12 V\"\n{lamp}\n"
    )
}

const JUDGE: [&str; 13] = [
    "judge",
    "lamp.toml",
    "scope.csv",
    "--instrument",
    "scope.toml",
    "--map",
    "Taster=button",
    "--map",
    "Lampe=lamp",
    "--start",
    "0 s",
    "--at",
    "press=button rises",
];

#[test]
fn thresholds_of_the_file_make_lines_of_volts() {
    let bench = bench();
    bench.write("scope.toml", &scope("", ""));
    bench.expect(0, &JUDGE);
    // What the command line says rules: a level that the lamp never reaches.
    let mapped: Vec<&str> =
        JUDGE.iter().map(|word| if *word == "Lampe=lamp" { "Lampe=lamp@30" } else { word }).collect();
    let ran = bench.expect(1, &mapped);
    assert!(ran.out.contains("did not rise"), "{}", ran.out);
}

#[test]
fn what_the_clock_may_be_off_opens_a_verdict() {
    let bench = bench();
    bench.write("scope.toml", &scope("error = \"100 ppm\"", ""));
    bench.expect(0, &JUDGE);
    // 10 % of the time since the start.
    bench.write("scope.toml", &scope("error = \"10 %\"", ""));
    let ran = bench.expect(3, &JUDGE);
    assert!(ran.out.contains("INCONCLUSIVE") && ran.out.contains("coverage"), "{}", ran.out);
    bench.write("scope.toml", &scope("resolution = \"100 ms\"", ""));
    bench.expect(3, &JUDGE);
}

#[test]
fn record_and_reports_say_what_the_file_states() {
    let bench = bench();
    let file = scope("error = \"25 ppm\"", "accuracy = { plus = \"100 mV\", coverage = \"95 %\" }");
    bench.write("scope.toml", &file);
    let ran = bench.expect(0, &[&JUDGE[..], &["--report", "out"]].concat());
    assert!(ran.out.contains("out/index.html"), "{}", ran.out);
    let record = bench.read("out/record.json");
    for part in
        ["\"coverage\":\"95 %\"", "\"title\":\"Scope 4\"", "\"value\":\"25 ppm\"", "\"accuracy.coverage\""]
    {
        assert!(record.contains(part), "{part} in {record}");
    }
    for (file, part) in [
        ("out/junit.xml", "coverage 95 %"),
        ("out/junit.xml", "timebase: error = 25 ppm"),
        ("out/summary.md", "coverage 95 %"),
        ("out/measurements.csv", ",95 %"),
        ("out/ctrf.json", "\"coverage\":\"95 %\""),
    ] {
        assert!(bench.read(file).contains(part), "{part} in {file}: {}", bench.read(file));
    }
    // The trace says all of it: it is judged again without the file.
    std::fs::remove_file(bench.path("scope.toml")).unwrap();
    let traces: Vec<_> =
        std::fs::read_dir(bench.path("out/traces")).unwrap().map(|entry| entry.unwrap().path()).collect();
    let trace = traces.iter().find(|path| path.extension().is_some_and(|ending| ending == "trace")).unwrap();
    bench.expect(0, &["judge", "lamp.toml", &trace.to_string_lossy(), "--report", "again"]);
    assert!(bench.read("again/record.json").contains("\"value\":\"25 ppm\""));
}

#[test]
fn a_file_that_does_not_suit_the_capture_is_refused() {
    let bench = bench();
    for (file, words) in [
        ("format = 1\n[channels.Lamp]\nunit = \"V\"", ["R0213", "write `Lampe`"]),
        ("format = 1\n[channels.Lamp]\nunit = \"V\"", ["scope.toml:2:11", "no channel `Lamp`"]),
        ("format = 1\n[channels.Lampe]\nunit = \"banana\"", ["scope.toml:2:11", "in V, and its figures"]),
        ("format = 1\n[channels.Lampe]\nthreshold = \"12 V\"", ["R0212", "unit"]),
        ("format = 1\n[channels.Lampe]\nunit = \"A\"\nthreshold = \"12 A\"", ["R0213", "write unit = \"V\""]),
        ("format = 1\n[timebase]\nresolutoin = \"1 ns\"", ["R0211", "did you mean `resolution`?"]),
    ] {
        bench.write("scope.toml", file);
        bench.refused(&JUDGE, &words);
    }
    // A channel that is no other's is noted: one file serves several captures.
    bench.write("scope.toml", &format!("{}[channels.Temperature]\nunit = \"degC\"\n", scope("", "")));
    let ran = bench.expect(0, &JUDGE);
    assert!(ran.err.contains("the capture has no channel Temperature of scope.toml"), "{}", ran.err);
    let file: Vec<&str> =
        JUDGE.iter().map(|word| if *word == "scope.toml" { "none.toml" } else { word }).collect();
    bench.refused(&file, &["R0201"]);
}

#[test]
fn an_edge_that_never_comes_says_what_its_channel_reads() {
    let bench = bench();
    let place = |edge: &str| ["judge", "lamp.toml", "scope.csv", "--start", edge].map(str::to_owned);
    let refused = |args: &[String], words: &[&str]| {
        let args: Vec<&str> = args.iter().map(String::as_str).collect();
        bench.refused(&args, words);
    };
    // Volts have no edges: the message says what to type.
    refused(
        &place("Taster rises"),
        &[
            "R0173",
            "`Taster` reads 0.02 .. ",
            " V, and numbers have no levels",
            "--map \"Taster=SIGNAL@2.5\"",
        ],
    );
    // A threshold that is never reached leaves one level.
    let mapped: Vec<String> =
        [&place("Taster rises")[..], &["--map", "Taster=button@30"].map(str::to_owned)].concat();
    refused(
        &mapped,
        &[
            "R0173",
            "`Taster` reads 0.02 .. ",
            "by its threshold is FALSE at first, rises never and falls never",
        ],
    );
}

#[test]
fn bits_have_no_unit() {
    let bench = bench();
    bench.write("bits.csv", "time [s],button,lamp\n0,0,0\n1,1,0\n1.52,1,1\n3,1,1\n");
    bench.write("scope.toml", "format = 1\n[channels.lamp]\nunit = \"banana\"\n");
    let args = ["judge", "lamp.toml", "bits.csv", "--start", "0 s", "--instrument", "scope.toml"];
    bench.refused(&args, &["R0213", "scope.toml:2:11", "the unit banana", "remove `unit` of `lamp`"]);
    // What a threshold of the command line makes bits of has volts.
    bench.write("scope.toml", "format = 1\n[channels.lamp]\nunit = \"V\"\n");
    assert_eq!(bench.rig(&[&args[..], &["--map", "lamp=lamp@0.5"]].concat()).code, Some(3));
}
