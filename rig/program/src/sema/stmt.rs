//! Statements.

use super::Sema;
use super::literal::LiteralOperand;
use super::place::PathMeaning;
use super::promote::{exceeds, whole_constant};
use super::types::{Type, TypeId, WRONG};
use crate::codes::Code;
use crate::findings::SourcePlace;
use crate::parse::ast::{self, AssignKind, CaseLabel, Counted, StmtKind as Written};
use crate::tree::{Expr, ExprKind, For, Stmt, StmtKind, Target, TreePlace, TreeRoot, Ty};
use crate::types::Elementary;

impl<'a> Sema<'a> {
    pub(super) fn statements(&mut self, list: &[ast::Stmt]) -> Vec<Stmt> {
        let mut out = Vec::with_capacity(list.len());
        for statement in list {
            if self.findings.full() {
                break;
            }
            self.statement(statement, &mut out);
        }
        out
    }

    fn statement(&mut self, statement: &ast::Stmt, out: &mut Vec<Stmt>) {
        let at = statement.at;
        let kind = match &statement.kind {
            Written::Assign { targets, kind, value } => {
                self.assignment(targets, *kind, value, at, out);
                return;
            }
            Written::Call(expr) => match self.call_statement(expr) {
                Some(call) => StmtKind::Call(Box::new(call)),
                None => return,
            },
            Written::If { arms, otherwise } => {
                let arms = arms
                    .iter()
                    .filter_map(|(condition, body)| {
                        let condition = self.condition(condition);
                        let body = self.statements(body);
                        Some((condition?, body))
                    })
                    .collect();
                StmtKind::If { arms, otherwise: self.statements(otherwise) }
            }
            Written::Case { selector, arms, otherwise } => {
                match self.case_statement(selector, arms, otherwise) {
                    Some(kind) => kind,
                    None => return,
                }
            }
            Written::For(counted) => match self.for_statement(counted, out) {
                Some(kind) => kind,
                None => return,
            },
            Written::While { condition, body, end } => {
                let condition = self.condition(condition);
                let body = self.looped(body);
                match condition {
                    Some(condition) => StmtKind::While { condition, body, end: *end },
                    None => return,
                }
            }
            Written::Repeat { body, until } => {
                let body = self.looped(body);
                match self.condition(until) {
                    Some(until) => StmtKind::Repeat { body, until },
                    None => return,
                }
            }
            Written::Exit | Written::Continue => {
                if self.context.loops == 0 {
                    let message = "there is no loop to leave or to go on with";
                    let help = "EXIT and CONTINUE belong into FOR, WHILE or REPEAT";
                    self.findings.error(Code::OutsideLoop, at, message, help);
                    return;
                }
                if matches!(statement.kind, Written::Exit) { StmtKind::Exit } else { StmtKind::Continue }
            }
            Written::Return => StmtKind::Return,
        };
        out.push(Stmt { kind, at });
    }

    fn looped(&mut self, body: &[ast::Stmt]) -> Vec<Stmt> {
        self.context.loops += 1;
        let body = self.statements(body);
        self.context.loops -= 1;
        body
    }

    fn condition(&mut self, written: &ast::Expr) -> Option<Expr> {
        let operand = self.expr(written, None);
        if matches!(operand, LiteralOperand::Wrong) {
            return None;
        }
        let ty = self.own_type(&operand);
        match operand {
            LiteralOperand::Value(value, ty) if self.scalar(ty) == Some(Elementary::Bool) => Some(value),
            operand => {
                let what = match operand {
                    LiteralOperand::Integer(_) | LiteralOperand::Real(..) => "a number".to_string(),
                    LiteralOperand::Text(..) => "a text".to_string(),
                    _ => self.type_name(ty),
                };
                let message = format!("a condition is BOOL, this is {what}");
                self.findings.error(Code::Condition, written.at, message, "compare it, as in n <> 0");
                None
            }
        }
    }

