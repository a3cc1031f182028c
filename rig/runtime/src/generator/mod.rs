//! Stimuli that go on: what they do is worked out act by act as its time comes, so that a wave of an hour takes no more
//! room than a pulse.
//!
//! Act `n` follows from `n` alone: when it comes and what it writes. So an act can be asked for ahead of its turn, and
//! a generator that is stopped leaves nothing behind.

mod band;
mod emission;
mod sequence;
mod wave;

pub use band::Band;
pub use emission::{EmissionError, EmittedPulses};
pub use sequence::{Rows, TableValue};
pub use wave::{Curve, Form, Waveform};

use drivers::{BusId, ChannelId, Emission};
use plans::steps::{Encoder, SendFrames, TrainStimulus};
use signal::{CanFrame, Random, Span, Value};

/// A stimulus under way.
#[derive(Clone, Debug)]
pub enum StimulusGenerator {
    /// A train of pulses: a rising edge, a falling edge, and so on.
    Train {
        /// Where it is emitted.
        channel: ChannelId,
        /// The pulses.
        train: TrainStimulus,
        /// What its jitter is drawn from.
        seed: u64,
    },
    /// A wave.
    Wave {
        /// The channel that it drives.
        channel: ChannelId,
        /// Its values.
        curve: Curve,
    },
    /// An encoder: the lines as they stand, then one act for each count.
    Encoder {
        /// A, B and the index.
        lines: [Option<ChannelId>; 3],
        /// What its shaft does.
        encoder: Encoder,
    },
    /// A table: one row after another.
    Sequence(Rows),
    /// Frames on a bus: an act for each.
    Frames {
        /// The bus.
        bus: BusId,
        /// Each of them.
        frame: CanFrame,
        /// When they come.
        send: Box<SendFrames>,
        /// What their jitter is drawn from.
        seed: u64,
    },
    /// Pulses that the board makes by itself.
    Emitted(EmittedPulses),
}

/// What an act of a generator asks of the board besides levels and values.
#[derive(Clone, Debug)]
pub enum BoardOrder {
    /// To send a frame.
    Send(BusId, CanFrame),
    /// To emit pulses.
    Emit(ChannelId, Emission),
}

impl StimulusGenerator {
    /// How long after the beginning act `n` from 0 comes; `None` after the last.
    pub fn after(&self, n: u64) -> Option<Span> {
        match self {
            StimulusGenerator::Train { train, seed, .. } => {
                let pulse = u32::try_from(n / 2 + 1).ok().filter(|pulse| *pulse <= train.count)?;
                Some(pulse_edge(train, *seed, pulse, n.is_multiple_of(2)))
            }
            StimulusGenerator::Wave { curve, .. } => curve.after(n),
            StimulusGenerator::Encoder { encoder, .. } => match n {
                0 => Some(Span::ZERO),
                n => encoder.count(n).map(|(after, _)| after),
            },
            StimulusGenerator::Sequence(rows) => rows.after(n),
            StimulusGenerator::Frames { send, seed, .. } => {
                (n < u64::from(send.count)).then(|| send.after(n, *seed))
            }
            StimulusGenerator::Emitted(emitted) => emitted.after(n),
        }
    }

    /// When pulse `n` from 1 of a train rises, jitter included.
    pub fn rises(&self, n: u32) -> Option<Span> {
        match self {
            StimulusGenerator::Train { train, seed, .. } => Some(pulse_edge(train, *seed, n, true)),
            StimulusGenerator::Emitted(emitted) => emitted.rises(n),
            _ => None,
        }
    }

