//! Deformable plates with a drop on them, shared by the cases.

use crate::setup::{at_rest, block, run_to, unit_model};
use crate::soft::{SoftMaterial, not_made};
use meniscus_elastic::{Anchor, Elastic, ElementOrder, SurfaceTension};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use meniscus_numerics::mesh::VolumeMesh;
use meniscus_sim::{LineTracker, Model, Simulation, Solid, SolidKind, StepError, Wall};
use std::f64::consts::FRAC_PI_2;
use std::iter::Sum;
use std::ops::Div;
use std::sync::Arc;

/// A plate and a drop on it. Units: γ = ρ = 1.
#[derive(Clone, Copy, Debug)]
pub struct PlateSetup {
    /// Cells per unit of length.
    pub cells: usize,
    /// Contact angle, degrees.
    pub angle: f64,
    /// Initial contact angle of the drop, degrees.
    pub initial_angle: f64,
    /// Length of the plate.
    pub length: f64,
    /// Its thickness.
    pub thickness: f64,
    /// Bending stiffness, `E t³ / 12 (1 − ν²)` over γ.
    pub bending: f64,
    /// Its Poisson's ratio.
    pub poisson: f64,
    /// Surface tension of the dry plate over γ.
    pub own_tension: f64,
    /// Density of the plate over the liquid's.
    pub density: f64,
    /// Damping ratio of its lowest mode.
    pub damping: f64,
    /// Area of the drop.
    pub area: f64,
    /// Position of the drop along the plate, from the middle.
    pub drop_offset: f64,
    /// Kinematic viscosity of the liquid.
    pub viscosity: f64,
    /// Support of the plate.
    pub support: PlateSupport,
    /// Height of the domain, and initial height of the plate's middle in it.
    pub domain_and_plate_height: [f64; 2],
}

/// Support of a plate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlateSupport {
    /// No anchored part.
    Free,
    /// The left end is anchored.
    LeftEnd,
    /// The lower side is anchored.
    Bottom,
    /// The lower side and the ends are anchored.
    BottomAndEnds,
    /// The plate is rigid.
    Rigid,
}

/// The simulation of a plate, with the initial positions of its vertices.
pub struct Plate {
    /// The simulation; the plate is its only solid.
    pub sim: Simulation<2>,
    /// Initial position of the plate's middle.
    pub middle: Vector<2>,
    /// Vertices of its lower side, and their positions along the plate from its middle, in order.
    pub bottom: Vec<(usize, f64)>,
    /// The same for its upper side.
    pub top: Vec<(usize, f64)>,
}

impl PlateSetup {
    /// A free plate of length 5 and stiffness 1 in the middle of a domain, with a drop of half a disc's area at its contact angle;
    /// without a thickness.
    pub fn free(cells: usize, angle: f64) -> Self {
        Self {
            cells,
            angle,
            initial_angle: angle,
            length: 5.0,
            thickness: 0.0,
            bending: 1.0,
            poisson: 0.3,
            own_tension: 0.0,
            density: 1.0,
            damping: 0.3,
            area: FRAC_PI_2,
            drop_offset: 0.0,
            viscosity: 0.3,
            support: PlateSupport::Free,
            domain_and_plate_height: [4.0, 1.4],
        }
    }

    /// Half the width wetted by the drop on a flat plate at a contact angle, degrees.
    pub fn half_width(&self, angle: f64) -> f64 {
        let t = angle.to_radians();
        (self.area / (t - t.sin() * t.cos())).sqrt() * t.sin()
    }

