//! Programs that plants run: read beside their board file, compiled without a controller, run without its time.

use crate::suite::file_source::{FileSource, beside, load_program};
use document::{Diagnostic, SourceFile};
use drivers::circuit::{
    PlantMachine, PlantProgram, PlantProgramError, PlantPrograms, PlantVariable, PlantVariableKind,
};
use program::{
    Costs, Elementary, Host, Machine, Options, Program, ProgramLimits, ProgramPin, StopReason, VarRef,
    compile,
};
use signal::{Address, AddressLimits, Span, Time, Value};
use std::cell::RefCell;
use std::sync::Arc;

/// Bytes of the variables and constants of a plant's program: a board has up to 4096 plants.
const MEMORY: u32 = 1 << 20;
/// The same of all plants of a board together.
const TOGETHER: usize = 64 << 20;
/// The compiler's code of an address that does not exist.
const NO_ADDRESS: &str = "S0207";
/// What a cycle may cost by [`Costs::COUNTED`]: some ten milliseconds of the host, whatever the program does.
const MOST_OPERATIONS: i64 = 1_000_000;

/// The programs of the plants of a board file.
pub(crate) struct BoardPrograms<'a> {
    files: &'a dyn FileSource,
    board: &'a str,
    read: RefCell<ReadPrograms>,
}

/// What was read so far.
#[derive(Debug, Default)]
pub(crate) struct ReadPrograms {
    /// The files, each once.
    pub(crate) sources: Vec<SourceFile>,
    /// What is worth knowing of them.
    pub(crate) warnings: Vec<Diagnostic>,
    /// Programs by the paths of their files: plants share them.
    compiled: Vec<(Vec<String>, Arc<CompiledProgram>)>,
    /// The bytes of the variables of all plants so far: each has its own.
    bytes: usize,
}

impl<'a> BoardPrograms<'a> {
    /// Those beside the board file of this path.
    pub(crate) fn new(files: &'a dyn FileSource, board: &'a str) -> Self {
        BoardPrograms { files, board, read: RefCell::default() }
    }

    /// What was read.
    pub(crate) fn into_read(self) -> ReadPrograms {
        self.read.into_inner()
    }

    /// The program of another plant, whose variables there is room for.
    fn counted(&self, of: Arc<CompiledProgram>) -> Result<Arc<dyn PlantProgram>, PlantProgramError> {
        let mut read = self.read.borrow_mut();
        read.bytes = read.bytes.saturating_add(of.machine.machine.program().memory_bytes());
        if read.bytes > TOGETHER {
            let message =
                format!("the variables of the programs of all plants need more than {} MiB", TOGETHER >> 20);
            return Err(unsuited(
                message,
                "declare less in them, or have one program do the work of several",
            ));
        }
        Ok(of)
    }

    /// The file of a path.
    fn source(&self, path: &str) -> Result<SourceFile, Diagnostic> {
        let known = self.read.borrow().sources.iter().find(|known| known.name == path).cloned();
        match known {
            Some(known) => Ok(known),
            None => {
                let source = load_program(self.files, path)?;
                self.read.borrow_mut().sources.push(source.clone());
                Ok(source)
            }
        }
    }
}

impl PlantPrograms for BoardPrograms<'_> {
    fn load(&self, files: &[&str]) -> Result<Arc<dyn PlantProgram>, PlantProgramError> {
        let paths: Vec<String> = files.iter().map(|file| beside(self.board, file)).collect();
        let known =
            self.read.borrow().compiled.iter().find(|(of, _)| *of == paths).map(|(_, known)| known.clone());
        if let Some(known) = known {
            return self.counted(known);
        }
        let sources: Result<Vec<SourceFile>, Diagnostic> =
            paths.iter().map(|path| self.source(path)).collect();
        let sources = sources.map_err(|found| {
            let help = format!("{}; the path is relative to the board file", found.help);
            PlantProgramError::Findings(vec![found.help(help)])
        })?;
        let compiled = compile(&sources, &options());
        let mut compiled = compiled.map_err(|found| PlantProgramError::Findings(without_memory(found)))?;
        let warnings = std::mem::take(&mut compiled.warnings);
        let compiled = Arc::new(CompiledProgram::new(compiled)?);
        let mut read = self.read.borrow_mut();
        read.warnings.extend(warnings);
        read.compiled.push((paths, Arc::clone(&compiled)));
        drop(read);
        self.counted(compiled)
    }
}

/// The standard blocks and functions, and nothing of a controller: no images, no mapped memory, no system variables. That images
/// are not there is [`refuse`]'s to say, who knows what to write instead.
fn options() -> Options {
    let limits = ProgramLimits::default();
    let addresses = AddressLimits { memory_words: 0, ..limits.addresses };
    let limits = ProgramLimits { memory: MEMORY, addresses, ..limits };
    Options { costs: Costs::COUNTED, limits, ..Options::default() }
}

/// Findings of the compiler, which speaks of a controller where a plant has no memory.
fn without_memory(mut found: Vec<Diagnostic>) -> Vec<Diagnostic> {
    for one in found.iter_mut().filter(|one| one.code == NO_ADDRESS && one.help.is_empty()) {
        one.help =
            String::from("a plant has no %M: declare a variable, and connect VAR_INPUT and VAR_OUTPUT");
    }
    found
}

/// A program that a plant can run.
#[derive(Debug)]
struct CompiledProgram {
    /// With every variable at its initial value.
    machine: ProgramMachine,
    variables: Vec<PlantVariable>,
}

