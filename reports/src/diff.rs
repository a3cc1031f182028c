//! What changed between two runs, for a terminal.

use crate::show::clean;
use crate::text::Style;
use record::{CaseChange, Comparison, Figure, GuardChange, TextChange};
use std::fmt::Write;

/// The most entries of one list that are shown.
const MOST: usize = 50;

/// The comparison in words: what got worse first, the counts last.
pub fn render(found: &Comparison, style: Style) -> String {
    let mut out = DiffText { text: String::new(), style };
    let (worse, others): (Vec<&CaseChange>, Vec<&CaseChange>) =
        found.cases.iter().partition(|case| case.worse);
    out.list("Worse", "31;1", &worse, case);
    let lost: Vec<_> = found.claims.iter().filter(|claim| claim.missing).collect();
    out.list("Claims that are missing", "31;1", &lost, |claim| {
        vec![format!("{}: {}", claim.case, claim.name)]
    });
    out.list("Margins that eroded", "31;1", &found.eroded.iter().collect::<Vec<_>>(), |one| {
        vec![
            format!("{}: {}", one.case, one.name),
            format!("{} became {}, {:.1} % lost", one.old, one.new, one.lost_percent),
        ]
    });
    out.list(
        "Traces that differ though nothing else does",
        "33;1",
        &found.traces.iter().collect::<Vec<_>>(),
        |name| vec![(*name).clone()],
    );
    let guard = |change: &GuardChange| {
        vec![
            format!("{}: {}", change.case, change.name),
            format!("guard {} became {}", change.old, change.new),
        ]
    };
    let (unproven, guards): (Vec<&GuardChange>, Vec<&GuardChange>) =
        found.guards.iter().partition(|change| change.worse);
    out.list("Proven before, now accepted by its middle", "31;1", &unproven, guard);
    out.list("Other changes of cases", "1", &others, case);
    let new: Vec<_> = found.claims.iter().filter(|claim| !claim.missing).collect();
    out.list("New claims", "1", &new, |claim| vec![format!("{}: {}", claim.case, claim.name)]);
    out.list("Values that moved", "1", &found.moved.iter().collect::<Vec<_>>(), |one| {
        let value = |[low, high]: [f64; 2]| {
            let figure = |value| Figure::new(value, one.unit.as_str()).to_string();
            if low == high { figure(low) } else { format!("{} .. {}", figure(low), figure(high)) }
        };
        vec![format!("{}: {}", one.case, one.name), format!("{} became {}", value(one.old), value(one.new))]
    });
    out.list("Guard bands that changed", "1", &guards, guard);
    out.list("Files that changed", "1", &found.files.iter().collect::<Vec<_>>(), |change| {
        vec![change.what.clone()]
    });
    out.list("Facts that changed", "1", &found.facts.iter().collect::<Vec<_>>(), fact);
    out.text.push_str(&summary(found));
    out.text
}

struct DiffText {
    text: String,
    style: Style,
}

impl DiffText {
    fn list<T>(&mut self, title: &str, color: &str, entries: &[&T], lines: impl Fn(&T) -> Vec<String>) {
        if entries.is_empty() {
            return;
        }
        let title =
            if self.style.color { format!("\u{1b}[{color}m{title}\u{1b}[0m") } else { title.to_owned() };
        // Writing to a String cannot fail.
        let _ = writeln!(self.text, "{title}");
        for entry in entries.iter().take(MOST) {
            for (place, line) in lines(entry).into_iter().filter(|line| !line.is_empty()).enumerate() {
                let indent = if place == 0 { 2 } else { 6 };
                let _ = writeln!(self.text, "{:indent$}{}", "", clean(&line));
            }
        }
        if entries.len() > MOST {
            let _ = writeln!(self.text, "  and {} more (`--format json` has all)", entries.len() - MOST);
        }
        self.text.push('\n');
    }
}

fn case(change: &CaseChange) -> Vec<String> {
    let head = match (change.old, change.new) {
        (Some(old), Some(new)) => format!("{}: {old} became {new}", change.name),
        (Some(old), None) => format!("{}: missing, was {old}", change.name),
        (None, Some(new)) => format!("{}: new, {new}", change.name),
        (None, None) => change.name.clone(),
    };
    vec![head, change.reason.clone()]
}

fn fact(change: &TextChange) -> Vec<String> {
    let short = |text: &str| if text.is_empty() { "none".to_owned() } else { text.to_owned() };
    vec![change.what.clone(), format!("{} became {}", short(&change.old), short(&change.new))]
}

fn summary(found: &Comparison) -> String {
    let count = |wanted: &dyn Fn(&CaseChange) -> bool| found.cases.iter().filter(|case| wanted(case)).count();
    let both = |case: &CaseChange| case.old.is_some() && case.new.is_some();
    let worse = count(&|case| both(case) && case.worse);
    let better = count(&|case| both(case) && !case.worse);
    let missing = count(&|case| case.new.is_none());
    let new = count(&|case| case.old.is_none());
    let word = if found.worse { "worse" } else { "not worse" };
    format!(
        "Summary: {word}; {} cases the same, {worse} worse, {better} better, {missing} missing, {new} new, {} margins eroded\n",
        found.same,
        found.eroded.len()
    )
}
