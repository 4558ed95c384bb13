//! Groups of elements over which strains are averaged, so that thin plates bend as they should.
//!
//! Linear simplices have one strain each and can bend only by shearing: plates of few layers are far too stiff. The
//! strain's mean over a group of elements knows nothing of that shear.
//!
//! **Cells.** The simplices around a longest edge make a group: in a lattice of squares cut into two triangles, or of cubes
//! cut into six tetrahedra around a diagonal, one group is one cell. The mean alone would let groups deform without any
//! energy (hourglasses), so that a little of the elements' own energy stays:
//!
//! ```text
//! E = Σ_groups V Ψ(mean F; λ − λ̂, μ − μ̂) + Σ_elements V Ψ(F; λ̂, μ̂),
//! μ̂ = μ/4,  λ̂ = 0.38 λ' − μ/10,  λ' = 2 λ μ / (λ + 2 μ),
//! ```
//!
//! where `λ'` is the first Lamé parameter of plane stress. In a layer of square cells, two triangles each and the diagonals
//! mirrored from cell to cell, a bent cell then has the energy that it should if `λ̂ + 3 μ̂ = 3/8 (2 μ + λ')`; the `−μ/10`
//! corrects for diagonals that are all parallel, and 0.38 for 3D, both by measurement (`tests/plates.rs`).
//!
//! **Edges.** Strains are averaged over the elements around each edge (Liu, Nguyen-Thoi & Lam 2009, "An edge-based smoothed
//! finite element method"; in 3D He et al. 2013). That needs no lattice, but couples vertices farther apart: in 3D the
//! factors are several times as large.

use super::density::Lame;
use crate::linalg::Cliques;
use meniscus_numerics::mesh::{Simplex, VolumeMesh};
use meniscus_numerics::{Matrix, Vector};

/// Over what strains are averaged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Smoothing {
    /// Nothing: each element has its own. For meshes of many layers only.
    None,
    /// The elements around a common longest edge, which is a cell in lattices of cubes: right within about 1 % from two
    /// layers on if cells are about as high as wide. Also a remedy against volumes that lock.
    #[default]
    Cells,
    /// The elements around each edge: for meshes without order. In 3D it costs several times as much.
    Edges,
    /// Quadratic.
    Quadratic,
}

/// A stretch of material with one deformation gradient `F = Σ x_v g_vᵀ`.
#[derive(Clone, Debug)]
pub(crate) struct Strains<const D: usize> {
    /// The vertices of each.
    pub vertices: Cliques,
    /// Points of each.
    pub per: usize,
    /// The gradients `g_v`, 1/m, as `vertices` in all lists.
    pub gradients: Vec<Vector<D>>,
    /// Volume of each, m³ (2D: m²).
    pub volumes: Vec<f64>,
    /// Elasticity of each.
    pub lame: Vec<Lame>,
}

/// An element's vertices with their gradients, and its volume.
type Element<const D: usize> = (Vec<(u32, Vector<D>)>, f64);

impl<const D: usize> Strains<D> {
    /// Of a body; every simplex must have a positive volume.
    pub fn new(mesh: &VolumeMesh<D>, lame: Lame, smoothing: Smoothing) -> Self {
        let elements: Vec<Element<D>> = mesh.simplices.iter().map(|s| element(mesh, s)).collect();
        let mut strains = Self { vertices: Cliques::default(), per: 1, gradients: Vec::new(), volumes: Vec::new(), lame: Vec::new() };
        match smoothing {
            Smoothing::None => elements.iter().for_each(|e| strains.push(&[e], 1.0, lame)),
            Smoothing::Cells => strains.cells(mesh, &elements, lame),
            Smoothing::Quadratic => {
                let points = super::quadratic::points(mesh);
                strains.per = D + 1;
                for (parent, (gradients, volumes)) in points {
                    strains.vertices.push(parent.nodes().iter().copied());
                    strains.gradients.extend(gradients);
                    strains.lame.extend(volumes.iter().map(|_| lame));
                    strains.volumes.extend(volumes);
                }
            }
            Smoothing::Edges => {
                let share = 2.0 / (D * (D + 1)) as f64;
                for around in
                    grouped(elements.iter().enumerate().flat_map(|(k, e)| edges(e).map(move |e| (e, k))))
                {
                    let around: Vec<&Element<D>> = around.iter().map(|k| &elements[*k]).collect();
                    strains.push(&around, share, lame);
                }
            }
        }
        strains
    }

    /// Vertices and gradients of a strain.
    pub fn part(&self, k: usize) -> (&[u32], &[Vector<D>]) {
        let (element, point) = (k / self.per, k % self.per);
        let range = self.vertices.range(element);
        let start = range.start * self.per + point * range.len();
        (self.vertices.get(element), &self.gradients[start..start + range.len()])
    }

