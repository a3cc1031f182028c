//! Converters, counters and buses of this machine, as a board file describes them.

use super::toml_text::{bare, is_name, quoted};
use drivers::adc::iio::{self, IioDevice};
use drivers::can::{self, Link, Modes};
use drivers::counter::{self, CounterDevice};
use drivers::counting::CountFunction;
use drivers::inventory::{Device, DeviceKind};
use host::HostMachine;
use std::path::Path;

/// How often an input is read that nobody thought about yet.
const PERIOD: &str = "100 ms";

/// Parts of a board file. What could move something, or what cannot be known from outside, stands there as a comment.
#[derive(Debug, Default)]
pub struct ScannedDevices {
    /// Lines under `[converters]`.
    pub converters: String,
    /// Lines under `[counters]`.
    pub counters: String,
    /// Lines under `[generators]`.
    pub generators: String,
    /// Lines under `[channels]`.
    pub channels: String,
    /// Lines under `[buses]`.
    pub buses: String,
    /// Whether something of it is more than a comment.
    pub live: bool,
}

/// What there is on the machine whose `/dev` and `/sys` lie under `root`.
pub fn look(root: &Path, devices: &[Device]) -> ScannedDevices {
    let machine = HostMachine::below(root);
    let mut found = ScannedDevices::default();
    let all = iio::list(root);
    for device in &all {
        converter(&machine, device, &all, &mut found);
    }
    let all = counter::list(root);
    for device in &all {
        counts(&machine, device, &all, &mut found);
    }
    for device in devices {
        match device.kind {
            DeviceKind::Spi => {
                found.converters += &spi(device);
                found.generators += &stream(device);
            }
            DeviceKind::Pwm => found.generators += &pwm(device),
            DeviceKind::Serial => found.buses += &serial(device),
            DeviceKind::Can => {
                let link = if machine.is_here() { can::ask(&device.path).ok() } else { None };
                let (line, live) = interface(device, link.as_ref());
                found.buses += &line;
                found.live |= live;
            }
            _ => {}
        }
    }
    found
}

/// A converter that the kernel has a driver for, with a channel for each input.
fn converter(machine: &HostMachine, device: &IioDevice, all: &[IioDevice], found: &mut ScannedDevices) {
    let twin = all.iter().filter(|other| other.name == device.name).count() > 1;
    let named = !twin && is_name(&device.name);
    let place = device.folder.canonicalize().ok();
    let key = if named { device.name.clone() } else { device.number.replace(':', "-") };
    let by = match place.as_deref().and_then(Path::parent).and_then(Path::to_str) {
        _ if named => format!("name = {}", quoted(&device.name)),
        // Its number may be another with the next start, and the place of its parent is not.
        Some(place) => format!("path = {}", quoted(place)),
        None => format!("path = {}", quoted(&format!("/dev/{}", device.number))),
    };
    let node = format!("/dev/{}", device.number);
    let mut what = format!("{}, {} inputs", device.number, device.inputs.len());
    if device.buffered {
        what += ", can sample by itself: buffered = true";
    }
    let usable = device.node.is_none() || machine.may_use(&node);
    let mark = if usable { "" } else { "# " };
    if !usable {
        what += &format!(", {node} is not to be used: see `rig doctor`");
    }
    found.live |= usable;
    found.converters +=
        &format!("{mark}{} = {{ kind = \"iio\", {by}, period = \"{PERIOD}\" }} # {what}\n", bare(&key));
    for input in &device.inputs {
        let unit = if input.unit.is_empty() { String::new() } else { format!("unit = \"{}\", ", input.unit) };
        let (of, name) = (quoted(&key), quoted(&input.name));
        let channel = bare(&format!("{key}-{}", input.name));
        let label = if input.label.is_empty() { String::new() } else { format!(" # {}", input.label) };
        let label: String = label.chars().filter(|c| !c.is_control()).collect();
        found.channels += &format!(
            "{mark}{channel} = {{ kind = \"analog\", {unit}converter = {of}, input = {name} }}{label}\n"
        );
    }
}

