//! Random programs against an evaluator of its own (evaluator.rs), which walks the tree: values, faults and modelled
//! time, with literals and with variables in their place, so that what the compiler computes changes nothing.

mod evaluator;
mod tree;

use crate::support::{Memory, sources};
use evaluator::Walk;
use proptest::prelude::*;
use scanrig_program::{Machine, Options, StopReason, compile};
use signal::{Span, Time, Value};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::Arc;
use tree::{Maker, Random, S, TYPES, V, Writer};

/// Two variables, an array and a function of every type.
fn text(body: &[S], first: &[(V, V)], counters: &[String], literals: bool) -> String {
    let mut writer = Writer { text: String::new(), names: (!literals).then(Vec::new) };
    writer.block(body);
    let mut text = String::from("VAR_GLOBAL\n");
    for (ty, (a, b)) in TYPES.into_iter().zip(first) {
        let name = ty.name();
        let mut initial = Writer { text: String::new(), names: None };
        for (nth, v) in [(1, a), (2, b)] {
            write!(initial.text, "v{nth}_{name} : {name} := ").unwrap();
            initial.literal(ty, *v);
            initial.text += ";\n";
        }
        writeln!(text, "{} a_{name} : ARRAY[-2..2] OF {name};", initial.text).unwrap();
    }
    for counter in counters {
        writeln!(text, "{counter} : {};", counter.split_once('_').unwrap().1).unwrap();
    }
    for name in writer.names.unwrap_or_default() {
        writeln!(text, "{name}").unwrap();
    }
    text.push_str("END_VAR\n");
    for ty in TYPES {
        let name = ty.name();
        // A TIME takes no XOR.
        let op = if ty.is_real() || ty.is_duration() { "-" } else { "XOR" };
        writeln!(
            text,
            "FUNCTION side_{name} : {name} VAR_INPUT x : {name}; END_VAR v1_{name} := v1_{name} {op} x; side_{name} := v1_{name}; END_FUNCTION"
        )
        .unwrap();
    }
    write!(text, "PROGRAM MAIN\n{}END_PROGRAM\n", writer.text).unwrap();
    text
}

fn same(v: V, found: Value) -> bool {
    match (v, found) {
        (V::N(n), found) => found.as_int() == Some(n),
        (V::F(n), Value::Real(found)) => {
            n.is_nan() && found.is_nan() || signal::of_single(n).to_bits() == found.to_bits()
        }
        (V::D(n), Value::Real(found)) => n.is_nan() && found.is_nan() || n.to_bits() == found.to_bits(),
        _ => false,
    }
}

fn names(list: &[S], counters: &mut Vec<String>) {
    for statement in list {
        match statement {
            S::For(_, name, .., body) | S::While(name, _, body) | S::Repeat(name, _, body) => {
                counters.push(name.clone());
                names(body, counters);
            }
            S::If(arms, otherwise) => {
                arms.iter().for_each(|(_, body)| names(body, counters));
                names(otherwise, counters);
            }
            S::Case(_, _, arms, otherwise) => {
                arms.iter().for_each(|(_, body)| names(body, counters));
                names(otherwise, counters);
            }
            _ => {}
        }
    }
}

/// The program with the declarations that it needs.
fn essence(text: &str) -> String {
    let (before, program) = text.split_once("PROGRAM MAIN").unwrap();
    let used = |line: &&str| line.split_once(" :").is_some_and(|(name, _)| program.contains(name.trim()));
    let declarations: Vec<&str> = before.lines().filter(used).collect();
    format!("{}{program}", declarations.join("\n"))
}

/// One cycle in slices of these lengths by turns: how it ends, and the time it takes.
fn cycle(machine: &mut Machine, slices: &[Span]) -> (StopReason, Span) {
    machine.begin(0);
    let mut used = Span::ZERO;
    let mut least = Span::ZERO;
    let mut memory = Memory::default();
    for budget in slices.iter().cycle() {
        let slice = machine.resume(0, Time::ZERO + used, (*budget).max(least), &mut memory);
        used = used + slice.used;
        match slice.stop {
            // An operation longer than the slice has to be let through.
            StopReason::Budget { next } => least = next,
            StopReason::Touched { .. } => least = Span::ZERO,
            stop => return (stop, used),
        }
    }
    (StopReason::Done, used)
}

fn check(seed: u64, depth: u32) {
    let mut maker = Maker { random: Random(seed), loops: Vec::new(), counters: 0 };
    let first: Vec<(V, V)> = TYPES.map(|ty| (maker.value(ty), maker.value(ty))).to_vec();
    let body = maker.block(depth);
    let mut counters = Vec::new();
    names(&body, &mut counters);
    let mut memory = BTreeMap::new();
    for (ty, (a, b)) in TYPES.into_iter().zip(&first) {
        let zero = if ty == scanrig_program::Elementary::Real {
            V::F(0.0)
        } else if ty.is_real() {
            V::D(0.0)
        } else {
            V::N(0)
        };
        let name = ty.name();
        memory.insert(format!("v1_{name}"), *a);
        memory.insert(format!("v2_{name}"), *b);
        memory.extend((-2..=2).map(|place| (format!("a_{name}[{place}]"), zero)));
    }
    memory.extend(counters.iter().map(|name| (name.clone(), V::N(0))));
    for folds in [true, false] {
        let mut walk = Walk { memory: memory.clone(), cost: 0, folds };
        let end = walk.block(&body).map(|_| ());
        let text = text(&body, &first, &counters, folds);
        let program = match compile(&sources(&text), &Options::default()) {
            Ok(program) => program,
            // The compiler sees some divisions by 0 and indices outside, whether they run or not.
            Err(findings)
                if folds && findings.iter().all(|f| ["S0305", "S0308", "S0309"].contains(&f.code)) =>
            {
                continue;
            }
            Err(findings) => panic!("{}\n{findings:#?}", essence(&text)),
        };
        let program = Arc::new(program);
        let mut machine = Machine::new(Arc::clone(&program), &[vec![0]]).unwrap();
        let (stop, used) = cycle(&mut machine, &[Span::from_secs(1)]);
        // Runs of operations that are executed in one go change nothing: cut short, they go one by one.
        let mut cut = Machine::new(program, &[vec![0]]).unwrap();
        let pieces = [1, 130, 900, 40, 5_000].map(Span::from_nanos);
        assert_eq!(cycle(&mut cut, &pieces), (stop, used), "{}", essence(&text));
        for name in walk.memory.keys() {
            let found =
                |machine: &Machine| format!("{:?}", machine.find(name).map(|place| machine.read(place)));
            assert_eq!(found(&cut), found(&machine), "{name}\n{}", essence(&text));
        }
        let stop = match stop {
            StopReason::Done => Ok(()),
            StopReason::Fault(fault) => Err(fault.kind),
            other => panic!("{other:?}\n{}", essence(&text)),
        };
        assert_eq!(stop, end, "{}", essence(&text));
        for (name, v) in &walk.memory {
            let found = machine.read(machine.find(name).unwrap_or_else(|| panic!("{name}")));
            // TIME is shown in nanoseconds.
            let v = match v {
                V::N(n) if name.contains("_TIME") => V::N(n * 1_000_000),
                v => *v,
            };
            assert!(same(v, found), "{name} is {found:?}, not {v:?}\n{}", essence(&text));
        }
        if end.is_ok() {
            assert_eq!(used.as_nanos(), walk.cost, "{}", essence(&text));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(400) })]

    #[test]
    fn programs_agree(seed: u64, depth in 0u32..4) {
        check(seed, depth);
    }
}
