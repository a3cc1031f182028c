//! The messages.

mod describe;
mod event;
mod plan;
mod reply;
mod request;
mod status;

pub use describe::{
    BusInfo, Channel, Clock, Description, DeviceInfo, Direction, FunctionInfo, Greeting, Point, Signal,
    SignalKind, Subject, TaskInfo,
};
pub use event::{Change, Event, Fault, FrameSeen, Message, Reply};
pub use plan::{Measured, PlanEvent, PlanStatus};
pub use reply::{Advanced, Done, LogLine, Plans, Subscribed, Values};
pub use request::{Action, Forces, Operation, REQUEST_FIELDS, Request, TOPIC_FIELDS, Topic};
pub use status::{
    BusStatus, DeviceStatus, Forced, Led, Locked, PointStatus, RigStatus, Status, StatusWarning, TaskStatus,
};
