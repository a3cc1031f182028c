//! Random programs as trees, and their text.

use crate::support::oracle::{decimal, limits, literal};
use scanrig_program::Elementary::{self, *};
use std::fmt::Write;

/// A value of any type of [`TYPES`].
#[derive(Clone, Copy, Debug)]
pub enum V {
    N(i128),
    F(f32),
    D(f64),
}

pub const TYPES: [Elementary; 16] =
    [Sint, Usint, Int, Uint, Dint, Udint, Lint, Ulint, Byte, Word, Dword, Lword, Bool, Real, Lreal, Time];

/// An expression; its type is known from where it stands.
#[derive(Clone, Debug)]
pub enum E {
    Literal(V),
    /// A variable by its whole name.
    Variable(String),
    /// An element of the array of the type, by an INT.
    Element(Box<E>),
    Not(Box<E>),
    Negative(Box<E>),
    Absolute(Box<E>),
    /// An operator or a function of two values of the type.
    Binary(&'static str, Box<E>, Box<E>),
    /// A value and a count of USINT.
    Shift(&'static str, Box<E>, Box<E>),
    Limit(Box<[E; 3]>),
    Select(Box<E>, Box<[E; 2]>),
    /// By a USINT.
    Multiplex(Box<E>, Vec<E>),
    /// A_TO_B.
    Converted(Elementary, Box<E>),
    /// BOOL of two values of a type.
    Compared(&'static str, Elementary, Box<E>, Box<E>),
    /// The function of the type, which changes a variable.
    Call(Box<E>),
}

/// Labels of CASE with their statements.
pub type Arm = (Vec<(i128, i128)>, Vec<S>);

#[derive(Clone, Debug)]
pub enum S {
    Assign(Elementary, String, E),
    Element(Elementary, E, E),
    If(Vec<(E, Vec<S>)>, Vec<S>),
    Case(Elementary, E, Vec<Arm>, Vec<S>),
    /// Type, name, start, end, step.
    For(Elementary, String, i128, E, i128, Vec<S>),
    /// The guard counts turns.
    While(String, E, Vec<S>),
    Repeat(String, E, Vec<S>),
    Exit,
    Continue,
    Return,
}

/// SplitMix64.
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ z >> 31
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    pub fn of<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.below(all.len())]
    }
}

/// Makes programs.
pub struct Maker {
    pub random: Random,
    /// Loops around, and how many there are in all.
    pub loops: Vec<(Elementary, String)>,
    pub counters: usize,
}

impl Maker {
    pub fn value(&mut self, ty: Elementary) -> V {
        let r = &mut self.random;
        match ty {
            Real => V::F(r.of(&[0.0, -0.0, 1.0, -1.5, 0.1, 3.4E38, -1.25E-38, 100_000.0, 16_777_216.0])),
            Lreal => {
                V::D(r.of(&[0.0, -0.0, 1.0, -1.5, 0.1, 1.7E308, 2.25E-308, 4.0E9, 9_007_199_254_740_993.0]))
            }
            _ => {
                let (low, high) = limits(ty);
                let any = low + (i128::from(r.next()) & (high - low));
                V::N(r.of(&[low, high, 0, 1, 2, 3, 7, any, (-1).max(low)]).clamp(low, high))
            }
        }
    }

    fn boxed(&mut self, ty: Elementary, depth: u32) -> Box<E> {
        Box::new(self.expression(ty, depth))
    }

    fn leaf(&mut self, ty: Elementary) -> E {
        if let Some((of, name)) = self.loops.last()
            && *of == ty
            && self.random.below(2) == 0
        {
            return E::Variable(name.clone());
        }
        match self.random.below(3) {
            0 => E::Literal(self.value(ty)),
            n => E::Variable(format!("v{n}_{}", ty.name())),
        }
    }

