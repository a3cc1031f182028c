//! `file`: what a user, the web site, FTP or the application does to a file of the controller.

use document::{Findings, KeySpec, KeyType, Node};

use super::{FileOperation, StepVerb, Stimulus};
use super::{StepNames, table_fields};
use crate::codes;

/// Most bytes of a file that a step writes: the flash memory of the controllers.
const MOST_BYTES: i64 = 128 << 20;

const KEYS: &[KeySpec] = &[
    KeySpec::optional("put", KeyType::Text, "The path of a file that is written whole."),
    KeySpec::optional("remove", KeyType::Text, "The path of a file that is removed."),
    KeySpec::optional("log", KeyType::Text, "The path of a log to which the application adds an entry."),
    KeySpec::optional("text", KeyType::Text, "What the file holds, or the entry."),
    KeySpec::optional(
        "size",
        KeyType::Integer(0, MOST_BYTES),
        "Bytes of the file or entry, in place of `text`.",
    ),
    KeySpec::optional(
        "by",
        KeyType::Choice(&["user", "application"]),
        "Who does it; a user if left out, and always the application with `log`.",
    ),
];

pub(super) const FILE: StepVerb = StepVerb {
    name: "file",
    doc: "Writes or removes a file of the controller.",
    value: KeyType::Table(KEYS),
    needs: &["files"],
    read,
};

fn read(node: &Node, _: &dyn StepNames, out: &mut Findings) -> Option<Stimulus> {
    let fields = table_fields(node, KEYS)?;
    let given: Vec<&str> = ["put", "remove", "log"].into_iter().filter(|key| fields.has(key)).collect();
    let [key] = given.as_slice() else {
        let message = "the step names none of `put`, `remove` and `log`, or several";
        out.bad(
            codes::STIMULUS,
            node,
            message,
            "as in file = { put = \"/usr/Rcp/mix.rcp\", text = \"...\" }",
        );
        return None;
    };
    let place = fields.get(key)?;
    let path = place.as_text()?.to_owned();
    if !path.starts_with('/') {
        let message = format!("`{path}` is no path of a file");
        out.bad(codes::STIMULUS, place, message, "as in \"/usr/Rcp/mix.rcp\"");
        return None;
    }
    let (text, size) = (fields.text("text"), fields.integer("size"));
    let by_application = *key == "log" || fields.text("by") == Some("application");
    let right = match *key {
        "put" => text.is_some() != size.is_some(),
        "log" => text.is_some() != size.is_some() && !fields.has("by"),
        _ => text.is_none() && size.is_none(),
    };
    if !right {
        let help =
            "`put` and `log` take `text` or `size`, `remove` takes neither, and `log` is the application's";
        out.bad(codes::STIMULUS, node, format!("these keys do not go with `{key}`"), help);
        return None;
    }
    let deed = match (*key, text, size) {
        ("put", Some(text), _) => FileOperation::Put(text.as_bytes().to_vec()),
        ("put", _, Some(size)) => FileOperation::Fill(usize::try_from(size).ok()?),
        ("log", Some(text), _) => FileOperation::Log(text.to_owned()),
        ("log", _, Some(size)) => FileOperation::Log("x".repeat(usize::try_from(size).ok()?)),
        _ => FileOperation::Remove,
    };
    Some(Stimulus::File { path, deed, by_application })
}
