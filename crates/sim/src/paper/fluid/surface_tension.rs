//! Surface tension as a force in a band around the surface, semi-implicit in time (Eq. 6; W. Zheng, J.-H. Yong, J.-C. Paul 2009).
//!
//! ```text
//! (u − u_old)/Δt = −Υ/ρ δ(φ) κ n + Υ/ρ δ(φ) Δt ∇²u,    δ(φ) = (1 + cos(π φ/ε))/(2 ε),   ε = 3 Δx
//! ```
//!
//! The density is missing in the paper (E2). `n = ∇φ/|∇φ|` and `κ = ∇·n` are those of the level set through the face, by central
//! differences. Each component of the velocity is one symmetric positive definite system on the faces of the band, `(ρ/(Υ δ Δt²) − ∇²) u
//! = …`, solved by conjugate gradients; faces outside the band keep their velocity. Sides of the domain are mirrors. Where a tension is
//! not positive the implicit term is left out, since it would not be positive.
//!
//! With [`Errata::one_sided_delta`] the force and the implicit term are doubled in the liquid. In the air there is no force then; the
//! implicit term is as printed, so that the velocity there, a continuation of the liquid's, does not hold the liquid back.
//!
//! With [`Errata::balanced_force`] (E24) `δ n` between two cells is the difference of their Heaviside functions, and `κ` that of the
//! surface at the closest point ([`SurfaceShape`]):
//!
//! ```text
//! −Υ κ δ n ≈ −Υ κ (H_upper − H_lower)/Δx,    H(φ) = ∫ δ dφ from −∞
//! ```
//!
//! So the sum from within the liquid to the air is `Υ κ` wherever the surface lies between the cells, and a surface of one curvature is
//! at rest: the force is the gradient of `−Υ κ H`. A solid in the band lacks the pressure `Υ κ H` of the liquid beside it, and gets it as an
//! impulse ([`SurfaceTension::solid_impulses`]). Faces of solid cells are not diffused.
//!
//! Limit: the implicit term is a viscosity `Υ δ Δt/ρ` (E4).

use super::cells::{CellType, CellTypes, Face, FaceType};
use super::curvature::curvature;
use super::fractions::phi_at_face;
use super::interfaces::{Interface, interface_at};
use super::surface_shape::SurfaceShape;
use crate::paper::Errata;
use meniscus_numerics::grid::{FaceField, Grid, Lattice};
use meniscus_numerics::linalg::{
    Jacobi, LinearOperator, SolveError, SolveLimits, SolveReport, conjugate_gradient,
};
use meniscus_numerics::{Vector, par};
use std::f64::consts::PI;

/// Half the width `ε` of the band, in cells.
pub const BAND_CELLS: f64 = 3.0;
/// Diffusion in a step, `Υ δ Δt²/ρ` over the square of a cell, below which a face keeps its velocity: its change would be below rounding.
const MIN_DIFFUSION_CELLS: f64 = 1e-15;

/// The delta function of Eq. 6, 1/m, for a half width `epsilon`, m. Its integral over `phi` is one.
pub fn delta(phi: f64, epsilon: f64) -> f64 {
    if phi.abs() < epsilon { 0.5 / epsilon * (1.0 + (PI * phi / epsilon).cos()) } else { 0.0 }
}

/// The integral of the delta function up to `phi`, or with `one_sided` that of the delta function which is doubled in the liquid and zero in
/// the air.
pub fn heaviside(phi: f64, epsilon: f64, one_sided: bool) -> f64 {
    let (place, sides) = (phi / epsilon, if one_sided { 1.0 } else { 0.5 });
    if place <= -1.0 {
        return 0.0;
    }
    (sides * (1.0 + place + (PI * place).sin() / PI)).min(1.0)
}

/// A step of Eq. 6.
pub struct SurfaceTension<'a, const D: usize> {
    /// Types of the cells.
    pub types: &'a CellTypes<D>,
    /// The liquid's surface, closed along solids, or continued into them ([`Errata::open_surface`]).
    pub shape: SurfaceShape<'a, D>,
    /// Tension of the liquid's surface, N/m.
    pub liquid_air: f64,
    /// Tension of wetted solids near a point (m), N/m; with an open surface it does not act here.
    pub liquid_solid: &'a (dyn Fn(&Vector<D>) -> f64 + Sync),
    /// Density of the liquid, kg/m³.
    pub density: f64,
    /// Length of the step, s.
    pub dt: f64,
    /// Errata.
    pub errata: Errata,
}

/// A face of the band.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BandFace {
    /// Its position in the lattice of its axis.
    pub index: usize,
    /// Change of its velocity by the explicit force, m/s.
    pub explicit: f64,
    /// `Υ δ Δt²/ρ` of the implicit term over the square of a cell; not negative.
    pub diffusion_cells: f64,
}

