//! What is worth knowing about a plan that is right, and what is not.

use document::{SourceFile, line_col};
use scanrig_plans::bench::{Doubt, doubt};
use scanrig_plans::read;
use signal::{Sampling, SignalInfo, Span, ValueKind};

/// The warnings of a plan with their lines.
fn warnings(text: &str) -> Vec<String> {
    let file = SourceFile::new("a.toml", format!("format = 1\nprogram = \"a.st\"\n{text}"));
    let plan = read(&file, &[], 1).unwrap_or_else(|found| panic!("{found:#?}"));
    let line = |at: usize| line_col(&file.text, at).0;
    plan.warnings.iter().map(|one| format!("{} {}", one.code, line(one.labels[0].span.start))).collect()
}

#[test]
fn a_name_that_no_row_uses_is_reported() {
    let rows = "expect = [
  { rows = [\"one\"], rises = { signal = \"lamp\" } },
  { rows = [\"two\"], rises = { signal = \"horn\" } },
]
[rows]
one = {}
two = {}
";
    let signals = "signals = { lamp = \"%QX0.4\", horn = \"%QX0.5\", spare = \"%QX0.6\", kept = { path = \"MAIN.n\", record = true } }\n";
    assert_eq!(warnings(&format!("{signals}{rows}")), ["P0623 3"]);
    // A second name under which an alarm, an invariant or a wait looks at it is a use.
    let used = "signals = { lamp = \"%QX0.4\", horn = \"%QX0.5\", spare = \"%QX0.6\" }
steps = [{ id = \"lit\", when = { signal = \"lamp\", edge = \"rises\", within = \"1 s\" } }]
invariants = [{ never = { signal = \"horn\" } }]
alarms = [{ name = \"spare\", when = { signal = \"spare\", is = true } }]
";
    assert!(warnings(used).is_empty());
}

#[test]
fn a_guard_band_that_no_measurement_takes_is_reported() {
    let plan = |guard: &str, more: &str| {
        format!(
            "guard = \"{guard}\"\nsignals = {{ lamp = \"%QX0.4\" }}\nexpect = [{{ rises = {{ signal = \"lamp\" }} }}]\n{more}"
        )
    };
    let measure = |keys: &str| format!("measure = [{{ name = \"n\", value-of = \"lamp\"{keys} }}]\n");
    assert_eq!(warnings(&plan("none", "")), ["P0626 3"]);
    // It has no limits, or another guard band.
    assert_eq!(warnings(&plan("none", &measure(""))), ["P0626 3"]);
    assert_eq!(warnings(&plan("none", &measure(", max = 1, guard = \"uncertainty\""))), ["P0626 3"]);
    for taken in [", max = 1", ", min = 0", ", nominal = 1, tolerance = 0"] {
        assert!(warnings(&plan("none", &measure(taken))).is_empty(), "{taken}");
    }
    // What is so without the key is nothing to speak of.
    assert!(warnings(&plan("uncertainty", "")).is_empty());
    let group = "steps = [{ id = \"a\", at = \"start\", run = { group = \"g\" } }]\n[group.g]\n\
                 measure = [{ name = \"n\", value-of = \"lamp\", max = 1 }]\n";
    assert!(warnings(&plan("none", group)).is_empty());
}

#[test]
fn a_step_that_the_end_cuts_off_is_reported() {
    let plan = |ends: &str| {
        format!(
            "signals = {{ button = \"%IX0.0\" }}
ends = \"{ends}\"
steps = [
  {{ id = \"press\", at = \"start + 1 s\", pulse = {{ signal = \"button\", width = \"2 s\" }} }},
  {{ id = \"hot\", at = \"start + 1 s\", fault = {{ signal = \"button\", kind = \"open\", duration = \"1 h\" }} }},
]
expect = [{{ state = {{ stays = \"RUNNING\" }} }}]
"
        )
    };
    assert_eq!(warnings(&plan("start + 2 s")), ["P0624 6"]);
    assert!(warnings(&plan("start + 3 s")).is_empty());
}

#[test]
fn a_claim_that_counts_on_a_watchdog_that_is_off_is_reported() {
    let plan = |enabled: bool, claim: &str| {
        format!(
            "ends = \"start + 10 s\"
settings = {{ mast = {{ watchdog = \"100 ms\", enabled = {enabled} }} }}
signals = {{ tripped = {{ task = \"MAST\", figure = \"exceptions\" }} }}
steps = [{{ id = \"busy\", at = \"start + 1 s\", overload = {{ task = \"MAST\", cycle = \"150 ms\" }} }}]
expect = [{{ value = {{ of = \"tripped\", max = 1 }} }}, {claim}]
"
        )
    };
    let halts = "{ state = { becomes = \"HALT\", from = \"busy\", within = \"100 ms .. 101 ms\" } }";
    assert_eq!(warnings(&plan(false, halts)), ["P0625 7"]);
    assert!(warnings(&plan(true, halts)).is_empty());
    assert_eq!(warnings(&plan(false, "{ value = { of = \"tripped\", is = 1 } }")), ["P0625 7"]);
    assert!(warnings(&plan(false, "{ value = { of = \"tripped\", is = 0 } }")).is_empty());
    // After three seconds the system watchdog may be it.
    let late = "{ state = { becomes = \"HALT\", from = \"busy\", within = \"3 s .. 3.1 s\" } }";
    assert!(warnings(&plan(false, late)).is_empty());
}

#[test]
fn limits_closer_than_a_channel_samples_are_reported() {
    let blind = |within: &str, sampling: Sampling| {
        let text = format!(
            "format = 1\nprogram = \"a.st\"\nends = \"start + 10 s\"\nexpect = [{{ rises = {{ signal = \"lamp\", within = \"{within}\" }} }}]\n"
        );
        let case = read(&SourceFile::new("a.toml", text), &[], 1).unwrap().case(0).unwrap();
        let infos = [SignalInfo { sampling, ..SignalInfo::exact("lamp", ValueKind::Bool) }];
        matches!(doubt(&*case.expectations[0].claim, &infos, &|_| None), Some(Doubt::Blind(_)))
    };
    let sampled = Sampling::Sampled { period: Span::from_millis(10) };
    assert!(blind("100 ms .. 109 ms", sampled) && blind("9 ms", sampled));
    assert!(!blind("100 ms .. 110 ms", sampled) && !blind("10 ms", sampled) && !blind("5 ms ..", sampled));
    let stamped = Sampling::Edges { resolution: Span::from_micros(20) };
    assert!(blind("100 ms ± 9 us", stamped) && !blind("100 ms ± 10 us", stamped));
}
