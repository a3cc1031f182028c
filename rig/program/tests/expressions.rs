//! Random expressions against an evaluator of its own: types, widths, precedence, constant folding.

use crate::support::{Memory, sources};
use proptest::prelude::*;
use scanrig_program::{Elementary, Machine, Options, ProgramFaultKind, StopReason, compile};
use signal::{Span, Time, Value};
use std::fmt::Write;
use std::sync::Arc;

const TYPES: [Elementary; 12] = [
    Elementary::Sint,
    Elementary::Usint,
    Elementary::Int,
    Elementary::Uint,
    Elementary::Dint,
    Elementary::Udint,
    Elementary::Lint,
    Elementary::Ulint,
    Elementary::Byte,
    Elementary::Word,
    Elementary::Dword,
    Elementary::Lword,
];

/// An expression of one type.
#[derive(Clone, Debug)]
enum E {
    Number(i128),
    /// One of two variables of its type.
    Variable(bool),
    Binary(&'static str, Box<E>, Box<E>),
    Unary(&'static str, Box<E>),
    /// From another type.
    Converted(Elementary, Box<E>),
    /// BOOL from two values of a type.
    Compared(&'static str, Elementary, Box<E>, Box<E>),
}

fn level(op: &str) -> u8 {
    match op {
        "OR" => 0,
        "XOR" => 1,
        "AND" => 2,
        "=" | "<>" => 3,
        "<" | "<=" | ">" | ">=" => 4,
        "+" | "-" => 5,
        _ => 6,
    }
}

/// Text with as few brackets as precedence allows.
fn text(e: &E, ty: Elementary, around: u8, out: &mut String) {
    let own = match e {
        E::Binary(op, ..) | E::Compared(op, ..) => level(op),
        E::Unary(..) => 7,
        _ => 8,
    };
    let brackets = own < around;
    if brackets {
        out.push('(');
    }
    let name = ty.name().to_lowercase();
    match e {
        E::Number(n) => write!(out, "{}#{n}", ty.name()).unwrap(),
        E::Variable(second) => write!(out, "{}{name}", if *second { "b_" } else { "a_" }).unwrap(),
        E::Binary(op, a, b) => {
            text(a, ty, own, out);
            write!(out, " {op} ").unwrap();
            text(b, ty, own + 1, out);
        }
        E::Compared(op, of, a, b) => {
            text(a, *of, own, out);
            write!(out, " {op} ").unwrap();
            text(b, *of, own + 1, out);
        }
        E::Unary(op, a) => {
            write!(out, "{op} ").unwrap();
            text(a, ty, 7, out);
        }
        E::Converted(from, a) => {
            write!(out, "{}_TO_{}(", from.name(), ty.name()).unwrap();
            text(a, *from, 0, out);
            out.push(')');
        }
    }
    if brackets {
        out.push(')');
    }
}

/// A number brought into the range of a type by adding its modulus.
fn wrap(n: i128, ty: Elementary) -> i128 {
    let modulus = 1i128 << ty.bits();
    let n = n.rem_euclid(modulus);
    if ty.signed() && n >= modulus / 2 { n - modulus } else { n }
}

/// A number as the processor holds it that was computed of values of a type: in at least 32 bits.
fn register(n: i128, ty: Elementary) -> i128 {
    match (ty.bits(), ty.signed()) {
        (8 | 16, true) => wrap(n, Elementary::Dint),
        (8 | 16, false) => wrap(n, Elementary::Udint),
        _ => wrap(n, ty),
    }
}

/// The value, not cut yet; `None` where something is divided by 0.
fn evaluate(e: &E, ty: Elementary, variables: &[[i128; 2]; 13]) -> Option<i128> {
    Some(match e {
        E::Number(n) => *n,
        E::Variable(second) => variables[slot(ty)][usize::from(*second)],
        E::Unary("-", a) => register(-evaluate(a, ty, variables)?, ty),
        E::Unary(_, a) => wrap(-1 - wrap(evaluate(a, ty, variables)?, ty), ty),
        E::Converted(_, a) if ty == Elementary::Bool => i128::from(evaluate_converted(e, a, variables)? != 0),
        E::Converted(_, a) => wrap(evaluate_converted(e, a, variables)?, ty),
        E::Compared(op, of, a, b) => {
            let (a, b) = (evaluate(a, *of, variables), evaluate(b, *of, variables));
            let (a, b) = (a?, b?);
            i128::from(match *op {
                "=" => a == b,
                "<>" => a != b,
                "<" => a < b,
                "<=" => a <= b,
                ">" => a > b,
                _ => a >= b,
            })
        }
        E::Binary(op, a, b) => {
            let (a, b) = (evaluate(a, ty, variables)?, evaluate(b, ty, variables)?);
            let n = match *op {
                "+" => a + b,
                "-" => a - b,
                // Products of two 64-bit numbers are cut before they leave 128 bits.
                "*" => (a as u128).wrapping_mul(b as u128) as i128,
                "/" if b == 0 => return None,
                "/" => a / b,
                "MOD" if b == 0 => return None,
                "MOD" => a % b,
                "AND" => a & b,
                "OR" => a | b,
                _ => a ^ b,
            };
            register(n, ty)
        }
    })
}

fn evaluate_converted(e: &E, a: &E, variables: &[[i128; 2]; 13]) -> Option<i128> {
    match e {
        E::Converted(from, _) => evaluate(a, *from, variables),
        _ => None,
    }
}

fn slot(ty: Elementary) -> usize {
    TYPES.iter().position(|known| *known == ty).unwrap_or(12)
}

fn number(ty: Elementary) -> BoxedStrategy<i128> {
    let (low, high) = ty.range();
    prop_oneof![Just(low), Just(high), Just(0), Just(1), low..=high, (low.max(-5))..=5].boxed()
}

fn boolean(depth: u32) -> BoxedStrategy<E> {
    let leaf = prop_oneof![any::<bool>().prop_map(E::Variable), (0..2i128).prop_map(E::Number)];
    if depth == 0 {
        return leaf.boxed();
    }
    let inner = || boolean(depth - 1).prop_map(Box::new);
    let operator = prop::sample::select(vec!["AND", "OR", "XOR", "=", "<>"]);
    let comparison = prop::sample::select(vec!["=", "<>", "<", "<=", ">", ">="]);
    let compared = (comparison, prop::sample::select(TYPES.to_vec())).prop_flat_map(move |(op, ty)| {
        (integer(ty, depth - 1), integer(ty, depth - 1))
            .prop_map(move |(a, b)| E::Compared(op, ty, Box::new(a), Box::new(b)))
    });
    prop_oneof![
        1 => leaf,
        3 => (operator, inner(), inner()).prop_map(|(op, a, b)| match op {
            "=" | "<>" => E::Compared(op, Elementary::Bool, a, b),
            op => E::Binary(op, a, b),
        }),
        1 => inner().prop_map(|a| E::Unary("NOT", a)),
        3 => compared,
    ]
    .boxed()
}

fn integer(ty: Elementary, depth: u32) -> BoxedStrategy<E> {
    let leaf = prop_oneof![2 => any::<bool>().prop_map(E::Variable), 1 => number(ty).prop_map(E::Number)];
    if depth == 0 {
        return leaf.boxed();
    }
    let inner = || integer(ty, depth - 1).prop_map(Box::new);
    let operator = prop::sample::select(vec!["+", "-", "*", "/", "MOD", "AND", "OR", "XOR"]);
    let unary = if ty.signed() { vec!["-", "NOT"] } else { vec!["NOT"] };
    let converted = prop::sample::select(TYPES.to_vec()).prop_flat_map(move |from| {
        integer(from, depth - 1).prop_map(move |a| E::Converted(from, Box::new(a)))
    });
    prop_oneof![
        1 => leaf,
        6 => (operator, inner(), inner()).prop_map(|(op, a, b)| E::Binary(op, a, b)),
        1 => (prop::sample::select(unary), inner()).prop_map(|(op, a)| E::Unary(op, a)),
        1 => converted,
        1 => boolean(depth - 1).prop_map(|a| E::Converted(Elementary::Bool, Box::new(a))),
    ]
    .boxed()
}

fn variables() -> impl Strategy<Value = [[i128; 2]; 13]> {
    let pairs: Vec<_> =
        TYPES.iter().chain([&Elementary::Bool]).map(|ty| (number(*ty), number(*ty))).collect();
    pairs.prop_map(|pairs| {
        let mut values = [[0; 2]; 13];
        for (place, (a, b)) in pairs.into_iter().enumerate() {
            values[place] = [a, b];
        }
        values[12] = values[12].map(|n| n & 1);
        values
    })
}

fn check(e: &E, ty: Elementary, variables: &[[i128; 2]; 13]) {
    let mut program = format!("PROGRAM MAIN VAR r : {};", ty.name());
    for of in TYPES.iter().chain([&Elementary::Bool]) {
        let name = of.name().to_lowercase();
        let [a, b] = variables[slot(*of)];
        write!(program, " a_{name} : {0} := {a}; b_{name} : {0} := {b};", of.name()).unwrap();
    }
    program.push_str(" END_VAR r := ");
    text(e, ty, 0, &mut program);
    program.push_str("; END_PROGRAM");
    let expected = evaluate(e, ty, variables).map(|n| wrap(n, ty));
    let compiled = match compile(&sources(&program), &Options::default()) {
        Ok(compiled) => Arc::new(compiled),
        Err(findings) => {
            // Divisions by a constant 0 are found by the compiler already.
            assert!(
                findings.iter().all(|f| ["S0305", "S0306", "S0309"].contains(&f.code)),
                "{program}\n{findings:#?}"
            );
            // The evaluator may have no value either; where a zero is constant it must have none.
            assert_eq!(expected, None, "{program}");
            return;
        }
    };
    let mut machine = Machine::new(compiled, &[vec![0]]).unwrap();
    let mut memory = Memory::default();
    machine.begin(0);
    let slice = machine.resume(0, Time::ZERO, Span::from_secs(1), &mut memory);
    match (slice.stop, expected) {
        (StopReason::Done, Some(expected)) => {
            let found = machine.read(machine.find("r").unwrap());
            assert_eq!(found.as_int(), Some(expected), "{program}");
            assert!(ty != Elementary::Bool || matches!(found, Value::Bool(_)));
        }
        (StopReason::Fault(fault), None) => assert_eq!(fault.kind, ProgramFaultKind::DivisionByZero),
        other => panic!("{other:?}\n{program}"),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn integers_agree(
        (ty, e) in prop::sample::select(TYPES.to_vec()).prop_flat_map(|ty| (Just(ty), integer(ty, 4))),
        variables in variables(),
    ) {
        check(&e, ty, &variables);
    }

    #[test]
    fn booleans_agree(e in boolean(4), variables in variables()) {
        check(&e, Elementary::Bool, &variables);
    }
}
