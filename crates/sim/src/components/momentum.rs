//! Momentum of the liquid's components, and its restoration.
//!
//! Advection and surface tension are accurate but not conservative. A component that touches nothing must keep
//! its mean velocity (except for gravity) and its angular momentum: after each step a uniform velocity and a
//! rigid rotation restore both. Rigid motions are divergence-free, except in cells that a free solid cuts,
//! where they leave a divergence. Components that merge or split in a step form one [`RigidMotion`], whose
//! angular momentum includes that of their orbits. A centre is that of the volume within the interface, which
//! the volume correction keeps on its path; the centres of the faces (one per axis) jitter.

use super::group::{ComponentGroup, RigidMotion};
use super::moments::{Moments, RowSums};
use crate::free_surface::interface_faces::InterfaceFace;
use crate::model::Model;
use meniscus_numerics::grid::{CellField, FaceField, Segment};
use meniscus_numerics::{Matrix, Vector, par, rotation_planes};
use std::iter::zip;

/// Largest ratio between the mass of a group's faces and that of its volume. Beyond it the cells lie between solids, and the mean over
/// the faces is not the velocity.
const MAX_MASS_RATIO: f64 = 2.0;

/// Consecutive faces of a row along the first axis that belong to one component.
struct Stretch<const D: usize> {
    component: u32,
    /// The first face on the lattice of faces, and its position in memory.
    first: [usize; D],
    first_face: usize,
    /// Number of faces.
    length: usize,
}

impl<const D: usize> Stretch<D> {
    /// Positions in memory.
    fn faces(&self) -> std::ops::Range<usize> {
        self.first_face..self.first_face + self.length
    }

    /// Place on the lattice of faces of the `n`-th face.
    fn at(&self, n: usize) -> [usize; D] {
        let mut at = self.first;
        at[0] += n;
        at
    }
}

/// Angular velocity that carries a given angular momentum, for the second moments `spread` (axis of the faces, two axes of the
/// positions); directions of less inertia than `min_inertia` are left out.
fn rotation_rate<const D: usize>(
    momentum: [f64; 3],
    min_inertia: f64,
    spread: impl Fn(usize, usize, usize) -> f64,
) -> [f64; 3] {
    // Rotation in plane (a, b): u_b += ω x_a, u_a −= ω x_b.
    let mut inertia = Matrix::<3>::zeros();
    for (i, &(a, b, _)) in rotation_planes::<D>().iter().enumerate() {
        for (j, &(c, d, _)) in rotation_planes::<D>().iter().enumerate() {
            for (axis, arm, s) in [(b, a, 1.0), (a, b, -1.0)] {
                for (other, lever, t) in [(d, c, 1.0), (c, d, -1.0)] {
                    if axis == other {
                        inertia[(i, j)] += s * t * spread(axis, arm, lever);
                    }
                }
            }
        }
    }
    let mut right = Vector::<3>::zeros();
    rotation_planes::<D>().iter().enumerate().for_each(|(i, p)| right[i] = momentum[p.2]);
    // The faces of a component one cell thick lie in one plane: it has no inertia in some directions.
    let inverse = inertia.symmetric_eigen();
    let mut rate = [0.0; 3];
    for (k, value) in inverse.eigenvalues.iter().enumerate().filter(|(_, value)| **value > min_inertia) {
        let direction = inverse.eigenvectors.column(k);
        let part = direction.dot(&right) / value;
        rotation_planes::<D>().iter().enumerate().for_each(|(i, p)| rate[p.2] += part * direction[i]);
    }
    rate
}

/// Result of restoring the momentum.
pub struct MomentumRestoration<const D: usize> {
    /// Moments of every component afterwards.
    pub moments: Vec<Moments<D>>,
    /// Restored momentum, kg m/s (2D: kg/s), sum of magnitudes over all groups.
    pub momentum: f64,
    /// Restored angular momentum, kg m²/s (2D: kg m/s), likewise.
    pub angular_momentum: f64,
    /// Groups whose momentum was not restored because they lie between solids.
    pub unrestored: u64,
    /// Number of lookups of cells without a component.
    pub unlabelled: u64,
}

/// The motions that components must have.
#[derive(Clone, Copy)]
pub struct MomentumTargets<'a, const D: usize> {
    /// Groups of components; those without a target motion are left as they are.
    pub groups: &'a [ComponentGroup<D>],
    /// Target volume of each component, m³ (2D: m²).
    pub volumes: &'a [f64],
    /// Centre of mass of each component, m.
    pub centers: &'a [Vector<D>],
    /// Time for which gravity has accelerated the groups since their target motions, s.
    pub gravity_time: f64,
}

