//! The user's program as the controller's application: `program` and `controller` meet here, for neither knows
//! the other.

pub mod blocks;
pub mod bundle;
pub mod catalogue;
pub mod coverage;
pub mod functions;
pub(crate) mod image_places;
pub(crate) mod inputs;
pub mod module_terminals;
pub mod modules;
pub mod observable;
pub mod store;
pub(crate) mod system_variables;
pub mod taken_values;
pub mod tasks;
pub mod variable_numbers;

use crate::application::bundle::{Bundle, TaskPrograms};
use crate::application::coverage::Collector;
use crate::application::system_variables::with_system;
use crate::application::variable_numbers::{ResolvedVariables, VariableNumbers};
use crate::codes;
use controller::{
    Application, ApplicationFault, ExtentStart, FaultClass, LoadError, Loader, Memory, RegisterFormat, Slice,
    SliceEnd, SystemCall, VariableLocation, VariableReset,
};
use document::{Diagnostic, SourceFile};
use expert::ExpertFunctions;
use profile::{ApplicationError, Profile};
use program::{Elementary, Extent, Host, Machine, Options, Pins, Program, ProgramFaultKind, Storage, VarRef};
use signal::{Address, Area, Cause, Size, Span, Time, Value};
use std::any::Any;
use std::sync::Arc;

/// What a program of this controller is compiled with: its address ranges and its instruction times.
pub fn options(profile: Profile) -> Options {
    let mut options = Options::default();
    options.limits.addresses = profile.address_limits();
    options.limits.memory = profile::APPLICATION_BYTES;
    options.limits.text = profile.longest_text();
    let documented = profile.instruction_costs();
    let costs = &mut options.costs;
    costs.bool_op = documented.bool_op;
    (costs.bool_load, costs.bool_store) = halves(documented.bool_op);
    costs.int_op = documented.int_arith;
    (costs.int_load, costs.int_store) = halves(documented.int_load_store);
    costs.dint_op = documented.dint_arith;
    (costs.dint_load, costs.dint_store) = halves(documented.dint_load_store);
    costs.real_op = documented.real_arith;
    costs.real_div = documented.real_div;
    (costs.real_load, costs.real_store) = halves(documented.real_load_store);
    options
}

/// A documented figure for load and store together, the store taking the odd nanosecond.
const fn halves(pair: u32) -> (u32, u32) {
    (pair / 2, pair - pair / 2)
}

/// Compiles the sources of an application for a controller of this profile.
///
/// # Errors
/// The findings of the compiler.
pub fn compile(sources: &[SourceFile], profile: Profile) -> Result<Program, Vec<Diagnostic>> {
    compile_with(sources, profile, options(profile))
}

/// The same for sources that need not have a PROGRAM: a library.
///
/// # Errors
/// The findings of the compiler.
pub fn compile_library(sources: &[SourceFile], profile: Profile) -> Result<Program, Vec<Diagnostic>> {
    compile_with(sources, profile, Options { library: true, ..options(profile) })
}

fn compile_with(
    sources: &[SourceFile],
    profile: Profile,
    options: Options,
) -> Result<Program, Vec<Diagnostic>> {
    let given = sources.len();
    let (sources, read_only) = with_system(sources, profile);
    let (blocks, provided) = (blocks::blocks(&sources), sources.len() - given);
    program::compile(&sources, &Options { read_only, blocks, provided, ..options })
}

/// What a check of a program says besides its findings: types that this controller's documents do not list
/// (controller:DT-04).
pub fn notes(program: &Program, profile: Profile) -> Vec<Diagnostic> {
    let missing = matches!(profile, Profile::M241_2014 | Profile::M241_2019);
    let Some((file, span)) = program.lreal().filter(|_| missing) else { return Vec::new() };
    let name = program.files().get(usize::from(file)).cloned().unwrap_or_default();
    let message = format!("the documents of {} do not list the type LREAL", profile.name());
    let note = Diagnostic::warning(codes::TYPE_NOT_DOCUMENTED, message).at(name, span, "");
    vec![note.help("its programming tool has the type, and the model runs it; REAL is in the table")]
}

