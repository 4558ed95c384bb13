//! A simplex cut by two linear functions: liquid (`φ < 0`) beside a solid (`ψ < 0`).
//!
//! With `g = ∇φ`, `n = g/|g|` and barycentric coordinates `λ_c`, the derivatives with respect to the value of `φ` at corner `c` are
//!
//! - of the volume of `{φ < 0, ψ > 0}`: `−(1/|g|) ∫_P λ_c dA` over the free surface `P = {φ = 0, ψ > 0}`, and of its
//!   first moment: `−(1/|g|) ∫_P λ_c x dA`;
//! - of the area of `P`: `(1/|g|) Σ_e l_e λ_c(e) (m·n)/√(1 − (m·n)²)` over the edges `e` of `P`, where `m` is the outward
//!   normal of the face of the simplex, or of the solid's surface, in which the edge lies (2D: over its two ends);
//! - of the wetted area of `{ψ = 0, φ < 0}`: `−(1/|g|) Σ_e l_e λ_c(e)/√(1 − (m·n)²)` over the edge on the solid.
//!
//! Points are stored in barycentric coordinates, so that one code cuts triangles and tetrahedra.

use crate::{Matrix, Vector, rotation_planes};

/// Least sine of the angle between the free surface and a face of the simplex.
const MIN_FACE_SINE: f64 = 1e-3;
/// Least sine of the angle between the free surface and the solid's.
const MIN_CONTACT_SINE: f64 = 0.05;

/// A point by its barycentric coordinates (2D: the last one is 0).
type Point = [f64; 4];
/// Label of an edge that lies on the solid. The others have the number of the corner opposite their face.
const SOLID_EDGE: usize = 4;

/// A simplex: its `D + 1` corners, the gradients of its barycentric coordinates, and its volume.
#[derive(Clone, Debug)]
pub struct ClipSimplex<const D: usize> {
    corners: [Vector<D>; 4],
    gradients: [Vector<D>; 4],
    volume: f64,
}

/// What the two functions cut out of a simplex.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ClippedMeasures {
    /// Volume of the liquid.
    pub volume: f64,
    /// First moment of the liquid's volume.
    pub moment: [f64; 3],
    /// Area of the free surface.
    pub area: f64,
    /// Area of the solid under liquid.
    pub wetted_area: f64,
    /// Normal component of the surface-tension pull on the solid: the integral along the contact line (2D: the sum over
    /// its points) of the sine of its angle times the normal; and its moment about the origin (2D: in the last entry).
    pub normal_pull: [[f64; 3]; 2],
    /// Integral along the contact line of the unit vector along the solid into the liquid, and its moment.
    pub wetting_direction: [[f64; 3]; 2],
    /// Derivative of the volume with respect to the value of φ at each corner.
    pub volume_slope: [f64; 4],
    /// That of the volume's first moment.
    pub moment_slope: [[f64; 3]; 4],
    /// That of the free surface's area.
    pub area_slope: [f64; 4],
    /// That of the wetted area.
    pub wetted_area_slope: [f64; 4],
}

impl<const D: usize> ClipSimplex<D> {
    /// The simplex with these corners; entries beyond `D + 1` are ignored.
    pub fn new(corners: [Vector<D>; 4]) -> Self {
        let edges = Matrix::<D>::from_fn(|r, c| (corners[c + 1] - corners[0])[r]);
        // Rows of the inverse are the gradients of the barycentric coordinates 1 … D.
        let inverse = edges.try_inverse().unwrap_or_else(Matrix::zeros);
        let mut gradients = [Vector::zeros(); 4];
        for i in 0..D {
            gradients[i + 1] = inverse.row(i).transpose();
            gradients[0] -= gradients[i + 1];
        }
        let square = Matrix::<3>::from_fn(|r, c| match (r < D, c < D) {
            (true, true) => edges[(r, c)],
            _ => f64::from(u8::from(r == c)),
        });
        let volume = square.determinant().abs() / if D == 2 { 2.0 } else { 6.0 };
        Self { corners, gradients, volume }
    }

