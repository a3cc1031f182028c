//! The names of a case: what the readers of verbs may ask of the plan around them.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};

use document::{Fields, Findings, KeySpec, Node, suggest};

use super::signals::{self, BUILT_IN};
use super::{FileFigure, Recording, RowFigure, SignalBinding, Source, TaskFigure};
use crate::codes;
use crate::expect::Names;
use crate::lang::{Anchor, AnchorError, Base, Operand, OperandError};

/// Signals in order of first use.
#[derive(Debug, Default)]
pub(super) struct Used {
    names: BTreeSet<String>,
    pub(super) list: Vec<SignalBinding>,
}

/// The names of one case.
#[derive(Debug)]
pub struct Scope<'a> {
    /// Steps of this case by their ids: how many pulses each emits, `None` if it is no train.
    pub(super) steps: BTreeMap<String, Option<u64>>,
    /// Ids of steps that only other rows have.
    pub(super) elsewhere: Vec<String>,
    /// The row, for messages.
    pub(super) row: Option<&'a str>,
    /// Signals that the plan binds.
    pub(super) bound: Vec<SignalBinding>,
    /// Names of `bound`.
    pub(super) bound_names: BTreeSet<String>,
    /// Signals that it uses without binding them, in order of use.
    pub(super) used: RefCell<Used>,
}

impl Scope<'_> {
    /// The fields of a table that was held against these keys before.
    pub(crate) fn fields<'n>(&self, node: &'n Node, specs: &'static [KeySpec]) -> Option<Fields<'n>> {
        Some(Fields::checked(node.as_table()?, specs))
    }

    /// The name of a signal; reports what is wrong with it.
    pub(crate) fn signal_of(&self, node: &Node, out: &mut Findings) -> Option<String> {
        let Some(text) = node.as_text() else {
            let source = signals::source(node, out)?;
            let name = source_name(&source);
            return Some(self.use_source(name, source, node));
        };
        let name = text.trim();
        if self.is_bound(name) {
            return Some(name.to_owned());
        }
        let source = signals::text_source(node, text, out)?;
        if let Source::Path(path) = &source {
            self.warn_if_misspelt(node, path, out);
        }
        // An address has one name however it is written: %Q0.4 is %QX0.4.
        let name = match &source {
            Source::Line(address) | Source::Memory(address) => address.to_string(),
            _ => name.to_owned(),
        };
        Some(self.use_source(name, source, node))
    }

    /// The name of a signal of which every change counts; reports one whose trace leaves some out.
    pub(crate) fn whole_signal(&self, node: &Node, out: &mut Findings) -> Option<String> {
        let name = self.signal_of(node, out)?;
        let binding = self.bound.iter().find(|binding| binding.name == name);
        let key = match binding.map(|binding| &binding.recording) {
            None | Some(Recording::Changes) => return Some(name),
            Some(Recording::Deadband(_)) => "deadband",
            Some(Recording::AtMostEvery(_)) => "at-most-every",
        };
        let message = format!("every change of `{name}` counts here, and it is recorded with `{key}`");
        let help = format!("bind the signal under a second name, without `{key}`");
        out.bad(codes::RECORDING, node, message, help);
        None
    }

    /// An instant; `within` shifts places inside the text.
    fn known(&self, anchor: Anchor, node: &Node, at: usize, out: &mut Findings) -> Option<Anchor> {
        let Some(id) = anchor.base.step() else { return Some(anchor) };
        let place = Some(at..at + id.len());
        let Some(pulses) = self.steps.get(id) else {
            let mut message = format!("there is no step `{id}`");
            if let (true, Some(row)) = (self.elsewhere.iter().any(|other| other == id), self.row) {
                message = format!("row `{row}` has no step `{id}`");
            }
            // Looking for what was meant takes time; what is not kept needs none.
            let ids = self.steps.keys().map(String::as_str).take(if out.is_full() { 0 } else { usize::MAX });
            let help = match suggest(id, ["start", "end"].into_iter().chain(ids)) {
                Some(meant) => format!("did you mean `{meant}`?"),
                None => "an instant counts from `start`, `end` or the id of a step".to_owned(),
            };
            out.bad_inside(codes::UNKNOWN_ANCHOR, node, place, message, help);
            return None;
        };
        if let Base::Pulse { n, .. } = anchor.base {
            match *pulses {
                None => {
                    let message = format!("the step `{id}` emits no train of pulses");
                    out.bad_inside(codes::UNKNOWN_ANCHOR, node, place, message, "");
                    return None;
                }
                Some(count) if n > count => {
                    let message = format!("the train `{id}` has {count} pulses, not {n}");
                    out.bad_inside(codes::UNKNOWN_ANCHOR, node, place, message, "");
                    return None;
                }
                Some(_) => {}
            }
        }
        Some(anchor)
    }

    fn is_bound(&self, name: &str) -> bool {
        BUILT_IN.contains(&name) || self.bound_names.contains(name)
    }

    /// Remembers a signal that is not bound.
    fn use_source(&self, name: String, source: Source, node: &Node) -> String {
        let mut used = self.used.borrow_mut();
        if used.names.insert(name.clone()) {
            let (name, recording) = (name.clone(), Recording::Changes);
            used.list.push(SignalBinding { name, source, recording, span: node.span.clone() });
        }
        name
    }

    /// A name one letter beside a bound one is more likely a slip than a variable.
    fn warn_if_misspelt(&self, node: &Node, path: &str, out: &mut Findings) {
        if path.contains(['.', '[']) || path.len() < 4 || out.is_full() || self.bound.len() > 100 {
            return;
        }
        let names = self.bound.iter().map(|binding| binding.name.as_str()).chain(BUILT_IN.iter().copied());
        if let Some(meant) = suggest(path, names) {
            let message = format!("`{path}` is not bound and taken for a variable of the program");
            out.warn(codes::UNBOUND, node.span.clone(), message, format!("did you mean `{meant}`?"));
        }
    }
}

