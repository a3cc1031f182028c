//! `--only EXPR`: which cases of a selection run.
//!
//! ```text
//! expr   = term { "or" term }
//! term   = factor { ["and"] factor }
//! factor = "not" factor | "(" expr ")" | word
//! word   = text | ("name" | "title" | "proves" | "tag" | "profile") ":" text
//! ```
//! A bare text means `name:`. Names and titles match where they hold the text, in any case; requirements match
//! whole, or up to a `*`; tags whole; words with blanks stand in double quotes.

pub mod shard;

use crate::exit::ExitStatus;
use crate::output;
use runtime::suite::Job;
use std::fmt;

/// What a case is selected by.
#[derive(Clone, Copy, Debug)]
pub struct CaseFacts<'a> {
    /// Name of the case.
    pub name: &'a str,
    /// Title of its plan.
    pub title: &'a str,
    /// Requirements that it proves.
    pub proves: &'a [String],
    /// Tags of its plan.
    pub tags: &'a [String],
    /// Profile that it runs with.
    pub profile: &'a str,
}

impl<'a> CaseFacts<'a> {
    /// The facts of a case that is to run.
    pub fn of(job: &'a Job) -> CaseFacts<'a> {
        CaseFacts {
            name: &job.name,
            title: &job.title,
            proves: &job.proves,
            tags: &job.tags,
            profile: job.profile.name(),
        }
    }
}

/// A parsed expression.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Selection {
    /// Every case.
    All,
    /// The name holds this.
    Name(String),
    /// The title holds this.
    Title(String),
    /// It proves this requirement.
    Proves(String),
    /// It has this tag.
    Tag(String),
    /// It runs with this profile.
    Profile(String),
    /// Not this.
    Not(Box<Selection>),
    /// Both.
    And(Box<Selection>, Box<Selection>),
    /// One or both.
    Or(Box<Selection>, Box<Selection>),
}

/// What is wrong with an expression, and at which byte.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SelectionError {
    /// Byte of the expression.
    pub at: usize,
    /// What is wrong.
    pub message: &'static str,
}

impl fmt::Display for SelectionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} (at character {})", self.message, self.at + 1)
    }
}

/// Brackets and `not`s that may be open at once.
const DEEPEST: usize = 64;

impl Selection {
    /// Reads an expression.
    ///
    /// # Errors
    /// [`SelectionError`] with the place.
    pub fn parse(text: &str) -> Result<Selection, SelectionError> {
        let tokens = tokens(text)?;
        let mut reader = SelectionParser { tokens: &tokens, at: 0, end: text.len(), depth: 0 };
        let selection = reader.expression()?;
        match reader.peek() {
            None => Ok(selection),
            Some(token) => Err(SelectionError { at: token.at, message: "a word or an end is expected here" }),
        }
    }

    /// As [`Selection::parse`], of what the command line gives.
    ///
    /// # Errors
    /// How the command ends; why is printed.
    pub fn of(text: &str) -> Result<Selection, ExitStatus> {
        Selection::parse(text).map_err(|error| {
            output::refuse(
                "R0227",
                format!("--only {text}: {error}"),
                "as in `lamp`, `tag:slow and not motor`, `proves:io:DI-*`",
            )
        })
    }

    /// Whether a case is selected.
    pub fn matches(&self, case: &CaseFacts<'_>) -> bool {
        let holds = |text: &str, part: &str| text.to_lowercase().contains(&part.to_lowercase());
        match self {
            Selection::All => true,
            Selection::Name(part) => holds(case.name, part),
            Selection::Title(part) => holds(case.title, part),
            Selection::Proves(id) => case.proves.iter().any(|proven| match id.strip_suffix('*') {
                Some(start) => proven.starts_with(start),
                None => proven == id,
            }),
            Selection::Tag(tag) => case.tags.iter().any(|known| known == tag),
            Selection::Profile(name) => case.profile == name,
            Selection::Not(inner) => !inner.matches(case),
            Selection::And(a, b) => a.matches(case) && b.matches(case),
            Selection::Or(a, b) => a.matches(case) || b.matches(case),
        }
    }
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum TokenKind {
    Open,
    Close,
    Word(String),
    /// In quotes: never an operator.
    Quoted(String),
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct NameToken {
    at: usize,
    kind: TokenKind,
}

fn tokens(text: &str) -> Result<Vec<NameToken>, SelectionError> {
    let mut tokens = Vec::new();
    let mut chars = text.char_indices().peekable();
    while let Some((at, c)) = chars.next() {
        let kind = match c {
            c if c.is_whitespace() => continue,
            '(' => TokenKind::Open,
            ')' => TokenKind::Close,
            '"' => {
                let word: String = chars.by_ref().map(|(_, c)| c).take_while(|c| *c != '"').collect();
                let closed = text[at + 1 + word.len()..].starts_with('"');
                if !closed {
                    return Err(SelectionError { at, message: "these quotes are never closed" });
                }
                TokenKind::Quoted(word)
            }
            first => {
                let mut word = String::from(first);
                // Square brackets and blanks inside quotes after a colon belong to the word: `title:"a b"`.
                let mut quoted = false;
                while let Some((_, c)) = chars.peek().copied() {
                    if c == '"' {
                        quoted = !quoted;
                        chars.next();
                        continue;
                    }
                    if !quoted && (c.is_whitespace() || c == '(' || c == ')') {
                        break;
                    }
                    word.push(c);
                    chars.next();
                }
                if quoted {
                    return Err(SelectionError { at, message: "quotes in this word are never closed" });
                }
                TokenKind::Word(word)
            }
        };
        tokens.push(NameToken { at, kind });
    }
    Ok(tokens)
}

struct SelectionParser<'a> {
    tokens: &'a [NameToken],
    at: usize,
    end: usize,
    depth: usize,
}

impl<'a> SelectionParser<'a> {
    fn peek(&self) -> Option<&'a NameToken> {
        self.tokens.get(self.at)
    }

