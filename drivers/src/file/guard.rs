//! What a board file says of the guard: `[guard]`.

use std::ops::Range;
use std::path::PathBuf;

use document::{Fields, Findings};
use signal::Span;

use super::codes;

/// When the watchdog is left to bite.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Bite {
    /// When nobody is there any more to keep the outputs safe, or they cannot be made safe.
    #[default]
    GuardLost,
    /// As soon as the rig is gone without a goodbye, even if all outputs are safe.
    RigLost,
}

/// The watchdog behind the guard.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WatchdogSettings {
    /// The device, as in `/dev/watchdog`.
    pub path: PathBuf,
    /// How long after the last feeding it bites; whole seconds.
    pub after: Span,
    /// When it is left to bite.
    pub bite: Bite,
    /// Where the board file names it, bytes of the file.
    pub place: Range<usize>,
}

/// How the guard keeps the outputs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GuardSettings {
    /// How long the rig may go without a sign of life before every output is driven safe.
    pub limit: Span,
    /// How long the guard of a rig that is gone holds the outputs before it lets go of their lines.
    pub hold: Span,
    /// The watchdog, if the guard is to feed one.
    pub watchdog: Option<WatchdogSettings>,
}

impl Default for GuardSettings {
    /// 200 ms, held for 2 s, no watchdog.
    fn default() -> Self {
        GuardSettings { limit: Span::from_millis(200), hold: Span::from_secs(2), watchdog: None }
    }
}

/// The limits that can be kept: shorter ones are below what a machine under load keeps, longer ones guard nothing.
const LIMITS: (Span, Span) = (Span::from_millis(20), Span::from_secs(10));
/// The longest that lines are held.
const LONGEST_HOLD: Span = Span::from_secs(24 * 3600);
/// What watchdogs can do.
const BITES: (Span, Span) = (Span::from_secs(1), Span::from_secs(600));

/// Reads the table.
pub(super) fn read(fields: Option<Fields>, out: &mut Findings) -> GuardSettings {
    let mut settings = GuardSettings::default();
    let Some(fields) = fields else { return settings };
    if let Some(limit) = within(&fields, "limit", LIMITS, out) {
        settings.limit = limit;
    }
    if let Some(hold) = within(&fields, "hold", (Span::ZERO, LONGEST_HOLD), out) {
        settings.hold = hold;
    }
    let after = within(&fields, "bites-after", BITES, out);
    let Some(path) = fields.text("watchdog") else {
        for key in ["bites-after", "bite"] {
            if let Some(entry) = fields.entry(key) {
                let message = format!("`{key}` says something of a watchdog that is not there");
                let help = "name the watchdog too, as in watchdog = \"/dev/watchdog\"";
                out.error(codes::GUARD_WATCHDOG, entry.key_span.clone(), message, help);
            }
        }
        return settings;
    };
    if let Some(node) = fields.get("watchdog").filter(|_| !path.starts_with('/')) {
        let message = format!("\"{path}\" is no device");
        out.bad(codes::GUARD_WATCHDOG, node, message, "write its whole path, as in \"/dev/watchdog\"");
    }
    let whole = Span::from_secs(1).as_nanos();
    if let (Some(after), Some(node)) = (after, fields.get("bites-after"))
        && after.as_nanos() % whole != 0
    {
        out.bad(codes::GUARD_TIME, node, "a watchdog counts whole seconds", "write as in \"10 s\"");
    }
    let bite = match fields.text("bite") {
        Some("rig-lost") => Bite::RigLost,
        _ => Bite::GuardLost,
    };
    let after = after.unwrap_or(Span::from_secs(10));
    let place = fields.get("watchdog").map_or(0..0, |node| node.span.clone());
    settings.watchdog = Some(WatchdogSettings { path: path.into(), after, bite, place });
    settings
}

/// A duration that can be kept.
fn within(fields: &Fields, key: &str, (shortest, longest): (Span, Span), out: &mut Findings) -> Option<Span> {
    let span = fields.duration(key)?;
    if (shortest..=longest).contains(&span) {
        return Some(span);
    }
    if let Some(node) = fields.get(key) {
        let message = format!("the guard cannot keep a `{key}` of {span}");
        out.bad(codes::GUARD_TIME, node, message, format!("it is from {shortest} to {longest}"));
    }
    None
}
