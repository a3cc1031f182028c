//! How far the cases of a run prove each requirement.

use plans::register::{ProofFacts, Requirement, RequirementClass, RequirementRegister};
use profile::Profile;
use record::{RunRecord, Verdict};
use std::collections::BTreeMap;

/// What the judged cases that cite a requirement or a clause came to under one profile.
#[derive(Debug, Default)]
pub struct Proof {
    cases: Vec<String>,
    verdict: Verdict,
}

/// What is cited, with its proofs by the names of the profiles.
pub type Proofs = BTreeMap<String, BTreeMap<String, Proof>>;

/// What can be said of a requirement or a clause.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ProofStatus {
    /// Cases of every profile that it holds for pass.
    Proven,
    /// The same, against its letter, as a decision says.
    ByDecision,
    /// The same, with something in place of what it names.
    StandIn,
    /// Of some profiles, or some clauses, and not of all.
    InPart,
    /// A rig cannot reproduce it.
    NotReproducible,
    /// No case passes.
    NotProven,
    /// A case does not pass.
    Failing,
}

impl ProofStatus {
    /// All of them, in the order of the columns of a table.
    pub const ALL: [ProofStatus; 7] = [
        ProofStatus::Proven,
        ProofStatus::ByDecision,
        ProofStatus::StandIn,
        ProofStatus::InPart,
        ProofStatus::NotReproducible,
        ProofStatus::NotProven,
        ProofStatus::Failing,
    ];

    /// The word for it.
    pub const fn word(self) -> &'static str {
        match self {
            ProofStatus::Proven => "proven",
            ProofStatus::ByDecision => "proven by decision",
            ProofStatus::StandIn => "stand-in",
            ProofStatus::InPart => "in part",
            ProofStatus::NotReproducible => "not reproducible",
            ProofStatus::NotProven => "not proven",
            ProofStatus::Failing => "failing",
        }
    }

    /// One column of a table.
    pub const fn sign(self) -> &'static str {
        match self {
            ProofStatus::Proven | ProofStatus::ByDecision | ProofStatus::StandIn => "+",
            ProofStatus::InPart => "~",
            ProofStatus::NotReproducible => " ",
            ProofStatus::NotProven => "-",
            ProofStatus::Failing => "!",
        }
    }

    /// Whether it is proven for all that it asks, whatever by.
    pub const fn is_proven(self) -> bool {
        matches!(self, ProofStatus::Proven | ProofStatus::ByDecision | ProofStatus::StandIn)
    }

    /// What several parts come to together: one case that does not pass is enough against all, and all have to be
    /// proven. Nothing without parts is proven.
    fn of_parts(parts: &[ProofStatus]) -> ProofStatus {
        let (Some(least), Some(greatest)) = (parts.iter().min(), parts.iter().max()) else {
            return ProofStatus::NotProven;
        };
        if *greatest == ProofStatus::Failing || greatest.is_proven() || least == greatest {
            *greatest
        } else if *least == ProofStatus::NotReproducible {
            ProofStatus::NotProven
        } else {
            ProofStatus::InPart
        }
    }
}

/// A requirement, or one of its clauses, with what proves it.
#[derive(Debug)]
pub struct RegisterRow<'a> {
    /// Its ID, as plans cite it.
    pub id: String,
    /// What it asks, one line.
    pub asks: &'a str,
    /// The requirement; of a clause the one that it belongs to.
    pub entry: &'a Requirement,
    /// What the register says of its proof.
    pub proof: &'a ProofFacts,
    /// How far it is proven.
    pub status: ProofStatus,
    /// The same for each profile that it holds for, with the names of the cases.
    pub profiles: Vec<(Profile, ProofStatus, Vec<&'a str>)>,
    /// What it lacks where it is proven in part: names of profiles, or clauses as in `#8`.
    pub lacks: Vec<String>,
}

impl RegisterRow<'_> {
    /// Its status in words, with what the register says of it.
    pub fn note(&self) -> String {
        let waits = self.proof.open.as_ref().map(|open| format!("waits for: {open}"));
        match self.status {
            ProofStatus::Proven | ProofStatus::Failing => String::new(),
            ProofStatus::ByDecision | ProofStatus::StandIn => {
                let decision = self.proof.decision.map(|number| format!("decision {number}"));
                let stand_in = Some(self.proof.stand_in.clone()).filter(|text| !text.is_empty());
                decision.into_iter().chain(stand_in).collect::<Vec<_>>().join("; ")
            }
            ProofStatus::InPart => {
                let lacks = Some(format!("lacks {}", self.lacks.join(", ")));
                lacks.into_iter().chain(waits).collect::<Vec<_>>().join("; ")
            }
            ProofStatus::NotReproducible => self.proof.reason.clone(),
            ProofStatus::NotProven => waits.unwrap_or_default(),
        }
    }
}