    fn takes(&mut self, word: &str) -> bool {
        let found =
            matches!(self.peek(), Some(NameToken { kind: TokenKind::Word(next), .. }) if next == word);
        self.at += usize::from(found);
        found
    }

    fn expression(&mut self) -> Result<Selection, SelectionError> {
        let mut all = self.term()?;
        while self.takes("or") {
            all = Selection::Or(Box::new(all), Box::new(self.term()?));
        }
        Ok(all)
    }

    fn term(&mut self) -> Result<Selection, SelectionError> {
        let mut all = self.factor()?;
        loop {
            let joined = self.takes("and");
            let stops = match self.peek() {
                None | Some(NameToken { kind: TokenKind::Close, .. }) => true,
                Some(NameToken { kind: TokenKind::Word(word), .. }) => word == "or",
                _ => false,
            };
            if stops && !joined {
                return Ok(all);
            }
            all = Selection::And(Box::new(all), Box::new(self.factor()?));
        }
    }

    fn factor(&mut self) -> Result<Selection, SelectionError> {
        let Some(token) = self.peek() else {
            return Err(SelectionError { at: self.end, message: "a word is missing at the end" });
        };
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(SelectionError { at: token.at, message: "nested too deeply" });
        }
        self.at += 1;
        let selection = match &token.kind {
            TokenKind::Open => {
                let inner = self.expression()?;
                match self.peek() {
                    Some(NameToken { kind: TokenKind::Close, .. }) => self.at += 1,
                    _ => {
                        return Err(SelectionError { at: token.at, message: "this bracket is never closed" });
                    }
                }
                inner
            }
            TokenKind::Close => {
                return Err(SelectionError { at: token.at, message: "nothing is open to be closed" });
            }
            TokenKind::Word(word) if word == "not" => Selection::Not(Box::new(self.factor()?)),
            TokenKind::Word(word) if word == "and" || word == "or" => {
                return Err(SelectionError { at: token.at, message: "a word is missing before this" });
            }
            TokenKind::Quoted(word) => Selection::Name(word.clone()),
            TokenKind::Word(word) => match word.split_once(':') {
                None => Selection::Name(word.clone()),
                Some(("name", part)) => Selection::Name(part.to_owned()),
                Some(("title", part)) => Selection::Title(part.to_owned()),
                Some(("proves", part)) => Selection::Proves(part.to_owned()),
                Some(("tag", part)) => Selection::Tag(part.to_owned()),
                Some(("profile", part)) => Selection::Profile(part.to_owned()),
                Some(_) => {
                    let message = "unknown kind: use name:, title:, proves:, tag: or profile:";
                    return Err(SelectionError { at: token.at, message });
                }
            },
        };
        self.depth -= 1;
        Ok(selection)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn selects(expression: &str, name: &str) -> bool {
        let proves = [String::from("controller:WD-04")];
        let tags = [String::from("slow")];
        let case = CaseFacts {
            name,
            title: "The watchdog trips",
            proves: &proves,
            tags: &tags,
            profile: "m241-2019",
        };
        Selection::parse(expression).unwrap().matches(&case)
    }

    #[test]
    fn expressions_select() {
        assert!(selects("watchdog", "watchdog/fallback[over]"));
        assert!(selects("fallback[over]", "watchdog/fallback[over]"));
        assert!(!selects("not fallback", "watchdog/fallback[over]"));
        assert!(selects("fallback and under or over", "watchdog/fallback[over]"));
        assert!(!selects("fallback (under or exactly)", "watchdog/fallback[over]"));
        assert!(selects("proves:controller:WD-*", "x"));
        assert!(!selects("proves:controller:WD-0", "x"));
        assert!(selects("tag:slow", "x") && !selects("tag:slo", "x"));
        assert!(selects("title:\"watchdog trips\"", "x"));
        assert!(selects("profile:m241-2019 x", "x"));
        assert!(selects("\"or\"", "for"));
    }

    #[test]
    fn faults_name_their_place() {
        let fault = |text| Selection::parse(text).unwrap_err().at;
        assert_eq!(fault(""), 0);
        assert_eq!(fault("a and"), 5);
        assert_eq!(fault("(a"), 0);
        assert_eq!(fault("a)"), 1);
        assert_eq!(fault("or a"), 0);
        assert_eq!(fault("kind:a"), 0);
        assert_eq!(fault("a \"b"), 2);
        assert!(Selection::parse(&"(".repeat(100_000)).is_err());
    }
}