    fn assignment(
        &mut self,
        targets: &[ast::Expr],
        kind: AssignKind,
        value: &ast::Expr,
        at: SourcePlace,
        out: &mut Vec<Stmt>,
    ) {
        match (kind, targets) {
            (AssignKind::Reference, [target]) => self.assign_reference(target, value, at, out),
            (AssignKind::Set | AssignKind::Reset, [target]) => {
                self.set_or_reset(kind == AssignKind::Set, target, value, at, out);
            }
            (AssignKind::Value, [target]) => self.assign(target, value, at, out),
            (AssignKind::Value, targets) => {
                // From the right: each gets what the one after it got.
                let Some((last, before)) = targets.split_last() else { return };
                self.assign(last, value, at, out);
                let mut source = last;
                for target in before.iter().rev() {
                    self.assign(target, source, at, out);
                    source = target;
                }
            }
            _ => {
                let message = "only := can assign to several targets";
                self.findings.error(Code::Unexpected, at, message, "write a statement for each");
            }
        }
    }

    fn assign(&mut self, target: &ast::Expr, value: &ast::Expr, at: SourcePlace, out: &mut Vec<Stmt>) {
        if let Some((instance, name)) = self.property_target(target) {
            if let Some(call) = self.set_property(&instance, name, value, at) {
                out.push(Stmt { kind: StmtKind::Call(Box::new(call)), at });
            }
            return;
        }
        let Some((place, ty)) = self.target(target) else {
            // Faults of the value are found in the same run.
            self.expr(value, None);
            return;
        };
        if matches!(self.ty(ty), Type::Block(_) | Type::Native(_)) {
            self.not_a_value(target.at);
            self.expr(value, None);
            return;
        }
        let operand = self.expr(value, Some(ty));
        // The bits of an address suit numbers of their width.
        if let (Target::Place(place), LiteralOperand::Value(from, from_type), ast::ExprKind::Direct(_)) =
            (&place, &operand, &target.kind)
            && let (Some(a), Some(b)) = (self.scalar(*from_type), self.scalar(ty))
            && a.is_integer()
            && b.is_integer()
            && a.bits() == b.bits()
        {
            let (place, from) = (place.clone(), from.clone());
            let value = self.widened(from, Ty::Scalar(b));
            out.push(Stmt { kind: StmtKind::Assign(Target::Place(place), value), at });
            return;
        }
        if let Some(value) = self.give(operand, ty, value.at) {
            out.push(Stmt { kind: StmtKind::Assign(place, value), at });
        }
    }

    /// The property that is assigned to, if it is one.
    fn property_target(&mut self, target: &ast::Expr) -> Option<(super::place::ObjectAccess, ast::Name)> {
        let name = match &target.kind {
            ast::ExprKind::Name(name) => *name,
            ast::ExprKind::Member(_, name) => *name,
            _ => return None,
        };
        // Only names of properties are looked at: a path is followed once.
        if !self.is_property_name(name.key) {
            return None;
        }
        if let (ast::ExprKind::Name(_), Some(super::scope::FoundName::Property)) =
            (&target.kind, self.find(name.key))
        {
            return Some((super::place::ObjectAccess::Same, name));
        }
        if let ast::ExprKind::Member(..) = &target.kind
            && let PathMeaning::Property(instance, name) = self.meaning(target)
        {
            return Some((instance, name));
        }
        None
    }

    fn is_property_name(&self, key: ast::Key) -> bool {
        use super::scope::{MethodSelector, SelectorKind};
        [SelectorKind::Get, SelectorKind::Set]
            .into_iter()
            .any(|kind| self.selector_index.contains_key(&MethodSelector { key, kind }))
    }

