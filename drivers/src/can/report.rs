//! Reports of CAN controllers (`linux/can/error.h`): what went wrong, and how the controller takes part from then on.

use crate::{BusError, BusState};

/// Classes of a report.
const TX_TIMEOUT: u32 = 0x1;
const LOST_ARBITRATION: u32 = 0x2;
const CONTROLLER: u32 = 0x4;
const PROTOCOL: u32 = 0x8;
const TRANSCEIVER: u32 = 0x10;
const NO_ACK: u32 = 0x20;
const BUS_OFF: u32 = 0x40;
const BUS_ERROR: u32 = 0x80;
const RESTARTED: u32 = 0x100;
const COUNTERS: u32 = 0x200;

/// Details of a controller's trouble, in the second byte.
const RX_OVERFLOW: u8 = 0x01;
const TX_OVERFLOW: u8 = 0x02;
const WARNING: u8 = 0x04 | 0x08;
const PASSIVE: u8 = 0x10 | 0x20;
const ACTIVE: u8 = 0x40;

/// The most errors of one report.
const MOST: usize = 8;

/// What a controller reported.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reported {
    errors: [Option<BusError>; MOST],
    /// How it takes part from now on; `None` where that is as before.
    pub state: Option<BusState>,
    /// Its counters of errors while sending and while receiving, where it reports them.
    pub counters: Option<(u8, u8)>,
}

impl Reported {
    /// What went wrong.
    pub fn errors(&self) -> impl Iterator<Item = BusError> + '_ {
        self.errors.iter().flatten().copied()
    }

    /// Reads a report from its classes and details.
    pub fn read(classes: u32, details: &[u8; 8]) -> Reported {
        let has = |class: u32| classes & class != 0;
        let controller = if has(CONTROLLER) { details[1] } else { 0 };
        let state = if has(BUS_OFF) {
            Some(BusState::BusOff)
        } else if controller & PASSIVE != 0 {
            Some(BusState::ErrorPassive)
        } else if controller & WARNING != 0 {
            Some(BusState::ErrorWarning)
        } else if controller & ACTIVE != 0 || has(RESTARTED) {
            Some(BusState::ErrorActive)
        } else {
            None
        };
        // A controller that nobody answers reports a bus error, too: that is no second one.
        let protocol = has(PROTOCOL) || has(BUS_ERROR) && !has(NO_ACK);
        // The position of the bit is 0 where the controller does not know it.
        let bit = Some(details[0]).filter(|bit| *bit != 0);
        let known = TX_TIMEOUT
            | LOST_ARBITRATION
            | CONTROLLER
            | PROTOCOL
            | TRANSCEIVER
            | NO_ACK
            | BUS_OFF
            | BUS_ERROR
            | RESTARTED
            | COUNTERS;
        let when = |yes: bool, error: BusError| yes.then_some(error);
        let errors = [
            when(has(NO_ACK), BusError::NoAck),
            when(has(LOST_ARBITRATION), BusError::LostArbitration(bit)),
            when(protocol, BusError::Protocol),
            when(controller & RX_OVERFLOW != 0, BusError::ReceiveOverflow),
            when(controller & TX_OVERFLOW != 0, BusError::SendOverflow),
            when(has(TX_TIMEOUT), BusError::SendTimeout),
            when(has(TRANSCEIVER), BusError::Transceiver),
            when(classes & !known != 0, BusError::Other),
        ];
        Reported { errors, state, counters: has(COUNTERS).then_some((details[6], details[7])) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn read(classes: u32, details: [u8; 8]) -> (Vec<BusError>, Option<BusState>) {
        let reported = Reported::read(classes, &details);
        (reported.errors().collect(), reported.state)
    }

    /// What candump shows of the lab's controllers, byte by byte.
    #[test]
    fn reports_of_real_controllers_are_told_apart() {
        let none = [0; 8];
        assert_eq!(read(0x40, none), (vec![], Some(BusState::BusOff)));
        assert_eq!(read(0x100, none), (vec![], Some(BusState::ErrorActive)));
        assert_eq!(read(0x204, [0, 0x08, 0, 0, 0, 0, 96, 0]), (vec![], Some(BusState::ErrorWarning)));
        assert_eq!(read(0x204, [0, 0x20, 0, 0, 0, 0, 128, 0]), (vec![], Some(BusState::ErrorPassive)));
        assert_eq!(read(0x204, [0, 0x40, 0, 0, 0, 0, 0, 0]), (vec![], Some(BusState::ErrorActive)));
        assert_eq!(read(0xA0, [0, 0, 0, 0x19, 0, 0, 8, 0]), (vec![BusError::NoAck], None));
        assert_eq!(read(0x88, [0, 0, 0x81, 0, 0, 0, 8, 0]), (vec![BusError::Protocol], None));
        assert_eq!(read(0x2, none), (vec![BusError::LostArbitration(None)], None));
        assert_eq!(read(0x2, [7, 0, 0, 0, 0, 0, 0, 0]), (vec![BusError::LostArbitration(Some(7))], None));
        assert_eq!(read(0x4, [0, 1, 0, 0, 0, 0, 0, 0]), (vec![BusError::ReceiveOverflow], None));
        assert_eq!(read(0x8000, none), (vec![BusError::Other], None));
    }

    proptest! {
        #[test]
        fn any_report_is_read(classes in any::<u32>(), details in any::<[u8; 8]>()) {
            let reported = Reported::read(classes, &details);
            prop_assert_eq!(reported.counters.is_some(), classes & COUNTERS != 0);
        }
    }
}
