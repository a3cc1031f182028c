//! Where the user's files come from, and the folders that they are in.

use crate::codes;
use document::{Diagnostic, SourceFile};
use std::io::ErrorKind;
use std::os::unix::fs::MetadataExt;
use std::path::Path;

/// Where plans, programs and board files come from: a disk, or what is built into the binary.
pub trait FileSource: Sync {
    /// The text of a file.
    ///
    /// # Errors
    /// Why it cannot be read.
    fn read(&self, path: &str) -> Result<String, String>;

    /// The bytes of a file, which need not be UTF-8.
    ///
    /// # Errors
    /// Why it cannot be read.
    fn bytes(&self, path: &str) -> Result<Vec<u8>, String> {
        self.read(path).map(String::into_bytes)
    }

    /// Whether there is something of this name.
    fn has(&self, path: &str) -> bool {
        self.read(path).is_ok()
    }

    /// The names in a folder, sorted, as far as they are known.
    fn names(&self, _folder: &str) -> Vec<String> {
        Vec::new()
    }

    /// Whether a file beside a plan belongs to somebody else than the plan and the user, in a folder that all users share.
    fn is_foreign(&self, _path: &str, _plan: &str) -> bool {
        false
    }

    /// The folders that a file is in and whose suites it is of, the innermost first; empty for where paths are
    /// written from.
    fn folders(&self, path: &str) -> Vec<String> {
        written(path)
    }
}

/// Largest file that is read, in bytes.
const LARGEST_FILE: u64 = 8 << 20;
/// Most names of a folder that are looked at.
const MOST_NAMES: usize = 100_000;

/// The host's disk.
#[derive(Clone, Copy, Debug, Default)]
pub struct Disk;

impl FileSource for Disk {
    fn read(&self, path: &str) -> Result<String, String> {
        let bytes = self.bytes(path)?;
        if path.to_ascii_lowercase().ends_with(".dbc") && std::str::from_utf8(&bytes).is_err() {
            // Older tools write Latin-1, where each byte is the character of its number.
            return Ok(bytes.into_iter().map(char::from).collect());
        }
        String::from_utf8(bytes)
            .map_err(|error| format!("it is no UTF-8 text (byte {})", error.utf8_error().valid_up_to()))
    }

    fn bytes(&self, path: &str) -> Result<Vec<u8>, String> {
        let bytes = document::file::read(Path::new(path), LARGEST_FILE).map_err(|fault| fault.to_string())?;
        tracing::debug!(path, length = bytes.len(), "a file is read");
        Ok(bytes)
    }

    fn has(&self, path: &str) -> bool {
        // A link that leads nowhere, a folder or a pipe of this name is there, and is refused when it is read.
        let found = std::fs::symlink_metadata(path);
        found.map_or_else(
            |error| !matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory),
            |_| true,
        )
    }

    fn names(&self, folder: &str) -> Vec<String> {
        let entries = std::fs::read_dir(place(folder)).into_iter().flatten().flatten();
        let mut names: Vec<String> =
            entries.filter_map(|entry| entry.file_name().into_string().ok()).take(MOST_NAMES).collect();
        names.sort();
        names
    }

    fn is_foreign(&self, path: &str, plan: &str) -> bool {
        let owner = |path: &str| std::fs::symlink_metadata(path).map(|about| about.uid()).ok();
        let own = [owner(plan), Some(rustix::process::geteuid().as_raw())];
        is_shared(&folder_of(path)) && !own.contains(&owner(path))
    }

    fn folders(&self, path: &str) -> Vec<String> {
        on_disk(path)
    }
}

/// A path beside another file.
pub fn beside(file: &str, path: &str) -> String {
    match file.rfind('/') {
        Some(at) if !path.starts_with('/') => format!("{}/{path}", &file[..at]),
        _ => path.to_owned(),
    }
}

/// Reads a user's file into a source.
///
/// # Errors
/// A finding with the path and the reason.
pub fn load(files: &dyn FileSource, path: &str) -> Result<SourceFile, Diagnostic> {
    let text = files.read(path).map_err(|why| unread(files, path, &why))?;
    Ok(SourceFile::new(path, text))
}

/// Reads a file of Structured Text, in whatever encoding and wrapping it is distributed.
///
/// # Errors
/// A finding with the path and the reason.
pub fn load_program(files: &dyn FileSource, path: &str) -> Result<SourceFile, Diagnostic> {
    let bytes = files.bytes(path).map_err(|why| unread(files, path, &why))?;
    program::source(path, &bytes)
}

/// Most folders above a plan: deeper than any project.
const MOST_FOLDERS: usize = 64;

/// A file that cannot be read, with the name beside it that was meant.
fn unread(files: &dyn FileSource, path: &str, why: &str) -> Diagnostic {
    let name = path.rsplit('/').next().unwrap_or(path);
    let beside = files.names(&folder_of(path));
    let help = match document::suggest(name, beside.iter().map(String::as_str)) {
        Some(near) if near != name => format!("did you mean `{near}`?"),
        _ => String::from("give the path of a file that can be read"),
    };
    Diagnostic::error(codes::FILE_NOT_READ, format!("`{path}` cannot be read: {why}")).help(help)
}

