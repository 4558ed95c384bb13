//! Reading and writing of surface meshes as PLY files.
//!
//! The reader accepts ASCII and binary files of either byte order with any scalar types; polygons are split into fans of
//! triangles. The writer makes binary little-endian files with positions in double precision.
//!
//! Edges are written as a property `next` of the vertices: the vertex at the end of an edge that begins there, or -1; `next_2` and so
//! on where more edges begin at one vertex. The reader also takes the element `edge` of earlier versions and of other programs. The
//! reason: `meshio` ends the program at every element but `vertex` and `face`, and faces of two vertices, which it takes as
//! lines, are an error in Blender's Sequence Loader.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Content of a PLY file: vertices, triangles, edges and values per vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlyMesh {
    /// Vertex positions (m); in 2D the third coordinate is 0.
    pub positions: Vec<[f64; 3]>,
    /// Triangles, as vertex indices.
    pub faces: Vec<[u32; 3]>,
    /// Edges, as vertex indices.
    pub edges: Vec<[u32; 2]>,
    /// Values per vertex, by property name.
    pub scalars: BTreeMap<String, Vec<f64>>,
    /// Comment lines of the header, without the word `comment`.
    pub comments: Vec<String>,
}

/// Error of reading or writing a PLY file.
#[derive(Debug, thiserror::Error)]
pub enum PlyError {
    /// The file could not be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The content is not a PLY mesh.
    #[error("{}: the file is not a readable PLY file: {what}", path.display())]
    Format {
        /// The file; `<memory>` if the bytes did not come from one.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
}

impl PlyMesh {
    /// Reads a file.
    pub fn load(path: &Path) -> Result<Self, PlyError> {
        let bytes = std::fs::read(path).map_err(|source| PlyError::Io { path: path.into(), source })?;
        parse(&bytes).map_err(|what| PlyError::Format { path: path.into(), what })
    }

    /// Reads a mesh from the bytes of a file.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, PlyError> {
        parse(bytes).map_err(|what| PlyError::Format { path: "<memory>".into(), what })
    }

    /// Writes a binary little-endian file, first under a temporary name in the same folder.
    pub fn save(&self, path: &Path) -> Result<(), PlyError> {
        let fail = |source| PlyError::Io { path: path.into(), source };
        let mut bytes = Vec::new();
        self.write(&mut bytes).map_err(fail)?;
        let beside = path.with_extension("ply.part");
        std::fs::write(&beside, &bytes).map_err(fail)?;
        std::fs::rename(&beside, path).map_err(fail)
    }

    /// Writes the mesh, binary little-endian. The values `kind` become `uchar`, `solid` becomes `int`, normals `nx`,
    /// `ny`, `nz` become `float`, all others `double`; missing values at the end of an array are 0. Edges are ordered by their first vertex when they are read back.
    pub fn write(&self, out: &mut impl Write) -> io::Result<()> {
        let mut head = String::from("ply\nformat binary_little_endian 1.0\n");
        for c in &self.comments {
            head += &format!("comment {}\n", c.replace(['\n', '\r'], " "));
        }
        head += &format!("element vertex {}\n", self.positions.len());
        head += "property double x\nproperty double y\nproperty double z\n";
        for name in self.scalars.keys() {
            head += &format!("property {} {}\n", scalar_type(name), name.replace(char::is_whitespace, "_"));
        }
        let next = self.next_vertices();
        for k in 1..=next.len() {
            head += &if k == 1 { "property int next\n".into() } else { format!("property int next_{k}\n") };
        }
        head += &format!("element face {}\nproperty list uchar int vertex_indices\n", self.faces.len());
        head += "end_header\n";
        out.write_all(head.as_bytes())?;
        out.write_all(&self.body(&next))
    }

    /// The ends of the edges that begin at each vertex, or -1: the first of each, the second of each, and so on.
    fn next_vertices(&self) -> Vec<Vec<i32>> {
        let mut all: Vec<Vec<i32>> = Vec::new();
        let mut count = vec![0; self.positions.len()];
        for [from, to] in &self.edges {
            let from = *from as usize;
            if count[from] == all.len() {
                all.push(vec![-1; self.positions.len()]);
            }
            all[count[from]][from] = *to as i32;
            count[from] += 1;
        }
        all
    }

