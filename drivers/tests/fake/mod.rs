//! A chip without a kernel behind it: sixteen outputs, sixteen inputs, and a test that moves them.

// Each test uses a part of it.
#![allow(dead_code)]

use std::collections::VecDeque;
use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicI32, AtomicU32, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex};

use document::SourceFile;
use host::{HostInstant, Realtime};
use rustix::event::{EventfdFlags, eventfd};
use scanrig_drivers::gpio::{
    Backend, ChipInfo, Claim, Edge, FoundChip, GpioPort, GpioSpec, LineLevels, Wanted,
};
use scanrig_drivers::{
    BoardContext, BoardFile, BoardKind, ChannelId, DeviceLimits, GpioBoard, OutputClaim, Terminals, read,
};

/// Lines of each direction.
pub const LINES: usize = 16;

#[derive(Debug)]
pub struct Fake {
    /// What the outputs were set to last.
    pub outputs: AtomicU64,
    /// What the inputs read.
    pub inputs: AtomicU64,
    pub sets: AtomicU32,
    pub gets: AtomicU32,
    /// The error that calls answer; 0 for none.
    pub error: AtomicI32,
    edges: Mutex<VecDeque<Edge>>,
    ready: OwnedFd,
    shut: Mutex<bool>,
    opened: Condvar,
    /// A call that sets waits for the gate.
    pub waiting: AtomicBool,
    numbers: AtomicU32,
}

impl Fake {
    pub fn new() -> Arc<Fake> {
        Arc::new(Fake {
            outputs: AtomicU64::new(0),
            inputs: AtomicU64::new(0),
            sets: AtomicU32::new(0),
            gets: AtomicU32::new(0),
            error: AtomicI32::new(0),
            edges: Mutex::new(VecDeque::with_capacity(1 << 16)),
            ready: eventfd(0, EventfdFlags::NONBLOCK | EventfdFlags::CLOEXEC).unwrap(),
            shut: Mutex::new(false),
            opened: Condvar::new(),
            waiting: AtomicBool::new(false),
            numbers: AtomicU32::new(0),
        })
    }

    /// From now on calls that set hang, or no longer.
    pub fn shut(&self, shut: bool) {
        *self.shut.lock().unwrap() = shut;
        self.opened.notify_all();
    }

    /// An edge of input 0, as the kernel would report it, and its level.
    pub fn edge(&self, high: bool, stamp: HostInstant) {
        let number = self.numbers.fetch_add(1, Ordering::AcqRel) + 1;
        self.level(high);
        self.tell(Edge { input: 0, high, stamp, numbers: Some((number, number)) });
    }

    /// The level of input 0, which no edge reports.
    pub fn level(&self, high: bool) {
        if high {
            self.inputs.fetch_or(1, Ordering::AcqRel);
        } else {
            self.inputs.fetch_and(!1, Ordering::AcqRel);
        }
    }

    pub fn tell(&self, edge: Edge) {
        self.edges.lock().unwrap().push_back(edge);
        rustix::io::write(&self.ready, &1u64.to_ne_bytes()).unwrap();
    }

    /// Whether no edge waits in the kernel any more.
    pub fn is_drained(&self) -> bool {
        self.edges.lock().unwrap().is_empty()
    }

    fn answer(&self) -> io::Result<()> {
        match self.error.load(Ordering::Acquire) {
            0 => Ok(()),
            code => Err(io::Error::from_raw_os_error(code)),
        }
    }
}

impl GpioPort for Fake {
    fn backend(&self) -> Backend {
        Backend::V2
    }

    fn set(&self, bits: u64) -> io::Result<()> {
        let mut shut = self.shut.lock().unwrap();
        while *shut {
            self.waiting.store(true, Ordering::Release);
            shut = self.opened.wait(shut).unwrap();
        }
        self.waiting.store(false, Ordering::Release);
        self.answer()?;
        self.sets.fetch_add(1, Ordering::AcqRel);
        self.outputs.store(bits, Ordering::Release);
        Ok(())
    }

