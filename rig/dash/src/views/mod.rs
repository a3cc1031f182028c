//! The views, one at a time below the header.

mod buses;
mod expert;
mod io;
mod log;
mod plan;
mod tasks;
#[cfg(test)]
mod tests;
mod trend;

use crate::glyphs::TerminalFeatures;
use crate::model::RigModel;
use crate::recording::TrendFiles;
use control::{RequestFault, RequestOperation, WireValue};
use ratatui::Frame;
use ratatui::crossterm::event::{KeyEvent, MouseEvent};
use ratatui::layout::Rect;
use std::rc::Rc;

/// What a view wants of the dashboard.
#[derive(Clone, Debug, PartialEq)]
pub enum ViewRequest {
    /// Ask the rig, at once.
    Operation(RequestOperation),
    /// Ask it once the user has said yes to this question.
    Confirm(String, RequestOperation),
    /// Let the user type something; [`View::typed`] gets it.
    Prompt {
        /// What stands before it.
        ask: String,
        /// What stands there to begin with.
        text: String,
    },
    /// Say something in the bottom line.
    Message(String),
    /// Say there what is wrong.
    Fault(RequestFault),
}

/// The views, in the order of their tabs.
pub fn all(files: Box<dyn TrendFiles>) -> Vec<Box<dyn View>> {
    let files: Rc<dyn TrendFiles> = files.into();
    vec![
        Box::new(io::IoView::default()),
        Box::new(trend::TrendView::new(files.clone())),
        Box::new(tasks::TasksView::default()),
        Box::new(expert::ExpertView::default()),
        Box::new(buses::BusesView::new(files)),
        Box::new(log::LogView::default()),
        Box::new(plan::PlanView::default()),
    ]
}

/// A view. It is asked before the dashboard is: a key that it uses goes no further.
pub trait View: std::fmt::Debug {
    /// The name in the row of tabs.
    fn name(&self) -> &'static str;

    /// Keys and what they do, as they stand in the bottom line.
    fn keys(&self) -> Vec<(&'static str, &'static str)>;

    /// Signals that it needs now, with every change (`true`) or the last value (`false`), whether it is shown or not.
    /// Asked again after each key and each message.
    fn signals(&self, model: &RigModel) -> Vec<(String, bool)>;

    /// It becomes the one that is shown (`true`), or another one does.
    fn shown(&mut self, _shown: bool) {}

    /// What it wants as soon as it is shown.
    fn opened(&mut self, _model: &RigModel) -> Vec<ViewRequest> {
        Vec::new()
    }

    /// Whether frames of the buses are to be sent now: on a fast bus they are many.
    fn wants_frames(&self) -> bool {
        false
    }

    /// There was no connection for a while, and now there is one again: nothing was sent of what changed in between. Where
    /// the rig restarted, its time did, too.
    fn reconnected(&mut self) {}

    /// A signal that it asked for changed: the earliest and the latest instant in nanoseconds since the rig began, and
    /// its value. In the order of the latest instants. What it was when it was asked for comes so, too.
    fn changed(&mut self, _name: &str, _when: (i64, i64), _value: WireValue) {}

    /// The rig did not send so many changes of the signals that it asked for, some time before now.
    fn missed(&mut self, _changes: u64) {}

    /// Draws it.
    fn draw(&mut self, frame: &mut Frame<'_>, area: Rect, model: &RigModel, features: TerminalFeatures);

    /// A key. `None` where the view does not use it.
    fn key(&mut self, key: KeyEvent, model: &RigModel) -> Option<Vec<ViewRequest>>;

    /// The mouse, somewhere in the area that was drawn last.
    fn mouse(&mut self, _mouse: MouseEvent, _model: &RigModel) -> Vec<ViewRequest> {
        Vec::new()
    }

    /// What the user typed after a prompt.
    fn typed(&mut self, _text: &str, _model: &RigModel) -> Vec<ViewRequest> {
        Vec::new()
    }
}
