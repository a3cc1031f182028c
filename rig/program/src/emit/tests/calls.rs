//! Calls: the order in which things happen, frames, instances, and what they cost.

use super::*;
use crate::code::ObjectClass;

fn frame(offset: u32, ty: Elementary) -> TreePlace {
    place(TreeRoot::Frame, offset, one(ty))
}

fn this(offset: u32, ty: Elementary) -> TreePlace {
    place(TreeRoot::This, offset, one(ty))
}

fn input(offset: u32, value: Expr) -> CallInput {
    CallInput { to: Slot::Frame(offset, value.ty), value }
}

fn call(callee: Callee, inputs: Vec<CallInput>, outputs: Vec<CallOutput>, result: Option<u32>) -> Expr {
    typed(ExprKind::Call(Box::new(TreeCall { callee, inputs, outputs, result, at: AT })), one(Dint))
}

fn add(a: Expr, b: Expr) -> Expr {
    binary(BinaryOp::Add, a, b, Dint)
}

/// `F := a - b`, and counts itself in a global variable at 100.
fn difference() -> UnitTree {
    let count = || global(100, Dint);
    let body = vec![
        set(count(), add(load(count()), number(1, Dint))),
        set(frame(0, Dint), binary(BinaryOp::Subtract, load(frame(4, Dint)), load(frame(8, Dint)), Dint)),
    ];
    unit("F", 12, body)
}

fn minus(a: Expr, b: Expr) -> Expr {
    call(Callee::Unit(1), vec![input(4, a), input(8, b)], vec![], Some(0))
}

const BODY: i64 = (24 + 41 + 25) + (24 + 24 + 41 + 25);

#[test]
fn a_function_costs_its_call_and_its_body() {
    let main = unit("MAIN", 0, vec![set(global(0, Dint), minus(number(9, Dint), number(4, Dint)))]);
    let ran = run_tree(program(vec![main, difference()]));
    assert_eq!((ran.cell(0, Dint), ran.nanos), (5, 200 + BODY + 25));
}

#[test]
fn calls_inside_calls_do_not_disturb_each_other() {
    // F(F(9, 4), F(3, 1)) - F(2, F(1, 1)) = 3 - 2
    let k = |n| number(n, Dint);
    let inner = minus(minus(k(9), k(4)), minus(k(3), k(1)));
    let value = binary(BinaryOp::Subtract, inner, minus(k(2), minus(k(1), k(1))), Dint);
    let ran = run_tree(program(vec![unit("MAIN", 0, vec![set(global(0, Dint), value)]), difference()]));
    assert_eq!((ran.cell(0, Dint), ran.cell(100, Dint)), (1, 5));
    assert_eq!(ran.nanos, 5 * (200 + BODY) + 41 + 25);
}

#[test]
fn what_a_call_changes_was_read_before() {
    // x := count + F(0, 0) * 0 + count: 0 before the call, 1 after it.
    let count = || load(global(100, Dint));
    let zero = binary(BinaryOp::Multiply, minus(number(0, Dint), number(0, Dint)), number(0, Dint), Dint);
    let sum = add(add(count(), zero), count());
    // As an argument too: F(count, F(0, 0)), which counts to 3.
    let argument = minus(count(), minus(number(0, Dint), number(0, Dint)));
    let body = vec![set(global(0, Dint), sum), set(global(4, Dint), argument)];
    let ran = run_tree(program(vec![unit("MAIN", 0, body), difference()]));
    assert_eq!((ran.cell(0, Dint), ran.cell(4, Dint), ran.cell(100, Dint)), (1, 1, 3));
}

#[test]
fn outputs_of_functions() {
    // F writes 7 to its output at 4; `F(out => NOT g)` and the result in one expression.
    let f = unit("F", 12, vec![set(frame(0, Dint), number(5, Dint)), set(frame(4, Bool), number(1, Bool))]);
    let outputs = vec![
        CallOutput { from: Slot::Frame(4, one(Bool)), negated: true, target: Target::Place(global(8, Bool)) },
        CallOutput {
            from: Slot::Frame(4, one(Bool)),
            negated: false,
            target: Target::Bit(global(12, Int), 3),
        },
        CallOutput {
            from: Slot::Frame(0, one(Dint)),
            negated: false,
            target: Target::Place(global(16, Lint)),
        },
    ];
    let value = add(call(Callee::Unit(1), vec![], outputs, Some(0)), number(1, Dint));
    let before = vec![set(global(8, Bool), number(1, Bool))];
    let main = unit("MAIN", 0, before.into_iter().chain([set(global(0, Dint), value)]).collect());
    let ran = run_tree(program(vec![main, f]));
    assert_eq!((ran.cell(0, Dint), ran.cell(8, Bool), ran.cell(12, Int), ran.cell(16, Lint)), (6, 0, 8, 5));
    let outputs = (37 + 75 + 38) + (37 + 38) + (24 + 50);
    assert_eq!(ran.nanos, 38 + 200 + 25 + 38 + outputs + 41 + 25);
}