    pub fn expression(&mut self, ty: Elementary, depth: u32) -> E {
        if depth == 0 {
            return self.leaf(ty);
        }
        let d = depth - 1;
        match self.random.below(16) {
            0 => self.leaf(ty),
            1 => {
                let inner = self.boxed(Int, d);
                // Mostly inside of -2..2.
                E::Element(if self.random.below(8) == 0 {
                    inner
                } else {
                    Box::new(E::Binary("MOD", inner, Box::new(E::Literal(V::N(3)))))
                })
            }
            2 => E::Select(self.boxed(Bool, d), Box::new([self.expression(ty, d), self.expression(ty, d)])),
            3 => {
                let count = 2 + self.random.below(3);
                E::Multiplex(self.boxed(Usint, d), (0..count).map(|_| self.expression(ty, d)).collect())
            }
            4 => {
                let from = self.random.of(&TYPES);
                // A BOOL has no number of milliseconds, and a real may have too many.
                let odd = |a: Elementary, b: Elementary| a == Time && (b == Bool || b.is_real());
                if odd(ty, from) || odd(from, ty) {
                    self.leaf(ty)
                } else {
                    E::Converted(from, self.boxed(from, d))
                }
            }
            5 if self.random.below(2) == 0 => E::Call(self.boxed(ty, d)),
            n => match ty {
                Bool if n < 9 => {
                    let of = self.random.of(&TYPES);
                    let op = self.random.of(&["=", "<>", "<", "<=", ">", ">="]);
                    E::Compared(op, of, self.boxed(of, d), self.boxed(of, d))
                }
                Bool if n == 9 => E::Not(self.boxed(ty, d)),
                Bool => {
                    let op = self.random.of(&["AND", "OR", "XOR", "AND_THEN", "OR_ELSE"]);
                    E::Binary(op, self.boxed(ty, d), self.boxed(ty, d))
                }
                _ if n == 6 => E::Limit(Box::new([
                    self.expression(ty, d),
                    self.expression(ty, d),
                    self.expression(ty, d),
                ])),
                Time => {
                    let op = self.random.of(&["+", "-", "MIN", "MAX"]);
                    E::Binary(op, self.boxed(ty, d), self.boxed(ty, d))
                }
                Real | Lreal if n == 7 => E::Negative(self.boxed(ty, d)),
                _ if n == 8 => E::Absolute(self.boxed(ty, d)),
                Real | Lreal => {
                    let op = self.random.of(&["+", "-", "*", "/", "MIN", "MAX"]);
                    E::Binary(op, self.boxed(ty, d), self.boxed(ty, d))
                }
                Sint | Int | Dint | Lint if n == 7 => E::Negative(self.boxed(ty, d)),
                _ if n == 7 => E::Not(self.boxed(ty, d)),
                Sint | Int | Dint | Lint if n == 9 => {
                    E::Shift("SHL", self.boxed(ty, d), self.boxed(Usint, d))
                }
                _ if n == 9 => {
                    let op = self.random.of(&["SHL", "SHR", "ROL", "ROR"]);
                    E::Shift(op, self.boxed(ty, d), self.boxed(Usint, d))
                }
                _ => {
                    let op = self
                        .random
                        .of(&["+", "-", "*", "+", "-", "*", "/", "MOD", "AND", "OR", "XOR", "MIN", "MAX"]);
                    E::Binary(op, self.boxed(ty, d), self.boxed(ty, d))
                }
            },
        }
    }

    pub fn block(&mut self, depth: u32) -> Vec<S> {
        let count = 1 + self.random.below(3);
        (0..count).map(|_| self.statement(depth)).collect()
    }

