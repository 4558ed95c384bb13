//! The momentum rows of the coupled systems: of solids with the liquid that moves with them (Eq. 9 and 10), and of solids and line with
//! theirs (Eq. 12 to 14).
//!
//! ```text
//! (M̃_s − Δt D_s) v_s + W_sᵀ V∇p̂ = M_s v_s* + W_sᵀ M u* + W_sᵀ P (M_c⁰ v_c*),   M̃_s = M_s + W_sᵀ M W_s + W_sᵀ (P M_c⁰) W_s
//!  M̃_c           v_c + W_cᵀ V∇p̂ = σ M_c⁰ v_c*   + W_cᵀ M u*,                     M̃_c = σ M_c⁰ + W_cᵀ M W_c
//! ```
//!
//! `P` is [`LineMap::distribution`], `σ` [`LineMap::liquid_share`]. As printed `P = W_c`, `σ = 1`, and the masses are lumped (E6 to E8).
//! Corrected, the sums of `σ` and of the columns of `P` are one, and `Σ M_c⁰ v_c*` arrives once. With [`Errata::balanced_force`] the `M` of
//! liquid–air faces is that of a whole cell, as in the equation of the pressure: else its gradient, which acts on a whole cell, and the force
//! of Eq. 6, which acts on `M`, are out of balance (E24).
//!
//! Impulses that act on the solids themselves are added to their rows ([`MomentumRows::push_faces`], [`MomentumRows::push_vertices`]).
//!
//! Every face has one owner: liquid–solid faces move with the solids, liquid–air faces around the line with the line, and the equation
//! of the pressure leaves both out of `∇·u*` and `∇²` (E20). A component of a particle without liquid–air faces is no unknown; it moves
//! with the solid.

use super::line_map::LineMap;
use super::solid_map::SolidMap;
use super::sparse_matrix::{Entry, SparseMatrix};
use crate::paper::fluid::cells::{CellTypes, Face, FaceType};
use crate::paper::fluid::fractions::liquid_mass;
use crate::paper::{Errata, LiquidMass};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::{FaceField, Sampler};

/// Faces that move with unknowns, and the momentum rows of these unknowns.
#[derive(Clone, Debug)]
pub struct MomentumRows {
    /// The faces, sorted.
    pub owned: Vec<Face>,
    /// The map from the unknowns to the velocities of the faces.
    pub map: SparseMatrix,
    /// `M̃ − Δt D`, kg (2D: kg/m); symmetric.
    pub mass: SparseMatrix,
    /// The right-hand sides, kg m/s (2D: kg/s).
    pub momentum: Vec<f64>,
    /// The values of unknowns that are given, m/s.
    pub prescribed: Vec<Option<f64>>,
}

impl MomentumRows {
    /// Adds impulses on faces along their axes, N s (2D: N s/m), to the momenta of what moves with them; those on other faces do not count.
    pub fn push_faces(&mut self, impulses: &[(Face, f64)]) {
        for (face, impulse) in impulses {
            let Ok(row) = self.owned.binary_search(face) else { continue };
            self.map.row(row).iter().for_each(|(j, weight)| self.momentum[*j as usize] += weight * impulse);
        }
    }

    /// Adds impulses on the components of the vertices of the solids' surfaces, N s (2D: N s/m), to the momenta of the solids.
    pub fn push_vertices(&mut self, embedding: &SparseMatrix, impulses: &[f64]) {
        add_transposed(&mut self.momentum, embedding, impulses);
    }
}

/// The liquid before the solve.
#[derive(Clone, Copy)]
pub struct Liquid<'a, const D: usize> {
    /// Types of the cells.
    pub types: &'a CellTypes<D>,
    /// The level set, m.
    pub phi: Sampler<'a, D>,
    /// Density, kg/m³.
    pub density: f64,
    /// `u*`, m/s.
    pub velocity: &'a FaceField<D>,
    /// Errata.
    pub errata: Errata,
}

/// The solids before the solve.
#[derive(Clone, Copy)]
pub struct SolidMomentum<'a> {
    /// `J`: unknowns to components of the surfaces' vertices.
    pub embedding: &'a SparseMatrix,
    /// `M_s`, kg (2D: kg/m).
    pub mass: &'a SparseMatrix,
    /// `−Δt D_s`, kg (2D: kg/m).
    pub damping: &'a SparseMatrix,
    /// `v_s*`, m/s; of prescribed unknowns their values.
    pub velocity: &'a [f64],
    /// Whether each unknown is prescribed.
    pub is_prescribed: &'a [bool],
}

/// The line before the solve.
#[derive(Clone, Copy)]
pub struct LineMomentum<'a, const D: usize> {
    /// The map of its particles.
    pub map: &'a LineMap<D>,
    /// `M_c⁰` of each particle, kg (2D: kg/m).
    pub intrinsic_mass: &'a [f64],
    /// `v_c*`, m/s.
    pub velocity: &'a [Vector<D>],
}

