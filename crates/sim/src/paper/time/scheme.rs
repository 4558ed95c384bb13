//! What is fixed in a run of the scheme.

use crate::model::{Model, Scheme};
use crate::paper::contact_line::RADIUS_CELLS;
use crate::paper::coupling::solver::{PAPER_LIMITS, Solver};
use crate::paper::{Errata, Tensions};
use crate::solid::Solids;
use meniscus_numerics::Vector;
use meniscus_numerics::linalg::SolveLimits;
use meniscus_numerics::mesh::{ShapeSurface, SurfaceMesh};
use std::sync::Arc;

/// Cells over the edges of the surfaces of rigid solids (Section 4.2: "1.5x in our experiments").
const CELLS_PER_EDGE: f64 = 1.5;

/// Largest number of iterations of a solve over that of the model, which is meant for multigrid.
const ITERATIONS_RATIO: usize = 20;

/// The scheme of the paper for a model. Of its `numerics` it uses what [`Self::of_model`] does.
#[derive(Clone, Debug)]
pub struct PaperScheme<const D: usize> {
    /// Grid, sides, liquid, gravity and solids.
    pub model: Model<D>,
    /// The tensions, of all solids the same; `None` for those of the model's surface tension and contact angles.
    pub tensions: Option<Tensions>,
    /// Errata.
    pub errata: Errata,
    /// The radius `R`, in cells.
    pub radius_cells: f64,
    /// Density of the solids, kg/m³, in the lumped mass of the line as printed (E9).
    pub solid_density: f64,
    /// Whether there is a contact line; without one the coupling is that of Section 5.1 alone.
    pub contact_line: bool,
    /// Solver of the coupled systems.
    pub solver: Solver,
    /// Limits of all solves.
    pub limits: SolveLimits,
    /// Surfaces of the rigid solids at the start, m; of deformable ones nothing.
    pub(super) rigid_surfaces: Vec<SurfaceMesh<D>>,
}

impl<const D: usize> PaperScheme<D> {
    /// The scheme of the paper, if it is the model's.
    pub fn chosen_by(model: &Model<D>) -> Option<Arc<Self>> {
        let is_chosen = model.numerics.scheme != Scheme::Meniscus;
        is_chosen.then(|| Arc::new(Self::of_model(model.clone())))
    }

    /// The scheme that a model's parameters choose; with all errata corrected if they choose another scheme.
    pub fn of_model(model: Model<D>) -> Self {
        let numerics = model.numerics;
        let radius_cells = numerics.line_radius / model.grid.dx;
        let limits = SolveLimits {
            tolerance: numerics.tolerance,
            max_iterations: ITERATIONS_RATIO * numerics.max_iterations,
        };
        let errata = match numerics.scheme {
            Scheme::PaperAsPrinted => Errata::AS_PRINTED,
            Scheme::Paper | Scheme::Meniscus => Errata::CORRECTED,
        };
        Self {
            errata,
            contact_line: numerics.contact_line,
            radius_cells: if radius_cells > 0.0 { radius_cells } else { RADIUS_CELLS },
            limits,
            ..Self::new(model, None)
        }
    }

    /// The scheme with the parameters of the paper and all errata corrected; for `tensions` see [`Self::tensions`].
    pub fn new(model: Model<D>, tensions: Option<Tensions>) -> Self {
        let edge = model.grid.dx / CELLS_PER_EDGE;
        let [first, last] = model.grid.bounds();
        let surface = |solid: &crate::Solid<D>| {
            if solid.elastic().is_some() {
                return SurfaceMesh::default();
            }
            let margin = Vector::repeat(2.0 * edge);
            let (low, high) = solid.shape.bounds();
            let distance = |x: &Vector<D>| solid.shape.signed_distance(x);
            // Without the facets that close the surface at the sides of the grid.
            let all =
                ShapeSurface::new(&distance, (low - margin).sup(&first), (high + margin).inf(&last), edge);
            SurfaceMesh { facets: all.solid_facets().to_vec(), positions: all.mesh.positions }
        };
        Self {
            rigid_surfaces: model.solids.iter().map(surface).collect(),
            solid_density: model.density,
            model,
            tensions,
            errata: Errata::CORRECTED,
            radius_cells: RADIUS_CELLS,
            contact_line: true,
            solver: Solver::ConjugateGradient,
            limits: PAPER_LIMITS,
        }
    }

    /// The tensions at a point (m) of a solid.
    pub(super) fn tensions_at(&self, solid: crate::SolidView<'_, D>, x: &Vector<D>) -> Tensions {
        let of_model = || {
            let cosine = solid.young_cosine_near(x, self.model.grid.dx);
            Tensions::of_cosine(self.model.surface_tension, cosine)
        };
        self.tensions.unwrap_or_else(of_model)
    }

    /// The tension of the wetted surface of the solid nearest to a point (m), N/m; zero without solids.
    pub(super) fn wetted_tension(&self, solids: Solids<'_, D>, x: &Vector<D>) -> f64 {
        solids.nearest(x).map_or(0.0, |number| self.tensions_at(solids.get(number), x).liquid_solid)
    }

    /// The tension of the liquid's surface, N/m.
    pub(super) fn liquid_air_tension(&self) -> f64 {
        self.tensions.map_or(self.model.surface_tension, |tensions| tensions.liquid_air)
    }
}
