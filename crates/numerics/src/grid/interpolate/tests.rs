use super::*;
use crate::grid::FaceField;
use crate::lanes::{Compiled, Instructions, LANES, LaneWork, Lanes, VectorLanes, run_with_widest};

fn cubic_is_exact<const D: usize>() {
    let grid = Grid::<D>::new([8; D], 0.25);
    let f = |x: &Vector<D>| 1.0 + x[0] - 2.0 * x[1] * x[1] + x[0] * x[1] * x[D - 1] + x[D - 1].powi(3);
    let lattice = grid.lattice();
    let data: Vec<f64> = (0..lattice.len()).map(|i| f(&grid.center(lattice.coordinates(i)))).collect();
    let sampler = Sampler::cells(&grid, &data, [[BoundaryExtension::Even; 2]; D]);
    let x = Vector::from_fn(|a, _| 0.9 + 0.13 * a as f64);
    let (value, gradient) = sampler.cubic_with_gradient(&x);
    assert!((value - f(&x)).abs() < 1e-12 && (sampler.cubic(&x) - value).abs() < 1e-12);
    for a in 0..D {
        let mut up = x;
        let mut down = x;
        up[a] += 1e-5;
        down[a] -= 1e-5;
        assert!((gradient[a] - (f(&up) - f(&down)) / 2e-5).abs() < 1e-8);
    }
}

#[test]
fn cubic_reproduces_cubics() {
    cubic_is_exact::<2>();
    cubic_is_exact::<3>();
}

#[test]
fn a_smooth_distance_is_sampled_by_quintics() {
    let grid = Grid::<3>::new([8; 3], 1.0);
    let f = |x: &Vector<3>| x[0] - 0.5 * x[1] + 1e-5 * (x[2].powi(5) - x[0].powi(4) * x[1]);
    let lattice = grid.lattice();
    let data: Vec<f64> = (0..lattice.len()).map(|i| f(&grid.center(lattice.coordinates(i)))).collect();
    let sampler = Sampler::cells(&grid, &data, [[BoundaryExtension::Even; 2]; 3]);
    let x = Vector::from([3.7, 4.1, 3.95]);
    let (value, gradient) = sampler.distance_with_gradient(&x);
    assert!((value - f(&x)).abs() < 1e-12);
    let exact = [1.0 - 4e-5 * 3.7f64.powi(3) * 4.1, -0.5 - 1e-5 * 3.7f64.powi(4), 5e-5 * 3.95f64.powi(4)];
    (0..3).for_each(|a| assert!((gradient[a] - exact[a]).abs() < 1e-12));
}

#[test]
fn edges_mirror() {
    let grid = Grid::<2>::new([4, 4], 1.0);
    let data: Vec<f64> = (0..16).map(|i| (i % 4) as f64).collect();
    let sampler = Sampler::cells(&grid, &data, [[BoundaryExtension::Even; 2]; 2]);
    assert_eq!(sampler.value([-1, 2]), 0.0);
    assert_eq!(sampler.value([-2, 2]), 1.0);
    assert_eq!(sampler.value([5, 2]), 2.0);
    let data: Vec<f64> = (0..20).map(|i| (i % 5) as f64).collect();
    let faces = Sampler::faces(&grid, 0, &data, [[BoundaryExtension::Odd; 2], [BoundaryExtension::Even; 2]]);
    assert_eq!(faces.value([-1, 0]), -1.0);
    assert_eq!(faces.value([5, 0]), -3.0);
}

fn the_side_decides_the_sign<const D: usize>() {
    let grid = Grid::<D>::new([8; D], 1.0);
    let lattice = grid.lattice();
    let data: Vec<f64> = (0..lattice.len()).map(|i| lattice.coordinates(i)[0] as f64 - 3.2).collect();
    let sampler = Sampler::cells(&grid, &data, [[BoundaryExtension::Even; 2]; D]);
    let x = Vector::from_fn(|a, _| if a == 0 { 3.55 } else { 4.0 });
    let columns = |some: u64| (0..4u32.pow(D as u32 - 1)).map(|row| some << (4 * row)).sum();
    // The stencil begins in column 2; the surface lies between 3 and 4.
    for (side, sign) in [(0b1100u64, 1.0), (0b0011, -1.0)] {
        assert!(sampler.distance_on_side(&x, |_| columns(side)) * sign > 0.0);
    }
    let whole = sampler.distance_with_gradient(&x).0;
    assert_eq!(sampler.distance_on_side(&x, |_| columns(0b1111)), whole);
    assert_eq!(sampler.distance_on_side(&x, |_| 0), whole);
}

