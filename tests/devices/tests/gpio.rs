//! Boards of GPIO lines on the kernel's simulated chips, through both of its interfaces.

#[path = "gpio/bench.rs"]
mod bench;
#[path = "gpio/edges.rs"]
mod edges;
#[path = "gpio/lines.rs"]
mod lines;
#[path = "gpio/trouble.rs"]
mod trouble;
