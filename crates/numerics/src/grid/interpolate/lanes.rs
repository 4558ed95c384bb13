//! Interpolation at several points at once.
//!
//! The points are those of consecutive cells of a row, moved by the flow. Where their stencils lie one value after the other in memory, which
//! holds but where the displacement passes from one cell to the next, all lanes read the same rows, shifted by a value each. Every lane has
//! the bits of the interpolation at its point alone. Limit: a stencil that leaves the data is read alone.

use super::stencil::Window;
use super::weights::{
    KINK_SLOPE_LOSS, KINK_TRANSITION_CELLS, MAX_SMOOTH_THIRD_DIFFERENCE_CELLS, QUINTIC_SCALE,
};
use super::{Sampler, VelocitySampler};
use crate::Vector;
use crate::grid::Lattice;
use crate::lanes::{ALL_LANES, LANES, Lanes, VectorLanes};

/// Length of the row that the stencils of two points along an axis read in all lanes.
const LINEAR_ROW: usize = LANES + 1;
/// The same for four points.
const CUBIC_ROW: usize = LANES + 3;
/// The same for six points.
const QUINTIC_ROW: usize = LANES + 5;

/// Places of several points along an axis: the lattice cells that contain them, as whole numbers, and the coordinates in these cells.
#[derive(Clone, Copy)]
struct Places {
    base: Lanes,
    t: Lanes,
}

