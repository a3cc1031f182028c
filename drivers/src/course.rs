//! How a quantity goes on from an instant, in closed form.

mod draining;

use draining::{drained, drained_to};
use signal::{Span, Time};

/// Nanoseconds in a second.
const NANOS: f64 = 1e9;
/// Beyond this many seconds nothing is looked for: the range of [`Time`].
const FAR: f64 = 9.0e9;
/// Time constants after which nothing is left of an exponential beside a number that it is added to.
const SETTLED: f64 = 40.0;
/// The most turning points of a course that are looked at: of an oscillation with the least damping, until it has settled.
const MAX_TURNS: usize = 4_096;

/// The value of a quantity from an instant on, for as long as nothing changes it: a function of time that is known as a whole.
///
/// Instants at which it reaches a value are exact to the nanosecond, as far as its value can be computed in floating point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Course {
    since: Time,
    scale: f64,
    offset: f64,
    shape: Shape,
}

/// The shape of a course, of the seconds `s` since its beginning.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape {
    /// `t0 + t1 s + t2 s^2 + t3 s^3 + amplitude exp(-s / tau)`.
    Sum { terms: [f64; 4], amplitude: f64, tau: f64 },
    /// `u^2` of `du/dt = (fill / u - drain) / 2`, from `root` on and at least 0: a tank that empties by its own weight, whose
    /// level is `u^2` and whose inflow `fill`.
    Draining { root: f64, fill: f64, drain: f64 },
    /// `exp(-decay s) (cosine cos(angular s) + sine sin(angular s))`.
    Oscillation { decay: f64, angular: f64, cosine: f64, sine: f64 },
    /// `(constant + linear s) exp(-decay s)`.
    Critical { decay: f64, constant: f64, linear: f64 },
    /// `one exp(-fast s) + other exp(-slow s)`, `fast` above `slow`.
    TwoDecays { fast: f64, slow: f64, one: f64, other: f64 },
}

/// The seconds from one instant to another.
fn seconds(from: Time, to: Time) -> f64 {
    to.as_nanos().saturating_sub(from.as_nanos()) as f64 / NANOS
}

/// By how much two numbers near this one differ by more than rounding, at least `least`: what a quantity has to pass a threshold by
/// on its way back.
pub(crate) fn margin(near: f64, least: f64) -> f64 {
    least.max(libm::fabs(near) * 4.0 * f64::EPSILON)
}

/// The seconds of a duration.
pub fn span_seconds(span: Span) -> f64 {
    span.as_nanos() as f64 / NANOS
}

impl Course {
    /// A quantity that stays.
    pub const fn constant(since: Time, value: f64) -> Course {
        Course::polynomial(since, [value, 0.0, 0.0, 0.0])
    }

    /// A quantity that moves evenly, by `slope` in a second.
    pub const fn line(since: Time, value: f64, slope: f64) -> Course {
        Course::polynomial(since, [value, slope, 0.0, 0.0])
    }

    /// `t0 + t1 s + t2 s^2 + t3 s^3` of the seconds `s`.
    pub const fn polynomial(since: Time, terms: [f64; 4]) -> Course {
        Course { since, scale: 1.0, offset: 0.0, shape: Shape::Sum { terms, amplitude: 0.0, tau: 1.0 } }
    }

    /// From `value` to `target` with a time constant in seconds.
    pub fn lag(since: Time, value: f64, target: f64, tau: f64) -> Course {
        let shape = Shape::Sum { terms: [target, 0.0, 0.0, 0.0], amplitude: value - target, tau };
        Course { since, scale: 1.0, offset: 0.0, shape }
    }

    /// The level of a tank that empties by its own weight: `h' = fill - drain sqrt(h)`, never below 0.
    pub fn draining(since: Time, level: f64, fill: f64, drain: f64) -> Course {
        let shape = Shape::Draining { root: libm::sqrt(level.max(0.0)), fill, drain };
        Course { since, scale: 1.0, offset: 0.0, shape }
    }

