//! Which functions a controller can have, and on which inputs and outputs.

use profile::{ChannelSet, EventEdges, IoChannel, Profile, Reference};
use proptest::prelude::*;
use scanrig_expert::{
    AxisConfig, AxisParameterError, AxisRole, CaptureInput, ChannelRole, CounterConfig, CounterKind,
    CounterMode, CounterRole, DriveInput, ExpertConfig, ExpertError, ExpertFault, ExpertFunctions,
    FunctionConfig, FunctionKind, FunctionProbe, InputConditions, PhaseMode, PulseOutput, Reflex,
    ReservedChannels, SyncInput, Threshold, ThresholdEvent, WaveConfig, WaveRole,
};
use signal::{Span, Time, Value};

const MODULO: CounterMode = CounterMode::ModuloLoop { modulo: 100 };

fn simple(a: u8) -> FunctionKind {
    FunctionKind::Counter(CounterConfig::new(CounterKind::Simple, a, MODULO))
}

fn single(a: u8) -> CounterConfig {
    CounterConfig::new(CounterKind::Single, a, MODULO)
}

fn dual(a: u8) -> FunctionKind {
    let kind = CounterKind::Dual { b: a + 1, phases: PhaseMode::X4 };
    FunctionKind::Counter(CounterConfig::new(kind, a, MODULO))
}

fn meter(a: u8) -> FunctionKind {
    let mode = CounterMode::Frequency { window: Span::from_millis(100) };
    FunctionKind::Counter(CounterConfig::new(CounterKind::Single, a, mode))
}

fn pto(a: u8) -> FunctionKind {
    FunctionKind::Axis(AxisConfig::new(a, a + 1))
}

fn generator(output: u8) -> FunctionKind {
    FunctionKind::Generator(WaveConfig::new(output))
}

fn config(kinds: impl IntoIterator<Item = FunctionKind>) -> ExpertConfig {
    let functions =
        (0..).zip(kinds).map(|(n, kind)| FunctionConfig { name: format!("F{n}"), kind }).collect();
    ExpertConfig { functions }
}

const SMALL: &str = "TM241CEC24T";
const LARGE: &str = "TM241CE40T";

fn check(
    profile: Profile,
    reference: &str,
    taken: &ReservedChannels,
    config: &ExpertConfig,
) -> Vec<ExpertError> {
    config.check(profile, Reference::find(reference).unwrap(), taken)
}

/// Place and fault of each error under 2019 with nothing else taken.
fn faults(reference: &str, kinds: impl IntoIterator<Item = FunctionKind>) -> Vec<(usize, ExpertFault)> {
    let errors = check(Profile::M241_2019, reference, &ReservedChannels::default(), &config(kinds));
    errors.into_iter().map(|error| (error.function, error.fault)).collect()
}

// io: section 6.2, the examples; io:EXP-09, io:EXP-11
#[test]
fn the_documented_examples_are_accepted() {
    let none: Vec<(usize, ExpertFault)> = Vec::new();
    let waves = |count: u8| (0..count).map(generator);
    let simples = |from: u8, to: u8| (from..to).map(simple);
    assert_eq!(faults(SMALL, waves(4).chain(simples(0, 14))), none);
    assert_eq!(faults(LARGE, waves(4).chain(simples(0, 16))), none);
    let singles = (0..4).map(|a| FunctionKind::Counter(single(a)));
    assert_eq!(faults(SMALL, singles.clone().chain(simples(4, 14))), none);
    assert_eq!(faults(LARGE, (0..4).map(|n| dual(2 * n)).chain(simples(8, 16))), none);
    assert_eq!(faults(LARGE, waves(2).chain(singles.clone().take(2)).chain(simples(2, 16))), none);
    let axes = |count: u8| (0..count).map(|n| pto(2 * n));
    assert_eq!(faults(SMALL, axes(4).chain(simples(0, 14))), none);
    assert_eq!(faults(LARGE, axes(2).chain(singles.take(2)).chain(simples(2, 16))), none);
    assert_eq!(faults(SMALL, axes(4).chain(simples(0, 8))), none);
    // Note 1: 12 HSC Simple beside 4 frequency meters.
    assert_eq!(faults(LARGE, (0..4).map(meter).chain(simples(4, 16))), none);
}

// io:EXP-07, io:EXP-08
#[test]
fn a_fifth_of_the_shared_class_is_refused() {
    let five = [generator(0), meter(0), dual(1), FunctionKind::Pwm(WaveConfig::new(1)), generator(2)];
    assert_eq!(faults(SMALL, five), [(4, ExpertFault::Shared { most: 4 })]);
    let text = ExpertFault::Shared { most: 4 }.to_string();
    assert!(text.contains("only HSC Simple can be added"), "{text}");
}

