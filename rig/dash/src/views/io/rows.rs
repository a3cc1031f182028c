//! The rows of the table: which ones, in which order, and what stands in them.

use crate::input_value::ExpectedInput;
use crate::model::RigModel;
use crate::show;
use control::{PointDirection, PointInfo, PointStatus, Signal, SignalKind, Value, WireValue};
use std::cmp::Ordering;

/// A row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum IoRow {
    /// The point at this place of the description.
    Point(usize),
    /// The signal at this place of it.
    Signal(usize),
    /// What somebody asked for by its name or address.
    Named(String),
}

/// What the rows are sorted by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Sort {
    /// As the rig lists them.
    #[default]
    Order,
    Name,
    Address,
    Variable,
    /// The greatest first.
    Value,
    /// The most first.
    Edges,
    /// What is lost first, then what is forced.
    Trouble,
}

impl Sort {
    const ALL: [Sort; 7] =
        [Sort::Order, Sort::Name, Sort::Address, Sort::Variable, Sort::Value, Sort::Edges, Sort::Trouble];

    pub fn next(self) -> Sort {
        let place = Sort::ALL.iter().position(|sort| *sort == self).unwrap_or(0);
        Sort::ALL[(place + 1) % Sort::ALL.len()]
    }

    pub fn name(self) -> &'static str {
        match self {
            Sort::Order => "order",
            Sort::Name => "name",
            Sort::Address => "address",
            Sort::Variable => "variable",
            Sort::Value => "value",
            Sort::Edges => "edges",
            Sort::Trouble => "trouble",
        }
    }
}

/// What stands in a row.
#[derive(Clone, Debug, Default)]
pub(super) struct Cells {
    pub name: String,
    pub address: String,
    pub variable: String,
    pub direction: &'static str,
    /// What the program sees or wrote.
    pub image: Option<WireValue>,
    pub image_text: String,
    /// What the word of an analogue channel stands for, in its unit.
    pub meaning: Option<String>,
    /// How far the word of an analogue channel is from one end of its mode to the other: 0 to 1, and beyond. Such a channel has no
    /// edges.
    pub share: Option<f64>,
    /// What is on the line.
    pub line_text: String,
    pub edges: PointStatus,
    pub is_point: bool,
    /// The device, or what stands for it.
    pub driver: String,
    /// How the device is.
    pub health: String,
    pub lost: bool,
    pub forced: bool,
    /// Who forced it.
    pub by: String,
}

impl IoRow {
    /// The signals that show it.
    pub fn signals(&self, model: &RigModel) -> Vec<String> {
        match self {
            IoRow::Point(place) => {
                let point = &model.description.points[*place];
                let channel = point.channel.as_ref().map(|channel| channel.name.clone());
                point.image.clone().into_iter().chain(channel).collect()
            }
            IoRow::Signal(place) => vec![model.description.signals[*place].name.clone()],
            IoRow::Named(name) => vec![name.clone()],
        }
    }

    /// What can be forced of it, by its address, and whether that is a point with two values.
    pub fn forcible(&self, model: &RigModel) -> Option<String> {
        let IoRow::Point(place) = self else { return None };
        let point = &model.description.points[*place];
        let name = || point.address.clone().unwrap_or_else(|| point.name.clone());
        point.forcible.then(name)
    }

    /// What a value is written to, with the kind and the names of its values.
    pub fn writable(&self, model: &RigModel) -> (String, ExpectedInput) {
        match self {
            IoRow::Point(place) => {
                let point = &model.description.points[*place];
                let name = point.variable.clone().or_else(|| point.address.clone());
                // What is in the image of an analog point are its steps.
                let is_level = point.kind == SignalKind::Bool;
                let expected = if is_level { ExpectedInput::level() } else { ExpectedInput::default() };
                (name.unwrap_or_else(|| point.name.clone()), expected)
            }
            IoRow::Signal(place) => {
                let signal = &model.description.signals[*place];
                (signal.name.clone(), ExpectedInput::of(signal))
            }
            IoRow::Named(name) => (name.clone(), ExpectedInput::default()),
        }
    }

    /// What stands in it.
    pub fn cells(&self, model: &RigModel) -> Cells {
        let value = |name: &str| model.values.get(name).map(|(_, value)| *value);
        match self {
            IoRow::Point(place) => point_cells(*place, &model.description.points[*place], model),
            IoRow::Signal(place) => {
                let signal = &model.description.signals[*place];
                signal_cells(signal, value(&signal.name))
            }
            IoRow::Named(name) => {
                let image = value(name);
                let image_text = image.map_or("...".to_owned(), |image| show::value(image, &[]));
                Cells { name: name.clone(), image, image_text, ..Cells::default() }
            }
        }
    }
}

fn signal_cells(signal: &Signal, image: Option<WireValue>) -> Cells {
    let image_text = image.map_or("...".to_owned(), |image| show::of_signal(image, Some(signal)));
    Cells { variable: signal.name.clone(), image, image_text, ..Cells::default() }
}

