//! What a TOML file is: plans, board files and instrument files stand in the same folders, among TOML files of other programs.

use document::{KeySpec, KeyType};
use drivers::file::KEYS as BOARD_KEYS;
use plans::plan::{INCLUDED_KEYS, PLAN_KEYS};
use runtime::suite::instrument_file::KEYS as INSTRUMENT_KEYS;

/// What the keys of a TOML text speak for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    /// A plan.
    Plan,
    /// A board file.
    Board,
    /// An instrument file.
    Instrument,
    /// What plans include: it has what they share, and neither does nor claims anything itself.
    Included,
    /// A plan or a board file, for it says its format, and nothing more yet.
    Unclear,
    /// Neither: empty, or of another program.
    Neither,
}

/// Recognises it by the keys at the top level, line by line: a file that is no TOML yet must be recognised, too. A key that stands
/// wrongly in a plan or a board file does not make it the other.
pub fn of(text: &str) -> FileKind {
    let mut counts = KeyCounts::default();
    let mut top = true;
    let mut in_channels = false;
    // What some editors put before the first line is no part of a key.
    for line in text.trim_start_matches('\u{feff}').lines() {
        let line = line.trim_end();
        if let Some(header) = line.trim_start().strip_prefix('[') {
            // A list that goes on over lines begins a line with a bracket, too, but closes no name with one.
            let header = header.trim_start_matches('[').trim_start();
            if let Some(key) = first_word(header)
                && header[key.len()..].trim_start().starts_with([']', '.'])
                && !line.ends_with(',')
            {
                top = false;
                in_channels = key == CHANNELS;
                counts.key(key, "{");
            }
        }
        if in_channels || top && first_word(line) == Some(CHANNELS) {
            counts.keys_of_a_channel(line);
        }
        if top
            && let Some(key) = first_word(line)
            && let Some(value) = line[key.len()..].trim_start().strip_prefix(['=', '.'])
        {
            counts.key(key, value.trim_start());
        }
    }
    counts.kind()
}

/// The name at the beginning of a text.
fn first_word(text: &str) -> Option<&str> {
    let end = text.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_' || c == '-')).unwrap_or(text.len());
    (end > 0).then(|| &text[..end])
}

/// The table that board files and instrument files have in common: only the keys of a channel distinguish them there.
const CHANNELS: &str = "channels";

/// Whether a table of keys has this one in its channels.
fn has_channel_key(keys: &[KeySpec], name: &str) -> bool {
    keys.iter().filter(|key| key.name == CHANNELS).any(|channels| match channels.ty {
        KeyType::Map(KeyType::Table(inner)) => inner.iter().any(|known| known.name == name),
        _ => false,
    })
}

/// How many keys speak for what.
#[derive(Clone, Copy, Debug, Default)]
struct KeyCounts {
    format: bool,
    plan: usize,
    /// Those of a plan that what plans include can have, too.
    included: usize,
    board: usize,
    instrument: usize,
    /// Whether a channel has a key that only those of instrument files have.
    instrument_channel: bool,
}

impl KeyCounts {
    /// Those in a line of text of a channel, which may be a table in one line.
    fn keys_of_a_channel(&mut self, line: &str) {
        for part in line.split(['{', ',', '.']).map(str::trim_start) {
            if let Some(key) = first_word(part)
                && part[key.len()..].trim_start().starts_with('=')
            {
                self.instrument_channel |=
                    has_channel_key(INSTRUMENT_KEYS, key) && !has_channel_key(BOARD_KEYS, key);
            }
        }
    }

    fn key(&mut self, key: &str, value: &str) {
        let plan = PLAN_KEYS.iter().any(|known| known.name == key);
        let board = BOARD_KEYS.iter().any(|known| known.name == key);
        if INSTRUMENT_KEYS.iter().any(|known| known.name == key) && !plan {
            self.instrument += 1;
        }
        match (plan, board) {
            // A board file describes the board; a text is a plan's, or what somebody took for a description.
            (true, true) if key == "board" => self.board += usize::from(!value.starts_with(['"', '\''])),
            // Of a board the guard is a table, of a plan a word.
            (true, true) if key == "guard" && value.starts_with(['"', '\'']) => {
                self.plan += 1;
                self.included += usize::from(INCLUDED_KEYS.iter().any(|known| known.name == key));
            }
            (true, true) if key == "guard" => self.board += 1,
            (true, true) => self.format |= key == "format" && value.starts_with(|c: char| c.is_ascii_digit()),
            (true, false) => {
                self.plan += 1;
                self.included += usize::from(INCLUDED_KEYS.iter().any(|known| known.name == key));
            }
            (false, true) => self.board += 1,
            (false, false) => {}
        }
    }

