//! Values at consecutive points of a row, a lane of the vector unit for each.
//!
//! Every operation is that of single numbers, lane by lane, and is rounded as theirs: a result in a lane does not depend on the width of the
//! machine's registers.

mod instructions;

use crate::Vector;
pub use instructions::{Compiled, Instructions, LaneFunction, LaneWork, run_with_widest};
use std::ops::{Add, BitAnd, Div, Mul, Sub};

/// Number of lanes: the numbers of double precision in the widest registers.
pub const LANES: usize = 8;

/// A number in each lane.
#[derive(Clone, Copy, Debug)]
pub struct Lanes<I: Instructions> {
    numbers: I::Numbers,
    with: I,
}

/// Yes or no in each lane.
#[derive(Clone, Copy, Debug)]
pub struct LaneMask<I: Instructions> {
    mask: I::Mask,
    with: I,
}

impl<I: Instructions> Lanes<I> {
    /// The same number in each lane.
    #[inline(always)]
    pub fn splat(with: I, value: f64) -> Self {
        Self { numbers: with.splat(value), with }
    }

    /// The numbers that `of` returns for each lane.
    #[inline(always)]
    pub fn from_fn(with: I, of: impl FnMut(usize) -> f64) -> Self {
        Self { numbers: with.load(&std::array::from_fn(of)), with }
    }

    /// The values from a position in memory on; zeros beyond the last one.
    #[inline(always)]
    pub fn load(with: I, data: &[f64], at: usize) -> Self {
        match data.get(at..).and_then(|rest| rest.first_chunk()) {
            Some(values) => Self { numbers: with.load(values), with },
            None => Self::from_fn(with, |l| data.get(at + l).copied().unwrap_or(0.0)),
        }
    }

    /// Stores as many of the lanes as there is place for, from `at` on.
    #[inline(always)]
    pub fn store(self, data: &mut [f64], at: usize) {
        let values = self.to_array();
        match data[at..].first_chunk_mut() {
            Some(all) => *all = values,
            None => data[at..].iter_mut().zip(values).for_each(|(to, value)| *to = value),
        }
    }

    /// The numbers.
    #[inline(always)]
    pub fn to_array(self) -> [f64; LANES] {
        self.with.to_array(self.numbers)
    }

    /// The instructions that operate on the lanes.
    #[inline(always)]
    pub fn instructions(self) -> I {
        self.with
    }

    /// The smaller one in each lane; that of `other` where one is not a number.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        Self { numbers: self.with.min(self.numbers, other.numbers), with: self.with }
    }

    /// The larger one in each lane; that of `other` where one is not a number.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        Self { numbers: self.with.max(self.numbers, other.numbers), with: self.with }
    }

    /// The magnitude in each lane.
    #[inline(always)]
    pub fn abs(self) -> Self {
        Self { numbers: self.with.abs(self.numbers), with: self.with }
    }

    /// The square root in each lane.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self { numbers: self.with.sqrt(self.numbers), with: self.with }
    }

    /// The largest whole number that is not larger in each lane, of numbers whose magnitude is below 2⁵¹.
    ///
    /// Numbers from 2⁵² to 2⁵³ are whole, so that this sum is rounded to one. Plain x86-64 has no instruction that rounds.
    #[inline(always)]
    pub fn floor(self) -> Self {
        let shift = Self::splat(self.with, 1.5 * (1u64 << 52) as f64);
        let nearest = self + shift - shift;
        nearest - self.less_than(nearest).select(Self::splat(self.with, 1.0), Self::splat(self.with, 0.0))
    }

    /// Where these numbers are smaller.
    #[inline(always)]
    pub fn less_than(self, other: Self) -> LaneMask<I> {
        LaneMask { mask: self.with.less_than(self.numbers, other.numbers), with: self.with }
    }

    /// Where these numbers are at least as large.
    #[inline(always)]
    pub fn at_least(self, other: Self) -> LaneMask<I> {
        LaneMask { mask: self.with.at_least(self.numbers, other.numbers), with: self.with }
    }

    /// Where the numbers are equal.
    #[inline(always)]
    pub fn equal_to(self, other: Self) -> LaneMask<I> {
        LaneMask { mask: self.with.equal(self.numbers, other.numbers), with: self.with }
    }
}

impl<I: Instructions> LaneMask<I> {
    /// The numbers of `yes` in the lanes of the mask, else those of `no`.
    #[inline(always)]
    pub fn select(self, yes: Lanes<I>, no: Lanes<I>) -> Lanes<I> {
        Lanes { numbers: self.with.select(self.mask, yes.numbers, no.numbers), with: self.with }
    }

    /// The lanes of the mask as bits.
    #[inline(always)]
    pub fn bits(self) -> u32 {
        self.with.bits(self.mask)
    }
}

/// The bits of all lanes.
pub const ALL_LANES: u32 = (1 << LANES) - 1;

impl<I: Instructions> BitAnd for LaneMask<I> {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self { mask: self.with.and(self.mask, other.mask), with: self.with }
    }
}

impl<I: Instructions> Add for Lanes<I> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { numbers: self.with.add(self.numbers, other.numbers), with: self.with }
    }
}

