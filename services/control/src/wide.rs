//! Numbers of some 32 digits: the unevaluated sum of two `f64`s.
//!
//! A plant of twenty poles near z = 1 has responses that `f64` cannot tell from its rounding; with twice the
//! digits they are exact to `f64`. Sums and products are those of T. J. Dekker (1971) and Y. Hida, X. S. Li and
//! D. H. Bailey (2001). There are only the operations that the analysis needs, and no functions but the root.

pub(crate) mod matrix;

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use nalgebra::Complex;

/// A real number of some 32 digits.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Wide {
    high: f64,
    low: f64,
}

/// The sum of two numbers and what rounding took from it.
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let of_b = sum - a;
    (sum, (a - (sum - of_b)) + (b - of_b))
}

/// The same where `a` is not smaller than `b` in magnitude.
fn quick_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    (sum, b - (sum - a))
}

/// Both halves of a number, 26 bits each.
fn halves(a: f64) -> (f64, f64) {
    const SPLIT: f64 = 134_217_729.0;
    let scaled = SPLIT * a;
    let high = scaled - (scaled - a);
    (high, a - high)
}

/// The product of two numbers and what rounding took from it. Not by `mul_add`, which is a slow call on
/// processors without that instruction.
fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    let ((a_high, a_low), (b_high, b_low)) = (halves(a), halves(b));
    let off = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low;
    (product, off)
}

impl Wide {
    pub(crate) const ZERO: Self = Self {
        high: 0.0,
        low: 0.0,
    };
    pub(crate) const ONE: Self = Self {
        high: 1.0,
        low: 0.0,
    };

    fn renormalised(high: f64, low: f64) -> Self {
        let (high, low) = quick_sum(high, low);
        Self { high, low }
    }

    /// The nearest `f64`.
    pub(crate) fn rounded(self) -> f64 {
        self.high
    }

    pub(crate) fn is_zero(self) -> bool {
        self.high == 0.0
    }

    /// The product with a power of two, which is exact.
    pub(crate) fn scaled(self, power_of_two: f64) -> Self {
        Self {
            high: self.high * power_of_two,
            low: self.low * power_of_two,
        }
    }

    /// The root of a number that is not negative.
    pub(crate) fn sqrt(self) -> Self {
        if self.high <= 0.0 {
            return Self::ZERO;
        }
        let root = Self::from(self.high.sqrt());
        // One step of Newton's doubles the digits.
        (root + self / root).scaled(0.5)
    }
}

impl From<f64> for Wide {
    fn from(high: f64) -> Self {
        Self { high, low: 0.0 }
    }
}

impl Add for Wide {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let (high, off) = two_sum(self.high, other.high);
        let (low, more) = two_sum(self.low, other.low);
        let (high, off) = quick_sum(high, off + low);
        Self::renormalised(high, off + more)
    }
}

impl Neg for Wide {
    type Output = Self;

    fn neg(self) -> Self {
        Self {
            high: -self.high,
            low: -self.low,
        }
    }
}

impl Sub for Wide {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Wide {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let (high, low) = two_product(self.high, other.high);
        Self::renormalised(high, low + (self.high * other.low + self.low * other.high))
    }
}

impl Div for Wide {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        let first = self.high / other.high;
        let rest = self - other * Self::from(first);
        let second = rest.high / other.high;
        let rest = rest - other * Self::from(second);
        Self::renormalised(first, second) + Self::from(rest.high / other.high)
    }
}

impl AddAssign for Wide {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Wide {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

/// A complex number of some 32 digits.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct WideComplex {
    pub(crate) re: Wide,
    pub(crate) im: Wide,
}

impl WideComplex {
    pub(crate) const ZERO: Self = Self {
        re: Wide::ZERO,
        im: Wide::ZERO,
    };

    /// The nearest complex number of two `f64`s.
    pub(crate) fn rounded(self) -> Complex<f64> {
        Complex::new(self.re.rounded(), self.im.rounded())
    }

    /// |re| + |im|, about: a size to choose pivots by.
    pub(crate) fn size(self) -> f64 {
        self.re.rounded().abs() + self.im.rounded().abs()
    }
}

impl From<Complex<f64>> for WideComplex {
    fn from(number: Complex<f64>) -> Self {
        Self {
            re: number.re.into(),
            im: number.im.into(),
        }
    }
}

impl From<Wide> for WideComplex {
    fn from(re: Wide) -> Self {
        Self { re, im: Wide::ZERO }
    }
}

impl Add for WideComplex {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            re: self.re + other.re,
            im: self.im + other.im,
        }
    }
}

impl Sub for WideComplex {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self {
            re: self.re - other.re,
            im: self.im - other.im,
        }
    }
}

impl Mul for WideComplex {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Self {
            re: self.re * other.re - self.im * other.im,
            im: self.re * other.im + self.im * other.re,
        }
    }
}

impl Mul<Wide> for WideComplex {
    type Output = Self;

    fn mul(self, other: Wide) -> Self {
        Self {
            re: self.re * other,
            im: self.im * other,
        }
    }
}

impl Div for WideComplex {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        let norm = other.re * other.re + other.im * other.im;
        let over = Self {
            re: other.re / norm,
            im: -other.im / norm,
        };
        self * over
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_third_has_thirty_digits_and_the_root_of_two_too() {
        let third = Wide::ONE / Wide::from(3.0);
        let off = third * Wide::from(3.0) - Wide::ONE;
        assert!(off.rounded().abs() < 1e-31, "{off:?}");
        let root = Wide::from(2.0).sqrt();
        let off = root * root - Wide::from(2.0);
        assert!(off.rounded().abs() < 1e-30, "{off:?}");
    }

    #[test]
    fn what_is_added_to_a_large_number_is_there_when_that_is_taken_away() {
        let sum = Wide::from(1e12) + Wide::from(1e-12);
        assert_eq!((sum - Wide::from(1e12)).rounded(), 1e-12);
    }

    #[test]
    fn a_quotient_of_complex_numbers_times_its_divisor_is_the_dividend() {
        let (a, b) = (Complex::new(3.0, -0.7), Complex::new(-0.2, 1.1));
        let b = WideComplex::from(b);
        let back = WideComplex::from(a) / b * b;
        assert!((back - WideComplex::from(a)).size() < 1e-30);
    }
}
