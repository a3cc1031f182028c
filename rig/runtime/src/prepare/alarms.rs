//! The alarms of a case with their signals.

use super::meaning::SignalMeanings;
use crate::codes;
use document::Diagnostic;
use plans::Case;
use plans::alarm::AlarmWatch;
use signal::{SignalId, SignalInfo, Trace, ValueKind};

/// An alarm that is watched while its case runs.
#[derive(Clone, Debug)]
pub struct ArmedAlarm {
    /// Its name.
    pub name: String,
    /// The signal that it watches.
    pub signal: SignalId,
    /// The mark of its being raised.
    pub mark: SignalId,
    /// Follows its condition.
    pub watch: AlarmWatch,
    /// Whether the case ends when it is raised.
    pub ends: bool,
}

/// Defines the marks of the alarms. Reports values that mean nothing for their signals.
pub(super) fn alarms(
    case: &Case,
    names: &SignalMeanings<'_>,
    trace: &mut Trace,
    found: &mut Vec<Diagnostic>,
) -> Vec<ArmedAlarm> {
    let mut armed = Vec::new();
    for alarm in &case.alarms {
        let mut wrong = |code, message: String, help: &str| {
            let place = &alarm.place;
            found.push(Diagnostic::error(code, message).at(&*place.file, place.span.clone(), "").help(help));
        };
        // A signal that is not there was reported where it is bound.
        let Some(signal) = names.signal(&alarm.signal) else { continue };
        let Some(info) = trace.signals().get(signal.0 as usize) else { continue };
        let watch = match alarm.watch(info) {
            Ok(watch) => watch,
            Err(why) => {
                wrong(codes::VALUE_MISFIT, why, "write a value of the signal");
                continue;
            }
        };
        match trace.define(SignalInfo::exact(format!("alarm:{}", alarm.name), ValueKind::Mark)) {
            Ok(mark) => {
                armed.push(ArmedAlarm { name: alarm.name.clone(), signal, mark, watch, ends: alarm.ends });
            }
            Err(error) => {
                wrong(codes::NOT_RECORDED, format!("`{}` cannot be recorded: {error}", alarm.name), "")
            }
        }
    }
    armed
}