    fn get(&self) -> io::Result<LineLevels> {
        self.answer()?;
        self.gets.fetch_add(1, Ordering::AcqRel);
        Ok(LineLevels { bits: self.inputs.load(Ordering::Acquire), known: (1 << LINES) - 1 })
    }

    fn survey(&self) -> io::Result<LineLevels> {
        self.get()
    }

    fn source(&self, number: usize) -> Option<BorrowedFd<'_>> {
        (number == 0).then(|| self.ready.as_fd())
    }

    fn edges(&self, _source: usize, out: &mut Vec<Edge>) -> io::Result<()> {
        self.answer()?;
        let mut edges = self.edges.lock().unwrap();
        while out.len() < out.capacity() {
            let Some(edge) = edges.pop_front() else { break };
            out.push(edge);
        }
        if edges.is_empty() {
            // Nothing to be read is no failure.
            let _ = rustix::io::read(&self.ready, &mut [0u8; 8]);
        }
        Ok(())
    }

    fn output_claims(&self, _device: &str) -> io::Result<Vec<OutputClaim>> {
        Ok(Vec::new())
    }
}

/// Outputs that carry pulses up to 1 kHz.
pub const PULSED: [usize; 2] = [12, 13];

/// The board file of the chip: outputs `o0` ..., inputs `i0` ..., a chip that is lost after so long.
pub fn file(unresponsive_after: &str) -> BoardFile {
    let mut text = format!(
        "format = 1\n[board]\nkind = \"real\"\nunresponsive-after = \"{unresponsive_after}\"\n[chips]\nmain = {{ label = \"fake\" }}\n\
         [channels]\n",
    );
    for line in 0..LINES {
        text += &format!("i{line} = {{ kind = \"digital\", line = {line} }}\n");
        let pulses = if PULSED.contains(&line) { ", pulses-up-to = \"1 kHz\"" } else { "" };
        let number = LINES + line;
        text += &format!("o{line} = {{ kind = \"digital\", line = {number}, drives = true{pulses} }}\n");
    }
    read(&SourceFile::new("fake.toml", text), &|_| Ok(Terminals::default())).unwrap()
}

/// A board of the chip.
pub fn board(port: Arc<dyn GpioPort>, unresponsive_after: &str) -> (GpioBoard, BoardContext) {
    let (file, found, at) = parts(unresponsive_after);
    (GpioBoard::on_port(&file.channel_table(), spec(&file), limits(&file), &at, found, port).unwrap(), at)
}

/// How patient the board file is.
pub fn limits(file: &BoardFile) -> DeviceLimits {
    let BoardKind::Real(spec) = &file.kind else { panic!("{:?}", file.kind) };
    spec.limits
}

/// What the board file says of lines.
pub fn spec(file: &BoardFile) -> &GpioSpec {
    let BoardKind::Real(spec) = &file.kind else { panic!("{:?}", file.kind) };
    spec.of().unwrap()
}

/// What a board of the chip is made of.
pub fn parts(unresponsive_after: &str) -> (BoardFile, FoundChip, BoardContext) {
    let file = file(unresponsive_after);
    let line = |number| Wanted {
        number,
        bias: None,
        active_low: false,
        drive: Default::default(),
        debounce_us: 0,
        safe: false,
    };
    let of = |letter: &str| -> Vec<ChannelId> {
        (0..LINES).map(|line| file.find(&format!("{letter}{line}")).unwrap()).collect()
    };
    let lines = LINES as u32;
    let found = FoundChip {
        spec: 0,
        info: ChipInfo {
            path: PathBuf::from("/dev/null"),
            name: "fake".into(),
            label: "fake".into(),
            backend: Backend::V2,
            lines: Vec::new(),
        },
        backend: Backend::V2,
        claim: Claim {
            outputs: (lines..2 * lines).map(line).collect(),
            inputs: (0..lines).map(line).collect(),
        },
        drives: of("o"),
        senses: of("i"),
    };
    (file, found, BoardContext::new(Realtime::default()))
}
