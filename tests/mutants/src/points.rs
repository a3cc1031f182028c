//! Finds the places of a source file that can be mutated, and what to write there.

use proc_macro2::Span;
use quote::ToTokens;
use std::ops::Range;
use syn::spanned::Spanned;
use syn::visit::{self, Visit};
use syn::{BinOp, Block, Expr, ExprLit, ImplItemFn, ItemFn, Lit, ReturnType, Stmt, Type, UnOp};

/// One mutation of one place.
#[derive(Clone, Debug)]
pub struct Point {
    /// Bytes of the source that are mutated; empty for an insertion.
    pub range: Range<usize>,
    pub line: usize,
    pub operator: &'static str,
    pub before: String,
    pub after: String,
    pub form: Form,
}

/// How the mutation gets into the source.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// `(if on(N) { after } else { before })`
    Replace,
    /// `!on(N) && before`: for a condition with `let`, which cannot stand in brackets.
    Never,
    /// `if on(N) { after }` where a body begins.
    Insert,
}

/// All mutations of a source file.
pub fn find(source: &str) -> syn::Result<Vec<Point>> {
    let file = syn::parse_file(source)?;
    let mut finder = Finder { points: Vec::new() };
    finder.visit_file(&file);
    Ok(finder.points)
}

struct Finder {
    points: Vec<Point>,
}

fn text(tokens: &impl ToTokens) -> String {
    tokens.to_token_stream().to_string()
}

fn is_test(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|attribute| text(attribute).contains("test"))
}

/// Whether a condition binds names, so that it cannot stand in brackets.
fn has_let(condition: &Expr) -> bool {
    match condition {
        Expr::Let(_) => true,
        Expr::Binary(binary) => has_let(&binary.left) || has_let(&binary.right),
        _ => false,
    }
}

/// Whether other mutations of the expression already stand for its negation.
fn is_negated_elsewhere(condition: &Expr) -> bool {
    match condition {
        Expr::Binary(binary) => matches!(
            binary.op,
            BinOp::Lt(_) | BinOp::Le(_) | BinOp::Gt(_) | BinOp::Ge(_) | BinOp::Eq(_) | BinOp::Ne(_)
        ),
        Expr::Unary(unary) => matches!(unary.op, UnOp::Not(_)),
        _ => false,
    }
}

/// What else the operator could have been.
fn others(op: &BinOp) -> &'static [&'static str] {
    match op {
        BinOp::Lt(_) => &["<=", ">="],
        BinOp::Le(_) => &["<", ">"],
        BinOp::Gt(_) => &[">=", "<="],
        BinOp::Ge(_) => &[">", "<"],
        BinOp::Eq(_) => &["!="],
        BinOp::Ne(_) => &["=="],
        BinOp::And(_) => &["||"],
        BinOp::Or(_) => &["&&"],
        BinOp::Add(_) => &["-"],
        BinOp::Sub(_) => &["+"],
        BinOp::Mul(_) => &["/"],
        BinOp::Div(_) | BinOp::Rem(_) => &["*"],
        BinOp::BitAnd(_) => &["|"],
        BinOp::BitOr(_) => &["&"],
        BinOp::BitXor(_) => &["|"],
        BinOp::Shl(_) => &[">>"],
        BinOp::Shr(_) => &["<<"],
        BinOp::AddAssign(_) => &["-="],
        BinOp::SubAssign(_) => &["+="],
        BinOp::BitAndAssign(_) => &["|="],
        BinOp::BitOrAssign(_) => &["&="],
        BinOp::BitXorAssign(_) => &["|="],
        _ => &[],
    }
}

fn is_assignment(op: &BinOp) -> bool {
    matches!(
        op,
        BinOp::AddAssign(_)
            | BinOp::SubAssign(_)
            | BinOp::BitAndAssign(_)
            | BinOp::BitOrAssign(_)
            | BinOp::BitXorAssign(_)
    )
}

impl Finder {
    fn push(&mut self, span: Span, operator: &'static str, before: String, after: String, form: Form) {
        let mut range = span.byte_range();
        if form == Form::Insert {
            range.end = range.start;
        }
        let line = span.start().line;
        self.points.push(Point { range, line, operator, before, after, form });
    }

    fn replace(&mut self, what: &impl ToTokens, operator: &'static str, after: String) {
        let before = text(what);
        self.push(what.to_token_stream().span(), operator, before, after, Form::Replace);
    }

    fn condition(&mut self, condition: &Expr) {
        if has_let(condition) {
            self.push(condition.span(), "condition", text(condition), "false".into(), Form::Never);
            return;
        }
        for after in ["true", "false"] {
            self.replace(condition, "condition", after.into());
        }
        if !is_negated_elsewhere(condition) {
            self.replace(condition, "condition", format!("!({})", text(condition)));
        }
    }

