//! Real lines: a board that is opened once and lent to one case after the other, and what the machine gives a run to
//! be on time.

pub mod bench_lock;

use crate::codes;
use crate::executor::clock::HostClock;
use crate::executor::heartbeat::Heartbeat;
use crate::hardware::bench_lock::BenchLock;
use crate::instrument::figures::{self, MachineFigures};
use crate::instrument::{self, Instrument, LoopFault};
use document::Diagnostic;
use drivers::gpio::GpioSpec;
use drivers::real::OfflineBoard;
use drivers::{
    Board, BoardContext, BoardError, BoardEvent, BoardFile, BoardKind, Channel, ChannelId, Health,
    LoopbackPair, RealtimeSettings,
};
use guard::{Guard, GuardError, GuardHandle, MissingPrivileges};
use host::{Entered, Privilege, Punctual, Refused, ThreadRole};
use signal::{Span, Time, Value};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError, Weak};

/// A board with real lines, for as long as a run lasts. Between cases its lines stay claimed, and safe.
#[derive(Debug)]
pub struct Hardware {
    place: Arc<BoardSlot>,
    /// Name of the board file.
    name: String,
    surroundings: BoardContext,
    settings: RealtimeSettings,
    punctual: Punctual,
    refused: Vec<Refused>,
    heartbeat: Option<Arc<dyn Heartbeat + Send>>,
    /// What was measured of this machine and these devices.
    standing: MachineFigures,
    /// What the guard could not get for itself.
    lacks: Option<MissingPrivileges>,
    /// Keeps other users off, until the lines were made safe.
    lock: Option<BenchLock>,
}

/// Real lines where none were opened.
pub fn in_virtual_time(board: &BoardFile) -> Diagnostic {
    let message = format!("`{}` has real lines, which have no virtual time", board.name);
    Diagnostic::error(codes::REAL_LINES_IN_VIRTUAL_TIME, message)
        .at(&board.name, 0..0, "")
        .help("run its cases by `rig test`, without `--clock virtual`")
}

/// Where the board is while no case has it.
#[derive(Debug)]
struct BoardSlot {
    board: Mutex<Option<Box<dyn Board>>>,
    back: Condvar,
}