impl CompiledProgram {
    fn new(program: Program) -> Result<CompiledProgram, PlantProgramError> {
        refuse(&program)?;
        let pins = program.pins().to_vec();
        let places: Vec<Option<(VarRef, Elementary)>> =
            pins.iter().map(|pin| program.resolve(&pin.path).zip(pin.ty)).collect();
        let machine = Machine::new(Arc::new(program), &[vec![0]]);
        let machine = machine.map_err(|error| unsuited(error.to_string(), "declare less in it"))?;
        let machine = ProgramMachine { machine, places: places.into() };
        let variable = |(place, pin): (usize, &ProgramPin)| PlantVariable {
            name: pin.name.clone(),
            is_input: pin.is_input,
            kind: pin.ty.map_or(PlantVariableKind::Other, kind_of),
            initial: machine.get(place),
        };
        let variables = pins.iter().enumerate().map(variable).collect();
        Ok(CompiledProgram { machine, variables })
    }
}

fn unsuited(message: String, help: &str) -> PlantProgramError {
    PlantProgramError::Unsuited(message, help.to_owned())
}

/// What a program has that no plant can run.
fn refuse(program: &Program) -> Result<(), PlantProgramError> {
    let file = |place: u16| program.files().get(usize::from(place)).map_or("", String::as_str);
    if let [first, second, ..] = program.programs() {
        let message = format!("a plant runs one PROGRAM, and here are `{first}` and `{second}`");
        return Err(unsuited(message, "make a FUNCTION_BLOCK of one, or a plant of each"));
    }
    if let Some(task) = program.tasks().first() {
        let message = format!("`{}` configures the task `{}`: a plant has none", file(task.file), task.name);
        return Err(unsuited(message, "remove the CONFIGURATION: `period` says how often it runs"));
    }
    let pins = "declare VAR_INPUT and VAR_OUTPUT, and bind them by `inputs` and `outputs`";
    if let Some(image) = program.images().first() {
        let message = format!("`{}` names {}: a plant has no images", file(image.file), image.address);
        return Err(unsuited(message, pins));
    }
    if let Some((place, line)) = program.asks_controller() {
        let message = format!("{}:{line} asks the controller: a plant has none", file(place));
        return Err(unsuited(message, "remove the call; what the plant is to know comes by an input"));
    }
    Ok(())
}

/// What a channel or a number does with a variable of this type.
fn kind_of(ty: Elementary) -> PlantVariableKind {
    match ty {
        Elementary::Bool => PlantVariableKind::Level,
        Elementary::Real => {
            PlantVariableKind::Number { least: -f64::from(f32::MAX), most: f64::from(f32::MAX) }
        }
        Elementary::Lreal => PlantVariableKind::Number { least: -f64::MAX, most: f64::MAX },
        ty if ty.is_integer() && !ty.is_bit_string() => {
            let (least, most) = ty.range();
            PlantVariableKind::Number { least: least as f64, most: most as f64 }
        }
        _ => PlantVariableKind::Other,
    }
}

impl PlantProgram for CompiledProgram {
    fn variables(&self) -> &[PlantVariable] {
        &self.variables
    }

    fn machine(&self) -> Box<dyn PlantMachine> {
        Box::new(self.machine.clone())
    }
}

/// A machine in the hands of a plant.
#[derive(Clone, Debug)]
struct ProgramMachine {
    machine: Machine,
    /// Where its inputs and outputs are; `None` for those that no channel carries.
    places: Arc<[Option<(VarRef, Elementary)>]>,
}

/// There is nothing beside the program's own memory: what names an address was refused, and a pointer that is led there by
/// reckoning finds nothing.
struct NoImages;

impl Host for NoImages {
    fn load(&mut self, _at: Address) -> u64 {
        0
    }

    fn store(&mut self, _at: Address, _value: u64, _file: u16, _line: u32) -> bool {
        false
    }
}

impl PlantMachine for ProgramMachine {
    fn reset(&mut self) {
        self.machine.reset(false, false);
    }

    fn set(&mut self, variable: usize, value: f64) {
        let Some((place, ty)) = self.places.get(variable).copied().flatten() else { return };
        let value = match kind_of(ty) {
            PlantVariableKind::Level => Value::Bool(value != 0.0),
            PlantVariableKind::Number { least, most } if ty.is_real() => {
                Value::Real(value.clamp(least, most))
            }
            PlantVariableKind::Number { .. } => {
                // As REAL_TO_INT rounds; the limits of 64 bits are no numbers of LREAL.
                let (least, most) = ty.range();
                let whole = (value.round_ties_even() as i128).clamp(least, most);
                if ty == Elementary::Ulint { Value::Word(whole as u64) } else { Value::Int(whole as i64) }
            }
            PlantVariableKind::Other => return,
        };
        self.machine.write(place, value);
    }

    fn get(&self, variable: usize) -> f64 {
        let place = self.places.get(variable).copied().flatten();
        place.and_then(|(place, _)| self.machine.read(place).as_real()).unwrap_or(0.0)
    }

    fn cycle(&mut self, now: Time) -> Result<(), String> {
        let stop = self.machine.cycle(0, now, Span::from_nanos(MOST_OPERATIONS), &mut NoImages);
        let at = |(file, line): (u16, u32)| {
            let files = self.machine.program().files();
            format!("{}:{line}", files.get(usize::from(file)).map_or("", String::as_str))
        };
        let here = || self.machine.source_line(0).map_or_else(String::new, at);
        match stop {
            StopReason::Done => Ok(()),
            StopReason::Fault(fault) => Err(format!("{}: {}", at((fault.file, fault.line)), fault.kind)),
            StopReason::Budget { .. } => {
                Err(format!("{}: a cycle that does not end: {MOST_OPERATIONS} operations are over", here()))
            }
            StopReason::Touched { .. } | StopReason::Break | StopReason::Service { .. } => {
                Err(format!("{}: the program stopped", here()))
            }
        }
    }
}
