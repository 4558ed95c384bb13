//! Unknowns of the solids: the velocities of the vertices of deformable solids, and velocity and angular velocity of rigid ones.
//!
//! The velocities of the vertices of their surfaces are `J v_s` with the embedding `J`. The paper's solids have volume meshes, for which
//! `J` picks the vertices of the surface; a rigid solid moves its vertices with `v + ω × r`. Angular velocities are multiplied by the
//! size of a cell, so that all unknowns are in m/s and all masses in kg.

use super::sparse_matrix::{Entry, SparseMatrix};
use crate::solid::{SolidView, Solids};
use meniscus_elastic::TangentWeights;
use meniscus_numerics::Vector;
use meniscus_numerics::mesh::SurfaceMesh;

/// The unknowns of solids in their states, solid by solid, node by node, component by component.
#[derive(Clone, Debug)]
pub struct SolidUnknowns<'a, const D: usize> {
    solids: Solids<'a, D>,
    /// First unknown of each solid, and the number of all.
    firsts: Vec<u32>,
}

impl<'a, const D: usize> SolidUnknowns<'a, D> {
    /// The unknowns of solids.
    pub fn new(solids: Solids<'a, D>) -> Self {
        let mut firsts = vec![0];
        for solid in solids.iter() {
            firsts.push(firsts[firsts.len() - 1] + (D * solid.node_count()) as u32);
        }
        Self { solids, firsts }
    }

    /// Number of unknowns.
    pub fn count(&self) -> usize {
        self.firsts[self.firsts.len() - 1] as usize
    }

    /// Their values in the states of the solids, m/s.
    pub fn velocities(&self) -> Vec<f64> {
        self.values(self.solids.iter().map(|solid| solid.state.node_velocities()))
    }

    /// Their values from the velocities of the nodes of each solid, m/s (angular ones rad/s).
    pub fn values(&self, nodes: impl IntoIterator<Item = Vec<Vector<D>>>) -> Vec<f64> {
        let mut all = Vec::with_capacity(self.count());
        for (solid, nodes) in self.solids.iter().zip(nodes) {
            for (node, v) in nodes.iter().enumerate() {
                let scale = if self.is_angular(&solid, node) { self.dx() } else { 1.0 };
                all.extend(v.iter().map(|component| component * scale));
            }
        }
        all
    }

    /// The velocities of the nodes of each solid from values of the unknowns; see [`crate::Solid::set_node_velocities`].
    pub fn node_velocities(&self, unknowns: &[f64]) -> Vec<Vec<Vector<D>>> {
        let of = |(number, solid): (usize, SolidView<'_, D>)| {
            let own = &unknowns[self.firsts[number] as usize..self.firsts[number + 1] as usize];
            let nodes = own.chunks_exact(D).map(Vector::from_column_slice).enumerate();
            let scale = |node: usize| if self.is_angular(&solid, node) { 1.0 / self.dx() } else { 1.0 };
            nodes.map(|(node, v)| v * scale(node)).collect()
        };
        self.solids.iter().enumerate().map(of).collect()
    }

    /// For each unknown whether its value is given: those of solids of prescribed motion and of anchored vertices, and in 2D the
    /// component of angular velocities that does not exist.
    pub fn is_prescribed(&self) -> Vec<bool> {
        let mut all = Vec::with_capacity(self.count());
        for solid in self.solids.iter() {
            for (node, prescribed) in solid.prescribed_nodes().into_iter().enumerate() {
                let unused = |a: usize| D == 2 && a == 1 && self.is_angular(&solid, node);
                all.extend((0..D).map(|a| prescribed || unused(a)));
            }
        }
        all
    }

    /// The embedding `J`: rows are the components of the velocities of the vertices of the surfaces, solid by solid, m.
    ///
    /// The vertices of a deformable solid's surface are those of [`SolidView::surface`]; the surface of a rigid one is any mesh in its
    /// present position.
    pub fn embedding(&self, surfaces: &[SurfaceMesh<D>]) -> SparseMatrix {
        let mut rows: Vec<Vec<Entry>> = Vec::new();
        for (number, (solid, surface)) in self.solids.iter().zip(surfaces).enumerate() {
            let first = self.firsts[number];
            if solid.elastic().is_some() {
                let vertices = solid.surface.volume_vertices();
                rows.extend(
                    vertices
                        .iter()
                        .flat_map(|v| (0..D as u32).map(move |a| vec![(first + v * D as u32 + a, 1.0)])),
                );
            } else {
                let center = solid.state.center_of_mass();
                for x in &surface.positions {
                    let arm = (x - center) / self.dx();
                    rows.extend((0..D).map(|a| rigid_row(first, a, &arm)));
                }
            }
        }
        SparseMatrix::new(self.count(), rows)
    }

