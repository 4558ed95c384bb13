//! Forces of contact lines on solids.
//!
//! Normal to its surface a solid feels the tension of the free surface, `γ sin θ n` with the actual angle `θ`;
//! along its surface it feels `γ cos θ_c t` with the angle of the energy: Young's, or with hysteresis that of
//! [`super::hysteresis`]. The unbalanced tangential part accelerates the liquid. The tangential force on a
//! plane wall with one angle adds up to zero, as the energy does not change when the liquid moves along it. In
//! equilibrium both parts together are the tension `γ t_la` of the free surface, with its tangent `t_la` away from the line.
//!
//! The dual cells give these forces to a percent or two. For a component of liquid that touches only solids the
//! sum is known exactly: it balances the capillary impulse on the liquid. The difference normal to the solids
//! is therefore distributed over the lines of the component, and liquid and solids together conserve momentum
//! and angular momentum. The exception are lines on a deformable solid that all lie within
//! [`MIN_RESOLVED_RADIUS_CELLS`] cells of one point: they carry no moment, and the repairs record what is left
//! out. Along the solids the dual cells are right, and the liquid gets the difference; otherwise a drop that
//! spreads on a tilted wall starts to glide along it. The liquid's share is dropped if the component is smaller
//! than a ball of that radius (`coupling/solve.rs`).
//!
//! A deformable solid also feels the tension of its own surface ([`super::solid_tension`]), which balances the line force
//! along the solid. The force of each piece of a line follows from the balance of the free surface around it
//! ([`super::local_balance`]); the sum over the line is as above.

use super::local_balance::LineNeighbourhood;
use super::solid_tension::WettedTensions;
use crate::coupling::impulses::{ComponentSolid, CouplingImpulses, Impulse, moment};
use crate::free_surface::dual_cell::DualCell;
use crate::free_surface::interface_faces::InterfaceFace;
use crate::model::resolution::MIN_RESOLVED_RADIUS_CELLS;
use crate::solid::Solids;
use crate::solid::surface::SurfacePoint;
use meniscus_numerics::grid::CutCell;
use meniscus_numerics::{Matrix, Vector, rotation_planes};
use std::collections::BTreeMap;

/// Contact-line forces of the dual cells: impulses, and line lengths in cells (times the sine of the angle) with their
/// first moments (cells times m).
struct LinePulls<const D: usize> {
    impulses: CouplingImpulses<D>,
    lengths: BTreeMap<ComponentSolid, (f64, Vector<D>)>,
    /// Load points of the lines on deformable solids.
    loads: BTreeMap<ComponentSolid, Vec<LineLoad<D>>>,
    /// Pieces of all lines: positions, m, and impulses over `γ h Δ^(D−2)`.
    pieces: Vec<(Vector<D>, Vector<D>)>,
}

/// A load point of a contact line on a deformable solid.
struct LineLoad<const D: usize> {
    point: SurfacePoint<D>,
    /// Index of the line's piece, and the fraction of it that acts here.
    piece: (usize, f64),
    /// Length there, in cells, times the sine of the angle.
    length_cells: f64,
    /// Impulse, N s (2D: per metre).
    impulse: Vector<D>,
}

/// Share of the lines' forces normal to solids from which on a direction counts fully as pulled.
const MIN_PULL_FRACTION: f64 = 0.1;

/// Projector onto the directions in which lines pull normal to their solids; it excludes those along a plane wall.
fn pull_projector<const D: usize>(across: &Matrix<D>) -> Matrix<D> {
    let square =
        Matrix::<3>::from_fn(|i, j| if i < D && j < D { across[(i, j)] / across.trace() } else { 0.0 });
    let eigen = square.symmetric_eigen();
    let weight = eigen.eigenvalues.map(|share| (share / MIN_PULL_FRACTION).min(1.0));
    let part = eigen.eigenvectors * Matrix::<3>::from_diagonal(&weight) * eigen.eigenvectors.transpose();
    Matrix::from_fn(|i, j| part[(i, j)])
}

