//! Runs of operations that are executed in one go.
//!
//! Most of the host time of an operation is finding out which one it is. The first of a common run is therefore
//! replaced by an operation that does the work of all and costs what all cost. The others stay behind it, for jumps
//! to them, and [`crate::program::Program::plain`] keeps the code as it was: where the budget does not hold for the
//! whole run, its operations are executed one by one. So costs, effects and instants are those of single operations.
//!
//! Between the first and the last operation of a run nothing happens that the rest of the rig could see: only the
//! last one writes.

use crate::code::{Op, Step};

/// The code with its runs; a run does not reach into another.
pub(crate) fn fuse(plain: &[Step]) -> Vec<Step> {
    let mut code = plain.to_vec();
    let mut at = 0;
    while at < code.len() {
        let rest = &plain[at..];
        let mut length = 1;
        if let Some((op, joined)) = run(rest) {
            let cost = rest[..joined].iter().try_fold(0u32, |sum, step| sum.checked_add(step.cost));
            if let Some(cost) = cost {
                code[at] = Step { op, cost, ..rest[0] };
                length = joined;
            }
        }
        at += length;
    }
    code
}

/// The operation for the longest run that begins here, with the number of operations in it.
fn run(rest: &[Step]) -> Option<(Op, usize)> {
    let op = |at: usize| rest.get(at).map_or(Op::Return, |step| step.op);
    let four = match (op(0), op(1), op(2), op(3)) {
        (Op::Load(a), Op::Const(k), Op::Le, Op::JumpIfNot(to)) => Op::IfLe(a, k, to),
        (Op::Load(a), Op::Const(k), Op::Ge, Op::JumpIfNot(to)) => Op::IfGe(a, k, to),
        _ => Op::Return,
    };
    let three = match (op(0), op(1), op(2)) {
        (Op::Load(a), Op::EqConst(k), Op::JumpIfNot(to)) => Op::IfEq(a, k, to),
        (Op::Load(a), Op::LtConst(k), Op::JumpIfNot(to)) => Op::IfLt(a, k, to),
        (Op::Load(a), Op::GtConst(k), Op::JumpIfNot(to)) => Op::IfGt(a, k, to),
        (Op::Load(a), Op::AddConst(ty, k), Op::Store(to)) => Op::AddConstTo(ty, a, k, to),
        (Op::LoadLocal(a), Op::EqConst(k), Op::JumpIf(to)) => Op::LocalEqJump(a, k, to),
        (Op::Load(a), Op::Const(k), Op::NextOrJump(ty, to)) => Op::NextCell(ty, a, k, to),
        (Op::Load(a), Op::Const(k), Op::Div(ty)) if k != 0 && !ty.wide_unsigned() => Op::DivCell(ty, a, k),
        _ => Op::Return,
    };
    let two = match (op(0), op(1)) {
        (Op::Load(a), Op::JumpIfNot(to)) => Op::IfTrue(a, to),
        (Op::Load(a), Op::Store(to)) => Op::Move(a, to),
        (Op::Const(k), Op::Store(to)) => Op::Set(k, to),
        (Op::Load(a), Op::And) => Op::AndCell(a),
        (Op::Load(a), Op::Or) => Op::OrCell(a),
        (Op::Load(a), Op::Add(ty)) => Op::AddCell(ty, a),
        (Op::Load(a), Op::GtConst(k)) => Op::GtCell(a, k),
        (Op::Load(a), Op::LtConst(k)) => Op::LtCell(a, k),
        (Op::Not(ty), Op::And) => Op::AndNot(ty),
        (Op::And, Op::Store(to)) => Op::AndTo(to),
        (Op::Or, Op::Store(to)) => Op::OrTo(to),
        (Op::Load(a), Op::Const(k)) => Op::LoadConst(a, k),
        (Op::Load(a), Op::Load(b)) => Op::LoadTwo(a, b),
        (Op::Add(ty), Op::Store(to)) => Op::AddTo(ty, to),
        (Op::Store(a), Op::Jump(to)) => Op::StoreJump(a, to),
        (Op::Index(bounds), Op::LoadAt(first)) => Op::IndexLoad(bounds, first),
        (Op::Eq, Op::JumpIfNot(to)) => Op::EqJump(to),
        (Op::Lt, Op::JumpIfNot(to)) => Op::LtJump(to),
        (Op::Le, Op::JumpIfNot(to)) => Op::LeJump(to),
        (Op::Gt, Op::JumpIfNot(to)) => Op::GtJump(to),
        (Op::Ge, Op::JumpIfNot(to)) => Op::GeJump(to),
        _ => Op::Return,
    };
    [(four, 4), (three, 3), (two, 2)].into_iter().find(|(op, _)| *op != Op::Return)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_costs_the_sum_and_leaves_the_others_in_their_places() {
        let ops = [Op::Load(1), Op::Const(2), Op::Le, Op::JumpIfNot(9), Op::Load(4), Op::Load(5), Op::Return];
        let plain: Vec<Step> = ops.into_iter().map(|op| Step { op, cost: 7, line: 1 }).collect();
        let code = fuse(&plain);
        assert_eq!((code[0].op, code[0].cost), (Op::IfLe(1, 2, 9), 28));
        assert_eq!((code[4].op, code[4].cost), (Op::LoadTwo(4, 5), 14));
        assert!([1, 2, 3, 5, 6].iter().all(|at| code[*at] == plain[*at]));
    }

    #[test]
    fn a_sum_of_costs_that_does_not_fit_is_no_run() {
        let plain = [Op::Load(1), Op::Load(2)].map(|op| Step { op, cost: u32::MAX, line: 1 });
        assert_eq!(fuse(&plain), plain);
    }
}
