//! Boards and board files from outside: one program, since each costs a link.

mod board_files;
mod common;
mod convert;
mod counter;
mod emit;
mod fake;
mod faults;
mod generating;
mod gpio;
mod lines;
mod plant_instants;
mod plant_kinds;
mod plant_programs;
mod plants;
mod relays;
mod scripted;
mod scripted_counter;
mod serial;
mod tallies;
mod wrappers;
