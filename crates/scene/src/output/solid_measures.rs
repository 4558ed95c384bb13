//! Measures of each solid in every row of the time series: position of its tip, deflection, wetted share, and the contact line of the
//! largest connected component of liquid on it.
//!
//! They follow from the state and the contact line alone, so a resumed run writes the same numbers. Angles by a fit of the free surface
//! take longer; `meniscus measure` computes them.

use super::summary::deflection;
use crate::job::padded_to_3d;
use meniscus_numerics::{Vector, par};
use meniscus_sim::{Component, ContactLine, LinePoint, Simulation};
use std::fmt::Write as _;

/// Relative tolerance within which vertices are equally far away.
const EQUAL_DISTANCE_TOLERANCE: f64 = 1e-6;
/// Most anchored vertices that distances are measured from.
const MAX_ANCHOR_SAMPLES: usize = 2000;
/// Most vertices of a tip whose distances from each other are measured.
const MAX_TIP_SAMPLES: usize = 500;
/// Ratio of horizontal to vertical distance below which two points lie one above the other up to rounding.
const VERTICAL_TOLERANCE: f64 = 1e-9;
/// Names of the axes.
const AXES: [&str; 3] = ["x", "y", "z"];

/// Which measures the named solids have.
#[derive(Clone, Debug)]
pub struct SolidMeasures {
    /// For each solid the vertices of its mesh that form its tip; none for a rigid one.
    tips: Vec<Option<Vec<u32>>>,
}

impl SolidMeasures {
    /// Measures of the first `solids` solids of a simulation, which are the named ones.
    pub fn new<const D: usize>(simulation: &Simulation<D>, solids: usize) -> Self {
        Self { tips: (0..solids).map(|number| tip_vertices(simulation, number)).collect() }
    }

    /// Number of named solids.
    pub fn solids(&self) -> usize {
        self.tips.len()
    }

    /// Names of the columns, solid by solid, from the names of the solids.
    pub fn columns<'a, const D: usize>(&self, names: impl Iterator<Item = &'a str>) -> Vec<String> {
        self.tips.iter().zip(names).flat_map(|(tip, name)| solid_columns(name, D, tip.is_some())).collect()
    }

    /// The cells of a row in the order of the columns; empty where there is no value.
    pub fn cells<const D: usize>(&self, simulation: &Simulation<D>, line: &ContactLine<D>) -> String {
        let mut row = String::new();
        let mut put = |value: Option<f64>| {
            row.push(',');
            value.iter().for_each(|value| {
                let _ = write!(row, "{value:?}");
            });
        };
        for (number, tip) in self.tips.iter().enumerate() {
            let (drop, points) = line_of_largest_component(simulation, line, number).unzip();
            let points = points.unwrap_or_default();
            let centroid = drop.map_or(Vector::zeros(), |drop| drop.centroid);
            line_angles(&points, &centroid).into_iter().for_each(&mut put);
            put(base_radius(&points));
            put(Some(simulation.wetted_fraction(number)));
            put(Some(line_loops(line, number) as f64));
            if let Some(tip) = tip {
                put(deflection(&simulation.solid(number)));
                let at = tip_position(simulation, number, tip);
                (0..D).for_each(|a| put(at.map(|x| x[a])));
                let (width, spread) = tip_width_and_spread(simulation, number, tip).unzip();
                put(width);
                put(spread);
            }
        }
        row
    }
}

/// Names of the columns of a solid, in the order of [`SolidMeasures::cells`].
pub fn solid_columns(name: &str, dimension: usize, deforms: bool) -> Vec<String> {
    let angles = if dimension == 2 { &["left", "right"][..] } else { &["mean", "least", "largest"] };
    let mut columns: Vec<String> = angles.iter().map(|a| format!("angle_{name}_{a}")).collect();
    columns.extend([format!("base_radius_{name}"), format!("wetted_{name}"), format!("line_loops_{name}")]);
    if deforms {
        columns.push(format!("deflection_{name}"));
        columns.extend(AXES[..dimension].iter().map(|axis| format!("tip_{name}_{axis}")));
        columns.extend([format!("tip_width_{name}"), format!("tip_spread_{name}")]);
    }
    columns
}

