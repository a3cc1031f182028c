//! Instants of a plan: `start + 1 s`, `busy`, `train.pulse[1000] - 2 us`, `cut.done + $wait`, `retry.second`.
//!
//! ```text
//! anchor = base { ("+" | "-") duration }
//! base   = "start" | "main" | "end" | "teardown" | path | path ".done" | path ".pulse[" number "]"
//! path   = id [ "[" number "]" ] { "." id [ "[" number "]" ] }
//! ```
//! An id may contain `-` before a letter; everywhere else `-` subtracts. A path leads into the groups that steps run.

use std::fmt;
use std::ops::Range;

use document::DURATION;
use signal::{QuantityFault, Span};

use super::words::id_length;

/// The pattern of an instant for schemas, without anchors at its ends: all that [`Anchor::parse`] takes, and little
/// more. After the id any parts and numbers may stand: which there are, depends on the step.
pub(crate) fn pattern() -> String {
    let id = "[A-Za-z_][A-Za-z0-9_]*(?:-[A-Za-z][A-Za-z0-9_]*)*";
    format!(r"{id}(?:\.{id}|\[\s*[0-9]+\s*\])*(?:\s*[+-]\s*-?{DURATION})*")
}

/// What an instant counts from.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum AnchorBase {
    /// The controller is booted, in its initial state, at the first release of MAST.
    Start,
    /// All of the setup is done; the same as `start` in a case without one.
    Main,
    /// The end of the case.
    End,
    /// The teardown begins.
    Teardown,
    /// The step of this id begins.
    Step(String),
    /// All that the step of this id does is done: the pulse is over, the power is back.
    StepDone(String),
    /// The rising edge of a pulse of the train that the step emits, counted from 1.
    Pulse {
        /// Id of the step.
        step: String,
        /// Number of the pulse, from 1.
        n: u64,
    },
    /// The step of this id, which comes again and again, comes this time.
    Occurrence {
        /// Id of the step.
        step: String,
        /// Which time, from 1.
        n: u64,
    },
}

impl AnchorBase {
    /// The id of the step it depends on, if any.
    pub fn step(&self) -> Option<&str> {
        match self {
            AnchorBase::Start | AnchorBase::Main | AnchorBase::End | AnchorBase::Teardown => None,
            AnchorBase::Step(id)
            | AnchorBase::StepDone(id)
            | AnchorBase::Pulse { step: id, .. }
            | AnchorBase::Occurrence { step: id, .. } => Some(id),
        }
    }
}

impl AnchorBase {
    /// The same part of another step.
    #[must_use]
    pub fn of_step(self, id: String) -> AnchorBase {
        match self {
            AnchorBase::Step(_) => AnchorBase::Step(id),
            AnchorBase::StepDone(_) => AnchorBase::StepDone(id),
            AnchorBase::Pulse { n, .. } => AnchorBase::Pulse { step: id, n },
            AnchorBase::Occurrence { n, .. } => AnchorBase::Occurrence { step: id, n },
            other => other,
        }
    }
}

impl fmt::Display for AnchorBase {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            AnchorBase::Start => f.write_str("start"),
            AnchorBase::Main => f.write_str("main"),
            AnchorBase::End => f.write_str("end"),
            AnchorBase::Teardown => f.write_str("teardown"),
            AnchorBase::Step(id) => f.write_str(id),
            AnchorBase::StepDone(id) => write!(f, "{id}.done"),
            AnchorBase::Pulse { step, n } => write!(f, "{step}.pulse[{n}]"),
            AnchorBase::Occurrence { step, n } => write!(f, "{step}[{n}]"),
        }
    }
}

/// An instant: a base and a signed distance from it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Anchor {
    /// What it counts from.
    pub base: AnchorBase,
    /// How long after the base, negative for before.
    pub offset: Span,
}

impl Anchor {
    /// The start of the case's stimuli.
    pub const START: Anchor = Anchor { base: AnchorBase::Start, offset: Span::ZERO };
    /// The end of the case.
    pub const END: Anchor = Anchor { base: AnchorBase::End, offset: Span::ZERO };

