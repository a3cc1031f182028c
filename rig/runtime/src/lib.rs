//! Subject, board and steps on a clock: what runs a case.
//!
//! Goals: one executor for virtual and real time; a trace that follows from the seed alone; a fault of the rig
//! never taken for one of the controller. Not goals: the meaning of expectations, the look of reports.

pub mod application;
pub mod case;
mod codes;
pub mod executor;
pub mod frames;
pub mod generator;
pub mod hardware;
pub mod instrument;
pub mod live;
pub mod prepare;
pub mod scan_port;
pub mod schedule;
pub mod soft_plc;
pub mod subject;
pub mod suite;
pub mod wiring;

pub use case::{CaseResult, ClockKind, RunOptions, run_case};
pub use codes::CODES;
pub use executor::loop_counter::LoopCounter;
pub use executor::operator::{AskError, Operator};
pub use hardware::Hardware;
pub use hardware::bench_lock::BenchLock;
pub use suite::case_files::CaseFiles;
