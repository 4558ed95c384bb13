//! Sample points of a shape's surface, for contact with other shapes.
//!
//! A ball is one point with its radius, a capsule several along its segment: these are exact where the other shape's
//! distance is. All other surfaces are points at most an edge apart, including corners and sharp rims.

use super::{MeshShape, Shape, unit};
use crate::grid::{CellField, Grid, Tiles};
use crate::{Matrix, Vector};
use std::f64::consts::PI;

/// A sample point with a ball around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceSample<const D: usize> {
    /// Position, m.
    pub position: Vector<D>,
    /// Radius of the ball, m; zero for a point of the surface.
    pub radius: f64,
    /// Whether it lies on a sharp edge or corner.
    pub sharp: bool,
}

/// Norm of the distance's finite-difference gradient at a point of the surface below which the surface has an edge there.
const MIN_SMOOTH_GRADIENT_NORM: f64 = 0.97;

/// Number of iterations of the projection onto a rim.
const RIM_PROJECTION_ITERATIONS: usize = 12;

impl<const D: usize> Shape<D> {
    /// Samples of its surface at most `edge` (m) apart. A half space has none: shapes that meet it must be sampled themselves.
    pub fn surface_samples(&self, edge: f64) -> Vec<SurfaceSample<D>> {
        match self {
            Self::Ball { center, radius } => {
                vec![SurfaceSample { position: *center, radius: *radius, sharp: false }]
            }
            Self::Capsule { a, b, radius } => {
                let n = ((b - a).norm() / edge).ceil().max(1.0);
                (0..=n as usize)
                    .map(|i| SurfaceSample {
                        position: a + (b - a) * (i as f64 / n),
                        radius: *radius,
                        sharp: false,
                    })
                    .collect()
            }
            Self::Union(parts) => {
                let outside =
                    |p: &SurfaceSample<D>| p.radius > 0.0 || self.signed_distance(&p.position) > -1e-6 * edge;
                parts.iter().flat_map(|part| part.surface_samples(edge)).filter(outside).collect()
            }
            other => {
                let sharp = |x: &Vector<D>| other.gradient(x, 0.2 * edge).norm() < MIN_SMOOTH_GRADIENT_NORM;
                let probe = |position| SurfaceSample { position, radius: 0.0, sharp: sharp(&position) };
                other.surface_points(edge).into_iter().map(probe).collect()
            }
        }
    }

    /// Whether the shape is known to be convex.
    pub fn is_convex(&self) -> bool {
        match self {
            Self::Ball { .. } | Self::Box { .. } | Self::HalfSpace { .. } => true,
            Self::Cylinder { .. } | Self::Capsule { .. } | Self::Ellipsoid { .. } => true,
            Self::PerturbedBall { .. } | Self::Extrusion { .. } | Self::Mesh(_) => false,
            Self::Difference { .. } | Self::SmoothUnion(_) => false,
            Self::Union(parts) => parts.len() == 1 && parts[0].is_convex(),
        }
    }

    /// The parts of a union, without nesting; the shape itself if it is no union.
    pub fn parts(&self) -> Vec<&Self> {
        match self {
            Self::Union(parts) => parts.iter().flat_map(Self::parts).collect(),
            one => vec![one],
        }
    }

    /// Unit vector along the gradient of the signed distance, by differences over `step` (m); zero where the gradient is.
    pub fn normal(&self, x: &Vector<D>, step: f64) -> Vector<D> {
        self.gradient(x, step).try_normalize(0.0).unwrap_or(Vector::zeros())
    }

    fn gradient(&self, x: &Vector<D>, step: f64) -> Vector<D> {
        Vector::from_fn(|a, _| {
            let by = Vector::<D>::from_fn(|b, _| if a == b { step } else { 0.0 });
            (self.signed_distance(&(x + by)) - self.signed_distance(&(x - by))) / (2.0 * step)
        })
    }

    /// Points of its surface at most `edge` (m) apart.
    fn surface_points(&self, edge: f64) -> Vec<Vector<D>> {
        let close = 1e-6 * edge;
        match self {
            Self::HalfSpace { .. } => Vec::new(),
            Self::Box { center, half_size, rotation } => {
                let all = box_points(half_size, edge);
                all.into_iter().map(|x| center + rotation * x).collect()
            }
            Self::Cylinder { center, axis, radius, height } => {
                let frame = rotation_to(&unit(axis));
                let all = cylinder_points(*radius, 0.5 * height, edge);
                all.into_iter().map(|x| center + frame * x).collect()
            }
            Self::Mesh(mesh) => mesh_points(mesh, edge),
            Self::Union(parts) => {
                let all = parts.iter().flat_map(|part| part.surface_points(edge));
                all.filter(|x| self.signed_distance(x) > -close).collect()
            }
            Self::Difference { of, minus } => {
                let mut points = of.surface_points(edge);
                let near = points.iter().filter(|x| minus.signed_distance(x).abs() < edge);
                let rim: Vec<_> = near.map(|x| project_onto_rim(x, of, minus, edge)).collect();
                points.extend(minus.surface_points(edge));
                points.extend(rim);
                points.into_iter().filter(|x| self.signed_distance(x).abs() < close).collect()
            }
            _ => self.smooth_points(edge),
        }
    }

