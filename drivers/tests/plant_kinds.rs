//! Plants of every kind, as board files have them, against what their laws give.

use std::collections::BTreeSet;
use std::path::Path;

use crate::common::*;
use document::SourceFile;
use scanrig_drivers::{Board, BoardExt, BoardFile, Subject, Terminals, UnknownSubject, build, read};
use signal::{Address, Value};

const S: i64 = 1_000_000_000;

fn terminals(_: &Subject) -> Result<Terminals, UnknownSubject> {
    let addresses =
        |area: &str| (0..8).map(|bit| Address::parse(&format!("%{area}X0.{bit}")).unwrap()).collect();
    Ok(Terminals { inputs: addresses("I"), outputs: addresses("Q"), ports: Vec::new(), modules: Vec::new() })
}

pub(super) struct Bench {
    pub(super) file: BoardFile,
    pub(super) board: Box<dyn Board>,
}

impl Bench {
    /// A started board with these channels and plants.
    pub(super) fn new(text: &str) -> Bench {
        let text = format!("format = 1\n{text}");
        let file =
            read(&SourceFile::new("b.toml", text), &terminals).unwrap_or_else(|found| panic!("{found:#?}"));
        let mut board = build(&file, 7).unwrap();
        board.start(at(0)).unwrap();
        poll(&mut *board, 0);
        Bench { file, board }
    }

    pub(super) fn write(&mut self, seconds: f64, name: &str, value: Value) {
        let channel = self.file.find(name).unwrap();
        self.board.write(at((seconds * 1e9).round() as i64), &[(channel, value)]).unwrap();
    }

    /// What a channel changes to up to an instant.
    pub(super) fn until(&mut self, seconds: f64, name: &str) -> Vec<(i64, Value)> {
        let channel = self.file.find(name).unwrap();
        changes(&poll(&mut *self.board, (seconds * 1e9).round() as i64), channel.0)
    }

    pub(super) fn set(&mut self, seconds: f64, parameter: &str, value: f64) {
        let place =
            self.file.circuit.plants[0].parameters().iter().position(|one| one.name == parameter).unwrap();
        self.board.set_parameter(at((seconds * 1e9).round() as i64), 0, place, value).unwrap();
    }
}

fn near(found: &[(i64, Value)], expected: &[(f64, Value)]) {
    let right = found.len() == expected.len()
        && found
            .iter()
            .zip(expected)
            .all(|((at, value), (time, level))| value == level && (*at - (time * 1e9) as i64).abs() <= 3);
    assert!(right, "{found:?} {expected:?}");
}

/// What is wrong with a board file, and what helps, in a line each.
fn wrong(text: &str) -> Vec<String> {
    let found = read(&SourceFile::new("b.toml", format!("format = 1\n{text}")), &terminals).unwrap_err();
    found.iter().map(|one| format!("{} {}; {}", one.code, one.message, one.help)).collect()
}

/// A finding says which limits a number has and what is to be written, in the words of the file.
#[test]
fn what_is_wrong_with_a_plant_says_what_to_write() {
    let transmitter = |range: &str, output: &str| {
        format!(
            "channels = {{ level = {{ kind = \"analog\", unit = \"m\" }}, s = {{ kind = \"analog\", unit = \"V\" }} }}\n\
             [[plants]]\nkind = \"transmitter\"\nname = \"t\"\ninput = \"level\"\noutput = \"{output}\"\n\
             range = \"{range}\"\nsignal = \"0 .. 10 V\"\nsample = \"1 s\"\n"
        )
    };
    let conveyor = |at: &str, speed: &str| {
        format!(
            "[[plants]]\nkind = \"conveyor\"\nname = \"c\"\ninput = \"Q0\"\nspeed = \"{speed}\"\nlength = \"3 m\"\n\
             part-length = \"1 m\"\nfeed = \"Q1\"\neyes = [{{ channel = \"I0\", at = \"{at}\" }}]\n"
        )
    };
    for (text, parts) in [
        (
            transmitter("2 .. 0 m", "s"),
            ["the end of the range lies before its beginning", "the lower one first"],
        ),
        (transmitter("2 m", "s"), ["B0007 `range` does not read as a range", "write both ends"]),
        (transmitter("0 .. 2 m", "M1.IW0"), ["B0304", "as in: \"M1.IW0\" = { kind = \"digital\" }"]),
        (transmitter("0 .. 2 m", "shown"), ["B0304", "as in: shown = {"]),
        (conveyor("3.5 m", "1 m/s"), ["B0507 `at` is out of its range: 3.5 m", "write 0 to 3 m"]),
        (conveyor("1 m", "0 m/s"), ["B0507 `speed` is out of its range", "more than 0"]),
    ] {
        let found = wrong(&text);
        assert!(parts.iter().all(|part| found[0].contains(part)), "{parts:?}: {found:?}");
    }
}

