//! Boards of GPIO lines on the kernel's simulated chips, through both of its interfaces.

mod bench;
mod edges;
mod lines;
mod trouble;