    /// The response of `y'' / w^2 + 2 damping y' / w + y = target` from `value` and its `slope` in a second.
    pub fn second_order(since: Time, value: f64, slope: f64, target: f64, w: f64, damping: f64) -> Course {
        let away = value - target;
        let shape = if damping < 1.0 {
            let (decay, angular) = (damping * w, w * libm::sqrt(1.0 - damping * damping));
            Shape::Oscillation { decay, angular, cosine: away, sine: (slope + decay * away) / angular }
        } else if damping > 1.0 {
            let spread = w * libm::sqrt(damping * damping - 1.0);
            let fast = damping * w + spread;
            // The product of both is w^2: the difference would lose its digits where the damping is strong.
            let slow = w * w / fast;
            let one = -(slope + slow * away) / (fast - slow);
            Shape::TwoDecays { fast, slow, one, other: away - one }
        } else {
            Shape::Critical { decay: w, constant: away, linear: slope + w * away }
        };
        Course { since, scale: 1.0, offset: target, shape }
    }

    /// From when on it holds.
    pub fn since(&self) -> Time {
        self.since
    }

    /// The value at an instant from its beginning on.
    pub fn value(&self, at: Time) -> f64 {
        self.at(seconds(self.since, at).max(0.0))
    }

    fn at(&self, s: f64) -> f64 {
        let value = match self.shape {
            Shape::Sum { terms: [t0, t1, t2, t3], amplitude, tau } => {
                let left = if amplitude == 0.0 || s >= SETTLED * tau {
                    0.0
                } else {
                    amplitude * libm::exp(-s / tau)
                };
                t0 + s * (t1 + s * (t2 + s * t3)) + left
            }
            Shape::Draining { root, fill, drain } => {
                let root = drained(root, fill, drain, s);
                root * root
            }
            Shape::Oscillation { decay, .. } | Shape::Critical { decay, .. } if s >= SETTLED / decay => 0.0,
            Shape::TwoDecays { slow, .. } if s >= SETTLED / slow => 0.0,
            Shape::Oscillation { decay, angular, cosine, sine } => {
                let angle = angular * s;
                libm::exp(-decay * s) * (cosine * libm::cos(angle) + sine * libm::sin(angle))
            }
            Shape::Critical { decay, constant, linear } => (constant + linear * s) * libm::exp(-decay * s),
            Shape::TwoDecays { fast, slow, one, other } => {
                one * libm::exp(-fast * s) + other * libm::exp(-slow * s)
            }
        };
        self.offset + self.scale * value
    }

    /// How fast it moves at an instant, in a second.
    pub fn slope(&self, at: Time) -> f64 {
        let s = seconds(self.since, at).max(0.0);
        let slope = match self.shape {
            Shape::Sum { terms: [_, t1, t2, t3], amplitude, tau } => {
                t1 + s * (2.0 * t2 + s * 3.0 * t3) - amplitude / tau * libm::exp(-s / tau)
            }
            Shape::Draining { root, fill, drain } => {
                let root = drained(root, fill, drain, s);
                if root == 0.0 && fill <= 0.0 { 0.0 } else { fill - drain * root }
            }
            Shape::Oscillation { decay, angular, cosine, sine } => {
                let angle = angular * s;
                let (cos, sin) = (libm::cos(angle), libm::sin(angle));
                libm::exp(-decay * s)
                    * ((angular * sine - decay * cosine) * cos - (angular * cosine + decay * sine) * sin)
            }
            Shape::Critical { decay, constant, linear } => {
                (linear - decay * (constant + linear * s)) * libm::exp(-decay * s)
            }
            Shape::TwoDecays { fast, slow, one, other } => {
                -fast * one * libm::exp(-fast * s) - slow * other * libm::exp(-slow * s)
            }
        };
        self.scale * slope
    }

    /// Whether it stays as it is from this instant on.
    pub fn is_settled(&self, at: Time) -> bool {
        self.is_settled_with(self.value(at))
    }

    /// Whether it stays as it is from the instant on at which it has this value.
    pub fn is_settled_with(&self, value: f64) -> bool {
        match self.shape {
            Shape::Sum { terms: [t0, t1, t2, t3], .. } => {
                t1 == 0.0 && t2 == 0.0 && t3 == 0.0 && value == self.offset + self.scale * t0
            }
            Shape::Draining { fill, drain, .. } => {
                let end = if fill <= 0.0 { 0.0 } else { (fill / drain) * (fill / drain) };
                value == self.offset + self.scale * end
            }
            _ => value == self.offset,
        }
    }