    /// Starts with the drop as a cap at the initial angle on the plate at rest.
    ///
    /// # Errors
    /// If the plate cannot be made.
    pub fn start(&self) -> Result<Plate, StepError> {
        let dx = 1.0 / self.cells as f64;
        let room = Vector::<2>::new(self.length + 1.6, self.domain_and_plate_height[0]);
        let grid = Grid::<2>::new([0, 1].map(|a| (room[a] * self.cells as f64) as usize), dx);
        let middle = Vector::<2>::new(0.5 * room[0] + 0.13 * dx, self.domain_and_plate_height[1] + 0.3 * dx);
        let half = Vector::<2>::new(0.5 * self.length, 0.5 * self.thickness);
        let shape = block(middle, half);
        let mesh = VolumeMesh::of_shape(&shape, dx / 1.5, ElementOrder::Quadratic).unwrap_or_default();
        let low = middle - half;
        let side = |height: f64| vertices_at_height(&mesh.positions, height, middle[0]);
        let (bottom, top) = (side(low[1]), side(low[1] + self.thickness));
        let kind = match self.support {
            PlateSupport::Rigid => SolidKind::Fixed,
            _ => SolidKind::Deformable(Arc::new(self.elastic(mesh, &low)?)),
        };
        let mut solid = Solid::new(shape, kind, self.density).padded(self.thickness, dx);
        solid.young_cosine = self.angle.to_radians().cos();
        let t = self.initial_angle.to_radians();
        let radius = self.half_width(self.initial_angle) / t.sin();
        let side = half[1] + solid.padding;
        let center = middle + Vector::<2>::new(self.drop_offset, side - radius * t.cos());
        // Liquid may extend into the plate, but not beside its ends.
        let beside = move |x: &Vector<2>| (middle[1] + side - x[1]).min((x[0] - middle[0]).abs() - half[0]);
        let drop = move |x: &Vector<2>| ((x - center).norm() - radius).max(middle[1] - x[1]).max(beside(x));
        let model = Model {
            kinematic_viscosity: self.viscosity,
            solids: vec![solid],
            ..unit_model(grid, [[Wall::Open; 2]; 2])
        };
        let sim = at_rest(model, &drop);
        Ok(Plate { sim, middle, bottom, top })
    }

    fn elastic(&self, mesh: VolumeMesh<2>, low: &Vector<2>) -> Result<Elastic<2>, StepError> {
        let young = 12.0 * self.bending * (1.0 - self.poisson * self.poisson) / self.thickness.powi(3);
        let anchors = match self.support {
            PlateSupport::LeftEnd => vec![Anchor::within(&mesh, |x| x[0] < low[0] + 1e-9)],
            PlateSupport::Bottom => vec![Anchor::within(&mesh, |x| x[1] < low[1] + 1e-9)],
            PlateSupport::BottomAndEnds => {
                let at_end = |x: f64| x < 1e-9 || x > self.length - 1e-9;
                vec![Anchor::within(&mesh, |x| x[1] < low[1] + 1e-9 || at_end(x[0] - low[0]))]
            }
            _ => Vec::new(),
        };
        let (poisson, density, damping) = (self.poisson, self.density, self.damping);
        let description = SoftMaterial { young, poisson, density, damping }.specification(mesh, anchors);
        let tension = SurfaceTension::new(&description.mesh, self.own_tension);
        Elastic::with_terms(description, vec![Box::new(tension)]).map_err(not_made)
    }
}

impl Plate {
    /// Slope of its lower side between two positions along it, rad.
    pub fn slope(&self, from: f64, to: f64) -> f64 {
        let Some(body) = self.sim.state.solids[0].as_deformable() else { return 0.0 };
        let within = self.bottom.iter().filter(|(_, s)| (from..=to).contains(s));
        let points: Vec<Vector<2>> = within.map(|(k, _)| body.vertices.positions[*k] - self.middle).collect();
        let mean = points.iter().sum::<Vector<2>>() / points.len() as f64;
        let sum = |f: &dyn Fn(&Vector<2>) -> f64| points.iter().map(|p| f(&(p - mean))).sum::<f64>();
        (sum(&|d| d[0] * d[1]) / sum(&|d| d[0] * d[0])).atan()
    }

    /// Positions of the vertices of a side.
    fn vertex_positions(&self, side: &[(usize, f64)], within: impl Fn(f64) -> bool) -> Vec<Vector<2>> {
        let Some(body) = self.sim.state.solids[0].as_deformable() else { return Vec::new() };
        side.iter().filter(|(_, s)| within(*s)).map(|(k, _)| body.vertices.positions[*k]).collect()
    }

