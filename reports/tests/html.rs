//! The page is well-formed, self-contained, of bearable size, and shows hostile names without obeying them.

mod fixture;
mod markup;

use proptest::prelude::*;
use record::*;
use scanrig_reports::html;
use signal::{Kind, SignalInfo, Time, Value, When};
use std::collections::BTreeSet;

fn page(run: &RunRecord) -> (String, Vec<markup::Element>) {
    let text = html::render(run).unwrap();
    let elements = markup::read(&text).unwrap_or_else(|fault| panic!("{fault}"));
    (text, elements)
}

#[test]
fn coverage_is_a_table() {
    let mut run = fixture::example();
    let hostile = "a<b>&\u{1b}[31m.st";
    run.coverage.push(FileCoverage {
        file: hostile.into(),
        statements: 8,
        statements_run: 7,
        branches: 4,
        branches_run: 4,
        lines_missed: vec![[3, 3], [7, 9]],
        ..FileCoverage::default()
    });
    let (text, elements) = page(&run);
    assert!(elements.iter().any(|e| e.get("id") == Some("coverage")));
    for words in ["7 of 8 (87.5 %)", "4 of 4 (100.0 %)", "3, 7-9", "a&lt;b&gt;&amp;"] {
        assert!(text.contains(words), "{words} is missing");
    }
    let (plain, _) = page(&fixture::example());
    assert!(!plain.contains("Lines not run"));
}

#[test]
fn the_example_is_well_formed_and_its_links_lead_somewhere() {
    let (text, elements) = page(&fixture::example());
    let ids: Vec<&str> = elements.iter().filter_map(|e| e.get("id")).collect();
    let unique: BTreeSet<&str> = ids.iter().copied().collect();
    assert_eq!(ids.len(), unique.len(), "an ID appears twice");
    let links = elements.iter().filter_map(|e| e.get("href"));
    for link in links {
        assert!(unique.contains(link.trim_start_matches('#')), "{link} leads nowhere");
    }
    assert_eq!(elements.iter().filter(|e| e.get("class") == Some("diagram")).count(), 5);
    for fact in [
        "m241-2019",
        "eeeeeeeeeeee",
        "-400 us",
        "MAST lamp.st:12",
        "never taken",
        "needs pulse &gt;= 200 kHz",
    ] {
        assert!(text.contains(fact), "{fact} is missing");
    }
}

#[test]
fn nothing_is_fetched() {
    let (text, elements) = page(&fixture::example());
    assert!(text.contains("default-src 'none'"));
    let outside = |e: &&markup::Element| e.get("src").is_some() || e.name == "link" || e.name == "img";
    assert!(!elements.iter().any(|e| outside(&e)));
    assert!(!text.replace("http://www.w3.org/2000/svg", "").contains("://"), "an address of the network");
}

#[test]
fn hostile_names_stay_text() {
    let (text, elements) = page(&fixture::hostile());
    assert_eq!(elements.iter().filter(|e| e.name == "script").count(), 1);
    assert!(elements.iter().all(|e| e.attributes.iter().all(|(key, _)| !key.starts_with("on"))));
    assert!(text.contains("&lt;script&gt;alert(1)"), "hostile names are shown");
}

#[test]
fn sixty_busy_cases_stay_under_two_megabytes() {
    let mut run = fixture::example();
    let busy = run.cases[2].clone();
    for n in 0..60 {
        let mut case = busy.clone();
        case.name = format!("busy/case[{n}]");
        case.claims.truncate(1);
        case.claims[0].window = None;
        case.claims[0].deciding_ns = None;
        case.measurements.clear();
        case.steps.clear();
        for lane in 0..6 {
            let mut dense = Lane::of(&SignalInfo::exact(
                format!("s{lane}"),
                if lane == 0 { Kind::Real } else { Kind::Bool },
            ));
            for at in 0..MAX_LANE_POINTS as i64 {
                let value =
                    if lane == 0 { Value::Real((at * 7 % 100) as f64) } else { Value::Bool(at % 2 == 0) };
                dense.push(When::exactly(Time::from_nanos(at * 1_700_000)), value);
            }
            case.lanes.push(dense);
        }
        run.push(case);
    }
    let (text, _) = page(&run);
    assert!(text.len() < 2_000_000, "{} bytes", text.len());
}