    /// Cuts the simplex; `phi` and `psi` are the values at its corners.
    pub fn cut(&self, phi: &[f64; 4], psi: &[f64; 4]) -> ClippedMeasures {
        let mut cut = ClippedMeasures::default();
        let open = psi.map(|v| -v);
        for part in negative_part::<D>(&Self::whole(), phi).iter().flatten() {
            let inside: [f64; 4] = std::array::from_fn(|k| interpolate(&part[k], &open));
            for piece in negative_part::<D>(part, &inside).iter().flatten() {
                self.add_volume(piece, &mut cut);
            }
        }
        self.free_surface(phi, psi, &mut cut);
        cut.wetted_area = self.measure(&clip_to_positive::<D>(zero_section::<D>(psi), &phi.map(|v| -v)));
        cut
    }

    fn whole() -> [Point; 4] {
        std::array::from_fn(|k| std::array::from_fn(|i| f64::from(u8::from(i == k))))
    }

    fn add_volume(&self, piece: &[Point; 4], cut: &mut ClippedMeasures) {
        // Barycentric coordinates add up to one, so the first of them is redundant.
        let share = Matrix::<3>::from_fn(|r, c| piece[r + 1][c + 1] - piece[0][c + 1]).determinant().abs();
        let volume = share * self.volume;
        cut.volume += volume;
        for p in &piece[..=D] {
            let x = self.position(p);
            (0..D).for_each(|a| cut.moment[a] += volume / (D as f64 + 1.0) * x[a]);
        }
    }

    fn position(&self, p: &Point) -> Vector<D> {
        (0..=D).fold(Vector::zeros(), |s: Vector<D>, i| s + self.corners[i] * p[i])
    }

    fn gradient(&self, values: &[f64; 4]) -> Vector<D> {
        (0..=D).fold(Vector::zeros(), |s: Vector<D>, i| s + self.gradients[i] * values[i])
    }

    fn free_surface(&self, phi: &[f64; 4], psi: &[f64; 4], cut: &mut ClippedMeasures) {
        let surface = clip_to_positive::<D>(zero_section::<D>(phi), psi);
        if surface.len() < D {
            return;
        }
        let gradient = self.gradient(phi);
        let steepness = gradient.norm().max(1e-12);
        let n = gradient / steepness;
        cut.area = self.measure(&surface);
        self.for_each_facet(&surface, |area, corners| {
            self.add_volume_derivatives(
                area / steepness,
                corners,
                &mut cut.volume_slope,
                &mut cut.moment_slope,
            )
        });
        for k in 0..surface.len() {
            let (p, label) = surface[k];
            let q = if D == 2 { p } else { surface[(k + 1) % surface.len()].0 };
            let length = if D == 2 { 1.0 } else { (self.position(&q) - self.position(&p)).norm() };
            let outward = if label == SOLID_EDGE { -self.gradient(psi) } else { -self.gradients[label] };
            let cosine = outward.try_normalize(0.0).map_or(0.0, |m| m.dot(&n));
            let least = if label == SOLID_EDGE { MIN_CONTACT_SINE } else { MIN_FACE_SINE };
            let sine = (1.0 - cosine * cosine).max(0.0).sqrt().max(least);
            if label == SOLID_EDGE {
                let inward = outward.try_normalize(0.0).unwrap_or(Vector::zeros());
                let middle = (self.position(&p) + self.position(&q)) * 0.5;
                add_force(&mut cut.normal_pull, &middle, &(inward * (-sine * length)));
                add_force(&mut cut.wetting_direction, &middle, &((inward * cosine - n) * (length / sine)));
            }
            for c in 0..=D {
                let weight = length * 0.5 * (p[c] + q[c]) / (steepness * sine);
                cut.area_slope[c] += weight * cosine;
                cut.wetted_area_slope[c] -= if label == SOLID_EDGE { weight } else { 0.0 };
            }
        }
    }

