//! Values and operators a second time, in i128, f32 and f64: what results are compared with. Nothing here is taken
//! from the compiler or the machine but the names of the types.

use super::sources;
use scanrig_program::{Elementary, Elementary::*, Machine, Options, StopReason, compile};
use signal::{Span, Time as Instant, Value};
use std::fmt::Write;
use std::sync::Arc;

/// Whole numbers and bit strings.
pub const WHOLE: [Elementary; 12] =
    [Sint, Usint, Int, Uint, Dint, Udint, Lint, Ulint, Byte, Word, Dword, Lword];

/// Width and sign (IEC 61131-3, table 10).
pub fn width(ty: Elementary) -> (u32, bool) {
    match ty {
        Sint => (8, true),
        Int => (16, true),
        Dint => (32, true),
        Lint => (64, true),
        Usint | Byte | Char => (8, false),
        Uint | Word | Wchar => (16, false),
        Udint | Dword | Time | Date | Tod | Dt => (32, false),
        Ulint | Lword | Ltime | Ldate | Ltod | Ldt => (64, false),
        Bool => (1, false),
        Real | Lreal => panic!("no whole number"),
    }
}

/// Least and greatest value.
pub fn limits(ty: Elementary) -> (i128, i128) {
    match width(ty) {
        (bits, true) => (-(1 << (bits - 1)), (1 << (bits - 1)) - 1),
        (bits, false) => (0, (1 << bits) - 1),
    }
}

/// The value of the type that differs from a number by a multiple of the modulus.
pub fn wrap(n: i128, ty: Elementary) -> i128 {
    let (bits, signed) = width(ty);
    let n = n.rem_euclid(1 << bits);
    if signed && n >= 1 << (bits - 1) { n - (1 << bits) } else { n }
}

/// The number as the processor holds it that was computed of values of the type: in at least 32 bits.
pub fn register(n: i128, ty: Elementary) -> i128 {
    match (width(ty), ty) {
        (_, Bool) => wrap(n, ty),
        ((8 | 16, true), _) => wrap(n, Dint),
        ((8 | 16, false), _) => wrap(n, Udint),
        _ => wrap(n, ty),
    }
}

/// A literal of a type.
pub fn literal(ty: Elementary, n: i128) -> String {
    match ty {
        Time => format!("T#{n}ms"),
        Ltime => format!("LTIME#{n}ns"),
        Real | Lreal => panic!("see `decimal`"),
        _ => format!("{}#{n}", ty.name()),
    }
}

/// A literal of REAL or LREAL.
pub fn decimal(ty: Elementary, n: f64) -> String {
    let text = if ty == Real { format!("{:e}", n as f32) } else { format!("{n:e}") };
    let (mantissa, exponent) = text.split_once('e').unwrap();
    let point = if mantissa.contains('.') { "" } else { ".0" };
    format!("{}#{mantissa}{point}E{exponent}", ty.name())
}

/// An expression with its value.
#[derive(Clone, Debug)]
pub struct Case {
    /// Operands stand as `$a`, `$b`, `$c`.
    pub text: String,
    pub result: Elementary,
    /// Type and literal.
    pub operands: Vec<(Elementary, String)>,
    pub expected: Value,
}

impl Case {
    pub fn new(text: &str, result: Elementary, expected: Value, operands: &[(Elementary, String)]) -> Case {
        Case { text: text.into(), result, operands: operands.to_vec(), expected }
    }
}

/// The number as a variable of the type holds it: what the host sees.
pub fn seen(ty: Elementary, n: i128) -> Value {
    match ty {
        Bool => Value::Bool(n != 0),
        // Times and dates are shown in nanoseconds.
        Time | Tod => Value::Int((n * 1_000_000) as i64),
        Date | Dt => Value::Int((n * 1_000_000_000) as i64),
        Ulint | Byte | Word | Dword | Lword => Value::Word(n as u64),
        _ => Value::Int(n as i64),
    }
}

/// An expected value as a machine shows it: a REAL as the decimal that it stands for.
fn shown(ty: Elementary, value: Value) -> Value {
    match value {
        Value::Real(real) if ty == Elementary::Real => Value::Real(signal::of_single(real as f32)),
        other => other,
    }
}

