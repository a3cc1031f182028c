//! Figures of this machine that are kept from one run to the next.

use crate::codes;
use crate::suite::describe::hex;
use document::{Diagnostic, file};
use drivers::gpio::GpioSpec;
use drivers::{BoardFile, BoardKind};
use host::{Histogram, HostMachine};
use record::{Durations, MAX_MACHINE_BYTES, MachineRecord};
use sha2::{Digest, Sha256};
use signal::Span;
use std::ffi::OsString;
use std::fmt::Write as _;
use std::io::Write;
use std::path::{Path, PathBuf};

/// How many durations are needed for one of 10 000 to be distinguished from the greatest.
pub const ENOUGH: u64 = 10_000;

/// Where the figures of the user's machine are kept: `rig` in the folder for what programs keep, by the XDG Base
/// Directory Specification. `None` where there is no home.
pub fn folder() -> Option<PathBuf> {
    folder_of(std::env::var_os("XDG_STATE_HOME"), std::env::var_os("HOME"))
}

fn folder_of(state: Option<OsString>, home: Option<OsString>) -> Option<PathBuf> {
    // The specification: a path that is not absolute is none.
    let absolute = |text: Option<OsString>| text.map(PathBuf::from).filter(|path| path.is_absolute());
    let state = absolute(state).or_else(|| Some(absolute(home)?.join(".local/state")))?;
    Some(state.join("rig"))
}

/// The kind of the figures of `rig bench counts`.
pub const COUNTS: &str = "counts";

/// How fast pulses can be for a board to count every one, and how fast it makes them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CountingLimit {
    /// The fastest pulses of which all were counted each time, in Hz.
    pub counted_hz: u64,
    /// The fastest that were made, in Hz.
    pub made_hz: u64,
    /// Faster ones were made, and some of them were missing.
    pub is_limit: bool,
}

impl CountingLimit {
    /// As settings of the figures that are kept.
    pub fn settings(&self) -> [(String, String); 3] {
        let limit = if self.is_limit { "yes" } else { "no" };
        [
            (String::from("counted Hz"), self.counted_hz.to_string()),
            (String::from("made Hz"), self.made_hz.to_string()),
            (String::from("faster ones were lost"), String::from(limit)),
        ]
    }

    /// Out of figures that were kept.
    pub fn of(record: &MachineRecord) -> Option<CountingLimit> {
        let text = |name: &str| {
            let found = record.settings.iter().find(|(known, _)| known == name);
            found.map(|(_, text)| text.as_str())
        };
        Some(CountingLimit {
            counted_hz: text("counted Hz")?.parse().ok()?,
            made_hz: text("made Hz")?.parse().ok()?,
            is_limit: text("faster ones were lost")? == "yes",
        })
    }

    /// What was counted, in words.
    pub fn counted(&self) -> String {
        let hz = self.counted_hz;
        match (hz, self.is_limit) {
            (0, _) => String::from("no pulses, not even the slowest"),
            (hz, true) => format!("up to {hz} Hz"),
            (hz, false) => format!("up to {hz} Hz at least: no faster pulses could be made"),
        }
    }

    /// A promise of an input that was not kept when it was measured, as a finding.
    pub fn broken(&self, input: &str, promised_hz: u64) -> Option<Diagnostic> {
        if promised_hz <= self.counted_hz {
            return None;
        }
        let counted = self.counted();
        let message =
            format!("the board file promises to count {promised_hz} Hz of `{input}`; measured: {counted}");
        let help = match self.is_limit || self.counted_hz == 0 {
            true => format!(
                "write counts-up-to = \"{} Hz\" or less, or count with a counter of the kernel",
                self.counted_hz.max(1)
            ),
            false => String::from("measure with a faster output: a generator by --out, wired to the input"),
        };
        Some(Diagnostic::warning(codes::PROMISE_NOT_KEPT, message).help(help))
    }
}

/// What a histogram says, under a name. `None` of an empty one.
pub fn durations(name: &str, of: &Histogram) -> Option<Durations> {
    (of.count() > 0).then(|| Durations {
        name: name.to_owned(),
        count: of.count(),
        min_ns: of.min(),
        mean_ns: of.mean(),
        p50_ns: of.millionths(500_000),
        p99_ns: of.millionths(990_000),
        p99_99_ns: of.millionths(999_900),
        max_ns: of.max(),
    })
}

