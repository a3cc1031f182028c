//! How many random mutants of the controller, of its expert functions or of the plants of simulated boards the shipped plans
//! alone kill.
//! `tests/mutants/run` runs it.
//!
//! Every mutation is compiled once, into one program, each behind a switch that the environment variable
//! `RIG_MUTANT` turns on: a copy of the repository is rewritten, mutations that do not compile are dropped, and what
//! is left are the viable mutants. A mutant is killed where `rig test` does not end with 0, or not in time.

mod build;
mod plans;
mod points;
mod rewrite;
mod trial;

use std::path::{Path, PathBuf};
use std::{env, fs};

type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

/// Mutants that are tried at the same time.
const AT_ONCE: usize = 2;

const USAGE: &str =
    "usage: scanrig-mutants CRATE[/FOLDER] build | run COUNT SEED [PLANS] | only NUMBER,... [PLANS]
  CRATE   controller, expert or drivers
  FOLDER  draws only from this folder of its sources, as in controller/bus";

fn main() -> Outcome<()> {
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).ok_or("no repository")?;
    let target = env::var_os("CARGO_TARGET_DIR")
        .map_or_else(|| repository.join("tests/mutants/target"), PathBuf::from);
    let mut args = env::args().skip(1);
    let subject = args.next().unwrap_or_default();
    let (name, folder) = subject.split_once('/').unwrap_or((&subject, ""));
    let Some(subject) = build::Subject::of(name) else { return Err(USAGE.into()) };
    let folder = Path::new(&subject.sources()).join(folder);
    let place = target.join("mutants").join(name);
    let list = place.join("points.tsv");
    let args: Vec<String> = args.collect();
    let plans = |n: usize| args.get(n).map_or_else(|| repository.join("plans/library"), PathBuf::from);
    match args.first().map(String::as_str) {
        Some("build") if args.len() == 1 => build::build(&subject, repository, &place, &list),
        Some("run") if args.len() >= 3 => {
            let all = fs::read_to_string(&list)?;
            let place_of = |line: &str| line.split('\t').nth(1).unwrap_or_default().to_owned();
            let all: Vec<&str> =
                all.lines().filter(|line| Path::new(&place_of(line)).starts_with(&folder)).collect();
            let drawn = trial::draw(&all, args[1].parse()?, args[2].parse()?);
            println!(
                "{} of {} viable mutants of {}, seed {}",
                drawn.len(),
                all.len(),
                folder.display(),
                args[2]
            );
            trial::run(&drawn, &place, &plans(3))
        }
        Some("only") if args.len() >= 2 => {
            let all = fs::read_to_string(&list)?;
            let wanted: Vec<&str> = args[1].split(',').collect();
            let of = |line: &&str| wanted.contains(&line.split('\t').next().unwrap_or_default());
            trial::run(&all.lines().filter(of).collect::<Vec<_>>(), &place, &plans(2))
        }
        _ => Err(USAGE.into()),
    }
}
