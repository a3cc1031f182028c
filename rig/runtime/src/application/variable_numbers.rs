//! The variables that a case looks at: their numbers hold for every application that its controller loads.
//!
//! An application numbers its variables by where they lie, and another application has them elsewhere. A number of
//! this table is a place in a list of paths, which each application looks up when it is loaded.

use program::{Elementary, Program, VarRef};
use std::sync::{Arc, Mutex, PoisonError};

/// The bit that a number of this table has, and no number of an application.
const NAMED: u32 = 1 << 31;

/// Paths with the type that the case takes them for.
#[derive(Clone, Debug, Default)]
pub struct VariableNumbers(Arc<Mutex<Vec<(String, Elementary)>>>);

impl VariableNumbers {
    /// The number of a path: a new one where it is not known.
    pub fn number(&self, path: &str, ty: Elementary) -> u32 {
        let mut names = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let known = names.iter().position(|(known, _)| known.eq_ignore_ascii_case(path));
        let place = known.unwrap_or_else(|| {
            names.push((path.to_owned(), ty));
            names.len() - 1
        });
        NAMED | place as u32
    }

    /// Where a program has the variables of the table: `None` for one that it does not have, or has with another
    /// type or in the controller's memory.
    pub fn resolve(&self, program: &Program) -> ResolvedVariables {
        let names = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let find = |(path, ty): &(String, Elementary)| {
            let same = program.find(path)?.ty == *ty;
            program.resolve(path).filter(|_| same)
        };
        ResolvedVariables(names.iter().map(find).collect())
    }
}

/// The table for one program.
#[derive(Clone, Debug, Default)]
pub struct ResolvedVariables(Vec<Option<VarRef>>);

impl ResolvedVariables {
    /// The variable behind a number of the table or of the application itself.
    pub fn of(&self, number: u32) -> Option<VarRef> {
        if number & NAMED == 0 {
            return Some(VarRef(number));
        }
        self.0.get((number & !NAMED) as usize).copied().flatten()
    }

    /// Whether the number came into the table after this resolution.
    pub fn lacks(&self, number: u32) -> bool {
        number & NAMED != 0 && (number & !NAMED) as usize >= self.0.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::application::compile;
    use document::SourceFile;
    use profile::Profile;

    #[test]
    fn a_number_holds_for_every_program() {
        let program = |text: &str| compile(&[SourceFile::new("a.st", text)], Profile::default()).unwrap();
        let first = program("PROGRAM MAIN VAR a : INT; b : DINT; c : INT; END_VAR END_PROGRAM");
        let other =
            program("PROGRAM MAIN VAR z : LINT; a : INT; b : REAL; c AT %MW0 : INT; END_VAR END_PROGRAM");
        let names = VariableNumbers::default();
        let numbers = ["MAIN.a", "MAIN.b", "MAIN.c"].map(|path| {
            let variable = first.find(path).unwrap();
            names.number(path, variable.ty)
        });
        assert_eq!(names.number("main.A", Elementary::Int), numbers[0]);
        let (here, there) = (names.resolve(&first), names.resolve(&other));
        assert_eq!(
            numbers.map(|n| here.of(n)),
            ["MAIN.a", "MAIN.b", "MAIN.c"].map(|path| first.resolve(path))
        );
        assert_eq!(numbers.map(|n| there.of(n)), [other.resolve("MAIN.a"), None, None]);
        assert_eq!(here.of(64), Some(VarRef(64)));
        let late = names.number("MAIN.late", Elementary::Int);
        assert!(here.lacks(late) && !here.lacks(numbers[2]) && !here.lacks(64));
        assert_eq!(here.of(late), None);
    }
}
