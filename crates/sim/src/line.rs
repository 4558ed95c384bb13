//! What the liquid's surface pulls at the solids with.
//!
//! Along the contact line the free surface pulls at the solid with its tension. The lattice of the surface tells that pull
//! to a percent; a body of liquid that touches nothing but solids tells it exactly: what its surface's pressure pushes
//! the liquid with, the solids must give back. So the difference is spread over its lines, and drop and solids together
//! neither gain nor lose momentum (design, experiments part 2, EFT). But along a solid the lines pull as at rest, whatever
//! the liquid does: what the surface's pressure lacks there, the liquid gets; a drop on an even wall does not start to glide.

use crate::liquid::cube::CutCube;
use crate::liquid::pressure::CutFace;
use crate::model::Model;
use meniscus_numerics::{Matrix, Vector, planes};
use std::collections::BTreeMap;

/// An impulse and its moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impulse<const D: usize> {
    /// N s (2D: per metre).
    pub linear: Vector<D>,
    /// About the origin, N m s (2D: N s, in the last entry).
    pub turning: Vector<3>,
}

/// Impulses between components of the liquid and solids, by their numbers; they act on the solids.
pub type Exchange<const D: usize> = BTreeMap<(u32, u32), Impulse<D>>;

impl<const D: usize> Impulse<D> {
    /// None.
    pub fn none() -> Self {
        Self { linear: Vector::zeros(), turning: Vector::zeros() }
    }

    /// One that acts at a point.
    pub fn at(x: &Vector<D>, linear: Vector<D>) -> Self {
        Self { linear, turning: moment(x, &linear) }
    }

    /// Adds `scale` times another.
    pub fn add(&mut self, other: &Self, scale: f64) {
        self.linear += other.linear * scale;
        self.turning += other.turning * scale;
    }

    /// The moment about a point.
    pub fn about(&self, center: &Vector<D>) -> Vector<3> {
        self.turning - moment(center, &self.linear)
    }

    /// Those of an exchange, summed by `key` of component and solid.
    pub fn sums(exchange: &Exchange<D>, count: usize, key: impl Fn((u32, u32)) -> u32) -> Vec<Self> {
        let mut sums = vec![Self::none(); count];
        exchange.iter().for_each(|(&pair, impulse)| sums[key(pair) as usize].add(impulse, 1.0));
        sums
    }
}

/// `r × f` (2D: in the last entry).
fn moment<const D: usize>(r: &Vector<D>, f: &Vector<D>) -> Vector<3> {
    let mut sum = Vector::<3>::zeros();
    planes::<D>().iter().for_each(|&(a, b, place)| sum[place] += r[a] * f[b] - r[b] * f[a]);
    sum
}

/// What the lattice tells of the lines: pulls, lengths in cells (times the sine of the angle), and the mean over each
/// component's lines of the projector across the solids.
struct Pulls<const D: usize> {
    exchange: Exchange<D>,
    lengths: BTreeMap<(u32, u32), f64>,
    across: Vec<Matrix<D>>,
}

/// The surface as it pulls at solids.
pub struct Lines<'a, const D: usize> {
    /// The model.
    pub model: &'a Model<D>,
    /// The surface in cubes.
    pub cubes: &'a [CutCube],
    /// The faces that it cuts.
    pub cut: &'a [CutFace],
    /// Component of a liquid cell.
    pub label: &'a dyn Fn(usize) -> Option<u32>,
    /// Which components touch no side of the domain.
    pub inside: &'a [bool],
}

impl<const D: usize> Lines<'_, D> {
    /// The impulses of the time `kick` (s) on the solids, and what is missing along them: an impulse for each component.
    pub fn impulses(&self, kick: f64) -> (Exchange<D>, Vec<Vector<D>>) {
        let Pulls { mut exchange, lengths, across } = self.pulls(kick);
        let mut total = vec![0.0; self.inside.len()];
        lengths.iter().for_each(|((c, _), length)| total[*c as usize] += length);
        let mut missing = self.pushes(kick);
        exchange.iter().for_each(|((c, _), pull)| missing[*c as usize].add(pull, 1.0));
        let mut along = vec![Vector::zeros(); self.inside.len()];
        for c in (0..along.len()).filter(|&c| self.inside[c] && total[c] > 0.0) {
            let share = across[c] / across[c].trace();
            let linear = share * missing[c].linear;
            along[c] = linear - missing[c].linear;
            missing[c].linear = linear;
        }
        for (pair, pull) in &mut exchange {
            let c = pair.0 as usize;
            if self.inside[c] && total[c] > 0.0 {
                pull.add(&missing[c], -lengths[pair] / total[c]);
            }
        }
        (exchange, along)
    }

    /// What the lattice tells.
    fn pulls(&self, kick: f64) -> Pulls<D> {
        let grid = &self.model.grid;
        let strength = self.model.surface_tension * kick * grid.dx.powi(D as i32 - 2);
        let (mut exchange, mut lengths) = (Exchange::new(), BTreeMap::new());
        let mut across = vec![Matrix::zeros(); self.inside.len()];
        for cube in self.cubes.iter().filter(|c| c.lift != [0.0; 3]) {
            let impulse: Impulse<D> = Impulse {
                linear: Vector::from_fn(|a, _| strength * cube.pull[a]),
                turning: Vector::<3>::from(cube.turn) * (strength * grid.dx),
            };
            let lift: Vector<D> = Vector::from_fn(|a, _| cube.lift[a]);
            let size = lift.norm();
            cube.share(self.label, |c, part| {
                exchange.entry((c, cube.solid)).or_insert_with(Impulse::none).add(&impulse, part);
                *lengths.entry((c, cube.solid)).or_insert(0.0) += part * size;
                across[c as usize] += lift * lift.transpose() * (part / size);
            });
        }
        Pulls { exchange, lengths, across }
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