    /// The time (s) in a comment `time T`, if there is one.
    pub fn time(&self) -> Option<f64> {
        self.comments.iter().find_map(|c| c.strip_prefix("time ")?.trim().parse().ok())
    }

    /// The bytes after the header.
    fn body(&self, next: &[Vec<i32>]) -> Vec<u8> {
        let per_vertex = 24 + 8 * self.scalars.len() + 4 * next.len();
        let mut b = Vec::with_capacity(self.positions.len() * per_vertex + self.faces.len() * 13);
        for (v, p) in self.positions.iter().enumerate() {
            p.iter().for_each(|x| b.extend_from_slice(&x.to_le_bytes()));
            for (name, values) in &self.scalars {
                let x = values.get(v).copied().unwrap_or(0.0);
                match scalar_type(name) {
                    "uchar" => b.push(x as u8),
                    "int" => b.extend_from_slice(&(x as i32).to_le_bytes()),
                    "float" => b.extend_from_slice(&(x as f32).to_le_bytes()),
                    _ => b.extend_from_slice(&x.to_le_bytes()),
                }
            }
            next.iter().for_each(|next| b.extend_from_slice(&next[v].to_le_bytes()));
        }
        for f in &self.faces {
            b.push(3);
            f.iter().for_each(|i| b.extend_from_slice(&i.to_le_bytes()));
        }
        b
    }
}

/// PLY type in which a value per vertex is written.
fn scalar_type(name: &str) -> &'static str {
    match name {
        "kind" => "uchar",
        "solid" => "int",
        "nx" | "ny" | "nz" => "float",
        _ => "double",
    }
}

/// A scalar type of the format.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn named(name: &str) -> Result<Self, String> {
        Ok(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            other => return Err(format!("unknown type `{other}`")),
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

/// A property of an element: one value, or a list with its own count.
struct Property {
    name: String,
    count: Option<Scalar>,
    value: Scalar,
}

impl Property {
    /// Whether it names the ends of edges: `next`, `next_2`, ….
    fn is_next_vertex(&self) -> bool {
        let number = self.name.strip_prefix("next_").map(|k| k.parse::<u32>().is_ok());
        let whole = !matches!(self.value, Scalar::F32 | Scalar::F64);
        self.count.is_none() && whole && number.unwrap_or(self.name == "next")
    }
}

struct Element {
    name: String,
    count: usize,
    properties: Vec<Property>,
}

#[derive(Clone, Copy, PartialEq)]
enum Encoding {
    Ascii,
    Little,
    Big,
}

struct Header {
    encoding: Encoding,
    elements: Vec<Element>,
    comments: Vec<String>,
    length: usize,
}

/// The line at `at` without its end, and the start of the next one.
fn line(bytes: &[u8], at: usize) -> Result<(&str, usize), String> {
    let rest = bytes.get(at..).unwrap_or_default();
    let end = rest.iter().position(|&b| b == b'\n').ok_or("the header does not end")?;
    let text = std::str::from_utf8(&rest[..end]).map_err(|_| "the header is not text")?;
    Ok((text.trim_end_matches('\r'), at + end + 1))
}

fn parse_header(bytes: &[u8]) -> Result<Header, String> {
    let (first, mut at) = line(bytes, 0).map_err(|_| "it does not start with `ply`")?;
    if first.trim() != "ply" {
        return Err("it does not start with `ply`".into());
    }
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    let mut comments = Vec::new();
    loop {
        let (text, next) = line(bytes, at)?;
        at = next;
        let words: Vec<&str> = text.split_whitespace().collect();
        match words.as_slice() {
            ["end_header"] => break,
            ["format", "ascii", _] => encoding = Some(Encoding::Ascii),
            ["format", "binary_little_endian", _] => encoding = Some(Encoding::Little),
            ["format", "binary_big_endian", _] => encoding = Some(Encoding::Big),
            ["comment", ..] => comments.push(text.trim_start()[7..].trim().to_string()),
            ["obj_info", ..] | [] => {}
            ["element", name, count] => {
                let count = count.parse().map_err(|_| format!("bad count in `{text}`"))?;
                elements.push(Element { name: (*name).into(), count, properties: Vec::new() });
            }
            ["property", rest @ ..] => {
                let element = elements.last_mut().ok_or("a property before any element")?;
                element.properties.push(parse_property(rest, text)?);
            }
            _ => return Err(format!("unexpected header line `{text}`")),
        }
    }
    let encoding = encoding.ok_or("no format line")?;
    Ok(Header { encoding, elements, comments, length: at })
}

fn parse_property(words: &[&str], text: &str) -> Result<Property, String> {
    match words {
        ["list", count, value, name] => Ok(Property {
            name: (*name).into(),
            count: Some(Scalar::named(count)?),
            value: Scalar::named(value)?,
        }),
        [value, name] => Ok(Property { name: (*name).into(), count: None, value: Scalar::named(value)? }),
        _ => Err(format!("unexpected header line `{text}`")),
    }
}

/// Reader of consecutive values after the header.
struct Cursor<'a> {
    bytes: &'a [u8],
    encoding: Encoding,
}

