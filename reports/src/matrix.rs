//! Which requirement is proved by which cases.

use crate::show::ShownOutcome;
use record::{RunRecord, Verdict};
use std::collections::BTreeMap;

/// A requirement and what the run says of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RequirementRow {
    /// Its ID: `controller:WD-04`.
    pub id: String,
    /// The greatest verdict of the judged cases that prove it; none when none was judged.
    pub verdict: Verdict,
    /// Places in the run of the cases that name it, in the run's order.
    pub cases: Vec<usize>,
}

/// Every requirement that a case of the run names, in the order of their IDs (numbers in them by value).
pub fn requirements(run: &RunRecord) -> Vec<RequirementRow> {
    let mut rows: BTreeMap<(String, u64, &str), RequirementRow> = BTreeMap::new();
    for (place, case) in run.cases.iter().enumerate() {
        let verdict = match ShownOutcome::of(case) {
            ShownOutcome::Judged(verdict) => verdict,
            ShownOutcome::Skipped | ShownOutcome::NotApplicable => Verdict::None,
        };
        for id in &case.proves {
            let row = rows.entry(key(id)).or_insert_with(|| RequirementRow {
                id: id.clone(),
                verdict: Verdict::None,
                cases: Vec::new(),
            });
            row.verdict = row.verdict.and(verdict);
            if row.cases.last() != Some(&place) {
                row.cases.push(place);
            }
        }
    }
    rows.into_values().collect()
}

/// Sorts `WD-9` before `WD-10`.
fn key(id: &str) -> (String, u64, &str) {
    let stem = id.trim_end_matches(|c: char| c.is_ascii_digit());
    (stem.to_owned(), id[stem.len()..].parse().unwrap_or(0), id)
}

#[cfg(test)]
mod tests {
    use super::*;
    use record::{CaseRecord, Provenance};

    #[test]
    fn the_worst_case_decides_and_an_unjudged_one_proves_nothing() {
        let mut run = RunRecord::new("", Provenance::default());
        for (name, verdict, proves) in [
            ("a", Verdict::Pass, vec!["controller:WD-10", "controller:WD-9"]),
            ("b", Verdict::Fail, vec!["controller:WD-10", "controller:WD-10"]),
        ] {
            let proves = proves.into_iter().map(str::to_owned).collect();
            run.push(CaseRecord { name: name.into(), verdict, proves, ..CaseRecord::default() });
        }
        let mut unjudged = CaseRecord::not_applicable("c", "no wire");
        unjudged.proves = vec!["io:STD-HSC-11".into()];
        run.push(unjudged);
        let rows = requirements(&run);
        let seen: Vec<_> = rows.iter().map(|r| (r.id.as_str(), r.verdict, r.cases.as_slice())).collect();
        assert_eq!(
            seen,
            [
                ("controller:WD-9", Verdict::Pass, &[0][..]),
                ("controller:WD-10", Verdict::Fail, &[0, 1][..]),
                ("io:STD-HSC-11", Verdict::None, &[2][..]),
            ]
        );
    }
}
