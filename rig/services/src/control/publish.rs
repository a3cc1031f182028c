//! What the rig reports is handed on to those who want it.

use std::fmt::Write;
use std::rc::Rc;

use control::{PlanEvent, RigLogLine, Status, SubscriptionEvent};
use serde::Serialize;
use signal::{Span, Time};

use super::client::ClientId;
use super::hub::{Hub, StatusCache};
use super::rig::RigEvent;
use super::topic::{Of, Subscription};

/// Changes in one message.
const CHANGES: usize = 512;
/// Lines of the log that are kept for those who come later.
const LINES: usize = 1_000;
/// What a case reported that is kept for those who come later.
const PLAN_EVENTS: usize = 1_000;
/// What is reported of a plan may wait in a longer queue: it is little, and a verdict that is missing is missed.
const PLAN_QUEUES: usize = 8;
/// A status is reported at least so often, so that a client knows that the rig is there.
const SIGN_OF_LIFE: Span = Span::from_secs(1);

impl Hub {
    /// Takes what the rig reports.
    pub(super) fn receive_event(&mut self, event: RigEvent, now: Time) {
        match event {
            RigEvent::Change { signal, at, value } => {
                let Some(watchers) = self.watched.get(&signal) else { return };
                let stepped = self.is_stepped();
                for (id, number) in watchers {
                    let Some(client) = self.clients.get_mut(id) else { continue };
                    let room = client.has_room(self.settings.limits.queue);
                    let Some(one) = client.subscriptions.get_mut(number) else { continue };
                    let Of::Signals { waiting, .. } = &mut one.of else { continue };
                    // In stepped time messages are cut by the rig's own time: the same each time. And rather
                    // than that something is missed, a message comes early.
                    let due = stepped && at.latest >= one.due;
                    if room && one.due != Time::MAX && (due || waiting.is_full()) {
                        while publish_changes(*number, one, &mut client.out, now) && due {}
                        if due {
                            one.due = at.latest + one.every;
                        }
                        self.touched.insert(*id);
                    }
                    if let Of::Signals { waiting, .. } = &mut one.of {
                        waiting.put(signal, at, value);
                    }
                }
            }
            RigEvent::Answer(ticket, answer) => self.answered(ticket, answer, now),
            RigEvent::Log(at, text) => self.log(at.as_nanos(), &text, now),
            RigEvent::Frame(frame) => {
                self.publish(|of| matches!(of, Of::Frames), "frame", "frame", &frame, 1, now);
            }
            RigEvent::Plan(event) => {
                self.publish(|of| matches!(of, Of::Plan), "plan", "told", &event, PLAN_QUEUES, now);
                if matches!(event, PlanEvent::Case { .. }) {
                    self.plan.clear();
                }
                if self.plan.len() < PLAN_EVENTS {
                    self.plan.push(event);
                }
            }
            RigEvent::Ended(why) => self.end(&why, now),
        }
    }

    /// Writes a line into the log.
    pub(super) fn log(&mut self, at: i64, text: &str, now: Time) {
        if self.log.len() == LINES {
            self.log.pop_front();
        }
        self.log.push_back(RigLogLine { at, text: text.into() });
        let ids: Vec<ClientId> = self.clients.keys().copied().collect();
        for id in ids {
            let queue = self.settings.limits.queue;
            let Some(client) = self.clients.get_mut(&id) else { continue };
            for (&subscription, one) in &mut client.subscriptions {
                if !matches!(one.of, Of::Log) || one.due == Time::MAX {
                    continue;
                }
                if client.out.len() >= queue {
                    one.missed += 1;
                    continue;
                }
                publish_missed(subscription, one, &mut client.out, now);
                client.out.put(&SubscriptionEvent::Log { subscription, at, text: text.into() }, now);
                self.touched.insert(id);
            }
        }
    }

    /// Sends a line to everyone who is subscribed to its topic; it is written once for all of them.
    fn publish(
        &mut self,
        is: impl Fn(&Of) -> bool,
        event: &str,
        field: &str,
        what: &impl Serialize,
        queues: usize,
        now: Time,
    ) {
        let queue = self.settings.limits.queue * queues;
        let mut line: Option<String> = None;
        for (id, client) in &mut self.clients {
            let room = client.has_room(queue);
            for (number, one) in &mut client.subscriptions {
                if !is(&one.of) || one.due == Time::MAX {
                    continue;
                }
                if !room {
                    one.missed += 1;
                    continue;
                }
                publish_missed(*number, one, &mut client.out, now);
                let line = line.get_or_insert_with(|| serde_json::to_string(what).unwrap_or_default());
                let mut head = String::new();
                let _ = write!(head, "{{\"event\":\"{event}\",\"subscription\":{number},\"{field}\":");
                client.out.put_written(&[&head, line, "}"], now);
                self.touched.insert(*id);
            }
        }
    }

