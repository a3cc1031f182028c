//! What stands in the file: well-formed, self-contained, of bearable size, with the record whole. What the script
//! makes of it is tested in a browser (tests/browser.py).

use record::*;
use scanrig_reports::html;
use serde_json::Value as Json;
use sha2::{Digest, Sha256};
use signal::{SignalInfo, Time, Value, ValueKind, When};

fn page(run: &RunRecord) -> (String, Vec<crate::markup::Element>) {
    let text = html::render(run).unwrap();
    let elements = crate::markup::read(&text).unwrap_or_else(|fault| panic!("{fault}"));
    (text, elements)
}

/// The text between `from` and `to`, which must be there.
fn between<'a>(text: &'a str, from: &str, to: &str) -> &'a str {
    let rest = text.split_once(from).unwrap_or_else(|| panic!("no {from}")).1;
    rest.split_once(to).unwrap_or_else(|| panic!("no {to}")).0
}

fn base64(text: &str) -> Vec<u8> {
    let digit = |c: u8| match c {
        b'A'..=b'Z' => c - b'A',
        b'a'..=b'z' => c - b'a' + 26,
        b'0'..=b'9' => c - b'0' + 52,
        b'+' => 62,
        b'/' => 63,
        other => panic!("{other} in base64"),
    };
    let digits: Vec<u8> = text.bytes().filter(|c| *c != b'=').map(digit).collect();
    let group = |group: &[u8]| {
        let bits =
            group.iter().fold(0u32, |bits, digit| bits << 6 | u32::from(*digit)) << (6 * (4 - group.len()));
        bits.to_be_bytes()[1..group.len()].to_vec()
    };
    digits.chunks(4).flat_map(group).collect()
}

/// The record that the page carries.
fn carried(page: &str) -> Json {
    let packed = base64(between(page, "id=\"run\">", "</script>"));
    let text = miniz_oxide::inflate::decompress_to_vec_zlib(&packed).unwrap();
    serde_json::from_slice(&text).unwrap()
}

#[test]
fn the_record_is_in_the_page() {
    let run = crate::fixture::drawn();
    let (text, _) = page(&run);
    let read = carried(&text);
    assert_eq!(read["cases"].as_array().unwrap().len(), run.cases.len());
    assert_eq!(read["requirements"][0]["status"], "in part");
    assert_eq!(read["requirements"][0]["clauses"][1]["asks"], "A power cut loses it");
    assert_eq!(read["provenance"]["environment"][0][1], "PREEMPT_RT");
    let case = &read["cases"][1];
    assert_eq!(case["name"], "watchdog/fallback[over]");
    assert_eq!(case["claims"][0]["nearest_miss"], "the fall came 400 us after the latest instant allowed");
    assert_eq!(case["claims"][0]["margin"]["value"], -400_000.0);
    assert_eq!(case["lanes"][0]["changes"].as_array().unwrap().len(), 3 * run.cases[1].lanes[0].points.len());
    assert_eq!(read["cases"][3]["claims"][1]["bounds"]["max"], 650.0);
}

#[test]
fn summary_and_failures_need_no_script() {
    let (text, elements) = page(&crate::fixture::drawn());
    let shown = between(&text, "<main", "</main>").replace("&#x2f;", "/");
    for fact in [
        "watchdog/fallback[over]",
        "the fall came 400 us after the latest instant allowed",
        "-400 us",
        "library/watchdog/fallback.toml:14",
        "the board can0 was lost 1.2 s after start",
        "never taken",
        "<noscript>",
    ] {
        assert!(shown.contains(fact), "{fact} is missing");
    }
    let head = between(&text, "<header", "</header>");
    for fact in [
        "1 of 6 judged cases",
        "8 planned, 6 executed, 1 skipped, 1 not applicable",
        "m241-2019",
        "PREEMPT_RT",
    ] {
        assert!(head.contains(fact), "{fact} is missing");
    }
    assert!(elements.iter().filter(|e| e.name == "article").count() == 3);
}

