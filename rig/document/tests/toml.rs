//! TOML texts: places, what TOML 1.0 does not allow, hints, bounds.

use proptest::prelude::*;
use scanrig_document::{Codes, Data, Fields, Findings, KeySpec, KeyType, SourceFile, Table, line_col, toml};

const CODES: Codes = Codes {
    syntax: "T1",
    newer_toml: "T2",
    too_large: "T3",
    unknown_key: "T4",
    missing_key: "T5",
    wrong_type: "T6",
    unreadable: "T7",
};

fn file(text: &str) -> SourceFile {
    SourceFile::new("t.toml", text)
}

fn read(text: &str) -> Table {
    toml::parse(&file(text), CODES).unwrap_or_else(|found| panic!("{text}: {found:?}"))
}

/// Code, line, column and help of every finding.
fn refused(text: &str) -> Vec<(&'static str, usize, usize, String)> {
    let found = toml::parse(&file(text), CODES).expect_err(text);
    let place = |at: usize| line_col(text, at);
    found
        .into_iter()
        .map(|one| {
            let (line, column) = place(one.labels[0].span.start);
            (one.code, line, column, one.help)
        })
        .collect()
}

#[test]
fn values_know_their_places() {
    let text = "b = \"x y\"\na = { d = 1, c = [true, 2.50] }\n[t.u]\n\"k k\" = '''\nraw'''\n";
    let root = read(text);
    let keys: Vec<&str> = root.entries.iter().map(|entry| entry.key.as_str()).collect();
    assert_eq!(keys, ["b", "a", "t"], "the order of the file is kept");
    let node = root.get("b").unwrap();
    assert_eq!(&text[node.span.clone()], "\"x y\"");
    assert_eq!(&text[node.inner(2..3)], "y");
    let inner = root.get("a").unwrap().as_table().unwrap();
    assert_eq!(inner.entries[0].key, "d");
    let list = inner.get("c").unwrap().as_array().unwrap();
    assert_eq!(list[1].data, Data::Float("2.50".into()));
    assert_eq!(&text[list[1].span.clone()], "2.50");
    let raw = root.get("t").unwrap().as_table().unwrap().get("u").unwrap().as_table().unwrap();
    assert_eq!(&text[raw.get("k k").unwrap().inner(0..3)], "raw");
}

#[test]
fn integers_of_more_than_64_bits_keep_their_digits() {
    let root = read("a = 18_446_744_073_709_551_615\nb = -9223372036854775809\nc = 9223372036854775807");
    let data = |key: &str| root.get(key).unwrap().data.clone();
    assert_eq!(data("a"), Data::Float("18446744073709551615".into()));
    assert_eq!(root.get("a").unwrap().kind(), "an integer of more than 64 bits");
    assert_eq!(data("b"), Data::Float("-9223372036854775809".into()));
    assert_eq!(data("c"), Data::Integer(i64::MAX));
    assert_eq!(refused("a = 0xFFFF_FFFF_FFFF_FFFF_F")[0].0, "T1");
}

// With escapes the places inside the text are not known: the whole value is shown.
#[test]
fn a_text_with_escapes_is_shown_whole() {
    let text = "a = \"x\\ty\"";
    let root = read(text);
    assert_eq!(root.get("a").unwrap().inner(0..1), 4..10);
}

#[test]
fn novelties_of_toml_1_1_are_refused() {
    assert_eq!(refused("a = {\n  b = 1 }")[0].0, "T2");
    assert_eq!(
        refused("a = { b = 1, }")[0],
        ("T2", 1, 12, "TOML 1.0 does not allow it: remove the comma".into())
    );
    assert_eq!(refused("a = \"\\e[0m\"")[0].0, "T2");
    assert_eq!(refused("a = \"\\x41\"")[0].0, "T2");
    read("a = { b = [\n 1,\n 2,\n] }");
    read("a = \"\\\\e\"");
}

#[test]
fn several_errors_come_in_one_run() {
    let found = refused("a = 10 ms\nb = RUNNING\nc = TRUE\nc = 1\n");
    let places: Vec<(usize, &str)> = found.iter().map(|one| (one.1, one.3.as_str())).collect();
    assert!(places.contains(&(1, "a number with a unit is a text: write \"10 ms\"")), "{places:?}");
    assert!(places.contains(&(2, "a text needs quotes: write \"RUNNING\"")), "{places:?}");
    assert!(places.contains(&(3, "write true")), "{places:?}");
    assert!(places.iter().any(|(line, _)| *line == 4), "a key given twice: {places:?}");
}

