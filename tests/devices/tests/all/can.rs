//! CAN buses of boards on the lab's controllers.

mod bench;
mod configure;
mod frames;
mod settings;
mod trouble;
