//! Fields on the grid as OpenVDB volumes, for Houdini, Blender and renderers.
//!
//! `phi` is a level set: the signed distance to the liquid's surface within a band of three cells to both sides, single precision.
//! `velocity` is a grid of vectors at the centres of the cells, the same places as those of `phi`, in the liquid and in the band. Where
//! liquid touches an end of the grid its surface is closed there, so that the level set has no hole. Limit: three dimensions only.

mod file;
mod tree;

use self::file::{File, Grid, Value};
use self::tree::{Tree, Voxel};
use crate::output::frame::{Frame, FrameFields, FrameParts, FrameWriter};
use crate::output::{FileError, Folder, atomic_file};
use std::io::Write;
use std::path::PathBuf;

/// Half the width of the band of a level set, in cells; the width that OpenVDB's own tools use.
const BAND_CELLS: f32 = 3.0;

/// Writes `fields_NNNN.vdb` with the grids `phi` and `velocity`. Nothing where a frame has no fields, or two dimensions.
#[derive(Clone, Copy, Debug)]
pub struct VdbWriter;

impl FrameWriter for VdbWriter {
    fn write(&self, folder: &Folder, number: u64, frame: &Frame) -> Result<PathBuf, FileError> {
        let volumes = frame.fields.as_ref().filter(|f| f.extent[2] > 1).and_then(Volumes::of);
        let Some(volumes) = volumes else { return Ok(folder.frames()) };
        let path = folder.frame_file("fields", number, "vdb");
        let bytes = volumes.file(number, frame.time);
        atomic_file::write_atomically(&path, |out| out.write_all(&bytes))?;
        Ok(path)
    }

    fn parts(&self) -> FrameParts {
        FrameParts { elements: false, fields: true }
    }
}

/// The fields that are written.
struct Volumes<'a> {
    fields: &'a FrameFields,
    phi: &'a [f64],
    velocity: &'a [f64],
}

impl<'a> Volumes<'a> {
    /// The fields of a frame; `None` if one is missing.
    fn of(fields: &'a FrameFields) -> Option<Self> {
        let values = |name| fields.attributes.iter().find(|a| a.name == name).map(|a| a.values.as_slice());
        Some(Self { fields, phi: values("phi")?, velocity: values("velocity")? })
    }

    /// The bytes of the file.
    fn file(&self, number: u64, time: f64) -> Vec<u8> {
        let FrameFields { extent, first, dx, .. } = self.fields;
        let background = BAND_CELLS * *dx as f32;
        let beyond = BAND_CELLS as i32;
        let (lower, upper) = ([-beyond; 3], extent.map(|n| n as i32 + beyond));
        let phi = Tree::new([lower, upper], background, |at| {
            let value = self.closed_phi(at) as f32;
            if value.abs() < background {
                return Voxel::Active(value);
            }
            if value < 0.0 { Voxel::Inside } else { Voxel::Outside }
        });
        let velocity = Tree::new([[0; 3], extent.map(|n| n as i32)], [0.0f32; 3], |at| {
            if self.closed_phi(at) as f32 >= background {
                return Voxel::Outside;
            }
            let cell = 3 * self.cell(at);
            Voxel::Active(std::array::from_fn(|a| self.velocity[cell + a] as f32))
        });
        let text = |text: &str| Value::Text(text.to_owned());
        let mut file = File::new(number, &[("time", Value::Number(time))]);
        let class = [("class", text("level set")), ("unit", text("m"))];
        file.add(&Grid { name: "phi", metadata: &class, dx: *dx, first: *first }, &phi);
        let class = [
            ("class", text("unknown")),
            ("unit", text("m/s")),
            ("vector_type", text("contravariant relative")),
        ];
        file.add(&Grid { name: "velocity", metadata: &class, dx: *dx, first: *first }, &velocity);
        file.into_bytes()
    }

    /// Number of the cell at these coordinates, or of the nearest one.
    fn cell(&self, at: [i32; 3]) -> usize {
        let [nx, ny, nz] = self.fields.extent;
        let within = |x: i32, n: usize| (x.max(0) as usize).min(n.saturating_sub(1));
        (within(at[2], nz) * ny + within(at[1], ny)) * nx + within(at[0], nx)
    }

