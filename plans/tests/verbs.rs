//! What the manual says of every verb and of every kind of measurement: claims without evidence are inconclusive, and on
//! a channel that is only sampled it depends on what one more pulse could do to them.

use std::collections::BTreeSet;

use scanrig_plans::expect;

use crate::goldens::Golden;

/// A claim of each verb, or several, that counts from the instant IT.
const CLAIMS: &[&str] = &[
    r#"{ rises = { signal = "q", from = "IT" } }"#,
    r#"{ rises = { signal = "q", from = "IT", within = "10 ns .. 50 ns" } }"#,
    r#"{ falls = { signal = "q", from = "IT" } }"#,
    r#"{ changes = { signal = "n", from = "IT" } }"#,
    r#"{ becomes = { signal = "n", is = 5, from = "IT" } }"#,
    r#"{ stays = { signal = "q", is = false, from = "IT" } }"#,
    r#"{ never = { signal = "q", from = "IT" } }"#,
    r#"{ never = { all = ["q", "r"], from = "IT" } }"#,
    r#"{ edges = { signal = "q", rising = 0, from = "IT" } }"#,
    r#"{ edges = { signal = "q", rising = 3, from = "IT" } }"#,
    r#"{ pulse = { signal = "q", width = "10 ns", from = "IT" } }"#,
    r#"{ pulse = { signal = "q", width = "10 ns", which = "every", from = "IT" } }"#,
    r#"{ period = { signal = "q", is = "100 ns", from = "IT" } }"#,
    r#"{ frequency = { signal = "q", min = "1 MHz", from = "IT" } }"#,
    r#"{ duty = { signal = "q", max = "60 %", from = "IT" } }"#,
    r#"{ jitter = { signal = "q", max = "1 us", from = "IT" } }"#,
    r#"{ speed = { signal = "n", max = "1 MHz", from = "IT" } }"#,
    r#"{ phase = { of = "r", reference = "q", is = "90 deg ± 10 deg", from = "IT" } }"#,
    r#"{ position = { signal = "q", is = 0, from = "IT" } }"#,
    r#"{ position = { signal = "q", is = 3, from = "IT" } }"#,
    r#"{ position = { signal = "q", direction = "r", is = 0, from = "IT" } }"#,
    r#"{ position = { signal = "q", down = "r", is = 3, from = "IT" } }"#,
    r#"{ position = { signal = "q", quadrature = "r", is = 0, from = "IT" } }"#,
    r#"{ position = { signal = "n", is = 0, from = "IT" } }"#,
    r#"{ position = { signal = "n", is = 3, from = "IT" } }"#,
    r#"{ profile = { signal = "q", points = [{ at = "0 ns", frequency = "1 MHz" }], tolerance = "900 kHz", from = "IT" } }"#,
    r#"{ settles = { signal = "n", is = "5 .. 6", from = "IT", within = "100 ns" } }"#,
    r#"{ follows = { signal = "n", leader = "m", from = "IT" } }"#,
    r#"{ state = { is = "RUNNING", when = "IT" } }"#,
    r#"{ state = { becomes = "RUNNING", from = "IT" } }"#,
    r#"{ state = { stays = "RUNNING", from = "IT" } }"#,
    r#"{ led = { name = "RUN", is = "on", when = "IT" } }"#,
    r#"{ led = { name = "RUN", becomes = "on", from = "IT" } }"#,
    r#"{ led = { name = "RUN", stays = "on", from = "IT" } }"#,
    r#"{ log = { contains = "halt", from = "IT" } }"#,
    r#"{ log = { never = "halt", from = "IT" } }"#,
    r#"{ frames = { frame = "n", count = 0, from = "IT" } }"#,
    r#"{ frames = { frame = "n", count = 3, from = "IT" } }"#,
    r#"{ frames = { frame = "n", cycle = "10 ns", from = "IT" } }"#,
    r#"{ frames = { frame = "n", max-gap = "400 ns", from = "IT" } }"#,
    r#"{ task = { name = "MAST", figure = "lost", is = 0, when = "IT" } }"#,
    r#"{ task = { name = "MAST", figure = "lost", is = 0, from = "IT" } }"#,
    r#"{ value = { of = "q", is = false, when = "IT" } }"#,
    r#"{ equal = { left = "n", right = "m", when = "IT" } }"#,
    r#"{ order = { edges = ["q rises", "r rises"], from = "IT" } }"#,
    r#"{ happens = { step = "came", from = "IT" } }"#,
];

