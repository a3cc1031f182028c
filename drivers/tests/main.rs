//! Boards and board files from outside: one program, since each costs a link.

mod board_files;
mod common;
mod convert;
mod fake;
mod faults;
mod gpio;
mod lines;
mod plants;
mod relays;
mod scripted;
mod serial;
mod wrappers;