    /// Sends what is due to those who have room for it.
    pub(super) fn flush(&mut self, now: Time) {
        if !self.is_stepped() {
            self.flush_those(now, |one| one.due <= now, None);
        } else {
            self.flush_those(now, |one| one.due == Time::MIN, None);
        }
    }

    /// Sends everything that waits: `to` even if its queue is full, since it asks for nothing more before it is read.
    pub(super) fn flush_all(&mut self, to: Option<ClientId>, now: Time) {
        self.flush_those(now, |one| one.due != Time::MAX, to);
    }

    fn flush_those(&mut self, now: Time, due: impl Fn(&Subscription) -> bool, all_to: Option<ClientId>) {
        let stepped = self.is_stepped();
        let queue = self.settings.limits.queue;
        let at = if stepped { Time::from_nanos(self.current_status().status.at) } else { now };
        let ids: Vec<ClientId> = self.clients.keys().copied().collect();
        for id in ids {
            let Some(client) = self.clients.get(&id) else { continue };
            if client.subscriptions.is_empty() {
                continue;
            }
            let wants_status =
                client.subscriptions.values().any(|one| matches!(one.of, Of::Status { .. }) && due(one));
            let line = wants_status.then(|| (self.status_line(), self.status_cache.edition));
            let Some(client) = self.clients.get_mut(&id) else { continue };
            let before = client.out.len();
            for (number, one) in &mut client.subscriptions {
                let room = client.out.len() < queue || all_to == Some(id);
                if !room || !due(one) {
                    // Where time is stepped nothing else would bring it up again.
                    if stepped && !room && due(one) {
                        one.due = Time::MIN;
                    }
                    continue;
                }
                publish_missed(*number, one, &mut client.out, now);
                let next = at + one.every;
                match &mut one.of {
                    Of::Signals { waiting, .. } => {
                        if waiting.is_empty() {
                            continue;
                        }
                        one.due = next;
                        while client.out.len() < queue || all_to == Some(id) {
                            if !publish_changes(*number, one, &mut client.out, now) {
                                break;
                            }
                        }
                        if matches!(&one.of, Of::Signals { waiting, .. } if !waiting.is_empty()) {
                            one.due = if stepped { Time::MIN } else { now };
                        }
                    }
                    Of::Status { reported, last } => {
                        let Some((line, edition)) = &line else { continue };
                        one.due = next;
                        let silent = !stepped && now - *last >= SIGN_OF_LIFE;
                        if *reported == Some(*edition) && !silent {
                            continue;
                        }
                        (*reported, *last) = (Some(*edition), now);
                        let mut head = String::new();
                        let _ = write!(head, "{{\"event\":\"status\",\"subscription\":{number},\"status\":");
                        client.out.put_written(&[&head, line, "}"], now);
                    }
                    Of::Log | Of::Frames | Of::Plan => {}
                }
            }
            if client.out.len() != before {
                self.touch(id);
            }
        }
    }

    /// The status as of this turn.
    pub(super) fn current_status(&mut self) -> &StatusCache {
        if !self.status_cache.fresh {
            let before = std::mem::replace(&mut self.status_cache.status, self.rig.status());
            self.status_cache.status.clients = u32::try_from(self.clients.len()).unwrap_or(u32::MAX);
            self.status_cache.status.locked = self.lock.now().cloned();
            self.name_forces();
            let status = &self.status_cache.status;
            if *status != (Status { at: status.at, ..before }) {
                self.status_cache.edition += 1;
            }
            self.status_cache.line = None;
            self.status_cache.fresh = true;
        }
        &self.status_cache
    }

    /// The status as it stands in a line.
    pub(super) fn status_line(&mut self) -> Rc<str> {
        self.current_status();
        let StatusCache { line, status, .. } = &mut self.status_cache;
        line.get_or_insert_with(|| serde_json::to_string(status).unwrap_or_default().into()).clone()
    }
}

/// Sends the next changes of a subscription; whether there were any.
fn publish_changes(
    subscription: u64,
    one: &mut Subscription,
    out: &mut super::outbox::ClientOutbox,
    now: Time,
) -> bool {
    let Of::Signals { waiting, .. } = &mut one.of else { return false };
    if waiting.is_empty() {
        return false;
    }
    let (changes, missed) = waiting.take(CHANGES);
    out.put(&SubscriptionEvent::Signals { subscription, changes, missed }, now);
    true
}

/// Reports how many lines of a subscription were left out, if any were.
fn publish_missed(
    subscription: u64,
    one: &mut Subscription,
    out: &mut super::outbox::ClientOutbox,
    now: Time,
) {
    let lines = std::mem::take(&mut one.missed);
    if lines > 0 {
        out.put(&SubscriptionEvent::Missed { subscription, lines }, now);
    }
}
