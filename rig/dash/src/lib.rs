//! The terminal dashboard: what the engineer looks at beside the machine. It knows the control socket and nothing else.

mod canvas;
mod codes;
mod editor;
pub mod frame_decoder;
pub mod glyphs;
mod input_value;
mod link;
pub mod model;
pub mod recording;
mod run;
mod shell;
mod show;
mod terminal;
pub mod views;

pub use codes::CODES;
pub use run::{DashboardSettings, run};
pub use shell::{LoopCommand, RigMessage, Shell};
