//! The collector of findings.

use std::ops::Range;

use crate::{Diagnostic, DiagnosticLabel, Node, SourceFile};

/// Most findings that one reading keeps; what comes later is counted only.
pub const MAX_FINDINGS: usize = 50;

/// The codes under which a reader reports what every TOML file can have wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Codes {
    /// The text is no TOML.
    pub syntax: &'static str,
    /// TOML 1.1 accepts it, TOML 1.0 and its editors do not.
    pub newer_toml: &'static str,
    /// The file is larger or deeper than a hand-written one can be.
    pub too_large: &'static str,
    /// A key that no table of keys has.
    pub unknown_key: &'static str,
    /// A required key is not there.
    pub missing_key: &'static str,
    /// A value of another type than the key's.
    pub wrong_type: &'static str,
    /// A text that does not read as the duration, quantity or choice that the key takes.
    pub unreadable: &'static str,
}

/// What is wrong with one file, in the order found. Holds at most [`MAX_FINDINGS`].
#[derive(Clone, Debug)]
pub struct Findings {
    file: String,
    codes: Codes,
    list: Vec<Diagnostic>,
    errors: usize,
    /// What is added to every finding: whose part is looked at.
    context: Vec<DiagnosticLabel>,
}

impl Findings {
    /// None yet for this file.
    pub fn new(file: &SourceFile, codes: Codes) -> Self {
        Findings { file: file.name.clone(), codes, list: Vec::new(), errors: 0, context: Vec::new() }
    }

    /// An empty collector for the same file, with the same codes and context.
    pub fn none_yet(&self) -> Self {
        Findings {
            file: self.file.clone(),
            codes: self.codes,
            list: Vec::new(),
            errors: 0,
            context: self.context.clone(),
        }
    }

    /// From now on adds these places to every finding: what led to what is looked at. None ends that.
    pub fn set_context(&mut self, places: impl IntoIterator<Item = (Range<usize>, String)>) {
        let label = |(span, text)| DiagnosticLabel { file: self.file.clone(), span, text };
        self.context = places.into_iter().map(label).collect();
    }

    /// The codes of this reader.
    pub fn codes(&self) -> Codes {
        self.codes
    }

    /// Name of the file.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// Keeps a finding. One that says the same about the same place as an earlier one is dropped: the cases
    /// of a plan often fail alike.
    pub fn push(&mut self, mut found: Diagnostic) {
        found.labels.extend(self.context.iter().cloned());
        self.errors += usize::from(found.is_error());
        if self.list.len() < MAX_FINDINGS && !self.list.contains(&found) {
            self.list.push(found);
        }
    }

    /// Reports an error at a place of the file; `label` says what stands there.
    pub fn error(
        &mut self,
        code: &'static str,
        span: Range<usize>,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        let found = Diagnostic::error(code, message).at(self.file.clone(), span, "").help(help);
        self.push(found);
    }

    /// Reports a warning at a place of the file.
    pub fn warn(
        &mut self,
        code: &'static str,
        span: Range<usize>,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        let found = Diagnostic::warning(code, message).at(self.file.clone(), span, "").help(help);
        self.push(found);
    }

    /// Reports an error about a value, with the place that gave the value if a `$reference` stands there.
    pub fn bad(
        &mut self,
        code: &'static str,
        node: &Node,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        self.bad_inside(code, node, None, message, help);
    }

    /// Reports an error about some bytes of a text's content (`None` = all of it).
    pub fn bad_inside(
        &mut self,
        code: &'static str,
        node: &Node,
        within: Option<Range<usize>>,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        let span = within.map_or_else(|| node.span.clone(), |within| node.inner(within));
        let found = self.with_origin(Diagnostic::error(code, message), node, span).help(help);
        self.push(found);
    }

    /// Adds the place of a value and the place that gave it.
    fn with_origin(&self, found: Diagnostic, node: &Node, span: Range<usize>) -> Diagnostic {
        let Some(origin) = &node.origin else { return found.at(self.file.clone(), span, "") };
        let shown = match node.as_text() {
            Some(text) => format!("here it reads \"{}\"", shorten(text)),
            None => String::from("the value stands for a reference"),
        };
        let found = found.at(self.file.clone(), node.span.clone(), shown);
        match &origin.span {
            Some(given) => {
                found.at(self.file.clone(), given.clone(), format!("${} comes from here", origin.name))
            }
            None => found,
        }
    }

    /// Whether something was kept under this code at this place: says whether to report it once more in other
    /// words.
    pub fn reported(&self, code: &str, span: &Range<usize>) -> bool {
        self.list.iter().any(|one| one.code == code && one.labels.first().is_some_and(|at| at.span == *span))
    }

    /// Counts an error that was reported before in other words, so that its file is refused.
    pub fn count_again(&mut self) {
        self.errors += 1;
    }

    /// Whether an error was reported, kept or not.
    pub fn has_errors(&self) -> bool {
        self.errors > 0
    }

    /// How many errors were reported.
    pub fn errors(&self) -> usize {
        self.errors
    }

    /// Whether no more will be kept.
    pub fn is_full(&self) -> bool {
        self.list.len() >= MAX_FINDINGS
    }

    /// The findings by place, then by code.
    pub fn into_vec(mut self) -> Vec<Diagnostic> {
        self.list.sort_by_key(|found| {
            let start = found.labels.first().map_or(0, |label| label.span.start);
            (start, found.code)
        });
        self.list
    }
}

/// A text of the user short enough for a message.
fn shorten(text: &str) -> String {
    if text.chars().count() <= 60 {
        return text.to_owned();
    }
    text.chars().take(57).chain("...".chars()).collect()
}
