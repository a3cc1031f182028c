//! The channels and terminals that steps act on, and what these can take.

use super::TestBench;
use super::meaning::{NameMeaning, SignalMeanings};
use super::signals::channel_info;
use crate::application::observable::Observable;
use crate::codes;
use controller::Probe;
use document::Findings;
use drivers::{BoardKind, Channel, ChannelId, FaultKind};
use plans::PlanStep;
use plans::lang::Literal;
use plans::steps::LineFault;
use profile::IoChannel;
use signal::{Address, Area, Level, Span, Value};

/// The code of pulses that the board does not promise: a case with such a step gets no verdict.
pub(crate) const NOT_PROMISED: &str = codes::PULSES_NOT_PROMISED;

/// The channel of a line.
pub(super) fn line(
    name: &str,
    names: &SignalMeanings<'_>,
    step: &PlanStep,
    out: &mut Findings,
) -> Option<ChannelId> {
    if let Some(NameMeaning::Channel(channel, _)) = names.meaning(name) {
        return Some(channel);
    }
    // A name that means nothing at all was reported where it is bound.
    if names.meaning(name).is_some() {
        let help = "a line is a terminal such as \"%IX0.0\" or \"M1.IW0\", or a channel of the board; `write` gives a variable or a place its value";
        out.error(codes::NOT_A_LINE, step.span.clone(), format!("`{name}` is no line"), help);
    }
    None
}

/// Whether an output terminal is behind the channel.
pub(super) fn of_controller(channel: ChannelId, bench: &TestBench<'_>) -> bool {
    bench.file.bind.iter().any(|binding| binding.channel == channel && binding.address.area() == Area::Output)
}

/// The channel of a line that the plan may drive: not one that the model drives.
pub(super) fn driven(
    name: &str,
    names: &SignalMeanings<'_>,
    bench: &TestBench<'_>,
    step: &PlanStep,
    out: &mut Findings,
) -> Option<ChannelId> {
    let channel = line(name, names, step, out)?;
    if of_controller(channel, bench) {
        let help = "an output is the controller's own: force it, or put a fault on it";
        out.error(
            codes::NOT_DRIVABLE,
            step.span.clone(),
            format!("`{name}` is driven by the controller"),
            help,
        );
        return None;
    }
    let known = &bench.board.channels()[usize::from(channel.0)];
    if !known.drives {
        let help = match bench.file.kind {
            _ if known.emits.is_some() => {
                "it makes pulses and keeps no level: take `train`, `square` or `sequence`"
            }
            BoardKind::Real(_) => {
                "name the line that drives it as `line` of its channel, and the one wired to it as `readback`"
            }
            BoardKind::Simulated => "",
        };
        out.error(codes::NOT_DRIVABLE, step.span.clone(), format!("the board cannot drive `{name}`"), help);
        return None;
    }
    Some(channel)
}

/// The place of an input or output of the controller, for forcing.
pub(super) fn forced_place(
    name: &str,
    names: &SignalMeanings<'_>,
    bench: &TestBench<'_>,
    step: &PlanStep,
    out: &mut Findings,
) -> Option<Address> {
    let address = match names.meaning(name)? {
        NameMeaning::Channel(_, Some(address)) => Some(address),
        NameMeaning::Channel(channel, None) => {
            bench.file.bind.iter().find(|binding| binding.channel == channel).map(|binding| binding.address)
        }
        NameMeaning::Inside(Observable { probe: Probe::Address(address), .. }) => Some(address),
        NameMeaning::Inside(_) | NameMeaning::OfBus => None,
    };
    let place = address.filter(|address| bench.subject.terminal(*address).is_some());
    if place.is_none() {
        let help = "only inputs and outputs of the controller are forced; a variable is written with `write`";
        out.error(codes::NOT_A_LINE, step.span.clone(), format!("`{name}` is no input or output"), help);
    }
    place
}

/// A written value as a channel takes it, if it does.
fn value_on(literal: &Literal, channel: &Channel) -> Option<Value> {
    if !channel.is_digital() && matches!(literal, Literal::Value(Value::Bool(_))) {
        return None;
    }
    match (plans::value_of(literal, &channel_info(&channel.name, channel)).ok()?, channel.is_digital()) {
        (Value::HighZ, _) => Some(Value::HighZ),
        (value, true) => match value.as_int() {
            Some(0) => Some(Value::from(Level::Low)),
            Some(1) => Some(Value::from(Level::High)),
            _ => None,
        },
        (value, false) => value.as_real().map(Value::Real),
    }
}

/// A planned fault as a channel takes it; `None` where its value does not fit.
pub(crate) fn fault_on(kind: &LineFault, channel: &Channel) -> Option<FaultKind> {
    Some(match kind {
        LineFault::Stuck(value) => FaultKind::StuckAt(value_on(value, channel)?),
        LineFault::Open => FaultKind::Open,
        LineFault::ShortToGround => FaultKind::ShortToGround,
        LineFault::ShortToSupply => FaultKind::ShortToSupply,
        LineFault::Glitch { value, width } => {
            FaultKind::Glitch { value: value_on(value, channel)?, width: *width }
        }
        LineFault::Late(delay) => FaultKind::Late(*delay),
        LineFault::Lost => FaultKind::Lost,
    })
}

