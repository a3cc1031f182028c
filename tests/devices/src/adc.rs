//! The lab's converter of industrial I/O: four inputs of ±10.24 V in 16 bits.

use crate::{PATIENCE, wait_for, write};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

const SIDE: &str = "/run/lab/iio";
const DRIVER: &str = "/sys/bus/platform/drivers/rig-iio";
const DEVICE: &str = "rig-iio";

/// What its driver calls it.
pub const ADC: &str = "rig-adc";

/// The converter from the side of the world. Dropping it takes faults back, and an unbound driver too.
#[derive(Debug)]
pub struct Adc;

impl Adc {
    /// Every input at 0 V, nothing wrong.
    ///
    /// # Panics
    /// When this is not the lab's guest.
    pub fn enter() -> Adc {
        let adc = Adc;
        adc.bind();
        adc.sound();
        (0..4).for_each(|input| adc.set(input, 0.0));
        adc
    }

    /// The voltage at an input.
    pub fn set(&self, input: u8, volts: f64) {
        write(&side(&format!("in{input}_uv")), &format!("{:.0}", volts * 1e6));
    }

    /// Single reads fail, and triggers bring nothing.
    pub fn fails(&self) {
        write(&side("fault"), "io-error");
    }

    /// So many of the next samples hang for so long inside the kernel. Nothing can interrupt them, not even a kill.
    pub fn stall(&self, lasts: Duration, times: u32) {
        write(&side("stall"), &format!("{} {times}", lasts.as_millis()));
    }

    /// How many samples hang just now.
    ///
    /// # Panics
    /// When the lab does not say.
    pub fn inside(&self) -> u32 {
        let text = fs::read_to_string(side("stall")).expect("the lab's stall");
        text.split_whitespace().last().and_then(|word| word.parse().ok()).expect("MS LEFT INSIDE")
    }

    /// Nothing fails or hangs any more.
    pub fn sound(&self) {
        write(&side("fault"), "none");
        write(&side("stall"), "0 0");
    }

    /// Takes the device away, whoever uses it.
    pub fn unbind(&self) {
        write(&Path::new(DRIVER).join("unbind"), DEVICE);
    }

    /// Brings it back.
    pub fn bind(&self) {
        if !Path::new(DRIVER).join(DEVICE).exists() {
            write(&Path::new(DRIVER).join("bind"), DEVICE);
        }
        wait_for("the converter is there", PATIENCE, || side("fault").exists());
    }
}

impl Drop for Adc {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            self.bind();
            self.sound();
        }
    }
}

fn side(file: &str) -> PathBuf {
    Path::new(SIDE).join(file)
}
