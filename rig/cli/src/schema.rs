//! `rig schema`: what editors complete and check by.

use crate::exit::ExitStatus;
use crate::output;
use clap::{Args, ValueEnum};
use document::schema::{Grammar, schema};
use drivers::file::KEYS as BOARD_KEYS;
use runtime::suite::instrument_file::KEYS as INSTRUMENT_KEYS;
use serde_json::Value as Json;

/// `rig schema`.
#[derive(Debug, Args)]
pub struct SchemaArgs {
    /// The kind of file.
    #[arg(value_enum, value_name = "FORMAT")]
    of: SchemaFormat,
}

/// The formats that have a schema.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SchemaFormat {
    /// A plan.
    Plan,
    /// A board file.
    Board,
    /// A suite file: what holds in every case of the plans below it.
    Suite,
    /// A file that plans include.
    Included,
    /// An instrument file: what the instrument of a capture may be off.
    Instrument,
}

/// Prints a schema.
pub fn run(args: &SchemaArgs) -> ExitStatus {
    output::print(&text(args.of));
    ExitStatus::Passed
}

/// The schema of a format as the text of a file.
pub fn text(of: SchemaFormat) -> String {
    format!("{}\n", serde_json::to_string_pretty(&json(of)).unwrap_or_default())
}

fn json(of: SchemaFormat) -> Json {
    match of {
        SchemaFormat::Plan => plans::schema::plan(),
        SchemaFormat::Suite => plans::schema::suite(),
        SchemaFormat::Included => plans::schema::included(),
        SchemaFormat::Instrument => {
            let about = "What the clock and the channels of an instrument that records captures may be off.";
            schema("Scanrig instrument file", about, INSTRUMENT_KEYS, &Grammar::default())
        }
        SchemaFormat::Board => plans::schema::board(BOARD_KEYS),
    }
}
