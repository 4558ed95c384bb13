//! A heavy deformable plate carried by the surface: the paper's Fig. 21.

use crate::measure::{bars, checks_or_failure};
use crate::setup::{at_rest, block, run_to, unit_model};
use crate::soft::not_made;
use crate::{Case, Check};
use meniscus_elastic::{ConstitutiveLaw, Elastic, ElasticSpecification, ElementOrder};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use meniscus_numerics::mesh::VolumeMesh;
use meniscus_sim::{Model, Solid, SolidKind, StepError, Wall};
use std::sync::Arc;

/// The case.
pub const CASE: Case = Case {
    name: "floating-plate",
    title: "A plate five times as dense as the liquid floats (Fig. 21)",
    theory: "The plate of the paper's Fig. 21 (1.3174 x 1.3174 x 0.1387 cm, springs of 5e3 mN/cm, γ = 2 mN/cm, 101.5 degrees, \
        ν = 0.5 cm²/s) in a tank of 4.992 cm with sides at 90 degrees, 2.496 cm deep, cells of 0.052 cm. The surface of Young \
        and Laplace between its upper edge and the sides, solved by differences, carries it where its weight is that of \
        what plate and dimple displace. Released there at rest: the depth of its upper face under the level, a mean over \
        0.25 s, one heave, from 0.35 s on.",
    quick: false,
    run: |_| checks_or_failure(NAME, run()),
};

const NAME: &str = "floating-plate";
/// Lengths in cm: cell, half-width of the tank, level of the liquid without the plate, half-width of the plate, and its thickness.
const DX: f64 = 0.052;
const TANK_HALF_WIDTH: f64 = 48.0 * DX;
const INITIAL_LEVEL: f64 = 48.0 * DX;
const PLATE_HALF_WIDTH: f64 = 19.0 * DX / 1.5;
const THICKNESS: f64 = 4.0 * DX / 1.5;
/// Density over the liquid's, 1 g/cm³; tension, dyn/cm; gravity, cm/s².
const DENSITY: f64 = 5.0;
const TENSION: f64 = 200.0;
const GRAVITY: f64 = 981.0;
/// Nodes of the reference solution along half the tank.
const NODES: usize = 106;
/// Over-relaxation factor, and tolerance of the change of a depth in a sweep, cm.
const RELAXATION_FACTOR: f64 = 1.7;
const DEPTH_TOLERANCE: f64 = 1e-9;
/// Time window, s, in which the depth is averaged.
const AVERAGING_START: f64 = 0.35;
const AVERAGING_END: f64 = 0.6;

/// The dimple around the plate: depths below the level on a quarter of the tank, from the middle, cm.
struct Dimple {
    depths: Vec<[f64; NODES + 1]>,
    /// Number of nodes under the plate.
    plate: usize,
}

impl Dimple {
    /// Solves `∇·(∇u/√(1 + |∇u|²)) = u ρg/γ` with the plate's upper edge at a depth and zero slope at the sides, by over-relaxation.
    fn of(depth: f64) -> Self {
        let plate = (PLATE_HALF_WIDTH / TANK_HALF_WIDTH * NODES as f64).round() as usize;
        let mut dimple = Self { depths: vec![[0.0; NODES + 1]; NODES + 1], plate };
        (0..=plate).for_each(|i| dimple.depths[i][..=plate].fill(depth));
        while dimple.relax() > DEPTH_TOLERANCE {}
        dimple
    }

    /// One sweep. Returns the largest change.
    fn relax(&mut self) -> f64 {
        let h = TANK_HALF_WIDTH / NODES as f64;
        let weight = h * h * GRAVITY / TENSION;
        let mut change: f64 = 0.0;
        for i in 0..=NODES as isize {
            for j in 0..=NODES as isize {
                if i.max(j) as usize <= self.plate {
                    continue;
                }
                let u = |di: isize, dj: isize| self.at(i + di, j + dj);
                let here = u(0, 0);
                let (mut sum, mut all) = (0.0, weight);
                for (di, dj) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
                    let beside = |side: isize| u(side * dj, side * di) + u(di + side * dj, dj + side * di);
                    let across = 0.25 * (beside(1) - beside(-1));
                    let there = u(di, dj);
                    let stretch = (1.0 + ((there - here).powi(2) + across * across) / (h * h)).sqrt();
                    (sum, all) = (sum + there / stretch, all + 1.0 / stretch);
                }
                let step = RELAXATION_FACTOR * (sum / all - here);
                self.depths[i as usize][j as usize] += step;
                change = change.max(step.abs());
            }
        }
        change
    }

    /// The depth at a node, mirrored at the middle and at the sides.
    fn at(&self, i: isize, j: isize) -> f64 {
        let n = NODES as isize;
        let [i, j] = [i, j].map(|k| n - (n - k.abs()).abs());
        self.depths[i as usize][j as usize]
    }

    /// The depth at a point, relative to the middle.
    fn depth(&self, x: f64, y: f64) -> f64 {
        let [x, y] = [x, y].map(|c| (c.abs() / TANK_HALF_WIDTH * NODES as f64).min(NODES as f64));
        let [i, j] = [x, y].map(|c| (c as isize).min(NODES as isize - 1));
        let (s, t) = (x - i as f64, y - j as f64);
        let row = |i: isize| self.at(i, j) * (1.0 - t) + self.at(i, j + 1) * t;
        row(i) * (1.0 - s) + row(i + 1) * s
    }

    /// Volume displaced by the plate and the dimple below the level, over that of the plate: the density that floats at this depth.
    fn displaced(&self) -> f64 {
        let h = TANK_HALF_WIDTH / NODES as f64;
        let half = |k: usize, end: usize| if k == 0 || k == end { 0.5 } else { 1.0 };
        let share = |i: usize, j: usize| {
            let within = i.max(j) <= self.plate;
            let own = if within { half(i, self.plate) * half(j, self.plate) } else { 0.0 };
            half(i, NODES) * half(j, NODES) - own
        };
        let nodes = (0..=NODES).flat_map(|i| (0..=NODES).map(move |j| (i, j)));
        let dimple: f64 = nodes.map(|(i, j)| share(i, j) * self.depths[i][j] * h * h).sum();
        let area = (self.plate as f64 * h).powi(2);
        (dimple / area + self.depths[0][0] + THICKNESS) / THICKNESS
    }
}

