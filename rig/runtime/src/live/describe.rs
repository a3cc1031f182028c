//! What a rig reports of itself once: its points, tasks, functions, buses and devices.

use super::directory::is_written;
use crate::application::bundle::TaskPrograms;
use crate::application::catalogue::Catalogue;
use control::{
    BusInfo, ChannelInfo as OnBoard, DeviceInfo, FrameSeen, FunctionInfo, ModuleInfo, PointDirection,
    PointInfo, SignalKind, TaskInfo, WordScale,
};
use controller::{TaskConfig, TaskKind};
use drivers::{Board, BoardExt, BoardFile, BusId, BusKind, ChannelId, ChannelKind};
use expert::{CounterKind, CounterMode, FunctionKind};
use profile::{ConfiguredModule, IoChannel};
use program::Storage;
use signal::{Address, Area, CanFrame, SerialErrors, SerialMessage, Size, Time};

/// The devices behind a board's channels and buses, each once.
#[derive(Debug)]
pub struct DeviceTable {
    /// As clients get them.
    pub list: Vec<DeviceInfo>,
    /// The device behind each channel.
    pub of_channels: Vec<Option<usize>>,
    /// The device behind each bus.
    pub of_buses: Vec<Option<usize>>,
}

impl DeviceTable {
    /// Those of a board.
    pub fn of(board: &dyn Board) -> DeviceTable {
        let mut list: Vec<DeviceInfo> = Vec::new();
        let mut place = |name: Option<&str>, kind: &str| {
            let name = name?;
            if let Some(known) = list.iter().position(|known| known.name == name) {
                return Some(known);
            }
            let path = name.split(' ').next().filter(|path| path.starts_with('/')).unwrap_or_default();
            list.push(DeviceInfo { name: name.to_owned(), kind: kind.to_owned(), path: path.to_owned() });
            Some(list.len() - 1)
        };
        let channels = 0..board.channels().len() as u16;
        let of_channel =
            |channel| place(board.device(channel), board.device_kind(channel).unwrap_or("other"));
        let of_channels = channels.map(ChannelId).map(of_channel).collect();
        let of_bus = |(number, bus): (u16, &drivers::Bus)| {
            let kind = match bus.kind {
                BusKind::Can { .. } => "can",
                BusKind::Serial { .. } => "serial",
            };
            place(board.bus_device(BusId(number)), kind)
        };
        let of_buses = (0..).zip(board.bus_list()).map(of_bus).collect();
        DeviceTable { list, of_channels, of_buses }
    }
}

/// The terminals of the controller, then the lines of the board that have none.
pub fn points(
    catalogue: &Catalogue,
    file: &BoardFile,
    board: &dyn Board,
    devices: &DeviceTable,
) -> Vec<PointInfo> {
    let reference = catalogue.reference();
    let (inputs, outputs) = (reference.input_count() as u32, reference.output_count() as u32);
    let expert = catalogue.functions().outputs();
    let channel = |id: ChannelId| {
        let channel = board.channels().get(usize::from(id.0))?;
        Some(OnBoard {
            name: channel.name.clone(),
            unit: channel.unit().to_owned(),
            device: devices.of_channels.get(usize::from(id.0)).copied().flatten(),
            drives: file.is_driven(id).unwrap_or(channel.drives),
        })
    };
    let written = |id: ChannelId| {
        let known = board.channels().get(usize::from(id.0));
        known.is_some_and(|known| is_written(file, id, known))
    };
    let terminal = |area: Area, letter: char, number: u32| {
        let address = Address::bit(area, number);
        PointInfo {
            name: format!("{letter}{number}"),
            address: Some(address.to_string()),
            variable: variable_at(catalogue, address),
            direction: if area == Area::Input { PointDirection::Input } else { PointDirection::Output },
            kind: SignalKind::Bool,
            channel: file.channel_of(address).and_then(channel),
            image: Some(address.to_string()),
            forcible: area == Area::Input || !expert.contains(number as usize),
            writable: file.channel_of(address).is_some_and(written),
            scale: None,
        }
    };
    let inputs = (0..inputs).map(|number| terminal(Area::Input, 'I', number));
    let outputs = (0..outputs).map(|number| terminal(Area::Output, 'Q', number));
    // Channels of modules have the names of their terminals.
    let of_modules = file.bind.iter().filter_map(|binding| {
        let address = binding.address;
        let is_embedded = IoChannel::at(address, reference).is_some();
        let known = board.channels().get(usize::from(binding.channel.0))?;
        (catalogue.is_channel(address) && !is_embedded).then(|| PointInfo {
            name: known.name.clone(),
            address: Some(address.to_string()),
            variable: variable_at(catalogue, address),
            direction: match address.area() {
                Area::Input => PointDirection::Input,
                _ => PointDirection::Output,
            },
            kind: if address.size() == Size::Bit { SignalKind::Bool } else { SignalKind::Real },
            channel: channel(binding.channel),
            image: Some(address.to_string()),
            forcible: true,
            writable: written(binding.channel),
            scale: scale_at(catalogue, address),
        })
    });
    let terminals: Vec<PointInfo> = inputs.chain(outputs).chain(of_modules).collect();
    // A simulated board has a line for each terminal. Nothing is on that of one which is bound elsewhere, and its name means
    // the terminal.
    let leads_nowhere =
        |name: &str| !file.is_real() && terminals.iter().any(|terminal| terminal.name == name);
    let loose = (0..board.channels().len() as u16)
        .map(ChannelId)
        .filter(|id| !file.bind.iter().any(|binding| binding.channel == *id));
    let loose = loose.filter_map(|id| {
        let known = board.channels().get(usize::from(id.0)).filter(|known| !leads_nowhere(&known.name))?;
        Some(PointInfo {
            name: known.name.clone(),
            address: None,
            variable: None,
            direction: PointDirection::Loose,
            kind: match known.kind {
                ChannelKind::Digital => SignalKind::Bool,
                ChannelKind::Analog { .. } => SignalKind::Real,
                ChannelKind::Count => SignalKind::Int,
            },
            channel: channel(id),
            image: None,
            forcible: false,
            writable: written(id),
            scale: None,
        })
    });
    let loose: Vec<PointInfo> = loose.collect();
    terminals.into_iter().chain(loose).collect()
}