/// The PROGRAMs that each task runs: those that its list names, and for the tasks without a list all that no
/// other task names. `None` where a list names a PROGRAM that the sources do not have.
pub fn assign(program: &Program, tasks: &[TaskPrograms]) -> Option<Vec<Vec<usize>>> {
    let find = |name: &String| program.programs().iter().position(|known| known.eq_ignore_ascii_case(name));
    let named: Option<Vec<Vec<usize>>> =
        tasks.iter().map(|task| task.named().iter().map(find).collect()).collect();
    let mut named = named?;
    let taken: Vec<usize> = named.iter().flatten().copied().collect();
    let rest: Vec<usize> = (0..program.programs().len()).filter(|place| !taken.contains(place)).collect();
    for (places, task) in named.iter_mut().zip(tasks) {
        if task.programs.is_none() {
            places.clone_from(&rest);
        }
    }
    Some(named)
}

/// A machine in the controller's hands.
#[derive(Debug)]
pub struct ProgramApplication {
    machine: Machine,
    /// The PROGRAMs of each task, by their places.
    places: Vec<Vec<usize>>,
    profile: Profile,
    /// Per task the bytes of %Q that its programs can write.
    output_bytes: Vec<Vec<u32>>,
    /// Per task the places in %Q that its programs can write.
    outputs: Vec<Vec<Address>>,
    /// Per task the places in %I that its programs read.
    inputs: Vec<Vec<Address>>,
    /// Where it leaves what of it ran.
    collector: Option<Collector>,
    names: VariableNumbers,
    /// Where the variables of `names` are.
    resolved: ResolvedVariables,
}

impl ProgramApplication {
    /// A machine for `program` whose tasks run the PROGRAMs at these places.
    ///
    /// # Errors
    /// [`LoadError`] when the program does not fit the controller.
    pub fn new(program: Arc<Program>, tasks: &[Vec<usize>], profile: Profile) -> Result<Self, LoadError> {
        let machine = Machine::new(Arc::clone(&program), tasks).map_err(|_| LoadError::Bundle)?;
        let output_bytes = tasks.iter().map(|programs| written_bytes(&program, programs)).collect();
        let outputs = tasks
            .iter()
            .map(|programs| programs.iter().flat_map(|place| program.outputs_of(*place)).collect())
            .collect();
        let inputs = tasks
            .iter()
            .map(|programs| programs.iter().flat_map(|place| program.inputs_of(*place)).collect())
            .collect();
        Ok(ProgramApplication {
            machine,
            places: tasks.to_vec(),
            profile,
            output_bytes,
            outputs,
            inputs,
            collector: None,
            names: VariableNumbers::default(),
            resolved: ResolvedVariables::default(),
        })
    }

    /// The same, with its variables known by the numbers of this table too.
    #[must_use]
    pub fn named(mut self, names: VariableNumbers) -> Self {
        self.resolved = names.resolve(self.machine.program());
        self.names = names;
        self
    }

    /// The same, with what of it runs added to the collector in the end.
    #[must_use]
    pub fn covered(mut self, collector: Collector) -> Self {
        self.machine.set_coverage(true);
        self.collector = Some(collector);
        self
    }
}

impl ProgramApplication {
    /// Adds what ran of it to the collector, if there is one.
    fn leave_coverage(&self) {
        if let Some(collector) = &self.collector {
            collector.add(self.machine.program().digest(), self.machine.coverage());
        }
    }
}

impl Drop for ProgramApplication {
    fn drop(&mut self) {
        self.leave_coverage();
    }
}

fn written_bytes(program: &Program, programs: &[usize]) -> Vec<u32> {
    let mut bytes: Vec<u32> = programs
        .iter()
        .flat_map(|place| program.outputs_of(*place))
        .flat_map(|address| {
            let last = address.bit_offset() + address.bit_len() - 1;
            address.bit_offset() / 8..=last / 8
        })
        .collect();
    bytes.sort_unstable();
    bytes.dedup();
    bytes
}

