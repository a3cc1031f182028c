//! The terminals of the controller, the lines of the board, and whatever inside has a name: values, forces, edges and
//! the devices behind.

mod rows;

use super::{View, ViewRequest};
use crate::canvas::{self, Canvas, CanvasColumn, column};
use crate::glyphs::TerminalFeatures;
use crate::input_value::{self, ExpectedInput};
use crate::model::RigModel;
use crate::show;
use control::{RequestOperation, Value, WireValue};
use ratatui::Frame;
use ratatui::crossterm::event::{KeyCode, KeyEvent, MouseButton, MouseEvent, MouseEventKind};
use ratatui::layout::{Position, Rect};
use ratatui::style::{Color, Modifier, Style};
use rows::{Cells, IoRow, Sort};

/// Columns of the table; those that name a width are shown from that width on.
const COLUMNS: [CanvasColumn; 8] = [
    column("", 1, false, 0),
    column("Name", 9, false, 0),
    column("Address", 8, false, 0),
    column("Variable", 12, false, 0),
    column("Image", 10, true, 0),
    column("Line", 13, true, 0),
    column("Edges", 9, true, 0),
    column("Driver", 9, false, 0),
];

/// The same where there is room.
const WIDE: [CanvasColumn; 12] = [
    column("", 1, false, 0),
    column("Name", 14, false, 0),
    column("Address", 9, false, 0),
    column("Variable", 22, false, 0),
    column("", 6, false, 0),
    column("Image", 18, true, 0),
    column("Line", 16, true, 0),
    column("Rising", 9, true, 0),
    column("Falling", 9, true, 0),
    column("Driver", 14, false, 0),
    column("Health", 30, false, 0),
    column("Forced by", 20, false, 170),
];

/// From this width on there is room.
const WIDE_FROM: u16 = 160;

/// Up to so many points all are watched, so that sorting by value knows them; else those that are shown.
const WATCHED: usize = 512;

/// Rows that a turn of the wheel moves.
const WHEEL: usize = 3;

/// What the user is typing.
#[derive(Clone, Debug, PartialEq, Eq)]
enum IoPrompt {
    Filter,
    Name,
    Force(String),
    Write(String, ExpectedInput),
}

/// The view.
#[derive(Debug, Default)]
pub struct IoView {
    shown: bool,
    /// Variables and other names beside the points.
    variables: bool,
    filter: String,
    sort: Sort,
    /// Names and addresses that somebody wants to see.
    named: Vec<String>,
    chosen: usize,
    first: usize,
    prompt_for: Option<IoPrompt>,
    /// Where titles and rows were drawn.
    titles: Vec<(Rect, Sort)>,
    rows: Rect,
}

impl IoView {
    fn listed(&self, model: &RigModel) -> Vec<IoRow> {
        rows::rows(model, self.variables, &self.named, &self.filter, self.sort)
    }

    fn chosen_row(&self, model: &RigModel) -> Option<IoRow> {
        self.listed(model).into_iter().nth(self.chosen)
    }

    fn prompt(&mut self, prompt_for: IoPrompt, ask: String, text: String) -> Vec<ViewRequest> {
        self.prompt_for = Some(prompt_for);
        vec![ViewRequest::Prompt { ask, text }]
    }

    /// Forces: the other value is proposed.
    fn force(&mut self, model: &RigModel) -> Vec<ViewRequest> {
        let Some(row) = self.chosen_row(model) else { return Vec::new() };
        let Some(address) = row.forcible(model) else {
            return vec![ViewRequest::Message(
                "this cannot be forced: inputs and outputs of the controller can".to_owned(),
            )];
        };
        let now = row.cells(model).image;
        let other = match now.map(|value| value.0) {
            // An analogue channel is forced to its word.
            Some(word @ (Value::Word(_) | Value::Int(_))) => show::value(WireValue(word), &[]),
            level => {
                show::value(WireValue(Value::Bool(!level.and_then(Value::as_bool).unwrap_or(false))), &[])
            }
        };
        self.prompt(IoPrompt::Force(address.clone()), format!("Force {address} to"), other)
    }

    fn release(&self, model: &RigModel) -> Vec<ViewRequest> {
        let address = self.chosen_row(model).and_then(|row| row.forcible(model));
        match address.filter(|address| model.forced(address).is_some()) {
            Some(name) => vec![ViewRequest::Operation(RequestOperation::Release { name })],
            None => vec![ViewRequest::Message("this is not forced".to_owned())],
        }
    }

