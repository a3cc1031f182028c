//! Places of %I and %Q that a program names and where nothing is, or something else than what it is taken for.

use crate::application::module_terminals::{ModuleTerminals, TerminalOfModule};
use crate::codes;
use controller::Config;
use document::Diagnostic;
use plans::Case;
use plans::signals::SignalSource;
use profile::{IoChannel, Reference, rearming_command, short_circuit_status};
use program::{ImagePlace, Program};
use signal::{Address, Area};

/// What is worth knowing of the places of the images that a program names: no channel is there, or one that is not used, or it is a
/// part of an analogue channel, or the status of one that the program does not read. A place where nothing is is memory alone: what is read there stays 0, and what is written reaches no terminal. A place that the plan itself looks at or
/// writes by its address is meant as memory, and is passed over.
pub(crate) fn warnings(program: &Program, config: &Config, case: &Case) -> Vec<Diagnostic> {
    let terminals = ModuleTerminals::new(config.reference, &config.modules);
    let warned = |place: &ImagePlace| {
        if is_memory_of(case, place) {
            return None;
        }
        let of_nothing =
            of_nothing(place, config.reference, &terminals).map(|why| (codes::PLACE_OF_NOTHING, why));
        let (code, (message, help)) = of_nothing.or_else(|| {
            let why =
                part_of_word(place, &terminals).or_else(|| status_of_unread(place, program, &terminals))?;
            Some((codes::PLACE_OF_ANOTHER, why))
        })?;
        let file = program.files().get(usize::from(place.file)).cloned().unwrap_or_default();
        Some(Diagnostic::warning(code, message).at(file, place.span.clone(), "").help(help))
    };
    program.images().iter().filter_map(warned).collect()
}

/// Whether the plan of a case names a place of an image that shares bits with this one.
fn is_memory_of(case: &Case, place: &ImagePlace) -> bool {
    case.signals.iter().any(|binding| match binding.source {
        SignalSource::Memory(named) | SignalSource::Image(named) => shares_bits(place, named),
        _ => false,
    })
}

/// What is wrong with a place, and what helps; `None` for one at which something is.
fn of_nothing(
    place: &ImagePlace,
    reference: &'static Reference,
    terminals: &ModuleTerminals<'_>,
) -> Option<(String, String)> {
    let (address, bits) = (place.address, place.bits);
    let first = address.bit_offset();
    let mut own = (first..first.saturating_add(bits)).map(|bit| Address::bit(address.area(), bit));
    if own.any(|bit| is_embedded(bit, reference)) {
        return None;
    }
    let there: Vec<TerminalOfModule<'_>> = terminals.at(address, bits).collect();
    let with_status: Vec<TerminalOfModule<'_>> = terminals.of_status_at(address, bits).collect();
    if there.iter().chain(&with_status).any(TerminalOfModule::is_used) {
        return None;
    }
    let what = if address.area() == Area::Input { "input" } else { "output" };
    if let ([], Some(terminal)) = (&there[..], with_status.first()) {
        let kind = if terminal.is_input() { "an input" } else { "an output" };
        let message = format!(
            "{address} is the status of {terminal}, {kind} of {} that is not used",
            terminal.reference()
        );
        return Some((message, terminal.how_to_use()));
    }
    if let Some(terminal) = there.first() {
        let message =
            format!("{address} is {terminal}, an {what} of {} that is not used", terminal.reference());
        return Some((message, terminal.how_to_use()));
    }
    Some((
        format!("no {what} of the controller is at {address}"),
        known_places(address.area(), reference, terminals),
    ))
}

/// A place within the word of an analogue channel: what was at this address was a digital channel or a status byte before the
/// list of modules changed.
fn part_of_word(place: &ImagePlace, terminals: &ModuleTerminals<'_>) -> Option<(String, String)> {
    if place.bits >= WORD {
        return None;
    }
    let word = terminals.at(place.address, place.bits).find(TerminalOfModule::is_word)?;
    let message =
        format!("{} is a part of {word}, an analogue channel of {}", place.address, word.reference());
    let status = word.status().map_or_else(String::new, |status| format!(", its status {status}"));
    Some((message, format!("its word is {}{status}", word.place()?)))
}

