//! The board of devices of one kind, each of which has a thread of its own: converters, counters, generators.

use std::fmt::{self, Debug};
use std::ops::Range;

use document::Diagnostic;
use host::HostInstant;
use rustix::io::Errno;
use signal::{Time, Value};

use crate::board::{Board, BoardError, Call, Descriptions, PulseOutputs};
use crate::channel::{Channel, ChannelId, Emission, NotEmitted};
use crate::context::BoardContext;
use crate::device_limits::DeviceLimits;
use crate::event::{BoardEvent, Health};
use crate::event_collector::EventCollector;
use crate::output_claim::OutputClaim;
use crate::refusal::Refusal;
use crate::run_state::{RunState, START, drives_none};

/// The board's end of a device: its thread reports, this end takes the reports in. Nothing waits for the device but where it
/// says so.
pub trait DeviceHandle: Debug + Send {
    /// Whether its channels are driven.
    const DRIVES: bool;

    /// What messages call it.
    fn device(&self) -> &str;

    /// What it is, in a word for clients.
    fn kind(&self) -> &'static str;

    /// Its channels, by the places of its inputs or outputs.
    fn channels(&self) -> Vec<ChannelId>;

    /// Asks for a new run. The number of this request.
    fn ask_start(&mut self) -> u64;

    /// Waits until the run has begun. FALSE where it has not by then, or the device is gone and is not opened again.
    fn await_start(&mut self, request: u64, due: HostInstant, reconnect: bool) -> bool;

    /// What a start says that could not begin.
    fn loss(&self) -> BoardError;

    /// Reports what its channels are at the start of a run, or when it is there again.
    fn present(&self, at: Time, collector: &mut EventCollector<'_>);

    /// Reports what happened up to now; `latched`: nothing is driven any more. TRUE where there is more than one poll reports.
    fn poll(&mut self, latched: bool, collector: &mut EventCollector<'_>) -> bool;

    /// When the device counts as unresponsive if it does not answer by then.
    fn overdue(&self) -> Option<HostInstant>;

    /// Asks for the end of a run, outputs safe. The number of this request.
    fn ask_safe(&mut self) -> u64;

    /// Waits for that, at most until then.
    ///
    /// # Errors
    /// Its outputs are not safe.
    fn await_safe(&self, request: u64, due: HostInstant) -> Result<(), Errno>;

    /// Channels that are lost with the device.
    fn lost_channels(&self) -> u32;

    /// Calls that failed since the start.
    fn failed_calls(&self) -> u64;

    /// The noise of the channel at this place.
    fn noise(&self, place: usize) -> Option<f64> {
        let _ = place;
        None
    }

    /// Whether the channel at this place can be driven to this.
    ///
    /// # Errors
    /// It takes no such value.
    fn takes(&self, place: usize, value: Value) -> Result<(), BoardError> {
        let _ = (place, value);
        Ok(())
    }

    /// Drives the channel at this place.
    ///
    /// # Errors
    /// The device has more orders than it will ever come to.
    fn write(&mut self, place: usize, value: Value) -> Result<(), BoardError> {
        let _ = (place, value);
        Ok(())
    }

    /// Has the channel at this place emit what it can emit.
    ///
    /// # Errors
    /// As [`DeviceHandle::write`].
    fn emit(&mut self, place: usize, emission: &Emission) -> Result<(), BoardError> {
        let _ = (place, emission);
        Ok(())
    }
}

/// How a device is opened again when it was gone; it is called on the device's thread.
pub struct Reopen<D: ?Sized>(Box<dyn FnMut() -> Option<Box<D>> + Send>);

impl<D: ?Sized> Reopen<D> {
    /// By this call: `None` where the device is not there.
    pub fn new(open: impl FnMut() -> Option<Box<D>> + Send + 'static) -> Reopen<D> {
        Reopen(Box::new(open))
    }

    /// The device, if it is there again.
    pub(crate) fn open(&mut self) -> Option<Box<D>> {
        (self.0)()
    }
}

impl<D: ?Sized> Debug for Reopen<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Reopen")
    }
}

