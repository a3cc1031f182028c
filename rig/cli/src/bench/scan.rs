//! `rig bench scan`.

use super::loopback::failed;
use super::{INTERRUPT, board, interrupted, interval, keep, measured, show};
use crate::bench_lock::BenchLockArgs;
use crate::exit::ExitStatus;
use crate::output::OutputFormat;
use crate::output::{self, refuse};
use clap::Args;
use drivers::{Board, ChannelId};
use profile::Profile;
use record::Durations;
use runtime::instrument::figures::{devices, durations};
use runtime::instrument::standalone::{StandaloneRun, tasks};
use runtime::instrument::{ScanFault, phases};
use serde_json::json;
use signal::Span;
use std::path::PathBuf;
use std::sync::Arc;

/// The most scans of one measurement.
const MOST: u64 = 100_000_000;

/// A scan that takes longer than this in modelled time does not end.
const MOST_SCAN: Span = Span::from_secs(10);

/// `rig bench scan`.
#[derive(Debug, Args)]
pub struct BenchScanArgs {
    /// The board file.
    #[arg(long, value_name = "FILE")]
    board: PathBuf,
    /// Structured Text files of the application to run in each scan; none runs if left out.
    #[arg(long, value_name = "FILE")]
    program: Vec<PathBuf>,
    /// Time between two scans.
    #[arg(long, value_name = "TIME", default_value = "1 ms")]
    interval: String,
    /// How many scans to measure.
    #[arg(long, value_name = "N", default_value_t = 10_000)]
    count: u64,
    /// Outputs that turn with every scan; no other one moves, but for that of the board's `check`.
    #[arg(long, value_name = "CHANNEL,...", value_delimiter = ',')]
    drive: Vec<String>,
    /// How to print.
    #[arg(long, value_enum, default_value_t)]
    format: OutputFormat,
    /// What it does when somebody else is on the lines.
    #[command(flatten)]
    wait: BenchLockArgs,
}

/// Scans as the executor does and says what the phases take.
pub fn run(args: &BenchScanArgs) -> ExitStatus {
    try_run(args).unwrap_or_else(|exit| exit)
}

fn try_run(args: &BenchScanArgs) -> Result<ExitStatus, ExitStatus> {
    let interval = interval(&args.interval)?;
    if args.count == 0 || args.count > MOST {
        let message = format!("--count {}: so many scans cannot be measured", args.count);
        return Err(refuse("R0250", message, &format!("from 1 to {MOST}")));
    }
    let mut alone = program(&args.program)?;
    let (file, hardware) = board::open(&args.board, &args.wait)?;
    let mut board = hardware.lease();
    let mut driven: Vec<ChannelId> = file.check.iter().map(|looped| looped.out).collect();
    for name in &args.drive {
        match file.find(name).filter(|at| board.channels()[usize::from(at.0)].drives) {
            Some(channel) => driven.push(channel),
            None => {
                let message = format!("--drive {name}: the board has no such output");
                return Err(refuse("R0254", message, "name outputs of the board file"));
            }
        }
    }
    let mut settings = board::settings(&hardware);
    settings.push((String::from("interval"), interval.to_string()));
    let entered = hardware.enter();
    let timing = [interval.as_nanos(), i64::try_from(args.count).unwrap_or(i64::MAX)];
    let mut scan = || alone.as_mut().map_or(Ok(()), |alone| alone.scan(MOST_SCAN).map(|_| ()));
    let found = phases(hardware.instrument(&mut board), timing, &driven, &mut scan, &INTERRUPT);
    drop(entered);
    let found = match found {
        Ok(found) => found,
        Err(ScanFault::Board(fault)) => return Err(failed(&fault, &Default::default())),
        Err(ScanFault::Program(how)) => return Err(crate::program::ended(&how)),
    };
    let all = [
        ("late by", &found.wake),
        ("inputs", &found.inputs),
        ("program", &found.program),
        ("outputs", &found.outputs),
        ("whole", &found.whole),
        ("device", &found.device),
    ];
    let figures: Vec<Durations> =
        all.iter().filter_map(|(name, histogram)| durations(name, histogram)).collect();
    let scans = found.wake.count();
    // The device is asked less often than once a scan where nothing changes: what it took says less.
    let judged: Vec<Durations> = figures.iter().filter(|figure| figure.name != "device").cloned().collect();
    let kept = keep(&measured("scan", &devices(&file), settings, judged));
    match args.format {
        OutputFormat::Table => {
            let mut text = format!("{scans} scans every {interval}\n");
            figures.iter().for_each(|figure| text += &format!("{}\n", show::line(figure)));
            if found.missed > 0 {
                text += &format!("{} more were left out, for the one before was too late\n", found.missed);
            }
            if found.lost > 0 {
                text += &format!("{} edges were lost: the device is slower than the scan\n", found.lost);
            }
            kept.iter().for_each(|path| text += &format!("kept in {path}\n"));
            output::print(&text);
        }
        OutputFormat::Json => {
            let mut out = json!({ "scans": scans, "missed": found.missed, "lost": found.lost, "kept": kept });
            out["devices"] = json!(devices(&file));
            out["interval_us"] = json!(interval.as_nanos() as f64 / 1_000.0);
            for figure in &figures {
                out[figure.name.replace(' ', "_")] = show::figures(figure);
            }
            output::print(&format!("{out}\n"));
        }
    }
    Ok(interrupted())
}

/// The application of a scan, if one was given.
fn program(files: &[PathBuf]) -> Result<Option<StandaloneRun>, ExitStatus> {
    if files.is_empty() {
        return Ok(None);
    }
    let (program, _) = crate::program::compile(files)?;
    let tasks = tasks(&program, Span::from_millis(20));
    StandaloneRun::new(Arc::clone(&program), tasks, Profile::default()).map(Some).map_err(|error| {
        output::error(&error.to_string());
        ExitStatus::UserFiles
    })
}