/// Limits that what is seen of [`TRAIN`] keeps, each kind of measurement.
const MEASUREMENTS: &[&str] = &[
    r#"{ name = "m", from = "IT", to = { signal = "q", edge = "rises" }, max = "2 us" }"#,
    r#"{ name = "m", value-of = "n", when = "IT", max = 9 }"#,
    r#"{ name = "m", value-of = "n", take = "mean", from = "IT", max = 9 }"#,
    r#"{ name = "m", frequency-of = "q", from = "IT", max = "20 MHz" }"#,
    r#"{ name = "m", duty-of = "q", from = "IT", max = "99 %" }"#,
    r#"{ name = "m", period-of = "q", from = "IT", max = "1 us" }"#,
    r#"{ name = "m", width-of = "q", from = "IT", max = "1 us" }"#,
    r#"{ name = "m", speed-of = "n", from = "IT", max = "1 GHz" }"#,
    r#"{ name = "m", jitter-of = "q", from = "IT", max = "1 us" }"#,
    r#"{ name = "m", position-of = { signal = "q" }, from = "IT", max = 9 }"#,
    r#"{ name = "m", position-of = { signal = "q", quadrature = "r" }, from = "IT", min = 3 }"#,
    r#"{ name = "m", profile-of = { signal = "q", points = [{ at = "0 ns", frequency = "9 MHz" }] }, from = "IT", max = "9 MHz" }"#,
];

const LINES: [(&str, &str); 8] = [
    ("q", "bool"),
    ("r", "bool"),
    ("n", "int"),
    ("m", "int"),
    ("state", "state"),
    ("LED.RUN", "led"),
    ("log:halt", "int"),
    ("task:MAST:lost", "int"),
];

/// A golden of the lines: with their first values, or with none at all.
fn check(claim: &str, known: bool, wanted: &str) {
    let mut block = format!("# {claim}\n");
    for (name, kind) in LINES {
        block.push_str(&format!("{name} {kind}\n"));
    }
    for (name, kind) in LINES.iter().filter(|_| known) {
        let first = match *kind {
            "bool" => "FALSE",
            "state" => "2",
            "led" => "off",
            _ => "0",
        };
        block.push_str(&format!("0 {name} {first}\n"));
    }
    block.push_str(&format!("500 step:came\nend 1000\ntrain gone q\n{claim}\n{wanted}\n"));
    Golden::parse(&block).check();
}

#[test]
fn an_instant_that_never_came_leaves_every_verb_open() {
    let named: BTreeSet<&str> = CLAIMS.iter().map(|claim| claim.split(' ').nth(1).unwrap()).collect();
    assert_eq!(named, expect::VERBS.iter().map(|verb| verb.name).collect());
    for claim in CLAIMS.iter().chain(MEASUREMENTS) {
        let claim = claim.replace("IT", "gone");
        check(&claim, true, "verdict inconclusive\nreason `gone` never came");
    }
}

#[test]
fn a_signal_that_was_never_observed_leaves_every_verb_open() {
    // That a step came is seen without a signal.
    for claim in CLAIMS.iter().filter(|claim| !claim.contains("happens")).chain(MEASUREMENTS) {
        check(&claim.replace("IT", "start"), false, "verdict inconclusive");
    }
}

/// Two lines with three pulses each, the second 20 ns after the first; a value that is 1 from 200 on and one that
/// follows it, all read every 10 ns; and the instant before the pulses.
const TRAIN: &str = "q bool sampled 10\nr bool sampled 10\nn int sampled 10\nm int sampled 10\n\
    0 q FALSE\n0 r FALSE\n0 n 0\n0 m 0\n100 step:a\n\
    [190, 200] q TRUE\n[190, 200] n 1\n[200, 210] m 1\n[210, 220] r TRUE\n\
    [240, 250] q FALSE\n[260, 270] r FALSE\n[290, 300] q TRUE\n[310, 320] r TRUE\n\
    [340, 350] q FALSE\n[360, 370] r FALSE\n[390, 400] q TRUE\n[410, 420] r TRUE\n\
    [440, 450] q FALSE\n[460, 470] r FALSE\nend 1000\n";

/// What comes of a claim about the train: without more, and with pulses that do not count up to what the channel sees.
fn sampled(claim: &str, alone: &str, with: &str) {
    Golden::parse(&format!("# {claim}\n{TRAIN}{claim}\nverdict {alone}")).check();
    let end = if claim.ends_with("} }") { "} }" } else { "}" };
    let place = claim.rfind(end).unwrap();
    let more = format!("{}, pulses-longer-than = \"10 ns\" {}", claim[..place].trim_end(), &claim[place..]);
    if !with.is_empty() {
        Golden::parse(&format!("# {more}\n{TRAIN}{more}\nverdict {with}")).check();
    }
}

