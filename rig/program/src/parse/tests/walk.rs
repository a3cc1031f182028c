//! Nothing is read and then ignored: random programs from the whole grammar are read without a finding, and what the
//! tree is written as has every token of the program.

use super::print::{Piece, print};
use super::read;
use std::collections::{BTreeMap, BTreeSet};

const GRAMMAR: &str = include_str!("grammar.txt");

/// How often an item of a rule is there.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
enum Times {
    Once,
    Optional,
    Any,
}

#[derive(Debug)]
enum Item {
    Rule(&'static str, Times),
    Text(Piece, Times),
}

type Rules = BTreeMap<&'static str, Vec<Vec<Item>>>;

fn rules() -> Rules {
    let lines: Vec<(&str, &str)> = GRAMMAR
        .lines()
        .filter(|line| !line.is_empty() && !line.starts_with('#'))
        .map(|line| line.split_once(" = ").unwrap())
        .collect();
    let known: BTreeSet<&str> = lines.iter().map(|line| line.0).collect();
    let item = |text: &'static str| {
        let (bare, times) = match text.strip_suffix('?') {
            Some(bare) => (bare, Times::Optional),
            None => match text.strip_suffix('*').filter(|bare| known.contains(bare)) {
                Some(bare) => (bare, Times::Any),
                None => (text, Times::Once),
            },
        };
        if known.contains(bare) {
            return Item::Rule(bare, times);
        }
        let counted = !bare.starts_with('~');
        Item::Text(Piece { text: bare.trim_start_matches('~').to_string(), counted }, times)
    };
    let alternatives = |body: &'static str| {
        body.split(" | ").map(|alternative| alternative.split_whitespace().map(item).collect()).collect()
    };
    lines.into_iter().map(|(name, body)| (name, alternatives(body))).collect()
}

struct Walk<'r> {
    rules: &'r Rules,
    random: u64,
    pieces: Vec<Piece>,
    /// Alternatives that were taken, and items that were there or not.
    seen: &'r mut BTreeSet<(&'static str, usize, usize, bool)>,
}

impl Walk<'_> {
    fn below(&mut self, n: usize) -> usize {
        self.random ^= self.random << 13;
        self.random ^= self.random >> 7;
        self.random ^= self.random << 17;
        (self.random >> 20) as usize % n
    }

    fn rule(&mut self, name: &'static str, depth: usize) {
        let rules = self.rules;
        let alternatives = &rules[name];
        // The deeper, the sooner it ends.
        let brief = depth > 14 || depth > 6 && self.below(3) > 0;
        let names = name == "new_name" || name == "plain_name";
        let choice = if brief && !names { 0 } else { self.below(alternatives.len()) };
        for (place, item) in alternatives[choice].iter().enumerate() {
            let (Item::Rule(_, times) | Item::Text(_, times)) = item;
            let count = match times {
                Times::Once => 1,
                _ if brief => 0,
                Times::Optional => self.below(2),
                Times::Any => self.below(4),
            };
            self.seen.insert((name, choice, place, count > 0));
            for _ in 0..count {
                match item {
                    Item::Rule(rule, _) => self.rule(rule, depth + 1),
                    Item::Text(piece, _) => self.pieces.push(piece.clone()),
                }
            }
        }
    }
}

/// What counts, in the spelling of the tree.
fn counted(pieces: &[Piece]) -> Vec<String> {
    let literal = |text: &str| text.contains(['\'', '"']) || text.contains('#') && !text.ends_with('#');
    pieces
        .iter()
        .filter(|piece| piece.counted)
        .map(|piece| match piece.text.as_str() {
            text if literal(text) || text.starts_with(|c: char| c.is_ascii_digit()) => text.to_string(),
            text => text.to_ascii_uppercase(),
        })
        .collect()
}

/// The text of a program, with remarks in between that say nothing.
fn text(pieces: &[Piece], mut remark: impl FnMut() -> &'static str) -> String {
    let mut text = String::new();
    for piece in pieces {
        text.push_str(&piece.text);
        text.push_str(remark());
    }
    text
}

/// The first finding with the text around it.
fn shown(findings: &[document::Diagnostic], source: &str) -> String {
    let at = findings[0].labels[0].span.start;
    let (from, to) = (source.floor_char_boundary(at.saturating_sub(200)), (at + 60).min(source.len()));
    format!(
        "{}: {} >>> {}",
        findings[0].message,
        &source[from..at],
        &source[at..source.floor_char_boundary(to)]
    )
}

#[test]
fn the_tree_has_every_token_of_the_grammar() {
    const REMARKS: [&str; 6] =
        ["\n", " (* a (* b *) ; *) ", " // END_IF '\n", " /* ( */ ", "{attribute 'x' := '(*'}", "\t\r\n"];
    let rules = rules();
    let mut seen = BTreeSet::new();
    for seed in 1..=4_000u64 {
        let mut walk = Walk {
            rules: &rules,
            random: seed.wrapping_mul(0x9E37_79B9_7F4A_7C15),
            pieces: Vec::new(),
            seen: &mut seen,
        };
        walk.rule("unit", 0);
        let pieces = std::mem::take(&mut walk.pieces);
        let source = text(&pieces, || match walk.below(8) {
            0 => REMARKS[walk.below(REMARKS.len())],
            _ => " ",
        });
        let (unit, names, findings) = read(&source);
        assert!(findings.is_empty(), "{}", shown(&findings, &source));
        let printed = print(&unit, &names);
        let (written, held) = (counted(&pieces), counted(&printed));
        if let Some(place) = (0..written.len().max(held.len())).find(|n| written.get(*n) != held.get(*n)) {
            let from = place.saturating_sub(8);
            panic!(
                "written {:?}\nheld {:?}",
                written.get(from..(place + 4).min(written.len())),
                held.get(from..(place + 4).min(held.len()))
            );
        }
        // What is written from the tree is the same tree.
        let source = text(&printed, || " ");
        let (again, names, findings) = read(&source);
        assert!(findings.is_empty(), "{}", shown(&findings, &source));
        assert_eq!(print(&again, &names), printed);
    }
    for (name, alternatives) in &rules {
        for (choice, items) in alternatives.iter().enumerate() {
            for (place, item) in items.iter().enumerate() {
                let (Item::Rule(_, times) | Item::Text(_, times)) = item;
                assert!(seen.contains(&(*name, choice, place, true)), "{name} {choice} {place}");
                let absent = seen.contains(&(*name, choice, place, false));
                assert!(*times == Times::Once || absent, "{name} {choice} {place}");
            }
        }
    }
}

/// Programs with one token missing or twice: one fault is seldom more than two findings.
#[test]
fn one_fault_is_few_findings() {
    let rules = rules();
    let mut seen = BTreeSet::new();
    let (mut few, mut many) = (0, 0);
    for seed in 1..=2_000u64 {
        let mut walk = Walk {
            rules: &rules,
            random: seed.wrapping_mul(0x9E37_79B9_7F4A_7C15),
            pieces: Vec::new(),
            seen: &mut seen,
        };
        walk.rule("unit", 0);
        let mut pieces = std::mem::take(&mut walk.pieces);
        if pieces.is_empty() {
            continue;
        }
        let place = walk.below(pieces.len());
        match walk.below(2) {
            0 => drop(pieces.remove(place)),
            _ => pieces.insert(place, pieces[place].clone()),
        }
        let (_, _, findings) = read(&text(&pieces, || "\n"));
        match findings.len() {
            0..=2 => few += 1,
            _ => many += 1,
        }
    }
    assert!(few > 20 * many, "{few} with few, {many} with many");
}
