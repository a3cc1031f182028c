//! Non-volatile storage as the controller sees it.

/// The boot application (controller:NV-03).
pub const APPLICATION_FILE: &str = "/usr/App/Application.app";

/// The two alternating images of the remanent variables (controller:NV-03, controller:REM-07).
pub const RETAIN_FILES: [&str; 2] = ["/data/retain.0", "/data/retain.1"];

/// Names and types of the remanent variables of the application that was in memory last: what of an image another
/// application can take (controller:REM-02 note 2).
pub const RETAIN_MAP: &str = "/data/retain.map";

/// The state that the controller is in, kept for the boot decision (controller:RB-02). A single word of
/// battery-backed memory: written at once, never torn.
pub const STATE_FILE: &str = "/data/state";

/// When the controller last stopped and last went off (controller:RB-06), battery-backed too.
pub const DATES_FILE: &str = "/data/dates";

/// Everything that belongs to the user (controller:NV-03).
pub(crate) const USER_FOLDER: &str = "/usr/";
/// The boot application with what belongs to it, and the source.
pub(crate) const APPLICATION_FOLDER: &str = "/usr/App/";
/// Configuration.
pub(crate) const CONFIGURATION_FOLDER: &str = "/usr/Cfg/";
/// Records of the system.
pub(crate) const SYSTEM_LOG_FOLDER: &str = "/usr/Syslog/";
/// Pages of the web visualisation (rig definition: the documents name no folder).
pub(crate) const VISUALISATION_FOLDER: &str = "/usr/Visu/";

/// Post configuration (controller:PC-01).
pub const POST_CONFIGURATION_FILE: &str = "/usr/Cfg/Machine.cfg";

/// Users, groups and their rights (rig definition: the documents name no file).
pub const RIGHTS_FILE: &str = "/usr/Cfg/Rights.cfg";

/// Certificates of the Web and FTP servers (rig definition: the documents name no folder).
pub const CERTIFICATES_FOLDER: &str = "/usr/Cfg/Certificates/";

/// Storage that outlives the power. Names are absolute paths as in controller:NV-03.
pub trait NonVolatile: Send {
    /// A file's bytes, where it exists and is whole.
    fn read(&self, name: &str) -> Option<Vec<u8>>;

    /// Writes a file as a whole.
    fn write(&mut self, name: &str, bytes: &[u8]);

    /// Removes a file; one that does not exist is no error.
    fn remove(&mut self, name: &str);

    /// Shows every file with its name and its length in bytes, in the order of names.
    fn list(&self, each: &mut dyn FnMut(&str, u64));

    /// What a power loss leaves of a write: the first `kept` bytes are new, the others as they were.
    fn tear(&mut self, name: &str, bytes: &[u8], kept: usize);
}