/// The file of a kind of figures; those of a board have a file for each board.
pub fn path(folder: &Path, kind: &str, board_sha256: &str) -> PathBuf {
    let board: String = board_sha256.chars().take(16).collect();
    folder.join(if board.is_empty() { format!("{kind}.json") } else { format!("{kind}-{board}.json") })
}

/// Keeps figures in place of earlier ones of their kind, wholly or not at all, and says where.
///
/// # Errors
/// What the operating system says.
pub fn keep(folder: &Path, record: &MachineRecord) -> std::io::Result<PathBuf> {
    std::fs::create_dir_all(folder)?;
    let path = path(folder, &record.kind, &record.board_sha256);
    let mut file = atomic_write_file::AtomicWriteFile::open(&path)?;
    file.write_all(record.to_json().as_bytes())?;
    file.commit()?;
    Ok(path)
}

/// The figures of a kind that were kept. `None` where there are none.
///
/// # Errors
/// Why a file that is there cannot be read.
pub fn kept(folder: &Path, kind: &str, board_sha256: &str) -> Result<Option<MachineRecord>, String> {
    let bytes = match file::read(&path(folder, kind, board_sha256), MAX_MACHINE_BYTES) {
        Ok(bytes) => bytes,
        Err(fault) if fault.is_not_found() => return Ok(None),
        Err(fault) => return Err(fault.to_string()),
    };
    let text = String::from_utf8(bytes).map_err(|_| String::from("it is no UTF-8 text"))?;
    let record = MachineRecord::from_json(&text)?;
    if record.kind == kind && record.board_sha256 == board_sha256 {
        Ok(Some(record))
    } else {
        Err(String::from("it holds figures of something else"))
    }
}

/// What distinguishes the devices of a board from those of another, 64 hexadecimal digits; empty for a board without real
/// lines. Channels, names and terminals do not matter: the times of a chip are those of its chip.
pub fn devices(file: &BoardFile) -> String {
    let BoardKind::Real(spec) = &file.kind else { return String::new() };
    let Some(spec) = spec.of::<GpioSpec>() else { return String::new() };
    let mut text = format!("gpio {:?}\n", spec.backend);
    for chip in &spec.chips {
        let _ = writeln!(text, "{:?}", chip.find);
    }
    hex(&Sha256::digest(text))
}

/// What is known of this machine with the devices of a board, for those that judge what it sees.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MachineFigures {
    /// How long before its stamp an edge may have happened: 9 999 of 10 000 did not take longer. 0 where that was not
    /// measured.
    pub resolution: Span,
    /// For the record of a run, name and text.
    pub facts: Vec<(String, String)>,
    /// Figures that are there and are not of this machine: to be said once.
    pub warnings: Vec<Diagnostic>,
}

/// What is kept of this machine with the devices of a board.
pub fn standing(file: &BoardFile) -> MachineFigures {
    standing_in(folder().as_deref(), file, &HostMachine::here().identity())
}

fn standing_in(folder: Option<&Path>, file: &BoardFile, machine: &[(String, String)]) -> MachineFigures {
    let mut standing = MachineFigures::default();
    let devices = devices(file);
    let of = [("loopback", devices.as_str(), "Edges stamped within"), ("latency", "", "Woken up within")];
    for (kind, devices, name) in of {
        let found = folder.map_or(Ok(None), |folder| kept(folder, kind, devices));
        let text = match found {
            Ok(Some(record)) => match (record.differences(machine).first(), record.figures.first()) {
                (None, Some(figure)) => {
                    let within = Span::from_nanos(i64::try_from(figure.p99_99_ns).unwrap_or(i64::MAX));
                    if kind == "loopback" {
                        standing.resolution = within;
                    }
                    let worst = Span::from_nanos(i64::try_from(figure.max_ns).unwrap_or(i64::MAX));
                    format!(
                        "{within} (9999 of 10000), worst of {} {worst}, measured {}",
                        figure.count, record.measured
                    )
                }
                (Some((what, then, now)), _) => {
                    let message = format!(
                        "the figures of `rig bench {kind}` are not used: the {what} was `{then}` and is `{now}`"
                    );
                    standing.warnings.push(unused(message, kind));
                    format!("not known: the {what} has changed since it was measured")
                }
                (None, None) => String::from("not measured"),
            },
            Ok(None) => String::from("not measured"),
            Err(error) => {
                let message = format!("the figures of `rig bench {kind}` cannot be read: {error}");
                standing.warnings.push(unused(message, kind));
                String::from("not known: the figures cannot be read")
            }
        };
        standing.facts.push((name.to_owned(), text));
    }
    standing
}

