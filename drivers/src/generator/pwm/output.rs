//! An output of a PWM chip: which of its attributes is written first.
//!
//! The kernel takes period and active time one by one, and applies each at once. Between the two the output must not
//! carry a wave with a shorter level than those before and after it, and the kernel refuses an active time that is
//! longer than its period.

use std::fmt::Debug;
use std::io;
use std::os::fd::OwnedFd;

use rustix::io::Errno;

/// What the kernel lets be set of an output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Attribute {
    /// Length of its period, in ns.
    Period,
    /// How long of it the output is active, in ns.
    Duty,
    /// Whether it runs: 1 or 0.
    Enable,
}

/// The attributes of an output. Calls do not allocate but [`Attributes::claim`].
pub trait Attributes: Send + Debug {
    /// Sets one.
    ///
    /// # Errors
    /// The kernel's.
    fn write(&mut self, attribute: Attribute, value: u64) -> io::Result<()>;

    /// Reads one.
    ///
    /// # Errors
    /// The kernel's.
    fn read(&mut self, attribute: Attribute) -> io::Result<u64>;

    /// A descriptor of the active time, for whoever makes the output rest when the rig cannot.
    ///
    /// # Errors
    /// The kernel has no descriptor left.
    fn claim(&self) -> io::Result<OwnedFd>;
}

/// An output that is set up: it runs all the time, and rests where its active time is 0.
#[derive(Debug)]
pub struct PwmOutput {
    attributes: Box<dyn Attributes>,
    period: u64,
    duty: u64,
}

impl PwmOutput {
    /// Sets an output to work, at rest. `period` is taken where it has none yet.
    ///
    /// # Errors
    /// The kernel's.
    pub fn new(attributes: Box<dyn Attributes>, period: u64) -> io::Result<PwmOutput> {
        let mut output = PwmOutput { attributes, period: 0, duty: 0 };
        output.know()?;
        // Nothing can be written while there is no period.
        if output.period == 0 {
            output.set(Attribute::Period, period.max(1))?;
        }
        output.rest()?;
        output.attributes.write(Attribute::Enable, 1)?;
        Ok(output)
    }

    /// Brings it to rest, whatever it was.
    ///
    /// # Errors
    /// The kernel's.
    pub fn rest(&mut self) -> io::Result<()> {
        self.set(Attribute::Duty, 0)
    }

    /// Keeps it active all the time.
    ///
    /// # Errors
    /// The kernel's.
    pub fn active(&mut self) -> io::Result<()> {
        self.set(Attribute::Duty, self.period)
    }

    /// Has it emit a wave that is active so long of each period, in ns; above 0 and below the period.
    ///
    /// # Errors
    /// The kernel's. What the output emits then is one of the waves on the way, or what it was before.
    pub fn wave(&mut self, period: u64, duty: u64) -> io::Result<()> {
        // A wave begins at rest: in front of it there is no level that could be cut.
        if self.duty == self.period {
            self.rest()?;
        }
        // The period first keeps the active time of before and makes the time at rest no shorter than before; the active
        // time first keeps the time at rest no shorter than it will be.
        let order = match period >= self.period || self.duty == 0 {
            true => [(Attribute::Period, period), (Attribute::Duty, duty)],
            false => [(Attribute::Duty, duty), (Attribute::Period, period)],
        };
        for (attribute, value) in order {
            let now = if attribute == Attribute::Period { self.period } else { self.duty };
            if now != value {
                self.set(attribute, value)?;
            }
        }
        Ok(())
    }

    /// Whether it is still there, and is what it was set to be.
    ///
    /// # Errors
    /// The kernel's; EBADMSG where somebody else has set it.
    pub fn look(&mut self) -> io::Result<()> {
        for (attribute, value) in [(Attribute::Period, self.period), (Attribute::Duty, self.duty)] {
            if self.attributes.read(attribute)? != value {
                return Err(Errno::BADMSG.into());
            }
        }
        Ok(())
    }

    /// Stops it, at rest.
    ///
    /// # Errors
    /// The kernel's.
    pub fn stop(&mut self) -> io::Result<()> {
        self.rest()?;
        self.attributes.write(Attribute::Enable, 0)
    }

    /// A descriptor as [`Attributes::claim`] says.
    ///
    /// # Errors
    /// The kernel has no descriptor left.
    pub fn claim(&self) -> io::Result<OwnedFd> {
        self.attributes.claim()
    }

    /// Sets one, and sees that it is so.
    fn set(&mut self, attribute: Attribute, value: u64) -> io::Result<()> {
        let outcome = self.attributes.write(attribute, value).and_then(|()| self.attributes.read(attribute));
        match outcome {
            Ok(now) if now == value => {
                match attribute {
                    Attribute::Period => self.period = value,
                    Attribute::Duty => self.duty = value,
                    Attribute::Enable => {}
                }
                Ok(())
            }
            outcome => {
                // What it is now decides the order of the next change.
                let known = self.know();
                outcome.and(known).and(Err(Errno::BADMSG.into()))
            }
        }
    }

