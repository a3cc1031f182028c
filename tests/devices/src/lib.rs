//! The other side of the lab's devices: what a test pulls, reads, wires and stalls while the rig talks to the same
//! devices through the kernel.
//!
//! A device test is `#[ignore = "in the lab: tests/lab/devices"]`, so that `cargo test` says what it leaves out, and
//! begins with [`Lab::enter`]. `tests/lab/devices` runs each of them in a process of its own inside the virtual
//! machine. A test that resets the machine has a name that begins with `resets_`: it gets a boot of its own and is
//! run again after the reset, when [`Lab::boot`] is 2.
//!
//! Helpers panic with words, as assertions of a test do.

mod adc;
mod chip;
mod counter;
mod pwm;
mod relay;
mod serial;
mod sink;
mod spi;
mod stall;
mod wait;

pub use adc::{ADC, Adc};
pub use chip::{AUX, Chip, Line, MAIN, SimChip};
pub use counter::{Count, Counter};
pub use pwm::{Pin, PwmChip};
pub use relay::Contact;
pub use serial::{SERIAL_A, SERIAL_B, SERIAL_C, SERIAL_D, Serial, Unplugged};
pub use sink::{Sink, Transfer};
pub use spi::{ADS8688, LOOPBACK, MAX1111, MCP3008, SpiAdc, bind_spi, unbind_spi};
pub use stall::Call;
pub use wait::{PATIENCE, wait_for};

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

const WIRES: &str = "/run/lab/wires";

/// The lab, as a test finds it: no wires, no stalls, every line an input that is pulled down, and nobody holding one.
/// Dropping it cuts wires and stalls again.
#[derive(Debug)]
pub struct Lab {
    boot: u32,
}

impl Lab {
    /// Sees that this is the lab, and brings its devices into their first state.
    ///
    /// # Panics
    /// When this is not the lab's guest, or when lines stay held: their holders are named.
    pub fn enter() -> Lab {
        let boot = std::env::var("LAB_BOOT").ok().and_then(|n| n.parse().ok());
        let Some(boot) = boot.filter(|_| Path::new(WIRES).exists()) else {
            panic!("this test needs the lab's devices: run it with tests/lab/devices");
        };
        let lab = Lab { boot };
        lab.cut();
        // A process that ended a moment ago may have left a guard that still holds its lines safe.
        wait_until_free();
        let_go_of_outputs();
        for chip in [MAIN, AUX] {
            for line in chip.lines().filter(|line| !line.hogged()) {
                line.pull(false);
            }
        }
        lab
    }

    /// Which boot of the machine this is: 1, and 2 after the first reset.
    pub fn boot(&self) -> u32 {
        self.boot
    }

    /// Wires an output line to an input line: whoever sets the one has set the other when the call returns.
    pub fn wire(&self, from: Line, to: Line) {
        write(Path::new(WIRES), &format!("{from} {to}"));
    }

    /// Wires an output line to an input line through an inverter.
    pub fn wire_inverted(&self, from: Line, to: Line) {
        write(Path::new(WIRES), &format!("{from} !{to}"));
    }

    /// A relay whose coil is one line: while that is high, its contact cuts or shorts another line. The contact moves so much
    /// later than the coil.
    pub fn relay(&self, coil: Line, contact: Contact, on: Line, after: Duration) {
        write(Path::new(WIRES), &format!("{coil} {} {on} {}", contact.word(), after.as_millis()));
    }

    /// The next `times` calls of this kind on the chip sleep this long inside the kernel, before the lines move. Nothing can
    /// interrupt them, not even a kill.
    pub fn stall(&self, chip: Chip, call: Call, lasts: Duration, times: u32) {
        stall::set(chip, call, lasts, times);
    }

    /// How many calls of this kind hang in a stall just now.
    pub fn inside(&self, chip: Chip, call: Call) -> u32 {
        stall::inside(chip, call)
    }

    /// Cuts all wires and takes back all stalls.
    pub fn cut(&self) {
        write(Path::new(WIRES), "none");
        stall::none();
    }
}

impl Drop for Lab {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            self.cut();
        }
    }
}

/// The command under test.
///
/// # Panics
/// When it does not lie beside the test.
pub fn rig() -> PathBuf {
    program("rig")
}

/// A program that lies beside the test: `rig`, or one of this package's own.
///
/// # Panics
/// When it does not.
pub fn program(name: &str) -> PathBuf {
    let test = std::env::current_exe().expect("the path of the test itself");
    let program = test.with_file_name(name);
    assert!(program.exists(), "{} is missing: run the test with tests/lab/devices", program.display());
    program
}

fn wait_until_free() {
    let deadline = Instant::now() + PATIENCE;
    loop {
        let held = held_lines();
        if held.is_empty() {
            return;
        }
        assert!(Instant::now() < deadline, "somebody still holds lines:\n{}", held.join("\n"));
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Lines that somebody holds, those apart that the lab keeps to itself.
fn held_lines() -> Vec<String> {
    listed().filter(|line| !line.contains("(<unused>)")).collect()
}

/// A line that somebody drove stays an output when it is let go. Here each begins as an input.
fn let_go_of_outputs() {
    for line in listed().filter(|line| !line.contains(" input")) {
        let number: String =
            line.chars().skip_while(|c| !c.is_ascii_digit()).take_while(char::is_ascii_digit).collect();
        write(Path::new("/sys/class/gpio/export"), &number);
        write(&Path::new("/sys/class/gpio").join(format!("gpio{number}/direction")), "in");
        write(Path::new("/sys/class/gpio/unexport"), &number);
    }
}

/// The lines of simulated chips as their driver lists them, such as `gpio-512 (<unused>) input,pull-down`; those apart
/// that the lab keeps to itself.
fn listed() -> impl Iterator<Item = String> {
    let listed = fs::read_to_string("/sys/kernel/debug/gpio").expect("the kernel's list of lines");
    let lines: Vec<String> = listed.lines().map(|line| line.trim().to_owned()).collect();
    lines.into_iter().filter(|line| line.starts_with("gpio-") && !line.contains(chip::HOG))
}

/// Writes a file of the lab.
fn write(path: &Path, text: &str) {
    if let Err(error) = fs::write(path, text) {
        panic!("the lab refused `{text}` in {}: {error}", path.display());
    }
}
