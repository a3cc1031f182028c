//! Reports drawn from the record of a run: terminal text, JUnit, CTRF, Markdown, CSV, one HTML page, and VCD from a
//! trace.
//!
//! Goals: the same facts in every form, each readable by the tool it is meant for; whatever a name or
//! message holds is shown and never interpreted (no markup, no terminal sequences). Not goals: judging,
//! reading traces for anything but VCD, writing files.

mod brief;
mod coverage;
pub mod csv;
pub mod ctrf;
pub mod diff;
pub mod html;
pub mod junit;
pub mod markdown;
mod matrix;
mod show;
pub mod text;
pub mod vcd;

pub use matrix::{RequirementRow, requirements};
pub use show::unguarded_words;
