//! The seven ways to a known position (io:STD-PTO-09).

use super::motion::MotionTarget;

/// A way to a known position. The numbers are a definition of the rig.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Homing {
    /// Where the axis stands.
    PositionSetting,
    /// A switch that stays on up to the end of the way.
    LongReference,
    /// The same, and then the first zero mark.
    LongReferenceAndIndex,
    /// A short switch, left towards the side from which it is approached.
    ShortReferenceReversal,
    /// A short switch, left in the direction in which it is approached.
    ShortReferenceNoReversal,
    /// A short switch, and the first zero mark beside it.
    ShortReferenceAndIndexOutside,
    /// A short switch, and the first zero mark on it.
    ShortReferenceAndIndexInside,
}

impl Homing {
    /// The mode with a number.
    pub fn of(number: i64) -> Option<Homing> {
        Some(match number {
            0 => Homing::PositionSetting,
            1 => Homing::LongReference,
            10 => Homing::LongReferenceAndIndex,
            20 => Homing::ShortReferenceReversal,
            21 => Homing::ShortReferenceNoReversal,
            30 => Homing::ShortReferenceAndIndexOutside,
            31 => Homing::ShortReferenceAndIndexInside,
            _ => return None,
        })
    }

    /// Whether it needs the zero mark.
    pub const fn needs_index(self) -> bool {
        matches!(
            self,
            Homing::LongReferenceAndIndex
                | Homing::ShortReferenceAndIndexOutside
                | Homing::ShortReferenceAndIndexInside
        )
    }

    /// Whether the switch is searched on the other side where a limit is reached.
    const fn reverses(self) -> bool {
        matches!(
            self,
            Homing::ShortReferenceReversal
                | Homing::ShortReferenceAndIndexOutside
                | Homing::ShortReferenceAndIndexInside
        )
    }
}

/// A homing command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HomingMethod {
    pub mode: Homing,
    /// The direction in which the switch is expected.
    pub forward: bool,
    /// What the position is in the end.
    pub position: i64,
    /// The velocity towards the switch, and the one at the place that counts, in units.
    pub fast: i64,
    pub slow: i64,
    /// Pulses from that place to where the axis comes to rest.
    pub offset: i64,
}

/// What a homing axis waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum HomingStage {
    /// The switch comes on.
    Approach { forward: bool },
    /// The switch goes off.
    Leave { forward: bool },
    /// The switch comes on again.
    Enter,
    /// The zero mark comes.
    Index { forward: bool },
    /// The end of the offset.
    Finish { target: i64 },
}

/// A change of an input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HomingEvent {
    /// The switch comes on or goes off.
    Reference(bool),
    /// The zero mark comes.
    Index,
}

/// A homing under way.
#[derive(Clone, Copy, Debug)]
pub struct HomingRun {
    pub method: HomingMethod,
    stage: HomingStage,
    reversed: bool,
}

impl HomingRun {
    /// Begins, on the switch or beside it.
    pub fn new(method: HomingMethod, on: bool) -> HomingRun {
        let forward = method.forward;
        let mut search = HomingRun { method, stage: HomingStage::Approach { forward }, reversed: false };
        if on {
            search.stage = search.leave();
        }
        search
    }

    fn leave(&self) -> HomingStage {
        let onwards = self.method.mode == Homing::ShortReferenceNoReversal;
        HomingStage::Leave { forward: self.method.forward == onwards }
    }

    /// Where to go in this stage.
    pub fn aim(&self) -> MotionTarget {
        let HomingMethod { forward, fast, slow, .. } = self.method;
        match self.stage {
            HomingStage::Approach { forward } => MotionTarget::Velocity { forward, velocity: fast },
            HomingStage::Leave { forward } | HomingStage::Index { forward } => {
                MotionTarget::Velocity { forward, velocity: slow }
            }
            HomingStage::Enter => MotionTarget::Velocity { forward, velocity: slow },
            HomingStage::Finish { target } => MotionTarget::Position { target, velocity: slow, end: 0 },
        }
    }

    /// An input changes while the axis goes in a direction; whether another stage begins. A place counts only in the
    /// direction of the stage: an axis that overruns the switch while it slows down comes by again.
    pub fn mark(&mut self, mark: HomingEvent, forward: bool, position: i64) -> bool {
        let place = HomingStage::Finish { target: position.saturating_add(self.method.offset) };
        let next = match (self.stage, mark) {
            (HomingStage::Approach { forward: way }, HomingEvent::Reference(true)) if way == forward => {
                self.leave()
            }
            (HomingStage::Leave { forward: way }, HomingEvent::Reference(false)) if way == forward => {
                match self.method.mode {
                    Homing::LongReferenceAndIndex | Homing::ShortReferenceAndIndexOutside => {
                        HomingStage::Index { forward }
                    }
                    Homing::ShortReferenceAndIndexInside => HomingStage::Enter,
                    _ => place,
                }
            }
            (HomingStage::Enter, HomingEvent::Reference(true)) if forward == self.method.forward => {
                HomingStage::Index { forward }
            }
            (HomingStage::Index { forward: way }, HomingEvent::Index) if way == forward => place,
            _ => return false,
        };
        self.stage = next;
        true
    }

    /// Whether an axis that goes in a direction is about to go the other way.
    pub fn turns(&self, forward: bool) -> bool {
        matches!(self.aim(), MotionTarget::Velocity { forward: way, .. } if way != forward)
    }

    /// A limit is reached; whether the search goes on the other way.
    pub fn limit(&mut self) -> bool {
        let HomingStage::Approach { forward } = self.stage else { return false };
        let turns = self.method.mode.reverses() && !self.reversed;
        if turns {
            self.reversed = true;
            self.stage = HomingStage::Approach { forward: !forward };
        }
        turns
    }
}
