//! What a plan says of itself: program, needs, requirements and profiles.

use document::{Fields, Findings, Node, suggest};
use profile::Profile;

use super::read::PlanDocument;
use super::{InitialState, PlanSettings, PlanStep};
use crate::codes;
use crate::lang::{Amount, BoundRelation, Need, NeedBound};
use crate::signals::{SignalBinding, SignalSource};
use crate::steps::ProgramRef;

/// Areas of the requirements.
const AREAS: &[&str] = &["controller", "io", "ethernet", "serial-can", "plcsystem"];

/// The program.
pub(super) fn program(
    document: &PlanDocument,
    fields: &Fields<'_>,
    settings: &PlanSettings,
    out: &mut Findings,
) -> ProgramRef {
    if let Some(text) = &document.program_text {
        return text.clone();
    }
    let files: Vec<String> =
        fields.each("program").iter().filter_map(Node::as_text).map(str::to_owned).collect();
    if !files.is_empty() {
        for node in fields
            .each("program")
            .iter()
            .filter(|node| node.as_text().is_some_and(|text| text.trim().is_empty()))
        {
            out.bad(
                codes::PROGRAM,
                node,
                "the name of a program file is empty",
                "as in program = \"lamp.st\"",
            );
        }
        return ProgramRef::Files(files);
    }
    let loads = settings.initial == InitialState::Empty;
    if !loads && !fields.has("program") {
        let help =
            "write program = \"lamp.st\" or program-text = \'\'\'...\'\'\', or settings.initial = \"empty\"";
        out.error(codes::PROGRAM, 0..0, "the plan has no program", help);
    }
    ProgramRef::None
}

/// The entries of a list that is looked through again for each of its entries.
fn few<'n>(fields: &Fields<'n>, key: &str, out: &mut Findings) -> &'n [Node] {
    const MOST: usize = 500;
    let list = fields.each(key);
    if let Some(node) = list.get(MOST) {
        out.bad(codes::TOO_LARGE, node, format!("`{key}` has more than {MOST} entries"), "split the plan");
        return &[];
    }
    list
}

/// The powers that the plan says it needs.
pub(super) fn needs(fields: &Fields<'_>, out: &mut Findings) -> Vec<Need> {
    let mut list: Vec<Need> = Vec::new();
    for node in few(fields, "needs", out) {
        let Some(text) = node.as_text() else { continue };
        match Need::parse(text) {
            Ok(need) if list.contains(&need) => {}
            Ok(need) => list.push(need),
            Err((at, fault)) => {
                let message = format!("`{text}` is no need: {fault}");
                let help =
                    "write one as in \"memory-access\", \"pulse >= 200 kHz\" or \"timestamp <= 0.5 us\"";
                out.bad_inside(codes::NEED, node, Some(at..text.len()), message, help);
            }
        }
    }
    list
}

/// Adds what the verbs and signals of a case need and the plan does not say.
pub(super) fn implied_needs(steps: &[PlanStep], signals: &[SignalBinding], needs: &mut Vec<Need>) {
    let mut add = |need: Need| {
        if !needs
            .iter()
            .any(|known| known.word == need.word && (need.bound.is_none() || known.bound == need.bound))
        {
            needs.push(need);
        }
    };
    for step in steps {
        if let Some(rate) = step.stimulus.millihertz() {
            let bound = NeedBound { relation: BoundRelation::AtLeast, amount: Amount::Millihertz(rate) };
            add(Need { word: "pulse", bound: Some(bound) });
            continue;
        }
        for word in step.stimulus.needs() {
            add(Need { word, bound: None });
        }
    }
    for signal in signals {
        match &signal.source {
            SignalSource::Memory(_) | SignalSource::Image(_) | SignalSource::Task { .. } => {
                add(Need { word: "memory-access", bound: None });
            }
            SignalSource::Log(_) | SignalSource::File { .. } => add(Need { word: "files", bound: None }),
            SignalSource::Register { .. } | SignalSource::Relocation { .. } => {
                add(Need { word: "registers", bound: None });
            }
            SignalSource::Path(path) => {
                let upper = path.to_ascii_uppercase();
                if ["PLC_R.", "PLC_W.", "TM3_MODULE_R[", "TM3_BUS_W."]
                    .iter()
                    .any(|begin| upper.starts_with(begin))
                {
                    add(Need { word: "system-variables", bound: None });
                }
                if upper.starts_with("LED.") || upper.starts_with("OUTPUT.Q") {
                    add(Need { word: "indicators", bound: None });
                }
            }
            SignalSource::Line(_)
            | SignalSource::Channel(_)
            | SignalSource::Frames(_)
            | SignalSource::FrameSignal(_) => {}
        }
    }
}