#[test]
fn where_an_edge_is_wanted_what_was_seen_decides() {
    for (claim, verdict) in [
        (r#"{ rises = { signal = "q", from = "a", within = "110 ns" } }"#, "pass"),
        (r#"{ falls = { signal = "q", from = "a", within = "160 ns" } }"#, "pass"),
        (r#"{ changes = { signal = "n", from = "a", within = "110 ns" } }"#, "pass"),
        (r#"{ becomes = { signal = "n", is = 1, from = "a", within = "110 ns" } }"#, "pass"),
        (r#"{ becomes = { signal = "n", is = 5, from = "a" } }"#, "fail"),
        (r#"{ rises = { signal = "q", from = "a", within = "50 ns" } }"#, "fail"),
        (r#"{ changes = { signal = "n", from = "a + 200 ns" } }"#, "fail"),
        (r#"{ value = { of = "q", is = true, when = "a + 120 ns" } }"#, "pass"),
        (r#"{ equal = { left = "n", right = "m", when = "end" } }"#, "pass"),
        (r#"{ speed = { signal = "n", is = "1 MHz ± 20 %", from = "a" } }"#, "pass"),
        (r#"{ happens = { step = "a", from = "start", within = "1 us" } }"#, "pass"),
    ] {
        sampled(claim, verdict, "");
    }
}

#[test]
fn where_a_pulse_could_break_it_a_claim_needs_the_promise_that_there_was_none() {
    for (claim, alone, with) in [
        (r#"{ rises = { signal = "q", from = "a", within = "50 ns .. 110 ns" } }"#, "inconclusive", "pass"),
        (r#"{ falls = { signal = "q", from = "a", within = "50 ns .. 160 ns" } }"#, "inconclusive", "pass"),
        (r#"{ changes = { signal = "q", from = "a", within = "50 ns .. 110 ns" } }"#, "inconclusive", "pass"),
        (
            r#"{ becomes = { signal = "n", is = 1, from = "a", within = "50 ns .. 110 ns" } }"#,
            "inconclusive",
            "pass",
        ),
        (r#"{ order = { edges = ["q rises", "r rises"], from = "a" } }"#, "inconclusive", "pass"),
        (r#"{ stays = { signal = "q", is = false, until = "a + 50 ns" } }"#, "inconclusive", "pass"),
        (r#"{ never = { signal = "q", until = "a + 50 ns" } }"#, "inconclusive", "pass"),
        (r#"{ never = { all = ["q", "r"], until = "a + 50 ns" } }"#, "inconclusive", "pass"),
        (
            r#"{ settles = { signal = "n", is = "1 .. 2", from = "a", within = "110 ns" } }"#,
            "inconclusive",
            "pass",
        ),
        // What was seen to be wrong.
        (r#"{ rises = { signal = "q", from = "a", within = "150 ns .. 300 ns" } }"#, "fail", "fail"),
        (r#"{ falls = { signal = "q", from = "a", within = "200 ns .. 300 ns" } }"#, "fail", "fail"),
        (r#"{ changes = { signal = "q", from = "a", within = "150 ns .. 300 ns" } }"#, "fail", "fail"),
        (
            r#"{ becomes = { signal = "n", is = 1, from = "a", within = "150 ns .. 300 ns" } }"#,
            "fail",
            "fail",
        ),
        (r#"{ order = { edges = ["r rises", "q rises"], from = "a" } }"#, "fail", "fail"),
        (r#"{ stays = { signal = "q", is = false, from = "a" } }"#, "fail", "fail"),
        (r#"{ never = { signal = "q", from = "a" } }"#, "fail", "fail"),
        (r#"{ never = { all = ["q", "r"], from = "a" } }"#, "fail", "fail"),
        (r#"{ settles = { signal = "n", is = "5 .. 6", from = "a", within = "110 ns" } }"#, "fail", "fail"),
    ] {
        sampled(claim, alone, with);
    }
    // For two values the time for which they may differ is what may go unseen.
    for (claim, verdict) in [
        (r#"{ follows = { signal = "m", leader = "n", from = "a + 150 ns" } }"#, "inconclusive"),
        (r#"{ follows = { signal = "m", leader = "n", within = "20 ns", from = "a" } }"#, "pass"),
        (r#"{ follows = { signal = "m", leader = "q", from = "a" } }"#, "fail"),
    ] {
        sampled(claim, verdict, "");
    }
}

#[test]
fn where_pulses_are_counted_a_claim_needs_the_promise_that_none_was_missed() {
    for (claim, alone, with) in [
        (r#"{ edges = { signal = "q", rising = 3, from = "a" } }"#, "inconclusive", "pass"),
        (r#"{ pulse = { signal = "q", width = "40 ns .. 60 ns", from = "a" } }"#, "inconclusive", "pass"),
        (
            r#"{ pulse = { signal = "q", width = "40 ns .. 60 ns", which = "every", from = "a" } }"#,
            "inconclusive",
            "pass",
        ),
        (r#"{ period = { signal = "q", is = "80 ns .. 120 ns", from = "a" } }"#, "inconclusive", "pass"),
        (r#"{ frequency = { signal = "q", is = "10 MHz ± 20 %", from = "a" } }"#, "inconclusive", "pass"),
        (r#"{ duty = { signal = "q", is = "50 % ± 20 %", from = "a" } }"#, "inconclusive", "pass"),
        (r#"{ jitter = { signal = "q", max = "50 ns", from = "a" } }"#, "inconclusive", "pass"),
        (
            r#"{ phase = { of = "r", reference = "q", is = "20 deg .. 120 deg", from = "a" } }"#,
            "inconclusive",
            "pass",
        ),
        (r#"{ position = { signal = "q", is = 3, from = "a" } }"#, "inconclusive", "pass"),
        (
            r#"{ profile = { signal = "q", points = [{ at = "0 ns", frequency = "10 MHz" }], tolerance = "9 MHz", from = "a + 50 ns", until = "a + 350 ns" } }"#,
            "inconclusive",
            "pass",
        ),
        // Too few may have been missed, too many are too many.
        (r#"{ edges = { signal = "q", rising = 4, from = "a" } }"#, "inconclusive", "fail"),
        (r#"{ edges = { signal = "q", rising = 2, from = "a" } }"#, "fail", "fail"),
        (r#"{ period = { signal = "q", is = "1 ns .. 20 ns", from = "a" } }"#, "inconclusive", "fail"),
        (r#"{ period = { signal = "q", is = "200 ns .. 300 ns", from = "a" } }"#, "fail", "fail"),
        (r#"{ pulse = { signal = "q", width = "1 ns .. 20 ns", from = "a" } }"#, "inconclusive", "fail"),
        (r#"{ frequency = { signal = "q", is = "1 MHz", from = "a" } }"#, "inconclusive", "fail"),
        (r#"{ duty = { signal = "q", is = "5 % .. 10 %", from = "a" } }"#, "inconclusive", "fail"),
        (r#"{ jitter = { signal = "q", is = "1 us .. 2 us", from = "a" } }"#, "inconclusive", "fail"),
        (
            r#"{ phase = { of = "r", reference = "q", is = "170 deg .. 190 deg", from = "a" } }"#,
            "inconclusive",
            "fail",
        ),
        (r#"{ position = { signal = "q", is = 4, from = "a" } }"#, "inconclusive", "fail"),
    ] {
        sampled(claim, alone, with);
    }
}

#[test]
fn a_measurement_of_a_sampled_channel_is_open_unless_what_was_seen_decides() {
    for claim in [
        r#"{ name = "m", from = "start", to = "a", max = "2 us" }"#,
        r#"{ name = "m", value-of = "n", when = "a + 50 ns", max = 9 }"#,
        r#"{ name = "m", speed-of = "n", from = "a", max = "1 GHz" }"#,
        r#"{ name = "m", from = "a", to = { signal = "q", edge = "rises" }, max = "2 us" }"#,
    ] {
        sampled(claim, "pass", "");
    }
    for claim in [
        r#"{ name = "m", from = "a", to = { signal = "q", edge = "rises" }, min = "50 ns" }"#,
        r#"{ name = "m", value-of = "n", take = "min", from = "a", min = 0 }"#,
        r#"{ name = "m", value-of = "n", take = "max", from = "a", max = 9 }"#,
        r#"{ name = "m", value-of = "n", take = "span", from = "a", max = 9 }"#,
        r#"{ name = "m", value-of = "n", take = "mean", from = "a", max = 9 }"#,
        r#"{ name = "m", value-of = "n", take = "rms", from = "a", max = 9 }"#,
        r#"{ name = "m", frequency-of = "q", from = "a", max = "20 MHz" }"#,
        r#"{ name = "m", duty-of = "q", from = "a", max = "99 %" }"#,
        r#"{ name = "m", period-of = "q", from = "a", max = "1 us" }"#,
        r#"{ name = "m", width-of = "q", from = "a", max = "1 us" }"#,
        r#"{ name = "m", jitter-of = "q", from = "a", max = "1 us" }"#,
    ] {
        sampled(claim, "inconclusive", "pass");
    }
    // The keys of a pulse train stand in a table of their own.
    let position = r#"{ name = "m", position-of = { signal = "q"MORE }, from = "a", max = 9 }"#;
    let profile = r#"{ name = "m", profile-of = { signal = "q"MORE, points = [{ at = "0 ns", frequency = "10 MHz" }] }, from = "a + 50 ns", until = "a + 350 ns", max = "9 MHz" }"#;
    for claim in [position, profile] {
        sampled(&claim.replace("MORE", ""), "inconclusive", "");
        sampled(&claim.replace("MORE", ", pulses-longer-than = \"10 ns\""), "pass", "");
    }
    sampled(r#"{ name = "m", value-of = "n", take = "max", from = "a", max = 0 }"#, "fail", "fail");
}
