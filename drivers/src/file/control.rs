//! What a board file says of the control socket: `[control]`.

use std::ops::Range;
use std::path::PathBuf;

use document::{Fields, Findings};
use host::LONGEST_SOCKET_PATH;

use super::codes;

/// What happens when the connection to a client is lost that had forced something.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OnDisconnect {
    /// Its forces stay.
    #[default]
    Keep,
    /// They end.
    Release,
    /// They end, and the application is stopped.
    Stop,
}

/// How the control socket of a rig that is kept running is served.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ControlSettings {
    /// The socket; the usual one if none is named.
    pub socket: Option<PathBuf>,
    /// The group whose members may use it.
    pub group: Option<String>,
    /// Where the group is named, bytes of the file.
    pub group_at: Range<usize>,
    /// What happens when a client is lost.
    pub on_disconnect: OnDisconnect,
    /// How many clients there may be at once; the usual number if left out.
    pub clients: Option<u16>,
}

/// Reads the table.
pub(super) fn read(fields: Option<Fields>, out: &mut Findings) -> ControlSettings {
    let Some(fields) = fields else { return ControlSettings::default() };
    let socket = fields.text("socket");
    if let Some((path, node)) = socket.zip(fields.get("socket")) {
        let help = "write as in \"/run/scanrig/rig.sock\"";
        if !path.starts_with('/') {
            out.bad(codes::DOCUMENT.unreadable, node, format!("\"{path}\" is no whole path"), help);
        } else if path.len() > LONGEST_SOCKET_PATH {
            let (bytes, most) = (path.len(), LONGEST_SOCKET_PATH);
            let message = format!("a path of {bytes} bytes is longer than the {most} of a socket");
            out.bad(codes::DOCUMENT.unreadable, node, message, help);
        }
    }
    ControlSettings {
        socket: socket.map(PathBuf::from),
        group: fields.text("group").map(str::to_owned),
        group_at: fields.get("group").map_or(0..0, |node| node.span.clone()),
        on_disconnect: match fields.text("on-disconnect") {
            Some("release") => OnDisconnect::Release,
            Some("stop") => OnDisconnect::Stop,
            _ => OnDisconnect::Keep,
        },
        clients: fields.integer("clients").and_then(|clients| u16::try_from(clients).ok()),
    }
}
