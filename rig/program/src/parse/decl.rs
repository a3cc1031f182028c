//! Units and what they hold: methods, properties, actions.

use super::ast::{
    Accessor, Action, InterfaceDecl, Method, Modifiers, Name, Pou, PouKind, Property, Section, SourceUnit,
    Stmt,
};
use super::lexer::Token;
use super::words::Word;
use super::{AlreadyReported, Parsed, Parser};
use crate::codes::Code;
use crate::findings::SourcePlace;

impl Parser<'_, '_, '_> {
    pub(super) fn declarations(&mut self, unit: &mut SourceUnit) {
        let first = unit.pous.len();
        while !self.is(Token::End) {
            let start = self.at();
            if self.declaration(unit, first).is_err() {
                self.skip_to_declaration(start);
            }
        }
    }

    /// `first`: place of the first unit of this source.
    fn declaration(&mut self, unit: &mut SourceUnit, first: usize) -> Parsed<()> {
        let kind = match self.word() {
            Some(Word::Program) => PouKind::Program,
            Some(Word::Function) => PouKind::Function,
            Some(Word::FunctionBlock) => PouKind::FunctionBlock,
            Some(Word::Type) => return self.type_block(unit),
            Some(Word::Interface) => {
                let interface = self.interface()?;
                unit.interfaces.push(interface);
                return Ok(());
            }
            Some(Word::Configuration) => {
                let configuration = self.configuration()?;
                unit.configurations.push(configuration);
                return Ok(());
            }
            Some(Word::VarGlobal | Word::VarAccess | Word::VarConfig) => {
                unit.globals.extend(self.section()?);
                return Ok(());
            }
            Some(Word::Method | Word::Property | Word::Action) => {
                // Some tools write what belongs to a unit after it.
                let Some(pou) = unit.pous.get_mut(first..).and_then(<[Pou]>::last_mut) else {
                    let message = format!("{} stands outside of a FUNCTION_BLOCK", self.found());
                    let help = "move it before END_FUNCTION_BLOCK of its block";
                    return Err(self.error(Code::Section, self.at(), message, help));
                };
                return self.part(pou);
            }
            _ if self.accept(Token::Semicolon) => return Ok(()),
            _ => return self.refused_declaration(),
        };
        let pou = self.pou(kind)?;
        unit.pous.push(pou);
        Ok(())
    }

    /// To the next word that starts a unit at the outside; inside a unit these words do not occur.
    fn skip_to_declaration(&mut self, start: SourcePlace) {
        if self.at() == start {
            self.advance();
        }
        while !self.is(Token::End) {
            let starts = matches!(
                self.word(),
                Some(
                    Word::Program
                        | Word::Function
                        | Word::FunctionBlock
                        | Word::Interface
                        | Word::Type
                        | Word::Configuration
                        | Word::VarGlobal
                )
            );
            if starts {
                return;
            }
            self.advance();
        }
    }

    /// PUBLIC, ABSTRACT and the like before a name.
    fn modifiers(&mut self) -> Modifiers {
        let mut modifiers = Modifiers::default();
        let mut access = None;
        while self.ahead(1).is_name() {
            let word = self.word();
            match word {
                Some(Word::Private) => modifiers.private = true,
                Some(Word::Protected) => modifiers.protected = true,
                Some(Word::Abstract) => modifiers.is_abstract = true,
                Some(Word::Final) => modifiers.is_final = true,
                Some(Word::Override) => modifiers.is_override = true,
                Some(Word::Public | Word::Internal) => {}
                _ => break,
            }
            let is_access =
                matches!(word, Some(Word::Private | Word::Protected | Word::Public | Word::Internal));
            if is_access && access.replace(word).is_some_and(|before| before != word) {
                let message = "two words say who may use this";
                self.error(
                    Code::Section,
                    self.at(),
                    message,
                    "keep one of PUBLIC, PROTECTED, PRIVATE, INTERNAL",
                );
            }
            self.advance();
        }
        modifiers
    }

    fn pou(&mut self, kind: PouKind) -> Parsed<Pou> {
        let open = self.at();
        self.advance();
        let words = self.at();
        let modifiers = self.modifiers();
        if kind != PouKind::FunctionBlock
            && (modifiers.is_abstract || modifiers.is_final || modifiers.is_override)
        {
            let message = format!("a {} is never ABSTRACT, FINAL or OVERRIDE", kind.keyword());
            self.error(Code::Section, words, message, "remove the word");
        }
        let name = self.new_name("a name")?;
        let (extends, implements, result) = match kind {
            PouKind::FunctionBlock => (self.extends()?, self.implements()?, None),
            PouKind::Function if self.accept(Token::Colon) => (None, Vec::new(), Some(self.type_ref()?)),
            _ => (None, Vec::new(), None),
        };
        let mut pou = Pou {
            kind,
            name,
            modifiers,
            extends,
            implements,
            result,
            sections: Vec::new(),
            methods: Vec::new(),
            properties: Vec::new(),
            actions: Vec::new(),
            body: Vec::new(),
            end: open,
        };
        let close = match kind {
            PouKind::Program => Word::EndProgram,
            PouKind::Function => Word::EndFunction,
            PouKind::FunctionBlock => Word::EndFunctionBlock,
        };
        while !self.accept_word(close) {
            if self.is(Token::End) || !self.inside_pou(&mut pou)? {
                self.unclosed(close, open);
                // What closes another kind of unit is meant for this one.
                let other = matches!(
                    self.word(),
                    Some(Word::EndProgram | Word::EndFunction | Word::EndFunctionBlock)
                );
                if other {
                    self.advance();
                }
                break;
            }
        }
        pou.end = self.last;
        Ok(pou)
    }

    /// One section, method or run of statements; FALSE where the unit ends.
    fn inside_pou(&mut self, pou: &mut Pou) -> Parsed<bool> {
        match self.word() {
            Some(Word::Method | Word::Property | Word::Action) => {
                let start = self.at();
                if self.part(pou).is_err() {
                    self.skip_part(start);
                }
            }
            Some(Word::VarGlobal) if !pou.body.is_empty() => return Ok(false),
            Some(word) if word.opens_section() => {
                if !pou.body.is_empty() {
                    let message = "variables are declared before the statements";
                    self.error(Code::Section, self.at(), message, "move the section to the head of the unit");
                }
                pou.sections.extend(self.section()?);
            }
            Some(word) if word.opens_declaration() => return Ok(false),
            Some(Word::EndProgram | Word::EndFunction | Word::EndFunctionBlock) => return Ok(false),
            Some(word) if word.closes_declaration() => self.stray(word),
            _ => self.body(&mut pou.body),
        }
        Ok(true)
    }

    /// Statements of a body, with the loops of no other body around them.
    fn body(&mut self, body: &mut Vec<Stmt>) {
        let open = std::mem::take(&mut self.open);
        body.append(&mut self.statements(false));
        self.open = open;
    }

    /// What closes nothing.
    pub(super) fn stray(&mut self, word: Word) {
        if !self.silent() {
            let message = format!("{} closes nothing here", word.text());
            self.error(Code::Unclosed, self.at(), message, "remove it, or write what it closes");
        }
        self.advance();
        self.accept(Token::Semicolon);
    }

    fn extends(&mut self) -> Parsed<Option<Name>> {
        if self.accept_word(Word::Extends) {
            Ok(Some(self.path_name("the name of a block")?))
        } else {
            Ok(None)
        }
    }

    fn implements(&mut self) -> Parsed<Vec<Name>> {
        if self.accept_word(Word::Implements) { self.interface_names() } else { Ok(Vec::new()) }
    }

    fn interface_names(&mut self) -> Parsed<Vec<Name>> {
        let mut names = vec![self.path_name("the name of an interface")?];
        while self.accept(Token::Comma) {
            names.push(self.path_name("the name of an interface")?);
        }
        Ok(names)
    }

    /// METHOD, PROPERTY or ACTION.
    fn part(&mut self, pou: &mut Pou) -> Parsed<()> {
        let at = self.at();
        let word = self.word();
        if pou.kind == PouKind::Function {
            let message = format!("{} cannot be in a FUNCTION", word.map_or("", Word::text));
            self.error(Code::Section, at, message, "move it into a FUNCTION_BLOCK");
        }
        match word {
            Some(Word::Method) => pou.methods.push(self.method()?),
            Some(Word::Property) => pou.properties.push(self.property()?),
            _ => pou.actions.push(self.action()?),
        }
        Ok(())
    }

    /// After the end of a broken method, property or action, or before the next.
    fn skip_part(&mut self, start: SourcePlace) {
        if self.at() == start {
            self.advance();
        }
        while !self.is(Token::End) {
            let word = self.word();
            if matches!(word, Some(Word::EndMethod | Word::EndProperty | Word::EndAction)) {
                self.advance();
                return;
            }
            if word.is_some_and(|word| !word.opens_section() && word.opens_declaration())
                || matches!(
                    word,
                    Some(Word::EndProgram | Word::EndFunction | Word::EndFunctionBlock | Word::EndInterface)
                )
            {
                return;
            }
            self.advance();
        }
    }

    fn method(&mut self) -> Parsed<Method> {
        let open = self.expect_word(Word::Method)?;
        let modifiers = self.modifiers();
        let name = self.new_name("the name of a method")?;
        let result = if self.accept(Token::Colon) { Some(self.type_ref()?) } else { None };
        let (sections, body) = self.sections_and_body()?;
        let end = self.close_part(Word::EndMethod, open)?;
        Ok(Method { name, modifiers, result, sections, body, end })
    }

    fn sections_and_body(&mut self) -> Parsed<(Vec<Section>, Vec<Stmt>)> {
        let (mut sections, mut body) = (Vec::new(), Vec::new());
        loop {
            while self.accept(Token::Semicolon) {}
            if !self.word().is_some_and(Word::opens_section) {
                break;
            }
            sections.extend(self.section()?);
        }
        self.body(&mut body);
        Ok((sections, body))
    }

    fn close_part(&mut self, close: Word, open: SourcePlace) -> Parsed<SourcePlace> {
        if self.accept_word(close) { Ok(self.last) } else { Err(self.unclosed(close, open)) }
    }

    fn property(&mut self) -> Parsed<Property> {
        let open = self.expect_word(Word::Property)?;
        let modifiers = self.modifiers();
        let name = self.new_name("the name of a property")?;
        self.expect(Token::Colon, "a colon and the type of the property")?;
        let ty = self.type_ref()?;
        let mut property = Property { name, modifiers, ty, get: None, set: None };
        loop {
            let (accessor, close) = match self.word() {
                Some(Word::Get) => (&mut property.get, Word::EndGet),
                Some(Word::Set) => (&mut property.set, Word::EndSet),
                Some(Word::EndProperty) => break,
                _ if self.accept(Token::Semicolon) => continue,
                _ => return Err(self.unclosed(Word::EndProperty, open)),
            };
            let at = self.at();
            if accessor.is_some() {
                let message = format!("the property has a second {}", self.found());
                self.error(Code::Duplicate, at, message, "remove one of them");
            }
            self.advance();
            let (sections, body) = self.sections_and_body()?;
            let end = self.close_part(close, at)?;
            *accessor = Some(Accessor { sections, body, end });
        }
        self.advance();
        Ok(property)
    }

    fn action(&mut self) -> Parsed<Action> {
        let open = self.expect_word(Word::Action)?;
        let name = self.new_name("the name of an action")?;
        self.accept(Token::Colon);
        let mut body = Vec::new();
        self.body(&mut body);
        let end = self.close_part(Word::EndAction, open)?;
        Ok(Action { name, body, end })
    }

    fn interface(&mut self) -> Parsed<InterfaceDecl> {
        let open = self.expect_word(Word::Interface)?;
        self.modifiers();
        let name = self.new_name("the name of an interface")?;
        let extends = if self.accept_word(Word::Extends) { self.interface_names()? } else { Vec::new() };
        let mut interface = InterfaceDecl { name, extends, methods: Vec::new(), properties: Vec::new() };
        while !self.accept_word(Word::EndInterface) {
            let start = self.at();
            let read = match self.word() {
                Some(Word::Method) => self.method().map(|method| {
                    self.no_body(&method.body);
                    interface.methods.push(method);
                }),
                Some(Word::Property) => self.property().map(|property| {
                    for accessor in [&property.get, &property.set].into_iter().flatten() {
                        self.no_body(&accessor.body);
                    }
                    interface.properties.push(property);
                }),
                _ if self.accept(Token::Semicolon) => Ok(()),
                _ if self.is(Token::End) => Err(self.unclosed(Word::EndInterface, open)),
                Some(word) if word.opens_declaration() || word.closes_declaration() => {
                    self.unclosed(Word::EndInterface, open);
                    return Ok(interface);
                }
                _ => Err(self.unexpected("METHOD, PROPERTY or END_INTERFACE")),
            };
            if let Err(AlreadyReported) = read {
                if self.is(Token::End) {
                    return Err(AlreadyReported);
                }
                self.skip_part(start);
            }
        }
        Ok(interface)
    }

    /// What an interface declares has no statements.
    fn no_body(&mut self, body: &[Stmt]) {
        if let Some(first) = body.first() {
            let help = "move the statements into the blocks that implement the interface";
            self.error(Code::Section, first.at, "an interface has no statements", help);
        }
    }
}