    /// The mass matrix `M_s`, kg (2D: kg/m); no mass for solids of prescribed motion.
    pub fn mass(&self) -> SparseMatrix {
        let mut entries = Vec::new();
        for (number, solid) in self.solids.iter().enumerate() {
            let first = self.firsts[number];
            if let Some(elastic) = solid.elastic() {
                let diagonal = elastic.masses().iter().enumerate();
                entries.extend(
                    diagonal
                        .flat_map(|(v, m)| (0..D as u32).map(move |a| (first + v as u32 * D as u32 + a, *m)))
                        .map(|(k, m)| (k, k, m)),
                );
            } else if !solid.kind.is_prescribed() {
                entries.extend((0..D as u32).map(|a| (first + a, first + a, solid.mass_properties.mass)));
                let inertia = solid.inertia(&solid.state.as_rigid()) / (self.dx() * self.dx());
                let angular = first + D as u32;
                if D == 2 {
                    entries.push((angular, angular, inertia[(2, 2)]));
                } else {
                    let block = (0..D).flat_map(|i| (0..D).map(move |j| (i, j)));
                    entries.extend(
                        block.map(|(i, j)| (angular + i as u32, angular + j as u32, inertia[(i, j)])),
                    );
                }
            }
        }
        SparseMatrix::of_entries([self.count(); 2], entries)
    }

    /// The implicit part of Eq. 7, `−Δt D_s + Δt τ K` for forces that act for `Δt` = `dt` (s) and belong to positions `τ` = `lookahead` (s)
    /// later, kg (2D: kg/m): damping proportional to the stiffness of deformable solids, which rigid motions do not feel, and their
    /// stiffness (E27). Positive semidefinite.
    pub fn implicit_forces(&self, dt: f64, lookahead: f64) -> SparseMatrix {
        let mut entries = Vec::new();
        for (number, solid) in self.solids.iter().enumerate() {
            let (Some(elastic), Some(body)) = (solid.elastic(), solid.state.as_deformable()) else {
                continue;
            };
            let (stiffness, viscosity) = (dt * lookahead, dt * elastic.damping_time());
            let weights = TangentWeights { stiffness, project_psd: true, viscosity };
            if stiffness == 0.0 && viscosity == 0.0 {
                continue;
            }
            let place = |vertex: usize, a: usize| self.firsts[number] + (vertex * D + a) as u32;
            for (i, j, block) in elastic.tangent(&body.vertices.positions, weights).lower_blocks() {
                for (a, b) in (0..D).flat_map(|a| (0..D).map(move |b| (a, b))) {
                    entries.push((place(i, a), place(j, b), block[(a, b)]));
                    if i != j {
                        entries.push((place(j, b), place(i, a), block[(a, b)]));
                    }
                }
            }
        }
        SparseMatrix::of_entries([self.count(); 2], entries)
    }

    fn dx(&self) -> f64 {
        self.solids.model.grid.dx
    }

    fn is_angular(&self, solid: &SolidView<'_, D>, node: usize) -> bool {
        node == 1 && solid.elastic().is_none()
    }
}

/// Component `a` of `v + ω × r` by the unknowns from `first` on, with the arm `r` in cells.
fn rigid_row<const D: usize>(first: u32, a: usize, arm: &Vector<D>) -> Vec<Entry> {
    let angular = first + D as u32;
    if D == 2 {
        let sign = if a == 0 { -1.0 } else { 1.0 };
        return vec![(first + a as u32, 1.0), (angular, sign * arm[1 - a])];
    }
    let (b, c) = ((a + 1) % D, (a + 2) % D);
    vec![(first + a as u32, 1.0), (angular + b as u32, arm[c]), (angular + c as u32, -arm[b])]
}
