//! CONFIGURATION: tasks and the programs that they run.

use super::{Global, Sema};
use crate::codes::Code;
use crate::parse::ast::{self, PouKind};
use crate::program::ConfiguredTask;
use crate::types::Elementary;
use signal::Span;

impl Sema<'_> {
    /// The tasks of all configurations; `programs` gives the place of a program by that of its unit.
    pub(super) fn tasks(&mut self, programs: &[u32]) -> Vec<ConfiguredTask> {
        let unit = self.unit;
        let mut list: Vec<(ast::Key, ConfiguredTask)> = Vec::new();
        for configuration in &unit.configurations {
            for task in &configuration.tasks {
                if list.iter().any(|(key, _)| *key == task.name.key) {
                    let message = format!("the task `{}` is declared twice", self.shown(task.name));
                    self.findings.error(Code::Duplicate, task.name.at, message, "");
                    continue;
                }
                if let Some(info) = self.task(task) {
                    list.push((task.name.key, info));
                }
            }
            for declared in &configuration.programs {
                let name = declared.program;
                let place = match self.outside.get(&name.key) {
                    Some(Global::Pou(pou)) if self.pous[*pou as usize].ast.kind == PouKind::Program => {
                        let pou = *pou;
                        programs.iter().position(|program| *program == pou)
                    }
                    _ => None,
                };
                let Some(place) = place else {
                    let message = format!("there is no PROGRAM `{}`", self.shown(name));
                    self.findings.error(
                        Code::UnknownName,
                        name.at,
                        message,
                        "write one, or correct the name",
                    );
                    continue;
                };
                let Some(task) = declared.task else {
                    let message = format!("`{}` runs in no task", self.shown(declared.instance));
                    let help = "name a task, as in PROGRAM p WITH t : MAIN";
                    self.findings.error(Code::Task, declared.at, message, help);
                    continue;
                };
                match list.iter_mut().find(|(key, _)| *key == task.key) {
                    Some((_, info)) => {
                        if !info.programs.contains(&place) {
                            info.programs.push(place);
                        } else {
                            let message = format!("`{}` is in this task already", self.shown(name));
                            let help = "a PROGRAM has one instance here";
                            self.findings.error(Code::Task, declared.at, message, help);
                        }
                    }
                    None => {
                        let message = format!("there is no task `{}`", self.shown(task));
                        self.findings.error(Code::UnknownName, task.at, message, "declare it with TASK");
                    }
                }
            }
        }
        list.into_iter().map(|(_, info)| info).collect()
    }

    fn task(&mut self, task: &ast::TaskDecl) -> Option<ConfiguredTask> {
        let mut info = ConfiguredTask {
            name: self.shown(task.name).to_string(),
            interval: None,
            single: None,
            priority: None,
            programs: Vec::new(),
            file: task.name.at.file,
            span: task.name.at.start as usize..task.name.at.end as usize,
        };
        for (name, value) in &task.parameters {
            match self.names.key_text(name.key) {
                "INTERVAL" => {
                    let time = self.elementary(Elementary::Ltime);
                    let nanoseconds = self.constant_cell(value, time)?;
                    if nanoseconds <= 0 {
                        let message = "an interval is longer than 0";
                        self.findings.error(Code::Task, value.at, message, "as in INTERVAL := T#20ms");
                        return None;
                    }
                    info.interval = Some(Span::from_nanos(nanoseconds));
                }
                "PRIORITY" => {
                    let number = self.constant_number(value)?;
                    let Ok(priority) = u32::try_from(number) else {
                        let message = format!("{number} is no priority");
                        self.findings.error(Code::Task, value.at, message, "0 is the highest");
                        return None;
                    };
                    info.priority = Some(priority);
                }
                "SINGLE" => {
                    let path: String = self.text(value.at).chars().filter(|c| !c.is_whitespace()).collect();
                    if !path.chars().all(|c| c.is_alphanumeric() || "_.[],%".contains(c)) {
                        let message = "a task is released by a variable, not by an expression";
                        self.findings.error(Code::Task, value.at, message, "as in SINGLE := MAIN.go");
                        return None;
                    }
                    info.single = Some(path);
                }
                _ => {
                    let message = format!("a task has no `{}`", self.shown(*name));
                    self.findings.error(
                        Code::Task,
                        name.at,
                        message,
                        "INTERVAL, SINGLE and PRIORITY are known",
                    );
                    return None;
                }
            }
        }
        let help = "write INTERVAL := T#20ms, or SINGLE := MAIN.go for a task that a variable releases";
        let message = match (info.interval, &info.single) {
            (None, None) => format!("the task `{}` has neither INTERVAL nor SINGLE", info.name),
            (Some(_), Some(_)) => format!("the task `{}` has both INTERVAL and SINGLE", info.name),
            _ => return Some(info),
        };
        self.findings.error(Code::Task, task.name.at, message, help);
        None
    }
}
