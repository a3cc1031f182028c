//! What the names of a modelled controller mean: variables, system variables, indicators, inputs, facts of functions.

use crate::application::functions;
use crate::application::inputs;
use crate::application::module_terminals::ModuleTerminals;
use crate::application::observable::Observable;
use crate::application::taken_values::TakenValues;
use crate::application::variable_numbers::VariableNumbers;
use controller::{Config, Led, Probe, TaskConfig};
use expert::ExpertConfig;
use profile::{
    ConfiguredModule, IoChannel, MemberType, Profile, Reference, SystemStructure, SystemVariable,
    module_indices,
};
use program::{Elementary, Program, Storage};
use signal::{Address, ValueKind};
use std::sync::Arc;

/// The names, without the controller that has them: they can be looked up while it runs elsewhere.
#[derive(Clone, Debug)]
pub struct Catalogue {
    /// The case's own program, then those that steps bring.
    programs: Vec<Arc<Program>>,
    /// Numbers for variables that hold for every program; none where there is one program only, whose own numbers hold.
    names: Option<VariableNumbers>,
    profile: Profile,
    /// The indices of the expansion modules that are configured.
    modules: Vec<usize>,
    /// All modules of the configuration, in its order.
    configured: Vec<ConfiguredModule<'static>>,
    /// The places of their channels in %I and %Q.
    module_channels: Vec<Address>,
    reference: &'static Reference,
    functions: ExpertConfig,
    tasks: Vec<TaskConfig>,
}

/// The places of the channels of modules, which a configuration has that was found right.
fn module_channels(config: &Config) -> Vec<Address> {
    let places = config.reference.module_addresses(&config.modules).unwrap_or_default();
    let channels = places.iter().flat_map(|place| {
        [place.digital_inputs, place.digital_outputs, place.analogue_inputs, place.analogue_outputs]
    });
    channels.flatten().flat_map(|all| all.iter()).collect()
}

impl Catalogue {
    /// The names of a controller of this configuration with this program, if it has one.
    pub fn new(config: &Config, program: Option<Arc<Program>>, names: VariableNumbers) -> Catalogue {
        Catalogue {
            programs: program.into_iter().collect(),
            names: Some(names),
            profile: config.profile,
            modules: module_indices(&config.modules).into_iter().flatten().collect(),
            configured: config.modules.clone(),
            module_channels: module_channels(config),
            reference: config.reference,
            functions: config.expert.clone(),
            tasks: config.tasks.clone(),
        }
    }

    /// VariableNumbers of further programs mean something too, after those that it knows.
    pub fn add_programs(&mut self, programs: Vec<Arc<Program>>) {
        self.programs.extend(programs);
    }

    /// The same for a controller that never gets another program: nothing is shared with it then.
    #[must_use]
    pub fn of_one_program(&self) -> Catalogue {
        Catalogue { names: None, ..self.clone() }
    }

    /// The expansion modules on the bus with their indices in TM3_MODULE_R.
    pub fn modules(&self) -> impl Iterator<Item = (usize, &ConfiguredModule<'static>)> {
        let on_bus = self.configured.iter().filter(|one| one.module.is_on_bus());
        self.modules.iter().copied().zip(on_bus)
    }

