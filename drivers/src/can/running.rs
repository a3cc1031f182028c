//! The thread of a CAN interface as its board has it.

use signal::{CanFrame, Span};
use std::sync::Arc;
use std::sync::atomic::Ordering;

use host::{Bell, HostInstant, Realtime};
use rtrb::{Consumer, Producer};

use super::adapter::Adapter;
use super::device::Device;
use super::port::Port;
use super::shared::{Report, Shared};

/// Frames on their way to the bus.
const TO_SEND: usize = 1_024;
/// Reports on their way to the board: a second of a busy bus.
pub(super) const REPORTS: usize = 8_192;

/// The board's side of the thread. Dropping it ends the thread.
#[derive(Debug)]
pub(super) struct Running {
    pub(super) shared: Arc<Shared>,
    pub(super) frames: Producer<CanFrame>,
    pub(super) reports: Consumer<Report>,
    patience: Span,
    thread: Option<std::thread::JoinHandle<()>>,
}

/// How a thread works.
#[derive(Clone, Copy, Debug)]
pub(super) struct ThreadConfig {
    /// How long before its stamp a frame may have ended.
    pub(super) resolution: Span,
    /// How long a call may last.
    pub(super) limit: Span,
    /// How long the end of the thread is waited for.
    pub(super) patience: Span,
    /// An interface that went away is taken back.
    pub(super) reconnect: bool,
    /// How the thread runs.
    pub(super) realtime: Realtime,
}

impl Running {
    /// Starts the thread of an open interface.
    pub(super) fn start(
        name: &str,
        adapter: Box<dyn Adapter>,
        port: Box<dyn Port>,
        bell: &Arc<Bell>,
        config: ThreadConfig,
    ) -> std::io::Result<Running> {
        let shared = Arc::new(Shared::new()?);
        let (frames, to_send) = rtrb::RingBuffer::new(TO_SEND);
        let (reports, reported) = rtrb::RingBuffer::new(REPORTS);
        let ends = (to_send, reports);
        let device = Device::new(adapter, port, shared.clone(), ends, bell.clone(), config);
        let thread = std::thread::Builder::new().name(format!("can {name}"));
        let thread = thread.spawn(move || device.run(config.realtime))?;
        Ok(Running { shared, frames, reports: reported, patience: config.patience, thread: Some(thread) })
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.shared.latched.store(true, Ordering::Release);
        self.shared.stop.store(true, Ordering::Release);
        self.shared.ask();
        let due = HostInstant::now() + self.patience;
        while !self.shared.ended.load(Ordering::Acquire) {
            // A thread inside a call that hangs is left to it: when the call ends, it finds that it is to stop.
            if HostInstant::now() >= due {
                return;
            }
            self.shared.answer.wait_until(due);
        }
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
