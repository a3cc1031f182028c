//! The tables of keys of a board file.

use document::{KeySpec, KeyType};
use host::Processors;

use super::devices::counter;
use crate::plant;

mod devices;

pub(super) use devices::{ACCURACY, CALIBRATION, CONVERTER, GENERATOR, SCALE};

const NAME: KeyType = KeyType::Text;

/// The keys of a board file.
pub const KEYS: &[KeySpec] = &[
    KeySpec::required("format", KeyType::Integer(1, i64::MAX), "Version of the format: 1"),
    KeySpec::optional("title", KeyType::Text, "What the board is, in a line"),
    KeySpec::optional("subject", KeyType::Table(SUBJECT), "The controller under test"),
    KeySpec::optional("board", KeyType::Table(BOARD), "The board itself"),
    KeySpec::optional("chips", KeyType::Map(&KeyType::Table(CHIP)), "GPIO chips, by a name of your own"),
    KeySpec::optional(
        "channels",
        KeyType::Map(&KeyType::Table(CHANNEL)),
        "Channels beyond those of the terminals",
    ),
    KeySpec::optional(
        "converters",
        KeyType::Map(&KeyType::Table(CONVERTER)),
        "Converters of voltages, by a name of your own",
    ),
    KeySpec::optional(
        "counters",
        KeyType::Map(&KeyType::Table(counter::KEYS)),
        "Counts of counters in hardware, by a name of your own",
    ),
    KeySpec::optional(
        "generators",
        KeyType::Map(&KeyType::Table(GENERATOR)),
        "Devices that make pulses by themselves, by a name of your own",
    ),
    KeySpec::optional(
        "buses",
        KeyType::Map(&KeyType::Table(BUS)),
        "CAN buses and serial lines, by a name of your own",
    ),
    KeySpec::optional(
        "fault-relays",
        KeyType::Map(&KeyType::Table(FAULT_RELAYS)),
        "Relays that open and short the wires of real channels, by channel",
    ),
    KeySpec::optional("bind", KeyType::Map(&NAME), "Terminals of the controller and their channels"),
    KeySpec::optional("ports", KeyType::Map(&NAME), "Ports of the controller and the buses that they are on"),
    KeySpec::optional(
        "modules",
        KeyType::List(&KeyType::Either(&[NAME, KeyType::Table(MODULE)])),
        "Expansion modules that are fitted; exactly those that a plan configures if left out",
    ),
    KeySpec::optional("wires", KeyType::List(&KeyType::Table(WIRE)), "Wires between channels"),
    KeySpec::optional("plants", KeyType::List(&KeyType::Table(plant::KEYS)), "Processes between channels"),
    KeySpec::optional(
        "guard",
        KeyType::Table(GUARD),
        "The process that makes outputs safe when the rig cannot",
    ),
    KeySpec::optional(
        "control",
        KeyType::Table(CONTROL),
        "The socket by which a rig that is kept running is looked at and worked",
    ),
    KeySpec::optional("faults", KeyType::Table(FAULTS), "Trouble that the board makes by itself"),
    KeySpec::optional("realtime", KeyType::Table(REALTIME), "How punctual a run on real lines has to be"),
    KeySpec::optional(
        "invariants",
        KeyType::List(&KeyType::Any),
        "What is claimed of every case that runs on the board, as in a plan",
    ),
    KeySpec::optional("alarms", KeyType::List(&KeyType::Any), "What ends a case when it lasts, as in a plan"),
];

pub(super) const SUBJECT: &[KeySpec] = &[
    KeySpec::optional(
        "kind",
        KeyType::Text,
        "\"model\": the rig's own controller; \"external\": a real one on the board's lines",
    ),
    KeySpec::optional("profile", KeyType::Text, "Profile of the controller, as in \"m241-2019\""),
    KeySpec::optional("reference", KeyType::Text, "Its reference, as in \"TM241CEC24T\""),
    KeySpec::optional("power", NAME, "The channel of its supply: 1 is on"),
    KeySpec::optional("run-stop", NAME, "The channel of its Run/Stop switch: 1 is Run"),
    KeySpec::optional("alarm", NAME, "The channel that is 1 while it is in RUNNING"),
    KeySpec::optional(
        "load",
        KeyType::List(&KeyType::Text),
        "The command that brings a case's program into a real controller",
    ),
    KeySpec::optional("unload", KeyType::List(&KeyType::Text), "The command after a case"),
    KeySpec::optional(
        "load-within",
        KeyType::Duration,
        "The longest that each command may take; 60 s if left out",
    ),
    KeySpec::optional(
        "cycle",
        KeyType::Bool,
        "Whether a case begins with the supply off and on again; true if left out",
    ),
    KeySpec::optional("off", KeyType::Duration, "How long the supply is off then; 1 s if left out"),
    KeySpec::optional(
        "boot",
        KeyType::Duration,
        "The longest from the supply to the program; 60 s if left out",
    ),
    KeySpec::optional(
        "jitter",
        KeyType::Duration,
        "How late its outputs may come for reasons that are not its own; 0 if left out",
    ),
];