/// The controller's memory as the machine's host.
struct TaskMemory<'a> {
    memory: &'a mut Memory,
    functions: &'a mut ExpertFunctions,
    task: u8,
}

impl Host for TaskMemory<'_> {
    #[inline]
    fn load(&mut self, at: Address) -> u64 {
        self.memory.load(at)
    }

    #[inline]
    fn store(&mut self, at: Address, value: u64, file: u16, line: u32) -> bool {
        self.memory.set_cause(Cause::Program { task: self.task, file, line });
        self.memory.store(at, value)
    }

    fn block(&mut self, block: u16, pins: &mut Pins<'_>) -> bool {
        blocks::call(block, pins, self.functions)
    }
}

impl Application for ProgramApplication {
    fn tasks(&self) -> usize {
        self.places.len()
    }

    fn begin(&mut self, task: usize) {
        self.machine.begin(task);
    }

    fn resume(
        &mut self,
        task: usize,
        now: Time,
        budget: Span,
        memory: &mut Memory,
        functions: &mut ExpertFunctions,
    ) -> Slice {
        let mut host = TaskMemory { memory, functions, task: task as u8 };
        let slice = self.machine.resume(task, now, budget, &mut host);
        let end = match slice.stop {
            program::StopReason::Budget { next } => SliceEnd::Budget { next },
            program::StopReason::Done => SliceEnd::Done,
            // Nobody sets breakpoints here yet; a stop at one is no more than the end of a slice.
            program::StopReason::Touched { file, line } => {
                host.memory.set_cause(Cause::Program { task: host.task, file, line });
                SliceEnd::Touched
            }
            program::StopReason::Break => SliceEnd::Break,
            program::StopReason::Service { service, argument } => {
                SliceEnd::SystemCall { call: call_of(service), argument }
            }
            program::StopReason::Fault(fault) => SliceEnd::Fault(application_fault(fault, self.profile)),
        };
        Slice { used: slice.used, end }
    }

    fn reset(&mut self, reset: VariableReset) {
        self.machine.reset(reset.keep_retain, reset.keep_persistent);
    }

    fn initialize(&self, memory: &mut Memory) {
        for located in self.machine.program().located() {
            if let Some(initial) = located.initial {
                memory.set_cause(Cause::Controller);
                memory.store(located.address, initial);
            }
        }
    }

    fn associates(&self, word: u32) -> bool {
        let word = Address::new(Area::Memory, Size::Word, word);
        let mut located = self.machine.program().located().iter();
        word.is_some_and(|word| located.any(|known| known.overlaps(&word)))
    }

    fn writes_output(&self, task: usize, byte: u32) -> bool {
        self.output_bytes.get(task).is_some_and(|bytes| bytes.binary_search(&byte).is_ok())
    }

    fn writes_output_bit(&self, task: usize, bit: u32) -> bool {
        let bit = Address::bit(Area::Output, bit);
        self.outputs.get(task).is_some_and(|outputs| outputs.iter().any(|written| written.overlaps(&bit)))
    }

    fn reads_input(&self, task: usize, bit: u32) -> bool {
        let bit = Address::bit(Area::Input, bit);
        self.inputs.get(task).is_some_and(|inputs| inputs.iter().any(|read| read.overlaps(&bit)))
    }

    fn retained_len(&self) -> usize {
        self.machine.retained_len()
    }

    fn save_retained(&self, out: &mut [u8]) {
        self.machine.save_retained(out);
    }

    fn restore_retained(&mut self, image: &[u8]) -> bool {
        self.machine.restore_retained(image)
    }

    fn retained_map(&self) -> Vec<u8> {
        self.machine.retained_map()
    }

    fn adopt_retained(&mut self, map: &[u8], image: &[u8]) -> bool {
        self.machine.adopt_retained(map, image)
    }

    fn declarations(&self) -> u64 {
        self.machine.program().declarations()
    }

    fn retained_dirty(&mut self) -> bool {
        self.machine.retained_dirty()
    }

    fn signature(&self) -> u64 {
        self.machine.signature()
    }

