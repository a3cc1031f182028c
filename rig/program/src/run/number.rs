//! Arithmetic that the language defines more closely than the host does.

/// The one NaN of a type: which NaN an operation gives differs between hosts.
pub(super) trait Canonical: Copy {
    fn canonical(self) -> Self;
}

/// Called, so that the test is a jump: what uses the number need not wait for its outcome.
#[cold]
#[inline(never)]
fn nan_f32() -> f32 {
    f32::from_bits(0x7FC0_0000)
}

#[cold]
#[inline(never)]
fn nan_f64() -> f64 {
    f64::from_bits(0x7FF8_0000_0000_0000)
}

impl Canonical for f32 {
    #[inline(always)]
    fn canonical(self) -> f32 {
        if self.is_nan() { nan_f32() } else { self }
    }
}

impl Canonical for f64 {
    #[inline(always)]
    fn canonical(self) -> f64 {
        if self.is_nan() { nan_f64() } else { self }
    }
}

/// What is stored of a number: whole numbers as they are, real ones as their bits.
pub(super) trait RawNumber {
    type Bits;
    fn raw(self) -> Self::Bits;
}

macro_rules! raw {
    ($($ty:ident => $bits:ident, |$n:ident| $raw:expr;)*) => {
        $(impl RawNumber for $ty {
            type Bits = $bits;
            #[inline(always)]
            fn raw(self) -> $bits {
                let $n = self;
                $raw
            }
        })*
    };
}

raw! {
    u8 => u8, |n| n;
    u16 => u16, |n| n;
    u32 => u32, |n| n;
    u64 => u64, |n| n;
    i8 => i8, |n| n;
    i16 => i16, |n| n;
    i32 => i32, |n| n;
    i64 => i64, |n| n;
    f32 => u32, |n| n.to_bits();
    f64 => u64, |n| n.to_bits();
}

/// Least and greatest of two real numbers: NaN if one is NaN, and -0 is less than 0.
macro_rules! order {
    ($ty:ident, $min:ident, $max:ident) => {
        #[inline]
        pub(super) fn $min(a: $ty, b: $ty) -> $ty {
            if a.is_nan() || b.is_nan() {
                $ty::NAN.canonical()
            } else if a < b || (a == b && a.is_sign_negative()) {
                a
            } else {
                b
            }
        }

        #[inline]
        pub(super) fn $max(a: $ty, b: $ty) -> $ty {
            if a.is_nan() || b.is_nan() {
                $ty::NAN.canonical()
            } else if a > b || (a == b && b.is_sign_negative()) {
                a
            } else {
                b
            }
        }
    };
}

order!(f32, min_f32, max_f32);
order!(f64, min_f64, max_f64);

/// A shift count; `None` where every bit is shifted out.
#[inline(always)]
pub(super) fn shift(n: i64, bits: u32) -> Option<u32> {
    u32::try_from(n).ok().filter(|n| *n < bits)
}

/// The count of a shift that fills with the sign, `None` for what gives 0.
#[inline(always)]
pub(super) fn spread(n: i64, bits: u32) -> Option<u32> {
    (n >= 0).then(|| n.min(i64::from(bits) - 1) as u32)
}

/// A rotation's count.
#[inline(always)]
pub(super) fn turn(n: i64, bits: u32) -> u32 {
    n.rem_euclid(i64::from(bits)) as u32
}
