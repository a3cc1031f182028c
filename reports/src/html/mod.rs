//! One self-contained page: no network, in light and dark, and on paper.
//!
//! The page carries the record itself, packed, and a script that draws from it what is looked at
//! ([decision 19](../../../docs/decisions/0019-the-page-draws-itself.md)). What a template writes beside it, the
//! summary and every case that needs attention, is there without the script too.

mod data;
mod view;

use crate::show::clean;
use minijinja::syntax::SyntaxConfig;
use minijinja::value::{Serde, Value, ValueKind};
use minijinja::{AutoEscape, Environment, context, escape_formatter};
use record::RunRecord;
use sha2::{Digest, Sha256};
use thiserror::Error;

/// Why no page was made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum HtmlError {
    /// R0410: the template that ships in the binary failed at this line: a fault of rig itself.
    #[error("the page's template failed at line {line}; please report this")]
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

/// The script, in the order in which its parts need each other.
const SCRIPT: [&str; 15] = [
    include_str!("script/element.js"),
    include_str!("script/figure.js"),
    include_str!("script/data.js"),
    include_str!("script/axis.js"),
    include_str!("script/lanes.js"),
    include_str!("script/marks.js"),
    include_str!("script/cursors.js"),
    include_str!("script/scope.js"),
    include_str!("script/hands.js"),
    include_str!("script/case.js"),
    include_str!("script/cases.js"),
    include_str!("script/overview.js"),
    include_str!("script/requirements.js"),
    include_str!("script/repeats.js"),
    include_str!("script/start.js"),
];

const STYLE: &str = concat!(include_str!("style/page.css"), include_str!("style/diagram.css"));

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
    // Every text of the record is cleaned of control characters on its way out; only what this crate made itself is
    // marked as safe and passes as it is.
    env.set_formatter(|out, state, value| {
        if value.kind() == ValueKind::String && !value.is_safe() {
            let text = value.as_str().unwrap_or_default();
            return escape_formatter(out, state, &Value::from(clean(text).into_owned()));
        }
        escape_formatter(out, state, value)
    });
    env.add_template("page.html", include_str!("page.html")).map_err(fault)?;
    let page = env.get_template("page.html").map_err(fault)?;
    let script = format!("\"use strict\";\n(() => {{\n{}}})();\n", SCRIPT.concat());
    let own = |text: &str| Value::from_safe_string(text.to_owned());
    page.render(context! {
        page => Serde(view::HtmlPage::of(run)),
        // No other style and no other script is obeyed, whatever a name in the record holds.
        style_hash => own(&hash(STYLE)),
        script_hash => own(&hash(&script)),
        style => own(STYLE),
        script => own(&script),
        data => own(&data::packed(run)),
    })
    .map_err(fault)
}

/// What a content security policy calls a text: `sha256-` and the digest in base64.
fn hash(text: &str) -> String {
    format!("sha256-{}", data::base64(&Sha256::digest(text.as_bytes())))
}
