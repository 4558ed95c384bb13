//! What the liquid's surface pulls at the solids with.
//!
//! Along the contact line a solid feels the free surface's tension across its own surface, `γ sin θ n` with the angle `θ`
//! that the surface has, and along it `γ cos θ_Y t` with Young's: what is unbalanced there moves the liquid, and no even
//! wall is pulled along itself, as the energy does not change when the liquid moves along it. At rest both make the pull
//! of the free surface, `γ t_la`.
//!
//! The lattice of the surface tells that to a percent or two; a body of liquid that touches nothing but solids tells it
//! exactly: what its surface's pressure pushes the liquid with, the solids must give back. So across the solids the
//! difference is spread over its lines, and drop and solids together neither gain nor lose momentum (design, experiments
//! part 2, EFT), nor angular momentum, except where all lines on a solid that deforms lie within [`RESOLVED`] cells of one place:
//! these carry no moment, and the repairs say how much was left out; along them the lattice is right, and the liquid gets what its surface's pressure lacks. Without that a drop
//! that spreads on a tilted wall starts to glide along it.
//!
//! A solid that deforms feels the tension of its own surface as well ([`super::solid_tension`]): along it the two are in balance. What each
//! piece of a line pulls it with, the balance of the surface around tells ([`super::local_balance`]); the sum over a line is as above.

use super::local_balance::Surroundings;
use super::solid_tension::Skins;
use crate::coupling::impulses::{Exchange, Impulse, moment};
use crate::free_surface::dual_cell::CutCube;
use crate::free_surface::interface_faces::CutFace;
use crate::model::Model;
use crate::model::resolution::RESOLVED;
use crate::solid::SolidState;
use crate::solid::surface::Grip;
use meniscus_numerics::grid::WetCell;
use meniscus_numerics::{Matrix, Vector, planes};
use std::collections::BTreeMap;

/// What the lattice tells of the lines: pulls, and lengths in cells (times the sine of the angle) with their first moments
/// (m).
struct Pulls<const D: usize> {
    exchange: Exchange<D>,
    lengths: BTreeMap<(u32, u32), (f64, Vector<D>)>,
    /// Where lines take hold of solids that deform.
    feet: BTreeMap<(u32, u32), Vec<Foot<D>>>,
    /// The pieces of all lines, and of the surface's rims at sides of the domain, each of which has its part of the surface
    /// around it: places, m, and pulls over the time and the tension of a cell.
    pieces: Vec<(Vector<D>, Vector<D>)>,
}

/// A place where a line takes hold of a solid that deforms.
struct Foot<const D: usize> {
    grip: Grip<D>,
    /// Number of the line's piece, and how much of it takes hold here.
    piece: (usize, f64),
    /// Length there, in cells.
    length: f64,
    /// What it pulls with, N s (2D: per metre).
    pull: Vector<D>,
}

/// Least share of the lines' pull across solids that a direction must have for lines to pull in it.
const PULLED: f64 = 0.1;

/// The part of a vector in directions in which lines pull across their solids: all but those along an even wall.
fn pulled<const D: usize>(across: &Matrix<D>) -> Matrix<D> {
    let square =
        Matrix::<3>::from_fn(|i, j| if i < D && j < D { across[(i, j)] / across.trace() } else { 0.0 });
    let eigen = square.symmetric_eigen();
    let weight = eigen.eigenvalues.map(|share| (share / PULLED).min(1.0));
    let part = eigen.eigenvectors * Matrix::<3>::from_diagonal(&weight) * eigen.eigenvectors.transpose();
    Matrix::from_fn(|i, j| part[(i, j)])
}

/// The sum over each component's lines of the projector across the solids around them: the mean over the solids' surface in
/// the cells that a piece of a line lies between, of which alone its energy knows. Beside an edge that has the normals of both
/// sides: nothing there is along an even wall.
fn across<const D: usize>(
    cubes: &[CutCube],
    wet: &[WetCell<D>],
    label: &dyn Fn(usize) -> Option<u32>,
    count: usize,
) -> Vec<Matrix<D>> {
    let projector = |n: &Vector<D>| n * n.transpose() / n.norm().max(f64::MIN_POSITIVE);
    let mut across = vec![Matrix::zeros(); count];
    for cube in cubes.iter().filter(|c| c.lift != [0.0; 3]) {
        let lift: Vector<D> = Vector::from_fn(|a, _| cube.lift[a]);
        let surfaces = cube.corners[..1 << D].iter().filter_map(|c| surface_in(wet, *c));
        let around: Matrix<D> = surfaces.map(|w| projector(&w.area)).sum();
        let around = if around.trace() > 0.0 { around } else { projector(&lift) };
        let part = around * (lift.norm() / around.trace());
        cube.share(label, |c, share| across[c as usize] += part * share);
    }
    across
}