    /// `r REF= x`.
    fn assign_reference(
        &mut self,
        target: &ast::Expr,
        value: &ast::Expr,
        at: SourcePlace,
        out: &mut Vec<Stmt>,
    ) {
        let Some((slot, ty)) = self.reference_place(target) else {
            let message = "REF= needs a REFERENCE on its left";
            self.findings.error(Code::Type, target.at, message, "assign values with :=");
            return;
        };
        let to = self.target_of(ty).unwrap_or(WRONG);
        let address = match &value.kind {
            ast::ExprKind::Number(0, _) | ast::ExprKind::Null => {
                Expr { kind: ExprKind::Constant(0), ty: Ty::Address, at: value.at }
            }
            _ => match self.meaning(value) {
                PathMeaning::Place(place, from, _) => {
                    if !self.reference_fits(from, to, false) {
                        if from != WRONG {
                            self.mismatch(from, to, value.at);
                        }
                        return;
                    }
                    self.address_of(place)
                }
                PathMeaning::Wrong => return,
                // What a function or method refers to.
                PathMeaning::Operand(LiteralOperand::Value(
                    Expr { kind: ExprKind::Load(place), .. },
                    from,
                )) if matches!(place.root, crate::tree::TreeRoot::Address(_))
                    && self.reference_fits(from, to, false) =>
                {
                    self.address_of(place)
                }
                _ => {
                    let message = "a reference needs a variable";
                    self.findings.error(
                        Code::Output,
                        value.at,
                        message,
                        "put the value into a variable first",
                    );
                    return;
                }
            },
        };
        let target = Target::Place(TreePlace { ty: Ty::Address, ..slot });
        out.push(Stmt { kind: StmtKind::Assign(target, address), at });
    }

    /// `x S= condition;` sets where the condition is TRUE, and else does nothing.
    fn set_or_reset(
        &mut self,
        set: bool,
        target: &ast::Expr,
        value: &ast::Expr,
        at: SourcePlace,
        out: &mut Vec<Stmt>,
    ) {
        let place = self.target(target);
        let condition = self.condition(value);
        let (Some((place, ty)), Some(condition)) = (place, condition) else { return };
        if self.scalar(ty) != Some(Elementary::Bool) {
            let message = format!("S= and R= are for BOOL, this is {}", self.type_name(ty));
            self.findings.error(Code::Type, target.at, message, "assign with :=");
            return;
        }
        let constant = self.constant(i64::from(set), Elementary::Bool, at);
        let assign = Stmt { kind: StmtKind::Assign(place, constant), at };
        let kind = StmtKind::If { arms: vec![(condition, vec![assign])], otherwise: Vec::new() };
        out.push(Stmt { kind, at });
    }

    /// A call that stands alone, with or without brackets.
    fn call_statement(&mut self, written: &ast::Expr) -> Option<Expr> {
        let operand = match &written.kind {
            ast::ExprKind::Call(callee, arguments) => self.call_value(callee, arguments, written.at),
            _ => match self.meaning(written) {
                PathMeaning::Action(..) | PathMeaning::Program(_) | PathMeaning::Method(..) => {
                    self.call_value(written, &[], written.at)
                }
                PathMeaning::Wrong => return None,
                _ => {
                    let message = format!("`{}` alone does nothing", self.text(written.at));
                    let help = "assign with :=, or call with brackets";
                    self.findings.error(Code::NotCallable, written.at, message, help);
                    return None;
                }
            },
        };
        match operand {
            LiteralOperand::Nothing(call) => Some(call),
            LiteralOperand::Value(value, _) => {
                // The function's work may be all that is wanted of it.
                Some(value)
            }
            _ => None,
        }
    }

