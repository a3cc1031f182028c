//! Text to tokens.

use logos::{FilterResult, Lexer, Logos};

/// Whether a name stands in a text outside of comments, pragmas and texts, in any case of letters.
pub fn mentions(text: &str, name: &str) -> bool {
    words(text, name).next().is_some()
}

/// Whether a text declares a name, with a colon and a type after it.
pub fn declares(text: &str, name: &str) -> bool {
    words(text, name).any(|mut rest| {
        loop {
            match rest.next() {
                Some(Ok(Token::Comment)) => {}
                next => return next == Some(Ok(Token::Colon)),
            }
        }
    })
}

/// Where a name stands: what follows each time.
fn words<'a>(text: &'a str, name: &'a str) -> impl Iterator<Item = Lexer<'a, Token>> {
    // Few texts have it at all, and looking for bytes is quick.
    let bytes = text.as_bytes().windows(name.len().max(1));
    let somewhere = bytes.into_iter().any(|bytes| bytes.eq_ignore_ascii_case(name.as_bytes()));
    let mut tokens = Token::lexer(if somewhere { text } else { "" });
    std::iter::from_fn(move || {
        loop {
            let token = tokens.next()?;
            if token == Ok(Token::Word) && tokens.slice().eq_ignore_ascii_case(name) {
                return Some(tokens.clone());
            }
        }
    })
}

/// What went wrong in a token.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum LexFault {
    #[default]
    Character,
    /// A comment, pragma or string runs to the end of the text or line.
    Unterminated,
    /// A pragma that chooses between pieces of the source.
    Conditional,
}

/// Whether comments end at the first `*)`, as exports of older tools say of themselves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Flat(bool);

/// A token; its text is taken from the source.
#[derive(Logos, Clone, Copy, Debug, PartialEq, Eq)]
#[logos(error = LexFault)]
#[logos(extras = Flat)]
#[logos(skip r"[ \t\r\n\f\u{feff}]+")]
#[logos(skip r"//[^\n]*")]
pub(crate) enum Token {
    #[token("(*", |lex| comment(lex, b"(*", b"*)"))]
    #[token("/*", |lex| comment(lex, b"/*", b"*/"))]
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
    /// `1.5`, `1.0E3`, `1e10`.
    #[regex(r"[0-9][0-9_]*\.[0-9][0-9_]*")]
    #[regex(r"[0-9][0-9_]*(\.[0-9][0-9_]*)?[eE][+-]?[0-9][0-9_]*")]
    Real,
    /// `T#1s500ms`, `LTIME#5us`.
    #[regex(r"(T|TIME|LT|LTIME)#", duration, priority = 20, ignore(case))]
    Duration,
    /// `D#2024-02-29`, `TOD#12:00:00`, `LDT#2024-02-29-12:00:00.5`.
    #[regex(r"L?(D|DATE|TOD|TIME_OF_DAY|DT|DATE_AND_TIME)#", date, priority = 20, ignore(case))]
    Date,
    /// `INT#` before a literal, `colour#` before the name of a value.
    #[regex(r"[A-Za-z_][A-Za-z0-9_]*#")]
    Prefix,
    /// `%IX0.4`, `%MW10`; `%I*`; after a point `%X3`.
    #[regex(r"%[A-Za-z]*[0-9*]*(\.[0-9]+)*")]
    Address,
    #[regex("'", |lex| quoted(lex, b'\''))]
    #[regex("\"", |lex| quoted(lex, b'"'))]
    Text,

    #[token(":=")]
    Assign,
    #[token("?=")]
    Attempt,
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

    /// A string that is not closed, which was reported. Never made by the lexer itself.
    BadText,
    /// The end of the text. Never made by the lexer itself.
    End,
}

/// A comment, with those of its own kind inside it.
fn comment(lex: &mut Lexer<Token>, open: &[u8; 2], close: &[u8; 2]) -> FilterResult<(), LexFault> {
    let rest = lex.remainder().as_bytes();
    let (mut depth, mut at) = (1usize, 0);
    while let Some(pair) = rest.get(at..at + 2) {
        if pair == close {
            (depth, at) = (depth - 1, at + 2);
        } else if pair == open && !lex.extras.0 {
            (depth, at) = (depth + 1, at + 2);
        } else {
            at += 1;
        }
        if depth == 0 {
            lex.bump(at);
            if let Some((_, value)) = lex.slice().split_once("@NESTEDCOMMENTS") {
                lex.extras = Flat(value.contains("'No'"));
            }
            return FilterResult::Skip;
        }
    }
    unterminated(lex)
}

