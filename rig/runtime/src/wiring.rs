//! Who is behind whom: terminals of the subject, channels of the board, signals of the trace.

use controller::ProbeId;
use drivers::ChannelId;
use signal::{Cause, SignalId};

/// The tables that the executor looks up in its loop.
#[derive(Debug, Default)]
pub struct Wiring {
    /// Channel behind each output terminal.
    pub outputs: Vec<Option<ChannelId>>,
    /// Input terminals behind each channel: one line may feed several.
    pub inputs: Vec<Vec<usize>>,
    /// Signals that show each channel.
    pub channels: Vec<Vec<SignalId>>,
    /// Signals that show each observed probe, by its number.
    pub probes: Vec<Vec<SignalId>>,
    /// Last writer of each channel, as the subject told it.
    pub writers: Vec<Cause>,
    /// The subject's state.
    pub state: Option<SignalId>,
    /// The marks of the case's own instants.
    pub start: Option<SignalId>,
    /// The mark of the case's end.
    pub end: Option<SignalId>,
    /// The mark of the end of the setup, where there is one.
    pub main: Option<SignalId>,
    /// The mark of the beginning of the teardown, where there is one.
    pub teardown: Option<SignalId>,
    /// The mark of its end.
    pub closed: Option<SignalId>,
}

impl Wiring {
    /// Tables for so many output terminals and channels, nothing bound yet.
    pub fn new(outputs: usize, channels: usize) -> Wiring {
        Wiring {
            outputs: vec![None; outputs],
            inputs: vec![Vec::new(); channels],
            channels: vec![Vec::new(); channels],
            writers: vec![Cause::Unknown; channels],
            ..Wiring::default()
        }
    }

    /// A signal shows an observed probe.
    pub fn show_probe(&mut self, probe: ProbeId, signal: SignalId) {
        let place = probe.0 as usize;
        if self.probes.len() <= place {
            self.probes.resize(place + 1, Vec::new());
        }
        self.probes[place].push(signal);
    }

    /// The channel behind an output terminal.
    pub fn output(&self, output: usize) -> Option<ChannelId> {
        self.outputs.get(output).copied().flatten()
    }
}
