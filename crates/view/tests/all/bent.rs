//! Solids that deform: plates bent to arcs whose slopes, curvature and fold are known.
#![allow(clippy::unwrap_used)]

use meniscus_numerics::mesh::ply::PlyMesh;
use meniscus_view::{MeasureOptions, SoftMeasure, measure};
use std::path::PathBuf;

/// Cell width, m.
const DX: f64 = 1e-3;
/// Length, width and thickness of the plates, m.
const PLATE: [f64; 3] = [0.04, 0.016, 0.003];
/// Cells along these.
const CELLS: [usize; 3] = [40, 16, 3];

struct Place(PathBuf);

impl Drop for Place {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// A run of two frames with a solid that was at first as one mesh, and then is as another.
fn run(name: &str, dimension: usize, frames: [&PlyMesh; 2]) -> Option<SoftMeasure> {
    let dir = std::env::temp_dir().join(format!("meniscus-bent-{name}-{dimension}-{}", std::process::id()));
    let place = Place(dir.clone());
    let _ = std::fs::remove_dir_all(&dir);
    std::fs::create_dir_all(dir.join("frames")).unwrap();
    let domain = if dimension == 2 { "[0.1, 0.1]" } else { "[0.1, 0.1, 0.1]" };
    let summary = format!(
        r#"{{"scene": "bent", "dimension": {dimension}, "dx": {DX}, "domain": {domain}, "frame_interval": 0.5,
        "simulated_seconds": 0.5, "solids": [{{"name": "plate"}}]}}"#
    );
    std::fs::write(dir.join("summary.json"), summary).unwrap();
    for (k, mesh) in frames.iter().enumerate() {
        let mut mesh = (*mesh).clone();
        mesh.comments = vec![format!("time {}", 0.5 * k as f64)];
        mesh.save(&dir.join(format!("frames/solid_plate_{k:04}.ply"))).unwrap();
        let far = [[0.09, 0.09, 0.0], [0.095, 0.09, 0.0], [0.09, 0.095, 0.0], [0.09, 0.09, 0.005]];
        let mut drop = PlyMesh { positions: far.to_vec(), comments: mesh.comments, ..PlyMesh::default() };
        match dimension {
            2 => drop.edges = vec![[0, 1], [1, 2], [2, 0]],
            _ => drop.faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
        }
        drop.scalars.insert("kind".into(), vec![0.0; 4]);
        drop.save(&dir.join(format!("frames/liquid_{k:04}.ply"))).unwrap();
    }
    let measured = measure(&place.0, &MeasureOptions::default()).unwrap();
    assert_eq!(measured.solids.len(), 1);
    measured.solids.into_iter().next().unwrap().soft
}

/// The surface of a plate about the origin: lattices on its faces, as a solid's mesh has them.
fn plate(dimension: usize) -> PlyMesh {
    let mut mesh = PlyMesh::default();
    // Axes along and across the plate; in the plane there is no width.
    let cells = if dimension == 2 { [CELLS[0], 0, CELLS[2]] } else { CELLS };
    let size = if dimension == 2 { [PLATE[0], 0.0, PLATE[2]] } else { PLATE };
    let mut number = std::collections::BTreeMap::new();
    let mut vertex = |at: [usize; 3], mesh: &mut PlyMesh| -> u32 {
        *number.entry(at).or_insert_with(|| {
            let place = |a: usize| match cells[a] {
                0 => 0.0,
                n => (at[a] as f64 / n as f64 - 0.5) * size[a],
            };
            let x = [place(0), place(1), place(2)];
            mesh.positions.push(if dimension == 2 { [x[0], x[2], 0.0] } else { x });
            mesh.positions.len() as u32 - 1
        })
    };
    if dimension == 2 {
        let (n, m) = (cells[0], cells[2]);
        let mut around: Vec<[usize; 3]> = (0..n).map(|i| [i, 0, 0]).collect();
        around.extend((0..m).map(|k| [n, 0, k]));
        around.extend((0..n).map(|i| [n - i, 0, m]));
        around.extend((0..m).map(|k| [0, 0, m - k]));
        let all: Vec<u32> = around.iter().map(|at| vertex(*at, &mut mesh)).collect();
        mesh.edges = (0..all.len()).map(|k| [all[k], all[(k + 1) % all.len()]]).collect();
        return mesh;
    }
    for axis in 0..3 {
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        for side in [0, cells[axis]] {
            for i in 0..cells[b] {
                for j in 0..cells[c] {
                    let mut corner = |di: usize, dj: usize| {
                        let mut at = [0; 3];
                        (at[axis], at[b], at[c]) = (side, i + di, j + dj);
                        vertex(at, &mut mesh)
                    };
                    let q = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                    let turned = |f: [u32; 3]| if side == 0 { [f[0], f[2], f[1]] } else { f };
                    mesh.faces.extend([turned([q[0], q[1], q[2]]), turned([q[0], q[2], q[3]])]);
                }
            }
        }
    }
    mesh
}