/// All of these devices, each opened at its place in a file, or what is wrong with those that cannot be had.
pub(crate) fn all_opened<T>(
    file: &str,
    devices: impl Iterator<Item = (Range<usize>, Result<T, Refusal>)>,
) -> Result<Vec<T>, Vec<Diagnostic>> {
    let (mut all, mut found) = (Vec::new(), Vec::new());
    for (place, opened) in devices {
        match opened {
            Ok(device) => all.push(device),
            Err(refusal) => found.push(refusal.finding(file, place)),
        }
    }
    if found.is_empty() { Ok(all) } else { Err(found) }
}

/// Devices of one kind as a board. Each has a thread of its own; no call of the board waits for one but its start and, where
/// something is driven, its safe state.
#[derive(Debug)]
pub struct DeviceBoard<H> {
    channels: Vec<Channel>,
    /// The device behind each channel, and the place of the channel there.
    behind: Vec<Option<(u16, u16)>>,
    limits: DeviceLimits,
    context: BoardContext,
    devices: Vec<H>,
    /// Claims for whoever makes outputs safe when the rig cannot.
    claims: Vec<OutputClaim>,
    run: RunState,
}

impl<H: DeviceHandle> DeviceBoard<H> {
    /// A board of devices that are at work.
    pub(crate) fn new(
        channels: Vec<Channel>,
        limits: DeviceLimits,
        context: &BoardContext,
        devices: Vec<H>,
        claims: Vec<OutputClaim>,
    ) -> DeviceBoard<H> {
        let mut behind = vec![None; channels.len()];
        for (device, handle) in devices.iter().enumerate() {
            for (place, channel) in handle.channels().into_iter().enumerate() {
                if let Some(behind) = behind.get_mut(usize::from(channel.0)) {
                    *behind = Some((device as u16, place as u16));
                }
            }
        }
        let context = context.clone();
        DeviceBoard { channels, behind, limits, context, devices, claims, run: RunState::default() }
    }

    /// The device behind a channel, and the place of the channel there.
    fn behind(&self, channel: ChannelId) -> Result<(usize, usize), BoardError> {
        let behind = self.behind.get(usize::from(channel.0)).ok_or(BoardError::NoChannel(channel))?;
        let (device, place) = behind.ok_or(BoardError::NotDriven(channel))?;
        Ok((usize::from(device), usize::from(place)))
    }
}

impl<H: DeviceHandle> Board for DeviceBoard<H> {
    fn inner(&self) -> Option<&dyn Board> {
        None
    }

    fn inner_mut(&mut self) -> Option<&mut dyn Board> {
        None
    }

    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// Waits for the devices, as long as one may be unresponsive or two seconds, and for pulses that are under way.
    fn start(&mut self, now: Time) -> Result<(), BoardError> {
        self.run.end();
        let requests: Vec<u64> = self.devices.iter_mut().map(H::ask_start).collect();
        let due = HostInstant::now() + self.limits.unresponsive_after.max(START);
        for (device, request) in self.devices.iter_mut().zip(requests) {
            if !device.await_start(request, due, self.limits.reconnect) {
                return Err(device.loss());
            }
        }
        self.run.begin(now);
        self.run.start_unreported();
        Ok(())
    }

    fn write(&mut self, now: Time, writes: &[(ChannelId, Value)]) -> Result<(), BoardError> {
        if !H::DRIVES {
            self.run.come_to(now)?;
            return drives_none(&self.channels, writes);
        }
        self.run.drive_at(now)?;
        for (channel, value) in writes {
            let (device, place) = self.behind(*channel)?;
            self.devices[device].takes(place, *value)?;
        }
        for (channel, value) in writes {
            let (device, place) = self.behind(*channel)?;
            self.devices[device].write(place, *value)?;
        }
        Ok(())
    }

