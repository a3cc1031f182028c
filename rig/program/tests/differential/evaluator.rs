//! Walks the tree of a program: values and modelled time.

use super::tree::{E, S, V};
use crate::support::oracle::{limits, register, width, wrap};
use scanrig_program::Elementary::{self, *};
use scanrig_program::ProgramFaultKind;
use std::collections::BTreeMap;

/// Load, store, operation and division (see `Costs::default`).
fn costs(ty: Elementary) -> [i64; 4] {
    match ty {
        Bool => [37, 38, 75, 75],
        Real => [25, 25, 336, 678],
        Lreal => [50, 50, 672, 1356],
        _ => match width(ty).0 {
            8 | 16 => [32, 32, 42, 84],
            32 => [24, 25, 41, 82],
            _ => [48, 50, 82, 164],
        },
    }
}

const BRANCH: i64 = 20;
const INDEX: i64 = 42;
const CALL: i64 = 200;

/// How a list of statements ends.
pub enum End {
    Through,
    Exit,
    Continue,
    Return,
}

pub struct Walk {
    /// All variables, elements as `a_INT[-2]`.
    pub memory: BTreeMap<String, V>,
    pub cost: i64,
    /// Literals are literals: what is made of them alone takes no time.
    pub folds: bool,
}

type Result<T> = std::result::Result<T, ProgramFaultKind>;

fn whole(v: V) -> i128 {
    match v {
        V::N(n) => n,
        V::F(_) | V::D(_) => panic!("no whole number"),
    }
}

/// A function of numbers of any type.
fn apply(
    ty: Elementary,
    a: V,
    b: V,
    on_whole: fn(i128, i128) -> i128,
    f: fn(f32, f32) -> f32,
    d: fn(f64, f64) -> f64,
) -> V {
    match (a, b) {
        (V::N(a), V::N(b)) => V::N(register(on_whole(a, b), ty)),
        (V::F(a), V::F(b)) => V::F(f(a, b)),
        (V::D(a), V::D(b)) => V::D(d(a, b)),
        _ => panic!("{a:?} and {b:?}"),
    }
}

/// The value as a variable of the type holds it.
fn cut(ty: Elementary, v: V) -> V {
    match v {
        V::N(n) => V::N(wrap(n, ty)),
        v => v,
    }
}

/// The greatest and the least of reals: -0.0 before 0.0, and NaN where one is NaN.
fn least(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() {
        f64::NAN
    } else if a < b || a == b && a.is_sign_negative() {
        a
    } else {
        b
    }
}

fn most(a: f64, b: f64) -> f64 {
    -least(-a, -b)
}

fn minimum(ty: Elementary, a: V, b: V) -> V {
    apply(ty, a, b, |a, b| a.min(b), |a, b| least(a.into(), b.into()) as f32, least)
}

fn maximum(ty: Elementary, a: V, b: V) -> V {
    apply(ty, a, b, |a, b| a.max(b), |a, b| most(a.into(), b.into()) as f32, most)
}

fn convert(to: Elementary, v: V) -> V {
    let real = |n: f64| match to {
        Real => V::F(n as f32),
        Lreal => V::D(n),
        Bool => V::N(i128::from(n != 0.0)),
        _ => {
            // To the nearest, ties to even; within 64 bits (of the sign that the number has), then cut.
            let (low, high) =
                (limits(Lint).0, if matches!(to, Ulint | Lword) && n > 0.0 { Ulint } else { Lint });
            let down = n.floor();
            let up = n - down > 0.5 || n - down == 0.5 && down % 2.0 != 0.0;
            let near = if n.is_nan() { 0 } else { (down as i128).saturating_add(i128::from(up)) };
            V::N(wrap(near.clamp(low, limits(high).1), to))
        }
    };
    match v {
        V::F(n) if to == Real => V::F(n),
        V::F(n) => real(f64::from(n)),
        V::D(n) => real(n),
        V::N(n) => match to {
            Real => V::F(n as f32),
            Lreal => V::D(n as f64),
            Bool => V::N(i128::from(n != 0)),
            _ => V::N(wrap(n, to)),
        },
    }
}