impl<const D: usize> SurfaceTension<'_, D> {
    /// Changes a velocity, m/s, that is known in the whole band, on both sides of the surface. Reports the solve for each component.
    ///
    /// # Errors
    /// [`SolveError`] of the conjugate gradients.
    pub fn apply(
        &self,
        velocity: &mut FaceField<D>,
        limits: SolveLimits,
    ) -> Result<[SolveReport; D], SolveError> {
        let mut reports = [SolveReport::default(); D];
        for (axis, report) in reports.iter_mut().enumerate() {
            let lattice = self.types.grid().face_lattice(axis);
            let (band, values) = (self.band(axis), &mut velocity.axes[axis]);
            let diffusing = |face: &BandFace| face.diffusion_cells > MIN_DIFFUSION_CELLS;
            band.iter().for_each(|face| values[face.index] += face.explicit);
            let diffusing = band.into_iter().filter(diffusing).collect();
            let system =
                BandDiffusion::new(lattice, diffusing, &|index| self.is_skipped(Face { axis, index }));
            let mut x: Vec<f64> = system.band.iter().map(|face| values[face.index]).collect();
            let preconditioner = Jacobi::new(&system.diagonal);
            *report =
                conjugate_gradient(&system, &preconditioner, &system.right_side(values), &mut x, limits)?;
            system.band.iter().zip(x).for_each(|(face, u)| values[face.index] = u);
        }
        Ok(reports)
    }

    /// The faces of the band normal to an axis, in order, those on closed sides left out.
    pub fn band(&self, axis: usize) -> Vec<BandFace> {
        let count = self.types.grid().face_lattice(axis).len();
        par::filter_map(count, 256, |index| self.band_face(Face { axis, index }))
    }

    /// Whether a face between two solid cells counts for none of its neighbours.
    fn is_skipped(&self, face: Face) -> bool {
        let is_solid = |c: &Option<usize>| c.is_none_or(|c| self.types.cell(c) == CellType::Solid);
        self.errata.balanced_force && self.types.sides(face).iter().all(is_solid)
    }

    /// Impulses along the axis on the solids beside liquid–solid faces, N s (2D: N s/m): the pressure `Υ κ H` that the balanced force
    /// keeps from them.
    pub fn solid_impulses(&self) -> Vec<(Face, f64)> {
        if !self.errata.balanced_force {
            return Vec::new();
        }
        let (grid, epsilon) = (self.types.grid(), BAND_CELLS * self.types.grid().dx);
        let of = |face: Face| {
            let liquid_first =
                self.types.sides(face)[0].is_some_and(|c| self.types.cell(c) == CellType::Liquid);
            let [lower, upper] = self.phi_beside(face);
            let (phi, sign) = if liquid_first { (lower, 1.0) } else { (upper, -1.0) };
            let step = heaviside(phi, epsilon, self.errata.one_sided_delta);
            let pressure = || self.liquid_air * self.shape.curvature(&self.types.center(face)) * step;
            (step > 0.0).then(|| (face, sign * pressure() * grid.face_area() * self.dt))
        };
        let faces = self.types.faces_of(FaceType::LiquidSolid);
        par::filter_map(faces.len(), 1, |i| of(faces[i]))
    }

    /// The level set in the cells below and above a face, m.
    fn phi_beside(&self, face: Face) -> [f64; 2] {
        let at = self.types.grid().face_lattice(face.axis).coordinates(face.index);
        let upper = at.map(|i| i as isize);
        let mut lower = upper;
        lower[face.axis] -= 1;
        [lower, upper].map(|cell| self.shape.phi.value(cell))
    }

    /// A face of the band with [`Errata::balanced_force`].
    fn balanced_face(&self, face: Face) -> Option<BandFace> {
        let (grid, epsilon) = (self.types.grid(), BAND_CELLS * self.types.grid().dx);
        let sides = self.types.sides(face).map(|c| c.map_or(CellType::Air, |c| self.types.cell(c)));
        if self.types.face(face) == FaceType::ClosedSide || sides.contains(&CellType::Solid) {
            return None;
        }
        let one_sided = self.errata.one_sided_delta;
        let [lower, upper] = self.phi_beside(face);
        let phi = 0.5 * (lower + upper);
        let jump = heaviside(upper, epsilon, one_sided) - heaviside(lower, epsilon, one_sided);
        let delta = delta(phi, epsilon) * if one_sided && phi < 0.0 { 2.0 } else { 1.0 };
        let acts = jump != 0.0 && sides.contains(&CellType::Liquid);
        if !acts && delta == 0.0 {
            return None;
        }
        let tension = self.liquid_air;
        let curvature = if acts { self.shape.curvature(&self.types.center(face)) } else { 0.0 };
        Some(BandFace {
            index: face.index,
            explicit: -tension * curvature * jump / grid.dx * self.dt / self.density,
            diffusion_cells: tension.max(0.0) * delta * self.dt * self.dt
                / (self.density * grid.dx * grid.dx),
        })
    }

    fn band_face(&self, face: Face) -> Option<BandFace> {
        if self.errata.balanced_force {
            return self.balanced_face(face);
        }
        let (grid, axis) = (self.types.grid(), face.axis);
        let (phi, differences) = phi_at_face(&self.shape.phi, grid, face);
        let delta = delta(phi, BAND_CELLS * grid.dx);
        if delta == 0.0 || self.types.face(face) == FaceType::ClosedSide {
            return None;
        }
        let slope: Vector<D> = differences.into();
        let normal = slope.try_normalize(0.0).unwrap_or(Vector::zeros());
        let [in_force, in_diffusion] = match (self.errata.one_sided_delta, phi < 0.0) {
            (false, _) => [1.0, 1.0],
            (true, true) => [2.0, 2.0],
            (true, false) => [0.0, 1.0],
        };
        let closest = self.types.center(face) - normal * phi;
        let interface = || interface_at(self.types, &closest);
        let is_with_solid = !self.errata.open_surface && interface() == Interface::LiquidSolid;
        let tension = if is_with_solid { (self.liquid_solid)(&closest) } else { self.liquid_air };
        let force = -tension * delta * self.face_curvature(grid, face) * normal[axis];
        let diffusion = tension.max(0.0) * delta * self.dt * self.dt / self.density;
        Some(BandFace {
            index: face.index,
            explicit: in_force * force * self.dt / self.density,
            diffusion_cells: in_diffusion * diffusion / (grid.dx * grid.dx),
        })
    }

    /// Mean curvature of the cells on both sides of a face, 1/m.
    fn face_curvature(&self, grid: &Grid<D>, face: Face) -> f64 {
        let upper = grid.face_lattice(face.axis).coordinates(face.index).map(|i| i as isize);
        let mut lower = upper;
        lower[face.axis] -= 1;
        [lower, upper].map(|cell| curvature(&self.shape.phi, grid.dx, cell)).iter().sum::<f64>() * 0.5
    }
}

