//! Vectors of floats as plain arrays, with exp and ln made of nothing but additions, multiplications and bit shifts.
//!
//! Every operation is one loop over an array of fixed length, which LLVM turns into whatever vector instructions the
//! calling function was compiled for. Nothing here contracts a product and a sum into one rounding, so the bits of a
//! result do not depend on the instruction set. (On the processors measured a fused multiply-add saves nothing that
//! matters: additions and multiplications issue side by side.)

// Inlined into callers so that it takes over their instruction set.
#![allow(clippy::inline_always)]

use std::ops::{Add, Div, Mul, Sub};

/// A vector of `LANES` floats; operations act on each lane alone.
pub trait Vector:
    Copy + Send + Sync + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// A vector of one such float, with the same arithmetic.
    type One: Vector<One = Self::One>;
    /// How many floats.
    const LANES: usize;
    /// Unit roundoff times two.
    const EPSILON: f64;
    /// A number that keeps 0 / 0 from happening and is nothing beside any mass.
    const TINY: f64;
    /// Largest |log| of a Sinkhorn scaling for which sums and products stay well inside the range.
    const LOG_RANGE: f64;

    /// The same number in every lane.
    fn splat(x: f64) -> Self;
    /// One lane's number.
    fn get(&self, lane: usize) -> f64;
    /// Set one lane's number, rounded.
    fn set(&mut self, lane: usize, x: f64);
    /// As many numbers as there are lanes.
    fn load(from: &[Self::One]) -> Self;
    /// Write the lanes one after the other.
    fn store(self, to: &mut [Self::One]);
    /// Absolute values.
    #[must_use]
    fn abs(self) -> Self;
    /// Square roots, correctly rounded.
    #[must_use]
    fn sqrt(self) -> Self;
    /// Larger of two numbers.
    #[must_use]
    fn max(self, other: Self) -> Self;
    /// e^x, accurate to about one unit in the last place; clamped where it would leave the normal range.
    #[must_use]
    fn exp(self) -> Self;
    /// Natural logarithm, accurate to about one unit in the last place; clamped below the normal range.
    #[must_use]
    fn ln(self) -> Self;
    /// `a` where `self` > 0, else `b`.
    #[must_use]
    fn positive(self, a: Self, b: Self) -> Self;
}

macro_rules! operator {
    ($vector:ident, $trait:ident, $method:ident, $op:tt) => {
        impl $trait for $vector {
            type Output = Self;
            #[inline(always)]
            fn $method(mut self, other: Self) -> Self {
                for k in 0..Self::LANES {
                    self.0[k] $op other.0[k];
                }
                self
            }
        }
    };
}

