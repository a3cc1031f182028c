//! Every operation on numbers against arithmetic in i128 and f64.

use super::{Board, Builder, at, cycle};
use crate::code::Op::{self, *};
use crate::host::{ProgramFaultKind, StopReason};
use proptest::prelude::*;

/// A whole number type: bits, signed.
type Whole = (u32, bool);

const B: [Whole; 4] = [(8, false), (16, false), (32, false), (64, false)];
const IU: [Whole; 8] =
    [(8, true), (8, false), (16, true), (16, false), (32, true), (32, false), (64, true), (64, false)];

fn read((bits, signed): Whole, raw: u64) -> i128 {
    let cut = i128::from(raw) & ((1 << bits) - 1);
    if signed && cut >> (bits - 1) & 1 == 1 { cut - (1 << bits) } else { cut }
}

fn cut((bits, _): Whole, n: i128) -> u64 {
    (n & ((1 << bits) - 1)) as u64
}

/// What a program of one operation gives: the destination's 8 bytes, of which the operation wrote some, over 0xA5.
fn result(op: Op, b: u64, c: u64) -> Result<u64, ProgramFaultKind> {
    let mut build = Builder::default();
    let to = build.variable(&[0xA5; 8]);
    let first = build.variable(&b.to_le_bytes());
    let second = build.variable(&c.to_le_bytes());
    build.program("MAIN", &[]);
    build.op(op, at(to), at(first), at(second));
    build.op(Return, 0, 0, 0);
    let mut machine = build.machine();
    match cycle(&mut machine, &mut Board::default()).stop {
        StopReason::Done => {
            let bytes = machine.memory()[to as usize..].first_chunk().unwrap();
            // The operands stay as they are.
            assert_eq!(machine.memory()[first as usize..][..8], b.to_le_bytes());
            assert_eq!(machine.memory()[second as usize..][..8], c.to_le_bytes());
            Ok(u64::from_le_bytes(*bytes))
        }
        StopReason::Fault(fault) => {
            assert_eq!(fault.line, 1);
            Err(fault.kind)
        }
        stop => panic!("{stop:?}"),
    }
}

/// The destination with its lowest bits written.
fn written(bits: u32, value: u64) -> u64 {
    let old = 0xA5A5_A5A5_A5A5_A5A5;
    if bits == 64 { value } else { old >> bits << bits | value & ((1 << bits) - 1) }
}

/// Which way a program of one conditional jump goes.
fn jumps(op: Op, b: u64, c: u64) -> bool {
    let mut build = Builder::default();
    let seen = build.variable(&[0]);
    let one = build.variable(&[1]);
    let first = build.variable(&b.to_le_bytes());
    let second = build.variable(&c.to_le_bytes());
    build.program("MAIN", &[]);
    build.op(op, 2, at(first), at(second));
    build.op(Move8, at(seen), at(one), 0);
    build.op(Return, 0, 0, 0);
    let mut machine = build.machine();
    assert_eq!(cycle(&mut machine, &mut Board::default()).stop, StopReason::Done);
    machine.memory()[seen as usize] == 0
}

/// Numbers at the edges, and any.
fn number() -> impl Strategy<Value = u64> {
    let edges =
        [0u64, 1, 2, 3, 0x7F, 0x80, 0xFF, 0x7FFF, 0x8000, 0xFFFF, 1 << 31, u64::MAX, 1 << 63, u64::MAX >> 1];
    prop_oneof![prop::sample::select(edges.to_vec()), any::<u64>(), 0u64..70]
}

/// Bits of real numbers, the strange ones too.
fn real() -> impl Strategy<Value = f64> {
    let edges =
        [0.0, -0.0, 1.0, -1.5, f64::NAN, -f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e-310, 3.4e38, 1e300];
    prop_oneof![prop::sample::select(edges.to_vec()), -1e6..1e6f64, any::<f64>()]
}

fn canonical64(n: f64) -> u64 {
    if n.is_nan() { 0x7FF8_0000_0000_0000 } else { n.to_bits() }
}

