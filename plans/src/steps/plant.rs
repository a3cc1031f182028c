//! `set-plant`: a parameter of a plant of the board.

use document::{Findings, KeySpec, KeyType, Node};

use super::drive::above_zero;
use super::{StepNames, table_fields};
use super::{StepVerb, Stimulus};
use crate::lang::Literal;

const KEYS: &[KeySpec] = &[
    KeySpec::required("plant", KeyType::Text, "Name of the plant."),
    KeySpec::required("parameter", KeyType::Text, "Name of its parameter."),
    KeySpec::required("value", KeyType::Value, "What it is from then on."),
    KeySpec::optional(
        "duration",
        KeyType::Duration,
        "How long; then it is what it was before. Until another step sets it if left out.",
    ),
];

pub(super) const SET_PLANT: StepVerb = StepVerb {
    name: "set-plant",
    doc: "Sets a parameter of a plant of the board.",
    value: KeyType::Table(KEYS),
    // A plant is the bench's: whatever controller is at it.
    needs: &[],
    read,
};

fn read(node: &Node, _: &dyn StepNames, out: &mut Findings) -> Option<Stimulus> {
    let fields = table_fields(node, KEYS)?;
    let lasts = if fields.has("duration") { Some(above_zero(&fields, "duration", out)?) } else { None };
    let value = Literal::read(fields.get("value")?, out)?;
    // Which plants and parameters there are the board knows.
    let (plant, parameter) = (fields.text("plant")?.to_owned(), fields.text("parameter")?.to_owned());
    Some(Stimulus::SetPlant { plant, parameter, value, lasts })
}