#[test]
fn beyond_a_thin_solid_lies_no_surface_of_this_side() {
    the_side_decides_the_sign::<2>();
    the_side_decides_the_sign::<3>();
}

/// The short formulas at face centres and cell centres give the values of the general interpolation, also next to the sides.
fn places_are_those_of_the_general_forms<const D: usize>() {
    let grid = Grid::<D>::new([9; D], 0.5);
    let lattice = grid.lattice();
    let plane = |x: &Vector<D>| 0.8 * (x[0] - 2.1) + 0.6 * (x[D - 1] - 1.9) + 2e-3 * x[0] * x[1] * x[D - 1];
    let data: Vec<f64> = (0..lattice.len()).map(|i| plane(&grid.center(lattice.coordinates(i)))).collect();
    let distance = Sampler::cells(&grid, &data, [[BoundaryExtension::Even; 2]; D]);
    for axis in 0..D {
        let faces = grid.face_lattice(axis);
        for at in (0..faces.len()).map(|f| faces.coordinates(f)) {
            let value = distance.distance(&grid.face_center(axis, at));
            assert!((distance.distance_at_face(&grid, axis, at) - value).abs() < 1e-12, "{D}D {at:?}");
            let cell = |along: isize, b: usize, by: isize| {
                let mut cell = at.map(|i| i as isize);
                cell[axis] += along;
                cell[b] += by;
                distance.value(cell)
            };
            let expected: [f64; D] = std::array::from_fn(|b| match b == axis {
                true => cell(0, b, 0) - cell(-1, b, 0),
                false => 0.25 * (cell(0, b, 1) - cell(0, b, -1) + (cell(-1, b, 1) - cell(-1, b, -1))),
            });
            let found = distance.face_differences(axis, at);
            assert!((0..D).all(|b| (found[b] - expected[b]).abs() < 1e-13), "{D}D {at:?}");
        }
    }
    let mut velocity = FaceField::zeros(grid);
    for (a, values) in velocity.axes.iter_mut().enumerate() {
        values.iter_mut().enumerate().for_each(|(f, u)| *u = (0.02 * f as f64 + a as f64).sin());
    }
    let normal = |a: usize| {
        std::array::from_fn(|b| [[BoundaryExtension::Even, BoundaryExtension::Odd][usize::from(a == b)]; 2])
    };
    let flow = VelocitySampler::new(&grid, &velocity, normal);
    for at in (0..lattice.len()).map(|i| lattice.coordinates(i)) {
        let found = flow.cubic_at_cell(at);
        for a in 0..D {
            let unlimited = flow.component(a).cubic_with_gradient(&grid.center(at)).0;
            assert!((found[a] - unlimited).abs() < 1e-12, "{D}D {at:?}");
        }
    }
}

#[test]
fn values_at_faces_and_centres_are_those_of_the_general_interpolation() {
    places_are_those_of_the_general_forms::<2>();
    places_are_those_of_the_general_forms::<3>();
}