    /// The vertices of a mesh of a surface without sharp edges, projected onto it.
    fn smooth_points(&self, edge: f64) -> Vec<Vector<D>> {
        let (low, high) = self.bounds();
        let cells = std::array::from_fn(|a| ((high[a] - low[a]) / edge).ceil().max(1.0) as usize + 4);
        let grid = Grid::<D>::new(cells, edge);
        let corner = low - Vector::repeat(2.0 * edge);
        let lattice = grid.lattice();
        let mut field = CellField::new(grid, 0.0);
        field.data.iter_mut().enumerate().for_each(|(i, value)| {
            *value = self.signed_distance(&(corner + grid.center(lattice.coordinates(i))));
        });
        let inside = Tiles::all(grid).negative_runs(&field.data);
        let net = crate::mesh::extract_isosurface(&field, &inside).mesh.positions;
        let onto = |x: Vector<D>| x - self.normal(&x, 1e-4 * edge) * self.signed_distance(&x);
        net.into_iter().map(|x| onto(onto(x + corner))).collect()
    }
}

/// Projects a point onto the intersection of two surfaces, alternating between both.
fn project_onto_rim<const D: usize>(x: &Vector<D>, one: &Shape<D>, other: &Shape<D>, edge: f64) -> Vector<D> {
    let mut x = *x;
    for _ in 0..RIM_PROJECTION_ITERATIONS {
        for shape in [other, one] {
            x -= shape.normal(&x, 1e-4 * edge) * shape.signed_distance(&x);
        }
    }
    x
}

/// Points of the surface of a box around the origin.
fn box_points<const D: usize>(half: &Vector<D>, edge: f64) -> Vec<Vector<D>> {
    let cells: [usize; D] = std::array::from_fn(|a| (2.0 * half[a] / edge).ceil().max(1.0) as usize);
    let count = cells.iter().map(|n| n + 1).product();
    let mut points = Vec::new();
    for mut i in 0..count {
        let at: [usize; D] = std::array::from_fn(|a| {
            let k = i % (cells[a] + 1);
            i /= cells[a] + 1;
            k
        });
        if (0..D).any(|a| at[a] == 0 || at[a] == cells[a]) {
            points.push(Vector::from_fn(|a, _| half[a] * (2.0 * at[a] as f64 / cells[a] as f64 - 1.0)));
        }
    }
    points
}

/// Points of the surface of a cylinder around the origin, along the last axis: rings on its side and on its ends.
fn cylinder_points<const D: usize>(radius: f64, half: f64, edge: f64) -> Vec<Vector<D>> {
    if D == 2 {
        return box_points(&Vector::from_fn(|a, _| if a == 0 { radius } else { half }), edge);
    }
    let mut points = Vec::new();
    let mut ring = |r: f64, z: f64| {
        let n = (2.0 * PI * r / edge).ceil().max(1.0);
        for k in 0..n as usize {
            let (s, c) = (2.0 * PI * k as f64 / n).sin_cos();
            points.push(Vector::from_fn(|a, _| [r * c, r * s, z][a]));
        }
    };
    let (rings, levels) = ((radius / edge).ceil().max(1.0), (2.0 * half / edge).ceil().max(1.0));
    (0..=levels as usize).for_each(|k| ring(radius, half * (2.0 * k as f64 / levels - 1.0)));
    for k in 0..rings as usize {
        let r = radius * k as f64 / rings;
        ring(r, half);
        ring(r, -half);
    }
    points
}

/// A rotation that takes the last axis to a direction.
fn rotation_to<const D: usize>(to: &Vector<D>) -> Matrix<D> {
    let mut columns = vec![*to];
    for a in 0..D {
        let mut e = Vector::<D>::from_fn(|b, _| if a == b { 1.0 } else { 0.0 });
        columns.iter().for_each(|c: &Vector<D>| e -= c * c.dot(&e));
        if columns.len() < D && e.norm() > 0.5 {
            columns.push(e.normalize());
        }
    }
    Matrix::from_fn(|r, c| columns.get(D - 1 - c).map_or(0.0, |column| column[r]))
}

