//! The tokens of a source as a list, so that the parser can look ahead.

use super::ast::Key;
use super::lexer::{LexFault, Token};
use super::names::NameTable;
use super::words::Word;
use crate::codes::Code;
use crate::findings::{CompileFindings, SourcePlace};
use logos::Logos;

/// The key of what is no word.
pub(super) const NO_WORD: Key = Key(u32::MAX);

/// A token with its place and, for words and for what stands before `#`, its key.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tok {
    pub token: Token,
    pub start: u32,
    pub end: u32,
    pub key: Key,
    /// What stands before `#`; [`NO_WORD`] for other tokens.
    pub prefix: Key,
}

impl Tok {
    pub const END: Tok = Tok { token: Token::End, start: 0, end: 0, key: NO_WORD, prefix: NO_WORD };

    /// Whether this can be a name.
    pub fn is_name(self) -> bool {
        self.token == Token::Word && !Word::is_reserved(self.key)
    }
}

/// All tokens, and whether the text ends inside a comment or pragma. Characters that make no token are reported, a
/// run of them once.
pub(super) fn tokens(
    text: &str,
    file: u16,
    names: &mut NameTable,
    findings: &mut CompileFindings<'_>,
) -> (Vec<Tok>, bool) {
    let mut list = Vec::with_capacity(text.len() / 4);
    let mut lexer = Token::lexer(text);
    let mut bad: Option<SourcePlace> = None;
    let mut cut = false;
    while let Some(lexed) = lexer.next() {
        let span = lexer.span();
        let (start, end) = (span.start as u32, span.end as u32);
        let at = SourcePlace { file, start, end };
        if let Some(run) = bad.take_if(|_| lexed != Err(LexFault::Character)) {
            character(run, text, findings);
        }
        let mut tok = Tok { token: Token::End, start, end, ..Tok::END };
        match lexed {
            Ok(Token::Comment) => continue,
            Ok(token) => {
                tok.token = token;
                match token {
                    Token::Word => tok.key = word(lexer.slice(), names),
                    Token::Prefix => tok.prefix = names.intern(lexer.slice().trim_end_matches('#')),
                    _ => {}
                }
                list.push(tok);
            }
            Err(LexFault::Character) => bad = Some(bad.map_or(at, |bad| bad.to(at))),
            Err(LexFault::Conditional) => {
                let message = "a pragma that chooses between pieces of the source is not supported";
                let help = "keep the piece that is wanted, remove the others";
                findings.error(Code::Unsupported, at, message, help);
            }
            Err(LexFault::Unterminated) => {
                let (what, close) = match text.as_bytes().get(span.start) {
                    Some(b'(') => ("comment", "*)"),
                    Some(b'/') => ("comment", "*/"),
                    Some(b'{') => ("pragma", "}"),
                    _ => ("string", "a quotation mark"),
                };
                let message = format!("this {what} is not closed");
                let open = SourcePlace { end: start + 1, ..at };
                findings.error(Code::Unterminated, open, message, format!("close it with {close}"));
                // A comment swallows the rest. Strings end with their line and stand for a value.
                cut = what != "string";
                if !cut {
                    tok.token = Token::BadText;
                    list.push(tok);
                }
            }
        }
        if findings.full() {
            break;
        }
    }
    if let Some(run) = bad {
        character(run, text, findings);
    }
    (list, cut)
}

/// The key of a word. Older tools wrote one of the language in one piece as well.
fn word(text: &str, names: &mut NameTable) -> Key {
    if text.len() == 13 && text.eq_ignore_ascii_case("FUNCTIONBLOCK") {
        Word::FunctionBlock.key()
    } else if text.len() == 17 && text.eq_ignore_ascii_case("END_FUNCTIONBLOCK") {
        Word::EndFunctionBlock.key()
    } else {
        names.intern(text)
    }
}

fn character(at: SourcePlace, text: &str, findings: &mut CompileFindings<'_>) {
    let text = text.get(at.start as usize..at.end as usize).unwrap_or("").chars().take(8).collect::<String>();
    let message = format!("`{}` is nothing that Structured Text knows", text.escape_debug());
    findings.error(Code::Character, at, message, "remove it");
}
