//! What parameters of plants go back to after a step that set them for a time.

use std::collections::BTreeMap;

/// A setting for a time that is not over.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Setting {
    step: usize,
    /// What the parameter was before; `None`: as the board file has it.
    before: Option<f64>,
}

/// A parameter of a plant that was set.
#[derive(Debug, Default)]
struct SetParameter {
    /// What it is now; `None`: as the board file has it.
    now: Option<f64>,
    /// The settings for a time on top of each other, the newest last.
    settings: Vec<Setting>,
}

/// The parameters that steps have set, by plant and parameter.
#[derive(Debug, Default)]
pub(super) struct PlantSettings {
    set: BTreeMap<(usize, usize), SetParameter>,
}

impl PlantSettings {
    /// A step sets a parameter, for a time or for good. What is set for good ends every setting for a time before it.
    pub(super) fn set(&mut self, at: (usize, usize), step: usize, value: f64, for_a_time: bool) {
        let parameter = self.set.entry(at).or_default();
        if for_a_time {
            parameter.settings.push(Setting { step, before: parameter.now });
        } else {
            parameter.settings.clear();
        }
        parameter.now = Some(value);
    }

    /// The time of a step is over. Returns what the parameter is from then on, `None` where another step has set it since: as
    /// it was before that step, or `initial` where that was what the board file has.
    pub(super) fn restore(&mut self, at: (usize, usize), step: usize, initial: f64) -> Option<f64> {
        let parameter = self.set.get_mut(&at)?;
        let place = parameter.settings.iter().rposition(|setting| setting.step == step)?;
        let ended = parameter.settings.remove(place);
        // One on top of it goes back to what this one would have.
        if let Some(above) = parameter.settings.get_mut(place) {
            above.before = ended.before;
            return None;
        }
        parameter.now = ended.before;
        Some(ended.before.unwrap_or(initial))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AT: (usize, usize) = (0, 2);

    #[test]
    fn a_setting_goes_back_to_what_was_before_it() {
        let mut settings = PlantSettings::default();
        settings.set(AT, 1, 5.0, true);
        assert_eq!(settings.restore(AT, 1, 1.0), Some(1.0));
        settings.set(AT, 2, 6.0, false);
        settings.set(AT, 3, 7.0, true);
        assert_eq!(settings.restore(AT, 3, 1.0), Some(6.0));
        assert_eq!(settings.restore(AT, 3, 1.0), None);
    }

    #[test]
    fn settings_within_and_over_each_other() {
        let mut settings = PlantSettings::default();
        settings.set(AT, 1, 5.0, true);
        settings.set(AT, 2, 6.0, true);
        assert_eq!(settings.restore(AT, 2, 1.0), Some(5.0));
        settings.set(AT, 3, 7.0, true);
        assert_eq!(settings.restore(AT, 1, 1.0), None);
        assert_eq!(settings.restore(AT, 3, 1.0), Some(1.0));
    }

    #[test]
    fn what_is_set_for_good_stays() {
        let mut settings = PlantSettings::default();
        settings.set(AT, 1, 5.0, true);
        settings.set(AT, 2, 6.0, false);
        assert_eq!(settings.restore(AT, 1, 1.0), None);
        settings.set(AT, 3, 7.0, true);
        assert_eq!(settings.restore(AT, 3, 1.0), Some(6.0));
    }
}
