//! How the control socket of `rig run` is made, and which plans its clients can run.

use crate::output;
use crate::plan_files::find;
use crate::plan_files::library::{self, ShippedFiles};
use clap::Args;
use control::place;
use document::Diagnostic;
use drivers::{BoardFile, OnDisconnect};
use runtime::live::{LiveRig, PlanSource};
use runtime::suite::{Disk, FileSource};
use services::control::{ClientLimits, Serving, SocketSettings};
use std::path::{Path, PathBuf};

/// Where a service manager says that what lasts is kept.
const STATE: &str = "STATE_DIRECTORY";

/// What the command line says of the socket.
#[derive(Debug, Args)]
pub struct ControlArgs {
    /// The control socket for `rig ctl` and `rig dash` [default: that of the board file, or the usual place].
    #[arg(long, value_name = "PATH")]
    control: Option<PathBuf>,
    /// A folder in which the lock outlasts the rig [default: $STATE_DIRECTORY].
    #[arg(long, value_name = "FOLDER")]
    state: Option<PathBuf>,
    /// Run in stepped time: it stands still until a client of the control socket advances it. For tests, on simulated boards.
    #[arg(long)]
    pub stepped: bool,
    /// The old name of `--stepped`.
    #[arg(long, hide = true)]
    led: bool,
}

impl ControlArgs {
    /// Whether time is stepped by clients.
    ///
    /// # Errors
    /// R0225: the old option.
    pub fn is_stepped(&self) -> Result<bool, Diagnostic> {
        if self.led {
            let found = Diagnostic::error("R0225", "`--led` is the old name of an option");
            return Err(found.help("write `--stepped`"));
        }
        Ok(self.stepped)
    }
}

/// Serves clients where that is wanted. A socket that was not asked for and cannot be created is reported, and the rig
/// runs without it.
///
/// # Errors
/// One that was asked for cannot be created.
pub fn serve(args: &ControlArgs, board: &BoardFile, rig: LiveRig) -> Result<Option<Serving>, Diagnostic> {
    let named = args.control.clone().or_else(|| board.control.socket.clone());
    let wanted = named.is_some() || board.control.group.is_some() || args.stepped;
    let socket = named.unwrap_or_else(|| place::default_socket(Path::new(&board.name)));
    match services::control::serve(rig, settings(args, board, socket), output::info) {
        Ok(serving) => {
            output::info(&format!("control socket {}", serving.path().display()));
            Ok(Some(serving))
        }
        Err(fault) if wanted => {
            let found = Diagnostic::error(known(&fault.code), fault.message);
            Err(if fault.help.is_empty() { found } else { found.help(fault.help) })
        }
        Err(fault) => {
            output::info(&format!("no control socket: {}", fault.message));
            Ok(None)
        }
    }
}

fn settings(args: &ControlArgs, board: &BoardFile, socket: PathBuf) -> SocketSettings {
    let said = &board.control;
    let usual = SocketSettings::of(socket);
    // A service may have several folders; the first is its own.
    let kept =
        || std::env::split_paths(&std::env::var_os(STATE)?).next().filter(|folder| folder.is_absolute());
    SocketSettings {
        group: said.group.clone(),
        on_disconnect: match said.on_disconnect {
            OnDisconnect::Keep => services::control::OnDisconnect::Keep,
            OnDisconnect::Release => services::control::OnDisconnect::Release,
            OnDisconnect::Stop => services::control::OnDisconnect::Stop,
        },
        state: args.state.clone().or_else(kept),
        limits: ClientLimits {
            clients: said.clients.map_or(usual.limits.clients, usize::from),
            ..usual.limits
        },
        ..usual
    }
}

/// The code as the registers have it.
fn known(code: &str) -> &'static str {
    services::CODES.iter().map(|(known, _)| *known).find(|known| *known == code).unwrap_or("R0631")
}

/// The plans of this machine, and those that ship.
#[derive(Clone, Copy, Debug)]
pub struct HostPlans;

impl PlanSource for HostPlans {
    fn plans(&self, path: Option<&str>, is_wanted: &dyn Fn() -> bool) -> Result<Vec<String>, String> {
        let Some(path) = path else { return Ok(library::plans()) };
        let found = std::fs::metadata(path);
        // A pipe would keep every client waiting.
        if found.as_ref().is_ok_and(|found| !found.is_file() && !found.is_dir()) {
            return Err(format!("`{path}` is neither a file nor a folder"));
        }
        if found.is_err() {
            let (file, folder) = (format!("{path}.toml"), format!("{path}/"));
            let within = |plan: &String| *plan == path || *plan == file || plan.starts_with(&folder);
            let shipped: Vec<String> = library::plans().into_iter().filter(within).collect();
            let none = || format!("`{path}` is not there");
            return if shipped.is_empty() { Err(none()) } else { Ok(shipped) };
        }
        let found = find::at(Path::new(path), is_wanted).map_err(|unread| unread.to_string())?;
        if found.is_empty() { Err(format!("`{path}` holds no plan")) } else { Ok(found) }
    }

    fn files(&self, plan: &str) -> &'static dyn FileSource {
        if Disk.has(plan) { &Disk } else { &ShippedFiles }
    }
}
