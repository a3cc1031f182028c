//! Which channel of a capture is which signal of the case.

use capture::{Capture, CapturedChannel, ChannelType};
use document::{Diagnostic, suggest};
use runtime::case::capture_import::{ChannelMapping, misfit};
use runtime::suite::instrument_file::{InstrumentChannel, InstrumentFile};
use signal::{SignalInfo, Unit, Value, ValueKind};

/// Channels that a message names at most.
const NAMED: usize = 16;

/// What there is in place of an unknown name.
pub fn known(name: &str, names: &[&str]) -> String {
    if let Some(near) = suggest(name, names.iter().copied()) {
        return format!("there is `{near}`");
    }
    let more = if names.len() > NAMED { ", ..." } else { "" };
    format!("there is {}{more}", names[..names.len().min(NAMED)].join(", "))
}

/// The wires: as the user says, and by equal names. `spelled` are the signals' names as a dump has them.
///
/// # Errors
/// A mapping that is none, names that do not exist, channels that do not fit.
pub fn wires(
    given: &[String],
    capture: &Capture,
    signals: &[SignalInfo],
    spelled: &[String],
    instrument: Option<&InstrumentFile>,
) -> Result<Vec<ChannelMapping>, Vec<Diagnostic>> {
    let mut wires: Vec<ChannelMapping> = Vec::new();
    let mut found = Vec::new();
    for text in given {
        match mapping(text, capture, signals) {
            Ok(wire) if wires.iter().any(|known| known.signal == wire.signal) => {
                let name = &signals[wire.signal].name;
                let message = format!("--map {text}: `{name}` is mapped twice");
                found.push(Diagnostic::error("R0178", message).help("remove one of the two"));
            }
            Ok(wire) => wires.push(wire),
            Err(wrong) => found.push(wrong),
        }
    }
    for (signal, (info, spelled)) in signals.iter().zip(spelled).enumerate() {
        if wires.iter().any(|wire| wire.signal == signal) {
            continue;
        }
        let named = |name: &str| capture.channels.iter().position(|channel| channel.name == name);
        if let Some(channel) = named(&info.name).or_else(|| named(spelled)) {
            if capture.channels[channel].shares_name {
                found.push(ambiguous(&capture.channels[channel].name, &info.name, capture));
                continue;
            }
            wires.push(ChannelMapping::new(channel, signal));
        }
    }
    for wire in &mut wires {
        let (channel, info) = (&capture.channels[wire.channel], &signals[wire.signal]);
        if let Some(instrument) = instrument {
            let described = instrument.channel(&channel.name);
            // A threshold of the command line rules over that of the file.
            let is_told = wire.threshold.is_some() || is_always_off(capture, wire.channel);
            let wrong = described.and_then(|of| Some((of, misdescribed(channel, info, of, is_told)?)));
            found.extend(wrong.map(|(of, wrong)| wrong.at(&instrument.name, of.place.clone(), "")));
            *wire = wire.described(info, instrument, &channel.name);
        }
        // A column of zeros and ones may be numbers as well.
        if let Some((message, help)) = misfit(channel, info, wire.threshold) {
            found.push(Diagnostic::error("R0174", message).help(help));
        }
    }
    if found.is_empty() { Ok(wires) } else { Err(found) }
}

/// Whether a channel is 0 all along: a dead line has no bits and no volts.
fn is_always_off(capture: &Capture, channel: usize) -> bool {
    capture
        .changes
        .iter()
        .all(|change| change.channel as usize != channel || change.value == Value::Bool(false))
}

/// What an instrument file says of a channel that the channel, or its signal, cannot have. `is_told` where it is no question
/// whether it has bits or volts.
fn misdescribed(
    channel: &CapturedChannel,
    info: &SignalInfo,
    of: &InstrumentChannel,
    is_told: bool,
) -> Option<Diagnostic> {
    let (name, signal) = (&channel.name, &info.name);
    let misfit = |message: String, help: String| Some(Diagnostic::error("R0213", message).help(help));
    let has_errors = of.error.of_value > 0.0 || of.error.plus > 0.0;
    let line = info.kind == ValueKind::Bool;
    if line && !is_told && of.threshold.is_some() && channel.shape == ChannelType::Bit {
        return misfit(
            format!("`{name}` has bits in the capture and a threshold in the instrument file"),
            format!("remove the threshold, or say that it has volts: --map \"{name}={signal}@2.5\""),
        );
    }
    if has_errors && !line && info.kind != ValueKind::Real {
        return misfit(
            format!("`{signal}` has whole numbers, and the instrument file gives `{name}` an accuracy"),
            format!("remove `accuracy` of `{name}`, or map it to a real number"),
        );
    }
    // Bits have no unit, which nobody could compare with anything.
    if line && !is_told && !of.unit.is_empty() && channel.shape == ChannelType::Bit && channel.unit.is_empty()
    {
        return misfit(
            format!("`{name}` has bits in the capture and the unit {} in the instrument file", of.unit),
            format!("remove `unit` of `{name}`"),
        );
    }
    let given = match channel.unit.is_empty() {
        true if info.kind == ValueKind::Real => &info.unit,
        _ => &channel.unit,
    };
    // Without figures nothing is computed in it, and it would be wrong in the report all the same.
    let counts = has_errors || line && of.threshold.is_some() || !of.unit.is_empty();
    if counts && !given.is_empty() && Unit::new(given) != Unit::new(&of.unit) {
        let own = if of.unit.is_empty() { "no unit" } else { &of.unit };
        return misfit(
            match channel.unit.is_empty() {
                true => format!(
                    "the capture gives `{name}` no unit, so that it counts in {given} as `{signal}` does, and its figures in the instrument file are in {own}"
                ),
                false => {
                    format!("`{name}` is in {given}, and its figures in the instrument file are in {own}")
                }
            },
            format!(
                "write unit = \"{given}\" for it, and its figures in {given}; a column in another unit has to be converted"
            ),
        );
    }
    None
}

