//! Commands to the controller and the rig: `rig ctl run`, `stop` and their neighbours, `lock`, `unlock`, `abort`,
//! `advance`.

use super::CtlError;
use super::show::seconds;
use crate::exit::ExitStatus;
use crate::{operator, output};
use clap::{Args, Subcommand};
use control::{Advanced, ControlClient, ControllerAction, Done, RequestOperation};
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
    const fn action(&self) -> (ControllerAction, &ActArgs) {
        match self {
            ControllerCommand::Run(args) => (ControllerAction::Run, args),
            ControllerCommand::Stop(args) => (ControllerAction::Stop, args),
            ControllerCommand::ResetWarm(args) => (ControllerAction::ResetWarm, args),
            ControllerCommand::ResetCold(args) => (ControllerAction::ResetCold, args),
            ControllerCommand::ResetOrigin(args) => (ControllerAction::ResetOrigin, args),
            ControllerCommand::Reboot(args) => (ControllerAction::Reboot, args),
            ControllerCommand::SwitchRun(args) => (ControllerAction::SwitchRun, args),
            ControllerCommand::SwitchStop(args) => (ControllerAction::SwitchStop, args),
            ControllerCommand::PowerOn(args) => (ControllerAction::PowerOn, args),
            ControllerCommand::PowerOff(args) => (ControllerAction::PowerOff, args),
        }
    }
}

/// Gives a command.
pub fn act(client: &mut ControlClient, command: &ControllerCommand) -> Result<ExitStatus, CtlError> {
    let (action, args) = command.action();
    confirm(client, args.yes, action.name())?;
    client.ask::<Done>(RequestOperation::Command { action })?;
    Ok(ExitStatus::Passed)
}

/// Asks the operator at a terminal to confirm what moves outputs. A script is not asked.
///
/// # Errors
/// It is not confirmed.
pub fn confirm(client: &ControlClient, yes: bool, what: &str) -> Result<(), CtlError> {
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
    Err(CtlError::Exit(ExitStatus::Interrupted))
}

/// `rig ctl lock`.
#[derive(Debug, Args)]
pub struct LockArgs {
    /// A note on why; it is shown to whoever is refused.
    #[arg(long, value_name = "TEXT", default_value = "")]
    note: String,
}

/// Locks the rig.
pub fn lock(client: &mut ControlClient, args: &LockArgs) -> Result<ExitStatus, CtlError> {
    client.ask::<Done>(RequestOperation::Lock { note: args.note.clone() })?;
    Ok(ExitStatus::Passed)
}

/// Ends the lock.
pub fn unlock(client: &mut ControlClient) -> Result<ExitStatus, CtlError> {
    client.ask::<Done>(RequestOperation::Unlock)?;
    Ok(ExitStatus::Passed)
}

/// Ends the plan that runs.
pub fn abort(client: &mut ControlClient) -> Result<ExitStatus, CtlError> {
    client.ask::<Done>(RequestOperation::Abort)?;
    Ok(ExitStatus::Passed)
}

/// `rig ctl advance`.
#[derive(Debug, Args)]
pub struct AdvanceArgs {
    /// How much time.
    #[arg(value_name = "TIME", value_parser = crate::duration::above_zero)]
    by: Span,
}

/// Lets time pass, and prints the instant that was reached.
pub fn advance(client: &mut ControlClient, args: &AdvanceArgs) -> Result<ExitStatus, CtlError> {
    let at = advance_by(client, args.by, STEP, |_| Ok(true))?;
    output::print(&format!("{}\n", seconds(at)));
    Ok(ExitStatus::Passed)
}

/// Advances time step by step; after each one `goes_on` is asked. Returns the instant that was reached.
pub fn advance_by(
    client: &mut ControlClient,
    by: Span,
    step: Span,
    mut goes_on: impl FnMut(&mut ControlClient) -> Result<bool, CtlError>,
) -> Result<i64, CtlError> {
    let mut left = by;
    loop {
        let next = left.min(step);
        left = left - next;
        let reached: Advanced =
            client.ask_within(RequestOperation::Advance { by: next.as_nanos() }, PATIENCE)?;
        if !goes_on(client)? || left <= Span::ZERO {
            return Ok(reached.at);
        }
    }
}
