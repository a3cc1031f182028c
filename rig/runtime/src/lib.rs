//! Subject, board and steps on a clock: what runs a case.
//!
//! Goals: one executor for virtual and real time; a trace that follows from the seed alone; a fault of the rig
//! never taken for one of the controller. Not goals: the meaning of expectations, the look of reports.

mod applicability;
pub mod application;
pub mod bench_lock;
pub mod blocks;
pub mod bundle;
mod capability;
pub mod capture_import;
pub mod case;
mod case_export;
pub mod catalogue;
mod check;
pub mod clock;
mod codes;
mod configure;
pub mod coverage;
pub mod describe;
pub mod executor;
pub mod external;
pub mod figures;
mod file_signals;
pub mod frame_log;
pub mod frames;
pub mod functions;
pub mod generator;
pub mod hardware;
pub mod hook;
mod inputs;
pub mod instrument;
mod jobs;
pub mod lanes;
pub mod live;
mod log;
pub mod loop_counter;
mod needs;
pub mod operator;
pub mod prepare;
mod real_boards;
pub mod recorder;
mod refusal;
pub mod rejudge;
pub mod rig_fault;
pub mod schedule;
pub mod soft_plc;
mod spill;
pub mod standalone;
pub mod stepping;
pub mod store;
pub mod subject;
pub mod suite;
pub mod suites;
mod system_variables;
pub mod tasks;
mod test_setup;
pub mod variable_numbers;
mod wake_statistics;
pub mod wiring;

pub use bench_lock::BenchLock;
pub use case::{CaseFiles, CaseResult, ClockKind, RunOptions, run_case};
pub use codes::CODES;
pub use hardware::Hardware;
pub use loop_counter::LoopCounter;
pub use operator::{AskError, Operator};
