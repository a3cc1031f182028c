//! What an executor is given of a case, and what it leaves.

use crate::executor::exceptions::ExceptionStop;
use crate::executor::frame_log::FrameLog;
use crate::executor::rig_fault::RigFault;
use crate::schedule::case_ending::NotRefused;
use controller::State;
use drivers::OnLoss;
use record::Wakes;
use signal::{Span, Time};

/// What the executor is given of a case.
#[derive(Clone, Copy, Debug)]
pub struct ExecutorLimits {
    /// The state in which the case begins.
    pub initial: State,
    /// The longest that the rig may be late before its verdict is `error`.
    pub late: Span,
    /// The longest that the application may run on before the rest of the rig is looked after; `Span::MAX` leaves
    /// it to the events. Never shows in the trace.
    pub slice: Span,
    /// The longest that the application may run ahead of the clock on real lines; wake-ups later than this count as
    /// late.
    pub horizon: Span,
    /// The case ends when a claim is lost.
    pub fail_fast: bool,
    /// What a lost device does to it.
    pub on_loss: OnLoss,
    /// A device that is gone is looked for, and taken back.
    pub reconnect: bool,
    /// Most modelled time from power-on to the end.
    pub timeout: Span,
    /// Most modelled time of the teardown.
    pub teardown: Span,
}

/// What a case's run leaves besides its trace.
#[derive(Debug, Default)]
pub struct ExecutorReport {
    /// When the case's own time began.
    pub start: Option<Time>,
    /// The end of the case: its teardown comes after.
    pub end: Time,
    /// The last instant.
    pub closed: Time,
    /// A fault of the rig: the verdict is then `error`.
    pub fault: Option<RigFault>,
    /// Steps that expect a refusal and were obeyed.
    pub not_refused: Vec<(String, NotRefused)>,
    /// Stops of the application by an exception, the first into each state.
    pub exceptions: Vec<ExceptionStop>,
    /// Deadlines of the rig that it missed.
    pub overruns: u64,
    /// How far the application could run ahead of the clock: 0 where that changes nothing.
    pub horizon: Span,
    /// How its waits ended; nothing in virtual time.
    pub wakes: Option<Wakes>,
    /// How late what the subject wrote reached its lines at worst, and how far it was behind at the end.
    pub late_outputs: Span,
    /// Events that the board lost.
    pub dropped: u64,
    /// The log.
    pub log: Vec<(Time, String)>,
    /// Log lines that found no room.
    pub log_dropped: u64,
    /// The CAN frames that were on its buses.
    pub frames: FrameLog,
}