/// `{attribute ..}` and other remarks to a tool are skipped; what would choose between pieces of the source is not.
fn pragma(lex: &mut Lexer<Token>) -> FilterResult<(), LexFault> {
    let rest = lex.remainder();
    let Some(at) = rest.find('}') else { return unterminated(lex) };
    let body = rest.get(..at).unwrap_or("").trim_start();
    let word = body.split(|c: char| !c.is_ascii_alphabetic()).next().unwrap_or("");
    lex.bump(at + 1);
    if word.eq_ignore_ascii_case("IF") {
        FilterResult::Error(LexFault::Conditional)
    } else {
        FilterResult::Skip
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

/// The rest of a duration. A point belongs to it only before a digit: `T#1s..T#2s` is a range.
fn duration(lex: &mut Lexer<Token>) {
    let rest = lex.remainder().as_bytes();
    let sign = usize::from(matches!(rest.first(), Some(b'+' | b'-')));
    body(lex, sign, |byte, next| match byte {
        b'.' => next.is_ascii_digit(),
        _ => byte.is_ascii_alphanumeric() || byte == b'_',
    });
}

/// The rest of a date or time of day.
fn date(lex: &mut Lexer<Token>) {
    body(lex, 0, |byte, next| match byte {
        b'.' | b'-' | b':' => next.is_ascii_digit(),
        _ => byte.is_ascii_digit() || byte == b'_',
    });
}

fn body(lex: &mut Lexer<Token>, start: usize, belongs: impl Fn(u8, u8) -> bool) {
    let rest = lex.remainder().as_bytes();
    let mut at = start;
    while let Some(byte) = rest.get(at) {
        if !belongs(*byte, rest.get(at + 1).copied().unwrap_or(0)) {
            break;
        }
        at += 1;
    }
    lex.bump(at);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tokens(text: &str) -> Vec<(Token, &str)> {
        let mut lexer = Token::lexer(text);
        let mut list = Vec::new();
        while let Some(token) = lexer.next() {
            list.push((token.unwrap(), lexer.slice()));
        }
        list
    }

    #[test]
    fn numbers_end_where_they_end() {
        use Token::*;
        assert_eq!(tokens("1..5"), [(Integer, "1"), (Range, ".."), (Integer, "5")]);
        assert_eq!(tokens("1.5..2.5E-3"), [(Real, "1.5"), (Range, ".."), (Real, "2.5E-3")]);
        assert_eq!(tokens("1e10 2E+3"), [(Real, "1e10"), (Real, "2E+3")]);
        assert_eq!(tokens("1.5ELSE"), [(Real, "1.5"), (Word, "ELSE")]);
        assert_eq!(tokens("7END_IF"), [(Integer, "7"), (Word, "END_IF")]);
        assert_eq!(tokens("1.5E+"), [(Real, "1.5"), (Word, "E"), (Plus, "+")]);
        assert_eq!(tokens("16#1E5"), [(Based, "16#1E5")]);
        assert_eq!(tokens("w.3"), [(Word, "w"), (Dot, "."), (Integer, "3")]);
        assert_eq!(tokens("w.%X3"), [(Word, "w"), (Dot, "."), (Address, "%X3")]);
        assert_eq!(tokens("%MW10.3"), [(Address, "%MW10.3")]);
        assert_eq!(tokens("\u{feff}a"), [(Word, "a")]);
    }

    #[test]
    fn moments_end_where_they_end() {
        use Token::*;
        assert_eq!(tokens("T#1s..t#1.5s"), [(Duration, "T#1s"), (Range, ".."), (Duration, "t#1.5s")]);
        assert_eq!(tokens("T#-5s-1"), [(Duration, "T#-5s"), (Minus, "-"), (Integer, "1")]);
        assert_eq!(tokens("LTIME#1us LT#1ns"), [(Duration, "LTIME#1us"), (Duration, "LT#1ns")]);
        assert_eq!(tokens("D#2020-01-31-x"), [(Date, "D#2020-01-31"), (Minus, "-"), (Word, "x")]);
        assert_eq!(tokens("ldt#2020-01-31-12:34:56.7:"), [(Date, "ldt#2020-01-31-12:34:56.7"), (Colon, ":")]);
        assert_eq!(tokens("tod#12:00:00..TIME_OF_DAY#1:2:3").len(), 3);
        assert_eq!(tokens("TX#a DTX#1"), [(Prefix, "TX#"), (Word, "a"), (Prefix, "DTX#"), (Integer, "1")]);
    }

    #[test]
    fn comments_and_pragmas_are_skipped() {
        assert_eq!(tokens("a(* (* *) *)b/* /* */ */c{x}//d\ne").len(), 4);
        assert_eq!(tokens("(**)a(***)(*)*)").len(), 1);
        let fault = |text: &str| Token::lexer(text).next().unwrap().unwrap_err();
        assert_eq!(fault("(* (* *)"), LexFault::Unterminated);
        assert_eq!(fault("/*/"), LexFault::Unterminated);
        assert_eq!(fault("'a"), LexFault::Unterminated);
        assert_eq!(fault("'a$'\n'"), LexFault::Unterminated);
        assert_eq!(fault("{ IF defined(x)}"), LexFault::Conditional);
        assert_eq!(fault("?"), LexFault::Character);
    }
}
