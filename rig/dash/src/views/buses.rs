//! The buses: their states and counters, and the frames on them.

use super::{View, ViewRequest};
use crate::canvas::{self, Canvas, CanvasColumn, column};
use crate::frame_decoder::{DecodedFrame, FrameDecoder};
use crate::glyphs::TerminalFeatures;
use crate::model::{KEPT, RigModel};
use crate::recording::TrendFiles;
use crate::show;
use control::{BusInfo, BusStatus, FrameSeen, ModuleInfo};
use ratatui::Frame;
use ratatui::crossterm::event::{KeyCode, KeyEvent, MouseEvent, MouseEventKind};
use ratatui::layout::Rect;
use ratatui::style::Style;
use std::collections::BTreeMap;
use std::rc::Rc;

const BUSES: [CanvasColumn; 8] = [
    column("Bus", 14, false, 0),
    column("Kind", 7, false, 0),
    column("Settings", 18, false, 0),
    column("State", 14, false, 0),
    column("Received", 9, true, 0),
    column("Sent", 9, true, 0),
    column("Errors", 9, true, 110),
    column("Dropped", 9, true, 110),
];

const MODULES: [CanvasColumn; 4] = [
    column("Module", 14, false, 0),
    column("Index", 7, true, 0),
    column("", 10, false, 0),
    column("State", 22, false, 0),
];

/// Counters that a narrow screen has no columns for stand below the table where they are not 0.
const WIDE: u16 = 110;

/// How frames are listed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum FrameOrder {
    /// One below the other, as they came.
    #[default]
    Chronological,
    /// The last one of each identifier, with how many there were and how far apart.
    PerIdentifier,
}

/// How data are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum DataFormat {
    #[default]
    Hex,
    Text,
    /// By a description of the frames.
    Decoded,
}

/// What the user is typing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum BusPrompt {
    #[default]
    Filter,
    Description,
}

/// The view of the buses.
#[derive(Debug)]
pub struct BusesView {
    files: Rc<dyn TrendFiles>,
    /// What frames mean, and the file that says it.
    decoder: Option<(String, Box<dyn FrameDecoder>)>,
    format: DataFormat,
    prompt: BusPrompt,
    shown: bool,
    list: FrameOrder,
    /// What frames have to match, as it was typed.
    filter: String,
    /// The frames that are looked at while new ones pass by unseen.
    held: Option<Vec<FrameSeen>>,
    /// Rows from the newest frame, or from the first identifier.
    back: usize,
    /// Rows of frames that were drawn last.
    rows: usize,
}