#[test]
fn sizes_are_bounded() {
    assert_eq!(refused(&"#".repeat((1 << 20) + 1))[0].0, "T3");
    assert_eq!(refused(&"[".repeat(100_000))[0].0, "T3");
    assert_eq!(refused(&format!("{} = 1", "a.".repeat(100_000)))[0].0, "T3");
    assert!(refused(&"= 1\n".repeat(10_000)).len() <= scanrig_document::MAX_FINDINGS);
}

const INNER: &[KeySpec] = &[KeySpec::required("lasts", KeyType::Duration, "How long.")];
const KEYS: &[KeySpec] = &[
    KeySpec::required("signal", KeyType::SignalRef, "The signal."),
    KeySpec::optional("times", KeyType::Integer(1, 10), "How often."),
    KeySpec::optional("mode", KeyType::Choice(&["keep", "default"]), "What happens."),
    KeySpec::optional("cut", KeyType::Table(INNER), "A cut."),
    KeySpec::optional("files", KeyType::OneOrMore(&KeyType::Text), "Files."),
    KeySpec::optional("on", KeyType::Bool, "Whether."),
];

fn check(text: &str) -> Vec<(&'static str, String)> {
    let root = read(text);
    let mut out = Findings::new(&file(text), CODES);
    Fields::check(&root, 0..0, "step", KEYS, &mut out);
    out.into_vec().into_iter().map(|one| (one.code, one.help)).collect()
}

#[test]
fn a_table_is_held_against_its_keys() {
    assert_eq!(
        check("signal = \"a\"\ntimes = 3\nmode = \"keep\"\ncut = { lasts = \"1 s\" }\nfiles = \"a\""),
        []
    );
    assert_eq!(check("signal = \"a\"\nfiles = [\"a\", \"b\"]"), []);
    assert_eq!(check("")[0], ("T5", "add `signal`: the signal".into()));
    assert_eq!(check("sginal = \"a\"\nsignal = \"a\"")[0], ("T4", "did you mean `signal`?".into()));
    assert_eq!(check("signal = \"a\"\ntimes = 11")[0].0, "T7");
    assert_eq!(check("signal = \"a\"\ntimes = 1e1")[0].0, "T6");
    assert_eq!(check("signal = \"a\"\nmode = \"kepe\"")[0], ("T7", "did you mean \"keep\"?".into()));
    assert_eq!(check("signal = \"a\"\ncut = { lasts = 5 }")[0].0, "T6");
    assert_eq!(check("signal = \"a\"\ncut = { lasts = 00:00:05 }")[0].0, "T6");
    assert_eq!(check("signal = \"a\"\ncut = { lasts = \"5 sec\" }")[0].0, "T7");
    assert_eq!(check("signal = \"a\"\non = \"true\"")[0], ("T6", "write true without quotes".into()));
    assert_eq!(check("signal = \"\"")[0].0, "T7");
    assert_eq!(check("signal = \"a\"\nfiles = []")[0].0, "T6");
}

#[test]
fn wrong_values_are_not_handed_out() {
    let root = read("signal = 1\ntimes = 3\ncut = {}");
    let mut out = Findings::new(&file(""), CODES);
    let fields = Fields::check(&root, 0..0, "step", KEYS, &mut out);
    assert_eq!((fields.text("signal"), fields.integer("times")), (None, Some(3)));
    assert!(fields.has("cut") && fields.inner("cut").is_none());
}

proptest! {
    #[test]
    fn no_text_panics(text in "\\PC*", near in "([a-c.]{1,3}|=|\\[|\\]|\\{|\\}|,|\"|'|\"\"\"|'''|\n|#|\\\\e|1|-|\u{e9}){0,24}") {
        for text in [text, near] {
            match toml::parse(&file(&text), CODES) {
                Ok(root) => {
                    for entry in &root.entries {
                        prop_assert!(text.get(entry.key_span.clone()).is_some());
                        prop_assert!(text.get(entry.node.span.clone()).is_some());
                    }
                }
                Err(found) => prop_assert!(!scanrig_document::render(&found, &[file(&text)], false).is_empty()),
            }
        }
    }
}
