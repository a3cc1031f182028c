//! Converters of analogue inputs.

use std::path::Path;

use document::Diagnostic;

use super::DeviceDriver;
use crate::adc::{self, AdcBoard, AdcKind, AdcSpec, FindInput, SampleSpec, iio, spi};
use crate::board::Board;
use crate::channel::{Channel, ChannelId};
use crate::channel_table::ChannelTable;
use crate::context::BoardContext;
use crate::real::{Look, RealSpec, Used};
use crate::refusal::Refusal;

pub(super) struct Adcs;

/// The converters of a board with their inputs. One that no channel uses may be missing: it is left alone.
fn used(spec: &RealSpec) -> impl Iterator<Item = (&AdcSpec, Vec<SampleSpec>)> {
    let all = spec.converters.converters.iter().enumerate();
    all.map(|(at, converter)| (converter, spec.converters.inputs_of(at)))
        .filter(|(_, inputs)| !inputs.is_empty())
}

impl DeviceDriver for Adcs {
    fn is_used(&self, spec: &RealSpec) -> bool {
        !spec.converters.samples.is_empty()
    }

    fn serves(&self, spec: &RealSpec) -> Vec<ChannelId> {
        spec.converters.samples.iter().map(|sample| sample.channel).collect()
    }

    fn describe(&self, table: &ChannelTable, spec: &RealSpec, channels: &mut [Channel]) {
        adc::describe(table, &spec.converters, channels);
    }

    fn probe(&self, table: &ChannelTable, spec: &RealSpec, look: &mut Look) {
        for (converter, inputs) in used(spec) {
            match inputs_of(converter, &inputs) {
                Ok(words) => {
                    let words = inputs.iter().zip(words).map(|(sample, words)| (sample.channel, Some(words)));
                    look.inputs.extend(words);
                }
                Err(refused) => {
                    look.inputs.extend(inputs.iter().map(|sample| (sample.channel, None)));
                    let finding = |refusal: Refusal| refusal.finding(&table.file, converter.place.clone());
                    look.found.extend(refused.into_iter().map(finding));
                }
            }
        }
    }

    fn occupies(&self, spec: &RealSpec) -> Vec<Used> {
        let device = |(converter, _): (&AdcSpec, _)| match &converter.kind {
            AdcKind::Spi(spi) => Used::behind(&spi.path),
            AdcKind::Iio(spec) => {
                iio::find(Path::new("/"), spec).ok().map(|device| Used::whole(device.number))
            }
        };
        used(spec).filter_map(device).collect()
    }

    fn open(
        &self,
        table: &ChannelTable,
        spec: &RealSpec,
        context: &BoardContext,
    ) -> Result<Box<dyn Board>, Vec<Diagnostic>> {
        Ok(Box::new(AdcBoard::open(table, &spec.converters, spec.limits, context)?))
    }
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