/// For each component the sum over its lines of projectors onto the normals of the solids. That of a piece is the mean over the
/// solids' surface in the cells at the corners of its dual cell, the only ones on which its energy depends; beside an edge it
/// contains the normals of both faces.
fn normal_projectors<const D: usize>(
    dual_cells: &[DualCell],
    wet: &[CutCell<D>],
    label: &dyn Fn(usize) -> Option<u32>,
    count: usize,
) -> Vec<Matrix<D>> {
    let projector = |n: &Vector<D>| n * n.transpose() / n.norm().max(f64::MIN_POSITIVE);
    let mut across = vec![Matrix::zeros(); count];
    for cube in dual_cells.iter().filter(|c| c.normal_pull != [0.0; 3]) {
        let lift: Vector<D> = Vector::from_fn(|a, _| cube.normal_pull[a]);
        let surfaces = cube.corners[..1 << D].iter().filter_map(|c| surface_in(wet, *c));
        let around: Matrix<D> = surfaces.map(|w| projector(&w.area_vector)).sum();
        let around = if around.trace() > 0.0 { around } else { projector(&lift) };
        let part = around * (lift.norm() / around.trace());
        cube.distribute(label, |c, share| across[c as usize] += part * share);
    }
    across
}

/// The solid's surface in a cell, if there is any.
fn surface_in<const D: usize>(wet: &[CutCell<D>], cell: u32) -> Option<&CutCell<D>> {
    wet.binary_search_by_key(&cell, |w| w.cell).ok().map(|at| &wet[at])
}

/// For each component the projector onto the directions in which its lines pull at no solid; zero without lines.
pub fn unconstrained_projectors<const D: usize>(
    dual_cells: &[DualCell],
    wet: &[CutCell<D>],
    label: &dyn Fn(usize) -> Option<u32>,
    count: usize,
) -> Vec<Matrix<D>> {
    let rest = |across: &Matrix<D>| {
        if across.trace() > 0.0 { Matrix::identity() - pull_projector(across) } else { Matrix::zeros() }
    };
    normal_projectors(dual_cells, wet, label, count).iter().map(rest).collect()
}

/// Impulses of the contact lines.
pub struct LineImpulses<const D: usize> {
    /// On the solids.
    pub on_solids: CouplingImpulses<D>,
    /// For each component the missing impulse along its solids, N s (2D: N s/m), which the liquid gets.
    pub on_liquid: Vec<Vector<D>>,
    /// Size of the moments that lines too close together do not carry, kg m²/s (2D: kg m/s).
    pub moment_lost: f64,
}

/// The data from which the contact-line forces are computed.
pub struct ContactLineForces<'a, const D: usize> {
    /// The solids.
    pub solids: Solids<'a, D>,
    /// Signed distance to the interface in each cell, m.
    pub phi: &'a [f64],
    /// The dual cells with interface or wetted solid.
    pub dual_cells: &'a [DualCell],
    /// The interface faces.
    pub interface_faces: &'a [InterfaceFace],
    /// The solids' surfaces in cells.
    pub wet: &'a [CutCell<D>],
    /// Centre of mass of each component, m.
    pub centers: &'a [Vector<D>],
    /// Component of a liquid cell.
    pub label: &'a dyn Fn(usize) -> Option<u32>,
    /// Whether each component touches no side of the domain.
    pub touches_no_side: &'a [bool],
    /// Tension forces of the wetted surfaces of deformable solids.
    pub wetted_tensions: &'a WettedTensions<D>,
}