pub(super) const CHECK: &[KeySpec] = &[
    KeySpec::required("out", NAME, "The channel that the rig drives; nothing else depends on it"),
    KeySpec::required("in", NAME, "The channel that follows; the same where it has a `readback`"),
];

pub(super) const BOARD: &[KeySpec] = &[
    KeySpec::required(
        "kind",
        KeyType::Text,
        "\"simulated\": modelled lines in virtual time; \"real\": devices of this machine",
    ),
    KeySpec::optional(
        "backend",
        KeyType::Choice(&["auto", "v2", "v1"]),
        "The kernel's interface to GPIO lines; \"auto\", the best there is, if left out",
    ),
    KeySpec::optional(
        "consumer",
        KeyType::Text,
        "What `gpioinfo` shows as the holder of GPIO lines; \"rig\"",
    ),
    KeySpec::optional(
        "unresponsive-after",
        KeyType::Duration,
        "How long a call on a device may last before the device counts as lost; 100 ms",
    )
    .was("silent-after"),
    KeySpec::optional(
        "reconnect",
        KeyType::Bool,
        "Whether a device that went away is opened again when it is there again; false if left out",
    )
    .was("retake"),
    KeySpec::optional(
        "on-loss",
        KeyType::Choice(&["end", "go-on"]),
        "What a lost device does to the case: \"end\" on real lines, \"go-on\" on a simulated board if left out",
    ),
    KeySpec::optional(
        "clock-error",
        KeyType::Quantity,
        "How far the rate of the clock that stamps all changes may be off, either way, as in \"25 ppm\"; 0",
    ),
    KeySpec::optional(
        "clock-coverage",
        KeyType::Text,
        "What `clock-error` covers: \"limits\", a probability as in \"95 %\", or a factor as in \"k = 2\"; \"limits\"",
    ),
    KeySpec::optional(
        "check",
        KeyType::Table(CHECK),
        "A wire from an output to an input by which the rig checks itself before each run",
    ),
];

pub(super) const CHIP: &[KeySpec] = &[
    KeySpec::optional("label", KeyType::Text, "What its driver calls it, as in \"pinctrl-bcm2711\""),
    KeySpec::optional("name", KeyType::Text, "Its name in the kernel, as in \"gpiochip0\""),
    KeySpec::optional("path", KeyType::Text, "Its device, as in \"/dev/gpiochip0\""),
];

const LINE: KeyType = KeyType::Either(&[KeyType::Integer(0, 65_535), KeyType::Text]);

