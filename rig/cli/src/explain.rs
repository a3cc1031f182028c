//! `rig explain`: what a code means, an example and the fix; what the catalogue says of a module.

use crate::code_pages::{self, CodePage, ExampleRole};
use crate::exit::ExitStatus;
use crate::paragraph::wrap;
use crate::{module_page, output};
use clap::Args;
use document::{Diagnostic, suggest};
use std::fmt::Write;

/// A code that no register has, or a module that the catalogue has not.
const UNKNOWN: &str = "R0152";

/// What lists the modules of the catalogue.
const MODULES: &str = "modules";

/// `rig explain`.
#[derive(Debug, Args)]
pub struct ExplainArgs {
    /// The code of a finding, as in P0102, or the reference of a module, as in TM3AI4; `modules` lists those. All codes
    /// with their titles if left out.
    #[arg(value_name = "CODE|MODULE")]
    code: Option<String>,
}

/// Prints the page of a code or module, or a list of all codes or modules.
pub fn run(args: &ExplainArgs) -> ExitStatus {
    let pages = code_pages::all();
    let Some(given) = &args.code else {
        pages.iter().for_each(|page| output::print(&format!("{}  {}\n", page.code, page.title)));
        return ExitStatus::Passed;
    };
    let code = given.trim().to_ascii_uppercase();
    if code.eq_ignore_ascii_case(MODULES) {
        output::print(&module_page::list());
        return ExitStatus::Passed;
    }
    if let Some(module) = catalogue::find(&code) {
        output::print(&module_page::show(module));
        return ExitStatus::Passed;
    }
    match pages.iter().find(|page| page.code == code) {
        Some(page) => {
            output::print(&show(page));
            ExitStatus::Passed
        }
        None => {
            output::findings(&[unknown(given, &code, &pages)], &[]);
            ExitStatus::UserFiles
        }
    }
}

fn unknown(given: &str, code: &str, pages: &[CodePage<'_>]) -> Diagnostic {
    const LISTS: &str = "`rig explain` lists all codes, `rig explain modules` all modules";
    let found = Diagnostic::error(UNKNOWN, format!("there is no code or module `{given}`"));
    let known = pages.iter().map(|page| page.code);
    match suggest(code, known.chain(catalogue::modules().iter().map(|module| module.reference.as_str()))) {
        Some(near) => found.help(format!("did you mean `{near}`? {LISTS}")),
        None => found.help(format!("a code is a letter and four digits, as in P0102; {LISTS}")),
    }
}

/// The page as a person reads it.
fn show(page: &CodePage<'_>) -> String {
    let mut text = format!("{}: {}\n", page.code, page.title);
    for paragraph in page.meaning.split("\n\n").filter(|paragraph| !paragraph.is_empty()) {
        let _ = write!(text, "\n{}", wrap(&plain(paragraph)));
    }
    let refused = if page.is_warning() { "This gives a warning" } else { "This is refused" };
    for example in &page.examples {
        let words = match example.role {
            ExampleRole::With => "With",
            ExampleRole::Wrong => refused,
            ExampleRole::Right => "This is right",
        };
        let _ = write!(text, "\n{words}:\n\n");
        for line in example.text.lines() {
            let _ = writeln!(text, "    {line}");
        }
    }
    let _ = write!(text, "\n{}", wrap(&format!("Fix: {}", plain(page.fix))));
    text
}

/// Links of Markdown as words with the file after them: `[needs](plans/cases.md#needs)` is `needs
/// (docs/plans/cases.md#needs)`. Targets are relative to the table of codes, or to the pages of codes, a folder below.
fn plain(text: &str) -> String {
    let mut plain = String::new();
    let mut rest = text;
    while let Some((before, words, target, after)) = link(rest) {
        let target = target.strip_prefix("../").unwrap_or(target);
        let _ = write!(plain, "{before}{words} (docs/{target})");
        rest = after;
    }
    plain + rest
}

/// What stands before a link, its words, its target, and what follows it.
fn link(text: &str) -> Option<(&str, &str, &str, &str)> {
    let middle = text.find("](")?;
    let start = text[..middle].rfind('[')?;
    let end = middle + text[middle..].find(')')?;
    Some((&text[..start], &text[start + 1..middle], &text[middle + 2..end], &text[end + 1..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_name_their_file() {
        assert_eq!(
            plain("Use [needs](plans/cases.md#needs); `a[1]` stays."),
            "Use needs (docs/plans/cases.md#needs); `a[1]` stays."
        );
        assert_eq!(plain("as a [file](../boards/file.md) says"), "as a file (docs/boards/file.md) says");
        assert_eq!(plain("an `x](` alone"), "an `x](` alone");
    }
}