    /// Half the angle between the last pieces of the given length at both ends, rad; positive where they rise.
    pub fn end_slope(&self, piece: f64) -> f64 {
        let end = self.bottom.last().map_or(0.0, |b| b.1);
        let direction = |within: &dyn Fn(f64) -> bool| {
            let places = self.vertex_positions(&self.bottom, within);
            let way = places.last().zip(places.first()).map_or(Vector::zeros(), |(b, a)| b - a);
            way[1].atan2(way[0])
        };
        0.5 * (direction(&|s| s > end - piece) - direction(&|s| s < piece - end))
    }

    /// Mean height of its upper side at two positions from its middle, relative to the start.
    pub fn mean_deflection(&self, places: [f64; 2], thickness: f64) -> f64 {
        let side = self.vertex_positions(&self.top, |_| true);
        let height = |s: f64| {
            let x = self.middle[0] + s;
            let k = side.partition_point(|p| p[0] < x).clamp(1, side.len() - 1);
            let (a, b) = (side[k - 1], side[k]);
            a[1] + (b[1] - a[1]) * (x - a[0]) / (b[0] - a[0])
        };
        0.5 * (height(places[0]) + height(places[1])) - self.middle[1] - 0.5 * thickness
    }

    /// Half the distance between the ends of its middle line, and their height over its middle.
    pub fn ends(&self) -> [f64; 2] {
        let sides = self
            .vertex_positions(&self.top, |_| true)
            .into_iter()
            .zip(self.vertex_positions(&self.bottom, |_| true));
        let line: Vec<Vector<2>> = sides.map(|(a, b)| 0.5 * (a + b)).collect();
        let (Some(first), Some(last)) = (line.first(), line.last()) else { return [0.0; 2] };
        let middle = 0.5 * (line[(line.len() - 1) / 2] + line[line.len() / 2]);
        let (way, over) = (last - first, 0.5 * (first + last) - middle);
        [0.5 * way.norm(), (way[0] * over[1] - way[1] * over[0]) / way.norm()]
    }

    /// Length along the upper side between the first and the last point of the contact line.
    pub fn wetted_length(&self, tracker: &LineTracker<2>) -> f64 {
        let side = self.vertex_positions(&self.top, |_| true);
        let line = tracker.extract(&self.sim);
        let places = line.points.iter().map(|p| arc_length_at(&side, &p.at));
        let (low, high) =
            places.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), s| (low.min(s), high.max(s)));
        high - low
    }

    /// Runs to a time. Returns the mean of a value over the last fifth.
    ///
    /// # Errors
    /// The step's.
    pub fn mean_over_last_fifth<T>(&mut self, time: f64, value: impl Fn(&Self) -> T) -> Result<T, StepError>
    where
        T: Sum + Div<f64, Output = T>,
    {
        const TIMES: u32 = 20;
        run_to(&mut self.sim, 0.8 * time, |_, _| ())?;
        let values = (1..=TIMES).map(|k| {
            run_to(&mut self.sim, time * (0.8 + 0.2 * f64::from(k) / f64::from(TIMES)), |_, _| ())?;
            Ok(value(self))
        });
        Ok(values.sum::<Result<T, StepError>>()? / f64::from(TIMES))
    }
}

/// The vertices at a height with their positions along the first axis from an origin, in their order along it.
pub fn vertices_at_height(positions: &[Vector<2>], height: f64, origin: f64) -> Vec<(usize, f64)> {
    let on = positions.iter().enumerate().filter(|(_, x)| (x[1] - height).abs() < 1e-9);
    let mut on: Vec<(usize, f64)> = on.map(|(k, x)| (k, x[0] - origin)).collect();
    on.sort_by(|a, b| a.1.total_cmp(&b.1));
    on
}

/// Arc length along a curve at the point closest to `x`.
fn arc_length_at(curve: &[Vector<2>], x: &Vector<2>) -> f64 {
    let (mut start, mut best) = (0.0, (f64::INFINITY, 0.0));
    for piece in curve.windows(2) {
        let way = piece[1] - piece[0];
        let t = ((x - piece[0]).dot(&way) / way.norm_squared()).clamp(0.0, 1.0);
        let distance = (x - piece[0] - way * t).norm();
        if distance < best.0 {
            best = (distance, start + t * way.norm());
        }
        start += way.norm();
    }
    best.1
}
