//! Values: operators, places, conversions, selection.

use super::*;

fn bool_op(op: BinaryOp, a: Expr, b: Expr) -> Expr {
    binary(op, a, b, Bool)
}

#[test]
fn an_assignment_is_one_operation_with_all_costs() {
    let n = || global(0, Int);
    let body = || vec![set(n(), binary(BinaryOp::Add, load(n()), number(1, Int), Int))];
    let ran = run(body());
    assert_eq!((ran.nanos, ran.cell(0, Int)), (32 + 42 + 32, 1));
    assert_eq!(operations(body()), [Op::Add16, Op::Return]);
}

#[test]
fn costs_do_not_depend_on_folding() {
    // d := (a + b) * (c - d), DINT: four loads, three operations, a store.
    let v = |at| load(global(at, Dint));
    let product = binary(
        BinaryOp::Multiply,
        binary(BinaryOp::Add, v(0), v(4), Dint),
        binary(BinaryOp::Subtract, v(8), v(12), Dint),
        Dint,
    );
    let before = vec![
        set(global(0, Dint), number(2, Dint)),
        set(global(4, Dint), number(3, Dint)),
        set(global(8, Dint), number(10, Dint)),
        set(global(12, Dint), number(6, Dint)),
    ];
    let ran = run_after(before, vec![set(global(12, Dint), product)]);
    assert_eq!((ran.nanos, ran.cell(12, Dint)), (4 * 24 + 3 * 41 + 25, 20));
}

#[test]
fn long_chains_need_no_stack() {
    let mut sum = number(0, Lint);
    for n in 0..5_000 {
        sum = binary(BinaryOp::Add, sum, number(n % 7, Lint), Lint);
    }
    let expected: i64 = (0..5_000).map(|n| n % 7).sum();
    assert_eq!(run(vec![set(global(0, Lint), sum)]).cell(0, Lint), expected);
}

#[test]
fn too_deep_a_tree_is_refused() {
    let mut sum = number(1, Lint);
    for _ in 0..2_000 {
        sum = binary(BinaryOp::Add, load(global(0, Lint)), sum, Lint);
    }
    let mut findings = CompileFindings::new(&[], 10);
    let tree = program(vec![unit("MAIN", 0, vec![set(global(0, Lint), sum)])]);
    emit(tree, &Options::default(), &mut findings, &[]);
    let codes: Vec<_> = findings.finish().iter().map(|finding| finding.code).collect();
    assert_eq!(codes, ["S0504"]);
}

#[test]
fn elements_of_arrays() {
    // a[i] := a[i] + 5; x := x + a[2]
    let i = || load(global(100, Int));
    let body = vec![
        set(
            element(0, i(), 1, 4, Dint),
            binary(BinaryOp::Add, load(element(0, i(), 1, 4, Dint)), number(5, Dint), Dint),
        ),
        set(
            global(40, Dint),
            binary(BinaryOp::Add, load(global(40, Dint)), load(element(0, i(), 1, 4, Dint)), Dint),
        ),
    ];
    let before = vec![set(global(100, Int), number(3, Int))];
    let ran = run_after(before, body);
    assert_eq!((ran.cell(8, Dint), ran.cell(40, Dint)), (5, 5));
    assert_eq!(ran.nanos, 3 * (32 + 42) + (24 + 41 + 25) + (24 + 24 + 41 + 25));
}

#[test]
fn elements_of_several_dimensions() {
    let index = |n: i64, stride| Index { value: load(global(n as u32, Int)), low: 0, high: 3, stride };
    let cell = TreePlace { indices: vec![index(200, 16), index(202, 4)], ..global(0, Dint) };
    let before = vec![set(global(200, Int), number(2, Int)), set(global(202, Int), number(3, Int))];
    let ran = run_after(before, vec![set(cell, number(7, Dint))]);
    assert_eq!((ran.cell(44, Dint), ran.nanos), (7, 2 * (32 + 42) + 25));
}

