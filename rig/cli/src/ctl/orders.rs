//! Commands to the controller and the rig: `rig ctl run`, `stop` and their neighbours, `lock`, `unlock`, `abort`,
//! `advance`.

use super::Stop;
use super::show::seconds;
use crate::exit::Exit;
use crate::{operator, output};
use clap::{Args, Subcommand};
use control::{Action, Advanced, Ask, Client, Done};
use signal::Span;
use std::io::{BufRead, Write};
use std::time::Duration;

/// Time is led in pieces, so that a rig that stands still is noticed.
const PIECE: Span = Span::from_secs(60);

/// How long a piece of led time may take: a program may compute a lot in it.
const PATIENCE: Duration = Duration::from_secs(300);

/// Commands to the controller.
#[derive(Debug, Subcommand)]
pub enum ActCommand {
    /// Start the application.
    Run(ActArgs),
    /// Stop the application.
    Stop(ActArgs),
    /// Reset warm: retained values stay.
    ResetWarm(ActArgs),
    /// Reset cold.
    ResetCold(ActArgs),
    /// Reset to the origin: the application is removed.
    ResetOrigin(ActArgs),
    /// Reboot.
    Reboot(ActArgs),
    /// Move the Run/Stop switch to Run.
    SwitchRun(ActArgs),
    /// Move the Run/Stop switch to Stop.
    SwitchStop(ActArgs),
    /// Switch the supply on.
    PowerOn(ActArgs),
    /// Switch the supply off.
    PowerOff(ActArgs),
}

/// What goes with a command.
#[derive(Debug, Args)]
pub struct ActArgs {
    /// Do not ask on a terminal whether it is meant.
    #[arg(long, short)]
    yes: bool,
}

impl ActCommand {
    const fn action(&self) -> (Action, &ActArgs) {
        match self {
            ActCommand::Run(args) => (Action::Run, args),
            ActCommand::Stop(args) => (Action::Stop, args),
            ActCommand::ResetWarm(args) => (Action::ResetWarm, args),
            ActCommand::ResetCold(args) => (Action::ResetCold, args),
            ActCommand::ResetOrigin(args) => (Action::ResetOrigin, args),
            ActCommand::Reboot(args) => (Action::Reboot, args),
            ActCommand::SwitchRun(args) => (Action::SwitchRun, args),
            ActCommand::SwitchStop(args) => (Action::SwitchStop, args),
            ActCommand::PowerOn(args) => (Action::PowerOn, args),
            ActCommand::PowerOff(args) => (Action::PowerOff, args),
        }
    }
}

/// Gives a command.
pub fn act(client: &mut Client, command: &ActCommand) -> Result<Exit, Stop> {
    let (action, args) = command.action();
    confirm(client, args.yes, action.name())?;
    client.ask::<Done>(Ask::Command { action })?;
    Ok(Exit::Passed)
}

/// Asks whoever sits at a terminal whether something is meant that moves outputs. A script is not asked.
///
/// # Errors
/// It is not meant.
pub fn confirm(client: &Client, yes: bool, what: &str) -> Result<(), Stop> {
    if yes || !operator::is_here() {
        return Ok(());
    }
    let board = &client.greeting().board;
    let _ = write!(std::io::stderr(), "{what} on {board}: outputs may move. Go on, yes or no?\n> ");
    let mut line = String::new();
    // Who cannot be read from has not said yes.
    let _ = std::io::stdin().lock().read_line(&mut line);
    if matches!(line.trim().to_lowercase().as_str(), "y" | "yes") {
        return Ok(());
    }
    output::note("nothing was done");
    Err(Stop::Exit(Exit::Interrupted))
}

/// `rig ctl lock`.
#[derive(Debug, Args)]
pub struct LockArgs {
    /// A word on why; told to whoever is refused.
    #[arg(long, value_name = "TEXT", default_value = "")]
    note: String,
}

/// Locks the rig.
pub fn lock(client: &mut Client, args: &LockArgs) -> Result<Exit, Stop> {
    client.ask::<Done>(Ask::Lock { note: args.note.clone() })?;
    Ok(Exit::Passed)
}

/// Ends the lock.
pub fn unlock(client: &mut Client) -> Result<Exit, Stop> {
    client.ask::<Done>(Ask::Unlock)?;
    Ok(Exit::Passed)
}

/// Ends the plan that runs.
pub fn abort(client: &mut Client) -> Result<Exit, Stop> {
    client.ask::<Done>(Ask::Abort)?;
    Ok(Exit::Passed)
}

/// `rig ctl advance`.
#[derive(Debug, Args)]
pub struct AdvanceArgs {
    /// How much time.
    #[arg(value_name = "TIME", value_parser = crate::duration::above_zero)]
    by: Span,
}

/// Lets time pass, and prints the instant that was reached.
pub fn advance(client: &mut Client, args: &AdvanceArgs) -> Result<Exit, Stop> {
    let at = lead(client, args.by, PIECE, |_| Ok(true))?;
    output::print(&format!("{}\n", seconds(at)));
    Ok(Exit::Passed)
}

/// Lets time pass piece by piece; behind each one it is asked whether to go on. Tells the instant that was reached.
pub fn lead(
    client: &mut Client,
    by: Span,
    piece: Span,
    mut goes_on: impl FnMut(&mut Client) -> Result<bool, Stop>,
) -> Result<i64, Stop> {
    let mut left = by;
    loop {
        let next = left.min(piece);
        left = left - next;
        let reached: Advanced = client.ask_within(Ask::Advance { by: next.as_nanos() }, PATIENCE)?;
        if !goes_on(client)? || left <= Span::ZERO {
            return Ok(reached.at);
        }
    }
}
