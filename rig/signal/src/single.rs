//! Numbers of 32 bits as numbers of 64 bits.

use std::fmt::Write;

/// A number with a fraction has at most 9 digits, a sign, a point and an exponent of two digits with its sign.
const LONGEST: usize = 24;

/// The number of 64 bits that a REAL stands for: that of the shortest decimal number which is read as it, 21.6 and not
/// 21.600000381469727; a whole number is itself. Made a REAL again it is the same.
pub fn of_single(real: f32) -> f64 {
    let exact = f64::from(real);
    if exact.fract() == 0.0 || !exact.is_finite() {
        return exact;
    }
    let mut text = Text { bytes: [0; LONGEST], length: 0 };
    let written = write!(text, "{real:e}");
    let digits = std::str::from_utf8(text.bytes.get(..text.length).unwrap_or_default());
    let shortest = digits.ok().filter(|_| written.is_ok()).and_then(|digits| digits.parse().ok());
    shortest.unwrap_or(exact)
}

/// Room for a number without the heap: values are read in the scan.
struct Text {
    bytes: [u8; LONGEST],
    length: usize,
}

impl Write for Text {
    fn write_str(&mut self, text: &str) -> std::fmt::Result {
        let end = self.length + text.len();
        self.bytes.get_mut(self.length..end).ok_or(std::fmt::Error)?.copy_from_slice(text.as_bytes());
        self.length = end;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_real_is_the_decimal_that_was_written() {
        for (real, number) in [
            (0.1_f32, 0.1_f64),
            (21.6, 21.6),
            (-0.7, -0.7),
            (1.5, 1.5),
            (16_777_216.0, 16_777_216.0),
            (3.402_823_5e38, f64::from(f32::MAX)),
            (1.175_494_4e-38, 1.175_494_4e-38),
            (-1.234_567_9e-38, -1.234_567_9e-38),
        ] {
            assert_eq!(of_single(real), number, "{real}");
        }
        assert!(of_single(f32::NAN).is_nan() && of_single(-0.0).is_sign_negative());
        assert_eq!(of_single(f32::NEG_INFINITY), f64::NEG_INFINITY);
    }

    proptest! {
        #[test]
        fn it_is_the_same_real_again(bits: u32) {
            let real = f32::from_bits(bits);
            let number = of_single(real);
            prop_assert!(number as f32 == real || real.is_nan() && number.is_nan());
            if real.fract() != 0.0 && real.is_finite() {
                prop_assert_eq!(number, format!("{real}").parse::<f64>().unwrap());
            }
        }
    }
}
