//! A board with a device of each kind, and what becomes of each.

use devices::{Adc, Lab, MCP3008, PATIENCE, SERIAL_A, SimChip, Unplugged, bind_spi, unbind_spi, wait_for};
use std::process::Command;
use std::time::Duration;

/// The board, with these keys below `[board]`. Periods are long: on a machine that stands still now and then a sample
/// that comes late is lost.
pub fn board(rest: &str) -> String {
    format!(
        r#"format = 1
title = "A device of each kind"
[board]
kind = "real"
unresponsive-after = "1 s"
{rest}
[chips]
main = {{ label = "rig-gpio" }}
far = {{ label = "rig-gpio-far" }}
[converters]
spi = {{ kind = "spi", path = "/dev/spidev0.0", part = "mcp3008", reference = "3.3 V", period = "500 ms" }}
iio = {{ kind = "iio", name = "rig-adc", period = "500 ms" }}
[buses]
machine = {{ kind = "can", interface = "rcan0", bitrate = 500_000 }}
spare = {{ kind = "can", interface = "vcan9", bitrate = 500_000 }}
field = {{ kind = "serial", path = "/dev/rig/serial-a" }}
[channels]
Q0 = {{ kind = "digital", chip = "main", line = 8, safe = false }}
Q1 = {{ kind = "digital", chip = "far", line = 0, safe = false }}
I1 = {{ kind = "digital", chip = "far", line = 1 }}
pressure = {{ kind = "analog", unit = "V", converter = "spi", input = 0 }}
level = {{ kind = "analog", unit = "V", converter = "iio", input = 0 }}
[guard]
limit = "10 s"
[realtime]
late = "10 s"
"#
    )
}

/// What a device meets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Loss {
    /// The chip of an output vanishes.
    Chip,
    /// Every transfer to a converter fails.
    SpiFails,
    /// The driver of the SPI bus is taken away.
    SpiUnbound,
    /// The driver of the other converter is taken away.
    IioUnbound,
    /// A reading of the other converter hangs.
    IioHangs,
    /// A CAN interface is set down.
    LinkDown,
    /// A controller goes off its bus.
    BusOff,
    /// A CAN interface is removed.
    Removed,
    /// The driver of a serial port is taken away.
    Serial,
}

impl Loss {
    pub const ALL: [Loss; 9] = [
        Loss::Chip,
        Loss::SpiFails,
        Loss::SpiUnbound,
        Loss::IioUnbound,
        Loss::IioHangs,
        Loss::LinkDown,
        Loss::BusOff,
        Loss::Removed,
        Loss::Serial,
    ];

    /// What the rig has to say of it: whom it hit, and how.
    pub fn words(self) -> [&'static str; 2] {
        match self {
            Loss::Chip => ["channel I1", "(rig-gpio-far), is gone"],
            Loss::SpiFails | Loss::SpiUnbound => ["channel pressure", "/dev/spidev0.0 (mcp3008), is gone"],
            Loss::IioUnbound => ["channel level", "(rig-adc), is gone"],
            Loss::IioHangs => ["channel level", "(rig-adc), does not answer"],
            Loss::LinkDown => ["bus machine", "rcan0, is gone"],
            Loss::BusOff => ["bus machine", "rcan0, went off the bus"],
            Loss::Removed => ["bus spare", "vcan9, is gone"],
            Loss::Serial => ["bus field", "/dev/rig/serial-a, is gone"],
        }
    }
}

/// All of the board's devices, sound. Dropping it leaves them so.
pub struct World {
    pub adc: Adc,
    pub far: Option<SimChip>,
    cut: Option<Unplugged>,
}

impl World {
    pub fn enter(_lab: &Lab) -> World {
        bind_spi();
        MCP3008.reset();
        fresh_buses();
        spare();
        World { adc: Adc::enter(), far: Some(far()), cut: None }
    }

    /// Whether the output of the chip that can go away is driven.
    pub fn far_is_on(&self) -> bool {
        self.far.as_ref().is_some_and(|chip| chip.value(0))
    }

    pub fn lose(&mut self, loss: Loss) {
        match loss {
            Loss::Chip => self.far.iter().for_each(SimChip::vanish),
            Loss::SpiFails => MCP3008.fault("io-error"),
            Loss::SpiUnbound => unbind_spi(),
            Loss::IioUnbound => self.adc.unbind(),
            // The next case begins after it.
            Loss::IioHangs => self.adc.stall(Duration::from_secs(2), 1),
            Loss::LinkDown => ip("link set rcan0 down"),
            Loss::BusOff => std::fs::write("/sys/class/net/rcan0/trouble/event", "bus-off").unwrap(),
            Loss::Removed => ip("link del vcan9"),
            Loss::Serial => self.cut = Some(SERIAL_A.unplug()),
        }
    }

    pub fn restore(&mut self, loss: Loss) {
        match loss {
            Loss::Chip => {
                drop(self.far.take());
                self.far = Some(far());
            }
            Loss::SpiFails => MCP3008.fault("none"),
            Loss::SpiUnbound => bind_spi(),
            Loss::IioUnbound => self.adc.bind(),
            Loss::IioHangs => {
                wait_for("the end of the call", PATIENCE, || self.adc.inside() == 0);
            }
            Loss::LinkDown => ip("link set rcan0 up"),
            Loss::BusOff => ip("link set rcan0 type can restart"),
            Loss::Removed => spare(),
            Loss::Serial => drop(self.cut.take()),
        }
    }
}

impl Drop for World {
    fn drop(&mut self) {
        bind_spi();
        MCP3008.fault("none");
        let _ = Command::new("ip").args(["link", "del", "vcan9"]).output();
    }
}

fn far() -> SimChip {
    SimChip::add("rig-gpio-far", &["", "", "", ""])
}

/// An interface that can be removed.
fn spare() {
    let _ = Command::new("ip").args(["link", "del", "vcan9"]).output();
    ip("link add dev vcan9 type vcan");
    ip("link set vcan9 up");
}

/// Puts the controllers with trouble into their first state.
pub fn fresh_buses() {
    for name in ["rcan0", "rcan1"] {
        ip(&format!("link set {name} down"));
        ip(&format!("link set {name} type can bitrate 500000 restart-ms 0 fd off"));
        ip(&format!("link set {name} up"));
    }
}

/// Sets up interfaces.
pub fn ip(words: &str) {
    let done = Command::new("ip").args(words.split(' ')).output().unwrap();
    assert!(done.status.success(), "ip {words}: {}", String::from_utf8_lossy(&done.stderr));
}
