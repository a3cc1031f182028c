//! Who has a device of this machine.

use std::fs;
use std::os::unix::fs::{FileTypeExt, MetadataExt};
use std::path::Path;

use rustix::param::clock_ticks_per_second;

/// A process that has a device open.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Holder {
    /// Its number.
    pub process: u32,
    /// Its name, as `ps` shows it.
    pub name: String,
    /// What it was started with, cut where that is long.
    pub command: String,
    /// How long it has been running, in seconds.
    pub runs_for: Option<u64>,
}

/// The longest command that is shown.
const LONGEST: usize = 120;

impl Holder {
    /// The process of this number; `None` where there is none.
    fn of(process: u32) -> Option<Holder> {
        let about = Path::new("/proc").join(process.to_string());
        let name = fs::read_to_string(about.join("comm")).ok()?.trim().to_owned();
        let words = fs::read(about.join("cmdline")).unwrap_or_default();
        let mut command = command(&words);
        if command.is_empty() {
            command.clone_from(&name);
        }
        let stat = fs::read_to_string(about.join("stat")).unwrap_or_default();
        let since_boot = fs::read_to_string("/proc/uptime").unwrap_or_default();
        Some(Holder { process, name, command, runs_for: runs_for(&stat, &since_boot) })
    }
}

/// The words that a program was started with, of which the first is a path. Anybody may have written them.
fn command(words: &[u8]) -> String {
    let mut words = words.split(|byte| *byte == 0).map(String::from_utf8_lossy);
    let program = words.next().unwrap_or_default();
    let program = program.rsplit('/').next().unwrap_or_default().to_owned();
    let all: Vec<String> = std::iter::once(program).chain(words.map(std::borrow::Cow::into_owned)).collect();
    let shown = all.join(" ");
    let shown = shown.trim_end().chars().map(|letter| if letter.is_control() { '?' } else { letter });
    shown.take(LONGEST).collect()
}

/// How long a process runs, from its line of figures and the time since the machine started.
fn runs_for(stat: &str, since_boot: &str) -> Option<u64> {
    // Its name, which may be anything, stands in brackets; after it the start is the twentieth figure.
    let ticks: u64 = stat.rsplit_once(')')?.1.split_whitespace().nth(19)?.parse().ok()?;
    let now: u64 = since_boot.split('.').next()?.parse().ok()?;
    Some(now.saturating_sub(ticks.checked_div(clock_ticks_per_second())?))
}

impl std::fmt::Display for Holder {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "`{}` (process {}", self.command, self.process)?;
        match self.runs_for {
            Some(seconds) => write!(f, ", running for {seconds} s)"),
            None => f.write_str(")"),
        }
    }
}

/// Who has a device open, but this process; those whom this user may see.
pub fn holders(path: &Path) -> Vec<Holder> {
    let own = std::process::id();
    let mut all = all_holders(path);
    all.retain(|holder| holder.process != own);
    all
}

/// Holders in a sentence, as in `is held by ...`; `others` where none can be seen.
pub(crate) fn words(holders: &[Holder], others: &str) -> String {
    let words: Vec<String> = holders.iter().map(Holder::to_string).collect();
    if words.is_empty() { others.to_owned() } else { words.join(", ") }
}

/// Who has a device open; those whom this user may see.
pub(crate) fn all_holders(path: &Path) -> Vec<Holder> {
    let Ok(about) = fs::metadata(path) else { return Vec::new() };
    let open = |process: &u32| {
        let files = fs::read_dir(format!("/proc/{process}/fd")).into_iter().flatten().flatten();
        files
            .filter_map(|file| fs::metadata(file.path()).ok())
            .any(|file| file.file_type().is_char_device() && file.rdev() == about.rdev() && about.rdev() != 0)
    };
    let processes = fs::read_dir("/proc").into_iter().flatten().flatten();
    let mut all: Vec<Holder> = processes
        .filter_map(|entry| entry.file_name().to_str()?.parse().ok())
        .filter(open)
        .filter_map(Holder::of)
        .collect();
    let locked = fs::canonicalize(path).ok().and_then(|device| lock(Path::new("/run/lock"), &device));
    all.extend(locked.filter(|holder| all.iter().all(|other| other.process != holder.process)));
    all.sort_by_key(|holder| holder.process);
    all
}

/// Who has locked a device by a file that old terminal programs agree on (Filesystem Hierarchy Standard, 5.9): it holds the
/// number of a process, in ten columns. One whose process is no more means nothing.
fn lock(folder: &Path, device: &Path) -> Option<Holder> {
    let file = folder.join(format!("LCK..{}", device.file_name()?.to_str()?));
    // Everybody may write into the folder: whatever else lies there under this name is not waited for, nor read to its end.
    let text = String::from_utf8(document::file::read_start(&file, 64).ok()?).ok()?;
    let process: u32 = text.split_whitespace().next()?.parse().ok()?;
    Holder::of(process)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lock_file_names_its_process_while_that_lives() {
        let folder = std::env::temp_dir().join(format!("locks-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let device = Path::new("/dev/ttyS9");
        let with = |text: &str| {
            fs::write(folder.join("LCK..ttyS9"), text).unwrap();
            lock(&folder, device).map(|holder| holder.process)
        };
        assert_eq!(lock(&folder, device), None);
        let own = std::process::id();
        assert_eq!(with(&format!("{own:>10}\n")), Some(own));
        assert_eq!(with(&format!("{own:>10} minicom root\n")), Some(own));
        // Numbers of processes end far below this.
        for text in ["4294967295\n", "", "\n", "minicom", "-1"] {
            assert_eq!(with(text), None, "{text}");
        }
        fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn a_holder_is_named_by_its_command_and_its_age() {
        let stat = "7 (a) b) S 1 7 7 0 -1 4194560 1 0 0 0 0 0 0 0 20 0 1 0 4200 9 9";
        let ticks = 4200 / clock_ticks_per_second();
        assert_eq!(runs_for(stat, "100.25 180.00\n"), Some(100 - ticks));
        assert_eq!(
            (runs_for("7 (a", "100.2"), runs_for(stat, ""), runs_for("7 (a) S 1", "1.0")),
            (None, None, None)
        );
        assert_eq!(command(b"/usr/bin/rig\0run\0a\x1b[2J\0"), "rig run a?[2J");
        assert_eq!((command(b"").as_str(), command(&[b'x'; 500]).len()), ("", LONGEST));
        let holder = Holder { process: 7, name: "rig".into(), command: "rig run".into(), runs_for: Some(9) };
        assert_eq!(words(&[holder], "somebody"), "`rig run` (process 7, running for 9 s)");
        assert_eq!((words(&[], "somebody"), holders(Path::new("/dev/nowhere"))), ("somebody".into(), vec![]));
    }
}
