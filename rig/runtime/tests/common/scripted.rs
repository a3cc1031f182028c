//! Real lines without a machine: a board whose edges come when its script says, on a clock that is as late as the
//! script says. Time passes only while somebody waits.

use drivers::{Board, BoardError, BoardEvent, Channel, ChannelId, Health, Origin, TimestampSource};
use scanrig_runtime::executor::clock::Clock;
use signal::{Span, Time, Value, When};
use std::collections::VecDeque;
use std::sync::{Arc, Mutex};

/// What the board and the clock of a script share.
#[derive(Debug, Default)]
pub struct World {
    pub now: Time,
    /// How late a wait for this instant ends; on time where nothing is said.
    pub late: VecDeque<(Time, Span)>,
    /// Edges from outside, by their instants.
    pub edges: VecDeque<(Time, ChannelId, bool)>,
    /// What was waited for, and when the wait ended.
    pub waits: Vec<(Time, Time)>,
    /// What was written when.
    pub writes: Vec<(Time, ChannelId, Value)>,
    written: VecDeque<BoardEvent>,
    rung: bool,
}

pub type Shared = Arc<Mutex<World>>;

impl World {
    /// The wait for `due` ends, not before `due`.
    fn end(&mut self, due: Time) -> Time {
        let mut end = due;
        while let Some((at, late)) = self.late.front().copied().filter(|(at, _)| *at <= due) {
            self.late.pop_front();
            end = end.max(at + late);
        }
        self.rung |= self.edges.front().is_some_and(|edge| edge.0 <= end && edge.0 > self.now);
        self.now = self.now.max(end);
        self.waits.push((due, self.now));
        self.now
    }
}

/// The clock of a script.
#[derive(Debug)]
pub struct ScriptClock(pub Shared);

impl Clock for ScriptClock {
    fn wait_until(&mut self, due: Time) -> Time {
        let mut world = self.0.lock().unwrap();
        if due <= world.now { world.now } else { world.end(due) }
    }

    fn wait(&mut self, due: Time) -> Time {
        let mut world = self.0.lock().unwrap();
        let next = world.edges.iter().find(|edge| edge.0 > world.now).map(|edge| edge.0);
        match next {
            Some(next) if next < due => world.end(next),
            _ if due <= world.now => world.now,
            _ => world.end(due),
        }
    }

    fn rung(&mut self) -> bool {
        std::mem::take(&mut self.0.lock().unwrap().rung)
    }

    fn now(&mut self) -> Time {
        self.0.lock().unwrap().now
    }

    fn is_exact(&self) -> bool {
        false
    }

    fn name(&self) -> &'static str {
        "script"
    }
}

/// The board of a script.
#[derive(Debug)]
pub struct ScriptBoard {
    pub world: Shared,
    channels: Vec<Channel>,
}

impl ScriptBoard {
    /// Real lines in place of a simulated board's.
    pub fn like(board: &dyn Board, world: &Shared) -> ScriptBoard {
        let real = |channel: &Channel| Channel { timestamp: TimestampSource::Kernel, ..channel.clone() };
        ScriptBoard { world: world.clone(), channels: board.channels().iter().map(real).collect() }
    }
}

impl Board for ScriptBoard {
    fn inner(&self) -> Option<&dyn Board> {
        None
    }

    fn inner_mut(&mut self) -> Option<&mut dyn Board> {
        None
    }

    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn start(&mut self, _now: Time) -> Result<(), BoardError> {
        let mut world = self.world.lock().unwrap();
        for place in 0..self.channels.len() as u16 {
            let (at, value) = (When::exactly(world.now), Value::Bool(false));
            let origin = Origin::Outside;
            world.written.push_back(BoardEvent::Changed { channel: ChannelId(place), at, value, origin });
        }
        Ok(())
    }

    fn write(&mut self, now: Time, writes: &[(ChannelId, Value)]) -> Result<(), BoardError> {
        let mut world = self.world.lock().unwrap();
        for (channel, value) in writes {
            world.writes.push((now, *channel, *value));
            let (channel, at, value) = (*channel, When::exactly(now), *value);
            world.written.push_back(BoardEvent::Changed { channel, at, value, origin: Origin::Write });
        }
        Ok(())
    }

    fn poll(&mut self, now: Time, out: &mut Vec<BoardEvent>) -> Result<(), BoardError> {
        let mut world = self.world.lock().unwrap();
        out.extend(world.written.drain(..));
        while let Some((at, channel, high)) = world.edges.front().copied().filter(|edge| edge.0 <= now) {
            world.edges.pop_front();
            let (at, value) = (When::exactly(at), Value::Bool(high));
            out.push(BoardEvent::Changed { channel, at, value, origin: Origin::Outside });
        }
        Ok(())
    }

    fn next_event(&self) -> Option<Time> {
        None
    }

    fn safe(&mut self, _now: Time) -> Result<(), BoardError> {
        Ok(())
    }

    fn health(&self) -> Health {
        Health::default()
    }
}
