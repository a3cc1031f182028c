//! Traces with known verdicts, written as text: `tests/goldens/*.txt`.
//!
//! A case is a block between lines of `---`. Its lines are a `# title`, declarations of signals
//! (`counts-up-to:lamp 1000` for what its board promises; `lamp bool`, `p real V deadband 1`, `n int every 10`, `s bool sampled 10`), events (`100 lamp TRUE`,
//! `[100, 110] lamp FALSE`, `100 step:busy`), `end 1000`, a claim or a measurement in TOML, and what comes of
//! it: `verdict pass`, and if wanted `margin 5`, `observed ...`, `reason ...`, `nearest ...`, `writer ...`,
//! `value 3 4` of a measurement, and `early 150`: when the claim is first known to be lost.
//! Times are in nanoseconds.

use std::fs;
use std::path::Path;

use document::{Fields, Findings, Node, SourceFile};
use record::{GuardBand, Verdict};
use scanrig_plans::expect::{self, Expectation, ReadContext};
use scanrig_plans::judge::{CaseJudge, Scenario, StepFacts};
use scanrig_plans::lang::PlanNames;
use scanrig_plans::steps::{StepCondition, StepWait};
use scanrig_plans::{Anchor, measure};
use signal::{
    Cause, Event, Policy, Sampling, SignalId, SignalInfo, Span, Time, Trace, Value, ValueKind, When,
};

/// Names without a plan around them: everything is known.
#[derive(Debug)]
struct Anything;

impl PlanNames for Anything {
    fn anchor(&self, node: &Node, out: &mut Findings) -> Option<Anchor> {
        let text = node.as_text()?;
        match Anchor::parse(text) {
            Ok(anchor) => Some(anchor),
            Err(error) => {
                out.bad("P0301", node, error.fault.to_string(), "");
                None
            }
        }
    }

    fn signal(&self, node: &Node, _out: &mut Findings) -> Option<String> {
        let Some(table) = node.as_table() else { return node.as_text().map(str::to_owned) };
        // `log:halt`, `task:MAST:lost`.
        let value = |key: &str| table.get(key).and_then(Node::as_text).unwrap_or_default();
        let first = table.entries.first()?;
        let figure = if value("figure").is_empty() { String::new() } else { format!(":{}", value("figure")) };
        Some(format!("{}:{}{figure}", first.key, value(&first.key)))
    }

    fn at_value(&self, node: &Node, out: &mut Findings) -> Option<(String, Option<Anchor>)> {
        let text = node.as_text()?;
        let Some((name, at)) = text.split_once('@') else { return Some((text.trim().to_owned(), None)) };
        let at = Node::new(node.span.clone(), document::Data::Text(at.trim().to_owned()));
        Some((name.trim().to_owned(), Some(self.anchor(&at, out)?)))
    }
}

#[derive(Default)]
pub(crate) struct Golden {
    title: String,
    signals: Vec<SignalInfo>,
    events: Vec<Event>,
    steps: Vec<StepFacts>,
    end: i64,
    toml: String,
    wanted: Vec<(String, String)>,
    notes: Vec<(String, String)>,
}

fn value(text: &str, kind: ValueKind) -> Value {
    match text {
        "TRUE" => Value::Bool(true),
        "FALSE" => Value::Bool(false),
        "Z" => Value::HighZ,
        "?" => Value::Unknown,
        "off" => Value::Int(0),
        "fast-flash" => Value::Int(2),
        _ if kind == ValueKind::Real => Value::Real(text.parse().expect("a real")),
        _ => Value::Int(text.parse().expect("an integer")),
    }
}

fn declare(words: &[&str]) -> SignalInfo {
    let kind = match words[1] {
        "bool" => ValueKind::Bool,
        "int" => ValueKind::Int,
        "real" => ValueKind::Real,
        "state" | "led" => ValueKind::State,
        other => panic!("no kind {other}"),
    };
    let mut info = SignalInfo::exact(words[0], kind);
    let mut rest = words[2..].iter();
    while let Some(word) = rest.next() {
        let mut number = || rest.next().expect("a number").parse::<i64>().expect("a number");
        match *word {
            "sampled" => info.sampling = Sampling::Sampled { period: Span::from_nanos(number()) },
            "deadband" => info.policy = Policy::Deadband(number() as f64),
            "every" => info.policy = Policy::AtMostEvery(Span::from_nanos(number())),
            unit => info.unit = unit.to_owned(),
        }
    }
    if words[1] == "led" {
        info.labels = vec![(0, "off".into()), (1, "on".into()), (2, "fast-flash".into())];
    } else if kind == ValueKind::State {
        info.labels = vec![(0, "EMPTY".into()), (2, "RUNNING".into()), (4, "HALT".into())];
    }
    info
}

