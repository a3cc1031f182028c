//! `rig ctl await`: a script goes on when the controller is where it is wanted.

use super::show;
use super::watch::host;
use super::{CtlError, commands, value};
use crate::exit::ExitStatus;
use crate::output;
use clap::Args;
use control::{
    ControlClient, RequestOperation, Signal, SignalChange, Subscribed, SubscriptionEvent, Topic, WireValue,
};
use signal::{Span, Value};
use std::time::{Duration, Instant};

/// The steps in which time is advanced: the end lies at most so far after the instant that was waited for.
const STEP: Span = Span::from_millis(10);

/// How long the rig is waited for at once.
const WAIT: Duration = Duration::from_millis(200);

/// `rig ctl await`.
#[derive(Debug, Args)]
pub struct AwaitArgs {
    /// What is waited for, as in state=RUNNING, %QX0.3=1, 'level>=2.5'; of several, all at once. There are = != < <= > >=.
    #[arg(value_name = "NAME=VALUE", required = true)]
    wanted: Vec<String>,
    /// Wait at most this long [default: as long as it takes].
    #[arg(long, value_name = "TIME", value_parser = crate::duration::above_zero)]
    within: Option<Span>,
    /// Advance the rig's time, at most by this much.
    #[arg(long, value_name = "TIME", conflicts_with = "within", value_parser = crate::duration::above_zero)]
    advance: Option<Span>,
}

/// How a value is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Relation {
    Equal,
    Other,
    Below,
    AtMost,
    Above,
    AtLeast,
}

/// The signs, those first of which another one is the beginning.
const SIGNS: [(&str, Relation); 6] = [
    ("!=", Relation::Other),
    ("<=", Relation::AtMost),
    (">=", Relation::AtLeast),
    ("=", Relation::Equal),
    ("<", Relation::Below),
    (">", Relation::Above),
];

impl Relation {
    fn holds(self, is: Value, wanted: Value) -> bool {
        let ordered = match (is.as_int(), wanted.as_int()) {
            (Some(is), Some(wanted)) => Some(is.cmp(&wanted)),
            _ => is.as_real().zip(wanted.as_real()).and_then(|(is, wanted)| is.partial_cmp(&wanted)),
        };
        match self {
            Relation::Equal => ordered.map_or(is == wanted, std::cmp::Ordering::is_eq),
            // What is not known is not known to be another value either.
            Relation::Other => {
                is != Value::Unknown && ordered.map_or(is != wanted, std::cmp::Ordering::is_ne)
            }
            Relation::Below => ordered.is_some_and(std::cmp::Ordering::is_lt),
            Relation::AtMost => ordered.is_some_and(std::cmp::Ordering::is_le),
            Relation::Above => ordered.is_some_and(std::cmp::Ordering::is_gt),
            Relation::AtLeast => ordered.is_some_and(std::cmp::Ordering::is_ge),
        }
    }
}

/// The name, the sign and the value in words such as `level>=2.5`.
fn split(words: &str) -> Option<(&str, Relation, &str)> {
    let at = words.find(['!', '<', '>', '='])?;
    let (name, rest) = words.split_at(at);
    let (sign, relation) = SIGNS.into_iter().find(|(sign, _)| rest.starts_with(sign))?;
    (!name.trim().is_empty()).then(|| (name.trim(), relation, &rest[sign.len()..]))
}

struct AwaitedValue {
    words: String,
    relation: Relation,
    value: Value,
    signal: Signal,
    is: Value,
}

/// Waits.
pub fn run(client: &mut ControlClient, args: &AwaitArgs) -> Result<ExitStatus, CtlError> {
    let mut wanted = Vec::new();
    for words in &args.wanted {
        let Some((name, relation, text)) = split(words) else {
            return Err(value::refuse(words, "it compares nothing", "write NAME=VALUE, as in state=RUNNING"));
        };
        let WireValue(value) = value::of(client, name, words, text)?;
        wanted.push((words, name.to_owned(), relation, value));
    }
    let names = wanted.iter().map(|(_, name, ..)| name.clone()).collect();
    let begun: Subscribed = client
        .ask(RequestOperation::Subscribe { topic: Topic::Signals { names, every_ms: 1, all: true } })?;
    let signals = wanted.into_iter().zip(begun.signals);
    let mut wanted: Vec<AwaitedValue> = signals
        .map(|((words, _, relation, value), signal)| AwaitedValue {
            words: words.clone(),
            relation,
            value,
            signal,
            is: Value::Unknown,
        })
        .collect();
    let mut met = begun.values.iter().fold(false, |_, change| take(&mut wanted, change));
    if let Some(by) = args.advance.filter(|_| !met) {
        commands::advance_by(client, by, STEP, |client| {
            client.take_waiting(|event| met = met || event_meets(&mut wanted, &event))?;
            Ok(!met)
        })?;
    } else {
        let until = args.within.map(|within| Instant::now() + host(within));
        while !met {
            let left = until.map_or(WAIT, |until| until.saturating_duration_since(Instant::now()).min(WAIT));
            met = client.next(left)?.is_some_and(|event| event_meets(&mut wanted, &event));
            // Also of a rig that sends one event after the other.
            if until.is_some_and(|until| Instant::now() >= until) {
                break;
            }
        }
    }
    if met {
        return Ok(ExitStatus::Passed);
    }
    for one in wanted.iter().filter(|one| !one.relation.holds(one.is, one.value)) {
        output::info(&format!("{} was not reached: it is {}", one.words, show::value(one.is, &one.signal)));
    }
    Ok(ExitStatus::Failed)
}

/// Takes the changes of an event up to the one with which all hold at once.
fn event_meets(wanted: &mut [AwaitedValue], event: &SubscriptionEvent) -> bool {
    match event {
        SubscriptionEvent::Signals { changes, .. } => changes.iter().any(|change| take(wanted, change)),
        _ => false,
    }
}

/// Takes a change; returns whether all hold now.
fn take(wanted: &mut [AwaitedValue], SignalChange(number, _, _, WireValue(value)): &SignalChange) -> bool {
    for one in wanted.iter_mut().filter(|one| one.signal.number == *number) {
        one.is = *value;
    }
    wanted.iter().all(|one| one.relation.holds(one.is, one.value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_cut_at_their_sign() {
        assert_eq!(split("state=RUNNING"), Some(("state", Relation::Equal, "RUNNING")));
        assert_eq!(split("level >= 2.5"), Some(("level", Relation::AtLeast, " 2.5")));
        assert_eq!(split("a!=1"), Some(("a", Relation::Other, "1")));
        for none in ["state", "=1", "a!1", ""] {
            assert_eq!(split(none), None, "{none}");
        }
    }

    #[test]
    fn values_of_all_kinds_compare() {
        let real = Value::Real;
        assert!(Relation::Equal.holds(Value::Bool(true), Value::Int(1)));
        assert!(Relation::Equal.holds(real(2.0), Value::Int(2)));
        assert!(Relation::AtLeast.holds(Value::measured(2.5, 0.1), real(2.5)));
        assert!(Relation::Below.holds(Value::Int(-1), Value::Word(u64::MAX)));
        assert!(Relation::Equal.holds(Value::HighZ, Value::HighZ));
        assert!(Relation::Other.holds(Value::HighZ, Value::Bool(true)));
        for relation in SIGNS.map(|(_, relation)| relation) {
            assert!(!relation.holds(Value::Unknown, Value::Int(1)), "{relation:?}");
            assert_eq!(relation.holds(real(f64::NAN), real(1.0)), relation == Relation::Other);
        }
    }
}
