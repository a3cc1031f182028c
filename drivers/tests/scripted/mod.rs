//! A converter that shows what a test wants it to.

// Each test uses a part of it.
#![allow(dead_code)]

use std::io;
use std::sync::atomic::{AtomicBool, AtomicI32, AtomicU32, Ordering};
use std::sync::{Arc, Condvar, Mutex};

use document::SourceFile;
use host::{HostInstant, Realtime};
use scanrig_drivers::adc::{Adc, AdcBoard, AdcPace, AdcReading, AdcSource, AdcsSpec, InRange};
use scanrig_drivers::real::RealSpec;
use scanrig_drivers::{BoardContext, BoardFile, BoardKind, Reopen, Terminals, read};
use signal::Span;

/// Inputs of the converter.
pub const INPUTS: usize = 4;

/// What the converter is to do.
#[derive(Debug, Default)]
pub struct Script {
    values: Mutex<[(f64, Option<InRange>); INPUTS]>,
    /// The error that calls answer; 0 for none.
    pub error: AtomicI32,
    /// Whether it can be opened again.
    pub there: AtomicBool,
    pub reads: AtomicU32,
    shut: Mutex<bool>,
    opened: Condvar,
    /// A call waits for the gate.
    pub waiting: AtomicBool,
}

impl Script {
    /// An input shows this from now on.
    pub fn show(&self, input: usize, value: f64) {
        self.values.lock().unwrap()[input] = (value, None);
    }

    /// An input is at an end of its range.
    pub fn clip(&self, input: usize, range: InRange) {
        self.values.lock().unwrap()[input].1 = Some(range);
    }

    /// From now on calls hang, or no longer.
    pub fn shut(&self, shut: bool) {
        *self.shut.lock().unwrap() = shut;
        self.opened.notify_all();
    }
}

#[derive(Debug)]
pub struct Scripted {
    script: Arc<Script>,
    period: Span,
}

impl Adc for Scripted {
    fn device(&self) -> &str {
        "scripted"
    }

    fn kind(&self) -> &'static str {
        "spi"
    }

    fn pace(&self) -> AdcPace<'_> {
        AdcPace::Asked(self.period)
    }

    fn read(&mut self, out: &mut Vec<AdcReading>) -> io::Result<()> {
        let before = HostInstant::now();
        let mut shut = self.script.shut.lock().unwrap();
        while *shut {
            self.script.waiting.store(true, Ordering::Release);
            shut = self.script.opened.wait(shut).unwrap();
        }
        drop(shut);
        self.script.waiting.store(false, Ordering::Release);
        self.script.reads.fetch_add(1, Ordering::AcqRel);
        match self.script.error.load(Ordering::Acquire) {
            0 => {}
            code => return Err(io::Error::from_raw_os_error(code)),
        }
        for (input, (value, range)) in self.script.values.lock().unwrap().iter().enumerate() {
            let range = range.unwrap_or(InRange::Yes);
            out.push(AdcReading {
                input: input as u16,
                before,
                after: HostInstant::now(),
                value: *value,
                range,
            });
        }
        Ok(())
    }
}

/// The board file: channels `a0` ... of the converter's inputs, read so often, and what else is said of `a1`.
pub fn file(unresponsive_after: &str, period: &str, reconnect: bool, more: &str) -> BoardFile {
    let mut text = format!(
        "format = 1\n[board]\nkind = \"real\"\nunresponsive-after = \"{unresponsive_after}\"\nreconnect = {reconnect}\n[converters]\n\
         adc = {{ kind = \"spi\", path = \"/dev/none\", part = \"ads8684\", period = \"{period}\", speed = \"17 MHz\" }}\n\
         [channels]\n",
    );
    for input in 0..INPUTS {
        let more = if input == 1 { more } else { "" };
        text += &format!("a{input} = {{ kind = \"analog\", unit = \"V\", input = {input}{more} }}\n");
    }
    read(&SourceFile::new("adc.toml", text), &|_| Ok(Terminals::default()))
        .unwrap_or_else(|found| panic!("{found:#?}"))
}

/// What the file says of devices.
pub fn spec(file: &BoardFile) -> &RealSpec {
    let BoardKind::Real(spec) = &file.kind else { panic!("{:?}", file.kind) };
    spec
}

/// A board of the converter.
pub fn board(file: &BoardFile, script: &Arc<Script>) -> (AdcBoard, BoardContext) {
    let (spec, at) = (spec(file), BoardContext::new(Realtime::default()));
    let adcs = spec.of::<AdcsSpec>().unwrap();
    let period = adcs.converters[0].period;
    let scripted = {
        let script = script.clone();
        move || -> Box<dyn Adc> { Box::new(Scripted { script: script.clone(), period }) }
    };
    let reopen = {
        let (script, scripted) = (script.clone(), scripted.clone());
        Reopen::new(move || script.there.load(Ordering::Acquire).then(&scripted))
    };
    let source = AdcSource { converter: scripted(), inputs: adcs.samples.clone(), period, reopen };
    (AdcBoard::on(&file.channel_table(), adcs, spec.limits, &at, vec![source]).unwrap(), at)
}