/// Iterates over the faces of each component.
pub struct ComponentFaces<'a, const D: usize> {
    /// The model.
    pub model: &'a Model<D>,
    /// Signed distance, m, to identify liquid cells.
    pub phi: &'a CellField<D>,
    /// The liquid's faces.
    pub faces: &'a [Vec<Segment>; D],
    /// Open fractions of the faces, if there are solids.
    pub open_fractions: Option<&'a FaceField<D>>,
    /// The faces at the interface.
    pub interface_faces: &'a [InterfaceFace],
    /// Component of a liquid cell.
    pub label: &'a (dyn Fn(usize) -> u32 + Sync),
    /// Number of components.
    pub component_count: usize,
}

impl<const D: usize> ComponentFaces<'_, D> {
    /// The moments of every component.
    pub fn moments(&self, velocity: &FaceField<D>) -> Vec<Moments<D>> {
        let mut total = vec![Moments::zero(); self.component_count];
        for a in 0..D {
            let chunks: Vec<&[Segment]> = self.faces[a].chunks(256).collect();
            let sums = par::map_slice(&chunks, 1, |chunk| self.chunk(a, chunk, &velocity.axes[a]));
            for (component, moments) in sums.iter().flatten() {
                total[*component as usize].add(moments, 1.0);
            }
        }
        let places = par::map_slice(self.interface_faces, 256, |f| self.place(f));
        for (f, (component, x)) in zip(self.interface_faces, &places) {
            let u = velocity.axes[f.axis][f.face];
            total[*component as usize].add_face(f.axis, f.theta * f.open_fraction, x, u);
        }
        total
    }

    /// The component and the centre, m, of a face at the interface.
    fn place(&self, f: &InterfaceFace) -> (u32, Vector<D>) {
        let grid = &self.model.grid;
        ((self.label)(f.cell), grid.face_center(f.axis, grid.face_lattice(f.axis).coordinates(f.face)))
    }

    fn chunk(&self, a: usize, segments: &[Segment], values: &[f64]) -> Vec<(u32, Moments<D>)> {
        let grid = &self.model.grid;
        let mut out: Vec<(u32, Moments<D>)> = Vec::new();
        for s in segments {
            self.for_each_inner_stretch(a, s, |stretch| {
                let mut row = RowSums::default();
                for (n, face) in stretch.faces().enumerate() {
                    let mass = self.open_fractions.map_or(1.0, |open| open.axes[a][face]);
                    row.add(mass, grid.face_center(a, stretch.at(n))[0], values[face]);
                }
                let place = out.iter().position(|(c, _)| *c == stretch.component).unwrap_or_else(|| {
                    out.push((stretch.component, Moments::zero()));
                    out.len() - 1
                });
                out[place].1.add_row(a, &row, &grid.face_center(a, stretch.first));
            });
        }
        out
    }

    /// Calls `f` for each stretch of faces of a segment that lie between two liquid cells.
    fn for_each_inner_stretch(&self, a: usize, s: &Segment, mut f: impl FnMut(&Stretch<D>)) {
        let (faces, cells) = (self.model.grid.face_lattice(a), self.model.grid.lattice());
        let row = faces.coordinates(s.row * faces.extent[0]);
        let (mut start, mut end) = (s.start, s.end);
        if a == 0 {
            (start, end) = (start.max(1), end.min(cells.extent[0]));
        } else if row[a] == 0 || row[a] == cells.extent[a] {
            return;
        }
        let (upper, face) = (cells.index(row), faces.index(row));
        let is_inner = |i: usize| {
            let is_open = self.open_fractions.is_none_or(|open| open.axes[a][face + i] != 0.0);
            is_open && self.phi.data[upper + i] < 0.0 && self.phi.data[upper + i - cells.stride[a]] < 0.0
        };
        while start < end {
            let length = (start..end).take_while(|i| is_inner(*i)).count();
            if length > 0 {
                let mut first = row;
                first[0] = start;
                let component = (self.label)(upper + start);
                f(&Stretch { component, first, first_face: face + start, length });
            }
            // The face at the end of the stretch, if there is one, is no inner face.
            start += length + 1;
        }
    }

    /// Whether the mass of a group's faces agrees with that of its volume.
    fn is_mass_consistent(&self, group: &ComponentGroup<D>, moments: &[Moments<D>], targets: &[f64]) -> bool {
        let faces = group.new.iter().flat_map(|&j| moments[j].mass).sum::<f64>() / D as f64;
        let cells = group.new.iter().map(|&j| targets[j]).sum::<f64>() / self.model.grid.cell_volume();
        faces.max(cells) <= MAX_MASS_RATIO * faces.min(cells)
    }

    /// Restores momentum and angular momentum of every group.
    pub fn restore(
        &self,
        velocity: &mut FaceField<D>,
        targets: &MomentumTargets<'_, D>,
    ) -> MomentumRestoration<D> {
        let moments = self.moments(velocity);
        let mut restored = MomentumRestoration {
            moments: Vec::new(),
            momentum: 0.0,
            angular_momentum: 0.0,
            unrestored: 0,
            unlabelled: 0,
        };
        let mut motions: Vec<Option<VelocityCorrection<D>>> = vec![None; self.component_count];
        for group in targets.groups {
            let Some(target) = group.target_motion.clone() else { continue };
            if !self.is_mass_consistent(group, &moments, targets.volumes) {
                restored.unrestored += 1;
                continue;
            }
            let lack = self.lacking_motion(group, target, &moments, targets);
            restored.momentum += self.model.density * lack.volume * lack.velocity.norm();
            let mut rate = [0.0; 3];
            if group.keeps_angular_momentum {
                let missing = lack.angular_momentum_per_density;
                restored.angular_momentum += self.model.density * Vector::<3>::from(missing).norm();
                let least = 1e-6 * lack.volume * self.model.grid.dx.powi(2);
                rate = rotation_rate::<D>(missing, least, |a, b, c| lack.second_moment(a, b, c));
            }
            zip(&group.new, lack.corrections(rate)).for_each(|(&j, motion)| motions[j] = Some(motion));
        }
        if motions.iter().all(Option::is_none) {
            return MomentumRestoration { moments, ..restored };
        }
        self.add_rigid_velocities(velocity, &motions);
        MomentumRestoration { moments: self.moments(velocity), ..restored }
    }

    /// Difference between the `target` motion of a group, accelerated by gravity, and its motion of these `moments`.
    fn lacking_motion(
        &self,
        group: &ComponentGroup<D>,
        mut target: RigidMotion<D>,
        moments: &[Moments<D>],
        targets: &MomentumTargets<'_, D>,
    ) -> LackingMotion<D> {
        let MomentumTargets { volumes, centers, gravity_time, .. } = *targets;
        let parts: Vec<Moments<D>> =
            group.new.iter().map(|&j| moments[j].scaled_to_mass(volumes[j])).collect();
        let now = combined(zip(&group.new, &parts).map(|(&j, m)| m.rigid_motion(centers[j])));
        if !group.unconstrained_projector.is_identity(0.0) {
            target = target.moved_to(now.center);
        }
        LackingMotion {
            parts,
            arms: group.new.iter().map(|&j| centers[j] - target.center).collect(),
            volume: target.volume,
            velocity: target.velocity + self.model.gravity * gravity_time - now.velocity,
            angular_momentum_per_density: std::array::from_fn(|i| {
                target.angular_momentum_per_density[i] - now.angular_momentum_per_density[i]
            }),
        }
    }

    /// Adds a velocity to each component.
    pub fn add_velocities(&self, velocity: &mut FaceField<D>, by: &[Vector<D>]) {
        let still = |v: &Vector<D>| VelocityCorrection {
            velocity: *v,
            rotation_rate: [0.0; 3],
            mean_positions: [Vector::zeros(); D],
        };
        let motions: Vec<Option<VelocityCorrection<D>>> =
            by.iter().map(|v| v.iter().any(|u| *u != 0.0).then(|| still(v))).collect();
        if motions.iter().any(Option::is_some) {
            self.add_rigid_velocities(velocity, &motions);
        }
    }

    fn add_rigid_velocities(&self, velocity: &mut FaceField<D>, motions: &[Option<VelocityCorrection<D>>]) {
        let motion = |a: usize, x: &Vector<D>, component: u32| -> f64 {
            motions[component as usize].as_ref().map_or(0.0, |m| {
                m.velocity[a] + rotational_velocity(&m.rotation_rate, &(x - m.mean_positions[a]))[a]
            })
        };
        for a in 0..D {
            let row = self.model.grid.face_lattice(a).extent[0];
            par::for_each_segment(&mut velocity.axes[a], row, &self.faces[a], |s, part| {
                let base = s.row * row + s.start;
                self.for_each_inner_stretch(a, s, |stretch| {
                    for (n, face) in stretch.faces().enumerate() {
                        let x = self.model.grid.face_center(a, stretch.at(n));
                        part[face - base] += motion(a, &x, stretch.component);
                    }
                });
            });
        }
        let change = |f: &InterfaceFace| {
            let (component, x) = self.place(f);
            motion(f.axis, &x, component)
        };
        let changes = par::map_slice(self.interface_faces, 256, change);
        zip(self.interface_faces, changes).for_each(|(f, by)| velocity.axes[f.axis][f.face] += by);
    }
}