/// The same with every vertex moved; what is along, across (3D) and up.
fn moved(mesh: &PlyMesh, dimension: usize, to: impl Fn([f64; 3]) -> [f64; 3]) -> PlyMesh {
    let mut out = mesh.clone();
    for x in &mut out.positions {
        let own = if dimension == 2 { [x[0], 0.0, x[1]] } else { *x };
        let new = to(own);
        *x = if dimension == 2 { [new[0], new[2], 0.0] } else { new };
    }
    out
}

fn near(what: &str, value: f64, exact: f64, part: f64) {
    assert!((value / exact - 1.0).abs() < part, "{what}: {value} instead of {exact}");
}

/// A free plate bent to an arc, turned and moved.
fn arc(dimension: usize) {
    let (flat, radius) = (plate(dimension), 0.03);
    let bent = moved(&flat, dimension, |[x, y, z]| {
        let angle = x / radius;
        let (s, c) = (0.4f64.sin(), 0.4f64.cos());
        let (a, b) = ((radius - z) * angle.sin(), radius - (radius - z) * angle.cos());
        [0.02 + c * a - s * b, y + 0.001, 0.01 + s * a + c * b]
    });
    let soft = run("arc", dimension, [&flat, &bent]).unwrap();
    let strip = soft.strip.unwrap();
    let half = (0.5 * PLATE[0] / radius).to_degrees();
    near("fold", strip.fold_angle, 2.0 * half, 0.002);
    near(
        "slope",
        strip.slopes[1] - strip.slopes[0],
        if strip.slopes[1] > 0.0 { 2.0 * half } else { -2.0 * half },
        0.002,
    );
    // The rigid motion is taken off: the ends are alike.
    assert!((strip.slopes[0] + strip.slopes[1]).abs() < 0.02, "{:?}", strip.slopes);
    near("curvature", strip.curvature.abs(), 1.0 / radius, 0.01);
    near("length", strip.length, PLATE[0], 1e-9);
    near("opening", strip.opening, 2.0 * radius * half.to_radians().sin() / PLATE[0], 0.001);
    assert!(!soft.held && soft.largest_displacement > soft.largest_deflection);
    assert!(soft.wetted.is_none() && soft.ridge.is_none());
}

#[test]
fn an_arc_has_its_curvature() {
    arc(2);
    arc(3);
}

