//! Who is behind whom: terminals of the subject, channels of the board, signals of the trace.

use crate::frames::FrameWatch;
use crate::subject::Subject;
use crate::subject::external;
use controller::{ProbeId, Terminal};
use drivers::file::ChannelDelay;
use drivers::sensor::SensorCurve;
use drivers::{BoardFile, BusId, ChannelId};
use profile::IoChannel;
use signal::{Area, Cause, SignalId, Size, Span};

/// An input terminal at a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WiredInput {
    /// The terminal.
    pub terminal: Terminal,
    /// It takes a number in the unit of the channel, and not a level.
    pub analog: bool,
    /// The channel carries what a sensor with this curve shows, and the terminal takes the temperature.
    pub sensor: Option<SensorCurve>,
}

/// A port of a subject that the rig plays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WiredPort {
    /// Its name.
    pub name: &'static str,
    /// The bus behind it.
    pub bus: Option<BusId>,
}

/// The tables that the executor looks up in its loop.
#[derive(Debug, Default)]
pub struct Wiring {
    /// Channel at each output terminal: by module, then by output.
    outputs: Vec<Vec<Option<ChannelId>>>,
    /// Input terminals at each channel: one line may feed several.
    pub inputs: Vec<Vec<WiredInput>>,
    /// Signals that show each channel.
    pub channels: Vec<Vec<SignalId>>,
    /// How much earlier than it was seen a change of each channel may have happened, by what the subject is.
    pub early: Vec<Span>,
    /// What lies between the terminal and the line of each channel adds to the earliest and to the latest instant of a change.
    pub delays: Vec<(Span, Span)>,
    /// Signals that show each observed probe, by its number.
    pub probes: Vec<Vec<SignalId>>,
    /// The ports of a subject that the rig plays, by their numbers.
    pub ports: Vec<WiredPort>,
    /// Signals that follow the frames of each bus.
    pub buses: Vec<Vec<FrameWatch>>,
    /// Last writer of each channel, as the subject reported it.
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
    /// Tables for so many channels, nothing bound yet.
    pub fn new(channels: usize) -> Wiring {
        Wiring {
            inputs: vec![Vec::new(); channels],
            channels: vec![Vec::new(); channels],
            early: vec![Span::ZERO; channels],
            delays: vec![(Span::ZERO, Span::ZERO); channels],
            writers: vec![Cause::Unknown; channels],
            ..Wiring::default()
        }
    }

    /// Tables for the controller of a board file, whose terminals are bound to their channels. Those of a real controller
    /// are the board's alone: it has the lines that the rig switches it by as outputs, and its alarm line as input.
    pub fn of(file: &BoardFile, subject: &dyn Subject, channels: usize) -> Wiring {
        let mut wiring = Wiring::new(channels);
        wiring.delay(&file.delays);
        let Some(settings) = &file.subject.external else {
            for binding in &file.bind {
                let Some(terminal) = subject.terminal(binding.address) else { continue };
                match terminal.channel {
                    IoChannel::Input(_) => {
                        let analog = binding.address.size() != Size::Bit;
                        let of_channel =
                            |(channel, _): &&(ChannelId, SensorCurve)| *channel == binding.channel;
                        let sensor = file.sensors.iter().find(of_channel).map(|(_, curve)| *curve);
                        wiring.bind_input(binding.channel, WiredInput { terminal, analog, sensor });
                    }
                    IoChannel::Output(_) => wiring.bind_output(terminal, binding.channel),
                }
            }
            return wiring;
        };
        for (output, line) in [(external::POWER, file.lines.power), (external::RUN_STOP, file.lines.run_stop)]
        {
            if let Some(channel) = line {
                wiring.bind_output(Terminal::output(output), channel);
            }
        }
        if let Some(alarm) = file.lines.alarm {
            let terminal = Terminal::input(external::ALARM);
            wiring.bind_input(alarm, WiredInput { terminal, analog: false, sensor: None });
        }
        let of_controller = file.bind.iter().filter(|binding| binding.address.area() == Area::Output);
        for channel in of_controller.map(|binding| binding.channel).chain(file.lines.alarm) {
            wiring.early[usize::from(channel.0)] = settings.jitter;
        }
        wiring
    }

    /// What lies between terminals and lines delays these channels. What was read came earlier; what was driven comes later, but
    /// may have come at once: the trace cannot have what is still to come.
    pub fn delay(&mut self, delays: &[ChannelDelay]) {
        for ChannelDelay { channel, before: (least, most), after } in delays {
            if let Some((earliest, latest)) = self.delays.get_mut(usize::from(channel.0)) {
                (*earliest, *latest) = (-*most, *after - *least);
            }
        }
    }

    /// What is added to the earliest and to the latest instant of a change of a channel by what delays it.
    pub fn delay_of(&self, channel: ChannelId) -> (Span, Span) {
        self.delays.get(usize::from(channel.0)).copied().unwrap_or_default()
    }

    /// A terminal follows a channel.
    pub fn bind_input(&mut self, channel: ChannelId, input: WiredInput) {
        if let Some(inputs) = self.inputs.get_mut(usize::from(channel.0)) {
            inputs.push(input);
        }
    }

    /// A terminal drives a channel; that of an input drives none.
    pub fn bind_output(&mut self, terminal: Terminal, channel: ChannelId) {
        let IoChannel::Output(output) = terminal.channel else { return };
        if self.outputs.len() <= terminal.module {
            self.outputs.resize(terminal.module + 1, Vec::new());
        }
        let outputs = &mut self.outputs[terminal.module];
        if outputs.len() <= output {
            outputs.resize(output + 1, None);
        }
        outputs[output] = Some(channel);
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
    pub fn follow(&mut self, bus: BusId, watch: FrameWatch) {
        let place = usize::from(bus.0);
        if self.buses.len() <= place {
            self.buses.resize(place + 1, Vec::new());
        }
        self.buses[place].push(watch);
    }

    /// The channel at the terminal of an output.
    #[inline]
    pub fn channel_of(&self, terminal: Terminal) -> Option<ChannelId> {
        let IoChannel::Output(output) = terminal.channel else { return None };
        self.outputs.get(terminal.module)?.get(output).copied().flatten()
    }

    /// The output terminals that drive a channel, by module and number.
    pub fn outputs(&self) -> impl Iterator<Item = (Terminal, ChannelId)> {
        self.outputs.iter().enumerate().flat_map(|(module, outputs)| {
            let terminal = move |output| Terminal { module, channel: IoChannel::Output(output) };
            let outputs = outputs.iter().enumerate();
            outputs.filter_map(move |(output, channel)| Some((terminal(output), (*channel)?)))
        })
    }
}