/// An input far beyond `full`, as of a channel in mV whose `full` was meant in V.
#[test]
fn an_encoder_has_no_more_edges_than_it_can_count() {
    let mut bench = Bench::new(
        "channels = { u = { kind = \"analog\", unit = \"V\" } }\n\
         [[plants]]\nkind = \"motor\"\nname = \"m\"\ninput = \"u\"\nspeed = \"3000 rpm\"\nfull = \"10 V\"\n\
         tau = \"1 us\"\na = \"I0\"\nb = \"I1\"\nlines = 1000\n",
    );
    bench.write(0.001, "u", Value::Real(1e9));
    let edges = bench.until(0.002, "I0").len();
    // A thousand microseconds with two edges each, half of them of A.
    assert!((900..=1001).contains(&edges), "{edges}");
}

/// As they are printed on a nameplate.
#[test]
fn areas_and_volumes_have_their_usual_symbols() {
    let bench = |area: &str, flow: &str| {
        let mut bench = Bench::new(&TANK.replace("0.1 m2", area).replace("6 l/min", flow));
        bench.write(0.0, "Q0", Value::Bool(true));
        bench.until(600.0, "half")
    };
    for (area, flow) in [("0.1 m2", "6 l/min"), ("0.1 m²", "6 L/min"), ("10 dm²", "0.36 m³/h")] {
        near(&bench(area, flow), &[(500.0, Value::Bool(true))]);
    }
}

const TANK: &str = r#"
channels = { level = { kind = "analog", unit = "m" }, full = { kind = "digital" }, half = { kind = "digital" } }
[[plants]]
kind = "tank"
name = "tank"
area = "0.1 m2"
height = "1 m"
inflows = [{ channel = "Q0", flow = "6 l/min" }]
outflows = [{ channel = "Q1", flow = "12 l/min" }]
output = "level"
sample = "100 s"
overflow = "full"
switches = [{ channel = "half", on-above = "50 cm", off-below = 0.25 }]
"#;

#[test]
fn a_tank_fills_overflows_and_empties() {
    // 6 l/min into 0.1 m2 is 1 mm in a second.
    let mut bench = Bench::new(TANK);
    bench.write(1.0, "Q0", ON);
    near(&bench.until(900.0, "half"), &[(501.0, ON)]);
    near(&bench.until(1_100.0, "full"), &[(1_001.0, ON)]);
    bench.write(1_100.0, "Q1", ON);
    near(&bench.until(1_100.5, "full"), &[(1_100.0, OFF)]);
    near(&bench.until(1_900.0, "half"), &[(1_850.0, OFF)]);
    bench.write(1_900.0, "Q0", OFF);
    let last = *bench.until(3_000.0, "level").last().unwrap();
    assert!(last.0 <= 2_100 * S && last.1 == Value::Real(0.0), "{last:?}");
    assert_eq!(bench.board.next_event(), None);
}

#[test]
fn a_full_tank_with_as_much_in_as_out_does_not_overflow() {
    // 0.1 + 0.2 is not 0.3 in binary: what is left is no flow.
    let text = TANK
        .replace(
            "flow = \"12 l/min\" }",
            "flow = \"0.1 l/min\" }, { channel = \"Q1\", flow = \"0.2 l/min\" }",
        )
        .replace("flow = \"6 l/min\"", "flow = \"0.3 l/min\"")
        .replace("sample", "initial = \"1 m\"\nsample");
    for first in ["Q0", "Q1"] {
        let mut bench = Bench::new(&text);
        bench.write(0.0, first, ON);
        let other = if first == "Q0" { "Q1" } else { "Q0" };
        bench.write(1e-9, other, ON);
        let overflowed = bench.until(10.0, "full");
        assert!(overflowed.last().is_none_or(|(_, level)| *level == OFF), "{first} {overflowed:?}");
    }
}

