//! `rig step`: a case step by step, with commands from a script.

use crate::project_folder::{CommandOutput, LAMP, TestProject, drain};
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use std::io::{BufRead, BufReader, Read, Write};
use std::process::Stdio;

fn step(bench: &TestProject, args: &[&str], script: &str) -> CommandOutput {
    let args: Vec<&str> = ["step"].into_iter().chain(args.iter().copied()).collect();
    let mut command = bench.command(&args);
    let mut child =
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    // A command that ends early does not read all of its script.
    let _ = child.stdin.take().unwrap().write_all(script.as_bytes());
    let out = drain(child.stdout.take().unwrap());
    let err = drain(child.stderr.take().unwrap());
    let code = child.wait().unwrap().code();
    CommandOutput { code, out: out.join().unwrap(), err: err.join().unwrap() }
}

#[test]
fn a_script_goes_through_a_case() {
    let bench = TestProject::new();
    let ran = step(&bench, &["lamp.toml"], "claims\nuntil 1.2 s\nuntil start + 1.6 s\nuntil 1 s\nrun\n");
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    assert_eq!(ran.err, "error: the case is at start + 1.6 s already\n");
    let claim = "`lamp` rises 500 ms .. 550 ms after press";
    let stays = "`lamp` stays FALSE until press + 500 ms";
    let text = format!(
        "start + 1 s  before press: button := TRUE
  state   RUNNING since start
  button  FALSE since start - 1.5 s
  lamp    FALSE since start - 1.5 s
  0 of 2 claims decided
          open  {claim}
          open  {stays}
start + 1.2 s
  state   RUNNING since start
  button  TRUE since start + 1 s
  lamp    FALSE since start - 1.5 s
  0 of 2 claims decided
start + 1.6 s
  state   RUNNING since start
  button  TRUE since start + 1 s
  lamp    TRUE since start + 1.520035 s
  decided:         pass  {claim}
  decided:         pass  {stays}
  2 of 2 claims decided
        PASS [   3.500 s] lamp
"
    );
    assert!(ran.out.starts_with(&text), "{}", ran.out);
}

/// It fails at the end of the case, by what happens after both stops.
#[test]
fn an_invariant_is_open_up_to_the_end() {
    let bench = TestProject::new();
    let plan = LAMP.replace("steps = [", "invariants = [{ never = { signal = \"lamp\" } }]\nsteps = [");
    bench.write("lamp.toml", &plan);
    let ran = step(&bench, &["lamp.toml"], "until 1.2 s\nclaims\nrun\n");
    assert_eq!(ran.code, Some(1), "{}", ran.err);
    assert!(!ran.out.contains("decided: "), "{}", ran.out);
    assert!(ran.out.contains("          open  `lamp` is never TRUE"), "{}", ran.out);
}

#[test]
fn stepping_changes_no_trace() {
    let bench = TestProject::new();
    let two = "  { id = \"press\", at = \"start + 1 s\", set = { signal = \"button\", value = true } },\n";
    assert!(LAMP.contains(two));
    let release =
        "  { id = \"release\", at = \"press + 1 s\", set = { signal = \"button\", value = false } },\n";
    bench.write("lamp.toml", &LAMP.replace(two, &format!("{two}{release}")));
    bench.expect(0, &["test", "lamp.toml", "--report", "out"]);
    let hash = bench.json("out/record.json")["cases"][0]["trace_sha256"].as_str().unwrap().to_owned();
    let ran = step(&bench, &["lamp.toml"], "until 700 us\nuntil 1.5203 s\n\nvalues\nnext\n");
    assert_eq!(ran.code, Some(0), "{}{}", ran.out, ran.err);
    assert!(ran.out.contains("before release: button := FALSE"), "{}", ran.out);
    assert!(ran.out.contains(&format!("trace  {hash}")), "{hash} is missing in {}", ran.out);
}

#[test]
fn a_lost_claim_is_decided_at_once() {
    let bench = TestProject::new();
    bench.write_lamp("slow.toml", "500 ms .. 550 ms", "490 ms .. 510 ms");
    let ran = step(&bench, &["slow.toml"], "until 1.515 s\n");
    assert_eq!(ran.code, Some(1), "{}", ran.out);
    assert!(
        ran.out.contains("decided:         fail  `lamp` rises 490 ms .. 510 ms after press"),
        "{}",
        ran.out
    );
    assert!(ran.out.contains("10.035 ms too late"), "{}", ran.out);
}

#[test]
fn the_user_can_end_it_and_is_helped() {
    let bench = TestProject::new();
    let ran = step(&bench, &["lamp.toml"], "vlaues\nhelp\nquit\nrun\n");
    assert_eq!(ran.code, Some(130));
    assert!(ran.err.contains("did you mean `values`?"), "{}", ran.err);
    assert!(
        ran.out.contains("until TIME") && ran.out.ends_with("quit: the outputs are safe\n"),
        "{}",
        ran.out
    );
}

#[test]
fn one_case_is_meant() {
    let bench = TestProject::new();
    let rows = "[rows]\nwide = { limit = \"400 ms .. 600 ms\" }\nearly = { limit = \"1 ms .. 2 ms\" }\n";
    bench.write("rows.toml", &format!("{}{rows}", LAMP.replace("\"500 ms .. 550 ms\"", "\"$limit\"")));
    bench.refused(&["step", "rows.toml"], &["R0175", "2 cases", "rows[wide], rows[early]"]);
    bench.refused(&["step", "rows.toml", "--only", "late"], &["R0175", "selects none"]);
    bench.refused(&["step", "nothing.toml"], &["nothing.toml"]);
    // Nothing on standard input: to the end.
    let ran = bench.expect(1, &["step", "rows.toml", "--only", "early"]);
    assert!(ran.out.contains("rows[early]") && ran.out.contains("FAIL"), "{}", ran.out);
}

#[test]
fn an_interrupt_ends_a_case_that_waits_for_a_command() {
    for signal in [Signal::SIGINT, Signal::SIGTERM] {
        let bench = TestProject::new();
        let mut command = bench.command(&["step", "lamp.toml"]);
        // An input that has no end and no line.
        let mut child =
            command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let mut out = BufReader::new(child.stdout.take().unwrap());
        let mut text = String::new();
        while !text.contains("of 2 claims decided") {
            assert_ne!(out.read_line(&mut text).unwrap(), 0, "{text}");
        }
        kill(Pid::from_raw(child.id() as i32), signal).unwrap();
        out.read_to_string(&mut text).unwrap();
        assert_eq!(child.wait().unwrap().code(), Some(130));
        assert!(text.ends_with("quit: the outputs are safe\n"), "{text}");
    }
}
