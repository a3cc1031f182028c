//! Device calls that hang.

use crate::{Chip, write};
use std::fs;
use std::path::Path;
use std::time::Duration;

const STALL: &str = "/run/lab/stall";

/// A call on the lines of a chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Call {
    /// Lines are read.
    Get,
    /// Lines are set.
    Set,
}

impl Call {
    fn name(self) -> &'static str {
        match self {
            Call::Get => "get",
            Call::Set => "set",
        }
    }
}

pub(crate) fn set(chip: Chip, call: Call, lasts: Duration, times: u32) {
    write(Path::new(STALL), &format!("{} {} {} {times}", chip.label(), call.name(), lasts.as_millis()));
}

/// How many calls of this kind sleep just now.
pub(crate) fn inside(chip: Chip, call: Call) -> u32 {
    let listed = fs::read_to_string(STALL).expect("the lab's list of stalled calls");
    // CHIP CALL MS LEFT INSIDE
    let of_call = listed.lines().map(|line| line.split(' ').collect::<Vec<_>>());
    of_call
        .filter(|words| words.starts_with(&[chip.label(), call.name()]))
        .find_map(|words| words.last()?.parse().ok())
        .unwrap_or(0)
}

pub(crate) fn none() {
    write(Path::new(STALL), "none");
}