    fn know(&mut self) -> io::Result<()> {
        self.period = self.attributes.read(Attribute::Period)?;
        self.duty = self.attributes.read(Attribute::Duty)?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::sync::{Arc, Mutex};

    /// An output as the kernel has it, and every state that it was in.
    #[derive(Clone, Debug, Default)]
    struct Made(Arc<Mutex<State>>);

    #[derive(Debug, Default)]
    struct State {
        period: u64,
        duty: u64,
        enabled: bool,
        was: Vec<(u64, u64, bool)>,
        /// So many writes go well before one fails.
        fails_in: Option<u32>,
    }

    impl Attributes for Made {
        fn write(&mut self, attribute: Attribute, value: u64) -> io::Result<()> {
            let mut state = self.0.lock().unwrap();
            if let Some(left) = state.fails_in {
                state.fails_in = left.checked_sub(1);
                if left == 0 {
                    return Err(Errno::IO.into());
                }
            }
            let (mut period, mut duty, mut enabled) = (state.period, state.duty, state.enabled);
            match attribute {
                Attribute::Period => period = value,
                Attribute::Duty => duty = value,
                Attribute::Enable => enabled = value == 1,
            }
            if period == 0 || duty > period {
                return Err(Errno::INVAL.into());
            }
            (state.period, state.duty, state.enabled) = (period, duty, enabled);
            state.was.push((period, duty, enabled));
            Ok(())
        }

        fn read(&mut self, attribute: Attribute) -> io::Result<u64> {
            let state = self.0.lock().unwrap();
            Ok(match attribute {
                Attribute::Period => state.period,
                Attribute::Duty => state.duty,
                Attribute::Enable => u64::from(state.enabled),
            })
        }

        fn claim(&self) -> io::Result<OwnedFd> {
            Err(Errno::NOSYS.into())
        }
    }

    /// The shortest level of a wave; nothing is short where there is none.
    fn shortest((period, duty): (u64, u64)) -> u64 {
        if duty == 0 || duty == period { u64::MAX } else { duty.min(period - duty) }
    }

    proptest! {
        #[test]
        fn no_change_passes_a_state_that_is_refused_or_a_level_shorter_than_before_and_behind(
            waves in prop::collection::vec((2_u64..60, 0_u64..60, any::<bool>()), 1..30),
        ) {
            let made = Made::default();
            let mut output = PwmOutput::new(Box::new(made.clone()), 40).unwrap();
            let mut before = (40, 0);
            for (period, duty, level) in waves {
                made.0.lock().unwrap().was.clear();
                let wave = match (level, duty % 2) {
                    (true, 0) => { output.rest().unwrap(); (before.0, 0) }
                    (true, _) => { output.active().unwrap(); (before.0, before.0) }
                    _ => {
                        let wave = (period, 1 + duty % (period - 1));
                        output.wave(wave.0, wave.1).unwrap();
                        wave
                    }
                };
                let state = made.0.lock().unwrap();
                prop_assert_eq!((state.period, state.duty, state.enabled), (wave.0, wave.1, true));
                let limit = shortest(before).min(shortest(wave));
                for (period, duty, _) in &state.was {
                    prop_assert!(shortest((*period, *duty)) >= limit, "{before:?} to {wave:?} by {:?}", state.was);
                }
                let all = if before.1 == before.0 { 3 } else { 2 };
                prop_assert!(state.was.len() <= all, "{before:?} to {wave:?} by {:?}", state.was);
                before = wave;
            }
        }
    }

    #[test]
    fn what_was_left_behind_is_brought_to_rest_before_it_runs_and_stops_at_rest() {
        let made = Made::default();
        *made.0.lock().unwrap() = State { period: 100, duty: 30, ..State::default() };
        let mut output = PwmOutput::new(Box::new(made.clone()), 40).unwrap();
        assert_eq!(made.0.lock().unwrap().was, [(100, 0, false), (100, 0, true)]);
        output.wave(10, 4).unwrap();
        made.0.lock().unwrap().was.clear();
        output.stop().unwrap();
        assert_eq!(made.0.lock().unwrap().was, [(10, 0, true), (10, 0, false)]);
    }

    #[test]
    fn a_change_that_fails_half_way_is_known() {
        let made = Made::default();
        let mut output = PwmOutput::new(Box::new(made.clone()), 100).unwrap();
        output.wave(50, 20).unwrap();
        made.0.lock().unwrap().fails_in = Some(1);
        assert!(output.wave(80, 70).is_err());
        output.look().unwrap();
        // The period is the new one already: from there the way to the old wave is by the active time first.
        made.0.lock().unwrap().was.clear();
        output.wave(50, 10).unwrap();
        assert_eq!(made.0.lock().unwrap().was, [(80, 10, true), (50, 10, true)]);
        made.0.lock().unwrap().duty = 11;
        assert_eq!(output.look().unwrap_err().raw_os_error(), Some(Errno::BADMSG.raw_os_error()));
    }
}
