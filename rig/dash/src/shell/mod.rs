//! The dashboard without its terminal: messages of the rig and keys go in, requests and frames come out. It neither
//! waits nor reads a clock.

mod dialog;
mod draw;
mod input;
mod menu;
mod signals;

use crate::glyphs::TerminalFeatures;
use crate::model::RigModel;
use crate::views::{View, ViewRequest};
use control::client::{self, ClientError};
use control::{
    Done, Forces, Greeting, Plans, Reply, Request, RequestFault, RequestOperation, Subscribed,
    SubscriptionEvent, Topic,
};
use dialog::Dialog;
use ratatui::layout::Rect;
use signals::SignalSubscriptions;
use std::collections::BTreeMap;

/// At most one status in so many milliseconds: the frames of the screen.
const STATUS_EVERY: u32 = 100;

/// What comes from the rig.
#[derive(Clone, Debug, PartialEq)]
pub enum RigMessage {
    /// There is a connection, and this is the rig at its other end.
    Connected(Box<Greeting>),
    /// An answer.
    Reply(Reply),
    /// Something of a subscription.
    Event(SubscriptionEvent),
    /// There is no connection, for this reason. It is tried again.
    Disconnected(String),
}

/// What an answer is for.
#[derive(Clone, Debug)]
enum Purpose {
    /// Nothing is done with it.
    Ignored,
    Describe,
    Status,
    Log,
    Frames,
    Plan,
    Plans,
    Signals {
        all: bool,
        round: u64,
        names: Vec<String>,
    },
    /// Somebody wanted it: these words say that it is done.
    UserRequest(String),
    /// It is the last one.
    Leave,
}

/// What stands in the bottom line until the next key.
#[derive(Clone, Debug, PartialEq, Eq)]
struct StatusNote {
    text: String,
    bad: bool,
}

/// What the dashboard wants of the program around it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LoopCommand {
    /// To be stopped as ctrl-z stops programs, with the terminal given back.
    Suspend,
    /// To draw everything again: something else wrote on the terminal.
    Redraw,
    /// To end.
    End,
}

/// The dashboard.
#[derive(Debug)]
pub struct Shell {
    model: RigModel,
    views: Vec<Box<dyn View>>,
    /// The place of the view that is shown.
    at: usize,
    features: TerminalFeatures,
    /// The rig was started for this dashboard and ends with it.
    owns_rig: bool,
    dialog: Option<Dialog>,
    note: Option<StatusNote>,
    requests: Vec<Request>,
    waiting: BTreeMap<u64, Purpose>,
    asked: u64,
    signals: SignalSubscriptions,
    /// The subscription to frames, where there is one or one is asked for.
    frames: Option<Option<u64>>,
    /// There was a connection before.
    was_connected: bool,
    loop_commands: Vec<LoopCommand>,
    /// Where tabs were drawn last, and what can be chosen in a dialog.
    tabs: Vec<Rect>,
    choices: Vec<Rect>,
    /// Where the view was.
    body: Rect,
}

impl Shell {
    /// A dashboard with these views. `owns_rig` says that the rig was started for it and ends with it.
    pub fn new(views: Vec<Box<dyn View>>, features: TerminalFeatures, owns_rig: bool) -> Shell {
        let mut shell = Shell {
            model: RigModel { gone: Some("connecting".to_owned()), ..RigModel::default() },
            views,
            at: 0,
            features,
            owns_rig,
            dialog: None,
            note: None,
            requests: Vec::new(),
            waiting: BTreeMap::new(),
            asked: 0,
            signals: SignalSubscriptions::default(),
            frames: None,
            was_connected: false,
            loop_commands: Vec::new(),
            tabs: Vec::new(),
            choices: Vec::new(),
            body: Rect::default(),
        };
        if let Some(view) = shell.views.first_mut() {
            view.shown(true);
        }
        shell
    }

    /// What the rig is and how, as far as it is known.
    pub fn model(&self) -> &RigModel {
        &self.model
    }

    /// What is to be sent to the rig, in this order.
    pub fn take_requests(&mut self) -> Vec<Request> {
        std::mem::take(&mut self.requests)
    }

