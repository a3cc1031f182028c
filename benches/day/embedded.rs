//! The case of the day: a controller without modules, every terminal recorded, thirty claims.

use std::fmt::Write as _;

/// Every output goes back to an input; four of them to a second one.
const BOARD: &str = r#"
format = 1
title = "Outputs wired back to inputs"
[subject]
kind = "model"
profile = "m241-2019"
reference = "TM241CEC24T"
[board]
kind = "simulated"
"#;

/// A hundred statements; which branches run differs from cycle to cycle.
const PROGRAM: &str = r#"
PROGRAM MAIN
VAR
    beat AT %QX0.0 : BOOL;
    slow AT %QX0.1 : BOOL;
    fill AT %QX0.2 : BOOL;
    drain AT %QX0.3 : BOOL;
    motor AT %QX0.4 : BOOL;
    lamp AT %QX0.5 : BOOL;
    horn AT %QX0.6 : BOOL;
    valve AT %QX0.7 : BOOL;
    ready AT %QX1.0 : BOOL;
    alarm AT %QX1.1 : BOOL;
    beat_back AT %IX0.0 : BOOL;
    slow_back AT %IX0.1 : BOOL;
    fill_back AT %IX0.2 : BOOL;
    drain_back AT %IX0.3 : BOOL;
    motor_back AT %IX0.4 : BOOL;
    guard AT %IX1.5 : BOOL;
    n : DINT;
    ticks : INT;
    seconds : INT;
    minutes : INT;
    hours : DINT;
    level : INT;
    step : INT;
    i : INT;
    sum : DINT;
    mean : DINT;
    error : DINT;
    integral : DINT;
    command : DINT;
    speed : INT;
    target : INT;
    least : INT := 32767;
    most : INT;
    faults : INT;
    state : INT;
    crc : WORD;
    pattern : WORD := 16#0001;
    full, empty, half, moving, stalled, warned, late : BOOL;
    history : ARRAY [0..3] OF DINT;
    on_delay : TON;
    off_delay : TOF;
    pulse : TP;
    watch : TON;
    rise : R_TRIG;
    fall : F_TRIG;
    parts : CTU;
    latch : SR;
END_VAR
VAR RETAIN
    batches : DINT;
END_VAR

(* heartbeat and clock *)
n := n + 1;
beat := NOT beat;
slow := (n / 25) MOD 2 = 0;
ready := n > 10;
ticks := ticks + 1;
IF ticks >= 50 THEN
    ticks := 0;
    seconds := seconds + 1;
    IF seconds >= 60 THEN
        seconds := 0;
        minutes := minutes + 1;
        IF minutes >= 60 THEN
            minutes := 0;
            hours := hours + 1;
        END_IF;
    END_IF;
END_IF;

(* a tank that fills and drains *)
CASE step OF
    0:
        fill := TRUE;
        drain := FALSE;
        level := level + 3;
        IF level >= 300 THEN
            step := 1;
        END_IF;
    1:
        fill := FALSE;
        IF on_delay.Q THEN
            step := 2;
        END_IF;
    2:
        drain := TRUE;
        level := level - 5;
        IF level <= 0 THEN
            level := 0;
            step := 3;
        END_IF;
ELSE
    batches := batches + 1;
    step := 0;