/// A written value as the channel takes it.
pub(super) fn value_for(
    literal: &Literal,
    channel: ChannelId,
    bench: &TestBench<'_>,
    step: &PlanStep,
    out: &mut Findings,
) -> Option<Value> {
    let channel = &bench.board.channels()[usize::from(channel.0)];
    let value = value_on(literal, channel);
    if value.is_none() {
        let help = if channel.is_digital() {
            String::from("it takes TRUE or FALSE")
        } else {
            match channel.unit() {
                "" => String::from("it takes a number without a unit"),
                unit => format!("it takes a number in {unit}, as in \"1.5 {unit}\""),
            }
        };
        out.error(
            codes::VALUE_MISFIT,
            step.span.clone(),
            format!("the value does not fit `{}`", channel.name),
            help,
        );
    }
    value
}

pub(super) fn fault_kind(
    kind: &LineFault,
    channel: ChannelId,
    bench: &TestBench<'_>,
    step: &PlanStep,
    out: &mut Findings,
) -> Option<FaultKind> {
    if let LineFault::Stuck(value) | LineFault::Glitch { value, .. } = kind {
        value_for(value, channel, bench, step, out)?;
    }
    let channel = &bench.board.channels()[usize::from(channel.0)];
    let kind = fault_on(kind, channel)?;
    if !channel.faults.contains(kind) {
        out.error(
            codes::FAULT_NOT_AVAILABLE,
            step.span.clone(),
            format!("the board cannot put this fault on `{}`", channel.name),
            available(channel),
        );
        return None;
    }
    Some(kind)
}

/// The faults that a channel can have, in words.
fn available(channel: &Channel) -> String {
    let all = [
        ("stuck", FaultKind::StuckAt(Value::Bool(false))),
        ("open", FaultKind::Open),
        ("short-to-ground", FaultKind::ShortToGround),
        ("short-to-supply", FaultKind::ShortToSupply),
        ("glitch", FaultKind::Glitch { value: Value::Bool(false), width: Span::ZERO }),
        ("late", FaultKind::Late(Span::ZERO)),
        ("lost", FaultKind::Lost),
    ];
    let named = all.into_iter().filter(|(_, kind)| channel.faults.contains(*kind)).map(|(name, _)| name);
    match named.collect::<Vec<_>>() {
        none if none.is_empty() => {
            String::from("it can have none: fault relays of the board make faults on real lines")
        }
        known => format!("it can have {}", known.join(", ")),
    }
}

/// Reports pulses that are faster than a regular input can follow (io:REF-03).
pub(super) fn warn_if_too_fast(
    channel: ChannelId,
    millihertz: u64,
    bench: &TestBench<'_>,
    step: &PlanStep,
    out: &mut Findings,
) {
    let Some(hertz) = bench.profile.regular_input_hertz() else { return };
    let mut bound = bench.file.bind.iter().filter(|binding| binding.channel == channel);
    let regular = bound.find(|binding| match IoChannel::at(binding.address, bench.reference) {
        Some(IoChannel::Input(input)) => input >= bench.reference.fast_inputs,
        _ => false,
    });
    if let Some(binding) = regular.filter(|_| millihertz > u64::from(hertz) * 1_000) {
        let message = format!("the step is out of specification for the regular input {}", binding.address);
        let help = format!("{} allows it up to {hertz} Hz", bench.profile.name());
        out.warn(codes::STIMULUS_OUT_OF_SPECIFICATION, step.span.clone(), message, help);
    }
}

/// Reports pulses that the board does not promise on this line. A level of them lasts `shortest` at least.
pub(super) fn warn_if_not_promised(
    channel: ChannelId,
    shortest: Span,
    bench: &TestBench<'_>,
    step: &PlanStep,
    out: &mut Findings,
) {
    let channel = &bench.board.channels()[usize::from(channel.0)];
    let promised = channel.max_pulse_hz;
    let shortest = u128::try_from(shortest.as_nanos()).unwrap_or(0).max(1);
    // Instants are rounded to the nanosecond.
    let slow = (shortest + 1) * 2 * u128::from(promised) >= 1_000_000_000;
    // What makes pulses by itself says by itself which.
    if promised > 0 && slow || channel.emits.is_some() {
        return;
    }
    let needs = 1_000_000_000u128.div_ceil(2 * shortest);
    let name = &channel.name;
    let (message, help) = match promised {
        0 => (
            format!("the step needs pulses of {needs} Hz on `{name}`, of which the board promises none"),
            format!("write `pulses-up-to = \"{needs} Hz\"` after its `line`, if it can make them"),
        ),
        _ => (
            format!("the step needs pulses of {needs} Hz on `{name}`, which makes them up to {promised} Hz"),
            String::from(
                "slow the step down, or raise `pulses-up-to` of the channel as far as its line follows",
            ),
        ),
    };
    out.warn(NOT_PROMISED, step.span.clone(), message, help);
}
