//! The tables of docs/system-variables.md are made of the tables in `system`: `SCANRIG_BLESS=1 cargo test -p scanrig-profile` writes
//! them again.

use scanrig_profile::{
    ENUMERATIONS, Enumeration, MemberSource, MemberType, Profile, REGISTER_RANGES, RegisterPermission,
    SystemMember, SystemStructure,
};
use std::fmt::Write;

/// What a table stands between.
const BEGIN: &str = "<!-- table:";
const END: &str = "<!-- end -->";

fn profiles(of: &[Profile]) -> String {
    match of == Profile::ALL {
        true => String::from("all"),
        false => of.iter().map(|one| one.name()).collect::<Vec<_>>().join(", "),
    }
}

/// The types of a member: one, or that of each family.
fn types(member: &SystemMember) -> String {
    let first = member.ty(Profile::M241_2019).declaration();
    let second = member.ty(Profile::M251_2024).declaration();
    let array = |text: String| text.replace('|', "/");
    match first == second || !member.exists(Profile::M251_2024) {
        true => array(first),
        false => array(format!("{first}; m251-2024: {second}")),
    }
}

fn members(structure: SystemStructure) -> String {
    let mut text = String::from(
        "| member | type | unit | enumeration | register | access | profiles | requirement | meaning |\n",
    );
    text += "| --- | --- | --- | --- | --- | --- | --- | --- | --- |\n";
    for member in structure.members() {
        let rest = match (member.source, member.ty(Profile::default())) {
            (MemberSource::Rest(_), MemberType::Text(_)) => String::from(" Rests empty."),
            (MemberSource::Rest(value), _) => format!(" Rests at {value}."),
            _ => String::new(),
        };
        let names: Vec<String> = member.names_of_it().map(|name| format!("`{name}`")).collect();
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} | {} | {} | {}{rest} |",
            names.join(", "),
            types(member),
            member.unit,
            member.enumeration.map_or(String::new(), |one| format!("`{}`", one.name)),
            member.register.map_or(String::from("by a row"), |first| first.to_string()),
            if structure.is_read_only() { "read" } else { "read and write" },
            profiles(member.profiles),
            member.requirement,
            member.meaning,
        );
    }
    text
}

fn enumerations() -> String {
    let mut text = String::from("| enumeration | values | profiles |\n| --- | --- | --- |\n");
    let values = |one: &Enumeration| {
        let values = one.values.iter().map(|(name, number)| format!("{number} `{name}`"));
        values.collect::<Vec<_>>().join(", ")
    };
    for one in ENUMERATIONS {
        let _ = writeln!(text, "| `{}` | {} | {} |", one.name, values(one), profiles(one.profiles));
    }
    text
}

fn registers() -> String {
    let mut text = String::from(
        "| registers | what | 2014, in a row | 2014, elsewhere | later, in a row | later, elsewhere | requirement |\n",
    );
    text += "| --- | --- | --- | --- | --- | --- | --- |\n";
    for range in REGISTER_RANGES {
        let of = |profile| [true, false].map(|declared| range.permission(profile, declared));
        assert_eq!(of(Profile::M241_2019), of(Profile::M251_2024));
        let all = [of(Profile::M241_2014), of(Profile::M241_2019)].concat();
        let all: Vec<&str> = all.into_iter().map(RegisterPermission::name).collect();
        let _ = writeln!(
            text,
            "| {} to {} | {} | {} | {} |",
            range.first,
            range.last,
            range.meaning,
            all.join(" | "),
            range.requirement
        );
    }
    text
}

fn table(name: &str) -> String {
    match name {
        "enumerations" => enumerations(),
        "registers" => registers(),
        name => members(SystemStructure::find(name).unwrap_or_else(|| panic!("no table `{name}`"))),
    }
}

#[test]
fn the_tables_are_those_of_the_structures() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/system-variables.md");
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
    assert_eq!(tables, SystemStructure::ALL.len() + 2);
    if std::env::var_os("SCANRIG_BLESS").is_some() {
        std::fs::write(path, &now).unwrap();
    }
    let page = std::fs::read_to_string(path).unwrap();
    let differs = page.lines().zip(now.lines()).find(|(page, now)| page != now);
    assert!(page == now, "docs/system-variables.md says otherwise than the tables: {differs:?}");
}
