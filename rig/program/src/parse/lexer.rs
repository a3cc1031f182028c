//! Text to tokens.

use logos::{FilterResult, Lexer, Logos, Skip};

/// What went wrong in a token.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum LexFault {
    #[default]
    Character,
    /// A comment, pragma or string runs to the end of the text or line.
    Unterminated,
}

/// A token; its text is taken from the source.
#[derive(Logos, Clone, Copy, Debug, PartialEq, Eq)]
#[logos(error = LexFault)]
#[logos(skip r"[ \t\r\n\f]+")]
#[logos(skip r"//[^\n]*")]
pub(crate) enum Token {
    #[token("(*", nested_comment)]
    #[token("/*", slash_comment)]
    #[token("{", pragma)]
    Comment,

    /// A name or a keyword.
    #[regex(r"[A-Za-z_][A-Za-z0-9_]*")]
    Word,
    /// `12`, `1_000`.
    #[regex(r"[0-9][0-9_]*")]
    Integer,
    /// `2#`, `8#`, `16#` with digits, `16#FFFF`.
    #[regex(r"[0-9][0-9_]*#[0-9A-Za-z_]*")]
    Based,
    /// `1.5`, `1.0E3`.
    #[regex(r"[0-9][0-9_]*\.[0-9][0-9_]*([eE][+-]?[0-9]+)?")]
    Real,
    /// `T#1s500ms`, `TIME#5s`.
    #[regex(r"(T|TIME)#[+-]?[0-9A-Za-z_.]*", priority = 20, ignore(case))]
    Duration,
    /// `INT#` before a literal.
    #[regex(r"[A-Za-z_][A-Za-z0-9_]*#")]
    Prefix,
    /// `%IX0.4`, `%MW10`.
    #[regex(r"%[A-Za-z]*[0-9*]*(\.[0-9]+)*")]
    Address,
    #[regex("'", |lex| quoted(lex, b'\''))]
    #[regex("\"", |lex| quoted(lex, b'"'))]
    Text,

    #[token(":=")]
    Assign,
    #[token("=>")]
    Arrow,
    #[token("..")]
    Range,
    #[token("<=")]
    LessEqual,
    #[token(">=")]
    GreaterEqual,
    #[token("<>")]
    NotEqual,
    #[token("**")]
    Power,
    #[token("=")]
    Equal,
    #[token("<")]
    Less,
    #[token(">")]
    Greater,
    #[token("+")]
    Plus,
    #[token("-")]
    Minus,
    #[token("*")]
    Star,
    #[token("/")]
    Slash,
    #[token("&")]
    Ampersand,
    #[token("(")]
    Open,
    #[token(")")]
    Close,
    #[token("[")]
    OpenBracket,
    #[token("]")]
    CloseBracket,
    #[token(",")]
    Comma,
    #[token(";")]
    Semicolon,
    #[token(":")]
    Colon,
    #[token(".")]
    Dot,
    #[token("^")]
    Caret,
    #[token("#")]
    Hash,

    /// The end of the text. Never made by the lexer itself.
    End,
}

fn nested_comment(lex: &mut Lexer<Token>) -> FilterResult<(), LexFault> {
    let rest = lex.remainder().as_bytes();
    let (mut depth, mut at) = (1usize, 0);
    while at < rest.len() {
        match &rest[at..(at + 2).min(rest.len())] {
            b"(*" => (depth, at) = (depth + 1, at + 2),
            b"*)" => (depth, at) = (depth - 1, at + 2),
            _ => at += 1,
        }
        if depth == 0 {
            lex.bump(at);
            return FilterResult::Skip;
        }
    }
    unterminated(lex)
}

fn slash_comment(lex: &mut Lexer<Token>) -> FilterResult<(), LexFault> {
    skip_past(lex, "*/")
}

fn pragma(lex: &mut Lexer<Token>) -> FilterResult<(), LexFault> {
    skip_past(lex, "}")
}

fn skip_past(lex: &mut Lexer<Token>, end: &str) -> FilterResult<(), LexFault> {
    match lex.remainder().find(end) {
        Some(at) => {
            lex.bump(at + end.len());
            let _: Skip = Skip;
            FilterResult::Skip
        }
        None => unterminated(lex),
    }
}

fn unterminated(lex: &mut Lexer<Token>) -> FilterResult<(), LexFault> {
    // What follows is inside the comment: reading on would only report it piece by piece.
    let rest = lex.remainder().len();
    lex.bump(rest);
    FilterResult::Error(LexFault::Unterminated)
}

/// The rest of a string; `$` escapes the next character.
fn quoted(lex: &mut Lexer<Token>, quote: u8) -> Result<(), LexFault> {
    let rest = lex.remainder();
    let mut escaped = false;
    for (at, byte) in rest.bytes().enumerate() {
        match byte {
            b'\n' => {
                lex.bump(at);
                return Err(LexFault::Unterminated);
            }
            _ if escaped => escaped = false,
            b'$' => escaped = true,
            _ if byte == quote => {
                lex.bump(at + 1);
                return Ok(());
            }
            _ => {}
        }
    }
    lex.bump(rest.len());
    Err(LexFault::Unterminated)
}
