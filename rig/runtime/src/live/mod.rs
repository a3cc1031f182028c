//! A rig that is kept running, for the control socket: orders into the scan, and out of it what happens and how it is.
//!
//! Goals: the scan never waits for whoever looks, takes no memory for them, and pays next to nothing where nobody does.
//! Not a goal: what is sent to whom, which is the socket's (`services::control`).
//!
//! Between the two are queues of a fixed size. What finds no room in them is counted and left out, but for a rig whose
//! time clients lead: its time waits.

mod describe;
mod directory;
mod fault;
mod handle;
mod plan_reading;
mod plans;
mod status;

use crate::case::DEFAULT_LATE;
use crate::case::test_setup::set_up;
use crate::hardware::Hardware;
use crate::scan_port::{PortLimits, ScanPort, Snapshot, queues};
use crate::suite::case_files::CaseFiles;
use ::plans::Case;
use control::{Description, SubjectKind, TimeSource};
use describe::DeviceTable;
use directory::Directory;
use document::Diagnostic;
use drivers::BoardExt;
use handle::{MOST_WATCHED, PlanOrders};
use profile::OVERLOAD_PERCENT;
use status::StatusSource;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

pub use handle::LiveRig;
pub use plans::{PlanBench, PlanSlot, PlanSource, run_with_plans};

/// The two ends of a rig that is about to be kept running: the handle for the socket, the port for the scan; and where plans
/// that a client chose wait for [`run_with_plans`]. Once `interrupt` is set nothing waits for clients any more.
///
/// # Errors
/// Findings in the user's files, and stepped time on real lines.
pub fn open(
    case: &Case,
    files: &CaseFiles,
    hardware: Option<&Hardware>,
    led: bool,
    version: &str,
    plans: Option<PlanBench>,
    interrupt: &'static AtomicBool,
) -> Result<(LiveRig, ScanPort, PlanSlot), Vec<Diagnostic>> {
    let file = &files.board;
    if led && file.is_real() {
        let message = format!("`{}` has real lines: their time cannot be stepped", file.name);
        let found = Diagnostic::error(fault::LED, message).at(&file.name, 0..0, "");
        return Err(vec![found.help("leave `--stepped` out, or take a simulated board")]);
    }
    let mut stage = set_up(case, files, None)?;
    if let Some(hardware) = hardware {
        stage.board = Box::new(hardware.lease());
    }
    let board = &*stage.board;
    let Some(catalogue) = stage.subject.catalogue() else {
        return Err(vec![crate::soft_plc::real_controller(file)]);
    };
    let catalogue = catalogue.of_one_program();
    let devices = DeviceTable::of(board);
    let points = describe::points(&catalogue, file, board, &devices);
    let channels = describe::channels(&points, board);
    let limits = files.profile.address_limits();
    let tasks = describe::tasks(&catalogue, &stage.tasks);
    let functions = describe::functions(&catalogue);
    let modules = describe::modules(&catalogue);
    let directory = Directory::new(catalogue, file, board.channels(), limits);
    let description = Description {
        board: file.name.clone(),
        reference: files.reference.name.into(),
        profile: files.profile.name().into(),
        program: files.sources.iter().map(|source| source.name.clone()).collect(),
        clock: if led { TimeSource::Stepped } else { TimeSource::Real },
        subject: SubjectKind::Model,
        points,
        signals: directory.listed(),
        tasks,
        functions,
        buses: describe::buses(board, file),
        modules,
        devices: devices.list.clone(),
        on_disconnect: String::new(),
        load_limit: u32::try_from(OVERLOAD_PERCENT * 10).unwrap_or_default(),
    };
    let snapshot = Snapshot::new(description.tasks.len(), board.channels().len(), board.bus_list().len());
    let bell = ScanPort::bell(hardware.map(Hardware::surroundings));
    let (inside, outside) = queues(&snapshot);
    let late = hardware.and_then(Hardware::late).unwrap_or(DEFAULT_LATE);
    let room = PortLimits { sources: directory.most(), watches: MOST_WATCHED, led, late, interrupt };
    let slot = PlanSlot::default();
    let port = ScanPort::new(inside, bell.clone(), snapshot.clone(), room);
    let realtime = hardware.is_some_and(Hardware::has_priority);
    let instruments = StatusSource::new(snapshot, devices, channels, hardware.is_some(), realtime);
    let orders = PlanOrders { bench: plans.map(Arc::new), slot: slot.clone() };
    let handle = LiveRig::new(outside, bell, description, version, directory, instruments, orders);
    Ok((handle, port, slot))
}
