//! Broken plans: `tests/broken/*.toml` each say in their first line which findings, with code, line and column,
//! the reader must report, all of them and no others: `# expect P0102 3:7, P0201 4:9`.
//!
//! `SCANRIG_BLESS=1 cargo test -p scanrig-plans --test all broken` writes the first lines again.

use std::path::PathBuf;

use document::{SourceFile, line_col, render};
use scanrig_plans::{CODES, gather, read_gathered};

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/broken")
}

#[test]
fn broken_plans_are_refused_at_the_right_place() {
    let mut paths: Vec<PathBuf> =
        std::fs::read_dir(folder()).unwrap().map(|one| one.unwrap().path()).collect();
    // Tables are what plans name.
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "toml"));
    paths.sort();
    assert!(paths.len() >= 15);
    let mut wrong = String::new();
    for path in paths {
        let text = std::fs::read_to_string(&path).unwrap();
        let file = SourceFile::new(path.file_name().unwrap().to_string_lossy(), text.clone());
        let beside = |name: &str| {
            std::fs::read_to_string(folder().join(name)).map_err(|error| error.kind().to_string())
        };
        let read = gather(&file, &mut { beside }).and_then(|text| read_gathered(&text, &[], 1));
        let found = read.err().unwrap_or_default();
        for one in &found {
            assert!(CODES.iter().any(|(code, _)| *code == one.code), "{} is not in the register", one.code);
            assert!(!one.message.ends_with('.'), "{}", one.message);
            // What is wrong with the TOML itself its own parser says.
            if one.help.is_empty() && one.code != scanrig_plans::TOML.syntax {
                wrong += &format!("{}: no help says what to write: {}\n", path.display(), one.message);
            }
        }
        let places: Vec<String> = found
            .iter()
            .map(|one| {
                let place = |at: &document::DiagnosticLabel| match at.file == file.name {
                    true => line_col(&text, at.span.start),
                    false => beside(&at.file).map_or((0, 0), |other| line_col(&other, at.span.start)),
                };
                let (line, column) = one.labels.first().map_or((0, 0), place);
                format!("{} {line}:{column}", one.code)
            })
            .collect();
        let expected = format!("# expect {}", places.join(", "));
        let (first, rest) = text.split_once('\n').unwrap();
        if std::env::var_os("SCANRIG_BLESS").is_some() {
            std::fs::write(&path, format!("{expected}\n{rest}")).unwrap();
        } else if first != expected || found.is_empty() {
            wrong += &format!(
                "{}: {first}\nbut found{}\n",
                path.display(),
                expected.trim_start_matches("# expect")
            );
        }
        wrong += &if std::env::var_os("SCANRIG_SHOW").is_some() {
            render(&found, &[file], false)
        } else {
            String::new()
        };
    }
    assert!(wrong.is_empty(), "{wrong}");
}
