//! One user of a bench at a time.
//!
//! Each device has a file in a folder that all users share; a line of a chip is a piece of it. Who uses a device or a line
//! has locked its piece and written into it who they are. The kernel takes the lock away when its holder ends, however it ends, so nothing is
//! ever stale.

use crate::codes;
use document::Diagnostic;
use drivers::real::{Used, uses};
use drivers::{BoardFile, BoardKind};
use host::lock_bytes;
use rustix::fs::{Mode, OFlags, chmod};
use signal::Span;
use std::ffi::OsString;
use std::fs::File;
use std::io;
use std::os::unix::fs::{FileExt, MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// Bytes of a file that stand for a line, or for a device that is taken as a whole.
const PIECE: u64 = 256;

/// What stands before the name of a network interface.
const NETWORK: &str = "net:";

/// The variable that names the shared folder.
const FOLDER: &str = "RIG_LOCK_DIR";

/// Where programs leave locks, by the Filesystem Hierarchy Standard; the first that takes some.
const FOLDERS: [&str; 2] = ["/run/lock", "/var/lock"];

/// How often a bench that is waited for is looked at: the kernel has no wait for a lock that ends at a time.
const LOOK: Duration = Duration::from_millis(100);

/// The devices of a bench, until this is dropped.
#[derive(Debug)]
pub struct BenchLock {
    /// Open as long as they are locked.
    _files: Vec<File>,
    /// What is worth knowing of the folder that the locks are in.
    warning: Option<Diagnostic>,
}

impl BenchLock {
    /// What is worth knowing of the locks.
    pub const fn warning(&self) -> Option<&Diagnostic> {
        self.warning.as_ref()
    }
}

/// A device or a line that somebody else has.
#[derive(Debug)]
struct TakenResource {
    what: String,
    holder: Option<BenchHolder>,
}

/// Who has it.
#[derive(Clone, Debug, PartialEq, Eq)]
struct BenchHolder {
    process: u32,
    /// Seconds since 1970.
    since: u64,
    user: String,
    command: String,
}

impl BenchHolder {
    fn here() -> BenchHolder {
        let command = std::fs::read("/proc/self/cmdline").unwrap_or_default();
        let mut words = command.split(|byte| *byte == 0).map(String::from_utf8_lossy);
        let program = words.next().unwrap_or_default();
        let program = program.rsplit('/').next().unwrap_or_default().to_owned();
        let words: Vec<String> =
            std::iter::once(program).chain(words.map(|word| word.into_owned())).collect();
        let uid = rustix::process::geteuid().as_raw();
        let users = std::fs::read_to_string("/etc/passwd").unwrap_or_default();
        BenchHolder {
            process: std::process::id(),
            since: now(),
            user: user(&users, uid).unwrap_or_else(|| format!("user {uid}")),
            command: words.join(" ").trim_end().to_owned(),
        }
    }

    /// As it stands in a piece: what is too long is cut.
    fn piece(&self) -> [u8; PIECE as usize] {
        let BenchHolder { process, since, user, command } = self;
        let mut text = format!("{process}\t{since}\t{user}\t{command}");
        text.retain(|letter| letter == '\t' || !letter.is_control());
        let mut piece = [0; PIECE as usize];
        for (to, from) in piece.iter_mut().zip(text.bytes()) {
            *to = from;
        }
        piece
    }

    /// What a piece says. Anybody may have written it.
    fn of(piece: &[u8]) -> Option<BenchHolder> {
        let end = piece.iter().position(|byte| *byte == 0).unwrap_or(piece.len());
        let text = String::from_utf8_lossy(&piece[..end]);
        let mut parts = text.splitn(4, '\t');
        let mut text = || {
            let part = parts.next()?;
            Some(
                part.chars().map(|letter| if letter.is_control() { '?' } else { letter }).collect::<String>(),
            )
        };
        Some(BenchHolder {
            process: text()?.parse().ok()?,
            since: text()?.parse().ok()?,
            user: text()?,
            command: text()?,
        })
    }
}

fn now() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs())
}

fn user(users: &str, uid: u32) -> Option<String> {
    users.lines().find_map(|line| {
        let mut parts = line.split(':');
        let name = parts.next()?;
        (parts.nth(1)?.parse() == Ok(uid)).then(|| name.to_owned())
    })
}