/// The vertices of a mesh, and points of its facets.
fn mesh_points<const D: usize>(mesh: &MeshShape<D>, edge: f64) -> Vec<Vector<D>> {
    let surface = mesh.surface();
    let mut points = surface.positions.clone();
    for facet in 0..surface.facets.len() {
        let c = surface.corners(facet);
        let longest = (0..D).map(|k| (c[(k + 1) % D] - c[k]).norm()).fold(0.0, f64::max);
        let n = (longest / edge).ceil().max(1.0) as usize;
        let (u, v) = ((c[1] - c[0]) / n as f64, (c[D - 1] - c[0]) / n as f64);
        for i in 0..=n {
            if D == 2 {
                points.push(c[0] + u * i as f64);
            } else {
                (0..=n - i).for_each(|j| points.push(c[0] + u * i as f64 + v * j as f64));
            }
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    fn nearest<const D: usize>(probes: &[SurfaceSample<D>], x: &Vector<D>) -> f64 {
        probes.iter().map(|p| (p.position - x).norm()).fold(f64::INFINITY, f64::min)
    }

    fn turned() -> Matrix<3> {
        nalgebra::Rotation3::new(Vector::<3>::new(0.3, -0.5, 0.8)).into_inner()
    }

    #[test]
    fn probes_lie_on_the_surface_and_keep_its_corners() {
        let (center, half_size) = (Vector::<3>::new(0.3, 0.1, -0.2), Vector::<3>::new(0.5, 0.2, 0.11));
        let block = Shape::Box { center, half_size, rotation: turned() };
        let ball = Shape::Ball { center: Vector::<3>::new(0.4, 0.1, -0.1), radius: 0.3 };
        let axis = Vector::<3>::new(1.0, 2.0, -0.5);
        let cylinder = Shape::Cylinder { center, axis, radius: 0.25, height: 0.4 };
        let ellipsoid =
            Shape::Ellipsoid { center, radii: Vector::<3>::new(0.4, 0.2, 0.3), rotation: turned() };
        let cut = Shape::Difference { of: Box::new(block.clone()), minus: Box::new(ball.clone()) };
        let both = Shape::Union(vec![cylinder.clone(), ellipsoid.clone(), ball]);
        for shape in [&block, &cylinder, &ellipsoid, &cut, &both] {
            let probes = shape.surface_samples(0.05);
            assert!(probes.len() > 100);
            for p in &probes {
                let distance = shape.signed_distance(&p.position) + p.radius;
                assert!(distance.abs() < 1e-6 || p.radius > 0.0, "{shape:?}: {distance}");
            }
        }
        let corner = center + turned() * half_size;
        assert!(nearest(&block.surface_samples(0.05), &corner) < 1e-12);
        // Points of the rim that the ball cuts into the box's face.
        let rim = cut.surface_samples(0.05);
        let (one, other) = (&block, &Shape::Ball { center: Vector::<3>::new(0.4, 0.1, -0.1), radius: 0.3 });
        let on = |p: &&SurfaceSample<3>| {
            one.signed_distance(&p.position).abs() < 1e-6 && other.signed_distance(&p.position).abs() < 1e-6
        };
        assert!(rim.iter().filter(on).count() > 20);
        assert!(block.is_convex() && !both.is_convex() && !cut.is_convex());
        let edges = block.surface_samples(0.05).into_iter().filter(|p| p.sharp);
        let off = |p: &SurfaceSample<3>| (turned().tr_mul(&(p.position - center)).abs() - half_size).abs();
        let ends = |p: SurfaceSample<3>| off(&p).iter().filter(|d| **d < 1e-9).count();
        assert!(edges.map(ends).all(|n| n >= 2));
    }

    #[test]
    fn probes_leave_no_gap() {
        let axis = Vector::<3>::new(0.2, 1.0, 0.4);
        let cylinder = Shape::Cylinder { center: Vector::<3>::zeros(), axis, radius: 0.25, height: 0.4 };
        let probes = cylinder.surface_samples(0.05);
        let frame = rotation_to(&axis.normalize());
        for i in 0..200 {
            let (s, c) = (f64::from(i) * 0.37).sin_cos();
            let z = 0.2 * (f64::from(i) * 1.7).sin();
            let x = frame * Vector::<3>::new(0.25 * c, 0.25 * s, z);
            assert!(nearest(&probes, &x) < 0.05, "{x}");
        }
        let flat = Shape::Cylinder {
            center: Vector::<2>::zeros(),
            axis: Vector::<2>::new(1.0, 1.0),
            radius: 0.1,
            height: 0.4,
        };
        let corner = Vector::<2>::new(0.3, 0.1) / 2.0f64.sqrt();
        assert!(nearest(&flat.surface_samples(0.05), &corner) < 1e-12);
    }

    #[test]
    fn probes_of_a_mesh_and_of_round_shapes() {
        let positions =
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Vector::from).to_vec();
        let facets = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let mesh = MeshShape::new(crate::mesh::SurfaceMesh { positions, facets });
        let shape = Shape::Mesh(Arc::new(mesh));
        let probes = shape.surface_samples(0.1);
        assert!(probes.iter().all(|p| shape.signed_distance(&p.position).abs() < 1e-12));
        assert!(nearest(&probes, &Vector::<3>::new(0.3, 0.3, 0.4)) < 0.1);
        let (a, b) = (Vector::<2>::new(0.1, 0.2), Vector::<2>::new(0.7, 0.2));
        let capsule = Shape::Capsule { a, b, radius: 0.2 }.surface_samples(0.25);
        assert_eq!(capsule.len(), 4);
        assert_eq!((capsule[3].position, capsule[3].radius), (b, 0.2));
    }
}
