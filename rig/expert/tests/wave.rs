//! Pulse width modulation and frequency generators through their blocks.

use proptest::prelude::*;
use scanrig_expert::{
    BLOCKS, BlockCall, BlockPins, BlockType, ExpertConfig, ExpertEffect, ExpertFunctions, ExpertOperation,
    FunctionConfig, FunctionKind, FunctionProbe, InputConditions, WaveConfig,
};
use signal::{Span, Time, Value};

/// The pins of one instance.
struct Instance {
    block: &'static BlockType,
    pins: Vec<i64>,
}

impl BlockPins for Instance {
    fn get(&self, pin: usize) -> i64 {
        self.pins.get(pin).copied().unwrap_or_default()
    }

    fn set(&mut self, pin: usize, value: i64) {
        self.pins[pin] = value;
    }
}

impl Instance {
    fn new(name: &str) -> Instance {
        let block = BLOCKS.iter().copied().flatten().find(|block| block.name == name).unwrap();
        Instance { block, pins: vec![0; block.pins.len()] }
    }

    fn place(&self, name: &str) -> usize {
        self.block.pins.iter().position(|pin| pin.name == name).unwrap()
    }

    fn with(&mut self, pins: &[(&str, i64)]) -> &mut Instance {
        for (name, value) in pins {
            let place = self.place(name);
            self.pins[place] = *value;
        }
        self
    }

    fn call(&mut self, expert: &mut ExpertFunctions, at: i64) {
        let run = self.block.run;
        run(&mut BlockCall { now: Time::from_nanos(at), pins: self, expert });
    }

    /// InFrequency, Busy, Error, ErrorID.
    fn shows(&self) -> [i64; 4] {
        ["InFrequency", "Busy", "Error", "ErrorID"].map(|name| self.pins[self.place(name)])
    }
}

/// A rig of functions whose effects are gathered.
struct Rig {
    expert: ExpertFunctions,
    edges: Vec<(i64, u8, bool)>,
}

impl Rig {
    fn new(kinds: impl IntoIterator<Item = FunctionKind>) -> Rig {
        let functions = (0..)
            .zip(kinds)
            .map(|(place, kind)| FunctionConfig { name: format!("F{place}"), kind })
            .collect();
        let mut expert = ExpertFunctions::new(&ExpertConfig { functions }, &[InputConditions::default(); 8]);
        expert.operate(Time::ZERO, ExpertOperation::Running);
        Rig { expert, edges: Vec::new() }
    }

    fn to(&mut self, at: i64) -> &mut Rig {
        self.expert.fire(Time::from_nanos(at));
        self.gather();
        self
    }

    fn gather(&mut self) {
        let mut place = 0;
        while let Some((at, effect)) = self.expert.take(place) {
            let ExpertEffect::Output { output, on } = effect else { panic!("{effect:?}") };
            self.edges.push((at.as_nanos(), output, on));
            place += 1;
        }
    }

    /// Rising and falling edges so far.
    fn edges(&mut self) -> Vec<(i64, bool)> {
        self.gather();
        self.edges.drain(..).map(|(at, _, on)| (at, on)).collect()
    }

    fn fact(&self, fact: FunctionProbe) -> Value {
        self.expert.read(0, fact)
    }
}

fn pwm(output: u8) -> FunctionKind {
    FunctionKind::Pwm(WaveConfig { enable: Some(0), sync: Some(1), ..WaveConfig::new(output) })
}

fn generator(output: u8) -> FunctionKind {
    FunctionKind::Generator(WaveConfig::new(output))
}

const US: i64 = 1_000;
const MS: i64 = 1_000_000;

/// A PWM of 1 kHz and 25 % that began at 0.
fn kilohertz() -> (Rig, Instance) {
    let mut rig = Rig::new([pwm(0)]);
    let mut block = Instance::new("PWM_M241");
    block
        .with(&[("PWM_REF_IN", 1), ("Enable", 1), ("Frequency", 10_000), ("Duty", 25)])
        .call(&mut rig.expert, 0);
    (rig, block)
}

// io:STD-PWM-01, vendor-help:VH-PWM-03
#[test]
fn a_wave_has_its_frequency_and_duty() {
    let (mut rig, block) = kilohertz();
    assert_eq!(block.shows(), [1, 0, 0, 0]);
    let expected: Vec<_> = (0..3).flat_map(|k| [(k * MS, true), (k * MS + 250 * US, false)]).collect();
    assert_eq!(rig.to(3 * MS - 1).edges(), expected);
    assert_eq!(
        (rig.fact(FunctionProbe::Frequency), rig.fact(FunctionProbe::Duty)),
        (Value::Int(10_000), Value::Int(250))
    );
    assert_eq!(rig.fact(FunctionProbe::Pulses), Value::Word(3));
}

