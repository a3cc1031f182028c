//! From stimuli that go on to their generators: values in the units of their channels.

use super::TestBench;
use super::emission::{by_itself, emitting};
use super::lines::{driven, warn_if_not_promised, warn_if_too_fast};
use super::meaning::SignalMeanings;
use crate::codes;
use crate::frames;
use crate::generator::{Band, Curve, Form, Rows, StimulusGenerator, TableValue, Waveform};
use document::Findings;
use drivers::ChannelId;
use plans::PlanStep;
use plans::steps::{Encoder, PeriodicWave, Sequence, Stimulus, StimulusShape, WaveStimulus};
use plans::table::Cell;
use signal::{Decimal, Quantity, QuantityRange, Random, Unit, Value};

/// Place of the index among the lines of an encoder.
const INDEX: usize = 2;

/// The generator of a step that has one: what the rig does, or what it has the board do.
pub(super) fn generator(
    step: &PlanStep,
    names: &SignalMeanings<'_>,
    bench: &TestBench<'_>,
    out: &mut Findings,
) -> Option<StimulusGenerator> {
    by_itself(by_rig(step, names, bench, out)?, step, names, bench, out)
}

/// What the rig would write itself, edge by edge.
fn by_rig(
    step: &PlanStep,
    names: &SignalMeanings<'_>,
    bench: &TestBench<'_>,
    out: &mut Findings,
) -> Option<StimulusGenerator> {
    match &step.stimulus {
        Stimulus::Train(train) => {
            let channel = pulsed(&train.signal, names, bench, step, out)?;
            if !is_level(channel, bench) {
                let message = format!("`{}` has {}", train.signal, carries(channel, bench));
                let help =
                    "a train drives levels: write `square` with a `range`, as in range = \"0 .. 10 V\"";
                out.error(codes::VALUE_MISFIT, step.span.clone(), message, help);
                return None;
            }
            warn_if_too_fast(channel, train.millihertz(), bench, step, out);
            let high = train.falls(1);
            let shortest = high.min(train.rises(2) - high) - train.jitter - train.jitter;
            warn_if_not_promised(channel, shortest, bench, step, out);
            Some(StimulusGenerator::Train { channel, train: train.clone(), seed: bench.seed })
        }
        Stimulus::Wave(wave) => {
            let channel = pulsed(&wave.signal, names, bench, step, out)?;
            if let Some(rate) = wave.millihertz() {
                warn_if_too_fast(channel, rate, bench, step, out);
                warn_if_not_promised(channel, wave.shortest(), bench, step, out);
            }
            Some(StimulusGenerator::Wave { channel, curve: curve(wave, channel, bench, step, out)? })
        }
        Stimulus::Encoder(encoder) => {
            let lines = encoder_lines(encoder, names, bench, step, out)?;
            Some(StimulusGenerator::Encoder { lines, encoder: encoder.clone() })
        }
        Stimulus::Sequence(sequence) => {
            let columns = sequence.columns.iter().map(|(column, name)| {
                let channel = pulsed(name, names, bench, step, out)?;
                Some((channel, values(sequence, *column, channel, bench, step, out)?))
            });
            let columns: Option<Vec<_>> = columns.collect();
            Some(StimulusGenerator::Sequence(Rows::new(sequence, columns?)))
        }
        Stimulus::Send(send) => {
            // A case that sends on a bus which the board lacks does not come here.
            let (bus, known) = frames::find(bench.board, &send.frame.bus)?;
            let frame = frames::outgoing(&send.frame, known);
            let frame = frame.map_err(|why| {
                let help = "send a frame that it carries, or give the bus a `data-bitrate`";
                out.error(codes::FRAME_NOT_CARRIED, step.span.clone(), why, help);
            });
            let seed = seed_of(bench.seed, &step.id);
            Some(StimulusGenerator::Frames { bus, frame: frame.ok()?, send: send.clone(), seed })
        }
        _ => None,
    }
}

