//! The record of a whole run.

use crate::{CaseRecord, CaseStatus, FileCoverage, Verdict};
use serde::{Deserialize, Serialize};

/// Version of the record's shape that this crate writes. Format 1, in which every field was written, is read, too.
pub const FORMAT: u32 = 2;

/// The oldest version that is read.
pub const OLDEST_FORMAT: u32 = 1;

/// On which clock the cases ran.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RunClock {
    /// Modelled time, from event to event.
    #[default]
    Virtual,
    /// The host's monotonic clock.
    Real,
}

impl RunClock {
    /// The word used in every file and report.
    pub const fn word(self) -> &'static str {
        match self {
            RunClock::Virtual => "virtual",
            RunClock::Real => "real",
        }
    }
}

/// Where the run came from.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Provenance {
    /// SHA-256 of the `rig` binary, 64 hexadecimal digits; empty when it could not be read.
    pub binary_sha256: String,
    /// The host's kernel release; empty when unknown.
    pub kernel: String,
    /// The host's processor, where known.
    pub host_cpu: Option<String>,
    /// Profiles that the cases ran with, in the order of their first use.
    pub profiles: Vec<String>,
    /// Seed of the run, from which the cases' seeds are derived.
    pub seed: u64,
    /// On which clock.
    pub clock: RunClock,
    /// The command line as the user gave it, without the program's own path.
    pub arguments: Vec<String>,
    /// When the run began, RFC 3339; nothing where a reproducible record was asked for.
    pub started: Option<String>,
    /// Nanoseconds of the second in which it began: tells two runs of one second apart.
    #[serde(default)]
    pub started_nanos: u32,
    /// Further facts of the host that figures depend on, name and text: kind of real-time kernel, cores, governor.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub environment: Vec<(String, String)>,
}

/// How many cases came to what.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Totals {
    /// Judged cases that passed.
    pub passed: u64,
    /// Judged cases without a verdict: nothing in them was judged.
    pub none: u64,
    /// Inconclusive cases.
    pub inconclusive: u64,
    /// Failed cases.
    pub failed: u64,
    /// Cases in which the rig had trouble of its own.
    pub errors: u64,
    /// Cases that do not apply.
    pub not_applicable: u64,
    /// Cases left out.
    pub skipped: u64,
}

impl Totals {
    /// Counts the cases.
    pub fn of<'a>(cases: impl IntoIterator<Item = &'a CaseRecord>) -> Totals {
        let mut totals = Totals::default();
        for case in cases {
            totals.count(case);
        }
        totals
    }

    /// Counts one more case.
    pub fn count(&mut self, case: &CaseRecord) {
        *match (&case.status, case.verdict) {
            (CaseStatus::NotApplicable { .. }, _) => &mut self.not_applicable,
            (CaseStatus::Skipped { .. }, _) => &mut self.skipped,
            (CaseStatus::Judged, Verdict::None) => &mut self.none,
            (CaseStatus::Judged, Verdict::Pass) => &mut self.passed,
            (CaseStatus::Judged, Verdict::Inconclusive) => &mut self.inconclusive,
            (CaseStatus::Judged, Verdict::Fail) => &mut self.failed,
            (CaseStatus::Judged, Verdict::Error) => &mut self.errors,
        } += 1;
    }

    /// Number of judged cases.
    pub const fn judged(&self) -> u64 {
        self.passed + self.none + self.inconclusive + self.failed + self.errors
    }
}

/// How many cases of a run were measured without a guard band (`guard = "none"`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Unguarded {
    /// Those with such a measurement.
    pub cases: u64,
    /// Those of them with a verdict that the middle of a value alone decided.
    pub by_middle: u64,
}

/// The record of a run: all that reports read.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RunRecord {
    /// Version of this shape: [`FORMAT`].
    pub format: u32,
    /// Version of the `rig` command.
    pub rig_version: String,
    /// Where it came from.
    pub provenance: Provenance,
    /// How many cases came to what; kept by [`RunRecord::push`].
    pub totals: Totals,
    /// How many cases the run was to have; 0 in a record of a rig that did not say.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub planned: u64,
    /// The cases, in the order in which the plans were given.
    pub cases: Vec<CaseRecord>,
    /// Which part of a suite it is: `[K, N]`, part K of N from 1; nothing where it is the whole.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shard: Option<[u32; 2]>,
    /// SHA-256 of what was selected before it was spread over shards: the cases in their order, with their plans and
    /// seeds. Parts of one suite have it in common. 64 hexadecimal digits; empty where it was not made.
    #[serde(default)]
    pub selection_sha256: String,
    /// How long the whole run took on the host, milliseconds.
    #[serde(default)]
    pub host_ms: u64,
    /// What of the programs ran, where it was asked for: file by file, in the order of their first case.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub coverage: Vec<FileCoverage>,
    /// The requirements that the cases prove, as the register has them, in its order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub requirements: Vec<RequirementFact>,
}

