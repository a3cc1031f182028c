//! The plans: choose one, run it, follow it.

mod limit_bar;
mod progress;

use super::{View, ViewRequest};
use crate::canvas::{self, Canvas};
use crate::glyphs::TerminalFeatures;
use crate::model::RigModel;
use crate::show;
use control::RequestOperation;
use progress::{CaseProgress, PlanProgress, StepProgress};
use ratatui::Frame;
use ratatui::crossterm::event::{KeyCode, KeyEvent, MouseButton, MouseEvent, MouseEventKind};
use ratatui::layout::Rect;
use ratatui::style::Style;

/// What the user is typing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum PlanPrompt {
    #[default]
    Filter,
    Folder,
}

/// The view of the plans.
#[derive(Debug, Default)]
pub struct PlanView {
    /// The list is looked at; else the course of the plan.
    list: bool,
    typing: PlanPrompt,
    filter: String,
    /// The chosen case of the list.
    chosen: usize,
    first: usize,
    /// The case of the course that is looked at; the newest where there is none.
    case: Option<usize>,
    /// Rows of its details that were scrolled away.
    down: usize,
    /// Where the rows of the list or of the cases were drawn, and which was first.
    rows: Rect,
    top: usize,
}

impl View for PlanView {
    fn name(&self) -> &'static str {
        "Plan"
    }

    fn keys(&self) -> Vec<(&'static str, &'static str)> {
        if self.list {
            vec![("Enter", "run"), ("/", "filter"), ("o", "open a folder"), ("l", "course")]
        } else {
            vec![("l", "plans"), ("x", "abort"), ("Up/Down", "case"), ("PgUp/PgDn", "details")]
        }
    }

    fn opened(&mut self, model: &RigModel) -> Vec<ViewRequest> {
        self.list = model.status.plan.is_none() && model.plan.is_empty();
        if model.plans.is_none() {
            vec![ViewRequest::Operation(RequestOperation::Plans { path: None })]
        } else {
            Vec::new()
        }
    }

    fn signals(&self, _model: &RigModel) -> Vec<(String, bool)> {
        Vec::new()
    }

    fn draw(&mut self, frame: &mut Frame<'_>, area: Rect, model: &RigModel, features: TerminalFeatures) {
        let mut canvas = Canvas::new(frame, area, features);
        if self.list {
            self.draw_list(&mut canvas, model);
        } else {
            self.draw_course(&mut canvas, model);
        }
    }

    fn key(&mut self, key: KeyEvent, model: &RigModel) -> Option<Vec<ViewRequest>> {
        match key.code {
            KeyCode::Char('l') => self.list = !self.list,
            KeyCode::Char('x') if model.status.plan.is_some() => {
                let question = "Abort the plan? The controller restarts.".to_owned();
                return Some(vec![ViewRequest::Confirm(question, RequestOperation::Abort)]);
            }
            KeyCode::Char('o') => {
                self.typing = PlanPrompt::Folder;
                let ask = "Plans in this file or folder (empty: those that ship): ".to_owned();
                return Some(vec![ViewRequest::Prompt { ask, text: String::new() }]);
            }
            KeyCode::Char('/') if self.list => {
                self.typing = PlanPrompt::Filter;
                let ask = "Only plans with: ".to_owned();
                return Some(vec![ViewRequest::Prompt { ask, text: self.filter.clone() }]);
            }
            KeyCode::Enter if self.list => return Some(self.run(model)),
            KeyCode::Up => self.step(-1, model),
            KeyCode::Down => self.step(1, model),
            KeyCode::PageUp => self.scroll_page(-10, model),
            KeyCode::PageDown => self.scroll_page(10, model),
            KeyCode::End if !self.list => self.case = None,
            _ => return None,
        }
        Some(Vec::new())
    }

    fn mouse(&mut self, mouse: MouseEvent, model: &RigModel) -> Vec<ViewRequest> {
        let inside = self.rows.contains((mouse.column, mouse.row).into());
        match mouse.kind {
            MouseEventKind::Down(MouseButton::Left) if inside => {
                let place = self.top + usize::from(mouse.row - self.rows.y);
                if self.list {
                    self.chosen = place;
                } else {
                    self.case = Some(place);
                    self.down = 0;
                }
            }
            MouseEventKind::ScrollUp => self.step(-1, model),
            MouseEventKind::ScrollDown => self.step(1, model),
            _ => {}
        }
        Vec::new()
    }

    fn typed(&mut self, text: &str, _model: &RigModel) -> Vec<ViewRequest> {
        let text = text.trim();
        match self.typing {
            PlanPrompt::Filter => self.filter = text.to_owned(),
            PlanPrompt::Folder => {
                self.list = true;
                let path = (!text.is_empty()).then(|| text.to_owned());
                return vec![ViewRequest::Operation(RequestOperation::Plans { path })];
            }
        }
        Vec::new()
    }
}

