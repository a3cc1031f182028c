//! `refused` and `warned`: a case whose check must find something. It passes by that and never runs.

use std::ops::Range;

use document::{Diagnostic, Fields, Findings, KeySpec, KeyType, Node};

use super::envelope::row_names;
use super::read::PlanDocument;
use super::variants::Variant;
use crate::codes;
use crate::lang::substitute;

/// The two keys: errors, and warnings where there is no error.
const REFUSED: &str = "refused";
const WARNED: &str = "warned";

/// The keys of both.
pub(super) const REFUSAL_KEYS: &[KeySpec] = &[
    KeySpec::required("code", KeyType::Text, "The code of what the check finds."),
    KeySpec::optional(
        "says",
        KeyType::OneOrMore(&KeyType::Text),
        "Texts that the findings hold, each of them one at least.",
    ),
    KeySpec::optional("errors", KeyType::Integer(1, 50), "How many there are."),
    KeySpec::optional("rows", KeyType::List(&KeyType::Text), "The rows that it holds for; all if left out."),
];

/// What the check of a case must find.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExpectedRefusal {
    /// The code of every error, or of the warnings that are meant.
    pub code: String,
    /// Whether warnings are meant, and no error may be found.
    pub warning: bool,
    /// Texts that the findings must hold.
    pub says: Vec<String>,
    /// How many there must be.
    pub errors: Option<usize>,
    /// What was found when the plan was read, where the code is one of the plan language.
    pub found: Vec<Diagnostic>,
    /// Bytes of the plan.
    pub span: Range<usize>,
    /// Line of the plan, from 1.
    pub line: u32,
}

impl ExpectedRefusal {
    /// Whether it is the reader of plans that must refuse.
    pub(super) fn is_of_the_plan(&self) -> bool {
        self.code.starts_with('P') && !self.warning
    }

    /// What is expected, in words.
    pub fn expected(&self) -> String {
        let count = self.errors.map_or_else(String::new, |count| format!("{count} of "));
        let does = if self.warning { "warns of it" } else { "refuses it" };
        let texts: Vec<String> = self.says.iter().map(|text| format!("`{text}`")).collect();
        let says = if texts.is_empty() { String::new() } else { format!(" saying {}", texts.join(", ")) };
        format!("the check {does}: {count}{}{says}", self.code)
    }

    /// Holds what the check found against what it must find: what was observed, or why it is something else.
    ///
    /// # Errors
    /// What is missing, or wrong in another way.
    pub fn judge(&self, found: &[Diagnostic]) -> Result<String, String> {
        // Every error counts, but only those warnings that are meant.
        let meant = |one: &&Diagnostic| one.is_error() || self.warning && one.code == self.code;
        let errors: Vec<&Diagnostic> = found.iter().filter(meant).collect();
        let Some(first) = errors.first() else {
            return Err(match self.warning {
                true => format!("the check does not warn of {}", self.code),
                false => String::from("nothing is refused: the check finds no error"),
            });
        };
        if let Some(other) = errors.iter().find(|one| one.code != self.code || one.is_error() == self.warning)
        {
            return Err(format!("refused otherwise: {}: {}", other.code, other.message));
        }
        for text in &self.says {
            let holds = |one: &&Diagnostic| {
                one.message.contains(text)
                    || one.help.contains(text)
                    || one.labels.iter().any(|label| label.text.contains(text))
            };
            if !errors.iter().any(holds) {
                return Err(format!(
                    "no finding says `{text}`; the first is {}: {}",
                    first.code, first.message
                ));
            }
        }
        if let Some(count) = self.errors.filter(|count| *count != errors.len()) {
            return Err(format!("{} findings in place of {count}", errors.len()));
        }
        let more = if errors.len() > 1 { format!(" (one of {})", errors.len()) } else { String::new() };
        Ok(format!("{}: {}{more}", first.code, first.message))
    }
}

/// Whether the plan has the key.
pub(super) fn is_there(root: &document::Table) -> bool {
    [REFUSED, WARNED].iter().any(|key| root.get(key).is_some())
}

/// What the check of this case must find; `Err` after what is wrong with the key was reported.
pub(super) fn read(
    document: &PlanDocument,
    variant: &Variant<'_>,
    out: &mut Findings,
) -> Result<Option<ExpectedRefusal>, ()> {
    let before = out.errors();
    let (key, node) = match (document.head.get(REFUSED), document.head.get(WARNED)) {
        (Some(node), None) => (REFUSED, node),
        (None, Some(node)) => (WARNED, node),
        (None, None) => return Ok(None),
        (Some(_), Some(node)) => {
            let message = "a plan has `refused` or `warned`, not both";
            out.error(codes::CLAIM, node.span.clone(), message, "write two plans");
            return Err(());
        }
    };
    let node = substitute(node, &variant.bindings(), out).into_owned();
    let Some(table) = node.as_table() else {
        // The table of the plan's keys says so.
        return Ok(None);
    };
    let fields = Fields::check(table, node.span.clone(), &format!("table `{key}`"), REFUSAL_KEYS, out);
    let row = variant.row.map(|row| row.name.as_str());
    if let Some(rows) = fields.get("rows") {
        let known = document.variants.rows.iter().map(|row| row.name.as_str()).collect();
        let rows = row_names(rows, &known, out);
        if out.errors() == before && !row.is_some_and(|row| rows.contains(row)) {
            return Ok(None);
        }
    }
    let code = fields.get("code").map(|node| (node, node.as_text().unwrap_or_default()));
    if let Some((node, code)) = code.filter(|(_, code)| !is_code(code)) {
        let message = format!("`{code}` is not the code of a finding");
        out.bad(codes::UNREADABLE, node, message, "write it as in code = \"R0113\"");
    }
    let (true, Some((_, code))) = (out.errors() == before, code) else { return Err(()) };
    Ok(Some(ExpectedRefusal {
        code: code.to_owned(),
        warning: key == WARNED,
        says: fields.each("says").iter().filter_map(Node::as_text).map(str::to_owned).collect(),
        errors: fields.integer("errors").and_then(|count| usize::try_from(count).ok()),
        found: Vec::new(),
        span: node.span.clone(),
        line: document.line(node.span.start),
    }))
}

/// `P`, `R`, `S` or `B` and four digits.
fn is_code(text: &str) -> bool {
    let mut letters = text.chars();
    letters.next().is_some_and(|first| "BPRS".contains(first))
        && text.len() == 5
        && letters.all(|one| one.is_ascii_digit())
}
