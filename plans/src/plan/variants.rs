//! Rows, sweeps, parameters and phases: what multiplies one plan into cases.
//!
//! Cases are numbered, never listed: rows outermost, then sweeps in the plan's order, then phases in the steps'
//! order. What a number means is worked out when the case is asked for.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::ops::Range;

use document::{Data, Entry, Fields, Findings, KeySpec, KeyType, Node, Table, suggest};
use signal::{Decimal, Quantity, Unit};

use super::read::MAX_CASES;
use crate::codes;
use crate::lang::{Bindings, MAX_VALUE_BYTES, has_reference, is_id};

/// A row: values by name.
pub(super) const ROW_TYPE: KeyType = KeyType::Map(&KeyType::Any);

const SWEEP_KEYS: &[KeySpec] = &[
    KeySpec::optional("from", KeyType::Quantity, "The first value."),
    KeySpec::optional("to", KeyType::Quantity, "The last value is at or below this."),
    KeySpec::optional("step", KeyType::Quantity, "From one value to the next."),
    KeySpec::optional("values", KeyType::List(&KeyType::Value), "The values one by one."),
];
/// A sweep.
pub(super) const SWEEP_TYPE: KeyType = KeyType::Table(SWEEP_KEYS);

/// A default, which may be a list.
const DEFAULT: KeyType = KeyType::Either(&[KeyType::Value, KeyType::List(&KeyType::Value)]);

const PARAMETER_KEYS: &[KeySpec] = &[
    KeySpec::required("default", DEFAULT, "The value if the command line gives none."),
    KeySpec::optional("doc", KeyType::Text, "What it means."),
];
/// A parameter: its default, alone or with what it means.
pub(super) const PARAMETER_TYPE: KeyType =
    KeyType::Either(&[KeyType::Table(PARAMETER_KEYS), KeyType::Value, KeyType::List(&KeyType::Value)]);

/// Most names of a row, of all sweeps and of all parameters: bounds the search for each reference.
const MAX_NAMES: usize = 200;

/// A row of the plan.
#[derive(Clone, Debug)]
pub(super) struct PlanRow {
    pub(super) name: String,
    pub(super) place: Range<usize>,
    values: Vec<Entry>,
}

/// A value that has a name for all cases, or one for each point of a sweep.
#[derive(Clone, Debug)]
struct NamedValues {
    name: String,
    values: Vec<Node>,
    place: Option<Range<usize>>,
}

/// The cases of each row.
#[derive(Clone, Debug)]
struct RowCases {
    /// Place in `rows`, `None` for a plan without rows.
    row: Option<usize>,
    /// Place of the step and number of its positions.
    phases: Vec<(usize, u64)>,
    /// Cases up to the end of this block.
    until: u64,
}

/// All that multiplies a plan.
#[derive(Clone, Debug, Default)]
pub(super) struct Variants {
    pub(super) rows: Vec<PlanRow>,
    sweeps: Vec<NamedValues>,
    parameters: Vec<NamedValues>,
    blocks: Vec<RowCases>,
}

/// One case among them.
#[derive(Clone, Debug)]
pub(super) struct Variant<'a> {
    pub(super) row: Option<&'a PlanRow>,
    /// Sweep and place of its value.
    points: Vec<(&'a NamedValues, usize)>,
    /// Place of the step, its position and the number of positions.
    pub(super) phases: Vec<(usize, u64, u64)>,
    parameters: &'a [NamedValues],
}

impl Variants {
    /// Reads rows, sweeps and parameters of the plan's root; reports what is wrong.
    pub(super) fn read(root: &Table, given: &[(String, String)], out: &mut Findings) -> Variants {
        let mut variants = Variants::default();
        if let Some(entry) = root.entry("rows") {
            variants.rows = rows(entry, out);
        }
        if let Some(table) = table_of(root, "sweep", &KeyType::Map(&SWEEP_TYPE), out) {
            variants.sweeps = table.entries.iter().filter_map(|entry| sweep(entry, out)).collect();
        }
        if let Some(table) = table_of(root, "parameters", &KeyType::Map(&KeyType::Any), out) {
            variants.parameters =
                table.entries.iter().filter_map(|entry| parameter(entry, given, out)).collect();
        }
        for (name, _) in given {
            if !variants.parameters.iter().any(|known| known.name == *name) {
                let help = match suggest(name, variants.parameters.iter().map(|known| known.name.as_str())) {
                    Some(meant) => format!("did you mean `{meant}`?"),
                    None => "parameters stand in the plan's [parameters]".to_owned(),
                };
                out.error(codes::PARAMETER, 0..0, format!("the plan has no parameter `{name}`"), help);
            }
        }
        variants.check_names(out);
        variants
    }

