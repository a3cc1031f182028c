//! The tasks of a controller: those that exist by themselves, those that the sources configure (CONFIGURATION), and
//! what a plan says of either.

use crate::application::bundle::TaskPrograms;
use crate::codes;
use controller::{
    BusCycle, Config, ConfigError, ExternalEventSource, TaskConfig, TaskKind, TaskWatchdog, Warning,
};
use document::{Diagnostic, SourceFile};
use plans::plan::{PlanSettings, TaskSettings, TaskType};
use profile::Profile;
use program::{ConfiguredTask, Elementary, Program, Storage};
use signal::{Address, Size, Span};

/// Where a task of the configuration was written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum TaskOrigin {
    /// Nowhere: MAST, or in the plan.
    Plan,
    /// In the sources: place in [`Program::tasks`].
    Sources(usize),
}

/// The tasks of a case.
#[derive(Debug)]
pub struct Tasks {
    /// As the controller takes them.
    pub configured: Vec<TaskConfig>,
    /// What each runs, in the same order.
    pub programs: Vec<TaskPrograms>,
    from: Vec<TaskOrigin>,
}

impl Tasks {
    /// The tasks of a program with what a plan says of them: MAST, then those of the sources, then further ones of
    /// the plan. What the plan says goes before what the sources say, key by key; a PROGRAM that a list of the plan
    /// names leaves the lists of the sources, and a task of the sources that has none left is not made.
    ///
    /// # Errors
    /// A finding in the sources or the plan for a task that these controllers do not have.
    pub fn new(
        program: Option<&Program>,
        settings: &PlanSettings,
        profile: Profile,
        plan: &SourceFile,
    ) -> Result<Tasks, Vec<Diagnostic>> {
        let mut tasks = Tasks {
            configured: vec![TaskConfig::mast()],
            programs: Vec::new(),
            from: vec![TaskOrigin::Plan],
        };
        tasks.programs.push(TaskPrograms { task: tasks.configured[0].name.clone(), programs: None });
        let known: &[ConfiguredTask] = program.map_or(&[], Program::tasks);
        for (place, task) in known.iter().enumerate() {
            let own = find(settings, &task.name);
            let programs = program.map_or(&[][..], Program::programs);
            let left = task.programs.iter().filter_map(|program| programs.get(*program));
            let left: Vec<String> = left.filter(|name| !named(settings, name)).cloned().collect();
            let is_mast = task.name.eq_ignore_ascii_case("MAST");
            if left.is_empty() && !is_mast && own.is_none_or(|own| own.programs.is_none()) {
                continue;
            }
            let kind = match (task.interval, &task.single) {
                (_, Some(trigger)) => {
                    let trigger = find_trigger(program, trigger).map_err(|message| {
                        let help = "SINGLE names a Boolean variable, as in `TASK t (SINGLE := MAIN.go, PRIORITY := 5)`";
                        vec![refused(program, task, &message).help(help)]
                    })?;
                    TaskKind::Event { trigger }
                }
                (Some(interval), None) => TaskKind::Cyclic { interval },
                (None, None) => TaskConfig::mast().kind,
            };
            let priority = task.priority.map_or(Ok(profile::DEFAULT_PRIORITY), u8::try_from);
            let Ok(priority) = own.and_then(|own| own.priority).map_or(priority, Ok) else {
                let lowest = profile::PRIORITIES.end();
                let message = format!("the task `{}` has a priority that no controller has", task.name);
                return Err(vec![refused(program, task, &message).help(format!("0 to {lowest}"))]);
            };
            let at = tasks.place(&task.name, TaskOrigin::Sources(place));
            if let Some(configured) = tasks.configured.get_mut(at) {
                configured.kind = kind;
                configured.priority = priority;
            }
            if let Some(task) = tasks.programs.get_mut(at) {
                task.programs = (!left.is_empty()).then_some(left);
            }
        }
        for said in &settings.tasks {
            let at = tasks.place(&said.name, TaskOrigin::Plan);
            if let Some(configured) = tasks.configured.get_mut(at) {
                overlay(configured, said);
                if let Some(kind) = said.kind {
                    configured.kind =
                        kind_of(kind, said, configured, program, profile).map_err(|message| {
                            vec![Diagnostic::error(codes::CONFIGURATION_REFUSED, message).at(
                                &plan.name,
                                0..0,
                                "",
                            )]
                        })?;
                }
            }
            if let (Some(task), Some(list)) = (tasks.programs.get_mut(at), &said.programs) {
                task.programs = Some(list.clone());
            }
        }
        Ok(tasks)
    }

