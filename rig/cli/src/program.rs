//! `rig program`.

use crate::args::{Format, ProgramRunArgs};
use crate::exit::Exit;
use crate::output;
use profile::Profile;
use program::{Program, Storage};
use runtime::alone::{Alone, Ended};
use runtime::suite::{self, Disk};
use serde_json::{Map, Value as Json};
use signal::{Span, Value};
use std::path::PathBuf;
use std::sync::Arc;

/// Compiles files and says what is wrong.
pub fn check(files: &[PathBuf]) -> Exit {
    match compile(files) {
        Ok(program) => {
            let count = program.variables().len();
            output::print(&format!(
                "no errors: programs {}, {count} variables\n",
                program.programs().join(", ")
            ));
            Exit::Passed
        }
        Err(exit) => exit,
    }
}

fn compile(files: &[PathBuf]) -> Result<Program, Exit> {
    let mut sources = Vec::new();
    for path in files {
        match suite::load(&Disk, &path.to_string_lossy()) {
            Ok(source) => sources.push(source),
            Err(found) => {
                output::findings(&[found], &sources);
                return Err(Exit::UserFiles);
            }
        }
    }
    match runtime::application::compile(&sources, Profile::default()) {
        Ok(program) => {
            output::findings(&program.warnings, &sources);
            Ok(program)
        }
        Err(found) => {
            output::findings(&found, &sources);
            Err(Exit::UserFiles)
        }
    }
}

/// Runs an application alone and prints its variables.
pub fn run(args: &ProgramRunArgs) -> Exit {
    let program = match compile(&args.files) {
        Ok(program) => Arc::new(program),
        Err(exit) => return exit,
    };
    let spans = [("--for", &args.duration), ("--interval", &args.interval)];
    let mut read = [Span::ZERO; 2];
    for ((option, text), span) in spans.into_iter().zip(&mut read) {
        match Span::parse(text) {
            Ok(value) if value > Span::ZERO => *span = value,
            Ok(_) => {
                output::complain(&format!("{option} {text}: must be above 0"));
                return Exit::UserFiles;
            }
            Err(error) => {
                output::complain(&format!("{option} {text}: {error}"));
                return Exit::UserFiles;
            }
        }
    }
    let mut alone = Alone::new(Arc::clone(&program), Profile::default());
    for assignment in &args.set {
        let Some((name, text)) = assignment.split_once('=') else {
            output::complain(&format!("--set {assignment}: write it as VARIABLE=VALUE"));
            return Exit::UserFiles;
        };
        let value = match plans::Literal::parse(text).map(|literal| literal.value()) {
            Ok(Some(value)) => value,
            _ => {
                output::complain(&format!("--set {assignment}: `{text}` is no value of a variable"));
                return Exit::UserFiles;
            }
        };
        if alone.read(name).is_none() {
            output::complain(&format!("--set {assignment}: {}", no_variable(name, &program)));
            return Exit::UserFiles;
        }
        // A number that does not fit its variable would be cut to its last bits.
        if !set(&mut alone, &program, name, value) {
            output::complain(&format!("--set {assignment}: `{name}` cannot have this value"));
            return Exit::UserFiles;
        }
    }
    let names = match names(args, &program) {
        Ok(names) => names,
        Err(exit) => return exit,
    };
    let ended = alone.run(read[0], read[1]);
    match args.format {
        Format::Table => {
            for name in &names {
                output::print(&format!("{name} = {}\n", show(name, alone.read(name), &program)));
            }
        }
        Format::Json => {
            let mut values = Map::new();
            for name in &names {
                values.insert(name.clone(), to_json(alone.read(name)));
            }
            output::print(&format!("{}\n", Json::Object(values)));
        }
    }
    match ended {
        Ended::InTime { .. } => Exit::Passed,
        Ended::Fault { at, text } => {
            output::complain(&format!("the program failed after {at}: {text}"));
            Exit::Failed
        }
        Ended::Endless { at } => {
            output::complain(&format!("the cycle that began after {at} had not ended at the end of the run"));
            Exit::Failed
        }
    }
}

fn names(args: &ProgramRunArgs, program: &Program) -> Result<Vec<String>, Exit> {
    if args.print.is_empty() {
        let single = |variable: &&program::Variable| variable.dimensions.is_empty();
        return Ok(program.variables().iter().filter(single).map(|variable| variable.path.clone()).collect());
    }
    for name in &args.print {
        let located = program.find(name).is_some_and(|known| matches!(known.storage, Storage::Located(_)));
        if program.resolve(name).is_none() && !located {
            output::complain(&no_variable(name, program));
            return Err(Exit::UserFiles);
        }
    }
    Ok(args.print.clone())
}

fn no_variable(name: &str, program: &Program) -> String {
    let known = program.variables().iter().map(|variable| variable.path.as_str());
    let hint =
        document::suggest(name, known).map_or_else(String::new, |meant| format!(": did you mean `{meant}`?"));
    format!("there is no variable `{name}`{hint}")
}

/// Sets a variable. FALSE where the value does not fit.
fn set(alone: &mut Alone, program: &Program, name: &str, value: Value) -> bool {
    if let Some(Storage::Located(address)) = program.find(name).map(|known| &known.storage) {
        // The memory knows no types: a number fits into its bits with or without a sign.
        let bits = address.bit_len();
        let least = if bits == 1 { 0 } else { -(1 << (bits - 1)) };
        return value.as_int().is_some_and(|number| (least..1 << bits).contains(&number))
            && alone.write(name, value);
    }
    alone.write(name, value) && alone.read(name).and_then(Value::as_int) == value.as_int()
}

/// A value for a person: TIME, which is kept in nanoseconds, as a duration.
fn show(name: &str, value: Option<Value>, program: &Program) -> String {
    let time = program.find(name).is_some_and(|variable| variable.ty == program::Elementary::Time);
    match value {
        Some(Value::Int(nanos)) if time => Span::from_nanos(nanos).to_string(),
        Some(value) => value.to_string(),
        None => String::from("unknown"),
    }
}

fn to_json(value: Option<Value>) -> Json {
    match value {
        Some(Value::Bool(on)) => on.into(),
        Some(Value::Int(number)) => number.into(),
        Some(Value::Word(number)) => number.into(),
        Some(Value::Real(number)) => number.into(),
        _ => Json::Null,
    }
}
