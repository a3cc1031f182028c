//! A line becomes a request.

use control::{REQUEST_FIELDS, Request, RequestFault, RequestOperation, TOPIC_FIELDS};
use document::suggest;
use serde_json::{Map, Value};

use crate::codes;

/// A line that is no request: the number that it has, if one can be read, and what is wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BadRequest {
    /// The number.
    pub id: Option<u64>,
    /// What is wrong.
    pub fault: RequestFault,
}

/// Reads a line of a client.
///
/// # Errors
/// [`BadRequest`] with the place where it stops to be JSON, or the word that is not known and the one that may be meant.
pub fn decode(line: &[u8]) -> Result<Request, BadRequest> {
    let nameless = |fault| BadRequest { id: None, fault };
    let text = std::str::from_utf8(line).map_err(|error| {
        let message = format!("the line is not UTF-8 from byte {} on", error.valid_up_to() + 1);
        nameless(fault(codes::JSON, message, "write text in UTF-8"))
    })?;
    if text.trim().is_empty() {
        return Err(nameless(fault(codes::JSON, "the line is empty".into(), EXAMPLE)));
    }
    let value: Value = serde_json::from_str(text).map_err(|error| {
        // serde_json names the line, too, but there is only this one.
        let said = error.to_string();
        let what = said.split(" at line ").next().unwrap_or_default();
        let message = format!("the line is not JSON at byte {}: {what}", error.column());
        nameless(fault(codes::JSON, message, EXAMPLE))
    })?;
    let Value::Object(mut fields) = value else {
        return Err(nameless(fault(codes::REQUEST, "a request is an object".into(), EXAMPLE)));
    };
    let number = fields.remove("id");
    let id = number.as_ref().and_then(Value::as_u64);
    let refuse = |fault| BadRequest { id, fault };
    let Some(number) = id else {
        let message = match number {
            None => "the request has no `id`",
            Some(_) => "the `id` of a request is a whole number from 0",
        };
        return Err(refuse(fault(codes::REQUEST, message.into(), EXAMPLE)));
    };
    known(&fields, "do", REQUEST_FIELDS).map_err(refuse)?;
    if let Some(Value::Object(topic)) = fields.get("topic") {
        known(topic, "of", TOPIC_FIELDS).map_err(refuse)?;
    }
    let kind = fields.get("do").and_then(Value::as_str).unwrap_or_default().to_string();
    let ask = serde_json::from_value::<RequestOperation>(Value::Object(fields)).map_err(|error| {
        let message = format!("`{kind}` cannot be read: {}", short(&error.to_string()));
        refuse(fault(codes::REQUEST, message, &help(&kind)))
    })?;
    Ok(Request { id: number, ask })
}

/// What a request looks like.
const EXAMPLE: &str = "a line is as in {\"id\": 1, \"do\": \"status\"}";

/// Whether an object has a kind that is known, and no field that is not.
fn known(fields: &Map<String, Value>, tag: &str, kinds: &[(&str, &[&str])]) -> Result<(), RequestFault> {
    let Some(kind) = fields.get(tag) else {
        return Err(fault(codes::REQUEST, format!("`{tag}` is missing"), EXAMPLE));
    };
    let Some(kind) = kind.as_str() else {
        return Err(fault(codes::REQUEST, format!("`{tag}` is a text"), EXAMPLE));
    };
    let Some((_, allowed)) = kinds.iter().find(|(name, _)| *name == kind) else {
        let message = format!("`{tag}` cannot be \"{}\"", short(kind));
        let all: Vec<&str> = kinds.iter().map(|(name, _)| *name).collect();
        return Err(fault(codes::UNKNOWN, message, &meant(kind, &all)));
    };
    match fields.keys().find(|&key| key != tag && !allowed.contains(&key.as_str())) {
        None => Ok(()),
        Some(key) => {
            let message = format!("\"{kind}\" has no `{}`", short(key));
            Err(fault(codes::REQUEST, message, &meant(key, allowed)))
        }
    }
}

/// The word that may be meant, else all.
fn meant(word: &str, all: &[&str]) -> String {
    match suggest(word, all.iter().copied()) {
        Some(near) => format!("did you mean `{near}`?"),
        None if all.is_empty() => "it has no further fields".into(),
        None => format!("there is {}", all.join(", ")),
    }
}

/// The fields of a kind of request.
fn help(kind: &str) -> String {
    let fields = REQUEST_FIELDS.iter().find(|(name, _)| *name == kind).map_or(&[][..], |(_, fields)| fields);
    format!("it has {}", fields.iter().map(|field| format!("`{field}`")).collect::<Vec<_>>().join(" and "))
}

/// A fault.
pub(super) fn fault(code: &str, message: String, help: &str) -> RequestFault {
    RequestFault { code: code.into(), message, help: help.into() }
}

/// The longest piece of a client's text that is reported again, characters.
const LONGEST_QUOTE: usize = 120;

