//! Interpolation at several points at once.
//!
//! The points are those of consecutive cells of a row, moved by the flow. Where their stencils lie one value after the other in memory, which
//! holds but where the displacement passes from one cell to the next, all lanes read the same rows, shifted by a value each. Every lane has
//! the bits of the interpolation at its point alone. Limit: a stencil that leaves the data is read alone.

use super::lane_sums::{
    CUBIC_ROW, QUINTIC_ROW, contract_lanes_within_range, contract_quintic_lanes, cubic_weight_lanes,
    eno_reduced, kink_indicator_lanes, quintic_weight_lanes, third_difference_lanes,
};
use super::stencil::Window;
use super::weights::MAX_SMOOTH_THIRD_DIFFERENCE_CELLS;
use super::{Sampler, VelocitySampler};
use crate::each_lanes;
use crate::grid::Lattice;
use crate::lanes::{ALL_LANES, Instructions, LANES, LaneFunction, Lanes, VectorLanes};

/// Length of the row that the stencils of two points along an axis read in all lanes.
const LINEAR_ROW: usize = LANES + 1;

/// Places of several points along an axis: the lattice cells that contain them, as whole numbers, and the coordinates in these cells.
#[derive(Clone, Copy)]
struct Places<I: Instructions> {
    base: Lanes<I>,
    t: Lanes<I>,
}

