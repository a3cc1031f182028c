//! Steps on channels that make pulses by themselves: what such a channel can emit is found out before anything moves.

use super::TestBench;
use super::lines::of_controller;
use super::meaning::{NameMeaning, SignalMeanings};
use crate::codes;
use crate::generator::{EmissionError, EmittedPulses, StimulusGenerator, Waveform};
use document::Findings;
use drivers::{ChannelId, Emission, NotEmitted, PulseCapability};
use plans::PlanStep;
use plans::steps::{PeriodicWave, Stimulus, StimulusShape};
use signal::{Area, Span};

/// The channel of a line that makes pulses by itself, with what it can emit.
pub(super) fn emitting(
    name: &str,
    names: &SignalMeanings<'_>,
    bench: &TestBench<'_>,
) -> Option<(ChannelId, PulseCapability)> {
    let Some(NameMeaning::Channel(channel, _)) = names.meaning(name) else { return None };
    let emits = bench.board.channels().get(usize::from(channel.0))?.emits?;
    (!of_controller(channel, bench)).then_some((channel, emits))
}

/// What a step does on a line, as pulses that the channel makes by itself. Where it cannot, a channel that also takes
/// levels is driven level by level by what is not made of pulses.
pub(super) fn by_itself(
    generator: StimulusGenerator,
    step: &PlanStep,
    names: &SignalMeanings<'_>,
    bench: &TestBench<'_>,
    out: &mut Findings,
) -> Option<StimulusGenerator> {
    let lines: Vec<&str> = step.stimulus.signals();
    let found = lines.iter().find_map(|name| emitting(name, names, bench).map(|found| (*name, found)));
    let Some((name, (channel, emits))) = found else { return Some(generator) };
    let drives = bench.board.channels()[usize::from(channel.0)].drives;
    match &step.stimulus {
        Stimulus::Train(_) | Stimulus::Wave(_) => {}
        // Levels of a table come one by one where the device takes them so.
        _ if drives => return Some(generator),
        _ if lines.len() == 1 => {}
        _ => {
            let message = format!("`{name}` cannot move together with other lines");
            let help = "its pulses begin when its device comes to them: drive the others with steps of their own, or \
                take lines that the rig drives";
            out.error(codes::LINES_NOT_TOGETHER, step.span.clone(), message, help);
            return None;
        }
    }
    if feeds_model(channel, bench) {
        let message = format!("`{name}` is an input of the model on a line that makes pulses by itself");
        let help = "bind the input to the line or counter that the generator is wired to, and name the generator's \
            channel in the step";
        out.error(codes::MODEL_INPUT_ON_GENERATOR, step.span.clone(), message, help);
        return None;
    }
    match made(&generator, channel, &emits, step) {
        Ok(emitted) => Some(StimulusGenerator::Emitted(emitted)),
        Err(why) => {
            let message = format!("`{name}` cannot emit this: {}", words(why));
            out.error(codes::PULSES_NOT_EMITTED, step.span.clone(), message, fix(why, &emits, step));
            None
        }
    }
}

/// Whether an input of the model is behind the channel: what the model sees of pulses that are reported only when they are
/// over, all at once, would be none of them.
fn feeds_model(channel: ChannelId, bench: &TestBench<'_>) -> bool {
    let feeds = |area| area == Area::Input;
    !bench.file.subject.is_external()
        && bench.file.bind.iter().any(|binding| binding.channel == channel && feeds(binding.address.area()))
}

fn made(
    generator: &StimulusGenerator,
    channel: ChannelId,
    emits: &PulseCapability,
    step: &PlanStep,
) -> Result<EmittedPulses, EmissionError> {
    let (lasts, counted) = match &step.stimulus {
        Stimulus::Wave(wave) => match &wave.shape {
            StimulusShape::Square { periodic: PeriodicWave { count, .. }, .. } => {
                (wave.lasts, count.is_some())
            }
            _ => (wave.lasts, false),
        },
        stimulus => (Some(stimulus.duration()), true),
    };
    if let (StimulusGenerator::Wave { curve, .. }, false) = (generator, counted)
        && let Waveform::Square { cycle, phase, duty, .. } = &curve.shape
        && (emits.endless || lasts.is_none())
    {
        if *phase != 0 {
            return Err(EmissionError::Phase);
        }
        let whole = u128::from(PeriodicWave::WHOLE);
        let (period, high) = (cycle.after(1, 1), cycle.after(u128::from(*duty), whole));
        let emission = Emission::Square { period, high };
        emits.check(&emission).map_err(EmissionError::NotEmitted)?;
        return Ok(EmittedPulses { channel, emission, ends: lasts });
    }
    let emission = generator.pulses(lasts.unwrap_or(Span::MAX), emits)?;
    Ok(EmittedPulses { channel, emission, ends: None })
}

fn words(why: EmissionError) -> String {
    match why {
        EmissionError::NotEmitted(why) => why.to_string(),
        EmissionError::EndsHigh => String::from("what it emits begins and ends low, and this ends high"),
        EmissionError::LetGo => String::from("what it emits is high and low, and this lets the line go"),
        EmissionError::Still => String::from("the line never moves"),
        EmissionError::Phase => String::from("a wave without end begins with its rising edge"),
    }
}

fn fix(why: EmissionError, emits: &PulseCapability, step: &PlanStep) -> String {
    let square = matches!(step.stimulus, Stimulus::Wave(_));
    match why {
        EmissionError::NotEmitted(NotEmitted::Short(_)) => {
            let fastest = 1_000_000_000 / (2 * emits.shortest.as_nanos().max(1));
            format!("lower the frequency, up to {fastest} Hz at a duty of 50 %, or take a duty nearer to it")
        }
        EmissionError::NotEmitted(NotEmitted::Long(_)) => String::from("raise the frequency"),
        EmissionError::NotEmitted(NotEmitted::Lasting(_)) => {
            String::from("make it shorter, or give the generator more room: its board file says how")
        }
        EmissionError::NotEmitted(NotEmitted::Counted) if square => {
            String::from("leave out `count`, and say with `duration` how long it takes")
        }
        EmissionError::NotEmitted(NotEmitted::Counted) => {
            String::from("emit a `square` wave, or take a line whose generator counts")
        }
        EmissionError::NotEmitted(NotEmitted::Endless) => {
            String::from("say with `count` or `duration` where it ends")
        }
        EmissionError::NotEmitted(NotEmitted::Nothing | NotEmitted::Disorder) => String::new(),
        EmissionError::EndsHigh if square => String::from("let it last whole periods, as with `count`"),
        EmissionError::EndsHigh | EmissionError::LetGo | EmissionError::Still => {
            String::from("let the table raise the line and take it back, or drive a line that the rig drives")
        }
        EmissionError::Phase => String::from("leave out `phase`, or take a line that the rig drives"),
    }
}