impl BoardSlot {
    fn lock(&self) -> MutexGuard<'_, Option<Box<dyn Board>>> {
        // A panic elsewhere does not make the board another one.
        self.board.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Hardware {
    /// Takes a board that lives in these surroundings. `name` is that of its file. The process asks for what makes it
    /// punctual, for as long as this lives.
    pub fn new(
        name: &str,
        board: Box<dyn Board>,
        surroundings: BoardContext,
        settings: RealtimeSettings,
    ) -> Hardware {
        let punctual = Punctual::begin();
        let mut refused = settings.threads().refused(ThreadRole::Edges);
        refused.extend(&punctual.refused);
        Hardware {
            place: Arc::new(BoardSlot { board: Mutex::new(Some(board)), back: Condvar::new() }),
            name: name.to_owned(),
            surroundings,
            settings,
            punctual,
            refused,
            heartbeat: None,
            standing: MachineFigures::default(),
            lacks: None,
            lock: None,
        }
    }

    /// Starts the guard, opens the board of a file under its eyes, and takes what makes the process punctual. `None`
    /// where the file's board is a simulated one.
    ///
    /// # Errors
    /// What keeps the board from being opened, at its place in the file, or from being guarded.
    pub fn open(file: &BoardFile) -> Result<Option<Hardware>, Vec<Diagnostic>> {
        if !file.is_real() {
            return Ok(None);
        }
        let refused = |error: GuardError| {
            let of_watchdog = matches!(error, GuardError::Watchdog { .. } | GuardError::NeverStops { .. });
            let watchdog = file.guard.watchdog.as_ref().filter(|_| of_watchdog);
            let place = watchdog.map_or(0..0, |watchdog| watchdog.place.clone());
            let found = Diagnostic::error(error.code(), error.to_string());
            vec![found.at(&file.name, place, "").help(error.help())]
        };
        // First of all: there are no threads yet, and no memory is locked.
        let guard = Arc::new(Guard::spawn(&file.guard).map_err(refused)?);
        let mut standing = figures::standing(file);
        for calibrated in file.calibrated(drivers::adc::today()) {
            standing.facts.push((format!("Channel {}", calibrated.channel), calibrated.words));
            standing.warnings.extend(calibrated.expired);
        }
        let mut surroundings = BoardContext::new(file.realtime.threads());
        surroundings.resolution = standing.resolution;
        let output_guard: Weak<GuardHandle> = Arc::downgrade(&guard);
        surroundings.output_guard = Some(output_guard);
        let opened = drivers::file::open(file, &surroundings).or_else(|found| {
            // The guard of a run that died may still hold the lines safe for it.
            if took_over(file, &found) { drivers::file::open(file, &surroundings) } else { Err(found) }
        });
        let Some(board) = opened? else { return Ok(None) };
        let held = board
            .output_claims()
            .map_err(|error| GuardError::Lines { device: file.name.clone(), why: error.to_string() });
        held.and_then(|held| guard.hold(held)).map_err(refused)?;
        let lacks = guard.lacks();
        let mut hardware = Hardware::new(&file.name, board, surroundings, file.realtime);
        (hardware.lacks, hardware.standing) = (Some(lacks), standing);
        Ok(Some(hardware.with_heartbeat(guard)))
    }

    /// The same, and every turn of the executor is shown to this.
    #[must_use]
    pub fn with_heartbeat(mut self, heartbeat: Arc<dyn Heartbeat + Send>) -> Hardware {
        self.heartbeat = Some(heartbeat);
        self
    }

    /// The same, with the lock that keeps other users off its lines.
    #[must_use]
    pub fn with_lock(mut self, lock: Option<BenchLock>) -> Hardware {
        self.lock = lock;
        self
    }

    /// Name of the board file.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The time, the bell and the priorities of the board.
    pub fn surroundings(&self) -> &BoardContext {
        &self.surroundings
    }

    /// How punctual the board file wants it.
    pub fn settings(&self) -> &RealtimeSettings {
        &self.settings
    }

    /// The clock of the board's time, which its bell wakes.
    pub fn clock(&self) -> HostClock {
        HostClock::of(&self.surroundings)
    }

    /// Who is shown every turn of the executor.
    pub fn heartbeat(&self) -> Option<&dyn Heartbeat> {
        self.heartbeat.as_deref().map(|heartbeat| heartbeat as &dyn Heartbeat)
    }

    /// The board, which comes back when what is lent is dropped. Waits while somebody else has it.
    pub fn lease(&self) -> BoardLease {
        let mut place = self.place.lock();
        loop {
            if let Some(board) = place.take() {
                return BoardLease { board, place: self.place.clone() };
            }
            place = self.place.back.wait(place).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// What was measured of this machine and these devices.
    pub fn standing(&self) -> &MachineFigures {
        &self.standing
    }

    /// The board, lent, as something that is measured.
    pub fn instrument<'a>(&'a self, lent: &'a mut BoardLease) -> Instrument<'a> {
        Instrument { board: lent, lives: &self.surroundings, heartbeat: self.heartbeat() }
    }

    /// Drives a known square wave through the loop that the board file names, if it names one, and compares what comes
    /// back: an instrument that does not see what it does itself judges nothing.
    ///
    /// # Errors
    /// Why the board is no instrument, as a finding to be shown; nothing of it where the user interrupted.
    pub fn check(
        &mut self,
        looped: Option<LoopbackPair>,
        interrupt: &AtomicBool,
    ) -> Result<(), Option<Diagnostic>> {
        let Some(looped) = looped else { return Ok(()) };
        let mut board = self.lease();
        let names = instrument::names(&board, looped);
        let entered = self.enter();
        let found = instrument::square(self.instrument(&mut board), looped, interrupt);
        drop(entered);
        match found {
            Ok(found) => {
                self.standing.facts.push((String::from("Instrument checked"), found.to_string()));
                Ok(())
            }
            Err(LoopFault::Interrupted) => Err(None),
            Err(fault) => Err(Some(fault.finding(&names))),
        }
    }

    /// The calling thread becomes one that runs the scan loop, until what comes back is dropped.
    pub fn enter(&self) -> Entered {
        self.settings.threads().enter_for_now(ThreadRole::Scan)
    }

    /// What the kernel refuses the run, each with its fix: warnings, to be shown once.
    pub fn warnings(&self) -> Vec<Diagnostic> {
        let warning = |refused: &Refused| {
            let code = match refused.what {
                Privilege::Priority => codes::NO_PRIORITY,
                Privilege::Processors => codes::NO_PROCESSORS,
                Privilege::Memory => codes::MEMORY_NOT_LOCKED,
                Privilege::Awake => codes::PROCESSORS_SLEEP,
            };
            Diagnostic::warning(code, refused.to_string()).help(refused.fix())
        };
        self.refused.iter().map(warning).chain(self.standing.warnings.iter().cloned()).collect()
    }

    /// How punctual the run can be, for its record: name and text.
    pub fn facts(&self) -> Vec<(String, String)> {
        let fact = |what: Privilege| {
            let text = match self.refused.iter().find(|refused| refused.what == what) {
                Some(refused) => format!("refused: {}", std::io::Error::from(refused.error)),
                None => match what {
                    Privilege::Priority => match self.settings.priority {
                        Some(priority) => priority.to_string(),
                        None => String::from("none"),
                    },
                    Privilege::Processors => self.settings.processors.to_string(),
                    Privilege::Memory | Privilege::Awake => String::from("yes"),
                },
            };
            (what.name().to_owned(), text)
        };
        let mut facts: Vec<_> = Privilege::ALL.into_iter().map(fact).collect();
        if let Some(lacks) = self.lacks {
            facts.push((String::from("Guard"), guarded(lacks)));
        }
        facts.extend(self.standing.facts.iter().cloned());
        facts
    }

    /// Whether the threads of the run have real-time priority.
    pub fn has_priority(&self) -> bool {
        let refused = self.refused.iter().any(|refused| refused.what == Privilege::Priority);
        self.settings.priority.is_some() && !refused
    }

    /// Whether the memory of the process stays in place.
    pub fn is_locked(&self) -> bool {
        self.punctual.is_locked()
    }

    /// How late the rig may be, where the board file says it.
    pub fn late(&self) -> Option<Span> {
        self.settings.late
    }
}

/// The code of a line that somebody holds.
const BUSY: &str = "B0174";

/// Whether a guard that outlived its rig let go of lines that were found to be held.
fn took_over(file: &BoardFile, found: &[Diagnostic]) -> bool {
    let BoardKind::Real(spec) = &file.kind else { return false };
    let busy = found.iter().any(|found| found.code == BUSY);
    let Some(gpio) = spec.of::<GpioSpec>().filter(|_| busy) else { return false };
    drivers::gpio::devices(gpio).iter().map(|device| guard::take_over(device)).sum::<usize>() > 0
}

/// How far the guard can do what it is for, in words.
fn guarded(lacks: MissingPrivileges) -> String {
    let without = [
        (lacks.priority, "real-time priority"),
        (lacks.memory, "locked memory"),
        (lacks.sparing, "being spared when memory runs out"),
    ];
    let without: Vec<&str> = without.into_iter().filter(|(lacks, _)| *lacks).map(|(_, what)| what).collect();
    if without.is_empty() { String::from("yes") } else { format!("without {}", without.join(", ")) }
}

impl Drop for Hardware {
    fn drop(&mut self) {
        let board = self.place.lock().take();
        if let Some(mut board) = board {
            // Lines that cannot be reached any more are the guard's.
            let _ = board.safe(self.surroundings.time.now());
            // It looks at the outputs once more, and a PWM output that was given back is not there to be looked at. In a
            // panic it sees this process die.
            if let Some(heartbeat) = self.heartbeat.as_ref().filter(|_| !std::thread::panicking()) {
                let _ = heartbeat.close();
            }
        }
    }
}

/// A board on loan.
#[derive(Debug)]
pub struct BoardLease {
    board: Box<dyn Board>,
    place: Arc<BoardSlot>,
}

impl Drop for BoardLease {
    fn drop(&mut self) {
        let nothing = Box::new(OfflineBoard::default());
        *self.place.lock() = Some(std::mem::replace(&mut self.board, nothing));
        self.place.back.notify_one();
    }
}

impl Board for BoardLease {
    fn inner(&self) -> Option<&dyn Board> {
        Some(&*self.board)
    }

    fn inner_mut(&mut self) -> Option<&mut dyn Board> {
        Some(&mut *self.board)
    }

    fn channels(&self) -> &[Channel] {
        self.board.channels()
    }

    fn start(&mut self, now: Time) -> Result<(), BoardError> {
        self.board.start(now)
    }

    fn write(&mut self, now: Time, writes: &[(ChannelId, Value)]) -> Result<(), BoardError> {
        self.board.write(now, writes)
    }

    fn poll(&mut self, now: Time, out: &mut Vec<BoardEvent>) -> Result<(), BoardError> {
        self.board.poll(now, out)
    }

    fn next_event(&self) -> Option<Time> {
        self.board.next_event()
    }

    fn safe(&mut self, now: Time) -> Result<(), BoardError> {
        self.board.safe(now)
    }

    fn health(&self) -> Health {
        self.board.health()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use drivers::SimulatedBoard;
    use drivers::circuit::Circuit;
    use host::Realtime;

    fn hardware() -> Hardware {
        let board = SimulatedBoard::new(&Circuit::default(), 1).unwrap();
        let settings = RealtimeSettings { priority: None, ..RealtimeSettings::default() };
        Hardware::new("bench.toml", Box::new(board), BoardContext::new(Realtime::default()), settings)
    }

    #[test]
    fn whoever_wants_the_board_waits_until_it_is_back() {
        let hardware = hardware();
        let lent = hardware.lease();
        std::thread::scope(|scope| {
            let next = scope.spawn(|| drop(hardware.lease()));
            drop(lent);
            next.join().unwrap();
        });
        assert!(hardware.place.lock().is_some());
    }

    #[test]
    fn the_record_says_what_was_refused_and_a_warning_says_why() {
        let mut hardware = hardware();
        hardware.refused = vec![Refused { what: Privilege::Memory, error: host::Errno::PERM }];
        let facts = hardware.facts();
        assert_eq!(facts[0], ("Real-time priority".to_owned(), "none".to_owned()));
        assert!(facts[2].1.starts_with("refused:"), "{facts:?}");
        let warnings = hardware.warnings();
        assert!(warnings[0].code == "R0183" && !warnings[0].is_error());
    }
}
