//! Edges from the records that the kernel's GPIO lines deliver: runs of `struct gpio_v2_line_event`.

use crate::ExpertFunctions;
use signal::Time;

/// Bytes of a record: the time in nanoseconds (u64), what happened, the line's offset, the number among the events of
/// the request, that among the events of the line (u32 each), and six words that mean nothing; all in the machine's order
/// of bytes.
pub const RECORD: usize = 48;

/// Inputs that an expert can have.
const INPUTS: usize = 32;

/// Hands the edges of some lines to the inputs that stand for them, and finds out which edges are missing.
///
/// The kernel numbers the events of each line without gaps, and drops the oldest when nobody fetches them in time. Each
/// record has its level, so levels are right from the first record after a gap on.
#[derive(Clone, Debug)]
pub struct LineEvents {
    /// Offset of the line of each input.
    lines: [Option<u32>; INPUTS],
    /// The number that the next event of each input's line has.
    numbers: [u32; INPUTS],
    /// What the records' clock showed at the origin of time.
    origin: i64,
    last: Time,
    lost: u64,
    malformed: u64,
}

impl LineEvents {
    /// Of a request whose events nobody fetched yet: `lines` are offsets of lines, each with n for In. `origin` is what
    /// the clock of the records showed at [`Time::ZERO`], in nanoseconds.
    pub fn new(lines: &[(u32, u8)], origin: i64) -> LineEvents {
        let mut events = LineEvents {
            lines: [None; INPUTS],
            numbers: [1; INPUTS],
            origin,
            last: Time::MIN,
            lost: 0,
            malformed: 0,
        };
        for (offset, input) in lines {
            if let Some(line) = events.lines.get_mut(usize::from(*input)) {
                *line = Some(*offset);
            }
        }
        events
    }

    /// Hands on the edges of whole records, up to the first after which there are effects to take. Returns the bytes
    /// that it took; what is left of them can be less than a record.
    pub fn read(&mut self, bytes: &[u8], expert: &mut ExpertFunctions) -> usize {
        let mut taken = 0;
        for record in bytes.chunks_exact(RECORD) {
            taken += RECORD;
            self.take(record, expert);
            if !expert.effects().as_slice().is_empty() {
                break;
            }
        }
        taken
    }

    /// Edges that are missing.
    pub const fn lost(&self) -> u64 {
        self.lost
    }

    /// Records that no kernel writes for these lines: of another line, neither rising nor falling, at a time that cannot
    /// be, with a number that was there already.
    pub const fn malformed(&self) -> u64 {
        self.malformed
    }

    #[inline]
    fn take(&mut self, record: &[u8], expert: &mut ExpertFunctions) {
        let word =
            |at: usize| record.get(at..at + 4).and_then(|it| it.try_into().ok()).map(u32::from_ne_bytes);
        let long =
            |at: usize| record.get(at..at + 8).and_then(|it| it.try_into().ok()).map(u64::from_ne_bytes);
        let read = (|| {
            let at = i64::try_from(long(0)?).ok()?.checked_sub(self.origin)?;
            let high = match word(8)? {
                1 => true,
                2 => false,
                _ => return None,
            };
            let offset = word(12)?;
            let input = self.lines.iter().position(|line| *line == Some(offset))?;
            let missing = word(20)?.wrapping_sub(self.numbers[input]);
            // Numbers start again after the last of their width; more than half of them ahead means back.
            (missing <= u32::MAX / 2).then_some((at, high, input, missing))
        })();
        let Some((at, high, input, missing)) = read else {
            self.malformed += 1;
            return;
        };
        // Stamps of different lines can be in another order than their numbers.
        self.last = self.last.max(Time::from_nanos(at));
        self.numbers[input] = self.numbers[input].wrapping_add(missing).wrapping_add(1);
        if missing > 0 {
            self.lost += u64::from(missing);
            expert.report_missed_edges(self.last, input, missing);
        }
        expert.edge(self.last, input, high);
    }
}
