//! Frames as USD text: a layer for each frame, and `run.usda`, which plays them as value clips.
//!
//! Source: OpenUSD, "USDA file format", "Value clips", "UsdGeom", "UsdPreviewSurface". A time code is the number of a frame; the time in
//! seconds is the attribute `meniscus:time` of the root prim. The number of vertices changes from frame to frame, so a value holds
//! until the next frame; renderers blur by `velocities`, in units of the positions a second of playback. Limit: positions and attributes are
//! in single precision, as the schemas ask.

mod layer;
mod prim;
mod root;

use self::layer::Range;
use self::prim::{Material, Naming, Prim, Scales};
use crate::output::frame::{Frame, FrameMesh, FrameWriter};
use crate::output::{FileError, Folder, atomic_file};
use std::path::PathBuf;

/// Writes `frame_NNNN.usda` with the prims `liquid`, `solid_NAME` and `contact_line`, and `run.usda` with all frames of the folder.
///
/// Every frame has all prims, with empty arrays where there is nothing, so that no clip shows what an earlier one had.
#[derive(Clone, Copy, Debug)]
pub struct UsdWriter;

impl FrameWriter for UsdWriter {
    fn write(&self, folder: &Folder, number: u64, frame: &Frame) -> Result<PathBuf, FileError> {
        let path = folder.frame_file("frame", number, "usda");
        let prims = prims(frame);
        let range = Range { first: number, last: number, up_axis: frame.up_axis, unit: frame.unit };
        atomic_file::write_atomically(&path, |out| {
            layer::write_head(out, &range)?;
            layer::open_root(out, None)?;
            layer::write_time(out, Some((number, frame.time)))?;
            prims.iter().try_for_each(|prim| layer::write_prim(out, prim, Some(number)))?;
            layer::close_root(out)
        })?;
        root::write(folder, &prims, frame)?;
        Ok(path)
    }
}

/// The prims of a frame; those without content have empty arrays.
fn prims(frame: &Frame) -> Vec<Prim> {
    let (flat, scales) = (is_flat(frame), Scales::of(frame));
    let mut naming = Naming::default();
    let mut surface = |name: &str, mesh: &FrameMesh, material| {
        let label = naming.label(name, material);
        if flat { prim::curves(label, mesh, &scales) } else { prim::triangles(label, mesh, &scales) }
    };
    let mut all = vec![surface("liquid", &frame.liquid, Material::Liquid)];
    for (name, mesh) in &frame.solids {
        all.push(surface(&format!("solid_{name}"), mesh, Material::Solid));
    }
    let label = naming.label("contact_line", Material::Line);
    let empty = prim::empty_line();
    let line = frame.contact_line.as_ref().unwrap_or(&empty);
    all.push(if flat { prim::points(label, line, &scales) } else { prim::curves(label, line, &scales) });
    all
}

