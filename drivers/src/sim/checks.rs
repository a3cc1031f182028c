//! What a simulated channel is to the outside, and which faults it takes.

use signal::{Span, Time, Value};

use crate::ChannelKind;
use crate::board::BoardError;
use crate::channel::{Channel, Fault, FaultKind, FaultSet, TimestampSource};
use crate::circuit::{ChannelSpec, fit};

/// The channel as the rig sees it.
pub(super) fn channel(spec: &ChannelSpec) -> Channel {
    let digital = spec.kind == ChannelKind::Digital;
    Channel {
        name: spec.name.clone(),
        kind: spec.kind.clone(),
        drives: spec.drives,
        senses: spec.senses,
        timestamp: TimestampSource::Virtual,
        resolution: Span::ZERO,
        shortest_pulse: Span::from_nanos(1),
        // A nanosecond on, a nanosecond off.
        deadband: 0.0,
        max_pulse_hz: if digital && spec.drives { 500_000_000 } else { 0 },
        emits: None,
        counts_hz: None,
        faults: match spec.kind {
            ChannelKind::Digital => FaultSet::DIGITAL,
            ChannelKind::Analog { .. } => FaultSet::ANALOG,
            ChannelKind::Count => FaultSet::NONE.with(FaultKind::Lost),
        },
        safe: fit(&spec.kind, spec.safe).unwrap_or(Value::HighZ),
    }
}

/// The fault with its value as the channel carries it, and the instant at which it ends.
pub(super) fn fault(channel: &Channel, now: Time, fault: Fault) -> Result<(Fault, Option<Time>), BoardError> {
    if !channel.faults.contains(fault.kind) {
        return Err(BoardError::NoSuchFault(fault.channel));
    }
    let fitting = |value| fit(&channel.kind, value).ok_or(BoardError::BadValue(fault.channel));
    let bad_time = BoardError::BadFaultTime(fault.channel);
    let positive = |span: Span| if span > Span::ZERO { Ok(span) } else { Err(bad_time) };
    let mut lasts = fault.lasts.map(positive).transpose()?;
    let kind = match fault.kind {
        FaultKind::StuckAt(value) => FaultKind::StuckAt(fitting(value)?),
        FaultKind::Glitch { value, width } => {
            let width = positive(width)?;
            lasts = Some(lasts.map_or(width, |lasts| lasts.min(width)));
            FaultKind::Glitch { value: fitting(value)?, width }
        }
        FaultKind::Late(delay) => FaultKind::Late(positive(delay)?),
        kind => kind,
    };
    let ends = |span: Span| now.as_nanos().checked_add(span.as_nanos()).map(Time::from_nanos).ok_or(bad_time);
    let until = lasts.map(ends).transpose()?;
    Ok((Fault { kind, ..fault }, until))
}
