//! Scans of a buffer: bytes in, readings with their instants out.

use host::HostInstant;
use signal::Span;

use super::element::{Element, SampleLayout};
use super::info::Scaling;
use crate::adc::{AdcReading, InRange};

/// One input of a scan.
#[derive(Clone, Copy, Debug)]
pub struct Sampled {
    /// Place of the input among those that the converter was opened for.
    pub input: u16,
    /// How it lies in the buffer.
    pub element: Element,
    scaling: Scaling,
}

impl Sampled {
    /// An input whose value is `(code + offset) * scale`.
    pub fn new(input: u16, element: Element, offset: f64, scale: f64) -> Sampled {
        Sampled { input, element, scaling: Scaling { offset, scale } }
    }

    pub(super) fn scaled(input: u16, element: Element, scaling: Scaling) -> Sampled {
        Sampled { input, element, scaling }
    }
}

/// Makes readings of scans. What a scan holds is fixed; its last element is the kernel's stamp.
#[derive(Debug)]
pub struct Scans {
    layout: SampleLayout,
    inputs: Vec<Sampled>,
    stamp: Element,
    period: Span,
    /// How long before its stamp a sample may have been taken.
    early: Span,
    last: Option<HostInstant>,
    lost: u64,
}

impl Scans {
    /// Of these inputs in the order of the buffer, so often. A trigger that starts the conversion stamps what follows;
    /// any other may be of a sample that was taken up to a period before.
    pub fn new(inputs: Vec<Sampled>, stamp: Element, period: Span, starts: bool) -> Scans {
        let elements = inputs.iter().map(|input| input.element).chain([stamp]);
        let period = period.max(Span::from_nanos(1));
        Scans {
            layout: SampleLayout::new(elements),
            inputs,
            stamp,
            period,
            early: if starts { Span::ZERO } else { period },
            last: None,
            lost: 0,
        }
    }

    /// Bytes of a scan.
    pub fn size(&self) -> usize {
        self.layout.size
    }

    /// What came so far is from before: a gap after it is none.
    pub fn begin(&mut self) {
        (self.last, self.lost) = (None, 0);
    }

    /// Scans that are missing since then, by the gaps between stamps.
    pub fn lost(&self) -> u64 {
        self.lost
    }

    /// Appends the readings of whole scans that were read by `now`; bytes after the last whole one are left out.
    pub fn take(&mut self, bytes: &[u8], now: HostInstant, out: &mut Vec<AdcReading>) {
        let mut scans = bytes.chunks_exact(self.size()).peekable();
        while let Some(scan) = scans.next() {
            let stamp = self.stamp_of(scan);
            if let Some(last) = self.last {
                let period = self.period.as_nanos();
                // A stamp that is half a period late or less is a timer that was late itself.
                let periods = (stamp - last).as_nanos().saturating_add(period / 2) / period;
                self.lost = self.lost.saturating_add(periods.saturating_sub(1).max(0) as u64);
            }
            self.last = Some(stamp);
            // The kernel begins no scan before the last one is done.
            let done = scans.peek().map_or(now, |next| self.stamp_of(next).min(now));
            let before = stamp - self.early;
            let after = done.max(stamp);
            for (at, sampled) in self.inputs.iter().enumerate() {
                let place = self.layout.places[at];
                let code = sampled.element.code(&scan[place..place + usize::from(sampled.element.bytes)]);
                let range = match code {
                    code if code <= sampled.element.lowest() => InRange::Below,
                    code if code >= sampled.element.highest() => InRange::Above,
                    _ => InRange::Yes,
                };
                let value = sampled.scaling.value(code);
                out.push(AdcReading { input: sampled.input, before, after, value, range });
            }
        }
    }

    fn stamp_of(&self, scan: &[u8]) -> HostInstant {
        let place = self.layout.places.last().copied().unwrap_or(0);
        let code = self.stamp.code(&scan[place..place + usize::from(self.stamp.bytes)]);
        HostInstant::from_nanos(i64::try_from(code).unwrap_or(i64::MAX))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const MS: i64 = 1_000_000;

    fn ms(count: i64) -> HostInstant {
        HostInstant::from_nanos(count * MS)
    }

    fn scans(starts: bool) -> Scans {
        let (sample, stamp) =
            (Element::parse("le:u16/16>>0").unwrap(), Element::parse("le:s64/64>>0").unwrap());
        let inputs = vec![Sampled::new(1, sample, -32_768.0, 0.001), Sampled::new(0, sample, 0.0, 1.0)];
        Scans::new(inputs, stamp, Span::from_millis(10), starts)
    }

    fn scan(first: u16, second: u16, stamp: i64) -> Vec<u8> {
        let mut bytes = [first.to_le_bytes(), second.to_le_bytes()].concat();
        bytes.extend([0xAA; 4]);
        bytes.extend(stamp.to_le_bytes());
        bytes
    }

    #[test]
    fn a_sample_lies_between_its_stamp_and_the_next_scan() {
        let mut scans = scans(true);
        assert_eq!(scans.size(), 16);
        let mut out = Vec::new();
        let bytes = [scan(32_768 + 5, 7, 100 * MS), scan(0, 65_535, 110 * MS), vec![1, 2, 3]].concat();
        scans.take(&bytes, ms(112), &mut out);
        let told: Vec<(u16, f64, InRange)> =
            out.iter().map(|one| (one.input, one.value, one.range)).collect();
        assert_eq!(
            told,
            [
                (1, 0.005, InRange::Yes),
                (0, 7.0, InRange::Yes),
                (1, -32.768, InRange::Below),
                (0, 65_535.0, InRange::Above)
            ]
        );
        let when: Vec<(i64, i64)> =
            out.iter().map(|one| (one.before.as_nanos() / MS, one.after.as_nanos() / MS)).collect();
        assert_eq!(when, [(100, 110), (100, 110), (110, 112), (110, 112)]);
        assert_eq!(scans.lost(), 0);
    }

    #[test]
    fn a_stamp_behind_the_sample_reaches_a_period_back() {
        let mut scans = scans(false);
        let mut out = Vec::new();
        scans.take(&scan(0, 0, 100 * MS), ms(101), &mut out);
        assert_eq!((out[0].before.as_nanos() / MS, out[0].after.as_nanos() / MS), (90, 101));
    }

    #[test]
    fn gaps_between_stamps_are_scans_that_are_missing() {
        let mut scans = scans(true);
        let mut out = Vec::new();
        for (stamp, lost) in [(100, 0), (114, 0), (120, 0), (140, 1), (185, 5), (184, 5)] {
            scans.take(&scan(0, 0, stamp * MS), ms(200), &mut out);
            assert_eq!(scans.lost(), lost, "{stamp}");
        }
        scans.begin();
        scans.take(&scan(0, 0, 900 * MS), ms(900), &mut out);
        assert_eq!(scans.lost(), 0);
    }

    proptest! {
        #[test]
        fn any_bytes_are_survived_and_no_reading_ends_before_it_begins(
            bytes in prop::collection::vec(any::<u8>(), 0..200), now: i64, starts: bool,
        ) {
            let mut scans = scans(starts);
            let mut out = Vec::new();
            scans.take(&bytes, HostInstant::from_nanos(now), &mut out);
            prop_assert_eq!(out.len(), bytes.len() / 16 * 2);
            prop_assert!(out.iter().all(|one| one.before <= one.after && one.value.is_finite()));
        }
    }
}