    fn variable(&self, path: &str) -> Option<u32> {
        self.machine.find(path).map(|variable| variable.0)
    }

    fn locate(&self, path: &str) -> Option<VariableLocation> {
        let program = self.machine.program();
        if let Some(Extent { first, bytes }) = program.extent(path) {
            let first = match first {
                Storage::Located(address) => ExtentStart::Memory(address),
                Storage::Cell(cell) => ExtentStart::Variable(cell.0),
            };
            return Some(VariableLocation::Extent { first, bytes });
        }
        let variable = program.find(path).filter(|variable| variable.dimensions.is_empty())?;
        match variable.storage {
            Storage::Located(address) => Some(VariableLocation::Memory(address)),
            Storage::Cell(cell) => Some(VariableLocation::Variable(cell.0, form_of(variable.ty))),
        }
    }

    fn word_of(&self, first: u32, bytes: u32, word: u16) -> Option<u32> {
        VarRef(first).word_of(bytes, word).map(|variable| variable.0)
    }

    fn read(&self, variable: u32) -> Value {
        self.resolved.of(variable).map_or(Value::Unknown, |variable| self.machine.read(variable))
    }

    fn write(&mut self, variable: u32, value: Value) {
        if let Some(variable) = self.resolved.of(variable) {
            self.machine.write(variable, value);
        }
    }

    fn watch(&mut self, variable: u32) {
        if self.resolved.lacks(variable) {
            self.resolved = self.names.resolve(self.machine.program());
        }
        if let Some(variable) = self.resolved.of(variable) {
            self.machine.watch(variable);
        }
    }

    fn unwatch(&mut self, variable: u32) {
        if let Some(variable) = self.resolved.of(variable) {
            self.machine.unwatch(variable);
        }
    }

    fn answer(&mut self, task: usize, result: i64) {
        self.machine.answer(task, result);
    }

    fn breakpoint(&mut self, file: u16, line: u32) -> Option<u32> {
        self.machine.set_breakpoint(file, line)
    }

    fn clear_breakpoints(&mut self) {
        self.machine.clear_breakpoints();
    }

    fn step(&mut self, task: usize) {
        self.machine.step(task);
    }

    fn succeed(&mut self, old: &mut dyn Application) -> Option<bool> {
        let old: &mut ProgramApplication = old.as_any().downcast_mut()?;
        self.leave_coverage();
        old.leave_coverage();
        let new = Arc::clone(self.machine.program());
        let report = old.machine.change(new, &self.places).ok()?;
        std::mem::swap(&mut self.machine, &mut old.machine);
        if self.collector.is_some() {
            self.machine.set_coverage(true);
        }
        Some(report.new == 0 && report.lost == 0)
    }

    fn as_any(&mut self) -> &mut dyn Any {
        self
    }
}

/// What a program asks for, as the controller knows it.
const fn call_of(service: program::Service) -> SystemCall {
    match service {
        program::Service::WaitSleep => SystemCall::WaitSleep,
        program::Service::GetTaskCycle => SystemCall::GetTaskCycle,
        program::Service::SetTaskCycle => SystemCall::SetTaskCycle,
        program::Service::FirstMastCycle => SystemCall::FirstMastCycle,
        program::Service::FirstMastColdCycle => SystemCall::FirstMastColdCycle,
        program::Service::FirstMastWarmCycle => SystemCall::FirstMastWarmCycle,
        program::Service::HasForcedIo => SystemCall::HasForcedIo,
        program::Service::ModuleInternalStatus => SystemCall::ModuleInternalStatus,
        program::Service::GetRtc => SystemCall::GetRtc,
        program::Service::SetRtcDrift => SystemCall::SetRtcDrift,
        program::Service::InhibitBatteryLed => SystemCall::InhibitBatteryLed,
        program::Service::ModuleBusStatus => SystemCall::ModuleBusStatus,
        program::Service::ModuleFirmware => SystemCall::ModuleFirmware,
    }
}

