//! The serial lines of a board.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use document::Diagnostic;
use host::{HostInstant, TimeBase};
use rustix::io::Errno;
use signal::{CanFrame, SerialOutput, Span, Time, Value, When};
use tokio::runtime::Builder;

use super::find::Identity;
use super::frames::Framing;
use super::work::{Order, Passed, Running, Shared, Worker};
use super::{OpenError, SerialPort, SerialSpec};
use crate::channel_table::ChannelTable;
use crate::codes;
use crate::holder::{all_holders, words};
use crate::run_state::{RunState, START, drives_none};
use crate::{
    Board, BoardContext, BoardError, BoardEvent, Bus, BusError, BusEvent, BusId, Buses, Channel, ChannelId,
    DeviceLimits, Health, LossReason,
};

/// The serial lines of a board: held for the rig alone while it lives, each by a thread of its own, which receives and
/// sends.
#[derive(Debug)]
pub struct SerialBoard {
    channels: Vec<Channel>,
    buses: Vec<Bus>,
    lines: Vec<Line>,
    context: BoardContext,
    limits: DeviceLimits,
    run: RunState,
}

#[derive(Debug)]
struct Line {
    bus: BusId,
    /// Its device, as messages name it.
    device: String,
    running: Running,
    lost: Option<LossReason>,
    /// What lies ahead of the last poll.
    ahead: Option<Time>,
    /// Messages that were lost on their way since the start.
    dropped: u64,
    /// Losses that were told, and failed calls before the run.
    losses: u32,
    failed: u64,
}

impl SerialBoard {
    /// Opens the ports of a board.
    ///
    /// # Errors
    /// All that are not there, not free, not permitted or cannot do what is asked, by place.
    pub fn open(
        table: &ChannelTable,
        spec: &[SerialSpec],
        limits: DeviceLimits,
        context: &BoardContext,
    ) -> Result<SerialBoard, Vec<Diagnostic>> {
        let mut buses = Vec::new();
        super::describe(spec, &mut buses);
        let mut board = SerialBoard {
            channels: table.blank(),
            buses,
            lines: Vec::with_capacity(spec.len()),
            context: context.clone(),
            limits,
            run: RunState::default(),
        };
        let mut found = Vec::new();
        for line in spec {
            match board.line(line) {
                Ok(line) => board.lines.push(line),
                Err((code, message, help)) => found.push(
                    Diagnostic::error(code, message)
                        .at(table.file.clone(), line.place.clone(), "")
                        .help(help),
                ),
            }
        }
        if found.is_empty() { Ok(board) } else { Err(found) }
    }

    fn line(&self, spec: &SerialSpec) -> Result<Line, (&'static str, String, String)> {
        let cannot = |error: std::io::Error| {
            let help = String::from("the machine has no room for it: see `ulimit -u` and `ulimit -n`");
            (codes::HOST, format!("the thread of a serial line cannot be started: {error}"), help)
        };
        let runtime = Builder::new_current_thread().enable_io().build().map_err(cannot)?;
        let shared = Arc::new(Shared::default());
        let port = {
            let _inside = runtime.enter();
            SerialPort::watched(&spec.port, Arc::clone(&shared.in_call)).map_err(|error| refused(&error))?
        };
        let worker = Worker {
            spec: spec.port.clone(),
            identity: Identity::of(&spec.port.path),
            framing: Framing::of(&spec.port.line, spec.message_gap),
            shared,
            bell: self.context.bell.clone(),
            reconnect: self.limits.reconnect,
            realtime: self.context.realtime,
        };
        let patience = self.limits.unresponsive_after;
        let running = Running::start(worker, runtime, port, patience).map_err(cannot)?;
        let device = spec.port.path.display().to_string();
        Ok(Line { bus: spec.bus, device, running, lost: None, ahead: None, dropped: 0, losses: 0, failed: 0 })
    }
}

impl Line {
    /// When it counts as silent unless the call that is under way ends.
    fn overdue(&self, limit: Span) -> Option<HostInstant> {
        Some(self.running.shared.in_call.get()? + limit)
    }

    /// Forgets what was on the line before now.
    fn restart(&mut self) {
        while self.running.reports.pop().is_ok() {}
        self.running.shared.overflowed.store(0, Ordering::Release);
        self.running.shared.latched.store(false, Ordering::Release);
        (self.lost, self.ahead, self.dropped) = (None, None, 0);
    }

    /// What passed on the line up to now.
    fn take(&mut self, time: &TimeBase, now: Time, out: &mut Vec<BusEvent>) {
        let (bus, stamp) = (self.bus, time.stamp(now));
        self.ahead = None;
        while let Ok(report) = self.running.reports.peek() {
            let (known, passed) = (report.last.1, report.passed);
            if known > stamp {
                self.ahead = Some(time.at(known));
                break;
            }
            let when = |(earliest, latest)| When::within(time.at(earliest), time.at(latest));
            let mut message = report.message;
            (message.first, message.last) = (when(report.first), when(report.last));
            // It is the one that was looked at.
            let _ = self.running.reports.pop();
            out.push(match passed {
                Passed::Received => BusEvent::SerialMessage { bus, message, own: false },
                Passed::Sent => BusEvent::SerialMessage { bus, message, own: true },
                Passed::NotSent => {
                    BusEvent::Error { bus, at: message.last.latest, error: BusError::SendTimeout }
                }
            });
        }
        let count = self.running.shared.overflowed.swap(0, Ordering::AcqRel);
        if count > 0 {
            self.dropped += u64::from(count);
            out.push(BusEvent::Dropped { bus, at: now, count });
        }
    }

