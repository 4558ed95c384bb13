//! Simulations of either dimension.
#![allow(clippy::unwrap_used, clippy::panic)]

use meniscus_scene::build::AnySimulation;
use meniscus_scene::file::{LoadOptions, Scene};
use meniscus_scene::output::frame::{Frame, FrameMesh};
use std::path::Path;

/// A drop on a soft plate on the bottom, with a fixed ball beside it.
fn scene(dimension: usize) -> Scene {
    let list = |values: [&str; 3]| format!("{:?}", [&values[..dimension - 1], &values[2..]].concat());
    let text = format!(
        "format = 1\nname = \"any\"\n\
         domain = {{ dimension = {dimension}, size = {}, resolution = 20 }}\n\
         liquid.density = \"1 g/cm^3\"\nliquid.kinematic_viscosity = \"0.1 cm^2/s\"\n\
         liquid.body = [{{ shape.ball = {{ center = {}, radius = \"1 mm\" }} }}]\n\
         solid = [\n\
         {{ name = \"plate\", density = \"1 g/cm^3\", shape.box = {{ lower = {}, upper = {} }}, \
         material.neo_hookean = {{ young_modulus = \"20 kPa\", poisson_ratio = 0.3 }} }},\n\
         {{ name = \"ball\", shape.ball = {{ center = {}, radius = \"0.4 mm\" }}, material.rigid.fixed = true }}]\n\
         tension = {{ liquid_air = \"30 mN/m\", plate.contact_angle = \"60 deg\" }}\n\
         output.duration = \"1 ms\"\n",
        list(["5 mm", "5 mm", "5 mm"]),
        list(["2 mm", "2.5 mm", "2.4 mm"]),
        list(["1 mm", "1.5 mm", "1 mm"]),
        list(["3.5 mm", "3.5 mm", "1.6 mm"]),
        list(["4.3 mm", "4.3 mm", "4.3 mm"]),
    );
    Scene::from_text("any.toml", &text, Path::new("."), &LoadOptions::default())
        .unwrap_or_else(|e| panic!("{}", e.render()))
}

fn meshes(frame: &Frame) -> impl Iterator<Item = &FrameMesh> {
    let solids = frame.solids.iter().map(|(_, mesh)| mesh);
    [&frame.liquid].into_iter().chain(solids).chain(&frame.contact_line)
}

#[test]
fn both_dimensions_have_one_face() {
    for dimension in [2, 3] {
        let mut simulation = AnySimulation::of(&scene(dimension)).unwrap();
        let end = 2e-4;
        simulation.run_to(end).unwrap();
        assert!((simulation.time() - end).abs() < 1e-15 && simulation.steps() > 0);
        let step = simulation.step(1e-5).unwrap();
        assert!(step.dt <= 1e-5 && step.diagnostics == simulation.diagnostics());
        assert_eq!(
            (simulation.dimension(), step.diagnostics.centroid[2] == 0.0),
            (dimension, dimension == 2)
        );

        let phi = simulation.phi();
        assert_eq!(phi.values.len(), phi.extent.iter().product::<usize>());
        let u = simulation.velocity(1).unwrap();
        assert_eq!((u.values.len(), u.extent[1]), (u.extent.iter().product(), phi.extent[1] + 1));
        assert!((phi.first[0] - u.first[0]).abs() < 1e-15 && u.first[1].abs() < phi.first[1]);
        assert_eq!(simulation.velocity(2).is_some(), dimension == 3);

        let frame = simulation.frame().unwrap();
        assert_eq!(frame.time, simulation.time());
        assert!(frame.solids.iter().map(|(name, _)| name.as_str()).eq(["plate", "ball"]));
        for mesh in meshes(&frame) {
            assert!(mesh.attributes.iter().all(|a| a.values.len() == mesh.positions.len()));
            assert!(
                dimension == 3 || mesh.triangles.is_empty() && mesh.positions.iter().all(|x| x[2] == 0.0)
            );
        }
        assert!(frame.solids[0].1.values("strain").is_some() && frame.solids[1].1.values("strain").is_none());
        let line = frame.contact_line.unwrap();
        assert!(line.values("solid").unwrap().iter().all(|n| *n == 0.0));
    }
}
