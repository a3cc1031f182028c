//! Recursive descent over the tokens of one source. A fault is reported where it is found, then reading goes on
//! behind the next semicolon or at the next keyword that starts or closes something.

pub(crate) mod ast;
mod decl;
mod expr;
mod lexer;
mod literal;
mod stmt;
pub(crate) mod words;

use crate::codes::Code;
use crate::findings::{At, Findings};
use ast::{Name, Unit};
use lexer::{LexFault, Token};
use logos::{Lexer, Logos};

/// Brackets, operators and blocks inside each other. Bounds the recursion of parser and compiler.
const MAX_DEPTH: usize = 64;

/// Longest name that the documents allow (controller:DT-03).
const LONG_NAME: usize = 32;

/// The fault has been reported.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reported;

type Parsed<T> = Result<T, Reported>;

/// Reads one source into `unit`.
pub(crate) fn parse(file: u8, text: &str, findings: &mut Findings<'_>, unit: &mut Unit) {
    let ended = (Token::End, At { file, start: 0, end: 0 });
    let lexer = Token::lexer(text);
    let mut parser = Parser {
        text,
        file,
        lexer,
        findings,
        token: ended,
        next: ended,
        last: ended.1,
        depth: 0,
        given_up: false,
    };
    parser.advance();
    parser.advance();
    parser.declarations(unit);
}

struct Parser<'t, 'f, 's> {
    text: &'t str,
    file: u8,
    lexer: Lexer<'t, Token>,
    findings: &'f mut Findings<'s>,
    token: (Token, At),
    next: (Token, At),
    /// The token before `token`.
    last: At,
    depth: usize,
    /// Nothing more is read.
    given_up: bool,
}

impl<'t> Parser<'t, '_, '_> {
    /// To the next token. Characters that make none are reported here, a run of them once.
    fn advance(&mut self) {
        self.last = self.token.1;
        self.token = self.next;
        let mut bad: Option<At> = None;
        self.next = loop {
            let lexed = if self.given_up { None } else { self.lexer.next() };
            let span = self.lexer.span();
            let at = At { file: self.file, start: span.start as u32, end: span.end as u32 };
            match lexed {
                Some(Err(LexFault::Character)) => bad = Some(bad.map_or(at, |bad| bad.to(at))),
                Some(Err(LexFault::Unterminated)) => {
                    let (what, close) = match self.text.as_bytes().get(span.start) {
                        Some(b'(') => ("comment", "*)"),
                        Some(b'/') => ("comment", "*/"),
                        Some(b'{') => ("pragma", "}"),
                        _ => ("string", "a quotation mark"),
                    };
                    let at = At { end: at.start + 1, ..at };
                    let message = format!("this {what} is not closed");
                    self.findings.error(Code::Unterminated, at, message, format!("close it with {close}"));
                    // A comment swallows the rest: what is missing then is not worth a word. Strings end with their line.
                    self.given_up = what != "string";
                }
                Some(Ok(Token::Comment)) => {}
                Some(Ok(token)) => break (token, at),
                None => {
                    let end = self.text.len() as u32;
                    break (Token::End, At { file: self.file, start: end, end });
                }
            }
        };
        if let Some(at) = bad {
            let text = self.slice(at).chars().take(8).collect::<String>();
            let message = format!("`{}` is nothing that Structured Text knows", text.escape_debug());
            self.findings.error(Code::Character, at, message, "remove it");
        }
        if self.given_up || self.findings.full() {
            self.token.0 = Token::End;
            self.next.0 = Token::End;
        }
    }

