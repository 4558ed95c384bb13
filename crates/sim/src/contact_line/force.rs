//! What the liquid's surface pulls at the solids with.
//!
//! Along the contact line a solid feels the free surface's tension across its own surface, `γ sin θ n` with the angle `θ`
//! that the surface has, and along it `γ mode_cosine θ_Y t` with Young's: what is unbalanced there moves the liquid, and no even
//! wall is pulled along itself, as the energy does not change when the liquid moves along it. At rest both make the pull
//! of the free surface, `γ t_la`.
//!
//! The lattice of the surface tells that to a percent or two; a body of liquid that touches nothing but solids tells it
//! exactly: what its surface's pressure pushes the liquid with, the solids must give back. So across the solids the
//! difference is spread over its lines, and drop and solids together neither gain nor lose momentum (design, experiments
//! part 2, EFT), nor angular momentum, except where all lines on a solid that deforms lie within [`MIN_RESOLVED_RADIUS_CELLS`] cells of one place:
//! these carry no moment, and the repairs say how much was left out; along them the lattice is right, and the liquid gets what its surface's pressure lacks. Without that a drop
//! that spreads on a tilted wall starts to glide along it.
//!
//! A solid that deforms feels the tension of its own surface as well ([`super::solid_tension`]): along it the two are in balance. What each
//! piece of a line pulls it with, the balance of the surface around tells ([`super::local_balance`]); the sum over a line is as above.

use super::local_balance::LineNeighbourhood;
use super::solid_tension::WettedTensions;
use crate::coupling::impulses::{CouplingImpulses, Impulse, moment};
use crate::free_surface::dual_cell::DualCell;
use crate::free_surface::interface_faces::InterfaceFace;
use crate::model::Model;
use crate::model::resolution::MIN_RESOLVED_RADIUS_CELLS;
use crate::solid::SolidState;
use crate::solid::surface::SurfacePoint;
use meniscus_numerics::grid::CutCell;
use meniscus_numerics::{Matrix, Vector, rotation_planes};
use std::collections::BTreeMap;

/// What the lattice tells of the lines: pulls, and lengths in cells (times the sine of the angle) with their first moments
/// (m).
struct LinePulls<const D: usize> {
    impulses: CouplingImpulses<D>,
    lengths: BTreeMap<(u32, u32), (f64, Vector<D>)>,
    /// Where lines take hold of solids that deform.
    loads: BTreeMap<(u32, u32), Vec<LineLoad<D>>>,
    /// The pieces of all lines, and of the surface's rims at sides of the domain, each of which has its part of the surface
    /// around it: places, m, and pulls over the time and the tension of a cell.
    pieces: Vec<(Vector<D>, Vector<D>)>,
}

/// A place where a line takes hold of a solid that deforms.
struct LineLoad<const D: usize> {
    point: SurfacePoint<D>,
    /// Number of the line's piece, and how much of it takes hold here.
    piece: (usize, f64),
    /// Length there, in cells.
    length_cells: f64,
    /// What it pulls with, N s (2D: per metre).
    impulse: Vector<D>,
}

/// Least share of the lines' pull across solids that a direction must have for lines to pull in it.
const MIN_PULL_FRACTION: f64 = 0.1;

/// The part of a vector in directions in which lines pull across their solids: all but those along an even wall.
fn pull_projector<const D: usize>(across: &Matrix<D>) -> Matrix<D> {
    let square =
        Matrix::<3>::from_fn(|i, j| if i < D && j < D { across[(i, j)] / across.trace() } else { 0.0 });
    let eigen = square.symmetric_eigen();
    let weight = eigen.eigenvalues.map(|share| (share / MIN_PULL_FRACTION).min(1.0));
    let part = eigen.eigenvectors * Matrix::<3>::from_diagonal(&weight) * eigen.eigenvectors.transpose();
    Matrix::from_fn(|i, j| part[(i, j)])
}

/// The sum over each component's lines of the projector across the solids around them: the mean over the solids' surface in
/// the cells that a piece of a line lies between, of which alone its energy knows. Beside an edge that has the normals of both
/// sides: nothing there is along an even wall.
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