impl<const D: usize> Sampler<'_, D> {
    /// [`Self::linear`] in each lane.
    #[inline(always)]
    pub fn linear_lanes<I: Instructions>(&self, x: &VectorLanes<I, D>) -> Lanes<I> {
        let places = self.places(x);
        self.linear_in(&places.each_ref())
    }

    /// [`Self::cubic`] in each lane.
    #[inline(always)]
    pub fn cubic_lanes<I: Instructions>(&self, x: &VectorLanes<I, D>) -> Lanes<I> {
        let places = self.places(x);
        let mut weights = [[places[0].t; 4]; D];
        for a in 0..D {
            weights[a] = cubic_weight_lanes(places[a].t);
        }
        self.cubic_in(&places.each_ref(), &weights.each_ref())
    }

    /// [`Self::distance`] in each lane.
    #[inline(always)]
    pub fn distance_lanes<I: Instructions>(&self, x: &VectorLanes<I, D>) -> Lanes<I> {
        x.instructions().call(DistanceLanes { sampler: self, x: *x })
    }

    /// The values beside several lattice points, by their distance from these, of at most `reach` along each axis; `None` where one of them
    /// lies beyond the edges.
    #[inline(always)]
    pub fn values_around<'a, I: Instructions + 'a>(
        &'a self,
        with: I,
        points: [[usize; D]; LANES],
        reach: usize,
    ) -> Option<impl Fn([isize; D]) -> Lanes<I> + 'a> {
        let Lattice { extent, stride } = self.lattice;
        let is_inner = |at: &[usize; D]| (0..D).all(|a| at[a] >= reach && at[a] + reach < extent[a]);
        points.iter().all(is_inner).then(|| {
            let centers = points.map(|at| self.lattice.index(at));
            move |shift: [isize; D]| {
                let shift = (0..D).map(|a| shift[a] * stride[a] as isize).sum::<isize>();
                Lanes::from_fn(with, |l| self.data[centers[l].wrapping_add_signed(shift)])
            }
        })
    }

    /// The places of the points along each axis.
    #[inline(always)]
    fn places<I: Instructions>(&self, x: &VectorLanes<I, D>) -> [Places<I>; D] {
        let mut places = [self.places_along(0, x.0[0]); D];
        for a in 1..D {
            places[a] = self.places_along(a, x.0[a]);
        }
        places
    }

    /// [`Self::locate_along`] in each lane.
    #[inline(always)]
    fn places_along<I: Instructions>(&self, a: usize, x: Lanes<I>) -> Places<I> {
        let with = x.instructions();
        let shift = Lanes::splat(with, self.margin_cells[a] - self.stagger_cells[a]);
        let upper = Lanes::splat(with, self.lattice.extent[a] as f64 + 1.0);
        // A place that is not a number stays so, because it is the second operand.
        let s = upper.min(Lanes::splat(with, -2.0).max(x * self.inverse_dx + shift));
        let base = s.floor();
        Places { base, t: s - base }
    }

    #[inline(always)]
    fn linear_in<I: Instructions>(&self, places: &[&Places<I>; D]) -> Lanes<I> {
        self.by_stencils::<I, _, 2, LINEAR_ROW>(places, &LinearLanes { sampler: self, places })
    }

    #[inline(always)]
    fn cubic_in<I: Instructions>(&self, places: &[&Places<I>; D], weights: &[&[Lanes<I>; 4]; D]) -> Lanes<I> {
        self.by_stencils::<I, _, 4, CUBIC_ROW>(places, &CubicLanes { sampler: self, places, weights })
    }

    /// Interpolates for each set of lanes whose stencils of `N` points along an axis lie one value after the other in memory, from the rows of
    /// `L` values that they read, and alone for a lane whose stencil leaves the data.
    #[inline(always)]
    fn by_stencils<I: Instructions, S: StencilLanes<I>, const N: usize, const L: usize>(
        &self,
        places: &[&Places<I>; D],
        stencils: &S,
    ) -> Lanes<I> {
        let with = places[0].t.instructions();
        let zero = Lanes::splat(with, 0.0);
        let mut origin = Lanes::from_fn(with, |l| -(l as f64));
        let mut is_inside = zero.at_least(zero);
        for a in 0..D {
            let first = places[a].base - Lanes::splat(with, (N / 2 - 1) as f64);
            let last = Lanes::splat(with, self.lattice.extent[a] as f64 - N as f64);
            is_inside = is_inside & first.at_least(zero) & last.at_least(first);
            origin = origin + first * self.lattice.stride[a] as f64;
        }
        let (mut values, mut rest, origins) = (zero, ALL_LANES, origin.to_array());
        while rest != 0 {
            let lane = rest.trailing_zeros() as usize;
            let is_same = origin.equal_to(Lanes::splat(with, origins[lane])) & is_inside;
            let together = is_same.bits() & rest;
            match if together == 0 { None } else { self.lane_window::<N, L>(origins[lane]) } {
                Some(window) => {
                    values = is_same.select(stencils.together(&window), values);
                    rest &= !together;
                }
                None => {
                    let (others, alone) = (values.to_array(), stencils.alone(lane));
                    values = Lanes::from_fn(with, |l| if l == lane { alone } else { others[l] });
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

/// Interpolation in the lanes.
trait StencilLanes<I: Instructions> {
    /// In all lanes whose stencils have these rows, shifted by a value each; marked `inline(always)`.
    fn together(&self, window: &Window<'_>) -> Lanes<I>;
    /// In a lane.
    fn alone(&self, lane: usize) -> f64;
}

/// [`Sampler::linear`] at these places.
struct LinearLanes<'a, I: Instructions, const D: usize> {
    sampler: &'a Sampler<'a, D>,
    places: &'a [&'a Places<I>; D],
}

impl<I: Instructions, const D: usize> StencilLanes<I> for LinearLanes<'_, I, D> {
    #[inline(always)]
    fn together(&self, window: &Window<'_>) -> Lanes<I> {
        let with = self.places[0].t.instructions();
        let (places, one) = (self.places, Lanes::splat(with, 1.0));
        let mut sums = Lanes::splat(with, 0.0);
        for row in 0..1usize << (D - 1) {
            let mut weight = if row & 1 == 1 { places[1].t } else { one - places[1].t };
            if D == 3 {
                weight = weight * if row >> 1 == 1 { places[2].t } else { one - places[2].t };
            }
            let values = window.row::<LINEAR_ROW>(row & 1, row >> 1);
            let (low, high) = (Lanes::load(with, values, 0), Lanes::load(with, values, 1));
            sums = sums + weight * (low + places[0].t * (high - low));
        }
        sums
    }

    fn alone(&self, lane: usize) -> f64 {
        let t = self.places.map(|place| place.t.to_array()[lane]);
        self.sampler.linear_at(base_of(self.places, lane), &t)
    }
}

/// [`Sampler::cubic`] at these places, with the weights of the points along each axis.
struct CubicLanes<'a, I: Instructions, const D: usize> {
    sampler: &'a Sampler<'a, D>,
    places: &'a [&'a Places<I>; D],
    weights: &'a [&'a [Lanes<I>; 4]; D],
}

impl<I: Instructions, const D: usize> StencilLanes<I> for CubicLanes<'_, I, D> {
    #[inline(always)]
    fn together(&self, window: &Window<'_>) -> Lanes<I> {
        contract_lanes_within_range(window, self.weights)
    }

    fn alone(&self, lane: usize) -> f64 {
        let weights = self.weights.map(|w| w.map(|point| point.to_array()[lane]));
        self.sampler.cubic_at(base_of(self.places, lane), &weights)
    }
}

/// [`Sampler::distance`] at these points.
struct DistanceLanes<'a, I: Instructions, const D: usize> {
    sampler: &'a Sampler<'a, D>,
    x: VectorLanes<I, D>,
}

