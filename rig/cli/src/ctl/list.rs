//! `rig ctl list` and `rig ctl rigs`.

use super::CtlError;
use super::show::{self, columns};
use crate::exit::ExitStatus;
use crate::output;
use clap::Args;
use control::client::running;
use control::{ControlClient, Description, PointDirection, PointInfo, RequestOperation, Signal, SignalKind};
use serde_json::json;

/// `rig ctl list`.
#[derive(Debug, Args)]
pub struct CtlListArgs {
    /// Only those of which one of these words is a part, in any case of letters.
    #[arg(value_name = "WORD")]
    words: Vec<String>,
    /// Print JSON for a program: the entries of `describe`.
    #[arg(long)]
    json: bool,
}

impl CtlListArgs {
    fn takes(&self, row: &[String]) -> bool {
        let has = |word: &String| row.iter().any(|cell| cell.to_lowercase().contains(&word.to_lowercase()));
        self.words.is_empty() || self.words.iter().any(has)
    }
}

/// Lists points and signals.
pub fn list(client: &mut ControlClient, args: &CtlListArgs) -> Result<ExitStatus, CtlError> {
    let it: Description = client.ask(RequestOperation::Describe)?;
    let points: Vec<&PointInfo> = it.points.iter().filter(|one| args.takes(&point(one))).collect();
    let signals: Vec<&Signal> = it.signals.iter().filter(|one| args.takes(&signal(one))).collect();
    if args.json {
        show::json(&json!({ "points": points, "signals": signals }));
        return Ok(ExitStatus::Passed);
    }
    let rows: Vec<Vec<String>> =
        points.into_iter().map(point).chain(signals.into_iter().map(signal)).collect();
    output::print(&columns(&rows));
    Ok(ExitStatus::Passed)
}

/// Name, kind, where it is, what the program calls it, what can be done with it.
fn point(point: &PointInfo) -> Vec<String> {
    let way = match point.direction {
        PointDirection::Input => "input",
        PointDirection::Output => "output",
        PointDirection::Loose => "line",
    };
    let unit = point.channel.as_ref().map(|channel| channel.unit.as_str()).unwrap_or_default();
    let mut also = Vec::new();
    also.extend(point.address.clone());
    also.extend(point.variable.clone());
    also.extend(point.channel.as_ref().map(|line| line.name.clone()).filter(|name| *name != point.name));
    let can = match (point.forcible, point.writable) {
        (true, true) => "force, write",
        (true, false) => "force",
        (false, true) => "write",
        (false, false) => "",
    };
    vec![point.name.clone(), kind(point.kind, unit), way.to_owned(), can.to_owned(), also.join("  ")]
}

fn signal(signal: &Signal) -> Vec<String> {
    let can = if signal.writable { "write" } else { "" };
    vec![
        signal.name.clone(),
        kind(signal.kind, &signal.unit),
        "inside".to_owned(),
        can.to_owned(),
        String::new(),
    ]
}

fn kind(kind: SignalKind, unit: &str) -> String {
    let word = match kind {
        SignalKind::Bool => "bool",
        SignalKind::Int => "int",
        SignalKind::Word => "word",
        SignalKind::Real => "real",
        SignalKind::State => "state",
    };
    if unit.is_empty() { word.to_owned() } else { format!("{word}, {unit}") }
}

/// Lists the rigs that run.
pub fn rigs() -> ExitStatus {
    let row = |rig: &ControlClient| {
        let (socket, greeting) = (rig.socket().display().to_string(), rig.greeting());
        vec![socket, greeting.reference.clone(), greeting.board.clone()]
    };
    output::print(&columns(&running().iter().map(row).collect::<Vec<_>>()));
    ExitStatus::Passed
}
