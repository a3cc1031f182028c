//! A valve with a drive: opened and closed by coils, or sent to a position.

use std::sync::Arc;

use document::{KeySpec, KeyType};

use super::{PlantKind, PlantReader, reader, travel};
use crate::circuit::PlantSpec;

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

fn read(reader: &mut PlantReader<'_, '_>) -> Option<Arc<dyn PlantSpec>> {
    travel::read(reader, "close", ["travel"; 2], ["opened", "closed"], true)
}