/// Equal as numbers; bit for bit for reals, where there is one NaN.
pub fn same(a: Value, b: Value) -> bool {
    match (a, b) {
        (Value::Real(a), Value::Real(b)) => a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan(),
        (a, b) => a.as_int().is_some() && a.as_int() == b.as_int(),
    }
}

/// Evaluates the cases and compares. The operands whose bit is set in `variables` are put into variables, the
/// others stay literals.
pub fn check(cases: &[Case], variables: u8) {
    for chunk in cases.chunks(2000) {
        check_some(chunk, variables);
    }
}

fn check_some(cases: &[Case], variables: u8) {
    let mut text = String::from("PROGRAM MAIN VAR\n");
    for ty in Elementary::ALL {
        let name = ty.name();
        for operand in ["a", "b", "c"] {
            writeln!(text, "{operand}_{name} : {name};").unwrap();
        }
        let count = cases.iter().filter(|case| case.result == ty).count();
        writeln!(text, "r_{name} : ARRAY[0..{count}] OF {name};").unwrap();
    }
    text.push_str("inf_REAL, nan_REAL : REAL; inf_LREAL, nan_LREAL : LREAL; END_VAR\n");
    let mut counts = [0; 25];
    let mut places = Vec::new();
    for case in cases {
        let mut expression = case.text.clone();
        for (nth, (ty, value)) in case.operands.iter().enumerate() {
            let letter = ["a", "b", "c"][nth];
            let mut operand = value.clone();
            if variables >> nth & 1 == 1 {
                operand = format!("{letter}_{}", ty.name());
                writeln!(text, "{operand} := {value};").unwrap();
            }
            expression = expression.replace(&format!("${letter}"), &operand);
        }
        let count = &mut counts[case.result as usize];
        writeln!(text, "r_{}[{count}] := {expression};", case.result.name()).unwrap();
        places.push((format!("r_{}[{count}]", case.result.name()), expression));
        *count += 1;
    }
    text.push_str("END_PROGRAM\n");
    let program = match compile(&sources(&text), &Options::default()) {
        Ok(program) => Arc::new(program),
        Err(findings) => {
            let first =
                findings.iter().find(|finding| finding.severity == document::Severity::Error).unwrap();
            let span = first.labels[0].span.clone();
            let from = text[..span.start].rfind('\n').map_or(0, |at| at + 1);
            let line: String = text[from..].lines().next().unwrap().into();
            panic!("{line}\n{first:?}");
        }
    };
    let mut machine = Machine::new(program, &[vec![0]]).unwrap();
    for name in ["REAL", "LREAL"] {
        for (value, number) in [("inf", f64::INFINITY), ("nan", f64::NAN)] {
            let variable = machine.find(&format!("{value}_{name}")).unwrap();
            assert!(machine.write(variable, Value::Real(number)));
        }
    }
    machine.begin(0);
    let stop = machine.resume(0, Instant::ZERO, Span::from_secs(1), &mut super::Memory::default()).stop;
    assert_eq!(stop, StopReason::Done);
    let mut wrong = String::new();
    for (case, (path, expression)) in cases.iter().zip(places) {
        let found = machine.read(machine.find(&path).unwrap());
        let expected = shown(case.result, case.expected);
        if !same(found, expected) {
            let operands = &case.operands;
            writeln!(wrong, "{expression} is {found:?}, not {expected:?}: {operands:?}").unwrap();
        }
    }
    assert!(wrong.is_empty(), "with variables {variables:#b}:\n{wrong}");
}

/// The codes that are reported for each of the statements, warnings among them.
pub fn verdicts(declarations: &str, statements: &[String]) -> Vec<Vec<&'static str>> {
    let mut text = format!("{}\nPROGRAM MAIN\n", declarations.replace('\n', " "));
    for statement in statements {
        writeln!(text, "{statement}").unwrap();
    }
    text.push_str("END_PROGRAM\n");
    let mut options = Options::default();
    options.limits.errors = usize::MAX;
    let findings = match compile(&sources(&text), &options) {
        Ok(program) => program.warnings,
        Err(findings) => findings,
    };
    let mut codes = vec![Vec::new(); statements.len()];
    for finding in findings {
        let line = text[..finding.labels[0].span.start].matches('\n').count();
        codes.get_mut(line.wrapping_sub(2)).unwrap_or_else(|| panic!("{finding:?}")).push(finding.code);
    }
    codes
}