#[test]
fn an_outflow_by_its_own_weight_goes_with_the_root_of_the_level() {
    let text = TANK
        .replace(
            "{ channel = \"Q1\", flow = \"12 l/min\" }",
            "{ channel = \"Q1\", flow = \"6 l/min\", at-level = \"1 m\" }",
        )
        .replace("sample", "initial = \"1 m\"\nsample");
    let mut bench = Bench::new(&text);
    bench.write(0.0, "Q1", ON);
    // sqrt(h) = 1 - 0.0005 t.
    near(&bench.until(1_900.0, "half"), &[(0.0, ON), (1_000.0, OFF)][1..]);
    assert_eq!(bench.until(2_200.0, "level").last().unwrap().1, Value::Real(0.0));
}

/// A valve that opens fills a tank; a transmitter measures its level. All show a sample every ten seconds.
const NET: &str = r#"
[channels]
opening = { kind = "analog", unit = "%" }
level = { kind = "analog", unit = "m" }
signal = { kind = "analog", unit = "mA" }
float = { kind = "digital" }
[[plants]]
kind = "valve"
name = "valve"
input = "Q0"
travel = "10 s"
output = "opening"
sample = "10 s"
[[plants]]
kind = "tank"
name = "tank"
area = "0.1 m2"
height = "1 m"
inflows = [{ channel = "opening", flow = "6 l/min" }]
output = "level"
sample = "10 s"
switches = [{ channel = "float", on-above = "4 mm", off-below = 0.003 }]
[[plants]]
kind = "transmitter"
name = "transmitter"
input = "level"
output = "signal"
range = "0 .. 1 m"
signal = "4 .. 20 mA"
sample = "1 s"
"#;

#[test]
fn between_plants_nothing_is_lost_between_samples() {
    let mut bench = Bench::new(NET);
    bench.write(0.0, "Q0", ON);
    let mut events = Vec::new();
    bench.board.poll(at(30 * S), &mut events).unwrap();
    // While the valve opens the level is 1 mm/s t^2 / 20 s.
    near(&changes(&events, bench.file.find("float").unwrap().0), &[(80f64.sqrt(), ON)]);
    let signal = changes(&events, bench.file.find("signal").unwrap().0);
    assert_eq!(signal.len(), 30, "{signal:?}");
    for (at, value) in signal {
        let t = at as f64 / 1e9;
        let level = if t < 10.0 { 1e-3 * t * t / 20.0 } else { 0.005 + 1e-3 * (t - 10.0) };
        assert!((value.as_real().unwrap() - 4.0 - 16.0 * level).abs() < 1e-9, "{t} {value:?}");
    }
}

#[test]
fn a_valve_sticks_where_it_is() {
    let mut bench = Bench::new(NET);
    bench.write(0.0, "Q0", ON);
    bench.set(5.0, "stuck", 1.0);
    assert_eq!(bench.until(60.0, "opening").last().unwrap().1, Value::Real(50.0));
    bench.set(60.0, "stuck", 0.0);
    assert_eq!(bench.until(80.0, "opening").last().unwrap().1, Value::Real(100.0));
}

#[test]
fn a_transmitter_has_limits_and_errors() {
    let mut bench = Bench::new(
        r#"
channels = { level = { kind = "analog", unit = "m" }, signal = { kind = "analog", unit = "mA" } }
[[plants]]
kind = "transmitter"
name = "t"
input = "level"
output = "signal"
range = "0 .. 2 m"
signal = "4 .. 20 mA"
limits = "3.8 .. 20.5 mA"
sample = "1 s"
"#,
    );
    bench.write(1.0, "level", Value::Real(1.0));
    near(&bench.until(1.5, "signal"), &[(1.0, Value::Real(12.0))]);
    bench.write(2.0, "level", Value::Real(5.0));
    near(&bench.until(2.5, "signal"), &[(2.0, Value::Real(20.5))]);
    bench.write(3.0, "level", Value::Real(1.0));
    bench.set(4.0, "offset", 0.5);
    near(&bench.until(4.5, "signal"), &[(3.0, Value::Real(12.0)), (4.0, Value::Real(16.0))]);
    bench.set(5.0, "broken", 1.0);
    // Nobody drives the line: it reads 0.
    near(&bench.until(5.5, "signal"), &[(5.0, Value::Real(0.0))]);
    bench.set(6.0, "broken", 0.0);
    bench.set(6.0, "offset", 0.0);
    bench.until(6.5, "signal");
    bench.set(7.0, "drift", 0.001);
    let drifted = bench.until(107.0, "signal").last().unwrap().1.as_real().unwrap();
    assert!((drifted - 12.8).abs() < 1e-9, "{drifted}");
    bench.set(108.0, "drift", 0.0);
    bench.until(109.0, "signal");
    bench.set(110.0, "noise", 0.1);
    let noisy = bench.until(210.0, "signal");
    assert!(noisy.len() > 90);
    assert!(noisy.iter().all(|(_, value)| (value.as_real().unwrap() - 12.0).abs() <= 0.8), "{noisy:?}");
    bench.set(210.5, "noise", 0.0);
    assert_eq!(bench.until(300.0, "signal"), [(211 * S, Value::Real(12.0))]);
}