    /// Whether its value can be computed: none of its numbers is infinite.
    pub fn is_finite(&self) -> bool {
        let own = match self.shape {
            Shape::Sum { terms: [t0, t1, t2, t3], amplitude, tau } => t0 + t1 + t2 + t3 + amplitude + tau,
            Shape::Draining { root, fill, drain } => root + fill + drain,
            Shape::Oscillation { decay, angular, cosine, sine } => decay + angular + cosine + sine,
            Shape::Critical { decay, constant, linear } => decay + constant + linear,
            Shape::TwoDecays { fast, slow, one, other } => fast + slow + one + other,
        };
        (own + self.offset + self.scale).is_finite()
    }

    /// Whether it is a constant.
    pub fn is_constant(&self) -> bool {
        matches!(self.shape, Shape::Sum { terms: [_, t1, t2, t3], amplitude, .. }
            if t1 == 0.0 && t2 == 0.0 && t3 == 0.0 && amplitude == 0.0)
    }

    /// `offset + scale` times this course.
    #[must_use]
    pub fn mapped(&self, offset: f64, scale: f64) -> Course {
        match self.shape {
            Shape::Sum { terms, amplitude, tau } => {
                let [t0, t1, t2, t3] = terms.map(|term| term * scale);
                let shape =
                    Shape::Sum { terms: [t0 + offset, t1, t2, t3], amplitude: amplitude * scale, tau };
                Course { shape, ..*self }
            }
            _ => Course { scale: scale * self.scale, offset: offset + scale * self.offset, ..*self },
        }
    }

    /// The course with the same values later by a delay.
    #[must_use]
    pub fn delayed(&self, delay: Span) -> Course {
        Course { since: self.since.saturating_add(delay), ..*self }
    }

    /// The same values, counted from a later instant; `None` where the shape has no such form.
    fn from(&self, at: Time) -> Option<([f64; 4], f64, f64)> {
        let Shape::Sum { terms: [t0, t1, t2, t3], amplitude, tau } = self.shape else { return None };
        let s = seconds(self.since, at).max(0.0);
        let terms =
            [t0 + s * (t1 + s * (t2 + s * t3)), t1 + s * (2.0 * t2 + 3.0 * s * t3), t2 + 3.0 * s * t3, t3];
        Some((terms, amplitude * libm::exp(-s / tau), tau))
    }

    /// The sum of two courses from an instant on; `None` where it is no course of this kind.
    pub fn plus(&self, other: &Course, at: Time) -> Option<Course> {
        let ((one, a, tau), (two, b, other_tau)) = (self.from(at)?, other.from(at)?);
        let (amplitude, tau) = match (a == 0.0, b == 0.0) {
            (_, true) => (a, tau),
            (true, _) => (b, other_tau),
            _ if tau == other_tau => (a + b, tau),
            _ => return None,
        };
        let terms = [0, 1, 2, 3].map(|n| one[n] + two[n]);
        Some(Course { since: at, scale: 1.0, offset: 0.0, shape: Shape::Sum { terms, amplitude, tau } })
    }

    /// What adds up of it from an instant on, in its unit times a second, beginning with `initial`; `None` where that is no
    /// course of this kind.
    pub fn integral(&self, at: Time, initial: f64) -> Option<Course> {
        let ([t0, t1, t2, t3], amplitude, tau) = self.from(at)?;
        if t3 != 0.0 {
            return None;
        }
        let terms = [initial + amplitude * tau, t0, t1 / 2.0, t2 / 3.0];
        let shape = Shape::Sum { terms, amplitude: -amplitude * tau, tau };
        Some(Course { since: at, scale: 1.0, offset: 0.0, shape })
    }

    /// The first nanosecond after `after` at which it is `level` or more.
    pub fn rises_to(&self, level: f64, after: Time) -> Option<Time> {
        self.first(after, level, &|value| value >= level)
    }

    /// The first nanosecond after `after` at which it is `level` or less.
    pub fn falls_to(&self, level: f64, after: Time) -> Option<Time> {
        self.first(after, level, &|value| value <= level)
    }

