//! Which states of the controller a case speaks of.

use super::{Case, StepTime};
use crate::expect::{ClaimDemand, condition::ValueCondition};
use crate::lang::Literal;
use crate::steps::StepCondition;

/// The signal of the controller's state, which every trace has.
const STATE: &str = "state";
/// Where a stop by an exception leads: HALT, or EMPTY after a system error.
const STOPPED_BY_EXCEPTION: [&str; 2] = ["HALT", "EMPTY"];

impl Case {
    /// The states, as in `HALT`, that an expectation of the case wants the controller to be in or to enter, or that one of
    /// its steps waits for. A stop into one of them is what the plan is about; a stop into another is not.
    ///
    /// A claim that the controller is never RUNNING wants a stop whatever its kind: that is as much as a plan can say of
    /// a real controller, whose alarm output shows RUNNING and nothing else of the state.
    pub fn expected_states(&self) -> Vec<String> {
        let mut states = Vec::new();
        for demand in self.expectations.iter().flat_map(|expectation| expectation.claim.demands()) {
            match demand {
                ClaimDemand::Value {
                    signal: STATE,
                    condition: ValueCondition::OneOf(list),
                    forbidden: false,
                } => {
                    states.extend(list.iter().filter_map(state_name));
                }
                ClaimDemand::Value {
                    signal: STATE,
                    condition: ValueCondition::OneOf(list),
                    forbidden: true,
                } if list.iter().filter_map(state_name).any(|state| state == "RUNNING") => {
                    states.extend(STOPPED_BY_EXCEPTION.map(String::from));
                }
                _ => {}
            }
        }
        for step in &self.steps {
            if let StepTime::When { signal, awaits: StepCondition::Becomes(literal), .. } = &step.when
                && signal == STATE
            {
                states.extend(state_name(literal));
            }
        }
        states
    }
}

/// The state that a plan names so.
fn state_name(literal: &Literal) -> Option<String> {
    if let Literal::Label(label) = literal { Some(label.to_ascii_uppercase()) } else { None }
}