impl Golden {
    pub(crate) fn parse(block: &str) -> Golden {
        let mut golden = Golden::default();
        for line in block.lines().map(str::trim).filter(|line| !line.is_empty()) {
            let words: Vec<&str> = line.split_whitespace().collect();
            if let Some(title) = line.strip_prefix("# ") {
                golden.title = title.to_owned();
            } else if line.starts_with('{') {
                golden.toml.push_str(line);
            } else if line.starts_with(|c: char| c == '[' || c == '-' || c.is_ascii_digit()) {
                golden.event(line);
            } else if words[0] == "end" {
                golden.end = words[1].parse().expect("the end");
            } else if words[0].starts_with("counts-up-to:") {
                golden.notes.push((words[0].to_owned(), words[1].to_owned()));
            } else if words[0] == "awaited" {
                golden.mark(&format!("step:{}", words[1]));
                let awaited = Some(StepWait {
                    signal: String::new(),
                    awaits: StepCondition::Changes,
                    from: Anchor::START,
                    within: Span::from_secs(1),
                });
                golden.steps.push(StepFacts { id: words[1].into(), awaited, ..StepFacts::default() });
            } else if words[0] == "train" {
                let train = Some(words[2].to_owned());
                golden.steps.push(StepFacts { id: words[1].into(), train, ..StepFacts::default() });
            } else if ["verdict", "margin", "observed", "reason", "nearest", "writer", "value", "early"]
                .contains(&words[0])
            {
                let (key, rest) = line.split_once(' ').expect("a value");
                golden.wanted.push((key.into(), rest.trim().into()));
            } else {
                golden.signals.push(declare(&words));
            }
        }
        golden
    }

    fn mark(&mut self, name: &str) -> SignalId {
        let at = self.signals.iter().position(|info| info.name == name).unwrap_or_else(|| {
            assert!(name.starts_with("step:"), "{}: no signal {name}", self.title);
            self.signals.push(SignalInfo::exact(name, ValueKind::Mark));
            self.signals.len() - 1
        });
        SignalId(at as u32)
    }

    fn event(&mut self, line: &str) {
        let (at, rest) = match line.strip_prefix('[') {
            Some(inside) => {
                let (interval, rest) = inside.split_once(']').expect("]");
                let (a, b) = interval.split_once(',').expect("two ends");
                let number = |text: &str| Time::from_nanos(text.trim().parse().expect("a time"));
                (When { earliest: number(a), latest: number(b) }, rest)
            }
            None => {
                let (at, rest) = line.split_once(' ').expect("a signal");
                (When::exactly(Time::from_nanos(at.parse().expect("a time"))), rest)
            }
        };
        let mut words = rest.split_whitespace();
        let signal = self.mark(words.next().expect("a signal"));
        let value = match words.next() {
            Some(word) => value(word, self.signals[signal.0 as usize].kind),
            None => Value::Int(1),
        };
        let cause = match words.next() {
            Some("by") => Cause::Program { task: 0, file: 0, line: words.next().unwrap().parse().unwrap() },
            _ => Cause::Unknown,
        };
        self.events.push(Event { signal, at, value, cause });
    }

    /// The claim or measurement of the block.
    fn scenario(&self) -> Scenario {
        let text = format!("it = {}", self.toml);
        let source = SourceFile::new("golden", text);
        let mut out = Findings::new(&source, scanrig_plans::TOML);
        let table = document::toml::parse(&source, scanrig_plans::TOML).expect("TOML");
        let entry = table.get("it").and_then(Node::as_table).expect("a table").clone();
        let names = Anything;
        let mut scenario = Scenario { steps: self.steps.clone(), ..Scenario::default() };
        let place = 0..source.text.len();
        let mut cx = ReadContext { out: &mut out, names: &names, place: place.clone() };
        match entry.entries.iter().find_map(|entry| Some((entry, expect::verb(&entry.key)?))) {
            Some((entry, verb)) => {
                let inner = entry.node.as_table().expect("a table");
                let fields = Fields::check(inner, place, verb.name, verb.keys, cx.out);
                let claim = (verb.read)(&fields, &mut cx);
                let claim = claim.filter(|_| !out.has_errors());
                let Some(claim) = claim else { panic!("{}: {:?}", self.title, out.into_vec()) };
                scenario.expectations.push(Expectation {
                    name: String::new(),
                    verb: verb.name,
                    claim,
                    place: None,
                });
            }
            None => {
                let fields = Fields::check(&entry, place, "measurement", measure::KEYS, cx.out);
                let taken =
                    measure::read(&fields, GuardBand::default(), &mut cx).filter(|_| !out.has_errors());
                let Some(taken) = taken else { panic!("{}: {:?}", self.title, out.into_vec()) };
                scenario.measurements.push(taken);
            }
        }
        scenario
    }