    /// The larger of φ and of the distance to the box of all cells, m.
    fn closed_phi(&self, at: [i32; 3]) -> f64 {
        let FrameFields { extent, dx, .. } = self.fields;
        let off: [f64; 3] = std::array::from_fn(|a| {
            let x = f64::from(at[a]) + 0.5;
            (-x).max(x - extent[a] as f64)
        });
        let outside = off.iter().map(|x| x.max(0.0).powi(2)).sum::<f64>().sqrt();
        let inside = off.into_iter().fold(f64::NEG_INFINITY, f64::max).min(0.0);
        self.phi[self.cell(at)].max((outside + inside) * dx)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::frame::Attribute;
    use crate::output::frame::formats::tests::{Place, empty_frame};

    /// A ball of radius 5 cells in 20 × 16 × 16 cells, which the end of the first axis cuts.
    fn ball() -> FrameFields {
        let (extent, dx) = ([20, 16, 16], 0.25);
        let mut phi = Vec::new();
        for n in 0..20 * 16 * 16 {
            let [x, y, z] = [n % 20, n / 20 % 16, n / 320].map(|i| i as f64 + 0.5);
            phi.push(((x - 3.0).powi(2) + (y - 8.0).powi(2) + (z - 8.0).powi(2)).sqrt() * dx - 5.0 * dx);
        }
        let velocity = (0..3 * phi.len()).map(|i| i as f64).collect();
        let attributes =
            vec![Attribute::new("phi", "m", "", phi), Attribute::new("velocity", "m/s", "", velocity)];
        FrameFields { extent, first: [0.125; 3], dx, attributes }
    }

    #[test]
    fn the_level_set_is_closed_at_the_ends_of_the_grid() {
        let fields = ball();
        let volumes = Volumes::of(&fields).unwrap();
        let middle = |x: i32| volumes.closed_phi([x, 8, 8]) / fields.dx;
        assert!((middle(0) + 0.5).abs() < 1e-12 && (middle(-1) - 0.5).abs() < 1e-12);
        assert!((middle(-3) - 2.5).abs() < 1e-12);
        // Away from the end it is φ itself.
        assert_eq!(volumes.closed_phi([7, 8, 8]), volumes.phi[volumes.cell([7, 8, 8])]);
        let at_corner = volumes.closed_phi([-1, -1, -1]) / fields.dx;
        assert!(at_corner >= 0.75f64.sqrt());
    }

    #[test]
    fn files_have_two_grids_whose_offsets_hold() {
        let place = Place::new("vdb");
        let frame = Frame { time: 0.25, fields: Some(ball()), ..empty_frame() };
        VdbWriter.write(&place.0, 3, &frame).unwrap();
        let flat = FrameFields { extent: [2, 1, 1], ..FrameFields::default() };
        VdbWriter.write(&place.0, 4, &Frame { fields: Some(flat), ..empty_frame() }).unwrap();
        VdbWriter.write(&place.0, 5, &empty_frame()).unwrap();
        assert_eq!(place.files(), ["fields_0003.vdb"]);
        let bytes = std::fs::read(place.path("fields_0003.vdb")).unwrap();
        let long = |at: usize| i64::from_le_bytes(bytes[at..at + 8].try_into().unwrap()) as usize;
        assert_eq!((long(0), bytes[8], bytes[20]), (0x5644_4220, 224, 1));
        let find = |text: &str| {
            bytes.windows(text.len()).position(|window| window == text.as_bytes()).unwrap() + text.len()
        };
        // Behind the type of a grid stand the length of an empty name and three offsets.
        let [phi, velocity] = ["Tree_float_5_4_3", "Tree_vec3s_5_4_3"].map(|kind| find(kind) + 4);
        assert_eq!(long(phi), phi + 24);
        assert!(long(phi) < long(phi + 8) && long(phi + 8) < long(phi + 16));
        assert_eq!((long(velocity), long(velocity + 16)), (velocity + 24, bytes.len()));
    }
}
