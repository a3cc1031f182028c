//! The register of the plan reader's codes. Every code that it reports is in here.

use document::Codes;

document::codes! {
    /// Every code of the plan reader with its title, in order.
    SYNTAX = "P0001", "The file is not TOML";
    NEWER_TOML = "P0002", "TOML 1.1 accepts this, TOML 1.0 does not";
    TOO_LARGE = "P0003", "The file is larger than a plan can be";
    UNKNOWN_KEY = "P0101", "An unknown key";
    MISSING_KEY = "P0102", "A key is missing";
    WRONG_TYPE = "P0103", "A value of the wrong type";
    UNREADABLE = "P0104", "A text that does not read as what the key takes";
    FORMAT = "P0105", "An unsupported format of plan";
    REQUIREMENT = "P0106", "Not the ID of a requirement";
    PROFILE = "P0107", "An unknown profile or reference";
    NEED = "P0108", "A need that no rig can have";
    PROGRAM = "P0109", "The program is missing or given twice";
    SETTING = "P0110", "A setting that no controller has";
    STEP_VERB = "P0201", "A step with no verb, an unknown verb or two verbs";
    STEP_ID = "P0202", "A step's id is missing, malformed or used twice";
    STEP_TIME = "P0203", "A step has no time, or two";
    STEP_BEFORE = "P0204", "A step cannot come before what it depends on";
    STEP_AFTER_END = "P0205", "A step comes after the end of its case";
    STEP_CYCLE = "P0206", "Steps depend on each other";
    STIMULUS = "P0207", "A stimulus that cannot be";
    TOO_MANY_STEPS = "P0208", "More steps than a plan can have";
    ANCHOR = "P0301", "A text that does not read as an instant";
    UNKNOWN_ANCHOR = "P0302", "An instant of an unknown step";
    VALUE = "P0303", "A text that does not read as a value";
    UNIT = "P0304", "A quantity of the wrong unit";
    SIGNAL = "P0305", "Not the name of a signal";
    ADDRESS = "P0306", "Not an address";
    UNBOUND = "P0307", "A name that is nearly that of a bound signal";
    OPERAND = "P0308", "A text that does not read as a signal's value at an instant";
    RECORDING = "P0309", "A signal that cannot be recorded like this";
    REFERENCE = "P0401", "A reference to nothing";
    REFERENCE_FORM = "P0402", "A reference that cannot stand here";
    ROWS = "P0403", "Rows that are malformed";
    UNKNOWN_ROW = "P0404", "An unknown row";
    SWEEP = "P0405", "A sweep that is malformed";
    NAME_TWICE = "P0406", "A name defined twice";
    TOO_MANY_CASES = "P0407", "More cases than a plan can have";
    PARAMETER = "P0408", "A parameter that the plan does not have";
    NOTHING_CLAIMED = "P0501", "A plan that claims and measures nothing";
    EXPECT_VERB = "P0502", "An expectation with no verb, an unknown verb or two verbs";
    CLAIM = "P0503", "A claim that can never be met or never fail";
    MEANING = "P0504", "A value that is not valid for its signal";
    NOT_IN_TRACE = "P0505", "A signal that the trace does not have";
    REFUSED_AND_CLAIMS = "P0506", "A case that is refused and claims something";
    TOO_MANY_CLAIMS = "P0507", "More claims than a case can have";
    PHASE = "P0600", "A step that depends on another part of the case";
    NO_TEARDOWN = "P0601", "An instant of a teardown that the plan does not have";
    GROUP = "P0602", "An unknown group";
    ARGUMENT = "P0603", "An argument that is missing, unknown or malformed";
    RECURSION = "P0604", "Groups that run each other without end";
    IN_GROUP = "P0605", "What cannot stand in a group";
    INCLUDE = "P0606", "A file that cannot be included";
    INCLUDED_TWICE = "P0607", "A name that two files define";
    REPEAT = "P0608", "A step that cannot come again like this";
    OCCURRENCE = "P0609", "A time that a step does not come";
    QUESTION = "P0610", "A question that cannot be asked";
    GROUP_NOT_RUN = "P0611", "A group that no step runs";
    GUARD_STEP = "P0620", "An invariant or alarm that depends on a step";
    ALARM = "P0621", "An alarm that cannot be";
    BEYOND_CASE = "P0622", "A claim that looks beyond the end of its case";
    UNUSED = "P0623", "A name that is bound and never used";
    CUT_OFF = "P0624", "A step that lasts longer than its case";
    NEVER_ARMED = "P0625", "A watchdog that is never armed";
    GUARD_OF_NOTHING = "P0626", "A guard band of a plan that no measurement takes";
    WAVE = "P0640", "A wave that cannot be";
    SAMPLES = "P0641", "A wave with too many or too few values";
    ENCODER = "P0642", "A motion of an encoder that cannot be";
    TABLE_FILE = "P0643", "A table that cannot be read";
    TABLE = "P0644", "A table of values that is malformed";
    COLUMN = "P0645", "A column that cannot drive a signal";
    MEASURE = "P0660", "A key that does not apply to this kind of measurement";
    TOO_MANY_TURNS = "P0661", "More turns than a plan can have";
    GUARD_BAND = "P0668", "A guard band where there is no figure";
    FRAME = "P0670", "A frame that cannot be described like this";
    FRAME_DATA = "P0671", "A text that does not read as data of a frame";
    FRAME_ID = "P0672", "An identifier that no frame has";
    DBC_FILE = "P0673", "A DBC file that cannot be read";
    DBC_NAME = "P0674", "A message or signal that a DBC file does not have";
    SEND = "P0675", "A frame that cannot be sent";
    FRAME_VALUE = "P0676", "A value that a frame cannot carry";
    UNKNOWN_FRAME = "P0677", "A frame that the plan does not name";
    MODULE = "P0678", "A module that the catalogue does not have";
    FUNCTION_KEY = "P0690", "A key that does not apply to this kind of expert function";
    CHANNEL_MODE = "P0691", "A mode that an analogue channel does not have";
    CHANNEL_PARAMETER = "P0692", "A parameter that an analogue channel cannot have";
    CHANNEL_KEY = "P0693", "A key that does not apply to this kind of module or analogue channel";
    TOO_MANY_CHANNELS = "P0694", "More analogue channels than the module has";
    GRID = "P0710", "A grid that jitter cannot be measured from";
    TRAIN = "P0711", "A pulse train whose direction cannot be described like this";
    SHAPE = "P0712", "A shape that no frequency has";
}

/// The codes of what every TOML file can have wrong.
pub const TOML: Codes = Codes {
    syntax: SYNTAX,
    newer_toml: NEWER_TOML,
    too_large: TOO_LARGE,
    unknown_key: UNKNOWN_KEY,
    missing_key: MISSING_KEY,
    wrong_type: WRONG_TYPE,
    unreadable: UNREADABLE,
};

#[cfg(test)]
mod tests {
    use super::CODES;

    #[test]
    fn codes_are_in_order_and_single() {
        assert!(CODES.windows(2).all(|pair| pair[0].0 < pair[1].0));
    }
}