/// A cantilever held at its lower end along x, bent by `w = a s²`.
fn cantilever(dimension: usize) {
    let flat = plate(dimension);
    let a = 4.0;
    let way = |x: f64| {
        let s = (x + 0.5 * PLATE[0] - 0.004).max(0.0);
        a * s * s
    };
    let bent = moved(&flat, dimension, |[x, y, z]| [x, y, z + way(x)]);
    let soft = run("cantilever", dimension, [&flat, &bent]).unwrap();
    let tip = way(0.5 * PLATE[0]);
    assert!(soft.held);
    near("deflection", soft.largest_deflection, tip, 1e-12);
    near("displacement", soft.largest_displacement, tip, 1e-12);
    assert!(soft.mean_deflection > 0.2 * tip && soft.mean_deflection < 0.5 * tip);
    let up = dimension - 1;
    near("tip", soft.tip_displacement.unwrap()[up], tip, 1e-12);
    near("tip along", soft.tip.unwrap()[0], 0.5 * PLATE[0], 1e-12);
    let strip = soft.strip.unwrap();
    let slope = (2.0 * a * (PLATE[0] - 0.004)).atan().to_degrees();
    near("slope", strip.slopes.map(f64::abs).into_iter().fold(0.0, f64::max), slope, 0.005);
    assert!(strip.slopes.map(f64::abs).into_iter().fold(90.0, f64::min) < 0.05, "{:?}", strip.slopes);
    // A line across it, in the middle or near its end: the plate bends there, but no ridge is pulled up.
    for (line, reason) in [(0.0, "not highest"), (0.5 * PLATE[0] - 0.002, "at an edge")] {
        let mut wet = bent.clone();
        let values =
            flat.positions.iter().map(|x| if flat_top(x, up) { x[0] - line } else { 0.02 }).collect();
        wet.scalars.insert("phi_c".into(), values);
        let soft = run("no-ridge", dimension, [&flat, &wet]).unwrap();
        assert!(
            soft.ridge.is_none() && soft.ridge_reason.unwrap().contains(reason),
            "{:?}",
            soft.ridge_reason
        );
    }
    near("curvature", strip.curvature.abs(), 2.0 * a, 0.05);
    near("profile", strip.profile.iter().map(|p| p[1].abs()).fold(0.0, f64::max), tip, 1e-3);
}

#[test]
fn a_cantilever_has_its_slope_and_tip() {
    cantilever(2);
    cantilever(3);
}

/// A plate around whose middle the distance to a line is known, with a ridge there.
fn ridge(dimension: usize) {
    let flat = plate(dimension);
    let high = 2e-4;
    let mut bent = moved(&flat, dimension, |[x, y, z]| {
        let up = high * (-(x.abs() - 0.008).powi(2) / (2.0 * DX).powi(2)).exp();
        [x, y, z + if z > 0.49 * PLATE[2] { up } else { 0.0 }]
    });
    let up = dimension - 1;
    let phi = |x: &[f64; 3]| if flat_top(x, up) { x[0].abs() - 0.008 } else { 0.02 };
    let values: Vec<f64> = flat.positions.iter().map(phi).collect();
    bent.scalars.insert("phi_c".into(), values);
    let soft = run("ridge", dimension, [&flat, &bent]).unwrap();
    let ridge = soft.ridge.unwrap();
    near("ridge", ridge.height, high, 0.02);
    let peak = ridge.profile.iter().fold([0.0; 2], |m, p| if p[1] > m[1] { *p } else { m });
    assert!(peak[0].abs() < 0.6 * DX, "{peak:?}");
    // Of the upper face the middle 16 mm are wetted.
    let faces = if dimension == 2 {
        2.0 * (PLATE[0] + PLATE[2])
    } else {
        2.0 * (PLATE[0] * PLATE[1] + PLATE[2] * (PLATE[0] + PLATE[1]))
    };
    let wet = 0.016 * if dimension == 2 { 1.0 } else { PLATE[1] };
    near("wetted", soft.wetted.unwrap(), wet / faces, 0.02);
}

fn flat_top(x: &[f64; 3], up: usize) -> bool {
    x[up] > 0.49 * PLATE[2]
}

#[test]
fn a_ridge_has_its_height() {
    ridge(2);
    ridge(3);
}

#[test]
fn rigid_solids_are_not_bent() {
    let flat = plate(3);
    let gone = moved(&flat, 3, |[x, y, z]| [y + 0.01, -x, z + 0.02]);
    assert!(run("rigid", 3, [&flat, &gone]).is_none());
    let ball = PlyMesh { positions: flat.positions[..4].to_vec(), ..flat.clone() };
    let less = PlyMesh { faces: vec![[0, 1, 2]], ..ball };
    assert!(run("other", 3, [&flat, &less]).is_none());
}
