//! `rig ctl`: a rig that runs, from a shell or a script.

mod await_values;
mod commands;
mod frames;
mod interrupt;
mod list;
mod log;
mod plan;
mod raw;
mod show;
mod status;
mod value;
mod values;
mod watch;

use crate::exit::ExitStatus;
use crate::output;
use crate::rig_address::RigAddress;
use clap::{Args, Subcommand};
use control::ClientError;

/// What the client is called in the rig's log.
const NAME: &str = "rig ctl";

/// `rig ctl`.
#[derive(Debug, Args)]
pub struct CtlArgs {
    /// Which rig.
    #[command(flatten)]
    pub address: RigAddress,
    /// What to do.
    #[command(subcommand)]
    pub command: CtlCommand,
}

/// What can be done.
#[derive(Debug, Subcommand)]
pub enum CtlCommand {
    /// List the rigs that run on this machine.
    Rigs,
    /// Print the state of the controller, as in RUNNING.
    State,
    /// Print the status of the rig: state, indicators, tasks, forces, faults.
    Status(status::StatusArgs),
    /// Describe the rig: controller, board, program, tasks, functions, buses, devices.
    Describe(status::StatusArgs),
    /// List what can be read: terminals, lines of the board, variables.
    List(list::CtlListArgs),
    /// Print values now.
    Read(values::ReadArgs),
    /// Write variables, places in memory or lines of the board.
    ///
    /// The line at an input, `I1`, is driven until it is written again. A bit of the image of the inputs, `%IX0.1`, is lost when
    /// the next cycle reads them, one of the outputs, `%QX0.4`, when the program writes it. The line of an output, `Q4`, is the
    /// controller's: force it.
    Write(values::WriteArgs),
    /// Force embedded inputs and outputs. They stay forced until they are released.
    ///
    /// The program reads the forced value of an input, whatever is on its line; an output has it, whatever the program writes.
    Force(values::ForceArgs),
    /// End forces.
    Release(values::ReleaseArgs),
    /// Give the controller a command.
    #[command(flatten)]
    Act(commands::ControllerCommand),
    /// Print signals as they change.
    Watch(watch::CtlWatchArgs),
    /// Wait until signals have the given values; exit with 1 if they do not in time.
    Await(await_values::AwaitArgs),
    /// Print the log.
    Log(log::LogArgs),
    /// Print the frames of the buses as they pass.
    Frames(frames::FramesArgs),
    /// List the cases that the rig can run on its board.
    Plans(plan::PlansArgs),
    /// Run a case, or all cases of a plan, in place of the controller's program, and report its progress.
    Plan(plan::PlanArgs),
    /// End the plan that runs.
    Abort,
    /// Lock the rig: until it is unlocked nobody can write, force, command or run plans.
    Lock(commands::LockArgs),
    /// End the lock.
    Unlock,
    /// Advance the time of a rig that was started with `--stepped`.
    Advance(commands::AdvanceArgs),
    /// Send lines of the protocol from standard input as they are, and print the answers.
    Raw(raw::RawArgs),
}

/// Why a command ended early.
#[derive(Debug)]
pub enum CtlError {
    /// Something between client and rig.
    Client(ClientError),
    /// It ends so, and why was printed.
    Exit(ExitStatus),
}

impl From<ClientError> for CtlError {
    fn from(error: ClientError) -> CtlError {
        CtlError::Client(error)
    }
}

/// Does what the command line asks.
pub fn run(args: &CtlArgs) -> ExitStatus {
    match try_run(args) {
        Ok(exit) | Err(CtlError::Exit(exit)) => exit,
        Err(CtlError::Client(error)) => {
            output::fault(&error.fault());
            exit_of(&error)
        }
    }
}

/// Whose fault it is: what was asked for, or the rig.
pub fn exit_of(error: &ClientError) -> ExitStatus {
    match error {
        ClientError::Refused(_)
        | ClientError::NoRig(_)
        | ClientError::SeveralRigs(_)
        | ClientError::Unreachable(..)
        | ClientError::NotARig(_)
        | ClientError::OtherProtocol(..) => ExitStatus::UserFiles,
        ClientError::Lost(_) | ClientError::Ended(_) | ClientError::Silent(..) | ClientError::Garbled(_) => {
            ExitStatus::Error
        }
    }
}

fn try_run(args: &CtlArgs) -> Result<ExitStatus, CtlError> {
    match &args.command {
        CtlCommand::Rigs => return Ok(list::rigs()),
        CtlCommand::Raw(raw) => return raw::run(&args.address, raw),
        _ => {}
    }
    let mut client = args.address.connect(NAME)?;
    let client = &mut client;
    match &args.command {
        // Done above, without a client that says hello by itself.
        CtlCommand::Rigs | CtlCommand::Raw(_) => Ok(ExitStatus::Passed),
        CtlCommand::State => status::state(client),
        CtlCommand::Status(args) => status::status(client, args),
        CtlCommand::Describe(args) => status::describe(client, args),
        CtlCommand::List(args) => list::list(client, args),
        CtlCommand::Read(args) => values::read(client, args),
        CtlCommand::Write(args) => values::write(client, args),
        CtlCommand::Force(args) => values::force(client, args),
        CtlCommand::Release(args) => values::release(client, args),
        CtlCommand::Act(command) => commands::act(client, command),
        CtlCommand::Watch(args) => watch::run(client, args),
        CtlCommand::Await(args) => await_values::run(client, args),
        CtlCommand::Log(args) => log::run(client, args),
        CtlCommand::Frames(args) => frames::run(client, args),
        CtlCommand::Plans(args) => plan::list(client, args),
        CtlCommand::Plan(args) => plan::run(client, args),
        CtlCommand::Abort => commands::abort(client),
        CtlCommand::Lock(args) => commands::lock(client, args),
        CtlCommand::Unlock => commands::unlock(client),
        CtlCommand::Advance(args) => commands::advance(client, args),
    }
}
