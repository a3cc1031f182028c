//! What is under test: the model (`model.rs`), or a real controller on the same wires (`external.rs`). A small core, and
//! the capabilities that only some subjects have (decision 52).

mod capabilities;
pub mod capability;
mod ext;
pub mod external;
pub mod hook;
pub(crate) mod log;
pub mod model;
mod ports;

use crate::application::catalogue::Catalogue;
use crate::subject::capability::Capability;
use controller::{Command, CommandError, Effects, State, Terminal};
use signal::{Address, Time, Value, When};

pub use capabilities::{Disturbances, ExpertFunctionAccess, FileAccess, Observation, Startup};
pub use ext::{NO_PROBE, SubjectExt};
pub use ports::PortAccess;

/// A controller under test.
///
/// The executor lets its program run to the next instant at which anything else happens, then lets its timers act.
/// A controller on real wires runs by itself: its `run` returns the limit at once and it has no timers.
///
/// What not every subject has is a capability of its own, reached by an accessor: [`Subject::startup`],
/// [`Subject::catalogue`], [`Subject::observation`], [`Subject::files`], [`Subject::disturbances`],
/// [`Subject::expert_functions`], [`Subject::ports`]. Callers who do not care whether it is there use [`SubjectExt`].
///
/// # A subject around another
///
/// A wrapper names the subject within by [`Subject::inner`] and [`Subject::inner_mut`], which nobody can leave out. It
/// writes the core methods, as the compiler asks; every capability, those that come later included, is that of the subject
/// within unless the wrapper changes it: then it implements the capability and answers its accessor by itself. One whose
/// instants are not those of the subject within answers all accessors whose capabilities take or give instants.
pub trait Subject: Send {
    /// The subject that this one is wrapped around; `None` for one of its own.
    fn inner(&self) -> Option<&dyn Subject>;

    /// As [`Subject::inner`].
    fn inner_mut(&mut self) -> Option<&mut dyn Subject>;

    /// The powers that it gives a plan.
    fn capabilities(&self) -> &'static [Capability];

    /// Whether the rig itself plays it: what the rig does late, it does late.
    fn is_model(&self) -> bool;

    /// Its state.
    fn state(&self) -> State;

    /// Switches its supply.
    fn power(&mut self, now: Time, on: bool, effects: &mut Effects);

    /// Lets application code run up to and including `limit`; returns the instant that it reached: earlier when
    /// something happened that the rest of the rig must see first.
    fn run(&mut self, limit: Time, effects: &mut Effects) -> Time;

    /// Whether its program has something to compute now: time that passes brings outputs, not only timers.
    fn is_computing(&self) -> bool;

    /// When it will next do something by itself.
    fn next_timer(&self) -> Option<Time>;

    /// Lets everything act that is due at `now`.
    fn fire(&mut self, now: Time, effects: &mut Effects);

    /// The terminal at a place of %I or %Q: a bit of a digital channel, a word of an analogue one. None where the rig does
    /// not know its inputs and outputs from inside.
    fn terminal(&self, address: Address) -> Option<Terminal>;

    /// What is at an input terminal from `now` on: a level ([`Value::HighZ`] where nothing drives its line), or a number in
    /// the unit of the channel. Its line changed `at` the instant before.
    fn set_input(&mut self, now: Time, at: When, terminal: Terminal, value: Value, effects: &mut Effects);

    /// What it drives an output terminal to; [`Value::Unknown`] where nobody can say.
    fn output(&self, terminal: Terminal) -> Value;

    /// Obeys a command.
    ///
    /// # Errors
    /// [`CommandError`] with the reason.
    fn command(&mut self, now: Time, command: &Command, effects: &mut Effects) -> Result<(), CommandError>;

    /// The rig has something to say that is no part of what it judges: a device was lost, or is back.
    fn notice(&mut self, at: Time, text: &str);

    /// Reports at `now`, the end of a case, which edges of its outputs are still to come and may be there already. Only of
    /// a model in its worst case.
    fn report_unsettled(&mut self, _now: Time, _effects: &mut Effects) {}

    /// How it comes into the state in which a case begins, where that is more than to switch it on.
    fn startup(&mut self) -> Option<&mut dyn Startup> {
        self.inner_mut()?.startup()
    }

    /// What names mean inside of it.
    fn catalogue(&self) -> Option<&Catalogue> {
        self.inner()?.catalogue()
    }

    /// What is inside of it, to look at.
    fn observation(&self) -> Option<&dyn Observation> {
        self.inner()?.observation()
    }

    /// As [`Subject::observation`], to watch and to write.
    fn observation_mut(&mut self) -> Option<&mut dyn Observation> {
        self.inner_mut()?.observation_mut()
    }

    /// Its files and its log.
    fn files(&mut self) -> Option<&mut dyn FileAccess> {
        self.inner_mut()?.files()
    }

    /// What can go wrong inside of it and around it.
    fn disturbances(&mut self) -> Option<&mut dyn Disturbances> {
        self.inner_mut()?.disturbances()
    }

    /// Its expert functions, with which hardware of the board can help.
    fn expert_functions(&mut self) -> Option<&mut dyn ExpertFunctionAccess> {
        self.inner_mut()?.expert_functions()
    }

    /// Its ports, where the rig plays them.
    fn ports(&mut self) -> Option<&mut dyn PortAccess> {
        self.inner_mut()?.ports()
    }
}
