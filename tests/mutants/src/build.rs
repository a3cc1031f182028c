//! Rewrites a copy of the repository and builds it with every mutation that compiles.

use crate::Outcome;
use crate::points::{self, Point};
use crate::rewrite::{Place, rewrite};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A crate that is mutated.
pub struct Subject<'a>(&'a str);

impl Subject<'_> {
    /// The crate of this name, if it is one whose behaviour the shipped plans claim.
    pub fn of(name: &str) -> Option<Subject<'_>> {
        ["controller", "expert", "drivers"].contains(&name).then_some(Subject(name))
    }

    /// Where its sources are in the repository.
    pub fn sources(&self) -> String {
        match self.0 {
            "drivers" => "drivers/src".into(),
            name => format!("rig/{name}/src"),
        }
    }

    fn package(&self) -> String {
        format!("scanrig-{}", self.0)
    }
}

/// What the rewritten crate asks whether a mutation is on. With `RIG_MUTANT=seen` none is, and the numbers of those
/// that were asked for go to the file in `RIG_MUTANT_SEEN`.
const SWITCH: &str = include_str!("switch.rs.txt");

struct Source {
    path: String,
    text: String,
    points: Vec<(usize, Point)>,
}

/// Builds `rig` with all viable mutations and lists them: number, place, operator, before, after.
pub fn build(subject: &Subject<'_>, repository: &Path, place: &Path, list: &Path) -> Outcome<()> {
    let copy = place.join("copy");
    copy_tree(subject, repository, &copy)?;
    let sources = read(subject, repository)?;
    let all: usize = sources.iter().map(|source| source.points.len()).sum();
    let mut dropped = BTreeSet::new();
    loop {
        let places = write(subject, &sources, &copy, &dropped)?;
        let more = errors(subject, &copy, place, &places)?;
        println!("{} of {all} mutations dropped, {} of the others do not compile", dropped.len(), more.len());
        if more.is_empty() {
            break;
        }
        dropped.extend(more);
    }
    let done = cargo(&copy, place).args(["build", "--quiet", "--release", "-p", "scanrig-cli"]).status()?;
    if !done.success() {
        return Err("the rewritten repository does not build".into());
    }
    let mut lines = String::new();
    for source in &sources {
        for (number, point) in source.points.iter().filter(|(number, _)| !dropped.contains(number)) {
            let (file, Point { line, operator, before, after, .. }) = (&source.path, point);
            writeln!(lines, "{number}\t{file}:{line}\t{operator}\t{before}\t{after}")?;
        }
    }
    println!("{} viable mutants: {}", lines.lines().count(), list.display());
    Ok(fs::write(list, lines)?)
}

fn cargo(copy: &Path, place: &Path) -> Command {
    let mut cargo = Command::new("cargo");
    cargo.current_dir(copy).env("CARGO_TARGET_DIR", place.join("build"));
    // Brackets that nobody would write are what most of the rewritten text consists of, and some mutations overflow.
    cargo.env("RUSTFLAGS", "--cap-lints=allow");
    // Compiled once and run some hundred times: link-time optimisation costs more than it gives.
    cargo.env("CARGO_PROFILE_RELEASE_LTO", "off").env("CARGO_PROFILE_RELEASE_DEBUG", "0");
    cargo.env("CARGO_PROFILE_RELEASE_CODEGEN_UNITS", "16");
    cargo
}

fn write_changed(path: &Path, bytes: &[u8]) -> Outcome<()> {
    if fs::read(path).is_ok_and(|old| old == bytes) {
        return Ok(());
    }
    fs::create_dir_all(path.parent().ok_or("no folder")?)?;
    Ok(fs::write(path, bytes)?)
}

/// Copies what is in the repository, but for the rewritten sources; unchanged files keep their time.
fn copy_tree(subject: &Subject<'_>, repository: &Path, copy: &Path) -> Outcome<()> {
    let mutated = subject.sources();
    let listed = Command::new("git").args(["ls-files", "-z"]).current_dir(repository).output()?;
    for path in String::from_utf8(listed.stdout)?.split_terminator('\0') {
        if !path.starts_with(&mutated) && repository.join(path).is_file() {
            write_changed(&copy.join(path), &fs::read(repository.join(path))?)?;
        }
    }
    Ok(())
}

