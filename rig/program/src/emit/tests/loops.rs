//! Conditions, CASE and loops: which way they go and what each turn costs.

use super::*;

const TURN: i64 = 20;

fn n() -> TreePlace {
    global(0, Int)
}

fn grow(by: i64) -> Stmt {
    set(n(), binary(BinaryOp::Add, load(n()), number(by, Int), Int))
}

const GROW: i64 = 32 + 42 + 32;

fn compare(op: BinaryOp, with: i64) -> Expr {
    binary(op, load(n()), number(with, Int), Bool)
}

fn counted(from: i64, to: Expr, by: Option<Expr>, body: Vec<Stmt>, ty: Elementary) -> Stmt {
    let from = number(from, ty);
    stmt(StmtKind::For(Box::new(For { variable: global(8, ty), from, to, by, body, end: AT })))
}

#[test]
fn while_tests_before_each_turn() {
    let body =
        vec![stmt(StmtKind::While { condition: compare(BinaryOp::Less, 3), body: vec![grow(1)], end: AT })];
    let ran = run(body);
    assert_eq!(ran.cell(0, Int), 3);
    assert_eq!(ran.nanos, 4 * (32 + 42 + 20) + 3 * (GROW + TURN));
}

#[test]
fn while_with_a_long_condition_costs_the_same() {
    let mut long = load(n());
    for _ in 0..20 {
        long = binary(BinaryOp::Add, long, number(0, Int), Int);
    }
    let condition = binary(BinaryOp::Less, long, number(3, Int), Bool);
    let ran = run(vec![stmt(StmtKind::While { condition, body: vec![grow(1)], end: AT })]);
    assert_eq!(ran.cell(0, Int), 3);
    assert_eq!(ran.nanos, 4 * (32 + 21 * 42 + 20) + 3 * (GROW + TURN));
}

#[test]
fn repeat_tests_after_each_turn() {
    let until = compare(BinaryOp::GreaterEqual, 3);
    let ran = run(vec![stmt(StmtKind::Repeat { body: vec![grow(1)], until })]);
    assert_eq!((ran.cell(0, Int), ran.nanos), (3, 3 * (GROW + 32 + 42 + TURN)));
}

#[test]
fn for_counts_by_one() {
    let ran = run(vec![counted(1, number(4, Int), None, vec![grow(2)], Int)]);
    assert_eq!((ran.cell(0, Int), ran.cell(8, Int)), (8, 5));
    let (test, next) = (32 + 42 + 20, 32 + 42 + 32 + TURN);
    assert_eq!(ran.nanos, 32 + 5 * test + 4 * (GROW + next));
    // Not at all.
    let ran = run(vec![counted(5, number(4, Int), None, vec![grow(2)], Int)]);
    assert_eq!((ran.cell(0, Int), ran.cell(8, Int), ran.nanos), (0, 5, 32 + test));
}

#[test]
fn for_counts_by_any_step() {
    let by = |n| vec![number(n, Lint), load(global(16, Lint))];
    for (from, to, step, turns, end) in
        [(1, 10, 3, 4, 13), (10, 1, -3, 4, -2), (1, 0, 2, 0, 1), (0, 1, -1, 0, 0), (5, 5, -5, 1, 0)]
    {
        for by in by(step) {
            let before = vec![set(global(16, Lint), number(step, Lint))];
            let load_step = if matches!(by.kind, ExprKind::Load(_)) { 48 } else { 0 };
            let ran = run_after(before, vec![counted(from, number(to, Int), Some(by), vec![grow(1)], Int)]);
            assert_eq!((ran.cell(0, Int), ran.cell(8, Int)), (turns, end), "{from} {to} {step}");
            let (test, next) = (32 + 42 + 20, 32 + 42 + 32 + TURN);
            assert_eq!(
                ran.nanos,
                32 + load_step + (turns + 1) * test + turns * (GROW + next),
                "{from} {to} {step}"
            );
        }
    }
}