/// What the judged cases of a run prove.
pub fn proofs(record: &RunRecord) -> Proofs {
    let mut proofs = Proofs::new();
    for case in record.cases.iter().filter(|case| case.is_judged()) {
        for id in &case.proves {
            let proof = proofs.entry(id.clone()).or_default().entry(case.profile.clone()).or_default();
            proof.cases.push(case.name.clone());
            proof.verdict = proof.verdict.max(case.verdict);
        }
    }
    proofs
}

/// The rows of a register in its order, each requirement before its clauses.
pub fn rows<'a>(register: &'a RequirementRegister, proofs: &'a Proofs) -> Vec<RegisterRow<'a>> {
    register.entries.iter().flat_map(|entry| rows_of(entry, proofs)).collect()
}

/// The row of a requirement, and after it those of its clauses, which decide about it where it has some: a case that
/// cites the whole of it says of no clause that it holds, but can speak against all.
fn rows_of<'a>(entry: &'a Requirement, proofs: &'a Proofs) -> Vec<RegisterRow<'a>> {
    let mut own = row(entry.id.clone(), &entry.asks, entry, &entry.proof, proofs);
    if entry.clauses.is_empty() {
        return vec![own];
    }
    let clauses: Vec<RegisterRow<'_>> = entry
        .clauses
        .iter()
        .map(|clause| row(format!("{}#{}", entry.id, clause.id), &clause.asks, entry, &clause.proof, proofs))
        .collect();
    for (profile, status, cases) in &mut own.profiles {
        let of_profile =
            clauses.iter().flat_map(|clause| &clause.profiles).filter(|(known, ..)| known == profile);
        let of_profile: Vec<_> = of_profile.collect();
        let mut parts: Vec<ProofStatus> = of_profile.iter().map(|(_, status, _)| *status).collect();
        parts.extend(Some(*status).filter(|status| *status == ProofStatus::Failing));
        *status = ProofStatus::of_parts(&parts);
        cases.extend(of_profile.iter().flat_map(|(_, _, cases)| cases));
        cases.sort_unstable();
        cases.dedup();
    }
    let mut parts: Vec<ProofStatus> = clauses.iter().map(|clause| clause.status).collect();
    parts.extend(Some(own.status).filter(|status| *status == ProofStatus::Failing));
    own.status = ProofStatus::of_parts(&parts);
    let lacking = entry.clauses.iter().zip(&clauses).filter(|(_, row)| !row.status.is_proven());
    own.lacks = lacking.map(|(clause, _)| format!("#{}", clause.id)).collect();
    let mut rows = vec![own];
    rows.extend(clauses);
    rows
}

fn row<'a>(
    id: String,
    asks: &'a str,
    entry: &'a Requirement,
    proof: &'a ProofFacts,
    proofs: &'a Proofs,
) -> RegisterRow<'a> {
    let holds = if proof.profiles.is_empty() { &entry.proof.profiles } else { &proof.profiles };
    let without = match proof.class {
        RequirementClass::NotReproducible => ProofStatus::NotReproducible,
        RequirementClass::Behaviour | RequirementClass::Constant => ProofStatus::NotProven,
    };
    let with = match (proof.decision, proof.stand_in.is_empty()) {
        (_, false) => ProofStatus::StandIn,
        (Some(_), true) => ProofStatus::ByDecision,
        (None, true) => ProofStatus::Proven,
    };
    let known = proofs.get(&id);
    let profiles: Vec<(Profile, ProofStatus, Vec<&str>)> = Profile::ALL
        .into_iter()
        .filter(|profile| holds.is_empty() || holds.contains(profile))
        .map(|profile| match known.and_then(|known| known.get(profile.name())) {
            None => (profile, without, Vec::new()),
            Some(proof) => {
                let status = match proof.verdict {
                    Verdict::Pass => with,
                    Verdict::None => without,
                    Verdict::Inconclusive | Verdict::Fail | Verdict::Error => ProofStatus::Failing,
                };
                (profile, status, proof.cases.iter().map(String::as_str).collect())
            }
        })
        .collect();
    let parts: Vec<ProofStatus> = profiles.iter().map(|(_, status, _)| *status).collect();
    let lacking = profiles.iter().filter(|(_, status, _)| !status.is_proven());
    let lacks = lacking.map(|(profile, ..)| profile.name().to_owned()).collect();
    RegisterRow { id, asks, entry, proof, status: ProofStatus::of_parts(&parts), profiles, lacks }
}

#[cfg(test)]
mod tests {
    use super::*;
    use record::CaseRecord;

