//! Each frame as one binary glTF file.
//!
//! Source: glTF 2.0 (ISO/IEC 12113). A file is a header, a JSON chunk and a chunk of binary data. The format is in metres with y up, so
//! a root node turns a frame whose third axis points up. Positions are in single precision.

use crate::output::frame::{Attribute, Frame, FrameMesh, FrameWriter};
use crate::output::{FileError, Folder, atomic_file};
use serde_json::{Value, json};
use std::io::{self, Write};
use std::path::PathBuf;

/// `ARRAY_BUFFER` and `ELEMENT_ARRAY_BUFFER`.
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;
/// Types of components.
const BYTE: u32 = 5121;
const UNSIGNED: u32 = 5125;
const FLOAT: u32 = 5126;
/// Modes of primitives.
const POINTS: u32 = 0;
const LINES: u32 = 1;
const TRIANGLES: u32 = 4;

/// Colours: liquid by `kind`, dry and wetted solid, contact line.
const LIQUID: [[u8; 4]; 3] = [[90, 160, 220, 255], [50, 105, 175, 255], [20, 60, 120, 255]];
const DRY: [u8; 4] = [190, 185, 178, 255];
const WETTED: [u8; 4] = [120, 145, 170, 255];
const LINE: [u8; 4] = [210, 40, 40, 255];

/// Writes `frame_NNNN.glb` with the meshes `liquid`, `solid_NAME` and `contact_line`: positions, normals, indices, colours, and every
/// attribute as `_NAME`.
#[derive(Clone, Copy, Debug)]
pub struct GlbWriter;

impl FrameWriter for GlbWriter {
    fn write(&self, folder: &Folder, number: u64, frame: &Frame) -> Result<PathBuf, FileError> {
        let path = folder.frame_file("frame", number, "glb");
        let file = GltfFile::of(frame);
        atomic_file::write_atomically(&path, |out| file.write(out))?;
        Ok(path)
    }
}

/// Parts of a file.
#[derive(Default)]
struct GltfFile {
    root: Value,
    nodes: Vec<Value>,
    meshes: Vec<Value>,
    accessors: Vec<Value>,
    views: Vec<Value>,
    data: Vec<u8>,
}

impl GltfFile {
    fn of(frame: &Frame) -> Self {
        let mut file = Self::default();
        file.mesh("liquid", &frame.liquid, 0, &liquid_colors(&frame.liquid));
        for (name, mesh) in &frame.solids {
            file.mesh(&format!("solid_{name}"), mesh, 1, &solid_colors(mesh));
        }
        if let Some(line) = &frame.contact_line {
            file.mesh("contact_line", line, 2, &vec![LINE; line.positions.len()]);
        }
        let children: Vec<usize> = (1..=file.nodes.len()).collect();
        file.root =
            json!({ "name": "frame", "extras": { "time": frame.time, "unit": frame.unit_text("metre") } });
        if !children.is_empty() {
            file.root["children"] = json!(children);
        }
        if frame.up_axis == 2 {
            let half = std::f64::consts::FRAC_1_SQRT_2;
            file.root["rotation"] = json!([-half, 0.0, 0.0, half]);
        }
        file
    }