    /// Reads an instant.
    ///
    /// # Errors
    /// [`AnchorError`] with the bytes of the text at fault.
    pub fn parse(text: &str) -> Result<Anchor, AnchorError> {
        parse(text)
    }
}

impl fmt::Display for Anchor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.base)?;
        match self.offset {
            Span::ZERO => Ok(()),
            below if below.is_negative() && below != Span::from_nanos(i64::MIN) => write!(f, " - {}", -below),
            offset => write!(f, " + {offset}"),
        }
    }
}

/// Why a text is no instant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AnchorError {
    /// Bytes of the text at fault.
    pub at: Range<usize>,
    /// What is wrong there.
    pub fault: AnchorFault,
}

/// What can be wrong with an instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AnchorFault {
    /// No base where one is expected.
    #[error("expected `start`, `main`, `end`, `teardown` or the id of a step")]
    Base,
    /// A duration stands where a base is expected.
    #[error("a duration alone is no instant: say from where, as in `start + 1 s`")]
    NoBase,
    /// A part of a step that does not exist.
    #[error("a step has `.done`, a train `.pulse[n]`, a run the steps of its group")]
    Part,
    /// Not the number of a pulse or an occurrence, from 1.
    #[error("expected a number from 1, as in `train.pulse[1000]` or `poll[3]`")]
    Number,
    /// Neither `+` nor `-`.
    #[error("expected `+` or `-` and a duration, or nothing")]
    Operator,
    /// Not a duration.
    #[error("{0}")]
    Duration(QuantityFault),
    /// The sum is beyond 292 years.
    #[error("further than 292 years away")]
    TooLarge,
}

fn parse(text: &str) -> Result<Anchor, AnchorError> {
    let fail = |at: Range<usize>, fault| Err(AnchorError { at, fault });
    let mut at = skip_blanks(text, 0);
    let length = id_length(&text[at..]);
    if length == 0 {
        let fault = if Span::parse(text).is_ok() { AnchorFault::NoBase } else { AnchorFault::Base };
        return fail(at..word_end(text, at), fault);
    }
    let fixed = match &text[at..at + length] {
        "start" => Some(AnchorBase::Start),
        "main" => Some(AnchorBase::Main),
        "end" => Some(AnchorBase::End),
        "teardown" => Some(AnchorBase::Teardown),
        _ => None,
    };
    let base = match fixed {
        Some(base) => {
            at += length;
            if text[at..].starts_with(['.', '[']) {
                return fail(at..word_end(text, at), AnchorFault::Part);
            }
            base
        }
        None => {
            let (base, after) = path(text, at)?;
            at = after;
            base
        }
    };
    let mut total = 0i128;
    loop {
        at = skip_blanks(text, at);
        let Some(operator) = text[at..].chars().next() else { break };
        let sign = match operator {
            '+' => 1,
            '-' => -1,
            _ => return fail(at..word_end(text, at), AnchorFault::Operator),
        };
        let from = skip_blanks(text, at + 1);
        let end = duration_end(text, from);
        match Span::parse(&text[from..end]) {
            Ok(span) => total += sign * i128::from(span.as_nanos()),
            Err(error) => {
                let place = from + error.at;
                return fail(place..word_end(text, place), AnchorFault::Duration(error.fault));
            }
        }
        at = end;
    }
    match i64::try_from(total) {
        Ok(nanos) if nanos != i64::MIN => Ok(Anchor { base, offset: Span::from_nanos(nanos) }),
        _ => fail(0..text.len(), AnchorFault::TooLarge),
    }
}

