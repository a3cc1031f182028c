//! How long reading takes: `cargo test --release -p scanrig-program parse::tests::speed -- --ignored --nocapture`.

use super::super::{NameTable, parse};
use crate::findings::CompileFindings;
use document::SourceFile;
use std::fmt::Write;
use std::time::Instant;

/// A source of about `lines` lines of the usual kinds.
fn source(lines: usize) -> String {
    let mut text = String::new();
    for n in 0..lines / 30 {
        write!(
            text,
            "FUNCTION_BLOCK Station_{n}
VAR_INPUT
    enable, reset_request : BOOL;   (* from the operator *)
    set_point : LREAL := 12.5;
    mode : INT (0..5);
END_VAR
VAR_OUTPUT
    actual_value : LREAL;
    alarm_word : WORD;
END_VAR
VAR
    timer : TON := (PT := T#2s500ms);
    history : ARRAY[0..15] OF DINT;
    index, total_count : DINT;
    text : STRING(40) := 'station {n}';
END_VAR
timer(IN := enable AND NOT reset_request, PT := T#1m_30s, Q => alarm_word.3);
IF timer.Q AND (actual_value > set_point * 1.05 OR mode = 3) THEN
    alarm_word := alarm_word OR 16#00_FF;
    FOR index := 0 TO 15 DO
        history[index] := history[(index + 1) MOD 16] + REAL_TO_DINT(set_point / 3.0) - index * 2;
    END_FOR;
ELSIF reset_request THEN
    CASE mode OF
        0, 2..3: total_count := 0;
        1: total_count := total_count + SEL(enable, -1, 1); // count
    END_CASE;
END_IF;
text := CONCAT(text, DINT_TO_STRING(total_count));
END_FUNCTION_BLOCK
"
        )
        .unwrap();
    }
    text
}

#[test]
#[ignore = "a measurement"]
fn thirty_thousand_lines() {
    let sources = [SourceFile::new("large.st", source(30_000))];
    for _ in 0..7 {
        let mut names = NameTable::new();
        let mut findings = CompileFindings::new(&sources, 50);
        let start = Instant::now();
        let unit = parse(&sources, sources.len(), &mut names, &mut findings);
        let reading = start.elapsed();
        assert!(!findings.failed() && unit.pous.len() == 1000);
        let lines = sources[0].text.lines().count();
        println!("{lines} lines, {} bytes: {reading:?}", sources[0].text.len());
    }
}
