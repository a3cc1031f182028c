//! The plan language: plans are read and checked here, and what they claim is judged here.
//!
//! [`read`] makes a [`Plan`] of a text; [`Plan::case`] gives its concrete cases one by one; [`judge`] turns a
//! trace into verdicts. Steps are one file of [`steps`] for each verb, expectations one of [`expect`].
//!
//! Goals: every finding with a code, the exact place and the fix; several findings in one run; bounded time
//! and memory for any text. Not goals: opening files, driving anything: the runtime does both.

pub mod alarm;
pub mod bench;
mod codes;
pub mod expect;
pub mod frames;
pub mod judge;
pub mod lang;
mod meaning;
pub mod measure;
mod module_names;
pub mod monitor;
pub mod plan;
pub mod register;
pub mod schema;
pub mod signals;
pub mod steps;
pub mod table;

pub use codes::{CODES, TOML};
pub use lang::{Anchor, AnchorBase, Literal};
pub use meaning::{show_literal, value_of};
pub use plan::{Case, Plan, PlanStep, StepTime, check_included, gather, read, read_gathered};
pub use steps::Stimulus;
