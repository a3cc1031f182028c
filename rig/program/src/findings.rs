//! Collects findings, with their places, up to a limit.

use crate::codes::Code;
use document::{Diagnostic, DiagnosticLabel, Severity, SourceFile};

/// A place in a source: bytes `start..end` of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct SourcePlace {
    pub file: u16,
    pub start: u32,
    pub end: u32,
}

impl SourcePlace {
    /// From the start of this to the end of `last`.
    pub fn to(self, last: SourcePlace) -> SourcePlace {
        SourcePlace { end: last.end.max(self.end), ..self }
    }
}

/// The findings of a compilation.
#[derive(Debug)]
pub(crate) struct CompileFindings<'a> {
    sources: &'a [SourceFile],
    list: Vec<Diagnostic>,
    errors: usize,
    limit: usize,
    /// Warnings are bounded by themselves.
    warnings: usize,
}

impl<'a> CompileFindings<'a> {
    pub fn new(sources: &'a [SourceFile], limit: usize) -> Self {
        CompileFindings { sources, list: Vec::new(), errors: 0, limit: limit.max(1), warnings: 0 }
    }

    pub fn error(
        &mut self,
        code: Code,
        at: SourcePlace,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        self.error_at(code, at, "", message, help, None);
    }

    /// An error with a second place and what is to be said of it.
    pub fn error_with(
        &mut self,
        code: Code,
        at: SourcePlace,
        message: impl Into<String>,
        help: impl Into<String>,
        other: (SourcePlace, &str),
    ) {
        self.error_at(code, at, "", message, help, Some(other));
    }

    fn error_at(
        &mut self,
        code: Code,
        at: SourcePlace,
        text: &str,
        message: impl Into<String>,
        help: impl Into<String>,
        other: Option<(SourcePlace, &str)>,
    ) {
        if self.full() {
            return;
        }
        self.errors += 1;
        let mut labels = vec![self.label(at, text)];
        labels.extend(other.map(|(at, text)| self.label(at, text)));
        self.push(code, Severity::Error, message.into(), labels, help.into());
        if self.full() {
            let labels = vec![self.label(at, "")];
            let message = format!("the compilation gives up after {} errors", self.limit);
            self.push(Code::TooMany, Severity::Error, message, labels, "fix the errors above first".into());
        }
    }

    pub fn warning(
        &mut self,
        code: Code,
        at: SourcePlace,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        // More warnings than errors are tolerable: they may all be of one habit.
        if self.warnings < self.limit.saturating_mul(4) {
            self.warnings += 1;
            let labels = vec![self.label(at, "")];
            self.push(code, Severity::Warning, message.into(), labels, help.into());
        }
    }

    fn push(
        &mut self,
        code: Code,
        severity: Severity,
        message: String,
        labels: Vec<DiagnosticLabel>,
        help: String,
    ) {
        self.list.push(Diagnostic { code: code.text(), severity, message, labels, help });
    }

    fn label(&self, at: SourcePlace, text: &str) -> DiagnosticLabel {
        let file = self.sources.get(usize::from(at.file)).map_or(String::new(), |source| source.name.clone());
        DiagnosticLabel { file, span: at.start as usize..at.end as usize, text: text.to_string() }
    }

    /// Whether an error was reported inside a place already.
    pub fn reported_within(&self, at: SourcePlace) -> bool {
        let Some(file) = self.sources.get(usize::from(at.file)) else { return false };
        let span = at.start as usize..at.end as usize;
        self.list.iter().rev().take(8).any(|finding| {
            finding.severity == Severity::Error
                && finding.labels.first().is_some_and(|label| {
                    label.file == file.name && span.start <= label.span.start && label.span.end <= span.end
                })
        })
    }

    /// Whether no more errors are taken.
    pub fn full(&self) -> bool {
        self.errors >= self.limit
    }

    pub fn failed(&self) -> bool {
        self.errors > 0
    }

    /// The findings in the order of the sources.
    pub fn finish(mut self) -> Vec<Diagnostic> {
        let sources = self.sources;
        let place = |d: &Diagnostic| {
            let label = d.labels.first();
            let file = label.and_then(|l| sources.iter().position(|s| s.name == l.file));
            (d.code == Code::TooMany.text(), file, label.map(|l| l.span.start))
        };
        self.list.sort_by_key(place);
        self.list
    }
}

/// `1 input`, `2 inputs`.
pub(crate) fn count(n: impl TryInto<u32>, what: &str) -> String {
    let n = n.try_into().unwrap_or(u32::MAX);
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}

/// The name of `known` that is at most two slips of the keyboard from `name`, both in capitals.
pub(crate) fn similar<'k>(name: &str, known: impl Iterator<Item = &'k str>) -> Option<String> {
    let allowed = match name.len() {
        0 | 1 => 0,
        2 | 3 => 1,
        _ => 2,
    };
    known
        .filter(|k| k.len().abs_diff(name.len()) <= allowed)
        .map(|k| (distance(name.as_bytes(), k.as_bytes()), k))
        .filter(|(distance, _)| *distance <= allowed)
        .min()
        .map(|(_, k)| k.to_string())
}

/// Edit distance with swaps of neighbours.
fn distance(a: &[u8], b: &[u8]) -> usize {
    let (mut before, mut last) = (vec![0; b.len() + 1], (0..=b.len()).collect::<Vec<_>>());
    for i in 1..=a.len() {
        let mut row = vec![i; b.len() + 1];
        for j in 1..=b.len() {
            let same = usize::from(a[i - 1] != b[j - 1]);
            row[j] = (last[j] + 1).min(row[j - 1] + 1).min(last[j - 1] + same);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                row[j] = row[j].min(before[j - 2] + 1);
            }
        }
        before = std::mem::replace(&mut last, row);
    }
    last[b.len()]
}

#[cfg(test)]
mod tests {
    use super::similar;

    #[test]
    fn near_names_are_suggested() {
        let known = ["COUNT", "LAMP", "N"];
        let near = |name| similar(name, known.into_iter());
        assert_eq!(near("CUONT").as_deref(), Some("COUNT"));
        assert_eq!(near("LMAP").as_deref(), Some("LAMP"));
        assert_eq!(near("PUMP").as_deref(), Some("LAMP"));
        assert_eq!(near("MOTOR"), None);
        assert_eq!(near("XY"), None);
    }
}
