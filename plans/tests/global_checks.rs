//! Suite files and what boards claim: what is wrong with them, and what they add to a case.

use std::path::PathBuf;

use document::{Diagnostic, SourceFile, line_col};
use record::ClaimOrigin;
use scanrig_plans::plan::GlobalChecks;
use scanrig_plans::signals::SignalSource;
use scanrig_plans::{CODES, Case, read};

fn plan(text: &str) -> Case {
    let text = format!("format = 1\nprogram = \"lamp.st\"\n{text}\n");
    read(&SourceFile::new("lamp.toml", text), &[], 1).expect("a plan").case(0).expect("a case")
}

fn suite(name: &str, text: &str) -> GlobalChecks {
    GlobalChecks::of_suite(&SourceFile::new(name, format!("format = 1\n{text}\n"))).expect("a suite")
}

/// `tests/broken-suites/*.toml` say in their first line what must be found, as broken plans do.
#[test]
fn broken_suites_are_refused_at_the_right_place() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/broken-suites");
    let mut paths: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|one| one.unwrap().path()).collect();
    paths.sort();
    let mut wrong = String::new();
    for path in paths {
        let text = std::fs::read_to_string(&path).unwrap();
        let found =
            GlobalChecks::of_suite(&SourceFile::new("suite.toml", text.clone())).err().unwrap_or_default();
        let place = |one: &Diagnostic| {
            assert!(CODES.iter().any(|(code, _)| *code == one.code), "{} is not in the register", one.code);
            let (line, column) = one.labels.first().map_or((0, 0), |at| line_col(&text, at.span.start));
            format!("{} {line}:{column}", one.code)
        };
        let expected = format!("# expect {}", found.iter().map(place).collect::<Vec<_>>().join(", "));
        let (first, rest) = text.split_once('\n').unwrap();
        if std::env::var_os("SCANRIG_BLESS").is_some() {
            std::fs::write(&path, format!("{expected}\n{rest}")).unwrap();
        } else if first != expected || found.is_empty() {
            wrong += &format!("{}: {first}\nbut {expected}\n", path.display());
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

#[test]
fn a_suite_adds_its_claims_with_their_places() {
    let mut case = plan("signals = { lamp = \"%QX0.4\" }\nexpect = [{ rises = { signal = \"lamp\" } }]");
    let checks = suite(
        "suite.toml",
        "signals = { lamp = \"%QX0.4\", horn = \"%QX0.5\" }\ninvariants = [{ never = { all = [\"lamp\", \"horn\"] } }]\n\
         alarms = [{ name = \"heat\", when = { signal = \"%MW3\", above = 5 } }]",
    );
    checks.attach(&mut case).unwrap();
    let names: Vec<&str> = case.signals.iter().map(|signal| signal.name.as_str()).collect();
    assert_eq!(names, ["lamp", "horn", "%MW3"]);
    assert!(case.signals[0].file.is_none() && case.signals[1].file.as_deref() == Some("suite.toml"));
    assert!(case.needs.iter().any(|need| need.word == "memory-access"));
    let scenario = case.scenario();
    let [never, alarm] = scenario.global_checks.as_slice() else { panic!("{scenario:#?}") };
    assert_eq!((never.origin, never.expectation.place.as_ref().unwrap().line), (ClaimOrigin::Suite, 3));
    assert_eq!(alarm.expectation.name, "heat");
    // The plan's own claims stay where they are.
    assert_eq!(scenario.expectations.len(), 1);
}

#[test]
fn one_name_for_two_things_is_distinguished() {
    let mut case = plan("signals = { lamp = \"%QX0.7\" }\nexpect = [{ rises = { signal = \"lamp\" } }]");
    let invariant = "invariants = [{ never = { signal = \"lamp\" } }]";
    suite("suite.toml", &format!("signals = {{ lamp = \"%QX0.4\" }}\n{invariant}"))
        .attach(&mut case)
        .unwrap();
    suite("a/suite.toml", &format!("signals = {{ lamp = \"%QX0.5\" }}\n{invariant}"))
        .attach(&mut case)
        .unwrap();
    let names: Vec<&str> = case.signals.iter().map(|signal| signal.name.as_str()).collect();
    assert_eq!(names, ["lamp", "suite lamp", "suite lamp 2"]);
    let claims: Vec<String> =
        case.invariants.iter().flat_map(|guard| guard.expectation.claim.signals()).collect();
    assert_eq!(claims, ["suite lamp", "suite lamp 2"]);
}

#[test]
fn what_the_plan_records_coarsely_a_suite_records_whole() {
    let mut case = plan(
        "signals = { n = { path = \"MAIN.n\", at-most-every = \"1 s\" } }\nexpect = [{ stays = { signal = \"n\", min = 0 } }]",
    );
    let checks = suite(
        "suite.toml",
        "signals = { n = \"MAIN.n\" }\ninvariants = [{ stays = { signal = \"n\", max = 5 } }]",
    );
    checks.attach(&mut case).unwrap();
    assert_eq!(case.signals[1].name, "suite n");
}

#[test]
fn a_board_speaks_of_its_channels() {
    let text =
        "format = 1\n[board]\nkind = \"simulated\"\n[[invariants]]\nnever = { all = [\"Q4\", \"%QX0.5\"] }\n";
    let checks = GlobalChecks::of_board(&SourceFile::new("bench.toml", text)).unwrap();
    let mut case = plan("expect = [{ value = { of = \"Q4\", is = 1 } }]");
    checks.attach(&mut case).unwrap();
    let sources: Vec<(&str, &SignalSource)> =
        case.signals.iter().map(|signal| (signal.name.as_str(), &signal.source)).collect();
    // In the plan Q4 is a variable first.
    assert!(matches!(sources[0], ("Q4", SignalSource::Path(_))));
    assert!(matches!(sources[1], ("board Q4", SignalSource::Channel(name)) if name == "Q4"));
    assert!(matches!(sources[2], ("%QX0.5", SignalSource::Line(_))));
}

#[test]
fn two_alarms_of_one_name_are_shown_with_both_places() {
    let alarm = "alarms = [{ name = \"heat\", when = { signal = \"lamp\", is = true } }]";
    let mut case = plan(&format!("signals = {{ lamp = \"%QX0.4\" }}\n{alarm}"));
    let checks = suite("suite.toml", &format!("signals = {{ lamp = \"%QX0.4\" }}\n{alarm}"));
    let found = checks.attach(&mut case).unwrap_err();
    let files: Vec<&str> = found[0].labels.iter().map(|label| label.file.as_str()).collect();
    assert_eq!((found[0].code, files), ("P0406", vec!["suite.toml", "lamp.toml"]));
}
