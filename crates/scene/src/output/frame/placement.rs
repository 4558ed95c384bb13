//! Scale and orientation of a frame, for programs with another unit of length or another axis that points up.

use super::known::VELOCITIES;
use super::{Attribute, Frame, FrameMesh};

/// Attributes that are vectors, by their components.
const VECTORS: [[&str; 3]; 3] = [["ux", "uy", "uz"], ["fx", "fy", "fz"], VELOCITIES];

impl Frame {
    /// The frame with all positions multiplied by `scale` and turned so that the axis `up` (1 or 2) points up. Components of vectors
    /// turn with it; values keep their unit. Elements and fields are left out.
    ///
    /// The rotation is about the first axis: from z up to y up, `(x, y, z) → (x, z, −y)`.
    #[must_use]
    pub fn placed(mut self, scale: f64, up: usize) -> Self {
        let from = self.up_axis;
        let turn = |[x, y, z]: [f64; 3]| match (from, up) {
            (2, 1) => [x, z, -y],
            (1, 2) => [x, -z, y],
            _ => [x, y, z],
        };
        let meshes = self.solids.iter_mut().map(|(_, mesh)| mesh);
        for mesh in meshes.chain(&mut self.contact_line).chain([&mut self.liquid]) {
            mesh.positions.iter_mut().for_each(|x| *x = turn(*x).map(|x| x * scale));
            VECTORS.iter().for_each(|names| turn_vectors(mesh, names, turn));
        }
        (self.up_axis, self.unit) = (up, self.unit / scale);
        (self.elements, self.fields) = (Vec::new(), None);
        self
    }
}

/// Turns the vectors whose components have these names; nothing if one is missing.
fn turn_vectors(mesh: &mut FrameMesh, names: &[&str; 3], turn: impl Fn([f64; 3]) -> [f64; 3]) {
    let place = |name: &&str| mesh.attributes.iter().position(|a: &Attribute| a.name == **name);
    let [Some(x), Some(y), Some(z)] = [&names[0], &names[1], &names[2]].map(place) else { return };
    for v in 0..mesh.positions.len() {
        let turned = turn([x, y, z].map(|a| mesh.attributes[a].values[v]));
        [x, y, z].into_iter().zip(turned).for_each(|(a, value)| mesh.attributes[a].values[v] = value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_and_vectors_turn_and_values_keep_their_unit() {
        let attribute = |name, value| Attribute::known(name, vec![value]);
        let mesh = FrameMesh {
            positions: vec![[1.0, 2.0, 3.0]],
            attributes: vec![
                attribute("phi_c", 0.5),
                attribute("ux", 1.0),
                attribute("uy", 2.0),
                attribute("uz", 3.0),
            ],
            ..FrameMesh::default()
        };
        let solids = vec![("a".into(), mesh.clone())];
        let frame = Frame { liquid: mesh, solids, ..Frame::empty(2) };
        let placed = frame.clone().placed(10.0, 1);
        assert_eq!(placed.liquid.positions, [[10.0, 30.0, -20.0]]);
        let values: Vec<f64> = placed.solids[0].1.attributes.iter().map(|a| a.values[0]).collect();
        assert_eq!((values, placed.up_axis), (vec![0.5, 1.0, 3.0, -2.0], 1));
        assert_eq!([placed.unit_text("m"), frame.unit_text("m")], ["0.1 m", "m"]);
        assert_eq!(placed.placed(0.1, 2), frame);
    }
}
