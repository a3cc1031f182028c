//! Which states of the controller a case speaks of.

use super::{Case, StepCondition, StepTime};
use crate::expect::{ClaimDemand, condition::ValueCondition};
use crate::lang::Literal;

/// The signal of the controller's state, which every trace has.
const STATE: &str = "state";

impl Case {
    /// The states, as in `HALT`, that an expectation of the case wants the controller to be in or to enter, or that one of
    /// its steps waits for. A stop into one of them is what the plan is about; a stop into another is not.
    pub fn expected_states(&self) -> Vec<String> {
        let mut states = Vec::new();
        let mut add = |literal: &Literal| {
            if let Literal::Label(label) = literal {
                states.push(label.to_ascii_uppercase());
            }
        };
        for demand in self.expectations.iter().flat_map(|expectation| expectation.claim.demands()) {
            if let ClaimDemand::Value {
                signal: STATE,
                condition: ValueCondition::OneOf(list),
                forbidden: false,
            } = demand
            {
                list.iter().for_each(&mut add);
            }
        }
        for step in &self.steps {
            if let StepTime::When { signal, awaits: StepCondition::Becomes(literal), .. } = &step.when
                && signal == STATE
            {
                add(literal);
            }
        }
        states
    }
}
