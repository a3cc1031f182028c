//! Functions and types that controllers bring along beside the standard's, written in Structured Text. Only what the
//! sources name is compiled with them, and a declaration of their own goes before it.

use document::SourceFile;

/// The sources with the names that ask for them, in capitals.
const LIBRARIES: &[(&str, &str, &[&str])] = &[
    (
        "(library) memory.st",
        include_str!("memory.st"),
        &["MEMCPY", "MEMMOVE", "MEMSET", "MEMCMP", "SYSMEMCPY", "SYSMEMMOVE", "SYSMEMSET", "SYSMEMCMP"],
    ),
    ("(library) tm3.st", include_str!("tm3.st"), &["TM3_GETMODULEINTERNALSTATUS"]),
    (
        "(library) any.st",
        include_str!("any.st"),
        &[
            "ANY",
            "ANY_NUM",
            "ANY_INT",
            "ANY_REAL",
            "ANY_BIT",
            "ANY_STRING",
            "ANY_DATE",
            "TYPE_CLASS",
            "TYPECLASS",
            "ANYTYPE",
        ],
    ),
];

/// What the sources need beside themselves.
pub(crate) fn needed(sources: &[SourceFile]) -> Vec<SourceFile> {
    let mut found = vec![false; LIBRARIES.len()];
    for source in sources {
        for word in source.text.split(|c: char| !c.is_ascii_alphanumeric() && c != '_') {
            // No name is shorter or longer.
            if !(3..=27).contains(&word.len()) {
                continue;
            }
            for ((_, _, names), found) in LIBRARIES.iter().zip(&mut found) {
                *found |= names.iter().any(|name| name.eq_ignore_ascii_case(word));
            }
        }
    }
    let needed = LIBRARIES.iter().zip(found).filter(|(_, found)| *found);
    needed.map(|((name, text, _), _)| SourceFile::new(*name, *text)).collect()
}