    /// Subtracts `∫ λ_c dA` and `∫ λ_c x dA` over a facet of the free surface.
    fn add_volume_derivatives(
        &self,
        area: f64,
        facet: &[Point],
        volume: &mut [f64; 4],
        moment: &mut [[f64; 3]; 4],
    ) {
        let n = facet.len() as f64;
        for c in 0..=D {
            let sum: f64 = facet.iter().map(|p| p[c]).sum();
            volume[c] -= area * sum / n;
            for p in facet {
                let (x, weight) = (self.position(p), area * (p[c] + sum) / (n * (n + 1.0)));
                (0..D).for_each(|a| moment[c][a] -= weight * x[a]);
            }
        }
    }

    /// Length or area of a segment or polygon.
    fn measure(&self, section: &[(Point, usize)]) -> f64 {
        let mut sum = 0.0;
        self.for_each_facet(section, |area, _| sum += area);
        sum
    }

    /// Calls `f(area, corners)` for the segment, or for each triangle of the polygon.
    fn for_each_facet(&self, section: &[(Point, usize)], mut f: impl FnMut(f64, &[Point])) {
        if D == 2 {
            if let [(p, _), (q, _)] = section {
                let length = (self.position(q) - self.position(p)).norm();
                f(length, &[*p, *q]);
            }
            return;
        }
        for k in 2..section.len() {
            let (p, q, r) = (section[0].0, section[k - 1].0, section[k].0);
            let (e, d) = (self.position(&q) - self.position(&p), self.position(&r) - self.position(&p));
            let square = e.norm_squared() * d.norm_squared() - e.dot(&d).powi(2);
            f(0.5 * square.max(0.0).sqrt(), &[p, q, r]);
        }
    }
}

/// Adds a force at a point, and its moment about the origin.
fn add_force<const D: usize>(sum: &mut [[f64; 3]; 2], at: &Vector<D>, force: &Vector<D>) {
    (0..D).for_each(|a| sum[0][a] += force[a]);
    for &(a, b, place) in rotation_planes::<D>() {
        sum[1][place] += at[a] * force[b] - at[b] * force[a];
    }
}

/// Value at a point of the linear function with these values at the corners.
fn interpolate(p: &Point, values: &[f64; 4]) -> f64 {
    (0..4).map(|i| if p[i] == 0.0 { 0.0 } else { p[i] * values[i] }).sum()
}

/// The point between two where the function with values `v` and `w` there, of different signs, is zero.
fn zero_between(p: &Point, q: &Point, v: f64, w: f64) -> Point {
    let t = v / (v - w);
    std::array::from_fn(|i| p[i] + t * (q[i] - p[i]))
}

/// The corners sorted with negative values first, and the number of negative values.
fn negative_first<const D: usize>(values: &[f64; 4]) -> ([usize; 4], usize) {
    let mut order = [0, 1, 2, 3];
    order[..=D].sort_by_key(|i| values[*i] >= 0.0);
    (order, values[..=D].iter().filter(|v| **v < 0.0).count())
}