/// Number of connected parts of the contact line on a solid; in 2D that of its points.
fn line_loops<const D: usize>(line: &ContactLine<D>, number: usize) -> usize {
    let mut parent: Vec<u32> = (0..line.points.len() as u32).collect();
    fn root(parent: &mut [u32], mut i: u32) -> u32 {
        while parent[i as usize] != i {
            parent[i as usize] = parent[parent[i as usize] as usize];
            i = parent[i as usize];
        }
        i
    }
    for [a, b] in &line.segments {
        let [a, b] = [root(&mut parent, *a), root(&mut parent, *b)];
        parent[a.max(b) as usize] = a.min(b);
    }
    let is_root = |i: &usize| parent[*i] as usize == *i && line.points[*i].solid as usize == number;
    (0..parent.len()).filter(is_root).count()
}

/// Largest distance between two vertices of the tip, and how far their distances from the solid's centre of mass lie apart, m.
fn tip_width_and_spread<const D: usize>(
    simulation: &Simulation<D>,
    number: usize,
    tip: &[u32],
) -> Option<(f64, f64)> {
    let now = &simulation.state.solids[number];
    let positions = &now.as_deformable()?.vertices.positions;
    let center = now.center_of_mass();
    let points: Vec<Vector<D>> = tip
        .iter()
        .step_by(tip.len().div_ceil(MAX_TIP_SAMPLES).max(1))
        .map(|v| positions[*v as usize])
        .collect();
    let pairs = points.iter().enumerate().flat_map(|(i, x)| points[..i].iter().map(move |y| (x - y).norm()));
    let width = pairs.fold(0.0, f64::max);
    let distances = || points.iter().map(|x| (x - center).norm());
    Some((width, distances().fold(0.0, f64::max) - distances().fold(f64::INFINITY, f64::min)))
}

/// The surface vertices of a solid that at rest are farthest from its anchored parts, or from the centroid of its surface vertices if
/// none is anchored; none for a rigid solid.
fn tip_vertices<const D: usize>(simulation: &Simulation<D>, number: usize) -> Option<Vec<u32>> {
    let elastic = simulation.model.solids[number].elastic()?;
    let surface_vertices = simulation.solid(number).surface.volume_vertices();
    let rest = &elastic.rest_mesh().positions;
    let anchored: Vec<u32> =
        surface_vertices.iter().copied().filter(|v| elastic.anchored()[*v as usize]).collect();
    let middle = surface_vertices.iter().map(|v| rest[*v as usize]).sum::<Vector<D>>()
        / surface_vertices.len().max(1) as f64;
    let far = |v: &u32| {
        let to = |from: &Vector<D>| (rest[*v as usize] - from).norm();
        let some = anchored.iter().step_by(anchored.len().div_ceil(MAX_ANCHOR_SAMPLES).max(1));
        some.map(|h| to(&rest[*h as usize])).reduce(f64::min).unwrap_or_else(|| to(&middle))
    };
    let distances = par::map_slice(surface_vertices, 16, far);
    let farthest = distances.iter().copied().fold(0.0, f64::max);
    let is_tip = |(_, distance): &(&u32, &f64)| **distance >= (1.0 - EQUAL_DISTANCE_TOLERANCE) * farthest;
    Some(surface_vertices.iter().zip(&distances).filter(is_tip).map(|(v, _)| *v).collect())
}

/// Position of the tip, m: the mean of its vertices.
fn tip_position<const D: usize>(simulation: &Simulation<D>, number: usize, tip: &[u32]) -> Option<[f64; 3]> {
    let positions = &simulation.state.solids[number].as_deformable()?.vertices.positions;
    let sum: Vector<D> = tip.iter().map(|v| positions[*v as usize]).sum();
    Some(padded_to_3d(&(sum / tip.len() as f64)))
}