    fn poll(&mut self, now: Time, out: &mut Vec<BoardEvent>) -> Result<(), BoardError> {
        self.run.come_to(now)?;
        let mut collector = EventCollector::new(out, &self.context.time, now);
        if let Some(start) = self.run.take_fresh() {
            self.devices.iter().for_each(|device| device.present(start, &mut collector));
        }
        let mut more = false;
        for device in &mut self.devices {
            more |= device.poll(self.run.is_latched(), &mut collector);
        }
        if more {
            collector.goes_on();
            self.context.bell.ring();
        }
        self.run.polled(collector);
        Ok(())
    }

    /// What lies ahead of the last poll or was left to the next, and when a device whose answer is due counts as lost.
    fn next_event(&self) -> Option<Time> {
        let deadlines = self.devices.iter().filter_map(H::overdue);
        self.run.next_event(&self.context.time, deadlines)
    }

    /// Waits for devices that drive, as long as one may be unresponsive. One that hangs is made safe as soon as its call ends.
    fn safe(&mut self, now: Time) -> Result<(), BoardError> {
        self.run.latch(now);
        let requests: Vec<u64> = self.devices.iter_mut().map(H::ask_safe).collect();
        let due = HostInstant::now() + self.limits.unresponsive_after;
        let mut outcome = Ok(());
        for (device, request) in self.devices.iter().zip(requests) {
            let safe = device.await_safe(request, due);
            let failed = |errno: Errno| BoardError::Os { call: Call::Write, code: errno.raw_os_error() };
            outcome = outcome.and(safe.map_err(failed));
        }
        outcome
    }

    fn health(&self) -> Health {
        Health {
            lost: self.devices.iter().map(H::lost_channels).sum(),
            dropped: self.run.dropped(),
            failed_calls: self.devices.iter().map(H::failed_calls).sum(),
            latched_safe: self.run.is_latched(),
            ..Health::default()
        }
    }

    fn pulse_outputs(&mut self) -> Option<&mut dyn PulseOutputs> {
        if H::DRIVES { Some(self) } else { None }
    }

    fn output_claims(&self) -> Result<Vec<OutputClaim>, BoardError> {
        let refused = |error: std::io::Error| BoardError::Os {
            call: Call::Open,
            code: error.raw_os_error().unwrap_or(Errno::MFILE.raw_os_error()),
        };
        self.claims.iter().map(OutputClaim::try_clone).collect::<std::io::Result<_>>().map_err(refused)
    }

    fn descriptions(&self) -> Option<&dyn Descriptions> {
        Some(self)
    }
}

impl<H: DeviceHandle> PulseOutputs for DeviceBoard<H> {
    fn emit(&mut self, now: Time, channel: ChannelId, emission: &Emission) -> Result<(), BoardError> {
        self.run.drive_at(now)?;
        let (device, place) = self.behind(channel)?;
        let Some(emits) = &self.channels[usize::from(channel.0)].emits else {
            return Err(BoardError::NotEmitted(channel, NotEmitted::Nothing));
        };
        emits.check(emission).map_err(|why| BoardError::NotEmitted(channel, why))?;
        self.devices[device].emit(place, emission)
    }
}

impl<H: DeviceHandle> Descriptions for DeviceBoard<H> {
    fn device(&self, channel: ChannelId) -> Option<&str> {
        let (device, _) = self.behind(channel).ok()?;
        Some(self.devices[device].device())
    }

