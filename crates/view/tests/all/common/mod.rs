//! Made-up output folders, for tests and for looking at.
#![allow(clippy::unwrap_used, dead_code)]

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};
use std::fmt::Write;
use std::path::Path;

use meniscus_numerics::mesh::ply::PlyMesh;

/// A sphere of triangles about the origin with radius 1.
pub fn icosphere(splits: usize) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let g = 0.5 * (1.0 + 5f64.sqrt());
    let mut points: Vec<[f64; 3]> = Vec::new();
    for (a, b) in [(-1.0, g), (1.0, g), (-1.0, -g), (1.0, -g)] {
        points.extend([[a, b, 0.0], [0.0, a, b], [b, 0.0, a]]);
    }
    let mut faces = Vec::new();
    for i in 0..12u32 {
        for j in 0..12u32 {
            for k in 0..12u32 {
                let near =
                    |a: u32, b: u32| (distance(points[a as usize], points[b as usize]) - 2.0).abs() < 1e-9;
                let [p, q, r] = [i, j, k].map(|v| points[v as usize]);
                if i < j
                    && i < k
                    && j != k
                    && near(i, j)
                    && near(j, k)
                    && near(k, i)
                    && dot(cross(p, q), r) > 0.0
                {
                    faces.push([i, j, k]);
                }
            }
        }
    }
    for _ in 0..splits {
        let mut middle: HashMap<(u32, u32), u32> = HashMap::new();
        let mut finer = Vec::new();
        for [a, b, c] in faces {
            let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(i, j)| {
                *middle.entry((i.min(j), i.max(j))).or_insert_with(|| {
                    let (p, q) = (points[i as usize], points[j as usize]);
                    points.push([p[0] + q[0], p[1] + q[1], p[2] + q[2]].map(|x| x * 0.5));
                    points.len() as u32 - 1
                })
            });
            finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        faces = finer;
    }
    let unit = |p: [f64; 3]| p.map(|x| x / dot(p, p).sqrt());
    (points.into_iter().map(unit).collect(), faces)
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let d = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    dot(d, d).sqrt()
}

/// A box of triangles, its faces cut into `n` × `n` squares.
pub fn cuboid(lower: [f64; 3], upper: [f64; 3], n: u32) -> PlyMesh {
    let mut mesh = PlyMesh::default();
    for axis in 0..3 {
        for side in [0, 1] {
            let first = mesh.positions.len() as u32;
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            for j in 0..=n {
                for i in 0..=n {
                    let mut p = [0.0; 3];
                    p[axis] = if side == 1 { upper[axis] } else { lower[axis] };
                    p[u] = lower[u] + (upper[u] - lower[u]) * f64::from(i) / f64::from(n);
                    p[v] = lower[v] + (upper[v] - lower[v]) * f64::from(j) / f64::from(n);
                    mesh.positions.push(p);
                }
            }
            for k in 0..n * n {
                let a = first + k / n * (n + 1) + k % n;
                let (b, c, d) = (a + 1, a + n + 2, a + n + 1);
                let two = if side == 1 { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] };
                mesh.faces.extend(two);
            }
        }
    }
    mesh
}

/// Faces of a closed mesh of a pole, rings of `around` vertices and another pole, in this order.
pub fn ring_faces(rings: u32, around: u32) -> Vec<[u32; 3]> {
    let at = |ring: u32, k: u32| 1 + (ring - 1) * around + k % around;
    let mut faces = Vec::new();
    for k in 0..around {
        faces.push([0, at(1, k), at(1, k + 1)]);
        for ring in 1..rings {
            faces.push([at(ring, k), at(ring + 1, k), at(ring + 1, k + 1)]);
            faces.push([at(ring, k), at(ring + 1, k + 1), at(ring, k + 1)]);
        }
        faces.push([at(rings, k), 1 + rings * around, at(rings, k + 1)]);
    }
    faces
}