/// The largest component that has points of the contact line on a solid, and these points: those in its box, widened by a cell.
fn line_of_largest_component<'a, const D: usize>(
    simulation: &'a Simulation<D>,
    line: &'a ContactLine<D>,
    number: usize,
) -> Option<(&'a Component<D>, Vec<&'a LinePoint<D>>)> {
    let dx = simulation.model.grid.dx;
    let own: Vec<&LinePoint<D>> = line.points.iter().filter(|p| p.solid as usize == number).collect();
    let within = |drop: &Component<D>| -> Vec<&'a LinePoint<D>> {
        let holds = |p: &&&LinePoint<D>| {
            (0..D).all(|a| p.at[a] >= drop.lower[a] - dx && p.at[a] <= drop.upper[a] + dx)
        };
        own.iter().filter(holds).copied().collect()
    };
    let drops = simulation.state.components.iter().map(|drop| (drop, within(drop)));
    let touching = drops.filter(|(_, points)| !points.is_empty());
    touching.max_by(|a, b| a.0.volume.total_cmp(&b.0.volume))
}

/// 2D: the angles at the left and right outermost points (the lower and upper ones if one lies above the other); a single point is
/// on one side of the drop's centroid. 3D: mean along the line, least and largest. Degrees; none without a line.
fn line_angles<const D: usize>(points: &[&LinePoint<D>], centroid: &Vector<D>) -> Vec<Option<f64>> {
    if D == 2 {
        let order = |a: &Vector<D>, b: &Vector<D>| {
            let separation = b - a;
            let axis = if separation[0].abs() > VERTICAL_TOLERANCE * separation[1].abs() { 0 } else { 1 };
            a[axis].total_cmp(&b[axis])
        };
        if let [only] = points {
            let angle = Some(only.angle_degrees);
            return if order(&only.at, centroid).is_le() { vec![angle, None] } else { vec![None, angle] };
        }
        let before = |a: &&&LinePoint<D>, b: &&&LinePoint<D>| order(&a.at, &b.at);
        let ends = [points.iter().min_by(before), points.iter().max_by(before)];
        return ends.map(|p| p.map(|p| p.angle_degrees)).to_vec();
    }
    let length: f64 = points.iter().map(|p| p.length).sum();
    let sum: f64 = points.iter().map(|p| p.length * p.angle_degrees).sum();
    let all = || points.iter().map(|p| p.angle_degrees);
    vec![(length > 0.0).then(|| sum / length), all().reduce(f64::min), all().reduce(f64::max)]
}

/// Mean distance of the points from their centroid, m; none for fewer than two.
fn base_radius<const D: usize>(points: &[&LinePoint<D>]) -> Option<f64> {
    let length: f64 = points.iter().map(|p| p.length).sum();
    if points.len() < 2 || length <= 0.0 {
        return None;
    }
    let middle = points.iter().map(|p| p.at * p.length).sum::<Vector<D>>() / length;
    Some(points.iter().map(|p| p.length * (p.at - middle).norm()).sum::<f64>() / length)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(x: f64, y: f64, angle_degrees: f64) -> LinePoint<2> {
        let zero = Vector::<2>::zeros();
        LinePoint {
            at: Vector::<2>::new(x, y),
            solid: 0,
            angle_degrees,
            speed: 0.0,
            force: zero,
            length: 1.0,
        }
    }

    #[test]
    fn left_and_right_are_the_outermost_points() {
        let [a, b, c] = [point(0.3, 1.0, 50.0), point(0.1, 1.0, 33.0), point(0.2, 2.0, 90.0)];
        let centroid = Vector::<2>::new(0.2, 1.1);
        assert_eq!(line_angles(&[&a, &b, &c], &centroid), [Some(33.0), Some(50.0)]);
        assert_eq!(line_angles(&[&a], &centroid), [None, Some(50.0)]);
        assert_eq!(line_angles(&[&b], &centroid), [Some(33.0), None]);
        assert!(base_radius(&[&a, &b]).is_some_and(|radius| (radius - 0.1).abs() < 1e-15));
        // On an upright wall the lower one comes first, whatever the rounding of x.
        let [low, high] = [point(1.0 + 1e-15, 0.0, 20.0), point(1.0, 1.0, 60.0)];
        assert_eq!(line_angles(&[&high, &low], &centroid), [Some(20.0), Some(60.0)]);
        assert_eq!((line_angles::<2>(&[], &centroid), base_radius::<2>(&[])), (vec![None, None], None));
    }
}
