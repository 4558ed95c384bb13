//! Mesh format of the page: 16-bit positions in the mesh's box, stored as differences, then gzip and base64.
//!
//! Layout before gzip, little-endian:
//! - `MESH`, vertex count, element count, corners per element (2 or 3) + 256 if kinds follow + 512, 1024, 2048, 4096 for each of
//!   [`ColorBy::STORED`] whose values follow (u32 each);
//! - lower and upper corner of the box (f32 each);
//! - per axis the low bytes, then the high bytes of the differences of successive positions (wrapping u16);
//! - differences of successive vertex indices as zigzag LEB128;
//! - one byte per vertex for its kind, then one per value, normalised to its range.

use std::io::Write;

use flate2::Compression;
use flate2::write::GzEncoder;
use meniscus_numerics::mesh::ply::PlyMesh;

use crate::color_map::{ColorBy, ScalarRanges};
use crate::folder::Bounds;

/// Packs a mesh: its triangles, or its edges if it has no triangles, and the values with a range.
pub(crate) fn pack(mesh: &PlyMesh, ranges: &ScalarRanges) -> String {
    let raw = encode(mesh, ranges);
    let mut gzip = GzEncoder::new(Vec::new(), Compression::new(7));
    // Writing to memory does not fail; otherwise the page would show an empty mesh.
    let packed = gzip.write_all(&raw).and_then(|()| gzip.finish()).unwrap_or_default();
    base64(&packed)
}

fn encode(mesh: &PlyMesh, ranges: &ScalarRanges) -> Vec<u8> {
    let n = mesh.positions.len();
    let bounds = Bounds::of(&mesh.positions);
    let kinds = mesh.scalars.get("kind").filter(|k| k.len() == n);
    let (indices, corners): (Vec<u32>, u32) = if mesh.faces.is_empty() {
        (mesh.edges.iter().flatten().copied().collect(), 2)
    } else {
        (mesh.faces.iter().flatten().copied().collect(), 3)
    };
    let mut out = Vec::with_capacity(40 + 7 * n + 2 * indices.len());
    out.extend_from_slice(b"MESH");
    let shaded = |k: usize| Some((ColorBy::STORED[k].values(mesh)?, ranges[k].as_ref()?));
    let shaded: Vec<_> = (0..ranges.len()).map(shaded).collect();
    let bits = (0..ranges.len()).filter(|k| shaded[*k].is_some()).map(|k| 512 << k).sum::<u32>();
    let flags = corners + if kinds.is_some() { 256 } else { 0 } + bits;
    for x in [n as u32, indices.len() as u32 / corners, flags] {
        out.extend_from_slice(&x.to_le_bytes());
    }
    let (lower, size) = if n == 0 { Default::default() } else { (bounds.lower, bounds.size()) };
    for x in lower.iter().chain((lower + size).iter()) {
        out.extend_from_slice(&(*x as f32).to_le_bytes());
    }
    for a in 0..3 {
        let step = size[a] / 65535.0;
        let place = |p: &[f64; 3]| if step > 0.0 { ((p[a] - lower[a]) / step).round() as u16 } else { 0 };
        let steps = differences(mesh.positions.iter().map(place));
        out.extend(steps.iter().map(|d| *d as u8));
        out.extend(steps.iter().map(|d| (d >> 8) as u8));
    }
    let mut last = 0i64;
    for &i in &indices {
        varint(&mut out, i64::from(i) - last);
        last = i64::from(i);
    }
    out.extend(kinds.into_iter().flatten().map(|k| *k as u8));
    for (values, range) in shaded.into_iter().flatten() {
        out.extend(values.into_iter().map(|v| (255.0 * range.normalised(v)).round() as u8));
    }
    out
}

fn differences(values: impl Iterator<Item = u16>) -> Vec<u16> {
    values
        .scan(0u16, |last, x| {
            let d = x.wrapping_sub(*last);
            *last = x;
            Some(d)
        })
        .collect()
}

/// Appends a signed number as zigzag LEB128.
fn varint(out: &mut Vec<u8>, x: i64) {
    let mut z = ((x << 1) ^ (x >> 63)) as u64;
    while z >= 128 {
        out.push(z as u8 | 128);
        z >>= 7;
    }
    out.push(z as u8);
}

