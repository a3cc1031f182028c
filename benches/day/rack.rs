//! The case of the rack: 14 modules, 7 of them remote, with 200 channels of which 40 are analogue, each of them at a plant.
//!
//! | module | what it is | what is there |
//! | --- | --- | --- |
//! | M1, M2 | TM3DI16 | float switches of the tanks of loops; contacts of valves and pumps |
//! | M3, M4 | TM3DQ16T | consumers of the loops, pumps and valves of the batches, heaters |
//! | M5 | TM3AI8 | levels of the loops |
//! | M6 | TM3AI8 | levels of the batches |
//! | M7 | TM3AQ4 | positioners of the loops |
//! | M10 | TM3DI32K | what the outputs of M11 do |
//! | M11 | TM3DQ32TK | fans of the lags, a running light |
//! | M12 | TM3DM32R | relays that count, and their contacts |
//! | M13 | TM3AI8 | lags |
//! | M14 | TM3TI4 | temperatures of four heaters |
//! | M15 | TM3AI4 | transmitters of four more |
//! | M16 | TM3AQ4 | positioners of the loops |

use std::fmt::Write as _;

const BOARD: &str = r#"
format = 1
title = "A rack of modules with tanks, heaters, lags and transmitters"
[subject]
kind = "model"
profile = "m241-2019"
reference = "TM241CEC24T"
[board]
kind = "simulated"
"#;

/// Level loops of reals, batches, heaters of two points, a running light, relays that count.
const PROGRAM: &str = r#"
FUNCTION_BLOCK LEVEL_LOOP
VAR_INPUT measured : INT; status : USINT; target : REAL; END_VAR
VAR_OUTPUT out : INT; END_VAR
VAR error, sum, command : REAL; END_VAR
IF status <> 0 THEN
    out := 0;
    RETURN;
END_IF;
error := target - INT_TO_REAL(measured);
sum := LIMIT(0.0, sum + error * 0.0016, 10000.0);
command := LIMIT(0.0, error * 2.0 + sum, 10000.0);
out := REAL_TO_INT(command);
END_FUNCTION_BLOCK

