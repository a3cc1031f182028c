//! Expressions, with the precedence of IEC 61131-3.

use super::ast::{Argument, BinaryOp, Expr, ExprKind, Name, UnaryOp};
use super::lexer::Token;
use super::tokens::Tok;
use super::words::Word;
use super::{MAX_HEIGHT, Parsed, Parser};
use crate::codes::Code;
use crate::findings::SourcePlace;

impl Parser<'_, '_, '_> {
    pub(super) fn expression(&mut self) -> Parsed<Expr> {
        self.nested(|p| p.binary(0))
    }

    /// One node above what was read last.
    fn grow(&mut self, height: usize) -> Parsed<()> {
        self.height = height + 1;
        if self.height > MAX_HEIGHT { Err(self.too_deep()) } else { Ok(()) }
    }

    /// Operators of `least` level and tighter ones. Those of one level make one chain, from left to right.
    fn binary(&mut self, least: u8) -> Parsed<Expr> {
        let mut left = self.unary()?;
        while let Some((_, level)) = self.operator().filter(|(_, level)| *level >= least) {
            let mut height = self.height;
            let mut rest = Vec::new();
            while let Some((op, _)) = self.operator().filter(|(_, found)| *found == level) {
                let at = self.at();
                self.advance();
                rest.push((op, at, self.binary(level + 1)?));
                height = height.max(self.height);
            }
            self.grow(height)?;
            let at = left.at.to(self.last);
            left = Expr { kind: ExprKind::Chain(Box::new(left), rest), at };
        }
        Ok(left)
    }

    fn operator(&self) -> Option<(BinaryOp, u8)> {
        self.tok.operator()
    }

    /// Signs and NOT bind tighter than every operator, `**` included: `-a ** b` is `(-a) ** b`.
    fn unary(&mut self) -> Parsed<Expr> {
        let at = self.at();
        let op = match self.tok.token {
            Token::Minus => UnaryOp::Minus,
            Token::Plus => UnaryOp::Plus,
            Token::Word if self.at_word(Word::Not) => UnaryOp::Not,
            _ => return self.postfix("a value"),
        };
        self.advance();
        let operand = self.nested(Self::unary)?;
        self.grow(self.height)?;
        Ok(Expr { at: at.to(operand.at), kind: ExprKind::Unary(op, Box::new(operand)) })
    }

    /// A value with what stands after it: `a.b`, `a[1]`, `p^`, `f(x)`, `w.%X3`, in any order.
    pub(super) fn postfix(&mut self, what: &str) -> Parsed<Expr> {
        let mut expr = self.primary(what)?;
        loop {
            let height = self.height;
            let kind = match self.tok.token {
                _ if !expr.kind.is_place() => return Ok(expr),
                Token::Dot => {
                    self.advance();
                    self.behind_point(&mut expr)?
                }
                Token::OpenBracket => {
                    self.advance();
                    let mut indices = vec![self.expression()?];
                    let mut height = height.max(self.height);
                    while self.accept(Token::Comma) {
                        indices.push(self.expression()?);
                        height = height.max(self.height);
                    }
                    self.expect(Token::CloseBracket, "a comma or a closing bracket ]")?;
                    self.height = height;
                    ExprKind::Index(Box::new(taken(&mut expr)), indices)
                }
                Token::Caret => {
                    self.advance();
                    ExprKind::Deref(Box::new(taken(&mut expr)))
                }
                Token::Open if expr.kind.can_be_called() => {
                    let arguments = self.arguments()?;
                    self.height = self.height.max(height);
                    ExprKind::Call(Box::new(taken(&mut expr)), arguments)
                }
                _ => return Ok(expr),
            };
            self.grow(self.height.max(height))?;
            expr = Expr { kind, at: expr.at.to(self.last) };
        }
    }

    /// A member, a bit or part, or `colour#red` after the name of a library.
    fn behind_point(&mut self, of: &mut Expr) -> Parsed<ExprKind> {
        let at = self.at();
        match self.tok.token {
            Token::Integer => {
                self.advance();
                let number = self.part_number(at, self.slice(at));
                Ok(ExprKind::Part { of: Box::new(taken(of)), bits: 1, number })
            }
            Token::Address => {
                self.advance();
                let text = self.slice(at);
                let size = text.get(1..2).unwrap_or("").to_ascii_uppercase();
                let bits = match size.as_str() {
                    "X" => 1,
                    "B" => 8,
                    "W" => 16,
                    "D" => 32,
                    _ => {
                        let help = "write %X, %B, %W or %D and a number, as in w.%B1";
                        return Err(self.error(Code::Number, at, format!("`{text}` is no part"), help));
                    }
                };
                // `w.%B1.3`: a bit of the part.
                let mut numbers = text.get(2..).unwrap_or("").split('.');
                let number = self.part_number(at, numbers.next().unwrap_or(""));
                let mut kind = ExprKind::Part { of: Box::new(taken(of)), bits, number };
                for bit in numbers {
                    self.grow(self.height)?;
                    let number = self.part_number(at, bit);
                    kind = ExprKind::Part { of: Box::new(Expr { kind, at: of.at.to(at) }), bits: 1, number };
                }
                Ok(kind)
            }
            Token::Prefix => {
                let ExprKind::Name(_) = of.kind else { return Err(self.unexpected("the name of a member")) };
                match self.typed()?.kind {
                    kind @ ExprKind::Qualified(..) => Ok(kind),
                    _ => {
                        let message = "a literal does not belong to a library";
                        Err(self.error(Code::Unexpected, at, message, "remove the name before the point"))
                    }
                }
            }
            _ => {
                let name = self.name("the name of a member")?;
                Ok(ExprKind::Member(Box::new(taken(of)), name))
            }
        }
    }

    /// The number of a bit or part; the compiler knows how far they go.
    fn part_number(&mut self, at: SourcePlace, text: &str) -> u32 {
        let fine = (1..=9).contains(&text.len()) && text.bytes().all(|byte| byte.is_ascii_digit());
        text.parse().ok().filter(|_| fine).unwrap_or_else(|| {
            let message = format!("`{}` is no number of a bit or part", self.slice(at));
            self.error(Code::Number, at, message, "write it with digits only");
            0
        })
    }

    fn primary(&mut self, what: &str) -> Parsed<Expr> {
        let at = self.at();
        self.height = 1;
        let kind = match self.tok.token {
            Token::Word => match self.word() {
                Some(Word::True) => ExprKind::Bool(true),
                Some(Word::False) => ExprKind::Bool(false),
                Some(Word::This) => ExprKind::This,
                Some(Word::Super) => ExprKind::Super,
                Some(Word::Null) => ExprKind::Null,
                // Functions that have the names of operators: `MOD(a, b)`.
                Some(Word::And | Word::Or | Word::Xor | Word::Mod) if self.next_is(Token::Open) => {
                    ExprKind::Name(Name { key: self.tok.key, at })
                }
                _ => ExprKind::Name(self.name(what)?),
            },
            Token::Open => {
                self.advance();
                let inner = self.expression()?;
                let end = self.expect(Token::Close, "a closing bracket )")?;
                return Ok(Expr { at: at.to(end), ..inner });
            }
            Token::Dot => {
                self.advance();
                ExprKind::Global(self.name("the name of a global variable")?)
            }
            Token::Address => ExprKind::Direct(self.slice(at).into()),
            Token::Prefix => return self.typed(),
            Token::BadText => {
                self.advance();
                return Err(super::AlreadyReported);
            }
            _ => match self.untyped_literal() {
                Some(kind) => kind,
                None => return Err(self.unexpected(what)),
            },
        };
        if self.at() == at {
            self.advance();
        }
        Ok(Expr { kind, at: at.to(self.last) })
    }

    /// The bracket after what is called.
    pub(super) fn arguments(&mut self) -> Parsed<Vec<Argument>> {
        self.expect(Token::Open, "an opening bracket (")?;
        let mut arguments = Vec::new();
        let mut height = 0;
        if self.accept(Token::Close) {
            return Ok(arguments);
        }
        loop {
            self.height = 0;
            arguments.push(self.argument()?);
            height = height.max(self.height);
            if !self.accept(Token::Comma) {
                break;
            }
        }
        self.expect(Token::Close, "a comma or a closing bracket )")?;
        self.height = height;
        Ok(arguments)
    }

    fn argument(&mut self) -> Parsed<Argument> {
        let negated_name = self.at_word(Word::Not)
            && self.ahead(1).token == Token::Word
            && self.ahead(2).token == Token::Arrow;
        if negated_name {
            self.advance();
        }
        if self.is(Token::Word) && self.next_is(Token::Assign) {
            let name = self.name("the name of a parameter")?;
            self.advance();
            return Ok(match self.tok.token {
                Token::Comma | Token::Close => Argument::Empty(name),
                _ => Argument::Input(name, self.expression()?),
            });
        }
        if self.is(Token::Word) && self.next_is(Token::Arrow) {
            let name = self.name("the name of a parameter")?;
            self.advance();
            let negated = negated_name || self.accept_word(Word::Not);
            let target = match self.tok.token {
                Token::Comma | Token::Close if !negated => None,
                _ => {
                    let target = self.expression()?;
                    self.assignable(&target)?;
                    Some(target)
                }
            };
            return Ok(Argument::Output { name, negated, target });
        }
        Ok(Argument::Positional(self.expression()?))
    }
}

