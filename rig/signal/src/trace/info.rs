//! The encoding of signal definitions, for the digest and for the file.

use super::code::{CodeFault, CodeReader, put_text, put_varint};
use crate::{ClockDomain, Policy, Sampling, SignalInfo, Span, ValueKind};

/// Appends a definition.
pub(super) fn put_info(out: &mut Vec<u8>, info: &SignalInfo) {
    put_text(out, &info.name);
    out.push(match info.kind {
        ValueKind::Bool => 0,
        ValueKind::Int => 1,
        ValueKind::Word => 2,
        ValueKind::Real => 3,
        ValueKind::State => 4,
        ValueKind::Mark => 5,
    });
    put_text(out, &info.unit);
    put_varint(out, info.labels.len() as u64);
    for (number, label) in &info.labels {
        out.extend_from_slice(&number.to_le_bytes());
        put_text(out, label);
    }
    out.push(match info.clock {
        ClockDomain::Virtual => 0,
        ClockDomain::Monotonic => 1,
        ClockDomain::Device => 2,
    });
    match info.sampling {
        Sampling::Edges { resolution } => put_tagged(out, 0, resolution.as_nanos() as u64),
        Sampling::Sampled { period } => put_tagged(out, 1, period.as_nanos() as u64),
    }
    out.extend_from_slice(&info.shortest_pulse.as_nanos().to_le_bytes());
    match info.policy {
        Policy::Changes => put_tagged(out, 0, 0),
        Policy::Deadband(band) => put_tagged(out, 1, band.to_bits()),
        Policy::AtMostEvery(span) => put_tagged(out, 2, span.as_nanos() as u64),
    }
}

fn put_tagged(out: &mut Vec<u8>, tag: u8, bits: u64) {
    out.push(tag);
    out.extend_from_slice(&bits.to_le_bytes());
}

/// Reads a definition that takes all of `bytes`.
pub(super) fn read_info(bytes: &[u8]) -> Result<SignalInfo, CodeFault> {
    let mut reader = CodeReader::new(bytes);
    let name = reader.text()?.to_string();
    let kind = match reader.byte()? {
        0 => ValueKind::Bool,
        1 => ValueKind::Int,
        2 => ValueKind::Word,
        3 => ValueKind::Real,
        4 => ValueKind::State,
        5 => ValueKind::Mark,
        _ => return Err(CodeFault::Bad),
    };
    let unit = reader.text()?.to_string();
    let count = reader.varint()?;
    // No reservation: the count is not to be trusted before the labels are seen.
    let mut labels = Vec::new();
    for _ in 0..count {
        labels.push((reader.u64()? as i64, reader.text()?.to_string()));
    }
    let clock = match reader.byte()? {
        0 => ClockDomain::Virtual,
        1 => ClockDomain::Monotonic,
        2 => ClockDomain::Device,
        _ => return Err(CodeFault::Bad),
    };
    let sampling = match (reader.byte()?, Span::from_nanos(reader.u64()? as i64)) {
        (0, resolution) => Sampling::Edges { resolution },
        (1, period) => Sampling::Sampled { period },
        _ => return Err(CodeFault::Bad),
    };
    let shortest_pulse = Span::from_nanos(reader.u64()? as i64);
    let policy = match (reader.byte()?, reader.u64()?) {
        (0, 0) => Policy::Changes,
        (1, bits) if f64::from_bits(bits) > 0.0 && f64::from_bits(bits).is_finite() => {
            Policy::Deadband(f64::from_bits(bits))
        }
        (2, nanos) if (nanos as i64) > 0 => Policy::AtMostEvery(Span::from_nanos(nanos as i64)),
        _ => return Err(CodeFault::Bad),
    };
    if !reader.rest().is_empty() {
        return Err(CodeFault::Bad);
    }
    Ok(SignalInfo { name, kind, unit, labels, clock, sampling, shortest_pulse, policy })
}

/// Memory that a definition takes in a trace, roughly.
pub(super) fn info_bytes(info: &SignalInfo) -> usize {
    let labels: usize = info.labels.iter().map(|(_, label)| size_of::<(i64, String)>() + label.len()).sum();
    size_of::<SignalInfo>() + 2 * info.name.len() + info.unit.len() + labels + 128
}
