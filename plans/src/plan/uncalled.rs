//! Groups that no call brings into a case: they are read as far as they can be without arguments.

use document::{Diagnostic, Fields, Findings, KeySpec, KeyType, Node, Table};

use super::envelope::{self, EXPECTATION, EntryForm, STEP};
use super::groups::PlanGroup;
use crate::{codes, expect, measure, steps};

/// Reports what can be seen of a group that no call brings into a case: verbs and keys that there are none of. Its values
/// may be arguments, which only a call has.
pub(super) fn check(group: &PlanGroup, out: &mut Findings) {
    for step in &group.steps {
        check_entry(&step.node, &STEP, &step_value, out);
    }
    for claim in &group.expect {
        check_entry(&claim.node, &EXPECTATION, &claim_value, out);
    }
    for measurement in &group.measure {
        if let Some(table) = measurement.node.as_table() {
            check_keys(table, &measurement.node, "measurement", measure::KEYS, out);
        }
    }
}

fn step_value(verb: &str) -> Option<KeyType> {
    steps::VERBS.iter().find(|known| known.name == verb).map(|verb| verb.value)
}

fn claim_value(verb: &str) -> Option<KeyType> {
    expect::verb(verb).map(|verb| KeyType::Table(verb.keys))
}

fn check_entry(node: &Node, form: &EntryForm, value: &dyn Fn(&str) -> Option<KeyType>, out: &mut Findings) {
    let verbs: Vec<&'static str> = match form.what {
        "step" => steps::VERBS.iter().map(|verb| verb.name).collect(),
        _ => expect::VERBS.iter().map(|verb| verb.name).collect(),
    };
    let Some((Some(entry), _)) = envelope::verb(node, form, &verbs, out) else { return };
    if let (Some(KeyType::Table(keys)), Some(table)) = (value(&entry.key), entry.node.as_table()) {
        check_keys(table, &entry.node, &format!("{} `{}`", form.what, entry.key), keys, out);
    }
}

/// Reports keys that are unknown or missing, and nothing of values.
fn check_keys(table: &Table, node: &Node, what: &str, keys: &'static [KeySpec], out: &mut Findings) {
    let mut own = out.none_yet();
    Fields::check(table, node.span.clone(), what, keys, &mut own);
    let of_keys = |one: &Diagnostic| [codes::UNKNOWN_KEY, codes::MISSING_KEY].contains(&one.code);
    own.into_vec().into_iter().filter(of_keys).for_each(|one| out.push(one));
}