impl<I: Instructions, const D: usize> LaneFunction for DistanceLanes<'_, I, D> {
    type Output = Lanes<I>;

    #[inline(always)]
    fn call(self) -> Lanes<I> {
        let Self { sampler, x } = self;
        let places = sampler.places(&x);
        let mut weights = [[places[0].t; 6]; D];
        for a in 0..D {
            weights[a] = quintic_weight_lanes(places[a].t);
        }
        let stencils = QuinticLanes { sampler, x: &x, places: &places, weights: &weights };
        sampler.by_stencils::<I, _, 6, QUINTIC_ROW>(&places.each_ref(), &stencils)
    }
}

/// The same with the places and the weights of the six points along each axis.
struct QuinticLanes<'a, I: Instructions, const D: usize> {
    sampler: &'a Sampler<'a, D>,
    x: &'a VectorLanes<I, D>,
    places: &'a [Places<I>; D],
    weights: &'a [[Lanes<I>; 6]; D],
}

impl<I: Instructions, const D: usize> StencilLanes<I> for QuinticLanes<'_, I, D> {
    #[inline(always)]
    fn together(&self, window: &Window<'_>) -> Lanes<I> {
        let with = self.x.instructions();
        let third = third_difference_lanes::<I, D>(with, window) * self.sampler.inverse_dx;
        let is_smooth = third.less_than(Lanes::splat(with, MAX_SMOOTH_THIRD_DIFFERENCE_CELLS));
        let smooth = contract_quintic_lanes(window, self.weights);
        if is_smooth.bits() == ALL_LANES {
            return smooth;
        }
        let mut t = [smooth; D];
        for a in 0..D {
            t[a] = self.places[a].t;
        }
        let kinked = EnoLanes { inverse_dx: self.sampler.inverse_dx, window: window.middle::<D>(), t };
        is_smooth.select(smooth, with.call(kinked))
    }

    fn alone(&self, lane: usize) -> f64 {
        self.sampler.distance(&self.x.to_array()[lane])
    }
}

/// The value of [`Sampler::eno_cubic_in`] in each lane, of rows shifted by a value each.
struct EnoLanes<'w, I: Instructions, const D: usize> {
    inverse_dx: f64,
    window: Window<'w>,
    t: [Lanes<I>; D],
}

impl<I: Instructions, const D: usize> LaneFunction for EnoLanes<'_, I, D> {
    type Output = Lanes<I>;

    #[inline(always)]
    fn call(self) -> Lanes<I> {
        let Self { inverse_dx, window, t } = self;
        let with = t[0].instructions();
        let kink = kink_indicator_lanes::<I, D>(with, &window);
        let scale = Lanes::splat(with, inverse_dx);
        let mut planes = [t[0]; 4];
        for (k, plane) in planes.iter_mut().enumerate().take(if D == 3 { 4 } else { 1 }) {
            let mut rows = [t[0]; 4];
            for (j, row) in rows.iter_mut().enumerate() {
                let values = window.row::<CUBIC_ROW>(j, k);
                *row = eno_reduced(each_lanes!(with, |i| Lanes::load(with, values, i)), t[0], kink, scale);
            }
            *plane = eno_reduced(rows, t[1], kink, scale);
        }
        if D == 3 { eno_reduced(planes, t[2], kink, scale) } else { planes[0] }
    }
}

/// [`VelocitySampler::cubic`] at these points.
struct CubicVelocityLanes<'a, I: Instructions, const D: usize> {
    sampler: &'a VelocitySampler<'a, D>,
    x: VectorLanes<I, D>,
}

impl<I: Instructions, const D: usize> LaneFunction for CubicVelocityLanes<'_, I, D> {
    type Output = VectorLanes<I, D>;

    #[inline(always)]
    fn call(self) -> VectorLanes<I, D> {
        let Self { sampler, x } = self;
        let places = sampler.place_lanes(&x);
        let mut weights = [[[x.0[0]; 4]; 2]; D];
        for (weights, places) in weights.iter_mut().zip(&places) {
            for k in 0..2 {
                weights[k] = cubic_weight_lanes(places[k].t);
            }
        }
        let mut velocity = x;
        for a in 0..D {
            let own = std::array::from_fn(|b| &places[b][usize::from(b != a)]);
            let weights = std::array::from_fn(|b| &weights[b][usize::from(b != a)]);
            velocity.0[a] = sampler.axes[a].cubic_in(&own, &weights);
        }
        velocity
    }
}

/// [`VelocitySampler::linear`] at these points.
struct LinearVelocityLanes<'a, I: Instructions, const D: usize> {
    sampler: &'a VelocitySampler<'a, D>,
    x: VectorLanes<I, D>,
}

