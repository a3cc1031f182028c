//! Limits that the manual states: what lies at one is taken, what lies beyond it is refused, and the page says so in the
//! words that stand here. Whoever moves a limit finds the sentence, and whoever changes the sentence the limit.

use crate::manual::markdown::page;
use crate::project_folder::{TestProject, root};

/// A limit: the page, its words there, the file around the value (`@`), values that are taken and values that are refused.
type Limit = (&'static str, &'static str, &'static str, &'static [&'static str], &'static [&'static str]);

/// What a board file of virtual lines and one of real ones begins with.
const SIMULATED: &str = "format = 1\n[board]\nkind = \"simulated\"\n";
const REAL: &str = "format = 1\n[board]\nkind = \"real\"\n";
/// What a plan begins with, and a claim for one without.
const PLAN: &str = "format = 1\ntitle = \"A limit\"\nprogram = \"bench.st\"\nboard = \"bench.toml\"\n";
const CLAIM: &str = "expect = [{ state = { becomes = \"RUNNING\" } }]\n";

const LIMITS: &[Limit] = &[
    (
        "boards/file",
        "the board: `\"simulated\"` or `\"real\"`",
        "format = 1\n[board]\nkind = \"@\"\n",
        &["simulated", "real"],
        &["gpio", "model"],
    ),
    (
        "boards/file",
        "`\"m241-2014\"`, `\"m241-2019\"`, `\"m251-2024\"`",
        "BOARD[subject]\nprofile = \"@\"\n",
        &["m241-2014", "m241-2019", "m251-2024"],
        &["m241-2020"],
    ),
    ("boards/file", "`\"model\"`", "BOARD[subject]\nkind = \"@\"\n", &["model"], &["real"]),
    ("boards/file", "1 to 4096", "BOARD[control]\nclients = @\n", &["1", "4096"], &["0", "4097"]),
    (
        "boards/file",
        "an even number from 2 to 1 000",
        "BOARD[[wires]]\nfrom = \"Q4\"\nto = \"I2\"\nbounce = { edges = @, over = \"2 ms\" }\n",
        &["2", "1000"],
        &["0", "3", "1002"],
    ),
    ("boards/real", "20 ms to 10 s", "BOARD[guard]\nlimit = \"@\"\n", &["20 ms", "10 s"], &["19 ms", "11 s"]),
    ("boards/real", "up to 24 h", "BOARD[guard]\nhold = \"@\"\n", &["0 s", "24 h"], &["24.1 h"]),
    (
        "boards/real",
        "whole seconds",
        "BOARD[guard]\nwatchdog = \"/dev/watchdog\"\nbites-after = \"@\"\n",
        &["5 s"],
        &["5.5 s"],
    ),
    ("boards/real", "2 to 97", "BOARD[realtime]\npriority = @\n", &["0", "2", "97"], &["1", "98"]),
    (
        "boards/real",
        "10 us to 10 ms",
        "BOARD[realtime]\nhorizon = \"@\"\n",
        &["10 us", "10 ms"],
        &["9 us", "11 ms"],
    ),
    (
        "boards/simulated",
        "from 0 (never) to 1 (always), in steps of a millionth",
        "BOARD[faults]\ndropped = { chance = @ }\n",
        &["0", "0.000001", "1"],
        &["-0.1", "0.0000015", "1.1"],
    ),
    (
        "boards/converters",
        "up to 4 096",
        "LINES[converters]\nc = { kind = \"spi\", path = \"/dev/spidev0.0\", part = \"mcp3208\", reference = \"3 V\", oversample = @ }\n",
        &["1", "4096"],
        &["0", "4097"],
    ),
    (
        "boards/counters",
        "16 to 65 536",
        "LINES[counters]\nc = { name = \"x\", events = [\"overflow\"], buffer = @ }\n",
        &["16", "65536"],
        &["15", "65537"],
    ),
    (
        "boards/generators",
        "SPI mode 0 to 3",
        "LINES[generators]\nc = { kind = \"spi\", path = \"/dev/x\", mode = @ }\n",
        &["0", "3"],
        &["4"],
    ),
    (
        "boards/serial",
        "whole milliseconds, at most 100",
        "LINES[buses]\nc = { kind = \"serial\", path = \"/dev/x\", rs485 = { delay-before = \"@\" } }\n",
        &["0 ms", "100 ms"],
        &["0.5 ms", "101 ms"],
    ),
    (
        "plans/values",
        "up to 30 digits",
        "PLANexpect = [{ stays = { signal = \"pressure\", max = \"@ bar\" } }]\n",
        &["0.12345678901234567890123456789"],
        &["0.1234567890123456789012345678901"],
    ),
    ("plans/file", "1 to 10 000", "PLANrepeat = @\nCLAIM", &["1", "10000"], &["0", "10001"]),
    (
        "plans/steps",
        "2 to 20",
        "PLANsteps = [{ id = \"a\", at = \"start\", ask = { text = \"?\", answers = [@] } }]\nCLAIM",
        &["\"a\", \"b\""],
        &["\"a\""],
    ),
    (
        "plans/steps",
        "at most 1 000 000 times",
        "PLANsteps = [{ id = \"a\", at = \"start\", every = { period = \"1 us\", times = @ }, mark = {} }]\nCLAIM",
        &["1000000"],
        &["1000001"],
    ),
    (
        "plans/expectations",
        "2 to 16 signals",
        "PLANexpect = [{ never = { all = [@] } }]\n",
        &["\"%QX0.4\", \"%QX0.5\""],
        &["\"%QX0.4\""],
    ),
    (
        "plans/expectations",
        "2 to 32",
        "PLANexpect = [{ order = { edges = [@] } }]\n",
        &["\"%QX0.4 rises\", \"%QX0.5 rises\""],
        &["\"%QX0.4 rises\""],
    ),
    (
        "plans/pulses",
        "between -360 and 360, less than a turn apart",
        "PLANexpect = [{ phase = { of = \"A\", reference = \"B\", is = \"@\" } }]\n",
        &["-360 deg .. -355 deg", "0 deg .. 359 deg"],
        &["355 deg ± 10 deg", "0 deg .. 360 deg"],
    ),
    (
        "plans/settings",
        "0, the highest, to 31",
        "PLANsettings = { mast = { priority = @ } }\nCLAIM",
        &["0", "31"],
        &["32"],
    ),
    (
        "plans/settings",
        "at least 1 us",
        "PLANsettings = { mast = { interval = \"@\" } }\nCLAIM",
        &["1 us"],
        &["999 ns"],
    ),
    (
        "plans/settings",
        "0, 1, 2, 5, 10, 50, 100 or 500 us, 1 or 5 ms",
        "PLANsettings = { inputs = { \"%IX0.0\" = { event = \"both\", bounce = \"@\" } } }\nCLAIM",
        &["0 us", "1 us", "2 us", "5 us", "10 us", "50 us", "100 us", "500 us", "1 ms", "5 ms"],
        &["3 us", "10 ms"],
    ),
    (
        "plans/settings",
        "up to four values that grow",
        "PLANsettings = { expert = { HSC0 = { kind = \"main-single\", a = \"%IX0.0\", mode = \"modulo-loop\", modulo = 9, thresholds = [@] } } }\nCLAIM",
        &["1, 2, 3, 4"],
        &["1, 2, 3, 4, 5", "2, 1"],
    ),
    (
        "plans/stimuli",
        "A period has 4 samples or more",
        "PLANsteps = [{ id = \"a\", at = \"start\", sine = { signal = \"pressure\", range = \"0 .. 1 bar\", period = \"@\", count = 2 } }]\nCLAIM",
        &["4 ms"],
        &["3 ms"],
    ),
    (
        "plans/stimuli",
        "less than half of the shorter part",
        "PLANsteps = [{ id = \"a\", at = \"start\", train = { signal = \"%IX0.1\", period = \"100 ms\", duty = \"25 %\", count = 1, jitter = \"@\" } }]\nCLAIM",
        &["12.4 ms"],
        &["12.5 ms"],
    ),
    (
        "plans/file",
        "a train 10 000 000 pulses",
        "PLANsteps = [{ id = \"a\", at = \"start\", train = { signal = \"%IX0.1\", frequency = \"1 MHz\", count = @ } }]\nCLAIM",
        &["10000000"],
        &["10000001"],
    ),
];

#[test]
fn limits_are_those_of_the_manual() {
    let bench = TestProject::new();
    for name in ["bench.st", "bench.toml"] {
        let path = root().join("tests/end_to_end/manual/bench").join(name);
        bench.write(name, &std::fs::read_to_string(path).unwrap());
    }
    let mut wrong = Vec::new();
    for (name, words, around, taken, refused) in LIMITS {
        if !page(name).sentences().contains(words) {
            wrong.push(format!("docs/{name}.md does not say `{words}`"));
        }
        let around = [("BOARD", SIMULATED), ("LINES", REAL), ("PLAN", PLAN), ("CLAIM", CLAIM)]
            .iter()
            .fold((*around).to_owned(), |text, (word, part)| text.replacen(word, part, 1));
        let values = taken.iter().map(|value| (value, 0)).chain(refused.iter().map(|value| (value, 2)));
        for (value, code) in values {
            bench.write("limit.toml", &around.replace('@', value));
            let ran = bench.rig(&["check", "limit.toml"]);
            if ran.code != Some(code) {
                wrong.push(format!(
                    "docs/{name}.md, `{words}`: {value} has exit code {:?}\n{}",
                    ran.code, ran.err
                ));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
