//! The cosine of Young's angle of a solid near a point, and its hysteresis there.

use super::description::Solid;
use super::view::SolidView;
use meniscus_numerics::Vector;

/// Samples along each side of the square for the mean, if the pattern has an edge in it.
const SAMPLES_PER_SIDE: usize = 6;
/// Enlargement of patches over the square's width: a patch that ends at the solid's surface covers it.
const PATCH_ENLARGEMENT: f64 = 0.05;

impl<const D: usize> SolidView<'_, D> {
    /// Cosine of Young's angle on the surface next to a point (m): the mean over a square (2D: a segment) of `width` (m). Below −1
    /// nothing is wetted, above 1 everything.
    pub fn young_cosine_near(&self, x: &Vector<D>, width: f64) -> f64 {
        let Solid { pattern, young_cosine, .. } = self.solid;
        if pattern.is_empty() {
            return *young_cosine;
        }
        let (foot, normal) = self.reference_point_and_normal(x, 0.01 * width);
        let slack = PATCH_ENLARGEMENT * width;
        let cosine =
            |x: &Vector<D>| pattern.iter().fold(*young_cosine, |below, l| l.blend_over(below, x, slack));
        let reach = 0.5 * width * ((D - 1) as f64).sqrt() + slack;
        if pattern.iter().all(|layer| layer.distance_to_edge(&foot) > reach) {
            return cosine(&foot);
        }
        let sides = tangents(&normal).map(|side| side * (width / SAMPLES_PER_SIDE as f64));
        let count = SAMPLES_PER_SIDE.pow(D as u32 - 1);
        let place = |k: usize| {
            let step = |i: usize| i as f64 - 0.5 * (SAMPLES_PER_SIDE - 1) as f64;
            let second = if D == 3 { sides[1] * step(k / SAMPLES_PER_SIDE) } else { Vector::zeros() };
            foot + sides[0] * step(k % SAMPLES_PER_SIDE) + second
        };
        (0..count).map(|k| cosine(&place(k))).sum::<f64>() / count as f64
    }
}

impl<const D: usize> Solid<D> {
    /// Cosine of the angle to which a contact line of the present angle's `cosine` tends where Young's is `young_cosine`, and whether
    /// it rests. Between the receding and the advancing angle the line keeps its angle.
    pub fn hysteretic_cosine(&self, young_cosine: f64, cosine: f64) -> (f64, bool) {
        let Some(hysteresis) = &self.hysteresis else { return (young_cosine, false) };
        let [advancing, receding] = hysteresis.cosine_bounds(young_cosine);
        (cosine.clamp(advancing, receding), (advancing..=receding).contains(&cosine))
    }
}