impl<I: Instructions> Sub for Lanes<I> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { numbers: self.with.subtract(self.numbers, other.numbers), with: self.with }
    }
}

impl<I: Instructions> Mul for Lanes<I> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self { numbers: self.with.multiply(self.numbers, other.numbers), with: self.with }
    }
}

impl<I: Instructions> Mul<f64> for Lanes<I> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        self * Self::splat(self.with, factor)
    }
}

impl<I: Instructions> Div<f64> for Lanes<I> {
    type Output = Self;
    #[inline(always)]
    fn div(self, divisor: f64) -> Self {
        self / Self::splat(self.with, divisor)
    }
}

impl<I: Instructions> Div for Lanes<I> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        Self { numbers: self.with.divide(self.numbers, other.numbers), with: self.with }
    }
}

/// An array of lanes, one for each number, without a closure ([`LaneWork`]).
#[macro_export]
macro_rules! each_lanes {
    ($with:expr, |$number:ident| $lanes:expr) => {{
        let mut all = [$crate::lanes::Lanes::splat($with, 0.0); _];
        for $number in 0..all.len() {
            all[$number] = $lanes;
        }
        all
    }};
}

/// A vector in each lane, component by component.
#[derive(Clone, Copy, Debug)]
pub struct VectorLanes<I: Instructions, const D: usize>(pub [Lanes<I>; D]);

impl<I: Instructions, const D: usize> VectorLanes<I, D> {
    /// The vectors that `of` returns for each lane.
    #[inline(always)]
    pub fn from_fn(with: I, of: impl Fn(usize) -> Vector<D>) -> Self {
        let vectors: [Vector<D>; LANES] = std::array::from_fn(of);
        Self(each_lanes!(with, |a| Lanes::from_fn(with, |l| vectors[l][a])))
    }

    /// The vectors.
    #[inline(always)]
    pub fn to_array(self) -> [Vector<D>; LANES] {
        let mut vectors = [Vector::zeros(); LANES];
        for (a, component) in self.0.iter().enumerate() {
            for (vector, value) in vectors.iter_mut().zip(component.to_array()) {
                vector[a] = value;
            }
        }
        vectors
    }

    /// The instructions that operate on the lanes.
    #[inline(always)]
    pub fn instructions(&self) -> I {
        self.0[0].instructions()
    }

    /// The lengths of the vectors.
    #[inline(always)]
    pub fn norms(&self) -> Lanes<I> {
        let mut sum = self.0[0] * self.0[0];
        for v in &self.0[1..] {
            sum = sum + *v * *v;
        }
        sum.sqrt()
    }

    /// The vectors of `yes` in the lanes of the mask, else those of `no`.
    #[inline(always)]
    pub fn select(mask: LaneMask<I>, yes: Self, no: Self) -> Self {
        Self(each_lanes!(yes.instructions(), |a| mask.select(yes.0[a], no.0[a])))
    }
}

impl<I: Instructions, const D: usize> Add for VectorLanes<I, D> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(each_lanes!(self.instructions(), |a| self.0[a] + other.0[a]))
    }
}

impl<I: Instructions, const D: usize> Sub for VectorLanes<I, D> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(each_lanes!(self.instructions(), |a| self.0[a] - other.0[a]))
    }
}

impl<I: Instructions, const D: usize> Mul<f64> for VectorLanes<I, D> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        Self(each_lanes!(self.instructions(), |a| self.0[a] * factor))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn floor_is_that_of_single_numbers() {
        let numbers = [-2.0, -1e-17, 0.0, 0.5, 1.0 - f64::EPSILON, 191.999, -1.5, 2f64.powi(50) + 0.75];
        let floors = Lanes::from_fn(Compiled, |l| numbers[l]).floor().to_array();
        assert_eq!(floors, numbers.map(f64::floor));
    }

    /// Every operation once, on numbers of all kinds.
    struct AllOperations;

    impl LaneWork for AllOperations {
        type Output = (Vec<[u64; LANES]>, Vec<u32>);

        #[inline(always)]
        fn run<I: Instructions>(self, with: I) -> Self::Output {
            let numbers = [0.1, -0.0, 0.0, f64::NAN, f64::INFINITY, -1e-310, 3.7e200, -2.5];
            let a = Lanes::from_fn(with, |l| numbers[l]);
            let b = Lanes::from_fn(with, |l| numbers[(5 * l + 3) % LANES]);
            let masks = [a.less_than(b), a.at_least(b), a.equal_to(b), a.less_than(b) & b.less_than(a)];
            let results = [
                a + b,
                a - b,
                a * b,
                a / b,
                a.min(b),
                a.max(b),
                a.abs(),
                a.abs().sqrt(),
                masks[0].select(a, b),
            ];
            let bits = |lanes: Lanes<I>| lanes.to_array().map(f64::to_bits);
            (results.map(bits).to_vec(), masks.map(LaneMask::bits).to_vec())
        }
    }

    #[test]
    fn all_instructions_return_the_same_bits() {
        let (compiled, widest) = (AllOperations.run(Compiled), run_with_widest(AllOperations));
        assert_eq!(compiled, widest);
    }
}
