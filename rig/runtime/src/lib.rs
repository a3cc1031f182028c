//! Subject, board and steps on a clock: what runs a case.
//!
//! Goals: one executor for virtual and real time; a trace that follows from the seed alone; trouble of the rig
//! never taken for trouble of the controller. Not goals: the meaning of expectations, the look of reports.

pub mod alone;
pub mod application;
pub mod bundle;
pub mod case;
pub mod clock;
mod codes;
mod configure;
pub mod coverage;
pub mod describe;
pub mod executor;
mod facts;
mod inputs;
pub mod lanes;
mod log;
pub mod names;
mod needs;
pub mod prepare;
pub mod recorder;
mod refusal;
pub mod rejudge;
pub mod schedule;
mod spill;
pub mod store;
pub mod subject;
pub mod suite;
mod system;
pub mod tasks;
pub mod trouble;
pub mod wiring;

pub use case::{CaseFiles, CaseResult, ClockKind, RunOptions, run_case};
pub use codes::CODES;
