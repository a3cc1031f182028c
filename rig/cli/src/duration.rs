//! Durations of arguments.

use signal::Span;

/// A duration of an argument.
pub fn above_zero(text: &str) -> Result<Span, String> {
    let span = Span::parse(text).map_err(|error| error.to_string())?;
    if span > Span::ZERO { Ok(span) } else { Err("the time must be above 0".to_owned()) }
}
