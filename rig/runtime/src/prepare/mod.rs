//! From the names of a plan to terminals, channels, probes and signals.

mod lines;
mod meaning;
mod signals;
mod steps;

use crate::facts;
use crate::schedule::Planned;
use crate::subject::Subject;
use crate::wiring::Wiring;
use controller::{Channel as Terminal, Probe, State};
use document::{Diagnostic, Findings};
use drivers::{Board, BoardFile};
use meaning::{Meaning, Names, meaning};
use plans::Case;
use plans::plan::ProgramRef;
use profile::{Profile, Reference};
use signal::{Kind, SignalId, SignalInfo, Trace};
use signals::{channel_info, clocked, define, policy};
use steps::plan_step;

/// What the names of a case are looked up in.
pub struct Bench<'a> {
    /// The subject.
    pub subject: &'a mut dyn Subject,
    /// The board.
    pub board: &'a dyn Board,
    /// The board's file.
    pub file: &'a BoardFile,
    /// The subject's profile.
    pub profile: Profile,
    /// The subject's reference.
    pub reference: &'static Reference,
    /// The application that a download step transfers where it names none; empty where there is none.
    pub bundle: &'a [u8],
    /// The programs that steps bring, as bundles.
    pub others: &'a [(ProgramRef, Vec<u8>)],
    /// Whether the clock is exact.
    pub exact: bool,
}

impl std::fmt::Debug for Bench<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Bench").field("file", &self.file.name).finish_non_exhaustive()
    }
}

/// A case with every name resolved.
#[derive(Debug)]
pub struct Prepared {
    /// The trace with its signals defined.
    pub trace: Trace,
    /// Who is behind whom.
    pub wiring: Wiring,
    /// The steps.
    pub steps: Vec<Planned>,
    /// Observed probes with their signals, to be read once at the start.
    pub probes: Vec<(Probe, SignalId)>,
    /// What is wrong with the plan and does not keep it from running.
    pub warnings: Vec<Diagnostic>,
}

/// The labels of the signal `state`.
pub fn state_labels() -> Vec<(i64, String)> {
    State::ALL.iter().map(|state| (state.number(), state.name().to_owned())).collect()
}

/// Resolves the names of a case and defines its signals in `trace`.
///
/// # Errors
/// Findings with their places in the plan: names that mean nothing on this bench, values that do not fit.
pub fn prepare(
    case: &Case,
    plan: &document::SourceFile,
    mut trace: Trace,
    bench: &mut Bench<'_>,
) -> Result<Prepared, Vec<Diagnostic>> {
    let mut out = Findings::new(plan, plans::TOML);
    let mut wiring = Wiring::new(bench.reference.output_count(), bench.board.channels().len());
    for binding in &bench.file.bind {
        match Terminal::at(binding.address, bench.reference) {
            Some(Terminal::Input(input)) => wiring.inputs[usize::from(binding.channel.0)].push(input),
            Some(Terminal::Output(output)) => wiring.outputs[output] = Some(binding.channel),
            None => {}
        }
    }
    let mut state = SignalInfo::exact("state", Kind::State);
    state.labels = state_labels();
    wiring.state = define(&mut trace, state, &mut out);
    let mut names = Vec::new();
    let mut probes = Vec::new();
    for binding in &case.signals {
        let found = facts::observable(binding, case, bench, &mut out);
        let found = found.map(|found| found.map(Meaning::Inside));
        let Some(meaning) = found.unwrap_or_else(|| meaning(binding, bench, &mut out)) else { continue };
        let info = match meaning {
            Meaning::Channel(channel, _) => {
                channel_info(&binding.name, &bench.board.channels()[usize::from(channel.0)])
            }
            Meaning::Inside(observable) => SignalInfo {
                labels: observable.labels(),
                ..SignalInfo::exact(&binding.name, observable.kind)
            },
        };
        let Some(policy) = policy(binding, &info, &mut out) else { continue };
        let info = clocked(SignalInfo { policy, ..info }, bench.exact);
        let Some(signal) = define(&mut trace, info, &mut out) else { continue };
        match meaning {
            Meaning::Channel(channel, _) => wiring.channels[usize::from(channel.0)].push(signal),
            Meaning::Inside(observable) => {
                let probe = bench.subject.watch(observable.probe);
                wiring.show_probe(probe, signal);
                probes.push((observable.probe, signal));
            }
        }
        names.push((binding.name.clone(), meaning, signal));
    }
    for (mark, place) in [("step:start", &mut wiring.start), ("step:end", &mut wiring.end)] {
        *place = define(&mut trace, SignalInfo::exact(mark, Kind::Mark), &mut out);
    }
    let mut steps = Vec::new();
    for step in &case.steps {
        let mark = define(&mut trace, SignalInfo::exact(format!("step:{}", step.id), Kind::Mark), &mut out);
        let done =
            define(&mut trace, SignalInfo::exact(format!("step:{}.done", step.id), Kind::Mark), &mut out);
        let (Some(mark), Some(done)) = (mark, done) else { continue };
        let names = Names { list: &names, state: wiring.state };
        let planned = plan_step(step, mark, done, &names, &trace, bench, &mut out);
        steps.extend(planned);
    }
    let found = out.into_vec();
    if found.iter().any(Diagnostic::is_error) {
        return Err(found);
    }
    Ok(Prepared { trace, wiring, steps, probes, warnings: found })
}