FUNCTION_BLOCK BATCH
VAR_INPUT measured : INT; END_VAR
VAR_OUTPUT fill, drain : BOOL; count : DINT; END_VAR
VAR step : INT; wait : TON; END_VAR
CASE step OF
    0: fill := TRUE;
       IF measured >= 8000 THEN fill := FALSE; step := 1; END_IF;
    1: wait(IN := TRUE, PT := T#10s);
       IF wait.Q THEN wait(IN := FALSE); step := 2; END_IF;
    2: drain := TRUE;
       IF measured <= 1000 THEN drain := FALSE; count := count + 1; step := 0; END_IF;
END_CASE;
END_FUNCTION_BLOCK

PROGRAM MAIN
VAR
    beat AT %QX0.0 : BOOL;
    slow AT %QX0.1 : BOOL;
    lights AT %QW9 : WORD;
    relays AT %QW10 : WORD;
    relays_back AT %IW32 : WORD;
    fans AT %QB16 : BYTE;
    fans_back AT %IB60 : BYTE;
    steady AT %QB17 : BYTE;
    floats AT %IW2 : WORD;
    contacts AT %IW3 : WORD;
    n, seconds, differs : DINT;
    most : INT;
    target : REAL := 4500.0;
"#;

/// Temperatures in tenths of a degree, and words of 4..20 mA for 0 to 200 degrees.
const BODY: &str = r#"
n := n + 1;
beat := NOT beat;
slow := (n / 50) MOD 2 = 0;
IF n MOD 50 = 0 THEN
    seconds := seconds + 1;
    relays := TO_WORD(seconds);
    IF seconds MOD 1800 = 0 THEN
        IF target > 5000.0 THEN target := 4500.0; ELSE target := 5500.0; END_IF;
    END_IF;
END_IF;
IF lights = 0 THEN lights := 1; END_IF;
IF n MOD 10 = 0 THEN lights := ROL(lights, 1); END_IF;
IF n MOD 500 = 0 THEN fans := NOT fans; END_IF;
steady := 16#A5;
IF fans <> fans_back OR relays <> relays_back THEN differs := differs + 1; END_IF;
"#;

/// The first word of %I of the levels of the loops and of the batches, of the lags, the sensors and the transmitters, and their
/// first status byte.
const LEVELS: (usize, usize) = (4, 24);
const BATCHES: (usize, usize) = (16, 48);
const LAGS: usize = 33;
const SENSORS: usize = 45;
const TRANSMITTERS: usize = 51;

/// The word of %Q of the positioner of a loop, and its channel.
fn positioner(n: usize) -> (usize, String) {
    if n < 4 { (4 + n, format!("M7.QW{n}")) } else { (11 + n - 4, format!("M16.QW{}", n - 4)) }
}

fn program() -> String {
    let mut text = PROGRAM.to_owned();
    let mut body = BODY.to_owned();
    // What is slow has its turn in each eighth cycle: a loop, a batch, a lag and a heater.
    body += "CASE n MOD 8 OF\n";
    for n in 0..8 {
        let _ = writeln!(text, "level{n} AT %IW{} : INT;", LEVELS.0 + n);
        let _ = writeln!(text, "status{n} AT %IB{} : USINT;", LEVELS.1 + n);
        let _ = writeln!(text, "valve{n} AT %QW{} : INT;", positioner(n).0);
        let _ = writeln!(text, "consumer{n} AT %QX4.{n} : BOOL;\ncycles{n} : INT;");
        let _ = writeln!(text, "loop{n} : LEVEL_LOOP;");
        let _ = writeln!(text, "amount{n} AT %IW{} : INT;", BATCHES.0 + n);
        let _ = writeln!(text, "pump{n} AT %QX5.{n} : BOOL;");
        let _ = writeln!(text, "outlet{n} AT %QX6.{n} : BOOL;");
        let _ = writeln!(text, "batch{n} : BATCH;");
        let _ = writeln!(text, "pressure{n} AT %IW{} : INT;", LAGS + n);
        let _ = writeln!(body, "{n}:");
        let target = n * 40;
        let _ = writeln!(
            body,
            "loop{n}(measured := level{n}, status := status{n}, target := target + {target}.0);"
        );
        let _ = writeln!(body, "valve{n} := loop{n}.out;");
        // Consumers come and go, each in a time of its own.
        let _ = writeln!(body, "cycles{n} := cycles{n} + 1;");
        let _ = writeln!(body, "IF cycles{n} >= {} THEN", 375 + 44 * n);
        let _ = writeln!(body, "    cycles{n} := 0; consumer{n} := NOT consumer{n};\nEND_IF;");
        let _ = writeln!(body, "batch{n}(measured := amount{n});");
        let _ = writeln!(body, "pump{n} := batch{n}.fill; outlet{n} := batch{n}.drain;");
        let _ = writeln!(body, "IF pressure{n} > most THEN most := pressure{n}; END_IF;");
        // Four heaters with sensors of their own, and four with transmitters.
        let (name, low, high) = if n < 4 {
            let _ = writeln!(text, "value{n} AT %IW{} : INT;", SENSORS + n);
            ("heater", 600 + 100 * n, 620 + 100 * n)
        } else {
            let _ = writeln!(text, "value{n} AT %IW{} : INT;", TRANSMITTERS + n - 4);
            ("oven", 4000, 4100)
        };
        let _ = writeln!(text, "{name}{n} AT %QX7.{n} : BOOL;");
        let _ = writeln!(body, "IF value{n} < {low} THEN {name}{n} := TRUE; END_IF;");
        let _ = writeln!(body, "IF value{n} > {high} THEN {name}{n} := FALSE; END_IF;");
    }
    text + "END_VAR\n" + &body + "END_CASE;\nEND_PROGRAM\n"
}

fn board() -> String {
    let mut text = String::from(BOARD);
    text += "[channels]\n";
    // What wires and plants are at has to be described.
    for (module, kind, count) in [
        (1, 'I', 16),
        (2, 'I', 16),
        (3, 'Q', 16),
        (4, 'Q', 16),
        (10, 'I', 32),
        (11, 'Q', 32),
        (12, 'I', 16),
        (12, 'Q', 16),
    ] {
        for n in 0..count {
            let _ = writeln!(text, "\"M{module}.{kind}{n}\" = {{ kind = \"digital\" }}");
        }
    }
    for (module, kind, count, unit) in [
        (5, 'I', 8, "mA"),
        (6, 'I', 8, "V"),
        (7, 'Q', 4, "V"),
        (13, 'I', 8, "V"),
        (14, 'I', 4, "degC"),
        (15, 'I', 4, "mA"),
        (16, 'Q', 4, "V"),
    ] {
        for n in 0..count {
            let _ = writeln!(text, "\"M{module}.{kind}W{n}\" = {{ kind = \"analog\", unit = \"{unit}\" }}");
        }
    }
    for n in 0..8 {
        let _ = writeln!(text, "open{n} = {{ kind = \"analog\", unit = \"%\" }}");
        let _ = writeln!(text, "level{n} = {{ kind = \"analog\", unit = \"m\" }}");
        let _ = writeln!(text, "amount{n} = {{ kind = \"analog\", unit = \"l\" }}");
    }
    for n in 0..4 {
        let _ = writeln!(text, "oven{n} = {{ kind = \"analog\", unit = \"degC\" }}");
    }
    for n in 0..8 {
        let _ = write!(
            text,
            r#"
[[plants]]
kind = "transmitter"
name = "positioner {n}"
input = "{position}"
output = "open{n}"
range = "0 .. 10 V"
signal = "0 .. 100 %"
sample = "100 ms"
[[plants]]
kind = "tank"
name = "tank {n}"
area = "0.5 m2"
height = "2 m"
initial = "1 m"
inflows = [{{ channel = "open{n}", flow = "60 l/min" }}]
outflows = [{{ flow = "15 l/min", at-level = "1 m" }}, {{ channel = "M3.Q{n}", flow = "10 l/min" }}]
output = "level{n}"
sample = "100 ms"
switches = [
  {{ channel = "M1.I{low}", on-above = "30 cm", off-below = "29 cm" }},
  {{ channel = "M1.I{high}", on-above = "1.8 m", off-below = "1.79 m" }},
]
[[plants]]
kind = "transmitter"
name = "level {n}"
input = "level{n}"
output = "M5.IW{n}"
range = "0 .. 2 m"
signal = "4 .. 20 mA"
limits = "3.8 .. 20.5 mA"
sample = "100 ms"
[[plants]]
kind = "tank"
name = "batch {n}"
area = "0.1 m2"
height = "1 m"
inflows = [{{ channel = "M3.Q{pump}", flow = "{fill} l/min" }}]
outflows = [{{ channel = "M4.Q{n}", flow = "{drain} l/min" }}]
output = "amount{n}"
sample = "100 ms"
[[plants]]
kind = "transmitter"
name = "amount {n}"
input = "amount{n}"
output = "M6.IW{n}"
range = "0 .. 100 l"
signal = "0 .. 10 V"
sample = "100 ms"
[[plants]]
kind = "lag"
name = "lag {n}"
input = "M11.Q{n}"
output = "M13.IW{n}"
low = "1 V"
high = "9 V"
tau = "{tau} s"
sample = "100 ms"
"#,
            position = positioner(n).1,
            low = 2 * n,
            high = 2 * n + 1,
            pump = 8 + n,
            fill = 20 + n,
            drain = 30 - n,
            tau = 2 + n,
        );
    }
    for n in 0..4 {
        let _ = write!(
            text,
            r#"
[[plants]]
kind = "heater"
name = "heater {n}"
input = "M4.Q{first}"
output = "M14.IW{n}"
ambient = "20 degC"
rise = "150 degC"
tau = "120 s"
sensor-tau = "{tau} s"
sample = "100 ms"
[[plants]]
kind = "heater"
name = "oven {n}"
input = "M4.Q{second}"
output = "oven{n}"
ambient = "20 degC"
rise = "150 degC"
tau = "200 s"
sensor-tau = "{tau} s"
sample = "100 ms"
[[plants]]
kind = "transmitter"
name = "oven {n}"
input = "oven{n}"
output = "M15.IW{n}"
range = "0 .. 200 degC"
signal = "4 .. 20 mA"
sample = "100 ms"
"#,
            first = 8 + n,
            second = 12 + n,
            tau = 5 + n,
        );
    }
    for n in 0..32 {
        let _ = write!(text, "[[wires]]\nfrom = \"M11.Q{n}\"\nto = \"M10.I{n}\"\n");
    }
    for n in 0..16 {
        let _ = write!(text, "[[wires]]\nfrom = \"M12.Q{n}\"\nto = \"M12.I{n}\"\n");
        let _ = write!(text, "[[wires]]\nfrom = \"M3.Q{n}\"\nto = \"M2.I{n}\"\ndelay = \"5 ms\"\n");
    }
    let _ = write!(text, "[[wires]]\nfrom = \"Q0\"\nto = \"I0\"\n[[wires]]\nfrom = \"Q1\"\nto = \"I1\"\n");
    text
}

/// So many channels in the same mode.
fn channels(count: usize, mode: &str) -> String {
    vec![format!("{{ mode = \"{mode}\", min = 0, max = 10000 }}"); count].join(", ")
}

fn plan(seconds: u64) -> String {
    let mut text = String::from(
        "format = 1\ntitle = \"A day of a rack\"\nprogram = \"rack.st\"\nboard = \"board.toml\"\n",
    );
    let _ = writeln!(text, "ends = \"start + {seconds} s\"\ntimeout = \"{} s\"", seconds + 60);
    text += "settings = { mast = { interval = \"20 ms\" }, modules = [\n";
    let sensors = ["\"PT100\""; 4].join(", ");
    for module in [
        "\"TM3DI16\"".to_owned(),
        "\"TM3DI16\"".to_owned(),
        "\"TM3DQ16T\"".to_owned(),
        "\"TM3DQ16T\"".to_owned(),
        format!("{{ type = \"TM3AI8\", inputs = [{}] }}", channels(8, "4..20 mA")),
        format!("{{ type = \"TM3AI8\", inputs = [{}] }}", channels(8, "0..10 V")),
        format!("{{ type = \"TM3AQ4\", outputs = [{}] }}", channels(4, "0..10 V")),
        "\"TM3XTRA1\"".to_owned(),
        "\"TM3XREC1\"".to_owned(),
        "\"TM3DI32K\"".to_owned(),
        "\"TM3DQ32TK\"".to_owned(),
        "\"TM3DM32R\"".to_owned(),
        format!("{{ type = \"TM3AI8\", inputs = [{}] }}", channels(8, "0..10 V")),
        format!("{{ type = \"TM3TI4\", inputs = [{sensors}] }}"),
        format!("{{ type = \"TM3AI4\", inputs = [{}] }}", channels(4, "4..20 mA")),
        format!("{{ type = \"TM3AQ4\", outputs = [{}] }}", channels(4, "0..10 V")),
    ] {
        let _ = writeln!(text, "  {module},");
    }
    text += "] }\n[signals]\nbeat = \"%QX0.0\"\nback = \"%IX0.0\"\nslow = \"%QX0.1\"\n";
    for n in 0..8 {
        let _ = writeln!(text, "level{n} = {{ channel = \"level{n}\" }}");
        let _ = writeln!(text, "low{n} = {{ channel = \"M1.I{}\" }}", 2 * n);
        let _ = writeln!(text, "high{n} = {{ channel = \"M1.I{}\" }}", 2 * n + 1);
        let _ = writeln!(text, "pump{n} = {{ channel = \"M3.Q{}\" }}", 8 + n);
        let _ = writeln!(text, "outlet{n} = {{ channel = \"M4.Q{n}\" }}");
        let _ = writeln!(text, "contact{n} = {{ channel = \"M2.I{}\" }}", 8 + n);
        let _ = writeln!(text, "fan{n} = {{ channel = \"M10.I{n}\" }}");
        let _ = writeln!(text, "light{n} = {{ channel = \"M10.I{}\" }}", 16 + n);
        let _ = writeln!(text, "relay{n} = {{ channel = \"M12.I{n}\" }}");
    }
    for n in 0..4 {
        let _ = writeln!(text, "heater{n} = {{ channel = \"M4.Q{}\" }}", 8 + n);
        let _ = writeln!(text, "oven{n} = {{ channel = \"M4.Q{}\" }}", 12 + n);
    }
    let beats = seconds * 25;
    let mut claims = vec![
        "state = { stays = \"RUNNING\", from = \"start\", until = \"end\" }".to_owned(),
        "period = { signal = \"back\", is = \"40 ms\", tolerance = \"0.2 ms\", from = \"start + 1 s\" }"
            .to_owned(),
        "period = { signal = \"slow\", is = \"2 s\", tolerance = \"0.2 ms\", from = \"start + 3 s\" }"
            .to_owned(),
        format!("edges = {{ signal = \"beat\", rising = \"{} .. {}\" }}", beats - 2, beats + 2),
    ];
    for n in 0..8 {
        claims.push(format!("stays = {{ signal = \"level{n}\", is = \"0.7 .. 1.3 m\" }}"));
        claims.push(format!("never = {{ signal = \"high{n}\" }}"));
        claims.push(format!("stays = {{ signal = \"low{n}\", is = true, from = \"start + 1 s\" }}"));
        claims.push(format!("never = {{ all = [\"pump{n}\", \"outlet{n}\"] }}"));
        claims
            .push(format!("edges = {{ signal = \"pump{n}\", rising = \"{} ..\" }}", (seconds / 600).max(1)));
        claims.push(format!(
            "edges = {{ signal = \"contact{n}\", rising = \"{} ..\" }}",
            (seconds / 600).max(1)
        ));
        claims.push(format!(
            "period = {{ signal = \"fan{n}\", is = \"20 s\", tolerance = \"0.2 ms\", from = \"start + 20 s\" }}"
        ));
        claims.push(format!(
            "period = {{ signal = \"light{n}\", is = \"3.2 s\", tolerance = \"0.2 ms\", from = \"start + 5 s\" }}"
        ));
    }
    for n in 0..4 {
        claims.push(format!(
            "edges = {{ signal = \"heater{n}\", rising = \"{} ..\" }}",
            (seconds / 600).max(1)
        ));
        claims
            .push(format!("edges = {{ signal = \"oven{n}\", rising = \"{} ..\" }}", (seconds / 600).max(1)));
    }
    claims.push("edges = { signal = \"relay0\", rising = \"1 ..\" }".to_owned());
    for claim in claims {
        let _ = writeln!(text, "[[expect]]\n{claim}");
    }
    text
}

/// The files of the case of so many seconds.
pub fn files(seconds: u64) -> Vec<(&'static str, String)> {
    vec![("plan.toml", plan(seconds)), ("rack.st", program()), ("board.toml", board())]
}