    /// Numbers the cases; `positions` gives the phases of a row's steps. Reports a plan with too many.
    pub(super) fn count(
        &mut self,
        positions: impl Fn(Option<&str>) -> Vec<(usize, u64)>,
        out: &mut Findings,
    ) {
        let swept = self.sweeps.iter().fold(1u64, |all, sweep| all.saturating_mul(sweep.values.len() as u64));
        let rows: Vec<Option<usize>> =
            if self.rows.is_empty() { vec![None] } else { (0..self.rows.len()).map(Some).collect() };
        let mut total = 0u64;
        for row in rows {
            let phases = positions(row.map(|at| self.rows[at].name.as_str()));
            let moved = phases.iter().fold(1u64, |all, (_, count)| all.saturating_mul(*count));
            total = total.saturating_add(swept.saturating_mul(moved));
            self.blocks.push(RowCases { row, phases, until: total });
        }
        if total > MAX_CASES {
            let help = "rows, sweeps and phases multiply: widen the steps of a sweep, or split the plan";
            let message = format!("the plan has {total} cases; {MAX_CASES} is the most");
            out.error(codes::TOO_MANY_CASES, 0..0, message, help);
            self.blocks.clear();
        }
    }

    /// How many cases there are.
    pub(super) fn len(&self) -> u64 {
        self.blocks.last().map_or(0, |block| block.until)
    }

    /// The case of this number.
    pub(super) fn get(&self, number: u64) -> Option<Variant<'_>> {
        let at = self.blocks.partition_point(|block| block.until <= number);
        let block = self.blocks.get(at)?;
        let before = if at == 0 { 0 } else { self.blocks[at - 1].until };
        let mut rest = number - before;
        let mut phases: Vec<(usize, u64, u64)> = Vec::with_capacity(block.phases.len());
        for (step, count) in block.phases.iter().rev() {
            phases.push((*step, rest % count, *count));
            rest /= count;
        }
        phases.reverse();
        let mut points = Vec::with_capacity(self.sweeps.len());
        for sweep in self.sweeps.iter().rev() {
            let count = sweep.values.len() as u64;
            points.push((sweep, (rest % count) as usize));
            rest /= count;
        }
        points.reverse();
        let row = block.row.map(|row| &self.rows[row]);
        Some(Variant { row, points, phases, parameters: &self.parameters })
    }

    /// Reports names that more than one of rows, sweeps and parameters define.
    fn check_names(&self, out: &mut Findings) {
        let mut known: BTreeSet<&str> =
            self.rows.iter().flat_map(|row| &row.values).map(|value| value.key.as_str()).collect();
        for named in self.sweeps.iter().chain(&self.parameters) {
            if !known.insert(&named.name) {
                let place = named.place.clone().unwrap_or(0..0);
                let message = format!("`{}` is defined twice among rows, sweeps and parameters", named.name);
                out.error(codes::NAME_TWICE, place, message, "give one of them another name");
            }
        }
    }
}

impl<'a> Variant<'a> {
    /// What `$` names have which value in this case.
    pub(super) fn bindings(&self) -> Bindings<'a> {
        let mut bindings = Bindings::of_row(self.row.map(|row| (row.name.as_str(), row.place.clone())));
        if let Some(row) = self.row {
            for value in &row.values {
                bindings.add(&value.key, Cow::Borrowed(&value.node), Some(value.node.span.clone()));
            }
        }
        for (sweep, at) in &self.points {
            bindings.add(&sweep.name, Cow::Borrowed(&sweep.values[*at]), sweep.place.clone());
        }
        for parameter in self.parameters {
            bindings.add(&parameter.name, Cow::Borrowed(&parameter.values[0]), parameter.place.clone());
        }
        bindings
    }

    /// What stands after the plan's path in the case's name, the phases aside.
    pub(super) fn suffix(&self) -> String {
        let mut suffix = self.row.map_or_else(String::new, |row| format!("[{}]", row.name));
        for (sweep, at) in &self.points {
            suffix.push_str(&format!("[{}={}]", sweep.name, show(&sweep.values[*at])));
        }
        suffix
    }
}

/// A scalar as the user wrote it.
pub(super) fn show(node: &Node) -> String {
    match &node.data {
        Data::Text(text) | Data::Float(text) | Data::Datetime(text) => text.clone(),
        Data::Integer(number) => number.to_string(),
        Data::Bool(on) => on.to_string(),
        Data::Array(list) => list.iter().map(show).collect::<Vec<_>>().join(", "),
        Data::Table(_) => "{}".to_owned(),
    }
}

/// A table of the root that was found right.
fn table_of<'t>(root: &'t Table, key: &str, ty: &KeyType, out: &mut Findings) -> Option<&'t Table> {
    let node = root.get(key)?;
    let table = document::check_value(node, key, ty, out).then(|| node.as_table())??;
    not_too_many(table, out).then_some(table)
}

