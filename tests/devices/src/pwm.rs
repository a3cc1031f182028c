//! The lab's PWM chip, from the side of its pins.

use crate::{PATIENCE, wait_for, write};
use std::fs;
use std::path::{Path, PathBuf};

const SIDE: &str = "/run/lab/pwm";
const DRIVER: &str = "/sys/bus/platform/drivers/rig-pwm";
const DEVICE: &str = "rig-pwm";
const CLASS: &str = "/sys/class/pwm/pwmchip0";

/// What the chip puts out at a pin.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pin {
    /// Length of a period, in ns.
    pub period: u64,
    /// How long of it the pin is active, in ns.
    pub duty: u64,
    /// Whether it is active while it is low.
    pub inversed: bool,
    /// Whether it runs.
    pub enabled: bool,
    /// How often it was changed.
    pub changes: u64,
    /// Whole periods that were put out.
    pub pulses: u64,
}

/// The chip. Dropping it takes faults back, and an unbound driver too.
#[derive(Debug)]
pub struct PwmChip;

impl PwmChip {
    /// The chip with all pins free, at rest and without faults.
    ///
    /// # Panics
    /// When this is not the lab's guest.
    pub fn enter() -> PwmChip {
        let chip = PwmChip;
        chip.bind();
        for pin in 0..4 {
            chip.fault(pin, "none");
            let own = Path::new(CLASS).join(format!("pwm{pin}"));
            wait_for("nobody holds the PWM output", PATIENCE, || !own.exists());
        }
        chip
    }

    /// What is at a pin.
    ///
    /// # Panics
    /// When the lab does not say.
    pub fn pin(&self, pin: u8) -> Pin {
        let text = |name: &str| {
            let file = side(pin, name);
            fs::read_to_string(&file)
                .unwrap_or_else(|error| panic!("{}: {error}", file.display()))
                .trim()
                .to_owned()
        };
        let number = |name: &str| text(name).parse().expect("a number");
        Pin {
            period: number("period_ns"),
            duty: number("duty_ns"),
            inversed: text("polarity") == "inversed",
            enabled: number("enabled") == 1,
            changes: number("changes"),
            pulses: number("pulses"),
        }
    }

    /// Makes changes of a pin fail: `none`, `io-error`.
    pub fn fault(&self, pin: u8, fault: &str) {
        write(&side(pin, "fault"), fault);
    }

    /// Whether somebody has an output of it.
    pub fn is_held(&self, pin: u8) -> bool {
        Path::new(CLASS).join(format!("pwm{pin}")).exists()
    }

    /// Takes the chip away, whoever uses it.
    pub fn unbind(&self) {
        write(&Path::new(DRIVER).join("unbind"), DEVICE);
    }

    /// Brings it back.
    pub fn bind(&self) {
        if !Path::new(DRIVER).join(DEVICE).exists() {
            write(&Path::new(DRIVER).join("bind"), DEVICE);
        }
        wait_for("the PWM chip is there", PATIENCE, || {
            side(3, "fault").exists() && Path::new(CLASS).exists()
        });
    }
}

impl Drop for PwmChip {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            self.bind();
            (0..4).for_each(|pin| self.fault(pin, "none"));
        }
    }
}

fn side(pin: u8, name: &str) -> PathBuf {
    Path::new(SIDE).join(format!("ch{pin}/{name}"))
}