impl View for BusesView {
    fn name(&self) -> &'static str {
        "Buses"
    }

    fn keys(&self) -> Vec<(&'static str, &'static str)> {
        vec![
            ("/", "filter"),
            ("Space", if self.held.is_some() { "go on" } else { "hold" }),
            ("o", if self.list == FrameOrder::Chronological { "one line per id" } else { "every frame" }),
            ("x", self.next_format().1),
            ("d", "DBC file"),
            ("Up/Down", "scroll"),
        ]
    }

    fn signals(&self, _model: &RigModel) -> Vec<(String, bool)> {
        Vec::new()
    }

    fn shown(&mut self, shown: bool) {
        self.shown = shown;
    }

    fn wants_frames(&self) -> bool {
        self.shown
    }

    fn draw(&mut self, frame: &mut Frame<'_>, area: Rect, model: &RigModel, features: TerminalFeatures) {
        let mut canvas = Canvas::new(frame, area, features);
        let above = draw_modules(&mut canvas, &model.description.modules, &model.status.modules);
        if model.description.buses.is_empty() {
            canvas.text(1, above, "The board has no buses.", Style::new());
            return;
        }
        let below = draw_buses(&mut canvas, above, &model.description.buses, &model.status.buses);
        let height = canvas.height().saturating_sub(below);
        let mut rest = canvas.part(0, below, area.width, height);
        let held = if self.held.is_some() { ", held" } else { "" };
        let filter = if self.filter.is_empty() { String::new() } else { format!(", only `{}`", self.filter) };
        let by = match (&self.decoder, self.format) {
            (Some((path, _)), DataFormat::Decoded) => format!(" by {path}"),
            _ => String::new(),
        };
        rest.rule(0, &format!("Frames{by}{filter}{held}"));
        self.rows = usize::from(height.saturating_sub(2));
        let all: Box<dyn DoubleEndedIterator<Item = &FrameSeen>> = match &self.held {
            Some(held) => Box::new(held.iter()),
            None => Box::new(model.frames.iter()),
        };
        let wanted: Vec<&FrameSeen> = all.filter(|frame| matches(frame, &self.filter)).collect();
        self.back = match self.list {
            FrameOrder::Chronological => self.draw_chronological(&mut rest, &wanted),
            FrameOrder::PerIdentifier => self.draw_per_identifier(&mut rest, &wanted),
        };
    }

    fn key(&mut self, key: KeyEvent, model: &RigModel) -> Option<Vec<ViewRequest>> {
        match key.code {
            KeyCode::Char('/') => {
                self.prompt = BusPrompt::Filter;
                return Some(vec![ViewRequest::Prompt {
                    ask: "Only frames with this bus, id or data: ".to_owned(),
                    text: self.filter.clone(),
                }]);
            }
            KeyCode::Char(' ') => {
                self.held = match self.held {
                    Some(_) => None,
                    None => Some(model.frames.iter().cloned().collect()),
                };
                self.back = 0;
            }
            KeyCode::Char('o') => {
                self.list = if self.list == FrameOrder::Chronological {
                    FrameOrder::PerIdentifier
                } else {
                    FrameOrder::Chronological
                };
                self.back = 0;
            }
            KeyCode::Char('x') => self.format = self.next_format().0,
            KeyCode::Char('d') => {
                self.prompt = BusPrompt::Description;
                let text = self.decoder.as_ref().map_or(String::new(), |(path, _)| path.clone());
                return Some(vec![ViewRequest::Prompt { ask: "DBC file (empty: none): ".to_owned(), text }]);
            }
            KeyCode::Up => self.scroll(true, 1, model),
            KeyCode::Down => self.scroll(false, 1, model),
            KeyCode::PageUp => self.scroll(true, self.rows, model),
            KeyCode::PageDown => self.scroll(false, self.rows, model),
            KeyCode::Home if self.list == FrameOrder::PerIdentifier => self.back = 0,
            KeyCode::End if self.list == FrameOrder::Chronological => self.back = 0,
            _ => return None,
        }
        Some(Vec::new())
    }

    fn mouse(&mut self, mouse: MouseEvent, model: &RigModel) -> Vec<ViewRequest> {
        match mouse.kind {
            MouseEventKind::ScrollUp => self.scroll(true, 3, model),
            MouseEventKind::ScrollDown => self.scroll(false, 3, model),
            _ => {}
        }
        Vec::new()
    }

    fn typed(&mut self, text: &str, _model: &RigModel) -> Vec<ViewRequest> {
        let text = text.trim();
        match self.prompt {
            BusPrompt::Filter => {
                self.filter = text.to_owned();
                self.back = 0;
            }
            BusPrompt::Description if text.is_empty() => {
                self.decoder = None;
                self.format = DataFormat::Hex;
            }
            BusPrompt::Description => match self.files.decoder(text) {
                Ok(decoder) => {
                    self.decoder = Some((text.to_owned(), decoder));
                    self.format = DataFormat::Decoded;
                }
                Err(fault) => return vec![ViewRequest::Fault(fault)],
            },
        }
        Vec::new()
    }
}

impl BusesView {
    /// Buses of which nothing is known yet.
    pub fn new(files: Rc<dyn TrendFiles>) -> BusesView {
        BusesView {
            files,
            decoder: None,
            format: DataFormat::Hex,
            prompt: BusPrompt::Filter,
            shown: false,
            list: FrameOrder::Chronological,
            filter: String::new(),
            held: None,
            back: 0,
            rows: 0,
        }
    }

    /// The form after this one, and what it is called.
    fn next_format(&self) -> (DataFormat, &'static str) {
        match self.format {
            DataFormat::Hex => (DataFormat::Text, "text"),
            DataFormat::Text if self.decoder.is_some() => (DataFormat::Decoded, "meaning"),
            DataFormat::Text | DataFormat::Decoded => (DataFormat::Hex, "hex"),
        }
    }

    /// Up or down the list.
    fn scroll(&mut self, up: bool, rows: usize, model: &RigModel) {
        // The course stands on its newest frame, the identifiers begin with the first.
        let away = up == (self.list == FrameOrder::Chronological);
        // Frames that come meanwhile would push older ones along, so they are held.
        if away && self.list == FrameOrder::Chronological && self.held.is_none() {
            self.held = Some(model.frames.iter().cloned().collect());
        }
        self.back = if away { (self.back + rows).min(KEPT) } else { self.back.saturating_sub(rows) };
    }