    fn kind(self) -> FileKind {
        let KeyCounts { format, plan, included, board, instrument, instrument_channel } = self;
        let instrument = instrument + usize::from(instrument_channel);
        // One word may be of any file; with `format`, or a second one, it is no chance.
        match plan.max(board).max(instrument) {
            0 if format => FileKind::Unclear,
            1 if !format => FileKind::Neither,
            0 => FileKind::Neither,
            _ if instrument > board.max(plan) => FileKind::Instrument,
            _ if board > plan => FileKind::Board,
            _ if format && plan == included => FileKind::Included,
            _ => FileKind::Plan,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_tell_plans_from_boards() {
        assert_eq!(
            of("format = 1\nprogram = \"a.st\"\nboard = \"b.toml\"\n[rows]\na = {}\n"),
            FileKind::Plan
        );
        assert_eq!(of("program = \"a.st\"\nexpect = [\n  { x = 1 },\n]\n"), FileKind::Plan);
        assert_eq!(of("format = 1\n[board]\nkind = \"simulated\"\n"), FileKind::Board);
        assert_eq!(of("format = 1\nboard = { kind = \"simulated\" }\n"), FileKind::Board);
        assert_eq!(of("\u{feff}format = 1\n[board]\nkind = \"simulated\"\n"), FileKind::Board);
        assert_eq!(of("format = 1\nboard.kind = \"simulated\"\n"), FileKind::Board);
        assert_eq!(of("format = 1\n[guard]\nlimit = \"1 ms\"\n"), FileKind::Board);
        assert_eq!(of("format = 1\nguard = \"none\"\nmeasure = []\n"), FileKind::Plan);
        assert_eq!(of("format = 1\n  [[wires]]\nfrom = \"Q0\"\n"), FileKind::Board);
        assert_eq!(of("format = 1\ntitle = \n"), FileKind::Unclear);
        assert_eq!(of(""), FileKind::Neither);
    }

    #[test]
    fn a_key_in_the_wrong_file_does_not_change_it() {
        assert_eq!(
            of("format = 1\nsteps = []\n[board]\nkind = \"x\"\n[bind]\n\"%IX0.0\" = \"I0\"\n"),
            FileKind::Board
        );
        assert_eq!(of("format = 1\nprogram = \"a.st\"\nexpect = []\nwires = []\n"), FileKind::Plan);
        assert_eq!(of("format = 1\nboard = \"simulated\"\nwires = []\n"), FileKind::Board);
    }

    #[test]
    fn what_is_included_does_nothing_itself() {
        assert_eq!(
            of("format = 1\nsignals = { a = \"%IX0.0\" }\n[group.x]\nsteps = []\n"),
            FileKind::Included
        );
        assert_eq!(of("format = 1\nsignals = { a = \"%IX0.0\" }\nexpect = []\n"), FileKind::Plan);
        assert_eq!(of("signals = {}\nsettings = {}\n"), FileKind::Plan);
    }

    #[test]
    fn an_instrument_file_has_a_clock_or_thresholds() {
        let clock = "format = 1\ntitle = \"Scope\"\n[timebase]\nerror = \"25 ppm\"\n";
        assert_eq!(of(clock), FileKind::Instrument);
        assert_eq!(of(&format!("{clock}[channels.CH1]\nunit = \"V\"\n")), FileKind::Instrument);
        assert_eq!(of("format = 1\ntimebase = { skew = \"2 ns\" }\n"), FileKind::Instrument);
        for channels in [
            "[channels.CH1]\nunit = \"V\"\nthreshold = \"2.5 V\"\n",
            "[channels]\nCH1 = { unit = \"V\", threshold = \"2.5 V\" }\n",
            "[channels]\nCH1.delay = \"5 ns\"\n",
            "channels.CH1.delay-error = \"1 ns\"\n",
            "channels = { CH1 = { hysteresis = \"1 V\" } }\n",
        ] {
            assert_eq!(of(&format!("format = 1\n{channels}")), FileKind::Instrument, "{channels}");
        }
        // A board file with a key of an instrument is a board file with a wrong key.
        assert_eq!(of("format = 1\n[channels.u]\nkind = \"analog\"\nunit = \"V\"\n"), FileKind::Board);
        assert_eq!(of("format = 1\n[board]\nkind = \"simulated\"\n[timebase]\n"), FileKind::Board);
        let board = "format = 1\n[board]\nkind = \"gpio\"\n[channels.u]\nthreshold = \"1 V\"\n";
        assert_eq!(of(board), FileKind::Board);
        assert_eq!(of("[timebase]\nx = 1\n"), FileKind::Neither);
    }

    #[test]
    fn files_of_other_programs_are_neither() {
        assert_eq!(of("[package]\nname = \"x\"\n[dependencies]\nprogram = \"1\"\n"), FileKind::Neither);
        assert_eq!(of("[project]\nname = \"x\"\n[tool.black]\nline-length = 88\n"), FileKind::Neither);
        assert_eq!(of("format = \"toml\"\n[tool]\n"), FileKind::Neither);
    }

    #[test]
    fn lines_of_lists_are_no_headers() {
        assert_eq!(of("format = 1\nvalues = [\n[1, 2],\n[3],\n]\nsteps = []\n"), FileKind::Plan);
        assert_eq!(of("format = 1\n[ board ]\nkind = \"simulated\"\n"), FileKind::Board);
    }
}
