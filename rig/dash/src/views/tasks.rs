//! The tasks: times, what was late or lost, load against its limit, watchdogs, and how the jitter is spread.

use super::{View, ViewRequest};
use crate::canvas::{self, Canvas, CanvasColumn, column};
use crate::glyphs::TerminalFeatures;
use crate::model::RigModel;
use crate::show;
use control::{TaskInfo, TaskStatus};
use ratatui::Frame;
use ratatui::crossterm::event::{KeyCode, KeyEvent, MouseButton, MouseEvent, MouseEventKind};
use ratatui::layout::Rect;
use ratatui::style::Style;

/// The table. Columns that name a width are shown from that width on.
const COLUMNS: [CanvasColumn; 14] = [
    column("Task", 10, false, 0),
    column("Pr", 2, true, 0),
    column("Interval", 8, true, 0),
    column("Last", 8, true, 0),
    column("Min", 8, true, 0),
    column("Mean", 8, true, 0),
    column("Max", 8, true, 0),
    column("Jitter", 8, true, 0),
    column("Over", 4, true, 0),
    column("Lost", 4, true, 0),
    column("Cycles", 10, true, 100),
    column("Watchdog", 8, true, 110),
    column("Trips", 5, true, 116),
    column("Programs", 40, false, 130),
];

/// From this width on the rig's own lateness stands beside the jitter.
const BESIDE: u16 = 110;

/// The view of the tasks.
#[derive(Debug, Default)]
pub struct TasksView {
    chosen: usize,
    first: usize,
    /// The rig's lateness in place of the task's jitter, where there is room for one.
    rig: bool,
    /// Where the rows of the table were drawn.
    rows: Rect,
}

impl View for TasksView {
    fn name(&self) -> &'static str {
        "Tasks"
    }

    fn keys(&self) -> Vec<(&'static str, &'static str)> {
        vec![("Up/Down", "task"), ("h", if self.rig { "jitter of the task" } else { "lateness of the rig" })]
    }

    fn signals(&self, _model: &RigModel) -> Vec<(String, bool)> {
        Vec::new()
    }

    fn draw(&mut self, frame: &mut Frame<'_>, area: Rect, model: &RigModel, features: TerminalFeatures) {
        let mut canvas = Canvas::new(frame, area, features);
        let tasks: Vec<(&TaskInfo, &TaskStatus)> =
            model.description.tasks.iter().zip(&model.status.tasks).collect();
        self.chosen = self.chosen.min(tasks.len().saturating_sub(1));
        if tasks.is_empty() {
            canvas.text(1, 0, "No application, so no tasks.", Style::new());
            return;
        }
        // The table takes what the bars and at least four rows of the histogram leave.
        let bars = (tasks.len() as u16 + 2).min(canvas.height() / 3);
        let table = (tasks.len() as u16).min(canvas.height().saturating_sub(bars + 8).max(1));
        canvas::titles(&mut canvas, 0, &COLUMNS);
        self.first = canvas::scrolled(self.first, self.chosen, usize::from(table));
        for (row, place) in (self.first..tasks.len()).take(usize::from(table)).enumerate() {
            let (info, status) = tasks[place];
            let y = row as u16 + 1;
            let style = if status.overruns + status.lost + status.watchdogs > 0 {
                canvas.alarm()
            } else {
                Style::new()
            };
            canvas::cells(&mut canvas, y, &COLUMNS, figures(info, status), style);
            if place == self.chosen {
                canvas.shade(y, canvas::chosen());
            }
        }
        self.rows = canvas.part(0, 1, canvas.width(), table).area();
        let top = table + 2;
        draw_loads(&mut canvas.part(0, top, area.width, bars), &tasks, self.chosen, model);
        let top = top + bars;
        let mut rest = canvas.part(0, top, area.width, area.height.saturating_sub(top));
        let (info, status) = tasks[self.chosen];
        let title = format!("Jitter of {}: from release to start of its cycle", info.name);
        let late = "Lateness of the rig: how long after its instants it woke up";
        if rest.width() >= BESIDE {
            let half = rest.width() / 2;
            let height = rest.height();
            draw_counts(&mut rest.part(0, 0, half - 1, height), &title, &status.jitter_counts);
            let width = rest.width() - half;
            draw_counts(&mut rest.part(half, 0, width, height), late, &model.status.rig.late_counts);
        } else if self.rig {
            draw_counts(&mut rest, late, &model.status.rig.late_counts);
        } else {
            draw_counts(&mut rest, &title, &status.jitter_counts);
        }
    }

    fn key(&mut self, key: KeyEvent, model: &RigModel) -> Option<Vec<ViewRequest>> {
        let last = model.status.tasks.len().saturating_sub(1);
        match key.code {
            KeyCode::Up => self.chosen = self.chosen.saturating_sub(1),
            KeyCode::Down => self.chosen = (self.chosen + 1).min(last),
            KeyCode::Home => self.chosen = 0,
            KeyCode::End => self.chosen = last,
            KeyCode::Char('h') => self.rig = !self.rig,
            _ => return None,
        }
        Some(Vec::new())
    }

    fn mouse(&mut self, mouse: MouseEvent, model: &RigModel) -> Vec<ViewRequest> {
        let inside = self.rows.contains((mouse.column, mouse.row).into());
        match mouse.kind {
            MouseEventKind::Down(MouseButton::Left) if inside => {
                let place = self.first + usize::from(mouse.row - self.rows.y);
                self.chosen = place.min(model.status.tasks.len().saturating_sub(1));
            }
            MouseEventKind::ScrollUp => self.chosen = self.chosen.saturating_sub(1),
            MouseEventKind::ScrollDown => {
                self.chosen = (self.chosen + 1).min(model.status.tasks.len().saturating_sub(1));
            }
            _ => {}
        }
        Vec::new()
    }
}

