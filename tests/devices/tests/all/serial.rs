//! Serial lines on ports of the kernel: 16550s joined in pairs, with the kernel's RS-485 emulation.

mod board;
mod port;
mod run;
