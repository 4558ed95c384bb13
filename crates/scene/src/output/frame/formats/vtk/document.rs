//! A VTK XML file with its arrays in one appended block of raw bytes.
//!
//! Source: "VTK XML Formats", docs.vtk.org. The head names each array's type, components and offset in the block. An array is its number
//! of bytes (`UInt64`) and its values, little-endian. Compressed, it is instead the number of blocks, their size, that of the last one if
//! it differs (else 0), the compressed sizes, and the LZ4 blocks.

use crate::output::frame::Attribute;
use meniscus_numerics::par;
use std::fmt::Write as _;
use std::io::{self, Write};

/// Bytes of a block before compression.
const BLOCK_BYTES: usize = 1 << 18;

/// A file that is being composed.
pub(super) struct Document {
    kind: &'static str,
    compressed: bool,
    text: String,
    data: Vec<u8>,
}

impl Document {
    /// A file of a kind such as `PolyData`, at a time, s. `meshio` reads uncompressed files only.
    pub fn new(kind: &'static str, attributes: &str, time: f64, compressed: bool) -> Self {
        let compressor = if compressed { " compressor=\"vtkLZ4DataCompressor\"" } else { "" };
        let text = format!(
            "<?xml version=\"1.0\"?>\n<!-- Meniscus {} -->\n\
             <VTKFile type=\"{kind}\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\"{compressor}>\n\
             <{kind}{attributes}>\n\
             <FieldData>\n<DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">{time:?}</DataArray>\n\
             </FieldData>\n",
            env!("CARGO_PKG_VERSION")
        );
        Self { kind, compressed, text, data: Vec::new() }
    }

    /// Adds an element with what `fill` adds in it.
    pub fn element(&mut self, tag: &str, attributes: &str, fill: impl FnOnce(&mut Self)) {
        let _ = writeln!(self.text, "<{tag}{attributes}>");
        fill(self);
        let _ = writeln!(self.text, "</{tag}>");
    }

    /// Adds an array of bytes.
    pub fn bytes(&mut self, name: &str, values: &[u8]) {
        self.array("UInt8", name, 1, "", values);
    }

    /// Adds an array of integers.
    pub fn integers(&mut self, name: &str, values: impl Iterator<Item = i64>) {
        let bytes: Vec<u8> = values.flat_map(i64::to_le_bytes).collect();
        self.array("Int64", name, 1, "", &bytes);
    }

    /// Adds positions, m.
    pub fn positions(&mut self, positions: &[[f64; 3]]) {
        let bytes: Vec<u8> = positions.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        self.array("Float64", "Points", 3, "m", &bytes);
    }

    /// Adds an attribute of `count` points or cells, in the type that it has in PLY files; in single precision where the file is
    /// compressed.
    pub fn attribute(&mut self, attribute: &Attribute, count: usize) {
        let Attribute { name, unit, values, .. } = attribute;
        let components = values.len().checked_div(count).unwrap_or(1);
        let (kind, bytes): (_, Vec<u8>) = match &**name {
            "kind" => ("UInt8", values.iter().map(|x| *x as u8).collect()),
            "solid" => ("Int32", values.iter().flat_map(|x| (*x as i32).to_le_bytes()).collect()),
            _ if self.compressed => {
                ("Float32", values.iter().flat_map(|x| (*x as f32).to_le_bytes()).collect())
            }
            _ => ("Float64", values.iter().flat_map(|x| x.to_le_bytes()).collect()),
        };
        self.array(kind, name, components, unit, &bytes);
    }

    fn array(&mut self, kind: &str, name: &str, components: usize, unit: &str, bytes: &[u8]) {
        let (name, unit, offset) = (escaped(name), escaped(unit), self.data.len());
        // `meshio` makes a matrix with one column of an array with a number of components.
        let components =
            if components == 1 { String::new() } else { format!(" NumberOfComponents=\"{components}\"") };
        let _ = write!(
            self.text,
            "<DataArray type=\"{kind}\" Name=\"{name}\"{components} format=\"appended\" offset=\"{offset}\""
        );
        let _ = match &*unit {
            "" | "1" => writeln!(self.text, "/>"),
            unit => writeln!(
                self.text,
                "><InformationKey name=\"UNITS_LABEL\" location=\"vtkDataArray\">{unit}</InformationKey></DataArray>"
            ),
        };
        if self.compressed {
            self.append_compressed(bytes);
        } else {
            self.append_number(bytes.len());
            self.data.extend_from_slice(bytes);
        }
    }

