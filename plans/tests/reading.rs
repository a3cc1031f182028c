//! Plans that must read: those of the plan language's description and those of the library.

use std::path::{Path, PathBuf};

use document::{SourceFile, render};
use record::GuardBand;
use scanrig_plans as plans;
use scanrig_plans::steps::Stimulus;
use scanrig_plans::{Anchor, AnchorBase, StepTime};
use signal::Span;

fn source(path: &Path) -> SourceFile {
    let text = std::fs::read_to_string(path).unwrap();
    SourceFile::new(path.file_name().unwrap().to_string_lossy(), text)
}

fn read(path: &str) -> plans::Plan {
    let file = source(&Path::new(env!("CARGO_MANIFEST_DIR")).join(path));
    plans::read(&file, &[], 1).unwrap_or_else(|found| panic!("{}", render(&found, &[file], false)))
}

fn plans_below(folder: &Path, found: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|one| one.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            plans_below(&path, found);
        } else if path.extension().is_some_and(|ext| ext == "toml") {
            found.push(path);
        }
    }
}

#[test]
fn the_library_reads() {
    let mut paths = Vec::new();
    plans_below(&Path::new(env!("CARGO_MANIFEST_DIR")).join("library"), &mut paths);
    assert!(!paths.is_empty());
    let mut wrong = String::new();
    let is_plan = |path: &&PathBuf| {
        let name = path.file_name().unwrap().to_string_lossy();
        !name.contains("board") && name != "suite.toml"
    };
    for path in paths.iter().filter(is_plan) {
        let file = source(path);
        let folder = path.parent().unwrap();
        let read = |name: &str| std::fs::read_to_string(folder.join(name)).map_err(|error| error.to_string());
        if file.name.ends_with("common.toml") {
            wrong += &render(&plans::check_included(&file, &mut { read }), &[file], false);
            continue;
        }
        let plan = plans::gather(&file, &mut { read }).and_then(|text| plans::read_gathered(&text, &[], 1));
        match plan {
            Ok(plan) if plan.warnings.is_empty() => {}
            Ok(plan) => wrong += &render(&plan.warnings, &[file], false),
            Err(found) => wrong += &render(&found, &[file], false),
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

#[test]
fn functions_can_be_written_as_a_plan_has_them() {
    let mut paths = Vec::new();
    plans_below(&Path::new(env!("CARGO_MANIFEST_DIR")).join("library/expert"), &mut paths);
    let written = |case: &plans::Case| {
        let functions = case.settings.expert.iter();
        functions
            .flat_map(|it| it.written().map(|(key, value)| format!("{:?}.{key} = {value}\n", it.name)))
            .collect::<String>()
    };
    let mut seen = 0;
    for path in paths {
        let folder = path.parent().unwrap();
        let read = |name: &str| std::fs::read_to_string(folder.join(name)).map_err(|error| error.to_string());
        let gathered = plans::gather(&source(&path), &mut { read });
        let Ok(plan) = gathered.and_then(|text| plans::read_gathered(&text, &[], 1)) else { continue };
        for case in plan.cases().filter(|case| !case.settings.expert.is_empty()) {
            let first = written(&case);
            let text = format!(
                "format = 1\ntitle = \"again\"\nexpect = [{{ state = {{ stays = \"RUNNING\" }} }}]\n[settings]\ninitial = \"empty\"\n[settings.expert]\n{first}"
            );
            let file = SourceFile::new("again.toml", text);
            let again = plans::read(&file, &[], 1)
                .unwrap_or_else(|found| panic!("{}", render(&found, &[file], false)));
            assert_eq!(written(&again.case(0).unwrap()), first, "{}", path.display());
            seen += 1;
        }
    }
    assert!(seen > 100, "{seen}");
}

#[test]
fn rows_are_cases_with_their_own_entries() {
    let plan = read("tests/plans/fallback.toml");
    let cases: Vec<plans::Case> = plan.cases().collect();
    let names: Vec<&str> = cases.iter().map(|case| case.name.as_str()).collect();
    assert_eq!(names, ["fallback[under]", "fallback[over]"]);
    assert_eq!(cases[0].expectations.len(), 2);
    assert_eq!(cases[1].expectations.len(), 3);
    let Stimulus::Overload { cycle, times, task } = &cases[1].steps[0].stimulus else {
        panic!("not an overload")
    };
    assert_eq!((*cycle, *times, task.as_str()), (Span::from_millis(101), 1, "MAST"));
    assert_eq!(
        cases[1].steps[0].when,
        StepTime::At(Anchor { base: AnchorBase::Start, offset: Span::from_secs(1) })
    );
    assert_eq!(cases[1].ends, Anchor { base: AnchorBase::Start, offset: Span::from_secs(2) });
    let signals: Vec<&str> = cases[1].signals.iter().map(|one| one.name.as_str()).collect();
    assert_eq!(signals, ["lamp", "PLC_R.i_wLastApplicationError"]);
}

#[test]
fn a_sweep_is_exact_and_keeps_its_unit() {
    let plan = read("tests/plans/power-cut.toml");
    assert_eq!(plan.len(), 55);
    let last = plan.case(54).unwrap();
    assert_eq!(last.name, "power-cut[cut=19.98 ms]");
    let at = Anchor { base: AnchorBase::Start, offset: Span::from_micros(2_019_980) };
    assert_eq!(last.steps[0].when, StepTime::At(at));
    let StepTime::When { within, from, .. } = &last.steps[1].when else { panic!("does not wait") };
    assert_eq!(*within, Span::from_secs(30));
    // What is waited for from an awaited or timed step depends on what that step depends on.
    assert_eq!(*from, Anchor { base: AnchorBase::Start, offset: Span::from_micros(2_019_980) });
    assert_eq!(last.ends, Anchor { base: AnchorBase::Step("back".into()), offset: Span::from_secs(1) });
}

#[test]
fn phases_are_cases_and_a_pulse_is_an_instant() {
    let plan = read("tests/plans/reflex.toml");
    assert_eq!(plan.len(), 16);
    let case = plan.case(3).unwrap();
    assert_eq!(case.name, "reflex[train.phase=3/16]");
    let at = Anchor { base: AnchorBase::Start, offset: Span::from_micros(103_750) };
    assert_eq!(case.steps[0].when, StepTime::At(at));
    let needs: Vec<String> = case.needs.iter().map(ToString::to_string).collect();
    assert_eq!(needs, ["pulse >= 200 kHz", "timestamp <= 500 ns"]);
}

#[test]
fn the_command_line_gives_parameters() {
    let text = "format = 1\nprogram = \"a.st\"\nexpect = [{ value = { of = \"n\", is = \"$n\", when = \"start + $wait\" } }]\n\
                [parameters]\nn = 3\nwait = { default = \"1 ms\", doc = \"Time to settle.\" }\n";
    let file = SourceFile::new("a.toml", text);
    let given = [("wait".to_owned(), "5 ms".to_owned())];
    let case = plans::read(&file, &given, 1).unwrap().case(0).unwrap();
    assert_eq!(case.parameters, [("n".to_owned(), "3".to_owned()), ("wait".to_owned(), "5 ms".to_owned())]);
    let code = |given: &[(&str, &str)]| {
        let given: Vec<(String, String)> =
            given.iter().map(|(a, b)| (a.to_string(), b.to_string())).collect();
        plans::read(&file, &given, 1).unwrap_err()[0].code
    };
    assert_eq!(code(&[("wiat", "5 ms")]), "P0408");
    assert_eq!(code(&[("n", "many")]), "P0408");
    assert_eq!(code(&[("wait", "5 mm")]), "P0301");
}

#[test]
fn a_random_phase_follows_the_seed() {
    let text = "format = 1\nprogram = \"a.st\"\nsteps = [{ id = \"a\", at = \"start\", phase = { over = \"20 ms\" }, \
                mark = {} }]\nexpect = [{ state = { is = \"RUNNING\", when = \"end\" } }]\n";
    let file = SourceFile::new("a.toml", text);
    let offset = |seed| match plans::read(&file, &[], seed).unwrap().case(0).unwrap().steps[0].when.clone() {
        StepTime::At(anchor) => anchor.offset,
        StepTime::When { .. } => panic!("waits"),
    };
    assert_eq!(offset(1), offset(1));
    assert_ne!(offset(1), offset(2));
    assert!(offset(1) < Span::from_millis(20));
}

/// What a plan expects to be refused: by the reader of plans here, else by the check on a bench.
#[test]
fn a_refusal_belongs_to_its_rows() {
    let text = "format = 1\nprogram = \"a.st\"\nproves = [\"io:STD-IN-01\"]\nsettings = { filter = \"$filter\" }\n\
                refused = { rows = [\"other\", \"beyond\"], code = \"$code\", says = \"$says\" }\n\
                expect = [{ rows = [\"known\"], state = { is = \"RUNNING\", when = \"end\" } }]\n[rows]\n\
                known = { filter = \"4 ms\", code = \"P0110\", says = \"\" }\n\
                other = { filter = \"3 ms\", code = \"P0110\", says = \"3 ms\" }\n\
                beyond = { filter = \"4 ms\", code = \"R0113\", says = \"tasks\" }\n";
    let read = |text: &str| {
        let file = SourceFile::new("a.toml", text);
        plans::read(&file, &[], 1).map(|plan| plan.cases().collect::<Vec<_>>())
    };
    let cases = read(text).unwrap();
    assert_eq!(cases[0].refusal, None);
    let other = cases[1].refusal.as_ref().unwrap();
    assert_eq!((other.code.as_str(), cases[1].name.as_str()), ("P0110", "a[other]"));
    assert!(other.judge(&other.found).is_ok() && cases[1].proves == ["io:STD-IN-01"]);
    let beyond = cases[2].refusal.as_ref().unwrap();
    assert!(beyond.found.is_empty() && beyond.judge(&[]).unwrap_err().contains("nothing is refused"));
    // What is wrong in another way is the plan's own fault.
    let found = read(&text.replace("\"a.st\"", "\"\"")).unwrap_err();
    assert!(found.iter().any(|one| one.code == "P0109"), "{found:?}");
}

#[test]
fn a_refusal_is_one_of_code_text_and_count() {
    let text = "format = 1\nprogram = \"a.st\"\nrefused = { code = \"R0112\", says = [\"last\", \"fix\"], errors = 2 }\n";
    let file = SourceFile::new("a.toml", text);
    let refusal = plans::read(&file, &[], 1).unwrap().case(0).unwrap().refusal.unwrap();
    let error = |code, message: &str| document::Diagnostic::error(code, message);
    let (one, two) = (error("R0112", "the last one"), error("R0112", "no").help("fix it"));
    assert!(refusal.judge(&[one.clone(), two.clone()]).is_ok());
    let wrong = |found: &[document::Diagnostic]| refusal.judge(found).unwrap_err();
    assert!(wrong(&[one.clone(), one.clone()]).contains("no finding says `fix`"));
    assert!(wrong(&[one.clone(), two.clone(), two.clone()]).contains("3 findings in place of 2"));
    assert!(wrong(&[one, two, error("R0113", "else")]).contains("refused otherwise: R0113"));
    assert!(wrong(&[document::Diagnostic::warning("R0112", "the last one")]).contains("nothing"));
}

#[test]
fn a_warning_is_one_without_errors() {
    let text =
        "format = 1\nprogram = \"a.st\"\nwarned = { code = \"R0117\", says = \"LREAL\", errors = 1 }\n";
    let read = |text: &str| plans::read(&SourceFile::new("a.toml", text), &[], 1);
    let warned = read(text).unwrap().case(0).unwrap().refusal.unwrap();
    let warning = |code| document::Diagnostic::warning(code, "the type LREAL");
    assert!(warned.judge(&[warning("S0109"), warning("R0117")]).is_ok());
    let wrong = |found: &[document::Diagnostic]| warned.judge(found).unwrap_err();
    assert!(wrong(&[warning("S0109")]).contains("does not warn of R0117"));
    assert!(
        wrong(&[warning("R0117"), document::Diagnostic::error("S0301", "x")]).contains("refused otherwise")
    );
    assert!(wrong(&[document::Diagnostic::error("R0117", "LREAL")]).contains("refused otherwise"));
    assert_eq!(read(&format!("{text}refused = {{ code = \"R0117\" }}\n")).unwrap_err()[0].code, "P0503");
}

#[test]
fn the_states_that_a_case_speaks_of() {
    let states = |claim: &str, step: &str| {
        let text = format!(
            "format = 1\nprogram = \"a.st\"\nends = \"start + 2 s\"\nsteps = [{step}]\nexpect = [{{ {claim} }}]\n"
        );
        let file = SourceFile::new("a.toml", text);
        let plan = plans::read(&file, &[], 1);
        plan.unwrap_or_else(|found| panic!("{}", render(&found, &[file], false)))
            .case(0)
            .unwrap()
            .expected_states()
    };
    for (claim, expected) in [
        ("state = { is = \"halt\" }", &["HALT"][..]),
        ("state = { becomes = \"EMPTY\" }", &["EMPTY"]),
        ("stays = { signal = \"state\", one-of = [\"RUNNING\", \"HALT\"] }", &["RUNNING", "HALT"]),
        ("value = { of = \"state\", is = \"HALT\" }", &["HALT"]),
        // All that an alarm line shows.
        ("never = { signal = \"state\", is = \"RUNNING\" }", &["HALT", "EMPTY"]),
        ("never = { signal = \"state\", is = \"HALT\" }", &[]),
        ("value = { of = \"%MW1\", is = 1 }", &[]),
    ] {
        assert_eq!(states(claim, ""), expected, "{claim}");
    }
    let waits = "{ id = \"a\", when = { signal = \"state\", becomes = \"HALT\", within = \"1 s\" } }";
    assert_eq!(states("value = { of = \"%MW1\", is = 1 }", waits), ["HALT"]);
}

#[test]
fn a_measurement_has_the_guard_band_of_its_plan_unless_it_names_one() {
    let text = "format = 1\ntitle = \"t\"\nprogram-text = \"PROGRAM MAIN END_PROGRAM\"\nsignals = { q = \"%IX0.0\" }\n\
        guard = \"none\"\nmeasure = [\n  { name = \"as the plan\", period-of = \"q\", max = \"1 ms\" },\n\
        { name = \"its own\", period-of = \"q\", max = \"1 ms\", guard = \"uncertainty\" },\n]\n";
    let guards = |text: &str| -> Vec<GuardBand> {
        let plan = plans::read(&SourceFile::new("t.toml", text), &[], 1).unwrap();
        plan.case(0).unwrap().measurements.iter().map(|known| known.guard).collect()
    };
    assert_eq!(guards(text), [GuardBand::None, GuardBand::Uncertainty]);
    assert_eq!(guards(&text.replace("guard = \"none\"\n", "")), [GuardBand::Uncertainty; 2]);
}