    fn poll(&mut self, now: Time, stamp: HostInstant, limit: Span, out: &mut Vec<BusEvent>) {
        let losses = self.running.shared.losses.load(Ordering::Acquire);
        let gone = self.running.shared.gone.load(Ordering::Acquire);
        let silent = match self.lost {
            // It was silent. It answers again when no call is under way.
            Some(LossReason::Unresponsive) => self.overdue(limit).is_some(),
            _ => self.overdue(limit).is_some_and(|due| due < stamp),
        };
        let reason = if gone { Some(LossReason::Gone) } else { silent.then_some(LossReason::Unresponsive) };
        let bus = self.bus;
        if losses != self.losses {
            self.losses = losses;
            if self.lost != Some(LossReason::Gone) {
                // Even when it is back already.
                out.push(BusEvent::Lost { bus, at: now, reason: LossReason::Gone });
                self.lost = Some(LossReason::Gone);
            }
        }
        if reason == self.lost {
            return;
        }
        self.lost = reason;
        out.push(match reason {
            Some(reason) => BusEvent::Lost { bus, at: now, reason },
            None => BusEvent::Returned { bus, at: now },
        });
    }
}

/// What it means that a port does not open: the code, the words, and what mends it.
pub(crate) fn refused(error: &OpenError) -> (&'static str, String, String) {
    let (code, help) = match error {
        OpenError::Busy(path) => {
            let by = all_holders(path);
            let own = by.iter().all(|holder| holder.process == std::process::id());
            let message = format!("{} is held by {}", path.display(), words(&by, "somebody else"));
            let help = match own && !by.is_empty() {
                true => "that is this rig: another line of the board is on the same port",
                false => {
                    "end that program, or take another port; a console on it ends with \
                     `sudo systemctl stop serial-getty@ttyS0`"
                }
            };
            return (codes::SERIAL_BUSY, message, String::from(help));
        }
        OpenError::NoPort(_) => {
            (codes::SERIAL_NONE, String::from("name a serial port: `ls /dev/serial/by-id` lists adapters"))
        }
        OpenError::Cannot { key, .. } => {
            (codes::SERIAL_CANNOT, format!("change `{key}`, or take a port whose driver can do it"))
        }
        OpenError::Call(failed) => match Errno::from_raw_os_error(failed.code) {
            Errno::ACCESS | Errno::PERM => {
                let help = format!(
                    "`ls -l {}` shows the group that may: add yourself to it, as in `sudo usermod -aG dialout $USER`, \
                     and log in again",
                    failed.path.display()
                );
                (codes::SERIAL_ACCESS, help)
            }
            _ if error.is_gone() => (
                codes::SERIAL_MISSING,
                String::from("`ls /dev/serial/by-id` lists adapters, `dmesg` says what became of one"),
            ),
            _ => (codes::SERIAL_REFUSED, String::from("`dmesg` tells what the port's driver says")),
        },
    };
    (code, error.to_string(), help)
}

impl Board for SerialBoard {
    fn inner(&self) -> Option<&dyn Board> {
        None
    }

    fn inner_mut(&mut self) -> Option<&mut dyn Board> {
        None
    }

    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// Waits for ports that are being taken back, for two seconds or as long as one may be silent.
    fn start(&mut self, now: Time) -> Result<(), BoardError> {
        self.run.end();
        let due = HostInstant::now() + self.limits.unresponsive_after.max(START);
        for line in &mut self.lines {
            let shared = Arc::clone(&line.running.shared);
            while shared.gone.load(Ordering::Acquire) {
                let stamp = HostInstant::now();
                if !self.limits.reconnect || stamp >= due {
                    let since = shared.since.get().map_or(Span::ZERO, HostInstant::elapsed);
                    return Err(BoardError::BusLost { bus: line.bus, reason: LossReason::Gone, since });
                }
                shared.answer.wait_until(due);
            }
            line.restart();
            line.losses = shared.losses.load(Ordering::Acquire);
            line.failed = shared.failed.load(Ordering::Acquire);
        }
        self.run.begin(now);
        Ok(())
    }

    fn write(&mut self, now: Time, writes: &[(ChannelId, Value)]) -> Result<(), BoardError> {
        self.run.come_to(now)?;
        drives_none(&self.channels, writes)
    }

    fn poll(&mut self, now: Time, _out: &mut Vec<BoardEvent>) -> Result<(), BoardError> {
        self.run.come_to(now)
    }

    /// When a port whose call is under way counts as lost.
    fn next_event(&self) -> Option<Time> {
        let answering = self.lines.iter().filter(|line| line.lost.is_none());
        let owed = answering.filter_map(|line| line.overdue(self.limits.unresponsive_after));
        self.run.next_event(&self.context.time, owed)
    }