/// Made of literals alone, by operators and conversions.
fn constant(e: &E) -> bool {
    match e {
        E::Literal(_) => true,
        E::Not(a) | E::Negative(a) | E::Absolute(a) | E::Converted(_, a) => constant(a),
        E::Binary(_, a, b) | E::Compared(_, _, a, b) | E::Shift(_, a, b) => constant(a) && constant(b),
        E::Limit(all) => all.iter().all(constant),
        E::Variable(_) | E::Element(_) | E::Select(..) | E::Multiplex(..) | E::Call(_) => false,
    }
}

impl Walk {
    pub fn get(&self, name: &str) -> V {
        *self.memory.get(name).unwrap_or_else(|| panic!("no {name}"))
    }

    fn set(&mut self, name: &str, v: V) {
        *self.memory.get_mut(name).unwrap_or_else(|| panic!("no {name}")) = v;
    }

    pub fn value(&mut self, ty: Elementary, e: &E) -> Result<V> {
        let before = self.cost;
        let v = self.compute(ty, e)?;
        if self.folds && constant(e) {
            self.cost = before;
        }
        Ok(v)
    }

    fn compute(&mut self, ty: Elementary, e: &E) -> Result<V> {
        let [load, store, op, div] = costs(ty);
        Ok(match e {
            E::Literal(v) => {
                self.cost += if self.folds { 0 } else { load };
                *v
            }
            E::Variable(name) => {
                self.cost += load;
                self.get(name)
            }
            E::Element(index) => {
                let name = self.element(ty, index)?;
                self.cost += load;
                self.get(&name)
            }
            E::Not(a) => {
                let a = whole(cut(ty, self.value(ty, a)?));
                self.cost += op;
                V::N(if ty == Bool { 1 - a } else { wrap(!a, ty) })
            }
            E::Negative(a) => {
                let a = self.value(ty, a)?;
                self.cost += op;
                apply(ty, a, a, |a, _| -a, |a, _| -a, |a, _| -a)
            }
            E::Absolute(a) => {
                let a = self.value(ty, a)?;
                self.cost += op;
                apply(ty, a, a, |a, _| a.abs(), |a, _| a.abs(), |a, _| a.abs())
            }
            E::Binary(which @ ("AND_THEN" | "OR_ELSE"), ..) => return self.in_turn(which, e),
            E::Binary(which, a, b) => {
                let (a, b) = (self.value(ty, a)?, self.value(ty, b)?);
                self.cost += if matches!(*which, "/" | "MOD") { div } else { op };
                match *which {
                    "+" => apply(ty, a, b, |a, b| a + b, |a, b| a + b, |a, b| a + b),
                    "-" => apply(ty, a, b, |a, b| a - b, |a, b| a - b, |a, b| a - b),
                    "*" => apply(ty, a, b, |a, b| a.wrapping_mul(b), |a, b| a * b, |a, b| a * b),
                    "/" | "MOD" if matches!(b, V::N(0)) => return Err(ProgramFaultKind::DivisionByZero),
                    "/" if matches!(b, V::F(n) if n == 0.0) || matches!(b, V::D(n) if n == 0.0) => {
                        return Err(ProgramFaultKind::RealDivisionByZero);
                    }
                    "/" => apply(ty, a, b, |a, b| a / b, |a, b| a / b, |a, b| a / b),
                    "MOD" => V::N(register(whole(a) % whole(b), ty)),
                    "AND" => V::N(whole(a) & whole(b)),
                    "OR" => V::N(whole(a) | whole(b)),
                    "XOR" => V::N(whole(a) ^ whole(b)),
                    "MIN" => minimum(ty, a, b),
                    _ => maximum(ty, a, b),
                }
            }
            E::Shift(which, a, count) => {
                let (a, count) =
                    (whole(cut(ty, self.value(ty, a)?)), whole(self.value(Usint, count)?) as u32);
                self.cost += op;
                let (bits, signed) = width(ty);
                let (full, turn) = ((1 << bits) - 1, count % bits);
                let plain = a & full;
                V::N(wrap(
                    match *which {
                        "SHL" if count < bits => plain << count,
                        "SHR" if signed => a >> count.min(127),
                        "SHR" if count < bits => plain >> count,
                        "ROL" => plain << turn | plain >> (bits - turn),
                        "ROR" => plain >> turn | plain << (bits - turn),
                        _ => 0,
                    } & full,
                    ty,
                ))
            }
            E::Limit(all) => {
                let [low, n, high] =
                    [self.value(ty, &all[0])?, self.value(ty, &all[1])?, self.value(ty, &all[2])?];
                // The greater of the first two is computed by the compiler where both are constant.
                let early = self.folds && constant(&all[0]) && constant(&all[1]);
                self.cost += if early { op } else { 2 * op };
                minimum(ty, maximum(ty, low, n), high)
            }
            E::Select(which, all) => {
                let which = whole(self.value(Bool, which)?);
                self.cost += op;
                self.value(ty, &all[which as usize])?
            }
            E::Multiplex(which, all) => {
                let which = whole(self.value(Usint, which)?);
                self.cost += op;
                // The last one for a number beyond, as the tool's help says.
                self.value(ty, &all[(which as usize).min(all.len() - 1)])?
            }
            E::Converted(from, a) => {
                let a = self.value(*from, a)?;
                self.cost += if width_of(*from) > width_of(ty) { costs(*from)[2] } else { op };
                convert(ty, a)
            }
            E::Compared(which, of, a, b) => {
                let (a, b) = (self.value(*of, a)?, self.value(*of, b)?);
                self.cost += costs(*of)[2];
                let order = match (a, b) {
                    (V::N(a), V::N(b)) => Some(a.cmp(&b)),
                    (V::F(a), V::F(b)) => a.partial_cmp(&b),
                    (V::D(a), V::D(b)) => a.partial_cmp(&b),
                    _ => panic!("{a:?} and {b:?}"),
                };
                let holds = |f: fn(std::cmp::Ordering) -> bool| order.is_some_and(f);
                V::N(i128::from(match *which {
                    "=" => holds(|o| o.is_eq()),
                    "<>" => !holds(|o| o.is_eq()),
                    "<" => holds(|o| o.is_lt()),
                    "<=" => holds(|o| o.is_le()),
                    ">" => holds(|o| o.is_gt()),
                    _ => holds(|o| o.is_ge()),
                }))
            }
            E::Call(a) => {
                let a = cut(ty, self.value(ty, a)?);
                // v1 := v1 op x; side := v1;
                self.cost += CALL + load + load + op + store + load + store;
                let name = format!("v1_{}", ty.name());
                let old = self.get(&name);
                let on_whole: fn(i128, i128) -> i128 = if ty == Time { |a, b| a - b } else { |a, b| a ^ b };
                let new = apply(ty, old, a, on_whole, |a, b| a - b, |a, b| a - b);
                self.set(&name, new);
                new
            }
        })
    }

