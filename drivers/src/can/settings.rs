//! Whether an interface is set up as the board file says, and what sets it up so.

use super::link::{BitTiming, Link, Modes};
use super::spec::CanBusSpec;

/// What differs, each in words. Interfaces without bits agree with any bit rate.
pub fn differences(spec: &CanBusSpec, link: &Link) -> Vec<String> {
    let mut found = Vec::new();
    let fd = spec.data_bitrate.is_some();
    if link.is_virtual() {
        if fd && link.mtu < super::wire::FD as u32 {
            found.push(String::from("it takes classic frames only"));
        }
        return found;
    }
    bits("", Some(spec.bitrate), spec.sample_point, link.bits, &mut found);
    match (fd, link.modes.has(Modes::FD)) {
        (true, false) => found.push(String::from("CAN FD is off")),
        (false, true) => found.push(String::from("CAN FD is on, and the board file names no `data-bitrate`")),
        _ => {}
    }
    if fd {
        bits("data ", spec.data_bitrate, spec.data_sample_point, link.data_bits, &mut found);
    }
    if link.modes.has(Modes::LISTEN_ONLY) != spec.listen_only {
        found.push(format!("listen-only is {}", if spec.listen_only { "off" } else { "on" }));
    }
    if link.modes.has(Modes::LOOPBACK) {
        found.push(String::from("loopback is on: nothing reaches the bus"));
    }
    if let Some(restart) = spec.restart {
        let wanted = restart.as_nanos() / 1_000_000;
        // What the kernel leaves to others the rig does, unless it sets up the kernel anyway.
        if i64::from(link.restart_ms) != wanted && (link.restart_ms > 0 || spec.configure) {
            found.push(match link.restart_ms {
                0 => format!("it stays off the bus after bus-off, not {wanted} ms"),
                has => format!("it starts again {has} ms after bus-off, not {wanted} ms"),
            });
        }
    }
    found
}

fn bits(
    which: &str,
    bitrate: Option<u32>,
    sample_point: Option<u32>,
    has: Option<BitTiming>,
    out: &mut Vec<String>,
) {
    let (Some(wanted), Some(has)) = (bitrate, has) else {
        return out.push(format!("it has no {which}bit rate"));
    };
    if has.bitrate != wanted {
        out.push(format!("its {which}bit rate is {} bit/s, not {wanted} bit/s", has.bitrate));
    }
    if let Some(wanted) = sample_point.filter(|wanted| *wanted != has.sample_point) {
        out.push(format!(
            "its {which}sample point is {}, not {}",
            thousandths(has.sample_point),
            thousandths(wanted)
        ));
    }
}

fn thousandths(number: u32) -> String {
    format!("{}.{:03}", number / 1_000, number % 1_000)
}

/// The commands that set an interface up as the board file says.
pub fn fix_command(spec: &CanBusSpec, link: &Link) -> String {
    let name = &spec.interface;
    if link.is_virtual() {
        return format!("ip link set {name} down && ip link set {name} mtu 72 up");
    }
    let mut line = format!("ip link set {name} down && ip link set {name} type can bitrate {}", spec.bitrate);
    if let Some(point) = spec.sample_point {
        line += &format!(" sample-point {}", thousandths(point));
    }
    if let Some(rate) = spec.data_bitrate {
        line += &format!(" dbitrate {rate}");
        if let Some(point) = spec.data_sample_point {
            line += &format!(" dsample-point {}", thousandths(point));
        }
        line += " fd on";
    } else if link.modes.has(Modes::FD) {
        line += " fd off";
    }
    if spec.listen_only != link.modes.has(Modes::LISTEN_ONLY) {
        line += if spec.listen_only { " listen-only on" } else { " listen-only off" };
    }
    if link.modes.has(Modes::LOOPBACK) {
        line += " loopback off";
    }
    if let Some(restart) = spec.restart {
        line += &format!(" restart-ms {}", restart.as_nanos() / 1_000_000);
    }
    format!("{line} && ip link set {name} up")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BusId, BusState};
    use signal::Span;

    fn spec() -> CanBusSpec {
        CanBusSpec {
            bus: BusId(0),
            name: "machine".into(),
            place: 0..0,
            interface_place: 0..0,
            interface: "can0".into(),
            bitrate: 500_000,
            sample_point: None,
            data_bitrate: None,
            data_sample_point: None,
            accept: Vec::new(),
            restart: None,
            listen_only: false,
            configure: false,
        }
    }

    fn link() -> Link {
        Link {
            index: 3,
            name: "can0".into(),
            up: true,
            running: true,
            mtu: 16,
            kind: "can".into(),
            bits: Some(BitTiming { bitrate: 250_000, sample_point: 875 }),
            data_bits: None,
            state: Some(BusState::ErrorActive),
            modes: Modes::default(),
            restart_ms: 0,
            errors: None,
        }
    }

    #[test]
    fn every_difference_is_said_and_one_line_mends_them_all() {
        let spec = CanBusSpec {
            sample_point: Some(800),
            data_bitrate: Some(2_000_000),
            restart: Some(Span::from_millis(100)),
            ..spec()
        };
        let link = Link { modes: Modes(Modes::LISTEN_ONLY | Modes::LOOPBACK), restart_ms: 50, ..link() };
        assert_eq!(
            differences(&spec, &link).join("\n"),
            "its bit rate is 250000 bit/s, not 500000 bit/s\nits sample point is 0.875, not 0.800\n\
             CAN FD is off\nit has no data bit rate\nlisten-only is on\nloopback is on: nothing reaches the bus\n\
             it starts again 50 ms after bus-off, not 100 ms"
        );
        assert_eq!(
            fix_command(&spec, &link),
            "ip link set can0 down && ip link set can0 type can bitrate 500000 sample-point 0.800 dbitrate 2000000 \
             fd on listen-only off loopback off restart-ms 100 && ip link set can0 up"
        );
    }

    #[test]
    fn a_restart_that_the_kernel_leaves_is_the_rigs_unless_it_sets_up_the_kernel() {
        let bus = CanBusSpec { bitrate: 250_000, restart: Some(Span::from_millis(100)), ..spec() };
        assert_eq!(differences(&bus, &link()), Vec::<String>::new());
        let configured = CanBusSpec { configure: true, ..bus };
        assert_eq!(differences(&configured, &link()), ["it stays off the bus after bus-off, not 100 ms"]);
    }

    #[test]
    fn a_virtual_bus_has_no_bits_and_one_that_agrees_differs_in_nothing() {
        let virtual_bus = Link { kind: "vcan".into(), bits: None, mtu: 72, ..link() };
        let fd = CanBusSpec { data_bitrate: Some(1), ..spec() };
        assert_eq!(differences(&fd, &virtual_bus), Vec::<String>::new());
        assert_eq!(differences(&fd, &Link { mtu: 16, ..virtual_bus }).len(), 1);
        let slow = CanBusSpec { bitrate: 250_000, ..spec() };
        assert_eq!(differences(&slow, &link()), Vec::<String>::new());
    }
}
