//! What the TOML library lets through and a hand-written file must not have: the novelties of TOML 1.1, which
//! other tools refuse, and sizes that no hand writes. Works on the tokens alone, before the tree is built.

use std::ops::Range;

use toml_parser::Source;
use toml_parser::lexer::TokenKind;

use crate::{Findings, SourceFile};

/// Largest file in bytes.
pub(crate) const MAX_BYTES: usize = 1 << 20;
/// Most keys, values and marks between them in one file; bounds the memory of the tree.
const MAX_TOKENS: usize = 200_000;
/// Deepest brackets and longest dotted key.
const MAX_DEPTH: usize = 24;

/// Checks the tokens. `false` if the file must not be parsed at all.
pub(crate) fn check(file: &SourceFile, out: &mut Findings) -> bool {
    if file.text.len() > MAX_BYTES {
        let help = "a TOML file has at most 1 MiB: split it, or leave out what it does not need";
        out.error(out.codes().too_large, 0..0, "the file is larger than 1 MiB", help);
        return false;
    }
    let mut state = State::default();
    let mut tokens = 0usize;
    for token in Source::new(&file.text).lex() {
        let span = token.span().start()..token.span().end();
        if !matches!(token.kind(), TokenKind::Whitespace | TokenKind::Comment | TokenKind::Newline) {
            tokens += 1;
        }
        if tokens > MAX_TOKENS {
            let message = format!("more than {MAX_TOKENS} keys, values and marks");
            out.error(out.codes().too_large, span, message, "split the file");
            return false;
        }
        if !state.take(token.kind(), span, &file.text, out) {
            return false;
        }
    }
    true
}

/// What is open at a token.
#[derive(Default)]
struct State {
    /// Open brackets: `{` with whether its line break was already reported, or `[`.
    open: Vec<Open>,
    /// Dots since the last mark that ends a key.
    dots: usize,
    /// The comma before this token, if only blanks lie between.
    comma: Option<Range<usize>>,
}

enum Open {
    List,
    InlineTable { reported: bool },
}

impl State {
    /// Looks at one token; `false` if the file must not be parsed.
    fn take(&mut self, kind: TokenKind, span: Range<usize>, text: &str, out: &mut Findings) -> bool {
        match kind {
            TokenKind::LeftCurlyBracket => self.open.push(Open::InlineTable { reported: false }),
            TokenKind::LeftSquareBracket => self.open.push(Open::List),
            TokenKind::RightSquareBracket => {
                self.open.pop();
            }
            TokenKind::RightCurlyBracket => {
                if let (Some(comma), Some(Open::InlineTable { .. })) = (self.comma.take(), self.open.pop()) {
                    let message = "a comma after the last entry of an inline table";
                    out.error(
                        out.codes().newer_toml,
                        comma,
                        message,
                        "TOML 1.0 does not allow it: remove the comma",
                    );
                }
            }
            TokenKind::Newline => {
                self.dots = 0;
                if let Some(Open::InlineTable { reported: reported @ false }) = self.open.last_mut() {
                    *reported = true;
                    let message = "a line break inside an inline table";
                    let help = "TOML 1.0 keeps an inline table `{ ... }` on one line: join the lines, or write a list \
                                with one inline table per line";
                    out.error(out.codes().newer_toml, span, message, help);
                }
                return true;
            }
            TokenKind::Whitespace | TokenKind::Comment => return true,
            TokenKind::BasicString | TokenKind::MlBasicString => newer_escape(text, &span, out),
            TokenKind::Dot => self.dots += 1,
            TokenKind::Equals => self.dots = 0,
            _ => {}
        }
        self.comma = None;
        if kind == TokenKind::Comma {
            self.dots = 0;
            self.comma = Some(span.clone());
        }
        if self.open.len() > MAX_DEPTH || self.dots > MAX_DEPTH {
            let message = format!("nested deeper than {MAX_DEPTH} levels");
            out.error(out.codes().too_large, span, message, "no file needs so many levels: flatten it");
            return false;
        }
        true
    }
}

/// Reports the escapes `\e` and `\xHH`, which TOML 1.1 brought.
fn newer_escape(text: &str, span: &Range<usize>, out: &mut Findings) {
    let Some(raw) = text.get(span.clone()) else { return };
    let bytes = raw.as_bytes();
    let mut at = 0;
    while at + 1 < bytes.len() {
        if bytes[at] != b'\\' {
            at += 1;
            continue;
        }
        if matches!(bytes[at + 1], b'e' | b'x') {
            let place = span.start + at..span.start + at + 2;
            let help =
                "TOML 1.0 does not know it: write \\u001B for the escape character, \\u00HH for others";
            out.error(out.codes().newer_toml, place, "an escape of TOML 1.1", help);
        }
        at += 2;
    }
}
