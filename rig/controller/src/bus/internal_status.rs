//! The status bytes of a module, as a program asks for them (io:DIAG-06).

use super::ExpansionBus;
use profile::ModuleState;
use signal::Time;

/// TM3_ERR_FAILED, TM3_ERR_PARAMETER and TM3_ERR_BUS (plcsystem: 9.15).
const FAILED: i64 = 1;
const PARAMETER: i64 = 2;
const BUS: i64 = 4;

impl ExpansionBus {
    /// The answer to a request for the status bytes of a module: in eight bits each, from the lowest on, the index of the module, the
    /// first byte and how many. It is the code of an error, or 0 and four bits for each byte from the ninth on. What is beyond
    /// the table of the module is refused, and so is a module without one.
    pub(crate) fn internal_status(&mut self, now: Time, request: i64) -> i64 {
        let [index, first, count, ..] = request.to_le_bytes().map(usize::from);
        let is_off = self.is_off;
        let found = self.positions.iter_mut().find(|position| position.configured.index == index);
        let Some(position) = found else { return PARAMETER };
        let end = first + count;
        if position.module.internal_status(now, end.max(1) - 1).is_none() {
            return PARAMETER;
        }
        match position.exchange.state() {
            ModuleState::BusError => return BUS,
            _ if is_off || !position.exchange.is_written() => return FAILED,
            _ => {}
        }
        // A module has eight channels at most.
        let mut answer = 0_i64;
        for (place, channel) in (first..end).enumerate() {
            let status = position.module.internal_status(now, channel).unwrap_or_default();
            answer |= i64::from(status.code()).checked_shl(8 + 4 * place as u32).unwrap_or(0);
        }
        answer
    }
}
