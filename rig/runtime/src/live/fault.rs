//! What is said to a client whose order is not carried out.

use crate::codes;
use crate::scan_port::ScanCommandError;
use control::RequestFault;
use controller::{CommandError, State, WriteError};

fn fault(code: &str, message: String, help: &str) -> RequestFault {
    RequestFault { code: code.into(), message, help: help.into() }
}

/// A name that the rig does not know.
pub fn unknown(name: &str, meant: Option<&str>) -> RequestFault {
    let help = match meant {
        Some(meant) => format!("did you mean `{meant}`?"),
        None => String::from("`rig ctl list` shows the names; addresses such as %MW12 can be named besides"),
    };
    fault(codes::UNKNOWN_TO_RIG, format!("unknown name `{name}`"), &help)
}

/// A name of a terminal that no module has, or whose channel is not used.
pub fn unknown_terminal(name: &str, help: &str) -> RequestFault {
    fault(codes::UNKNOWN_TO_RIG, format!("unknown name `{name}`"), help)
}

/// An address that the controller does not have.
pub fn unknown_address(name: &str, why: &str) -> RequestFault {
    fault(
        codes::UNKNOWN_TO_RIG,
        format!("unknown name `{name}`: {why}"),
        "name an address of this controller",
    )
}

/// Something that is only looked at.
pub fn not_written(name: &str) -> RequestFault {
    let help = "write a variable, a %M address, or a line of the board that nothing of the rig drives; an output is forced";
    fault(codes::CLIENT_CANNOT_WRITE, format!("`{name}` cannot be written"), help)
}

/// A value that does not fit.
pub fn bad_value(name: &str, wanted: &str) -> RequestFault {
    fault(
        codes::CLIENT_VALUE_MISFIT,
        format!("the value does not fit `{name}`"),
        &format!("it takes {wanted}"),
    )
}

/// More than there is room for.
pub fn too_many(what: &str) -> RequestFault {
    fault(codes::TOO_MANY, format!("too much at once: {what}"), "end what is not needed, or ask again later")
}

/// Something that is no input or output of the controller.
pub fn not_forced(name: &str) -> RequestFault {
    let help = "force an input or output of the controller, as in %IX0.2 or Q3; write anything else";
    fault(codes::NOT_FORCEABLE, format!("`{name}` cannot be forced"), help)
}

/// Why the scan did not carry out an order.
pub fn refused(why: ScanCommandError) -> RequestFault {
    match why {
        ScanCommandError::Command(refusal) => {
            fault(codes::COMMAND_REFUSED, format!("the controller does not obey: {refusal}"), fix(refusal))
        }
        ScanCommandError::Write(WriteError::State(state)) => fault(
            codes::COMMAND_REFUSED,
            format!("nothing is written in state {state}"),
            "switch it on, and wait until it has booted",
        ),
        ScanCommandError::Write(error) => fault(
            codes::CLIENT_CANNOT_WRITE,
            error.to_string(),
            "write a variable, or an address of %M, %Q or %I",
        ),
        ScanCommandError::Board(error) => {
            fault(codes::LINE_NOT_DRIVEN, format!("the board does not do it: {error}"), "")
        }
        ScanCommandError::NotStepped => fault(
            codes::NOT_STEPPED,
            "the time of this rig is not stepped".into(),
            "start the rig with `rig run --stepped` to advance it",
        ),
        ScanCommandError::PlanRuns => plan_runs(),
        ScanCommandError::NoPlan => fault(codes::NO_PLAN_RUNS, "no plan runs".into(), ""),
        ScanCommandError::NoModel => fault(
            codes::COMMAND_REFUSED,
            "the controller is a real one: its memory is out of reach".into(),
            "",
        ),
    }
}

const fn fix(refusal: CommandError) -> &'static str {
    match refusal {
        CommandError::State(State::Off) => "switch its supply on first",
        CommandError::State(State::Booting) => "wait until it has booted",
        CommandError::State(State::Empty) => "it has no application any more: start the rig again",
        CommandError::State(State::Halt) => "reset it first",
        CommandError::NeedsPowerCycle => "switch its supply off and on",
        CommandError::SwitchAtStop => "move the Run/Stop switch to Run first",
        CommandError::RunStopInput => "give the Run/Stop input a 1 first",
        CommandError::Stopping => "wait until the cycle under way has ended",
        CommandError::ExpertOutput(_) => "a function drives it: act on the function",
        _ => "",
    }
}

/// Clients lead the time of modelled lines alone.
pub const LED: &str = codes::REAL_LINES_NOT_STEPPED;

/// A plan that cannot be run.
pub fn plan(why: &str) -> RequestFault {
    fault(
        codes::PLAN_NOT_RUN,
        format!("the plan cannot be run: {why}"),
        "`rig ctl plans` lists those that there are, `rig check` says what is wrong with one",
    )
}

/// Files of plans that do not come from their disk.
pub fn not_read(what: &str, seconds: u64) -> RequestFault {
    fault(
        codes::PLANS_NOT_READ,
        format!("what is at `{what}` was not read within {seconds} s"),
        "name a single plan or a smaller folder, on a disk that answers",
    )
}

/// More files of plans at once than are read.
pub fn plans_are_read(most: usize) -> RequestFault {
    fault(
        codes::PLANS_NOT_READ,
        format!("plans are being read for {most} requests, and none of them has ended"),
        "ask again later; if it lasts, a disk or network folder with plans does not answer",
    )
}

/// A case that a plan does not have.
pub fn no_case(name: &str, meant: Option<&str>) -> RequestFault {
    let help = meant.map_or_else(
        || String::from("`rig ctl plans` lists the cases"),
        |meant| format!("did you mean `{meant}`?"),
    );
    fault(codes::PLAN_NOT_RUN, format!("there is no case `{name}`"), &help)
}

/// A plan has the board.
pub fn plan_runs() -> RequestFault {
    fault(
        codes::PLAN_HAS_BOARD,
        "a plan runs: the board is its own until it ends".into(),
        "wait until it is over, or abort it",
    )
}

/// A rig that runs no plans.
pub fn no_plans() -> RequestFault {
    fault(codes::NO_PLANS, "this rig runs no plans".into(), "run them with `rig test`")
}