    fn statement(&mut self, depth: u32) -> S {
        let ty = self.random.of(&TYPES);
        match self.random.below(if depth == 0 { 7 } else { 12 }) {
            n if n < 4 || n > 4 && depth == 0 && (n != 5 || self.loops.is_empty()) => {
                let name = format!("v{}_{}", 1 + self.random.below(2), ty.name());
                S::Assign(ty, name, self.expression(ty, 3))
            }
            4 => {
                let place = E::Binary("MOD", self.boxed(Int, 1), Box::new(E::Literal(V::N(3))));
                S::Element(ty, place, self.expression(ty, 3))
            }
            5 if !self.loops.is_empty() => match self.random.below(6) {
                0 => S::Exit,
                1..=3 => S::Continue,
                _ => S::If(vec![(self.expression(Bool, 1), vec![S::Exit])], Vec::new()),
            },
            6 if self.random.below(30) == 0 => S::Return,
            5..=7 => {
                let arms = (0..=self.random.below(2))
                    .map(|_| (self.expression(Bool, 3), self.inner(depth)))
                    .collect();
                S::If(arms, if self.random.below(2) == 0 { self.inner(depth) } else { Vec::new() })
            }
            8 => {
                let ty = self.random.of(&TYPES[..12]);
                let mut next = self.random.of(&[limits(ty).0, 0, 1]);
                let mut arms = Vec::new();
                for _ in 0..1 + self.random.below(3) {
                    let mut labels = Vec::new();
                    for _ in 0..1 + self.random.below(2) {
                        let end = next + self.random.of(&[0, 0, 1, 5]);
                        labels.push((next, end));
                        next = end + 1 + self.random.of(&[0, 1, 20]);
                    }
                    arms.push((labels, self.inner(depth)));
                }
                S::Case(ty, self.expression(ty, 2), arms, self.inner(depth))
            }
            9 | 10 => {
                let ty = self.random.of(&TYPES[..8]);
                let name = self.counter(ty);
                let body = self.turns(ty, &name, depth);
                let small = |maker: &mut Maker| {
                    let inner = maker.boxed(ty, 1);
                    E::Binary("MOD", inner, Box::new(E::Literal(V::N(5))))
                };
                if self.random.below(2) == 0 {
                    let end = if self.random.below(2) == 0 { E::Literal(V::N(3)) } else { small(self) };
                    S::For(ty, name, 0, end, 1, body)
                } else {
                    // An unsigned counter has a number below this end, too: else the loop never ends.
                    S::For(ty, name, 7, E::Literal(V::N(2)), -2, body)
                }
            }
            n => {
                let name = self.counter(Dint);
                let condition = self.expression(Bool, 2);
                let body = self.turns(Dint, &name, depth);
                if n == 11 { S::While(name, condition, body) } else { S::Repeat(name, condition, body) }
            }
        }
    }

    fn inner(&mut self, depth: u32) -> Vec<S> {
        self.block(depth.saturating_sub(1))
    }

    fn counter(&mut self, ty: Elementary) -> String {
        self.counters += 1;
        format!("i{}_{}", self.counters, ty.name())
    }

    fn turns(&mut self, ty: Elementary, name: &str, depth: u32) -> Vec<S> {
        self.loops.push((ty, name.into()));
        let body = self.inner(depth);
        self.loops.pop();
        body
    }
}

/// Writes programs; literals become variables where `names` collects them.
pub struct Writer {
    pub text: String,
    pub names: Option<Vec<String>>,
}

impl Writer {
    pub fn literal(&mut self, ty: Elementary, v: V) {
        let plain = match v {
            V::F(n) => decimal(ty, f64::from(n)),
            V::D(n) => decimal(ty, n),
            V::N(n) => literal(ty, n),
        };
        match &mut self.names {
            Some(names) => {
                write!(self.text, "k{}", names.len()).unwrap();
                names.push(format!("k{} : {} := {plain};", names.len(), ty.name()));
            }
            None => self.text += &plain,
        }
    }

    fn list(&mut self, name: &str, list: &[(Elementary, &E)]) {
        self.text += name;
        for (nth, (ty, e)) in list.iter().enumerate() {
            self.text += if nth == 0 { "(" } else { ", " };
            self.expression(*ty, e);
        }
        self.text += ")";
    }

