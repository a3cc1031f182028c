//! One counter with its block.

use scanrig_expert::*;
use signal::{Span, Time, Value};

/// Pulses of 10 us.
pub const PERIOD: i64 = 10_000;

/// An instance of a block.
pub struct Instance {
    block: &'static BlockType,
    pins: Vec<i64>,
}

impl BlockPins for Instance {
    fn get(&self, pin: usize) -> i64 {
        self.pins.get(pin).copied().unwrap_or(0)
    }

    fn set(&mut self, pin: usize, value: i64) {
        self.pins[pin] = value;
    }
}

impl Instance {
    pub fn new(name: &str) -> Instance {
        let block = BLOCKS.iter().copied().flatten().find(|block| block.name == name).unwrap();
        Instance { block, pins: vec![0; block.pins.len()] }
    }

    fn place(&self, name: &str) -> usize {
        self.block.pins.iter().position(|pin| pin.name == name).unwrap_or_else(|| panic!("no pin {name}"))
    }

    /// Sets inputs.
    pub fn with(&mut self, pins: &[(&str, i64)]) -> &mut Instance {
        for (name, value) in pins {
            let place = self.place(name);
            assert_eq!(self.block.pins[place].kind, BlockPinKind::Input, "{name}");
            self.pins[place] = *value;
        }
        self
    }

    pub fn call(&mut self, expert: &mut ExpertFunctions, at: i64) -> &mut Instance {
        let run = self.block.run;
        run(&mut BlockCall { now: Time::from_nanos(at), pins: self, expert });
        self
    }

    pub fn shows(&self, name: &str) -> i64 {
        let place = self.place(name);
        assert_eq!(self.block.pins[place].kind, BlockPinKind::Output, "{name}");
        self.pins[place]
    }
}

/// A controller that runs with one counter, whose block is called where a test says so.
pub struct Rig {
    pub expert: ExpertFunctions,
    pub block: Instance,
    pub now: i64,
    pub effects: Vec<(i64, ExpertEffect)>,
}

impl Rig {
    /// Inputs without delay and filter.
    pub fn new(config: CounterConfig) -> Rig {
        Rig::behind(config, InputConditions::default())
    }

    pub fn behind(config: CounterConfig, conditions: InputConditions) -> Rig {
        assert_eq!(config.faults(), []);
        let name = if config.kind == CounterKind::Simple { "HSCSimple_M241" } else { "HSCMain_M241" };
        let mut block = Instance::new(name);
        block.with(&[("HSC_REF_IN", 1)]);
        let functions = vec![FunctionConfig { name: "HSC0".into(), kind: FunctionKind::Counter(config) }];
        let mut expert = ExpertFunctions::new(&ExpertConfig { functions }, &[conditions; 16]);
        expert.operate(Time::ZERO, ExpertOperation::Running);
        Rig { expert, block, now: 0, effects: Vec::new() }
    }

    /// Calls the block with these inputs changed.
    pub fn call(&mut self, pins: &[(&str, i64)]) -> &mut Rig {
        self.block.with(pins).call(&mut self.expert, self.now);
        self.gather()
    }

    /// The pin rises with one call and falls with the next.
    pub fn press(&mut self, pin: &str) -> &mut Rig {
        self.call(&[(pin, 1)]).call(&[(pin, 0)])
    }

    pub fn shows<const N: usize>(&mut self, names: [&str; N]) -> [i64; N] {
        self.call(&[]);
        names.map(|name| self.block.shows(name))
    }

    pub fn value(&mut self) -> i64 {
        self.shows(["CurrentValue"])[0]
    }

    /// A level at an input, now.
    pub fn level(&mut self, input: usize, high: bool) -> &mut Rig {
        self.expert.edge(Time::from_nanos(self.now), input, high);
        self.gather()
    }

    /// So many pulses; the last one has fallen, and `now` is where the next would rise.
    pub fn pulses(&mut self, input: usize, count: usize) -> &mut Rig {
        for _ in 0..count {
            self.level(input, true).pass(PERIOD / 2).level(input, false).pass(PERIOD / 2);
        }
        self
    }

    /// Time passes.
    pub fn pass(&mut self, nanos: i64) -> &mut Rig {
        self.now += nanos;
        while self.expert.next() <= Time::from_nanos(self.now) {
            let at = self.expert.next();
            self.expert.fire(at);
            self.gather();
        }
        self
    }

    pub fn operate(&mut self, operation: ExpertOperation) -> &mut Rig {
        self.expert.operate(Time::from_nanos(self.now), operation);
        self.gather()
    }

    pub fn gather(&mut self) -> &mut Rig {
        let mut place = 0;
        while let Some((at, effect)) = self.expert.take(place) {
            self.effects.push((at.as_nanos(), effect));
            place += 1;
        }
        self
    }

    pub fn taken(&mut self) -> Vec<(i64, ExpertEffect)> {
        std::mem::take(&mut self.effects)
    }

    pub fn reads(&self, fact: FunctionProbe) -> Value {
        self.expert.read(0, fact)
    }
}

pub fn simple(mode: CounterMode) -> CounterConfig {
    CounterConfig::new(CounterKind::Simple, 0, mode)
}

pub fn single(mode: CounterMode) -> CounterConfig {
    CounterConfig::new(CounterKind::Single, 0, mode)
}

pub fn dual(phases: PhaseMode, mode: CounterMode) -> CounterConfig {
    CounterConfig::new(CounterKind::Dual { b: 1, phases }, 0, mode)
}

pub fn free(preset: i32, limits: LimitsMode) -> CounterMode {
    CounterMode::FreeLarge { preset, limits }
}

pub fn millis(n: i64) -> Span {
    Span::from_millis(n)
}