    /// What act `n`, which there is, writes: appended to `out`.
    pub fn writes(&self, n: u64, out: &mut Vec<(ChannelId, Value)>) {
        match self {
            StimulusGenerator::Train { channel, .. } => {
                out.push((*channel, Value::Bool(n.is_multiple_of(2))))
            }
            StimulusGenerator::Wave { channel, curve } => {
                if let Some(after) = curve.after(n) {
                    out.push((*channel, curve.value(n, after)));
                }
            }
            StimulusGenerator::Sequence(rows) => rows.writes(n, out),
            StimulusGenerator::Frames { .. } => {}
            StimulusGenerator::Emitted(emitted) => emitted.writes(n, out),
            StimulusGenerator::Encoder { lines, encoder } => {
                let before = n.checked_sub(1).map(|before| match before {
                    0 => encoder.from,
                    n => encoder.count(n).map_or(encoder.from, |(_, position)| position),
                });
                let position = encoder.count(n).map_or(encoder.from, |(_, position)| position);
                let levels = |position: i64| {
                    let (a, b, index) = encoder.levels(position);
                    [a, b, index]
                };
                let (old, new) = (before.map(levels), levels(position));
                for (place, line) in lines.iter().enumerate() {
                    // Only what changes: a line that something else drives by now is left alone.
                    if let Some(line) = line
                        && old.is_none_or(|old| old[place] != new[place])
                    {
                        out.push((*line, Value::Bool(new[place])));
                    }
                }
            }
        }
    }

    /// Whether its acts are edges, whose distances count where nobody can make up for a late one.
    pub fn is_of_edges(&self) -> bool {
        match self {
            StimulusGenerator::Train { .. }
            | StimulusGenerator::Encoder { .. }
            | StimulusGenerator::Sequence(_) => true,
            StimulusGenerator::Wave { curve, .. } => matches!(curve.shape, Waveform::Square { .. }),
            StimulusGenerator::Frames { .. } | StimulusGenerator::Emitted(_) => false,
        }
    }

    /// What act `n` asks of the board besides, if anything.
    pub fn order(&self, n: u64) -> Option<BoardOrder> {
        match self {
            StimulusGenerator::Frames { bus, frame, .. } => Some(BoardOrder::Send(*bus, *frame)),
            StimulusGenerator::Emitted(emitted) if n == 0 => {
                Some(BoardOrder::Emit(emitted.channel, emitted.emission.clone()))
            }
            _ => None,
        }
    }

    /// It begins now, with what `driven` says that each channel is driven to.
    pub fn begin(&mut self, driven: &[Value]) {
        let StimulusGenerator::Wave { channel, curve } = self else { return };
        if let Waveform::Ramp { band, fixed: false } = &mut curve.shape {
            let from = driven.get(usize::from(channel.0)).and_then(|value| value.as_real());
            // A channel that nobody drives reads 0.
            *band = Band::from_float(from.unwrap_or(0.0), band.to());
        }
    }

    /// The channels that it drives.
    pub fn channels(&self) -> impl Iterator<Item = ChannelId> {
        let (few, rows) = match self {
            StimulusGenerator::Train { channel, .. } | StimulusGenerator::Wave { channel, .. } => {
                ([Some(*channel), None, None], None)
            }
            StimulusGenerator::Encoder { lines, .. } => (*lines, None),
            StimulusGenerator::Sequence(rows) => ([None; 3], Some(rows)),
            StimulusGenerator::Emitted(emitted) => ([Some(emitted.channel), None, None], None),
            StimulusGenerator::Frames { .. } => ([None; 3], None),
        };
        few.into_iter().flatten().chain(rows.into_iter().flat_map(Rows::channels))
    }
}

/// From the beginning of a train to an edge of its pulse `n` from 1.
fn pulse_edge(train: &TrainStimulus, seed: u64, n: u32, rising: bool) -> Span {
    let nominal = if rising { train.rises(n) } else { train.falls(n) };
    if train.jitter == Span::ZERO {
        return nominal;
    }
    // The jitter of an edge depends on its number alone.
    let mut random = Random::new(seed ^ (u64::from(n) << 1 | u64::from(rising)).wrapping_mul(0x9e37_79b9));
    let width = train.jitter.as_nanos() as u64 * 2 + 1;
    let moved = Span::from_nanos(random.below(width) as i64) - train.jitter;
    (nominal + moved).max(Span::ZERO)
}
