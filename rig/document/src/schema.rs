//! JSON Schema of a format, made from its tables of keys: editors complete and check by it what the readers read.
//!
//! Draft 7, with `definitions`: what editors of TOML understand. A schema never refuses what the reader takes; what
//! depends on other keys or on other files only the reader refuses.

use serde_json::{Map, Value as Json, json};

use crate::patterns::{DURATION, QUANTITY, RANGE, REFERENCE, whole};
use crate::{KeySpec, KeyType};

/// What a format adds to its tables of keys.
#[derive(Clone, Debug, Default)]
pub struct Grammar {
    /// Whether a text with a `$name` may stand in place of any value.
    pub references: bool,
    /// The pattern of an instant, without anchors at its ends.
    pub instant: String,
    /// The keys of a table that names a signal.
    pub signal: &'static [KeySpec],
    /// The tables whose entries have a verb beside their own keys.
    pub verbs: Vec<Verbs>,
}

/// A table that has one verb among its keys.
#[derive(Clone, Debug)]
pub struct Verbs {
    /// The name of its definition.
    pub name: &'static str,
    /// The keys besides the verb: what the table is known by.
    pub own: &'static [KeySpec],
    /// The verbs, each with the type of its value.
    pub verbs: Vec<KeySpec>,
    /// The own key that makes a verb unnecessary.
    pub alone: Option<&'static str>,
}

/// The schema of a document with these keys.
pub fn schema(title: &str, description: &str, keys: &[KeySpec], grammar: &Grammar) -> Json {
    let mut root = table(keys, grammar);
    root.insert("$schema".into(), json!("http://json-schema.org/draft-07/schema#"));
    root.insert("title".into(), json!(title));
    root.insert("description".into(), json!(description));
    let required: Vec<&str> = keys.iter().filter(|key| key.required).map(|key| key.name).collect();
    root.insert("x-taplo".into(), json!({ "initKeys": required }));
    let mut definitions = Map::new();
    if !grammar.signal.is_empty() {
        definitions.insert("signal".into(), Json::Object(table(grammar.signal, grammar)));
    }
    for verbs in &grammar.verbs {
        definitions.insert(verbs.name.into(), with_verb(verbs, grammar));
    }
    if !definitions.is_empty() {
        root.insert("definitions".into(), Json::Object(definitions));
    }
    Json::Object(root)
}

/// A table with these keys and no others.
fn table(keys: &[KeySpec], grammar: &Grammar) -> Map<String, Json> {
    let mut object = Map::new();
    object.insert("type".into(), json!("object"));
    let properties: Map<String, Json> = keys.iter().map(|key| property(key, grammar)).collect();
    object.insert("properties".into(), Json::Object(properties));
    let required: Vec<&str> = keys.iter().filter(|key| key.required).map(|key| key.name).collect();
    if !required.is_empty() {
        object.insert("required".into(), json!(required));
    }
    object.insert("additionalProperties".into(), json!(false));
    object
}

fn property(key: &KeySpec, grammar: &Grammar) -> (String, Json) {
    let mut value = value(&key.ty, grammar);
    if let Json::Object(object) = &mut value {
        // Beside a `$ref` nothing else counts, so the description needs the reference one level down.
        if object.contains_key("$ref") {
            value = json!({ "allOf": [value], "description": key.doc });
        } else {
            object.insert("description".into(), json!(key.doc));
        }
    }
    (key.name.to_owned(), value)
}

/// A table with its own keys and exactly one verb.
fn with_verb(verbs: &Verbs, grammar: &Grammar) -> Json {
    let mut object = table(verbs.own, grammar);
    if let Some(Json::Object(properties)) = object.get_mut("properties") {
        properties.extend(verbs.verbs.iter().map(|verb| property(verb, grammar)));
    }
    let one = |name: &str| json!({ "required": [name] });
    let each: Vec<Json> = verbs.verbs.iter().map(|verb| one(verb.name)).collect();
    let mut forms = each.clone();
    if let Some(alone) = verbs.alone {
        forms.push(json!({ "required": [alone], "not": { "anyOf": each } }));
    }
    object.insert("oneOf".into(), Json::Array(forms));
    Json::Object(object)
}

