//! Texts of any kind are refused or read within bounds and never panic.

use std::fmt::Write;
use std::path::Path;

use document::SourceFile;
use proptest::prelude::*;
use scanrig_plans::read;

/// The first code of a text that must be refused.
fn refused(text: String) -> &'static str {
    read(&SourceFile::new("a.toml", text), &[], 1).unwrap_err()[0].code
}

const HEAD: &str = "format = 1\nprogram = \"a.st\"\n";
const CLAIM: &str = "expect = [{ state = { is = \"RUNNING\", when = \"end\" } }]\n";

#[test]
fn sizes_are_bounded() {
    assert_eq!(refused(" ".repeat((1 << 20) + 1)), "P0003");
    assert_eq!(refused("[".repeat(1 << 20)), "P0003");
    assert_eq!(refused(format!("a = {}", "[".repeat(1000))), "P0003");
    assert_eq!(refused("a.".repeat(500_000)), "P0003");
    assert_eq!(refused("a=1\n".repeat(260_000)), "P0003");
    assert_eq!(refused(format!("a = [{}]", "0,".repeat(300_000))), "P0003");
    assert_eq!(refused(format!("{HEAD}steps = [{}]\n{CLAIM}", "{},".repeat(10_001))), "P0208");
    assert_eq!(
        refused(format!("{HEAD}{CLAIM}sweep = {{ a = {{ from = 1, to = 100001, step = 1 }} }}")),
        "P0407"
    );
    assert_eq!(
        refused(format!("{HEAD}{CLAIM}sweep = {{ a = {{ from = 1, to = 1e300, step = 1 }} }}")),
        "P0407"
    );
    let long = "x".repeat(257);
    assert_eq!(refused(format!("{HEAD}{CLAIM}[rows]\na = {{ b = \"{long}\" }}")), "P0403");
    let twice = format!(
        "{HEAD}title = \"{}\"\n{CLAIM}[rows]\na = {{ b = \"{}\" }}",
        "$b".repeat(5000),
        "x".repeat(256)
    );
    assert_eq!(refused(twice), "P0402");
    let phase = "steps = [{ id = \"a\", at = \"start\", phase = { over = \"1 s\", positions = 100000 }, mark = {} }, \
                 { id = \"b\", at = \"start\", phase = { over = \"1 s\", positions = 100000 }, mark = {} }]\n";
    assert_eq!(refused(format!("{HEAD}{phase}{CLAIM}")), "P0407");
    let train = "steps = [{ id = \"a\", at = \"start\", train = { signal = \"b\", period = \"1 us\", count = 10_000_001 } }]\n";
    assert_eq!(refused(format!("{HEAD}{train}{CLAIM}")), "P0104");
}

/// Groups that run each other: each of eight runs the next one a hundred times.
fn nested(inner: &str) -> String {
    let mut text =
        format!("{HEAD}{CLAIM}steps = [{{ id = \"s\", at = \"start\", run = {{ group = \"g0\" }} }}]\n");
    for n in 0..7 {
        let call = format!("run = {{ group = \"g{}\" }}", n + 1);
        let steps: Vec<String> =
            (0..100).map(|at| format!("{{ id = \"s{at}\", at = \"begin\", {call} }}")).collect();
        writeln!(text, "[group.g{n}]\nsteps = [{}]", steps.join(", ")).unwrap();
    }
    text + &format!("[group.g7]\n{inner}\n")
}

#[test]
fn groups_are_bounded_before_they_are_expanded() {
    let began = std::time::Instant::now();
    assert_eq!(refused(nested("steps = [{ id = \"s\", at = \"begin\", mark = {} }]")), "P0407");
    // A long list as an argument, in each of many calls.
    let list = vec!["1"; 5_000].join(", ");
    let call = "{ id = \"s\", at = \"start\", every = { period = \"1 ms\", times = 2000 }, run = { group = \"g\", a = [LIST] } }";
    let text = format!(
        "{HEAD}{CLAIM}steps = [{}]\n[group.g]\nargs = {{ a = {{ doc = \"\" }} }}\nsteps = [{{ id = \"x\", at = \"begin\", set = {{ signal = \"$a\", value = true }} }}]\n",
        call.replace("LIST", &list)
    );
    assert_eq!(refused(text), "P0208");
    // Claims, which are no steps.
    let claims = vec!["{ state = { stays = \"RUNNING\" } }"; 200].join(", ");
    let text = format!(
        "{HEAD}steps = [{{ id = \"s\", at = \"start\", every = {{ period = \"1 ms\", times = 1000 }}, run = {{ group = \"g\" }} }}]\n[group.g]\nexpect = [{claims}]\n"
    );
    assert_eq!(refused(text), "P0507");
    let groups: String = (0..1_001).fold(String::new(), |text, n| text + &format!("[group.g{n}]\n{CLAIM}"));
    assert_eq!(refused(format!("{HEAD}{CLAIM}{groups}")), "P0003");
    assert!(began.elapsed().as_secs() < 60, "{:?}", began.elapsed());
}

