//! The devices of this machine that a board can be made of, and whether this user may use them.

use super::check::{CheckState, DoctorCheck};
use drivers::{BusState, can};
use host::HostMachine;

/// The group of the devices.
pub const GROUP: &str = "devices";

/// ARPHRD_CAN: the type of a network interface that is a CAN controller.
const CAN: &str = "280";

/// The first kernel that reports when edges of a GPIO line were lost.
const GPIO_V2: (u32, u32) = (5, 10);

/// A kind of device that programs open by a node or a file.
struct DeviceClass {
    name: &'static str,
    /// Where they are listed, and how their names begin.
    folder: &'static str,
    prefix: &'static str,
    /// The file of one that has to be written, in which `{}` is its name.
    file: &'static str,
    /// Its subsystem, and the group to which distributions give it.
    subsystem: &'static str,
    group: &'static str,
}

const KINDS: &[DeviceClass] = &[
    DeviceClass {
        name: "GPIO",
        folder: "/dev",
        prefix: "gpiochip",
        file: "/dev/{}",
        subsystem: "gpio",
        group: "gpio",
    },
    DeviceClass {
        name: "SPI",
        folder: "/dev",
        prefix: "spidev",
        file: "/dev/{}",
        subsystem: "spidev",
        group: "spi",
    },
    DeviceClass {
        name: "serial",
        folder: "/dev/serial/by-id",
        prefix: "",
        file: "/dev/serial/by-id/{}",
        subsystem: "tty",
        group: "dialout",
    },
    DeviceClass {
        name: "ADC",
        folder: "/sys/bus/iio/devices",
        prefix: "iio:device",
        file: "/dev/{}",
        subsystem: "iio",
        group: "iio",
    },
    DeviceClass {
        name: "counter",
        folder: "/dev",
        prefix: "counter",
        file: "/dev/{}",
        subsystem: "counter",
        group: "gpio",
    },
    DeviceClass {
        name: "PWM",
        folder: "/sys/class/pwm",
        prefix: "pwmchip",
        file: "/sys/class/pwm/{}/export",
        subsystem: "pwm",
        group: "gpio",
    },
];

/// Every kind of device.
pub fn checks(machine: &HostMachine) -> Vec<DoctorCheck> {
    let mut checks: Vec<DoctorCheck> = KINDS.iter().map(|kind| devices(machine, kind)).collect();
    checks.push(can(machine));
    checks
}

fn devices(machine: &HostMachine, kind: &DeviceClass) -> DoctorCheck {
    let names = machine.list(kind.folder, kind.prefix);
    let gpio = kind.subsystem == "gpio";
    if names.is_empty() {
        return match () {
            () if gpio => DoctorCheck::bad(GROUP, kind.name, "none")
                .means("there are no lines here: plans run on the simulated board, and on no other"),
            () if kind.subsystem == "spidev" && machine.has("/boot/firmware/config.txt") => {
                DoctorCheck::open(GROUP, kind.name, "none").fix("sudo raspi-config nonint do_spi 0")
            }
            () => DoctorCheck::open(GROUP, kind.name, "none"),
        };
    }
    let file = |name: &str| kind.file.replace("{}", name);
    match names.iter().find(|name| !machine.may_use(&file(name))) {
        Some(refused) => {
            let found = format!("{}; {} is not to be used", names.join(", "), file(refused));
            let mut check = if gpio {
                DoctorCheck::bad(GROUP, kind.name, found).means("the rig may neither read nor drive lines")
            } else {
                DoctorCheck::poor(GROUP, kind.name, found).means("the rig may not use it")
            };
            let (fix, then) = grant(machine, &file(refused), kind.subsystem, kind.group);
            check = check.fix(fix).then(then);
            check
        }
        None if gpio && version(machine).is_some_and(|version| version < GPIO_V2) => {
            DoctorCheck::poor(GROUP, kind.name, format!("{}, by the first interface", names.join(", ")))
                .means("edges that get lost go unnoticed; a kernel from 5.10 reports them")
        }
        None => DoctorCheck::good(GROUP, kind.name, names.join(", ")),
    }
}

