//! A cylinder with end switches.

use std::sync::Arc;

use document::{KeySpec, KeyType};
use signal::Random;

use super::travel::{self, TravelSpec};
use super::{PlantKind, PlantReader, reader};
use crate::circuit::{CircuitFault, Plant, PlantParameter, PlantPort, PlantSpec};

pub(super) const KIND: PlantKind = PlantKind {
    name: "cylinder",
    keys: &[
        reader::INPUT,
        KeySpec::optional(
            "retract",
            KeyType::Text,
            "The digital channel that retracts it; without one a spring does",
        ),
        KeySpec::required("extend-time", KeyType::Duration, "How long it takes to extend from end to end"),
        KeySpec::required("retract-time", KeyType::Duration, "How long it takes to retract from end to end"),
        reader::INITIAL,
        reader::VALUE,
        reader::SAMPLE_OF_VALUE,
        travel::REACH,
        KeySpec::optional("extended", KeyType::Text, "The digital channel of the switch at its extended end"),
        KeySpec::optional(
            "retracted",
            KeyType::Text,
            "The digital channel of the switch at its retracted end",
        ),
    ],
    read,
};

const TIMES: [&str; 2] = ["extend-time", "retract-time"];

#[derive(Clone, Debug)]
struct CylinderSpec {
    name: String,
    travel: TravelSpec,
}

fn read(reader: &mut PlantReader<'_, '_>) -> Option<Arc<dyn PlantSpec>> {
    let travel = travel::read(reader, "retract", TIMES, ["extended", "retracted"], false)?;
    Some(Arc::new(CylinderSpec { name: reader.name(), travel }))
}

impl PlantSpec for CylinderSpec {
    fn name(&self) -> &str {
        &self.name
    }

    fn inputs(&self) -> Vec<PlantPort> {
        self.travel.inputs()
    }

    fn outputs(&self) -> Vec<PlantPort> {
        self.travel.outputs()
    }

    fn check(&self) -> Vec<(Option<usize>, CircuitFault)> {
        Vec::new()
    }

    fn parameters(&self) -> Vec<PlantParameter> {
        self.travel.parameters(TIMES)
    }

    fn build(&self, _random: Random) -> Box<dyn Plant> {
        self.travel.build()
    }
}
