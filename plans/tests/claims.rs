//! What is refused: claims that make no sense in themselves, and claims that make none for their signals.

use document::{Fields, Findings, Node, SourceFile};
use record::GuardBand;
use scanrig_plans::expect::{self, Expectation, ReadContext};
use scanrig_plans::judge::{CaseJudge, Scenario};
use scanrig_plans::lang::PlanNames;
use scanrig_plans::{Anchor, TOML, measure};
use signal::{SignalInfo, ValueKind};

/// Names without a plan around them: everything is known.
struct Anything;

impl PlanNames for Anything {
    fn anchor(&self, node: &Node, _out: &mut Findings) -> Option<Anchor> {
        Anchor::parse(node.as_text()?).ok()
    }

    fn signal(&self, node: &Node, _out: &mut Findings) -> Option<String> {
        node.as_text().map(str::to_owned)
    }

    fn at_value(&self, node: &Node, _out: &mut Findings) -> Option<(String, Option<Anchor>)> {
        Some((node.as_text()?.to_owned(), None))
    }
}

/// The scenario of one claim or measurement, or the codes of what is wrong with it.
fn read(text: &str) -> Result<Scenario, Vec<&'static str>> {
    let source = SourceFile::new("claim", format!("it = {text}"));
    let mut out = Findings::new(&source, TOML);
    let table = document::toml::parse(&source, TOML).expect("TOML");
    let table = table.get("it").and_then(Node::as_table).expect("a table");
    let mut scenario = Scenario::default();
    match expect::verb(&table.entries[0].key) {
        Some(verb) => {
            let inner = table.entries[0].node.as_table().expect("a table");
            let fields = Fields::check(inner, 0..1, verb.name, verb.keys, &mut out);
            let mut cx = ReadContext { out: &mut out, names: &Anything, place: 0..1 };
            if let Some(claim) = (verb.read)(&fields, &mut cx) {
                let expectation = Expectation { name: String::new(), verb: verb.name, claim, place: None };
                scenario.expectations.push(expectation);
            }
        }
        None => {
            let fields = Fields::check(table, 0..1, "measurement", measure::KEYS, &mut out);
            let mut cx = ReadContext { out: &mut out, names: &Anything, place: 0..1 };
            scenario.measurements.extend(measure::read(&fields, GuardBand::default(), &mut cx));
        }
    }
    let nothing = scenario.expectations.is_empty() && scenario.measurements.is_empty();
    let found: Vec<&'static str> = out.into_vec().into_iter().map(|found| found.code).collect();
    assert_eq!(nothing, !found.is_empty(), "{text}: refused and reported go together: {found:?}");
    if nothing { Err(found) } else { Ok(scenario) }
}

