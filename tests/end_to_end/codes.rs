//! Every code that the rig can report has a row in the documents, with its title.

use crate::project_folder::root;

#[test]
fn every_code_has_a_row() {
    let text = std::fs::read_to_string(root().join("docs/codes.md")).unwrap();
    let mut missing = Vec::new();
    for (code, title) in [
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
    {
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
    let known = [
        plans::CODES,
        drivers::CODES,
        program::CODES,
        runtime::CODES,
        guard::CODES,
        control::CODES,
        services::CODES,
        dash::CODES,
    ]
    .concat();
    // The codes of records are those of `record::RecordError` and of the page.
    let known = |code: &str| code.starts_with("R04") || known.iter().any(|(one, _)| *one == code);
    let unknown: Vec<&&str> = codes.iter().filter(|code| !known(code)).collect();
    assert!(unknown.is_empty(), "{unknown:?}");
}
