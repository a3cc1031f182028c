//! Host time of modelled operations, for looking at: `cargo run --release --example speed`.

use document::SourceFile;
use scanrig_program::{Host, Machine, Options, StopReason, compile};
use signal::{Address, Span, Time};
use std::sync::Arc;
use std::time::Instant;

struct Nothing;

impl Host for Nothing {
    fn load(&mut self, _: Address) -> u64 {
        1
    }
    fn store(&mut self, _: Address, _: u64, _: u16, _: u32) -> bool {
        false
    }
}

fn main() {
    let bodies = [
        ("arithmetic", "n := n + m * 3 - k; m := m XOR n; k := k + 1;"),
        ("logic", "a := b AND NOT c OR d; b := a XOR c; IF a THEN c := NOT c; ELSE d := b; END_IF;"),
        ("loop", "FOR i := 1 TO 10 DO n := n + i; END_FOR;"),
        ("timers", "t1(IN := a, PT := T#5s); t2(IN := t1.Q, PT := T#1s);"),
        ("images", "%QX0.1 := %IX0.0 AND a; %MW5 := %IW2;"),
    ];
    for (name, body) in bodies {
        let text = format!(
            "PROGRAM MAIN VAR n, m, k, i : DINT; a, b, c, d : BOOL; t1, t2 : TON; END_VAR {} END_PROGRAM",
            body.repeat(20)
        );
        let source = SourceFile { name: "speed.st".into(), text };
        let Ok(program) = compile(&[source], &Options::default()) else { panic!("{name} does not compile") };
        let Ok(mut machine) = Machine::new(Arc::new(program), &[vec![0]]) else { panic!("no machine") };
        let mut operations = 0u64;
        let start = Instant::now();
        let mut modelled = 0;
        for _ in 0..20_000 {
            machine.begin(0);
            let slice = machine.resume(0, Time::ZERO, Span::from_secs(1), &mut Nothing);
            assert_eq!(slice.stop, StopReason::Done);
            modelled += slice.used.as_nanos();
            operations += 20;
        }
        let host = start.elapsed().as_nanos() as f64;
        println!(
            "{name:12} {:8.1} ns a body, modelled {:8} ns",
            host / operations as f64,
            modelled / operations as i64
        );
    }
}
