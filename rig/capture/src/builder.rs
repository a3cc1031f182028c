//! Changes as a reader finds them, bounded.

use crate::{CapturedChange, CapturedChannel, ChannelType, MAX_CHANGES, MAX_CHANNELS};
use signal::{Value, When};
use std::collections::BTreeSet;

/// Channels and changes while a file is read.
#[derive(Debug, Default)]
pub(crate) struct CaptureBuilder {
    pub(crate) channels: Vec<CapturedChannel>,
    pub(crate) changes: Vec<CapturedChange>,
    names: BTreeSet<String>,
    last: Vec<Option<Value>>,
}

impl CaptureBuilder {
    /// Adds a channel; `None` where there are too many. A name that is taken gets a number after it.
    pub(crate) fn channel(&mut self, name: &str, unit: &str, shape: ChannelType) -> Option<u32> {
        if self.channels.len() >= MAX_CHANNELS {
            return None;
        }
        let mut unique = name.to_owned();
        let mut copy = 2;
        while !self.names.insert(unique.clone()) {
            unique = format!("{name}_{copy}");
            copy += 1;
        }
        let shares_name = unique != name;
        if let Some(first) = self.channels.iter_mut().find(|known| shares_name && known.name == name) {
            first.shares_name = true;
        }
        let unit = unit.to_owned();
        self.channels.push(CapturedChannel { name: unique, shares_name, unit, shape, recording: None });
        self.last.push(None);
        Some(self.channels.len() as u32 - 1)
    }

    /// Whether this would be a change. What a channel is before anything is known of it is none.
    pub(crate) fn is_change(&self, channel: u32, value: Value) -> bool {
        match self.last.get(channel as usize) {
            Some(Some(last)) => *last != value,
            Some(None) => value != Value::Unknown,
            None => false,
        }
    }

    /// Adds a change, if it is one. `false` where there are too many.
    pub(crate) fn change(&mut self, channel: u32, at: When, value: Value) -> bool {
        if self.is_change(channel, value) { self.push(channel, at, value) } else { true }
    }

    /// The same of a file in which the first word on a channel may be that it is not known, which says more than none.
    pub(crate) fn change_or_unknown(&mut self, channel: u32, at: When, value: Value) -> bool {
        let is_first = !self.is_known(channel);
        if is_first || self.is_change(channel, value) { self.push(channel, at, value) } else { true }
    }

    fn push(&mut self, channel: u32, at: When, value: Value) -> bool {
        if self.changes.len() >= MAX_CHANGES {
            return false;
        }
        self.last[channel as usize] = Some(value);
        self.changes.push(CapturedChange { channel, at, value });
        true
    }

    /// Whether a channel has a value yet.
    pub(crate) fn is_known(&self, channel: u32) -> bool {
        self.last.get(channel as usize).is_some_and(Option::is_some)
    }
}

/// What to say where there are too many changes.
pub(crate) fn too_many_changes() -> String {
    format!("more than {MAX_CHANGES} changes")
}

/// What to do about too many changes.
pub(crate) const FEWER: &str = "capture for a shorter time, or fewer channels";

/// What to say where there are too many channels.
pub(crate) fn too_many_channels() -> String {
    format!("more than {MAX_CHANNELS} channels")
}
