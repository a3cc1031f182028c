//! Changes about the end of a case, against an oracle that tries every placement: what comes at the end or later is not of
//! the case.

use proptest::prelude::*;
use record::Verdict;
use signal::{Sampling, Span};

use crate::oracle_unseen::{Change, END, verdict};

/// What is claimed, in TOML, and whether it holds of a line whose changes all come before the end.
type Claim = (&'static str, fn(&[(i64, bool)]) -> bool);

fn rises(line: &[(i64, bool)]) -> usize {
    line.windows(2).filter(|pair| !pair[0].1 && pair[1].1).count()
}

const CLAIMS: &[Claim] = &[
    (r#"{ edges = { signal = "q", rising = 0, from = "a" } }"#, |line| rises(line) == 0),
    (r#"{ edges = { signal = "q", rising = 1, from = "a" } }"#, |line| rises(line) == 1),
    (r#"{ never = { signal = "q", from = "a" } }"#, |line| line.iter().all(|change| !change.1)),
    (r#"{ value = { of = "q", is = false, when = "end" } }"#, |line| {
        line.last().is_some_and(|change| !change.1)
    }),
    (r#"{ rises = { signal = "q", from = "a" } }"#, |line| rises(line) > 0),
    (r#"{ rises = { signal = "q", from = "a", within = "115 ns" } }"#, |line| rises(line) > 0),
    (r#"{ order = { edges = ["q rises", "q falls"], from = "a" } }"#, |line| {
        rises(line) > 0 && line.windows(2).any(|pair| pair[0].1 && !pair[1].1)
    }),
    (r#"{ name = "t", from = "a", to = { signal = "q", edge = "rises" }, max = "1 us" }"#, |line| {
        rises(line) > 0
    }),
    (r#"{ name = "m", value-of = "q", take = "max", from = "a", max = 0 }"#, |line| {
        line.iter().all(|change| !change.1)
    }),
];

proptest! {
    #![proptest_config(ProptestConfig { cases: 800, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn what_may_have_come_before_the_end_leaves_open_whether_it_did(
        changes in prop::collection::vec((0i64..4, 0i64..5), 0..4),
        before in 0i64..8,
        which in 0..CLAIMS.len(),
    ) {
        let mut line: Vec<Change> = vec![(0, 0, false)];
        let (mut at, mut latest) = (END - before, 0);
        for (gap, width) in changes {
            at += gap;
            latest = latest.max(at + width);
            let on = line.len() % 2 == 1;
            line.push((at, latest, on));
        }
        let claim = &CLAIMS[which];
        let (mut some, mut other) = (false, false);
        let mut times: Vec<i64> = line.iter().map(|change| change.0).collect();
        loop {
            if times.windows(2).all(|pair| pair[0] <= pair[1]) {
                let placed = times.iter().zip(&line).map(|(at, change)| (*at, change.2));
                let of_the_case: Vec<(i64, bool)> = placed.filter(|change| change.0 < END).collect();
                if claim.1(&of_the_case) { some = true } else { other = true }
            }
            let Some(next) = (0..line.len()).find(|at| times[*at] < line[*at].1) else { break };
            times[next] += 1;
            for at in 0..next {
                times[at] = line[at].0;
            }
        }
        // At the very end the order of the trace would decide, which is not drawn.
        prop_assume!(line.iter().all(|change| change.0 != END && change.1 != END));
        let expected = match (some, other) {
            (true, false) => Verdict::Pass,
            (false, true) => Verdict::Fail,
            _ => Verdict::Inconclusive,
        };
        let found = verdict(claim.0, &line, 5, Sampling::Edges { resolution: Span::from_nanos(5) });
        prop_assert!(found == expected || found == Verdict::Inconclusive, "{found:?}, not {expected:?}: {} {line:?}", claim.0);
        // Where the line has one change, only its place decides.
        let exactly = line.len() <= 2 && !claim.0.contains("order");
        prop_assert!(!exactly || found == expected, "{found:?}, not {expected:?}: {} {line:?}", claim.0);
    }
}
