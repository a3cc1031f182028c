//! Who is behind whom: terminals of the subject, channels of the board, signals of the trace.

use crate::external;
use crate::frames::Watch;
use controller::{Channel as Terminal, ProbeId};
use drivers::{BoardFile, BusId, ChannelId};
use profile::Reference;
use signal::{Area, Cause, SignalId, Span};

/// The tables that the executor looks up in its loop.
#[derive(Debug, Default)]
pub struct Wiring {
    /// Channel behind each output terminal.
    pub outputs: Vec<Option<ChannelId>>,
    /// Input terminals behind each channel: one line may feed several.
    pub inputs: Vec<Vec<usize>>,
    /// Signals that show each channel.
    pub channels: Vec<Vec<SignalId>>,
    /// How much earlier than it was seen a change of each channel may have happened, by what the subject is.
    pub early: Vec<Span>,
    /// Signals that show each observed probe, by its number.
    pub probes: Vec<Vec<SignalId>>,
    /// Signals that follow the frames of each bus.
    pub buses: Vec<Vec<Watch>>,
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
            early: vec![Span::ZERO; channels],
            writers: vec![Cause::Unknown; channels],
            ..Wiring::default()
        }
    }

    /// Tables for the controller of a board file, whose terminals are bound to their channels. Those of a real controller
    /// are the board's alone: it has the lines that the rig switches it by as outputs, and its alarm line as input.
    pub fn of(file: &BoardFile, reference: &Reference, channels: usize) -> Wiring {
        let Some(settings) = &file.subject.external else {
            let mut wiring = Wiring::new(reference.output_count(), channels);
            for binding in &file.bind {
                match Terminal::at(binding.address, reference) {
                    Some(Terminal::Input(input)) => wiring.inputs[usize::from(binding.channel.0)].push(input),
                    Some(Terminal::Output(output)) => wiring.outputs[output] = Some(binding.channel),
                    None => {}
                }
            }
            return wiring;
        };
        let mut wiring = Wiring::new(2, channels);
        wiring.outputs[external::POWER] = file.lines.power;
        wiring.outputs[external::RUN_STOP] = file.lines.run_stop;
        if let Some(alarm) = file.lines.alarm {
            wiring.inputs[usize::from(alarm.0)].push(external::ALARM);
        }
        let of_controller = file.bind.iter().filter(|binding| binding.address.area() == Area::Output);
        for channel in of_controller.map(|binding| binding.channel).chain(file.lines.alarm) {
            wiring.early[usize::from(channel.0)] = settings.jitter;
        }
        wiring
    }

    /// A signal shows an observed probe.
    pub fn show_probe(&mut self, probe: ProbeId, signal: SignalId) {
        let place = probe.0 as usize;
        if self.probes.len() <= place {
            self.probes.resize(place + 1, Vec::new());
        }
        self.probes[place].push(signal);
    }

    /// A signal follows the frames of a bus.
    pub fn follow(&mut self, bus: BusId, watch: Watch) {
        let place = usize::from(bus.0);
        if self.buses.len() <= place {
            self.buses.resize(place + 1, Vec::new());
        }
        self.buses[place].push(watch);
    }

    /// The channel behind the terminal of an output. Of the modules only the embedded I/O is bound to channels.
    pub fn channel_of(&self, terminal: controller::Terminal) -> Option<ChannelId> {
        match (terminal.module, terminal.channel) {
            (0, Terminal::Output(output)) => self.output(output),
            _ => None,
        }
    }

    /// The channel behind an output terminal.
    pub fn output(&self, output: usize) -> Option<ChannelId> {
        self.outputs.get(output).copied().flatten()
    }
}
