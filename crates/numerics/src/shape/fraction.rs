//! How much of a cube lies below a plane: exact clipping in two and three dimensions.
//!
//! With $m_a = |g_a|$ sorted upwards and $\alpha = \tfrac12 \sum_a m_a - |\varphi_0|$, the smaller of the two
//! parts of the unit cube is the volume of $\{y \in [0,1]^D : m \cdot y < \alpha\}$. The closed forms are
//! those of R. Scardovelli and S. Zaleski, J. Comput. Phys. 164 (2000) 228–237, rearranged so that no
//! difference of nearly equal numbers is divided by a small $m_a$: any gradient, however close to an axis,
//! keeps full precision.

/// The fraction of a cube in which a linear function is negative, between 0 and 1.
///
/// `value_at_centre` is the function at the cube's centre and `gradient_times_dx` its gradient times the
/// cube's side, both in the function's unit. A function that is zero throughout gives one half.
///
/// ```
/// use meniscus_numerics::shape::plane_box_fraction;
/// assert_eq!(plane_box_fraction(-0.25, [0.0, 1.0]), 0.75);
/// ```
pub fn plane_box_fraction<const D: usize>(value_at_centre: f64, gradient_times_dx: [f64; D]) -> f64 {
    let m = gradient_times_dx.map(f64::abs);
    let alpha = 0.5 * m.iter().sum::<f64>() - value_at_centre.abs();
    let smaller = if value_at_centre == 0.0 {
        0.5
    } else if alpha <= 0.0 {
        0.0
    } else if D == 2 {
        corner_area(m[0].min(m[1]), m[0].max(m[1]), alpha)
    } else {
        let (low, high) = (m[0].min(m[1]), m[0].max(m[1]));
        corner_volume(low.min(m[2]), low.max(m[2]).min(high), high.max(m[2]), alpha)
    };
    if value_at_centre < 0.0 { 1.0 - smaller } else { smaller }
}

/// Area of `{m1 x + m2 y < alpha}` in the unit square; `m1 <= m2`, `0 < alpha <= (m1 + m2) / 2`.
fn corner_area(m1: f64, m2: f64, alpha: f64) -> f64 {
    if alpha < m1 { (alpha / m1) * (alpha / m2) * 0.5 } else { (alpha - 0.5 * m1) / m2 }
}