    /// Results that a function could give at once.
    fn body(&mut self, output: &ReturnType, block: &Block) {
        let Some(first) = block.stmts.first() else { return };
        let values: &[&str] = match output {
            ReturnType::Default => &[""],
            ReturnType::Type(_, kind) => match (&**kind, text(kind).as_str()) {
                (_, "bool") => &["true", "false"],
                (_, "u8" | "u16" | "u32" | "u64" | "usize" | "i32" | "i64") => &["0", "1"],
                (Type::Path(_), name) if name.starts_with("Option <") => &["None"],
                (Type::Path(_), name) if name.starts_with("Result < ()") => &["Ok(())"],
                _ => &[],
            },
        };
        for value in values {
            self.push(first.span(), "result", "the body".into(), format!("return {value};"), Form::Insert);
        }
        if let (ReturnType::Default, Some(Stmt::Expr(last @ (Expr::MethodCall(_) | Expr::Call(_)), None))) =
            (output, block.stmts.last())
            && block.stmts.len() > 1
        {
            self.replace(last, "call removed", String::new());
        }
    }
}

impl<'a> Visit<'a> for Finder {
    fn visit_item(&mut self, item: &'a syn::Item) {
        let attributes = match item {
            syn::Item::Mod(module) => &module.attrs,
            syn::Item::Fn(function) => &function.attrs,
            syn::Item::Impl(block) => {
                let of = block.trait_.as_ref().map(|(_, path, _)| text(path)).unwrap_or_default();
                if of.ends_with("Display") || of.ends_with("Debug") || of.ends_with("Error") {
                    return;
                }
                &block.attrs
            }
            syn::Item::Const(_) | syn::Item::Static(_) | syn::Item::Macro(_) | syn::Item::Enum(_) => return,
            _ => return visit::visit_item(self, item),
        };
        if !is_test(attributes) {
            visit::visit_item(self, item);
        }
    }

    fn visit_item_fn(&mut self, function: &'a ItemFn) {
        if function.sig.constness.is_none() {
            self.body(&function.sig.output, &function.block);
            self.visit_block(&function.block);
        }
    }

    fn visit_impl_item_fn(&mut self, function: &'a ImplItemFn) {
        if function.sig.constness.is_none() && !is_test(&function.attrs) {
            self.body(&function.sig.output, &function.block);
            self.visit_block(&function.block);
        }
    }

    fn visit_impl_item_const(&mut self, _: &'a syn::ImplItemConst) {}
    fn visit_attribute(&mut self, _: &'a syn::Attribute) {}
    fn visit_pat(&mut self, _: &'a syn::Pat) {}
    fn visit_type(&mut self, _: &'a Type) {}
    fn visit_path(&mut self, _: &'a syn::Path) {}
    fn visit_generic_argument(&mut self, _: &'a syn::GenericArgument) {}
    fn visit_macro(&mut self, _: &'a syn::Macro) {}
    fn visit_expr_const(&mut self, _: &'a syn::ExprConst) {}

    fn visit_expr_repeat(&mut self, repeat: &'a syn::ExprRepeat) {
        self.visit_expr(&repeat.expr);
    }

    fn visit_stmt(&mut self, stmt: &'a Stmt) {
        if let Stmt::Expr(call @ (Expr::MethodCall(_) | Expr::Call(_)), Some(_)) = stmt {
            self.replace(call, "call removed", String::new());
        }
        visit::visit_stmt(self, stmt);
    }

    fn visit_expr_if(&mut self, branch: &'a syn::ExprIf) {
        self.condition(&branch.cond);
        visit::visit_expr_if(self, branch);
    }

    fn visit_expr_while(&mut self, repeat: &'a syn::ExprWhile) {
        let form = if has_let(&repeat.cond) { Form::Never } else { Form::Replace };
        self.push(repeat.cond.span(), "condition", text(&repeat.cond), "false".into(), form);
        visit::visit_expr_while(self, repeat);
    }

    fn visit_arm(&mut self, arm: &'a syn::Arm) {
        if let Some((_, guard)) = &arm.guard {
            self.condition(guard);
        }
        visit::visit_arm(self, arm);
    }

    fn visit_expr_assign(&mut self, assign: &'a syn::ExprAssign) {
        self.replace(assign, "assignment removed", String::new());
        self.visit_expr(&assign.right);
    }

    fn visit_expr_unary(&mut self, unary: &'a syn::ExprUnary) {
        if matches!(unary.op, UnOp::Not(_)) {
            self.replace(unary, "not removed", format!("({})", text(&unary.expr)));
        }
        visit::visit_expr_unary(self, unary);
    }

    fn visit_expr_lit(&mut self, literal: &'a ExprLit) {
        match &literal.lit {
            Lit::Int(int) => {
                if let Ok(n) = int.base10_parse::<u64>() {
                    let after = format!("{}{}", n.wrapping_add(1), int.suffix());
                    self.replace(literal, "literal", after);
                }
            }
            Lit::Bool(bool) => self.replace(literal, "literal", (!bool.value).to_string()),
            _ => {}
        }
    }

    fn visit_expr_binary(&mut self, binary: &'a syn::ExprBinary) {
        let (left, right) = (text(&binary.left), text(&binary.right));
        if !has_let(&binary.left) && !has_let(&binary.right) {
            let operator = if is_assignment(&binary.op) { "compound assignment" } else { "operator" };
            for other in others(&binary.op) {
                let after = match is_assignment(&binary.op) {
                    true => format!("{left} {other} {right}"),
                    false => format!("({left}) {other} ({right})"),
                };
                self.replace(binary, operator, after);
            }
            if is_assignment(&binary.op) {
                self.replace(binary, "assignment removed", String::new());
                return self.visit_expr(&binary.right);
            }
        }
        visit::visit_expr_binary(self, binary);
    }
}
