//! `[subject]`: which controller is tested, whether it is the rig's own, and the lines that it has beside its terminals.

use document::{Data, Fields, Findings, Node};
use signal::Span;

use super::bench::Bench;
use super::codes;
use crate::{ChannelId, ChannelKind};

/// The controller under test.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Subject {
    /// Name of its profile, as in `m241-2019`.
    pub profile: String,
    /// Its reference, as in `TM241CEC24T`; `None` for the profile's usual one.
    pub reference: Option<String>,
    /// How the rig meets a controller that is not its own; `None` for the rig's own model.
    pub external: Option<External>,
}

impl Default for Subject {
    /// The model of a TM241CEC24T, `m241-2019`.
    fn default() -> Self {
        Subject { profile: "m241-2019".into(), reference: Some("TM241CEC24T".into()), external: None }
    }
}

impl Subject {
    /// Whether it is a real controller on the board's lines.
    pub fn is_external(&self) -> bool {
        self.external.is_some()
    }
}

/// How the rig meets a real controller.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct External {
    /// The command that brings a case's program into it; empty: the program is there.
    pub load: Vec<String>,
    /// The command after a case; empty: none.
    pub unload: Vec<String>,
    /// The longest that each of the two may take.
    pub load_within: Span,
    /// Whether a case begins with its supply off and on again, where the board can do that.
    pub cycle: bool,
    /// How long its supply stays off then.
    pub off: Span,
    /// The longest from its supply to its program.
    pub boot: Span,
    /// How late its outputs may come for reasons that are not its own.
    pub jitter: Span,
}

impl Default for External {
    fn default() -> Self {
        External {
            load: Vec::new(),
            unload: Vec::new(),
            load_within: Span::from_secs(60),
            cycle: true,
            off: Span::from_secs(1),
            boot: Span::from_secs(60),
            jitter: Span::ZERO,
        }
    }
}

/// The lines that a controller has beside its terminals. The rig drives the first two and sees the third of a real
/// controller; of one that the rig plays it is the other way round.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SubjectLines {
    /// Its supply: 1 is on.
    pub power: Option<ChannelId>,
    /// Its Run/Stop switch: 1 is Run.
    pub run_stop: Option<ChannelId>,
    /// 1 while it is in RUNNING.
    pub alarm: Option<ChannelId>,
}

/// The keys that only a real controller has.
const OF_EXTERNAL: [&str; 7] = ["load", "unload", "load-within", "cycle", "off", "boot", "jitter"];

/// Reads the table, but for its channels.
pub(super) fn subject(fields: Option<Fields<'_>>, out: &mut Findings) -> Subject {
    let Some(fields) = fields else { return Subject::default() };
    let external = match fields.text("kind") {
        Some("external") => Some(external(&fields, out)),
        None | Some("model") => {
            for entry in OF_EXTERNAL.iter().filter_map(|key| fields.entry(key)) {
                let message = format!("the model has no `{}`", entry.key);
                let help = "remove it, or write kind = \"external\"";
                out.error(codes::SUBJECT_KEY, entry.key_span.clone(), message, help);
            }
            None
        }
        Some(kind) => {
            let message = format!("subjects of kind \"{kind}\" are not available");
            if let Some(node) = fields.get("kind") {
                let help = "write kind = \"model\", or kind = \"external\" for a real controller";
                out.bad(codes::SUBJECT_KIND, node, message, help);
            }
            None
        }
    };
    let default = Subject::default();
    let reference = fields.text("reference").map(str::to_owned);
    match fields.text("profile") {
        None => Subject { profile: default.profile, reference: reference.or(default.reference), external },
        Some(profile) => Subject { profile: profile.to_owned(), reference, external },
    }
}

fn external(fields: &Fields<'_>, out: &mut Findings) -> External {
    let default = External::default();
    let mut command = |key: &str| {
        let Some(node) = fields.get(key) else { return Vec::new() };
        let words = match &node.data {
            Data::Array(nodes) => nodes.iter().filter_map(Node::as_text).map(str::to_owned).collect(),
            _ => Vec::new(),
        };
        let named = words.first().is_some_and(|program: &String| !program.is_empty());
        if !named || words.iter().any(|word| word.contains('\0')) {
            let help = "write the program and its arguments, as in [\"./load.sh\", \"plc1\"]";
            out.bad(codes::SUBJECT_COMMAND, node, format!("`{key}` names no command"), help);
        }
        words
    };
    let (load, unload) = (command("load"), command("unload"));
    let within = |key: &str, usual: Span| fields.duration(key).unwrap_or(usual);
    External {
        load,
        unload,
        load_within: within("load-within", default.load_within),
        cycle: fields.boolean("cycle").unwrap_or(default.cycle),
        off: within("off", default.off),
        boot: within("boot", default.boot),
        jitter: within("jitter", default.jitter),
    }
}

/// Finds the channels of its lines.
pub(super) fn subject_lines(fields: &Fields<'_>, bench: &Bench<'_>, out: &mut Findings) -> SubjectLines {
    let mut taken: Vec<(ChannelId, &str)> = Vec::new();
    let mut line = |key: &'static str| {
        let node = fields.get(key)?;
        let channel = bench.channel(node, out)?;
        let spec = &bench.file.circuit.channels[usize::from(channel.0)];
        let rig_drives = bench.file.subject.is_external() == (key != "alarm");
        let wrong = if spec.kind != ChannelKind::Digital {
            Some((format!("`{key}` is a level, `{}` an analog channel", spec.name), "name a digital channel"))
        } else if let Some((_, other)) = taken.iter().find(|(known, _)| *known == channel) {
            Some((format!("`{other}` has the channel `{}` already", spec.name), "give each its own channel"))
        } else if rig_drives && !spec.drives {
            Some((format!("`{key}` needs a channel that is driven"), "remove `drives = false`"))
        } else if !rig_drives && !spec.senses {
            Some((format!("`{key}` needs a channel that is sensed"), "remove `senses = false`"))
        } else {
            None
        };
        taken.push((channel, key));
        match wrong {
            Some((message, help)) => {
                out.bad(codes::SUBJECT_LINE, node, message, help);
                None
            }
            None => Some(channel),
        }
    };
    SubjectLines { power: line("power"), run_stop: line("run-stop"), alarm: line("alarm") }
}