    fn release_all(model: &RigModel) -> Vec<ViewRequest> {
        match model.status.forced.len() {
            0 => vec![ViewRequest::Message("nothing is forced".to_owned())],
            count => {
                vec![ViewRequest::Confirm(
                    format!("Release all forces ({count})?"),
                    RequestOperation::ReleaseAll,
                )]
            }
        }
    }

    fn write(&mut self, model: &RigModel) -> Vec<ViewRequest> {
        let Some(row) = self.chosen_row(model) else { return Vec::new() };
        let (name, expected) = row.writable(model);
        let unit = if expected.duration { show::NANOSECONDS } else { "" };
        let now = row.cells(model).image;
        let now = now.map(|value| show::with_unit(value, &expected.labels, unit)).unwrap_or_default();
        let ask = format!("{name} :=");
        self.prompt(IoPrompt::Write(name, expected), ask, now)
    }

    /// The row at which the table begins, and how many are shown.
    fn window(&self) -> (usize, usize) {
        (self.first, usize::from(self.rows.height).max(1))
    }
}

impl View for IoView {
    fn name(&self) -> &'static str {
        "I/O"
    }

    fn keys(&self) -> Vec<(&'static str, &'static str)> {
        vec![
            ("f", "force"),
            ("r", "release"),
            ("R", "all"),
            ("w", "write"),
            ("/", "filter"),
            ("s", "sort"),
            ("v", "variables"),
            ("a", "add a name or address"),
            ("d", "drop an added one"),
            ("Up Down PgUp PgDn Home End", "move"),
            ("Esc", "no filter"),
        ]
    }

    fn shown(&mut self, shown: bool) {
        self.shown = shown;
    }

    fn signals(&self, model: &RigModel) -> Vec<(String, bool)> {
        if !self.shown {
            return Vec::new();
        }
        let rows = self.listed(model);
        let (first, count) = self.window();
        let window = rows.iter().skip(first).take(count);
        let points = (0..model.description.points.len()).map(IoRow::Point);
        let watched: Vec<IoRow> = if model.description.points.len() <= WATCHED {
            points.chain(window.filter(|row| !matches!(row, IoRow::Point(_))).cloned()).collect()
        } else {
            window.cloned().collect()
        };
        watched.iter().flat_map(|row| row.signals(model)).map(|name| (name, false)).collect()
    }

    fn draw(&mut self, frame: &mut Frame<'_>, area: Rect, model: &RigModel, features: TerminalFeatures) {
        let rows = self.listed(model);
        self.chosen = self.chosen.min(rows.len().saturating_sub(1));
        let mut canvas = Canvas::new(frame, area, features);
        let wide = area.width >= WIDE_FROM;
        let columns: &[CanvasColumn] = if wide { &WIDE } else { &COLUMNS };
        canvas::titles(&mut canvas, 0, columns);
        self.titles = title_places(columns, area);
        let height = area.height.saturating_sub(4);
        self.rows = Rect::new(area.x, area.y + 1, area.width, height);
        self.first = canvas::scrolled(self.first, self.chosen, usize::from(height.max(1)));
        for (row, place) in (self.first..rows.len()).take(usize::from(height)).enumerate() {
            let y = row as u16 + 1;
            let cells = rows[place].cells(model);
            let style = style(&cells, &canvas);
            let texts = if wide { wide_texts(&cells) } else { texts(&cells) };
            canvas::cells(&mut canvas, y, columns, texts, style);
            if let Some(share) = cells.share {
                let (x, width) = edge_columns(columns);
                canvas.bar(x, y, width, share, None, style);
            }
            if place == self.chosen {
                canvas.shade(y, canvas::chosen());
            }
        }
        if rows.is_empty() {
            canvas.text(1, 1, "No row has that in it: Esc ends the filter.", Style::new());
        }
        let all = rows::rows(model, self.variables, &self.named, "", Sort::Order).len();
        let filter =
            if self.filter.is_empty() { String::new() } else { format!(", filter `{}`", self.filter) };
        let title = format!("{} of {all}, by {}{filter}", rows.len(), self.sort.name());
        let foot = area.height.saturating_sub(3);
        canvas.rule(foot, &title);
        if let Some(row) = rows.get(self.chosen) {
            let (first, second) = about(row, model);
            canvas.text(1, foot + 1, &first, Style::new());
            canvas.text(1, foot + 2, &second, Style::new());
        }
    }

    fn key(&mut self, key: KeyEvent, model: &RigModel) -> Option<Vec<ViewRequest>> {
        let canvas = self.window().1;
        match key.code {
            KeyCode::Up => self.chosen = self.chosen.saturating_sub(1),
            KeyCode::Down => self.chosen = self.chosen.saturating_add(1),
            KeyCode::PageUp => self.chosen = self.chosen.saturating_sub(canvas),
            KeyCode::PageDown => self.chosen = self.chosen.saturating_add(canvas),
            KeyCode::Home => self.chosen = 0,
            KeyCode::End => self.chosen = usize::MAX,
            KeyCode::Char('f') => return Some(self.force(model)),
            KeyCode::Char('r') => return Some(self.release(model)),
            KeyCode::Char('R') => return Some(IoView::release_all(model)),
            KeyCode::Char('w') => return Some(self.write(model)),
            KeyCode::Char('s') => self.sort = self.sort.next(),
            KeyCode::Char('v') => self.variables = !self.variables,
            KeyCode::Char('/') => {
                let text = self.filter.clone();
                return Some(self.prompt(IoPrompt::Filter, "Rows with".to_owned(), text));
            }
            KeyCode::Char('a') => {
                let ask = "Name or address to look at".to_owned();
                return Some(self.prompt(IoPrompt::Name, ask, String::new()));
            }
            KeyCode::Char('d') => {
                if let Some(IoRow::Named(name)) = self.chosen_row(model) {
                    self.named.retain(|kept| *kept != name);
                }
            }
            KeyCode::Esc if !self.filter.is_empty() => self.filter.clear(),
            _ => return None,
        }
        self.chosen = self.chosen.min(self.listed(model).len().saturating_sub(1));
        Some(Vec::new())
    }

    fn mouse(&mut self, mouse: MouseEvent, model: &RigModel) -> Vec<ViewRequest> {
        let at = Position::new(mouse.column, mouse.row);
        match mouse.kind {
            MouseEventKind::Down(MouseButton::Left) => {
                if let Some((_, sort)) = self.titles.iter().find(|(area, _)| area.contains(at)) {
                    self.sort = if self.sort == *sort { Sort::Order } else { *sort };
                } else if self.rows.contains(at) {
                    let place = self.first + usize::from(mouse.row - self.rows.y);
                    if place < self.listed(model).len() {
                        self.chosen = place;
                    }
                }
            }
            MouseEventKind::ScrollUp => self.chosen = self.chosen.saturating_sub(WHEEL),
            MouseEventKind::ScrollDown => {
                let last = self.listed(model).len().saturating_sub(1);
                self.chosen = self.chosen.saturating_add(WHEEL).min(last);
            }
            _ => {}
        }
        Vec::new()
    }

    fn typed(&mut self, text: &str, _model: &RigModel) -> Vec<ViewRequest> {
        let text = text.trim();
        let asked = match self.prompt_for.take() {
            Some(IoPrompt::Filter) => {
                self.filter = text.to_owned();
                self.chosen = 0;
                return Vec::new();
            }
            Some(IoPrompt::Name) => {
                if !text.is_empty() && !self.named.iter().any(|name| name == text) {
                    self.named.push(text.to_owned());
                }
                return Vec::new();
            }
            Some(IoPrompt::Force(name)) => input_value::value(text, &ExpectedInput::at(&name))
                .map(|value| RequestOperation::Force { name, value }),
            Some(IoPrompt::Write(name, expected)) => {
                input_value::value(text, &expected).map(|value| RequestOperation::Write { name, value })
            }
            None => return Vec::new(),
        };
        vec![match asked {
            Ok(ask) => ViewRequest::Operation(ask),
            Err(message) => ViewRequest::Message(message),
        }]
    }
}