/// The folder of a path as it is written; empty for where it is written from.
fn folder_of(path: &str) -> String {
    match path.rfind('/') {
        Some(0) => "/".to_owned(),
        Some(at) => path[..at].to_owned(),
        None => String::new(),
    }
}

/// The folder above a folder.
fn above(folder: &str) -> Option<String> {
    match folder.rsplit('/').next() {
        _ if folder == "/" => None,
        Some("" | ".") if folder.len() < 2 => Some("..".to_owned()),
        Some("..") => Some(format!("{folder}/..")),
        _ => Some(folder_of(folder)),
    }
}

/// The folders that a path is in as it is written, the innermost first; the last one is where it is written from.
fn written(path: &str) -> Vec<String> {
    let ends = |folder: &String| folder.is_empty() || folder.ends_with("..");
    let first = folder_of(path);
    std::iter::successors(Some(first), |folder| above(folder).filter(|_| !ends(folder))).collect()
}

/// The folders of a file on the disk up to that of its repository, or else up to the root or to below a folder that
/// all users share: the suites of a plan do not depend on where it is run from, nor on who else uses `/tmp`.
fn on_disk(path: &str) -> Vec<String> {
    let is_last = |folder: &String| {
        let place = place(folder);
        place.join(".git").exists() || is_root(place) || above(folder).is_some_and(|above| is_shared(&above))
    };
    let folders =
        std::iter::successors(Some(folder_of(path)), |folder| above(folder).filter(|_| !is_last(folder)));
    folders.take(MOST_FOLDERS).collect()
}

/// The path of a folder.
fn place(folder: &str) -> &Path {
    Path::new(if folder.is_empty() { "." } else { folder })
}

/// Whether a folder is one as `/tmp` is, which all users share: everybody may put files into it and take away only their own.
/// One that is open without this protection is a project's on a medium that knows no users.
fn is_shared(folder: &str) -> bool {
    const SHARED: u32 = 0o1002;
    std::fs::metadata(place(folder)).is_ok_and(|about| about.mode() & SHARED == SHARED)
}

fn is_root(folder: &Path) -> bool {
    folder.canonicalize().map_or(true, |folder| folder.parent().is_none())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt;

    #[test]
    fn a_path_is_in_the_folders_that_it_names() {
        assert_eq!(written("a/b/plan.toml"), ["a/b", "a", ""]);
        assert_eq!(written("plan.toml"), [""]);
        assert_eq!(written("/a/plan.toml"), ["/a", "/"]);
        assert_eq!(above(""), Some("..".to_owned()));
        assert_eq!(above("../a"), Some("..".to_owned()));
        assert_eq!(above(".."), Some("../..".to_owned()));
    }

    #[test]
    fn the_search_ends_at_the_repository_wherever_it_begins() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path().join("work");
        std::fs::create_dir_all(root.join("plans/inner")).unwrap();
        std::fs::create_dir_all(root.join(".git")).unwrap();
        let plan = root.join("plans/inner/lamp.toml");
        let folders = on_disk(&plan.to_string_lossy());
        let wanted: Vec<String> = ["plans/inner", "plans"]
            .iter()
            .map(|inner| root.join(inner).to_string_lossy().into_owned())
            .chain([root.to_string_lossy().into_owned()])
            .collect();
        assert_eq!(folders, wanted);
    }

    #[test]
    fn the_search_ends_below_a_folder_that_all_users_share() {
        let folder = tempfile::tempdir().unwrap();
        let shared = folder.path().join("shared");
        std::fs::create_dir_all(shared.join("project/plans")).unwrap();
        std::fs::set_permissions(&shared, std::fs::Permissions::from_mode(0o1777)).unwrap();
        let place = |inner: &str| shared.join(inner).to_string_lossy().into_owned();
        assert_eq!(on_disk(&place("project/plans/lamp.toml")), [place("project/plans"), place("project")]);
        // A plan that lies there itself has the suite beside it, if that is the user's own.
        std::fs::write(shared.join("suite.toml"), "").unwrap();
        assert!(!Disk.is_foreign(&place("suite.toml"), &place("lamp.toml")));
        // On a medium that knows no users every folder is open.
        std::fs::set_permissions(&shared, std::fs::Permissions::from_mode(0o777)).unwrap();
        assert!(on_disk(&place("project/plans/lamp.toml")).contains(&shared.to_string_lossy().into_owned()));
    }

    #[test]
    fn what_is_of_a_name_is_there_whatever_it_is() {
        let folder = tempfile::tempdir().unwrap();
        let place = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
        std::os::unix::fs::symlink("nowhere", folder.path().join("link")).unwrap();
        std::fs::create_dir(folder.path().join("folder")).unwrap();
        for name in ["link", "folder"] {
            assert!(Disk.has(&place(name)) && Disk.read(&place(name)).is_err(), "{name}");
        }
        assert!(!Disk.has(&place("none")) && !Disk.has(&place("none/none")));
        assert_eq!(Disk.names(&place("")), ["folder", "link"]);
    }
}
