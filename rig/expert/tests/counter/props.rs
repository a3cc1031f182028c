//! Properties: ways to hand in edges that are the same, and a second decoder.

use crate::rig::{Instance, dual, free};
use profile::EventEdges;
use proptest::collection::vec;
use proptest::prelude::*;
use scanrig_expert::*;
use signal::{Span, Time, Value};

/// All that can be seen of a counter in the end, and what it did.
type Seen = (Vec<(i64, ExpertEffect)>, Vec<Value>);

const FACTS: [FunctionProbe; 16] = [
    FunctionProbe::Value,
    FunctionProbe::Captured,
    FunctionProbe::Valid,
    FunctionProbe::Run,
    FunctionProbe::Error,
    FunctionProbe::Threshold(0),
    FunctionProbe::Threshold(1),
    FunctionProbe::Threshold(2),
    FunctionProbe::Threshold(3),
    FunctionProbe::Reflex(0),
    FunctionProbe::Reflex(1),
    FunctionProbe::ModuloFlag,
    FunctionProbe::PresetFlag,
    FunctionProbe::CaptureFlag,
    FunctionProbe::Excess,
    FunctionProbe::Pulses,
];

pub fn running(config: &CounterConfig, conditions: InputConditions, on: &[&str]) -> ExpertFunctions {
    let functions = vec![FunctionConfig { name: "HSC0".into(), kind: FunctionKind::Counter(config.clone()) }];
    let mut expert = ExpertFunctions::new(&ExpertConfig { functions }, &[conditions; 8]);
    expert.operate(Time::ZERO, ExpertOperation::Running);
    let mut block = Instance::new("HSCMain_M241");
    block.with(&[("HSC_REF_IN", 1)]);
    for pin in on {
        block.with(&[(pin, 1)]);
    }
    block.call(&mut expert, 0);
    expert
}

fn gather(expert: &mut ExpertFunctions, effects: &mut Vec<(i64, ExpertEffect)>) {
    let mut place = 0;
    while let Some((at, effect)) = expert.take(place) {
        effects.push((at.as_nanos(), effect));
        place += 1;
    }
}

fn seen(mut expert: ExpertFunctions, mut effects: Vec<(i64, ExpertEffect)>, end: i64) -> Seen {
    expert.fire(Time::from_nanos(end));
    gather(&mut expert, &mut effects);
    (effects, FACTS.map(|fact| expert.read(0, fact)).to_vec())
}

fn kinds() -> impl Strategy<Value = CounterConfig> {
    let phases = prop_oneof![
        Just(PhaseMode::UpDown),
        Just(PhaseMode::PulseDirection),
        Just(PhaseMode::X1),
        Just(PhaseMode::X2),
        Just(PhaseMode::X4),
        Just(PhaseMode::ReverseX1),
        Just(PhaseMode::ReverseX2),
        Just(PhaseMode::ReverseX4),
    ];
    let limits = prop_oneof![Just(LimitsMode::Lock), Just(LimitsMode::Rollover)];
    let single = prop_oneof![
        (1_i32..9).prop_map(|preset| CounterMode::OneShot { preset }),
        (2_i32..9).prop_map(|modulo| CounterMode::ModuloLoop { modulo }),
        Just(CounterMode::EventCounting { window: Span::from_millis(100) }),
        Just(CounterMode::Frequency { window: Span::from_millis(10) }),
        (prop_oneof![Just(PeriodMeasurement::Period), Just(PeriodMeasurement::PulseWidth)], 0_i64..40_000)
            .prop_map(|(measures, timeout)| CounterMode::Period {
                measures,
                resolution: Span::from_nanos(100),
                timeout: Span::from_nanos(timeout),
            }),
    ];
    let both = prop_oneof![
        (2_i32..9).prop_map(|modulo| CounterMode::ModuloLoop { modulo }),
        (prop_oneof![-3_i32..3, Just(i32::MAX - 2), Just(i32::MIN + 2)], limits)
            .prop_map(|(preset, limits)| free(preset, limits)),
    ];
    prop_oneof![
        single.prop_map(|mode| CounterConfig::new(CounterKind::Single, 0, mode)),
        (phases, both).prop_map(|(phases, mode)| dual(phases, mode)),
    ]
}

