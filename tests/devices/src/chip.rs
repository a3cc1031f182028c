//! Simulated chips: their lines from the side of the world.

use crate::write;
use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};

/// Who holds the lines that the lab keeps to itself.
pub(crate) const HOG: &str = "lab-hog";

/// One of the lab's two chips that are always there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Chip {
    number: u8,
    label: &'static str,
    lines: u32,
}

/// The chip with 32 lines. Lines 24 to 26 are named `DOOR`, `PUMP` and `VALVE`.
pub const MAIN: Chip = Chip { number: 0, label: "rig-gpio", lines: 32 };
/// The chip with 8 lines. Line 5 is named `VALVE`, as one of the other chip is; line 7 (`HOGGED`) is held by
/// `lab-hog`.
pub const AUX: Chip = Chip { number: 1, label: "rig-gpio-aux", lines: 8 };

impl Chip {
    /// Its label.
    pub fn label(self) -> &'static str {
        self.label
    }

    /// How many lines it has.
    pub fn count(self) -> u32 {
        self.lines
    }

    /// Its device file.
    ///
    /// # Panics
    /// When the lab has none.
    pub fn path(self) -> PathBuf {
        let link = format!("/dev/rig/gpio{}", self.number);
        fs::canonicalize(&link).unwrap_or_else(|error| panic!("{link}: {error}"))
    }

    /// A line of it.
    pub fn line(self, number: u32) -> Line {
        assert!(number < self.lines, "{} has {} lines", self.label, self.lines);
        Line { chip: self, number }
    }

    /// All its lines.
    pub fn lines(self) -> impl Iterator<Item = Line> {
        (0..self.lines).map(move |number| Line { chip: self, number })
    }
}

/// A line, as the world outside of the machine sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Line {
    chip: Chip,
    number: u32,
}

impl Line {
    /// Its number on its chip.
    pub fn number(self) -> u32 {
        self.number
    }

    /// Drives it from outside: an input line reads this level then. It is also what a line goes back to when an
    /// output is released.
    pub fn pull(self, high: bool) {
        write(&self.file("pull"), if high { "pull-up" } else { "pull-down" });
    }

    /// The file that [`Line::pull`] writes, for who writes it often.
    pub fn pull_file(self) -> PathBuf {
        self.file("pull")
    }

    /// The level on the line, whoever makes it.
    ///
    /// # Panics
    /// When the lab does not say.
    pub fn value(self) -> bool {
        read_level(&self.file("value"))
    }

    /// The lab keeps this line to itself.
    pub(crate) fn hogged(self) -> bool {
        self == AUX.line(7)
    }

    fn file(self, name: &str) -> PathBuf {
        PathBuf::from(format!("/run/lab/gpio{}/sim_gpio{}/{name}", self.chip.number, self.number))
    }
}

impl fmt::Display for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.chip.label, self.number)
    }
}

/// A chip of the test's own, which can be taken away. Its lines cannot be wired.
#[derive(Debug)]
pub struct SimChip {
    config: PathBuf,
    side: PathBuf,
    path: PathBuf,
}

impl SimChip {
    /// Adds a chip with this label, its lines named as given (an empty name is none).
    ///
    /// # Panics
    /// When the kernel refuses.
    pub fn add(label: &str, names: &[&str]) -> SimChip {
        let config = PathBuf::from(format!("/sys/kernel/config/gpio-sim/{label}"));
        let bank = config.join("bank0");
        fs::create_dir_all(&bank).expect("a simulated chip");
        write(&bank.join("label"), label);
        write(&bank.join("num_lines"), &names.len().to_string());
        for (number, name) in names.iter().enumerate().filter(|(_, name)| !name.is_empty()) {
            let line = bank.join(format!("line{number}"));
            fs::create_dir(&line).expect("a named line");
            write(&line.join("name"), name);
        }
        write(&config.join("live"), "1");
        let name = |path: PathBuf| fs::read_to_string(path).expect("the new chip's name").trim().to_owned();
        let chip = name(bank.join("chip_name"));
        let side = Path::new("/sys/devices/platform").join(name(config.join("dev_name"))).join(&chip);
        SimChip { config, side, path: Path::new("/dev").join(chip) }
    }

    /// Its device file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Drives a line from outside.
    pub fn pull(&self, line: u32, high: bool) {
        write(&self.side.join(format!("sim_gpio{line}/pull")), if high { "pull-up" } else { "pull-down" });
    }

    /// The level on a line.
    ///
    /// # Panics
    /// When the lab does not say.
    pub fn value(&self, line: u32) -> bool {
        read_level(&self.side.join(format!("sim_gpio{line}/value")))
    }

    /// Takes the chip away, whoever uses it.
    pub fn vanish(&self) {
        write(&self.config.join("live"), "0");
    }
}

impl Drop for SimChip {
    fn drop(&mut self) {
        // Already gone, when the test made it vanish.
        let _ = fs::write(self.config.join("live"), "0");
        let bank = self.config.join("bank0");
        for entry in fs::read_dir(&bank).into_iter().flatten().flatten() {
            if entry.file_name().to_string_lossy().starts_with("line") {
                let _ = fs::remove_dir(entry.path());
            }
        }
        let _ = fs::remove_dir(&bank);
        let _ = fs::remove_dir(&self.config);
    }
}

fn read_level(path: &Path) -> bool {
    match fs::read_to_string(path) {
        Ok(text) => text.trim() == "1",
        Err(error) => panic!("{}: {error}", path.display()),
    }
}