/// How a value of this type fills registers (controller:REL-04).
fn form_of(ty: Elementary) -> RegisterFormat {
    match ty {
        Elementary::Bool => RegisterFormat::Bit,
        Elementary::Real => RegisterFormat::Real,
        Elementary::Lreal => RegisterFormat::Long,
        ty => RegisterFormat::Whole(ty.bits().div_ceil(16) as u16),
    }
}

/// What the controller makes of a fault of the machine (controller:ERR-01, controller:SYS-03).
fn application_fault(fault: program::ProgramFault, profile: Profile) -> ApplicationFault {
    let (error, class) = match fault.kind {
        ProgramFaultKind::DivisionByZero => (ApplicationError::IntegerDivision, FaultClass::Application),
        ProgramFaultKind::RealDivisionByZero => (ApplicationError::RealDivision, FaultClass::Application),
        // The 2014 document names an exceeded array as a system error. The later ones do not, and they let
        // system errors that can be managed at run time be treated as application errors (controller:ERR-02).
        ProgramFaultKind::Bounds if profile == Profile::M241_2014 => {
            (ApplicationError::ReservedMemory, FaultClass::System)
        }
        ProgramFaultKind::Bounds | ProgramFaultKind::BadReference => {
            (ApplicationError::ReservedMemory, FaultClass::Application)
        }
        // All three documents name a write to memory that is reserved at run time; a read is none.
        ProgramFaultKind::ReservedWrite => (ApplicationError::ReservedMemory, FaultClass::System),
        // What lies beyond the stack is memory reserved at run time, and no task can go on without its stack.
        ProgramFaultKind::StackDepth => (ApplicationError::ReservedMemory, FaultClass::System),
        ProgramFaultKind::Internal => (ApplicationError::UndefinedInstruction, FaultClass::System),
    };
    ApplicationFault { error, class, file: fault.file, line: fault.line }
}

/// Compiles the bundles that a controller loads.
#[derive(Clone, Debug)]
pub struct BundleLoader {
    profile: Profile,
    collector: Option<Collector>,
    names: VariableNumbers,
}

impl BundleLoader {
    /// A loader for a controller of this profile.
    pub fn new(profile: Profile) -> Self {
        BundleLoader { profile, collector: None, names: VariableNumbers::default() }
    }

    /// The same, whose applications know their variables by the numbers of this table too.
    #[must_use]
    pub fn named(mut self, names: VariableNumbers) -> Self {
        self.names = names;
        self
    }

    /// The same, with what of the applications runs added to the collector.
    #[must_use]
    pub fn covered(mut self, collector: Option<Collector>) -> Self {
        self.collector = collector;
        self
    }
}

impl Loader for BundleLoader {
    fn load(&mut self, bundle: &[u8]) -> Result<Box<dyn Application>, LoadError> {
        let bundle = Bundle::from_bytes(bundle).map_err(|_| LoadError::Bundle)?;
        let program = compile(&bundle.sources, self.profile)
            .map_err(|findings| LoadError::Program { errors: findings.len() })?;
        let tasks = assign(&program, &bundle.tasks).ok_or(LoadError::Bundle)?;
        let application =
            ProgramApplication::new(Arc::new(program), &tasks, self.profile)?.named(self.names.clone());
        Ok(Box::new(match &self.collector {
            Some(collector) => application.covered(collector.clone()),
            None => application,
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lreal_is_noted_where_the_documents_do_not_list_it() {
        // controller:DT-04
        let text = "PROGRAM MAIN VAR a : REAL; b : LREAL; END_VAR END_PROGRAM";
        let noted = |profile: Profile| {
            let program = compile(&[SourceFile::new("a.st", text)], profile).unwrap();
            notes(&program, profile).iter().map(|d| (d.code, d.labels[0].span.clone())).collect::<Vec<_>>()
        };
        let place = text.find("LREAL").unwrap();
        assert_eq!(noted(Profile::M241_2014), [("R0117", place..place + 5)]);
        assert_eq!(noted(Profile::M241_2019), [("R0117", place..place + 5)]);
        assert_eq!(noted(Profile::M251_2024), []);
    }
}
