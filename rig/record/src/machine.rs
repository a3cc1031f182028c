//! What was measured of a machine, and of which: kept between runs, and read by those that judge on real lines.

use serde::{Deserialize, Serialize};

/// Version of the shape of [`MachineRecord`].
pub const MACHINE_FORMAT: u32 = 1;

/// The most bytes of a file of figures that is read.
pub const MAX_MACHINE_BYTES: u64 = 4 << 20;

/// How long something took, over many times, in nanoseconds.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Durations {
    /// What took this long: `wake-up`, `call to stamp`.
    pub name: String,
    /// How often it was measured.
    pub count: u64,
    /// The least.
    pub min_ns: u64,
    /// The mean.
    pub mean_ns: u64,
    /// Half did not take longer.
    pub p50_ns: u64,
    /// 99 of 100 did not.
    pub p99_ns: u64,
    /// 9 999 of 10 000 did not.
    pub p99_99_ns: u64,
    /// The greatest.
    pub max_ns: u64,
}

/// The figures of a machine.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct MachineRecord {
    /// Version of this shape: [`MACHINE_FORMAT`].
    pub format: u32,
    /// What was measured: `latency`, `scan`, `loopback`.
    pub kind: String,
    /// When, RFC 3339.
    pub measured: String,
    /// What the figures depend on, name and text.
    pub machine: Vec<(String, String)>,
    /// SHA-256 of the board file, 64 hexadecimal digits; empty where no board was in use.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub board_sha256: String,
    /// How it was measured, name and text.
    pub settings: Vec<(String, String)>,
    /// What came of it.
    pub figures: Vec<Durations>,
}

impl MachineRecord {
    /// The figures of this name.
    pub fn figure(&self, name: &str) -> Option<&Durations> {
        self.figures.iter().find(|figure| figure.name == name)
    }

    /// What of the machine is not as it was when these figures were taken: name, then, now.
    pub fn differences<'a>(&'a self, machine: &'a [(String, String)]) -> Vec<(&'a str, &'a str, &'a str)> {
        let text = |list: &'a [(String, String)], name: &str| {
            list.iter().find(|(known, _)| known == name).map_or("", |(_, text)| text)
        };
        let names = machine.iter().map(|(name, _)| name.as_str());
        let gone = self.machine.iter().map(|(name, _)| name.as_str());
        let gone = gone.filter(|name| machine.iter().all(|(known, _)| known != name));
        names
            .chain(gone)
            .map(|name| (name, text(&self.machine, name), text(machine, name)))
            .filter(|(_, then, now)| then != now)
            .collect()
    }

    /// As text.
    pub fn to_json(&self) -> String {
        // Texts and whole numbers: there is nothing that could not be written.
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }

    /// From text.
    ///
    /// # Errors
    /// Why it cannot be read.
    pub fn from_json(text: &str) -> Result<MachineRecord, String> {
        let record: MachineRecord = serde_json::from_str(text).map_err(|error| error.to_string())?;
        match record.format {
            MACHINE_FORMAT => Ok(record),
            other => Err(format!("it has format {other}, and this rig reads {MACHINE_FORMAT}")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record() -> MachineRecord {
        let fact = |name: &str, text: &str| (name.to_owned(), text.to_owned());
        MachineRecord {
            format: MACHINE_FORMAT,
            kind: "latency".into(),
            measured: "2026-11-22T09:00:00Z".into(),
            machine: vec![fact("kernel", "Linux 6.12"), fact("governor", "performance")],
            settings: vec![fact("interval", "1 ms")],
            figures: vec![Durations { name: "wake-up".into(), count: 7, max_ns: 9, ..Durations::default() }],
            ..MachineRecord::default()
        }
    }

    #[test]
    fn what_is_written_reads_back() {
        assert_eq!(MachineRecord::from_json(&record().to_json()), Ok(record()));
        assert_eq!(record().figure("wake-up").map(|figure| figure.max_ns), Some(9));
        assert_eq!(record().figure("scan"), None);
    }

    #[test]
    fn what_is_cut_or_of_another_format_does_not() {
        let text = record().to_json();
        assert!((0..text.len() - 2).all(|end| MachineRecord::from_json(&text[..end]).is_err()));
        assert!(MachineRecord::from_json(&text.replace("\"format\": 1", "\"format\": 2")).is_err());
    }

    #[test]
    fn another_machine_is_told_by_what_differs() {
        let was = record();
        assert!(was.differences(&was.machine).is_empty());
        let mut now = was.machine.clone();
        now[0].1 = "Linux 6.18".into();
        now.remove(1);
        now.push(("tick".into(), "off".into()));
        let found = was.differences(&now);
        let all =
            [("kernel", "Linux 6.12", "Linux 6.18"), ("tick", "", "off"), ("governor", "performance", "")];
        assert_eq!(found, all);
    }
}
