//! A valve with a drive: opened and closed by coils, or sent to a position.

use std::sync::Arc;

use document::{KeySpec, KeyType};
use signal::Random;

use super::travel::{self, TravelSpec};
use super::{PlantKind, PlantReader, reader};
use crate::circuit::{CircuitFault, Plant, PlantParameter, PlantPort, PlantSpec};

pub(super) const KIND: PlantKind = PlantKind {
    name: "valve",
    keys: &[
        reader::INPUT,
        KeySpec::optional(
            "close",
            KeyType::Text,
            "The digital channel that closes it; without one it closes by itself",
        ),
        KeySpec::required("travel", KeyType::Duration, "How long it takes from end to end"),
        reader::INITIAL,
        reader::VALUE,
        reader::SAMPLE_OF_VALUE,
        travel::REACH,
        KeySpec::optional("opened", KeyType::Text, "The digital channel of the switch at its open end"),
        KeySpec::optional("closed", KeyType::Text, "The digital channel of the switch at its closed end"),
    ],
    read,
};

const TIMES: [&str; 2] = ["travel"; 2];

#[derive(Clone, Debug)]
struct ValveSpec {
    name: String,
    travel: TravelSpec,
}

fn read(reader: &mut PlantReader<'_, '_>) -> Option<Arc<dyn PlantSpec>> {
    let travel = travel::read(reader, "close", TIMES, ["opened", "closed"], true)?;
    Some(Arc::new(ValveSpec { name: reader.name(), travel }))
}

impl PlantSpec for ValveSpec {
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