/// Moves an expression out, its place stays.
fn taken(expr: &mut Expr) -> Expr {
    Expr { kind: std::mem::replace(&mut expr.kind, ExprKind::Wrong), at: expr.at }
}

impl ExprKind {
    /// Whether something can stand after this: a point, an index, `^`.
    fn is_place(&self) -> bool {
        self.can_be_called()
            || matches!(self, ExprKind::Part { .. } | ExprKind::Call(..) | ExprKind::Direct(_))
    }

    /// Whether a bracket after this is that of a call.
    pub(super) fn can_be_called(&self) -> bool {
        matches!(
            self,
            ExprKind::Name(_)
                | ExprKind::Global(_)
                | ExprKind::Member(..)
                | ExprKind::Index(..)
                | ExprKind::Deref(_)
                | ExprKind::This
                | ExprKind::Super
        )
    }
}

impl Tok {
    /// The operator that a token is, with its level, loosest 0.
    pub(super) fn operator(self) -> Option<(BinaryOp, u8)> {
        Some(match self.token {
            Token::Word => match Word::of(self.key)? {
                Word::Or => (BinaryOp::Or, 0),
                Word::OrElse => (BinaryOp::OrElse, 0),
                Word::Xor => (BinaryOp::Xor, 1),
                Word::And => (BinaryOp::And, 2),
                Word::AndThen => (BinaryOp::AndThen, 2),
                Word::Mod => (BinaryOp::Mod, 6),
                _ => return None,
            },
            Token::Ampersand => (BinaryOp::And, 2),
            Token::Equal => (BinaryOp::Equal, 3),
            Token::NotEqual => (BinaryOp::NotEqual, 3),
            Token::Less => (BinaryOp::Less, 4),
            Token::LessEqual => (BinaryOp::LessEqual, 4),
            Token::Greater => (BinaryOp::Greater, 4),
            Token::GreaterEqual => (BinaryOp::GreaterEqual, 4),
            Token::Plus => (BinaryOp::Add, 5),
            Token::Minus => (BinaryOp::Subtract, 5),
            Token::Star => (BinaryOp::Multiply, 6),
            Token::Slash => (BinaryOp::Divide, 6),
            Token::Power => (BinaryOp::Power, 7),
            _ => return None,
        })
    }
}