/// The solid's surface in a cell, if there is any.
fn surface_in<const D: usize>(wet: &[WetCell<D>], cell: u32) -> Option<&WetCell<D>> {
    wet.binary_search_by_key(&cell, |w| w.cell).ok().map(|at| &wet[at])
}

/// For each component the part of a vector in directions in which its lines pull at no solid; nothing without lines.
pub fn unpulled<const D: usize>(
    cubes: &[CutCube],
    wet: &[WetCell<D>],
    label: &dyn Fn(usize) -> Option<u32>,
    count: usize,
) -> Vec<Matrix<D>> {
    let rest = |across: &Matrix<D>| {
        if across.trace() > 0.0 { Matrix::identity() - pulled(across) } else { Matrix::zeros() }
    };
    across(cubes, wet, label, count).iter().map(rest).collect()
}

/// Impulses of the contact lines.
pub struct LineImpulses<const D: usize> {
    /// On the solids.
    pub on_solids: Exchange<D>,
    /// For each component what is missing along its solids, N s (2D: N s/m): the liquid gets it.
    pub on_liquid: Vec<Vector<D>>,
    /// Size of the moments that lines too close together do not carry, kg m²/s (2D: kg m/s).
    pub moment_lost: f64,
}

/// The surface as it pulls at solids.
pub struct Lines<'a, const D: usize> {
    /// The model.
    pub model: &'a Model<D>,
    /// The solids.
    pub solids: &'a [SolidState<D>],
    /// The distance to the surface, cell by cell.
    pub phi: &'a [f64],
    /// The surface in cubes.
    pub cubes: &'a [CutCube],
    /// The faces that it cuts.
    pub cut: &'a [CutFace],
    /// The solids' surfaces in cells.
    pub wet: &'a [WetCell<D>],
    /// Centre of mass of each component, m.
    pub centers: &'a [Vector<D>],
    /// Component of a liquid cell.
    pub label: &'a dyn Fn(usize) -> Option<u32>,
    /// Which components touch no side of the domain.
    pub inside: &'a [bool],
    /// What is wetted of the solids that deform.
    pub skins: &'a Skins<D>,
}