fn edges_of() -> impl Strategy<Value = EventEdges> {
    prop_oneof![Just(EventEdges::Rising), Just(EventEdges::Falling), Just(EventEdges::Both)]
}

fn configs() -> impl Strategy<Value = CounterConfig> {
    let events = prop_oneof![
        Just(ThresholdEvent::None),
        Just(ThresholdEvent::Upwards),
        Just(ThresholdEvent::Downwards),
        Just(ThresholdEvent::Both),
        Just(ThresholdEvent::Below),
        Just(ThresholdEvent::Above),
    ];
    let inputs = (any::<[bool; 4]>(), edges_of(), edges_of(), edges_of());
    (kinds(), vec((-3_i32..8, events), 0..5), any::<[u8; 2]>(), inputs).prop_map(
        |(mut config, mut thresholds, zones, (there, first, second, third))| {
            thresholds.sort_by_key(|(value, _)| *value);
            thresholds.dedup_by_key(|(value, _)| *value);
            config.thresholds =
                thresholds.into_iter().map(|(value, event)| Threshold { value, event }).collect();
            for (n, zones) in zones.into_iter().enumerate() {
                config.reflex[n] = Reflex { output: Some(n as u8), zones: zones & 31 };
            }
            config.enable = there[0].then_some(2);
            config.sync = there[1].then_some(SyncInput { input: 3, edges: first, while_enable: None });
            config.captures[0] = there[2].then_some(CaptureInput { input: 4, edges: second });
            config.captures[1] = there[3].then_some(CaptureInput { input: 5, edges: third });
            // What a configuration cannot have is left out, as long as there is something.
            while let Some(fault) = config.faults().first() {
                match fault {
                    CounterFault::Input(_) => {
                        config.sync = None;
                        config.captures = [None; 2];
                    }
                    CounterFault::ThresholdRange(n) => {
                        config.thresholds.remove(usize::from(*n));
                    }
                    CounterFault::Thresholds => config.thresholds.clear(),
                    CounterFault::ReflexZone(n) => config.reflex[usize::from(*n)].zones = 0,
                    CounterFault::ReflexWithoutThreshold(_) => config.reflex = Default::default(),
                    other => unreachable!("{other}"),
                }
            }
            config
        },
    )
}

fn trains() -> impl Strategy<Value = Vec<InputEdge>> {
    // Few different gaps, so that instants of edges and of filters meet often.
    vec((0_i64..6, 0_u8..8), 0..120).prop_map(|steps| {
        let mut at = 0;
        let mut levels = 0_u8;
        steps
            .into_iter()
            .map(|(gap, input)| {
                let input = if input < 6 { input } else { input - 6 };
                at += gap * 500;
                levels ^= 1 << input;
                InputEdge { at: Time::from_nanos(at), input, high: levels >> input & 1 == 1 }
            })
            .collect()
    })
}

const ON: [&str; 7] = ["EN_Enable", "EN_Preset", "EN_Cap", "EN_Compare", "EN_Out0", "EN_Out1", "F_Preset"];

