//! How fast Structured Text compiles: an application of 30,000 lines, whole, several times; the goal is a median
//! below 300 ms.

use document::SourceFile;
use scanrig_program::{Options, compile};
use std::fmt::Write;
use std::hint::black_box;
use std::time::Instant;

const LINES: usize = 30_000;
const RUNS: usize = 15;

/// Blocks, functions and structures of every kind, numbered, with what calls them.
fn source() -> String {
    let mut text = String::new();
    let mut calls = String::new();
    let mut variables = String::new();
    let mut unit = 0;
    while text.lines().count() + calls.lines().count() + variables.lines().count() < LINES {
        for _ in 0..20 {
            unit += 1;
            let _ = write!(
                text,
                "TYPE
  axis_{unit} : STRUCT
    position, speed : REAL;
    name : STRING(20) := 'axis {unit}';
    limits : ARRAY[0..1] OF DINT := [-{unit}, {unit}];
    state : (idle_{unit}, moving_{unit}, halted_{unit});
  END_STRUCT;
END_TYPE

FUNCTION scale_{unit} : REAL
VAR_INPUT raw : INT; low, high : REAL; END_VAR
VAR k : INT; END_VAR
  (* a value of an input as a number of the plant *)
  IF raw < 0 THEN
    scale_{unit} := low;
  ELSIF raw > 27648 THEN
    scale_{unit} := high;
  ELSE
    scale_{unit} := low + (high - low) * INT_TO_REAL(raw) / 27648.0;
  END_IF;
  FOR k := 1 TO 3 DO
    scale_{unit} := scale_{unit} + 0.5;
  END_FOR;
END_FUNCTION

FUNCTION_BLOCK drive_{unit}
VAR_INPUT enable : BOOL; target : DINT; END_VAR
VAR_OUTPUT busy : BOOL; error : WORD; END_VAR
VAR axis : axis_{unit}; delay : TON; last : DINT; text : STRING(40); END_VAR
  delay(IN := enable AND NOT busy, PT := T#20ms);
  CASE axis.state OF
    idle_{unit}:
      IF delay.Q THEN axis.state := moving_{unit}; busy := TRUE; END_IF;
    moving_{unit}:
      last := last + 1;
      axis.position := axis.position + axis.speed * 0.02;
      IF last >= LIMIT(axis.limits[0], target, axis.limits[1]) THEN
        axis.state := halted_{unit};
      END_IF;
  ELSE
    error := error OR SHL(WORD#1, 3);
    busy := FALSE;
  END_CASE;
  text := CONCAT('position ', DINT_TO_STRING(last));
  axis.speed := scale_{unit}(raw := DINT_TO_INT(last), low := 0.0, high := 10.0);
END_FUNCTION_BLOCK

"
            );
            let _ = writeln!(variables, "  d{unit} : drive_{unit};");
            let _ = writeln!(calls, "  d{unit}(enable := NOT d{unit}.busy, target := {unit});");
        }
    }
    let _ = write!(text, "PROGRAM MAIN\nVAR\n{variables}END_VAR\n{calls}END_PROGRAM\n");
    text
}

fn main() {
    let text = source();
    let lines = text.lines().count();
    let sources = [SourceFile { name: "plant.st".into(), text }];
    let mut times: Vec<f64> = (0..RUNS)
        .map(|_| {
            let start = Instant::now();
            let program = compile(black_box(&sources), &Options::default());
            let time = start.elapsed().as_secs_f64() * 1000.0;
            assert!(
                program.is_ok(),
                "{:#?}",
                program.err().map(|found| found.into_iter().take(3).collect::<Vec<_>>())
            );
            time
        })
        .collect();
    times.sort_by(f64::total_cmp);
    let (least, median, most) = (times[0], times[RUNS / 2], times[RUNS - 1]);
    println!("{lines} lines in {median:.0} ms ({least:.0} to {most:.0}, {RUNS} runs; goal 300 ms)");
}
