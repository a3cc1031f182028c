//! Recursive descent over the tokens of one source. A fault is reported where it is found, then reading goes on
//! after the next semicolon or at the next word that starts or closes something.

pub(crate) mod ast;
mod configuration;
mod constant;
mod decl;
mod expr;
mod initial;
mod lexer;
mod literal;
mod members;
mod moment;
mod names;
mod skip;
mod stmt;
#[cfg(test)]
mod tests;
mod tokens;
mod types;
pub(crate) mod words;

use crate::codes::Code;
use crate::findings::{CompileFindings, SourcePlace};
use ast::{Name, SourceUnit};
use document::SourceFile;
use lexer::Token;
pub use lexer::{declares, mentions};
pub(crate) use names::NameTable;
use tokens::Tok;
use words::Word;

/// Brackets, operators and blocks inside each other. Bounds the recursion of the parser.
const MAX_DEPTH: usize = 64;

/// Nodes of an expression above each other. Bounds the recursion of what walks the tree.
const MAX_HEIGHT: usize = 128;

/// Longest name that the documents allow (controller:DT-03).
const LONG_NAME: usize = 32;

/// The fault has been reported.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AlreadyReported;

type Parsed<T> = Result<T, AlreadyReported>;

/// Sources that a place can tell apart.
const MOST_SOURCES: usize = 65_535;

/// Reads all sources into one unit.
pub(crate) fn parse(
    sources: &[SourceFile],
    own: usize,
    names: &mut NameTable,
    findings: &mut CompileFindings<'_>,
) -> SourceUnit {
    let mut unit = SourceUnit::default();
    if sources.len() > MOST_SOURCES {
        let message = format!("{} sources are too many", sources.len());
        let help = format!("join some of them: at most {MOST_SOURCES} are read");
        findings.error(Code::SourceSize, SourcePlace::default(), message, help);
    }
    for (file, source) in (0..=u16::MAX).zip(sources) {
        let (tokens, cut) = tokens::tokens(&source.text, file, names, findings);
        let mut parser = Parser {
            text: &source.text,
            file,
            own: usize::from(file) < own,
            tok: Tok::END,
            tokens,
            place: 0,
            last: SourcePlace { file, start: 0, end: 0 },
            names,
            findings,
            depth: 0,
            height: 0,
            open: Vec::new(),
            builds: false,
            built: None,
            given_up: false,
            cut,
        };
        parser.go(0);
        parser.declarations(&mut unit);
    }
    unit
}

/// The first word of a text after remarks and pragmas, in capitals.
pub(crate) fn first_word(text: &str) -> String {
    let mut lexer = <Token as logos::Logos>::lexer(text);
    while let Some(token) = lexer.next() {
        if token == Ok(Token::Word) {
            return lexer.slice().to_ascii_uppercase();
        }
    }
    String::new()
}

struct Parser<'t, 'p, 's> {
    text: &'t str,
    file: u16,
    /// The source is the user's.
    own: bool,
    tokens: Vec<Tok>,
    /// Of the present token.
    place: usize,
    tok: Tok,
    /// The token before the present one.
    last: SourcePlace,
    names: &'p NameTable,
    findings: &'p mut CompileFindings<'s>,
    depth: usize,
    /// Nodes above each other in the expression that was read last.
    height: usize,
    /// What closes the statements around the present token, of one body.
    open: Vec<Word>,
    /// Whether an instance with arguments for FB_Init may be declared here, and those that were read.
    builds: bool,
    built: Option<ast::Built>,
    /// Nothing more is read.
    given_up: bool,
    /// The text ends inside a comment: what is missing at its end is not worth a word.
    cut: bool,
}

impl<'t> Parser<'t, '_, '_> {
    fn go(&mut self, place: usize) {
        self.place = place;
        self.tok = self.tokens.get(place).copied().unwrap_or(Tok::END);
    }

    /// To the next token.
    fn advance(&mut self) {
        self.last = self.at();
        if self.tok.token != Token::End {
            self.go(self.place + 1);
        }
    }

    fn at(&self) -> SourcePlace {
        match self.tok.token {
            Token::End => {
                let end = self.text.len() as u32;
                SourcePlace { file: self.file, start: end, end }
            }
            _ => SourcePlace { file: self.file, start: self.tok.start, end: self.tok.end },
        }
    }

    /// The token `n` after the present one.
    fn ahead(&self, n: usize) -> Tok {
        match self.given_up {
            true => Tok::END,
            false => self.tokens.get(self.place + n).copied().unwrap_or(Tok::END),
        }
    }

