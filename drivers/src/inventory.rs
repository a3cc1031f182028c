//! What devices a machine has beside GPIO, by the paths that stay from one start of the machine to the next.
//! Nothing is opened to find out.

use std::fs;
use std::path::{Path, PathBuf};

/// What a device is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum DeviceKind {
    /// A chip select of an SPI bus.
    Spi,
    /// A serial port.
    Serial,
    /// A CAN interface.
    Can,
    /// A converter of the industrial I/O subsystem.
    Iio,
    /// A counter.
    Counter,
    /// A chip of PWM outputs.
    Pwm,
    /// A watchdog.
    Watchdog,
}

impl DeviceKind {
    /// All, in the order in which they are listed.
    pub const ALL: [DeviceKind; 7] = [
        DeviceKind::Spi,
        DeviceKind::Serial,
        DeviceKind::Can,
        DeviceKind::Iio,
        DeviceKind::Counter,
        DeviceKind::Pwm,
        DeviceKind::Watchdog,
    ];

    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            DeviceKind::Spi => "spi",
            DeviceKind::Serial => "serial",
            DeviceKind::Can => "can",
            DeviceKind::Iio => "iio",
            DeviceKind::Counter => "counter",
            DeviceKind::Pwm => "pwm",
            DeviceKind::Watchdog => "watchdog",
        }
    }
}

/// A device that is there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Device {
    /// What it is for.
    pub kind: DeviceKind,
    /// How to name it so that it stays: a path, or the name of an interface.
    pub path: String,
    /// What it is, as its driver says: a model, a driver; may be empty.
    pub what: String,
}

/// Devices of the machine whose `/dev` and `/sys` lie under `root`, by kind and path. What cannot be read is left
/// out: a machine without a subsystem has none of its devices.
pub fn devices(root: &Path) -> Vec<Device> {
    let mut found = Vec::new();
    for kind in DeviceKind::ALL {
        let mut some = match kind {
            DeviceKind::Serial => serial(root),
            _ => class(root, kind),
        };
        some.sort_by_key(|device| natural(&device.path));
        found.append(&mut some);
    }
    found
}

/// Devices that a subsystem lists in one folder of `/sys`.
fn class(root: &Path, kind: DeviceKind) -> Vec<Device> {
    let folder = match kind {
        DeviceKind::Spi => "sys/class/spidev",
        DeviceKind::Can => "sys/class/net",
        DeviceKind::Iio => "sys/bus/iio/devices",
        DeviceKind::Counter => "sys/bus/counter/devices",
        DeviceKind::Pwm => "sys/class/pwm",
        DeviceKind::Watchdog => "sys/class/watchdog",
        DeviceKind::Serial => "sys/class/tty",
    };
    let entries = names(&root.join(folder));
    let device = |name: &String| describe(kind, name, &root.join(folder).join(name));
    entries.iter().filter_map(device).collect()
}

/// What `/sys` says about a device; `None` for what stands in the folder beside the devices.
fn describe(kind: DeviceKind, name: &str, at: &Path) -> Option<Device> {
    let driver = || target(&at.join("device/driver")).unwrap_or_default();
    let (path, what) = match kind {
        DeviceKind::Spi => (format!("/dev/{name}"), line(&at.join("device/modalias"))),
        // ARPHRD_CAN; a virtual one has no driver of its own.
        DeviceKind::Can if line(&at.join("type")) == "280" => (name.to_owned(), driver()),
        DeviceKind::Iio if name.starts_with("iio:device") => (format!("/dev/{name}"), line(&at.join("name"))),
        DeviceKind::Counter if name.starts_with("counter") => {
            (format!("/dev/{name}"), line(&at.join("name")))
        }
        DeviceKind::Pwm => (place(at), format!("{} outputs", line(&at.join("npwm")))),
        DeviceKind::Watchdog => (format!("/dev/{name}"), line(&at.join("identity"))),
        _ => return None,
    };
    Some(Device { kind, path, what })
}

/// Serial ports: by the links that follow the device, where there are some. A name like `ttyUSB0` follows the order
/// in which devices were found.
fn serial(root: &Path) -> Vec<Device> {
    let mut linked: Vec<(String, String)> = Vec::new();
    for folder in ["dev/serial/by-id", "dev/serial/by-path"] {
        for name in names(&root.join(folder)) {
            let Some(port) = target(&root.join(folder).join(&name)) else { continue };
            if linked.iter().all(|(known, _)| *known != port) {
                linked.push((port, format!("/{folder}/{name}")));
            }
        }
    }
    let ports = names(&root.join("sys/class/tty"));
    let device = |name: &String| {
        let at = root.join("sys/class/tty").join(name);
        let driver = target(&at.join("device/driver"))?;
        // The kernel keeps places for ports of the mainboard that no chip is behind: their type is 0.
        if line(&at.join("type")) == "0" {
            return None;
        }
        let link = linked.iter().find(|(port, _)| port == name).map(|(_, link)| link.clone());
        let (path, what) = match link {
            Some(link) => (link, format!("{name}, {driver}")),
            None => (format!("/dev/{name}"), driver),
        };
        Some(Device { kind: DeviceKind::Serial, path, what })
    };
    ports.iter().filter_map(device).collect()
}

