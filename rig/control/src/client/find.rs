//! Rigs that run on this machine.

use super::{ClientError, ControlClient};
use crate::place;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// How long a rig may take to greet while it is only looked for.
const GLANCE: Duration = Duration::from_secs(2);

/// The rigs that run, in the order of the folders and of their names; nothing is said to them yet. A rig that takes
/// nobody more is none of them.
pub fn running() -> Vec<ControlClient> {
    answering(&place::folders())
}

/// The only rig that runs.
///
/// # Errors
/// None, or several.
pub fn only() -> Result<ControlClient, ClientError> {
    let folders = place::folders();
    let mut rigs = answering(&folders);
    match (rigs.pop(), rigs.is_empty()) {
        (None, _) => Err(ClientError::NoRig(folders)),
        (Some(rig), true) => Ok(rig),
        (Some(last), false) => {
            rigs.push(last);
            Err(ClientError::SeveralRigs(rigs.iter().map(|rig| rig.socket().to_owned()).collect()))
        }
    }
}

/// The socket of a rig by the name of its board: the first that is there, else where it would be.
pub fn by_name(board: &Path) -> PathBuf {
    let folders = place::folders();
    let found = folders.iter().map(|folder| place::socket_in(folder, board)).find(|socket| socket.exists());
    found.unwrap_or_else(|| place::default_socket(board))
}

fn answering(folders: &[PathBuf]) -> Vec<ControlClient> {
    let mut found = Vec::new();
    for folder in folders {
        let Ok(entries) = std::fs::read_dir(folder) else { continue };
        let mut sockets: Vec<PathBuf> = entries
            .filter_map(|entry| Some(entry.ok()?.path()))
            .filter(|path| place::is_socket_name(path))
            .collect();
        sockets.sort();
        found.extend(sockets.iter().filter_map(|socket| ControlClient::meet(socket, GLANCE).ok()));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Greeting;
    use std::os::unix::net::UnixListener;

    #[test]
    fn only_sockets_that_greet_are_rigs() {
        let folder = std::env::temp_dir().join(format!("scanrig-find-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let live = UnixListener::bind(folder.join("live.sock")).unwrap();
        drop(UnixListener::bind(folder.join("dead.sock")).unwrap());
        std::fs::write(folder.join("file.sock"), "").unwrap();
        std::fs::write(folder.join("note.txt"), "").unwrap();
        let greeter = std::thread::spawn(move || {
            use std::io::Write;
            let (mut stream, _) = live.accept().unwrap();
            let greeting = Greeting {
                rig: "scanrig".to_owned(),
                protocol: crate::PROTOCOL,
                version: "1".to_owned(),
                board: "live.toml".to_owned(),
                reference: "TM241CEC24T".to_owned(),
                client: 1,
            };
            serde_json::to_writer(&mut stream, &greeting).unwrap();
            stream.write_all(b"\n").unwrap();
        });
        let found = answering(&[folder.join("nowhere"), folder.clone()]);
        greeter.join().unwrap();
        std::fs::remove_dir_all(&folder).unwrap();
        assert_eq!(found.len(), 1);
        assert_eq!(
            (found[0].socket(), &*found[0].greeting().board),
            (&*folder.join("live.sock"), "live.toml")
        );
    }
}