pub(super) const CHANNEL: &[KeySpec] = &[
    KeySpec::required(
        "kind",
        KeyType::Choice(&["digital", "analog", "count"]),
        "What it carries: a level, a quantity, or how far a counter has counted",
    ),
    KeySpec::optional("unit", KeyType::Text, "Unit of an analog channel"),
    KeySpec::optional("drives", KeyType::Bool, "Whether the rig can drive it; true if left out"),
    KeySpec::optional("senses", KeyType::Bool, "Whether the rig can see it; true if left out"),
    KeySpec::optional("safe", KeyType::Value, "What it is driven to when safe; left undriven if left out"),
    KeySpec::optional(
        "pull",
        KeyType::Choice(&["none", "up", "down"]),
        "What an undriven digital channel reads: \"none\" for high impedance; \"down\" if left out",
    ),
    KeySpec::optional("chip", KeyType::Text, "The GPIO chip of its line; the only one if left out"),
    KeySpec::optional("line", LINE, "Its GPIO line: the number on the chip, or the name"),
    KeySpec::optional(
        "bias",
        KeyType::Choice(&["pull-up", "pull-down", "disabled"]),
        "The pull of its GPIO line; as it is if left out",
    ),
    KeySpec::optional("active-low", KeyType::Bool, "Whether a low level of its GPIO line is 1"),
    KeySpec::optional("debounce", KeyType::Duration, "How long its GPIO line keeps a level before it counts"),
    KeySpec::optional(
        "drive",
        KeyType::Choice(&["push-pull", "open-drain", "open-source"]),
        "How its GPIO line is driven; \"push-pull\" if left out",
    ),
    KeySpec::optional("converter", NAME, "The converter that measures it; the only one if left out"),
    KeySpec::optional("input", LINE, "Its input of a converter: the number, or the name"),
    KeySpec::optional("range", KeyType::Range, "What its input is to take, as in \"-10.24 V .. 10.24 V\""),
    KeySpec::optional("scale", KeyType::Table(SCALE), "What the channel shows of the voltage at its input"),
    KeySpec::optional("calibration", KeyType::Table(CALIBRATION), "What a better instrument said of it"),
    KeySpec::optional(
        "accuracy",
        KeyType::Table(ACCURACY),
        "How far off it may be, its steps and noise aside",
    ),
    KeySpec::optional(
        "deadband",
        KeyType::Quantity,
        "By how much more than this it has to differ to count as a change; 0",
    ),
    KeySpec::optional(
        "open-below",
        KeyType::Quantity,
        "Below this, in volts or amperes at the input, its wire is open, as in \"3.6 mA\"",
    ),
    KeySpec::optional(
        "short-above",
        KeyType::Quantity,
        "Above this its sensor fails or its wire is shorted, as in \"21 mA\"",
    ),
    KeySpec::optional(
        "input-delay",
        KeyType::Range,
        "How much later than its terminal its line changes, at least and at most, as in \"2 us .. 18 us\", or at most alone; 0",
    ),
    KeySpec::optional(
        "output-delay",
        KeyType::Duration,
        "How much later than its line its terminal changes at most; 0",
    ),
    KeySpec::optional("counter", NAME, "The counter behind a count; the only one if left out"),
    KeySpec::optional(
        "of",
        KeyType::List(&NAME),
        "The lines of a simulated board that a count counts: A, or A and B",
    ),
    KeySpec::optional("function", counter::FUNCTION, "What is made of them; \"increase\" if left out"),
    KeySpec::optional("edge", counter::EDGE, "The edge of A that counts alone; \"rising\" if left out"),
    KeySpec::optional("readback", LINE, "A GPIO line of the same chip, wired to it, that reads its level"),
    KeySpec::optional("generator", NAME, "The generator that makes its pulses"),
    KeySpec::optional("output", KeyType::Integer(0, 65_535), "The number of its output; 0 if left out"),
    KeySpec::optional(
        "counts-up-to",
        KeyType::Quantity,
        "The fastest pulses of which its GPIO line reports every one, as in \"20 kHz\"",
    ),
    KeySpec::optional(
        "pulses-up-to",
        KeyType::Quantity,
        "The fastest pulses that are emitted on its GPIO line, as in \"1 kHz\"; none if left out",
    ),
];

