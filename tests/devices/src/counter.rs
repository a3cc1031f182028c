//! The lab's counter: two counts whose signals a test moves, or lets follow GPIO lines.

use crate::{Chip, PATIENCE, wait_for, write};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

const SIDE: &str = "/run/lab/counter";
const DEVICE: &str = "/sys/bus/counter/devices/counter0";
const DRIVER: &str = "/sys/bus/platform/drivers/rig-counter";
const BOUND: &str = "rig-counter";

/// A count of the lab's counter, from the side of the world.
#[derive(Clone, Copy, Debug)]
pub struct Count(u8);

/// The counter from the side of the world. Dropping it brings it back, at rest.
#[derive(Debug)]
pub struct Counter;

impl Counter {
    /// Both counts at 0, at rest, counting quadrature x4 to 32 bits, following no lines.
    ///
    /// # Panics
    /// When this is not the lab's guest.
    pub fn enter() -> Counter {
        let counter = Counter;
        counter.bind();
        for count in [Count(0), Count(1)] {
            count.inject("0");
            count.lines_none();
            count.set("function", "quadrature x4");
            count.set("ceiling", "4294967295");
            count.set("count_mode", "normal");
            count.set("count", "0");
            count.stall(Duration::ZERO, 0);
        }
        counter
    }

    /// One of its counts.
    pub fn count(&self, number: u8) -> Count {
        Count(number)
    }

    /// Takes the device away, whoever uses it.
    pub fn unbind(&self) {
        write(&Path::new(DRIVER).join("unbind"), BOUND);
    }

    /// Brings it back.
    pub fn bind(&self) {
        if !Path::new(DRIVER).join(BOUND).exists() {
            write(&Path::new(DRIVER).join("bind"), BOUND);
        }
        wait_for("the counter is there", PATIENCE, || Path::new(SIDE).join("count1/inject").exists());
    }
}

impl Drop for Counter {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            self.bind();
            for count in [Count(0), Count(1)] {
                count.inject("0");
                count.lines_none();
                count.stall(Duration::ZERO, 0);
            }
        }
    }
}

impl Count {
    /// So many steps, at once.
    pub fn steps(self, steps: i64) {
        self.inject(&steps.to_string());
    }

    /// So many steps, so many of them a second.
    pub fn steps_at(self, steps: i64, rate: u32) {
        self.inject(&format!("{steps} at {rate}"));
    }

    /// Waits until all steps are made.
    ///
    /// # Panics
    /// When they are not made in time.
    pub fn rest(self) {
        wait_for("all steps are made", PATIENCE, || self.left() == 0);
    }

    /// A pulse of the index signal.
    pub fn index(self) {
        self.inject("index");
    }

    fn inject(self, text: &str) {
        write(&self.side("inject"), text);
    }

    fn left(self) -> i64 {
        let text = fs::read_to_string(self.side("inject")).expect("the lab's steps");
        text.trim().parse().expect("a number of steps")
    }

    /// Follows lines of a chip: A, B and index, as many as there are.
    pub fn lines(self, chip: Chip, lines: &[u32]) {
        let lines: Vec<String> = lines.iter().map(u32::to_string).collect();
        write(&self.side("lines"), &format!("{} {}", chip.label(), lines.join(" ")));
    }

    fn lines_none(self) {
        write(&self.side("lines"), "none");
    }

    /// So many of the next times that the count is read, reading it hangs for so long inside the kernel.
    pub fn stall(self, lasts: Duration, times: u32) {
        write(&self.side("stall"), &format!("{} {times}", lasts.as_millis()));
    }

    /// How many of them hang just now.
    ///
    /// # Panics
    /// When the lab does not say.
    pub fn inside(self) -> u32 {
        let text = fs::read_to_string(self.side("stall")).expect("the lab's stall");
        text.split_whitespace().last().and_then(|word| word.parse().ok()).expect("MS LEFT INSIDE")
    }

    /// Sets one of the kernel's files of the count.
    pub fn set(self, file: &str, text: &str) {
        write(&self.file(file), text);
    }

    /// What one of the kernel's files of the count says.
    ///
    /// # Panics
    /// When it cannot be read.
    pub fn says(self, file: &str) -> String {
        let text = fs::read_to_string(self.file(file));
        text.unwrap_or_else(|error| panic!("{file}: {error}")).trim().to_owned()
    }

    fn file(self, file: &str) -> PathBuf {
        Path::new(DEVICE).join(format!("count{}", self.0)).join(file)
    }

    fn side(self, file: &str) -> PathBuf {
        Path::new(SIDE).join(format!("count{}", self.0)).join(file)
    }
}
