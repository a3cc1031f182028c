//! Broken programs: each says in its first line which codes are expected, and where.

use document::{Diagnostic, SourceFile};
use scanrig_program::{CODES, Options, compile};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

fn programs() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/broken");
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

fn findings(path: &Path) -> (String, Vec<Diagnostic>) {
    let text = std::fs::read_to_string(path).unwrap();
    let name = path.file_name().unwrap().to_string_lossy().into_owned();
    let result = compile(&[SourceFile { name, text: text.clone() }], &Options::default());
    (text, result.err().unwrap_or_default())
}

/// `S0102 3:7` for a finding.
fn place(text: &str, finding: &Diagnostic) -> String {
    let start = finding.labels[0].span.start;
    let before = &text[..start];
    let line = before.matches('\n').count() + 1;
    let column = before.rsplit('\n').next().unwrap_or("").chars().count() + 1;
    format!("{} {line}:{column}", finding.code)
}

#[test]
fn broken_programs_are_refused_where_they_are_broken() {
    let mut wrong = Vec::new();
    for path in programs() {
        let (text, findings) = findings(&path);
        let first = text.lines().next().unwrap();
        let expected = first.trim_start_matches("(* expect ").trim_end_matches(" *)");
        let mut expected: Vec<String> = expected.split(", ").map(str::to_string).collect();
        let mut found: Vec<String> = findings.iter().map(|finding| place(&text, finding)).collect();
        expected.sort();
        found.sort();
        if expected != found {
            let messages: Vec<String> =
                findings.iter().map(|f| format!("{}: {} ({})", place(&text, f), f.message, f.help)).collect();
            wrong.push(format!("{}\nexpected {expected:?}\n{}", path.display(), messages.join("\n")));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}

#[test]
fn findings_are_complete() {
    let mut seen = BTreeSet::new();
    for path in programs() {
        let (text, findings) = findings(&path);
        for finding in findings {
            assert!(CODES.iter().any(|(code, _)| *code == finding.code), "{}", finding.code);
            assert!(!finding.message.is_empty() && !finding.message.ends_with('.'), "{}", finding.message);
            assert!(!finding.labels.is_empty());
            for label in &finding.labels {
                assert!(text.get(label.span.clone()).is_some(), "{finding:?}");
            }
            seen.insert(finding.code);
        }
    }
    // What the broken programs do not show is shown elsewhere: sizes, depths and warnings.
    let elsewhere = [
        "S0107", "S0109", "S0112", "S0215", "S0216", "S0306", "S0309", "S0310", "S0411", "S0501", "S0502",
        "S0503", "S0504", "S0505", "S0506",
    ];
    for (code, title) in CODES {
        assert!(seen.contains(code) || elsewhere.contains(code), "no broken program shows {code}: {title}");
    }
}
