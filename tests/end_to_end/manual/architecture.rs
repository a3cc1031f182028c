//! The page about the architecture beside the workspace: crates and their dependencies, who reads a clock, and files that it
//! and the other pages name.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use crate::manual::markdown::{code, manual, page};
use crate::project_folder::{list, root};

/// The crates of the page's table with their folders.
fn crates() -> BTreeMap<String, PathBuf> {
    let tables = page("architecture").tables();
    let table = tables.into_iter().find(|table| table.header == "crate").unwrap();
    let rows = table.rows.into_iter();
    rows.map(|row| {
        (row.names[0].clone(), root().join(code(&row.rest).next().unwrap().trim_end_matches("/src")))
    })
    .collect()
}

/// The crates of the workspace that a crate depends on.
fn dependencies(folder: &Path, crates: &BTreeMap<String, PathBuf>) -> BTreeSet<String> {
    let manifest = std::fs::read_to_string(folder.join("Cargo.toml")).unwrap();
    let section = manifest.split_once("\n[dependencies]\n").map_or("", |(_, rest)| rest);
    let lines = section.lines().take_while(|line| !line.starts_with('['));
    let names = lines.filter_map(|line| line.split(['.', ' ']).next());
    names.filter(|name| crates.contains_key(*name)).map(str::to_owned).collect()
}

#[test]
fn the_arrows_are_the_dependencies() {
    let crates = crates();
    let text = page("architecture").text;
    let drawing = text.split("## The house").nth(1).unwrap().split("| crate |").next().unwrap();
    // What has no arrow goes on with the line before.
    let mut arrows: Vec<(String, String)> = Vec::new();
    for line in drawing.lines().filter_map(|line| line.strip_prefix("    ")) {
        match (line.split_once('►'), arrows.last_mut()) {
            (Some((from, to)), _) => arrows.push((from.replace('─', ""), to.to_owned())),
            (None, Some((_, to))) => to.push_str(line),
            (None, None) => panic!("`{line}` has no arrow"),
        }
    }
    let names = |text: &str| -> BTreeSet<String> {
        text.split(',').map(str::trim).filter(|name| !name.is_empty()).map(str::to_owned).collect()
    };
    let mut drawn: BTreeSet<String> = BTreeSet::from(["signal".to_owned()]);
    for (from, to) in &arrows {
        for name in names(from) {
            let found = dependencies(&crates[&name], &crates);
            let wanted = match to
                .trim()
                .strip_prefix("everything below, ")
                .and_then(|rest| rest.strip_suffix(" apart"))
            {
                Some(apart) => {
                    let apart = apart.replace(" and ", ", ");
                    let apart = names(&apart);
                    crates.keys().filter(|one| **one != name && !apart.contains(*one)).cloned().collect()
                }
                None => names(to),
            };
            assert_eq!(found, wanted, "{name}");
            drawn.insert(name);
        }
    }
    assert_eq!(drawn, crates.keys().cloned().collect());
    // A crate that nobody wrote into the table.
    let mut folders: Vec<PathBuf> =
        list(&root().join("rig")).iter().map(|name| root().join("rig").join(name)).collect();
    folders.extend(["drivers", "plans", "reports"].map(|name| root().join(name)));
    folders
        .retain(|folder| folder.join("Cargo.toml").exists() && !crates.values().any(|known| known == folder));
    assert_eq!(folders, Vec::<PathBuf>::new());
}

/// The sources below a folder, without those of tests.
fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() && name != "tests" {
            sources(&path, found);
        } else if name.ends_with(".rs") && !name.contains("tests") {
            found.push(path);
        }
    }
}

#[test]
fn who_is_said_to_read_no_clock_reads_none() {
    let crates = crates();
    let text = page("architecture").text;
    let rule = text.split("- Time is an argument: ").nth(1).unwrap();
    let rule = rule.split("read no clock").next().unwrap();
    let folders: Vec<PathBuf> = code(rule)
        .map(|name| crates.get(name).map_or_else(|| root().join(name), |folder| folder.join("src")))
        .collect();
    assert!(folders.len() > 8, "{folders:?}");
    let mut wrong = Vec::new();
    for folder in &folders {
        let mut files = Vec::new();
        sources(folder, &mut files);
        assert!(!files.is_empty(), "{}", folder.display());
        for file in files {
            let text = std::fs::read_to_string(&file).unwrap();
            for clock in ["Instant::now", "SystemTime::now", "clock_gettime", "HostInstant::now"] {
                if text.contains(clock) {
                    wrong.push(format!("{}: {clock}", file.display()));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

// A file or folder of the sources that a page names: after it was moved the page says so.
#[test]
fn paths_that_pages_name_are_there() {
    let tops = ["rig/", "drivers/", "plans/", "reports/", "tests/", "benches/"];
    let mut missing = Vec::new();
    let mut named = 0;
    for page in manual() {
        // What a project of the user's own may have stands in the pages about writing plans.
        if page.name.starts_with("plans/") || ["tools", "reports", "terminal"].contains(&page.name.as_str()) {
            continue;
        }
        for path in code(&page.sentences()) {
            let plain = path.chars().all(|char| char.is_ascii_alphanumeric() || "/._-".contains(char));
            if plain && tops.iter().any(|top| path.starts_with(top)) {
                named += 1;
                if !root().join(path).exists() {
                    missing.push(format!("docs/{}.md: {path}", page.name));
                }
            }
        }
    }
    assert!(named > 30, "{named}");
    assert!(missing.is_empty(), "{}", missing.join("\n"));
}

// The way of a bit: each station is where the page says, in at most twenty.
#[test]
fn the_stations_of_a_bit_are_where_the_page_says() {
    let tables = page("architecture").tables();
    let table = tables.into_iter().find(|table| table.header == "station").unwrap();
    assert!((10..=20).contains(&table.rows.len()), "{} stations", table.rows.len());
    for row in &table.rows {
        let mut names = code(&row.rest);
        let (file, name) = (names.next().unwrap(), names.next().unwrap());
        let text = std::fs::read_to_string(root().join(file)).unwrap_or_default();
        let mut words = text.split(|char: char| !char.is_alphanumeric() && char != '_');
        assert!(words.any(|word| word == name), "docs/{}: no `{name}` in {file}", row.place);
    }
}

#[test]
fn the_methods_of_a_board_are_on_its_page() {
    let source = std::fs::read_to_string(root().join("drivers/src/board/mod.rs")).unwrap();
    let body = source.split_once("\npub trait Board").unwrap().1.split_once("\n}\n").unwrap().0;
    let lines = body.lines().filter_map(|line| line.trim_start().strip_prefix("fn "));
    let names: Vec<&str> = lines.filter_map(|line| line.split(['(', '<']).next()).collect();
    assert!(names.len() > 8, "{names:?}");
    let page = page("boards/drivers").text;
    let stands = |name: &str| page.contains(&format!("{name}("));
    // What can be changed is reached by the same word as what can be looked at.
    let missing: Vec<_> = names.iter().filter(|name| !stands(name.trim_end_matches("_mut"))).collect();
    assert!(missing.is_empty(), "docs/boards/drivers.md lacks {missing:?}");
}
