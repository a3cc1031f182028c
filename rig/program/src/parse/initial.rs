//! Initial values.

use super::ast::{Expr, ExprKind, Initializer, Name, TypeKind, TypeRef};
use super::lexer::Token;
use super::words::Word;
use super::{Parsed, Parser};

impl Parser<'_, '_, '_> {
    /// What stands after a type: `:=` and values, or nothing.
    pub(super) fn initial_of(&mut self, ty: &TypeRef) -> Parsed<Option<Initializer>> {
        if self.at_word(Word::Ref) && self.next_is(Token::Equal) {
            let help = "assign it in a statement";
            return Err(self.unsupported(self.at(), "REF= in a declaration", help));
        }
        if !self.accept(Token::Assign) {
            return Ok(None);
        }
        let start = self.at();
        let first = self.repeated()?;
        let listed = first.0.is_some() || self.is(Token::Comma);
        if !listed {
            return Ok(Some(first.1));
        }
        // Values of an array without brackets, as older tools write them.
        if !matches!(ty.kind, TypeKind::Array { .. } | TypeKind::Named(_)) {
            return Err(self.unexpected("a semicolon"));
        }
        let mut list = vec![first];
        while self.accept(Token::Comma) {
            list.push(self.repeated()?);
        }
        Ok(Some(Initializer::List(list, start.to(self.last))))
    }

    /// `[1, 2]`, `(a := 1)` or an expression.
    fn initial(&mut self) -> Parsed<Initializer> {
        let open = self.at();
        if self.at_members() {
            self.advance();
            let members = self.nested(Self::member_values)?;
            let end = self.expect(Token::Close, "a comma or a closing bracket )")?;
            return Ok(Initializer::Members(members, open.to(end)));
        }
        if !self.is(Token::OpenBracket) {
            return Ok(Initializer::One(self.expression()?));
        }
        self.advance();
        let list = self.nested(Self::values)?;
        let end = self.expect(Token::CloseBracket, "a comma or a closing bracket ]")?;
        Ok(Initializer::List(list, open.to(end)))
    }

    /// Whether a bracket with values for members opens here.
    fn at_members(&self) -> bool {
        self.is(Token::Open) && self.ahead(1).token == Token::Word && self.ahead(2).token == Token::Assign
    }

    fn member_values(&mut self) -> Parsed<Vec<(Name, Initializer)>> {
        let mut members = Vec::new();
        loop {
            let name = self.name("the name of a member")?;
            self.expect(Token::Assign, ":=")?;
            members.push((name, self.initial()?));
            if !self.accept(Token::Comma) {
                return Ok(members);
            }
        }
    }

    fn values(&mut self) -> Parsed<Vec<(Option<Expr>, Initializer)>> {
        let mut list = Vec::new();
        if self.is(Token::CloseBracket) {
            return Ok(list);
        }
        loop {
            list.push(self.repeated()?);
            if !self.accept(Token::Comma) {
                return Ok(list);
            }
        }
    }

    /// `5`, or `10(5)` for ten times.
    fn repeated(&mut self) -> Parsed<(Option<Expr>, Initializer)> {
        let value = self.initial()?;
        let Initializer::One(count @ Expr { kind: ExprKind::Number(..), .. }) = value else {
            return Ok((None, value));
        };
        if !self.is(Token::Open) {
            return Ok((None, Initializer::One(count)));
        }
        // `2(a := 1)` gives the members of two elements.
        let repeated = if self.at_members() {
            self.initial()?
        } else {
            self.advance();
            let repeated = self.nested(Self::initial)?;
            self.expect(Token::Close, "a closing bracket ) after the repeated value")?;
            repeated
        };
        Ok((Some(count), repeated))
    }
}
