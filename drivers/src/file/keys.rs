//! The tables of keys of a board file.

use document::{KeySpec, KeyType};

const NAME: KeyType = KeyType::Text;

/// The keys of a board file.
pub const KEYS: &[KeySpec] = &[
    KeySpec::required("format", KeyType::Integer(1, i64::MAX), "Version of the format: 1"),
    KeySpec::optional("title", KeyType::Text, "What the board is, in a line"),
    KeySpec::optional("subject", KeyType::Table(SUBJECT), "The controller under test"),
    KeySpec::optional("board", KeyType::Table(BOARD), "The board itself"),
    KeySpec::optional(
        "channels",
        KeyType::Map(&KeyType::Table(CHANNEL)),
        "Channels beyond those of the terminals",
    ),
    KeySpec::optional("bind", KeyType::Map(&NAME), "Terminals of the controller and their channels"),
    KeySpec::optional("wires", KeyType::List(&KeyType::Table(WIRE)), "Wires between channels"),
    KeySpec::optional("plants", KeyType::List(&KeyType::Table(PLANT)), "Processes between channels"),
    KeySpec::optional("faults", KeyType::Table(FAULTS), "Trouble that the board makes by itself"),
    KeySpec::optional(
        "invariants",
        KeyType::List(&KeyType::Any),
        "What is claimed of every case that runs on the board, as in a plan",
    ),
    KeySpec::optional("alarms", KeyType::List(&KeyType::Any), "What ends a case when it lasts, as in a plan"),
];

pub(super) const SUBJECT: &[KeySpec] = &[
    KeySpec::optional("kind", KeyType::Text, "\"model\": the rig's own controller"),
    KeySpec::optional("profile", KeyType::Text, "Profile of the controller, as in \"m241-2019\""),
    KeySpec::optional("reference", KeyType::Text, "Its reference, as in \"TM241CEC24T\""),
];

pub(super) const BOARD: &[KeySpec] =
    &[KeySpec::required("kind", KeyType::Text, "\"simulated\": modelled lines in virtual time")];

pub(super) const CHANNEL: &[KeySpec] = &[
    KeySpec::required(
        "kind",
        KeyType::Choice(&["digital", "analog"]),
        "What it carries: a level or a quantity",
    ),
    KeySpec::optional("unit", KeyType::Text, "Unit of an analog channel"),
    KeySpec::optional("drives", KeyType::Bool, "Whether the rig can drive it; true if left out"),
    KeySpec::optional("senses", KeyType::Bool, "Whether the rig can see it; true if left out"),
    KeySpec::optional("safe", KeyType::Value, "What it is driven to when safe; left undriven if left out"),
    KeySpec::optional(
        "pull",
        KeyType::Choice(&["none", "up", "down"]),
        "What an undriven digital channel reads: \"none\" for high impedance; \"down\" if left out",
    ),
];

pub(super) const WIRE: &[KeySpec] = &[
    KeySpec::required("from", NAME, "The channel that it listens to"),
    KeySpec::required("to", NAME, "The channel that it drives"),
    KeySpec::optional("delay", KeyType::Duration, "How much later each change arrives"),
    KeySpec::optional("invert", KeyType::Bool, "Whether it drives the opposite level"),
    KeySpec::optional("bounce", KeyType::Table(BOUNCE), "Further edges behind each change"),
];

pub(super) const BOUNCE: &[KeySpec] = &[
    KeySpec::required("edges", KeyType::Integer(0, 1_000_000), "Number of further edges, even"),
    KeySpec::required("over", KeyType::Duration, "Time within which they come"),
    KeySpec::optional(
        "spacing",
        KeyType::Choice(&["random", "even"]),
        "\"random\" (from the seed, if left out) or \"even\"",
    ),
];

pub(super) const PLANT: &[KeySpec] = &[
    KeySpec::required("kind", KeyType::Choice(&["lag"]), "\"lag\": first-order lag"),
    KeySpec::required("name", KeyType::Text, "Its name"),
    KeySpec::required("input", NAME, "The channel that drives it"),
    KeySpec::required("output", NAME, "The analog channel that carries its value"),
    KeySpec::optional("low", KeyType::Quantity, "Where it goes while a digital input is 0"),
    KeySpec::optional("high", KeyType::Quantity, "Where it goes while a digital input is 1"),
    KeySpec::optional("offset", KeyType::Quantity, "Where it goes while an analog input is 0"),
    KeySpec::optional("gain", KeyType::Number, "How much further it goes for each unit of an analog input"),
    KeySpec::optional("initial", KeyType::Quantity, "Value at the start; `low` or `offset` if left out"),
    KeySpec::required("tau", KeyType::Duration, "Time constant"),
    KeySpec::required("sample", KeyType::Duration, "Time between two samples of the output"),
    KeySpec::optional("switches", KeyType::List(&KeyType::Table(SWITCH)), "Comparators on its value"),
];

pub(super) const SWITCH: &[KeySpec] = &[
    KeySpec::required("channel", NAME, "The digital channel that it drives"),
    KeySpec::required("on-above", KeyType::Quantity, "It goes on where the value reaches this"),
    KeySpec::required("off-below", KeyType::Quantity, "It goes off where the value comes down to this"),
];

pub(super) const FAULTS: &[KeySpec] = &[
    KeySpec::optional("late", KeyType::Table(LATE), "Changes that become known late"),
    KeySpec::optional("dropped", KeyType::Table(CHANCE), "Changes that are lost"),
    KeySpec::optional("failed-calls", KeyType::Table(CHANCE), "Calls that fail"),
    KeySpec::optional("lost", KeyType::Table(LOST), "Devices that go and come back"),
];

pub(super) const CHANCE: &[KeySpec] =
    &[KeySpec::required("chance", KeyType::Number, "How often, from 0 (never) to 1 (always)")];

pub(super) const LATE: &[KeySpec] = &[
    KeySpec::required("chance", KeyType::Number, "How often, from 0 (never) to 1 (always)"),
    KeySpec::required("by", KeyType::Duration, "At most how late"),
];

pub(super) const LOST: &[KeySpec] = &[
    KeySpec::required("chance", KeyType::Number, "At how many of its changes, from 0 (none) to 1 (all)"),
    KeySpec::required("for", KeyType::Duration, "How long"),
];