/// A text of a client as it may stand in a message or in the log: on one line, and not long.
pub(super) fn short(text: &str) -> String {
    let mut shown: String =
        text.chars().take(LONGEST_QUOTE).map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect();
    if text.chars().nth(LONGEST_QUOTE).is_some() {
        shown.push_str("...");
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;
    use control::{ControllerAction, Forces, Topic, WireValue};
    use proptest::prelude::*;

    fn refused(line: &str) -> (Option<u64>, String, String) {
        let BadRequest { id, fault } = decode(line.as_bytes()).expect_err(line);
        (id, format!("{} {}", fault.code, fault.message), fault.help)
    }

    #[test]
    fn what_is_wrong_is_named_with_its_place_or_the_word_that_is_meant() {
        let example = EXAMPLE.to_string();
        for (line, id, said, help) in [
            (
                r#"{"id": 1, "do" "status"}"#,
                None,
                "R0621 the line is not JSON at byte 16: expected `:`",
                &*example,
            ),
            ("[1]", None, "R0622 a request is an object", &example),
            (r#"{"do": "status"}"#, None, "R0622 the request has no `id`", &example),
            (
                r#"{"id": -1, "do": "status"}"#,
                None,
                "R0622 the `id` of a request is a whole number from 0",
                &example,
            ),
            (r#"{"id": 2}"#, Some(2), "R0622 `do` is missing", &example),
            (
                r#"{"id": 3, "do": "stauts"}"#,
                Some(3),
                "R0623 `do` cannot be \"stauts\"",
                "did you mean `status`?",
            ),
            (
                r#"{"id": 4, "do": "force", "nam": "Q0", "value": 1}"#,
                Some(4),
                "R0622 \"force\" has no `nam`",
                "did you mean `name`?",
            ),
            (
                r#"{"id": 5, "do": "status", "now": true}"#,
                Some(5),
                "R0622 \"status\" has no `now`",
                "it has no further fields",
            ),
            (
                r#"{"id": 6, "do": "subscribe", "topic": {"of": "signal"}}"#,
                Some(6),
                "R0623 `of` cannot be \"signal\"",
                "did you mean `signals`?",
            ),
            (
                r#"{"id": 7, "do": "force", "name": "Q0"}"#,
                Some(7),
                "R0622 `force` cannot be read: missing field `value`",
                "it has `name` and `value`",
            ),
        ] {
            assert_eq!(refused(line), (id, said.to_string(), help.to_string()), "{line}");
        }
        let bad = decode(b"{\"id\": 1, \xff").expect_err("bytes");
        assert_eq!(bad.fault.message, "the line is not UTF-8 from byte 11 on");
        let deep = "[".repeat(10_000);
        assert!(refused(&deep).1.starts_with("R0621 "));
    }

    /// One request of each kind.
    fn asks() -> Vec<RequestOperation> {
        let name = || "a".to_string();
        let value = WireValue(signal::Value::Bool(true));
        vec![
            RequestOperation::Hello { protocol: 1, name: name() },
            RequestOperation::Describe,
            RequestOperation::Status,
            RequestOperation::Read { names: vec![name()] },
            RequestOperation::Write { name: name(), value },
            RequestOperation::Force { name: name(), value },
            RequestOperation::Release { name: name() },
            RequestOperation::ReleaseAll,
            RequestOperation::Command { action: ControllerAction::ResetWarm },
            RequestOperation::Subscribe {
                topic: Topic::Signals { names: vec![name()], every_ms: 5, all: true },
            },
            RequestOperation::Unsubscribe { subscription: 1 },
            RequestOperation::Plans { path: None },
            RequestOperation::Plan { name: name() },
            RequestOperation::Abort,
            RequestOperation::Lock { note: name() },
            RequestOperation::Unlock,
            RequestOperation::Leave { forces: Forces::Keep },
            RequestOperation::Advance { by: 1 },
        ]
    }

    #[test]
    fn the_list_of_fields_is_that_of_the_messages() {
        let mut listed = Vec::new();
        for (id, ask) in asks().into_iter().enumerate() {
            let request = Request { id: id as u64, ask };
            let line = serde_json::to_string(&request).expect("a line");
            assert_eq!(decode(line.as_bytes()).as_ref(), Ok(&request), "{line}");
            let Ok(Value::Object(fields)) = serde_json::from_str(&line) else { panic!("{line}") };
            let kind = fields["do"].as_str().expect("a text").to_string();
            listed.push((kind, fields.keys().filter(|key| *key != "id" && *key != "do").count()));
        }
        let known: Vec<_> =
            REQUEST_FIELDS.iter().map(|(kind, fields)| (kind.to_string(), fields.len())).collect();
        assert_eq!(listed, known);
        let topics = [
            Topic::Signals { names: vec![], every_ms: 1, all: false },
            Topic::Status { every_ms: 1 },
            Topic::Log,
            Topic::Frames,
            Topic::Plan,
        ];
        for (topic, (kind, fields)) in topics.iter().zip(TOPIC_FIELDS) {
            let Ok(Value::Object(written)) = serde_json::to_value(topic) else { panic!("{topic:?}") };
            assert_eq!(written["of"], *kind);
            assert!(fields.iter().all(|field| written.contains_key(*field)), "{topic:?}");
            assert_eq!(written.len(), fields.len() + 1);
        }
    }

    proptest! {
        #[test]
        fn no_bytes_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let _ = decode(&bytes);
        }

        #[test]
        fn no_json_panics(kind in "[a-z-]{0,12}", field in "[a-z_]{0,9}", value in "\\PC{0,20}") {
            let line = serde_json::json!({"id": 1, "do": kind, field: value}).to_string();
            if let Err(refused) = decode(line.as_bytes()) {
                prop_assert!(!refused.fault.message.is_empty() && !refused.fault.help.is_empty());
            }
        }
    }
}