/// The cells of a task's row.
fn figures(info: &TaskInfo, status: &TaskStatus) -> [String; COLUMNS.len()] {
    // A task that never ran has no times.
    let time = |nanos: i64| if status.cycles == 0 { "-".to_owned() } else { show::span(nanos) };
    [
        info.name.clone(),
        info.priority.to_string(),
        if info.interval > 0 { show::span(info.interval) } else { short(&info.kind).to_owned() },
        time(status.last),
        time(status.min),
        time(status.mean),
        time(status.max),
        time(status.jitter_max),
        status.overruns.to_string(),
        status.lost.to_string(),
        status.cycles.to_string(),
        info.watchdog.map_or("off".to_owned(), show::span),
        status.watchdogs.to_string(),
        info.programs.join(", "),
    ]
}

/// What stands in place of an interval.
fn short(kind: &str) -> &str {
    match kind {
        "freewheeling" => "free",
        "external-event" => "external",
        other => other,
    }
}

/// Bars of the load, in all and of each task, and how much of the chosen one's watchdog is left.
fn draw_loads(canvas: &mut Canvas<'_>, tasks: &[(&TaskInfo, &TaskStatus)], chosen: usize, model: &RigModel) {
    let limit = model.description.load_limit;
    let watchdog = canvas.height().saturating_sub(1);
    let share = |load: u32| f64::from(load) / 1_000.0;
    let name = 14;
    let width = canvas.width().saturating_sub(name + 22);
    let over = limit > 0 && model.status.load > limit;
    let style = if over { canvas.alarm() } else { canvas.good() };
    canvas.text(1, 0, "Load", canvas::bold());
    canvas.bar(name, 0, width, share(model.status.load), (limit > 0).then(|| share(limit)), style);
    let text = if limit > 0 {
        format!("{} of {}", show::per_mille(model.status.load), show::per_mille(limit))
    } else {
        show::per_mille(model.status.load)
    };
    canvas.text(name + width + 1, 0, &text, style);
    // The chosen one is among those that are shown.
    let rows = usize::from(watchdog.saturating_sub(1));
    let first = canvas::scrolled(0, chosen, rows.max(1));
    for (row, (info, status)) in tasks.iter().skip(first).take(rows).enumerate() {
        let y = row as u16 + 1;
        canvas.text_in(3, y, name - 4, &info.name, Style::new());
        canvas.bar(name, y, width, share(status.load), None, Style::new());
        canvas.text(name + width + 1, y, &show::per_mille(status.load), Style::new());
    }
    let Some((info, status)) = tasks.get(chosen) else { return };
    canvas.text(1, watchdog, "Watchdog", canvas::bold());
    let Some(time) = info.watchdog.filter(|time| *time > 0) else {
        canvas.text(name, watchdog, &format!("off for {}", info.name), Style::new());
        return;
    };
    let left = time.saturating_sub(status.max).max(0);
    let style = if left * 5 < time { canvas.alarm() } else { canvas.good() };
    canvas.bar(name, watchdog, width, status.max as f64 / time as f64, None, style);
    canvas.text(name + width + 1, watchdog, &format!("{} left", show::span(left)), style);
}

/// A histogram: a bar for each border, with its count and its share.
fn draw_counts(canvas: &mut Canvas<'_>, title: &str, counts: &[(i64, u64)]) {
    canvas.rule(0, title);
    let all: u64 = counts.iter().map(|(_, count)| count).sum();
    if all == 0 {
        canvas.text(1, 1, "nothing counted yet", Style::new());
        return;
    }
    // Empty ends are left out: a border below the first count, or above the last, says nothing.
    let begin = counts.iter().position(|(_, count)| *count > 0).unwrap_or(0);
    let end = counts.iter().rposition(|(_, count)| *count > 0).map_or(counts.len(), |last| last + 1);
    let room = usize::from(canvas.height().saturating_sub(1)).max(1);
    let shown = joined(&counts[begin..end], room);
    let most = shown.iter().map(|(_, count)| *count).max().unwrap_or(1).max(1);
    let width = canvas.width().saturating_sub(32);
    for (row, (border, count)) in shown.iter().enumerate() {
        let y = row as u16 + 1;
        let upto =
            if *border == i64::MAX { "more".to_owned() } else { format!("<= {}", show::span(*border)) };
        canvas.right(12, y, &upto, Style::new());
        canvas.bar(13, y, width, *count as f64 / most as f64, None, Style::new());
        let share = *count as f64 / all as f64 * 100.0;
        canvas.right(13 + width + 10, y, &count.to_string(), Style::new());
        canvas.right(13 + width + 18, y, &format!("{share:.2}%"), Style::new());
    }
}

/// Neighbours together, until no more than `room` are left.
fn joined(counts: &[(i64, u64)], room: usize) -> Vec<(i64, u64)> {
    let each = counts.len().div_ceil(room).max(1);
    counts
        .chunks(each)
        .filter_map(|part| part.last().map(|(border, _)| (*border, part.iter().map(|(_, n)| n).sum())))
        .collect()
}