    /// Draws the newest frames but some; the row from which they were really drawn.
    fn draw_chronological(&self, canvas: &mut Canvas<'_>, wanted: &[&FrameSeen]) -> usize {
        let columns = [
            column("Time [s]", 12, true, 0),
            column("Bus", 10, false, 0),
            column("", 4, false, 0),
            column("Id", 8, true, 0),
            column("Len", 3, true, 0),
            column("Data", canvas.width().saturating_sub(44), false, 0),
        ];
        canvas::titles(canvas, 1, &columns);
        let back = self.back.min(wanted.len().saturating_sub(self.rows));
        let end = wanted.len() - back;
        for (row, frame) in wanted[end.saturating_sub(self.rows)..end].iter().enumerate() {
            let style = style_of(canvas, frame);
            canvas::cells(
                canvas,
                row as u16 + 2,
                &columns,
                [
                    show::seconds(frame.at, 6),
                    frame.bus.clone(),
                    if frame.sent { "sent" } else { "" }.to_owned(),
                    frame.id.clone(),
                    (frame.data.len() / 2).to_string(),
                    self.data(frame),
                ],
                style,
            );
        }
        back
    }

    /// Draws the identifiers but some; the row from which they were really drawn.
    fn draw_per_identifier(&self, canvas: &mut Canvas<'_>, wanted: &[&FrameSeen]) -> usize {
        let columns = [
            column("Bus", 10, false, 0),
            column("", 4, false, 0),
            column("Id", 8, true, 0),
            column("Count", 7, true, 0),
            column("Every", 9, true, 0),
            column("Len", 3, true, 0),
            column("Data", canvas.width().saturating_sub(49), false, 0),
        ];
        canvas::titles(canvas, 1, &columns);
        let mut each: BTreeMap<(&str, bool, usize, &str), IdentifierFrames<'_>> = BTreeMap::new();
        for frame in wanted {
            // Shorter identifiers first: the order of numbers.
            each.entry((&frame.bus, frame.sent, frame.id.len(), &frame.id))
                .and_modify(|each| {
                    each.every = Some(frame.at.saturating_sub(each.last.at));
                    each.count += 1;
                    each.last = frame;
                })
                .or_insert(IdentifierFrames { last: frame, count: 1, every: None });
        }
        let back = self.back.min(each.len().saturating_sub(self.rows));
        for (row, each) in each.values().skip(back).take(self.rows).enumerate() {
            let frame = each.last;
            let style = style_of(canvas, frame);
            canvas::cells(
                canvas,
                row as u16 + 2,
                &columns,
                [
                    frame.bus.clone(),
                    if frame.sent { "sent" } else { "" }.to_owned(),
                    frame.id.clone(),
                    each.count.to_string(),
                    each.every.map_or("-".to_owned(), show::span),
                    (frame.data.len() / 2).to_string(),
                    self.data(frame),
                ],
                style,
            );
        }
        back
    }

    /// The bytes of a frame with its flags.
    fn data(&self, frame: &FrameSeen) -> String {
        let decoded = match (&self.decoder, self.format) {
            (Some((_, decoder)), DataFormat::Decoded) => decoder.decode(frame),
            _ => None,
        };
        let mut text = match (decoded, self.format) {
            (Some(decoded), _) => text_of(&decoded),
            (None, DataFormat::Text) => characters(&frame.data),
            (None, _) => spaced(&frame.data),
        };
        for flag in &frame.flags {
            text = if text.is_empty() { format!("[{flag}]") } else { format!("{text} [{flag}]") };
        }
        text
    }
}

/// All frames of one identifier.
struct IdentifierFrames<'a> {
    last: &'a FrameSeen,
    count: u64,
    every: Option<i64>,
}

fn style_of(canvas: &Canvas<'_>, frame: &FrameSeen) -> Style {
    let wrong = ["error", "parity", "framing", "damaged", "overrun", "break", "bus-off"];
    let wrong = frame.flags.iter().any(|flag| wrong.contains(&flag.as_str()));
    if wrong { canvas.alarm() } else { Style::new() }
}

