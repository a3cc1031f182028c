//! Every example of the manual is one that `rig check` takes.

use crate::manual::markdown::{Block, manual};
use crate::project_folder::{LAMP_ST, TestProject, root};
use document::SourceFile;
use runtime::suite::instrument_file;

/// What stands in front of a list of steps or of expectations.
const KEYS: &str = r#"format = 1
title = "A part of the manual"
program = "bench.st"
board = "bench.toml"
settings = { modules = ["TM3DI16", "TM3DQ8T", "TM3XTRA1", "TM3XREC1"], expert = { HSC0 = { kind = "simple", a = "%IX0.2", mode = "modulo-loop", modulo = 1000 } } }
"#;

/// The names that the lists use.
const NAMES: &str = r#"
[frames]
beat = { bus = "machine", id = 0x701, data = "05" }
status = { bus = "machine", id = 0x100, mask = 0x700, from = "others" }
engine = { bus = "drive", dbc = "machine.dbc", message = "Engine" }
[signals]
button = "%IX0.0"
second = "%IX0.1"
pulses = "%IX0.3"
lamp = "%QX0.4"
seen = { image = "%IX0.0" }
forward = "%QX0.5"
reverse = "%QX0.6"
slow = "%QX0.7"
fast = "%QX1.0"
back = "%QX1.1"
kept = "MAIN.kept"
copy = "MAIN.copy"
track_a = "A"
track_b = "B"
"#;

/// The group that some lists run.
const GROUP: &str = r#"
[group.press]
args = { lasts = "1 s" }
steps = [{ id = "down", at = "begin + 10 ms", pulse = { signal = "button", width = "$lasts" } }]
"#;

/// Names of steps alone: the columns of a table.
const COLUMNS: &str = "p = \"pressure\"\nlevel = \"%IX0.4\"\n";

/// The steps that expectations of the manual count from.
const STEPS: &str = r#"
  { id = "press", at = "start + 1 s", set = { signal = "button", value = true } },
  { id = "release", at = "press + 1 s", set = { signal = "button", value = false } },
  { id = "lit", when = { signal = "lamp", edge = "rises", from = "press", within = "2 s" } },
  { id = "tap", at = "start + 4 s", pulse = { signal = "button", width = "100 ms" } },
  { id = "train", at = "start + 5 s", train = { signal = "pulses", frequency = "200 Hz", count = 100 } },
  { id = "slow", at = "train.done + 100 ms", train = { signal = "pulses", period = "10 ms", count = 10 } },
  { id = "busy", at = "start + 8 s", overload = { task = "MAST", cycle = "95 ms" } },
  { id = "stop", at = "start + 10 s", command = "stop" },
  { id = "cut", at = "start + 11 s", power-cut = { duration = "500 ms" } },
  { id = "go", at = "start + 15 s", train = { signal = "pulses", frequency = "1 kHz", count = 1000 } },
  { id = "there", at = "go.done", mark = {} },
  { id = "turn", at = "start + 20 s", encoder = { a = "A", b = "B", moves = [{ by = 400_000, speed = "200 kHz" }] } },
  { id = "back", at = "turn.done", encoder = { a = "A", b = "B", from = 400_000, moves = [{ to = 0, speed = "200 kHz" }] } },
  { id = "beats", at = "start + 30 s", send = { frame = "beat", period = "100 ms", count = 20 } },
  { id = "raw", at = "start + 31 s", send = { bus = "drive", id = 0x181, data = "01 2A" } },
"#;

/// A board with the channels and buses that the examples name, and the files that they name.
fn bench() -> TestProject {
    let bench = TestProject::new();
    let folder = root().join("tests/end_to_end/manual/bench");
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    for name in ["bench.st", "other.st", "tasks.st", "counter.st", "machine.dbc", "bench.toml"] {
        bench.write(name, &read(name));
    }
    bench.write("door.png", "");
    let tanks =
        manual().iter().flat_map(|page| page.blocks()).find(|block| block.text.contains("PROGRAM TwoTanks"));
    bench.write("two-tanks.st", &tanks.unwrap().text);
    let sequences = manual().iter().flat_map(|page| page.blocks()).find(|block| block.language == "csv");
    bench.write("drive.csv", &sequences.unwrap().text);
    bench
}

/// The name and the text of the file that an example stands for.
fn file(block: &Block) -> (&'static str, String) {
    let text = &block.text;
    if block.language == "iecst" {
        let part = !text.contains("END_PROGRAM");
        let text =
            if part { LAMP_ST.replace("END_PROGRAM", &format!("{text}END_PROGRAM")) } else { text.clone() };
        return ("example.st", text);
    }
    // A group that no step runs is refused.
    let group = if text.contains("group = \"press\"") { GROUP } else { "" };
    let text = match text.get(..1) {
        // A whole file begins with its format; of a board file a table may stand alone.
        Some("f") => text.clone(),
        Some("[") => format!("format = 1\n[board]\nkind = \"simulated\"\n{text}"),
        _ if text.starts_with("{ id") => {
            let claims = "expect = [{ state = { becomes = \"RUNNING\" } }]";
            format!("{KEYS}steps = [\n{text}]\n{claims}\n{group}{NAMES}{COLUMNS}")
        }
        _ => format!("{KEYS}steps = [{STEPS}]\nexpect = [\n{text}]\n{group}{NAMES}"),
    };
    (if is_suite(&text) { "suite.toml" } else { "example.toml" }, text)
}

/// A suite file is known by its name alone.
fn is_suite(text: &str) -> bool {
    text.contains("\ninvariants = ")
        && !["program", "board"].iter().any(|key| text.contains(&format!("\n{key} = ")))
}

#[test]
fn the_examples_of_the_manual_are_taken() {
    let bench = bench();
    let mut wrong = Vec::new();
    let mut taken = 0;
    for page in manual() {
        for block in page.blocks() {
            let checked = ["toml", "iecst"].contains(&block.language.as_str());
            // The line of a schema is one of an editor.
            if !checked || block.text.starts_with("#:schema") {
                continue;
            }
            if block.text.contains("\n[timebase]\n") {
                let read = instrument_file::read(&SourceFile::new("scope.toml", &block.text));
                wrong.extend(read.err().map(|found| format!("docs/{}:\n{found:?}", block.place)));
                taken += 1;
                continue;
            }
            let (name, text) = file(&block);
            bench.write(name, &text);
            let ran = bench.rig(&["check", name]);
            if ran.code != Some(0) {
                let errors = ran.err.split("\n\n").filter(|found| found.trim_start().starts_with("error"));
                wrong.push(format!("docs/{}:\n{}", block.place, errors.collect::<Vec<_>>().join("\n")));
            }
            std::fs::remove_file(bench.path(name)).unwrap();
            taken += 1;
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
    assert!(taken > 60, "{taken} examples");
}