// io:STD-FG-01, io:STD-FG-02
#[test]
fn periods_are_exact_on_average() {
    let mut rig = Rig::new([generator(1)]);
    let mut block = Instance::new("FrequencyGenerator_M241");
    // 69999.7 Hz: no whole number of nanoseconds.
    block.with(&[("FREQGEN_REF_IN", 1), ("Enable", 1), ("Frequency", 699_997)]).call(&mut rig.expert, 0);
    let edges = rig.to(1_000_000_000).edges();
    for (n, (at, on)) in edges.iter().enumerate() {
        let exact = n as i128 * 5_000_000_000 / 699_997;
        assert_eq!((i128::from(*at), *on), (exact, n % 2 == 0), "edge {n}");
    }
    assert_eq!(edges.len(), 139_999 + 1);
}

// io:STD-PWM-02
#[test]
fn a_change_waits_for_the_next_period() {
    let (mut rig, mut block) = kilohertz();
    // In the middle of a pulse, and once more in the gap after it: the last one counts.
    rig.to(100 * US);
    block.with(&[("Duty", 75)]).call(&mut rig.expert, 100 * US);
    assert_eq!(block.shows(), [0, 1, 0, 0]);
    rig.to(600 * US);
    block.with(&[("Frequency", 20_000)]).call(&mut rig.expert, 600 * US);
    assert_eq!(rig.fact(FunctionProbe::Frequency), Value::Int(10_000));
    rig.to(MS);
    block.call(&mut rig.expert, MS);
    assert_eq!(block.shows(), [1, 0, 0, 0]);
    assert_eq!(
        rig.to(1_500 * US).edges(),
        [(0, true), (250 * US, false), (MS, true), (1_375 * US, false), (1_500 * US, true)]
    );
}

// io:STD-PWM-01
#[test]
fn duty_0_and_100_have_no_edges() {
    let (mut rig, mut block) = kilohertz();
    block.with(&[("Duty", 0)]).call(&mut rig.expert, 10 * US);
    assert_eq!(rig.to(10 * MS).edges(), [(0, true), (250 * US, false)]);
    assert_eq!(rig.expert.next(), Time::MAX, "a constant output needs no looking after");
    // Periods pass unseen; a change still waits for the next one.
    block.with(&[("Duty", 100)]).call(&mut rig.expert, 10 * MS + 400 * US);
    assert_eq!(rig.to(20 * MS).edges(), [(11 * MS, true)]);
    // A change that is taken back never happens.
    block.with(&[("Duty", 50)]).call(&mut rig.expert, 20 * MS + 1);
    block.with(&[("Duty", 100)]).call(&mut rig.expert, 20 * MS + 2);
    assert_eq!((rig.expert.next(), block.shows()), (Time::MAX, [1, 0, 0, 0]));
    // At the very instant at which a period begins it is taken at once.
    block.with(&[("Duty", 50)]).call(&mut rig.expert, 30 * MS);
    assert_eq!(rig.to(31 * MS).edges(), [(30 * MS + 500 * US, false), (31 * MS, true)]);
}

// io:STD-PWM-01
#[test]
fn frequency_0_is_an_output_at_0() {
    let (mut rig, mut block) = kilohertz();
    block.with(&[("Frequency", 0)]).call(&mut rig.expert, 10 * US);
    assert_eq!(block.shows(), [0, 1, 0, 0]);
    assert_eq!(rig.to(5 * MS).edges(), [(0, true), (250 * US, false)]);
    block.call(&mut rig.expert, 5 * MS);
    assert_eq!(block.shows(), [1, 0, 0, 0]);
    // There is no period to wait for.
    block.with(&[("Frequency", 10_000)]).call(&mut rig.expert, 5 * MS + 7);
    assert_eq!(rig.to(6 * MS).edges(), [(5 * MS + 7, true), (5 * MS + 7 + 250 * US, false)]);
}

