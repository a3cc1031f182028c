//! What is looked at: the window and the cursors, and how they move.

use super::{BASES, TrendCursor, TrendView};

impl TrendView {
    /// The window that is to be shown, and the trigger in it.
    pub(super) fn current(&self) -> ((i64, i64), Option<i64>) {
        let base = self.base();
        let live = self.file.is_none();
        let trigger = self.trigger.window(self.live.now, base).filter(|_| live);
        let end = match (self.held, trigger) {
            (Some(end), _) => end,
            (None, Some((end, _))) => end,
            (None, None) => self.seen().now,
        };
        ((end.saturating_sub(base), end), trigger.map(|(_, at)| at))
    }

    /// The trigger whose window is shown, as long as that is not held elsewhere.
    pub(super) fn fired(&self) -> Option<i64> {
        self.current().1
    }

    /// Holds the window where it is.
    pub(super) fn hold(&mut self) {
        if self.held.is_none() {
            self.held = Some(self.current().0.1);
        }
    }

    /// Lets time go on.
    pub(super) fn release(&mut self) {
        self.held = None;
    }

    /// Another length of the window. The middle stays where it is, unless time goes on.
    pub(super) fn zoom(&mut self, longer: bool) {
        let (from, to) = self.current().0;
        self.base = if longer { (self.base + 1).min(BASES.len() - 1) } else { self.base.saturating_sub(1) };
        if self.held.is_some() {
            let middle = match self.moving.and_then(|place| self.cursors[place]) {
                Some(mark) => mark.at,
                None => from + to.saturating_sub(from) / 2,
            };
            self.held = Some(middle.saturating_add(self.base() / 2));
        }
    }

    /// Moves the cursor that moves, else the window, by so many columns.
    pub(super) fn shift(&mut self, columns: i64) {
        let width = i64::from(self.plot.width.max(1));
        let by = (self.base() / width).max(1).saturating_mul(columns);
        match self.moving {
            Some(place) => {
                let at = self.cursors[place].map_or(self.window.0, |mark| mark.at);
                self.put(place, TrendCursor { at: at.saturating_add(by), width: 0 });
            }
            None => {
                self.hold();
                let (begin, end) = (self.seen().begin(), self.seen().now);
                let least = begin.saturating_add(self.base()).min(end);
                self.held = self.held.map(|held| held.saturating_add(by).clamp(least, end.max(least)));
            }
        }
    }

    /// Puts a cursor somewhere, and follows it where it leaves the window.
    pub(super) fn put(&mut self, place: usize, mark: TrendCursor) {
        let at = mark.at.clamp(self.seen().begin().min(self.window.0), self.seen().now.max(self.window.1));
        self.cursors[place] = Some(TrendCursor { at, width: mark.width });
        self.moving = Some(place);
        let (from, to) = self.window;
        if at < from || at > to {
            self.held = Some(if at < from { at.saturating_add(self.base()) } else { at });
        }
    }

    /// Chooses a cursor; one that is nowhere comes to the middle. Once more, and no cursor moves.
    pub(super) fn cursor(&mut self, place: usize) {
        if self.moving == Some(place) {
            self.moving = None;
            return;
        }
        self.hold();
        self.moving = Some(place);
        if self.cursors[place].is_none() {
            let (from, to) = self.window;
            self.put(place, TrendCursor { at: from + to.saturating_sub(from) / 2, width: 0 });
        }
    }

    /// Moves the cursor to the next change of the chosen line.
    pub(super) fn jump(&mut self, forward: bool) {
        let place = self.moving.unwrap_or(0);
        if self.moving.is_none() {
            self.cursor(place);
        }
        let Some(mark) = self.cursors[place] else { return };
        if let Some(point) = self.seen().lines.get(self.chosen).and_then(|line| line.next(mark.at, forward)) {
            self.put(place, TrendCursor { at: point.at, width: point.at.saturating_sub(point.earliest) });
        }
    }
}