/// Motion that a group lacks, and the components that must get it.
struct LackingMotion<const D: usize> {
    /// Moments of the components, with their target volumes as mass.
    parts: Vec<Moments<D>>,
    /// Positions of their centres relative to that of the group, m.
    arms: Vec<Vector<D>>,
    /// Target volume of the group, m³ (2D: m²).
    volume: f64,
    /// Velocity that the group lacks, m/s.
    velocity: Vector<D>,
    /// Angular momentum that it lacks, over density.
    angular_momentum_per_density: [f64; 3],
}

impl<const D: usize> LackingMotion<D> {
    /// Σ m x_b x_c over the group's faces of axis `a`, about the group's centre.
    fn second_moment(&self, a: usize, b: usize, c: usize) -> f64 {
        zip(&self.parts, &self.arms)
            .map(|(m, r)| m.central_second_moment(a, b, c) + m.mass[a] * r[b] * r[c])
            .sum()
    }

    /// The correction of each component's velocity if the group turns at this angular velocity.
    fn corrections(&self, rotation_rate: [f64; 3]) -> impl Iterator<Item = VelocityCorrection<D>> {
        zip(&self.parts, &self.arms).map(move |(part, arm)| VelocityCorrection {
            velocity: self.velocity + rotational_velocity(&rotation_rate, arm),
            rotation_rate,
            mean_positions: part.mean_positions(),
        })
    }
}

