//! `rig ctl frames`: what passes on the buses.

use super::CtlError;
use super::commands;
use super::show::{print_text, seconds};
use super::watch::host;
use crate::exit::ExitStatus;
use crate::output;
use clap::Args;
use control::{
    ControlClient, Description, FrameSeen, RequestOperation, Subscribed, SubscriptionEvent, Topic,
};
use document::Diagnostic;
use serde_json::json;
use signal::Span;
use std::time::{Duration, Instant};

/// How long the rig is waited for at once.
const WAIT: Duration = Duration::from_secs(1);

/// A name that the rig does not know.
const UNKNOWN: &str = "R0601";

/// Time is advanced in steps of so much.
const PIECE: Span = Span::from_millis(100);

/// `rig ctl frames`.
#[derive(Debug, Args)]
pub struct FramesArgs {
    /// Only those of these buses.
    #[arg(value_name = "BUS")]
    buses: Vec<String>,
    /// Print JSON for a program, an object a line.
    #[arg(long)]
    json: bool,
    /// End after so long [default: until it is interrupted].
    #[arg(long = "for", value_name = "TIME", value_parser = crate::duration::above_zero)]
    lasts: Option<Span>,
    /// End after so many frames.
    #[arg(long, value_name = "N")]
    count: Option<std::num::NonZeroU64>,
    /// Advance the rig's time by so much, and end then.
    #[arg(long, value_name = "TIME", conflicts_with = "lasts", value_parser = crate::duration::above_zero)]
    advance: Option<Span>,
}

/// Refuses names that no bus of the rig has.
fn known(client: &mut ControlClient, names: &[String]) -> Result<(), CtlError> {
    if names.is_empty() {
        return Ok(());
    }
    let described: Description = client.ask(RequestOperation::Describe)?;
    let buses: Vec<&str> = described.buses.iter().map(|bus| bus.name.as_str()).collect();
    let Some(name) = names.iter().find(|name| !buses.contains(&name.as_str())) else { return Ok(()) };
    let all = match buses.is_empty() {
        true => String::from("its board has no buses"),
        false => format!("its buses are {}", buses.join(", ")),
    };
    let help = match document::suggest(name, buses.iter().copied()) {
        Some(meant) => format!("did you mean `{meant}`? {all}"),
        None => all,
    };
    let found = Diagnostic::error(UNKNOWN, format!("the rig has no bus `{name}`"));
    output::findings(&[found.help(help)], &[]);
    Err(CtlError::Exit(ExitStatus::UserFiles))
}

/// Prints frames.
pub fn run(client: &mut ControlClient, args: &FramesArgs) -> Result<ExitStatus, CtlError> {
    known(client, &args.buses)?;
    client.ask::<Subscribed>(RequestOperation::Subscribe { topic: Topic::Frames })?;
    let mut left = args.count.map(std::num::NonZeroU64::get);
    let mut take = |event: &SubscriptionEvent| match event {
        SubscriptionEvent::Frame { frame, .. } if wanted(args, frame) => {
            left = left.map(|left| left - 1);
            let text = if args.json { format!("{}\n", json!(frame)) } else { line(frame) };
            print_text(&text) && left != Some(0)
        }
        SubscriptionEvent::Missed { lines, .. } => {
            output::note(&format!("{lines} frames were left out"));
            true
        }
        _ => true,
    };
    if let Some(by) = args.advance {
        commands::advance_by(client, by, PIECE, |client| {
            let mut goes_on = true;
            client.take_waiting(|event| goes_on = goes_on && take(&event))?;
            Ok(goes_on)
        })?;
        return Ok(ExitStatus::Passed);
    }
    let until = args.lasts.map(|lasts| Instant::now() + host(lasts));
    while until.is_none_or(|until| Instant::now() < until) {
        let wait = until.map_or(WAIT, |until| until.saturating_duration_since(Instant::now()).min(WAIT));
        if let Some(event) = client.next(wait)?
            && !take(&event)
        {
            break;
        }
    }
    Ok(ExitStatus::Passed)
}

fn wanted(args: &FramesArgs, frame: &FrameSeen) -> bool {
    args.buses.is_empty() || args.buses.contains(&frame.bus)
}

/// A frame as a line: instant, bus, direction, identifier, length, bytes, flags.
fn line(frame: &FrameSeen) -> String {
    let way = if frame.sent { "sent" } else { "got" };
    let bytes: Vec<String> =
        frame.data.as_bytes().chunks(2).map(|pair| String::from_utf8_lossy(pair).into_owned()).collect();
    let mut line = format!("{:>16}  {}  {way:<4}", seconds(frame.at), frame.bus);
    if !frame.id.is_empty() {
        line.push_str(&format!("  {:>8}", frame.id));
    }
    line.push_str(&format!("  [{}] {}", bytes.len(), bytes.join(" ")));
    if !frame.flags.is_empty() {
        line.push_str(&format!("  {}", frame.flags.join(" ")));
    }
    format!("{}\n", line.trim_end())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_a_line() {
        let frame = |id: &str, data: &str, flags: &[&str]| FrameSeen {
            bus: "drive".to_owned(),
            at: 1_500_000_000,
            sent: id.is_empty(),
            id: id.to_owned(),
            flags: flags.iter().map(|flag| (*flag).to_owned()).collect(),
            data: data.to_owned(),
        };
        assert_eq!(
            line(&frame("18F", "0102FF", &["fd", "brs"])),
            "      1.500000 s  drive  got        18F  [3] 01 02 FF  fd brs\n"
        );
        assert_eq!(line(&frame("", "41", &[])), "      1.500000 s  drive  sent  [1] 41\n");
        assert_eq!(
            line(&frame("7FF", "", &["remote"])),
            "      1.500000 s  drive  got        7FF  [0]   remote\n"
        );
    }
}