#[test]
fn for_goes_on_at_the_other_end_of_its_type() {
    use Elementary::{Sint, Usint};
    let five = || {
        let exit = vec![stmt(StmtKind::Exit)];
        let arms = vec![(compare(BinaryOp::Equal, 5), exit)];
        vec![grow(1), stmt(StmtKind::If { arms, otherwise: vec![] })]
    };
    let ran = run(vec![counted(125, number(127, Sint), None, five(), Sint)]);
    assert_eq!((ran.cell(0, Int), ran.cell(8, Sint)), (5, -127));
    let ran = run(vec![counted(250, number(255, Usint), Some(number(4, Lint)), five(), Usint)]);
    assert_eq!((ran.cell(0, Int), ran.cell(8, Usint)), (5, 10));
}

#[test]
fn for_computes_its_end_before_each_turn() {
    let (test, next) = (32 + 42 + 20, 32 + 42 + 32 + TURN);
    let before = || vec![set(n(), number(6, Int))];
    let ran = run_after(before(), vec![counted(1, load(n()), None, vec![grow(-1)], Int)]);
    assert_eq!((ran.cell(0, Int), ran.cell(8, Int)), (3, 4));
    // Reading it is charged once.
    assert_eq!(ran.nanos, 32 + 32 + 4 * test + 3 * (GROW + next));
    // The same where it takes operations, and where it has more bits than the variable.
    let sum = binary(BinaryOp::Add, load(n()), number(0, Int), Int);
    let wide = |inner| typed(ExprKind::Reinterpret(Box::new(inner)), Ty::Promoted(Int));
    for (end, more) in [(sum, 32 + 42), (wide(load(n())), 32)] {
        let ran = run_after(before(), vec![counted(1, end, None, vec![grow(-1)], Int)]);
        assert_eq!((ran.cell(0, Int), ran.cell(8, Int)), (3, 4));
        assert_eq!(ran.nanos, 32 + 4 * (test + more) + 3 * (GROW + next));
    }
}

#[test]
fn exit_and_continue() {
    // Counts to 10, skips at 3, leaves at 6.
    let at = |value| binary(BinaryOp::Equal, load(global(8, Int)), number(value, Int), Bool);
    let when =
        |value, kind| stmt(StmtKind::If { arms: vec![(at(value), vec![stmt(kind)])], otherwise: vec![] });
    let body = vec![when(3, StmtKind::Continue), when(6, StmtKind::Exit), grow(1)];
    let ran = run(vec![counted(1, number(10, Int), None, body, Int), grow(100)]);
    assert_eq!((ran.cell(0, Int), ran.cell(8, Int)), (104, 6));
}

#[test]
fn case_tests_label_after_label() {
    let one_test = 42 + 20;
    for (value, expected, tests) in [
        (1, 1, 1),
        (2, 1, 2),
        (5, 2, 2 + 2),
        (7, 2, 2 + 2),
        (8, 3, 2 + 2 + 1),
        (20, 9, 2 + 2 + 1),
        (0, 9, 2 + 1 + 1),
    ] {
        let put = |value| vec![set(global(4, Int), number(value, Int))];
        let arms = vec![(vec![(1, 1), (2, 2)], put(1)), (vec![(5, 7)], put(2)), (vec![(8, 8)], put(3))];
        let case = stmt(StmtKind::Case { selector: load(n()), arms, otherwise: put(9) });
        let ran = run_after(vec![set(n(), number(value, Int))], vec![case]);
        assert_eq!((ran.cell(4, Int), ran.nanos), (expected, 32 + tests * one_test + 32), "{value}");
    }
}