impl Cursor<'_> {
    fn next(&mut self, kind: Scalar) -> Result<f64, String> {
        if self.encoding == Encoding::Ascii { self.next_word() } else { self.next_binary(kind) }
    }

    fn next_word(&mut self) -> Result<f64, String> {
        let text = self.bytes.trim_ascii_start();
        let end = text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len());
        let (word, rest) = text.split_at(end);
        self.bytes = rest;
        if word.is_empty() {
            return Err("the file ends too early".into());
        }
        let word = String::from_utf8_lossy(word);
        word.parse().map_err(|_| format!("`{word}` is not a number"))
    }

    fn next_binary(&mut self, kind: Scalar) -> Result<f64, String> {
        let n = kind.size();
        let (head, rest) = self.bytes.split_at_checked(n).ok_or("the file ends too early")?;
        self.bytes = rest;
        let mut b = [0u8; 8];
        b[..n].copy_from_slice(head);
        if self.encoding == Encoding::Big {
            b[..n].reverse();
        }
        let [b0, b1, b2, b3, ..] = b;
        Ok(match kind {
            Scalar::I8 => f64::from(b0 as i8),
            Scalar::U8 => f64::from(b0),
            Scalar::I16 => f64::from(i16::from_le_bytes([b0, b1])),
            Scalar::U16 => f64::from(u16::from_le_bytes([b0, b1])),
            Scalar::I32 => f64::from(i32::from_le_bytes([b0, b1, b2, b3])),
            Scalar::U32 => f64::from(u32::from_le_bytes([b0, b1, b2, b3])),
            Scalar::F32 => f64::from(f32::from_le_bytes([b0, b1, b2, b3])),
            Scalar::F64 => f64::from_le_bytes(b),
        })
    }

    /// Rejects a count that the rest of the file cannot hold, before memory is allocated for it.
    fn check(&self, element: &Element) -> Result<(), String> {
        let ascii = self.encoding == Encoding::Ascii;
        let size = |p: &Property| if ascii { 1 } else { p.count.unwrap_or(p.value).size() };
        let least: usize = element.properties.iter().map(size).sum();
        let fits = element.count.checked_mul(least.max(1)).is_some_and(|n| n <= self.bytes.len());
        if fits || element.count == 0 {
            return Ok(());
        }
        Err(format!("it is too short for {} elements `{}`", element.count, element.name))
    }
}

fn parse(bytes: &[u8]) -> Result<PlyMesh, String> {
    let header = parse_header(bytes)?;
    let mut mesh = PlyMesh { comments: header.comments, ..PlyMesh::default() };
    let mut cursor = Cursor { bytes: &bytes[header.length..], encoding: header.encoding };
    for element in &header.elements {
        cursor.check(element)?;
        match element.name.as_str() {
            "vertex" => read_vertices(&mut cursor, element, &mut mesh)?,
            "face" => read_faces(&mut cursor, element, &mut mesh)?,
            "edge" => read_edges(&mut cursor, element, &mut mesh)?,
            _ => {
                for _ in 0..element.count {
                    read_row(&mut cursor, element, |_, _, _| {})?;
                }
            }
        }
    }
    let n = mesh.positions.len();
    let largest = mesh.faces.iter().flatten().chain(mesh.edges.iter().flatten()).max();
    match largest {
        Some(&i) if i as usize >= n => Err(format!("vertex {i} is named, but there are only {n}")),
        _ => Ok(mesh),
    }
}

