//! The map `W_c` between line particles and faces (Section 5.2, Fig. 8).
//!
//! Incident to a particle are the liquid–air and the solid–air faces whose centres lie within the radius `R` of it. Liquid–air faces move
//! with the line, `u_f = Σ_c W_fc v_c`: each takes the mean of the particles that it is incident to, so that rows add up to one.
//!
//! An impulse of the line goes to its incident faces: the part of liquid–air faces moves the liquid, that of solid–air faces goes on to the
//! solid through `W_sᵀ`. With [`LineImpulse::ByFaces`] each component is divided evenly between the incident faces of its axis, so
//! that a particle's parts add up to one. As printed the weights are those of `W_c`, whose rows add up to one, and not its columns, and
//! the liquid gets all of the impulse as well (E7, E8). With [`LineImpulse::ByDirections`] the velocity of a particle is that which its force on
//! the liquid gives it; all of it goes to liquid–air faces (E22).
//!
//! With free faces ([`Errata::free_faces`], E26) the line owns none: [`push_faces`] adds its impulses to the velocity.
//!
//! The paper does not give the weights of incident faces; here they are equal. A component whose axis has no incident face reaches
//! nothing, and is counted.

use super::sparse_matrix::{Entry, SparseMatrix};
use crate::paper::fluid::cells::{CellType, CellTypes, Face, FaceType};
use crate::paper::{Errata, LineImpulse};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::FaceField;

/// `W_c`, and how impulses of the line are divided.
#[derive(Clone, Debug)]
pub struct LineMap<const D: usize> {
    /// The liquid–air faces that move with the line, sorted.
    pub liquid_air: Vec<Face>,
    /// `W_c` of these faces; its columns are the particles.
    pub interpolation: SparseMatrix,
    /// The solid–air faces around the line, sorted.
    pub solid_air: Vec<Face>,
    /// The part of each particle's impulse that each of them gets.
    pub distribution: SparseMatrix,
    /// For each particle and axis the part of the impulse that the liquid gets.
    pub liquid_share: Vec<[f64; D]>,
    /// Number of components of particles without incident faces.
    pub unreached: u64,
}

/// The faces of a type around particles, with the particles that each one is incident to.
struct IncidentFaces {
    faces: Vec<Face>,
    particles: Vec<Vec<u32>>,
}

impl<const D: usize> LineMap<D> {
    /// The map for particles at given positions, m, with incident faces within a radius, m.
    pub fn new(types: &CellTypes<D>, particles: &[Vector<D>], radius: f64, errata: Errata) -> Self {
        let around = |kind| IncidentFaces::new(types, types.faces_of(kind), particles, radius);
        let liquid = around(FaceType::LiquidAir);
        let solid = match errata.line_impulse {
            LineImpulse::ByDirections => IncidentFaces { faces: Vec::new(), particles: Vec::new() },
            _ => around(FaceType::SolidAir),
        };
        let [of_liquid, of_solid] = [&liquid, &solid].map(|of| of.counts::<D>(particles.len()));
        let total = |c: usize, a: usize| of_liquid[c][a] + of_solid[c][a];
        let share = |c: usize| {
            std::array::from_fn(|a| match (errata.line_impulse, total(c, a)) {
                (LineImpulse::ForBoth, _) => 1.0,
                (_, 0) => 0.0,
                (_, all) => of_liquid[c][a] as f64 / all as f64,
            })
        };
        let divided = |(face, to): (&Face, &Vec<u32>)| -> Vec<Entry> {
            to.iter().map(|c| (*c, 1.0 / total(*c as usize, face.axis) as f64)).collect()
        };
        let distribution = match errata.line_impulse {
            LineImpulse::ForBoth => solid.mean(particles.len()),
            _ => SparseMatrix::new(particles.len(), solid.faces.iter().zip(&solid.particles).map(divided)),
        };
        let unreached = (0..particles.len()).flat_map(|c| (0..D).map(move |a| (c, a)));
        Self {
            interpolation: liquid.mean(particles.len()),
            distribution,
            liquid_share: (0..particles.len()).map(share).collect(),
            unreached: unreached.filter(|(c, a)| total(*c, *a) == 0).count() as u64,
            liquid_air: liquid.faces,
            solid_air: solid.faces,
        }
    }
}

