//! Instructions for several numbers at once: those for which the program was compiled, or wider ones that the machine has.
//!
//! Every operation is rounded as that of single numbers, so that the choice changes no result.

use super::LANES;
use std::fmt::Debug;
use wide::f64x8;

/// A set of instructions for [`LANES`] numbers.
pub trait Instructions: Copy + Debug + Send + Sync {
    /// The numbers.
    type Numbers: Copy + Debug;
    /// Yes or no for each number.
    type Mask: Copy + Debug;

    /// Loads numbers.
    fn load(self, values: &[f64; LANES]) -> Self::Numbers;
    /// The same number [`LANES`] times.
    fn splat(self, value: f64) -> Self::Numbers;
    /// The numbers as an array.
    fn to_array(self, a: Self::Numbers) -> [f64; LANES];
    /// `a + b`.
    fn add(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;
    /// `a − b`.
    fn subtract(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;
    /// `a b`.
    fn multiply(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;
    /// `a / b`.
    fn divide(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;
    /// The smaller number; `b` where one is not a number.
    fn min(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;
    /// The larger number; `b` where one is not a number.
    fn max(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;
    /// `|a|`.
    fn abs(self, a: Self::Numbers) -> Self::Numbers;
    /// `√a`.
    fn sqrt(self, a: Self::Numbers) -> Self::Numbers;
    /// Where `a < b`.
    fn less_than(self, a: Self::Numbers, b: Self::Numbers) -> Self::Mask;
    /// Where `a ≥ b`.
    fn at_least(self, a: Self::Numbers, b: Self::Numbers) -> Self::Mask;
    /// Where `a = b`.
    fn equal(self, a: Self::Numbers, b: Self::Numbers) -> Self::Mask;
    /// Where both masks say yes.
    fn and(self, a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// The numbers `yes` where the mask says yes, else `no`.
    fn select(self, mask: Self::Mask, yes: Self::Numbers, no: Self::Numbers) -> Self::Numbers;
    /// The mask as bits.
    fn bits(self, mask: Self::Mask) -> u32;
    /// Calls a function that is compiled for these instructions.
    fn call<F: LaneFunction>(self, function: F) -> F::Output;
}

/// A function on lanes, with its arguments.
pub trait LaneFunction {
    /// Its result.
    type Output;
    /// Calls it; marked `inline(always)`.
    fn call(self) -> Self::Output;
}

/// Work that is compiled for each set of instructions.
///
/// Everything that operates on lanes in it must be inlined, or be called by [`Instructions::call`]: functions are marked `inline(always)`,
/// and closures, which cannot be, do not operate on lanes. Else each operation is a call.
pub trait LaneWork {
    /// Its result.
    type Output;
    /// Does the work; marked `inline(always)`.
    fn run<I: Instructions>(self, instructions: I) -> Self::Output;
}

/// Does work with the widest instructions of the machine.
pub fn run_with_widest<W: LaneWork>(work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    if let Some(avx2) = pulp::x86::V3::try_new() {
        return avx2.call(WithInstructions { with: avx2, work });
    }
    work.run(Compiled)
}

/// Work for any instructions, together with those that it is to use.
struct WithInstructions<I, W> {
    with: I,
    work: W,
}

impl<I: Instructions, W: LaneWork> LaneFunction for WithInstructions<I, W> {
    type Output = W::Output;

    #[inline(always)]
    fn call(self) -> W::Output {
        self.work.run(self.with)
    }
}

/// The instructions for which the program was compiled.
#[derive(Clone, Copy, Debug)]
pub struct Compiled;

impl Instructions for Compiled {
    type Numbers = f64x8;
    type Mask = f64x8;

    #[inline(always)]
    fn load(self, values: &[f64; LANES]) -> f64x8 {
        f64x8::new(*values)
    }
    #[inline(always)]
    fn splat(self, value: f64) -> f64x8 {
        f64x8::splat(value)
    }
    #[inline(always)]
    fn to_array(self, a: f64x8) -> [f64; LANES] {
        a.to_array()
    }
    #[inline(always)]
    fn add(self, a: f64x8, b: f64x8) -> f64x8 {
        a + b
    }
    #[inline(always)]
    fn subtract(self, a: f64x8, b: f64x8) -> f64x8 {
        a - b
    }
    #[inline(always)]
    fn multiply(self, a: f64x8, b: f64x8) -> f64x8 {
        a * b
    }
    #[inline(always)]
    fn divide(self, a: f64x8, b: f64x8) -> f64x8 {
        a / b
    }
    #[inline(always)]
    fn min(self, a: f64x8, b: f64x8) -> f64x8 {
        a.fast_min(b)
    }
    #[inline(always)]
    fn max(self, a: f64x8, b: f64x8) -> f64x8 {
        a.fast_max(b)
    }
    #[inline(always)]
    fn abs(self, a: f64x8) -> f64x8 {
        a.abs()
    }
    #[inline(always)]
    fn sqrt(self, a: f64x8) -> f64x8 {
        a.sqrt()
    }
    #[inline(always)]
    fn less_than(self, a: f64x8, b: f64x8) -> f64x8 {
        a.simd_lt(b)
    }
    #[inline(always)]
    fn at_least(self, a: f64x8, b: f64x8) -> f64x8 {
        a.simd_ge(b)
    }
    #[inline(always)]
    fn equal(self, a: f64x8, b: f64x8) -> f64x8 {
        a.simd_eq(b)
    }
    #[inline(always)]
    fn and(self, a: f64x8, b: f64x8) -> f64x8 {
        a & b
    }
    #[inline(always)]
    fn select(self, mask: f64x8, yes: f64x8, no: f64x8) -> f64x8 {
        mask.select(yes, no)
    }
    #[inline(always)]
    fn bits(self, mask: f64x8) -> u32 {
        mask.to_bitmask()
    }
    #[inline(always)]
    fn call<F: LaneFunction>(self, function: F) -> F::Output {
        function.call()
    }
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use super::{Instructions, LANES, LaneFunction};
    use pulp::x86::V3;
    use pulp::{NullaryFnOnce, cast, f64x4, m64x4};
    use std::arch::x86_64::__m256d;

    type Numbers = [f64x4; 2];
    type Mask = [m64x4; 2];

    impl Instructions for V3 {
        type Numbers = Numbers;
        type Mask = Mask;

        #[inline(always)]
        fn load(self, values: &[f64; LANES]) -> Numbers {
            cast(*values)
        }
        #[inline(always)]
        fn splat(self, value: f64) -> Numbers {
            [self.splat_f64x4(value); 2]
        }
        #[inline(always)]
        fn to_array(self, a: Numbers) -> [f64; LANES] {
            cast(a)
        }
        #[inline(always)]
        fn add(self, a: Numbers, b: Numbers) -> Numbers {
            [self.add_f64x4(a[0], b[0]), self.add_f64x4(a[1], b[1])]
        }
        #[inline(always)]
        fn subtract(self, a: Numbers, b: Numbers) -> Numbers {
            [self.sub_f64x4(a[0], b[0]), self.sub_f64x4(a[1], b[1])]
        }
        #[inline(always)]
        fn multiply(self, a: Numbers, b: Numbers) -> Numbers {
            [self.mul_f64x4(a[0], b[0]), self.mul_f64x4(a[1], b[1])]
        }
        #[inline(always)]
        fn divide(self, a: Numbers, b: Numbers) -> Numbers {
            [self.div_f64x4(a[0], b[0]), self.div_f64x4(a[1], b[1])]
        }
        #[inline(always)]
        fn min(self, a: Numbers, b: Numbers) -> Numbers {
            [self.min_f64x4(a[0], b[0]), self.min_f64x4(a[1], b[1])]
        }
        #[inline(always)]
        fn max(self, a: Numbers, b: Numbers) -> Numbers {
            [self.max_f64x4(a[0], b[0]), self.max_f64x4(a[1], b[1])]
        }
        #[inline(always)]
        fn abs(self, a: Numbers) -> Numbers {
            [self.abs_f64x4(a[0]), self.abs_f64x4(a[1])]
        }
        #[inline(always)]
        fn sqrt(self, a: Numbers) -> Numbers {
            [self.sqrt_f64x4(a[0]), self.sqrt_f64x4(a[1])]
        }
        #[inline(always)]
        fn less_than(self, a: Numbers, b: Numbers) -> Mask {
            [self.cmp_lt_f64x4(a[0], b[0]), self.cmp_lt_f64x4(a[1], b[1])]
        }
        #[inline(always)]
        fn at_least(self, a: Numbers, b: Numbers) -> Mask {
            [self.cmp_ge_f64x4(a[0], b[0]), self.cmp_ge_f64x4(a[1], b[1])]
        }
        #[inline(always)]
        fn equal(self, a: Numbers, b: Numbers) -> Mask {
            [self.cmp_eq_f64x4(a[0], b[0]), self.cmp_eq_f64x4(a[1], b[1])]
        }
        #[inline(always)]
        fn and(self, a: Mask, b: Mask) -> Mask {
            [self.and_m64x4(a[0], b[0]), self.and_m64x4(a[1], b[1])]
        }
        #[inline(always)]
        fn select(self, mask: Mask, yes: Numbers, no: Numbers) -> Numbers {
            [self.select_f64x4(mask[0], yes[0], no[0]), self.select_f64x4(mask[1], yes[1], no[1])]
        }
        #[inline(always)]
        fn bits(self, mask: Mask) -> u32 {
            let [low, high] = mask;
            let low = self.avx._mm256_movemask_pd(cast::<_, __m256d>(low)) as u32;
            let high = self.avx._mm256_movemask_pd(cast::<_, __m256d>(high)) as u32;
            low | high << (LANES / 2)
        }
        #[inline(always)]
        fn call<F: LaneFunction>(self, function: F) -> F::Output {
            self.vectorize(Nullary(function))
        }
    }

    /// A function on lanes as `pulp` takes it.
    struct Nullary<F>(F);

    impl<F: LaneFunction> NullaryFnOnce for Nullary<F> {
        type Output = F::Output;

        #[inline(always)]
        fn call(self) -> F::Output {
            self.0.call()
        }
    }
}
