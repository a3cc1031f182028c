//! The plans that a command line names, on disk or of those that ship: found, distinguished from other files, loaded.

pub mod find;
pub mod kind;
pub mod library;
pub mod load;
mod parameters;
pub mod project;

pub use parameters::Parameters;
