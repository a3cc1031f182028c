//! A board around any board: one that makes trouble.

mod faulty;

pub use faulty::{Disturbance, Faulty, MAX_HELD};
