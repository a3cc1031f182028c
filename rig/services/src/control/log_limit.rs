//! How many lines of the log clients may cause: a script that connects in a loop must not fill a disk.

use signal::{Span, Time};

/// What a line of the log is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LogTopic {
    /// Clients that come and go.
    Connections,
    /// What they do.
    Actions,
}

impl LogTopic {
    pub(super) const ALL: [LogTopic; 2] = [LogTopic::Connections, LogTopic::Actions];

    /// The most lines of it in a second.
    const fn most(self) -> u32 {
        match self {
            LogTopic::Connections => 100,
            LogTopic::Actions => 200,
        }
    }

    /// The line for lines that were left out.
    pub(super) fn left_out(self, lines: u64) -> String {
        match self {
            LogTopic::Connections => format!("{lines} more lines about clients that came and went"),
            LogTopic::Actions => format!("{lines} more lines about what clients did"),
        }
    }
}

/// The lines of both topics in the second that is counted.
#[derive(Debug, Default)]
pub(super) struct LogLimit([Counted; 2]);

#[derive(Clone, Copy, Debug, Default)]
struct Counted {
    since: Option<Time>,
    lines: u32,
    left_out: u64,
}

impl LogLimit {
    /// Whether another line may be written. One that may not is counted.
    pub(super) fn admits(&mut self, topic: LogTopic, now: Time) -> bool {
        let counted = &mut self.0[topic as usize];
        if counted.is_over(now) {
            (counted.since, counted.lines) = (Some(now), 0);
        }
        if counted.lines >= topic.most() {
            counted.left_out += 1;
            return false;
        }
        counted.lines += 1;
        true
    }

    /// Lines that were left out in a second that is over, once.
    pub(super) fn take_left_out(&mut self, topic: LogTopic, now: Time) -> Option<u64> {
        let counted = &mut self.0[topic as usize];
        let lines = if counted.is_over(now) { std::mem::take(&mut counted.left_out) } else { 0 };
        (lines > 0).then_some(lines)
    }
}

impl Counted {
    fn is_over(self, now: Time) -> bool {
        self.since.is_none_or(|since| now - since >= Span::from_secs(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flood_is_counted_and_the_next_second_has_its_lines_again() {
        let mut limit = LogLimit::default();
        let at = |milliseconds| Time::ZERO + Span::from_millis(milliseconds);
        let mut written =
            |from: i64| (0..1_000).filter(|_| limit.admits(LogTopic::Connections, at(from))).count();
        assert_eq!((written(0), written(999)), (100, 0));
        assert!(limit.admits(LogTopic::Actions, at(999)), "which is counted by itself");
        assert_eq!(limit.take_left_out(LogTopic::Connections, at(999)), None);
        assert_eq!(limit.take_left_out(LogTopic::Connections, at(1_000)), Some(1_900));
        assert_eq!(limit.take_left_out(LogTopic::Connections, at(1_000)), None);
        assert!(limit.admits(LogTopic::Connections, at(1_000)));
    }
}
