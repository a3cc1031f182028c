//! Programs that plants run, as a board sees them. What compiles and runs them is no part of this crate: whoever has a board
//! file read brings it along.

use std::fmt;
use std::sync::Arc;

use document::Diagnostic;
use signal::Time;

/// What a variable of a program holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlantVariableKind {
    /// TRUE or FALSE, as 1 or 0: BOOL.
    Level,
    /// A number within these limits.
    Number {
        /// The least.
        least: f64,
        /// The greatest.
        most: f64,
    },
    /// What no channel carries.
    Other,
}

/// A variable by which a program is connected.
#[derive(Clone, Debug, PartialEq)]
pub struct PlantVariable {
    /// As declared; capitals make no difference.
    pub name: String,
    /// VAR_INPUT, and not VAR_OUTPUT.
    pub is_input: bool,
    /// What it holds.
    pub kind: PlantVariableKind,
    /// What it is at the start.
    pub initial: f64,
}

/// A program that a plant can run, compiled. Plants share it.
pub trait PlantProgram: Send + Sync + fmt::Debug {
    /// Its inputs and outputs, in the order that [`PlantMachine`] counts.
    fn variables(&self) -> &[PlantVariable];

    /// A machine of its own with the variables at their initial values.
    fn machine(&self) -> Box<dyn PlantMachine>;
}

/// A program with its memory. Nothing is allocated but by its making and by a fault.
pub trait PlantMachine: Send + fmt::Debug {
    /// Every variable back to its initial value.
    fn reset(&mut self);

    /// Sets a variable: TRUE for what is not 0, and the nearest number that its type holds.
    fn set(&mut self, variable: usize, value: f64);

    /// The value of a variable.
    fn get(&self, variable: usize) -> f64;

    /// Runs the program once; all of it happens at `now`.
    ///
    /// # Errors
    /// Why it did not come to its end, with file and line. What it had done by then stays.
    fn cycle(&mut self, now: Time) -> Result<(), String>;
}

/// Why a plant has no program.
#[derive(Clone, Debug, PartialEq)]
pub enum PlantProgramError {
    /// It cannot be read, or does not compile. Findings without a place are about the name of the file.
    Findings(Vec<Diagnostic>),
    /// It is a program, and not one that a plant can run: why, and what to do.
    Unsuited(String, String),
}

/// Where the programs of plants come from.
pub trait PlantPrograms {
    /// The program of these files, named as in the board file.
    ///
    /// # Errors
    /// [`PlantProgramError`].
    fn load(&self, files: &[&str]) -> Result<Arc<dyn PlantProgram>, PlantProgramError>;
}

/// How a plant came to its end before its board did.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct PlantFault {
    /// The name of the plant.
    pub plant: String,
    /// When.
    pub at: Time,
    /// Why, with the file and line of its program.
    pub why: String,
}
