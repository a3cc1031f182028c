//! What the guard does: one loop that waits for messages, deaths and deadlines, and never for a device.

mod goodbye;
mod pending;
mod say;

use crate::Reason;
use crate::driver::Driver;
use crate::lines::OutputLines;
use crate::page::Page;
use crate::takeover::{Listener, TakeoverRequest};
use crate::wire::{Descriptors, GuardMessage, PWM, Tag};
use drivers::{Bite, LineApi, OutputClaim};
use host::{HostInstant, WatchdogDevice};
use nix::sys::signalfd::SignalFd;
use pending::PendingRequest;
use rustix::event::{PollFd, PollFlags, poll};
use rustix::io::{Errno, read};
use rustix::process::{Signal, pidfd_send_signal};
use rustix::time::Timespec;
use signal::Span;
use std::os::fd::{AsFd, OwnedFd};
use std::sync::Arc;

/// How soon lines are driven again while a write that began before the latch may still come.
const AGAIN: Span = Span::from_millis(2);

/// How soon lines that could not be made safe are tried again once the rig is gone.
const RETRY: Span = Span::from_millis(100);

/// Parts of the limit between two signs of life of the guard.
const SIGNS: i64 = 4;

/// How the guard ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ending {
    /// The rig said goodbye.
    Goodbye,
    /// The rig is gone; the outputs were safe, and their lines were let go.
    LetGo,
    /// The rig is gone and the outputs could not be made safe.
    Unsafe,
}

/// Where things stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum WatchState {
    /// The rig does not drive: nothing is expected of it but to live.
    Idle,
    /// The rig drives and gives signs of life.
    Armed,
    /// The latch closed at this instant, and the rig's process may still be there.
    Latched(HostInstant),
    /// The rig's process is gone since this instant; its lines are held until they were safe for long enough.
    Alone(HostInstant),
}

/// The watchdog behind the guard.
#[derive(Debug)]
pub(crate) struct FedWatchdog {
    watchdog: WatchdogDevice,
    bite: Bite,
    /// When it is fed next.
    due: HostInstant,
}

impl FedWatchdog {
    /// It is fed from now on.
    pub fn new(watchdog: WatchdogDevice, bite: Bite) -> FedWatchdog {
        FedWatchdog { watchdog, bite, due: HostInstant::BOOT }
    }

    /// Feeds it if it is due.
    fn feed(&mut self, now: HostInstant) {
        if now >= self.due {
            // A device that refuses bites: that is what it is there for.
            let _ = self.watchdog.feed();
            self.due = now + part(self.watchdog.timeout(), 4);
        }
    }
}

/// An even part of a time.
fn part(whole: Span, parts: i64) -> Span {
    Span::from_nanos(whole.as_nanos() / parts)
}

/// What ended a wait.
#[derive(Clone, Copy)]
enum Source {
    Link,
    Rig,
    Lines,
    End,
    Listener,
    TakeoverRequest,
}

/// What the guard gets at its start.
pub(crate) struct GuardSetup {
    /// To the rig.
    pub link: OwnedFd,
    /// The rig's process.
    pub rig: OwnedFd,
    /// The page that it shares with the rig.
    pub page: Page,
    /// Where SIGTERM is heard.
    pub ends: SignalFd,
    /// A counter that lines report to.
    pub finished: Arc<OwnedFd>,
    /// The watchdog, if it has one.
    pub watchdog: Option<FedWatchdog>,
    /// The longest that the rig may give no sign of life.
    pub limit: Span,
    /// How long lines are held after the death of the rig.
    pub hold: Span,
}

/// Makes lines of a claim.
pub(crate) type LinesOpener<'a> = &'a dyn Fn(OutputClaim) -> Box<dyn OutputLines>;