/// Takes the devices of a board for this process; `None` where the board has none on this machine. Where somebody else has
/// one, `wait` is how long to wait for them, if at all, and `report` hears once for whom.
///
/// # Errors
/// Who has them; a place for locks that is no whole path; a warning where this machine has no place for locks, and the bench
/// is used without.
pub fn take(
    board: &BoardFile,
    wait: Option<Span>,
    interrupt: &AtomicBool,
    report: &dyn Fn(&str),
) -> Result<Option<BenchLock>, Diagnostic> {
    let BoardKind::Real(spec) = &board.kind else { return Ok(None) };
    let used = uses(spec);
    if used.is_empty() {
        return Ok(None);
    }
    let folder = match named_folder(std::env::var_os(FOLDER))? {
        Some(named) => folder(&[named]),
        None => folder(&usual_folders()),
    };
    let folder = folder.map_err(|error| without(&error))?;
    let begun = Instant::now();
    let mut waits = false;
    loop {
        let taken = match lock(&folder, &used).map_err(|error| without(&error))? {
            Ok(lock) => return Ok(Some(BenchLock { warning: ruled_by_others(&folder), ..lock })),
            Err(taken) => taken,
        };
        let lasts = wait.map(|wait| Duration::from_nanos(u64::try_from(wait.as_nanos()).unwrap_or(0)));
        let over = lasts.is_none_or(|lasts| begun.elapsed() >= lasts);
        if over || interrupt.load(Ordering::Relaxed) {
            return Err(in_use(&taken, wait));
        }
        if !std::mem::replace(&mut waits, true) {
            report(&format!("waiting for the bench: {}", words(&taken)));
        }
        std::thread::sleep(LOOK);
    }
}

/// Locks all devices or none.
fn lock(folder: &Path, used: &[Used]) -> io::Result<Result<BenchLock, TakenResource>> {
    let own = BenchHolder::here().piece();
    let mut files = Vec::new();
    for Used { device, lines } in used {
        let file = open(&folder.join(format!("{device}.lock")))?;
        for number in lines.as_deref().unwrap_or(&[0]) {
            let start = u64::from(*number) * PIECE;
            if !lock_bytes(&file, start, PIECE)? {
                let mut piece = [0; PIECE as usize];
                let holder =
                    file.read_exact_at(&mut piece, start).ok().and_then(|()| BenchHolder::of(&piece));
                let what = match lines {
                    Some(_) => format!("line {number} of {device}"),
                    None => device.trim_start_matches(NETWORK).to_owned(),
                };
                return Ok(Err(TakenResource { what, holder }));
            }
            file.write_all_at(&own, start)?;
        }
        files.push(file);
    }
    Ok(Ok(BenchLock { _files: files, warning: None }))
}

/// Opens a file that every user may write. One of another user is not created again: the kernel may refuse that in a
/// folder that all share.
fn open(path: &Path) -> io::Result<File> {
    // Whoever can write into the folder must not choose which file is overwritten, or hold up who opens it.
    let flags = (OFlags::NOFOLLOW | OFlags::NONBLOCK).bits().cast_signed();
    let mut options = File::options();
    options.read(true).write(true).custom_flags(flags);
    match options.open(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => {}
        opened => return opened,
    }
    match options.create_new(true).open(path) {
        Ok(file) => {
            file.set_permissions(std::fs::Permissions::from_mode(0o666))?;
            Ok(file)
        }
        // Somebody was quicker.
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
            File::options().read(true).write(true).custom_flags(flags).open(path)
        }
        Err(error) => Err(error),
    }
}

/// The folder that the environment names, if it names one.
///
/// # Errors
/// It is no whole path: two commands that are started in two folders would not meet in it.
fn named_folder(named: Option<OsString>) -> Result<Option<PathBuf>, Diagnostic> {
    let Some(named) = named.filter(|named| !named.is_empty()).map(PathBuf::from) else { return Ok(None) };
    if named.is_absolute() {
        return Ok(Some(named));
    }
    let message = format!("`{FOLDER}` is `{}`, which is no whole path", named.display());
    let help = format!("write the path from the root, as in {FOLDER}=/run/lock/scanrig, or unset it");
    Err(Diagnostic::error(codes::LOCK_FOLDER_NOT_WHOLE, message).help(help))
}

