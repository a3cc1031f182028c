//! From the text of a board file to a board that can be built.

use document::{Diagnostic, Fields, Findings, Node, SourceFile, suggest, toml};

use super::bench::Bench;
use super::devices::counter;
use super::realtime::realtime;
use super::subject::{subject, subject_lines};
use crate::circuit::PlantPrograms;

use super::{
    BoardFile, BoardKind, OnLoss, Subject, Terminals, UnknownSubject, check, clock, codes, control, delays,
    guard, keys, modules, parts, ports, real, sim_buses, statements,
};

/// Reads a board file. `terminals` says which terminals a subject has. A plant that runs a program is refused:
/// [`read_with_programs`] has them.
///
/// # Errors
/// Everything that is wrong with the file, by place, under [`super::CODES`].
pub fn read(
    file: &SourceFile,
    terminals: &dyn Fn(&Subject) -> Result<Terminals, UnknownSubject>,
) -> Result<BoardFile, Vec<Diagnostic>> {
    read_file(file, terminals, None)
}

/// As [`read`], with the programs of its plants.
///
/// # Errors
/// Those of [`read`], and what is wrong with the programs.
pub fn read_with_programs(
    file: &SourceFile,
    terminals: &dyn Fn(&Subject) -> Result<Terminals, UnknownSubject>,
    programs: &dyn PlantPrograms,
) -> Result<BoardFile, Vec<Diagnostic>> {
    read_file(file, terminals, Some(programs))
}

fn read_file(
    file: &SourceFile,
    terminals: &dyn Fn(&Subject) -> Result<Terminals, UnknownSubject>,
    programs: Option<&dyn PlantPrograms>,
) -> Result<BoardFile, Vec<Diagnostic>> {
    let tree = toml::parse(file, codes::DOCUMENT)?;
    let mut out = Findings::new(file, codes::DOCUMENT);
    let fields = Fields::check(&tree, 0..0, "board file", keys::KEYS, &mut out);
    if let Some(format) = fields.integer("format").filter(|format| *format != 1) {
        let place = fields.get("format").map_or(0..0, |node| node.span.clone());
        let message = format!("format {format} is not supported");
        out.error(codes::FORMAT, place, message, "this version of the rig reads format 1");
    }
    let board = fields.inner("board");
    let kind = board.and_then(|board| board.get("kind"));
    let real = kind.and_then(Node::as_text) == Some("real");
    if let Some(node) = kind.filter(|node| !real && node.as_text() != Some("simulated")) {
        let message = format!("boards of kind \"{}\" are not available", node.as_text().unwrap_or_default());
        out.bad(codes::BOARD_KIND, node, message, "write kind = \"simulated\" or kind = \"real\"");
    }
    let subject = subject(fields.inner("subject"), &mut out);
    // What follows would only repeat what a wrong key or subject brings about.
    if out.has_errors() {
        return Err(out.into_vec());
    }
    let terminals = match terminals(&subject) {
        Ok(terminals) => terminals,
        Err(unknown) => {
            unknown_subject(&subject, &unknown, fields.inner("subject"), &mut out);
            return Err(out.into_vec());
        }
    };
    let default = match real {
        true => BoardFile::default_for(&[], &[]),
        false => BoardFile::default_for(&terminals.inputs, &terminals.outputs),
    };
    let title = fields.text("title").unwrap_or_default().to_owned();
    let punctual = fields.inner("realtime").map(|table| realtime(&table, &mut out)).unwrap_or_default();
    let mut bench = Bench::new(
        BoardFile { name: file.name.clone(), title, subject, realtime: punctual, ..default },
        &terminals,
        programs,
    );
    let entries = |key| fields.get(key).and_then(Node::as_table).map_or(&[][..], |table| &table.entries);
    bench.channels(entries("channels"), &mut out);
    if real {
        bench.bind_by_name();
    }
    bench.bind(entries("bind"), &mut out);
    bench.file.fitted = modules::fitted(&fields, &terminals.modules, &bench.file.subject, &mut out);
    bench.file.ports = ports::read(&fields, &terminals.ports, !real, &mut out);
    if let Some(fields) = fields.inner("subject") {
        bench.file.lines = subject_lines(&fields, &bench, &mut out);
    }
    bench.file.on_loss = match board.and_then(|board| board.text("on-loss")) {
        Some("end") => OnLoss::End,
        Some(_) => OnLoss::GoOn,
        None if real => OnLoss::End,
        None => OnLoss::GoOn,
    };
    if let Some(board) = &board {
        bench.file.clock = clock::of_board(board, &mut out);
    }
    bench.file.statements = statements::of_board(&tree);
    bench.file.guard = guard::read(fields.inner("guard"), &mut out);
    bench.file.control = control::read(fields.inner("control"), &mut out);
    if real {
        if let Some(spec) = real::real(&fields, &mut bench, &mut out) {
            bench.file.kind = BoardKind::Real(Box::new(spec));
            bench.file.delays = delays::read(&fields, &bench, &mut out);
        }
        bench.file.check = board.and_then(|board| check::looped(&board, &bench, &mut out));
        return if out.has_errors() { Err(out.into_vec()) } else { Ok(bench.file) };
    }
    real::reject_real_only_keys(&fields, &mut out);
    counter::tallies(&fields, &mut bench, &mut out);
    let wires = parts::wires(fields.each("wires"), &mut bench, &mut out);
    let plants = parts::plants(fields.each("plants"), &mut bench, &mut out);
    bench.file.circuit.buses = sim_buses::read(&fields, &mut out);
    parts::circuit(&bench, &wires, &plants, &mut out);
    if let Some(faults) = fields.inner("faults") {
        bench.file.disturbance = Some(parts::disturbance(&faults, &mut out));
    }
    if out.has_errors() { Err(out.into_vec()) } else { Ok(bench.file) }
}

fn unknown_subject(subject: &Subject, unknown: &UnknownSubject, fields: Option<Fields>, out: &mut Findings) {
    let (key, code, written, known) = match unknown {
        UnknownSubject::Profile { known } => ("profile", codes::PROFILE, subject.profile.as_str(), known),
        UnknownSubject::Reference { known } => {
            ("reference", codes::REFERENCE, subject.reference.as_deref().unwrap_or("the usual"), known)
        }
    };
    let place = fields.and_then(|fields| fields.get(key)).map_or(0..0, |node| node.span.clone());
    let message = match unknown {
        UnknownSubject::Profile { .. } => format!("there is no profile {written}"),
        UnknownSubject::Reference { .. } => format!("{} has no reference {written}", subject.profile),
    };
    let help = match suggest(written, known.iter().map(String::as_str)) {
        Some(meant) => format!("did you mean {meant}?"),
        None => format!("known are {}", known.join(", ")),
    };
    out.error(code, place, message, help);
}
