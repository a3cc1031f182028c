//! The level of a tank that empties by its own weight.

/// The most steps of Newton's method: of each that is taken at least one digit comes.
const MAX_STEPS: usize = 100;

/// The root of the level of a tank that empties by its own weight, `s` seconds after it was `root`.
pub(super) fn drained(root: f64, fill: f64, drain: f64, s: f64) -> f64 {
    if fill == 0.0 {
        return (root - drain * s / 2.0).max(0.0);
    }
    let rest = fill / drain;
    if root == rest || s <= 0.0 {
        return root;
    }
    if rest < 0.0 && s >= drained_to(root, fill, drain, 0.0) {
        return 0.0;
    }
    // Of the part of its way that is left, exp(y), is known that away (exp(y) - 1 - y) + root y + drain s / 2 = 0, written so that
    // nothing cancels where the rest is far away. The sum bends one way only: Newton's method comes to its zero from where it
    // begins, without passing it but by rounding.
    let away = root - rest;
    let passed = drain * s / 2.0;
    let (a, k) = (away / rest, passed / rest);
    // Where it would be if it moved on as fast as it does from `root`. The sum has the sign there that it has at the other
    // beginning, so the zero lies beyond both: the nearer one saves steps.
    let first = -passed / root;
    let (mut y, upwards) = if a > 0.0 {
        ((a - k).min(first), -1.0)
    } else if a < -1.0 {
        (first, -1.0)
    } else {
        ((a - k).max(first), 1.0)
    };
    let mut grown = 0.0;
    for _ in 0..MAX_STEPS {
        let less;
        (grown, less) = expm1_and_less(y);
        let step = -(away * less + root * y + passed) / (root + away * grown);
        let goes_on = step * upwards > 2.0 * f64::EPSILON * libm::fabs(y);
        if !goes_on {
            break;
        }
        y += step;
    }
    // It moves from `root` towards `rest`, and not beyond 0.
    let u = if y < -1.0 { rest + away * libm::exp(y) } else { root + away * grown };
    u.max(0.0)
}

/// The seconds after which the root of such a level has come from `root` to `u`, which lies on its way.
pub(super) fn drained_to(root: f64, fill: f64, drain: f64, u: f64) -> f64 {
    if fill == 0.0 {
        return 2.0 * (root - u) / drain;
    }
    // -(2 / drain) (u - root + rest ln((u - rest) / (root - rest))), written so that nothing cancels where the rest is far away.
    let away = root - fill / drain;
    let part = (u - root) / away;
    -2.0 / drain * (away * less_log1p(part) + root * libm::log1p(part))
}

/// `x - ln(1 + x)`, with all its digits also near 0.
fn less_log1p(x: f64) -> f64 {
    if libm::fabs(x) > 0.1 {
        return x - libm::log1p(x);
    }
    // x^2 / 2 - x^3 / 3 + x^4 / 4 and so on: what comes after 18 terms is less than rounding.
    let sum = (2..20).rev().fold(0.0, |sum, n| 1.0 / f64::from(n) - x * sum);
    x * x * sum
}

/// What `x^2`, `x^3` and so on are multiplied by in `exp(x) - 1 - x`: 1 / 2!, 1 / 3! and so on.
const FACTORS: [f64; 10] = {
    let (mut factors, mut product, mut n) = ([0.0; 10], 2.0, 0);
    while n < factors.len() {
        factors[n] = 1.0 / product;
        product *= n as f64 + 3.0;
        n += 1;
    }
    factors
};

/// `exp(x) - 1`, and `exp(x) - 1 - x`, with all their digits also near 0.
fn expm1_and_less(x: f64) -> (f64, f64) {
    let size = libm::fabs(x);
    if size > 0.1 {
        let grown = libm::expm1(x);
        return (grown, grown - x);
    }
    // What comes after these factors is less than rounding. They are multiplied and not divided by: each division of a series
    // would wait for the one before.
    let factors = if size > 1e-3 { &FACTORS[..] } else { &FACTORS[..5] };
    let less = x * x * factors.iter().rev().fold(0.0, |sum, factor| sum * x + factor);
    (x + less, less)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The root after a time against a search for it by the time that it takes to each root.
    #[test]
    fn a_level_by_its_own_weight_is_the_one_that_takes_the_time() {
        for root in [0.0, 1e-6, 0.3, 1.0, 4.0] {
            for fill in [-2.0, -0.3, -1e-6, 1e-6, 0.1, 0.35, 2.0] {
                for drain in [1e-3, 0.2, 1.0] {
                    for s in [1e-9, 1e-4, 0.02, 0.7, 5.0, 60.0, 3600.0, 1e7] {
                        let (mut near, mut far) = (root, f64::max(fill / drain, 0.0));
                        if fill < 0.0 && s >= drained_to(root, fill, drain, 0.0) {
                            near = 0.0;
                        }
                        for _ in 0..200 {
                            let middle = near + (far - near) / 2.0;
                            let early = drained_to(root, fill, drain, middle) < s;
                            if early { near = middle } else { far = middle }
                        }
                        let found = drained(root, fill, drain, s);
                        let what = format!("{root} {fill} {drain} {s}: {found} {near}");
                        // Either is exact where the other is not: the root, and the time that it takes.
                        let is_there = (found - near).abs() < 1e-7 * root.max(near).max(1e-9);
                        let rounding = 1e-14 * (root + (fill / drain).abs()) / drain;
                        let takes = drained_to(root, fill, drain, found);
                        assert!(is_there || (takes - s).abs() < 1e-9 * s + rounding, "{what} {takes}");
                        assert!(found >= 0.0, "{what}");
                    }
                }
            }
        }
    }
    /// Against `expm1`, and against the series with the last of its terms first, each made of the one before.
    #[test]
    fn both_parts_of_an_exponential_have_all_their_digits() {
        for exponent in -40..8 {
            for part in [1.0, 1.02, 1.3, 1.77] {
                for x in [part, -part].map(|part| part * f64::from(exponent).exp2()) {
                    let (grown, less) = expm1_and_less(x);
                    let exact = libm::expm1(x);
                    assert!(
                        (grown - exact).abs() <= 2.0 * f64::EPSILON * exact.abs(),
                        "{x}: {grown} {exact}"
                    );
                    if x.abs() > 0.1 {
                        assert_eq!(less, exact - x, "{x}");
                        continue;
                    }
                    let sum = (3..20).rev().fold(0.0, |sum, n| (1.0 + sum) * x / f64::from(n));
                    let exact = x * x / 2.0 * (1.0 + sum);
                    assert!((less - exact).abs() <= 4.0 * f64::EPSILON * exact, "{x}: {less} {exact}");
                }
            }
        }
    }
}
