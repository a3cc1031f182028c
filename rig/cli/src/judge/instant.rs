//! Instants of a capture as the user names them: `1.5 s`, `button rises`, `lamp falls 2`.

use capture::{Capture, ChannelType, TimebaseErrors};
use document::Diagnostic;
use runtime::case::capture_import::ChannelMapping;
use signal::{SignalInfo, Span, Time, Value, When};

/// Which change of a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum EdgeKind {
    Rises,
    Falls,
    Changes,
}

/// Where names of channels and signals are looked up.
#[derive(Clone, Copy, Debug)]
pub struct CaptureNames<'a> {
    /// The capture.
    pub capture: &'a Capture,
    /// Its channels that are signals.
    pub wires: &'a [ChannelMapping],
    /// The signals.
    pub signals: &'a [SignalInfo],
    /// What the clock of the instrument may be off.
    pub timebase: TimebaseErrors,
}

/// The instant that `text`, said with `option`, names.
///
/// # Errors
/// R0177 for words that are none, R0171 for an unknown name, R0173 for what never came.
pub fn find(option: &str, text: &str, names: &CaptureNames<'_>) -> Result<When, Diagnostic> {
    if let Ok(span) = Span::parse(text) {
        let [first, last] = names.capture.span;
        let at = Time::ZERO.saturating_add(span);
        // Before the first instant the case may have begun unseen.
        if at > last {
            let message = format!("{option}: {span} is after the end of the capture");
            return Err(Diagnostic::error("R0173", message).help(range(first, last)));
        }
        return Ok(names.timebase.named(at));
    }
    let (channel, edge, count) = parse(option, text, names)?;
    let mut before = None;
    // Since when the level is not known: the edge may have come then.
    let mut unknown: Option<When> = None;
    let mut left = count;
    for change in names.capture.changes.iter().filter(|change| change.channel as usize == channel) {
        let now = change.value.as_bool();
        let met = match edge {
            EdgeKind::Rises => now == Some(true) && before == Some(false),
            EdgeKind::Falls => now == Some(false) && before == Some(true),
            EdgeKind::Changes => now.is_some() && before.is_some() && now != before,
        };
        before = now.or(before);
        left -= u64::from(met);
        if left == 0 {
            let since = unknown.map_or(change.at.earliest, |since| since.earliest);
            return Ok(When::within(since, change.at.latest));
        }
        unknown = if now.is_none() { unknown.or(Some(change.at)) } else { None };
    }
    let message = format!("{option}: `{text}` never comes");
    let [first, last] = names.capture.span;
    let help = format!("{}; {}", range(first, last), what_it_reads(names.capture, channel));
    Err(Diagnostic::error("R0173", message).help(help))
}

/// What a channel reads in the capture, and which levels it has by that: why an edge may not be there.
fn what_it_reads(capture: &Capture, channel: usize) -> String {
    let (Some(of), values) = (capture.channels.get(channel), values(capture, channel)) else {
        return String::new();
    };
    let name = &of.name;
    // What a threshold made levels of stands before it, by the same name.
    let source = capture.channels.iter().position(|one| one.name == *name).unwrap_or(channel);
    let read = range_of(capture, source);
    let Some(first) = values.iter().copied().find_map(Value::as_bool) else {
        return match read {
            Some(read) if source == channel => format!(
                "`{name}` reads {read}, and numbers have no levels: say above which value it is TRUE, as in --map \"{name}=SIGNAL@2.5\""
            ),
            Some(read) => {
                format!("`{name}` reads {read}, which is never for certain one level: correct its threshold")
            }
            None => format!("`{name}` is never known to be TRUE or FALSE"),
        };
    };
    let read = read
        .filter(|_| source != channel)
        .map_or(String::new(), |read| format!("reads {read}, and by its threshold "));
    let mut edges = [0_u64; 2];
    let mut before = first;
    for now in values.into_iter().filter_map(Value::as_bool) {
        if now != before {
            edges[usize::from(now)] += 1;
            before = now;
        }
    }
    let times = |count: u64| match count {
        0 => String::from("never"),
        1 => String::from("once"),
        count => format!("{count} times"),
    };
    let [falls, rises] = edges.map(times);
    format!("`{name}` {read}is {} at first, rises {rises} and falls {falls}", Value::Bool(first))
}

fn values(capture: &Capture, channel: usize) -> Vec<Value> {
    let own = capture.changes.iter().filter(|change| change.channel as usize == channel);
    own.map(|change| change.value).collect()
}

/// The numbers that a channel reads, with its unit: `0.02 .. 23.9 V`; nothing where it has bits.
fn range_of(capture: &Capture, channel: usize) -> Option<String> {
    let of = capture.channels.get(channel).filter(|of| of.shape != ChannelType::Bit)?;
    let numbers = values(capture, channel).into_iter().filter_map(Value::as_real);
    let [low, high] = numbers.fold(None, |range: Option<[f64; 2]>, number| {
        let [low, high] = range.unwrap_or([number; 2]);
        Some([low.min(number), high.max(number)])
    })?;
    Some(format!("{low} .. {high} {}", of.unit).trim_end().to_owned())
}

fn range(first: Time, last: Time) -> String {
    format!("the capture covers {first} to {last}")
}

/// The channel, the edge, and the how manieth it is.
fn parse(option: &str, text: &str, names: &CaptureNames<'_>) -> Result<(usize, EdgeKind, u64), Diagnostic> {
    let wrong = || {
        let message = format!("{option}: `{text}` is no instant");
        let help =
            "write a time of the capture such as \"1.5 s\", or an edge: \"button rises\", \"lamp falls 2\"";
        Diagnostic::error("R0177", message).help(help)
    };
    let mut words = text.split_whitespace().rev().peekable();
    let count = match words.peek().and_then(|word| word.parse::<u64>().ok()) {
        Some(0) => return Err(wrong()),
        Some(count) => {
            words.next();
            count
        }
        None => 1,
    };
    let edge = match words.next() {
        Some("rises") => EdgeKind::Rises,
        Some("falls") => EdgeKind::Falls,
        Some("changes") => EdgeKind::Changes,
        _ => return Err(wrong()),
    };
    let mut name: Vec<&str> = words.collect();
    name.reverse();
    let name = name.join(" ");
    if name.is_empty() {
        return Err(wrong());
    }
    let wire = names.wires.iter().find(|wire| {
        names.signals.get(wire.signal).is_some_and(|info| info.name == name)
            || names.capture.channels[wire.channel].name == name
    });
    let channel = match wire {
        Some(wire) => Some(wire.channel),
        None => names.capture.channels.iter().position(|channel| channel.name == name),
    };
    let Some(channel) = channel else {
        let known: Vec<&str> = names.capture.channels.iter().map(|channel| channel.name.as_str()).collect();
        let message = format!("{option}: the capture has no channel `{name}`");
        return Err(Diagnostic::error("R0171", message).help(super::mapping::known(&name, &known)));
    };
    Ok((channel, edge, count))
}