/// The path of a step from `first` on, with the part of it that is meant, and where it ends.
fn path(text: &str, first: usize) -> Result<(AnchorBase, usize), AnchorError> {
    let mut at = first;
    loop {
        let length = id_length(&text[at..]);
        if length == 0 {
            return Err(AnchorError { at: at..word_end(text, at).max(at), fault: AnchorFault::Part });
        }
        at += length;
        // Up to here without the index, which belongs to the path only where it goes on.
        let step = &text[first..at];
        let mut index = None;
        if text[at..].starts_with('[') {
            let (n, after) = number(text, at + 1)?;
            index = Some(n);
            at = after;
        }
        let whole = &text[first..at];
        let Some(rest) = text[at..].strip_prefix('.') else {
            let base = match index {
                Some(n) => AnchorBase::Occurrence { step: step.to_owned(), n },
                None => AnchorBase::Step(whole.to_owned()),
            };
            return Ok((base, at));
        };
        at += 1;
        if let Some(inside) = rest.strip_prefix("pulse[") {
            let (n, after) = number(text, text.len() - inside.len())?;
            return Ok((AnchorBase::Pulse { step: whole.to_owned(), n }, after));
        }
        let length = id_length(rest);
        if &rest[..length] == "done" {
            return Ok((AnchorBase::StepDone(whole.to_owned()), at + length));
        }
    }
}

/// A number from 1 before a `]`, and where the bracket ends.
fn number(text: &str, from: usize) -> Result<(u64, usize), AnchorError> {
    let end = text[from..].find(']').map_or(text.len(), |end| from + end);
    let digits = text[from..end].trim();
    // One number has one name.
    let plain = !digits.starts_with(['+', '0']) && digits.len() == end - from;
    match digits.parse::<u64>() {
        Ok(n) if n > 0 && end < text.len() && plain => Ok((n, end + 1)),
        _ => Err(AnchorError { at: from..end, fault: AnchorFault::Number }),
    }
}

/// The end of the duration at `from`: the next operator, but not the sign right at the beginning.
fn duration_end(text: &str, from: usize) -> usize {
    let signed = usize::from(text[from..].starts_with(['+', '-']));
    text[from + signed..].find(['+', '-']).map_or(text.len(), |end| from + signed + end)
}

fn skip_blanks(text: &str, at: usize) -> usize {
    at + (text[at..].len() - text[at..].trim_start().len())
}

