//! The register of the runtime's codes: what is wrong with a plan on this bench, known only here. Codes without a name are
//! those of the command, which says them itself.

/// A signal that cannot be recorded.
pub const NOT_RECORDED: &str = "R0101";
/// A line that the controller or the board does not have.
pub const NO_TERMINAL: &str = "R0102";
/// A channel that the board does not have.
pub const NO_CHANNEL: &str = "R0103";
/// A name that is unknown on this bench.
pub const UNKNOWN_NAME: &str = "R0104";
/// A task that the controller does not have.
pub const NO_TASK: &str = "R0105";
/// Something that cannot be written.
pub const NOT_WRITABLE: &str = "R0106";
/// A value that does not fit its signal.
pub const VALUE_MISFIT: &str = "R0107";
/// An application that cannot be downloaded.
pub const NOT_DOWNLOADABLE: &str = "R0108";
/// Not a line, or not an input or output.
pub const NOT_A_LINE: &str = "R0109";
/// A line that the plan cannot drive.
pub const NOT_DRIVABLE: &str = "R0110";
/// A fault that the board cannot make.
pub const FAULT_NOT_AVAILABLE: &str = "R0111";
/// An address beyond its area.
pub const ADDRESS_OUT_OF_RANGE: &str = "R0112";
/// A configuration that the controller refuses.
pub const CONFIGURATION_REFUSED: &str = "R0113";
/// A program that the tasks do not find.
pub const PROGRAM_NOT_FOUND: &str = "R0114";
/// A deadband that does not fit its signal.
pub const DEADBAND_MISFIT: &str = "R0115";
/// A task of the program that the controller refuses.
pub const TASK_REFUSED: &str = "R0116";
/// A type that the controller's documents do not list.
pub const TYPE_NOT_DOCUMENTED: &str = "R0117";
/// A case that is not refused as its plan says.
pub const NOT_REFUSED_AS_PLANNED: &str = "R0118";
/// A configuration that the controller accepts with a warning.
pub const CONFIGURATION_WARNING: &str = "R0119";
/// A program with other tasks than the controller.
pub const OTHER_TASKS: &str = "R0121";
/// A source that no program of the plan has.
pub const NO_SOURCE: &str = "R0122";
/// Parameters of an input that exclude each other.
pub const INPUT_PARAMETERS_EXCLUSIVE: &str = "R0131";
/// An input that cannot run and stop the controller.
pub const NO_RUN_STOP_INPUT: &str = "R0132";
/// A latched input in another task than MAST.
pub const LATCH_OUTSIDE_MAST: &str = "R0133";
/// A stimulus out of specification.
pub const STIMULUS_OUT_OF_SPECIFICATION: &str = "R0134";
/// A question where nobody can be asked.
pub const NOBODY_TO_ASK: &str = "R0140";
/// A picture that is not there.
pub const NO_PICTURE: &str = "R0141";
/// A claim on values that its signal cannot have, or always has.
pub const CLAIM_WITHOUT_CHOICE: &str = "R0145";
/// A signal that nothing moves, or that the rig cannot see.
pub const SIGNAL_NOT_MOVED: &str = "R0146";
/// A fault on the line of an output whose edges are intervals.
pub const FAULT_IN_WORST_CASE: &str = "R0234";
/// A need that the bench does not meet.
pub const NEED_NOT_MET: &str = "R0147";
/// A limit that is closer than the signal is known.
pub const LIMIT_TOO_CLOSE: &str = "R0148";
/// A plan of which no case ever runs.
pub const PLAN_NEVER_RUNS: &str = "R0149";
/// Real lines in virtual time.
pub const REAL_LINES_IN_VIRTUAL_TIME: &str = "R0180";
/// Real-time priority that the kernel refuses.
pub const NO_PRIORITY: &str = "R0181";
/// Processors that the run cannot stay on.
pub const NO_PROCESSORS: &str = "R0182";
/// Memory that the kernel does not lock.
pub const MEMORY_NOT_LOCKED: &str = "R0183";
/// Processors that may sleep too deeply.
pub const PROCESSORS_SLEEP: &str = "R0184";
/// Several boards with real lines in one run.
pub const SEVERAL_REAL_BOARDS: &str = "R0185";
/// A file that cannot be read.
pub const FILE_NOT_READ: &str = "R0201";
/// A trace of another plan.
pub const TRACE_OF_ANOTHER_PLAN: &str = "R0203";
/// A suite file under another name.
pub const SUITE_MISNAMED: &str = "R0205";
/// A suite file of another user.
pub const SUITE_OF_ANOTHER_USER: &str = "R0206";
/// An instrument file that is no TOML.
pub const INSTRUMENT_NOT_READ: &str = "R0210";
/// A key of an instrument file that is unknown, missing or wrong.
pub const INSTRUMENT_KEY: &str = "R0211";
/// An error that no instrument has.
pub const INSTRUMENT_ERROR: &str = "R0212";
/// An instrument that does not suit the capture.
pub const INSTRUMENT_MISFIT: &str = "R0213";
/// A program that cannot be handed to the command that loads it.
pub const NOT_EXPORTED: &str = "R0220";
/// A real controller that is to be played.
pub const REAL_CONTROLLER: &str = "R0221";
/// A real controller whose program the rig does not load.
pub const PROGRAM_NOT_LOADED: &str = "R0224";
/// Figures that are not of this machine.
pub const FIGURES_OF_ANOTHER_MACHINE: &str = "R0252";
/// A board that is no instrument.
pub const NOT_AN_INSTRUMENT: &str = "R0255";
/// A module that the controller of a case does not take.
pub const MODULE_OF_ANOTHER_PROFILE: &str = "R0256";
/// More modules than a controller takes.
pub const TOO_MANY_MODULES: &str = "R0257";
/// A link to remote modules that is not whole.
pub const MODULE_LINK: &str = "R0258";
/// A TM2 module where none can be.
pub const MODULE_ORDER: &str = "R0259";
/// A module that cannot be optional.
pub const MODULE_NEVER_OPTIONAL: &str = "R0260";
/// Two optional modules that the controller cannot distinguish.
pub const OPTIONAL_TWINS: &str = "R0261";
/// Modules that the images have no room for.
pub const IMAGE_FULL: &str = "R0262";
/// A module without a model.
pub const MODULE_NOT_MODELLED: &str = "R0263";
/// A module that is not configured.
pub const NO_MODULE: &str = "R0264";
/// A place of the images where nothing is.
pub const PLACE_OF_NOTHING: &str = "R0265";
/// A place of the images that is a part of something else, or the status of an input that is not read.
pub const PLACE_OF_ANOTHER: &str = "R0266";
/// A terminal of a module that a board drives and a plan does not use.
pub const UNUSED_TERMINAL: &str = "R0267";
/// A frame that its bus cannot carry.
pub const FRAME_NOT_CARRIED: &str = "R0270";
/// A port that the controller of a case lacks.
pub const PORT_MISSING: &str = "R0271";
/// A bus that the plan's board does not have.
pub const NO_BUS: &str = "R0272";
/// A bench that somebody else uses.
pub const BENCH_IN_USE: &str = "R0280";
/// A machine without a place for locks.
pub const NO_PLACE_FOR_LOCKS: &str = "R0281";
/// A folder for locks that is no whole path.
pub const LOCK_FOLDER_NOT_WHOLE: &str = "R0282";
/// A folder for locks that others rule.
pub const LOCK_FOLDER_OF_OTHERS: &str = "R0283";
/// A parameter that an expert function lacks.
pub const FUNCTION_PARAMETER_MISSING: &str = "R0290";
/// An expert function that the controller cannot have.
pub const FUNCTION_NOT_AVAILABLE: &str = "R0291";
/// A parameter that an expert function cannot have.
pub const FUNCTION_PARAMETER_INVALID: &str = "R0292";
/// A bounce time that lets too few pulses pass.
pub const BOUNCE_TIME_TOO_LONG: &str = "R0293";
/// An input or output that an expert function cannot have.
pub const FUNCTION_TERMINAL_INVALID: &str = "R0294";
/// A function that cannot be given counts.
pub const FUNCTION_WITHOUT_COUNTS: &str = "R0300";
/// A level of an input that has none.
pub const INPUT_WITHOUT_LEVEL: &str = "R0301";
/// Pulses that a generator cannot emit.
pub const PULSES_NOT_EMITTED: &str = "R0305";
/// Lines of generators that cannot move together.
pub const LINES_NOT_TOGETHER: &str = "R0306";
/// An input of the model on a line that makes pulses by itself.
pub const MODEL_INPUT_ON_GENERATOR: &str = "R0307";
/// A function whose pulses a device cannot make.
pub const FUNCTION_PULSES_NOT_MADE: &str = "R0308";
/// A function that may pulse faster than its line.
pub const FUNCTION_FASTER_THAN_LINE: &str = "R0309";
/// A period that a device cannot restart.
pub const PERIOD_NOT_RESTARTED: &str = "R0310";
/// Pulses that the board does not promise.
pub const PULSES_NOT_PROMISED: &str = "R0315";
/// A promise to count that was not kept when it was measured.
pub const PROMISE_NOT_KEPT: &str = "R0316";
/// A plant that the board does not have, or has twice.
pub const NO_PLANT: &str = "R0331";
/// A parameter that a plant does not have.
pub const NO_PARAMETER: &str = "R0332";
/// A value that a parameter of a plant does not take.
pub const PARAMETER_VALUE: &str = "R0333";
/// A plant that failed while it ran.
pub const PLANT_FAILED: &str = "R0334";
/// Stepped time on real lines.
pub const REAL_LINES_NOT_STEPPED: &str = "R0600";
/// A name that is unknown to a running rig.
pub const UNKNOWN_TO_RIG: &str = "R0601";
/// Something that a client cannot write.
pub const CLIENT_CANNOT_WRITE: &str = "R0602";
/// A value that does not fit what it is written to.
pub const CLIENT_VALUE_MISFIT: &str = "R0603";
/// More than a running rig has room for.
pub const TOO_MANY: &str = "R0604";
/// Something that cannot be forced.
pub const NOT_FORCEABLE: &str = "R0605";
/// A command that the controller does not obey.
pub const COMMAND_REFUSED: &str = "R0606";
/// Time that is not stepped.
pub const NOT_STEPPED: &str = "R0607";
/// A line that the board does not drive.
pub const LINE_NOT_DRIVEN: &str = "R0608";
/// Plans on a rig that runs none.
pub const NO_PLANS: &str = "R0609";
/// A plan that a running rig cannot run.
pub const PLAN_NOT_RUN: &str = "R0610";
/// A board that a plan has for itself.
pub const PLAN_HAS_BOARD: &str = "R0611";
/// No plan that runs.
pub const NO_PLAN_RUNS: &str = "R0612";
/// Plans whose files are not read in time.
pub const PLANS_NOT_READ: &str = "R0613";