    fn device_kind(&self, channel: ChannelId) -> Option<&'static str> {
        let (device, _) = self.behind(channel).ok()?;
        Some(self.devices[device].kind())
    }

    fn noise(&self, channel: ChannelId) -> Option<f64> {
        let (device, place) = self.behind(channel).ok()?;
        self.devices[device].noise(place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::channel_table::ChannelTable;
    use crate::circuit::{ChannelSpec, Pull};
    use host::Realtime;
    use signal::Span;

    /// A device without a thread: what the board asked of it, and what it answers.
    #[derive(Debug, Default)]
    struct Silent {
        channels: Vec<ChannelId>,
        asked: u64,
        starts: bool,
        safe: bool,
    }

    impl DeviceHandle for Silent {
        const DRIVES: bool = true;

        fn device(&self) -> &str {
            "silent"
        }

        fn kind(&self) -> &'static str {
            "test"
        }

        fn channels(&self) -> Vec<ChannelId> {
            self.channels.clone()
        }

        fn ask_start(&mut self) -> u64 {
            self.asked += 1;
            self.asked
        }

        fn await_start(&mut self, request: u64, _due: HostInstant, _reconnect: bool) -> bool {
            assert_eq!(request, self.asked);
            self.starts
        }

        fn loss(&self) -> BoardError {
            let reason = crate::event::LossReason::Unresponsive;
            BoardError::Lost { channel: self.channels[0], reason, since: Span::ZERO }
        }

        fn present(&self, _at: Time, _collector: &mut EventCollector<'_>) {}

        fn poll(&mut self, _latched: bool, _collector: &mut EventCollector<'_>) -> bool {
            false
        }

        fn overdue(&self) -> Option<HostInstant> {
            None
        }

        fn ask_safe(&mut self) -> u64 {
            self.asked += 1;
            self.asked
        }

        fn await_safe(&self, _request: u64, _due: HostInstant) -> Result<(), Errno> {
            if self.safe { Ok(()) } else { Err(Errno::TIMEDOUT) }
        }

        fn lost_channels(&self) -> u32 {
            self.channels.len() as u32
        }

        fn failed_calls(&self) -> u64 {
            1
        }
    }

    fn board(devices: Vec<Silent>) -> DeviceBoard<Silent> {
        let channels = ["a", "b", "c", "d"].map(|name| ChannelSpec::digital(name, Pull::Down));
        let table = ChannelTable { file: "bench.toml".into(), channels: channels.to_vec() };
        let context = BoardContext::new(Realtime::default());
        DeviceBoard::new(table.blank(), DeviceLimits::default(), &context, devices, Vec::new())
    }

    fn silent(channels: &[u16], starts: bool, safe: bool) -> Silent {
        Silent { channels: channels.iter().map(|id| ChannelId(*id)).collect(), asked: 0, starts, safe }
    }

    #[test]
    fn one_device_that_does_not_start_ends_the_start_and_names_its_channel() {
        let mut board = board(vec![silent(&[0], true, true), silent(&[2, 3], false, true)]);
        let lost = board.start(Time::ZERO).unwrap_err();
        assert!(matches!(lost, BoardError::Lost { channel: ChannelId(2), .. }), "{lost:?}");
        assert_eq!(board.write(Time::ZERO, &[]), Err(BoardError::NotStarted));
    }

    #[test]
    fn every_device_is_asked_to_be_safe_and_one_that_is_not_is_an_error() {
        let mut board = board(vec![silent(&[0], true, false), silent(&[1], true, true)]);
        board.start(Time::ZERO).unwrap();
        let unsafe_output = BoardError::Os { call: Call::Write, code: Errno::TIMEDOUT.raw_os_error() };
        assert_eq!(board.safe(Time::ZERO), Err(unsafe_output));
        assert_eq!(board.devices.iter().map(|device| device.asked).collect::<Vec<_>>(), [2, 2]);
        assert_eq!(board.write(Time::ZERO, &[]), Err(BoardError::Latched));
        let health = board.health();
        assert_eq!((health.lost, health.failed_calls, health.latched_safe), (2, 2, true));
    }

    #[test]
    fn a_channel_without_a_device_is_not_driven_and_has_none() {
        let mut board = board(vec![silent(&[1], true, true)]);
        board.start(Time::ZERO).unwrap();
        let write =
            |board: &mut DeviceBoard<Silent>, id| board.write(Time::ZERO, &[(ChannelId(id), Value::HighZ)]);
        assert_eq!(write(&mut board, 1), Ok(()));
        assert_eq!(write(&mut board, 0), Err(BoardError::NotDriven(ChannelId(0))));
        assert_eq!(write(&mut board, 9), Err(BoardError::NoChannel(ChannelId(9))));
        assert_eq!((board.device(ChannelId(1)), board.device(ChannelId(0))), (Some("silent"), None));
    }
}
