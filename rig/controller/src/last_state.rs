//! What the controller knows of its past after a power cycle: its state, and when it stopped and went off.

use crate::{DATES_FILE, NonVolatile, STATE_FILE, State};

const MAGIC: &[u8; 4] = b"SRST";

/// Keeps the state for the boot decision.
pub(crate) fn save_last_state(store: &mut dyn NonVolatile, state: State, signature: u64) {
    let mut bytes = [0; 17];
    bytes[..4].copy_from_slice(MAGIC);
    bytes[4] = state.number() as u8;
    bytes[5..13].copy_from_slice(&signature.to_le_bytes());
    let sum = crc32fast::hash(&bytes[..13]);
    bytes[13..].copy_from_slice(&sum.to_le_bytes());
    store.write(STATE_FILE, &bytes);
}

/// The state before, and the signature of the application that was in memory.
pub(crate) fn load_last_state(store: &dyn NonVolatile) -> Option<(State, u64)> {
    let bytes: [u8; 17] = store.read(STATE_FILE)?.try_into().ok()?;
    let (body, sum) = bytes.split_last_chunk::<4>()?;
    if !body.starts_with(MAGIC) || crc32fast::hash(body) != u32::from_le_bytes(*sum) {
        return None;
    }
    let signature = u64::from_le_bytes(body[5..13].try_into().ok()?);
    Some((State::from_number(i64::from(body[4]))?, signature))
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