fn read(subject: &Subject<'_>, repository: &Path) -> Outcome<Vec<Source>> {
    let mut paths: Vec<PathBuf> = Vec::new();
    let mut folders = vec![repository.join(subject.sources())];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder)? {
            let path = entry?.path();
            match path.is_dir() {
                true => folders.push(path),
                false => paths.push(path),
            }
        }
    }
    paths.sort();
    let (mut sources, mut number) = (Vec::new(), 0);
    for path in paths {
        let text = fs::read_to_string(&path)?;
        let is_test =
            path.components().any(|part| part.as_os_str() == "tests" || part.as_os_str() == "tests.rs");
        let found = if is_test { Vec::new() } else { points::find(&text)? };
        let points = found.into_iter().map(|point| {
            number += 1;
            (number, point)
        });
        let points = points.collect();
        let path = path.strip_prefix(repository)?.to_string_lossy().into_owned();
        sources.push(Source { path, text, points });
    }
    Ok(sources)
}

/// Writes the sources; gives where every mutation is.
fn write(
    subject: &Subject<'_>,
    sources: &[Source],
    copy: &Path,
    dropped: &BTreeSet<usize>,
) -> Outcome<BTreeMap<String, Vec<Place>>> {
    let mut all = BTreeMap::new();
    for source in sources {
        let points = source.points.iter().filter(|(number, _)| !dropped.contains(number));
        let points: Vec<(usize, &Point)> = points.map(|(number, point)| (*number, point)).collect();
        let (mut text, places) = rewrite(&source.text, &points);
        if source.path.ends_with("src/lib.rs") {
            text.push_str("\nmod mutants;\n");
        }
        write_changed(&copy.join(&source.path), text.as_bytes())?;
        all.insert(source.path.clone(), places);
    }
    write_changed(&copy.join(subject.sources()).join("mutants.rs"), SWITCH.as_bytes())?;
    Ok(all)
}

/// The mutations that the compiler does not take.
fn errors(
    subject: &Subject<'_>,
    copy: &Path,
    place: &Path,
    places: &BTreeMap<String, Vec<Place>>,
) -> Outcome<BTreeSet<usize>> {
    let mut check = cargo(copy, place);
    check.env("CARGO_TARGET_DIR", place.join("check"));
    check.args(["check", "--release", "-p", &subject.package(), "--message-format=json"]);
    let output = check.output()?;
    let mut found = BTreeSet::new();
    let mut unplaced = String::new();
    for line in String::from_utf8(output.stdout)?.lines() {
        let message: Value = serde_json::from_str(line)?;
        let message = &message["message"];
        if message["level"] != "error" {
            continue;
        }
        let spans = message["spans"].as_array().map_or(&[][..], Vec::as_slice);
        let culprits = culprits(spans, places);
        if culprits.is_empty() && !spans.is_empty() {
            unplaced += message["rendered"].as_str().unwrap_or_default();
        }
        found.extend(culprits);
    }
    if found.is_empty() && !output.status.success() {
        return Err(format!("{unplaced}{}", String::from_utf8_lossy(&output.stderr)).into());
    }
    Ok(found)
}

/// Whose fault an error is: the mutations that it points into, else the innermost around it, else those of its line.
fn culprits(spans: &[Value], places: &BTreeMap<String, Vec<Place>>) -> BTreeSet<usize> {
    let none = Vec::new();
    let of = |span: &Value| {
        let file = places.get(span["file_name"].as_str().unwrap_or_default()).unwrap_or(&none);
        let number = |key: &str| span[key].as_u64().unwrap_or_default() as usize;
        (file, number("byte_start")..number("byte_end"), number("line_start"))
    };
    let primary = || spans.iter().filter(|span| span["is_primary"] == true);
    let mut found = BTreeSet::new();
    for span in primary().chain(spans) {
        let (file, bytes, _) = of(span);
        let inside = |place: &&Place| place.mutated.start <= bytes.start && bytes.end <= place.mutated.end;
        found.extend(file.iter().filter(inside).map(|place| place.number));
        if !found.is_empty() {
            return found;
        }
    }
    for span in primary() {
        let (file, bytes, line) = of(span);
        let around = |place: &&Place| place.whole.start <= bytes.start && bytes.end <= place.whole.end;
        match file.iter().filter(around).min_by_key(|place| place.whole.len()) {
            Some(place) => found.extend([place.number]),
            None => found.extend(file.iter().filter(|place| place.line == line).map(|place| place.number)),
        }
    }
    found
}
