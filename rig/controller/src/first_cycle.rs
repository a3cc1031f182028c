//! The first cycle of MAST after RUNNING was entered, and what came before it (controller:TASK-53).

use crate::application::{SystemCall, VariableReset};

/// What came before RUNNING is entered next (controller:TASK-53).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum FirstCycle {
    /// Nothing but a stop.
    #[default]
    Again,
    /// A reset warm, or a boot with a valid context.
    Warm,
    /// A reset cold, a download, or a boot without a valid context.
    Cold,
    /// RUNNING was entered after this: MAST has not begun its first cycle.
    Entered(StartKind),
    /// MAST is in its first cycle.
    First(StartKind),
}

/// What came before the first cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StartKind {
    Stop,
    Warm,
    Cold,
}

impl FirstCycle {
    /// A reset comes before the next start.
    pub(crate) fn after(reset: VariableReset) -> FirstCycle {
        if reset == VariableReset::WARM { FirstCycle::Warm } else { FirstCycle::Cold }
    }

    /// RUNNING is entered.
    pub(crate) fn enter_running(&mut self) {
        *self = FirstCycle::Entered(match *self {
            FirstCycle::Warm | FirstCycle::Entered(StartKind::Warm) => StartKind::Warm,
            FirstCycle::Cold | FirstCycle::Entered(StartKind::Cold) => StartKind::Cold,
            _ => StartKind::Stop,
        });
    }

    /// A cycle of MAST begins.
    #[inline]
    pub(crate) fn begin_cycle(&mut self) {
        if let FirstCycle::Entered(kind) = *self {
            *self = FirstCycle::First(kind);
        }
    }

    /// A cycle of MAST ended.
    #[inline]
    pub(crate) fn end_cycle(&mut self) {
        if matches!(self, FirstCycle::First(_)) {
            *self = FirstCycle::Again;
        }
    }

    /// What the flag of this call shows: 1 in the first cycle after any start, a cold or a warm one.
    pub(crate) fn flag(self, call: SystemCall) -> i64 {
        let FirstCycle::First(kind) = self else { return 0 };
        i64::from(match call {
            SystemCall::FirstMastCycle => true,
            SystemCall::FirstMastColdCycle => kind == StartKind::Cold,
            SystemCall::FirstMastWarmCycle => kind == StartKind::Warm,
            _ => false,
        })
    }
}