/// A rigid motion: velocity of the centre, angular velocity, and the mean position of each axis' faces, about which a rotation does not
/// change the mean velocity.
#[derive(Clone)]
struct VelocityCorrection<const D: usize> {
    velocity: Vector<D>,
    rotation_rate: [f64; 3],
    mean_positions: [Vector<D>; D],
}

/// Velocity of a rotation at `arm`.
fn rotational_velocity<const D: usize>(rate: &[f64; 3], arm: &Vector<D>) -> Vector<D> {
    let mut velocity = Vector::zeros();
    for &(a, b, place) in rotation_planes::<D>() {
        velocity[b] += rate[place] * arm[a];
        velocity[a] -= rate[place] * arm[b];
    }
    velocity
}

/// Combines several components into one.
pub fn combined<const D: usize>(bodies: impl Iterator<Item = RigidMotion<D>>) -> RigidMotion<D> {
    let bodies: Vec<_> = bodies.collect();
    let volume: f64 = bodies.iter().map(|b| b.volume).sum();
    let mean = |f: &dyn Fn(&RigidMotion<D>) -> Vector<D>| {
        let sum = bodies.iter().fold(Vector::zeros(), |s: Vector<D>, b| s + f(b) * b.volume);
        if volume > 0.0 { sum / volume } else { sum }
    };
    let (center, velocity) = (mean(&|b| b.center), mean(&|b| b.velocity));
    let mut angular_momentum = [0.0; 3];
    for b in bodies {
        let relative = RigidMotion { velocity: b.velocity - velocity, ..b };
        zip(&mut angular_momentum, relative.angular_momentum_about(&center)).for_each(|(sum, s)| *sum += s);
    }
    RigidMotion { volume, center, velocity, angular_momentum_per_density: angular_momentum }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus_numerics::grid::Grid;

    #[test]
    fn closed_faces_part_components() {
        let grid = Grid::<2>::new([6, 3], 1.0);
        let model = Model::of_test(grid, Vec::new());
        let (phi, mut velocity) = (CellField::new(grid, -1.0), FaceField::zeros(grid));
        let (mut open_fractions, lattice) = (FaceField::zeros(grid), grid.face_lattice(0));
        for i in 0..7 {
            let face = lattice.index([i, 1]);
            open_fractions.axes[0][face] = f64::from(i != 3);
            velocity.axes[0][face] = f64::from(i > 3);
        }
        let faces = [vec![Segment { row: 1, start: 1, end: 6 }], Vec::new()];
        let label = |cell: usize| u32::from(cell % 6 >= 3);
        let open_fractions = Some(&open_fractions);
        let walk = ComponentFaces {
            model: &model,
            phi: &phi,
            faces: &faces,
            open_fractions,
            interface_faces: &[],
            label: &label,
            component_count: 2,
        };
        let moments = walk.moments(&velocity);
        assert_eq!(moments.iter().map(|m| m.mass[0]).collect::<Vec<_>>(), [2.0, 2.0]);
        assert_eq!(moments.iter().map(|m| m.momentum[0]).collect::<Vec<_>>(), [0.0, 2.0]);
    }
}
