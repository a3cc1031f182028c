//! `rig ctl raw`: the protocol as it is.

use super::show::print_text;
use super::{CtlError, exit_of};
use crate::exit::ExitStatus;
use crate::output;
use crate::rig_address::RigAddress;
use clap::Args;
use control::client::PATIENCE;
use control::{ClientError, Connection};
use serde_json::Value as Json;
use std::io::{BufRead, BufReader, ErrorKind, Write};
use std::net::Shutdown;
use std::os::unix::net::UnixStream;
use std::path::Path;

/// `rig ctl raw`.
#[derive(Debug, Args)]
pub struct RawArgs {
    /// Go on with what comes when standard input is at its end.
    #[arg(long, short)]
    follow: bool,
}

/// Sends lines and prints lines. The rig answers all that it was asked and closes when nothing more comes.
pub fn run(address: &RigAddress, args: &RawArgs) -> Result<ExitStatus, CtlError> {
    let rig = address.open()?;
    let socket = rig.socket().to_owned();
    let unreachable = |error: std::io::Error| ClientError::Unreachable(socket.clone(), error.kind());
    // Its greeting was taken to see that it is a rig, so this connection starts again.
    drop(rig);
    let Connection::Open(stream) = control::connect(&socket, PATIENCE).map_err(unreachable)? else {
        return Err(ClientError::Silent(socket, PATIENCE).into());
    };
    let sends = stream.try_clone().map_err(unreachable)?;
    let follow = args.follow;
    // Not joined: it may wait for a line of somebody who types none any more.
    std::thread::spawn(move || send(sends, follow));
    receive(stream, &socket)
}

/// Sends standard input line by line.
fn send(mut stream: UnixStream, follow: bool) {
    for line in std::io::stdin().lock().split(b'\n') {
        let Ok(mut line) = line else { break };
        line.push(b'\n');
        // A rig that is gone is reported by the other side.
        if stream.write_all(&line).is_err() {
            return;
        }
    }
    if !follow {
        // A connection that is closed already has nothing to end.
        let _ = stream.shutdown(Shutdown::Write);
    }
}

/// Prints what the rig says until it closes.
fn receive(stream: UnixStream, socket: &Path) -> Result<ExitStatus, CtlError> {
    let mut refused = false;
    for line in BufReader::new(stream).split(b'\n') {
        let line = match line {
            Ok(line) => line,
            // It was cut off while it still had something to send.
            Err(error) if error.kind() == ErrorKind::ConnectionReset => break,
            Err(_) => {
                let lost = ClientError::Lost(socket.to_owned());
                output::fault(&lost.fault());
                return Ok(exit_of(&lost));
            }
        };
        let text = String::from_utf8_lossy(&line);
        refused |= serde_json::from_str::<Json>(&text).is_ok_and(|line| line.get("error").is_some());
        if !print_text(&format!("{text}\n")) {
            break;
        }
    }
    Ok(if refused { ExitStatus::UserFiles } else { ExitStatus::Passed })
}
