//! The keys of converters and of generators.

use document::{KeySpec, KeyType};

use crate::adc::iio::MAX_BUFFER;
use crate::file::accuracy::{COVERAGE, OF_VALUE, PLUS};

pub(in crate::file) const CONVERTER: &[KeySpec] = &[
    KeySpec::required(
        "kind",
        KeyType::Choice(&["spi", "iio"]),
        "\"spi\": a converter on an SPI bus, read by the rig; \"iio\": one that the kernel has a driver for",
    ),
    KeySpec::optional("period", KeyType::Duration, "Time between two readings of an input; \"10 ms\""),
    KeySpec::optional(
        "path",
        KeyType::Text,
        "Its device: the chip select, as in \"/dev/spidev0.0\", or the place in /sys or /dev",
    ),
    KeySpec::optional(
        "part",
        KeyType::Choice(&[
            "mcp3004", "mcp3008", "mcp3204", "mcp3208", "ads8684", "ads8688", "max1110", "max1111",
            "max1112", "max1113",
        ]),
        "What it is",
    ),
    KeySpec::optional(
        "speed",
        KeyType::Quantity,
        "Clock rate of the bus; \"1 MHz\", or what the part can follow",
    ),
    KeySpec::optional(
        "clock-error",
        KeyType::Quantity,
        "How much faster than `speed` the bus may be, as in \"50 ppm\"; 0",
    ),
    KeySpec::optional("mode", KeyType::Integer(0, 3), "SPI mode; that of the part if left out"),
    KeySpec::optional("reference", KeyType::Quantity, "Its reference voltage; its own if it has one"),
    KeySpec::optional("oversample", KeyType::Integer(1, 4_096), "Sweeps whose mean is a reading; 1"),
    KeySpec::optional(
        "sequence",
        KeyType::Choice(&["auto", "manual"]),
        "Whether a part that can goes through its inputs by itself; \"auto\"",
    ),
    KeySpec::optional("name", KeyType::Text, "What the kernel's driver calls it, as in \"ads8688\""),
    KeySpec::optional("label", KeyType::Text, "What the description of the machine calls it"),
    KeySpec::optional(
        "buffered",
        KeyType::Bool,
        "Whether the kernel samples by itself, by a timer that the rig makes; true with a `trigger`",
    ),
    KeySpec::optional("trigger", KeyType::Text, "The kernel's trigger that starts each sample"),
    KeySpec::optional(
        "buffer",
        KeyType::Integer(1, MAX_BUFFER as i64),
        "Scans that the kernel keeps; 1024 if left out",
    ),
    KeySpec::optional(
        "watermark",
        KeyType::Integer(1, MAX_BUFFER as i64),
        "Scans that come at once; 1 if left out",
    ),
];

pub(in crate::file) const GENERATOR: &[KeySpec] = &[
    KeySpec::required(
        "kind",
        KeyType::Choice(&["spi", "pwm"]),
        "\"spi\": the data line of an SPI bus, counted pulses; \"pwm\": a PWM chip, waves without end",
    ),
    KeySpec::optional(
        "path",
        KeyType::Text,
        "Its device: the chip select, as in \"/dev/spidev0.0\", or the place of the chip in /sys",
    ),
    KeySpec::optional("name", KeyType::Text, "The name of a PWM chip in the kernel, as in \"pwmchip0\""),
    KeySpec::optional("label", KeyType::Text, "The name of its device, as in \"fe20c000.pwm\""),
    KeySpec::optional(
        "clock",
        KeyType::Quantity,
        "Bits a second of a stream; \"1 MHz\". The clock of a PWM chip, in whose periods it counts",
    ),
    KeySpec::optional(
        "clock-error",
        KeyType::Quantity,
        "How much faster than `clock` a stream may be, as in \"50 ppm\"; 0",
    ),
    KeySpec::optional("mode", KeyType::Integer(0, 3), "SPI mode; 0 if left out"),
    KeySpec::optional("lsb-first", KeyType::Bool, "Whether the bus sends the lowest bit of a byte first"),
    KeySpec::optional(
        "buffer",
        KeyType::Integer(2, 1 << 28),
        "Bytes that a stream has at most: `bufsiz` of the kernel's driver; 4096 if left out",
    ),
    KeySpec::optional(
        "shortest",
        KeyType::Duration,
        "The shortest level of a PWM chip; a period of its clock if left out",
    ),
    KeySpec::optional("longest", KeyType::Duration, "The longest period of a PWM chip; 2.147483647 s"),
];

pub(in crate::file) const SCALE: &[KeySpec] = &[
    KeySpec::optional(
        "divider",
        KeyType::List(&KeyType::Quantity),
        "Resistors in front of the input: to the signal, to ground",
    ),
    KeySpec::optional("shunt", KeyType::Quantity, "Resistor across which the input sees a current"),
    KeySpec::optional(
        "from",
        KeyType::List(&KeyType::Quantity),
        "Two points, in volts, or in amperes behind a shunt",
    ),
    KeySpec::optional("to", KeyType::List(&KeyType::Quantity), "What the channel shows at these points"),
];

pub(in crate::file) const ACCURACY: &[KeySpec] = &[
    OF_VALUE,
    KeySpec::optional("of-range", KeyType::Quantity, "A part of the input's range, as in \"0.05 %\"; 0"),
    PLUS,
    COVERAGE,
];

pub(in crate::file) const CALIBRATION: &[KeySpec] = &[
    KeySpec::required(
        "points",
        KeyType::List(&KeyType::List(&KeyType::Quantity)),
        "Pairs of what the channel showed and what it truly was, rising",
    ),
    KeySpec::optional("date", KeyType::Text, "The day of the calibration, as in \"2026-01-31\""),
    KeySpec::optional("expires", KeyType::Text, "The last day on which it counts"),
    KeySpec::optional("by", KeyType::Text, "Who calibrated it"),
    KeySpec::optional("certificate", KeyType::Text, "The number of the certificate"),
];
