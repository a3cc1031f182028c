//! Statements.

use super::ast::{CaseLabel, Counted, Expr, ExprKind, Stmt, StmtKind};
use super::lexer::Token;
use super::{Parsed, Parser, Reported, words};
use crate::codes::Code;
use crate::findings::At;

impl Parser<'_, '_, '_> {
    /// Statements up to a word that ends a list, or in a CASE up to the next label.
    pub(super) fn statements(&mut self, in_case: bool) -> Vec<Stmt> {
        let mut list = Vec::new();
        loop {
            while self.accept(Token::Semicolon) {}
            if self.list_ends() || in_case && self.at_label() {
                return list;
            }
            let start = self.token.1;
            match self.nested(Self::statement) {
                Ok(kind) => list.push(Stmt { kind, at: start.to(self.last) }),
                Err(Reported) => self.recover(start),
            }
        }
    }

    fn list_ends(&self) -> bool {
        match self.token.0 {
            Token::End => true,
            Token::Word => words::ends_statements(&self.slice(self.token.1).to_ascii_uppercase()),
            _ => false,
        }
    }

    /// Whether a label of CASE starts here: what no statement starts with.
    fn at_label(&self) -> bool {
        match self.token.0 {
            Token::Integer | Token::Based | Token::Duration | Token::Prefix | Token::Minus | Token::Real => {
                true
            }
            Token::Word => {
                self.at_word("TRUE")
                    || self.at_word("FALSE")
                    || matches!(self.next.0, Token::Colon | Token::Comma | Token::Range)
            }
            _ => false,
        }
    }

    /// Behind the next semicolon, or before the next word that ends a list. `start` is where the bad
    /// statement began: something is always skipped.
    fn recover(&mut self, start: At) {
        if self.token.1 == start && !self.is(Token::Semicolon) {
            self.advance();
        }
        while !self.list_ends() {
            if self.accept(Token::Semicolon) {
                return;
            }
            self.advance();
        }
    }

    fn statement(&mut self) -> Parsed<StmtKind> {
        let start = self.token.1;
        let kind = match self.token.0 {
            Token::Word => match self.slice(start).to_ascii_uppercase().as_str() {
                "IF" => self.if_statement()?,
                "CASE" => self.case_statement()?,
                "FOR" => self.for_statement()?,
                "WHILE" => self.while_statement()?,
                "REPEAT" => self.repeat_statement()?,
                "EXIT" => self.single(StmtKind::Exit),
                "CONTINUE" => self.single(StmtKind::Continue),
                "RETURN" => self.single(StmtKind::Return),
                _ => self.assign_or_call()?,
            },
            Token::Address => {
                self.advance();
                let target = Expr { kind: ExprKind::Direct(self.slice(start).to_string()), at: start };
                self.assignment(target)?
            }
            _ => return Err(self.unexpected("a statement")),
        };
        self.semicolon()?;
        Ok(kind)
    }

    fn single(&mut self, kind: StmtKind) -> StmtKind {
        self.advance();
        kind
    }

    fn assign_or_call(&mut self) -> Parsed<StmtKind> {
        let path = self.path("a statement")?;
        if self.is(Token::Open) {
            let arguments = self.arguments()?;
            return Ok(StmtKind::Call(path, arguments));
        }
        self.assignment(Expr { at: path.at, kind: ExprKind::Path(path) })
    }

    fn assignment(&mut self, target: Expr) -> Parsed<StmtKind> {
        if self.is(Token::Equal) {
            let message = "= compares, it does not assign";
            self.findings.error(Code::Unexpected, self.token.1, message, "write := to assign");
            return Err(Reported);
        }
        self.expect(Token::Assign, ":= or a call")?;
        let value = self.expression()?;
        Ok(StmtKind::Assign { target, value })
    }

    /// The keyword that closes what `open` opened.
    fn close(&mut self, word: &str, open: At) -> Parsed<At> {
        if self.accept_word(word) { Ok(self.last) } else { Err(self.unclosed(word, open)) }
    }

    fn if_statement(&mut self) -> Parsed<StmtKind> {
        let open = self.expect_word("IF")?;
        let mut arms = vec![self.arm()?];
        while self.accept_word("ELSIF") {
            arms.push(self.arm()?);
        }
        let otherwise = if self.accept_word("ELSE") { self.statements(false) } else { Vec::new() };
        self.close("END_IF", open)?;
        Ok(StmtKind::If { arms, otherwise })
    }

    fn arm(&mut self) -> Parsed<(Expr, Vec<Stmt>)> {
        let condition = self.expression()?;
        self.expect_word("THEN")?;
        Ok((condition, self.statements(false)))
    }

    fn case_statement(&mut self) -> Parsed<StmtKind> {
        let open = self.expect_word("CASE")?;
        let selector = self.expression()?;
        self.expect_word("OF")?;
        let mut arms = Vec::new();
        while !self.list_ends() {
            let mut labels = vec![self.label()?];
            while self.accept(Token::Comma) {
                labels.push(self.label()?);
            }
            self.expect(Token::Colon, "a colon")?;
            arms.push((labels, self.statements(true)));
        }
        let otherwise = if self.accept_word("ELSE") { self.statements(false) } else { Vec::new() };
        self.close("END_CASE", open)?;
        Ok(StmtKind::Case { selector, arms, otherwise })
    }

    fn label(&mut self) -> Parsed<CaseLabel> {
        let low = self.expression()?;
        let high = if self.accept(Token::Range) { Some(self.expression()?) } else { None };
        Ok(CaseLabel { low, high })
    }

    fn for_statement(&mut self) -> Parsed<StmtKind> {
        let open = self.expect_word("FOR")?;
        let path = self.path("the control variable")?;
        let variable = Expr { at: path.at, kind: ExprKind::Path(path) };
        self.expect(Token::Assign, ":=")?;
        let from = self.expression()?;
        self.expect_word("TO")?;
        let to = self.expression()?;
        let by = if self.accept_word("BY") { Some(self.expression()?) } else { None };
        self.expect_word("DO")?;
        let body = self.statements(false);
        let end = self.close("END_FOR", open)?;
        Ok(StmtKind::For(Box::new(Counted { variable, from, to, by, body, end })))
    }

    fn while_statement(&mut self) -> Parsed<StmtKind> {
        let open = self.expect_word("WHILE")?;
        let condition = self.expression()?;
        self.expect_word("DO")?;
        let body = self.statements(false);
        let end = self.close("END_WHILE", open)?;
        Ok(StmtKind::While { condition, body, end })
    }

    fn repeat_statement(&mut self) -> Parsed<StmtKind> {
        let open = self.expect_word("REPEAT")?;
        let body = self.statements(false);
        self.close("UNTIL", open)?;
        let until = self.expression()?;
        self.close("END_REPEAT", open)?;
        Ok(StmtKind::Repeat { body, until })
    }
}