macro_rules! vector {
    ($(#[$doc:meta])* $vector:ident, $one:ident, $float:ident, $lanes:literal, $align:literal, $constants:ident) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy)]
        #[repr(C, align($align))]
        pub struct $vector(pub [$float; $lanes]);

        operator!($vector, Add, add, +=);
        operator!($vector, Sub, sub, -=);
        operator!($vector, Mul, mul, *=);
        operator!($vector, Div, div, /=);

        // Lossless where the caller's number is of this type already, rounding where it is not.
        #[allow(clippy::cast_lossless, clippy::unnecessary_cast)]
        impl Vector for $vector {
            type One = $one;
            const LANES: usize = $lanes;
            const EPSILON: f64 = $float::EPSILON as f64;
            const TINY: f64 = $constants::TINY;
            const LOG_RANGE: f64 = $constants::LOG_RANGE;

            #[inline(always)]
            fn splat(x: f64) -> Self {
                Self([x as $float; $lanes])
            }

            #[inline(always)]
            fn get(&self, lane: usize) -> f64 {
                self.0[lane] as f64
            }

            #[inline(always)]
            fn set(&mut self, lane: usize, x: f64) {
                self.0[lane] = x as $float;
            }

            #[inline(always)]
            fn load(from: &[$one]) -> Self {
                let from = &from[..$lanes];
                let mut out = Self([0.0; $lanes]);
                for k in 0..$lanes {
                    out.0[k] = from[k].0[0];
                }
                out
            }

            #[inline(always)]
            fn store(self, to: &mut [$one]) {
                let to = &mut to[..$lanes];
                for k in 0..$lanes {
                    to[k].0[0] = self.0[k];
                }
            }

            #[inline(always)]
            fn abs(mut self) -> Self {
                for k in 0..$lanes {
                    self.0[k] = self.0[k].abs();
                }
                self
            }

            #[inline(always)]
            fn sqrt(mut self) -> Self {
                for k in 0..$lanes {
                    self.0[k] = self.0[k].sqrt();
                }
                self
            }

            #[inline(always)]
            fn max(mut self, other: Self) -> Self {
                for k in 0..$lanes {
                    self.0[k] = if self.0[k] > other.0[k] { self.0[k] } else { other.0[k] };
                }
                self
            }

            #[inline(always)]
            fn positive(mut self, a: Self, b: Self) -> Self {
                for k in 0..$lanes {
                    self.0[k] = if self.0[k] > 0.0 { a.0[k] } else { b.0[k] };
                }
                self
            }

            #[inline(always)]
            fn exp(self) -> Self {
                let mut out = self;
                for k in 0..$lanes {
                    let x = self.0[k];
                    let x = if x > $constants::EXP_MIN { x } else { $constants::EXP_MIN };
                    let x = if x < $constants::EXP_MAX { x } else { $constants::EXP_MAX };
                    // x = turns ln 2 + r: the low bits of `shifted` hold `turns` as an integer.
                    let shifted = x * std::$float::consts::LOG2_E + $constants::ROUND;
                    let turns = shifted - $constants::ROUND;
                    let r = (x - turns * $constants::LN2_HIGH) - turns * $constants::LN2_LOW;
                    let mut p = $constants::EXP[0];
                    for c in &$constants::EXP[1..] {
                        p = p * r + *c;
                    }
                    let p = p * (r * r) + r + 1.0;
                    out.0[k] = $float::from_bits(p.to_bits().wrapping_add(shifted.to_bits() << $constants::MANTISSA));
                }
                out
            }

            #[inline(always)]
            fn ln(self) -> Self {
                let mut out = self;
                for k in 0..$lanes {
                    let x = self.0[k];
                    let x = if x > $float::MIN_POSITIVE { x } else { $float::MIN_POSITIVE };
                    // x = 2^(exponent - bias) mantissa, with the mantissa in [sqrt(1/2), sqrt(2)).
                    let bits = x.to_bits();
                    let exponent = bits.wrapping_add($constants::SQRT_HALF_OFFSET) >> $constants::MANTISSA;
                    let mantissa = $float::from_bits(
                        bits.wrapping_add($constants::BIAS << $constants::MANTISSA)
                            .wrapping_sub(exponent << $constants::MANTISSA),
                    );
                    let turns = $float::from_bits(exponent | $constants::INTEGER.to_bits())
                        - ($constants::INTEGER + $constants::BIAS as $float);
                    // fdlibm's log: s = f / (2 + f), log(1 + f) = f - (f^2 / 2 - s (f^2 / 2 + R(s^2))).
                    let f = mantissa - 1.0;
                    let s = f / (2.0 + f);
                    let z = s * s;
                    let mut p = $constants::LN[0];
                    for c in &$constants::LN[1..] {
                        p = p * z + *c;
                    }
                    let half = 0.5 * f * f;
                    let low = s * (half + p * z) + turns * $constants::LN2_LOW;
                    out.0[k] = turns * $constants::LN2_HIGH - ((half - low) - f);
                }
                out
            }
        }
    };
}

mod f64_constants {
    pub const TINY: f64 = 1e-300;
    pub const LOG_RANGE: f64 = 300.0;
    pub const EXP_MIN: f64 = -708.0;
    pub const EXP_MAX: f64 = 709.0;
    /// 1.5 * 2^52: adding it rounds to an integer in the low bits.
    pub const ROUND: f64 = 6_755_399_441_055_744.0;
    // The high part has 21 trailing zeros, so that its product with an exponent is exact.
    pub const LN2_HIGH: f64 = 6.931_471_803_691_238e-1;
    pub const LN2_LOW: f64 = 1.908_214_929_270_587_7e-10;
    pub const MANTISSA: u32 = 52;
    pub const BIAS: u64 = 1023;
    /// 2^52, whose mantissa takes an integer's bits as they are.
    pub const INTEGER: f64 = 4_503_599_627_370_496.0;
    /// (bits of 1) - (bits of sqrt(1/2)).
    pub const SQRT_HALF_OFFSET: u64 = 0x3ff0_0000_0000_0000 - 0x3fe6_a09e_667f_3bcd;
    /// Of (e^r - 1 - r) / r^2 on [-ln2/2, ln2/2], interpolated at Chebyshev nodes: relative error of e^r 1.7e-17.
    pub const EXP: [f64; 10] = [
        2.510_038_549_551_032e-8,
        2.762_008_844_540_975e-7,
        2.755_726_845_999_706_5e-6,
        2.480_152_129_595_437_5e-5,
        1.984_126_986_305_361_7e-4,
        1.388_888_891_721_371_7e-3,
        8.333_333_333_330_062e-3,
        4.166_666_666_662_413e-2,
        1.666_666_666_666_666_7e-1,
        0.5,
    ];
    /// fdlibm e_log.c, Lg7 to Lg1: error below 2^-58.45.
    pub const LN: [f64; 7] = [
        1.479_819_860_511_658_6e-1,
        1.531_383_769_920_937_3e-1,
        1.818_357_216_161_805e-1,
        2.222_219_843_214_978_4e-1,
        2.857_142_874_366_239e-1,
        3.999_999_999_940_942e-1,
        6.666_666_666_666_735e-1,
    ];
}

mod f32_constants {
    pub const TINY: f64 = 1e-37;
    pub const LOG_RANGE: f64 = 40.0;
    pub const EXP_MIN: f32 = -87.0;
    pub const EXP_MAX: f32 = 88.0;
    /// 1.5 * 2^23.
    pub const ROUND: f32 = 12_582_912.0;
    pub const LN2_HIGH: f32 = 0.693_359_4;
    pub const LN2_LOW: f32 = -2.121_944_4e-4;
    pub const MANTISSA: u32 = 23;
    pub const BIAS: u32 = 127;
    pub const INTEGER: f32 = 8_388_608.0;
    pub const SQRT_HALF_OFFSET: u32 = 0x3f80_0000 - 0x3f35_04f3;
    /// As for f64: relative error of e^r 1e-8.
    pub const EXP: [f32; 5] = [1.392_618_3e-3, 8.363_179e-3, 4.166_655_5e-2, 1.666_657_7e-1, 0.5];
    /// fdlibm e_logf.c (FreeBSD's single-precision coefficients), Lg4 to Lg1.
    pub const LN: [f32; 4] = [0.242_790_79, 0.284_987_87, 0.400_009_72, 0.666_666_6];
}

vector!(
    /// Sixteen f64: two of the widest registers, so that one's latency hides behind the other's.
    F64x16, F64x1, f64, 16, 64, f64_constants
);
vector!(
    /// Thirty-two f32.
    F32x32, F32x1, f32, 32, 64, f32_constants
);

vector!(
    /// Eight f64, for a few pairs: the bits of a lane do not depend on how many there are.
    F64x8, F64x1, f64, 8, 64, f64_constants
);
vector!(
    /// Sixteen f32, for a few pairs.
    F32x16, F32x1, f32, 16, 64, f32_constants
);
vector!(
    /// One f64.
    F64x1, F64x1, f64, 1, 8, f64_constants
);
vector!(
    /// One f32.
    F32x1, F32x1, f32, 1, 4, f32_constants
);

#[cfg(test)]
mod tests {
    use super::*;

    fn spread<V: Vector>(of: impl Fn(V) -> V, truth: impl Fn(f64) -> f64, low: f64, high: f64) -> f64 {
        let mut worst = 0.0_f64;
        for k in 0..200_000 {
            let v = V::splat(low + (high - low) * f64::from(k) / 2e5);
            let x = v.get(0);
            let (found, expected) = (of(v).get(V::LANES - 1), truth(x));
            worst = worst.max((found - expected).abs() / (V::EPSILON * expected.abs().max(1e-300)));
        }
        worst
    }

    #[test]
    fn exp_and_ln_are_accurate_to_the_last_place() {
        assert!(spread(F64x16::exp, f64::exp, -707.9, 708.9) < 1.1);
        assert!(spread(F64x16::ln, f64::ln, 1e-3, 3.0) < 1.1);
        assert!(spread(F64x16::ln, f64::ln, 1.0, 1e300) < 1.1);
        assert!(spread(F32x32::exp, f64::exp, -86.9, 87.9) < 1.5);
        assert!(spread(F32x32::ln, f64::ln, 1e-3, 3.0) < 1.5);
        assert!(spread(F32x32::ln, f64::ln, 1.0, 1e30) < 1.5);
    }

    #[test]
    fn exp_and_ln_stay_finite_outside_their_range() {
        for x in [f64::NEG_INFINITY, -1e30, 1e30, f64::INFINITY] {
            assert!(F64x16::splat(x).exp().get(0).is_finite());
            assert!(F32x32::splat(x).exp().get(0).is_finite());
        }
        assert!(F64x16::splat(0.0).ln().get(0) < -700.0);
        assert!(F32x32::splat(0.0).ln().get(0) < -87.0);
    }
}
