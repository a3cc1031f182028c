//! A counter that shows what a test wants it to.

// Each test uses a part of it.
#![allow(dead_code)]

use std::io;
use std::sync::atomic::{AtomicBool, AtomicI32, AtomicU32, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex};

use document::SourceFile;
use host::{CounterEvent, HostInstant, Realtime};
use scanrig_drivers::counter::{Counter, CounterBoard, CounterReading, CounterSource, CountersSpec};
use scanrig_drivers::{BoardContext, BoardFile, BoardKind, Reopen, Terminals, read};

/// What the counter is to do.
#[derive(Debug, Default)]
pub struct Script {
    /// What the count shows.
    pub value: AtomicU64,
    /// The error that calls answer; 0 for none.
    pub error: AtomicI32,
    /// Whether it can be opened again.
    pub there: AtomicBool,
    pub reads: AtomicU32,
    /// Whether the next events find their queue full.
    pub full: AtomicBool,
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
}

#[derive(Debug)]
struct Scripted(Arc<Script>);

impl Counter for Scripted {
    fn device(&self) -> &str {
        "scripted"
    }

    fn ceiling(&self) -> u64 {
        u64::from(u32::MAX)
    }

    fn begin(&mut self) -> io::Result<()> {
        Ok(())
    }

    fn read(&mut self) -> io::Result<CounterReading> {
        let before = HostInstant::now();
        let mut shut = self.0.shut.lock().unwrap();
        while *shut {
            self.0.waiting.store(true, Ordering::Release);
            shut = self.0.opened.wait(shut).unwrap();
        }
        drop(shut);
        self.0.waiting.store(false, Ordering::Release);
        self.0.reads.fetch_add(1, Ordering::AcqRel);
        match self.0.error.load(Ordering::Acquire) {
            0 => Ok(CounterReading {
                before,
                after: HostInstant::now(),
                value: self.0.value.load(Ordering::Acquire),
            }),
            code => Err(io::Error::from_raw_os_error(code)),
        }
    }

    fn events(&mut self, _out: &mut Vec<CounterEvent>) -> io::Result<bool> {
        Ok(!self.0.full.swap(false, Ordering::AcqRel))
    }
}

/// The board file: a channel `shaft` of a counter that is read so often.
pub fn file(unresponsive_after: &str, period: &str, reconnect: bool) -> BoardFile {
    let text = format!(
        "format = 1\n[board]\nkind = \"real\"\nunresponsive-after = \"{unresponsive_after}\"\nreconnect = {reconnect}\n[counters]\n\
         wheel = {{ path = \"/dev/none\", period = \"{period}\" }}\n[channels]\nshaft = {{ kind = \"count\" }}\n",
    );
    read(&SourceFile::new("counter.toml", text), &|_| Ok(Terminals::default()))
        .unwrap_or_else(|found| panic!("{found:#?}"))
}

/// A board of the counter.
pub fn board(file: &BoardFile, script: &Arc<Script>) -> (CounterBoard, BoardContext) {
    let BoardKind::Real(spec) = &file.kind else { panic!("{:?}", file.kind) };
    let counters = spec.of::<CountersSpec>().unwrap();
    let at = BoardContext::new(Realtime::default());
    let reopen = {
        let script = script.clone();
        move || -> Option<Box<dyn Counter>> {
            script.there.load(Ordering::Acquire).then(|| Box::new(Scripted(script.clone())) as _)
        }
    };
    let source = CounterSource {
        counter: Box::new(Scripted(script.clone())),
        channel: counters.counts[0].channel,
        reopen: Reopen::new(reopen),
    };
    (CounterBoard::on(&file.channel_table(), counters, spec.limits, &at, vec![source]).unwrap(), at)
}