/// Unit tangents of a surface with the normal `n` (2D: the second is zero); zero without a normal.
fn tangents<const D: usize>(n: &Vector<D>) -> [Vector<D>; 2] {
    let least = (0..D).fold(0, |least, a| if n[a].abs() < n[least].abs() { a } else { least });
    let axis = Vector::from_fn(|a, _| if a == least && *n != Vector::<D>::zeros() { 1.0 } else { 0.0 });
    let first = (axis - n * n[least]).try_normalize(0.0).unwrap_or(Vector::zeros());
    let cross = |a: usize, b: usize| n[a] * first[b] - n[b] * first[a];
    let second = Vector::from_fn(|a, _| if D == 3 { cross((a + 1) % D, (a + 2) % D) } else { 0.0 });
    [first, second]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solid::surface::SolidSurface;
    use crate::solid::wettability::CosineImage;
    use crate::solid::wettability::{Hysteresis, WettabilityLayer};
    use crate::solid::{Kinematics, RigidKinematics, SolidKind, SolidState};
    use meniscus_numerics::Matrix;
    use meniscus_numerics::mesh::SurfaceMesh;
    use meniscus_numerics::shape::Shape;
    use std::sync::Arc;

    /// The cosine near a point of a rigid solid.
    fn cosine_near<const D: usize>(
        solid: &Solid<D>,
        state: &SolidState<D>,
        x: &Vector<D>,
        width: f64,
    ) -> f64 {
        let surface = &SolidSurface::new(SurfaceMesh::default(), Vec::new());
        SolidView { solid, state, surface }.young_cosine_near(x, width)
    }

    /// A plate 2 by 2 wide with its top at 0 and its middle at the origin.
    fn plate<const D: usize>(pattern: Vec<WettabilityLayer<D>>) -> Solid<D> {
        let last = |a: usize| a + 1 == D;
        let shape = Shape::Box {
            center: Vector::from_fn(|a, _| if last(a) { -0.2 } else { 0.0 }),
            half_size: Vector::from_fn(|a, _| if last(a) { 0.2 } else { 1.0 }),
            rotation: Matrix::identity(),
        };
        let mut solid = Solid::new(shape, SolidKind::Rigid, 1.0);
        (solid.young_cosine, solid.pattern) = (-0.5, pattern);
        solid
    }

    fn block<const D: usize>(low: f64, high: f64) -> Shape<D> {
        let middle = |a: usize| if a == 0 { 0.5 * (low + high) } else { 0.0 };
        let half = |a: usize| if a == 0 { 0.5 * (high - low) } else { 5.0 };
        Shape::Box {
            center: Vector::from_fn(|a, _| middle(a)),
            half_size: Vector::from_fn(|a, _| half(a)),
            rotation: Matrix::identity(),
        }
    }

    fn patches_and_their_edges<const D: usize>() {
        let patch = |low, high, cosine| WettabilityLayer::Patch { shape: block::<D>(low, high), cosine };
        let solid = plate(vec![patch(-0.5, 0.5, 0.5), patch(0.3, 0.7, 0.9)]);
        let now = solid.initial_state();
        let at = |x: f64, width: f64| {
            let place = Vector::from_fn(|a, _| if a == 0 { x } else { 0.03 });
            cosine_near(&solid, &now, &place, width)
        };
        for (x, cosine) in [(-0.9, -0.5), (0.0, 0.5), (0.4, 0.9), (0.65, 0.9), (0.8, -0.5)] {
            assert!((at(x, 0.1) - cosine).abs() < 1e-12, "{D}D at {x}: {}", at(x, 0.1));
        }
        // Over an edge the mean is linear from one side to the other.
        for part in [-0.4, -0.2, 0.0, 0.2, 0.4] {
            let found = at(-0.5 + part * 0.1, 0.1);
            assert!((found - part).abs() < 0.15, "{D}D, {part}: {found}");
        }
    }

    #[test]
    fn patches_lie_where_they_are_told() {
        patches_and_their_edges::<2>();
        patches_and_their_edges::<3>();
    }

    #[test]
    fn a_patch_that_ends_at_the_surface_covers_it() {
        let shape = Shape::Box {
            center: Vector::<3>::new(0.0, 0.0, -0.1),
            half_size: Vector::<3>::new(0.5, 0.5, 0.1),
            rotation: Matrix::identity(),
        };
        let solid = plate(vec![WettabilityLayer::Patch { shape, cosine: 0.8 }]);
        let cosine =
            |z: f64| cosine_near(&solid, &solid.initial_state(), &Vector::<3>::new(0.1, 0.2, z), 0.1);
        assert!([-0.04, 0.0, 0.05].map(cosine).iter().all(|c| (c - 0.8).abs() < 1e-12));
    }

    #[test]
    fn patterns_go_with_their_solids() {
        let solid = plate::<2>(vec![WettabilityLayer::Patch { shape: block(-0.5, 0.5), cosine: 0.5 }]);
        let (s, c) = 0.7f64.sin_cos();
        let start = solid.initial_state().as_rigid();
        let center = start.center + Vector::<2>::new(3.0, 1.0);
        let rigid = RigidKinematics { center, rotation: Matrix::<2>::new(c, -s, s, c), ..start };
        let now = SolidState::new(Kinematics::Rigid(rigid));
        let moved = |x: f64| solid.to_current(&rigid, &Vector::<2>::new(x, 0.02));
        for (x, cosine) in [(0.4, 0.5), (-0.4, 0.5), (0.6, -0.5), (-0.6, -0.5)] {
            assert!((cosine_near(&solid, &now, &moved(x), 0.05) - cosine).abs() < 1e-12, "at {x}");
        }
    }

    #[test]
    fn gradients_and_pictures() {
        let gradient = WettabilityLayer::Gradient {
            from: (Vector::<3>::new(-0.5, 0.0, 0.0), 0.0),
            to: (Vector::<3>::new(0.5, 0.0, 0.0), 0.8),
        };
        let pixels = vec![[1.0, 1.0], [0.0, 1.0], [0.2, 1.0], [0.7, 0.0]];
        let picture = CosineImage { bounds: [[0.0, 0.4], [0.0, 0.4]], size: [2, 2], pixels };
        let solid = plate(vec![gradient, WettabilityLayer::Image(Arc::new(picture))]);
        let at = |x, y| cosine_near(&solid, &solid.initial_state(), &Vector::<3>::new(x, y, 0.0), 0.01);
        assert!((at(-0.25, -0.5) - 0.2).abs() < 1e-9 && (at(0.9, -0.5) - 0.8).abs() < 1e-12);
        // The lower row; half-way between its pixels; the transparent pixel shows the layer below.
        assert!((at(0.05, 0.05) - 1.0).abs() < 1e-9, "{}", at(0.05, 0.05));
        assert!((at(0.2, 0.05) - 0.5).abs() < 1e-9, "{}", at(0.2, 0.05));
        assert!((at(0.35, 0.35) - 0.68).abs() < 1e-9, "{}", at(0.35, 0.35));
    }

    #[test]
    fn lines_rest_around_youngs_angle() {
        let mut solid = plate::<2>(Vec::new());
        let cosine = |degrees: f64| degrees.to_radians().cos();
        solid.hysteresis = Some(Hysteresis::Around([0.2, 0.1]));
        let bounds = Hysteresis::Around([10f64.to_radians(), 20f64.to_radians()]).cosine_bounds(cosine(60.0));
        assert!((bounds[0] - cosine(70.0)).abs() < 1e-12 && (bounds[1] - cosine(40.0)).abs() < 1e-12);
        assert_eq!(solid.hysteretic_cosine(cosine(60.0), cosine(65.0)), (cosine(65.0), true));
        assert!(!solid.hysteretic_cosine(cosine(30.0), cosine(65.0)).1);
    }
}