    fn slice(&self, at: At) -> &'t str {
        self.text.get(at.start as usize..at.end as usize).unwrap_or("")
    }

    fn is(&self, token: Token) -> bool {
        self.token.0 == token
    }

    /// Whether the token is this word, given in capitals.
    fn at_word(&self, word: &str) -> bool {
        self.is(Token::Word) && self.slice(self.token.1).eq_ignore_ascii_case(word)
    }

    fn accept(&mut self, token: Token) -> bool {
        let found = self.is(token);
        if found {
            self.advance();
        }
        found
    }

    fn accept_word(&mut self, word: &str) -> bool {
        let found = self.at_word(word);
        if found {
            self.advance();
        }
        found
    }

    fn expect(&mut self, token: Token, what: &str) -> Parsed<At> {
        if self.is(token) {
            self.advance();
            return Ok(self.last);
        }
        Err(self.unexpected(what))
    }

    fn expect_word(&mut self, word: &str) -> Parsed<At> {
        if self.accept_word(word) { Ok(self.last) } else { Err(self.unexpected(word)) }
    }

    /// A missing semicolon is shown behind what it should follow.
    fn semicolon(&mut self) -> Parsed<()> {
        if self.accept(Token::Semicolon) {
            return Ok(());
        }
        if self.given_up {
            return Err(Reported);
        }
        if self.is(Token::Word) {
            // `a AND_THEN b`: what stops the expression is a word that later parts of the language bring.
            let key = self.slice(self.token.1).to_ascii_uppercase();
            if words::is_unsupported(&key) {
                return Err(self.unsupported(self.token.1, &key));
            }
        }
        let found = self.found();
        let at = At { start: self.last.end, end: self.last.end, ..self.last };
        let message = format!("a semicolon is missing here, before {found}");
        self.findings.error(Code::Unexpected, at, message, "end the statement or declaration with ;");
        Err(Reported)
    }

    /// What the present token is, in words.
    fn found(&self) -> String {
        match self.token.0 {
            Token::End => "the end of the text".to_string(),
            _ => format!("`{}`", self.slice(self.token.1).chars().take(40).collect::<String>()),
        }
    }

    fn unexpected(&mut self, what: &str) -> Reported {
        if self.given_up {
            return Reported;
        }
        if self.is(Token::Word) {
            let key = self.slice(self.token.1).to_ascii_uppercase();
            if words::is_unsupported(&key) {
                return self.unsupported(self.token.1, &key);
            }
        }
        if self.is(Token::Text) {
            return self.unsupported(self.token.1, "a string");
        }
        let message = format!("{what} is expected here, not {}", self.found());
        self.findings.error(Code::Unexpected, self.token.1, message, "");
        Reported
    }

    /// `word` is missing, which closes what `open` opened.
    fn unclosed(&mut self, word: &str, open: At) -> Reported {
        if !self.given_up {
            let message = format!("{word} is expected here, not {}", self.found());
            self.findings.error_with(Code::Unclosed, self.token.1, message, "", (open, "this is not closed"));
        }
        Reported
    }

    fn unsupported(&mut self, at: At, what: &str) -> Reported {
        let message = format!("{what} is not supported yet");
        self.findings.error(Code::Unsupported, at, message, "");
        Reported
    }

    /// A name that the user chose.
    fn name(&mut self, what: &str) -> Parsed<Name> {
        if !self.is(Token::Word) {
            return Err(self.unexpected(what));
        }
        let at = self.token.1;
        let text = self.slice(at);
        let key = text.to_ascii_uppercase();
        if words::is_keyword(&key) || words::is_unsupported(&key) {
            return Err(self.unexpected(what));
        }
        self.advance();
        Ok(Name { text: text.to_string(), key, at })
    }

    /// A name that is being declared: it has to keep the rules (controller:DT-03).
    fn new_name(&mut self, what: &str) -> Parsed<Name> {
        let at = self.token.1;
        let key = self.slice(at).to_ascii_uppercase();
        let reserved = self.is(Token::Word) && (words::is_keyword(&key) || words::is_unsupported(&key));
        if reserved && matches!(self.next.0, Token::Colon | Token::Comma) {
            let text = self.slice(at).to_string();
            let message = format!("`{text}` belongs to the language");
            self.findings.error(Code::Reserved, at, message, "choose another name");
            self.advance();
            return Ok(Name { text, key, at });
        }
        let name = self.name(what)?;
        if name.text.contains("__") || (name.text.ends_with('_') && name.text.len() > 1) || name.text == "_" {
            let message = format!("`{}` has underscores side by side or at its end", name.text);
            self.findings.error(
                Code::Identifier,
                name.at,
                message,
                "use single underscores between letters and digits",
            );
        }
        if name.text.len() > LONG_NAME {
            let message = format!("`{}` is longer than {LONG_NAME} characters", name.text);
            self.findings.warning(Code::LongName, name.at, message, "the controllers promise 32 characters");
        }
        Ok(name)
    }

    /// Runs `inner` one level deeper; too deep gives up the whole source.
    fn nested<T>(&mut self, inner: impl FnOnce(&mut Self) -> Parsed<T>) -> Parsed<T> {
        if self.depth >= MAX_DEPTH {
            if !self.given_up {
                self.given_up = true;
                let message = format!("more than {MAX_DEPTH} brackets or blocks inside each other");
                self.findings.error(
                    Code::Nesting,
                    self.token.1,
                    message,
                    "split it up; the rest was not read",
                );
                self.token.0 = Token::End;
                self.next.0 = Token::End;
            }
            return Err(Reported);
        }
        self.depth += 1;
        let result = inner(self);
        self.depth -= 1;
        result
    }
}
