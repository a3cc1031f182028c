//! Places of %I and %Q that a program names and where nothing is.

use crate::application::module_terminals::{ModuleTerminals, TerminalOfModule};
use crate::codes;
use controller::Config;
use document::Diagnostic;
use plans::Case;
use plans::signals::SignalSource;
use profile::{IoChannel, Reference, rearming_command, short_circuit_status};
use program::{ImagePlace, Program};
use signal::{Address, Area};

/// What is worth knowing of the places of the images that a program names: no channel is there, or one that is not used. Such a
/// place is memory alone: what is read there stays 0, and what is written reaches no terminal. A place that the plan itself looks at or
/// writes by its address is meant as memory, and is passed over.
pub(crate) fn warnings(program: &Program, config: &Config, case: &Case) -> Vec<Diagnostic> {
    let terminals = ModuleTerminals::new(config.reference, &config.modules);
    let warned = |place: &ImagePlace| {
        if is_memory_of(case, place) {
            return None;
        }
        let (message, help) = of_nothing(place, config.reference, &terminals)?;
        let file = program.files().get(usize::from(place.file)).cloned().unwrap_or_default();
        let found = Diagnostic::warning(codes::PLACE_OF_NOTHING, message);
        Some(found.at(file, place.span.clone(), "").help(help))
    };
    program.images().iter().filter_map(warned).collect()
}

/// Whether the plan of a case names a place of an image that shares bits with this one.
fn is_memory_of(case: &Case, place: &ImagePlace) -> bool {
    let end = place.address.bit_offset().saturating_add(place.bits);
    case.signals.iter().any(|binding| match binding.source {
        SignalSource::Memory(named) | SignalSource::Image(named) => {
            named.area() == place.address.area()
                && named.bit_offset() < end
                && place.address.bit_offset() < named.bit_offset() + named.bit_len()
        }
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
    if own.any(|bit| is_embedded(bit, reference)) || terminals.has_status_at(address, bits) {
        return None;
    }
    let there: Vec<TerminalOfModule<'_>> = terminals.at(address, bits).collect();
    if there.iter().any(TerminalOfModule::is_used) {
        return None;
    }
    let what = if address.area() == Area::Input { "input" } else { "output" };
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
