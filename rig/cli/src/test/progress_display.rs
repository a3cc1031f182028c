//! The progress bar, and lines that are printed above it.

use super::display::ProgressMode;
use super::estimate::{Estimate, words};
use crate::output;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::time::Instant;

/// Cells of the bar.
const WIDTH: u64 = 24;

/// A progress bar on standard error, or none.
#[derive(Debug)]
pub struct ProgressDisplay {
    bar: Option<ProgressBar>,
    began: Instant,
    estimate: Estimate,
    total: u64,
    done: u64,
    failed: u64,
}

impl ProgressDisplay {
    /// A bar where the user and the terminal take one.
    pub fn new(progress: ProgressMode) -> ProgressDisplay {
        let terminal = std::io::stderr().is_terminal();
        let ci = std::env::var_os("CI").is_some_and(|value| !value.is_empty());
        let wanted = match progress {
            ProgressMode::Auto => terminal && !ci,
            ProgressMode::Bar => terminal,
            ProgressMode::None => false,
        };
        let bar = wanted.then(|| {
            let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
            // A template of the program's own that cannot be read would be seen by the first user of a terminal.
            let style = ProgressStyle::with_template("{prefix}\n{wide_msg}");
            bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()))
        });
        ProgressDisplay {
            bar,
            began: Instant::now(),
            estimate: Estimate::default(),
            total: 0,
            done: 0,
            failed: 0,
        }
    }

    /// Whether there is a bar.
    pub fn has_bar(&self) -> bool {
        self.bar.is_some()
    }

    /// The run begins with so many cases.
    pub fn start(&mut self, total: u64) {
        self.began = Instant::now();
        self.total = total;
    }

    /// A case has ended.
    pub fn ended(&mut self) {
        self.done += 1;
        self.estimate.ended(self.began.elapsed());
    }

    /// A case did not pass.
    pub fn failed(&mut self) {
        self.failed += 1;
    }

    /// Draws the bar with the names of the cases that run.
    pub fn draw<'a>(&self, running: impl Iterator<Item = &'a str>) {
        let Some(bar) = &self.bar else { return };
        bar.set_prefix(self.head());
        let names: Vec<&str> = running.collect();
        bar.set_message(format!("  {}", output::harmless(&names.join(", "))));
        bar.tick();
    }

    fn head(&self) -> String {
        let filled = (self.done * WIDTH).checked_div(self.total).unwrap_or(0).min(WIDTH);
        let bar: String = (0..WIDTH).map(|cell| if cell < filled { '#' } else { '-' }).collect();
        let mut head = format!("[{bar}] {}/{}", self.done, self.total);
        if self.failed > 0 {
            head.push_str(&format!(", {} not passed", self.failed));
        }
        if let Some(left) = self.estimate.left(self.began.elapsed(), self.total) {
            head.push_str(&format!(", {}", words(left)));
        }
        head
    }

    /// Prints while no bar is in the way.
    pub fn above(&self, print: impl FnOnce()) {
        match &self.bar {
            Some(bar) => bar.suspend(print),
            None => print(),
        }
    }

    /// The bar goes.
    pub fn clear(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