    /// `F = Σ x_v g_vᵀ`; differences of positions, so that it is the same wherever the body is.
    pub fn gradient(&self, k: usize, x: &[Vector<D>]) -> Matrix<D> {
        let (vertices, gradients) = self.part(k);
        let first = x[vertices[0] as usize];
        let ahead = vertices.iter().zip(gradients).skip(1);
        ahead.fold(Matrix::zeros(), |f, (v, g)| f + (x[*v as usize] - first) * g.transpose())
    }

    fn cells(&mut self, mesh: &VolumeMesh<D>, elements: &[Element<D>], lame: Lame) {
        let own = hourglass(lame);
        let rest = Lame { lambda: lame.lambda - own.lambda, mu: lame.mu - own.mu };
        let longest = elements.iter().map(|e| longest_edge(mesh, e)).enumerate().map(|(k, edge)| (edge, k));
        for group in grouped(longest) {
            let group: Vec<&Element<D>> = group.iter().map(|k| &elements[*k]).collect();
            if let [single] = group[..] {
                self.push(&[single], 1.0, lame);
            } else {
                self.push(&group, 1.0, rest);
                group.iter().for_each(|e| self.push(&[*e], 1.0, own));
            }
        }
    }

    /// Adds the mean over elements, of a `share` of their volume.
    fn push(&mut self, elements: &[&Element<D>], share: f64, lame: Lame) {
        let volume: f64 = elements.iter().map(|e| e.1).sum();
        let mut all: Vec<(u32, Vector<D>)> =
            elements.iter().flat_map(|e| e.0.iter().map(|(v, g)| (*v, g * (e.1 / volume)))).collect();
        all.sort_by_key(|(v, _)| *v);
        let merged: Vec<(u32, Vector<D>)> =
            all.chunk_by(|a, b| a.0 == b.0).map(|same| (same[0].0, same.iter().map(|s| s.1).sum())).collect();
        self.vertices.push(merged.iter().map(|m| m.0));
        self.gradients.extend(merged.iter().map(|m| m.1));
        self.volumes.push(volume * share);
        self.lame.push(lame);
    }
}

/// What of the elements' own elasticity stays where cells are averaged.
fn hourglass(lame: Lame) -> Lame {
    let plane = 2.0 * lame.lambda * lame.mu / (lame.lambda + 2.0 * lame.mu);
    let mu = 0.25 * lame.mu;
    Lame { lambda: (0.38 * plane - 0.1 * lame.mu).max(-0.5 * mu), mu }
}

fn element<const D: usize>(mesh: &VolumeMesh<D>, simplex: &Simplex<D>) -> Element<D> {
    let volume = simplex.volume(&mesh.positions);
    let cofactors = super::density::cofactor(&simplex.edges(&mesh.positions));
    let scale = if D == 2 { 0.5 } else { 1.0 / 6.0 } / volume;
    let mut gradients: Vec<(u32, Vector<D>)> =
        (0..D).map(|k| (simplex.rest[k], cofactors.column(k) * scale)).collect();
    let sum: Vector<D> = gradients.iter().map(|g| g.1).sum();
    gradients.push((simplex.root, -sum));
    (gradients, volume)
}

fn edges<const D: usize>(element: &Element<D>) -> impl Iterator<Item = [u32; 2]> + '_ {
    let vertices = &element.0;
    (0..=D).flat_map(move |a| {
        (a + 1..=D).map(move |b| {
            let [a, b] = [vertices[a].0, vertices[b].0];
            [a.min(b), a.max(b)]
        })
    })
}

/// The longest edge; of those as long to rounding, that with the largest vertex numbers.
fn longest_edge<const D: usize>(mesh: &VolumeMesh<D>, element: &Element<D>) -> [u32; 2] {
    let length = |e: [u32; 2]| (mesh.positions[e[1] as usize] - mesh.positions[e[0] as usize]).norm();
    let longest = edges(element).map(length).fold(0.0, f64::max);
    edges(element).filter(|e| length(*e) > longest * (1.0 - 1e-9)).fold([0, 0], |a, b| a.max(b))
}

/// Elements that share a key, in the order of keys.
fn grouped(keyed: impl Iterator<Item = ([u32; 2], usize)>) -> Vec<Vec<usize>> {
    let mut keyed: Vec<([u32; 2], usize)> = keyed.collect();
    keyed.sort_unstable();
    keyed.chunk_by(|a, b| a.0 == b.0).map(|same| same.iter().map(|s| s.1).collect()).collect()
}
