//! The protocol of the control socket: lines of JSON between a rig that runs and those who look at it and work it.
//!
//! A rig greets whoever connects with one line ([`Greeting`]). Then each line of a client is a [`Request`], answered by
//! one line with the request's number ([`Reply`]); subscriptions bring further lines by themselves ([`SubscriptionEvent`]). The
//! protocol has a version: [`PROTOCOL`]. A rig that takes nobody more sends a [`Reply`] with a fault in place of the
//! greeting. Requests of one client are done one after the other and answered in their order; [`Done`], [`SignalValues`] and
//! their neighbours say what an answer holds.
//!
//! Goals: a person can read it, a script can write it, and neither side can make the other grow without bound. Not a
//! goal: the network. The socket is a file, and its permissions say who may speak.

pub mod client;
mod codes;
mod message;
pub mod place;
mod value;

pub use client::{ClientError, Connection, ControlClient, connect};
pub use codes::CODES;
pub use message::{
    Advanced, BusInfo, BusStatus, ChannelInfo, ControllerAction, Description, DeviceInfo, DeviceStatus, Done,
    ForcedPoint, Forces, FrameSeen, FunctionInfo, Greeting, LedStatus, Locked, Measured, ModuleInfo,
    PlanEvent, PlanStatus, Plans, PointDirection, PointInfo, PointStatus, REQUEST_FIELDS, Reply, Request,
    RequestFault, RequestOperation, RigLogLine, RigStatus, ServerMessage, Signal, SignalChange, SignalKind,
    SignalValues, Status, StatusWarning, SubjectKind, Subscribed, SubscriptionEvent, TOPIC_FIELDS, TaskInfo,
    TaskStatus, TimeSource, Topic, WordScale,
};
pub use signal::{Span, Value};
pub use value::WireValue;

/// The version of the protocol. It changes when an old client would misunderstand; new fields and new kinds of events
/// come without a new version, so a client passes over what it does not know.
pub const PROTOCOL: u32 = 1;

/// The longest line of a client, in bytes with its end.
pub const LONGEST_LINE: usize = 64 * 1024;