/// What a value of this type has to be.
fn value(ty: &KeyType, grammar: &Grammar) -> Json {
    match ty {
        KeyType::Text => json!({ "type": "string" }),
        KeyType::Bool => typed("boolean", grammar),
        KeyType::Integer(min, max) => {
            let mut integer = typed("integer", grammar);
            for (key, limit, open) in [("minimum", *min, i64::MIN), ("maximum", *max, i64::MAX)] {
                if let Some(object) = integer.as_object_mut().filter(|_| limit != open) {
                    object.insert(key.into(), json!(limit));
                }
            }
            integer
        }
        KeyType::Number => typed("number", grammar),
        KeyType::Duration => text(&["string"], DURATION, &["10 ms", "1 min 30 s"], grammar),
        KeyType::Quantity => text(&["string", "number"], QUANTITY, &["200 kHz"], grammar),
        KeyType::Range => {
            text(&["string", "number"], RANGE, &["100 ms .. 100.3 ms", ".. 5 ms", "24 V ± 10 %"], grammar)
        }
        KeyType::Anchor if grammar.instant.is_empty() => json!({ "type": "string", "minLength": 1 }),
        KeyType::Anchor => text(&["string"], &grammar.instant, &["start + 1 s"], grammar),
        KeyType::SignalRef if grammar.signal.is_empty() => json!({ "type": "string", "minLength": 1 }),
        KeyType::SignalRef => {
            json!({ "anyOf": [{ "type": "string", "minLength": 1 }, { "$ref": "#/definitions/signal" }] })
        }
        KeyType::Value => json!({ "type": ["boolean", "number", "string"] }),
        KeyType::Choice(words) => {
            let words = json!({ "type": "string", "enum": words });
            match grammar.references {
                false => words,
                true => json!({ "anyOf": [words, { "type": "string", "pattern": REFERENCE }] }),
            }
        }
        KeyType::List(inner) => {
            let mut list = typed("array", grammar);
            if let Some(object) = list.as_object_mut() {
                object.insert("items".into(), value(inner, grammar));
            }
            list
        }
        KeyType::OneOrMore(inner) => {
            let one = value(inner, grammar);
            json!({ "anyOf": [one, { "type": "array", "minItems": 1, "items": one }] })
        }
        KeyType::Table(keys) => match grammar.verbs.iter().find(|verbs| verbs.own == *keys) {
            Some(verbs) => json!({ "$ref": format!("#/definitions/{}", verbs.name) }),
            None => Json::Object(table(keys, grammar)),
        },
        KeyType::Map(inner) => json!({ "type": "object", "additionalProperties": value(inner, grammar) }),
        KeyType::Either(types) => {
            json!({ "anyOf": types.iter().map(|ty| value(ty, grammar)).collect::<Vec<_>>() })
        }
        KeyType::Any => json!({}),
    }
}

/// A value of one type of JSON, or a reference to one.
fn typed(name: &str, grammar: &Grammar) -> Json {
    match grammar.references {
        // A pattern holds for texts alone.
        true => json!({ "type": [name, "string"], "pattern": REFERENCE }),
        false => json!({ "type": name }),
    }
}

/// A text with a grammar of its own; among the types there may be a number, which needs none.
fn text(types: &[&str], pattern: &str, examples: &[&str], grammar: &Grammar) -> Json {
    let mut pattern = whole(pattern);
    if grammar.references {
        pattern = format!("{pattern}|{REFERENCE}");
    }
    let types = if let [one] = types { json!(one) } else { json!(types) };
    json!({ "type": types, "pattern": pattern, "examples": examples })
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: &[KeySpec] = &[
        KeySpec::required("id", KeyType::Text, "Its name."),
        KeySpec::optional("at", KeyType::Anchor, "Its instant."),
    ];
    const WAIT: &[KeySpec] = &[KeySpec::required("for", KeyType::Duration, "How long.")];
    const KEYS: &[KeySpec] = &[
        KeySpec::required("format", KeyType::Integer(1, i64::MAX), "The format."),
        KeySpec::optional("mode", KeyType::Choice(&["run", "stop"]), "What is done."),
        KeySpec::optional("steps", KeyType::List(&KeyType::Table(STEP)), "In order."),
    ];

    fn grammar(references: bool) -> Grammar {
        let verbs = vec![KeySpec::optional("wait", KeyType::Table(WAIT), "Waits.")];
        Grammar {
            references,
            instant: "[a-z]+".into(),
            verbs: vec![Verbs { name: "step", own: STEP, verbs, alone: Some("at") }],
            ..Grammar::default()
        }
    }

    #[test]
    fn a_table_says_its_keys_and_no_others() {
        let schema = schema("T", "D", KEYS, &grammar(false));
        assert_eq!(schema["required"], json!(["format"]));
        assert_eq!(schema["additionalProperties"], json!(false));
        let format = json!({ "type": "integer", "minimum": 1, "description": "The format." });
        assert_eq!(schema["properties"]["format"], format);
        assert_eq!(schema["properties"]["mode"]["enum"], json!(["run", "stop"]));
    }

    #[test]
    fn an_entry_has_exactly_one_verb() {
        let schema = schema("T", "D", KEYS, &grammar(false));
        assert_eq!(schema["properties"]["steps"]["items"], json!({ "$ref": "#/definitions/step" }));
        let step = &schema["definitions"]["step"];
        assert_eq!(step["properties"]["wait"]["required"], json!(["for"]));
        let alone = json!({ "required": ["at"], "not": { "anyOf": [{ "required": ["wait"] }] } });
        assert_eq!(step["oneOf"], json!([{ "required": ["wait"] }, alone]));
    }

    #[test]
    fn a_reference_may_stand_for_any_value() {
        let schema = schema("T", "D", KEYS, &grammar(true));
        assert_eq!(schema["properties"]["format"]["type"], json!(["integer", "string"]));
        assert_eq!(schema["properties"]["mode"]["anyOf"][1]["pattern"], json!(REFERENCE));
        let at = schema["definitions"]["step"]["properties"]["at"]["pattern"].as_str().unwrap();
        assert!(at.ends_with(REFERENCE), "{at}");
    }
}
