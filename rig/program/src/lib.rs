//! Structured Text: compiler and resumable machine.
//!
//! [`compile`] turns sources of IEC 61131-3 Structured Text into a [`Program`]; a [`Machine`] runs its cycles in
//! slices of modelled time, each operation of the source costing what [`Costs`] says.
//!
//! ```
//! # use scanrig_program as program;
//! use program::{Host, Machine, Options, StopReason, compile};
//! use signal::{Address, Span, Time, Value};
//!
//! struct NoMemory;
//! impl Host for NoMemory {
//!     fn load(&mut self, _: Address) -> u64 {
//!         0
//!     }
//!     fn store(&mut self, _: Address, _: u64, _: u16, _: u32) -> bool {
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
//! assert_eq!((slice.used, slice.stop), (Span::from_nanos(32 + 42 + 32), StopReason::Done));
//! assert_eq!(machine.read(machine.find("MAIN.n").unwrap()), Value::Int(1));
//! ```
//!
//! Goals: every finding with a code and a place, exact modelled time that does not depend on how a cycle is sliced,
//! no allocation while running. Not goals: tasks, states and images of the controller, which come in as [`Host`].
//!
//! What the language does not have yet is refused with a code, never read and ignored.

mod assemble;
mod code;
mod codes;
mod emit;
mod extent;
mod findings;
mod host;
mod initialise;
mod library;
mod listing;
mod look;
mod machine;
mod native;
mod options;
mod parse;
mod program;
mod run;
mod sema;
mod set;
mod shape;
mod source;
mod state;
mod tree;
mod types;
mod vendor;
mod walk;

pub use codes::CODES;
pub use extent::Extent;
pub use host::{Host, MachineSlice, ProgramFault, ProgramFaultKind, StopReason};
pub use library::Service;
pub use listing::{ListedLine, ListedStep, ListedUnit};
pub use look::ShownVariable;
pub use machine::{ChangeError, ChangeReport, Machine};
pub use native::{BlockBody, Native, Pin, PinKind, Pins, STANDARD};
pub use options::{Costs, Options, ProgramLimits};
pub use parse::{declares, mentions};
pub use program::{
    ConfiguredTask, ImagePlace, Located, Program, ProgramPin, Retention, Storage, VarRef, Variable,
};
pub use set::SetError;
pub use shape::{Member, MemoryLayout, Root, ShapeId};
pub use source::source;
pub use state::{BranchCoverage, Coverage, MachineError, StatementCoverage};
pub use types::Elementary;

use codes::Code;
use document::{Diagnostic, SourceFile};
use findings::{CompileFindings, SourcePlace};

/// Files of one application. Libraries are distributed with a file for each unit.
const MOST_SOURCES: usize = 4000;

/// Compiles sources, which are one application together.
///
/// # Errors
/// The findings: at least one error, and at most [`ProgramLimits::errors`]; warnings among them.
pub fn compile(sources: &[SourceFile], options: &Options) -> Result<Program, Vec<Diagnostic>> {
    let own = sources.len().saturating_sub(options.provided);
    let mut needed = vendor::needed(sources);
    if needed.is_empty() {
        return compile_all(sources, own, options);
    }
    needed.splice(0..0, sources.iter().cloned());
    compile_all(&needed, own, options)
}

/// The first `own` sources are the user's.
fn compile_all(sources: &[SourceFile], own: usize, options: &Options) -> Result<Program, Vec<Diagnostic>> {
    let mut findings = CompileFindings::new(sources, options.limits.errors);
    let mut names = parse::NameTable::new();
    let size: usize = sources.iter().map(|source| source.text.len()).sum();
    if size > options.limits.source || sources.len() > MOST_SOURCES {
        let message = format!("{} sources of {size} bytes in all", sources.len());
        let help =
            format!("at most {MOST_SOURCES} sources of {} bytes in all are compiled", options.limits.source);
        findings.error(Code::SourceSize, SourcePlace::default(), message, help);
        return Err(findings.finish());
    }
    let unit = parse::parse(sources, own, &mut names, &mut findings);
    if findings.failed() {
        // A tree with faults has holes: what is missing would be reported as unknown.
        return Err(findings.finish());
    }
    let (tree, mut findings) = sema::check(&unit, &names, options, findings, (sources, own));
    if findings.failed() {
        return Err(findings.finish());
    }
    let (initial, makers) = (tree.initial, tree.makers.clone());
    let mut program = emit::emit(tree, options, &mut findings, sources);
    if let (Some(unit), false) = (initial, findings.failed()) {
        program = initialise::initialise(program, unit, makers, &mut findings);
    }
    if findings.failed() {
        return Err(findings.finish());
    }
    program.warnings = findings.finish();
    Ok(assemble::finish(program))
}

#[cfg(test)]
mod tests;