fn usual_folders() -> Vec<PathBuf> {
    let usual = FOLDERS.iter().map(PathBuf::from).chain(Some(std::env::temp_dir()));
    usual.map(|folder| folder.join("scanrig")).collect()
}

/// The folder that all users of this machine share: the first that there is or that can be made.
fn folder(candidates: &[PathBuf]) -> io::Result<PathBuf> {
    let mut last = io::Error::from(io::ErrorKind::NotFound);
    for folder in candidates {
        let error = match std::fs::create_dir(folder) {
            Ok(()) => {
                // Everybody may add files, and nobody take away those of others.
                let all = Mode::RWXU | Mode::RWXG | Mode::RWXO | Mode::SVTX;
                let _ = chmod(folder, all);
                return Ok(folder.clone());
            }
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
                // A link may lead another user elsewhere tomorrow.
                match std::fs::symlink_metadata(folder) {
                    Ok(found) if found.is_dir() => return Ok(folder.clone()),
                    Ok(_) => io::Error::from(io::ErrorKind::NotADirectory),
                    Err(error) => error,
                }
            }
            Err(error) => error,
        };
        last = io::Error::new(error.kind(), format!("{}: {error}", folder.display()));
    }
    Err(last)
}

/// A warning where somebody else can take locks out of the folder, so that two users may have the same bench.
fn ruled_by_others(folder: &Path) -> Option<Diagnostic> {
    let found = std::fs::metadata(folder).ok()?;
    let (owner, mode) = (found.uid(), found.mode());
    let (sticky, shared) = (Mode::SVTX.bits(), (Mode::WGRP | Mode::WOTH).bits());
    let why = if owner != 0 && owner != rustix::process::geteuid().as_raw() {
        let users = std::fs::read_to_string("/etc/passwd").unwrap_or_default();
        let owner = user(&users, owner).unwrap_or_else(|| format!("user {owner}"));
        format!("belongs to {owner}, who can remove the locks of others")
    } else if mode & shared != 0 && mode & sticky == 0 {
        "lets its users remove the locks of others".into()
    } else {
        return None;
    };
    let message = format!("the folder for locks `{}` {why}", folder.display());
    let path = folder.display();
    let help = format!("make it root's, as with `sudo chown root {path} && sudo chmod 1777 {path}`");
    Some(Diagnostic::warning(codes::LOCK_FOLDER_OF_OTHERS, message).help(help))
}

/// Who has what, since when.
fn words(taken: &TakenResource) -> String {
    match &taken.holder {
        Some(BenchHolder { process, since, user, command }) => {
            let lasts = now().saturating_sub(*since);
            let (what, process) = (&taken.what, *process);
            format!("{user} has had {what} for {lasts} s with `{command}`, process {process}")
        }
        None => format!("somebody has {}", taken.what),
    }
}

fn in_use(taken: &TakenResource, wait: Option<Span>) -> Diagnostic {
    let mut message = words(taken);
    if let Some(wait) = wait {
        message += &format!(", and it did not come free within {wait}");
    }
    let help = "one user has a bench at a time: end that command, or wait for it, as by --wait '10 min'";
    Diagnostic::error(codes::BENCH_IN_USE, message).help(help)
}

