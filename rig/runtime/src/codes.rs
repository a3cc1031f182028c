//! The register of the runtime's codes: what is wrong with a plan on this bench, known only here.

/// Every code with its title, in order.
pub const CODES: &[(&str, &str)] = &[
    ("R0101", "A signal that cannot be recorded"),
    ("R0102", "A line that the controller or the board does not have"),
    ("R0103", "A channel that the board does not have"),
    ("R0104", "A name that means nothing on this bench"),
    ("R0105", "A task that the controller does not have"),
    ("R0106", "Something that cannot be written"),
    ("R0107", "A value that does not fit its signal"),
    ("R0108", "An application that cannot be downloaded"),
    ("R0109", "Not a line, or not an input or output"),
    ("R0110", "A line that the plan cannot drive"),
    ("R0111", "A fault that the board cannot make"),
    ("R0112", "An address beyond its area"),
    ("R0113", "A configuration that the controller refuses"),
    ("R0114", "A program that the tasks do not find"),
    ("R0115", "A deadband that does not fit its signal"),
    ("R0116", "A task of the program that the controller refuses"),
    ("R0117", "A type that the controller's documents do not list"),
    ("R0201", "A file that cannot be read"),
    ("R0203", "A trace of another plan"),
    ("R0501", "A variable that the program does not have"),
    ("R0502", "A value that its variable cannot have"),
    ("R0503", "An assignment that is none"),
    ("R0504", "A duration that cannot be"),
    ("R0505", "A number of cycles that cannot be"),
];
