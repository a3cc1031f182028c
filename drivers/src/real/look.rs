//! A look at the devices of a board that have no lines: whether they are there, free and set up as the file says.

use document::Diagnostic;
use rustix::fs::{Access, access};
use std::path::Path;

use super::RealSpec;
use crate::adc::{AdcKind, AdcSpec, FindInput, Refusal, SampleSpec, iio, spi};
use crate::can::{self, CanBusSpec};
use crate::counter;
use crate::file::BoardFile;
use crate::generator::{self, GeneratorSpec, OutputSpec};
use crate::serial::{self, OpenError, SerialSpec};
use crate::{BusId, ChannelId};

/// What was found, and what is wrong.
#[derive(Debug, Default)]
pub struct Look {
    /// What is behind a channel that has no line, in words; `None` where it cannot be had.
    pub inputs: Vec<(ChannelId, Option<String>)>,
    /// What a bus is, in words; `None` where it cannot be had.
    pub buses: Vec<(BusId, String, Option<String>)>,
    /// What is wrong, at its place in the file.
    pub found: Vec<Diagnostic>,
}

/// Looks at converters, counters, generators and buses. Nothing is set up, and nothing is kept.
pub fn look(file: &BoardFile, spec: &RealSpec) -> Look {
    let mut look = Look::default();
    for (at, converter) in spec.converters.converters.iter().enumerate() {
        let inputs = spec.converters.inputs_of(at);
        // A converter that no channel uses may be missing.
        if inputs.is_empty() {
            continue;
        }
        match inputs_of(converter, &inputs) {
            Ok(words) => {
                let words = inputs.iter().zip(words).map(|(sample, words)| (sample.channel, Some(words)));
                look.inputs.extend(words);
            }
            Err(refused) => {
                look.inputs.extend(inputs.iter().map(|sample| (sample.channel, None)));
                let finding = |refusal: Refusal| refusal.finding(&file.name, converter.place.clone());
                look.found.extend(refused.into_iter().map(finding));
            }
        }
    }
    for count in &spec.counters.counts {
        let Some(counter) = spec.counters.counters.get(count.counter) else { continue };
        let words = match counter::look(Path::new("/"), counter) {
            Ok((device, hardware)) => {
                let function = counter.function.map_or(&*hardware.function, |function| function.kernel());
                Some(format!("count {} of {}, {function}", hardware.number, counter::named(&device)))
            }
            Err(refusal) => {
                look.found.push(refusal.finding(&file.name, counter.place.clone()));
                None
            }
        };
        look.inputs.push((count.channel, words));
    }
    for (at, generator) in spec.generators.generators.iter().enumerate() {
        let outputs = spec.generators.outputs_of(at);
        if !outputs.is_empty() {
            generated(file, generator, &outputs, &mut look);
        }
    }
    for bus in &spec.can.buses {
        let words = interface(file, bus).map_err(|found| look.found.push(found)).ok();
        look.buses.push((bus.bus, bus.name.clone(), words));
    }
    for line in &spec.serial {
        let words = port(line).map_err(|error| {
            let (code, message, help) = serial::refused(&error);
            let found = Diagnostic::error(code, message).at(file.name.clone(), line.place.clone(), "");
            look.found.push(found.help(help));
        });
        look.buses.push((line.bus, line.name.clone(), words.ok()));
    }
    look.buses.sort_by_key(|(bus, ..)| *bus);
    look
}

/// What is behind each input of a converter.
fn inputs_of(converter: &AdcSpec, inputs: &[SampleSpec]) -> Result<Vec<String>, Vec<Refusal>> {
    let one = |refusal| vec![refusal];
    match &converter.kind {
        AdcKind::Spi(spec) => {
            for sample in inputs {
                spi::choose(spec, sample).map_err(one)?;
            }
            // It is let go again at once.
            drop(spi::claim(&spec.path).map_err(one)?);
            let words = |sample: &SampleSpec| match &sample.input {
                FindInput::Number(number) => format!("input {number}"),
                FindInput::Name(name) => format!("input {name}"),
            };
            let of = format!("of {} on {}", spec.part.name(), spec.path.display());
            Ok(inputs.iter().map(|sample| format!("measures {} {of}, free", words(sample))).collect())
        }
        AdcKind::Iio(spec) => {
            let (device, places) = iio::look(spec, inputs)?;
            let of = iio::named(&device);
            let words = |place: &usize| {
                let input = device.inputs.get(*place).map_or("", |input| input.name.as_str());
                format!("measures {input} of {of}, free")
            };
            Ok(places.iter().map(words).collect())
        }
    }
}

/// What is behind each output of a generator.
fn generated(file: &BoardFile, generator: &GeneratorSpec, outputs: &[OutputSpec], look: &mut Look) {
    match generator::look(generator, outputs) {
        Ok(words) => {
            let words = outputs.iter().zip(words).map(|(output, words)| (output.channel, Some(words)));
            look.inputs.extend(words);
        }
        Err(refusal) => {
            look.inputs.extend(outputs.iter().map(|output| (output.channel, None)));
            look.found.push(refusal.finding(&file.name, generator.place.clone()));
        }
    }
}

/// A CAN interface in words.
fn interface(file: &BoardFile, bus: &CanBusSpec) -> Result<String, Diagnostic> {
    can::find(file, bus)?;
    let mut words = format!("CAN bus on {}", bus.interface);
    // It was there a moment ago.
    if let Ok(link) = can::ask(&bus.interface) {
        words += &can::words(&link);
    }
    if bus.configure {
        words += ", set up by the rig";
    }
    Ok(words)
}

/// A serial port in words.
fn port(line: &SerialSpec) -> Result<String, OpenError> {
    let path = &line.port.path;
    access(path, Access::READ_OK | Access::WRITE_OK).map_err(|errno| {
        OpenError::Call(serial::SerialError::new(path, serial::SerialCall::Open, &errno.into()))
    })?;
    if line.port.exclusive && !crate::holders(path).is_empty() {
        return Err(OpenError::Busy(path.clone()));
    }
    Ok(format!("serial line on {}, {} Bd, free", path.display(), line.port.line.baud))
}