    fn trace(&self) -> Trace {
        let mut trace = Trace::new();
        for info in &self.signals {
            trace.define(info.clone()).expect("a signal");
        }
        trace.set_note("task:0", "MAST".into());
        trace.set_note("file:0", "lamp.st".into());
        for (key, value) in &self.notes {
            trace.set_note(key, value.clone());
        }
        for event in &self.events {
            while trace.settle(event.at.earliest).expect("an event").is_some() {}
            trace.push(*event).expect("an event");
        }
        while trace.settle(Time::from_nanos(self.end)).expect("an event").is_some() {}
        trace
    }

    pub(crate) fn check(mut self) {
        self.mark("step:start");
        self.mark("step:end");
        if self.toml.is_empty() {
            panic!("{}: nothing claimed", self.title);
        }
        if !self.events.iter().any(|event| self.signals[event.signal.0 as usize].name == "step:start") {
            let signal = self.mark("step:start");
            let at = When::exactly(Time::ZERO);
            let event = Event { signal, at, value: Value::Int(1), cause: Cause::Unknown };
            // After the values that the trace begins with.
            let place = self.events.iter().take_while(|event| event.at.latest <= Time::ZERO).count();
            self.events.insert(place, event);
        }
        let trace = self.trace();
        let end = When::exactly(Time::from_nanos(self.end));
        let scenario = self.scenario();
        let judge = CaseJudge::new(scenario.clone(), &self.signals)
            .unwrap_or_else(|found| panic!("{}: {found:?}", self.title));
        let outcome = judge.replay(end, &trace).expect("a readable trace");
        // What is fed piece by piece gives the same, and what is lost early is no pass in the end.
        let mut judge = CaseJudge::new(scenario, &self.signals).expect("as before");
        let mut lost = None;
        for event in trace.events() {
            let event = event.expect("an event");
            judge.feed(&event);
            if lost.is_none() && judge.failed_early() {
                lost = Some(event.at.earliest.as_nanos());
            }
        }
        let live = judge.finish(end, &trace).expect("a readable trace");
        assert_eq!(live, outcome, "{}", self.title);
        if lost.is_some() {
            assert_eq!(outcome.verdict, Verdict::Fail, "{}: lost early", self.title);
        }
        let shown = format!("{}: {outcome:#?}", self.title);
        for (key, wanted) in &self.wanted {
            let claim = outcome.claims.first();
            let got = match key.as_str() {
                "verdict" => outcome.verdict.to_string(),
                "margin" => {
                    let margin = match claim {
                        Some(claim) => claim.margin.clone(),
                        None => outcome.measurements[0].margin.clone(),
                    };
                    margin.map_or("none".into(), |margin| margin.value.to_string())
                }
                "observed" => claim.map(|claim| claim.observed.clone()).unwrap_or_default(),
                "reason" => match claim {
                    Some(claim) => claim.reason.clone(),
                    None => outcome.measurements[0].reason.clone(),
                },
                "nearest" => claim.and_then(|claim| claim.nearest_miss.clone()).unwrap_or_default(),
                "writer" => claim.and_then(|claim| claim.last_writer.clone()).unwrap_or_default(),
                "early" => lost.map_or("never".into(), |at| at.to_string()),
                "value" => {
                    outcome.measurements[0].value.map(|v| format!("{} {}", v[0], v[1])).unwrap_or_default()
                }
                other => panic!("no key {other}"),
            };
            assert_eq!(&got, wanted, "{key} of {shown}");
        }
    }
}

fn blocks() -> Vec<(String, String)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/goldens");
    let mut files: Vec<_> =
        fs::read_dir(folder).expect("the folder").map(|file| file.unwrap().path()).collect();
    files.sort();
    let mut blocks = Vec::new();
    for file in files {
        let text = fs::read_to_string(&file).expect("a golden");
        let name = file.file_stem().unwrap().to_string_lossy().into_owned();
        blocks.extend(text.split("\n---").map(|block| (name.clone(), block.to_owned())));
    }
    blocks
}

/// Every golden has its verdict; fed live or replayed, the outcome is the same.
#[test]
fn goldens_hold() {
    let blocks = blocks();
    assert!(blocks.len() >= 40, "only {} goldens", blocks.len());
    let mut failures = Vec::new();
    for (file, block) in blocks {
        let golden = Golden::parse(&block);
        let title = golden.title.clone();
        let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| golden.check()));
        if result.is_err() {
            failures.push(format!("{file}: {title}"));
        }
    }
    assert!(failures.is_empty(), "{failures:#?}");
}

/// Every verb has at least one golden that passes and one that fails.
#[test]
fn every_verb_is_covered() {
    let blocks = blocks();
    for verb in expect::VERBS {
        for verdict in ["pass", "fail"] {
            let covers = |block: &str| {
                block.contains(&format!("{{ {} =", verb.name))
                    && block.contains(&format!("verdict {verdict}"))
            };
            assert!(
                blocks.iter().any(|(_, block)| covers(block)),
                "no golden of `{}` with {verdict}",
                verb.name
            );
        }
    }
}
