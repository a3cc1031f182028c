//! A generator that does what a test wants it to: a stream on `S`, a chip with the outputs of `P0` and `P1`.

// Each test uses a part of it.
#![allow(dead_code)]

use std::io;
use std::sync::atomic::{AtomicBool, AtomicI32, AtomicI64, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex};
use std::time::Duration;

use document::SourceFile;
use host::{HostInstant, Realtime};
use scanrig_drivers::generator::{Generator, GeneratorBoard, GeneratorSource, GeneratorsSpec, SentPulses};
use scanrig_drivers::{BoardContext, BoardFile, BoardKind, OutputClaim, Reopen, Terminals, read};
use signal::Span;

/// What was asked of a generator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Did {
    Rest,
    Level(u8, bool),
    Square(u8, i64, i64),
    /// So many edges, the last one then.
    Pulses(usize, i64),
}

/// What the generators are to do, and did.
#[derive(Debug, Default)]
pub struct Script {
    did: Mutex<Vec<Did>>,
    /// Only so much is remembered; 0 for everything.
    room: AtomicUsize,
    /// The error that calls answer; 0 for none.
    pub error: AtomicI32,
    /// Whether they can be opened again.
    pub there: AtomicBool,
    /// How much longer than it does a call says that it lasts, in ns.
    pub says: AtomicI64,
    shut: Mutex<bool>,
    opened: Condvar,
    /// A call waits for the gate.
    pub waiting: AtomicBool,
}

impl Script {
    /// From now on calls hang, or no longer.
    pub fn shut(&self, shut: bool) {
        *self.shut.lock().unwrap() = shut;
        self.opened.notify_all();
    }

    /// What was done, but for looks.
    pub fn did(&self) -> Vec<Did> {
        self.did.lock().unwrap().clone()
    }

    /// Forgets what was done, and remembers only so much more.
    pub fn forget(&self, room: usize) {
        self.room.store(room, Ordering::Release);
        let mut did = self.did.lock().unwrap();
        did.clear();
        did.reserve(room);
    }

    fn call(&self, did: Option<Did>) -> io::Result<()> {
        let mut shut = self.shut.lock().unwrap();
        while *shut {
            self.waiting.store(true, Ordering::Release);
            shut = self.opened.wait(shut).unwrap();
        }
        drop(shut);
        self.waiting.store(false, Ordering::Release);
        match self.error.load(Ordering::Acquire) {
            0 => {}
            code => return Err(io::Error::from_raw_os_error(code)),
        }
        let mut all = self.did.lock().unwrap();
        let room = self.room.load(Ordering::Acquire);
        if room == 0 || all.len() < room {
            all.extend(did);
        }
        Ok(())
    }
}

#[derive(Debug)]
struct Scripted(Arc<Script>);

impl Generator for Scripted {
    fn device(&self) -> &str {
        "scripted"
    }

    fn rest(&mut self) -> io::Result<()> {
        self.0.call(Some(Did::Rest))
    }

    fn level(&mut self, output: u8, high: bool) -> io::Result<()> {
        self.0.call(Some(Did::Level(output, high)))
    }

    fn square(&mut self, output: u8, period: Span, high: Span) -> io::Result<()> {
        self.0.call(Some(Did::Square(output, period.as_nanos(), high.as_nanos())))
    }

    fn pulses(&mut self, _output: u8, edges: &[Span]) -> io::Result<SentPulses> {
        let before = HostInstant::now();
        let last = edges.last().map_or(0, |edge| edge.as_nanos());
        self.0.call(Some(Did::Pulses(edges.len(), last)))?;
        // A clock of 1 MHz, eight bits in front, whole bytes.
        let bits = ((8 + last as u64 / 1_000) / 8 + 1) * 8;
        let over = before + Span::from_micros(bits as i64);
        while HostInstant::now() < over {
            std::thread::sleep(Duration::from_micros(50));
        }
        Ok(SentPulses { before, after: HostInstant::now(), bits })
    }

    fn lasts(&self, _edges: &[Span]) -> Span {
        Span::from_nanos(self.0.says.load(Ordering::Acquire))
    }

    fn look(&mut self) -> io::Result<()> {
        self.0.call(None)
    }

    fn output_claims(&self) -> io::Result<Vec<OutputClaim>> {
        Ok(Vec::new())
    }
}

/// The board file.
pub fn file(unresponsive_after: &str, reconnect: bool) -> BoardFile {
    let text = format!(
        "format = 1\n[board]\nkind = \"real\"\nunresponsive-after = \"{unresponsive_after}\"\nreconnect = {reconnect}\n[generators]\n\
         stream = {{ kind = \"spi\", path = \"/dev/none\" }}\nchip = {{ kind = \"pwm\", name = \"none\" }}\n[channels]\n\
         S = {{ kind = \"digital\", generator = \"stream\" }}\nP0 = {{ kind = \"digital\", generator = \"chip\" }}\n\
         P1 = {{ kind = \"digital\", generator = \"chip\", output = 1, safe = true }}\n",
    );
    read(&SourceFile::new("emit.toml", text), &|_| Ok(Terminals::default()))
        .unwrap_or_else(|found| panic!("{found:#?}"))
}

/// A board of both generators, the stream by the first script, the chip by the second.
pub fn board(file: &BoardFile, scripts: [&Arc<Script>; 2]) -> (GeneratorBoard, BoardContext) {
    let BoardKind::Real(spec) = &file.kind else { panic!("{:?}", file.kind) };
    let generators = spec.of::<GeneratorsSpec>().unwrap();
    let at = BoardContext::new(Realtime::default());
    let source = |(place, script): (usize, &Arc<Script>)| {
        let of = script.clone();
        let scripted = move || -> Box<dyn Generator> { Box::new(Scripted(of.clone())) };
        let (first, script) = (scripted.clone(), script.clone());
        GeneratorSource {
            generator: first(),
            kind: generators.generators[place].kind.clone(),
            outputs: generators.outputs_of(place),
            reopen: Reopen::new(move || script.there.load(Ordering::Acquire).then(&scripted)),
        }
    };
    let sources = scripts.into_iter().enumerate().map(source).collect();
    (GeneratorBoard::on(&file.channel_table(), generators, spec.limits, &at, sources).unwrap(), at)
}
