//! Generators of pulses.

use std::path::Path;

use document::Diagnostic;

use super::DeviceDriver;
use crate::board::Board;
use crate::channel::{Channel, ChannelId};
use crate::channel_table::ChannelTable;
use crate::context::BoardContext;
use crate::generator::{self, GeneratorBoard, GeneratorKind, GeneratorSpec, OutputSpec};
use crate::real::{Look, RealSpec, Used};

pub(super) struct Generators;

/// The generators of a board with their outputs. One that no channel uses may be missing: it is left alone.
fn used(spec: &RealSpec) -> impl Iterator<Item = (&GeneratorSpec, Vec<OutputSpec>)> {
    let all = spec.generators.generators.iter().enumerate();
    all.map(|(at, generator)| (generator, spec.generators.outputs_of(at)))
        .filter(|(_, outputs)| !outputs.is_empty())
}

impl DeviceDriver for Generators {
    fn is_used(&self, spec: &RealSpec) -> bool {
        !spec.generators.outputs.is_empty()
    }

    fn serves(&self, spec: &RealSpec) -> Vec<ChannelId> {
        spec.generators.outputs.iter().map(|output| output.channel).collect()
    }

    fn describe(&self, table: &ChannelTable, spec: &RealSpec, channels: &mut [Channel]) {
        generator::describe(table, &spec.generators, channels);
    }

    fn probe(&self, table: &ChannelTable, spec: &RealSpec, look: &mut Look) {
        for (generator, outputs) in used(spec) {
            match generator::look(generator, &outputs) {
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

    fn occupies(&self, spec: &RealSpec) -> Vec<Used> {
        let device = |(generator, outputs): (&GeneratorSpec, Vec<OutputSpec>)| match &generator.kind {
            GeneratorKind::Stream(stream) => Used::behind(&stream.path),
            GeneratorKind::Pwm(pwm) => generator::find(Path::new("/"), pwm).ok().map(|chip| Used {
                device: chip.name,
                lines: Some(outputs.iter().map(|output| u32::from(output.output)).collect()),
            }),
        };
        used(spec).filter_map(device).collect()
    }

    fn open(
        &self,
        table: &ChannelTable,
        spec: &RealSpec,
        context: &BoardContext,
    ) -> Result<Box<dyn Board>, Vec<Diagnostic>> {
        Ok(Box::new(GeneratorBoard::open(table, &spec.generators, spec.limits, context)?))
    }
}