/// A device of the counter subsystem, with a channel for each of its counts.
fn counts(machine: &HostMachine, device: &CounterDevice, all: &[CounterDevice], found: &mut ScannedDevices) {
    let twin = all.iter().filter(|other| other.name == device.name).count() > 1;
    let named = !twin && is_name(&device.name);
    let place = device.folder.canonicalize().ok();
    let key = if named { &device.name } else { &device.number };
    let by = match place.as_deref().and_then(Path::parent).and_then(Path::to_str) {
        _ if named => format!("name = {}", quoted(&device.name)),
        // Its number may be another with the next start, and the place of its parent is not.
        Some(place) => format!("path = {}", quoted(place)),
        None => format!("path = {}", quoted(&format!("/dev/{}", device.number))),
    };
    let node = format!("/dev/{}", device.number);
    let usable = device.node.is_none() || machine.may_use(&node);
    let mark = if usable { "" } else { "# " };
    found.live |= usable && !device.counts.is_empty();
    for count in &device.counts {
        let name = format!("{key}-{}", count.number);
        let known = |kernel: &String| CountFunction::ALL.iter().find(|(.., other)| other == kernel);
        let functions: Vec<&str> =
            count.functions.iter().filter_map(known).map(|(_, name, _)| *name).collect();
        let mut what = format!("{}, can be {}", device.number, functions.join(", "));
        if !usable {
            what += &format!(", {node} is not to be used: see `rig doctor`");
        }
        let function = known(&count.function)
            .map_or_else(String::new, |(_, name, _)| format!(", function = {}", quoted(name)));
        found.counters += &format!(
            "{mark}{} = {{ {by}, count = {}{function}, period = \"{PERIOD}\" }} # {what}\n",
            bare(&name),
            count.number
        );
        found.channels += &format!(
            "{mark}{} = {{ kind = \"count\", counter = {} }}\n",
            bare(&format!("{name}-count")),
            quoted(&name)
        );
    }
}

/// A chip select: what is connected to it cannot be asked.
fn spi(device: &Device) -> String {
    let name = device.path.trim_start_matches("/dev/").replace('.', "-");
    let part = device.what.strip_prefix("spi:").filter(|part| is_name(part)).unwrap_or("mcp3008");
    let (path, part) = (quoted(&device.path), quoted(part));
    format!(
        "# {name} = {{ kind = \"spi\", path = {path}, part = {part}, reference = \"3.3 V\" }} # if that is what is connected\n"
    )
}

/// The data line of a chip select, which moves something as soon as it is taken.
fn stream(device: &Device) -> String {
    let name = device.path.trim_start_matches("/dev/").replace('.', "-");
    let path = quoted(&device.path);
    format!(
        "# {name}-out = {{ kind = \"spi\", path = {path} }} # if nothing is connected but a wire from its data line\n"
    )
}

/// A PWM chip: its outputs move something as soon as they are taken.
fn pwm(device: &Device) -> String {
    let name = device.path.rsplit('/').find(|part| *part != "pwm").unwrap_or("pwm");
    let (key, path) = (name.replace(['.', ':', '@'], "-"), quoted(&device.path));
    format!("# {} = {{ kind = \"pwm\", path = {path} }} # {}\n", bare(&key), device.what)
}

/// A serial port: to open it may move its control lines.
fn serial(device: &Device) -> String {
    let name = device.path.rsplit('/').next().unwrap_or("serial");
    let port = device.what.split(',').next().filter(|word| word.starts_with("tty")).unwrap_or(name);
    let what: String = device.what.chars().filter(|c| !c.is_control()).collect();
    format!("# {} = {{ kind = \"serial\", path = {} }} # {what}\n", bare(port), quoted(&device.path))
}

/// A CAN interface, and whether it can be used as it is.
fn interface(device: &Device, link: Option<&Link>) -> (String, bool) {
    let name = &device.path;
    let bits = link.and_then(|link| link.bits);
    let live = link.is_some_and(|link| link.up) && bits.is_some() && is_name(name);
    let mut keys = format!("kind = \"can\", interface = {}", quoted(name));
    keys += &format!(", bitrate = {}", bits.map_or(500_000, |bits| bits.bitrate));
    let mut what = device.what.clone();
    match link {
        Some(link) => {
            if let Some(data) = link.data_bits.filter(|_| link.modes.has(Modes::FD)) {
                keys += &format!(", data-bitrate = {}", data.bitrate);
            }
            if link.modes.has(Modes::LISTEN_ONLY) {
                keys += ", listen-only = true";
            }
            what += &can::words(link);
        }
        None => what += ", not asked",
    }
    let what = what.trim_start_matches(", ");
    let mark = if live { "" } else { "# " };
    (format!("{mark}{} = {{ {keys} }} # {what}\n", bare(name)), live)
}

#[cfg(test)]
mod tests {
    use super::*;
    use drivers::BusState;
    use drivers::can::BitTiming;
    use std::fs;

