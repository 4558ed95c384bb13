use super::tests::{System, limits, slab};
use super::{CoupledBodies, MultigridBackend, PressureBackend, PressureSystem, SparseColumn};
use crate::grid::CellField;
use crate::linalg::{SolveError, SolveReport};
use nalgebra::{DMatrix, DVector};

/// Solves a system with bodies in a new backend.
fn solve_once<const D: usize>(
    system: &System<D>,
    bodies: &CoupledBodies<'_>,
    rhs: &CellField<D>,
    x: &mut CellField<D>,
) -> Result<SolveReport, SolveError> {
    let mut backend = MultigridBackend::default();
    let system = PressureSystem { matrix: system.input(), bodies: Some(bodies) };
    backend.prepare(&system)?.solve(rhs, x, limits(1e-11, 400))
}

/// Rigid bodies: degrees of freedom with unit mass (`B = I`) and no lumped compliance.
fn rigid_solution_matches<const D: usize>(system: &System<D>, scale: f64) {
    let (rhs, mut x) = (system.random_field(5), system.random_field(6));
    let column = |seed: u64| -> SparseColumn {
        let values = system.random_field(seed);
        let every = system.cells().into_iter().step_by(3);
        every.map(|c| (c as u32, scale * values.data[c])).collect()
    };
    let columns = [column(7), column(8), column(9)];
    let flow =
        |(i, (cell, _)): (usize, &(u32, f64))| (*cell, (0..3).map(|k| (k as u32, columns[k][i].1)).collect());
    let flux_rows: Vec<(u32, Vec<(u32, f64)>)> = columns[0].iter().enumerate().map(flow).collect();
    let (lumped_compliance, mean_pressure_probes) = (vec![0.0; flux_rows.len()], columns.to_vec());
    let body = CoupledBodies {
        dof_count: 3,
        flux_rows,
        lumped_compliance,
        solve: Box::new(|_| ()),
        mean_pressure_probes,
    };
    let report = solve_once(system, &body, &rhs, &mut x).unwrap();
    let mut dense = system.dense();
    let cells = system.cells();
    for column in &columns {
        let mut j = DVector::zeros(cells.len());
        column.iter().for_each(|(c, v)| j[cells.binary_search(&(*c as usize)).unwrap()] = *v);
        dense += &j * j.transpose();
    }
    let exact = dense.cholesky().expect("positive definite").solve(&system.values(&rhs));
    let error = (&exact - system.values(&x)).norm() / exact.norm();
    assert!(error < 1e-7, "{error}");
    assert!(report.iterations < 80, "{}", report.iterations);
}

#[test]
fn rigid_bodies_are_part_of_the_system() {
    for scale in [0.01, 1.0, 100.0] {
        rigid_solution_matches(&slab::<2>(), scale);
        rigid_solution_matches(&slab::<3>(), scale);
    }
    // Only the body determines the mean pressure of this one.
    rigid_solution_matches(&System::new([12, 9], |_| true, || 1.0, |_| 0.0), 1.0);
}

