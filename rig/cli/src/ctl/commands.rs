//! Commands to the controller and the rig: `rig ctl run`, `stop` and their neighbours, `lock`, `unlock`, `abort`,
//! `advance`.

use super::CtlError;
use super::show::seconds;
use crate::exit::Exit;
use crate::{operator, output};
use clap::{Args, Subcommand};
use control::{Action, Advanced, Client, Done, Operation};
use signal::Span;
use std::io::{BufRead, Write};
use std::time::Duration;

/// Time is advanced in steps, so that a rig that does not answer is noticed.
const STEP: Span = Span::from_secs(60);

/// How long a step of time may take on the host: a program may compute a lot in it.
const PATIENCE: Duration = Duration::from_secs(300);

/// Commands to the controller.
#[derive(Debug, Subcommand)]
pub enum ControllerCommand {
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

impl ControllerCommand {
    const fn action(&self) -> (Action, &ActArgs) {
        match self {
            ControllerCommand::Run(args) => (Action::Run, args),
            ControllerCommand::Stop(args) => (Action::Stop, args),
            ControllerCommand::ResetWarm(args) => (Action::ResetWarm, args),
            ControllerCommand::ResetCold(args) => (Action::ResetCold, args),
            ControllerCommand::ResetOrigin(args) => (Action::ResetOrigin, args),
            ControllerCommand::Reboot(args) => (Action::Reboot, args),
            ControllerCommand::SwitchRun(args) => (Action::SwitchRun, args),
            ControllerCommand::SwitchStop(args) => (Action::SwitchStop, args),
            ControllerCommand::PowerOn(args) => (Action::PowerOn, args),
            ControllerCommand::PowerOff(args) => (Action::PowerOff, args),
        }
    }
}

/// Gives a command.
pub fn act(client: &mut Client, command: &ControllerCommand) -> Result<Exit, CtlError> {
    let (action, args) = command.action();
    confirm(client, args.yes, action.name())?;
    client.ask::<Done>(Operation::Command { action })?;
    Ok(Exit::Passed)
}

/// Asks the operator at a terminal to confirm what moves outputs. A script is not asked.
///
/// # Errors
/// It is not confirmed.
pub fn confirm(client: &Client, yes: bool, what: &str) -> Result<(), CtlError> {
    if yes || !operator::is_present() {
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
    Err(CtlError::Exit(Exit::Interrupted))
}

/// `rig ctl lock`.
#[derive(Debug, Args)]
pub struct LockArgs {
    /// A note on why; it is shown to whoever is refused.
    #[arg(long, value_name = "TEXT", default_value = "")]
    note: String,
}

/// Locks the rig.
pub fn lock(client: &mut Client, args: &LockArgs) -> Result<Exit, CtlError> {
    client.ask::<Done>(Operation::Lock { note: args.note.clone() })?;
    Ok(Exit::Passed)
}

/// Ends the lock.
pub fn unlock(client: &mut Client) -> Result<Exit, CtlError> {
    client.ask::<Done>(Operation::Unlock)?;
    Ok(Exit::Passed)
}

/// Ends the plan that runs.
pub fn abort(client: &mut Client) -> Result<Exit, CtlError> {
    client.ask::<Done>(Operation::Abort)?;
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
pub fn advance(client: &mut Client, args: &AdvanceArgs) -> Result<Exit, CtlError> {
    let at = advance_by(client, args.by, STEP, |_| Ok(true))?;
    output::print(&format!("{}\n", seconds(at)));
    Ok(Exit::Passed)
}

/// Advances time step by step; after each one `goes_on` is asked. Returns the instant that was reached.
pub fn advance_by(
    client: &mut Client,
    by: Span,
    step: Span,
    mut goes_on: impl FnMut(&mut Client) -> Result<bool, CtlError>,
) -> Result<i64, CtlError> {
    let mut left = by;
    loop {
        let next = left.min(step);
        left = left - next;
        let reached: Advanced = client.ask_within(Operation::Advance { by: next.as_nanos() }, PATIENCE)?;
        if !goes_on(client)? || left <= Span::ZERO {
            return Ok(reached.at);
        }
    }
}
