//! What the rig does with the generators of a board.

use std::path::Path;
use std::sync::Arc;

use document::Diagnostic;

use super::{GeneratorBoard, GeneratorKind, GeneratorSpec, GeneratorsSpec, OutputSpec};
use crate::board::Board;
use crate::channel::{Channel, ChannelId};
use crate::channel_table::ChannelTable;
use crate::context::BoardContext;
use crate::device_limits::DeviceLimits;
use crate::real::{DeviceSpec, Look, Used};

impl DeviceSpec for GeneratorsSpec {
    fn is_used(&self) -> bool {
        !self.outputs.is_empty()
    }

    fn serves(&self) -> Vec<ChannelId> {
        self.outputs.iter().map(|output| output.channel).collect()
    }

    fn describe(&self, table: &ChannelTable, _limits: DeviceLimits, channels: &mut [Channel]) {
        super::describe(table, self, channels);
    }

    fn probe(&self, table: &ChannelTable, look: &mut Look) {
        for (generator, outputs) in self.used() {
            match super::look(generator, &outputs) {
                Ok(words) => {
                    let words =
                        outputs.iter().zip(words).map(|(output, words)| (output.channel, Some(words)));
                    look.inputs.extend(words);
                }
                Err(refusal) => {
                    look.inputs.extend(outputs.iter().map(|output| (output.channel, None)));
                    look.found.push(refusal.finding(&table.file, generator.place.clone()));
                }
            }
        }
    }

    fn occupies(&self) -> Vec<Used> {
        let device = |(generator, outputs): (&GeneratorSpec, Vec<OutputSpec>)| match &generator.kind {
            GeneratorKind::Stream(stream) => Used::behind(&stream.path),
            GeneratorKind::Pwm(pwm) => super::find(Path::new("/"), pwm).ok().map(|chip| Used {
                device: chip.name,
                lines: Some(outputs.iter().map(|output| u32::from(output.output)).collect()),
            }),
        };
        self.used().filter_map(device).collect()
    }

    fn open(
        &self,
        table: &ChannelTable,
        limits: DeviceLimits,
        context: &BoardContext,
    ) -> Result<Box<dyn Board>, Vec<Diagnostic>> {
        Ok(Box::new(GeneratorBoard::open(table, self, limits, context)?))
    }

    fn with_channels(&self, number: &dyn Fn(ChannelId) -> Option<ChannelId>) -> Arc<dyn DeviceSpec> {
        let output =
            |output: &OutputSpec| Some(OutputSpec { channel: number(output.channel)?, ..output.clone() });
        let outputs = self.outputs.iter().filter_map(output).collect();
        Arc::new(GeneratorsSpec { generators: self.generators.clone(), outputs })
    }
}