    const REGISTER: &str = r#"
        ["controller:RB-02"]
        asks = "a"
        source = "s"
        clauses = { 1 = "b", 2 = { asks = "c", profiles = ["m241-2014"] }, 3 = { asks = "d", class = "not-reproducible", reason = "r" } }
        ["controller:WD-04"]
        asks = "a"
        source = "s"
        profiles = ["m241-2014", "m251-2024"]
        open = "modules"
        ["controller:SD-01"]
        asks = "a"
        source = "s"
        profiles = ["m241-2019"]
        decision = 66
        ["controller:SD-02"]
        asks = "a"
        source = "s"
        clauses = { 1 = { asks = "b", decision = 66, profiles = ["m241-2019"] }, 2 = { asks = "c", stand-in = "a file in place of a card", profiles = ["m241-2019"] } }
    "#;

    /// Status and note of a row.
    fn of(id: &str, cited: &[(&str, &str, Verdict)]) -> (&'static str, String) {
        let register = RequirementRegister::read(REGISTER).unwrap();
        let mut record = RunRecord::default();
        for (id, profile, verdict) in cited {
            record.push(CaseRecord {
                name: String::from("case"),
                profile: (*profile).to_owned(),
                proves: vec![(*id).to_owned()],
                verdict: *verdict,
                ..CaseRecord::default()
            });
        }
        let proofs = proofs(&record);
        let rows = rows(&register, &proofs);
        let row = rows.iter().find(|row| row.id == id).unwrap();
        (row.status.word(), row.note())
    }

    #[test]
    fn every_profile_that_it_names_has_to_be_proven() {
        let old = ("controller:WD-04", "m241-2014", Verdict::Pass);
        let usual = ("controller:WD-04", "m241-2019", Verdict::Pass);
        let other = ("controller:WD-04", "m251-2024", Verdict::Pass);
        let is = |cited: &[_]| of("controller:WD-04", cited);
        assert_eq!(is(&[old, other]), ("proven", String::new()));
        assert_eq!(is(&[old, usual]), ("in part", "lacks m251-2024; waits for: modules".into()));
        // A profile that it does not hold for proves nothing of it.
        assert_eq!(is(&[usual]), ("not proven", "waits for: modules".into()));
        let nothing_judged = ("controller:WD-04", "m251-2024", Verdict::None);
        assert_eq!(is(&[old, nothing_judged]).0, "in part");
        for verdict in [Verdict::Inconclusive, Verdict::Fail, Verdict::Error] {
            assert_eq!(is(&[old, other, ("controller:WD-04", "m251-2024", verdict)]).0, "failing");
        }
    }

    #[test]
    fn every_clause_has_to_be_proven() {
        let one = Profile::ALL.map(|profile| ("controller:RB-02#1", profile.name(), Verdict::Pass));
        let two = ("controller:RB-02#2", "m241-2014", Verdict::Pass);
        let whole = Profile::ALL.map(|profile| ("controller:RB-02", profile.name(), Verdict::Pass));
        assert_eq!(of("controller:RB-02", &whole).0, "not proven");
        assert_eq!(of("controller:RB-02", &one), ("in part", "lacks #2, #3".into()));
        let both = [&one[..], &[two]].concat();
        // What a rig cannot reproduce is not proven with the rest.
        assert_eq!(of("controller:RB-02", &both), ("in part", "lacks #3".into()));
        assert_eq!(of("controller:RB-02#3", &both), ("not reproducible", "r".into()));
        assert_eq!(of("controller:RB-02#1", &[one[0]]), ("in part", "lacks m241-2019, m251-2024".into()));
        let fail = ("controller:RB-02#2", "m241-2014", Verdict::Fail);
        assert_eq!(of("controller:RB-02", &[&one[..], &[fail]].concat()).0, "failing");
        assert_eq!(of("controller:RB-02", &[("controller:RB-02", "m241-2019", Verdict::Fail)]).0, "failing");
    }

    #[test]
    fn a_decision_and_a_stand_in_are_shown() {
        let cited = |id| [(id, "m241-2019", Verdict::Pass)];
        assert_eq!(
            of("controller:SD-01", &cited("controller:SD-01")),
            ("proven by decision", "decision 66".into())
        );
        assert_eq!(of("controller:SD-01", &[]).0, "not proven");
        let both = [cited("controller:SD-02#1")[0], cited("controller:SD-02#2")[0]];
        assert_eq!(of("controller:SD-02", &both).0, "stand-in");
        assert_eq!(of("controller:SD-02#2", &both), ("stand-in", "a file in place of a card".into()));
        assert_eq!(of("controller:SD-02", &both[..1]), ("in part", "lacks #2".into()));
    }

    #[test]
    fn parts_of_one_status_have_it_together() {
        for status in ProofStatus::ALL {
            assert_eq!(ProofStatus::of_parts(&[status, status]), status);
        }
        assert_eq!(
            ProofStatus::of_parts(&[ProofStatus::NotReproducible, ProofStatus::NotProven]),
            ProofStatus::NotProven
        );
        assert_eq!(ProofStatus::of_parts(&[]), ProofStatus::NotProven);
    }
}
