//! What can go wrong between a client and its rig.

use crate::{PROTOCOL, RequestFault};
use std::fmt;
use std::io::ErrorKind;
use std::path::PathBuf;
use std::time::Duration;

/// Why a client has no answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ClientError {
    /// The rig refused the request, or the connection, with its own code.
    Refused(RequestFault),
    /// There is no rig; these folders were searched.
    NoRig(Vec<PathBuf>),
    /// Nobody said which of these rigs is meant.
    SeveralRigs(Vec<PathBuf>),
    /// The socket cannot be connected to.
    Unreachable(PathBuf, ErrorKind),
    /// Who answers there is no rig.
    NotARig(PathBuf),
    /// The rig speaks this version of the protocol.
    OtherProtocol(PathBuf, u32),
    /// The connection broke.
    Lost(PathBuf),
    /// The rig ended it, and said why.
    Ended(String),
    /// Nothing came for so long.
    Silent(PathBuf, Duration),
    /// A line that means nothing: what the reader says of it.
    Garbled(String),
}

impl ClientError {
    /// The error as a rig would report it: code, message and help.
    pub fn fault(&self) -> RequestFault {
        let fault = |code: &str, message: String, help: &str| RequestFault {
            code: code.to_owned(),
            message,
            help: help.to_owned(),
        };
        match self {
            ClientError::Refused(fault) => fault.clone(),
            ClientError::NoRig(folders) => fault(
                "R0640",
                format!("no rig runs: there is no socket that answers in {}", list(folders)),
                "start one with `rig run --board FILE --program FILE`, or name its socket with `--socket PATH`",
            ),
            ClientError::SeveralRigs(sockets) => fault(
                "R0641",
                format!("several rigs run: {}", list(sockets)),
                "name one with `--socket PATH`, or its board with `--board NAME`",
            ),
            ClientError::Unreachable(socket, kind) => {
                let help = match kind {
                    ErrorKind::NotFound => {
                        "start the rig with `rig run`, or name the socket of one that runs: `rig ctl rigs` lists them"
                    }
                    ErrorKind::ConnectionRefused => {
                        "its rig is gone without removing it: start the rig again, which takes the socket over"
                    }
                    ErrorKind::PermissionDenied => {
                        "join the group that the socket belongs to (`ls -l` shows it), and log in again"
                    }
                    _ => "see whether the rig runs, and whether this is its socket",
                };
                let why = match kind {
                    ErrorKind::NotFound => String::from("there is no such socket"),
                    kind => kind.to_string(),
                };
                fault("R0642", format!("`{}` cannot be connected to: {why}", socket.display()), help)
            }
            ClientError::NotARig(socket) => fault(
                "R0643",
                format!("who answers at `{}` is no rig", socket.display()),
                "name the socket of a rig",
            ),
            ClientError::OtherProtocol(socket, version) => fault(
                "R0644",
                format!(
                    "the rig at `{}` speaks version {version} of the protocol, and this program version {PROTOCOL}",
                    socket.display()
                ),
                "use the `rig` of the release that the rig was started with",
            ),
            ClientError::Lost(socket) => fault(
                "R0645",
                format!("the connection to the rig at `{}` is lost", socket.display()),
                "see in the log of `rig run` why it ended",
            ),
            ClientError::Ended(why) => fault(
                "R0646",
                format!("the rig ended the connection: {why}"),
                "see what the rig's log says of it",
            ),
            ClientError::Silent(socket, patience) => fault(
                "R0647",
                format!("the rig at `{}` gave no answer within {patience:?}", socket.display()),
                "see whether it stands still, as one does that was stopped by a debugger",
            ),
            ClientError::Garbled(what) => fault(
                "R0648",
                format!("an answer of the rig cannot be understood: {what}"),
                "use the `rig` of the release that the rig was started with",
            ),
        }
    }
}

fn list(paths: &[PathBuf]) -> String {
    paths.iter().map(|path| format!("`{}`", path.display())).collect::<Vec<_>>().join(", ")
}

impl fmt::Display for ClientError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let fault = self.fault();
        write!(f, "{} ({})", fault.message, fault.code)
    }
}

impl std::error::Error for ClientError {}
