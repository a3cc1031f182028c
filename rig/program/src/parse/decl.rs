//! Units and their declarations.

use super::ast::{Initial, Pou, PouKind, Section, SectionKind, TypeRef, Unit, VarDecl};
use super::lexer::Token;
use super::{Parsed, Parser, Reported, words};
use crate::codes::Code;
use crate::findings::At;
use crate::program::Retention;

impl Parser<'_, '_, '_> {
    pub(super) fn declarations(&mut self, unit: &mut Unit) {
        while !self.is(Token::End) {
            let start = self.token.1;
            if self.declaration(unit).is_err() {
                self.skip_to_declaration(start);
            }
        }
    }

    fn declaration(&mut self, unit: &mut Unit) -> Parsed<()> {
        if self.accept(Token::Semicolon) {
            return Ok(());
        }
        for kind in [PouKind::Program, PouKind::FunctionBlock, PouKind::Function] {
            if self.at_word(kind.keyword()) {
                let pou = self.pou(kind)?;
                unit.pous.push(pou);
                return Ok(());
            }
        }
        if self.at_word("VAR_GLOBAL") {
            if let Some(section) = self.section()? {
                unit.globals.push(section);
            }
            return Ok(());
        }
        Err(self.unexpected("PROGRAM, FUNCTION, FUNCTION_BLOCK or VAR_GLOBAL"))
    }

    /// To the next word that starts a unit at the outside; inside a unit these words do not occur.
    fn skip_to_declaration(&mut self, start: At) {
        let mut first = self.token.1 == start;
        while !self.is(Token::End) {
            let starts =
                ["PROGRAM", "FUNCTION", "FUNCTION_BLOCK", "VAR_GLOBAL"].iter().any(|word| self.at_word(word));
            if starts && !first {
                return;
            }
            first = false;
            self.advance();
        }
    }

    fn pou(&mut self, kind: PouKind) -> Parsed<Pou> {
        let open = self.expect_word(kind.keyword())?;
        let name = self.new_name("a name")?;
        let result = match kind {
            PouKind::Function => {
                if !self.is(Token::Colon) {
                    let message = format!("the function `{}` has no result type", name.text);
                    self.findings.error(
                        Code::Unexpected,
                        self.token.1,
                        message,
                        "write it as in FUNCTION f : INT",
                    );
                    return Err(Reported);
                }
                self.advance();
                Some(self.type_ref()?)
            }
            _ => None,
        };
        let mut sections = Vec::new();
        while self.is(Token::Word) && self.slice(self.token.1).to_ascii_uppercase().starts_with("VAR") {
            let key = self.slice(self.token.1).to_ascii_uppercase();
            if !words::ends_statements(&key) {
                break;
            }
            if words::is_unsupported(&key) {
                self.unsupported(self.token.1, &key);
                self.skip_section();
                continue;
            }
            if let Some(section) = self.section()? {
                sections.push(section);
            }
        }
        let body = self.statements(false);
        let close = format!("END_{}", kind.keyword());
        if !self.accept_word(&close) {
            self.unclosed(&close, open);
            // What closes something else would only be reported again and again.
            if !self.is(Token::End) {
                return Err(Reported);
            }
        }
        Ok(Pou { kind, name, result, sections, body, end: self.last })
    }

    fn skip_section(&mut self) {
        while !self.is(Token::End) && !self.accept_word("END_VAR") {
            self.advance();
        }
    }

    /// VAR .. END_VAR. `None` where what it holds was reported and skipped.
    fn section(&mut self) -> Parsed<Option<Section>> {
        let at = self.token.1;
        let kind = match self.slice(at).to_ascii_uppercase().as_str() {
            "VAR" => SectionKind::Local,
            "VAR_INPUT" => SectionKind::Input,
            "VAR_OUTPUT" => SectionKind::Output,
            "VAR_GLOBAL" => SectionKind::Global,
            _ => return Err(self.unexpected("VAR, VAR_INPUT, VAR_OUTPUT or VAR_GLOBAL")),
        };
        self.advance();
        let mut section =
            Section { kind, retention: Retention::None, constant: false, variables: Vec::new(), at };
        loop {
            if self.accept_word("CONSTANT") {
                section.constant = true;
            } else if self.accept_word("RETAIN") {
                section.retention = section.retention.max(Retention::Retain);
            } else if self.accept_word("PERSISTENT") {
                section.retention = Retention::Persistent;
            } else if !self.accept_word("NON_RETAIN") {
                break;
            }
        }
        while !self.at_word("END_VAR") {
            let start = self.token.1;
            let ended = self.is(Token::End) || self.at_statement();
            if ended || self.variables(&mut section).is_err() && !self.recover_in_section(start) {
                self.unclosed("END_VAR", at);
                return Ok(Some(section));
            }
        }
        self.advance();
        Ok(Some(section))
    }

    /// Whether a statement starts here, or a unit ends: then the section was not closed.
    fn at_statement(&self) -> bool {
        let goes_on = matches!(self.next.0, Token::Assign | Token::Open | Token::OpenBracket | Token::Dot);
        self.is(Token::Word) && goes_on || self.at_statement_word()
    }

    fn at_statement_word(&self) -> bool {
        let key = self.slice(self.token.1).to_ascii_uppercase();
        let starts = ["IF", "FOR", "CASE", "WHILE", "REPEAT"].contains(&key.as_str());
        self.is(Token::Word) && (starts || words::ends_statements(&key))
    }

    /// Behind the next semicolon or before END_VAR; FALSE where the section seems to have ended.
    fn recover_in_section(&mut self, start: At) -> bool {
        if self.token.1 == start && !self.at_word("END_VAR") {
            self.advance();
        }
        loop {
            if self.at_word("END_VAR") || self.accept(Token::Semicolon) {
                return true;
            }
            if self.is(Token::End) || self.at_statement_word() {
                return false;
            }
            self.advance();
        }
    }

    /// `a, b AT %MW1 : INT := 5;`
    fn variables(&mut self, section: &mut Section) -> Parsed<()> {
        let mut names = Vec::new();
        let mut address = None;
        loop {
            names.push(self.new_name("the name of a variable or END_VAR")?);
            if self.accept_word("AT") {
                let at = self.token.1;
                self.expect(Token::Address, "an address such as %MW10")?;
                address = Some((self.slice(at).to_string(), at));
            }
            if !self.accept(Token::Comma) {
                break;
            }
        }
        self.expect(Token::Colon, "a colon and a type")?;
        let ty = self.type_ref()?;
        let initial = if self.accept(Token::Assign) { Some(self.initial()?) } else { None };
        self.semicolon()?;
        for name in names {
            section.variables.push(VarDecl {
                name,
                address: address.clone(),
                ty: ty.clone(),
                initial: initial.clone(),
            });
        }
        Ok(())
    }

    fn type_ref(&mut self) -> Parsed<TypeRef> {
        let at = self.token.1;
        if !self.accept_word("ARRAY") {
            return Ok(TypeRef::Named(self.name("a type")?));
        }
        self.expect(Token::OpenBracket, "an opening bracket [")?;
        let mut ranges = Vec::new();
        loop {
            let low = self.expression()?;
            self.expect(Token::Range, "..")?;
            ranges.push((low, self.expression()?));
            if !self.accept(Token::Comma) {
                break;
            }
        }
        self.expect(Token::CloseBracket, "a closing bracket ]")?;
        self.expect_word("OF")?;
        if self.at_word("ARRAY") {
            return Err(self.unsupported(self.token.1, "an array of arrays"));
        }
        let of = self.name("the type of the elements")?;
        Ok(TypeRef::Array { ranges, of, at: at.to(self.last) })
    }

    fn initial(&mut self) -> Parsed<Initial> {
        let open = self.token.1;
        if self.is(Token::Open) && self.next.0 == Token::Word {
            // `(IN := TRUE)` gives values to the members of a block or structure.
            let text_behind = self.text.get(self.next.1.end as usize..).unwrap_or("").trim_start();
            if text_behind.starts_with(":=") {
                return Err(self.unsupported(open, "an initial value for members"));
            }
        }
        if !self.accept(Token::OpenBracket) {
            return Ok(Initial::One(self.expression()?));
        }
        let mut list = Vec::new();
        if !self.is(Token::CloseBracket) {
            loop {
                list.push(self.repeated()?);
                if !self.accept(Token::Comma) {
                    break;
                }
            }
        }
        let end = self.expect(Token::CloseBracket, "a comma or a closing bracket ]")?;
        Ok(Initial::List(list, open.to(end)))
    }

    /// `5`, or `10(5)` for ten times.
    fn repeated(&mut self) -> Parsed<(Option<super::ast::Expr>, super::ast::Expr)> {
        let value = self.expression()?;
        if !self.accept(Token::Open) {
            return Ok((None, value));
        }
        let repeated = self.expression()?;
        self.expect(Token::Close, "a closing bracket )")?;
        Ok((Some(value), repeated))
    }
}