pub(super) const BUS: &[KeySpec] = &[
    KeySpec::required(
        "kind",
        KeyType::Choice(&["can", "serial"]),
        "\"can\": a CAN bus; \"serial\": a serial line, RS-485 or RS-232",
    ),
    KeySpec::optional(
        "bitrate",
        KeyType::Integer(1, u32::MAX as i64),
        "Bit rate of a CAN bus in bit/s, as in 500_000; of a simulated one 250_000 if left out",
    ),
    KeySpec::optional(
        "data-bitrate",
        KeyType::Integer(1, u32::MAX as i64),
        "Bit rate of the data of CAN FD frames; classic frames alone if left out",
    ),
    KeySpec::optional(
        "sample-point",
        KeyType::Number,
        "Where a bit is looked at, as in 0.875; anywhere if left out",
    ),
    KeySpec::optional("data-sample-point", KeyType::Number, "The same of a bit of fast data"),
    KeySpec::optional(
        "accept",
        KeyType::List(&KeyType::Text),
        "Identifiers that the kernel hands over, as in \"701\" or \"700/780\"; all if left out",
    ),
    KeySpec::optional(
        "restart",
        KeyType::Duration,
        "How long after bus-off the controller is started again, by the kernel or else by the rig; not asked if left out",
    ),
    KeySpec::optional(
        "listen-only",
        KeyType::Bool,
        "Whether the controller never drives the CAN bus, not even to acknowledge; false if left out",
    ),
    KeySpec::optional(
        "configure",
        KeyType::Bool,
        "Whether the rig sets up the interface of a CAN bus, and back as it was at the end; false if left out",
    ),
    KeySpec::optional("joins", NAME, "A simulated bus of the same kind before this one, whose wire it is on"),
    KeySpec::optional(
        "delay",
        KeyType::Duration,
        "How long what a simulated serial line sends takes to the other ends; 0 if left out",
    ),
    KeySpec::optional(
        "message-gap",
        KeyType::Duration,
        "How long a serial line is silent between two messages; as Modbus RTU has it if left out",
    ),
    KeySpec::optional("interface", KeyType::Text, "The interface of a CAN bus, as in \"can0\""),
    KeySpec::optional("path", KeyType::Text, "The device of a serial line, as in \"/dev/serial/by-id/...\""),
    KeySpec::optional(
        "baud",
        KeyType::Integer(1, 16_000_000),
        "Speed of a serial line in Bd; 19200 if left out",
    ),
    KeySpec::optional("data-bits", KeyType::Integer(5, 8), "Data bits of a byte; 8 if left out"),
    KeySpec::optional(
        "parity",
        KeyType::Choice(&["none", "even", "odd"]),
        "Parity bit of a byte; \"even\" if left out",
    ),
    KeySpec::optional("stop-bits", KeyType::Integer(1, 2), "Stop bits of a byte; 1 if left out"),
    KeySpec::optional(
        "rs485",
        KeyType::Table(RS485),
        "How the kernel drives the direction of a transceiver; a simulated line with it is one pair of wires",
    ),
    KeySpec::optional(
        "low-latency",
        KeyType::Bool,
        "Whether the driver hands on each byte at once; as it is if left out",
    ),
    KeySpec::optional(
        "exclusive",
        KeyType::Bool,
        "Whether nobody else may use the port meanwhile; true if left out",
    ),
];

pub(super) const RS485: &[KeySpec] = &[
    KeySpec::optional("enabled", KeyType::Bool, "Whether the kernel drives the direction; true if left out"),
    KeySpec::optional(
        "rts-on-send",
        KeyType::Choice(&["high", "low"]),
        "Level of RTS while the port sends, the other one while it does not; \"high\" if left out",
    ),
    KeySpec::optional(
        "delay-before",
        KeyType::Duration,
        "Between RTS and the first bit, whole milliseconds; 0 if left out",
    ),
    KeySpec::optional(
        "delay-after",
        KeyType::Duration,
        "Between the last bit and RTS, whole milliseconds; 0 if left out",
    ),
    KeySpec::optional("hears-itself", KeyType::Bool, "Whether the port receives what it sends"),
    KeySpec::optional("terminate", KeyType::Bool, "Whether the port's own resistor ends the bus"),
];

pub(super) const FAULT_RELAYS: &[KeySpec] = &[
    KeySpec::optional("open", NAME, "The channel of the relay that opens the wire"),
    KeySpec::optional("short-to-ground", NAME, "The channel of the relay that joins it to 0 V"),
    KeySpec::optional("short-to-supply", NAME, "The channel of the relay that joins it to the supply"),
    KeySpec::optional(
        "settle",
        KeyType::Duration,
        "The longest that each relay takes to move and to stop bouncing; 10 ms if left out",
    ),
    KeySpec::optional(
        "ground-is-one",
        KeyType::Bool,
        "Whether the channel is 1 while its wire is at 0 V; false if left out",
    ),
    KeySpec::optional(
        "apart-from",
        KeyType::List(&NAME),
        "Channels on whose wires no fault may be at the same time",
    ),
];

pub(super) const MODULE: &[KeySpec] = &[KeySpec::required("type", NAME, "Its reference, as in \"TM3DI16\"")];