/// Volume of `{m1 x + m2 y + m3 z < alpha}` in the unit cube; `m1 <= m2 <= m3`, `0 < alpha <= (m1 + m2 + m3)
/// / 2`.
fn corner_volume(m1: f64, m2: f64, m3: f64, alpha: f64) -> f64 {
    if alpha < m1 {
        return (alpha / m1) * (alpha / m2) * (alpha / m3) / 6.0;
    }
    if alpha >= m1 + m2 {
        return (alpha - 0.5 * (m1 + m2)) / m3;
    }
    // The cut-off corners, of size at most m1, are divided by m1 m2 m3 without loss; there is none where m1 is zero.
    let corner = |beyond: f64| if beyond > 0.0 { (beyond / m1) * (beyond / m2) * (beyond / m3) } else { 0.0 };
    let wedge = (alpha / m2) * ((alpha - m1) / m3) * 0.5 + (m1 / m2) * (m1 / m3) / 6.0;
    wedge - (corner((alpha - m2).max(0.0)) + corner((alpha - m3).max(0.0))) / 6.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_along_an_axis_have_a_share() {
        // Exactly zero components: mirror planes of symmetric liquids.
        for g in [[0.0, 0.6, 0.8], [0.6, 0.0, 0.8], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]] {
            for v in [-0.6, -0.3, -0.1, 0.0, 0.1, 0.3, 0.6] {
                let share = plane_box_fraction(v, g);
                assert!((0.0..=1.0).contains(&share), "{v} {g:?}: {share}");
            }
        }
    }

    /// A small generator of numbers in 0..1 (SplitMix64).
    struct Random(u64);
    impl Random {
        fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut z = self.0;
            z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
        }
    }

    /// Integrates along the last axis in closed form, by the midpoint rule along the others.
    fn by_sampling<const D: usize>(value: f64, g: [f64; D], n: usize) -> f64 {
        let total = n.pow(D as u32 - 1);
        let sum: f64 = (0..total)
            .map(|mut k| {
                let mut v = value;
                for slope in &g[..D - 1] {
                    v += slope * (((k % n) as f64 + 0.5) / n as f64 - 0.5);
                    k /= n;
                }
                let m = g[D - 1].abs();
                if m < 1e-12 { f64::from(v < 0.0) } else { (0.5 - v / m).clamp(0.0, 1.0) }
            })
            .sum();
        sum / total as f64
    }

    fn check<const D: usize>() {
        let mut random = Random(7);
        for _ in 0..300 {
            let g: [f64; D] = std::array::from_fn(|_| (random.next() - 0.5) * 2.0);
            let g = g.map(|v| if v.abs() < 0.1 { v * 1e-9 } else { v });
            let reach = 0.5 * g.iter().map(|v| v.abs()).sum::<f64>();
            let value = (random.next() - 0.5) * 2.2 * reach;
            let fraction = plane_box_fraction(value, g);
            assert!((0.0..=1.0).contains(&fraction));
            let expected = by_sampling(value, g, 200);
            assert!((fraction - expected).abs() < 3e-3, "{value} {g:?}: {fraction} {expected}");
            // The complement, scaling, mirroring and permutation of the axes.
            assert_eq!(fraction + plane_box_fraction(-value, g), 1.0);
            let scaled = plane_box_fraction(value * 1e-7, g.map(|v| -v * 1e-7));
            assert!((scaled - fraction).abs() < 1e-14);
            let mut turned = g;
            turned.rotate_left(1);
            assert!((plane_box_fraction(value, turned) - fraction).abs() < 1e-14);
        }
        assert_eq!(plane_box_fraction(1.0, [0.0; D]), 0.0);
        assert_eq!(plane_box_fraction(-1.0, [0.0; D]), 1.0);
        assert_eq!(plane_box_fraction(0.0, [0.0; D]), 0.5);
    }

    #[test]
    fn shape_fraction_agrees_with_sampling_and_symmetry() {
        check::<2>();
        check::<3>();
    }

    #[test]
    fn shape_fraction_is_the_corner_simplex() {
        assert!((plane_box_fraction(0.25, [0.5, 0.5]) - 0.125).abs() < 1e-15);
        let alpha: f64 = 0.3;
        let exact = alpha.powi(3) / (6.0 * 0.5 * 0.7);
        assert!((plane_box_fraction(1.1 - alpha, [1.0, -0.5, 0.7]) - exact).abs() < 1e-15);
        // Half of the unit cube lies below x + y + z = 3/2, and 5/6 of it below 2.
        assert_eq!(plane_box_fraction(0.0, [1.0, 1.0, 1.0]), 0.5);
        assert!((plane_box_fraction(-0.5, [1.0, 1.0, 1.0]) - 5.0 / 6.0).abs() < 1e-15);
    }

    #[test]
    fn shape_fraction_has_no_jump_between_the_forms() {
        let mut random = Random(3);
        for _ in 0..2000 {
            let g = [random.next().powi(8), random.next().powi(4), random.next()];
            let base = 0.5 * (g[0] + g[1] + g[2]);
            for at in [g[0], g[1], g[2], g[0] + g[1]] {
                let step = 1e-13 * base;
                let below = plane_box_fraction(base - at + step, g);
                let above = plane_box_fraction(base - at - step, g);
                let slope_bound = 2.0 * step / g[0].max(g[1]).max(g[2]);
                assert!(above - below > -1e-15 && above - below < slope_bound * 1.1 + 3e-15);
            }
        }
    }
}
