//! What the interval of a measurement covers, by the notes of its trace.
//!
//! An interval holds what is measured in every placement of the events within theirs, so it is a bound wherever these are.
//! Where a statement of uncertainty that is no bound made an interval of the trace, a note says which.

use signal::Coverage;

/// What the notes of signals are called; their names come after it.
const NOTE: &str = "coverage:";

/// The note of the instants that all else is counted from: the steps and the clock.
pub const INSTANTS_NOTE: &str = "coverage-of-instants";

/// The note by which a trace says what the values of a signal, and the instants of its changes, cover where they are no bounds.
pub fn note_of(signal: &str) -> String {
    format!("{NOTE}{signal}")
}

/// What a measurement of these signals covers.
pub(super) fn coverage(names: &[String], note: &dyn Fn(&str) -> Option<String>) -> String {
    let own = names.iter().filter_map(|name| note(&note_of(name)));
    let stated: Vec<String> = own.chain(note(INSTANTS_NOTE)).collect();
    Coverage::together(stated.iter().flat_map(|words| words.split(", ")).filter_map(Coverage::parse))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_bound_counts_where_it_took_part() {
        let note = |key: &str| match key {
            "coverage:pressure" => Some("95 %".to_owned()),
            "coverage:level" => Some("k = 2, 99 %".to_owned()),
            _ => None,
        };
        let of = |names: &[&str]| {
            coverage(&names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>(), &note)
        };
        assert_eq!(of(&["lamp"]), "limits");
        assert_eq!(of(&["pressure", "lamp"]), "95 %");
        assert_eq!(of(&["pressure", "level"]), "95 %, 99 %, k = 2");
        let clock = |key: &str| (key == INSTANTS_NOTE).then(|| "k = 2".to_owned());
        assert_eq!(coverage(&[], &clock), "k = 2");
    }
}