    fn mesh(&mut self, name: &str, mesh: &FrameMesh, material: usize, colors: &[[u8; 4]]) {
        let count = mesh.positions.len();
        if count == 0 {
            return;
        }
        let mut attributes = json!({ "POSITION": self.positions(&mesh.positions) });
        let mut primitive = json!({ "material": material });
        if !mesh.triangles.is_empty() {
            attributes["NORMAL"] = self.floats(mesh.normals().into_iter().flatten(), count, "VEC3").into();
        }
        attributes["COLOR_0"] = self.colors(colors).into();
        for Attribute { name, values, .. } in &mesh.attributes {
            attributes[format!("_{}", name.to_uppercase())] =
                self.floats(values.iter().copied(), count, "SCALAR").into();
        }
        let (mode, indices): (u32, Vec<u32>) = match (&mesh.triangles[..], &mesh.edges[..]) {
            ([], []) => (POINTS, Vec::new()),
            ([], edges) => (LINES, edges.iter().flatten().copied().collect()),
            (triangles, _) => (TRIANGLES, triangles.iter().flatten().copied().collect()),
        };
        primitive["mode"] = mode.into();
        if !indices.is_empty() {
            let bytes: Vec<u8> = indices.iter().flat_map(|v| v.to_le_bytes()).collect();
            let view = self.view(&bytes, INDICES);
            let accessor = json!({ "bufferView": view, "componentType": UNSIGNED, "count": indices.len(), "type": "SCALAR" });
            primitive["indices"] = self.accessor(accessor).into();
        }
        primitive["attributes"] = attributes;
        let unit = |a: &Attribute| (a.name.to_string(), Value::from(a.unit.as_ref()));
        let units: serde_json::Map<String, Value> = mesh.attributes.iter().map(unit).collect();
        self.nodes.push(json!({ "name": name, "mesh": self.meshes.len(), "extras": { "units": units } }));
        self.meshes.push(json!({ "name": name, "primitives": [primitive] }));
    }

    fn positions(&mut self, positions: &[[f64; 3]]) -> usize {
        let accessor = self.floats(positions.iter().flatten().copied(), positions.len(), "VEC3");
        let bound = |start: f32, of: fn(f32, f32) -> f32| {
            let axis = |k: usize| positions.iter().map(|x| x[k] as f32).fold(start, of);
            [axis(0), axis(1), axis(2)]
        };
        self.accessors[accessor]["min"] = json!(bound(f32::INFINITY, f32::min));
        self.accessors[accessor]["max"] = json!(bound(f32::NEG_INFINITY, f32::max));
        accessor
    }

    fn floats(&mut self, values: impl Iterator<Item = f64>, count: usize, kind: &str) -> usize {
        let bytes: Vec<u8> = values.flat_map(|x| (x as f32).to_le_bytes()).collect();
        let view = self.view(&bytes, VERTICES);
        self.accessor(json!({ "bufferView": view, "componentType": FLOAT, "count": count, "type": kind }))
    }

    fn colors(&mut self, colors: &[[u8; 4]]) -> usize {
        let view = self.view(&colors.concat(), VERTICES);
        let count = colors.len();
        let accessor = json!({ "bufferView": view, "componentType": BYTE, "normalized": true, "count": count, "type": "VEC4" });
        self.accessor(accessor)
    }

    fn accessor(&mut self, accessor: Value) -> usize {
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// A part of the binary data; all parts have a multiple of four bytes.
    fn view(&mut self, bytes: &[u8], target: u32) -> usize {
        let offset = self.data.len();
        self.views
            .push(json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len(), "target": target }));
        self.data.extend_from_slice(bytes);
        self.views.len() - 1
    }

    fn write(&self, out: &mut impl Write) -> io::Result<()> {
        let mut nodes = vec![self.root.clone()];
        nodes.extend_from_slice(&self.nodes);
        let generator = concat!("Meniscus ", env!("CARGO_PKG_VERSION"));
        let mut document = json!({
            "asset": { "version": "2.0", "generator": generator }, "scene": 0, "scenes": [{ "nodes": [0] }],
            "nodes": nodes, "materials": [material("liquid", 0.1), material("solid", 0.9), material("line", 1.0)],
        });
        if !self.meshes.is_empty() {
            document["meshes"] = json!(self.meshes);
            document["accessors"] = json!(self.accessors);
            document["bufferViews"] = json!(self.views);
            document["buffers"] = json!([{ "byteLength": self.data.len() }]);
        }
        let mut text = document.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let binary = if self.data.is_empty() { 0 } else { 8 + self.data.len() };
        out.write_all(b"glTF")?;
        let number = |out: &mut dyn Write, n: usize| out.write_all(&(n as u32).to_le_bytes());
        number(out, 2)?;
        number(out, 20 + text.len() + binary)?;
        number(out, text.len())?;
        out.write_all(b"JSON")?;
        out.write_all(&text)?;
        if binary > 0 {
            number(out, self.data.len())?;
            out.write_all(b"BIN\0")?;
            out.write_all(&self.data)?;
        }
        Ok(())
    }
}