/// The guard at work.
pub(crate) struct GuardLoop<'a> {
    link: Option<OwnedFd>,
    rig: OwnedFd,
    page: Page,
    ends: SignalFd,
    finished: Arc<OwnedFd>,
    open: LinesOpener<'a>,
    watchdog: Option<FedWatchdog>,
    limit: Span,
    hold: Span,
    drivers: Vec<Driver>,
    state: WatchState,
    pending: Option<PendingRequest>,
    /// When lines are driven again.
    again: HostInstant,
    /// When the last wait was to end.
    wakes_at: HostInstant,
    /// The sign of life after which the machine stood still, and until when the rig has another chance.
    excused: Option<HostInstant>,
    chance: HostInstant,
    /// The lines may be let go: asked to end, or another rig needs them.
    release: bool,
    /// What became of the outputs was said.
    said: bool,
    listener: Option<Listener>,
    takeover: Option<TakeoverRequest>,
}

impl<'a> GuardLoop<'a> {
    /// A guard that has been introduced to its rig.
    pub fn new(setup: GuardSetup, open: LinesOpener<'a>) -> GuardLoop<'a> {
        GuardLoop {
            link: Some(setup.link),
            rig: setup.rig,
            page: setup.page,
            ends: setup.ends,
            finished: setup.finished,
            open,
            watchdog: setup.watchdog,
            limit: setup.limit.max(Span::from_nanos(1)),
            hold: setup.hold.max(Span::ZERO),
            drivers: Vec::new(),
            state: WatchState::Idle,
            pending: None,
            again: HostInstant::NEVER,
            wakes_at: HostInstant::NEVER,
            excused: None,
            chance: HostInstant::BOOT,
            release: false,
            said: false,
            listener: None,
            takeover: None,
        }
    }

    /// Watches until the end.
    pub fn run(mut self) -> Ending {
        loop {
            let now = HostInstant::now();
            self.page.guard_lives(now);
            if let Some(ending) = self.look(now) {
                return self.end(ending);
            }
            self.wait(now);
        }
    }

    /// What the time demands.
    fn look(&mut self, now: HostInstant) -> Option<Ending> {
        if self.state == WatchState::Armed && self.is_unresponsive(now) {
            self.latch(Reason::Unresponsive, now);
        }
        // First, or lines that are safe by now would be driven once more, and the answer would have to wait for that.
        if self.answer(now) {
            return Some(Ending::Goodbye);
        }
        if now >= self.again {
            self.drive_again(now);
        }
        if let WatchState::Latched(since) | WatchState::Alone(since) = self.state
            && self.are_safe(since)
        {
            self.page.is_safe(now);
        }
        let starved = self.starves(now);
        if let Some(watchdog) = self.watchdog.as_mut().filter(|_| !starved) {
            watchdog.feed(now);
        }
        let WatchState::Alone(since) = self.state else { return None };
        self.alone(since, now)
    }

    /// Whether the rig has given no sign of life for too long. A guard that wakes late itself has seen the machine stand
    /// still, and the rig with it: then the rig has one more chance, once for each sign of life.
    fn is_unresponsive(&mut self, now: HostInstant) -> bool {
        let last = self.page.rig();
        if now < last + self.limit || self.excused == Some(last) && now < self.chance {
            return false;
        }
        if now - self.wakes_at > part(self.limit, SIGNS) && self.excused != Some(last) {
            self.excused = Some(last);
            self.chance = now + part(self.limit, SIGNS);
            return false;
        }
        true
    }

    /// Whether the watchdog is left to bite.
    fn starves(&self, now: HostInstant) -> bool {
        let (Some(watchdog), WatchState::Latched(since) | WatchState::Alone(since)) =
            (&self.watchdog, self.state)
        else {
            return false;
        };
        let lost = self.page.latched().is_some_and(Reason::loses_rig);
        let rig_lost = watchdog.bite == Bite::RigLost && lost;
        rig_lost || now >= since + self.limit && !self.are_safe(since)
    }

    /// Waits for whatever comes first.
    fn wait(&mut self, now: HostInstant) {
        let mut until = now + part(self.limit, SIGNS);
        if self.state == WatchState::Armed {
            let chance = if self.excused == Some(self.page.rig()) { self.chance } else { HostInstant::BOOT };
            until = until.min((self.page.rig() + self.limit).max(chance));
        }
        if let Some(watchdog) = self.watchdog.as_ref().filter(|_| !self.starves(now)) {
            until = until.min(watchdog.due);
        }
        if let Some(pending) = &self.pending {
            until = until.min(pending.until);
        }
        until = until.min(self.again).max(now);
        self.wakes_at = until;
        let patience = (until - now).as_nanos();
        let patience = Timespec { tv_sec: patience / 1_000_000_000, tv_nsec: patience % 1_000_000_000 };
        let mut ready = [None; 6];
        {
            let mut set: [PollFd; 6] = std::array::from_fn(|_| PollFd::new(&self.finished, PollFlags::IN));
            let mut who = [Source::Lines; 6];
            let mut count = 1;
            let mut add = |source, descriptor| {
                set[count] = PollFd::from_borrowed_fd(descriptor, PollFlags::IN);
                who[count] = source;
                count += 1;
            };
            add(Source::End, self.ends.as_fd());
            if let Some(link) = &self.link {
                add(Source::Link, link.as_fd());
            }
            if !matches!(self.state, WatchState::Alone(_)) {
                add(Source::Rig, self.rig.as_fd());
            }
            if let Some(listener) = &self.listener {
                add(Source::Listener, listener.as_fd());
            }
            if let Some(takeover) = &self.takeover {
                add(Source::TakeoverRequest, takeover.as_fd());
            }
            // Interrupted or refused: the next turn looks at the time and comes back.
            if poll(&mut set[..count], Some(&patience)).is_ok() {
                for (place, ready) in ready.iter_mut().enumerate().take(count) {
                    *ready = (!set[place].revents().is_empty()).then_some(who[place]);
                }
            }
        }
        for source in ready.into_iter().flatten() {
            self.take(source);
        }
    }

    /// Takes what came from a source.
    fn take(&mut self, source: Source) {
        match source {
            Source::Lines => {
                let _ = read(&*self.finished, &mut [0; 8]);
            }
            Source::Rig => self.rig_is_gone(),
            Source::Link => self.message(),
            Source::End => {
                // While the rig lives only the rig can dismiss its guard.
                while let Ok(Some(_)) = self.ends.read_signal() {
                    self.release |= matches!(self.state, WatchState::Alone(_));
                }
            }
            Source::Listener => {
                self.takeover = self.listener.as_ref().and_then(Listener::accept);
            }
            Source::TakeoverRequest => self.answer_takeover(),
        }
    }

    /// A message of the rig, or the end of its messages.
    fn message(&mut self) {
        let Some(link) = &self.link else { return };
        match GuardMessage::receive(link) {
            Ok(Some((message, descriptors))) => self.obey(&message, descriptors),
            Err(Errno::AGAIN | Errno::INTR) => {}
            Ok(None) | Err(Errno::CONNRESET) => {
                // A process that ends closes this first, and is gone a moment later.
                self.link = None;
                self.latch(Reason::Exited, HostInstant::now());
            }
            Err(_) => self.latch(Reason::Nonsense, HostInstant::now()),
        }
    }

    fn obey(&mut self, message: &GuardMessage, descriptors: Descriptors) {
        let now = HostInstant::now();
        let latched = matches!(self.state, WatchState::Latched(_));
        match (message.tag, self.state) {
            (Tag::Forget, WatchState::Idle) => {
                for driver in self.drivers.drain(..) {
                    driver.let_go();
                }
                self.reply(Tag::Done, "");
            }
            (Tag::Release, WatchState::Idle | WatchState::Armed) => {
                let gone = self.drivers.extract_if(.., |driver| driver.device == message.text());
                gone.for_each(Driver::let_go);
                self.reply(Tag::Done, "");
            }
            (Tag::Hold, WatchState::Idle | WatchState::Armed) => match self.hold(message, descriptors) {
                Ok(()) => self.expect(Tag::Hold, now),
                Err(why) => self.reply(Tag::Refused, &why),
            },
            (Tag::Arm, WatchState::Idle) => {
                self.state = WatchState::Armed;
                self.again = HostInstant::NEVER;
                self.reply(Tag::Done, "");
            }
            (Tag::Disarm, WatchState::Armed | WatchState::Idle) => {
                self.state = WatchState::Idle;
                self.expect(Tag::Disarm, now);
            }
            (Tag::Trip, WatchState::Armed | WatchState::Idle) => {
                self.latch(Reason::Asked, now);
                self.expect(Tag::Trip, now);
            }
            (Tag::Close, _) => {
                if !latched {
                    self.state = WatchState::Idle;
                }
                self.expect(Tag::Close, now);
            }
            (Tag::Forget | Tag::Release | Tag::Hold | Tag::Arm | Tag::Disarm | Tag::Trip, _) if latched => {
                self.reply(Tag::Refused, "");
            }
            _ => self.latch(Reason::Nonsense, now),
        }
    }

    /// Takes charge of lines.
    fn hold(&mut self, message: &GuardMessage, mut descriptors: Descriptors) -> Result<(), String> {
        let claim = descriptors.next().ok_or("no descriptor came with it")?;
        let [lines, mask, safe, _] = message.numbers;
        let api = match u8::try_from(lines) {
            Ok(0) => LineApi::V2,
            Ok(lines @ 1..=64) => LineApi::V1 { lines },
            Err(_) if lines == PWM => LineApi::Pwm,
            _ => return Err("a claim has at most 64 lines".into()),
        };
        let (mask, device) = (mask.cast_unsigned(), message.text().to_owned());
        let safe = safe.cast_unsigned() & mask;
        let lines = (self.open)(OutputClaim { device: device.clone(), claim, api, mask, safe });
        let driver = Driver::start(device, lines, safe, &self.finished).map_err(|error| error.to_string())?;
        self.drivers.push(driver);
        Ok(())
    }

    /// Closes the latch: from now on the lines are safe and stay so.
    fn latch(&mut self, reason: Reason, now: HostInstant) {
        if matches!(self.state, WatchState::Latched(_) | WatchState::Alone(_)) {
            return;
        }
        self.page.latch(reason, now);
        self.state = WatchState::Latched(now);
        self.pending = None;
        if reason.loses_rig() {
            // A process that is gone already needs no signal.
            let _ = pidfd_send_signal(&self.rig, Signal::KILL);
        }
        self.drive(now);
    }

    /// Orders all lines to be driven safe from this instant on, and again before long.
    fn drive(&mut self, now: HostInstant) {
        self.drivers.iter().for_each(Driver::order);
        self.again = now + AGAIN;
    }

    /// The same for those that are not at it still.
    fn drive_again(&mut self, now: HostInstant) {
        self.drivers.iter().filter(|driver| driver.is_idle()).for_each(Driver::order);
        let hopeless = self.said && matches!(self.state, WatchState::Alone(_));
        self.again = now + if hopeless { RETRY } else { AGAIN };
    }

    /// Whether all lines were found safe by a drive that began at this instant or later.
    fn are_safe(&self, since: HostInstant) -> bool {
        self.drivers.iter().all(|driver| driver.is_safe(since))
    }

    /// The rig's process has ended: nothing of it can write any more. Nothing is allocated before the lines were driven.
    fn rig_is_gone(&mut self) {
        if matches!(self.state, WatchState::Alone(_)) {
            return;
        }
        let now = HostInstant::now();
        self.latch(Reason::Exited, now);
        self.state = WatchState::Alone(now);
        self.pending = None;
        self.link = None;
        self.drive(now);
    }
}