/// A block that adds its input at 0 to its sum at 4.
fn adder() -> UnitTree {
    unit("ADDER", 0, vec![set(this(4, Dint), add(load(this(4, Dint)), load(this(0, Dint))))])
}

#[test]
fn blocks_at_fixed_places() {
    let pin = CallInput { to: Slot::Place(global(32, Dint)), value: number(6, Dint) };
    let callee = Callee::Of(1, place(TreeRoot::Absolute, map::FIRST + 32, Ty::Block { bytes: 8 }));
    let sum = CallOutput {
        from: Slot::Place(global(36, Dint)),
        negated: false,
        target: Target::Place(global(0, Dint)),
    };
    let statement = stmt(StmtKind::Call(Box::new(call(callee, vec![pin], vec![sum], None))));
    let ran = run_tree(program(vec![unit("MAIN", 0, vec![statement]), adder()]));
    assert_eq!((ran.cell(0, Dint), ran.nanos), (6, 25 + 200 + (24 + 24 + 41 + 25) + 24 + 25));
}

#[test]
fn blocks_in_arrays_compute_their_index_once() {
    // The input of b[i] is F(i, 0), which may change everything.
    let at = |offset, ty| {
        let index = Index { value: load(global(100, Dint)), low: 0, high: 3, stride: 8 };
        TreePlace { indices: vec![index], ..place(TreeRoot::Absolute, map::FIRST + 32 + offset, ty) }
    };
    let value = minus(number(9, Dint), number(0, Dint));
    let pin = CallInput { to: Slot::Place(at(0, one(Dint))), value };
    let sum = CallOutput {
        from: Slot::Place(at(4, one(Dint))),
        negated: false,
        target: Target::Place(global(0, Dint)),
    };
    let callee = Callee::Of(2, at(0, Ty::Block { bytes: 8 }));
    let statement = stmt(StmtKind::Call(Box::new(call(callee, vec![pin], vec![sum], None))));
    let ran = run_tree(program(vec![unit("MAIN", 0, vec![statement]), difference(), adder()]));
    assert_eq!((ran.cell(0, Dint), ran.cell(36, Dint), ran.cell(44, Dint)), (9, 9, 0));
    let index = 24 + 42;
    assert_eq!(ran.nanos, index + (200 + BODY) + 25 + 200 + (24 + 24 + 41 + 25) + 24 + 25);
}

#[test]
fn native_blocks_cost_a_block() {
    let native = crate::native::STANDARD.iter().find(|native| native.name == "R_TRIG").unwrap();
    let callee = Callee::Native(0, place(TreeRoot::Absolute, map::FIRST + 32, Ty::Block { bytes: 24 }));
    let pin = CallInput { to: Slot::Place(global(32, Bool)), value: number(1, Bool) };
    let statement = stmt(StmtKind::Call(Box::new(call(callee, vec![pin], vec![], None))));
    let mut tree = program(vec![unit("MAIN", 0, vec![statement])]);
    tree.natives = vec![native];
    assert_eq!(run_tree(tree).nanos, 38 + 400);
}