/// For each component the part of a vector in directions in which its lines pull at no solid; nothing without lines.
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
    /// For each component what is missing along its solids, N s (2D: N s/m): the liquid gets it.
    pub on_liquid: Vec<Vector<D>>,
    /// Size of the moments that lines too close together do not carry, kg m²/s (2D: kg m/s).
    pub moment_lost: f64,
}

/// The surface as it pulls at solids.
pub struct ContactLineForces<'a, const D: usize> {
    /// The model.
    pub model: &'a Model<D>,
    /// The solids.
    pub solids: &'a [SolidState<D>],
    /// The distance to the surface, cell by cell.
    pub phi: &'a [f64],
    /// The surface in cubes.
    pub dual_cells: &'a [DualCell],
    /// The faces that it cuts.
    pub interface_faces: &'a [InterfaceFace],
    /// The solids' surfaces in cells.
    pub wet: &'a [CutCell<D>],
    /// Centre of mass of each component, m.
    pub centers: &'a [Vector<D>],
    /// Component of a liquid cell.
    pub label: &'a dyn Fn(usize) -> Option<u32>,
    /// Which components touch no side of the domain.
    pub touches_no_side: &'a [bool],
    /// What is wetted of the solids that deform.
    pub wetted_tensions: &'a WettedTensions<D>,
}

