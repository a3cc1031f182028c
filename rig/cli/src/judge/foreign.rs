//! Judging what another instrument recorded.

use super::instant::{self, CaptureNames};
use super::{JudgeArgs, mapping};
use crate::output;
use crate::plan_files::Parameters;
use capture::{Capture, CaptureError, CaptureFormat, Knowledge, MAX_FILE, TimebaseErrors};
use document::file::{self, FileFault};
use document::{Diagnostic, SourceFile};
use plans::Case;
use record::CaseRecord;
use runtime::case::capture_import::{self, CaseLayout, ChannelMapping, Instants};
use runtime::case::rejudge;
use runtime::suite::describe;
use runtime::suite::instrument_file::{InstrumentFile, load_instrument};
use runtime::suite::{self, Disk, Job, LoadedPlan};
use signal::{Span, Trace, When};

/// Reads the capture and judges it by the plan.
pub fn judge(
    args: &JudgeArgs,
    format: CaptureFormat,
    sources: &mut Vec<SourceFile>,
) -> Result<(CaseRecord, Trace), Vec<Diagnostic>> {
    let (mut capture, hash) = read(args, format).map_err(|found| vec![found])?;
    if capture.knowledge == Knowledge::Own {
        own_dump(args, &capture).map_err(|found| vec![found])?;
    }
    let instrument = instrument(args, &capture, sources)?;
    let (loaded, seed) = load(args, &capture, sources)?;
    let (case, job) = choose(args, &capture, &loaded, seed).map_err(|found| vec![found])?;
    let files = loaded.files(&case, &job)?;
    let layout = capture_import::lay_out(&case, &files)?;
    let spelled = reports::vcd::names(layout.signals());
    let known = instrument.as_ref();
    let mut wires = mapping::wires(&args.capture.map, &capture, layout.signals(), &spelled, known)?;
    let marked = wires.iter().any(|wire| layout.signals()[wire.signal].name == "step:start");
    let unsaid = args.capture.start.is_none() && args.capture.at.is_empty();
    let has_marks = marked && unsaid && known.is_none();
    say_what_is_missing(&case, &layout, &wires, has_marks);
    capture_import::find_levels(&mut capture, &mut wires);
    let timebase = known.map_or_else(TimebaseErrors::default, |instrument| instrument.timebase);
    if let Some(instrument) = known {
        capture.correct(&instrument.errors());
    }
    let instants = if has_marks {
        None
    } else {
        // What the user says of instants goes before what the file says of them.
        let names = CaptureNames { capture: &capture, wires: &wires, signals: layout.signals(), timebase };
        let (instants, reference) = instants(args, &layout, &names)?;
        capture.widen_by_rate(reference, timebase.rate);
        Some(instants)
    };
    let marks = |wire: &ChannelMapping| layout.signals()[wire.signal].name.starts_with("step:");
    let wires: Vec<ChannelMapping> =
        wires.iter().copied().filter(|wire| instants.is_none() || !marks(wire)).collect();
    let trace = capture_import::trace(layout, &case, &files, &capture, &wires, instants.as_ref(), known);
    let mut trace = trace
        .map_err(|error| vec![Diagnostic::error("R0170", format!("the capture makes no trace: {error}"))])?;
    describe::annotate_capture(&mut trace, &files, &hash);
    Ok((rejudge::judge_gathered(loaded.plan.text(), &trace)?, trace))
}

/// The instrument file, where there is one.
fn instrument(
    args: &JudgeArgs,
    capture: &Capture,
    sources: &mut Vec<SourceFile>,
) -> Result<Option<InstrumentFile>, Vec<Diagnostic>> {
    let Some(path) = &args.capture.instrument else { return Ok(None) };
    let instrument = load_instrument(&Disk, &path.to_string_lossy(), sources)?;
    if capture.knowledge == Knowledge::Own {
        let message =
            format!("{} is a file of the rig's own, which says what is known", args.trace.display());
        return Err(vec![Diagnostic::error("R0213", message).help("leave out --instrument")]);
    }
    let strange = mapping::unknown_channels(&instrument, capture)?;
    if !strange.is_empty() {
        output::note(&format!("the capture has no channel {} of {}", strange.join(", "), instrument.name));
    }
    Ok(Some(instrument))
}

