//! The kinds of number that an expression can be worked out with.

use super::{Binary, Unary};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// What expressions are evaluated with.
pub trait Number: Copy {
    /// This value everywhere.
    #[must_use]
    fn constant(value: f64) -> Self;
    /// A function of this.
    #[must_use]
    fn unary(self, function: Unary) -> Self;
    /// A function of this and another.
    #[must_use]
    fn binary(self, function: Binary, other: Self) -> Self;
    /// To a whole power.
    #[must_use]
    fn power(self, power: i32) -> Self;
}

impl Number for f64 {
    fn constant(value: f64) -> Self {
        value
    }

    fn unary(self, function: Unary) -> Self {
        match function {
            Unary::Negate => -self,
            Unary::Abs => self.abs(),
            Unary::Sqrt => self.sqrt(),
            Unary::Exp => self.exp(),
            Unary::Log => self.ln(),
            Unary::Sin => self.sin(),
            Unary::Cos => self.cos(),
            Unary::Tan => self.tan(),
        }
    }

    fn binary(self, function: Binary, other: Self) -> Self {
        match function {
            Binary::Add => self + other,
            Binary::Subtract => self - other,
            Binary::Multiply => self * other,
            Binary::Divide => self / other,
            Binary::Power => self.powf(other),
            // What is no number stays none, unlike in f64::min.
            Binary::Min | Binary::Max if self.is_nan() || other.is_nan() => Self::NAN,
            Binary::Min => self.min(other),
            Binary::Max => self.max(other),
            Binary::Atan2 => self.atan2(other),
        }
    }

    fn power(self, power: i32) -> Self {
        self.powi(power)
    }
}

/// Eight values side by side: the cost of going through the operations is shared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lanes(pub [f64; Lanes::COUNT]);

impl Lanes {
    /// How many.
    pub const COUNT: usize = 8;

    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self(self.0.map(f))
    }

    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self(std::array::from_fn(|i| f(self.0[i], other.0[i])))
    }
}

impl Number for Lanes {
    fn constant(value: f64) -> Self {
        Self([value; Self::COUNT])
    }

    // One loop a function, so that each is a loop over numbers without a choice in it.
    fn unary(self, function: Unary) -> Self {
        match function {
            Unary::Negate => self.map(|a| -a),
            Unary::Abs => self.map(f64::abs),
            Unary::Sqrt => self.map(f64::sqrt),
            other => self.map(|a| a.unary(other)),
        }
    }

    fn binary(self, function: Binary, other: Self) -> Self {
        match function {
            Binary::Add => self.zip(other, |a, b| a + b),
            Binary::Subtract => self.zip(other, |a, b| a - b),
            Binary::Multiply => self.zip(other, |a, b| a * b),
            Binary::Divide => self.zip(other, |a, b| a / b),
            function => self.zip(other, |a, b| a.binary(function, b)),
        }
    }

    fn power(self, power: i32) -> Self {
        match power {
            2 => self.map(|a| a * a),
            3 => self.map(|a| a * a * a),
            4 => self.map(|a| (a * a) * (a * a)),
            _ => self.map(|a| a.powi(power)),
        }
    }
}

/// A value and its derivatives by `N` variables: forward automatic differentiation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dual<const N: usize> {
    /// The value.
    pub value: f64,
    /// Its derivatives.
    pub slopes: [f64; N],
}

impl<const N: usize> Dual<N> {
    /// The variable of number `index` where it has this value.
    #[must_use]
    pub fn variable(value: f64, index: usize) -> Self {
        Self { value, slopes: std::array::from_fn(|i| f64::from(u8::from(i == index))) }
    }

    /// A function's value, and its derivative there times this one's.
    fn chain(self, value: f64, slope: f64) -> Self {
        Self { value, slopes: self.slopes.map(|s| s * slope) }
    }

    /// As [`Dual::chain`] for a function of two.
    fn chain2(self, other: Self, value: f64, [slope, other_slope]: [f64; 2]) -> Self {
        Self { value, slopes: std::array::from_fn(|i| self.slopes[i] * slope + other.slopes[i] * other_slope) }
    }
}

impl<const N: usize> Number for Dual<N> {
    fn constant(value: f64) -> Self {
        Self { value, slopes: [0.0; N] }
    }

    fn unary(self, function: Unary) -> Self {
        let a = self.value;
        let value = a.unary(function);
        match function {
            Unary::Negate => self.chain(value, -1.0),
            // At the kink the mean of both sides' slopes.
            Unary::Abs => self.chain(value, if a == 0.0 { 0.0 } else { a.signum() }),
            Unary::Sqrt => self.chain(value, 0.5 / value),
            Unary::Exp => self.chain(value, value),
            Unary::Log => self.chain(value, 1.0 / a),
            Unary::Sin => self.chain(value, a.cos()),
            Unary::Cos => self.chain(value, -a.sin()),
            Unary::Tan => self.chain(value, 1.0 + value * value),
        }
    }

    fn binary(self, function: Binary, other: Self) -> Self {
        let (a, b) = (self.value, other.value);
        let value = a.binary(function, b);
        match function {
            Binary::Add => self.chain2(other, value, [1.0, 1.0]),
            Binary::Subtract => self.chain2(other, value, [1.0, -1.0]),
            Binary::Multiply => self.chain2(other, value, [b, a]),
            Binary::Divide => self.chain2(other, value, [1.0 / b, -value / b]),
            // A constant exponent needs no logarithm, which a base of 0 has not.
            Binary::Power if other.slopes == [0.0; N] => self.chain(value, b * a.powf(b - 1.0)),
            Binary::Power => self.chain2(other, value, [b * a.powf(b - 1.0), value * a.ln()]),
            Binary::Min => {
                if a <= b {
                    self
                } else {
                    other
                }
            }
            Binary::Max => {
                if a >= b {
                    self
                } else {
                    other
                }
            }
            Binary::Atan2 => {
                let square = a * a + b * b;
                self.chain2(other, value, [b / square, -a / square])
            }
        }
    }