    /// The terminals of the modules.
    pub fn module_terminals(&self) -> ModuleTerminals<'_> {
        ModuleTerminals::new(self.reference, &self.configured)
    }

    /// Whether an input or output of the controller is at this place.
    pub fn is_channel(&self, address: Address) -> bool {
        IoChannel::at(address, self.reference).is_some() || self.module_channels.contains(&address)
    }

    /// The programs.
    pub fn programs(&self) -> &[Arc<Program>] {
        &self.programs
    }

    /// The controller that is modelled.
    pub const fn reference(&self) -> &'static Reference {
        self.reference
    }

    /// The expert functions.
    pub const fn functions(&self) -> &ExpertConfig {
        &self.functions
    }

    /// The tasks, in the order of the configuration.
    pub fn tasks(&self) -> &[TaskConfig] {
        &self.tasks
    }

    /// The place of a task by its name.
    pub fn task(&self, name: &str) -> Option<usize> {
        self.tasks.iter().position(|task| task.name.eq_ignore_ascii_case(name))
    }

    /// Name of a task by its place.
    pub fn task_name(&self, task: usize) -> Option<&str> {
        self.tasks.get(task).map(|task| task.name.as_str())
    }

    /// Name of an expert function by its place.
    pub fn function_name(&self, function: usize) -> Option<&str> {
        self.functions.functions.get(function).map(|function| function.name.as_str())
    }

    /// Name of a source file of the first program by its place.
    pub fn file_name(&self, file: u16) -> Option<&str> {
        self.programs.first()?.files().get(usize::from(file)).map(String::as_str)
    }

    /// The source files of the programs, with their places in their programs.
    pub fn source_files(&self) -> impl Iterator<Item = (u16, &str)> {
        self.programs.iter().flat_map(|program| (0..).zip(program.files().iter().map(String::as_str)))
    }

    /// VariableNumbers that mean something, for suggestions.
    pub fn names(&self) -> Vec<String> {
        let variables = self.programs.iter().flat_map(|program| program.variables());
        let variables = variables.map(|variable| variable.path.clone());
        let variables = variables.chain(inputs::names(self.reference.input_count()));
        let variables = variables.chain(functions::names(&self.functions));
        let leds = Led::ALL.iter().flat_map(|led| ["", ".lit"].map(|end| format!("LED.{}{end}", led.name())));
        // Of the expansion bus only what there is.
        let is_there = |variable: &SystemVariable| match variable.field.structure() {
            SystemStructure::Tm3ModuleR => self.modules.contains(&usize::from(variable.part)),
            SystemStructure::Tm3BusW => !self.modules.is_empty(),
            _ => true,
        };
        let system = SystemVariable::all(self.profile).filter(is_there).map(|variable| variable.to_string());
        variables.chain(system).chain(leds).collect()
    }

    /// The system variable of this name, where a controller of the profile has it.
    fn system_variable(&self, name: &str) -> Option<SystemVariable> {
        SystemVariable::find(name, self.profile)
    }

    /// What a name means: a system variable, an indicator, a fact of a function, an address, or a variable's path.
    pub fn observable(&self, name: &str) -> Option<Observable> {
        if let Some(variable) = self.system_variable(name) {
            let is_bit = variable.ty(self.profile) == MemberType::Bool;
            let kind = if is_bit { ValueKind::Bool } else { ValueKind::Word };
            return Some(Observable { probe: Probe::System(variable), kind });
        }
        if let Some(found) = indicator(name, self.reference.output_count()) {
            return Some(found);
        }
        if let Some(found) = inputs::observable(name, self.reference.input_count()) {
            return Some(found);
        }
        if let Some(found) = functions::observable(name, &self.functions) {
            return Some(found);
        }
        if name.starts_with('%') {
            return Address::parse(name).ok().map(of_address);
        }
        let variable = self.programs.iter().find_map(|program| program.find(name))?;
        if !variable.dimensions.is_empty() {
            return None;
        }
        Some(match variable.storage {
            // The memory knows no types: what is located is its bits.
            Storage::Located(address) => of_address(address),
            Storage::Cell(cell) => Observable {
                probe: Probe::Variable(match &self.names {
                    Some(names) => names.number(&variable.path, variable.ty),
                    None => cell.0,
                }),
                kind: kind_of(variable.ty),
            },
        })
    }

    /// The least and the greatest value of a duration, a time of day or a date, in nanoseconds; `None` for what is no time.
    pub fn times(&self, name: &str) -> Option<(i64, i64)> {
        let of = |ty: Elementary| {
            let greatest = ty.range().1.saturating_mul(i128::from(ty.nanos()?));
            Some((0, i64::try_from(greatest).unwrap_or(i64::MAX)))
        };
        let mut variables = self.programs.iter().filter_map(|program| program.find(name));
        let first = variables.next()?.ty;
        // Of several programs the value may be of any.
        if variables.all(|other| other.ty == first) { of(first) } else { None }
    }

    /// Which values a variable, a system variable or a place takes that is written. `None` for what is none of them, and for a
    /// variable of several types in several programs.
    pub fn taken(&self, name: &str) -> Option<TakenValues> {
        if let Some(variable) = self.system_variable(name) {
            return Some(match variable.ty(self.profile) {
                MemberType::Bool => TakenValues::Level,
                ty => TakenValues::Whole(0, (1 << ty.bits()) - 1),
            });
        }
        if name.starts_with('%') {
            return Address::parse(name).ok().map(TakenValues::of_place);
        }
        let mut variables = self.programs.iter().filter_map(|program| program.find(name));
        let first = variables.next()?.ty;
        variables.all(|other| other.ty == first).then(|| TakenValues::of_type(first))
    }

    /// The least and the greatest value that a whole number can have; `None` for times, real numbers and what is not known.
    pub fn bounds(&self, name: &str) -> Option<(i128, i128)> {
        if let Some(variable) = self.system_variable(name) {
            return Some((0, (1 << variable.ty(self.profile).bits()) - 1));
        }
        if indicator(name, self.reference.output_count()).is_some()
            || inputs::observable(name, self.reference.input_count()).is_some()
            || functions::observable(name, &self.functions).is_some()
        {
            return None;
        }
        // Of several programs the value may be of any.
        let mut variables = self.programs.iter().filter_map(|program| program.find(name));
        let first = variables.next()?;
        if variables.any(|other| other.ty != first.ty) {
            return None;
        }
        match first.storage {
            Storage::Located(address) => Some((0, (1i128 << address.size().bits()) - 1)),
            Storage::Cell(_) => match first.ty {
                Elementary::Bool
                | Elementary::Sint
                | Elementary::Usint
                | Elementary::Int
                | Elementary::Uint
                | Elementary::Dint
                | Elementary::Udint
                | Elementary::Lint
                | Elementary::Ulint
                | Elementary::Byte
                | Elementary::Word
                | Elementary::Dword
                | Elementary::Lword => Some(first.ty.range()),
                _ => None,
            },
        }
    }
}

