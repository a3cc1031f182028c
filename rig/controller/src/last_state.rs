//! What the controller knows of its past after a power cycle: its state, why it left RUNNING, when it stopped and went off.

use crate::{DATES_FILE, NonVolatile, STATE_FILE, State};
use profile::StopCause;

const MAGIC: &[u8; 4] = b"SRS2";
/// Magic, state, signature, cause and checksum.
const LENGTH: usize = 4 + 1 + 8 + 2 + 4;

/// What a boot finds of the controller as it was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct LastState {
    /// The state before, for the boot decision.
    pub state: State,
    /// The signature of the application that was in memory, 0 for none.
    pub signature: u64,
    /// Why RUNNING was left last (plcsystem:PLCR-10).
    pub stop_cause: StopCause,
}

impl LastState {
    /// That of a controller whose storage says nothing.
    const NONE: LastState = LastState { state: State::Off, signature: 0, stop_cause: StopCause::Unknown };

    /// That of an earlier life.
    pub(crate) fn load(store: &dyn NonVolatile) -> LastState {
        store.read(STATE_FILE).and_then(|bytes| LastState::decode(&bytes)).unwrap_or(LastState::NONE)
    }

    fn decode(bytes: &[u8]) -> Option<LastState> {
        let bytes: &[u8; LENGTH] = bytes.try_into().ok()?;
        let (body, sum) = bytes.split_last_chunk::<4>()?;
        if !body.starts_with(MAGIC) || crc32fast::hash(body) != u32::from_le_bytes(*sum) {
            return None;
        }
        Some(LastState {
            state: State::from_number(i64::from(body[4]))?,
            signature: u64::from_le_bytes(body[5..13].try_into().ok()?),
            stop_cause: StopCause::from_code(u16::from_le_bytes(body[13..].try_into().ok()?))?,
        })
    }

    /// Keeps it.
    pub(crate) fn save(self, store: &mut dyn NonVolatile) {
        let mut bytes = [0; LENGTH];
        let (body, sum) = bytes.split_at_mut(LENGTH - 4);
        body[..4].copy_from_slice(MAGIC);
        body[4] = self.state.number() as u8;
        body[5..13].copy_from_slice(&self.signature.to_le_bytes());
        body[13..].copy_from_slice(&self.stop_cause.code().to_le_bytes());
        sum.copy_from_slice(&crc32fast::hash(body).to_le_bytes());
        store.write(STATE_FILE, &bytes);
    }
}

/// Seconds since 1970-01-01 00:00 UTC (controller:RB-06), 0 for never.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Dates {
    /// When RUNNING was left last.
    pub stop: u32,
    /// When the controller went off last.
    pub off: u32,
}

impl Dates {
    /// Those of an earlier life.
    pub(crate) fn load(store: &dyn NonVolatile) -> Dates {
        let bytes = store.read(DATES_FILE).unwrap_or_default();
        let Some((stop, off)) = bytes.split_first_chunk::<4>() else { return Dates::default() };
        let off = off.try_into().map_or(0, u32::from_le_bytes);
        Dates { stop: u32::from_le_bytes(*stop), off }
    }

    /// Keeps them.
    pub(crate) fn save(self, store: &mut dyn NonVolatile) {
        let mut bytes = [0; 8];
        bytes[..4].copy_from_slice(&self.stop.to_le_bytes());
        bytes[4..].copy_from_slice(&self.off.to_le_bytes());
        store.write(DATES_FILE, &bytes);
    }
}
