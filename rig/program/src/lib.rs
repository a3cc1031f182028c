//! Structured Text: compiler and resumable machine.
//!
//! [`compile`] turns sources of IEC 61131-3 Structured Text into a [`Program`]; a [`Machine`] runs its cycles in
//! slices of modelled time, each operation of the source costing what [`Costs`] says.
//!
//! ```
//! # use scanrig_program as program;
//! use program::{Host, Machine, Options, Stop, compile};
//! use signal::{Address, Span, Time, Value};
//!
//! struct NoMemory;
//! impl Host for NoMemory {
//!     fn load(&mut self, _: Address) -> u64 {
//!         0
//!     }
//!     fn store(&mut self, _: Address, _: u64, _: u8, _: u32) -> bool {
//!         false
//!     }
//! }
//!
//! let text = "PROGRAM MAIN VAR n : INT; END_VAR n := n + 1; END_PROGRAM".into();
//! let program = compile(&[document::SourceFile { name: "count.st".into(), text }], &Options::default()).unwrap();
//! let mut machine = Machine::new(program.into(), &[vec![0]]).unwrap();
//! machine.begin(0);
//! let slice = machine.resume(0, Time::ZERO, Span::from_micros(1), &mut NoMemory);
//! // A load, an addition and a store of INT.
//! assert_eq!((slice.used, slice.stop), (Span::from_nanos(32 + 42 + 32), Stop::Done));
//! assert_eq!(machine.read(machine.find("MAIN.n").unwrap()), Value::Int(1));
//! ```
//!
//! Goals: every finding with a code and a place, exact modelled time that does not depend on how a cycle is sliced,
//! no allocation while running. Not goals: tasks, states and images of the controller, which come in as [`Host`].
//!
//! What the language does not have yet is refused with a code, never read and ignored.

mod code;
mod codes;
mod findings;
mod fuse;
mod lower;
mod machine;
mod native;
mod options;
mod parse;
mod program;
mod run;
mod types;

pub use codes::CODES;
pub use machine::{Fault, FaultKind, Host, Machine, MachineError, Slice, Stop};
pub use native::{Native, Pin, PinKind, Pins, STANDARD};
pub use options::{Costs, Limits, Options};
pub use program::{Located, Program, Retention, Storage, VarRef, Variable};
pub use types::Elementary;

/// Compiles sources, which are one application together.
///
/// # Errors
/// The findings: at least one error, and at most [`Limits::errors`]; warnings among them.
pub fn compile(
    sources: &[document::SourceFile],
    options: &Options,
) -> Result<Program, Vec<document::Diagnostic>> {
    lower::compile(sources, options)
}