    fn power(self, power: i32) -> Self {
        if power == 0 {
            return Self::constant(1.0);
        }
        let less = if power == 2 { self.value } else { self.value.powi(power - 1) };
        self.chain(less * self.value, f64::from(power) * less)
    }
}

/// Bounds of all the values that something takes. Where some of them may be no number, it is [`Interval::ALL`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// None is less.
    pub low: f64,
    /// None is greater.
    pub high: f64,
}

impl Interval {
    /// Nothing is known.
    pub const ALL: Self = Self { low: f64::NEG_INFINITY, high: f64::INFINITY };

    /// From the least to the greatest of these, [`Interval::ALL`] if one is no number.
    fn hull<const N: usize>(values: [f64; N]) -> Self {
        if values.iter().any(|v| v.is_nan()) {
            return Self::ALL;
        }
        let over = |f: fn(f64, f64) -> f64, start| values.into_iter().fold(start, f);
        Self { low: over(f64::min, f64::INFINITY), high: over(f64::max, f64::NEG_INFINITY) }
    }

    fn has(self, value: f64) -> bool {
        self.low <= value && value <= self.high
    }

    /// A function that grows.
    fn growing(self, f: impl Fn(f64) -> f64) -> Self {
        Self::hull([f(self.low), f(self.high)])
    }

    /// The sine: its ends, and 1 or −1 where a crest or trough lies between them.
    fn sine(self) -> Self {
        if !self.low.is_finite() || !self.high.is_finite() || self.high - self.low >= TAU {
            return Self { low: -1.0, high: 1.0 };
        }
        let has_crest = |first: f64| ((self.low - first) / TAU).ceil() * TAU + first <= self.high;
        let ends = self.growing(f64::sin);
        Self {
            low: if has_crest(-FRAC_PI_2) { -1.0 } else { ends.low },
            high: if has_crest(FRAC_PI_2) { 1.0 } else { ends.high },
        }
    }

    fn product(self, other: Self) -> Self {
        // Nought times a bound at infinity is nought: no value lies there.
        let times = |a: f64, b: f64| if a == 0.0 || b == 0.0 { 0.0 } else { a * b };
        Self::hull([
            times(self.low, other.low),
            times(self.low, other.high),
            times(self.high, other.low),
            times(self.high, other.high),
        ])
    }

    fn reciprocal(self) -> Self {
        if self.has(0.0) { Self::ALL } else { Self::hull([1.0 / self.low, 1.0 / self.high]) }
    }
}

impl Number for Interval {
    fn constant(value: f64) -> Self {
        Self::hull([value])
    }

    // What may be no number stays so, whatever is made of it.
    fn unary(self, function: Unary) -> Self {
        match function {
            _ if self == Self::ALL => self,
            Unary::Negate => Self { low: -self.high, high: -self.low },
            Unary::Abs if self.has(0.0) => Self { low: 0.0, high: self.high.max(-self.low) },
            Unary::Abs => Self::hull([self.low.abs(), self.high.abs()]),
            Unary::Sqrt if self.low < 0.0 => Self::ALL,
            Unary::Sqrt => self.growing(f64::sqrt),
            Unary::Exp => self.growing(f64::exp),
            Unary::Log if self.low <= 0.0 => Self::ALL,
            Unary::Log => self.growing(f64::ln),
            Unary::Sin => self.sine(),
            Unary::Cos => Self { low: self.low + FRAC_PI_2, high: self.high + FRAC_PI_2 }.sine(),
            Unary::Tan => {
                let pole = ((self.low - FRAC_PI_2) / PI).ceil() * PI + FRAC_PI_2;
                if pole <= self.high || !self.low.is_finite() { Self::ALL } else { self.growing(f64::tan) }
            }
        }
    }

    fn binary(self, function: Binary, other: Self) -> Self {
        match function {
            _ if self == Self::ALL || other == Self::ALL => Self::ALL,
            Binary::Add => Self::hull([self.low + other.low, self.high + other.high]),
            Binary::Subtract => Self::hull([self.low - other.high, self.high - other.low]),
            Binary::Multiply => self.product(other),
            Binary::Divide if other.has(0.0) => Self::ALL,
            Binary::Divide => self.product(other.reciprocal()),
            Binary::Power if self.low <= 0.0 => Self::ALL,
            Binary::Power => self.growing(f64::ln).product(other).growing(f64::exp),
            Binary::Min => Self { low: self.low.min(other.low), high: self.high.min(other.high) },
            Binary::Max => Self { low: self.low.max(other.low), high: self.high.max(other.high) },
            // The angle has a cut where y changes sign at negative x.
            Binary::Atan2 if other.low <= 0.0 && self.has(0.0) => Self { low: -PI, high: PI },
            Binary::Atan2 => Self::hull([
                self.low.atan2(other.low),
                self.low.atan2(other.high),
                self.high.atan2(other.low),
                self.high.atan2(other.high),
            ]),
        }
    }

    fn power(self, power: i32) -> Self {
        if self == Self::ALL {
            return self;
        }
        if power < 0 {
            return self.power(-power).reciprocal();
        }
        let ends = Self::hull([self.low.powi(power), self.high.powi(power)]);
        if power % 2 == 0 && power > 0 && self.has(0.0) { Self { low: 0.0, high: ends.high } } else { ends }
    }
}
