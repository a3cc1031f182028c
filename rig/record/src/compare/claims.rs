//! Claims and measurements of one case in two runs.

use super::{ClaimChange, Comparison, Erosion, GuardChange, Move, Thresholds};
use crate::{CaseRecord, Figure, GuardBand, Verdict};
use std::collections::BTreeMap;

/// A claim or measurement, as far as it is compared.
struct ClaimEntry<'a> {
    verdict: Verdict,
    margin: Option<&'a Figure>,
    /// How much of the margin is not known, in its unit.
    unknown: f64,
    value: Option<[f64; 2]>,
    unit: &'a str,
    /// How its uncertainty counts against its limits, and whether its middle alone decides; nothing for a claim, and where no
    /// limits are.
    guard: Option<(GuardBand, bool)>,
}

/// Entries by kind, name and turn: names need not be unique in a case.
type Entries<'a> = BTreeMap<(bool, &'a str, usize), ClaimEntry<'a>>;

/// Adds what changed in a case that is in both runs.
pub(super) fn compare(was: &CaseRecord, is: &CaseRecord, thresholds: &Thresholds, found: &mut Comparison) {
    if !was.is_judged() || !is.is_judged() {
        // Without a verdict nothing was claimed; the case itself says it.
        return;
    }
    let (before, after) = (entries(was), entries(is));
    for (key @ (_, name, _), old) in &before {
        let Some(new) = after.get(key) else {
            found.claims.push(ClaimChange {
                case: was.name.clone(),
                name: (*name).to_owned(),
                missing: true,
            });
            continue;
        };
        found.eroded.extend(eroded(was, name, old, new, thresholds));
        found.moved.extend(moved(was, name, old, new));
        found.guards.extend(guard(was, name, old, new));
    }
    for (_, name, _) in after.keys().filter(|key| !before.contains_key(*key)) {
        found.claims.push(ClaimChange { case: was.name.clone(), name: (*name).to_owned(), missing: false });
    }
}

fn entries(case: &CaseRecord) -> Entries<'_> {
    let mut all = Entries::new();
    let mut turns: BTreeMap<(bool, &str), usize> = BTreeMap::new();
    let mut turn = |measured, name| {
        let turn = turns.entry((measured, name)).or_default();
        *turn += 1;
        *turn
    };
    for claim in &case.claims {
        let unknown = claim.uncertainty.as_ref();
        let unknown = unknown.filter(|u| claim.margin.as_ref().is_some_and(|m| m.unit == u.unit));
        let entry = ClaimEntry {
            verdict: claim.verdict,
            margin: claim.margin.as_ref(),
            unknown: unknown.map_or(0.0, |u| u.value.abs()),
            value: None,
            unit: "",
            guard: None,
        };
        all.insert((false, claim.name.as_str(), turn(false, claim.name.as_str())), entry);
    }
    for m in &case.measurements {
        let entry = ClaimEntry {
            verdict: m.verdict,
            margin: m.margin.as_ref(),
            unknown: m.value.map_or(0.0, |[low, high]| high - low),
            value: m.value,
            unit: &m.unit,
            guard: (m.verdict != Verdict::None).then_some((m.guard_band, m.by_middle)),
        };
        all.insert((true, m.name.as_str(), turn(true, m.name.as_str())), entry);
    }
    all
}

/// A margin that lost more than the threshold, and more than what is not known of it. Where the verdict changed, that
/// says more.
fn eroded(
    case: &CaseRecord,
    name: &str,
    old: &ClaimEntry<'_>,
    new: &ClaimEntry<'_>,
    thresholds: &Thresholds,
) -> Option<Erosion> {
    let (was, is) = (old.margin?, new.margin?);
    if old.verdict != Verdict::Pass || new.verdict != Verdict::Pass || was.unit != is.unit {
        return None;
    }
    // That of a middle is no less than that of the same value with its guard band.
    if old.guard.map(|(band, _)| band) != new.guard.map(|(band, _)| band) {
        return None;
    }
    let lost = was.value - is.value;
    let lost_percent = 100.0 * lost / was.value;
    let known = lost > old.unknown.max(new.unknown);
    (known && lost_percent > thresholds.erosion_percent).then(|| Erosion {
        case: case.name.clone(),
        name: name.to_owned(),
        old: was.clone(),
        new: is.clone(),
        lost_percent,
    })
}

/// Another guard band, or another use of it.
fn guard(case: &CaseRecord, name: &str, old: &ClaimEntry<'_>, new: &ClaimEntry<'_>) -> Option<GuardChange> {
    let (was, is) = (old.guard?, new.guard?);
    let passes = old.verdict == Verdict::Pass && new.verdict == Verdict::Pass;
    let word = |(band, by_middle)| match (band, by_middle) {
        (GuardBand::Uncertainty, _) => "uncertainty",
        (GuardBand::None, false) => "none",
        (GuardBand::None, true) => "none, by its middle",
    };
    (was != is).then(|| GuardChange {
        case: case.name.clone(),
        name: name.to_owned(),
        old: word(was),
        new: word(is),
        worse: passes && was.0 != is.0 && is.1,
    })
}

fn moved(case: &CaseRecord, name: &str, old: &ClaimEntry<'_>, new: &ClaimEntry<'_>) -> Option<Move> {
    let (was, is) = (old.value?, new.value?);
    let apart = was[1] < is[0] || is[1] < was[0];
    (apart && old.unit == new.unit).then(|| Move {
        case: case.name.clone(),
        name: name.to_owned(),
        old: was,
        new: is,
        unit: old.unit.to_owned(),
    })
}
