//! The messages.

mod describe;
mod event;
mod plan;
mod reply;
mod request;
mod status;

pub use describe::{
    BusInfo, ChannelInfo, Description, DeviceInfo, FunctionInfo, Greeting, ModuleInfo, PointDirection,
    PointInfo, Signal, SignalKind, SubjectKind, TaskInfo, TimeSource, WordScale,
};
pub use event::{FrameSeen, Reply, RequestFault, ServerMessage, SignalChange, SubscriptionEvent};
pub use plan::{Measured, PlanEvent, PlanStatus};
pub use reply::{Advanced, Done, Plans, RigLogLine, SignalValues, Subscribed};
pub use request::{ControllerAction, Forces, REQUEST_FIELDS, Request, RequestOperation, TOPIC_FIELDS, Topic};
pub use status::{
    BusStatus, DeviceStatus, ForcedPoint, LedStatus, Locked, PointStatus, RigStatus, Status, StatusWarning,
    TaskStatus,
};
