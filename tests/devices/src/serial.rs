//! Serial ports: their trouble, which no emulated line has by itself.

use crate::write;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// A port of the lab.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Serial(char);

/// Joined to [`SERIAL_B`].
pub const SERIAL_A: Serial = Serial('a');
/// Joined to [`SERIAL_A`].
pub const SERIAL_B: Serial = Serial('b');
/// Joined to [`SERIAL_D`]; on one card with [`SERIAL_A`].
pub const SERIAL_C: Serial = Serial('c');
/// Joined to [`SERIAL_C`]; on one card with [`SERIAL_B`].
pub const SERIAL_D: Serial = Serial('d');

const DRIVER: &str = "/sys/bus/pci/drivers/serial";

impl Serial {
    /// Its device: a link that stays.
    pub fn path(self) -> PathBuf {
        PathBuf::from(format!("/dev/rig/serial-{}", self.0))
    }

    /// The name of its device, as in `ttyS4`.
    ///
    /// # Panics
    /// When the lab has none.
    pub fn name(self) -> String {
        let device = fs::read_link(self.path()).expect("a serial port of the lab");
        device.file_name().expect("the name of a device").to_string_lossy().into_owned()
    }

    /// The port receives this, whatever its line does: `break`, `parity 41`, `frame 41`, `overrun`, `byte 41`.
    pub fn harm(self, what: &str) {
        write(&self.trouble("harm"), what);
    }

    /// Every break, and every question whether all is sent, sleeps this long inside the kernel; zero for none.
    pub fn stall(self, lasts: Duration) {
        write(&self.trouble("stall_ms"), &lasts.as_millis().to_string());
    }

    /// How many calls sleep in a stall just now.
    ///
    /// # Panics
    /// When the lab does not say.
    pub fn inside(self) -> u32 {
        let count = fs::read_to_string(self.trouble("inside")).expect("the number of stalled calls");
        count.trim().parse().expect("a number")
    }

    /// What is sent is never sent to its end, or is again.
    pub fn stuck(self, stuck: bool) {
        write(&self.trouble("stuck"), if stuck { "1" } else { "0" });
    }

    /// Takes the driver from the card of this port, which has another one, until what comes back is dropped.
    ///
    /// # Panics
    /// When the port is no part of a card.
    pub fn unplug(self) -> Unplugged {
        let device = fs::canonicalize(format!("/sys/class/tty/{}/device", self.name())).expect("a device");
        let driver = fs::canonicalize(DRIVER).expect("the driver of the cards");
        let bound = |folder: &&Path| fs::canonicalize(folder.join("driver")).is_ok_and(|its| its == driver);
        let card = device.ancestors().find(bound).expect("a card with a driver");
        let card = card.file_name().expect("the address of a card").to_string_lossy().into_owned();
        write(&Path::new(DRIVER).join("unbind"), &card);
        Unplugged { card }
    }

    fn trouble(self, name: &str) -> PathBuf {
        PathBuf::from(format!("/sys/kernel/debug/rig-serial/{}/{name}", self.name()))
    }
}

/// A card without its driver. Dropping this gives it back.
#[derive(Debug)]
pub struct Unplugged {
    card: String,
}

impl Drop for Unplugged {
    fn drop(&mut self) {
        write(&Path::new(DRIVER).join("bind"), &self.card);
        // Ports that are new lack what a PC's ports lack.
        for port in [SERIAL_A, SERIAL_B, SERIAL_C, SERIAL_D] {
            write(&port.trouble("offer"), "1");
        }
    }
}