fn unused(message: String, kind: &str) -> Diagnostic {
    Diagnostic::warning(codes::FIGURES_OF_ANOTHER_MACHINE, message)
        .help(format!("measure again: `rig bench {kind}`"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_folder_is_that_of_the_specification() {
        let of = |state: Option<&str>, home: Option<&str>| {
            folder_of(state.map(OsString::from), home.map(OsString::from))
        };
        assert_eq!(of(Some("/state"), Some("/home/a")), Some(PathBuf::from("/state/rig")));
        assert_eq!(of(Some("state"), Some("/home/a")), Some(PathBuf::from("/home/a/.local/state/rig")));
        assert_eq!(of(None, Some("/home/a")), Some(PathBuf::from("/home/a/.local/state/rig")));
        assert_eq!(of(Some(""), None), None);
    }

    #[test]
    fn figures_are_kept_for_each_kind_and_board_and_a_torn_file_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        let mut histogram = Histogram::new();
        (1..=100).for_each(|nanos| histogram.note(nanos * 1_000));
        let mut record = MachineRecord {
            format: record::MACHINE_FORMAT,
            kind: "loopback".into(),
            board_sha256: "ab".repeat(32),
            figures: durations("call to stamp", &histogram).into_iter().collect(),
            ..MachineRecord::default()
        };
        assert_eq!(kept(folder, "loopback", &record.board_sha256), Ok(None));
        let path = keep(folder, &record).unwrap();
        assert_eq!(path.file_name().unwrap(), "loopback-abababababababab.json");
        assert_eq!(kept(folder, "loopback", &record.board_sha256), Ok(Some(record.clone())));
        assert_eq!(kept(folder, "loopback", ""), Ok(None));
        // Another board whose sum begins the same is no match.
        let other = format!("{}cd", "ab".repeat(31));
        assert!(kept(folder, "loopback", &other).is_err());
        record.figures.clear();
        keep(folder, &record).unwrap();
        assert_eq!(kept(folder, "loopback", &record.board_sha256), Ok(Some(record)));
        std::fs::write(&path, "{").unwrap();
        assert!(kept(folder, "loopback", &"ab".repeat(32)).is_err());
    }

    #[test]
    fn what_stands_is_of_this_machine_and_of_these_devices() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path();
        let folder = Some(path);
        let file = BoardFile::default_for(&[], &[]);
        let machine = vec![(String::from("kernel"), String::from("Linux 6.12"))];
        let text = |standing: &MachineFigures, place: usize| standing.facts[place].1.clone();
        let none = standing_in(folder, &file, &machine);
        assert_eq!(
            (none.resolution, text(&none, 0), text(&none, 1).as_str()),
            (Span::ZERO, String::from("not measured"), "not measured")
        );
        let mut histogram = Histogram::new();
        (1..=20_000).for_each(|nanos| histogram.note(nanos));
        let mut record = MachineRecord {
            format: record::MACHINE_FORMAT,
            kind: "loopback".into(),
            measured: "2026-11-22T09:00:00Z".into(),
            machine: machine.clone(),
            figures: durations("call to stamp", &histogram).into_iter().collect(),
            ..MachineRecord::default()
        };
        keep(path, &record).unwrap();
        let known = standing_in(folder, &file, &machine);
        assert!(known.resolution >= Span::from_nanos(19_998) && known.resolution <= Span::from_nanos(20_000));
        assert!(text(&known, 0).contains("worst of 20000 20 us, measured 2026-11-22"), "{}", text(&known, 0));
        assert!(known.warnings.is_empty());
        // Another kernel: nothing is known, and that is said.
        let other = vec![(String::from("kernel"), String::from("Linux 6.18"))];
        let unknown = standing_in(folder, &file, &other);
        assert_eq!((unknown.resolution, unknown.warnings.len()), (Span::ZERO, 1));
        assert_eq!(unknown.warnings[0].code, "R0252");
        record.figures.clear();
        keep(path, &record).unwrap();
        assert_eq!(standing_in(folder, &file, &machine).resolution, Span::ZERO);
        assert_eq!(standing_in(None, &file, &machine).facts.len(), 2);
    }
}
