//! The controller's log as a file (controller:NV-09): lines of text, the oldest giving way to the newest.

use profile::SYSTEM_LOG_BYTES;
use signal::Time;
use std::collections::VecDeque;
use std::fmt::Write as _;

/// The message queue behind the tool's page Log and the file of the system log.
#[derive(Clone, Debug, Default)]
pub(crate) struct SystemLog {
    lines: VecDeque<String>,
    bytes: usize,
}

impl SystemLog {
    /// Appends a line with its instant.
    pub(crate) fn append(&mut self, at: Time, text: &str) {
        let mut line = String::with_capacity(text.len() + 24);
        // Writing into a text cannot fail.
        let _ = writeln!(line, "{at} {text}");
        self.bytes += line.len();
        self.lines.push_back(line);
        while self.bytes > SYSTEM_LOG_BYTES {
            let Some(oldest) = self.lines.pop_front() else { return };
            self.bytes -= oldest.len();
        }
    }

    /// Bytes of the file; 0 where there is none.
    pub(crate) fn len(&self) -> usize {
        self.bytes
    }

    /// The file.
    pub(crate) fn bytes(&self) -> Vec<u8> {
        self.lines.iter().flat_map(|line| line.bytes()).collect()
    }

    /// How many lines hold a text.
    pub(crate) fn count(&self, text: &str) -> i64 {
        self.lines.iter().filter(|line| line.contains(text)).count() as i64
    }

    /// Removes every line.
    pub(crate) fn clear(&mut self) {
        self.lines.clear();
        self.bytes = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_oldest_lines_give_way() {
        let mut log = SystemLog::default();
        for n in 0..10_000 {
            log.append(Time::ZERO, &format!("line {n}."));
        }
        assert!(log.len() <= SYSTEM_LOG_BYTES && log.len() > SYSTEM_LOG_BYTES - 40);
        assert_eq!(log.bytes().len(), log.len());
        assert_eq!((log.count("line 0."), log.count("line 9999.")), (0, 1));
        log.clear();
        assert_eq!((log.len(), log.count("line")), (0, 0));
    }
}
