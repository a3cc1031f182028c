//! Subject, board and steps on a clock: what runs a case.
//!
//! Goals: one executor for virtual and real time; a trace that follows from the seed alone; trouble of the rig
//! never taken for trouble of the controller. Not goals: the meaning of expectations, the look of reports.

pub mod alone;
pub mod application;
pub mod bench_lock;
pub mod blocks;
pub mod bundle;
mod capability;
pub mod case;
pub mod catalogue;
mod check;
pub mod clock;
mod codes;
mod configure;
pub mod coverage;
pub mod describe;
pub mod executor;
pub mod external;
mod facts;
pub mod figures;
pub mod foreign;
pub mod frame_log;
pub mod frames;
pub mod functions;
pub mod generator;
mod hand;
pub mod hardware;
pub mod hook;
mod inputs;
pub mod instrument;
pub mod lanes;
mod lines;
pub mod live;
mod log;
pub mod names;
mod needs;
pub mod operator;
pub mod play;
pub mod prepare;
mod punctuality;
mod queue;
mod reach;
pub mod recorder;
mod refusal;
pub mod rejudge;
pub mod schedule;
mod spill;
mod stage;
pub mod stepping;
pub mod store;
pub mod subject;
pub mod suite;
pub mod suites;
mod system;
pub mod tasks;
pub mod trouble;
pub mod turns;
pub mod wiring;

pub use bench_lock::BenchLock;
pub use case::{CaseFiles, CaseResult, ClockKind, RunOptions, run_case};
pub use codes::CODES;
pub use hardware::Hardware;
pub use operator::{AskError, Operator};
pub use turns::Turns;