/// That a dump of the rig's own says how everything was recorded, and that nothing else is said of it.
fn own_dump(args: &JudgeArgs, capture: &Capture) -> Result<(), Diagnostic> {
    let path = args.trace.display();
    if args.capture.period.is_some() {
        let message = format!("{path} is a file of the rig's own, which says what is known");
        return Err(Diagnostic::error("R0213", message).help("leave out --period"));
    }
    match capture.channels.iter().find(|channel| channel.recording.is_none()) {
        Some(channel) => {
            let message = format!("{path}: the dump does not say how `{}` was recorded", channel.name);
            let help =
                "name the trace beside it, or write the dump again: rig report RUN --out DIR --format vcd";
            Err(Diagnostic::error("R0170", message).help(help))
        }
        None => Ok(()),
    }
}

/// The capture, and its hash.
fn read(args: &JudgeArgs, format: CaptureFormat) -> Result<(Capture, String), Diagnostic> {
    let path = args.trace.display();
    let wrong = |what: String| Diagnostic::error("R0170", format!("{path}: {what}"));
    let period = match &args.capture.period {
        None => None,
        Some(text) => match Span::parse(text) {
            Ok(span) if span > Span::ZERO => Some(span),
            _ => {
                let message = format!("--period: `{text}` is no time between two samples");
                return Err(
                    Diagnostic::error("R0177", message).help("write a time above 0, such as \"10 us\"")
                );
            }
        },
    };
    let bytes = file::read(&args.trace, MAX_FILE).map_err(|fault| {
        let help = match fault {
            FileFault::TooLarge { .. } => "capture for a shorter time, or fewer channels",
            _ => "name a file with what the instrument recorded",
        };
        wrong(fault.to_string()).help(help)
    })?;
    let read = capture::read(format, &bytes, period).map_err(|error: CaptureError| {
        let found = wrong(error.to_string());
        if error.fix.is_empty() { found } else { found.help(error.fix) }
    })?;
    Ok((read, describe::sha256(&bytes)))
}

/// The plan with what the command line, or a file of the rig's own, gives for its parameters; and the seed.
fn load(
    args: &JudgeArgs,
    capture: &Capture,
    sources: &mut Vec<SourceFile>,
) -> Result<(LoadedPlan, u64), Vec<Diagnostic>> {
    let note =
        |key: &str| capture.notes.iter().find(|(known, _)| known == key).map(|(_, value)| value.as_str());
    let seed = note("seed").and_then(|seed| seed.parse().ok()).unwrap_or(1);
    let path = args.plan.to_string_lossy();
    // Its own messages are printed: what comes back is how the command ends.
    let mut parameters = Parameters::read(&args.capture.params).map_err(|_| Vec::new())?;
    let mut given = parameters.of_plan(&Disk, &path);
    parameters.finish().map_err(|_| Vec::new())?;
    for (key, value) in &capture.notes {
        if let Some(name) = key.strip_prefix("given:")
            && given.iter().all(|(known, _)| known != name)
        {
            given.push((name.to_owned(), value.clone()));
        }
    }
    let board = match &args.capture.board {
        Some(board) => Some(suite::load_board(&Disk, &board.to_string_lossy(), sources)?),
        None => None,
    };
    let loaded = suite::load_plan(&Disk, &path, board.as_ref(), &given, seed, sources)?;
    Ok((loaded, seed))
}

/// What distinguishes a case from the others of its plan: `[row]` of `folder/plan[row]`.
fn own_part(name: &str) -> &str {
    name.find('[').map_or("", |at| &name[at..])
}