/// A drop lying at height `z` about `center`: contact angle (rad), contact radius, and an elliptic wobble.
pub fn cap(center: [f64; 2], z: f64, angle: f64, radius: f64, wobble: f64) -> (PlyMesh, PlyMesh) {
    const RINGS: u32 = 70;
    const FLAT: u32 = 24;
    const AROUND: u32 = 150;
    let sphere = radius / angle.sin();
    let mut mesh = PlyMesh::default();
    let mut kind = Vec::new();
    let mut push = |r: f64, turn: f64, h: f64, k: f64| {
        let r = r * (1.0 + wobble * (2.0 * turn).cos());
        mesh.positions.push([center[0] + r * turn.cos(), center[1] + r * turn.sin(), z + h]);
        kind.push(k);
    };
    push(0.0, 0.0, sphere * (1.0 - angle.cos()), 0.0);
    for ring in 1..=RINGS + FLAT - 1 {
        for k in 0..AROUND {
            let turn = TAU * f64::from(k) / f64::from(AROUND);
            if ring <= RINGS {
                let a = angle * f64::from(ring) / f64::from(RINGS);
                let kind = if ring == RINGS { 2.0 } else { 0.0 };
                push(sphere * a.sin(), turn, sphere * (a.cos() - angle.cos()), kind);
            } else {
                push(radius * f64::from(RINGS + FLAT - ring) / f64::from(FLAT), turn, 0.0, 1.0);
            }
        }
    }
    push(0.0, 0.0, 0.0, 1.0);
    mesh.faces = ring_faces(RINGS + FLAT - 1, AROUND);
    mesh.scalars.insert("kind".into(), kind);
    let first = 1 + (RINGS - 1) * AROUND;
    let ring: Vec<[f64; 3]> = (0..AROUND).map(|k| mesh.positions[(first + k) as usize]).collect();
    let mut line = PlyMesh { positions: ring, ..PlyMesh::default() };
    line.edges = (0..AROUND).map(|k| [k, (k + 1) % AROUND]).collect();
    line.scalars.insert("angle".into(), vec![angle.to_degrees(); AROUND as usize]);
    (mesh, line)
}

/// A closed outline in the plane: a circle with a wobble of mode 3, cut off below `floor`.
pub fn blob(center: [f64; 2], radius: f64, wobble: f64, floor: f64, n: u32) -> PlyMesh {
    let mut mesh = PlyMesh::default();
    for k in 0..n {
        let turn = TAU * f64::from(k) / f64::from(n);
        let r = radius * (1.0 + wobble * (3.0 * turn).cos());
        mesh.positions.push([center[0] + r * turn.cos(), (center[1] + r * turn.sin()).max(floor), 0.0]);
    }
    mesh.edges = (0..n).map(|k| [k, (k + 1) % n]).collect();
    let on = |p: &[f64; 3]| f64::from(u8::from(p[1] <= floor));
    let kinds = mesh.positions.iter().map(on).collect();
    mesh.scalars.insert("kind".into(), kinds);
    mesh
}

/// Which folder to make up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sample {
    /// A wobbling ball in the air.
    Ball,
    /// A drop on a plate, with its contact line.
    Drop,
    /// A blob on the floor, in the plane.
    Flat,
}

/// Writes a folder with `frames` frames.
pub fn write(dir: &Path, sample: Sample, frames: u32) {
    std::fs::create_dir_all(dir.join("frames")).unwrap();
    for n in 0..frames {
        let phase = TAU * 2.0 * f64::from(n) / f64::from(frames.max(2));
        let mut meshes: Vec<(&str, PlyMesh)> = Vec::new();
        match sample {
            Sample::Ball => {
                let (points, faces) = icosphere(5);
                let place = |p: &[f64; 3]| {
                    let legendre = 0.5 * (3.0 * p[2] * p[2] - 1.0);
                    let r = 0.01 * (1.0 + 0.16 * phase.cos() * legendre + 0.01 * (5.0 * p[0] + phase).sin());
                    [0.03 + r * p[0], 0.03 + r * p[1], 0.018 + r * p[2]]
                };
                let positions = points.iter().map(place).collect();
                meshes.push(("liquid", PlyMesh { positions, faces, ..PlyMesh::default() }));
            }
            Sample::Drop => {
                let angle = (70.0 + 40.0 * (0.5 * phase).sin()) * PI / 180.0;
                let (mut drop, line) = cap([0.05, 0.05], 0.012, angle, 0.014, 0.04 * phase.sin());
                let (points, faces) = icosphere(4);
                let first = drop.positions.len() as u32;
                drop.positions.extend(points.iter().map(|p| {
                    [0.055 + 0.003 * p[0], 0.045 + 0.003 * p[1], 0.045 - 0.01 * phase.sin() + 0.003 * p[2]]
                }));
                drop.faces.extend(faces.iter().map(|f| f.map(|i| i + first)));
                if let Some(kind) = drop.scalars.get_mut("kind") {
                    kind.resize(drop.positions.len(), 0.0);
                }
                meshes.push(("liquid", drop));
                meshes.push(("contact_line", line));
                meshes.push(("solid_plate", cuboid([0.02, 0.02, 0.008], [0.08, 0.08, 0.012], 6)));
            }
            Sample::Flat => {
                let drop = blob([0.05, 0.026], 0.022, 0.12 * phase.cos(), 0.01, 400);
                let wet = drop.positions.iter().filter(|p| p[1] <= 0.01 + 1e-12).map(|p| p[0]);
                let (low, high) = wet.fold((1.0f64, 0.0f64), |(a, b), x| (a.min(x), b.max(x)));
                let positions = vec![[low, 0.01, 0.0], [high, 0.01, 0.0]];
                meshes.push(("liquid", drop));
                meshes.push(("contact_line", PlyMesh { positions, ..PlyMesh::default() }));
                let positions = vec![[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.1, 0.01, 0.0], [0.0, 0.01, 0.0]];
                let edges = vec![[0, 1], [1, 2], [2, 3], [3, 0]];
                meshes.push(("solid_table", PlyMesh { positions, edges, ..PlyMesh::default() }));
            }
        }
        for (what, mut mesh) in meshes {
            mesh.comments.push(format!("time {}", f64::from(n) * 0.005));
            mesh.save(&dir.join(format!("frames/{what}_{n:04}.ply"))).unwrap();
        }
    }
    write_texts(dir, sample, frames);
}

