//! Waves whose pulses hardware makes.

use super::*;
use signal::Span;

const MS: i64 = 1_000_000;
const US: i64 = 1_000;

/// A offloaded PWM, and what it reported since it was asked last.
struct OffloadedPwm {
    wave: SquareWave,
    fx: ExpertEffects,
    request: WaveRequest,
}

fn at(nanos: i64) -> Time {
    Time::from_nanos(nanos)
}

/// A square wave with this period and this high part, in microseconds.
fn pulses(period: i64, high: i64) -> ExpertEffect {
    ExpertEffect::Wave { output: 0, period: Span::from_micros(period), high: Span::from_micros(high) }
}

const fn level(on: bool) -> ExpertEffect {
    ExpertEffect::Output { output: 0, on }
}

impl OffloadedPwm {
    fn new() -> OffloadedPwm {
        let mut wave = SquareWave::pwm(&WaveConfig { sync: Some(1), ..WaveConfig::new(0) });
        wave.offload_pulses();
        let mut fx = ExpertEffects::new();
        wave.operate(at(0), ExpertOperation::Running, &mut fx);
        let shape = Some(WaveShape { frequency: 10_000, duty: 250 });
        let request =
            WaveRequest { enable: true, enable_by_input: false, sync: false, sync_by_input: false, shape };
        OffloadedPwm { wave, fx, request }
    }

    /// 1 kHz or so with this duty, in percent.
    fn call(&mut self, now: i64, frequency: u32, duty: u16) -> WaveStatus {
        self.request.shape = Some(WaveShape { frequency: frequency * 10, duty: duty * 10 });
        self.wave.call(at(now), &self.request, &mut self.fx)
    }

    fn to(&mut self, now: i64) -> Vec<(i64, ExpertEffect)> {
        self.wave.fire(at(now), &mut self.fx);
        let reported = self.fx.as_slice().iter().map(|(at, effect)| (at.as_nanos(), *effect)).collect();
        self.fx = ExpertEffects::new();
        reported
    }
}

#[test]
fn a_wave_is_told_once_and_asks_for_nothing_more() {
    let mut pwm = OffloadedPwm::new();
    let status = pwm.call(7 * US, 1_000, 25);
    assert!(status.in_frequency && !status.busy);
    assert_eq!(pwm.to(7 * US), [(7 * US, pulses(1_000, 250))]);
    assert_eq!(pwm.wave.next(), Time::MAX);
    pwm.call(20 * MS, 1_000, 25);
    assert_eq!(pwm.to(60 * MS), []);
    assert_eq!(pwm.wave.read(FunctionProbe::Frequency), Some(Value::Int(10_000)));
    // Nobody counts them.
    assert_eq!(pwm.wave.read(FunctionProbe::Pulses), Some(Value::Unknown));
    pwm.request.enable = false;
    pwm.call(61 * MS, 1_000, 25);
    assert_eq!(pwm.to(61 * MS), [(61 * MS, level(false))]);
}

// io:STD-PWM-02: what is reported at once holds from the end of a period on, and the block says so.
#[test]
fn a_change_is_told_at_once_and_reached_with_the_next_period() {
    let mut pwm = OffloadedPwm::new();
    pwm.call(0, 1_000, 25);
    pwm.to(0);
    let status = pwm.call(10 * MS + 300 * US, 2_000, 25);
    assert!(status.busy && !status.in_frequency);
    assert_eq!(pwm.wave.read(FunctionProbe::Frequency), Some(Value::Int(10_000)));
    assert_eq!(pwm.to(10 * MS + 300 * US), [(10 * MS + 300 * US, pulses(500, 125))]);
    // Taken back before it is reached.
    pwm.call(10 * MS + 400 * US, 1_000, 25);
    assert_eq!(pwm.to(20 * MS), [(10 * MS + 400 * US, pulses(1_000, 250))]);
    pwm.call(20 * MS + 900 * US, 1_000, 75);
    assert_eq!(pwm.to(22 * MS), [(20 * MS + 900 * US, pulses(1_000, 750))]);
    let status = pwm.call(22 * MS, 1_000, 75);
    assert!(status.in_frequency && !status.busy);
}

// io:STD-PWM-01: a level would cut the pulse under way, so it comes with the end of the period.
#[test]
fn a_constant_output_is_a_level_from_the_end_of_the_period() {
    let mut pwm = OffloadedPwm::new();
    pwm.call(0, 1_000, 25);
    pwm.to(0);
    pwm.call(200 * US, 1_000, 100);
    assert_eq!(pwm.to(5 * MS), [(MS, level(true))]);
    // From 1 to 1 there is no edge; from pulses to 1 there was.
    pwm.call(6 * MS + 100 * US, 1_000, 50);
    assert_eq!(pwm.to(8 * MS), [(7 * MS, pulses(1_000, 500))]);
    pwm.call(9 * MS + 1, 0, 50);
    assert_eq!(pwm.to(12 * MS), [(10 * MS, level(false))]);
    pwm.call(13 * MS, 1_000, 50);
    assert_eq!(pwm.to(13 * MS), [(13 * MS, pulses(1_000, 500))]);
    // io:OUT-20
    pwm.wave.operate(at(14 * MS), ExpertOperation::Stopped, &mut pwm.fx);
    assert_eq!(pwm.to(14 * MS), [(14 * MS, level(false))]);
}

#[test]
fn a_period_that_begins_anew_is_told_where_there_is_one() {
    let mut pwm = OffloadedPwm::new();
    pwm.request.sync_by_input = true;
    pwm.call(0, 1_000, 25);
    pwm.wave.edge(at(300 * US), 1, true, &mut pwm.fx);
    assert_eq!(
        pwm.to(400 * US),
        [(0, pulses(1_000, 250)), (300 * US, ExpertEffect::PeriodRestarted { output: 0 })]
    );
    pwm.call(400 * US, 1_000, 0);
    assert_eq!(pwm.to(2 * MS), [(1_300 * US, level(false))]);
    pwm.wave.edge(at(2 * MS), 1, true, &mut pwm.fx);
    assert_eq!(pwm.to(2 * MS), []);
}