/// `LED.RUN`, `LED.RUN.lit` or `OUTPUT.Q0`, in any case of letters.
fn indicator(name: &str, outputs: usize) -> Option<Observable> {
    let upper = name.to_ascii_uppercase();
    if let Some(led) = upper.strip_prefix("LED.") {
        let (led, lit) = match led.strip_suffix(".LIT") {
            Some(led) => (Led::find(led)?, true),
            None => (Led::find(led)?, false),
        };
        return Some(match lit {
            true => Observable { probe: Probe::LedLit(led), kind: ValueKind::Bool },
            false => Observable { probe: Probe::Led(led), kind: ValueKind::State },
        });
    }
    let output = upper.strip_prefix("OUTPUT.Q")?.parse().ok().filter(|output| *output < outputs)?;
    Some(Observable { probe: Probe::Output(output), kind: ValueKind::State })
}

fn of_address(address: Address) -> Observable {
    let kind = if address.bit_len() == 1 { ValueKind::Bool } else { ValueKind::Word };
    Observable { probe: Probe::Address(address), kind }
}

fn kind_of(ty: Elementary) -> ValueKind {
    match ty {
        Elementary::Bool => ValueKind::Bool,
        Elementary::Real | Elementary::Lreal => ValueKind::Real,
        Elementary::Byte | Elementary::Word | Elementary::Dword | Elementary::Lword | Elementary::Ulint => {
            ValueKind::Word
        }
        _ => ValueKind::Int,
    }
}
