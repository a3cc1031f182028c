//! A cylinder with end switches.

use std::sync::Arc;

use document::{KeySpec, KeyType};

use super::{PlantKind, PlantReader, reader, travel};
use crate::circuit::PlantSpec;

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

fn read(reader: &mut PlantReader<'_, '_>) -> Option<Arc<dyn PlantSpec>> {
    travel::read(reader, "retract", ["extend-time", "retract-time"], ["extended", "retracted"], false)
}
