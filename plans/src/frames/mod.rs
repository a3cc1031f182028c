//! What passes on buses, as plans name it: frames of CAN buses, and the patterns of data that they share with what else
//! carries bytes.

pub mod can;
mod data;

pub use data::{DataFault, DataPattern, MAX_DATA};