#[test]
fn a_valve_travels_to_its_set_point() {
    let mut bench = Bench::new(
        r#"
[channels]
setpoint = { kind = "analog", unit = "%" }
position = { kind = "analog", unit = "%" }
[[plants]]
kind = "valve"
name = "v"
input = "setpoint"
travel = "20 s"
initial = "10 %"
output = "position"
sample = "1 s"
opened = "I0"
closed = "I1"
reach = "5 %"
"#,
    );
    bench.write(0.0, "setpoint", Value::Real(60.0));
    assert_eq!(bench.until(5.0, "position").last(), Some(&(5 * S, Value::Real(35.0))));
    assert_eq!(bench.until(30.0, "position").last(), Some(&(10 * S, Value::Real(60.0))));
    bench.write(30.0, "setpoint", Value::Real(120.0));
    near(&bench.until(60.0, "I0"), &[(37.0, ON)]);
    bench.write(60.0, "setpoint", Value::Real(-5.0));
    near(&bench.until(90.0, "I1"), &[(79.0, ON)]);
    assert_eq!(bench.board.next_event(), None);
}

#[test]
fn a_cylinder_reaches_its_end_switches() {
    let mut bench = Bench::new(
        r#"
[[plants]]
kind = "cylinder"
name = "c"
input = "Q0"
extend-time = "2 s"
retract-time = "1 s"
extended = "I0"
retracted = "I1"
reach = "10 %"
"#,
    );
    bench.write(1.0, "Q0", ON);
    let mut events = Vec::new();
    bench.board.poll(at(5 * S), &mut events).unwrap();
    near(&changes(&events, bench.file.find("I1").unwrap().0), &[(1.2, OFF)]);
    near(&changes(&events, bench.file.find("I0").unwrap().0), &[(2.8, ON)]);
    bench.write(5.0, "Q0", OFF);
    near(&bench.until(5.5, "I0"), &[(5.1, OFF)]);
    near(&bench.until(9.0, "I1"), &[(5.9, ON)]);
}

#[test]
fn a_conveyor_carries_parts_past_its_eyes() {
    let mut bench = Bench::new(
        r#"
[[plants]]
kind = "conveyor"
name = "belt"
input = "Q0"
speed = "0.5 m/s"
length = "3 m"
part-length = "20 cm"
feed = "Q1"
eyes = [{ channel = "I0", at = "1 m" }]
"#,
    );
    bench.write(0.0, "Q0", ON);
    bench.write(1.0, "Q1", ON);
    bench.write(1.1, "Q1", OFF);
    bench.write(2.0, "Q0", OFF);
    bench.write(4.0, "Q0", ON);
    bench.write(4.5, "Q1", ON);
    near(&bench.until(20.0, "I0"), &[(5.0, ON), (5.4, OFF), (6.5, ON), (6.9, OFF)]);
    assert_eq!(bench.board.next_event(), None);
}

#[test]
fn a_motor_turns_an_encoder() {
    let mut bench = Bench::new(
        r#"
channels = { turns = { kind = "count", of = ["I0", "I1"], function = "quadrature-x4" } }
[[plants]]
kind = "motor"
name = "m"
input = "Q0"
reverse = "Q1"
speed = "600 rpm"
tau = "100 ms"
lines = 100
a = "I0"
b = "I1"
"#,
    );
    bench.write(0.0, "Q0", ON);
    // 4000 counts in a second, from the middle of count 0, with its first 100 ms behind.
    let counted = bench.until(1.0, "turns").last().unwrap().1;
    let angle = 0.5 + 4_000.0 * (1.0 - 0.1 * (1.0 - f64::exp(-10.0)));
    assert_eq!(counted, Value::Int(angle as i64));
    bench.write(1.0, "Q1", ON);
    let back = bench.until(3.0, "turns").last().unwrap().1;
    let (speed, left) = (1.0 - f64::exp(-10.0), 1.0 - f64::exp(-20.0));
    let angle = angle - 4_000.0 * (2.0 - 0.1 * (1.0 + speed) * left);
    assert_eq!(back, Value::Int(angle.floor() as i64));
}