    fn slice(&self, at: SourcePlace) -> &'t str {
        self.text.get(at.start as usize..at.end as usize).unwrap_or("")
    }

    fn is(&self, token: Token) -> bool {
        self.tok.token == token
    }

    fn next_is(&self, token: Token) -> bool {
        self.ahead(1).token == token
    }

    /// The present word of the language.
    fn word(&self) -> Option<Word> {
        Word::of(self.tok.key)
    }

    fn at_word(&self, word: Word) -> bool {
        self.tok.key == word.key()
    }

    /// Whether the present token can be a name.
    fn at_name(&self) -> bool {
        self.tok.is_name()
    }

    fn accept(&mut self, token: Token) -> bool {
        let found = self.is(token);
        if found {
            self.advance();
        }
        found
    }

    fn accept_word(&mut self, word: Word) -> bool {
        let found = self.at_word(word);
        if found {
            self.advance();
        }
        found
    }

    fn expect(&mut self, token: Token, what: &str) -> Parsed<SourcePlace> {
        if self.accept(token) { Ok(self.last) } else { Err(self.unexpected(what)) }
    }

    fn expect_word(&mut self, word: Word) -> Parsed<SourcePlace> {
        if self.accept_word(word) { Ok(self.last) } else { Err(self.unexpected(word.text())) }
    }

    /// A missing semicolon is shown after what it should follow. Where a new line starts with a word, what was read
    /// is taken as complete.
    fn semicolon(&mut self) -> Parsed<()> {
        if self.accept(Token::Semicolon) {
            return Ok(());
        }
        if !self.silent() {
            let found = self.found();
            let at = SourcePlace { start: self.last.end, end: self.last.end, ..self.last };
            let message = format!("a semicolon is missing here, before {found}");
            self.error(Code::Unexpected, at, message, "end the statement or declaration with ;");
        }
        let between = SourcePlace { start: self.last.end, end: self.tok.start, ..self.last };
        if self.is(Token::Word) && self.slice(between).contains('\n') { Ok(()) } else { Err(AlreadyReported) }
    }

    /// What the present token is, in words.
    fn found(&self) -> String {
        match self.tok.token {
            Token::End => "the end of the text".to_string(),
            _ => format!("`{}`", self.slice(self.at()).chars().take(40).collect::<String>()),
        }
    }

    /// Whether what is missing here is not worth a word.
    fn silent(&self) -> bool {
        self.given_up || self.cut && self.is(Token::End)
    }

    fn error(
        &mut self,
        code: Code,
        at: SourcePlace,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> AlreadyReported {
        self.findings.error(code, at, message, help);
        if self.findings.full() {
            self.give_up();
        }
        AlreadyReported
    }

    fn give_up(&mut self) {
        self.given_up = true;
        self.tok = Tok::END;
    }

    fn unexpected(&mut self, what: &str) -> AlreadyReported {
        if self.silent() {
            return AlreadyReported;
        }
        let message = format!("{what} is expected here, not {}", self.found());
        let help = match self.is(Token::Word) && Word::is_reserved(self.tok.key) {
            true => format!("{} belongs to the language and is no name", self.found()),
            false => format!("write {what} here, or remove what does not belong"),
        };
        self.error(Code::Unexpected, self.at(), message, help)
    }

    /// `word` is missing, which closes what `open` opened.
    fn unclosed(&mut self, word: Word, open: SourcePlace) -> AlreadyReported {
        if !self.silent() {
            let word = word.text();
            let message = format!("{word} is expected here, not {}", self.found());
            let help = format!("close it with {word}");
            let other = (open, "this is not closed");
            self.findings.error_with(Code::Unclosed, self.at(), message, help, other);
            if self.findings.full() {
                self.give_up();
            }
        }
        AlreadyReported
    }

    /// A part of the language that is refused, with what to write instead.
    fn unsupported(&mut self, at: SourcePlace, what: &str, help: &str) -> AlreadyReported {
        self.error(Code::Unsupported, at, format!("{what} is not supported"), help)
    }

    /// A name that the user chose.
    fn name(&mut self, what: &str) -> Parsed<Name> {
        if !self.at_name() {
            return Err(self.unexpected(what));
        }
        let name = Name { key: self.tok.key, at: self.at() };
        self.advance();
        Ok(name)
    }

    /// A name that is being declared: it has to keep the rules (controller:DT-03). Underscores side by side are only warned of,
    /// because libraries of vendors have them.
    fn new_name(&mut self, what: &str) -> Parsed<Name> {
        let at = self.at();
        let Tok { token, key, .. } = self.tok;
        let declared = matches!(
            self.ahead(1).token,
            Token::Colon | Token::Comma | Token::Assign | Token::Close | Token::Semicolon
        );
        let taken =
            Word::is_reserved(key) && declared || [Word::String.key(), Word::Wstring.key()].contains(&key);
        if token == Token::Word && taken {
            let message = format!("`{}` belongs to the language", self.slice(at));
            self.error(Code::Reserved, at, message, "choose another name");
            self.advance();
            return Ok(Name { key, at });
        }
        let name = self.name(what)?;
        let text = self.slice(at);
        if text.bytes().all(|byte| byte == b'_') {
            let message = format!("`{text}` has no letter or digit");
            self.error(Code::Identifier, at, message, "use letters and digits beside the underscore");
        } else if self.own && text.contains("__") {
            let message = format!("`{text}` has two underscores side by side");
            self.findings.warning(
                Code::Underscores,
                at,
                message,
                "the controllers' tool takes single ones only",
            );
        }
        if self.own && text.len() > LONG_NAME {
            let message = format!("`{text}` is longer than {LONG_NAME} characters");
            self.findings.warning(Code::LongName, at, message, "the controllers promise 32 characters");
        }
        Ok(name)
    }

    /// `library.name`, of which only the name counts. The point stands at the name: after the head of a method,
    /// `.global := 1;` is a statement.
    fn path_name(&mut self, what: &str) -> Parsed<Name> {
        let mut name = self.name(what)?;
        while self.is(Token::Dot) && self.tok.start == self.last.end && self.ahead(1).is_name() {
            self.advance();
            name = self.name(what)?;
        }
        Ok(name)
    }

    /// Runs `inner` one level deeper; too deep gives up the whole source.
    fn nested<T>(&mut self, inner: impl FnOnce(&mut Self) -> Parsed<T>) -> Parsed<T> {
        if self.depth >= MAX_DEPTH {
            return Err(self.too_deep());
        }
        self.depth += 1;
        let result = inner(self);
        self.depth -= 1;
        result
    }

    fn too_deep(&mut self) -> AlreadyReported {
        if !self.given_up {
            let message = format!("more than {MAX_DEPTH} brackets or blocks inside each other");
            self.error(Code::Nesting, self.at(), message, "split it up; the rest was not read");
            self.give_up();
        }
        AlreadyReported
    }
}