#[test]
fn a_selector_of_case_that_is_computed_is_charged() {
    let narrow = typed(ExprKind::Convert(Box::new(load(global(8, Dint)))), one(Int));
    let arms = vec![(vec![(3, 4), (9, 9)], vec![grow(1)])];
    let case = stmt(StmtKind::Case { selector: narrow, arms, otherwise: vec![] });
    let ran = run_after(vec![set(global(8, Dint), number(9, Dint))], vec![case]);
    assert_eq!((ran.cell(0, Int), ran.nanos), (1, 24 + 41 + 3 * (42 + 20) + GROW));
}

#[test]
fn conditions_of_several_comparisons_cost_all_of_them() {
    use BinaryOp::{And, Greater, Less, Or};
    for op in [And, Or] {
        for (value, on) in [(2, 0), (2, 1), (5, 0), (5, 1), (9, 0), (9, 1)] {
            // (n > 3 AND n < 7) op b
            let inside = binary(And, compare(Greater, 3), compare(Less, 7), Bool);
            let whole = || binary(op, inside.clone(), load(global(20, Bool)), Bool);
            let not = typed(ExprKind::Unary(UnaryOp::Not, Box::new(whole())), one(Bool));
            let branch = |at| vec![set(global(at, Bool), number(1, Bool))];
            let before = vec![set(n(), number(value, Int)), set(global(20, Bool), number(on, Bool))];
            let body = vec![
                stmt(StmtKind::If { arms: vec![(whole(), branch(30))], otherwise: vec![] }),
                stmt(StmtKind::If { arms: vec![(not, branch(31))], otherwise: vec![] }),
            ];
            let ran = run_after(before, body);
            let (a, b) = (value == 5, on == 1);
            let holds = i64::from(if op == And { a && b } else { a || b });
            assert_eq!((ran.cell(30, Bool), ran.cell(31, Bool)), (holds, 1 - holds), "{op:?} {value} {on}");
            let test = 2 * (32 + 42) + 2 * 75 + 37 + 20;
            assert_eq!(ran.nanos, 2 * test + 75 + 38, "{op:?} {value} {on}");
        }
    }
    let sides = binary(And, compare(Greater, 3), compare(Less, 7), Bool);
    let body = vec![stmt(StmtKind::If { arms: vec![(sides, vec![grow(1)])], otherwise: vec![] })];
    assert_eq!(operations(body), [Op::JumpLeI16, Op::JumpLeI16, Op::Add16, Op::Return]);
}

#[test]
fn jumps_to_jumps_are_left_out() {
    let when = |value, body, otherwise| {
        stmt(StmtKind::If { arms: vec![(compare(BinaryOp::Equal, value), body)], otherwise })
    };
    let inner = when(1, vec![grow(1)], vec![grow(2)]);
    let made = made(program(vec![unit("MAIN", 0, vec![when(2, vec![inner], vec![grow(3)]), grow(4)])]));
    let jumps: Vec<u32> = made.code.iter().filter(|step| step.op == Op::Jump).map(|step| step.a).collect();
    assert_eq!(jumps, [7, 7]);
}

#[test]
fn every_statement_has_its_first_operation() {
    let body = vec![
        grow(1),
        stmt(StmtKind::If {
            arms: vec![(compare(BinaryOp::Equal, 1), vec![grow(1)])],
            otherwise: vec![grow(2)],
        }),
        grow(3),
    ];
    let made = made(program(vec![unit("MAIN", 0, body)]));
    let places: Vec<u32> = made.statements.iter().map(|statement| statement.pc).collect();
    assert_eq!(places, [0, 1, 2, 4, 5]);
    assert!(made.statements.iter().all(|statement| statement.line == 1));
}

#[test]
fn too_long_a_program_is_refused() {
    let mut options = Options::default();
    options.limits.code = 3;
    let mut findings = CompileFindings::new(&[], 10);
    let tree = program(vec![unit("MAIN", 0, vec![grow(1), grow(1), grow(1), grow(1)])]);
    emit(tree, &options, &mut findings, &[]);
    let codes: Vec<_> = findings.finish().iter().map(|finding| finding.code).collect();
    assert_eq!(codes, ["S0505"]);
}