#[test]
fn a_started_board_is_as_at_the_start() {
    let mut bench = Bench::new(TANK);
    bench.set(0.0, "leak", 1.0);
    bench.set(0.0, "inflow", 1.0);
    bench.board.start(at(0)).unwrap();
    bench.write(1.0, "Q0", ON);
    near(&bench.until(900.0, "half"), &[(0.0, OFF), (501.0, ON)]);
}

/// A response to 100 with a time constant of 1 s, of which parameters are set on its way.
fn response(kind: &str) -> Bench {
    let damping = if kind == "lag" { "" } else { "damping = 1" };
    Bench::new(&format!(
        r#"
channels = {{ y = {{ kind = "analog", unit = "degC" }}, warm = {{ kind = "digital" }} }}
[[plants]]
kind = "{kind}"
name = "p"
input = "Q0"
output = "y"
low = 0
high = 100
tau = "1 s"
{damping}
sample = "10 ms"
switches = [{{ channel = "warm", on-above = 80, off-below = 10 }}]
"#
    ))
}

#[test]
fn a_lag_goes_on_from_where_it_is_with_another_time_constant_and_target() {
    let mut bench = response("lag");
    bench.write(0.0, "Q0", ON);
    bench.set(1.0, "tau", 2.0);
    let at_1 = 100.0 * (1.0 - f64::exp(-1.0));
    let at_2 = 100.0 + (at_1 - 100.0) * f64::exp(-0.5);
    // The comparator flips by the new law: y is 80 at 1 + 2 ln((100 - y(1)) / 20).
    let warm = 1.0 + 2.0 * f64::ln((100.0 - at_1) / 20.0);
    let y = |bench: &mut Bench, seconds| bench.until(seconds, "y").last().unwrap().1.as_real().unwrap();
    assert!((y(&mut bench, 2.0) - at_2).abs() < 1e-9);
    bench.set(2.0, "high", 200.0);
    bench.set(2.0, "high", 100.0);
    near(&bench.until(3.0, "warm"), &[(warm, ON)]);
    bench.set(3.0, "high", 50.0);
    assert!((y(&mut bench, 200.0) - 50.0).abs() < 1e-9);
    bench.set(200.0, "low", 40.0);
    bench.write(300.0, "Q0", OFF);
    assert!((y(&mut bench, 500.0) - 40.0).abs() < 1e-9);
    bench.board.start(at(0)).unwrap();
    bench.write(0.0, "Q0", ON);
    assert!((y(&mut bench, 1.0) - at_1).abs() < 1e-9);
}

#[test]
fn a_response_of_second_order_goes_on_as_fast_as_it_moves() {
    let mut bench = response("second-order");
    bench.write(0.0, "Q0", ON);
    // 100 (1 - (1 + t) exp(-t)), with a slope of 100 t exp(-t).
    let (at_1, slope) = (100.0 * (1.0 - 2.0 * f64::exp(-1.0)), 100.0 * f64::exp(-1.0));
    bench.set(1.0, "tau", 0.5);
    let left = (at_1 - 100.0) + (slope + 2.0 * (at_1 - 100.0)) * 0.5;
    let found = bench.until(1.5, "y").last().unwrap().1.as_real().unwrap();
    assert!((found - (100.0 + left * f64::exp(-1.0))).abs() < 1e-9, "{found}");
    bench.set(2.0, "high", 10.0);
    let found = bench.until(100.0, "y").last().unwrap().1.as_real().unwrap();
    assert!((found - 10.0).abs() < 1e-9, "{found}");
    bench.board.start(at(0)).unwrap();
    bench.write(0.0, "Q0", ON);
    let found = bench.until(1.0, "y").last().unwrap().1.as_real().unwrap();
    assert!((found - at_1).abs() < 1e-9, "{found}");
}

#[test]
fn a_parameter_set_to_what_it_is_changes_nothing() {
    for (text, input) in [(TANK, "Q0"), (NET, "Q0")] {
        let mut plain = Bench::new(text);
        let mut set = Bench::new(text);
        for bench in [&mut plain, &mut set] {
            bench.write(1.0, input, ON);
        }
        for (place, spec) in set.file.circuit.plants.iter().enumerate() {
            for (at_place, parameter) in spec.parameters().iter().enumerate() {
                set.board.set_parameter(at(7 * S + 3), place, at_place, parameter.initial).unwrap();
            }
        }
        let rounded = |events: Vec<scanrig_drivers::BoardEvent>| -> Vec<String> {
            events.iter().map(|event| format!("{event:.9?}")).collect()
        };
        assert_eq!(rounded(poll(&mut *plain.board, 60 * S)), rounded(poll(&mut *set.board, 60 * S)));
    }
}

