//! The pages of the codes, made of the documents that are built in: title and fix stand in the list of codes, meaning
//! and examples in one file for each letter. A code that only the list has, has a page without an example.

/// The list of codes.
const LIST: &str = include_str!("../../../docs/codes.md");
/// What the codes mean, a file for each letter.
const MEANINGS: [&str; 4] = [
    include_str!("../../../docs/codes/P.md"),
    include_str!("../../../docs/codes/B.md"),
    include_str!("../../../docs/codes/S.md"),
    include_str!("../../../docs/codes/R.md"),
];

/// What the list says of the fix where the finding is no error.
const WARNING: &str = "warning";

/// All that is to be said of a code.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CodePage<'a> {
    pub code: &'a str,
    pub title: &'a str,
    pub fix: &'a str,
    /// Paragraphs; empty where nothing is to be said beyond the title.
    pub meaning: &'a str,
    pub examples: Vec<Example<'a>>,
}

/// An example, or a part of one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Example<'a> {
    pub role: ExampleRole,
    pub text: &'a str,
}

/// What an example is there for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExampleRole {
    /// What the next block works with.
    With,
    /// It provokes the code.
    Wrong,
    /// The same without the fault.
    Right,
}

impl CodePage<'_> {
    /// Whether the finding refuses nothing.
    pub fn is_warning(&self) -> bool {
        self.fix.split_whitespace().take(3).any(|word| word.trim_end_matches([':', ',']) == WARNING)
    }
}

/// The pages in the order of the list.
pub fn all() -> Vec<CodePage<'static>> {
    LIST.lines()
        .filter_map(row)
        .map(|(code, title, fix)| {
            let (meaning, examples) =
                MEANINGS.iter().find_map(|text| section(text, code)).unwrap_or_default();
            CodePage { code, title, fix, meaning, examples }
        })
        .collect()
}

/// The code as the pages have it: whoever hears of a code at run time can show it as a finding.
pub fn registered(code: &str) -> Option<&'static str> {
    all().iter().map(|page| page.code).find(|registered| *registered == code)
}

/// `| P0102 | A key is missing | Add the key. |`
fn row(line: &str) -> Option<(&str, &str, &str)> {
    let (code, rest) = line.strip_prefix("| ")?.split_once(" | ")?;
    let (title, fix) = rest.strip_suffix(" |")?.split_once(" | ")?;
    is_code(code).then_some((code, title, fix))
}

fn is_code(text: &str) -> bool {
    let bytes = text.as_bytes();
    bytes.len() == 5 && bytes[0].is_ascii_uppercase() && bytes[1..].iter().all(u8::is_ascii_digit)
}

/// The paragraphs and the examples below the heading of a code.
fn section<'t>(text: &'t str, code: &str) -> Option<(&'t str, Vec<Example<'t>>)> {
    let heading = format!("\n## {code}\n");
    let start = text.find(&heading)? + heading.len();
    let body = &text[start..];
    let body = &body[..body.find("\n## ").unwrap_or(body.len())];
    let end = body.find("```").unwrap_or(body.len());
    let mut examples = Vec::new();
    let mut rest = &body[end..];
    while let Some((_, after)) = rest.split_once("```") {
        let (info, after) = after.split_once('\n')?;
        let (text, after) = after.split_once("\n```")?;
        let role = match info.rsplit(' ').next() {
            Some("with") => ExampleRole::With,
            Some("right") => ExampleRole::Right,
            _ => ExampleRole::Wrong,
        };
        examples.push(Example { role, text });
        rest = after;
    }
    Some((body[..end].trim(), examples))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_is_joined_of_list_and_examples() {
        assert_eq!(row("| P0102 | A key | Add `a | b`. |"), Some(("P0102", "A key", "Add `a | b`.")));
        assert_eq!(row("| code | title | fix |"), None);
        let text = "# T\n\n## P0101\n\nOne.\n\n## P0102\n\nIt means\nthis.\n\n```toml wrong\na = 1\n```\n\n```toml right\nb = 1\n```\n";
        let (meaning, examples) = section(text, "P0102").unwrap();
        assert_eq!(meaning, "It means\nthis.");
        assert_eq!(
            examples,
            [
                Example { role: ExampleRole::Wrong, text: "a = 1" },
                Example { role: ExampleRole::Right, text: "b = 1" }
            ]
        );
        assert_eq!(section(text, "P0101"), Some(("One.", Vec::new())));
        assert_eq!(section(text, "P0103"), None);
    }
}
