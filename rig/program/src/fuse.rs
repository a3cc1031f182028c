//! Pairs of operations that run in one go.
//!
//! Most of the host time of an operation is finding out which one it is. Of a common pair the first operation is
//! replaced by one that also executes the second, where the budget holds for both. The second stays behind it: for
//! jumps to it, and for slices that end between the two. So costs, effects and instants are those of single operations.

use crate::code::{Op, Step};

/// Joins pairs from the front; the second of a pair is not the first of another.
pub(crate) fn fuse(code: &mut [Step]) {
    let mut at = 0;
    while at + 1 < code.len() {
        let pair = pair(code[at].op, code[at + 1].op);
        if let Some(op) = pair {
            code[at].op = op;
            at += 1;
        }
        at += 1;
    }
}

const fn pair(first: Op, second: Op) -> Option<Op> {
    Some(match (first, second) {
        (Op::Load(at), Op::Const(_)) => Op::LoadConst(at),
        (Op::Load(at), Op::Load(_)) => Op::LoadLoad(at),
        (Op::Load(at), Op::Store(_)) => Op::LoadStore(at),
        (Op::Const(n), Op::Store(_)) => Op::ConstStore(n),
        (Op::Add(ty), Op::Store(_)) => Op::AddStore(ty),
        (Op::Index(at), Op::LoadAt(_)) => Op::IndexLoad(at),
        (Op::Store(at), Op::Jump(_)) => Op::StoreJump(at),
        (Op::Eq, Op::JumpIfNot(_)) => Op::EqJump,
        (Op::Lt, Op::JumpIfNot(_)) => Op::LtJump,
        (Op::Le, Op::JumpIfNot(_)) => Op::LeJump,
        (Op::Gt, Op::JumpIfNot(_)) => Op::GtJump,
        (Op::Ge, Op::JumpIfNot(_)) => Op::GeJump,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_second_of_a_pair_stays_and_pairs_do_not_overlap() {
        let step = |op| Step { op, cost: 7, line: 1 };
        let before = [Op::Load(1), Op::Const(2), Op::Store(3), Op::Jump(0), Op::Load(4)].map(step);
        let mut after = before;
        fuse(&mut after);
        assert_eq!(after.map(|step| step.op), [
            Op::LoadConst(1),
            Op::Const(2),
            Op::StoreJump(3),
            Op::Jump(0),
            Op::Load(4)
        ]);
        assert!(before.iter().zip(&after).all(|(before, after)| before.cost == after.cost));
    }
}
