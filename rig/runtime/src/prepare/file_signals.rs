//! Signals that stand for files, the log, registers and rows of the relocation table.

use super::TestBench;
use crate::application::observable::Observable;
use crate::codes;
use crate::subject::SubjectExt;
use controller::{FileProbe, Probe, RegisterProbe, RelocationPart};
use document::Findings;
use plans::Case;
use plans::signals::{FileFigure, RowFigure, SignalBinding, SignalSource};
use signal::ValueKind;

/// What a bound name is, where it stands for files, the log or registers: these the subject has to know of.
pub(super) fn observable(
    binding: &SignalBinding,
    case: &Case,
    bench: &mut TestBench<'_>,
    out: &mut Findings,
) -> Option<Option<Observable>> {
    let mut ask = |fact, kind| Observable { probe: bench.subject.file_probe(fact), kind };
    let register = |fact, kind| Observable { probe: Probe::Register(fact), kind };
    let found = match &binding.source {
        SignalSource::Log(text) => ask(FileProbe::Log(text.clone()), ValueKind::Int),
        SignalSource::File { path, asks } => {
            let path = path.clone();
            match asks {
                FileFigure::Exists => ask(FileProbe::Exists(path), ValueKind::Bool),
                FileFigure::Holds(text) => ask(FileProbe::Holds(path, text.clone()), ValueKind::Bool),
                FileFigure::Size => ask(FileProbe::Size(path), ValueKind::Int),
                FileFigure::Lost => ask(FileProbe::Lost(path), ValueKind::Int),
            }
        }
        SignalSource::Register { register: number, exception: false } => {
            register(RegisterProbe::Value(*number), ValueKind::Word)
        }
        SignalSource::Register { register: number, exception: true } => {
            register(RegisterProbe::Exception(*number), ValueKind::Int)
        }
        SignalSource::Relocation { row, figure } => {
            let parts =
                [RelocationPart::Read, RelocationPart::Write].into_iter().zip(&case.settings.relocation);
            let mut places = parts.filter_map(|(part, rows)| {
                let place = rows.iter().position(|known| known.eq_ignore_ascii_case(row))?;
                Some((part, u16::try_from(place).ok()?))
            });
            let Some((part, place)) = places.next() else {
                let message = format!("the relocation table has no row `{row}`");
                out.error(
                    codes::UNKNOWN_NAME,
                    binding.span.clone(),
                    message,
                    "its rows stand in `settings.relocation`",
                );
                return Some(None);
            };
            match figure {
                RowFigure::Address => register(RegisterProbe::Address(part, place), ValueKind::Int),
                RowFigure::Length => register(RegisterProbe::Length(part, place), ValueKind::Int),
                RowFigure::Valid => register(RegisterProbe::Valid(part, place), ValueKind::Bool),
            }
        }
        _ => return None,
    };
    Some(Some(found))
}
