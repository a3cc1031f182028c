//! The second half of [`super::print`]: expressions and statements.

use super::super::ast::*;
use super::print::{MOMENTS, Printer};
use crate::types::Elementary;

impl Printer<'_> {
    fn list(&mut self, exprs: &[Expr]) {
        for (place, expr) in exprs.iter().enumerate() {
            if place > 0 {
                self.put(",");
            }
            self.expr(expr);
        }
    }

    /// Inside brackets that group, where it is made of several.
    fn grouped(&mut self, expr: &Expr) {
        let group = matches!(expr.kind, ExprKind::Chain(..) | ExprKind::Unary(..));
        if group {
            self.skip("(");
        }
        self.expr(expr);
        if group {
            self.skip(")");
        }
    }

    fn typed(&mut self, ty: &Option<Elementary>, text: &str) {
        self.put(&format!("{}{text}", ty.map(|ty| format!("{}#", ty.name())).unwrap_or_default()));
    }

    pub(super) fn expr(&mut self, expr: &Expr) {
        match &expr.kind {
            ExprKind::Number(n, ty) => self.typed(ty, &n.to_string()),
            ExprKind::Real(double, single, ty) => {
                assert_eq!(*single, *double as f32);
                self.typed(ty, &format!("{double:?}"));
            }
            ExprKind::Bool(value) => self.put(if *value { "TRUE" } else { "FALSE" }),
            ExprKind::Moment(cell, ty) => {
                let moment = MOMENTS.iter().find(|moment| (moment.1, moment.2) == (*cell, *ty)).unwrap();
                self.put(moment.0);
            }
            ExprKind::Text { wide, units, typed } => {
                let text = String::from_utf16(units).unwrap().replace('$', "$$");
                self.typed(typed, &if *wide { format!("\"{text}\"") } else { format!("'{text}'") });
            }
            ExprKind::Name(name) => self.name(*name),
            ExprKind::Global(name) => {
                self.put(".");
                self.name(*name);
            }
            ExprKind::Qualified(ty, name) => {
                let text = format!("{}#", self.names.key_text(ty.key));
                self.put(&text);
                self.name(*name);
            }
            ExprKind::Member(of, name) => {
                self.grouped(of);
                self.put(".");
                self.name(*name);
            }
            ExprKind::Part { of, bits, number } => {
                self.grouped(of);
                self.put(".");
                self.put(&match bits {
                    1 => format!("%X{number}"),
                    8 => format!("%B{number}"),
                    16 => format!("%W{number}"),
                    _ => format!("%D{number}"),
                });
            }
            ExprKind::Index(of, indices) => {
                self.grouped(of);
                self.put("[");
                self.list(indices);
                self.put("]");
            }
            ExprKind::Deref(of) => {
                self.grouped(of);
                self.put("^");
            }
            ExprKind::Call(of, arguments) => {
                self.grouped(of);
                self.arguments(arguments);
            }
            ExprKind::Direct(text) => self.put(text),
            ExprKind::This => self.put("THIS"),
            ExprKind::Super => self.put("SUPER"),
            ExprKind::Null => self.put("NULL"),
            ExprKind::Unary(op, of) => {
                self.put(match op {
                    UnaryOp::Not => "NOT",
                    UnaryOp::Minus => "-",
                    UnaryOp::Plus => "+",
                });
                self.grouped(of);
            }
            ExprKind::Chain(first, rest) => {
                self.grouped(first);
                for (op, _, expr) in rest {
                    self.put(op.text());
                    self.grouped(expr);
                }
            }
            ExprKind::Wrong => panic!("a wrong expression without a finding"),
        }
    }

    pub(super) fn arguments(&mut self, arguments: &[Argument]) {
        self.put("(");
        for (place, argument) in arguments.iter().enumerate() {
            if place > 0 {
                self.put(",");
            }
            self.argument(argument);
        }
        self.put(")");
    }

    fn argument(&mut self, argument: &Argument) {
        match argument {
            Argument::Positional(expr) => self.expr(expr),
            Argument::Input(name, expr) => {
                self.name(*name);
                self.put(":=");
                self.expr(expr);
            }
            Argument::Empty(name) => {
                self.name(*name);
                self.put(":=");
            }
            Argument::Output { name, negated, target } => {
                self.name(*name);
                self.put("=>");
                if *negated {
                    self.put("NOT");
                }
                if let Some(target) = target {
                    self.expr(target);
                }
            }
        }
    }

    pub(super) fn body(&mut self, body: &[Stmt]) {
        for stmt in body {
            self.stmt(&stmt.kind);
            self.put(";");
        }
    }

    fn stmt(&mut self, kind: &StmtKind) {
        match kind {
            StmtKind::Assign { targets, kind, value } => {
                for target in targets {
                    self.expr(target);
                    match kind {
                        AssignKind::Value => self.put(":="),
                        AssignKind::Set => self.put("S="),
                        AssignKind::Reset => self.put("R="),
                        AssignKind::Reference => self.put("REF="),
                    }
                }
                self.expr(value);
            }
            StmtKind::Call(expr) => self.expr(expr),
            StmtKind::If { arms, otherwise } => {
                for (place, (condition, body)) in arms.iter().enumerate() {
                    self.put(if place == 0 { "IF" } else { "ELSIF" });
                    self.expr(condition);
                    self.put("THEN");
                    self.body(body);
                }
                self.otherwise(otherwise);
                self.put("END_IF");
            }
            StmtKind::Case { selector, arms, otherwise } => {
                self.put("CASE");
                self.expr(selector);
                self.put("OF");
                for (labels, body) in arms {
                    for (place, label) in labels.iter().enumerate() {
                        if place > 0 {
                            self.put(",");
                        }
                        self.expr(&label.low);
                        if let Some(high) = &label.high {
                            self.put("..");
                            self.expr(high);
                        }
                    }
                    self.put(":");
                    self.body(body);
                }
                self.otherwise(otherwise);
                self.put("END_CASE");
            }
            StmtKind::For(counted) => {
                self.put("FOR");
                self.expr(&counted.variable);
                self.put(":=");
                self.expr(&counted.from);
                self.put("TO");
                self.expr(&counted.to);
                if let Some(by) = &counted.by {
                    self.put("BY");
                    self.expr(by);
                }
                self.put("DO");
                self.body(&counted.body);
                self.put("END_FOR");
            }
            StmtKind::While { condition, body, .. } => {
                self.put("WHILE");
                self.expr(condition);
                self.put("DO");
                self.body(body);
                self.put("END_WHILE");
            }
            StmtKind::Repeat { body, until } => {
                self.put("REPEAT");
                self.body(body);
                self.put("UNTIL");
                self.expr(until);
                self.put("END_REPEAT");
            }
            StmtKind::Exit => self.put("EXIT"),
            StmtKind::Continue => self.put("CONTINUE"),
            StmtKind::Return => self.put("RETURN"),
        }
    }

    fn otherwise(&mut self, otherwise: &[Stmt]) {
        if !otherwise.is_empty() {
            self.put("ELSE");
            self.body(otherwise);
        }
    }
}