#[test]
fn a_wave_up_to_the_end_has_the_limit_of_one_with_a_duration() {
    let plan = |wave: &str, more: &str| {
        format!(
            "{HEAD}{CLAIM}ends = \"start + 1000 h\"\nsteps = [{{ id = \"w\", at = \"start\", {wave} }}{more}]\n"
        )
    };
    let square = "square = { signal = \"b\", frequency = \"1 MHz\" }";
    let noise = "noise = { signal = \"p\", range = \"0 .. 5 bar\", sample = \"1 us\" }";
    assert_eq!(refused(plan(square, "")), "P0641");
    assert_eq!(refused(plan(noise, "")), "P0641");
    let slow = "square = { signal = \"b\", frequency = \"1 Hz\" }";
    let ended = ", { id = \"off\", at = \"start + 1 s\", set = { signal = \"b\", value = true } }";
    for text in [plan(slow, ""), plan(square, ended)] {
        assert!(read(&SourceFile::new("a.toml", text), &[], 1).is_ok());
    }
}

// A chain of steps, each depending on the one before, must neither recurse deeply nor take quadratic time.
#[test]
fn a_long_chain_of_steps_reads() {
    let mut text = format!("{HEAD}{CLAIM}steps = [{{ id = \"s0\", at = \"start\", mark = {{}} }},\n");
    for n in 1..5_000 {
        writeln!(text, "{{ id = \"s{n}\", at = \"s{} + 1 ms\", mark = {{}} }},", n - 1).unwrap();
    }
    text.push(']');
    let plan = read(&SourceFile::new("a.toml", text), &[], 1).unwrap();
    assert_eq!(plan.case(0).unwrap().ends.to_string(), "start + 5.999 s");
}

#[test]
fn many_cases_read() {
    let text = format!(
        "{HEAD}expect = [{{ value = {{ of = \"n\", is = \"$a\", when = \"end\" }} }}]\n\
                        sweep = {{ a = {{ from = 1, to = 50000, step = 1 }} }}\n"
    );
    let plan = read(&SourceFile::new("a.toml", text), &[], 1).unwrap();
    assert_eq!((plan.len(), plan.case(49_999).unwrap().name), (50_000, "a[a=50000]".to_owned()));
    assert!(plan.case(50_000).is_none());
}

fn good_plans() -> Vec<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/plans");
    let mut paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(|one| one.unwrap().path()).collect();
    paths.sort();
    paths.iter().map(|path| std::fs::read_to_string(path).unwrap()).collect()
}

/// Pieces that plans are made of, to put where they do not belong.
const PIECES: &[&str] = &[
    "$",
    "$$",
    "$cut",
    "\"",
    "'''",
    "\"\"\"",
    "{",
    "}",
    "[",
    "]",
    ",",
    "=",
    ".",
    "-1",
    "1e400",
    "nan",
    "0x",
    "00:00:10",
    "start",
    "end",
    "@",
    "..",
    "±",
    "µs",
    "16#",
    "%QX",
    "\n",
    "\\u0000",
    "99999999999999999999",
    "a.b.c",
    "id",
    "when",
    "rows",
    "phase",
    "train",
    "count = 0",
    "true",
    "",
    "pulse[0]",
    "\u{feff}",
    "\u{202e}",
];

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_text_panics(text in "\\PC{0,200}", lines in "([a-z]{1,8} = [\\[{\"$0-9a-z .]{0,20}\n){0,6}") {
        let _ = read(&SourceFile::new("a.toml", text), &[], 1);
        let _ = read(&SourceFile::new("a.toml", format!("{HEAD}{lines}")), &[], 1);
    }

    #[test]
    fn no_mutated_plan_panics(
        which in 0usize..3,
        cuts in proptest::collection::vec((any::<u32>(), 0usize..12, 0usize..PIECES.len()), 1..5),
    ) {
        let plans = good_plans();
        let mut text = plans[which % plans.len()].clone();
        for (at, length, piece) in cuts {
            let mut start = at as usize % (text.len() + 1);
            while !text.is_char_boundary(start) {
                start -= 1;
            }
            let mut end = (start + length).min(text.len());
            while !text.is_char_boundary(end) {
                end += 1;
            }
            text.replace_range(start..end, PIECES[piece]);
        }
        let file = SourceFile::new("a.toml", text);
        match read(&file, &[], 1) {
            Ok(plan) => {
                // What was found right can be made.
                for number in 0..plan.len().min(20) {
                    prop_assert!(plan.case(number).is_some());
                }
            }
            Err(found) => {
                prop_assert!(found.iter().any(document::Diagnostic::is_error));
                let _ = document::render(&found, &[file], true);
            }
        }
    }
}
