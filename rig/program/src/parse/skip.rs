//! Constructs that are refused as a whole: named once, and skipped so that their inside is not reported.

use super::lexer::Token;
use super::words::Word;
use super::{AlreadyReported, Parsed, Parser};
use crate::findings::SourcePlace;

impl Parser<'_, '_, '_> {
    /// After the bracket that closes the one here.
    pub(super) fn skip_brackets(&mut self) {
        let mut depth = 0usize;
        while !self.is(Token::End) && !self.is(Token::Semicolon) {
            match self.tok.token {
                Token::Open | Token::OpenBracket => depth += 1,
                Token::Close | Token::CloseBracket => depth = depth.saturating_sub(1),
                _ => {}
            }
            self.advance();
            if depth == 0 {
                return;
            }
        }
    }

    /// After `close`, of which the text may not run short.
    pub(super) fn skip_past(&mut self, close: Word, open: SourcePlace) {
        while !self.accept_word(close) {
            if self.is(Token::End) {
                self.unclosed(close, open);
                return;
            }
            self.advance();
        }
    }

    /// A declaration at the outside that is not there: CLASS, NAMESPACE, USING.
    pub(super) fn refused_declaration(&mut self) -> Parsed<()> {
        let at = self.at();
        if self.ahead(1).is_name() {
            match self.word() {
                Some(Word::Class) => {
                    self.unsupported(at, "CLASS", "write it as a FUNCTION_BLOCK without a body");
                    self.skip_past(Word::EndClass, at);
                    return Ok(());
                }
                Some(Word::Namespace) => {
                    let help =
                        "remove NAMESPACE and END_NAMESPACE, and give the names inside a common beginning";
                    self.unsupported(at, "NAMESPACE", help);
                    self.advance();
                    let mut depth = 1usize;
                    while depth > 0 && !self.is(Token::End) {
                        match self.word() {
                            Some(Word::Namespace) if self.ahead(1).is_name() => depth += 1,
                            Some(Word::EndNamespace) => depth -= 1,
                            _ => {}
                        }
                        self.advance();
                    }
                    return Ok(());
                }
                Some(Word::Using) => {
                    self.unsupported(at, "USING", "remove it: every name is known everywhere");
                    while !self.is(Token::End) && !self.accept(Token::Semicolon) {
                        self.advance();
                    }
                    return Ok(());
                }
                _ => {}
            }
        }
        Err(self
            .unexpected("PROGRAM, FUNCTION, FUNCTION_BLOCK, INTERFACE, TYPE, CONFIGURATION or VAR_GLOBAL"))
    }

    /// A statement that is not there, or a body in another language. `Ok` where it is neither.
    pub(super) fn refused_statement(&mut self) -> Parsed<()> {
        let at = self.at();
        let next = self.ahead(1);
        // `step S= TRUE` is a statement like any other.
        let assigned = self.ahead(2).token == Token::Equal;
        match self.word() {
            Some(Word::Jmp) => {
                Err(self.unsupported(at, "JMP", "use IF, a loop, EXIT, CONTINUE or RETURN instead"))
            }
            Some(Word::Try) => {
                self.unsupported(at, "__TRY", "test for what could go wrong before it does");
                self.skip_past(Word::EndTry, at);
                Err(AlreadyReported)
            }
            Some(Word::InitialStep | Word::Step | Word::Transition) if next.is_name() && !assigned => {
                let help = "write the steps as a CASE over a variable that holds the present one";
                self.unsupported(at, "a Sequential Function Chart", help);
                Err(self.skip_body())
            }
            Some(Word::Ld | Word::Ldn | Word::Cal | Word::Calc | Word::Calcn)
                if self.is_operand(next.token) && !assigned =>
            {
                self.unsupported(at, "Instruction List", "write the body in Structured Text");
                Err(self.skip_body())
            }
            _ => Ok(()),
        }
    }

    /// A label before a statement, for a jump.
    pub(super) fn refused_label(&mut self) -> bool {
        let found = self.at_name() && self.next_is(Token::Colon);
        if found {
            let help = "a label is only there for JMP: use IF, a loop, EXIT, CONTINUE or RETURN instead";
            self.unsupported(self.at(), "a label", help);
            self.advance();
            self.advance();
        }
        found
    }

    fn is_operand(&self, token: Token) -> bool {
        use Token::{Address, Based, Date, Duration, Integer, Prefix, Real, Text, Word};
        matches!(token, Word | Integer | Based | Real | Duration | Date | Prefix | Address | Text)
    }

    /// Up to what closes the body. Declarations do not start inside another language.
    fn skip_body(&mut self) -> AlreadyReported {
        while !self.is(Token::End)
            && !self.word().is_some_and(|word| word.closes_declaration() || word.opens_declaration())
        {
            self.advance();
        }
        AlreadyReported
    }
}
