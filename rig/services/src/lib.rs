//! Endpoints of a rig's services: each a core without I/O, and a thin shell that owns its sockets.

mod codes;
pub mod control;

pub use codes::CODES;
