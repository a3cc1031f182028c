//! How the devices are set up that carry more than levels: converters, serial ports, CAN interfaces.

use super::check::DoctorCheck;
use host::HostMachine;

const GROUP: &str = "devices";

/// The check of what the driver of SPI takes at once.
pub const TRANSFERS: &str = "SPI transfers";

/// Where the kernel makes timers for its converters.
const TIMERS: &str = "/sys/kernel/config/iio/triggers/hrtimer";

/// ASYNC_LOW_LATENCY among the flags of a serial port.
const LOW_LATENCY: u32 = 1 << 13;

/// The longest that an adapter may keep bytes to itself and still count as quick, in ms.
const QUICK: u32 = 1;

/// What there is to say of the devices that are there.
pub fn checks(machine: &HostMachine) -> Vec<DoctorCheck> {
    [transfer(machine), timers(machine), latency(machine)].into_iter().flatten().collect()
}

/// How much the driver of SPI takes at once.
fn transfer(machine: &HostMachine) -> Option<DoctorCheck> {
    if machine.list("/dev", "spidev").is_empty() {
        return None;
    }
    Some(match buffer(machine) {
        Some(bytes) => DoctorCheck::good(GROUP, TRANSFERS, format!("of up to {bytes} bytes")),
        None => DoctorCheck::open(GROUP, TRANSFERS, "the driver does not say how long they may be"),
    })
}

/// Bytes that the driver of SPI takes at once.
pub fn buffer(machine: &HostMachine) -> Option<u32> {
    machine.read("/sys/module/spidev/parameters/bufsiz")?.trim().parse().ok()
}

/// Whether converters can sample by themselves without a trigger of their own.
fn timers(machine: &HostMachine) -> Option<DoctorCheck> {
    const NAME: &str = "ADC timers";
    let devices = machine.list("/sys/bus/iio/devices", "iio:device");
    let buffered =
        devices.iter().any(|name| machine.has(&format!("/sys/bus/iio/devices/{name}/buffer/enable")));
    if !buffered {
        return None;
    }
    Some(if machine.has(TIMERS) {
        DoctorCheck::good(GROUP, NAME, "the kernel makes them")
    } else {
        DoctorCheck::open(GROUP, NAME, "none: with `buffered = true` a converter needs a `trigger`")
            .fix("sudo modprobe iio-trig-hrtimer && echo iio-trig-hrtimer | sudo tee /etc/modules-load.d/rig-iio.conf")
    })
}

/// How long serial ports keep bytes to themselves.
fn latency(machine: &HostMachine) -> Option<DoctorCheck> {
    const NAME: &str = "serial latency";
    let about = |port: &str, file: &str| machine.read(&format!("/sys/class/tty/{port}/{file}"));
    let real = |port: &String| {
        machine.has(&format!("/sys/class/tty/{port}/device/driver"))
            && about(port, "type").as_deref() != Some("0")
    };
    let ports: Vec<String> = machine.list("/sys/class/tty", "tty").into_iter().filter(real).collect();
    // An adapter reports its timer in ms, a port of the mainboard one of its flags.
    let slow = |port: &&String| match about(port, "device/latency_timer") {
        Some(timer) => timer.parse().is_ok_and(|timer: u32| timer > QUICK),
        None => about(port, "flags")
            .and_then(|flags| u32::from_str_radix(flags.trim_start_matches("0x"), 16).ok())
            .is_some_and(|flags| flags & LOW_LATENCY == 0),
    };
    let slow: Vec<&str> = ports.iter().filter(slow).map(String::as_str).collect();
    match (ports.len(), slow.len()) {
        (0, _) => None,
        (_, 0) => Some(DoctorCheck::good(GROUP, NAME, "low, as far as the ports report")),
        _ => {
            let found = format!("{} may keep what comes for some milliseconds", slow.join(", "));
            let check = DoctorCheck::open(GROUP, NAME, found);
            Some(check.then("`low-latency = true` of a serial bus changes that while the rig uses it"))
        }
    }
}
