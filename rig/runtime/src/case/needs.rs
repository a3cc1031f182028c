//! What a plan needs of subject, board and rig.

use crate::subject::Subject;
use crate::subject::capability::Capability;
use drivers::{Board, Channel, FaultSet};
use plans::Case;
use plans::lang::{Amount, BoundRelation, Need};
use plans::steps::Stimulus;
use signal::Span;

/// A need of the plan that is not met.
pub enum Unmet {
    /// The subject or the board lacks a power: the case does not apply.
    Power(String),
    /// The instrument is not good enough: inconclusive.
    Instrument(String),
}

/// That the plan needs somebody who can be asked, where nobody is. A case with a question is refused before.
pub fn unmet_operator(case: &Case, is_there: bool) -> Option<Unmet> {
    let needs = case.needs.iter().any(|need| need.word == "operator");
    (needs && !is_there).then(|| {
        Unmet::Power(String::from("nobody can be asked: the run is not on a terminal, or `CI` is set"))
    })
}

/// The first need that is not met on a rig that is `late` by so much.
pub fn unmet(case: &Case, subject: &dyn Subject, board: &dyn Board, late: Span) -> Option<Unmet> {
    // Where the subject has no faults of its own, relays of the board may put them on its wires.
    let disturbs = |step: &plans::PlanStep| matches!(step.stimulus, Stimulus::Disturb { .. });
    let relays = board.channels().iter().any(|channel| channel.faults != FaultSet::NONE);
    let faults = relays && !case.steps.iter().any(disturbs);
    let by_relays = |need: &&Need| faults && need.word == Capability::Faults.word();
    let mut needs = case.needs.iter().filter(|need| !by_relays(need));
    needs.find_map(|need| unmet_need(need, subject, board, late))
}

fn unmet_need(need: &Need, subject: &dyn Subject, board: &dyn Board, late: Span) -> Option<Unmet> {
    let lines = || board.channels().iter().filter(|channel| channel.is_digital());
    match (need.word, need.bound) {
        ("pulse", bound) => {
            let fastest = lines().map(fastest_pulses).max().unwrap_or(0);
            let wanted = match bound.map(|bound| (bound.relation, bound.amount)) {
                Some((BoundRelation::AtLeast, Amount::Millihertz(wanted))) => u128::from(wanted),
                _ => 1,
            };
            (fastest < wanted).then(|| {
                Unmet::Instrument(match fastest / 1_000 {
                    0 => String::from(
                        "the board promises no pulses: `pulses-up-to` of a channel says what its line can make",
                    ),
                    hz => format!("the board emits pulses up to {hz} Hz, the plan needs more"),
                })
            })
        }
        ("timestamp", bound) => {
            let stamped = lines().map(|channel| channel.resolution).max().unwrap_or(Span::ZERO);
            let worst = stamped + late;
            match bound.map(|bound| (bound.relation, bound.amount)) {
                Some((BoundRelation::AtMost, Amount::Time(wanted))) if worst > wanted => {
                    Some(Unmet::Instrument(if stamped > wanted {
                        format!("the board stamps edges to within {stamped}, the plan needs {wanted}")
                    } else {
                        format!("the rig was {late} late, the plan needs edges to within {wanted}")
                    }))
                }
                _ => None,
            }
        }
        // Of the run, not of the subject.
        ("operator" | "settings", _) => None,
        (word, _) => match Capability::find(word) {
            Some(capability) if subject.capabilities().contains(&capability) => None,
            _ => Some(Unmet::Power(format!("the subject does not have the power `{word}`"))),
        },
    }
}

/// The fastest pulses that a channel emits, written edge by edge or made by itself, in thousandths of a Hertz.
fn fastest_pulses(channel: &Channel) -> u128 {
    let written = if channel.drives { u128::from(channel.max_pulse_hz) * 1_000 } else { 0 };
    let made = channel.emits.map_or(0, |emits| {
        1_000_000_000_000 / u128::from(emits.shortest.as_nanos().max(1).unsigned_abs()) / 2
    });
    written.max(made)
}
