//! What the dashboard may draw with: a terminal may have no colours, and no characters but those of ASCII.

/// What the terminal can show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TerminalFeatures {
    /// Characters beyond ASCII: frames, braille, blocks.
    pub utf8: bool,
    /// Colours. Nothing is said by colour alone.
    pub color: bool,
}

/// Terminals that show no frames or braille, whatever the locale says: consoles of the kernel, of serial lines, and
/// those that nothing is known of.
const PLAIN: [&str; 7] = ["linux", "dumb", "unknown", "vt52", "vt100", "vt102", "vt220"];

/// Terminals without colours.
const GREY: [&str; 6] = ["dumb", "unknown", "vt52", "vt100", "vt102", "vt220"];

impl TerminalFeatures {
    /// What can be taken for granted from variables of the environment, which `variable` reads.
    pub fn of_environment(variable: impl Fn(&str) -> Option<String>) -> TerminalFeatures {
        let set = |name: &str| variable(name).filter(|value| !value.is_empty());
        let term = set("TERM").unwrap_or_default();
        // The first that is set decides, as for every program.
        let locale =
            ["LC_ALL", "LC_CTYPE", "LANG"].into_iter().find_map(set).unwrap_or_default().to_lowercase();
        let utf8 = locale.contains("utf-8") || locale.contains("utf8");
        let is_one_of = |names: &[&str]| names.contains(&term.as_str());
        TerminalFeatures {
            utf8: utf8 && !is_one_of(&PLAIN),
            color: set("NO_COLOR").is_none() && !is_one_of(&GREY),
        }
    }

    /// A character, or what stands for it in ASCII.
    pub const fn or(self, glyph: &'static str, ascii: &'static str) -> &'static str {
        if self.utf8 { glyph } else { ascii }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn look(variables: &[(&str, &str)]) -> (bool, bool) {
        let find =
            |name: &str| variables.iter().find(|(n, _)| *n == name).map(|(_, value)| (*value).to_owned());
        let features = TerminalFeatures::of_environment(find);
        (features.utf8, features.color)
    }

    #[test]
    fn a_terminal_gets_only_what_it_shows() {
        assert_eq!(look(&[("TERM", "xterm"), ("LANG", "de_DE.UTF-8")]), (true, true));
        assert_eq!(look(&[("TERM", "xterm"), ("LANG", "C.utf8"), ("LC_ALL", "C")]), (false, true));
        assert_eq!(look(&[("TERM", "xterm"), ("LANG", "C.utf8"), ("LC_ALL", "")]), (true, true));
        assert_eq!(look(&[("TERM", "linux"), ("LANG", "C.UTF-8")]), (false, true));
        assert_eq!(look(&[("TERM", "vt100"), ("LANG", "C.UTF-8")]), (false, false));
        assert_eq!(look(&[("TERM", "xterm"), ("LANG", "C.UTF-8"), ("NO_COLOR", "1")]), (true, false));
        assert_eq!(look(&[("TERM", "xterm"), ("LANG", "C.UTF-8"), ("NO_COLOR", "")]), (true, true));
        assert_eq!(look(&[]), (false, true));
    }
}