#[test]
fn a_damped_response_overshoots_and_a_heater_does_not() {
    let text = |kind: &str, more: &str| {
        format!(
            "channels = {{ y = {{ kind = \"analog\", unit = \"degC\" }} }}\n[[plants]]\nkind = \"{kind}\"\nname = \"p\"\n\
             input = \"Q0\"\noutput = \"y\"\nsample = \"10 ms\"\ntau = \"1 s\"\n{more}\n"
        )
    };
    let peak = |text: &str| {
        let mut bench = Bench::new(text);
        bench.write(0.0, "Q0", ON);
        let values = bench.until(100.0, "y");
        values.iter().map(|(_, value)| value.as_real().unwrap()).fold(0.0, f64::max)
    };
    let overshoot = peak(&text("second-order", "damping = 0.5\nlow = 0\nhigh = 100"));
    let exact = 100.0 + 100.0 * f64::exp(-0.5 * std::f64::consts::PI / 0.75f64.sqrt());
    assert!((overshoot - exact).abs() < 0.01, "{overshoot} {exact}");
    let heated = peak(&text("heater", "sensor-tau = \"200 ms\"\nambient = 20\nrise = 60"));
    assert!((79.99..=80.0).contains(&heated), "{heated}");
}

#[test]
fn dead_time_keeps_the_course() {
    let channel = "[channels]\nlate = { kind = \"analog\", unit = \"mA\" }";
    let pipe = "[[plants]]\nkind = \"dead-time\"\nname = \"pipe\"\ninput = \"signal\"\noutput = \"late\"\ndelay = \"2500 ms\"\n";
    let mut bench = Bench::new(&(NET.replace("[channels]", channel) + pipe));
    bench.write(0.0, "Q0", ON);
    let late = bench.until(12.6, "late");
    let (at, value) = *late.last().unwrap();
    assert_eq!(at, 12 * S + S / 2);
    assert!((value.as_real().unwrap() - 4.0 - 16.0 * 0.005).abs() < 1e-9, "{value:?}");
}

/// The parameters of every plant of the shipped boards, by its kind.
fn parameters_of_boards() -> BTreeSet<(String, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let folder = root.join("plans/library/plants");
    let files = std::fs::read_dir(folder).unwrap().map(|file| file.unwrap().path());
    let mut texts: Vec<String> = files
        .filter(|path| path.to_string_lossy().ends_with("-board.toml"))
        .map(|path| std::fs::read_to_string(path).unwrap())
        // Parameters of a program are its own.
        .filter(|text| !text.contains("kind = \"program\""))
        .collect();
    texts.push(std::fs::read_to_string(root.join("drivers/tests/bench.toml")).unwrap());
    // A response to a digital input, as that of `bench.toml` is of the other kind.
    let damped = response("second-order").file.circuit.plants[0].parameters();
    let mut found: BTreeSet<_> =
        damped.into_iter().map(|one| (String::from("second-order"), one.name)).collect();
    for text in texts {
        let kinds: Vec<String> = text
            .lines()
            .skip_while(|line| *line != "[[plants]]")
            .filter_map(|line| line.strip_prefix("kind = \"")?.strip_suffix('"').map(str::to_owned))
            .collect();
        let file = read(&SourceFile::new("b.toml", text), &terminals).unwrap();
        assert_eq!(kinds.len(), file.circuit.plants.len());
        for (kind, spec) in kinds.iter().zip(&file.circuit.plants) {
            for parameter in spec.parameters() {
                // Flows have names of their own.
                if kind != "tank" || parameter.name == "leak" {
                    found.insert((kind.clone(), parameter.name));
                }
            }
        }
    }
    found
}

#[test]
fn the_manual_lists_every_parameter() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/boards/plants.md");
    let text = std::fs::read_to_string(page).unwrap();
    let table = text.split_once("## Parameters").unwrap().1;
    let mut listed = BTreeSet::new();
    for row in table.lines().filter(|line| line.starts_with("| `")) {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        let coded =
            |cell: &str| -> Vec<String> { cell.split('`').skip(1).step_by(2).map(str::to_owned).collect() };
        for kind in coded(cells[1]) {
            listed.extend(coded(cells[2]).into_iter().map(|name| (kind.clone(), name)));
        }
    }
    assert_eq!(listed, parameters_of_boards());
}