/// Where titles stand that sort when they are clicked.
fn title_places(columns: &[CanvasColumn], area: Rect) -> Vec<(Rect, Sort)> {
    let mut x = area.x + 1;
    let mut places = Vec::new();
    for column in columns {
        let sort = match column.title {
            "Name" => Some(Sort::Name),
            "Address" => Some(Sort::Address),
            "Variable" => Some(Sort::Variable),
            "Image" => Some(Sort::Value),
            "Edges" | "Rising" | "Falling" => Some(Sort::Edges),
            "Driver" | "Health" | "Forced by" => Some(Sort::Trouble),
            _ => None,
        };
        places.extend(sort.map(|sort| (Rect::new(x, area.y, column.width, 1), sort)));
        x += column.width + 1;
    }
    places
}

/// What is lost comes before what is forced.
fn style(cells: &Cells, canvas: &Canvas<'_>) -> Style {
    if cells.lost {
        canvas.alarm()
    } else if cells.forced {
        canvas.tint(Color::Yellow).add_modifier(Modifier::BOLD)
    } else {
        Style::new()
    }
}

fn mark(cells: &Cells) -> &'static str {
    match (cells.lost, cells.forced) {
        (true, _) => "!",
        (false, true) => "F",
        (false, false) => "",
    }
}