#[test]
fn places_behind_addresses() {
    // p := ADR(x); p^ (at offset 4) := 9
    let p = place(TreeRoot::Absolute, map::FIRST + 64, Ty::Address);
    let address = typed(ExprKind::AddressOf(global(8, Dint)), Ty::Address);
    let pointed_at = place(TreeRoot::Address(Box::new(load(p.clone()))), 4, one(Dint));
    let ran = run(vec![set(p.clone(), address), set(pointed_at.clone(), number(9, Dint))]);
    assert_eq!((ran.cell(12, Dint), ran.nanos), (9, 25 + 24 + 25));
    // NULL is found though the offset leads to a variable.
    let tree =
        program(vec![unit("MAIN", 0, vec![set(TreePlace { offset: 100, ..pointed_at }, number(9, Dint))])]);
    let mut machine = Machine::new(Arc::new(made(tree)), &[vec![0]]).unwrap();
    machine.begin(0);
    assert!(matches!(
        machine.resume(0, Time::ZERO, Span::from_secs(1), &mut NoHost).stop,
        StopReason::Fault(_)
    ));
}

#[test]
fn bits_are_read_and_written() {
    let word = || global(0, Dint);
    let bit = |n| typed(ExprKind::LoadBit(word(), n), one(Bool));
    let ran = run(vec![
        set(word(), number(4, Dint)),
        stmt(StmtKind::Assign(Target::Bit(word(), 9), bit(2))),
        set(global(8, Bool), bit(3)),
    ]);
    assert_eq!((ran.cell(0, Dint), ran.cell(8, Bool)), (0x204, 0));
    assert_eq!(ran.nanos, 25 + 2 * (37 + 38));
}

#[test]
fn short_circuits_leave_out_what_does_not_matter() {
    for (op, left, right) in [
        (BinaryOp::AndThen, 0, 1),
        (BinaryOp::AndThen, 1, 0),
        (BinaryOp::AndThen, 1, 1),
        (BinaryOp::OrElse, 0, 0),
        (BinaryOp::OrElse, 0, 1),
        (BinaryOp::OrElse, 1, 0),
    ] {
        let before =
            vec![set(global(0, Bool), number(left, Bool)), set(global(1, Bool), number(right, Bool))];
        let sides = || bool_op(op, load(global(0, Bool)), load(global(1, Bool)));
        let branch = |value| vec![set(global(4, Int), number(value, Int))];
        let body = vec![
            set(global(2, Bool), sides()),
            stmt(StmtKind::If { arms: vec![(sides(), branch(1))], otherwise: branch(2) }),
        ];
        let ran = run_after(before, body);
        let both = (left == 1) == (op == BinaryOp::AndThen);
        let holds = if op == BinaryOp::AndThen { left & right } else { left | right };
        assert_eq!((ran.cell(2, Bool), ran.cell(4, Int)), (holds, 2 - holds), "{op:?} {left} {right}");
        let test = 37 + 75 + if both { 37 } else { 0 };
        assert_eq!(ran.nanos, test + 38 + test + 20 + 32, "{op:?} {left} {right}");
    }
}

#[test]
fn relations_of_nan_do_not_hold_in_conditions() {
    use BinaryOp::{Equal, Greater, GreaterEqual, Less, LessEqual, NotEqual};
    for (nan, ty) in [(i64::from(f32::NAN.to_bits()), Real), (f64::NAN.to_bits() as i64, Lreal)] {
        for op in [Equal, NotEqual, Less, LessEqual, Greater, GreaterEqual] {
            let compare = || bool_op(op, load(global(0, ty)), number(0, ty));
            let not = typed(ExprKind::Unary(UnaryOp::Not, Box::new(compare())), one(Bool));
            let branch = |at| vec![set(global(at, Bool), number(1, Bool))];
            let ran = run(vec![
                set(global(0, ty), number(nan, ty)),
                set(global(8, Bool), compare()),
                stmt(StmtKind::If { arms: vec![(compare(), branch(9))], otherwise: vec![] }),
                stmt(StmtKind::If { arms: vec![(not, branch(10))], otherwise: vec![] }),
            ]);
            let holds = i64::from(op == NotEqual);
            let found = [8, 9, 10].map(|at| ran.cell(at, Bool));
            assert_eq!(found, [holds, holds, 1 - holds], "{op:?}");
        }
    }
}

