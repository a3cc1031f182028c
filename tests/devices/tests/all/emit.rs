//! Boards of generators on the lab's SPI sink and PWM chip: every driver, ioctl and file of `/sys` is the kernel's.

mod bench;
mod command;
mod plan;
mod pwm;
mod stream;