    /// The place of a task by its name; a new one is made where there is none.
    fn place(&mut self, name: &str, from: TaskOrigin) -> usize {
        let known = self.configured.iter().position(|task| task.name.eq_ignore_ascii_case(name));
        let place = known.unwrap_or_else(|| {
            self.configured.push(TaskConfig { name: name.to_owned(), ..TaskConfig::mast() });
            self.programs.push(TaskPrograms { task: name.to_owned(), programs: None });
            self.from.push(from);
            self.configured.len() - 1
        });
        if let (TaskOrigin::Sources(_), Some(known)) = (from, self.from.get_mut(place)) {
            *known = from;
        }
        place
    }

    /// What the controller refuses of a configuration with these tasks, at the task of the sources that it is about,
    /// else in the plan.
    pub fn refusal(&self, error: &ConfigError, program: Option<&Program>, plan: &SourceFile) -> Diagnostic {
        let places: &[usize] = match error {
            ConfigError::SameName { tasks: (first, second) }
            | ConfigError::SamePriority { tasks: (first, second), .. } => &[*second, *first],
            ConfigError::Priority { task, .. }
            | ConfigError::Interval { task, .. }
            | ConfigError::WatchdogTime { task } => &[*task],
            ConfigError::Event { task, .. } | ConfigError::NoEvent { task, .. } => &[*task],
            ConfigError::TooManyTasks { most, .. } => &[*most],
            _ => &[],
        };
        let written = places.iter().find_map(|place| match self.from.get(*place)? {
            TaskOrigin::Sources(task) => program?.tasks().get(*task),
            TaskOrigin::Plan => None,
        });
        let message = self.message(error);
        match written {
            Some(task) => refused(program, task, &message),
            None => Diagnostic::error(codes::CONFIGURATION_REFUSED, message).at(&plan.name, 0..0, ""),
        }
    }

    /// The error with the names of the tasks.
    fn message(&self, error: &ConfigError) -> String {
        let name = |place: &usize| self.configured.get(*place).map_or("?", |task| task.name.as_str());
        match error {
            ConfigError::SamePriority { tasks: (first, second), priority } => format!(
                "the tasks `{}` and `{}` both have priority {priority}: give each its own",
                name(first),
                name(second)
            ),
            ConfigError::Priority { task, priority } => {
                let lowest = profile::PRIORITIES.end();
                format!("the task `{}` has priority {priority}: the lowest is {lowest}", name(task))
            }
            ConfigError::Interval { task, interval } => format!(
                "the task `{}` has an interval of {interval}: the least is {}",
                name(task),
                profile::MINIMUM_CYCLE
            ),
            ConfigError::WatchdogTime { task } => {
                format!("the watchdog time of the task `{}` is not above 0", name(task))
            }
            ConfigError::Event { task, event: source } => {
                format!(
                    "the task `{}` is started by {source}, an event that the controller does not have",
                    name(task)
                )
            }
            ConfigError::NoEvent { task, event: source @ ExternalEventSource::CanSync } => format!(
                "the task `{}` is started by {source}, which nothing raises: the CANopen manager has to produce or consume \
                 SYNC, `can-sync = true`",
                name(task)
            ),
            ConfigError::NoEvent { task, event: source } => format!(
                "the task `{}` is started by {source}, which raises no event: give the input an `event`",
                name(task)
            ),
            other => other.to_string(),
        }
    }