fn word_end(text: &str, at: usize) -> usize {
    text[at..].find(char::is_whitespace).map_or(text.len(), |end| at + end)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn step(id: &str, offset: Span) -> Anchor {
        Anchor { base: AnchorBase::Step(id.into()), offset }
    }

    #[test]
    fn instants_read() {
        assert_eq!(Anchor::parse("start"), Ok(Anchor::START));
        assert_eq!(Anchor::parse(" busy + 102 ms "), Ok(step("busy", Span::from_millis(102))));
        assert_eq!(Anchor::parse("busy-2 ms"), Ok(step("busy", Span::from_millis(-2))));
        assert_eq!(
            Anchor::parse("power-cut + 2 s + 0.37 ms"),
            Ok(step("power-cut", Span::from_micros(2_000_370)))
        );
        assert_eq!(Anchor::parse("a + 1 min 30 s - 1 s"), Ok(step("a", Span::from_secs(89))));
        assert_eq!(Anchor::parse("a + -2 ms"), Ok(step("a", Span::from_millis(-2))));
        let pulse = AnchorBase::Pulse { step: "train".into(), n: 1000 };
        assert_eq!(Anchor::parse("train.pulse[1000]"), Ok(Anchor { base: pulse, offset: Span::ZERO }));
        let done = AnchorBase::StepDone("cut".into());
        assert_eq!(Anchor::parse("cut.done"), Ok(Anchor { base: done, offset: Span::ZERO }));
        let inner = AnchorBase::StepDone("retry[2].gap".into());
        assert_eq!(Anchor::parse("retry[2].gap.done"), Ok(Anchor { base: inner, offset: Span::ZERO }));
        let third = AnchorBase::Occurrence { step: "poll".into(), n: 3 };
        assert_eq!(Anchor::parse("poll[3] - 1 ms").map(|anchor| anchor.base), Ok(third));
        assert_eq!(Anchor::parse("main").map(|anchor| anchor.base), Ok(AnchorBase::Main));
        assert_eq!(Anchor::parse("teardown + 1 s").map(|anchor| anchor.base), Ok(AnchorBase::Teardown));
    }

    #[test]
    fn faults_name_their_place() {
        let fault = |text: &str| Anchor::parse(text).map_err(|error| (error.at, error.fault)).unwrap_err();
        assert_eq!(fault(""), (0..0, AnchorFault::Base));
        assert_eq!(fault("1 s"), (0..1, AnchorFault::NoBase));
        assert_eq!(fault("start 1 s"), (6..7, AnchorFault::Operator));
        assert_eq!(fault("start + 1"), (8..9, AnchorFault::Duration(QuantityFault::MissingUnit)));
        assert_eq!(fault("start + 1 s + 2 sec"), (16..19, AnchorFault::Duration(QuantityFault::NoTime)));
        assert_eq!(fault("start +"), (7..7, AnchorFault::Duration(QuantityFault::Empty)));
        assert_eq!(fault("a.pulse[0]"), (8..9, AnchorFault::Number));
        assert_eq!(fault("a.pulse[1"), (8..9, AnchorFault::Number));
        assert_eq!(fault("a.1"), (2..3, AnchorFault::Part));
        assert_eq!(fault("a."), (2..2, AnchorFault::Part));
        assert_eq!(fault("a[0]"), (2..3, AnchorFault::Number));
        assert_eq!(fault("a[x].b"), (2..3, AnchorFault::Number));
        assert_eq!(fault("start.done"), (5..10, AnchorFault::Part));
        assert_eq!(fault("main[1]"), (4..7, AnchorFault::Part));
        assert_eq!(fault("a + 290 d + 290000 d").1, AnchorFault::Duration(QuantityFault::TooLong));
    }

    fn matches(text: &str) -> bool {
        regex::Regex::new(&format!(r"^\s*(?:{})\s*$", pattern())).unwrap().is_match(text)
    }

    #[test]
    fn the_pattern_of_schemas_tells_instants_from_other_texts() {
        for good in
            ["start", " busy + 102 ms ", "busy-2 ms", "power-cut + 2 s + 0.37 ms", "a + 1 min 30 s - 1 s"]
        {
            assert!(matches(good) && Anchor::parse(good).is_ok(), "{good}");
        }
        for bad in ["", "1 s", "start 1 s", "start + 1", "start + 1 s + 2 sec", "start +", "a.pulse[", "a..b"]
        {
            assert!(!matches(bad) && Anchor::parse(bad).is_err(), "{bad}");
        }
    }

    proptest! {
        #[test]
        fn what_is_written_reads_back(
            offset in -i64::MAX..=i64::MAX,
            id in "[a-z_][a-z0-9_]{0,8}(-[a-z][a-z0-9]{0,3})?",
            part in 0u8..4,
            n in 1u64..u64::MAX,
        ) {
            prop_assume!(!["start", "main", "end", "teardown"].contains(&id.as_str()));
            let id = if n % 2 == 0 { id } else { format!("{id}[{n}].x") };
            let base = match part {
                0 => AnchorBase::Step(id),
                1 => AnchorBase::StepDone(id),
                2 => AnchorBase::Occurrence { step: id, n },
                _ => AnchorBase::Pulse { step: id, n },
            };
            let anchor = Anchor { base, offset: Span::from_nanos(offset) };
            prop_assert!(matches(&anchor.to_string()), "{}", anchor);
            prop_assert_eq!(Anchor::parse(&anchor.to_string()), Ok(anchor));
        }

        #[test]
        fn no_text_panics(text in "\\PC*", near in "(start|a|a\\.pulse\\[|\\.done|\\.|\\[|\\]| |\\+|-|[0-9]{1,3}|s|ms|µ){0,9}") {
            for text in [text, near] {
                prop_assert!(Anchor::parse(&text).is_err() || matches(&text), "{}", text);
                if let Err(error) = Anchor::parse(&text) {
                    prop_assert!(error.at.start <= error.at.end && error.at.end <= text.len());
                    prop_assert!(text.is_char_boundary(error.at.start));
                }
            }
        }
    }
}
