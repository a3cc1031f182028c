//! What stands in lists: the tests of a crate are one program, whose `main.rs` lists their files, and a fuzz target is
//! named in four places. What is not listed would never run.

use std::path::Path;

use crate::project_folder::{list, root};

/// The files and folders beside `main.rs` that hold tests but are no module of it.
fn unlisted(folder: &Path) -> Vec<String> {
    let main = std::fs::read_to_string(folder.join("main.rs")).unwrap();
    let crate_file = std::fs::read_to_string(folder.join("../Cargo.toml")).unwrap_or_default();
    let names = list(folder).into_iter().filter_map(|name| {
        if folder.join(&name).join("main.rs").exists() {
            // A program of its own, which stands in the crate's file.
            (!crate_file.contains(&format!("\"tests/{name}/main.rs\""))).then_some(name)
        } else {
            let module = name.strip_suffix(".rs")?;
            (module != "main" && !main.contains(&format!("mod {module};\n"))).then(|| name.clone())
        }
    });
    names.map(|name| folder.join(name).display().to_string()).collect()
}

#[test]
fn every_file_of_tests_is_part_of_a_program() {
    let crates = list(&root().join("rig")).into_iter().map(|name| format!("rig/{name}/tests"));
    let others = ["drivers/tests", "plans/tests", "reports/tests", "tests/end_to_end"].map(String::from);
    let folders: Vec<_> = crates
        .chain(others)
        .map(|folder| root().join(folder))
        .filter(|folder| folder.join("main.rs").exists())
        .collect();
    assert!(folders.len() >= 6, "{folders:?}");
    let unlisted: Vec<_> = folders.iter().flat_map(|folder| unlisted(folder)).collect();
    assert!(unlisted.is_empty(), "not listed in the `main.rs` beside: {unlisted:?}");
}

#[test]
fn fuzz_targets_are_the_same_everywhere() {
    let folder = root().join("tests/fuzz");
    let text = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    let sorted = |mut names: Vec<String>| {
        names.sort();
        names
    };
    let files = list(&folder.join("fuzz_targets"));
    let files: Vec<_> = files.iter().filter_map(|name| name.strip_suffix(".rs")).map(String::from).collect();
    let manifest = text("Cargo.toml");
    let bins = manifest.split("[[bin]]").skip(1);
    let bins = bins.map(|bin| bin.split('"').nth(1).unwrap().to_owned());
    assert_eq!(sorted(bins.collect()), files);
    assert_eq!(list(&folder.join("corpus")), files);
}