    /// Puts the tasks into a configuration.
    ///
    /// # Errors
    /// What the controller refuses of it.
    pub fn configure(
        &self,
        config: &mut Config,
        settings: &PlanSettings,
        program: Option<&Program>,
        plan: &SourceFile,
    ) -> Result<(), Vec<Diagnostic>> {
        config.tasks.clone_from(&self.configured);
        if let Some(name) = &settings.bus_cycle_task {
            config.bus_cycle_task = match config.task(name) {
                Some(place) => BusCycle::Task(place),
                None if name == "<unspecified>" => BusCycle::Slowest,
                None => {
                    let message = format!("there is no task `{name}` to be the bus cycle task");
                    return Err(vec![Diagnostic::error(codes::CONFIGURATION_REFUSED, message).at(
                        &plan.name,
                        0..0,
                        "",
                    )]);
                }
            };
        }
        config.check().map_err(|error| vec![self.refusal(&error, program, plan)])
    }
}

/// Whether a controller of this profile takes the tasks of a program as the sources configure them.
///
/// # Errors
/// What it refuses.
pub fn check(program: &Program, profile: Profile) -> Result<(), Vec<Diagnostic>> {
    let (settings, plan) = (PlanSettings::default(), SourceFile::new("", ""));
    let tasks = Tasks::new(Some(program), &settings, profile, &plan)?;
    tasks.configure(&mut Config::new(profile), &settings, Some(program), &plan)
}

/// What a plan says of a task.
fn find<'a>(settings: &'a PlanSettings, name: &str) -> Option<&'a TaskSettings> {
    settings.tasks.iter().find(|task| task.name.eq_ignore_ascii_case(name))
}

/// Whether a list of the plan names a PROGRAM.
fn named(settings: &PlanSettings, program: &str) -> bool {
    let mut lists = settings.tasks.iter().filter_map(|task| task.programs.as_ref());
    lists.any(|list| list.iter().any(|name| name.eq_ignore_ascii_case(program)))
}

/// Puts what a plan says of a task over what is known of it.
fn overlay(task: &mut TaskConfig, said: &TaskSettings) {
    task.priority = said.priority.unwrap_or(task.priority);
    let watchdog = task.watchdog.unwrap_or(TaskWatchdog { time: Span::from_millis(100), sensitivity: 1 });
    task.watchdog = said.enabled.unwrap_or(true).then(|| TaskWatchdog {
        time: said.watchdog.unwrap_or(watchdog.time),
        sensitivity: said.sensitivity.unwrap_or(watchdog.sensitivity),
    });
}

/// The kind of a task of which a plan says more than was known. What it leaves out stays as it was.
fn kind_of(
    kind: TaskType,
    said: &TaskSettings,
    known: &TaskConfig,
    program: Option<&Program>,
    profile: Profile,
) -> Result<TaskKind, String> {
    Ok(match (kind, &known.kind) {
        (TaskType::Cyclic, _) => {
            let interval = said.interval.or(known.interval()).or(TaskConfig::mast().interval());
            TaskKind::Cyclic { interval: interval.unwrap_or(Span::ZERO) }
        }
        (TaskType::Freewheeling, _) => TaskKind::Freewheeling,
        (TaskType::Event, known) => match (&said.trigger, known) {
            (Some(trigger), _) => TaskKind::Event { trigger: find_trigger(program, trigger)? },
            (None, TaskKind::Event { .. }) => known.clone(),
            _ => return Err(format!("the event task `{}` has no `trigger`", said.name)),
        },
        (TaskType::ExternalEvent, _) => {
            let Some(event) = &said.event else {
                return Err(format!("the external event task `{}` has no `event`", said.name));
            };
            let source = ExternalEventSource::find(event, profile);
            let source = source.ok_or_else(|| format!("{} has no event `{event}`", profile.name()))?;
            TaskKind::ExternalEvent { source }
        }
    })
}

