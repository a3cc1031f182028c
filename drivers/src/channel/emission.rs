//! Pulses that a board makes by itself, without a write for each edge.

use std::sync::Arc;

use signal::Span;
use thiserror::Error;

/// What a channel can emit by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PulseCapability {
    /// The shortest time at one level.
    pub shortest: Span,
    /// The longest period of a square wave.
    pub longest: Span,
    /// Instants of edges are moved to whole multiples of this since the beginning.
    pub resolution: Span,
    /// How long an [`Emission::Pulses`] may last; 0 for a channel that cannot count its pulses.
    pub counted: Span,
    /// Whether it emits an [`Emission::Square`].
    pub endless: bool,
}

/// Pulses from the beginning of an emission on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Emission {
    /// A square wave that begins with its rising edge, until the channel is written or emits something else. Where the
    /// channel emits one already, it is never asked for a wave with a shorter level than both have; whether the period under
    /// way goes to its end is the device's.
    Square {
        /// From one rising edge to the next.
        period: Span,
        /// How long of it the line is high: above 0 and below the period.
        high: Span,
    },
    /// Edges at these times since the beginning, in order: rising, falling and so on. An even number of them.
    Pulses(Arc<[Span]>),
}

/// Why a channel cannot emit something.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Error)]
pub enum NotEmitted {
    /// It emits nothing by itself.
    #[error("nothing behind it makes pulses by itself")]
    Nothing,
    /// It has no square wave without end.
    #[error("it emits counted pulses alone, no wave without end")]
    Endless,
    /// It cannot count pulses.
    #[error("it emits waves without end alone, and cannot count their pulses")]
    Counted,
    /// A level would last less than this.
    #[error("it keeps a level for at least {0}")]
    Short(Span),
    /// The period would be longer than this.
    #[error("its periods last at most {0}")]
    Long(Span),
    /// The pulses last longer than this.
    #[error("its pulses last at most {0} in all")]
    Lasting(Span),
    /// The edges are not in order, or odd in number.
    #[error("its edges are not in order")]
    Disorder,
}

impl PulseCapability {
    /// Whether it can emit this.
    ///
    /// # Errors
    /// What of it cannot be.
    pub fn check(&self, emission: &Emission) -> Result<(), NotEmitted> {
        let long_enough =
            |level: Span| if level < self.shortest { Err(NotEmitted::Short(self.shortest)) } else { Ok(()) };
        match emission {
            Emission::Square { .. } if !self.endless => Err(NotEmitted::Endless),
            Emission::Square { period, .. } if *period > self.longest => Err(NotEmitted::Long(self.longest)),
            Emission::Square { period, high } => long_enough(*high).and(long_enough(*period - *high)),
            Emission::Pulses(_) if self.counted == Span::ZERO => Err(NotEmitted::Counted),
            Emission::Pulses(edges) => {
                let mut last = None;
                for edge in edges.iter() {
                    match last {
                        Some(last) if *edge <= last => return Err(NotEmitted::Disorder),
                        Some(last) => long_enough(*edge - last)?,
                        None if *edge < Span::ZERO => return Err(NotEmitted::Disorder),
                        None => {}
                    }
                    last = Some(*edge);
                }
                match last {
                    Some(last) if last > self.counted => Err(NotEmitted::Lasting(self.counted)),
                    _ if edges.len() % 2 == 1 => Err(NotEmitted::Disorder),
                    _ => Ok(()),
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const US: fn(i64) -> Span = Span::from_micros;

    #[test]
    fn only_what_a_channel_can_emit_is_accepted() {
        let pwm = PulseCapability {
            shortest: US(2),
            longest: US(1_000),
            resolution: Span::from_nanos(10),
            counted: Span::ZERO,
            endless: true,
        };
        let square = |period, high| Emission::Square { period: US(period), high: US(high) };
        assert_eq!(pwm.check(&square(10, 5)), Ok(()));
        assert_eq!(pwm.check(&square(10, 1)), Err(NotEmitted::Short(US(2))));
        assert_eq!(pwm.check(&square(10, 9)), Err(NotEmitted::Short(US(2))));
        assert_eq!(pwm.check(&square(2_000, 5)), Err(NotEmitted::Long(US(1_000))));
        let pulses = |edges: &[i64]| Emission::Pulses(edges.iter().map(|at| US(*at)).collect());
        assert_eq!(pwm.check(&pulses(&[0, 5])), Err(NotEmitted::Counted));
        let stream = PulseCapability { counted: US(100), endless: false, ..pwm };
        assert_eq!(stream.check(&pulses(&[0, 5, 10, 15])), Ok(()));
        assert_eq!(stream.check(&square(10, 5)), Err(NotEmitted::Endless));
        assert_eq!(stream.check(&pulses(&[0, 5, 6, 15])), Err(NotEmitted::Short(US(2))));
        assert_eq!(stream.check(&pulses(&[5, 0])), Err(NotEmitted::Disorder));
        assert_eq!(stream.check(&pulses(&[0, 5, 10])), Err(NotEmitted::Disorder));
        assert_eq!(stream.check(&pulses(&[0, 5, 10, 101])), Err(NotEmitted::Lasting(US(100))));
    }
}
