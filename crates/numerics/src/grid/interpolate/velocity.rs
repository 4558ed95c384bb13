//! Interpolation of a velocity whose components lie on the faces normal to them.

use super::weights::cubic_weights;
use super::{BoundaryExtension, Sampler};
use crate::Vector;
use crate::grid::{FaceField, Grid};

/// Interpolates a velocity field component by component.
pub struct VelocitySampler<'a, const D: usize> {
    pub(super) axes: [Sampler<'a, D>; D],
}

/// Places of a point along an axis on the lattice of the faces normal to it, and on the lattices of the other components.
type Places<T> = [T; 2];

impl<'a, const D: usize> VelocitySampler<'a, D> {
    /// The sampler of a velocity field; `edges` are the boundary extensions of each component.
    pub fn new(
        grid: &Grid<D>,
        velocity: &'a FaceField<D>,
        edges: impl Fn(usize) -> [[BoundaryExtension; 2]; D],
    ) -> Self {
        Self { axes: std::array::from_fn(|a| Sampler::faces(grid, a, &velocity.axes[a], edges(a))) }
    }

    /// The sampler of the component along an axis.
    pub fn component(&self, axis: usize) -> &Sampler<'a, D> {
        &self.axes[axis]
    }

    /// The velocity at a point, by limited cubic interpolation.
    #[inline]
    pub fn cubic(&self, x: &Vector<D>) -> Vector<D> {
        let (base, t) = self.locate(x);
        let weights: [Places<[f64; 4]>; D] = t.map(|places| places.map(cubic_weights));
        Vector::from_fn(|a, _| self.axes[a].cubic_at(of_component(&base, a), &of_component(&weights, a)))
    }

    /// The velocity at a point, interpolated linearly.
    #[inline]
    pub fn linear(&self, x: &Vector<D>) -> Vector<D> {
        let (base, t) = self.locate(x);
        Vector::from_fn(|a, _| self.axes[a].linear_at(of_component(&base, a), &of_component(&t, a)))
    }

    /// The linearly interpolated velocity at the centre of a cell.
    #[inline]
    pub fn at_cell(&self, at: [usize; D]) -> Vector<D> {
        Vector::from_fn(|a, _| {
            let Sampler { data, lattice, .. } = &self.axes[a];
            let lower = lattice.index(at);
            0.5 * (data[lower] + data[lower + lattice.stride[a]])
        })
    }

    /// The velocity at the centre of a cell, by cubic interpolation of each component along its own axis. It is not limited: it leaves the range
    /// of the four values by at most an eighth of it.
    #[inline]
    pub fn cubic_at_cell(&self, at: [usize; D]) -> Vector<D> {
        Vector::from_fn(|a, _| {
            let Sampler { data, lattice, .. } = &self.axes[a];
            let (lower, step) = (lattice.index(at), lattice.stride[a]);
            let middle = [data[lower], data[lower + step]];
            let outer = if at[a] > 0 && at[a] + 2 < lattice.extent[a] {
                [data[lower - step], data[lower + 2 * step]]
            } else {
                let value = |offset: isize| {
                    let mut place = at.map(|i| i as isize);
                    place[a] += offset;
                    self.axes[a].value(place)
                };
                [value(-1), value(2)]
            };
            (9.0 * (middle[0] + middle[1]) - (outer[0] + outer[1])) / 16.0
        })
    }

    /// The linearly interpolated velocity at the centre of a face normal to `axis`.
    #[inline]
    pub fn at_face(&self, axis: usize, at: [usize; D]) -> Vector<D> {
        let faces = self.axes[axis].lattice.extent[axis];
        Vector::from_fn(|a, _| {
            let Sampler { data, lattice, .. } = &self.axes[a];
            if a == axis {
                return data[lattice.index(at)];
            }
            // Beyond a side lies the mirror image.
            let mut cell = at;
            cell[axis] = at[axis].min(faces - 2);
            let upper = lattice.index(cell);
            cell[axis] = at[axis].saturating_sub(1);
            let lower = lattice.index(cell);
            let up = lattice.stride[a];
            0.25 * ((data[lower] + data[lower + up]) + (data[upper] + data[upper + up]))
        })
    }

    /// For each axis the lattice cells that contain a point, and its coordinates in them.
    #[inline(always)]
    fn locate(&self, x: &Vector<D>) -> ([Places<isize>; D], [Places<f64>; D]) {
        let (mut base, mut t) = ([[0; 2]; D], [[0.0; 2]; D]);
        for b in 0..D {
            for (place, component) in [b, (b + 1) % D].into_iter().enumerate() {
                (base[b][place], t[b][place]) = self.axes[component].locate_along(b, x[b]);
            }
        }
        (base, t)
    }
}

/// The places on the lattice of a component.
#[inline(always)]
fn of_component<T: Copy, const D: usize>(places: &[Places<T>; D], component: usize) -> [T; D] {
    std::array::from_fn(|b| places[b][usize::from(b != component)])
}
