//! Boards of counters: the lab's own, which a test moves or lets follow GPIO lines, through the kernel's counter subsystem.

mod bench;
mod counts;
mod plan;
mod settings;
mod trouble;
