//! How much longer a run takes, said no more exactly than it is known.

use std::collections::VecDeque;
use std::time::Duration;

/// Before this nothing is said: a few cases say little of the others.
const FIRST_ESTIMATE_AFTER: Duration = Duration::from_secs(2);

/// Ends of cases that the recent rate is taken over.
const RECENT: usize = 32;

/// Watches cases end.
#[derive(Debug, Default)]
pub struct Estimate {
    done: u64,
    /// When the last cases ended.
    recent: VecDeque<Duration>,
}

impl Estimate {
    /// A case ended this long after the beginning of the run.
    pub fn ended(&mut self, at: Duration) {
        self.done += 1;
        self.recent.push_back(at);
        if self.recent.len() > RECENT {
            self.recent.pop_front();
        }
    }

    /// The least and the most that the rest may take: by the rate of the whole run and by that of the last cases,
    /// which differ where the cases do. Counted from now, so that a case that hangs lets both grow.
    pub fn left(&self, now: Duration, total: u64) -> Option<(Duration, Duration)> {
        let left = total.saturating_sub(self.done);
        let first = *self.recent.front()?;
        if now < FIRST_ESTIMATE_AFTER || left == 0 || self.recent.len() < RECENT.min(8) {
            return None;
        }
        let overall = now.as_secs_f64() / self.done as f64;
        let recent = now.saturating_sub(first).as_secs_f64() / self.recent.len() as f64;
        let (least, most) = (overall.min(recent), overall.max(recent));
        let whole = |each: f64| Duration::try_from_secs_f64(each * left as f64).unwrap_or(Duration::MAX);
        Some((whole(least), whole(most)))
    }
}

/// The range in words: `12 s left`, `1 to 3 min left`.
pub fn words((least, most): (Duration, Duration)) -> String {
    // Up, so that the run is not longer than what was said.
    let (unit, name) = if most.as_secs() < 120 { (1, "s") } else { (60, "min") };
    let number = |time: Duration| (time.as_secs() + u64::from(time.subsec_nanos() > 0)).div_ceil(unit).max(1);
    let (least, most) = (number(least), number(most));
    if least == most { format!("about {most} {name} left") } else { format!("{least} to {most} {name} left") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seconds(n: f64) -> Duration {
        Duration::from_secs_f64(n)
    }

    #[test]
    fn nothing_is_said_too_early_or_at_the_end() {
        let mut estimate = Estimate::default();
        assert_eq!(estimate.left(seconds(10.0), 100), None);
        (1..=10).for_each(|n| estimate.ended(seconds(f64::from(n) * 0.1)));
        assert_eq!(estimate.left(seconds(1.0), 100), None);
        assert!(estimate.left(seconds(2.0), 100).is_some());
        assert_eq!(estimate.left(seconds(2.0), 10), None);
    }

    #[test]
    fn equal_cases_give_one_figure_and_unequal_ones_a_range() {
        let mut estimate = Estimate::default();
        (1..=100).for_each(|n| estimate.ended(seconds(f64::from(n) * 0.1)));
        let (least, most) = estimate.left(seconds(10.0), 200).unwrap();
        assert!(least >= seconds(9.5) && most <= seconds(10.01), "{least:?} {most:?}");
        // The last cases take ten times as long.
        (1..=32).for_each(|n| estimate.ended(seconds(10.0 + f64::from(n))));
        let (least, most) = estimate.left(seconds(42.0), 200).unwrap();
        assert!(least < seconds(25.0) && most > seconds(60.0), "{least:?} {most:?}");
    }

    #[test]
    fn a_case_that_hangs_lets_the_estimate_grow() {
        let mut estimate = Estimate::default();
        (1..=40).for_each(|n| estimate.ended(seconds(f64::from(n) * 0.1)));
        let before = estimate.left(seconds(4.0), 80).unwrap().1;
        assert!(estimate.left(seconds(60.0), 80).unwrap().1 > before * 5);
    }

    #[test]
    fn words_are_no_more_exact_than_the_figure() {
        assert_eq!(words((seconds(0.2), seconds(0.9))), "about 1 s left");
        assert_eq!(words((seconds(10.1), seconds(14.0))), "11 to 14 s left");
        assert_eq!(words((seconds(70.0), seconds(200.0))), "2 to 4 min left");
    }
}
