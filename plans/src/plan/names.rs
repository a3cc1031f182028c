//! The names of a case: what the readers of verbs may ask of the plan around them.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;
use std::sync::Arc;

use document::{Findings, Node, suggest};
use signal::Span;

use super::expand::GroupCall;
use crate::codes;
use crate::frames::can::Databases;
use crate::lang::{Anchor, AnchorBase, AnchorError, PlanNames, SignalAt, SignalAtError};
use crate::signals::frames::NamedFrame;
use crate::signals::{
    self, BUILT_IN, FileFigure, RecordingPolicy, RowFigure, SignalBinding, SignalSource, TaskFigure,
};
use crate::steps::{CasePart, StepNames};
use crate::table::{TableFault, ValueTable, ValueTables};

/// Signals in order of first use.
#[derive(Debug, Default)]
pub(super) struct UsedSignals {
    names: BTreeSet<String>,
    pub(super) list: Vec<SignalBinding>,
}

/// What instants may ask of a step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct StepName {
    /// How many pulses it emits; `None` if it is no train.
    pub(super) pulses: Option<u64>,
    /// How many times it comes at most, if it comes again.
    pub(super) times: Option<u64>,
}

/// The names of one case.
#[derive(Debug)]
pub(super) struct CaseNames<'a> {
    /// Steps of this case by their ids.
    pub(super) steps: BTreeMap<String, StepName>,
    /// The parts that the case has steps in.
    pub(super) parts: BTreeSet<CasePart>,
    /// The call whose group is read.
    pub(super) call: RefCell<Rc<GroupCall>>,
    /// Ids of steps that only other rows have.
    pub(super) elsewhere: Vec<String>,
    /// The row, for messages.
    pub(super) row: Option<&'a str>,
    /// The tables that the plan may name.
    pub(super) tables: &'a ValueTables,
    /// The DBC files that the plan may name.
    pub(super) databases: &'a Databases,
    /// The frames that it names.
    pub(super) frames: BTreeMap<String, NamedFrame>,
    /// Signals that the plan binds.
    pub(super) bound: Vec<SignalBinding>,
    /// Names of `bound`.
    pub(super) bound_names: BTreeSet<String>,
    /// Those of them that something speaks of.
    pub(super) spoken_of: RefCell<BTreeSet<String>>,
    /// Signals that it uses without binding them, in order of use.
    pub(super) used: RefCell<UsedSignals>,
}

