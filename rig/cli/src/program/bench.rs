//! `rig program bench`.

use super::args::ProgramBenchArgs;
use super::{compile, ended};
use crate::exit::ExitStatus;
use crate::output::OutputFormat;
use crate::output::{self, refuse};
use profile::Profile;
use runtime::instrument::standalone::{StandaloneRun, StandaloneTask};
use serde_json::json;
use signal::Span;
use std::sync::Arc;
use std::time::Instant;

/// The most cycles that are measured: their times are kept.
const MOST_CYCLES: u64 = 10_000_000;

/// A scan that takes longer than this in modelled time does not end.
const MOST_SCAN: Span = Span::from_secs(10);

/// The times of the scans that were measured, in nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Figures {
    mean: f64,
    p99: u64,
    max: u64,
}

impl Figures {
    /// Of at least one time.
    fn of(mut times: Vec<u64>) -> Figures {
        times.sort_unstable();
        let sum: u128 = times.iter().map(|time| u128::from(*time)).sum();
        // The least time that 99 of 100 scans do not exceed.
        let place = (times.len() * 99).div_ceil(100).saturating_sub(1);
        Figures {
            mean: sum as f64 / times.len().max(1) as f64,
            p99: times.get(place).copied().unwrap_or(0),
            max: times.last().copied().unwrap_or(0),
        }
    }
}

/// Runs the bodies of all PROGRAMs back to back and prints how long the host and the modelled controller take.
pub fn bench(args: &ProgramBenchArgs) -> ExitStatus {
    let cycles = args.cycles;
    if cycles == 0 || cycles > MOST_CYCLES {
        let help = format!("from 1 to {MOST_CYCLES}");
        return refuse("R0505", format!("--cycles {cycles}: so many cannot be measured"), &help);
    }
    let (program, _) = match compile(&args.files) {
        Ok(compiled) => compiled,
        Err(exit) => return exit,
    };
    let all = StandaloneTask {
        name: String::from("MAST"),
        interval: Span::from_millis(20),
        programs: (0..program.programs().len()).collect(),
    };
    let mut alone = match StandaloneRun::new(Arc::clone(&program), vec![all], Profile::default()) {
        Ok(alone) => alone,
        Err(error) => {
            output::error(&error.to_string());
            return ExitStatus::UserFiles;
        }
    };
    let warm_up = (cycles / 10).clamp(1, 1_000);
    for _ in 0..warm_up {
        if let Err(how) = alone.scan(MOST_SCAN) {
            return ended(&how);
        }
    }
    let (mut host, mut modelled) = (Vec::with_capacity(cycles as usize), Vec::with_capacity(cycles as usize));
    for _ in 0..cycles {
        let began = Instant::now();
        let scan = alone.scan(MOST_SCAN);
        host.push(u64::try_from(began.elapsed().as_nanos()).unwrap_or(u64::MAX));
        match scan {
            Ok(span) => modelled.push(span.as_nanos().unsigned_abs()),
            Err(how) => return ended(&how),
        }
    }
    show(args.format, program.programs(), cycles, Figures::of(host), Figures::of(modelled));
    ExitStatus::Passed
}

fn show(format: OutputFormat, programs: &[String], cycles: u64, host: Figures, modelled: Figures) {
    let us = |nanos: u64| nanos as f64 / 1_000.0;
    match format {
        OutputFormat::Table => output::print(&format!(
            "{}, {cycles} scans\nhost      mean {:.3} us, p99 {:.3} us, max {:.3} us\n\
             modelled  mean {:.3} us, max {:.3} us\n",
            programs.join(", "),
            host.mean / 1_000.0,
            us(host.p99),
            us(host.max),
            modelled.mean / 1_000.0,
            us(modelled.max),
        )),
        OutputFormat::Json => {
            let figures = json!({
                "programs": programs,
                "cycles": cycles,
                "scan_us": { "mean": host.mean / 1_000.0, "p99": us(host.p99), "max": us(host.max) },
                "modelled_us": { "mean": modelled.mean / 1_000.0, "max": us(modelled.max) },
            });
            output::print(&format!("{figures}\n"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_of_scans() {
        let figures = Figures::of((1..=200).rev().collect());
        assert_eq!(figures, Figures { mean: 100.5, p99: 198, max: 200 });
        assert_eq!(Figures::of(vec![7]), Figures { mean: 7.0, p99: 7, max: 7 });
    }
}
