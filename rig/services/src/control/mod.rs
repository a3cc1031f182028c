//! The control socket: clients on one side, the rig's scan on the other, and nothing of the first ever keeps the second
//! waiting.
//!
//! [`Hub`] is all of it but the socket: bytes of clients come in, bytes for them come out, the rig behind the trait
//! [`Rig`] gets orders and reports. [`serve`] makes the socket and runs the hub on a thread of its own without real-time
//! priority.
//!
//! Goals: each request is answered once and in order; whoever does not read is sent less, then cut off; memory is
//! bounded for every client. Not goals: the network, and secrecy between users who may open the socket.

mod client;
mod decode;
mod forces;
mod hub;
mod lines;
mod lock;
mod log_limit;
mod orders;
mod outbox;
mod publish;
mod requests;
mod rig;
mod serve;
mod settings;
mod socket;
mod topic;

pub use client::{ClientId, Peer};
pub use decode::{BadRequest, decode};
pub use hub::Hub;
pub use rig::{Answer, MOST_ORDERS, Rig, RigEvent, RigOrder, Ticket};
pub use serve::{Serving, serve};
pub use settings::{ClientLimits, OnDisconnect, SocketSettings};
pub use socket::check_group;
