//! `rig ctl read`, `write`, `force` and `release`: values and forces.

use super::show::{self, columns};
use super::{CtlError, interrupt, value};
use crate::exit::ExitStatus;
use crate::output;
use clap::Args;
use control::{ControlClient, Description, Done, Forces, RequestOperation, Signal, SignalValues, WireValue};
use serde_json::{Map, json};
use signal::Span;
use std::borrow::Cow;
use std::time::{Duration, Instant};

/// How long an interrupt may go unseen.
const LOOK_UP: Duration = Duration::from_millis(50);

/// `rig ctl read`.
#[derive(Debug, Args)]
pub struct ReadArgs {
    /// Variables, addresses, terminals or lines of the board.
    #[arg(value_name = "NAME", required = true)]
    names: Vec<String>,
    /// Print the values alone, a line each.
    #[arg(long)]
    plain: bool,
    /// Print JSON for a program: an object of names and values.
    #[arg(long, conflicts_with = "plain")]
    json: bool,
}

/// Prints values.
pub fn read(client: &mut ControlClient, args: &ReadArgs) -> Result<ExitStatus, CtlError> {
    let read: SignalValues = client.ask(RequestOperation::Read { names: args.names.clone() })?;
    let named = args.names.iter().zip(&read.values);
    if args.json {
        let map: Map<String, serde_json::Value> =
            named.map(|(name, value)| (name.clone(), json!(value))).collect();
        show::json(&map.into());
    } else if args.plain {
        for (_, WireValue(value)) in named {
            output::print(&format!("{}\n", show::field(*value)));
        }
    } else {
        let it: Description = client.ask(RequestOperation::Describe)?;
        let row = |(name, value): (&String, &WireValue)| vec![name.clone(), shown(&it, name, *value)];
        output::print(&columns(&named.map(row).collect::<Vec<_>>()));
    }
    Ok(ExitStatus::Passed)
}

/// The value with what the description knows of its signal.
fn shown(it: &Description, name: &str, WireValue(value): WireValue) -> String {
    show::value(value, &it.named(name).unwrap_or_else(|| Cow::Owned(Signal::unlisted(name, ""))))
}

/// `rig ctl write`.
#[derive(Debug, Args)]
pub struct WriteArgs {
    /// What gets which value, as in level=42, %MW3=16#FF, delay=T#500ms.
    #[arg(value_name = "NAME=VALUE", required = true)]
    pairs: Vec<String>,
}

/// Writes values, one after the other.
pub fn write(client: &mut ControlClient, args: &WriteArgs) -> Result<ExitStatus, CtlError> {
    // What cannot be read is refused before anything moves.
    let pairs = args.pairs.iter().map(|words| value::pair(client, words)).collect::<Result<Vec<_>, _>>()?;
    for (name, value) in pairs {
        client.ask::<Done>(RequestOperation::Write { name, value })?;
    }
    Ok(ExitStatus::Passed)
}

/// `rig ctl force`.
#[derive(Debug, Args)]
pub struct ForceArgs {
    /// What is forced to which value, as in %QX0.3=1 or I2=FALSE.
    #[arg(value_name = "NAME=VALUE", required = true)]
    pairs: Vec<String>,
    /// Release them again after so long, or when interrupted; if this program is killed, the board's `on-disconnect` says
    /// what becomes of them.
    #[arg(long = "for", value_name = "TIME", value_parser = crate::duration::above_zero)]
    lasts: Option<Span>,
}

/// Forces inputs and outputs.
pub fn force(client: &mut ControlClient, args: &ForceArgs) -> Result<ExitStatus, CtlError> {
    let pairs = args.pairs.iter().map(|words| value::forced(client, words));
    let pairs = pairs.collect::<Result<Vec<_>, _>>()?;
    let Some(lasts) = args.lasts else {
        for (name, value) in pairs {
            client.ask::<Done>(RequestOperation::Force { name, value })?;
        }
        // Else the forces would be those of a client that is gone.
        client.ask::<Done>(RequestOperation::Leave { forces: Forces::Keep })?;
        return Ok(ExitStatus::Passed);
    };
    let interrupted = interrupt::catch()?;
    for (name, value) in pairs {
        client.ask::<Done>(RequestOperation::Force { name, value })?;
    }
    let until = Instant::now() + Duration::from_nanos(lasts.as_nanos().unsigned_abs());
    while !interrupted() && Instant::now() < until {
        let left = until.saturating_duration_since(Instant::now()).min(LOOK_UP);
        // A rig that ends has nothing forced any more, and is an error all the same.
        client.next(left)?;
    }
    client.ask::<Done>(RequestOperation::Leave { forces: Forces::Release })?;
    Ok(if interrupted() { ExitStatus::Interrupted } else { ExitStatus::Passed })
}

/// `rig ctl release`.
#[derive(Debug, Args)]
pub struct ReleaseArgs {
    /// What is not to be forced any more.
    #[arg(value_name = "NAME", required_unless_present = "all")]
    names: Vec<String>,
    /// All that is forced.
    #[arg(long, conflicts_with = "names")]
    all: bool,
}

/// Ends forces.
pub fn release(client: &mut ControlClient, args: &ReleaseArgs) -> Result<ExitStatus, CtlError> {
    if args.all {
        client.ask::<Done>(RequestOperation::ReleaseAll)?;
    }
    for name in &args.names {
        client.ask::<Done>(RequestOperation::Release { name: name.clone() })?;
    }
    Ok(ExitStatus::Passed)
}
