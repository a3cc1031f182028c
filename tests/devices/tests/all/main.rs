//! Tests that need real kernel devices, a module a subject: run by `tests/lab/devices`, each in a process of its own.
//! They are one program, because each would hold the whole rig.

mod adc;
mod attacks;
mod bench;
mod board;
mod can;
mod counter;
mod emit;
mod executor;
mod faults;
mod frames;
mod gpio;
mod guard;
mod guarded_runs;
mod iio;
mod lab;
mod live;
mod pulses;
mod rig;
mod serial;
mod trains;
mod trouble;