    /// The first nanosecond after `after` at which its value has reached what `reached` says, which holds of all values from
    /// `level` on upwards or downwards.
    fn first(&self, after: Time, level: f64, reached: &dyn Fn(f64) -> bool) -> Option<Time> {
        let start = after.as_nanos().max(self.since.as_nanos()).checked_add(1)?;
        // Of a value that goes one way to its end no instant has to be looked at where that does not meet the level.
        if let Some((least, most)) = self.range()
            && (level < least || level > most)
        {
            return reached(least).then_some(Time::from_nanos(start));
        }
        if reached(self.value(Time::from_nanos(start))) {
            return Some(Time::from_nanos(start));
        }
        let last = i64::MAX - 1;
        let mut from = start;
        let mut turned = seconds(self.since, Time::from_nanos(start));
        for _ in 0..MAX_TURNS {
            let turn = self.turn(turned);
            let nanos = libm::round(turn.unwrap_or(FAR) * NANOS);
            let room = last.saturating_sub(self.since.as_nanos());
            let to =
                if nanos < room as f64 { self.since.as_nanos().saturating_add(nanos as i64) } else { last };
            if to > from && reached(self.value(Time::from_nanos(to))) {
                // The value is monotone from one turning point to the next.
                let (mut before, mut there) = (from, to);
                if let Some(s) = self.guess(level) {
                    (before, there) = self.around(s, (before, there), reached);
                }
                while there - before > 1 {
                    let middle = before + (there - before) / 2;
                    if reached(self.value(Time::from_nanos(middle))) {
                        there = middle
                    } else {
                        before = middle
                    }
                }
                return Some(Time::from_nanos(there));
            }
            turned = turn?;
            from = from.max(to);
        }
        None
    }

    /// Between which values, with room for rounding, a course lies that goes one way only and comes to an end.
    fn range(&self) -> Option<(f64, f64)> {
        let (one, other) = match self.shape {
            Shape::Sum { terms: [t0, t1, t2, t3], amplitude, .. } if t1 == 0.0 && t2 == 0.0 && t3 == 0.0 => {
                (t0 + amplitude, t0)
            }
            Shape::Draining { root, fill, drain } => {
                let end = (fill / drain).max(0.0);
                (root * root, end * end)
            }
            _ => return None,
        };
        let (one, other) = (self.offset + self.scale * one, self.offset + self.scale * other);
        let room = 1e-9 * (libm::fabs(one) + libm::fabs(other) + libm::fabs(self.offset));
        Some((one.min(other) - room, one.max(other) + room))
    }

    /// About the seconds after its beginning at which it is `level`, where its equation can be solved for that.
    fn guess(&self, level: f64) -> Option<f64> {
        let wanted = (level - self.offset) / self.scale;
        match self.shape {
            Shape::Sum { terms: [t0, t1, t2, t3], amplitude, tau } if t2 == 0.0 && t3 == 0.0 => {
                if amplitude == 0.0 {
                    Some((wanted - t0) / t1)
                } else {
                    (t1 == 0.0).then(|| tau * libm::log(amplitude / (wanted - t0)))
                }
            }
            Shape::Draining { root, fill, drain } => {
                Some(drained_to(root, fill, drain, libm::sqrt(wanted.max(0.0))))
            }
            _ => None,
        }
    }

    /// Two nanoseconds within the limits and about `s` seconds after the beginning, with the first at which the value has reached
    /// what `reached` says after one and not after the other. It is so at the upper limit, and not at the lower one.
    fn around(&self, s: f64, limits: (i64, i64), reached: &dyn Fn(f64) -> bool) -> (i64, i64) {
        let (mut before, mut there) = limits;
        let nanos = libm::round(s * NANOS);
        if !(nanos >= 0.0 && nanos < there as f64) {
            return limits;
        }
        let middle = self.since.as_nanos().saturating_add(nanos as i64);
        let mut width = 1i64;
        // Twice as far each time: a guess is good to some nanoseconds.
        loop {
            let (low, high) = (middle.saturating_sub(width), middle.saturating_add(width));
            let mut is_around = true;
            if low > before {
                if reached(self.value(Time::from_nanos(low))) {
                    (there, is_around) = (there.min(low), false);
                } else {
                    before = low;
                }
            }
            if is_around && high < there {
                if reached(self.value(Time::from_nanos(high))) {
                    there = high;
                } else {
                    (before, is_around) = (before.max(high), false);
                }
            }
            if is_around || width > i64::MAX / 2 {
                return (before, there);
            }
            width *= 2;
        }
    }