/// The variable that starts an event task, as the controller looks it up: a path, or the address of a located one.
fn find_trigger(program: Option<&Program>, trigger: &str) -> Result<String, String> {
    if trigger.starts_with('%') {
        let address = Address::parse(trigger).ok().filter(|address| address.size() == Size::Bit);
        return address
            .map(|address| address.to_string())
            .ok_or(format!("`{trigger}` is no bit of the memory"));
    }
    let Some(program) = program else { return Ok(trigger.to_owned()) };
    match program.find(trigger) {
        Some(variable) if variable.ty == Elementary::Bool && variable.dimensions.is_empty() => {
            Ok(match variable.storage {
                Storage::Located(address) => address.to_string(),
                Storage::Cell(_) => variable.path,
            })
        }
        Some(_) => {
            Err(format!("`{trigger}` is no Boolean variable: it starts an event task when it becomes TRUE"))
        }
        None => Err(format!("there is no variable `{trigger}` to start an event task")),
    }
}

/// What the controller accepts with a warning (controller:PRIO-02, controller:TASK-23, io:EIO-17), of a configuration and
/// of its application.
pub fn warnings(config: &Config, application: Option<Warning>, plan: &SourceFile) -> Vec<Diagnostic> {
    let name = |place: usize| config.tasks.get(place).map_or("?", |task| task.name.as_str());
    let show = |warning: &Warning| {
        Diagnostic::warning(codes::CONFIGURATION_WARNING, warning.show(name))
            .at(&plan.name, 0..0, "")
            .help("it also stands in the log")
    };
    config.warnings().iter().chain(&application).map(show).collect()
}

