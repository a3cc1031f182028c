//! Switches and values of plants that something changes at the very instants of their thresholds, against the same laws in steps of
//! a millisecond and whole numbers.

use crate::common::*;
use crate::plant_kinds::Bench;
use signal::{Random, Value};

const MS: i64 = 1_000_000;

/// What a plan does at an instant: a number of `Q0` and the like, or a parameter.
#[derive(Clone, Copy, Debug)]
enum Act {
    Level(&'static str, bool),
    Number(&'static str, f64),
    Parameter(&'static str, f64),
}

/// A law in whole numbers.
trait Law {
    /// Lets a millisecond pass.
    fn step(&mut self);
    fn act(&mut self, act: Act);
    /// What each channel has now, in the order of the names.
    fn values(&self) -> Vec<Value>;
}

/// Runs both for so many milliseconds, with acts at instants of a coarse grid, and compares them at each millisecond.
fn compare(seed: u64, text: &str, names: &[&str], law: &mut dyn Law, acts: &[Act], grid: u64) {
    let mut random = Random::new(seed);
    let mut bench = Bench::new(text);
    let ids: Vec<u16> = names.iter().map(|name| bench.file.find(name).unwrap().0).collect();
    let mut shown: Vec<Value> = law.values();
    let mut done = Vec::new();
    for ms in 0..4_000u64 {
        if ms > 0 {
            law.step();
        }
        let mut events = Vec::new();
        let mut act_now = |bench: &mut Bench, law: &mut dyn Law, random: &mut Random| {
            if ms % grid == 0 && random.below(3) > 0 {
                let act = acts[random.below(acts.len() as u64) as usize];
                done.push((ms, act));
                law.act(act);
                let seconds = ms as f64 / 1e3;
                match act {
                    Act::Level(name, on) => bench.write(seconds, name, Value::Bool(on)),
                    Act::Number(name, number) => bench.write(seconds, name, Value::Real(number)),
                    Act::Parameter(name, number) => bench.set(seconds, name, number),
                }
            }
        };
        // Before and after what is due at this instant.
        act_now(&mut bench, law, &mut random);
        events.append(&mut poll(&mut *bench.board, ms as i64 * MS));
        let expected = law.values();
        act_now(&mut bench, law, &mut random);
        events.append(&mut poll(&mut *bench.board, ms as i64 * MS));
        for (place, id) in ids.iter().enumerate() {
            if let Some((_, value)) = changes(&events, *id).last() {
                shown[place] = *value;
            }
            let same = match (shown[place], expected[place]) {
                (Value::Real(shown), Value::Real(expected)) => {
                    // A decimal number is met, and any other one but for rounding.
                    let decimal = (expected * 1e3).round() / 1e3 == expected;
                    shown == expected || !decimal && (shown - expected).abs() < 5e-14
                }
                (shown, expected) => shown == expected,
            };
            assert!(
                same,
                "seed {seed}, {} at {ms} ms: {:?}, expected {:?}; {:?}",
                names[place],
                shown[place],
                expected[place],
                &done[done.len().saturating_sub(8)..]
            );
        }
    }
}

/// A position in 3000 parts of the way.
struct Position {
    at: i64,
    target: i64,
    /// Milliseconds, out and back.
    times: [i64; 2],
    stuck: bool,
}

const PARTS: i64 = 3_000;

impl Law for Position {
    fn step(&mut self) {
        if self.stuck {
            return;
        }
        let rate = |time: i64| PARTS / time;
        if self.target > self.at {
            self.at = (self.at + rate(self.times[0])).min(self.target);
        } else {
            self.at = (self.at - rate(self.times[1])).max(self.target);
        }
    }

    fn act(&mut self, act: Act) {
        match act {
            Act::Level(_, on) => self.target = if on { PARTS } else { 0 },
            Act::Number(_, percent) => self.target = percent as i64 * PARTS / 100,
            Act::Parameter("stuck", on) => self.stuck = on != 0.0,
            Act::Parameter("travel", time) => self.times = [(time * 1e3) as i64; 2],
            Act::Parameter("extend-time", time) => self.times[0] = (time * 1e3) as i64,
            Act::Parameter(_, time) => self.times[1] = (time * 1e3) as i64,
        }
    }

    fn values(&self) -> Vec<Value> {
        let ends = [self.at >= PARTS - PARTS / 10, self.at <= PARTS / 10];
        let percent = self.at as f64 / (PARTS / 100) as f64;
        ends.map(Value::Bool).into_iter().chain([Value::Real(percent)]).collect()
    }
}

const TRAVEL: &str = r#"
[channels]
go = { kind = "analog", unit = "%" }
high = { kind = "digital" }
low = { kind = "digital" }
position = { kind = "analog", unit = "%" }
[[plants]]
name = "p"
output = "position"
sample = "1 ms"
reach = "10 %"
"#;

#[test]
fn end_switches_change_where_the_position_passes_them() {
    let names = ["high", "low", "position"];
    for seed in 0..40 {
        let mut law = Position { at: 0, target: 0, times: [1_000; 2], stuck: false };
        let common = [Act::Parameter("stuck", 1.0), Act::Parameter("stuck", 0.0)];
        let times = [0.2, 0.3, 0.5, 0.6, 1.0, 1.5];
        let (rest, acts): (&str, Vec<Act>) = match seed % 3 {
            0 => (
                "kind = \"cylinder\"\ninput = \"Q0\"\nextended = \"high\"\nretracted = \"low\"\nextend-time = \"1 s\"\n\
                 retract-time = \"1 s\"\n",
                times
                    .iter()
                    .flat_map(|time| ["extend-time", "retract-time"].map(|name| Act::Parameter(name, *time)))
                    .chain([true, true, true, false, false, false].map(|on| Act::Level("Q0", on)))
                    .collect(),
            ),
            1 => (
                "kind = \"valve\"\ninput = \"Q0\"\nopened = \"high\"\nclosed = \"low\"\ntravel = \"1 s\"\n",
                times
                    .map(|time| Act::Parameter("travel", time))
                    .into_iter()
                    .chain([true, true, false, false].map(|on| Act::Level("Q0", on)))
                    .collect(),
            ),
            _ => (
                "kind = \"valve\"\ninput = \"go\"\nopened = \"high\"\nclosed = \"low\"\ntravel = \"1 s\"\n",
                times
                    .map(|time| Act::Parameter("travel", time))
                    .into_iter()
                    .chain(
                        [0, 5, 10, 10, 35, 50, 55, 7, 90, 90, 95, 100]
                            .map(|n| Act::Number("go", f64::from(n))),
                    )
                    .collect(),
            ),
        };
        let acts: Vec<Act> = acts.into_iter().chain(common).collect();
        compare(
            seed,
            &format!("{TRAVEL}{rest}"),
            &names,
            &mut law,
            &acts,
            [10, 20, 50][seed as usize % 7 % 3],
        );
    }
}

/// The level of a tank in 20000 parts of its height.
struct Level {
    at: i64,
    flows: [(bool, i64); 2],
    high: bool,
    low: bool,
    overflows: bool,
}

const FULL: i64 = 20_000;

impl Level {
    fn switch(&mut self) {
        let next = |on: bool, above: i64, below: i64| if on { self.at > below } else { self.at >= above };
        (self.high, self.low) = (next(self.high, 18_000, 16_000), next(self.low, 4_000, 2_000));
    }
}

impl Law for Level {
    fn step(&mut self) {
        let [inflow, outflow] = self.flows.map(|(on, flow)| if on { flow } else { 0 });
        let next = self.at + inflow - outflow;
        // What goes over in this millisecond.
        self.overflows = next > FULL;
        self.at = next.clamp(0, FULL);
        self.switch();
    }

    fn act(&mut self, act: Act) {
        match act {
            Act::Level(name, on) => self.flows[usize::from(name == "Q1")].0 = on,
            Act::Parameter(name, flow) => {
                self.flows[usize::from(name == "outflow")].1 = (flow * 200.0).round() as i64;
            }
            Act::Number(..) => {}
        }
    }

    fn values(&self) -> Vec<Value> {
        let levels = [self.high, self.low, self.overflows].map(Value::Bool);
        levels.into_iter().chain([Value::Real(self.at as f64 / 200.0)]).collect()
    }
}

#[test]
fn switches_of_a_level_change_where_it_reaches_them() {
    let text = r#"
[channels]
high = { kind = "digital" }
low = { kind = "digital" }
over = { kind = "digital" }
level = { kind = "analog", unit = "%" }
[[plants]]
kind = "tank"
name = "tank"
area = "0.1 m2"
height = "1 m"
initial = 50
inflows = [{ channel = "Q0", flow = "6000 l/min" }]
outflows = [{ channel = "Q1", flow = "6000 l/min" }]
output = "level"
sample = "1 ms"
overflow = "over"
switches = [{ channel = "high", on-above = 90, off-below = 80 }, { channel = "low", on-above = 20, off-below = 10 }]
"#;
    let mut acts = Vec::new();
    for on in [true, true, true, false] {
        acts.extend([Act::Level("Q0", on), Act::Level("Q1", on)]);
    }
    for flow in [0.05, 0.1, 0.2] {
        acts.extend([Act::Parameter("inflow", flow), Act::Parameter("outflow", flow)]);
    }
    for seed in 0..40 {
        let mut law =
            Level { at: FULL / 2, flows: [(false, 20); 2], high: false, low: true, overflows: false };
        compare(
            seed,
            text,
            &["high", "low", "over", "level"],
            &mut law,
            &acts,
            [10, 20, 50][seed as usize % 3],
        );
    }
}

/// A belt in half millimetres.
struct Belt {
    moved: i64,
    parts: Vec<i64>,
    runs: bool,
    backwards: bool,
    blocked: bool,
    feeding: bool,
    speed: i64,
}

impl Law for Belt {
    fn step(&mut self) {
        let speed = if self.runs && !self.blocked { self.speed } else { 0 };
        self.moved += if self.backwards { -speed } else { speed };
        let moved = self.moved;
        self.parts.retain(|came| moved >= *came && moved < came + 2_000 + 400);
    }

    fn act(&mut self, act: Act) {
        match act {
            Act::Level("Q0", on) => self.runs = on,
            Act::Level("Q1", on) => self.backwards = on,
            Act::Level(_, on) => {
                if on && !self.feeding {
                    self.parts.push(self.moved);
                }
                self.feeding = on;
            }
            Act::Parameter("blocked", on) => self.blocked = on != 0.0,
            Act::Parameter(_, speed) => self.speed = (speed * 2.0).round() as i64,
            Act::Number(..) => {}
        }
    }

    fn values(&self) -> Vec<Value> {
        let sees =
            |eye: i64| self.parts.iter().any(|came| (came + eye..came + eye + 400).contains(&self.moved));
        [200, 600].map(|eye| Value::Bool(sees(eye))).into()
    }
}

#[test]
fn photo_eyes_change_where_a_part_comes_before_them() {
    let text = r#"
[channels]
near = { kind = "digital" }
far = { kind = "digital" }
[[plants]]
kind = "conveyor"
name = "belt"
input = "Q0"
reverse = "Q1"
feed = "Q2"
speed = "1 m/s"
length = "1 m"
part-length = "20 cm"
eyes = [{ channel = "near", at = "10 cm" }, { channel = "far", at = "30 cm" }]
"#;
    let mut acts = vec![Act::Level("Q1", true), Act::Parameter("blocked", 1.0)];
    for on in [true, true, true, false] {
        acts.extend([Act::Level("Q0", on), Act::Level("Q2", on)]);
    }
    acts.extend([false; 2].map(|on| Act::Level("Q1", on)));
    acts.extend([0.0; 2].map(|on| Act::Parameter("blocked", on)));
    acts.extend([0.5, 1.0, 2.0].map(|speed| Act::Parameter("speed", speed)));
    for seed in 0..40 {
        let mut law = Belt {
            moved: 0,
            parts: Vec::new(),
            runs: false,
            backwards: false,
            blocked: false,
            feeding: false,
            speed: 2,
        };
        compare(seed, text, &["near", "far"], &mut law, &acts, [10, 20, 50][seed as usize % 3]);
    }
}

/// What a person computes in decimals is what a transmitter signals and what a lag comes to.
#[test]
fn linear_laws_meet_decimal_numbers() {
    for (range, signal, unit) in [
        ((0, 20), (4_000, 20_000), "mA"),
        ((0, 17), (0, 10_000), "V"),
        ((-10, 10), (4_000, 20_000), "mA"),
        ((0, 7), (-10_000, 10_000), "V"),
        ((9_990, 10_000), (4_000, 20_000), "mA"),
    ] {
        let text = format!(
            r#"
[channels]
level = {{ kind = "analog", unit = "m" }}
signal = {{ kind = "analog", unit = "{unit}" }}
[[plants]]
kind = "transmitter"
name = "t"
input = "level"
output = "signal"
range = "{} .. {} m"
signal = "{} .. {} {unit}"
sample = "1 s"
"#,
            f64::from(range.0) / 10.0,
            f64::from(range.1) / 10.0,
            signal.0 / 1_000,
            signal.1 / 1_000,
        );
        let mut bench = Bench::new(&text);
        for step in 1..=100 {
            // Tenths of a metre by hundredths, thousandths of the signal's unit by hundredths.
            let level = f64::from(range.0 * 100 + (range.1 - range.0) * step) / 1_000.0;
            let expected = f64::from(signal.0 * 100 + (signal.1 - signal.0) * step) / 100_000.0;
            bench.write(f64::from(step), "level", Value::Real(level));
            let found = bench.until(f64::from(step) + 0.5, "signal");
            assert_eq!(found.last().map(|(_, value)| *value), Some(Value::Real(expected)), "{level}");
        }
    }
}

/// A tank that is filled just full lets nothing over, and one that is filled longer does so from then on.
#[test]
fn a_tank_overflows_for_as_long_as_more_flows_in() {
    let text = r#"
channels = { level = { kind = "analog", unit = "m" }, over = { kind = "digital" } }
[[plants]]
kind = "tank"
name = "tank"
area = "0.1 m2"
height = "1 m"
inflows = [{ channel = "Q0", flow = "3000 l/min" }]
output = "level"
sample = "10 ms"
overflow = "over"
"#;
    for polls_first in [false, true] {
        let mut bench = Bench::new(text);
        bench.write(1.0, "Q0", Value::Bool(true));
        if polls_first {
            assert_eq!(bench.until(3.0, "over"), []);
        }
        bench.write(3.0, "Q0", Value::Bool(false));
        assert_eq!(bench.until(4.0, "over"), [], "{polls_first}");
        bench.write(4.0, "Q0", Value::Bool(true));
        bench.write(4.5, "Q0", Value::Bool(false));
        let over = bench.until(5.0, "over");
        assert_eq!(over, [(4_000 * MS + 1, Value::Bool(true)), (4_500 * MS + 1, Value::Bool(false))]);
    }
}
