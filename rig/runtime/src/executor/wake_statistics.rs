//! How late the waits of a case ended, without a word more memory however many there are.

use host::Histogram;
use record::{LateWake, MAX_LATE_WAKES, Wakes};
use signal::{Span, Time};

/// Counts wake-ups, and keeps the latest of them with their instants.
#[derive(Debug)]
pub struct WakeStatistics {
    from: Span,
    noted: Histogram,
    late: u64,
    latest: Vec<LateWake>,
}

impl WakeStatistics {
    /// Wake-ups later than `from` count as late.
    pub fn new(from: Span) -> WakeStatistics {
        WakeStatistics { from, noted: Histogram::new(), late: 0, latest: Vec::with_capacity(MAX_LATE_WAKES) }
    }

    /// A wait that was to end at `due` ended so much later.
    #[inline]
    pub fn note(&mut self, due: Time, late: Span) {
        self.noted.note(late.as_nanos());
        if late > self.from {
            self.late += 1;
            self.keep(LateWake { at_ns: due.as_nanos(), late_ns: late.as_nanos() });
        }
    }

    #[cold]
    fn keep(&mut self, wake: LateWake) {
        if self.latest.len() < MAX_LATE_WAKES {
            self.latest.push(wake);
            return;
        }
        let least = self.latest.iter_mut().min_by_key(|kept| kept.late_ns);
        if let Some(least) = least.filter(|least| least.late_ns < wake.late_ns) {
            *least = wake;
        }
    }

    /// For the record.
    pub fn figures(mut self) -> Wakes {
        let span = |length: u64| i64::try_from(length).unwrap_or(i64::MAX);
        self.latest.sort_by_key(|wake| wake.at_ns);
        Wakes {
            count: self.noted.count(),
            late: self.late,
            late_from_ns: self.from.as_nanos(),
            p50_ns: span(self.noted.millionths(500_000)),
            p99_ns: span(self.noted.millionths(990_000)),
            p9999_ns: span(self.noted.millionths(999_900)),
            max_ns: span(self.noted.max()),
            histogram: coarse(&self.noted),
            latest: self.latest,
        }
    }
}

/// Buckets for a record: each is a quarter of a power of two wide, which shows enough and takes little room.
fn coarse(noted: &Histogram) -> Vec<[u64; 2]> {
    let mut buckets: Vec<[u64; 2]> = Vec::new();
    let quarter = |length: u64| (length.ilog2(), length >> length.ilog2().saturating_sub(2) & 3);
    for (up_to, count) in noted.buckets() {
        match buckets.last_mut().filter(|last| quarter(last[0].max(1)) == quarter(up_to.max(1))) {
            Some(last) => *last = [up_to, last[1] + count],
            None => buckets.push([up_to, count]),
        }
    }
    buckets
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_latest_are_kept_whenever_they_came() {
        let mut seen = WakeStatistics::new(Span::from_micros(100));
        for n in 0..1_000 {
            // From 1 us to 1000 us, in an order in which late ones come early and late.
            let late = Span::from_micros((n * 37) % 1_000 + 1);
            seen.note(Time::from_nanos(n), late);
        }
        let figures = seen.figures();
        assert_eq!((figures.count, figures.late, figures.max_ns), (1_000, 900, 1_000_000));
        assert_eq!(figures.latest.len(), MAX_LATE_WAKES);
        assert!(figures.latest.iter().all(|wake| wake.late_ns > 1_000_000 - 1_000 * MAX_LATE_WAKES as i64));
        assert!(figures.latest.is_sorted_by_key(|wake| wake.at_ns));
        assert!(figures.histogram.len() <= 4 * 10, "{:?}", figures.histogram);
        assert_eq!(figures.histogram.iter().map(|[_, count]| count).sum::<u64>(), 1_000);
    }
}