/// The channel of a line that the plan may drive, or that makes pulses by itself.
fn pulsed(
    name: &str,
    names: &SignalMeanings<'_>,
    bench: &TestBench<'_>,
    step: &PlanStep,
    out: &mut Findings,
) -> Option<ChannelId> {
    match emitting(name, names, bench) {
        Some((channel, _)) => Some(channel),
        None => driven(name, names, bench, step, out),
    }
}

/// The values of a column as its channel takes them, row by row.
fn values(
    sequence: &Sequence,
    column: usize,
    channel: ChannelId,
    bench: &TestBench<'_>,
    step: &PlanStep,
    out: &mut Findings,
) -> Option<Vec<Option<TableValue>>> {
    let table = &sequence.table;
    let head = &table.columns[column];
    let level = is_level(channel, bench);
    if level && !head.unit.is_none() {
        let name = &bench.board.channels()[usize::from(channel.0)].name;
        let message = format!("column `{}` has a unit, and `{name}` has levels", head.name);
        out.error(
            codes::VALUE_MISFIT,
            step.span.clone(),
            message,
            "leave the unit out, or let it drive another signal",
        );
        return None;
    }
    // The unit is that of the whole column: one answer for all rows.
    let one = Quantity { number: Decimal::from(1), unit: head.unit.clone() };
    if !level {
        in_unit(&one, channel, bench, step, out)?;
    }
    let unit = Unit::new(bench.board.channels()[usize::from(channel.0)].unit());
    let mut list = Vec::with_capacity(table.times.len());
    for (row, line) in table.lines.iter().enumerate() {
        let number = |number: Decimal| match head.unit.is_none() {
            true => Some(number),
            false => Quantity { number, unit: head.unit.clone() }.in_unit(&unit),
        };
        let value = match (table.cell(row, column), level) {
            (Cell::Kept, _) => None,
            (Cell::HighZ, _) => Some(TableValue { value: Value::HighZ, number: None }),
            (Cell::Level(on), true) => Some(TableValue { value: Value::Bool(on), number: None }),
            (Cell::Number(number), true) if number == Decimal::ZERO || number == Decimal::from(1) => {
                Some(TableValue { value: Value::Bool(number != Decimal::ZERO), number: None })
            }
            (Cell::Number(value), false) => {
                let value = number(value)?;
                Some(TableValue { value: Value::Real(value.as_f64()), number: Some(value) })
            }
            _ => {
                let message = format!("line {line} of {} does not fit `{}`", table.path, head.name);
                let help = if level { "a level is TRUE or FALSE, 1 or 0" } else { "a number is expected" };
                out.error(codes::VALUE_MISFIT, step.span.clone(), message, help);
                return None;
            }
        };
        list.push(value);
    }
    Some(list)
}

fn encoder_lines(
    encoder: &Encoder,
    names: &SignalMeanings<'_>,
    bench: &TestBench<'_>,
    step: &PlanStep,
    out: &mut Findings,
) -> Option<[Option<ChannelId>; 3]> {
    let mut lines = [None; 3];
    for (place, (line, name)) in lines.iter_mut().zip(encoder.lines()).enumerate() {
        let channel = pulsed(name, names, bench, step, out)?;
        if !is_level(channel, bench) {
            let message = format!("`{name}` is no line: it has {}", carries(channel, bench));
            out.error(codes::VALUE_MISFIT, step.span.clone(), message, "an encoder drives levels");
            return None;
        }
        warn_if_too_fast(channel, encoder.millihertz(), bench, step, out);
        // The index is high for one count, A and B keep a level for two.
        let counts = if place == INDEX { 1 } else { 2 };
        warn_if_not_promised(channel, encoder.lasts_at_most_speed(counts), bench, step, out);
        *line = Some(channel);
    }
    Some(lines)
}

fn is_level(channel: ChannelId, bench: &TestBench<'_>) -> bool {
    bench.board.channels()[usize::from(channel.0)].is_digital()
}

/// What a channel carries, in words.
fn carries(channel: ChannelId, bench: &TestBench<'_>) -> String {
    let channel = &bench.board.channels()[usize::from(channel.0)];
    match (channel.is_digital(), channel.unit()) {
        (true, _) => String::from("levels"),
        (false, "") => String::from("plain numbers"),
        (false, unit) => format!("values in {unit}"),
    }
}