    /// AND_THEN and OR_ELSE: from left to right until one decides.
    fn in_turn(&mut self, which: &str, e: &E) -> Result<V> {
        let mut parts = Vec::new();
        let mut left = e;
        while let E::Binary(op, a, b) = left
            && *op == which
            && !(self.folds && constant(left))
        {
            parts.push(b.as_ref());
            left = a;
        }
        parts.push(left);
        if parts.len() == 1 {
            // All of it is constant.
            let E::Binary(_, a, b) = e else { panic!() };
            let (a, b) = (whole(self.value(Bool, a)?), whole(self.value(Bool, b)?));
            return Ok(V::N(if which == "AND_THEN" { a & b } else { a | b }));
        }
        let decides = i128::from(which == "OR_ELSE");
        let mut last = 1 - decides;
        while let Some(part) = parts.pop() {
            self.cost += if parts.is_empty() { 0 } else { costs(Bool)[2] };
            last = whole(self.value(Bool, part)?);
            if last == decides {
                break;
            }
        }
        Ok(V::N(last))
    }

    /// The name of an element.
    fn element(&mut self, ty: Elementary, index: &E) -> Result<String> {
        let place = whole(self.value(Int, index)?);
        self.cost += if self.folds && constant(index) { 0 } else { INDEX };
        if (-2..=2).contains(&place) {
            Ok(format!("a_{}[{place}]", ty.name()))
        } else {
            Err(ProgramFaultKind::Bounds)
        }
    }

    fn holds(&mut self, condition: &E) -> Result<bool> {
        let truth = whole(self.value(Bool, condition)?) != 0;
        self.cost += BRANCH;
        Ok(truth)
    }

