//! Expressions, with the precedence of IEC 61131-3.

use super::ast::{Argument, BinaryOp, Expr, ExprKind, Path, Segment, UnaryOp};
use super::lexer::Token;
use super::literal::{self, LiteralFault};
use super::{Parsed, Parser, Reported, words};
use crate::codes::Code;
use crate::findings::At;
use crate::types::Elementary;

/// Levels of the binary operators, loosest first.
const LEVELS: usize = 7;

impl Parser<'_, '_, '_> {
    pub(super) fn expression(&mut self) -> Parsed<Expr> {
        self.nested(|p| p.level(0))
    }

    /// One level of operators, associating to the left.
    fn level(&mut self, level: usize) -> Parsed<Expr> {
        if level == LEVELS {
            return self.unary();
        }
        let first = self.level(level + 1)?;
        let mut rest = Vec::new();
        while let Some(op) = self.operator(level) {
            let at = self.token.1;
            self.advance();
            rest.push((op, at, self.level(level + 1)?));
        }
        Ok(match rest.last() {
            None => first,
            Some((_, _, last)) => {
                let at = first.at.to(last.at);
                Expr { kind: ExprKind::Chain(Box::new(first), rest), at }
            }
        })
    }

    fn operator(&self, level: usize) -> Option<BinaryOp> {
        let is = |word: &str| self.at_word(word);
        match (level, self.token.0) {
            (0, Token::Word) if is("OR") => Some(BinaryOp::Or),
            (1, Token::Word) if is("XOR") => Some(BinaryOp::Xor),
            (2, Token::Word) if is("AND") => Some(BinaryOp::And),
            (2, Token::Ampersand) => Some(BinaryOp::And),
            (3, Token::Equal) => Some(BinaryOp::Equal),
            (3, Token::NotEqual) => Some(BinaryOp::NotEqual),
            (4, Token::Less) => Some(BinaryOp::Less),
            (4, Token::LessEqual) => Some(BinaryOp::LessEqual),
            (4, Token::Greater) => Some(BinaryOp::Greater),
            (4, Token::GreaterEqual) => Some(BinaryOp::GreaterEqual),
            (5, Token::Plus) => Some(BinaryOp::Add),
            (5, Token::Minus) => Some(BinaryOp::Subtract),
            (6, Token::Star) => Some(BinaryOp::Multiply),
            (6, Token::Slash) => Some(BinaryOp::Divide),
            (6, Token::Word) if is("MOD") => Some(BinaryOp::Mod),
            _ => None,
        }
    }

    fn unary(&mut self) -> Parsed<Expr> {
        let at = self.token.1;
        let op = match self.token.0 {
            Token::Minus => UnaryOp::Minus,
            Token::Word if self.at_word("NOT") => UnaryOp::Not,
            Token::Plus => {
                self.advance();
                return self.nested(Self::unary);
            }
            _ => {
                let operand = self.primary()?;
                if self.is(Token::Power) {
                    return Err(self.unsupported(self.token.1, "the operator **"));
                }
                return Ok(operand);
            }
        };
        self.advance();
        let operand = self.nested(Self::unary)?;
        let at = at.to(operand.at);
        Ok(Expr { kind: ExprKind::Unary(op, Box::new(operand)), at })
    }

    fn primary(&mut self) -> Parsed<Expr> {
        let at = self.token.1;
        let text = self.slice(at);
        let kind = match self.token.0 {
            Token::Integer | Token::Based => {
                self.advance();
                self.literal(Code::Number, at, literal::number(text), |n| ExprKind::Number(n, None))
            }
            Token::Duration => {
                self.advance();
                self.literal(Code::Duration, at, literal::duration(text), ExprKind::Duration)
            }
            Token::Real => {
                self.unsupported(at, "a REAL number");
                self.advance();
                ExprKind::Wrong
            }
            Token::Prefix => return self.typed_literal(),
            Token::Address => {
                self.advance();
                ExprKind::Direct(text.to_string())
            }
            Token::Open => {
                self.advance();
                let inner = self.expression()?;
                let end = self.expect(Token::Close, "a closing bracket )")?;
                return Ok(Expr { at: at.to(end), ..inner });
            }
            Token::Word if self.at_word("TRUE") || self.at_word("FALSE") => {
                self.advance();
                ExprKind::Bool(text.eq_ignore_ascii_case("TRUE"))
            }
            Token::Word => {
                if self.next.0 == Token::Open {
                    let name = self.name("a value")?;
                    let arguments = self.arguments()?;
                    let at = at.to(self.last);
                    return Ok(Expr { kind: ExprKind::Call(name, arguments), at });
                }
                let path = self.path("a value")?;
                if self.is(Token::Open) {
                    let message = "only functions can be called inside an expression";
                    let help = "call the block in a statement of its own, then read its output";
                    self.findings.error(Code::NotCallable, path.at, message, help);
                    self.arguments()?;
                    return Ok(Expr { kind: ExprKind::Wrong, at: at.to(self.last) });
                }
                return Ok(Expr { at: path.at, kind: ExprKind::Path(path) });
            }
            _ => return Err(self.unexpected("a value")),
        };
        Ok(Expr { kind, at })
    }

    fn literal<T>(
        &mut self,
        code: Code,
        at: At,
        read: Result<T, LiteralFault>,
        kind: impl FnOnce(T) -> ExprKind,
    ) -> ExprKind {
        match read {
            Ok(value) => kind(value),
            Err(fault) => {
                let (message, help) = fault.text();
                self.findings.error(code, at, message, help);
                ExprKind::Wrong
            }
        }
    }

    /// `INT#5`, `WORD#16#FF`, `BOOL#1`.
    fn typed_literal(&mut self) -> Parsed<Expr> {
        let start = self.token.1;
        let key = self.slice(start).trim_end_matches('#').to_ascii_uppercase();
        let Some(ty) = Elementary::named(&key) else {
            if words::is_unsupported(&key) || key == "D" {
                return Err(self.unsupported(start, &format!("a literal of {key}")));
            }
            let message = format!("{key} is no elementary type");
            self.findings.error(Code::UnknownType, start, message, "write a type before #, as in INT#5");
            return Err(Reported);
        };
        self.advance();
        if ty == Elementary::Bool && (self.at_word("TRUE") || self.at_word("FALSE")) {
            let value = self.at_word("TRUE");
            self.advance();
            return Ok(Expr { kind: ExprKind::Bool(value), at: start.to(self.last) });
        }
        let negative = self.accept(Token::Minus);
        if !negative {
            self.accept(Token::Plus);
        }
        if !matches!(self.token.0, Token::Integer | Token::Based) {
            return Err(self.unexpected("a number"));
        }
        let text = self.slice(self.token.1);
        self.advance();
        let at = start.to(self.last);
        let kind = self.literal(Code::Number, at, literal::number(text), |n| {
            ExprKind::Number(if negative { -n } else { n }, Some(ty))
        });
        Ok(Expr { kind, at })
    }

    /// `a`, `t1.Q`, `a[i]`, `m[i, j].x`.
    pub(super) fn path(&mut self, what: &str) -> Parsed<Path> {
        let root = self.name(what)?;
        let mut path = Path { at: root.at, root, rest: Vec::new() };
        loop {
            match self.token.0 {
                Token::Dot if self.next.0 == Token::Integer => {
                    return Err(self.unsupported(self.next.1, "access to single bits of a variable"));
                }
                Token::Dot => {
                    self.advance();
                    let name = self.name("the name of a member")?;
                    path.rest.push(Segment::Member(name));
                }
                Token::OpenBracket => {
                    let open = self.token.1;
                    self.advance();
                    let mut indices = vec![self.expression()?];
                    while self.accept(Token::Comma) {
                        indices.push(self.expression()?);
                    }
                    let end = self.expect(Token::CloseBracket, "a closing bracket ]")?;
                    path.rest.push(Segment::Index(indices, open.to(end)));
                }
                Token::Caret => return Err(self.unsupported(self.token.1, "a pointer")),
                _ => break,
            }
            path.at = path.at.to(self.last);
        }
        Ok(path)
    }

    /// The bracket behind what is called.
    pub(super) fn arguments(&mut self) -> Parsed<Vec<Argument>> {
        self.expect(Token::Open, "an opening bracket (")?;
        let mut arguments = Vec::new();
        if self.accept(Token::Close) {
            return Ok(arguments);
        }
        loop {
            arguments.push(match (self.token.0, self.next.0) {
                (Token::Word, Token::Assign) => {
                    let name = self.name("the name of a parameter")?;
                    self.advance();
                    Argument::Input(name, self.expression()?)
                }
                (Token::Word, Token::Arrow) => {
                    let name = self.name("the name of a parameter")?;
                    self.advance();
                    Argument::Output(name, self.expression()?)
                }
                _ => Argument::Positional(self.expression()?),
            });
            if !self.accept(Token::Comma) {
                break;
            }
        }
        self.expect(Token::Close, "a comma or a closing bracket )")?;
        Ok(arguments)
    }
}
