//! The sink on the simulated SPI bus: a part that keeps every bit that it is sent.

use crate::{LOOPBACK, SpiAdc, bind_spi, write};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

const SELECT: u8 = 4;

/// The part from the side of the world. Dropping it takes faults back, and an unbound driver too.
#[derive(Debug)]
pub struct Sink;

/// A transfer that it was sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Transfer {
    /// Stamps of the monotonic clock, in ns.
    pub start: i64,
    /// The later one.
    pub end: i64,
    /// Clock rate in Hz.
    pub hz: u32,
    /// SPI mode.
    pub mode: u8,
    /// Place of its first byte among all that were sent.
    pub at: usize,
    /// Bytes.
    pub bytes: usize,
}

impl Sink {
    /// The sink with nothing in it and nothing wrong.
    ///
    /// # Panics
    /// When this is not the lab's guest.
    pub fn enter() -> Sink {
        bind_spi();
        let sink = Sink;
        sink.part().fault("none");
        sink.forget();
        sink
    }

    /// Its device file.
    pub fn path(&self) -> PathBuf {
        PathBuf::from(format!("/dev/spidev0.{SELECT}"))
    }

    /// The part, for its faults.
    pub fn part(&self) -> SpiAdc {
        LOOPBACK.at(SELECT)
    }

    /// Its next messages sleep this long inside the kernel. Nothing can interrupt them, not even a kill.
    pub fn stall(&self, lasts: Duration, times: u32) {
        self.part().stall(lasts, times);
    }

    /// Forgets what it was sent.
    pub fn forget(&self) {
        write(&file("mosi"), "0");
    }

    /// All bytes that it was sent, as on the wire.
    ///
    /// # Panics
    /// When the lab does not say.
    pub fn bytes(&self) -> Vec<u8> {
        fs::read(file("mosi")).expect("what the sink was sent")
    }

    /// Its transfers, in order.
    ///
    /// # Panics
    /// When the lab does not say.
    pub fn transfers(&self) -> Vec<Transfer> {
        let text = fs::read_to_string(file("transfers")).expect("the sink's transfers");
        // start end Hz mode bits-per-word position bytes frame
        let transfer = |line: &str| {
            let numbers: Vec<i64> = line.split(' ').map(|word| word.parse().expect("a number")).collect();
            Transfer {
                start: numbers[0],
                end: numbers[1],
                hz: numbers[2] as u32,
                mode: numbers[3] as u8,
                at: numbers[5] as usize,
                bytes: numbers[6] as usize,
            }
        };
        text.lines().map(transfer).collect()
    }
}

impl Drop for Sink {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            bind_spi();
            self.part().fault("none");
        }
    }
}

fn file(name: &str) -> PathBuf {
    Path::new("/run/lab/spi-sink").join(format!("cs{SELECT}/{name}"))
}
