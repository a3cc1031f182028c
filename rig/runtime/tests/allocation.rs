//! The loop of a case allocates nothing: between two instants of modelled time, well after the start, the number of
//! allocations does not depend on how many cycles lie between them. What remains are the segments of the trace.

use crate::texts::Texts;
use scanrig_runtime::executor::clock::Clock;
use signal::Time;

const PROGRAM: &str = "PROGRAM MAIN
VAR
    beat AT %QX0.0 : BOOL;
    slow AT %QX0.4 : BOOL;
    back AT %IX0.0 : BOOL;
    count AT %MW100 : WORD;
    delay : TON;
    rise : R_TRIG;
    parts : CTU;
    n : DINT;
    history : ARRAY [0..7] OF DINT;
END_VAR
VAR RETAIN
    kept : DINT;
END_VAR
VAR PERSISTENT
    lasting : DINT;
END_VAR
n := n + 1;
beat := NOT beat;
history[n MOD 8] := n;
delay(IN := NOT delay.Q, PT := T#100ms);
IF delay.Q THEN
    slow := NOT slow;
    kept := kept + 1;
    lasting := kept;
END_IF;
rise(CLK := back);
parts(CU := rise.Q, RESET := parts.Q, PV := 5);
count := count + 1;
END_PROGRAM
";

const BOARD: &str = "format = 1
title = \"Outputs wired back to inputs\"
[board]
kind = \"simulated\"
[[wires]]
from = \"Q0\"
to = \"I0\"
[[wires]]
from = \"Q4\"
to = \"I1\"
delay = \"3 ms\"
bounce = { edges = 4, over = \"2 ms\" }
";

const PLAN: &str = "format = 1
title = \"Cycles without end\"
program = \"cycles.st\"
board = \"board.toml\"
signals = { beat = \"%QX0.0\", slow = \"%QX0.4\", back = \"%IX0.0\", bounced = \"%IX0.1\", n = \"MAIN.n\", word = \"%MW100\", kept = \"MAIN.kept\", done = \"MAIN.delay.Q\" }
ends = \"start + 230 s\"
expect = [
  { period = { signal = \"beat\", is = \"40 ms\", tolerance = \"1 ms\", from = \"start + 1 s\" } },
  { pulse = { signal = \"slow\", width = \"50 ms .. 200 ms\", which = \"every\", from = \"start + 1 s\" } },
  { edges = { signal = \"back\", rising = \"100 ..\" } },
  { state = { stays = \"RUNNING\", from = \"start\", until = \"end\" } },
]
invariants = [{ never = { signal = \"word\", min = 60_000 } }]
alarms = [
  { name = \"stuck\", when = { signal = \"slow\", is = true }, delay = \"150 ms\" },
  { name = \"often\", when = { signal = \"back\", is = true }, delay = \"5 ms\", ends = false },
]
";

/// Virtual time that notes the allocations up to each of its instants.
pub struct Noting {
    pub now: Time,
    pub at: [Time; 3],
    pub allocations: [Option<u64>; 3],
}

impl Clock for Noting {
    fn wait_until(&mut self, due: Time) -> Time {
        self.now = self.now.max(due);
        for (at, noted) in self.at.iter().zip(&mut self.allocations) {
            if noted.is_none() && self.now >= *at {
                *noted = Some(counting::of_this_thread());
            }
        }
        self.now
    }

    fn now(&mut self) -> Time {
        self.now
    }

    fn is_exact(&self) -> bool {
        true
    }

    fn name(&self) -> &'static str {
        "noting"
    }
}

/// Stimuli that go on for the whole case.
const WAVES: &str = "format = 1
title = \"Waves without end\"
program = \"cycles.st\"
board = \"board.toml\"
signals = { level = \"level\", noise = \"noise\", played = \"played\", line = \"%IX0.2\", a = \"%IX0.3\", b = \"%IX0.4\" }
ends = \"start + 230 s\"
steps = [
  { id = \"sine\", at = \"start\", sine = { signal = \"level\", range = \"-5 .. 5 V\", frequency = \"3 Hz\", sample = \"20 ms\" } },
  { id = \"noise\", at = \"start\", noise = { signal = \"noise\", range = \"0 .. 1 V\", deviation = \"0.1 V\", sample = \"20 ms\" } },
  { id = \"square\", at = \"start\", square = { signal = \"line\", frequency = \"7 Hz\", duty = \"10 %\" } },
  { id = \"encoder\", at = \"start\", encoder = { a = \"a\", b = \"b\", moves = { by = 23_000, speed = \"100 Hz\", ramp = \"1 s\" } } },
  { id = \"table\", at = \"start\", sequence = { file = \"table.csv\", columns = { p = \"played\" }, times = 500, interpolate = true, sample = \"20 ms\" } },
]
expect = [
  { stays = { signal = \"noise\", is = \"0 .. 1 V\" } },
  { edges = { signal = \"line\", rising = \"1_600 ..\" } },
  { edges = { signal = \"a\", rising = \"5_000 ..\" } },
]
";

const CHANNELS: &str = "[channels]
level = { kind = \"analog\", unit = \"V\" }
noise = { kind = \"analog\", unit = \"V\" }
played = { kind = \"analog\", unit = \"bar\" }
";

#[test]
fn cycles_allocate_nothing() {
    allocates_nothing(&[("plan.toml", PLAN), ("cycles.st", PROGRAM), ("board.toml", BOARD)]);
}

#[test]
fn waves_allocate_nothing() {
    let board = BOARD.replace("[[wires]]\nfrom = \"Q0\"", &format!("{CHANNELS}[[wires]]\nfrom = \"Q0\""));
    let table = "t [ms],p [bar]\n0,1\n300,2.5\n500,1\n";
    let files =
        [("plan.toml", WAVES), ("cycles.st", PROGRAM), ("board.toml", board.as_str()), ("table.csv", table)];
    allocates_nothing(&files);
}

/// A plant that times, counts and looks into a table, and a controller that answers it.
const PLANT: &str = "PROGRAM Plant
VAR_INPUT beat : BOOL; target : LREAL; END_VAR
VAR_OUTPUT back : BOOL; level : LREAL; END_VAR
VAR delay : TON; rise : R_TRIG; table : ARRAY [0..7] OF REAL; n : DINT; END_VAR
n := n + 1;
rise(CLK := beat);
IF rise.Q THEN table[n MOD 8] := LREAL_TO_REAL(SIN(target + DINT_TO_LREAL(n))); END_IF
delay(IN := beat, PT := T#5ms);
back := delay.Q;
level := table[(n + 1) MOD 8];
END_PROGRAM
";

#[test]
fn plants_in_structured_text_allocate_nothing() {
    let plant = "[channels]\nlevel = { kind = \"analog\" }\nset = { kind = \"analog\" }
[[plants]]\nkind = \"program\"\nname = \"plant\"\nprogram = \"plant.st\"\nperiod = \"3 ms\"
inputs = { beat = \"Q0\", target = \"set\" }\noutputs = { back = \"I5\", level = \"level\" }\n";
    let board = BOARD.replace("[[wires]]\nfrom = \"Q0\"", &format!("{plant}[[wires]]\nfrom = \"Q0\""));
    let files =
        [("plan.toml", PLAN), ("cycles.st", PROGRAM), ("board.toml", board.as_str()), ("plant.st", PLANT)];
    allocates_nothing(&files);
}

/// Square waves, pulses of an axis that goes to and fro, and a counter of the waves with reflex and threshold.
const FUNCTIONS: &str = "PROGRAM MAIN
VAR
    wave : PWM_M241;
    count : HSCMain_M241;
    power : MC_Power_PTO;
    there, back : MC_MoveRelative_PTO;
    go : BOOL;
END_VAR
wave(PWM_REF_IN := PWM0, Enable := TRUE, Frequency := 1000, Duty := 50);
count(HSC_REF_IN := HSC0, F_Enable := TRUE, EN_Compare := TRUE, EN_Out0 := TRUE);
power(Axis := PTO0, Enable := TRUE);
there(Axis := PTO0, Execute := go, Distance := 20, Velocity := 100, Acceleration := 10, Deceleration := 10);
back(Axis := PTO0, Execute := NOT go AND power.Status, Distance := -20, Velocity := 100, Acceleration := 10,
    Deceleration := 10);
IF there.Done OR there.Error THEN go := FALSE; END_IF;
IF back.Done OR back.Error THEN go := TRUE; END_IF;
END_PROGRAM
";

const OF_FUNCTIONS: &str = "format = 1
title = \"Expert functions without end\"
program = \"functions.st\"
board = \"board.toml\"
signals = { wave = \"%QX0.0\", back = \"%IX0.0\", a = \"%QX0.2\", reflex = \"%QX0.1\", value = \"HSC0.value\", at = \"PTO0.position\" }
ends = \"start + 230 s\"
expect = [{ edges = { signal = \"reflex\", rising = \"100 ..\" } }, { edges = { signal = \"a\", rising = \"100 ..\" } }]
[settings.expert]
HSC0 = { kind = \"main-single\", a = \"%IX0.0\", mode = \"modulo-loop\", modulo = 10, thresholds = [5], reflex0 = \"%QX0.1\", reflex0-zones = [1] }
PWM0 = { kind = \"pwm\", a = \"%QX0.0\" }
PTO0 = { kind = \"pto\", a = \"%QX0.2\", b = \"%QX0.3\" }
";

#[test]
fn expert_functions_allocate_nothing() {
    allocates_nothing(&[("plan.toml", OF_FUNCTIONS), ("functions.st", FUNCTIONS), ("board.toml", BOARD)]);
}

fn allocates_nothing(files: &[(&str, &str)]) {
    let second = |n: i64| Time::from_nanos(n * 1_000_000_000);
    let (mut model, mut parts) = Texts(files).parts(1);
    // 1 000 cycles of 20 ms, then 10 000.
    let mut clock =
        Noting { now: Time::ZERO, at: [second(10), second(30), second(230)], allocations: [None; 3] };
    let ran = parts.run(&mut clock, &mut model);
    assert_eq!(ran.fault, None);
    let changes = parts.recorder.trace().len();
    assert!(changes > 50_000, "only {changes} changes");
    let [Some(from), Some(between), Some(to)] = clock.allocations else { panic!("{:?}", clock.allocations) };
    let (few, many) = (between - from, to - between);
    println!("{few} allocations in 1 000 cycles, {many} in 10 000, {changes} changes");
    // A segment of the trace holds 64 KiB; a change takes some bytes of it.
    let segments = changes * 44 / (64 * 1024) + 1;
    assert!(few <= 4 * segments, "{few} allocations in 1 000 cycles");
    assert!(many <= few + 4 * segments, "{few} allocations in 1 000 cycles, {many} in 10 000");
}
