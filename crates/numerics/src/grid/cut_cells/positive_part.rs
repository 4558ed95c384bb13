//! The part of a unit edge or unit square on which a piecewise linear function is positive: its size and its centroid.
//!
//! The function is given at the corners. On the square it is linear on each of the four triangles around the middle, where it
//! has the corners' mean; the part is exact for that function.

/// Part of the unit edge where a linear function is positive: its length and centroid.
pub(super) fn positive_edge_part(v0: f64, v1: f64) -> (f64, [f64; 2]) {
    match (v0 > 0.0, v1 > 0.0) {
        (true, true) => (1.0, [0.5; 2]),
        (false, false) => (0.0, [0.5; 2]),
        (true, false) => {
            let t = v0 / (v0 - v1);
            (t, [0.5 * t, 0.5])
        }
        (false, true) => {
            let t = v1 / (v1 - v0);
            (t, [1.0 - 0.5 * t, 0.5])
        }
    }
}

/// Part of the unit square where a function that is linear on the triangles around the middle is positive: its area and centroid.
pub(super) fn positive_square_part(v: [[f64; 2]; 2]) -> (f64, [f64; 2]) {
    let ring = [([0.0, 0.0], v[0][0]), ([1.0, 0.0], v[1][0]), ([1.0, 1.0], v[1][1]), ([0.0, 1.0], v[0][1])];
    if ring.iter().all(|c| c.1 > 0.0) {
        return (1.0, [0.5; 2]);
    }
    if ring.iter().all(|c| c.1 <= 0.0) {
        return (0.0, [0.5; 2]);
    }
    let middle = ([0.5, 0.5], 0.25 * (v[0][0] + v[0][1] + v[1][0] + v[1][1]));
    let (mut area, mut first) = (0.0, [0.0; 2]);
    for k in 0..4 {
        let (part, center) = positive_triangle_part([middle, ring[k], ring[(k + 1) % 4]]);
        area += 0.25 * part;
        (0..2).for_each(|a| first[a] += 0.25 * part * center[a]);
    }
    (area, first.map(|f| if area > 0.0 { f / area } else { 0.5 }))
}

/// Part of a triangle where the linear function given at its corners is positive: its share of the area, and centroid.
fn positive_triangle_part(corners: [([f64; 2], f64); 3]) -> (f64, [f64; 2]) {
    let mean = |p: [[f64; 2]; 3]| [0, 1].map(|a| (p[0][a] + p[1][a] + p[2][a]) / 3.0);
    let whole = mean(corners.map(|c| c.0));
    let positive = corners.iter().filter(|c| c.1 > 0.0).count();
    if positive == 3 || positive == 0 {
        return (if positive == 3 { 1.0 } else { 0.0 }, whole);
    }
    // The only corner with its sign, and the triangle that the zero line cuts off at it.
    let lone = (0..3).find(|k| (corners[*k].1 > 0.0) == (positive == 1)).unwrap_or(0);
    let (p, v) = corners[lone];
    let cut = |k: usize| {
        let (q, w) = corners[(lone + k) % 3];
        let t = v / (v - w);
        (t, [0, 1].map(|a| p[a] + t * (q[a] - p[a])))
    };
    let ((t1, p1), (t2, p2)) = (cut(1), cut(2));
    let (share, center) = (t1 * t2, mean([p, p1, p2]));
    if positive == 1 {
        return (share, center);
    }
    let rest = 1.0 - share;
    (rest, [0, 1].map(|a| if rest > 0.0 { (whole[a] - share * center[a]) / rest } else { whole[a] }))
}
