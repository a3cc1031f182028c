//! The record as the page carries it: JSON without what is empty, deflated, in base64.
//!
//! The library's 4313 cases are 27 MB as a plain record; so packed they are under 2 MB, and the browser draws what is
//! looked at.

use record::{Lane, RunRecord};
use serde::Serialize;
use serde_json::{Value, json};

/// How hard to pack: the greatest level that is still fast.
const LEVEL: u8 = 8;

/// The run, ready to stand in the page: letters, digits, `+`, `/` and `=` only.
pub(super) fn packed(run: &RunRecord) -> String {
    base64(&miniz_oxide::deflate::compress_to_vec_zlib(text(run).as_bytes(), LEVEL))
}

/// The run as JSON, case by case, so that a large run never stands in memory as a tree.
fn text(run: &RunRecord) -> String {
    // The coverage stands in the page as a table of its own.
    let shell = RunRecord {
        format: run.format,
        rig_version: run.rig_version.clone(),
        provenance: run.provenance.clone(),
        totals: run.totals,
        planned: run.planned,
        host_ms: run.host_ms,
        shard: run.shard,
        requirements: run.requirements.clone(),
        ..RunRecord::default()
    };
    let mut text = pruned(tree(&shell)).to_string();
    // The shell is an object that has a format, so it ends in a brace after at least one field.
    text.pop();
    text.push_str(&format!(",\"repeated\":{}", pruned(tree(&run.repeated()))));
    text.push_str(",\"cases\":[");
    for (place, case) in run.cases.iter().enumerate() {
        if place > 0 {
            text.push(',');
        }
        let mut value = tree(case);
        if let Value::Object(fields) = &mut value {
            fields.insert("lanes".to_owned(), case.lanes.iter().map(lane).collect());
        }
        text.push_str(&pruned(value).to_string());
    }
    text.push_str("]}");
    text
}

fn tree(of: &impl Serialize) -> Value {
    // Keys are strings and numbers finite or written as words, so this cannot fail.
    serde_json::to_value(of).unwrap_or_default()
}

/// A lane with its points as one list of numbers, three for each: distance of the earliest instant from that of the
/// point before, width of the interval, value. Most distances come again and again, which packs well.
fn lane(lane: &Lane) -> Value {
    let mut value = tree(&Lane { points: Vec::new(), ..lane.clone() });
    let mut before = 0;
    let changes = lane.points.iter().flat_map(|point| {
        let [earliest, latest] = point.at;
        let distance = earliest.saturating_sub(before);
        before = earliest;
        [json!(distance), json!(latest.saturating_sub(earliest)), tree(&point.value)]
    });
    let changes: Value = changes.collect();
    if let Value::Object(fields) = &mut value {
        fields.insert("changes".to_owned(), changes);
    }
    value
}

/// The value without what is empty: the page takes what is missing for empty. Numbers stay, and what stands in a
/// list.
fn pruned(value: Value) -> Value {
    match value {
        Value::Object(fields) => {
            let kept =
                fields.into_iter().map(|(key, value)| (key, pruned(value))).filter(|(_, v)| !is_empty(v));
            Value::Object(kept.collect())
        }
        Value::Array(items) => Value::Array(items.into_iter().map(pruned).collect()),
        other => other,
    }
}

fn is_empty(value: &Value) -> bool {
    match value {
        Value::Null | Value::Bool(false) => true,
        Value::String(text) => text.is_empty(),
        Value::Array(items) => items.is_empty(),
        Value::Object(fields) => fields.is_empty(),
        Value::Bool(true) | Value::Number(_) => false,
    }
}

/// Base64 with the usual alphabet (RFC 4648).
pub(super) fn base64(bytes: &[u8]) -> String {
    const ALPHABET: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for group in bytes.chunks(3) {
        let byte = |place: usize| u32::from(group.get(place).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for place in 0..4 {
            if place > group.len() {
                text.push('=');
            } else {
                text.push(char::from(ALPHABET[(bits >> (18 - 6 * place)) as usize & 63]));
            }
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use record::{CaseRecord, LaneKind, LanePoint, LaneValue};

    #[test]
    fn base64_as_in_the_rfc() {
        let all = ["", "f", "fo", "foo", "foob", "fooba", "foobar"].map(|text| base64(text.as_bytes()));
        assert_eq!(all, ["", "Zg==", "Zm8=", "Zm9v", "Zm9vYg==", "Zm9vYmE=", "Zm9vYmFy"]);
    }

    #[test]
    fn nothing_but_what_is_empty_is_left_out() {
        let mut run = RunRecord::new("0.1.0", record::Provenance::default());
        let point = |at, value| LanePoint { at, value };
        run.push(CaseRecord {
            name: "a".into(),
            lanes: vec![Lane {
                signal: "lamp".into(),
                kind: LaneKind::Digital,
                points: vec![
                    point([5, 7], LaneValue::Number(0.0)),
                    point([15, 15], LaneValue::HighZ),
                    point([10, 12], LaneValue::Number(1.5)),
                    point([i64::MIN, i64::MAX], LaneValue::Unknown),
                ],
                ..Lane::default()
            }],
            ..CaseRecord::default()
        });
        let read: Value = serde_json::from_str(&text(&run)).unwrap();
        assert_eq!(read["rig_version"], "0.1.0");
        assert_eq!(read["totals"]["none"], 1);
        let case = &read["cases"][0];
        assert_eq!(
            (&case["name"], &case["verdict"], &case["seed"]),
            (&json!("a"), &json!("none"), &json!(0))
        );
        assert!(case.get("title").is_none() && case.get("claims").is_none());
        let lane = &case["lanes"][0];
        assert!(lane.get("points").is_none());
        let far = [json!(i64::MIN), json!(i64::MAX), json!("x")];
        let near =
            [json!(5), json!(2), json!(0), json!(10), json!(0), json!("z"), json!(-5), json!(2), json!(1.5)];
        assert_eq!(lane["changes"], Value::Array(near.into_iter().chain(far).collect()));
    }
}