fn material(name: &str, roughness: f64) -> Value {
    let surface = json!({ "metallicFactor": 0.0, "roughnessFactor": roughness });
    json!({ "name": name, "doubleSided": true, "pbrMetallicRoughness": surface })
}

fn liquid_colors(mesh: &FrameMesh) -> Vec<[u8; 4]> {
    match mesh.values("kind") {
        Some(kind) => kind.iter().map(|k| LIQUID[(*k as usize).min(2)]).collect(),
        None => vec![LIQUID[0]; mesh.positions.len()],
    }
}

fn solid_colors(mesh: &FrameMesh) -> Vec<[u8; 4]> {
    match mesh.values("phi_c") {
        Some(phi_c) => phi_c.iter().map(|x| if *x < 0.0 { WETTED } else { DRY }).collect(),
        None => vec![DRY; mesh.positions.len()],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::frame::formats::tests::{Place, empty_frame, full_frame};

    /// The document and the binary data of a file.
    fn read(place: &Place, file: &str) -> (Value, Vec<u8>) {
        let bytes = std::fs::read(place.path(file)).unwrap();
        let number = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        assert_eq!((&bytes[..4], number(4), number(8)), (&b"glTF"[..], 2, bytes.len()));
        let end = 20 + number(12);
        assert!(end.is_multiple_of(4));
        let data = if bytes.len() > end { bytes[end + 8..].to_vec() } else { Vec::new() };
        (serde_json::from_slice(&bytes[20..end]).unwrap(), data)
    }

    /// The bytes of an accessor.
    fn bytes_of(document: &Value, data: &[u8], accessor: &Value) -> Vec<u8> {
        let accessor = &document["accessors"][accessor.as_u64().unwrap() as usize];
        let view = &document["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let [at, n] = ["byteOffset", "byteLength"].map(|key| view[key].as_u64().unwrap() as usize);
        data[at..at + n].to_vec()
    }

    #[test]
    fn meshes_come_back() {
        let (place, frame) = (Place::new("glb"), full_frame());
        GlbWriter.write(&place.0, 0, &frame).unwrap();
        GlbWriter.write(&place.0, 1, &empty_frame()).unwrap();
        assert!(read(&place, "frame_0001.glb").0.get("meshes").is_none());
        let (document, data) = read(&place, "frame_0000.glb");
        assert_eq!(document["nodes"][0]["children"], json!([1, 2, 3]));
        assert_eq!(document["nodes"][0]["extras"]["time"], 0.1 + 0.2);
        let solid = &document["meshes"][1]["primitives"][0];
        let floats = |accessor: &Value| -> Vec<f32> {
            let bytes = bytes_of(&document, &data, accessor);
            bytes.chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect()
        };
        let single = |values: &[f64]| values.iter().map(|x| *x as f32).collect::<Vec<f32>>();
        let mesh = &frame.solids[0].1;
        assert_eq!(floats(&solid["attributes"]["POSITION"]), single(&mesh.positions.concat()));
        assert_eq!(floats(&solid["attributes"]["_PHI_C"]), single(mesh.values("phi_c").unwrap()));
        assert_eq!(floats(&solid["attributes"]["NORMAL"]).len(), 12);
        assert_eq!(bytes_of(&document, &data, &solid["attributes"]["COLOR_0"])[..4], WETTED);
        let indices = bytes_of(&document, &data, &solid["indices"]);
        assert_eq!((indices[4], solid["mode"].as_u64()), (2, Some(4)));
        let line = &document["meshes"][2]["primitives"][0];
        assert_eq!((line["mode"].as_u64(), bytes_of(&document, &data, &line["indices"])[8]), (Some(1), 1));
        let position = &document["accessors"][solid["attributes"]["POSITION"].as_u64().unwrap() as usize];
        assert_eq!(position["max"], json!([1.0, (1.0f64 / 3.0) as f32, 1.0]));
    }
}