impl<const D: usize> ContactLineForces<'_, D> {
    /// Computes the impulses during `impulse_time` (s).
    pub fn impulses(&self, impulse_time: f64) -> LineImpulses<D> {
        let LinePulls { mut impulses, lengths, mut loads, pieces } = self.lattice_pulls(impulse_time);
        if !loads.is_empty() {
            self.add_local_balance(impulse_time, pieces, loads.values_mut().flatten());
        }
        let across = normal_projectors(self.dual_cells, self.wet, self.label, self.touches_no_side.len());
        let mut total = vec![0.0; self.touches_no_side.len()];
        lengths.iter().for_each(|(pair, (length, _))| total[pair.component as usize] += length);
        let mut missing = self.capillary_impulses(impulse_time);
        impulses.pairs.iter().for_each(|(pair, pull)| missing[pair.component as usize].add(pull, 1.0));
        let mut along = vec![Vector::zeros(); self.touches_no_side.len()];
        let (sides, mut moment_lost) = (self.side_axes(), 0.0);
        for c in (0..along.len()).filter(|&c| total[c] > 0.0) {
            // Sides of the domain pull only along their normals, with an unknown moment.
            let balanced = Vector::from_fn(|a, _| if sides[c][a] { 0.0 } else { missing[c].linear[a] });
            let linear = pull_projector(&across[c]) * balanced;
            if self.touches_no_side[c] {
                along[c] = linear - missing[c].linear;
                // The liquid gets this impulse at its centre of mass.
                missing[c].angular += moment(&self.centers[c], &along[c]);
            }
            missing[c].linear = linear;
        }
        for (pair, (length, middle)) in
            lengths.iter().filter(|(pair, _)| total[pair.component as usize] > 0.0)
        {
            let c = pair.component as usize;
            let mut rest = Impulse::zero();
            let at_middle = Impulse::at(&(middle / *length), missing[c].linear);
            rest.add(if self.touches_no_side[c] { &missing[c] } else { &at_middle }, -length / total[c]);
            impulses.add(*pair, &rest, 1.0);
            if let Some(loads) = loads.get(pair)
                && let Some(all) = impulses.pairs.remove(pair)
            {
                moment_lost += self.load_deformable(*pair, loads, &all, impulse_time, &mut impulses);
            }
        }
        // Without a contact line the tension of the wetted surface is in balance by itself.
        let lineless = self.wetted_tensions.iter().filter(|(pair, _)| !lengths.contains_key(pair));
        for (pair, skin) in lineless {
            skin.iter()
                .for_each(|(grip, force)| impulses.add_at_surface_point(*pair, grip, force * impulse_time));
        }
        LineImpulses { on_solids: impulses, on_liquid: along, moment_lost }
    }

    /// Applies the impulse `all` of a component to a deformable solid: the lines' impulses at their load points (`feet`), that of the
    /// tension of the wetted surface, and the rest distributed over all load points. Returns the size of the moment that
    /// [`distribute_rigidly`] leaves out, kg m²/s (2D: kg m/s).
    fn load_deformable(
        &self,
        pair: ComponentSolid,
        feet: &[LineLoad<D>],
        all: &Impulse<D>,
        impulse_time: f64,
        exchange: &mut CouplingImpulses<D>,
    ) -> f64 {
        let skin = self.wetted_tensions.get(&pair).map_or(&[][..], |skin| skin);
        let shortest_lever = MIN_RESOLVED_RADIUS_CELLS * self.solids.model.grid.dx;
        let mut rest = *all;
        feet.iter().for_each(|f| rest.add(&Impulse::at(&f.point.point, f.impulse), -1.0));
        skin.iter().for_each(|(grip, force)| rest.add(&Impulse::at(&grip.point, *force), -impulse_time));
        skin.iter().for_each(|(grip, force)| exchange.add_at_surface_point(pair, grip, force * impulse_time));
        let asked = rest;
        for (foot, more) in feet.iter().zip(distribute_rigidly(feet, shortest_lever, &asked)) {
            exchange.add_at_surface_point(pair, &foot.point, foot.impulse + more);
            rest.add(&Impulse::at(&foot.point.point, more), -1.0);
        }
        rest.angular.norm()
    }

    /// The axes along which sides of the domain pull at the surface of each component: the normals of the sides.
    fn side_axes(&self) -> Vec<[bool; D]> {
        let mut sides = vec![[false; D]; self.touches_no_side.len()];
        for cube in self.dual_cells.iter().filter(|c| c.area > 0.0) {
            // Beyond a side a corner is a mirror image.
            for a in (0..D).filter(|a| cube.corners[0] == cube.corners[1 << a]) {
                cube.distribute(self.label, |c, _| sides[c as usize][a] = true);
            }
        }
        sides
    }

    /// Contact-line forces of the dual cells.
    fn lattice_pulls(&self, impulse_time: f64) -> LinePulls<D> {
        let grid = &self.solids.model.grid;
        let strength = self.solids.model.surface_tension * impulse_time * grid.dx.powi(D as i32 - 2);
        let (mut impulses, mut lengths, mut loads) =
            (CouplingImpulses::new(), BTreeMap::new(), BTreeMap::new());
        let mut pieces = Vec::new();
        for cube in self.dual_cells.iter().filter(|c| c.normal_pull != [0.0; 3]) {
            let pull = cube.pull();
            let impulse: Impulse<D> = Impulse {
                linear: Vector::from_fn(|a, _| strength * pull[a]),
                angular: Vector::<3>::from(cube.pull_moment()) * (strength * grid.dx),
            };
            let size = Vector::<3>::from(cube.normal_pull).norm();
            let place = grid.center(grid.lattice().coordinates(cube.corners[0] as usize))
                + Vector::repeat(0.5 * grid.dx);
            let foot = cube.line_center().map_or(place, |foot| Vector::from_fn(|a, _| foot[a] * grid.dx));
            let surface = self.solids.get(cube.solid as usize).surface;
            let grips = surface.patch(&foot, self.solids.model.numerics.line_radius);
            let number = pieces.len();
            pieces.push((foot, Vector::from_fn(|a, _| pull[a])));
            cube.distribute(self.label, |component, part| {
                let pair = ComponentSolid { component, solid: cube.solid };
                impulses.add(pair, &impulse, part);
                for &(point, share) in &grips {
                    let (part, loads) = (part * share, loads.entry(pair).or_insert_with(Vec::new));
                    let pull = Vector::from_fn(|a, _| strength * part * pull[a]);
                    loads.push(LineLoad {
                        point,
                        piece: (number, part),
                        length_cells: part * size,
                        impulse: pull,
                    });
                }
                let (length, moment) = lengths.entry(pair).or_insert((0.0, Vector::zeros()));
                *length += part * size;
                *moment += place * (part * size);
            });
        }
        LinePulls { impulses, lengths, loads, pieces }
    }

    /// Adds the imbalance of the free surface around each piece of the lines to the load points on deformable solids. The rims of
    /// the surface at sides of the domain are pieces, too: each has its part of the surface around it.
    fn add_local_balance<'f>(
        &self,
        impulse_time: f64,
        mut pieces: Vec<(Vector<D>, Vector<D>)>,
        feet: impl Iterator<Item = &'f mut LineLoad<D>>,
    ) {
        let grid = &self.solids.model.grid;
        let strength = self.solids.model.surface_tension * impulse_time * grid.dx.powi(D as i32 - 2);
        let rim = |c: &&DualCell| c.area > 0.0 && (0..D).any(|a| c.corners[0] == c.corners[1 << a]);
        let corner = |c: &DualCell| grid.center(grid.lattice().coordinates(c.corners[0] as usize));
        pieces.extend(self.dual_cells.iter().filter(rim).map(|c| (corner(c), Vector::zeros())));
        let places: Vec<Vector<D>> = pieces.iter().map(|p| p.0).collect();
        let around = LineNeighbourhood::new(grid, self.phi, &places);
        let mut imbalances: Vec<Vector<D>> = pieces.iter().map(|p| -p.1).collect();
        around.add_tension(self.phi, self.dual_cells, &mut imbalances);
        around.subtract_capillary_force(grid, self.interface_faces, &mut imbalances);
        feet.for_each(|foot| foot.impulse += imbalances[foot.piece.0] * (strength * foot.piece.1));
    }

    /// Capillary impulse of the free surface on each component.
    fn capillary_impulses(&self, impulse_time: f64) -> Vec<Impulse<D>> {
        let grid = &self.solids.model.grid;
        let strength = self.solids.model.surface_tension * impulse_time * grid.face_area() / grid.dx;
        let mut pushes = vec![Impulse::zero(); self.touches_no_side.len()];
        for f in self.interface_faces {
            let Some(c) = (self.label)(f.cell) else { continue };
            let mut linear = Vector::zeros();
            linear[f.axis] = -f.sign * f.open_fraction * f.kappa * strength;
            let mut x = grid.center(grid.lattice().coordinates(f.cell));
            x[f.axis] += f.sign * f.theta * grid.dx;
            pushes[c as usize].add(&Impulse::at(&x, linear), 1.0);
        }
        pushes
    }
}

