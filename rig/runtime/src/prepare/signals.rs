//! How the trace records a bound name.

use crate::codes;
use document::Findings;
use drivers::{Channel, ChannelKind, TimestampSource};
use plans::signals::{RecordingPolicy, SignalBinding};
use signal::{
    ClockDomain, ClockError, Policy, Sampling, SignalId, SignalInfo, Span, Trace, TraceError, Value,
    ValueKind,
};

/// Which changes of a bound signal the trace keeps. `own` is the deadband that its channel has on the board: what is
/// not reported is not known, and a second filter after it would leave more unknown than one number says.
pub(super) fn policy(
    binding: &SignalBinding,
    info: &SignalInfo,
    own: f64,
    out: &mut Findings,
) -> Option<Policy> {
    let band = match &binding.recording {
        RecordingPolicy::Changes if own > 0.0 => return Some(Policy::Deadband(own)),
        _ if own > 0.0 => {
            let message =
                format!("`{}` has a deadband of {own} {} on its board already", info.name, info.unit);
            out.error(
                codes::DEADBAND_MISFIT,
                binding.span.clone(),
                message,
                "keep one: the board file's or the plan's",
            );
            return None;
        }
        RecordingPolicy::Changes => return Some(Policy::Changes),
        RecordingPolicy::AtMostEvery(span) => return Some(Policy::AtMostEvery(*span)),
        RecordingPolicy::Deadband(band) => band,
    };
    let (message, help) = match (info.kind, plans::value_of(band, info).ok().and_then(Value::as_real)) {
        (ValueKind::Int | ValueKind::Word | ValueKind::Real, Some(band))
            if band > 0.0 && band.is_finite() =>
        {
            return Some(Policy::Deadband(band));
        }
        (ValueKind::Int | ValueKind::Word | ValueKind::Real, _) => {
            let unit = if info.unit.is_empty() {
                String::from("without a unit")
            } else {
                format!("in {}", info.unit)
            };
            let band = plans::show_literal(band);
            (format!("the deadband {band} does not fit `{}`", info.name), format!("write a number {unit}"))
        }
        _ => (format!("`{}` is no number and has no deadband", info.name), String::from("remove `deadband`")),
    };
    out.error(codes::DEADBAND_MISFIT, binding.span.clone(), message, help);
    None
}

pub(super) fn define(trace: &mut Trace, info: SignalInfo, out: &mut Findings) -> Option<SignalId> {
    let name = info.name.clone();
    match trace.define(info) {
        Ok(signal) => Some(signal),
        Err(TraceError::DuplicateName(_)) => {
            out.error(
                codes::NOT_RECORDED,
                0..0,
                format!("the trace has two signals `{name}`"),
                "rename one of them",
            );
            None
        }
        Err(error) => {
            out.error(
                codes::NOT_RECORDED,
                0..0,
                format!("the signal `{name}` cannot be recorded: {error}"),
                "",
            );
            None
        }
    }
}

pub(super) fn clocked(mut info: SignalInfo, exact: bool) -> SignalInfo {
    info.clock = if exact { ClockDomain::Virtual } else { ClockDomain::Monotonic };
    info
}

pub(super) fn channel_info(name: &str, channel: &Channel) -> SignalInfo {
    let kind = match channel.kind {
        ChannelKind::Digital => ValueKind::Bool,
        ChannelKind::Analog { .. } => ValueKind::Real,
        ChannelKind::Count => ValueKind::Int,
    };
    let sampling = match channel.timestamp {
        TimestampSource::Sampled { period } => Sampling::Sampled { period },
        _ => Sampling::Edges { resolution: channel.resolution },
    };
    SignalInfo {
        unit: channel.unit().to_owned(),
        sampling,
        shortest_pulse: channel.shortest_pulse,
        ..SignalInfo::exact(name, kind)
    }
}

/// The same, seen by a clock whose rate may be off: what was read from time to time, by that clock, may have been read more seldom.
pub(super) fn by_clock(info: SignalInfo, error: ClockError) -> SignalInfo {
    let longer = |span: Span| span + error.of(span);
    let sampling = match info.sampling {
        Sampling::Sampled { period } => Sampling::Sampled { period: longer(period) },
        edges @ Sampling::Edges { .. } => edges,
    };
    SignalInfo { sampling, shortest_pulse: longer(info.shortest_pulse), ..info }
}

/// The same, whose edges are known by as much less well.
pub(super) fn delayed(info: SignalInfo, wider: Span) -> SignalInfo {
    match info.sampling {
        Sampling::Edges { resolution } => {
            SignalInfo { sampling: Sampling::Edges { resolution: resolution + wider }, ..info }
        }
        Sampling::Sampled { .. } => info,
    }
}