// io:STD-PWM-02
#[test]
fn sync_begins_the_period_anew() {
    let (mut rig, mut block) = kilohertz();
    rig.to(600 * US);
    block.with(&[("Sync", 1)]).call(&mut rig.expert, 600 * US);
    // A level is no edge.
    block.call(&mut rig.expert, 700 * US);
    block.with(&[("Sync", 0)]).call(&mut rig.expert, 800 * US);
    // In the middle of a pulse it lasts longer, it is not cut; and what was changed is taken.
    block.with(&[("Duty", 40)]).call(&mut rig.expert, 1_650 * US);
    block.with(&[("Sync", 1)]).call(&mut rig.expert, 1_700 * US);
    assert_eq!(block.shows(), [1, 0, 0, 0]);
    assert_eq!(
        rig.to(2_699 * US).edges(),
        [
            (0, true),
            (250 * US, false),
            (600 * US, true),
            (850 * US, false),
            (1_600 * US, true),
            (2_100 * US, false)
        ]
    );
}

// io:STD-PWM-02
#[test]
fn inputs_enable_and_sync_where_they_may() {
    let mut rig = Rig::new([pwm(0)]);
    let mut block = Instance::new("PWM_M241");
    block
        .with(&[("PWM_REF_IN", 1), ("Frequency", 10_000), ("Duty", 50), ("EN_Enable", 1)])
        .call(&mut rig.expert, 0);
    assert_eq!(block.shows(), [0, 0, 0, 0]);
    rig.expert.edge(Time::from_nanos(10 * US), 0, true);
    // Not authorised: no effect.
    rig.expert.edge(Time::from_nanos(100 * US), 1, true);
    rig.expert.edge(Time::from_nanos(110 * US), 1, false);
    rig.to(200 * US);
    block.with(&[("EN_Sync", 1)]).call(&mut rig.expert, 200 * US);
    assert_eq!(block.shows(), [1, 0, 0, 0]);
    rig.expert.edge(Time::from_nanos(700 * US), 1, true);
    rig.expert.edge(Time::from_nanos(720 * US), 1, false);
    rig.expert.edge(Time::from_nanos(800 * US), 0, false);
    assert_eq!(
        rig.to(5 * MS).edges(),
        [(10 * US, true), (510 * US, false), (700 * US, true), (800 * US, false)]
    );
    // Not authorised: its level has no effect, unless the program enables.
    block.with(&[("EN_Enable", 0)]).call(&mut rig.expert, 5 * MS);
    rig.expert.edge(Time::from_nanos(6 * MS), 0, true);
    assert_eq!(rig.to(7 * MS).edges(), []);
}

// io:STD-PWM-03, io:STD-PWM-01, io:STD-FG-01, io:EXP-03
#[test]
fn values_out_of_range_change_nothing() {
    for (output, most) in [(0, 200_000), (3, 200_000), (4, 10_000), (7, 10_000)] {
        let mut rig = Rig::new([pwm(output)]);
        let mut block = Instance::new("PWM_M241");
        block.with(&[("PWM_REF_IN", 1), ("Enable", 1), ("Frequency", most), ("Duty", 100)]);
        block.call(&mut rig.expert, 0);
        assert_eq!(block.shows(), [1, 0, 0, 0]);
        for (pin, wrong, right) in [("Frequency", most + 1, 1), ("Duty", 101, 0), ("Frequency", -1, 5)] {
            block.with(&[(pin, wrong)]).call(&mut rig.expert, 0);
            assert_eq!(block.shows(), [0, 0, 1, 3], "{pin} {wrong}");
            block.with(&[(pin, right)]).call(&mut rig.expert, 0);
            assert_eq!(block.shows()[2..], [0, 0], "{pin} {right}");
        }
        block.with(&[("HighPrecision", 1), ("Duty", 1001)]).call(&mut rig.expert, 0);
        assert_eq!(block.shows(), [0, 0, 1, 3]);
        block.with(&[("Duty", 999)]).call(&mut rig.expert, 0);
        assert_eq!(block.shows()[2..], [0, 0]);
    }
    for (output, most) in [(0, 1_000_000), (4, 10_000)] {
        let mut rig = Rig::new([generator(output)]);
        let mut block = Instance::new("FrequencyGenerator_M241");
        block.with(&[("FREQGEN_REF_IN", 1), ("Enable", 1), ("Frequency", most)]).call(&mut rig.expert, 0);
        assert_eq!(block.shows(), [1, 0, 0, 0]);
        block.with(&[("Frequency", most + 1)]).call(&mut rig.expert, 0);
        assert_eq!(block.shows(), [0, 0, 1, 3]);
    }
}