    fn case_statement(
        &mut self,
        selector: &ast::Expr,
        arms: &[(Vec<CaseLabel>, Vec<ast::Stmt>)],
        otherwise: &[ast::Stmt],
    ) -> Option<StmtKind> {
        let operand = self.expr(selector, None);
        let wrong = matches!(operand, LiteralOperand::Wrong);
        let value = self.own_value(operand, selector.at);
        let ty = value.as_ref().map(|(_, ty)| *ty).filter(|ty| {
            self.scalar(*ty)
                .is_some_and(|ty| ty.is_integer() || ty.is_char() || ty.is_duration() || ty.is_date())
        });
        if ty.is_none() && !wrong && value.is_some() {
            let message = "CASE selects by a number";
            self.findings.error(Code::Type, selector.at, message, "use IF for other types");
        }
        let mut seen: Vec<(i128, i128, SourcePlace)> = Vec::new();
        let mut out = Vec::with_capacity(arms.len());
        for (labels, body) in arms {
            let mut ranges = Vec::with_capacity(labels.len());
            for label in labels {
                let Some(ty) = ty else { continue };
                if let Some(range) = self.label(label, ty) {
                    seen.push(range);
                    ranges.push((range.0, range.1));
                }
            }
            let body = self.statements(body);
            out.push((ranges, body));
        }
        let otherwise = self.statements(otherwise);
        self.check_labels(seen);
        let (selector, _) = value?;
        let selector = self.promoted(selector);
        ty?;
        Some(StmtKind::Case { selector, arms: out, otherwise })
    }

    fn check_labels(&mut self, mut seen: Vec<(i128, i128, SourcePlace)>) {
        seen.sort_by_key(|(low, high, at)| (*low, *high, at.start));
        for pair in seen.windows(2) {
            if let [(_, high, first), (low, _, second)] = pair
                && low <= high
            {
                let (first, second) =
                    if first.start < second.start { (first, second) } else { (second, first) };
                let other = (*first, "first here");
                let message = format!("{low} is a label twice");
                self.findings.error_with(
                    Code::CaseLabel,
                    *second,
                    message,
                    "each value has one place",
                    other,
                );
            }
        }
    }

    /// The values of a label, both ends included.
    fn label(&mut self, label: &CaseLabel, ty: TypeId) -> Option<(i128, i128, SourcePlace)> {
        let scalar = self.scalar(ty)?;
        let low = self.constant_cell(&label.low, ty).map(|cell| scalar.number(cell))?;
        let Some(high) = &label.high else { return Some((low, low, label.low.at)) };
        let at = label.low.at.to(high.at);
        let high = self.constant_cell(high, ty).map(|cell| scalar.number(cell))?;
        if low > high {
            let message = format!("the range {low}..{high} is empty");
            self.findings.error(Code::CaseLabel, at, message, "write the lower end first");
            return None;
        }
        Some((low, high, at))
    }

    fn for_statement(&mut self, counted: &Counted, out: &mut Vec<Stmt>) -> Option<StmtKind> {
        let variable = self.for_variable(&counted.variable);
        let ty = variable.as_ref().map(|(_, ty)| *ty);
        let from = ty.and_then(|ty| self.value(&counted.from, ty));
        let to = ty.and_then(|ty| self.end(&counted.to, ty));
        let by = match &counted.by {
            None => Some(None),
            Some(by) => self.step(by).map(Some),
        };
        let body = self.looped(&counted.body);
        let (mut variable, ty) = variable?;
        if through_pointer(&counted.variable) {
            self.hold_address(&mut variable, out);
        }
        let (from, to, by) = (from?, to?, by?);
        if let Some(scalar) = self.scalar(ty) {
            self.check_end(scalar, &from, &to, by.as_ref());
        }
        Some(StmtKind::For(Box::new(For { variable, from, to, by, body, end: counted.end })))
    }

    /// The end of FOR: it is only compared, so it is not cut.
    fn end(&mut self, written: &ast::Expr, ty: TypeId) -> Option<Expr> {
        let end = self.value(written, ty)?;
        if exceeds(&end) {
            self.check_below_0(&end);
        }
        Some(self.promoted(end))
    }