/// A claim that can never be met or never fail is refused when the plan is read.
#[test]
fn senseless_claims_are_refused() {
    for (text, code) in [
        (r#"{ stays = { signal = "q" } }"#, "P0503"),
        (r#"{ stays = { signal = "q", is = true, one-of = [1] } }"#, "P0503"),
        (r#"{ stays = { signal = "q", min = 5, max = 4 } }"#, "P0503"),
        (r#"{ stays = { signal = "q", is = true, from = "a + 5 ms", until = "a + 5 ms" } }"#, "P0503"),
        (r#"{ never = { is = true } }"#, "P0503"),
        (r#"{ never = { all = ["q"] } }"#, "P0503"),
        (r#"{ never = { all = ["q", "q"] } }"#, "P0503"),
        (r#"{ never = { signal = "q", all = ["q", "r"] } }"#, "P0503"),
        (r#"{ edges = { signal = "q" } }"#, "P0503"),
        (r#"{ edges = { signal = "q", rising = "3 .. 1" } }"#, "P0104"),
        (r#"{ rises = { signal = "q", within = "2 ms .. 1 ms" } }"#, "P0503"),
        (r#"{ rises = { signal = "q", within = "2 .. 3" } }"#, "P0104"),
        (r#"{ rises = { signal = "q", within = 5 } }"#, "P0103"),
        (r#"{ pulse = { signal = "q" } }"#, "P0102"),
        (r#"{ period = { signal = "q", is = "1 ms .. 2 ms", tolerance = "1 ms" } }"#, "P0503"),
        (r#"{ state = { is = "RUNNING", stays = "RUNNING" } }"#, "P0503"),
        (r#"{ state = { is = "RUNNING", from = "a" } }"#, "P0503"),
        (r#"{ value = { of = "q", is = 1, near = "n" } }"#, "P0503"),
        (r#"{ value = { of = "q", is = 1, tolerance = 1 } }"#, "P0503"),
        (r#"{ equal = { left = "n", right = "n" } }"#, "P0503"),
        (r#"{ order = { edges = ["q rises"] } }"#, "P0503"),
        (r#"{ order = { edges = ["q rises", "r goes"] } }"#, "P0104"),
        (r#"{ happens = { step = "a + 1 ms" } }"#, "P0503"),
        (r#"{ name = "t", from = "a", to = "b", max = 6 }"#, "P0304"),
        (r#"{ name = "t", from = "a", to = "b", max = "6 V" }"#, "P0304"),
        (r#"{ name = "t", from = "a" }"#, "P0102"),
        (r#"{ name = "t", from = "a", value-of = "n" }"#, "P0660"),
        (r#"{ name = "t", value-of = "n", nominal = 3 }"#, "P0503"),
        (r#"{ name = "t", value-of = "n", nominal = 3, tolerance = 1, max = 4 }"#, "P0503"),
        (r#"{ frequency = { signal = "q" } }"#, "P0503"),
        (r#"{ frequency = { signal = "q", is = 50 } }"#, "P0304"),
        (r#"{ frequency = { signal = "q", max = "5 ms" } }"#, "P0304"),
        (r#"{ duty = { signal = "q", is = "40 .. 60" } }"#, "P0304"),
        (r#"{ phase = { of = "q", reference = "q", is = "90 deg ± 5 deg" } }"#, "P0503"),
        (r#"{ phase = { of = "q", reference = "r", min = "5 deg" } }"#, "P0503"),
        (r#"{ phase = { of = "q", reference = "r", is = "0 deg .. 400 deg" } }"#, "P0503"),
        (r#"{ settles = { signal = "n", is = 5, from = "a", within = "2 s", until = "a + 1 s" } }"#, "P0503"),
        (r#"{ settles = { signal = "n", max = 5, within = "2 s", overshoot = 1 } }"#, "P0503"),
        (r#"{ settles = { signal = "n", is = 5 } }"#, "P0102"),
        (r#"{ follows = { signal = "n", leader = "n" } }"#, "P0503"),
        (r#"{ led = { name = "RUN", is = "on", stays = "on" } }"#, "P0503"),
        (r#"{ led = { name = "RUN", is = "green" } }"#, "P0104"),
        (r#"{ led = { name = "ERROR", is = "on" } }"#, "P0104"),
        (r#"{ log = { from = "a" } }"#, "P0503"),
        (r#"{ log = { contains = "x", until = "a" } }"#, "P0503"),
        (r#"{ log = { never = " " } }"#, "P0503"),
        (r#"{ task = { name = "MAST", figure = "lost", is = 0, when = "a", from = "a" } }"#, "P0503"),
        (r#"{ task = { name = "MAST", figure = "speed", is = 0 } }"#, "P0104"),
        (r#"{ name = "t", value-of = "n", frequency-of = "n" }"#, "P0503"),
        (r#"{ name = "t", frequency-of = "n", to = "a" }"#, "P0660"),
        (r#"{ name = "t", frequency-of = "n", take = "max" }"#, "P0660"),
        (r#"{ name = "t", frequency-of = "n", max = 50 }"#, "P0304"),
        (r#"{ name = "t", width-of = "n", take = "rms" }"#, "P0660"),
        (r#"{ name = "t", value-of = "n", take = "first" }"#, "P0660"),
        (r#"{ name = "t", value-of = "n", until = "a" }"#, "P0660"),
        (r#"{ name = "t", period-of = "n", level = "low" }"#, "P0660"),
    ] {
        assert_eq!(read(text).unwrap_err(), [code], "{text}");
    }
}

/// What the signals of the case cannot answer is found before the case runs.
#[test]
fn claims_about_the_wrong_signals_are_refused() {
    let mut state = SignalInfo::exact("state", ValueKind::State);
    state.labels = vec![(2, "RUNNING".into())];
    let mut volts = SignalInfo::exact("u", ValueKind::Real);
    volts.unit = "V".into();
    let signals = [state, volts, SignalInfo::exact("q", ValueKind::Bool)];
    for (text, code) in [
        (r#"{ rises = { signal = "lamp" } }"#, "P0505"),
        (r#"{ state = { stays = "RUNING" } }"#, "P0504"),
        (r#"{ stays = { signal = "u", max = "5 mA" } }"#, "P0504"),
        (r#"{ stays = { signal = "q", is = "RUNNING" } }"#, "P0504"),
        (r#"{ name = "t", value-of = "u", max = "5 mA" }"#, "P0504"),
        (r#"{ name = "t", value-of = "u", min = 3, max = 2 }"#, "P0504"),
        (r#"{ name = "t", value-of = "state", take = "mean" }"#, "P0504"),
        (r#"{ name = "t", value-of = "u", take = "mean", max = "5 mA" }"#, "P0504"),
        (r#"{ settles = { signal = "q", is = true, within = "1 s" } }"#, "P0504"),
        (r#"{ settles = { signal = "u", is = "5 V ± 1 V", within = "1 s", overshoot = "1 mA" } }"#, "P0504"),
        (r#"{ follows = { signal = "u", leader = "q", tolerance = "1 A" } }"#, "P0504"),
    ] {
        let found = CaseJudge::new(read(text).expect(text), &signals).expect_err(text);
        assert_eq!(found.iter().map(|found| found.code).collect::<Vec<_>>(), [code], "{text}: {found:?}");
        assert!(!found[0].message.is_empty());
    }
    assert!(
        CaseJudge::new(read(r#"{ stays = { signal = "u", max = "5000 mV" } }"#).unwrap(), &signals).is_ok()
    );
}