impl PlanView {
    /// The plans that the filter lets through.
    fn wanted<'a>(&self, model: &'a RigModel) -> Vec<&'a str> {
        let filter = self.filter.to_lowercase();
        let plans = model.plans.iter().flatten();
        plans.map(String::as_str).filter(|name| name.to_lowercase().contains(&filter)).collect()
    }

    fn run(&mut self, model: &RigModel) -> Vec<ViewRequest> {
        if model.status.plan.is_some() {
            return vec![ViewRequest::Message("A plan runs already; x aborts it.".to_owned())];
        }
        let Some(name) = self.wanted(model).get(self.chosen).map(|name| (*name).to_owned()) else {
            return Vec::new();
        };
        self.list = false;
        self.case = None;
        let question = format!(
            "Run `{name}` on the board? The controller stops with safe outputs, the plan moves the outputs, and the \
             controller restarts."
        );
        vec![ViewRequest::Confirm(question, RequestOperation::Plan { name })]
    }

    /// Up or down the list, or the cases.
    fn step(&mut self, by: isize, model: &RigModel) {
        if self.list {
            let last = self.wanted(model).len().saturating_sub(1);
            self.chosen = self.chosen.saturating_add_signed(by).min(last);
            return;
        }
        let last = PlanProgress::of(&model.plan).cases.len().saturating_sub(1);
        let to = self.case.unwrap_or(last).saturating_add_signed(by).min(last);
        // At the end the newest is followed again.
        self.case = (to < last).then_some(to);
        self.down = 0;
    }

    fn scroll_page(&mut self, by: isize, model: &RigModel) {
        if self.list {
            self.step(by, model);
        } else {
            self.down = self.down.saturating_add_signed(by);
        }
    }

    fn draw_list(&mut self, canvas: &mut Canvas<'_>, model: &RigModel) {
        let filter = if self.filter.is_empty() { String::new() } else { format!(" with `{}`", self.filter) };
        let Some(plans) = &model.plans else {
            canvas.text(1, 0, "The rig has no plans. o: open those of a file or folder.", Style::new());
            return;
        };
        let wanted = self.wanted(model);
        canvas.rule(0, &format!("{} of {} plans{filter}", wanted.len(), plans.len()));
        self.chosen = self.chosen.min(wanted.len().saturating_sub(1));
        let height = canvas.height().saturating_sub(1);
        self.first = canvas::scrolled(self.first, self.chosen, usize::from(height));
        self.top = self.first;
        self.rows = canvas.part(0, 1, canvas.width(), height).area();
        for (row, name) in wanted.iter().skip(self.first).take(usize::from(height)).enumerate() {
            let y = row as u16 + 1;
            canvas.text(1, y, name, Style::new());
            if self.first + row == self.chosen {
                canvas.shade(y, canvas::chosen());
            }
        }
    }

    fn draw_course(&mut self, canvas: &mut Canvas<'_>, model: &RigModel) {
        let course = PlanProgress::of(&model.plan);
        if course.cases.is_empty() {
            let text = match &model.status.plan {
                Some(plan) => format!("`{}` begins.", plan.name),
                None => "No plan ran yet: l lists the plans.".to_owned(),
            };
            canvas.text(1, 0, &text, Style::new());
            return;
        }
        draw_progress(canvas, &course, model);
        let shown = self.case.unwrap_or(course.cases.len() - 1).min(course.cases.len() - 1);
        let left = (canvas.width() * 2 / 5).min(60);
        let (width, height) = (canvas.width(), canvas.height().saturating_sub(2));
        let mut cases = canvas.part(0, 2, left, height);
        cases.rule(0, "Cases");
        let room = usize::from(height.saturating_sub(1));
        self.top = canvas::scrolled(self.top.min(course.cases.len().saturating_sub(room)), shown, room);
        self.rows = cases.part(0, 1, left, height.saturating_sub(1)).area();
        for (row, case) in course.cases.iter().skip(self.top).take(room).enumerate() {
            let y = row as u16 + 1;
            let verdict = case.end.as_ref().map_or("runs", |end| end.verdict);
            let style = style_of(&cases, verdict);
            let x = cases.text_in(1, y, 7, word(verdict), style);
            cases.text(x.max(8) + 1, y, case.name, Style::new());
            if self.top + row == shown {
                cases.shade(y, canvas::chosen());
            }
        }
        let mut details = canvas.part(left + 1, 2, width.saturating_sub(left + 1), height);
        self.down = draw_case(&mut details, &course.cases[shown], self.down);
    }
}