pub(super) const WIRE: &[KeySpec] = &[
    KeySpec::required("from", NAME, "The channel that it listens to"),
    KeySpec::required("to", NAME, "The channel that it drives"),
    KeySpec::optional("delay", KeyType::Duration, "How much later each change arrives"),
    KeySpec::optional(
        "on-delay",
        KeyType::Duration,
        "How much later it changes to 1; as `delay` if left out",
    ),
    KeySpec::optional(
        "off-delay",
        KeyType::Duration,
        "How much later it changes to 0; as `delay` if left out",
    ),
    KeySpec::optional("invert", KeyType::Bool, "Whether it drives the opposite level"),
    KeySpec::optional("bounce", KeyType::Table(BOUNCE), "Further edges after each change"),
];

pub(super) const BOUNCE: &[KeySpec] = &[
    KeySpec::required("edges", KeyType::Integer(0, 1_000_000), "Number of further edges, even"),
    KeySpec::required("over", KeyType::Duration, "Time within which they come"),
    KeySpec::optional(
        "spacing",
        KeyType::Choice(&["random", "even"]),
        "\"random\" (from the seed, if left out) or \"even\"",
    ),
];

pub(super) const GUARD: &[KeySpec] = &[
    KeySpec::optional(
        "limit",
        KeyType::Duration,
        "How long the rig may give no sign of life; 200 ms if left out",
    ),
    KeySpec::optional(
        "hold",
        KeyType::Duration,
        "How long the lines of a rig that is gone are held safe before they are let go; 2 s if left out",
    ),
    KeySpec::optional("watchdog", KeyType::Text, "A watchdog that the guard feeds, as in \"/dev/watchdog\""),
    KeySpec::optional(
        "bites-after",
        KeyType::Duration,
        "How long it goes unfed before it bites; 10 s if left out",
    ),
    KeySpec::optional(
        "bite",
        KeyType::Choice(&["guard-lost", "rig-lost"]),
        "When it is left to bite: when nobody keeps the outputs safe (if left out), or whenever the rig is lost",
    ),
];

pub(super) const CONTROL: &[KeySpec] = &[
    KeySpec::optional(
        "socket",
        KeyType::Text,
        "Its whole path, as in \"/run/scanrig/rig.sock\"; one named as the board file in the user's or the machine's folder for running programs if left out",
    ),
    KeySpec::optional(
        "group",
        KeyType::Text,
        "The group whose members may use it, as in \"scanrig\"; that of the process if left out",
    ),
    KeySpec::optional(
        "on-disconnect",
        KeyType::Choice(&["keep", "release", "stop"]),
        "What happens when a client is lost that forced something: its forces stay (if left out), they end, or they end and the application is stopped",
    ),
    KeySpec::optional("clients", KeyType::Integer(1, 4_096), "Clients at once; 64 if left out"),
];

pub(super) const FAULTS: &[KeySpec] = &[
    KeySpec::optional("late", KeyType::Table(LATE), "Changes that become known late"),
    KeySpec::optional("dropped", KeyType::Table(CHANCE), "Changes that are lost"),
    KeySpec::optional("failed-calls", KeyType::Table(CHANCE), "Calls that fail"),
    KeySpec::optional("lost", KeyType::Table(LOST), "Devices that go and come back"),
];

pub(super) const REALTIME: &[KeySpec] = &[
    KeySpec::optional(
        "priority",
        KeyType::Integer(0, 97),
        "Real-time priority of the scan loop, from 2; 80 if left out, 0 for none",
    ),
    KeySpec::optional(
        "cpus",
        KeyType::List(&KeyType::Integer(0, Processors::MOST as i64)),
        "The processors that the run's threads stay on; any if left out",
    ),
    KeySpec::optional(
        "horizon",
        KeyType::Duration,
        "The longest that the application runs ahead of the clock; \"100 us\" if left out",
    ),
    KeySpec::optional("late", KeyType::Duration, "How late the rig may be before its verdict is `error`"),
];

pub(super) const CHANCE: &[KeySpec] =
    &[KeySpec::required("chance", KeyType::Number, "How often, from 0 (never) to 1 (always)")];

pub(super) const LATE: &[KeySpec] = &[
    KeySpec::required("chance", KeyType::Number, "How often, from 0 (never) to 1 (always)"),
    KeySpec::required("by", KeyType::Duration, "At most how late"),
];

pub(super) const LOST: &[KeySpec] = &[
    KeySpec::required("chance", KeyType::Number, "At how many of its changes, from 0 (none) to 1 (all)"),
    KeySpec::required("duration", KeyType::Duration, "How long").was("for"),
];