/// The requirements that the plan proves.
pub(super) fn proves(fields: &Fields<'_>, out: &mut Findings) -> Vec<String> {
    let mut list: Vec<String> = Vec::new();
    for node in few(fields, "proves", out) {
        let Some(text) = node.as_text() else { continue };
        if is_requirement(text) {
            if !list.iter().any(|known| known == text) {
                list.push(text.to_owned());
            }
            continue;
        }
        let area = text.split(':').next().unwrap_or_default();
        let help = match suggest(area, AREAS.iter().copied()) {
            Some(meant) if text.contains(':') && meant != area => format!("did you mean the area `{meant}`?"),
            _ => {
                "write it as in \"controller:WD-04\", a clause of it as in \"controller:RB-02#8\"".to_owned()
            }
        };
        out.bad(codes::REQUIREMENT, node, format!("`{text}` is not the ID of a requirement"), help);
    }
    list
}

/// The words that the plan's cases can be chosen by, each once.
pub(super) fn tags(fields: &Fields<'_>, out: &mut Findings) -> Vec<String> {
    let mut list: Vec<String> = Vec::new();
    for text in few(fields, "tags", out).iter().filter_map(Node::as_text) {
        if !text.is_empty() && !list.iter().any(|known| known == text) {
            list.push(text.to_owned());
        }
    }
    list
}

/// `area:WORD-04`, `area:TWO-WORDS-04b`, `area:WORD-04#clause`.
fn is_requirement(text: &str) -> bool {
    let (text, clause) = text.split_once('#').unwrap_or((text, "x"));
    let Some((area, id)) = text.split_once(':') else { return false };
    let parts: Vec<&str> = id.split('-').collect();
    let [words @ .., number] = parts.as_slice() else { return false };
    let word =
        |word: &&str| !word.is_empty() && word.chars().all(|c| c.is_ascii_uppercase() || c.is_ascii_digit());
    let digits = number.strip_suffix(|c: char| c.is_ascii_lowercase()).unwrap_or(number);
    AREAS.contains(&area)
        && id.len() <= 40
        && !words.is_empty()
        && words.iter().all(word)
        && !digits.is_empty()
        && digits.chars().all(|c| c.is_ascii_digit())
        && crate::register::is_clause(clause)
}

/// The profiles that the plan holds for.
pub(super) fn profiles(fields: &Fields<'_>, out: &mut Findings) -> Vec<Profile> {
    let mut list = Vec::new();
    for node in few(fields, "profiles", out) {
        let Some(text) = node.as_text() else { continue };
        match Profile::ALL.into_iter().find(|profile| profile.name() == text) {
            Some(profile) if list.contains(&profile) => {}
            Some(profile) => list.push(profile),
            None => {
                let help = match suggest(text, Profile::ALL.iter().map(|profile| profile.name())) {
                    Some(meant) => format!("did you mean \"{meant}\"?"),
                    None => "the profiles are m241-2014, m241-2019 and m251-2024".to_owned(),
                };
                out.bad(codes::PROFILE, node, format!("there is no profile \"{text}\""), help);
            }
        }
    }
    list
}
