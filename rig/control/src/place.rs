//! Where the socket of a rig is, unless somebody says otherwise.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// The folder within the folder of a user's or the machine's running programs.
const FOLDER: &str = "scanrig";
/// Where the machine's running programs have their files.
const MACHINE: &str = "/run";
/// What the name of a socket ends in.
const EXTENSION: &str = "sock";

/// The folders in which sockets of rigs are, the user's own first. A rig without a name for its socket makes it in the
/// first; a client looks into all.
pub fn folders() -> Vec<PathBuf> {
    folders_from(std::env::var_os("XDG_RUNTIME_DIR"))
}

/// The socket of a rig of a board file that names none.
pub fn default_socket(board: &Path) -> PathBuf {
    socket_in(&folders()[0], board)
}

/// The socket of a board file's rig in a folder.
pub fn socket_in(folder: &Path, board: &Path) -> PathBuf {
    let mut name = board.file_stem().unwrap_or("rig".as_ref()).to_os_string();
    name.push(".");
    name.push(EXTENSION);
    folder.join(name)
}

/// Whether a file of one of the folders is called as a socket is.
pub fn is_socket_name(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == EXTENSION)
}

/// A variable that is empty or no whole path counts as not set, as its specification asks.
fn folders_from(user: Option<OsString>) -> Vec<PathBuf> {
    let user = user.map(PathBuf::from).filter(|path| path.is_absolute());
    user.into_iter().chain([PathBuf::from(MACHINE)]).map(|path| path.join(FOLDER)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_users_folder_comes_first_if_there_is_one() {
        assert_eq!(
            folders_from(Some("/run/user/7".into())),
            [Path::new("/run/user/7/scanrig"), Path::new("/run/scanrig")]
        );
        for none in [None, Some("".into()), Some("not/whole".into())] {
            assert_eq!(folders_from(none), [Path::new("/run/scanrig")]);
        }
    }

    #[test]
    fn the_board_names_the_socket() {
        let folder = Path::new("/run/scanrig");
        assert_eq!(socket_in(folder, Path::new("boards/bench-2.toml")), folder.join("bench-2.sock"));
        assert_eq!(socket_in(folder, Path::new("sim")), folder.join("sim.sock"));
        assert!(is_socket_name(&socket_in(folder, Path::new(""))));
    }
}
