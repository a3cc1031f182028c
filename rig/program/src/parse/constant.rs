//! Literals in expressions, alone and with a type before them.

use super::ast::{Expr, ExprKind, Name};
use super::lexer::Token;
use super::literal::SourceLiteralFault;
use super::words::Word;
use super::{AlreadyReported, Parsed, Parser, literal, moment};
use crate::codes::Code;
use crate::findings::SourcePlace;
use crate::types::Elementary;

impl Parser<'_, '_, '_> {
    /// What the present token says by itself, which is not taken.
    pub(super) fn untyped_literal(&mut self) -> Option<ExprKind> {
        let at = self.at();
        let text = self.slice(at);
        Some(match self.tok.token {
            Token::Integer | Token::Based => {
                self.literal(Code::Number, at, literal::number(text), |n| ExprKind::Number(n, None))
            }
            Token::Real => {
                self.literal(Code::Number, at, literal::real(text), |(d, s)| ExprKind::Real(d, s, None))
            }
            Token::Duration => {
                let read = moment::duration(text);
                self.literal(Code::Duration, at, read, |(cell, ty)| ExprKind::Moment(cell, ty))
            }
            Token::Date => {
                let read = moment::date(text);
                self.literal(Code::Date, at, read, |(cell, ty)| ExprKind::Moment(cell, ty))
            }
            Token::Text => self.literal(Code::Text, at, literal::text(text), |(wide, units)| {
                ExprKind::Text { wide, units, typed: None }
            }),
            _ => return None,
        })
    }

    fn literal<T>(
        &mut self,
        code: Code,
        at: SourcePlace,
        read: Result<T, SourceLiteralFault>,
        kind: impl FnOnce(T) -> ExprKind,
    ) -> ExprKind {
        match read {
            Ok(value) => kind(value),
            Err(fault) => {
                let (message, help) = fault.text();
                self.error(code, at, message, help);
                ExprKind::Wrong
            }
        }
    }

    /// `INT#5`, `WORD#16#FF`, `BOOL#1`, `STRING#'a'`; `colour#red`.
    pub(super) fn typed(&mut self) -> Parsed<Expr> {
        let start = self.at();
        let prefix = self.tok.prefix;
        self.advance();
        let named = Elementary::named(self.names.key_text(prefix));
        let kind = match (self.tok.token, named) {
            (Token::Text, _) => self.typed_text(start, named, prefix == Word::Wstring.key())?,
            (Token::Word, Some(Elementary::Bool))
                if self.at_word(Word::True) || self.at_word(Word::False) =>
            {
                let value = self.at_word(Word::True);
                self.advance();
                ExprKind::Bool(value)
            }
            (Token::Word, None) => {
                let at = SourcePlace { end: start.end - 1, ..start };
                ExprKind::Qualified(Name { key: prefix, at }, self.name("the name of a value")?)
            }
            (_, Some(ty)) => self.typed_number(start, ty)?,
            _ => {
                let message = format!("`{}` is no elementary type", self.slice(start).trim_end_matches('#'));
                return Err(self.error(
                    Code::UnknownType,
                    start,
                    message,
                    "write a type before #, as in INT#5",
                ));
            }
        };
        Ok(Expr { kind, at: start.to(self.last) })
    }

    fn typed_text(
        &mut self,
        start: SourcePlace,
        named: Option<Elementary>,
        wstring: bool,
    ) -> Parsed<ExprKind> {
        let at = self.at();
        let read = literal::text(self.slice(at));
        self.advance();
        let is_string = self.slice(start).eq_ignore_ascii_case("STRING#");
        let wide_type = wstring || named == Some(Elementary::Wchar);
        let typed = named.filter(|ty| ty.is_char());
        if typed.is_none() && !wstring && !is_string {
            let message = format!("`{}` is no type of texts", self.slice(start).trim_end_matches('#'));
            return Err(self.error(Code::Text, start, message, "use STRING#, WSTRING#, CHAR# or WCHAR#"));
        }
        if read.as_ref().is_ok_and(|(wide, _)| *wide != wide_type) {
            let (message, help) = match wide_type {
                true => ("wide texts stand in double quotation marks", "write it as in WSTRING#\"text\""),
                false => {
                    ("texts of this type stand in single quotation marks", "write it as in STRING#'text'")
                }
            };
            return Err(self.error(Code::Text, at, message, help));
        }
        let read = match (read, typed) {
            (Ok((_, units)), Some(_)) if units.len() != 1 => Err(SourceLiteralFault::OneCharacter),
            (read, _) => read,
        };
        Ok(self.literal(Code::Text, at, read, |(wide, units)| ExprKind::Text { wide, units, typed }))
    }

    /// After `INT#` and the like: a number with or without a sign.
    fn typed_number(&mut self, start: SourcePlace, ty: Elementary) -> Parsed<ExprKind> {
        let negative = self.accept(Token::Minus);
        if !negative {
            self.accept(Token::Plus);
        }
        let (token, text) = (self.tok.token, self.slice(self.at()));
        if !matches!(token, Token::Integer | Token::Based | Token::Real) {
            return Err(self.unexpected("a number"));
        }
        self.advance();
        let at = start.to(self.last);
        let sign = if negative { -1 } else { 1 };
        if ty.is_real() && token != Token::Based {
            let sign = f64::from(sign);
            return Ok(self.literal(Code::Number, at, literal::real(text), |(double, single)| {
                ExprKind::Real(sign * double, sign as f32 * single, Some(ty))
            }));
        }
        let whole = ty.is_integer() || ty == Elementary::Bool;
        if !whole || token == Token::Real {
            let message = format!("{} has no such literal", ty.name());
            let help =
                "whole numbers go after types of whole numbers, numbers with a point after REAL# and LREAL#";
            return Err(self.error(Code::Number, at, message, help));
        }
        let read = literal::number(text);
        if ty == Elementary::Bool {
            if negative || !matches!(read, Ok(0 | 1)) {
                self.error(Code::Number, at, "BOOL is 0 or 1", "write BOOL#0 or BOOL#1");
                return Err(AlreadyReported);
            }
            return Ok(ExprKind::Bool(read == Ok(1)));
        }
        Ok(self.literal(Code::Number, at, read, |n| ExprKind::Number(n * i128::from(sign), Some(ty))))
    }
}
