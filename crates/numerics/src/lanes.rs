//! Values at consecutive points of a row, a lane of the vector unit for each.
//!
//! Every operation is that of single numbers, lane by lane, and is rounded as theirs: a result in a lane does not depend on the width of the
//! machine's registers.

use crate::Vector;
use std::ops::{Add, BitAnd, Div, Mul, Sub};
use wide::f64x8;

/// Number of lanes: the numbers of double precision in the widest registers.
pub const LANES: usize = 8;

/// A number in each lane.
#[derive(Clone, Copy, Debug)]
pub struct Lanes(f64x8);

/// Yes or no in each lane.
#[derive(Clone, Copy, Debug)]
pub struct LaneMask(f64x8);

impl Lanes {
    /// Zero in each lane.
    pub const ZERO: Self = Self(f64x8::ZERO);

    /// The same number in each lane.
    #[inline(always)]
    pub fn splat(value: f64) -> Self {
        Self(f64x8::splat(value))
    }

    /// The numbers that `of` returns for each lane.
    #[inline(always)]
    pub fn from_fn(of: impl FnMut(usize) -> f64) -> Self {
        Self(f64x8::new(std::array::from_fn(of)))
    }

    /// The values from a position in memory on; zeros beyond the last one.
    #[inline(always)]
    pub fn load(data: &[f64], at: usize) -> Self {
        match data.get(at..).and_then(|rest| rest.first_chunk()) {
            Some(values) => Self(f64x8::new(*values)),
            None => Self::from_fn(|l| data.get(at + l).copied().unwrap_or(0.0)),
        }
    }

    /// Stores as many of the lanes as there is place for, from `at` on.
    #[inline(always)]
    pub fn store(self, data: &mut [f64], at: usize) {
        let values = self.0.to_array();
        match data[at..].first_chunk_mut() {
            Some(all) => *all = values,
            None => data[at..].iter_mut().zip(values).for_each(|(to, value)| *to = value),
        }
    }

    /// The numbers.
    #[inline(always)]
    pub fn to_array(self) -> [f64; LANES] {
        self.0.to_array()
    }

    /// The smaller one in each lane; that of `other` where one is not a number.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        Self(self.0.fast_min(other.0))
    }

    /// The larger one in each lane; that of `other` where one is not a number.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        Self(self.0.fast_max(other.0))
    }

    /// The magnitude in each lane.
    #[inline(always)]
    pub fn abs(self) -> Self {
        Self(self.0.abs())
    }

    /// The largest whole number that is not larger in each lane, of numbers whose magnitude is below 2⁵¹.
    ///
    /// Numbers from 2⁵² to 2⁵³ are whole, so that this sum is rounded to one. Plain x86-64 has no instruction that rounds.
    #[inline(always)]
    pub fn floor(self) -> Self {
        let shift = Self::splat(1.5 * (1u64 << 52) as f64);
        let nearest = self + shift - shift;
        nearest - self.less_than(nearest).select(Self::splat(1.0), Self::ZERO)
    }

    /// The square root in each lane.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }

    /// Where these numbers are smaller.
    #[inline(always)]
    pub fn less_than(self, other: Self) -> LaneMask {
        LaneMask(self.0.simd_lt(other.0))
    }

    /// Where these numbers are at least as large.
    #[inline(always)]
    pub fn at_least(self, other: Self) -> LaneMask {
        LaneMask(self.0.simd_ge(other.0))
    }

    /// Where the numbers are equal.
    #[inline(always)]
    pub fn equal_to(self, other: Self) -> LaneMask {
        LaneMask(self.0.simd_eq(other.0))
    }
}

impl LaneMask {
    /// The numbers of `yes` in the lanes of the mask, else those of `no`.
    #[inline(always)]
    pub fn select(self, yes: Lanes, no: Lanes) -> Lanes {
        Lanes(self.0.select(yes.0, no.0))
    }

    /// The lanes of the mask as bits.
    #[inline(always)]
    pub fn bits(self) -> u32 {
        self.0.to_bitmask()
    }
}

/// The bits of all lanes.
pub const ALL_LANES: u32 = (1 << LANES) - 1;

impl BitAnd for LaneMask {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

impl Add for Lanes {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }
}

impl Sub for Lanes {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(self.0 - other.0)
    }
}

impl Mul for Lanes {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self(self.0 * other.0)
    }
}

impl Mul<f64> for Lanes {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        Self(self.0 * f64x8::splat(factor))
    }
}

impl Div<f64> for Lanes {
    type Output = Self;
    #[inline(always)]
    fn div(self, divisor: f64) -> Self {
        Self(self.0 / f64x8::splat(divisor))
    }
}

impl Div for Lanes {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        Self(self.0 / other.0)
    }
}

/// A vector in each lane, component by component.
#[derive(Clone, Copy, Debug)]
pub struct VectorLanes<const D: usize>(pub [Lanes; D]);

impl<const D: usize> VectorLanes<D> {
    /// The vectors that `of` returns for each lane.
    pub fn from_fn(of: impl Fn(usize) -> Vector<D>) -> Self {
        let vectors: [Vector<D>; LANES] = std::array::from_fn(of);
        Self(std::array::from_fn(|a| Lanes::from_fn(|l| vectors[l][a])))
    }

    /// The vectors.
    pub fn to_array(self) -> [Vector<D>; LANES] {
        let components = self.0.map(Lanes::to_array);
        std::array::from_fn(|l| Vector::from_fn(|a, _| components[a][l]))
    }

    /// The lengths of the vectors.
    #[inline(always)]
    pub fn norms(&self) -> Lanes {
        self.0.iter().fold(Lanes::ZERO, |sum, v| sum + *v * *v).sqrt()
    }

    /// The vectors of `yes` in the lanes of the mask, else those of `no`.
    #[inline(always)]
    pub fn select(mask: LaneMask, yes: Self, no: Self) -> Self {
        Self(std::array::from_fn(|a| mask.select(yes.0[a], no.0[a])))
    }
}

impl<const D: usize> Add for VectorLanes<D> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(std::array::from_fn(|a| self.0[a] + other.0[a]))
    }
}

impl<const D: usize> Sub for VectorLanes<D> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(std::array::from_fn(|a| self.0[a] - other.0[a]))
    }
}

impl<const D: usize> Mul<f64> for VectorLanes<D> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        Self(self.0.map(|component| component * factor))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn floor_is_that_of_single_numbers() {
        let numbers = [-2.0, -1e-17, 0.0, 0.5, 1.0 - f64::EPSILON, 191.999, -1.5, 2f64.powi(50) + 0.75];
        assert_eq!(Lanes::from_fn(|l| numbers[l]).floor().to_array(), numbers.map(f64::floor));
    }
}