impl<const D: usize> Lines<'_, D> {
    /// The impulses of the time `kick` (s).
    pub fn impulses(&self, kick: f64) -> LineImpulses<D> {
        let Pulls { mut exchange, lengths, mut feet, pieces } = self.pulls(kick);
        if !feet.is_empty() {
            self.balance(kick, pieces, feet.values_mut().flatten());
        }
        let across = across(self.cubes, self.wet, self.label, self.inside.len());
        let mut total = vec![0.0; self.inside.len()];
        lengths.iter().for_each(|((c, _), (length, _))| total[*c as usize] += length);
        let mut missing = self.pushes(kick);
        exchange.pairs.iter().for_each(|((c, _), pull)| missing[*c as usize].add(pull, 1.0));
        let mut along = vec![Vector::zeros(); self.inside.len()];
        let (sides, mut moment_lost) = (self.sides(), 0.0);
        for c in (0..along.len()).filter(|&c| total[c] > 0.0) {
            // Sides of the domain pull across themselves only, and with what moment is not known.
            let balanced = Vector::from_fn(|a, _| if sides[c][a] { 0.0 } else { missing[c].linear[a] });
            let linear = pulled(&across[c]) * balanced;
            if self.inside[c] {
                along[c] = linear - missing[c].linear;
                // The liquid gets that as a whole.
                missing[c].turning += moment(&self.centers[c], &along[c]);
            }
            missing[c].linear = linear;
        }
        for (pair, (length, middle)) in lengths.iter().filter(|(pair, _)| total[pair.0 as usize] > 0.0) {
            let c = pair.0 as usize;
            let mut rest = Impulse::none();
            let at_middle = Impulse::at(&(middle / *length), missing[c].linear);
            rest.add(if self.inside[c] { &missing[c] } else { &at_middle }, -length / total[c]);
            exchange.add(*pair, &rest, 1.0);
            if let Some(feet) = feet.get(pair)
                && let Some(all) = exchange.pairs.remove(pair)
            {
                let skin = self.skins.get(pair).map_or(&[][..], |skin| skin);
                let shortest_lever = RESOLVED * self.model.grid.dx;
                moment_lost += take_hold(feet, shortest_lever, (skin, kick), *pair, &all, &mut exchange);
            }
        }
        // Without a line nothing holds the tension of what is wetted, nor needs to: that of every facet is in balance.
        let lineless = self.skins.iter().filter(|(pair, _)| !lengths.contains_key(pair));
        for (pair, skin) in lineless {
            skin.iter().for_each(|(grip, force)| exchange.grip(*pair, grip, force * kick));
        }
        LineImpulses { on_solids: exchange, on_liquid: along, moment_lost }
    }

    /// Along which axes sides of the domain pull at the surface of each component: along their normals.
    fn sides(&self) -> Vec<[bool; D]> {
        let mut sides = vec![[false; D]; self.inside.len()];
        for cube in self.cubes.iter().filter(|c| c.area > 0.0) {
            // Beyond a side a corner stands for its mirror image.
            for a in (0..D).filter(|a| cube.corners[0] == cube.corners[1 << a]) {
                cube.share(self.label, |c, _| sides[c as usize][a] = true);
            }
        }
        sides
    }

    /// What the lattice tells.
    fn pulls(&self, kick: f64) -> Pulls<D> {
        let grid = &self.model.grid;
        let strength = self.model.surface_tension * kick * grid.dx.powi(D as i32 - 2);
        let (mut exchange, mut lengths, mut feet) = (Exchange::new(), BTreeMap::new(), BTreeMap::new());
        let mut pieces = Vec::new();
        for cube in self.cubes.iter().filter(|c| c.lift != [0.0; 3]) {
            let pull = cube.pull();
            let impulse: Impulse<D> = Impulse {
                linear: Vector::from_fn(|a, _| strength * pull[a]),
                turning: Vector::<3>::from(cube.turn()) * (strength * grid.dx),
            };
            let size = Vector::<3>::from(cube.lift).norm();
            let place = grid.center(grid.lattice().coordinates(cube.corners[0] as usize))
                + Vector::repeat(0.5 * grid.dx);
            let foot = cube.foot().map_or(place, |foot| Vector::from_fn(|a, _| foot[a] * grid.dx));
            let now = &self.solids[cube.solid as usize];
            let grips = now.patch(&foot, self.model.numerics.line_radius);
            let number = pieces.len();
            pieces.push((foot, Vector::from_fn(|a, _| pull[a])));
            cube.share(self.label, |c, part| {
                exchange.add((c, cube.solid), &impulse, part);
                for &(grip, share) in &grips {
                    let (part, feet) = (part * share, feet.entry((c, cube.solid)).or_insert_with(Vec::new));
                    let pull = Vector::from_fn(|a, _| strength * part * pull[a]);
                    feet.push(Foot { grip, piece: (number, part), length: part * size, pull });
                }
                let (length, moment) = lengths.entry((c, cube.solid)).or_insert((0.0, Vector::zeros()));
                *length += part * size;
                *moment += place * (part * size);
            });
        }
        Pulls { exchange, lengths, feet, pieces }
    }

    /// Gives each piece of the lines on solids that deform what the balance of the surface around it asks for.
    fn balance<'f>(
        &self,
        kick: f64,
        mut pieces: Vec<(Vector<D>, Vector<D>)>,
        feet: impl Iterator<Item = &'f mut Foot<D>>,
    ) {
        let grid = &self.model.grid;
        let strength = self.model.surface_tension * kick * grid.dx.powi(D as i32 - 2);
        let rim = |c: &&CutCube| c.area > 0.0 && (0..D).any(|a| c.corners[0] == c.corners[1 << a]);
        let corner = |c: &CutCube| grid.center(grid.lattice().coordinates(c.corners[0] as usize));
        pieces.extend(self.cubes.iter().filter(rim).map(|c| (corner(c), Vector::zeros())));
        let places: Vec<Vector<D>> = pieces.iter().map(|p| p.0).collect();
        let around = Surroundings::new(grid, self.phi, &places);
        let mut lacks: Vec<Vector<D>> = pieces.iter().map(|p| -p.1).collect();
        around.add_tension(self.phi, self.cubes, &mut lacks);
        around.take_pushes(grid, self.cut, &mut lacks);
        feet.for_each(|foot| foot.pull += lacks[foot.piece.0] * (strength * foot.piece.1));
    }

    /// What the surface's pressure pushes each component with.
    fn pushes(&self, kick: f64) -> Vec<Impulse<D>> {
        let grid = &self.model.grid;
        let strength = self.model.surface_tension * kick * grid.face_area() / grid.dx;
        let mut pushes = vec![Impulse::none(); self.inside.len()];
        for f in self.cut {
            let Some(c) = (self.label)(f.cell) else { continue };
            let mut linear = Vector::zeros();
            linear[f.axis] = -f.sign * f.open * f.kappa * strength;
            let mut x = grid.center(grid.lattice().coordinates(f.cell));
            x[f.axis] += f.sign * f.theta * grid.dx;
            pushes[c as usize].add(&Impulse::at(&x, linear), 1.0);
        }
        pushes
    }
}