proptest! {
    #![proptest_config(ProptestConfig { cases: 4_000, ..ProptestConfig::default() })]

    // The batch path equals the path edge by edge, whether anybody lets time pass in between or not.
    #[test]
    fn however_edges_are_handed_in(
        config in configs(),
        edges in trains(),
        delay in 0_i64..4,
        bounce in 0_i64..6,
        forced in any::<bool>(),
    ) {
        let conditions =
            InputConditions { delay: Span::from_nanos(delay * 500), bounce: Span::from_nanos(bounce * 500) };
        let mut on = ON.to_vec();
        on.extend(forced.then_some("F_Enable"));
        let start = running(&config, conditions, &on);
        let end = edges.last().map_or(0, |edge| edge.at.as_nanos()) + 250_000_000;

        let (mut expert, mut effects) = (start.clone(), Vec::new());
        for edge in &edges {
            while expert.next() <= edge.at {
                let at = expert.next();
                expert.fire(at);
                gather(&mut expert, &mut effects);
            }
            expert.edge(edge.at, edge.input.into(), edge.high);
            gather(&mut expert, &mut effects);
        }
        let by_instants = seen(expert, effects, end);

        let (mut expert, mut effects) = (start.clone(), Vec::new());
        for edge in &edges {
            expert.edge(edge.at, edge.input.into(), edge.high);
        }
        gather(&mut expert, &mut effects);
        prop_assert_eq!(&seen(expert, effects, end), &by_instants);

        let (mut expert, mut effects) = (start, Vec::new());
        let mut left = &edges[..];
        while !left.is_empty() {
            let cut = left.len().min(17);
            let taken = expert.edges(&left[..cut]);
            prop_assert!(taken == cut || !expert.effects().as_slice().is_empty());
            gather(&mut expert, &mut effects);
            left = &left[taken..];
        }
        prop_assert_eq!(&seen(expert, effects, end), &by_instants);
    }
}

/// The second decoder. It knows nothing of transitions: of an encoder it keeps the position in quarters of a cycle, and
/// what is counted is a function of the position.
struct Encoder {
    phases: PhaseMode,
    position: i64,
    base: i64,
    illegal: bool,
    a: bool,
    b: bool,
}

impl Encoder {
    fn counted(&self) -> i64 {
        match self.phases {
            PhaseMode::X4 => self.position,
            PhaseMode::X2 => (self.position + 1).div_euclid(2),
            PhaseMode::X1 => (self.position + 3).div_euclid(4),
            PhaseMode::ReverseX4 => -self.position,
            PhaseMode::ReverseX2 => -(self.position + 1).div_euclid(2),
            PhaseMode::ReverseX1 => -(self.position + 3).div_euclid(4),
            PhaseMode::UpDown | PhaseMode::PulseDirection => 0,
        }
    }

    /// The levels become these at one instant.
    fn become_(&mut self, a: bool, b: bool) {
        let rose = (a && !self.a, b && !self.b);
        (self.a, self.b) = (a, b);
        match self.phases {
            PhaseMode::UpDown => self.base += i64::from(rose.0) - i64::from(rose.1),
            PhaseMode::PulseDirection => self.base += if rose.0 { if b { -1 } else { 1 } } else { 0 },
            _ => {
                let quarter = match (a, b) {
                    (false, false) => 0,
                    (true, false) => 1,
                    (true, true) => 2,
                    (false, true) => 3,
                };
                match (quarter - self.position).rem_euclid(4) {
                    0 => {}
                    1 => self.position += 1,
                    3 => self.position -= 1,
                    _ => {
                        let before = self.counted();
                        self.position += 2;
                        self.base += before - self.counted();
                        self.illegal = true;
                    }
                }
            }
        }
    }

    fn value(&self) -> i64 {
        self.base + self.counted()
    }
}

pub const ALL: [PhaseMode; 8] = [
    PhaseMode::UpDown,
    PhaseMode::PulseDirection,
    PhaseMode::X1,
    PhaseMode::X2,
    PhaseMode::X4,
    PhaseMode::ReverseX1,
    PhaseMode::ReverseX2,
    PhaseMode::ReverseX4,
];

