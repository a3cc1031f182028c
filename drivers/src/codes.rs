//! The register of codes of board files.

use document::Codes;

document::codes! {
    /// Every code that board files are refused with, with its title, in order.
    SYNTAX = "B0001", "The board file is no TOML";
    NEWER_TOML = "B0002", "The board file uses what TOML 1.0 does not have";
    TOO_LARGE = "B0003", "The board file is too large or too deep";
    UNKNOWN_KEY = "B0004", "A key is not known";
    MISSING_KEY = "B0005", "A key is missing";
    WRONG_TYPE = "B0006", "A value has the wrong type";
    UNREADABLE = "B0007", "A text does not read as what is expected";
    FORMAT = "B0101", "The format of the board file is not supported";
    SUBJECT_KIND = "B0102", "The kind of subject is not available";
    BOARD_KIND = "B0103", "The kind of board is not available";
    PROFILE = "B0104", "The profile is not known";
    REFERENCE = "B0105", "The profile does not have the reference";
    SUBJECT_KEY = "B0106", "A key does not suit the kind of subject";
    SUBJECT_LINE = "B0107", "A channel does not suit a line of the subject";
    SUBJECT_COMMAND = "B0108", "A command of the subject is none";
    BUS_KEY = "B0110", "A key of a bus is missing, or does not suit its kind";
    BUS_RATE = "B0111", "A bit rate that a bus cannot have";
    BUS_JOIN = "B0112", "A bus that cannot be joined";
    FIND_CONVERTER = "B0120", "It is not clear which converter is meant";
    INPUT = "B0121", "A channel has no input, or one that its converter lacks";
    RANGE = "B0122", "A range that the converter does not have";
    SCALE = "B0123", "A scale that leads nowhere";
    CALIBRATION = "B0124", "A calibration that is none";
    EXPIRED = "B0125", "A calibration has expired";
    CONVERTER_VALUE = "B0126", "A setting that the converter does not take";
    CONVERTER_MISSING = "B0127", "The machine has no such converter";
    CONVERTER_BUSY = "B0128", "A converter is held by somebody else";
    CONVERTER_REFUSED = "B0129", "A converter does not take its settings";
    IIO_MISSING = "B0130", "The machine has no such industrial I/O device";
    IIO_ALIKE = "B0131", "Several industrial I/O devices answer to this";
    IIO_INPUT = "B0132", "The device has no such input";
    IIO_BUSY = "B0133", "An industrial I/O device is held by somebody else";
    IIO_TRIGGER = "B0134", "A trigger is missing or cannot be made";
    IIO_SETTING = "B0135", "An industrial I/O device does not take a setting";
    IIO_BUFFER = "B0136", "An industrial I/O device cannot sample like this by itself";
    IIO_DENIED = "B0137", "The rig may not use an industrial I/O device";
    IIO_KEYS = "B0138", "Keys of an industrial I/O converter do not go together";
    SERIAL_PATH = "B0140", "It is not clear which serial port is meant";
    SERIAL_VALUE = "B0141", "A setting of a serial line is out of range";
    SERIAL_TWICE = "B0142", "A serial port is used twice";
    SERIAL_MISSING = "B0144", "The machine has no such serial port";
    SERIAL_BUSY = "B0145", "A serial port is held by somebody else";
    SERIAL_ACCESS = "B0146", "The rig may not open the serial port";
    SERIAL_NONE = "B0147", "The device is no serial port";
    SERIAL_CANNOT = "B0148", "The serial port cannot do this";
    SERIAL_REFUSED = "B0149", "The kernel refuses the serial port";
    CHECK = "B0150", "A loop that cannot check the rig";
    CAN_VALUE = "B0152", "A setting of a CAN bus is out of range";
    CAN_TWICE = "B0153", "An interface carries two CAN buses";
    CAN_MISSING = "B0154", "The machine has no such CAN interface";
    CAN_DOWN = "B0155", "The CAN interface is down";
    CAN_SETTINGS = "B0156", "The CAN interface is set up otherwise";
    CAN_REFUSED = "B0157", "The kernel refuses the CAN interface";
    CAN_ACCESS = "B0158", "The rig may not set up CAN interfaces";
    CAN_CANNOT = "B0159", "The CAN interface cannot be set up like this";
    OTHER_BOARD = "B0160", "A key belongs to another kind of board";
    FIND_CHIP = "B0161", "It is not clear which chip is meant";
    CHIP = "B0162", "A chip is not known";
    NO_LINE_SAID = "B0163", "A channel has no line";
    LINE_TWICE = "B0164", "A line is used twice";
    LINE_PROPERTY = "B0165", "A property does not suit the direction of a line";
    TOO_MANY_LINES = "B0166", "A chip has more lines than one claim takes";
    LINE_VALUE = "B0167", "A value is outside of what the kernel takes";
    CHIP_MISSING = "B0170", "The machine has no such chip";
    CHIPS_ALIKE = "B0171", "Several chips of the machine answer to this";
    LINE_MISSING = "B0172", "The chip has no such line";
    LINES_ALIKE = "B0173", "Several lines of the chip have this name";
    BUSY = "B0174", "A line is held by somebody else";
    NO_ACCESS = "B0175", "The rig may not open the chip";
    BACKEND = "B0176", "The kernel's interface cannot do this";
    REFUSED = "B0177", "The kernel refuses the lines";
    HOST = "B0178", "The machine cannot give what the board needs";
    GUARD_TIME = "B0180", "A time that the guard cannot keep";
    GUARD_WATCHDOG = "B0181", "A watchdog that is none, or missing";
    FAULT_RELAY = "B0182", "A channel does not suit a fault relay";
    FAULTY_CHANNEL = "B0183", "A channel cannot have fault relays";
    RELAY_TIME = "B0184", "A time in which no relay settles";
    REALTIME = "B0190", "A setting of real time is out of range";
    CLOCK = "B0191", "A clock that is off by as much is none";
    DELAY = "B0192", "A delay that its channel does not have";
    CHANNEL_NAME = "B0201", "A channel's name breaks the rules";
    CHANNEL_PROPERTY = "B0202", "A property does not suit the kind of channel";
    SAFE_VALUE = "B0203", "A safe value does not suit its channel";
    TOO_MANY = "B0204", "The board has too many parts";
    FIND_COUNTER = "B0205", "It is not clear which counter is meant";
    COUNTER_VALUE = "B0206", "A setting that does not suit a counter";
    COUNT_TWICE = "B0207", "A count is used twice";
    COUNTER_MISSING = "B0208", "The machine has no such counter";
    COUNTERS_ALIKE = "B0209", "Several counters of the machine answer to this";
    COUNT_MISSING = "B0210", "The counter has no such count";
    COUNTER_SETTING = "B0211", "A counter does not take a setting";
    COUNTER_DENIED = "B0212", "The rig may not use a counter";
    COUNTER_REFUSED = "B0213", "The kernel refuses a counter";
    COUNTER_WRAPS = "B0214", "A count wraps too soon to be followed";
    TALLY = "B0215", "A count of a simulated board cannot be made of this";
    FIND_GENERATOR = "B0220", "It is not clear which generator is meant";
    GENERATOR_VALUE = "B0221", "A setting that a generator does not take";
    GENERATOR_TWICE = "B0222", "A device is two generators";
    OUTPUT = "B0223", "A channel has no output, or one that its generator lacks";
    GENERATOR_LEVEL = "B0224", "A generator does not do what the channel is wired to do";
    GENERATOR_MISSING = "B0230", "The machine has no such generator";
    GENERATORS_ALIKE = "B0231", "Several generators of the machine answer to this";
    GENERATOR_BUSY = "B0232", "A generator is held by somebody else";
    GENERATOR_ACCESS = "B0233", "The rig may not use a generator";
    GENERATOR_REFUSED = "B0234", "A generator does not take its settings";
    STREAM_BUFFER = "B0235", "The kernel takes less at once than a stream needs";
    STREAM_CLOCK = "B0236", "A bus does not keep the clock of its stream";
    FREQUENCY = "B0240", "A frequency that a line cannot have";
    ADDRESS = "B0301", "An address cannot be read";
    TERMINAL = "B0302", "The controller has no such terminal";
    BOUND_TWICE = "B0303", "A terminal is bound twice";
    UNKNOWN_CHANNEL = "B0304", "A channel is not known";
    BINDING = "B0305", "A channel does not suit its terminal";
    OUTPUTS_MEET = "B0306", "Two outputs are bound to one channel";
    PORT = "B0307", "The controller has no such port";
    PORT_BUS = "B0308", "A port is bound to a bus that is not known";
    PORT_KIND = "B0309", "A bus does not suit its port";
    PORT_TWICE = "B0310", "A port or a bus is bound twice";
    PORT_NOT_BOUND = "B0311", "A port of this kind cannot be bound";
    MODULE_UNIT = "B0312", "A channel does not have the unit of its terminal";
    FITTED = "B0314", "A module that cannot be fitted";
    KINDS_DIFFER = "B0401", "A wire joins channels of different kinds";
    NOT_FOR_ANALOG = "B0402", "An analog wire has one delay, and can neither invert nor bounce";
    BOUNCE = "B0403", "A bounce is impossible";
    RING = "B0404", "Wires or plants without delay form a ring";
    TWO_SOURCES = "B0405", "An analog channel is driven from two sides";
    PLANT_CHANNEL = "B0501", "A channel does not suit its plant";
    PLANT_TARGET = "B0502", "A lag's target is missing or does not suit its input";
    UNIT = "B0503", "A number has another unit than its channel";
    TIME = "B0504", "A time must be above 0";
    HYSTERESIS = "B0505", "A switch goes off where it goes on, or above";
    PLANT_KEY = "B0506", "A key belongs to another kind of plant";
    PLANT_RANGE = "B0507", "A number of a plant is out of its range";
    PLANT_UNIT = "B0508", "A quantity of a plant is of another kind";
    PLANT_FLOW = "B0509", "A flow of a tank is not clear";
    PLANT_ENCODER = "B0510", "The encoder of a motor cannot be like this";
    PLANT_SAMPLE = "B0511", "A sample time and an output do not go together";
    PLANT_PROGRAM = "B0512", "A program that no plant can run";
    PLANT_VARIABLE = "B0513", "A variable that the program of a plant does not have, or not so";
    PLANT_VARIABLE_TYPE = "B0514", "A variable of a plant's program does not suit its channel or value";
    CHANCE = "B0601", "A chance is not between 0 and 1";
}

pub(super) const DOCUMENT: Codes = Codes {
    syntax: SYNTAX,
    newer_toml: NEWER_TOML,
    too_large: TOO_LARGE,
    unknown_key: UNKNOWN_KEY,
    missing_key: MISSING_KEY,
    wrong_type: WRONG_TYPE,
    unreadable: UNREADABLE,
};
