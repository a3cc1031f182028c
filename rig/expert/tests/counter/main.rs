//! Fast counters and meters, by their blocks and edges.

mod blocks;
mod compare;
mod modes;
mod pace;
mod props;
mod records;
mod rig;
mod steps;