/// Every code with its title, in order.
pub const CODES: &[(&str, &str)] = &[
    (NOT_RECORDED, "A signal that cannot be recorded"),
    (NO_TERMINAL, "A line that the controller or the board does not have"),
    (NO_CHANNEL, "A channel that the board does not have"),
    (UNKNOWN_NAME, "A name that is unknown on this bench"),
    (NO_TASK, "A task that the controller does not have"),
    (NOT_WRITABLE, "Something that cannot be written"),
    (VALUE_MISFIT, "A value that does not fit its signal"),
    (NOT_DOWNLOADABLE, "An application that cannot be downloaded"),
    (NOT_A_LINE, "Not a line, or not an input or output"),
    (NOT_DRIVABLE, "A line that the plan cannot drive"),
    (FAULT_NOT_AVAILABLE, "A fault that the board cannot make"),
    (ADDRESS_OUT_OF_RANGE, "An address beyond its area"),
    (CONFIGURATION_REFUSED, "A configuration that the controller refuses"),
    (PROGRAM_NOT_FOUND, "A program that the tasks do not find"),
    (DEADBAND_MISFIT, "A deadband that does not fit its signal"),
    (TASK_REFUSED, "A task of the program that the controller refuses"),
    (TYPE_NOT_DOCUMENTED, "A type that the controller's documents do not list"),
    (NOT_REFUSED_AS_PLANNED, "A case that is not refused as its plan says"),
    (CONFIGURATION_WARNING, "A configuration that the controller accepts with a warning"),
    (OTHER_TASKS, "A program with other tasks than the controller"),
    (NO_SOURCE, "A source that no program of the plan has"),
    (INPUT_PARAMETERS_EXCLUSIVE, "Parameters of an input that exclude each other"),
    (NO_RUN_STOP_INPUT, "An input that cannot run and stop the controller"),
    (LATCH_OUTSIDE_MAST, "A latched input in another task than MAST"),
    (STIMULUS_OUT_OF_SPECIFICATION, "A stimulus out of specification"),
    (NOBODY_TO_ASK, "A question where nobody can be asked"),
    (NO_PICTURE, "A picture that is not there"),
    (CLAIM_WITHOUT_CHOICE, "A claim on values that its signal cannot have, or always has"),
    (SIGNAL_NOT_MOVED, "A signal that nothing moves, or that the rig cannot see"),
    (NEED_NOT_MET, "A need that the bench does not meet"),
    (LIMIT_TOO_CLOSE, "A limit that is closer than the signal is known"),
    (PLAN_NEVER_RUNS, "A plan of which no case ever runs"),
    ("R0150", "A folder that is not empty"),
    ("R0151", "A file that cannot be written"),
    ("R0152", "A code or module that does not exist"),
    ("R0160", "A run that cannot be read"),
    ("R0161", "A part of a suite that cannot be"),
    ("R0162", "Parts of different suites"),
    ("R0163", "Parts of a suite that are missing"),
    ("R0164", "A part of a suite that is given twice"),
    ("R0165", "A run that is not a part of a suite"),
    ("R0166", "A trace that is not there, or not the one that the record names"),
    ("R0167", "A folder or file that cannot be written"),
    ("R0168", "A file that is no history of runs"),
    ("R0169", "A history that cannot be used now"),
    ("R0170", "A capture that cannot be read"),
    ("R0171", "A channel that the capture does not have"),
    ("R0172", "A signal that the case does not have"),
    ("R0173", "An instant that the capture does not have"),
    ("R0174", "A channel that does not fit its signal"),
    ("R0175", "A case that has to be named"),
    ("R0176", "A capture without a start"),
    ("R0177", "Words that are no instant of a capture"),
    ("R0178", "A mapping that is none"),
    ("R0179", "A name that several channels of a capture have"),
    (REAL_LINES_IN_VIRTUAL_TIME, "Real lines in virtual time"),
    (NO_PRIORITY, "Real-time priority that the kernel refuses"),
    (NO_PROCESSORS, "Processors that the run cannot stay on"),
    (MEMORY_NOT_LOCKED, "Memory that the kernel does not lock"),
    (PROCESSORS_SLEEP, "Processors that may sleep too deeply"),
    (SEVERAL_REAL_BOARDS, "Several boards with real lines in one run"),
    (FILE_NOT_READ, "A file that cannot be read"),
    (TRACE_OF_ANOTHER_PLAN, "A trace of another plan"),
    ("R0204", "A trace that cannot be judged as it is given"),
    (SUITE_MISNAMED, "A suite file under another name"),
    (SUITE_OF_ANOTHER_USER, "A suite file of another user"),
    (INSTRUMENT_NOT_READ, "An instrument file that is no TOML"),
    (INSTRUMENT_KEY, "A key of an instrument file that is unknown, missing or wrong"),
    (INSTRUMENT_ERROR, "An error that no instrument has"),
    (INSTRUMENT_MISFIT, "An instrument that does not suit the capture"),
    (NOT_EXPORTED, "A program that cannot be handed to the command that loads it"),
    (REAL_CONTROLLER, "A real controller that is to be played"),
    ("R0222", "A time to run that is none"),
    ("R0223", "A case that its plan does not have"),
    (PROGRAM_NOT_LOADED, "A real controller whose program the rig does not load"),
    ("R0225", "An option under its old name"),
    ("R0226", "A filter of the log that is none"),
    ("R0227", "A selection of cases that is none"),
    ("R0228", "A selection that no case meets"),
    ("R0229", "A parameter that cannot be given"),
    ("R0230", "A folder without plans"),
    ("R0231", "A run in which no case was judged"),
    ("R0232", "Output that cannot be written"),
    ("R0233", "Cases that cannot be in one run"),
    (FAULT_IN_WORST_CASE, "A fault on a line whose edges may come at any time within their delay"),
    ("R0235", "A file that is named as a plan and is none"),
    ("R0240", "A machine without GPIO lines"),
    ("R0241", "A chip that cannot be looked at"),
    ("R0242", "A board file that is there already"),
    ("R0243", "A board without lines of this machine"),
    ("R0244", "A call on a device that failed"),
    ("R0245", "An output that would move without consent"),
    ("R0246", "A channel that is no output"),
    ("R0250", "A measurement that cannot be"),
    ("R0251", "Figures that cannot be kept"),
    (FIGURES_OF_ANOTHER_MACHINE, "Figures that are not of this machine"),
    ("R0253", "A measurement without real lines"),
    ("R0254", "A loop or output that the board does not have"),
    (NOT_AN_INSTRUMENT, "A board that is no instrument"),
    (MODULE_OF_ANOTHER_PROFILE, "A module that the controller does not take"),
    (TOO_MANY_MODULES, "More modules than the controller takes"),
    (MODULE_LINK, "A link to remote modules that is not whole"),
    (MODULE_ORDER, "A TM2 module where none can be"),
    (MODULE_NEVER_OPTIONAL, "A module that cannot be optional"),
    (OPTIONAL_TWINS, "Two optional modules that cannot be distinguished"),
    (IMAGE_FULL, "Modules that the images have no room for"),
    (MODULE_NOT_MODELLED, "A module that has no model yet"),
    (NO_MODULE, "A module that is not configured"),
    (PLACE_OF_NOTHING, "A place of the images where nothing is"),
    (PLACE_OF_ANOTHER, "A place of the images that belongs to another channel"),
    (UNUSED_TERMINAL, "A terminal of a module that a board drives and the plan does not use"),
    (FRAME_NOT_CARRIED, "A frame that its bus cannot carry"),
    (PORT_MISSING, "A port that the controller of a case lacks"),
    (NO_BUS, "A bus that the plan's board does not have"),
    (BENCH_IN_USE, "A bench that somebody else uses"),
    (NO_PLACE_FOR_LOCKS, "A machine without a place for locks"),
    (LOCK_FOLDER_NOT_WHOLE, "A folder for locks that is no whole path"),
    (LOCK_FOLDER_OF_OTHERS, "A folder for locks that others rule"),
    (FUNCTION_PARAMETER_MISSING, "A parameter that an expert function lacks"),
    (FUNCTION_NOT_AVAILABLE, "An expert function that the controller cannot have"),
    (FUNCTION_PARAMETER_INVALID, "A parameter that an expert function cannot have"),
    (BOUNCE_TIME_TOO_LONG, "A bounce time that lets too few pulses pass"),
    (FUNCTION_TERMINAL_INVALID, "An input or output that an expert function cannot have"),
    (FUNCTION_WITHOUT_COUNTS, "A function that cannot be given counts"),
    (INPUT_WITHOUT_LEVEL, "A level of an input that has none"),
    (PULSES_NOT_EMITTED, "Pulses that a generator cannot emit"),
    (LINES_NOT_TOGETHER, "Lines of generators that cannot move together"),
    (MODEL_INPUT_ON_GENERATOR, "An input of the model on a line that makes pulses by itself"),
    (FUNCTION_PULSES_NOT_MADE, "A function whose pulses a device cannot make"),
    (FUNCTION_FASTER_THAN_LINE, "A function that may pulse faster than its line"),
    (PERIOD_NOT_RESTARTED, "A period that a device cannot restart"),
    (PULSES_NOT_PROMISED, "Pulses that the board does not promise"),
    (PROMISE_NOT_KEPT, "A promise to count that was not kept when it was measured"),
    (NO_PLANT, "A plant that the board does not have"),
    (NO_PARAMETER, "A parameter that a plant does not have"),
    (PARAMETER_VALUE, "A value that a parameter of a plant does not take"),
    (PLANT_FAILED, "A plant that failed while it ran"),
    ("R0340", "A service manager that cannot be notified"),
    ("R0341", "A setting of the service manager that is no number"),
    ("R0342", "A rig that ended by a fault of its own"),
    ("R0501", "A variable that the program does not have"),
    ("R0502", "A value that its variable cannot have"),
    ("R0503", "An assignment that is none"),
    ("R0504", "A duration that cannot be"),
    ("R0505", "A number of cycles that cannot be"),
    (REAL_LINES_NOT_STEPPED, "Stepped time on real lines"),
    (UNKNOWN_TO_RIG, "A name that is unknown to a running rig"),
    (CLIENT_CANNOT_WRITE, "Something that a client cannot write"),
    (CLIENT_VALUE_MISFIT, "A value that does not fit what it is written to"),
    (TOO_MANY, "More than a running rig has room for"),
    (NOT_FORCEABLE, "Something that cannot be forced"),
    (COMMAND_REFUSED, "A command that the controller does not obey"),
    (NOT_STEPPED, "Time that is not stepped"),
    (LINE_NOT_DRIVEN, "A line that the board does not drive"),
    (NO_PLANS, "Plans on a rig that runs none"),
    (PLAN_NOT_RUN, "A plan that a running rig cannot run"),
    (PLAN_HAS_BOARD, "A board that a plan has for itself"),
    (NO_PLAN_RUNS, "No plan that runs"),
    (PLANS_NOT_READ, "Plans that are not read in time"),
    ("R0680", "A recording in a format that is not written"),
    ("R0681", "A recording that cannot be written"),
    ("R0682", "A recording that cannot be read"),
    ("R0683", "A description of frames that cannot be read"),
];