#[test]
fn selections_take_one_of_all() {
    // x := MUX(k, 10, x, 30)
    for (k, taken) in [(-1, 10), (0, 10), (1, 5), (2, 30), (9, 30)] {
        let x = || global(4, Dint);
        let values = vec![number(10, Dint), load(x()), number(30, Dint)];
        let mux = typed(ExprKind::Select(Box::new(load(global(0, Int))), values), one(Dint));
        let before = vec![set(global(0, Int), number(k, Int)), set(x(), number(5, Dint))];
        let ran = run_after(before, vec![set(x(), mux)]);
        // Only what is taken is read.
        let read = if k == 1 { 24 } else { 0 };
        assert_eq!((ran.cell(4, Dint), ran.nanos), (taken, 32 + read + 41 + 25), "{k}");
    }
}

#[test]
fn conversions_cost_what_the_source_writes() {
    let convert = |inner, ty| typed(ExprKind::Convert(Box::new(inner)), one(ty));
    let bits = |inner, ty| typed(ExprKind::Reinterpret(Box::new(inner)), one(ty));
    let v = |ty| load(global(0, ty));
    let before = vec![set(global(0, Int), number(-2, Int))];
    for (value, ty, expected, nanos) in [
        (convert(v(Int), Dint), Dint, -2, 32 + 41 + 25),
        (bits(v(Int), Dint), Dint, -2, 32 + 25),
        (convert(v(Int), Elementary::Byte), Elementary::Byte, 0xFE, 32 + 42 + 32),
        (convert(v(Int), Real), Real, i64::from((-2f32).to_bits()), 32 + 336 + 25),
        (convert(v(Int), Bool), Bool, 1, 32 + 42 + 38),
    ] {
        let ran = run_after(before.clone(), vec![set(global(8, ty), value)]);
        assert_eq!((ran.cell(8, ty), ran.nanos), (expected, nanos), "{ty:?}");
    }
}

#[test]
fn texts_are_copied_and_compared() {
    let ty = Ty::Text { wide: false, length: 3 };
    let s = |at| place(TreeRoot::Absolute, map::FIRST + at, ty);
    let literal = typed(ExprKind::Text(b"abcdef\0".to_vec()), Ty::Text { wide: false, length: 6 });
    let less = binary(BinaryOp::Less, load(s(0)), literal.clone(), Bool);
    let ran = run(vec![set(s(0), literal), set(s(8), load(s(0))), set(global(16, Bool), less)]);
    assert_eq!(ran.cell(8, Dint), i64::from(i32::from_le_bytes(*b"abc\0")));
    assert_eq!((ran.cell(16, Bool), ran.nanos), (1, 3 * 1000 + 38));
}

#[test]
fn constants_stand_once() {
    let body = vec![
        set(global(0, Dint), number(70_000, Dint)),
        set(global(4, Dint), number(70_000, Dint)),
        set(global(8, Int), number(5, Int)),
        set(global(10, Elementary::Uint), number(5, Elementary::Uint)),
    ];
    let made = made(program(vec![unit("MAIN", 0, body)]));
    assert_eq!(made.image.len(), made.variables_to as usize + 4 + 2);
    assert_eq!(made.variables_from, map::FIRST);
}

fn text(at: u32, length: u32) -> TreePlace {
    place(TreeRoot::Absolute, map::FIRST + at, Ty::Text { wide: false, length })
}

fn literal(bytes: &[u8]) -> Expr {
    let stored: Vec<u8> = bytes.iter().copied().chain([0]).collect();
    typed(ExprKind::Text(stored), Ty::Text { wide: false, length: bytes.len() as u32 })
}

fn function(name: &str, generic: Elementary, arguments: Vec<Expr>, ty: Ty) -> Expr {
    typed(ExprKind::Library(crate::library::find(name).unwrap(), generic, arguments), ty)
}

