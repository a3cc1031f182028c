//! CAN buses of boards on the lab's controllers.

#[path = "can/bench.rs"]
mod bench;
#[path = "can/configure.rs"]
mod configure;
#[path = "can/frames.rs"]
mod frames;
#[path = "can/settings.rs"]
mod settings;
#[path = "can/trouble.rs"]
mod trouble;
