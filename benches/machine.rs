//! The machine beside native Rust: the same work in Structured Text and in Rust, as the ratio of their median times.
//!
//! `cargo bench -p scanrig-program --bench machine`; `-- NAME` runs one of them, for a profiler. The exit code is 1
//! where a loop on numbers takes more than [`MOST`] times the native time.

use document::SourceFile;
use scanrig_program::{Host, Machine, Options, StopReason, compile};
use signal::{Address, Span, Time, Value};
use std::hint::black_box;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

/// How much slower than native Rust loops on numbers may be.
const MOST: f64 = 8.0;
/// Times that each side runs, in turns.
const RUNS: usize = 41;

struct Nothing;

impl Host for Nothing {
    fn load(&mut self, _: Address) -> u64 {
        0
    }
    fn store(&mut self, _: Address, _: u64, _: u16, _: u32) -> bool {
        false
    }
}

struct Case {
    name: &'static str,
    source: &'static str,
    /// The same, and what `result` is afterwards.
    native: fn() -> i64,
    /// It counts for the goal.
    numbers: bool,
}

const CASES: [Case; 6] = [
    Case {
        name: "dint",
        // A sum, a largest value and a checksum of an array; the checksum keeps native code from doing several
        // elements at once, which no controller does.
        source: "PROGRAM MAIN
            VAR a : ARRAY[0..255] OF DINT; i, n, sum, most, check, result : DINT; END_VAR
            FOR i := 0 TO 255 DO a[i] := i * 7919 MOD 1009; END_FOR;
            check := 1; result := 0;
            FOR n := 1 TO 20 DO
                sum := 0; most := 0;
                FOR i := 0 TO 255 DO
                    sum := sum + a[i];
                    IF a[i] > most THEN most := a[i]; END_IF;
                    check := check * 31 + a[i];
                END_FOR;
                result := result + sum - most + check;
            END_FOR;
            END_PROGRAM",
        native: dint,
        numbers: true,
    },
    Case {
        name: "dint sort",
        // A generator of pseudo-random numbers and a sort by insertion.
        source: "PROGRAM MAIN
            VAR a : ARRAY[0..255] OF DINT; i, j, x, k, result : DINT; END_VAR
            x := 12345;
            FOR i := 0 TO 255 DO
                x := x * 1103515245 + 12345;
                a[i] := x / 65536 MOD 1000;
            END_FOR;
            FOR i := 1 TO 255 DO
                k := a[i];
                j := i - 1;
                WHILE j >= 0 AND_THEN a[j] > k DO
                    a[j + 1] := a[j];
                    j := j - 1;
                END_WHILE;
                a[j + 1] := k;
            END_FOR;
            result := a[0] + a[128] * 1000 + a[255];
            END_PROGRAM",
        native: dint_sort,
        numbers: true,
    },
    Case {
        name: "dint mod",
        // Primes by division.
        source: "PROGRAM MAIN
            VAR n, d, result : DINT; prime : BOOL; END_VAR
            result := 0;
            FOR n := 2 TO 2000 DO
                prime := TRUE;
                d := 2;
                WHILE d * d <= n AND prime DO
                    IF n MOD d = 0 THEN prime := FALSE; END_IF;
                    d := d + 1;
                END_WHILE;
                IF prime THEN result := result + 1; END_IF;
            END_FOR;
            END_PROGRAM",
        native: dint_mod,
        numbers: true,
    },
    Case {
        name: "real",
        // A controller with a first-order plant.
        source: "PROGRAM MAIN
            VAR i, result : DINT; y, error, sum, out : REAL; END_VAR
            y := 0.0; sum := 0.0;
            FOR i := 1 TO 5000 DO
                error := 100.0 - y;
                sum := sum + error * 0.01;
                out := error * 2.0 + sum * 0.5;
                IF out > 150.0 THEN out := 150.0; END_IF;
                y := y + (out - y) * 0.05;
            END_FOR;
            result := REAL_TO_DINT(y * 1000.0);
            END_PROGRAM",
        native: real,
        numbers: true,
    },
    Case {
        name: "blocks",
        source: "FUNCTION_BLOCK STAGE
            VAR_INPUT run : BOOL; END_VAR VAR_OUTPUT count : DINT; END_VAR VAR timer : TON; END_VAR
            timer(IN := run, PT := T#10s);
            IF NOT timer.Q THEN count := count + 1; END_IF;
            END_FUNCTION_BLOCK
            PROGRAM MAIN
            VAR s : ARRAY[0..9] OF STAGE; i, n, result : DINT; END_VAR
            FOR n := 1 TO 100 DO
                FOR i := 0 TO 9 DO s[i](run := TRUE); END_FOR;
            END_FOR;
            result := 0;
            END_PROGRAM",
        native: blocks,
        numbers: false,
    },
    Case {
        name: "strings",
        source: "PROGRAM MAIN
            VAR line : STRING[200]; i, result : DINT; END_VAR
            result := 0;
            FOR i := 1 TO 500 DO
                line := CONCAT('value ', DINT_TO_STRING(i));
                line := CONCAT(line, ' of ');
                line := CONCAT(line, '500');
                result := result + LEN(line);
            END_FOR;
            END_PROGRAM",
        native: strings,
        numbers: false,
    },
];

fn dint() -> i64 {
    let mut a = [0i32; 256];
    for (value, i) in a.iter_mut().zip(black_box(0i32)..) {
        *value = i * 7919 % 1009;
    }
    let (mut check, mut result) = (1i32, 0i32);
    for _ in 0..black_box(20) {
        let (mut sum, mut most) = (0i32, 0i32);
        for value in a {
            sum = sum.wrapping_add(value);
            if value > most {
                most = value;
            }
            check = check.wrapping_mul(31).wrapping_add(value);
        }
        result = result.wrapping_add(sum).wrapping_sub(most).wrapping_add(check);
    }
    i64::from(result)
}

fn dint_sort() -> i64 {
    let mut a = [0i32; 256];
    let mut x = black_box(12345i32);
    for value in &mut a {
        x = x.wrapping_mul(1_103_515_245).wrapping_add(12345);
        *value = x / 65536 % 1000;
    }
    for i in 1..256i32 {
        let k = a[i as usize];
        let mut j = i - 1;
        while j >= 0 && a[j as usize] > k {
            a[(j + 1) as usize] = a[j as usize];
            j -= 1;
        }
        a[(j + 1) as usize] = k;
    }
    i64::from(a[0] + a[128] * 1000 + a[255])
}

fn dint_mod() -> i64 {
    let mut result = 0;
    for n in 2..=black_box(2000i32) {
        let mut prime = true;
        let mut d = 2;
        while d * d <= n && prime {
            if n % d == 0 {
                prime = false;
            }
            d += 1;
        }
        result += i64::from(prime);
    }
    result
}

fn real() -> i64 {
    let (mut y, mut sum) = (0.0f32, 0.0f32);
    for _ in 0..black_box(5000) {
        let error = 100.0 - y;
        sum += error * 0.01;
        let mut out = error * 2.0 + sum * 0.5;
        if out > 150.0 {
            out = 150.0;
        }
        y += (out - y) * 0.05;
    }
    (y * 1000.0).round_ties_even() as i64
}

#[derive(Clone, Copy, Default)]
struct Timer {
    running: bool,
    start: i64,
    q: bool,
    et: u32,
}

impl Timer {
    #[inline(never)]
    fn call(&mut self, on: bool, pt: u32, now: i64) {
        if !on {
            *self = Timer::default();
            return;
        }
        if !self.running {
            (self.running, self.start) = (true, now);
        }
        self.et = ((now - self.start) / 1_000_000).min(i64::from(pt)) as u32;
        self.q = self.et >= pt;
    }
}

#[derive(Clone, Copy, Default)]
struct Stage {
    timer: Timer,
    count: i32,
}

impl Stage {
    #[inline(never)]
    fn call(&mut self, run: bool, now: i64) {
        self.timer.call(run, 10_000, now);
        if !self.timer.q {
            self.count = self.count.wrapping_add(1);
        }
    }
}

fn blocks() -> i64 {
    let mut stages = [Stage::default(); 10];
    for now in 0..black_box(100) {
        for stage in &mut stages {
            stage.call(true, now);
        }
    }
    black_box(stages);
    0
}

fn strings() -> i64 {
    let mut result = 0;
    for i in 1..=black_box(500) {
        let mut line = format!("value {i}");
        line = format!("{line} of ");
        line = format!("{line}500");
        result += black_box(line).len() as i64;
    }
    result
}

fn median(times: &mut [f64]) -> f64 {
    times.sort_by(f64::total_cmp);
    times.get(times.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Nanoseconds of a cycle and of the native function, and the cycle's modelled time.
fn measure(case: &Case) -> Result<(f64, f64, i64), String> {
    let source = SourceFile { name: format!("{}.st", case.name), text: case.source.into() };
    let program = compile(&[source], &Options::default()).map_err(|findings| format!("{findings:?}"))?;
    let mut machine = Machine::new(Arc::new(program), &[vec![0]]).map_err(|error| error.to_string())?;
    let result = machine.find("MAIN.result").ok_or("no result")?;
    let (mut ours, mut native) = (Vec::new(), Vec::new());
    let mut modelled = 0;
    for _ in 0..RUNS {
        let start = Instant::now();
        machine.begin(0);
        let slice = machine.resume(0, Time::ZERO, Span::from_secs(1000), &mut Nothing);
        ours.push(start.elapsed().as_nanos() as f64);
        if slice.stop != StopReason::Done {
            return Err(format!("{:?}", slice.stop));
        }
        modelled = slice.used.as_nanos();
        let start = Instant::now();
        let expected = (case.native)();
        native.push(start.elapsed().as_nanos() as f64);
        if machine.read(result) != Value::Int(expected) {
            return Err(format!("{:?}, natively {expected}", machine.read(result)));
        }
    }
    Ok((median(&mut ours), median(&mut native), modelled))
}

fn main() -> ExitCode {
    let only = std::env::args().skip(1).find(|argument| !argument.starts_with('-'));
    let mut missed = false;
    println!("{:10} {:>12} {:>12} {:>7} {:>14}", "", "machine ns", "native ns", "ratio", "modelled ns");
    for case in CASES.iter().filter(|case| only.as_deref().is_none_or(|only| only == case.name)) {
        match measure(case) {
            Ok((ours, native, modelled)) => {
                let ratio = ours / native;
                missed |= case.numbers && ratio > MOST;
                println!("{:10} {ours:12.0} {native:12.0} {ratio:7.1} {modelled:14}", case.name);
            }
            Err(why) => {
                missed = true;
                println!("{:10} {why}", case.name);
            }
        }
    }
    if missed { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}