/// What a counter with these thresholds does whose value takes these values, by definition (io:STD-HSC-11,
/// io:STD-HSC-12).
fn compared(values: &[(i64, i64)], config: &CounterConfig) -> Vec<(i64, ExpertEffect)> {
    let mut effects = Vec::new();
    let on = |value: i64, n: usize| {
        let zone = config.thresholds.iter().filter(|it| value >= it.value.into()).count();
        config.reflex[n].zones >> zone & 1 == 1
    };
    for pair in values.windows(2) {
        let ((_, before), (at, after)) = (pair[0], pair[1]);
        for (n, threshold) in (0..).zip(&config.thresholds) {
            let limit = i64::from(threshold.value);
            let up = before < limit && after >= limit;
            let down = before >= limit && after < limit;
            let raised = match threshold.event {
                ThresholdEvent::Upwards | ThresholdEvent::Above => up,
                ThresholdEvent::Downwards | ThresholdEvent::Below => down,
                ThresholdEvent::Both => up || down,
                ThresholdEvent::Between => {
                    let next = i64::from(config.thresholds[usize::from(n) + 1].value);
                    let within = |value: i64| (limit..next).contains(&value);
                    within(after) && !within(before)
                }
                ThresholdEvent::None => false,
            };
            if raised {
                effects.push((at, ExpertEffect::Threshold { counter: 0, threshold: n }));
            }
        }
        for n in 0..2 {
            if on(before, n) != on(after, n) {
                effects.push((at, ExpertEffect::Output { output: n as u8, on: on(after, n) }));
            }
        }
    }
    effects
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3_000, ..ProptestConfig::default() })]

    // io:STD-HSC-09: every input mode against the second decoder, with both phases at once now and then; and what the
    // value is compared with against its definition.
    #[test]
    fn a_second_decoder_agrees(
        mode in 0_usize..8,
        steps in vec((1_i64..40, 0_u8..9), 0..200),
        thresholds in vec(-12_i32..12, 0..5),
        events in any::<[u8; 4]>(),
        zones in any::<[u8; 2]>(),
    ) {
        use ThresholdEvent as E;
        let mut config = dual(ALL[mode], free(0, LimitsMode::Lock));
        let mut thresholds = thresholds;
        thresholds.sort();
        thresholds.dedup();
        let count = thresholds.len();
        for (n, value) in thresholds.into_iter().enumerate() {
            let event = [E::None, E::Upwards, E::Downwards, E::Both, E::Above, E::Below, E::Between]
                [usize::from(events[n] % 7)];
            let event = if event == E::Between && n + 1 == count { E::Above } else { event };
            config.thresholds.push(Threshold { value, event });
        }
        if count > 0 {
            for n in 0..2 {
                let zones = zones[n] & ((2 << count) - 1);
                config.reflex[n] = Reflex { output: Some(n as u8), zones };
            }
        }
        prop_assert_eq!(config.faults(), []);
        let delay = 2_000;
        let conditions = InputConditions { delay: Span::from_nanos(delay), bounce: Span::ZERO };
        let on = ["F_Enable", "F_Preset", "EN_Compare", "EN_Out0", "EN_Out1"];
        let mut expert = running(&config, conditions, &on);
        let mut effects = Vec::new();
        gather(&mut expert, &mut effects);
        effects.clear();
        let mut oracle =
            Encoder { phases: ALL[mode], position: 0, base: 0, illegal: false, a: false, b: false };
        let mut values = vec![(0, 0)];
        let mut at = 0;
        for (gap, step) in steps {
            at += delay + gap * 10_000;
            let (mut a, mut b) = (oracle.a, oracle.b);
            // Mostly one phase, now and then both.
            (a, b) = match step {
                0..=3 => (!a, b),
                4..=7 => (a, !b),
                _ => (!a, !b),
            };
            for (input, high) in [(0, a), (1, b)] {
                expert.edge(Time::from_nanos(at), input, high);
            }
            oracle.become_(a, b);
            values.push((at + delay, oracle.value()));
            gather(&mut expert, &mut effects);
        }
        let (effects, facts) = seen(expert, effects, at + delay);
        prop_assert_eq!(&facts[0], &Value::Int(oracle.value()));
        prop_assert_eq!(facts[4].as_bool(), Some(oracle.illegal));
        prop_assert_eq!(effects, compared(&values, &config));
    }
}