impl<const D: usize> ContactLineForces<'_, D> {
    /// The impulses of the time `impulse_time` (s).
    pub fn impulses(&self, impulse_time: f64) -> LineImpulses<D> {
        let LinePulls { mut impulses, lengths, mut loads, pieces } = self.lattice_pulls(impulse_time);
        if !loads.is_empty() {
            self.add_local_balance(impulse_time, pieces, loads.values_mut().flatten());
        }
        let across = normal_projectors(self.dual_cells, self.wet, self.label, self.touches_no_side.len());
        let mut total = vec![0.0; self.touches_no_side.len()];
        lengths.iter().for_each(|((c, _), (length, _))| total[*c as usize] += length);
        let mut missing = self.capillary_impulses(impulse_time);
        impulses.pairs.iter().for_each(|((c, _), pull)| missing[*c as usize].add(pull, 1.0));
        let mut along = vec![Vector::zeros(); self.touches_no_side.len()];
        let (sides, mut moment_lost) = (self.side_axes(), 0.0);
        for c in (0..along.len()).filter(|&c| total[c] > 0.0) {
            // Sides of the domain pull across themselves only, and with what moment is not known.
            let balanced = Vector::from_fn(|a, _| if sides[c][a] { 0.0 } else { missing[c].linear[a] });
            let linear = pull_projector(&across[c]) * balanced;
            if self.touches_no_side[c] {
                along[c] = linear - missing[c].linear;
                // The liquid gets that as a whole.
                missing[c].angular += moment(&self.centers[c], &along[c]);
            }
            missing[c].linear = linear;
        }
        for (pair, (length, middle)) in lengths.iter().filter(|(pair, _)| total[pair.0 as usize] > 0.0) {
            let c = pair.0 as usize;
            let mut rest = Impulse::zero();
            let at_middle = Impulse::at(&(middle / *length), missing[c].linear);
            rest.add(if self.touches_no_side[c] { &missing[c] } else { &at_middle }, -length / total[c]);
            impulses.add(*pair, &rest, 1.0);
            if let Some(loads) = loads.get(pair)
                && let Some(all) = impulses.pairs.remove(pair)
            {
                let skin = self.wetted_tensions.get(pair).map_or(&[][..], |skin| skin);
                let shortest_lever = MIN_RESOLVED_RADIUS_CELLS * self.model.grid.dx;
                moment_lost +=
                    load_deformable(loads, shortest_lever, (skin, impulse_time), *pair, &all, &mut impulses);
            }
        }
        // Without a line nothing holds the tension of what is wetted, nor needs to: that of every facet is in balance.
        let lineless = self.wetted_tensions.iter().filter(|(pair, _)| !lengths.contains_key(pair));
        for (pair, skin) in lineless {
            skin.iter()
                .for_each(|(grip, force)| impulses.add_at_surface_point(*pair, grip, force * impulse_time));
        }
        LineImpulses { on_solids: impulses, on_liquid: along, moment_lost }
    }

    /// Along which axes sides of the domain pull at the surface of each component: along their normals.
    fn side_axes(&self) -> Vec<[bool; D]> {
        let mut sides = vec![[false; D]; self.touches_no_side.len()];
        for cube in self.dual_cells.iter().filter(|c| c.area > 0.0) {
            // Beyond a side a corner stands for its mirror image.
            for a in (0..D).filter(|a| cube.corners[0] == cube.corners[1 << a]) {
                cube.distribute(self.label, |c, _| sides[c as usize][a] = true);
            }
        }
        sides
    }

    /// What the lattice tells.
    fn lattice_pulls(&self, impulse_time: f64) -> LinePulls<D> {
        let grid = &self.model.grid;
        let strength = self.model.surface_tension * impulse_time * grid.dx.powi(D as i32 - 2);
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
            let now = &self.solids[cube.solid as usize];
            let grips = now.surface_patch(&foot, self.model.numerics.line_radius);
            let number = pieces.len();
            pieces.push((foot, Vector::from_fn(|a, _| pull[a])));
            cube.distribute(self.label, |c, part| {
                impulses.add((c, cube.solid), &impulse, part);
                for &(point, share) in &grips {
                    let (part, loads) = (part * share, loads.entry((c, cube.solid)).or_insert_with(Vec::new));
                    let pull = Vector::from_fn(|a, _| strength * part * pull[a]);
                    loads.push(LineLoad {
                        point,
                        piece: (number, part),
                        length_cells: part * size,
                        impulse: pull,
                    });
                }
                let (length, moment) = lengths.entry((c, cube.solid)).or_insert((0.0, Vector::zeros()));
                *length += part * size;
                *moment += place * (part * size);
            });
        }
        LinePulls { impulses, lengths, loads, pieces }
    }

    /// Gives each piece of the lines on solids that deform what the balance of the surface around it asks for.
    fn add_local_balance<'f>(
        &self,
        impulse_time: f64,
        mut pieces: Vec<(Vector<D>, Vector<D>)>,
        feet: impl Iterator<Item = &'f mut LineLoad<D>>,
    ) {
        let grid = &self.model.grid;
        let strength = self.model.surface_tension * impulse_time * grid.dx.powi(D as i32 - 2);
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

    /// What the surface's pressure pushes each component with.
    fn capillary_impulses(&self, impulse_time: f64) -> Vec<Impulse<D>> {
        let grid = &self.model.grid;
        let strength = self.model.surface_tension * impulse_time * grid.face_area() / grid.dx;
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

/// Gives a solid that deforms what its lines pull with, each where it is, what the tension of its wetted surface (`skin`) does
/// in the time `impulse_time` (s), which along the solid is in balance with the lines, and what `all` is besides to all lines. Returns
/// the size of the moment that [`distribute_rigidly`] leaves out, kg m²/s (2D: kg m/s).
fn load_deformable<const D: usize>(
    feet: &[LineLoad<D>],
    shortest_lever: f64,
    (skin, impulse_time): (&[(SurfacePoint<D>, Vector<D>)], f64),
    pair: (u32, u32),
    all: &Impulse<D>,
    exchange: &mut CouplingImpulses<D>,
) -> f64 {
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

/// An impulse spread over places on a solid that deforms, by their lengths, as the accelerations of a rigid body are. About an axis
/// from which the root mean square distance of the places is less than `shortest_lever` (m) they get no moment: the forces that
/// make it grow without bound as the places come together.
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

    /// A force and a moment are spread over three places on a line, `width` cells apart from each other; returns the impulse that
    /// is asked for and the sum of what the places get.
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
            // The whole impulse and moment over the shortest lever bound what a place gets.
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
        // The root mean square lever of three places is √(2/3) of their distance: 2.45 cells carry a moment, 2.44 do not.
        for (width, carries) in [(0.0, false), (1e-15, false), (2.44, false), (2.46, true), (4.0, true)] {
            let [asked, given] = spread_over(width);
            assert!((asked.linear - given.linear).norm() < 1e-12);
            let about = |impulse: &Impulse<2>| impulse.moment_about(&Vector::<2>::new(3.0, 2.0))[2];
            let wanted = if carries { about(&asked) } else { 0.0 };
            assert!((about(&given) - wanted).abs() < 1e-12, "{width}: {} {wanted}", about(&given));
        }
    }
}
