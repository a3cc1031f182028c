//! The JSON Schema of plans, from the same tables of keys and verbs that their reader checks by.

use document::schema::{Grammar, Verbs, schema};
use document::{KeySpec, KeyType};
use serde_json::Value as Json;

use crate::plan::{EXPECT_KEYS, INCLUDED_KEYS, PLAN_KEYS, STEP_KEYS, SUITE_KEYS};
use crate::signals::SOURCE_KEYS;
use crate::{expect, lang, steps};

/// The schema of a plan.
pub fn plan() -> Json {
    schema(
        "Scanrig test plan",
        "What a rig does to a logic controller, and what it claims of it.",
        PLAN_KEYS,
        &grammar(),
    )
}

/// The schema of a suite file.
pub fn suite() -> Json {
    let description = "What holds in every case of the plans in its folder and below.";
    schema("Scanrig suite file", description, SUITE_KEYS, &Grammar { references: false, ..grammar() })
}

/// The schema of a file that plans include. What stands in it as in a plan is held against the tables of plans when it
/// is there.
pub fn included() -> Json {
    let known = |key: &KeySpec| match key.ty {
        KeyType::Any | KeyType::List(KeyType::Any) => {
            PLAN_KEYS.iter().find(|known| known.name == key.name).copied()
        }
        _ => None,
    };
    let keys: Vec<KeySpec> = INCLUDED_KEYS.iter().map(|key| known(key).unwrap_or(*key)).collect();
    schema("Scanrig included file", "What several plans share.", &keys, &grammar())
}

/// The schema of a board file with these keys. What stands in a board file as in a plan, its reader knows by name
/// alone: plans say what that is.
pub fn board(keys: &[KeySpec]) -> Json {
    let known = |key: &KeySpec| match key.ty {
        KeyType::List(KeyType::Any) => SUITE_KEYS.iter().find(|known| known.name == key.name).copied(),
        _ => None,
    };
    let keys: Vec<KeySpec> = keys.iter().map(|key| known(key).unwrap_or(*key)).collect();
    let description = "Which controller is tested, on which board, bound how.";
    schema("Scanrig board file", description, &keys, &Grammar { references: false, ..grammar() })
}

/// What plans add to their tables of keys: instants, tables that name signals, and the verbs of steps and
/// expectations.
pub fn grammar() -> Grammar {
    let steps = steps::VERBS.iter().map(|verb| KeySpec::optional(verb.name, verb.value, verb.doc));
    let claims =
        expect::VERBS.iter().map(|verb| KeySpec::optional(verb.name, KeyType::Table(verb.keys), verb.doc));
    Grammar {
        references: true,
        instant: lang::instant_pattern(),
        signal: SOURCE_KEYS,
        verbs: vec![
            Verbs { name: "step", own: STEP_KEYS, verbs: steps.collect(), alone: Some("when") },
            Verbs { name: "expectation", own: EXPECT_KEYS, verbs: claims.collect(), alone: None },
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // A verb that is added to the tables is in the schema, and a step has one of them.
    #[test]
    fn every_verb_is_in_the_schema() {
        let schema = plan();
        for (list, name, count) in
            [("steps", "step", steps::VERBS.len() + 1), ("expect", "expectation", expect::VERBS.len())]
        {
            let reference = schema["properties"][list]["items"]["$ref"].as_str();
            assert_eq!(reference, Some(format!("#/definitions/{name}").as_str()));
            assert_eq!(schema["definitions"][name]["oneOf"].as_array().map(Vec::len), Some(count), "{name}");
        }
        let set = &schema["definitions"]["step"]["properties"]["set"];
        assert_eq!(set["anyOf"][1]["items"]["required"], serde_json::json!(["signal", "value"]));
    }
}
