//! Converters on the simulated SPI bus, from the side of what they measure.

use crate::{PATIENCE, wait_for, write};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// The driver of the bus.
const DRIVER: &str = "/sys/bus/platform/drivers/rig-spi-adc";
/// The bus, as its driver knows it.
const DEVICE: &str = "rig-spi-adc";

/// A converter of the lab.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SpiAdc {
    select: u8,
    inputs: u8,
    reference_uv: u32,
}

/// MCP3008 against 3.3 V.
pub const MCP3008: SpiAdc = SpiAdc { select: 0, inputs: 8, reference_uv: 3_300_000 };
/// ADS8688 against 4.096 V.
pub const ADS8688: SpiAdc = SpiAdc { select: 1, inputs: 8, reference_uv: 4_096_000 };
/// MAX1111 against 2.048 V.
pub const MAX1111: SpiAdc = SpiAdc { select: 2, inputs: 4, reference_uv: 2_048_000 };
/// No converter: what is sent comes back.
pub const LOOPBACK: SpiAdc = SpiAdc { select: 3, inputs: 0, reference_uv: 0 };

impl SpiAdc {
    /// The same with all its inputs at 0 V and without faults.
    pub fn reset(self) -> SpiAdc {
        self.fault("none");
        (0..self.inputs).for_each(|input| self.volts(input, 0.0));
        if self.inputs > 0 {
            write(&self.file("vref_uv"), &self.reference_uv.to_string());
        }
        self
    }

    /// A part without inputs at another chip select.
    pub(crate) fn at(self, select: u8) -> SpiAdc {
        SpiAdc { select, inputs: 0, ..self }
    }

    /// Its device file.
    pub fn path(self) -> PathBuf {
        PathBuf::from(format!("/dev/spidev0.{}", self.select))
    }

    /// Puts an input at a voltage.
    pub fn volts(self, input: u8, volts: f64) {
        write(&self.file(&format!("in{input}_uv")), &format!("{:.0}", volts * 1e6));
    }

    /// Makes it fail: `none`, `stuck-low`, `stuck-high`, `bit-slip`, `io-error`.
    pub fn fault(self, fault: &str) {
        write(&self.file("fault"), fault);
    }

    /// Its next messages sleep this long inside the kernel. Nothing can interrupt them, not even a kill.
    pub fn stall(self, lasts: Duration, times: u32) {
        self.fault(&format!("stall {} {times}", lasts.as_millis()));
    }

    /// How many of its messages hang in a stall just now.
    ///
    /// # Panics
    /// When the lab does not say.
    pub fn inside(self) -> u32 {
        // stall MS LEFT INSIDE
        let shown = self.shown("fault");
        shown.strip_prefix("stall ").and_then(|rest| rest.split(' ').next_back()?.parse().ok()).unwrap_or(0)
    }

    /// Times that it was selected.
    ///
    /// # Panics
    /// When the lab does not say.
    pub fn frames(self) -> u64 {
        self.shown("frames").parse().expect("a number of frames")
    }

    fn shown(self, name: &str) -> String {
        let file = self.file(name);
        fs::read_to_string(&file)
            .unwrap_or_else(|error| panic!("{}: {error}", file.display()))
            .trim()
            .to_owned()
    }

    fn file(self, name: &str) -> PathBuf {
        PathBuf::from(format!("/run/lab/spi/cs{}/{name}", self.select))
    }
}

/// Takes the whole bus away from its driver, whoever uses its converters.
pub fn unbind_spi() {
    write(&Path::new(DRIVER).join("unbind"), DEVICE);
}

/// Gives it back, if it was taken away, and waits until its converters are there.
pub fn bind_spi() {
    if !Path::new(DRIVER).join(DEVICE).exists() {
        write(&Path::new(DRIVER).join("bind"), DEVICE);
    }
    wait_for("the SPI bus is back", PATIENCE, || {
        MCP3008.path().exists() && MCP3008.file("fault").exists() && LOOPBACK.path().exists()
    });
}