    /// What the program around is to do.
    pub fn take_loop_commands(&mut self) -> Vec<LoopCommand> {
        std::mem::take(&mut self.loop_commands)
    }

    /// So much time passed since the last status came, nanoseconds.
    pub fn pass(&mut self, nanos: i64) {
        self.model.pass(nanos);
    }

    /// Something came from the rig.
    pub fn receive(&mut self, heard: RigMessage) {
        match heard {
            RigMessage::Connected(greeting) => self.connected(&greeting),
            RigMessage::Disconnected(why) => self.disconnected(why),
            RigMessage::Reply(reply) => self.answered(reply),
            RigMessage::Event(event) => self.event(event),
        }
        self.refresh_subscriptions();
    }

    fn connected(&mut self, greeting: &Greeting) {
        self.waiting.clear();
        self.requests.clear();
        self.signals.reset();
        self.frames = None;
        self.model = RigModel { plans: self.model.plans.take(), ..RigModel::default() };
        if std::mem::replace(&mut self.was_connected, true) {
            for view in &mut self.views {
                view.reconnected();
            }
            self.say(format!("connected again to {}", greeting.board));
        }
        self.ask(RequestOperation::Describe, Purpose::Describe);
        self.ask(
            RequestOperation::Subscribe { topic: Topic::Status { every_ms: STATUS_EVERY } },
            Purpose::Status,
        );
        self.ask(RequestOperation::Subscribe { topic: Topic::Log }, Purpose::Log);
        self.ask(RequestOperation::Subscribe { topic: Topic::Plan }, Purpose::Plan);
    }

    fn disconnected(&mut self, why: String) {
        if self.waiting.values().any(|purpose| matches!(purpose, Purpose::Leave)) {
            self.loop_commands.push(LoopCommand::End);
        }
        self.waiting.clear();
        self.requests.clear();
        self.model.gone = Some(why);
    }

    fn ask(&mut self, ask: RequestOperation, purpose: Purpose) {
        self.asked += 1;
        self.requests.push(Request { id: self.asked, ask });
        self.waiting.insert(self.asked, purpose);
    }

    fn ask_all(&mut self, asks: Vec<(RequestOperation, Purpose)>) {
        for (ask, purpose) in asks {
            self.ask(ask, purpose);
        }
    }

    fn answered(&mut self, reply: Reply) {
        let Some(purpose) = reply.id.and_then(|id| self.waiting.remove(&id)) else { return };
        if let Err(fault) = self.take_answer(purpose, reply) {
            self.complain(&fault);
        }
    }

    fn take_answer(&mut self, purpose: Purpose, reply: Reply) -> Result<(), RequestFault> {
        match purpose {
            Purpose::Ignored | Purpose::Status => drop(client::answer::<Done>(reply).map_err(fault_of)?),
            Purpose::Describe => {
                self.model.description = client::answer(reply).map_err(fault_of)?;
                self.model.gone = None;
            }
            Purpose::Log => {
                let answer: Subscribed = client::answer(reply).map_err(fault_of)?;
                answer.log.into_iter().for_each(|line| self.model.take_log(line.at, line.text));
            }
            Purpose::Plan => {
                let answer: Subscribed = client::answer(reply).map_err(fault_of)?;
                answer.plan.into_iter().for_each(|event| self.model.take_plan_event(event));
            }
            Purpose::Plans => {
                self.model.plans = Some(client::answer::<Plans>(reply).map_err(fault_of)?.plans)
            }
            Purpose::Frames => {
                self.frames = None;
                let answer: Subscribed = client::answer(reply).map_err(fault_of)?;
                self.frames = Some(Some(answer.subscription));
            }
            Purpose::Signals { all, round, names } => {
                let asks = match client::answer(reply).map_err(fault_of) {
                    Ok(answer) => {
                        let (signals, views) = (&mut self.signals, &mut self.views);
                        signals.subscribed((all, round), names, answer, views, &mut self.model)
                    }
                    Err(fault) => self.signals.refused((all, round), names).map_err(|_| fault)?,
                };
                self.ask_all(asks);
            }
            Purpose::UserRequest(done) => {
                client::answer::<Done>(reply).map_err(fault_of)?;
                self.say(done);
            }
            Purpose::Leave => {
                client::answer::<Done>(reply).map_err(fault_of)?;
                self.loop_commands.push(LoopCommand::End);
            }
        }
        Ok(())
    }

