//! Findings as a person reads them.

use annotate_snippets::renderer::DecorStyle;
use annotate_snippets::{
    Annotation, AnnotationKind, Group, Level, Renderer, Snippet, normalize_untrusted_str,
};

use crate::place::floor;
use crate::{Diagnostic, DiagnosticLabel, Severity, SourceFile, line_col};

/// Lines longer than this are not shown: no window shows them, and drawing them takes long.
const MAX_LINE: usize = 2_000;

/// Writes findings with the lines of the user's files that they speak of, one below the other.
///
/// `color` adds ANSI colours. A label whose file is not among `sources` is given as a name only.
pub fn render(found: &[Diagnostic], sources: &[SourceFile], color: bool) -> String {
    let renderer = if color { Renderer::styled() } else { Renderer::plain() };
    let renderer = renderer.decor_style(DecorStyle::Ascii);
    let mut text = String::new();
    for one in found {
        if !text.is_empty() {
            text.push('\n');
        }
        text.push_str(&renderer.render(&[group(one, sources)]));
        text.push('\n');
    }
    text
}

fn group<'a>(one: &'a Diagnostic, sources: &'a [SourceFile]) -> Group<'a> {
    let level = match one.severity {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
    };
    let mut group = level
        .primary_title(normalize_untrusted_str(&one.message))
        .id(one.code)
        .elements(Vec::<Snippet<'a, Annotation<'a>>>::new());
    // One snippet for each file, in the order in which the labels name them.
    let mut shown: Vec<&str> = Vec::new();
    for (place, label) in one.labels.iter().enumerate() {
        if shown.contains(&label.file.as_str()) {
            continue;
        }
        shown.push(&label.file);
        match sources.iter().find(|source| source.name == label.file) {
            Some(source) => group = snippets(group, one, place, source),
            None => {
                let name = normalize_untrusted_str(&label.file);
                group = group.element(annotate_snippets::Origin::path(name));
            }
        }
    }
    if !one.help.is_empty() {
        group = group.element(Level::HELP.message(normalize_untrusted_str(&one.help)));
    }
    group
}

/// Draws the labels of one file; the label at `first` is where the finding stands.
fn snippets<'a>(
    mut group: Group<'a>,
    one: &'a Diagnostic,
    first: usize,
    source: &'a SourceFile,
) -> Group<'a> {
    let mut snippet = Snippet::source(source.text.as_str()).path(source.name.as_str());
    let mut drawn = false;
    for (place, label) in one.labels.iter().enumerate().skip(first) {
        if label.file != source.name {
            continue;
        }
        let span = clamp(&source.text, label);
        if line_length(&source.text, span.start) > MAX_LINE {
            let (line, column) = line_col(&source.text, span.start);
            let origin = annotate_snippets::Origin::path(source.name.as_str()).line(line).char_column(column);
            group = group.element(origin);
            continue;
        }
        let kind = if place == 0 { AnnotationKind::Primary } else { AnnotationKind::Context };
        let mut annotation = kind.span(span);
        if !label.text.is_empty() {
            annotation = annotation.label(label.text.as_str());
        }
        snippet = snippet.annotation(annotation);
        drawn = true;
    }
    if drawn { group.element(snippet) } else { group }
}

/// The label's bytes, held inside the text and within one line and whole characters.
fn clamp(text: &str, label: &DiagnosticLabel) -> std::ops::Range<usize> {
    let start = floor(text, label.span.start);
    let mut end = floor(text, label.span.end.max(start));
    if let Some(line_end) = text[start..end].find('\n') {
        // A table over many lines is shown by its first line.
        end = start + line_end;
    }
    start..end.max(start)
}

fn line_length(text: &str, byte: usize) -> usize {
    let start = text[..byte].rfind('\n').map_or(0, |at| at + 1);
    let end = text[byte..].find('\n').map_or(text.len(), |at| byte + at);
    end - start
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_finding_shows_code_place_and_mend() {
        let file = SourceFile::new("a.toml", "format = 1\nsginal = \"x\"\n");
        let found = Diagnostic::error("P0101", "unknown key `sginal`")
            .at("a.toml", 11..17, "not a key of a plan")
            .help("did you mean `signal`?");
        let text = render(&[found], &[file], false);
        for part in ["error[P0101]: unknown key `sginal`", "a.toml:2:1", "^^^^^^", "did you mean `signal`?"] {
            assert!(text.contains(part), "{part} is missing in:\n{text}");
        }
    }

    proptest! {
        // Spans of other texts, or into the middle of characters, must never panic.
        #[test]
        fn no_place_panics(text in "\\PC{0,20}(\n\\PC{0,20}){0,3}", start in 0usize..90, length in 0usize..90) {
            let found = Diagnostic::error("P0101", text.clone())
                .at("a", start..start + length, "here")
                .at("a", length..start, "there")
                .at("b", 0..1, "elsewhere");
            let _ = render(&[found], &[SourceFile::new("a", text)], false);
        }
    }
}