#[test]
fn functions_of_the_library_may_read_what_they_write() {
    // s := CONCAT(CONCAT(s, 'b'), s), cut to the room of s; n := LEN(s); x := SQRT(x)
    let long = Ty::Text { wide: false, length: 255 };
    let concat = |a, b| function("CONCAT", Bool, vec![a, b], long);
    let s = || text(0, 7);
    let twice = concat(concat(load(s()), literal(b"b")), load(s()));
    let root = function("SQRT", Lreal, vec![load(global(16, Lreal))], one(Lreal));
    let before =
        vec![set(s(), literal(b"aaaaaa")), set(global(16, Lreal), number(16f64.to_bits() as i64, Lreal))];
    let body = vec![
        set(s(), twice),
        set(global(8, Int), function("LEN", Bool, vec![load(s())], one(Int))),
        set(global(16, Lreal), root),
    ];
    let ran = run_after(before, body);
    assert_eq!(ran.cell(0, Lint).to_le_bytes(), *b"aaaaaab\0");
    assert_eq!((ran.cell(8, Int), ran.cell(16, Lreal)), (7, 4f64.to_bits() as i64));
    assert_eq!(ran.nanos, 2000 + 1000 + 32 + 50 + 1000 + 50);
}

#[test]
fn texts_and_numbers_become_each_other() {
    let convert = |inner, ty| typed(ExprKind::Convert(Box::new(inner)), ty);
    let ran = run(vec![
        set(global(16, Int), number(-45, Int)),
        set(text(0, 7), convert(load(global(16, Int)), Ty::Text { wide: false, length: 80 })),
        set(global(18, Int), convert(load(text(0, 7)), one(Int))),
    ]);
    assert_eq!((ran.cell(0, Dint), ran.cell(18, Int)), (i64::from(i32::from_le_bytes(*b"-45\0")), -45));
    assert_eq!(ran.nanos, 32 + (32 + 1000) + (1000 + 32));
}

#[test]
fn values_that_were_given_a_place() {
    // A value in the frame, reached through its address as the argument of an in-out would be.
    let hidden = place(TreeRoot::Frame, 0, one(Dint));
    let address = typed(ExprKind::AddressOf(hidden.clone()), Ty::Address);
    let kept = typed(ExprKind::Sequence(vec![set(hidden, number(7, Dint))], Box::new(address)), Ty::Address);
    let pointed_at = place(TreeRoot::Address(Box::new(kept)), 0, one(Dint));
    let main = unit("MAIN", 8, vec![set(global(0, Dint), load(pointed_at))]);
    let ran = run_tree(program(vec![main]));
    assert_eq!((ran.cell(0, Dint), ran.nanos), (7, 25 + 24 + 25));
}

#[test]
fn addresses_are_counted_on() {
    let p = place(TreeRoot::Absolute, map::FIRST + 64, Ty::Address);
    let start = typed(ExprKind::AddressOf(global(0, Dint)), Ty::Address);
    let ahead = ExprKind::Offset(Box::new(load(p.clone())), Box::new(load(global(72, Lint))));
    let pointed_at = place(TreeRoot::Address(Box::new(typed(ahead, Ty::Address))), 0, one(Dint));
    let ran =
        run(vec![set(global(72, Lint), number(8, Lint)), set(p, start), set(pointed_at, number(9, Dint))]);
    assert_eq!((ran.cell(8, Dint), ran.nanos), (9, 50 + 25 + (24 + 48 + 41) + 25));
}

#[test]
fn short_conversions_are_those_of_the_library() {
    let convert = |inner, ty| typed(ExprKind::Convert(Box::new(inner)), one(ty));
    for from in Elementary::ALL {
        for to in Elementary::ALL {
            let body = vec![set(global(8, to), convert(load(global(0, from)), to))];
            let made = made(program(vec![unit("MAIN", 0, body)]));
            for raw in
                [0, 1, 0x80, 0xFF, 0x8000, 0x7FFF_FFFF, 0xFFFF_FFFF, 0x4049_0FDB, i64::MAX, -1, i64::MIN]
            {
                let cell = if from == Bool { raw & 1 } else { from.wrap(raw) };
                let mut made = made.clone();
                let at = map::FIRST as usize;
                made.image[at..at + from.bytes()].copy_from_slice(&cell.to_le_bytes()[..from.bytes()]);
                let found = ran(made).cell(8, to);
                let expected = crate::library::convert(from, to, cell);
                assert!(found == expected, "{from:?} to {to:?}: {cell:x} is {found:x}, not {expected:x}");
            }
        }
    }
}