impl Names for Scope<'_> {
    fn anchor(&self, node: &Node, out: &mut Findings) -> Option<Anchor> {
        let text = node.as_text()?;
        match Anchor::parse(text) {
            Ok(anchor) => self.known(anchor, node, text.len() - text.trim_start().len(), out),
            Err(AnchorError { at, fault }) => {
                let message = format!("`{text}` does not read as an instant: {fault}");
                out.bad_inside(codes::ANCHOR, node, Some(at), message, "write it as in \"busy + 102 ms\"");
                None
            }
        }
    }

    fn signal(&self, node: &Node, out: &mut Findings) -> Option<String> {
        self.signal_of(node, out)
    }

    fn at_value(&self, node: &Node, out: &mut Findings) -> Option<(String, Option<Anchor>)> {
        let Some(text) = node.as_text() else { return Some((self.signal_of(node, out)?, None)) };
        let operand = match Operand::parse(text) {
            Ok(operand) => operand,
            Err(error) => {
                let code = match error {
                    OperandError::Signal(_) => codes::OPERAND,
                    OperandError::Anchor(..) => codes::ANCHOR,
                };
                let help = "write it as in \"n\" or \"n @ cut\"";
                out.bad_inside(
                    code,
                    node,
                    Some(error.at()),
                    format!("`{text}` does not read: {error}"),
                    help,
                );
                return None;
            }
        };
        let at = match operand.at {
            Some(anchor) => Some(self.known(anchor, node, operand.anchor_at.start, out)?),
            None => None,
        };
        // The name alone, at its own place, so that what is wrong with it is shown there.
        let mut name = Node::new(node.inner(operand.signal_at), document::Data::Text(operand.signal));
        name.content = node.content.is_some().then_some(name.span.start);
        name.origin = node.origin.clone();
        Some((self.signal_of(&name, out)?, at))
    }
}

/// The name in the trace of a signal that is written as a table.
fn source_name(source: &Source) -> String {
    match source {
        Source::Line(address) | Source::Memory(address) => address.to_string(),
        Source::Image(address) => format!("image {address}"),
        Source::Path(name) | Source::Channel(name) => name.clone(),
        Source::Task { task, figure } => {
            let at = TaskFigure::ALL.iter().position(|known| known == figure).unwrap_or_default();
            format!("{task} {}", TaskFigure::NAMES[at])
        }
        Source::Log(text) => format!("log {text}"),
        Source::File { path, asks } => match asks {
            FileFigure::Exists => path.clone(),
            FileFigure::Holds(text) => format!("{path} holds {text}"),
            FileFigure::Size => format!("{path} size"),
            FileFigure::Lost => format!("{path} lost"),
        },
        Source::Register { register, exception: false } => format!("register {register}"),
        Source::Register { register, exception: true } => format!("register {register} exception"),
        Source::Relocation { row, figure } => {
            let figure = match figure {
                RowFigure::Address => "address",
                RowFigure::Length => "length",
                RowFigure::Valid => "valid",
            };
            format!("{row} {figure}")
        }
    }
}