    fn event(&mut self, event: SubscriptionEvent) {
        match event {
            SubscriptionEvent::Signals { subscription, changes, missed } => {
                self.signals.changed(subscription, &changes, missed, &mut self.views, &mut self.model);
            }
            SubscriptionEvent::Status { status, .. } => self.model.take_status(*status),
            SubscriptionEvent::Log { at, text, .. } => self.model.take_log(at, text),
            SubscriptionEvent::Frame { frame, .. } => self.model.take_frame(frame),
            SubscriptionEvent::Plan { event, .. } => self.model.plan_event(event),
            SubscriptionEvent::Missed { lines, .. } => {
                self.say(format!("{lines} lines of the rig were not sent: they came too fast"));
            }
            SubscriptionEvent::Gone { why } => self.model.gone = Some(why),
        }
    }

    /// Asks for what the views want now.
    fn refresh_subscriptions(&mut self) {
        if self.model.gone.is_some() {
            return;
        }
        let asks = self.signals.refresh(&mut self.views, &mut self.model);
        self.ask_all(asks);
        let frames = self.views.iter().any(|view| view.wants_frames());
        match self.frames {
            None if frames => {
                self.frames = Some(None);
                self.ask(RequestOperation::Subscribe { topic: Topic::Frames }, Purpose::Frames);
            }
            Some(Some(subscription)) if !frames => {
                self.frames = None;
                self.ask(RequestOperation::Unsubscribe { subscription }, Purpose::Ignored);
            }
            _ => {}
        }
    }

    fn show(&mut self, view: usize) {
        if view < self.views.len() && view != self.at {
            self.views[self.at].shown(false);
            self.at = view;
            self.views[view].shown(true);
            let requests_of_view = self.views[view].opened(&self.model);
            self.carry_out(requests_of_view);
        }
    }

    fn say(&mut self, text: String) {
        self.note = Some(StatusNote { text, bad: false });
    }

    fn complain(&mut self, fault: &RequestFault) {
        let mut text = format!("{} {}", fault.code, fault.message);
        if !fault.help.is_empty() {
            text.push_str(": ");
            text.push_str(&fault.help);
        }
        self.note = Some(StatusNote { text, bad: true });
    }

    /// Does what the view that is shown wants.
    fn carry_out(&mut self, requests_of_view: Vec<ViewRequest>) {
        for request in requests_of_view {
            match request {
                ViewRequest::Operation(ask) => self.request_for_user(ask),
                ViewRequest::Confirm(question, ask) => {
                    self.dialog = Some(Dialog::confirm(question, ask));
                }
                ViewRequest::Prompt { ask, text } => self.dialog = Some(Dialog::prompt(ask, &text, self.at)),
                ViewRequest::Message(text) => self.say(text),
                ViewRequest::Fault(fault) => self.complain(&fault),
            }
        }
    }

    /// Asks the rig for something that somebody wanted.
    fn request_for_user(&mut self, ask: RequestOperation) {
        if let Some(why) = &self.model.gone {
            let text = format!("there is no connection to the rig: {why}");
            self.note = Some(StatusNote { text, bad: true });
            return;
        }
        let purpose = match &ask {
            RequestOperation::Plans { .. } => Purpose::Plans,
            other => Purpose::UserRequest(menu::done(other)),
        };
        self.ask(ask, purpose);
    }

    /// Leaves, after the rig knows what becomes of forces. Where there is none, at once.
    fn leave(&mut self, forces: Forces) {
        if self.model.gone.is_some() {
            self.loop_commands.push(LoopCommand::End);
        } else {
            self.ask(RequestOperation::Leave { forces }, Purpose::Leave);
        }
    }
}

/// What keeps an answer from being one, as the rig would report it.
fn fault_of(error: ClientError) -> RequestFault {
    error.fault()
}