fn point_cells(place: usize, point: &PointInfo, model: &RigModel) -> Cells {
    let value = |name: &Option<String>| {
        name.as_ref().and_then(|name| model.values.get(name)).map(|(_, value)| *value)
    };
    let text = |of: Option<WireValue>, unit: &str| match of {
        None => "...".to_owned(),
        Some(of) => show::with_unit(of, &[], unit),
    };
    let edges = model.status.points.get(place).copied().unwrap_or_default();
    let forced = point.address.as_ref().and_then(|address| model.forced(address));
    let image = value(&point.image);
    let mut cells = Cells {
        name: point.name.clone(),
        address: point.address.clone().unwrap_or_default(),
        variable: point.variable.clone().unwrap_or_default(),
        direction: match point.direction {
            PointDirection::Input => "input",
            PointDirection::Output => "output",
            PointDirection::Loose => "loose",
        },
        image,
        image_text: if point.image.is_some() { text(image, "") } else { "-".to_owned() },
        line_text: "-".to_owned(),
        edges,
        is_point: true,
        driver: "unbound".to_owned(),
        lost: edges.lost,
        forced: forced.is_some(),
        by: forced.and_then(|forced| forced.by.clone()).unwrap_or_default(),
        ..Cells::default()
    };
    if let (Some(scale), Some(WireValue(Value::Int(word)))) = (&point.scale, image) {
        // The image is a WORD, and that of an analogue channel is an INT.
        let word = word as i16;
        let value = WireValue(Value::Real(scale.value(f64::from(word))));
        let meaning = show::with_unit(value, &[], &scale.unit);
        cells.image_text = format!("{word} = {meaning}");
        cells.meaning = Some(meaning);
        cells.share = Some(scale.share(f64::from(word)));
    }
    if let Some(channel) = &point.channel {
        let line = value(&Some(channel.name.clone()));
        cells.line_text = text(line, &channel.unit);
        let device = channel.device.and_then(|place| {
            let info = model.description.devices.get(place)?;
            Some((info, model.status.devices.get(place)))
        });
        match device {
            None => cells.driver = "simulated".to_owned(),
            Some((info, status)) => {
                cells.driver = info.name.clone();
                let unsound = status.is_some_and(|status| !status.sound);
                cells.lost |= unsound;
                cells.health = match status {
                    Some(status) if !status.why.is_empty() => status.why.clone(),
                    _ if cells.lost => "the channel is lost".to_owned(),
                    _ => "sound".to_owned(),
                };
            }
        }
        if image.is_none() && point.image.is_none() {
            cells.image = line;
        }
    }
    cells
}

/// The rows that are shown: those with every word of the filter somewhere in them, in this order.
pub(super) fn rows(
    model: &RigModel,
    variables: bool,
    named: &[String],
    filter: &str,
    sort: Sort,
) -> Vec<IoRow> {
    let named = named.iter().map(|name| IoRow::Named(name.clone()));
    let points = (0..model.description.points.len()).map(IoRow::Point);
    let signals = if variables { 0..model.description.signals.len() } else { 0..0 };
    let all = named.chain(points).chain(signals.map(IoRow::Signal));
    if filter.is_empty() && sort == Sort::Order {
        return all.collect();
    }
    let words: Vec<String> = filter.split_whitespace().map(str::to_lowercase).collect();
    let with_cells = |row: IoRow| {
        let cells = row.cells(model);
        (row, cells)
    };
    let mut rows: Vec<(IoRow, Cells)> = all.map(with_cells).collect();
    rows.retain(|(row, cells)| {
        let text = searched(row, cells, model);
        words.iter().all(|word| text.contains(word))
    });
    rows.sort_by(|(_, a), (_, b)| order(sort, a, b));
    rows.into_iter().map(|(row, _)| row).collect()
}

/// Everything that a filter looks at.
fn searched(row: &IoRow, cells: &Cells, model: &RigModel) -> String {
    let mut text = [
        &*cells.name,
        &*cells.address,
        &*cells.variable,
        cells.direction,
        &*cells.image_text,
        &*cells.driver,
        if cells.forced { "forced" } else { "" },
        if cells.lost { "lost" } else { "" },
    ]
    .join(" ");
    if let IoRow::Point(place) = row
        && let Some(channel) = &model.description.points[*place].channel
    {
        text.push(' ');
        text.push_str(&channel.name);
    }
    text.to_lowercase()
}

fn order(sort: Sort, a: &Cells, b: &Cells) -> Ordering {
    // What has no such thing comes last.
    let texts = |a: &str, b: &str| (a.is_empty(), natural(a)).cmp(&(b.is_empty(), natural(b)));
    let number = |cells: &Cells| cells.image.and_then(|value| value.0.as_real()).unwrap_or(f64::NEG_INFINITY);
    match sort {
        Sort::Order => Ordering::Equal,
        Sort::Name => texts(&a.name, &b.name),
        Sort::Address => texts(&a.address, &b.address),
        Sort::Variable => texts(&a.variable, &b.variable),
        Sort::Value => number(b).total_cmp(&number(a)),
        Sort::Edges => {
            let edges = |cells: &Cells| cells.edges.rising.saturating_add(cells.edges.falling);
            edges(b).cmp(&edges(a))
        }
        Sort::Trouble => (b.lost, b.forced).cmp(&(a.lost, a.forced)),
    }
}

/// A name in parts, so that `I2` comes before `I10`.
fn natural(name: &str) -> Vec<(u64, String)> {
    let mut parts: Vec<(u64, String)> = Vec::new();
    for character in name.chars() {
        match (character.to_digit(10), parts.last_mut()) {
            (Some(digit), Some((number, text))) if text.is_empty() => {
                *number = number.saturating_mul(10).saturating_add(u64::from(digit));
            }
            (Some(digit), _) => parts.push((u64::from(digit), String::new())),
            (None, Some((0, text))) if !text.is_empty() => text.push(character),
            (None, _) => parts.push((0, character.to_string())),
        }
    }
    parts
}
