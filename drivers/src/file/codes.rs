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
    CHECK = "B0150", "A loop that cannot check the rig";
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
    REALTIME = "B0190", "A setting of real time is out of range";
    CHANNEL_NAME = "B0201", "A channel's name breaks the rules";
    CHANNEL_PROPERTY = "B0202", "A property does not suit the kind of channel";
    SAFE_VALUE = "B0203", "A safe value does not suit its channel";
    TOO_MANY = "B0204", "The board has too many parts";
    ADDRESS = "B0301", "An address cannot be read";
    TERMINAL = "B0302", "The controller has no such terminal";
    BOUND_TWICE = "B0303", "A terminal is bound twice";
    UNKNOWN_CHANNEL = "B0304", "A channel is not known";
    BINDING = "B0305", "A channel does not suit its terminal";
    OUTPUTS_MEET = "B0306", "Two outputs are bound to one channel";
    KINDS_DIFFER = "B0401", "A wire joins channels of different kinds";
    NOT_FOR_ANALOG = "B0402", "An analog wire can neither invert nor bounce";
    BOUNCE = "B0403", "A bounce is impossible";
    RING = "B0404", "Wires without delay form a ring";
    TWO_SOURCES = "B0405", "An analog channel is driven from two sides";
    PLANT_CHANNEL = "B0501", "A channel does not suit its plant";
    PLANT_TARGET = "B0502", "A lag's target is missing or does not suit its input";
    UNIT = "B0503", "A number has another unit than its channel";
    TIME = "B0504", "A time must be above 0";
    HYSTERESIS = "B0505", "A switch goes off where it goes on, or above";
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