    /// The seconds after `from` at which the course turns next.
    fn turn(&self, from: f64) -> Option<f64> {
        let later = |s: f64| (s.is_finite() && s > from).then_some(s);
        match self.shape {
            Shape::Sum { terms: [_, t1, t2, t3], amplitude, tau } => {
                let zeros = zeros(&[t1, 2.0 * t2, 3.0 * t3], -amplitude / tau, tau, from);
                zeros.list().first().copied()
            }
            Shape::Draining { .. } => None,
            Shape::Oscillation { decay, angular, cosine, sine } => {
                // Of the slope: (angular sine - decay cosine) cos = (angular cosine + decay sine) sin.
                let first =
                    libm::atan2(angular * sine - decay * cosine, angular * cosine + decay * sine) / angular;
                let half = std::f64::consts::PI / angular;
                let number = libm::floor((from - first) / half) + 1.0;
                // Where rounding brings the turn itself again, it is the one after.
                let next = later(first + number * half).or_else(|| later(first + (number + 1.0) * half));
                next.filter(|turn| *turn <= SETTLED / decay + half)
            }
            Shape::Critical { decay, constant, linear } => later(1.0 / decay - constant / linear),
            Shape::TwoDecays { fast, slow, one, other } => {
                later(libm::log(-fast * one / (slow * other)) / (fast - slow))
            }
        }
    }
}

/// Up to four instants, in order.
#[derive(Clone, Copy, Debug, Default)]
struct Zeros {
    list: [f64; 4],
    count: usize,
}

impl Zeros {
    fn push(&mut self, at: f64) {
        if let Some(place) = self.list.get_mut(self.count) {
            *place = at;
            self.count += 1;
        }
    }

    fn list(&self) -> &[f64] {
        &self.list[..self.count]
    }
}

