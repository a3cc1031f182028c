//! Boards around any board: one that makes trouble, one that remembers.

mod faulty;
mod traced;

pub use faulty::{Disturbance, Faulty, MAX_HELD};
pub use traced::{Counts, Entry, Traced};
