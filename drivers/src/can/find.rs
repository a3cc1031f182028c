//! The interface of a bus on this machine, and whether it is as the board file says.

use document::{Diagnostic, suggest};
use rustix::io::Errno;

use super::configure::{is_ready, may_change};
use super::link::Link;
use super::netlink::ask;
use super::settings::{differences, fix_command};
use super::spec::CanBusSpec;
use crate::BusState;
use crate::codes;
use crate::refusal::Refusal;

/// Names of the CAN interfaces of this machine, in order.
pub fn interfaces() -> Vec<String> {
    let is_can = |name: &String| {
        std::fs::read_to_string(format!("/sys/class/net/{name}/type")).is_ok_and(|kind| kind.trim() == TYPE)
    };
    let entries = std::fs::read_dir("/sys/class/net").into_iter().flatten().flatten();
    let mut all: Vec<String> =
        entries.filter_map(|entry| entry.file_name().into_string().ok()).filter(is_can).collect();
    all.sort();
    all
}

/// What the kernel calls CAN among the kinds of networks (ARPHRD_CAN).
const TYPE: &str = "280";

/// Sees that the interface of a bus is there, up and set up as the file says.
///
/// # Errors
/// What is wrong with it, at its place in the file.
pub fn find(file: &str, spec: &CanBusSpec) -> Result<(), Diagnostic> {
    look(spec).map_err(|refusal| refusal.finding(file, spec.interface_place.clone()))
}

fn look(spec: &CanBusSpec) -> Result<(), Refusal> {
    let name = &spec.interface;
    let link = match ask(name) {
        Ok(link) => link,
        Err(error) if error.raw_os_error() == Some(Errno::NODEV.raw_os_error()) => {
            let all = interfaces();
            let help = match suggest(name, all.iter().map(String::as_str)) {
                Some(meant) => format!("did you mean {meant}?"),
                None if all.is_empty() => String::from("this machine has no CAN interface: see `ip link`"),
                None => format!("there are {}", all.join(", ")),
            };
            let message = format!("this machine has no interface {name}");
            return Err(Refusal::new(codes::CAN_MISSING, message, help));
        }
        Err(error) => {
            let message = format!("the kernel says nothing of {name}: {error}");
            return Err(Refusal::new(codes::CAN_REFUSED, message, "see what `ip link` says"));
        }
    };
    if !interfaces().contains(name) {
        let message = format!("{name} is no CAN interface");
        return Err(Refusal::new(codes::CAN_MISSING, message, "name one of a CAN controller, as in can0"));
    }
    check(spec, &link)
}

/// The privilege to change interfaces (CAP_NET_ADMIN).
const PRIVILEGE: &str = "run `sudo setcap cap_net_admin+ep \"$(command -v rig)\"`";

/// Whether the rig is to start a controller again after bus-off: the board file wants it, and the kernel leaves it.
pub(super) fn restarts_by_rig(spec: &CanBusSpec, link: &Link) -> bool {
    spec.restart.is_some() && link.restart_ms == 0 && !link.is_virtual()
}

/// How an interface is set up and how it fares, in words after its name.
pub fn words(link: &Link) -> String {
    let mut words = String::new();
    if let Some(bits) = link.bits {
        words += &format!(", {} bit/s", bits.bitrate);
    }
    if let Some(bits) = link.data_bits {
        words += &format!(" and {} bit/s", bits.bitrate);
    }
    words += match (link.up, link.state) {
        (false, _) => ", down",
        (true, None | Some(BusState::ErrorActive)) => ", up",
        (true, Some(BusState::ErrorWarning)) => ", up, with errors",
        (true, Some(BusState::ErrorPassive)) => ", error-passive",
        (true, Some(BusState::BusOff)) => ", bus-off",
        (true, Some(BusState::Stopped)) => ", up, its controller stopped",
    };
    if link.restart_ms > 0 {
        words += &format!(", starts again {} ms after bus-off", link.restart_ms);
    }
    words
}

/// Whether an interface is set up for a bus, or the rig may do so.
///
/// # Errors
/// What is wrong with it.
pub fn check(spec: &CanBusSpec, link: &Link) -> Result<(), Refusal> {
    let name = &spec.interface;
    if spec.configure {
        if is_ready(spec, link) || may_change(link) {
            return Ok(());
        }
        let help = format!("{PRIVILEGE}, or run `{}` as root", fix_command(spec, link));
        let message = format!("the rig is to set up {name}, and may not");
        return Err(Refusal::new(codes::CAN_ACCESS, message, help));
    }
    let differ = differences(spec, link);
    if !differ.is_empty() {
        let message = format!("{name} is not set up as the board file says: {}", differ.join("; "));
        return Err(Refusal::new(codes::CAN_SETTINGS, message, format!("run `{}`", fix_command(spec, link))));
    }
    if !link.up {
        let help = format!("run `ip link set {name} up`");
        return Err(Refusal::new(codes::CAN_DOWN, format!("{name} is down"), help));
    }
    if restarts_by_rig(spec, link) && !may_change(link) {
        let message = format!("the rig is to start {name} again after bus-off, and may not");
        let help = format!("{PRIVILEGE}, or let the kernel do it: run `{}` as root", fix_command(spec, link));
        return Err(Refusal::new(codes::CAN_ACCESS, message, help));
    }
    Ok(())
}
