//! Boards of converters on the lab's SPI bus: every driver, ioctl and transfer limit is the kernel's.

mod bench;
mod parts;
mod plan;
mod transfers;
mod trouble;