/// Gives a solid that deforms what its lines pull with, each where it is, what the tension of its wetted surface (`skin`) does
/// in the time `kick` (s), which along the solid is in balance with the lines, and what `all` is besides to all lines. Returns
/// the size of the moment that [`spread`] leaves out, kg m²/s (2D: kg m/s).
fn take_hold<const D: usize>(
    feet: &[Foot<D>],
    shortest_lever: f64,
    (skin, kick): (&[(Grip<D>, Vector<D>)], f64),
    pair: (u32, u32),
    all: &Impulse<D>,
    exchange: &mut Exchange<D>,
) -> f64 {
    let mut rest = *all;
    feet.iter().for_each(|f| rest.add(&Impulse::at(&f.grip.point, f.pull), -1.0));
    skin.iter().for_each(|(grip, force)| rest.add(&Impulse::at(&grip.point, *force), -kick));
    skin.iter().for_each(|(grip, force)| exchange.grip(pair, grip, force * kick));
    let asked = rest;
    for (foot, more) in feet.iter().zip(spread(feet, shortest_lever, &asked)) {
        exchange.grip(pair, &foot.grip, foot.pull + more);
        rest.add(&Impulse::at(&foot.grip.point, more), -1.0);
    }
    rest.turning.norm()
}

/// An impulse spread over places on a solid that deforms, by their lengths, as the accelerations of a rigid body are. About an axis
/// from which the root mean square distance of the places is less than `shortest_lever` (m) they get no moment: the forces that
/// make it grow without bound as the places come together.
fn spread<const D: usize>(
    feet: &[Foot<D>],
    shortest_lever: f64,
    impulse: &Impulse<D>,
) -> impl Iterator<Item = Vector<D>> {
    let length: f64 = feet.iter().map(|f| f.length).sum();
    let middle: Vector<D> = feet.iter().map(|f| f.grip.point * (f.length / length)).sum();
    let mut second = Matrix::<3>::zeros();
    for foot in feet {
        let arm = foot.grip.point - middle;
        let r = Vector::<3>::from_fn(|a, _| if a < D { arm[a] } else { 0.0 });
        second += (Matrix::<3>::identity() * r.norm_squared() - r * r.transpose()) * (foot.length / length);
    }
    let inverse = second.pseudo_inverse(shortest_lever * shortest_lever).unwrap_or_else(|_| Matrix::zeros());
    let turning = inverse * impulse.about(&middle);
    let linear = impulse.linear;
    feet.iter().map(move |foot| {
        let (arm, mut push) = (foot.grip.point - middle, linear);
        for &(a, b, place) in planes::<D>() {
            push[b] += turning[place] * arm[a];
            push[a] -= turning[place] * arm[b];
        }
        push * (foot.length / length)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A force and a moment are spread over three places on a line, `width` cells apart from each other; returns the impulse that
    /// is asked for and the sum of what the places get.
    fn spread_over(width: f64) -> [Impulse<2>; 2] {
        let foot = |x: f64| Foot {
            grip: Grip { vertices: [0; 2], weights: [0.5; 2], point: Vector::<2>::new(3.0 + x * width, 2.0) },
            piece: (0, 1.0),
            length: 0.7,
            pull: Vector::zeros(),
        };
        let feet = [-1.0, 0.0, 1.0].map(foot);
        let asked = Impulse { linear: Vector::<2>::new(0.2, -0.4), turning: Vector::<3>::new(0.0, 0.0, 1.3) };
        let mut given = Impulse::none();
        for (foot, push) in feet.iter().zip(spread(&feet, RESOLVED, &asked)) {
            // The whole impulse and moment over the shortest lever bound what a place gets.
            assert!(push.norm() < asked.linear.norm() + asked.turning.norm() / RESOLVED, "{push:?}");
            given.add(&Impulse::at(&foot.grip.point, push), 1.0);
        }
        [asked, given]
    }

    #[test]
    fn what_lines_lack_is_spread_over_them() {
        // The root mean square lever of three places is √(2/3) of their distance: 2.45 cells carry a moment, 2.44 do not.
        for (width, carries) in [(0.0, false), (1e-15, false), (2.44, false), (2.46, true), (4.0, true)] {
            let [asked, given] = spread_over(width);
            assert!((asked.linear - given.linear).norm() < 1e-12);
            let about = |impulse: &Impulse<2>| impulse.about(&Vector::<2>::new(3.0, 2.0))[2];
            let wanted = if carries { about(&asked) } else { 0.0 };
            assert!((about(&given) - wanted).abs() < 1e-12, "{width}: {} {wanted}", about(&given));
        }
    }
}