/// A task of the sources that these controllers do not take.
fn refused(program: Option<&Program>, task: &ConfiguredTask, message: &str) -> Diagnostic {
    let file = program.and_then(|program| program.files().get(usize::from(task.file)));
    let file = file.map_or("", String::as_str);
    Diagnostic::error(codes::TASK_REFUSED, message).at(file, task.span.clone(), "")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::application::compile;

    const PROGRAMS: &str = "PROGRAM a END_PROGRAM PROGRAM b END_PROGRAM PROGRAM c END_PROGRAM\n";

    fn program(configuration: &str) -> Program {
        let text = format!("{PROGRAMS}CONFIGURATION x {configuration} END_CONFIGURATION");
        compile(&[SourceFile::new("x.st", text)], Profile::default()).unwrap()
    }

    fn task(name: &str) -> TaskSettings {
        TaskSettings { name: name.to_owned(), ..TaskSettings::default() }
    }

    /// Name, interval in ms, priority and programs of each task.
    fn tasks(program: &Program, said: Vec<TaskSettings>) -> Vec<(String, i64, u8, String)> {
        let settings = PlanSettings { tasks: said, ..PlanSettings::default() };
        let plan = SourceFile::new("plan.toml", "");
        let tasks = Tasks::new(Some(program), &settings, Profile::default(), &plan).unwrap();
        let rows = tasks.configured.iter().zip(&tasks.programs);
        let row = |(task, runs): (&TaskConfig, &TaskPrograms)| {
            assert_eq!(task.name, runs.task);
            let programs = runs.named().join(" ");
            (runs.task.clone(), task.interval().unwrap().as_nanos() / 1_000_000, task.priority, programs)
        };
        rows.map(row).collect()
    }

    fn row(name: &str, interval: i64, priority: u8, programs: &str) -> (String, i64, u8, String) {
        (name.to_owned(), interval, priority, programs.to_owned())
    }

    #[test]
    fn without_any_there_is_mast() {
        let none = compile(&[SourceFile::new("x.st", PROGRAMS)], Profile::default()).unwrap();
        assert_eq!(tasks(&none, Vec::new()), [row("MAST", 20, 15, "")]);
        assert_eq!(
            Tasks::new(None, &PlanSettings::default(), Profile::default(), &SourceFile::new("", ""))
                .unwrap()
                .configured,
            [TaskConfig::mast()]
        );
    }

    #[test]
    fn the_plan_goes_before_the_program_key_by_key() {
        let program = program(
            "TASK t (INTERVAL := T#5ms, PRIORITY := 2); TASK mast (INTERVAL := T#50ms); \
             PROGRAM p WITH t : a; PROGRAM q WITH t : b;",
        );
        let own = [row("MAST", 50, 15, ""), row("t", 5, 2, "a b")];
        assert_eq!(tasks(&program, Vec::new()), own);
        let kind = Some(TaskType::Cyclic);
        let interval = TaskSettings { kind, interval: Some(Span::from_millis(7)), ..task("T") };
        assert_eq!(tasks(&program, vec![interval]), [row("MAST", 50, 15, ""), row("t", 7, 2, "a b")]);
        let priority = TaskSettings { priority: Some(3), ..task("mast") };
        assert_eq!(tasks(&program, vec![priority]), [row("MAST", 50, 3, ""), row("t", 5, 2, "a b")]);
        // A PROGRAM that the plan gives away leaves its task, and an empty task is not made.
        let one = TaskSettings { programs: Some(vec!["A".into()]), priority: Some(9), ..task("u") };
        let moved = [row("MAST", 50, 15, ""), row("t", 5, 2, "b"), row("u", 20, 9, "A")];
        assert_eq!(tasks(&program, vec![one]), moved);
        let both = TaskSettings { programs: Some(vec!["b".into(), "a".into()]), ..task("MAST") };
        assert_eq!(tasks(&program, vec![both]), [row("MAST", 50, 15, "b a")]);
    }

    #[test]
    fn what_the_controller_refuses_is_told_at_the_task() {
        for (text, said, code, place) in [
            ("TASK t (INTERVAL := T#5ms); PROGRAM p WITH t : a;", None, "R0116", Some("t (")),
            ("TASK t (INTERVAL := T#5ms, PRIORITY := 99); PROGRAM p WITH t : a;", None, "R0116", Some("t (")),
            (
                "TASK t (INTERVAL := T#5ms, PRIORITY := 999); PROGRAM p WITH t : a;",
                None,
                "R0116",
                Some("t ("),
            ),
            (
                "TASK t (INTERVAL := LTIME#999ns, PRIORITY := 3); PROGRAM p WITH t : a;",
                None,
                "R0116",
                Some("t ("),
            ),
            (
                "TASK t (INTERVAL := T#5ms, PRIORITY := 4); PROGRAM p WITH t : a;",
                Some(4),
                "R0116",
                Some("t ("),
            ),
        ] {
            let program = program(text);
            let mast = TaskSettings { priority: said, ..task("MAST") };
            let settings = PlanSettings { tasks: vec![mast], ..PlanSettings::default() };
            let mut config = Config::new(Profile::default());
            let plan = SourceFile::new("plan.toml", "");
            let tasks = Tasks::new(Some(&program), &settings, Profile::default(), &plan);
            let found = tasks
                .and_then(|tasks| tasks.configure(&mut config, &settings, Some(&program), &plan))
                .unwrap_err();
            assert_eq!((found.len(), found[0].code), (1, code), "{text}");
            let label = &found[0].labels[0];
            let source = format!("{PROGRAMS}CONFIGURATION x {text} END_CONFIGURATION");
            assert_eq!(source.get(label.span.start..label.span.start + 3), place, "{text}");
        }
        let twice = vec![TaskSettings { priority: Some(15), ..task("t") }];
        let settings = PlanSettings { tasks: twice, ..PlanSettings::default() };
        let plan = SourceFile::new("plan.toml", "");
        let tasks = Tasks::new(None, &settings, Profile::default(), &plan).unwrap();
        let found =
            tasks.configure(&mut Config::new(Profile::default()), &settings, None, &plan).unwrap_err();
        assert_eq!((found[0].code, found[0].labels[0].file.as_str()), ("R0113", "plan.toml"));
        assert!(found[0].message.contains("`MAST` and `t`"), "{}", found[0].message);
    }
}