/// Channels of an instrument file that the capture does not have: an error where a name is nearly that of another channel, whose
/// errors would be left out, else a note.
///
/// # Errors
/// R0213 for each name that is nearly one of the capture's.
pub fn unknown_channels(
    instrument: &InstrumentFile,
    capture: &Capture,
) -> Result<Vec<String>, Vec<Diagnostic>> {
    let has = |name: &str| capture.channels.iter().any(|channel| channel.name == name);
    let free = capture.channels.iter().map(|channel| channel.name.as_str());
    let free: Vec<&str> = free.filter(|name| instrument.channel(name).is_none()).collect();
    let (mut found, mut strange) = (Vec::new(), Vec::new());
    for channel in instrument.channels.iter().filter(|channel| !has(&channel.name)) {
        let name = &channel.name;
        match suggest(name, free.iter().copied()) {
            Some(near) => {
                let message = format!("the capture has no channel `{name}`");
                let help = format!("write `{near}`, or remove the channel from the file");
                let wrong = Diagnostic::error("R0213", message).help(help);
                found.push(wrong.at(&instrument.name, channel.place.clone(), ""));
            }
            None => strange.push(name.clone()),
        }
    }
    if found.is_empty() { Ok(strange) } else { Err(found) }
}

/// That several channels have the name of a signal, so that none of them is it by its name.
fn ambiguous(channel: &str, signal: &str, capture: &Capture) -> Diagnostic {
    let twins = capture.channels.iter().filter(|one| {
        one.shares_name
            && one.name.strip_prefix(channel).is_some_and(|rest| rest.is_empty() || rest.starts_with('_'))
    });
    let names: Vec<&str> = twins.map(|one| one.name.as_str()).take(NAMED).collect();
    let message = format!("{} channels of the capture have the name `{channel}`", names.len());
    let help = format!(
        "say which one it is: --map \"{channel}={signal}\" is the first; in the order of the file they are {}",
        names.join(", ")
    );
    Diagnostic::error("R0179", message).help(help)
}

/// `CHANNEL=SIGNAL`, `CHANNEL=SIGNAL@THRESHOLD`.
fn mapping(text: &str, capture: &Capture, signals: &[SignalInfo]) -> Result<ChannelMapping, Diagnostic> {
    // A channel's name may hold a `=`, a signal's does not.
    let Some((channel, signal)) = text.rsplit_once('=') else {
        let message = format!("--map {text}: it names no signal");
        return Err(Diagnostic::error("R0178", message).help("write --map CHANNEL=SIGNAL"));
    };
    let (signal, threshold) = match signal.rsplit_once('@') {
        None => (signal, None),
        Some((signal, number)) => match number.trim().parse::<f64>() {
            Ok(number) if number.is_finite() => (signal, Some(number)),
            _ => {
                let message = format!("--map {text}: `{number}` is not a number");
                return Err(Diagnostic::error("R0178", message).help("write the threshold as in lamp@2.5"));
            }
        },
    };
    let (channel, signal) = (channel.trim(), signal.trim());
    let Some(channel_at) = capture.channels.iter().position(|one| one.name == channel) else {
        let names: Vec<&str> = capture.channels.iter().map(|one| one.name.as_str()).collect();
        let message = format!("--map {text}: the capture has no channel `{channel}`");
        return Err(Diagnostic::error("R0171", message).help(known(channel, &names)));
    };
    let Some(signal_at) = signals.iter().position(|info| info.name == signal) else {
        let names: Vec<&str> = signals.iter().map(|info| info.name.as_str()).collect();
        let names: Vec<&str> = names.into_iter().filter(|name| !name.starts_with("step:")).collect();
        let message = format!("--map {text}: the case has no signal `{signal}`");
        return Err(Diagnostic::error("R0172", message).help(known(signal, &names)));
    };
    Ok(ChannelMapping { threshold, ..ChannelMapping::new(channel_at, signal_at) })
}
