//! Serial lines on ports of the kernel: 16550s joined in pairs, with the kernel's RS-485 emulation.

#[path = "serial/board.rs"]
mod board;
#[path = "serial/port.rs"]
mod port;
#[path = "trouble/rig.rs"]
#[allow(dead_code)]
mod rig;
#[path = "serial/run.rs"]
mod run;
