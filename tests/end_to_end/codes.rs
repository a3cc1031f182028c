//! Every code that the rig can report has a row in the documents, with its title, and a page that says what it means.

use crate::project_folder::root;

/// The codes of all registers, with their titles.
fn registered() -> Vec<(&'static str, &'static str)> {
    [
        plans::CODES,
        drivers::CODES,
        program::CODES,
        runtime::CODES,
        guard::CODES,
        control::CODES,
        services::CODES,
        dash::CODES,
    ]
    .concat()
}

#[test]
fn every_code_has_a_row() {
    let text = std::fs::read_to_string(root().join("docs/codes.md")).unwrap();
    let mut missing = Vec::new();
    for (code, title) in registered() {
        let row = format!("| {code} | {title} |");
        if !text.lines().any(|line| line.starts_with(&row)) {
            missing.push(row);
        }
    }
    assert!(missing.is_empty(), "docs/codes.md lacks\n{}", missing.join("\n"));
}

#[test]
fn the_rows_are_in_order_and_of_codes_that_exist() {
    let text = std::fs::read_to_string(root().join("docs/codes.md")).unwrap();
    let codes: Vec<&str> =
        text.lines().filter_map(|line| line.strip_prefix("| ")?.split(' ').next()).collect();
    let codes: Vec<&str> =
        codes.into_iter().filter(|code| code.len() == 5 && code.ends_with(char::is_numeric)).collect();
    for pair in codes.windows(2) {
        assert!(pair[0][..1] != pair[1][..1] || pair[0] < pair[1], "{} before {}", pair[0], pair[1]);
    }
    let known = registered();
    // The codes of records are those of `record::RecordError` and of the page.
    let known = |code: &str| code.starts_with("R04") || known.iter().any(|(one, _)| *one == code);
    let unknown: Vec<&&str> = codes.iter().filter(|code| !known(code)).collect();
    assert!(unknown.is_empty(), "{unknown:?}");
}

// `rig explain` shows the page: one that is missing leaves the reader with the title.
#[test]
fn every_code_has_a_page_with_words() {
    let text =
        |letter: &str| std::fs::read_to_string(root().join(format!("docs/codes/{letter}.md"))).unwrap();
    let mut missing = Vec::new();
    for (code, _) in registered() {
        let text = text(&code[..1]);
        let page = text.split(&format!("## {code}\n")).nth(1).unwrap_or_default();
        if page.split("\n## ").next().unwrap_or_default().trim().is_empty() {
            missing.push(code);
        }
    }
    assert!(missing.is_empty(), "docs/codes lacks pages of {missing:?}");
}
