//! Broken texts: the codes and places of their findings, and that one fault is one finding.

use super::read;

/// `S0102 3:7` for each finding.
fn findings(text: &str) -> Vec<String> {
    let (_, _, findings) = read(text);
    let place = |finding: &document::Diagnostic| {
        assert!(!finding.message.is_empty() && !finding.message.ends_with('.'), "{}", finding.message);
        let before = &text[..finding.labels[0].span.start];
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().unwrap_or("").chars().count() + 1;
        format!("{} {line}:{column}", finding.code)
    };
    findings.iter().map(place).collect()
}

/// `> S0102 1:9`: what is expected of the text above it.
const CASES: &str = include_str!("broken.txt");

#[test]
fn faults_are_found_where_they_are() {
    let (mut text, mut wrong) = (String::new(), String::new());
    for line in CASES.lines().filter(|line| !line.starts_with("# ")) {
        let Some(expected) = line.strip_prefix('>') else {
            text.push_str(line);
            text.push('\n');
            continue;
        };
        let expected: Vec<&str> =
            expected.split(',').map(str::trim).filter(|code| !code.is_empty()).collect();
        if findings(&text) != expected {
            let (_, _, list) = read(&text);
            let messages: Vec<&str> = list.iter().map(|finding| finding.message.as_str()).collect();
            wrong.push_str(&format!(
                "{text}expected {expected:?}\nfound {:?} {messages:?}\n\n",
                findings(&text)
            ));
        }
        text.clear();
    }
    assert!(wrong.is_empty(), "{wrong}");
}

#[test]
fn findings_are_bounded() {
    let text = format!("PROGRAM p {} END_PROGRAM", "a b c; ".repeat(1000));
    let found = findings(&text);
    assert_eq!((found.len(), found.last().map(|last| &last[..5])), (51, Some("S0506")));
}

#[test]
fn unclosed_things_show_where_they_open() {
    let (_, _, findings) = read("PROGRAM p\n  IF a THEN\nEND_PROGRAM");
    let spans: Vec<_> = findings[0].labels.iter().map(|label| label.span.clone()).collect();
    assert_eq!(spans, [22..33, 12..14]);
}