impl<const D: usize> Sampler<'_, D> {
    /// [`Self::linear`] in each lane.
    #[inline]
    pub fn linear_lanes(&self, x: &VectorLanes<D>) -> Lanes {
        let places: [Places; D] = std::array::from_fn(|a| self.places_along(a, x.0[a]));
        self.linear_in(&places.each_ref())
    }

    /// [`Self::cubic`] in each lane.
    #[inline]
    pub fn cubic_lanes(&self, x: &VectorLanes<D>) -> Lanes {
        let places: [Places; D] = std::array::from_fn(|a| self.places_along(a, x.0[a]));
        let weights = places.map(|place| cubic_weight_lanes(place.t));
        self.cubic_in(&places.each_ref(), &weights.each_ref())
    }

    /// [`Self::distance`] in each lane.
    #[inline]
    pub fn distance_lanes(&self, x: &VectorLanes<D>) -> Lanes {
        let places: [Places; D] = std::array::from_fn(|a| self.places_along(a, x.0[a]));
        let weights = places.map(|place| quintic_weight_lanes(place.t));
        let all = |window: &Window<'_>| {
            let third = third_difference_lanes::<D>(window) * self.inverse_dx;
            let is_smooth = third.less_than(Lanes::splat(MAX_SMOOTH_THIRD_DIFFERENCE_CELLS));
            let smooth = contract_quintic_lanes(window, &weights);
            if is_smooth.bits() == ALL_LANES {
                return smooth;
            }
            is_smooth.select(smooth, self.eno_lanes(&window.middle::<D>(), places.map(|place| place.t)))
        };
        let one = |l: usize| self.distance(&Vector::from_fn(|a, _| x.0[a].to_array()[l]));
        self.by_stencils::<6, QUINTIC_ROW>(&places.each_ref(), all, one)
    }

    /// The value of [`Self::eno_cubic_in`] in each lane, of rows shifted by a value each.
    #[inline(never)]
    fn eno_lanes(&self, window: &Window<'_>, t: [Lanes; D]) -> Lanes {
        let (kink, scale) = (kink_indicator_lanes::<D>(window), Lanes::splat(self.inverse_dx));
        let reduced = |points: [Lanes; 4], t: Lanes| {
            let weights = eno_cubic_weight_lanes(points.map(|v| v * scale), t, kink);
            let terms: [Lanes; 4] = std::array::from_fn(|k| weights[k] * points[k]);
            (terms[0] + terms[1]) + (terms[2] + terms[3])
        };
        let row = |j: usize, k: usize| {
            let values = window.row::<CUBIC_ROW>(j, k);
            reduced(std::array::from_fn(|i| Lanes::load(values, i)), t[0])
        };
        let plane = |k: usize| reduced(std::array::from_fn(|j| row(j, k)), t[1]);
        if D == 3 { reduced(std::array::from_fn(plane), t[2]) } else { plane(0) }
    }

    /// The values beside several lattice points, by their distance from these, of at most `reach` along each axis; `None` where one of them
    /// lies beyond the edges.
    #[inline(always)]
    pub fn values_around(
        &self,
        points: [[usize; D]; LANES],
        reach: usize,
    ) -> Option<impl Fn([isize; D]) -> Lanes + '_> {
        let Lattice { extent, stride } = self.lattice;
        let is_inner = |at: &[usize; D]| (0..D).all(|a| at[a] >= reach && at[a] + reach < extent[a]);
        points.iter().all(is_inner).then(|| {
            let centers = points.map(|at| self.lattice.index(at));
            move |shift: [isize; D]| {
                let shift = (0..D).map(|a| shift[a] * stride[a] as isize).sum::<isize>();
                Lanes::from_fn(|l| self.data[centers[l].wrapping_add_signed(shift)])
            }
        })
    }

    /// [`Self::locate_along`] in each lane.
    #[inline(always)]
    fn places_along(&self, a: usize, x: Lanes) -> Places {
        let shift = Lanes::splat(self.margin_cells[a] - self.stagger_cells[a]);
        let upper = Lanes::splat(self.lattice.extent[a] as f64 + 1.0);
        // A place that is not a number stays so, because it is the second operand.
        let s = upper.min(Lanes::splat(-2.0).max(x * self.inverse_dx + shift));
        let base = s.floor();
        Places { base, t: s - base }
    }

    #[inline(always)]
    fn linear_in(&self, places: &[&Places; D]) -> Lanes {
        let one = Lanes::splat(1.0);
        let all = |window: &Window<'_>| {
            let mut sums = Lanes::ZERO;
            for row in 0..1usize << (D - 1) {
                let part = |a: usize| {
                    if row >> (a - 1) & 1 == 1 { places[a].t } else { one - places[a].t }
                };
                let weight = if D == 3 { part(1) * part(2) } else { part(1) };
                let values = window.row::<LINEAR_ROW>(row & 1, row >> 1);
                let (low, high) = (Lanes::load(values, 0), Lanes::load(values, 1));
                sums = sums + weight * (low + places[0].t * (high - low));
            }
            sums
        };
        let one = |l: usize| self.linear_at(base_of(places, l), &places.map(|p| p.t.to_array()[l]));
        self.by_stencils::<2, LINEAR_ROW>(places, all, one)
    }

    #[inline(always)]
    fn cubic_in(&self, places: &[&Places; D], weights: &[&[Lanes; 4]; D]) -> Lanes {
        let all = |window: &Window<'_>| contract_lanes_within_range(window, weights);
        let one = |l: usize| {
            self.cubic_at(base_of(places, l), &weights.map(|w| w.map(|point| point.to_array()[l])))
        };
        self.by_stencils::<4, CUBIC_ROW>(places, all, one)
    }

    /// Calls `all` for each set of lanes whose stencils of `N` points along an axis lie one value after the other in memory, with the rows of
    /// `L` values that they read, and `one` for a lane whose stencil leaves the data.
    #[inline(always)]
    fn by_stencils<const N: usize, const L: usize>(
        &self,
        places: &[&Places; D],
        all: impl Fn(&Window<'_>) -> Lanes,
        one: impl Fn(usize) -> f64,
    ) -> Lanes {
        let mut origin = Lanes::from_fn(|l| -(l as f64));
        let mut is_inside = Lanes::ZERO.at_least(Lanes::ZERO);
        for a in 0..D {
            let first = places[a].base - Lanes::splat((N / 2 - 1) as f64);
            let last = Lanes::splat(self.lattice.extent[a] as f64 - N as f64);
            is_inside = is_inside & first.at_least(Lanes::ZERO) & last.at_least(first);
            origin = origin + first * self.lattice.stride[a] as f64;
        }
        let (mut values, mut rest, origins) = (Lanes::ZERO, ALL_LANES, origin.to_array());
        while rest != 0 {
            let lane = rest.trailing_zeros() as usize;
            let is_same = origin.equal_to(Lanes::splat(origins[lane])) & is_inside;
            let together = is_same.bits() & rest;
            match if together == 0 { None } else { self.lane_window::<N, L>(origins[lane]) } {
                Some(window) => {
                    values = is_same.select(all(&window), values);
                    rest &= !together;
                }
                None => {
                    let (others, alone) = (values.to_array(), one(lane));
                    values = Lanes::from_fn(|l| if l == lane { alone } else { others[l] });
                    rest &= rest - 1;
                }
            }
        }
        values
    }

    /// The rows from a position in memory on that stencils of `N` points along an axis read, of `L` values; `None` if they leave the data.
    #[inline(always)]
    fn lane_window<const N: usize, const L: usize>(&self, origin: f64) -> Option<Window<'_>> {
        let strides = [self.lattice.stride[1], if D == 3 { self.lattice.stride[2] } else { 0 }];
        let reach = L + (N - 1) * (strides[0] + strides[1]);
        let origin = (origin >= 0.0).then_some(origin as usize)?;
        self.data.get(origin..origin + reach).map(|values| Window { values, strides })
    }
}