fn edges(cells: &Cells, of: u64) -> String {
    if has_edges(cells) { of.to_string() } else { String::new() }
}

/// An analogue channel has a bar in their place.
fn has_edges(cells: &Cells) -> bool {
    cells.is_point && cells.share.is_none()
}

/// Where the columns of the edges begin, and how wide they are.
fn edge_columns(columns: &[CanvasColumn]) -> (u16, u16) {
    let is_of_edges = |column: &&CanvasColumn| matches!(column.title, "Edges" | "Rising" | "Falling");
    let before = columns.iter().take_while(|column| !is_of_edges(column));
    let x = before.map(|column| column.width + 1).sum::<u16>() + 1;
    let width = columns.iter().filter(is_of_edges).map(|column| column.width + 1).sum::<u16>();
    (x, width.saturating_sub(1))
}

fn texts(cells: &Cells) -> Vec<String> {
    let both = format!("{}/{}", cells.edges.rising, cells.edges.falling);
    vec![
        mark(cells).to_owned(),
        cells.name.clone(),
        cells.address.clone(),
        cells.variable.clone(),
        cells.meaning.as_ref().unwrap_or(&cells.image_text).clone(),
        cells.line_text.clone(),
        if has_edges(cells) { both } else { String::new() },
        if cells.lost { format!("! {}", cells.driver) } else { cells.driver.clone() },
    ]
}

fn wide_texts(cells: &Cells) -> Vec<String> {
    vec![
        mark(cells).to_owned(),
        cells.name.clone(),
        cells.address.clone(),
        cells.variable.clone(),
        cells.direction.to_owned(),
        cells.image_text.clone(),
        cells.line_text.clone(),
        edges(cells, cells.edges.rising),
        edges(cells, cells.edges.falling),
        cells.driver.clone(),
        cells.health.clone(),
        cells.by.clone(),
    ]
}

/// All about a row, in two lines.
fn about(row: &IoRow, model: &RigModel) -> (String, String) {
    let cells = row.cells(model);
    let words = [&cells.name, &cells.address, &cells.variable];
    let names: Vec<&str> = words.into_iter().map(String::as_str).filter(|word| !word.is_empty()).collect();
    let names = names.join("  ");
    let IoRow::Point(place) = row else {
        return (format!("{names} = {}", cells.image_text), String::new());
    };
    let point = &model.description.points[*place];
    let forced = match (cells.forced, cells.by.is_empty()) {
        (false, _) => String::new(),
        (true, true) => "  FORCED".to_owned(),
        (true, false) => format!("  FORCED by {}", cells.by),
    };
    let first =
        format!("{names}  {}  image {}  line {}{forced}", cells.direction, cells.image_text, cells.line_text);
    let Some(channel) = &point.channel else { return (first, "no channel is bound to it".to_owned()) };
    let mut second = format!("channel {}", channel.name);
    match channel.device.and_then(|place| model.description.devices.get(place)) {
        None => second.push_str(", simulated"),
        Some(device) => {
            let place = if device.path.is_empty() { String::new() } else { format!(" {}", device.path) };
            second.push_str(&format!(" on {} ({}{place}): {}", device.name, device.kind, cells.health));
        }
    }
    (first, second)
}