impl CaseNames<'_> {
    /// The name of a signal; reports what is wrong with it.
    fn signal_of(&self, node: &Node, out: &mut Findings) -> Option<String> {
        let Some(text) = node.as_text() else {
            let source = signals::source(node, out)?;
            let name = source_name(&source);
            return Some(self.use_source(name, source, node));
        };
        let name = text.trim();
        if self.is_bound(name) {
            self.spoken_of.borrow_mut().insert(name.to_owned());
            return Some(name.to_owned());
        }
        let source = signals::text_source(node, text, out)?;
        if let SignalSource::Path(path) = &source {
            self.warn_if_misspelt(node, path, out);
        }
        // An address has one name however it is written: %Q0.4 is %QX0.4.
        let name = match &source {
            SignalSource::Line(address) | SignalSource::Memory(address) => address.to_string(),
            _ => name.to_owned(),
        };
        Some(self.use_source(name, source, node))
    }

    /// What is read from now on belongs to this call, and so do findings about it.
    pub(super) fn enter(&self, call: &Rc<GroupCall>, out: &mut Findings) {
        call.announce(out);
        *self.call.borrow_mut() = Rc::clone(call);
    }

    /// Where counting begins that says nothing else: where the group that is read is run, or `start`.
    fn first(&self) -> Anchor {
        match self.call.borrow().path.as_str() {
            "" => Anchor::START,
            path => Anchor { base: AnchorBase::Step(path.to_owned()), offset: Span::ZERO },
        }
    }

    /// The step that is meant by an id: one of the group that is read goes before those around it.
    fn meant(&self, id: &str) -> Option<(String, StepName)> {
        let call = self.call.borrow();
        let mut path = call.path.as_str();
        if id == "begin" && !path.is_empty() {
            return Some((path.to_owned(), StepName::default()));
        }
        while !path.is_empty() {
            let full = format!("{path}.{id}");
            if let Some(known) = self.steps.get(&full) {
                return Some((full, *known));
            }
            path = path.rfind('.').map_or("", |at| &path[..at]);
        }
        self.steps.get(id).map(|known| (id.to_owned(), *known))
    }

    /// The instant with the full id of its step; reports a step that is not there and a part that it does not have.
    /// `at` is where the instant begins in the text.
    fn known(&self, anchor: Anchor, node: &Node, at: usize, out: &mut Findings) -> Option<Anchor> {
        if anchor.base == AnchorBase::Teardown && !self.parts.contains(&CasePart::Teardown) {
            let place = Some(at..at + "teardown".len());
            let help = "add teardown = [ ... ], or count from `end`";
            out.bad_inside(codes::NO_TEARDOWN, node, place, "the plan has no teardown", help);
            return None;
        }
        let Some(id) = anchor.base.step() else { return Some(anchor) };
        let place = Some(at..at + id.len());
        if let AnchorBase::Occurrence { step, n } = &anchor.base
            && let Some((full, _)) = self.meant(&format!("{step}[{n}]"))
        {
            // One of several calls of a group is a step of its own.
            return Some(Anchor { base: AnchorBase::Step(full), ..anchor });
        }
        let Some((full, facts)) = self.meant(id) else {
            let mut message = format!("there is no step `{id}`");
            if let (true, Some(row)) = (self.elsewhere.iter().any(|other| other == id), self.row) {
                message = format!("row `{row}` has no step `{id}`");
            }
            // Looking for what was meant takes time; what is not kept needs none.
            let ids = self.steps.keys().map(String::as_str).take(if out.is_full() { 0 } else { usize::MAX });
            let help = match suggest(id, ["start", "main", "end", "teardown"].into_iter().chain(ids)) {
                Some(meant) => format!("did you mean `{meant}`?"),
                None => "an instant counts from `start`, `end` or the id of a step".to_owned(),
            };
            out.bad_inside(codes::UNKNOWN_ANCHOR, node, place, message, help);
            return None;
        };
        let fault = match (&anchor.base, facts.pulses, facts.times) {
            (AnchorBase::Pulse { .. }, None, _) => {
                let help = format!("write `{id}`, or name a step with a `train`");
                Some((codes::UNKNOWN_ANCHOR, format!("the step `{id}` emits no train of pulses"), help))
            }
            (AnchorBase::Pulse { n, .. }, Some(count), _) if *n > count => {
                let message = format!("the train `{id}` has {count} pulses, not {n}");
                Some((codes::UNKNOWN_ANCHOR, message, format!("write a pulse from 1 to {count}")))
            }
            (AnchorBase::Occurrence { .. }, _, None) => {
                Some((codes::OCCURRENCE, format!("the step `{id}` comes once"), format!("write `{id}`")))
            }
            (AnchorBase::Occurrence { n, .. }, _, Some(times)) if *n > times => {
                let message = format!("the step `{id}` comes at most {times} times, not {n}");
                Some((codes::OCCURRENCE, message, format!("write a number from 1 to {times}")))
            }
            _ => None,
        };
        if let Some((code, message, help)) = fault {
            out.bad_inside(code, node, place, message, help);
            return None;
        }
        Some(Anchor { base: anchor.base.of_step(full), offset: anchor.offset })
    }

    fn is_bound(&self, name: &str) -> bool {
        BUILT_IN.contains(&name) || self.bound_names.contains(name)
    }

    /// Remembers a signal that is not bound.
    fn use_source(&self, name: String, source: SignalSource, node: &Node) -> String {
        let mut used = self.used.borrow_mut();
        if used.names.insert(name.clone()) {
            let (name, recording) = (name.clone(), RecordingPolicy::Changes);
            used.list.push(SignalBinding {
                name,
                source,
                recording,
                record: false,
                file: None,
                span: node.span.clone(),
            });
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

impl StepNames for CaseNames<'_> {
    fn whole_signal(&self, node: &Node, out: &mut Findings) -> Option<String> {
        let name = self.signal_of(node, out)?;
        let binding = self.bound.iter().find(|binding| binding.name == name);
        let key = match binding.map(|binding| &binding.recording) {
            None | Some(RecordingPolicy::Changes) => return Some(name),
            Some(RecordingPolicy::Deadband(_)) => "deadband",
            Some(RecordingPolicy::AtMostEvery(_)) => "at-most-every",
        };
        let message = format!("every change of `{name}` counts here, and it is recorded with `{key}`");
        let help = format!("bind the signal under a second name, without `{key}`");
        out.bad(codes::RECORDING, node, message, help);
        None
    }

    fn table(&self, name: &str) -> Result<Arc<ValueTable>, TableFault> {
        self.tables.get(name)
    }

    fn databases(&self) -> &Databases {
        self.databases
    }

    fn frame(&self, name: &str) -> Option<NamedFrame> {
        let named = self.frames.get(name)?.clone();
        self.spoken_of.borrow_mut().insert(name.to_owned());
        Some(named)
    }

    fn frame_names(&self) -> Vec<&str> {
        self.frames.keys().map(String::as_str).collect()
    }
}

impl PlanNames for CaseNames<'_> {
    fn begin(&self) -> Anchor {
        self.first()
    }

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
        let operand = match SignalAt::parse(text) {
            Ok(operand) => operand,
            Err(error) => {
                let code = match error {
                    SignalAtError::Signal(_) => codes::OPERAND,
                    SignalAtError::Anchor(..) => codes::ANCHOR,
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
fn source_name(source: &SignalSource) -> String {
    match source {
        SignalSource::Line(address) | SignalSource::Memory(address) => address.to_string(),
        SignalSource::Image(address) => format!("image {address}"),
        SignalSource::Path(name) | SignalSource::Channel(name) => name.clone(),
        SignalSource::Frames(pattern) => pattern.to_string(),
        SignalSource::FrameSignal(signal) => format!("{} {}", signal.pattern, signal.field.name),
        SignalSource::Task { task, figure } => {
            let at = TaskFigure::ALL.iter().position(|known| known == figure).unwrap_or_default();
            format!("{task} {}", TaskFigure::NAMES[at])
        }
        SignalSource::Log(text) => format!("log {text}"),
        SignalSource::File { path, asks } => match asks {
            FileFigure::Exists => path.clone(),
            FileFigure::Holds(text) => format!("{path} holds {text}"),
            FileFigure::Size => format!("{path} size"),
            FileFigure::Lost => format!("{path} lost"),
        },
        SignalSource::Register { register, exception: false } => format!("register {register}"),
        SignalSource::Register { register, exception: true } => format!("register {register} exception"),
        SignalSource::Relocation { row, figure } => {
            let figure = match figure {
                RowFigure::Address => "address",
                RowFigure::Length => "length",
                RowFigure::Valid => "valid",
            };
            format!("{row} {figure}")
        }
    }
}