impl<I: Instructions, const D: usize> LaneFunction for LinearVelocityLanes<'_, I, D> {
    type Output = VectorLanes<I, D>;

    #[inline(always)]
    fn call(self) -> VectorLanes<I, D> {
        let Self { sampler, x } = self;
        let places = sampler.place_lanes(&x);
        let mut velocity = x;
        for a in 0..D {
            let own = std::array::from_fn(|b| &places[b][usize::from(b != a)]);
            velocity.0[a] = sampler.axes[a].linear_in(&own);
        }
        velocity
    }
}

impl<const D: usize> VelocitySampler<'_, D> {
    /// [`Self::cubic`] in each lane.
    #[inline(always)]
    pub fn cubic_lanes<I: Instructions>(&self, x: &VectorLanes<I, D>) -> VectorLanes<I, D> {
        x.instructions().call(CubicVelocityLanes { sampler: self, x: *x })
    }

    /// [`Self::linear`] in each lane.
    #[inline(always)]
    pub fn linear_lanes<I: Instructions>(&self, x: &VectorLanes<I, D>) -> VectorLanes<I, D> {
        x.instructions().call(LinearVelocityLanes { sampler: self, x: *x })
    }

    /// [`Self::at_cell`] at consecutive cells of a row, from `at` on.
    #[inline(always)]
    pub fn at_cells<I: Instructions>(&self, with: I, at: [usize; D]) -> VectorLanes<I, D> {
        VectorLanes(each_lanes!(with, |a| {
            let Sampler { data, lattice, .. } = &self.axes[a];
            let lower = lattice.index(at);
            (Lanes::load(with, data, lower) + Lanes::load(with, data, lower + lattice.stride[a])) * 0.5
        }))
    }

    /// [`Self::cubic_at_cell`] at consecutive cells of a row, from `at` on.
    #[inline(always)]
    pub fn cubic_at_cells<I: Instructions>(&self, with: I, at: [usize; D]) -> VectorLanes<I, D> {
        let is_inner = (0..D).all(|a| {
            let last = at[a] + if a == 0 { LANES - 1 } else { 0 };
            at[a] > 0 && last + 2 < self.axes[a].lattice.extent[a]
        });
        if !is_inner {
            let last = self.axes[0].lattice.extent[0] - 2;
            return VectorLanes::from_fn(with, |l| {
                let mut cell = at;
                cell[0] = (at[0] + l).min(last);
                self.cubic_at_cell(cell)
            });
        }
        VectorLanes(each_lanes!(with, |a| {
            let Sampler { data, lattice, .. } = &self.axes[a];
            let (lower, step) = (lattice.index(at), lattice.stride[a]);
            let middle = Lanes::load(with, data, lower) + Lanes::load(with, data, lower + step);
            let outer = Lanes::load(with, data, lower - step) + Lanes::load(with, data, lower + 2 * step);
            (middle * 9.0 - outer) * (1.0 / 16.0)
        }))
    }

    /// [`Self::at_face`] at consecutive faces of a row, from `at` on.
    #[inline(always)]
    pub fn at_faces<I: Instructions>(&self, with: I, axis: usize, at: [usize; D]) -> VectorLanes<I, D> {
        let faces = self.axes[axis].lattice.extent[axis];
        if axis == 0 && (at[0] == 0 || at[0] + LANES >= faces) {
            return VectorLanes::from_fn(with, |l| {
                let mut face = at;
                face[0] = (at[0] + l).min(faces - 1);
                self.at_face(axis, face)
            });
        }
        VectorLanes(each_lanes!(with, |a| {
            let Sampler { data, lattice, .. } = &self.axes[a];
            if a == axis {
                Lanes::load(with, data, lattice.index(at))
            } else {
                let mut cell = at;
                cell[axis] = at[axis].min(faces - 2);
                let upper = lattice.index(cell);
                cell[axis] = at[axis].saturating_sub(1);
                let lower = lattice.index(cell);
                let step = lattice.stride[a];
                let below = Lanes::load(with, data, lower) + Lanes::load(with, data, lower + step);
                let above = Lanes::load(with, data, upper) + Lanes::load(with, data, upper + step);
                (below + above) * 0.25
            }
        }))
    }

    /// The places of the points along each axis on the lattice of the faces normal to it, and on the lattices of the other components.
    #[inline(always)]
    fn place_lanes<I: Instructions>(&self, x: &VectorLanes<I, D>) -> [[Places<I>; 2]; D] {
        let mut places = [[Places { base: x.0[0], t: x.0[0] }; 2]; D];
        for (b, places) in places.iter_mut().enumerate() {
            *places = [self.axes[b].places_along(b, x.0[b]), self.axes[(b + 1) % D].places_along(b, x.0[b])];
        }
        places
    }
}

/// The lattice cell of a lane.
fn base_of<I: Instructions, const D: usize>(places: &[&Places<I>; D], l: usize) -> [isize; D] {
    places.map(|place| place.base.to_array()[l] as isize)
}