    pub fn block(&mut self, list: &[S]) -> Result<End> {
        for statement in list {
            match self.statement(statement)? {
                End::Through => {}
                end => return Ok(end),
            }
        }
        Ok(End::Through)
    }

    fn statement(&mut self, statement: &S) -> Result<End> {
        match statement {
            S::Assign(ty, name, value) => {
                let v = self.value(*ty, value)?;
                self.cost += costs(*ty)[1];
                self.set(name, cut(*ty, v));
            }
            S::Element(ty, index, value) => {
                let name = self.element(*ty, index)?;
                let v = self.value(*ty, value)?;
                self.cost += costs(*ty)[1];
                self.set(&name, cut(*ty, v));
            }
            S::If(arms, otherwise) => {
                for (condition, body) in arms {
                    if self.holds(condition)? {
                        return self.block(body);
                    }
                }
                return self.block(otherwise);
            }
            S::Case(ty, selector, arms, otherwise) => {
                let n = whole(self.value(*ty, selector)?);
                let test = costs(*ty)[2] + BRANCH;
                for (labels, body) in arms {
                    for (low, high) in labels {
                        self.cost += if low != high && n >= *low { 2 * test } else { test };
                        if (*low..=*high).contains(&n) {
                            return self.block(body);
                        }
                    }
                }
                return self.block(otherwise);
            }
            S::For(ty, name, from, to, by, body) => {
                let [load, store, op, _] = costs(*ty);
                self.cost += store;
                self.set(name, V::N(*from));
                let plain = matches!(to, E::Literal(_) | E::Variable(_));
                let mut first = true;
                loop {
                    // The end is computed before each turn; reading a variable is charged once.
                    let before = self.cost;
                    let to = whole(self.value(*ty, to)?);
                    if !std::mem::take(&mut first) && plain {
                        self.cost = before;
                    }
                    self.cost += load + op + BRANCH;
                    let n = whole(self.get(name));
                    if if *by > 0 { n > to } else { n < to } {
                        break;
                    }
                    match self.block(body)? {
                        End::Exit => break,
                        End::Return => return Ok(End::Return),
                        End::Through | End::Continue => {}
                    }
                    self.cost += load + op + store + BRANCH;
                    let next = whole(self.get(name)) + by;
                    self.set(name, V::N(wrap(next, *ty)));
                }
            }
            S::While(guard, condition, body) => {
                self.count(guard, 0);
                loop {
                    let more = whole(self.value(Bool, condition)?) != 0;
                    let few = self.guard(guard);
                    self.cost += costs(Bool)[2] + BRANCH;
                    if !(more && few < 4) {
                        break;
                    }
                    self.cost += costs(Dint)[0] + costs(Dint)[2];
                    self.count(guard, few + 1);
                    match self.block(body)? {
                        End::Exit => break,
                        End::Return => return Ok(End::Return),
                        End::Through | End::Continue => self.cost += BRANCH,
                    }
                }
            }
            S::Repeat(guard, condition, body) => {
                self.count(guard, 0);
                loop {
                    self.cost += costs(Dint)[0] + costs(Dint)[2];
                    let turn = whole(self.get(guard)) + 1;
                    self.count(guard, turn);
                    match self.block(body)? {
                        End::Exit => break,
                        End::Return => return Ok(End::Return),
                        End::Through | End::Continue => {}
                    }
                    let done = whole(self.value(Bool, condition)?) != 0;
                    self.guard(guard);
                    self.cost += costs(Bool)[2] + BRANCH;
                    if done || turn >= 4 {
                        break;
                    }
                }
            }
            S::Exit => return Ok(End::Exit),
            S::Continue => return Ok(End::Continue),
            S::Return => return Ok(End::Return),
        }
        Ok(End::Through)
    }

    /// Compares a guard with a literal.
    fn guard(&mut self, guard: &str) -> i128 {
        self.cost += costs(Dint)[0] + costs(Dint)[2];
        whole(self.get(guard))
    }

    fn count(&mut self, guard: &str, n: i128) {
        self.cost += costs(Dint)[1];
        self.set(guard, V::N(n));
    }
}

/// Bits, of a BOOL one.
fn width_of(ty: Elementary) -> u32 {
    match ty {
        Real => 32,
        Lreal => 64,
        ty => width(ty).0,
    }
}
