//! Variables: sections of units, members of structures and unions.

use super::ast::{Name, Section, SectionKind, VarDecl};
use super::lexer::Token;
use super::words::Word;
use super::{Parsed, Parser};
use crate::codes::Code;
use crate::findings::SourcePlace;
use crate::program::Retention;

/// The text of an address and its place.
type Address = (Box<str>, SourcePlace);

/// Bytes of a declaration times its names: the type is copied for each.
const MOST_COPIED: usize = 1 << 22;

impl Parser<'_, '_, '_> {
    /// VAR .. END_VAR. `None` where what it holds was reported and skipped.
    pub(super) fn section(&mut self) -> Parsed<Option<Section>> {
        let at = self.at();
        let kind = match self.word() {
            Some(Word::Var) => SectionKind::Local,
            Some(Word::VarInput) => SectionKind::Input,
            Some(Word::VarOutput) => SectionKind::Output,
            Some(Word::VarInOut) => SectionKind::InOut,
            Some(Word::VarTemp) => SectionKind::Temp,
            Some(Word::VarStat) => SectionKind::Static,
            Some(Word::VarInst) => SectionKind::Instance,
            Some(Word::VarGlobal) => SectionKind::Global,
            Some(Word::VarExternal) => SectionKind::External,
            Some(word @ (Word::VarAccess | Word::VarConfig)) => {
                let help = "write the addresses and initial values where the variables are declared";
                self.unsupported(at, word.text(), help);
                self.skip_past(Word::EndVar, at);
                return Ok(None);
            }
            _ => return Err(self.unexpected("VAR, VAR_INPUT, VAR_OUTPUT or another section of variables")),
        };
        self.advance();
        let mut section =
            Section { kind, retention: Retention::None, constant: false, variables: Vec::new(), at };
        self.section_words(&mut section);
        section.variables = self.members(Word::EndVar, at)?;
        self.check_words(&section);
        Ok(Some(section))
    }

    /// Reports edges and arguments of FB_Init where they mean nothing.
    fn check_words(&mut self, section: &Section) {
        use SectionKind::{Global, Input, Instance, Local, Static, Temp};
        for decl in &section.variables {
            if let Some((_, at)) = decl.edge.filter(|_| section.kind != Input) {
                let message = "only inputs detect edges";
                self.error(Code::Section, at, message, "declare an R_TRIG or F_TRIG and call it");
            }
            if let Some(built) = &decl.built
                && !matches!(section.kind, Local | Temp | Static | Instance | Global)
            {
                let message = "the instance is made elsewhere";
                self.error(Code::Section, built.at, message, "declare it in VAR or VAR_GLOBAL");
            }
        }
    }

    /// CONSTANT, RETAIN and the like, in any order. Who may see the variables is not restricted here.
    fn section_words(&mut self, section: &mut Section) {
        let (mut retain, mut forgets) = (false, None);
        loop {
            match self.word() {
                Some(Word::Constant) => section.constant = true,
                Some(Word::Retain) => {
                    retain = true;
                    section.retention = section.retention.max(Retention::Retain);
                }
                Some(Word::Persistent) => {
                    retain = true;
                    section.retention = Retention::Persistent;
                }
                Some(Word::NonRetain) => forgets = Some(self.at()),
                Some(Word::Public | Word::Private | Word::Protected | Word::Internal)
                    if self.ahead(1).token == Token::Word && self.ahead(1).key != Word::At.key() => {}
                _ => break,
            }
            self.advance();
        }
        if let Some(at) = forgets.filter(|_| retain) {
            let message = "a section cannot be RETAIN and NON_RETAIN at once";
            self.error(Code::Section, at, message, "remove one of the words");
        }
    }

    /// Declarations up to `close`, which is taken. Where it seems to be missing it is reported.
    pub(super) fn members(&mut self, close: Word, open: SourcePlace) -> Parsed<Vec<VarDecl>> {
        let mut list = Vec::new();
        while !self.accept_word(close) {
            if self.accept(Token::Semicolon) {
                continue;
            }
            match self.word() {
                Some(word @ (Word::EndStruct | Word::EndUnion)) if close == Word::EndVar => {
                    self.stray(word);
                    continue;
                }
                _ => {}
            }
            let start = self.at();
            let ended = self.is(Token::End)
                || self.ends_members()
                // Inside a structure there are no statements for which END_STRUCT could be missing.
                || close == Word::EndVar && self.at_statement();
            if ended || self.variables(close, &mut list).is_err() && !self.recover_in_members(close, start) {
                let reported = self.unclosed(close, open);
                return if close == Word::EndVar { Ok(list) } else { Err(reported) };
            }
        }
        Ok(list)
    }

    /// Whether an assignment or a call starts here: then the variables were not closed.
    fn at_statement(&self) -> bool {
        let goes_on =
            matches!(self.ahead(1).token, Token::Assign | Token::Open | Token::OpenBracket | Token::Dot);
        self.is(Token::Word) && goes_on
    }

    /// Whether what is here cannot stand between variables.
    fn ends_members(&self) -> bool {
        self.word().is_some_and(|word| {
            let unit = word.opens_declaration() || word.closes_declaration() || word.closes_elsewhere();
            // `TYPE : INT` is a name that is not free, `VAR` in a section is one that was not closed.
            let named = matches!(self.ahead(1).token, Token::Colon | Token::Comma);
            (unit || word.opens_statements() || word.belongs_to_statement()) && !named
        })
    }

    /// After the next semicolon or before `close`, past whole structures; FALSE where the variables seem to have
    /// ended.
    fn recover_in_members(&mut self, close: Word, start: SourcePlace) -> bool {
        if self.at() == start && !self.at_word(close) {
            self.advance();
        }
        let mut depth = 0usize;
        loop {
            match self.word() {
                Some(word) if word == close && (depth == 0 || close == Word::EndVar) => return true,
                Some(Word::Struct | Word::Union) => depth += 1,
                Some(Word::EndStruct | Word::EndUnion) if depth > 0 || close == Word::EndVar => {
                    depth = depth.saturating_sub(1);
                }
                _ if self.is(Token::End) || self.ends_members() => return false,
                _ if depth == 0 && self.accept(Token::Semicolon) => return true,
                _ => {}
            }
            self.advance();
        }
    }

    /// `a, b AT %MW1 : INT := 5;`
    fn variables(&mut self, close: Word, list: &mut Vec<VarDecl>) -> Parsed<()> {
        let start = self.at();
        let mut names: Vec<(Name, Option<Address>)> = Vec::new();
        loop {
            let what = match close {
                Word::EndStruct | Word::EndUnion => "the name of a member or the end of the structure",
                _ => "the name of a variable or END_VAR",
            };
            if self.at_word(Word::At) && !self.next_is(Token::Colon) {
                let help = "write a name before AT, or use the address where it is needed";
                return Err(self.unsupported(self.at(), "an address without a name", help));
            }
            let name = self.new_name(what)?;
            names.push((name, self.address(close)?));
            if !self.accept(Token::Comma) {
                break;
            }
        }
        self.expect(Token::Colon, "a colon and a type")?;
        // Structures and what pointers lead to are built nowhere.
        let plain = matches!(self.tok.token, Token::Word) && !self.at_word(Word::Struct);
        let outer = std::mem::replace(&mut self.builds, plain && close == Word::EndVar);
        let ty = self.type_ref();
        self.builds = outer;
        let (ty, built) = (ty?, self.built.take());
        let edge = self.at_edge().then(|| (self.at_word(Word::FEdge), self.at()));
        if close != Word::EndVar && self.at_edge() {
            let help = "declare it as an input of a FUNCTION_BLOCK";
            return Err(self.unsupported(self.at(), "a member that detects edges", help));
        }
        if edge.is_some() {
            self.advance();
        }
        let initial = self.initial_of(&ty)?;
        self.semicolon()?;
        let length = self.last.end.saturating_sub(start.start) as usize;
        if length.saturating_mul(names.len().saturating_sub(1)) > MOST_COPIED {
            let message = "a long declaration for too many names";
            let help = "declare the type under a name of its own, in a TYPE block";
            return Err(self.error(Code::SourceSize, start, message, help));
        }
        let last = names.pop();
        list.extend(names.into_iter().map(|(name, address)| VarDecl {
            name,
            address,
            ty: ty.clone(),
            built: built.clone(),
            edge,
            initial: initial.clone(),
        }));
        list.extend(last.map(|(name, address)| VarDecl { name, address, ty, built, edge, initial }));
        Ok(())
    }

    /// `AT %MW10` after the name of a variable.
    fn address(&mut self, close: Word) -> Parsed<Option<Address>> {
        if !self.at_word(Word::At) {
            return Ok(None);
        }
        let word = self.at();
        self.advance();
        let at = self.expect(Token::Address, "an address such as %MW10")?;
        let text = self.slice(at);
        if close != Word::EndVar {
            self.unsupported(word, "an address for a member", "give one to a variable of the structure");
            return Ok(None);
        }
        if text.contains('*') {
            let message = format!("`{text}` is an address that is completed elsewhere");
            let help = "the variable is connected to nothing here; write the whole address to connect it";
            self.findings.warning(Code::Unconnected, at, message, help);
            return Ok(None);
        }
        Ok(Some((text.into(), at)))
    }
}