// io:STD-PTO-02, io:EXP-04, io:STD-ASG-01
#[test]
fn an_axis_takes_its_inputs_and_outputs() {
    let input = |input| Some(DriveInput { input, inverted: false });
    let axis = AxisConfig {
        drive_enable: Some(4),
        reference: input(0),
        limit_positive: input(0),
        ..AxisConfig::new(2, 3)
    };
    let roles: Vec<_> = FunctionKind::Axis(axis.clone()).channels();
    assert_eq!(roles[0], (ChannelRole::Axis(AxisRole::Reference), IoChannel::Input(0)));
    let errors =
        check(Profile::M241_2019, SMALL, &ReservedChannels::default(), &config([FunctionKind::Axis(axis)]));
    assert_eq!(errors.iter().map(ToString::to_string).collect::<Vec<_>>(), ["limP: I0 is REF already"]);
    assert_eq!(
        faults("TM241CEC24R", [pto(3)]),
        [(0, ExpertFault::Pulses(IoChannel::Output(4)))],
        "the second output of a PTO is no relay"
    );
    let fast = FunctionKind::Axis(AxisConfig { max_velocity: 1_001, ..AxisConfig::new(4, 5) });
    assert!(matches!(
        faults(SMALL, [fast])[..],
        [(0, ExpertFault::Axis(AxisParameterError::OutOfRange { parameter: "max_velocity", .. }))]
    ));
}

// io: section 6.1, the number of PTO
#[test]
fn in_2014_there_are_two_axes() {
    let of = |profile| {
        let config = config((0..3).map(|n| FunctionKind::Axis(single_output(n))));
        let errors = check(profile, SMALL, &ReservedChannels::default(), &config);
        errors.iter().map(|error| (error.function, error.fault)).collect::<Vec<_>>()
    };
    assert_eq!(of(Profile::M241_2014), [(2, ExpertFault::Axes { most: 2 })]);
    assert_eq!(of(Profile::M241_2019), []);
}

fn single_output(a: u8) -> AxisConfig {
    AxisConfig { output: PulseOutput::Pulse, b: None, ..AxisConfig::new(a, 0) }
}

// io:EXP-09, io:EXP-10
#[test]
fn one_counter_more_than_there_are_is_refused() {
    let fifteen = (0..14).map(simple).chain([simple(0)]);
    let first = (IoChannel::Input(0), 0, ChannelRole::Counter(CounterRole::A));
    let assigned = |(channel, function, role)| ExpertFault::Assigned { channel, function, role };
    assert_eq!(faults(SMALL, fifteen), [(14, assigned(first))]);
    // The 40 I/O have 24 inputs, of which counters can use 16.
    let seventeen = (0..17).map(simple);
    assert_eq!(faults(LARGE, seventeen), [(16, ExpertFault::Unusable(IoChannel::Input(16)))]);
    // Inputs run out before numbers do.
    let duals = (0..4).map(|n| dual(2 * n)).chain((8..17).map(simple));
    assert_eq!(faults(LARGE, duals), [(12, ExpertFault::Unusable(IoChannel::Input(16)))]);
    assert_eq!(faults(SMALL, [simple(14)]), [(0, ExpertFault::Missing(IoChannel::Input(14)))]);
    assert_eq!(faults(SMALL, [simple(255)]), [(0, ExpertFault::Missing(IoChannel::Input(255)))]);
}

// io:STD-ASG-01, io:EXP-01
#[test]
fn a_main_counter_has_four_inputs_and_in_2014_six() {
    let capture = |input| Some(CaptureInput { input, edges: EventEdges::Rising });
    let sync = SyncInput { input: 3, edges: EventEdges::Rising, while_enable: None };
    let kind = CounterKind::Dual { b: 1, phases: PhaseMode::X4 };
    let mut counter =
        CounterConfig { enable: Some(2), sync: Some(sync), ..CounterConfig::new(kind, 0, MODULO) };
    let of = |counter: &CounterConfig, profile| {
        let errors = check(
            profile,
            SMALL,
            &ReservedChannels::default(),
            &config([FunctionKind::Counter(counter.clone())]),
        );
        errors.iter().map(|error| error.fault).collect::<Vec<_>>()
    };
    assert_eq!(of(&counter, Profile::M241_2019), []);
    counter.captures[0] = capture(4);
    assert_eq!(of(&counter, Profile::M241_2019), [ExpertFault::Inputs { found: 5, most: 4 }]);
    counter.captures[1] = capture(5);
    assert_eq!(of(&counter, Profile::M241_2014), []);
    let two = CounterConfig { captures: [capture(1), capture(2)], ..single(0) };
    assert_eq!(of(&two, Profile::M241_2019), [ExpertFault::Capture]);
}

