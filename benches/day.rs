//! A day of a controller in seconds: 24 hours of a MAST of 20 ms with every terminal recorded and thirty claims.
//!
//! `cargo bench -p scanrig-runtime --bench day` runs an hour and three times a day, each in a process of its own, and
//! compares the day of middle length with the goals; `-- --quick` runs the hour alone. The exit code is 1 where a goal is missed. Time is that of
//! the processor: a busy host makes the wall's longer. `-- --seconds N` is one run for a profiler.

use scanrig_runtime::case::jobs::{JobResult, run};
use scanrig_runtime::suite::{FileSource, load_plan};
use scanrig_runtime::{ClockKind, RunOptions};
use std::fmt::Write as _;
use std::process::{Command, ExitCode};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Goals for the day: time on one core, recorded changes, memory above start, growth in percent from the hour to the day.
const MOST_SECONDS: f64 = 10.0;
const LEAST_CHANGES: u64 = 10_000_000;
const MOST_KILOBYTES: u64 = 64 << 10;
const MOST_GROWTH: f64 = 5.0;

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

/// The board file with its wires: `Qn` to `In`, and the first four to I10 to I13 behind a contactor's delay.
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

/// The files of the bench: nothing is on disk.
struct InMemory {
    seconds: u64,
}

impl FileSource for InMemory {
    fn read(&self, path: &str) -> Result<String, String> {
        match path {
            "day.toml" => Ok(plan(self.seconds)),
            "day.st" => Ok(PROGRAM.to_owned()),
            "board.toml" => Ok(board()),
            _ => Err("the bench has no such file".to_owned()),
        }
    }
}

/// A figure of /proc/self/status in kilobytes; 0 where the system has none.
fn kilobytes(name: &str) -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix(name));
    line.and_then(|line| line.trim_start_matches(':').split_whitespace().next()?.parse().ok()).unwrap_or(0)
}

/// Processor time of all threads of this process, user and system; ticks of /proc are hundredths of a second.
fn processor_seconds() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    let mut fields = stat.rsplit_once(')')?.1.split_whitespace().skip(11);
    let user: f64 = fields.next()?.parse().ok()?;
    let system: f64 = fields.next()?.parse().ok()?;
    Some((user + system) / 100.0)
}

/// What one run took.
#[derive(Clone, Debug, Default)]
struct Figures {
    /// Of the wall, and of the processor.
    wall: f64,
    busy: f64,
    changes: u64,
    scans: u64,
    /// Kilobytes resident at the start, and at most.
    start: u64,
    peak: u64,
    passed: bool,
}

impl Figures {
    /// Peak above start.
    fn above(&self) -> u64 {
        self.peak.saturating_sub(self.start)
    }

    fn line(&self) -> String {
        let Figures { wall, busy, changes, scans, start, peak, passed } = self;
        format!("{wall} {busy} {changes} {scans} {start} {peak} {passed}")
    }

    fn parse(text: &str) -> Option<Figures> {
        let line = text.lines().find_map(|line| line.strip_prefix("figures "))?;
        let mut words = line.split_whitespace();
        Some(Figures {
            wall: words.next()?.parse().ok()?,
            busy: words.next()?.parse().ok()?,
            changes: words.next()?.parse().ok()?,
            scans: words.next()?.parse().ok()?,
            start: words.next()?.parse().ok()?,
            peak: words.next()?.parse().ok()?,
            passed: words.next()?.parse().ok()?,
        })
    }

    fn print(&self, what: &str) {
        let each = self.busy * 1e9 / self.scans.max(1) as f64;
        println!(
            "{what}: {:.2} s of the processor, {:.2} s of the wall, {each:.0} ns a scan",
            self.busy, self.wall
        );
        println!("{what}: {} changes, {} scans", self.changes, self.scans);
        println!(
            "{what}: {} kB at the start, {} kB at most: {} kB above",
            self.start,
            self.peak,
            self.above()
        );
        println!("{what}: verdict {}", if self.passed { "pass" } else { "NOT pass" });
    }
}

