//! CAN buses of the kernel's interfaces (SocketCAN): frames both ways with the kernel's stamps, what controllers
//! report, and whether an interface is set up as the board file says.

mod adapter;
mod arrivals;
mod board;
mod configure;
mod device;
mod driver;
mod find;
mod link;
mod netlink;
mod node;
mod order;
mod port;
mod report;
mod settings;
mod shared;
mod spec;
#[cfg(test)]
mod tests;
mod wire;

pub use board::CanBoard;
pub use find::{check, find, interfaces, words};
pub use link::{BitTiming, Link, Modes, News, read as read_news};
pub use netlink::ask;
pub use order::{Setup, question};
pub use report::Reported;
pub use settings::{differences, fix_command};
pub use spec::{CanBusSpec, CanSpec, Filter};
pub use wire::{Datagram, decode, encode};

use crate::Bus;

/// Describes the CAN buses of a board, before anything is known of their interfaces.
pub(crate) fn describe(spec: &CanSpec, buses: &mut Vec<Bus>) {
    for bus in &spec.buses {
        let at = usize::from(bus.bus.0);
        if buses.len() <= at {
            buses.resize(at + 1, Bus::none());
        }
        buses[at] = bus.described();
    }
}