/// How far the plan is, and how it went by now.
fn draw_progress(canvas: &mut Canvas<'_>, course: &PlanProgress<'_>, model: &RigModel) {
    let place = course.cases.last().map_or((0, 0), |case| case.place);
    let name = model.status.plan.as_ref().map_or("", |plan| plan.name.as_str());
    let ended = course.cases.iter().filter(|case| case.end.is_some()).count();
    let tally: Vec<String> =
        course.tally().iter().map(|(verdict, count)| format!("{count} {verdict}")).collect();
    let share = if course.over.is_some() {
        1.0
    } else {
        f64::from(place.0.saturating_sub(1)) / f64::from(place.1.max(1))
    };
    let bar = canvas.width() / 4;
    canvas.bar(1, 0, bar, share, None, Style::new());
    let x = canvas.text(bar + 2, 0, &format!("case {} of {}", place.0, place.1), canvas::bold());
    canvas.text(x + 2, 0, &if ended > 0 { tally.join(", ") } else { name.to_owned() }, Style::new());
    match course.over {
        Some((verdict, report)) => {
            let style = style_of(canvas, verdict);
            let x = canvas.text(1, 1, &format!("Over: {verdict}"), style.patch(canvas::bold()));
            if let Some(report) = report {
                canvas.text(x + 2, 1, &format!("report: {report}"), Style::new());
            }
        }
        None if model.status.plan.is_none() => {
            canvas.text(1, 1, "It ended before its last case: no more is reported.", canvas.alarm());
        }
        None => {
            canvas.text(1, 1, &format!("Running {name}"), Style::new());
        }
    }
}

