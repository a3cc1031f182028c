//! Non-volatile storage as the controller sees it.

/// The boot application (controller:NV-03).
pub const APPLICATION_FILE: &str = "/usr/App/Application.app";

/// The two alternating images of the remanent variables (controller:NV-03, controller:REM-07).
pub const RETAIN_FILES: [&str; 2] = ["/data/retain.0", "/data/retain.1"];

/// The state that the controller is in, kept for the boot decision (controller:RB-02). A single word of
/// battery-backed memory: written at once, never torn.
pub const STATE_FILE: &str = "/data/state";

/// Storage that outlives the power. Names are absolute paths as in controller:NV-03.
pub trait NonVolatile: Send {
    /// A file's bytes, where it exists and is whole.
    fn read(&self, name: &str) -> Option<Vec<u8>>;

    /// Writes a file as a whole.
    fn write(&mut self, name: &str, bytes: &[u8]);

    /// Removes a file; one that does not exist is no error.
    fn remove(&mut self, name: &str);

    /// What a power loss leaves of a write: the first `kept` bytes are new, the others as they were.
    fn tear(&mut self, name: &str, bytes: &[u8], kept: usize);
}