/// Reads one element and calls `each` with (property, place in its list, value) for each value.
fn read_row(
    cursor: &mut Cursor,
    element: &Element,
    mut each: impl FnMut(usize, usize, f64),
) -> Result<(), String> {
    for (p, property) in element.properties.iter().enumerate() {
        let count = match property.count {
            None => 1,
            Some(kind) => cursor.next(kind)? as usize,
        };
        for k in 0..count {
            each(p, k, cursor.next(property.value)?);
        }
    }
    Ok(())
}

fn read_vertices(cursor: &mut Cursor, element: &Element, mesh: &mut PlyMesh) -> Result<(), String> {
    let axis = |p: &Property| ["x", "y", "z"].iter().position(|&a| a == p.name);
    let axes: Vec<Option<usize>> = element.properties.iter().map(axis).collect();
    if !axes.contains(&Some(0)) || !axes.contains(&Some(1)) {
        return Err("the vertices have no x and y".into());
    }
    let mut values: Vec<Vec<f64>> = element.properties.iter().map(|_| Vec::new()).collect();
    mesh.positions.reserve(element.count);
    for _ in 0..element.count {
        let mut point = [0.0; 3];
        read_row(cursor, element, |p, k, x| match axes[p] {
            Some(a) if k == 0 => point[a] = x,
            None if k == 0 => values[p].push(x),
            _ => {}
        })?;
        if !point.iter().all(|x| x.is_finite()) {
            return Err(format!("vertex {} is not finite", mesh.positions.len()));
        }
        mesh.positions.push(point);
    }
    for (p, values) in element.properties.iter().zip(values) {
        if p.is_next_vertex() {
            for (from, to) in values.into_iter().enumerate().filter(|(_, to)| *to != -1.0) {
                mesh.edges.push([from as u32, index(to)?]);
            }
        } else if p.count.is_none() && axis(p).is_none() {
            mesh.scalars.insert(p.name.clone(), values);
        }
    }
    mesh.edges.sort_by_key(|[from, _]| *from);
    Ok(())
}

/// A vertex index from a value of the file.
fn index(x: f64) -> Result<u32, String> {
    if x >= 0.0 && x < f64::from(u32::MAX) && x.fract() == 0.0 {
        return Ok(x as u32);
    }
    Err(format!("{x} is not a vertex"))
}

fn read_faces(cursor: &mut Cursor, element: &Element, mesh: &mut PlyMesh) -> Result<(), String> {
    let named = |p: &Property| matches!(p.name.as_str(), "vertex_indices" | "vertex_index");
    let Some(list) = element.properties.iter().position(|p| named(p) && p.count.is_some()) else {
        return if element.count == 0 { Ok(()) } else { Err("the faces have no vertex_indices".into()) };
    };
    let mut corners = Vec::new();
    mesh.faces.reserve(element.count);
    for _ in 0..element.count {
        corners.clear();
        read_row(cursor, element, |p, _, x| {
            if p == list {
                corners.push(x);
            }
        })?;
        if corners.len() < 3 {
            return Err(format!("a face has {} corners", corners.len()));
        }
        let first = index(corners[0])?;
        for pair in corners[1..].windows(2) {
            mesh.faces.push([first, index(pair[0])?, index(pair[1])?]);
        }
    }
    Ok(())
}

fn read_edges(cursor: &mut Cursor, element: &Element, mesh: &mut PlyMesh) -> Result<(), String> {
    let find = |name| element.properties.iter().position(|p| p.name == name && p.count.is_none());
    let (Some(a), Some(b)) = (find("vertex1"), find("vertex2")) else {
        return if element.count == 0 { Ok(()) } else { Err("the edges lack vertex1 and vertex2".into()) };
    };
    mesh.edges.reserve(element.count);
    for _ in 0..element.count {
        let mut ends = [-1.0; 2];
        read_row(cursor, element, |p, _, x| {
            if p == a {
                ends[0] = x;
            } else if p == b {
                ends[1] = x;
            }
        })?;
        mesh.edges.push([index(ends[0])?, index(ends[1])?]);
    }
    Ok(())
}

#[cfg(test)]
#[path = "ply_tests.rs"]
mod tests;