impl<const D: usize> VelocitySampler<'_, D> {
    /// [`Self::cubic`] in each lane.
    #[inline]
    pub fn cubic_lanes(&self, x: &VectorLanes<D>) -> VectorLanes<D> {
        let places = self.place_lanes(x);
        let weights = places.map(|two| two.map(|place| cubic_weight_lanes(place.t)));
        VectorLanes(std::array::from_fn(|a| {
            let own = std::array::from_fn(|b| &places[b][usize::from(b != a)]);
            self.axes[a].cubic_in(&own, &std::array::from_fn(|b| &weights[b][usize::from(b != a)]))
        }))
    }

    /// [`Self::linear`] in each lane.
    #[inline]
    pub fn linear_lanes(&self, x: &VectorLanes<D>) -> VectorLanes<D> {
        let places = self.place_lanes(x);
        VectorLanes(std::array::from_fn(|a| {
            self.axes[a].linear_in(&std::array::from_fn(|b| &places[b][usize::from(b != a)]))
        }))
    }

    /// [`Self::at_cell`] at consecutive cells of a row, from `at` on.
    #[inline(always)]
    pub fn at_cells(&self, at: [usize; D]) -> VectorLanes<D> {
        VectorLanes(std::array::from_fn(|a| {
            let Sampler { data, lattice, .. } = &self.axes[a];
            let lower = lattice.index(at);
            (Lanes::load(data, lower) + Lanes::load(data, lower + lattice.stride[a])) * 0.5
        }))
    }

    /// [`Self::cubic_at_cell`] at consecutive cells of a row, from `at` on.
    #[inline]
    pub fn cubic_at_cells(&self, at: [usize; D]) -> VectorLanes<D> {
        let is_inner = (0..D).all(|a| {
            let last = at[a] + if a == 0 { LANES - 1 } else { 0 };
            at[a] > 0 && last + 2 < self.axes[a].lattice.extent[a]
        });
        if !is_inner {
            let last = self.axes[0].lattice.extent[0] - 2;
            return VectorLanes::from_fn(|l| {
                let mut cell = at;
                cell[0] = (at[0] + l).min(last);
                self.cubic_at_cell(cell)
            });
        }
        VectorLanes(std::array::from_fn(|a| {
            let Sampler { data, lattice, .. } = &self.axes[a];
            let (lower, step) = (lattice.index(at), lattice.stride[a]);
            let middle = Lanes::load(data, lower) + Lanes::load(data, lower + step);
            let outer = Lanes::load(data, lower - step) + Lanes::load(data, lower + 2 * step);
            (middle * 9.0 - outer) * (1.0 / 16.0)
        }))
    }

    /// [`Self::at_face`] at consecutive faces of a row, from `at` on.
    #[inline]
    pub fn at_faces(&self, axis: usize, at: [usize; D]) -> VectorLanes<D> {
        let faces = self.axes[axis].lattice.extent[axis];
        if axis == 0 && (at[0] == 0 || at[0] + LANES >= faces) {
            return VectorLanes::from_fn(|l| {
                let mut face = at;
                face[0] = (at[0] + l).min(faces - 1);
                self.at_face(axis, face)
            });
        }
        VectorLanes(std::array::from_fn(|a| {
            let Sampler { data, lattice, .. } = &self.axes[a];
            if a == axis {
                return Lanes::load(data, lattice.index(at));
            }
            let mut cell = at;
            cell[axis] = at[axis].min(faces - 2);
            let upper = lattice.index(cell);
            cell[axis] = at[axis].saturating_sub(1);
            let lower = lattice.index(cell);
            let both = |cell: usize| Lanes::load(data, cell) + Lanes::load(data, cell + lattice.stride[a]);
            (both(lower) + both(upper)) * 0.25
        }))
    }

    /// The places of the points along each axis on the lattice of the faces normal to it, and on the lattices of the other components.
    #[inline(always)]
    fn place_lanes(&self, x: &VectorLanes<D>) -> [[Places; 2]; D] {
        std::array::from_fn(|b| {
            [b, (b + 1) % D].map(|component| self.axes[component].places_along(b, x.0[b]))
        })
    }
}

