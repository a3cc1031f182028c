//! What the manual says of verdicts: each sentence that speaks of passing, failing, being inconclusive or of a verdict
//! stands in `verdicts.toml`, with the tests that would fail if it were not true, or with the reason why it says nothing
//! of a verdict. Whoever changes the sentence finds the tests, and whoever removes a test the sentence.

use std::collections::BTreeMap;

use document::{Node, SourceFile};

use crate::manual::links::anchor;
use crate::manual::markdown::{Page, page, pages};
use crate::project_folder::root;

/// The words that make a sentence one about verdicts.
const WORDS: [&str; 11] = [
    "pass",
    "passes",
    "passed",
    "fail",
    "fails",
    "failed",
    "failure",
    "failures",
    "inconclusive",
    "verdict",
    "verdicts",
];

const LIST: &str = "tests/end_to_end/manual/verdicts.toml";

/// The pages that say how verdicts come about, what makes them open or errors, and where they are shown.
fn read_pages() -> Vec<Page> {
    let others = ["plans", "terminal", "reports", "boards", "control", "realtime", "requirements"].map(page);
    ["plans", "boards"].into_iter().flat_map(pages).chain(others).collect()
}

fn is_about_verdicts(text: &str) -> bool {
    text.split(|letter: char| !letter.is_alphanumeric())
        .any(|word| WORDS.iter().any(|known| word.eq_ignore_ascii_case(known)))
}

/// An entry of the list.
struct Entry {
    /// The page with the anchor of the heading, as a link has it.
    section: String,
    /// A part of one sentence there.
    words: String,
    /// Tests that would fail if that were not true; none if the sentence says nothing of a verdict.
    tests: Vec<String>,
}

fn entries() -> Vec<Entry> {
    let text = std::fs::read_to_string(root().join(LIST)).unwrap();
    let list = document::toml::parse(&SourceFile::new(LIST, text), plans::TOML).expect("a list that reads");
    let mut entries = Vec::new();
    for section in &list.entries {
        let sentences = section.node.as_table().expect("a table for each section");
        for sentence in &sentences.entries {
            let named = sentence.node.as_array();
            let tests =
                named.map(|tests| tests.iter().filter_map(Node::as_text).map(str::to_owned).collect());
            let reason = sentence.node.as_text().is_some_and(|reason| !reason.is_empty());
            let tests: Vec<String> = tests.unwrap_or_default();
            let place = format!("{LIST}: {}: `{}`", section.key, sentence.key);
            assert!(reason == tests.is_empty(), "{place}: name tests in a list, or give a reason as a text");
            entries.push(Entry { section: section.key.clone(), words: sentence.key.clone(), tests });
        }
    }
    entries
}

/// The sentences about verdicts, by the sections that they stand in.
fn sentences() -> BTreeMap<String, Vec<String>> {
    let mut found: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for page in read_pages() {
        for (heading, sentence) in page.each_sentence() {
            if is_about_verdicts(&sentence) {
                found.entry(format!("{}#{}", page.name, anchor(heading))).or_default().push(sentence);
            }
        }
    }
    found
}

#[test]
fn every_sentence_about_a_verdict_has_its_tests() {
    let (sentences, entries) = (sentences(), entries());
    assert!(sentences.values().flatten().count() > 80, "the sentences are not read");
    let mut wrong = Vec::new();
    for (section, sentences) in &sentences {
        for sentence in sentences {
            let has = |entry: &&Entry| entry.section == *section && sentence.contains(&entry.words);
            if !entries.iter().any(|entry| has(&entry)) {
                wrong.push(format!(
                    "docs/{section}: `{sentence}` has no entry: add one below [\"{section}\"] in {LIST}, with a \
                     test that fails if the sentence is not true"
                ));
            }
        }
    }
    for Entry { section, words, .. } in &entries {
        let count = sentences.get(section).into_iter().flatten().filter(|text| text.contains(words)).count();
        if count != 1 || !is_about_verdicts(words) {
            wrong.push(format!(
                "{LIST}: `{words}` stands in {count} sentences about verdicts of docs/{section}: quote so much of one \
                 sentence, with its word about the verdict, that it is the only one; where the sentence changed, see \
                 whether its tests are still the right ones"
            ));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Why a test that the list names is none, if it is none.
fn missing(test: &str) -> Option<String> {
    let (file, name) = test.split_once("::").unwrap_or((test, ""));
    let Ok(text) = std::fs::read_to_string(root().join(file)) else {
        return Some(format!("there is no file {file}"));
    };
    let is_test = if file.ends_with(".rs") {
        has_test(&text, name)
    } else if file.ends_with(".py") {
        text.contains(&format!("\ndef {name}("))
    } else if file.starts_with("plans/tests/goldens/") {
        text.lines().any(|line| line.strip_prefix("# ") == Some(name))
    } else {
        // Plans that the tests run with their verdicts: those of the library all pass.
        let run = file.starts_with("plans/library/") || file.starts_with("tests/verdicts/");
        run && name.is_empty() && text.contains("\ntitle = ")
    };
    (!is_test).then(|| format!("{file} has no test `{name}`"))
}

/// Whether a source has a function of this name that is a test and not left out: those of the lab run there.
fn has_test(source: &str, name: &str) -> bool {
    let lines: Vec<&str> = source.lines().map(str::trim).collect();
    let Some(place) = lines.iter().position(|line| line.starts_with(&format!("fn {name}("))) else {
        return false;
    };
    let before =
        lines[..place].iter().rev().take_while(|line| line.starts_with("#[") || line.starts_with("//"));
    let attributes: Vec<&&str> = before.collect();
    let is_left_out =
        |line: &&&str| line.starts_with("#[ignore") && !line.starts_with("#[ignore = \"in the lab: ");
    attributes.iter().any(|line| **line == "#[test]") && !attributes.iter().any(is_left_out)
}

#[test]
fn every_test_that_the_list_names_is_there() {
    let mut wrong = Vec::new();
    for Entry { section, words, tests } in entries() {
        for fault in tests.iter().filter_map(|test| missing(test)) {
            wrong.push(format!(
                "{LIST}: docs/{section}, `{words}`: {fault}: name the test that fails if the sentence is not true"
            ));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn what_is_no_test_is_noticed() {
    assert!(
        is_about_verdicts("Inconclusive also as `stays`.")
            && !is_about_verdicts("It bypasses a failing one.")
    );
    let source = "#[test]\n/// Words.\nfn one() {}\nfn two() {}\n#[test]\n#[ignore = \"slow\"]\nfn three() {}\n\
                  #[test]\n#[ignore = \"in the lab: tests/lab/devices\"]\nfn five() {}\n";
    assert_eq!(
        ["one", "two", "three", "four", "five"].map(|name| has_test(source, name)),
        [true, false, false, false, true]
    );
    for test in [
        "plans/tests/none.rs::a",
        "plans/tests/goldens/ends.txt::none",
        "plans/library/none.toml",
        "README.md",
    ] {
        assert!(missing(test).is_some(), "{test}");
    }
}
