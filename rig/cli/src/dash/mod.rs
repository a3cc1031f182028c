//! `rig dash`: the dashboard on this terminal.

mod dbc_decoder;
mod demonstration;
mod trend_files;

use crate::ctl;
use crate::exit::ExitStatus;
use crate::output;
use crate::rig_address::RigAddress;
use clap::Args;
use dash::glyphs::TerminalFeatures;
use demonstration::Demonstration;
use document::Diagnostic;
use std::io::IsTerminal;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use trend_files::HostTrendFiles;

/// Set by the signals that end programs: the terminal is given back, and the rig does what its board file says.
static END: AtomicBool = AtomicBool::new(false);

/// The name of the board that a rig is started on for the dashboard.
const DEMONSTRATION: &str = "sim";

/// `rig dash`.
#[derive(Debug, Args)]
#[command(
    after_help = "`rig dash --board sim` starts a rig with a conveyor on a simulated board, and ends it when you \
leave."
)]
pub struct DashArgs {
    /// Which rig.
    #[command(flatten)]
    address: RigAddress,
    /// Draw with the characters of ASCII alone. Without this it is so where LANG, LC_ALL or TERM say that the terminal has
    /// no others.
    #[arg(long)]
    ascii: bool,
    /// Leave the mouse to the terminal.
    #[arg(long)]
    no_mouse: bool,
}

/// Shows the dashboard until somebody leaves.
pub fn run(args: &DashArgs) -> ExitStatus {
    if !std::io::stdin().is_terminal() || !std::io::stdout().is_terminal() {
        let found = Diagnostic::error("R0660", "the dashboard needs a terminal for its keys and its screen");
        output::findings(&[found.help("start it without pipes; scripts use `rig ctl`")], &[]);
        return ExitStatus::UserFiles;
    }
    if let Err(error) = ctrlc::set_handler(|| END.store(true, Ordering::Relaxed)) {
        output::error(&format!("interrupts cannot be caught: {error}"));
        return ExitStatus::Error;
    }
    let wanted = args.address.board.as_ref().is_some_and(|board| board.as_os_str() == DEMONSTRATION);
    if !wanted {
        return attach(args);
    }
    match Demonstration::start(&END) {
        Ok(own) => show(args, own.socket().to_owned(), true),
        Err(found) => {
            output::findings(&[found], &[]);
            ExitStatus::Error
        }
    }
}

/// A rig that runs. One that is not there is reported before the screen is taken.
fn attach(args: &DashArgs) -> ExitStatus {
    match args.address.connect("rig dash") {
        Ok(client) => show(args, client.socket().to_owned(), false),
        Err(error) => {
            output::fault(&error.fault());
            ctl::exit_of(&error)
        }
    }
}

fn show(args: &DashArgs, socket: PathBuf, owns_rig: bool) -> ExitStatus {
    let mut features = TerminalFeatures::of_environment(|name| std::env::var(name).ok());
    features.utf8 &= !args.ascii;
    features.color = output::color_on_screen(features.color);
    let settings = dash::DashboardSettings {
        socket,
        files: Box::new(HostTrendFiles),
        features,
        mouse: !args.no_mouse,
        owns_rig,
        stop: &END,
        suspend: host::stop_here,
    };
    let shown = dash::run(settings);
    match shown {
        _ if END.load(Ordering::Relaxed) => ExitStatus::Interrupted,
        Ok(()) => ExitStatus::Passed,
        Err(error) => {
            output::error(&format!("the terminal is lost: {error}"));
            ExitStatus::Error
        }
    }
}
