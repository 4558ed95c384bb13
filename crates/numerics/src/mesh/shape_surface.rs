//! Surface mesh of a solid, finer than the grid, from its signed distance.

use super::isosurface::LIQUID_AIR;
use super::remesh::Remesher;
use super::{Isosurface, SurfaceMesh};
use crate::Vector;
use crate::grid::{CellField, Grid, Tiles};
use crate::par;

/// Newton iterations of the projection of a vertex onto the surface.
const PROJECTION_STEPS: usize = 3;

/// Surface mesh of a solid.
#[derive(Clone, Debug, PartialEq)]
pub struct ShapeSurface<const D: usize> {
    /// Vertices (m) and facets, outward; closed.
    pub mesh: SurfaceMesh<D>,
    /// Number of facets on the solid's surface; they come first. The others close the mesh at the sides of the box that
    /// truncates the solid.
    pub solid_facet_count: usize,
}

impl<const D: usize> ShapeSurface<D> {
    /// The zero set of a signed distance (m, negative inside) within a box, with edges about `edge` (m) long: surface nets,
    /// remeshed and projected onto the zero set.
    pub fn new(
        distance: &(dyn Fn(&Vector<D>) -> f64 + Sync),
        low: Vector<D>,
        high: Vector<D>,
        edge: f64,
    ) -> Self {
        let cells: [usize; D] = std::array::from_fn(|a| ((high[a] - low[a]) / edge).ceil().max(1.0) as usize);
        // Cells are slightly compressed so that the lattice ends at the box.
        let scale = Vector::from_fn(|a, _| (high[a] - low[a]) / (cells[a] as f64 * edge));
        let grid = Grid::<D>::new(cells, edge);
        let lattice = grid.lattice();
        let mut field = CellField::new(grid, 0.0);
        par::for_each_mut(&mut field.data, 64, |i, value| {
            *value = distance(&(low + grid.center(lattice.coordinates(i)).component_mul(&scale)));
        });
        let inside = Tiles::all(grid).negative_runs(&field.data);
        let Isosurface { mut mesh, facet_kind: tags, .. } = crate::mesh::extract_isosurface(&field, &inside);
        mesh.positions.iter_mut().for_each(|x| *x = low + x.component_mul(&scale));
        let mut fixed = vec![false; mesh.positions.len()];
        for (facet, _) in mesh.facets.iter().zip(&tags).filter(|(_, tag)| **tag != LIQUID_AIR) {
            facet.iter().for_each(|v| fixed[*v as usize] = true);
        }
        let project = |x: &Vector<D>| project(distance, x, edge);
        let mut remesh = Remesher { mesh, tags, fixed, project: &project };
        remesh.project_all();
        remesh.remesh();
        let Remesher { mut mesh, tags, .. } = remesh;
        let mut order: Vec<usize> = (0..tags.len()).collect();
        order.sort_by_key(|f| tags[*f] != LIQUID_AIR);
        mesh.facets = order.into_iter().map(|f| mesh.facets[f]).collect();
        Self { solid_facet_count: tags.iter().filter(|t| **t == LIQUID_AIR).count(), mesh }
    }

    /// The facets on the solid's surface.
    pub fn solid_facets(&self) -> &[[u32; D]] {
        &self.mesh.facets[..self.solid_facet_count]
    }
}

impl<const D: usize> Remesher<'_, D> {
    /// Projects every vertex that is not fixed onto the surface.
    fn project_all(&mut self) {
        let (project, fixed) = (self.project, &self.fixed);
        let moving = self.mesh.positions.iter_mut().zip(fixed).filter(|(_, f)| !**f);
        moving.for_each(|(x, _)| *x = project(x));
    }
}

