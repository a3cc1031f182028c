//! Statements.

use super::ast::{AssignKind, CaseLabel, Counted, Expr, ExprKind, Stmt, StmtKind};
use super::lexer::Token;
use super::words::Word;
use super::{AlreadyReported, Parsed, Parser};
use crate::codes::Code;
use crate::findings::SourcePlace;

impl Parser<'_, '_, '_> {
    /// Statements up to a word that ends a list, or in a CASE up to the next label.
    pub(super) fn statements(&mut self, in_case: bool) -> Vec<Stmt> {
        let mut list = Vec::new();
        loop {
            while self.accept(Token::Semicolon) {}
            if self.list_ends() || in_case && self.at_case_label() {
                return list;
            }
            if let Some(word) =
                self.word().filter(|word| word.belongs_to_statement() || word.closes_elsewhere())
            {
                self.stray(word);
                continue;
            }
            if self.refused_label() {
                continue;
            }
            let start = self.at();
            match self.nested(Self::statement) {
                Ok(kind) => list.push(Stmt { kind, at: start.to(self.last) }),
                Err(AlreadyReported) => self.recover(start),
            }
        }
    }

    /// Whether a list of statements ends here. What divides or closes a statement ends it only inside of one.
    fn list_ends(&self) -> bool {
        let Some(word) = self.word() else { return self.is(Token::End) };
        let inside = |close| self.open.contains(&close);
        match word {
            Word::Else => inside(Word::EndIf) || inside(Word::EndCase),
            Word::Elsif => inside(Word::EndIf),
            Word::Until => inside(Word::EndRepeat),
            _ if word.belongs_to_statement() => inside(word),
            _ => word.opens_declaration() || word.closes_declaration(),
        }
    }

    /// Whether a label of CASE starts here: what no statement starts with.
    fn at_case_label(&self) -> bool {
        match self.tok.token {
            Token::Integer
            | Token::Based
            | Token::Real
            | Token::Duration
            | Token::Date
            | Token::Prefix
            | Token::Text
            | Token::Minus
            | Token::Plus
            | Token::Open => true,
            Token::Word => match self.word() {
                Some(Word::True | Word::False | Word::Null | Word::Not) => true,
                _ => self.at_name() && self.label_behind_path(),
            },
            Token::Dot => self.label_behind_path(),
            _ => false,
        }
    }

    /// Whether a name such as `library.colour.red` is followed by what follows a label, not an assignment or call.
    fn label_behind_path(&self) -> bool {
        let mut n = usize::from(self.is(Token::Dot)) + 1;
        while self.ahead(n).token == Token::Dot {
            n += 2;
        }
        match self.ahead(n).token {
            Token::Colon | Token::Comma | Token::Range => true,
            // More likely an assignment that lacks its colon.
            Token::Equal => false,
            // `last + 1:`
            _ => self.ahead(n).operator().is_some(),
        }
    }

    /// After the next semicolon, or before the next word that starts a statement or ends a list. `start` is where
    /// the bad statement began: something is always skipped.
    fn recover(&mut self, start: SourcePlace) {
        if self.at() == start && !self.is(Token::Semicolon) {
            self.advance();
        }
        while !self.list_ends() {
            let stops =
                self.word().is_some_and(|word| word.opens_statements() || word.belongs_to_statement());
            if stops || self.accept(Token::Semicolon) {
                return;
            }
            self.advance();
        }
    }

    fn statement(&mut self) -> Parsed<StmtKind> {
        let kind = match self.word() {
            Some(Word::If) => self.if_statement()?,
            Some(Word::Case) => self.case_statement()?,
            Some(Word::For) => self.for_statement()?,
            Some(Word::While) => self.while_statement()?,
            Some(Word::Repeat) => self.repeat_statement()?,
            word => {
                let kind = match word {
                    Some(Word::Exit) => self.single(StmtKind::Exit),
                    Some(Word::Continue) => self.single(StmtKind::Continue),
                    Some(Word::Return) if self.next_is(Token::Open) => self.conditional_return()?,
                    Some(Word::Return) => self.single(StmtKind::Return),
                    _ => {
                        self.refused_statement()?;
                        self.assign_or_call()?
                    }
                };
                self.semicolon()?;
                return Ok(kind);
            }
        };
        // What closes itself needs no semicolon.
        self.accept(Token::Semicolon);
        Ok(kind)
    }

    fn single(&mut self, kind: StmtKind) -> StmtKind {
        self.advance();
        kind
    }

    fn assign_or_call(&mut self) -> Parsed<StmtKind> {
        let target = self.target("a statement")?;
        let kind = match self.tok.token {
            Token::Assign => AssignKind::Value,
            Token::Word if self.next_is(Token::Equal) => match self.word() {
                Some(Word::S) => AssignKind::Set,
                Some(Word::R) => AssignKind::Reset,
                Some(Word::Ref) => AssignKind::Reference,
                _ => return self.alone(target),
            },
            _ => return self.alone(target),
        };
        self.assignable(&target)?;
        let mut targets = vec![target];
        if kind != AssignKind::Value {
            self.advance();
            self.advance();
            let value = self.expression()?;
            return Ok(StmtKind::Assign { targets, kind, value });
        }
        loop {
            self.advance();
            let value = self.expression()?;
            if !self.is(Token::Assign) {
                return Ok(StmtKind::Assign { targets, kind, value });
            }
            self.assignable(&value)?;
            targets.push(value);
        }
    }

    pub(super) fn assignable(&mut self, target: &Expr) -> Parsed<()> {
        if target.kind.is_target() {
            return Ok(());
        }
        let help = "write a variable before :=";
        Err(self.error(Code::Unexpected, target.at, "this cannot be assigned to", help))
    }

    /// What a statement starts with: a variable or a call.
    fn target(&mut self, what: &str) -> Parsed<Expr> {
        let starts = matches!(self.word(), None | Some(Word::This | Word::Super)) || self.at_name();
        let starts =
            starts && matches!(self.tok.token, Token::Word | Token::Address | Token::Dot | Token::BadText);
        if starts { self.postfix(what) } else { Err(self.unexpected(what)) }
    }

    /// An expression without an assignment: only a call, or the name of something that is called, means anything.
    fn alone(&mut self, expr: Expr) -> Parsed<StmtKind> {
        match self.tok.token {
            Token::Equal => {
                let message = "= compares, it does not assign";
                Err(self.error(Code::Unexpected, self.at(), message, "write := to assign"))
            }
            Token::Attempt => {
                let help = "compare the reference with NULL, then assign it with :=";
                Err(self.unsupported(self.at(), "the assignment attempt ?=", help))
            }
            _ if matches!(expr.kind, ExprKind::Call(..)) => Ok(StmtKind::Call(expr)),
            _ if expr.kind.is_called_bare() && (self.is(Token::Semicolon) || self.list_ends()) => {
                Ok(StmtKind::Call(expr))
            }
            _ => Err(self.unexpected(":= or a call")),
        }
    }

    /// The keyword that closes what `open` opened.
    fn close(&mut self, word: Word, open: SourcePlace) -> Parsed<SourcePlace> {
        if self.accept_word(word) { Ok(self.last) } else { Err(self.unclosed(word, open)) }
    }

    /// The statements that `close` closes, which is not taken.
    fn inside(&mut self, close: Word, in_case: bool) -> Vec<Stmt> {
        self.open.push(close);
        let list = self.statements(in_case);
        self.open.pop();
        list
    }

    /// A value in the head of a statement and the word after it. Where either is wrong, reading goes on with the
    /// statements inside, so that what closes them is not reported too.
    fn head(&mut self, word: Word) -> Expr {
        let at = self.at();
        let read = self.expression().and_then(|expr| self.expect_word(word).map(|_| expr));
        read.unwrap_or_else(|AlreadyReported| {
            self.recover_in_head(word);
            Expr { kind: ExprKind::Wrong, at }
        })
    }

    /// After `word`, or to where the statements inside seem to start.
    fn recover_in_head(&mut self, word: Word) {
        while !self.is(Token::Semicolon) && !self.list_ends() {
            let stops =
                self.word().is_some_and(|word| word.opens_statements() || word.belongs_to_statement());
            if stops || self.accept_word(word) {
                return;
            }
            self.advance();
        }
    }

    fn if_statement(&mut self) -> Parsed<StmtKind> {
        let open = self.expect_word(Word::If)?;
        let mut arms = Vec::new();
        loop {
            let condition = self.head(Word::Then);
            arms.push((condition, self.inside(Word::EndIf, false)));
            if !self.accept_word(Word::Elsif) {
                break;
            }
        }
        let otherwise =
            if self.accept_word(Word::Else) { self.inside(Word::EndIf, false) } else { Vec::new() };
        self.close(Word::EndIf, open)?;
        Ok(StmtKind::If { arms, otherwise })
    }

    /// `RETURN(condition);`, a return that is taken where the condition holds.
    fn conditional_return(&mut self) -> Parsed<StmtKind> {
        let at = self.at();
        self.advance();
        self.advance();
        let condition = self.expression()?;
        self.expect(Token::Close, "a closing bracket )")?;
        let leave = Stmt { kind: StmtKind::Return, at };
        Ok(StmtKind::If { arms: vec![(condition, vec![leave])], otherwise: Vec::new() })
    }

    fn case_statement(&mut self) -> Parsed<StmtKind> {
        let open = self.expect_word(Word::Case)?;
        let selector = self.head(Word::Of);
        let mut arms = Vec::new();
        self.open.push(Word::EndCase);
        loop {
            while self.accept(Token::Semicolon) {}
            if self.list_ends() {
                break;
            }
            let start = self.at();
            match self.labels() {
                Ok(labels) => arms.push((labels, self.statements(true))),
                Err(AlreadyReported) => {
                    self.recover(start);
                    self.statements(true);
                }
            }
        }
        let otherwise = if self.accept_word(Word::Else) { self.statements(false) } else { Vec::new() };
        self.open.pop();
        self.close(Word::EndCase, open)?;
        Ok(StmtKind::Case { selector, arms, otherwise })
    }

    fn labels(&mut self) -> Parsed<Vec<CaseLabel>> {
        let mut labels = Vec::new();
        loop {
            let low = self.expression()?;
            let high = if self.accept(Token::Range) { Some(self.expression()?) } else { None };
            labels.push(CaseLabel { low, high });
            if !self.accept(Token::Comma) {
                break;
            }
        }
        self.expect(Token::Colon, "a colon after the label")?;
        Ok(labels)
    }

    fn for_statement(&mut self) -> Parsed<StmtKind> {
        let open = self.expect_word(Word::For)?;
        let (variable, from, to, by) = match self.for_head() {
            Ok(head) => head,
            Err(AlreadyReported) => {
                self.recover_in_head(Word::Do);
                let wrong = Expr { kind: ExprKind::Wrong, at: open };
                (wrong.clone(), wrong.clone(), wrong, None)
            }
        };
        let body = self.inside(Word::EndFor, false);
        let end = self.close(Word::EndFor, open)?;
        Ok(StmtKind::For(Box::new(Counted { variable, from, to, by, body, end })))
    }

    fn for_head(&mut self) -> Parsed<(Expr, Expr, Expr, Option<Expr>)> {
        let variable = self.target("the control variable")?;
        self.assignable(&variable)?;
        self.expect(Token::Assign, ":=")?;
        let from = self.expression()?;
        self.expect_word(Word::To)?;
        let to = self.expression()?;
        let by = if self.accept_word(Word::By) { Some(self.expression()?) } else { None };
        self.expect_word(Word::Do)?;
        Ok((variable, from, to, by))
    }

    fn while_statement(&mut self) -> Parsed<StmtKind> {
        let open = self.expect_word(Word::While)?;
        let condition = self.head(Word::Do);
        let body = self.inside(Word::EndWhile, false);
        let end = self.close(Word::EndWhile, open)?;
        Ok(StmtKind::While { condition, body, end })
    }

    fn repeat_statement(&mut self) -> Parsed<StmtKind> {
        let open = self.expect_word(Word::Repeat)?;
        let body = self.inside(Word::EndRepeat, false);
        self.close(Word::Until, open)?;
        let until = self.expression()?;
        self.accept(Token::Semicolon);
        self.close(Word::EndRepeat, open)?;
        Ok(StmtKind::Repeat { body, until })
    }
}

impl ExprKind {
    /// Whether this alone calls something: the name of an action.
    fn is_called_bare(&self) -> bool {
        matches!(self, ExprKind::Name(_) | ExprKind::Global(_) | ExprKind::Member(..))
    }

    /// Whether a value can be assigned to this.
    fn is_target(&self) -> bool {
        use ExprKind::{Deref, Direct, Global, Index, Member, Name, Part};
        matches!(self, Name(_) | Global(_) | Member(..) | Part { .. } | Index(..) | Deref(_) | Direct(_))
    }
}
