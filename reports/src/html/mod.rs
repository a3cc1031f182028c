//! One self-contained page: no network, readable without scripts, in light and dark, and on paper.

mod view;

use crate::show::clean;
use minijinja::syntax::SyntaxConfig;
use minijinja::value::{Serde, Value, ValueKind};
use minijinja::{AutoEscape, Environment, escape_formatter};
use record::RunRecord;
use std::fmt;

/// Why no page was made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HtmlError {
    /// R0410: the template that ships in the binary failed at this line: a fault of rig itself.
    Template {
        /// Line of the template, from 1; 0 when unknown.
        line: usize,
    },
}

impl HtmlError {
    /// The code that has a page.
    pub const fn code(self) -> &'static str {
        match self {
            HtmlError::Template { .. } => "R0410",
        }
    }
}

impl fmt::Display for HtmlError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            HtmlError::Template { line } => {
                write!(f, "the page's template failed at line {line}; please report this")
            }
        }
    }
}

impl std::error::Error for HtmlError {}

/// The run as an HTML page.
///
/// # Errors
/// [`HtmlError::Template`] for a fault of the built-in template; no record causes it.
pub fn render(run: &RunRecord) -> Result<String, HtmlError> {
    let fault = |error: minijinja::Error| HtmlError::Template { line: error.line().unwrap_or(0) };
    let mut env = Environment::new();
    env.set_auto_escape_callback(|_| AutoEscape::Html);
    let syntax = SyntaxConfig::builder().trim_blocks(true).lstrip_blocks(true).build();
    env.set_syntax(syntax.map_err(fault)?);
    // Every text of the record is cleaned of control characters on its way out; only markup that this crate
    // made itself is marked as safe and passes as it is.
    env.set_formatter(|out, state, value| {
        if value.kind() == ValueKind::String && !value.is_safe() {
            let text = value.as_str().unwrap_or_default();
            return escape_formatter(out, state, &Value::from(clean(text).into_owned()));
        }
        escape_formatter(out, state, value)
    });
    env.add_template("page.html", include_str!("page.html")).map_err(fault)?;
    env.add_template("case.html", include_str!("case.html")).map_err(fault)?;
    let page = env.get_template("page.html").map_err(fault)?;
    page.render(Serde(view::Page::of(run))).map_err(fault)
}
