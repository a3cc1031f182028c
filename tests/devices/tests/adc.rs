//! Boards of converters on the lab's SPI bus: every driver, ioctl and transfer limit is the kernel's.

#[path = "adc/bench.rs"]
mod bench;
#[path = "adc/parts.rs"]
mod parts;
#[path = "adc/plan.rs"]
mod plan;
#[path = "adc/transfers.rs"]
mod transfers;
#[path = "adc/trouble.rs"]
mod trouble;