/// Part of a face along the force of a particle below which the faces around it cannot take the force up.
const MIN_FACES: f64 = 0.5;

/// Adds the impulses of particles, N s (2D: N s/m), to the velocity of the liquid–air faces within a radius (m) of each, for faces of a mass
/// (kg; 2D: kg/m): as a pressure `P w n`, with the normal `n` of each face out of the liquid and the weight `w = 1 − d/R` at the distance
/// `d`, such that the sum has the component of the impulse along it. Returns what the sums have beside the impulses, N s, and the number
/// of particles whose impulse reaches nothing.
///
/// Divided evenly by axes instead, the impulse drives a current around every step of the cells at the surface: at 90 degrees a drop on 32
/// cells comes to rest at 97.
pub fn push_faces<const D: usize>(
    types: &CellTypes<D>,
    [particles, impulses]: [&[Vector<D>]; 2],
    radius: f64,
    face_mass: f64,
    velocity: &mut FaceField<D>,
) -> (Vec<Vector<D>>, u64) {
    let liquid = IncidentFaces::new(types, types.faces_of(FaceType::LiquidAir), particles, radius);
    let mut sums = vec![Vector::<D>::zeros(); particles.len()];
    let weighted = |face: &Face, c: usize| {
        let is_liquid = types.sides(*face)[0].is_some_and(|cell| types.cell(cell) == CellType::Liquid);
        let weight = 1.0 - (types.center(*face) - particles[c]).norm() / radius;
        if is_liquid { weight } else { -weight }
    };
    for (face, near) in liquid.faces.iter().zip(&liquid.particles) {
        near.iter().for_each(|c| sums[*c as usize][face.axis] += weighted(face, *c as usize));
    }
    let pressure = |(impulse, sum): (&Vector<D>, &Vector<D>)| {
        let along = impulse.try_normalize(0.0).map_or(0.0, |direction| sum.dot(&direction));
        (along.abs() >= MIN_FACES).then(|| impulse.norm() / along)
    };
    let pressures: Vec<Option<f64>> = impulses.iter().zip(&sums).map(pressure).collect();
    for (face, near) in liquid.faces.iter().zip(&liquid.particles) {
        let of = |c: &u32| pressures[*c as usize].unwrap_or(0.0) * weighted(face, *c as usize);
        velocity.axes[face.axis][face.index] += near.iter().map(of).sum::<f64>() / face_mass;
    }
    let beside = |((impulse, sum), p): ((&Vector<D>, &Vector<D>), &Option<f64>)| {
        p.map_or(-impulse, |p| sum * p - impulse)
    };
    let rest = impulses.iter().zip(&sums).zip(&pressures).map(beside).collect();
    let lost = impulses.iter().zip(&pressures).filter(|(impulse, p)| p.is_none() && impulse.norm() > 0.0);
    (rest, lost.count() as u64)
}

impl IncidentFaces {
    fn new<const D: usize>(
        types: &CellTypes<D>,
        faces: Vec<Face>,
        particles: &[Vector<D>],
        radius: f64,
    ) -> Self {
        let near = |face: &Face| -> Vec<u32> {
            let x = types.center(*face);
            let within = particles.iter().enumerate().filter(|(_, p)| (*p - x).norm() <= radius);
            within.map(|(c, _)| c as u32).collect()
        };
        let incident = faces.into_iter().map(|face| (face, near(&face))).filter(|(_, near)| !near.is_empty());
        let (faces, particles) = incident.unzip();
        Self { faces, particles }
    }

    /// Number of incident faces for each particle and axis.
    fn counts<const D: usize>(&self, particles: usize) -> Vec<[usize; D]> {
        let mut counts = vec![[0; D]; particles];
        for (face, near) in self.faces.iter().zip(&self.particles) {
            near.iter().for_each(|c| counts[*c as usize][face.axis] += 1);
        }
        counts
    }

    /// The mean of the particles of each face.
    fn mean(&self, particles: usize) -> SparseMatrix {
        let row = |near: &Vec<u32>| near.iter().map(|c| (*c, 1.0 / near.len() as f64)).collect::<Vec<_>>();
        SparseMatrix::new(particles, self.particles.iter().map(row))
    }
}