/// Velocities and forces of line particles, for [`Self::intermediate_velocities`].
#[derive(Clone, Copy, Debug)]
pub struct LineForces<'a, const D: usize> {
    /// `v_c`, m/s.
    pub velocity: &'a [Vector<D>],
    /// `f_c`, N (2D: N/m).
    pub force: &'a [Vector<D>],
    /// `M_c⁰`, kg (2D: kg/m).
    pub intrinsic_mass: &'a [f64],
    /// The lumped mass `m_c` of Section 4.3.1, kg (2D: kg/m).
    pub lumped_mass: &'a [f64],
}

impl<const D: usize> LineForces<'_, D> {
    /// `v_c* = v_c + Δt f_c/M_c` (Eq. 21), m/s. `M_c` is the intrinsic mass, as in Eq. 14, or as printed the lumped one (E9).
    pub fn intermediate_velocities(&self, dt: f64, errata: Errata) -> Vec<Vector<D>> {
        let mass = if errata.intrinsic_mass_in_eq_21 { self.intrinsic_mass } else { self.lumped_mass };
        let particles = self.velocity.iter().zip(self.force).zip(mass);
        particles.map(|((v, f), m)| v + f * (dt / m)).collect()
    }
}

impl<const D: usize> Liquid<'_, D> {
    /// Masses with which liquid–air faces move, kg (2D: kg/m).
    fn masses_beside_air(&self, faces: &[Face]) -> Vec<f64> {
        match self.errata.balanced_force {
            true => vec![self.density * self.types.grid().cell_volume(); faces.len()],
            false => self.masses(faces),
        }
    }

    /// Masses of the liquid in the dual cells of faces, kg (2D: kg/m).
    fn masses(&self, faces: &[Face]) -> Vec<f64> {
        faces.iter().map(|f| liquid_mass(&self.phi, self.types, self.density, *f)).collect()
    }

    /// Momenta of the liquid in the dual cells, with these masses.
    fn momenta(&self, faces: &[Face], masses: &[f64]) -> Vec<f64> {
        faces.iter().zip(masses).map(|(f, m)| m * self.velocity.axes[f.axis][f.index]).collect()
    }
}

/// Entries of the mass that moves with faces: `(W J)ᵀ M (W J)`, or `Jᵀ diag(Wᵀ M 1) J`. `on_vertices` is `W` on the components of vertices.
fn mass_of_faces(
    on_vertices: &SparseMatrix,
    embedding: &SparseMatrix,
    masses: &[f64],
    form: LiquidMass,
) -> Vec<(u32, u32, f64)> {
    match form {
        LiquidMass::Consistent => on_vertices.product(embedding).weighted_gram(masses).collect(),
        LiquidMass::Lumped => embedding.weighted_gram(&on_vertices.multiply_transposed(masses)).collect(),
    }
}

/// Adds `Aᵀ x` to `y`.
fn add_transposed(y: &mut [f64], matrix: &SparseMatrix, x: &[f64]) {
    y.iter_mut().zip(matrix.multiply_transposed(x)).for_each(|(y, product)| *y += product);
}

/// The rows of Eq. 10, with the liquid–solid faces of the map.
pub fn solid_rows<const D: usize>(
    liquid: &Liquid<'_, D>,
    map: &SolidMap<D>,
    solids: &SolidMomentum<'_>,
) -> MomentumRows {
    let is_wetted = |i: &usize| liquid.types.face(map.faces[*i]) == FaceType::LiquidSolid;
    let wetted: Vec<usize> = (0..map.faces.len()).filter(is_wetted).collect();
    let owned: Vec<Face> = wetted.iter().map(|i| map.faces[*i]).collect();
    let on_vertices = map.on_components().select(&wetted);
    let faces = on_vertices.product(solids.embedding);
    let masses = liquid.masses(&owned);
    let form = liquid.errata.liquid_mass;
    let liquid_mass = mass_of_faces(&on_vertices, solids.embedding, &masses, form);
    let entries = solids.mass.entries().chain(solids.damping.entries()).chain(liquid_mass);
    let mut momentum = solids.mass.multiply(solids.velocity);
    add_transposed(&mut momentum, &faces, &liquid.momenta(&owned, &masses));
    let given = solids.is_prescribed.iter().zip(solids.velocity).map(|(is, v)| is.then_some(*v));
    MomentumRows {
        owned,
        map: faces,
        mass: SparseMatrix::of_entries([solids.mass.rows(); 2], entries),
        momentum,
        prescribed: given.collect(),
    }
}

