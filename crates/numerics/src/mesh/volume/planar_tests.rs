//! Triangulations of outlines, flat and extruded.

use super::*;
use crate::Matrix;
use crate::mesh::volume::ElementOrder;
use crate::shape::Shape;
use std::f64::consts::PI;

/// The named outlines, about 1 across.
fn outlines() -> Vec<(&'static str, Outline)> {
    let blob: Vec<[f64; 2]> = (0..200)
        .map(|k| {
            let angle = 2.0 * PI * f64::from(k) / 200.0;
            let r = 0.4 + 0.08 * (2.0 * angle).sin() + 0.05 * (3.0 * angle).cos();
            [r * angle.cos() + 0.1, r * angle.sin()]
        })
        .collect();
    let notched = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.4], [0.5, 0.3], [0.4, 0.8], [0.0, 0.6]];
    vec![
        ("square", Outline::square(1.0)),
        ("triangle", Outline::triangle(1.0)),
        ("petals-4", Outline::petals(4, 1.0)),
        ("petals-6", Outline::petals(6, 1.0)),
        ("cross", Outline::cross(1.0)),
        ("leaf", Outline::leaf(1.0)),
        ("blob", Outline::polygon(&blob).unwrap()),
        ("notched", Outline::polygon(&notched).unwrap()),
    ]
}

#[test]
fn outlines_are_triangulated_well() {
    for (name, outline) in outlines() {
        for edge in [0.02, 0.033] {
            let planar = outline.triangulate(edge).unwrap();
            let mesh = &planar.mesh;
            let quality = mesh.quality();
            println!("{name} {edge}: {quality}, colours {:?}", planar.color.iter().max());
            assert_eq!(mesh.check(), Ok(()), "{name}");
            let tree = outline.tree();
            let (surface, _) = mesh.surface();
            assert!(surface.positions.iter().all(|x| tree.signed_distance(x).abs() < 1e-12), "{name}");
            assert!((quality.volume / outline.surface().volume() - 1.0).abs() < 3e-3, "{name}");
            assert!(quality.smallest_angle.0.to_degrees() > 22.0, "{name} {quality}");
            assert!((quality.edge_lengths[1] / edge - 1.0).abs() < 0.1, "{name}");
            for e in mesh.edges() {
                assert!(planar.color[e[0] as usize] != planar.color[e[1] as usize]);
            }
        }
    }
}

/// Reflections and rotations of the outline map the triangles onto themselves.
#[test]
fn triangulations_have_the_symmetry_of_their_outline() {
    for (name, outline) in outlines() {
        let planar = outline.triangulate(0.05).unwrap();
        let keys = |k: usize, mirrored: bool| {
            let key = |s: &Simplex<2>| {
                let x = outline.image(&s.center(&planar.mesh.positions), k, mirrored);
                [(x[0] * 1e9).round() as i64, (x[1] * 1e9).round() as i64]
            };
            let mut all: Vec<_> = planar.mesh.simplices.iter().map(key).collect();
            all.sort_unstable();
            all
        };
        for k in 0..outline.mirror_count {
            let close = |(a, b): (&[i64; 2], &[i64; 2])| (a[0] - b[0]).abs() < 3 && (a[1] - b[1]).abs() < 3;
            assert!(keys(0, false).iter().zip(&keys(k, true)).all(close), "{name}");
            assert!(keys(0, false).iter().zip(&keys(k, false)).all(close), "{name}");
        }
    }
}

#[test]
fn triangulation_refuses_what_cannot_be() {
    let square = Outline::square(1.0);
    assert!(matches!(square.triangulate(0.0), Err(OutlineError::Size { .. })));
    assert!(matches!(Outline::leaf(0.0).triangulate(0.1), Err(OutlineError::Size { .. })));
    assert!(matches!(square.triangulate(1e-5), Err(OutlineError::TooFine { .. })));
}

/// Edges longer than the width of the outline give a mesh or an error.
#[test]
fn long_edges_make_a_mesh_or_an_error() {
    for (name, outline) in outlines() {
        for edge in [0.05, 0.08, 0.13, 0.21, 0.34, 0.55, 3.0] {
            match outline.triangulate(edge) {
                Ok(planar) => {
                    assert_eq!(planar.mesh.check(), Ok(()), "{name} {edge}");
                    assert!(!planar.mesh.simplices.is_empty(), "{name} {edge}");
                }
                Err(error) => {
                    assert!(matches!(error, OutlineError::TooCoarse { .. }), "{name} {edge}: {error}");
                }
            }
        }
    }
}

fn extruded<const D: usize>() {
    let mut rotation = Matrix::<D>::identity();
    let (s, c) = 0.4f64.sin_cos();
    (rotation[(0, 0)], rotation[(0, 1)], rotation[(1, 0)], rotation[(1, 1)]) = (c, -s, s, c);
    let center = Vector::from_fn(|a, _| 0.3 + a as f64);
    for (name, outline) in outlines() {
        for order in [ElementOrder::Linear, ElementOrder::Quadratic] {
            let mesh = VolumeMesh::<D>::of_outline(&outline, &center, 0.06, &rotation, 0.033, order).unwrap();
            let shape = Shape::<D>::extrusion(&outline, &center, 0.06, &rotation);
            let quality = mesh.quality();
            println!("{D}D {name} {order:?}: {quality}");
            assert_eq!(mesh.check(), Ok(()), "{name}");
            assert!((quality.volume / shape.volume().unwrap() - 1.0).abs() < 3e-3);
            let (surface, _) = mesh.surface();
            let off = |x: &&Vector<D>| shape.signed_distance(x).abs() >= 1e-12;
            let off = surface.positions.iter().filter(off).count();
            // Quadratic nodes on flat triangles stay on straight edges.
            assert!(
                off * 50 <= surface.positions.len() && (order == ElementOrder::Quadratic || off == 0),
                "{name} {off}"
            );
            let least = if D == 2 { 22.0 } else { 20.0 };
            assert!(quality.smallest_angle.0.to_degrees() > least, "{name} {quality}");
        }
    }
}

#[test]
fn extruded_outlines_are_their_shape() {
    extruded::<2>();
    extruded::<3>();
    let plate = VolumeMesh::<3>::of_outline(
        &Outline::square(3.33),
        &Vector::zeros(),
        0.0693,
        &Matrix::identity(),
        0.034_67,
        ElementOrder::Linear,
    );
    assert_eq!(plate.unwrap().simplices.len(), 110_592);
    let thin = VolumeMesh::<3>::of_outline(
        &Outline::leaf(1.0),
        &Vector::zeros(),
        0.0,
        &Matrix::identity(),
        0.1,
        ElementOrder::Linear,
    );
    assert!(matches!(thin, Err(OutlineError::Size { .. })));
}
