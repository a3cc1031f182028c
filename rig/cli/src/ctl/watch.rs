//! `rig ctl watch`: signals as they change.

use super::CtlError;
use super::commands;
use super::show::{self, field, print_text, quoted, seconds};
use crate::exit::ExitStatus;
use crate::output;
use clap::Args;
use control::{
    ControlClient, RequestOperation, Signal, SignalChange, Subscribed, SubscriptionEvent, Topic, WireValue,
};
use serde_json::json;
use signal::Span;
use std::time::{Duration, Instant};

/// How long the rig is waited for at once.
const WAIT: Duration = Duration::from_secs(1);

/// `rig ctl watch`.
#[derive(Debug, Args)]
pub struct CtlWatchArgs {
    /// Variables, addresses, terminals, lines of the board; `state` is the controller's.
    #[arg(value_name = "NAME", required = true)]
    names: Vec<String>,
    /// Print CSV for a program.
    #[arg(long)]
    csv: bool,
    /// Print JSON for a program, an object a line.
    #[arg(long, conflicts_with = "csv")]
    json: bool,
    /// Print the last change of each signal this often.
    #[arg(long, value_name = "TIME", default_value = "100 ms", value_parser = crate::duration::above_zero)]
    every: Span,
    /// Print every change.
    #[arg(long, conflicts_with = "every")]
    all: bool,
    /// End after so long [default: until it is interrupted].
    #[arg(long = "for", value_name = "TIME", value_parser = crate::duration::above_zero)]
    lasts: Option<Span>,
    /// End after so many changes.
    #[arg(long, value_name = "N")]
    count: Option<std::num::NonZeroU64>,
    /// Advance the rig's time by so much, and end then.
    #[arg(long, value_name = "TIME", conflicts_with = "lasts", value_parser = crate::duration::above_zero)]
    advance: Option<Span>,
}

/// The subscription's milliseconds of a duration.
pub fn milliseconds(every: Span) -> u32 {
    u32::try_from(every.as_nanos() / 1_000_000).unwrap_or(u32::MAX).max(1)
}

/// The host's duration of a span.
pub fn host(span: Span) -> Duration {
    Duration::from_nanos(span.as_nanos().unsigned_abs())
}

/// Prints the present values, then changes.
pub fn run(client: &mut ControlClient, args: &CtlWatchArgs) -> Result<ExitStatus, CtlError> {
    let topic =
        Topic::Signals { names: args.names.clone(), every_ms: milliseconds(args.every), all: args.all };
    let begun: Subscribed = client.ask(RequestOperation::Subscribe { topic })?;
    let mut view = WatchOutput {
        form: WatchFormat::of(args),
        signals: begun.signals,
        left: args.count.map(std::num::NonZeroU64::get),
        missed: 0,
        wide: 0,
    };
    view.wide = view.signals.iter().map(|signal| signal.name.chars().count()).max().unwrap_or_default();
    let mut open = view.form != WatchFormat::Csv || print_text("earliest_ns,latest_ns,signal,value\n");
    open &= view.changes(&begun.values, false);
    if !open {
        return Ok(ExitStatus::Passed);
    }
    if let Some(by) = args.advance {
        commands::advance_by(client, by, args.every.max(Span::from_millis(100)), |client| {
            let mut goes_on = true;
            // What the piece brought stands before its answer.
            client.take_waiting(|event| goes_on = goes_on && view.event(&event))?;
            Ok(goes_on)
        })?;
    } else {
        let until = args.lasts.map(|lasts| Instant::now() + host(lasts));
        loop {
            let left = until.map_or(WAIT, |until| until.saturating_duration_since(Instant::now()).min(WAIT));
            if let Some(event) = client.next(left)?
                && !view.event(&event)
            {
                break;
            }
            if until.is_some_and(|until| Instant::now() >= until) {
                break;
            }
        }
    }
    let missed = view.missed + client.unseen();
    if missed > 0 {
        output::note(&format!("{missed} changes were missed: they came faster than they could be sent"));
    }
    Ok(ExitStatus::Passed)
}

/// How changes are printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum WatchFormat {
    Text,
    Csv,
    Json,
}

impl WatchFormat {
    const fn of(args: &CtlWatchArgs) -> WatchFormat {
        match (args.csv, args.json) {
            (true, _) => WatchFormat::Csv,
            (_, true) => WatchFormat::Json,
            _ => WatchFormat::Text,
        }
    }
}

struct WatchOutput {
    form: WatchFormat,
    signals: Vec<Signal>,
    /// Changes that are still to come, where they are counted.
    left: Option<u64>,
    missed: u64,
    wide: usize,
}

impl WatchOutput {
    /// Prints what an event brings; `false` where nothing more is wanted.
    fn event(&mut self, event: &SubscriptionEvent) -> bool {
        match event {
            SubscriptionEvent::Signals { changes, missed, .. } => {
                self.missed += missed;
                self.changes(changes, true)
            }
            _ => true,
        }
    }

    fn changes(&mut self, changes: &[SignalChange], counted: bool) -> bool {
        let mut text = String::new();
        for change in changes {
            if counted && self.left == Some(0) {
                break;
            }
            if let Some(signal) = self.signals.iter().find(|signal| signal.number == change.0) {
                text.push_str(&line(self.form, signal, change, self.wide));
                self.left = self.left.map(|left| left - u64::from(counted));
            }
        }
        print_text(&text) && self.left != Some(0)
    }
}

/// A change as a line.
fn line(
    form: WatchFormat,
    signal: &Signal,
    SignalChange(_, earliest, latest, value): &SignalChange,
    wide: usize,
) -> String {
    let WireValue(now) = *value;
    match form {
        WatchFormat::Text => {
            let shown = show::value(now, signal);
            format!("{:>16}  {:wide$}  {shown}\n", seconds(*latest), signal.name)
        }
        WatchFormat::Csv => format!("{earliest},{latest},{},{}\n", quoted(&signal.name), field(now)),
        WatchFormat::Json => {
            let object =
                json!({ "earliest": earliest, "latest": latest, "name": signal.name, "value": value });
            format!("{object}\n")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use control::SignalKind;
    use signal::Value;

    #[test]
    fn a_change_is_one_line_in_every_form() {
        let signal = Signal {
            number: 3,
            name: "tank, left".to_owned(),
            kind: SignalKind::Real,
            unit: "bar".to_owned(),
            labels: Vec::new(),
            writable: false,
        };
        let change = SignalChange(3, 1_000, 2_000_000_000, WireValue(Value::Real(1.5)));
        assert_eq!(
            line(WatchFormat::Text, &signal, &change, 12),
            "      2.000000 s  tank, left    1.5 bar\n"
        );
        assert_eq!(line(WatchFormat::Csv, &signal, &change, 0), "1000,2000000000,\"tank, left\",1.5\n");
        assert_eq!(
            line(WatchFormat::Json, &signal, &change, 0),
            "{\"earliest\":1000,\"latest\":2000000000,\"name\":\"tank, left\",\"value\":1.5}\n"
        );
    }

    #[test]
    fn a_subscription_has_whole_milliseconds() {
        assert_eq!(milliseconds(Span::from_nanos(1)), 1);
        assert_eq!(milliseconds(Span::from_millis(250)), 250);
        assert_eq!(milliseconds(Span::MAX), u32::MAX);
    }
}