    /// Warns of a loop whose control variable cannot get beyond its end.
    fn check_end(&mut self, ty: Elementary, from: &Expr, to: &Expr, by: Option<&Expr>) {
        let step = by.map_or(Some(1), whole_constant);
        let (Some(end), Some(step)) = (whole_constant(to), step) else { return };
        let (low, high) = ty.range();
        let (limit, other) = if step > 0 { (high, low) } else { (low, high) };
        let last = match whole_constant(from) {
            Some(from) if (end - from) * step.signum() < 0 => return,
            Some(from) => from + (end - from) / step * step,
            None => end,
        };
        // Where the start is not known, it may be such that the steps meet the end.
        let next = if whole_constant(from).is_some() { last + step } else { end + step.signum() };
        if low <= next && next <= high {
            return;
        }
        let message = format!("the loop does not end: {} goes on at {other} after {limit}", ty.name());
        let wider = [Elementary::Int, Elementary::Dint, Elementary::Lint].into_iter().find(|wider| {
            let (least, most) = wider.range();
            least <= next && next <= most
        });
        let help = match wider {
            Some(wider) => format!("count in {}", wider.name()),
            None => "end one step earlier".to_string(),
        };
        self.findings.warning(Code::Endless, to.at, message, help);
    }

    /// Keeps where a control variable is, so that a pointer that the body changes leads the loop nowhere else.
    fn hold_address(&mut self, variable: &mut TreePlace, out: &mut Vec<Stmt>) {
        let at = variable.at;
        if !matches!(variable.root, TreeRoot::Address(_)) {
            return;
        }
        let offset = self.hidden(Ty::Address);
        let held = TreePlace {
            root: TreeRoot::Frame,
            offset,
            indices: Vec::new(),
            ty: Ty::Address,
            retained: false,
            at,
        };
        let address = self.address_of(variable.clone());
        out.push(Stmt { kind: StmtKind::Assign(Target::Place(held.clone()), address), at });
        let load = Expr { kind: ExprKind::Load(held), ty: Ty::Address, at };
        variable.root = TreeRoot::Address(Box::new(load));
        variable.offset = 0;
    }

    fn for_variable(&mut self, written: &ast::Expr) -> Option<(TreePlace, TypeId)> {
        let (target, ty) = self.target(written)?;
        let scalar = self.scalar(ty).filter(|ty| ty.is_integer());
        match (target, scalar) {
            (Target::Place(place), Some(_)) => {
                if !place.indices.is_empty() {
                    let message = "the control variable of FOR cannot be an element at a variable index";
                    let help = "count in a variable of its own";
                    self.findings.error(Code::ForVariable, written.at, message, help);
                    return None;
                }
                Some((place, ty))
            }
            _ => {
                let message =
                    format!("the control variable of FOR is an integer, this is {}", self.type_name(ty));
                self.findings.error(Code::ForVariable, written.at, message, "count in INT or DINT");
                None
            }
        }
    }

    /// A step may be negative even where the variable cannot.
    fn step(&mut self, by: &ast::Expr) -> Option<Expr> {
        let lint = self.elementary(Elementary::Lint);
        let operand = self.expr(by, None);
        let step = match operand {
            LiteralOperand::Value(value, from) if self.scalar(from).is_some_and(Elementary::is_integer) => {
                self.widened(value, Ty::Scalar(Elementary::Lint))
            }
            operand => self.give(operand, lint, by.at)?,
        };
        if let ExprKind::Constant(0) = step.kind {
            self.findings.error(Code::ForVariable, by.at, "a step of 0 never comes to an end", "");
            return None;
        }
        Some(step)
    }
}

/// Whether a path leads through a pointer.
fn through_pointer(written: &ast::Expr) -> bool {
    match &written.kind {
        ast::ExprKind::Deref(of) => !matches!(of.kind, ast::ExprKind::This),
        ast::ExprKind::Member(of, _) | ast::ExprKind::Index(of, _) | ast::ExprKind::Part { of, .. } => {
            through_pointer(of)
        }
        _ => false,
    }
}
