//! What the readers of verbs may ask of the plan around them.

use document::{Findings, Node};

use super::Anchor;

/// What a verb's reader may ask of the plan around it.
pub trait PlanNames {
    /// Reads an instant such as `busy + 102 ms`; reports what is wrong with it, unknown steps included.
    fn anchor(&self, node: &Node, out: &mut Findings) -> Option<Anchor>;
    /// Where counting begins that says nothing else.
    fn begin(&self) -> Anchor {
        Anchor::START
    }
    /// Reads the name of a signal: bound by the plan, built in, or a variable's path.
    fn signal(&self, node: &Node, out: &mut Findings) -> Option<String>;
    /// Reads `n` or `n @ cut`: a signal, and the instant at which its value is meant.
    fn at_value(&self, node: &Node, out: &mut Findings) -> Option<(String, Option<Anchor>)>;
}