/// A row of a case's details.
enum DetailRow<'a> {
    Rule(&'a str),
    Text(String, Style),
    Band(&'a control::Measured),
}

/// Draws steps, claims and measurements of a case from a row on; the row that it was really drawn from.
fn draw_case(canvas: &mut Canvas<'_>, case: &CaseProgress<'_>, down: usize) -> usize {
    let plain = Style::new();
    let mut rows = vec![DetailRow::Rule(case.name)];
    let verdict_of = |name: &str| {
        let claims = case.end.iter().flat_map(|end| end.claims);
        let measured = case.end.iter().flat_map(|end| end.measured).find(|one| one.name == name);
        claims
            .into_iter()
            .find(|(claim, ..)| claim == name)
            .map(|(_, verdict, why)| (verdict.as_str(), why.as_str()))
            .or(measured.map(|one| (one.verdict.as_str(), "")))
    };
    if let Some(end) = &case.end {
        let style = style_of(canvas, end.verdict).patch(canvas::bold());
        rows.push(DetailRow::Text(format!("{}: {}", end.verdict, end.reason), style));
    }
    let now = (canvas.features.utf8, case.end.is_none());
    for ((name, what), step) in case.steps.iter().zip(case.progress()) {
        let (mark, at) = match step {
            StepProgress::Pending => (' ', String::new()),
            StepProgress::Started(at) => (if now == (true, true) { '▶' } else { '>' }, show::span(at)),
            StepProgress::Done(at) => (if now.0 { '✓' } else { '+' }, show::span(at)),
        };
        let style = if step == StepProgress::Pending { canvas.dim() } else { plain };
        rows.push(DetailRow::Text(format!("{mark} {at:>9}  {name}: {what}"), style));
    }
    if !case.claims.is_empty() {
        rows.push(DetailRow::Rule("Claims"));
    }
    for (name, what) in case.claims {
        match verdict_of(name) {
            None => rows.push(DetailRow::Text(format!("{:7} {name}: {what}", ""), plain)),
            Some((verdict, why)) => {
                let style = style_of(canvas, verdict);
                rows.push(DetailRow::Text(format!("{:7} {name}: {what}", word(verdict)), style));
                if verdict != "pass" && !why.is_empty() {
                    rows.push(DetailRow::Text(format!("{:10}{why}", ""), style));
                }
            }
        }
    }
    let measured = case.end.as_ref().map_or(&[][..], |end| end.measured);
    if !measured.is_empty() {
        rows.push(DetailRow::Rule("Measured"));
    }
    for one in measured {
        let style = style_of(canvas, &one.verdict);
        rows.push(DetailRow::Text(
            format!("{:7} {}: {}", word(&one.verdict), one.name, limit_bar::words(one)),
            style,
        ));
        rows.push(DetailRow::Band(one));
    }
    let width = usize::from(canvas.width().saturating_sub(2));
    let rows: Vec<DetailRow<'_>> = rows.into_iter().flat_map(|row| wrapped(row, width)).collect();
    let down = down.min(rows.len().saturating_sub(usize::from(canvas.height())));
    for (y, row) in (0..canvas.height()).zip(&rows[down..]) {
        match row {
            DetailRow::Rule(title) => canvas.rule(y, title),
            DetailRow::Text(text, style) => {
                canvas.text(1, y, text, *style);
            }
            DetailRow::Band(measured) => {
                limit_bar::draw(canvas, 9, y, canvas.width().saturating_sub(11), measured)
            }
        }
    }
    down
}

/// A row in as many as it needs; those after the first are indented.
fn wrapped(row: DetailRow<'_>, width: usize) -> Vec<DetailRow<'_>> {
    const SET_IN: usize = 10;
    let DetailRow::Text(text, style) = row else { return vec![row] };
    if text.chars().count() <= width || width < 2 * SET_IN {
        return vec![DetailRow::Text(text, style)];
    }
    let mut lines = Vec::new();
    let mut rest: Vec<char> = text.chars().collect();
    loop {
        let set_in = if lines.is_empty() { 0 } else { SET_IN };
        let room = width - set_in;
        // At the last blank, else within a word.
        let fits = rest.len() <= room;
        let blank = rest.iter().take(room + 1).rposition(|c| *c == ' ').filter(|at| *at > SET_IN);
        let end = if fits { rest.len() } else { blank.unwrap_or(room) };
        let line: String = rest.drain(..end).collect();
        lines.push(DetailRow::Text(format!("{:set_in$}{line}", ""), style));
        if fits {
            return lines;
        }
        if rest.first() == Some(&' ') {
            rest.remove(0);
        }
    }
}

fn style_of(canvas: &Canvas<'_>, verdict: &str) -> Style {
    match verdict {
        "pass" => canvas.good(),
        "fail" | "error" => canvas.alarm(),
        "inconclusive" => canvas::bold(),
        _ => Style::new(),
    }
}

/// A verdict in seven letters.
fn word(verdict: &str) -> &str {
    match verdict {
        "inconclusive" => "inconcl",
        other => other,
    }
}