/// The seconds after `from` at which `t0 + t1 s + t2 s^2 + amplitude exp(-s / tau)`, of at most three terms, is 0. Between the
/// zeros of its slope, which is of the same form with one term less, it is monotone.
fn zeros(terms: &[f64], amplitude: f64, tau: f64, from: f64) -> Zeros {
    let value = |s: f64| {
        let sum = terms.iter().rev().fold(0.0, |sum, term| sum * s + term);
        if amplitude == 0.0 { sum } else { sum + amplitude * libm::exp(-s / tau) }
    };
    let mut found = Zeros::default();
    if terms.iter().skip(1).all(|term| *term == 0.0) {
        let base = terms.first().copied().unwrap_or(0.0);
        let zero = if amplitude == 0.0 { f64::NAN } else { -tau * libm::log(-base / amplitude) };
        if zero.is_finite() && zero > from {
            found.push(zero);
        }
        return found;
    }
    let mut slope = [0.0; 2];
    for (n, term) in terms.iter().enumerate().skip(1) {
        slope[n - 1] = n as f64 * term;
    }
    let bends = zeros(&slope[..terms.len() - 1], -amplitude / tau, tau, from);
    let mut left = from;
    for right in bends.list().iter().copied().chain([FAR]) {
        let (at_left, at_right) = (value(left), value(right));
        if at_left == 0.0 && left > from {
            found.push(left);
        }
        if (at_left < 0.0 && at_right > 0.0) || (at_left > 0.0 && at_right < 0.0) {
            let (mut low, mut high) = (left, right);
            loop {
                let middle = low + (high - low) / 2.0;
                if middle <= low || middle >= high {
                    break;
                }
                if (value(middle) > 0.0) == (at_left > 0.0) { low = middle } else { high = middle }
            }
            found.push(high);
        }
        left = right;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: f64 = 1e-4;

    fn at(seconds: f64) -> Time {
        Time::from_nanos((seconds * NANOS) as i64)
    }

    /// The slope that an equation gives at a time in seconds and a value.
    type Slope = fn(f64, f64) -> f64;

    /// Every shape, with the slope that its equation gives it.
    fn courses() -> Vec<(Course, Slope)> {
        let zero = Time::ZERO;
        vec![
            (Course::lag(zero, 3.0, 1.0, 0.5), |_, y| (1.0 - y) / 0.5),
            (Course::polynomial(zero, [1.0, -2.0, 0.5, 0.25]), |s, _| -2.0 + s + 0.75 * s * s),
            (Course::draining(zero, 2.0, 0.0, 0.4), |_, y| -0.4 * y.max(0.0).sqrt()),
            (Course::draining(zero, 2.0, 0.3, 0.4), |_, y| 0.3 - 0.4 * y.max(0.0).sqrt()),
            (Course::draining(zero, 0.1, 0.3, 0.4), |_, y| 0.3 - 0.4 * y.max(0.0).sqrt()),
            (
                Course::draining(zero, 0.5, -0.1, 0.4),
                |_, y| {
                    if y <= 0.0 { 0.0 } else { -0.1 - 0.4 * y.sqrt() }
                },
            ),
        ]
    }

    #[test]
    fn courses_solve_their_equations() {
        for (course, slope) in courses() {
            let mut y = course.value(Time::ZERO);
            let steps = 30_000;
            for step in 0..steps {
                let s = f64::from(step) * S;
                // Heun's method: two looks at the slope for each step.
                let first = slope(s, y);
                let next = (y + S * first).max(if matches!(course.shape, Shape::Draining { .. }) {
                    0.0
                } else {
                    f64::MIN
                });
                y += S * (first + slope(s + S, next)) / 2.0;
                if step % 1_000 == 0 {
                    let exact = course.value(at(s + S));
                    assert!((exact - y).abs() < 1e-4, "{course:?} at {s}: {exact} {y}");
                }
            }
        }
    }

    #[test]
    fn second_order_responses_solve_their_equation() {
        for damping in [0.05, 0.3, 0.99, 1.0, 1.01, 3.0] {
            let w = 4.0;
            let course = Course::second_order(Time::ZERO, 1.0, 2.0, 5.0, w, damping);
            let (mut y, mut v) = (1.0f64, 2.0f64);
            let slope = |y: f64, v: f64| w * w * (5.0 - y) - 2.0 * damping * w * v;
            for step in 0..30_000 {
                let a = slope(y, v);
                let (y1, v1) = (y + S * v, v + S * a);
                let b = slope(y1, v1);
                y += S * (v + v1) / 2.0;
                v += S * (a + b) / 2.0;
                if step % 1_000 == 0 {
                    let now = at(f64::from(step + 1) * S);
                    assert!((course.value(now) - y).abs() < 1e-4, "{damping} {} {y}", course.value(now));
                    assert!((course.slope(now) - v).abs() < 1e-3, "{damping} {} {v}", course.slope(now));
                }
            }
        }
    }

    /// The first instants of all courses against a look at every tenth of a millisecond.
    #[test]
    fn instants_are_the_first() {
        let zero = Time::ZERO;
        let mut all: Vec<Course> = courses().into_iter().map(|(course, _)| course).collect();
        all.extend(
            [0.05, 0.3, 1.0, 2.0].map(|damping| Course::second_order(zero, 1.0, 2.0, 5.0, 4.0, damping)),
        );
        all.extend([0.2, 1.0].map(|damping| Course::second_order(zero, 1.0, -20.0, 5.0, 4.0, damping)));
        all.push(Course::lag(zero, 0.0, 2.0, 0.4).integral(zero, -0.5).unwrap());
        let slow = Course::line(zero, 0.0, -1.0).plus(&Course::lag(zero, 3.0, 0.0, 0.7), zero).unwrap();
        all.push(slow);
        all.push(slow.mapped(1.0, -3.0));
        for course in all {
            for level in [-3.0, -1.0, 0.0, 0.2, 0.5, 0.9, 1.3, 2.0, 4.0, 6.0, 8.0] {
                for rising in [true, false] {
                    let reached = |value: f64| if rising { value >= level } else { value <= level };
                    let found =
                        if rising { course.rises_to(level, zero) } else { course.falls_to(level, zero) };
                    let looked = (1..40_000).map(|n| f64::from(n) * S).find(|s| reached(course.at(*s)));
                    match (found, looked) {
                        (Some(found), Some(looked)) => {
                            let found = seconds(zero, found);
                            assert!(
                                found <= looked + 1e-9 && found > looked - S - 1e-9,
                                "{course:?} {level} {found} {looked}"
                            );
                        }
                        // What lies beyond the looks, or between two of them.
                        (Some(found), None) => {
                            assert!(reached(course.value(found)), "{course:?} {level} {found:?}");
                        }
                        (None, looked) => assert_eq!(looked, None, "{course:?} {level}"),
                    }
                }
            }
        }
    }

    /// Against the square root of the level as a line, to which an outflow comes with hardly any drain; against an integration
    /// that is exact where the drain is a part in a million.
    #[test]
    fn a_weak_drain_keeps_its_digits() {
        for drain in [1e-4, 1e-6, 1e-9, 1e-12] {
            let (level, fill, s) = (0.25, 1e-3, 400.0);
            let course = Course::draining(Time::ZERO, level, fill, drain);
            // h = level + fill s - drain (2 / 3 fill) ((level + fill s)^1.5 - level^1.5), but for the square of the drain.
            let end = level + fill * s;
            let first = drain * 2.0 / 3.0 / fill * (libm::pow(end, 1.5) - libm::pow(level, 1.5));
            let error = libm::fabs(course.value(at(s)) - (end - first));
            assert!(error < 1e-14 + first * first, "{drain}: {error}");
        }
        let resting = Course::draining(Time::ZERO, 0.5, 0.3, 0.4);
        assert!(resting.is_settled(at(1e4)));
    }

    /// A search that begins at a guess finds the nanosecond that one without it finds.
    #[test]
    fn a_guess_does_not_change_what_is_found() {
        let mut random = signal::Random::new(24);
        let mut part = |least: f64, most: f64| {
            least + (most - least) * (random.below(1 << 32) as f64 / (1u64 << 32) as f64)
        };
        let mut found = 0;
        for _ in 0..3_000 {
            let since = at(part(0.0, 10.0));
            let course = match part(0.0, 3.0) {
                kind if kind < 1.0 => Course::lag(since, part(-5.0, 5.0), part(-5.0, 5.0), part(1e-3, 100.0)),
                kind if kind < 2.0 => Course::line(since, part(-5.0, 5.0), part(-1.0, 1.0)),
                _ => Course::draining(since, part(0.0, 2.0), part(-0.1, 0.3), part(1e-3, 0.3)),
            };
            let course = course.mapped(part(-1.0, 1.0), part(-2.0, 2.0));
            let (level, after) = (part(-5.0, 5.0), at(part(0.0, 20.0)));
            for rising in [true, false] {
                let reached = |value: f64| if rising { value >= level } else { value <= level };
                let guessed = course.first(after, level, &reached);
                let searched = course.first(after, f64::NAN, &reached);
                // Where rounding has the value pass the level several times, both are such a passage.
                let near = match (guessed, searched) {
                    (Some(guessed), Some(searched)) => {
                        let apart = guessed.as_nanos().abs_diff(searched.as_nanos());
                        let before = Time::from_nanos(guessed.as_nanos() - 1);
                        let first = guessed.as_nanos() == after.as_nanos().max(since.as_nanos()) + 1;
                        apart == 0
                            || reached(course.value(guessed)) && (first || !reached(course.value(before)))
                    }
                    (guessed, searched) => guessed == searched,
                };
                assert!(near, "{course:?} {level} {after:?}: {guessed:?} {searched:?}");
                found += u32::from(guessed.is_some());
            }
        }
        assert!(found > 1_000, "{found}");
    }

    #[test]
    fn what_settles_is_there() {
        for damping in [0.3, 1.0, 2.0] {
            let course = Course::second_order(Time::ZERO, 1.0, 0.0, 5.0, 4.0, damping);
            assert!(!course.is_settled(at(0.1)));
            assert!(course.is_settled(at(200.0)), "{damping}");
        }
        assert!(Course::draining(Time::ZERO, 1.0, 0.0, 1.0).is_settled(at(2.1)));
        assert!(!Course::line(Time::ZERO, 1.0, 1.0).is_settled(at(1e6)));
    }

    #[test]
    fn courses_add_up_from_a_later_instant() {
        let course = Course::polynomial(at(1.0), [1.0, 2.0, 0.5, 0.0]);
        let lag = Course::lag(at(0.5), 4.0, 1.0, 0.3);
        let sum = course.plus(&lag, at(2.0)).unwrap();
        assert!((sum.value(at(3.5)) - course.value(at(3.5)) - lag.value(at(3.5))).abs() < 1e-12);
        assert_eq!(sum.plus(&Course::lag(at(0.0), 1.0, 0.0, 0.4), at(2.0)), None);
        assert_eq!(sum.plus(&Course::draining(at(0.0), 1.0, 0.0, 0.4), at(2.0)), None);
        let area = sum.integral(at(2.0), 7.0).unwrap();
        let steps = 100_000;
        let width = 1.5 / f64::from(steps);
        let middle = |n: i32| 2.0 + (f64::from(n) + 0.5) * width;
        let summed: f64 = (0..steps).map(|n| width * sum.value(at(middle(n)))).sum();
        assert!((area.value(at(3.5)) - 7.0 - summed).abs() < 1e-6);
        assert_eq!(course.delayed(Span::from_secs(2)).value(at(5.0)), course.value(at(3.0)));
    }
}
