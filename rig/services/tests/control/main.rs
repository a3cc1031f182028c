//! The control socket over real sockets, with a rig that does what it is asked.

mod bench;
mod fake;
mod property;
mod requests;
mod robust;
mod socket;