/// Projection of a point onto the zero set of a distance; points that would move by half an edge or more stay.
fn project<const D: usize>(distance: &dyn Fn(&Vector<D>) -> f64, x: &Vector<D>, edge: f64) -> Vector<D> {
    let step = 1e-3 * edge;
    let mut y = *x;
    for _ in 0..PROJECTION_STEPS {
        let value = distance(&y);
        let slope = Vector::<D>::from_fn(|a, _| {
            let by = Vector::<D>::from_fn(|b, _| if a == b { step } else { 0.0 });
            (distance(&(y + by)) - distance(&(y - by))) / (2.0 * step)
        });
        let size = slope.norm_squared();
        if size > 0.01 {
            y -= slope * (value / size);
        }
    }
    if (y - x).norm() < 0.5 * edge { y } else { *x }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Matrix;
    use crate::shape::Shape;

    /// Shortest edge, longest edge and smallest facet height, over the mean edge.
    fn quality<const D: usize>(surface: &ShapeSurface<D>) -> [f64; 3] {
        let mesh = &surface.mesh;
        let mut edges = Vec::new();
        for f in surface.solid_facets() {
            let at = |k: usize| mesh.positions[f[k % D] as usize];
            (0..D).for_each(|k| edges.push((at(k + 1) - at(k)).norm()));
        }
        let mean = edges.iter().sum::<f64>() / edges.len() as f64;
        let longest = edges.iter().fold(0.0f64, |m, e| m.max(*e));
        let shortest = edges.iter().fold(f64::INFINITY, |m, e| m.min(*e));
        let height = |f: usize| mesh.area_vector(f).norm() / longest.powi(D as i32 - 2);
        let flattest = (0..surface.solid_facet_count).map(height).fold(f64::INFINITY, f64::min);
        [shortest / mean, longest / mean, flattest / mean]
    }

    fn check<const D: usize>(name: &str, shape: &Shape<D>, edge: f64) -> ShapeSurface<D> {
        let (low, high) = shape.bounds();
        let margin = Vector::repeat(2.0 * edge);
        let (low, high) = ((low - margin).sup(&Vector::zeros()), (high + margin).inf(&Vector::repeat(1.0)));
        let surface = ShapeSurface::new(&|x| shape.signed_distance(x), low, high, edge);
        let found = quality(&surface);
        println!("{D}D {name}: {} own facets, {found:?}", surface.solid_facet_count);
        assert!(surface.mesh.is_watertight(), "{D}D {name} is open");
        surface
    }

    fn surfaces<const D: usize>() {
        let edge = 0.021;
        let middle = Vector::from_fn(|a, _| 0.49 + 0.017 * a as f64);
        let ball = check::<D>("ball", &Shape::Ball { center: middle, radius: 0.21 }, edge);
        let off = |x: &Vector<D>| ((x - middle).norm() - 0.21).abs();
        assert!(ball.mesh.positions.iter().all(|x| off(x) < 1e-6), "vertices off the ball");
        let found = quality(&ball);
        assert!(found[0] > 0.4 && found[1] < 1.6 && found[2] > 0.1, "{found:?}");

        let normal = Vector::from_fn(|a, _| if a + 1 == D { 1.0 } else { 0.3 });
        let plane = Shape::HalfSpace { point: Vector::repeat(0.41), normal };
        let plane_surface = check::<D>("plane", &plane, edge);
        assert!(plane_surface.solid_facet_count < plane_surface.mesh.facets.len());
        for f in plane_surface.solid_facets().iter().flatten() {
            let x = plane_surface.mesh.positions[*f as usize];
            // On the sides of the box vertices are fixed where the surface nets put them.
            let inner = x.iter().all(|c| (1e-9..1.0 - 1e-9).contains(c));
            assert!(plane.signed_distance(&x).abs() < if inner { 1e-9 } else { 0.7 * edge }, "{D}D {x}");
        }

        let mut rotation = Matrix::<D>::identity();
        let (s, c) = 0.4f64.sin_cos();
        (rotation[(0, 0)], rotation[(0, 1)], rotation[(1, 0)], rotation[(1, 1)]) = (c, -s, s, c);
        let half_size = Vector::from_fn(|a, _| if a + 1 == D { 0.08 } else { 0.25 });
        let plate = Shape::Box { center: middle, half_size, rotation };
        let volume = plate.volume().unwrap();
        let plate = check::<D>("plate", &plate, edge);
        assert!((plate.mesh.volume() / volume - 1.0).abs() < 0.01, "{} {volume}", plate.mesh.volume());
    }

    #[test]
    fn surfaces_of_shapes_are_closed_and_even() {
        surfaces::<2>();
        surfaces::<3>();
    }
}