fn write_texts(dir: &Path, sample: Sample, frames: u32) {
    let (dimension, domain) = match sample {
        Sample::Ball => (3, "[0.06, 0.06, 0.06]"),
        Sample::Drop => (3, "[0.1, 0.1, 0.06]"),
        Sample::Flat => (2, "[0.1, 0.06]"),
    };
    let summary = format!(
        r#"{{"scene": "sample-{}", "dimension": {dimension}, "domain": {domain}, "resolution": 96, "dx": 0.001,
        "steps": 500, "simulated_seconds": {}, "wall_seconds": 12.5, "volume_error": -0.0004,
        "phases": {{"advect": 3.1, "solve": 8.2, "mesh": 1.2}},
        "drops": [{{"volume": 4.2e-6, "centroid": [0.03, 0.03, 0.02]}}],
        "exit_reason": "done", "version": "0.1.0"}}"#,
        format!("{sample:?}").to_lowercase(),
        0.005 * f64::from(frames.saturating_sub(1)),
    );
    std::fs::write(dir.join("summary.json"), summary).unwrap();
    let scene = "format = 1\nname = \"sample\"                 # made up, not simulated\n\n[liquid]\n\
        density = \"1 g/cm^3\"\n\n[tension]\nliquid_air = \"0.728 mN/cm\"\n";
    std::fs::write(dir.join("scene.toml"), scene).unwrap();
    let mut csv = String::from(
        "step,time,dt,cfl,liquid_volume,kinetic_energy,surface_energy,elastic_energy,potential_energy,max_speed,\
        momentum_x,momentum_y,momentum_z,contact_points,contact_length,contact_angle_mean,contact_angle_std,\
        divergence_max,solve_iterations,wall_seconds\n",
    );
    let end = 0.005 * f64::from(frames.saturating_sub(1));
    for step in 0..500 {
        let t = end * f64::from(step) / 499.0;
        let (decay, phase) = ((-6.0 * t).exp(), TAU * 2.0 * t / end.max(1e-9));
        let angle = match sample {
            Sample::Ball => ",".to_string(),
            _ => format!("{},{}", 70.0 + 40.0 * decay * (0.5 * phase).sin(), 1.0 + decay),
        };
        let kinetic = 2e-6 * decay * phase.sin().powi(2);
        let surface = 1e-4 + 2e-6 * decay * phase.cos().powi(2);
        let speed = 0.2 * decay * phase.sin().abs();
        let volume = 4.2e-6 * (1.0 - 4e-4 * (1.0 - decay));
        let _ = writeln!(
            csv,
            "{step},{t},{},0.7,{volume},{kinetic},{surface},0,{},{speed},0,0,{},150,0.088,{angle},1e-9,{},0.025",
            end / 499.0,
            5e-7 * decay,
            1e-9 * phase.sin(),
            8 + step % 5,
        );
    }
    std::fs::write(dir.join("timeseries.csv"), csv).unwrap();
}
