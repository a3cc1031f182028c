//! Types where they are used, and the TYPE block.

use super::ast::{Built, Expr, SourceUnit, TypeDecl, TypeKind, TypeRef};
use super::lexer::Token;
use super::words::Word;
use super::{Parsed, Parser};
use crate::findings::SourcePlace;
use crate::types::Elementary;

/// What a subrange and the values of an enumeration share with the arguments of a constructor.
const CONSTRUCTOR: &str = "a constructor with parameters";
const CONSTRUCTOR_HELP: &str = "give initial values to the inputs, as in t : TON := (PT := T#1s)";

impl Parser<'_, '_, '_> {
    /// TYPE .. END_TYPE with any number of names.
    pub(super) fn type_block(&mut self, unit: &mut SourceUnit) -> Parsed<()> {
        let open = self.expect_word(Word::Type)?;
        while !self.accept_word(Word::EndType) {
            if self.accept(Token::Semicolon) {
                continue;
            }
            let start = self.at();
            if self.is(Token::End) || self.word().is_some_and(|word| word.opens_declaration()) {
                self.unclosed(Word::EndType, open);
                return Ok(());
            }
            match self.type_declaration() {
                Ok(declaration) => unit.types.push(declaration),
                Err(_) => self.recover_in_types(start),
            }
        }
        Ok(())
    }

    /// After the declaration that could not be read, with the members of its structure.
    fn recover_in_types(&mut self, start: SourcePlace) {
        if self.at() == start && !self.at_word(Word::EndType) {
            self.advance();
        }
        loop {
            let word = self.word();
            if self.is(Token::End)
                || word == Some(Word::EndType)
                || word.is_some_and(|word| word.opens_declaration())
            {
                return;
            }
            let semicolon = self.is(Token::Semicolon);
            self.advance();
            match word {
                Some(Word::EndStruct | Word::EndUnion) => return,
                None if semicolon => match self.end_of_members() {
                    Some(place) => self.go(place),
                    None => return,
                },
                _ => {}
            }
        }
    }

    /// The END_STRUCT or END_UNION of a structure whose inside is here.
    fn end_of_members(&self) -> Option<usize> {
        let mut depth = 0usize;
        for n in 0.. {
            let tok = self.ahead(n);
            match Word::of(tok.key) {
                Some(Word::Struct | Word::Union) => depth += 1,
                Some(Word::EndStruct | Word::EndUnion) if depth == 0 => return Some(self.place + n),
                Some(Word::EndStruct | Word::EndUnion) => depth -= 1,
                Some(Word::EndType) => return None,
                _ if tok.token == Token::End => return None,
                _ => {}
            }
        }
        None
    }

    fn type_declaration(&mut self) -> Parsed<TypeDecl> {
        let access = self.at_word(Word::Public) || self.at_word(Word::Internal);
        if access && self.ahead(1).is_name() {
            self.advance();
        }
        let name = self.new_name("the name of a type or END_TYPE")?;
        let extends = if self.accept_word(Word::Extends) {
            Some(self.path_name("the name of a structure")?)
        } else {
            None
        };
        self.expect(Token::Colon, "a colon and a type")?;
        let mut ty = self.type_ref()?;
        match (&mut ty.kind, extends) {
            (TypeKind::Struct { extends, .. }, base) => *extends = base,
            (_, Some(base)) => {
                let message = "only a structure extends another";
                let help = "write STRUCT after the colon, or remove EXTENDS";
                return Err(self.error(crate::codes::Code::Section, base.at, message, help));
            }
            (_, None) => {}
        }
        let initial = self.initial_of(&ty)?;
        let closed = matches!(ty.kind, TypeKind::Struct { .. } | TypeKind::Union { .. }) && initial.is_none();
        if !closed || self.is(Token::Semicolon) {
            self.semicolon()?;
        }
        Ok(TypeDecl { name, ty, initial })
    }

    pub(super) fn type_ref(&mut self) -> Parsed<TypeRef> {
        let at = self.at();
        let kind = self.nested(Self::type_kind)?;
        Ok(TypeRef { kind, at: at.to(self.last) })
    }

    fn type_kind(&mut self) -> Parsed<TypeKind> {
        let open = self.at();
        match self.word() {
            Some(Word::Array) => self.array(),
            Some(Word::Pointer) => {
                self.advance();
                self.expect_word(Word::To)?;
                Ok(TypeKind::Pointer(Box::new(self.type_ref()?)))
            }
            Some(Word::RefTo) => {
                self.advance();
                Ok(TypeKind::RefTo(Box::new(self.type_ref()?)))
            }
            Some(Word::Reference) if self.ahead(1).key == Word::To.key() => {
                self.advance();
                self.advance();
                Ok(TypeKind::Reference(Box::new(self.type_ref()?)))
            }
            Some(word @ (Word::String | Word::Wstring)) => {
                self.advance();
                let wide = word == Word::Wstring;
                let close = match self.tok.token {
                    Token::Open => Token::Close,
                    Token::OpenBracket => Token::CloseBracket,
                    _ => return Ok(TypeKind::Text { wide, length: None }),
                };
                self.advance();
                let length = self.expression()?;
                self.expect(close, "a closing bracket after the length")?;
                Ok(TypeKind::Text { wide, length: Some(Box::new(length)) })
            }
            Some(Word::Struct) => {
                self.advance();
                if self.at_word(Word::Overlap) && !self.next_is(Token::Colon) && !self.next_is(Token::Comma) {
                    let at = self.at();
                    self.unsupported(at, "OVERLAP", "use a UNION for members that share their place");
                    self.advance();
                }
                Ok(TypeKind::Struct { extends: None, members: self.members(Word::EndStruct, open)? })
            }
            Some(Word::Union) => {
                self.advance();
                Ok(TypeKind::Union { members: self.members(Word::EndUnion, open)? })
            }
            _ if self.is(Token::Open) => self.enumeration(),
            _ => self.named_type(),
        }
    }

    /// `ARRAY[1..3, 0..n] OF INT`, `ARRAY[*] OF INT`.
    fn array(&mut self) -> Parsed<TypeKind> {
        self.advance();
        self.expect(Token::OpenBracket, "an opening bracket [")?;
        let mut ranges = Vec::new();
        loop {
            if self.accept(Token::Star) {
                ranges.push(None);
            } else {
                let low = self.expression()?;
                self.expect(Token::Range, "..")?;
                ranges.push(Some((low, self.expression()?)));
            }
            if !self.accept(Token::Comma) {
                break;
            }
        }
        self.expect(Token::CloseBracket, "a comma or a closing bracket ]")?;
        self.expect_word(Word::Of)?;
        Ok(TypeKind::Array { ranges, of: Box::new(self.type_ref()?) })
    }

    /// `(red, green := 5) UINT`.
    fn enumeration(&mut self) -> Parsed<TypeKind> {
        let values = self.enumerators()?;
        // Any other word belongs to what follows the type.
        let elementary = self.at_name() && Elementary::named(self.names.key_text(self.tok.key)).is_some();
        let base = if elementary { Some(self.name("a type")?) } else { None };
        Ok(TypeKind::Enumeration { values, base })
    }

    fn enumerators(&mut self) -> Parsed<Vec<(super::ast::Name, Option<Expr>)>> {
        self.expect(Token::Open, "an opening bracket (")?;
        let mut values = Vec::new();
        loop {
            let name = self.new_name("the name of a value")?;
            let value = if self.accept(Token::Assign) { Some(self.expression()?) } else { None };
            values.push((name, value));
            if !self.accept(Token::Comma) {
                break;
            }
        }
        self.expect(Token::Close, "a comma or a closing bracket )")?;
        Ok(values)
    }

    /// A name of a type, with a subrange or the values of an enumeration after it.
    fn named_type(&mut self) -> Parsed<TypeKind> {
        let base = self.path_name("a type")?;
        if self.builds && self.is(Token::OpenBracket) && self.next_is(Token::Open) {
            self.built = Some(self.built_each()?);
            return Ok(TypeKind::Named(base));
        }
        if !self.is(Token::Open) {
            return Ok(TypeKind::Named(base));
        }
        let elementary = Elementary::named(self.names.key_text(base.key)).is_some();
        let value_ahead = self.ahead(1).token == Token::Word
            && matches!(self.ahead(2).token, Token::Comma | Token::Close | Token::Assign);
        if elementary && value_ahead {
            return Ok(TypeKind::Enumeration { values: self.enumerators()?, base: Some(base) });
        }
        let open = self.at();
        let constructor = self.next_is(Token::Close)
            || !elementary && self.ahead(2).token == Token::Assign
            || !elementary && !self.range_ahead();
        if constructor && self.builds {
            let lists = vec![self.arguments()?];
            self.built = Some(Built { each: false, lists, at: open.to(self.last) });
            return Ok(TypeKind::Named(base));
        }
        if constructor {
            self.unsupported(open, CONSTRUCTOR, CONSTRUCTOR_HELP);
            self.skip_brackets();
            return Ok(TypeKind::Named(base));
        }
        self.advance();
        let low = Box::new(self.expression()?);
        self.expect(Token::Range, "..")?;
        let high = Box::new(self.expression()?);
        self.expect(Token::Close, "a closing bracket )")?;
        Ok(TypeKind::Subrange { base, low, high })
    }

    /// `[(level := 1), (level := 2)]` after the block of an array.
    fn built_each(&mut self) -> Parsed<Built> {
        let open = self.at();
        self.advance();
        let mut lists = Vec::new();
        loop {
            lists.push(self.arguments()?);
            if !self.accept(Token::Comma) {
                break;
            }
        }
        let end = self.expect(Token::CloseBracket, "a comma or a closing bracket ]")?;
        Ok(Built { each: true, lists, at: open.to(end) })
    }

    /// Whether `..` stands in the bracket that opens here.
    fn range_ahead(&self) -> bool {
        let mut depth = 0usize;
        for n in 0.. {
            match self.ahead(n).token {
                Token::Open | Token::OpenBracket => depth += 1,
                Token::Close | Token::CloseBracket if depth <= 1 => return false,
                Token::Close | Token::CloseBracket => depth -= 1,
                Token::Range if depth == 1 => return true,
                Token::End | Token::Semicolon => return false,
                _ => {}
            }
        }
        false
    }

    /// R_EDGE or F_EDGE after a type.
    pub(super) fn at_edge(&self) -> bool {
        self.at_word(Word::REdge) || self.at_word(Word::FEdge)
    }
}
