//! `rig program run`.

use super::args::ProgramRunArgs;
use super::{compile, duration, ended};
use crate::exit::ExitStatus;
use crate::output::OutputFormat;
use crate::output::{self, refuse};
use profile::Profile;
use program::{Elementary, Program, SetError, ShownVariable};
use reports::text;
use runtime::application::coverage::by_file;
use runtime::instrument::standalone::{StandaloneRun, tasks};
use serde_json::{Map, Value as Json, json};
use signal::Value;
use std::sync::Arc;

/// The most values that are printed where none are named.
const MOST_VALUES: usize = 10_000;

/// Runs an application alone and prints its variables.
pub fn run(args: &ProgramRunArgs) -> ExitStatus {
    match prepare(args) {
        Ok((alone, program)) => finish(args, alone, &program),
        Err(exit) => exit,
    }
}

/// The application before its first cycle.
fn prepare(args: &ProgramRunArgs) -> Result<(StandaloneRun, Arc<Program>), ExitStatus> {
    let interval = duration("--interval", &args.interval)?;
    duration("--for", &args.duration)?;
    let (program, _) = compile(&args.files)?;
    let tasks = tasks(&program, interval);
    let mut alone = StandaloneRun::new(Arc::clone(&program), tasks, Profile::default()).map_err(|error| {
        output::error(&error.to_string());
        ExitStatus::UserFiles
    })?;
    for assignment in &args.set {
        set(&mut alone, &program, assignment)?;
    }
    for name in names(&args.print) {
        if alone.show(name).is_none() {
            return Err(no_variable("--print", name, &program));
        }
    }
    if args.coverage {
        alone.cover();
    }
    Ok((alone, program))
}

/// Runs it and prints what came of it.
fn finish(args: &ProgramRunArgs, mut alone: StandaloneRun, program: &Program) -> ExitStatus {
    let ran = match duration("--for", &args.duration) {
        Ok(time) => alone.run(time),
        Err(exit) => return exit,
    };
    let values = match args.print.is_empty() {
        true => every(&mut alone, program),
        false => names(&args.print)
            .into_iter()
            .filter_map(|name| Some((name.to_owned(), alone.show(name)?)))
            .collect(),
    };
    let coverage = args.coverage.then(|| {
        let files = by_file(program, &alone.coverage());
        files.iter().map(runtime::application::coverage::CoveredFile::record).collect::<Vec<_>>()
    });
    match args.format {
        OutputFormat::Table => {
            let mut lines = Vec::new();
            values.iter().for_each(|(path, shown)| flat(path, shown, &mut lines));
            lines.iter().for_each(|(path, shown)| output::print(&format!("{path} = {shown}\n")));
            if let Some(files) = &coverage {
                output::print(&format!("\n{}", text::coverage(files)));
            }
        }
        OutputFormat::Json => {
            let values: Map<String, Json> =
                values.iter().map(|(path, shown)| (path.clone(), to_json(shown))).collect();
            let printed = match coverage {
                None => Json::Object(values),
                Some(files) => json!({ "variables": values, "coverage": files }),
            };
            output::print(&format!("{printed}\n"));
        }
    }
    ended(&ran)
}

/// Sets a variable as `VARIABLE=VALUE` says.
fn set(alone: &mut StandaloneRun, program: &Program, assignment: &str) -> Result<(), ExitStatus> {
    let Some((name, text)) = assignment.split_once('=') else {
        let help = "write it as VARIABLE=VALUE";
        return Err(refuse("R0503", format!("--set {assignment}: no assignment"), help));
    };
    let name = name.trim_end_matches([' ', ':']);
    alone.set(name, text).map_err(|error| match error {
        SetError::NoSuchVariable => no_variable("--set", name, program),
        error => {
            let message = format!("--set {assignment}: `{name}` cannot have the value `{}`", text.trim());
            refuse("R0502", message, &error.to_string())
        }
    })
}

fn no_variable(option: &str, name: &str, program: &Program) -> ExitStatus {
    let known = program.variables().iter().map(|variable| variable.path.as_str());
    let known = known.chain(program.roots().iter().map(|root| root.path.as_str()));
    let help = document::suggest(name, known);
    let help = help.map_or_else(String::new, |meant| format!("did you mean `{meant}`?"));
    refuse("R0501", format!("{option}: there is no variable `{name}`"), &help)
}