// io:STD-PWM-03, io:STD-PWM-02
#[test]
fn an_error_neither_starts_nor_keeps_alive() {
    let (mut rig, mut block) = kilohertz();
    rig.to(100 * US);
    block.with(&[("Frequency", 999_999)]).call(&mut rig.expert, 100 * US);
    assert_eq!(rig.to(2 * MS - 1).edges(), [(0, true), (250 * US, false), (MS, true), (1_250 * US, false)]);
    // Enable = 0 is obeyed whatever the values are, and is no error.
    block.with(&[("Enable", 0)]).call(&mut rig.expert, 2 * MS - 1);
    assert_eq!((block.shows(), rig.fact(FunctionProbe::Run)), ([0, 0, 0, 0], Value::Bool(false)));
    block.with(&[("Enable", 1)]).call(&mut rig.expert, 2 * MS);
    assert_eq!((block.shows(), rig.to(9 * MS).edges()), ([0, 0, 1, 3], vec![]));
}

// io:EXP-06
#[test]
fn a_block_needs_a_function_of_its_kind() {
    let mut rig = Rig::new([pwm(0), generator(1)]);
    for (name, own, pin) in [("PWM_M241", 1, "PWM_REF_IN"), ("FrequencyGenerator_M241", 2, "FREQGEN_REF_IN")]
    {
        for reference in [-1, 0, 1, 2, 3, i64::MAX] {
            let mut block = Instance::new(name);
            block.with(&[(pin, reference), ("Enable", 1), ("Frequency", 10)]).call(&mut rig.expert, 0);
            let shows = if reference == own { [1, 0, 0, 0] } else { [0, 0, 1, 1] };
            assert_eq!(block.shows(), shows, "{name} {reference}");
        }
    }
    // The generator's duty needs no word; that of the PWM was never given.
    assert_eq!(rig.edges(), [(0, true)]);
}

// io:OUT-20
#[test]
fn outside_running_there_are_no_pulses() {
    let (mut rig, mut block) = kilohertz();
    rig.to(100 * US);
    rig.expert.operate(Time::from_nanos(100 * US), ExpertOperation::Stopped);
    rig.expert.operate(Time::from_nanos(5 * MS), ExpertOperation::Running);
    assert_eq!(rig.to(10 * MS).edges(), [(0, true), (100 * US, false)]);
    // The program takes it up again.
    block.call(&mut rig.expert, 10 * MS);
    assert_eq!(rig.to(11 * MS - 1).edges(), [(10 * MS, true), (10_250 * US, false)]);
    assert_eq!(rig.fact(FunctionProbe::Pulses), Value::Word(2));
    rig.expert.operate(Time::from_nanos(11 * MS), ExpertOperation::Off);
    assert_eq!(rig.fact(FunctionProbe::Pulses), Value::Word(0));
}

/// What happens to a function, and how long after the last thing.
#[derive(Clone, Debug)]
enum Event {
    Call { enable: bool, frequency: u32, duty: u16, sync: bool },
    Enable(bool),
    Sync(bool),
    Stop,
}

fn event() -> impl Strategy<Value = (i64, Event)> {
    let frequency = prop_oneof![8 => 100_000..=200_000_u32, 1 => Just(0), 1 => Just(123_457)];
    let duty = prop_oneof![6 => 0..=1000_u16, 1 => Just(0), 1 => Just(1000)];
    let event = prop_oneof![
        8 => (prop::bool::weighted(0.8), frequency, duty, any::<bool>())
            .prop_map(|(enable, frequency, duty, sync)| Event::Call { enable, frequency, duty, sync }),
        1 => any::<bool>().prop_map(Event::Enable),
        2 => any::<bool>().prop_map(Event::Sync),
        1 => Just(Event::Stop),
    ];
    (prop_oneof![0..3_i64, 0..150_000_i64], event)
}

