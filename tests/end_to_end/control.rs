//! The page about the control socket: its examples are run on a rig in stepped time, one after the other, and print
//! what stands there. `SCANRIG_BLESS=1` writes the page again.

use crate::project_folder::{TestProject, root};
use crate::stepped_rig::SteppedRig;
use std::fmt::Write as _;
use std::io::{BufRead, BufReader, Write};
use std::os::unix::net::UnixStream;

/// The words of a command line: blanks divide, quotes of both kinds hold together.
fn words(line: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut open = None;
    for c in line.chars() {
        match (open, c) {
            (Some(quote), _) if quote == c => open = None,
            (None, '\'' | '"') => open = Some(c),
            (None, ' ') => words.push(String::new()),
            _ => words.last_mut().unwrap().push(c),
        }
    }
    words
}

/// Runs the commands of a block and gives the block as it is then.
fn console(stepped: &SteppedRig, block: &str) -> String {
    let mut text = String::new();
    for command in block.lines().filter_map(|line| line.strip_prefix("$ rig ")) {
        let words = words(command);
        let ran = stepped.ctl(&words.iter().skip(1).map(String::as_str).collect::<Vec<_>>());
        let _ = write!(text, "$ rig {command}\n{}{}", ran.out, ran.err);
        if ran.code != Some(0) {
            let _ = writeln!(text, "(exit code {})", ran.code.unwrap());
        }
    }
    text
}

/// The line as every version prints it.
fn unversioned(line: &str) -> String {
    line.replace(concat!("\"version\":\"", env!("CARGO_PKG_VERSION"), "\""), "\"version\":\"0.1.0\"")
}

/// Sends the client's lines of a block over a connection of their own, each when the one before is answered, and gives the
/// block as it is then.
fn exchange(stepped: &SteppedRig, block: &str) -> String {
    let mut stream = UnixStream::connect(stepped.socket()).unwrap();
    let mut lines = BufReader::new(stream.try_clone().unwrap()).lines();
    let mut text = String::new();
    let greeting = lines.next().unwrap().unwrap();
    if block.starts_with('<') {
        let _ = writeln!(text, "< {}", unversioned(&greeting));
    }
    for request in block.lines().filter_map(|line| line.strip_prefix("> ")) {
        let _ = writeln!(text, "> {request}");
        stream.write_all(format!("{request}\n").as_bytes()).unwrap();
        loop {
            let line = lines.next().unwrap().unwrap();
            let _ = writeln!(text, "< {}", unversioned(&line));
            if line.starts_with("{\"id\":") {
                break;
            }
        }
    }
    text
}

#[test]
fn the_examples_of_the_page_are_true() {
    let path = root().join("docs/control.md");
    let page = std::fs::read_to_string(&path).unwrap();
    let bench = TestProject::new();
    let mut stepped: Option<SteppedRig> = None;
    let (mut now, mut fence, mut block) = (String::new(), None::<String>, String::new());
    for line in page.lines() {
        match (&fence, line.strip_prefix("```")) {
            (None, None) => now += &format!("{line}\n"),
            (None, Some(language)) => {
                now += &format!("{line}\n");
                fence = Some(language.to_owned());
            }
            (Some(_), None) => block += &format!("{line}\n"),
            (Some(language), Some(_)) => {
                if stepped.is_none() && matches!(language.as_str(), "console" | "jsonl") {
                    stepped = Some(SteppedRig::start(&bench, "tank.toml", "lamp.st"));
                }
                let rig = stepped.as_ref();
                now += &match language.as_str() {
                    "console" => console(rig.unwrap(), &block),
                    "jsonl" => exchange(rig.unwrap(), &block),
                    "toml" => {
                        bench.write("tank.toml", &block);
                        block.clone()
                    }
                    "iecst" => {
                        bench.write("lamp.st", &block);
                        block.clone()
                    }
                    other => panic!("a block of {other}"),
                };
                now += "```\n";
                (fence, block) = (None, String::new());
            }
        }
    }
    if std::env::var_os("SCANRIG_BLESS").is_some() {
        std::fs::write(&path, &now).unwrap();
    }
    let page = std::fs::read_to_string(&path).unwrap();
    let differs = page.lines().zip(now.lines()).find(|(page, now)| page != now);
    assert!(page == now, "docs/control.md says otherwise than the rig: {differs:?}");
}