/// Reports a table of more names than [`MAX_NAMES`].
fn not_too_many(table: &Table, out: &mut Findings) -> bool {
    if let Some(entry) = table.entries.get(MAX_NAMES) {
        let message = format!("more than {MAX_NAMES} names");
        out.error(
            codes::TOO_LARGE,
            entry.key_span.clone(),
            message,
            "write what does not differ where it is used",
        );
    }
    table.entries.len() <= MAX_NAMES
}

fn rows(entry: &Entry, out: &mut Findings) -> Vec<PlanRow> {
    let Some(table) = table_of_entry(entry, out) else { return Vec::new() };
    if table.entries.is_empty() {
        let help = "write one row for each case, as in over = { cycle = \"101 ms\" }, or remove [rows]";
        out.error(codes::ROWS, entry.key_span.clone(), "there are no rows", help);
    }
    let mut list = Vec::with_capacity(table.entries.len());
    for row in &table.entries {
        name_of(row, "row", out);
        let Some(values) = row.node.as_table() else {
            let help = "a row is a table of values, as in over = { cycle = \"101 ms\" }";
            out.error(codes::ROWS, row.node.span.clone(), format!("the row is {}", row.node.kind()), help);
            continue;
        };
        if !not_too_many(values, out) {
            continue;
        }
        let right = values.entries.iter().filter(|value| {
            let named = name_of(value, "column", out);
            plain(&value.node, out) && named
        });
        let values = right.cloned().collect();
        list.push(PlanRow { name: row.key.clone(), place: row.key_span.clone(), values });
    }
    list
}

fn table_of_entry<'t>(entry: &'t Entry, out: &mut Findings) -> Option<&'t Table> {
    let table = entry.node.as_table();
    if table.is_none() {
        let help = "rows are a table: [rows], then a line for each row, as in over = { cycle = \"101 ms\" }";
        out.error(codes::ROWS, entry.node.span.clone(), "the rows are not a table", help);
    }
    table
}

/// Reports a name that `$` could not reach.
fn name_of(entry: &Entry, what: &str, out: &mut Findings) -> bool {
    let right = is_id(&entry.key);
    if !right {
        let help = "letters, digits, `_`, and `-` before a letter; it begins with a letter";
        let message = format!("`{}` cannot be the name of a {what}", entry.key);
        out.error(codes::ROWS, entry.key_span.clone(), message, help);
    }
    right
}

/// Reports what a reference cannot stand for: tables, long texts, further references.
fn plain(node: &Node, out: &mut Findings) -> bool {
    let fault = match &node.data {
        Data::Text(text) if text.len() > MAX_VALUE_BYTES => "the text is longer than 256 bytes",
        Data::Text(_) if has_reference(node) => {
            "a value that references are replaced by cannot hold one itself"
        }
        Data::Table(_) => "a value is a Boolean, a number, a text or a list of them",
        Data::Datetime(_) => "a TOML date or time is no value: write a text",
        Data::Array(list) if list.len() > 64 => "a list has at most 64 entries",
        Data::Array(list) => {
            return list.iter().all(|one| {
                let scalar = !matches!(one.data, Data::Array(_));
                if !scalar {
                    out.error(
                        codes::ROWS,
                        one.span.clone(),
                        "a list in a list",
                        "write one list of numbers or texts",
                    );
                }
                scalar && plain(one, out)
            });
        }
        _ => return true,
    };
    let help = "write true, a number, a text in quotes, or a short list of such";
    out.error(codes::ROWS, node.span.clone(), fault, help);
    false
}

fn sweep(entry: &Entry, out: &mut Findings) -> Option<NamedValues> {
    name_of(entry, "sweep", out);
    let fields = Fields::checked(entry.node.as_table()?, SWEEP_KEYS);
    let bad = |out: &mut Findings, message: &str, help: &str| {
        out.error(codes::SWEEP, entry.node.span.clone(), message, help);
        None::<NamedValues>
    };
    let values = match (fields.get("values"), fields.has("from") || fields.has("to") || fields.has("step")) {
        (Some(values), false) => values.as_array()?.to_vec(),
        (None, true) => match (fields.get("from"), fields.get("to"), fields.get("step")) {
            (Some(from), Some(to), Some(step)) => points(from, to, step, out)?,
            _ => return bad(out, "the sweep lacks `from`, `to` or `step`", "all three are needed"),
        },
        _ => {
            let help = "write { from = \"0 ms\", to = \"20 ms\", step = \"1 ms\" } or { values = [1, 2] }";
            return bad(out, "a sweep has either `values` or `from`, `to` and `step`", help);
        }
    };
    if values.is_empty() {
        return bad(out, "the sweep has no values", "write { values = [1, 2] }");
    }
    if !values.iter().all(|value| plain(value, out)) {
        return None;
    }
    Some(NamedValues { name: entry.key.clone(), values, place: Some(entry.key_span.clone()) })
}