/// The rows of Eq. 13 and 14: adds the line to the rows of the solids, whose map has the solid–air faces around the line too. Also the
/// unknown of each component of a particle, counted after those of the solids; `None` where it has no liquid–air face.
pub fn with_line<const D: usize>(
    rows: MomentumRows,
    liquid: &Liquid<'_, D>,
    map: &SolidMap<D>,
    embedding: &SparseMatrix,
    line: &LineMomentum<'_, D>,
) -> (MomentumRows, Vec<[Option<usize>; D]>) {
    let solid_count = rows.mass.rows();
    let (unknowns, line_count) = line_unknowns(line.map, solid_count);
    let count = solid_count + line_count;
    let mut momentum = [rows.momentum, vec![0.0; line_count]].concat();
    let mut entries: Vec<(u32, u32, f64)> = rows.mass.entries().collect();
    let form = liquid.errata.liquid_mass;
    add_line_to_solids(&mut momentum[..solid_count], &mut entries, map, embedding, line, form);

    // The line's own rows.
    let of_line = |(i, face): (usize, &Face)| -> Vec<Entry> {
        let entry = |(c, weight): &Entry| Some((unknowns[*c as usize][face.axis]? as u32, *weight));
        line.map.interpolation.row(i).iter().filter_map(entry).collect()
    };
    let line_rows = SparseMatrix::new(count, line.map.liquid_air.iter().enumerate().map(of_line));
    let masses = liquid.masses_beside_air(&line.map.liquid_air);
    add_transposed(&mut momentum, &line_rows, &liquid.momenta(&line.map.liquid_air, &masses));
    match form {
        LiquidMass::Consistent => entries.extend(line_rows.weighted_gram(&masses)),
        LiquidMass::Lumped => {
            let lumped = line_rows.multiply_transposed(&masses).into_iter().enumerate();
            entries.extend(lumped.skip(solid_count).map(|(j, m)| (j as u32, j as u32, m)));
        }
    }
    for (c, own) in unknowns.iter().enumerate() {
        for (a, j) in own.iter().enumerate().filter_map(|(a, j)| Some((a, (*j)?))) {
            let mass = line.map.liquid_share[c][a] * line.intrinsic_mass[c];
            entries.push((j as u32, j as u32, mass));
            momentum[j] += mass * line.velocity[c][a];
        }
    }

    let all = rows.owned.iter().enumerate().map(|(i, face)| (*face, rows.map.row(i).to_vec()));
    let of_line = line.map.liquid_air.iter().enumerate().map(|(i, face)| (*face, line_rows.row(i).to_vec()));
    let mut faces: Vec<(Face, Vec<Entry>)> = all.chain(of_line).collect();
    faces.sort_by_key(|(face, _)| *face);
    let (owned, map): (Vec<Face>, Vec<Vec<Entry>>) = faces.into_iter().unzip();
    let rows = MomentumRows {
        owned,
        map: SparseMatrix::new(count, map),
        mass: SparseMatrix::of_entries([count; 2], entries),
        momentum,
        prescribed: [rows.prescribed, vec![None; line_count]].concat(),
    };
    (rows, unknowns)
}

/// Numbers the components of particles that move liquid–air faces, from `first` on.
fn line_unknowns<const D: usize>(map: &LineMap<D>, first: usize) -> (Vec<[Option<usize>; D]>, usize) {
    let mut unknowns = vec![[None; D]; map.liquid_share.len()];
    for (i, face) in map.liquid_air.iter().enumerate() {
        map.interpolation.row(i).iter().for_each(|(c, _)| unknowns[*c as usize][face.axis] = Some(0));
    }
    let mut next = first;
    for slot in unknowns.iter_mut().flatten().filter(|slot| slot.is_some()) {
        *slot = Some(next);
        next += 1;
    }
    (unknowns, next - first)
}

/// Adds the part of the line's mass and impulse that solids get (Eq. 12 and 14), through the solid–air faces.
fn add_line_to_solids<const D: usize>(
    momentum: &mut [f64],
    entries: &mut Vec<(u32, u32, f64)>,
    map: &SolidMap<D>,
    embedding: &SparseMatrix,
    line: &LineMomentum<'_, D>,
    form: LiquidMass,
) {
    let places = line.map.solid_air.iter().enumerate();
    let known = places.filter_map(|(i, face)| Some((i, map.faces.binary_search(face).ok()?)));
    let (of_line, of_map): (Vec<usize>, Vec<usize>) = known.unzip();
    let on_vertices = map.on_components().select(&of_map);
    let parts = line.map.distribution.select(&of_line);
    let masses = parts.multiply(line.intrinsic_mass);
    let impulse = |(row, i): (usize, &usize)| -> f64 {
        let axis = line.map.solid_air[*i].axis;
        let of =
            |(c, part): &Entry| part * line.intrinsic_mass[*c as usize] * line.velocity[*c as usize][axis];
        parts.row(row).iter().map(of).sum()
    };
    let impulses: Vec<f64> = of_line.iter().enumerate().map(impulse).collect();
    entries.extend(mass_of_faces(&on_vertices, embedding, &masses, form));
    add_transposed(momentum, &on_vertices.product(embedding), &impulses);
}