/// The table of the expansion modules, if there are any; the row after it.
fn draw_modules(canvas: &mut Canvas<'_>, infos: &[ModuleInfo], states: &[String]) -> u16 {
    if infos.is_empty() {
        return 0;
    }
    canvas::titles(canvas, 0, &MODULES);
    let mut y = 1;
    for (info, state) in infos.iter().zip(states) {
        let style = if state == "TM3_OK" { Style::new() } else { canvas.alarm() };
        let optional = if info.optional { "optional" } else { "" };
        let cells = [info.reference.clone(), info.index.to_string(), optional.to_owned(), state.clone()];
        canvas::cells(canvas, y, &MODULES, cells, style);
        y += 1;
    }
    y + 1
}

/// The table of the buses, from a row on; the row after it.
fn draw_buses(canvas: &mut Canvas<'_>, from: u16, infos: &[BusInfo], statuses: &[BusStatus]) -> u16 {
    canvas::titles(canvas, from, &BUSES);
    let mut y = from + 1;
    for (info, status) in infos.iter().zip(statuses) {
        let sound = matches!(status.state.as_str(), "error-active" | "open" | "");
        let style = if sound && status.errors + status.dropped == 0 { Style::new() } else { canvas.alarm() };
        canvas::cells(
            canvas,
            y,
            &BUSES,
            [
                info.name.clone(),
                info.kind.clone(),
                info.settings.clone(),
                status.state.clone(),
                status.received.to_string(),
                status.sent.to_string(),
                status.errors.to_string(),
                status.dropped.to_string(),
            ],
            style,
        );
        y += 1;
        if canvas.width() < WIDE && status.errors + status.dropped > 0 {
            let text = format!("{} errors, {} dropped", status.errors, status.dropped);
            canvas.text(16, y, &text, style);
            y += 1;
        }
    }
    y
}

/// Whether a frame has a text in its bus's name, its identifier, its flags or its data, in hexadecimal with or without
/// spaces, or as characters. Upper and lower case are the same.
fn matches(frame: &FrameSeen, filter: &str) -> bool {
    if filter.is_empty() {
        return true;
    }
    let filter = filter.to_ascii_lowercase();
    let bytes: String = filter.chars().filter(|letter| *letter != ' ').collect();
    frame.bus.to_ascii_lowercase().contains(&filter)
        || frame.id.to_ascii_lowercase().contains(&filter)
        || frame.flags.iter().any(|flag| flag.to_ascii_lowercase().contains(&filter))
        || aligned(&frame.data.to_ascii_lowercase(), &bytes)
        || characters(&frame.data).to_ascii_lowercase().contains(&filter)
}

/// Whether bytes in hexadecimal hold others; a byte's second digit does not begin one.
fn aligned(data: &str, bytes: &str) -> bool {
    data.match_indices(bytes).any(|(at, _)| at % 2 == 0)
}

/// What a frame says, in one line.
fn text_of(decoded: &DecodedFrame) -> String {
    let fields: Vec<String> = decoded.fields.iter().map(|(name, value)| format!("{name}={value}")).collect();
    format!("{}: {}", decoded.name, fields.join(" "))
}

/// Bytes with a space between two.
fn spaced(data: &str) -> String {
    let mut text = String::with_capacity(data.len() * 3 / 2);
    for (place, digit) in data.chars().enumerate() {
        if place > 0 && place % 2 == 0 {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

/// Bytes as characters, with a dot for those that are none.
fn characters(data: &str) -> String {
    let digits: Vec<u32> = data.chars().filter_map(|digit| digit.to_digit(16)).collect();
    digits
        .chunks(2)
        .map(|pair| pair.iter().fold(0, |byte, digit| byte * 16 + digit))
        .map(|byte| char::from_u32(byte).filter(|c| c.is_ascii_graphic() || *c == ' ').unwrap_or('.'))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(id: &str, data: &str) -> FrameSeen {
        let (bus, id, data) = ("drive".to_owned(), id.to_owned(), data.to_owned());
        FrameSeen { bus, at: 0, sent: false, id, flags: vec!["fd".to_owned()], data }
    }

    #[test]
    fn a_filter_finds_bus_id_flag_and_bytes() {
        let seen = frame("18F", "014142FF");
        for found in ["", "DRIVE", "8f", "FD", "41 42", "4142", "ff", "ab"] {
            assert!(matches(&seen, found), "{found}");
        }
        for other in ["7", "14 14", "1414", "brs"] {
            assert!(!matches(&seen, other), "{other}");
        }
    }

    #[test]
    fn bytes_are_shown_as_they_are() {
        assert_eq!(spaced("014142F"), "01 41 42 F");
        assert_eq!(characters("014142FF2"), ".AB..");
    }
}