/// A requirement as the register has it, and how far the run proves it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RequirementFact {
    /// Its ID: `controller:WD-04`.
    pub id: String,
    /// What it asks, one line.
    pub asks: String,
    /// How far the run proves it, a word: `proven`, `in part`; empty in a record of a rig that did not say.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub status: String,
    /// What it lacks, or why it is so: `lacks m251-2024`; empty for what is plainly proven.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub note: String,
    /// Its clauses.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub clauses: Vec<ClauseFact>,
}

/// A clause of a requirement as the register has it, and how far the run proves it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(from = "ClauseForm")]
pub struct ClauseFact {
    /// What stands after the `#`.
    pub id: String,
    /// What it asks, one line.
    pub asks: String,
    /// As that of [`RequirementFact::status`].
    #[serde(skip_serializing_if = "String::is_empty")]
    pub status: String,
    /// As that of [`RequirementFact::note`].
    #[serde(skip_serializing_if = "String::is_empty")]
    pub note: String,
}

/// How a clause is written: older records have two texts, its ID and what it asks.
#[derive(Deserialize)]
#[serde(untagged)]
enum ClauseForm {
    Pair(String, String),
    Fact {
        id: String,
        asks: String,
        #[serde(default)]
        status: String,
        #[serde(default)]
        note: String,
    },
}

impl From<ClauseForm> for ClauseFact {
    fn from(form: ClauseForm) -> Self {
        match form {
            ClauseForm::Pair(id, asks) => ClauseFact { id, asks, ..ClauseFact::default() },
            ClauseForm::Fact { id, asks, status, note } => ClauseFact { id, asks, status, note },
        }
    }
}

fn is_zero(n: &u64) -> bool {
    *n == 0
}

impl RunRecord {
    /// A record without cases.
    pub fn new(rig_version: impl Into<String>, provenance: Provenance) -> Self {
        RunRecord { format: FORMAT, rig_version: rig_version.into(), provenance, ..RunRecord::default() }
    }

    /// Appends a case and counts it.
    pub fn push(&mut self, case: CaseRecord) {
        let profiles = &mut self.provenance.profiles;
        if !case.profile.is_empty() && !profiles.contains(&case.profile) {
            profiles.push(case.profile.clone());
        }
        self.totals.count(&case);
        self.cases.push(case);
    }

    /// The cases that were measured without a guard band.
    pub fn unguarded(&self) -> Unguarded {
        let count = |is: fn(&CaseRecord) -> bool| self.cases.iter().filter(|case| is(case)).count() as u64;
        Unguarded { cases: count(CaseRecord::is_unguarded), by_middle: count(CaseRecord::is_by_middle) }
    }

    /// The greatest verdict of the judged cases; [`Verdict::None`] when none was judged.
    pub fn verdict(&self) -> Verdict {
        Verdict::fold(self.cases.iter().filter(|c| c.is_judged()).map(|c| c.verdict))
    }

    /// The record without what depends on the host and the moment: two runs of one seed then compare equal.
    pub fn without_host_facts(mut self) -> Self {
        self.provenance.binary_sha256.clear();
        self.provenance.kernel.clear();
        self.provenance.host_cpu = None;
        self.provenance.started = None;
        self.provenance.started_nanos = 0;
        self.provenance.arguments.clear();
        self.host_ms = 0;
        self.provenance.environment.clear();
        for case in &mut self.cases {
            case.host_ms = 0;
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clauses_of_older_records_are_read() {
        let text = r#"{ "id": "controller:RB-02", "asks": "a", "clauses": [["8", "b"], { "id": "9", "asks": "c", "status": "proven" }] }"#;
        let read: RequirementFact = serde_json::from_str(text).unwrap();
        let known = |id: &str, asks: &str, status: &str| ClauseFact {
            id: id.into(),
            asks: asks.into(),
            status: status.into(),
            ..ClauseFact::default()
        };
        assert_eq!(read.clauses, [known("8", "b", ""), known("9", "c", "proven")]);
        let again: RequirementFact = serde_json::from_str(&serde_json::to_string(&read).unwrap()).unwrap();
        assert_eq!(again, read);
    }
}
