//! Which signals the views want, and the subscriptions that bring them.

use super::Purpose;
use crate::model::RigModel;
use crate::views::View;
use control::{RequestOperation, SignalChange, Subscribed, Topic, WireValue};
use std::collections::{BTreeMap, BTreeSet};

/// The most names in one request, so that it stays far below the longest line.
const NAMES: usize = 200;

/// At most one message of the last values in so many milliseconds: the frames of the screen.
const LAST_EVERY: u32 = 100;

/// At most one message of all changes in so many milliseconds.
const ALL_EVERY: u32 = 50;

/// The signals that are wanted and those that come.
#[derive(Debug, Default)]
pub(super) struct SignalSubscriptions {
    /// What each view asked for last.
    by_view: Vec<BTreeSet<String>>,
    /// What was asked of the rig: names of signals of which the last value is enough, and of which every change is
    /// wanted. A name stands in one of the two.
    asked: [BTreeSet<String>; 2],
    /// How often each of the two was asked for again: answers to earlier requests are of no use any more.
    rounds: [u64; 2],
    /// The subscriptions: which of the two, and the names that were asked for by the numbers that they got. Two names
    /// can mean one signal.
    coming: BTreeMap<u64, (bool, BTreeMap<u32, Vec<String>>)>,
    /// Names that the rig does not know.
    refused: BTreeSet<String>,
}

impl SignalSubscriptions {
    /// Everything has to be asked for again: the connection is a new one.
    pub fn reset(&mut self) {
        self.asked = Default::default();
        self.coming.clear();
        self.refused.clear();
    }

    /// Looks at what the views want now, of which one is shown; what has to be asked of the rig.
    pub fn refresh(
        &mut self,
        views: &mut [Box<dyn View>],
        model: &mut RigModel,
    ) -> Vec<(RequestOperation, Purpose)> {
        let mut wanted: [BTreeSet<String>; 2] = Default::default();
        self.by_view.resize_with(views.len(), BTreeSet::new);
        for (view, before) in views.iter_mut().zip(&mut self.by_view) {
            let names = view.signals(model);
            let new = names.iter().filter(|(name, _)| !before.contains(name));
            for (name, _) in new {
                if let Some((at, value)) = model.values.get(name) {
                    view.changed(name, (*at, *at), *value);
                }
            }
            *before = names.iter().map(|(name, _)| name.clone()).collect();
            for (name, all) in names {
                wanted[usize::from(all)].insert(name);
            }
        }
        let [last, all] = &mut wanted;
        last.retain(|name| !all.contains(name) && !self.refused.contains(name));
        all.retain(|name| !self.refused.contains(name));
        if wanted == self.asked {
            return Vec::new();
        }
        let mut requests = Vec::new();
        for all in [false, true] {
            let place = usize::from(all);
            if wanted[place] != self.asked[place] {
                self.rounds[place] += 1;
                let names: Vec<&String> = wanted[place].iter().collect();
                for part in names.chunks(NAMES) {
                    requests.push(self.request(all, part.iter().map(|name| (*name).clone()).collect()));
                }
                if names.is_empty() {
                    self.retire(all, &mut requests);
                }
            }
        }
        model.values.retain(|name, _| wanted.iter().any(|names| names.contains(name)));
        self.asked = wanted;
        requests
    }

    fn request(&self, all: bool, names: Vec<String>) -> (RequestOperation, Purpose) {
        let round = self.rounds[usize::from(all)];
        let every_ms = if all { ALL_EVERY } else { LAST_EVERY };
        let topic = Topic::Signals { names: names.clone(), every_ms, all };
        (RequestOperation::Subscribe { topic }, Purpose::Signals { all, round, names })
    }

    /// Ends the subscriptions of one of the two.
    fn retire(&mut self, of: bool, requests: &mut Vec<(RequestOperation, Purpose)>) {
        self.coming.retain(|subscription, (all, _)| {
            if *all == of {
                requests
                    .push((RequestOperation::Unsubscribe { subscription: *subscription }, Purpose::Ignored));
            }
            *all != of
        });
    }