/// A wave with its values in the unit of its channel.
fn curve(
    wave: &WaveStimulus,
    channel: ChannelId,
    bench: &TestBench<'_>,
    step: &PlanStep,
    out: &mut Findings,
) -> Option<Curve> {
    let level =
        matches!(&wave.shape, StimulusShape::Square { periodic: PeriodicWave { range: None, .. }, .. });
    if level != is_level(channel, bench) {
        let message = format!("`{}` has {}", wave.signal, carries(channel, bench));
        let help = match (level, &wave.shape) {
            (true, _) => "give the square wave a `range`, as in range = \"0 .. 10 V\"",
            (false, StimulusShape::Square { .. }) => "leave out the `range`: the wave is FALSE and TRUE then",
            _ => "a level is driven with `square`, `train`, `pulse` or `set`",
        };
        out.error(codes::VALUE_MISFIT, step.span.clone(), message, help);
        return None;
    }
    let mut number = |quantity: &Quantity| in_unit(quantity, channel, bench, step, out);
    let mut band = |range: &QuantityRange| -> Option<Band> {
        let (min, max) = (number(range.min.as_ref()?), number(range.max.as_ref()?));
        Some(Band::new(min?, max?))
    };
    let shape = match &wave.shape {
        StimulusShape::Ramp { from: Some(from), to } => {
            let (from, to) = (number(from)?, number(to)?);
            Waveform::Ramp { band: Band::new(from, to), fixed: true }
        }
        StimulusShape::Ramp { from: None, to } => {
            let to = number(to)?;
            Waveform::Ramp { band: Band::new(to, to), fixed: false }
        }
        StimulusShape::Sine(periodic) => shape(Form::Sine, periodic, band(periodic.range.as_ref()?)?),
        StimulusShape::Triangle { periodic, rise } => {
            shape(Form::Triangle(*rise), periodic, band(periodic.range.as_ref()?)?)
        }
        StimulusShape::Square { periodic, duty } => Waveform::Square {
            band: match &periodic.range {
                Some(range) => Some(band(range)?),
                None => None,
            },
            cycle: periodic.cycle,
            phase: periodic.phase,
            // The parts of a phase are finer by this.
            duty: duty * (PeriodicWave::WHOLE / 1_000_000),
        },
        StimulusShape::Noise { range, deviation } => Waveform::Noise {
            band: band(range)?,
            deviation: match deviation {
                Some(deviation) => Some(number(deviation)?.as_f64()),
                None => None,
            },
            seed: seed_of(bench.seed, &step.id),
        },
    };
    Some(Curve { shape, lasts: wave.lasts, sample: wave.sample })
}

fn shape(form: Form, periodic: &PeriodicWave, band: Band) -> Waveform {
    Waveform::Periodic {
        form,
        band,
        cycle: periodic.cycle,
        phase: periodic.phase,
        whole: periodic.count.is_some(),
    }
}

/// A quantity as a number in the unit of a channel.
fn in_unit(
    quantity: &Quantity,
    channel: ChannelId,
    bench: &TestBench<'_>,
    step: &PlanStep,
    out: &mut Findings,
) -> Option<Decimal> {
    let unit = bench.board.channels()[usize::from(channel.0)].unit();
    let number =
        if quantity.unit.is_none() { Some(quantity.number) } else { quantity.in_unit(&Unit::new(unit)) };
    if number.is_none() {
        let name = &bench.board.channels()[usize::from(channel.0)].name;
        let message = format!("{quantity} does not fit `{name}`, which has {}", carries(channel, bench));
        out.error(
            codes::VALUE_MISFIT,
            step.span.clone(),
            message,
            "write it in a unit of this kind, or as a number",
        );
    }
    number
}

/// The seed of one noise of a case: further ones shift nothing.
fn seed_of(seed: u64, id: &str) -> u64 {
    let lane = id.bytes().fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    });
    Random::lane(seed, lane).below(u64::MAX)
}
