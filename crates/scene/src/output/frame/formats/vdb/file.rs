//! An OpenVDB file: a head, metadata, and for each grid its description, transform, topology and values.
//!
//! Source: OpenVDB 10, `openvdb/io/Archive.cc`, `GridDescriptor.cc`, `openvdb/math/Maps.h`. Numbers are little-endian. A text is its length
//! and its bytes. A grid stands behind the places of its own start, of its values and of its end in the file.

use super::tree::{Stored, Tree};

/// `VDB ` as a number.
const MAGIC: i64 = 0x5644_4220;
/// Version of the format.
const FORMAT: u32 = 224;
/// Version of the library whose format it is.
const LIBRARY: [u32; 2] = [10, 0];
/// Compression of values: zlib, and active values only.
const COMPRESSION: u32 = 1 | 2;

/// A value of metadata.
pub(super) enum Value {
    /// A text.
    Text(String),
    /// A number of double precision.
    Number(f64),
}

/// Description of a grid.
pub(super) struct Grid<'a> {
    /// Its name.
    pub name: &'static str,
    /// Its metadata beside the name.
    pub metadata: &'a [(&'static str, Value)],
    /// Size of a voxel, m.
    pub dx: f64,
    /// Centre of the voxel at 0, m.
    pub first: [f64; 3],
}

/// A file with its grids.
pub(super) struct File {
    bytes: Vec<u8>,
    /// Place of the number of grids.
    count_at: usize,
    count: u32,
}

impl File {
    /// A file without grids; files of frames differ in their identifier.
    pub fn new(number: u64, metadata: &[(&str, Value)]) -> Self {
        let mut bytes = Vec::new();
        bytes.extend_from_slice(&MAGIC.to_le_bytes());
        for version in [FORMAT, LIBRARY[0], LIBRARY[1]] {
            bytes.extend_from_slice(&version.to_le_bytes());
        }
        // The grids' places are in the file.
        bytes.push(1);
        // A UUID of version 8, whose bits are free: the same bits for the same frame.
        bytes.extend_from_slice(
            format!("6d656e69-7363-8075-8000-{:012x}", number & 0xffff_ffff_ffff).as_bytes(),
        );
        let mut file = Self { bytes, count_at: 0, count: 0 };
        let creator = Value::Text(concat!("Meniscus ", env!("CARGO_PKG_VERSION")).to_owned());
        file.metadata(metadata.iter().map(|(key, value)| (*key, value)).chain([("creator", &creator)]));
        file.count_at = file.bytes.len();
        file.number(0);
        file
    }

    /// Adds a grid.
    pub fn add<T: Stored>(&mut self, grid: &Grid<'_>, tree: &Tree<T>) {
        let Grid { name, metadata, .. } = grid;
        self.text(name);
        self.text(&format!("Tree_{}_5_4_3", T::NAME));
        // No other grid shares its tree.
        self.text("");
        let places_at = self.bytes.len();
        self.bytes.extend_from_slice(&[0; 24]);
        let start = self.bytes.len();
        self.number(COMPRESSION);
        let shown = Value::Text((*name).to_owned());
        self.metadata(metadata.iter().map(|(key, value)| (*key, value)).chain([("name", &shown)]));
        self.transform(grid);
        tree.put_topology(&mut self.bytes);
        let values = self.bytes.len();
        tree.put_values(&mut self.bytes);
        let places = [start, values, self.bytes.len()];
        let places: Vec<u8> = places.iter().flat_map(|place| (*place as i64).to_le_bytes()).collect();
        self.bytes[places_at..places_at + 24].copy_from_slice(&places);
        self.count += 1;
        self.bytes[self.count_at..self.count_at + 4].copy_from_slice(&self.count.to_le_bytes());
    }

    /// The bytes.
    pub fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }

    fn number(&mut self, number: u32) {
        self.bytes.extend_from_slice(&number.to_le_bytes());
    }

    fn text(&mut self, text: &str) {
        self.number(text.len() as u32);
        self.bytes.extend_from_slice(text.as_bytes());
    }

    fn metadata<'a>(&mut self, entries: impl Iterator<Item = (&'a str, &'a Value)> + Clone) {
        self.number(entries.clone().count() as u32);
        for (key, value) in entries {
            self.text(key);
            match value {
                Value::Text(text) => {
                    self.text("string");
                    self.text(text);
                }
                Value::Number(number) => {
                    self.text("double");
                    self.number(8);
                    self.bytes.extend_from_slice(&number.to_le_bytes());
                }
            }
        }
    }

    /// The transform from voxels to metres, with the factors that its reader wants of it.
    fn transform(&mut self, grid: &Grid<'_>) {
        let Grid { dx, first, .. } = grid;
        self.text("UniformScaleTranslateMap");
        let (inverse, square, half) = (1.0 / dx, 1.0 / (dx * dx), 0.5 / dx);
        let rows = [*first, [*dx; 3], [*dx; 3], [inverse; 3], [square; 3], [half; 3]];
        rows.iter().flatten().for_each(|x| self.bytes.extend_from_slice(&x.to_le_bytes()));
    }
}