fn canonical32(n: f32) -> u64 {
    if n.is_nan() { 0x7FC0_0000 } else { u64::from(n.to_bits()) }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn whole_arithmetic(b in number(), c in number()) {
        type Oracle = fn(i128, i128) -> i128;
        let plain: [([Op; 4], Oracle); 7] = [
            ([Add8, Add16, Add32, Add64], |b, c| b + c),
            ([Sub8, Sub16, Sub32, Sub64], |b, c| b - c),
            ([Mul8, Mul16, Mul32, Mul64], i128::wrapping_mul),
            ([And8, And16, And32, And64], |b, c| b & c),
            ([Or8, Or16, Or32, Or64], |b, c| b | c),
            ([Xor8, Xor16, Xor32, Xor64], |b, c| b ^ c),
            ([Move8, Move16, Move32, Move64], |b, _| b),
        ];
        for (ops, oracle) in plain {
            for (op, ty) in ops.into_iter().zip(B) {
                let expected = cut(ty, oracle(read(ty, b), read(ty, c)));
                prop_assert_eq!(result(op, b, c), Ok(written(ty.0, expected)), "{:?}", op);
            }
        }
        type Single = fn(i128) -> i128;
        let single: [([Op; 4], Single); 2] = [
            ([Neg8, Neg16, Neg32, Neg64], |b| -b),
            ([Not8, Not16, Not32, Not64], |b| !b),
        ];
        for (ops, oracle) in single {
            for (op, ty) in ops.into_iter().zip(B) {
                prop_assert_eq!(result(op, b, c), Ok(written(ty.0, cut(ty, oracle(read(ty, b))))), "{:?}", op);
            }
        }
        for (op, ty) in [AbsI8, AbsI16, AbsI32, AbsI64].into_iter().zip([8, 16, 32, 64].map(|bits| (bits, true))) {
            prop_assert_eq!(result(op, b, c), Ok(written(ty.0, cut(ty, read(ty, b).abs()))), "{:?}", op);
        }
        let typed: [([Op; 8], Oracle); 2] = [
            ([MinI8, MinU8, MinI16, MinU16, MinI32, MinU32, MinI64, MinU64], |b, c| if b < c { b } else { c }),
            ([MaxI8, MaxU8, MaxI16, MaxU16, MaxI32, MaxU32, MaxI64, MaxU64], |b, c| if b > c { b } else { c }),
        ];
        for (ops, oracle) in typed {
            for (op, ty) in ops.into_iter().zip(IU) {
                let expected = cut(ty, oracle(read(ty, b), read(ty, c)));
                prop_assert_eq!(result(op, b, c), Ok(written(ty.0, expected)), "{:?}", op);
            }
        }
        prop_assert_eq!(result(NotBool, b, c), Ok(written(8, u64::from(b & 0xFF == 0))));
    }

    #[test]
    fn division(b in number(), c in number()) {
        // Towards 0, the sign of MOD that of the dividend; MIN / -1 wraps.
        type Oracle = fn(i128, i128) -> i128;
        let ops: [([Op; 8], Oracle); 2] = [
            ([DivI8, DivU8, DivI16, DivU16, DivI32, DivU32, DivI64, DivU64], |b, c| b / c),
            ([ModI8, ModU8, ModI16, ModU16, ModI32, ModU32, ModI64, ModU64], |b, c| b % c),
        ];
        for (ops, oracle) in ops {
            for (op, ty) in ops.into_iter().zip(IU) {
                let (n, d) = (read(ty, b), read(ty, c));
                let expected = if d == 0 {
                    Err(ProgramFaultKind::DivisionByZero)
                } else {
                    Ok(written(ty.0, cut(ty, oracle(n, d))))
                };
                prop_assert_eq!(result(op, b, c), expected, "{:?}", op);
            }
        }
    }

    #[test]
    fn shifts(b in number(), n in prop_oneof![-70i64..140, any::<i64>()]) {
        let ops = [
            ([Shl8, Shl16, Shl32, Shl64], 0),
            ([ShrU8, ShrU16, ShrU32, ShrU64], 1),
            ([ShrI8, ShrI16, ShrI32, ShrI64], 4),
            ([Rol8, Rol16, Rol32, Rol64], 2),
            ([Ror8, Ror16, Ror32, Ror64], 3),
        ];
        for (ops, kind) in ops {
            for (op, ty) in ops.into_iter().zip(B) {
                let bits = i64::from(ty.0);
                // Bit by bit.
                let mut expected = 0u64;
                for to in 0..bits {
                    let from = match kind {
                        0 => Some(to - n.clamp(-1, 100)).filter(|_| n >= 0),
                        1 => Some(to + n.clamp(-1, 100)).filter(|_| n >= 0),
                        4 => Some((to + n.clamp(-1, 100)).min(bits - 1)).filter(|_| n >= 0),
                        2 => Some((to - n % bits + bits) % bits),
                        _ => Some((to + n % bits + bits) % bits),
                    };
                    if let Some(from) = from.filter(|from| (0..bits).contains(from)) {
                        expected |= (b >> from & 1) << to;
                    }
                }
                prop_assert_eq!(result(op, b, n as u64), Ok(written(ty.0, expected)), "{:?} {}", op, n);
            }
        }
    }

    #[test]
    fn comparisons(b in number(), c in number()) {
        let pairs = [(b, c), (b, b)];
        for (b, c) in pairs {
            for (nth, ty) in B.into_iter().enumerate() {
                let (x, y) = (read(ty, b), read(ty, c));
                let eq = ([Eq8, Eq16, Eq32, Eq64][nth], [JumpEq8, JumpEq16, JumpEq32, JumpEq64][nth], x == y);
                let ne = ([Ne8, Ne16, Ne32, Ne64][nth], [JumpNe8, JumpNe16, JumpNe32, JumpNe64][nth], x != y);
                for (op, jump, holds) in [eq, ne] {
                    prop_assert_eq!(result(op, b, c), Ok(written(8, u64::from(holds))), "{:?}", op);
                    prop_assert_eq!(jumps(jump, b, c), holds, "{:?}", jump);
                }
            }
            const LT: [Op; 8] = [LtI8, LtU8, LtI16, LtU16, LtI32, LtU32, LtI64, LtU64];
            const LE: [Op; 8] = [LeI8, LeU8, LeI16, LeU16, LeI32, LeU32, LeI64, LeU64];
            const JUMP_LT: [Op; 8] =
                [JumpLtI8, JumpLtU8, JumpLtI16, JumpLtU16, JumpLtI32, JumpLtU32, JumpLtI64, JumpLtU64];
            const JUMP_LE: [Op; 8] =
                [JumpLeI8, JumpLeU8, JumpLeI16, JumpLeU16, JumpLeI32, JumpLeU32, JumpLeI64, JumpLeU64];
            for (nth, ty) in IU.into_iter().enumerate() {
                let (x, y) = (read(ty, b), read(ty, c));
                for (op, jump, holds) in [(LT[nth], JUMP_LT[nth], x < y), (LE[nth], JUMP_LE[nth], x <= y)] {
                    prop_assert_eq!(result(op, b, c), Ok(written(8, u64::from(holds))), "{:?}", op);
                    prop_assert_eq!(jumps(jump, b, c), holds, "{:?}", jump);
                }
            }
        }
    }

    #[test]
    fn widening(b in number()) {
        let sign = [(Sign8To16, 8, 16), (Sign8To32, 8, 32), (Sign8To64, 8, 64), (Sign16To32, 16, 32), (Sign16To64, 16, 64), (Sign32To64, 32, 64)];
        let zero = [(Zero8To16, 8, 16), (Zero8To32, 8, 32), (Zero8To64, 8, 64), (Zero16To32, 16, 32), (Zero16To64, 16, 64), (Zero32To64, 32, 64)];
        for (signed, (op, from, to)) in sign.map(|op| (true, op)).into_iter().chain(zero.map(|op| (false, op))) {
            let expected = cut((to, false), read((from, signed), b));
            prop_assert_eq!(result(op, b, 0), Ok(written(to, expected)), "{:?}", op);
        }
        let (short, long) = (read((16, true), b) as f64, read((32, true), b) as f64);
        prop_assert_eq!(result(I16ToF32, b, 0), Ok(written(32, canonical32(short as f32))));
        prop_assert_eq!(result(I32ToF32, b, 0), Ok(written(32, canonical32(long as f32))));
        prop_assert_eq!(result(I32ToF64, b, 0), Ok(canonical64(long)));
    }

    #[test]
    fn real_arithmetic(b in real(), c in real()) {
        let (s, t) = (b as f32, c as f32);
        let raw = |n: f32| u64::from(n.to_bits());
        type Oracle = fn(f64, f64) -> f64;
        // The sum, difference, product or quotient of two singles, computed in double, rounds to the same single.
        let ops: [(Op, Op, Oracle); 4] = [
            (AddF32, AddF64, |b, c| b + c),
            (SubF32, SubF64, |b, c| b - c),
            (MulF32, MulF64, |b, c| b * c),
            (DivF32, DivF64, |b, c| b / c),
        ];
        for (single, double, oracle) in ops {
            if double == DivF64 && c == 0.0 || single == DivF32 && t == 0.0 {
                let zero = Err(ProgramFaultKind::RealDivisionByZero);
                prop_assert_eq!(result(single, raw(s), raw(t)), zero);
                prop_assert!(c != 0.0 || result(double, b.to_bits(), c.to_bits()) == zero);
                continue;
            }
            let expected = canonical32(oracle(f64::from(s), f64::from(t)) as f32);
            prop_assert_eq!(result(single, raw(s), raw(t)), Ok(written(32, expected)), "{:?}", single);
            prop_assert_eq!(result(double, b.to_bits(), c.to_bits()), Ok(canonical64(oracle(b, c))), "{:?}", double);
        }
        prop_assert_eq!(result(NegF32, raw(s), 0), Ok(written(32, canonical32(-s))));
        prop_assert_eq!(result(NegF64, b.to_bits(), 0), Ok(canonical64(-b)));
        prop_assert_eq!(result(AbsF32, raw(s), 0), Ok(written(32, canonical32(s.abs()))));
        prop_assert_eq!(result(AbsF64, b.to_bits(), 0), Ok(canonical64(b.abs())));
        prop_assert_eq!(result(F32ToF64, raw(s), 0), Ok(canonical64(f64::from(s))));
        // By the total order of IEEE 754, but for NaN.
        let least = |b: f64, c: f64| if b.is_nan() || c.is_nan() { f64::NAN } else if b.total_cmp(&c).is_lt() { b } else { c };
        let most = |b: f64, c: f64| if b.is_nan() || c.is_nan() { f64::NAN } else if b.total_cmp(&c).is_gt() { b } else { c };
        for (single, double, expected) in [(MinF32, MinF64, least as Oracle), (MaxF32, MaxF64, most)] {
            let short = canonical32(expected(f64::from(s), f64::from(t)) as f32);
            prop_assert_eq!(result(single, raw(s), raw(t)), Ok(written(32, short)));
            prop_assert_eq!(result(double, b.to_bits(), c.to_bits()), Ok(canonical64(expected(b, c))));
        }
        for (b, c) in [(b, c), (b, b)] {
            let order = b.partial_cmp(&c);
            let (eq, lt) = (order.is_some_and(|o| o.is_eq()), order.is_some_and(|o| o.is_lt()));
            let all = [
                (EqF64, JumpEqF64, eq),
                (NeF64, JumpNeF64, !eq),
                (LtF64, JumpLtF64, lt),
                (LeF64, JumpLeF64, lt || eq),
            ];
            for (op, jump, holds) in all {
                prop_assert_eq!(result(op, b.to_bits(), c.to_bits()), Ok(written(8, u64::from(holds))), "{:?}", op);
                prop_assert_eq!(jumps(jump, b.to_bits(), c.to_bits()), holds, "{:?}", jump);
            }
            prop_assert_eq!(jumps(JumpNotLtF64, b.to_bits(), c.to_bits()), !lt);
            prop_assert_eq!(jumps(JumpNotLeF64, b.to_bits(), c.to_bits()), !(lt || eq));
            let (s, t) = (b as f32, c as f32);
            let (eq, lt) = (s == t, s < t);
            let all = [
                (EqF32, JumpEqF32, eq),
                (NeF32, JumpNeF32, !eq),
                (LtF32, JumpLtF32, lt),
                (LeF32, JumpLeF32, lt || eq),
            ];
            for (op, jump, holds) in all {
                prop_assert_eq!(result(op, raw(s), raw(t)), Ok(written(8, u64::from(holds))), "{:?}", op);
                prop_assert_eq!(jumps(jump, raw(s), raw(t)), holds, "{:?}", jump);
            }
            prop_assert_eq!(jumps(JumpNotLtF32, raw(s), raw(t)), !lt);
            prop_assert_eq!(jumps(JumpNotLeF32, raw(s), raw(t)), !(lt || eq));
        }
    }

    #[test]
    fn loops(b in number(), c in number()) {
        const FOR: [Op; 8] = [ForI8, ForU8, ForI16, ForU16, ForI32, ForU32, ForI64, ForU64];
        for (nth, ty) in IU.into_iter().enumerate() {
            let (n, end) = (read(ty, b), read(ty, c));
            let next = read(ty, cut(ty, n + 1));
            prop_assert_eq!(turn(FOR[nth], b, c), (next <= end, over(ty, b, next)), "{:?}", FOR[nth]);
        }
    }
}

/// The variable with its lowest bits replaced.
fn over((bits, _): Whole, old: u64, value: i128) -> u64 {
    if bits == 64 { value as u64 } else { old >> bits << bits | cut((bits, false), value) }
}

/// Whether a loop's operation jumps, and its variable afterwards.
fn turn(op: Op, b: u64, c: u64) -> (bool, u64) {
    let mut build = Builder::default();
    let seen = build.variable(&[0]);
    let one = build.variable(&[1]);
    let variable = build.variable(&b.to_le_bytes());
    let other = build.variable(&c.to_le_bytes());
    build.program("MAIN", &[]);
    build.op(op, 2, at(variable), at(other));
    build.op(Move8, at(seen), at(one), 0);
    build.op(Return, 0, 0, 0);
    let mut machine = build.machine();
    assert_eq!(cycle(&mut machine, &mut Board::default()).stop, StopReason::Done);
    let value = u64::from_le_bytes(*machine.memory()[variable as usize..].first_chunk().unwrap());
    (machine.memory()[seen as usize] == 0, value)
}