// io:STD-ASG-01, io:EXP-10
#[test]
fn an_input_or_output_has_one_role() {
    let pwm = FunctionKind::Pwm(WaveConfig { enable: Some(3), sync: Some(3), ..WaveConfig::new(0) });
    let errors = check(
        Profile::M241_2019,
        SMALL,
        &ReservedChannels::default(),
        &config([simple(3), pwm, generator(0)]),
    );
    let shown: Vec<_> = errors.iter().map(|error| (error.function, error.to_string())).collect();
    assert_eq!(
        shown,
        [
            (1, "EN: I3 is A already".to_owned()),
            (1, "SYNC: I3 is A already".to_owned()),
            (2, "A: Q0 is A already".to_owned())
        ]
    );
    let both = FunctionKind::Pwm(WaveConfig { enable: Some(3), sync: Some(3), ..WaveConfig::new(0) });
    let role = ChannelRole::Wave(WaveRole::Enable);
    let assigned = ExpertFault::Assigned { channel: IoChannel::Input(3), function: 0, role };
    assert_eq!(faults(SMALL, [both]), [(0, assigned)]);
}

// io:STD-ASG-01, io:EXP-02, io:EXP-04, vendor-help:VH-HSC-31
#[test]
fn outputs_have_the_roles_of_the_table() {
    let reflex = |output| {
        let threshold = Threshold { value: 10, event: ThresholdEvent::None };
        let first = Reflex { output: Some(output), zones: 2 };
        FunctionKind::Counter(CounterConfig {
            thresholds: vec![threshold],
            reflex: [first, Reflex::default()],
            ..single(0)
        })
    };
    let pulses = |output| generator(output);
    for (profile, reference, reflexes, generators) in [
        (Profile::M241_2019, SMALL, 0..8, 0..8),
        (Profile::M241_2019, "TM241CE40U", 0..8, 0..8),
        (Profile::M241_2019, "TM241CEC24R", 0..8, 0..4),
        (Profile::M241_2014, SMALL, 0..4, 0..4),
        (Profile::M241_2014, "TM241C40R", 0..4, 0..4),
    ] {
        for output in 0..20 {
            let accepted =
                |kind| check(profile, reference, &ReservedChannels::default(), &config([kind])).is_empty();
            assert_eq!(
                accepted(reflex(output)),
                reflexes.contains(&output),
                "{profile} {reference} Q{output}"
            );
            assert_eq!(
                accepted(pulses(output)),
                generators.contains(&output),
                "{profile} {reference} Q{output}"
            );
        }
    }
    assert_eq!(faults("TM241CE40R", [generator(4)]), [(0, ExpertFault::Pulses(IoChannel::Output(4)))]);
    assert_eq!(faults(SMALL, [generator(8)]), [(0, ExpertFault::Unusable(IoChannel::Output(8)))]);
    assert_eq!(faults(SMALL, [generator(10)]), [(0, ExpertFault::Missing(IoChannel::Output(10)))]);
}

// io:EXP-05, io:RS-06, io:OUT-05, io:EIO-12
#[test]
fn what_the_controller_uses_itself_is_not_free() {
    let taken = ReservedChannels { advanced: ChannelSet::of(2), run_stop: Some(1), alarm: Some(5) };
    let kinds = [simple(0), simple(1), simple(2), simple(5), generator(4), generator(5)];
    let errors = check(Profile::M241_2019, SMALL, &taken, &config(kinds));
    let found: Vec<_> = errors.iter().map(|error| (error.function, error.fault)).collect();
    assert_eq!(
        found,
        [
            (1, ExpertFault::RunStop(IoChannel::Input(1))),
            (2, ExpertFault::Advanced(IoChannel::Input(2))),
            (5, ExpertFault::Alarm(IoChannel::Output(5)))
        ]
    );
}

// io:EXP-06
#[test]
fn names_are_names_and_differ() {
    let names = ["HSC0", "hsc0", "", "1A", "a b", "_x", "x__y", "x_", "None", "\u{e4}", "Kolben_2"];
    let functions =
        (0..).zip(names).map(|(n, name)| FunctionConfig { name: name.to_owned(), kind: simple(n) }).collect();
    let errors = check(Profile::M241_2019, SMALL, &ReservedChannels::default(), &ExpertConfig { functions });
    let found: Vec<_> = errors.iter().map(|error| (names[error.function], error.fault)).collect();
    let name = ExpertFault::Name;
    assert_eq!(
        found,
        [
            ("hsc0", ExpertFault::SameName(0)),
            ("", name),
            ("1A", name),
            ("a b", name),
            ("x__y", name),
            ("x_", name),
            ("None", name),
            ("\u{e4}", name)
        ]
    );
}

