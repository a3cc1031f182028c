//! Values as they are typed: `TRUE`, `42`, `16#FF`, `T#500ms`, `500 mV`, `RUNNING`. They are those of plans.

use super::CtlError;
use crate::exit::ExitStatus;
use crate::output;
use control::{ControlClient, Description, RequestOperation, SignalKind, SignalValues, WireValue};
use document::Diagnostic;
use plans::Literal;
use signal::{SignalInfo, Value, ValueKind};

/// Why words give no value.
pub fn refuse(words: &str, why: &str, help: &str) -> CtlError {
    let found = Diagnostic::error("R0649", format!("`{words}` is not a valid value: {why}"));
    output::findings(&[found.help(help)], &[]);
    CtlError::Exit(ExitStatus::UserFiles)
}

/// Reads `NAME=VALUE`.
pub fn pair(client: &mut ControlClient, words: &str) -> Result<(String, WireValue), CtlError> {
    match words.split_once('=') {
        Some((name, text)) if !name.trim().is_empty() => {
            Ok((name.trim().to_owned(), of(client, name.trim(), words, text)?))
        }
        _ => Err(refuse(words, "it is not a name with a value", "write NAME=VALUE, as in %QX0.3=1")),
    }
}

/// Reads `NAME=VALUE` of what is forced: levels, and the counts of analogue channels, which have no unit.
pub fn forced(client: &mut ControlClient, words: &str) -> Result<(String, WireValue), CtlError> {
    let literal = words.split_once('=').and_then(|(_, text)| Literal::parse(text).ok());
    let has_unit = |literal: Literal| literal.quantity().is_some_and(|quantity| !quantity.unit.is_none());
    if literal.is_some_and(has_unit) {
        let help =
            "force an analogue channel to its counts, a whole number; `rig modules` says what they stand for";
        return Err(refuse(words, "what is forced is an image, which has no unit", help));
    }
    pair(client, words)
}

/// Reads the value of a name. The rig is asked for what it means only where units and labels matter.
pub fn of(client: &mut ControlClient, name: &str, words: &str, text: &str) -> Result<WireValue, CtlError> {
    let help = "write a number, TRUE, 16#0010, T#500ms, a quantity such as '24 V', the name of a state, or Z";
    let literal = Literal::parse(text).map_err(|why| refuse(words, &why.to_string(), help))?;
    if let Some(value) = literal.value() {
        return Ok(WireValue(value));
    }
    if matches!(&literal, Literal::Label(label) if label.eq_ignore_ascii_case("z")) {
        return Ok(WireValue(Value::HighZ));
    }
    let info = info(client, name)?;
    plans::value_of(&literal, &info).map(WireValue).map_err(|why| refuse(words, &why, help))
}

/// What is known of a name; the rig itself refuses one that it does not know.
fn info(client: &mut ControlClient, name: &str) -> Result<SignalInfo, CtlError> {
    let described: Description = client.ask(RequestOperation::Describe)?;
    let Some(signal) = described.named(name) else {
        client.ask::<SignalValues>(RequestOperation::Read { names: vec![name.to_owned()] })?;
        return Ok(SignalInfo::exact(name, ValueKind::Int));
    };
    let mut info = SignalInfo::exact(name, kind(signal.kind));
    info.unit.clone_from(&signal.unit);
    info.labels.clone_from(&signal.labels);
    Ok(info)
}

const fn kind(kind: SignalKind) -> ValueKind {
    match kind {
        SignalKind::Bool => ValueKind::Bool,
        SignalKind::Int => ValueKind::Int,
        SignalKind::Word => ValueKind::Word,
        SignalKind::Real => ValueKind::Real,
        SignalKind::State => ValueKind::State,
    }
}
