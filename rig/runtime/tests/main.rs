//! The executors from outside: one program, since each costs a link.

mod allocation;
mod bindings;
mod board_clock;
mod checks;
mod common;
mod delays;
mod determinism;
mod driven;
mod emission;
mod external;
mod flow;
mod guards;
mod instrument;
mod late;
mod level_loop;
mod library;
mod lines;
mod live;
mod modules;
mod plant_programs;
mod plants;
mod ports;
mod refused;
#[path = "common/scripted.rs"]
mod scripted;
mod steps;
#[path = "common/texts.rs"]
mod texts;
mod trouble;
mod worst_case;
mod writers;

#[global_allocator]
static COUNTING: counting::Counting = counting::Counting;
