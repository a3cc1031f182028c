//! A signal's value, now or at another instant: `n`, `n @ cut - 1 ms`.

use std::ops::Range;

use super::{Anchor, AnchorFault, is_path};

/// A signal and the instant at which its value counts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SignalAt {
    /// Name of the signal.
    pub signal: String,
    /// Bytes of the name in the text.
    pub signal_at: Range<usize>,
    /// The instant; `None` for the one that the expectation itself names.
    pub at: Option<Anchor>,
    /// Bytes of the instant in the text.
    pub anchor_at: Range<usize>,
}

/// Why a text is no operand.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SignalAtError {
    /// No name of a signal at these bytes.
    #[error("expected the name of a signal, as in `n` or `n @ cut`")]
    Signal(Range<usize>),
    /// The instant after `@` is wrong at these bytes.
    #[error("{1}")]
    Anchor(Range<usize>, AnchorFault),
}

impl SignalAtError {
    /// Bytes of the text at fault.
    pub fn at(&self) -> Range<usize> {
        match self {
            SignalAtError::Signal(at) | SignalAtError::Anchor(at, _) => at.clone(),
        }
    }
}

impl SignalAt {
    /// Reads `signal` or `signal @ instant`.
    ///
    /// # Errors
    /// [`SignalAtError`] with the bytes at fault.
    pub fn parse(text: &str) -> Result<SignalAt, SignalAtError> {
        let name_end = text.find('@').unwrap_or(text.len());
        let name = text[..name_end].trim();
        let from = text[..name_end].len() - text[..name_end].trim_start().len();
        let signal_at = from..from + name.len();
        if !is_path(name) && !name.starts_with('%') {
            return Err(SignalAtError::Signal(signal_at));
        }
        let (mut at, mut anchor_at) = (None, text.len()..text.len());
        if name_end < text.len() {
            let rest = name_end + 1;
            let blanks = text[rest..].len() - text[rest..].trim_start().len();
            anchor_at = rest + blanks..text.trim_end().len().max(rest + blanks);
            at = Some(Anchor::parse(&text[rest..]).map_err(|error| {
                SignalAtError::Anchor(error.at.start + rest..error.at.end + rest, error.fault)
            })?);
        }
        Ok(SignalAt { signal: name.to_owned(), signal_at, at, anchor_at })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use signal::Span;

    #[test]
    fn operands_read() {
        let plain = SignalAt::parse("MAIN.n").unwrap();
        assert_eq!((plain.signal.as_str(), plain.at), ("MAIN.n", None));
        let then = SignalAt::parse("n @ cut - 1 ms").unwrap();
        assert_eq!(then.signal, "n");
        assert_eq!(then.anchor_at, 4..14);
        assert_eq!(then.at.unwrap().offset, Span::from_millis(-1));
        assert_eq!(SignalAt::parse(" @ cut").unwrap_err().at(), 1..1);
        assert_eq!(SignalAt::parse("n @ cut + 1").unwrap_err().at(), 10..11);
    }

    proptest! {
        #[test]
        fn no_text_panics(text in "\\PC*", near in "(n|@| |cut|\\+|1 s|%MW1){0,7}") {
            for text in [text, near] {
                if let Err(error) = SignalAt::parse(&text) {
                    prop_assert!(error.at().end <= text.len());
                }
            }
        }
    }
}
