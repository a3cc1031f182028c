//! The tables of docs/modules.md are made of the catalogue: `SCANRIG_BLESS=1 cargo test -p scanrig-catalogue` writes them again.

use profile::{AnalogueMode, ModuleFamily, ModuleType, Profile};
use scanrig_catalogue::{channels, modules};
use std::fmt::Write;

/// What a table stands between.
const BEGIN: &str = "<!-- table:";
const END: &str = "<!-- end -->";

/// The rows of a family: a module and the one with spring terminals are one row.
fn modules_of(family: ModuleFamily) -> String {
    let mut text = String::from("| reference | ID | channels | bytes of `%I` | bytes of `%Q` | profiles |\n");
    text += "| --- | --- | --- | --- | --- | --- |\n";
    for module in modules().iter().filter(|one| one.family == family && !one.reference.ends_with('G')) {
        let spring = scanrig_catalogue::find(&format!("{}G", module.reference));
        let reference =
            module.reference.clone() + &spring.map_or(String::new(), |one| format!(", {}", one.reference));
        let id = module.id.map_or(String::new(), |id| id.to_string());
        let inputs = match module.status_bytes() {
            _ if unknown(module) => String::new(),
            0 => module.input_bytes().to_string(),
            status => format!("{} + {status} status", module.input_bytes()),
        };
        let _ = writeln!(
            text,
            "| {reference} | {id} | {} | {inputs} | {} | {} |",
            what(module),
            if unknown(module) { String::new() } else { module.output_bytes().to_string() },
            known_by(module)
        );
    }
    text
}

/// Whether no document says what channels it has.
fn unknown(module: &ModuleType) -> bool {
    module.is_on_bus() && channels(module).is_empty()
}

/// The channels, or what it is for where it has none.
fn what(module: &ModuleType) -> String {
    match channels(module) {
        _ if unknown(module) => String::from("not known"),
        none if none.is_empty() => module.kind.name().to_owned(),
        words => words,
    }
}

fn known_by(module: &ModuleType) -> String {
    if module.profiles == Profile::ALL {
        return String::from("all");
    }
    module.profiles.iter().map(|one| one.name()).collect::<Vec<_>>().join(", ")
}

/// The modes of a family in the order in which modules name them.
fn modes_of(family: ModuleFamily) -> String {
    let mut text = String::from("| mode | unit | from | to | under range | over range |\n");
    text += "| --- | --- | --- | --- | --- | --- |\n";
    let mut seen: Vec<&AnalogueMode> = Vec::new();
    for module in modules().iter().filter(|one| one.family == family) {
        let channels = [&module.analogue_inputs, &module.analogue_outputs].into_iter().flatten();
        for mode in channels.flat_map(|one| &one.modes) {
            if !seen.contains(&mode) {
                seen.push(mode);
            }
        }
    }
    for mode in seen {
        let figures = [mode.low, mode.high, mode.under_range, mode.over_range];
        let figures = figures.map(|one| one.map_or(String::new(), |number| number.to_string()));
        let _ = writeln!(text, "| {} | {} | {} |", mode.name, mode.unit, figures.join(" | "));
    }
    text
}

fn table(name: &str) -> String {
    let family = |name: &str| ModuleFamily::ALL.into_iter().find(|one| one.name() == name);
    match name.split_once(' ') {
        Some((of, "modules")) => modules_of(family(of).unwrap()),
        Some((of, "modes")) => modes_of(family(of).unwrap()),
        _ => panic!("no table `{name}`"),
    }
}

#[test]
fn the_tables_are_those_of_the_catalogue() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/modules.md");
    let page = std::fs::read_to_string(path).unwrap();
    let (mut now, mut inside, mut tables) = (String::new(), false, 0);
    for line in page.lines() {
        inside &= line != END;
        if inside {
            continue;
        }
        let _ = writeln!(now, "{line}");
        if let Some(name) = line.strip_prefix(BEGIN) {
            let _ = write!(now, "\n{}\n", table(name.trim_end_matches("-->").trim()));
            (inside, tables) = (true, tables + 1);
        }
    }
    assert_eq!(tables, 6);
    if std::env::var_os("SCANRIG_BLESS").is_some() {
        std::fs::write(path, &now).unwrap();
    }
    let page = std::fs::read_to_string(path).unwrap();
    let differs = page.lines().zip(now.lines()).find(|(page, now)| page != now);
    assert!(page == now, "docs/modules.md says otherwise than the catalogue: {differs:?}");
}

#[test]
fn channels_are_said_in_words() {
    let words = |reference: &str| channels(scanrig_catalogue::find(reference).unwrap());
    assert_eq!(words("TM3DM24R"), "16 digital inputs, 8 relay outputs");
    assert_eq!(words("TM3TM3"), "2 analogue inputs of 16 bit, 1 analogue output of 12 bit");
    assert_eq!(words("TM3DQ8UG"), "8 sink outputs");
    assert_eq!(words("TM2AVO2HT"), "2 analogue outputs");
    assert_eq!(words("TM3XHSC202"), "");
}
