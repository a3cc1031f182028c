//! What the rig does with the converters of a board.

use std::path::Path;
use std::sync::Arc;

use document::Diagnostic;

use super::{AdcBoard, AdcKind, AdcSpec, AdcsSpec, FindInput, SampleSpec, iio, spi};
use crate::board::Board;
use crate::channel::{Channel, ChannelId};
use crate::channel_table::ChannelTable;
use crate::context::BoardContext;
use crate::device_limits::DeviceLimits;
use crate::real::{DeviceSpec, Look, Used};
use crate::refusal::Refusal;

impl DeviceSpec for AdcsSpec {
    fn is_used(&self) -> bool {
        !self.samples.is_empty()
    }

    fn serves(&self) -> Vec<ChannelId> {
        self.samples.iter().map(|sample| sample.channel).collect()
    }

    fn describe(&self, table: &ChannelTable, _limits: DeviceLimits, channels: &mut [Channel]) {
        super::describe(table, self, channels);
    }

    fn probe(&self, table: &ChannelTable, look: &mut Look) {
        for (converter, inputs) in self.used() {
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

    fn occupies(&self) -> Vec<Used> {
        let device = |(converter, _): (&AdcSpec, _)| match &converter.kind {
            AdcKind::Spi(spi) => Used::behind(&spi.path),
            AdcKind::Iio(spec) => {
                iio::find(Path::new("/"), spec).ok().map(|device| Used::whole(device.number))
            }
        };
        self.used().filter_map(device).collect()
    }

    fn open(
        &self,
        table: &ChannelTable,
        limits: DeviceLimits,
        context: &BoardContext,
    ) -> Result<Box<dyn Board>, Vec<Diagnostic>> {
        Ok(Box::new(AdcBoard::open(table, self, limits, context)?))
    }

    fn with_channels(&self, number: &dyn Fn(ChannelId) -> Option<ChannelId>) -> Arc<dyn DeviceSpec> {
        let sample =
            |sample: &SampleSpec| Some(SampleSpec { channel: number(sample.channel)?, ..sample.clone() });
        let samples = self.samples.iter().filter_map(sample).collect();
        Arc::new(AdcsSpec { converters: self.converters.clone(), samples })
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
