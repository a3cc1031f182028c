//! `--shard K/N`: a part of the chosen cases, so that several machines run a suite.
//!
//! The cases go round the parts in their order, so that each part has as many as any other and long rows and sweeps
//! are spread. Which cases a part has depends on nothing but the selection.

use document::Diagnostic;
use runtime::suite::{Job, LoadedPlan};

/// Part `part` of `of`, from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    part: u32,
    of: u32,
}

impl Shard {
    /// Reads `K/N`.
    ///
    /// # Errors
    /// A finding that shows the form.
    pub fn parse(text: &str) -> Result<Shard, Diagnostic> {
        let number = |text: &str| text.trim().parse::<u32>().ok();
        text.split_once('/')
            .and_then(|(part, of)| Some(Shard { part: number(part)?, of: number(of)? }))
            .filter(|shard| (1..=shard.of).contains(&shard.part))
            .ok_or_else(|| {
                Diagnostic::error("R0161", format!("`--shard {text}` is not a part of a suite"))
                    .help("write `--shard 1/3`, `2/3` and `3/3` to run a suite in three parts")
            })
    }

    /// The cases of this part.
    pub fn take(self, jobs: Vec<Job>) -> Vec<Job> {
        let (part, of) = (self.part as usize - 1, self.of as usize);
        jobs.into_iter().skip(part).step_by(of).collect()
    }

    /// As the record has it.
    pub const fn record(self) -> [u32; 2] {
        [self.part, self.of]
    }
}

/// SHA-256 of what was chosen: the cases in their order with their seeds, and all files that they are made from.
pub fn sha256(loaded: &[LoadedPlan], jobs: &[Job]) -> String {
    let mut text = String::new();
    for plan in loaded {
        text.push_str(&format!("{}\n", plan.sha256()));
    }
    for job in jobs {
        text.push_str(&format!("{} {} {} {}\n", job.plan, job.seed, job.name.len(), job.name));
    }
    runtime::suite::describe::sha256(text.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn jobs(count: u64) -> Vec<Job> {
        let job = |case| Job {
            turn: None,
            plan: 0,
            case,
            profile: profile::Profile::default(),
            name: format!("case {case}"),
            title: String::new(),
            proves: Vec::new(),
            tags: Vec::new(),
            seed: 1,
            asks: false,
        };
        (0..count).map(job).collect()
    }

    #[test]
    fn parts_are_the_whole_and_of_one_size() {
        for (count, of) in [(10, 3), (3, 3), (2, 5), (0, 2), (7, 1)] {
            let mut all = Vec::new();
            for part in 1..=of {
                let taken = Shard { part, of }.take(jobs(count));
                let least = count as usize / of as usize;
                assert!((least..=least + 1).contains(&taken.len()), "{count} in {of}: {}", taken.len());
                all.extend(taken.into_iter().map(|job| job.case));
            }
            all.sort_unstable();
            assert_eq!(all, (0..count).collect::<Vec<u64>>());
        }
    }

    #[test]
    fn only_parts_that_can_be() {
        assert_eq!(Shard::parse("2/3").unwrap(), Shard { part: 2, of: 3 });
        for wrong in ["0/3", "4/3", "1/0", "3", "a/b", "-1/3", "1/3/5", "1/99999999999"] {
            assert_eq!(Shard::parse(wrong).unwrap_err().code, "R0161", "{wrong}");
        }
    }
}