/// Whether a frame is of two dimensions: its surfaces are edges. One without surfaces is if its second axis points up.
fn is_flat(frame: &Frame) -> bool {
    let surfaces = || frame.solids.iter().map(|(_, mesh)| mesh).chain([&frame.liquid]);
    let has_triangles = surfaces().any(|mesh| !mesh.triangles.is_empty());
    let has_edges = surfaces().any(|mesh| !mesh.edges.is_empty());
    !has_triangles && (has_edges || frame.up_axis == 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::frame::Attribute;
    use crate::output::frame::formats::tests::{Place, empty_frame, full_frame};

    /// The text between the brackets of an attribute's values.
    fn values<'a>(text: &'a str, prim: &str, name: &str) -> &'a str {
        let prim = text.split_once(&format!("\"{prim}\"")).unwrap().1;
        let sample = prim.split_once(&format!(" {name}.timeSamples = {{")).unwrap().1;
        sample.split_once('[').unwrap().1.split_once(']').unwrap().0
    }

    #[test]
    fn prims_have_topology_attributes_and_all_digits() {
        let place = Place::new("usd");
        UsdWriter.write(&place.0, 7, &full_frame()).unwrap();
        assert_eq!(place.files(), ["frame_0007.usda", "run.usda"]);
        let text = place.text("frame_0007.usda");
        assert!(text.starts_with("#usda 1.0\n(\n"));
        assert!(text.contains("metersPerUnit = 1\n") && text.contains("upAxis = \"Z\"\n"));
        assert!(text.contains("meniscus:time.timeSamples = {\n        7: 0.30000000000000004,\n"));
        assert_eq!(values(&text, "liquid", "faceVertexCounts"), "3, 3, 3, 3");
        assert_eq!(values(&text, "liquid", "primvars:kind"), "0, 1, 2, 0");
        let indices = values(&text, "solid_plate", "faceVertexIndices");
        assert_eq!(indices, "0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3");
        assert_eq!(values(&text, "solid_plate", "primvars:phi_c"), "-0.25, 0.5, 0.33333334, 0.0");
        assert!(values(&text, "liquid", "points").contains("(1.0, 1e-7, 0.0)"));
        assert_eq!(values(&text, "liquid", "normals").matches('(').count(), 4);
        assert_eq!(values(&text, "contact_line", "curveVertexCounts"), "3");
        assert_eq!(values(&text, "contact_line", "primvars:angle"), "89.5, 90.0, 91.25");
        assert!(text.contains("string unit = \"deg\""));
        assert!(text.contains("inputs:ior = 1.333\n"));
        assert_eq!(text.matches('{').count(), text.matches('}').count());
    }

    #[test]
    fn velocities_are_those_of_the_playback_in_the_unit_of_the_positions() {
        let (place, mut frame) = (Place::new("usd-velocities"), full_frame());
        let component = |name, value| Attribute::known(name, vec![value; 4]);
        frame.liquid.attributes.extend([component("vx", 2.0), component("vy", 0.0), component("vz", -0.5)]);
        // Half a second from frame to frame is a 24th of a second of playback, and 100 units are a metre: 2 m/s are 2400 units a second.
        frame.interval = Some(0.5);
        UsdWriter.write(&place.0, 1, &frame.placed(100.0, 2)).unwrap();
        let text = place.text("frame_0001.usda");
        assert!(text.contains("metersPerUnit = 0.01\n"));
        assert!(values(&text, "liquid", "velocities").starts_with("(2400.0, 0.0, -600.0), "));
        assert_eq!(values(&text, "liquid", "primvars:vx"), "2.0, 2.0, 2.0, 2.0");
        assert!(!text.split_once("\"contact_line\"").unwrap().1.contains("velocities"));
    }

    #[test]
    fn names_are_identifiers_and_differ() {
        let place = Place::new("usd-names");
        let mut frame = full_frame();
        let mesh = frame.solids[0].1.clone();
        frame.solids = vec![("a-b".into(), mesh.clone()), ("a.b".into(), mesh)];
        UsdWriter.write(&place.0, 0, &frame).unwrap();
        let text = place.text("frame_0000.usda");
        assert!(text.contains("def Mesh \"solid_a_b\"") && text.contains("def Mesh \"solid_a_b_2\""));
        assert!(text.contains("displayName = \"solid_a.b\""));
    }

    #[test]
    fn flat_frames_are_curves_and_points() {
        let place = Place::new("usd-flat");
        let mut frame = full_frame();
        frame.up_axis = 1;
        for mesh in frame.solids.iter_mut().map(|(_, mesh)| mesh).chain([&mut frame.liquid]) {
            mesh.triangles.clear();
            mesh.edges = vec![[2, 0], [1, 2], [0, 1]];
        }
        frame.contact_line.as_mut().unwrap().edges.clear();
        UsdWriter.write(&place.0, 0, &frame).unwrap();
        let text = place.text("frame_0000.usda");
        assert!(text.contains("def BasisCurves \"liquid\"") && text.contains("def Points \"contact_line\""));
        assert!(text.contains("upAxis = \"Y\""));
        // A closed curve ends with its first vertex, and attributes are in the order of the curve.
        assert_eq!(values(&text, "liquid", "curveVertexCounts"), "4");
        assert_eq!(values(&text, "liquid", "primvars:kind"), "2, 0, 1, 2");
        assert_eq!(values(&text, "contact_line", "primvars:solid"), "0, 0, 0");
    }

    #[test]
    fn the_root_plays_all_frames_of_the_folder() {
        let place = Place::new("usd-root");
        for number in [0, 1, 3] {
            UsdWriter.write(&place.0, number, &full_frame()).unwrap();
        }
        let text = place.text("run.usda");
        assert!(text.contains("[@./frame_0000.usda@, @./frame_0001.usda@, @./frame_0003.usda@]"));
        assert!(text.contains("double2[] active = [(0, 0), (1, 1), (3, 2)]"));
        assert!(text.contains("double2[] times = [(0, 0), (1, 0), (1, 1), (3, 1), (3, 3)]"));
        assert!(text.contains("startTimeCode = 0\n") && text.contains("endTimeCode = 3\n"));
        assert!(!text.contains("timeSamples"));
        // A resumed run removes the root and the frames that it writes again.
        place.0.remove_frames_from(1).unwrap();
        assert_eq!(place.files(), ["frame_0000.usda"]);
        UsdWriter.write(&place.0, 1, &empty_frame()).unwrap();
        let text = place.text("run.usda");
        assert!(text.contains("[@./frame_0000.usda@, @./frame_0001.usda@]"));
        assert!(text.contains("float[] primvars:angle"));
        let text = place.text("frame_0001.usda");
        assert_eq!((values(&text, "liquid", "points"), values(&text, "contact_line", "points")), ("", ""));
    }
}