/// Distributes an impulse over load points on a deformable solid, weighted by length, as the accelerations of a rigid body
/// are. There is no moment about an axis from which the root mean square distance of the points is less than
/// `shortest_lever` (m): the forces for it grow without bound as the points approach each other.
fn distribute_rigidly<const D: usize>(
    feet: &[LineLoad<D>],
    shortest_lever: f64,
    impulse: &Impulse<D>,
) -> impl Iterator<Item = Vector<D>> {
    let length: f64 = feet.iter().map(|f| f.length_cells).sum();
    let middle: Vector<D> = feet.iter().map(|f| f.point.point * (f.length_cells / length)).sum();
    let mut second = Matrix::<3>::zeros();
    for foot in feet {
        let arm = foot.point.point - middle;
        let r = Vector::<3>::from_fn(|a, _| if a < D { arm[a] } else { 0.0 });
        second +=
            (Matrix::<3>::identity() * r.norm_squared() - r * r.transpose()) * (foot.length_cells / length);
    }
    let inverse = second.pseudo_inverse(shortest_lever * shortest_lever).unwrap_or_else(|_| Matrix::zeros());
    let turning = inverse * impulse.moment_about(&middle);
    let linear = impulse.linear;
    feet.iter().map(move |foot| {
        let (arm, mut push) = (foot.point.point - middle, linear);
        for &(a, b, place) in rotation_planes::<D>() {
            push[b] += turning[place] * arm[a];
            push[a] -= turning[place] * arm[b];
        }
        push * (foot.length_cells / length)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Distributes a force and a moment over three points on a line, `width` cells apart. Returns the requested impulse and
    /// the sum of the impulses at the points.
    fn spread_over(width: f64) -> [Impulse<2>; 2] {
        let foot = |x: f64| LineLoad {
            point: SurfacePoint {
                vertices: [0; 2],
                weights: [0.5; 2],
                point: Vector::<2>::new(3.0 + x * width, 2.0),
            },
            piece: (0, 1.0),
            length_cells: 0.7,
            impulse: Vector::zeros(),
        };
        let feet = [-1.0, 0.0, 1.0].map(foot);
        let asked = Impulse { linear: Vector::<2>::new(0.2, -0.4), angular: Vector::<3>::new(0.0, 0.0, 1.3) };
        let mut given = Impulse::zero();
        for (foot, push) in feet.iter().zip(distribute_rigidly(&feet, MIN_RESOLVED_RADIUS_CELLS, &asked)) {
            // The whole impulse, and the moment over the shortest lever, bound the impulse at a point.
            assert!(
                push.norm() < asked.linear.norm() + asked.angular.norm() / MIN_RESOLVED_RADIUS_CELLS,
                "{push:?}"
            );
            given.add(&Impulse::at(&foot.point.point, push), 1.0);
        }
        [asked, given]
    }

    #[test]
    fn what_lines_lack_is_spread_over_them() {
        // The root mean square lever of three points is √(2/3) of their distance: 2.45 cells carry a moment, 2.44 do not.
        for (width, carries) in [(0.0, false), (1e-15, false), (2.44, false), (2.46, true), (4.0, true)] {
            let [asked, given] = spread_over(width);
            assert!((asked.linear - given.linear).norm() < 1e-12);
            let about = |impulse: &Impulse<2>| impulse.moment_about(&Vector::<2>::new(3.0, 2.0))[2];
            let wanted = if carries { about(&asked) } else { 0.0 };
            assert!((about(&given) - wanted).abs() < 1e-12, "{width}: {} {wanted}", about(&given));
        }
    }
}