/// Runs the case of so many modelled seconds in this process.
fn measure(seconds: u64) -> Result<Figures, String> {
    let start = kilobytes("VmRSS");
    let (began, spent) = (Instant::now(), processor_seconds());
    let mut sources = Vec::new();
    let found =
        |found: &[document::Diagnostic]| found.iter().map(|one| format!("{one:?}\n")).collect::<String>();
    let files = InMemory { seconds };
    let loaded = load_plan(&files, "day.toml", None, &[], 1, &mut sources).map_err(|list| found(&list))?;
    let jobs = loaded.jobs(0, 1, 1);
    let interrupt = AtomicBool::new(false);
    let options = RunOptions::new(ClockKind::Virtual, &interrupt);
    let mut figures = Figures { start, ..Figures::default() };
    let mut trouble = String::new();
    run(&[loaded], &jobs, 1, false, &options, &mut |_, done| match done {
        JobResult::Case(result) => {
            let record = &result.record;
            figures.passed = record.verdict == record::Verdict::Pass;
            for claim in record.claims.iter().filter(|claim| claim.verdict != record::Verdict::Pass) {
                println!("{:?}: {}: {} ({})", claim.verdict, claim.expected, claim.observed, claim.reason);
            }
            if !record.reason.is_empty() {
                println!("{}", record.reason);
            }
            figures.scans = record.tasks.iter().map(|task| task.cycles).sum();
            figures.changes = result.trace.as_ref().map_or(0, signal::Trace::len);
        }
        JobResult::Findings(list) => trouble = found(&list),
        JobResult::Skipped(_) => trouble = "the case was skipped".to_owned(),
    });
    figures.wall = began.elapsed().as_secs_f64();
    figures.busy = processor_seconds().zip(spent).map_or(figures.wall, |(now, then)| now - then);
    figures.peak = kilobytes("VmHWM");
    if trouble.is_empty() { Ok(figures) } else { Err(trouble) }
}

/// Runs the case in a process of its own, so that its peak of memory is its own.
fn measure_apart(hours: u64) -> Result<Figures, String> {
    let program = std::env::current_exe().map_err(|error| error.to_string())?;
    let seconds = (hours * 3600).to_string();
    let output = Command::new(program)
        .args(["--seconds", &seconds])
        .output()
        .map_err(|error| format!("the bench cannot start itself: {error}"))?;
    let text = String::from_utf8_lossy(&output.stdout);
    for line in text.lines().filter(|line| !line.starts_with("figures ")) {
        println!("{line}");
    }
    let figures =
        Figures::parse(&text).ok_or_else(|| String::from_utf8_lossy(&output.stderr).into_owned())?;
    figures.print(&format!("{hours:2} h"));
    Ok(figures)
}

fn goal(met: bool, words: &str) -> bool {
    println!("{} {words}", if met { "met   " } else { "MISSED" });
    met
}

fn bench(quick: bool) -> Result<bool, String> {
    let hour = measure_apart(1)?;
    if quick {
        return Ok(goal(hour.passed, "verdict pass"));
    }
    let mut days = [measure_apart(24)?, measure_apart(24)?, measure_apart(24)?];
    days.sort_by(|a, b| a.busy.total_cmp(&b.busy));
    let [_, day, _] = days;
    let growth = (day.peak as f64 / hour.peak.max(1) as f64 - 1.0) * 100.0;
    let met = [
        goal(hour.passed && day.passed, "verdict pass"),
        goal(day.busy < MOST_SECONDS, &format!("24 h in less than {MOST_SECONDS} s of one core")),
        goal(day.changes >= LEAST_CHANGES, &format!("at least {LEAST_CHANGES} changes")),
        goal(day.above() <= MOST_KILOBYTES, &format!("at most {MOST_KILOBYTES} kB above start")),
        goal(
            growth <= MOST_GROWTH,
            &format!("peak grows by {growth:.1} % from 1 h to 24 h, at most {MOST_GROWTH} %"),
        ),
    ];
    Ok(met.iter().all(|met| *met))
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().collect();
    let seconds = arguments.iter().position(|argument| argument == "--seconds");
    let outcome = match seconds.and_then(|at| arguments.get(at + 1)?.parse().ok()) {
        Some(seconds) => measure(seconds).map(|figures| {
            println!("figures {}", figures.line());
            true
        }),
        None => bench(arguments.iter().any(|argument| argument == "--quick")),
    };
    match outcome {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}
