//! The contact line as a mesh of particles: points in 2D, chains of segments in 3D (Section 4.3.1, "Lagrangian representation").
//!
//! A particle lies on each edge of the surface whose ends have values of opposite signs ([`Contour`]: marching segments and triangles).
//! After the repair of its edges each particle is moved to the closest point of the surface, which is known by a facet and weights.

use super::repair::Chains;
use meniscus_numerics::Vector;
use meniscus_numerics::mesh::{Contour, FacetBvh, SurfaceMesh};

/// A particle of the contact line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineParticle<const D: usize> {
    /// Position, m.
    pub at: Vector<D>,
    /// The facet of the surface on which it lies.
    pub facet: u32,
    /// Its barycentric weights in the facet.
    pub weights: [f64; D],
    /// Half the length of its segments, m (2D: 1, per metre of depth): `ℓ_c` of erratum E11.
    pub length: f64,
    /// Unit tangent along the line, by its neighbours (`t_c` of Section 4.3.2); zero in 2D.
    pub tangent: Vector<D>,
}

/// The contact line on a surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LineMesh<const D: usize> {
    /// The particles.
    pub particles: Vec<LineParticle<D>>,
    /// The segments between them, the wetted side on the left as seen from outside the solid; none in 2D.
    pub segments: Vec<[u32; 2]>,
}

impl<const D: usize> LineMesh<D> {
    /// The zero set of values at the vertices of a surface, with repaired edges.
    pub fn new(mesh: &SurfaceMesh<D>, values: &[f64]) -> Self {
        let contour = Contour::of(&mesh.facets, values);
        if contour.points.is_empty() {
            return Self::default();
        }
        let mut chains = Chains::new(contour.positions(mesh), &contour.segments);
        chains.repair();
        let tree = FacetBvh::new(mesh);
        let particle = |v: usize| {
            let closest = tree.closest_point(&chains.positions[v], f64::INFINITY)?;
            let (at, facet, weights) = (closest.point, closest.facet, closest.weights);
            Some(LineParticle { at, facet, weights, length: 1.0, tangent: Vector::zeros() })
        };
        let particles = (0..chains.positions.len()).filter_map(particle).collect();
        let mut line = Self { particles, segments: chains.segments() };
        if D == 3 {
            line.measure();
        }
        line
    }

    /// Positions of the particles, m.
    pub fn positions(&self) -> Vec<Vector<D>> {
        self.particles.iter().map(|p| p.at).collect()
    }

    /// Sets lengths and tangents from the segments.
    fn measure(&mut self) {
        let at = self.positions();
        self.particles.iter_mut().for_each(|p| p.length = 0.0);
        for [a, b] in self.segments.iter().map(|s| s.map(|p| p as usize)) {
            let along = at[b] - at[a];
            for end in [a, b] {
                self.particles[end].length += 0.5 * along.norm();
                // The sum of both segments is the difference of the neighbours' positions.
                self.particles[end].tangent += along;
            }
        }
        let unit = |t: Vector<D>| t.try_normalize(0.0).unwrap_or(Vector::zeros());
        self.particles.iter_mut().for_each(|p| p.tangent = unit(p.tangent));
    }
}