/// What the words of the analogue channel at this place stand for.
fn scale_at(catalogue: &Catalogue, address: Address) -> Option<WordScale> {
    if address.size() == Size::Bit {
        return None;
    }
    let ends =
        catalogue.module_terminals().at(address, address.bit_len()).find_map(|terminal| terminal.ends())?;
    Some(WordScale { words: ends.words, values: ends.values, unit: ends.unit.to_string() })
}

/// The channel behind each point, in their order.
pub fn channels(points: &[PointInfo], board: &dyn Board) -> Vec<Option<usize>> {
    let place = |point: &PointInfo| {
        let channel = point.channel.as_ref()?;
        board.channels().iter().position(|known| known.name == channel.name)
    };
    points.iter().map(place).collect()
}

fn variable_at(catalogue: &Catalogue, address: Address) -> Option<String> {
    let mut variables = catalogue.programs().first()?.variables().iter();
    let found = variables
        .find(|variable| variable.dimensions.is_empty() && variable.storage == Storage::Located(address));
    found.map(|variable| variable.path.clone())
}

/// The tasks, with the programs that each runs.
pub fn tasks(catalogue: &Catalogue, programs: &[TaskPrograms]) -> Vec<TaskInfo> {
    let known = catalogue.programs().first();
    let places = known.and_then(|program| crate::application::assign(program, programs));
    let named = |name: &str| -> Vec<String> {
        let place = programs.iter().position(|runs| runs.task.eq_ignore_ascii_case(name));
        let run = place.and_then(|place| places.as_ref()?.get(place)).cloned().unwrap_or_default();
        run.iter().filter_map(|place| known?.programs().get(*place).cloned()).collect()
    };
    let task = |config: &TaskConfig| TaskInfo {
        name: config.name.clone(),
        kind: match config.kind {
            TaskKind::Cyclic { .. } => "cyclic",
            TaskKind::Freewheeling => "freewheeling",
            TaskKind::Event { .. } => "event",
            TaskKind::ExternalEvent { .. } => "external-event",
        }
        .into(),
        interval: config.interval().map_or(0, |interval| interval.as_nanos()),
        priority: config.priority,
        watchdog: config.watchdog.map(|watchdog| watchdog.time.as_nanos()),
        programs: named(&config.name),
    };
    catalogue.tasks().iter().map(task).collect()
}

/// The expansion modules.
pub fn modules(catalogue: &Catalogue) -> Vec<ModuleInfo> {
    let module = |(index, one): (usize, &ConfiguredModule<'_>)| ModuleInfo {
        index: u8::try_from(index).unwrap_or(u8::MAX),
        reference: one.module.reference.clone(),
        optional: one.optional,
    };
    catalogue.modules().map(module).collect()
}

/// The expert functions.
pub fn functions(catalogue: &Catalogue) -> Vec<FunctionInfo> {
    let config = catalogue.functions();
    let facts: Vec<String> = crate::application::functions::names(config).collect();
    let function = |known: &expert::FunctionConfig| {
        let prefix = format!("{}.", known.name);
        FunctionInfo {
            name: known.name.clone(),
            kind: words(&known.kind).into(),
            signals: facts.iter().filter(|fact| fact.starts_with(&prefix)).cloned().collect(),
            terminals: known.kind.channels().iter().map(|(_, channel)| channel.to_string()).collect(),
        }
    };
    config.functions.iter().map(function).collect()
}