/// The simplices that make up the part of a simplex where the function with these values at its corners is negative.
fn negative_part<const D: usize>(corners: &[Point; 4], values: &[f64; 4]) -> [Option<[Point; 4]>; 3] {
    let (o, count) = negative_first::<D>(values);
    let p = |i: usize| corners[o[i]];
    let x = |i: usize, j: usize| zero_between(&p(i), &p(j), values[o[i]], values[o[j]]);
    // In 2D the fourth corner stays the fourth unit vector, so that determinants are those of three corners.
    let flat = |a: Point, b: Point, c: Point| Some([a, b, c, [0.0, 0.0, 0.0, 1.0]]);
    match (D, count) {
        (_, 0) => [None; 3],
        (2, 3) | (3, 4) => [Some(*corners), None, None],
        (2, 1) => [flat(p(0), x(0, 1), x(0, 2)), None, None],
        (2, _) => [flat(p(0), p(1), x(0, 2)), flat(p(1), x(0, 2), x(1, 2)), None],
        (_, 1) => [Some([p(0), x(0, 1), x(0, 2), x(0, 3)]), None, None],
        (_, 2) => prism_tetrahedra([p(0), x(0, 2), x(0, 3)], [p(1), x(1, 2), x(1, 3)]),
        _ => prism_tetrahedra([p(0), p(1), p(2)], [x(0, 3), x(1, 3), x(2, 3)]),
    }
}

/// The tetrahedra of a prism with these ends.
fn prism_tetrahedra(a: [Point; 3], b: [Point; 3]) -> [Option<[Point; 4]>; 3] {
    [Some([a[0], a[1], a[2], b[0]]), Some([a[1], a[2], b[0], b[1]]), Some([a[2], b[0], b[1], b[2]])]
}

/// Zero set of the function with these values at the corners: the points around it, each with the label of the edge that
/// follows it (2D: in which it lies).
fn zero_section<const D: usize>(values: &[f64; 4]) -> Vec<(Point, usize)> {
    let (o, count) = negative_first::<D>(values);
    let whole = ClipSimplex::<D>::whole();
    let x = |i: usize, j: usize| zero_between(&whole[o[i]], &whole[o[j]], values[o[i]], values[o[j]]);
    match (D, count) {
        (_, 0) | (2, 3) | (3, 4) => Vec::new(),
        (2, 1) => vec![(x(0, 1), o[2]), (x(0, 2), o[1])],
        (2, _) => vec![(x(0, 2), o[1]), (x(1, 2), o[0])],
        (_, 1) => vec![(x(0, 1), o[3]), (x(0, 2), o[1]), (x(0, 3), o[2])],
        (_, 2) => vec![(x(0, 2), o[1]), (x(0, 3), o[2]), (x(1, 3), o[0]), (x(1, 2), o[3])],
        _ => vec![(x(0, 3), o[2]), (x(1, 3), o[0]), (x(2, 3), o[1])],
    }
}