/// The edges of a PWM up to `end`, worked out nanosecond by nanosecond from the definition: pulse k since the wave began,
/// was synchronised or changed its frequency rises k periods after that.
fn by_the_nanosecond(events: &[(i64, Event)], end: i64) -> Vec<(i64, bool)> {
    let mut edges: Vec<(i64, bool)> = Vec::new();
    let mut level = false;
    let (mut soft, mut input, mut sync_level, mut last_sync) = (false, false, false, false);
    let mut called = false;
    let mut wanted = (0_u32, 0_u16);
    // Frequency, duty, origin, number of the period.
    let mut wave: Option<(u32, u16, i64, i64)> = None;
    let mut events = events.iter().peekable();
    let rise = |f: u32, origin: i64, k: i64| origin + k * 10_000_000_000 / i64::from(f);
    let fall = |f: u32, d: u16, origin: i64, k: i64| {
        origin + (k * 10_000_000_000 + i64::from(d) * 10_000_000) / i64::from(f)
    };
    for now in 0..=end {
        if let Some((f, d, origin, k)) = &mut wave
            && *f != 0
            && rise(*f, *origin, *k + 1) == now
        {
            if *f == wanted.0 {
                *k += 1;
            } else {
                (*origin, *k) = (now, 0);
            }
            (*f, *d) = wanted;
        }
        while let Some((_, event)) = events.next_if(|(at, _)| *at == now) {
            let mut restart = false;
            match event {
                Event::Call { enable, frequency, duty, sync } => {
                    (soft, called, wanted) = (*enable, true, (*frequency, *duty));
                    restart = *sync && !last_sync;
                    last_sync = *sync;
                    if let Some((f, d, origin, k)) = &mut wave {
                        let boundary = *f != 0 && rise(*f, *origin, *k) == now;
                        // A constant output can take a change where a period begins.
                        if *f == 0 || boundary && *k > 0 && (*d == 0 || *d == 1000) {
                            if *f != wanted.0 {
                                (*origin, *k) = (now, 0);
                            }
                            (*f, *d) = wanted;
                        }
                    }
                }
                Event::Enable(high) => input = *high,
                Event::Sync(high) => {
                    restart = called && *high && !sync_level;
                    sync_level = *high;
                }
                Event::Stop => (soft, called) = (false, false),
            }
            let enabled = soft || called && input;
            if !enabled {
                wave = None;
            } else if wave.is_none() || restart {
                wave = Some((wanted.0, wanted.1, now, 0));
            }
        }
        let high = wave.is_some_and(|(f, d, origin, k)| {
            f != 0 && now < fall(f, d, origin, k).max(now + i64::from(d == 1000))
        });
        if high != level {
            level = high;
            edges.push((now, high));
        }
    }
    edges
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn whatever_is_asked_the_edges_are_those_of_the_definition(steps in prop::collection::vec(event(), 1..16)) {
        let mut at = 0;
        let events: Vec<_> = steps.into_iter().map(|(wait, event)| { at += wait; (at, event) }).collect();
        let end = at + 250_000;
        let mut rig = Rig::new([pwm(0)]);
        let mut block = Instance::new("PWM_M241");
        for (at, event) in &events {
            rig.to(*at);
            let now = Time::from_nanos(*at);
            match event {
                Event::Call { enable, frequency, duty, sync } => block
                    .with(&[
                        ("PWM_REF_IN", 1), ("HighPrecision", 1), ("EN_Enable", 1), ("EN_Sync", 1),
                        ("Enable", (*enable).into()), ("Frequency", (*frequency).into()),
                        ("Duty", (*duty).into()), ("Sync", (*sync).into()),
                    ])
                    .call(&mut rig.expert, *at),
                Event::Enable(high) => rig.expert.edge(now, 0, *high),
                Event::Sync(high) => rig.expert.edge(now, 1, *high),
                Event::Stop => {
                    rig.expert.operate(now, ExpertOperation::Stopped);
                    rig.expert.operate(now, ExpertOperation::Running);
                }
            }
        }
        // Two edges at one instant leave the level as it was.
        let mut edges: Vec<(i64, bool)> = Vec::new();
        for edge in rig.to(end).edges() {
            if edges.last().is_some_and(|last| last.0 == edge.0) {
                edges.pop();
            } else {
                edges.push(edge);
            }
        }
        prop_assert_eq!(edges, by_the_nanosecond(&events, end));
    }

    #[test]
    fn how_time_is_cut_makes_no_difference(cuts in prop::collection::vec(1..700_000_i64, 1..40), tenths in 1..=200_000_u32, duty in 0..=100_u16) {
        let run = |cuts: &[i64]| {
            let mut rig = Rig::new([pwm(0)]);
            Instance::new("PWM_M241")
                .with(&[("PWM_REF_IN", 1), ("Enable", 1), ("Frequency", tenths.into()), ("Duty", duty.into())])
                .call(&mut rig.expert, 0);
            let mut at = 0;
            for cut in cuts {
                at += cut;
                rig.to(at);
            }
            rig.edges()
        };
        prop_assert_eq!(run(&cuts), run(&[cuts.iter().sum()]));
    }
}

#[test]
fn a_wave_goes_on_for_centuries() {
    let mut rig = Rig::new([pwm(0)]);
    let mut block = Instance::new("PWM_M241");
    block.with(&[("PWM_REF_IN", 1), ("Enable", 1), ("Frequency", 3), ("Duty", 100)]).call(&mut rig.expert, 0);
    let far = i64::MAX - Span::from_secs(1).as_nanos();
    block.with(&[("Duty", 1)]).call(&mut rig.expert, far);
    rig.to(i64::MAX - 1);
    assert!(rig.expert.next() > Time::from_nanos(far));
}