fn words(kind: &FunctionKind) -> &'static str {
    match kind {
        FunctionKind::Counter(counter) => match (counter.mode, counter.kind) {
            (CounterMode::Frequency { .. }, _) => "HSC frequency meter",
            (CounterMode::Period { .. }, _) => "HSC period meter",
            (CounterMode::EventCounting { .. }, _) => "HSC event counter",
            (_, CounterKind::Simple) => "HSC simple",
            (_, CounterKind::Single) => "HSC main, single phase",
            (_, CounterKind::Dual { .. }) => "HSC main, dual phase",
        },
        FunctionKind::Axis(_) => "PTO",
        FunctionKind::Pwm(_) => "PWM",
        FunctionKind::Generator(_) => "frequency generator",
    }
}

/// The buses of a board, with the ports that are on them.
pub fn buses(board: &dyn Board, file: &BoardFile) -> Vec<BusInfo> {
    let kilobits = |rate: u32| format!("{} kbit/s", f64::from(rate) / 1_000.0);
    let bus = |(number, bus): (u16, &drivers::Bus)| {
        let (kind, settings) = match bus.kind {
            BusKind::Can { bitrate, data_bitrate: None } => ("can", kilobits(bitrate)),
            BusKind::Can { bitrate, data_bitrate: Some(data) } => {
                ("can-fd", format!("{}, data {}", kilobits(bitrate), kilobits(data)))
            }
            BusKind::Serial { settings } => ("serial", settings.to_string()),
        };
        let port = file.ports.iter().find(|binding| binding.bus == BusId(number));
        let port = port.map_or_else(String::new, |binding| binding.port.clone());
        BusInfo { name: bus.name.clone(), kind: kind.into(), settings, port }
    };
    (0..).zip(board.bus_list()).map(bus).collect()
}

/// A frame as clients see it.
pub fn frame(bus: Option<&BusInfo>, at: Time, frame: &CanFrame, own: bool) -> FrameSeen {
    let flags = [(frame.remote, "remote"), (frame.fd, "fd"), (frame.brs, "brs"), (frame.esi, "esi")];
    let flags = flags.into_iter().filter(|(set, _)| *set).map(|(_, flag)| flag.to_owned());
    FrameSeen {
        bus: bus.map_or_else(String::new, |bus| bus.name.clone()),
        at: at.as_nanos(),
        sent: own,
        id: if frame.extended { format!("{:08X}", frame.id) } else { format!("{:03X}", frame.id) },
        flags: flags.collect(),
        data: hexadecimal(frame.data()),
    }
}

/// Characters of a serial line as clients see them.
pub fn serial_message(bus: Option<&BusInfo>, message: &SerialMessage, own: bool) -> FrameSeen {
    let SerialErrors { parity, framing, damaged, breaks, overruns } = message.errors;
    let flags = [
        (parity > 0, "parity"),
        (framing > 0, "framing"),
        (damaged > 0, "damaged"),
        (breaks > 0, "break"),
        (overruns > 0, "overrun"),
        (message.doubtful, "doubtful"),
        (message.continues, "continues"),
        (!message.ends, "goes-on"),
    ];
    let flags = flags.into_iter().filter(|(set, _)| *set).map(|(_, flag)| flag.to_owned());
    FrameSeen {
        bus: bus.map_or_else(String::new, |bus| bus.name.clone()),
        at: message.last.latest.as_nanos(),
        sent: own,
        id: String::new(),
        flags: flags.collect(),
        data: hexadecimal(message.data()),
    }
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02X}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use signal::When;

    #[test]
    fn serial_bytes_have_no_identifier_and_say_what_was_wrong_with_them() {
        let bus = BusInfo { name: "modbus".into(), kind: "serial".into(), ..BusInfo::default() };
        let at = When::exactly(Time::from_nanos(7));
        let mut message = SerialMessage::of(at, at, &[0x01, 0xAF]);
        message.errors = SerialErrors { parity: 2, breaks: 1, ..SerialErrors::NONE };
        let seen = serial_message(Some(&bus), &message, false);
        assert_eq!((seen.bus.as_str(), seen.at, seen.sent), ("modbus", 7, false));
        assert_eq!((seen.id.as_str(), seen.data.as_str()), ("", "01AF"));
        assert_eq!(seen.flags, ["parity", "break"]);
        // The middle of a long message, into which a silence may have slipped.
        message = SerialMessage::begin(at, true);
        message.doubtful = true;
        assert_eq!(serial_message(None, &message, false).flags, ["doubtful", "continues", "goes-on"]);
    }
}
