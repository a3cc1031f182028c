//! The user's text files: diagnostics with a code and a place, TOML whose every value knows its place, and
//! the tables of keys that the readers and the schemas are made from.
//!
//! The way through: [`toml::parse`] makes a tree of [`Node`]s, [`Fields::check`] holds a table of it against a
//! list of [`KeySpec`]s and gives typed access, [`Findings`] collects what is wrong, [`render`] shows it.
//!
//! Goals: several findings in one run, every finding with the exact place and the fix, bounded memory for any
//! input; no file of the user is read without a limit ([`mod@file`]). Not goals: writing files.

mod diagnostic;
mod fields;
pub mod file;
mod findings;
mod joined;
pub mod keys;
mod patterns;
mod place;
mod render;
pub mod schema;
mod strict;
mod suggest;
pub mod toml;
mod tree;

pub use diagnostic::{Diagnostic, DiagnosticLabel, Severity, SourceFile};
pub use fields::{Fields, check_value};
pub use findings::{Codes, Findings, MAX_FINDINGS};
pub use joined::Joined;
pub use keys::{KeySpec, KeyType};
pub use patterns::DURATION;
pub use place::line_col;
pub use render::render;
pub use suggest::{distance, suggest};
pub use tree::{Data, Entry, Node, Table, ValueOrigin};

/// Declares a register of codes: a constant for each, visible in the crate, and the public list `CODES` of all with
/// their titles, in order.
///
/// ```
/// mod codes {
///     scanrig_document::codes! {
///         /// Every code with its title.
///         SYNTAX = "X0001", "The file is not TOML";
///         KEY = "X0002", "An unknown key";
///     }
/// }
/// assert_eq!((codes::KEY, codes::CODES[0].0), ("X0002", "X0001"));
/// ```
#[macro_export]
macro_rules! codes {
    ($(#[$of:meta])* $($name:ident = $code:literal, $title:literal;)*) => {
        $(#[doc = $title] pub(crate) const $name: &str = $code;)*

        $(#[$of])*
        pub const CODES: &[(&str, &str)] = &[$(($code, $title),)*];
    };
}