fn compliant_solution_matches<const D: usize>(mut system: System<D>, scale: f64) {
    let mut dense = system.dense();
    let cells = system.cells();
    let (wet, dof_count) = (cells.len().min(40), 12);
    let values = system.random_field(3);
    let flow = |i: usize| {
        let value =
            |k: usize| (((i + 3 * k) % dof_count) as u32, scale * values.data[cells[(i + 5 * k) % wet]]);
        (cells[i] as u32, (0..3).map(value).collect::<Vec<_>>())
    };
    let flux_rows: Vec<_> = (0..wet).map(flow).collect();
    let stiff = DMatrix::from_fn(dof_count, dof_count, |i, j| match i.abs_diff(j) {
        0 => 3.0 + i as f64,
        1 => -1.0,
        _ => 0.0,
    });
    let factor = stiff.clone().cholesky().expect("positive definite");
    let solve = |x: &mut [f64]| {
        for x in x.chunks_exact_mut(dof_count) {
            let solved = factor.solve(&DVector::from_column_slice(x));
            x.copy_from_slice(solved.as_slice());
        }
    };
    let mut f = DMatrix::zeros(cells.len(), dof_count);
    for (cell, flow) in &flux_rows {
        let row = cells.binary_search(&(*cell as usize)).unwrap();
        flow.iter().for_each(|(k, v)| f[(row, *k as usize)] += v);
    }
    dense += &f * factor.solve(&f.transpose());
    let lumped_compliance: Vec<f64> =
        flux_rows.iter().map(|(_, flow)| flow.iter().map(|(_, v)| v * v / 3.0).sum()).collect();
    for ((cell, _), lumped_compliance) in flux_rows.iter().zip(&lumped_compliance) {
        system.dirichlet.data[*cell as usize] += lumped_compliance;
    }
    let mean_pressure_probes = vec![flux_rows.iter().map(|(cell, _)| (*cell, 1.0)).collect()];
    let soft = CoupledBodies {
        dof_count,
        flux_rows,
        lumped_compliance,
        solve: Box::new(solve),
        mean_pressure_probes,
    };
    let (rhs, mut x) = (system.random_field(5), system.random_field(6));
    solve_once(&system, &soft, &rhs, &mut x).unwrap();
    let exact = dense.cholesky().expect("positive definite").solve(&system.values(&rhs));
    let error = (&exact - system.values(&x)).norm() / exact.norm();
    assert!(error < 1e-7, "{error}");
}

#[test]
fn bodies_that_deform_are_part_of_the_system() {
    for scale in [0.01, 1.0, 100.0] {
        compliant_solution_matches(slab::<2>(), scale);
        compliant_solution_matches(slab::<3>(), scale);
    }
    compliant_solution_matches(System::new([12, 9], |_| true, || 1.0, |_| 0.0), 1.0);
}

#[test]
fn systems_before_leave_no_trace_in_a_backend() {
    let large = slab::<3>();
    let bodies = CoupledBodies {
        dof_count: 1,
        flux_rows: large.cells().iter().step_by(7).map(|c| (*c as u32, vec![(0, 0.3)])).collect(),
        lumped_compliance: vec![0.0; large.cells().len().div_ceil(7)],
        solve: Box::new(|_| ()),
        mean_pressure_probes: Vec::new(),
    };
    let system = PressureSystem { matrix: large.input(), bodies: Some(&bodies) };
    let solve = |backend: &mut MultigridBackend<3>| {
        let mut prepared = backend.prepare(&system).unwrap();
        [5, 6].map(|seed| {
            let mut x = large.random_field(seed + 2);
            prepared.solve(&large.random_field(seed), &mut x, limits(1e-9, 100)).unwrap();
            large.cells().iter().map(|c| x.data[*c].to_bits()).collect::<Vec<_>>()
        })
    };
    let mut used = MultigridBackend::default();
    // One with another layout, and a solve that fails, which leaves numbers in the memory that are not finite.
    let other = System::<3>::random([33, 19, 12], 0.95, 7);
    for system in [&other, &large] {
        let mut rhs = system.random_field(1);
        rhs.data[system.cells()[40]] = f64::NAN;
        let mut x = system.random_field(2);
        let alone = PressureSystem { matrix: system.input(), bodies: None };
        let mut prepared = used.prepare(&alone).unwrap();
        let failure = prepared.solve(&rhs, &mut x, limits(1e-9, 100)).unwrap_err();
        assert!(matches!(failure, SolveError::NotFinite { .. }));
        rhs.data[system.cells()[40]] = 1e200;
        prepared.solve(&rhs, &mut x, limits(1e-9, 100)).ok();
    }
    assert_eq!(solve(&mut MultigridBackend::default()), solve(&mut used));
}
