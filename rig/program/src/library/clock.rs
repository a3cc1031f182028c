//! The system time: modelled time since the start of the rig, as the timers see it.

use super::{Body, Function, Gives};
use crate::types::Elementary::{self, Ltime, Time};

/// TIME() and LTIME(), without parameters. TIME goes on at 0 after 4294967295 ms.
pub(super) const FUNCTIONS: &[Function] = &[
    system("TIME", Time, |now| Time.wrap(now.as_nanos() / 1_000_000)),
    system("LTIME", Ltime, |now| Ltime.wrap(now.as_nanos())),
];

const fn system(name: &'static str, gives: Elementary, body: fn(signal::Time) -> i64) -> Function {
    Function { name, parameters: &[], extensible: false, gives: Gives::Exact(gives), body: Body::Clock(body) }
}
