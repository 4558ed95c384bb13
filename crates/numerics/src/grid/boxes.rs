//! Boxes of lattice points: lower corner, and one past the upper corner.

use super::{Lattice, Segment};

/// The faces normal to `axis` of the cells of a box.
pub(super) fn face_box<const D: usize>([low, mut high]: [[usize; D]; 2], axis: usize) -> [[usize; D]; 2] {
    high[axis] += 1;
    [low, high]
}

/// The lattice points of a box, the first axis varying fastest.
pub fn lattice_points<const D: usize>(cells: [[usize; D]; 2]) -> impl Iterator<Item = [usize; D]> {
    let (count, place) = point_numbering(cells);
    (0..count).map(place)
}

/// The number of lattice points of a box, and the map from number to point.
fn point_numbering<const D: usize>([low, high]: [[usize; D]; 2]) -> (usize, impl Fn(usize) -> [usize; D]) {
    let inner = Lattice::new(std::array::from_fn::<_, D, _>(|a| high[a] - low[a]));
    let place = move |i| {
        let at = inner.coordinates(i);
        std::array::from_fn(|a| low[a] + at[a])
    };
    (inner.len(), place)
}

/// The rows of a box as segments of a lattice, in memory order.
pub fn box_rows<const D: usize>(lattice: &Lattice<D>, [low, high]: [[usize; D]; 2]) -> Vec<Segment> {
    let mut ends = high;
    ends[0] = low[0] + usize::from(high[0] > low[0]);
    let row = |start| Segment { row: lattice.index(start) / lattice.extent[0], start: low[0], end: high[0] };
    lattice_points([low, ends]).map(row).collect()
}

/// The lattice points of a segment.
pub fn segment_points<const D: usize>(
    lattice: &Lattice<D>,
    segment: &Segment,
) -> impl Iterator<Item = [usize; D]> + use<D> {
    let first = lattice.coordinates(segment.row * lattice.extent[0]);
    (segment.start..segment.end).map(move |i| std::array::from_fn(|a| if a == 0 { i } else { first[a] }))
}

/// Sets all points of a box to a value.
pub(super) fn fill_box<const D: usize>(
    values: &mut [f64],
    lattice: &Lattice<D>,
    [low, high]: [[usize; D]; 2],
    value: f64,
) {
    let mut ends = high;
    ends[0] = low[0] + usize::from(high[0] > low[0]);
    for start in lattice_points([low, ends]) {
        let first = lattice.index(start);
        values[first..first + high[0] - low[0]].fill(value);
    }
}