/// The system of one component, times the square of a cell: `(1/c + n) u − Σ u_neighbour = u_old/c + Σ u_known` with the diffusion `c` and
/// the number `n` of neighbours.
struct BandDiffusion<const D: usize> {
    lattice: Lattice<D>,
    band: Vec<BandFace>,
    /// For every face of the lattice 1 + its number in the band, or 0.
    slots: Vec<u32>,
    diagonal: Vec<f64>,
    /// For every face of the lattice whether it counts for none of its neighbours.
    skipped: Vec<bool>,
}

impl<const D: usize> BandDiffusion<D> {
    fn new(lattice: Lattice<D>, band: Vec<BandFace>, skipped: &(dyn Fn(usize) -> bool + Sync)) -> Self {
        let mut slots = vec![0; lattice.len()];
        band.iter().enumerate().for_each(|(i, face)| slots[face.index] = i as u32 + 1);
        let skipped = par::map(lattice.len(), 256, skipped);
        let mut system = Self { lattice, band, slots, diagonal: Vec::new(), skipped };
        let of = |face: &BandFace| 1.0 / face.diffusion_cells + system.neighbours(face.index).count() as f64;
        system.diagonal = system.band.iter().map(of).collect();
        system
    }

    fn neighbours(&self, index: usize) -> impl Iterator<Item = usize> + '_ {
        self.lattice.neighbours(index).filter(|n| !self.skipped[*n])
    }

    fn right_side(&self, values: &[f64]) -> Vec<f64> {
        let of = |face: &BandFace| {
            let known = self.neighbours(face.index).filter(|n| self.slots[*n] == 0);
            values[face.index] / face.diffusion_cells + known.map(|n| values[n]).sum::<f64>()
        };
        par::map_slice(&self.band, 256, of)
    }
}

impl<const D: usize> LinearOperator for BandDiffusion<D> {
    fn size(&self) -> usize {
        self.band.len()
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        par::for_each_mut(y, 256, |i, y| {
            let slots = self.neighbours(self.band[i].index).map(|n| self.slots[n] as usize);
            let around: f64 = slots.filter(|slot| *slot > 0).map(|slot| x[slot - 1]).sum();
            *y = self.diagonal[i] * x[i] - around;
        });
    }
}