/// The lattice cell of a lane.
fn base_of<const D: usize>(places: &[&Places; D], l: usize) -> [isize; D] {
    places.map(|place| place.base.to_array()[l] as isize)
}

/// [`super::weights::cubic_weights`] in each lane.
#[inline(always)]
fn cubic_weight_lanes(t: Lanes) -> [Lanes; 4] {
    let [a, b, c] = [-1.0, 1.0, 2.0].map(|point| t - Lanes::splat(point));
    [t * b * c / -6.0, a * b * c * 0.5, a * t * c * -0.5, a * t * b / 6.0]
}

/// [`super::weights::quintic_weights`] in each lane.
#[inline(always)]
fn quintic_weight_lanes(t: Lanes) -> [Lanes; 6] {
    let away: [Lanes; 6] = std::array::from_fn(|i| t + Lanes::splat(2.0) - Lanes::splat(i as f64));
    let (mut before, mut after) = ([Lanes::splat(1.0); 6], [Lanes::splat(1.0); 6]);
    for i in 1..6 {
        before[i] = before[i - 1] * away[i - 1];
        after[5 - i] = after[6 - i] * away[6 - i];
    }
    std::array::from_fn(|i| before[i] * QUINTIC_SCALE[i] * after[i])
}

/// [`super::stencil::contract_within_range`] in each lane, of rows shifted by a value each.
#[inline(always)]
fn contract_lanes_within_range<const D: usize>(window: &Window<'_>, weights: &[&[Lanes; 4]; D]) -> Lanes {
    let (mut low, mut high) = (Lanes::splat(f64::INFINITY), Lanes::splat(f64::NEG_INFINITY));
    let mut sums = [Lanes::ZERO; 4];
    for row in 0..1usize << (2 * (D - 1)) {
        let own = weights[1][row & 3];
        let weight = if D == 3 { own * weights[2][row >> 2] } else { own };
        let values = window.row::<CUBIC_ROW>(row & 3, row >> 2);
        for i in 0..4 {
            let value = Lanes::load(values, i);
            low = value.min(low);
            high = value.max(high);
            sums[i] = sums[i] + weight * value;
        }
    }
    let terms: [Lanes; 4] = std::array::from_fn(|i| sums[i] * weights[0][i]);
    high.min(low.max((terms[0] + terms[1]) + (terms[2] + terms[3])))
}

/// [`super::stencil::contract_rows`] in each lane, of rows shifted by a value each.
#[inline(always)]
fn contract_quintic_lanes<const D: usize>(window: &Window<'_>, weights: &[[Lanes; 6]; D]) -> Lanes {
    let mut values = [Lanes::ZERO; 6];
    for k in 0..6 {
        let mut sums = [Lanes::ZERO; 6];
        for j in 0..6usize.pow(D as u32 - 2) {
            let row = window.row::<QUINTIC_ROW>(if D == 3 { j } else { k }, if D == 3 { k } else { 0 });
            for i in 0..6 {
                let value = Lanes::load(row, i);
                sums[i] = sums[i] + if D == 3 { weights[1][j] * value } else { value };
            }
        }
        for i in 0..6 {
            values[i] = values[i] + weights[D - 1][k] * sums[i];
        }
    }
    (1..6).fold(weights[0][0] * values[0], |sum, i| sum + weights[0][i] * values[i])
}