#[test]
fn what_has_no_record_is_said() {
    let mut run = crate::fixture::drawn();
    run.planned = 12;
    assert!(page(&run).0.contains("12 planned, 6 executed, 1 skipped, 1 not applicable, 4 without a record"));
}

#[test]
fn the_host_clock_says_how_well_it_was_kept() {
    let mut run = crate::fixture::drawn();
    assert!(!page(&run).0.contains("Rig timing</dt>"));
    run.provenance.clock = RunClock::Real;
    assert!(page(&run).0.contains("at most 41 us late, 0 overruns, 0 events dropped"));
}

#[test]
fn coverage_is_a_table() {
    let mut run = crate::fixture::drawn();
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
    let (plain, _) = page(&crate::fixture::drawn());
    assert!(!plain.contains("Lines not run"));
}

#[test]
fn nothing_is_fetched_and_no_other_script_or_style_obeyed() {
    let (text, elements) = page(&crate::fixture::hostile());
    let policy = between(&text, "http-equiv=\"Content-Security-Policy\" content=\"", "\"");
    assert!(policy.starts_with("default-src 'none'; ") && !policy.contains("unsafe"), "{policy}");
    for (kind, open, close) in
        [("style-src", "<style>", "</style>"), ("script-src", "</script>\n<script>", "</script>")]
    {
        let hash = between(policy, &format!("{kind} 'sha256-"), "'");
        assert_eq!(base64(hash), Sha256::digest(between(&text, open, close).as_bytes()).to_vec(), "{kind}");
    }
    let outside = |e: &&crate::markup::Element| e.get("src").is_some() || e.name == "link" || e.name == "img";
    assert!(!elements.iter().any(|e| outside(&e)));
    assert!(
        elements.iter().all(|e| e.attributes.iter().all(|(key, _)| !key.starts_with("on") && key != "style"))
    );
    let own = text.replace("http://www.w3.org/2000/svg", "").replace("://", ":\u{0}");
    assert!(!own.contains(":\u{0}"), "an address of the network");
}

#[test]
fn hostile_names_stay_text() {
    let (text, elements) = page(&crate::fixture::hostile());
    assert_eq!(elements.iter().filter(|e| e.name == "script").count(), 2);
    assert_eq!(text.matches("<script").count(), 2, "a name of the record is a script");
    assert!(text.contains("&lt;script&gt;alert(1)"), "hostile names are shown");
}

#[test]
fn sixty_busy_cases_stay_under_two_megabytes() {
    let mut run = crate::fixture::drawn();
    let busy = run.cases[2].clone();
    for n in 0..60 {
        let mut case = busy.clone();
        case.name = format!("busy/case[{n}]");
        for lane in 0..6 {
            let kind = if lane == 0 { ValueKind::Real } else { ValueKind::Bool };
            let mut dense = Lane::of(&SignalInfo::exact(format!("s{lane}"), kind));
            for at in 0..MAX_LANE_POINTS as i64 {
                let value =
                    if lane == 0 { Value::Real((at * 7 % 100) as f64) } else { Value::Bool(at % 2 == 0) };
                dense.push(When::exactly(Time::from_nanos(at * (1_700_000 + n) + at * at % 977)), value);
            }
            case.lanes.push(dense);
        }
        run.push(case);
    }
    let (text, _) = page(&run);
    assert!(text.len() < 2_000_000, "{} bytes", text.len());
}

#[test]
fn an_empty_run_has_a_page_that_claims_nothing() {
    let (text, _) = page(&RunRecord::new("0.1.0", Provenance::default()));
    assert!(text.contains("Nothing was judged"));
    assert_eq!(carried(&text)["cases"], Json::Array(Vec::new()));
}

#[test]
fn whatever_the_record_there_is_a_page() {
    let run = crate::fixture::extreme::extreme();
    assert_eq!(carried(&page(&run).0)["cases"].as_array().unwrap().len(), run.cases.len());
}