fn without(error: &io::Error) -> Diagnostic {
    let message = format!("there is no place for locks, so another user is not kept off the bench: {error}");
    let help = format!("give {FOLDER} a folder that every user of this machine may write to");
    Diagnostic::warning(codes::NO_PLACE_FOR_LOCKS, message).help(help)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn used(lines: &[u32]) -> Vec<Used> {
        vec![Used { device: "gpiochip0".into(), lines: Some(lines.to_vec()) }]
    }

    #[test]
    fn a_device_has_one_user_beside_those_of_others() {
        let folder = tempfile::tempdir().unwrap();
        let of = |devices: &[&str]| -> Vec<Used> {
            devices.iter().map(|device| Used { device: (*device).into(), lines: None }).collect()
        };
        let one = lock(folder.path(), &of(&["ttyUSB0", "net:can0"])).unwrap().unwrap();
        let beside = lock(folder.path(), &of(&["spidev0.0", "net:can1"])).unwrap().unwrap();
        let taken = lock(folder.path(), &of(&["spidev0.1", "net:can0"])).unwrap().unwrap_err();
        assert_eq!(taken.what, "can0");
        // All or nothing.
        assert!(lock(folder.path(), &of(&["spidev0.1"])).unwrap().is_ok());
        drop(one);
        assert!(lock(folder.path(), &of(&["net:can0"])).unwrap().is_ok());
        drop(beside);
    }

    #[test]
    fn a_lock_is_no_link_to_another_file() {
        let folder = tempfile::tempdir().unwrap();
        let victim = folder.path().join("victim");
        std::fs::write(&victim, "kept").unwrap();
        let path = folder.path().join("x.lock");
        std::os::unix::fs::symlink(&victim, &path).unwrap();
        assert!(open(&path).is_err());
        assert_eq!(std::fs::read_to_string(&victim).unwrap(), "kept");
    }

    #[test]
    fn a_line_has_one_user_who_is_named_and_others_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let one = lock(folder.path(), &used(&[3, 7])).unwrap().unwrap();
        let taken = lock(folder.path(), &used(&[1, 7])).unwrap().unwrap_err();
        assert_eq!(taken.what, "line 7 of gpiochip0");
        assert_eq!(taken.holder.as_ref().map(|holder| holder.process), Some(std::process::id()));
        let found = in_use(&taken, Some(Span::from_secs(2)));
        let process = format!("process {}, and it did not come free within 2 s", std::process::id());
        assert!(found.code == "R0280" && found.message.ends_with(&process), "{}", found.message);
        // All or nothing: line 1 was not kept.
        let beside = lock(folder.path(), &used(&[1, 8])).unwrap().unwrap();
        drop(one);
        assert!(lock(folder.path(), &used(&[3, 7])).unwrap().is_ok());
        drop(beside);
    }

    #[test]
    fn a_folder_that_somebody_else_rules_is_reported_and_a_link_is_none() {
        let place = tempfile::tempdir().unwrap();
        let shared = place.path().join("shared");
        assert_eq!(folder(std::slice::from_ref(&shared)).unwrap(), shared);
        assert_eq!(ruled_by_others(&shared), None);
        std::fs::set_permissions(&shared, std::fs::Permissions::from_mode(0o777)).unwrap();
        assert_eq!(ruled_by_others(&shared).unwrap().code, "R0283");
        let link = place.path().join("link");
        std::os::unix::fs::symlink(&shared, &link).unwrap();
        assert_eq!(folder(&[link.clone(), shared.clone()]).unwrap(), shared);
        assert_eq!(folder(&[link]).unwrap_err().kind(), io::ErrorKind::NotADirectory);
    }

    #[test]
    fn a_folder_is_named_by_a_whole_path() {
        let named = |text: &str| named_folder(Some(text.into()));
        assert_eq!(named("/run/lock/x"), Ok(Some("/run/lock/x".into())));
        assert_eq!((named(""), named_folder(None)), (Ok(None), Ok(None)));
        assert_eq!(named("locks").unwrap_err().code, "R0282");
    }

    #[test]
    fn what_others_wrote_is_read_with_care() {
        let holder =
            BenchHolder { process: 7, since: 9, user: "eve".into(), command: "x\u{1b}[2J".repeat(99) };
        let read = BenchHolder::of(&holder.piece()).unwrap();
        assert_eq!((read.process, read.since, read.user.as_str()), (7, 9, "eve"));
        assert!(read.command.starts_with("x[2Jx") && read.command.len() < 256);
        assert_eq!(BenchHolder::of(b"7\t9\te\x1bve\tr\xffm\0").unwrap().user, "e?ve");
        for broken in [&b""[..], b"x\t9\teve\tr", b"7\t9\teve", &[255; 256], b"-1\t9\teve\tr"] {
            assert_eq!(BenchHolder::of(broken), None, "{broken:?}");
        }
        assert_eq!(user("root:x:0:0:r:/root:/bin/sh\neve:x:7:7::/:", 7).as_deref(), Some("eve"));
        assert_eq!(user("nonsense", 7), None);
    }
}