/// [`super::weights::max_third_difference`] of the four middle points along each axis in each lane, of rows shifted by a value each.
#[inline(always)]
fn third_difference_lanes<const D: usize>(window: &Window<'_>) -> Lanes {
    let mut worst = Lanes::ZERO;
    for k in if D == 3 { 1..5 } else { 0..1 } {
        let rows: [_; 4] = std::array::from_fn(|j| window.row::<QUINTIC_ROW>(j + 1, k));
        for row in rows {
            worst = larger_third(worst, std::array::from_fn(|i| Lanes::load(row, i + 1)));
        }
        worst = larger_third_across(worst, rows);
    }
    if D == 3 {
        for j in 1..5 {
            let rows = std::array::from_fn(|k| window.row::<QUINTIC_ROW>(j, k + 1));
            worst = larger_third_across(worst, rows);
        }
    }
    worst
}

/// The larger of `worst` and the third difference of four values.
#[inline(always)]
fn larger_third(worst: Lanes, values: [Lanes; 4]) -> Lanes {
    let third = (values[1] - values[2]) * 3.0 + values[3] - values[0];
    third.abs().max(worst)
}

/// The same for four rows, at their four middle places.
#[inline(always)]
fn larger_third_across(worst: Lanes, rows: [&[f64; QUINTIC_ROW]; 4]) -> Lanes {
    (1..5).fold(worst, |worst, i| larger_third(worst, rows.map(|row| Lanes::load(row, i))))
}

/// The weights of [`super::weights::eno_cubic_weights`] in each lane.
#[inline(always)]
fn eno_cubic_weight_lanes(v: [Lanes; 4], t: Lanes, kink: Lanes) -> [Lanes; 4] {
    let (zero, one) = (Lanes::ZERO, Lanes::splat(1.0));
    let (a, b) = (v[0] - v[1] * 2.0 + v[2], v[1] - v[2] * 2.0 + v[3]);
    let excess =
        ((a - b).abs() - Lanes::splat(MAX_SMOOTH_THIRD_DIFFERENCE_CELLS)).max(zero) / KINK_TRANSITION_CELLS;
    let square = excess * excess;
    let smooth = one / (one + square * square) / 3.0;
    let (left, right) = (smooth * (Lanes::splat(2.0) - t), smooth * (one + t));
    let q = t * 0.5 * (t - one);
    let rest = one - smooth * 3.0;
    let kink = kink * rest;
    let is_left = a.abs().less_than(b.abs());
    let is_near = (t * a.abs()).less_than((one - t) * b.abs());
    let bent = |side: Lanes, share: Lanes, line: Lanes| {
        let side = side + q * share;
        side + kink * (line - side)
    };
    let same = zero.less_than(a * b);
    let bent_left = bent(q * left, is_left.select(rest, zero), is_near.select(zero - t, zero));
    let bent_right = bent(q * right, is_left.select(zero, rest), is_near.select(zero, t - one));
    let (l, r) = (same.select(bent_left, q * left), same.select(bent_right, q * right));
    [l, one - t - l * 2.0 + r, t + l - r * 2.0, r]
}

/// [`super::weights::kink_indicator`] in each lane, of rows shifted by a value each.
#[inline(always)]
fn kink_indicator_lanes<const D: usize>(window: &Window<'_>) -> Lanes {
    let square = |axis: usize, shift: usize| {
        let mut rise = [Lanes::ZERO; D];
        for corner in 0..1 << D {
            let place = |b: usize| (corner >> b & 1) + if b == axis { shift } else { 1 };
            let row = window.row::<CUBIC_ROW>(place(1), if D == 3 { place(2) } else { 0 });
            let value = Lanes::load(row, place(0));
            for (a, rise) in rise.iter_mut().enumerate() {
                *rise = if corner >> a & 1 == 1 { *rise + value } else { *rise - value };
            }
        }
        rise.iter().fold(Lanes::ZERO, |sum, r| sum + *r * *r)
    };
    let around = (0..D).map(|a| square(a, 0).min(square(a, 2))).fold(Lanes::ZERO, |worst, s| s.max(worst));
    let part = (square(0, 1) / around.max(Lanes::splat(1e-300))).sqrt();
    Lanes::splat(1.0).min(Lanes::ZERO.max((Lanes::splat(1.0) - part) / KINK_SLOPE_LOSS))
}