    pub fn expression(&mut self, ty: Elementary, e: &E) {
        let name = ty.name();
        match e {
            E::Literal(v) => self.literal(ty, *v),
            E::Variable(name) => self.text += name,
            E::Element(index) => {
                write!(self.text, "a_{name}[").unwrap();
                self.expression(Int, index);
                self.text += "]";
            }
            E::Not(of) => self.list("NOT ", &[(ty, of)]),
            E::Negative(of) => self.list("-", &[(ty, of)]),
            E::Absolute(of) => self.list("ABS", &[(ty, of)]),
            E::Binary(op @ ("MIN" | "MAX"), a, b) => self.list(op, &[(ty, a), (ty, b)]),
            E::Binary(op, a, b) => self.infix(op, ty, a, b),
            E::Compared(op, of, a, b) => self.infix(op, *of, a, b),
            E::Shift(op, value, count) => self.list(op, &[(ty, value), (Usint, count)]),
            E::Limit(all) => self.list("LIMIT", &[(ty, &all[0]), (ty, &all[1]), (ty, &all[2])]),
            E::Select(which, all) => self.list("SEL", &[(Bool, which), (ty, &all[0]), (ty, &all[1])]),
            E::Multiplex(which, all) => {
                let mut list = vec![(Usint, which.as_ref())];
                list.extend(all.iter().map(|e| (ty, e)));
                self.list("MUX", &list);
            }
            E::Converted(from, of) => self.list(&format!("{}_TO_{name}", from.name()), &[(*from, of)]),
            E::Call(of) => self.list(&format!("side_{name}"), &[(ty, of)]),
        }
    }

    fn infix(&mut self, op: &str, ty: Elementary, a: &E, b: &E) {
        self.text += "(";
        self.expression(ty, a);
        write!(self.text, " {op} ").unwrap();
        self.expression(ty, b);
        self.text += ")";
    }

    pub fn block(&mut self, list: &[S]) {
        for statement in list {
            self.statement(statement);
        }
    }

    fn statement(&mut self, statement: &S) {
        match statement {
            S::Assign(ty, name, value) => {
                write!(self.text, "{name} := ").unwrap();
                self.expression(*ty, value);
            }
            S::Element(ty, index, value) => {
                self.expression(*ty, &E::Element(Box::new(index.clone())));
                self.text += " := ";
                self.expression(*ty, value);
            }
            S::If(arms, otherwise) => {
                for (nth, (condition, body)) in arms.iter().enumerate() {
                    self.text += if nth == 0 { "IF " } else { "ELSIF " };
                    self.expression(Bool, condition);
                    self.text += " THEN\n";
                    self.block(body);
                }
                self.text += "ELSE\n";
                self.block(otherwise);
                self.text += "END_IF";
            }
            S::Case(ty, selector, arms, otherwise) => {
                self.text += "CASE ";
                self.expression(*ty, selector);
                self.text += " OF\n";
                for (labels, body) in arms {
                    let labels: Vec<String> = labels
                        .iter()
                        .map(
                            |(low, high)| {
                                if low == high { low.to_string() } else { format!("{low}..{high}") }
                            },
                        )
                        .collect();
                    writeln!(self.text, "{}:", labels.join(", ")).unwrap();
                    self.block(body);
                }
                self.text += "ELSE\n";
                self.block(otherwise);
                self.text += "END_CASE";
            }
            S::For(ty, name, from, to, by, body) => {
                write!(self.text, "FOR {name} := {from} TO ").unwrap();
                self.expression(*ty, to);
                writeln!(self.text, " BY {by} DO").unwrap();
                self.block(body);
                self.text += "END_FOR";
            }
            S::While(guard, condition, body) => {
                write!(self.text, "{guard} := 0;\nWHILE ").unwrap();
                self.expression(Bool, condition);
                writeln!(self.text, " AND {guard} < 4 DO {guard} := {guard} + 1;").unwrap();
                self.block(body);
                self.text += "END_WHILE";
            }
            S::Repeat(guard, condition, body) => {
                writeln!(self.text, "{guard} := 0;\nREPEAT {guard} := {guard} + 1;").unwrap();
                self.block(body);
                self.text += "UNTIL ";
                self.expression(Bool, condition);
                write!(self.text, " OR {guard} >= 4 END_REPEAT").unwrap();
            }
            S::Exit => self.text += "EXIT",
            S::Continue => self.text += "CONTINUE",
            S::Return => self.text += "RETURN",
        }
        self.text += ";\n";
    }
}