#[test]
fn what_lies_after_an_excerpt_is_drawn_as_unknown() {
    let run = RunRecord::new("", Provenance::default());
    let mut case = CaseRecord { end_ns: 1_000, duration_ns: 1_000, ..CaseRecord::default() };
    let mut lane = Lane::of(&SignalInfo::exact("lamp", Kind::Bool));
    lane.push(When::exactly(Time::ZERO), Value::Bool(true));
    case.lanes.push(lane);
    let unknown = |case: &CaseRecord| {
        let mut run = run.clone();
        run.push(case.clone());
        page(&run).1.iter().filter(|e| e.get("class") == Some("unknown")).count()
    };
    assert_eq!(unknown(&case), 0);
    // A claim decided after the excerpt: the lane must not seem to have stayed.
    case.lanes[0].until_ns = Some(500);
    case.claims.push(ClaimRecord { deciding_ns: Some([900, 900]), ..ClaimRecord::default() });
    case.claims.push(ClaimRecord { deciding_ns: Some([300, 300]), ..ClaimRecord::default() });
    assert_eq!(unknown(&case), 1);
}

#[test]
fn an_empty_run_has_a_page_that_claims_nothing() {
    let (text, _) = page(&RunRecord::new("0.1.0", Provenance::default()));
    assert!(text.contains("Nothing was judged"));
}

fn any_at() -> impl Strategy<Value = [i64; 2]> {
    let near = (-50i64..1_000, 0i64..40).prop_map(|(at, width)| [at, at + width]);
    let far = (any::<i64>(), any::<i64>()).prop_map(|(a, b)| [a.min(b), a.max(b)]);
    prop_oneof![8 => near, 1 => far]
}

fn any_lane() -> impl Strategy<Value = Lane> {
    let value = prop_oneof![
        4 => (0i64..2).prop_map(|n| LaneValue::Number(n as f64)),
        1 => any::<f64>().prop_map(LaneValue::Number),
        1 => Just(LaneValue::HighZ),
        1 => Just(LaneValue::Unknown),
    ];
    let kind = prop_oneof![Just(LaneKind::Digital), Just(LaneKind::Analog), Just(LaneKind::State)];
    let points =
        prop::collection::vec((any_at(), value).prop_map(|(at, value)| LanePoint { at, value }), 0..40);
    (kind, points, any::<bool>(), prop::option::of(any::<i64>())).prop_map(
        |(kind, points, truncated, until_ns)| Lane {
            signal: "s".into(),
            kind,
            points,
            truncated,
            until_ns,
            ..Lane::default()
        },
    )
}

fn any_claim() -> impl Strategy<Value = ClaimRecord> {
    let verdict = prop_oneof![
        Just(Verdict::Pass),
        Just(Verdict::Fail),
        Just(Verdict::Inconclusive),
        Just(Verdict::None)
    ];
    let window = prop::option::of((any_at(), any_at(), prop::option::of(any_at())));
    (verdict, window, prop::option::of(any_at())).prop_map(|(verdict, window, deciding_ns)| ClaimRecord {
        verdict,
        deciding_ns,
        signal: Some("s".into()),
        window: window.map(|(from_ns, until_ns, limits)| Window {
            from_ns,
            until_ns,
            limit_from_ns: limits.map(|l| l[0]),
            limit_until_ns: limits.map(|l| l[1]),
        }),
        ..ClaimRecord::default()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]
    #[test]
    fn whatever_the_record_the_drawing_is_well_formed(
        lanes in prop::collection::vec(any_lane(), 1..4),
        claims in prop::collection::vec(any_claim(), 0..5),
        anchors in any_at(),
        measured in prop::collection::vec((any_at(), any_at(), any::<[f64; 2]>(), any::<f64>()), 0..3),
    ) {
        let [start_ns, end_ns] = anchors;
        let measurements = measured.into_iter().map(|(from, to, value, max)| MeasurementRecord {
            value: Some(value), max: Some(max), from_ns: Some(from), to_ns: Some(to), unit: "ns".into(),
            ..MeasurementRecord::default()
        });
        let case = CaseRecord {
            name: "a/b".into(), lanes, claims, start_ns, end_ns, duration_ns: end_ns,
            measurements: measurements.collect(),
            ..CaseRecord::default()
        };
        let mut run = RunRecord::new("", Provenance::default());
        run.push(case);
        let (text, elements) = page(&run);
        prop_assert!(elements.iter().any(|e| e.get("class") == Some("diagram")));
        prop_assert!(!text.contains("\"NaN\"") && !text.contains("\"inf"));
    }
}