/// Every lane has the bits of the interpolation at its point alone, wherever the points lie.
fn lanes_are_single_points<I: Instructions, const D: usize>(with: I) {
    let grid = Grid::<D>::new(std::array::from_fn(|a| if a == 0 { 19 } else { 9 }), 0.5);
    let lattice = grid.lattice();
    let wave = |x: &Vector<D>| (1.3 * x[0] - 0.9 * x[D - 1]).sin() + 0.2 * x[1];
    let field: Vec<f64> = (0..lattice.len()).map(|i| wave(&grid.center(lattice.coordinates(i)))).collect();
    // A ridge of a distance, and smooth values elsewhere.
    let ridge = |x: &Vector<D>| 0.4 - (x[0] - 4.1).abs() + 0.02 * x[D - 1];
    let ridge: Vec<f64> = (0..lattice.len()).map(|i| ridge(&grid.center(lattice.coordinates(i)))).collect();
    let mut velocity = FaceField::zeros(grid);
    for (a, values) in velocity.axes.iter_mut().enumerate() {
        values.iter_mut().enumerate().for_each(|(f, u)| *u = (0.37 * f as f64 + a as f64).sin());
    }
    let normal = |a: usize| {
        std::array::from_fn(|b| [[BoundaryExtension::Even, BoundaryExtension::Odd][usize::from(a == b)]; 2])
    };
    let flow = VelocitySampler::new(&grid, &velocity, normal);
    let [field, ridge] =
        [&field, &ridge].map(|data| Sampler::cells(&grid, data, [[BoundaryExtension::Even; 2]; D]));
    let same = |lanes: &Lanes<I>, l: usize, one: f64| lanes.to_array()[l].to_bits() == one.to_bits();
    for start in (0..lattice.len()).map(|i| lattice.coordinates(i)) {
        let cells = LANES.min(grid.cells[0] - start[0]);
        let waves = VectorLanes::from_fn(with, |l| {
            Vector::from_fn(|a, _| ((start[a] + 3 * a) as f64 + 0.21 * l as f64).sin())
        });
        let x = grid.centers(with, start) + waves * 0.6;
        let fields = [field.linear_lanes(&x), field.cubic_lanes(&x)];
        let distances = [field.distance_lanes(&x), ridge.distance_lanes(&x)];
        let flows = [flow.linear_lanes(&x), flow.cubic_lanes(&x)];
        let centers = [flow.at_cells(with, start), flow.cubic_at_cells(with, start)];
        for l in 0..cells {
            let (mut at, x) = (start, x.to_array()[l]);
            at[0] += l;
            assert_eq!(grid.centers(with, start).to_array()[l], grid.center(at));
            assert!(
                same(&fields[0], l, field.linear(&x)) && same(&fields[1], l, field.cubic(&x)),
                "{D}D {at:?}"
            );
            assert!(same(&distances[0], l, field.distance(&x)), "{D}D {at:?}");
            assert!(same(&distances[1], l, ridge.distance(&x)), "{D}D {at:?}");
            assert_eq!([flows[0].to_array()[l], flows[1].to_array()[l]], [flow.linear(&x), flow.cubic(&x)]);
            assert_eq!(
                [centers[0].to_array()[l], centers[1].to_array()[l]],
                [flow.at_cell(at), flow.cubic_at_cell(at)]
            );
            for axis in 0..D {
                assert_eq!(flow.at_faces(with, axis, start).to_array()[l], flow.at_face(axis, at));
                assert_eq!(grid.face_centers(with, axis, start).to_array()[l], grid.face_center(axis, at));
            }
        }
    }
}

/// [`lanes_are_single_points`], for each set of instructions.
struct SinglePoints<const D: usize>;

impl<const D: usize> LaneWork for SinglePoints<D> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self, with: I) {
        lanes_are_single_points::<I, D>(with);
    }
}

/// A number that is not finite must reach the checks of a step: no lane may replace it by a bound.
#[test]
fn what_is_not_a_number_stays_so_in_its_lane() {
    let grid = Grid::<2>::new([12; 2], 1.0);
    let mut data = vec![1.0; grid.lattice().len()];
    let x = |l: usize| Vector::from([if l == 3 { f64::NAN } else { 2.1 + l as f64 }, 5.2]);
    let edges = [[BoundaryExtension::Even; 2]; 2];
    let sampler = Sampler::cells(&grid, &data, edges);
    let x = VectorLanes::from_fn(Compiled, x);
    for values in [sampler.linear_lanes(&x), sampler.cubic_lanes(&x), sampler.distance_lanes(&x)] {
        let found = values.to_array();
        assert!((0..LANES).all(|l| found[l].is_nan() == (l == 3)), "{found:?}");
    }
    data[grid.lattice().index([5, 5])] = f64::NAN;
    let sampler = Sampler::cells(&grid, &data, edges);
    let x = VectorLanes::from_fn(Compiled, |l| Vector::from([5.4 + 0.01 * l as f64, 5.2]));
    assert!(sampler.cubic_lanes(&x).to_array().iter().all(|v| v.is_nan()));
}

#[test]
fn every_lane_has_the_bits_of_its_point_alone() {
    SinglePoints::<2>.run(Compiled);
    SinglePoints::<3>.run(Compiled);
    run_with_widest(SinglePoints::<2>);
    run_with_widest(SinglePoints::<3>);
}
