//! Links of the documents: each leads to a file that is there, and to a heading that it has; every page can be reached
//! from the map of the documents.

use crate::project_folder::root;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};

/// A page: where its headings are, and where its links lead.
struct Page {
    anchors: BTreeSet<String>,
    /// Line and target as written.
    links: Vec<(usize, String)>,
}

/// Folders that hold nothing of ours.
fn is_foreign(name: &str) -> bool {
    name == "target" || name.starts_with('.')
}

fn pages_below(folder: &Path, found: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() && !is_foreign(&name) {
            pages_below(&path, found);
        } else if name.ends_with(".md") {
            found.push(path);
        }
    }
}

/// The anchor that forges give a heading: small letters, digits, `-` and `_`; blanks become `-`.
pub fn anchor(heading: &str) -> String {
    let kept = heading.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
    kept.flat_map(char::to_lowercase).map(|c| if c == ' ' { '-' } else { c }).collect()
}

/// The targets of the links and pictures in a line, but for those in `code`.
fn targets(line: &str) -> Vec<String> {
    let prose: String = line.split('`').step_by(2).collect::<Vec<_>>().join("code");
    let parts = prose.split("](").skip(1);
    parts.filter_map(|part| Some(part.split_once(')')?.0.to_owned())).collect()
}

fn read(text: &str) -> Page {
    let mut page = Page { anchors: BTreeSet::new(), links: Vec::new() };
    let mut fenced = false;
    for (number, line) in text.lines().enumerate() {
        if line.trim_start().starts_with("```") {
            fenced = !fenced;
        }
        if fenced || line.starts_with("    ") {
            continue;
        }
        if let Some(heading) =
            line.trim_start_matches('#').strip_prefix(' ').filter(|_| line.starts_with('#'))
        {
            let first = anchor(heading);
            let numbered = (1..).map(|n| format!("{first}-{n}"));
            let free =
                std::iter::once(first.clone()).chain(numbered).find(|name| !page.anchors.contains(name));
            page.anchors.extend(free);
        }
        page.links.extend(targets(line).into_iter().map(|target| (number + 1, target)));
    }
    page
}

/// `a/b/../c` is `a/c`.
fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => drop(plain.pop()),
            Component::CurDir => {}
            part => plain.push(part),
        }
    }
    plain
}

fn pages() -> BTreeMap<PathBuf, Page> {
    let mut paths = Vec::new();
    pages_below(&root(), &mut paths);
    paths.into_iter().map(|path| (plain(&path), read(&std::fs::read_to_string(&path).unwrap()))).collect()
}

/// The file that a link of a page leads to, with the heading; none outside of the repository.
fn destination(page: &Path, target: &str) -> Option<(PathBuf, Option<String>)> {
    if target.contains("://") || target.starts_with("mailto:") {
        return None;
    }
    let (file, heading) =
        target.split_once('#').map_or((target, None), |(file, heading)| (file, Some(heading)));
    let path = if file.is_empty() { page.to_owned() } else { plain(&page.parent().unwrap().join(file)) };
    Some((path, heading.map(str::to_owned)))
}

#[test]
fn every_link_leads_to_a_file_and_a_heading() {
    let pages = pages();
    let mut dead = Vec::new();
    for (path, page) in &pages {
        for (line, target) in &page.links {
            let Some((file, heading)) = destination(path, target) else { continue };
            let known =
                |heading: &String| pages.get(&file).is_some_and(|page| page.anchors.contains(heading));
            if !file.exists() || heading.as_ref().is_some_and(|heading| !known(heading)) {
                dead.push(format!("{}:{line}: {target}", path.display()));
            }
        }
    }
    assert!(pages.len() > 50, "{} pages", pages.len());
    assert!(dead.is_empty(), "dead links:\n{}", dead.join("\n"));
}

#[test]
fn every_page_of_the_documents_is_reached_from_their_map() {
    let pages = pages();
    let docs = plain(&root()).join("docs");
    let mut reached = BTreeSet::new();
    let mut open = vec![docs.join("README.md")];
    while let Some(path) = open.pop() {
        if !reached.insert(path.clone()) {
            continue;
        }
        let links = pages.get(&path).map_or(&[][..], |page| &page.links);
        open.extend(links.iter().filter_map(|(_, target)| Some(destination(&path, target)?.0)));
    }
    // A decision is found by its number, in the folder.
    let lost = |path: &&PathBuf| {
        path.starts_with(&docs)
            && !reached.contains(*path)
            && !path.parent().is_some_and(|folder| folder.ends_with("decisions") && reached.contains(folder))
    };
    let lost: Vec<&PathBuf> = pages.keys().filter(lost).collect();
    assert!(lost.is_empty(), "no page leads to {lost:?}");
}

#[test]
fn links_and_headings_are_read_as_forges_read_them() {
    let page = read(
        "# A `b`, C_d\n## X\n## X\n[a](one.md#x) ![b](two.png) `[no](link)`\n```\n# no\n```\n    [no](n)\n",
    );
    assert_eq!(page.anchors.iter().collect::<Vec<_>>(), ["a-b-c_d", "x", "x-1"]);
    assert_eq!(page.links, [(4, "one.md#x".to_owned()), (4, "two.png".to_owned())]);
}
