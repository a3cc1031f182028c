//! Runs the code that makes the instances, once, when everything else of a program is there. What it leaves in the
//! variables are their initial values.

use crate::codes::Code;
use crate::findings::{CompileFindings, SourcePlace};
use crate::host::{Host, StopReason};
use crate::machine::Machine;
use crate::program::Program;
use signal::{Address, Span, Time};
use std::ops::Range;
use std::sync::Arc;

/// Modelled time after which it is taken to be endless.
const LONGEST: Span = Span::from_secs(1);

/// What stands at addresses is not there yet.
#[derive(Debug, Default)]
struct Nothing {
    /// Where a store was tried.
    stored: Option<(Address, u16, u32)>,
}

impl Host for Nothing {
    fn load(&mut self, _: Address) -> u64 {
        0
    }

    fn store(&mut self, at: Address, _: u64, file: u16, line: u32) -> bool {
        self.stored.get_or_insert((at, file, line));
        false
    }
}

/// The program with the values that `unit` leaves; `makers` are the units that nothing else calls.
pub(crate) fn initialise(
    mut program: Program,
    unit: u16,
    makers: Range<usize>,
    findings: &mut CompileFindings<'_>,
) -> Program {
    let programs = std::mem::replace(&mut program.programs, vec![unit]);
    let shared = Arc::new(program);
    let mut host = Nothing::default();
    let run = Machine::new(Arc::clone(&shared), &[vec![0]]).map(|mut machine| {
        machine.begin(0);
        let stop = machine.resume(0, Time::ZERO, LONGEST, &mut host).stop;
        (stop, machine.memory().to_vec())
    });
    let mut program = Arc::try_unwrap(shared).unwrap_or_else(|shared| (*shared).clone());
    program.programs = programs;
    match run {
        Ok((StopReason::Done, values)) => {
            let range = program.variables_from as usize..program.variables_to as usize;
            if let (Some(to), Some(from)) = (program.image.get_mut(range.clone()), values.get(range)) {
                to.copy_from_slice(from);
            }
        }
        Ok((StopReason::Fault(fault), _)) => {
            let message = format!("making the instances ends with {:?}", fault.kind);
            failed(&program, message, fault.file, fault.line, findings);
        }
        _ => failed(&program, format!("making the instances takes longer than {LONGEST}"), 0, 0, findings),
    }
    if let Some((address, file, line)) = host.stored {
        failed(&program, format!("{address} is written while instances are made"), file, line, findings);
    }
    // They belong to no statement of the user's.
    let range = |nth: usize| program.units.get(nth).map_or(u32::MAX, |unit| unit.entry);
    let own = range(makers.start)..range(makers.end);
    program.statements.retain(|statement| !own.contains(&statement.pc));
    program
}

fn failed(program: &Program, message: String, file: u16, line: u32, findings: &mut CompileFindings<'_>) {
    let name = program.files.get(usize::from(file)).map_or("", String::as_str);
    let help = format!("see FB_Init and initial values of addresses; it was at {name}, line {line}");
    findings.error(Code::InitialValue, SourcePlace::default(), message, help);
}