/// Names in a folder, in order; none where there is no such folder.
pub(crate) fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<String> = entries.filter_map(|entry| entry.file_name().into_string().ok()).collect();
    names.sort();
    names
}

/// The first line of a file; empty where there is none.
pub(crate) fn line(path: &Path) -> String {
    let text = fs::read_to_string(path).unwrap_or_default();
    text.lines().next().unwrap_or_default().trim().to_owned()
}

/// The last part of what a link points to.
fn target(link: &Path) -> Option<String> {
    Some(fs::read_link(link).ok()?.file_name()?.to_string_lossy().into_owned())
}

/// The place of a device in `/sys`, from which its number has gone where the link gives its place.
fn place(at: &Path) -> String {
    let device = fs::canonicalize(at.join("device")).ok();
    let inside = device.and_then(|path| {
        let parts: PathBuf = path.iter().skip_while(|part| *part != "sys").collect();
        (!parts.as_os_str().is_empty()).then_some(parts)
    });
    inside.map_or_else(
        || at.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default(),
        |path| format!("/{}", path.display()),
    )
}

/// A key that sorts `spidev0.10` after `spidev0.9`.
fn natural(text: &str) -> Vec<(bool, u64, String)> {
    let mut parts: Vec<(bool, u64, String)> = Vec::new();
    for c in text.chars() {
        match (parts.last_mut(), c.to_digit(10)) {
            (Some((true, number, _)), Some(digit)) => {
                *number = number.saturating_mul(10).saturating_add(u64::from(digit));
            }
            (_, Some(digit)) => parts.push((true, u64::from(digit), String::new())),
            (Some((false, _, letters)), None) => letters.push(c),
            (_, None) => parts.push((false, 0, c.to_string())),
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    /// A made-up machine, which goes with the test.
    struct Machine(PathBuf);

    impl Machine {
        fn new(name: &str) -> Machine {
            let root = std::env::temp_dir().join(format!("scanrig-{name}-{}", std::process::id()));
            let _ = fs::remove_dir_all(&root);
            fs::create_dir_all(&root).unwrap();
            Machine(root)
        }

        fn file(&self, path: &str, text: &str) {
            let path = self.0.join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }

        fn link(&self, path: &str, to: &str) {
            let path = self.0.join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            symlink(to, path).unwrap();
        }

        fn found(&self) -> Vec<String> {
            let text = |device: &Device| format!("{} {} {}", device.kind.name(), device.path, device.what);
            devices(&self.0).iter().map(text).collect()
        }
    }

    impl Drop for Machine {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    #[test]
    fn a_machine_without_devices_has_none() {
        assert_eq!(Machine::new("bare").found(), Vec::<String>::new());
    }

    #[test]
    fn devices_are_named_by_what_stays() {
        let machine = Machine::new("full");
        for place in ["spidev0.10", "spidev0.9"] {
            machine.file(&format!("sys/class/spidev/{place}/device/modalias"), "spi:mcp3008\n");
        }
        // A port with a link by what it is, one with a link by where it is, one with none, and a place without a chip.
        for (port, kind) in [("ttyUSB0", "14"), ("ttyAMA0", "32"), ("ttyS0", "4"), ("ttyS1", "0")] {
            machine.file(&format!("sys/class/tty/{port}/type"), kind);
            machine.link(&format!("sys/class/tty/{port}/device/driver"), "../../drivers/uart");
        }
        machine.file("sys/class/tty/console/dev", "5:1");
        machine.link("dev/serial/by-id/usb-FTDI_0-if00", "../../ttyUSB0");
        machine.link("dev/serial/by-path/pci-usb-0:1", "../../ttyUSB0");
        machine.link("dev/serial/by-path/platform-uart0", "../../ttyAMA0");
        machine.file("sys/class/net/can0/type", "280\n");
        machine.link("sys/class/net/can0/device/driver", "../../drivers/mcp251xfd");
        machine.file("sys/class/net/eth0/type", "1\n");
        machine.file("sys/bus/iio/devices/iio:device0/name", "ads8688\n");
        machine.file("sys/bus/iio/devices/trigger0/name", "timer\n");
        machine.file("sys/bus/counter/devices/counter0/name", "ti-eqep\n");
        machine.file("sys/devices/platform/pwm@20/npwm", "2\n");
        machine.link("sys/class/pwm/pwmchip0/device", "../../../devices/platform/pwm@20");
        machine.file("sys/class/pwm/pwmchip0/npwm", "2\n");
        machine.file("sys/class/watchdog/watchdog0/identity", "Broadcom BCM2835\n");
        assert_eq!(
            machine.found(),
            [
                "spi /dev/spidev0.9 spi:mcp3008",
                "spi /dev/spidev0.10 spi:mcp3008",
                "serial /dev/serial/by-id/usb-FTDI_0-if00 ttyUSB0, uart",
                "serial /dev/serial/by-path/platform-uart0 ttyAMA0, uart",
                "serial /dev/ttyS0 uart",
                "can can0 mcp251xfd",
                "iio /dev/iio:device0 ads8688",
                "counter /dev/counter0 ti-eqep",
                "pwm /sys/devices/platform/pwm@20 2 outputs",
                "watchdog /dev/watchdog0 Broadcom BCM2835",
            ]
        );
    }
}
