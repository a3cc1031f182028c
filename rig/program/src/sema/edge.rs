//! Inputs that detect edges: R_EDGE and F_EDGE. The block's statements see TRUE in the one call at which the input
//! changed, as if an R_TRIG or F_TRIG stood before it (IEC 61131-3, declaration of inputs with edges).

use super::Sema;
use super::scope::{CallableKind, Home};
use super::types::TypeId;
use crate::codes::Code;
use crate::parse::ast::{self, PouKind, Section, SectionKind};
use crate::tree::{BinaryOp, Expr, ExprKind, Stmt, StmtKind, Target, TreePlace, TreeRoot, Ty, UnaryOp};
use crate::types::Elementary;

impl<'a> Sema<'a> {
    /// Whether an edge can be detected where a variable asks for it.
    pub(super) fn check_edge(
        &mut self,
        section: &Section,
        decl: &'a ast::VarDecl,
        ty: TypeId,
        member: bool,
    ) -> bool {
        let Some((_, at)) = decl.edge else { return true };
        let block = self.context.pou.and_then(|pou| self.pous.get(pou as usize));
        let block = block.is_some_and(|pou| pou.ast.kind == PouKind::FunctionBlock);
        if !member || !block || section.kind != SectionKind::Input {
            let message = "only inputs of a FUNCTION_BLOCK detect edges";
            let help = "declare an R_TRIG or F_TRIG and call it with the value";
            self.findings.error(Code::Section, at, message, help);
            return false;
        }
        if self.scalar(ty) != Some(Elementary::Bool) && !super::is_wrong(ty) {
            let message = format!("{} has no edges", self.type_name(ty));
            self.findings.error(Code::Type, at, message, "declare it as BOOL");
            return false;
        }
        true
    }

    /// Statements that find the edges, at the begin of a block's body. Those of blocks that it extends are its own.
    pub(super) fn edges(&mut self, callable: u32) -> Vec<Stmt> {
        let owner = self.callables.get(callable as usize).filter(|c| c.kind == CallableKind::Body);
        let Some(owner) = owner.and_then(|callable| callable.owner) else { return Vec::new() };
        let lineage: Vec<u32> = self.lineage(owner).collect();
        let mut list = Vec::new();
        for pou in lineage {
            let symbols = self.pous.get(pou as usize).map_or(Vec::new(), |pou| pou.symbols.clone());
            for symbol in symbols {
                let (Some(edge), Some((falling, at)), Home::This(input)) =
                    (symbol.edge, symbol.decl.edge, symbol.home)
                else {
                    continue;
                };
                if pou != owner {
                    let message = format!("`{}` is inherited and detects edges", symbol.shown);
                    let help = "call an R_TRIG or F_TRIG with it in the block that is extended";
                    self.findings.error(Code::Unsupported, at, message, help);
                    continue;
                }
                let ty = Ty::Scalar(Elementary::Bool);
                let place = |offset: u32| TreePlace {
                    root: TreeRoot::This,
                    offset,
                    indices: Vec::new(),
                    ty,
                    retained: false,
                    at,
                };
                let load = |offset: u32| Expr { kind: ExprKind::Load(place(offset)), ty, at };
                let (now, before) = (load(input), load(edge + 1));
                let found = if falling {
                    let low = self.unary(UnaryOp::Not, now, at);
                    self.binary(BinaryOp::And, low, before, at)
                } else {
                    let was_low = self.unary(UnaryOp::Not, before, at);
                    self.binary(BinaryOp::And, now, was_low, at)
                };
                let assign = |offset: u32, value: Expr| Stmt {
                    kind: StmtKind::Assign(Target::Place(place(offset)), value),
                    at,
                };
                list.push(assign(edge, found));
                list.push(assign(edge + 1, load(input)));
            }
        }
        list
    }
}
