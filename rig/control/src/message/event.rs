//! What a rig reports.

use crate::WireValue;
use crate::message::{PlanEvent, Status};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// A line of a rig, after its greeting. [`ServerMessage::read`] reads it.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum ServerMessage {
    /// The answer to a request.
    Reply(Reply),
    /// Something of a subscription.
    Event(SubscriptionEvent),
}

impl ServerMessage {
    /// Reads a line; `None` for an event of a kind that is not known here: rigs may be younger than their clients.
    ///
    /// # Errors
    /// What no rig sends.
    pub fn read(line: &[u8]) -> Result<Option<ServerMessage>, serde_json::Error> {
        // Only this distinguishes an event from an answer, of which each field may be missing.
        #[derive(Deserialize)]
        struct Kind<'a> {
            #[serde(borrow)]
            event: Option<Cow<'a, str>>,
        }
        match serde_json::from_slice::<Kind<'_>>(line)?.event {
            None => serde_json::from_slice(line).map(|reply| Some(ServerMessage::Reply(reply))),
            Some(kind) if !SubscriptionEvent::KINDS.contains(&&*kind) => Ok(None),
            Some(_) => serde_json::from_slice(line).map(|event| Some(ServerMessage::Event(event))),
        }
    }
}

/// The answer to a request: `{"id": 7, "ok": ...}` or `{"id": 7, "error": {...}}`. A line that was no request has no
/// number.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reply {
    /// The request's number, where it could be read.
    pub id: Option<u64>,
    /// What was asked for, where it went well.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ok: Option<serde_json::Value>,
    /// Why it did not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<RequestFault>,
}

/// Why a request was not done.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RequestFault {
    /// The code, as `rig explain` knows it.
    pub code: String,
    /// What is wrong.
    pub message: String,
    /// How to fix it; empty where nothing helps.
    #[serde(default)]
    pub help: String,
}

/// Something of a subscription.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "event", rename_all = "kebab-case")]
pub enum SubscriptionEvent {
    /// Signals changed.
    Signals {
        /// The subscription.
        subscription: u64,
        /// The changes in their order.
        changes: Vec<SignalChange>,
        /// Changes that were not reported to this client since the last message, because it did not read in time.
        #[serde(default)]
        missed: u64,
    },
    /// The status.
    Status {
        /// The subscription.
        subscription: u64,
        /// How the rig is.
        status: Box<Status>,
    },
    /// A line of the log.
    Log {
        /// The subscription.
        subscription: u64,
        /// When, nanoseconds since the rig began.
        at: i64,
        /// The line.
        text: String,
    },
    /// A frame.
    Frame {
        /// The subscription.
        subscription: u64,
        /// The frame.
        frame: FrameSeen,
    },
    /// A plan went on.
    Plan {
        /// The subscription.
        subscription: u64,
        /// How.
        #[serde(rename = "told")]
        event: PlanEvent,
    },
    /// Lines of a subscription other than signals were left out, because this client did not read in time.
    Missed {
        /// The subscription.
        subscription: u64,
        /// How many.
        lines: u64,
    },
    /// The rig ends, or ends this connection. Nothing comes after it.
    Gone {
        /// Why.
        why: String,
    },
}

impl SubscriptionEvent {
    /// The kinds of events, as lines name them.
    pub const KINDS: [&str; 7] = ["signals", "status", "log", "frame", "plan", "missed", "gone"];
}

/// A change of a signal: its number, the earliest and the latest instant in nanoseconds since the rig began, its value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SignalChange(pub u32, pub i64, pub i64, pub WireValue);

/// A frame on a bus.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FrameSeen {
    /// The bus's name.
    pub bus: String,
    /// When it was over, nanoseconds since the rig began.
    pub at: i64,
    /// The rig sent it.
    pub sent: bool,
    /// The identifier in hexadecimal, as in `18F` or `18FF50E5`; empty for serial bytes.
    pub id: String,
    /// Of a CAN frame `remote`, `fd`, `brs`, `esi`; of serial bytes what was wrong with them (`parity`, `framing`, `damaged`,
    /// `break`, `overrun`), `doubtful` where they may be two messages, `continues` where they are the next part of a long
    /// one, and `goes-on` where another part follows.
    pub flags: Vec<String>,
    /// The bytes in hexadecimal.
    pub data: String,
}