    fn append_number(&mut self, number: usize) {
        self.data.extend_from_slice(&(number as u64).to_le_bytes());
    }

    fn append_compressed(&mut self, bytes: &[u8]) {
        let blocks = par::map_jobs(bytes.chunks(BLOCK_BYTES).collect(), lz4_flex::block::compress);
        for number in [blocks.len(), BLOCK_BYTES, bytes.len() % BLOCK_BYTES] {
            self.append_number(number);
        }
        blocks.iter().for_each(|block| self.append_number(block.len()));
        blocks.iter().for_each(|block| self.data.extend_from_slice(block));
    }

    /// Writes the file.
    pub fn write(&self, out: &mut impl Write) -> io::Result<()> {
        write!(out, "{}</{}>\n<AppendedData encoding=\"raw\">\n_", self.text, self.kind)?;
        out.write_all(&self.data)?;
        out.write_all(b"\n</AppendedData>\n</VTKFile>\n")
    }
}

/// Text for an attribute or the content of an element.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}

#[cfg(test)]
pub(in crate::output::frame::formats) mod tests {
    use super::*;

    /// The value of an attribute of the first element that contains `element` in its tag.
    pub fn attribute_of(head: &str, element: &str, attribute: &str) -> String {
        let start = head.find(element).unwrap_or_else(|| panic!("{element} in {head}"));
        let tag_start = head[..start].rfind('<').unwrap();
        let tag = &head[tag_start..tag_start + head[tag_start..].find('>').unwrap()];
        let value =
            tag.split(&format!("{attribute}=\"")).nth(1).unwrap_or_else(|| panic!("{attribute} in {tag}"));
        value.split('"').next().unwrap().to_owned()
    }

    /// Head and appended bytes of a file.
    pub fn parts(file: &[u8]) -> (String, Vec<u8>) {
        let mark = b"<AppendedData encoding=\"raw\">\n_";
        let end = b"\n</AppendedData>\n</VTKFile>\n";
        let at = file.windows(mark.len()).position(|w| w == mark).unwrap();
        assert!(file.ends_with(end));
        let data = file[at + mark.len()..file.len() - end.len()].to_vec();
        (String::from_utf8(file[..at].to_vec()).unwrap(), data)
    }

    /// The bytes of an array of an uncompressed file.
    pub fn array(file: &[u8], name: &str) -> Vec<u8> {
        let (head, data) = parts(file);
        let offset: usize = attribute_of(&head, &format!("Name=\"{name}\""), "offset").parse().unwrap();
        let length = u64::from_le_bytes(data[offset..offset + 8].try_into().unwrap()) as usize;
        data[offset + 8..offset + 8 + length].to_vec()
    }

    pub fn doubles(bytes: &[u8]) -> Vec<f64> {
        bytes.chunks(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect()
    }

    pub fn longs(bytes: &[u8]) -> Vec<i64> {
        bytes.chunks(8).map(|b| i64::from_le_bytes(b.try_into().unwrap())).collect()
    }

    #[test]
    fn compressed_arrays_come_back() {
        let values: Vec<f64> = (0..150_000).map(|i| f64::from(i % 1000)).collect();
        let mut document = Document::new("ImageData", "", 0.5, true);
        document.attribute(&Attribute::new("phi", "m", "", values.clone()), values.len());
        let mut file = Vec::new();
        document.write(&mut file).unwrap();
        let (head, data) = parts(&file);
        assert_eq!(attribute_of(&head, "\"phi\"", "type"), "Float32");
        let number = |k: usize| u64::from_le_bytes(data[8 * k..8 * k + 8].try_into().unwrap()) as usize;
        let (blocks, last) = (number(0), number(2));
        assert_eq!((blocks, number(1), last), (3, BLOCK_BYTES, 4 * values.len() - 2 * BLOCK_BYTES));
        let (mut at, mut bytes) = (8 * (3 + blocks), Vec::new());
        for k in 0..blocks {
            let size = if k + 1 == blocks { last } else { BLOCK_BYTES };
            bytes.extend(lz4_flex::block::decompress(&data[at..at + number(3 + k)], size).unwrap());
            at += number(3 + k);
        }
        let back: Vec<f64> =
            bytes.chunks(4).map(|b| f64::from(f32::from_le_bytes(b.try_into().unwrap()))).collect();
        assert_eq!((back, at), (values, data.len()));
    }
}