#[test]
fn methods_are_found_by_the_class_of_the_instance() {
    // Two classes with one method each: M := x + 1 and M := x + 2. The class word stands at 0 of an instance.
    let method = |n| unit("M", 8, vec![set(frame(0, Dint), add(load(frame(4, Dint)), number(n, Dint)))]);
    let reference = place(TreeRoot::Absolute, map::FIRST + 64, Ty::Address);
    let through = |x| {
        let callee = Callee::Virtual(0, load(reference.clone()));
        call(callee, vec![input(4, x)], vec![], Some(0))
    };
    let instance =
        |at| typed(ExprKind::AddressOf(place(TreeRoot::Absolute, map::FIRST + at, one(Dint))), Ty::Address);
    let body = vec![
        set(reference.clone(), instance(32)),
        set(global(0, Dint), through(number(10, Dint))),
        set(reference.clone(), instance(40)),
        set(global(4, Dint), through(through(number(10, Dint)))),
    ];
    let mut tree = program(vec![unit("MAIN", 0, body), method(1), method(2)]);
    let class = |unit| ObjectClass { methods: vec![Some(unit)], kinds: Vec::new() };
    tree.classes = vec![class(1), class(2)];
    tree.variables[32] = 1;
    tree.variables[40] = 2;
    let ran = run_tree(tree);
    assert_eq!((ran.cell(0, Dint), ran.cell(4, Dint)), (11, 14));
    let main = ran.machine.program().units.first().unwrap();
    assert_eq!(main.calls, [1, 2]);
}

#[test]
fn what_is_written_of_the_outputs_is_known() {
    let output = |offset, ty| place(TreeRoot::Absolute, map::OUTPUTS + offset, one(ty));
    let body = vec![
        set(output(2, Elementary::Word), number(1, Elementary::Word)),
        stmt(StmtKind::Assign(Target::Bit(output(0, Bool), 5), number(1, Bool))),
        stmt(StmtKind::Assign(Target::Bit(output(0, Bool), 5), number(0, Bool))),
        set(global(0, Elementary::Word), load(output(8, Elementary::Word))),
    ];
    assert_eq!(made(program(vec![unit("MAIN", 0, body)])).units[0].writes, [(5, 1), (16, 16)]);
}

#[test]
fn in_outs_stand_in_the_frame() {
    // F(x) with an in-out at 4: x := x + 1.
    let x = || place(TreeRoot::Address(Box::new(load(place(TreeRoot::Frame, 4, Ty::Address)))), 0, one(Dint));
    let f = unit("F", 8, vec![set(x(), add(load(x()), number(1, Dint)))]);
    let address = typed(ExprKind::AddressOf(global(20, Dint)), Ty::Address);
    let statement =
        stmt(StmtKind::Call(Box::new(call(Callee::Unit(1), vec![input(4, address)], vec![], None))));
    let tree = program(vec![unit("MAIN", 0, vec![statement]), f]);
    let ran = run_tree(tree);
    assert_eq!((ran.cell(20, Dint), ran.nanos), (1, 200 + 2 * 24 + 24 + 41 + 25));
}

#[test]
fn instances_are_asked_for_their_kind() {
    let reference = place(TreeRoot::Absolute, map::FIRST + 64, Ty::Address);
    let is = |kind| typed(ExprKind::IsKind(Box::new(load(reference.clone())), kind), one(Bool));
    let instance = typed(ExprKind::AddressOf(global(32, Dint)), Ty::Address);
    let body = vec![
        set(global(0, Bool), is(1)),
        set(reference.clone(), instance),
        set(global(1, Bool), is(1)),
        set(global(2, Bool), is(0)),
    ];
    let mut tree = program(vec![unit("MAIN", 0, body)]);
    tree.classes = vec![ObjectClass { methods: Vec::new(), kinds: vec![1] }];
    tree.kinds = vec!["A".into(), "B".into()];
    tree.variables[32] = 1;
    let ran = run_tree(tree);
    assert_eq!([0, 1, 2].map(|at| ran.cell(at, Bool)), [0, 1, 0]);
    assert_eq!(ran.nanos, 3 * (24 + 41 + 38) + 25);
}

#[test]
fn blocks_of_bytes_are_copied_by_words() {
    // A function that gives a structure of 12 bytes; its value goes to a variable, and that to another.
    let bytes = Ty::Block { bytes: 12 };
    let whole = |root, offset| place(root, offset, bytes);
    let f = unit("F", 16, vec![set(frame(8, Dint), number(3, Dint))]);
    let value = typed(
        ExprKind::Call(Box::new(TreeCall {
            callee: Callee::Unit(1),
            inputs: vec![],
            outputs: vec![],
            result: Some(0),
            at: AT,
        })),
        bytes,
    );
    let variable = |at| whole(TreeRoot::Absolute, map::FIRST + at);
    let body = vec![set(variable(0), value), set(variable(16), load(variable(0)))];
    let ran = run_tree(program(vec![unit("MAIN", 0, body), f]));
    assert_eq!((ran.cell(24, Dint), ran.nanos), (3, 200 + 25 + 2 * (2 * 49)));
}