/// The part of a segment or polygon where a linear function is positive; the new edge gets the label `SOLID_EDGE`.
fn clip_to_positive<const D: usize>(section: Vec<(Point, usize)>, values: &[f64; 4]) -> Vec<(Point, usize)> {
    let inside = |p: &Point| interpolate(p, values) > 0.0;
    let cross = |p: &Point, q: &Point| zero_between(p, q, interpolate(p, values), interpolate(q, values));
    if D == 2 {
        let [(p, i), (q, j)] = section[..] else { return Vec::new() };
        return match (inside(&p), inside(&q)) {
            (true, true) => vec![(p, i), (q, j)],
            (true, false) => vec![(p, i), (cross(&p, &q), SOLID_EDGE)],
            (false, true) => vec![(cross(&p, &q), SOLID_EDGE), (q, j)],
            (false, false) => Vec::new(),
        };
    }
    let mut out = Vec::with_capacity(section.len() + 1);
    for (k, (p, edge)) in section.iter().enumerate() {
        let q = &section[(k + 1) % section.len()].0;
        match (inside(p), inside(q)) {
            (true, true) => out.push((*p, *edge)),
            (true, false) => out.extend([(*p, *edge), (cross(p, q), SOLID_EDGE)]),
            (false, true) => out.push((cross(p, q), *edge)),
            (false, false) => {}
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A small generator of numbers in −1..1.
    struct Random(u64);
    impl Random {
        fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        }
    }

    fn simplex<const D: usize>() -> ClipSimplex<D> {
        let unit = |k: usize| {
            Vector::<D>::from_fn(|a, _| if a + 1 == k { 1.0 } else { 0.1 * (a as f64 - k as f64) })
        };
        ClipSimplex::new(std::array::from_fn(unit))
    }

    fn slopes_are_derivatives<const D: usize>() {
        let (s, mut random) = (simplex::<D>(), Random(3));
        let mut seen = 0;
        for _ in 0..400 {
            let phi: [f64; 4] = std::array::from_fn(|_| random.next());
            let psi: [f64; 4] = std::array::from_fn(|_| random.next());
            let (n, m) = (s.gradient(&phi).normalize(), s.gradient(&psi).normalize());
            let touches = phi.iter().chain(&psi).any(|v| v.abs() < 0.05) || n.dot(&m).abs() > 0.95;
            let flat = (0..=D).any(|c| n.dot(&s.gradients[c].normalize()).abs() > 0.999);
            if touches || flat {
                continue;
            }
            let cut = s.cut(&phi, &psi);
            seen += usize::from(cut.wetted_area > 0.0 && cut.area > 0.0);
            for c in 0..=D {
                let shifted = |by: f64| {
                    let mut phi = phi;
                    phi[c] += by;
                    s.cut(&phi, &psi)
                };
                let (up, down) = (shifted(1e-5), shifted(-1e-5));
                for (slope, up, down) in [
                    (cut.volume_slope[c], up.volume, down.volume),
                    (cut.moment_slope[c][0], up.moment[0], down.moment[0]),
                    (cut.moment_slope[c][D - 1], up.moment[D - 1], down.moment[D - 1]),
                    (cut.area_slope[c], up.area, down.area),
                    (cut.wetted_area_slope[c], up.wetted_area, down.wetted_area),
                ] {
                    let exact = (up - down) / 2e-5;
                    assert!((slope - exact).abs() < 1e-6 * (1.0 + exact.abs()), "{D}D: {slope} for {exact}");
                }
            }
        }
        assert!(seen > 20, "{D}D: only {seen} contact lines");
    }

    #[test]
    fn slopes_are_the_derivatives_of_what_is_cut() {
        slopes_are_derivatives::<2>();
        slopes_are_derivatives::<3>();
    }

    fn parts_make_the_whole<const D: usize>() {
        let (s, mut random) = (simplex::<D>(), Random(8));
        for _ in 0..200 {
            let phi: [f64; 4] = std::array::from_fn(|_| random.next());
            let psi: [f64; 4] = std::array::from_fn(|_| random.next());
            let minus = |v: &[f64; 4]| v.map(|v| -v);
            let quarters = [
                s.cut(&phi, &psi),
                s.cut(&minus(&phi), &psi),
                s.cut(&phi, &minus(&psi)),
                s.cut(&minus(&phi), &minus(&psi)),
            ];
            let volume: f64 = quarters.iter().map(|q| q.volume).sum();
            assert!((volume - s.volume).abs() < 1e-12, "{D}D: {volume}");
            for a in 0..D {
                let moment: f64 = quarters.iter().map(|q| q.moment[a]).sum();
                let center = s.corners[..=D].iter().map(|c| c[a]).sum::<f64>() / (D as f64 + 1.0);
                assert!((moment - center * s.volume).abs() < 1e-12, "{D}D: {moment}");
            }
            let (free, whole) = (quarters[0].area + quarters[2].area, s.cut(&phi, &[1.0; 4]).area);
            assert!((free - whole).abs() < 1e-12, "{D}D: {free} {whole}");
            let (wet, whole) =
                (quarters[0].wetted_area + quarters[1].wetted_area, s.cut(&[-1.0; 4], &psi).wetted_area);
            assert!((wet - whole).abs() < 1e-12, "{D}D: {wet} {whole}");
        }
    }

    #[test]
    fn the_parts_make_the_whole() {
        parts_make_the_whole::<2>();
        parts_make_the_whole::<3>();
    }
}