/// The status byte of an input whose value the program does not read: most likely that of another one is meant.
fn status_of_unread(
    place: &ImagePlace,
    program: &Program,
    terminals: &ModuleTerminals<'_>,
) -> Option<(String, String)> {
    let mut of = terminals.of_status_at(place.address, place.bits);
    let (Some(terminal), None) = (of.next(), of.next()) else { return None };
    let is_read = |terminal: &TerminalOfModule<'_>| {
        let word = terminal.place();
        program.images().iter().any(|named| word.is_some_and(|word| shares_bits(named, word)))
    };
    if !terminal.is_input() || place.bits > BYTE || is_read(&terminal) {
        return None;
    }
    let read = terminals.all().map(|(terminal, _)| terminal).filter(|one| one.is_word() && one.is_input());
    let known: Vec<String> = read
        .filter(is_read)
        .filter_map(|one| Some(format!("that of {} ({one}) is {}", one.place()?, one.status()?)))
        .collect();
    let message =
        format!("{} is the status of {terminal}, whose value the program does not read", place.address);
    let own = terminal.place()?;
    Some((
        message,
        match known.is_empty() {
            true => format!("the value of {terminal} is {own}"),
            false => {
                format!("the value of {terminal} is {own}; the program reads others: {}", known.join(", "))
            }
        },
    ))
}

const BYTE: u32 = 8;
const WORD: u32 = 16;

/// Whether a place that a program names has bits of an address.
fn shares_bits(named: &ImagePlace, address: Address) -> bool {
    let end = named.address.bit_offset().saturating_add(named.bits);
    named.address.area() == address.area()
        && address.bit_offset() < end
        && named.address.bit_offset() < address.bit_offset() + address.bit_len()
}

/// Which inputs or outputs a controller has with its modules: what to say where there is none at an address.
pub(crate) fn known_places(
    area: Area,
    reference: &'static Reference,
    terminals: &ModuleTerminals<'_>,
) -> String {
    let what = if area == Area::Input { "input" } else { "output" };
    let mut known: Vec<String> = embedded(area, reference).into_iter().collect();
    known.extend(terminals.in_image(area));
    match known.is_empty() {
        true => format!(
            "{} has no {what}s without modules that have some: write `settings.modules`",
            reference.name
        ),
        false => format!("its {what}s are {}", known.join(", ")),
    }
}

/// Whether a bit of an image is that of the controller itself: of an embedded channel, of the status of its outputs or of the
/// command that rearms them (io:ADR-01, io:ADR-02).
fn is_embedded(bit: Address, reference: &'static Reference) -> bool {
    let special = match bit.area() {
        Area::Input => short_circuit_status(reference),
        Area::Output => rearming_command(reference),
        Area::Memory => None,
    };
    IoChannel::at(bit, reference).is_some()
        || special.is_some_and(|(byte, number)| bit.bit_offset() == byte * 8 + number)
}

/// The embedded channels of an image in words.
fn embedded(area: Area, reference: &'static Reference) -> Option<String> {
    let (count, special, what) = match area {
        Area::Input => {
            (reference.input_count(), short_circuit_status(reference), "the status of its outputs")
        }
        _ => (reference.output_count(), rearming_command(reference), "the command that rearms them"),
    };
    let last = u32::try_from(count.checked_sub(1)?).ok()?;
    let channels = format!("{}..{}", Address::bit(area, 0), Address::bit(area, last));
    Some(match special {
        Some((byte, bit)) => {
            format!("{channels} and {what} {} of {}", Address::bit(area, byte * 8 + bit), reference.name)
        }
        None => format!("{channels} of {}", reference.name),
    })
}