    /// What waits is not sent: a line that nobody sends on is idle.
    fn safe(&mut self, now: Time) -> Result<(), BoardError> {
        for line in &self.lines {
            line.running.shared.latched.store(true, Ordering::Release);
        }
        self.run.latch(now);
        Ok(())
    }

    fn health(&self) -> Health {
        let failed = |line: &Line| line.running.shared.failed.load(Ordering::Acquire) - line.failed;
        Health {
            lost: self.lines.iter().filter(|line| line.lost.is_some()).count() as u32,
            dropped: self.lines.iter().map(|line| line.dropped).sum(),
            failed_calls: self.lines.iter().map(failed).sum(),
            latched_safe: self.run.is_latched(),
            ..Health::default()
        }
    }

    fn buses(&self) -> Option<&dyn Buses> {
        Some(self)
    }

    fn buses_mut(&mut self) -> Option<&mut dyn Buses> {
        Some(self)
    }
}

impl Buses for SerialBoard {
    fn bus_list(&self) -> &[Bus] {
        &self.buses
    }

    fn bus_device(&self, bus: BusId) -> Option<&str> {
        self.lines.iter().find(|line| line.bus == bus).map(|line| line.device.as_str())
    }

    fn send(&mut self, now: Time, bus: BusId, _frame: &CanFrame) -> Result<(), BoardError> {
        self.run.come_to(now)?;
        let known = self.lines.iter().any(|line| line.bus == bus);
        Err(if known { BoardError::BadFrame(bus) } else { BoardError::NoBus(bus) })
    }

    fn send_serial(&mut self, now: Time, bus: BusId, output: &SerialOutput) -> Result<(), BoardError> {
        self.run.drive_at(now)?;
        let line = self.lines.iter_mut().find(|line| line.bus == bus).ok_or(BoardError::NoBus(bus))?;
        let order = Order::of(output).ok_or(BoardError::BadFrame(bus))?;
        if line.running.order(order) { Ok(()) } else { Err(BoardError::BusFull(bus)) }
    }

    fn poll_buses(&mut self, now: Time, out: &mut Vec<BusEvent>) -> Result<(), BoardError> {
        self.run.come_to(now)?;
        let stamp = self.context.time.stamp(now);
        let first = out.len();
        for line in &mut self.lines {
            line.take(&self.context.time, now, out);
            line.poll(now, stamp, self.limits.unresponsive_after, out);
        }
        crate::event_collector::sort_by(&mut out[first..], BusEvent::latest);
        self.run.lies_ahead(self.lines.iter().filter_map(|line| line.ahead).min());
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMIT: Span = Span::from_millis(100);

    fn line(shared: Arc<Shared>) -> Line {
        let running = Running::ended(shared);
        Line {
            bus: BusId(3),
            device: String::new(),
            running,
            lost: None,
            ahead: None,
            dropped: 0,
            losses: 0,
            failed: 0,
        }
    }

    fn poll(line: &mut Line, nanos: i64) -> Vec<BusEvent> {
        let mut out = Vec::new();
        line.poll(Time::from_nanos(nanos), HostInstant::from_nanos(nanos), LIMIT, &mut out);
        out
    }

    #[test]
    fn a_call_that_lasts_too_long_is_silence_until_it_ends() {
        let shared = Arc::new(Shared::default());
        let mut line = line(shared.clone());
        let bus = BusId(3);
        assert_eq!(poll(&mut line, 10), []);
        shared.in_call.set(HostInstant::from_nanos(20));
        let due = line.overdue(LIMIT).unwrap().as_nanos();
        assert_eq!(due, 20 + LIMIT.as_nanos());
        assert_eq!(poll(&mut line, due), []);
        let at = Time::from_nanos(due + 1);
        assert_eq!(poll(&mut line, due + 1), [BusEvent::Lost { bus, at, reason: LossReason::Unresponsive }]);
        assert_eq!(poll(&mut line, due + 2), []);
        shared.in_call.clear();
        let at = Time::from_nanos(due + 3);
        assert_eq!(poll(&mut line, due + 3), [BusEvent::Returned { bus, at }]);
    }

    #[test]
    fn a_loss_is_told_though_the_port_is_back_before_anybody_looked() {
        let shared = Arc::new(Shared::default());
        let mut line = line(shared.clone());
        let (bus, at) = (BusId(3), Time::from_nanos(5));
        shared.losses.store(1, Ordering::Release);
        let told = [BusEvent::Lost { bus, at, reason: LossReason::Gone }, BusEvent::Returned { bus, at }];
        assert_eq!(poll(&mut line, 5), told);
        assert_eq!(poll(&mut line, 6), []);
        shared.losses.store(2, Ordering::Release);
        shared.gone.store(true, Ordering::Release);
        assert_eq!(poll(&mut line, 7).len(), 1);
        // Back and away again: still away.
        shared.losses.store(3, Ordering::Release);
        assert_eq!(poll(&mut line, 8), []);
    }
}