/// The dimple of the floating plate, by the secant method for the depth.
fn equilibrium() -> Dimple {
    let [mut shallow, mut deep] =
        [(0.15, Dimple::of(0.15).displaced()), (0.25, Dimple::of(0.25).displaced())];
    for _ in 0..4 {
        let depth = shallow.0 + (deep.0 - shallow.0) * (DENSITY - shallow.1) / (deep.1 - shallow.1);
        (shallow, deep) = (deep, (depth, Dimple::of(depth).displaced()));
    }
    Dimple::of(deep.0)
}

fn run() -> Result<Vec<Check>, StepError> {
    let dimple = equilibrium();
    let depth = dimple.depth(0.0, 0.0);
    // It displaces its weight, which raises the level.
    let level = INITIAL_LEVEL + DENSITY * THICKNESS * (PLATE_HALF_WIDTH / TANK_HALF_WIDTH).powi(2);
    let middle = Vector::<3>::new(TANK_HALF_WIDTH, TANK_HALF_WIDTH, level - depth - 0.5 * THICKNESS);
    let half_size = Vector::<3>::new(PLATE_HALF_WIDTH, PLATE_HALF_WIDTH, 0.5 * THICKNESS);
    let shape = block(middle, half_size);
    let description = ElasticSpecification {
        mesh: VolumeMesh::of_shape(&shape, DX / 1.5, ElementOrder::Linear).unwrap_or_default(),
        density: DENSITY,
        law: ConstitutiveLaw::Springs { stiffness: 5e5 },
        damping_ratio: 0.1,
        anchors: Vec::new(),
    };
    let elastic = Elastic::new(description).map_err(not_made)?;
    let mut plate = Solid::new(shape, SolidKind::Deformable(Arc::new(elastic)), DENSITY);
    (plate.young_cosine, plate.line_friction) = (-0.2, 3.0);
    let model = Model {
        kinematic_viscosity: 0.5,
        surface_tension: TENSION,
        gravity: Vector::<3>::new(0.0, 0.0, -GRAVITY),
        solids: vec![plate],
        ..unit_model(Grid::<3>::new([96, 96, 80], DX), [[Wall::Slip; 2]; 3])
    };
    let bath = |x: &Vector<3>| x[2] - level + dimple.depth(x[0] - TANK_HALF_WIDTH, x[1] - TANK_HALF_WIDTH);
    let mut sim = at_rest(model, &bath);
    let (mut sum, mut time, mut last) = (0.0, 0.0, 0.0);
    run_to(&mut sim, AVERAGING_END, |sim, _| {
        let step = sim.state.time - last;
        last = sim.state.time;
        if last > AVERAGING_START {
            let found = level - sim.state.solids[0].center_of_mass()[2] - 0.5 * THICKNESS;
            (sum, time) = (sum + found * step, time + step);
        }
    })?;
    let what = "depth of the upper face";
    Ok(vec![Check::relative(NAME, what, sum / time, depth, bars(0.1, 0.04)).in_unit("cm")])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_plate_floats_less_deep_than_plane_menisci_would_have_it() {
        let dimple = equilibrium();
        assert!((dimple.displaced() - DENSITY).abs() < 1e-6, "{}", dimple.displaced());
        let depth = dimple.depth(0.0, 0.0);
        // Half as many nodes give 0.2152.
        assert!((depth - 0.2160).abs() < 2e-4, "{depth}");
        // A plane meniscus of this depth carries less; the corners add to it.
        let plane = TENSION
            * (2.0 * PLATE_HALF_WIDTH)
            * 4.0
            * (2.0 * (0.5 * depth * (GRAVITY / TENSION).sqrt()).asin()).sin();
        let carried = (DENSITY - 1.0 - depth / THICKNESS)
            * THICKNESS
            * 4.0
            * PLATE_HALF_WIDTH
            * PLATE_HALF_WIDTH
            * GRAVITY;
        assert!(carried > 1.05 * plane && carried < 1.4 * plane, "{carried} {plane}");
    }
}