    fn device(kind: DeviceKind, path: &str, what: &str) -> Device {
        Device { kind, path: path.into(), what: what.into() }
    }

    #[test]
    fn a_bus_is_taken_as_it_is_set_up_and_one_that_is_down_is_a_comment() {
        let can = device(DeviceKind::Can, "can0", "mcp251xfd");
        let link = Link {
            index: 3,
            name: "can0".into(),
            up: true,
            running: true,
            mtu: 72,
            kind: "can".into(),
            bits: Some(BitTiming { bitrate: 250_000, sample_point: 875 }),
            data_bits: Some(BitTiming { bitrate: 2_000_000, sample_point: 750 }),
            state: Some(BusState::ErrorActive),
            modes: Modes(Modes::FD),
            restart_ms: 0,
            errors: None,
        };
        let line = "can0 = { kind = \"can\", interface = \"can0\", bitrate = 250000, data-bitrate = 2000000 } # \
                    mcp251xfd, 250000 bit/s and 2000000 bit/s, up\n";
        assert_eq!(interface(&can, Some(&link)), (line.to_owned(), true));
        let (line, live) = interface(&can, Some(&Link { up: false, bits: None, ..link }));
        assert!(!live && line.starts_with("# can0 = ") && line.contains("bitrate = 500000"), "{line}");
        assert!(interface(&can, None).0.ends_with("# mcp251xfd, not asked\n"));
    }

    #[test]
    fn what_nobody_can_tell_or_what_moves_something_is_a_comment() {
        let root = std::env::temp_dir().join(format!("scanrig-found-{}", std::process::id()));
        let at = root.join("sys/bus/iio/devices/iio:device0");
        fs::create_dir_all(&at).unwrap();
        for (file, text) in
            [("name", "ads8688"), ("in_voltage0_raw", "1"), ("in_temp_raw", "1"), ("in_temp_label", "box")]
        {
            fs::write(at.join(file), text).unwrap();
        }
        let at = root.join("sys/bus/counter/devices/counter0");
        fs::create_dir_all(at.join("count1")).unwrap();
        for (file, text) in [
            ("name", "ti-eqep"),
            ("count1/function", "quadrature x4"),
            ("count1/function_available", "increase\nquadrature x4\n"),
        ] {
            fs::write(at.join(file), text).unwrap();
        }
        let found = look(
            &root,
            &[
                device(DeviceKind::Spi, "/dev/spidev0.0", "spi:mcp3208"),
                device(DeviceKind::Serial, "/dev/serial/by-id/usb-x", "ttyUSB0, ftdi"),
                device(DeviceKind::Pwm, "/sys/devices/platform/soc/fe20c000.pwm", "2 outputs"),
            ],
        );
        let _ = fs::remove_dir_all(&root);
        assert!(found.live);
        assert_eq!(
            found.converters,
            "ads8688 = { kind = \"iio\", name = \"ads8688\", period = \"100 ms\" } # iio:device0, 2 inputs\n\
             # spidev0-0 = { kind = \"spi\", path = \"/dev/spidev0.0\", part = \"mcp3208\", reference = \"3.3 V\" } \
             # if that is what is connected\n"
        );
        assert_eq!(
            found.counters,
            "ti-eqep-1 = { name = \"ti-eqep\", count = 1, function = \"quadrature-x4\", period = \"100 ms\" } \
             # counter0, can be increase, quadrature-x4\n"
        );
        assert_eq!(
            found.channels,
            "ads8688-temp = { kind = \"analog\", unit = \"degC\", converter = \"ads8688\", input = \"temp\" } # box\n\
             ads8688-voltage0 = { kind = \"analog\", unit = \"V\", converter = \"ads8688\", input = \"voltage0\" }\n\
             ti-eqep-1-count = { kind = \"count\", counter = \"ti-eqep-1\" }\n"
        );
        assert_eq!(
            found.generators,
            "# spidev0-0-out = { kind = \"spi\", path = \"/dev/spidev0.0\" } # if nothing is connected but a wire \
             from its data line\n\
             # fe20c000-pwm = { kind = \"pwm\", path = \"/sys/devices/platform/soc/fe20c000.pwm\" } # 2 outputs\n"
        );
        assert_eq!(
            found.buses,
            "# ttyUSB0 = { kind = \"serial\", path = \"/dev/serial/by-id/usb-x\" } # ttyUSB0, ftdi\n"
        );
    }
}