END_CASE;
on_delay(IN := step = 1, PT := T#400ms);
full := level >= 290;
empty := level <= 10;
half := level > 140 AND level < 160;
least := MIN(least, level);
most := MAX(most, level);

(* feedback of the outputs *)
rise(CLK := slow_back);
fall(CLK := drain_back);
parts(CU := rise.Q, RESET := fall.Q, PV := 5);
latch(SET1 := rise.Q, RESET := parts.Q);
off_delay(IN := fill_back, PT := T#1s);
pulse(IN := fall.Q, PT := T#250ms);
motor := latch.Q1 OR off_delay.Q;
lamp := pulse.Q XOR slow_back;
horn := motor_back AND NOT fill_back AND drain_back;
moving := motor_back AND NOT empty;
watch(IN := motor AND NOT motor_back, PT := T#2s);
stalled := watch.Q OR stalled AND NOT ready;
IF stalled THEN
    faults := faults + 1;
END_IF;

(* a ramp *)
IF moving THEN
    target := 1500;
ELSE
    target := 300;
END_IF;
IF speed < target THEN
    speed := speed + 7;
ELSIF speed > target THEN
    speed := speed - 11;
END_IF;
IF ABS(speed - target) < 12 THEN
    speed := target;
END_IF;

(* a moving mean and a controller of integers *)
history[n MOD 4] := level;
sum := 0;
FOR i := 0 TO 3 DO
    sum := sum + history[i];
END_FOR;
mean := sum / 4;
error := 150 - mean;
integral := LIMIT(-1000, integral + error, 1000);
command := error * 4 + integral / 10;
valve := command > 0;

(* a little machine of states *)
CASE state OF
    0:
        IF full THEN
            state := 1;
        END_IF;
    1:
        IF half THEN
            state := 2;
        END_IF;
    2:
        warned := TRUE;
        IF empty THEN
            state := 3;
        END_IF;
ELSE
    warned := FALSE;
    state := 0;
END_CASE;
late := warned AND full;
IF late THEN
    faults := faults + 1;
END_IF;

(* registers that go round *)
pattern := ROL(pattern, 1);
IF pattern = 16#8000 THEN
    pattern := 16#0001;
END_IF;
crc := crc XOR pattern;
crc := SHL(crc, 1) OR SHR(crc, 15);
%MW1100 := pattern;
%MW1101 := %MW1101 + 1;
%MW1102 := crc;
%MD560 := n;

alarm := guard AND beat_back AND level > 400;
END_PROGRAM
"#;

const NAMES: [&str; 10] =
    ["beat", "slow", "fill", "drain", "motor", "lamp", "horn", "valve", "ready", "alarm"];

/// The board file with its wires: `Qn` to `In`, and the first four to I10 to I13 after a contactor's delay.
fn board() -> String {
    let mut text = String::from(BOARD);
    for n in 0..10 {
        let _ = write!(text, "[[wires]]\nfrom = \"Q{n}\"\nto = \"I{n}\"\n");
    }
    let _ = write!(text, "[[wires]]\nfrom = \"Q0\"\nto = \"I10\"\ninvert = true\n");
    let _ = write!(text, "[[wires]]\nfrom = \"Q1\"\nto = \"I11\"\ndelay = \"3 ms\"\n");
    let _ = write!(text, "[[wires]]\nfrom = \"Q2\"\nto = \"I12\"\ndelay = \"8 ms\"\n");
    let _ = write!(text, "[[wires]]\nfrom = \"Q9\"\nto = \"I13\"\n");
    text
}

/// The plan of so many seconds: all 24 channels as signals, thirty expectations.
fn plan(seconds: u64) -> String {
    let mut text =
        String::from("format = 1\ntitle = \"A day\"\nprogram = \"day.st\"\nboard = \"board.toml\"\n");
    let _ = writeln!(text, "ends = \"start + {seconds} s\"\ntimeout = \"{} s\"\n[signals]", seconds + 60);
    for (n, name) in NAMES.iter().enumerate() {
        let _ = writeln!(text, "{name} = \"%QX{}.{}\"", n / 8, n % 8);
    }
    for n in 0..14 {
        let _ = writeln!(text, "i{n} = \"%IX{}.{}\"", n / 8, n % 8);
    }
    let beats = seconds * 25;
    let claims = [
        "state = { stays = \"RUNNING\", from = \"start\", until = \"end\" }".to_owned(),
        "never = { signal = \"alarm\" }".to_owned(),
        "never = { signal = \"i9\" }".to_owned(),
        "never = { signal = \"i13\" }".to_owned(),
        "never = { all = [\"fill\", \"drain\"] }".to_owned(),
        "never = { all = [\"i2\", \"i3\"] }".to_owned(),
        "never = { all = [\"horn\", \"fill\"], pulses-longer-than = \"25 ms\" }".to_owned(),
        "never = { all = [\"beat\", \"i10\"] , pulses-longer-than = \"1 ms\" }".to_owned(),
        "stays = { signal = \"ready\", is = true, from = \"start + 1 s\" }".to_owned(),
        "stays = { signal = \"i8\", is = true, from = \"start + 1 s\" }".to_owned(),
        "stays = { signal = \"alarm\", is = false }".to_owned(),
        "period = { signal = \"beat\", is = \"40 ms\", tolerance = \"0.2 ms\", from = \"start + 1 s\" }".to_owned(),
        "period = { signal = \"i0\", is = \"40 ms\", tolerance = \"0.2 ms\", from = \"start + 1 s\" }".to_owned(),
        "period = { signal = \"i10\", edge = \"falls\", is = \"40 ms\", tolerance = \"0.2 ms\", from = \"start + 1 s\" }".to_owned(),
        "period = { signal = \"slow\", is = \"1 s\", tolerance = \"0.2 ms\", from = \"start + 2 s\" }".to_owned(),
        "period = { signal = \"i11\", is = \"1 s\", tolerance = \"0.2 ms\", from = \"start + 2 s\" }".to_owned(),
        "period = { signal = \"beat\", edge = \"changes\", is = \"19.8 ms .. 20.2 ms\", from = \"start + 1 s\" }".to_owned(),
        format!("edges = {{ signal = \"beat\", rising = \"{} .. {}\" }}", beats - 2, beats + 2),
        format!("edges = {{ signal = \"i0\", falling = \"{} .. {}\" }}", beats - 2, beats + 2),
        format!("edges = {{ signal = \"i10\", rising = \"{} .. {}\" }}", beats - 2, beats + 2),
        format!("edges = {{ signal = \"slow\", rising = \"{} .. {}\" }}", seconds - 2, seconds + 2),
        "edges = { signal = \"alarm\", rising = 0 }".to_owned(),
        format!("edges = {{ signal = \"fill\", rising = \"{0} ..\", falling = \"{0} ..\" }}", seconds / 5),
        "edges = { signal = \"motor\", rising = \"1 ..\" }".to_owned(),
        "pulse = { signal = \"beat\", width = \"19 ms .. 21 ms\", which = \"every\", from = \"start + 1 s\" }".to_owned(),
        format!("pulse = {{ signal = \"drain\", width = \"1 s .. 3 s\", which = \"every\", from = \"start + 10 s\", until = \"start + {} s\" }}", seconds - 10),
        "rises = { signal = \"slow\", from = \"start + 10 s\", within = \"1.1 s\" }".to_owned(),
        "falls = { signal = \"fill\", from = \"start + 10 s\", within = \"10 s\" }".to_owned(),
        format!("rises = {{ signal = \"i2\", from = \"start + {} s\", within = \"10 s\" }}", seconds - 20),
        "value = { of = \"ready\", is = true, when = \"end\" }".to_owned(),
    ];
    for claim in claims {
        let _ = writeln!(text, "[[expect]]\n{claim}");
    }
    text
}

/// The files of the case of so many seconds.
pub fn files(seconds: u64) -> Vec<(&'static str, String)> {
    vec![("plan.toml", plan(seconds)), ("day.st", PROGRAM.to_owned()), ("board.toml", board())]
}
