//! The rig as the control socket sees it.

use control::{ControllerAction, Description, FrameSeen, Greeting, PlanEvent, RequestFault, Signal, Status};
use signal::{Span, Time, Value, When};

/// The most orders that are under way at once.
pub const MOST_ORDERS: usize = 64;

/// What an order's answer is known by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Ticket(pub u64);

/// What the rig is to do. Orders are carried out in their order, between two turns of the scan.
#[derive(Clone, Debug, PartialEq)]
pub enum RigOrder {
    /// Read a signal.
    Read(u32),
    /// Write one.
    Write(u32, Value),
    /// Force an embedded input or output, by the signal of its image.
    Force(u32, Value),
    /// End its forcing.
    Release(u32),
    /// End all forcing.
    ReleaseAll,
    /// Command the controller.
    Command(ControllerAction),
    /// Let time pass, where clients step it.
    Advance(Span),
    /// List what it can run: the cases of the plans of a file or folder, or the names of the plans that ship. Not an order to
    /// the scan: files are read for it, which may take its time.
    Plans(Option<String>),
    /// Run a plan.
    Plan(String),
    /// End the plan that runs.
    Abort,
}

/// What an order came to.
#[derive(Clone, Debug, PartialEq)]
pub enum Answer {
    /// It is done.
    Done,
    /// What was read.
    Value(Value),
    /// What can be run.
    Plans(Vec<String>),
}

/// What the rig reports.
#[derive(Clone, Debug, PartialEq)]
pub enum RigEvent {
    /// A signal that is watched changed.
    Change {
        /// Its number.
        signal: u32,
        /// When.
        at: When,
        /// Its value.
        value: Value,
    },
    /// An order was carried out, or not.
    Answer(Ticket, Result<Answer, RequestFault>),
    /// A line of the log.
    Log(Time, String),
    /// A frame.
    Frame(FrameSeen),
    /// A plan goes on.
    Plan(PlanEvent),
    /// It is over.
    Ended(String),
}

/// The handle of a rig that runs. Its calls never wait for the scan, nor for a disk; what they set off is reported by
/// [`Rig::poll`].
pub trait Rig: Send {
    /// The greeting, without the client's number.
    fn greeting(&self) -> Greeting;

    /// What it is.
    fn describe(&self) -> Description;

    /// How it is, as far as is known by now; after [`RigOrder::Advance`], of the instant that was reached. Who is
    /// connected, the lock and who forced what are added by the socket.
    fn status(&self) -> Status;

    /// What a name means: a signal's, a terminal's, a channel's, an address.
    ///
    /// # Errors
    /// A name that the rig does not know, with the nearest one.
    fn find(&mut self, name: &str) -> Result<Signal, RequestFault>;

    /// From now on changes of a signal are reported, its present value as the first. It is watched as often as this was
    /// called, less as often as [`Rig::unwatch`] was.
    ///
    /// # Errors
    /// More signals than can be watched.
    fn watch(&mut self, signal: u32) -> Result<(), RequestFault>;

    /// Ends that.
    fn unwatch(&mut self, signal: u32);

    /// What a watched signal was by now, if anything was reported of it.
    fn last(&self, signal: u32) -> Option<(When, Value)>;

    /// Gives an order; its answer comes with [`RigEvent::Answer`].
    ///
    /// # Errors
    /// What cannot be done, if that is known already. There is room for [`MOST_ORDERS`]: the socket never has more of
    /// them under way.
    fn order(&mut self, ticket: Ticket, order: RigOrder) -> Result<(), RequestFault>;

    /// Hands on what the rig reported since the last call, in its order.
    fn poll(&mut self, report: &mut dyn FnMut(RigEvent));
}
