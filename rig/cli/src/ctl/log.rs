//! `rig ctl log`.

use super::CtlError;
use super::show::{print_text, seconds};
use super::watch::host;
use crate::exit::ExitStatus;
use crate::output;
use clap::Args;
use control::{ControlClient, RequestOperation, Subscribed, SubscriptionEvent, Topic};
use signal::Span;
use std::time::{Duration, Instant};

/// How long the rig is waited for at once.
const WAIT: Duration = Duration::from_secs(1);

/// `rig ctl log`.
#[derive(Debug, Args)]
pub struct LogArgs {
    /// Go on with what comes, until it is interrupted.
    #[arg(long, short)]
    follow: bool,
    /// Go on with what comes, for so long.
    #[arg(long = "for", value_name = "TIME", value_parser = crate::duration::above_zero)]
    lasts: Option<Span>,
    /// Begin with the last N lines alone.
    #[arg(long, short = 'n', value_name = "N")]
    lines: Option<usize>,
}

/// Prints the log so far, then what comes.
pub fn run(client: &mut ControlClient, args: &LogArgs) -> Result<ExitStatus, CtlError> {
    let begun: Subscribed = client.ask(RequestOperation::Subscribe { topic: Topic::Log })?;
    let first = args.lines.map_or(0, |lines| begun.log.len().saturating_sub(lines));
    let mut open = begun.log.iter().skip(first).all(|line| print_text(&shown(line.at, &line.text)));
    let until = args.lasts.map(|lasts| Instant::now() + host(lasts));
    while open && (args.follow || until.is_some()) && until.is_none_or(|until| Instant::now() < until) {
        let left = until.map_or(WAIT, |until| until.saturating_duration_since(Instant::now()).min(WAIT));
        match client.next(left)? {
            Some(SubscriptionEvent::Log { at, text, .. }) => open = print_text(&shown(at, &text)),
            Some(SubscriptionEvent::Missed { lines, .. }) => {
                output::note(&format!("{lines} lines were left out"))
            }
            _ => {}
        }
    }
    Ok(ExitStatus::Passed)
}

fn shown(at: i64, text: &str) -> String {
    format!("{:>16}  {text}\n", seconds(at))
}