    /// The answer to a subscription; what it held before is over with it. What has to be asked then.
    pub fn subscribed(
        &mut self,
        (all, round): (bool, u64),
        asked: Vec<String>,
        answer: Subscribed,
        views: &mut [Box<dyn View>],
        model: &mut RigModel,
    ) -> Vec<(RequestOperation, Purpose)> {
        let mut requests = Vec::new();
        if round != self.rounds[usize::from(all)] {
            requests.push((
                RequestOperation::Unsubscribe { subscription: answer.subscription },
                Purpose::Ignored,
            ));
            return requests;
        }
        let mut names: BTreeMap<u32, Vec<String>> = BTreeMap::new();
        for (name, signal) in asked.into_iter().zip(&answer.signals) {
            names.entry(signal.number).or_default().push(name);
        }
        // Their numbers come with the new one from now on, and no change comes twice. What is left of older ones is
        // wanted no more, unless its own new one is still under way.
        let wanted = &self.asked;
        self.coming.retain(|subscription, (_, old)| {
            old.retain(|number, _| !names.contains_key(number));
            let keep = old.values().flatten().any(|name| wanted.iter().any(|asked| asked.contains(name)));
            if !keep {
                requests
                    .push((RequestOperation::Unsubscribe { subscription: *subscription }, Purpose::Ignored));
            }
            keep
        });
        for SignalChange(number, earliest, latest, value) in &answer.values {
            for name in names.get(number).into_iter().flatten() {
                // Of what came before by another subscription nothing is new.
                let before = model.values.get(name);
                let new = before.is_none_or(|(at, old)| latest > at || (latest == at && value != old));
                if new {
                    report_change(&self.by_view, views, name, (*earliest, *latest), *value);
                    model.values.insert(name.clone(), (*latest, *value));
                }
            }
        }
        self.coming.insert(answer.subscription, (all, names));
        requests
    }

    /// A subscription was refused. One name that the rig does not know would keep all others from coming, so each half
    /// is asked for by itself; what has to be asked, or the name that it is about.
    pub fn refused(
        &mut self,
        (all, round): (bool, u64),
        mut names: Vec<String>,
    ) -> Result<Vec<(RequestOperation, Purpose)>, String> {
        if round != self.rounds[usize::from(all)] {
            return Ok(Vec::new());
        }
        if names.len() < 2 {
            let name = names.pop().unwrap_or_default();
            self.asked[usize::from(all)].remove(&name);
            self.refused.insert(name.clone());
            return Err(name);
        }
        let second = names.split_off(names.len() / 2);
        Ok(vec![self.request(all, names), self.request(all, second)])
    }

    /// Signals changed.
    pub fn changed(
        &self,
        subscription: u64,
        changes: &[SignalChange],
        missed: u64,
        views: &mut [Box<dyn View>],
        model: &mut RigModel,
    ) {
        let Some((all, names)) = self.coming.get(&subscription) else { return };
        for SignalChange(number, earliest, latest, value) in changes {
            for name in names.get(number).into_iter().flatten() {
                report_change(&self.by_view, views, name, (*earliest, *latest), *value);
                model.values.insert(name.clone(), (*latest, *value));
            }
        }
        if missed > 0 && *all {
            for (view, wanted_names) in views.iter_mut().zip(&self.by_view) {
                if names.values().flatten().any(|name| wanted_names.contains(name)) {
                    view.missed(missed);
                }
            }
        }
    }
}

fn report_change(
    by_view: &[BTreeSet<String>],
    views: &mut [Box<dyn View>],
    name: &str,
    when: (i64, i64),
    value: WireValue,
) {
    for (view, wanted_names) in views.iter_mut().zip(by_view) {
        if wanted_names.contains(name) {
            view.changed(name, when, value);
        }
    }
}