/// Encodes bytes as base64.
pub(crate) fn base64(bytes: &[u8]) -> String {
    const SIGNS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for group in bytes.chunks(3) {
        let at = |i: usize| u32::from(group.get(i).copied().unwrap_or(0));
        let bits = at(0) << 16 | at(1) << 8 | at(2);
        for k in 0..4 {
            let sign = char::from(SIGNS[(bits >> (18 - 6 * k)) as usize & 63]);
            text.push(if k > group.len() { '=' } else { sign });
        }
    }
    text
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::color_map::ScalarRange;
    use std::io::Read;

    fn unbase64(text: &str) -> Vec<u8> {
        let value = |c: u8| match c {
            b'A'..=b'Z' => c - b'A',
            b'a'..=b'z' => c - b'a' + 26,
            b'0'..=b'9' => c - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            _ => panic!("not base64"),
        };
        let mut out = Vec::new();
        for four in text.trim_end_matches('=').as_bytes().chunks(4) {
            let bits =
                four.iter().enumerate().fold(0u32, |b, (k, c)| b | u32::from(value(*c)) << (18 - 6 * k));
            out.extend_from_slice(&bits.to_be_bytes()[1..four.len()]);
        }
        out
    }

    /// Inverse of [`pack`], as implemented by the page.
    pub(crate) fn unpack(text: &str) -> PlyMesh {
        let mut raw = Vec::new();
        flate2::read::GzDecoder::new(&unbase64(text)[..]).read_to_end(&mut raw).unwrap();
        assert_eq!(&raw[..4], b"MESH");
        let word = |i: usize| u32::from_le_bytes(raw[i..i + 4].try_into().unwrap());
        let float = |i: usize| f64::from(f32::from_le_bytes(raw[i..i + 4].try_into().unwrap()));
        let (n, elements, corners) = (word(4) as usize, word(8) as usize, word(12) as usize & 255);
        let mut mesh = PlyMesh { positions: vec![[0.0; 3]; n], ..PlyMesh::default() };
        for a in 0..3 {
            let (low, high) = (float(16 + 4 * a), float(28 + 4 * a));
            let mut last = 0u16;
            for v in 0..n {
                let at = 40 + 2 * a * n + v;
                last = last.wrapping_add(u16::from_le_bytes([raw[at], raw[at + n]]));
                mesh.positions[v][a] = low + (high - low) * f64::from(last) / 65535.0;
            }
        }
        let (mut at, mut last, mut all) = (40 + 6 * n, 0i64, Vec::new());
        for _ in 0..elements * corners {
            let (mut z, mut shift) = (0u64, 0);
            loop {
                z |= u64::from(raw[at] & 127) << shift;
                shift += 7;
                at += 1;
                if raw[at - 1] < 128 {
                    break;
                }
            }
            last += (z >> 1) as i64 ^ -((z & 1) as i64);
            all.push(last as u32);
        }
        if corners == 3 {
            mesh.faces = all.chunks(3).map(|c| [c[0], c[1], c[2]]).collect();
        } else {
            mesh.edges = all.chunks(2).map(|c| [c[0], c[1]]).collect();
        }
        if word(12) & 256 != 0 {
            mesh.scalars.insert("kind".into(), raw[at..at + n].iter().map(|k| f64::from(*k)).collect());
            at += n;
        }
        for (_, shade) in ColorBy::STORED.into_iter().enumerate().filter(|(k, _)| word(12) & (512 << k) != 0)
        {
            let places = raw[at..at + n].iter().map(|p| f64::from(*p) / 255.0);
            mesh.scalars.insert(shade.name().into(), places.collect());
            at += n;
        }
        mesh
    }

    #[test]
    fn known_base64() {
        for (plain, text) in [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foob", "Zm9vYg==")]
        {
            assert_eq!(base64(plain.as_bytes()), text);
            assert_eq!(unbase64(text), plain.as_bytes());
        }
    }

    #[test]
    fn packed_meshes_come_back() {
        let position = |i: u32| [f64::from(i * 37 % 101) * 1e-3, -2e-3 + f64::from(i * 53 % 97) * 1e-4, 0.25];
        let mut mesh = PlyMesh { positions: (0..300).map(position).collect(), ..PlyMesh::default() };
        mesh.faces = (0..298).map(|i| [i, (i * 7) % 300, 299 - i]).collect();
        mesh.scalars.insert("kind".into(), (0..300).map(|i| f64::from(i % 3)).collect());
        let back = unpack(&pack(&mesh, &ScalarRanges::default()));
        assert_eq!(back.faces, mesh.faces);
        assert_eq!(back.scalars, mesh.scalars);
        for (p, q) in back.positions.iter().zip(&mesh.positions) {
            (0..3).for_each(|a| assert!((p[a] - q[a]).abs() < 0.1 / 65535.0 * 0.6 + 1e-7, "{p:?} {q:?}"));
        }
        mesh.scalars.insert("strain".into(), (0..300).map(f64::from).collect());
        let ranges = [None, Some(ScalarRange { low: 0.0, high: 299.0 }), None, None];
        let places = &unpack(&pack(&mesh, &ranges)).scalars["strain"];
        assert!((0..300).all(|i| (places[i] - i as f64 / 299.0).abs() < 0.6 / 255.0));
        mesh.edges = vec![[0, 5], [5, 299]];
        mesh.faces.clear();
        assert_eq!(unpack(&pack(&mesh, &ScalarRanges::default())).edges, mesh.edges);
        assert_eq!(unpack(&pack(&PlyMesh::default(), &ScalarRanges::default())).positions.len(), 0);
    }
}