/// The names in lists with commas; those between the indices of an element belong to it.
fn names(lists: &[String]) -> Vec<&str> {
    let mut names = Vec::new();
    for list in lists {
        let (mut depth, mut from) = (0usize, 0);
        for (at, c) in list.char_indices() {
            match c {
                '[' => depth += 1,
                ']' => depth = depth.saturating_sub(1),
                ',' if depth == 0 => {
                    names.extend(list.get(from..at));
                    from = at + 1;
                }
                _ => {}
            }
        }
        names.extend(list.get(from..));
    }
    names.into_iter().map(str::trim).collect()
}

/// All variables, those of structures, blocks and programs one by one.
fn every(alone: &mut StandaloneRun, program: &Program) -> Vec<(String, ShownVariable)> {
    let mut values = Vec::new();
    for root in program.roots() {
        if values.len() > MOST_VALUES {
            break;
        }
        if let Some(shown) = alone.show(&root.path) {
            flat(&root.path, &shown, &mut values);
        }
    }
    if values.len() > MOST_VALUES {
        values.truncate(MOST_VALUES);
        output::note(&format!("only {MOST_VALUES} values are shown: name those that you want with --print"));
    }
    values
}

/// Members, and elements that have members, each under its own path.
fn flat(path: &str, shown: &ShownVariable, values: &mut Vec<(String, ShownVariable)>) {
    match shown {
        ShownVariable::Members(members) => {
            members.iter().for_each(|(name, member)| flat(&format!("{path}.{name}"), member, values));
        }
        ShownVariable::Array(elements, more) if has_members(shown) => {
            elements.iter().for_each(|(index, element)| flat(&format!("{path}{index}"), element, values));
            if *more > 0 {
                output::note(&format!("{path} has {more} more elements: name them with --print"));
            }
        }
        _ => values.push((path.to_owned(), shown.clone())),
    }
}

fn has_members(shown: &ShownVariable) -> bool {
    match shown {
        ShownVariable::Members(_) => true,
        ShownVariable::Array(elements, _) => {
            elements.first().is_some_and(|(_, element)| has_members(element))
        }
        _ => false,
    }
}

/// A value for a program: numbers as numbers, durations in nanoseconds, dates and texts as texts, enumerations by
/// their names.
fn to_json(shown: &ShownVariable) -> Json {
    match shown {
        ShownVariable::Value(_, ty) if ty.is_date() || ty.is_char() || is_time_of_day(*ty) => {
            shown.to_string().trim_matches(['\'', '"']).into()
        }
        ShownVariable::Value(value, _) | ShownVariable::Named(None, value) => number(*value),
        ShownVariable::Named(Some(name), _) => name.as_str().into(),
        ShownVariable::Text(text) => text.as_str().into(),
        ShownVariable::Address(address) => (*address).into(),
        ShownVariable::Array(elements, _) => elements.iter().map(|(_, element)| to_json(element)).collect(),
        ShownVariable::Members(members) => {
            let members = members.iter().map(|(name, member)| (name.clone(), to_json(member)));
            Json::Object(members.collect())
        }
    }
}

const fn is_time_of_day(ty: Elementary) -> bool {
    matches!(ty, Elementary::Tod | Elementary::Ltod)
}

fn number(value: Value) -> Json {
    match value {
        Value::Bool(on) => on.into(),
        Value::Int(number) => number.into(),
        Value::Word(number) => number.into(),
        // JSON has no numbers for what is none.
        Value::Real(number) | Value::Measured(number, _) if !number.is_finite() => number.to_string().into(),
        Value::Real(number) | Value::Measured(number, _) => number.into(),
        Value::HighZ | Value::Unknown => Json::Null,
    }
}

#[cfg(test)]
mod tests {
    use super::names;

    #[test]
    fn commas_of_indices_do_not_separate() {
        let lists = [String::from("a, b[1,2].c,d"), String::from("e")];
        assert_eq!(names(&lists), ["a", "b[1,2].c", "d", "e"]);
    }
}