/// The case: named by the user, by a file of the rig's own, or the only one.
fn choose(
    args: &JudgeArgs,
    capture: &Capture,
    loaded: &LoadedPlan,
    seed: u64,
) -> Result<(Case, Job), Diagnostic> {
    let note =
        |key: &str| capture.notes.iter().find(|(known, _)| known == key).map(|(_, value)| value.as_str());
    let cases: Vec<Case> = loaded.plan.cases().collect();
    let wanted = args.capture.case.as_deref();
    let noted = note("plan-case").map(own_part);
    let chosen = cases.iter().position(|case| match (wanted, noted) {
        (Some(wanted), _) => {
            let part = own_part(&case.name);
            case.name == wanted || part == wanted || part == format!("[{wanted}]")
        }
        (None, Some(noted)) => own_part(&case.name) == noted,
        (None, None) => cases.len() == 1,
    });
    let Some(number) = chosen else {
        let names: Vec<&str> = cases.iter().map(|case| case.name.as_str()).collect();
        let message = match wanted {
            Some(wanted) => format!("{} has no case `{wanted}`", loaded.plan.path),
            None => format!("{} has {} cases", loaded.plan.path, cases.len()),
        };
        let help = format!("say which with --case; {}", mapping::known(wanted.unwrap_or_default(), &names));
        return Err(Diagnostic::error("R0175", message).help(help));
    };
    let profile = note("profile");
    let jobs: Vec<Job> =
        loaded.jobs(0, seed, 1).into_iter().filter(|job| job.case == number as u64).collect();
    let job = jobs.iter().find(|job| profile == Some(job.profile.name())).or(jobs.first());
    match (cases.into_iter().nth(number), job) {
        (Some(case), Some(job)) => Ok((case, job.clone())),
        _ => Err(Diagnostic::error("R0175", format!("{} has no case to judge", loaded.plan.path))),
    }
}

/// Claims on what the capture does not have come out inconclusive; the reason is reported. When the steps came is found of the other
/// channels, unless the capture has the marks itself.
fn say_what_is_missing(case: &Case, layout: &CaseLayout, wires: &[ChannelMapping], has_marks: bool) {
    let wired = |name: &str| wires.iter().any(|wire| layout.signals()[wire.signal].name == name);
    let has = |name: &str| wired(name) || !has_marks && name.starts_with("step:");
    let missing: Vec<String> = case.scenario().signals().into_iter().filter(|name| !has(name)).collect();
    if !missing.is_empty() {
        let names = missing.join(", ");
        output::note(&format!(
            "the capture has no channel for {names}: claims on it are inconclusive (--map)"
        ));
    }
}

/// Where the instants of the plan lie, and that from which the time is counted: the start, or the step that it is counted back
/// from.
fn instants(
    args: &JudgeArgs,
    layout: &CaseLayout,
    names: &CaptureNames<'_>,
) -> Result<(Instants, When), Vec<Diagnostic>> {
    let mut found = Vec::new();
    let mut steps: Vec<(String, When)> = Vec::new();
    for text in &args.capture.at {
        match step(text, layout, names) {
            Ok(step) => steps.push(step),
            Err(wrong) => found.push(wrong),
        }
    }
    let start = match &args.capture.start {
        Some(text) => instant::find("--start", text, names).map(|at| Some((at, at))),
        None => Ok(steps.iter().find_map(|(id, at)| Some((before(*at, layout.due(id)?), *at)))),
    };
    match start {
        Ok(Some((start, reference))) if found.is_empty() => {
            for (_, at) in &mut steps {
                *at = names.timebase.rate.drifted(*at, reference);
            }
            Ok((Instants { start, steps }, reference))
        }
        Ok(None) if found.is_empty() => {
            let message = String::from("nothing says where the plan's `start` lies in the capture");
            let help = "say it with --start \"0 s\" or --start \"button rises\", or say where a step lies with \
                        --at press=\"button rises\"";
            Err(vec![Diagnostic::error("R0176", message).help(help)])
        }
        Ok(_) => Err(found),
        Err(wrong) => {
            found.push(wrong);
            Err(found)
        }
    }
}

/// The instant so much earlier.
fn before(at: When, span: Span) -> When {
    When::within(at.earliest.saturating_add(-span), at.latest.saturating_add(-span))
}

fn step(text: &str, layout: &CaseLayout, names: &CaptureNames<'_>) -> Result<(String, When), Diagnostic> {
    let Some((id, when)) = text.split_once('=') else {
        let message = format!("--at {text}: it names no instant");
        return Err(Diagnostic::error("R0178", message).help("write --at STEP=\"button rises\""));
    };
    let id = id.trim();
    if !layout.has_step(id) {
        let message = format!("--at {text}: the case has no step `{id}`");
        return Err(Diagnostic::error("R0178", message).help("name a step of the plan by its id"));
    }
    Ok((id.to_owned(), instant::find(&format!("--at {id}"), when.trim(), names)?))
}
