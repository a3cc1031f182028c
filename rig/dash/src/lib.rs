//! The terminal dashboard: what the engineer looks at beside the machine. It knows the control socket and nothing else.

mod codes;
mod editor;
pub mod glyphs;
mod link;
pub mod meaning;
pub mod model;
mod page;
pub mod recording;
mod run;
mod shell;
mod show;
mod terminal;
mod typed;
pub mod views;

pub use codes::CODES;
pub use run::{Setting, run};
pub use shell::{Heard, Shell, Want};