/// Major and minor number of the kernel.
pub fn version(machine: &HostMachine) -> Option<(u32, u32)> {
    let release = machine.release()?;
    let mut numbers = release.split(|c: char| !c.is_ascii_digit()).map(str::parse);
    Some((numbers.next()?.ok()?, numbers.next()?.ok()?))
}

/// The line that gives a file to this user, and what has to be done after it.
pub fn grant(machine: &HostMachine, file: &str, subsystem: &str, group: &str) -> (String, &'static str) {
    let owner = machine.mode(file).filter(|(mode, _, _)| mode & 0o060 == 0o060);
    let name = owner.and_then(|(_, _, gid)| group_name(machine, gid)).filter(|name| name != "root");
    match name {
        Some(name) => (format!("sudo usermod -aG {name} \"$USER\""), "log in again"),
        None => (
            format!(
                "sudo groupadd -f {group} && sudo usermod -aG {group} \"$USER\" && \
                 echo 'SUBSYSTEM==\"{subsystem}\", GROUP=\"{group}\", MODE=\"0660\"' | \
                 sudo tee /etc/udev/rules.d/60-rig-{subsystem}.rules && sudo udevadm control --reload && \
                 sudo udevadm trigger --subsystem-match={subsystem}"
            ),
            "log in again",
        ),
    }
}

fn group_name(machine: &HostMachine, gid: u32) -> Option<String> {
    let text = machine.read("/etc/group")?;
    text.lines().find_map(|line| {
        let mut fields = line.split(':');
        let name = fields.next()?;
        (fields.nth(1)?.parse() == Ok(gid)).then(|| name.to_owned())
    })
}

/// CAN controllers are network interfaces: everybody may use them, and somebody has to switch them on.
fn can(machine: &HostMachine) -> DoctorCheck {
    const NAME: &str = "CAN";
    let about = |name: &str, file: &str| machine.read(&format!("/sys/class/net/{name}/{file}"));
    let mut names = machine.list("/sys/class/net", "");
    names.retain(|name| about(name, "type").as_deref() == Some(CAN));
    if names.is_empty() {
        return DoctorCheck::open(GROUP, NAME, "none");
    }
    let up = |name: &String| {
        let flags = about(name, "flags").unwrap_or_default();
        u32::from_str_radix(flags.trim_start_matches("0x"), 16).is_ok_and(|flags| flags & 1 == 1)
    };
    match names.iter().find(|name| !up(name)) {
        None => can_up(machine, &names),
        Some(down) => {
            let mut check =
                DoctorCheck::good(GROUP, NAME, format!("{}; {down} is switched off", names.join(", ")));
            check.state = CheckState::Open;
            check.fix(format!("sudo ip link set {down} up type can bitrate 500000"))
        }
    }
}

/// Interfaces that are switched on: how they are set up, as far as this machine can be asked.
fn can_up(machine: &HostMachine, names: &[String]) -> DoctorCheck {
    const NAME: &str = "CAN";
    if !machine.is_here() {
        return DoctorCheck::good(GROUP, NAME, names.join(", "));
    }
    let links: Vec<can::Link> = names.iter().filter_map(|name| can::ask(name).ok()).collect();
    let words: Vec<String> = links.iter().map(|link| format!("{}{}", link.name, can::words(link))).collect();
    match links.iter().find(|link| link.state == Some(BusState::BusOff)) {
        None => DoctorCheck::good(GROUP, NAME, words.join("; ")),
        Some(off) => DoctorCheck::poor(GROUP, NAME, words.join("; "))
            .means("nothing passes there before its controller is started again")
            .fix(format!("sudo ip link set {} type can restart", off.name))
            .then("look at bit rate, termination and cable: too many errors made it give up"),
    }
}