/// The values from `from` to at most `to`, in the unit that all three are written in.
fn points(from: &Node, to: &Node, step: &Node, out: &mut Findings) -> Option<Vec<Node>> {
    let first = quantity(from, out)?;
    let last = quantity(to, out)?;
    let by = quantity(step, out)?;
    for (node, other) in [(to, &last), (step, &by)] {
        if other.unit != first.unit {
            let message = "`from`, `to` and `step` are not in one unit";
            let help = match first.unit.is_none() {
                true => String::new(),
                false => format!("write all three in `{}`", first.unit),
            };
            out.error(codes::UNIT, node.span.clone(), message, help);
            return None;
        }
    }
    if by.number <= Decimal::ZERO || last.number < first.number {
        let (place, message) = match by.number <= Decimal::ZERO {
            true => (step, "`step` is not above 0"),
            false => (to, "`to` is below `from`"),
        };
        out.error(codes::SWEEP, place.span.clone(), message, "a sweep goes upwards");
        return None;
    }
    let whole = [from, to, step].iter().all(|node| !matches!(node.data, Data::Float(_)))
        && [&first, &last, &by].iter().all(|quantity| quantity.number.is_whole());
    let mut values = Vec::new();
    let mut number = first.number;
    while number <= last.number {
        if values.len() as u64 == MAX_CASES {
            let message = format!("the sweep has more than {MAX_CASES} values");
            out.error(codes::TOO_MANY_CASES, step.span.clone(), message, "widen its step");
            return None;
        }
        let integer = number.as_whole().and_then(|integer| i64::try_from(integer).ok());
        let data = match (first.unit.is_none(), whole, integer) {
            (false, ..) => Some(Data::Text(Quantity { number, unit: first.unit.clone() }.to_string())),
            (true, true, integer) => integer.map(Data::Integer),
            (true, false, _) => Some(Data::Float(number.to_string())),
        };
        let (Some(data), Some(next)) = (data, number.plus(by.number)) else {
            out.error(
                codes::SWEEP,
                from.span.clone(),
                "too many digits",
                "round `from` and `step`: their sums have at most 30 digits",
            );
            return None;
        };
        values.push(Node::new(from.span.clone(), data));
        number = next;
    }
    Some(values)
}

/// A number with its unit.
fn quantity(node: &Node, out: &mut Findings) -> Option<Quantity> {
    let read = match &node.data {
        Data::Text(text) | Data::Float(text) => Quantity::parse(text).ok(),
        Data::Integer(number) => {
            Some(Quantity { number: Decimal::from(i128::from(*number)), unit: Unit::NONE })
        }
        _ => None,
    };
    if read.is_none() {
        let help = "write a number or a quantity such as \"0.37 ms\"";
        out.error(codes::SWEEP, node.span.clone(), "not a number with at most one unit", help);
    }
    read
}

fn parameter(entry: &Entry, given: &[(String, String)], out: &mut Findings) -> Option<NamedValues> {
    name_of(entry, "parameter", out);
    let default = match entry.node.as_table() {
        Some(table) => {
            let before = out.errors();
            let fields = Fields::check(table, entry.node.span.clone(), "parameter", PARAMETER_KEYS, out);
            if out.errors() > before {
                return None;
            }
            fields.get("default")?
        }
        None => &entry.node,
    };
    if !plain(default, out) {
        return None;
    }
    // The last one on the command line counts.
    let Some((_, text)) = given.iter().rev().find(|(name, _)| *name == entry.key) else {
        let place = Some(default.span.clone());
        return Some(NamedValues { name: entry.key.clone(), values: vec![default.clone()], place });
    };
    let mut value = default.clone();
    value.data = match &default.data {
        Data::Integer(_) => text.parse().map_or(None, |number| Some(Data::Integer(number))),
        Data::Bool(_) => text.parse().map_or(None, |on| Some(Data::Bool(on))),
        Data::Float(_) => {
            text.parse::<f64>().ok().filter(|n| n.is_finite()).map(|_| Data::Float(text.clone()))
        }
        _ => Some(Data::Text(text.clone())),
    }
    .or_else(|| {
        let message = format!("the command line gives `{}` the value \"{text}\"", entry.key);
        let help = format!("it is {} here", default.kind());
        out.error(codes::PARAMETER, default.span.clone(), message, help);
        None
    })?;
    value.content = None;
    if text.len() > MAX_VALUE_BYTES || has_reference(&value) {
        let message =
            format!("the value that the command line gives `{}` is too long or holds a `$`", entry.key);
        let help = "give it a shorter value, without a `$`";
        out.error(codes::PARAMETER, default.span.clone(), message, help);
        return None;
    }
    Some(NamedValues { name: entry.key.clone(), values: vec![value], place: None })
}
