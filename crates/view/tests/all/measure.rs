//! The goniometer on made-up drops whose angles are known.
#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};

use crate::common::{cap, cuboid, icosphere, ring_faces};
use meniscus_numerics::mesh::ply::PlyMesh;
use meniscus_view::{ContactMeasure, FitShape, MeasureOptions, Measurement, ViewError, measure};

/// Cell width of all runs here, m.
const DX: f64 = 1e-3;

struct Place(PathBuf);

impl Drop for Place {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// A folder with one frame of some meshes, told to have cells of [`DX`].
fn folder(name: &str, dimension: usize, meshes: &[(&str, &PlyMesh)]) -> Place {
    let dir = std::env::temp_dir().join(format!("meniscus-measure-{name}-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&dir);
    std::fs::create_dir_all(dir.join("frames")).unwrap();
    let domain = if dimension == 2 { "[0.1, 0.08]" } else { "[0.1, 0.1, 0.08]" };
    let summary = format!(
        r#"{{"scene": "{name}", "dimension": {dimension}, "dx": {DX}, "domain": {domain}, "frame_interval": 0.5,
        "simulated_seconds": 0, "solids": [{{"name": "plate", "net_force": [0, -1, 2],
        "pressure_force": [0, -3, 4], "line_force": [0, 2, -2]}}]}}"#
    );
    std::fs::write(dir.join("summary.json"), summary).unwrap();
    frame(&dir, 0, meshes);
    Place(dir)
}

/// The frame nearest to a time, s.
fn at(time: f64) -> MeasureOptions {
    MeasureOptions { at: Some(time), ..MeasureOptions::default() }
}

fn frame(dir: &Path, number: u32, meshes: &[(&str, &PlyMesh)]) {
    for (what, mesh) in meshes {
        let mut mesh = (*mesh).clone();
        mesh.comments = vec![format!("time {}", 0.5 * f64::from(number))];
        mesh.save(&dir.join(format!("frames/{what}_{number:04}.ply"))).unwrap();
    }
}

fn contact(m: &Measurement) -> &ContactMeasure {
    assert_eq!((m.drops.len(), m.drops[0].contacts.len()), (1, 1), "{m:?}");
    &m.drops[0].contacts[0]
}

fn near(what: &str, value: f64, exact: f64, part: f64) {
    assert!((value / exact - 1.0).abs() < part, "{what}: {value} instead of {exact}");
}

/// The outline of a drop in the plane: an arc with half axes `a` and `b` (m) whose middle lies `up` (m) above the plate
/// at height `z` (m), closed by the base.
fn arc(z: f64, a: f64, b: f64, up: f64) -> PlyMesh {
    let start = (-up / b).asin();
    let (n, base) = (240u32, 60u32);
    let mut mesh = PlyMesh::default();
    let mut kinds = Vec::new();
    for k in 0..=n {
        let t = start + (std::f64::consts::PI - 2.0 * start) * f64::from(k) / f64::from(n);
        mesh.positions.push([0.05 + a * t.cos(), z + up + b * t.sin(), 0.0]);
        kinds.push(if k == 0 || k == n { 2.0 } else { 0.0 });
    }
    let half = a * start.cos();
    for k in 1..base {
        mesh.positions.push([0.05 - half + 2.0 * half * f64::from(k) / f64::from(base), z, 0.0]);
        kinds.push(1.0);
    }
    let all = mesh.positions.len() as u32;
    mesh.edges = (0..all).map(|k| [k, (k + 1) % all]).collect();
    mesh.scalars.insert("kind".into(), kinds);
    mesh
}

fn plate_2d(z: f64) -> PlyMesh {
    let positions = vec![[0.01, 0.0, 0.0], [0.09, 0.0, 0.0], [0.09, z, 0.0], [0.01, z, 0.0]];
    PlyMesh { positions, edges: vec![[0, 1], [1, 2], [2, 3], [3, 0]], ..PlyMesh::default() }
}

#[test]
fn caps_in_space_give_their_angle() {
    let plate = cuboid([0.01, 0.01, 0.005], [0.09, 0.09, 0.01], 8);
    let base = 0.012;
    let mut worst = 0.0f64;
    for angle in [30.0, 45.0, 60.0, 90.0, 120.0, 135.0, 150.0f64] {
        let exact = angle.to_radians();
        let (drop, line) = cap([0.05, 0.05], 0.01, exact, base, 0.0);
        let place =
            folder("cap-3d", 3, &[("liquid", &drop), ("solid_plate", &plate), ("contact_line", &line)]);
        let m = measure(&place.0, &MeasureOptions::default()).unwrap();
        let c = contact(&m);
        let fitted = c.angle.as_ref().unwrap();
        assert_eq!((c.solid.as_str(), fitted.shape), ("plate", FitShape::Sphere));
        worst = worst.max((fitted.value - angle).abs());
        assert!((fitted.value - angle).abs() < 0.3 && fitted.uncertainty < 0.3, "{angle}: {fitted:?}");
        let height = base / exact.sin() * (1.0 - exact.cos());
        near("base radius", c.base_radius.unwrap(), base, 0.01);
        near("height", c.height, height, 0.01);
        near("area", c.contact_area, std::f64::consts::PI * base * base, 0.01);
        let volume = std::f64::consts::PI / 6.0 * height * (3.0 * base * base + height * height);
        near("volume", m.drops[0].volume, volume, 0.01);
        let local = c.local_angle.as_ref().unwrap();
        assert!((local.mean - angle).abs() < 1e-9 && local.std < 1e-9 && local.points == 150);
        near("length", local.length, std::f64::consts::TAU * base, 0.01);
        let forces = m.solids[0].forces.as_ref().unwrap();
        assert_eq!(
            (&forces.net[..], forces.line.as_deref()),
            (&[0.0, -1.0, 2.0][..], Some(&[0.0, 2.0, -2.0][..]))
        );
    }
    println!("worst angle of caps in space: {worst:.2e} degrees");
}

#[test]
fn arcs_in_the_plane_give_their_angle() {
    let (z, radius) = (0.01, 0.016);
    let mut worst = 0.0f64;
    for angle in [30.0, 45.0, 60.0, 90.0, 120.0, 135.0, 150.0f64] {
        let exact = angle.to_radians();
        let drop = arc(z, radius, radius, -radius * exact.cos());
        let place = folder("arc-2d", 2, &[("liquid", &drop), ("solid_plate", &plate_2d(z))]);
        let m = measure(&place.0, &MeasureOptions::default()).unwrap();
        let c = contact(&m);
        let fitted = c.angle.as_ref().unwrap();
        assert_eq!(fitted.shape, FitShape::Circle);
        worst = worst.max((fitted.value - angle).abs());
        assert!((fitted.value - angle).abs() < 0.3 && fitted.uncertainty < 0.3, "{angle}: {fitted:?}");
        near("base radius", c.base_radius.unwrap(), radius * exact.sin(), 0.01);
        near("height", c.height, radius * (1.0 - exact.cos()), 0.01);
        near("area", c.contact_area, 2.0 * radius * exact.sin(), 0.01);
        assert!(c.local_angle.is_none());
    }
    println!("worst angle of arcs in the plane: {worst:.2e} degrees");
}

#[test]
fn flattened_drops_are_ellipses() {
    let (z, a, b, up) = (0.01, 0.018, 0.012, 0.003);
    let drop = arc(z, a, b, up);
    let place = folder("ellipse", 2, &[("liquid", &drop), ("solid_plate", &plate_2d(z))]);
    let m = measure(&place.0, &MeasureOptions::default()).unwrap();
    let fitted = contact(&m).angle.clone().unwrap();
    // At its foot the ellipse's normal is (cos t / a, sin t / b) with sin t = −up / b.
    let s = -up / b;
    let (x, y) = ((1.0 - s * s).sqrt() / a, s / b);
    let exact = (y / x.hypot(y)).acos().to_degrees();
    assert_eq!(fitted.shape, FitShape::Ellipse);
    assert!((fitted.value - exact).abs() < 0.3, "{exact}: {fitted:?}");
    assert!((fitted.radii[0] / a - 1.0).abs() < 0.01 && (fitted.radii[1] / b - 1.0).abs() < 0.01);
}

/// A cap of a sphere about `top` with radius `r` on a ball about `low` with radius `s`, closed along the ball.
fn cap_on_ball(top: f64, r: f64, low: f64, s: f64) -> PlyMesh {
    let gap = top - low;
    // Polar angles, from each centre, of the circle in which they meet.
    let outer = (-(gap * gap + r * r - s * s) / (2.0 * gap * r)).acos();
    let inner = ((gap * gap + s * s - r * r) / (2.0 * gap * s)).acos();
    let (rings, under, around) = (80u32, 30u32, 120u32);
    let mut mesh = PlyMesh::default();
    let mut kinds = Vec::new();
    let mut push = |center: f64, radius: f64, polar: f64, turn: f64, kind: f64| {
        let (sin, cos) = polar.sin_cos();
        mesh.positions.push([
            0.05 + radius * sin * turn.cos(),
            0.05 + radius * sin * turn.sin(),
            center + radius * cos,
        ]);
        kinds.push(kind);
    };
    push(top, r, 0.0, 0.0, 0.0);
    for ring in 1..rings + under {
        for k in 0..around {
            let turn = std::f64::consts::TAU * f64::from(k) / f64::from(around);
            if ring <= rings {
                push(
                    top,
                    r,
                    outer * f64::from(ring) / f64::from(rings),
                    turn,
                    if ring == rings { 2.0 } else { 0.0 },
                );
            } else {
                push(low, s, inner * f64::from(rings + under - ring) / f64::from(under), turn, 1.0);
            }
        }
    }
    push(low, s, 0.0, 0.0, 1.0);
    mesh.faces = ring_faces(rings + under - 1, around);
    mesh.scalars.insert("kind".into(), kinds);
    mesh
}

#[test]
fn caps_on_a_ball_give_their_angle() {
    let (low, s) = (0.03, 0.014);
    let (points, faces) = icosphere(5);
    let place = |p: &[f64; 3]| [0.05 + s * p[0], 0.05 + s * p[1], low + s * p[2]];
    let ball = PlyMesh { positions: points.iter().map(place).collect(), faces, ..PlyMesh::default() };
    for (gap, r) in [(0.016, 0.012), (0.009, 0.012), (0.022, 0.012)] {
        let drop = cap_on_ball(low + gap, r, low, s);
        let place = folder("cap-on-ball", 3, &[("liquid", &drop), ("solid_plate", &ball)]);
        let m = measure(&place.0, &MeasureOptions::default()).unwrap();
        let c = contact(&m);
        let exact = ((r * r + s * s - gap * gap) / (2.0 * r * s)).acos().to_degrees();
        let fitted = c.angle.as_ref().unwrap();
        assert!((fitted.value - exact).abs() < 0.3, "{exact}: {fitted:?}");
        near("height", c.height, gap + r - s, 0.01);
        let polar = (gap * gap + s * s - r * r) / (2.0 * gap * s);
        near("base radius", c.base_radius.unwrap(), s * (1.0 - polar * polar).sqrt(), 0.01);
        near("area", c.contact_area, std::f64::consts::TAU * s * s * (1.0 - polar), 0.01);
    }
}

#[test]
fn the_frame_is_chosen_by_time_and_touches_are_counted() {
    let drop = |up: f64| arc(0.01 + up, 0.016, 0.016, 0.0);
    let plate = plate_2d(0.01);
    let place = folder("times", 2, &[("liquid", &drop(0.005)), ("solid_plate", &plate)]);
    for (number, up) in [(1, 0.0), (2, 0.0), (3, 0.005)] {
        frame(&place.0, number, &[("liquid", &drop(up)), ("solid_plate", &plate)]);
    }
    let m = measure(&place.0, &at(1.1)).unwrap();
    assert_eq!((m.frame, m.time, m.drops[0].contacts.len()), (2, Some(1.0), 1));
    assert!(m.solids[0].forces.is_none(), "stored for the end only");
    let touch = &m.solids[0].touches[..];
    assert_eq!(touch.len(), 1);
    assert_eq!((touch[0].start, touch[0].end, touch[0].duration), (0.5, 1.0, Some(1.0)));
    assert!(measure(&place.0, &MeasureOptions::default()).unwrap().drops[0].contacts.is_empty());
    let error = measure(&place.0, &at(9.0)).unwrap_err();
    assert!(
        matches!(error, ViewError::Time { .. }) && error.to_string().contains("from 0 s to 1.5 s"),
        "{error}"
    );
}

/// A mesh whose vertices at one place are one.
fn welded(mesh: &PlyMesh) -> PlyMesh {
    let mut out = PlyMesh::default();
    let place = |p: &[f64; 3], out: &mut PlyMesh| {
        let same = |q: &[f64; 3]| (0..3).all(|a| (p[a] - q[a]).abs() < 1e-9);
        let known = out.positions.iter().position(same).unwrap_or(out.positions.len());
        if known == out.positions.len() {
            out.positions.push(*p);
        }
        known as u32
    };
    let places: Vec<u32> = mesh.positions.iter().map(|p| place(p, &mut out)).collect();
    out.faces = mesh.faces.iter().map(|f| f.map(|v| places[v as usize])).collect();
    out
}

#[test]
fn a_ball_in_a_tank_floats() {
    // A tank filled to 0.04 m; the ball about 0.03 m lies in it, all wet.
    let mut tank = welded(&cuboid([0.0, 0.0, 0.0], [0.1, 0.1, 0.04], 40));
    let on_top = |p: &[f64; 3]| p[2] > 0.04 - 1e-9 && p[0].min(p[1]) > 1e-9 && p[0].max(p[1]) < 0.1 - 1e-9;
    let mut kinds: Vec<f64> = tank.positions.iter().map(|p| if on_top(p) { 0.0 } else { 1.0 }).collect();
    let (points, faces) = icosphere(4);
    let place = |p: &[f64; 3]| [0.05 + 0.008 * p[0], 0.05 + 0.008 * p[1], 0.03 + 0.008 * p[2]];
    let ball = PlyMesh { positions: points.iter().map(place).collect(), faces, ..PlyMesh::default() };
    let first = tank.positions.len() as u32;
    tank.positions.extend_from_slice(&ball.positions);
    tank.faces.extend(ball.faces.iter().map(|f| [f[0] + first, f[2] + first, f[1] + first]));
    kinds.resize(tank.positions.len(), 1.0);
    tank.scalars.insert("kind".into(), kinds);
    let place = folder("tank", 3, &[("liquid", &tank), ("solid_plate", &ball)]);
    let m = measure(&place.0, &MeasureOptions::default()).unwrap();
    let floating = m.solids[0].floating.as_ref().unwrap();
    near("level", floating.level, 0.04, 1e-6);
    near("depth", floating.depth, 0.018, 1e-3);
    near("middle", floating.centre_above_level, -0.01, 1e-3);
    let ball = m.drops[0].contacts.iter().find(|c| c.solid == "plate").unwrap();
    assert!(ball.angle.is_none() && ball.base_radius.is_none(), "{ball:?}");
    near("wetted area", ball.contact_area, 2.0 * std::f64::consts::TAU * 0.008f64.powi(2), 0.01);
    assert!(m.drops[0].contacts.iter().any(|c| c.wall && c.solid == "bottom"));
    assert_eq!(m.drops.len(), 1, "the hole that the ball makes is no drop");
}

#[test]
fn folders_that_hold_no_run_are_refused() {
    let nowhere = std::env::temp_dir().join("meniscus-measure-nowhere");
    assert!(
        measure(&nowhere, &MeasureOptions::default())
            .unwrap_err()
            .to_string()
            .contains("meniscus-measure-nowhere")
    );
    let place = folder("no-summary", 2, &[("liquid", &arc(0.01, 0.016, 0.016, 0.0))]);
    std::fs::remove_file(place.0.join("summary.json")).unwrap();
    let error = measure(&place.0, &MeasureOptions::default()).unwrap_err().to_string();
    assert!(
        error.contains("summary.json") && error.contains("is this the output folder of a run?"),
        "{error}"
    );
    std::fs::remove_file(place.0.join("frames/liquid_0000.ply")).unwrap();
    assert!(
        measure(&place.0, &MeasureOptions::default()).unwrap_err().to_string().contains("liquid_NNNN.ply")
    );
}