// io:REF-08
#[test]
fn an_m251_has_none() {
    let errors = check(Profile::M251_2024, "TM251MESE", &ReservedChannels::default(), &config([simple(0)]));
    assert_eq!(errors.iter().map(|error| error.fault).collect::<Vec<_>>(), [ExpertFault::NoEmbedded]);
}

// io:STD-IN-05
#[test]
fn a_bounce_time_suits_a_frequency() {
    let warned = |kind: CounterKind, bounce: Span, expected: u32, input: u8| {
        let counter = CounterConfig { expected: Some(expected), ..CounterConfig::new(kind, input, MODULO) };
        let inputs = [InputConditions { bounce, ..InputConditions::default() }; 14];
        let warnings = config([FunctionKind::Counter(counter)]).warnings(&inputs);
        warnings.first().map(|warning| warning.most)
    };
    let single = CounterKind::Single;
    for (bounce, most) in [
        (0, 200_000),
        (1, 200_000),
        (2, 200_000),
        (5, 100_000),
        (10, 50_000),
        (50, 10_000),
        (100, 5_000),
        (500, 1_000),
        (1_000, 500),
        (5_000, 100),
    ] {
        assert_eq!(warned(single, Span::from_micros(bounce), most, 0), None, "{bounce} us");
        assert_eq!(warned(single, Span::from_micros(bounce), most + 1, 0), Some(most), "{bounce} us");
    }
    let dual = CounterKind::Dual { b: 1, phases: PhaseMode::X1 };
    assert_eq!(warned(dual, Span::from_micros(2), 100_001, 0), Some(100_000));
    // A regular input.
    assert_eq!(warned(single, Span::from_micros(2), 1_001, 8), Some(1_000));
}

fn any_kind() -> impl Strategy<Value = FunctionKind> {
    let small = prop_oneof![20 => 0..24_u8, 1 => any::<u8>()];
    let input = || prop::option::weighted(0.2, prop_oneof![20 => 0..24_u8, 1 => any::<u8>()]);
    let wave = (small.clone(), input(), input()).prop_map(|(output, enable, sync)| WaveConfig {
        enable,
        sync,
        ..WaveConfig::new(output)
    });
    prop_oneof![
        4 => small.clone().prop_map(simple),
        2 => (small.clone(), small.clone(), input()).prop_map(|(a, b, enable)| {
            let kind = CounterKind::Dual { b, phases: PhaseMode::UpDown };
            FunctionKind::Counter(CounterConfig { enable, ..CounterConfig::new(kind, a, MODULO) })
        }),
        1 => wave.clone().prop_map(FunctionKind::Pwm),
        1 => wave.prop_map(FunctionKind::Generator),
    ]
}

proptest! {
    /// Whatever is accepted has each terminal once and can be made; whatever is refused is refused for a reason that
    /// the rules, counted again, confirm.
    #[test]
    fn what_is_accepted_keeps_the_rules(kinds in prop::collection::vec(any_kind(), 0..8), old in any::<bool>(), large in any::<bool>()) {
        let profile = if old { Profile::M241_2014 } else { Profile::M241_2019 };
        let reference = if large { LARGE } else { SMALL };
        let config = config(kinds);
        let accepted = check(profile, reference, &ReservedChannels::default(), &config).is_empty();
        let mut inputs = Vec::new();
        let mut outputs = Vec::new();
        for function in &config.functions {
            for (_, channel) in function.kind.channels() {
                match channel {
                    IoChannel::Input(n) => inputs.push(n),
                    IoChannel::Output(n) => outputs.push(n),
                }
            }
        }
        let most = if old { 8 } else if large { 16 } else { 14 };
        let mut fine = inputs.iter().all(|n| *n < most) && outputs.iter().all(|n| *n < if old { 4 } else { 8 });
        for list in [&mut inputs, &mut outputs] {
            let all = list.len();
            list.sort_unstable();
            list.dedup();
            fine &= list.len() == all;
        }
        let few = |kind: &FunctionKind| !matches!(kind, FunctionKind::Counter(it) if it.kind == CounterKind::Simple);
        fine &= config.functions.iter().filter(|it| few(&it.kind)).count() <= 4;
        prop_assert_eq!(accepted, fine);
        if accepted {
            let mut expert = ExpertFunctions::new(&config, &[InputConditions::default(); 24]);
            expert.fire(Time::from_nanos(1));
            let driven = outputs.into_iter().collect();
            prop_assert_eq!(expert.outputs(), driven);
            prop_assert_eq!(expert.read(99, FunctionProbe::Value), Value::Unknown);
        }
    }
}
