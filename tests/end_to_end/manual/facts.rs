//! Verbs, powers, figures, units, codes and options: what the manual names is there, and what is there is named.

use std::collections::BTreeSet;

use crate::manual::markdown::{Table, code, manual, page};
use crate::project_folder::{TestProject, root};
use plans::signals::TaskFigure;
use plans::{expect, lang, steps};
use signal::Quantity;

fn table(name: &str, heading: &str, header: &str) -> Table {
    let tables = page(name).tables();
    let found = tables.into_iter().find(|table| table.heading == heading && table.header == header);
    found.unwrap_or_else(|| {
        panic!("docs/{name}.md has no table below `{heading}` that begins with `{header}`")
    })
}

/// The names of the rows of a table; where a page writes more than one in a cell, each.
fn named(table: &Table) -> Vec<&str> {
    table.rows.iter().flat_map(|row| &row.names).map(String::as_str).collect()
}

fn sorted<'a>(names: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    let mut names: Vec<&str> = names.into_iter().collect();
    names.sort_unstable();
    names
}

#[test]
fn every_stimulus_has_a_row_with_what_it_needs() {
    let table = table("plans/stimuli", "Stimuli", "verb");
    assert_eq!(sorted(named(&table)), sorted(steps::VERBS.iter().map(|verb| verb.name)));
    let mut wrong = Vec::new();
    for row in &table.rows {
        // The last cell; a bound stands beside its word.
        let cells = row.rest.trim_end().trim_end_matches('|');
        let cell = cells.rsplit('|').next().unwrap();
        let words: BTreeSet<&str> = code(cell).filter_map(|word| word.split(' ').next()).collect();
        for verb in steps::VERBS.iter().filter(|verb| row.names.iter().any(|name| name == verb.name)) {
            let needs: BTreeSet<&str> = verb.needs.iter().copied().collect();
            // How fast the pulses are, the step says.
            let said: BTreeSet<&str> = words.iter().copied().filter(|word| *word != "pulse").collect();
            if said != needs && !verb.needs.contains(&"pulse") {
                wrong.push(format!("docs/{}: `{}` needs {needs:?}", row.place, verb.name));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_expectation_has_a_row_and_a_section_with_its_keys() {
    let table = table("plans/expectations", "Expectations", "verb");
    assert_eq!(sorted(named(&table)), sorted(expect::VERBS.iter().map(|verb| verb.name)));
    let shared = self::table("plans/expectations", "Expectations", "key");
    let shared = named(&shared);
    let pages = [page("plans/expectations"), page("plans/pulses"), page("plans/frames")];
    let mut wrong = Vec::new();
    for verb in expect::VERBS {
        let of = |heading: &str| heading.split([',', ' ']).any(|word| word == verb.name);
        let found = pages.iter().find_map(|page| {
            let heading = page.headings().into_iter().find(|heading| of(heading))?;
            Some(page.section(heading))
        });
        let Some(section) = found else {
            wrong.push(format!("`{}` has no section", verb.name));
            continue;
        };
        let said: BTreeSet<&str> =
            code(&section).map(|code| code.split(' ').next().unwrap_or(code)).collect();
        let keys = verb.keys.iter().map(|key| key.name);
        // The keys of a pulse train have their table with `position`.
        let elsewhere = |key: &str| shared.contains(&key) || section.contains("(#position)");
        let missing = keys.filter(|key| !said.contains(key) && !elsewhere(key));
        wrong.extend(missing.map(|key| format!("the section of `{}` lacks `{key}`", verb.name)));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_power_has_a_row() {
    let table = table("plans/cases", "Needs", "power");
    let words = table.rows.iter().flat_map(|row| &row.names).filter_map(|name| name.split(' ').next());
    assert_eq!(sorted(words), sorted(lang::CAPABILITIES.iter().map(|power| power.word)));
}

#[test]
fn every_figure_of_a_task_is_named() {
    let page = page("plans/signals").text;
    let missing = TaskFigure::NAMES.iter().filter(|name| !code(&page).any(|code| code == **name));
    assert_eq!(missing.collect::<Vec<_>>(), Vec::<&&str>::new());
}

// What stands in one row is converted; what stands in two is not.
#[test]
fn units_of_one_kind_are_converted() {
    let table = table("plans/values", "Values, durations, ranges, instants", "kind");
    let mut firsts: Vec<String> = Vec::new();
    let mut compared = 0;
    for row in &table.rows {
        // Several kinds in a row are parted by commas.
        for kind in row.rest.trim_end_matches('|').split("`, ") {
            let units: Vec<&str> = kind.split('`').map(str::trim).filter(|unit| !unit.is_empty()).collect();
            let of = |unit: &str| Quantity::parse(&format!("1 {unit}")).unwrap();
            let converts = |from: &str, to: &str| of(from).in_unit(&of(to).unit).is_some();
            for unit in &units {
                // Nothing is converted to minutes, hours and days.
                assert!(converts(unit, units[0]), "{}: `{unit}` to `{}`", row.place, units[0]);
                compared += 1;
            }
            for other in &firsts {
                assert!(!converts(units[0], other), "{}: `{}` to `{other}`", row.place, units[0]);
            }
            firsts.push(units[0].to_owned());
        }
    }
    assert!(compared > 45, "{compared}");
}

#[test]
fn every_code_of_the_manual_exists() {
    let listed = TestProject::new().expect(0, &["explain"]).out;
    let known: BTreeSet<&str> = listed.lines().filter_map(|line| line.get(..5)).collect();
    let is_code = |word: &str| {
        word.len() == 5
            && word.starts_with(['P', 'B', 'S', 'R', 'G'])
            && word[1..].bytes().all(|byte| byte.is_ascii_digit())
    };
    let mut unknown = Vec::new();
    for page in manual() {
        for line in page.text.lines() {
            let words = line.split(|char: char| !char.is_ascii_alphanumeric());
            let words = words.filter(|word| is_code(word) && !known.contains(word));
            unknown.extend(words.map(|word| format!("docs/{}.md: {word}", page.name)));
        }
    }
    assert!(unknown.is_empty(), "{unknown:?}");
}

// An option that was renamed or that never was: the completions of the shell have all that there are.
#[test]
fn every_option_of_the_manual_exists() {
    let completions = TestProject::new().expect(0, &["completions", "bash"]).out;
    let options = |text: &str| -> Vec<String> {
        let words = text.split([' ', '"', '=', '`', '|', ',', ')', '[', ']']);
        words.filter(|word| word.starts_with("--") && word.len() > 3).map(str::to_owned).collect()
    };
    let known: BTreeSet<String> = options(&completions).into_iter().collect();
    let readme = std::fs::read_to_string(root().join("README.md")).unwrap();
    let texts =
        manual().into_iter().map(|page| (page.name, page.text)).chain([("../README".to_owned(), readme)]);
    let mut unknown = Vec::new();
    let mut compared = 0;
    for (name, text) in texts {
        for line in text.lines() {
            let commands =
                line.trim_start().strip_prefix("rig ").into_iter().filter(|_| line.starts_with("    "));
            let spans = code(line).filter(|code| code.starts_with("rig ") || code.starts_with("--"));
            // What stands after a `#` is no command, and what stands after `;` or `&&` one of another program.
            let commands =
                commands.chain(spans).map(|text| text.split([';', '#', '&']).next().unwrap_or(text));
            for option in commands.flat_map(options) {
                compared += 1;
                if !known.contains(option.trim_end_matches(['.', ':'])) {
                    unknown.push(format!("docs/{name}.md: {option}"));
                }
            }
        }
    }
    assert!(compared > 50, "{compared}");
    assert!(unknown.is_empty(), "{}", unknown.join("\n"));
}
